"""Angle and rate together: the least deflection over the rate at which the nozzle turns.

With one unstable pole p that decides, (4b) integrated by parts asks of a deflection from rest

    integral of delta'(s) e^(-p s) ds = d0,

d0 the least peak at any rate. The earliest motion has the largest weight: a ramp at the full rate
r, then a constant. With f(x) = (1 - e^-x)/x

    d0 = d f(p d/r),    d = -(r/p) ln(1 - p d0/r),    r > p d0.

With an acceleration limit c too, from rest to rest, v is the rate that is reached:

    d0 = d f(p d/v) f(p v/c),    v = min(r, sqrt(c d)).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray


def ramped_deflection(
    least: ArrayLike, pole: float, rate: ArrayLike, acceleration: ArrayLike = np.inf
) -> FloatArray:
    """Return the least deflection [rad] under limits of rate and acceleration, of one pole.

    `least`: d0 [rad], the least deflection at any rate, positive. `pole`: the unstable pole p
    [1/s]. `rate`, `acceleration`: their limits r [rad/s] and c [rad/s2], which broadcast with
    `least`; both may be infinite. Returned: infinite where no deflection is sufficient.
    """
    d0, r, c = np.broadcast_arrays(
        *(np.asarray(x, dtype=float) for x in (least, rate, acceleration))
    )
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        # full rate: d0 p/(r f(p r/c)) = 1 - e^(-p d/r), with r f(p r/c) = (c/p)(1 - e^(-p r/c))
        worth = np.where(np.isinf(c), r, -(c / pole) * np.expm1(-pole * r / c))
        full_rate = np.where(np.isinf(r), d0, -(r / pole) * _log1m(d0 * pole / worth))
        # full rate is never reached: d0 = d f(x)^2 with x = p sqrt(d/c)
        x = -_log1m(pole * np.sqrt(d0 / c))
        short = np.where(np.isinf(c), d0, c * (x / pole) ** 2)
        return np.where(c * short < r**2, short, full_rate)


def ramp_rate(least: ArrayLike, pole: ArrayLike, deflection: ArrayLike) -> FloatArray:
    """Return the least deflection rate [rad/s] at a limit `deflection`, d [rad], of one pole.

    It is the inverse of `ramped_deflection`: d0 = d f(x) with x = p d/r, which Lambert's W solves.
    Zero where no deflection is required, and infinite where no rate is sufficient.
    """
    from scipy.special import lambertw

    d0, p, d = np.broadcast_arrays(*(np.asarray(x, float) for x in (least, pole, deflection)))
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.maximum(d / d0, 1.0)
        x = ratio + np.real(lambertw(-ratio * np.exp(-ratio)))
        return np.where(d0 <= 0.0, 0.0, np.where(ratio > 1.0, p * d / x, np.inf))


def _log1m(x: FloatArray) -> FloatArray:
    """Return ln(1 - x), minus infinity from x = 1 on."""
    return np.where(x < 1.0, np.log1p(-np.minimum(x, 1.0)), -np.inf)
