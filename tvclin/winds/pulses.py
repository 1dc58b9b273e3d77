"""Winds of analytical shape and sampled winds, as histories of the wind angle of attack alpha_w(t).

With the peak a [rad], the duration T [s] and zero outside 0 <= t <= T:

- rectangle: alpha_w = a;
- triangle: alpha_w = a (1 - |2 t/T - 1|), or with its peak at any time;
- trapezoid: a rise, a constant part and a fall, all linear in time;
- one minus cosine: alpha_w = (a/2) (1 - cos(2 pi t/T)), or with a plateau at its peak;
- samples: linear between given times.

All have exact pieces (`Pieces`), so that their transforms are exact. `equivalent_triangle` is the
triangle of the same area and peak as another wind.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.numerics.pieces import Pieces
from tvclin.winds.histories import History, linear_pieces

_MIN_PEAK = 1e-12
"""Smallest size of a peak [rad]."""
MIN_DURATION, MAX_DURATION = 1e-9, 1e9
"""Durations [s] outside of which times can no longer be added without loss of digits."""
# Coefficients over the peak at the rates 0, +j omega and -j omega. The local time of every piece
# starts where its half wave is at an extreme, so that all coefficients are real.
_RISE = [0.5, -0.25, -0.25]
_PLATEAU = [1.0, 0.0, 0.0]
_FALL = [0.5, 0.25, 0.25]
_ZERO = [0.0, 0.0, 0.0]
_AREA_ROUNDING = 1e-12
"""Area, relative to the sum of the sizes of its terms, that counts as zero."""


def checked_peak(peak: ArrayLike) -> FloatArray:
    """Return peaks [rad] as a float array; `InputError` for zero, and beyond 90 degrees."""
    peak = errors.small_angle("a wind angle", errors.nonzero)("peak", peak)
    if np.any(np.abs(peak) < _MIN_PEAK):
        raise errors.InputError(
            f"peak must be at least {_MIN_PEAK:g} rad in size; got {peak.min():.6g}"
        )
    return peak


def checked_duration(name: str, value: ArrayLike) -> FloatArray:
    """Return a duration `value` [s] as a float array; `InputError` unless from 1 ns to 1e9 s.

    `name`: name of the argument in the error.
    """
    value = errors.positive(name, value, "s")
    return errors.within(name, value, MIN_DURATION, MAX_DURATION, "s")


def checked_interval(name: str, value: ArrayLike) -> FloatArray:
    """Return an interval `value` [s] as a float array; `InputError` between zero and 1 ns.

    It may be zero, and at most 1e9 s. `name`: name of the argument in the error.
    """
    value = errors.within(name, errors.nonnegative(name, value, "s"), 0.0, MAX_DURATION, "s")
    if np.any((value > 0.0) & (value < MIN_DURATION)):
        raise errors.InputError(
            f"{name} must be zero, or {MIN_DURATION:g} s or longer; got {value.min():.6g} s"
        )
    return value


def check_end(wind: History) -> None:
    """Raise `InputError` for a wind that is zero throughout, or never ends."""
    if np.any(np.isneginf(wind.end)):
        raise errors.InputError("wind must differ from zero; got a history that is zero throughout")
    if np.any(np.isposinf(wind.end)):
        raise errors.InputError("wind must end: the last piece of its history must be zero")


def set_fields(wind: History, **checked: FloatArray) -> None:
    """Set the checked fields of a frozen wind, by name, all broadcast to the shape of its batch."""
    errors.together(**checked)
    for name, value in zip(checked, np.broadcast_arrays(*checked.values()), strict=True):
        object.__setattr__(wind, name, errors.plain(value))


def piecewise_linear(time: FloatArray, angle: FloatArray) -> Pieces:
    """Return the pieces of linear interpolation between points, zero outside.

    `time`, `angle`: coordinates of the points [s, rad], ``(..., n)``; two at one time are a jump.
    """
    width, rise = np.diff(time, axis=-1), np.diff(angle, axis=-1)
    slope = np.where(width > 0.0, rise, 0.0) / np.where(width > 0.0, width, 1.0)
    zero = np.zeros_like(slope[..., :1])
    return linear_pieces(
        time,
        np.concatenate([angle[..., :-1], np.zeros_like(angle[..., :1])], axis=-1),
        np.concatenate([slope, zero], axis=-1),
    )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class SampledWind(History):
    """Wind defined by samples and linear interpolation between them.

    Parameters
    ----------
    time : array_like
        Sample times [s], shape ``(n,)``, not decreasing. A repeated time is a jump. Before
        the first and after the last sample the wind is zero.
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
        """Check the samples, and set them to arrays; `InputError` as the class says."""
        time = errors.finite("time", self.time, "s")
        angle = errors.finite("angle", self.angle, "rad")
        if time.ndim != 1 or time.size < 2 or angle.ndim < 1 or angle.shape[-1] != time.size:
            raise errors.InputError(
                "time must hold two or more samples and angle one for each along its last axis;"
                f" got time of shape {time.shape} and angle of shape {angle.shape}"
            )
        step = np.diff(time)
        thrice = np.append(False, (step[1:] == 0.0) & (step[:-1] == 0.0))
        invalid = (step < 0.0) | thrice
        if np.any(invalid):
            index = int(np.argmax(invalid)) + 1
            raise errors.InputError(
                "time must not decrease, and may stand twice (a jump) but not three times; got"
                f" {time[index]:.6g} s at index {index}"
            )
        errors.within("time", time, -MAX_DURATION, MAX_DURATION, "s")
        if np.any(np.abs(angle) >= np.pi / 2):
            raise errors.InputError(
                "angle must be a wind within 90 degrees; got a largest size of"
                f" {errors.in_degrees(np.abs(angle).max())}"
            )
        has_wind = (angle[..., :-1] != 0.0) | (angle[..., 1:] != 0.0)
        if not np.all(np.any(has_wind & (step > 0.0), axis=-1)):
            raise errors.InputError(
                "angle must be a wind that is not zero throughout; got one that is zero wherever"
                f" time advances, from {time[0]:.6g} s to {time[-1]:.6g} s"
            )
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "angle", angle)

    def _pieces(self) -> Pieces:
        """Return the lines between the samples, and zero after them."""
        return piecewise_linear(self.time, self.angle)

    def __repr__(self) -> str:
        """Return the number of samples and their range of time, as text."""
        time = self.time
        return f"SampledWind({time.size} samples from {time[0]:.6g} s to {time[-1]:.6g} s)"


