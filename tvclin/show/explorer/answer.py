"""Answer of the panel to its choices: numbers and verdict, in steps, each cached by its inputs.

Margins do not depend on the wind, nor a flight on the sign that counts: only parts whose inputs
changed are computed again.
"""

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, one_of
from tvclin.base.package_warnings import pass_warnings
from tvclin.base.quantities import NOMINAL, sufficiency
from tvclin.case.features import omission_notes
from tvclin.case.flexible_autopilot import specified_law
from tvclin.control.autopilot.judged_margins import JudgedMargins
from tvclin.control.laws.registry import DEAD_BAND
from tvclin.flights.closed_loop.fly import fly
from tvclin.flights.closed_loop.fly_many import NOT_KNOWN, OUTCOME_WORDS, fly_many
from tvclin.kernels.choice import compiling_nothing
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.requirement.case_requirement import CaseRequirement, case_requirement
from tvclin.requirement.nominal_requirement import covers
from tvclin.requirement.plane_requirement import direction_notes
from tvclin.requirement.study import along_the_path, gust_placed, vehicle_warnings
from tvclin.show.explorer.choices import CONTROLS, LONGEST, REPORT, Choices
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.wind_angles import beyond_linear, linear_notes

DURATIONS = LONGEST * np.linspace(0.05, 1.0, 30) ** 1.5
"""Durations of the wind [s] of the curve."""
_FOLLOWED_TIME_CONSTANTS, _MAX_FOLLOWED_S = 6.0, 20.0
"""Time of a response shown after the wind, in time constants 1/beta, and its maximum [s]."""
_TIME_POINTS = 401
"""Number of times of a response."""
_MAX_CACHED = 1024
"""Largest number of answers in the cache of a part."""
_HELD = (
    "the report's control holds the limit for ever, and a limit above the boundary then turns"
    " the vehicle over to the other side; a law lets go of it"
)
_NOMINAL = f"response and flight are {NOMINAL}, as those of tvclin fly"
_BOTH = "what is needed is of both planes with one stop, and the flight of the {} plane alone"


@dataclass(frozen=True, eq=False)
class CachedAnswer:
    """Value that a function returns, None where it raises an `InputError`, and its notes."""

    value: Any
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Motion:
    """A response or a flight over time [s], angles in rad, ``(n,)``."""

    time: FloatArray
    wind: FloatArray
    attitude: FloatArray
    deflection: FloatArray


class Cached:
    """A function with a cache of its answers, whose warnings and input errors become notes."""

    def __init__(self, compute: Callable[..., Any]) -> None:
        """Keep the values of a function `compute` by its arguments."""
        self._compute = compute
        self.cache: dict[tuple[Any, ...], CachedAnswer] = {}

    def __call__(self, *arguments: Any) -> CachedAnswer:
        """Return the answer for hashable arguments, from the cache or computed now.

        Its notes are the warnings of the function, or the message of its `InputError` alone. Beyond
        `_MAX_CACHED` answers the oldest ones are dropped.
        """
        if arguments not in self.cache:
            value: Any = None
            notes: list[str] = []
            with pass_warnings(notes.append):
                try:
                    value = self._compute(*arguments)
                except InputError as error:
                    notes = [str(error)]
            self.cache[arguments] = CachedAnswer(value, tuple(notes))
            while len(self.cache) > _MAX_CACHED:
                del self.cache[next(iter(self.cache))]
        return self.cache[arguments]


@Cached
def requirement(plan: StudyPlan) -> CaseRequirement:
    """Return the requirement of a plan's case as `tvclin study` prints it."""
    return case_requirement(plan, plan.dead_band)


@Cached
def loop_margins(plan: StudyPlan) -> JudgedMargins:
    """Return the margins of a plan's autopilot, judged, as `tvclin margins` prints them."""
    return JudgedMargins.of(plan.autopilot, plan.plant, plan.margin_criteria)


@Cached
def placed(plan: StudyPlan) -> ShapedWind:
    """Return the wind of a plan with its gust at the time of the request, or at the worst time."""
    return plan.wind_at(plan.dead_band)


