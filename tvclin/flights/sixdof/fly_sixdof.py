"""Flights with six degrees of freedom in JSBSim: `fly_sixdof`, and the verdict in both planes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.nominal_flight import FlightCondition
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, between, instance, single, times_row
from tvclin.base.fields import checked, flag, quantity, word
from tvclin.boundary.limit_shapes import LimitShape
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.laws.autopilot_law import SaturatedLaw
from tvclin.control.laws.law import Law, LawInPlanes, Measurement
from tvclin.control.laws.trim import TrimLaw
from tvclin.flights.closed_loop.checks import check_span
from tvclin.flights.engine_interface import (
    MAX_ATTITUDE,
    OUTPUTS,
    Command,
    Control,
    ReportControl,
    check_history,
    check_path,
    command_of,
    has_fallen,
    limit_of,
    verdict_time,
    warn_of_the_end,
)
from tvclin.flights.sixdof.airframe import Surroundings, reused_airframe
from tvclin.flights.sixdof.model import Earth, NominalTrajectory, nominal_trajectory
from tvclin.flights.sixdof.steering import Steering, TrimThenHold, by_history, by_law, step_means
from tvclin.linear.lateral import NO_LATERAL_SENSORS, LateralSensors
from tvclin.linear.plant import Plant
from tvclin.linear.response import time_response
from tvclin.vehicle.coefficients import PLANES, Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind

if TYPE_CHECKING:
    from control import TimeResponseData


_MIN_STEP, _MAX_STEP = 1e-4, 0.02
"""Smallest and largest step of the engine [s]."""
_MAX_STEP_TIMES_FREQUENCY = 0.05
"""Largest step times the frequency of the airframe; errors are of its square."""
_MAX_STEP_TIMES_ACTUATOR = 0.5
"""Largest step times the natural frequency of the actuator."""


@dataclass(frozen=True, eq=False)
class Air:
    """Wind at the steps of a flight.

    `wind`: the wind angle [rad]. `times`: times of the steps [s], ``(n,)``; the first lies before
    the flight. `angles`, `speeds`: means over each step: wind angle [rad], and wind speed [m/s]
    along the flight or to its right. `trajectory`: the nominal flight where parameters vary.
    """

    wind: History
    times: FloatArray
    angles: FloatArray
    speeds: FloatArray
    trajectory: NominalTrajectory | None


@dataclass(frozen=True)
class SixDof:
    """Vehicle and options of a flight in JSBSim, checked.

    `vehicle`, `plane`, `drift`, `step`, `earth`, `condition`: same as in `fly_sixdof`.
    """

    vehicle: Vehicle
    plane: str = word(PLANES, "pitch")
    drift: bool = flag(True)
    step: float = quantity("time", 0.01, between(_MIN_STEP, _MAX_STEP))
    earth: Earth | None = None
    condition: FlightCondition | None = None

    def __post_init__(self) -> None:
        """Raise `InputError` for a batch, numbers out of range, and conflicting options."""
        instance("vehicle", self.vehicle, Vehicle, "see load_vehicle")
        checked(self, "plane", "drift")
        single("vehicle", self.coefficients.batch)
        if self.earth is not None:
            instance("earth", self.earth, Earth, "or None for a flat planet")
        if self.condition is not None:
            instance("condition", self.condition, FlightCondition, "see load_flight_condition")
            if self.earth is not None or not self.drift:
                raise InputError(
                    "condition must be left out over the Earth and without drift: with one, the"
                    " flight follows its trajectory over a flat planet"
                )
        checked(self, "step")
        c = self.coefficients
        frequency = abs(float(c.mu_alpha)) ** 0.5 + float(c.damping)
        if self.step * frequency > _MAX_STEP_TIMES_FREQUENCY:
            raise InputError(
                f"step must be at most {_MAX_STEP_TIMES_FREQUENCY / frequency:.3g} s for a vehicle"
                f" that moves with {frequency:.3g} rad/s; got {self.step:.6g} s"
            )

    @property
    def coefficients(self) -> Coefficients:
        """Coefficients of the vehicle in this plane."""
        return Coefficients.from_vehicle(self.vehicle, self.plane)

    def air(self, wind: History, start: float, stop: float) -> Air:
        """Return the wind at the steps of a flight from `start` to `stop` [s] or just beyond.

        `wind`: one wind angle [rad]. With a `condition`, with which speed and pressure vary, the
        nominal trajectory is included. `InputError` for a wind from before the start, and an angle
        that no horizontal wind can make.
        """
        check_span(start, stop)
        check_history("wind", wind, start)
        # one step before the start, and one beyond the end; 1e-9 of a step is rounding
        count = int(np.ceil((stop - start) / self.step - 1e-9)) + 2
        times = start + self.step * np.arange(-1.0, count)
        angles = step_means(wind, times, self.step)
        trajectory, velocity, path = None, self.vehicle.velocity, self.vehicle.attitude
        if self.condition is not None:
            trajectory = nominal_trajectory(self.vehicle, self.condition, times)
            velocity, path = trajectory.speeds, trajectory.rows[:, 2]
        speeds = self._speeds(angles, velocity, path)
        return Air(wind, times, angles=angles, speeds=speeds, trajectory=trajectory)

    def steering(self, command: Command, limit: float, air: Air) -> Steering:
        """Return the function from step number and measurements to a deflection in `limit` [rad].

        `command`: a deflection over time, the report's control, or a law with actuator and rate
        limit. `air`: wind at the steps. `InputError` for a step too large for the actuator.
        """
        control, actuator = command.control, command.actuator
        if isinstance(control, History):
            return by_history(control, air.times, self.step, limit)
        if isinstance(control, ReportControl):
            trim = TrimLaw(Plant.from_vehicle(self.vehicle, "fixed-path", self.plane))
            return TrimThenHold(
                trim, limit, control.dead_band, wind=air.wind, times=air.times, step=self.step
            )
        frequency = 0.0 if actuator is None else float(actuator.natural_frequency)
        if self.step * frequency > _MAX_STEP_TIMES_ACTUATOR:
            raise InputError(
                f"step must be at most {_MAX_STEP_TIMES_ACTUATOR / frequency:.6g} s for an actuator"
                f" of {frequency:.6g} rad/s; got {self.step:.6g} s"
            )
        return by_law(command, limit, self.step, air.times.size)

    def flown(
        self, steering: Steering, air: Air, sensors: LateralSensors = NO_LATERAL_SENSORS
    ) -> FloatArray:
        """Return the `OUTPUTS` [rad, rad/s] of a flight at the steps, ``(m, 5)``.

        They are deviations from the nominal flight, and end where the attitude leaves the range of
        the model. `steering`: function that returns the deflection. `air`: wind at the steps; if it
        has a trajectory, of that vehicle, from its departure, and less its nominal outputs, `rows`.
        `sensors`: lateral sensors of the law. `InputError` for NaN, and for drift that is measured
        on a path that does not turn.
        """
        check_path(self.drift, sensors)
        surroundings: Surroundings = self.earth
        vehicle, reference = self.vehicle, None
        if air.trajectory is not None:
            vehicle, surroundings, reference = (
                air.trajectory.vehicle,
                air.trajectory.departure,
                air.trajectory.rows,
            )
        numbers = vehicle.replace(name="", time=None)  # all that the engine knows of it
        with reused_airframe(numbers, self.plane, self.drift, self.step, surroundings) as airframe:
            rows = airframe.fly(steering, air.speeds, air.angles, reference, sensors)
        invalid = np.argwhere(~np.isfinite(rows))
        if invalid.size:
            raise InputError(
                f"the flight fails at t = {air.times[invalid[0, 0]]:.6g} s:"
                f" {OUTPUTS[invalid[0, 1]]} is not finite"
            )
        return rows

    def _speeds(self, angles: FloatArray, velocity: Any, attitude: Any) -> FloatArray:
        """Return the horizontal wind [m/s] that makes wind angles [rad] on the nominal flight.

        By the sine rule it is V sin(angle)/sin(path + angle), V being the speed; in yaw the path is
        at a right angle to the wind, and the wind from the right is negative. `InputError` where no
        horizontal wind makes the angle. `velocity`, `attitude`: speed [m/s] and attitude [rad] of
        that flight, constant or ``(n,)``.
        """
        path = np.asarray(attitude if self.plane == "pitch" else np.pi / 2)
        sine = np.sin(path + angles)
        if np.any(sine * np.sin(path) <= 0.0):
            raise InputError(
                "wind must be an angle that a horizontal wind can make, at a flight path of"
                f" {path.min():.6g} rad; got {angles[np.argmax(np.abs(angles))]:.6g} rad"
            )
        tail = velocity * np.sin(angles) / sine
        return np.asarray(tail if self.plane == "pitch" else -tail)


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
    vehicle, timepts, actuator
        Same as in `fly_planar`.
    control : History, Law, Autopilot or ReportControl
        A deflection over time, a law or an autopilot asked at every step, or the report's
        control.
    wind : History
        One wind angle of attack [rad] on the nominal flight, flown as the horizontal wind that
        makes it: in pitch along the flight, positive a tail wind; in yaw across, positive from
        the right.
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
    case = SixDof(vehicle, plane, drift, step=step, earth=earth, condition=condition)
    times = times_row("timepts", timepts)
    air = case.air(wind, float(times.min()), float(times.max()))
    command = command_of(control, float(times.min()), actuator, rate_limit)
    limit = limit_of(control, deflection_limit)
    rows = case.flown(case.steering(command, limit, air), air, command.lateral_sensors)
    flown = air.times[: len(rows)]
    if abs(rows[-1, 0]) > MAX_ATTITUDE:
        warn_of_the_end(float(flown[-1]))
    outputs = np.stack([np.interp(times, flown, row, right=np.nan) for row in rows.T])
    title = f"Flight with six degrees of freedom, {vehicle.name or 'vehicle'}, {plane}"
    return time_response(times, outputs, OUTPUTS, name="JSBSim", title=title, wind=wind)


def planes_verdict(
    vehicle: Vehicle,
    wind: PlaneWind,
    control: object,
    *,
    frozen: bool = True,
    drift: bool = True,
    step: float = 0.01,
    limit_shape: LimitShape | str = "round",
    saturate: str = "radial",
) -> Callable[[float], bool]:
    """Return the function from a deflection limit [rad] to whether its flight survives.

    The flight is in both planes, over a flat planet with frozen parameters. `wind`: one wind that
    ends, from t = 0 on. `control`: law of both planes. `drift`: whether the flight path may turn.
    `step`: step of JSBSim and of the law [s]. `limit_shape`: limit shape of the nozzle, or its
    name. `saturate`: "radial" or "each plane". `InputError` for another type than a law, parameters
    that are not frozen, and in the same cases as `fly_sixdof` and `fly_planes`.
    """
    if isinstance(control, Autopilot):
        control = SaturatedLaw(control)
    if not isinstance(control, Law):
        raise InputError("both planes are flown by a law; give law=, such as TrimLaw")
    check_path(drift, control.lateral_sensors)
    if not frozen:
        raise InputError("both planes are flown with frozen parameters; leave frozen=True")
    law = LawInPlanes(control, limit_shape, saturate)
    cases = {plane: SixDof(vehicle, plane, drift, step) for plane in PLANES}
    pole = float(cases["yaw"].coefficients.pole)
    begin, until = min(0.0, float(wind.onset)), verdict_time(wind, pole)
    check_span(begin, until)
    winds = [case.air(getattr(wind, plane), begin, until) for plane, case in cases.items()]
    # at the steps, in each plane: speeds [m/s] and angles [rad]
    speeds, angles = (np.stack([getattr(air, n) for air in winds]) for n in ("speeds", "angles"))
    numbers = vehicle.replace(name="", time=None)  # airframes are reused by numbers alone

    def survives(limit: float) -> bool:
        """Return whether the vehicle survives the wind with a deflection limit [rad].

        Its attitudes must stay within `MAX_ATTITUDE`, and its last attitude rates mean no fall.
        """
        with reused_airframe(numbers, "pitch", drift, step, None) as airframe:
            steering = _steering(law, limit, step)
            rows = airframe.fly_both(steering, speeds, angles, control.lateral_sensors)
        # rows: samples, planes, outputs; of the last sample attitudes, then attitude rates
        if not np.all(np.isfinite(rows)) or np.abs(rows[-1, :, 0]).max() > MAX_ATTITUDE:
            return False
        return not has_fallen(float(np.hypot(*rows[-1, :, 1])), float(wind.peak), pole)

    return survives


def _steering(
    law: LawInPlanes, limit: float, step: float
) -> Callable[[list[Measurement]], tuple[float, float]]:
    """Return the steering of a law in both planes, from their measurements to both deflections.

    Vectors are complex, pitch + j yaw; the law has one state vector, stepped with `step`. `limit`:
    deflection limit of the vector [rad]. `step`: step [s].
    """
    steps = law.law.state_space.to_steps(step)
    memory, limits = np.zeros(len(steps.states), complex), np.array([limit])

    def command_of(planes: list[Measurement]) -> tuple[float, float]:
        """Return the commands [rad] in pitch and yaw, and update the state of the law."""
        nonlocal memory
        pitch, yaw = planes
        measured = np.array(pitch) + 1j * np.array(yaw)
        demand = law.demand(measured[np.newaxis], memory[np.newaxis], limits)
        (command,), _ = law.limited(demand, limits)
        memory = steps.A @ memory + steps.B @ measured
        return float(command.real), float(command.imag)

    return command_of
