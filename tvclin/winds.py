"""Winds: histories of the wind angle of attack alpha_w.

A positive wind angle lowers the angle of attack (alpha = theta - gamma - alpha_w): it is a tail
wind, or the downwind part of a cross wind.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.errors import InputError, finite, nonzero, plain, positive, together
from tvclin.histories import History, linear_pieces
from tvclin.kernels.pieces import Pieces

FloatArray = NDArray[np.float64]


def _checked_peak(peak: ArrayLike) -> FloatArray:
    peak = nonzero("peak", peak, "rad")
    if np.any(np.abs(peak) >= np.pi / 2):
        raise InputError(
            "peak must be a wind angle within 90 degrees, in radians; got"
            f" {np.abs(peak).max():.6g} rad ({np.degrees(np.abs(peak).max()):.4g} deg)"
        )
    return peak


@dataclass(frozen=True, kw_only=True, eq=False)
class RectangularWind(History):
    """A wind that starts at t = 0, keeps one angle, and stops (report, sketch (a)).

    Parameters
    ----------
    peak : array_like
        Wind angle of attack alpha_w,max [rad], not zero, within 90 degrees.
    duration : array_like
        Duration tau [s], positive; broadcasts with `peak`.

    Raises
    ------
    InputError
        For a peak of zero or beyond 90 degrees, a duration not above zero, or shapes that do
        not broadcast.
    """

    peak: float | FloatArray  # type: ignore[assignment]
    duration: float | FloatArray

    def __post_init__(self) -> None:
        _check_pulse(self)

    @cached_property
    def pieces(self) -> Pieces:
        """The pieces as arrays."""
        peak, duration = np.broadcast_arrays(self.peak, self.duration)
        zero = np.zeros_like(peak)
        knots = np.stack([zero, duration], axis=-1)
        return linear_pieces(knots, np.stack([peak, zero], axis=-1), 0.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class TriangularWind(History):
    """A wind that rises evenly from t = 0 to its peak at tau/2 and falls evenly to tau.

    It is the report's stand-in for synthetic winds (sketch (b)).

    Parameters
    ----------
    peak : array_like
        Wind angle of attack alpha_w,max [rad], not zero, within 90 degrees.
    duration : array_like
        Duration tau [s], positive; broadcasts with `peak`.

    Raises
    ------
    InputError
        For a peak of zero or beyond 90 degrees, a duration not above zero, or shapes that do
        not broadcast.
    """

    peak: float | FloatArray  # type: ignore[assignment]
    duration: float | FloatArray

    def __post_init__(self) -> None:
        _check_pulse(self)

    @cached_property
    def pieces(self) -> Pieces:
        """The pieces as arrays."""
        peak, duration = np.broadcast_arrays(self.peak, self.duration)
        zero, slope = np.zeros_like(peak), peak / (duration / 2)
        return linear_pieces(
            np.stack([zero, duration / 2, duration], axis=-1),
            np.stack([zero, peak, zero], axis=-1),
            np.stack([slope, -slope, zero], axis=-1),
        )


def _check_pulse(wind: "RectangularWind | TriangularWind") -> None:
    peak, duration = _checked_peak(wind.peak), positive("duration", wind.duration, "s")
    together(peak=peak, duration=duration)
    object.__setattr__(wind, "peak", plain(peak))
    object.__setattr__(wind, "duration", plain(duration))


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class SampledWind(History):
    """A wind given by samples and straight lines between them.

    Parameters
    ----------
    time : array_like
        Sample times [s], shape ``(n,)``, not decreasing. A time given twice is a jump. Before
        the first and after the last sample there is no wind.
    angle : array_like
        Wind angle of attack [rad] at these times, shape ``(..., n)``.

    Raises
    ------
    InputError
        For fewer than two samples, lengths that differ, times that decrease or stand three
        times over, angles beyond 90 degrees or not finite, or a wind that is zero throughout.
    """

    time: FloatArray
    angle: FloatArray

    def __post_init__(self) -> None:
        time, angle = finite("time", self.time, "s"), finite("angle", self.angle, "rad")
        if time.ndim != 1 or time.size < 2 or angle.ndim < 1 or angle.shape[-1] != time.size:
            raise InputError(
                "time must hold two or more samples and angle one for each along its last axis;"
                f" got time of shape {time.shape} and angle of shape {angle.shape}"
            )
        step = np.diff(time)
        if np.any(step < 0.0) or np.any((step[1:] == 0.0) & (step[:-1] == 0.0)):
            late = int(np.argmax((step < 0.0) | np.append(False, step[1:] + step[:-1] == 0.0))) + 1
            raise InputError(
                "time must not decrease, and may stand twice (a jump) but not three times; got"
                f" {time[late]:.6g} s at index {late}"
            )
        if not np.all(np.any(angle != 0.0, axis=-1)) or np.any(np.abs(angle) >= np.pi / 2):
            raise InputError(
                "angle must be a wind within 90 degrees, in radians, and not zero throughout;"
                f" got a largest size of {np.abs(angle).max():.6g} rad"
            )
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "angle", angle)

    @cached_property
    def pieces(self) -> Pieces:
        """The pieces as arrays."""
        time, angle = self.time, self.angle
        width = np.diff(time)
        rise = np.diff(angle, axis=-1)
        slope = np.where(width > 0.0, rise, 0.0) / np.where(width > 0.0, width, 1.0)
        zero = np.zeros_like(angle[..., :1])
        return linear_pieces(
            time,
            np.concatenate([angle[..., :-1], zero], axis=-1),
            np.concatenate([slope, zero], axis=-1),
        )

    def __repr__(self) -> str:
        time = self.time
        return f"SampledWind({time.size} samples from {time[0]:.6g} s to {time[-1]:.6g} s)"


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
        When the wind is faster than the vehicle can meet: |V_w sin(gamma)| > V_R.
    """
    speed = finite("speed", speed, "m/s")
    velocity = positive("velocity", velocity, "m/s")
    sine = speed / velocity * np.sin(finite("flight_path_angle", flight_path_angle, "rad"))
    if np.any(np.abs(sine) > 1.0):
        raise InputError(
            "speed must stay below velocity / sin(flight_path_angle); got a ratio of"
            f" {np.abs(sine).max():.6g}"
        )
    return np.arcsin(sine)
