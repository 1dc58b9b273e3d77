"""Polynomials with real coefficients, the constant first, one at a time and without memory."""

import cmath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.compiled.compiler import lean

FloatArray = NDArray[np.float64]

_ROUGH = 1e-8
"""A step of so small a part of a root ends the search for a rough one."""


@lean
def degree_of(p: FloatArray) -> int:
    """Return the degree, zeros at the end left out."""
    last = p.size - 1
    while last > 0 and p[last] == 0.0:
        last -= 1
    return last


@lean
def value(p: FloatArray, degree: int, x: float) -> float:
    """Return the value at x."""
    result = p[degree]
    for k in range(degree - 1, -1, -1):
        result = result * x + p[k]
    return result


@lean
def value_and_slope(p: FloatArray, degree: int, x: float) -> Any:
    """Return the value and the derivative at x."""
    result, slope = p[degree], 0.0
    for k in range(degree - 1, -1, -1):
        slope = slope * x + result
        result = result * x + p[k]
    return result, slope


@lean
def on_axis(p: FloatArray, degree: int, omega: float) -> Any:
    """Return the value and the derivative at j omega, from the even and the odd powers."""
    x, even_degree = -omega * omega, degree - degree % 2
    even, even_slope = p[even_degree], 0.0
    odd, odd_slope = p[degree] if degree % 2 else 0.0, 0.0
    for k in range(even_degree - 2, -1, -2):
        even_slope = even_slope * x + even
        even = even * x + p[k]
        odd_slope = odd_slope * x + odd
        odd = odd * x + p[k + 1]
    slope = complex(odd + 2.0 * x * odd_slope, 2.0 * omega * even_slope)
    return complex(even, omega * odd), slope


@lean
def add_product(
    p: FloatArray, m: int, q: FloatArray, n: int, factor: float, total: FloatArray
) -> None:
    """Add factor p q to the total."""
    for i in range(m + 1):
        scaled = factor * p[i]
        for k in range(n + 1):
            total[i + k] += scaled * q[k]


@lean
def add_on_axis(
    p: FloatArray, m: int, q: FloatArray, n: int, even: FloatArray, odd: FloatArray
) -> None:
    """Add p(j w) conj(q(j w)) to even(w^2) + j w odd(w^2)."""
    for i in range(m + 1):
        for k in range(n + 1):
            turn = (i - k) & 3  # (j w)^i (-j w)^k = j^(i - k) w^(i + k)
            product = p[i] * q[k] if turn < 2 else -p[i] * q[k]
            if turn & 1:
                odd[(i + k) // 2] += product
            else:
                even[(i + k) // 2] += product


@lean
def add_square(p: FloatArray, degree: int, square: FloatArray) -> None:
    """Add |p(j w)|^2 in powers of w^2."""
    for i in range(degree + 1):
        square[i] += p[i] * p[i]
        sign = -2.0
        for j in range(1, min(i, degree - i) + 1):
            square[i] += sign * p[i - j] * p[i + j]
            sign = -sign


@lean
def rough_roots(p: FloatArray, work: FloatArray, roots: NDArray[np.complex128]) -> int:
    """Write one root of each pair, and all real roots, to a few digits; return how many.

    Laguerre's steps from zero, and division by what was found.
    """
    degree = degree_of(p)
    for k in range(degree + 1):
        work[k] = p[k]
    count = 0
    while degree > 0:
        if work[0] == 0.0:
            root = 0.0 + 0.0j
        elif degree == 1:
            root = complex(-work[0] / work[1])
        else:
            root = _laguerre(work, degree)
        if abs(root.imag) <= 1e-6 * abs(root):
            roots[count] = complex(root.real)
            for k in range(degree - 1, -1, -1):
                work[k] += root.real * work[k + 1]
            drop = 1
        else:
            roots[count] = complex(root.real, abs(root.imag))
            total, product = 2.0 * root.real, root.real**2 + root.imag**2
            for k in range(degree - 1, -1, -1):
                work[k] += total * work[k + 1]
                if k + 2 <= degree:
                    work[k] -= product * work[k + 2]
            drop = 2
        for k in range(degree - drop + 1):
            work[k] = work[k + drop]
        degree -= drop
        count += 1
    return count


@lean
def _laguerre(p: FloatArray, degree: int) -> complex:
    """Return the root to which Laguerre's steps lead from zero."""
    s = 0.0j
    for _ in range(40):
        a, b, c = complex(p[degree]), 0.0j, 0.0j
        for k in range(degree - 1, -1, -1):
            c = c * s + b
            b = b * s + a
            a = a * s + p[k]
        if a == 0.0:
            return s
        spread = cmath.sqrt((degree - 1) * ((degree - 1) * b * b - 2.0 * degree * a * c))
        below = b + spread if abs(b + spread) > abs(b - spread) else b - spread
        if below == 0.0:
            below = complex(abs(a) + 1e-300)
        step = degree * a / below
        s -= step
        if abs(step) <= _ROUGH * abs(s):
            return s
    return s
