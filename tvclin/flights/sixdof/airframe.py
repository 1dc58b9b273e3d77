"""A JSBSim instance of one vehicle: its sensors, the wind that it is given, and its steps.

`Engine` is JSBSim without console output, with fixed integrators, and reproducible after every
reset.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from itertools import repeat
from math import asin, cos, hypot, sin
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, missing
from tvclin.base.units import FOOT
from tvclin.control.laws.law import Measurement
from tvclin.flights.engine_interface import MAX_ATTITUDE, OUTPUTS
from tvclin.flights.sixdof.model import DEFLECTIONS, Earth, InitialState, model_xml, planet_xml
from tvclin.flights.sixdof.steering import LateralMotion, Steering
from tvclin.linear.lateral import NO_LATERAL_SENSORS, LateralSensors
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle import Vehicle

_INTEGRATORS = {
    "rate/rotational": 3,
    "rate/translational": 3,
    "position/rotational": 4,
    "position/translational": 4,
}
"""Adams-Bashforth of second order for rates and of third order for positions."""


class Engine:
    """Instance of JSBSim with one model, in its initial state.

    Each `run` integrates the state with the previous forces, then evaluates the forces at the new
    time: inputs of the new time are set before the call.
    """

    def __init__(
        self,
        model: str,
        initial: Mapping[str, float],
        step: float,
        *,
        planet: str | None = None,
        drift: bool = True,
    ) -> None:
        """Load a model and its planet into JSBSim, and set its initial state.

        `model`, `planet`: XML; without a planet it is the rotating Earth, WGS84. `initial`:
        properties below ``ic/`` and their values. `step`: step [s]. `drift`: whether the velocity
        changes. `InputError` if JSBSim is not installed.
        """
        self._jsbsim = _loaded(model, planet)
        self._frozen = {"rate/translational": 0} if not drift else {}
        self._nodes = self._jsbsim.get_property_manager()
        self._jsbsim.set_dt(step)
        for name, value in initial.items():
            self._jsbsim[f"ic/{name}"] = value
        self._jsbsim.run_ic()
        self.run: Callable[[], bool] = self._jsbsim.run
        self.reset()

    def reset(self) -> None:
        """Restore the initial state with all inputs at zero, as in a new engine."""
        self._jsbsim.reset_to_initial_conditions(0)
        for name, number in {**_INTEGRATORS, **self._frozen}.items():
            self._jsbsim[f"simulation/integrator/{name}"] = number

    def reader(self, name: str) -> Callable[[], float]:
        """Return the function that reads the JSBSim property with a name."""
        return self._nodes.get_node(name).get_double_value

    def writer(self, name: str) -> Callable[[float], Any]:
        """Return the function that sets the JSBSim property with a name."""
        return self._nodes.get_node(name).set_double_value


def _loaded(model: str, planet: str | None) -> Any:
    """Return a JSBSim executive with a model and a planet loaded.

    `model`, `planet`: XML; without a planet it is the rotating Earth.
    """
    try:
        import jsbsim
    except ImportError:
        raise missing("flights with six degrees of freedom need JSBSim", "sixdof") from None
    base: Any = jsbsim.FGJSBBase
    base().debug_lvl = 0  # or it writes a page for every engine
    with TemporaryDirectory() as folder:
        aircraft = Path(folder) / "aircraft" / "vehicle"
        aircraft.mkdir(parents=True)
        (aircraft / "vehicle.xml").write_text(model)
        engine = jsbsim.FGFDMExec(folder)
        if planet is not None:
            (Path(folder) / "planet.xml").write_text(planet)
            engine.load_planet(str(Path(folder) / "planet.xml"), False)
        engine.load_model("vehicle")
    return engine


_TwoNumbers = Callable[[], tuple[float, float]]
_MIN_COMPONENT = 1e-12
"""Smallest component of the wind direction that is written to JSBSim."""


class MotionReaders(NamedTuple):
    """Functions that read the motion in one plane, without arguments.

    `angles`: attitude and flight path angle [rad]. `rates`: attitude rate [rad/s] and acceleration
    [rad/s^2]. `alpha`: angle of attack [rad]. `lateral`: speed over the ground [m/s], and force per
    mass normal to the body, without weight [m/s^2].
    """

    angles: _TwoNumbers
    rates: _TwoNumbers
    alpha: Callable[[], float]
    lateral: _TwoNumbers


def motion_readers(engine: Engine, plane: str, heading: float) -> MotionReaders:
    """Return the functions that read the motion in a plane; yaw angles are positive to the right.

    JSBSim works in feet and pounds, in body axes with z down and y to the right: a force upwards is
    minus its z. `engine`: JSBSim with the vehicle. `plane`: "pitch" or "yaw". `heading`: direction
    of the vertical plane of the nominal flight [rad], from north over east.
    """
    read = engine.reader
    axis = "q" if plane == "pitch" else "r"
    rate = read(f"velocities/{axis}-rad_sec")
    acceleration = read(f"accelerations/{axis}dot-rad_sec2")
    theta, mass = read("attitude/theta-rad"), read("inertia/mass-slugs")
    velocities = [read(f"velocities/v-{name}-fps") for name in ("north", "east", "down")]
    force = read(f"tvclin/without-weight-{'z' if plane == 'pitch' else 'y'}-lbs")
    # the force [lbf] times this is along the positive lateral axis, up or right, and over the mass
    # [slug] an acceleration in m/s^2 (lbf/slug is ft/s^2)
    metres_along_axis = -FOOT if plane == "pitch" else FOOT

    def rates() -> tuple[float, float]:
        """Return attitude rate [rad/s] and attitude acceleration [rad/s^2]."""
        return rate(), acceleration()

    def ground_speed() -> float:
        """Return the speed over the ground [ft/s]."""
        return hypot(*(component() for component in velocities))

    def lateral() -> tuple[float, float]:
        """Return the speed over the ground [m/s], and the force up or right per mass [m/s^2]."""
        return FOOT * ground_speed(), metres_along_axis * force() / mass()

    if plane == "pitch":
        gamma = read("flight-path/gamma-rad")
        return MotionReaders(lambda: (theta(), gamma()), rates, read("aero/alpha-rad"), lateral)
    psi, sideslip = read("attitude/psi-rad"), read("aero/beta-rad")
    (north, east, _), cosine, right = velocities, cos(heading), sin(heading)

    def angles() -> tuple[float, float]:
        """Return yaw angle and heading of the path [rad], from the vertical plane of the `heading`.

        `cosine` and `right`: components of the direction of that plane to north and to east.
        `theta`, `psi`: pitch angle and heading of the nose [rad]; `north`, `east`: velocities.
        """
        across = east() * cosine - north() * right
        return asin(cos(theta()) * sin(psi() - heading)), asin(across / ground_speed())

    return MotionReaders(angles, rates, lambda: -sideslip(), lateral)


def wind_setter(engine: Engine, plane: str, heading: float) -> Callable[[float], None]:
    """Return the function that sets a wind [m/s] along the flight (pitch) or to its right (yaw).

    A component of the wind that is zero but for rounding is not written, and stays exactly zero.
    `engine`: JSBSim with the vehicle. `plane`: "pitch" or "yaw". `heading`: direction of flight
    [rad], from north over east.
    """
    north, east = cos(heading), sin(heading)
    if plane == "yaw":
        north, east = -east, north
    components = [
        (engine.writer(f"atmosphere/wind-{name}-fps"), component / FOOT)
        for name, component in (("north", north), ("east", east))
        if abs(component) > _MIN_COMPONENT
    ]

    def set_wind(speed: float) -> None:
        """Set the components of the wind to the north and the east for its speed [m/s]."""
        for write, component in components:
            write(speed * component)

    return set_wind


Row = tuple[float, ...]
"""`OUTPUTS` at [0] to [4], from attitude to deflection; [5] force per mass normal to the body
[m/s^2], [6] acceleration of the attitude [rad/s^2]."""
_COLUMNS = len(OUTPUTS) + 2
_ACCELEROMETER = LateralSensors(acceleration=True)
"""Sensors with which the force of the nominal flight is recorded."""


class Prediction:
    """Prediction of the state in one plane at the end of the next step.

    JSBSim takes the inputs of the end of a step before the step, so the state at its end is
    predicted: the rate by the engine's integration rule, the angles to second order.
    """

    def __init__(
        self,
        readers: MotionReaders,
        step: float,
        sensors: LateralSensors,
        path_rotation: float = 0.0,
    ) -> None:
        """Read the state in a plane at the start of a flight.

        `readers`: functions that read the motion in the plane. `step`: step [s]. `sensors`: lateral
        sensors of the law. `path_rotation`: turn of the flight path [rad] in the step before the
        flight, for its angle at the begin of that step, `_path_before`.
        """
        self._readers, self._step = readers, step
        self._lateral = LateralMotion(sensors, step) if sensors.signals else None
        if self._lateral is not None:  # at the start: its speed, and no drift or force
            speed, *_ = readers.lateral()
            self._lateral.move(0.0, speed, 0.0, 0.0)
        self._attitude, self._path = readers.angles()
        self._rate, self._acceleration = readers.rates()
        self._path_before, self._acceleration_before = (
            self._path - path_rotation,
            self._acceleration,
        )
        self._alpha = self._wind_angle = self._deflection = 0.0

    def measurement(self, angle: float, nominal: Row) -> Measurement:
        """Return the predicted measurements of a law, minus the outputs of the nominal flight.

        `angle`: wind angle [rad] at the end of the step. `nominal`: outputs of the nominal flight
        there, a `Row`. The rate is by second-order Adams-Bashforth; attitude and path rotate
        on, and the angle of attack changes by the rotation of attitude, path and wind. `_path` and
        `_path_before` are the path angle now and a step before; `_lateral` adds drift and
        acceleration where the law measures them.
        """
        h, rate = self._step, self._rate
        next_rate = rate + h * (1.5 * self._acceleration - 0.5 * self._acceleration_before)
        rotation = 0.5 * h * (rate + next_rate)
        path_rotation = self._path - self._path_before
        alpha = self._alpha + rotation - path_rotation - (angle - self._wind_angle)
        nominal_attitude, nominal_rate, nominal_path, nominal_alpha, *_ = nominal
        plain = Measurement(
            attitude=self._attitude + rotation - nominal_attitude,
            attitude_rate=next_rate - nominal_rate,
            flight_path_angle=self._path + path_rotation - nominal_path,
            angle_of_attack=alpha - nominal_alpha,
            deflection=self._deflection,
        )
        return plain if self._lateral is None else self._lateral.measured(plain)

    def after_step(self, deflection: float, angle: float, nominal: Row) -> Row:
        """Return the outputs after a step, minus the nominal outputs, and update the state.

        `deflection`: deflection [rad], and `angle`: wind angle [rad] in the step. `nominal`:
        outputs of the nominal flight at its end, a `Row`: attitude, its rate, path angle, angle of
        attack, deflection, force per mass and attitude acceleration. The force is zero without
        lateral sensors.
        """
        self._acceleration_before, self._path_before = self._acceleration, self._path
        self._deflection, self._wind_angle = deflection, angle
        self._attitude, self._path = attitude, path = self._readers.angles()
        (self._rate, self._acceleration), self._alpha = self._readers.rates(), self._readers.alpha()
        attitude_n, rate_n, path_n, alpha_n, _, force_n, acceleration_n = nominal
        force, acceleration = 0.0, self._acceleration - acceleration_n
        if self._lateral is not None:
            speed, force = self._readers.lateral()
            force -= force_n
            self._lateral.move(path - path_n, speed, force, acceleration)
        angles = attitude - attitude_n, self._rate - rate_n, path - path_n, self._alpha - alpha_n
        return (*angles, deflection, force, acceleration)


Surroundings = Earth | InitialState | None

_HOLD_OVER_AIRFRAME_FREQUENCY = 4.0
"""Natural frequency of the nominal flight's attitude hold, relative to the airframe."""
_MIN_HOLD_FREQUENCY = 1.0
"""Smallest natural frequency of that hold [rad/s]."""


