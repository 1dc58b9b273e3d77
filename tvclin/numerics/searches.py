"""Zeros and minima of functions, for a whole batch at once."""

from collections.abc import Callable

import numpy as np

from tvclin.base.arrays import FloatArray, IndexArray

Evaluate = Callable[[FloatArray, IndexArray], FloatArray]
"""Values at times ``(k,)`` of the batch elements at the flat positions ``(k,)``."""


def first_crossing(times: FloatArray, values: FloatArray, evaluate: Evaluate) -> FloatArray:
    """Return the first time at which values ``(..., m)`` reach zero from below; inf if never.

    The time is accurate to rounding. Where a value and its predecessor do not differ in sign, it is
    the time of the sample.
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
    """Return the root between ``low (k,)`` and ``high (k,)``; `high` without a rise through zero.

    By the method of Chandrupatla (1997) as `scipy.optimize.elementwise.find_root` has it, whose
    import takes as long as a whole study: inverse quadratic interpolation where three points allow
    it, else bisection, down to four roundings of the root.
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
        left = (width >= tolerance) & (f1 != 0.0) & (f2 != 0.0)
        if not np.any(left):
            break
        x1, x2, x3, f1, f2, f3, width, tolerance, index = (
            x[left] for x in (x1, x2, x3, f1, f2, f3, width, tolerance, index)
        )
        with np.errstate(all="ignore"):  # of points that coincide, where bisection is taken
            place, height = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
            quadratic = f1 / (f1 - f2) * f3 / (f3 - f2) - (x3 - x1) / (x2 - x1) * f1 / (
                f3 - f1
            ) * f2 / (f2 - f3)
            inside = (1.0 - np.sqrt(1.0 - place) < height) & (height < np.sqrt(place))
        nearest = 0.5 * tolerance / width
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
) -> tuple[FloatArray, FloatArray]:
    """Return position and value of the minimum of functions between `low` and `high` ``(...)``.

    Each function has one dip. Grids are refined, each between the neighbours of the lowest point of
    its predecessor. `height` takes ``(..., k)`` to the same shape. A dip narrower than a sixteenth
    of the range may be missed; a caller with a value in it keeps that if it is lower.
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
    return at, minimum
