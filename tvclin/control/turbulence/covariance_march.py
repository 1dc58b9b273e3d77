"""Steps of mean and covariance of a loop over time.

The vehicle starts at rest, or where turbulence has long acted on it. A step is the exponential of a
constant system that equals the varying one to fourth order; behind it a sampled autopilot may jump.

Between the breakpoints of vehicle, structure and gains along a flight each entry of the matrices is
a smooth function of time, which differs little from a polynomial over a part of a second: one
through five Lobatto points of an interval. It is compared with the loop itself at a further time,
and an interval with another value there is halved.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.base.errors import InputError, instance, single
from tvclin.control.turbulence.driven_loop import DrivenLoop, Jump, Signal
from tvclin.numerics.covariance import constant_over_steps, stationary_covariance, steps
from tvclin.numerics.propagation import GAUSS_NODES
from tvclin.winds.histories import History

_POINTS = 0.5 - 0.5 * np.cos(np.pi * np.arange(5) / 4.0)
"""Lobatto points of an interval of unit length."""
_COEFFICIENTS = np.linalg.inv(np.vander(_POINTS))
"""Coefficients of the polynomial through values at these points, highest power first."""
_CHECKED_POINT = 0.32
"""Position in an interval at which the polynomial is compared."""
_MAX_INTERVAL_S, _MAX_HALVINGS = 1.0, 6
"""Longest interval [s], and how often one is halved."""
_TOLERANCE, _ROUNDING = 1e-9, 1e-13
"""Largest error of an entry, relative to its largest value, and to the largest of its matrix."""


class VaryingLoop:
    """Driven loop as a function of time.

    `loop_at`: loops at times [s] ``(n,)``. `breaks`: rising times, from the first to the last, with
    the breakpoints of the data between.
    """

    def __init__(self, loop_at: Callable[[FloatArray], DrivenLoop], breaks: FloatArray) -> None:
        """Set starts and lengths [s] of intervals, and loops at the five nodes of each.

        Intervals between `breaks` [s] are halved until interpolation reproduces the loops.
        """
        self._starts, self._lengths, self._nodes = _interpolated(loop_at, breaks)

    @property
    def jumps(self) -> tuple[Jump, ...]:
        """Jumps of a sampled autopilot at all nodes."""
        return self._nodes.jumps

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the outputs."""
        return self._nodes.labels

    def at(self, times: FloatArray) -> DrivenLoop:
        """Return the loops at times [s], a batch ``(n,)``, without their jumps."""
        smooth = replace(self._nodes, jumps=())
        return smooth.mapped(lambda values: self._interpolated(values, times))

    def jumps_at(self, index: int, times: FloatArray) -> list[Jump]:
        """Return the jumps behind the interval `index` of a sample, one at each of n times [s].

        The `length` [s] of the interval is constant.
        """
        length, *arrays = self.jumps[index]
        at_times = (self._interpolated(values, times) for values in arrays)
        return [Jump(length, *at_time) for at_time in zip(*at_times, strict=True)]

    def signals(self, times: FloatArray) -> dict[str, Signal]:
        """Return the outputs at times [s] by name, rows ``(n, states)`` or constant ones.

        The rate of an output y = row x, row x' + row' x, has the derivative of the row over time.
        """

        def varying(values: FloatArray) -> FloatArray:
            """Return `values` at the nodes, ``(nodes, ...)``, at the n times [s], ``(n, ...)``.

            If they are equal at all nodes they are returned once, without the axis n.
            """
            constant = np.all(values == values[0])
            return values[0] if constant else self._interpolated(values, times)

        signals = {}
        for output in self.labels:
            row, direct, rate = self._nodes.signal(output)  # at the nodes
            if rate is not None:
                rate_row, rate_direct = map(varying, rate)  # row x' as such a sum
                if np.any(row != row[0]):
                    rate_row = rate_row + self._interpolated(row, times, slopes=True)
                rate = rate_row, rate_direct
            signals[output] = Signal(varying(row), varying(direct), rate)
        return signals

    def _interpolated(
        self, values: FloatArray, times: FloatArray, *, slopes: bool = False
    ) -> FloatArray:
        """Return values ``(nodes, ...)``, or their `slopes`, at m times [s], ``(m, ...)``.

        By the polynomial through the nodes of each interval. Constant entries are exact; beyond the
        intervals all are constant.
        """
        index = np.maximum(np.searchsorted(self._starts, times, side="right") - 1, 0)
        lengths = self._lengths[index, np.newaxis]
        x = np.clip((times - self._starts[index])[:, np.newaxis] / lengths, 0.0, 1.0)
        flat = values.reshape(-1, len(_POINTS), values[0].size)  # interval, node of it, entry
        varies = np.any(flat != flat[0, 0], axis=(0, 1))
        result = np.tile(np.zeros_like(flat[0, 0]) if slopes else flat[0, 0], (len(times), 1))
        polynomials = np.tensordot(_COEFFICIENTS, flat[..., varies], axes=(1, 1))[:, index]
        if slopes:  # derivatives of powers 4 to 1, over the length of the interval
            polynomials = polynomials[:-1] * np.arange(4.0, 0.0, -1.0)[:, np.newaxis, np.newaxis]
            polynomials /= lengths
        result[:, varies] = np.polyval(polynomials, x)
        return result.reshape(len(times), *values.shape[1:])


