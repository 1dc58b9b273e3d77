"""Polynomials with real or complex coefficients ``(..., n + 1)``, highest power first."""

import numpy as np

from tvclin.base.arrays import AnyArray, ComplexArray, FloatArray
from tvclin.kernels.choice import run
from tvclin.kernels.small_roots import COMPILED, PLAIN, small_roots

_NOTHING = 1e-300
"""A leading coefficient that is so small beside the largest is zero: its root is no number."""
_LOW = 4
"""The degree up to which roots are found one after the other."""


def value(polynomial: AnyArray, s: AnyArray) -> AnyArray:
    """Return the values at ``s (..., m)``; the leading axes broadcast."""
    if not polynomial.shape[-1]:
        return np.zeros_like(s)
    result = polynomial[..., 0, np.newaxis] + 0.0 * s
    for k in range(1, polynomial.shape[-1]):
        result *= s
        result += polynomial[..., k, np.newaxis]
    return result


def on_axis(polynomial: FloatArray, omega: FloatArray) -> AnyArray:
    """Return the values at j omega ``(..., m)``; the leading axes broadcast."""
    even, odd = _halves(polynomial)
    square = -(omega**2)
    values = value(even, square).astype(complex)
    values.imag = omega * value(odd, square)
    return values


def derivative(polynomial: AnyArray) -> AnyArray:
    """Return the derivative."""
    degree = polynomial.shape[-1] - 1
    return polynomial[..., :-1] * np.arange(degree, 0, -1)


def multiply(first: AnyArray, second: AnyArray) -> AnyArray:
    """Return the product; the leading axes broadcast."""
    m, n = first.shape[-1], second.shape[-1]
    shape = np.broadcast_shapes(first.shape[:-1], second.shape[:-1])
    product = np.zeros((*shape, m + n - 1), dtype=np.result_type(first, second))
    for k in range(m):
        product[..., k : k + n] += first[..., k, np.newaxis] * second
    return product


def add(first: AnyArray, second: AnyArray) -> AnyArray:
    """Return the sum of polynomials, also of different degree; the leading axes broadcast."""
    size = max(first.shape[-1], second.shape[-1])
    return np.asarray(_padded(first, size) + _padded(second, size))


def squared_size(polynomial: FloatArray) -> FloatArray:
    """Return |p(j omega)|^2 as a polynomial in omega^2."""
    even, odd = (_alternating(half) for half in _halves(polynomial))
    squares = multiply(even, even)
    if odd.shape[-1]:
        squares = add(squares, times_variable(multiply(odd, odd)))
    return squares


