"""The bound of every law that does not know when a turning wind will stop.

With the demand I(s, T) of the wind between s and T, z(T) must be in the recoverable set y S when
the wind stops at T, so z(s) - I(s, T) is in y S as well; z(0) = 0. Hence

    g_S(-I(0, T)) <= y,    I(s, T) in y (S - S)    for all s < T
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tvclin.base.arrays import ComplexArray, FloatArray
from tvclin.boundary.planes.pair import Pair
from tvclin.boundary.stops import Stop

_TIMES = 80
"""Times of the first grid, about, in each of its two variables."""
_DIRECTIONS = 180
"""Directions in half a turn at which S - S is computed; it is symmetric."""
_GRID_POINTS = 33
"""Points of a refined grid in each of its two variables."""
_REFINEMENT_FACTOR = 8.0
"""Width of a refined grid over that of the next."""
_GRID_REFINEMENTS = 5
"""Number of refined grids."""


def _difference_gauge(stop: Stop) -> Callable[[ComplexArray], FloatArray]:
    """Return the gauge of S - S, from its supports in some directions: a lower bound of it."""
    if stop.symmetric:
        return lambda vector: stop.gauge(vector) / 2.0
    directions = np.exp(1j * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS)
    normals = directions / (stop.support(directions) + stop.support(-directions))
    components = np.stack([normals.real, normals.imag])
    return lambda vector: np.abs(np.stack([vector.real, vector.imag], axis=-1) @ components).max(
        axis=-1
    )


def unforeseen(pair: Pair, stop: Stop) -> float:
    """Return the bound [rad] of the fast modes for laws that know the wind, but not when it stops.

    With planes that differ, it is computed for states that a constant vector returns from: up to
    two percent too large where the poles differ by half.
    """
    onset, end = float(pair.wind.onset), float(pair.wind.end)
    shown = pair.times()
    times = shown[:: max(1, shown.size // _TIMES)]
    times = np.union1d(np.append(times, [onset, end]), np.linspace(onset, end, _TIMES // 2))
    gauge = _difference_gauge(stop)

    def two_sided(s: FloatArray, T: FloatArray) -> FloatArray:
        return gauge(_between(pair, s, T))

    def from_onset(_: FloatArray, T: FloatArray) -> FloatArray:
        return stop.gauge(_between(pair, np.full((1, 1), onset), T))

    grid = two_sided(times[:, np.newaxis], times)
    s, T = (times[i] for i in np.unravel_index(np.argmax(grid), grid.shape))
    first = from_onset(times, times)
    latest = times[int(np.argmax(first))]
    step = float(np.diff(times).max())
    return max(
        float(grid.max()),
        float(first.max()),
        _refined_maximum(two_sided, (s, T), step, (onset, end)),
        _refined_maximum(from_onset, (latest, latest), step, (onset, end)),
    )


def _between(pair: Pair, s: FloatArray, T: FloatArray) -> ComplexArray:
    """Return the demand [rad] of the wind from s to T, zero where T is before s; they broadcast."""
    demand = pair.wind_demand(s) - pair.decayed(pair.wind_demand(T), np.maximum(T - s, 0.0))
    return np.where(T > s, demand, 0.0)


def _refined_maximum(
    height: Callable[[FloatArray, FloatArray], FloatArray],
    start: tuple[float, float],
    step: float,
    ends: tuple[float, float],
) -> float:
    """Return the largest value near a start, by grids about the best point, each narrower."""
    s, T = start
    best = 0.0
    offsets = np.linspace(-1.0, 1.0, _GRID_POINTS)
    for _ in range(_GRID_REFINEMENTS):
        first, last = (np.clip(centre + step * offsets, *ends) for centre in (s, T))
        values = height(first[:, np.newaxis], last)
        i, k = np.unravel_index(np.argmax(values), values.shape)
        if values[i, k] > best:
            best, s, T = float(values[i, k]), float(first[i]), float(last[k])
        step /= _REFINEMENT_FACTOR
    return best
