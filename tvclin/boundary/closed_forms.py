"""The report's boundary limits in closed form: eqs (7), (12), (16) and (18), for arrays.

    p = tau beta/2,   y = y_BR,   R = 2 e^(-p) - e^(-2p),   L = -ln R,   z = p y
    kappa = 1 - K1 = (b1 - b2)/(beta + b1),   rho = b1/beta,   psi(x) = (e^(-x) - 1 + x)/x^2

The printed forms lose all digits at the ends of their ranges; those used here do not: nothing
is divided by K, 1 - K or b1, and no large numbers are subtracted. A vehicle with damping has
`Coefficients.pole` in the place of beta throughout.

Eq (12) is solved to a relative 1e-15, eq (18) to 1e-13. A converged element is not iterated
further, so that its bits do not depend on the others of a batch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.errors import InputError, finite, plain, positive, together, within
from tvclin.numerics.pieces import moments

OK = "ok"
NOT_CONVERGED = "not converged: the bracket could not be narrowed to rounding"
NOT_UNIQUE = "b2 is above b1: a solution, but perhaps not the only one"
NEVER_SATURATES = "trim never saturates: K times the limit is above the trim deflection"

_EPSILON = np.finfo(float).eps
"""Relative spacing of floating-point numbers."""
_MAX_RATE = 1e9
"""Largest rate [1/s]; its inverse is the smallest pole."""


def solve_triangular(p: FloatArray, K: FloatArray) -> FloatArray:
    """Return the boundary limit y in a triangular wind without drift, over static trim.

    It solves eq (12) of the report. `p`: fast pole times half the duration [-], positive. `K`: dead
    band, 0 to 1, of the same shape. y = (1 - e^(-s))/(p (1 - K)) where s + c (1 - e^(-s)) = L =
    -ln(2 e^(-p) - e^(-2p)), c = K/(1 - K), by Newton's method, which rises to s from below; y = L/p
    for K = 1.
    """
    L = _minus_log_R(p)
    with np.errstate(divide="ignore"):
        c = K / (1.0 - K)
    finite_c = np.where(np.isinf(c), 0.0, c)  # without K = 1
    s, done = L / (1.0 + finite_c), np.zeros(L.shape, dtype=bool)
    for _ in range(60):
        step = (L - s + finite_c * np.expm1(-s)) / (1.0 + finite_c * np.exp(-s))
        s = np.where(done, s, s + np.maximum(step, 0.0))
        done |= step <= 2.0 * _EPSILON * s
        if np.all(done):
            break
    return np.where(np.isinf(c), L, -np.expm1(-s) / np.where(np.isinf(c), 1.0, 1.0 - K)) / p


def solve_with_drift(
    p: FloatArray, K: FloatArray, kappa: FloatArray, K1: FloatArray, rho: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return z = p y of eq (18) of the report, and whether the iteration converged.

    y is the boundary limit of a triangular wind with drift, over static trim; the equation is in
    `solve_triangular_with_drift`. `p`: pole times half the duration. `K`: dead band. `kappa`: (b1 -
    b2)/(beta + b1). `K1`: 1 - kappa. `rho`: b1/beta. All arrays have one shape. For b2 <= b1 the
    left side falls from a positive value at z = 0 and is concave, so that it has one root, below
    p/K and 1/(1 - K), which Newton's method finds inside a bracket.
    """
    L = _minus_log_R(p)

    def residual(z: FloatArray) -> FloatArray:
        """Return the left side of eq (18), zero at the solution z."""
        x = K * z
        return -K1 * np.expm1(x - L) - (1.0 - K) * z - kappa * (x + x**2 * psi(rho * x))

    with np.errstate(divide="ignore", over="ignore"):
        high = np.minimum(p / K, 1.0 / (1.0 - K))
    for _ in range(60):  # for b2 > b1 the bracket may have to be larger
        outside = residual(high) > 0.0
        if not np.any(outside):
            break
        high = np.where(outside, 1.5 * high, high)
    low = np.zeros_like(high)
    z = np.minimum(K1 * p * solve_triangular(p, K), high)
    converged = np.zeros(z.shape, dtype=bool)
    for _ in range(100):
        x = K * z
        left = residual(z)
        M_0 = moments(rho * x, 0)[..., 0]  # (x^2 psi)' = x M_0, M_0(x) = (1 - e^(-x))/x
        slope = -K1 * K * np.exp(x - L) - (1.0 - K) - kappa * K * (1.0 + x * M_0)
        low, high = np.where(left > 0.0, z, low), np.where(left < 0.0, z, high)
        iterate = z - left / slope
        iterate = np.where((iterate >= low) & (iterate <= high), iterate, (low + high) / 2.0)
        iterate = np.where((left == 0.0) | converged, z, iterate)
        converged |= np.abs(iterate - z) <= 4.0 * _EPSILON * iterate
        z = iterate
        if np.all(converged):
            break
    return z, converged


