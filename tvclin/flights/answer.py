"""What every flight gives back, whichever engine flew it."""

from __future__ import annotations

import warnings
from math import radians
from typing import TYPE_CHECKING

from tvclin.base.arrays import FloatArray
from tvclin.control.autopilot.systems import wind_response
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from control import TimeResponseData


FARTHEST = radians(25.0)
"""Attitude [rad] from the nominal beyond which forces linear in alpha are no model of anything."""
OUTPUTS = ("attitude", "attitude_rate", "flight_path_angle", "angle_of_attack", "deflection")


def flight_response(
    times: FloatArray, outputs: FloatArray, wind: History, *, engine: str, title: str
) -> TimeResponseData:
    """Return the `OUTPUTS` of a flight ``(5, n)`` as `control.TimeResponseData`."""
    return wind_response(times, outputs, wind, OUTPUTS, name=engine, title=title)


def warn_of_the_end(time: float) -> None:
    """Warn the caller that a flight left the range of its model at a time [s]."""
    warnings.warn(
        f"the flight ends at t = {time:.6g} s, where its attitude is more than 25 deg from the"
        " nominal: beyond, the model holds no longer",
        stacklevel=4,
    )
