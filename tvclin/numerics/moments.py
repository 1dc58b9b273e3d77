"""The exponential moments, from which every transform and every exact response is made.

    M_k(z) = integral from 0 to 1 of x^k e^(-z x) dx,    k = 0 ... degree

They are entire in z, so nothing is lost where z tends to zero: the textbook
form (1 - e^(-z))/z and its higher relatives are never divided out there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray


def moments(z: ArrayLike, degree: int) -> AnyArray:
    """Return M_0(z) ... M_degree(z), shape ``(..., degree + 1)``, real for a real z.

    The recursion z M_k = k M_(k-1) - e^(-z) loses digits upward where k > |z| and
    downward where k < |z|, so each order is taken from the direction that is stable for it.
    """
    z = np.asarray(z)
    z = z.astype(complex if np.iscomplexobj(z) else float)
    orders = np.arange(degree + 1)
    size = np.abs(z)
    small = size <= degree + 1.5
    downward = _downward(np.where(small, z, 0.0), degree)
    if np.all(size <= 1.0):
        return downward
    upward = _upward(np.where(size > 1.0, z, 2.0), degree)
    use_upward = (size[..., np.newaxis] > np.maximum(orders, 1.0)) | ~small[..., np.newaxis]
    return np.where(use_upward, upward, downward)


def _downward(z: AnyArray, degree: int) -> AnyArray:
    # What the recursion starts from is wrong by a relative 1, and each order j multiplies that by
    # |z|/j; with |z| <= degree + 1.5 so many more orders bring it below 1e-16.
    start = 3 * degree + 26
    result = np.empty((*z.shape, degree + 1), dtype=z.dtype)
    decay = np.exp(-z)
    moment = np.zeros_like(z)
    for order in range(start, 0, -1):
        moment = (z * moment + decay) / order  # M_(order-1)
        if order <= degree + 1:
            result[..., order - 1] = moment
    return result


def _upward(z: AnyArray, degree: int) -> AnyArray:
    result = np.empty((*z.shape, degree + 1), dtype=z.dtype)
    with np.errstate(over="ignore", invalid="ignore"):
        decay = np.exp(-z)
        result[..., 0] = -np.expm1(-z) / z
        for order in range(1, degree + 1):
            result[..., order] = (order * result[..., order - 1] - decay) / z
    result[np.isinf(decay)] = np.inf
    return result
