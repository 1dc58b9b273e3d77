"""Polynomials with real coefficients, the constant first, one at a time and without memory."""

import cmath
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.compiled.compiler import lean

FloatArray = NDArray[np.float64]

_STEPS = 200
_LAST = 1e-11
"""After so small a step of Newton, over the root, it is exact: Newton squares what is left."""
_ROUGH = 1e-8
"""A step of so small a part of a root ends the search for a rough one."""
CHOOSE = np.array([[float(math.comb(n, k)) for k in range(32)] for n in range(32)])
"""Binomial coefficients, for derivatives."""


@lean
def degree_of(p: FloatArray) -> int:
    """Return the degree, zeros at the end left out."""
    last = p.size - 1
    while last > 0 and p[last] == 0.0:
        last -= 1
    return last


@lean
def value(p: FloatArray, degree: int, s: Any) -> Any:
    """Return the value at s, real or complex."""
    result = p[degree] + 0.0 * s
    for k in range(degree - 1, -1, -1):
        result = result * s + p[k]
    return result


@lean
def value_and_slope(p: FloatArray, degree: int, s: Any) -> Any:
    """Return the value and the derivative at s, real or complex."""
    result = p[degree] + 0.0 * s
    slope = 0.0 * s
    for k in range(degree - 1, -1, -1):
        slope = slope * s + result
        result = result * s + p[k]
    return result, slope


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
def positive_roots(p: FloatArray, work: FloatArray, edges: FloatArray, roots: FloatArray) -> int:
    """Write the positive roots at which p changes its sign, rising, and return their number.

    Between two roots of a derivative there is at most one of the polynomial. So the roots of
    all derivatives are found in turn, from the highest that has one root at most by the rule of
    Descartes; nothing can be missed or found twice.
    """
    last = degree_of(p)
    first = 0
    while first < last and p[first] == 0.0:
        first += 1
    level, changes, positive = last - first, 0, p[last] > 0.0
    for j in range(last - 1, first - 1, -1):
        if p[j] != 0.0 and (p[j] > 0.0) != positive:
            if changes == 1:
                break
            changes, positive = 1, not positive
        level = j - first
    if changes == 0:
        return 0
    count = 0
    for k in range(level, -1, -1):
        degree = last - first - k
        for j in range(degree + 1):
            work[j] = p[first + k + j] * CHOOSE[k + j, k]
        for j in range(count):
            edges[j] = roots[j]
        count = _between(work, degree, edges, count, roots)
    return count


@lean
def _between(p: FloatArray, degree: int, edges: FloatArray, count: int, roots: FloatArray) -> int:
    """Write the positive roots between the edges, of which each part has one at most."""
    lowest = 0
    while lowest < degree and p[lowest] == 0.0:
        lowest += 1
    found, left, left_positive = 0, 0.0, p[lowest] > 0.0
    for i in range(count + 1):
        right, right_positive = math.inf, p[degree] > 0.0
        if i < count:
            right = edges[i]
            height = value(p, degree, right)
            right_positive = left_positive if height == 0.0 else height > 0.0
        if right_positive != left_positive:
            if right == math.inf:
                guess = abs(p[lowest] / p[degree]) ** (1.0 / (degree - lowest))
                left, right = _beyond(p, degree, left, max(guess, left), right_positive)
            if left == 0.0:
                left, right = _below(p, degree, right, left_positive)
            roots[found] = _root(p, degree, left, right, right_positive)
            found += 1
        left, left_positive = right, right_positive
    return found


@lean
def _beyond(p: FloatArray, degree: int, low: float, guess: float, positive: bool) -> Any:
    """Return a bracket above `low`, beyond which p has the sign it has at infinity."""
    high = guess if guess > low else 2.0 * low
    for _ in range(_STEPS):
        if (value(p, degree, high) > 0.0) == positive:
            break
        low, high = high, 4.0 * high
    return low, high


@lean
def _below(p: FloatArray, degree: int, high: float, positive: bool) -> Any:
    """Return a bracket below `high`, below which p has the sign it has at zero."""
    low = 0.25 * high
    for _ in range(_STEPS):
        if (value(p, degree, low) > 0.0) == positive:
            break
        low, high = 0.25 * low, low
    return low, high


@lean
def _root(p: FloatArray, degree: int, low: float, high: float, rising: bool) -> float:
    """Return the one root in between, by Newton's steps; bisection where they lead out."""
    x = math.sqrt(low * high)
    for _ in range(_STEPS):
        height, slope = value_and_slope(p, degree, x)
        if height == 0.0:
            return x
        if (height > 0.0) == rising:
            high = x
        else:
            low = x
        new = x - height / slope
        if abs(new - x) <= _LAST * x:
            return new
        if not low < new < high:
            new = math.sqrt(low * high)
            if new in (low, high):
                return new
        x = new
    return x


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
