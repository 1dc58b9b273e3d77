"""The smallest deflection limit with which a nonlinear flight survives, by bisection.

`ENGINES` names the ways to fly: the planar equations, and JSBSim.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tvclin.ascent.nominal_flight import FlightCondition
from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.fields import spec
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.laws.law import Law
from tvclin.flights.engine_interface import (
    Control,
    ReportControl,
    command_of,
    verdict_of,
    verdict_time,
)
from tvclin.flights.planar import planar_case, planar_outputs
from tvclin.flights.sixdof.fly_sixdof import SixDof, fly_sixdof, planes_verdict
from tvclin.flights.sixdof.model import Earth
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind

Verdict = Callable[[float], bool]
"""Function from a deflection limit [rad] to whether its flight survives."""


def planar_verdict(
    vehicle: Vehicle,
    wind: History,
    control: Control,
    *,
    plane: str = "pitch",
    frozen: bool = True,
    drift: bool = True,
    condition: FlightCondition | None = None,
    actuator: Actuator | None = None,
    rate_limit: float = np.inf,
) -> Verdict:
    """Return the function from a deflection limit [rad] to whether its planar flight survives.

    `wind`: one wind that ends. `control`: the report's, a law or an autopilot. `frozen`: whether
    parameters are frozen; else they vary along the nominal flight of `condition`. `drift`: whether
    the path may turn. `actuator`, `rate_limit`: hardware of a law, and its limit [rad/s].
    `InputError` in the same cases as `fly_planar`, and for an aerodynamically stable vehicle. The
    verdict is the direction in which it turns at the `verdict_time` after the wind.
    """
    _check_frozen(frozen, condition)
    pole = float(Coefficients.from_vehicle(vehicle, plane).pole)
    if frozen:  # the equations do not depend on time, and near zero its rounding is smallest
        wind = wind.shift(-wind.onset)
    span = (float(wind.onset), verdict_time(wind, pole))
    case = planar_case(vehicle, wind, span, plane=plane, drift=drift, condition=condition)
    command = command_of(control, span[0], actuator, rate_limit)

    def late_rate(limit: float) -> float:
        """Return the attitude rate [rad/s] at the end of a flight with a deflection limit [rad]."""
        flight = case.flown(command, limit)
        _attitude, rate, *_ = flight.rows(np.array([min(flight.end, span[1])]))  # at that time
        return float(rate[0])

    return verdict_of(late_rate, command.control, wind, pole)


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
) -> Verdict:
    """Return the function from a deflection limit [rad] to whether its flight in JSBSim survives.

    Same parameters as `planar_verdict`, and `step`: step of JSBSim [s]; `earth`: the rotating
    Earth, in place of a flat planet. Same exceptions as `fly_sixdof`. A flight does not survive if
    at the `verdict_time` after the wind the vehicle turns fast, see `verdict_of`. It begins at the
    onset of the wind, a frozen one at zero if that is earlier.
    """
    _check_frozen(frozen, condition)
    case = SixDof(vehicle, plane, drift, step=step, earth=earth, condition=condition)
    pole, begin = float(case.coefficients.pole), float(wind.onset)
    air = case.air(wind, min(0.0, begin) if frozen else begin, verdict_time(wind, pole))
    command = command_of(control, begin, actuator, rate_limit)

    def late_rate(limit: float) -> float:
        """Return the attitude rate [rad/s] at the end of a flight with a deflection limit [rad]."""
        steering = case.steering(command, limit, air)
        rows = case.flown(steering, air, command.lateral_sensors)
        _, attitude_rate, *_ = rows[-1]  # of the last time
        return float(attitude_rate)

    return verdict_of(late_rate, command.control, wind, pole)


def _check_frozen(frozen: bool, condition: object) -> None:
    """Raise `InputError` unless exactly one of frozen parameters and a condition is given."""
    if errors.flag("frozen", frozen) == (condition is not None):
        raise errors.InputError(
            "condition must be given exactly when parameters are not frozen (frozen=False)"
        )


def _sixdof_outputs(*arguments: Any, **options: Any) -> tuple[FloatArray, FloatArray]:
    """Return times [s] ``(n,)`` and outputs ``(5, n)`` of a flight in JSBSim, see `fly_sixdof`."""
    flight = fly_sixdof(*arguments, **options)
    return np.asarray(flight.time), np.array(flight.outputs)


@dataclass(frozen=True)
class Engine:
    """Engine of nonlinear flights, and its description in words.

    `outputs`: function that returns times [s] and outputs of a flight, such as `planar_outputs`.
    `verdict`: function that returns the `Verdict` of a vehicle, a wind and a control, such as
    `planar_verdict`.
    """

    words: str
    outputs: Callable[..., tuple[FloatArray, FloatArray]]
    verdict: Callable[..., Verdict]


ENGINES: Mapping[str, Engine] = {
    "planar": Engine("planar equations (B1)", planar_outputs, planar_verdict),
    "sixdof": Engine("six degrees of freedom (JSBSim)", _sixdof_outputs, sixdof_verdict),
}


_MIN_TOLERANCE = 1e-7
"""Smallest tolerance of the limit, over the largest trim deflection."""
_MAX_LIMIT_OVER_TRIM = 1e3
"""Largest limit of the search, over the largest trim deflection."""


@dataclass(frozen=True)
class FlownBoundary(Shown):
    """Boundary of nonlinear flights.

    Attributes
    ----------
    limit : float
        y, the smallest deflection limit that survives over ``|B alpha_w,max|``.
    deflection : float
        Deflection -limit B alpha_w,max [rad]; its sign opposes the wind.
    error : float
        Half of the last bracket of y.
    flights : int
        Number of flights.
    """

    limit: float = field(metadata=spec(label="limit over trim"))
    deflection: float = field(metadata=spec("angle"))
    error: float = field(metadata=spec())
    flights: int = field(metadata=spec())


def flown_boundary(
    vehicle: Vehicle,
    wind: History | PlaneWind,
    dead_band: float = 1.0,
    *,
    law: Law | Autopilot | None = None,
    engine: str | Callable[..., Verdict] = "planar",
    plane: str = "pitch",
    frozen: bool = True,
    tolerance: float = 1e-4,
    highest: float = 1.5,
    **options: Any,
) -> FlownBoundary:
    """Return the smallest deflection limit with which a control survives a wind in flight.

    Parameters
    ----------
    vehicle : Vehicle
        One vehicle, aerodynamically unstable.
    wind : History or PlaneWind
        One wind that ends, from t = 0 on or later. A wind with a direction is flown in both planes
        at once, by a law in JSBSim; the limit is over the largest vector, in the measure of the
        limit shape.
    dead_band : float
        K of the report's control, in [0, 1]; see `ReportControl`.
    law : Law or Autopilot, optional
        Law instead of the report's control. If survival is not monotonic in the limit, the result
        is one of the limits between survival and loss.
    engine : str or callable
        Name in `ENGINES`, or a function such as `planar_verdict`.
    plane : {"pitch", "yaw"}
        The plane of wind and nozzle.
    frozen : bool
        Whether mass, forces and speed are constant; an engine may require it.
    tolerance : float
        Tolerance of the limit, over ``|B alpha_w,max|``, the trim deflection at the wind's peak.
    highest : float
        Largest limit of the search, over the same.
    **options
        Further options of the engine: for "planar" drift, condition, actuator and rate_limit, see
        `fly_planar`; for "sixdof" also step and earth, see `fly_sixdof`; in both planes drift,
        step, stop and saturate, see `fly_planes`.

    Returns
    -------
    FlownBoundary
        By bisection on the limit, each flight judged by the side to which it falls.

    Raises
    ------
    InputError
        For a vehicle without an unstable pole, batches, a wind that never ends, numbers out of
        range, a dead band and a law together, and a wind in which the highest limit is not
        sufficient.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> wind = tv.TriangularWind(peak=np.radians(1), duration=7.5)
    >>> flown = tv.flown_boundary(vehicle, wind, dead_band=1.0)
    >>> linear = tv.boundary_limit(tv.Plant.from_vehicle(vehicle, model="drift-exact"), wind)
    >>> round(flown.limit, 3), round(linear.limit, 3)
    (0.654, 0.654)
    """
    errors.instance("vehicle", vehicle, Vehicle, "see load_vehicle")
    if not isinstance(wind, PlaneWind):
        errors.instance("wind", wind, History, "such as TriangularWind")
    errors.single("wind", wind.batch)
    errors.ending("wind", wind.end)
    control = ReportControl(dead_band) if law is None else law
    if law is not None and ReportControl(dead_band) != ReportControl():
        raise errors.InputError(
            "dead_band belongs to the report's control; leave it out with a law"
        )
    upper = errors.number("highest", highest, errors.positive)
    errors.number("highest", upper, errors.between(0.0, _MAX_LIMIT_OVER_TRIM))
    width = errors.number("tolerance", tolerance, errors.between(_MIN_TOLERANCE, 0.5))
    engine_verdict = (
        engine if callable(engine) else ENGINES[errors.one_of("engine", engine, ENGINES)].verdict
    )
    if isinstance(wind, PlaneWind):
        if engine != "sixdof":
            raise errors.InputError('a wind with a direction is flown with engine="sixdof"')
        survives = planes_verdict(vehicle, wind, control, frozen=frozen, **options)
    else:
        survives = engine_verdict(vehicle, wind, control, plane=plane, frozen=frozen, **options)
    trim = -float(Coefficients.from_vehicle(vehicle, plane).B * wind.peak)
    scale = abs(trim)
    if not survives(upper * scale):
        raise errors.InputError(
            f"wind must be survived with {upper:g} times the largest trim deflection as the limit"
        )
    diverged, saved, flights = 0.0, upper, 1
    while saved - diverged > 2.0 * width:
        middle = 0.5 * (diverged + saved)
        diverged, saved = (diverged, middle) if survives(middle * scale) else (middle, saved)
        flights += 1
    limit = 0.5 * (diverged + saved)
    error = 0.5 * (saved - diverged)
    return FlownBoundary(limit=limit, deflection=limit * trim, error=error, flights=flights)
