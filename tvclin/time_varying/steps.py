"""Steps over winds and the calm after them, and what vehicles encounter at their ends.

A step is short beside the fastest rate of vehicle and wind; breakpoints of either, where the wind
may jump or its slope changes, are ends of steps. Wind angles and dynamic pressure are sampled at
begin, middle and end of each.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from tvclin.base.arrays import FloatArray, IndexArray
from tvclin.base.errors import InputError
from tvclin.time_varying.equations import Equations
from tvclin.winds.histories import History

STEP = 0.1
"""Length of a step times the fastest rate of vehicle and wind."""
_CALM_OVER_TIME_CONSTANT = 15.0
"""Length of a flight after its wind times the unstable pole. On a quick path the law may diverge
with a limit that survives if it is constant."""
_CALM_STEP_OVER_TIME_CONSTANT = 0.05
"""Largest product of step and fastest rate after the wind."""
_EVEN_STEP = 0.125
"""Length of an even step times the fastest rate, through winds whose breakpoints are not ends.
With the impulse of the wind in each step the largest min(trim, demand) is within a thousandth."""
_MIN_RATE_PER_S = 0.5
"""Smallest rate [1/s] that sets even steps."""
_MIN_EVEN_STEPS = 32
"""Smallest number of even steps."""
MAX_STEPS = 20_000
"""Largest number of steps over one wind."""
_WIND_RATE_FACTOR = 3.0
"""Factor on the rates of a wind, whose curvature sets the error of the parabola of trim."""
_MIN_STEPS = 4
"""Smallest number of steps between two breakpoints of a wind."""


class Motion(Protocol):
    """Equations of vehicles over time: `Equations`, or `FlightMode`."""

    @property
    def fastest(self) -> FloatArray:
        """Inverse of the shortest time constant [1/s] of each vehicle's attitude, ``(n,)``."""

    @property
    def breakpoints(self) -> FloatArray:
        """Breakpoints [s] of the equations, in addition to the breakpoints of the wind."""

    def judged_at(self, ends: FloatArray) -> FloatArray:
        """Return the times [s] at which flights in n winds are judged, ``(n,)``; `ends` [s]."""

    def at_steps(self, times: FloatArray) -> Equations:
        """Return the equations at begin, middle and end of S steps [s], `times` ``(n, S, 3)``."""


class Encounter(Protocol):
    """A wind as vehicles encounter it: `EncounteredWind`, `NominalWind` or `FlightWind`."""

    @property
    def history(self) -> History:
        """A history with the breakpoints and rates of the wind."""

    def at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return wind angles [rad] and q/q_n (q_n: nominal q) at `times` [s], in their shape."""


def step_counts(wind: History, motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Return k + 1 breakpoints [s] of n winds and motion, and the steps between, ``(n, k)``.

    `STEP`, a step times the fastest rate, requires their number; it is rounded up to one of four in
    each octave, so that winds of similar length have the same. `motion`: equations of a vehicle.
    """
    knots = _breakpoints(wind, motion)
    widths = np.diff(knots, axis=-1)
    fastest = _fastest(wind, motion, knots)
    with np.errstate(invalid="ignore"):  # a calm has no breakpoints
        counts = np.maximum(np.ceil(widths * fastest / STEP), _MIN_STEPS)
        quarter = 2.0 ** np.floor(np.log2(counts)) / 4.0  # a quarter of the power of two below
        counts = np.where(widths > 0.0, np.ceil(counts / quarter) * quarter, 0.0 * widths)
    return knots, counts


def _fastest(wind: History, motion: Motion, knots: FloatArray) -> FloatArray:
    """Return the fastest rate [1/s] that sets the steps between k + 1 breakpoints, ``(n, k)``.

    It is that of n winds there and of the motion. `knots`: breakpoints [s] of both, ``(n, k + 1)``.
    """
    # complex rates s [1/s] of the terms e^(s t) of each piece of the wind, zero where it has none
    terms = np.any(wind.pieces.coefficients != 0.0, axis=-1)
    rates = np.where(terms, np.abs(wind.pieces.rates)[..., np.newaxis, :], 0.0)
    by_piece = _WIND_RATE_FACTOR * rates.max(axis=-1, initial=0.0)  # [1/s]
    by_piece = by_piece.reshape(-1, by_piece.shape[-1])
    begins = wind.knots.reshape(-1, 1, wind.knots.shape[-1])
    middles = 0.5 * (knots[:, 1:] + knots[:, :-1])[..., np.newaxis]
    piece = np.maximum(np.sum(begins <= middles, axis=-1) - 1, 0)  # in which each middle lies
    rows = np.broadcast_to(by_piece, (len(piece), by_piece.shape[-1]))
    return np.maximum(motion.fastest[:, np.newaxis], np.take_along_axis(rows, piece, axis=-1))


