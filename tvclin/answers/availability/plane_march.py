"""Deflections that winds of soundings require in one plane, along a part of a flight.

The equations of the vehicle are those of even steps of the part, computed once; all winds are
marched along them at their own wind angle and dynamic pressure over time. The largest
min(trim, demand) is what they require but where flights decide (`time_varying`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from tvclin.answers.availability.growth import WindGrowth
from tvclin.answers.availability.sounding_winds import FlightPath, LineWinds
from tvclin.answers.sizing.flight_requirement import FlightEquations
from tvclin.answers.time_varying import (
    FLIGHT_PARTS,
    LimitedFlights,
    curves,
    decided_by_flights,
    even_steps,
)
from tvclin.answers.varying_curves import Curves
from tvclin.answers.varying_equations import Equations
from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.winds.histories import History

_MOST_OVER_LEAST = 1.2
"""Up to which multiple of min(trim, demand) a flight may require more, where trim meets it more
than once while the path drifts, or the path is quick; docs/availability.md says what was
measured."""


@dataclass(frozen=True, eq=False)
class Additions:
    """What is added to the winds of soundings.

    Attributes
    ----------
    growth : WindGrowth or None
        What a wind may become until launch.
    gust : History or None
        A gust, by its angle [rad].
    gust_speed : float or None
        Wind speed [m/s] at the peak of the gust, in place of its angle.
    pressure : bool
        Whether the dynamic pressure encountered counts, or the nominal one.
    """

    growth: WindGrowth | None
    gust: History | None
    gust_speed: float | None
    pressure: bool

    def grown(self, height: FloatArray) -> FloatArray:
        """Return the growth of winds at heights [m/s]."""
        return np.zeros(height.shape) if self.growth is None else self.growth.at(height)

    def strongest(self, height: FloatArray) -> FloatArray:
        """Return growth and speed of the gust [m/s]."""
        return self.grown(height) + abs(self.gust_speed or 0.0)

    @property
    def symmetric(self) -> bool:
        """Whether winds are the same, whichever of their directions requires more."""
        return self.growth is None and self.gust is None


@dataclass(frozen=True, eq=False)
class Bounds:
    """Bounds of the deflections [rad] that winds require, as sizes ``(n,)``.

    Attributes
    ----------
    least : ndarray
        The largest min(trim, demand).
    most : ndarray
        What a flight may require, no more than the largest trim.
    lowest : ndarray
        The lowest limit with which a flight may survive: less than `least` where trim reaches that
        to both sides, or more than once while the path drifts.
    highest : ndarray
        A limit that the law never meets.
    """

    least: FloatArray
    most: FloatArray
    lowest: FloatArray
    highest: FloatArray


@dataclass(frozen=True, eq=False)
class PlaneMarch:
    """A part of a flight in one plane, ready for any winds.

    Attributes
    ----------
    path : FlightPath
        The part of the flight.
    plane : str
        Plane of the motion.
    motion : FlightEquations
        The equations of the vehicle, with an unstable mode.
    fastest : FlightEquations
        Those of the plane whose rates set the steps of both.
    """

    path: FlightPath
    plane: str
    motion: FlightEquations
    fastest: FlightEquations

    @cached_property
    def _steps(self) -> tuple[FloatArray, Equations]:
        """Times [s] of even steps, and the equations there."""
        return self._every(1)

    @cached_property
    def _flight_steps(self) -> tuple[FloatArray, Equations]:
        """Times [s] of the steps of flights, and the equations there."""
        return self._every(FLIGHT_PARTS)

    def _every(self, parts: int) -> tuple[FloatArray, Equations]:
        steps = even_steps(self.fastest, (self.path.time[0], self.path.time[-1]), parts)
        return steps, self.motion.over(steps)

    def curves(self, winds: LineWinds, pressure: bool) -> Curves:
        """Return trim and demand of winds."""
        steps, equations = self._steps
        return curves(equations, *self.path.encountered(steps, winds, self.plane, pressure))

    def _limit(self, found: Curves, side: float | None = None) -> tuple[FloatArray, FloatArray]:
        paired = np.broadcast_to(self._steps[1].paired, found.trim.shape)
        return found.limit_of_trim_law(paired, side)

    def bounds(self, winds: LineWinds, pressure: bool) -> Bounds:
        """Return bounds of the deflections that winds require."""
        found, equations = self.curves(winds, pressure), self._steps[1]
        limit, highest = self._limit(found)[0], found.highest_limit
        if np.any(equations.paired):
            return Bounds(limit, limit, limit, highest)
        doubted, lowest = decided_by_flights(equations, found, limit)
        more = np.maximum(limit, np.minimum(_MOST_OVER_LEAST * limit, highest))
        most = np.where(doubted & equations.drifts, more, limit)
        return Bounds(limit, most, lowest, highest)

    def with_gusts(self, winds: LineWinds, side: float, additions: Additions) -> list[LineWinds]:
        """Return winds with a gust to one side: where they are largest, and at their limit.

        `side`: sign of the winds that count; where there are none the gust is left out.
        """
        gust, times = additions.gust, winds.times
        if gust is None:
            return [winds]
        angle = side * self.path.nominal_angle(winds.speeds[self.plane], times, self.plane)
        calm = np.max(angle, axis=1) <= 0.0
        top = np.argmax(angle, axis=1)
        equations = self._steps[1].nominal[0, :, 1, 1]
        turn = -np.sign(np.sum(equations[:, -1] / equations[:, -2]))  # of trim in such a wind
        at_limit = self._limit(self.curves(winds, additions.pressure), turn * side)[1]
        speed = partial(self._gust_speed, side, additions, calm)
        return [
            winds.with_gust(gust, self.plane, at, speed)
            for at in (times[np.arange(top.size), top], at_limit)
        ]

    def _gust_speed(
        self, side: float, additions: Additions, calm: BoolArray, angle: FloatArray, at: FloatArray
    ) -> FloatArray:
        """Return speeds [m/s] of a gust of angles [rad] at times [s], zero in a calm."""
        gust, speed = additions.gust, additions.gust_speed
        if gust is not None and speed is not None:
            blows = side * speed * angle / float(gust.peak)
        else:
            blows = self.path.speed_of_angle(side * angle, at, self.plane, additions.pressure)
        return np.where(calm[:, np.newaxis], 0.0, blows)

    def flights(self, winds: LineWinds, pressure: bool) -> LimitedFlights:
        """Return flights of the ideal trim law through winds."""
        steps, equations = self._flight_steps
        each = self.path.encountered(steps, winds, self.plane, pressure)
        return LimitedFlights(equations, *each)


@dataclass(frozen=True, eq=False)
class MarchedWinds:
    """Winds of soundings in one plane of a part of a flight, with their bounds.

    Attributes
    ----------
    march : PlaneMarch
        The part of the flight.
    winds : LineWinds
        One wind of each sounding.
    bounds : Bounds
        What they require.
    pressure : bool
        Whether the dynamic pressure encountered counts.
    """

    march: PlaneMarch
    winds: LineWinds
    bounds: Bounds
    pressure: bool

    def flown(self, limit: FloatArray) -> tuple[BoolArray, BoolArray]:
        """Return with which limits [rad] flights must decide, and which are lost without any."""
        lost = limit < self.bounds.lowest
        return (self.bounds.most > limit) & ~lost, lost

    def survive(self, limit: FloatArray, cases: IndexArray) -> BoolArray:
        """Return whether flights of cases survive with limits [rad] and all above."""
        flights = self.march.flights(self.winds.of(cases), self.pressure)
        return flights.survive(limit[cases], self.bounds.most[cases])

    def requirement(self, cases: IndexArray) -> FloatArray:
        """Return the deflections [rad] that cases require, by flights where these decide."""
        b, required = self.bounds, self.bounds.least[cases]
        doubted = np.flatnonzero((b.most > b.least)[cases] | (b.lowest < b.least)[cases])
        if doubted.size:
            flown = cases[doubted]
            flights = self.march.flights(self.winds.of(flown), self.pressure)
            required[doubted] = flights.requirement(b.lowest[flown], b.highest[flown])
        return required
