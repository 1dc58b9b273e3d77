"""Pade approximation of a delay in state space, and whether it leaves a closed loop its stability.

P(s) of order n has |P| = 1 on the imaginary axis, and with x the frequency times the delay

    |e^(-j x) - P(j x)| <= c x^(2 n + 1),    c = n!^2/((2 n)! (2 n + 1)!),

from the remainder x^(2 n + 1)/(2 n)! int_0^1 t^n (1 - t)^n e^(-j x t) dt over a denominator that is
at least one there (Baker and Graves-Morris, Pade Approximants, 1996).
"""

from __future__ import annotations

from math import comb, factorial, perm

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.numerics.state_space import DIRECT, Matrices

_BAND_EDGES = np.array([0.0, *np.geomspace(0.01, 1e3, 41), np.inf])
"""Edges of the frequency bands of the bound, times the delay."""
_MAX_RELATIVE_CHANGE = 0.5
"""Bound of the relative change of 1 + L that counts as less than one despite rounding."""


def pade_delay(delay: float, order: int) -> Matrices:
    """Return A, B, C, D of the Pade approximation of a delay [s], scaled to poles near 1/delay."""
    if delay == 0.0:
        return DIRECT
    powers = np.arange(order, -1, -1)
    denominator = np.array([float(comb(order, k) * perm(2 * order - k, order - k)) for k in powers])
    unit = denominator[-1] ** (1.0 / order)
    denominator /= unit ** powers[::-1]
    numerator = denominator * (-1.0) ** powers
    A, B = np.eye(order, k=1), np.zeros((order, 1))
    A[-1], B[-1] = -denominator[:0:-1], 1.0
    C = (numerator - numerator[0] * denominator)[np.newaxis, :0:-1]
    return A * unit / delay, B * unit / delay, C, numerator[:1, np.newaxis]


def pade_keeps_stability(
    A: FloatArray, B: FloatArray, C: FloatArray, delay: float, order: int
) -> bool:
    """Return whether a bound proves that the exact delay has the same number of unstable poles.

    `A`, `B`, `C`: closed loop with the Pade approximation of order `order`, from what adds to the
    command to the command that returns, H(s) = C (s - A)^-1 B; ``(n, n)``, ``(n,)`` and ``(n,)``.
    `delay`: T [s]. False also where the bound is too coarse.

    1 + L with the exact delay is (1 + L P) (1 + H (e^(-s T)/P - 1)) up to the sign of H, so that by
    Rouche's theorem both have as many unstable zeros where ``|H| |e^(-j omega T) - P| < 1`` on the
    whole axis. ``|H|`` is at most the sum of ``|residue|/|j omega - pole|``, each term of which is
    largest, in a band of frequencies, at the frequency nearest to the pole.
    """
    poles, vectors = np.linalg.eig(A)
    try:
        residues = np.abs((C @ vectors) * np.linalg.solve(vectors, B))
    except np.linalg.LinAlgError:
        return False
    low, high = _BAND_EDGES[:-1, np.newaxis] / delay, _BAND_EDGES[1:, np.newaxis] / delay
    outside = np.maximum(np.maximum(low - np.abs(poles.imag), np.abs(poles.imag) - high), 0.0)
    error_factor = factorial(order) ** 2 / (factorial(2 * order) * factorial(2 * order + 1))
    errors = np.minimum(error_factor * _BAND_EDGES[1:] ** (2 * order + 1), 2.0)
    with np.errstate(divide="ignore", invalid="ignore"):  # of poles on the axis
        changes = errors * np.sum(residues / np.hypot(poles.real, outside), axis=-1)
    return bool(np.all(changes < _MAX_RELATIVE_CHANGE))
