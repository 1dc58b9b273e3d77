"""A search for the minimum of a function with kinks and bounds, many points at a time."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from tvclin.base.arrays import FloatArray

Values = Callable[[FloatArray, FloatArray], FloatArray]

POOL = 24
"""Best points so far, whose differences say how far and in which direction to go on."""
_LEADERS = 8
"""Of them, from which new points start."""
_STRIDES = (0.4, 1.3)
"""Over a difference: between these, so that the pool neither freezes nor scatters."""
_NEAR = 0.1
"""The first pool around points that are given, over the box."""


def least_points(
    values: Values,
    axes: int,
    *,
    first: int,
    each: int,
    rounds: int,
    known: FloatArray | None = None,
    wide: bool = True,
    islands: int = 3,
    tolerance: float = 3e-6,
) -> tuple[FloatArray, FloatArray]:
    """Return the best points of the unit box and their values, best first.

    Even points over the box (Sobol's); then in each round new ones, a + stride (b - c), from a
    leader a and the difference of two of the pool, which lies along the walls and valleys that the
    pool has found (after Storn and Price's differential evolution, but each round is one call and
    the best of all go on). At first there is a pool for each part of the first axis, so that a wide
    valley does not hide a narrow one; their best go on together.

    `values`: of points ``(n, axes)`` and the values of the pool, ``(POOL,)``: those of the points.
    `axes`: of the box. `first`, `each`, `rounds`: points over the box, points in a round, rounds.
    `known`: points that are good for another reason, ``(n, axes)``, to begin with. `wide`: whether
    the first points are over the whole box, or around those that are known. `islands`: pools that
    first grow by themselves. `tolerance`: a pool whose values differ by less has arrived.
    """
    from scipy.stats import qmc  # late: it takes 0.5 s to import

    points = np.asarray(qmc.Sobol(axes, scramble=False).random(first))
    if known is not None:
        if not wide:
            points = known[np.arange(first) % len(known)] + _NEAR * (points - 0.5)
        points = np.concatenate([known, np.clip(points, 0.0, 1.0)])
    found = values(points, np.full(POOL, np.inf))
    grown = partial(_grown, values, each=each, rounds=rounds, tolerance=tolerance)
    if wide and islands > 1:
        some = np.argsort(found, kind="stable")[: 2 * islands * POOL]
        some = some[np.argsort(points[some, 0], kind="stable")]
        pools = [grown(points[one], found[one]) for one in np.array_split(some, islands)]
        points, found = (np.concatenate(parts) for parts in zip(*pools, strict=True))
    return grown(points, found)


def _grown(
    values: Values,
    points: FloatArray,
    found: FloatArray,
    *,
    each: int,
    rounds: int,
    tolerance: float,
) -> tuple[FloatArray, FloatArray]:
    """The pool that comes of points and their values, best first."""
    random = np.random.default_rng(0)
    for _ in range(rounds):
        order = np.argsort(found, kind="stable")[:POOL]
        points, found = points[order], found[order]
        if found[-1] - found[0] < tolerance:
            break
        a = random.integers(min(_LEADERS, len(points)), size=each)
        b, c = random.integers(len(points), size=(2, each))
        new = points[a] + random.uniform(*_STRIDES, size=(each, 1)) * (points[b] - points[c])
        new = np.clip(new, 0.0, 1.0)
        points, found = np.concatenate([points, new]), np.concatenate([found, values(new, found)])
    order = np.argsort(found, kind="stable")[:POOL]
    return points[order], found[order]