@Cached
def motion(plan: StudyPlan, law: str) -> Motion:
    """Return the motion of the vehicle of a plan in its wind; a gust must have a time.

    `law`: name of the law. The response to the report's control is exact, as by `tvclin respond`;
    a law is flown by the engine of `tvclin fly --engine linear`. The report's control trims and
    then holds the limit, with the sign against the wind. `InputError` for a vehicle without a
    moment. It is shown from the onset of the wind until some time constants after it.
    """
    wind = plan.history
    beta = float(np.sqrt(np.abs(np.asarray(plan.plant.rigid.coefficients.mu_alpha))))
    after = min(_FOLLOWED_TIME_CONSTANTS / beta, _MAX_FOLLOWED_S) if beta else _MAX_FOLLOWED_S
    times = np.linspace(float(wind.onset), float(wind.end) + after, _TIME_POINTS)
    if one_of("law", law, CONTROLS) == REPORT:
        plant = Plant.from_vehicle(plan.vehicle, plan.model, plan.plane)
        sign = -float(np.sign(plant.coefficients.B)) * float(np.sign(wind.peak))  # that of trim
        if not sign:
            raise InputError(
                "the report's control turns the nozzle against the moment of the wind, and this"
                " vehicle feels none: mu_alpha is 0"
            )
        assert plan.nozzle.limit is not None
        deflection = trim_then_hold(plant, wind, sign * plan.nozzle.limit, plan.dead_band)
        response = attitude_responses(plant, deflection, wind, times)
        return Motion(times, wind(times), response["attitude"], deflection(times))
    hardware = {"deflection_limit": plan.nozzle.limit, **plan.hardware}
    flown = fly(plan.plant, _law(plan, law), wind, times, **hardware)
    return Motion(times, wind(times), flown.outputs["attitude"], flown.outputs["deflection"])


@Cached
def outcome(plan: StudyPlan, law: str) -> str | None:
    """Return the outcome of the flight of a law of a plan, a status of `FlownCases`.

    `law`: name of the law; None is returned for `REPORT`, trim then hold, which is not flown.
    """
    if law == REPORT:
        return None
    if beyond_linear(float(plan.history.peak)):
        return NOT_KNOWN
    hardware = {"deflection_limit": plan.nozzle.limit, **plan.hardware}
    return str(fly_many(plan.plant, _law(plan, law), plan.history, **hardware).status)


def _law(plan: StudyPlan, name: str) -> Any:
    """Return the law of a name for a plan, with the dead band and the rate limit of the plan."""
    parameters = {"dead_band": plan.dead_band} if name == DEAD_BAND else {}
    return specified_law(plan, name, plan.hardware["rate_limit"], **parameters)


_UNKNOWN = CachedAnswer(None, ())
"""Answer of a step that is not done."""
_PARTS = 4
"""Number of steps before the curve: margins, motion, outcome and requirement."""


@dataclass(frozen=True, eq=False)
class Answer:
    """Numbers that the panel shows; None for a number that is not computed or has no answer.

    `boundary`: required deflection [rad] over the durations of the wind [s]; `requirement`: that of
    the chosen duration. `remaining`: for each remaining step, whether it is slow. `outcome`: status
    of the flight of a law; see `FlownCases`. `notes`: reasons, omissions and warnings.
    """

    choices: Choices
    durations: FloatArray
    boundary: FloatArray | None
    remaining: tuple[bool, ...]
    requirement: CaseRequirement | None
    motion: Motion | None
    outcome: str | None
    margins: JudgedMargins | None
    verdict: str
    notes: tuple[str, ...]

    @property
    def required(self) -> float | None:
        """The deflection that is required at the chosen duration [rad]."""
        return None if self.requirement is None else self.requirement.required_deflection


def answer(choices: Choices, max_steps: int | None = None) -> Answer:
    """Return all numbers for the choices of the panel, of at most `max_steps` steps; None for all.

    A part that cannot be answered, such as a law for a stable vehicle, is None and has its reason
    among the notes. A slider waits for no kernel to be compiled; slow steps may compile theirs.
    """
    steps, done = _steps(choices), []
    for run, slow in steps[:max_steps]:
        with nullcontext() if slow else compiling_nothing():
            done.append(run())
    # the first steps are four parts (unknown if not done), the others the points of the curve
    first = [*done[:_PARTS], *[_UNKNOWN] * (_PARTS - len(done))]
    (margins, motion, outcome, requirement), curve = first, done[_PARTS:]
    values = [None if point.value is None else point.value.required_deflection for point in curve]
    notes = [
        note for item in (requirement, *curve, motion, outcome, margins) for note in item.notes
    ]
    if requirement.value is not None:
        notes += _notes(choices, requirement.value)
        if choices.law == REPORT and choices.limit > requirement.value.nominal_deflection > 0.0:
            notes.append(_HELD)  # the report's control diverges with more than it requires
    neglected = omission_notes(choices.plan, "explore")  # effects such as bending
    return Answer(
        choices=choices,
        durations=_durations(choices)[: len(curve)],
        boundary=None if None in values else np.array(values, dtype=float),
        remaining=tuple(slow for _, slow in steps[len(done) :]),
        requirement=requirement.value,
        motion=motion.value,
        outcome=outcome.value,
        margins=margins.value,
        verdict=_verdict(choices, requirement.value, outcome.value, len(done) >= _PARTS),
        notes=(*dict.fromkeys(notes), *(f"{words[0].upper()}{words[1:]}." for words in neglected)),
    )


