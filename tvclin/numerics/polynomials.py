"""Polynomials with real or complex coefficients ``(..., n + 1)``, highest power first.

numpy has the same for one polynomial at a time: `numpy.roots` takes three times as long for 2000 of
degree eight, and its roots between 1e-5 and 1e4 of one polynomial have twelve digits, not fourteen.
"""

import numpy as np

from tvclin.base.arrays import AnyArray, ComplexArray, FloatArray
from tvclin.kernels.choice import run
from tvclin.kernels.small_roots import COMPILED, PLAIN, small_roots

_NEGLIGIBLE_LEADING_COEFFICIENT = 1e-300
"""Leading coefficient, relative to the largest, that counts as zero: its root overflows."""
_MAX_DIRECT_DEGREE = 4
"""Degree up to which the kernel finds the roots one after the other."""


def value(polynomial: AnyArray, s: AnyArray) -> AnyArray:
    """Return the values of a polynomial at ``s (..., m)``; the leading axes broadcast.

    `polynomial`: coefficients, highest power first, ``(..., n + 1)``.
    """
    if not polynomial.shape[-1]:
        return np.zeros_like(s)
    result = polynomial[..., 0, np.newaxis] + 0.0 * s
    for k in range(1, polynomial.shape[-1]):
        result *= s
        result += polynomial[..., k, np.newaxis]
    return result


def on_axis(polynomial: FloatArray, omega: FloatArray) -> AnyArray:
    """Return the values of a real polynomial at j omega ``(..., m)``; the leading axes broadcast.

    `polynomial`: coefficients, highest power first, ``(..., n + 1)``. `omega`: frequencies [rad/s].
    """
    even, odd = _parts_on_axis(polynomial)
    square = omega**2
    values = value(even, square).astype(complex)
    values.imag = omega * value(odd, square)
    return values


def derivative(polynomial: AnyArray) -> AnyArray:
    """Return the coefficients ``(..., n)`` of the derivative of polynomials ``(..., n + 1)``."""
    degree = polynomial.shape[-1] - 1
    return polynomial[..., :-1] * np.arange(degree, 0, -1)


def multiply(first: AnyArray, second: AnyArray) -> AnyArray:
    """Return the coefficients of the product of two polynomials, highest power first.

    `first`, `second`: ``(..., m + 1)`` and ``(..., n + 1)``, whose leading axes broadcast.
    """
    m, n = first.shape[-1], second.shape[-1]
    shape = np.broadcast_shapes(first.shape[:-1], second.shape[:-1])
    product = np.zeros((*shape, m + n - 1), dtype=np.result_type(first, second))
    for k in range(m):
        product[..., k : k + n] += first[..., k, np.newaxis] * second
    return product


def add(first: AnyArray, second: AnyArray) -> AnyArray:
    """Return the sum of two polynomials, which may differ in degree; the leading axes broadcast.

    `first`, `second`: coefficients, highest power first, ``(..., m + 1)`` and ``(..., n + 1)``.
    """
    size = max(first.shape[-1], second.shape[-1])
    batch = np.broadcast_shapes(first.shape[:-1], second.shape[:-1])
    total = np.zeros((*batch, size), np.result_type(first, second))
    total[..., size - first.shape[-1] :] = first
    total[..., size - second.shape[-1] :] += second
    return total


def squared_size(polynomial: FloatArray) -> FloatArray:
    """Return |p(j omega)|^2 as a polynomial in omega^2, for real p ``(..., n + 1)``."""
    even, odd = _parts_on_axis(polynomial)
    squares = multiply(even, even)
    if odd.shape[-1]:
        squares = add(squares, times_variable(multiply(odd, odd)))
    return squares