def _breakpoints(wind: History, motion: Motion) -> FloatArray:
    """Return k + 1 breakpoints [s] of each of n winds and the motion, from its onset on.

    The last one is the time at which the flight is judged, the end of the wind or later. `motion`:
    equations of the vehicles over time. Breakpoints outside are moved to the nearer end.
    """
    knots = wind.knots.reshape(-1, wind.knots.shape[-1])
    onset, end = (np.reshape(x, (-1, 1)) for x in (wind.onset, motion.judged_at(wind.end)))
    more = motion.breakpoints
    more = more[(more > np.min(onset)) & (more < np.max(end))]
    rows = max(len(knots), len(end))
    columns = [np.broadcast_to(x, (rows, x.shape[-1])) for x in (knots, more, end)]
    return np.clip(np.sort(np.concatenate(columns, axis=-1), axis=-1), onset, end)


def step_times(wind: History, motion: Motion, parts: float = 1) -> FloatArray:
    """Return times [s] at begin, middle and end of S steps over each of n winds, ``(n, S, 3)``.

    Breakpoints of winds and motion are ends of steps, which between them are even. `parts`: number
    of substeps of each step, at least 1/4. `InputError` where a wind takes too many steps.
    """
    return np.concatenate(_interval_times(wind, motion, parts), axis=1)


def _interval_times(wind: History, motion: Motion, parts: float) -> list[FloatArray]:
    """Return times [s] of the steps in each interval between two breakpoints.

    An array for each interval, ``(winds, steps, 3)``: begin, middle and end of each step. `motion`:
    equations of a vehicle. `parts`: number of substeps of each step.
    """
    knots, counts = step_counts(wind, motion)
    # of each wind by itself: the largest numbers of all intervals may add up to several times more
    taken = counts.sum(axis=-1)
    if not np.all(taken <= MAX_STEPS):
        lasts, shortest = np.max(wind.end - wind.onset), STEP / _fastest(wind, motion, knots).max()
        raise InputError(
            f"varying parameters can be followed for at most {MAX_STEPS} steps; this wind, which"
            f" lasts {lasts:.4g} s, takes {np.max(taken):.6g}, the shortest of them {shortest:.4g}"
            " s: check the moment of inertia and the forces, or shorten the wind"
        )
    counts = counts.max(axis=0)
    widths, inside = np.diff(knots, axis=-1), np.array([0.0, 0.5, 1.0])
    intervals = []  # times of the steps in each interval between two breakpoints
    for i in np.flatnonzero(counts):
        steps = int(counts[i] * parts)
        fractions = (np.arange(steps)[:, np.newaxis] + inside) / steps
        times = knots[:, i, None, None] + widths[:, i, None, None] * fractions
        times[:, -1, 2] = knots[:, i + 1]  # not beyond, by rounding
        intervals.append(times)
    return intervals


def even_steps(motion: Motion, span: tuple[float, float], parts: int = 1) -> FloatArray:
    """Return times [s] at begin, middle and end of even steps over a span [s], ``(1, S, 3)``.

    `motion`: its fastest rate sets their length. `parts`: number of substeps of each step.
    """
    begin, end = span
    rate = max(motion.fastest.max(), _MIN_RATE_PER_S)
    count = max(int(np.ceil((end - begin) * rate / _EVEN_STEP)), _MIN_EVEN_STEPS)
    ends = np.linspace(begin, end, min(count, MAX_STEPS) * parts + 1)
    return np.stack([ends[:-1], 0.5 * (ends[:-1] + ends[1:]), ends[1:]], axis=-1)[np.newaxis]


