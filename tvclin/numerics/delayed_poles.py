"""The rightmost poles of a closed loop with its delay, which has infinitely many.

What is on its way through the delay T is a wave v(t, theta), -T <= theta <= 0:

    x' = A x + B v(-T),    dv/dt = dv/dtheta,    v(0) = -C x,

and its values at Chebyshev's points are states like others (Breda, Maset and Vermiglio, SIAM J.
Sci. Comput. 27, 2005). The poles of that are moved to zeros of 1 + L(s) by Newton's steps.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray

_POINTS = 48
"""In the delay; poles with |s| T below half of it have some digits before they are moved."""
_STEPS, _ASIDE, _NEAR = 12, 1e-6, 1e-5
"""Newton's steps, how far aside the slope is taken, and how far a pole may be moved, over 1/T."""


def rightmost_poles(
    A: FloatArray, B: FloatArray, C: FloatArray, delay: float, loop: Callable[[AnyArray], AnyArray]
) -> AnyArray:
    """Return the closed-loop poles [1/s] that are furthest right, falling, as many as are sure.

    `A`, `B`, `C`: of the loop without its delay, ``(n, n)``, ``(n,)`` and ``(n,)``; closed by 1 + L
    = 0. `delay`: T [s], positive. `loop`: L with its delay at complex frequencies ``(m,)`` [1/s].
    """
    n, wave = len(A), _slopes(_POINTS) * (2.0 / delay)
    whole = np.zeros((n + _POINTS, n + _POINTS))
    whole[:n, :n], whole[:n, -1] = A, B
    whole[n:, n:], whole[n:, :n] = wave[1:, 1:], -np.outer(wave[1:, 0], C)
    found = np.linalg.eigvals(whole).astype(complex)
    found = found[np.abs(found) * delay < 0.5 * _POINTS]
    found = found[np.argsort(-found.real)]
    s, size = found.copy(), np.abs(found) + 1.0 / delay
    with np.errstate(all="ignore"):
        for _ in range(_STEPS):
            aside = _ASIDE * size
            slope = (loop(s + aside) - loop(s - aside)) / (2.0 * aside)
            s = s - (1.0 + loop(s)) / slope
        sure = np.abs(s - found) <= _NEAR * size
    s = s[: int(np.argmin(sure)) if not np.all(sure) else s.size]
    return np.where(np.abs(s.imag) < _NEAR**2 * np.abs(s), s.real, s)


def _slopes(count: int) -> FloatArray:
    """The derivatives at Chebyshev's points from 1 down to -1 of a polynomial through them."""
    x = np.cos(np.pi * np.arange(count + 1) / count)
    c = np.ones(count + 1)
    c[[0, -1]] = 2.0
    c *= (-1.0) ** np.arange(count + 1)
    apart = x[:, np.newaxis] - x + np.eye(count + 1)
    slopes = np.outer(c, 1.0 / c) / apart
    return slopes - np.diag(slopes.sum(axis=1))
