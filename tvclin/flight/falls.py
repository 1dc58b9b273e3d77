"""How a flight of the report's control is judged: by the side to which it falls in the end.

With a limit that is too low the vehicle falls to the side to which the wind turns it; with one
that is high enough, but held for ever, to the other.
"""

from tvclin.histories import History

_PATIENCE = 12.0
"""A flight is watched for so long after the wind, over beta: what is off has grown by e^12."""
_STILL = 0.1
"""A late rate below this part of beta times the wind's peak is no fall."""


def watched_until(wind: History, beta: float) -> float:
    """Return the time [s] at which a flight is judged, if it has not left its model before."""
    return float(wind.end) + _PATIENCE / beta


def has_survived(rate: float, wind: History, beta: float) -> bool:
    """Return whether the late attitude rate [rad/s] is none to which the wind turns a vehicle."""
    peak = float(wind.peak)
    with_the_wind = -rate if peak > 0.0 else rate
    return with_the_wind <= _STILL * beta * abs(peak)
