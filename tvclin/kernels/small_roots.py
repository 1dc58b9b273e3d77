"""Roots of real polynomials of low degree, by deflation, case by case."""

import numpy as np

from tvclin.base.arrays import ComplexArray, FloatArray
from tvclin.kernels.source import allocation_free, kernel

PLAIN, COMPILED = 5e-5, 1e-6
"""About how many seconds a polynomial takes, in plain Python and as machine code."""
_MAX_ITERATIONS = 60
"""Largest number of Laguerre iterations, of which ten or so suffice, and more in a cluster."""
_NEWTON_ITERATIONS = 2
"""Newton iterations on the original polynomial."""
_MAX_STEP_OVER_DISTANCE = 1e-3
"""Largest Newton step over the distance to the next root: the errors of a cluster are correlated,
and separate steps would destroy their accurate mean."""
_LAST_RELATIVE_STEP = 4.0 * 2.0**-52
"""Step over the root at which an iteration ends."""


@kernel
def small_roots(polynomials: FloatArray, out: ComplexArray, first: int, last: int) -> None:
    """Write the roots of ``polynomials (n, degree + 1)`` to ``out (n, degree)``, complex.

    The coefficient of the highest power comes first and is one; the roots have no order. Cases from
    `first` up to `last` are computed.
    The roots are found by Laguerre's iteration from zero on and deflated, the smaller ones first,
    which is stable; the last two by their sum and product. Two Newton steps on the polynomial
    itself bring small roots to full relative accuracy beside large ones.
    """
    work = np.empty(polynomials.shape[1])
    for case in range(first, last):
        degree = polynomials.shape[1] - 1
        for k in range(degree + 1):
            work[k] = polynomials[case, k]
        while degree > 2:
            root = _laguerre_root(work, degree)
            degree -= 1
            out[case, degree] = root
            if root.imag == 0.0:
                _divide(work, degree, -root.real, 0.0)
            else:
                degree -= 1
                out[case, degree] = root.conjugate()
                size = root.real * root.real + root.imag * root.imag
                _divide(work, degree, -2.0 * root.real, size)
        if degree == 2:
            out[case, 0], out[case, 1] = _quadratic_roots(-0.5 * work[1], work[2])
        elif degree == 1:
            out[case, 0] = complex(-work[1], 0.0)
        for _ in range(_NEWTON_ITERATIONS):
            for k in range(out.shape[1]):
                out[case, k] = _polished(polynomials, out, case, k)


@allocation_free
def _divide(work: FloatArray, degree: int, first: float, second: float) -> None:
    """Divide a polynomial in place by s + first, or s^2 + first s + second if `second` is not zero.

    `work`: coefficients, highest power first, the first one; numbers 0 to `degree` become those of
    the quotient, whose degree this is. The remainder is neglected.
    """
    for k in range(1, degree + 1):
        work[k] -= first * work[k - 1]
        if second != 0.0 and k > 1:
            work[k] -= second * work[k - 2]


@allocation_free
def _laguerre_root(work: FloatArray, degree: int) -> complex:
    """Return a root by Laguerre's iteration from zero; real where rounding cannot distinguish it.

    `work`: coefficients, highest power first, up to number `degree`, the degree of the polynomial.
    """
    root = complex(0.0, 0.0)
    if work[degree] == 0.0:
        return root
    for _ in range(_MAX_ITERATIONS):
        # of the polynomial at the iterate, by Horner's scheme
        value, slope, half_curvature = complex(work[0], 0.0), 0.0 * root, 0.0 * root
        error = abs(work[0])
        size = abs(root)
        for k in range(1, degree + 1):
            half_curvature = half_curvature * root + slope
            slope = slope * root + value
            value = value * root + work[k]
            error = error * size + abs(value)  # bound of the roundings, in units of one
        if abs(value) <= 0.25 * _LAST_RELATIVE_STEP * error:
            break
        # sums over all roots r of 1/(root - r) and of its square
        first = slope / value
        second = first * first - 2.0 * half_curvature / value
        spread = np.sqrt((degree - 1.0) * (degree * second - first * first))
        divisor = first + spread
        if abs(first - spread) > abs(divisor):
            divisor = first - spread
        if divisor == 0.0:
            break
        step = degree / divisor
        root -= step
        if abs(step) <= _LAST_RELATIVE_STEP * abs(root):
            break
    # the polynomial at the real part: zero within rounding if the root may be real
    real, value, error = root.real, work[0], abs(work[0])
    for k in range(1, degree + 1):
        value = value * real + work[k]
        error = error * abs(real) + abs(value)
    if abs(value) <= _LAST_RELATIVE_STEP * error:
        return complex(real, 0.0)
    return root


@allocation_free
def _polished(polynomials: FloatArray, out: ComplexArray, case: int, k: int) -> complex:
    """Return a root after a Newton step, or as it is if it is clustered or the residual grows.

    `polynomials`: ``(n, degree + 1)``, highest power first. `out`: roots ``(n, degree)``, of which
    number k of polynomial number `case` is taken.
    """
    root = out[case, k]
    distance = np.inf
    for other in range(out.shape[1]):
        if other != k:
            distance = min(distance, abs(root - out[case, other]))
    value, slope = complex(polynomials[case, 0], 0.0), 0.0 * root
    for j in range(1, polynomials.shape[1]):
        slope = slope * root + value
        value = value * root + polynomials[case, j]
    if slope == 0.0 or abs(value) > _MAX_STEP_OVER_DISTANCE * distance * abs(slope):
        return root
    iterate = root - value / slope
    residual = complex(polynomials[case, 0], 0.0)
    for j in range(1, polynomials.shape[1]):
        residual = residual * iterate + polynomials[case, j]
    return iterate if abs(residual) < abs(value) else root


@allocation_free
def _quadratic_roots(middle: float, product: float) -> tuple[complex, complex]:
    """Return the roots of s^2 - 2 middle s + product, without cancellation.

    `middle` is their mean. A complex pair begins with the positive imaginary part, a real pair with
    the root of larger size.
    """
    square = middle * middle - product
    if square < 0.0:
        height = np.sqrt(-square)
        return complex(middle, height), complex(middle, -height)
    larger = middle + np.sqrt(square) if middle >= 0.0 else middle - np.sqrt(square)
    smaller = product / larger if larger != 0.0 else 0.0
    return complex(larger, 0.0), complex(smaller, 0.0)
