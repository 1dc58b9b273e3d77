"""Measured winds along a flight: their part of one sign around a flight time, with a gust."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, each, flag, instance, number, one_of, positive, single
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds import wind_angles
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.pulses import SampledWind, checked_gust
from tvclin.winds.soundings.profile import WindProfile, gap_words, wind_angles_along

GustOf = History | Callable[[Vehicle], History]
"""A gust, or a function from a vehicle to its gust: a wind speed has another angle for each."""
_ROUNDING = 1e-12
"""Largest wind angle in a plane, relative to the other plane, that counts as none."""


@dataclass(frozen=True, eq=False)
class SoundingSpeeds:
    """Wind speeds of a sounding along a flight, over the speed of the vehicle at each time.

    `time`: flight times [s], ``(n,)``; before the first and after the last the wind is calm.
    `path`: flight path angles [rad], ``(n,)``. `wind`, `bias`: speeds, ``(n,)``, by the plane of
    their wind angle: in pitch along the path, positive from behind, and in yaw across it; of the
    entire wind, and of the mean wind for which the flight path is biased.
    """

    time: FloatArray
    path: FloatArray
    wind: Mapping[str, FloatArray]
    bias: Mapping[str, FloatArray]

    @property
    def pressure(self) -> FloatArray:
        """Dynamic pressure encountered over the nominal one at the times, ``(n,)``."""
        _, _, ratio = wind_angles.wind_triangle(self.path, self.wind["pitch"], self.wind["yaw"])
        return ratio

    def encountered(
        self, plane: str, angle: FloatArray, times: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return wind angles of attack in a plane [rad] and q/q_n at times [s], in their shape.

        q/q_n is the dynamic pressure over the nominal one. `plane`: plane of the angle; the other
        plane has the wind of the sounding. `angle`: wind angles [rad] at the nominal speed of the
        flight, beyond the bias, at the times.
        """
        path = np.interp(times, self.time, self.path)  # [rad]
        bias, wind = (  # speeds by plane, over the speed of the vehicle; calm beyond the sounding
            {k: np.interp(times, self.time, speed, left=0.0, right=0.0) for k, speed in x.items()}
            for x in (self.bias, self.wind)
        )
        # sin(angle) = (wind speed/speed of the vehicle) sin(path), in yaw without the path
        speed = np.sin(angle) / (np.sin(path) if plane == "pitch" else 1.0)
        wind[plane] = bias[plane] + speed
        *angles, ratio = wind_angles.wind_triangle(path, wind["pitch"], wind["yaw"])
        *bias_angles, _ratio = wind_angles.wind_triangle(path, bias["pitch"], bias["yaw"])
        k = PLANES.index(plane)
        # the flight path is biased for the mean wind, which makes no angle of attack
        return angles[k] - bias_angles[k], ratio