def _interpolated(
    loop_at: Callable[[FloatArray], DrivenLoop], breaks: FloatArray
) -> tuple[FloatArray, FloatArray, DrivenLoop]:
    """Return starts and lengths of the intervals [s], and the batch of loops at all nodes.

    `loop_at`: loops at times [s] ``(n,)``. `breaks`: rising times [s] between which the loops are
    smooth. Each interval has five nodes; it is halved, six times at most, while the polynomial
    through them differs from the loop at a further, checked point.
    """
    # Less 1e-9: rounding makes no interval more.
    counts = np.maximum(np.ceil(np.diff(breaks) / _MAX_INTERVAL_S - 1e-9), 1.0).astype(int)
    lengths = np.repeat(np.diff(breaks) / counts, counts)
    starts = breaks[0] + np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    points = np.append(_POINTS, _CHECKED_POINT)
    taken_starts, taken_lengths, taken_loops = [], [], []  # of intervals that fit
    for halving in range(_MAX_HALVINGS + 1):
        times = starts[:, np.newaxis] + lengths[:, np.newaxis] * points
        loops = loop_at(times.ravel())
        fits = _fits(loops, times.shape) | (halving == _MAX_HALVINGS)
        # Intervals that fit are taken with their nodes, without the checked point.
        nodes = np.arange(times.size).reshape(times.shape)[fits, :-1].ravel()
        taken_starts.append(starts[fits])
        taken_lengths.append(lengths[fits])
        taken_loops.append(loops.mapped(lambda a, index=nodes: a[index]))  # type: ignore[misc]
        if np.all(fits):
            break
        half = 0.5 * lengths[~fits]
        starts = np.concatenate([starts[~fits], starts[~fits] + half])
        lengths = np.concatenate([half, half])
    starts, lengths = np.concatenate(taken_starts), np.concatenate(taken_lengths)
    order = np.argsort(starts)
    nodes = (order[:, np.newaxis] * len(_POINTS) + np.arange(len(_POINTS))).ravel()
    return starts[order], lengths[order], _joined(taken_loops, nodes)


def _joined(loops: list[DrivenLoop], order: IndexArray) -> DrivenLoop:
    """Return several batches of loops as one batch, in a new order.

    `order`: indices of the loops, counted over all batches one behind another.
    """
    arrays_of_all = zip(*(loop.arrays for loop in loops), strict=True)
    joined = (np.concatenate(arrays)[order] for arrays in arrays_of_all)
    return loops[0].mapped(lambda _: next(joined))  # takes the arrays in the same order


