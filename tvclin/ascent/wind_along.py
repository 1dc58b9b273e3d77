"""Winds along a flight: wind angle of attack and dynamic pressure encountered, over flight time.

At a single time a sounding is the wind of the vehicle there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tvclin.ascent.measured_wind import (
    FlightWind,
    GustOf,
    MeasuredPlanes,
    MeasuredWind,
    SoundingSpeeds,
    fly_through,
    unknown_between,
)
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, NotKnownError, instance, number, one_of, positive
from tvclin.vehicle.coefficients import PLANES
from tvclin.vehicle.linear_vehicle import complete_vehicle
from tvclin.winds import wind_angles
from tvclin.winds.histories import History, VehicleWind
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.pulses import SampledWind
from tvclin.winds.soundings.profile import WindProfile

_MAX_INTERVAL_S = 0.1
"""Longest interval [s] of the straight lines between the encountered angles of a sounding."""


@dataclass(frozen=True, eq=False)
class WindAlong:
    """Wind along a flight, in one plane.

    `history`: wind angles of attack [rad] over the time of flight; a batch at nominal dynamic
    pressure alone. `encountered`: wind with its dynamic pressure; None for the nominal one.
    `known`: first and last time of flight [s] at which the wind is known.
    """

    history: History
    encountered: wind_angles.EncounteredWind | EncounteredPlanes | FlightWind | None = None
    known: tuple[float, float] = (-np.inf, np.inf)

    def pressure(self, times: FloatArray) -> FloatArray:
        """Return the dynamic pressure over the nominal one at n times of flight [s], ``(n,)``."""
        if self.encountered is None:
            return np.ones(times.shape)
        _, ratio = self.encountered.at(np.reshape(times, (1, -1)))
        return np.reshape(ratio, times.shape)

    @property
    def breaks(self) -> FloatArray:
        """Times [s] between which wind and dynamic pressure are smooth."""
        times = [np.ravel(self.history.knots)]
        if isinstance(self.encountered, FlightWind):
            times.append(self.encountered.speeds.time)
        if isinstance(self.encountered, EncounteredPlanes):
            wind = self.encountered.wind
            times += [np.ravel(wind.pitch.knots), np.ravel(wind.yaw.knots)]
        return np.unique(np.concatenate(times))

    def span(
        self, flight: FlightSchedule, start: float | None, stop: float | None
    ) -> tuple[float, float]:
        """Return the first and the last time [s] of a flight through the wind.

        `start`, `stop`: these times [s]; None for the first and last at which both are known.
        `InputError` for times outside the flight or the wind.
        """
        flight_interval = flight.between(start, stop)
        known_from, known_to = self.known
        first, last = np.clip(flight_interval.span, known_from, known_to).tolist()
        for name, requested, end in (("start", start, first), ("stop", stop, last)):
            if requested is not None and requested != end:
                raise InputError(
                    f"{name} must be between {known_from:.6g} and {known_to:.6g} s, where"
                    f" the wind is known; got {requested:.6g} s"
                )
        if not first < last:
            raise InputError("the wind must be known at times of the flight; it is at none of them")
        return first, last


def wind_along(
    flight: FlightSchedule,
    wind: History | MeasuredWind,
    plane: str,
    sign: str | None = None,
    gust_time: float | None = None,
) -> WindAlong:
    """Return one wind along a flight with the dynamic pressure encountered.

    `wind`: wind angles of attack [rad] over the time of flight, or the wind of `fly_through`
    without its window. `plane`: plane of the wind angles, pitch or yaw. `sign`: direction of the
    largest angle of a history in pitch, "head" (by default, whatever the sign of the angle) or
    "tail"; "frozen" is the nominal dynamic pressure. A history in yaw is a cross wind, and a
    sounding has its own direction. `gust_time`: time of flight [s] of the gust of a `MeasuredWind`.
    `InputError` for another sign, a path on which no horizontal wind has the angle, and a gust
    without its time.
    """
    instance("flight", flight, FlightSchedule, "see load_schedule")
    one_of("plane", plane, PLANES)
    if sign is not None:
        one_of("sign", sign, (*wind_angles.SIGNS, wind_angles.FROZEN))
    if isinstance(wind, MeasuredWind):
        return _sounding(flight, wind, plane, sign, gust_time)
    instance("wind", wind, History, "such as TriangularWind, or the wind of fly_through")
    if gust_time is not None:
        raise InputError("gust_time is that of the gust of a sounding: add a pulse to a history")
    if sign == wind_angles.FROZEN or not np.any(np.isfinite(wind.onset)):
        return WindAlong(wind)
    in_pitch, in_yaw = 0.0, 1.0
    if plane == "pitch":  # the sign by which the largest angle becomes that of the direction
        in_pitch, in_yaw = wind_angles.SIGNS[sign or "head"] * float(np.sign(wind.peak)), 0.0
    paths = flight.flight_path_angle
    encountered = wind_angles.EncounteredWind(
        plane=plane,
        path=paths[0],
        angle=wind,
        speed=None,
        of_angle=(np.asarray(in_pitch), np.asarray(in_yaw)),
        of_speed=(0.0, 0.0),  # of no wind that is given by its speed
        flight=(flight.times, paths, np.ones(paths.shape)),  # ones: of no effect on angles
    )
    encountered.check_possible()
    return WindAlong(wind, encountered)


def _sounding(
    flight: FlightSchedule,
    wind: MeasuredWind,
    plane: str,
    sign: str | None,
    gust_time: float | None,
) -> WindAlong:
    """Return the wind of a sounding along a flight, in one plane.

    `wind`: the sounding along this flight, `known` between two times of it, with a gust or without.
    `plane`: of the wind angles, pitch or yaw. `sign`: "frozen" for the nominal dynamic pressure, or
    None; no other, for its direction is measured. `gust_time`: time of flight [s] of the gust.
    """
    if sign in wind_angles.SIGNS:
        raise InputError(
            f"measured winds have their own sign: leave sign, or take {wind_angles.FROZEN}"
        )
    if (wind.gust is None) != (gust_time is None):
        raise InputError("gust_time must be given for a sounding with a gust, and for no other")
    history: History = wind.wind
    if gust_time is not None:
        time = number("gust_time", gust_time, unit="s")
        # the gust is placed at the time of the vehicle, of which the structure has no part; the
        # whole sounding, not a window about the gust, with positive and negative wind angles
        vehicle = flight.at(time).rigid
        history = replace(wind, window=None).of_both_signs(vehicle)
    speeds = None if sign == wind_angles.FROZEN else wind.speeds
    return sounding_along(history, speeds, plane, wind.known)


def sounding_along(
    history: History, speeds: SoundingSpeeds | None, plane: str, known: tuple[float, float]
) -> WindAlong:
    """Return the wind of a sounding along a flight, or an interval of it.

    `history`: wind angles [rad] at the nominal speed of the flight, eq (B1e). `speeds`: wind of
    both planes; None for the nominal dynamic pressure. `plane`: plane of the wind angles, pitch or
    yaw. `known`: first and last time of flight [s] at which the sounding is known.
    """
    if speeds is None:
        return WindAlong(history, known=known)
    encountered = FlightWind(history, plane, speeds)
    knots = history.knots
    # the difference of encountered and nominal angle is sampled, with straight lines between
    parts = np.maximum(np.ceil(np.diff(knots) / _MAX_INTERVAL_S), 1.0).astype(int)
    between = [
        np.linspace(a, b, n, endpoint=False)
        for a, b, n in zip(knots[:-1], knots[1:], parts.tolist(), strict=True)
    ]
    times = np.unique(np.concatenate([*between, knots[-1:]]))
    inside = np.minimum(times, np.nextafter(knots[-1], -np.inf))  # zero from the last knot on
    (angle,), _ratio = encountered.at(inside[np.newaxis])
    change = angle - history(inside)
    if not np.any(change):  # of a plane in which the sounding is calm
        return WindAlong(history, encountered, known)
    return WindAlong(history + SampledWind(time=times, angle=change), encountered, known)


@dataclass(frozen=True, eq=False)
class EncounteredPlanes:
    """Wind of both planes over flight time, as a flight encounters it.

    `plane`: plane of the angles of `at`. `wind`: wind angles of attack [rad] of both planes.
    `flight`: the flight with its path angles.
    """

    plane: str
    wind: PlaneWind
    flight: FlightSchedule

    def at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return wind angles of attack [rad] of the plane, and q/q_n, at flight times [s].

        q/q_n is the dynamic pressure over the nominal one, NaN where no horizontal wind along the
        path has the angle.
        """
        angles = {plane: np.asarray(getattr(self.wind, plane)(times)) for plane in PLANES}
        path = np.interp(times, self.flight.times, self.flight.flight_path_angle)
        along = np.zeros(times.shape)
        if np.any(angles["pitch"]):
            along = wind_angles.along_from_angle(path, angles["pitch"])
        # the air speed in the plane of the path, over the speed, is the root of q/q_n without wind
        # across; the wind across it is the tangent of the yaw angle times this air speed
        across = np.sqrt(wind_angles.pressure_in_winds(path, along)) * np.tan(angles["yaw"])
        return angles[self.plane], wind_angles.pressure_in_winds(path, along, across)


