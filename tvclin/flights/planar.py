"""Planar flights of the report's equations of motion (B1a) to (B1f), event-exact.

    m V'         = T cos(Theta - gamma + delta) - F_A cos(Theta - gamma)
                   - N alpha sin(Theta - gamma) - W sin gamma
    m V gamma'   = T sin(Theta - gamma + delta) - F_A sin(Theta - gamma)
                   + N alpha cos(Theta - gamma) - W cos gamma
    I Theta''    = N l_a alpha - T l_c sin delta - M_q Theta'

m mass, V speed, T thrust, F_A axial force, N slope of the normal force [N/rad], W weight, I moment
of inertia, l_a and l_c arms of the normal and of the control force, M_q pitch damping. If only some
engines turn, their thrust, the control force, replaces T in the terms of delta.

States are deviations from a nominal flight, so that zero is a solution. Parameters are frozen, as
in the linear theory, or vary along the nominal flight. In the yaw plane the component of gravity
across the path is of a turned path, W sin(Theta_n) sin(sigma), and Theta, gamma are the yaw
angle and the heading of the path. The report has no damping M_q; it is constant, as the inertia
is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.nominal_flight import FlightCondition, NominalFlight, nominal_flight, time_of
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, ending, flag, instance, one_of, single, times_row
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law
from tvclin.control.laws.trim import TrimLaw
from tvclin.flights.closed_loop.checks import check_span
from tvclin.flights.closed_loop.continuous import Arc, ContinuousFlight, Loop, smooth_piece
from tvclin.flights.engine_interface import (
    MAX_ATTITUDE,
    ONSET_OVER_LIMIT,
    OUTPUTS,
    Command,
    Control,
    ReportControl,
    check_history,
    check_path,
    command_of,
    limit_of,
    warn_of_the_end,
)
from tvclin.linear.lateral import NO_LATERAL_SENSORS, LateralSensors
from tvclin.linear.plant import Plant
from tvclin.linear.response import time_response
from tvclin.vehicle.coefficients import PLANES
from tvclin.vehicle.vehicle import STANDARD_GRAVITY, Vehicle
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from control import TimeResponseData


STATES = ("attitude", "attitude_rate", "flight_path_angle", "relative_speed", "altitude")


@dataclass(frozen=True, eq=False)
class PlanarMotion:
    """Equations of motion of one vehicle in one plane.

    `vehicle`: one vehicle. `plane`: "pitch" or "yaw". `drift`: whether the path turns and the speed
    changes; without it only the attitude does. `nominal`: nominal flight along which all parameters
    vary; without it they are frozen, and the wind angle does not depend on the motion. `sensors`:
    lateral sensors of the law, whose states are the last. `InputError` for drift that is measured
    on a path that does not turn.
    """

    vehicle: Vehicle
    plane: str = "pitch"
    drift: bool = True
    nominal: NominalFlight | None = None
    sensors: LateralSensors = NO_LATERAL_SENSORS

    def __post_init__(self) -> None:
        """Raise `InputError` for an unknown plane, a batch, and drift on a path that is fixed."""
        one_of("plane", self.plane, PLANES)
        check_path(self.drift, self.sensors)
        single("vehicle", self.vehicle.replace(time=None).batch)

    @cached_property
    def states(self) -> tuple[str, ...]:
        """Names of the states: of the vehicle, the altitude if it varies, and of the sensors."""
        return (*STATES[: 4 if self.nominal is None else 5], *self.sensors.states)

    @property
    def scales(self) -> FloatArray:
        """Scales of the states, ``(n,)``: the speed [m/s] from the altitude on, else 1."""
        scales = np.ones(len(self.states))
        scales[4:] = self.vehicle.velocity
        return scales

    def rates(self, t: float, x: FloatArray, deflection: float, gust: float) -> FloatArray:
        """Return the derivatives of the states `x` at a time `t` [s], ``(n,)``.

        The states are deviations from the nominal flight: attitude [rad], its rate [rad/s], flight
        path angle [rad], relative speed, altitude [m] and the sensors' states. `deflection`:
        deflection minus the nominal one [rad]. `gust`: wind angle of attack [rad] relative to the
        nominal flight. Forces of the air are the vehicle's times `ratio`, the dynamic pressure over
        the nominal one.
        """
        now = self._nominal_state(t)
        theta, theta_rate, gamma, relative_speed, *_ = x
        alpha, speed = self._air(now, x, gust)
        ratio = self._ratio(speed, now.altitude + x[4]) if self.nominal is not None else 1.0
        v = self.vehicle
        moment = v.normal_force_slope * ratio * v.aerodynamic_arm * alpha
        moment -= v.control_force * v.control_arm * np.sin(deflection)
        moment -= v.pitch_damping * theta_rate
        derivatives = np.zeros(len(self.states))
        derivatives[0], derivatives[1] = theta_rate, moment / v.moment_of_inertia
        ground_speed = now.speed * (1.0 + relative_speed)  # [m/s]
        if self.drift:
            # gamma' [rad/s] and V' [m/s^2], of this and of the nominal flight
            path_rate, acceleration = self._path(
                now, theta, gamma, ground_speed, alpha, ratio, deflection
            )
            nominal_ratio = self._ratio(now.speed, now.altitude)
            nominal_path_rate, nominal_acceleration = self._path(
                now, 0.0, 0.0, now.speed, 0.0, nominal_ratio, 0.0
            )
            derivatives[2] = path_rate - nominal_path_rate
            # V = V_n (1 + x), so that V' - V_n' = V_n x' + V_n' x, V_n' being 0 if frozen
            from_nominal = 0.0 if self.nominal is None else nominal_acceleration * relative_speed
            derivatives[3] = (acceleration - nominal_acceleration - from_nominal) / now.speed
        if self.nominal is not None and self.plane == "pitch":
            climb = ground_speed * np.sin(now.path + gamma)
            derivatives[4] = climb - now.speed * np.sin(now.path) if self.drift else 0.0
        if self.sensors.drift:
            derivatives[self.states.index("drift")] = self._drift_rate(now, x)
        if self.sensors.acceleration:
            k = self.states.index("acceleration")  # a first-order lag of what the sensor feels
            normal = v.normal_force_slope * ratio * alpha + v.control_force * np.sin(deflection)
            felt = normal / now.mass + self.sensors.station * derivatives[1]
            derivatives[k] = self.sensors.bandwidth * (felt - x[k])
        return derivatives

    def lateral(self, t: Any, x: FloatArray) -> dict[str, Any]:
        """Return the measurements of the lateral sensors, by name; empty without any.

        Drift [m] and acceleration [m/s^2] are states, the drift rate [m/s] follows from them. `t`:
        times [s]. `x`: states, ``(n, ...)``.
        """
        states = dict(zip(self.states, x, strict=True))
        lateral = {name: states[name] for name in self.sensors.states}
        if self.sensors.drift_rate:
            lateral["drift_rate"] = self._drift_rate(self._nominal_state(t), x)
        return lateral

    def _drift_rate(self, now: _Nominal, x: Any) -> Any:
        """Return the velocity normal to the nominal path [m/s].

        `now`: the nominal flight. `x`: deviations from it, ``(states, ...)``: the third is the
        flight path angle [rad], the fourth the speed, relative to the nominal one.
        """
        return now.speed * (1.0 + x[3]) * np.sin(x[2])

    def angle_of_attack(self, t: Any, x: FloatArray, gust: Any) -> Any:
        """Return the angle of attack [rad] at times `t` [s].

        `x`: states, ``(states, ...)``. `gust`: wind angle of attack [rad] on the nominal path.
        """
        alpha, _ = self._air(self._nominal_state(t), x, gust)  # with the air speed
        return alpha

    def _air(self, now: _Nominal, x: Any, gust: Any) -> tuple[Any, Any]:
        """Return the angle of attack [rad] and the air speed [m/s].

        With frozen parameters it is attitude minus path minus wind. Else the wind angle is made a
        horizontal wind [m/s], in pitch along the flight and in yaw to its side, and added to the
        velocity. `now`: the nominal flight. `x`: deviations from it, ``(states, ...)``: attitude,
        its rate, flight path angle [rad], relative speed. `gust`: wind angle of attack [rad] on the
        nominal path.
        """
        if self.nominal is None:
            return x[0] - x[2] - gust, now.speed
        speed = now.speed * (1.0 + x[3])
        if self.plane == "pitch":
            path = now.path + x[2]
            # law of sines in the wind triangle of the nominal flight
            wind = now.speed * np.sin(gust) / np.sin(now.path + gust)
            along, across = speed * np.cos(path) - wind, speed * np.sin(path)
            path_angle = np.arctan2(across, along) - now.path
        else:
            wind = now.speed * np.tan(gust)
            along, across = speed * np.cos(x[2]), speed * np.sin(x[2]) + wind
            path_angle = np.arctan2(across, along)
        return x[0] - path_angle, np.hypot(along, across)

    def _path(
        self,
        now: _Nominal,
        theta: Any,
        gamma: Any,
        speed: Any,
        alpha: Any,
        ratio: Any,
        delta: Any,
    ) -> tuple[Any, Any]:
        """Return the rates of flight path angle [rad/s] and speed [m/s^2], nominal rates included.

        Forces are summed across the path and along it. Only the control force, a part of the
        thrust, turns with the nozzle. `now`: the nominal flight. `theta`, `gamma`: deviations of
        attitude and flight path from it [rad]. `speed`: [m/s]. `alpha`: angle of attack [rad].
        `ratio`: dynamic pressure over the nominal one. `delta`: deflection [rad].
        """
        v, lean = self.vehicle, theta - gamma
        weight = now.mass * STANDARD_GRAVITY
        normal, axial = v.normal_force_slope * ratio * alpha, v.axial_force * ratio
        lateral = v.control_force * np.sin(delta)
        axial_thrust = v.thrust - v.control_force * (1.0 - np.cos(delta))
        across = (axial_thrust - axial) * np.sin(lean) + (lateral + normal) * np.cos(lean)
        along = (axial_thrust - axial) * np.cos(lean) - (lateral + normal) * np.sin(lean)
        if self.plane == "pitch":
            across = across - weight * np.cos(now.path + gamma)
            along = along - weight * np.sin(now.path + gamma)
        else:  # in yaw the weight has only its component against the nominal path
            across = across + weight * np.sin(now.path) * np.sin(gamma)
            along = along - weight * np.sin(now.path) * np.cos(gamma)
        return across / (now.mass * speed), along / now.mass

    def _ratio(self, speed: Any, altitude: Any) -> Any:
        """Return the dynamic pressure q/q_n, over the nominal one of the vehicle's coefficients.

        `speed`: air speed [m/s]. `altitude`: altitude [m].
        """
        return 1.0 if self.nominal is None else self.nominal.pressure_ratio(speed, altitude)

    def _nominal_state(self, t: Any) -> _Nominal:
        """Return the nominal flight at a time `t` [s], or the vehicle's state if it is frozen.

        The nominal path angle is the nominal attitude: the nominal flight has no angle of attack.
        """
        v = self.vehicle
        if self.nominal is None:  # the altitude matters only where parameters vary
            return _Nominal(mass=v.mass, speed=v.velocity, path=v.attitude, altitude=0.0)
        # a solver evaluates one time more than once: `_latest` stores the last state
        return _nominal_at(self.nominal, t) if np.ndim(t) else _latest(self.nominal, float(t))


@dataclass(frozen=True, eq=False)
class _Nominal:
    """The nominal flight at a time: mass [kg], speed [m/s], path angle [rad] and altitude [m]."""

    mass: Any
    speed: Any
    path: Any
    altitude: Any


def _nominal_at(nominal: NominalFlight, t: Any) -> _Nominal:
    """Return mass, speed, path angle and altitude of the nominal flight at times `t` [s]."""
    return _Nominal(nominal.mass(t), *nominal.states_within(t))


_latest = lru_cache(maxsize=1)(_nominal_at)
"""Nominal flight at one time [s], cached: a law and the equations of motion call it in turn."""


_RTOL, _ATOL = 1e-9, 1e-12
"""Relative and absolute tolerance of a solver step of a flight without a law; angles are some
hundredths of a rad."""
_END_MARGIN = 1e-6
"""Distance beyond the largest attitude at which a flight ends, over that attitude."""


@dataclass(frozen=True, eq=False)
class Solution:
    """Solution of a flight.

    `rows`: function from times [s] ``(m,)`` to states and deflection, ``(states + 1, m)``; NaN
    after the end. `end`: time [s] at which the attitude leaves the range of the model; infinite if
    it does not.
    """

    rows: Callable[[FloatArray], FloatArray]
    end: float


@dataclass(frozen=True, eq=False)
class PlanarCase:
    """Equations, wind and time span of a flight, checked; made by `planar_case`.

    `motion`: equations of motion. `wind`: one wind that ends. `span`: start and end of the flight
    [s].
    """

    motion: PlanarMotion
    wind: History
    span: tuple[float, float]

    def flown(self, command: Command, limit: float) -> Solution:
        """Return the flight of a nozzle command from equilibrium, within a deflection limit [rad].

        The command is a history of the deflection, or a law, which flies in a closed loop with
        actuator and rate limit [rad/s]. `InputError` for noise, and a rate limit without actuator.
        """
        control, actuator, rate_limit = command.control, command.actuator, command.rate_limit
        if isinstance(control, History):
            return self._by_history(control, limit)
        if isinstance(control, ReportControl):
            design = Plant.from_vehicle(self.motion.vehicle, "fixed-path", self.motion.plane)
            control = _TrimThenHold(design, dead_band=control.dead_band)
        law: Law = control
        noise, _seed = law.rate_noise  # of the measured attitude rate [rad/s rms]
        if noise:
            raise InputError("noise belongs to samples, and this flight has none; leave it out")
        if rate_limit < np.inf and actuator is None:
            raise InputError("a rate_limit needs an actuator")
        motion = replace(self.motion, sensors=law.lateral_sensors)
        loop = Loop(motion, law, limit=limit, rate_limit=rate_limit, actuator=actuator)
        flight = ContinuousFlight(loop, self.wind, MAX_ATTITUDE)
        arcs = flight.arcs(*self.span)  # solutions between events
        return self._ended(arcs, lambda times: flight.rows(arcs, times))

    def _by_history(self, control: History, limit: float) -> Solution:
        """Return the flight with a deflection history `control` [rad] within a limit [rad].

        It is solved from breakpoint to breakpoint of history and wind, up to the end of the span or
        of the model's range.
        """
        from scipy.integrate import solve_ivp

        start, stop = self.span
        knots = np.concatenate([self.wind.knots, control.knots])
        inside = knots[(knots > start) & (knots < stop)]
        state, arcs = np.zeros(len(self.motion.states)), []
        # a span of zero length is flown for 1 ns, to have an arc
        for first, last in pairwise(np.unique([start, *inside, max(stop, start + 1e-9)])):
            inputs = smooth_piece(control, float(first)), smooth_piece(self.wind, float(first))
            result = solve_ivp(
                self._rates,  # derivatives of the states
                (first, last),
                state,
                method="DOP853",
                rtol=_RTOL,
                atol=_ATOL,
                dense_output=True,
                events=_attitude_end,
                args=(limit, *inputs),
            )
            arcs.append(Arc(float(first), result.sol, mode=0.0))  # no law that changes its mode
            state = result.y[:, -1]  # at the end of the arc
            if result.status:  # the attitude has left the range of the model
                break
        starts = np.array([arc.start for arc in arcs])

        def rows(times: FloatArray) -> FloatArray:
            """Return states and deflection at m times [s], ``(states + 1, m)``."""
            index = np.clip(np.searchsorted(starts, times, side="right") - 1, 0, None)
            states = np.stack([arcs[k].solution(t) for k, t in zip(index, times, strict=True)], -1)
            return np.vstack([states, np.clip(control(times), -limit, limit)])

        return self._ended(arcs, rows)

    def _rates(
        self, t: float, x: FloatArray, limit: float, deflection: Any, gust: Any
    ) -> FloatArray:
        """Return the derivatives of the states `x` at a time `t` [s], ``(states,)``.

        `limit`: deflection limit [rad]. `deflection`, `gust`: deflection before the limit, and wind
        angle [rad], as functions of the time.
        """
        return self.motion.rates(t, x, min(max(float(deflection(t)), -limit), limit), gust(t))

    def _ended(self, arcs: list[Arc], rows: Callable[[FloatArray], FloatArray]) -> Solution:
        """Return a solution with NaN after the end of the last of its arcs.

        If that is the end of the time span, the solution has no end. `rows`: function from times
        [s] to states and deflection.
        """
        solution: Any = arcs[-1].solution
        last = float(solution.t_max)
        if last >= self.span[1]:
            return Solution(rows, np.inf)
        return Solution(lambda times: np.where(times > last, np.nan, rows(times)), last)


def planar_case(
    vehicle: Vehicle,
    wind: History,
    span: tuple[float, float],
    *,
    plane: str,
    drift: bool,
    condition: FlightCondition | None,
) -> PlanarCase:
    """Return the case of a vehicle in a wind over a time span [s], start and end.

    The nominal flight passes through the vehicle's state at the vehicle's own time, so that it
    covers that time too. `drift`: whether the flight path may turn and the speed change.
    `condition`: with it, parameters vary along the nominal flight. Exceptions as `fly_planar`.
    """
    instance("vehicle", vehicle, Vehicle, "see load_vehicle")
    check_span(*span)
    check_history("wind", wind, span[0])
    ending("wind", wind.end)
    nominal = None
    if condition is not None:
        # 1 ms more: the last time is within the nominal flight in spite of rounding
        reference = time_of(vehicle)
        first, last = min(span[0], reference), max(span[1], reference) + 1e-3
        nominal = nominal_flight(vehicle, condition, start=first, stop=last)
    motion = PlanarMotion(vehicle, plane=plane, drift=flag("drift", drift), nominal=nominal)
    return PlanarCase(motion, wind, span)


@dataclass(frozen=True)
class _TrimThenHold(TrimLaw):
    """The report's control: trim until K times the limit, then the limit for ever.

    `release` is minus infinity: no demand ends the full limit. `engage` is the dead band K.
    """

    dead_band: float = 1.0
    release = -np.inf

    @property
    def engage(self) -> float:  # type: ignore[override]
        """Demanded deflection over the limit from which on the limit is held: the dead band K.

        With K = 0, where any demand holds it, a tiny number above rounding.
        """
        return max(self.dead_band, ONSET_OVER_LIMIT)


def _attitude_end(t: float, x: FloatArray, *inputs: Any) -> float:
    """Return the distance [rad] of the attitude to the end of the model's range, negative beyond.

    It is the event function of `solve_ivp`. `x`: states, the attitude first. Time and inputs do not
    matter.
    """
    return MAX_ATTITUDE * (1.0 + _END_MARGIN) - abs(float(x[0]))


_attitude_end.terminal = True  # type: ignore[attr-defined]


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
    times, outputs = planar_outputs(
        vehicle,
        control,
        wind,
        timepts,
        deflection_limit=deflection_limit,
        plane=plane,
        drift=drift,
        condition=condition,
        actuator=actuator,
        rate_limit=rate_limit,
    )
    title = f"Planar flight, {vehicle.name or 'vehicle'}, {plane}"
    return time_response(times, outputs, OUTPUTS, name="planar", title=title, wind=wind)


def planar_outputs(
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
) -> tuple[FloatArray, FloatArray]:
    """Return n times [s] and the `OUTPUTS` of a flight at them, ``(5, n)``, without python-control.

    Same parameters, exceptions and warnings as `fly_planar`.
    """
    times = times_row("timepts", timepts)
    span = (float(times.min()), float(times.max()))
    case = planar_case(vehicle, wind, span, plane=plane, drift=drift, condition=condition)
    command = command_of(control, span[0], actuator, rate_limit)
    flown = case.flown(command, limit_of(control, deflection_limit))
    if np.isfinite(flown.end):
        warn_of_the_end(flown.end)
    rows = flown.rows(times)  # states, of which attitude, its rate and path come first; deflection
    alpha = case.motion.angle_of_attack(times, rows[:-1], wind(times))
    return times, np.vstack([rows[:3], alpha, rows[-1]])