def _fits(loops: DrivenLoop, shape: tuple[int, ...]) -> BoolArray:
    """Return for each interval whether the polynomials through its nodes fit a further point.

    `loops`: batch of loops at the five nodes of each interval, and behind them at the further,
    checked point. `shape`: numbers of intervals and of points in each, 6. An error counts as none
    up to 1e-9 of the largest value of its entry, plus 1e-13, rounding, of that of its matrix.
    """
    fits = np.ones(shape[0], bool)
    # weights of the values at the five nodes in the polynomial's value at the checked point
    weights = np.polyval(_COEFFICIENTS, _CHECKED_POINT)
    for array in loops.arrays:
        values = array.reshape(*shape, -1)
        errors = np.abs(np.tensordot(values[:, :-1], weights, axes=(1, 0)) - values[:, -1])
        sizes = np.abs(values).max(axis=(0, 1), initial=0.0)
        fits &= np.all(errors <= _TOLERANCE * sizes + _ROUNDING * sizes.max(initial=0.0), axis=1)
    return fits


_STEP_OF_ONE_VEHICLE_S, _STEP_OF_A_FLIGHT_S, _STEP_BETWEEN_SAMPLES_S = 0.02, 0.05, 0.01
"""Longest steps [s]."""
_MAX_STEPS = 30_000
"""Steps of a history; more are a duration in the wrong unit."""
_STEPS_AT_ONCE = 500
"""Steps whose matrices are in memory at one time."""
_MAX_CHOSEN = 400
"""Times of the double integral of a travel's variance."""
_CLOSE_TIMES_S = 1e-9
"""Times this close are equal."""


def march_times(
    start: float, stop: float, wind: History | None, loop: DrivenLoop | VaryingLoop
) -> FloatArray:
    """Return the times [s] of the steps of a covariance from `start` to `stop`, ``(n,)``.

    Without samples they include the breakpoints of the `wind`; of a sampled `loop` they are the
    ends of the intervals of its samples, with even steps between, and those of a constant loop end
    with the sample that contains `stop`. `InputError` for a wind that is no single history, and for
    more than 30,000 steps.
    """
    if wind is not None:
        instance("wind", wind, History, "such as TriangularWind")
        single("wind", wind.batch)
    constant = isinstance(loop, DrivenLoop)
    longest = _STEP_OF_ONE_VEHICLE_S if constant else _STEP_OF_A_FLIGHT_S
    # lengths [s] of the steps up to each jump of the states in a sample, or of one step
    steps_by_interval = [_steps_before(jump) for jump in loop.jumps] or [np.array([longest])]
    lengths = np.concatenate(steps_by_interval)
    repetitions = (stop - start) / lengths.sum() - 1e-9  # rounding adds none
    if repetitions * lengths.size > _MAX_STEPS:
        raise InputError(
            f"a history has up to {_MAX_STEPS} steps; this one would have"
            f" {repetitions * lengths.size:.3g} (a shorter duration)"
        )
    count = int(np.ceil(repetitions))
    if loop.jumps:
        grid = start + np.concatenate([[0.0], np.cumsum(np.tile(lengths, count))])
        return grid if constant else grid[grid <= stop + _CLOSE_TIMES_S]
    breaks = np.zeros(0) if wind is None else np.real(wind.pieces.knots)
    even = np.linspace(start, stop, count + 1)
    grid = np.unique(np.concatenate([even, breaks[(breaks > start) & (breaks < stop)]]))
    close = np.diff(grid) < 1e-9 * max(stop, 1.0)  # to the time before: the same one
    return np.asarray(grid[np.concatenate([[True], ~close])])