def _steps(choices: Choices) -> list[tuple[Callable[[], CachedAnswer], bool]]:
    """Return the steps to an answer, and whether each takes longer than a slider may wait.

    `choices`: the values of the controls. Margins, motion, outcome and requirement come first, then
    the requirement for each duration of the curve. Slow, unless its answer is cached, is a motion
    or outcome whose gust has no time yet, and a requirement with a gust or a direction of the wind.
    A cache (`placed.cache`, `requirement.cache`) has the arguments of the function as its keys.
    """
    # plans with only those values on which a requirement, and the time of a gust, depend
    inputs, wind, gust = choices.requirement_inputs, choices.wind, choices.gust_inputs
    # whether `placed` must now search for the worst time of the gust: neither given nor cached
    gust_sought = wind.gust is not None and wind.gust_at is None and (gust,) not in placed.cache

    def in_placed_wind(compute: Cached) -> CachedAnswer:
        """Return the motion or the outcome in the wind with its gust at the worst time.

        `compute`: which of both, a function of plan and law. `gust`: plan with the values on which
        that time depends. Where it is not known, the answer has no value, and notes say why.
        """
        placed_wind = placed(gust)  # its value: the wind with its gust, or None
        if placed_wind.value is None:
            return placed_wind
        return compute(replace(choices.motion_inputs, wind=placed_wind.value), choices.law)

    def requirement_step(plan: StudyPlan) -> tuple[Callable[[], CachedAnswer], bool]:
        """Return the step of a plan's requirement, and whether it is slow."""
        return (lambda: requirement(plan)), _slow(choices) and (plan,) not in requirement.cache

    winds = (replace(wind, duration=duration) for duration in _durations(choices).tolist())
    return [
        (lambda: loop_margins(choices.margin_inputs), False),
        (lambda: in_placed_wind(motion), gust_sought),
        (lambda: in_placed_wind(outcome), gust_sought),
        requirement_step(inputs),
        *(requirement_step(replace(inputs, wind=curve_wind)) for curve_wind in winds),
    ]


def _slow(choices: Choices) -> bool:
    """Return whether the required deflection of choices takes longer than a slider may wait."""
    return choices.wind.gust is not None or choices.wind.heading is not None


def _durations(choices: Choices) -> FloatArray:
    """Return the durations of the curve [s], fewer where each takes long by the choices."""
    return DURATIONS[:: 3 if _slow(choices) else 1]


def _notes(choices: Choices, requirement: CaseRequirement) -> list[str]:
    """Return the notes of a study on its vehicle, its gust, its direction and its wind's sign.

    `choices`: the values of the controls. `requirement`: the required deflection in their wind.
    """
    plan, nominal = choices.plan, requirement.at_nominal_pressure
    of_planes = {"both_judged": False, "at_nominal_pressure": nominal}
    plane_notes = [_BOTH.format(plan.plane)] if requirement.judges_both_planes else []
    return [
        *linear_notes(requirement.wind_angle),
        *vehicle_warnings(plan.vehicle),
        *gust_placed(choices.wind, requirement),
        *along_the_path(requirement),
        *(plane_notes or direction_notes(requirement.planes, plan.plane, **of_planes)),
        *(() if nominal else [_NOMINAL]),
    ]


def _verdict(
    c: Choices, requirement: CaseRequirement | None, outcome: str | None, computed: bool
) -> str:
    """Return the sentences on required deflection, limit and flight of the law.

    `c`: the choices. `requirement`: required deflection, None without an answer. `outcome`: status
    of the flight, None for the report's control. `computed`: whether the answer is complete.
    """
    flown = f" Flown with the law {c.law}, the vehicle {OUTCOME_WORDS[outcome]}." if outcome else ""
    if requirement is None and computed:
        return f"No answer for these choices.{flown}"
    if requirement is None:
        return f"What the ideal trim law requires is computed ...{flown}"
    if requirement.beyond_linear:
        return f"{sufficiency(None)}: {requirement.beyond_linear}.{flown}"
    have, required = float(np.degrees(c.limit)), requirement.required_deflection
    if not required:
        return f"No deflection is needed: no unstable pole that a wind could excite.{flown}"
    covered = bool(covers(c.limit, required))
    if covered and requirement.unknown:
        return f"{sufficiency(None)}: {requirement.unknown}.{flown}"
    word = sufficiency(covered)
    return (
        f"{word}: with K = {requirement.dead_band:g} the ideal trim law requires"
        f" {np.degrees(required):.3f} deg ({requirement.governs}), and the limit is"
        f" {have:.3f} deg.{flown}"
    )
