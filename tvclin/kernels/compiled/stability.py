"""How many closed-loop poles are unstable: one loop at a time, and only where that is certain."""

import math

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.compiled.compiler import lean
from tvclin.kernels.compiled.polynomials import on_axis
from tvclin.kernels.stability import CLOSE, STEPS

FloatArray = NDArray[np.float64]

UNSURE = -1
"""The count of what rounding might change."""
_DOUBT = 1e-10
"""A verdict must bear a change of this part of every coefficient."""
_SLOW = 1e-8
"""A pole slower than this part of the fastest may count as lying at zero."""
_TURN = 2.0 * math.pi
_SAME, _WHOLE = 1e-6, 1e-9
"""A pole that is due within the first [rad] of phase, or of turns within the second, is unsure."""
_NEARLY = 1e-9
"""After such a step of Newton, over the frequency, the next would be rounding."""


@lean
def unstable_roots(p: FloatArray, degree: int, table: FloatArray) -> int:
    """Return the number of roots in the right half plane; `UNSURE` near the edge.

    Routh's table; the last two rows bound what a change of the coefficients does to the others.
    """
    if _has_slow_root(p, degree):
        return UNSURE
    width = degree // 2 + 1
    table[:, : width + 1] = 0.0
    for k in range(degree + 1):
        table[k & 1, k // 2] = p[degree - k]
        table[2 + (k & 1), k // 2] = _DOUBT * abs(p[degree - k])
    count, upper, lower = 0, 0, 1
    for row in range(degree):
        a, b = table[upper, 0], table[lower, 0]
        loose = table[2 + lower, 0]
        if abs(b) <= loose:
            return UNSURE
        if (a > 0.0) != (b > 0.0):
            count += 1
        inverse = 1.0 / b
        ratio = a * inverse
        size = abs(ratio)
        blur = (table[2 + upper, 0] + size * loose) * abs(inverse)
        width = (degree - row) // 2
        for j in range(width):
            x, y = table[upper, j + 1], table[lower, j + 1]
            table[upper, j] = x - ratio * y
            table[2 + upper, j] = (
                table[2 + upper, j + 1]
                + size * table[2 + lower, j + 1]
                + abs(y) * blur
                + _DOUBT * (abs(x) + size * abs(y))
            )
        table[upper, width], table[2 + upper, width] = 0.0, 0.0
        upper, lower = lower, upper
    return count


@lean
def _has_slow_root(p: FloatArray, degree: int) -> bool:
    """Return whether a root may be slow beside the others; no stable one exceeds `fastest`."""
    fastest = abs(p[degree - 1] / p[degree])
    if degree > 1:
        fastest = max(fastest, math.sqrt(abs(p[degree - 2] / p[degree])))
    rest = 0.0
    for k in range(degree, 0, -1):
        rest = (rest + abs(p[k])) * _SLOW * fastest
    return abs(p[0]) <= rest


@lean
def polished(above: FloatArray, m: int, below: FloatArray, n: int, omega: float) -> float:
    """Return a gain crossover after Newton's steps on ln |L| itself, as the numpy twin."""
    for _ in range(STEPS):
        a, a_slope = on_axis(above, m, omega)
        b, b_slope = on_axis(below, n, omega)
        a_square, b_square = a.real**2 + a.imag**2, b.real**2 + b.imag**2
        growth = (b_slope * b.conjugate()).imag / b_square
        growth -= (a_slope * a.conjugate()).imag / a_square
        step = 0.5 * math.log(a_square / b_square) / growth
        if not abs(step) <= CLOSE * omega:
            break
        omega -= step
        if abs(step) <= _NEARLY * omega:
            break
    return omega


@lean
def moved_by_delay(due: float, turned: float, rising: bool) -> int:
    """Return how many poles a delay brings to the right half plane at one gain crossover.

    After Walton and Marshall, as the numpy twin; `UNSURE` where one has hardly begun to move or
    lies on the axis.

    Parameters
    ----------
    due : float
        The phase [rad] of -L without its delay, which the delay has to turn back.
    turned : float
        The phase [rad] that the delay turns.
    rising : bool
        Whether |D| - |N| rises with the frequency.
    """
    due = due % _TURN
    if due < _SAME or due > _TURN - _SAME:
        return UNSURE
    turns = (turned - due) / _TURN
    if turns > -_WHOLE and abs(turns - np.round(turns)) < _WHOLE:
        return UNSURE
    passed = 2 * int(max(math.ceil(turns), 0))
    return passed if rising else -passed
