"""Time of a gust on a wind at which the required deflection is largest.

A gust without a time may come at any time of the wind, and the worst counts. The requirement over
the time of the gust is scanned, and refined between the neighbours of its maximum: at the dynamic
pressure encountered, in the worst direction of the wind, or at nominal dynamic pressure, by request
and where that encountered is not known. A time at which wind and gust together exceed linear
aerodynamics is worse than all others: what is required there is not known.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import NotKnownError
from tvclin.boundary.limit import boundary_limit
from tvclin.boundary.open_loop import open_loop_requirements
from tvclin.kernels.choice import repeated
from tvclin.linear.plant import Plant
from tvclin.numerics.searches import grid_minimum
from tvclin.time_varying.equations import Equations
from tvclin.time_varying.requirements import varying_requirement
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.shaped import ShapedWind, encountered_wind
from tvclin.winds.wind_angles import MAX_LINEAR_ANGLE

_MIN_STEPS, _MAX_STEPS = 16, 64
"""Smallest and largest number of steps over the wind, two in each duration of the gust."""
_REFINEMENTS = 2
"""Refinements of the time of the gust, to 1e-3 of the duration of the wind."""
_PARTS = 0.25
"""Number of steps of the search over that of the requirement: its steps are four times as long."""

RequirementsByTime = Callable[[FloatArray], FloatArray]
"""Function that returns required deflections [rad] with the middle of a gust at times [s]."""


def nominal_requirements_by_time(
    plant: Plant, wind: ShapedWind, dead_band: float
) -> RequirementsByTime:
    """Return the required deflections [rad] at nominal pressure, a function of gust times [s].

    Each is the largest of `open_loop_requirements`. `wind`: in the plane, with a gust. `dead_band`:
    K, the vehicle is trimmed up to K times the limit.
    """
    K = np.asarray(dead_band)

    def required(times: FloatArray) -> FloatArray:
        """Return the required deflections [rad] with the middle of the gust at times [s].

        Infinite where the wind exceeds linear aerodynamics.
        """
        gusty = wind.history({"gust_at": times})
        # Literal: the switch compares the trim deflection itself with K times the limit.
        boundary = boundary_limit(plant, gusty, K, "literal")
        largest = np.max(list(open_loop_requirements(plant, gusty, K, boundary).values()), axis=0)
        return np.where(gusty.peak > MAX_LINEAR_ANGLE, np.inf, largest)

    return required


def encountered_requirements_by_time(
    vehicle: Vehicle,
    model: str,
    plane: str,
    wind: ShapedWind,
    directions: tuple[str, ...],
    dead_band: float,
) -> RequirementsByTime:
    """Return the required deflections [rad] as encountered, a function of gust times [s].

    Each is the largest of all directions of the wind, without flights of the limited law. `wind`:
    with its heading and its gust. `model`, `plane`: linear model, and the judged plane.
    `directions`: such as "head" and "tail". `dead_band`: K, the vehicle is trimmed up to K times
    the limit.
    """
    equations = Equations.frozen(vehicle.rigid, model, plane)

    def required(times: FloatArray) -> FloatArray:
        """Return the required deflections [rad] with the middle of the gust at times [s], ``(n,)``.

        They are the largest of the `directions`, computed in longer steps (`_PARTS`), without
        flights; infinite where the angle of a wind is beyond linear aerodynamics.
        """
        by_direction = []
        for direction in directions:
            gusty = encountered_wind(wind, vehicle, plane, direction, values={"gust_at": times})
            linear = gusty.largest_angle <= MAX_LINEAR_ANGLE  # NaN where no wind has the angle
            if not np.all(linear):
                by_direction.append(np.where(linear, 0.0, np.inf))
                continue
            requirement = varying_requirement(
                equations, gusty, dead_band, parts=_PARTS, flights=False
            )
            by_direction.append(requirement.required)
        return np.asarray(np.max(by_direction, axis=0))

    return required


def worst_gust_time(wind: ShapedWind, required: RequirementsByTime) -> float | None:
    """Return the time [s] of the middle of a gust with the largest requirement.

    None where nothing is required. Of several times at which the requirement is infinite, the
    first. `InputError` where the requirement of any time is not defined or not known. `wind`: with
    the gust; the search goes from its beginning to its end. `required`: required deflections [rad]
    by time of the gust.
    """
    gust = wind.gust
    assert gust is not None
    # Two steps in each duration of the gust.
    steps = 2.0 * wind.duration / float(gust.end - gust.onset)
    steps = int(np.clip(steps, _MIN_STEPS, _MAX_STEPS))
    times = np.linspace(0.0, wind.duration, steps + 1)
    # the scan and its refinements: similar runs, which decide between compiled and plain code
    with repeated(1 + _REFINEMENTS):
        scan = required(times)
        if np.any(np.isnan(scan)):
            time = times[int(np.isnan(scan).argmax())]
            raise NotKnownError(f"what a gust at {time:.4g} s requires is not known")
        best = int(scan.argmax())
        if scan[best] == 0.0:
            return None
        if np.isinf(scan[best]):
            return float(times[best])
        low, high = times[max(best - 1, 0)], times[min(best + 1, steps)]
        time, refined = grid_minimum(lambda time: -required(time), low, high, _REFINEMENTS)
        return float(time if -refined > scan[best] else times[best])
