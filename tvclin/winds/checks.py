"""What every wind with a peak is asked at the door."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.errors import InputError, nonzero, plain, together
from tvclin.histories import History

FloatArray = NDArray[np.float64]


def checked_peak(peak: ArrayLike) -> FloatArray:
    """Return `peak` as a float array; `InputError` unless it is a wind angle, and not zero."""
    peak = nonzero("peak", peak, "rad")
    if np.any(np.abs(peak) >= np.pi / 2):
        raise InputError(
            "peak must be a wind angle within 90 degrees, in radians; got"
            f" {np.abs(peak).max():.6g} rad ({np.degrees(np.abs(peak).max()):.4g} deg)"
        )
    return peak


def keep(wind: History, **checked: FloatArray) -> None:
    """Keep the checked fields of a frozen wind, all in the shape of its batch.

    `InputError` unless their shapes broadcast.
    """
    together(**checked)
    for name, value in zip(checked, np.broadcast_arrays(*checked.values()), strict=True):
        object.__setattr__(wind, name, plain(value))
