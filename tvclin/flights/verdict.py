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


_WATCHED = 12.0
"""A flight is watched for so long after the wind, over its pole: what is off has grown by e^12."""
_STILL = 0.1
"""A late rate below this part of the pole times the wind's peak is no fall."""


def watched_until(wind: History | PlaneWind, pole: float) -> float:
    """Return the time [s] at which a flight is judged, if it has not left its model before."""
    return float(wind.end) + _WATCHED / pole


def has_fallen(rate: float, peak: float, pole: float) -> bool:
    """Return whether a late attitude rate [rad/s] is a fall, after a wind of a peak [rad]."""
    return rate > _STILL * pole * abs(peak)


def judged(
    late_rate: Callable[[float], float], control: object, wind: History, pole: float
) -> Callable[[float], bool]:
    """Return what says of a limit [rad] that the late rate [rad/s] with it is no fall.

    A law lets go of the limit when the work is done, and falls to neither side; what holds the
    limit for ever, only to the side to which the wind turns a vehicle.
    """
    peak, lets_go = float(wind.peak), isinstance(control, Law)

    def survives(limit: float) -> bool:
        rate = late_rate(limit)
        with_the_wind = -rate if peak > 0.0 else rate
        return not has_fallen(abs(rate) if lets_go else with_the_wind, peak, pole)

    return survives