class Airframe:
    """JSBSim instance of one vehicle.

    With frozen parameters over a flat planet the nominal flight is straight and requires no
    control. Over the Earth, and from an initial state on, the nominal flight is flown first, with
    an attitude hold of the nose on the flight path; the other plane has this hold in every flight.
    """

    def __init__(
        self, vehicle: Vehicle, plane: str, drift: bool, step: float, surroundings: Surroundings
    ) -> None:
        """Load a vehicle into JSBSim at its nominal state.

        `plane`: plane of wind, deflection and measurements; in yaw to the right. `drift`: whether
        the flight path may turn. `step`: step [s]. `surroundings`: the Earth, or an initial state
        with varying parameters; None for a flat planet and frozen parameters.
        """
        earth = surroundings if isinstance(surroundings, Earth) else None
        departure = surroundings if isinstance(surroundings, InitialState) else None
        heading = earth.heading if earth else 0.0
        initial = {
            "lat-geod-rad": earth.latitude if earth else 0.0,
            "h-sl-ft": (surroundings.altitude if surroundings else 0.0) / FOOT,
            "psi-true-rad": heading,
            "theta-rad": float(vehicle.attitude),
            "u-fps": float(vehicle.velocity) / FOOT,
            "q-rad_sec": departure.path_rate if departure else 0.0,
        }
        planet = None if earth else planet_xml()
        model = model_xml(vehicle, heading, departure)
        engine = Engine(model, initial, step, planet=planet, drift=drift)
        self.engine, self._step = engine, step
        # by plane, pitch and yaw: functions that write or read JSBSim's properties
        self._deflection_setters = {name: engine.writer(path) for name, path in DEFLECTIONS.items()}
        self._readers = {name: motion_readers(engine, name, heading) for name in DEFLECTIONS}
        self._wind_setters = {name: wind_setter(engine, name, heading) for name in DEFLECTIONS}
        self._plane, c = plane, Coefficients.from_vehicle(vehicle, plane)
        # of the attitude hold of the nominal flight; a frozen vehicle over a plane needs none
        self._gains = _hold_gains(c) if surroundings else None
        self._nominal: list[Row] = []  # outputs of the nominal flight by step, flown when needed

    def fly(
        self,
        steering: Steering,
        speeds: FloatArray,
        angles: FloatArray,
        trajectory: FloatArray | None = None,
        sensors: LateralSensors = NO_LATERAL_SENSORS,
    ) -> FloatArray:
        """Return attitude, its rate, path angle, angle of attack and deflection, ``(m, 5)``.

        They are the `OUTPUTS` of a flight from the nominal state, deviations [rad, rad/s] from the
        nominal flight, and end after the first attitude beyond 25 deg or number that is not finite.

        `steering`: function of the deflection. `speeds`: wind speed [m/s] at each step, along the
        flight or to its right, ``(n,)``, m <= n; the first is zero. `angles`: wind angle [rad],
        ``(n,)``. `trajectory`: `OUTPUTS` in pitch of the nominal flight, ``(n, 5)``; without it the
        nominal flight is straight. `sensors`: lateral sensors of the law.
        """
        nominal = self._nominal_rows(len(speeds), trajectory)
        rows = self._deviation_rows(steering, speeds, angles, nominal, trajectory, sensors)
        return rows[:, : len(OUTPUTS)]

    def fly_both(
        self,
        steering: Callable[[list[Measurement]], tuple[float, float]],
        speeds: FloatArray,
        angles: FloatArray,
        sensors: LateralSensors = NO_LATERAL_SENSORS,
    ) -> FloatArray:
        """Return the `OUTPUTS` of a flight in both planes [rad, rad/s], ``(m, 2, 5)``.

        They are deviations from the nominal flight, which is straight: parameters are frozen, over
        a flat planet. The flight ends after the first attitude beyond 25 deg or number that is not
        finite. `steering`: function from the predicted measurements in pitch and yaw to both
        deflections [rad]. `speeds`, `angles`: wind along the flight and to its right [m/s], and as
        angles [rad], ``(2, n)``, at each step; those at the start are zero. `sensors`: lateral
        sensors of the law.
        """
        self._restart()
        planes = [Prediction(self._readers[name], self._step, sensors) for name in DEFLECTIONS]
        setters = (self._deflection_setters, self._wind_setters)
        set_deflections, set_winds = ([setter[name] for name in DEFLECTIONS] for setter in setters)
        nominal = [_straight_row(*self._readers[name].angles()) for name in DEFLECTIONS]
        rows: list[list[Row]] = [[(0.0,) * _COLUMNS] * len(planes)]
        for speed, angle in zip(speeds.T[1:].tolist(), angles.T[1:].tolist(), strict=True):
            inputs = list(zip(planes, angle, nominal, strict=True))
            deflections = steering([plane.measurement(a, row) for plane, a, row in inputs])
            values = (*deflections, *speed)
            for write, value in zip((*set_deflections, *set_winds), values, strict=True):
                write(value)
            self.engine.run()
            rows.append(
                [
                    plane.after_step(d, a, row)
                    for d, (plane, a, row) in zip(deflections, inputs, strict=True)
                ]
            )
            if not max(abs(row[0]) for row in rows[-1]) <= MAX_ATTITUDE:
                break
        return np.array(rows)[..., : len(OUTPUTS)]

    def _nominal_rows(self, count: int, trajectory: FloatArray | None) -> Iterator[Row]:
        """Return an iterator over the outputs of the nominal flight, a `Row` for each step.

        Without an attitude hold (`_gains`) it is straight. Else it is flown in still air with that
        hold, about a reference, and its rows are kept for further flights. The reference is
        `trajectory` in pitch, `OUTPUTS` ``(count, 5)``, and else straight. `count`: number of the
        steps. `InputError` where the flight ends before.
        """
        start = _straight_row(*self._restart())  # attitude and flight path angle at the start
        if self._gains is None:
            return repeat(start)
        if len(self._nominal) < count:
            (on_lean, on_rate), zeros = self._gains, np.zeros(count)
            reference = np.tile(start, (count, 1))
            if trajectory is not None and self._plane == "pitch":
                reference[:, : len(OUTPUTS)] = trajectory
            rows = _plain_rows(reference)
            # deviations from the reference, which the hold keeps small
            deviations = self._deviation_rows(
                steering=lambda k, measured: (
                    on_lean * (measured.attitude - measured.flight_path_angle)
                    + on_rate * measured.attitude_rate
                ),
                speeds=zeros,
                angles=zeros,
                nominal=rows,
                trajectory=trajectory,
                sensors=_ACCELEROMETER,  # a `Row` has the force and the angular acceleration
            )
            self._nominal = list(_plain_rows(deviations + reference[: len(deviations)]))
        if len(self._nominal) < count:
            raise InputError(
                "timepts must end before the nominal flight has turned by 25 deg, after"
                f" {len(self._nominal) * self._step:.3g} s"
            )
        return iter(self._nominal)

    def _restart(self) -> tuple[float, float]:
        """Reset JSBSim to the start; return attitude and flight path angle [rad] in the plane."""
        self.engine.reset()
        return self._readers[self._plane].angles()  # readers of the motion in pitch and in yaw

    def _deviation_rows(
        self,
        steering: Steering,
        speeds: FloatArray,
        angles: FloatArray,
        nominal: Iterator[Row],
        trajectory: FloatArray | None,
        sensors: LateralSensors,
    ) -> FloatArray:
        """Return the outputs of a flight at m samples, minus the nominal outputs, ``(m, 7)``.

        The columns are those of `Row`, attitude first. JSBSim is reset first. The flight ends after
        the first attitude beyond 25 deg or that is not finite. `steering`: returns the deflection
        of the law [rad]. `speeds`, `angles`: wind speed [m/s] and wind angle [rad] at each step,
        ``(n,)``, m <= n. `nominal`: rows of the nominal flight. `trajectory`: its `OUTPUTS` in
        pitch, ``(n, 5)``; without it the nominal flight is straight. `sensors`: of the law.
        """
        self._restart()
        h, run, set_deflection = self._step, self.engine.run, self._deflection_setters[self._plane]
        set_wind_speed = self._wind_setters[self._plane]
        hold_other_plane = self._attitude_hold(trajectory)
        _attitude, path_rate, *_ = next(nominal)  # at the start: path and attitude turn together
        prediction = Prediction(self._readers[self._plane], h, sensors, h * path_rate)
        rows: list[Row] = [(0.0,) * _COLUMNS]
        gusts = zip(speeds[1:].tolist(), angles[1:].tolist(), nominal, strict=False)
        for k, (speed, angle, row) in enumerate(gusts, start=1):
            deflection = steering(k, prediction.measurement(angle, row))
            hold_other_plane()
            *_, nominal_deflection, _force, _acceleration = row
            set_deflection(nominal_deflection + deflection)
            set_wind_speed(speed)
            run()
            rows.append(prediction.after_step(deflection, angle, row))
            if not abs(rows[-1][0]) <= MAX_ATTITUDE:
                break
        return np.array(rows)

    def _attitude_hold(self, trajectory: FloatArray | None) -> Callable[[], None]:
        """Return the function that holds the nose on the path in the other plane, before a step.

        The other plane is the one in which no law flies. `trajectory`: `OUTPUTS` of the nominal
        flight in pitch, ``(n, 5)``, whose rate and deflection are the reference; without it they
        are zero.
        """
        if self._gains is None:  # flat planet and frozen parameters: no control is required
            return lambda: None
        (other_plane,) = set(DEFLECTIONS) - {self._plane}
        angles, rates, *_ = self._readers[other_plane]
        set_deflection, (on_lean, on_rate) = self._deflection_setters[other_plane], self._gains
        reference: Iterator[Row] = repeat((0.0, 0.0))
        if trajectory is not None and other_plane == "pitch":
            # attitude rate and deflection in each step, which a row states at the step's end
            reference = _plain_rows(trajectory[1:, [1, 4]])

        def hold() -> None:
            """Set the deflection of the other plane for the next step: reference plus feedback."""
            path_rate, deflection = next(reference)
            attitude, path = angles()
            rate, _acceleration = rates()
            lean, excess_rate = attitude - path, rate - path_rate
            set_deflection(deflection + on_lean * lean + on_rate * excess_rate)

        return hold


