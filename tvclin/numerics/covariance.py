"""Covariance of linear systems in white noise, x' = A x + n, E[n(t) n(t')'] = N delta(t - t').

Stationary, A P + P A' + N = 0, and in exact steps, P(t + h) = F P(t) F' + Q(h) with

    F = e^(A h),    Q = int_0^h e^(A s) N e^(A' s) ds.

The steps are found by series and doubling, Q(2 h) = Q + F Q F', which adds nothing but positive
matrices: Van Loan's exponential contains e^(-A h), which loses all digits where fast poles decay.
A system that varies over a step is replaced by the constant one with the same step to order four,
Magnus' expansion with two Gauss points (Blanes, Casas, Oteo and Ros, 2009).
"""

from __future__ import annotations

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.numerics.propagation import constant_generator

_MAX_SERIES_NORM, _SERIES_TERMS = 0.25, 12
"""Norm of A h up to which the series is used, and its terms: (2 x 0.25)^13/13! is below 1e-13."""


def stationary_covariance(A: FloatArray, noise: FloatArray) -> FloatArray:
    """Return P of A P + P A' + N = 0 for a stable system, ``(n, n)``.

    `A`, `noise`: A [1/s] and N, ``(n, n)``.
    """
    from scipy.linalg import solve_continuous_lyapunov  # late: it takes half a second to import

    P = solve_continuous_lyapunov(A, -noise)
    return np.asarray(0.5 * (P + P.T))


def periodic_covariance(step: FloatArray, noise: FloatArray) -> FloatArray:
    """Return P of P = F P F' + Q for a stable discrete system, ``(n, n)``.

    `step`, `noise`: F and Q, ``(n, n)``.
    """
    from scipy.linalg import solve_discrete_lyapunov  # late, as above

    P = solve_discrete_lyapunov(step, noise)
    return np.asarray(0.5 * (P + P.T))


def steps(A: FloatArray, noise: FloatArray, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return F and Q of steps of given lengths [s] ``(m,)``, each ``(m, n, n)``.

    `A`, `noise`: A [1/s] and N, ``(n, n)`` or ``(m, n, n)``. What is beyond all numbers is infinite
    or NaN.
    """
    lengths = np.asarray(times, float)[:, np.newaxis, np.newaxis]
    norm = np.abs(A).sum(axis=-2).max(axis=-1, initial=0.0)
    size = float(np.max(norm * np.asarray(times, float), initial=0.0))
    doublings = max(int(np.frexp(size / _MAX_SERIES_NORM)[1]), 0)
    first = A * np.ldexp(lengths, -doublings)
    unit = np.eye(A.shape[-1])
    F = np.broadcast_to(unit, first.shape)
    for k in range(_SERIES_TERMS, 0, -1):
        F = unit + first @ F / k
    term = noise * np.ldexp(lengths, -doublings)
    Q = term
    for k in range(2, _SERIES_TERMS + 1):
        product = first @ term
        term = (product + np.swapaxes(product, -1, -2)) / k
        Q = Q + term
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(doublings):
            Q = Q + F @ Q @ np.swapaxes(F, -1, -2)
            F = F @ F
    return F, Q


def constant_over_steps(
    A: tuple[FloatArray, FloatArray], noise: tuple[FloatArray, FloatArray], times: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the constant A and N with the same step, to fourth order, as those that vary.

    `A`, `noise`: A and N at the two `GAUSS_NODES` of each step, each ``(m, n, n)``. `times`:
    lengths of the steps [s], ``(m,)``.
    """
    (A1, A2), (N1, N2) = A, noise
    factor = np.sqrt(3.0) / 12.0 * np.asarray(times)[:, np.newaxis, np.newaxis]

    def driven(matrix: FloatArray, noise: FloatArray) -> FloatArray:
        product = matrix @ noise
        return product + np.swapaxes(product, -1, -2)

    return (
        constant_generator(A1, A2, times),
        0.5 * (N1 + N2) + factor * (driven(A2, N1) - driven(A1, N2)),
    )
