"""Above which value all that was tried survives: a scan, and its edge refined.

Survival need not be even: windows of loss lie above values that survive. The edge is that above
the highest value that does not; the steps above it are looked at again, in finer steps, and the
edge moves up until they are clean; then the finer steps likewise. Only a window of losses that is
narrower than the steps where it lies is missed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.errors import InputError, shown, whole_number
from tvclin.flights.closed_loop.checks import check_samples
from tvclin.flights.closed_loop.many import SURVIVED, UNDECIDED
from tvclin.winds.histories import History

Words = NDArray[np.str_]

OK = "ok"
NEVER = "no limit in the range survives"
ALWAYS = "every limit in the range survives"
OPEN = "undecided: the highest limit that does not survive is not lost either"
STEPS = 60
"""Of a scan."""
ABOVE, PARTS, LEVELS = 4, 16, 3
"""So many steps above an edge are looked at again, each in so many parts, and that so often."""
STRIDE, FINE, AHEAD, LAST_PARTS = 0.02, 0.002, 0.06, 10
"""Steps of many edges at once, over the value; how far above an edge the finer ones reach; and in
how many parts the last is looked at."""
_MOST_CUTS = 1000
_SAMPLES = 5_000_000
"""Of all winds that are flown together: some hundred megabytes."""


@dataclass(frozen=True, eq=False)
class Edge:
    """The edge, the values tried, their status, what was looked at, and what is to be said.

    `looked` holds steps, and up to which value they were tried, the finest last; `lost` is the
    highest value that does not survive, or minus infinity.
    """

    limit: float
    lost: float
    scan: FloatArray
    found: Words
    looked: tuple[tuple[float, float], ...]
    status: str


def edge_above_losses(survives: Callable[[FloatArray], Words], scan: FloatArray) -> Edge:
    """Return the edge above the highest value that does not survive.

    `survives`: the status of values, ``(n,)``. `scan`: values in even steps, rising.
    """
    bottom, top = float(scan[0]), float(scan[-1])
    step = float(scan[1] - scan[0])
    tried: list[FloatArray] = []
    status: list[Words] = []

    def lost(values: FloatArray) -> BoolArray:
        column, found = values[:, 0], np.zeros(values.shape, np.bool_)
        new = column < top if tried else column <= top  # the top has been tried at once
        tried.append(column[new])
        status.append(survives(column[new]))
        found[new, 0] = status[-1] != SURVIVED
        return found

    steps = step / float(PARTS) ** np.arange(1, LEVELS + 1)
    levels = [(one, ABOVE * PARTS, PARTS) for one in steps.tolist()]
    base, ends = _climbed(lost, scan[:, np.newaxis], levels)
    values, found = np.concatenate(tried), np.concatenate(status)
    looked = tuple((one, min(end, top)) for one, end in zip(steps.tolist(), ends, strict=True))
    low, order = float(base[0]), np.argsort(values)
    words = OPEN if np.any(found[values == low] == UNDECIDED) else OK
    edge = min(low + looked[-1][0], top)
    if low == -np.inf:
        edge, words = bottom, ALWAYS
    elif low == top:
        edge, words = np.inf, NEVER if words == OK else f"{NEVER}; {OPEN}"
    return Edge(edge, low, values[order], found[order], looked, words)


def edges_above_losses(
    lost: Callable[[FloatArray], BoolArray], low: FloatArray, high: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return the edges of many cases at once, and which of them are lost at `high` too.

    Values are tried every `STRIDE` from `low` to `high`; above the highest that is lost every
    `FINE`, until a range of `AHEAD` is clean; and the step that is left in `LAST_PARTS`. `lost`:
    which of the values ``(k, n)``, a column for each case, are lost. `low`, `high`: positive values
    between which the edges are sought, ``(n,)``.
    """
    span, fine = np.log(np.maximum(high / low, 1.0)), np.log1p(FINE)
    count = max(int(np.ceil(span.max(initial=0.0) / STRIDE)), 1)
    scan = span * np.linspace(0.0, 1.0, count + 1)[:, np.newaxis]

    def gone(parts: FloatArray) -> BoolArray:
        return lost(low * np.exp(np.minimum(parts, span))) & (parts <= span)

    levels = [(fine, int(AHEAD / FINE), 1), (fine / LAST_PARTS, LAST_PARTS - 1, 1)]
    base, _ = _climbed(gone, scan, levels)
    never, edge = base >= span, low * np.exp(np.minimum(base + fine / LAST_PARTS, span))
    return np.where(never, high, np.where(base > -np.inf, edge, low)), never


def _climbed(
    lost: Callable[[FloatArray], BoolArray],
    scan: FloatArray,
    levels: Sequence[tuple[float, int, int]],
) -> tuple[FloatArray, list[float]]:
    """The highest value that is lost of each column ``(k, n)``, minus infinity where none is.

    Of each level: the step, how many of them must be clean above it, and each how many-th has been
    tried a level above. Returned too: how far each level looked, in the first column.
    """
    base, ends = np.where(lost(scan), scan, -np.inf).max(axis=0), []
    for step, most, known in levels:
        start, first, last = np.maximum(base, scan[0]), 1, most
        while first <= last:
            parts = np.arange(first, last + 1)
            parts = parts[(parts % known != 0) | (known == 1)]
            values = start + step * parts[:, np.newaxis]
            gone = lost(values)
            base = np.maximum(base, np.where(gone, values, -np.inf).max(axis=0))
            above = parts[gone.any(axis=1)]
            first, last = last + 1, int(above.max(initial=last - most)) + most
        ends.append(float(start[0] + step * (first - 1)))
    return base, ends


def in_all(
    winds: Sequence[History],
    status: Callable[[History, BoolArray], Words],
    size: int,
    flown: Callable[[], None] = lambda: None,
) -> Words:
    """Return the status over all winds of many flights: the first not survived counts.

    `winds`: flown one after the other. `status`: of the flights chosen by a mask, in a wind.
    `size`: number of flights. `flown`: is called after each wind.
    """
    found = np.full(size, SURVIVED, dtype=object)
    for one in winds:
        alive = found == SURVIVED
        if np.any(alive):
            found[alive] = status(one, alive)
        flown()
    return found.astype(str)


def stopped_winds(wind: History, cuts: int, length: float) -> list[History]:
    """Return the wind, and the same with so many sudden stops, at even instants.

    `InputError` for cuts that are not a whole number up to 1000, or make too many samples of a
    length [s].
    """
    stops = whole_number("cuts", cuts)
    if stops > _MOST_CUTS:
        raise InputError(f"cuts must be at most {_MOST_CUTS}; got {shown(cuts)}")
    start, end = float(wind.onset), float(wind.end)
    if (stops + 1) * (end - start) / length > _SAMPLES:
        raise InputError(
            f"cuts and sample_rate may make at most {_SAMPLES:g} samples of all winds; got"
            f" {stops + 1} times {end - start:.6g} s at {1.0 / length:.6g} Hz"
        )
    check_samples(end - start, length)
    return [wind, *(wind.before(t) for t in np.linspace(start, end, stops + 2)[1:-1])]