def psi(x: FloatArray) -> FloatArray:
    """Return psi(x) = (e^(-x) - 1 + x)/x^2 = M_0(x) - M_1(x), in the shape of x.

    M_k is the moment of order k, the integral of v^k e^(-x v) over v from 0 to 1.
    """
    m = moments(x, 1)
    return np.asarray(m[..., 0] - m[..., 1])


def _minus_log_R(p: FloatArray) -> FloatArray:
    """Return L = -ln(2 e^(-p) - e^(-2p)) for p > 0, without cancellation at either end."""
    with np.errstate(divide="ignore"):
        short = -np.log1p(-(np.expm1(-p) ** 2))
    return np.where(p < 1.0, short, p - np.log(2.0 - np.exp(-p)))


@dataclass(frozen=True, eq=False)
class TriangularLimit:
    """Solutions of eq (18), every field of shape ``(...)``.

    `switch`: a/tau = y_BR K/2, eq (11): exit of the dead band. `status`: "ok", or in words
    what is wrong with the element.
    """

    limit: Any
    switch: Any
    status: Any


def rectangular_limit(tau_beta: ArrayLike, K1: ArrayLike = 1.0) -> Any:
    """Return the boundary limit y_BR of a rectangular wind, over static trim, eqs (7) and (16).

        y_BR = K1 (1 - e^(-tau beta))

    Eq (7) of Borsody and Teren is without drift, where K1 = 1; eq (16) is with drift.

    Parameters
    ----------
    tau_beta : array_like
        The duration tau of the wind times the unstable pole beta, positive.
    K1 : array_like
        (beta + b2)/(beta + b1), eq (15b), with b1 and b2 of the flight path; 1 without drift.

    Raises
    ------
    InputError
        For a tau_beta not above zero.
    """
    tau_beta, K1 = positive("tau_beta", tau_beta), finite("K1", K1)
    together(tau_beta=tau_beta, K1=K1)
    return plain(np.asarray(-K1 * np.expm1(-tau_beta)))


def triangular_limit(tau_beta: ArrayLike, dead_band: ArrayLike) -> Any:
    """Return the boundary limit y_BR of a triangular wind without drift, in closed form.

    Parameters
    ----------
    tau_beta : array_like
        The duration tau of the wind times the unstable pole beta, positive.
    dead_band : array_like
        K in [0, 1]; broadcasts with `tau_beta`.

    Returns
    -------
    float or ndarray
        y_BR, the limit over static trim, to a relative 1e-15. The exit of the dead band is at
        a = y_BR K tau/2, which is never later than tau/2.

    Raises
    ------
    InputError
        For a tau_beta not above zero, or a dead band outside [0, 1].

    Notes
    -----
    The printed form, eq (12) of Borsody and Teren, is [1 - p y (1 - K)] e^(-p y K) = R, with p =
    tau beta/2, R = 2 e^(-p) - e^(-2p) and L = -ln R. With c = K/(1 - K) its solution is y = [1 -
    W(c R e^c)/c]/(p (1 - K)), W being Lambert's function; its ends are y = (1 - e^(-p))^2/p for K =
    0 and y = L/p for K = 1. W cancels where c is large, so it is evaluated as y = (1 - e^(-s))/(p
    (1 - K)) with s + c (1 - e^(-s)) = L.
    """
    tau_beta = positive("tau_beta", tau_beta)
    K = within("dead_band", dead_band, 0.0, 1.0)
    together(tau_beta=tau_beta, dead_band=K)
    p, K = np.broadcast_arrays(tau_beta / 2.0, K)
    return plain(solve_triangular(p, K))


