"""Study files that name a plant and a controller in state space."""

import json

import control
import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tvclin.cli.app import app
from tvclin.ensembles.campaign.cases import evaluate
from tvclin.ensembles.campaign.folder import read, written
from tvclin.requirement.autopilot_requirement import at_peak_pressure
from tvclin.studyfile.campaign_file import load_campaign
from tvclin.studyfile.findings import find
from tvclin.studyfile.questions import questions
from tvclin.studyfile.settings import with_settings

STUDY = """
[study]
vehicle = "configuration-i"
[wind]
peak_deg = 5
duration_s = 7.5
[nozzle]
limit_deg = 1.5
[autopilot]
delay_ms = 20
"""
GAINS = "attitude_gain = 0.3\nrate_gain_s = 0.5\nsample_rate_Hz = 50\n"
PLANT, CONTROLLER = '[plant]\nsystem = "plant.mat"\n', '[controller]\nsystem = "law.npz"\n'


@pytest.fixture
def folder(tmp_path):
    """Return a folder with the files of a plant and a controller."""
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    tv.linear.write_system(plant.ss(), tmp_path / "plant.mat")
    law = control.StateSpace(
        [], [], [], [[0.3, 0.5]], 0.02, inputs=["attitude", "attitude_rate"], outputs=["u"]
    )
    tv.linear.write_system(law, tmp_path / "law.npz")
    return tmp_path


def _plan(folder, text):
    (folder / "study.toml").write_text(text)
    return tv.load_study(folder / "study.toml")


def test_a_study_with_a_plant_and_a_controller_has_the_margins_of_its_gains(folder):
    gains = _plan(folder, STUDY + GAINS)
    systems = _plan(folder, STUDY + PLANT + CONTROLLER)
    assert systems.hardware["sample_rate"] == gains.hardware["sample_rate"] == 50.0
    one, other = (plan.autopilot.margins(plan.plant) for plan in (gains, systems))
    for name in ("aero_margin_dB", "phase_margin_deg", "delay_margin"):
        assert getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-9)
    law = tv.SaturatedLaw.of(systems.autopilot)
    assert isinstance(law, tv.control.SystemLaw)
    limit = 1.05 * gains.nozzle.limit
    flown = [
        tv.fly_many(
            p.plant,
            tv.SaturatedLaw.of(p.autopilot),
            p.history,
            deflection_limit=limit,
            **p.hardware,
        )
        for p in (gains, systems)
    ]
    assert flown[1].peak_attitude == pytest.approx(flown[0].peak_attitude, rel=1e-9)


def test_a_plant_in_state_space_is_not_known_at_another_dynamic_pressure(folder):
    plan = _plan(folder, STUDY + PLANT)
    with pytest.raises(tv.InputError, match="at nominal dynamic pressure alone"):
        at_peak_pressure(plan, None)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (STUDY + '[plant]\nsystem = "none.mat"\n', "none.mat does not exist"),
        (STUDY + "[plant]\n", "a key is missing in .plant.: system"),
        (STUDY + '[plant]\nsystem = "law.npz"\n', "must be continuous|has no input deflection"),
        (STUDY + '[controller]\nsytem = "law.npz"\n', "system"),
        (STUDY + GAINS + CONTROLLER, "a controller has its own gains"),
        (STUDY + "sample_rate_Hz = 25\n" + CONTROLLER, "that of the controller, 50 Hz"),
    ],
)
def test_a_bad_system_in_a_study_is_refused_in_one_sentence(folder, text, message):
    def margins():
        plan = _plan(folder, text)
        return plan.autopilot.margins(plan.plant)

    with pytest.raises(tv.InputError, match=message):
        margins()


@pytest.mark.parametrize("key", ["plant", "plant.system"])
def test_a_plant_is_taken_out_of_a_study_by_its_table_or_its_only_key(folder, key):
    _plan(folder, STUDY + PLANT + CONTROLLER)
    source = with_settings(str(folder / "study.toml"), [(key, "none")])
    plan = tv.load_study(source)
    assert plan.plant_system is None
    assert plan.controller is not None


