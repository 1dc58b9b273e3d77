"""Whether a planar flight of the report's control survives."""

from collections.abc import Callable

import numpy as np

from tvclin.coefficients import Coefficients
from tvclin.errors import InputError
from tvclin.flight.condition import FlightCondition
from tvclin.flight.control import Command, ReportControl
from tvclin.flight.falls import has_survived, watched_until
from tvclin.flight.planar.case import planar_case
from tvclin.histories import History
from tvclin.vehicle import Vehicle


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
    beta = float(Coefficients.from_vehicle(vehicle, plane).beta)
    span = (float(wind.onset), watched_until(wind, beta))
    case = planar_case(vehicle, wind, span, plane=plane, drift=drift, condition=condition)

    def survives(limit: float) -> bool:
        flown = case.flown(Command(ReportControl(dead_band)), limit)
        rate = flown.rows(np.array([min(flown.end, span[1])]))[1, 0]
        return has_survived(float(rate), wind, beta)

    return survives
