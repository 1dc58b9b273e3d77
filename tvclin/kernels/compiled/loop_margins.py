"""Margins of loops, one after the other: the verdict, every crossing, and the peaks."""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.compiled.compiler import compiled, lean
from tvclin.kernels.compiled.loop_crossings import (
    Room,
    end_of_turns,
    merged,
    turning_back,
    with_delay,
    without_delay,
)
from tvclin.kernels.compiled.loop_peaks import peaks_of_one
from tvclin.kernels.compiled.polynomials import add_on_axis, degree_of, positive_roots, value
from tvclin.kernels.compiled.stability import UNSURE, moved_by_delay, polished, unstable_roots
from tvclin.kernels.rational import Rational
from tvclin.kernels.threads import in_slices

FloatArray = NDArray[np.float64]

_CROSSINGS, _PEAKS = 3e-6, 1e-5
"""About what one loop takes [s]."""
_WIDTH = 16
"""Phase crossings for which there is room at first."""
_TURN = 2.0 * math.pi
_SIZE = 32
"""Room for the coefficients of the longest polynomial: of order 23, for a loop of order 12."""


class Found(NamedTuple):
    """Results of the cases ``(k,)``; the rows are filled with NaN."""

    poles: NDArray[np.intp]
    gains: FloatArray
    phases: FloatArray
    places: FloatArray
    factors: FloatArray
    needed: NDArray[np.intp]


def loop_crossings(loop: Rational) -> tuple[list[NDArray[Any]], NDArray[np.bool_]]:
    """Return the arrays of `LoopCrossings`, and the loops on which numpy has to decide."""
    parts = _ascending(loop)
    found = _found(parts, _WIDTH)
    places, factors = found.places, found.factors
    many = np.flatnonzero(found.needed > _WIDTH)
    if many.size:
        more = _found(tuple(part[many] for part in parts), int(found.needed.max()))
        beyond = [(0, 0), (0, more.places.shape[-1] - _WIDTH)]
        places, factors = (np.pad(a, beyond, constant_values=np.nan) for a in (places, factors))
        places[many], factors[many] = more.places, more.factors
    width = int(found.needed.max(initial=0))
    places, factors = places[:, :width], factors[:, :width]
    marginal = np.zeros(len(places), dtype=bool)
    arrays = [found.poles, marginal, found.gains, found.phases, places, factors]
    return arrays, found.poles == UNSURE


def _found(parts: tuple[FloatArray, ...], width: int) -> Found:
    """Return everything, with room for `width` phase crossings of each loop."""
    above, below, delay = parts
    cases, order = len(delay), below.shape[-1] - 1
    poles, needed = np.zeros((2, cases), dtype=np.intp)
    gains, phases = np.full((2, cases, order), np.nan)
    places, factors = np.full((2, cases, width), np.nan)
    found = Found(poles, gains, phases, places, factors, needed)
    in_slices(
        lambda first, last: _crossings(first, last, above, below, delay, found),
        cases,
        _CROSSINGS * cases,
    )
    return found


def loop_peaks(loop: Rational) -> FloatArray:
    """Return the peaks of S, T and (S - T)/2 and their frequencies, ``(3, 2, k)``."""
    above, below, delay = _ascending(loop)
    tops = np.empty((len(delay), 3, 2))
    in_slices(
        lambda first, last: _peaks(first, last, above, below, delay, tops),
        len(delay),
        _PEAKS * len(delay),
    )
    return np.moveaxis(tops, 0, -1)


