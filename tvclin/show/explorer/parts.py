"""The parts of an answer, each cached by the values on which it depends and by nothing else.

Margins do not depend on the wind, nor a flight on the sign that counts: only parts whose values
changed are computed again.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, one_of
from tvclin.base.warned import warned
from tvclin.case.flexible_autopilot import law_asked
from tvclin.control.laws.registry import DEAD_BAND
from tvclin.control.margins.margins import Margins
from tvclin.flights.closed_loop.fly import fly
from tvclin.flights.closed_loop.fly_many import fly_many
from tvclin.flights.theory_comparison import NOT_KNOWN
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.requirement.case_requirement import CaseRequirement, case_requirement
from tvclin.show.explorer.choices import CONTROLS, REPORT
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.winds.histories import History
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.wind_angles import beyond_linear

LONGEST = 30.0
"""Longest wind [s] of the curve."""
DURATIONS = LONGEST * np.linspace(0.05, 1.0, 30) ** 1.5
"""Durations of the wind [s] of the curve."""
_FOLLOWED_TIME_CONSTANTS, _MAX_FOLLOWED_S = 6.0, 20.0
"""Time of a response shown after the wind, in time constants 1/beta, and its maximum [s]."""
_TIME_POINTS = 401
"""Number of times of a response."""
_MAX_CACHED = 1024
"""Largest number of answers in the cache of a part."""


@dataclass(frozen=True, eq=False)
class Part:
    """The value of a part, None where there is no answer, and its notes."""

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
    """A function with a cache of its answers, whose warnings and input errors become notes."""

    def __init__(self, compute: Callable[..., Any]) -> None:
        self._compute = compute
        self.kept: dict[tuple[Any, ...], Part] = {}

    def __call__(self, *plain: Any) -> Part:
        """Return the part for these arguments, from the cache or computed now."""
        if plain not in self.kept:
            self.kept[plain] = self._computed(plain)
            while len(self.kept) > _MAX_CACHED:
                del self.kept[next(iter(self.kept))]
        return self.kept[plain]

    def _computed(self, plain: tuple[Any, ...]) -> Part:
        said: list[str] = []
        with warned(said.append):
            try:
                value = self._compute(*plain)
            except InputError as error:
                return Part(None, (str(error),))
        return Part(value, tuple(said))


@Kept
def need(plan: StudyPlan) -> CaseRequirement:
    """Return the requirement of the case, the one that `tvclin study` prints."""
    return case_requirement(plan, plan.dead_band)


@Kept
def loop_margins(plan: StudyPlan) -> Margins:
    """Return the margins of the autopilot, those that `tvclin margins` prints."""
    return plan.autopilot.margins(plan.plant)


@Kept
def placed(plan: StudyPlan) -> ShapedWind:
    """Return the wind with its gust at its time, or at the worst one."""
    return plan.wind_at(plan.dead_band)


@Kept
def motion(plan: StudyPlan, law: str) -> Motion:
    """Return the motion of the vehicle in a wind whose gust has its time.

    The response to the report's control is exact, that of `tvclin respond`; a law is flown by the
    engine of `tvclin fly --engine linear`.
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
        deflection = trim_then_hold(plant, wind, against * plan.nozzle.limit, plan.dead_band)
        response = attitude_responses(plant, deflection, wind, times)
        return Motion(times, wind(times), response["attitude"], deflection(times))
    flown = fly(plan.plant, _law(plan, law), wind, times, **_nozzle(plan))
    return Motion(times, wind(times), flown.outputs["attitude"], flown.outputs["deflection"])


@Kept
def fate(plan: StudyPlan, law: str) -> str | None:
    """Return the outcome of the flight of a law, a status of `FlownCases`; None for `REPORT`."""
    if law == REPORT:
        return None
    if beyond_linear(float(plan.history.peak)):
        return NOT_KNOWN
    return str(fly_many(plan.plant, _law(plan, law), plan.history, **_nozzle(plan)).status)


def _law(plan: StudyPlan, name: str) -> Any:
    parameters = {"dead_band": plan.dead_band} if name == DEAD_BAND else {}
    return law_asked(plan, name, plan.hardware["rate_limit"], **parameters)


def _nozzle(plan: StudyPlan) -> dict[str, Any]:
    return {"deflection_limit": plan.nozzle.limit, **plan.hardware}


def _times(plan: StudyPlan, wind: History) -> FloatArray:
    """Return times [s] from the onset of a wind until some time after it, ``(401,)``."""
    beta = float(np.sqrt(np.abs(np.asarray(plan.plant.rigid.coefficients.mu_alpha))))
    after = min(_FOLLOWED_TIME_CONSTANTS / beta, _MAX_FOLLOWED_S) if beta else _MAX_FOLLOWED_S
    return np.linspace(float(wind.onset), float(wind.end) + after, _TIME_POINTS)
