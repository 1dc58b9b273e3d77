"""Where functions of time cross zero, for a whole batch at once."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

Evaluate = Callable[[FloatArray, NDArray[np.intp]], FloatArray]
"""Values at times ``(k,)`` of the batch elements at the flat positions ``(k,)``."""


def first_crossing(times: FloatArray, values: FloatArray, evaluate: Evaluate) -> FloatArray:
    """Return the first time at which values ``(..., m)`` reach zero from below; inf if never."""
    times, values = np.broadcast_arrays(times, values)
    reached = values >= 0.0
    index = np.argmax(reached, axis=-1)
    found = refine(times, index, evaluate)
    return np.where(np.any(reached, axis=-1), found, np.inf)


def refine(times: FloatArray, index: NDArray[Any], evaluate: Evaluate) -> FloatArray:
    """Return the root between ``times[index - 1]`` and ``times[index]``, to rounding.

    Where the ends have no different signs it is the later end.
    """
    from scipy.optimize.elementwise import find_root  # late: it takes 0.3 s to import

    index = index[..., np.newaxis]
    high = np.take_along_axis(times, index, axis=-1)[..., 0]
    low = np.take_along_axis(times, np.maximum(index - 1, 0), axis=-1)[..., 0]
    result = find_root(evaluate, (low.ravel(), high.ravel()), args=(np.arange(high.size),))
    return np.where(result.success, result.x, high.ravel()).reshape(high.shape)
