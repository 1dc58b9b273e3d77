"""Systems in state space, in batches (A, B, C, D): in series, in discrete time, and as delays.

`to_steps` and `from_steps` are the bilinear rule and its inverse (Franklin, Powell and Workman,
Digital Control of Dynamic Systems); a series connection is the same in discrete and in continuous
time. python-control and scipy have them for one system at a time: for 1000 systems of order eight
`scipy.signal.cont2discrete` takes thirty times as long.

The Pade approximation P(s) of order n of a delay has |P| = 1 on the imaginary axis, and with x the
frequency times the delay

    |e^(-j x) - P(j x)| <= c x^(2 n + 1),    c = n!^2/((2 n)! (2 n + 1)!),

from the remainder x^(2 n + 1)/(2 n)! int_0^1 t^n (1 - t)^n e^(-j x t) dt over a denominator that is
at least one there (Baker and Graves-Morris, Pade Approximants, 1996).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import comb, factorial, perm

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray

Matrices = tuple[FloatArray, FloatArray, FloatArray, FloatArray]


def series(first: Matrices, second: Matrices) -> Matrices:
    """Return A, B, C and D of the second system in series behind the first.

    `first`, `second`: A, B, C and D of each, with leading batch axes that broadcast.
    """
    (A1, B1, C1, D1), (A2, B2, C2, D2) = first, second
    n = A1.shape[-1], A2.shape[-1]
    A = stacked(join_columns(A1, np.zeros(n)), join_columns(B2 @ C1, A2))
    return A, stacked(B1, B2 @ D1), join_columns(D2 @ C1, C2), D2 @ D1


def to_steps(system: Matrices, c: FloatArray) -> Matrices:
    """Return A, B, C and D in discrete time by the bilinear rule s = c (z - 1)/(z + 1).

    `system`: A, B, C and D in continuous time. `c`: two over the sampling period, or the value with
    which the rule is exact at one frequency [1/s], ``(...)``.
    """
    A, B, C, D = system
    c = np.asarray(c)[..., np.newaxis, np.newaxis]
    unit = np.eye(A.shape[-1])
    # (s - A)^-1 = (z + 1) (z - Z)^-1 (c - A)^-1 with Z = (c - A)^-1 (c + A)
    inverse = np.linalg.inv(c * unit - A)
    return inverse @ (c * unit + A), 2.0 * c * (inverse @ B), C @ inverse, D + C @ inverse @ B


def from_steps(system: Matrices, half: FloatArray) -> Matrices:
    """Return A, B, C and D in w, z = (1 + w h/2)/(1 - w h/2), of a discrete-time system.

    `system`: its A, B, C and D. `half`: half of the sampling period h [s], ``(...)``.
    """
    A, B, C, D = system
    half = np.asarray(half)[..., np.newaxis, np.newaxis]
    unit = np.eye(A.shape[-1])
    # (z - A)^-1 = (1 - w h/2) (w - W)^-1 (1 + A)^-1/(h/2) with W = (1 + A)^-1 (A - 1)/(h/2)
    inverse = np.linalg.inv(unit + A)
    return inverse @ (A - unit) / half, 2.0 / half * (inverse @ B), C @ inverse, D - C @ inverse @ B


def join_columns(*blocks: FloatArray) -> FloatArray:
    """Return matrices ``(..., n, k)`` side by side, ``(..., n, sum of k)``; batches broadcast."""
    return np.concatenate(_spread(blocks), axis=-1)


def stacked(*blocks: FloatArray) -> FloatArray:
    """Return matrices ``(..., n, k)`` below each other, ``(..., sum of n, k)``; they broadcast."""
    return np.concatenate(_spread(blocks), axis=-2)


def _spread(blocks: Sequence[FloatArray]) -> list[FloatArray]:
    """Return matrices ``(..., n, k)`` with their leading axes broadcast to one common batch."""
    shape = np.broadcast_shapes(*(block.shape[:-2] for block in blocks))
    return [np.broadcast_to(block, (*shape, *block.shape[-2:])) for block in blocks]


_BAND_EDGES = np.array([0.0, *np.geomspace(0.01, 1e3, 41), np.inf])
"""Edges of the frequency bands of the bound, times the delay."""
_MAX_RELATIVE_CHANGE = 0.5
"""Bound of the relative change of 1 + L that counts as less than one despite rounding."""


def pade_delay(delay: float, order: int) -> Matrices:
    """Return A, B, C, D of the Pade approximation e^(-s T) ~ P(s), scaled to poles near 1/T.

    `delay`: T [s]; zero gives a direct connection. `order`: number of poles of P.
    """
    if delay == 0.0:
        return np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.ones((1, 1))
    powers = np.arange(order, -1, -1)  # of s T, later of s T/unit, with which the last number is 1
    denominator = np.array([float(comb(order, k) * perm(2 * order - k, order - k)) for k in powers])
    unit = denominator[-1] ** (1.0 / order)
    denominator /= unit ** powers[::-1]
    numerator = denominator * (-1.0) ** powers
    # controllable canonical form, in which the time unit is T/unit
    A, B = np.eye(order, k=1), np.zeros((order, 1))
    A[-1], B[-1] = -denominator[:0:-1], 1.0
    C = (numerator - numerator[0] * denominator)[np.newaxis, :0:-1]
    return A * unit / delay, B * unit / delay, C, numerator[:1, np.newaxis]


def pade_keeps_stability(
    A: FloatArray, B: FloatArray, C: FloatArray, delay: float, order: int
) -> BoolArray:
    """Return whether a bound proves that the exact delay has the same number of unstable poles.

    Shape ``(...)``; False also where the bound is too coarse. `A`, `B`, `C`: closed loops with the
    Pade approximation P of order `order` in place of the delay, from a disturbance added to the
    command to the command that is fed back, H(s) = C (s - A)^-1 B; ``(..., n, n)``, ``(..., n)``
    and ``(..., n)``. `delay`: T [s].

    With the loop gain L without its delay, 1 + L e^(-s T) = (1 + L P) (1 + H (e^(-s T)/P - 1)) up
    to the sign of H. With |P| = 1 on the imaginary axis, 1 + L e^(-s T) and 1 + L P have as many
    unstable zeros, by Rouche's theorem, if ``|H| |e^(-j omega T) - P| < 1`` at all omega. ``|H|``
    is at most the sum of ``|residue|/|j omega - pole|``, each term of which is largest, in a band
    of frequencies, at the frequency nearest to the pole.
    """
    poles, vectors = np.linalg.eig(A)
    try:
        to_modes = np.linalg.solve(vectors, B[..., np.newaxis])[..., 0]
    except np.linalg.LinAlgError:  # a pole with too few eigenvectors
        return np.zeros(poles.shape[:-1], dtype=bool)
    residues = np.abs(np.einsum("...i,...ij->...j", C, vectors) * to_modes)[..., np.newaxis, :]
    poles = poles[..., np.newaxis, :]
    low, high = _BAND_EDGES[:-1, np.newaxis] / delay, _BAND_EDGES[1:, np.newaxis] / delay
    # distance of |Im pole| from each band of frequencies [rad/s]; zero within the band
    outside = np.maximum(np.maximum(low - np.abs(poles.imag), np.abs(poles.imag) - high), 0.0)
    error_factor = factorial(order) ** 2 / (factorial(2 * order) * factorial(2 * order + 1))
    # |e^(-j omega T) - P| in each band: largest at its upper edge, and at most 1 + |P| = 2
    errors = np.minimum(error_factor * _BAND_EDGES[1:] ** (2 * order + 1), 2.0)
    with np.errstate(divide="ignore", invalid="ignore"):  # poles on the imaginary axis
        changes = errors * np.sum(residues / np.hypot(poles.real, outside), axis=-1)
    return np.asarray(np.all(changes < _MAX_RELATIVE_CHANGE, axis=-1))
