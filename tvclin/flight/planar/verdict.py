"""Whether a planar flight of the report's control survives: the side to which it falls."""

from collections.abc import Callable

import numpy as np

from tvclin.coefficients import Coefficients
from tvclin.errors import InputError
from tvclin.flight.condition import FlightCondition
from tvclin.flight.control import ReportControl
from tvclin.flight.planar.case import planar_case
from tvclin.histories import History
from tvclin.vehicle import Vehicle

_PATIENCE = 12.0
"""A flight is watched for so long after the wind, over beta: what is off has grown by e^12."""
_STILL = 0.1
"""A late rate below this part of beta times the wind's peak is no fall."""


def planar_verdict(
    vehicle: Vehicle,
    wind: History,
    dead_band: float,
    *,
    plane: str = "pitch",
    frozen: bool = True,
    drift: bool = True,
    condition: FlightCondition | None = None,
) -> Callable[[float], bool]:
    """Return what says of a deflection limit [rad] whether its planar flight survives.

    With a limit that is too low the vehicle falls to the side to which the wind turns it; with
    one that is high enough, but held for ever, to the other.

    Parameters
    ----------
    vehicle, wind, plane, drift, condition
        As of `fly_planar`; the wind ends.
    dead_band : float
        K.
    frozen : bool
        Whether parameters are frozen; if not, they vary along the nominal flight of `condition`.

    Raises
    ------
    InputError
        As `fly_planar`, and for an aerodynamically stable vehicle.
    """
    if frozen == (condition is not None):
        raise InputError(
            "condition must be given exactly when parameters are not frozen (frozen=False)"
        )
    coefficients = Coefficients.from_vehicle(vehicle, plane)
    beta = float(coefficients.beta)
    span = (float(wind.onset), float(wind.end) + _PATIENCE / beta)
    case = planar_case(vehicle, wind, span, plane=plane, drift=drift, condition=condition)
    side, still = -np.sign(float(wind.peak)), _STILL * beta * abs(float(wind.peak))

    def survives(limit: float) -> bool:
        flown = case.flown(ReportControl(dead_band), limit)
        rate = flown.rows(np.array([min(flown.end, span[1])]))[1, 0]
        return bool(side * rate <= still)

    return survives
