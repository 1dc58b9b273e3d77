"""Margins of a block of loops: the verdict, every crossing, and the peaks.

The polynomials of all loops are made first, so that their roots are searched for together.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.compiled.compiler import compiled, lean
from tvclin.kernels.compiled.loop_crossings import (
    Loop,
    end_of_turns,
    growing_quiet,
    merge,
    square,
    turning_back,
    with_delay,
    without_delay,
)
from tvclin.kernels.compiled.loop_peaks import peaks_of_one
from tvclin.kernels.compiled.polynomials import degree_of, on_axis
from tvclin.kernels.compiled.positive_roots import SIZE, Searches, positive_roots, searches
from tvclin.kernels.compiled.stability import UNSURE, moved_by_delay, polished, unstable_roots

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
Parts = tuple[FloatArray, FloatArray, FloatArray]
"""Numerators, denominators and delays, the constant first."""

BLOCK = 32
"""Loops whose polynomials are worked on together."""
_TURN = 2.0 * math.pi


class Found(NamedTuple):
    """Results of the cases ``(k,)``; the rows are filled with NaN.

    `crossed` and `needed` are how many gain and phase crossings there are.
    """

    poles: IntArray
    gains: FloatArray
    phases: FloatArray
    places: FloatArray
    factors: FloatArray
    crossed: IntArray
    needed: IntArray


class Room(NamedTuple):
    """Where a block of loops is worked on: polynomials and their roots, a row for each loop."""

    above_squared: FloatArray
    below_squared: FloatArray
    real: FloatArray
    imaginary: FloatArray
    sum: FloatArray
    roots: FloatArray
    counts: IntArray
    squares: FloatArray
    real_counts: IntArray
    ends: FloatArray
    both: FloatArray
    table: FloatArray
    work: Searches


@compiled
def block_room() -> Room:
    """Return room for a block."""
    rows, counts = np.zeros((7, BLOCK, SIZE)), np.zeros((2, BLOCK), dtype=np.intp)
    return Room(
        rows[0],
        rows[1],
        rows[2],
        rows[3],
        rows[4],
        rows[5],
        counts[0],
        rows[6],
        counts[1],
        np.zeros(BLOCK),
        np.zeros(2 * SIZE),
        np.zeros((4, SIZE)),
        searches(BLOCK),
    )


@lean
def _loop(parts: Parts, case: int, room: Room, i: int) -> Loop:
    """Return a loop, the i-th of its block."""
    above, below = parts[0][case], parts[1][case]
    return Loop(
        above,
        degree_of(above),
        below,
        below.size - 1,
        parts[2][case],
        room.above_squared[i],
        room.below_squared[i],
        room.real[i],
        room.imaginary[i],
    )


@lean
def block_crossings(parts: Parts, start: int, count: int, room: Room, found: Found) -> None:
    """Write the results of a block of loops."""
    for i in range(count):
        found.poles[start + i] = _begun(_loop(parts, start + i, room, i), room, i)
    positive_roots(room.sum, count, room.work, room.roots, room.counts)
    for i in range(count):
        loop = _loop(parts, start + i, room, i)
        found.poles[start + i] = _gain_crossings(loop, room, i, found, start + i)
    positive_roots(room.imaginary, count, room.work, room.squares, room.real_counts)
    _turns(parts, start, count, room)
    for i in range(count):
        _phase_crossings(_loop(parts, start + i, room, i), room, i, found, start + i)


@lean
def _begun(loop: Loop, room: Room, i: int) -> int:
    """Write the polynomials of a loop and return the unstable poles that it has without delay."""
    square(loop)
    total, n = room.sum[i], loop.n
    total[:] = 0.0
    for k in range(n + 1):
        total[k] = loop.above[k] + loop.below[k]
    poles = unstable_roots(total, n, room.table)
    real = degree_of(loop.imaginary) == 0 and loop.imaginary[0] == 0.0
    if real and (loop.delay > 0.0 or loop.above[loop.m] == 0.0):
        poles = UNSURE
    for k in range(n + 1):
        total[k] = loop.below_squared[k] - loop.above_squared[k]
        if not math.isfinite(total[k]):
            poles = UNSURE
    if poles == UNSURE:
        total[:], loop.imaginary[:] = 0.0, 0.0
    return poles


@lean
def _gain_crossings(loop: Loop, room: Room, i: int, found: Found, case: int) -> int:
    """Write where |L| = 1 and the phase left there; return the number of unstable poles."""
    poles, count = found.poles[case], room.counts[i]
    found.crossed[case] = count
    for j in range(count):
        omega = polished(loop.above, loop.m, loop.below, loop.n, math.sqrt(room.roots[i, j]))
        a, _ = on_axis(loop.above, loop.m, omega)
        b, _ = on_axis(loop.below, loop.n, omega)
        point = -a * b.conjugate()
        due = math.atan2(point.imag, point.real)
        found.gains[case, j] = omega
        left = due - omega * loop.delay
        found.phases[case, j] = left - _TURN * np.round(left / _TURN)
        if loop.delay > 0.0:
            # Beyond the last crossover |D| is the larger one.
            moved = moved_by_delay(due, omega * loop.delay, (count - j) % 2 == 1)
            if moved == UNSURE:
                return UNSURE
            poles += moved
    return poles


@lean
def _turns(parts: Parts, start: int, count: int, room: Room) -> None:
    """Write how far the turns of delays are followed, and where the phase of loops turns back."""
    latest = 0.0
    for i in range(count):
        latest = max(latest, parts[2][start + i])
    if latest == 0.0:
        return
    _ends(parts, start, count, room)
    for i in range(count):
        loop = _loop(parts, start + i, room, i)
        if loop.delay > 0.0:
            turning_back(loop, room.sum[i], room.table)
        else:
            room.sum[i, :] = 0.0
    positive_roots(room.sum, count, room.work, room.roots, room.counts)


@lean
def _ends(parts: Parts, start: int, count: int, room: Room) -> None:
    """Write how far [rad/s] the turns of delays are followed; infinite without a delay."""
    for i in range(count):
        growing_quiet(_loop(parts, start + i, room, i), room.sum[i])
    positive_roots(room.sum, count, room.work, room.roots, room.counts)
    for i in range(count):
        loop, roots = _loop(parts, start + i, room, i), room.counts[i]
        last = math.sqrt(room.roots[i, roots - 1]) if roots > 0 else 0.0
        room.ends[i] = end_of_turns(loop, last) if loop.delay > 0.0 else math.inf


@lean
def _phase_crossings(loop: Loop, room: Room, i: int, found: Found, case: int) -> None:
    """Write where L is real and negative, and the factor that makes it -1."""
    if found.poles[case] == UNSURE:
        return
    places, factors = found.places[case], found.factors[case]
    at_zero = 0
    if loop.above[0] * loop.below[0] < 0.0:
        at_zero, places[0] = 1, 0.0
    rest, squares, count = places[at_zero:], room.squares[i], room.real_counts[i]
    if loop.delay == 0.0:
        total = without_delay(loop, squares, count, rest)
    else:
        count = merge(squares, count, room.roots[i], room.counts[i], room.both)
        total = with_delay(loop, room.both, count, room.ends[i], rest)
    total += at_zero
    found.needed[case] = total
    for j in range(min(total, places.size)):
        a, _ = on_axis(loop.above, loop.m, places[j])
        b, _ = on_axis(loop.below, loop.n, places[j])
        squared = (b.real**2 + b.imag**2) / (a.real**2 + a.imag**2)
        factors[j] = math.sqrt(squared)


@lean
def block_peaks(
    parts: Parts,
    start: int,
    count: int,
    room: Room,
    roots: NDArray[np.complex128],
    tops: FloatArray,
) -> None:
    """Write the peaks of a block of loops."""
    for i in range(count):
        square(_loop(parts, start + i, room, i))
    _ends(parts, start, count, room)
    for i in range(count):
        loop = _loop(parts, start + i, room, i)
        end, top = room.ends[i], tops[start + i]
        peaks_of_one(loop.above, loop.below, loop.delay, end, room.table, roots, top)
