"""The nominal flight: a gravity turn at zero angle of attack through a vehicle's state.

    V' = (T - F_A)/m - g sin gamma,   gamma' = -g cos(gamma)/V,   h' = V sin gamma

Thrust, inertia and damping are constant, the mass falls with the specific impulse, and F_A and N
are proportional to the dynamic pressure. The report gives none of these histories (nor tables
against Mach, nor an altitude): flights on this trajectory are reconstructed, not flown in 1968.
`FlightCondition` gives altitude and specific impulse.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.atmosphere import HIGHEST, LOWEST, air_at, density_at, standard_atmosphere
from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.fields import checked, file_table, quantity
from tvclin.base.files import called
from tvclin.numerics.chebyshev import initial_value_solution
from tvclin.vehicle.vehicle import STANDARD_GRAVITY, Vehicle
from tvclin.vehicle.vehicle_file import is_schedule, read_vehicle_text, table_of


@dataclass(frozen=True, kw_only=True)
class FlightCondition:
    """Altitude of a vehicle at its time, and the specific impulse by which its mass falls.

    Parameters
    ----------
    altitude : float
        Altitude [m] at the vehicle's time, from -5 to 86 km.
    specific_impulse : float
        Of the thrust [s], positive: it says how fast the mass falls.
    reference_area : float, optional
        S [m^2] of the aerodynamic coefficients, which no flight needs.
    table_scale : float
        A common factor on W, I, N, T and F_A. No flight depends on it; coefficients and forces do.

    Raises
    ------
    InputError
        For numbers out of range.
    """

    altitude: float = quantity("altitude", check=errors.between(LOWEST, HIGHEST))
    specific_impulse: float = quantity("time", check=errors.positive)
    reference_area: float | None = quantity("area", None, errors.positive)
    table_scale: float = quantity("number", 1.0, errors.positive)

    def __post_init__(self) -> None:
        """Check the fields; `InputError` for numbers out of range."""
        checked(self)

    @cached_property
    def density(self) -> float:
        """Density of the air [kg/m^3]."""
        return float(standard_atmosphere(self.altitude).density)

    def dynamic_pressure(self, vehicle: Vehicle) -> float:
        """Return the dynamic pressure rho V_n^2/2 [Pa] of a vehicle with the velocity V_n."""
        return 0.5 * self.density * float(np.asarray(vehicle.velocity)) ** 2

    def scaled(self, vehicle: Vehicle) -> Vehicle:
        """Return the vehicle with weight, inertia and all forces times the factor `table_scale`.

        No flight depends on this common factor, with which a table of the vehicle may be printed.
        """
        names = ("weight", "moment_of_inertia", "normal_force_slope", "thrust", "axial_force")
        changes = {name: self.table_scale * getattr(vehicle, name) for name in names}
        if vehicle.control_force_slope is not None:
            changes["control_force_slope"] = self.table_scale * vehicle.control_force_slope
        return vehicle.replace(**changes)


FLIGHT_TABLE = file_table("[flight]", FlightCondition, required=("altitude", "specific_impulse"))


def load_flight_condition(source: str | PathLike[str]) -> FlightCondition:
    """Return the flight condition of a vehicle.

    `source`: name of a vehicle of the package, or path of a vehicle file. The condition stands in
    the file under its own heading, [flight]: altitude_m, specific_impulse_s, and perhaps
    reference_area_m2 and table_scale.

    Raises
    ------
    InputError
        As `load_vehicle`, and where the heading or a key is missing.

    Examples
    --------
    >>> from tvclin.ascent.nominal_flight import load_flight_condition
    >>> load_flight_condition("configuration-i").altitude
    11950.0
    """
    text, path = read_vehicle_text(source)
    scheduled = is_schedule(source)
    table = {} if scheduled else table_of(text, path, FLIGHT_TABLE)
    name = called(path)
    if not table:
        settings = " (--set flight.altitude_m M --set flight.specific_impulse_s S)"
        raise errors.InputError(
            f"{name} has no table [flight]; a flight needs altitude_m and specific_impulse_s in it"
            f"{'' if scheduled else settings}"
        )
    with errors.naming(name):
        return FlightCondition(**FLIGHT_TABLE.read(table))


_SHORTER_WIND = (
    "give a shorter span, of a shorter wind, or of a sounding a shorter window (--set"
    " sounding.window_s 20, in a file window_s in [sounding])"
)
"""What to change where a flight does not last as long as the wind."""
_STEEP = np.radians(89.9)
"""The path at which a nominal flight ends: straight up or down it has no plane."""


@dataclass(frozen=True, eq=False)
class NominalFlight:
    """The nominal flight over a span of time [s]; make it with `nominal_flight`.

    `vehicle`: at its own time. `condition`: altitude and specific impulse. `start`, `stop`: the
    span.
    """

    vehicle: Vehicle
    condition: FlightCondition
    start: float
    stop: float

    def states(self, t: ArrayLike) -> FloatArray:
        """Return velocity [m/s], flight path angle [rad] and altitude [m], ``(3,) + t.shape``.

        `t`: times of flight [s]; `InputError` for times outside the span.
        """
        times = errors.finite("t", t, "s")
        slack = 1e-9 * (self.stop - self.start)  # rounding of times at the ends
        if np.any((times < self.start - slack) | (times > self.stop + slack)):
            raise errors.InputError(
                f"t must be between {self.start:.6g} and {self.stop:.6g} s, the span of the"
                f" nominal flight; got {float(times.min()):.6g} to {float(times.max()):.6g} s"
            )
        flat = np.clip(times.ravel(), self.start, self.stop)
        return self.states_within(flat).reshape(3, *times.shape)

    @cached_property
    def time(self) -> FloatArray:
        """Times [s] over the span, at most a tenth of a second apart, shape ``(n,)``."""
        return np.linspace(self.start, self.stop, int(10.0 * (self.stop - self.start)) + 2)

    @cached_property
    def speed(self) -> FloatArray:
        """Velocity [m/s] at `time`."""
        speed, _, _ = self.states(self.time)
        return np.asarray(speed)

    @cached_property
    def flight_path_angle(self) -> FloatArray:
        """Flight path angle [rad] at `time`."""
        _, path, _ = self.states(self.time)
        return np.asarray(path)

    @cached_property
    def height(self) -> FloatArray:
        """Altitude [m] at `time`."""
        _, _, altitude = self.states(self.time)
        return np.asarray(altitude)

    def states_within(self, t: Any) -> FloatArray:
        """Return `states` at a time `t` [s], ``(3,)``, or at times ``(n,)``, ``(3, n)``.

        They are velocity [m/s], flight path angle [rad], altitude [m]. Times are not checked.
        """
        early, late = self._solutions
        if np.ndim(t) == 0:
            return np.asarray(early(t) if t < self._time else late(t))
        return np.where(t < self._time, early(t), late(t))

    def mass(self, t: ArrayLike) -> Any:
        """Return the mass [kg] at times of flight `t` [s], in their shape."""
        flow = self.vehicle.thrust / (STANDARD_GRAVITY * self.condition.specific_impulse)
        return self.vehicle.mass - flow * (np.asarray(t, dtype=float) - self._time)

    def pressure_ratio(self, speed: Any, altitude: Any) -> Any:
        """Return the dynamic pressure at a speed [m/s] and an altitude [m] over the vehicle's own.

        `speed`: relative to the air; both may be arrays of one shape.
        """
        density = density_at(altitude) if np.ndim(altitude) == 0 else air_at(altitude).density
        return density / self.condition.density * (speed / self.vehicle.velocity) ** 2

    def dynamic_pressure(self, t: ArrayLike) -> FloatArray:
        """Return the dynamic pressure [Pa] at times of flight `t` [s], in their shape."""
        speed, _, altitude = self.states(t)
        ratio = self.pressure_ratio(speed, altitude)
        return np.asarray(ratio * self.condition.dynamic_pressure(self.vehicle))

    def deflection(self, t: ArrayLike) -> FloatArray:
        """Return the nominal deflection [rad] at times of flight `t` [s], eq (B2c) of the report.

            delta_n = -(I Theta_n'' + M_q Theta_n')/(T l_c)

        Theta_n is the attitude of the nominal flight, its path angle; I the moment of inertia, T
        l_c the control force per deflection times the control arm. The report has no damping M_q;
        the nose comes down in a gravity turn, which it resists.
        """
        speed, path, _ = states = self.states(t)
        speed_rate, path_rate, _ = self.rates(t, states)
        # the derivative of gamma' = -g cos(gamma)/V
        path_acceleration = STANDARD_GRAVITY * (
            np.sin(path) * path_rate / speed + np.cos(path) * speed_rate / speed**2
        )
        v = self.vehicle
        moment = v.moment_of_inertia * path_acceleration + v.pitch_damping * path_rate
        return np.asarray(-moment / (v.control_force * v.control_arm))

    def vehicle_at(self, t: ArrayLike) -> Vehicle:
        """Return the vehicle at times `t` [s], a batch of their shape.

        Lift slope and axial force are proportional to the dynamic pressure, with the coefficients
        of `vehicle`. The attitude is the path: there is no angle of attack.
        """
        speed, path, altitude = self.states(t)
        ratio = self.pressure_ratio(speed, altitude)
        return self.vehicle.replace(
            weight=self.mass(t) * STANDARD_GRAVITY,
            normal_force_slope=self.vehicle.normal_force_slope * ratio,
            axial_force=self.vehicle.axial_force * ratio,
            velocity=speed,
            attitude=path,
            time=np.asarray(t, dtype=float),
        )

    def rates(self, t: Any, states: FloatArray) -> FloatArray:
        """Return the derivatives of velocity, flight path angle and altitude, in SI units.

        `t`: times of flight [s], ``(...)``. `states`: these three at the times, ``(3, ...)``.
        """
        speed, path, altitude = states
        drag = self.vehicle.axial_force * self.pressure_ratio(speed, altitude)
        push = (self.vehicle.thrust - drag) / self.mass(t)  # acceleration along the path
        return np.stack(
            [
                push - STANDARD_GRAVITY * np.sin(path),
                -STANDARD_GRAVITY * np.cos(path) / speed,
                speed * np.sin(path),
            ]
        )

    @property
    def _time(self) -> float:
        """Time of the vehicle [s]."""
        return time_of(self.vehicle)

    @cached_property
    def _solutions(self) -> tuple[Any, Any]:
        """Solutions of the flight before and after the time of the vehicle, for any time."""
        v = self.vehicle
        begin = np.array([v.velocity, v.attitude, self.condition.altitude], dtype=float)
        return self._integrated(begin, self.start), self._integrated(begin, self.stop)

    def _integrated(self, begin: FloatArray, end: float) -> Any:
        """Return the function from times [s] to `states`, from the vehicle's time to `end` [s].

        `begin`: state at the vehicle's time, ``(3,)``. `InputError` for a flight that leaves the
        atmosphere before the end.
        """
        if end == self._time:  # nothing to integrate: the state of the vehicle at any time
            return lambda t: begin if np.ndim(t) == 0 else np.outer(begin, np.ones(np.size(t)))
        solution = initial_value_solution(self.rates, begin, (self._time, end), _in_atmosphere)
        if (last := solution.ends[-1]) != end:  # time at which the integration stopped
            speed, _path, altitude = solution(last) if solution.values.size else begin
            raise errors.InputError(
                f"the nominal flight does not reach t = {end:.6g} s: at {last:.6g} s it is at"
                f" {altitude:.6g} m with {speed:.6g} m/s; {_SHORTER_WIND}"
            )
        return solution


def _in_atmosphere(states: FloatArray) -> bool:
    """Return whether states, ``(3, ...)``, all move within the atmosphere, not straight up or down.

    They are velocity [m/s], flight path angle [rad] and altitude [m]. Below 1 m/s the path angle,
    whose rate is -g cos(gamma)/V, is not followed.
    """
    speed, path, altitude = states
    inside = (altitude > LOWEST) & (altitude < HIGHEST)
    return bool(np.all((speed > 1.0) & (np.abs(path) < _STEEP) & inside))


def nominal_flight(
    vehicle: Vehicle, condition: FlightCondition, *, start: float, stop: float
) -> NominalFlight:
    """Return the nominal flight through a vehicle's state, from `start` to `stop` [s].

    `vehicle`: one vehicle, with the time to which its numbers belong (zero where it has none).
    `condition`: altitude and specific impulse. `start`, `stop`: the span [s], around the vehicle's
    time. `InputError` for a batch, a span that does not hold the vehicle's time, and one in which
    the mass is used up or the flight leaves the atmosphere.

    Examples
    --------
    >>> import tvclin as tv
    >>> from tvclin.ascent.nominal_flight import load_flight_condition, nominal_flight
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> flight = nominal_flight(
    ...     vehicle, load_flight_condition("configuration-i"), start=62.0, stop=72.0
    ... )
    >>> bool(flight.states(66.0)[0] == vehicle.velocity)
    True
    """
    errors.instance("vehicle", vehicle, Vehicle, "see load_vehicle")
    errors.instance("condition", condition, FlightCondition, "see load_flight_condition")
    errors.single("vehicle", vehicle.batch)
    begin, end = (
        errors.number(name, value, errors.between(-errors.MAX_TIME, errors.MAX_TIME), "s")
        for name, value in (("start", start), ("stop", stop))
    )
    vehicle_time = time_of(vehicle)
    if not begin <= vehicle_time <= end or begin == end:
        raise errors.InputError(
            f"start and stop must lie around the vehicle's time, {vehicle_time:.6g} s; got"
            f" {begin:.6g} and {end:.6g} s"
        )
    return _integrated_once(vehicle, condition, begin, end)


@lru_cache(maxsize=8)
def _integrated_once(
    vehicle: Vehicle, condition: FlightCondition, begin: float, end: float
) -> NominalFlight:
    """Return the nominal flight of a vehicle in a span of time, cached: it is integrated once.

    `condition`: altitude and specific impulse. `begin`, `end`: the span [s]. `InputError` where the
    mass is used up, or the flight leaves the atmosphere.
    """
    flight = NominalFlight(vehicle, condition, start=begin, stop=end)
    if flight.mass(end) <= 0.0:
        raise errors.InputError(f"the mass is used up before t = {end:.6g} s; {_SHORTER_WIND}")
    _ = flight._solutions  # integrates, and stores the solutions in the flight
    return flight


def time_of(vehicle: Vehicle) -> float:
    """Return the flight time [s] of a single vehicle; zero where it has none."""
    return 0.0 if vehicle.time is None else float(np.asarray(vehicle.time))