@dataclass(frozen=True, eq=False)
class FlightWind(wind_angles.NominalWind):
    """A wind in flight time, as a vehicle encounters it with the wind of a sounding.

    `history`: wind angles [rad] at the nominal speed of the flight, eq (B1e). `plane`: plane of
    these angles. `speeds`: the wind of both planes.
    """

    plane: str
    speeds: SoundingSpeeds

    def at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return wind angles [rad] and dynamic pressures over the nominal one at times [s]."""
        nominal, _ = super().at(times)
        return self.speeds.encountered(self.plane, nominal, times)

    def between(self, start: float, stop: float) -> FlightWind:
        """Return the wind from a start to a stop time [s], zero before and after."""
        return replace(self, history=super().between(start, stop).history)


@dataclass(frozen=True, eq=False)
class SoundingGaps:
    """Gaps between the levels of a sounding along a flight, in which the wind is not known.

    `height`: heights [m] of the levels below and above each gap, ``(gaps, 2)``. `time`: flight
    times [s] at these heights, ``(gaps, 2)``, of a flight that ascends.
    """

    height: FloatArray
    time: FloatArray

    def __post_init__(self) -> None:
        """Set heights and times to arrays of two columns, also where there is no gap."""
        for name in ("height", "time"):
            value = np.reshape(np.asarray(getattr(self, name), dtype=float), (-1, 2))
            object.__setattr__(self, name, value)

    @classmethod
    def of(cls, profile: WindProfile, schedule: FlightSchedule) -> SoundingGaps:
        """Return the gaps of a profile along a flight: their ends as heights [m] and times [s]."""
        times = np.interp(profile.gaps, schedule.height, schedule.times)
        return cls(profile.gaps, times)

    def between(self, first: float, last: float) -> str:
        """Return the gaps that a flight crosses between two times [s], in words; often empty."""
        return gap_words(self.height[(self.time[:, 0] < last) & (self.time[:, 1] > first)])

    def encountered(self, first: float, last: float, half: float) -> tuple[str, str]:
        """Return the gaps within `half` a window of flight times, and what makes them known.

        `first`, `last`, `half`: times [s]. Both in words, the first empty without a gap. An earlier
        last time is a cure where the gaps begin after the first.
        """
        begins = self.time[self.time[:, 1] > first - half, 0]
        until = float(begins.min(initial=np.inf)) - half
        before = f" or --to {hundredths(until, up=False)}" if until > first else ""
        return self.between(first - half, last + half), f"known with more levels{before}"

    def reason(self, first: float, last: float) -> str:
        """Return why the wind is not known between two times [s], its gaps; empty without any."""
        gaps = self.between(first, last)
        return f"the wind is not known {gaps}" if gaps else ""


NO_GAPS = SoundingGaps(np.empty((0, 2)), np.empty((0, 2)))
"""Gaps of a sounding without any."""


@dataclass(frozen=True, eq=False)
class MeasuredWind:
    """A wind in flight time, of which a vehicle at a flight time gets the part that counts.

    That is the part with the sign of the largest angle, for boundaries are defined for winds of one
    sign; the trim law is flown through both signs. With a window only angles within half of it
    count; such a wind begins with a jump, and relief by drift before it is neglected. `size` takes
    it as a wind with its place in the flight. Before the first and after the last of its samples
    the wind is not known: `size` leaves these flight times open.

    Attributes
    ----------
    wind : SampledWind
        One wind, in flight time.
    window : float, optional
        Length of the window [s]; the whole wind where it is not given.
    gust : History or callable, optional
        Added to it, with the wind's sign if its peak is positive; its middle is at the flight time.
        Nothing is added to a calm. A function gives it for the vehicle, as `GustOfSpeed`.
    notes : tuple of str
        Where the wind is not known for another reason than that the sounding ends.
    speeds : SoundingSpeeds, optional
        Speeds of the sounding, which with varying parameters give wind angle of attack and dynamic
        pressure; without them the dynamic pressure is nominal.
    gaps : SoundingGaps
        Gaps of the sounding, in which the wind is not known.
    """

    wind: SampledWind
    window: float | None = None
    gust: GustOf | None = None
    notes: tuple[str, ...] = ()
    speeds: SoundingSpeeds | None = None
    gaps: SoundingGaps = NO_GAPS

    def __post_init__(self) -> None:
        """Check the fields; `InputError` for another type, a batch, and a window not positive."""
        instance("wind", self.wind, SampledWind, "see fly_through")
        single("wind", self.wind.batch)
        if self.window is not None:
            number("window", self.window, positive, "s")
        _checked_gust(self.gust)
        object.__setattr__(self, "notes", each("notes", self.notes, str, "one for each remark"))
        if self.speeds is not None:
            instance("speeds", self.speeds, SoundingSpeeds, "see fly_through")
        instance("gaps", self.gaps, SoundingGaps, "see fly_through")

    @property
    def known(self) -> tuple[float, float]:
        """The first and the last flight time [s] at which the wind is known."""
        return float(self.wind.time[0]), float(self.wind.time[-1])

    def __call__(self, vehicle: Vehicle) -> History:
        """Return the wind angle [rad] around the vehicle's time [s], of the largest angle's sign.

        It is a history over flight time, with the gust; angles of the opposite sign become zero.
        """
        return self._around(vehicle, max_opposite=0.0)

    def of_both_signs(self, vehicle: Vehicle) -> History:
        """Return the wind angle [rad] around the vehicle's time [s], with angles of both signs."""
        return self._around(vehicle, max_opposite=np.inf)

    def samples(self, vehicle: Vehicle) -> tuple[Any, Any]:
        """Return times [s] and angles [rad] of the window around a vehicle's time."""
        time = _time_of(vehicle)
        half = np.inf if self.window is None else 0.5 * self.window
        return cut_samples(self.wind, time - half, time + half)

    def _around(self, vehicle: Vehicle, max_opposite: float) -> History:
        """Return the wind angle [rad] around a vehicle's time, with the gust, in flight time.

        `max_opposite`: size [rad] up to which angles of the sign opposite to the largest are kept:
        zero for a wind of one sign, infinite for all of it. The middle of the gust is at the time,
        and its sign is that of the largest angle; a calm has none. `NotKnownError` where wind and
        gust together are beyond linear aerodynamics.
        """
        time = _time_of(vehicle)
        times, angles = self.samples(vehicle)
        if times.size < 2 or not np.any(angles):
            return self.wind * 0.0
        sign = float(np.sign(angles[np.argmax(np.abs(angles))]))
        around = SampledWind(time=times, angle=sign * np.maximum(sign * angles, -max_opposite))
        if self.gust is None:
            return around
        gust = gust_at(self.gust, vehicle)
        wind_angles.checked_linear(abs(float(around(time))) + abs(float(gust.peak)))
        middle = 0.5 * (gust.onset + gust.end)
        return around + gust.shift(float(time - middle)) * sign


