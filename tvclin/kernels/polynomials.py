"""Polynomials with real or complex coefficients ``(..., n + 1)``, highest power first."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def value(polynomial: NDArray[Any], s: NDArray[Any]) -> NDArray[Any]:
    """Return the values at ``s (..., m)``; the leading axes broadcast."""
    result = np.zeros_like(s)
    for k in range(polynomial.shape[-1]):
        result = result * s + polynomial[..., k, np.newaxis]
    return result


def derivative(polynomial: NDArray[Any]) -> NDArray[Any]:
    """Return the derivative."""
    degree = polynomial.shape[-1] - 1
    return polynomial[..., :-1] * np.arange(degree, 0, -1)


def divide(polynomial: NDArray[Any], root: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return quotient and remainder of the division by (s - root), by Horner's scheme."""
    columns = [polynomial[..., 0] + 0 * root]
    for k in range(1, polynomial.shape[-1]):
        columns.append(columns[-1] * root + polynomial[..., k])
    return np.stack(columns[:-1], axis=-1), columns[-1]


def roots(polynomial: NDArray[np.float64]) -> NDArray[Any]:
    """Return the roots, shape ``(..., n)``; real when all roots of the whole batch are real.

    Eigenvalues of the companion matrices, then two Newton steps each, which bring the small
    roots of a polynomial with roots of very different size to full relative accuracy.
    """
    degree = polynomial.shape[-1] - 1
    if degree == 0:
        return np.zeros((*polynomial.shape[:-1], 0))
    monic = polynomial[..., 1:] / polynomial[..., :1]
    companion = np.zeros((*monic.shape[:-1], degree, degree))
    companion[..., 0, :] = -monic
    companion[..., np.arange(1, degree), np.arange(degree - 1)] = 1.0
    found = np.linalg.eigvals(companion)
    for _ in range(2):
        found = _newton(polynomial, found)
    return found


def _newton(polynomial: NDArray[np.float64], found: NDArray[Any]) -> NDArray[Any]:
    """One step for the roots that stand alone.

    The errors of a cluster of roots belong together, and moving them one by one would spoil what
    they have in common.
    """
    residual = value(polynomial, found)
    slope = value(derivative(polynomial), found)
    step = np.where(slope == 0.0, 0.0, residual / np.where(slope == 0.0, 1.0, slope))
    apart = np.abs(found[..., :, np.newaxis] - found[..., np.newaxis, :])
    apart[..., np.arange(found.shape[-1]), np.arange(found.shape[-1])] = np.inf
    alone = np.abs(step) <= 1e-3 * apart.min(axis=-1)
    better = np.abs(value(polynomial, found - step)) < np.abs(residual)
    return np.where(alone & better, found - step, found)
