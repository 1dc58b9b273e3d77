"""Linear equations whose coefficients vary, solved by collocation, for all steps of a mesh at once.

    y' = A(t) y + g(t),    y' = sum of k_j L_j(t),    k_j = A(t_j) y(t_j) + g(t_j)

with the polynomials L_j of Gauss's points t_j of each step. What a step adds to y is linear in the
y that it begins with, so that only y at the mesh itself is followed from step to step.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import leggauss

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError

if TYPE_CHECKING:
    from scipy.interpolate import PPoly


_POINTS = 6
_STEP = 0.25
"""Of the mesh, over the time of the fastest rate: between its times the polynomials of degree 6 are
off by a part of _STEP^7 1e-7, at its times by less."""
_MOST = 20_000
"""Steps of a mesh."""


def mesh(times: FloatArray, rate: float) -> FloatArray:
    """Return increasing times [s] and even ones between, as many as a rate [1/s] asks for.

    `InputError` for more of them than memory and patience take.
    """
    counts = np.maximum(np.ceil(np.diff(times) * rate / _STEP), 1.0)
    if not counts.sum() <= _MOST:
        raise InputError(
            f"varying parameters can be followed for at most {_MOST * _STEP:.4g} times that of the"
            f" fastest motion, {1.0 / rate:.4g} s; this asks for {times[-1] - times[0]:.4g} s:"
            " shorten the winds, or let the vehicle be frozen"
        )
    return refined(times, counts)


def refined(times: FloatArray, counts: FloatArray) -> FloatArray:
    """Return increasing times [s] with so many even steps from each to the next."""
    between = [
        np.linspace(a, b, int(count), endpoint=False)
        for (a, b), count in zip(pairwise(times), counts, strict=True)
    ]
    return np.concatenate([*between, times[-1:]])


def solved(
    terms: Callable[[FloatArray], tuple[FloatArray, FloatArray]],
    times: FloatArray,
    first: FloatArray,
    *,
    backwards: bool = False,
    direction: bool = False,
) -> PPoly:
    """Return the solution as a function of time, ``t.shape + (n, q)``.

    `terms` gives at times ``(k,)`` the A ``(k, n, n)`` and the g ``(k, n, q)``, smooth within the
    steps of a `mesh`; `first` is y at the first of its times, or backwards at the last, ``(n, q)``.
    Only the `direction` of y may be kept: its length is one where each step begins, so that it
    never overflows.
    """
    from scipy.interpolate import PPoly

    steps = np.diff(times)[:, np.newaxis, np.newaxis]
    points = (leggauss(_POINTS)[0] + 1.0) / 2.0
    powers = np.arange(_POINTS)
    to_powers = np.linalg.inv(points[:, np.newaxis] ** powers)  # of k_j, as powers of the part
    inner = points[:, np.newaxis] ** (powers + 1) / (powers + 1) @ to_powers  # up to each point
    whole = 1.0 / (powers + 1) @ to_powers
    count, n, q = steps.size, *first.shape
    A, g = terms((times[:-1, np.newaxis] + steps[:, 0] * points).ravel())
    A, g = A.reshape(count, _POINTS, n, n), g.reshape(count, _POINTS, n, q)
    # k_i - h A_i sum of W_ij k_j = A_i y + g_i
    held = steps[..., np.newaxis, np.newaxis] * np.einsum("ij,miab->miajb", inner, A)
    system = np.eye(_POINTS * n) - held.reshape(count, _POINTS * n, _POINTS * n)
    known = np.concatenate([A, g], axis=-1).reshape(count, _POINTS * n, n + q)
    slopes = np.linalg.solve(system, known).reshape(count, _POINTS, n, n + q)
    gains = steps * np.einsum("j,mjab->mab", whole, slopes)
    turns, adds = np.eye(n) + gains[..., :n], gains[..., n:]
    if backwards:
        turns = np.linalg.inv(turns)
        adds = -turns @ adds
    states = np.empty((count + 1, n, q))
    states[-1 if backwards else 0] = first
    for m in range(count)[:: -1 if backwards else 1]:
        begin, end = (m + 1, m) if backwards else (m, m + 1)
        states[end] = turns[m] @ states[begin] + adds[m]
        if direction:
            states[end] /= np.linalg.norm(states[end])
    at_points = slopes[..., :n] @ states[:-1, np.newaxis] + slopes[..., n:]
    rising = np.einsum("pj,mjab->pmab", to_powers / (powers[:, np.newaxis] + 1), at_points)
    rising = rising / steps ** powers[:, np.newaxis, np.newaxis, np.newaxis]  # (t - t_m)^(p + 1)
    return PPoly(np.concatenate([rising[::-1], states[np.newaxis, :-1]]), times)
