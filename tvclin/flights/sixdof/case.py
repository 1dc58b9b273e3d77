"""What is flown, checked: one vehicle in its plane, and a wind at its steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.ascent.flight_condition import FlightCondition
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, flag, instance, number, one_of, single, within
from tvclin.control.laws.trim import TrimLaw
from tvclin.flights.answer import OUTPUTS
from tvclin.flights.closed_loop.checks import check_span
from tvclin.flights.control import Command, ReportControl, check_one
from tvclin.flights.sixdof.airframe import Place, borrowed
from tvclin.flights.sixdof.departure import Course, course_of
from tvclin.flights.sixdof.earth import Earth
from tvclin.flights.sixdof.steering import Steering, TrimThenHold, by_history, by_law, step_means
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import PLANES, Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History

_SHORTEST, _LONGEST = 1e-4, 0.02
"""Steps of the engine [s] that are taken."""
_PER_STEP = 0.05
"""Most that the airframe's own motion may go on in a step; errors are of its square."""
_PER_SERVO = 0.5
"""Most of the actuator's 1/omega_n that a step may be."""


@dataclass(frozen=True, eq=False)
class Air:
    """A wind as it is flown.

    `wind`: the wind angle [rad]. `times`: times of the steps [s], ``(n,)``; the first lies before
    the flight. `angles`, `speeds`: means over each step: wind angle [rad], and wind speed [m/s]
    along the flight or to its right. `course`: the nominal flight where parameters vary.
    """

    wind: History
    times: FloatArray
    angles: FloatArray
    speeds: FloatArray
    course: Course | None


@dataclass(frozen=True)
class SixDof:
    """What is flown, checked.

    `vehicle`, `plane`, `drift`, `step`, `earth`, `condition`: as of `fly_sixdof`.
    """

    vehicle: Vehicle
    plane: str = "pitch"
    drift: bool = True
    step: float = 0.01
    earth: Earth | None = None
    condition: FlightCondition | None = None

    def __post_init__(self) -> None:
        instance("vehicle", self.vehicle, Vehicle, "see load_vehicle")
        one_of("plane", self.plane, PLANES)
        flag("drift", self.drift)
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
        step = within("step", self.step, _SHORTEST, _LONGEST, "s")
        object.__setattr__(self, "step", number("step", step))
        c = self.coefficients
        pace = abs(float(c.mu_alpha)) ** 0.5 + float(c.damping)
        if self.step * pace > _PER_STEP:
            raise InputError(
                f"step must be at most {_PER_STEP / pace:.3g} s for a vehicle that moves with"
                f" {pace:.3g} rad/s; got {self.step:.6g} s"
            )

    @property
    def coefficients(self) -> Coefficients:
        """The coefficients of the vehicle in this plane."""
        return Coefficients.from_vehicle(self.vehicle, self.plane)

    def air(self, wind: History, start: float, stop: float) -> Air:
        """Return a wind at the steps of a flight from `start` to `stop` [s] or just beyond."""
        check_span(start, stop)
        check_one("wind", wind, start)
        count = int(np.ceil((stop - start) / self.step - 1e-9)) + 2
        times = start + self.step * np.arange(-1.0, count)
        angles = step_means(wind, times, self.step)
        if self.condition is None:
            speeds = self._speeds(angles, self.vehicle.velocity, self.vehicle.attitude)
            return Air(wind, times, angles, speeds, None)
        course = course_of(self.vehicle, self.condition, times)
        speeds = self._speeds(angles, course.speeds, course.rows[:, 2])
        return Air(wind, times, angles, speeds, course)

    def steering(self, command: Command, limit: float, air: Air) -> Steering:
        """Return what turns the nozzle within a limit [rad], step by step.

        `InputError` for a step too large for the actuator.
        """
        control, actuator = command.control, command.actuator
        if isinstance(control, History):
            return by_history(control, air.times, self.step, limit)
        if isinstance(control, ReportControl):
            trim = TrimLaw(Plant.from_vehicle(self.vehicle, "fixed-path", self.plane))
            return TrimThenHold(trim, limit, control.dead_band, air.wind, air.times, self.step)
        if actuator is not None and self.step * float(actuator.natural_frequency) > _PER_SERVO:
            raise InputError(
                f"step must be at most {_PER_SERVO / float(actuator.natural_frequency):.6g} s for"
                f" an actuator of {actuator.natural_frequency:.6g} rad/s; got {self.step:.6g} s"
            )
        return by_law(command, limit, self.step, air.times.size)

    def flown(self, steering: Steering, air: Air) -> FloatArray:
        """Return the outputs at the steps that were flown; `InputError` for lost numbers."""
        place: Place = self.earth
        vehicle, held = self.vehicle, None
        if air.course is not None:
            vehicle, place, held = air.course.vehicle, air.course.departure, air.course.rows
        numbers = vehicle.replace(name="", time=None)  # all that the engine knows of it
        with borrowed(numbers, self.plane, self.drift, self.step, place) as airframe:
            rows = airframe.fly(steering, air.speeds, air.angles, held)
        lost = np.argwhere(~np.isfinite(rows))
        if lost.size:
            raise InputError(
                f"the flight fails at t = {air.times[lost[0, 0]]:.6g} s:"
                f" {OUTPUTS[lost[0, 1]]} is not finite"
            )
        return rows

    def _speeds(self, angles: FloatArray, velocity: Any, attitude: Any) -> FloatArray:
        """Return the horizontal wind [m/s] that makes these angles on the nominal flight."""
        path = np.asarray(attitude if self.plane == "pitch" else np.pi / 2)
        sine = np.sin(path + angles)
        if np.any(sine * np.sin(path) <= 0.0):
            raise InputError(
                "wind must be an angle that a horizontal wind can make, at a flight path of"
                f" {path.min():.6g} rad; got {angles[np.argmax(np.abs(angles))]:.6g} rad"
            )
        tail = velocity * np.sin(angles) / sine
        return np.asarray(tail if self.plane == "pitch" else -tail)
