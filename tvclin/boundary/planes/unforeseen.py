"""The bound of every law that does not know when a turning wind will stop.

With I(s, T) what the wind between s and T asks for, a wind that stops at T must leave z(T) in the
set y S of what can be returned from, so z(s) - I(s, T) is in y S as well; z(0) = 0. Hence

    g_S(-I(0, T)) <= y,    I(s, T) in y (S - S)    for all s < T
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tvclin.boundary.planes.pair import Pair
from tvclin.boundary.stops import Stop, along

FloatArray = NDArray[np.float64]

_TIMES = 80
_DIRECTIONS = 360
_CLOSER, _ROUNDS = 9, 14


def _apart(stop: Stop, vector: NDArray[np.complex128]) -> FloatArray:
    """The gauge of S - S, of its supports in some directions: never more than the truth."""
    if stop.symmetric:
        return stop.gauge(vector) / 2.0
    around = np.exp(2j * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS)
    both = stop.support(around) + stop.support(-around)
    return np.asarray((along(around, vector[..., np.newaxis]) / both).max(axis=-1))


def unforeseen(pair: Pair, stop: Stop) -> float:
    """Return the bound [rad] of the fast modes; a law told the whole wind, but not its stop.

    Parameters
    ----------
    pair : Pair
        With planes that differ, it is counted for what a constant vector returns from, up to two
        percent too much where the poles differ by half.
    stop : Stop
        Its shape.
    """
    onset, end = float(pair.wind.onset), float(pair.wind.end)
    shown = pair.times()
    every = shown[:: max(1, shown.size // _TIMES)]
    every = np.union1d(np.append(every, [onset, end]), np.linspace(onset, end, _TIMES // 2))

    def two_sided(s: FloatArray, T: FloatArray) -> FloatArray:
        return _apart(stop, _between(pair, s, T))

    grid = two_sided(every[:, np.newaxis], every)
    grid[np.tril_indices(every.size)] = 0.0
    s, T = (every[i] for i in np.unravel_index(np.argmax(grid), grid.shape))
    step = float(np.diff(every).max())
    most = max(float(grid.max()), _closer(two_sided, (s, T), step, (onset, end)))
    first = stop.gauge(_between(pair, np.full(1, onset), every))
    T = every[int(np.argmax(first))]
    alone = _closer(
        lambda _, T: stop.gauge(_between(pair, np.full(1, onset), T)), (T, T), step, (onset, end)
    )
    return max(most, float(first.max()), alone)


def _between(pair: Pair, s: FloatArray, T: FloatArray) -> NDArray[np.complex128]:
    """What the wind from s to T asks for [rad]; the two broadcast."""
    return pair.demanded(s) - pair.decayed(pair.demanded(T), np.maximum(T - s, 0.0))


def _closer(
    height: Callable[[FloatArray, FloatArray], FloatArray],
    start: tuple[float, float],
    step: float,
    ends: tuple[float, float],
) -> float:
    """The largest value near a place: by grids about the best one, each half as wide."""
    s, T = start
    best = 0.0
    offsets = np.linspace(-1.0, 1.0, _CLOSER)
    for _ in range(_ROUNDS):
        first = np.clip(s + step * offsets, *ends)[:, np.newaxis]
        last = np.maximum(np.clip(T + step * offsets, *ends), first)
        values = height(first, last)
        i, k = np.unravel_index(np.argmax(values), values.shape)
        if values[i, k] > best:
            best, s, T = float(values[i, k]), float(first[i, 0]), float(last[i, k])
        step /= 2.0
    return best
