"""The angle of attack up to which linear aerodynamics holds, on which every verdict rests."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import BoolArray
from tvclin.base.errors import NotKnownError

MAX_LINEAR_ANGLE = float(np.radians(30.0))
"""Largest wind angle [rad] of a verdict: at a larger one no slope of a normal force holds."""
MAX_CERTAIN_ANGLE = float(np.radians(10.0))
"""Angle of attack [rad] above which a slender body's normal force is doubtfully linear."""
BEYOND_LINEAR = f"above {np.degrees(MAX_LINEAR_ANGLE):.3g} deg linear aerodynamics says nothing"
DOUBTFUL = (
    f"above about {np.degrees(MAX_CERTAIN_ANGLE):.3g} deg the normal force of a slender body is no"
    " longer proportional to the angle: the numbers are doubtful"
)
WIND, ATTACK = "the wind meets the flight at", "the angle of attack reaches"
"""Subjects of the sentences: the wind angle, and the angle of attack of a flight."""
_ROUNDING = 1e-12
"""Relative rounding of an angle at the limit."""


def within_linear(angles: ArrayLike) -> BoolArray:
    """Whether angles of attack [rad] are at most `MAX_LINEAR_ANGLE`, in their shape."""
    return np.abs(np.asarray(angles)) <= MAX_LINEAR_ANGLE * (1.0 + _ROUNDING)


def beyond_linear(angle: float, subject: str = WIND) -> str:
    """Sentence why nothing is known at an angle of attack [rad]; empty up to `MAX_LINEAR_ANGLE`."""
    if within_linear(angle):
        return ""
    return f"{subject} {np.degrees(abs(float(angle))):.4g} deg, and {BEYOND_LINEAR}"


def linear_notes(angle: float, subject: str = WIND) -> tuple[str, ...]:
    """Notes on an angle of attack [rad]: that nothing is known at it, or that it is doubtful."""
    if beyond := beyond_linear(angle, subject):
        return (beyond,)
    if doubtfully_linear(angle):
        return (f"{subject} {np.degrees(abs(float(angle))):.4g} deg, and {DOUBTFUL}",)
    return ()


def doubtfully_linear(angle: float) -> bool:
    """Whether an angle of attack [rad] is above `MAX_CERTAIN_ANGLE`."""
    return abs(float(angle)) > MAX_CERTAIN_ANGLE * (1.0 + _ROUNDING)


def checked_linear(angle: float) -> float:
    """Return a wind angle [rad]; raise `NotKnownError` above `MAX_LINEAR_ANGLE`."""
    if beyond := beyond_linear(angle):
        raise NotKnownError(beyond)
    return angle