def _time_of(vehicle: Vehicle) -> float:
    """Return the flight time [s] of a vehicle; `InputError` without one."""
    instance("vehicle", vehicle, Vehicle, "see FlightSchedule.at")
    single("vehicle", vehicle.batch)
    if vehicle.time is None:
        raise InputError("vehicle must have a time [s], at which it encounters the wind")
    return float(np.asarray(vehicle.time))


@dataclass(frozen=True, eq=False)
class MeasuredPlanes:
    """A measured wind in both planes, one `MeasuredWind` for each plane, in `parts`.

    They have the same times and the same window; a plane without wind has none. The gust is along
    the vector of the wind where that is largest.
    """

    parts: Mapping[str, MeasuredWind]
    gust: GustOf | None = None
    notes: tuple[str, ...] = ()

    @property
    def known(self) -> tuple[float, float]:
        """The first and the last flight time [s] at which the wind is known."""
        return next(iter(self.parts.values())).known

    @property
    def gaps(self) -> SoundingGaps:
        """Gaps of the sounding, in which the wind is not known."""
        return next(iter(self.parts.values())).gaps

    def __call__(self, vehicle: Vehicle) -> PlaneWind:
        """Return the wind around the vehicle's time [s], in flight time; zero where it is calm.

        `parts` are the winds of the sounding by plane, each a function of the vehicle.
        """
        calm = next(iter(self.parts.values())).wind * 0.0
        pitch, yaw = (self.component(plane, vehicle) for plane in PLANES)
        return PlaneWind(
            pitch=calm if pitch is None else pitch(vehicle),
            yaw=calm if yaw is None else yaw(vehicle),
        )

    def component(self, plane: str, vehicle: Vehicle) -> MeasuredWind | None:
        """Return the wind of one plane with its component of the gust; None for a calm plane.

        The gust points where the wind vector is largest around the time of `vehicle`; the wind of a
        plane in which it has no component is returned without a gust.
        """
        wind = self.parts.get(plane)
        if wind is None or self.gust is None:
            return wind
        share = abs(self._direction(vehicle)[plane])  # component of the gust's unit vector
        return replace(wind, gust=gust_at(self.gust, vehicle) * share) if share else wind

    def _direction(self, vehicle: Vehicle) -> dict[str, float]:
        """Return the unit vector, by plane, of the largest wind around a vehicle's time.

        A plane without samples around that time does not count; zero in a calm.
        """
        samples = {plane: wind.samples(vehicle) for plane, wind in self.parts.items()}
        times = np.unique(np.concatenate([time for time, _ in samples.values()]))
        angles = {  # [rad] at all these times
            plane: np.interp(times, time, angle)
            for plane, (time, angle) in samples.items()
            if time.size
        }
        size = np.sqrt(sum(angle**2 for angle in angles.values()) + np.zeros(times.shape))
        if not np.any(size):
            return dict.fromkeys(PLANES, 0.0)
        at = int(np.argmax(size))
        return dict.fromkeys(PLANES, 0.0) | {
            plane: float(angle[at] / size[at]) for plane, angle in angles.items()
        }


def hundredths(time: float, *, up: bool) -> str:
    """Return a flight time [s] rounded up or down to hundredths, in words."""
    return f"{(np.ceil if up else np.floor)(100.0 * time) / 100.0:.10g}"


