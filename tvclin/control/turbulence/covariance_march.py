"""Steps of mean and covariance of a loop over time.

The vehicle starts at rest, or where turbulence has long acted on it. A step is the exponential of a
constant system that equals the varying one to fourth order; behind it a sampled autopilot may jump.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, instance, single
from tvclin.control.turbulence.driven_loop import DrivenLoop, Jump
from tvclin.numerics.covariance import constant_over_steps, stationary_covariance, steps
from tvclin.numerics.propagation import GAUSS_NODES
from tvclin.winds.histories import History

_STEP_OF_ONE_VEHICLE_S, _STEP_OF_A_FLIGHT_S = 0.02, 0.05
"""Longest steps [s]."""
_MAX_STEPS = 30_000
"""Steps of a history; more are a duration in the wrong unit."""


def march_times(
    start: float, stop: float, wind: History | None, loop: DrivenLoop | None
) -> FloatArray:
    """Return the times of a march, with the breakpoints of the wind and the ends of intervals."""
    if wind is not None:
        instance("wind", wind, History, "such as TriangularWind")
        single("wind", wind.batch)
    step = _STEP_OF_A_FLIGHT_S if loop is None else _STEP_OF_ONE_VEHICLE_S
    sample = [_sample_steps(jump) for jump in ([] if loop is None else loop.jumps)]
    steps_of = np.concatenate(sample) if sample else np.array([step])
    intervals = (stop - start) / steps_of.sum() - 1e-9
    if intervals * steps_of.size > _MAX_STEPS:
        raise InputError(
            f"a history has up to {_MAX_STEPS} steps; this one would have"
            f" {intervals * steps_of.size:.3g} (a shorter duration)"
        )
    count = int(np.ceil(intervals))
    if sample:
        return start + np.concatenate([[0.0], np.cumsum(np.tile(steps_of, count))])
    breaks = np.zeros(0) if wind is None else np.real(wind.pieces.knots)
    even = np.linspace(start, stop, count + 1)
    grid = np.unique(np.concatenate([even, breaks[(breaks > start) & (breaks < stop)]]))
    close = np.diff(grid) < 1e-9 * max(stop, 1.0)
    return np.asarray(grid[np.concatenate([[True], ~close])])


def _sample_steps(jump: Jump) -> FloatArray:
    """Return the lengths of the steps ahead of a jump of a sampled autopilot [s]."""
    count = 2 * int(np.ceil(jump.length / _STEP_OF_ONE_VEHICLE_S))
    return np.full(count, jump.length / count)


def gauss_times(times: FloatArray) -> list[FloatArray]:
    """Return the times of the two Gauss points of each step, ``(n - 1,)`` each."""
    return [times[:-1] + fraction * np.diff(times) for fraction in GAUSS_NODES]


def march(
    loops: tuple[DrivenLoop, DrivenLoop],
    times: FloatArray,
    wind: History | None,
    shape: tuple[FloatArray, FloatArray],
    start: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return wind, means, covariances and transitions of the states at the times.

    `loops`: at the two Gauss points of each step. `shape`: A and b of the filter, in any measure of
    its time. `start`: covariance at the first time, behind its sample; by default that of a vehicle
    at rest and a stationary filter.
    """
    lengths, nodes = np.diff(times), gauss_times(times)
    loop, n = loops[0], loops[0].A.shape[-1]
    F, Q, forced = _steps(loops, lengths, None if wind is None else [wind(t) for t in nodes])
    P, mean = np.zeros((n, n)), np.zeros(n)
    filtered = slice(loop.order, loop.order + loop.filter_order)
    P[filtered, filtered] = stationary_covariance(shape[0], shape[1] @ shape[1].T)
    known = np.zeros(times.size) if wind is None else np.asarray(wind(times))
    means, covariances = np.zeros((times.size, n)), np.zeros((times.size, n, n))
    transitions = np.empty((len(lengths), n, n))
    jumps = _jumps_before(loop, len(lengths))
    if loop.jumps:
        mean, P = _jumped(loop.jumps[-1], mean, P, known[0])
    P = P if start is None else start
    covariances[0], means[0] = P, mean
    for k, jump in zip(range(len(lengths)), jumps, strict=False):
        step = F[k]
        transitions[k] = step
        if jump is not None:
            mean, P = _jumped(jump, mean, P, known[k])
            transitions[k] = step @ jump.matrix
        mean = step @ mean + forced[k]
        P = step @ P @ step.T + Q[k]
        means[k + 1], covariances[k + 1] = mean, P
    if not np.all(np.isfinite(covariances)) or not np.all(np.isfinite(means)):
        raise InputError(
            f"the motion grows beyond all numbers within {times[-1] - times[0]:.6g} s; the loop is"
            " not stable: take a shorter time"
        )
    return known, means, covariances, transitions


def _jumped(
    jump: Jump, mean: FloatArray, P: FloatArray, wind: float
) -> tuple[FloatArray, FloatArray]:
    """Return mean and covariance behind a jump."""
    moved = jump.matrix @ mean + jump.wind * wind
    return moved, jump.matrix @ P @ jump.matrix.T + jump.noise


def _jumps_before(loop: DrivenLoop, count: int) -> Iterator[Jump | None]:
    """Yield the jump ahead of each step, or None; the first sample is taken already."""
    if not loop.jumps:
        yield from (None for _ in range(count))
        return
    yield None
    for jump in cycle(loop.jumps):
        yield from (None for _ in _sample_steps(jump)[1:])
        yield jump


def _steps(
    loops: tuple[DrivenLoop, DrivenLoop], lengths: FloatArray, winds: list[FloatArray] | None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return transitions and noise covariances of the steps, and what the known wind adds.

    A loop without axes is constant: steps of one length have one transition.
    """
    n, count = loops[0].A.shape[-1], len(lengths)
    varies = loops[0].A.ndim > 2
    if winds is None and not varies:
        rounded, which = np.unique(np.round(lengths, 12), return_inverse=True)
        F, Q = steps(loops[0].A, loops[0].noise, rounded)
        return F[which], Q[which], np.zeros((count, n))
    size = n + (winds is not None)
    A, noise = np.zeros((2, 2, count, size, size))
    for k, loop in enumerate(loops):
        A[k, :, :n, :n], noise[k, :, :n, :n] = loop.A, loop.noise
        if winds is not None:
            A[k, :, :n, n] = loop.wind * winds[k][:, np.newaxis]
    F, Q = steps(*constant_over_steps((A[0], A[1]), (noise[0], noise[1]), lengths), lengths)
    forced = F[:, :n, n] if winds is not None else np.zeros((count, n))
    return F[:, :n, :n], Q[:, :n, :n], forced
