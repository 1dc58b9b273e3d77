"""Whether a planar flight survives."""

from collections.abc import Callable

import numpy as np

from tvclin.control.autopilot.actuator import Actuator
from tvclin.flights.checks import check_frozen
from tvclin.flights.condition import FlightCondition
from tvclin.flights.control import Control, command_of
from tvclin.flights.falls import has_survived, lets_go, watched_until
from tvclin.flights.planar.case import planar_case
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History


def planar_verdict(
    vehicle: Vehicle,
    wind: History,
    control: Control,
    *,
    plane: str = "pitch",
    frozen: bool = True,
    drift: bool = True,
    condition: FlightCondition | None = None,
    actuator: Actuator | None = None,
    rate_limit: float = np.inf,
) -> Callable[[float], bool]:
    """Return what says of a deflection limit [rad] whether its planar flight survives.

    `vehicle`, `wind`, `control`, `plane`, `drift`, `condition`, `actuator`, `rate_limit`: as of
    `fly_planar`; the wind ends. `frozen`: whether parameters are frozen; if not, they vary along
    the nominal flight of `condition`. `InputError` as `fly_planar`, and for an aerodynamically
    stable vehicle.
    """
    check_frozen(frozen, condition)
    pole = float(Coefficients.from_vehicle(vehicle, plane).pole)
    if frozen:  # any time is like another, and near zero it is known more sharply
        wind = wind.shift(-wind.onset)
    span = (float(wind.onset), watched_until(wind, pole))
    case = planar_case(vehicle, wind, span, plane=plane, drift=drift, condition=condition)
    command = command_of(control, span[0], actuator, rate_limit)

    def survives(limit: float) -> bool:
        flown = case.flown(command, limit)
        rate = flown.rows(np.array([min(flown.end, span[1])]))[1, 0]
        return has_survived(float(rate), wind, pole, lets_go(command.control))

    return survives
