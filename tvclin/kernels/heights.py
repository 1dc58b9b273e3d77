"""When trim first reaches a height, and what the modes still ask for from then on.

A control that trims up to K times its limit L leaves trim at the first time at which that is as
large as K L, to either side. From the state of that time every growing mode p_i asks for the mean

    z_i = p_i integral from t on of e^(-p_i (r - t)) g(r) dr

of the trim g still to come, the demand of `excess` for each mode by itself. Where trim stays below
that height while the wind blows, the control is free from the end of the wind on.
"""

from typing import Any

import numpy as np

from tvclin.kernels.excess import (
    ABOVE,
    ROOM,
    TRIM_DRIVES,
    drift,
    driver,
    of_future,
    parts,
    root,
    state,
    to_come,
)
from tvclin.kernels.source import bare, kernel


@kernel
def at_heights(
    winds: Any, which: Any, numbers: Any, poles: Any, heights: Any, out: Any, first: int, last: int
) -> None:
    """Write the demands of the modes when trim reaches a height, over B times the wind's peak.

    `winds`, `which`: as of `switches.switches`. `numbers`: b1, b2 and q of each case, ``(n, 3)``.
    `poles`: of the modes [1/s], which may be complex, ``(n, m)``. `heights`: over B times the
    wind's peak, positive, ``(n,)``. `out`: demands, ``(n, m)``; where trim stays below the height
    while the wind blows, those at its end.
    """
    knots, coefficients, rates = winds
    kept, ends = np.empty((3, knots.shape[1])), np.empty(ROOM)
    work = np.empty((2, coefficients.shape[3]), coefficients.dtype)
    for case in range(first, last):
        j = which[case]
        b1, b2, q = numbers[case, 0], numbers[case, 1], numbers[case, 2]
        wind = (knots[j], coefficients[j], rates[j], kept, work)
        law = (1.0, 1.0, b2 - b1, b1, q, TRIM_DRIVES)
        drift(wind, law)
        i, u = _reached(wind, law, heights[case], ends)
        x, y = state(wind, law, i, u)
        for k in range(poles.shape[1]):
            p = poles[case, k]
            out[case, k] = of_future(law, p, to_come(wind, i, u, p), x, y)


@bare
def _reached(wind: Any, law: Any, height: float, ends: Any) -> tuple[int, float]:
    """Return the piece and the local time at which the driver's size first is a height or more.

    The end of the wind where it never is.
    """
    knots = wind[0]
    for i in range(knots.size - 1):
        for part in range(parts(wind, law, i, ends)):
            a, b = ends[part], ends[part + 1]
            start, stop = driver(wind, law, i, a)[0], driver(wind, law, i, b)[0]
            if abs(start) >= height:
                return i, a
            if abs(stop) >= height:
                level = height if stop > 0.0 else -height
                return i, root(ABOVE, level, wind, law, i, a, start - level, b, stop - level)
    i = knots.size - 2
    return i, knots[i + 1] - knots[i]
