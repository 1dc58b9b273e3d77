"""From wind speeds to wind angles."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import (
    InputError,
    NotKnownError,
    directions,
    finite,
    number,
    positive,
    together,
)

_STEPS = 8
_AXIS = 1e-12


def angle_from_speed(
    speed: ArrayLike, velocity: ArrayLike, flight_path_angle: ArrayLike
) -> FloatArray:
    """Return the wind angle of attack [rad] of a horizontal wind, eq (B1e).

        sin(alpha_w) = (V_w/V_R) sin(gamma)

    Parameters
    ----------
    speed : array_like
        Wind speed V_w [m/s]; positive is a tail wind.
    velocity : array_like
        Speed of the vehicle relative to the air V_R [m/s], positive.
    flight_path_angle : array_like
        Flight path angle gamma [rad].

    Raises
    ------
    InputError
        When the wind is faster than the vehicle can meet: ``|V_w sin(gamma)| > V_R``.
    """
    speed = finite("speed", speed, "m/s")
    velocity = positive("velocity", velocity, "m/s")
    path = directions("flight_path_angle", flight_path_angle)
    together(speed=speed, velocity=velocity, flight_path_angle=path)
    with np.errstate(over="ignore"):  # an infinite ratio is refused with the others
        sine = speed * np.sin(path) / velocity
    if np.any(np.abs(sine) > 1.0):
        raise NotKnownError(
            "speed must stay below velocity / sin(flight_path_angle), or none can meet it; got a"
            f" ratio of {np.abs(sine).max():.6g}"
        )
    return np.arcsin(sine)


def angle_in_plane(
    speed: ArrayLike, velocity: ArrayLike, attitude: ArrayLike, plane: str
) -> FloatArray:
    """Return the angle [rad] of a wind [m/s] that meets a flight along its attitude [rad].

    In yaw the wind comes across, at right angles. Raise `InputError` as `angle_from_speed`.
    """
    return angle_from_speed(speed, velocity, np.pi / 2 if plane == "yaw" else attitude)


def along_and_across(heading: float, attitude: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return the sines of both wind angles over V_w/V_R: in pitch, and in yaw from the right.

    `heading`: direction [rad] from which a horizontal wind blows, clockwise from that of the
    flight: pi is a tail wind, pi/2 one from the right. `attitude`: attitudes of flights above the
    horizontal [rad], of the shape of both.
    """
    parts = -np.cos(heading) * np.sin(attitude), np.sin(heading) + 0.0 * np.asarray(attitude)
    along, across = (np.where(np.abs(one) < _AXIS, 0.0, one) for one in parts)
    return along, across


def angles_of_vector(
    peak: ArrayLike, heading: float, attitude: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return the wind angles [rad] in pitch and in yaw of winds whose vectors have a size.

        sin(alpha_pitch) = -r cos(psi) sin(gamma),  sin(alpha_yaw) = r sin(psi),  r = V_w/V_R

    `peak`: sizes [rad] of the vector of both angles; with a sign, the wind blows the other way.
    `heading`, `attitude`: as of `along_and_across`; peaks and attitudes broadcast. `InputError` for
    numbers that are not finite, a wind along a level flight, which has no angle, and a vector that
    no wind slower than the flight makes.
    """
    size, gamma = np.broadcast_arrays(finite("peak", peak, "rad"), directions("attitude", attitude))
    along, across = along_and_across(number("heading", heading, directions, "rad"), gamma)
    if np.any((along == 0.0) & (across == 0.0)):
        raise InputError("a wind along a level flight has no wind angle; give another heading")
    sines = np.stack([along, across])
    most = (1.0 - _AXIS) / np.abs(sines).max(axis=0)
    ratio = np.minimum(np.abs(size) / np.hypot(along, across), most)
    for _ in range(_STEPS):  # Newton on |alpha(r)|^2 = peak^2, which is convex in r
        angles = np.arcsin(ratio * sines)
        slope = np.sum(angles * sines / np.sqrt(1.0 - (ratio * sines) ** 2), axis=0)
        over = np.sum(angles**2, axis=0) - size**2
        step = np.divide(over, slope, out=np.zeros(size.shape), where=size != 0.0)
        ratio = np.minimum(ratio - 0.5 * step, most)
    axis = (along == 0.0) | (across == 0.0)  # of one plane alone, to the last digit
    pitch, yaw = np.where(axis, np.sign(sines) * np.abs(size), np.arcsin(ratio * sines))
    if not np.allclose(np.hypot(pitch, yaw), np.abs(size), rtol=1e-9, atol=0.0):
        raise NotKnownError(
            "peak must be an angle that a wind slower than the flight makes; got"
            f" {float(np.abs(size).max()):.6g} rad"
        )
    return np.copysign(1.0, size) * pitch, np.copysign(1.0, size) * yaw


def angles_from_speed(
    speed: float, velocity: float, attitude: float, heading: float
) -> tuple[float, float]:
    """Return the wind angles [rad] in pitch and in yaw of a horizontal wind [m/s], eq (B1e).

    `speed`, `velocity`: of the wind and of the vehicle relative to the air [m/s]. `attitude`,
    `heading`: as of `along_and_across`. `InputError` as `angle_from_speed`.
    """
    parts = along_and_across(number("heading", heading, directions, "rad"), float(attitude))
    wind = number("speed", speed, unit="m/s")
    pitch, yaw = (float(angle_from_speed(wind * one, velocity, np.pi / 2)) for one in parts)
    if (size := np.degrees(np.hypot(pitch, yaw))) >= 90.0:
        raise NotKnownError(f"speed must make a vector of angles below 90 deg; got {size:.4g} deg")
    return pitch, yaw
