"""A search for the minimum of a function with kinks and bounds, many points at a time."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from tvclin.base.arrays import FloatArray

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
    """Return a pool of points ``(n, axes)`` and its values ``(n,)`` after `rounds`, best first."""
    random = np.random.default_rng(0)
    for _ in range(rounds):
        order = np.argsort(costs, kind="stable")[:POOL]
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
