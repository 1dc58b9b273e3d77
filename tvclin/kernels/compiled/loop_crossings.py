"""Where one loop crosses the negative real axis, from the real roots of polynomials.

Between the frequencies at which L without its delay is real, and those at which the phase of L
turns back, the phase is monotone. So every crossing lies alone in a known interval.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.compiled.compiler import lean
from tvclin.kernels.compiled.polynomials import (
    add_on_axis,
    add_product,
    add_square,
    on_axis,
    value,
    value_and_slope,
)
from tvclin.kernels.loop_grid import MORE, MOST, PAST, QUIET, STEP

FloatArray = NDArray[np.float64]

_TURN = 2.0 * math.pi
_STEPS = 100
_NEARLY = 1e-8
"""After such a step of Newton, over the frequency, the next would be rounding."""
_POLISH, _CLOSE = 3, 1e-3
"""Newton's steps on L itself, and how far they may lead, over the frequency."""
_VANISHED = 1e-13
_BESIDE = 1e-9
"""So far beside a pole or zero on the axis its neighbourhood begins."""
_FIRST = 1e-6
"""The first frequency, over the lowest at which anything happens."""


class Loop(NamedTuple):
    """One loop: numerator and denominator with their degrees, the delay, and what they make.

    The last four are |N|^2, |D|^2 and N conj(D), as ``real + j omega imaginary``, in powers of
    omega^2.
    """

    above: FloatArray
    m: int
    below: FloatArray
    n: int
    delay: float
    above_squared: FloatArray
    below_squared: FloatArray
    real: FloatArray
    imaginary: FloatArray


@lean
def square(loop: Loop) -> None:
    """Write |N|^2, |D|^2 and N conj(D) on the axis."""
    above, m, below, n = loop.above, loop.m, loop.below, loop.n
    loop.above_squared[:], loop.below_squared[:] = 0.0, 0.0
    loop.real[:], loop.imaginary[:] = 0.0, 0.0
    add_square(above, m, loop.above_squared)
    add_square(below, n, loop.below_squared)
    add_on_axis(above, m, below, n, loop.real, loop.imaginary)


@lean
def _vanishes(p: FloatArray, degree: int, omega: float) -> bool:
    """Return whether p(j omega) is zero to rounding."""
    size = 0.0
    for k in range(degree, -1, -1):
        size = size * omega + abs(p[k])
    height, _ = on_axis(p, degree, omega)
    return height.real**2 + height.imag**2 <= (_VANISHED * size) ** 2


@lean
def _jumps(loop: Loop, omega: float) -> bool:
    """Return whether the phase of L jumps, at a pole or zero on the axis."""
    return _vanishes(loop.above, loop.m, omega) or _vanishes(loop.below, loop.n, omega)


