"""The report's attitude responses in closed form: eqs (9), (13) and (B9), the last corrected.

All give the attitude error over the wind's peak with the sign reversed,
(Theta - Theta_n)/(-alpha_w,max), against t/tau. They are sums of hyperbolic functions: near the
boundary their growing parts cancel, so they lose digits with e^(tau beta (t/tau)). For numbers
use `response.attitude_response`, which loses none; these are for reading, and for checking it. They
hold without damping alone: with it the two exponentials are unlike, and only that function knows.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.base.errors import InputError, finite, nonnegative, plain, positive, together, within
from tvclin.boundary.closed_forms import psi

FloatArray = NDArray[np.float64]


def rectangular_attitude(t_over_tau: ArrayLike, tau_beta: ArrayLike, limit: ArrayLike) -> Any:
    """Return the attitude in a rectangular wind with the deflection held from t = 0, eq (9).

        (1 - y) [cosh(tau beta x) - 1] - [cosh(tau beta (x - 1)) - 1] u(x - 1),   x = t/tau

    Parameters
    ----------
    t_over_tau : array_like
        Time over the duration of the wind.
    tau_beta : array_like
        tau beta, positive.
    limit : array_like
        y, the deflection over B alpha_w,max with its sign reversed; at eq (7) it is on the
        boundary.

    Returns
    -------
    float or ndarray
        (Theta - Theta_n)/(-alpha_w,max); the arguments broadcast.

    Raises
    ------
    InputError
        For a tau_beta not above zero, a negative limit, or numbers that are not finite.
    """
    x, b, y = _arguments(t_over_tau, tau_beta, limit)
    after = x - 1.0
    return plain(_from(x, (1.0 - y) * _cosh(b * x)) - _from(after, _cosh(b * after)))


def triangular_attitude(
    t_over_tau: ArrayLike, tau_beta: ArrayLike, limit: ArrayLike, dead_band: ArrayLike = 1.0
) -> Any:
    """Return the attitude in a triangular wind without drift, eq (13).

    Parameters
    ----------
    t_over_tau, tau_beta, limit : array_like
        As of `rectangular_attitude`; on the boundary the limit is that of eq (12).
    dead_band : array_like
        K in [0, 1]; the limit is held from a = y K tau/2 on, eq (11).

    Returns
    -------
    float or ndarray
        (Theta - Theta_n)/(-alpha_w,max).

    Raises
    ------
    InputError
        As `rectangular_attitude`, and where y K > 1: trim then never saturates, and the formula
        does not hold.
    """
    x, b, y, K = _switched(t_over_tau, tau_beta, limit, dead_band)
    since = x - y * K / 2.0
    held = _sinh(b * since) - y * (b / 2.0) * (1.0 - K) * _cosh(b * since)
    middle, end = x - 0.5, x - 1.0
    total = _from(since, held) - 2.0 * _from(middle, _sinh(b * middle)) + _from(end, _sinh(b * end))
    return plain(2.0 / b * total)


def triangular_attitude_with_drift(
    t_over_tau: ArrayLike,
    tau_beta: ArrayLike,
    limit: ArrayLike,
    dead_band: ArrayLike,
    beta: ArrayLike,
    b1: ArrayLike,
    b2: ArrayLike,
) -> Any:
    """Return the attitude in a triangular wind with drift, eq (B9), corrected.

    Parameters
    ----------
    t_over_tau, tau_beta, limit, dead_band : array_like
        As of `triangular_attitude`; on the boundary the limit is that of eq (18).
    beta : array_like
        Vehicle response parameter [1/s], positive.
    b1, b2 : array_like
        Zeros of the numerators [1/s], eq (B7).

    Returns
    -------
    float or ndarray
        As of `triangular_attitude`, and so is what is refused.

    Notes
    -----
    As printed, the first bracket has + (tau beta)^2/2 for -, the third B for beta and its
    closing parenthesis in the wrong place. (e^(-b1 a) + b1 a - 1)/b1^2 is written a^2 psi(b1 a),
    so that b1 may be zero.
    """
    x, b, y, K = _switched(t_over_tau, tau_beta, limit, dead_band)
    beta, b1, b2 = positive("beta", beta, "1/s"), finite("b1", b1, "1/s"), finite("b2", b2, "1/s")
    tau = b / beta
    a = y * K * tau / 2.0
    since = b * (x - a / tau)
    hold = y * (1.0 - K)
    held = (1.0 + a * (b2 - b1) - b1 * tau / 2.0 * hold) * _sinh(since)
    held = held + b2 / beta * _cosh_2(since)
    held = held + (beta * (b2 - b1) * a**2 * psi(b1 * a) - b / 2.0 * hold) * _cosh(since)
    total = _from(since, held)
    for weight, start in ((-2.0, 0.5), (1.0, 1.0)):
        later = b * (x - start)
        total = total + weight * _from(later, _sinh(later) + b2 / beta * _cosh_2(later))
    return plain(np.asarray(2.0 / b * total))


def _arguments(
    t_over_tau: ArrayLike, tau_beta: ArrayLike, limit: ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    x, b = finite("t_over_tau", t_over_tau), positive("tau_beta", tau_beta)
    y = nonnegative("limit", limit)
    together(t_over_tau=x, tau_beta=b, limit=y)
    return x, b, y


def _switched(
    t_over_tau: ArrayLike, tau_beta: ArrayLike, limit: ArrayLike, dead_band: ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    x, b, y = _arguments(t_over_tau, tau_beta, limit)
    K = within("dead_band", dead_band, 0.0, 1.0)
    if np.any(y * K > 1.0):
        raise InputError(
            "limit times dead_band must not exceed 1, where trim never saturates and the formula"
            f" does not hold; got {np.max(y * K):.6g} (use trim_then_hold and attitude_response)"
        )
    return x, b, y, K


def _from(since: FloatArray, values: FloatArray) -> FloatArray:
    """The values from `since` = 0 on, and nothing before."""
    return np.where(since >= 0.0, values, 0.0)


def _cosh(x: FloatArray) -> FloatArray:
    """Cosh(x) - 1, without cancellation."""
    return 2.0 * np.sinh(np.maximum(x, 0.0) / 2.0) ** 2


def _sinh(x: FloatArray) -> FloatArray:
    """Sinh(x) - x for x >= 0, by its series where it would cancel."""
    x = np.maximum(x, 0.0)
    near = x**3 / 6.0 * _series(x**2, (20.0, 42.0, 72.0, 110.0, 156.0))
    return np.where(x < 0.5, near, np.sinh(x) - x)


def _cosh_2(x: FloatArray) -> FloatArray:
    """Cosh(x) - 1 - x^2/2 for x >= 0, by its series where it would cancel."""
    x = np.maximum(x, 0.0)
    near = x**4 / 24.0 * _series(x**2, (30.0, 56.0, 90.0, 132.0, 182.0))
    return np.where(x < 0.5, near, _cosh(x) - x**2 / 2.0)


def _series(square: FloatArray, divisors: tuple[float, ...]) -> FloatArray:
    """1 + s/d1 (1 + s/d2 (1 + ...)): the ratio of each term to the one before is s/d."""
    total = np.ones_like(square)
    for divisor in reversed(divisors):
        total = 1.0 + square / divisor * total
    return total