def planes_along(
    flight: FlightSchedule,
    wind: PlaneWind | MeasuredPlanes,
    sign: str | None = None,
    gust_time: float | None = None,
) -> dict[str, WindAlong]:
    """Return a wind of both planes along a flight, by plane, with its dynamic pressure.

    `wind`: wind angles of attack [rad] over the time of flight, or the wind of `fly_through` in
    both planes. `sign`: "frozen" for the nominal dynamic pressure; by default it is encountered in
    the wind of both planes. `gust_time`: time of flight [s] of the gust of a sounding.
    `InputError` as `wind_along`, and for a wind of one plane, or a batch.
    """
    instance("flight", flight, FlightSchedule, "see load_schedule")
    if sign is not None:
        one_of("sign", sign, (wind_angles.FROZEN,))
    if isinstance(wind, MeasuredPlanes):
        return _sounding_in_planes(flight, wind, sign, gust_time)
    instance("wind", wind, PlaneWind, "or the wind of fly_through with plane='both'")
    if wind.batch:
        raise InputError(f"wind must be one wind; got a batch of shape {wind.batch}")
    if gust_time is not None:
        raise InputError("gust_time is that of the gust of a sounding: add a pulse to a history")
    histories = {plane: getattr(wind, plane) for plane in PLANES}
    if sign == wind_angles.FROZEN:
        return {plane: WindAlong(history) for plane, history in histories.items()}
    encountered = {plane: EncounteredPlanes(plane, wind, flight) for plane in PLANES}
    _, ratio = encountered["pitch"].at(wind.pitch.probe_times())
    if np.any(np.isnan(ratio)):
        raise InputError("no horizontal wind turns the flight as far as this wind in pitch")
    return {plane: WindAlong(histories[plane], encountered[plane]) for plane in PLANES}


