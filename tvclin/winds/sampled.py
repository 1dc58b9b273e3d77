"""Winds given by samples, and the straight lines between points of which most winds are made."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, finite, within
from tvclin.numerics.pieces import Pieces
from tvclin.winds.checks import LONGEST
from tvclin.winds.histories import History, linear_pieces


def straight_lines(time: FloatArray, angle: FloatArray) -> Pieces:
    """Return the pieces of straight lines between points ``(..., n)``, zero before and after.

    Two points at one time are a jump.
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
        _check_order(time)
        within("time", time, -LONGEST, LONGEST, "s")
        _check_angle(time, angle)
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "angle", angle)

    @cached_property
    def pieces(self) -> Pieces:
        """The pieces as arrays."""
        return straight_lines(self.time, self.angle)

    def __repr__(self) -> str:
        time = self.time
        return f"SampledWind({time.size} samples from {time[0]:.6g} s to {time[-1]:.6g} s)"


def _check_order(time: FloatArray) -> None:
    step = np.diff(time)
    thrice = np.append(False, (step[1:] == 0.0) & (step[:-1] == 0.0))
    wrong = (step < 0.0) | thrice
    if np.any(wrong):
        late = int(np.argmax(wrong)) + 1
        raise InputError(
            "time must not decrease, and may stand twice (a jump) but not three times; got"
            f" {time[late]:.6g} s at index {late}"
        )


def _check_angle(time: FloatArray, angle: FloatArray) -> None:
    if np.any(np.abs(angle) >= np.pi / 2):
        raise InputError(
            "angle must be a wind within 90 degrees, in radians; got a largest size of"
            f" {np.abs(angle).max():.6g} rad"
        )
    blows = (angle[..., :-1] != 0.0) | (angle[..., 1:] != 0.0)
    if not np.all(np.any(blows & (np.diff(time) > 0.0), axis=-1)):
        raise InputError(
            "angle must be a wind that is not zero throughout; got one that is zero wherever"
            f" time advances, from {time[0]:.6g} s to {time[-1]:.6g} s"
        )
