"""Zeros and minima of functions, for a whole batch at once, and a minimum with kinks and bounds."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from tvclin.base.arrays import FloatArray, IndexArray

Evaluate = Callable[[FloatArray, IndexArray], FloatArray]
"""Values at times ``(k,)`` of the batch elements at the flat positions ``(k,)``."""


def first_crossing(times: FloatArray, values: FloatArray, evaluate: Evaluate) -> FloatArray:
    """Return the first time ``(...)`` at which a function reaches zero from below; inf if never.

    `times`, `values`: samples of the function, ``(..., m)``. `evaluate`: the function itself, from
    times and flat batch positions, both ``(k,)``, to values ``(k,)``. The crossing is between the
    first nonnegative sample and its predecessor, and accurate to rounding. Where these do not
    differ in sign (at the first sample) it is the time of the sample.
    """
    times, values = np.broadcast_arrays(times, values)
    nonnegative = values >= 0.0
    index = np.argmax(nonnegative, axis=-1)[..., np.newaxis]
    low, high = (
        np.take_along_axis(times, np.maximum(index - offset, 0), axis=-1)[..., 0]
        for offset in (1, 0)
    )
    crossings = roots_between(low.ravel(), high.ravel(), evaluate).reshape(high.shape)
    return np.where(np.any(nonnegative, axis=-1), crossings, np.inf)


def roots_between(low: FloatArray, high: FloatArray, evaluate: Evaluate) -> FloatArray:
    """Return the roots of k functions between `low` and `high` ``(k,)``; `high` without a root.

    A value must rise through zero. `evaluate`: from m points ``(m,)`` and the indices of their
    functions, positions in `low`, to values ``(m,)``. By the method of Chandrupatla (1997) as
    `scipy.optimize.elementwise.find_root` has it, whose import takes as long as a whole study:
    inverse quadratic interpolation where three points allow it, else bisection, down to four
    roundings of the root.
    """
    index, root = np.arange(low.size), high.copy()
    begin, end = evaluate(low, index), evaluate(high, index)
    index = np.flatnonzero((begin < 0.0) & (end > 0.0))
    # The newest point, the other end of its bracket and the point before, with their values.
    x1, x2, x3 = low[index], high[index], high[index]
    f1, f2, f3 = begin[index], end[index], end[index]
    for _ in range(_MAX_ITERATIONS):
        best = np.where(np.abs(f1) < np.abs(f2), x1, x2)
        root[index] = best
        width = np.abs(x2 - x1)
        tolerance = 4.0 * (np.abs(best) * np.finfo(float).eps + np.finfo(float).tiny)
        active = (width >= tolerance) & (f1 != 0.0) & (f2 != 0.0)
        if not np.any(active):
            break
        x1, x2, x3, f1, f2, f3, width, tolerance, index = (
            x[active] for x in (x1, x2, x3, f1, f2, f3, width, tolerance, index)
        )
        with np.errstate(all="ignore"):  # of points that coincide, where bisection is taken
            fraction, height = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
            quadratic = f1 / (f1 - f2) * f3 / (f3 - f2) - (x3 - x1) / (x2 - x1) * f1 / (
                f3 - f1
            ) * f2 / (f2 - f3)
            # Chandrupatla's criterion: the inverse quadratic is monotonic in the bracket
            inside = (1.0 - np.sqrt(1.0 - fraction) < height) & (height < np.sqrt(fraction))
        nearest = 0.5 * tolerance / width
        # fraction of the bracket from x1 on, not nearer to its ends than half the tolerance
        x = x1 + np.clip(np.where(inside, quadratic, 0.5), nearest, 1.0 - nearest) * (x2 - x1)
        f = evaluate(x, index)
        same = np.sign(f) == np.sign(f1)
        x3, f3 = np.where(same, x1, x2), np.where(same, f1, f2)
        x2, f2 = np.where(same, x2, x1), np.where(same, f2, f1)
        x1, f1 = x, f
    return root


_MAX_ITERATIONS = 200
"""Iterations of a root: bisection alone takes 55 from a bracket of the size of the root."""


_GRID_POINTS, _REFINEMENTS = 17, 16
"""Points of each grid, and grids, each over two cells of its predecessor: 4e-15 of the first."""


def grid_minimum(
    height: Callable[[FloatArray], FloatArray],
    low: FloatArray,
    high: FloatArray,
    refinements: int = _REFINEMENTS,
    *,
    smooth: bool = False,
) -> tuple[FloatArray, FloatArray]:
    """Return position and value of the minimum of functions between `low` and `high` ``(...)``.

    Each function has one dip. In each of `refinements` rounds a grid spans the neighbours of the
    lowest point of its predecessor. `height`: the functions, from points ``(..., k)`` to values of
    the same shape. A dip narrower than a sixteenth of the range may be missed; a caller with a
    value in it keeps that if it is lower. `smooth`: whether the dips have a second derivative; the
    vertex of the parabola through the last three points then has twice the digits of the grid.
    """
    for _ in range(refinements):
        x = low[..., np.newaxis] + (high - low)[..., np.newaxis] * np.linspace(
            0.0, 1.0, _GRID_POINTS
        )
        values = height(x)
        index = np.argmin(values, axis=-1)[..., np.newaxis]
        low, high = (
            np.take_along_axis(x, np.clip(index + step, 0, _GRID_POINTS - 1), axis=-1)[..., 0]
            for step in (-1, 1)
        )
    at, minimum = (np.take_along_axis(array, index, axis=-1)[..., 0] for array in (x, values))
    if not smooth:
        return at, minimum
    middle = np.clip(index, 1, _GRID_POINTS - 2)
    before, lowest, after = (
        np.take_along_axis(values, middle + step, axis=-1) for step in (-1, 0, 1)
    )
    with np.errstate(all="ignore"):
        offset = 0.5 * (before - after) / (before - 2.0 * lowest + after)
    offset = np.where(np.abs(offset) < 1.0, offset, 0.0) * (x[..., 1:2] - x[..., :1])
    vertex = np.take_along_axis(x, middle, axis=-1) + offset
    height_of_vertex = height(vertex)[..., 0]
    lower = height_of_vertex < minimum
    return np.where(lower, vertex[..., 0], at), np.where(lower, height_of_vertex, minimum)


Values = Callable[[FloatArray, FloatArray], FloatArray]
"""Function from points ``(n, axes)`` and the values of a pool to the values of the points."""

POOL = 24
"""Number of best points in a pool, whose differences are the directions of new points."""
_LEADERS = 8
"""Number of best points of a pool from which new points start."""
_STRIDES = (0.4, 1.3)
"""Range of a stride, in differences of points, so that a pool neither freezes nor scatters."""
_LOCAL_WIDTH = 0.1
"""Width of the first points around known points, as a fraction of the box."""


def box_minimum(
    values: Values,
    axes: int,
    *,
    initial: int,
    per_round: int,
    rounds: int,
    start: FloatArray | None = None,
    over_box: bool = True,
    islands: int = 3,
    tolerance: float = 3e-6,
) -> tuple[FloatArray, FloatArray]:
    """Return the best points of the unit box, ``(POOL, axes)``, and their values, best first.

    Even points over the box (Sobol's); then in each round new ones, a + stride (b - c), from a
    leader a and the difference of two of the pool, which lies along the walls and valleys that the
    pool contains (after Storn and Price's differential evolution, but each round is one call and
    the best of all go on). At first there is a pool for each interval of the first axis, so that a
    wide valley does not hide a narrow one; their best go on together.

    `values`: function from points ``(n, axes)`` and the values of the pool, ``(POOL,)``, to the
    values of the points, ``(n,)``. `axes`: number of axes of the box. `initial`, `per_round`,
    `rounds`: points over the box, points in a round, rounds. `start`: points to start from, from
    another source, ``(n, axes)``. `over_box`: whether the first points are over the whole box, or
    around the known points. `islands`: number of pools that first evolve by themselves.
    `tolerance`: difference of the values of a pool at which it has converged.
    """
    from scipy.stats import qmc  # late: it takes 0.5 s to import

    points = np.asarray(qmc.Sobol(axes, scramble=False).random(initial))
    if start is not None:
        if not over_box:
            points = start[np.arange(initial) % len(start)] + _LOCAL_WIDTH * (points - 0.5)
        points = np.concatenate([start, np.clip(points, 0.0, 1.0)])
    costs = values(points, np.full(POOL, np.inf))
    evolve = partial(_evolved, values, per_round=per_round, rounds=rounds, tolerance=tolerance)
    if over_box and islands > 1:
        best = np.argsort(costs, kind="stable")[: 2 * islands * POOL]
        best = best[np.argsort(points[best, 0], kind="stable")]
        pools = [evolve(points[k], costs[k]) for k in np.array_split(best, islands)]
        points, costs = (np.concatenate(rows) for rows in zip(*pools, strict=True))
    return evolve(points, costs)


def _evolved(
    values: Values,
    points: FloatArray,
    costs: FloatArray,
    *,
    per_round: int,
    rounds: int,
    tolerance: float,
) -> tuple[FloatArray, FloatArray]:
    """Return a pool of points ``(n, axes)`` and its values ``(n,)`` after `rounds`, best first.

    A round adds `per_round` points a + stride (b - c) within the unit box, a being one of the best
    and b and c any two of the pool; the best of all are the next pool. `values`: function from new
    points and the pool's values to their values. `points`, `costs`: the pool before, and its
    values. `tolerance`: difference of a pool's values below which it has converged.
    """
    random = np.random.default_rng(0)  # the same numbers in every call
    for _ in range(rounds):
        order = np.argsort(costs, kind="stable")[:POOL]  # the best first
        points, costs = points[order], costs[order]
        if costs[-1] - costs[0] < tolerance:
            break
        a = random.integers(min(_LEADERS, len(points)), size=per_round)
        b, c = random.integers(len(points), size=(2, per_round))
        new = points[a] + random.uniform(*_STRIDES, size=(per_round, 1)) * (points[b] - points[c])
        new = np.clip(new, 0.0, 1.0)
        points, costs = np.concatenate([points, new]), np.concatenate([costs, values(new, costs)])
    order = np.argsort(costs, kind="stable")[:POOL]
    return points[order], costs[order]
