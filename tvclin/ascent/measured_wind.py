"""Measured winds on a flight: what blows to one side, around a flight time, a gust on top."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, each, flag, instance, number, one_of, positive, single
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.pulses import SampledWind, checked_gust
from tvclin.winds.soundings.profile import WindProfile, wind_angles_along
from tvclin.winds.wind_angles import MAX_LINEAR_ANGLE, angle_in_plane, checked_linear, wind_triangle

GustOf = History | Callable[[Vehicle], History]
"""A gust, or what gives the one that a vehicle meets: of a wind speed, an angle."""
_ROUNDING = 1e-12
"""What is smaller in one plane than this part of the other is no wind."""


@dataclass(frozen=True, eq=False)
class MeasuredWind:
    """A wind in flight time that gives, for a vehicle at a flight time, what counts then.

    That is what blows to the side on which the wind is largest, for boundaries are defined for
    winds of one sign; the trim law is flown through both. The vehicle is that of the flight time,
    the wind where the flight met it. With a window only what blows within half of it counts; such
    a wind begins with a jump, and what drift had relieved before is forgotten. Give it to `size` as
    a wind; its placing is its own. Before the first and after the last of its samples the wind is
    not known: `size` leaves these flight times open.

    Attributes
    ----------
    wind : SampledWind
        One wind, in flight time.
    window : float, optional
        Length of the window [s]; the whole wind where it is not given.
    gust : History or callable, optional
        Added to it, on the wind's side if its peak is positive; its middle meets the flight time.
        Nothing is added to a calm. A function gives it for the vehicle, as `gust_of_speed`.
    notes : tuple of str
        Where the wind is not known for another reason than that the sounding ends.
    pressure : ndarray, optional
        Dynamic pressure at the samples over that of calm air, ``(n,)``, which varying parameters
        count; without it that of calm air.
    """

    wind: SampledWind
    window: float | None = None
    gust: GustOf | None = None
    notes: tuple[str, ...] = ()
    pressure: FloatArray | None = None

    def __post_init__(self) -> None:
        instance("wind", self.wind, SampledWind, "see fly_through")
        single("wind", self.wind.batch)
        if self.window is not None:
            number("window", self.window, positive, "s")
        _checked_gust(self.gust)
        object.__setattr__(self, "notes", each("notes", self.notes, str, "one for each remark"))
        if self.pressure is not None:
            pressure = positive("pressure", self.pressure)
            if pressure.shape != self.wind.time.shape:
                raise InputError("pressure must be one number for each sample of the wind")
            object.__setattr__(self, "pressure", pressure)

    @property
    def known(self) -> tuple[float, float]:
        """The first and the last flight time [s] at which the wind is known."""
        return float(self.wind.time[0]), float(self.wind.time[-1])

    def __call__(self, vehicle: Vehicle) -> History:
        """Return the wind around the vehicle's time [s], in flight time; zero where it is calm."""
        return self._around(vehicle, 0.0)

    def to_both_sides(self, vehicle: Vehicle) -> History:
        """Return the same with what blows to the other side."""
        return self._around(vehicle, np.inf)

    def samples(self, vehicle: Vehicle) -> tuple[Any, Any]:
        """Return times [s] and angles [rad] of the window around a vehicle's time."""
        time = _time_of(vehicle)
        half = np.inf if self.window is None else 0.5 * self.window
        return cut_samples(self.wind, time - half, time + half)

    def _around(self, vehicle: Vehicle, other: float) -> History:
        """The wind around a vehicle's time, and to the other side what is below an angle [rad]."""
        time = _time_of(vehicle)
        times, angles = self.samples(vehicle)
        if times.size < 2 or not np.any(angles):
            return self.wind * 0.0
        side = float(np.sign(angles[np.argmax(np.abs(angles))]))
        around = SampledWind(time=times, angle=side * np.maximum(side * angles, -other))
        if self.gust is None:
            return around
        gust = gust_at(self.gust, vehicle)
        checked_linear(abs(float(around(time))) + abs(float(gust.peak)))
        return around + gust.shift(float(time - 0.5 * (gust.onset + gust.end))) * side


def _time_of(vehicle: Vehicle) -> float:
    instance("vehicle", vehicle, Vehicle, "see FlightSchedule.at")
    single("vehicle", vehicle.batch)
    if vehicle.time is None:
        raise InputError("vehicle must have a time [s], at which it meets the wind")
    return float(np.asarray(vehicle.time))


