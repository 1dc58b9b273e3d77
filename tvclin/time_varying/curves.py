"""Trim and demand of a wind over time, and the deflection limits that follow from both curves.

At begin, middle and end of steps are known the deflection of ideal trim, and the demand, the limit
that is sufficient when it is held from then on. Within a step trim is the parabola of its three
values, the demand Hermite's cubic of two values and slopes. From them follow

- K = 1: the largest over time of min(trim, demand), to either side. Trim that meets the limit for
  the last time at t diverges only if the demand is above the limit then;
- 0 < K < 1: the demand where trim, at a new height, crosses K times the demand for the last time;
- K = 0: the demand at the onset.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.kernels import dead_band as exits
from tvclin.kernels.choice import run
from tvclin.numerics.searches import roots_between

_BOTH_SIGNS_FRACTION = 0.95
"""A law that is limited to one side alone requires at least what trim and demand say: where trim to
the other is below this fraction of that, no flight requires less than the same fraction."""
_UNLIMITED_OVER_TRIM = 1.0 + 1e-3
"""Over the largest trim, a limit that the law never meets."""
_SLOPE_FRACTION = 4.0 / 27.0
"""Largest value in a step of Hermite's cubics of a slope of one, over the length of the step."""
_OPPOSITE_FRACTION = 1e-6
"""A wind angle of the opposite sign below this fraction of the largest counts as zero."""


