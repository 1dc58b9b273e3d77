"""The door to flights with six degrees of freedom."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.autopilot import Actuator
from tvclin.closed_loop.airframe import Nozzle
from tvclin.closed_loop.checks import check_actuator, check_rate_limit
from tvclin.errors import InputError, number, positive
from tvclin.flight.answer import (
    FARTHEST,
    begins_in_time,
    flight_response,
    flight_times,
    warn_of_the_end,
)
from tvclin.flight.control import Control, ReportControl, law_and_actuator
from tvclin.flight.sixdof.case import Air, SixDof
from tvclin.flight.sixdof.earth import Earth
from tvclin.flight.sixdof.steering import Steering, TrimThenHold, by_history, by_law
from tvclin.histories import History
from tvclin.vehicle import Vehicle

if TYPE_CHECKING:
    from control import TimeResponseData

FloatArray = NDArray[np.float64]

_PER_STEP = 0.5
"""Most of the actuator's 1/omega_n that a step may be."""


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
    actuator: Actuator | None = None,
    rate_limit: float = np.inf,
) -> "TimeResponseData":
    """Return a flight with six degrees of freedom in a wind, flown by JSBSim.

    The parameters of the vehicle are frozen as in the linear theory: mass, forces and speed stay
    what they are. Nothing else is linear.

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
        that begins before the flight, a step too large for the vehicle or the actuator, and a
        flight whose numbers are lost.

    Warns
    -----
    UserWarning
        When the attitude is beyond 25 degrees: the flight ends there, and is NaN from then on.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> wind = tv.TriangularWind(peak=np.radians(1), duration=7.5)
    >>> control = tv.ReportControl(dead_band=1.0)
    >>> for limit in (0.00120, 0.00126):
    ...     flown = tv.fly_sixdof(vehicle, control, wind, [0, 15], deflection_limit=limit)
    ...     print(flown.outputs["attitude"][-1].round(3))
    -0.092
    0.092
    """
    case = SixDof(vehicle, plane, drift, step, earth)
    times = flight_times(timepts)
    air = case.air(wind, float(times.min()), float(times.max()))
    steering = _steering(case, control, air, deflection_limit, actuator, rate_limit)
    return _response(times, air, case.flown(steering, air), f"{vehicle.name or 'vehicle'}, {plane}")


def _steering(
    case: SixDof,
    control: Control,
    air: Air,
    deflection_limit: float,
    actuator: Actuator | None,
    rate_limit: float,
) -> Steering:
    most = check_rate_limit(rate_limit)
    limit = deflection_limit
    if not (isinstance(control, History) and limit == np.inf):
        limit = number("deflection_limit", deflection_limit, positive, "rad")
    if isinstance(control, History | ReportControl) and (actuator is not None or most < np.inf):
        raise InputError("actuator and rate_limit belong to a law or an autopilot")
    if isinstance(control, History):
        if control.batch:
            raise InputError(f"control must be one history; got a batch of shape {control.batch}")
        begins_in_time("control", control, float(air.times[1]))
        return by_history(control, air.times, case.step, limit)
    if isinstance(control, ReportControl):
        B = float(case.coefficients.B)
        return TrimThenHold(B, limit, control.dead_band, air.wind, air.times, case.step)
    law, actuator = law_and_actuator(control, actuator)
    _check_step(actuator, case.step)
    return by_law(law, Nozzle(actuator, most, case.step), limit, air.times.size)


def _check_step(actuator: Actuator | None, step: float) -> None:
    check_actuator(actuator)
    if actuator is not None and step * float(actuator.natural_frequency) > _PER_STEP:
        raise InputError(
            f"step must be at most {_PER_STEP / float(actuator.natural_frequency):.6g} s for an"
            f" actuator of {actuator.natural_frequency:.6g} rad/s; got {step:.6g} s"
        )


def _response(times: FloatArray, air: Air, rows: FloatArray, title: str) -> "TimeResponseData":
    flown = air.times[: len(rows)]
    if abs(rows[-1, 0]) > FARTHEST:
        warn_of_the_end(float(flown[-1]))
    outputs = np.stack([np.interp(times, flown, row, right=np.nan) for row in rows.T])
    title = f"Flight with six degrees of freedom, {title}"
    return flight_response(times, outputs, air.wind, engine="JSBSim", title=title)
