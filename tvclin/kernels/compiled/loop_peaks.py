"""Where the sensitivities of one loop are largest.

The frequency rises in steps that are short beside the distance to the nearest pole or zero. Where
the slope of a size changes from up to down, the place of its zero is refined. Sizes are kept as
squares, and slopes are those of their logarithms.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.compiled.compiler import lean
from tvclin.kernels.compiled.polynomials import degree_of, on_axis, rough_roots
from tvclin.kernels.loop_peaks import AT_INFINITY

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

_STEP, _TURN = 0.25, 0.5
"""A step, over the distance to the nearest root, and the phase [rad] the delay turns in it."""
_FIRST = 1e-3
"""The first step, over the others: at zero itself every slope is zero."""
_ON_AXIS, _AT_ZERO = 1e-9, 1e-12
"""A root is nowhere nearer than the first of its size; the second of the largest is at zero."""
_FAR, _BEYOND, _PAST = 1e7, 1e2, 10.0
"""Zeros farther out than the first times the fastest pole are rounding. Without a delay the
second times the largest root is the end, and beyond the third |L| falls for ever."""
_FLAT = 0.3
"""Where neither tangent changes the logarithm of a size by more than this in a step, a summit in
between is higher by less than twice that change."""
_MOST, _STEPS, _CLOSE = 1_000_000, 100, 1e-12
_HIGHER = 1.0 + 1e-14
"""By what a square must be larger to count as such."""


@lean
def peaks_of_one(
    above: FloatArray,
    below: FloatArray,
    delay: float,
    end: float,
    scratch: FloatArray,
    roots: ComplexArray,
    tops: FloatArray,
) -> None:
    """Write the largest |S|, |T| and |S - T|/2 of a stable loop and where, `tops` ``(3, 2)``.

    Parameters
    ----------
    above, below : ndarray
        Numerator and denominator, ``(n + 1,)``.
    delay, end : float
        Delay [s], and how far its turns are followed [rad/s].
    scratch, roots : ndarray
        Work space, ``(>= 4, >= n + 1)`` and ``(>= 3 n,)``.
    tops : ndarray
        Where to write.
    """
    m, n = degree_of(above), below.size - 1
    count, largest = _all_roots(above, m, below, n, scratch, roots)
    if delay == 0.0:
        end = _BEYOND * largest
    here, there = scratch[0], scratch[1]
    _look(above, m, below, n, delay, 0.0, here)
    for kind in range(3):
        tops[kind, 0], tops[kind, 1] = here[kind], 0.0
    omega = _FIRST * _step(0.0, roots, count, delay)
    _look(above, m, below, n, delay, omega, here)
    for _ in range(_MOST):
        if omega >= end or (omega > _PAST * largest and _settled(here, tops)):
            break
        new = min(omega + _step(omega, roots, count, delay), end)
        _look(above, m, below, n, delay, new, there)
        for kind in range(3):
            _note(tops, kind, there[kind], new)
            if here[3 + kind] > 0.0 >= there[3 + kind] and _promising(
                here, there, kind, new - omega, tops[kind, 0]
            ):
                where = _summit(above, m, below, n, delay, omega, new, here, there, kind)
                a, _, b, _ = _parts(above, m, below, n, delay, where)
                _note(tops, kind, _size(a, b, kind), where)
        here, there = there, here
        omega = new
    for kind in range(3):
        limit, height = AT_INFINITY[kind], math.sqrt(tops[kind, 0])
        tops[kind, 0] = max(height, limit)
        if height <= limit:
            tops[kind, 1] = math.inf


@lean
def _note(tops: FloatArray, kind: int, square: float, omega: float) -> None:
    if square > _HIGHER * tops[kind, 0]:
        tops[kind, 0], tops[kind, 1] = square, omega


@lean
def _promising(
    here: FloatArray, there: FloatArray, kind: int, width: float, highest: float
) -> bool:
    """Return whether a summit between two frequencies may be the highest."""
    steepest = width * max(here[3 + kind], -there[3 + kind])
    return steepest > _FLAT or max(here[kind], there[kind]) * math.exp(4.0 * steepest) > highest


@lean
def _settled(here: FloatArray, tops: FloatArray) -> bool:
    """Return whether no size rises above the highest while |L| stays below what it is here."""
    if here[0] == 0.0:
        return False
    size = math.sqrt(here[1] / here[0])
    if size >= 1.0:
        return False
    most = 1.0 / (1.0 - size)
    if most * most > tops[0, 0] or (size * most) ** 2 > tops[1, 0]:
        return False
    return (0.5 * (1.0 + size) * most) ** 2 <= tops[2, 0]


@lean
def _parts(above: FloatArray, m: int, below: FloatArray, n: int, delay: float, omega: float) -> Any:
    """Return numerator, with the delay, and denominator at j omega, each with its slope in s."""
    a, a_slope = on_axis(above, m, omega)
    b, b_slope = on_axis(below, n, omega)
    if delay > 0.0:
        late = complex(math.cos(omega * delay), -math.sin(omega * delay))
        a_slope = (a_slope - delay * a) * late
        a = a * late
    return a, a_slope, b, b_slope


@lean
def _square(z: complex) -> float:
    return z.real * z.real + z.imag * z.imag


@lean
def _growth(z: complex, z_slope: complex) -> float:
    """Return d ln|z(j omega)|/d omega from z and dz/ds; zero where z is."""
    square = _square(z)
    return -(z_slope * z.conjugate()).imag / square if square > 0.0 else 0.0


@lean
def _top(a: complex, b: complex, kind: int) -> complex:
    """Return what stands over N + D: in S, in T and in (S - T)/2."""
    if kind == 0:
        return b
    return a if kind == 1 else 0.5 * (b - a)


@lean
def _size(a: complex, b: complex, kind: int) -> float:
    return _square(_top(a, b, kind)) / _square(a + b)


@lean
def _look(
    above: FloatArray,
    m: int,
    below: FloatArray,
    n: int,
    delay: float,
    omega: float,
    seen: FloatArray,
) -> None:
    """Write the three squares, and behind them the slopes of the logarithms of the sizes."""
    a, a_slope, b, b_slope = _parts(above, m, below, n, delay, omega)
    closed = _growth(a + b, a_slope + b_slope)
    for kind in range(3):
        seen[kind] = _size(a, b, kind)
        seen[3 + kind] = _growth(_top(a, b, kind), _top(a_slope, b_slope, kind)) - closed


@lean
def _summit(
    above: FloatArray,
    m: int,
    below: FloatArray,
    n: int,
    delay: float,
    low: float,
    high: float,
    here: FloatArray,
    there: FloatArray,
    kind: int,
) -> float:
    """Return where a slope comes down through zero, after Chandrupatla (1997)."""
    x1, f1, x2, f2 = high, there[3 + kind], low, here[3 + kind]
    share = 0.5
    for _ in range(_STEPS):
        x = x1 + share * (x2 - x1)
        a, a_slope, b, b_slope = _parts(above, m, below, n, delay, x)
        f = _growth(_top(a, b, kind), _top(a_slope, b_slope, kind))
        f -= _growth(a + b, a_slope + b_slope)
        if (f > 0.0) == (f1 > 0.0):
            x3, f3 = x1, f1
        else:
            x3, f3, x2, f2 = x2, f2, x1, f1
        x1, f1 = x, f
        if f == 0.0 or abs(x2 - x1) <= _CLOSE * x1:
            return x1 if abs(f1) < abs(f2) else x2
        xi, phi = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
        share = 0.5
        if phi * phi < xi and (1.0 - phi) ** 2 < 1.0 - xi:
            share = f1 / (f2 - f1) * f3 / (f2 - f3)
            share += (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
        least = 0.5 * _CLOSE * x1 / abs(x2 - x1)
        share = min(max(share, least), 1.0 - least)
    return x1


@lean
def _all_roots(
    above: FloatArray, m: int, below: FloatArray, n: int, scratch: FloatArray, roots: ComplexArray
) -> Any:
    """Write closed-loop poles, poles and zeros; return how many, and the size of the largest.

    One of each pair, and none at zero.
    """
    work, closed = scratch[0], scratch[1]
    for k in range(n + 1):
        closed[k] = below[k] + above[k]
    count = rough_roots(closed[: n + 1], work, roots)
    count += rough_roots(below, work, roots[count:])
    fastest = 0.0
    for k in range(count):
        fastest = max(fastest, abs(roots[k]))
    count += rough_roots(above, work, roots[count:])
    kept, largest = 0, 0.0
    for k in range(count):
        size = abs(roots[k])
        if _AT_ZERO * fastest < size < _FAR * fastest:
            roots[kept] = roots[k]
            largest = max(largest, size)
            kept += 1
    return kept, largest


@lean
def _step(omega: float, roots: ComplexArray, count: int, delay: float) -> float:
    """Return how far away the next frequency may be [rad/s]."""
    nearest = math.inf
    for k in range(count):
        root = roots[k]
        apart = omega - root.imag
        square = root.real * root.real + apart * apart
        floor = _ON_AXIS * _ON_AXIS * _square(root)
        nearest = min(nearest, max(square, floor))
    step = _STEP * math.sqrt(nearest)
    return min(step, _TURN / delay) if delay > 0.0 else step
