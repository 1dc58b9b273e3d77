"""Winds placed in a flight, and the trim of winds that are fixed in flight time.

A pulse has its peak at a flight time; a sounding is a window of flight time. A sounding encounters
the vehicle of each height with the wind of that height: trim is ``|B(t) alpha_w(t)|``, and not
the product of the largest angle of the flight and the B of another time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.ascent.measured_wind import MeasuredPlanes, MeasuredWind, SoundingSpeeds, gust_at
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.errors import InputError, NotKnownError, instance, number, one_of, positive
from tvclin.boundary.limit_shapes import LimitShape
from tvclin.vehicle.coefficients import BOTH, PLANES, Coefficients
from tvclin.vehicle.vehicle import Vehicle, at_pressure
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.pulses import TriangularWind
from tvclin.winds.wind_angles import FROZEN, SIGNS, checked_linear, pressure_ratio

PLACINGS = ("peak", "flight")
PEAK = PLACINGS[0]
_WINDOW_S = 20.0
"""Default length of the interval about a flight time in which a wind in flight time counts [s]."""

WindOf = History | PlaneWind | MeasuredPlanes | Callable[[Vehicle], History | PlaneWind]
"""A wind, or a function from a vehicle to its wind, as for a wind speed."""

_PEAK_FRACTION = 1.0 - 1e-12
"""Fraction of the peak above which a wind counts as at its peak, which may be flat."""


@dataclass(frozen=True, eq=False)
class PlacedWind:
    """A wind in a flight: a history in its own time, whose zero is at the flight time `zero` [s].

    An unknown wind is represented by a calm; `why` is the reason, unless a sounding ends. `fixed`
    says whether all flight times have this same wind, such as a sounding without a window.
    `two_sided` is the wind where its angles change sign: `history` then has the angles of the
    larger sign alone. `speeds`: the wind of both planes, for a sounding.
    """

    history: History
    zero: float
    known: bool = True
    why: str = ""
    fixed: bool = False
    two_sided: History | None = None
    speeds: SoundingSpeeds | None = None

    @property
    def calm(self) -> bool:
        """Whether the wind is zero."""
        return not np.isfinite(self.history.onset)

    @property
    def span(self) -> tuple[float, float]:
        """Flight times [s] at which the wind begins and ends."""
        return float(self.history.onset) + self.zero, float(self.history.end) + self.zero

    @property
    def in_flight(self) -> History:
        """The wind in flight time."""
        return self.history.shift(self.zero)


def named_winds(winds: WindOf | Mapping[str, WindOf]) -> dict[str, WindOf]:
    """Return winds by name; a single wind is called "wind". `InputError` without any wind."""
    by_name = dict(winds) if isinstance(winds, Mapping) else {"wind": winds}
    if not by_name:
        raise InputError("winds must hold one wind or more; got none")
    return by_name


def placings(winds: Mapping[str, WindOf], placing: str | Mapping[str, str]) -> dict[str, str]:
    """Return the placing of each wind by name; `InputError` for an unknown placing."""
    if isinstance(placing, str):
        return dict.fromkeys(winds, one_of("placing", placing, PLACINGS))
    instance("placing", placing, Mapping, "of names to peak or flight, or one of these")
    for name, value in placing.items():
        one_of("placing's winds", name, winds)
        one_of(f"placing of {name}", value, PLACINGS)
    return {name: placing.get(name, PEAK) for name in winds}


def place(
    wind: WindOf, vehicle: Vehicle, time: float, placing: str = PEAK, window: float = _WINDOW_S
) -> PlacedWind:
    """Return a wind placed at a flight time [s] of a vehicle; a measured wind keeps its time.

    A measured wind has a gust about that time, if it has one, and is unknown where the sounding
    does not reach. With the `placing` "peak" the peak (the middle of a flat top) is moved to that
    time; with "flight" the wind is in flight time, and counts within half a window [s].
    `zero`: flight time of the wind's own zero [s]. `InputError` for a batch of winds, and a wind
    that never ends or is zero; `NotKnownError` from a function that gives the wind.
    """
    if isinstance(wind, MeasuredWind):  # in flight time: its zero is the flight time zero
        first, last = wind.known
        if not first <= time <= last:
            return PlacedWind(wind.wind * 0.0, zero=0.0, known=False)
        # `wind(vehicle)` has the angles of one sign, `signed` those of both (`two_sided`). Without
        # window and gust the wind is the same at all flight times (`fixed`).
        signed = wind.of_both_signs(vehicle)
        values = signed(signed.probe_times())
        changes_sign = values.min() < 0.0 < values.max()
        return PlacedWind(
            wind(vehicle),
            zero=0.0,
            fixed=wind.window is None and wind.gust is None,
            two_sided=signed if changes_sign else None,
            speeds=wind.speeds,
        )
    history = wind_of(wind, vehicle)
    if not isinstance(history, History) or history.batch:
        hint = f"; a PlaneWind needs plane={BOTH!r}" if isinstance(history, PlaneWind) else ""
        raise InputError(
            f"each wind must be one history, such as TriangularWind, or give one{hint}"
        )
    _check_end(history)
    if placing == PEAK:
        peak_time = _middle_of_peak(history, history.probe_times())
        return PlacedWind(history, zero=time - peak_time)
    half = 0.5 * number("window", window, positive, "s")
    in_window = history.before(time + half) - history.before(time - half)
    return PlacedWind(in_window, zero=0.0)


def placed_in_planes(
    planes: tuple[str, ...],
    wind: WindOf,
    vehicle: Vehicle,
    time: float,
    placing: str = PEAK,
    window: float = _WINDOW_S,
) -> dict[str, PlacedWind]:
    """Return a wind placed at a flight time [s], by planes; in both planes its vector is placed.

    `vehicle`: vehicle at this time. `placing`: "peak" for a wind whose peak is moved to this time,
    "flight" for a wind in flight time, which counts within half a `window` [s] of it. A wind of
    more than 30 deg, or with a `NotKnownError` at this time, counts as unknown: a calm with the
    reason. Same exceptions as `place`; in both planes also for a wind without a direction.
    """
    try:
        if len(planes) == 1:
            placed = {planes[0]: place(wind, vehicle, time, placing, window)}
        else:
            placed = place_vector(wind, vehicle, time, placing, window)
        winds = {plane: x.history for plane, x in placed.items() if not x.calm}
        # in both planes the angle of the vector
        whole = [PlaneWind(**winds)] if len(winds) == len(PLANES) else winds.values()
        checked_linear(max((abs(float(wind.peak)) for wind in whole), default=0.0))
        return placed
    except NotKnownError as error:
        calm = TriangularWind(peak=1.0, duration=1.0) * 0.0
        return dict.fromkeys(planes, PlacedWind(calm, zero=0.0, known=False, why=str(error)))


def encountered_winds(
    vehicle: Vehicle,
    placed: PlacedWind,
    planes: Mapping[str, PlacedWind],
    sign: str | None,
    *,
    signed: bool,
    interval: FloatArray | None = None,
) -> Iterator[tuple[str, Vehicle, History]]:
    """Yield the direction of a wind, the vehicle at its largest dynamic pressure, and the wind.

    The direction is "head" or "tail" for a wind that may be either (`signed`), of which each is
    yielded unless `sign` selects one; else empty. The wind [rad] is in flight time. `placed`: the
    wind in one plane. `planes`: the placed wind of each plane; pitch sets the dynamic pressure.
    `sign`: head, tail or frozen (nominal pressure), of the case. `interval`: first and last flight
    time [s] of a measured wind, which has the dynamic pressure of its own speeds.
    """
    wind = (placed.two_sided or placed.history).shift(placed.zero)
    if interval is not None:
        ratio = 1.0
        if placed.speeds is not None:  # q/q_n of the sounding at its times, linear between them
            times, ratios = placed.speeds.time, placed.speeds.pressure
            within = times[(times > interval[0]) & (times < interval[1])]
            ratio = float(np.interp(np.concatenate([interval, within]), times, ratios).max())
        yield "", at_pressure(vehicle, ratio), wind
        return
    along, angle = planes.get("pitch"), np.zeros(())
    if along is not None and not along.calm and sign != FROZEN:
        angle = np.asarray(along.history.peak)
    ratio = float(pressure_ratio(vehicle.attitude, -np.abs(angle)))  # of a head wind, above one
    if not angle or np.isnan(ratio):  # none along the path, or none that has the angle
        yield "", vehicle, wind
    elif not signed:  # it has a direction
        yield "", at_pressure(vehicle, ratio) if angle < 0.0 else vehicle, wind
    else:
        for direction in SIGNS if sign is None else (sign,):
            at_peak = at_pressure(vehicle, ratio) if direction == "head" else vehicle
            # a head wind is negative, whatever the sign of the specified peak
            yield direction, at_peak, wind * float(SIGNS[direction] * np.sign(angle))


def angle_at(placed: Mapping[str, PlacedWind], time: float) -> float:
    """Return the magnitude [rad] of a placed wind's angle at a flight time [s].

    `placed`: the wind by plane, or in one plane.
    """
    # a history has its own time, whose zero is at the flight time `zero`
    angles = [float(x.history(time - x.zero)) for x in placed.values()]
    return float(np.linalg.norm(angles))


def place_vector(
    wind: WindOf, vehicle: Vehicle, time: float, placing: str = PEAK, window: float = _WINDOW_S
) -> dict[str, PlacedWind]:
    """Return the components of a wind placed at a flight time [s], by plane.

    `wind`: a measured wind, a `PlaneWind`, or a function from the vehicle to one. `vehicle`:
    vehicle at this time. `placing`: "peak" for a wind whose peak is moved to this time, "flight"
    for a wind in flight time, which counts within half a `window` [s] of it.
    """
    if isinstance(wind, MeasuredPlanes):
        measured = {plane: wind.component(plane, vehicle) for plane in PLANES}  # None: calm
        calm, *_ = (x.wind * 0.0 for x in measured.values() if x is not None)
        first, last = wind.known
        return {
            plane: PlacedWind(calm, zero=0.0, known=first <= time <= last)
            if wind_in_plane is None
            else place(wind_in_plane, vehicle, time, placing, window)
            for plane, wind_in_plane in measured.items()
        }
    vector = wind_of(wind, vehicle)
    if not isinstance(vector, PlaneWind) or vector.batch:
        raise InputError(
            "for both planes each wind must have a direction: give one PlaneWind (see"
            f" PlaneWind.towards), what gives one, or fly_through with plane={BOTH!r}"
        )
    _check_end(vector)
    components = {plane: getattr(vector, plane) for plane in PLANES}
    if placing == PEAK:
        samples = np.union1d(vector.pitch.probe_times(), vector.yaw.probe_times())
        zero = time - _middle_of_peak(vector, samples)  # flight time of the wind's time zero
        return {plane: PlacedWind(history, zero) for plane, history in components.items()}
    return {
        plane: place(history, vehicle, time, placing, window)
        if np.isfinite(history.onset)
        else PlacedWind(history, zero=0.0)  # calm in this plane
        for plane, history in components.items()
    }


def wind_of(wind: Any, vehicle: Vehicle) -> Any:
    """Return the wind of a vehicle, from a wind or a function from vehicles to winds."""
    # winds are callable too, with times
    is_function = callable(wind) and not isinstance(wind, History | PlaneWind)
    return wind(vehicle) if is_function else wind


def _check_end(wind: History | PlaneWind) -> None:
    """Raise `InputError` for a wind that never ends or is zero."""
    if not np.isfinite(wind.end):
        raise InputError("each wind must end, and be other than zero")


def _middle_of_peak(wind: History | PlaneWind, times: FloatArray) -> float:
    """Return the middle [s] of the times at which a wind is at its peak."""
    values = np.abs(wind(times))
    top = times[values >= _PEAK_FRACTION * values.max()]
    return 0.5 * float(top[0] + top[-1])


_TIMES_PER_INTERVAL = 33
"""Number of even times between two flight times, besides samples, for the largest trim."""


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
    limit_shape: LimitShape,
    known: BoolArray,
) -> ConcurrentTrim:
    """Return the largest trim ``|B(t) alpha_w(t)|`` around each flight time, and when it occurs.

    B is trim deflection per angle of attack. Angle [rad] and time [s] are ``(n, m)``. `times`: n
    flight times [s]. `winds`: m winds by name; `placing`: "flight" for a wind in flight time,
    "peak" for one whose peak is moved to each flight time, of which the trim is NaN. `planes`: one
    plane or both; with both `limit_shape` measures the vector of trim. `known`: whether a wind can
    be sized, ``(n, m)``; the trim of a wind that cannot is NaN.
    """
    ordered = np.sort(times)
    # each flight time stands for the interval to the middles between it and its neighbours
    edges = np.concatenate([ordered[:1], 0.5 * (ordered[1:] + ordered[:-1]), ordered[-1:]])
    largest = np.full((times.size, len(winds), 2), np.nan)  # trim [rad], and its time [s]
    for j, (name, wind) in enumerate(winds.items()):
        first, last = -np.inf, np.inf
        if isinstance(wind, MeasuredWind | MeasuredPlanes):
            first, last = wind.known
        elif placing[name] == PEAK:
            continue
        for i, k in enumerate(np.argsort(np.argsort(times)).tolist()):  # k: rank of time i
            low, high = max(edges[k], first), min(edges[k + 1], last)
            beyond_linear = not known[i, j] and first <= times[i] <= last
            if low <= high and not beyond_linear:
                vehicle = schedule.at(float(times[i]))  # whose speed makes a wind an angle
                largest[i, j] = _largest(schedule, wind, vehicle, planes, limit_shape, (low, high))
    return ConcurrentTrim(deflection=largest[..., 0], time=largest[..., 1])


def _largest(
    schedule: FlightSchedule,
    wind: WindOf,
    vehicle: Vehicle,
    planes: tuple[str, ...],
    limit_shape: LimitShape,
    interval: tuple[float, float],
) -> tuple[float, float]:
    """Return the largest trim [rad] of an interval of the flight, and its time [s].

    Trim is B times the wind angle, B being the ratio of trim deflection to angle of attack; the
    peak of a gust counts in addition at all times. `wind`: wind in flight time. `vehicle`: vehicle
    with which its angle is evaluated. `planes`: one plane or both; with both `limit_shape` measures
    the vector of trim. `interval`: first and last time [s].
    """
    low, high = interval
    winds = {plane: _in_plane(wind, plane, vehicle) for plane in planes}
    samples = [history.probe_times() for history in winds.values() if history is not None]
    breakpoints = np.concatenate([schedule.times, *samples])
    even = np.linspace(low, high, _TIMES_PER_INTERVAL)
    t = np.unique(np.concatenate([even, breakpoints[(breakpoints > low) & (breakpoints < high)]]))
    vehicles = schedule.clamped_at(t, rigid=True)
    B = {plane: np.asarray(Coefficients.from_vehicle(vehicles, plane).B) for plane in planes}
    by_plane = [
        B[plane] * (0.0 if history is None else history(t)) + np.zeros(t.shape)
        for plane, history in winds.items()
    ]
    if len(by_plane) == 1:
        trim = np.abs(by_plane[0])
    else:
        pitch, yaw = by_plane
        trim = limit_shape.gauge(pitch + 1j * yaw)
    # a gust may be in any plane: the larger B counts
    trim = trim + np.max([np.abs(x) for x in B.values()], axis=0) * _gust(wind, vehicle)
    index = int(np.argmax(trim))
    return float(trim[index]), float(t[index])


def _in_plane(wind: Any, plane: str, vehicle: Vehicle) -> History | None:
    """Return the wind angles [rad] in one plane in flight time, without gust; None where calm.

    `wind`: a sounding in one plane or in both, or a `History`, a `PlaneWind` or a function that
    gives one for a vehicle. `vehicle`: vehicle of such a function.
    """
    if isinstance(wind, MeasuredPlanes):
        measured = wind.parts.get(plane)
        return None if measured is None else measured.wind
    if isinstance(wind, MeasuredWind):
        return wind.wind
    given = wind_of(wind, vehicle)
    history: History = getattr(given, plane) if isinstance(given, PlaneWind) else given
    return history


def _gust(wind: Any, vehicle: Vehicle) -> float:
    """Return the peak angle [rad] of the gust of a measured wind; NaN where it is not known.

    `vehicle`: vehicle whose speed a gust by speed is divided by. Zero without a gust.
    """
    gust = getattr(wind, "gust", None)
    if gust is None:
        return 0.0
    try:
        return abs(float(gust_at(gust, vehicle).peak))
    except NotKnownError:
        return float("nan")
