"""The door to flights with six degrees of freedom."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.flight_condition import FlightCondition
from tvclin.base.errors import times_row
from tvclin.control.autopilot.actuator import Actuator
from tvclin.flights.answer import FARTHEST, OUTPUTS, warn_of_the_end
from tvclin.flights.control import Control, command_of, limit_of
from tvclin.flights.sixdof.case import SixDof
from tvclin.flights.sixdof.earth import Earth
from tvclin.linear.response import time_response
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from control import TimeResponseData


def fly_sixdof(
    vehicle: Vehicle,
    control: Control,
    wind: History,
    timepts: ArrayLike,
    *,
    deflection_limit: float = np.inf,
    plane: str = "pitch",
    drift: bool = True,
    step: float = 0.01,
    earth: Earth | None = None,
    condition: FlightCondition | None = None,
    actuator: Actuator | None = None,
    rate_limit: float = np.inf,
) -> TimeResponseData:
    """Return a flight with six degrees of freedom in a wind, flown by JSBSim.

    The parameters of the vehicle are frozen as in the linear theory, or follow its trajectory:
    see `condition`. Nothing else is linear.

    Parameters
    ----------
    vehicle : Vehicle
        One vehicle.
    control : History, Law, Autopilot or ReportControl
        A deflection over time, a law or an autopilot asked at every step, or the report's
        control.
    wind : History
        One wind angle of attack [rad] on the nominal flight, flown as the horizontal wind that
        makes it: in pitch along the flight, positive a tail wind; in yaw across, positive from
        the right.
    timepts : array_like
        Times [s], ``(n,)``; the flight begins at the first of them in time, at rest.
    deflection_limit : float
        Largest deflection [rad]; only a history may do without.
    plane : {"pitch", "yaw"}
        The plane of wind, nozzle and outputs; in yaw angles are positive to the right.
    drift : bool
        Whether the flight path may turn; without drift the velocity stays as it is.
    step : float
        Step of the engine and of the law [s], 0.0001 to 0.02.
    earth : Earth, optional
        Flies over the rotating Earth. Without it the planet is flat and at rest.
    condition : FlightCondition, optional
        With one, mass, speed and dynamic pressure vary along the nominal flight through the
        vehicle's state at its own time, as in `fly_planar`; the air is that of the engine, and
        the wind changes the air speed. Without one, mass, forces and speed stay what they are.
    actuator : Actuator, optional
        Between a law and the nozzle; an autopilot brings its own.
    rate_limit : float
        Largest deflection rate [rad/s] of a law.

    Returns
    -------
    control.TimeResponseData
        Outputs attitude, attitude_rate, flight_path_angle, angle_of_attack and deflection [rad,
        rad/s], as deviations from the nominal flight without wind; input wind [rad].

    Raises
    ------
    InputError
        For batches, numbers out of range, an engine that is not installed, a wind or a history
        that begins before the flight, a step too large for the vehicle or the actuator, a
        nominal flight that does not reach so far, and a flight whose numbers are lost.

    Warns
    -----
    UserWarning
        When the attitude is beyond 25 degrees: the flight ends there, and is NaN from then on.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> wind = tv.TriangularWind(peak=np.radians(1), duration=7.5)
    >>> above = {"control": tv.flights.ReportControl(dead_band=1.0), "deflection_limit": 0.00126}
    >>> tv.fly_sixdof(vehicle, wind=wind, timepts=[0, 15], **above).outputs["attitude"].round(3)
    array([0.   , 0.092])
    """
    case = SixDof(vehicle, plane, drift, step, earth, condition)
    times = times_row("timepts", timepts)
    air = case.air(wind, float(times.min()), float(times.max()))
    command = command_of(control, float(times.min()), actuator, rate_limit)
    limit = limit_of(control, deflection_limit)
    rows = case.flown(case.steering(command, limit, air), air)
    flown = air.times[: len(rows)]
    if abs(rows[-1, 0]) > FARTHEST:
        warn_of_the_end(float(flown[-1]))
    outputs = np.stack([np.interp(times, flown, row, right=np.nan) for row in rows.T])
    title = f"Flight with six degrees of freedom, {vehicle.name or 'vehicle'}, {plane}"
    return time_response(times, outputs, OUTPUTS, name="JSBSim", title=title, wind=wind)