def _ascending(loop: Rational) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The parts of a loop in the one kind of memory for which its kernels are compiled."""
    parts = (loop.numerator[:, ::-1], loop.denominator[:, ::-1], loop.delay)
    above, below, delay = (np.require(part, float, ["C", "W"]) for part in parts)
    return above, below, delay


@compiled
def _room() -> Room:
    rows = np.zeros((10, _SIZE))
    return Room(
        rows[0],
        rows[1],
        rows[2],
        rows[3],
        rows[4],
        rows[5],
        rows[6],
        rows[7],
        rows[8],
        rows[9],
        np.zeros((4, _SIZE)),
    )


@lean
def _square(above: FloatArray, m: int, below: FloatArray, n: int, room: Room) -> None:
    """Write |N|^2, |D|^2 and N conj(D) on the axis."""
    room.above_squared[:], room.below_squared[:] = 0.0, 0.0
    room.real[:], room.imaginary[:] = 0.0, 0.0
    add_on_axis(above, m, above, m, room.above_squared, room.work)
    add_on_axis(below, n, below, n, room.below_squared, room.work)
    add_on_axis(above, m, below, n, room.real, room.imaginary)


@compiled
def _crossings(
    first: int, last: int, above: FloatArray, below: FloatArray, delay: FloatArray, found: Found
) -> None:
    room, n = _room(), below.shape[1] - 1
    for case in range(first, last):
        a, b, late = above[case], below[case], delay[case]
        m = degree_of(a)
        _square(a, m, b, n, room)
        poles = _gain_crossings(a, m, b, n, late, room, found, case)
        found.poles[case] = poles
        if poles != UNSURE:
            _phase_crossings(a, m, b, n, late, room, found, case)


@lean
def _gain_crossings(
    above: FloatArray,
    m: int,
    below: FloatArray,
    n: int,
    delay: float,
    room: Room,
    found: Found,
    case: int,
) -> int:
    """Write where |L| = 1 and the phase left there; return the number of unstable poles."""
    closed = room.sum
    for k in range(n + 1):
        closed[k] = above[k] + below[k]
    poles = unstable_roots(closed, n, room.table)
    real = degree_of(room.imaginary) == 0 and room.imaginary[0] == 0.0
    if poles == UNSURE or (real and (delay > 0.0 or above[m] == 0.0)):
        return UNSURE
    for k in range(_SIZE):
        room.sum[k] = room.below_squared[k] - room.above_squared[k]
        if not math.isfinite(room.sum[k]):
            return UNSURE
    count = positive_roots(room.sum, room.work, room.edges, room.roots)
    for i in range(count):
        omega = polished(above, m, below, n, math.sqrt(room.roots[i]))
        point = -value(above, m, 1j * omega) * value(below, n, 1j * omega).conjugate()
        due = math.atan2(point.imag, point.real)
        found.gains[case, i] = omega
        left = due - omega * delay
        found.phases[case, i] = left - _TURN * np.round(left / _TURN)
        if delay > 0.0:
            # Beyond the last crossover |D| is the larger one.
            moved = moved_by_delay(due, omega * delay, (count - i) % 2 == 1)
            if moved == UNSURE:
                return UNSURE
            poles += moved
    return poles


@lean
def _phase_crossings(
    above: FloatArray,
    m: int,
    below: FloatArray,
    n: int,
    delay: float,
    room: Room,
    found: Found,
    case: int,
) -> None:
    """Write where L is real and negative, and the factor that makes it -1."""
    places, factors = found.places[case], found.factors[case]
    at_zero = 0
    if above[0] * below[0] < 0.0:
        at_zero, places[0] = 1, 0.0
    rest = places[at_zero:]
    count = positive_roots(room.imaginary, room.work, room.edges, room.squares)
    if delay == 0.0:
        total = without_delay(above, m, below, n, room, count, rest)
    else:
        end = end_of_turns(below, n, delay, room)
        turning_back(above, m, below, n, delay, room)
        more = positive_roots(room.sum, room.work, room.edges, room.roots)
        count = merged(room.squares, count, room.roots, more, room.both)
        total = with_delay(above, m, below, n, delay, room, count, end, rest)
    total += at_zero
    found.needed[case] = total
    for i in range(min(total, places.size)):
        s = 1j * places[i]
        factors[i] = abs(value(below, n, s)) / abs(value(above, m, s))


@compiled
def _peaks(
    first: int,
    last: int,
    above: FloatArray,
    below: FloatArray,
    delay: FloatArray,
    tops: FloatArray,
) -> None:
    room, n = _room(), below.shape[1] - 1
    roots = np.zeros(3 * _SIZE, dtype=np.complex128)
    for case in range(first, last):
        a, b, late = above[case], below[case], delay[case]
        end = math.inf
        if late > 0.0:
            _square(a, degree_of(a), b, n, room)
            end = end_of_turns(b, n, late, room)
        peaks_of_one(a, b, late, end, room.table, roots, tops[case])
