"""Where functions cross zero, and where they are least, for a whole batch at once."""

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
    """Return the root between ``low (k,)`` and ``high (k,)``; `high` without a sign change."""
    from scipy.optimize.elementwise import find_root  # late: it takes 0.3 s to import

    index = np.arange(low.size)
    crossing = (evaluate(low, index) < 0.0) & (evaluate(high, index) > 0.0)
    if not np.any(crossing):
        return high
    result = find_root(evaluate, (low[crossing], high[crossing]), args=(index[crossing],))
    root = high.copy()
    root[crossing] = np.where(result.success, result.x, high[crossing])
    return root


_GRID_POINTS, _REFINEMENTS = 17, 16
"""Points of each grid, and grids, each over two cells of its predecessor: 4e-15 of the first."""


def grid_minimum(
    height: Callable[[FloatArray], FloatArray],
    low: FloatArray,
    high: FloatArray,
    refinements: int = _REFINEMENTS,
) -> tuple[FloatArray, FloatArray]:
    """Return place and value of the minimum of functions between `low` and `high` ``(...)``.

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