@dataclass(frozen=True, kw_only=True, eq=False)
class Pulse(History):
    """Wind defined by its peak [rad] and its duration [s]; each subclass gives the shape."""

    peak: float | FloatArray = field()  # type: ignore[assignment]
    duration: float | FloatArray

    def __post_init__(self) -> None:
        """Check peak and duration, and set them to one shape; `InputError` as each class says."""
        set_fields(
            self, peak=checked_peak(self.peak), duration=checked_duration("duration", self.duration)
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class RectangularWind(Pulse):
    """Wind of constant angle from t = 0 to t = tau (report, sketch (a)).

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

    def _pieces(self) -> Pieces:
        """Return the constant piece, and zero after it."""
        return _vertices_to_pieces((0.0, self.duration), (self.peak, self.peak))


@dataclass(frozen=True, kw_only=True, eq=False)
class TriangularWind(Pulse):
    """Wind that rises linearly from t = 0 to its peak at tau/2 and falls linearly to tau.

    It is the report's substitute for synthetic winds (sketch (b)).

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

    def _pieces(self) -> Pieces:
        """Return the lines of rise and fall, and zero after them."""
        return _vertices_to_pieces((0.0, self.duration / 2, self.duration), (0.0, self.peak, 0.0))


@dataclass(frozen=True, kw_only=True, eq=False)
class AsymmetricTriangularWind(Pulse):
    """Wind that rises linearly from t = 0 to its peak at any time and falls linearly to tau.

    Parameters
    ----------
    peak : array_like
        Wind angle of attack alpha_w,max [rad], not zero, within 90 degrees.
    duration : array_like
        Duration tau [s], positive; broadcasts with `peak`.
    peak_time : array_like
        Time of the peak [s], from 0 (a jump, then a fall) to `duration` (a rise, then a jump);
        broadcasts with the others.

    Raises
    ------
    InputError
        For a peak of zero or beyond 90 degrees, a duration not above zero, a peak time outside
        the duration, or shapes that do not broadcast.
    """

    peak_time: float | FloatArray

    def __post_init__(self) -> None:
        """Check the fields, and set them to one shape; `InputError` as the class says."""
        peak, duration = checked_peak(self.peak), checked_duration("duration", self.duration)
        peak_time = errors.nonnegative("peak_time", self.peak_time, "s")
        set_fields(self, peak=peak, duration=duration, peak_time=peak_time)
        errors.nonnegative("duration - peak_time", duration - peak_time, "s")

    def _pieces(self) -> Pieces:
        """Return the lines of rise and fall, and zero after them."""
        return _vertices_to_pieces((0.0, self.peak_time, self.duration), (0.0, self.peak, 0.0))


@dataclass(frozen=True, kw_only=True, eq=False)
class TrapezoidalWind(History):
    """Wind that rises linearly from t = 0 to its peak, stays constant, and falls linearly.

    Parameters
    ----------
    peak : array_like
        Wind angle of attack alpha_w,max [rad], not zero, within 90 degrees.
    rise, hold, fall : array_like
        Durations of rise, constant peak and fall [s], each zero or positive and not all of them
        zero; a rise or fall of zero is a jump. They broadcast with each other and with `peak`.

    Raises
    ------
    InputError
        For a peak of zero or beyond 90 degrees, a negative duration, a total duration of zero, or
        shapes that do not broadcast.
    """

    peak: float | FloatArray = field()  # type: ignore[assignment]
    rise: float | FloatArray
    hold: float | FloatArray
    fall: float | FloatArray

    def __post_init__(self) -> None:
        """Check the fields, and set them to one shape; `InputError` as the class says."""
        peak, rise = checked_peak(self.peak), checked_interval("rise", self.rise)
        hold, fall = checked_interval("hold", self.hold), checked_interval("fall", self.fall)
        set_fields(self, peak=peak, rise=rise, hold=hold, fall=fall)
        checked_duration("rise + hold + fall", rise + hold + fall)

    def _pieces(self) -> Pieces:
        """Return the lines of rise, constant peak and fall, and zero after them."""
        top = self.rise + self.hold
        times = (0.0, self.rise, top, top + self.fall)
        return _vertices_to_pieces(times, (0.0, self.peak, self.peak, 0.0))


def _vertices_to_pieces(times: tuple[ArrayLike, ...], angles: tuple[ArrayLike, ...]) -> Pieces:
    """Return the lines between vertices at times [s] with angles [rad], each of them a batch."""
    time, angle = (np.stack(np.broadcast_arrays(*row), axis=-1) for row in (times, angles))
    return piecewise_linear(time, angle)


@dataclass(frozen=True, kw_only=True, eq=False)
class OneMinusCosineGust(Pulse):
    """Gust that rises smoothly from t = 0 to its peak at T/2 and falls until T.

        alpha_w = (peak/2) (1 - cos(2 pi t/T)),    0 <= t <= T

    Parameters
    ----------
    peak : array_like
        Peak wind angle of attack [rad], not zero, within 90 degrees.
    duration : array_like
        Duration T [s], positive; broadcasts with `peak`. In the words of airworthiness rules it
        is twice the gust gradient distance over the speed.

    Raises
    ------
    InputError
        For a peak of zero or beyond 90 degrees, a duration not above zero, or shapes that do
        not broadcast.

    Notes
    -----
    The shape is defined by 14 CFR 25.341(a)(2).
    """

    def _pieces(self) -> Pieces:
        """Return the half waves of rise and fall, and zero after them."""
        duration = np.asarray(self.duration)
        knots = np.stack([np.zeros_like(duration), duration / 2, duration], axis=-1)
        return _half_waves(
            np.asarray(self.peak), duration / 2, knots=knots, shape=[_RISE, _FALL, _ZERO]
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class LayeredGust(History):
    """Gust that rises smoothly to its peak, stays there, and falls as it rose.

    The rise is (peak/2) (1 - cos(pi t/blend)), and the fall is its mirror image.

    Parameters
    ----------
    peak : array_like
        Wind angle of attack on the plateau [rad], not zero, within 90 degrees.
    blend : array_like
        Duration of the rise, and of the fall [s]; zero or positive, zero being a jump.
    plateau : array_like
        Duration of the peak [s]; zero or positive, and not zero where `blend` is zero. All three
        broadcast.

    Raises
    ------
    InputError
        For a peak of zero or beyond 90 degrees, a negative blend or plateau, a duration of
        zero, or shapes that do not broadcast.

    Notes
    -----
    The shape is the discrete gust of NASA-HDBK-1001, eq (2.69): its heights over the rate of
    climb are these times. The source read is not the handbook itself, but the program MAPLEAF
    (TurbulenceModelling.py), which cites it.
    """

    peak: float | FloatArray = field()  # type: ignore[assignment]
    blend: float | FloatArray
    plateau: float | FloatArray

    def __post_init__(self) -> None:
        """Check the fields, and set them to one shape; `InputError` as the class says."""
        peak, blend = checked_peak(self.peak), checked_interval("blend", self.blend)
        plateau = errors.nonnegative("plateau", self.plateau, "s")
        set_fields(self, peak=peak, blend=blend, plateau=plateau)
        checked_duration("blend + plateau", blend + plateau)

    def _pieces(self) -> Pieces:
        """Return half waves of rise and fall, `blend` long, the plateau between, and zero after."""
        blend = np.asarray(self.blend)
        top = blend + self.plateau
        knots = np.stack(np.broadcast_arrays(0.0, blend, top, top + blend), axis=-1)
        shape = [_RISE, _PLATEAU, _FALL, _ZERO]
        return _half_waves(np.asarray(self.peak), blend, knots=knots, shape=shape)


def _half_waves(
    peak: FloatArray, half_wave: FloatArray, *, knots: FloatArray, shape: list[list[float]]
) -> Pieces:
    """Return pieces (c0 + c1 cos(omega u)) peak, omega being pi over the `half_wave` [s].

    They are constants and half waves of a cosine, u being the time from the begin of a piece.
    `peak`: peaks [rad]; `half_wave`: duration of half a wave, zero for a jump; `knots`: times at
    which pieces begin [s], ``(..., n)``. `shape`: coefficients of the rates 0, j omega and
    -j omega, which make c0 and c1, of each of the n pieces.
    """
    coefficients = peak[..., np.newaxis, np.newaxis] * np.array(shape)
    omega = np.pi / np.where(half_wave > 0.0, half_wave, 1.0)
    rates = 1j * omega[..., np.newaxis] * np.array([0.0, 1.0, -1.0])
    return Pieces(knots, coefficients[..., np.newaxis], rates)  # polynomials of degree zero


def checked_gust(gust: History | None) -> History | None:
    """Return a gust or None; `InputError` for a batch, and for an endless gust."""
    if gust is not None:
        errors.instance("gust", gust, History, "such as OneMinusCosineGust")
        errors.single("gust", gust.batch)
        errors.ending("gust", gust.end)
    return gust


def equivalent_triangle(wind: History) -> History:
    """Return the triangular wind of the same area, peak and onset as a wind.

    Its duration is twice the area over the peak.

    Parameters
    ----------
    wind : History
        Wind angle of attack, one or a batch, that ends.

    Returns
    -------
    History
        A `TriangularWind`, shifted (a plain history) where the wind does not start at t = 0.

    Raises
    ------
    InputError
        For an endless wind, an area without the sign of the peak (as of opposite lobes that
        cancel, or of a wind that is zero), and a peak beyond 90 degrees.

    Notes
    -----
    The report, under "Results": "reasonable results can be obtained by approximating the real
    wind with a triangle of the same area and maximum velocity". `triangle_error` says how
    reasonable, for a given plant.

    Examples
    --------
    >>> from tvclin.winds.pulses import OneMinusCosineGust, equivalent_triangle
    >>> equivalent_triangle(OneMinusCosineGust(peak=0.08, duration=6.0))
    TriangularWind(peak=0.08, duration=6.0)
    """
    errors.instance("wind", wind, History, "such as OneMinusCosineGust")
    if np.any(wind.end == np.inf):
        raise errors.InputError("wind must end: the last piece of its history must be zero")
    peak, area = np.broadcast_arrays(wind.peak, wind.laplace(0.0))
    # an area within rounding of zero has no sign
    invalid = np.sign(peak) * area <= _AREA_ROUNDING * wind.laplace_magnitude(0.0)
    if np.any(invalid):
        index = int(np.argmax(invalid))
        raise errors.InputError(
            f"wind must have a time integral with the sign of its peak; got {area.flat[index]:.6g}"
            f" rad s with a peak of {peak.flat[index]:.6g} rad"
        )
    triangle = TriangularWind(peak=peak, duration=2.0 * area / peak)
    return triangle.shift(wind.onset) if np.any(wind.onset != 0.0) else triangle
