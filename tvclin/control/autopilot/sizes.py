"""How large and how small the numbers of an autopilot may be.

The polynomials of a loop multiply several of them; what lies beyond overflows or vanishes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, finite, positive, within

LARGEST = 1e9
"""Of gains, frequencies, damping ratios and times in SI units, and one over the smallest."""
LEAST_GAIN = 1e-30
"""A smaller gain is zero or a mistake; rounding leaves larger ones."""


def sized(name: str, value: ArrayLike, unit: str = "") -> FloatArray:
    """Return `value` as an array; `InputError` unless it is positive and of a size to work with."""
    return within(name, positive(name, value, unit), 1.0 / LARGEST, LARGEST, unit)


def zero_or_sized(name: str, value: ArrayLike, least: float, unit: str = "") -> FloatArray:
    """Return `value` as an array; `InputError` where its size is not zero, or `least` to 1e9."""
    array = finite(name, value, unit)
    size = np.abs(array)
    bad = (size > LARGEST) | ((size > 0.0) & (size < least))
    if np.any(bad):
        raise InputError(
            f"{name} must be zero or {least:.6g} to {LARGEST:.6g}{unit and ' ' + unit} in size;"
            f" got {array[bad].flat[0]:.6g}"
        )
    return array