CAMPAIGN = """
[campaign]
vehicle = "VEHICLE"
cases = 6
[wind]
peak_deg = 5
duration_s = 7.5
[nozzle]
limit_deg = 1.5
[outputs]
names = ["margins", "flight"]
[[dispersion]]
parameter = "aerodynamic_arm"
percent = 20
[autopilot]
delay_ms = 20
"""


def _campaign(folder, text, vehicle="configuration-i"):
    (folder / "campaign.toml").write_text(CAMPAIGN.replace("VEHICLE", vehicle) + text)
    return load_campaign(folder / "campaign.toml")


@pytest.mark.thorough
@pytest.mark.parametrize(
    "vehicle", ["configuration-i", pytest.param("made-up-launcher", marks=pytest.mark.thorough)]
)
def test_cases_around_a_controller_in_steps_are_those_around_its_gains(folder, vehicle):
    gains, steps = (
        evaluate(_campaign(folder, text, vehicle), 0, 6) for text in (GAINS, CONTROLLER)
    )
    assert gains.keys() == steps.keys()
    assert steps["margin_stable"].any()
    for name in set(gains) - {"status"}:
        np.testing.assert_allclose(steps[name], gains[name], rtol=1e-9, err_msg=name)


@pytest.mark.parametrize("period", [None, 0.02])
def test_a_manifest_holds_a_controller_to_the_last_bit(folder, period):
    states = control.StateSpace([[-0.1]], [[1 / 3, 0.1]], [[0.7]], [[0.3, 0.5]], period or 0)
    static = control.StateSpace([], [], [], [[0.3, 0.5]], period or 0)
    for system in (states, static):
        system.input_labels = ["attitude", "attitude_rate"]
        tv.linear.write_system(system, folder / "law.npz")
        campaign = _campaign(folder, CONTROLLER)
        read_again = read(json.loads(json.dumps(written(campaign))))
        for matrix, other in zip(
            campaign.controller.matrices(), read_again.controller.matrices(), strict=True
        ):
            np.testing.assert_array_equal(matrix, other, strict=True)
        assert read_again.hardware == campaign.hardware
        assert read_again.controller.inputs == ("attitude", "attitude_rate")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (PLANT, "whose matrices are one vehicle; leave the table out"),
        (
            CONTROLLER + '[[dispersion]]\nparameter = "rate_gain"\npercent = 5\n',
            "rate_gain is dispersed, but has no nominal value",
        ),
        (CONTROLLER.replace("law.npz", "slosh.npz"), "a flight does not measure slosh"),
    ],
)
def test_a_campaign_refuses_what_it_cannot_disperse_or_fly(folder, text, message):
    law = control.StateSpace([], [], [], [[0.3]], inputs=["slosh"], outputs=["u"])
    tv.linear.write_system(law, folder / "slosh.npz")
    with pytest.raises(tv.InputError, match=message):
        _campaign(folder, text)


@pytest.mark.thorough
def test_the_requirement_of_a_plant_in_a_head_wind_is_not_known(folder):
    systems, gains = (
        {q.name: q for q in questions(find(_plan(folder, STUDY + text)))}["autopilot"]
        for text in (PLANT + CONTROLLER, CONTROLLER)
    )
    assert gains.yes is True
    assert systems.yes is None
    assert "not known with the dynamic pressure at the peak of a head wind" in systems.line[0]


def test_commands_take_a_controller_in_steps_or_say_who_does(folder, monkeypatch):
    monkeypatch.chdir(folder)
    wind = "[wind]\npeak_deg = 5\nduration_s = 7.5\n[nozzle]\nlimit_deg = 1.5\n"
    (folder / "steps.toml").write_text(f'[study]\nvehicle = "configuration-i"\n{wind}{CONTROLLER}')
    flown = CliRunner().invoke(app, ["fly", "steps.toml", "--law", "autopilot"])
    assert flown.exit_code == 0, flown.output
    assert "Limit 1.5 deg: SUFFICIENT" in flown.stdout
    refused = CliRunner().invoke(app, ["design", "steps.toml"])
    assert refused.exit_code == 2
    assert "tvclin margins judges that" in " ".join(refused.stderr.split())