def unknown_between(wind: MeasuredWind | MeasuredPlanes, first: float, last: float) -> str:
    """Return why a measured wind is not known between two flight times, in words; often empty.

    It is known from its first sample to its last, except in gaps of the sounding; a flight through
    the rest is not known to be survived. `first`, `last`: flight times [s].
    """
    begin, end = wind.known
    if first < begin or end < last:
        # rounded inwards, so that the times printed are known
        span = f"{hundredths(begin, up=True)} to {hundredths(end, up=False)} s"
        return f"the wind is known from {span} alone"
    return wind.gaps.reason(first, last)


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
    """Return the wind in flight time that a flight through a sounding encounters.

    Parameters
    ----------
    profile : WindProfile
        The wind over height; see `read_sounding`.
    schedule : FlightSchedule
        The flight, with its altitude.
    azimuth : float
        Direction of flight [rad], from north, clockwise.
    plane : {"pitch", "yaw", "both"}
        Plane of the wind angle of attack; "both" returns a wind for each.
    window : float, optional
        Length [s] of the interval about the time of a vehicle that counts; by default all times.
    gust : History or callable, optional
        Gust on top of the wind, or a function from a vehicle to its gust; see `GustOfSpeed`.
    pressure : bool
        Whether the dynamic pressure encountered counts, or the nominal one.
    bias : WindProfile, optional
        The mean wind for which the flight path is biased: taken out of the angles, and not of the
        dynamic pressure, which depends on the whole wind.

    Raises
    ------
    InputError
        For a schedule without altitude, a wind angle above 30 deg throughout, and the reasons of
        `WindProfile.to_wind`.

    Notes
    -----
    Where the wind angle of attack is above 30 deg, as on the pad, the wind is not known: the
    longest interval below is returned.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> flight = tv.load_schedule("configuration-i")
    >>> west = tv.WindProfile(height=[5e3, 12e3, 20e3], east=[0, 60, 0], north=[0, 0, 0])
    >>> wind = tv.fly_through(west, flight, azimuth=np.radians(90))
    >>> sizing = tv.size(flight, wind, times=[60.0, 66.0, 72.0])
    >>> np.degrees(sizing.required["K = 1"])[:, 0].round(3)
    array([0.439, 0.399, 0.347])
    """
    instance("profile", profile, WindProfile, "see read_sounding")
    _checked_gust(gust)
    if bias is not None:
        instance("bias", bias, WindProfile, "see read_sounding")
    unbiased = profile if bias is None else profile - bias
    across = {"pitch": unbiased.in_plane(azimuth), "yaw": unbiased.cross_plane(azimuth)}
    planes = PLANES if one_of("plane", plane, (*PLANES, BOTH)) == BOTH else (plane,)
    angles = {
        k: wind_angles_along(schedule, unbiased.height, across[k], k, wind_angles.MAX_LINEAR_ANGLE)
        for k in planes
    }
    # the interval of flight times that is known in all planes
    first = max(time[0] for time, _ in angles.values())
    last = min(time[-1] for time, _ in angles.values())
    largest = max(float(np.abs(angle).max()) for _, angle in angles.values())
    winds = {
        k: SampledWind(time=time[(inside := (time >= first) & (time <= last))], angle=angle[inside])
        for k, (time, angle) in angles.items()
        if plane != BOTH or np.abs(angle).max() > _ROUNDING * largest
    }
    if not winds:
        raise InputError("the wind must blow along the flight; it is zero throughout there")
    notes = _beyond_linear(unbiased, schedule, float(first), float(last))
    flag("pressure", pressure)
    speeds = {
        k: _speeds(profile, bias, schedule, azimuth, wind.time) if pressure else None
        for k, wind in winds.items()
    }
    gaps = SoundingGaps.of(profile, schedule)
    if plane != BOTH:
        return MeasuredWind(
            winds[plane], window, gust=gust, notes=notes, speeds=speeds[plane], gaps=gaps
        )
    parts = {
        k: MeasuredWind(wind, window, speeds=speeds[k], gaps=gaps) for k, wind in winds.items()
    }
    return MeasuredPlanes(parts, gust=gust, notes=notes)


