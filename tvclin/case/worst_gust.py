"""Worst time of a gust on top of a wind, with the largest required deflection."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.boundary.limit import boundary_limit
from tvclin.boundary.open_loop import open_loop_requirements
from tvclin.kernels.choice import repeated
from tvclin.linear.plant import Plant
from tvclin.numerics.searches import grid_minimum
from tvclin.winds.shaped import ShapedWind

_MIN_STEPS, _MAX_STEPS = 16, 64
"""Smallest and largest number of steps over the wind, two in each duration of the gust."""
_REFINEMENTS = 3
"""Refinements of the time of the gust, to 1e-4 of the duration of the wind."""


def placed_worst(wind: ShapedWind, plant: Plant, dead_band: float = 1.0) -> ShapedWind:
    """Return a wind without a heading with its gust at the time with the largest requirement.

    A wind without a gust, or with a gust that has a time, is returned unchanged. The time maximises
    `open_loop_requirements` from the beginning of the wind to its end, by a scan that is refined
    between the neighbours of its maximum. A gust that opposes the wind, or one for which no limit
    is defined, stays in the middle.
    """
    gust = wind.gust
    if gust is None or wind.gust_at is not None:
        return wind
    length = wind.duration
    if plant.batch or float(gust.peak) * wind.peak < 0.0:
        return wind
    wind_without_gust, K = replace(wind, gust=None).history({}), np.asarray(dead_band)
    middle = 0.5 * (float(gust.onset) + float(gust.end))

    def required(time: FloatArray) -> FloatArray:
        """Return the required deflections [rad] with the gust at times [s], in their shape."""
        gusty = wind_without_gust + gust.shift(time - middle)
        boundary = boundary_limit(plant, gusty, K, "literal")
        return np.max(list(open_loop_requirements(plant, gusty, K, boundary).values()), axis=0)

    steps = int(np.clip(2.0 * length / float(gust.end - gust.onset), _MIN_STEPS, _MAX_STEPS))
    times = np.linspace(0.0, length, steps + 1)
    with suppress(InputError), repeated(1 + _REFINEMENTS):
        scan = required(times)
        if not np.all(np.isfinite(scan)) or scan.max() == 0.0:
            return wind
        best = int(scan.argmax())
        low, high = times[max(best - 1, 0)], times[min(best + 1, steps)]
        time, refined = grid_minimum(lambda time: -required(time), low, high, _REFINEMENTS)
        return replace(wind, gust_at=float(time if -refined > scan[best] else times[best]))
    return wind
