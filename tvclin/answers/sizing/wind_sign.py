"""What the sign of a wind along the path changes: the dynamic pressure that the vehicle meets.

A head wind raises the speed through the air, and with it normal and axial force; a tail wind lowers
it. Seen from the ground the vehicle has the speed V at the angle Theta_n above the horizontal, and
the horizontal wind that turns the path by alpha_w is

    w = V sin(alpha_w)/sin(Theta_n + alpha_w),
    q/q_n = ((V cos Theta_n - w)^2 + (V sin Theta_n)^2)/V^2.

All else is held, so that the condition of varying parameters (`sizing.varying`) says what the two
ask for. Speed and path of the vehicle itself hardly change within a wind.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from tvclin.answers.case import FROZEN, SIGNS, Case
from tvclin.answers.sizing.air_met import AirMet, denser_air, in_air, left_between, need_ratio
from tvclin.answers.sizing.collocation import mesh, refined
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, one_of
from tvclin.boundary.limit import (
    AFTER_TRIM,
    MINIMUM,
    boundary_alone,
    leading_pole,
    open_loop_needs,
)
from tvclin.linear.plant import Plant
from tvclin.numerics import pieces
from tvclin.vehicle.coefficients import PLANES
from tvclin.vehicle.linear_vehicle import whole_vehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.shaped import part_in

OWN = "own"
"""That of a wind whose angles have their sign already, as measured ones."""
_STEPS, _LONGEST, _BEFORE = 64, 500.0, 1.0 - 1e-6
"""Steps through the winds of a batch, at least; how long winds are followed, over the time of the
fastest rate; and the end of the last step, over the duration."""
_REACH, _FLOWN_REACH = 0.75, 0.25
"""How long each is at most, over the same; with K = 1 one line of a step has what is required."""
_CLOSE = 1e-9
"""Of the logarithm of a factor on the wind."""
_ROWS = 33
"""Times of a wind at which the parameters are tabulated, beside its knots."""
_NEAR = 0.8
"""Of the boundary: what slower modes ask for below that in calm air stays below it in any wind."""
_FINER = 17
"""Ends of steps in the one in which the dead band is left."""
_LEAST_RATE = 16.0
"""Of a `mesh` through the same, over their duration: 64 steps at least."""
_JUMP = 1e-6
"""A jump of the wind is a slope over this part of its duration."""


def own_sign(sign: str | None) -> bool:
    """Return whether measured winds count with their own sign; `InputError` for another one."""
    if isinstance(sign, str) and sign in SIGNS:
        raise InputError(f"measured winds have their own sign: leave sign, or take {FROZEN}")
    return sign is None or one_of("sign", sign, (FROZEN,)) != FROZEN


def pressure_ratio(vehicle: Vehicle, angle: FloatArray) -> FloatArray:
    """Return the dynamic pressure in winds along the path of angles [rad], over that in calm air.

    `InputError` where no horizontal wind turns the path so far: it would be level.
    """
    path = float(np.asarray(vehicle.attitude))
    found = pressure_ratios(path, angle)
    if np.any(np.isnan(found)):
        raise InputError(
            f"a wind of {np.degrees(np.abs(angle).max()):.4g} deg along the path has no sign for a"
            f" flight at {np.degrees(path):.4g} deg: no horizontal wind turns it so far"
        )
    return found


def pressure_ratios(path: ArrayLike, angle: FloatArray) -> FloatArray:
    """Return the same of flight path angles [rad]; NaN where no wind turns one so far."""
    path, level = np.asarray(path), np.sin(path) <= 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        wind = np.sin(angle) / np.sin(path + angle)  # over V
        found = (np.cos(path) - wind) ** 2 + np.sin(path) ** 2
    return np.where(level | (np.sin(path + angle) <= 0.0), np.nan, found)


def batch_factors(
    vehicle: Vehicle,
    model: str,
    plane: str,
    winds: History,
    dead_band: float,
    sign: str | None,
    along: History | None = None,
) -> FloatArray:
    """Return what vehicles need in winds by their sign, over what they need in calm air's.

    For each, ``(...)``: vehicles are frozen, winds one for each or one for all, and `along` the
    same in the pitch plane, for those in yaw. The sign is the one that counts, without it the worst
    of them, and `OWN` that of the winds themselves. One for a wind across the path, and where what
    its sign changes is not known.
    """
    along = winds if plane == "pitch" else along
    if along is None or sign == FROZEN:
        return np.ones(())
    plants = [Plant.from_vehicle(v, model, plane) for v in (vehicle, denser_air(vehicle))]
    met, path = AirMet.held(*plants), np.ravel(vehicle.attitude)[:, np.newaxis]
    given = np.sign(np.ravel(along.peak))[:, np.newaxis]
    turn = (
        1.0
        if sign == OWN
        else given * (SIGNS[sign] if sign in SIGNS else np.where(np.cos(path) < 0.0, 1.0, -1.0))
    )
    begin, length = np.ravel(winds.onset), np.ravel(winds.end) - np.ravel(winds.onset)
    fastest = np.ravel(np.abs(np.linalg.eigvals(plants[0].matrices()[0])).max(axis=-1))
    lasts = fastest * length  # in times of the fastest rate
    found = np.ones(np.broadcast_shapes(lasts.shape, given.shape[:1], path.shape[:1]))
    reach = _STEPS * (_FLOWN_REACH if dead_band == 1.0 else _REACH)
    steps = _STEPS * 2.0 ** np.ceil(np.log2(np.fmax(lasts / reach, 1.0)))
    steps = np.broadcast_to(np.where(lasts > _LONGEST, 0.0, steps), found.shape)
    for count in np.unique(steps[steps > 0.0]).tolist():
        parts = np.linspace(0.0, _BEFORE, 2 * int(count) + 1)
        times = begin[:, np.newaxis] + length[:, np.newaxis] * parts
        angle, turned = (
            np.real(pieces.value(one.pieces, times if one.batch else times[0]))
            for one in (winds, along)
        )
        ratio = pressure_ratios(path, turn * turned.reshape(-1, parts.size))
        some = np.flatnonzero(steps == count)
        rows = [
            one if len(one) == 1 else one[some]
            for one in (times, ratio, angle.reshape(-1, parts.size))
        ]
        found[some] = need_ratio(met.taken(some), rows[0], rows[1], rows[2], dead_band)[0]
    found = np.where(np.isnan(found), 1.0, found)
    return np.maximum(found, 1.0) if sign is None else found


def sign_factors(
    case: Case,
    wind: History,
    dead_band: float,
    sign: str | None = None,
    size: float = 1.0,
    calm: dict[str, float] | None = None,
) -> dict[str, float]:
    """Return what a wind needs by its sign along the path, over what it needs in calm air's.

    By `SIGNS`; empty for a wind across the path, and where nothing helps or is needed. `wind` is
    that of the case in its plane, with its gust, and `size` a factor on it; with a stop of both
    planes the factor is the larger one of the planes. `calm` is what the wind needs in the plane of
    the case in calm air, the `needs` of `required_deflection`, where that is known. `sign` is the
    one that counts, unless given that of the case; a wind with a direction has its own, and
    `InputError` is raised for another, and for a vehicle of which speed and attitude are not known,
    and as `signed_need`.
    """
    sign = case.sign if sign is None else sign
    if sign == FROZEN:
        return {}
    if sign is not None and case.heading is not None:
        raise InputError("a wind with a direction is a head or a tail wind by that: leave sign")
    along, winds = _met(case, wind, dead_band)
    if along is None:
        return {}
    known = {} if calm is None else {case.plane: calm}
    every = [
        _Signed.of(case, plane, one, along, dead_band, known.get(plane)) for plane, one in winds
    ]
    given, found = float(np.sign(along.peak)), {}
    for name in SIGNS if sign is None else (sign,):
        turn = SIGNS[name] * given
        if case.heading is None or turn > 0.0:
            found[name] = max(one.factor(turn * size) for one in every)
    return {} if 0.0 in found.values() else found


def largest_ratio(case: Case, wind: History, dead_band: float, size: float = 1.0) -> float:
    """Return the dynamic pressure at the peak of a head wind, over that in calm air.

    `wind` and `size` are as of `sign_factors`; one for a wind across the path, and `InputError` as
    that.
    """
    along = _met(case, wind, dead_band)[0]
    if along is None:
        return 1.0
    vehicle = whole_vehicle(case.vehicle, "the sign of a wind").rigid
    return float(pressure_ratio(vehicle, np.asarray(-size * abs(along.peak))))


def _met(
    case: Case, wind: History, dead_band: float
) -> tuple[History | None, list[tuple[str, History]]]:
    """The wind along the path in pitch, if there is one, and that in each plane that is judged."""
    if case.heading is None:
        return (wind if case.plane == "pitch" else None), [(case.plane, wind)]
    blows = case.wind_at(dead_band)
    whole = whole_vehicle(case.vehicle, "a wind with a direction")
    peaks = blows.peaks(float(np.asarray(whole.attitude)))
    parts = {plane: part_in(blows, peaks, plane) for plane in PLANES if peaks[plane]}
    judged = [(case.plane, wind)] if case.nozzle.stop is None else list(parts.items())
    return parts.get("pitch"), judged


@dataclass(frozen=True, eq=False)
class _Signed:
    """A wind in one plane, that along the path, and what it needs in calm air [rad].

    `fast` is the boundary, and `slow` what all growing modes need, for dead bands below 1. Where
    two modes are a pair, `paired`, trim must never be limited.
    """

    vehicle: Vehicle
    model: str
    plane: str
    dead_band: float
    wind: History
    along: History
    fast: float
    slow: float
    paired: bool

    @classmethod
    def of(
        cls,
        case: Case,
        plane: str,
        wind: History,
        along: History,
        dead_band: float,
        calm: dict[str, float] | None,
    ) -> _Signed:
        vehicle = whole_vehicle(case.vehicle, "the sign of a wind").rigid
        plant = Plant.from_vehicle(vehicle, case.model, plane)
        boundary = boundary_alone(plant, wind, dead_band, True)[0]
        slow = 0.0
        if dead_band < 1.0:
            needs = calm or open_loop_needs(plant, wind, np.asarray(dead_band), boundary)
            slow = max(float(needs[MINIMUM]), float(needs[AFTER_TRIM]))
        fast = abs(float(boundary.deflection))
        paired = bool(leading_pole(plant)[1])
        return cls(vehicle, case.model, plane, dead_band, wind, along, fast, slow, paired)

    def factor(self, size: float) -> float:
        """Return the factor in so many times these winds; zero where none counts."""
        if self.fast == 0.0 or not np.isfinite(self.fast):
            return 0.0
        if self.paired:
            return self._over_all_modes(size)
        of = self.vehicle, self.wind * size, self.model, self.dead_band
        need = signed_need(*of, plane=self.plane, along=self.along * size)
        counts = self.slow >= _NEAR * self.fast
        if not (np.isfinite(need) or counts):
            raise InputError("with this dead band no limit is enough")
        fast = need / (max(self.fast, self.slow) * abs(size)) if np.isfinite(need) else 0.0
        return max(fast, self._over_all_modes(size)) if counts else fast

    def _over_all_modes(self, size: float) -> float:
        """The factor by `need_ratio`, to some 1e-4."""
        plants = [
            Plant.from_vehicle(v, self.model, self.plane)
            for v in (self.vehicle, denser_air(self.vehicle))
        ]
        bends = np.concatenate([_bends(self.wind), _bends(self.along)])
        bends = np.unique(np.clip(bends, self.wind.onset, self.wind.end))
        ends = mesh(bends, max(float(leading_pole(plants[0])[0]), _LEAST_RATE / np.ptp(bends)))
        met = AirMet.held(*plants)

        def on(ends: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
            times = refined(ends, np.full(ends.size - 1, 2.0))
            ratio = pressure_ratio(self.vehicle, self.along(times) * size)
            return times[np.newaxis], ratio[np.newaxis], self.wind(times)[np.newaxis]

        if 0.0 < self.dead_band < 1.0 and not self.paired:  # finer where the dead band is left
            times, ratio, angle = on(ends)
            for air in (np.ones(times.shape), ratio):
                low, high = left_between(met, times, air, angle, self.dead_band)[:, 0].tolist()
                ends = np.unique(np.append(ends, np.linspace(low, high, _FINER)))
        return float(need_ratio(met, *on(ends), self.dead_band)[0, 0])


def survived_size(limit: float, need: Callable[[float], float]) -> float:
    """Return the factor on a wind at which its need, which is no multiple of it, is the limit."""
    from scipy.optimize import brentq

    @cache
    def over(x: float) -> float:
        value = float(np.log(need(float(np.exp(x))) / limit))
        return 1.0 if np.isinf(value) else value  # where no wind turns the path so far

    first = -over(0.0)
    if abs(first) < _CLOSE:
        return 1.0
    end = first if over(first) * first > 0.0 else 2.0 * first  # a tail wind needs less than so much
    while first < 0.0 < over(end):
        end *= 2.0
    if over(end) < 0.0 < first:
        return float(np.exp(end))
    return float(np.exp(brentq(over, 0.0, end, xtol=_CLOSE) - _CLOSE))  # survived, not nearly so


def signed_need(
    vehicle: Vehicle,
    wind: History,
    model: str,
    dead_band: float,
    *,
    plane: str = "pitch",
    along: History | None = None,
) -> float:
    """Return what a control needs [rad] in a wind with its sign along the path, as a size.

    The wind has one sign, in the pitch plane positive from behind; `along` is the same in that
    plane, for one in yaw. As in a flight trim leaves the dead band. `InputError` as
    `pressure_ratio` and `varying_need`.
    """
    from tvclin.answers.sizing.growing import GrowingMode
    from tvclin.answers.sizing.schedule import FlightSchedule
    from tvclin.answers.sizing.varying import varying_need

    begin, end = float(wind.onset), float(wind.end)
    times = np.unique(np.concatenate([np.linspace(begin, end, _ROWS), _bends(wind)]))
    ratio = pressure_ratio(vehicle, (wind if along is None else along)(times))
    met = in_air(vehicle, ratio).replace(time=times)
    mode = GrowingMode(FlightSchedule(met), model, plane, (begin, end))
    return float(varying_need(mode, wind, np.array([dead_band])).required[0])


def _bends(wind: History) -> FloatArray:
    """The knots [s] of a wind while it blows, and times just before its jumps."""
    begin, end = float(wind.onset), float(wind.end)
    knots = wind.knots[(wind.knots > begin) & (wind.knots <= end)]
    before = knots - _JUMP * (end - begin)
    jumps = np.abs(wind(knots) - wind(before)) > np.sqrt(_JUMP) * abs(float(wind.peak))
    return np.unique(np.concatenate([[begin], knots, before[jumps]]))
