"""The engines that fly the nonlinear equations, by name: what each is, flies and judges."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from tvclin.ascent.flight_condition import FlightCondition
from tvclin.base.errors import InputError, flag
from tvclin.control.autopilot.actuator import Actuator
from tvclin.flights.control import Control, command_of
from tvclin.flights.falls import judged, watched_until
from tvclin.flights.planar.case import planar_case
from tvclin.flights.planar.fly_planar import fly_planar
from tvclin.flights.sixdof.case import SixDof
from tvclin.flights.sixdof.earth import Earth
from tvclin.flights.sixdof.fly_sixdof import fly_sixdof
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from control import TimeResponseData

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


@dataclass(frozen=True)
class Engine:
    """One way to fly, and what it is in words.

    `fly`: a flight, as of `fly_planar`. `verdict`: takes a vehicle, a wind and a control, and by
    name the plane, whether parameters are frozen, and options of its own.
    """

    words: str
    fly: Callable[..., TimeResponseData]
    verdict: Callable[..., Verdict]


ENGINES: Mapping[str, Engine] = MappingProxyType(
    {
        "planar": Engine("planar equations (B1)", fly_planar, planar_verdict),
        "sixdof": Engine("six degrees of freedom (JSBSim)", fly_sixdof, sixdof_verdict),
    }
)
