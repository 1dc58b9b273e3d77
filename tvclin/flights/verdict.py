"""The verdict on a flight of any engine: the sign of its attitude rate long after the wind.

With a limit that is too small the vehicle tumbles in the direction in which the wind turns it. With
a sufficient limit a law returns it to equilibrium; the report's control, which holds the limit for
ever, turns it the other way.
"""

import warnings
from collections.abc import Callable
from math import radians

from tvclin.control.laws.law import Law
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind

MAX_ATTITUDE = radians(25.0)
"""Largest attitude from the nominal [rad] at which forces linear in alpha are a valid model."""
OUTPUTS = ("attitude", "attitude_rate", "flight_path_angle", "angle_of_attack", "deflection")


def warn_of_the_end(time: float) -> None:
    """Warn the caller that a flight left the range of its model at a time [s]."""
    warnings.warn(
        f"the flight ends at t = {time:.6g} s, where its attitude is more than 25 deg from the"
        " nominal: beyond, the model holds no longer",
        stacklevel=3,
    )


_VERDICT_TIME_TIMES_POLE = 12.0
"""Time after the wind at which a flight is judged, times the pole: errors have grown by e^12."""
_MIN_FALL_RATE = 0.1
"""Smallest late attitude rate of a fall, over the pole times the wind's peak."""


def verdict_time(wind: History | PlaneWind, pole: float) -> float:
    """Return the time [s] of the verdict on a flight that stays within the range of its model."""
    return float(wind.end) + _VERDICT_TIME_TIMES_POLE / pole


def has_fallen(rate: float, peak: float, pole: float) -> bool:
    """Return whether a late attitude rate [rad/s] means a fall, after a wind of a peak [rad]."""
    return rate > _MIN_FALL_RATE * pole * abs(peak)


def verdict_of(
    late_rate: Callable[[float], float], control: object, wind: History, pole: float
) -> Callable[[float], bool]:
    """Return the function from a deflection limit [rad] to whether its flight survives.

    `late_rate`: attitude rate [rad/s] at the time of the verdict, of a limit. A law returns to
    equilibrium, and must not fall in either direction; a control that holds the limit for ever is
    lost only in the direction in which the wind turns a vehicle.
    """
    peak, is_law = float(wind.peak), isinstance(control, Law)

    def survives(limit: float) -> bool:
        rate = late_rate(limit)
        rate_with_wind = -rate if peak > 0.0 else rate
        return not has_fallen(abs(rate) if is_law else rate_with_wind, peak, pole)

    return survives
