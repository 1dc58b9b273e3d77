"""What configuration I of Table I needs beside the abstract of the companion report."""

from dataclasses import dataclass

import numpy as np

from tvclin.ascent.schedule_file import load_schedule
from tvclin.vehicle.coefficients import Coefficients

WIND, PEAK = 2.4, 5.2
"""What the abstract says that 99 percent winds need of the vehicle with an S-IVB [deg], and a wind
angle [deg] to compare with."""
TIMES = (45.0, 66.0)
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
    across : float
        Speed [m/s] of a horizontal wind across the flight that `WIND` trims.
    """

    time: float
    velocity: float
    B: float
    trim: float
    across: float


def moments() -> tuple[Moment, ...]:
    """Return configuration I at each of `TIMES`, by its reconstructed flight."""
    flight = load_schedule("configuration-i", start=min(TIMES), stop=max(TIMES))
    computed = []
    for time in TIMES:
        vehicle = flight.at(time)
        B, speed = float(Coefficients.from_vehicle(vehicle).B), float(vehicle.velocity)
        across = speed * np.sin(np.radians(WIND / B))  # eq (B1e)
        computed.append(Moment(time, speed, B, B * PEAK, float(across)))
    return tuple(computed)


def example() -> float:
    """Return B at which the assumed wind needs `WIND`, over the B of Table I."""
    table = next(moment for moment in moments() if moment.time == 66.0)
    return WIND / float(np.degrees(np.arcsin(EXAMPLE / table.velocity))) / table.B
