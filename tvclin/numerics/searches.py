"""Where functions cross zero, and where they are least, for a whole batch at once."""

from collections.abc import Callable

import numpy as np

from tvclin.base.arrays import FloatArray, IndexArray

Evaluate = Callable[[FloatArray, IndexArray], FloatArray]
"""Values at times ``(k,)`` of the batch elements at the flat positions ``(k,)``."""


def first_crossing(times: FloatArray, values: FloatArray, evaluate: Evaluate) -> FloatArray:
    """Return the first time at which values ``(..., m)`` reach zero from below; inf if never.

    To rounding; where a value and the one before it have no different signs, its own time.
    """
    times, values = np.broadcast_arrays(times, values)
    reached = values >= 0.0
    index = np.argmax(reached, axis=-1)[..., np.newaxis]
    low, high = (
        np.take_along_axis(times, np.maximum(index - back, 0), axis=-1)[..., 0] for back in (1, 0)
    )
    found = roots_between(low.ravel(), high.ravel(), evaluate).reshape(high.shape)
    return np.where(np.any(reached, axis=-1), found, np.inf)


def roots_between(low: FloatArray, high: FloatArray, evaluate: Evaluate) -> FloatArray:
    """Return the root between ``low (k,)`` and ``high (k,)``; `high` where there is no rise."""
    from scipy.optimize.elementwise import find_root  # late: it takes 0.3 s to import

    everyone = np.arange(low.size)
    crossing = (evaluate(low, everyone) < 0.0) & (evaluate(high, everyone) > 0.0)
    if not np.any(crossing):
        return high
    result = find_root(evaluate, (low[crossing], high[crossing]), args=(everyone[crossing],))
    root = high.copy()
    root[crossing] = np.where(result.success, result.x, high[crossing])
    return root


_GRID, _ROUNDS = 17, 16
"""Points of a grid that is laid into two cells of the one before: after 16 rounds, 4e-15 of it."""


def lowest(
    height: Callable[[FloatArray], FloatArray],
    low: FloatArray,
    high: FloatArray,
    rounds: int = _ROUNDS,
) -> tuple[FloatArray, FloatArray]:
    """Return where functions with one dip are least between `low` and `high` ``(...)``, and there.

    By grids, each between the neighbours of the lowest point of the one before. `height` takes
    ``(..., k)`` to the same shape. A dip much narrower than a sixteenth of the range may be missed:
    who has a value in it keeps that if it is less.
    """
    for _ in range(rounds):
        x = low[..., np.newaxis] + (high - low)[..., np.newaxis] * np.linspace(0.0, 1.0, _GRID)
        found = height(x)
        best = np.argmin(found, axis=-1)[..., np.newaxis]
        low, high = (
            np.take_along_axis(x, np.clip(best + step, 0, _GRID - 1), axis=-1)[..., 0]
            for step in (-1, 1)
        )
    at, least = (np.take_along_axis(of, best, axis=-1)[..., 0] for of in (x, found))
    return at, least
