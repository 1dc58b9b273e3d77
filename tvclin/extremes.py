"""What stands out in an attitude response: its extremes, and when it is back at zero."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tvclin.histories import History
from tvclin.plant import Plant
from tvclin.response import attitude_responses

FloatArray = NDArray[np.float64]
Function = Callable[[FloatArray], FloatArray]

_COARSE, _BETWEEN, _FINE, _ROUNDS = 2001, 100, 41, 5
_NOTHING = 1e-9
"""An attitude error below this part of the wind's peak is rounding."""


@dataclass(frozen=True)
class Point:
    """A value [rad] and its time [s]."""

    value: float
    time: float


@dataclass(frozen=True)
class Extremes:
    """What stands out in an attitude response; None where there is no such thing.

    Attributes
    ----------
    with_wind : Point or None
        Largest attitude error on the side to which the wind turns the vehicle, with its sign.
    against_wind : Point or None
        Largest attitude error on the other side.
    back_at_zero : Point or None
        When the attitude comes back through zero from the wind's side for the last time.
    at_wind_end : Point or None
        Attitude error when the wind ends; None if the response is shorter.
    at_end : Point
        Attitude error at the end.
    """

    with_wind: Point | None
    against_wind: Point | None
    back_at_zero: Point | None
    at_wind_end: Point | None
    at_end: Point


def extremes(plant: Plant, deflection: History, wind: History, length: float) -> Extremes:
    """Return what stands out in the attitude from 0 to `length` [s].

    Parameters
    ----------
    plant : Plant
        One plant.
    deflection : History
        Its deflection [rad].
    wind : History
        Its wind [rad], which ends.
    length : float
        Duration of the response [s].

    Notes
    -----
    Extremes are sought between the samples; nothing depends on how fine a response is written.
    """
    turned = float(np.sign(-plant.coefficients.mu_alpha * wind.peak)) or 1.0
    smallest = _NOTHING * abs(float(wind.peak))

    def attitude(times: FloatArray) -> FloatArray:
        return attitude_responses(plant, deflection, wind, times, ["attitude"])["attitude"]

    def at(time: float) -> Point:
        return Point(float(attitude(np.array([time]))[0]), time)

    times = probe_times(0.0, length, deflection, wind)
    towards = turned * attitude(times)
    high = summit(lambda t: turned * attitude(t), times, towards)
    low = summit(lambda t: -turned * attitude(t), times, -towards)
    return Extremes(
        with_wind=at(high[1]) if high[0] > smallest else None,
        against_wind=at(low[1]) if low[0] > smallest else None,
        back_at_zero=_last_return(attitude, times, np.where(abs(towards) > smallest, towards, 0.0)),
        at_wind_end=at(float(wind.end)) if wind.end <= length else None,
        at_end=at(length),
    )


def probe_times(start: float, stop: float, *histories: History) -> FloatArray:
    """Return times [s] from `start` to `stop`, even, and more of them around the knots."""
    near = np.concatenate([history.probe_times(_BETWEEN).ravel() for history in histories])
    near = near[(near >= start) & (near <= stop)]
    return np.unique(np.concatenate([np.linspace(start, stop, _COARSE), near]))


def summit(function: Function, times: FloatArray, values: FloatArray) -> tuple[float, float]:
    """Return the highest value and its time, sought between the samples around the highest."""
    i = int(np.argmax(values))
    best = float(values[i]), float(times[i])
    low, high = times[max(i - 1, 0)], times[min(i + 1, times.size - 1)]
    for _ in range(_ROUNDS):
        near = np.linspace(low, high, _FINE)
        found = function(near)
        k = int(np.argmax(found))
        if found[k] > best[0]:
            best = float(found[k]), float(near[k])
        low, high = near[max(k - 1, 0)], near[min(k + 1, _FINE - 1)]
    return best


def _last_return(function: Function, times: FloatArray, towards: FloatArray) -> Point | None:
    """Where the values last fall from above zero to below it."""
    from scipy.optimize import brentq  # late: it takes 0.3 s to import

    times, towards = times[towards != 0.0], towards[towards != 0.0]
    falls = np.flatnonzero((towards[:-1] > 0.0) & (towards[1:] < 0.0))
    if not falls.size:
        return None
    ends = times[falls[-1]], times[falls[-1] + 1]
    zero = brentq(lambda t: float(function(np.array([t]))[0]), *ends, xtol=1e-12)
    return Point(0.0, float(zero))
