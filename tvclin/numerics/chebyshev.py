"""Values of a smooth function of time at many times, from those at a few Chebyshev points.

In each interval between breakpoints the function is evaluated at the extreme points of a Chebyshev
polynomial, whose degree is doubled until the interpolant of half the degree agrees with the new
values. Its error falls geometrically with the degree (Trefethen, 2013), so that the one that is
taken has about the square of that difference. Where it is not worth it, or does not converge, the
function is evaluated at each time.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial.chebyshev import chebpts2

from tvclin.base.arrays import FloatArray, IndexArray

_FIRST_DEGREE, _MAX_DEGREE = 8, 32
"""Degree of the first and the last interpolant."""
_MIN_TIMES_PER_POINT = 2
"""Smallest number of times for each point of an interpolant that is worth it."""
_HALF_DEGREE_TOLERANCE = 1e-7
"""Largest difference from the interpolant of half the degree, relative to the largest value."""
_ROUNDING = 1e-13
"""Rounding of a value, relative to the largest of its array."""


def smooth_values(
    function: Callable[[FloatArray], dict[str, FloatArray]],
    times: FloatArray,
    interval: IndexArray,
) -> dict[str, FloatArray]:
    """Return the values of a function at times, ``(n, ...)``, to about 1e-13 of the largest.

    A value that is constant is exact.

    Parameters
    ----------
    function : callable
        Function from times ``(m,)`` to arrays ``(m, ...)`` by name; it is called with many times
        together.
    times : ndarray
        Times, rising, ``(n,)``.
    interval : ndarray of int
        Number of the interval in which the function is smooth, for each time; negative for a time
        at which it is evaluated itself.
    """
    shapes: dict[str, tuple[int, ...]] = {}

    def packed(at: FloatArray) -> FloatArray:
        arrays = function(at)
        shapes.update({name: array.shape[1:] for name, array in arrays.items()})
        return np.concatenate([array.reshape(at.size, -1) for array in arrays.values()], axis=1)

    groups = [np.flatnonzero(interval == k) for k in np.unique(interval[interval >= 0])]
    pending = [which for which in groups if _worth(which, _FIRST_DEGREE)]
    exact = np.concatenate(
        [np.flatnonzero(interval < 0), *(w for w in groups if not _worth(w, _FIRST_DEGREE))]
    )
    degree = _FIRST_DEGREE
    nodes = [_nodes(times[which], degree) for which in pending]
    first = packed(np.concatenate([times[exact], *nodes]))
    values = np.empty((times.size, first.shape[1]))
    values[exact] = first[: exact.size]
    at_nodes = list(np.split(first[exact.size :], max(len(pending), 1)))
    sizes = [int(np.prod(shape)) for shape in shapes.values()]
    remaining: list[IndexArray] = []
    while pending:
        degree *= 2
        fresh = [_nodes(times[which], degree)[1::2] for which in pending]
        made = np.split(packed(np.concatenate(fresh)), len(pending))
        rest: list[tuple[IndexArray, FloatArray]] = []
        for which, old, new in zip(pending, at_nodes, made, strict=False):
            guess = _interpolated(old, np.linspace(0.0, np.pi, degree + 1)[1::2])
            points = np.empty((degree + 1, new.shape[1]))
            points[::2], points[1::2] = old, new
            if _agree(guess, new, points, sizes):
                values[which] = _interpolated(points, _angles(times[which]))
            elif degree < _MAX_DEGREE and _worth(which, degree):
                rest.append((which, points))
            else:
                remaining.append(which)
        pending, at_nodes = [which for which, _ in rest], [points for _, points in rest]
    if remaining:
        which = np.concatenate(remaining)
        values[which] = packed(times[which])
    parts = np.split(values, np.cumsum(sizes)[:-1], axis=1)
    return {
        name: part.reshape(times.size, *shape)
        for (name, shape), part in zip(shapes.items(), parts, strict=True)
    }


def _worth(which: IndexArray, degree: int) -> bool:
    """Return whether times are many enough for an interpolant of a degree and its double."""
    return which.size >= _MIN_TIMES_PER_POINT * (2 * degree + 1)


def _nodes(times: FloatArray, degree: int) -> FloatArray:
    """Return the Chebyshev points of a degree between the first and the last time, rising."""
    return times[0] + (times[-1] - times[0]) * (0.5 + 0.5 * chebpts2(degree + 1))


def _angles(times: FloatArray) -> FloatArray:
    """Return the angles of times on the half circle, 0 for the first and pi for the last."""
    middle = 2.0 * (times - times[0]) / (times[-1] - times[0]) - 1.0
    return np.arccos(np.clip(-middle, -1.0, 1.0))


def _interpolated(points: FloatArray, angles: FloatArray) -> FloatArray:
    """Return values at angles on the half circle, from those at equidistant ones ``(d + 1, k)``.

    The differences from the first point are interpolated.
    """
    nodes = np.cos(np.linspace(0.0, np.pi, len(points)))
    factors = interpolation_factors(nodes, np.cos(angles))
    values: FloatArray = factors @ np.nan_to_num(points - points[0])
    values += points[0]
    return values


def interpolation_factors(nodes: FloatArray, places: FloatArray) -> FloatArray:
    """Return the factors ``(m, n)`` from values at Chebyshev nodes ``(n,)`` to places ``(m,)``.

    By the barycentric formula (Berrut and Trefethen, 2004), whose weights are of alternating sign,
    and half as large at both ends. `nodes`: extreme points, on any interval.
    """
    weights = (-1.0) ** np.arange(nodes.size)
    weights[[0, -1]] *= 0.5
    distances = places[:, np.newaxis] - nodes
    at_node = distances == 0.0
    factors = weights / np.where(at_node, 1.0, distances)
    factors = np.where(at_node.any(axis=1, keepdims=True), at_node.astype(float), factors)
    return np.asarray(factors / factors.sum(axis=1, keepdims=True))


def _agree(guess: FloatArray, made: FloatArray, points: FloatArray, sizes: list[int]) -> bool:
    """Return whether an interpolant of half the degree agrees with new values of the function.

    `sizes`: number of values of each array, whose largest value sets its rounding.
    """
    missing = np.isnan(points)
    if np.any(missing.any(axis=0) != missing.all(axis=0)):
        return False
    largest = np.abs(np.where(missing, 0.0, points)).max(axis=0)
    of_array = np.maximum.reduceat(largest, np.cumsum([0, *sizes[:-1]]))
    tolerance = _HALF_DEGREE_TOLERANCE * largest + _ROUNDING * np.repeat(of_array, sizes)
    with np.errstate(invalid="ignore"):
        return bool(np.all((np.abs(guess - made) <= tolerance) | missing[1::2]))
