"""Steps of mean and covariance of a loop over time.

The vehicle starts at rest, or where turbulence has long acted on it. A step is the exponential of a
constant system that equals the varying one to fourth order; behind it a sampled autopilot may jump.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tvclin.base.arrays import FloatArray, IndexArray
from tvclin.base.errors import InputError, instance, single
from tvclin.control.turbulence.driven_loop import DrivenLoop, Jump
from tvclin.control.turbulence.varying_loop import VaryingLoop
from tvclin.numerics.covariance import constant_over_steps, stationary_covariance, steps
from tvclin.numerics.propagation import GAUSS_NODES
from tvclin.winds.histories import History

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
    """Return the times of a march, with the breakpoints of the wind and the ends of intervals."""
    if wind is not None:
        instance("wind", wind, History, "such as TriangularWind")
        single("wind", wind.batch)
    constant = isinstance(loop, DrivenLoop)
    sample = [_sample_steps(jump) for jump in loop.jumps]
    longest = _STEP_OF_ONE_VEHICLE_S if constant else _STEP_OF_A_FLIGHT_S
    steps_of = np.concatenate(sample) if sample else np.array([longest])
    intervals = (stop - start) / steps_of.sum() - 1e-9
    if intervals * steps_of.size > _MAX_STEPS:
        raise InputError(
            f"a history has up to {_MAX_STEPS} steps; this one would have"
            f" {intervals * steps_of.size:.3g} (a shorter duration)"
        )
    count = int(np.ceil(intervals))
    if sample:
        grid = start + np.concatenate([[0.0], np.cumsum(np.tile(steps_of, count))])
        return grid if constant else grid[grid <= stop + _CLOSE_TIMES_S]
    breaks = np.zeros(0) if wind is None else np.real(wind.pieces.knots)
    even = np.linspace(start, stop, count + 1)
    grid = np.unique(np.concatenate([even, breaks[(breaks > start) & (breaks < stop)]]))
    close = np.diff(grid) < 1e-9 * max(stop, 1.0)
    return np.asarray(grid[np.concatenate([[True], ~close])])


def _sample_steps(jump: Jump) -> FloatArray:
    """Return the lengths of the steps ahead of a jump of a sampled autopilot [s]."""
    count = max(int(np.ceil(jump.length / _STEP_BETWEEN_SAMPLES_S - 1e-9)), 1)
    return np.full(count, jump.length / count)


class Moments(NamedTuple):
    """Mean and covariance of the states of a loop over time.

    `wind`: the known wind at the times ``(n,)``. `means` ``(n, states)``, `covariances` ``(n,
    states, states)``. `chosen`: indices of times, up to 400, evenly spread; `transitions`: of the
    states from each of these times to the next.
    """

    wind: FloatArray
    means: FloatArray
    covariances: FloatArray
    chosen: IndexArray
    transitions: FloatArray


def march(
    loop: DrivenLoop | VaryingLoop,
    times: FloatArray,
    wind: History | None,
    start: FloatArray | None = None,
) -> Moments:
    """Return the moments of the states at the times.

    `start`: covariance at the first time, behind its sample; by default that of a vehicle at rest
    and a stationary filter.
    """
    known = np.zeros(times.size) if wind is None else np.asarray(wind(times))
    first_loop = loop if isinstance(loop, DrivenLoop) else loop.at(times[:1]).mapped(np.squeeze)
    n = first_loop.A.shape[-1]
    P, mean = np.zeros((n, n)), np.zeros(n)
    filtered = first_loop.filter_states
    P[filtered, filtered] = stationary_covariance(
        *(matrix[filtered, filtered] for matrix in (first_loop.A, first_loop.noise))
    )
    if loop.jumps:
        mean, P = _jumped(_jumps(loop, len(loop.jumps) - 1, times[:1])[0], mean, P, known[0])
    P = P if start is None else start
    means, covariances = np.zeros((times.size, n)), np.zeros((times.size, n, n))
    covariances[0], means[0] = P, mean
    spread = np.linspace(times[0], times[-1], min(_MAX_CHOSEN, times.size))
    chosen = np.unique(np.clip(np.searchsorted(times, spread - _CLOSE_TIMES_S), 0, times.size - 1))
    is_chosen = np.isin(np.arange(times.size), chosen)
    transitions, passed = [], np.eye(n)
    for first in range(0, times.size - 1, _STEPS_AT_ONCE):
        part = times[first : first + _STEPS_AT_ONCE + 1]
        F, Q, forced = _steps(loop, part, wind)
        jumps = _jumps_before(loop, part, first)
        for k, jump in enumerate(jumps, start=first):
            step = F[k - first]
            transition = step
            if jump is not None:
                mean, P = _jumped(jump, mean, P, known[k])
                transition = step @ jump.matrix
            mean = step @ mean + forced[k - first]
            P = step @ P @ step.T + Q[k - first]
            means[k + 1], covariances[k + 1] = mean, P
            passed = transition @ passed
            if is_chosen[k + 1]:
                transitions.append(passed)
                passed = np.eye(n)
    if not np.all(np.isfinite(covariances)) or not np.all(np.isfinite(means)):
        raise InputError(
            f"the motion grows beyond all numbers within {times[-1] - times[0]:.6g} s; the loop is"
            " not stable: take a shorter time"
        )
    return Moments(known, means, covariances, chosen, np.array(transitions))


def _jumped(
    jump: Jump, mean: FloatArray, P: FloatArray, wind: float
) -> tuple[FloatArray, FloatArray]:
    """Return mean and covariance behind a jump."""
    moved = jump.matrix @ mean + jump.wind * wind
    return moved, jump.matrix @ P @ jump.matrix.T + jump.noise


def _jumps(loop: DrivenLoop | VaryingLoop, index: int, times: FloatArray) -> list[Jump]:
    """Return a jump of the loop at each of some times."""
    if isinstance(loop, DrivenLoop):
        return [loop.jumps[index]] * len(times)
    length, *arrays = loop.jump_at(index, times)
    return [Jump(length, *parts) for parts in zip(*arrays, strict=True)]


def _jumps_before(
    loop: DrivenLoop | VaryingLoop, times: FloatArray, first: int
) -> list[Jump | None]:
    """Return the jump ahead of each step between times ``(n + 1,)``, or None.

    `first`: number of the first of the steps; the sample ahead of step 0 is taken already.
    """
    jumps: list[Jump | None] = [None] * (len(times) - 1)
    ends = np.cumsum([_sample_steps(jump).size for jump in loop.jumps])
    numbers = first + np.arange(len(times) - 1)
    for index, end in enumerate(ends):
        ahead = np.flatnonzero((numbers > 0) & (numbers % ends[-1] == end % ends[-1]))
        for k, jump in zip(ahead, _jumps(loop, index, times[ahead]), strict=True):
            jumps[k] = jump
    return jumps


def _steps(
    loop: DrivenLoop | VaryingLoop, times: FloatArray, wind: History | None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return transitions and noise covariances of the steps, and what the known wind adds.

    Steps of a constant loop of one length have one transition.
    """
    lengths, count = np.diff(times), len(times) - 1
    if wind is None and isinstance(loop, DrivenLoop):
        rounded, which = np.unique(np.round(lengths, 12), return_inverse=True)
        F, Q = steps(loop.A, loop.noise, rounded)
        return F[which], Q[which], np.zeros((count, len(loop.A)))
    nodes = [times[:-1] + fraction * lengths for fraction in GAUSS_NODES]
    loops = [loop if isinstance(loop, DrivenLoop) else loop.at(node) for node in nodes]
    n = loops[0].A.shape[-1]
    size = n + (wind is not None)
    A, noise = np.zeros((2, 2, count, size, size))
    for k, (node, at_node) in enumerate(zip(nodes, loops, strict=True)):
        A[k, :, :n, :n], noise[k, :, :n, :n] = at_node.A, at_node.noise
        if wind is not None:
            A[k, :, :n, n] = at_node.wind * np.asarray(wind(node))[:, np.newaxis]
    F, Q = steps(*constant_over_steps((A[0], A[1]), (noise[0], noise[1]), lengths), lengths)
    forced = F[:, :n, n] if wind is not None else np.zeros((count, n))
    return F[:, :n, :n], Q[:, :n, :n], forced