@lean
def without_delay(loop: Loop, squares: FloatArray, count: int, found: FloatArray) -> int:
    """Write the crossings; L is real at the frequencies with these squares."""
    total = 0
    for i in range(count):
        omega = math.sqrt(squares[i])
        if value(loop.real, (loop.m + loop.n) // 2, squares[i]) >= 0.0 or _jumps(loop, omega):
            continue
        if total < found.size:
            found[total] = _exact(loop, omega)
        total += 1
    return total


@lean
def _exact(loop: Loop, omega: float) -> float:
    """Return a crossing that is nearly known, by Newton's steps on L itself.

    The squared polynomials lose digits where |L| is far from what its terms are.
    """
    for _ in range(_POLISH):
        a, a_slope = on_axis(loop.above, loop.m, omega)
        b, b_slope = on_axis(loop.below, loop.n, omega)
        a_square, b_square = a.real**2 + a.imag**2, b.real**2 + b.imag**2
        slope = (a_slope * a.conjugate()).real / a_square - loop.delay
        slope -= (b_slope * b.conjugate()).real / b_square
        point = -a * b.conjugate()
        phase = math.atan2(point.imag, point.real) - omega * loop.delay
        step = (phase - _TURN * np.round(phase / _TURN)) / slope
        if abs(step) > _CLOSE * omega:
            break
        omega -= step
        if abs(step) < _NEARLY * omega:
            break
    return omega


@lean
def turning_back(loop: Loop, total: FloatArray, table: FloatArray) -> None:
    """Write the polynomial in omega^2 that is zero where the phase of L turns back.

    The phase of p(j w) rises by Re(p' conj p)/|p|^2.
    """
    m, n = loop.m, loop.n
    total[:] = 0.0
    _add_rise(loop.above, m, loop.below_squared, n, 1.0, total, table)
    _add_rise(loop.below, n, loop.above_squared, m, -1.0, total, table)
    add_product(loop.above_squared, m, loop.below_squared, n, -loop.delay, total)


@lean
def _add_rise(
    p: FloatArray,
    degree: int,
    squared: FloatArray,
    order: int,
    sign: float,
    total: FloatArray,
    table: FloatArray,
) -> None:
    """Add sign Re(p' conj p) times a squared size to the total."""
    if degree == 0:
        return
    slope, even, odd = table[0], table[1], table[2]
    even[:], odd[:] = 0.0, 0.0
    for j in range(degree):
        slope[j] = (j + 1) * p[j + 1]
    add_on_axis(slope, degree - 1, p, degree, even, odd)
    add_product(even, degree - 1, squared, order, sign, total)


@lean
def with_delay(loop: Loop, both: FloatArray, count: int, end: float, found: FloatArray) -> int:
    """Write the crossings up to `end` and return how many there are.

    The phase is monotone between the frequencies with these squares.
    """
    total = 0
    left = _FIRST * (math.sqrt(both[0]) if count > 0 else end)
    beside = left
    for i in range(count + 1):
        right = min(math.sqrt(both[i]), end) if i < count else end
        if right <= left:
            continue
        low, high, left, beside = beside, right, right, max(beside, right)
        if _jumps(loop, right):
            high, beside = right * (1.0 - _BESIDE), right * (1.0 + _BESIDE)
        if high <= low:  # a double root of what is zero at a jump
            continue
        side = -1.0 if value(loop.imaginary, (loop.m + loop.n) // 2, low * high) > 0.0 else 1.0
        begin, _ = _turned(loop, side, low)
        stop, _ = _turned(loop, side, high)
        slope = (stop - begin) / (high - low)
        falling = slope < 0.0
        least = math.floor(min(begin, stop) / _TURN) + 1
        most = math.floor(max(begin, stop) / _TURN)
        for j in range(most - least + 1):
            target = _TURN * (most - j if falling else least + j)
            low, slope = _alone(loop, side, target, begin, slope, low, high)
            begin = target
            if total < found.size:
                found[total] = _exact(loop, low)
            total += 1
    return total


@lean
def _alone(
    loop: Loop,
    side: float,
    target: float,
    begin: float,
    slope: float,
    low: float,
    high: float,
) -> Any:
    """Return where the phase, monotone from `begin` at `low`, meets its target, and its slope."""
    falling = begin > target
    omega = low + (target - begin) / slope
    if not low < omega < high:
        omega = 0.5 * (low + high)
    for _ in range(_STEPS):
        phase, slope = _turned(loop, side, omega)
        if (phase > target) == falling:
            low = omega
        else:
            high = omega
        new = omega - (phase - target) / slope
        if abs(new - omega) <= _NEARLY * omega:
            return new, slope
        if not low < new < high:
            new = 0.5 * (low + high)
            if new in (low, high):
                break
        omega = new
    return omega, slope


@lean
def _turned(loop: Loop, side: float, omega: float) -> Any:
    """Return the phase of -L [rad] on one side of the real axis, turned back by the delay."""
    x, degree = omega * omega, (loop.m + loop.n) // 2
    real, real_slope = value_and_slope(loop.real, degree, x)
    part, part_slope = value_and_slope(loop.imaginary, degree, x)
    phase = side * math.atan2(omega * abs(part), -real)
    rise = real * (part + 2.0 * x * part_slope) - 2.0 * x * part * real_slope
    return phase - omega * loop.delay, rise / (real * real + x * part * part) - loop.delay


@lean
def growing_quiet(loop: Loop, total: FloatArray) -> None:
    """Write the polynomial in omega^2 that is positive where |L| is below `QUIET`."""
    for k in range(total.size):
        total[k] = QUIET * QUIET * loop.below_squared[k] - loop.above_squared[k]


@lean
def end_of_turns(loop: Loop, last: float) -> float:
    """Return how far [rad/s] the turns of a delay are followed, as the numpy twin.

    Beyond `last` [rad/s] the loop is quiet.
    """
    below, n, furthest = loop.below, loop.n, 0.0
    for k in range(n):
        furthest = max(furthest, abs(below[k] / below[n]) ** (1.0 / (n - k)))
    end = max(last, 2.0 * PAST * furthest)
    return min(end + MORE * STEP / loop.delay, MOST * STEP / loop.delay)


@lean
def merge(first: FloatArray, m: int, second: FloatArray, n: int, both: FloatArray) -> int:
    """Write two rising rows as one and return its length."""
    i, k = 0, 0
    while i < m or k < n:
        if k == n or (i < m and first[i] <= second[k]):
            both[i + k] = first[i]
            i += 1
        else:
            both[i + k] = second[k]
            k += 1
    return m + n
