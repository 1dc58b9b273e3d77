"""Required deflection of a wind at its own wind angles of attack and dynamic pressure.

A wind known by its speed stays a velocity, so that angle and dynamic pressure follow from the wind
triangle at each time (`winds.wind_angles`). A wind given by its angle is the velocity that has that
angle. Whether a wind along the path is a head or a tail wind changes both; a wind across the path
raises the dynamic pressure whichever side it comes from.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, one_of
from tvclin.case.case import Case
from tvclin.time_varying.equations import Equations
from tvclin.time_varying.requirements import batch_requirements, varying_requirement
from tvclin.time_varying.steps import encountered_at_steps
from tvclin.vehicle.coefficients import PLANES
from tvclin.vehicle.linear_vehicle import LinearVehicle, complete_vehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History, VehicleWind
from tvclin.winds.shaped import FixedWind, ShapedWind, WindEnsemble, encountered_wind
from tvclin.winds.wind_angles import FROZEN, SIGNS, EncounteredWind, within_linear


def encountered_requirements(
    case: Case, wind: ShapedWind, dead_band: float, size: float = 1.0
) -> dict[str, dict[str, float]]:
    """Return the required deflections [rad] of a case by the direction of its wind, and the plane.

    Parameters
    ----------
    case : Case
        Vehicle, model and plane; of a nozzle with one limit for both planes both are judged.
    wind : ShapedWind
        The wind of the case with its heading, its gust at its time.
    dead_band, size
        K in [0, 1], and factor on the wind.

    Raises
    ------
    InputError
        For a vehicle of which speed and attitude are not known, where no horizontal wind has the
        angle, for angles beyond linear aerodynamics, and for a wind too long to be followed.
    """
    names = case.directions()
    if not names:
        return {}
    vehicle = complete_vehicle(case.vehicle, "the dynamic pressure encountered").rigid
    planes: tuple[str, ...] = (case.plane,) if case.nozzle.limit_shape is None else PLANES
    if case.heading is not None:
        peaks = wind.peaks(float(np.asarray(vehicle.attitude)))
        planes = tuple(plane for plane in planes if peaks[plane])
    required: dict[str, dict[str, float]] = {name: {} for name in names}
    for name, plane in product(names, planes):
        equations = Equations.frozen(vehicle, case.model, plane)
        encountered = encountered_wind(wind, vehicle, plane, name, size)
        encountered.check_linear()
        requirement = varying_requirement(equations, encountered, dead_band)
        required[name][plane] = float(requirement.required[0])  # of one wind
    return required


def largest_pressure(
    wind: ShapedWind, vehicle: Vehicle, plane: str, name: str, size: float = 1.0
) -> float:
    """Return the largest ratio q/q_n of dynamic pressures that a vehicle encounters in a wind.

    `plane`: plane of the wind angle. `name`: direction of the wind, such as "head". `size`: factor
    on the wind.
    """
    encountered = encountered_wind(wind, vehicle, plane, name, size)
    encountered.check_possible()
    # the equations set the steps alone: the ratio is that of the wind triangle
    equations = Equations.frozen(vehicle, "fixed-path", plane)
    _times, _wind, ratio = encountered_at_steps(equations, encountered)
    return float(ratio.max())


def largest_measured_pressure(case: Case) -> float:
    """Return the largest ratio q/q_n of dynamic pressures in the measured wind of a case.

    One where the case specifies the nominal dynamic pressure, and for a vehicle of which speed and
    attitude are not known. Angles of a history have their own sign, negative for a head wind.
    `InputError` for the sign of a measured wind, and for a path on which no horizontal wind has the
    angle.
    """
    if isinstance(case.vehicle, LinearVehicle) or not uses_encountered_pressure(case.sign):
        return 1.0
    if isinstance(case.wind, VehicleWind):
        return case.wind.largest_pressure(case.vehicle, case.plane)
    # sampled at both sides of each breakpoint and at eight times between two
    encountered = _of_ensemble(case.history, case.vehicle, case.plane)
    encountered.check_possible()
    _, ratio = encountered.at(encountered.history.probe_times()[np.newaxis])
    return float(ratio.max())


def uses_encountered_pressure(sign: str | None) -> bool:
    """Return whether measured winds count at the dynamic pressure encountered.

    `sign`: None, or `FROZEN` for the nominal one. `InputError` for another sign: the sign of a
    measured wind follows from its direction.
    """
    if isinstance(sign, str) and sign in SIGNS:
        raise InputError(f"measured winds have their own sign: leave sign, or take {FROZEN}")
    return sign is None or one_of("sign", sign, (FROZEN,)) != FROZEN


def encountered_batch(
    case: Case, values: Mapping[str, Any], vehicle: Vehicle, dead_band: float, plane: str
) -> FloatArray | None:
    """Return required deflections [rad] of dispersed cases, at the pressure encountered, ``(n,)``.

    NaN where the requirement is not known: no horizontal wind has the angle, the wind encountered
    is beyond linear aerodynamics, or it is too long to be followed. None where the case specifies
    the nominal dynamic pressure. Zero or infinite requirements at nominal dynamic pressure stand,
    as in a study; they are not decided here.

    Parameters
    ----------
    case : Case
        Model and wind; winds of an ensemble have their own direction along the path.
    values : mapping
        Dispersed values by name; see `ShapedWind.history`.
    vehicle : Vehicle
        One vehicle for each case, or one for all.
    dead_band : float
        K in [0, 1].
    plane : str
        Plane of the deflection.
    """
    winds: list[EncounteredWind] = []
    if isinstance(case.wind, ShapedWind):
        winds = [
            encountered_wind(case.wind, vehicle, plane, name, values=values)
            for name in case.directions(plane)
        ]
    elif uses_encountered_pressure(case.sign):
        assert isinstance(case.wind, FixedWind | WindEnsemble)
        winds = [_of_ensemble(case.wind.history(dict(values)), vehicle, plane)]
    if not winds:
        return None
    equations = Equations.frozen(vehicle, case.model, plane)
    requirement = [
        np.where(
            within_linear(wind.largest_angle),
            batch_requirements(equations, wind, dead_band),
            np.nan,
        )
        for wind in winds
    ]
    return np.asarray(np.max(requirement, axis=0))  # NaN of one is NaN of all


def _of_ensemble(winds: History, vehicle: Vehicle, plane: str) -> EncounteredWind:
    """Return measured winds as encountered: in pitch they blow along the path, in yaw across it.

    `winds`: wind angles [rad], with their signs, without speeds. `vehicle`: vehicle, or batch of
    the winds.
    """
    # fractions of the angle in pitch and yaw are those of the speed along and across the path
    along, across = (1.0, 0.0) if plane == "pitch" else (0.0, 1.0)
    return EncounteredWind(
        plane=plane,
        path=np.asarray(vehicle.attitude),
        angle=winds,
        speed=None,
        of_angle=(np.asarray(along), np.asarray(across)),
        of_speed=(along, across),
    )
