"""A vehicle over its flight: the numbers of Table I at many times, and what lies between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.atmosphere import speed_of_sound, standard_atmosphere
from tvclin.ascent.nominal_flight import FlightCondition, nominal_flight, time_of
from tvclin.ascent.structure_schedule import StructureSchedule, structures_at, table_reader
from tvclin.base import errors
from tvclin.base.arrays import FloatArray, IndexArray
from tvclin.base.cards import Shown
from tvclin.base.fields import derived, spec
from tvclin.base.files import called, write_text
from tvclin.linear.plant import Plant
from tvclin.vehicle.vehicle import AIR_FORCES, NUMBERS, Vehicle
from tvclin.vehicle.vehicle_file import VEHICLE_TABLE

_MIN_B = 1e-9
"""Smallest |B| of plants: without a moment of the air coefficients do not give the path."""
_ARM_ROUNDING = 1e-9
"""Aerodynamic arm over the largest of a flight, up to which it counts as zero."""
_ACTUATOR = ("actuator_frequency", "actuator_damping")
"""Names of the fields of the actuator."""
_MAX_ROWS = 100_000
"""Rows of a schedule; more are a step that was given in the wrong unit."""


@dataclass(frozen=True, eq=False)
class FlightSchedule(Shown):
    """A vehicle at several times of its flight, straight lines between them.

    Parameters
    ----------
    vehicle : Vehicle
        A batch ``(n,)`` of two or more, whose `time` rises. Numbers that do not change may stand
        once.
    nominal_deflection : array_like
        Deflection of the nominal flight delta_n [rad], ``(n,)`` or one for all; zero if not known.
    altitude : array_like, optional
        Altitude [m], ``(n,)``: only a wind over height needs it.
    structure : StructureSchedule, optional
        Bending and slosh over the flight, at least over its times; see `load_structure`.
    actuator_frequency, actuator_damping : array_like, optional
        Natural frequency [rad/s] and damping ratio of the actuator, positive, ``(n,)`` or one for
        all; both or neither.
    notes : tuple of str
        Where its numbers came from, and what else a reader should know.

    Raises
    ------
    InputError
        For a vehicle without times, fewer than two of them, times that do not rise, shapes other
        than theirs, and a structure that is not known at all of them.

    Examples
    --------
    >>> import tvclin as tv
    >>> booster = tv.load_vehicle("configuration-i")
    >>> schedule = tv.FlightSchedule(booster.replace(time=[60.0, 70.0], velocity=[500.0, 580.0]))
    >>> schedule.at(65.0).velocity
    540.0
    """

    vehicle: Vehicle = field(metadata=spec(of="vehicle.name"))
    nominal_deflection: ArrayLike = 0.0
    altitude: ArrayLike | None = field(default=None, metadata=spec("length"))
    notes: tuple[str, ...] = field(default=(), metadata=spec())
    structure: StructureSchedule | None = None
    actuator_frequency: ArrayLike | None = None
    actuator_damping: ArrayLike | None = None

    def __post_init__(self) -> None:
        """Check the fields, and set them to arrays; `InputError` as the class says."""
        errors.instance("vehicle", self.vehicle, Vehicle, "see load_vehicle")
        times = np.asarray(self.vehicle.time)
        if self.vehicle.time is None or times.ndim != 1 or times.size < 2:
            raise errors.InputError(
                "vehicle must be a batch with two or more times [s] in its field time; got"
                f" {'none' if self.vehicle.time is None else f'times of shape {times.shape}'}"
            )
        if np.any(np.diff(times) <= 0.0):
            late = int(np.argmax(np.diff(times) <= 0.0)) + 1
            raise errors.InputError(
                f"the times of a schedule must rise; got {times[late]:.6g} s after"
                f" {times[late - 1]:.6g} s at index {late}"
            )
        nominal = errors.small_angle("a deflection")("nominal_deflection", self.nominal_deflection)
        object.__setattr__(self, "nominal_deflection", nominal)
        numbers = {"nominal_deflection": nominal, **_numbers(self.vehicle)}
        if self.altitude is not None:
            object.__setattr__(self, "altitude", errors.finite("altitude", self.altitude, "m"))
            numbers["altitude"] = self.altitude
        numbers |= self._checked_actuator()
        for name, values in numbers.items():
            if np.shape(values) not in ((), times.shape):
                raise errors.InputError(
                    f"{name} must be one number or one for each of the {times.size} times; got"
                    f" shape {np.shape(values)}"
                )
        notes = errors.each("notes", self.notes, str, "one for each remark")
        object.__setattr__(self, "notes", tuple(errors.text("notes", note) for note in notes))
        if self.structure is not None:
            errors.instance("structure", self.structure, StructureSchedule, "see load_structure")
            first, last = self.structure.span
            if first > times[0] or last < times[-1]:
                raise errors.InputError(
                    f"the structure must be known over the whole flight, {times[0]:.6g} to"
                    f" {times[-1]:.6g} s; got {first:.6g} to {last:.6g} s"
                )

    def _checked_actuator(self) -> dict[str, FloatArray]:
        """Check and set frequency [rad/s] and damping of the actuator; return them by name."""
        checked = {
            name: errors.positive(name, getattr(self, name))
            for name in _ACTUATOR
            if getattr(self, name) is not None
        }
        if len(checked) == 1:
            raise errors.InputError("an actuator over the flight needs a frequency and a damping")
        for name, array in checked.items():
            object.__setattr__(self, name, array)
        return checked

    @property
    @derived("time")
    def times(self) -> FloatArray:
        """The times [s], rising, ``(n,)``."""
        return np.asarray(self.vehicle.time)

    @property
    def time(self) -> FloatArray:
        """The times [s], ``(n,)``, by the name that flights through soundings use."""
        return self.times

    @property
    def height(self) -> FloatArray:
        """The altitude at the times [m], ``(n,)``; `InputError` where it is not known."""
        if self.altitude is None:
            raise errors.InputError("the schedule has no altitude; give altitude_m in it")
        return np.broadcast_to(np.asarray(self.altitude), self.times.shape)

    @property
    @derived("speed")
    def speed(self) -> FloatArray:
        """The speed at the times [m/s], ``(n,)``."""
        return np.broadcast_to(np.asarray(self.vehicle.velocity), self.times.shape)

    @property
    def flight_path_angle(self) -> FloatArray:
        """Nominal flight path angle at the times [rad], ``(n,)``: equal to the attitude."""
        return np.broadcast_to(np.asarray(self.vehicle.attitude), self.times.shape)

    @property
    def span(self) -> tuple[float, float]:
        """The first and the last time [s]."""
        return float(self.times[0]), float(self.times[-1])

    def at(self, time: ArrayLike) -> Vehicle:
        """Return the vehicle at a time [s] with its structure, or a batch of them at several.

        `InputError` for times outside the schedule.
        """
        times = errors.finite("time", time, "s")
        first, last = self.span
        if np.any((times < first) | (times > last)):
            ends = dict.fromkeys((f"{times.min():.6g}", f"{times.max():.6g}"))
            raise errors.InputError(
                f"time must be between {first:.6g} and {last:.6g} s, the span of the schedule; got"
                f" {' to '.join(ends)} s"
            )
        return self.clamped_at(times)

    def clamped_at(self, time: ArrayLike, *, rigid: bool = False) -> Vehicle:
        """Return the vehicle at any time [s], constant outside the schedule.

        `rigid`: whether its structure is left out, whose interpolation takes most of the time.
        """
        times = errors.finite("time", time, "s")
        numbers = {
            name: np.interp(times, self.times, values) if np.ndim(values) else values
            for name, values in _numbers(self.vehicle).items()
        }
        if errors.flag("rigid", rigid):
            numbers["structure"] = None
        elif self.structure is not None:
            numbers["structure"] = self.structure.at(times)
        return self.vehicle.replace(**numbers, time=times)

    def plants(self, time: ArrayLike, model: str, plane: str) -> Plant:
        """Return the plants at any times [s], a batch of their shape.

        `model`: name of the model, such as "drift-exact". `plane`: pitch or yaw. B, the ratio of
        trim deflection to angle of attack, is at least `_MIN_B` in size, as the path requires 1/B:
        where the air has a smaller moment, its arm is made longer, and a normal force of nearly
        zero larger.
        """
        v = self.clamped_at(time, rigid=True)
        # B = N l_a/(T l_c): normal force slope and aerodynamic arm, control force and control arm
        smallest = _MIN_B * np.asarray(v.control_force)
        force = np.maximum(v.normal_force_slope, smallest)
        arm = np.asarray(v.aerodynamic_arm)
        weak = np.abs(v.normal_force_slope * arm) < smallest * np.abs(v.control_arm)
        if np.any(weak):
            longer = np.copysign(smallest * np.abs(v.control_arm) / force, arm)
            arm, force = np.where(weak, longer, arm), np.where(weak, force, v.normal_force_slope)
            v = v.replace(aerodynamic_arm=arm, normal_force_slope=force)
        return Plant.from_vehicle(v, model, plane)

    @property
    def one_sign_intervals(self) -> tuple[FlightSchedule, ...]:
        """Intervals of the flight, in each of which the aerodynamic arm has one sign.

        The arm [m], of the normal force about the centre of gravity, is linear between the times;
        times at which it is zero within rounding do not count.
        """
        arm = np.broadcast_to(np.asarray(self.vehicle.aerodynamic_arm), self.times.shape)
        times, signed = self.times, np.flatnonzero(np.abs(arm) > _ARM_ROUNDING * np.abs(arm).max())
        # rows after which the arm has the other sign
        at = signed[:-1][arm[signed[:-1]] * arm[signed[1:]] < 0.0]
        zeros = times[at] + arm[at] / (arm[at] - arm[at + 1]) * (times[at + 1] - times[at])
        ends = [None, *zeros.tolist(), None]
        return tuple(self.between(*pair) for pair in pairwise(ends)) if zeros.size else (self,)

    def between(self, start: float | None = None, stop: float | None = None) -> FlightSchedule:
        """Return the flight from the time `start` to `stop` [s], by default its first and last.

        `InputError` for times outside the schedule, or not in order.
        """
        first, last = self.span
        low, high = (
            end if time is None else errors.number(name, time, errors.between(first, last), "s")
            for name, time, end in (("start", start, first), ("stop", stop, last))
        )
        if not low < high:
            raise errors.InputError(f"start must lie before stop; got {low:.6g} and {high:.6g} s")
        times = np.concatenate(
            [[low], self.times[(self.times > low) & (self.times < high)], [high]]
        )
        altitude = None if self.altitude is None else np.interp(times, self.times, self.height)
        frequency, damping = self.actuator_at(times) or (None, None)
        return replace(
            self,
            # the structure of a schedule stays beside its vehicle
            vehicle=replace(self, structure=None).clamped_at(times),
            nominal_deflection=self.nominal_at(times),
            altitude=altitude,
            actuator_frequency=frequency,
            actuator_damping=damping,
        )

    def nominal_at(self, time: ArrayLike) -> Any:
        """Return the nominal deflection [rad] at any times [s], constant outside the schedule."""
        values = np.broadcast_to(np.asarray(self.nominal_deflection), self.times.shape)
        return np.interp(errors.finite("time", time, "s"), self.times, values)

    def actuator_at(self, time: ArrayLike) -> tuple[FloatArray, FloatArray] | None:
        """Return natural frequency [rad/s] and damping ratio of the actuator at any times [s].

        None for a flight without an actuator; constant outside the schedule.
        """
        if self.actuator_frequency is None or self.actuator_damping is None:
            return None
        at = errors.finite("time", time, "s")
        frequency, damping = (
            np.interp(at, self.times, np.broadcast_to(values, self.times.shape))
            for values in (self.actuator_frequency, self.actuator_damping)
        )
        return np.asarray(frequency), np.asarray(damping)

    def altitude_text(self, time: float) -> str:
        """Return the altitude at a time [s] in words, or the time alone where it is not known."""
        if self.altitude is None:
            return f"the height at {time:.4g} s"
        height = float(np.interp(time, self.times, self.height))
        return f"{height / 1e3:.1f} km ({time:.4g} s)"

    def to_csv(self, path: str | PathLike[str]) -> None:
        """Write the schedule as `load_schedule` reads it, its notes as comments above.

        The structure is another table, and not written.

        Parameters
        ----------
        path : str or path
            The file; its name must end in .csv.

        Raises
        ------
        InputError
            For another ending, and a file that cannot be written.
        """
        target = errors.path("path", path)
        if target.suffix.lower() != ".csv":
            raise errors.InputError(
                f"path must end in .csv, by which a schedule is known; got {called(target)}"
            )
        numbers = {"time": self.times} | _numbers(self.vehicle)
        if not np.any(self.vehicle.pitch_damping):
            del numbers["pitch_damping"]
        columns = VEHICLE_TABLE.write(numbers)
        columns["attitude_deg"] = np.degrees(columns.pop("attitude_rad"))
        if np.any(self.nominal_deflection):
            columns["nominal_deflection_deg"] = np.degrees(self.nominal_deflection)
        if self.altitude is not None:
            columns["altitude_m"] = np.asarray(self.altitude)
        if self.actuator_frequency is not None and self.actuator_damping is not None:
            columns["actuator_frequency_rad_per_s"] = np.asarray(self.actuator_frequency)
            columns["actuator_damping"] = np.asarray(self.actuator_damping)
        rows = np.column_stack([np.broadcast_to(c, self.times.shape) for c in columns.values()])
        lines = [f"# {note}".replace('"', "'") for note in self.notes]
        lines += [",".join(columns), *(",".join(f"{x:.12g}" for x in row) for row in rows)]
        write_text(target, "\n".join(lines) + "\n")

    @classmethod
    def from_flight(
        cls,
        vehicle: Vehicle,
        condition: FlightCondition,
        *,
        start: float,
        stop: float,
        step: float = 0.5,
    ) -> FlightSchedule:
        """Return the schedule of the nominal flight through a vehicle's state.

        Parameters
        ----------
        vehicle : Vehicle
            One vehicle with its time.
        condition : FlightCondition
            Altitude and specific impulse; see `nominal_flight`.
        start, stop : float
            The span [s], around the vehicle's time.
        step : float
            Time between two rows [s]; what lies between them is read off straight lines.

        Raises
        ------
        InputError
            As `nominal_flight`, and for a step not positive.
        """
        flight = nominal_flight(vehicle, condition, start=start, stop=stop)
        width = errors.number("step", step, errors.positive, "s")
        reference = time_of(vehicle)
        if (flight.stop - flight.start) / width > _MAX_ROWS:
            raise errors.InputError(f"step must give at most {_MAX_ROWS} rows; got {width:.6g} s")
        before, after = (
            np.arange(reference, end, step)
            for end, step in ((flight.start, -width), (flight.stop, width))
        )
        times = np.unique(np.concatenate([[flight.start], before, after, [flight.stop]]))
        _speed, _path, altitude = flight.states(times)
        return cls(
            flight.vehicle_at(times), nominal_deflection=flight.deflection(times), altitude=altitude
        )


def vehicles_at(
    flights: Sequence[FlightSchedule],
    time: FloatArray,
    which: IndexArray | int = 0,
    pressure: FloatArray | float = 1.0,
) -> Vehicle:
    """Return vehicles with their structure at any times [s] of flights with equal times.

    They are constant outside the schedule. `time`: times, ``(...)``. `which`: index of the flight
    of each, ``(...)``. `pressure`: dynamic pressure over the nominal one, q/q_n, ``(...)``.
    """
    read = table_reader(flights[0].times, time, which)
    tables = [_numbers(flight.vehicle) for flight in flights]
    numbers = {name: read([table[name] for table in tables]) for name in tables[0]}
    # normal and axial force are in proportion to the dynamic pressure
    numbers |= {name: np.multiply(numbers[name], pressure) for name in AIR_FORCES}
    structures = [flight.structure for flight in flights if flight.structure is not None]
    if structures:
        numbers["structure"] = structures_at(structures, time, which)
    return flights[0].vehicle.replace(**numbers, time=time)


def _numbers(vehicle: Vehicle) -> dict[str, Any]:
    """Return the numbers of a vehicle by name, without its time."""
    numbers = {name: getattr(vehicle, name) for name in NUMBERS if name != "time"}
    return {name: value for name, value in numbers.items() if value is not None}


VARIABLES = ("time", "speed", "altitude", "mach", "dynamic_pressure")
"""Names of the variables."""


def flight_variable(flight: FlightSchedule, variable: str, time: ArrayLike) -> FloatArray:
    """Return a variable of the flight at times [s], of their shape, in SI units.

    Parameters
    ----------
    flight : FlightSchedule
        The flight; with its altitude for all variables but time and speed.
    variable : {"time", "speed", "altitude", "mach", "dynamic_pressure"}
        Time of flight [s], speed [m/s], altitude [m], Mach number, and dynamic pressure [Pa], the
        last two in the standard atmosphere without wind.
    time : array_like
        Times of flight [s].

    Raises
    ------
    InputError
        For another variable, times outside the flight, and a flight without altitude.

    Examples
    --------
    >>> import tvclin as tv
    >>> flight = tv.load_schedule("configuration-i")
    >>> tv.ascent.flight_variable(flight, "mach", [50.0, 66.0, 80.0]).round(2)
    array([1.32, 1.83, 2.33])
    """
    errors.instance("flight", flight, FlightSchedule, "see load_schedule")
    errors.one_of("variable", variable, VARIABLES)
    times = errors.within("time", errors.finite("time", time, "s"), *flight.span, "s")
    if variable == "time":
        return times
    speed = np.asarray(np.interp(times, flight.times, flight.speed))
    if variable == "speed":
        return speed
    altitude = np.asarray(np.interp(times, flight.times, flight.height))
    if variable == "altitude":
        return altitude
    air = standard_atmosphere(altitude)
    if variable == "mach":
        return np.asarray(speed / speed_of_sound(air))
    return np.asarray(0.5 * air.density * speed**2)
