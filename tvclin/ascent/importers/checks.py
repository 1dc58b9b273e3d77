"""Checks of the numbers of a flight: what would be silently wrong is refused, with its row."""

import numpy as np

from tvclin.ascent.importers.flight import Flight
from tvclin.ascent.importers.slopes import LEAST, MOST
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, positive
from tvclin.vehicle.vehicle import STANDARD_GRAVITY

_LARGEST_ANGLE = np.radians(2.0)
"""Above this angle of attack body lift moves the centre of pressure: not the linear vehicle."""
_PATH_BESIDE = np.radians(10.0)
"""The path is within the angle of attack of the attitude, and what wind there may be."""
_THRUST_OVER_WEIGHT = (0.2, 500.0)
"""Of the largest: upper stages and small rockets lie within, a mass in another unit does not."""
_RADIUS_OVER_ARM = (0.1, 3.0)
"""Radius of gyration over the control arm: 0.5 to 1 for a slender body steered at its end."""
_SLOWEST_EXHAUST = 500.0
"""m/s: mass that is lost faster than a motor of this exhaust speed burns it has fallen off."""
_ROUNDING = 2e-3
"""Part of the mass that four digits, or three decimals, may jump by."""
_LONGEST = 5.0
"""A gimbal farther from the nose than so many times the centre of gravity is in another unit."""


def check_angle_of_attack(flight: Flight) -> None:
    """Refuse rows above 2 degrees, where slope and centre of pressure are not those at zero."""
    angle = np.abs(flight["angle_of_attack"])
    large = np.flatnonzero(angle > _LARGEST_ANGLE)
    if large.size:
        raise InputError(
            f"{flight.places[large[0]]}: the angle of attack is"
            f" {np.degrees(angle[large[0]]):.3g} deg at {flight['time'][large[0]]:g} s, beyond the"
            " 2 deg up to which slope and centre of pressure are those of the linear vehicle;"
            " simulate without wind, or leave these rows out with start and stop"
        )


def check_attitude(flight: Flight, attitude: FloatArray) -> None:
    """Refuse an attitude [rad] that is not above the horizon: without wind the path is near it."""
    path = np.arcsin(np.clip(flight["climb"] / flight["velocity"], -1.0, 1.0))
    off = np.abs(path - attitude)
    worst = int(np.argmax(off))
    if off[worst] > _PATH_BESIDE:
        raise InputError(
            f"{flight.places[worst]}: the attitude is {np.degrees(attitude[worst]):.3g} deg and the"
            f" path {np.degrees(path[worst]):.3g} deg above the horizon; without wind they are near"
            " each other, so check that the attitude is not from the vertical"
        )


def check_gimbal(flight: Flight, gimbal: FloatArray, gravity: FloatArray) -> None:
    """Refuse a gimbal ahead of the centre of gravity, and one too far behind it to be in metres."""
    ahead = np.flatnonzero(gravity >= gimbal)
    if ahead.size:
        i = ahead[0]
        raise InputError(
            f"gimbal_station must lie behind the centre of gravity, {gravity[i]:.4g} m from the"
            f" nose tip at {flight['time'][i]:g} s; got {gimbal[i]:.6g} m"
        )
    if gimbal.max() > _LONGEST * gravity.max() > 0.0:
        raise InputError(
            f"gimbal_station must be in m from the nose tip, and the centre of gravity is"
            f" {gravity.max():.4g} m from it; got {gimbal.max():.6g} m (is it in cm, or in inches?)"
        )


def check_slope(slope: FloatArray) -> None:
    """Refuse slopes [1/rad] that are too small to be per radian, or too large for any fins."""
    if slope.max() > MOST:
        raise InputError(
            f"normal_force_coefficient_slope must be per radian, at most {MOST:g} with large fins;"
            f" got {slope.max():.4g} (was it turned from degrees twice?)"
        )
    if slope.max() < LEAST:
        raise InputError(
            f"normal_force_coefficient_slope must be per radian, and slender bodies have about 2;"
            f" got at most {slope.max():.4g} (a coefficient, or per degree: then times 57.3?)"
        )


def check_masses(flight: Flight, weight: FloatArray) -> None:
    """Refuse a mass in another unit, and a stage that falls off."""
    ratio = flight["thrust"] / weight
    best = int(np.argmax(ratio))
    least, most = _THRUST_OVER_WEIGHT
    if not least <= ratio[best] <= most:
        raise InputError(
            f"{flight.places[best]}: thrust over weight must be between {least:g} and {most:g} for"
            f" a booster; got {ratio[best]:.3g}, so check the units of mass and thrust"
        )
    # m' = -T/c: what one step burns, at the slowest exhaust speed c, and what is lost in it
    mass = weight / STANDARD_GRAVITY
    thrust = np.maximum(flight["thrust"][:-1], flight["thrust"][1:])
    burnt = thrust * np.diff(flight["time"]) / _SLOWEST_EXHAUST + _ROUNDING * mass[:-1]
    lost = np.flatnonzero(-np.diff(mass) > burnt)
    if lost.size:
        i = lost[0]
        raise InputError(
            f"{flight.places[i + 1]}: the mass falls from {mass[i]:.5g} to {mass[i + 1]:.5g} kg,"
            " more than the motor burns, so a stage leaves; read one stage with start and stop"
        )


def check_inertia(flight: Flight, inertia: FloatArray, weight: FloatArray, arm: FloatArray) -> None:
    """Refuse an inertia in another unit, or about another axis."""
    positive("moment_of_inertia", inertia, "kg m^2")
    ratio = np.sqrt(inertia * STANDARD_GRAVITY / weight) / np.abs(arm)
    least, most = _RADIUS_OVER_ARM
    wrong = np.flatnonzero((ratio < least) | (ratio > most))
    if wrong.size:
        i = wrong[0]
        raise InputError(
            f"{flight.places[i]}: the radius of gyration, {ratio[i] * abs(arm[i]):.3g} m, must be"
            f" between {least:g} and {most:g} times the control arm, {abs(arm[i]):.3g} m; check the"
            " unit of the moment of inertia, and that it is about the transverse axis"
        )