@dataclass(frozen=True, eq=False)
class Curves:
    """Trim and demand of n winds over their S steps.

    A position in steps counts whole steps and the fraction of the next: 2.5 is the middle of the
    third step.

    Attributes
    ----------
    times, wind : ndarray
        Begin, middle and end of each step [s], and wind angles of attack [rad], ``(n, S, 3)``.
    trim, demand : ndarray
        Deflection of ideal trim, and the limit sufficient when held from then on [rad], there.
    trim_range : ndarray
        Smallest trim, at most zero, and largest, at least zero [rad], of each wind, ``(n, 2)``.
    demand_slope : ndarray
        Slopes of the demand at begin and end of each step [rad/s], ``(n, S, 2)``.
    path : ndarray
        States beyond attitude and rate under trim at the ends of steps, ``(n, S + 1, m - 2)``.
    """

    times: FloatArray
    wind: FloatArray
    trim: FloatArray
    demand: FloatArray
    trim_range: FloatArray
    demand_slope: FloatArray
    path: FloatArray

    def trim_at(self, case: IndexArray, position: FloatArray) -> FloatArray:
        """Return the trim [rad] of cases at positions in steps: 2.5 is the middle of the third."""
        step, u = self._step(position)
        return parabola(self.trim[case, step], u)

    def demand_at(self, case: IndexArray, position: FloatArray) -> FloatArray:
        """Return the demand [rad], the limit sufficient when held from then on, by Hermite's cubic.

        `case`, `position`: index of the wind, and position in steps, of each value.
        """
        step, u = self._step(position)
        begin, _, end = np.moveaxis(self.times[case, step], -1, 0)  # with the middle
        length = end - begin
        return _cubic(self.demand[case, step], self.demand_slope[case, step], length, u)

    def time_at(self, case: IndexArray, position: FloatArray) -> FloatArray:
        """Return the times [s] of cases at positions in steps: 2.5 is the middle of the third."""
        step, u = self._step(position)
        begin, _, end = np.moveaxis(self.times[case, step], -1, 0)  # with the middle
        return np.asarray(begin + u * (end - begin))

    def _step(self, position: FloatArray) -> tuple[IndexArray, FloatArray]:
        """Return index of the step and fraction within it, 0 to 1, of each position in steps."""
        step = np.clip(np.floor(position).astype(int), 0, self.trim.shape[1] - 1)
        return step, position - step

    @cached_property
    def sign(self) -> FloatArray:
        """Sign of the trim deflection of largest size, of each wind, ``(n,)``."""
        return np.asarray(np.sign(self.trim_range.sum(axis=-1)))

    @cached_property
    def has_two_signs(self) -> BoolArray:
        """Whether each of the n winds changes its sign, ``(n,)``."""
        low, high = self.wind.min(axis=(1, 2)), self.wind.max(axis=(1, 2))  # over all steps
        return np.asarray(np.minimum(-low, high) > _OPPOSITE_FRACTION * np.maximum(-low, high))

    @property
    def largest_trim(self) -> FloatArray:
        """Trim along the path: largest size of ideal trim [rad] in each of n winds, ``(n,)``."""
        return np.abs(self.trim_range).max(axis=-1)

    @property
    def onset_demand(self) -> FloatArray:
        """Demand at the onset of each wind [rad], the begin of its first step, ``(n,)``."""
        return self.demand[:, 0, 0]

    @property
    def highest_limit(self) -> FloatArray:
        """Highest deflection limit [rad] worth a trial in each of n winds, ``(n,)``.

        The ideal trim law never reaches it: it is a thousandth above the largest trim and above the
        demand at the end of the wind, the limit sufficient when held from then on.
        """
        final_demand = np.abs(self.demand[:, -1, 2])  # last step, its end
        return np.asarray(_UNLIMITED_OVER_TRIM * np.maximum(self.largest_trim, final_demand))

    def of(self, cases: IndexArray) -> Curves:
        """Return the curves of `cases`, their indices, which rise and do not repeat."""
        if len(cases) == len(self.trim):  # all of them
            return self
        return Curves(*(getattr(self, item.name)[cases] for item in fields(self)))

    def limit_of_trim_law(
        self, paired: BoolArray, sign: float | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Return the largest min(trim, demand) of either sign [rad], and its time [s]: K = 1.

        Both are ``(n,)``, of n winds. The demand is the limit sufficient when held from then on.
        The largest is at the begin, the middle or the end of a step, at the vertex of the parabola
        of trim, or at a crossing of both curves; the last two are searched in steps with a larger
        demand alone. `paired`: where two unstable modes are a pair, so that trim must never be
        limited and counts alone, ``(n, S, 3)``. `sign`: sign of the trim that counts, by default
        either.
        """
        lower = smaller(self.trim, self.demand, sign)
        if np.any(paired):
            lower = np.where(paired, np.abs(self.trim), lower)
        flat = lower.reshape(len(lower), -1)
        largest = np.argmax(flat, axis=-1)
        limit = np.take_along_axis(flat, largest[:, np.newaxis], axis=-1)[:, 0]
        at = 0.5 * (largest % 3) + largest // 3  # position in steps, of three values each
        case, step = np.nonzero(self._largest_demand(sign) > limit[:, np.newaxis])
        summit = step + _vertex(self.trim[case, step])  # in steps whose demand permits more
        crossed, crossing = self._crossings(case, step)
        case, position = np.append(case, crossed), np.append(summit, crossing)
        level = smaller(self.trim_at(case, position), self.demand_at(case, position), sign)
        order = np.argsort(level)
        case, position, level = case[order], position[order], level[order]
        larger = level > limit[case]  # the last of equal cases, the largest, stays
        limit[case[larger]], at[case[larger]] = level[larger], position[larger]
        return limit, self.time_at(np.arange(len(limit)), at)

    def _crossings(self, case: IndexArray, step: IndexArray) -> tuple[IndexArray, FloatArray]:
        """Return the cases and positions in steps at which trim crosses the demand.

        The demand is the limit sufficient when held from then on. `case`, `step`: index of the wind
        and of the step of each of n steps. Each half of them that has a crossing returns one.
        """
        gap = self.trim[case, step] - self.demand[case, step]  # at begin, middle, end, (n, 3)
        row, half = np.nonzero(gap[:, :-1] * gap[:, 1:] < 0.0)  # half of the step: 0 or 1
        rising, low = np.sign(gap[row, half + 1]), step[row] + 0.5 * half
        case = case[row]

        def rises(position: FloatArray, k: IndexArray) -> FloatArray:
            """Return trim minus demand [rad] of crossings `k` at positions in steps, rising.

            It is times -1 where it falls; `case` has the wind of each crossing.
            """
            gap = self.trim_at(case[k], position) - self.demand_at(case[k], position)
            return np.asarray(rising[k] * gap)

        if not case.size:
            return case, low
        # up to just before the end of the half, a position that may count in the next step
        return case, roots_between(low, np.nextafter(low + 0.5, -np.inf), rises)

    @property
    def _lengths(self) -> FloatArray:
        """Lengths [s] of the S steps of n winds, ``(n, S)``."""
        return np.asarray(self.times[..., 2] - self.times[..., 0])

    def _largest_demand(self, sign: float | None) -> FloatArray:
        """Return an upper bound of the demand of n winds in each of S steps [rad], ``(n, S)``.

        The demand is the limit sufficient when held from then on, a cubic by end values and slopes.
        `sign`: sign of the demand that counts; with None its size counts.
        """
        begin, end = self.demand[..., 0], self.demand[..., 2]
        ends = np.maximum(np.abs(begin), np.abs(end))
        if sign is not None:
            ends = np.maximum(sign * begin, sign * end)
        # a slope of one at an end adds at most this fraction of the length of the step
        slopes = np.abs(self.demand_slope).sum(axis=-1)
        return np.asarray(ends + _SLOPE_FRACTION * self._lengths * slopes)  # lengths in s

    def limit_of_dead_band(self, dead_band: float) -> tuple[FloatArray, FloatArray]:
        """Return the limit [rad] with a dead band K < 1, as a size, and the time [s] of its exit.

        Both are ``(n,)`` of n winds; the limit is NaN for a wind of two signs. The demand at a time
        is the limit that is sufficient when held from then on. The dead band is left, and the limit
        held, at a new maximum of trim that is K times the demand: the limit is the demand then. Of
        several such times the last has the largest limit. With K = 0 the exit is the onset.
        """
        if dead_band == 0.0:
            limit = self.sign * self.onset_demand
            return np.where(self.has_two_signs, np.nan, limit), self.times[:, 0, 0]
        return self._exit_from(self.demand, self.demand_slope, dead_band)

    def limit_with_minimum(
        self, minimum: FloatArray, dead_band: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return the limit [rad] and the time [s] of the exit of a dead band 0 < K < 1, ``(n,)``.

        The exit is where trim is K times the peak required from then on: here not `demand`, of a
        constant deflection, but `minimum`, the smallest peak of any deflection that survives from
        the begin and the end of each step on [rad], ``(n, S, 2)``, linear within a step. It is a
        size, which `sign` gives the sign of trim. `dead_band`: K.
        """
        values = np.stack([minimum[..., 0], minimum.mean(axis=-1), minimum[..., 1]], axis=-1)
        sign = self.sign[:, np.newaxis, np.newaxis]
        width = self._lengths[..., np.newaxis]  # [s], zero where two breakpoints coincide
        rise = np.diff(minimum, axis=-1)
        slope = np.divide(rise, width, out=np.zeros_like(rise), where=width > 0.0)
        slopes = np.broadcast_to(slope, minimum.shape)
        return self._exit_from(sign * values, sign * slopes, dead_band)

    def _exit_from(
        self, demand: FloatArray, slope: FloatArray, dead_band: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return the limit [rad] and the time [s] of the exit of a dead band, ``(n,)`` each.

        The exit is where trim reaches K times the limit, which from then on is the demand: the
        smallest limit that, held, survives the rest of the wind. `demand`: demand of n winds at
        begin, middle and end of S steps [rad], ``(n, S, 3)``. `slope`: its
        slope at begin and end [rad/s], ``(n, S, 2)``. `dead_band`: K, above zero. Where trim is in
        the dead band, the limit is the largest trim over K, at the time of the largest trim. The
        limit is NaN for a wind of two signs.
        """
        limit, position = np.empty(len(demand)), np.empty(len(demand))
        arrays = self._lengths, self.trim, demand, slope, self.sign
        work = self._lengths.size
        run(
            exits.dead_band_exits,
            (*(np.require(x, float, ["C", "W"]) for x in arrays), dead_band, limit, position),
            cases=len(demand),
            # estimated run time, which decides between compiled and plain code
            seconds=exits.PLAIN * work,
            compiled_seconds=exits.COMPILED * work,
        )
        stays = position < 0.0  # how the kernel marks that trim stays within the dead band
        largest = np.argmax(self.sign[:, np.newaxis] * self.trim.reshape(len(demand), -1), axis=-1)
        step, sample = np.divmod(largest, 3)  # three samples in each step, half a step apart
        position = np.where(stays, step + 0.5 * sample, position)
        limit = np.where(stays, self.largest_trim / dead_band, limit)
        time = self.time_at(np.arange(len(demand)), position)
        return np.where(self.has_two_signs, np.nan, limit), time

    def trim_ratios(self, dead_band: float) -> FloatArray:
        """Return trim over K [rad] of n winds, ``(n, S + 1)``, at S begins of steps and the end.

        It is the limit with which trim leaves the dead band `dead_band`, K above zero, there.
        Infinite where trim has been larger before, so that it leaves the band there with no limit.
        NaN behind the step of the largest trim: with every limit it has left the band, or never
        does.
        """
        trim = self.sign[:, np.newaxis] * self.trim.reshape(len(self.trim), -1)  # (n, 3 S)
        at_maximum, steps = _new_heights(trim), np.arange(self.trim.shape[1] + 1)
        ratio = np.where(at_maximum, trim / dead_band, np.inf)
        # sample of the largest trim, the last new maximum
        last_sample = trim.shape[1] - 1 - np.argmax(at_maximum[:, ::-1], axis=-1)
        last_step = last_sample // 3 + 1  # end of the step of that sample: three samples each
        at_steps = np.concatenate([ratio[:, ::3], ratio[:, -1:]], axis=-1)
        return np.where(steps > last_step[:, np.newaxis], np.nan, at_steps)

    def is_crossed_twice(self, limit: FloatArray) -> BoolArray:
        """Return whether trim exceeds the limits [rad] of n winds in two or more intervals."""
        above = np.abs(self.trim.reshape(len(self.trim), -1)) > limit[:, np.newaxis]
        begins = above[:, 1:] & ~above[:, :-1]  # of intervals, but for one at the first sample
        return np.asarray(above[:, 0] + np.sum(begins, axis=-1) > 1)

    def reaches_both_signs(self, limit: FloatArray) -> BoolArray:
        """Return whether trim of both signs reaches 95 % of limits [rad] above zero, ``(n,)``."""
        low, high = self.trim_range.T
        return np.asarray(np.minimum(high, -low) > _BOTH_SIGNS_FRACTION * limit) & (limit > 0.0)


def smaller(trim: FloatArray, demand: FloatArray, sign: float | None) -> FloatArray:
    """Return min(|trim|, |demand|) [rad] where both have the same sign; zero elsewhere.

    `trim`, `demand`: deflection of ideal trim, and limit sufficient when held from then on, of one
    shape [rad]. `sign`: sign that both must have; None for either. NaN of the demand stays.
    """
    opposite = (
        trim * demand <= 0.0 if sign is None else np.minimum(sign * trim, sign * demand) <= 0.0
    )
    return np.where(opposite, 0.0, np.minimum(np.abs(trim), np.abs(demand)))  # NaN stays


def _vertex(values: FloatArray) -> FloatArray:
    """Return the fraction of each step at which the parabola of values ``(..., 3)`` turns.

    One half where it does not turn within the step.
    """
    a, b, c = values[..., 0], values[..., 1], values[..., 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        u = (3.0 * a + c - 4.0 * b) / (4.0 * (a - 2.0 * b + c))
    return np.where((u > 0.0) & (u < 1.0), u, 0.5)


def parabola(values: FloatArray, u: FloatArray) -> FloatArray:
    """Return values of a parabola at fractions u of steps.

    `values`: at the fractions 0, 1/2 and 1 of each step, ``(..., 3)``.
    """
    a, b, c = values[..., 0], values[..., 1], values[..., 2]
    return np.asarray(a + u * (4.0 * b - 3.0 * a - c + u * 2.0 * (a - 2.0 * b + c)))


def at_substeps(values: FloatArray, parts: int) -> FloatArray:
    """Return values at begin, middle and end of the substeps of steps, ``(n, parts S, 3)``.

    `values`: of n winds at begin, middle and end of S steps, ``(n, S, 3)``, a parabola within each
    step. `parts`: number of substeps of each step.
    """
    u = (np.arange(parts)[:, np.newaxis] + [0.0, 0.5, 1.0]) / parts
    return parabola(values[:, :, np.newaxis, np.newaxis, :], u).reshape(len(values), -1, 3)


def _cubic(values: FloatArray, slopes: FloatArray, length: FloatArray, u: FloatArray) -> FloatArray:
    """Return values of Hermite's cubic of end values and end slopes, at fractions u of steps.

    `values`: at begin, middle and end of steps, ``(..., 3)``, of which the ends count. `slopes`: at
    begin and end, ``(..., 2)``. `length`: of the steps [s].
    """
    a, b = values[..., 0], values[..., 2]
    # slopes over a step at its begin and its end
    s, e = length * slopes[..., 0], length * slopes[..., 1]
    quadratic, cubic = 3.0 * (b - a) - 2.0 * s - e, 2.0 * (a - b) + s + e
    return np.asarray(a + u * (s + u * (quadratic + u * cubic)))


def _new_heights(trim: FloatArray) -> BoolArray:
    """Return whether trim ``(n, k)`` of n winds at k times is at a new maximum, above zero.

    A tolerance of rounding counts a value equal to the maximum before as new.
    """
    highest = np.maximum.accumulate(trim, axis=-1)
    return np.asarray((trim >= highest * (1.0 - exits.HEIGHT_TOLERANCE)) & (trim > 0.0))
