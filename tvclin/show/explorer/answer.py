"""All numbers for the choices, and the verdict, after any number of steps: pure."""

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, replace

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.quantities import NOMINAL, sufficiency
from tvclin.case.parts import told
from tvclin.control.margins.margins import Margins
from tvclin.flights.theory_comparison import OUTCOME_WORDS
from tvclin.kernels.choice import compiling_nothing
from tvclin.requirement.case_requirement import CaseRequirement
from tvclin.requirement.nominal_requirement import covers
from tvclin.requirement.plane_requirement import direction_notes
from tvclin.requirement.study import along_the_path, doubts, gust_placed
from tvclin.show.explorer import parts
from tvclin.show.explorer.choices import REPORT, Choices
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.winds.wind_angles import linear_notes

_HELD = (
    "the report's control holds the limit for ever, and a limit above the boundary then turns"
    " the vehicle over to the other side; a law lets go of it"
)
_NOMINAL = f"response and flight are {NOMINAL}, as those of tvclin fly"
_BOTH = "what is needed is of both planes with one stop, and the flight of the {} plane alone"
_UNKNOWN = parts.Part(None, ())


@dataclass(frozen=True, eq=False)
class Answer:
    """Numbers that the panel shows; one without an answer, or without one yet, is None.

    `boundary`: required deflection [rad] over the durations of the wind [s], and `need` at the
    chosen one. `rest`: for each remaining step, whether it is slow. `fate`: outcome of a law's
    flight, a status of `FlownCases`. `notes`: reasons, omissions and warnings.
    """

    choices: Choices
    durations: FloatArray
    boundary: FloatArray | None
    rest: tuple[bool, ...]
    need: CaseRequirement | None
    motion: parts.Motion | None
    fate: str | None
    margins: Margins | None
    verdict: str
    notes: tuple[str, ...]

    @property
    def required(self) -> float | None:
        """The deflection that is required at the chosen duration [rad]."""
        return None if self.need is None else self.need.required_deflection


def answer(choices: Choices, max_steps: int | None = None) -> Answer:
    """Return all numbers for the choices, of at most so many steps.

    A part that cannot be answered, such as a law for a stable vehicle, is None and has its reason
    among the notes. A slider waits for no kernel to be compiled; slow steps may compile theirs.
    """
    steps, parts_done = _steps(choices), []
    for run, slow in steps[:max_steps]:
        with nullcontext() if slow else compiling_nothing():
            parts_done.append(run())
    first = [*parts_done[:4], *[_UNKNOWN] * (4 - len(parts_done))]
    (margins, motion, fate, need), curve = first, parts_done[4:]
    values = [None if point.value is None else point.value.required_deflection for point in curve]
    notes = [note for item in (need, *curve, motion, fate, margins) for note in item.notes]
    if need.value is not None:
        notes += _notes(choices, need.value)
        if choices.law == REPORT and choices.limit > need.value.nominal_deflection > 0.0:
            notes.append(_HELD)
    return Answer(
        choices=choices,
        durations=_durations(choices)[: len(curve)],
        boundary=None if None in values else np.array(values, dtype=float),
        rest=tuple(slow for _, slow in steps[len(parts_done) :]),
        need=need.value,
        motion=motion.value,
        fate=fate.value,
        margins=margins.value,
        verdict=_verdict(choices, need.value, fate.value, len(parts_done) > 3),
        notes=(*dict.fromkeys(notes), *_neglected(choices)),
    )


def _steps(choices: Choices) -> list[tuple[Callable[[], parts.Part], bool]]:
    """Return the steps to an answer, and whether each takes longer than a slider may wait."""
    plan_of_need, wind, gust = choices.of_need, choices.wind, choices.of_gust
    sought = wind.gust is not None and wind.gust_at is None and (gust,) not in parts.placed.kept

    def of_flight(cache: parts.Kept) -> parts.Part:
        at = parts.placed(gust)
        if at.value is None:
            return at
        return cache(replace(choices.of_motion, wind=at.value), choices.law)

    def of_need(plan: StudyPlan) -> tuple[Callable[[], parts.Part], bool]:
        return (lambda: parts.need(plan)), _slow(choices) and (plan,) not in parts.need.kept

    lasting = (replace(wind, duration=duration) for duration in _durations(choices).tolist())
    return [
        (lambda: parts.loop_margins(choices.of_margins), False),
        (lambda: of_flight(parts.motion), sought),
        (lambda: of_flight(parts.fate), sought),
        of_need(plan_of_need),
        *(of_need(replace(plan_of_need, wind=duration)) for duration in lasting),
    ]


def _slow(choices: Choices) -> bool:
    """Return whether a required deflection takes longer than a slider may wait."""
    return choices.wind.gust is not None or choices.wind.heading is not None


def _durations(choices: Choices) -> FloatArray:
    """Return the durations of the curve [s], fewer where each takes long."""
    return parts.DURATIONS[:: 3 if _slow(choices) else 1]


def _notes(choices: Choices, need: CaseRequirement) -> list[str]:
    """Return the notes of a study on its vehicle, its gust, its direction and its wind's sign."""
    plan, calm = choices.plan, need.at_nominal_pressure
    plane_notes = [_BOTH.format(plan.plane)] if need.in_both else []
    return [
        *linear_notes(need.wind_angle),
        *doubts(plan.vehicle),
        *gust_placed(choices.wind, need.wind_in_plane),
        *along_the_path(need),
        *(plane_notes or direction_notes(need.planes, plan.plane, False, calm)),
        *(() if calm else [_NOMINAL]),
    ]


def _neglected(choices: Choices) -> list[str]:
    """Return a sentence on each effect that is neglected, such as the structure."""
    return [f"{sentence[0].upper()}{sentence[1:]}." for sentence in told(choices.plan, "explore")]


def _verdict(c: Choices, need: CaseRequirement | None, fate: str | None, computed: bool) -> str:
    flown = (
        "" if fate is None else f" Flown with the law {c.law}, the vehicle {OUTCOME_WORDS[fate]}."
    )
    if need is None:
        said = (
            "No answer for these choices."
            if computed
            else "What this wind requires is computed ..."
        )
        return f"{said}{flown}"
    if need.beyond:
        return f"{sufficiency(None)}: {need.beyond}.{flown}"
    have, required = float(np.degrees(c.limit)), need.required_deflection
    if not required:
        return f"No deflection is needed: no unstable pole that a wind could excite.{flown}"
    word = sufficiency(bool(covers(c.limit, required)))
    return (
        f"{word}: with K = {need.dead_band:g} this wind requires {np.degrees(required):.3f} deg"
        f" ({need.governs}), and the limit is {have:.3f} deg.{flown}"
    )
