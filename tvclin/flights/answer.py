"""What every flight gives back, whichever engine flew it."""

import warnings
from math import radians

FARTHEST = radians(25.0)
"""Attitude [rad] from the nominal beyond which forces linear in alpha are no model of anything."""
OUTPUTS = ("attitude", "attitude_rate", "flight_path_angle", "angle_of_attack", "deflection")


def warn_of_the_end(time: float) -> None:
    """Warn the caller that a flight left the range of its model at a time [s]."""
    warnings.warn(
        f"the flight ends at t = {time:.6g} s, where its attitude is more than 25 deg from the"
        " nominal: beyond, the model holds no longer",
        stacklevel=3,
    )
