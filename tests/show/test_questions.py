"""Every question of a study file has its answer, and the worst one is the verdict."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tvclin.answers.findings import find
from tvclin.answers.questions import all_yes, questions, sufficient
from tvclin.cli.app import app
from tvclin.show.report import verdict

SPREAD = tv.Dispersions((tv.Dispersion("normal_force_slope", "truncated", 0.1),))
LOOSE = tv.Criteria.own("loose", aero_margin_dB=3.0)
GAINS = tv.GainsAsked(design="poles", natural_frequency=2.0, damping=0.8)


def plan_of(limit_deg: float | None, **changes: object) -> tv.StudyPlan:
    limit = None if limit_deg is None else float(np.radians(limit_deg))
    plan = tv.StudyPlan(vehicle=tv.load_vehicle("configuration-i"), limit=limit, cases=400)
    return replace(plan, **changes)


def headline(plan: tv.StudyPlan) -> str:
    line = verdict.sentence(find(plan))
    return "".join(one if isinstance(one, str) else one.text for one in line)


def answers(plan: tv.StudyPlan) -> dict[str, bool | None]:
    return {one.name: one.yes for one in questions(find(plan))}


def test_a_limit_that_covers_the_wind_alone_is_not_enough_for_a_probability() -> None:
    plan = plan_of(0.4, dispersions=SPREAD, probability=0.99)
    assert answers(plan) == {"wind": True, "probability": False}
    assert headline(plan).startswith("Not enough: 99.000 % of flights need, 90 % sure, 0.4")
    wide = plan_of(0.6, dispersions=SPREAD, probability=0.99)
    assert answers(wide) == {"wind": True, "probability": True}
    assert headline(wide).startswith("Enough")


def test_too_few_cases_are_no_yes() -> None:
    plan = plan_of(3.0, dispersions=SPREAD)  # 400 cases cannot speak of 99.865 percent
    assert answers(plan) == {"wind": True, "probability": None}
    assert sufficient(find(plan)) is None
    assert not all_yes(find(plan))
    assert headline(plan).startswith("Not shown to be enough: too few cases")


def test_an_autopilot_that_asks_for_more_than_the_limit_is_told_in_the_headline() -> None:
    plan = plan_of(0.5, gains=GAINS, criteria=LOOSE)
    asks = np.degrees(find(plan).comparison.peak_deflection)
    assert answers(plan) == {"wind": True, "autopilot": False, "margins": True}
    assert asks > 0.5
    assert f"asks for {asks:.4f} deg; the limit is 0.5000 deg" in headline(plan)
    assert answers(plan_of(1.01 * asks, gains=GAINS, criteria=LOOSE))["autopilot"] is True


def test_margins_that_are_not_met_are_no_with_or_without_a_limit() -> None:
    strict = tv.Criteria.own("strict", aero_margin_dB=60.0)
    for limit in (3.0, None):
        plan = plan_of(limit, gains=GAINS, criteria=strict)
        assert answers(plan)["margins"] is False
        assert sufficient(find(plan)) is False
        assert "does not meet the criteria strict" in headline(plan)
    assert sufficient(find(plan_of(None, gains=GAINS, criteria=LOOSE))) is None


def test_what_has_no_answer_is_no_yes() -> None:
    stable = tv.load_vehicle("configuration-i").replace(aerodynamic_arm=-2.0)
    plan = plan_of(0.4, vehicle=stable, gains=tv.GainsAsked(), criteria=LOOSE)
    assert answers(plan) == {"wind": True, "autopilot": None, "margins": None}
    assert headline(plan).startswith("Not shown to be enough: ")


@pytest.mark.parametrize(("limit", "code"), [(0.3, 1), (0.4, 1), (0.6, 0)])
def test_study_and_report_exit_alike(tmp_path, limit: float, code: int) -> None:
    file = tmp_path / "s.toml"
    file.write_text(
        "[study]\nvehicle = 'configuration-i'\n[wind]\npeak_deg = 5\nduration_s = 7.5\n"
        f"[question]\nlimit_deg = {limit}\n"
        "probability = 0.99\n[campaign]\ncases = 400\n[[dispersion]]\n"
        "parameter = 'normal_force_slope'\nshape = 'truncated'\npercent = 10\n"
    )
    page = ["report", str(file), "-o", str(tmp_path / "r.html")]
    for command in (["study", str(file)], ["study", str(file), "--json"], page):
        result = CliRunner().invoke(app, command)
        assert result.exit_code == code, result.output
        if "--json" in command:
            document = json.loads(result.stdout)
            assert document["sufficient"] is (code == 0)
            assert [one["name"] for one in document["questions"]] == ["wind", "probability"]
