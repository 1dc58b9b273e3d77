"""What is still to come of a wind, discounted: at its onset, at its largest, and after trim.

W(t) = p integral from t on of e^(-p (r - t)) f(r) dr is the demand of `excess` for a wind that is
trimmed at once, so W' = p (W - f).

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
    ENOUGH,
    ROOM,
    TRIM_DRIVES,
    WIND_DRIVES,
    carry,
    demand,
    drift,
    driver,
    of_future,
    onset,
    parts,
    root,
    state,
    to_come,
)
from tvclin.kernels.source import bare, kernel

PLAIN, COMPILED = 1e-4, 5e-7
"""Seconds that a breakpoint of a case takes for each rate of its wind, in plain Python and
as machine code."""
ONSET_PLAIN, ONSET_COMPILED = 3e-5, 1e-7
"""The same of `from_onset`, for each pole."""


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
