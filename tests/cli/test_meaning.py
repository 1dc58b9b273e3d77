"""An option of a command changes the answer or is refused."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.turns import usual
from tvclin.cli.app import app

FAST = ("--limit-deg", "2", "--json")


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.mark.parametrize("law", usual(["trim", "autopilot"], 0))
def test_a_flight_has_the_actuator_of_its_options_in_either_unit(law):
    given = ("fly", "configuration-i", "--engine", "linear", "--law", law, *FAST)
    hertz, radians, usual = (
        json.loads(run(*given, *more).stdout)
        for more in (
            ("--set", "nozzle.actuator_frequency_Hz=1.5"),
            ("--set", "nozzle.actuator_frequency_rad_per_s", 2 * np.pi * 1.5),
            (),
        )
    )
    assert hertz == radians
    assert hertz["peaks_over_the_wind_deg"] != usual["peaks_over_the_wind_deg"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("margins", "--wind", "rectangular"), "--wind needs --limit-deg"),
        (("margins", "--peak-deg", 3), "--peak-deg needs --limit-deg"),
        (("margins", "--duration", 3), "--duration needs --limit-deg"),
        (("ascent", "--set", "sounding.window_s=20"), "[sounding] needs a sounding"),
        # one of several options of nearly one name
        (("study", "--peak-deg", 0), "--peak-deg must be other than zero; got 0 deg"),
        (("study", "--peak-speed", 0), "--peak-speed must be other than zero; got 0 m/s"),
        (("ascent", "--peak-speed", 0), "--peak-speed must be other than zero; got 0 m/s"),
        (
            ("design", "--set", "nozzle.actuator_damping=-1"),
            "damping must be positive; got -1",
        ),
    ],
)
def test_what_has_no_meaning_is_refused(arguments, words):
    command, *rest = arguments
    result = run(command, "configuration-i", *rest)
    assert (result.exit_code, words in result.output) == (2, True), result.output


@pytest.mark.thorough
def test_the_wind_gain_of_a_vehicle_that_bends_is_that_of_a_dense_sweep():
    plant = tv.linear.plant_of(tv.load_vehicle("made-up-launcher"))
    autopilot = tv.design_gains(
        plant.coefficients, natural_frequency=1.2, damping=0.7, actuator=tv.Actuator()
    )
    wind = tv.TriangularWind(peak=0.05, duration=6.0)
    result = tv.compare_with_trim(plant, autopilot, wind)
    loop = autopilot.close(plant)["deflection", "wind"]
    omega = np.concatenate([np.geomspace(1e-3, 300.0, 40_000), np.linspace(30.0, 40.0, 40_000)])
    assert result.wind_gain == pytest.approx(np.abs(loop(1j * omega)).max(), rel=1e-4)
    assert result.margins.gain_increase_dB == autopilot.margins(plant).gain_increase_dB
