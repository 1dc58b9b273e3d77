"""Peaks of an attitude response: extremes, the end of its validity, and loads during the wind.

Extremes are located on samples that resolve the breakpoints of the inputs, and refined between
them, so that they do not depend on the sampling of a response. `wind_loads` gives the peak angle of
attack, to which the normal force N alpha and the bending moment are proportional.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Record, Shown
from tvclin.base.errors import InputError, ending, instance
from tvclin.base.fields import spec
from tvclin.base.lines import Table, degrees, number
from tvclin.linear.plant import PLANT_HINT, Plant
from tvclin.linear.response import attitude_responses
from tvclin.numerics.searches import grid_minimum, roots_between
from tvclin.winds.histories import History

Function = Callable[[FloatArray], FloatArray]

_EVEN_SAMPLES, _SAMPLES_PER_PIECE = 2001, 100
"""Sample times of a search for extremes: over the whole response, and between two breakpoints."""
_REFINEMENTS = 8
"""Refinements around a maximum: 8^-8 of the interval remains, and a maximum is flat, so that its
height is known to rounding."""
_RELATIVE_ROUNDING = 1e-9
"""Attitude error over the peak of the wind that counts as zero."""
_RELATIVE_FLIGHT_ERROR = 1e-3
"""Attitude error of a flight over the peak of the wind that counts as zero."""
MAX_SHOWN_ATTITUDE = np.pi / 2
"""Attitude error [rad] at which a response ends."""
RELEASED, OVERTURNED, COMPLETE = "let go", "fallen", "whole"
"""Reasons for the end of a response: release of the limit, 90 degrees, or the requested end."""
OVERTURNED_NOTE = (
    "Held for ever, this limit turns the vehicle over. It is survived with a control that"
    " lets go of it in time, which this response does not show."
)
"""Note on a limit that survives, but whose response exceeds 90 degrees."""


@dataclass(frozen=True)
class Point(Record):
    """Value [rad] of a response and its time [s]."""

    value: float = field(metadata=spec("angle", key="deg"))
    time: float = field(metadata=spec("time"))


@dataclass(frozen=True)
class Extremes:
    """Extremes of an attitude response; None where one does not exist.

    `with_wind`, `against_wind`: largest attitude error, with its sign, in the direction to which
    the wind turns the vehicle, and in the opposite direction. `back_at_zero`: last return through
    zero from the wind's direction. `at_wind_end`, `at_end`: attitude error at the end of the wind
    and of the response.
    """

    with_wind: Point | None
    against_wind: Point | None
    back_at_zero: Point | None
    at_wind_end: Point | None
    at_end: Point


def extremes(plant: Plant, deflection: History, wind: History, length: float) -> Extremes:
    """Return the extremes of the attitude from 0 to `length` [s].

    `plant`: one plant. `deflection`: its deflection [rad]. `wind`: its wind [rad], which ends.
    `length`: duration of the response [s].

    Extremes are refined between samples, and do not depend on the sampling of a response.
    """
    sign = _wind_sign(plant, wind)
    smallest = _RELATIVE_ROUNDING * abs(float(wind.peak))  # [rad], counts as zero below
    attitude = _output(plant, deflection, wind, "attitude")

    def at(time: float) -> Point:
        """Return the attitude [rad] at a time [s], with that time."""
        return Point(float(attitude(np.array([time]))[0]), time)

    def with_wind(time: FloatArray) -> FloatArray:
        """Return the attitude [rad] at times [s], positive as the wind turns the vehicle."""
        return sign * attitude(time)

    times = probe_times(0.0, length, deflection, wind)
    towards = with_wind(times)
    highest, highest_time = refined_maximum(with_wind, times, towards)
    lowest, lowest_time = refined_maximum(lambda t: -with_wind(t), times, -towards)
    return Extremes(
        with_wind=at(highest_time) if highest > smallest else None,
        against_wind=at(lowest_time) if lowest > smallest else None,
        back_at_zero=_last_zero(with_wind, times, np.where(abs(towards) > smallest, towards, 0.0)),
        at_wind_end=at(float(wind.end)) if wind.end <= length else None,
        at_end=at(length),
    )


@dataclass(frozen=True)
class ResponseEnd:
    """End [s] of a response that is shown, and its reason; `back_at_zero` if it is that return."""

    time: float
    why: str
    back_at_zero: Point | None = None


def response_end(
    plant: Plant, deflection: History, wind: History, longest: float, *, lets_go: bool = True
) -> ResponseEnd:
    """Return the end of the response to a limit that is constant without end, and its reason.

    Such a limit drives a vehicle that survives over to the other side. An autopilot releases it
    when the attitude is back at zero, and so the response ends there. Where the limit turns the
    vehicle to the other side at once, it ends with the wind; and it ends at an attitude of 90
    degrees.

    `plant`: one plant. `deflection`, `wind`: its inputs [rad]; the wind ends. `longest`: requested
    end [s]. `lets_go`: whether the limit survives, so that it is released; otherwise only 90
    degrees and the requested end count.
    """
    back = extremes(plant, deflection, wind, longest).back_at_zero  # return of the attitude to zero
    if lets_go and back is not None:
        return ResponseEnd(back.time, RELEASED, back)
    times = probe_times(0.0, longest, deflection, wind)
    attitude = _output(plant, deflection, wind, "attitude")
    towards = _wind_sign(plant, wind) * attitude(times)  # positive: as the wind turns the vehicle
    # the time from which the attitude stays opposite to the wind
    release = _overturning_time(times, towards, wind, _RELATIVE_ROUNDING) if lets_go else np.inf
    exceeding = np.flatnonzero(np.abs(towards) > MAX_SHOWN_ATTITUDE)  # beyond 90 degrees
    if not exceeding.size or release <= times[exceeding[0] - 1]:
        why = RELEASED if release < longest else COMPLETE
        return ResponseEnd(min(release, longest), why)
    first = exceeding[:1]
    (end,) = roots_between(
        times[first - 1], times[first], lambda t, _: np.abs(attitude(t)) - MAX_SHOWN_ATTITUDE
    )
    return ResponseEnd(float(end), OVERTURNED)


def release_time(plant: Plant, wind: History, times: FloatArray, attitude: FloatArray) -> float:
    """Return the time [s] at which the deflection may leave its limit; infinite if never.

    It is the time at which the attitude of a flight that survives last returns through zero from
    the direction to which the wind turns the vehicle or, without such a return, the time from which
    it stays opposite to the wind, but not before the end of the wind.

    `plant`, `wind`: plant and wind of the flight. `times`, `attitude`: samples of the flight [s,
    rad], ``(n,)``, NaN if missing; between them attitudes are interpolated linearly.
    """
    valid = np.isfinite(attitude)
    times, towards = times[valid], _wind_sign(plant, wind) * attitude[valid]
    # attitudes below a thousandth of the peak wind angle count as zero
    significant = np.where(
        np.abs(towards) > _RELATIVE_FLIGHT_ERROR * abs(float(wind.peak)), towards, 0.0
    )
    back = _last_zero(lambda t: np.interp(t, times, towards), times, significant)
    if back is not None:
        return back.time
    return _overturning_time(times, towards, wind, _RELATIVE_FLIGHT_ERROR)


def _wind_sign(plant: Plant, wind: History) -> float:
    """Return the sign, 1 or -1, of the attitude to which a wind turns a vehicle.

    `plant`: one plant. `wind`: its wind [rad]. It is the sign of the peak times the moment of a
    positive wind, -mu_alpha, or, in a plant without coefficients, times the numerator of the
    attitude from the wind at the fastest pole.
    """
    if plant.coefficients_known:
        effect = -plant.coefficients.mu_alpha
    else:
        _, from_wind, _ = plant.attitude_fractions(plant.poles[:1])
        effect = from_wind.real.item()
    return float(np.sign(effect * wind.peak)) or 1.0


def _overturning_time(
    times: FloatArray, towards: FloatArray, wind: History, smallest: float
) -> float:
    """Return the time [s] from which the attitude stays opposite to the wind; infinite if never.

    It is at least the end of the wind, before which the vehicle leans into the wind. `times`:
    samples [s]. `towards`: attitude [rad] with the sign of the wind, at `times`. `smallest`:
    fraction of the peak wind angle below which an attitude counts as zero.
    """
    not_opposite = np.flatnonzero(towards >= -smallest * abs(float(wind.peak)))
    if not not_opposite.size or not_opposite[-1] == times.size - 1:
        return np.inf
    return max(float(times[not_opposite[-1]]), float(wind.end))


def probe_times(start: float, stop: float, *histories: History) -> FloatArray:
    """Return times [s] from `start` to `stop`, even, and denser at breakpoints of histories."""
    dense = np.concatenate(
        [history.probe_times(_SAMPLES_PER_PIECE).ravel() for history in histories]
    )
    dense = dense[(dense >= start) & (dense <= stop)]
    return np.unique(np.concatenate([np.linspace(start, stop, _EVEN_SAMPLES), dense]))


def refined_maximum(
    function: Function, times: FloatArray, values: FloatArray
) -> tuple[float, float]:
    """Return the maximum of a function and its time [s], refined around the highest sample.

    It is never less than the highest sample. `function`: from times ``(n,)`` [s] to values.
    `times`, `values`: its samples, ``(n,)``, between whose neighbours the maximum lies.
    """
    i = int(np.argmax(values))
    neighbours = times[max(i - 1, 0)], times[min(i + 1, times.size - 1)]
    time, minimum = grid_minimum(lambda t: -function(t), *neighbours, _REFINEMENTS)
    return max((float(values[i]), float(times[i])), (-float(minimum), float(time)))


def _last_zero(function: Function, times: FloatArray, towards: FloatArray) -> Point | None:
    """Return the last point at which a response falls through zero; None if it does not.

    `function`: the response, from times ``(n,)`` [s] to values. `times`: of samples [s], ``(n,)``.
    `towards`: samples at these times; only their falls from positive to negative count, and zeros
    are omitted.
    """
    times, towards = times[towards != 0.0], towards[towards != 0.0]
    falls = np.flatnonzero((towards[:-1] > 0.0) & (towards[1:] < 0.0))
    if not falls.size:
        return None
    last = falls[-1:]
    (zero,) = roots_between(times[last], times[last + 1], lambda t, _: -function(t))
    return Point(0.0, float(zero))


@dataclass(frozen=True)
class Loads(Shown):
    """Peaks of angle of attack and attitude error during the wind, with their signs.

    Attributes
    ----------
    peak_angle_of_attack : float
        Angle of attack [rad].
    peak_time : float
        Time of the peak angle of attack [s].
    peak_attitude : float
        Attitude error [rad].
    relative : float
        Size of the peak angle of attack over the peak of the wind: 1 for ideal trim without
        drift. The bending-moment indicator N alpha falls by the same factor.
    """

    peak_angle_of_attack: float = field(metadata=spec("angle"))
    peak_time: float = field(metadata=spec("time"))
    peak_attitude: float = field(metadata=spec("angle"))
    relative: float = field(metadata=spec())


def response_table(caption: str, extremes: Extremes, loads: Loads | None) -> Table:
    """Return the table of extremes of a response [deg, s], with its peak angle of attack.

    `caption`: title of the table. `loads`: peaks during the wind; None where the response does not
    cover the wind.
    """
    angle = None if loads is None else Point(loads.peak_angle_of_attack, loads.peak_time)
    points = {
        "with_wind": ("largest attitude error, with the wind", extremes.with_wind),
        "against_wind": ("largest attitude error, against the wind", extremes.against_wind),
        "back_at_zero": ("attitude last back at zero", extremes.back_at_zero),
        "at_wind_end": ("attitude error when the wind ends", extremes.at_wind_end),
        "at_end": ("attitude error at the end of what is shown", extremes.at_end),
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
    """Return the peaks of angle of attack and attitude error during the wind.

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
    moment. The peaks are refined between the samples of the exact response.
    """
    instance("plant", plant, Plant, PLANT_HINT)
    instance("deflection", deflection, History, "such as ConstantDeflection")
    instance("wind", wind, History, "such as TriangularWind")
    if plant.batch or deflection.batch or wind.batch:
        raise InputError("wind_loads is for one case; take the elements of the batch one by one")
    ending("wind", wind.end)
    # up to the last instant of the wind, before a jump at its end
    start, end = float(wind.onset), float(np.nextafter(wind.end, -np.inf))
    times = probe_times(start, end, deflection, wind)
    (angle, time), (attitude, _) = (
        _peak(_output(plant, deflection, wind, name), times)
        for name in ("angle_of_attack", "attitude")
    )
    if not np.isfinite([angle, attitude]).all():
        raise InputError("the attitude grows beyond all numbers before the wind ends")
    return Loads(
        peak_angle_of_attack=angle,
        peak_time=time,
        peak_attitude=attitude,
        relative=abs(angle / float(wind.peak)),
    )


def _output(plant: Plant, deflection: History, wind: History, name: str) -> Function:
    """Return the output `name` of a response as a function of times ``(n,)`` [s].

    `plant`: one plant. `deflection`, `wind`: its inputs [rad].
    """
    return lambda times: attitude_responses(plant, deflection, wind, times, [name])[name]


def _peak(output: Function, times: FloatArray) -> tuple[float, float]:
    """Return the value of largest size of a function, with its sign, and its time [s].

    `output`: the function, from times ``(n,)`` [s] to values ``(n,)``. `times`: times of samples.
    """
    values = output(times)
    sign = float(np.sign(values[np.argmax(np.abs(values))])) or 1.0
    value, time = refined_maximum(lambda t: sign * output(t), times, sign * values)
    return sign * value, time
