"""Compiled twin of `kernels.loop_margins`: block by block, the cases in slices over threads."""

from threading import local
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.compiled.compiler import compiled_lean
from tvclin.kernels.compiled.loop_blocks import (
    BLOCK,
    Found,
    Parts,
    Room,
    begun,
    ends,
    gain_crossings,
    loop_of,
    new_room,
    phase_crossings,
    turns,
)
from tvclin.kernels.compiled.loop_crossings import square
from tvclin.kernels.compiled.loop_peaks import peaks_of_one
from tvclin.kernels.compiled.positive_roots import positive_roots
from tvclin.kernels.compiled.stability import UNSURE
from tvclin.kernels.rational import Rational
from tvclin.kernels.threads import in_slices

FloatArray = NDArray[np.float64]

_CROSSINGS, _PEAKS = 1e-6, 7e-6
"""About what one loop takes [s]."""
_WIDTH = 16
"""Phase crossings for which there is room at first."""
_rooms = local()
"""Each thread makes its room once."""


def loop_crossings(loop: Rational) -> tuple[list[NDArray[Any]], NDArray[np.bool_]]:
    """Return the arrays of `LoopCrossings`, and the loops on which numpy has to decide."""
    parts = _ascending(loop)
    found = _found(parts, _WIDTH)
    places, factors = found.places, found.factors
    many = np.flatnonzero(found.needed > _WIDTH)
    if many.size:
        above, below, delay = (part[many] for part in parts)
        more = _found((above, below, delay), int(found.needed.max()))
        beyond = [(0, 0), (0, more.places.shape[-1] - _WIDTH)]
        places, factors = (np.pad(a, beyond, constant_values=np.nan) for a in (places, factors))
        places[many], factors[many] = more.places, more.factors
    width = int(found.needed.max(initial=0))
    places, factors = places[:, :width], factors[:, :width]
    width = int(found.crossed.max(initial=0))
    gains, phases = found.gains[:, :width], found.phases[:, :width]
    marginal = np.zeros(len(places), dtype=bool)
    arrays = [found.poles, marginal, gains, phases, places, factors]
    return arrays, found.poles == UNSURE


def _found(parts: Parts, width: int) -> Found:
    """Return everything, with room for `width` phase crossings of each loop."""
    cases, order = len(parts[2]), parts[1].shape[-1] - 1
    poles, crossed, needed = np.zeros((3, cases), dtype=np.intp)
    gains, phases = np.full((2, cases, order), np.nan)
    places, factors = np.full((2, cases, width), np.nan)
    found = Found(poles, gains, phases, places, factors, crossed, needed)
    in_slices(
        lambda first, last: _crossings(first, last, parts, _room(), found),
        cases,
        _CROSSINGS * cases,
    )
    return found


def loop_peaks(loop: Rational) -> FloatArray:
    """Return the peaks of S, T and (S - T)/2 and their frequencies, ``(3, 2, k)``."""
    parts = _ascending(loop)
    tops = np.empty((len(loop.delay), 3, 2))
    in_slices(
        lambda first, last: _peaks(first, last, parts, _room(), tops),
        len(loop.delay),
        _PEAKS * len(loop.delay),
    )
    return np.moveaxis(tops, 0, -1)


def _room() -> Room:
    """Return where this thread works."""
    if not hasattr(_rooms, "room"):
        _rooms.room = new_room()
    room: Room = _rooms.room
    return room


def _ascending(loop: Rational) -> Parts:
    """The parts of a loop in the one kind of memory for which its kernels are compiled."""
    parts = (loop.numerator[:, ::-1], loop.denominator[:, ::-1], loop.delay)
    above, below, delay = (np.require(part, float, ["C", "W"]) for part in parts)
    return above, below, delay


@compiled_lean
def _crossings(first: int, last: int, parts: Parts, room: Room, found: Found) -> None:
    for start in range(first, last, BLOCK):
        count = min(BLOCK, last - start)
        for i in range(count):
            found.poles[start + i] = begun(loop_of(parts, start + i, room, i), room, i)
        positive_roots(room.sum, count, room.work, room.roots, room.counts)
        for i in range(count):
            loop = loop_of(parts, start + i, room, i)
            found.poles[start + i] = gain_crossings(loop, room, i, found, start + i)
        positive_roots(room.imaginary, count, room.work, room.squares, room.real_counts)
        turns(parts, start, count, room)
        for i in range(count):
            phase_crossings(loop_of(parts, start + i, room, i), room, i, found, start + i)


@compiled_lean
def _peaks(first: int, last: int, parts: Parts, room: Room, tops: FloatArray) -> None:
    for start in range(first, last, BLOCK):
        count = min(BLOCK, last - start)
        for i in range(count):
            if parts[2][start + i] > 0.0:
                square(loop_of(parts, start + i, room, i))
        ends(parts, start, count, room)
        for i in range(count):
            loop, end = loop_of(parts, start + i, room, i), room.ends[i]
            above, below, delay, top = loop.above, loop.below, loop.delay, tops[start + i]
            peaks_of_one(above, below, delay, end, room.table, room.poles, top)
