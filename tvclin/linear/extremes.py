"""What stands out in an attitude response: its extremes, and when it is back at zero."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.documents import keyed
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.winds.histories import History

Function = Callable[[FloatArray], FloatArray]

_COARSE, _BETWEEN = 2001, 100
"""Times at which extremes are looked for: even ones over all, and ones between two breakpoints. A
swing that is shorter than both is not seen."""
_FINE, _ROUNDS = 41, 5
"""Times between two samples beside the highest, and how often: 20^-5 of the interval is left, and a
summit is flat, so that its height is known to rounding."""
_NOTHING = 1e-9
"""An attitude error below this part of the wind's peak is rounding."""
_FLOWN = 1e-3
"""The same of a flight."""
FALLEN_OVER = np.pi / 2
"""An attitude error [rad] beyond which nothing is to be shown."""
LET_GO, FALLEN, WHOLE = "let go", "fallen", "whole"
"""Why a response is shown no longer: the limit is let go, 90 degrees are exceeded, it was asked."""
TURNED_OVER = (
    "Held for ever, this limit turns the vehicle over. It is survived with a control that"
    " lets go of it in time, which this response does not show."
)
"""Of a limit that is survived, and a response with it that exceeds 90 degrees."""


@dataclass(frozen=True)
class Point:
    """A value [rad] and its time [s]."""

    value: float
    time: float

    as_dict = keyed("deg=value time_s")


@dataclass(frozen=True)
class Extremes:
    """What stands out in an attitude response; None where there is no such thing.

    `with_wind`, `against_wind`: largest attitude error on the side to which the wind turns the
    vehicle, with its sign, and on the other. `back_at_zero`: when it comes back through zero from
    the wind's side for the last time. `at_wind_end`, `at_end`: of the wind and of the response.
    """

    with_wind: Point | None
    against_wind: Point | None
    back_at_zero: Point | None
    at_wind_end: Point | None
    at_end: Point


def extremes(plant: Plant, deflection: History, wind: History, length: float) -> Extremes:
    """Return what stands out in the attitude from 0 to `length` [s].

    `plant`: one plant. `deflection`: its deflection [rad]. `wind`: its wind [rad], which ends.
    `length`: duration of the response [s].

    Extremes are sought between the samples; nothing depends on how fine a response is written.
    """
    turned = _turned(plant, wind)
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


@dataclass(frozen=True)
class Shown:
    """Until when [s] a response says anything, and why; `back_at_zero` if that is its end."""

    time: float
    why: str
    back_at_zero: Point | None = None


def shown_until(
    plant: Plant, deflection: History, wind: History, longest: float, *, lets_go: bool = True
) -> Shown:
    """Return until when the response to a limit that is held for ever is to be shown.

    A limit that is held for ever drives a survivor over to the other side. An autopilot lets go of
    it when the attitude is back at zero, and so the response ends there. Where the limit turns the
    vehicle over to the other side at once, it ends with the wind.

    `plant`: one plant. `deflection`, `wind`: its inputs [rad]; the wind ends. `longest`: the end
    that was asked for [s]. `lets_go`: whether the limit survives, so that the last return to zero
    is the end of its work.
    """
    from scipy.optimize import brentq

    back = extremes(plant, deflection, wind, longest).back_at_zero
    if lets_go and back is not None:
        return Shown(back.time, LET_GO, back)
    times = probe_times(0.0, longest, deflection, wind)
    towards = _turned(plant, wind) * attitude_responses(plant, deflection, wind, times)["attitude"]
    over = _over(times, towards, wind, _NOTHING) if lets_go else np.inf

    def left(times: FloatArray) -> FloatArray:
        return FALLEN_OVER - np.abs(attitude_responses(plant, deflection, wind, times)["attitude"])

    fallen = np.flatnonzero(np.abs(towards) > FALLEN_OVER)
    if not fallen.size or over <= times[fallen[0] - 1]:
        return Shown(over, LET_GO) if over < longest else Shown(longest, WHOLE)
    ends = times[fallen[0] - 1], times[fallen[0]]
    return Shown(float(brentq(lambda t: float(left(np.array([t]))[0]), *ends)), FALLEN)


def let_go(plant: Plant, wind: History, times: FloatArray, attitude: FloatArray) -> float:
    """Return when a limit that is held for ever is let go in a flight [s]; infinite if never.

    `plant`, `wind`: what flies. `times`, `attitude`: samples of a flight that survives [s, rad],
    ``(n,)``; NaN where there is none.

    As of `shown_until`, but between the samples the attitude is taken for straight.
    """
    known = np.isfinite(attitude)
    times, towards = times[known], _turned(plant, wind) * attitude[known]
    clear = np.where(np.abs(towards) > _FLOWN * abs(float(wind.peak)), towards, 0.0)
    back = _last_return(lambda t: np.interp(t, times, towards), times, clear)
    if back is not None:
        return back.time
    return _over(times, towards, wind, _FLOWN)


def _turned(plant: Plant, wind: History) -> float:
    """The sign of the attitudes to which a wind turns a vehicle."""
    return float(np.sign(-plant.coefficients.mu_alpha * wind.peak)) or 1.0


def _over(times: FloatArray, towards: FloatArray, wind: History, smallest: float) -> float:
    """When an attitude that was never on the wind's side goes over to the other; infinite if not.

    From the end of the wind on, for before it leans into the wind.
    """
    still = np.flatnonzero(towards >= -smallest * abs(float(wind.peak)))
    if not still.size or still[-1] == times.size - 1:
        return np.inf
    return max(float(times[still[-1]]), float(wind.end))


def probe_times(start: float, stop: float, *histories: History) -> FloatArray:
    """Return times [s] from `start` to `stop`, even, and more of them around the breakpoints."""
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
