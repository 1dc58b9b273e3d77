"""Whether a flight survives in JSBSim."""

from collections.abc import Callable

import numpy as np

from tvclin.control.autopilot.actuator import Actuator
from tvclin.flights.checks import check_frozen
from tvclin.flights.condition import FlightCondition
from tvclin.flights.control import Control, command_of
from tvclin.flights.falls import has_survived, lets_go, watched_until
from tvclin.flights.sixdof.case import SixDof
from tvclin.flights.sixdof.earth import Earth
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History


def sixdof_verdict(
    vehicle: Vehicle,
    wind: History,
    control: Control,
    *,
    plane: str = "pitch",
    frozen: bool = True,
    drift: bool = True,
    step: float = 0.01,
    earth: Earth | None = None,
    condition: FlightCondition | None = None,
    actuator: Actuator | None = None,
    rate_limit: float = np.inf,
) -> Callable[[float], bool]:
    """Return what says of a deflection limit [rad] whether its flight survives.

    `step`, `earth`: as of `fly_sixdof`, which says what is refused; all others as of
    `planar_verdict`.
    """
    check_frozen(frozen, condition)
    case = SixDof(vehicle, plane, drift, step, earth, condition)
    pole, begin = float(case.coefficients.pole), float(wind.onset)
    air = case.air(wind, min(0.0, begin) if frozen else begin, watched_until(wind, pole))
    command = command_of(control, begin, actuator, rate_limit)

    def survives(limit: float) -> bool:
        late = case.flown(case.steering(command, limit, air), air)[-1, 1]
        return has_survived(float(late), wind, pole, lets_go(command.control))

    return survives
