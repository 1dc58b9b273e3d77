"""Winds of soundings, marched together along a vehicle in a plane, and bounds of what they require.

The equations of the vehicle are computed once, at even steps of an interval of the flight; all
winds are marched along them at the wind angle and dynamic pressure encountered. The requirement is
the largest min(trim, demand), except where flights decide (`time_varying`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.ensembles.availability.sounding_winds import (
    FlightPath,
    PolylineWinds,
    WindGrowth,
    on_lines,
)
from tvclin.requirement.flight.flight_requirement import FlightMode
from tvclin.time_varying import requirements as time_varying
from tvclin.time_varying.curves import Curves, smaller
from tvclin.time_varying.equations import Equations
from tvclin.time_varying.requirements import SteppedWinds
from tvclin.time_varying.steps import even_steps, with_calm_after
from tvclin.vehicle.coefficients import PLANES
from tvclin.winds.histories import History

_MAX_UPPER_RATIO = 1.2
"""Largest ratio of the requirement of a flight to min(trim, demand), where trim crosses that more
than once while the path drifts slowly; docs/availability.md has measured ratios."""


@dataclass(frozen=True, eq=False)
class Additions:
    """Growth and gust that are added to the winds of soundings.

    `growth`: growth of the wind until launch, or None. `gust`: a gust, by its angle [rad], or None.
    `gust_speed`: wind speed [m/s] at the peak of the gust, in place of its angle.
    """

    growth: WindGrowth | None
    gust: History | None
    gust_speed: float | None

    def grown(self, height: FloatArray) -> FloatArray:
        """Return the wind speed [m/s] added until launch, at heights [m]; zero without growth."""
        return np.zeros(height.shape) if self.growth is None else self.growth.at(height)

    def strongest(self, height: FloatArray) -> FloatArray:
        """Return the sum of growth and gust speed [m/s] at heights [m]."""
        return self.grown(height) + abs(self.gust_speed or 0.0)

    @property
    def gust_text(self) -> str:
        """Text on size and duration of the gust, ", with a gust of 9 m/s and 2 s"; else empty."""
        if self.gust is None:
            return ""
        angle, speed = f"{np.degrees(self.gust.peak):.4g} deg", self.gust_speed
        size = angle if speed is None else f"{speed:.4g} m/s"
        return f", with a gust of {size} and {self.gust.end - self.gust.onset:.4g} s"

    @property
    def symmetric(self) -> bool:
        """Whether nothing is added to the winds, so that both signs of them require the same."""
        return self.growth is None and self.gust is None


@dataclass(frozen=True, eq=False)
class Bounds:
    """Bounds of the deflections [rad] that n winds require, as sizes ``(n,)``.

    `lower`: the largest min(trim, demand), or the minimum peak over several unstable modes if
    larger. `upper`: largest possible requirement of a flight, at most the largest trim; infinite
    where a flight on a quick path diverges with a limit that it never reaches. `lowest`: lowest
    limit with which a flight may survive: less than `lower` where trim reaches `lower` with both
    signs, or more than once while the path drifts, or the moment changes its sign. `highest`: a
    limit that the law never reaches.
    """

    lower: FloatArray
    upper: FloatArray
    lowest: FloatArray
    highest: FloatArray


@dataclass(frozen=True, eq=False)
class PlaneMarch:
    """Equations of an interval of a flight in a plane, along which winds are marched.

    `path`: the interval of the flight. `plane`: plane of the motion. `motion`: the equations of the
    vehicle, with an unstable mode. `fastest`: equations of the plane whose rates set the steps of
    both planes.
    """

    path: FlightPath
    plane: str
    motion: FlightMode
    fastest: FlightMode

    @cached_property
    def _steps(self) -> tuple[FloatArray, Equations]:
        """Times [s] at begin, middle and end of even steps, ``(1, S, 3)``, and their equations."""
        steps = even_steps(self.fastest, self._span)
        return steps, self.motion.at_steps(steps)

    @cached_property
    def _flight_steps(self) -> tuple[FloatArray, Equations]:
        """Times [s] of the steps of flights, ``(1, S, 3)``, and the equations of steps and calm.

        The equations, not the times returned, go on through the calm after the interval, in which a
        flight may still diverge.
        """
        steps = even_steps(self.fastest, self._span, time_varying.FLIGHT_SUBSTEPS)
        unused = np.zeros(steps.shape)  # in place of wind and dynamic pressure
        _, even_equations = self._steps
        times, *_unused = with_calm_after(even_equations, steps, unused, unused)
        return steps, self.motion.at_steps(times)

    @property
    def _span(self) -> tuple[float, float]:
        """First and last time [s] of the interval."""
        return self.path.time[0], self.path.time[-1]

    def stepped(self, winds: PolylineWinds) -> SteppedWinds:
        """Return winds as the vehicle encounters them over the even steps, with its equations."""
        steps, equations = self._steps
        return SteppedWinds(equations, *self.path.encountered(steps, winds, self.plane))

    def _limit(self, march: Curves, sign: float | None = None) -> tuple[FloatArray, FloatArray]:
        """Return the largest min(trim, demand) [rad] and its time [s], ``(n,)`` each.

        Trim is the deflection of zero moment, the demand the constant deflection that is sufficient
        from then on; where two unstable modes are a pair, trim counts alone. `march`: both curves
        of n winds over time. `sign`: sign of the deflections that count; None for both.
        """
        _, equations = self._steps
        # whether the modes are a pair at each time, from one flight for all winds
        paired = np.broadcast_to(equations.paired, march.trim.shape)
        return march.limit_of_trim_law(paired, sign)

    def bounds(self, winds: PolylineWinds) -> Bounds:
        """Return bounds of the required deflections [rad] of n winds, by trim and demand over time.

        Both are max(min(trim, demand)), or the minimum peak over all unstable modes if larger.
        Where flights of the trim law would decide (`decided_by_flights`) the upper one is 1.2 times
        that, as was measured, at most `highest`, a limit that the law never reaches. With a quick
        path (b1 negative, or a second pole comparable with the fastest) or a moment of changing
        sign it is `highest`. Where the law may diverge with that, it is flown: infinite if it does.
        `lowest`: lowest limit with which a flight may survive.
        """
        stepped = self.stepped(winds)
        equations, march = stepped.equations, stepped.curves()  # trim and demand over time
        (limit, _time), highest = self._limit(march), march.highest_limit  # at the ends of steps
        limit = np.maximum(limit, self._limit_at_levels(winds, march, stepped))  # and within
        minimum = np.zeros(limit.shape)  # peak over all unstable modes
        for cases, peaks in stepped.peaks_over_modes(march.path):
            # from the begin of the first step on
            minimum[cases] = np.maximum(minimum[cases], peaks[:, 0])
        flown, lowest = time_varying.decided_by_flights(equations, march, limit)
        limit, lowest = np.maximum(limit, minimum), np.maximum(lowest, minimum)
        upper = np.maximum(limit, np.minimum(_MAX_UPPER_RATIO * limit, highest))
        if np.any(equations.quick_path | equations.changes_sign) or self._law_may_diverge:
            upper = np.maximum(limit, highest)
        if self._law_may_diverge:
            diverges = self.flights(winds).diverge(highest[:, np.newaxis])[:, 0]
            upper = np.where(diverges, np.inf, upper)
        else:
            upper = np.where(flown, upper, limit)
        return Bounds(lower=limit, upper=upper, lowest=lowest, highest=highest)

    @cached_property
    def _law_may_diverge(self) -> bool:
        """Whether flights may diverge with a limit that the law never reaches.

        They may if the vehicle is stable somewhere, or its path is unstable while trim holds the
        attitude. Rows of the equations are the derivatives of attitude, its rate and the path
        angle; columns are these states, then deflection and wind.
        """
        _, equations = self._steps
        if not equations.drifts:
            return False
        E = equations.nominal
        # with the deflection that makes the angular acceleration due to the path angle zero
        path_rate = E[..., 2, 2] - E[..., 2, -2] / E[..., 1, -2] * E[..., 1, 2]
        mu_alpha = E[..., 1, 0]  # row of the attitude rate, column of attitude
        return bool(np.any(mu_alpha < 0.0) or np.any(path_rate > 0.0))

    def _limit_at_levels(
        self, winds: PolylineWinds, march: Curves, stepped: SteppedWinds
    ) -> FloatArray:
        """Return the limit [rad] that n winds require at their levels, ``(n,)``.

        It is the largest min(trim, demand) at the times of `winds`, most of which lie within a
        step; the demand is the limit sufficient when held from then on. Trim is -B q/q_n alpha_w
        (dynamic pressure over the nominal one, wind angle), and what balances drift, linear between
        the ends of steps. Where two unstable modes are a pair, trim alone counts. `march`: trim and
        demand over the steps. `stepped`: wind and q/q_n there.
        """
        steps, equations = self._steps  # begin, middle and end of S steps, (1, S, 3)
        # row of the angular acceleration in [A b w], whose last columns are deflection and wind
        acceleration = equations.nominal[..., 1, :]
        static = -acceleration[..., -1] / acceleration[..., -2]  # trim over wind angle: -B
        drift_trim = march.trim - static * stepped.ratio * stepped.wind
        # at the first begin and the ends of all steps; `paired`: whether unstable modes are a pair
        drift_trim, static, paired = (
            np.concatenate([x[:, :1, 0], x[..., 2]], axis=1)
            for x in (drift_trim, static, equations.paired)
        )
        ends, times = np.append(steps[0, 0, 0], steps[0, :, 2]), winds.times
        along, across = (winds.speeds[plane] for plane in PLANES)
        angle, ratio = self.path.angle_and_pressure(times, along, across, self.plane)
        trim = on_lines(np.broadcast_to(ends, drift_trim.shape), drift_trim, times)
        trim += np.interp(times, ends, static[0]) * ratio * angle
        case = np.broadcast_to(np.arange(len(times))[:, np.newaxis], times.shape)  # of the wind
        position = (times - ends[0]) / (ends[1] - ends[0])  # in steps, which are even
        demand = march.demand_at(case, position)
        is_paired = np.interp(times, ends, paired[0]) > 0.0
        smaller_size = smaller(trim, demand, sign=None)  # zero where their signs differ
        level = np.where(is_paired, np.abs(trim), smaller_size)
        return np.asarray(level.max(axis=1))

    def with_gusts(
        self, winds: PolylineWinds, sign: float, additions: Additions
    ) -> list[PolylineWinds]:
        """Return winds with a gust: at the time of the largest wind, and of the requirement.

        These are two records of n winds; without a gust the winds themselves. `sign`: sign of wind
        and gust; a wind that never has this sign is without a gust. `additions`: has the gust. At
        the time of the requirement min(trim, demand) is largest, the demand being the limit
        sufficient when held from then on.
        """
        gust, times = additions.gust, winds.times
        if gust is None:
            return [winds]
        angle = sign * self.path.nominal_angle(winds.speeds[self.plane], times, self.plane)
        calm, largest = np.max(angle, axis=1) <= 0.0, np.argmax(angle, axis=1)
        _, equations = self._steps
        middle, attitude_rate = 1, 1  # of begin, middle and end; row of [A b w]
        acceleration = equations.nominal[0, :, middle, attitude_rate]
        # trim per wind angle, -w/b, in each step; its sign is that of the sum
        trim_per_wind = -acceleration[:, -1] / acceleration[:, -2]
        trim_sign = float(np.sign(trim_per_wind.sum())) * sign
        _limit, limit_time = self._limit(self.stepped(winds).curves(), trim_sign)
        gust_speed = additions.gust_speed

        def speed(angle: FloatArray, at: FloatArray) -> FloatArray:
            """Return speeds [m/s] of the gust of n winds at k times `at` [s], ``(n, k)``.

            A gust specified by its speed has this speed at its peak, and its shape elsewhere; a
            gust specified by its angle is the wind that has the angle at each time. `angle`: angles
            of the gust [rad] at the times, without the sign.
            """
            if gust_speed is not None:
                speeds = sign * gust_speed * angle / float(gust.peak)
            else:
                speeds = self.path.speed_of_angle(sign * angle, at, self.plane)
            return np.where(calm[:, np.newaxis], 0.0, speeds)

        return [
            winds.with_gust(gust, self.plane, at, speed)
            for at in (times[np.arange(largest.size), largest], limit_time)
        ]

    def flights(self, winds: PolylineWinds) -> SteppedWinds:
        """Return winds and the calm after them over the finer steps of flights, with the equations.

        Each wind begins at its onset, counted in these steps. The equations of the even steps set
        the length of the calm, which the equations of flights include.
        """
        steps, equations = self._flight_steps
        _, even_equations = self._steps
        # times [s], wind angles [rad] and q/q_n over the steps, and the onset
        *encountered, onset = self.path.encountered(steps, winds, self.plane)
        times, wind, ratio = with_calm_after(even_equations, *encountered)
        return SteppedWinds(equations, times, wind, ratio, onset)


@dataclass(frozen=True, eq=False)
class MarchedWinds:
    """Winds of n soundings in a plane of an interval of a flight, one each, with their bounds.

    `march`: equations of the flight in the plane. `bounds`: bounds of the required deflections.
    """

    march: PlaneMarch
    winds: PolylineWinds
    bounds: Bounds

    def undecided(self, limit: FloatArray) -> tuple[BoolArray, BoolArray]:
        """Return whether n limits [rad] must be flown, and whether they are insufficient, ``(n,)``.

        A limit below the lowest with which a flight may survive is insufficient, one above the
        upper bound sufficient; between, flights decide. `limit`: a limit for each wind, ``(n,)``.
        """
        insufficient = limit < self.bounds.lowest
        undecided = (self.bounds.upper > limit) & ~insufficient
        return undecided, insufficient

    def survive(self, limit: FloatArray, cases: IndexArray) -> BoolArray:
        """Return whether flights survive with limits [rad] and all above them, ``(cases,)``.

        `limit`: a limit for each of the n winds, ``(n,)``, those that are not flown included.
        `cases`: indices of the winds that are flown. The bounds, lower and upper, of the required
        deflection [rad] decide flights whose limit lies outside them.
        """
        flights = self.march.flights(self.winds.select(cases))
        return flights.survive(limit[cases], self.bounds.upper[cases], self.bounds.lower[cases])

    def requirement(self, cases: IndexArray) -> FloatArray:
        """Return the required deflections [rad] of winds, ``(cases,)``.

        The curves of trim and demand give a lower bound, which is the requirement where the upper
        bound `upper` is not above `lowest`, the limit below which no flight survives. Elsewhere it
        is the smallest limit that survives when flown, searched from there up to `highest`, a limit
        that the law never reaches. `cases`: indices of the winds.
        """
        b, required = self.bounds, self.bounds.lower[cases]
        undecided = np.flatnonzero((b.upper > b.lowest)[cases])
        if undecided.size:
            flown = cases[undecided]
            flights = self.march.flights(self.winds.select(flown))
            required[undecided] = flights.requirement(b.lowest[flown], b.highest[flown])
        return required
