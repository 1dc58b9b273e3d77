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
    positive_roots,
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


class Room(NamedTuple):
    """Where one loop is worked on; each an array ``(32,)``, and a table ``(4, 32)``.

    The first four hold |N|^2, |D|^2 and N conj(D), as ``real + j omega imaginary``, in powers of
    omega^2.
    """

    above_squared: FloatArray
    below_squared: FloatArray
    real: FloatArray
    imaginary: FloatArray
    sum: FloatArray
    work: FloatArray
    edges: FloatArray
    roots: FloatArray
    squares: FloatArray
    both: FloatArray
    table: FloatArray


@lean
def vanishes(p: FloatArray, degree: int, omega: float) -> bool:
    """Return whether p(j omega) is zero to rounding."""
    size = 0.0
    for k in range(degree, -1, -1):
        size = size * omega + abs(p[k])
    return abs(value(p, degree, 1j * omega)) <= _VANISHED * size


@lean
def without_delay(
    above: FloatArray, m: int, below: FloatArray, n: int, room: Room, count: int, found: FloatArray
) -> int:
    """Write the crossings; L is real at the frequencies whose squares are in `room.squares`."""
    total = 0
    for i in range(count):
        omega = math.sqrt(room.squares[i])
        if value(room.real, (m + n) // 2, room.squares[i]) >= 0.0:
            continue
        if vanishes(above, m, omega) or vanishes(below, n, omega):
            continue
        if total < found.size:
            found[total] = _exact(above, m, below, n, 0.0, omega)
        total += 1
    return total


@lean
def _exact(
    above: FloatArray, m: int, below: FloatArray, n: int, delay: float, omega: float
) -> float:
    """Return a crossing that is nearly known, by Newton's steps on L itself.

    The squared polynomials lose digits where |L| is far from what its terms are.
    """
    for _ in range(_POLISH):
        a, a_slope = value_and_slope(above, m, 1j * omega)
        b, b_slope = value_and_slope(below, n, 1j * omega)
        a_square, b_square = a.real**2 + a.imag**2, b.real**2 + b.imag**2
        slope = (a_slope * a.conjugate()).real / a_square - delay
        slope -= (b_slope * b.conjugate()).real / b_square
        point = -a * b.conjugate()
        phase = math.atan2(point.imag, point.real) - omega * delay
        step = (phase - _TURN * np.round(phase / _TURN)) / slope
        if abs(step) > _CLOSE * omega:
            break
        omega -= step
        if abs(step) < _NEARLY * omega:
            break
    return omega


@lean
def turning_back(
    above: FloatArray, m: int, below: FloatArray, n: int, delay: float, room: Room
) -> None:
    """Write to `room.sum` the polynomial in omega^2 that is zero where the phase of L turns back.

    The phase of p(j w) rises by Re(p' conj p)/|p|^2.
    """
    total = room.sum
    total[:] = 0.0
    _add_rise(above, m, room.below_squared, n, 1.0, room)
    _add_rise(below, n, room.above_squared, m, -1.0, room)
    add_product(room.above_squared, m, room.below_squared, n, -delay, total)


@lean
def _add_rise(
    p: FloatArray, degree: int, squared: FloatArray, order: int, sign: float, room: Room
) -> None:
    """Add sign Re(p' conj p) times a squared size to `room.sum`."""
    if degree == 0:
        return
    slope, even, odd = room.table[0], room.table[1], room.table[2]
    even[:] = 0.0
    for j in range(degree):
        slope[j] = (j + 1) * p[j + 1]
    add_on_axis(slope, degree - 1, p, degree, even, odd)
    add_product(even, degree - 1, squared, order, sign, room.sum)


@lean
def with_delay(
    above: FloatArray,
    m: int,
    below: FloatArray,
    n: int,
    delay: float,
    room: Room,
    count: int,
    end: float,
    found: FloatArray,
) -> int:
    """Write the crossings up to `end` and return how many there are.

    The phase is monotone between the frequencies whose squares are in `room.both`.
    """
    total = 0
    left = _FIRST * (math.sqrt(room.both[0]) if count > 0 else end)
    beside = left
    for i in range(count + 1):
        right = min(math.sqrt(room.both[i]), end) if i < count else end
        if right <= left:
            continue
        low, high, left, beside = beside, right, right, right
        if vanishes(above, m, right) or vanishes(below, n, right):
            high, beside = right * (1.0 - _BESIDE), right * (1.0 + _BESIDE)
        side = -1.0 if value(room.imaginary, (m + n) // 2, low * high) > 0.0 else 1.0
        begin, _ = _turned(room, m + n, delay, side, low)
        stop, _ = _turned(room, m + n, delay, side, high)
        slope = (stop - begin) / (high - low)
        falling = slope < 0.0
        least = math.floor(min(begin, stop) / _TURN) + 1
        most = math.floor(max(begin, stop) / _TURN)
        for j in range(most - least + 1):
            target = _TURN * (most - j if falling else least + j)
            low, slope = _alone(room, m + n, delay, side, target, begin, slope, low, high)
            begin = target
            if total < found.size:
                found[total] = _exact(above, m, below, n, delay, low)
            total += 1
    return total


@lean
def _alone(
    room: Room,
    order: int,
    delay: float,
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
        phase, slope = _turned(room, order, delay, side, omega)
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
def _turned(room: Room, order: int, delay: float, side: float, omega: float) -> Any:
    """Return the phase of -L [rad] on one side of the real axis, turned back by the delay."""
    x = omega * omega
    real, real_slope = value_and_slope(room.real, order // 2, x)
    part, part_slope = value_and_slope(room.imaginary, order // 2, x)
    phase = side * math.atan2(omega * abs(part), -real)
    rise = real * (part + 2.0 * x * part_slope) - 2.0 * x * part * real_slope
    return phase - omega * delay, rise / (real * real + x * part * part) - delay


@lean
def end_of_turns(below: FloatArray, n: int, delay: float, room: Room) -> float:
    """Return how far [rad/s] the turns of a delay are followed, as the numpy twin."""
    furthest = 0.0
    for k in range(n):
        furthest = max(furthest, abs(below[k] / below[n]) ** (1.0 / (n - k)))
    quiet = room.sum
    for k in range(quiet.size):
        quiet[k] = QUIET * QUIET * room.below_squared[k] - room.above_squared[k]
    count = positive_roots(quiet, room.work, room.edges, room.roots)
    last = math.sqrt(room.roots[count - 1]) if count > 0 else 0.0
    end = max(last, 2.0 * PAST * furthest)
    return min(end + MORE * STEP / delay, MOST * STEP / delay)


@lean
def merged(first: FloatArray, m: int, second: FloatArray, n: int, both: FloatArray) -> int:
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
