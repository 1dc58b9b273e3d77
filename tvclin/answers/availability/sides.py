"""What winds ask of one plane to one side, in a part of a flight: bounded, or flown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.answers.availability.growth import WindGrowth
from tvclin.answers.availability.met import FlownPath, Winds, on_lines, with_gust
from tvclin.answers.availability.needs import needs_of_winds
from tvclin.answers.availability.tables import FlightTables, TableRows
from tvclin.answers.sizing.flight_mode import FlightMode
from tvclin.answers.sizing.flown import flight_steps, trim_law_needs
from tvclin.answers.time_varying import curves
from tvclin.answers.varying_equations import Equations
from tvclin.base.arrays import FloatArray
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import wind_triangle

_RETURNS, _DRIFTS_FAST = 1.2, 1.02
"""Of what a wind asks for, so much a flight may need that meets the limit more than once while the
path drifts, or once while it drifts fast, as far as docs/availability.md says what was measured."""


@dataclass(frozen=True, eq=False)
class Sides:
    """What blows on top of winds along a path: what they may still become, and a gust.

    Needs are ``(3, n)`` of n winds: the least, what a flight may need more, and the largest trim
    [rad].
    """

    path: FlownPath
    growth: WindGrowth | None
    gust: History | None
    gust_speed: float | None
    """Of the gust [m/s], in place of its angle."""

    def grown(self, height: FloatArray) -> Any:
        """Return what the wind may become at heights [m/s]."""
        return 0.0 if self.growth is None else self.growth.at(height)

    def strongest(self, height: FloatArray) -> Any:
        """Return the same with the speed of the gust [m/s]."""
        return self.grown(height) + abs(self.gust_speed or 0.0)

    def _gust_size(self, times: FloatArray, plane: str) -> FloatArray:
        """The gust whose middle is at times [s], over the one that is given."""
        if self.gust is None or self.gust_speed is None:
            return np.ones(times.shape)
        speed = np.full(times.shape, self.gust_speed)
        return self.path.angle(speed, times, plane) / float(self.gust.peak)

    def to_one(
        self,
        tables: FlightTables,
        height: FloatArray,
        times: FloatArray,
        wind: FloatArray,
        fine: FloatArray,
        rows: TableRows,
        flown: bool,
    ) -> tuple[FloatArray, list[Winds]]:
        """Return what winds [m/s] at heights and times ask for to one side, ``(3, n)``.

        And these winds, with their gusts.
        """
        plane = tables.mode.plane
        angle = self.path.angle(wind + self.grown(height), times, plane)
        if fine is not times:
            angle = on_lines(times, angle, fine)
        need, at_limit = self._on_lines(tables, fine, angle, rows, flown)
        winds = [(fine, angle)]
        if self.gust is not None:
            top = fine[np.arange(angle.shape[0]), np.argmax(angle, axis=1)]
            blows = np.max(angle, axis=1) > 0.0
            winds = [
                with_gust(self.gust, blows * self._gust_size(at, plane), fine, angle, at)
                for at in (top, at_limit)
            ]
            gusty = [self._on_lines(tables, *wind, None, flown)[0] for wind in winds]
            need = np.where(blows, np.maximum(*gusty), need)
        return need, winds

    def _on_lines(
        self,
        tables: FlightTables,
        times: FloatArray,
        angle: FloatArray,
        rows: TableRows | None,
        flown: bool,
    ) -> tuple[FloatArray, FloatArray]:
        """What wind angles [rad] ask for, and when trim and demand are that large.

        The least, what a flight may need more, and the largest trim, ``(3, n)``.
        """
        found = needs_of_winds(tables, times, angle, rows)
        fast = tables.at(found.at).drifts_fast
        part = np.where(found.returns, _RETURNS, np.where(fast, _DRIFTS_FAST, 1.0))
        part = np.where(tables.order > 0, part, 1.0)
        need = np.stack([found.limit, part * found.limit, found.trim])
        return (flown_needs(tables.mode, times, angle, need) if flown else need), found.at


def in_air(
    path: FlownPath,
    air: tuple[FloatArray, Equations],
    plane: str,
    side: float,
    winds: list[Winds],
    other: FloatArray,
    fine: FloatArray,
) -> FloatArray:
    """Return what winds to a side need in the dynamic pressure met, over calm air's, ``(3, n)``.

    `path` and `air` are of the part of the flight. The other plane's wind [m/s] is that at the
    `fine` times.
    """
    times_of_steps, equations = air
    shape = fine.shape[0], *times_of_steps.shape[1:]
    steps = times_of_steps.ravel()
    at = np.broadcast_to(steps, (fine.shape[0], steps.size))
    every = []
    speed, climb = (np.interp(steps, path.time, one) for one in (path.speed, path.climb))
    beside = on_lines(fine, other, at) / speed
    for times, angle in winds:
        turned = on_lines(times, angle, at)
        own = side * np.sin(turned)
        along, across = (own / np.sin(climb), beside) if plane == "pitch" else (beside, own)
        ratio = wind_triangle(climb, along, across)[2]
        encountered = np.arcsin(np.clip(np.sin(turned) / np.sqrt(ratio), -1.0, 1.0))
        nominal, met = (
            _limit_and_trim(equations, times_of_steps, *(x.reshape(shape) for x in pair))
            for pair in ((turned, np.ones(turned.shape)), (encountered, ratio))
        )
        with np.errstate(invalid="ignore", divide="ignore"):
            every.append(met / nominal)
    found = np.fmax.reduce(every)[[0, 0, 1]]
    return np.where(np.isnan(found), 1.0, found)


def _limit_and_trim(
    equations: Equations, times: FloatArray, wind: FloatArray, ratio: FloatArray
) -> FloatArray:
    """Return the limit with K = 1 from both curves, and trim along the path [rad], ``(2, n)``."""
    found = curves(equations, times, wind, ratio)
    paired = np.broadcast_to(equations.paired, wind.shape)
    return np.stack([found.limit_of_trim_law(paired)[0], found.largest_trim])


def flown_needs(
    mode: FlightMode, times: FloatArray, angle: FloatArray, need: FloatArray
) -> FloatArray:
    """Return needs ``(3, n)`` in wind angles [rad], flown where they differ."""
    doubted = at_most(need) > need[0]
    if not np.any(doubted):
        return need
    steps = flight_steps(mode)
    winds = on_lines(
        times[doubted], angle[doubted], np.broadcast_to(steps, (int(doubted.sum()), steps.size))
    )
    found = need.copy()
    found[:, doubted] = trim_law_needs(mode, steps, winds, need[0, doubted])
    return found


def at_most(need: FloatArray) -> FloatArray:
    """Return needs ``(3, n)`` at the most: what a flight may need more, or the largest trim."""
    least, more, trim = need
    return np.maximum(least, np.minimum(more, trim))
