"""What is still to come of a wind, discounted: at its onset, and at its largest.

W(t) = p integral from t on of e^(-p (r - t)) f(r) dr is the demand of `excess` for a wind that is
trimmed at once, so W' = p (W - f).
"""

from typing import Any

import numpy as np

from tvclin.kernels.excess import (
    ENOUGH,
    ROOM,
    WIND_DRIVES,
    carry,
    demand,
    driver,
    onset,
    parts,
    root,
    to_come,
)
from tvclin.kernels.source import bare, kernel


@kernel
def largest_futures(winds: Any, which: Any, poles: Any, out: Any, first: int, last: int) -> None:
    """Write p times a wind's discounted future, over its peak, where it is largest.

    At the onset, the largest, and its time [s], to ``out (n, 3)``, for ``poles (n,)`` [1/s]. It
    rises as long as it is above the wind, W' = p (W - f): it is largest at a knot, or where a wind
    that rises comes up to it.
    """
    knots, coefficients, rates = winds
    kept, ends = np.empty((3, knots.shape[1])), np.empty(ROOM)
    work = np.empty((2, coefficients.shape[3]), coefficients.dtype)
    for case in range(first, last):
        i = which[case]
        wind = (knots[i], coefficients[i], rates[i], kept, work)
        law = (poles[case], 1.0, 0.0, 0.0, 0.0, WIND_DRIVES)
        carry(wind, law)
        most, time = _largest_future(wind, law, ends)
        out[case, 0], out[case, 1], out[case, 2] = demand(wind, law, onset(wind), 0.0), most, time


@kernel
def from_onset(winds: Any, which: Any, poles: Any, out: Any, first: int, last: int) -> None:
    """Write the discounted futures of winds at their onset to ``out (n, m)``.

    For ``poles (n, m)`` [1/s], which may be complex.
    """
    knots, c, rates = winds
    for case in range(first, last):
        i = which[case]
        wind = (knots[i], c[i], rates[i], knots, knots)
        for k in range(poles.shape[1]):
            out[case, k] = to_come(wind, onset(wind), 0.0, poles[case, k])


@bare
def _largest_future(wind: Any, law: Any, ends: Any) -> tuple[float, float]:
    """Return the largest demand of the wind itself, and its time."""
    knots = wind[0]
    most, time = -np.inf, 0.0
    for i in range(knots.size - 1):
        here = demand(wind, law, i, 0.0)
        if here > most:
            most, time = here, knots[i]
        for part in range(parts(wind, law, i, ends)):
            a, b = ends[part], ends[part + 1]
            top = driver(wind, law, i, b)[0]
            before = driver(wind, law, i, a)[0] - demand(wind, law, i, a)
            after = top - demand(wind, law, i, b)
            if before < 0.0 < after and top > most:
                u = root(ENOUGH, -np.inf, wind, law, i, a, before, b, after)
                here = demand(wind, law, i, u)
                if here > most:
                    most, time = here, knots[i] + u
    return most, time
