"""Worst time of a gust on top of a wind: that with the largest required deflection."""

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
from tvclin.winds.shaped import ShapedWind

_MIN_STEPS, _MAX_STEPS = 16, 64
"""Smallest and largest number of steps over the wind, two in each duration of the gust."""
_TIME_TOLERANCE = 1e-4
"""Tolerance of the time of the gust, relative to the duration of the wind."""
_EVALUATIONS = 15
"""Typical number of evaluations of the refinement."""


def placed_worst(wind: ShapedWind, plant: Plant, dead_band: float = 1.0) -> ShapedWind:
    """Return a wind without a heading with its gust at the time with the largest requirement.

    A wind without a gust, or with a gust that has a time, is returned unchanged. The time is that
    of the largest of `open_loop_requirements` from the beginning of the wind to its end: of a scan,
    refined between the neighbours of the best. Where the gust opposes the wind, and where no limit
    is defined, it stays in the middle.
    """
    gust = wind.gust
    if gust is None or wind.gust_at is not None:
        return wind
    length = wind.duration
    if plant.batch or float(gust.peak) * wind.peak < 0.0:
        return wind
    alone, K = replace(wind, gust=None).history({}), np.asarray(dead_band)
    middle = 0.5 * (float(gust.onset) + float(gust.end))

    def required(time: FloatArray) -> FloatArray:
        """Return the required deflections [rad] with the gust at times [s], in their shape."""
        gusty = alone + gust.shift(time - middle)
        boundary = boundary_limit(plant, gusty, K, "literal")
        return np.max(list(open_loop_requirements(plant, gusty, K, boundary).values()), axis=0)

    steps = int(np.clip(2.0 * length / float(gust.end - gust.onset), _MIN_STEPS, _MAX_STEPS))
    times = np.linspace(0.0, length, steps + 1)
    with suppress(InputError):
        scan = required(times)
        if not np.all(np.isfinite(scan)) or scan.max() == 0.0:
            return wind
        best = int(scan.argmax())
        bracket = times[[max(best - 1, 0), min(best + 1, steps)]]
        from scipy.optimize import minimize_scalar

        with repeated(_EVALUATIONS):
            finer = minimize_scalar(
                lambda time: -float(required(np.asarray(time))),
                bounds=tuple(bracket),
                method="bounded",
                options={"xatol": _TIME_TOLERANCE * length},
            )
        better = -finer.fun > scan[best]
        return replace(wind, gust_at=float(finer.x if better else times[best]))
    return wind
