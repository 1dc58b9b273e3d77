"""Exact response of the linear model to the wind of a study, with trim and then the limit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tvclin.base.lines import Line, Table, degrees
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.extremes import (
    COMPLETE,
    OVERTURNED,
    OVERTURNED_NOTE,
    RELEASED,
    extremes,
    response_end,
    response_table,
    wind_loads,
)
from tvclin.linear.plant import Plant
from tvclin.linear.response import Responses, attitude_responses
from tvclin.requirement.study import Study

if TYPE_CHECKING:
    from tvclin.linear.extremes import Extremes
    from tvclin.winds.histories import History

_MAX_END_OVER_DURATION = 2.0
"""Longest time of a response, in durations of the wind."""
_POINTS = 401
"""Number of times of a response."""
_LIMIT_OVER_REQUIREMENT = 1.1
"""Limit of the response over the required deflection, where the study has no limit."""
_END_NOTES = {
    RELEASED: "It ends where the attitude is back at zero: there an autopilot lets go of the"
    " limit.",
    OVERTURNED: "It ends where the attitude error exceeds 90 degrees.",
    COMPLETE: "The attitude does not come back to zero in this time.",
}
"""Reason of the end of a response, in a sentence."""


@dataclass(frozen=True, eq=False)
class StudyResponse:
    """Response to the wind of a study: trim up to the dead band, then the limit.

    `limit` [rad], `end` [s]; `why`: reason of the end; see `response_end`.
    """

    study: Study
    plant: Plant
    deflection: History
    limit: float
    end: float
    why: str

    @property
    def extremes(self) -> Extremes:
        """Extremes of the attitude up to the end."""
        return extremes(self.plant, self.deflection, self.study.history, self.end)

    @property
    def response(self) -> Responses:
        """Response at 401 times from the begin of the wind to the end."""
        times = np.linspace(0.0, self.end, _POINTS)
        return attitude_responses(self.plant, self.deflection, self.study.history, times)

    @property
    def limit_words(self) -> str:
        """Origin of the limit: the study, or a multiple of the required deflection."""
        if self.study.limit is not None:
            return "the limit in question"
        return f"{_LIMIT_OVER_REQUIREMENT:g} times the required deflection"

    @property
    def limit_line(self) -> Line:
        """Limit in degrees."""
        return degrees("response.limit", self.limit, unit="deg")

    @property
    def note(self) -> str:
        """Reason of the end, in sentences."""
        largest = self.extremes
        if largest.with_wind is None and largest.against_wind is None:
            return "Trim stays within the limit, and the attitude at zero."
        enough = self.study.limit is None or self.study.sufficient
        note = f" {OVERTURNED_NOTE}" if self.why == OVERTURNED and enough else ""
        return f"{_END_NOTES[self.why]}{note}"

    @property
    def table(self) -> Table:
        """Table of largest and last values, with loads where the response covers the wind."""
        wind, loads = self.study.history, None
        if self.end >= wind.end:
            loads = wind_loads(self.plant, self.deflection, wind)
        return response_table("Largest and last values", self.extremes, loads)


def study_response(s: Study) -> StudyResponse | None:
    """Return the response of a study with its limit, by default 1.1 times the required deflection.

    None where that is zero or infinite.
    """
    required = abs(float(s.requirement.deflection))
    limit = s.limit if s.limit is not None else _LIMIT_OVER_REQUIREMENT * required
    if not limit or np.isinf(limit):
        return None
    plant, wind = Plant(s.coefficients, s.model), s.history
    against = -float(np.sign(s.coefficients.B * wind.peak)) or 1.0
    deflection = trim_then_hold(plant, wind, against * limit, s.dead_band, s.switch)
    shown = response_end(plant, deflection, wind, _MAX_END_OVER_DURATION * float(wind.end))
    return StudyResponse(s, plant, deflection, limit, shown.time, shown.why)
