"""What configuration I of Table I needs beside the abstract of the companion report."""

from dataclasses import dataclass

import numpy as np

from tvclin.ascent.schedule_file import load_schedule
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.gains import canonical_gains
from tvclin.control.comparison import compare_with_trim
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle_file import load_vehicle
from tvclin.winds.pulses import TriangularWind

WIND, PEAK = 2.4, 5.2
"""What the abstract says that 99 percent winds need of the vehicle with an S-IVB [deg], and a wind
angle [deg] to compare with."""
TIMES = (45.0, 55.0, 66.0, 80.0)
"""Flight times [s] of the reconstructed flight; 66 s is that of Table I."""
EXAMPLE = 75.0
"""A wind across the flight [m/s], assumed."""


@dataclass(frozen=True)
class Moment:
    """Configuration I at one time of its flight.

    Attributes
    ----------
    time, velocity : float
        Flight time [s] and speed [m/s].
    B : float
        Trim deflection over the wind angle.
    trim : float
        Trim deflection in a wind of `PEAK` [deg].
    angle, along, across : float
        The wind angle [deg] that `WIND` trims, and the speed of a horizontal wind that makes it,
        along the flight and across it [m/s].
    """

    time: float
    velocity: float
    B: float
    trim: float
    angle: float
    along: float
    across: float


def moments() -> tuple[Moment, ...]:
    """Return configuration I at each of `TIMES`, by its reconstructed flight."""
    flight = load_schedule("configuration-i", start=min(TIMES), stop=max(TIMES))
    found = []
    for time in TIMES:
        vehicle = flight.at(time)
        B, speed = float(Coefficients.from_vehicle(vehicle).B), float(vehicle.velocity)
        angle = WIND / B
        across = speed * np.sin(np.radians(angle))  # eq (B1e)
        along = across / np.sin(float(vehicle.attitude))
        found.append(Moment(time, speed, B, B * PEAK, angle, float(along), float(across)))
    return tuple(found)


def example() -> tuple[float, float]:
    """Return the angle [deg] of the assumed wind at the time of Table I, and B by its own.

    That B with which the wind needs `WIND`, over the B of Table I.
    """
    table = next(one for one in moments() if one.time == 66.0)
    angle = float(np.degrees(np.arcsin(EXAMPLE / table.velocity)))
    return angle, WIND / angle / table.B


def autopilot() -> float:
    """Return what the usual autopilot asks for in the usual wind, without a stop, over trim."""
    plant = Plant.from_vehicle(load_vehicle("configuration-i"))
    wind = TriangularWind(peak=np.radians(5.0), duration=7.5)
    return compare_with_trim(plant, canonical_gains(plant, actuator=Actuator()), wind).ratio_to_trim
