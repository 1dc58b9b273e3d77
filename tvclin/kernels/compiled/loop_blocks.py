"""Margins of a block of loops: the verdict, every crossing, and the peaks.

The polynomials of all loops are made first, so that their roots are searched for together.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.compiled.compiler import lean
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
    poles: NDArray[np.complex128]
    work: Searches


def new_room() -> Room:
    """Return room for a block."""
    rows, counts = np.zeros((7, BLOCK, SIZE)), np.zeros((2, BLOCK), dtype=np.intp)
    above, below, real, imaginary, total, roots, squares = rows
    both, table, poles = np.zeros(2 * SIZE), np.zeros((4, SIZE)), np.zeros(3 * SIZE, complex)
    return Room(
        above_squared=above,
        below_squared=below,
        real=real,
        imaginary=imaginary,
        sum=total,
        roots=roots,
        counts=counts[0],
        squares=squares,
        real_counts=counts[1],
        ends=np.zeros(BLOCK),
        both=both,
        table=table,
        poles=poles,
        work=searches(BLOCK),
    )


@lean
def loop_of(parts: Parts, case: int, room: Room, i: int) -> Loop:
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
def begun(loop: Loop, room: Room, i: int) -> int:
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
def gain_crossings(loop: Loop, room: Room, i: int, found: Found, case: int) -> int:
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
def turns(parts: Parts, start: int, count: int, room: Room) -> None:
    """Write how far the turns of delays are followed, and where the phase of loops turns back."""
    if not ends(parts, start, count, room):
        return
    for i in range(count):
        loop = loop_of(parts, start + i, room, i)
        if loop.delay > 0.0:
            turning_back(loop, room.sum[i], room.table)
        else:
            room.sum[i, :] = 0.0
    positive_roots(room.sum, count, room.work, room.roots, room.counts)


@lean
def ends(parts: Parts, start: int, count: int, room: Room) -> bool:
    """Write how far [rad/s] the turns of delays are followed; return whether there are any."""
    late = False
    for i in range(count):
        room.ends[i], room.sum[i, :] = math.inf, 0.0
        loop = loop_of(parts, start + i, room, i)
        if loop.delay > 0.0:
            late = True
            growing_quiet(loop, room.sum[i])
    if late:
        positive_roots(room.sum, count, room.work, room.roots, room.counts)
    for i in range(count):
        loop, roots = loop_of(parts, start + i, room, i), room.counts[i]
        if loop.delay > 0.0:
            last = math.sqrt(room.roots[i, roots - 1]) if roots > 0 else 0.0
            room.ends[i] = end_of_turns(loop, last)
    return late


@lean
def phase_crossings(loop: Loop, room: Room, i: int, found: Found, case: int) -> None:
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
