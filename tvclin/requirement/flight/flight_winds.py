"""Winds in a flight: their place, and the trim of those that are fixed to flight times.

A pulse has its peak at a flight time; a sounding is a window of flight time. A sounding encounters
the vehicle of each height with the wind of that height: trim takes ``|B(t) alpha_w(t)|``, and not
the largest angle of the flight with the B of another time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.ascent.measured_wind import MeasuredPlanes, MeasuredWind, SoundingSpeeds, gust_at
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.errors import InputError, NotKnownError, instance, number, one_of, positive
from tvclin.boundary.limit_shapes import LimitShape
from tvclin.vehicle.coefficients import BOTH, PLANES, Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.pulses import TriangularWind
from tvclin.winds.wind_angles import checked_linear

PLACINGS = ("peak", "flight")
PEAK = PLACINGS[0]

WindOf = History | PlaneWind | MeasuredPlanes | Callable[[Vehicle], History | PlaneWind]
"""A wind, or a function from a vehicle to its wind: a wind speed has another angle for each."""

_TOP = 1.0 - 1e-12
"""Fraction of the peak above which a wind is at its top, which may be flat."""


@dataclass(frozen=True, eq=False)
class PlacedWind:
    """A wind in a flight: in its own time, whose zero is at a flight time [s].

    An unknown wind is represented by a calm; `why` says the reason, unless a sounding ends. `fixed`
    says whether all flight times have this same wind, such as a sounding without a window. `whole`
    is a wind of both signs, of which `history` has the larger one; `speeds` the wind of
    both planes, where it is that of a sounding.
    """

    history: History
    zero: float
    known: bool = True
    why: str = ""
    fixed: bool = False
    whole: History | None = None
    speeds: SoundingSpeeds | None = None

    @property
    def calm(self) -> bool:
        """Whether the wind is zero."""
        return not np.isfinite(self.history.onset)

    @property
    def span(self) -> tuple[float, float]:
        """Flight time [s] at which it begins and ends."""
        return float(self.history.onset) + self.zero, float(self.history.end) + self.zero

    @property
    def in_flight(self) -> History:
        """The wind in flight time."""
        return self.history.shift(self.zero)


def named_winds(winds: WindOf | Mapping[str, WindOf]) -> dict[str, WindOf]:
    """Return winds by name; a single one is called "wind". `InputError` if there is none."""
    by_name = dict(winds) if isinstance(winds, Mapping) else {"wind": winds}
    if not by_name:
        raise InputError("winds must hold one wind or more; got none")
    return by_name


def placings(winds: Mapping[str, WindOf], placing: str | Mapping[str, str]) -> dict[str, str]:
    """Return the placing of each wind by its name; `InputError` for unknown ones."""
    if isinstance(placing, str):
        return dict.fromkeys(winds, one_of("placing", placing, PLACINGS))
    instance("placing", placing, Mapping, "of names to peak or flight, or one of these")
    for name, value in placing.items():
        one_of("placing's winds", name, winds)
        one_of(f"placing of {name}", value, PLACINGS)
    return {name: placing.get(name, PEAK) for name in winds}


def place(wind: WindOf, vehicle: Vehicle, time: float, placing: str, window: float) -> PlacedWind:
    """Return a wind placed at a flight time [s] of a vehicle; a measured wind is placed already.

    With "peak" its peak is moved to that time (the middle of a flat top); with "flight" it is in
    flight time, and the part within half a window [s] counts. `InputError` for a batch of winds,
    and a wind that never ends or is zero; `NotKnownError` from a function that gives the wind.
    """
    if isinstance(wind, MeasuredWind):
        first, last = wind.known
        if not first <= time <= last:
            return PlacedWind(wind.wind * 0.0, 0.0, known=False)
        signed = wind.to_both_sides(vehicle)
        values = signed(signed.probe_times())
        two_sided = values.min() < 0.0 < values.max()
        return PlacedWind(
            wind(vehicle),
            0.0,
            fixed=wind.window is None and wind.gust is None,
            whole=signed if two_sided else None,
            speeds=wind.speeds,
        )
    history = given(wind, vehicle)
    if not isinstance(history, History) or history.batch:
        raise InputError(
            "each wind must be one history, such as TriangularWind, or give one; a PlaneWind needs"
            f" plane={BOTH!r}"
            if isinstance(history, PlaneWind)
            else "each wind must be one history, such as TriangularWind, or give one"
        )
    _ends(history)
    if placing == PEAK:
        return PlacedWind(history, time - _middle_of_the_top(history, history.probe_times()))
    half = 0.5 * number("window", window, positive, "s")
    return PlacedWind(history.before(time + half) - history.before(time - half), 0.0)


def place_in(
    planes: tuple[str, ...],
    wind: WindOf,
    vehicle: Vehicle,
    time: float,
    placing: str,
    window: float,
) -> dict[str, PlacedWind]:
    """Return a wind placed at a flight time, by planes; in both planes its vector is placed.

    A wind of more than `MAX_LINEAR_ANGLE`, or with a `NotKnownError` at this time, is placed as an
    unknown one. `InputError` for the reasons of `place`, and in both planes for a wind without a
    direction.
    """
    try:
        if len(planes) == 1:
            placed = {planes[0]: place(wind, vehicle, time, placing, window)}
        else:
            placed = _in_both(wind, vehicle, time, placing, window)
        checked_linear(peak_angle(placed))
        return placed
    except NotKnownError as error:
        none = TriangularWind(peak=1.0, duration=1.0) * 0.0
        return dict.fromkeys(planes, PlacedWind(none, 0.0, known=False, why=str(error)))


def peak_angle(placed: Mapping[str, PlacedWind]) -> float:
    """Return the largest size [rad] of the wind angle, of both planes of its vector."""
    winds = {plane: one.history for plane, one in placed.items() if not one.calm}
    if len(winds) < len(PLANES):
        return max((abs(float(one.peak)) for one in winds.values()), default=0.0)
    return float(PlaneWind(**winds).peak)


def angle_at(placed: Mapping[str, PlacedWind], time: float) -> float:
    """Return the wind angle [rad] of a placed wind at a flight time [s], a size."""
    angles = [float(one.history(time - one.zero)) for one in placed.values()]
    return float(np.linalg.norm(angles))


def _in_both(
    wind: WindOf, vehicle: Vehicle, time: float, placing: str, window: float
) -> dict[str, PlacedWind]:
    if isinstance(wind, MeasuredPlanes):
        measured = {plane: wind.part(plane, vehicle) for plane in PLANES}
        calm = next(one for one in measured.values() if one is not None).wind * 0.0
        first, last = wind.known
        return {
            plane: PlacedWind(calm, 0.0, known=first <= time <= last)
            if one is None
            else place(one, vehicle, time, placing, window)
            for plane, one in measured.items()
        }
    vector = given(wind, vehicle)
    if not isinstance(vector, PlaneWind) or vector.batch:
        raise InputError(
            "for both planes each wind must have a direction: give one PlaneWind (see"
            f" PlaneWind.towards), what gives one, or fly_through with plane={BOTH!r}"
        )
    _ends(vector)
    parts = {plane: getattr(vector, plane) for plane in PLANES}
    if placing == PEAK:
        shown = np.union1d(vector.pitch.probe_times(), vector.yaw.probe_times())
        zero = time - _middle_of_the_top(vector, shown)
        return {plane: PlacedWind(one, zero) for plane, one in parts.items()}
    return {
        plane: place(one, vehicle, time, placing, window)
        if np.isfinite(one.onset)
        else PlacedWind(one, 0.0)
        for plane, one in parts.items()
    }


def given(wind: Any, vehicle: Vehicle) -> Any:
    """Return the wind of a vehicle, which may be given as a function of it."""
    made = callable(wind) and not isinstance(wind, History | PlaneWind)
    return wind(vehicle) if made else wind


def _ends(wind: History | PlaneWind) -> None:
    if not np.isfinite(wind.end):
        raise InputError("each wind must end, and be other than zero")


def _middle_of_the_top(wind: History | PlaneWind, times: FloatArray) -> float:
    values = np.abs(wind(times))
    top = times[values >= _TOP * values.max()]
    return 0.5 * float(top[0] + top[-1])


_TIMES_IN_INTERVAL = 33
"""Even times between two flight times, besides the samples, at which B alpha_w is evaluated."""


@dataclass(frozen=True, eq=False)
class ConcurrentTrim:
    """Largest trim ``|B(t) alpha_w(t)|`` of the times nearest to each flight time.

    `deflection` is that trim [rad], its gust included, and `time` its flight time [s], both
    ``(n, m)``; NaN for a wind whose peak is moved to the flight time, and where the wind is not
    known. For both planes the deflection is in the measure of the stop.
    """

    deflection: FloatArray
    time: FloatArray


def concurrent_trim(
    schedule: FlightSchedule,
    times: FloatArray,
    winds: Mapping[str, WindOf],
    placing: Mapping[str, str],
    planes: tuple[str, ...],
    stop: LimitShape,
    known: BoolArray,
) -> ConcurrentTrim:
    """Return the concurrent trim [rad] of winds at flight times [s], ``(n, m)``.

    `known` says where a wind can be sized, ``(n, m)``: where it cannot although it blows, as beyond
    linear aerodynamics, its trim is NaN.
    """
    ordered = np.sort(times)
    edges = np.concatenate([ordered[:1], 0.5 * (ordered[1:] + ordered[:-1]), ordered[-1:]])
    found = np.full((times.size, len(winds), 2), np.nan)
    for j, (name, wind) in enumerate(winds.items()):
        first, last = -np.inf, np.inf
        if isinstance(wind, MeasuredWind | MeasuredPlanes):
            first, last = wind.known
        elif placing[name] == PEAK:
            continue
        for i, k in enumerate(np.argsort(np.argsort(times)).tolist()):
            low, high = max(edges[k], first), min(edges[k + 1], last)
            steep = not known[i, j] and first <= times[i] <= last
            if low <= high and not steep:
                vehicle = schedule.at(float(times[i]))
                found[i, j] = _largest(schedule, wind, vehicle, planes, stop, (low, high))
    return ConcurrentTrim(found[..., 0], found[..., 1])


def _largest(
    schedule: FlightSchedule,
    wind: WindOf,
    vehicle: Vehicle,
    planes: tuple[str, ...],
    stop: LimitShape,
    interval: tuple[float, float],
) -> tuple[float, float]:
    """Return the largest trim [rad] of an interval of the flight, and its time [s]."""
    low, high = interval
    parts = {plane: _in_plane(wind, plane, vehicle) for plane in planes}
    samples = [schedule.times, *(one.probe_times() for one in parts.values() if one is not None)]
    bends = np.concatenate(samples)
    even = np.linspace(low, high, _TIMES_IN_INTERVAL)
    t = np.unique(np.concatenate([even, bends[(bends > low) & (bends < high)]]))
    held = schedule.clamped_at(t)
    slopes = {plane: np.asarray(Coefficients.from_vehicle(held, plane).B) for plane in planes}
    moments = [
        slopes[plane] * (0.0 if one is None else one(t)) + np.zeros(t.shape)
        for plane, one in parts.items()
    ]
    trim = np.abs(moments[0]) if len(moments) == 1 else stop.gauge(moments[0] + 1j * moments[1])
    trim = trim + np.max([np.abs(one) for one in slopes.values()], axis=0) * _gust(wind, vehicle)
    most = int(np.argmax(trim))
    return float(trim[most]), float(t[most])


def _in_plane(wind: Any, plane: str, vehicle: Vehicle) -> History | None:
    """Return the wind in one plane in flight time, without its gust; None where it is calm."""
    if isinstance(wind, MeasuredPlanes):
        part = wind.parts.get(plane)
        return None if part is None else part.wind
    if isinstance(wind, MeasuredWind):
        return wind.wind
    history = given(wind, vehicle)
    found: History = getattr(history, plane) if isinstance(history, PlaneWind) else history
    return found


def _gust(wind: Any, vehicle: Vehicle) -> float:
    """Return the peak angle [rad] of the gust of a measured wind; NaN where it is not known."""
    gust = getattr(wind, "gust", None)
    if gust is None:
        return 0.0
    try:
        return abs(float(gust_at(gust, vehicle).peak))
    except NotKnownError:
        return float("nan")
