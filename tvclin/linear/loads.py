"""What a wind and a control do to the structure: angle of attack and the bending indicator."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, ending, instance, nonnegative
from tvclin.base.lines import Table, degrees, number
from tvclin.linear.extremes import Extremes, Point, probe_times, summit
from tvclin.linear.plant import RIGID, Plant
from tvclin.linear.response import attitude_responses
from tvclin.winds.histories import History

_NAMES = ("angle_of_attack", "attitude")


@dataclass(frozen=True)
class Loads(Shown):
    """Largest sizes while the wind blows, with their signs.

    Attributes
    ----------
    peak_angle_of_attack : float
        Angle of attack [rad].
    peak_time : float
        When it is reached [s].
    peak_attitude : float
        Attitude error [rad].
    relative : float
        Size of the peak angle of attack over the peak of the wind: 1 for ideal trim without
        drift. The bending-moment indicator N alpha falls by the same factor.
    """

    peak_angle_of_attack: float
    peak_time: float
    peak_attitude: float
    relative: float

    _keys = "peak_angle_of_attack_deg peak_time_s peak_attitude_deg relative"

    def bending_indicator(self, normal_force_slope: float) -> float:
        """Return the peak normal force N alpha [N], to which the bending moment is proportional."""
        slope = errors.number("normal_force_slope", normal_force_slope, nonnegative, "N/rad")
        return slope * abs(self.peak_angle_of_attack)


def response_table(caption: str, found: Extremes, loads: Loads | None) -> Table:
    """Return what stands out in a response, and when; of its loads where it covers the wind."""
    angle = None if loads is None else Point(loads.peak_angle_of_attack, loads.peak_time)
    points = {
        "with_wind": ("largest attitude error, with the wind", found.with_wind),
        "against_wind": ("largest attitude error, against the wind", found.against_wind),
        "back_at_zero": ("attitude last back at zero", found.back_at_zero),
        "at_wind_end": ("attitude error when the wind ends", found.at_wind_end),
        "at_end": ("attitude error at the end of what is shown", found.at_end),
        "angle_of_attack": ("largest angle of attack while the wind blows", angle),
    }
    rows = tuple(
        (
            (label,),
            degrees(f"response.{key}", point.value),
            number(f"response.{key}_s", point.time),
        )
        for key, (label, point) in points.items()
        if point is not None
    )
    return Table(caption, ("quantity", "[deg]", "time [s]"), rows)


def wind_loads(plant: Plant, deflection: History, wind: History) -> Loads:
    """Return the largest angle of attack and attitude error while the wind blows.

    Parameters
    ----------
    plant : Plant
        One plant of any model.
    deflection, wind : History
        Two histories, not batches; the wind must end.

    Raises
    ------
    InputError
        For a batch, for a wind that never ends, and where the attitude grows beyond all numbers.

    Notes
    -----
    The report's conclusions say that a control below trim reduces angle of attack and bending
    moment. The peaks are sought between the samples of the exact response.
    """
    instance("plant", plant, Plant, RIGID)
    instance("deflection", deflection, History, "such as HeldDeflection")
    instance("wind", wind, History, "such as TriangularWind")
    if plant.batch or deflection.batch or wind.batch:
        raise InputError("wind_loads is for one case; take the elements of the batch one by one")
    ending("wind", wind.end)
    start, end = float(wind.onset), float(np.nextafter(wind.end, -np.inf))
    times = probe_times(start, end, deflection, wind)
    summits = [_largest(plant, deflection, wind, name, times) for name in _NAMES]
    (angle, time), (attitude, _) = summits
    if not np.isfinite([angle, attitude]).all():
        raise InputError("the attitude grows beyond all numbers before the wind ends")
    return Loads(angle, time, attitude, abs(angle / float(wind.peak)))


def _largest(
    plant: Plant, deflection: History, wind: History, name: str, times: FloatArray
) -> tuple[float, float]:
    """The value of largest size, with its sign, and its time."""

    def output(t: FloatArray) -> FloatArray:
        return attitude_responses(plant, deflection, wind, t, [name])[name]

    values = output(times)
    sign = float(np.sign(values[np.argmax(np.abs(values))])) or 1.0
    value, time = summit(lambda t: sign * output(t), times, sign * values)
    return sign * value, time