def imaginary_part(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return Im(first(j omega) conj(second(j omega)))/omega as a polynomial in omega^2."""
    (even, odd), (even_2, odd_2) = (
        [half * (-1.0) ** np.arange(half.shape[-1])[::-1] for half in _halves(polynomial)]
        for polynomial in (first, second)
    )
    return add(multiply(odd, even_2), -multiply(even, odd_2))


def times_variable(polynomial: AnyArray, power: int = 1) -> AnyArray:
    """Return the polynomial times a power of its variable."""
    return np.concatenate([polynomial, np.zeros((*polynomial.shape[:-1], power))], axis=-1)


def divide(polynomial: AnyArray, root: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Return quotient and remainder of the division by (s - root), by Horner's scheme."""
    columns = [polynomial[..., 0] + 0 * root]
    for k in range(1, polynomial.shape[-1]):
        columns.append(columns[-1] * root + polynomial[..., k])
    return np.stack(columns[:-1], axis=-1), columns[-1]


def roots(polynomial: FloatArray) -> AnyArray:
    """Return the roots, shape ``(..., n)``; real when all roots of the whole batch are real.

    Those of a quadratic come from their sum and product, those of cubics and quartics one after
    the other. Others are eigenvalues of the companion matrices. Two Newton steps each bring the
    small roots of a polynomial with roots of very different size to full relative accuracy.
    """
    degree = polynomial.shape[-1] - 1
    if degree == 0:
        return np.zeros((*polynomial.shape[:-1], 0))
    monic = polynomial[..., 1:] / polynomial[..., :1]
    if degree == 2:
        return _quadratic(-0.5 * monic[..., 0], monic[..., 1])
    if 2 < degree <= _LOW:
        return _of_low_degree(monic)
    found = _eigenvalues(monic)
    for _ in range(2):
        found = _newton(polynomial, found)
    return found


def roots_of_each(polynomial: FloatArray) -> ComplexArray:
    """Return the roots of polynomials ``(k, n + 1)`` that may begin with zeros, ``(k, n)``.

    NaN fills the rows of those that are of lower degree.
    """
    count, size = polynomial.shape
    found = np.full((count, size - 1), np.nan, dtype=complex)
    live = np.abs(polynomial) > _NOTHING * np.abs(polynomial).max(axis=-1, keepdims=True)
    zeros = np.where(np.any(live, axis=-1), np.argmax(live, axis=-1), size)
    for few in np.unique(zeros[zeros < size]):
        rows = zeros == few
        found[rows, : size - 1 - few] = roots(polynomial[rows, few:])
    return found


def _eigenvalues(monic: FloatArray) -> AnyArray:
    degree = monic.shape[-1]
    companion = np.zeros((*monic.shape[:-1], degree, degree))
    companion[..., 0, :] = -monic
    companion[..., np.arange(1, degree), np.arange(degree - 1)] = 1.0
    return np.linalg.eigvals(companion)


def _of_low_degree(monic: FloatArray) -> AnyArray:
    rows = np.concatenate([np.ones_like(monic[..., :1]), monic], axis=-1)
    rows = rows.reshape(-1, rows.shape[-1])
    if np.all(rows == rows[:1]):  # one vehicle in many winds
        rows = rows[:1]
    found = np.empty((len(rows), rows.shape[-1] - 1), dtype=complex)
    count = len(rows)
    run(small_roots, (rows, found), count, PLAIN * count, COMPILED * count)
    together = np.resize(found, monic.shape)
    return together if np.any(np.imag(together)) else np.real(together)


def bound(polynomial: FloatArray) -> FloatArray:
    """Return a number that no root exceeds in size, ``(...)``, after Fujiwara (1916)."""
    order = np.arange(1, polynomial.shape[-1])
    sizes = np.abs(polynomial[..., 1:] / polynomial[..., :1]) ** (1.0 / order)
    return 2.0 * np.asarray(sizes.max(axis=-1, initial=0.0))


def _halves(polynomial: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The even powers, and the odd ones over the variable, as polynomials in its square."""
    return polynomial[..., ::-2][..., ::-1], polynomial[..., -2::-2][..., ::-1]


def _alternating(polynomial: FloatArray) -> FloatArray:
    """The polynomial at minus its argument, but for the sign of the whole."""
    return polynomial * (-1.0) ** np.arange(polynomial.shape[-1])


def _padded(polynomial: FloatArray, size: int) -> FloatArray:
    width = [(0, 0)] * (polynomial.ndim - 1) + [(size - polynomial.shape[-1], 0)]
    return np.pad(polynomial, width)


def _quadratic(middle: FloatArray, product: FloatArray) -> AnyArray:
    """Two numbers by their mean and their product; none is a difference of nearly equal ones."""
    square = middle**2 - product
    far = middle + np.copysign(np.sqrt(np.maximum(square, 0.0)), middle)
    near = np.where(far == 0.0, 0.0, product / np.where(far == 0.0, 1.0, far))
    apart = square < 0.0
    if not np.any(apart):
        return np.stack([far, near], axis=-1)
    height = np.sqrt(np.maximum(-square, 0.0))
    pair = [np.where(apart, middle + sign * height, r) for sign, r in ((1j, far), (-1j, near))]
    return np.stack(pair, axis=-1)


def _newton(polynomial: FloatArray, found: AnyArray) -> AnyArray:
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
