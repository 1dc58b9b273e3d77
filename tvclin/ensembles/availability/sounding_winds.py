"""Winds of soundings along a flight, over even steps, and their growth until launch.

Between levels, and between the rows of a flight, a wind is straight over time. At even steps, whose
ends are not the levels, it is represented by its values at both ends of a step and by

    w(middle) = (6 W/h - w(begin) - w(end))/4,    W = integral of w over the step of length h,

so that the parabola through the three values has the impulse of the wind. The step in which a wind
begins starts at that onset. With the vehicle's speed V and path angle Theta_n of each time, winds w
along the path and c across it, both over V, make

    q/q_n = (cos Theta_n - w)^2 + sin(Theta_n)^2 + c^2,
    sin(alpha_w) = w sin(Theta_n)/sqrt(q/q_n) in pitch,  c/sqrt(q/q_n) in yaw.

Between the balloon and the launch a wind grows, or its required deflection does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.ascent.atmosphere import HIGHEST, LOWEST, standard_atmosphere
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base import errors
from tvclin.base.arrays import BoolArray, FloatArray, IndexArray, IntArray
from tvclin.vehicle.coefficients import PLANES
from tvclin.winds.histories import History
from tvclin.winds.soundings.archive import Soundings, gather
from tvclin.winds.soundings.levels import MAX_WIND_SPEED
from tvclin.winds.soundings.profile import MAX_LEVEL_DISTANCE, checked_flight, longest_interval
from tvclin.winds.wind_angles import MAX_LINEAR_ANGLE, along_from_angle, pressure_in_winds

HALF_DAY = 12.0
"""Time between the soundings of most stations [h]."""


@dataclass(frozen=True, eq=False)
class WindGrowth:
    """A wind speed that is added against the vehicle, with the sign that requires more.

    Parameters
    ----------
    speed : array_like
        Wind speed [m/s], a number for all heights, or one for each of `height`.
    height : array_like, optional
        Heights [m], ascending, straight lines between them; beyond them the nearest.

    Raises
    ------
    InputError
        For negative speeds, and rows of different lengths.
    """

    speed: ArrayLike
    height: ArrayLike | None = None

    def __post_init__(self) -> None:
        """Check the fields, and set them to arrays; `InputError` as the class says."""
        object.__setattr__(self, "speed", errors.nonnegative("speed", self.speed, "m/s"))
        if self.height is None:
            errors.number("speed", self.speed, unit="m/s")
            return
        height = errors.one_row("height", self.height, "m")
        if np.shape(self.speed) != height.shape or np.any(np.diff(height) <= 0.0):
            raise errors.InputError("height must ascend, with one speed for each; check both rows")
        object.__setattr__(self, "height", height)

    def at(self, height: ArrayLike) -> FloatArray:
        """Return the speed [m/s] at heights [m], in their shape."""
        heights, speed = errors.finite("height", height, "m"), np.asarray(self.speed)
        if self.height is None:
            return np.full(heights.shape, speed)
        return np.asarray(np.interp(heights, np.asarray(self.height), speed))


@dataclass(frozen=True)
class PairGrowth:
    """Growth of the requirement until launch, from pairs of soundings of the archive 12 h apart.

    It is the quantile of need(later) - need(earlier) over all pairs 12 h apart, times
    (hours/12)^(1/3): differences of winds grow with the interval as a spectrum with the power -5/3
    has it.

    Parameters
    ----------
    hours : float
        Time from the balloon to the launch [h].
    quantile : float
        Quantile over the pairs, in (0, 1).

    Raises
    ------
    InputError
        For numbers out of range.
    """

    hours: float = HALF_DAY
    quantile: float = 0.95

    def __post_init__(self) -> None:
        """Check the fields; `InputError` for numbers out of range."""
        object.__setattr__(self, "hours", errors.number("hours", self.hours, errors.positive, "h"))
        object.__setattr__(self, "quantile", errors.fraction("quantile", self.quantile))


def growth_of(persistence: Any) -> float | WindGrowth | PairGrowth:
    """Return the growth until launch of an argument `persistence`.

    It is an angle [rad] that the requirement grows by, zero for None; a wind speed that is added
    (`WindGrowth`); or the growth from pairs of soundings (`PairGrowth`), with defaults for "pairs".
    `InputError` for another word, a negative angle and one that is not small.
    """
    if persistence is None:
        return 0.0
    if isinstance(persistence, WindGrowth | PairGrowth):
        return persistence
    if isinstance(persistence, str):
        errors.one_of("persistence", persistence, ("pairs",))
        return PairGrowth()
    return errors.number(
        "persistence", persistence, errors.small_angle("an angle", errors.nonnegative), "rad"
    )


def grown_by(
    growth: PairGrowth, need: FloatArray, times: NDArray[np.datetime64]
) -> tuple[FloatArray, int]:
    """Return the growth [rad] of requirements, ``(a,)``, and the number of pairs.

    `growth`: time until launch, and quantile over the pairs. `need`: required deflections [rad],
    ``(a, n)`` for azimuths and soundings, NaN where unknown. `times`: times of the soundings,
    ``(n,)``. `InputError` where no two soundings are twelve hours apart.
    """
    minutes, interval = times.astype("datetime64[m]").astype(np.int64), round(60 * HALF_DAY)
    order = np.argsort(minutes, kind="stable")
    # the first sounding at least twelve hours after each
    later = np.searchsorted(minutes[order], minutes[order] + interval)
    has_later = later < times.size
    earlier, partner = order[has_later], order[later[has_later]]
    pairs = minutes[partner] - minutes[earlier] == interval
    growths = need[:, partner[pairs]] - need[:, earlier[pairs]]
    growths = growths[:, ~np.isnan(growths).any(axis=0)]
    if not growths.shape[1]:
        raise errors.InputError(
            "persistence from pairs needs soundings 12 h apart that can be judged; there are"
            " none, so give an angle [rad]"
        )
    # differences of a wind with a spectrum of the power -5/3 grow with this power of the interval
    scale = (growth.hours / HALF_DAY) ** (1 / 3)
    return scale * np.quantile(growths, growth.quantile, axis=1), growths.shape[1]


_EDGE_DISTANCE = 0.01
"""Distance [m] of the additional levels from the edges of an unknown wind."""
_SOUNDING_OFFSET = 1e6
"""Offset [m] between the heights of successive soundings, where all are in one array."""
_MIN_WIND_M_PER_S = np.sqrt(np.finfo(float).tiny)
"""Speed [m/s] whose square is below all numbers: a slower wind in a plane counts as calm."""
_GUST_SEGMENTS = 64
"""Number of straight segments that approximate a gust."""


@dataclass(frozen=True, eq=False)
class FlightPath:
    """A flight over height, as arrays ``(f,)``.

    `height` [m], `time` [s], `speed` [m/s], `climb`: flight path angle [rad]. `max_q`: height [m]
    of the largest dynamic pressure, in the standard atmosphere. `pressure`: whether winds count
    with the dynamic pressure that they cause, or the nominal one.
    """

    height: FloatArray
    time: FloatArray
    speed: FloatArray
    climb: FloatArray
    max_q: float
    pressure: bool

    @classmethod
    def of(cls, flight: FlightSchedule, pressure: bool) -> FlightPath:
        """Return the path of a flight; `InputError` without altitude, or where none is gained.

        `pressure`: whether winds count with the dynamic pressure that they cause.
        """
        time, height, speed, climb = checked_flight(flight)
        density = standard_atmosphere(np.clip(height, LOWEST, HIGHEST)).density
        max_q = float(height[np.argmax(density * speed**2)])
        return cls(height, time, speed, climb, max_q=max_q, pressure=pressure)

    def speed_and_climb(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return speed [m/s] and flight path angle [rad] at times [s]."""
        return np.interp(times, self.time, self.speed), np.interp(times, self.time, self.climb)

    def fastest_wind(self, height: FloatArray) -> FloatArray:
        """Return the fastest wind [m/s] that is judged at heights [m], in their shape.

        It is the largest speed that a sounding may have, or less where its angle would be beyond
        linear aerodynamics, above 30 deg.
        """
        flight_speed = np.interp(height, self.height, self.speed)
        # no slower wind turns the airspeed by this angle, in any direction
        return np.minimum(MAX_WIND_SPEED, np.sin(MAX_LINEAR_ANGLE) * flight_speed)

    def nominal_angle(self, wind: FloatArray, times: FloatArray, plane: str) -> FloatArray:
        """Return wind angles [rad] of winds [m/s] at the nominal speed of the flight.

        Of a horizontal wind in the vertical plane of the path only the component normal to the
        path makes an angle, its speed times the sine of the path angle `climb`. `times`: times of
        the winds [s]. `plane`: "pitch" for winds along the path, "yaw" for winds across it.
        """
        speed, climb = self.speed_and_climb(times)
        return _angle(wind / speed * (1.0 if plane == "yaw" else np.sin(climb)))

    def speed_of_angle(self, angle: FloatArray, times: FloatArray, plane: str) -> FloatArray:
        """Return the winds [m/s] that turn the nominal path by angles [rad] at times [s].

        `plane`: "pitch" for winds along the path, "yaw" for those across it. At the dynamic
        pressure encountered the angle is that of the wind triangle, and the wind NaN where no
        horizontal one turns the path so far; at the nominal one it is that at the nominal speed.
        """
        speed, climb = self.speed_and_climb(times)
        if self.pressure:
            return speed * (np.tan(angle) if plane == "yaw" else along_from_angle(climb, angle))
        return speed * np.sin(angle) / (1.0 if plane == "yaw" else np.sin(climb))

    def encountered(
        self, steps: FloatArray, winds: PolylineWinds, plane: str
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return times [s], wind angles of attack [rad], q/q_n, ``(n, S, 3)``, and onsets.

        They are of n winds over even steps, of which the one in which a wind begins starts at the
        wind's onset: its times are its own. q/q_n is the dynamic pressure over the nominal one; an
        onset, where a wind begins, ``(n,)``, is counted in steps: 2.5 is the middle of the third.
        `steps`: times at begin, middle and end [s], ``(1, S, 3)``. `plane`: plane of the angles,
        pitch or yaw, which are at most 30 deg.
        """
        begins, last_end = steps[0, :, 0], steps[0, -1, 2]
        times, along, across, onset = winds.at_steps(np.append(begins, last_end))
        return times, *self.angle_and_pressure(times, along, across, plane), onset

    def angle_and_pressure(
        self, times: FloatArray, along: FloatArray, across: FloatArray, plane: str
    ) -> tuple[FloatArray, FloatArray]:
        """Return wind angles of attack [rad] and q/q_n of winds [m/s] at times [s], in their shape.

        q/q_n is the dynamic pressure over the nominal one; where the nominal one counts it is one,
        and the angles are those at the nominal speed. `along`, `across`: winds along and across the
        path. `plane`: plane of the angles, pitch or yaw.
        """
        speed, climb = self.speed_and_climb(times)
        # wind normal to the path over the nominal speed: at this airspeed the sine of the angle
        sine = along * (np.sin(climb) / speed) if plane == "pitch" else across / speed
        if not self.pressure:
            return _angle(sine), np.ones(sine.shape)
        ratio = pressure_in_winds(climb, along / speed, across / speed)
        # the airspeed in the plane, squared, over the nominal one: pitch has no wind across
        in_plane = pressure_in_winds(climb, along / speed) if plane == "pitch" else ratio
        return _angle(sine / np.sqrt(in_plane)), ratio


def _angle(sine: FloatArray) -> FloatArray:
    """Return angles [rad] of sines, at most `MAX_LINEAR_ANGLE`."""
    largest = np.sin(MAX_LINEAR_ANGLE)
    return np.asarray(np.arcsin(np.clip(sine, -largest, largest)))


@dataclass(frozen=True, eq=False)
class SoundingWinds:
    """Winds of n soundings over height, with two additional levels at the edges of each gap.

    `height`, `east`, `north`: levels [m] and winds towards east and north [m/s], of all soundings
    one after the other. `offsets`: index of the first level of each sounding, and the number of all
    levels, ``(n + 1,)``. `gaps`: index of the lower of both levels in each gap.
    """

    height: FloatArray
    east: FloatArray
    north: FloatArray
    offsets: IntArray
    gaps: IntArray

    @classmethod
    def of(cls, soundings: Soundings, path: FlightPath) -> SoundingWinds:
        """Return the winds of soundings, all usable, with the gaps along the path of a flight.

        A gap is an interval between two levels further apart than `MAX_LEVEL_DISTANCE`. Both levels
        that are added at its edges, just inside, have no wind.
        """
        height, offsets = soundings.height, soundings.offsets
        wide = np.diff(height) > MAX_LEVEL_DISTANCE
        wide &= (height[:-1] < path.height[-1]) & (height[1:] > path.height[0])
        wide[offsets[1:-1] - 1] = False  # between two soundings is no gap
        below = np.flatnonzero(wide)  # level below each gap; two levels are added after it
        at = np.repeat(below + 1, 2)
        edges = height[below] + _EDGE_DISTANCE, height[below + 1] - _EDGE_DISTANCE
        sounding = np.searchsorted(offsets, below, side="right")  # whose gap it is, from one
        added = 2 * np.bincount(sounding, minlength=offsets.size)
        return cls(
            height=np.insert(height, at, np.stack(edges, axis=-1).ravel()),
            east=np.insert(soundings.east, at, 0.0),
            north=np.insert(soundings.north, at, 0.0),
            offsets=offsets + np.cumsum(added[: offsets.size]),
            # the first added level, among all levels
            gaps=below + 1 + 2 * np.arange(below.size),
        )

    def select(self, index: NDArray[np.intp]) -> SoundingWinds:
        """Return the winds of soundings; `index`: their indices, in the order of the result."""
        offsets, levels = gather(self.offsets, index)  # of the result, and indices of its levels
        in_gap = np.zeros(self.height.size, dtype=bool)
        in_gap[self.gaps] = True
        return SoundingWinds(
            height=self.height[levels],
            east=self.east[levels],
            north=self.north[levels],
            offsets=offsets,
            gaps=np.flatnonzero(in_gap[levels]),
        )

    @property
    def bottom(self) -> FloatArray:
        """Lowest level of each sounding [m]."""
        return np.asarray(self.height[self.offsets[:-1]])

    @property
    def top(self) -> FloatArray:
        """Highest level of each sounding [m]."""
        return np.asarray(self.height[self.offsets[1:] - 1])

    def incomplete(self, path: FlightPath) -> BoolArray:
        """Return whether a sounding lacks the wind anywhere along the path of a flight, ``(n,)``.

        It does if it has a gap, or begins above the path, or ends below its top.
        """
        return self.has_gaps | (self.bottom > path.height[0]) | (self.top < path.height[-1])

    @property
    def has_gaps(self) -> BoolArray:
        """Whether a sounding has a gap along the path, ``(n,)``."""
        has_gap = np.zeros(self.offsets.size - 1, dtype=bool)
        # each level belongs to the sounding with the last offset at or below it
        has_gap[np.searchsorted(self.offsets, self.gaps, side="right") - 1] = True
        return has_gap

    def wind(self, azimuth: float, plane: str) -> FloatArray:
        """Return the wind in a plane [m/s] at the levels of all soundings.

        `azimuth`: direction of flight [rad], from north, clockwise. `plane`: "pitch" for the wind
        along the path, positive from behind, "yaw" for that across it, positive from the right.
        Gaps are calm.
        """
        sine, cosine = np.sin(azimuth), np.cos(azimuth)
        wind = self.east * sine + self.north * cosine
        if plane == "yaw":
            wind = self.north * sine - self.east * cosine
        return np.where(np.abs(wind) < _MIN_WIND_M_PER_S, 0.0, wind)

    def linear_heights(self, path: FlightPath, more: Callable[[FloatArray], Any]) -> FloatArray:
        """Return the lowest and the highest height [m] at which winds can be judged, ``(n, 2)``.

        They bound the longest interval of the flight along `path` in which the wind angle is at
        most `MAX_LINEAR_ANGLE`, from any direction; NaN where the interval omits the largest
        dynamic pressure. `more`: function from heights [m] to a wind speed that is added [m/s], as
        of a gust. An end that no too large angle cuts off is the end of the flight.
        """
        height = self.breakpoints(path, entire=False)  # within the levels of each sounding
        wind = np.hypot(
            self.interpolated(self.east, height), self.interpolated(self.north, height)
        ) + more(height)
        steep = wind > np.sin(MAX_LINEAR_ANGLE) * np.interp(height, path.height, path.speed)
        ends = np.tile(path.height[[0, -1]], (height.shape[0], 1))
        for i in np.flatnonzero(steep.any(axis=1)).tolist():
            times = np.interp(height[i], path.height, path.time)
            run = longest_interval(times, ~steep[i])
            ends[i] = np.nan
            if run.start < run.stop:
                low, high = height[i, run.start], height[i, run.stop - 1]
                ends[i, 0] = low if run.start else path.height[0]
                ends[i, 1] = high if run.stop < height.shape[1] else path.height[-1]
        # whether the height of the largest dynamic pressure, `max_q`, is in the interval
        inside = (ends[:, :1] <= path.max_q) & (path.max_q <= ends[:, 1:])
        return np.where(inside, ends, np.nan)

    def unknown(self, height: FloatArray) -> BoolArray:
        """Return whether the wind at heights [m] is not measured, ``(n, k)``.

        `height`: k heights for each sounding, ``(n, k)``. The wind is not measured beyond the
        levels, and in gaps.
        """
        # one within a gap and zero outside, interpolated as a wind is: `gaps` are the first of the
        # two levels that are added at the edges of each gap
        edge = np.zeros(self.height.size)
        edge[self.gaps] = edge[self.gaps + 1] = 1.0
        outside = (height < self.bottom[:, np.newaxis]) | (height > self.top[:, np.newaxis])
        return np.asarray(outside | (self.interpolated(edge, height) > 0.5))

    def breakpoints(self, path: FlightPath, entire: bool) -> FloatArray:
        """Return k heights [m] for each of n soundings: of its levels, and of rows of the flight.

        `path`: path of the flight. The heights are from the lowest to the highest level (`bottom`,
        `top`); if `entire`, along the entire flight, with two more where the wind becomes unknown.
        Soundings with fewer levels repeat heights.
        """
        counts = np.diff(self.offsets)  # levels of each sounding; the last one is repeated
        index = np.minimum(np.arange(counts.max(initial=0)), counts[:, np.newaxis] - 1)
        levels = self.height[self.offsets[:-1, np.newaxis] + index]
        first, last = path.height[0], path.height[-1]
        low, high = (np.clip(end, first, last)[:, np.newaxis] for end in (self.bottom, self.top))
        rows = np.broadcast_to(path.height, (counts.size, path.height.size))
        if entire:
            edges = np.stack([self.bottom - _EDGE_DISTANCE, self.top + _EDGE_DISTANCE], axis=1)
            levels = np.concatenate([levels, edges], axis=1)
            low, high = np.full_like(low, first), np.full_like(high, last)
        return np.sort(np.clip(np.concatenate([levels, rows], axis=1), low, high), axis=1)

    def interpolated(self, wind: FloatArray, height: FloatArray) -> FloatArray:
        """Return winds [m/s] at k heights [m] of each of n soundings, ``(n, k)``.

        Beyond the levels they are constant.
        `wind`: winds at the levels of all soundings, in the order of `height` of this record. Each
        sounding is shifted above the previous, so that one call of `np.interp` serves all.
        """
        shifts = _SOUNDING_OFFSET * np.arange(self.offsets.size - 1)
        inside = np.clip(height, self.bottom[:, np.newaxis], self.top[:, np.newaxis])
        levels = self.height + np.repeat(shifts, np.diff(self.offsets))
        return np.asarray(np.interp(inside + shifts[:, np.newaxis], levels, wind))


@dataclass(frozen=True, eq=False)
class PolylineWinds:
    """Winds along a flight, straight between their times and zero beyond them.

    `times`: times [s] that do not decrease, ``(n, k)``. `speeds`: winds at these [m/s] by plane,
    ``(n, k)``: along the path in pitch, across it in yaw.
    """

    times: FloatArray
    speeds: dict[str, FloatArray]

    def select(self, cases: IndexArray) -> PolylineWinds:
        """Return some of the n winds; `cases`: their indices, in the order of the result."""
        return PolylineWinds(self.times[cases], {k: x[cases] for k, x in self.speeds.items()})

    def at_steps(self, ends: FloatArray) -> tuple[FloatArray, ...]:
        """Return times [s], winds along and across [m/s], and onsets, over even steps.

        Times and winds are at begin, middle and end of steps, ``(n, S, 3)``; the times are ``(1, S,
        3)`` where all winds have the same. The onset of each wind is a real number of steps from
        the first of `ends` on, ``(n,)``. `ends`: begin of the first step and ends of all [s],
        ``(S + 1,)``. The middle value of a step is from the integral of the wind over it, so that
        its parabola has the wind's impulse: 1.5 times the mean over the step, less a quarter of the
        values at both ends. Winds are zero before their first time and after their last; the step
        in which a wind begins starts at its onset.
        """
        knots, (n, k) = self.times, self.times.shape  # n winds of k - 1 straight lines
        steps, length = ends.size - 1, (ends[-1] - ends[0]) / (ends.size - 1)
        position = (knots - ends[0]) / length  # in steps
        onset = np.clip(position[:, 0], 0.0, np.nextafter(float(steps), 0.0))
        # `line`: index of the straight line of each wind on which each end of a step lies, the
        # number of knots not after this end, less one. To count the knots of all winds at once,
        # `next_end` is the index of the first end not before a knot, winds S + 2 places apart.
        next_end = np.clip(np.ceil(position), 0, steps + 1).astype(np.int64)
        next_end += (steps + 2) * np.arange(n)[:, np.newaxis]
        begun = np.bincount(next_end.ravel(), minlength=n * (steps + 2)).reshape(n, steps + 2)
        line = np.clip(np.cumsum(begun, axis=1)[:, :-1] - 1, 0, k - 2)
        flat = line + k * np.arange(n)[:, np.newaxis]  # its index among those of all winds
        within = np.clip(ends, knots[:, :1], knots[:, -1:])
        inside, width = within == ends, np.diff(knots, append=knots[:, -1:])
        after = within - knots.take(flat)  # time [s] since the begin of the line
        late = np.flatnonzero(onset > 0.0)  # winds that begin after the first step does
        begins = np.floor(onset[late]).astype(np.int64)
        times = np.stack([ends[:-1], 0.5 * (ends[:-1] + ends[1:]), ends[1:]], axis=-1)[np.newaxis]
        if late.size:
            times = np.repeat(times, n, axis=0)
            times[late, begins, 0] = knots[late, 0]
            times[late, begins, 1] = 0.5 * (knots[late, 0] + ends[begins + 1])
        both_planes = []
        for wind in (self.speeds[plane] for plane in PLANES):
            rise = np.diff(wind, append=wind[:, -1:])
            slope = np.divide(rise, width, out=np.zeros_like(width), where=width > 0.0)
            areas = width * (wind + 0.5 * rise)  # integral of each line
            begin, slopes = wind.take(flat), slope.take(flat)
            area = np.cumsum(areas, axis=1).take(flat) - areas.take(flat)  # of all lines before
            mean = np.diff(area + (begin + 0.5 * slopes * after) * after) / length
            values = np.where(inside, begin + slopes * after, 0.0)
            samples = np.empty((n, steps, 3))
            samples[..., 0], samples[..., 2] = values[:, :-1], values[:, 1:]
            if late.size:
                samples[late, begins, 0] = wind[late, 0]
                mean[late, begins] /= begins + 1 - onset[late]  # over the part of the step
            samples[..., 1] = 1.5 * mean - 0.25 * (samples[..., 0] + samples[..., 2])
            both_planes.append(samples)
        return times, *both_planes, onset

    def with_gust(
        self,
        gust: History,
        plane: str,
        at: FloatArray,
        speed: Callable[[FloatArray, FloatArray], FloatArray],
    ) -> PolylineWinds:
        """Return the winds with a gust in a plane, whose middle is at the times `at` [s], ``(n,)``.

        `gust`: its wind angle over time. `plane`: "pitch" along the path, "yaw" across it. `speed`:
        function from wind angles [rad] and times [s] of the gust to its speeds [m/s].
        """
        times = self.times
        middle = 0.5 * (gust.onset + gust.end)
        samples = np.linspace(gust.onset, gust.end, _GUST_SEGMENTS + 1)  # in the gust's own time
        inside = np.clip(at[:, np.newaxis] + samples - middle, times[:, :1], times[:, -1:])
        finer = np.sort(np.concatenate([times, inside], axis=1), axis=1)
        gust_times = finer - at[:, np.newaxis] + middle
        angle = np.interp(gust_times, samples, gust(samples), left=0.0, right=0.0)
        speeds = {name: on_lines(times, values, finer) for name, values in self.speeds.items()}
        return PolylineWinds(finer, speeds | {plane: speeds[plane] + speed(angle, finer)})


def on_lines(times: FloatArray, values: FloatArray, at: FloatArray) -> FloatArray:
    """Return values interpolated linearly at times `at` [s], ``(n, j)``.

    `times`, `values`: n rows of ascending times [s] and values at them, ``(n, k)``. Rows are
    shifted, each beyond the row before it, so that one call of `np.interp` serves all.
    """
    shifts = (1.0 + times.max() - times.min()) * np.arange(times.shape[0])[:, np.newaxis]
    return np.interp((at + shifts).ravel(), (times + shifts).ravel(), values.ravel()).reshape(
        at.shape
    )
