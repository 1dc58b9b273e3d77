"""The report's boundary limits in closed form: eqs (7), (12), (16) and (18), for arrays.

    p = tau beta/2,   y = y_BR,   R = 2 e^(-p) - e^(-2p),   L = -ln R,   z = p y
    kappa = 1 - K1 = (b1 - b2)/(beta + b1),   rho = b1/beta,   psi(x) = (e^(-x) - 1 + x)/x^2

The printed forms lose all digits at the ends of their ranges; those used here do not: nothing
is divided by K, 1 - K or b1, and no large numbers are subtracted. A vehicle with damping has
`Coefficients.pole` in the place of beta throughout.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.errors import InputError, finite, plain, positive, together, within
from tvclin.numerics import limits

OK = "ok"
NOT_CONVERGED = "not converged: the bracket could not be narrowed to rounding"
NOT_UNIQUE = "b2 is above b1: a solution, but perhaps not the only one"
NEVER_SATURATES = "trim never saturates: K times the limit is above the trim deflection"

_EPS = np.finfo(float).eps
_LARGEST = 1e9
"""Rates beyond it [1/s] mean nothing, nor does a pole below its inverse."""


@dataclass(frozen=True, eq=False)
class TriangularLimit:
    """Solutions of eq (18), every field of shape ``(...)``.

    `switch`: a/tau = y_BR K/2, eq (11): when the dead band is left. `status`: "ok", or in words
    what is wrong with the element.
    """

    limit: Any
    switch: Any
    status: Any


def rectangular_limit(tau_beta: ArrayLike, K1: ArrayLike = 1.0) -> Any:
    """Return y_BR of a rectangular wind, eq (7), and with drift eq (16).

        y_BR = K1 (1 - e^(-tau beta))

    Parameters
    ----------
    tau_beta : array_like
        tau beta, positive: the duration in units of 1/beta.
    K1 : array_like
        (beta + b2)/(beta + b1), eq (15b); 1 without drift.

    Raises
    ------
    InputError
        For a tau_beta not above zero.
    """
    tau_beta, K1 = positive("tau_beta", tau_beta), finite("K1", K1)
    together(tau_beta=tau_beta, K1=K1)
    return plain(np.asarray(-K1 * np.expm1(-tau_beta)))


def triangular_limit(tau_beta: ArrayLike, dead_band: ArrayLike) -> Any:
    """Return y_BR of a triangular wind without drift, eq (12) in closed form.

    Parameters
    ----------
    tau_beta : array_like
        tau beta, positive: the duration in units of 1/beta.
    dead_band : array_like
        K in [0, 1]; broadcasts with `tau_beta`.

    Returns
    -------
    float or ndarray
        y_BR, to a relative 1e-15. The dead band is left at a = y_BR K tau/2, which is
        never later than tau/2.

    Raises
    ------
    InputError
        For a tau_beta not above zero, or a dead band outside [0, 1].

    Notes
    -----
    The printed form is [1 - p y (1 - K)] e^(-p y K) = R. With c = K/(1 - K) its solution is
    y = [1 - W(c R e^c)/c]/(p (1 - K)), W being Lambert's function; its ends are
    y = (1 - e^(-p))^2/p for K = 0 and y = L/p for K = 1. W cancels where c is large, so it is
    evaluated as y = (1 - e^(-s))/(p (1 - K)) with s + c (1 - e^(-s)) = L.
    """
    tau_beta = positive("tau_beta", tau_beta)
    K = within("dead_band", dead_band, 0.0, 1.0)
    together(tau_beta=tau_beta, dead_band=K)
    p, K = np.broadcast_arrays(tau_beta / 2.0, K)
    return plain(limits.triangular(p, K))


def triangular_limit_with_drift(
    tau_beta: ArrayLike, dead_band: ArrayLike, beta: ArrayLike, b1: ArrayLike, b2: ArrayLike
) -> Any:
    """Return y_BR of a triangular wind with drift, eq (18); NaN where it was not found.

    `solve_triangular_with_drift` gives the same with a status for each element.

    Parameters
    ----------
    tau_beta : array_like
        tau beta, positive.
    dead_band : array_like
        K in [0, 1].
    beta : array_like
        Vehicle response parameter [1/s], or with damping the pole, 1e-9 to 1e9.
    b1, b2 : array_like
        Zeros of the numerators [1/s], eq (B7), at most 1e9 in size, with beta + b1 and beta + b2
        positive.

    Raises
    ------
    InputError
        For arguments outside these ranges.
    """
    return solve_triangular_with_drift(tau_beta, dead_band, beta, b1, b2).limit


def solve_triangular_with_drift(
    tau_beta: ArrayLike, dead_band: ArrayLike, beta: ArrayLike, b1: ArrayLike, b2: ArrayLike
) -> TriangularLimit:
    """Return the solution of eq (18) with a status for each element.

    Parameters
    ----------
    tau_beta, dead_band, beta, b1, b2 : array_like
        As of `triangular_limit_with_drift`.

    Raises
    ------
    InputError
        For arguments outside their ranges.

    Notes
    -----
    With z = p y eq (18) reads

        K1 (1 - e^(K z - L)) - (1 - K) z - kappa [K z + (K z)^2 psi(rho K z)] = 0.
    """
    arrays = {
        "tau_beta": positive("tau_beta", tau_beta),
        "dead_band": within("dead_band", dead_band, 0.0, 1.0),
        "beta": within("beta", beta, 1.0 / _LARGEST, _LARGEST, "1/s"),
        "b1": within("b1", b1, -_LARGEST, _LARGEST, "1/s"),
        "b2": within("b2", b2, -_LARGEST, _LARGEST, "1/s"),
    }
    together(**arrays)
    tau_beta, K, beta, b1, b2 = np.broadcast_arrays(*arrays.values())
    if np.any(beta + b1 <= 0.0) or np.any(beta + b2 <= 0.0):
        raise InputError("beta + b1 and beta + b2 must be positive; change b1 or b2")
    p = tau_beta / 2.0
    kappa, K1, rho = (b1 - b2) / (beta + b1), (beta + b2) / (beta + b1), b1 / beta
    z, converged = limits.triangular_with_drift(p, K, kappa, K1, rho)
    y = z / p
    never = K * y > 1.0 + 4.0 * _EPS
    status = np.select(
        [~converged, never, b2 > b1], [NOT_CONVERGED, NEVER_SATURATES, NOT_UNIQUE], OK
    )
    y = np.where(converged, y, np.nan)
    return TriangularLimit(
        plain(y), plain(np.asarray(y * K / 2.0)), status if status.ndim else str(status)
    )
