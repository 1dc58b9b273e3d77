"""Whether a flight of the report's control survives: the side to which it falls in the end."""

from collections.abc import Callable

import numpy as np

from tvclin.errors import InputError
from tvclin.flight.sixdof.case import SixDof
from tvclin.flight.sixdof.earth import Earth
from tvclin.flight.sixdof.steering import TrimThenHold
from tvclin.histories import History
from tvclin.vehicle import Vehicle

_PATIENCE = 12.0
"""A flight is watched for so long after the wind, over beta: what is off has grown by e^12."""
_STILL = 0.1
"""A late rate below this part of beta times the wind's peak is no fall."""


def sixdof_verdict(
    vehicle: Vehicle,
    wind: History,
    dead_band: float,
    *,
    plane: str = "pitch",
    frozen: bool = True,
    drift: bool = True,
    step: float = 0.01,
    earth: Earth | None = None,
) -> Callable[[float], bool]:
    """Return what says of a deflection limit [rad] whether its flight survives.

    With a limit that is too low the vehicle falls to the side to which the wind turns it; with
    one that is high enough, but held for ever, to the other.

    Parameters
    ----------
    vehicle, wind, plane, drift, step, earth
        As of `fly_sixdof`; the wind ends.
    dead_band : float
        K.
    frozen : bool
        Only frozen parameters are flown.

    Raises
    ------
    InputError
        As `fly_sixdof`, for parameters that are not frozen, and for an aerodynamically stable
        vehicle.
    """
    if not frozen:
        raise InputError('engine "sixdof" flies frozen parameters only')
    case = SixDof(vehicle, plane, drift, step, earth)
    beta, B = float(case.coefficients.beta), float(case.coefficients.B)
    air = case.air(wind, min(0.0, float(wind.onset)), float(wind.end) + _PATIENCE / beta)
    side, still = -np.sign(float(wind.peak)), _STILL * beta * abs(float(wind.peak))

    def survives(limit: float) -> bool:
        steering = TrimThenHold(B, limit, dead_band, wind, air.times, step)
        return bool(side * case.flown(steering, air)[-1, 1] <= still)

    return survives
