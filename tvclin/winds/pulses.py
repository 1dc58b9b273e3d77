"""Pulses of straight lines: rectangle, triangles and trapezoid, all from t = 0 on."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import nonnegative
from tvclin.numerics.pieces import Pieces
from tvclin.winds.checks import checked_part, checked_peak, checked_span, keep
from tvclin.winds.histories import History
from tvclin.winds.sampled import straight_lines


@dataclass(frozen=True, kw_only=True, eq=False)
class Pulse(History):
    """A wind that is known by its peak and its duration; each shape says what becomes of them."""

    peak: float | FloatArray = field()  # type: ignore[assignment]
    duration: float | FloatArray

    def __post_init__(self) -> None:
        keep(self, peak=checked_peak(self.peak), duration=checked_span("duration", self.duration))


@dataclass(frozen=True, kw_only=True, eq=False)
class RectangularWind(Pulse):
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

    @cached_property
    def pieces(self) -> Pieces:
        """The pieces as arrays."""
        return _lines((0.0, self.duration), (self.peak, self.peak))


@dataclass(frozen=True, kw_only=True, eq=False)
class TriangularWind(Pulse):
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

    @cached_property
    def pieces(self) -> Pieces:
        """The pieces as arrays."""
        return _lines((0.0, self.duration / 2, self.duration), (0.0, self.peak, 0.0))


@dataclass(frozen=True, kw_only=True, eq=False)
class AsymmetricTriangularWind(History):
    """A wind that rises evenly from t = 0 to its peak at any time and falls evenly to tau.

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

    peak: float | FloatArray = field()  # type: ignore[assignment]
    duration: float | FloatArray
    peak_time: float | FloatArray

    def __post_init__(self) -> None:
        peak, duration = checked_peak(self.peak), checked_span("duration", self.duration)
        peak_time = nonnegative("peak_time", self.peak_time, "s")
        keep(self, peak=peak, duration=duration, peak_time=peak_time)
        nonnegative("duration - peak_time", duration - peak_time, "s")

    @cached_property
    def pieces(self) -> Pieces:
        """The pieces as arrays."""
        return _lines((0.0, self.peak_time, self.duration), (0.0, self.peak, 0.0))


@dataclass(frozen=True, kw_only=True, eq=False)
class TrapezoidalWind(History):
    """A wind that rises evenly from t = 0 to its peak, holds it, and falls evenly.

    Parameters
    ----------
    peak : array_like
        Wind angle of attack alpha_w,max [rad], not zero, within 90 degrees.
    rise, hold, fall : array_like
        How long the three parts last [s], each zero or positive and not all of them zero; a rise
        or fall of zero is a jump. They broadcast with each other and with `peak`.

    Raises
    ------
    InputError
        For a peak of zero or beyond 90 degrees, a negative part, a wind that does not last, or
        shapes that do not broadcast.
    """

    peak: float | FloatArray = field()  # type: ignore[assignment]
    rise: float | FloatArray
    hold: float | FloatArray
    fall: float | FloatArray

    def __post_init__(self) -> None:
        peak, rise = checked_peak(self.peak), checked_part("rise", self.rise)
        hold, fall = checked_part("hold", self.hold), checked_part("fall", self.fall)
        keep(self, peak=peak, rise=rise, hold=hold, fall=fall)
        checked_span("rise + hold + fall", rise + hold + fall)

    @cached_property
    def pieces(self) -> Pieces:
        """The pieces as arrays."""
        top = self.rise + self.hold
        times = (0.0, self.rise, top, top + self.fall)
        return _lines(times, (0.0, self.peak, self.peak, 0.0))


def _lines(times: tuple[ArrayLike, ...], angles: tuple[ArrayLike, ...]) -> Pieces:
    time, angle = (np.stack(np.broadcast_arrays(*row), axis=-1) for row in (times, angles))
    return straight_lines(time, angle)
