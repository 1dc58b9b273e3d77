"""`tvclin study`: the main job, one vehicle in one wind."""

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from tvclin.base.errors import nonzero, number, positive
from tvclin.cli.inputs import case_of, changed
from tvclin.cli.options import (
    GROUP,
    LIMIT,
    LIMIT_SHAPES_HELP,
    STUDY,
    AsJson,
    At,
    Given,
    Plot,
    Source,
    asked,
    switch,
)
from tvclin.cli.output import answer, print_tables, say, say_lines, say_notes
from tvclin.cli.progress import bar, waiting
from tvclin.cli.wind import ShapedOptions
from tvclin.requirement import study_tables as tables
from tvclin.requirement.case_requirement import pulse_of
from tvclin.studyfile.findings import Findings, find
from tvclin.studyfile.questions import (
    all_yes,
    loop_notes,
    nominal_notes,
    overall,
    questioned,
    questions,
    sufficient,
)
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.vehicle_file import numbers_as_written
from tvclin.winds.wind_file import gust_of


@dataclass(frozen=True)
class StudyWind(ShapedOptions):
    """Options of a pulse with its gust; `grouped` gives them to a command."""

    gust: tuple[float, float] | None = asked(
        "Gust (1 - cosine) on top of the wind: its peak and duration; more: --set gust.KEY VALUE.",
        metavar="DEG S",
    )

    def over(self, plan: StudyPlan, source: str = "") -> StudyPlan:
        """Return a plan with the pulse and the gust, at the time of the largest requirement."""
        plan = super().over(plan, source)
        if self.gust is None:
            return plan
        peak, duration = self.gust
        radians = float(np.radians(number("--gust", peak, nonzero)))
        gust = gust_of(radians, float(number("--gust", duration, positive)))
        return replace(plan, wind=replace(pulse_of(plan), gust=gust, gust_at=None, gust_speed=None))


def _with_limit_shape(limit_shape: str | None, plan: StudyPlan) -> StudyPlan:
    """Return a plan with the limit shape of --limit-shape."""
    return replace(plan, nozzle=changed(plan.nozzle, limit_shape=limit_shape))


def study(
    source: Source = "configuration-i",
    time: At = None,
    winds: StudyWind = GROUP,
    question: Given = Given(STUDY, ("dead_band", "switch", "sign", "model", "plane")),
    limit: Given = LIMIT,
    limit_shape: str | None = asked(
        f"Judge both planes with one limit of this shape: {LIMIT_SHAPES_HELP} The peak that the"
        " limit survives is then that of the wind's vector; without, that of its part in"
        " --plane. Needs --set wind.direction_deg.",
        metavar="SHAPE",
    ),
    explain: bool = switch("--explain", "Explain each symbol and each quantity in one line."),
    as_json: AsJson = False,
    plot: Plot = None,
) -> None:
    """Print the required deflection of a booster in a wind, and the verdict on its limit.

    A study file may also ask about the whole flight, an archive of soundings, dispersed vehicles
    and an autopilot. Options count more than the file.

    Exit code 0: every verdict is SUFFICIENT, every criterion MET and every flight SURVIVED, or no
    limit was given; 1: one is not, or is NOT KNOWN; 2: bad input.
    """
    changes = limit.over, partial(_with_limit_shape, limit_shape), question.over
    plan = case_of(source, *changes, wind=winds.over, told=("study",), time=time)
    with bar("answers") as progress:
        findings = find(questioned(plan), progress)
    if plot is not None:
        from tvclin.plots import save_figure, study_chart, study_planes_chart

        chart = study_planes_chart if findings.study.judges_both_planes else study_chart
        with waiting("drawing"):
            save_figure(chart(findings.study), plot)
    answer(
        as_json,
        lambda: _document(findings),
        lambda: _print(findings, source, explain),
        all_yes(findings),
    )


def _document(findings: Findings) -> dict[str, Any]:
    """Return the study with its questions and notes, for JSON."""
    extra = {} if findings.dispersed is None else {"dispersed": findings.dispersed}
    said = [*findings.study.notes, *nominal_notes(findings), *loop_notes(findings)]
    answers = {"questions": questions(findings), "all_answers_yes": sufficient(findings)}
    return findings.study.as_dict() | extra | answers | {"notes": said}


def _print(findings: Findings, source: str, explain: bool) -> None:
    """Print the vehicle, the boundaries and the verdict, and the answers to further questions."""
    s, d = findings.study, findings.dispersed
    print_tables(tables.vehicle(s, source, numbers_as_written(source)), tables.coefficients(s))
    print_tables(tables.poles(s), tables.boundaries(s))
    say_lines(tables.verdict(s))
    say(tables.LEGEND)
    say_notes(s.notes)
    if explain:
        from tvclin.studyfile.glossary import quantity_table, symbol_table

        say("")
        print_tables(symbol_table(), quantity_table())
    if d is not None:
        say("")
        print_tables(*d.tables())
        say(d.spreads)
    _print_questions(findings)


def _print_questions(findings: Findings) -> None:
    """Print all questions with the verdict, where there are several, and the notes on them."""
    asked_questions = questions(findings)
    if len(asked_questions) < 2:
        say_notes(loop_notes(findings))
        return
    from tvclin.studyfile.questions import questions_table

    say("")
    print_tables(questions_table(findings))
    say(f"Verdict: {overall(findings)}")
    days = () if findings.availability is None else findings.availability.notes
    say_notes((*nominal_notes(findings), *loop_notes(findings), *days))