@dataclass(frozen=True, eq=False)
class MeasuredPlanes:
    """A measured wind in both planes, of which each gives what counts at a flight time.

    Its parts are on the same times and with the same window; one in which nothing blows is left
    out. The gust is along the vector of the wind where that is largest; notes are as of
    `MeasuredWind`.
    """

    parts: Mapping[str, MeasuredWind]
    gust: GustOf | None = None
    notes: tuple[str, ...] = ()

    @property
    def known(self) -> tuple[float, float]:
        """The first and the last flight time [s] at which the wind is known."""
        return next(iter(self.parts.values())).known

    def __call__(self, vehicle: Vehicle) -> PlaneWind:
        """Return the wind around the vehicle's time [s], in flight time; zero where it is calm."""
        calm = next(iter(self.parts.values())).wind * 0.0
        parts = {plane: self.part(plane, vehicle) for plane in PLANES}
        return PlaneWind(**{k: calm if one is None else one(vehicle) for k, one in parts.items()})

    def part(self, plane: str, vehicle: Vehicle) -> MeasuredWind | None:
        """Return one plane around a vehicle's time, with its part of the gust; None in a calm."""
        found = self.parts.get(plane)
        if found is None or self.gust is None:
            return found
        share = abs(self._largest(vehicle)[plane])
        return replace(found, gust=gust_at(self.gust, vehicle) * share) if share else found

    def _largest(self, vehicle: Vehicle) -> dict[str, float]:
        """The largest vector around a vehicle's time, over its size."""
        cut = {plane: one.samples(vehicle) for plane, one in self.parts.items()}
        times = np.unique(np.concatenate([time for time, _ in cut.values()]))
        angles = {plane: np.interp(times, *one) for plane, one in cut.items() if one[0].size}
        size = np.sqrt(sum(one**2 for one in angles.values()) + np.zeros(times.shape))
        if not np.any(size):
            return dict.fromkeys(PLANES, 0.0)
        at = int(np.argmax(size))
        return dict.fromkeys(PLANES, 0.0) | {
            plane: float(one[at] / size[at]) for plane, one in angles.items()
        }


def fly_through(
    profile: WindProfile,
    schedule: FlightSchedule,
    *,
    azimuth: float,
    plane: str = "pitch",
    window: float | None = None,
    gust: GustOf | None = None,
    pressure: bool = True,
    bias: WindProfile | None = None,
) -> MeasuredWind | MeasuredPlanes:
    """Return the wind that a flight through a sounding meets, as `size` takes it.

    Parameters
    ----------
    profile : WindProfile
        The wind over height; see `read_sounding`.
    schedule : FlightSchedule
        The flight, with its altitude.
    azimuth : float
        Direction of flight [rad], from north, clockwise.
    plane : {"pitch", "yaw", "both"}
        As of `WindProfile.to_wind`; both as of `WindProfile.to_winds`.
    window, gust
        As of `MeasuredWind`, or of `MeasuredPlanes`.
    pressure : bool
        Whether the dynamic pressure that is met counts, or that of calm air.
    bias : WindProfile, optional
        The mean wind for which the flight path is biased: taken out of the angles, and not of the
        dynamic pressure, which is that of the whole wind.

    Raises
    ------
    InputError
        For a schedule without altitude, a wind that meets the flight at more than 30 deg all
        the way, and as `WindProfile.to_wind`.

    Notes
    -----
    Where the wind meets the flight at more than 30 deg, as on the pad, it is not known: the longest
    time without is kept.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> flight = tv.load_schedule("configuration-i")
    >>> west = tv.WindProfile(height=[5e3, 12e3, 20e3], east=[0, 60, 0], north=[0, 0, 0])
    >>> met = tv.fly_through(west, flight, azimuth=np.radians(90))
    >>> found = tv.size(flight, met, times=[60.0, 66.0, 72.0])
    >>> np.degrees(found.required["K = 1"])[:, 0].round(3)
    array([0.439, 0.399, 0.347])
    """
    instance("profile", profile, WindProfile, "see read_sounding")
    _checked_gust(gust)
    if bias is not None:
        instance("bias", bias, WindProfile, "see read_sounding")
    left = profile if bias is None else profile - bias
    across = {"pitch": left.in_plane(azimuth), "yaw": left.cross_plane(azimuth)}
    planes = PLANES if one_of("plane", plane, (*PLANES, BOTH)) == BOTH else (plane,)
    met = {
        k: wind_angles_along(schedule, left.height, across[k], k, MAX_LINEAR_ANGLE) for k in planes
    }
    first, last = (f(time[k] for time, _ in met.values()) for f, k in ((max, 0), (min, -1)))
    most = max(float(np.abs(angle).max()) for _, angle in met.values())
    blows = {
        k: SampledWind(time=time[(inside := (time >= first) & (time <= last))], angle=angle[inside])
        for k, (time, angle) in met.items()
        if plane != BOTH or np.abs(angle).max() > _ROUNDING * most
    }
    if not blows:
        raise InputError("the wind must blow along the flight; it is zero throughout there")
    notes = _steep(left, schedule, float(first), float(last))
    flag("pressure", pressure)
    met_air = {
        k: _pressure(profile, schedule, azimuth, one.time) if pressure else None
        for k, one in blows.items()
    }
    if plane != BOTH:
        return MeasuredWind(blows[plane], window, gust, notes, met_air[plane])
    parts = {k: MeasuredWind(one, window, pressure=met_air[k]) for k, one in blows.items()}
    return MeasuredPlanes(parts, gust, notes)