def _steps_before(jump: Jump) -> FloatArray:
    """Return the lengths [s] of the steps in the interval before a jump, ``(steps,)``.

    They are equal, and 0.01 s at most. `jump`: jump of the states at a sample of the loop, with the
    length of the interval before it.
    """
    count = max(int(np.ceil(jump.length / _STEP_BETWEEN_SAMPLES_S - 1e-9)), 1)
    return np.full(count, jump.length / count)


class Moments(NamedTuple):
    """Mean and covariance of the states of a loop at n times.

    `wind`: the known wind [rad], ``(n,)``. `means` ``(n, states)``, `covariances` ``(n, states,
    states)``. `chosen`: indices of times, up to 400, evenly spread; `transitions`: of the states
    from each of these times to the next; both empty where the times do not follow one another.
    """

    wind: FloatArray
    means: FloatArray
    covariances: FloatArray
    chosen: IndexArray = np.zeros(0, int)
    transitions: FloatArray = np.zeros((0, 0, 0))


def march(
    loop: DrivenLoop | VaryingLoop,
    times: FloatArray,
    wind: History | None,
    start: FloatArray | None = None,
) -> Moments:
    """Return mean and covariance of the states of a loop at times [s], from the first on.

    Transition matrices are kept between `chosen`, evenly spread times, for the covariance of two.
    `loop`: constant or varying. `times`: rising, of `march_times`. `wind`: known wind [rad], to
    which the mean is the response; without it the mean is zero. `start`: covariance at the first
    time, after its sample, ``(states, states)``; by default that of a vehicle at rest and a
    stationary filter of turbulence. `InputError` for numbers that overflow, of an unstable loop.
    """
    # wind at the times [rad]; a jump, such as a sample of the law, changes the states at one time
    angles = np.zeros(times.size) if wind is None else np.asarray(wind(times))
    first_loop = loop if isinstance(loop, DrivenLoop) else loop.at(times[:1]).mapped(np.squeeze)
    n = first_loop.A.shape[-1]
    # At first the vehicle is at rest, behind a sample, and the filter of turbulence is stationary.
    P, mean = np.zeros((n, n)), np.zeros(n)  # covariance and mean of the states
    z = slice(first_loop.order, first_loop.order + first_loop.filter_order)  # of the filter
    P[z, z] = stationary_covariance(first_loop.A[z, z], first_loop.noise[z, z])
    if loop.jumps:
        # the last jump of a period is the law's sample; before it a delayed command may arrive
        (sample,) = loop.jumps_at(len(loop.jumps) - 1, times[:1])
        mean, P = _jumped(sample, mean, P, angles[0])
    P = P if start is None else start
    means, covariances = np.zeros((times.size, n)), np.zeros((times.size, n, n))
    covariances[0], means[0] = P, mean
    # the first of `times` from each evenly spread time on, equal but for rounding
    even = np.linspace(times[0], times[-1], min(_MAX_CHOSEN, times.size))
    chosen = np.unique(np.clip(np.searchsorted(times, even - _CLOSE_TIMES_S), 0, times.size - 1))
    is_chosen = np.isin(np.arange(times.size), chosen)
    transitions, product = [], np.eye(n)  # from a chosen time to the next, and since the last one
    for first in range(0, times.size - 1, _STEPS_AT_ONCE):
        block = times[first : first + _STEPS_AT_ONCE + 1]
        # a step of the block: x -> F x + forced, and noise Q
        steps_of_block = zip(*_steps(loop, block, wind), strict=True)
        jumps = _jumps_before(loop, block, first)
        for k, ((F, Q, forced), jump) in enumerate(
            zip(steps_of_block, jumps, strict=True), start=first
        ):
            transition = F
            if jump is not None:
                mean, P = _jumped(jump, mean, P, angles[k])
                transition = F @ jump.matrix
            mean, P = F @ mean + forced, F @ P @ F.T + Q
            means[k + 1], covariances[k + 1] = mean, P
            product = transition @ product
            if is_chosen[k + 1]:
                transitions.append(product)
                product = np.eye(n)
    if not np.all(np.isfinite(covariances)) or not np.all(np.isfinite(means)):
        raise InputError(
            f"the motion grows beyond all numbers within {times[-1] - times[0]:.6g} s; the loop is"
            " not stable: take a shorter time"
        )
    return Moments(angles, means, covariances, chosen, np.array(transitions))


