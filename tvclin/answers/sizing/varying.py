"""What a wind asks of a vehicle whose parameters vary while it blows.

Held from the time a on, after trim, the limit that brings the growing part to zero is

    delta_max(a) = -(l.x(a) + future(a))/reach(a),

with the state x that trim has left, the wind still to come in units of the growing part, and the
reach of a unit deflection. With constant parameters it is the demand behind `boundary_limit`.

It is the mean, weighted by p.b, of all trim that is still to come. A law that trims up to a limit L
and lets go of it when the attitude is back is lost in the end only if at some time both

    trim(t) > L    and    delta_max(t) > L.

For the limit is met for the last time at a time t with trim above it, and it does not bring the
attitude back if delta_max is above it then. So the largest min(trim, delta_max) of all times is
enough, for winds of both signs on either side. On a fixed path a wind of one sign asks for no less;
one that comes from the other side may, for it finds the attitude off to that side. With drift the
path that a limited flight leaves is not that of trim: a law that meets its limit again, or whose
path is quick, is flown (`flown`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from tvclin.answers.sizing.air_met import flight_ratio
from tvclin.answers.sizing.collocation import mesh, solved
from tvclin.answers.sizing.flown import flight_steps, trim_law_needs
from tvclin.answers.sizing.growing import GrowingMode
from tvclin.answers.trim_flown import path_counts
from tvclin.base.arrays import FloatArray
from tvclin.boundary.limit import leading_pole
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History

_BETWEEN = 16
_LOOKS = 17
"""Times of a wind at which the pace of the path is looked at."""
_SLACK = 1e-9
_LEAST = 1e-6
"""Of the largest: what is less to the other side is none."""


@dataclass(frozen=True, eq=False)
class VaryingNeed:
    """Deflections [rad] that one wind asks of a vehicle along its flight.

    `trim` is the largest |B(t) alpha_w(t)|, without drift; `required` what the control needs at
    each dead band, ``(k,)``: for K = 1 of a law that lets go, for the others what (4b) asks for;
    NaN for a wind that changes its sign. `minimum` is the least peak that leaves nothing of the
    fastest growing part, the whole wind being known. `trim_time` is the flight time [s] of the
    largest trim, and `times` those at which the dead bands are left with the required limits,
    ``(k,)``.
    """

    trim: float
    required: FloatArray
    minimum: float
    trim_time: float
    times: FloatArray


def varying_need(
    mode: GrowingMode, wind: History, dead_bands: FloatArray, whole: History | None = None
) -> VaryingNeed:
    """Return what a wind, within the span of `mode`, asks of a vehicle whose parameters vary.

    The dead band is left when the trim deflection reaches K times the limit, as in a flight.
    `whole` is the wind with what blows to the other side, where `wind` is its part to one: a law
    with K = 1 meets both.
    """
    times = _times(wind)
    course = _Course.of(mode, wind)
    moment = mode.trim_per_wind(times) * wind(times)
    trim = np.abs(moment)
    minimum = abs(float(course.future(wind.onset) / mode.farthest(wind.onset)))
    side = -float(np.sign(moment[np.argmax(trim)]))
    blows = -side * moment
    required = exits = np.full(dead_bands.shape, np.nan)
    if not np.any(blows < -_LEAST * trim.max()):
        driver = side * course.trim(times)
        required, exits = np.transpose(
            [_boundary(course, times, driver, side, K) for K in dead_bands]
        )
        paired = leading_pole(_held(mode, times))[1]  # there the dead band must never be left
        inside = np.where(paired, driver, 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            kept = inside.max() / dead_bands
        longer = (dead_bands < 1.0) & ((kept > required) | np.isnan(required))
        exits = np.where(longer, times[np.argmax(inside)], exits)
        required = np.where(longer, np.fmax(required, kept), required)
        flown, most = _flown(course, times, (side,)), np.abs(driver).max()
        if whole is not None:
            both, at = _Course.of(mode, whole), _times(whole)
            flown = max(flown, _flown(both, at, (side, -side)))
            most = max(most, np.abs(both.trim(at)).max())
        larger = (dead_bands == 1.0) & (flown[0] > required)
        required = np.where(larger, flown[0], required)
        exits = np.where(larger, flown[1], exits)
        with np.errstate(divide="ignore"):  # so large a limit is never met
            required = np.minimum(required, most / dead_bands)
    return VaryingNeed(float(trim.max()), required, minimum, float(times[np.argmax(trim)]), exits)


def need_in_parts(
    mode: GrowingMode,
    wind: History,
    dead_bands: FloatArray,
    whole: History | None = None,
    pressure: tuple[FloatArray, FloatArray] | None = None,
) -> VaryingNeed:
    """Return `varying_need` in the dynamic pressure that is met, as of `flight_ratio`, or calm air.

    Where the wind turns the vehicle to both sides of a flight it requires the most that it does in
    one of the `FlightSchedule.parts`.
    """

    def in_air(flight: GrowingMode, blows: History, calm: VaryingNeed) -> FloatArray:
        if pressure is None:
            return calm.required
        return calm.required * flight_ratio(flight, blows, pressure, dead_bands)

    found, parts = varying_need(mode, wind, dead_bands, whole), mode.schedule.parts
    if len(parts) == 1 or not np.any(np.isnan(found.required)):
        return replace(found, required=in_air(mode, wind, found))
    ends = [mode.span[0], *(part.span[0] for part in parts[1:]), mode.span[1]]
    most, exits = np.zeros(dead_bands.shape), np.full(dead_bands.shape, found.trim_time)
    for part, (start, stop) in zip(parts, pairwise(ends), strict=True):
        alone = GrowingMode(part, mode.model, mode.plane, (start, stop))
        blows, both = (
            None if one is None else one.before(stop) - one.before(start) for one in (wind, whole)
        )
        if alone.grows and blows is not None and np.any(blows(blows.probe_times())):
            calm = varying_need(alone, blows, dead_bands, both)
            required = in_air(alone, blows, calm)
            exits = np.where(required > most, calm.times, exits)
            most = np.maximum(most, required)
    return replace(found, required=most, times=exits)


def _times(wind: History) -> FloatArray:
    """Return the times at which a wind is looked at while it blows."""
    times = np.unique(wind.probe_times(_BETWEEN))
    return np.asarray(times[(times >= wind.onset) & (times < wind.end)])


def _flown(course: _Course, times: FloatArray, sides: tuple[float, ...]) -> tuple[float, float]:
    """The largest min(trim, demand) [rad] to a side, and its time [s]: a given one or a crossing.

    Where trim is above it more than once and the path drifts, or drifts fast, the law is flown.
    """
    from scipy.optimize import brentq

    trim, demand = course.trim(times), course.demand(times)

    def over(t: float) -> float:
        return float(course.trim(t) - course.demand(t))

    mode = course.mode
    paired = leading_pole(_held(mode, times))[1]  # there trim must never be limited
    both = [np.where(paired, s * trim, np.minimum(s * trim, s * demand)) for s in sides]
    most = float(np.max(both))
    when = float(times[np.argmax(np.max(both, axis=0))])
    turns = np.flatnonzero((trim[:-1] - demand[:-1]) * (trim[1:] - demand[1:]) < 0.0)
    for k in turns.tolist():
        ends = np.stack([trim[k : k + 2], demand[k : k + 2]])
        if max(np.max(side * ends, axis=-1).min() for side in sides) > most:
            meets = brentq(over, float(times[k]), float(times[k + 1]), xtol=1e-12)
            crossing = max(side * float(course.demand(meets)) for side in sides)
            if crossing > most:
                most, when = crossing, meets
    above = np.abs(trim) > most
    again = above[0] + np.sum(above[1:] & ~above[:-1]) > 1
    if mode.model == "fixed-path" or not (again or _drifts_fast(mode, times)):
        return most, when
    steps = flight_steps(mode, (float(course.wind.onset), float(course.wind.end)))
    return float(trim_law_needs(mode, steps, course.wind(steps)[np.newaxis], most)[0]), when


def _drifts_fast(mode: GrowingMode, times: FloatArray) -> bool:
    return bool(np.any(path_counts(_held(mode, np.linspace(times[0], times[-1], _LOOKS)))))


def _held(mode: GrowingMode, times: FloatArray) -> Plant:
    """The plants with the parameters of these times."""
    return mode.schedule.plants(times, mode.model, mode.plane)


def _boundary(
    course: _Course, times: FloatArray, driver: FloatArray, side: float, K: float
) -> tuple[float, float]:
    """The limit that just suffices when it is held from the exit of the dead band on, and its time.

    As in `switching`: only new heights of the driver leave it, and of several solutions the last
    has the largest limit.
    """
    from scipy.optimize import brentq

    if K == 0.0:
        return side * float(course.demand(times[0])), float(times[0])
    highest = np.maximum.accumulate(driver)
    new = np.flatnonzero((driver >= highest * (1.0 - _SLACK)) & (driver > 0.0))
    demands = side * course.demand(times[new])
    short = np.flatnonzero(driver[new] < K * demands)
    last = int(short[-1]) if short.size else -1
    if last + 1 == new.size:
        return max(float(highest[-1]) / K, float(driver.max())), float(times[np.argmax(driver)])
    begins = K * side * float(course.demand(times[0]))
    if last < 0 and (new[0] == 0 or driver[0] >= begins):
        return float(demands[0]), float(times[new[0]])
    before = 0 if last < 0 else int(new[last])
    floor, low, high = (
        max(float(driver[before]), 0.0),
        *(float(times[i]) for i in (before, new[last + 1])),
    )

    def over(t: float) -> float:
        return max(side * float(course.trim(t)), floor) - K * side * float(course.demand(t))

    leaves = brentq(over, low, high, xtol=1e-12)
    return side * float(course.demand(leaves)), leaves


@dataclass(frozen=True, eq=False)
class _Course:
    """One wind over one flight: the state under ideal trim, and the wind still to come."""

    mode: GrowingMode
    wind: History
    drifted: Callable[[ArrayLike], FloatArray]
    future: Callable[[ArrayLike], FloatArray]

    @classmethod
    def of(cls, mode: GrowingMode, wind: History) -> _Course:
        begin, end = float(wind.onset), float(wind.end)
        bends = np.concatenate([wind.knots, mode.bends, [begin, end]])
        bends = np.unique(bends[(bends >= begin) & (bends <= end)])
        times = mesh(bends, max(mode.quickest, float(np.abs(wind.pieces.rates).max())))
        size = mode.matrices(begin)[0].shape[-1] - 2

        def drift(t: FloatArray) -> tuple[FloatArray, FloatArray]:
            F, c = mode.under_trim(t)
            return F, c * wind(t)[:, np.newaxis, np.newaxis]

        def ahead(t: FloatArray) -> tuple[FloatArray, FloatArray]:
            row, _ = mode.at(t)
            driven = np.einsum("nt,tn->t", row, mode.matrices(t)[1][..., 1]) * wind(t)
            return mode.rate(t)[:, np.newaxis, np.newaxis], -driven[:, np.newaxis, np.newaxis]

        path = solved(drift, times, np.zeros((size, 1)))
        rest = solved(ahead, times, np.zeros((1, 1)), backwards=True)
        return cls(
            mode, wind, lambda t: np.moveaxis(path(t)[..., 0], -1, 0), lambda t: rest(t)[..., 0, 0]
        )

    def demand(self, t: ArrayLike) -> FloatArray:
        """The limit [rad], with its sign, that is enough when it is held from t on."""
        row, reach = self.mode.at(t)
        kept = np.sum(row[2:] * self.drifted(t), axis=0)
        return np.asarray(-(kept + self.future(t)) / reach)

    def trim(self, t: ArrayLike) -> FloatArray:
        """The deflection of ideal trim [rad]."""
        A, inputs = self.mode.matrices(t)
        kept = np.vecdot(A[..., 1, 2:], np.moveaxis(self.drifted(t), 0, -1))
        return np.asarray(-(kept + inputs[..., 1, 1] * self.wind(t)) / inputs[..., 1, 0])
