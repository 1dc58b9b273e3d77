"""The smallest deflection limit with which a nonlinear flight survives, by bisection.

`ENGINES` names the ways to fly: the planar equations, and JSBSim.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from tvclin.ascent.flight_condition import FlightCondition
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import (
    InputError,
    between,
    ending,
    flag,
    instance,
    number,
    one_of,
    positive,
    single,
)
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.laws.law import Law
from tvclin.flights.nozzle_command import Control, ReportControl, command_of
from tvclin.flights.planar import planar_case, planar_outputs
from tvclin.flights.sixdof.fly_sixdof import SixDof, fly_sixdof, planes_verdict
from tvclin.flights.sixdof.model import Earth
from tvclin.flights.verdict import judged, watched_until
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind

Verdict = Callable[[float], bool]
"""Takes a deflection limit [rad] and says whether its flight survives."""


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
    """Return the verdict of planar flights.

    All but `frozen` as of `fly_planar`; the wind ends. `frozen`: whether parameters are frozen; if
    not, they vary along the nominal flight of `condition`. `InputError` as `fly_planar`, and for an
    aerodynamically stable vehicle.
    """
    _check_frozen(frozen, condition)
    pole = float(Coefficients.from_vehicle(vehicle, plane).pole)
    if frozen:  # any time is like another, and near zero it is known more sharply
        wind = wind.shift(-wind.onset)
    span = (float(wind.onset), watched_until(wind, pole))
    case = planar_case(vehicle, wind, span, plane=plane, drift=drift, condition=condition)
    command = command_of(control, span[0], actuator, rate_limit)

    def late_rate(limit: float) -> float:
        flown = case.flown(command, limit)
        return float(flown.rows(np.array([min(flown.end, span[1])]))[1, 0])

    return judged(late_rate, command.control, wind, pole)


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
    """Return the verdict of flights in JSBSim.

    `step`, `earth`: as of `fly_sixdof`, which says what is refused; all others as of
    `planar_verdict`.
    """
    _check_frozen(frozen, condition)
    case = SixDof(vehicle, plane, drift, step, earth, condition)
    pole, begin = float(case.coefficients.pole), float(wind.onset)
    air = case.air(wind, min(0.0, begin) if frozen else begin, watched_until(wind, pole))
    command = command_of(control, begin, actuator, rate_limit)

    def late_rate(limit: float) -> float:
        return float(case.flown(case.steering(command, limit, air), air)[-1, 1])

    return judged(late_rate, command.control, wind, pole)


def _check_frozen(frozen: bool, condition: object) -> None:
    """Raise `InputError` unless parameters are frozen, or vary in a condition."""
    if flag("frozen", frozen) == (condition is not None):
        raise InputError(
            "condition must be given exactly when parameters are not frozen (frozen=False)"
        )


def _sixdof_outputs(*given: Any, **options: Any) -> tuple[FloatArray, FloatArray]:
    """Return times [s] and outputs of a flight in JSBSim, as of `fly_sixdof`."""
    flight = fly_sixdof(*given, **options)
    return np.asarray(flight.time), np.array(flight.outputs)


@dataclass(frozen=True)
class Engine:
    """One way to fly, and what it is in words.

    `outputs`: times and outputs of a flight, as of `planar_outputs`. `verdict`: takes a vehicle, a
    wind and a control, and by name the plane, whether parameters are frozen, and options of its
    own.
    """

    words: str
    outputs: Callable[..., tuple[FloatArray, FloatArray]]
    verdict: Callable[..., Verdict]


ENGINES: Mapping[str, Engine] = MappingProxyType(
    {
        "planar": Engine("planar equations (B1)", planar_outputs, planar_verdict),
        "sixdof": Engine("six degrees of freedom (JSBSim)", _sixdof_outputs, sixdof_verdict),
    }
)


_FINEST, _WIDEST = 1e-7, 1e3
"""Least tolerance and largest limit, over the largest trim deflection."""


@dataclass(frozen=True)
class FlownBoundary(Shown):
    """A boundary that was flown.

    Attributes
    ----------
    limit : float
        y, the least deflection limit that survives over ``|B alpha_w,max|``.
    deflection : float
        The same as a deflection [rad], -limit B alpha_w,max; its sign opposes the wind.
    error : float
        Half of the last bracket of y.
    flights : int
        How many flights it took.
    """

    limit: float
    deflection: float
    error: float
    flights: int

    _keys = "limit_over_trim=limit deflection_deg error flights"


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
    """Return the least deflection limit with which a control survives a wind, found by flying.

    Parameters
    ----------
    vehicle : Vehicle
        One vehicle, aerodynamically unstable.
    wind : History or PlaneWind
        One wind that ends, from t = 0 on or later. One with a direction is flown in both planes at
        once, by a law in JSBSim; the limit is over the largest vector, in the measure of the stop.
    dead_band : float
        K of the report's control, in [0, 1]; see `ReportControl`.
    law : Law or Autopilot, optional
        Flies in place of the report's control. Where its survival does not grow with the limit,
        what is found is one of the limits between survival and loss.
    engine : str or callable
        One of `ENGINES`, or a function like these.
    plane : {"pitch", "yaw"}
        The plane of wind and nozzle.
    frozen : bool
        Whether mass, forces and speed stay what they are; an engine may know no other way.
    tolerance : float
        The limit is known to this part of ``|B alpha_w,max|``.
    highest : float
        Largest limit that is tried, over ``|B alpha_w,max|``.
    **options
        What else the engine takes: "planar" drift, condition, actuator and rate_limit, as of
        `fly_planar`; "sixdof" these, step and earth, as of `fly_sixdof`, and in both planes drift,
        step, stop and saturate, as of `fly_planes`.

    Returns
    -------
    FlownBoundary
        By bisection on the limit, each flight judged by the side to which it falls.

    Raises
    ------
    InputError
        For a vehicle without an unstable pole, batches, a wind that never ends, numbers out of
        range, a dead band and a law together, and a wind in which the highest limit is not
        enough.

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
    instance("vehicle", vehicle, Vehicle, "see load_vehicle")
    if not isinstance(wind, PlaneWind):
        instance("wind", wind, History, "such as TriangularWind")
    single("wind", wind.batch)
    ending("wind", wind.end)
    control = ReportControl(dead_band) if law is None else law
    if law is not None and ReportControl(dead_band) != ReportControl():
        raise InputError("dead_band belongs to the report's control; leave it out with a law")
    top = number("highest", highest, positive)
    number("highest", top, between(0.0, _WIDEST))
    narrow = number("tolerance", tolerance, between(_FINEST, 0.5))
    make = engine if callable(engine) else ENGINES[one_of("engine", engine, ENGINES)].verdict
    if isinstance(wind, PlaneWind):
        if engine != "sixdof":
            raise InputError('a wind with a direction is flown with engine="sixdof"')
        survives = planes_verdict(vehicle, wind, control, frozen=frozen, **options)
    else:
        survives = make(vehicle, wind, control, plane=plane, frozen=frozen, **options)
    trim = -float(Coefficients.from_vehicle(vehicle, plane).B * wind.peak)
    scale = abs(trim)
    if not survives(top * scale):
        raise InputError(
            f"wind must be survived with {top:g} times the largest trim deflection as the limit"
        )
    lost, saved, flights = 0.0, top, 1
    while saved - lost > 2.0 * narrow:
        middle = 0.5 * (lost + saved)
        lost, saved = (lost, middle) if survives(middle * scale) else (middle, saved)
        flights += 1
    limit = 0.5 * (lost + saved)
    return FlownBoundary(limit, limit * trim, 0.5 * (saved - lost), flights)