def _pressure(
    profile: WindProfile, schedule: FlightSchedule, azimuth: float, time: FloatArray
) -> FloatArray:
    """The dynamic pressure that a flight through a sounding meets, over that in calm air."""
    height = np.interp(time, schedule.time, schedule.height)
    speed, climb = (
        np.interp(time, schedule.time, one) for one in (schedule.speed, schedule.flight_path_angle)
    )
    along, across = (
        np.interp(height, profile.height, wind) / speed
        for wind in (profile.in_plane(azimuth), profile.cross_plane(azimuth))
    )
    return wind_triangle(climb, along, across)[2]


def _steep(
    profile: WindProfile, schedule: FlightSchedule, first: float, last: float
) -> tuple[str, ...]:
    """Where a sounding is left out although it was measured."""
    low, high = np.interp([first, last], schedule.time, schedule.height)
    bottom = max(float(profile.height[0]), float(schedule.height[0]))
    top = min(float(profile.height[-1]), float(schedule.height[-1]))
    slack = 1e-9 * (top - bottom)
    where = [
        f"{word} {height / 1e3:.3g} km"
        for word, height, out in (
            ("below", low, low > bottom + slack),
            ("above", high, high < top - slack),
        )
        if out
    ]
    if not where:
        return ()
    return (
        f"{' and '.join(where)} the wind meets the flight at more than"
        f" {np.degrees(MAX_LINEAR_ANGLE):.3g} deg, of which linear aerodynamics says nothing",
    )


def gust_of_speed(gust: History, speed: float, plane: str) -> GustOf:
    """Return a gust of a wind speed [m/s], at the angle at which each vehicle meets it, eq (B1e).

    For both planes as if it came across, from where the angle is largest. Raise
    `NotKnownError` for a vehicle that meets it at more than `MAX_LINEAR_ANGLE`.
    """

    def met(vehicle: Vehicle) -> History:
        across = plane if plane == "pitch" else "yaw"
        angle = float(angle_in_plane(speed, vehicle.velocity, vehicle.attitude, across))
        return gust * (checked_linear(angle) / float(gust.peak))

    return met


def gust_at(gust: GustOf, vehicle: Vehicle) -> History:
    """Return the gust that a vehicle meets."""
    return gust if isinstance(gust, History) else gust(vehicle)


def _checked_gust(gust: GustOf | None) -> None:
    if isinstance(gust, History) or not callable(gust):
        checked_gust(gust)


def cut_samples(wind: SampledWind, low: float, high: float) -> tuple[Any, Any]:
    """Samples from one time to another, with the ends and every change of sign among them.

    A change of sign within rounding of a sample is at the sample.
    """
    low, high = max(low, float(wind.time[0])), min(high, float(wind.time[-1]))
    if not low < high:
        return np.empty(0), np.empty(0)
    inside = (wind.time > low) & (wind.time < high)
    times = np.concatenate([[low], wind.time[inside], [high]])
    angles = np.interp(times, wind.time, wind.angle)
    turns = np.flatnonzero(angles[:-1] * angles[1:] < 0.0)
    part = angles[turns] / (angles[turns] - angles[turns + 1])
    calm = times[turns] + part * (times[turns + 1] - times[turns])
    apart = (times[turns] < calm) & (calm < times[turns + 1])
    after = turns[apart] + 1
    return np.insert(times, after, calm[apart]), np.insert(angles, after, 0.0)