def imaginary_part(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return Im(p(j omega) conj(q(j omega)))/omega as a polynomial in omega^2.

    `first`, `second`: the real polynomials p and q, ``(..., n + 1)`` each.
    """
    (even, odd), (even_2, odd_2) = map(_parts_on_axis, (first, second))
    return add(multiply(odd, even_2), -multiply(even, odd_2))


def times_variable(polynomial: AnyArray, power: int = 1) -> AnyArray:
    """Return the coefficients of x^power p(x) of polynomials p ``(..., n + 1)``."""
    return np.concatenate([polynomial, np.zeros((*polynomial.shape[:-1], power))], axis=-1)


def divide(polynomial: AnyArray, root: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Return quotient ``(..., n)`` and remainder ``(...)`` of p(s)/(s - root), by Horner's scheme.

    `polynomial`: coefficients of p, highest power first, ``(..., n + 1)``. `root`: ``(...)``.
    """
    columns = [polynomial[..., 0] + 0 * root]
    for k in range(1, polynomial.shape[-1]):
        columns.append(columns[-1] * root + polynomial[..., k])
    return np.stack(columns[:-1], axis=-1), columns[-1]


def roots(polynomial: FloatArray) -> AnyArray:
    """Return the roots of polynomials ``(..., n + 1)``, ``(..., n)``; real if all of the batch are.

    A quadratic is solved by the sum and product of its roots, cubics and quartics by deflation; for
    higher degrees the roots are eigenvalues of the companion matrices. Two Newton steps bring small
    roots of a polynomial with roots of very different size to full relative accuracy.
    """
    degree = polynomial.shape[-1] - 1
    if degree == 0:
        return np.zeros((*polynomial.shape[:-1], 0))
    monic = polynomial[..., 1:] / polynomial[..., :1]  # coefficients after the leading 1
    if degree == 2:
        return _quadratic(-0.5 * monic[..., 0], monic[..., 1])
    if 2 < degree <= _MAX_DIRECT_DEGREE:
        rows = np.concatenate([np.ones_like(monic[..., :1]), monic], axis=-1)
        rows = rows.reshape(-1, degree + 1)
        rows = rows[:1] if np.all(rows == rows[:1]) else rows  # one vehicle in many winds
        count, row_roots = len(rows), np.empty((len(rows), degree), dtype=complex)
        # estimated run time, which decides between compiled and plain code
        run(small_roots, (rows, row_roots), count, PLAIN * count, COMPILED * count)
        all_roots = np.resize(row_roots, monic.shape)
        return all_roots if np.any(np.imag(all_roots)) else np.real(all_roots)
    companion = np.zeros((*monic.shape[:-1], degree, degree))
    companion[..., 0, :] = -monic
    companion[..., np.arange(1, degree), np.arange(degree - 1)] = 1.0
    estimates = np.linalg.eigvals(companion)
    for _ in range(2):
        estimates = _newton_step(polynomial, estimates)
    return estimates


def roots_of_each(polynomial: FloatArray) -> ComplexArray:
    """Return the roots ``(k, n)`` of polynomials ``(k, n + 1)`` that may begin with zeros.

    NaN fills the rows of polynomials of lower degree.
    """
    count, size = polynomial.shape
    all_roots = np.full((count, size - 1), np.nan, dtype=complex)
    live = np.abs(polynomial) > _NEGLIGIBLE_LEADING_COEFFICIENT * np.abs(polynomial).max(
        axis=-1, keepdims=True
    )
    leading_zeros = np.where(np.any(live, axis=-1), np.argmax(live, axis=-1), size)
    for leading in np.unique(leading_zeros[leading_zeros < size]):
        rows = leading_zeros == leading
        all_roots[rows, : size - 1 - leading] = roots(polynomial[rows, leading:])
    return all_roots


def bound(polynomial: FloatArray) -> FloatArray:
    """Return an upper bound of the sizes of the roots, ``(...)``, after Fujiwara (1916).

    `polynomial`: coefficients, highest power first, ``(..., n + 1)``.
    """
    order = np.arange(1, polynomial.shape[-1])
    sizes = np.abs(polynomial[..., 1:] / polynomial[..., :1]) ** (1.0 / order)
    return 2.0 * np.asarray(sizes.max(axis=-1, initial=0.0))


def _parts_on_axis(polynomial: FloatArray) -> tuple[FloatArray, ...]:
    """Return the polynomials E and O in omega^2 of p(j omega) = E(omega^2) + j omega O(omega^2).

    `polynomial`: coefficients of p, highest power first, ``(..., n + 1)``, as the results. E has
    the even and O the odd coefficients, with alternating signs.
    """
    halves = polynomial[..., ::-2][..., ::-1], polynomial[..., -2::-2][..., ::-1]
    return tuple(half * (-1.0) ** np.arange(half.shape[-1])[::-1] for half in halves)


def _quadratic(middle: FloatArray, product: FloatArray) -> AnyArray:
    """Return two numbers ``(..., 2)`` by their mean and their product, without cancellation.

    `middle`, `product`: mean and product of both numbers, ``(...)``. Where they are complex in any
    element of the batch, all are returned as complex numbers.
    """
    square = middle**2 - product  # of half the difference
    larger = middle + np.copysign(np.sqrt(np.maximum(square, 0.0)), middle)
    smaller = np.where(larger == 0.0, 0.0, product / np.where(larger == 0.0, 1.0, larger))
    complex_pair = square < 0.0
    if not np.any(complex_pair):
        return np.stack([larger, smaller], axis=-1)
    height = np.sqrt(np.maximum(-square, 0.0))
    pair = [
        np.where(complex_pair, middle + sign * height, r)
        for sign, r in ((1j, larger), (-1j, smaller))
    ]
    return np.stack(pair, axis=-1)


def _newton_step(polynomial: FloatArray, estimates: AnyArray) -> AnyArray:
    """Return the roots ``(..., n)`` after one Newton step of those that are isolated.

    `polynomial`: ``(..., n + 1)``. `estimates`: the roots before the step, ``(..., n)``. The errors
    of a cluster of roots are correlated; separate steps would destroy their accurate mean.
    """
    residual = value(polynomial, estimates)
    slope = value(derivative(polynomial), estimates)
    step = np.where(slope == 0.0, 0.0, residual / np.where(slope == 0.0, 1.0, slope))
    distances = np.abs(estimates[..., :, np.newaxis] - estimates[..., np.newaxis, :])
    distances[..., np.arange(estimates.shape[-1]), np.arange(estimates.shape[-1])] = np.inf
    isolated = np.abs(step) <= 1e-3 * distances.min(axis=-1)
    better = np.abs(value(polynomial, estimates - step)) < np.abs(residual)
    return np.where(isolated & better, estimates - step, estimates)
