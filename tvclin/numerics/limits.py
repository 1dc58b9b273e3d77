"""The closed forms of the boundary in a triangular wind, eqs (12) and (18).

    p = tau beta/2,   z = p y,   R = 2 e^(-p) - e^(-2p),   L = -ln R
    psi(x) = (e^(-x) - 1 + x)/x^2

They are solved to a relative 1e-15 for (12), and to 1e-13 for (18). An element that has arrived
is left alone, so that it has the same bits in any company.
"""

from typing import Any

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.numerics.moments import moments

_EPS = np.finfo(float).eps


def triangular(p: FloatArray, K: FloatArray) -> FloatArray:
    """Return y of eq (12), for arrays of one shape, p > 0 and 0 <= K <= 1."""
    L = _minus_log_R(p)
    with np.errstate(divide="ignore"):
        c = K / (1.0 - K)
    partly = np.where(np.isinf(c), 0.0, c)
    s, done = L / (1.0 + partly), np.zeros(L.shape, dtype=bool)
    for _ in range(60):
        step = (L - s + partly * np.expm1(-s)) / (1.0 + partly * np.exp(-s))
        s = np.where(done, s, s + np.maximum(step, 0.0))
        done |= step <= 2.0 * _EPS * s
        if np.all(done):
            break
    return np.where(np.isinf(c), L, -np.expm1(-s) / np.where(np.isinf(c), 1.0, 1.0 - K)) / p


def triangular_with_drift(
    p: FloatArray, K: FloatArray, kappa: FloatArray, K1: FloatArray, rho: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return z of eq (18), and whether it was found, for arrays of one shape.

        K1 (1 - e^(K z - L)) - (1 - K) z - kappa [K z + (K z)^2 psi(rho K z)] = 0

    For b2 <= b1 the left side falls from a positive value at z = 0 and is concave, so there is
    one root, below p/K and 1/(1 - K); Newton's iteration is kept between the ends.
    """
    L = _minus_log_R(p)
    high = _above_the_root(p, K, kappa, K1, rho, L)
    low = np.zeros_like(high)
    z = np.minimum(K1 * p * triangular(p, K), high)
    converged = np.zeros(z.shape, dtype=bool)
    for _ in range(100):
        x = K * z
        left = _left_side(z, K, kappa, K1, rho, L)
        bend = moments(rho * x, 0)[..., 0]  # (x^2 psi)' = x M_0
        slope = -K1 * K * np.exp(x - L) - (1.0 - K) - kappa * K * (1.0 + x * bend)
        low, high = np.where(left > 0.0, z, low), np.where(left < 0.0, z, high)
        new = z - left / slope
        new = np.where((new >= low) & (new <= high), new, (low + high) / 2.0)
        new = np.where((left == 0.0) | converged, z, new)
        converged |= np.abs(new - z) <= 4.0 * _EPS * new
        z = new
        if np.all(converged):
            break
    return z, converged


def psi(x: FloatArray) -> FloatArray:
    """(e^(-x) - 1 + x)/x^2 = M_0(x) - M_1(x)."""
    m = moments(x, 1)
    return np.asarray(m[..., 0] - m[..., 1])


def _left_side(z: Any, K: Any, kappa: Any, K1: Any, rho: Any, L: Any) -> FloatArray:
    x = K * z
    return -K1 * np.expm1(x - L) - (1.0 - K) * z - kappa * (x + x**2 * psi(rho * x))


def _above_the_root(p: Any, K: Any, kappa: Any, K1: Any, rho: Any, L: Any) -> FloatArray:
    """An end at which the left side is not positive; for b2 > b1 it may lie beyond p/K."""
    with np.errstate(divide="ignore", over="ignore"):
        high = np.minimum(p / K, 1.0 / (1.0 - K))
    for _ in range(60):
        below = _left_side(high, K, kappa, K1, rho, L) > 0.0
        if not np.any(below):
            break
        high = np.where(below, 1.5 * high, high)
    return high


def _minus_log_R(p: FloatArray) -> FloatArray:
    """L = -ln(2 e^(-p) - e^(-2p)), without cancellation at either end."""
    with np.errstate(divide="ignore"):
        short = -np.log1p(-(np.expm1(-p) ** 2))
    return np.where(p < 1.0, short, p - np.log(2.0 - np.exp(-p)))
