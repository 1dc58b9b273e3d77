"""What the sign of a wind along the path changes: the dynamic pressure that the vehicle meets.

A head wind raises the speed through the air, and with it normal and axial force; a tail wind lowers
it. Seen from the ground the vehicle has the speed V at the angle Theta_n above the horizontal, and
the horizontal wind that turns the path by alpha_w is

    w = V sin(alpha_w)/sin(Theta_n + alpha_w),
    q/q_n = ((V cos Theta_n - w)^2 + (V sin Theta_n)^2)/V^2.

All else is held, so that the condition of varying parameters (`sizing.varying`) says what the two
ask for. Speed and path of the vehicle itself hardly change within a wind.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tvclin.answers.requirement import RequiredDeflection
from tvclin.answers.sizing.growing import GrowingMode
from tvclin.answers.sizing.schedule import FlightSchedule
from tvclin.answers.sizing.varying import varying_need
from tvclin.base.errors import InputError
from tvclin.boundary.limit import BOUNDARY
from tvclin.vehicle.linear_vehicle import AnyVehicle, whole_vehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History

FloatArray = NDArray[np.float64]

SIGNS = {"head": -1.0, "tail": 1.0}
"""Of the wind angle in the pitch plane."""
_ROWS = 33
"""Times of a wind at which the parameters are tabulated, beside its knots."""
_JUMP = 1e-6
"""A jump of the wind is a slope over this part of its duration."""


def pressure_ratio(vehicle: Vehicle, angle: FloatArray) -> FloatArray:
    """Return the dynamic pressure in winds along the path of angles [rad], over that in calm air.

    Raises
    ------
    InputError
        Where no horizontal wind turns the path so far: it would be level.
    """
    path = float(np.asarray(vehicle.attitude))
    if np.any(np.sin(path + angle) <= 0.0) or np.sin(path) <= 0.0:
        raise InputError(
            f"a wind of {np.degrees(np.abs(angle).max()):.4g} deg along the path has no sign for a"
            f" flight at {np.degrees(path):.4g} deg: no horizontal wind turns it so far"
        )
    wind = np.sin(angle) / np.sin(path + angle)  # over V
    return np.asarray((np.cos(path) - wind) ** 2 + np.sin(path) ** 2)


def signed_needs(
    vehicle: AnyVehicle, wind: History, required: RequiredDeflection, model: str, dead_band: float
) -> dict[str, float]:
    """Return what a wind in the pitch plane needs as a head and as a tail wind [rad], by `SIGNS`.

    That is what is required with parameters frozen, times what the condition (4b) asks for more or
    less with its sign; nothing where none is required, or none is enough.

    Raises
    ------
    InputError
        As `signed_need`, and for a vehicle of which speed and attitude are not known.
    """
    frozen = abs(float(required.needs[BOUNDARY]))
    if frozen == 0.0 or not np.isfinite(frozen * float(required.deflection)):
        return {}
    whole = whole_vehicle(vehicle, "the sign of a wind").rigid
    per = abs(float(required.deflection)) / frozen
    size = wind * np.sign(float(wind.peak))
    return {
        name: per * signed_need(whole, size * sign, model, dead_band)
        for name, sign in SIGNS.items()
    }


def signed_need(vehicle: Vehicle, wind: History, model: str, dead_band: float) -> float:
    """Return what a control needs [rad] in a wind in the pitch plane, with its sign, as a size.

    Parameters
    ----------
    vehicle : Vehicle
        One vehicle, with a real unstable pole.
    wind : History
        Wind angle of attack of one sign, positive from behind.
    model : str
        As of `Plant`.
    dead_band : float
        K, which trim leaves, as in a flight.

    Raises
    ------
    InputError
        As `pressure_ratio` and `varying_need`.
    """
    begin, end = float(wind.onset), float(wind.end)
    knots = wind.knots[(wind.knots > begin) & (wind.knots <= end)]
    before = knots - _JUMP * (end - begin)
    jumps = np.abs(wind(knots) - wind(before)) > np.sqrt(_JUMP) * abs(float(wind.peak))
    times = np.unique(np.concatenate([np.linspace(begin, end, _ROWS), knots, before[jumps]]))
    ratio = pressure_ratio(vehicle, wind(times))
    met = vehicle.replace(
        normal_force_slope=vehicle.normal_force_slope * ratio,
        axial_force=vehicle.axial_force * ratio,
        time=times,
    )
    mode = GrowingMode(FlightSchedule(met), model, "pitch", (begin, end))
    return float(varying_need(mode, wind, np.array([dead_band])).required[0])
