"""When a gust on top of a wind asks for most: the least favourable of all times."""

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

_COARSE, _FINE = 16, 64
"""Steps over the wind, at least and at most: two in each duration of the gust."""
_CLOSE = 1e-4
"""The time is known to this part of the duration of the wind."""
_LOOKS = 15
"""About how often that takes to look."""


def placed_worst(wind: ShapedWind, plant: Plant, dead_band: float = 1.0) -> ShapedWind:
    """Return a wind without a heading with its gust at the time at which a plant needs most.

    It is returned as it is where it has no gust, or one with a time. The time is that of the
    largest of `open_loop_requirements` from the beginning of the wind to its end: of a scan,
    refined between the neighbours of the best. Where the gust blows against the wind, and where no
    limit is defined, it stays in the middle.
    """
    gust = wind.gust
    if gust is None or wind.gust_at is not None:
        return wind
    length = wind.duration
    if plant.batch or float(gust.peak) * wind.peak < 0.0:
        return wind
    alone, K = replace(wind, gust=None).history({}), np.asarray(dead_band)
    own = 0.5 * (float(gust.onset) + float(gust.end))

    def needed(at: FloatArray) -> FloatArray:
        blows = alone + gust.shift(at - own)
        boundary = boundary_limit(plant, blows, K, "literal")
        return np.max(list(open_loop_requirements(plant, blows, K, boundary).values()), axis=0)

    steps = int(np.clip(2.0 * length / float(gust.end - gust.onset), _COARSE, _FINE))
    times = np.linspace(0.0, length, steps + 1)
    with suppress(InputError):
        found = needed(times)
        if not np.all(np.isfinite(found)) or found.max() == 0.0:
            return wind
        best = int(found.argmax())
        near = times[[max(best - 1, 0), min(best + 1, steps)]]
        from scipy.optimize import minimize_scalar

        with repeated(_LOOKS):
            finer = minimize_scalar(
                lambda at: -float(needed(np.asarray(at))),
                bounds=tuple(near),
                method="bounded",
                options={"xatol": _CLOSE * length},
            )
        better = -finer.fun > found[best]
        return replace(wind, gust_at=float(finer.x if better else times[best]))
    return wind
