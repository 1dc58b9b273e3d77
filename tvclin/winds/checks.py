"""What is checked of every wind with a peak."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import (
    InputError,
    nonnegative,
    nonzero,
    plain,
    positive,
    small_angle,
    together,
    within,
)
from tvclin.winds.histories import History

_FAINTEST = 1e-12
SHORTEST, LONGEST = 1e-9, 1e9
"""Beyond these, times and angles can no longer be added to each other without loss."""


def checked_peak(peak: ArrayLike) -> FloatArray:
    """Return `peak` as a float array; `InputError` unless it is a wind angle, and not zero."""
    peak = small_angle("a wind angle", nonzero)("peak", peak)
    if np.any(np.abs(peak) < _FAINTEST):
        raise InputError(f"peak must be at least {_FAINTEST:g} rad in size; got {peak.min():.6g}")
    return peak


def checked_span(name: str, value: ArrayLike) -> FloatArray:
    """Return a duration as a float array; `InputError` unless it is between 1 ns and 1e9 s."""
    value = positive(name, value, "s")
    return within(name, value, SHORTEST, LONGEST, "s")


def checked_part(name: str, value: ArrayLike) -> FloatArray:
    """Return a part of a duration, which may be zero; `InputError` if it is shorter than 1 ns."""
    value = within(name, nonnegative(name, value, "s"), 0.0, LONGEST, "s")
    if np.any((value > 0.0) & (value < SHORTEST)):
        raise InputError(
            f"{name} must be zero, or {SHORTEST:g} s or longer; got {value.min():.6g} s"
        )
    return value


def check_end(wind: History) -> None:
    """Raise `InputError` for a wind that is zero throughout, or never ends."""
    if np.any(np.isneginf(wind.end)):
        raise InputError("wind must differ from zero; got a history that is zero throughout")
    if np.any(np.isposinf(wind.end)):
        raise InputError("wind must end: the last piece of its history must be zero")


def keep(wind: History, **checked: FloatArray) -> None:
    """Keep the checked fields of a frozen wind, all in the shape of its batch."""
    together(**checked)
    for name, value in zip(checked, np.broadcast_arrays(*checked.values()), strict=True):
        object.__setattr__(wind, name, plain(value))
