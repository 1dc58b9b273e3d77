"""The head of the page: which assumptions hold, and how many are doubtful."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import tvclin as tv
from tests.flexible import PHASED
from tests.show.pages import section
from tests.turns import usual
from tvclin.base.lines import Number, text
from tvclin.studyfile import verdict
from tvclin.studyfile.assumptions import assumptions, detuning_notes, study_warnings
from tvclin.studyfile.findings import Findings, find

HEADER = re.compile(r"<header.*?</header>", re.DOTALL)


def findings(more: str, tmp_path, peak: float = 5.0, limit: float = 0.4) -> Findings:
    """The findings of configuration I in a triangle of 5 s."""
    (tmp_path / "s.toml").write_text(
        f'[study]\nvehicle = "configuration-i"\nmodel = "fixed-path"\n'
        f'[wind]\nshape = "triangular"\npeak_deg = {peak}\nduration_s = 5\n'
        f"[nozzle]\nlimit_deg = {limit}\n{more}"
    )
    return find(tv.load_study(tmp_path / "s.toml"))


def check_of(answers: Findings, begin: str):
    return next(
        assumption for assumption in assumptions(answers) if text(assumption.line).startswith(begin)
    )


@pytest.mark.thorough
@pytest.mark.parametrize("duration", usual([5.0, 30.0], 1))
def test_a_vehicle_that_changes_by_more_than_a_tenth_is_not_marked_as_frozen(
    duration, tmp_path
) -> None:
    """Its own sentence says by how many percent beta or B changes while the wind blows."""
    answers = findings("[size]\nfrom_s = 66\nto_s = 66\n", tmp_path)
    plan = replace(answers.plan, wind=replace(answers.plan.wind, duration=duration))
    check = check_of(find(plan), "Mass, thrust, air and speed stay as they are")
    percent = next(one for one in check.line if isinstance(one, Number)).value
    assert (percent > 10.0) is (duration > 10.0)
    assert check.state == ("doubt" if percent > 10.0 else "ok")


@pytest.mark.parametrize(("rate", "state"), usual([(20.0, "ok"), (0.2, "doubt")], 1))
def test_a_rate_that_theory_or_autopilot_exceeds_is_not_marked_as_holding(
    rate, state, tmp_path
) -> None:
    answers = findings(f"rate_limit_deg_per_s = {rate}\n[autopilot]\n", tmp_path, limit=2.0)
    assert check_of(answers, "The boundary does not count the rate limit").state == state


@pytest.mark.thorough
def test_a_mode_that_is_unstable_near_its_frequency_is_a_doubtful_assumption(tmp_path) -> None:
    """A mode at 0.95 of the notch is unstable at 1.126 of its frequency, at the notch at 1.069."""
    answers = findings("", tmp_path)
    words = "The frequencies of modes are those of the vehicle file"
    assert not any(text(assumption.line).startswith(words) for assumption in assumptions(answers))
    unstable = "bending 1 is unstable at 1.069 of its frequency"
    for factor, state, notes in (
        (0.95, "ok", []),
        (1.0, "doubt", [f"{unstable}; tvclin margins --detuned shows the margins"]),
    ):
        moved = PHASED.replace("frequency_Hz = 2.5", f"frequency_Hz = {2.5 * factor}")
        (tmp_path / "phased.toml").write_text(moved)
        plant = tv.linear.plant_of(tv.load_vehicle(tmp_path / "phased.toml"), "drift-exact")
        autopilot = replace(
            tv.design_gains(plant.rigid, natural_frequency=1.3, damping=0.7),
            filters=(tv.vehicle.Filter.notch(5.0 * np.pi, 0.05, 0.5),),
            delay=0.05,
            actuator=tv.Actuator(),
        )
        detuned = tv.control.detuned(autopilot, plant)
        flexible = SimpleNamespace(bands=autopilot.band_margins(plant), detuned=detuned)
        with_modes = replace(answers, flexible=flexible)
        check = check_of(with_modes, words)
        assert check.state == state
        assert (f"{words}, but {unstable}." == text(check.line)) is (state == "doubt")
        assert list(detuning_notes(with_modes)) == notes


@pytest.mark.thorough
def test_the_head_counts_its_doubtful_assumptions_and_the_notes_below(tmp_path) -> None:
    answers = findings("[size]\nfrom_s = 66\nto_s = 66\n", tmp_path, peak=12.0)
    page = tv.report_html(answers.plan)
    head = HEADER.search(page)[0]
    marked, all_marked = (one.count('<li class="doubt">') for one in (head, page))
    every = head.count("<li class=")
    assert f"{marked} of these {every} assumptions" in head
    assert marked >= 1
    more = all_marked - marked
    assert more == 0 or f"{more} more warning" in head


def test_a_page_does_not_judge_a_wind_of_60_degrees(tmp_path) -> None:
    answers = findings("", tmp_path, peak=60.0, limit=12.0)
    sentence = "wind meets the flight at 60 deg, and above 30 deg linear aerodynamics says nothing"
    assert sentence in text(verdict.sentence(answers))
    assert check_of(answers, "Forces are linear").state == "doubt"
    assert dict(verdict.facts(answers))[verdict.SURVIVES][0] == "≥ "
    assert not section(answers, "boundaries").attributes("svg")
    assert any(sentence in note for note in study_warnings(answers))


@pytest.mark.thorough
def test_the_panel_does_not_judge_a_wind_of_60_degrees() -> None:
    from tvclin.show.explorer.answer import answer
    from tvclin.show.explorer.choices import Choices

    wind = tv.winds.ShapedWind("triangular", float(np.radians(60.0)), 7.5)
    plan = tv.studyfile.StudyPlan(
        vehicle=tv.load_vehicle("configuration-i"), wind=wind, nozzle=tv.Nozzle(limit=0.2)
    )
    said = answer(Choices(plan=plan, law="trim"), 4).verdict
    assert said.startswith("NOT KNOWN: the wind meets the flight at 60 deg")
    assert "the vehicle is not known to survive" in said