def encountered_at_steps(
    motion: Motion, encountered: Encounter | Sequence[Encounter], parts: float = 1
) -> tuple[FloatArray, ...]:
    """Return times [s], wind angles of attack [rad] and q/q_n over steps, ``(n, S, 3)`` each.

    Of n winds at begin, middle and end of S steps; q_n is the nominal q. `motion`: its breakpoints
    and fastest rate set the steps. `encountered`: winds, or a sequence of winds with equally many
    steps. `parts`: substeps of each step. A wind that jumps as a step ends has its value before it.
    """
    if isinstance(encountered, Sequence):
        winds = [encountered_at_steps(motion, wind, parts) for wind in encountered]
        return tuple(np.concatenate(rows) for rows in zip(*winds, strict=True))
    intervals = _interval_times(encountered.history, motion, parts)
    times = np.concatenate(intervals, axis=1)
    last = np.cumsum([interval.shape[1] for interval in intervals]) - 1  # step of each interval
    # a step ends with the value at the begin of the next, but for a jump between two intervals
    just_before = np.maximum(np.nextafter(times[:, last, 2], -np.inf), times[:, last, 1])
    samples = np.concatenate([times[..., :2].reshape(len(times), -1), just_before], axis=1)
    wind, ratio = encountered.at(samples)
    shape = (max(len(times), len(wind), len(motion.fastest)), *times.shape[1:])
    return np.broadcast_to(times, shape), *(_at_ends(x, last, shape) for x in (wind, ratio))


def _at_ends(samples: FloatArray, last: IndexArray, shape: tuple[int, ...]) -> FloatArray:
    """Return values at begin, middle and end of S steps, ``shape (n, S, 3)``, from `samples`.

    They are at begin and middle of all steps, then at the ends of the steps `last`, ``(n, k)`` or
    ``(1, k)``; the other steps end with the value at the begin of the next.
    """
    values, count = np.empty(shape), last.size
    values[..., :2] = samples[:, :-count].reshape(len(samples), -1, 2)
    values[:, :-1, 2] = values[:, 1:, 0]
    values[:, last, 2] = samples[:, -count:]
    return values


def with_calm_after(
    equations: Equations, times: FloatArray, wind: FloatArray, ratio: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return times [s], wind angles [rad] and q/q_n with the calm after the wind, ``(n, S, 3)``.

    `equations`: of n cases, or common to all. `times` [s], `wind` [rad], `ratio`: times, wind
    angles and q/q_n, dynamic pressure over the nominal one, at begin, middle and end of the steps
    over the wind, ``(n, S, 3)``; times may be common, ``(1, S, 3)``.
    """
    count = int(steps_after(equations).max())
    rate = np.where(equations.fastest > 0.0, equations.fastest, 1.0)  # [1/s]
    step = (_CALM_STEP_OVER_TIME_CONSTANT / rate)[:, np.newaxis, np.newaxis]
    # from the end of the last step on
    calm = times[:, -1:, 2:] + step * (np.arange(count)[:, np.newaxis] + [0.0, 0.5, 1.0])
    after = (0, 0), (0, calm.shape[1]), (0, 0)  # widths to pad: behind the steps
    times = np.concatenate([times, calm], axis=1)
    return times, np.pad(wind, after), np.pad(ratio, after, constant_values=1.0)


def steps_after(equations: Equations) -> IndexArray:
    """Return the number of steps after the wind in flights of trim within a limit, ``(n,)``.

    `equations`: of n cases. The calm lasts `_CALM_OVER_TIME_CONSTANT` of the unstable pole, in
    steps of the fastest rate. The number is zero where the flight path is slow beside the attitude
    (not `quick_path`): there a limit that survives the wind also survives the calm.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        # fastest rate over the unstable pole, at least one; NaN without an unstable pole
        rate_over_pole = np.maximum(equations.fastest / np.maximum(equations.end_pole, 0.0), 1.0)
    counts = np.ceil(_CALM_OVER_TIME_CONSTANT / _CALM_STEP_OVER_TIME_CONSTANT) * np.where(
        np.isnan(rate_over_pole), 1.0, np.ceil(rate_over_pole)
    )
    quick = np.broadcast_to(equations.quick_path, counts.shape)
    return np.where(quick, np.minimum(counts, MAX_STEPS), 0.0).astype(int)
