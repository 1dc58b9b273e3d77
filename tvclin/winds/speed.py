"""From wind speeds to wind angles."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.base.errors import (
    InputError,
    finite,
    positive,
    together,
)


def angle_from_speed(
    speed: ArrayLike, velocity: ArrayLike, flight_path_angle: ArrayLike
) -> NDArray[np.float64]:
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
    path = finite("flight_path_angle", flight_path_angle, "rad")
    together(speed=speed, velocity=velocity, flight_path_angle=path)
    with np.errstate(over="ignore"):  # an infinite ratio is refused with the others
        sine = speed * np.sin(path) / velocity
    if np.any(np.abs(sine) > 1.0):
        raise InputError(
            "speed must stay below velocity / sin(flight_path_angle); got a ratio of"
            f" {np.abs(sine).max():.6g}"
        )
    return np.arcsin(sine)


def angle_in_plane(
    speed: ArrayLike, velocity: ArrayLike, attitude: ArrayLike, plane: str
) -> NDArray[np.float64]:
    """Return the angle [rad] of a wind [m/s] that meets a flight along its attitude [rad].

    In yaw the wind comes across, at right angles. Raise `InputError` as `angle_from_speed`.
    """
    return angle_from_speed(speed, velocity, np.pi / 2 if plane == "yaw" else attitude)