def _jumped(
    jump: Jump, mean: FloatArray, P: FloatArray, wind: float
) -> tuple[FloatArray, FloatArray]:
    """Return mean ``(n,)`` and covariance ``(n, n)`` of the states behind a jump.

    `jump`: x -> matrix x + wind alpha_w, plus noise with a covariance. `mean`, `P`: mean and
    covariance before it. `wind`: wind angle alpha_w [rad].
    """
    J = jump.matrix
    return J @ mean + jump.wind * wind, J @ P @ J.T + jump.noise


def _jumps_before(
    loop: DrivenLoop | VaryingLoop, times: FloatArray, first: int
) -> list[Jump | None]:
    """Return the jump of the states at the begin of each of n steps; None where there is none.

    A sample period has one or two intervals, each of several steps and with a jump at its end.
    `loop`: constant or varying; without samples it has no jumps. `times`: ends of the steps [s],
    ``(n + 1,)``. `first`: number of steps from the start of the history to these. The start itself
    has no jump here: its mean and covariance are those behind a sample.
    """
    jumps: list[Jump | None] = [None] * (len(times) - 1)
    numbers = first + np.arange(len(times) - 1)  # steps from the start to the begin of each
    steps_of_intervals = [_steps_before(jump).size for jump in loop.jumps]
    ends = np.cumsum(steps_of_intervals)  # steps from a sample to the end of each interval
    for index, end in enumerate(ends):
        period = ends[-1]  # steps of a sample period
        at = np.flatnonzero((numbers > 0) & (numbers % period == end % period))
        for k, jump in zip(at, loop.jumps_at(index, times[at]), strict=True):
            jumps[k] = jump
    return jumps


def _steps(
    loop: DrivenLoop | VaryingLoop, times: FloatArray, wind: History | None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return F ``(m, n, n)``, Q ``(m, n, n)`` and the forcing g ``(m, n)`` of the wind, of m steps.

    A step of the n states is x -> F x + g plus noise with the covariance Q. `loop`: constant or
    varying. `times`: ends of the steps [s], ``(m + 1,)``. `wind`: known wind [rad]; None: g is
    zero. The wind is one more state, equal to one, so that its column of F is g; what varies within
    a step is taken at its two Gauss points.
    """
    lengths, count = np.diff(times), len(times) - 1
    if wind is None and isinstance(loop, DrivenLoop):
        # One exponential for each length of step, to 1e-12 s.
        rounded, which = np.unique(np.round(lengths, 12), return_inverse=True)
        F, Q = steps(loop.A, loop.noise, rounded)
        return F[which], Q[which], np.zeros((count, len(loop.A)))
    nodes = [times[:-1] + fraction * lengths for fraction in GAUSS_NODES]  # [s], of all steps
    loops = [loop if isinstance(loop, DrivenLoop) else loop.at(node) for node in nodes]
    n = loops[0].A.shape[-1]
    size = n + (wind is not None)
    A, noise = np.zeros((2, 2, count, size, size))  # at the first and the second Gauss point
    for k, (node, at_node) in enumerate(zip(nodes, loops, strict=True)):
        A[k, :, :n, :n], noise[k, :, :n, :n] = at_node.A, at_node.noise
        if wind is not None:
            A[k, :, :n, n] = at_node.wind * np.asarray(wind(node))[:, np.newaxis]
    constant_A, constant_noise = constant_over_steps(tuple(A), tuple(noise), lengths)
    F, Q = steps(constant_A, constant_noise, lengths)
    forced = F[:, :n, n] if wind is not None else np.zeros((count, n))
    return F[:, :n, :n], Q[:, :n, :n], forced
