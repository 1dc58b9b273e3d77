"""The laws by name: the same everywhere, and named wherever one can be chosen."""

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tvclin.cli.app import app
from tvclin.control.laws.registry import LAWS
from tvclin.ensembles.campaign.cases import batch, draw_cases
from tvclin.ensembles.campaign.outputs import law_of
from tvclin.studyfile.campaign_file import template
from tvclin.studyfile.read import example

PLANT = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
PEAK = 0.08


@pytest.mark.parametrize("name", LAWS)
def test_a_law_is_the_same_in_trials_and_in_campaigns(name):
    plan = tv.Campaign(
        vehicle=tv.load_vehicle("configuration-i"),
        wind=tv.ShapedWind("triangular", PEAK, 7.5),
        nozzle=tv.Nozzle(limit=0.01),
        outputs=("flight",),
        law=name,
        cases=2,
    )
    law = tv.control.design_law(name, PLANT, PEAK)
    assert law.numbers is not None  # the compiled flights know it
    flown = law_of(plan, batch(plan, draw_cases(plan, 0, 1)))
    assert law.numbers == flown.numbers == tv.design.standard_laws(PLANT, PEAK)[name].numbers


@pytest.mark.parametrize("name", ["trim", "dead-band"])
def test_trim_holds_the_attitude_and_lets_no_path_creep_away(name):
    """Linear near rest: delta = B alpha + gains of attitude and rate, about the drifting plant."""
    numbers = tv.control.design_law(name, PLANT, PEAK).numbers
    A, inputs, C, D = PLANT.matrices()
    alpha, through = C[3], D[3]
    assert through[0] == 0.0

    def growth(one):
        own = np.array([one.attitude, one.attitude_rate, one.flight_path_angle])
        gains = one.angle_of_attack * alpha[:3] + own
        return np.linalg.eigvals(A + np.outer(inputs[:, 0], gains)).real.max()

    assert growth(numbers) < 0.0
    assert growth(tv.TrimLaw(PLANT).numbers) == pytest.approx(0.0129, abs=5e-4)


def test_a_law_takes_its_own_and_nothing_else():
    autopilot = tv.Autopilot(attitude_gain=0.4, rate_gain=0.5, integral_gain=0.1)
    law = tv.control.design_law("autopilot", PLANT, PEAK, autopilot=autopilot)
    assert law == tv.SaturatedLaw(autopilot)
    assert tv.design.standard_laws(PLANT, PEAK, autopilot)["autopilot"] == law
    for name, own in (("trim", {"dead_band": 0.5}), ("dead-band", {"autopilot": autopilot})):
        with pytest.raises(tv.InputError, match=f"is not of the law {name}; leave it out"):
            tv.control.design_law(name, PLANT, PEAK, **own)
    with pytest.raises(tv.InputError, match="law must be one of autopilot, trim"):
        tv.control.design_law("bang-bang", PLANT, PEAK)


def test_every_law_is_named_wherever_it_can_be_asked_for():
    help_of_fly = " ".join(
        CliRunner().invoke(app, ["fly", "--help"], terminal_width=200).output.split()
    )
    for name in LAWS:
        assert name in help_of_fly.replace("- ", "-")
        assert name in example()
        assert name in template()
