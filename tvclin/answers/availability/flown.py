"""What one wind asks for where the trim law is flown: (4b) times what `size` finds beyond it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tvclin.answers.sizing.frozen import frozen_need
from tvclin.answers.sizing.measured import cut_samples
from tvclin.answers.sizing.schedule import FlightSchedule
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import Coefficients
from tvclin.winds.sampled import SampledWind

FloatArray = NDArray[np.float64]


def flown_need(
    flight: FlightSchedule,
    model: str,
    plane: str,
    times: FloatArray,
    wind: FloatArray,
    need: float,
) -> float:
    """Return the limit [rad] that a wind asks for, as `size` has it with ``varying=True``.

    What the trim law needs flown beyond (4b) is found with the vehicle frozen at the peak of the
    wind, and taken in proportion. The flight meets both sides; it counts for the stronger one.

    Parameters
    ----------
    flight, model, plane
        As of `availability`.
    times, wind : ndarray
        Knots [s], not decreasing, and wind angles [rad], positive to the side that counts.
    need : float
        What (4b) asks for [rad], with parameters that vary.
    """
    if not need > 0.0 or -wind.min() > wind.max():
        return need
    knots, first = np.unique(times, return_index=True)
    lines = SampledWind(time=knots, angle=wind[first])
    at, angle = cut_samples(lines, -np.inf, np.inf)
    one = SampledWind(time=at, angle=np.maximum(angle, 0.0))
    whole = SampledWind(time=at, angle=angle) if angle.min() < 0.0 else None
    vehicle = flight.at(float(at[np.argmax(angle)]))
    plant = Plant.from_vehicle(vehicle, model, plane)
    found = frozen_need(plant, one, np.ones(1), "bound", whole)
    if found.paired:  # the dead band must never be left
        B = np.asarray(Coefficients.from_vehicle(flight.held(at), plane).B)
        return float(np.max(np.abs(B * np.maximum(angle, 0.0))))
    return need * float(found.beyond[0])
