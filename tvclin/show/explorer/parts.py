"""The parts of an answer, each kept by what it depends on and by nothing else.

Margins do not depend on the wind, nor a flight on the sign that counts: what did not change is not
computed again.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.answers.case_requirement import CaseRequirement, case_requirement
from tvclin.answers.flexible import law_asked
from tvclin.answers.study_file.plan import StudyPlan
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, one_of
from tvclin.base.warned import warned
from tvclin.control.laws.registry import DEAD_BAND
from tvclin.control.margins.margins import Margins
from tvclin.flights.closed_loop.fly import fly
from tvclin.flights.closed_loop.fly_many import fly_many
from tvclin.flights.theory_comparison import NOT_KNOWN
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.show.explorer.choices import CONTROLS, REPORT
from tvclin.winds.histories import History
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.wind_angles import beyond_linear

LONGEST = 30.0
"""Longest wind [s] of the curve."""
DURATIONS = LONGEST * np.linspace(0.05, 1.0, 30) ** 1.5
_AFTER, _LONGEST_AFTER = 6.0, 20.0
"""A response is followed so long after the wind, times beta, and at most so many seconds."""
_POINTS = 401
_KEPT = 1024


@dataclass(frozen=True, eq=False)
class Part:
    """What was found, None where there is no answer, and what is to be said of it."""

    value: Any
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Motion:
    """A response or a flight over time [s], angles in rad, ``(n,)``."""

    time: FloatArray
    wind: FloatArray
    attitude: FloatArray
    deflection: FloatArray


class Kept:
    """A function whose answers are kept, with warnings and refusals as sentences beside them."""

    def __init__(self, compute: Callable[..., Any]) -> None:
        self._compute = compute
        self.kept: dict[tuple[Any, ...], Part] = {}

    def __call__(self, *plain: Any) -> Part:
        """Return what is kept of these arguments, or is found now."""
        if plain not in self.kept:
            self.kept[plain] = self._found(plain)
            while len(self.kept) > _KEPT:
                del self.kept[next(iter(self.kept))]
        return self.kept[plain]

    def _found(self, plain: tuple[Any, ...]) -> Part:
        said: list[str] = []
        with warned(said.append):
            try:
                value = self._compute(*plain)
            except InputError as error:
                return Part(None, (str(error),))
        return Part(value, tuple(said))


@Kept
def need(plan: StudyPlan) -> CaseRequirement:
    """Return what is required, as `tvclin study` says it."""
    return case_requirement(plan, plan.dead_band)


@Kept
def loop_margins(plan: StudyPlan) -> Margins:
    """Return the margins of the autopilot, as `tvclin margins` says them."""
    return plan.autopilot.margins(plan.plant)


@Kept
def placed(plan: StudyPlan) -> ShapedWind:
    """Return the wind with its gust at its time, or at the worst one."""
    return plan.wind_at(plan.dead_band)


@Kept
def motion(plan: StudyPlan, law: str) -> Motion:
    """Return what the vehicle does in a wind whose gust has its time.

    The report's control is a history and its response exact, as of `tvclin respond`; a law is flown
    as `tvclin fly --engine linear` flies it.
    """
    wind = plan.history
    times = _times(plan, wind)
    if one_of("law", law, CONTROLS) == REPORT:
        plant = Plant.from_vehicle(plan.vehicle, plan.model, plan.plane)
        against = -float(np.sign(plant.coefficients.B)) * float(np.sign(wind.peak))
        if not against:
            raise InputError(
                "the report's control turns the nozzle against the moment of the wind, and this"
                " vehicle feels none: mu_alpha is 0"
            )
        assert plan.nozzle.limit is not None
        held = trim_then_hold(plant, wind, against * plan.nozzle.limit, plan.dead_band)
        found = attitude_responses(plant, held, wind, times)
        return Motion(times, wind(times), found["attitude"], held(times))
    flown = fly(plan.plant, _law(plan, law), wind, times, **_nozzle(plan))
    return Motion(times, wind(times), flown.outputs["attitude"], flown.outputs["deflection"])


@Kept
def fate(plan: StudyPlan, law: str) -> str | None:
    """Return what becomes of the flight of a law, as of `FlownCases`; None of what is no law."""
    if law == REPORT:
        return None
    if beyond_linear(float(plan.history.peak)):
        return NOT_KNOWN
    return str(fly_many(plan.plant, _law(plan, law), plan.history, **_nozzle(plan)).status)


def _law(plan: StudyPlan, name: str) -> Any:
    own = {"dead_band": plan.dead_band} if name == DEAD_BAND else {}
    return law_asked(plan, name, plan.hardware["rate_limit"], **own)


def _nozzle(plan: StudyPlan) -> dict[str, Any]:
    return {"deflection_limit": plan.nozzle.limit, **plan.hardware}


def _times(plan: StudyPlan, wind: History) -> FloatArray:
    """Times [s] from the onset of a wind until some time after it."""
    beta = float(np.sqrt(np.abs(np.asarray(plan.plant.rigid.coefficients.mu_alpha))))
    after = min(_AFTER / beta, _LONGEST_AFTER) if beta else _LONGEST_AFTER
    return np.linspace(float(wind.onset), float(wind.end) + after, _POINTS)
