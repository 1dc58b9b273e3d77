"""The wind triangle: wind angles of attack and dynamic pressure of a velocity through the air.

Seen from the ground the vehicle has the speed V at the angle Theta_n above the horizontal. In
horizontal winds w along the path, positive from behind, and c across it, both over V, its velocity
through the air over V is

    (cos Theta_n - w, sin Theta_n, -c),

so that the wind angles of attack in pitch and yaw and the dynamic pressure over the nominal one are

    alpha = atan2(sin Theta_n, cos Theta_n - w) - Theta_n,    tan(beta) = c/v,    q/q_n = v^2 + c^2,
    v^2 = (cos Theta_n - w)^2 + sin(Theta_n)^2.

A wind that is given by its angles is that whose triangle has them,

    w = sin(alpha)/sin(Theta_n + alpha),    c = v tan(beta).

Speed and path are those given; `EncounteredWind.flight` lets them vary along a flight.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray


def wind_triangle(
    path: ArrayLike, along: ArrayLike, across: ArrayLike = 0.0
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return wind angles of attack in pitch and yaw [rad], and q/q_n, of horizontal winds.

    Parameters
    ----------
    path : array_like
        Angle Theta_n of the path above the horizontal [rad].
    along, across : array_like
        Wind speeds w and c over the speed of the vehicle; w is positive from behind.
    """
    climb = np.asarray(path, dtype=float)
    forward, upward = np.cos(climb) - along, np.sin(climb)
    in_pitch = forward**2 + upward**2
    turned = np.arctan2(upward, forward) - climb
    pitch = np.arctan2(np.sin(turned), np.cos(turned))
    yaw = np.arctan2(across, np.sqrt(in_pitch))
    return np.asarray(pitch), np.asarray(yaw), np.asarray(in_pitch + np.square(across))


def along_from_angle(path: ArrayLike, angle: ArrayLike) -> FloatArray:
    """Return the wind speed w along a path, over that of the vehicle, that turns it by an angle.

    `path`, `angle`: Theta_n and alpha [rad]. NaN where no horizontal wind turns the path so far: it
    would be level, or is.
    """
    path, turned = np.asarray(path), np.asarray(path) + angle
    possible = (np.sin(path) > 0.0) & (np.sin(turned) > 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(possible, np.sin(angle) / np.sin(turned), np.nan)


def pressure_ratio(path: ArrayLike, angle: ArrayLike) -> FloatArray:
    """Return q/q_n in winds along a path that turn it by angles [rad]; NaN where none does."""
    return wind_triangle(path, along_from_angle(path, angle))[2]
