"""The door to planar flights."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.flight_condition import FlightCondition
from tvclin.base.errors import times_row
from tvclin.control.autopilot.actuator import Actuator
from tvclin.flights.answer import OUTPUTS, warn_of_the_end
from tvclin.flights.control import Control, command_of, limit_of
from tvclin.flights.planar.case import planar_case
from tvclin.linear.response import time_response
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from control import TimeResponseData


def fly_planar(
    vehicle: Vehicle,
    control: Control,
    wind: History,
    timepts: ArrayLike,
    *,
    deflection_limit: float = np.inf,
    plane: str = "pitch",
    drift: bool = True,
    condition: FlightCondition | None = None,
    actuator: Actuator | None = None,
    rate_limit: float = np.inf,
) -> TimeResponseData:
    """Return a flight of the equations (B1) in a wind.

    Parameters
    ----------
    vehicle : Vehicle
        One vehicle.
    control : History, Law, Autopilot or ReportControl
        A deflection over time, a law or an autopilot, or the report's control.
    wind : History
        One wind angle of attack [rad] on the nominal flight, positive a tail wind or one that
        turns the path away from the nose.
    timepts : array_like
        Times [s], ``(n,)``; the flight begins at the first of them in time, at rest.
    deflection_limit : float
        Largest deflection [rad]; only a history may do without.
    plane : {"pitch", "yaw"}
        The plane of wind, nozzle and outputs.
    drift : bool
        Whether the flight path may turn and the speed change.
    condition : FlightCondition, optional
        With one, mass and aerodynamic forces vary along the nominal flight through the vehicle's
        state at its own time, and the wind is a wind: it changes air speed and dynamic pressure.
        Without one, all parameters are frozen.
    actuator : Actuator, optional
        Between a law and the nozzle; an autopilot brings its own.
    rate_limit : float
        Largest deflection rate [rad/s] of a law; it needs an actuator.

    Returns
    -------
    control.TimeResponseData
        Outputs attitude, attitude_rate, flight_path_angle, angle_of_attack and deflection [rad,
        rad/s], as deviations from the nominal flight; input wind [rad].

    Raises
    ------
    InputError
        For batches, numbers out of range, a wind or a history that begins before the flight, a
        wind that never ends, and a nominal flight that does not reach so far.

    Warns
    -----
    UserWarning
        When the attitude is beyond 25 degrees: the flight ends there, and is NaN from then on.

    Notes
    -----
    Breakpoints of the wind, the limit and the switches of a law are hit by the solver; see `fly`.
    The nominal deflection, some thousandths of a degree, is not counted against the limit.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> wind = tv.TriangularWind(peak=np.radians(1), duration=7.5)
    >>> control = tv.flights.ReportControl(dead_band=1.0)
    >>> for limit in (0.00120, 0.00126):
    ...     flown = tv.fly_planar(vehicle, control, wind, [0, 15], deflection_limit=limit)
    ...     print(flown.outputs["attitude"][-1].round(3))
    -0.093
    0.091
    """
    times = times_row("timepts", timepts)
    span = (float(times.min()), float(times.max()))
    case = planar_case(vehicle, wind, span, plane=plane, drift=drift, condition=condition)
    command = command_of(control, span[0], actuator, rate_limit)
    flown = case.flown(command, limit_of(control, deflection_limit))
    if np.isfinite(flown.end):
        warn_of_the_end(flown.end)
    rows = flown.rows(times)
    alpha = case.motion.angle_of_attack(times, rows[:-1], wind(times))
    outputs = np.vstack([rows[:3], alpha, rows[-1]])
    title = f"Planar flight, {vehicle.name or 'vehicle'}, {plane}"
    return time_response(times, outputs, OUTPUTS, name="planar", title=title, wind=wind)
