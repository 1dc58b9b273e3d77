"""`tvclin study`: the main job, one vehicle in one wind."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tvclin.base.errors import nonzero, number, positive
from tvclin.base.lines import text
from tvclin.cli.inputs import case_of, chosen
from tvclin.cli.options import (
    BOTH_LIMITS,
    DESIGN,
    GROUP,
    LIMIT_SHAPES_HELP,
    STUDY,
    AsJson,
    At,
    GainOptions,
    More,
    Options,
    Plot,
    Source,
    option,
    switch,
)
from tvclin.cli.output import answer, bar, note_below, print_answer, print_tables, say, waiting
from tvclin.cli.wind import PulseOptions
from tvclin.requirement import study_tables as tables
from tvclin.requirement.case_requirement import pulse_of
from tvclin.studyfile.assumptions import detuning_notes, loop_notes, nominal_notes
from tvclin.studyfile.findings import Findings, find
from tvclin.studyfile.questions import all_yes, questioned, questions, sufficient
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.studyfile.verdict import questions_table, sentence
from tvclin.vehicle.vehicle_file import numbers_as_written
from tvclin.winds.wind_file import gust_of

_ARCHIVE = (
    "[availability] has no least_part and is no question here; tvclin availability answers for it"
)
"""Note on an archive without a criterion."""


@dataclass(frozen=True)
class StudyWind(PulseOptions):
    """Options of a pulse with its gust; `grouped` gives them to a command."""

    azimuth_deg: float | None = option(
        "Direction of flight, in deg from north, clockwise, with wind.direction_deg: the peak is"
        " then that of the wind's vector."
    )
    gust: tuple[float, float] | None = option(
        "Gust (1 - cosine) on top of the wind: its peak and duration; more: --set gust.KEY VALUE.",
        metavar="DEG S",
    )

    def applied_to(self, plan: StudyPlan, source: str = "") -> StudyPlan:
        """Return a plan with the pulse and the gust, at the time of the largest requirement.

        A gust of the file, with its time and its speed, is replaced. `source` is not used.
        """
        plan = super().applied_to(plan, source)
        if self.gust is None:
            return plan
        peak, duration = self.gust
        radians = float(np.radians(number("--gust (peak)", peak, nonzero)))
        gust = gust_of(radians, float(number("--gust (duration)", duration, positive)))
        return replace(plan, wind=replace(pulse_of(plan), gust=gust, gust_at=None, gust_speed=None))


_GAINS = ("natural_frequency", "damping", "attitude_gain", "rate_gain")
"""Fields of `AutopilotDesign` that have an option."""


def study(
    source: Source = "configuration-i",
    time: At = None,
    winds: StudyWind = GROUP,
    question: Options = Options(STUDY, ("dead_band", "switch", "sign", "model", "plane")),
    limits: Options = BOTH_LIMITS,
    limit_shape: str | None = option(
        f"Judge both planes with one limit of this shape: {LIMIT_SHAPES_HELP} The peak that the"
        " limit survives is then that of the wind's vector; without, that of its part in"
        " --plane. Needs --set wind.direction_deg.",
        metavar="SHAPE",
    ),
    gains: GainOptions = GainOptions(DESIGN, _GAINS),
    explain: bool = switch("--explain", "Explain each symbol and each quantity in one line."),
    as_json: AsJson = False,
    plot: Plot = None,
    more: More = False,
) -> None:
    """Print the required deflection of a booster in one wind, and the verdict on its limit.

    Of a study file it answers all questions: also of the whole flight, an archive of soundings,
    dispersed vehicles and an autopilot; tvclin report shows them on a page. Options count more than
    the file. With gains or a natural frequency the autopilot is judged too; its delay, samples and
    filters are keys: --set autopilot.delay_ms 20.

    Exit code 0: every verdict is SUFFICIENT, every criterion MET and every flight SURVIVED, or no
    limit was given; 1: one is not, or is NOT KNOWN; 2: bad input.
    """

    def shaped(plan: StudyPlan) -> StudyPlan:
        """Return a plan with the limit shape of --limit-shape, if it is given."""
        shape = chosen(limit_shape, plan.nozzle.limit_shape)
        return replace(plan, nozzle=replace(plan.nozzle, limit_shape=shape))

    changes = limits.applied_to, shaped, question.applied_to, gains.applied_to
    plan = case_of(source, *changes, wind=winds.applied_to, questions=("study",), time=time)
    if plot is not None:
        from tvclin.kernels.choice import announce
        from tvclin.plots.boundaries import CURVES_SECONDS

        # estimated run time, which decides between compiled and plain code
        announce(CURVES_SECONDS)
    with bar("answers", even=False) as progress:
        # flown margins are of the page alone
        findings = find(questioned(plan), progress, omitted=("flown",))
    if plan.availability is not None and plan.availability.least_part is None:
        note_below(_ARCHIVE)
    if plot is not None:
        from tvclin.plots import save_figure, study_chart, study_planes_chart

        chart = study_planes_chart if findings.study.judges_both_planes else study_chart
        with waiting("drawing"):
            save_figure(chart(findings.study), plot)
    answer(
        as_json,
        lambda: _document(findings),
        lambda: _print(findings, source, explain, more),
        all_yes(findings),
    )


def _document(findings: Findings) -> dict[str, Any]:
    """Return the study of findings with its questions and notes, for JSON."""
    extra = {"dispersed": findings.dispersed, "turbulence": findings.turbulence}
    extra = {name: value for name, value in extra.items() if value is not None}
    all_notes = [*findings.study.notes, *_further_notes(findings)]
    answers = {"questions": questions(findings), "all_answers_yes": sufficient(findings)}
    return findings.study.as_dict() | extra | answers | {"notes": all_notes}


def _further_notes(findings: Findings) -> Iterator[str]:
    """Yield warnings of the flight, and notes on nominal pressure, detuned modes and the loop."""
    if findings.plan.sizing is not None:
        yield from findings.plan.sizing.warnings
    for notes in (nominal_notes, detuning_notes, loop_notes):
        yield from notes(findings)


def _print(findings: Findings, source: str, explain: bool, more: bool) -> None:
    """Print the verdict, the boundaries or the answers to all questions, and notes.

    `source`: name of the vehicle or study file. `explain`: whether symbols and quantities are
    explained. `more`: whether the details are printed, and all notes. With several questions their
    table is the answer, else the table of boundaries, with the required deflection below the
    verdict, and the first table of turbulence.
    """
    s, several = findings.study, len(questions(findings)) > 1
    headline, requirement = text(sentence(findings)), text(tables.requirement(s))
    archive_notes = () if findings.availability is None else findings.availability.notes
    further_notes = [*_further_notes(findings), *archive_notes]
    turbulence, unknown = findings.turbulence, findings.reasons.get("turbulence")
    if unknown and not several:
        further_notes.append(f"turbulence: {unknown}")

    print_answer(
        headline if several else f"{headline}\n{requirement}",
        questions_table(findings) if several else tables.boundaries(s),
        *([] if several or turbulence is None else turbulence.tables()[:1]),
        notes=(*further_notes, *s.notes) if several else (*s.notes, *further_notes),
        more=more,
        details=lambda: _print_details(findings, source, requirement if several else ""),
    )
    if explain:
        from tvclin.studyfile.glossary import quantity_table, symbol_table

        say("")
        print_tables(symbol_table(), quantity_table())


def _print_details(findings: Findings, source: str, wind: str) -> None:
    """Print the vehicle, its poles, dispersions and turbulence.

    `wind`: line on the required deflection, below the boundaries; empty where they are the answer.
    """
    s = findings.study
    say("")
    print_tables(tables.vehicle(s, source, numbers_as_written(source)), tables.coefficients(s))
    print_tables(tables.poles(s))
    if wind:
        print_tables(tables.boundaries(s))
        say(wind)
    say(tables.LEGEND)
    if findings.dispersed is not None:
        print_tables(*findings.dispersed.tables())
        say(findings.dispersed.spreads)
    if findings.turbulence is not None:
        print_tables(*findings.turbulence.tables())
