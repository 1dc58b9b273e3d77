"""Roots of real polynomials of low degree, case by case."""

from typing import Any

import numpy as np

from tvclin.kernels.source import bare, kernel

PLAIN, COMPILED = 5e-5, 1e-6
"""About how many seconds a polynomial takes, in plain Python and as machine code."""
_STEPS = 60
"""Of an iteration, which takes ten or so; a cluster more."""
_POLISHED = 2
"""Steps of Newton on the polynomial itself: one, and one for what it leaves."""
_ALONE = 1e-3
"""A root is moved by no more than this part of its distance from the next one: the errors of a
cluster belong together, and moving them one by one would spoil what they have in common."""
_ROUNDING = 4.0 * 2.0**-52
"""An iteration ends where a step is below this part of the root."""


@kernel
def small_roots(polynomials: Any, out: Any, first: int, last: int) -> None:
    """Write the roots of ``polynomials (n, degree + 1)`` to ``out (n, degree)``, complex.

    The highest coefficient comes first and is one. One root after the other is found by Laguerre's
    iteration from zero on and divided out, the smaller ones first, which is stable; the last two
    come from their sum and product. Two steps of Newton's on the polynomial itself bring small
    roots beside large ones to full relative accuracy.
    """
    work = np.empty(polynomials.shape[1])
    for case in range(first, last):
        degree = polynomials.shape[1] - 1
        for k in range(degree + 1):
            work[k] = polynomials[case, k]
        while degree > 2:
            root = _one_root(work, degree)
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
            out[case, 0], out[case, 1] = _two_roots(-0.5 * work[1], work[2])
        elif degree == 1:
            out[case, 0] = complex(-work[1], 0.0)
        for _ in range(_POLISHED):
            for k in range(out.shape[1]):
                out[case, k] = _polished(polynomials, out, case, k)


@bare
def _divide(work: Any, degree: int, first: float, second: float) -> None:
    """Divide in place by s + first, or where `second` is not zero by s^2 + first s + second."""
    for k in range(1, degree + 1):
        work[k] -= first * work[k - 1]
        if second != 0.0 and k > 1:
            work[k] -= second * work[k - 2]


@bare
def _one_root(work: Any, degree: int) -> complex:
    """Return a root, by Laguerre's iteration; a real one where rounding cannot tell."""
    root = complex(0.0, 0.0)
    if work[degree] == 0.0:
        return root
    for _ in range(_STEPS):
        level, slope, bend = complex(work[0], 0.0), 0.0 * root, 0.0 * root
        error = abs(work[0])
        size = abs(root)
        for k in range(1, degree + 1):
            bend = bend * root + slope
            slope = slope * root + level
            level = level * root + work[k]
            error = error * size + abs(level)
        if abs(level) <= 0.25 * _ROUNDING * error:
            break
        first = slope / level
        second = first * first - 2.0 * bend / level
        spread = np.sqrt((degree - 1.0) * (degree * second - first * first))
        divisor = first + spread
        if abs(first - spread) > abs(divisor):
            divisor = first - spread
        if divisor == 0.0:
            break
        step = degree / divisor
        root -= step
        if abs(step) <= _ROUNDING * abs(root):
            break
    real, level, error = root.real, work[0], abs(work[0])
    for k in range(1, degree + 1):
        level = level * real + work[k]
        error = error * abs(real) + abs(level)
    if abs(level) <= _ROUNDING * error:
        return complex(real, 0.0)
    return root


@bare
def _polished(polynomials: Any, out: Any, case: int, k: int) -> complex:
    """Return a root after one step of Newton's, if it stands alone and gets better."""
    root = out[case, k]
    apart = np.inf
    for other in range(out.shape[1]):
        if other != k:
            apart = min(apart, abs(root - out[case, other]))
    level, slope = complex(polynomials[case, 0], 0.0), 0.0 * root
    for j in range(1, polynomials.shape[1]):
        slope = slope * root + level
        level = level * root + polynomials[case, j]
    if slope == 0.0 or abs(level) > _ALONE * apart * abs(slope):
        return root
    moved = root - level / slope
    left = complex(polynomials[case, 0], 0.0)
    for j in range(1, polynomials.shape[1]):
        left = left * moved + polynomials[case, j]
    return moved if abs(left) < abs(level) else root


@bare
def _two_roots(middle: float, product: float) -> tuple[complex, complex]:
    """Return two roots by their mean and product; none is a difference of nearly equal numbers."""
    square = middle * middle - product
    if square < 0.0:
        height = np.sqrt(-square)
        return complex(middle, height), complex(middle, -height)
    far = middle + np.sqrt(square) if middle >= 0.0 else middle - np.sqrt(square)
    near = product / far if far != 0.0 else 0.0
    return complex(far, 0.0), complex(near, 0.0)