def _sounding_in_planes(
    flight: FlightSchedule, wind: MeasuredPlanes, sign: str | None, gust_time: float | None
) -> dict[str, WindAlong]:
    """Return the wind of a sounding along a flight, by plane, in both planes.

    The vehicle at the time of the gust gives its angle in each plane; without a gust the vehicle
    does not count, and that at the begin of the flight is taken.
    `wind`: the sounding along this flight. `sign`: "frozen" for the nominal dynamic pressure, or
    None. `gust_time`: time of flight [s] of its gust.
    """
    if (wind.gust is None) != (gust_time is None):
        raise InputError("gust_time must be given for a sounding with a gust, and for no other")
    vehicle = flight.at(flight.span[0] if gust_time is None else gust_time).rigid
    winds = {}
    for plane in PLANES:
        component = wind.component(plane, vehicle)
        if component is None:  # a calm plane: the other one has the wind speeds of both
            other = next(iter(wind.parts.values()))
            speeds = None if sign == wind_angles.FROZEN else other.speeds
            winds[plane] = sounding_along(other.wind * 0.0, speeds, plane, wind.known)
        else:
            time = None if component.gust is None else gust_time
            winds[plane] = wind_along(flight, component, plane, sign, time)
    return winds


_MIN_STEP_FRACTION = 0.1
"""Fraction of the largest wind angle in a window above which a step at an end is noted."""
WINDOW_S = 20.0
"""Default length [s] of the part of a sounding that counts, about the time of the vehicle."""
_TIME = "the vehicle's time"
"""Name of the flight time in messages."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SoundingWind(VehicleWind):
    """Wind of a sounding that a vehicle encounters around its time of flight.

    Its history has angles of both signs, as a flight meets them; the part with the sign of its peak
    is `of_one_sign`, for boundaries, which are defined for winds of one sign. `name`: name of the
    sounding. `profile`: wind over height. `schedule`: flight of the vehicle, with its altitude.
    `azimuth`: direction of flight [rad], from north, clockwise. `window`: length [s] of the
    interval that counts, about the time of the vehicle. `gust`: gust on top of it; see
    `MeasuredWind`. `bias`: mean wind for which the flight path is biased; see `fly_through`.
    `in_flight`: whether the history is in flight time, or begins at zero.
    """

    name: str
    profile: WindProfile
    schedule: FlightSchedule
    azimuth: float
    window: float = WINDOW_S
    gust: GustOf | None = None
    bias: WindProfile | None = None
    in_flight: bool = False

    def __post_init__(self) -> None:
        """Check profile, schedule and window; `InputError` for another type or number."""
        instance("profile", self.profile, WindProfile, "see read_sounding")
        instance("schedule", self.schedule, FlightSchedule, "see load_schedule")
        number("window", self.window, positive, "s")

    @property
    def shape(self) -> str:
        """Name of the sounding."""
        return self.name

    def history(self, vehicle: Any, plane: str) -> History:
        """Return the wind angle of attack [rad] of a vehicle in a plane, pitch or yaw.

        It is over flight time if the field `in_flight` is true, else over the time since its onset.
        `InputError` for a vehicle without a time of flight, and for a wind that is calm or not
        known at its time.
        """
        wind, time = self._along(plane), self._time(vehicle)
        first, last = wind.known
        if not first <= time <= last:
            raise NotKnownError(f"the wind of {self.name} is not known at {time:g} s, {_TIME}")
        history = wind.of_both_signs(complete_vehicle(vehicle, "a sounding"))
        if not history.peak:
            raise InputError(f"the wind of {self.name} is calm at {time:g} s, {_TIME}")
        return history.shift(-self.zero(vehicle, plane))

    def zero(self, vehicle: Any, plane: str) -> float:
        """Return the time of flight [s] at which the history of a vehicle in a plane has t = 0."""
        if self.in_flight:
            return 0.0
        whole = self._along(plane).of_both_signs(complete_vehicle(vehicle, "a sounding"))
        return float(whole.onset)

    def of_one_sign(self, vehicle: Any, plane: str) -> History:
        """Return the part [rad] of `history` with the sign of its largest angle, at the same times.

        `vehicle`, `plane`: as of `history`, and with its errors.
        """
        history = self.history(vehicle, plane)
        if history.constant_sign:
            return history
        part = self._along(plane)(complete_vehicle(vehicle, "a sounding"))
        return part.shift(-self.zero(vehicle, plane))

    def largest_pressure(self, vehicle: Any, plane: str) -> float:
        """Return the largest ratio q/q_n that a vehicle encounters while its history lasts.

        q/q_n is the dynamic pressure over the nominal one, of the wind of both planes with its
        gust. `vehicle`: has the time of flight. `plane`: plane of the history, pitch or yaw.
        """
        wind = self._along(plane)
        history = wind.of_both_signs(complete_vehicle(vehicle, "a sounding"))
        assert wind.speeds is not None
        times = np.union1d(history.probe_times(), wind.speeds.time)
        times = times[(times >= history.onset) & (times < history.end)]
        _, ratio = FlightWind(history, plane, wind.speeds).at(times[np.newaxis])
        return float(ratio.max())

    def notes(self, vehicle: Any, plane: str) -> Iterator[str]:
        """Yield notes on the sounding, and on ends of flight or sounding in a vehicle's window.

        `vehicle`: has the time of flight. `plane`: pitch or yaw.
        """
        notes = self.profile.notes_along(self.schedule)
        yield from (f"{self.name}: {note}" for note in notes)
        time, half = self._time(vehicle), self.window / 2
        steps = np.degrees(np.abs(self._end_angles(vehicle, plane)))
        ends = (*self._along(plane).known, *self.schedule.span, *steps)
        first, last, flight_begin, flight_end, at_begin, at_end = map(float, ends)
        if time - half < first:
            yield self._end_note("begins", first, first <= flight_begin, "before", at_begin)
        if last < time + half:
            yield self._end_note("ends", last, last >= flight_end, "after", at_end)

    def _end_note(self, verb: str, time: float, of_flight: bool, side: str, step: float) -> str:
        """Return a note on an end of the flight or of the known wind, within the window.

        `verb`: begins or ends. `time`: its time of flight [s]. `of_flight`: whether it is an end of
        the flight. `side`: before or after. `step`: wind angle there [deg], zero for none.
        """
        what = "the flight" if of_flight else "the known wind"
        with_step = f", with a step of {step:.3g} deg" if step else ""
        return (
            f"{self.name}: {what} {verb} at {time:.6g} s{with_step}; no wind {side} that is counted"
        )

    def steps(self, vehicle: Any, plane: str) -> FloatArray:
        """Return the wind angles [rad] at the begin and the end of the window, ``(2,)``.

        With such steps the wind begins and ends, as the window cuts the sounding there. Zero at an
        end of the flight or of the sounding itself, and if at most a tenth of the largest angle.
        `vehicle`: has the time of flight. `plane`: pitch or yaw.
        """
        time, (first, last) = self._time(vehicle), self._along(plane).known
        is_cut = first < time - self.window / 2, time + self.window / 2 < last
        return np.where(is_cut, self._end_angles(vehicle, plane), 0.0)

    def _end_angles(self, vehicle: Any, plane: str) -> FloatArray:
        """Return the first and the last wind angle [rad] of a vehicle's window, ``(2,)``.

        Each is zero if it is at most a tenth of the largest.
        """
        _times, angles = self._along(plane).samples(complete_vehicle(vehicle, "a sounding"))
        if not angles.size:  # where the wind is not known
            return np.zeros(2)
        ends = angles[[0, -1]]
        return np.where(np.abs(ends) > _MIN_STEP_FRACTION * np.abs(angles).max(), ends, 0.0)

    def unknown(self, vehicle: Any, plane: str) -> str:
        """Return why the wind is not known within the window of a vehicle, in words; often empty.

        Times before the schedule begins, and after it ends, have no flight. `vehicle`: has the time
        of flight. `plane`: pitch or yaw.
        """
        time, half = self._time(vehicle), self.window / 2
        ends = np.clip([time - half, time + half], *self.schedule.span).tolist()
        return unknown_between(self._along(plane), *ends)

    def _along(self, plane: str) -> MeasuredWind:
        """Return the wind in a plane, pitch or yaw, along the whole flight."""
        wind = fly_through(
            self.profile,
            self.schedule,
            azimuth=self.azimuth,
            plane=plane,
            window=self.window,
            gust=self.gust,
            bias=self.bias,
        )
        assert isinstance(wind, MeasuredWind)
        return wind

    def _time(self, vehicle: Any) -> float:
        """Return the time [s] of a vehicle in its flight; `InputError` without one."""
        time = complete_vehicle(vehicle, "a sounding").time
        if time is None:
            raise InputError("a sounding needs a vehicle with its time of flight, time_s")
        return float(time)
