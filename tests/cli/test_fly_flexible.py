"""`tvclin fly` of a vehicle that bends and sloshes: flights of the library, beside the rigid."""

import json
import re
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.flexible import MODE_AND_TANK
from tests.turns import usual
from tvclin.cli.app import app
from tvclin.vehicle.vehicle_file import read_vehicle_text

mpl.use("Agg")

GAINS = ("--natural-frequency", "1.5", "--delay-ms", "10")
NOTCH = (
    "--set",
    'autopilot.filter=[{kind="notch", frequency_Hz=12, zero_damping=0.05, pole_damping=0.5}]',
)
RIGID = ("--set", "study.rigid=true")
WIND = tv.TriangularWind(peak=np.radians(5), duration=7.5)
NOZZLE = {"actuator": tv.Actuator(), "sample_rate": 100.0, "delay": 0.01}


@pytest.fixture
def mine(tmp_path: Path) -> str:
    """Return a file of configuration I with a mode and a tank."""
    path = tmp_path / "my.toml"
    path.write_text(read_vehicle_text("configuration-i")[0] + MODE_AND_TANK)
    return str(path)


def run(*arguments):
    return CliRunner().invoke(app, ["fly", *map(str, arguments)])


def plant_of(source):
    return tv.linear.plant_of(tv.load_vehicle(source))


def law_of(plant, *filters):
    gains = tv.design_gains(plant.coefficients, natural_frequency=1.5, damping=0.7, filters=filters)
    return tv.SaturatedLaw(gains)


@pytest.mark.thorough
def test_the_flexible_vehicle_flies_with_limits_beside_the_rigid_one(mine, tmp_path):
    curves = tmp_path / "flown.csv"
    rate = ("--set", "nozzle.rate_limit_deg_per_s=1.2")
    more = ("--limit-deg", 0.45, *rate, "--csv", curves, "--json")
    result = run(mine, *GAINS, *NOTCH, *more)
    document, plant = json.loads(result.stdout), plant_of(mine)
    # in a head wind, at the dynamic pressure of its peak, the autopilot requires more
    assert (result.exit_code, document["survived"], document["sufficient"]) == (1, True, None)
    law = law_of(plant, tv.vehicle.Filter.notch(24 * np.pi, 0.05, 0.5))
    nozzle = NOZZLE | {"deflection_limit": np.radians(0.45), "rate_limit": np.radians(1.2)}
    many = {
        "flown": tv.fly_many(plant, law, WIND, **nozzle),
        "rigid": tv.fly_many(plant.rigid, law, WIND, **nozzle),
    }
    assert document["flexible"]
    for name, one in many.items():
        assert document["status"][name] == one.status == "survived"
        rate = document["peak_deflection_rate_deg_s"][name]
        assert np.radians(rate) == pytest.approx(one.peak_deflection_rate, rel=1e-12)
        peak = document["peaks_over_the_wind_deg"]["attitude"][name]
        # Of 401 samples in 15 s, and of the flight at 100 Hz.
        assert np.radians(peak) == pytest.approx(one.peak_attitude, rel=2e-3)
    assert curves.read_text().splitlines()[1].startswith("time")
    assert "rigid" in curves.read_text()


@pytest.mark.thorough
def test_without_a_limit_the_flight_has_a_tenth_more_than_the_boundary_of_the_law(mine):
    document = json.loads(run(mine, *GAINS, *NOTCH, "--json").stdout)
    plant = plant_of(mine)
    law = law_of(plant, tv.vehicle.Filter.notch(24 * np.pi, 0.05, 0.5))
    for name, one in (("flown", plant), ("rigid", plant.rigid)):
        boundary = tv.closed_loop_boundary(one, law, WIND, highest=4.0, **NOZZLE)
        minimum = abs(np.degrees(boundary.deflection))
        assert document["boundary_deg"][name] == pytest.approx(minimum, rel=1e-12)
    assert document["limit_deg"] == pytest.approx(1.1 * document["boundary_deg"]["flown"])


def test_a_mode_that_is_not_held_rings_and_has_not_survived(mine):
    result = run(mine, *GAINS, "--limit-deg", 0.45)
    assert result.exit_code == 1
    verdict = (
        "NOT SURVIVED, limit cycle with 0.450 deg at nominal dynamic pressure, vehicle frozen;"
        " rigid: SURVIVED"
    )
    assert verdict in " ".join(result.output.split())
    more = run(mine, *GAINS, "--limit-deg", 0.45, "--more").output
    assert "Flexible vehicle (--set study.rigid true: without): 1 bending mode, 1 tank" in more
    assert more.count("Flexible vehicle (") == 1
    without = run(mine, *GAINS)
    assert without.exit_code == 1
    assert without.stdout.startswith("Autopilot requirement: NOT KNOWN, the closed loop is unst")