def _speeds(
    profile: WindProfile,
    bias: WindProfile | None,
    schedule: FlightSchedule,
    azimuth: float,
    time: FloatArray,
) -> SoundingSpeeds:
    """Return the wind speeds of a sounding, and of a bias, along a flight, over its speed.

    `profile`, `bias`: winds over height; None for no bias. `schedule`: the flight. `azimuth`: its
    direction [rad], from north, clockwise. `time`: times of flight [s], ``(n,)``.
    """
    height, speed, path = (
        np.interp(time, schedule.time, values)
        for values in (schedule.height, schedule.speed, schedule.flight_path_angle)
    )

    def by_plane(wind: WindProfile | None) -> dict[str, FloatArray]:
        """Return the speeds of a wind over the vehicle's, "pitch" along its flight, "yaw" across.

        They are at the n times, at the `height` of the flight then; zero without a wind.
        """
        if wind is None:
            return dict.fromkeys(PLANES, np.zeros(time.shape))
        along, across = wind.in_plane(azimuth), wind.cross_plane(azimuth)
        return {
            "pitch": np.interp(height, wind.height, along) / speed,
            "yaw": np.interp(height, wind.height, across) / speed,
        }

    return SoundingSpeeds(time=time, path=path, wind=by_plane(profile), bias=by_plane(bias))


def _beyond_linear(
    profile: WindProfile, schedule: FlightSchedule, first: float, last: float
) -> tuple[str, ...]:
    """Return a note on measured heights at which the wind angle is beyond linear aerodynamics.

    `profile`, `schedule`: wind and flight over height. `first`, `last`: times [s] of the flight
    between which the angle is within it. Empty where these include all measured heights.
    """
    low, high = np.interp([first, last], schedule.time, schedule.height)
    bottom = max(float(profile.height[0]), float(schedule.height[0]))
    top = min(float(profile.height[-1]), float(schedule.height[-1]))
    slack = 1e-9 * (top - bottom)  # rounding of heights
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
        f" {np.degrees(wind_angles.MAX_LINEAR_ANGLE):.3g} deg, of which linear aerodynamics says"
        " nothing",
    )


@dataclass(frozen=True, eq=False)
class GustOfSpeed:
    """A gust of a wind speed, which has another wind angle for each vehicle: a function of it.

    `shape`: the gust over time, of any peak. `speed`: wind speed at its peak [m/s]. `plane`: pitch,
    yaw or both; for both it is taken as across the path, where the angle is largest.
    """

    shape: History
    speed: float
    plane: str

    def __call__(self, vehicle: Vehicle) -> History:
        """Return the gust as wind angles [rad] of a vehicle; `NotKnownError` beyond 30 deg."""
        plane = "pitch" if self.plane == "pitch" else "yaw"  # in both planes across the path
        angle = float(
            wind_angles.angle_in_plane(self.speed, vehicle.velocity, vehicle.attitude, plane)
        )
        return self.shape * (wind_angles.checked_linear(angle) / float(self.shape.peak))


def gust_words(gust: GustOf) -> str:
    """Return the peak of a gust, as angle or wind speed, and its duration, in words.

    Of a function of the vehicle other than `GustOfSpeed` neither is known.
    """
    if isinstance(gust, GustOfSpeed):
        peak, shape = f"{gust.speed:g} m/s", gust.shape
    elif isinstance(gust, History):
        peak, shape = f"{np.degrees(float(gust.peak)):.6g} deg", gust
    else:
        return "gust by vehicle"
    return f"gust of {peak}, {float(shape.end - shape.onset):g} s"


def gust_at(gust: GustOf, vehicle: Vehicle) -> History:
    """Return a gust as wind angles [rad] over time: itself, or its function of the vehicle."""
    return gust if isinstance(gust, History) else gust(vehicle)


def _checked_gust(gust: GustOf | None) -> None:
    """Raise `InputError` for a gust that is neither a single history that ends nor a function."""
    if isinstance(gust, History) or not callable(gust):
        checked_gust(gust)


def cut_samples(wind: SampledWind, low: float, high: float) -> tuple[Any, Any]:
    """Return times [s] and angles [rad] of a wind from `low` to `high` [s], ``(k,)`` each.

    The ends and every change of sign are among the samples; a change of sign within rounding of a
    sample is at the sample. Both are empty where the wind is known at no two of these times.
    """
    low, high = max(low, float(wind.time[0])), min(high, float(wind.time[-1]))
    if not low < high:
        return np.empty(0), np.empty(0)
    inside = (wind.time > low) & (wind.time < high)
    times = np.concatenate([[low], wind.time[inside], [high]])
    angles = np.interp(times, wind.time, wind.angle)
    before = np.flatnonzero(angles[:-1] * angles[1:] < 0.0)  # samples before a change of sign
    fraction = angles[before] / (angles[before] - angles[before + 1])
    zero = times[before] + fraction * (times[before + 1] - times[before])  # time of the change
    between = (times[before] < zero) & (zero < times[before + 1])
    after = before[between] + 1
    return np.insert(times, after, zero[between]), np.insert(angles, after, 0.0)
