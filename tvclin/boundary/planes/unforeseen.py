"""The bound of every law that does not know when a turning wind will stop.

With I(s, T) what the wind between s and T asks for, a wind that stops at T must leave z(T) in the
set y S of what can be returned from, so z(s) - I(s, T) is in y S as well; z(0) = 0. Hence

    g_S(-I(0, T)) <= y,    I(s, T) in y (S - S)    for all s < T
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tvclin.base.arrays import ComplexArray, FloatArray
from tvclin.boundary.planes.pair import Pair
from tvclin.boundary.stops import Stop

_TIMES = 80
_DIRECTIONS = 180
"""Directions of half a turn, in which S - S is counted; it is the same to the other side."""
_CLOSER, _NARROWER, _ROUNDS = 33, 8.0, 5
"""Points of a grid each way, by how much the next is narrower, and how many there are."""


def _apart(stop: Stop) -> Callable[[ComplexArray], FloatArray]:
    """The gauge of S - S, of its supports in some directions: never more than the truth."""
    if stop.symmetric:
        return lambda vector: stop.gauge(vector) / 2.0
    around = np.exp(1j * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS)
    normals = around / (stop.support(around) + stop.support(-around))
    parts = np.stack([normals.real, normals.imag])
    return lambda vector: np.abs(np.stack([vector.real, vector.imag], axis=-1) @ parts).max(axis=-1)


def unforeseen(pair: Pair, stop: Stop) -> float:
    """Return the bound [rad] of the fast modes; a law told the whole wind, but not its stop.

    `pair`: with planes that differ, it is counted for what a constant vector returns from, up to
    two percent too much where the poles differ by half.
    """
    onset, end = float(pair.wind.onset), float(pair.wind.end)
    shown = pair.times()
    every = shown[:: max(1, shown.size // _TIMES)]
    every = np.union1d(np.append(every, [onset, end]), np.linspace(onset, end, _TIMES // 2))
    apart = _apart(stop)

    def two_sided(s: FloatArray, T: FloatArray) -> FloatArray:
        return apart(_between(pair, s, T))

    def from_onset(_: FloatArray, T: FloatArray) -> FloatArray:
        return stop.gauge(_between(pair, np.full((1, 1), onset), T))

    grid = two_sided(every[:, np.newaxis], every)
    s, T = (every[i] for i in np.unravel_index(np.argmax(grid), grid.shape))
    first = from_onset(every, every)
    latest = every[int(np.argmax(first))]
    step = float(np.diff(every).max())
    return max(
        float(grid.max()),
        float(first.max()),
        _closer(two_sided, (s, T), step, (onset, end)),
        _closer(from_onset, (latest, latest), step, (onset, end)),
    )


def _between(pair: Pair, s: FloatArray, T: FloatArray) -> ComplexArray:
    """What the wind from s to T asks for [rad], zero where T is before s; the two broadcast."""
    asked = pair.demanded(s) - pair.decayed(pair.demanded(T), np.maximum(T - s, 0.0))
    return np.where(T > s, asked, 0.0)


def _closer(
    height: Callable[[FloatArray, FloatArray], FloatArray],
    start: tuple[float, float],
    step: float,
    ends: tuple[float, float],
) -> float:
    """The largest value near a place: by grids about the best one, each `_NARROWER` than before."""
    s, T = start
    best = 0.0
    offsets = np.linspace(-1.0, 1.0, _CLOSER)
    for _ in range(_ROUNDS):
        first, last = (np.clip(one + step * offsets, *ends) for one in (s, T))
        values = height(first[:, np.newaxis], last)
        i, k = np.unravel_index(np.argmax(values), values.shape)
        if values[i, k] > best:
            best, s, T = float(values[i, k]), float(first[i]), float(last[k])
        step /= _NARROWER
    return best
