"""How the nozzle moves in a flight: deflection, rate and acceleration, many times in a sample."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.batch import Hardware, one_flight
from tvclin.flights.closed_loop.many import LOST, fly_many
from tvclin.flights.closed_loop.track import outputs_of, tracked
from tvclin.linear.flexible import AnyPlant
from tvclin.winds.histories import History

_AFTER = 15.0
"""A flight is shown so many times of its fast mode after the wind: what moves then is rounding."""
_IN_A_SAMPLE, _MOST = 4, 50_000
"""Times shown in a sample; and samples, of longer flights those of the wind alone."""


@dataclass(frozen=True, eq=False)
class NozzleFlight:
    """What became of a flight, and how its nozzle moved; angles in rad.

    `times`: even times [s] from the first command on, at which commands change too, ``(n,)``; of a
    flight that is lost none. `rate`, `acceleration`: of the actuator right after these; None
    without an actuator, whose times are the samples.
    """

    status: str
    times: FloatArray
    deflection: FloatArray
    angle_of_attack: FloatArray
    attitude: FloatArray
    rate: FloatArray | None
    acceleration: FloatArray | None


def fly_nozzle(
    plant: AnyPlant,
    law: Law,
    wind: History,
    *,
    deflection_limit: float,
    rate_limit: float,
    actuator: Actuator | None,
    sample_rate: float,
    delay: float,
) -> NozzleFlight:
    """Return how a nozzle moves in the flight of a law; arguments as of `fly_many`."""
    told: dict[str, Any] = {"deflection_limit": deflection_limit, "rate_limit": rate_limit}
    told |= {"actuator": actuator, "sample_rate": sample_rate, "delay": delay}
    status = str(fly_many(plant, law, wind, **told).status)
    none = np.empty(0)
    if status == LOST:
        return NozzleFlight(status, none, none, none, none, None, None)
    onset, end, h = float(wind.onset), float(wind.end), 1.0 / sample_rate
    late = onset + delay % h
    count = int(np.ceil((end - late + _AFTER / float(plant.coefficients.pole)) / h))
    if count > _MOST:
        count = int(np.ceil((end - late) / h))
    points = 1 if actuator is None else _IN_A_SAMPLE
    times = np.asarray(late + h / points * np.arange(count * points + 1), dtype=np.float64)
    hardware = Hardware(h, delay, actuator, rate_limit)
    flight = one_flight(plant, law, wind, deflection_limit, hardware, until=times[-1] + h)
    rows, rate, acceleration = tracked(flight, times)
    seen = outputs_of(plant, rows, wind(times))
    alpha, attitude = (seen[plant.outputs.index(name)] for name in ("angle_of_attack", "attitude"))
    return NozzleFlight(status, times, rows[-1], alpha, attitude, rate, acceleration)