def _straight_row(attitude: float, path: float) -> Row:
    """Return the outputs of a straight flight with an attitude and a flight path angle [rad].

    All other numbers of the `Row` are zero.
    """
    return (attitude, 0.0, path, *(0.0,) * (_COLUMNS - 3))


def _plain_rows(rows: FloatArray) -> Iterator[Row]:
    """Return an iterator over the rows as tuples of floats, which are read faster."""
    return map(tuple, rows.tolist())


def _hold_gains(c: Coefficients) -> tuple[float, float]:
    """Return the gains of an attitude hold on nose minus path, and on the attitude rate [s].

    The attitude is to move like s^2 + 2 w s + w^2 with the frequency w [rad/s], four times that of
    the airframe and at least 1, against the moments mu_alpha and mu_delta per inertia [1/s^2], per
    angle of attack and per deflection. `c`: coefficients of the vehicle in the plane.
    """
    mu_alpha, mu_delta = float(c.mu_alpha), float(c.mu_delta)
    frequency = max(_HOLD_OVER_AIRFRAME_FREQUENCY * abs(mu_alpha) ** 0.5, _MIN_HOLD_FREQUENCY)
    return (frequency**2 + mu_alpha) / mu_delta, 2.0 * frequency / mu_delta


_Case = tuple[Vehicle, str, bool, float, Surroundings]
_IDLE: dict[_Case, list[Airframe]] = {}
_MAX_CASES = 8
"""Largest number of cases whose airframes are kept: an engine holds some megabytes."""


@contextmanager
def reused_airframe(*case: *_Case) -> Iterator[Airframe]:
    """Provide JSBSim with a vehicle, an idle one if possible: loading takes a third of a flight.

    `case`: arguments of `Airframe`. Airframes in use are not shared, so that threads, and laws that
    fly themselves, have their own.
    """
    try:
        airframe = _IDLE[case].pop()
    except (KeyError, IndexError):
        airframe = Airframe(*case)
    yield airframe
    if case not in _IDLE and len(_IDLE) >= _MAX_CASES:
        _IDLE.pop(next(iter(_IDLE)), None)
    _IDLE.setdefault(case, []).append(airframe)