def triangular_limit_with_drift(
    tau_beta: ArrayLike, dead_band: ArrayLike, beta: ArrayLike, b1: ArrayLike, b2: ArrayLike
) -> Any:
    """Return the boundary limit y_BR of a triangular wind with drift, over static trim.

    It solves eq (18) of Borsody and Teren; NaN without convergence. `solve_triangular_with_drift`
    gives the same with a status for each element.

    Parameters
    ----------
    tau_beta : array_like
        The duration tau of the wind times the unstable pole beta, positive.
    dead_band : array_like
        K in [0, 1].
    beta : array_like
        Vehicle response parameter [1/s], or with damping the pole, 1e-9 to 1e9.
    b1, b2 : array_like
        Zeros -b1 and -b2 of the numerators of deflection and wind to the attitude [1/s], eq (B7),
        at most 1e9 in size, with beta + b1 and beta + b2 positive.

    Raises
    ------
    InputError
        For arguments outside these ranges.
    """
    return solve_triangular_with_drift(tau_beta, dead_band, beta, b1, b2).limit


def solve_triangular_with_drift(
    tau_beta: ArrayLike, dead_band: ArrayLike, beta: ArrayLike, b1: ArrayLike, b2: ArrayLike
) -> TriangularLimit:
    """Return the boundary limit of a triangular wind with drift, eq (18), with a status.

    Parameters
    ----------
    tau_beta, dead_band, beta, b1, b2 : array_like
        Same parameters as `triangular_limit_with_drift`.

    Raises
    ------
    InputError
        For arguments outside their ranges.

    Notes
    -----
    y is the boundary limit over static trim, K the dead band, and the trim deflection leaves it
    after y K/2 of the duration, eq (11). With p = tau beta/2 and z = p y eq (18) of Borsody and
    Teren reads

        K1 (1 - e^(K z - L)) - (1 - K) z - kappa [K z + (K z)^2 psi(rho K z)] = 0,

    L = -ln(2 e^(-p) - e^(-2p)), K1 = (beta + b2)/(beta + b1), kappa = 1 - K1, rho = b1/beta, and
    psi(x) = (e^(-x) - 1 + x)/x^2. Above K y = 1 trim never reaches K times the limit.
    """
    arrays = {
        "tau_beta": positive("tau_beta", tau_beta),
        "dead_band": within("dead_band", dead_band, 0.0, 1.0),
        "beta": within("beta", beta, 1.0 / _MAX_RATE, _MAX_RATE, "1/s"),
        "b1": within("b1", b1, -_MAX_RATE, _MAX_RATE, "1/s"),
        "b2": within("b2", b2, -_MAX_RATE, _MAX_RATE, "1/s"),
    }
    together(**arrays)
    tau_beta, K, beta, b1, b2 = np.broadcast_arrays(*arrays.values())
    if np.any(beta + b1 <= 0.0) or np.any(beta + b2 <= 0.0):
        raise InputError("beta + b1 and beta + b2 must be positive; change b1 or b2")
    p = tau_beta / 2.0
    kappa, K1, rho = (b1 - b2) / (beta + b1), (beta + b2) / (beta + b1), b1 / beta
    z, converged = solve_with_drift(p, K, kappa, K1, rho)
    y = z / p
    never = K * y > 1.0 + 4.0 * _EPSILON
    status = np.select(
        [~converged, never, b2 > b1], [NOT_CONVERGED, NEVER_SATURATES, NOT_UNIQUE], OK
    )
    y = np.where(converged, y, np.nan)
    return TriangularLimit(
        plain(y), plain(np.asarray(y * K / 2.0)), status if status.ndim else str(status)
    )