@pytest.mark.thorough
def test_margins_that_are_flown_are_those_of_the_flexible_vehicle(mine):
    arguments = ("margins", mine, *GAINS, *NOTCH, "--limit-deg", "0.5", "--json")
    result = CliRunner().invoke(app, list(arguments))
    assert not result.stderr
    plant = plant_of(mine)
    law = law_of(plant, tv.vehicle.Filter.notch(24 * np.pi, 0.05, 0.5))
    expected = tv.flights.flown_margins(plant, law, WIND, limit=np.radians(0.5), **NOZZLE)
    computed = json.loads(result.stdout)["flown"]
    for name in ("gain_rise", "effectiveness_fall"):
        assert computed[name]["value"] == pytest.approx(getattr(expected, name).value, rel=1e-12)


@pytest.mark.thorough
def test_rigid_and_the_nonlinear_engines_leave_the_structure_out(mine):
    beside = json.loads(run(mine, *GAINS, *NOTCH, "--limit-deg", 0.45, "--json").stdout)
    more = ("--engine", "linear", *RIGID, "--limit-deg", 0.45, "--json")
    single = json.loads(run(mine, *GAINS, *NOTCH, *more).stdout)
    assert not single["flexible"]
    peaks = beside["peaks_over_the_wind_deg"]["attitude"]
    assert single["peaks_over_the_wind_deg"]["attitude"]["flown"] == peaks["rigid"]
    planar = run(mine, "--engine", "planar")
    assert planar.exit_code == 0
    assert re.search(r"of the rigid vehicle, without the structure .* fast pole by", planar.stderr)
    quiet = run(mine, *RIGID)
    assert quiet.stdout == planar.stdout == run("configuration-i").stdout
    assert not quiet.stderr


@pytest.mark.parametrize("law", usual(["trim", "dead-band", "recoverable-attitude"], 2))
def test_every_law_flies_a_flexible_vehicle_with_filters(mine, law):
    result = run(mine, "--law", law, *NOTCH, "--limit-deg", 0.6, "--json")
    document, plant = json.loads(result.stdout), plant_of(mine)
    chosen = tv.design.standard_laws(plant.rigid, np.radians(5))[law]
    filtered = tv.control.FilteredLaw(
        chosen, filters=(tv.vehicle.Filter.notch(24 * np.pi, 0.05, 0.5),)
    )
    nozzle = NOZZLE | {"delay": 0.0, "deflection_limit": np.radians(0.6)}
    assert document["status"]["flown"] == tv.fly_many(plant, filtered, WIND, **nozzle).status


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--law", "report"), "--law report has no actuator and no samples"),
        (("--engine", "planar", "--model", "drift"), "--model needs --engine linear"),
        (("--engine", "planar", "--sample-rate", "50"), "--sample-rate needs --engine linear"),
        (("--law", "trim", "--natural-frequency", "2"), "--natural-frequency needs --law auto"),
        (("--sample-rate", "0"), "--sample-rate must be"),
        (
            ("--set", "nozzle.rate_limit_deg_per_s", "-1"),
            "rate_limit_deg_per_s in [nozzle] must be positive; got -1",
        ),
        (("--set", "nozzle.actuator_frequency_rad_per_s=0"), "second order"),
        (("--engine", "euler"), "--engine"),
    ],
)
def test_what_does_not_go_together_is_one_sentence(arguments, message):
    result = run("made-up-booster", "--limit-deg", "2", *arguments)
    assert result.exit_code == 2, result.output
    assert message in result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.thorough
def test_the_figure_has_the_rigid_vehicle_beside_the_flexible_one(mine, tmp_path):
    picture = tmp_path / "flown.svg"
    assert run(mine, *GAINS, *NOTCH, "--limit-deg", 0.6, "--plot", picture).exit_code == 0
    assert picture.stat().st_size > 10_000


@pytest.mark.thorough
def test_laws_fly_the_flexible_vehicle_with_an_actuator(mine, monkeypatch):
    every = tv.design.standard_laws
    monkeypatch.setattr(
        "tvclin.cli.fly.standard_laws",
        lambda plant, peak, *_: {"trim": every(plant, peak)["trim"]},
    )
    arguments = (
        "fly",
        mine,
        "--law",
        "all",
        "--wind",
        "triangular",
        *NOTCH,
        "--delay-ms",
        "10",
        "--json",
    )
    document = json.loads(CliRunner().invoke(app, list(arguments)).stdout)
    plant = plant_of(mine)
    law = tv.control.FilteredLaw(
        tv.design.standard_laws(plant.rigid, np.radians(5))["trim"],
        filters=(tv.vehicle.Filter.notch(24 * np.pi, 0.05, 0.5),),
    )
    expected = tv.closed_loop_boundary(plant, law, WIND, highest=4.0, **NOZZLE)
    (trim,) = [trial for trial in document["trials"] if trial["law"] == "trim"]
    assert document["flexible"]
    assert trim["limit"] == pytest.approx(expected.limit, rel=1e-12)
    assert trim["status"] == expected.status == "ok"
    drawn = CliRunner().invoke(app, [*arguments[:4], "--plot", "laws.png", "--winds", "x.csv"])
    assert drawn.exit_code == 2
    assert "--winds needs no --plot: that is drawn of pulses alone" in drawn.stderr
