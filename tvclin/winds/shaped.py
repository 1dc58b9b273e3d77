"""Winds by shape, peak and duration, with a gust and a direction, or sampled wind ensembles.

They are the winds that files and options name and campaigns disperse: `history` makes histories of
the wind angle of attack from dispersed values.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray, IntArray
from tvclin.base.errors import InputError, between, directions, instance, nonzero, number, one_of
from tvclin.base.fields import checked, quantity
from tvclin.vehicle.coefficients import PLANES
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds import pulses
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import (
    CROSS,
    SIGNS,
    EncounteredWind,
    angle_in_plane,
    angles_from_speed,
    angles_from_vector_size,
    sines_by_heading,
)

SHAPES: dict[str, Callable[..., Any]] = {
    "triangular": pulses.TriangularWind,
    "rectangular": pulses.RectangularWind,
    "one-minus-cosine": pulses.OneMinusCosineGust,
}


@dataclass(frozen=True)
class ShapedWind:
    """Wind of an analytical shape, whose peak and duration may be dispersed.

    Attributes
    ----------
    shape : str
        "triangular", "rectangular" or "one-minus-cosine".
    peak : float
        Nominal wind angle of attack [rad].
    duration : float
        Nominal duration [s].
    heading : float, optional
        Direction [rad] from which it blows, clockwise from the direction of flight: pi is a tail
        wind, pi/2 a wind from the right. With it the peak is the size of the vector of both planes.
    gust : History, optional
        Gust on top of the wind and in its direction, such as `OneMinusCosineGust`. Where peak and
        duration are dispersed it keeps its size, and its time from the middle of the wind.
    gust_at : float, optional
        Time of the middle of the gust [s]. Without it a `Case` takes the time of the largest
        requirement, and all else the middle of the wind.
    speed, gust_speed : float, optional
        Peak wind speed of the wind and of its gust [m/s], where they are given; their peaks are
        then the angles of eq (B1e), from `with_speed` and `with_gust_speed`.

    Raises
    ------
    InputError
        For an unknown shape, numbers out of range, and a gust that is a batch or endless.
    """

    shape: str
    peak: float
    duration: float
    heading: float | None = None
    gust: History | None = None
    gust_at: float | None = quantity(
        "time", None, between(-pulses.MAX_DURATION, pulses.MAX_DURATION)
    )
    speed: float | None = quantity("speed", None, nonzero)
    gust_speed: float | None = quantity("speed", None, nonzero)

    count = 0

    def __post_init__(self) -> None:
        """Check the fields; `InputError` as the class says."""
        one_of("shape of the wind", self.shape, SHAPES)
        object.__setattr__(self, "peak", number("peak of the wind", self.peak))
        object.__setattr__(self, "duration", number("duration of the wind", self.duration))
        pulses.checked_peak(self.peak)
        pulses.checked_duration("duration of the wind", self.duration)
        if self.heading is not None:
            number("heading of the wind", self.heading, directions, "rad")
        pulses.checked_gust(self.gust)
        checked(self)

    def in_plane(self, plane: str, attitude: float) -> ShapedWind:
        """Return the component of the wind in a plane, without a heading; itself without one.

        `attitude`: attitude of the flight above the horizontal [rad]. `InputError` for a wind that
        blows in the other plane alone, along a level flight, or faster than the flight.
        """
        if self.heading is None:
            return self
        peak = self.peaks(attitude)[one_of("plane", plane, PLANES)]
        if peak == 0.0:
            windy = next(name for name in PLANES if name != plane)
            raise InputError(
                f"this wind has no part in {plane}: it blows in {windy} alone; take that plane, as"
                f" by --plane {windy}"
            )
        gust = None if self.gust is None else self.gust * (peak / self.peak)
        return replace(self, peak=peak, heading=None, gust=gust, speed=None, gust_speed=None)

    def with_speed(self, speed: float, vehicle: Vehicle, plane: str) -> ShapedWind:
        """Return the wind with the peak angle of a wind speed [m/s] for a vehicle, by eq (B1e).

        With a heading the peak is the size of the vector of both planes. `InputError` for a batch
        of vehicles, an unknown plane, and a speed that makes no wind angle.
        """
        instance("vehicle", vehicle, Vehicle, "see load_vehicle")
        velocity = number("velocity", vehicle.velocity)
        attitude = number("attitude", vehicle.attitude)
        speed = number("speed", speed, unit="m/s")
        one_of("plane", plane, PLANES)
        if self.heading is None:
            peak = float(angle_in_plane(speed, velocity, attitude, plane))
        else:
            peak = math.hypot(*angles_from_speed(speed, velocity, attitude, self.heading))
        return replace(self, peak=peak, speed=speed)

    def with_gust_speed(self, speed: float, vehicle: Vehicle, plane: str) -> ShapedWind:
        """Return the wind with the peak angle of its gust from a wind speed [m/s], by eq (B1e).

        `vehicle`, `plane`: vehicle whose speed and attitude count, and plane of the angle, for a
        wind without a heading. `InputError` without a gust, for a batch of vehicles, an unknown
        plane, and a speed that makes no wind angle.
        """
        if self.gust is None:
            raise InputError("the speed of a gust needs the gust that it is of")
        peak = self.with_speed(speed, vehicle, plane).peak  # the angle of a wind of this speed
        gust = self.gust * (peak / float(self.gust.peak))
        return replace(self, gust=gust, gust_speed=speed)

    def for_vehicle(self, vehicle: Vehicle, plane: str) -> ShapedWind:
        """Return the wind with the peak angles of its speeds, where it has these, for a vehicle.

        `vehicle`, `plane`: as for `with_speed` and `with_gust_speed`, whose errors apply.
        """
        wind = self if self.speed is None else self.with_speed(self.speed, vehicle, plane)
        if wind.gust_speed is None:
            return wind
        return wind.with_gust_speed(wind.gust_speed, vehicle, plane)

    def scaled(self, factor: float) -> ShapedWind:
        """Return the wind with its peak and its gust, as angles and as speeds, times a factor.

        `InputError` for a factor that is zero or no number, and a peak beyond 90 degrees.
        """
        number("factor", factor, nonzero)
        scaled = {
            name: getattr(self, name) * factor
            for name in ("peak", "gust", "speed", "gust_speed")
            if getattr(self, name) is not None
        }
        return replace(self, **scaled)

    def peaks(self, attitude: float) -> dict[str, float]:
        """Return the peak angle [rad] in each plane for a flight of an attitude [rad].

        `InputError` for a wind without a heading, along a level flight, or faster than the flight.
        """
        if self.heading is None:
            raise InputError(
                "both planes need a wind with a direction: give where it blows from, and the"
                " azimuth of the flight"
            )
        climb = number("attitude", attitude, directions, "rad")
        angles = angles_from_vector_size(self.peak, self.heading, climb)
        return dict(zip(PLANES, map(float, angles), strict=True))

    def in_planes(self, values: Mapping[str, Any], attitude: ArrayLike) -> dict[str, History]:
        """Return the winds of cases in each plane; a gust has the direction of its wind.

        Parameters
        ----------
        values : dict
            Dispersed "wind_peak" [rad] and "wind_duration" [s], ``(n,)``.
        attitude : array_like
            Attitude of the flight of each case [rad].

        Raises
        ------
        InputError
            As `peaks`, and for values that are not by name.
        """
        instance("values", values, Mapping, "of dispersed values by name")
        if self.heading is None:
            self.peaks(0.0)  # raises the error about the missing heading
        peak = np.asarray(values.get("wind_peak", self.peak))
        angles = angles_from_vector_size(peak, self.heading or 0.0, attitude)
        wind = self.history(dict(values))
        return {plane: wind * (angle / peak) for plane, angle in zip(PLANES, angles, strict=True)}

    @property
    def gust_text(self) -> str:
        """Text on size, duration and time of the gust; "" without a gust."""
        gust = self.placed_gust
        if gust is None:
            return ""
        size = f"{np.degrees(gust.peak):.4g} deg and {gust.end - gust.onset:.4g} s"
        return f", with a gust of {size} at {0.5 * (gust.onset + gust.end):.4g} s"

    @property
    def placed_gust(self) -> History | None:
        """Gust with its middle at `gust_at`, or in the middle of the wind; None without a gust."""
        return self.gust_history({})  # without dispersed values: the nominal gust

    @property
    def nominal(self) -> dict[str, float]:
        """Nominal values of peak and duration, by the names of their dispersions."""
        return {"wind_peak": self.peak, "wind_duration": self.duration}

    @property
    def max_angle(self) -> float:
        """Largest size of the nominal wind angle [rad], with the gust."""
        return abs(float(self.history({}).peak))

    def history(self, values: dict[str, Any]) -> History:
        """Return the wind angles [rad] of cases, with the gust.

        `values`: dispersed "wind_peak" [rad] and "wind_duration" [s], and the times of the gust,
        "gust_at" [s], ``(n,)``; what is missing has its nominal value.
        """
        numbers = self.nominal | {k: v for k, v in values.items() if k in self.nominal}
        duration = numbers["wind_duration"]
        wind: History = SHAPES[self.shape](peak=numbers["wind_peak"], duration=duration)
        gust = self.gust_history(values)
        return wind if gust is None else wind + gust

    def gust_history(self, values: Mapping[str, Any]) -> History | None:
        """Return the gust of cases in the time of the wind, as angles [rad]; None without a gust.

        `values`: dispersed values by name. A change of "wind_duration" [s], ``(n,)``, shifts the
        gust by its half: the distance to the middle of the wind is kept. "gust_at" is the time of
        the middle of the gust [s], ``(n,)``; without it the middle of the wind.
        `InputError` for values that are not by name, and durations that are no numbers.
        """
        instance("values", values, Mapping, "of dispersed values by name")
        gust = self.gust
        if gust is None:
            return None
        at = values.get("gust_at", 0.5 * self.duration if self.gust_at is None else self.gust_at)
        duration = np.asarray(values.get("wind_duration", self.duration))
        shift = np.asarray(at) - 0.5 * float(gust.onset + gust.end)
        return gust.shift(shift + 0.5 * (duration - self.duration))


def refuse_gust_time(gust_at: float | None, place: str = "at the vehicle's time") -> None:
    """Raise `InputError` for a time of the gust [s] in soundings, which have none of their own.

    `gust_at`: see `ShapedWind`; None passes. `place`: where the gust stands in them, in words.
    """
    if gust_at is not None:
        raise InputError(
            "take peak_time_s out of [gust] (gust.peak_time_s), a time in a pulse; with a sounding"
            f" the gust stands {place}"
        )


def component_in(wind: ShapedWind, peaks: dict[str, float], plane: str) -> History:
    """Return the wind angle [rad] in one plane, of a wind with a heading, with its gust there.

    `peaks`: components [rad] of the wind's peak by plane. The gust has the same direction.
    """
    # `size`: peak of the vector of both planes, with the sign of the wind
    peak, size = peaks[plane], math.copysign(math.hypot(*peaks.values()), wind.peak)
    # zero throughout, with the breakpoints of the wind in the other plane: its peak times zero
    if peak == 0.0:
        return wind.history({"wind_peak": size}) * 0.0
    gust = None if wind.gust is None else wind.gust * (peak / size)
    return replace(wind, peak=peak, heading=None, gust=gust).history({})  # nothing is dispersed


def heading_cosines(heading: float) -> tuple[float, float]:
    """Return the horizontal components of a wind of speed one: along the flight, and across.

    Along is positive from behind, across from the right. `heading`: direction from which the wind
    blows [rad], clockwise from the heading of the flight.
    """
    # on a vertical flight both horizontal components are across the path: the sines of the angles
    along, across = sines_by_heading(heading, np.pi / 2)
    return float(along), float(across)


def encountered_wind(
    wind: ShapedWind,
    vehicle: Vehicle,
    plane: str,
    name: str,
    size: float = 1.0,
    values: Mapping[str, Any] | None = None,
) -> EncounteredWind:
    """Return the wind angles of attack and dynamic pressure in a plane that vehicles encounter.

    `wind`: with its heading, its speeds where they are known, and its gust at its time. `vehicle`:
    one vehicle, or one for each case ``(n,)``. `plane`: of the wind angles of attack. `name`:
    direction of the wind: head, tail or cross. `size`: factor on the wind. `values`: dispersed
    peaks [rad], durations and times of gusts [s]; see `ShapedWind.history`.
    """
    values = values or {}
    path, velocity = np.asarray(vehicle.attitude), np.asarray(vehicle.velocity)
    peak = np.asarray(values.get("wind_peak", wind.peak))
    # angles and speeds are made positive here; their fractions in both planes have the signs
    factor = size * np.sign(peak)
    # wind and gust are each known by the angle [rad], or by the speed over that of the vehicle
    angle: History | None = None
    speed: History | None = None
    base = replace(wind, gust=None, heading=None).history(dict(values))
    if wind.speed is None:
        angle = base * factor
    else:
        speed = base * (factor * wind.speed / (wind.peak * velocity))
    gust = wind.gust_history(values)
    if gust is not None and wind.gust_speed is None:
        angle = gust * factor if angle is None else angle + gust * factor
    elif gust is not None and wind.gust is not None and wind.gust_speed is not None:
        gust = gust * (factor * wind.gust_speed / (float(wind.gust.peak) * velocity))
        speed = gust if speed is None else speed + gust
    if wind.heading is not None:
        # a negative peak blows the other way
        in_pitch, in_yaw = angles_from_vector_size(peak, wind.heading, path)
        of_angle = in_pitch / np.abs(peak), in_yaw / np.abs(peak)
        along, across = heading_cosines(wind.heading)
        sign = float(np.sign(wind.peak))
        of_speed = sign * along, sign * across
    else:
        of_speed = (0.0, 1.0) if name == CROSS else (SIGNS[name], 0.0)
        of_angle = np.asarray(of_speed[0]), np.asarray(of_speed[1])
    return EncounteredWind(
        plane=plane,
        path=path,
        angle=angle,
        speed=speed,
        of_angle=of_angle,  # fractions in pitch and yaw
        of_speed=of_speed,  # fractions along the path and across
    )


@dataclass(frozen=True, eq=False)
class FixedWind:
    """Wind of any shape that is the same in all cases, such as a sounding's.

    `angle`: wind angle of attack [rad]. `why_unknown`: why parts of it are not known, in words;
    empty where it is known.
    """

    angle: History
    why_unknown: str = ""

    count = 0

    @property
    def nominal(self) -> dict[str, float]:
        """Nominal values by the names of their dispersions: none, as the wind is not dispersed."""
        return {}

    @property
    def max_angle(self) -> float:
        """Largest size of the wind angle [rad] over all times, the same in each case."""
        return abs(float(self.angle.peak))

    def history(self, values: dict[str, Any]) -> History:
        """Return the wind angle [rad], whatever the dispersed values of a case, `values`."""
        return self.angle


@dataclass(frozen=True, eq=False)
class WindEnsemble:
    """Ensemble of sampled winds, from which each case draws one.

    Attributes
    ----------
    time : ndarray
        Sample times [s], ``(n,)``.
    angle : ndarray
        Wind angles of attack [rad], straight between the samples, ``(winds, n)``.

    Raises
    ------
    InputError
        As `SampledWind`, for each of the winds.
    """

    time: FloatArray
    angle: FloatArray

    def __post_init__(self) -> None:
        """Check the samples, and set them to arrays; `InputError` as the class says."""
        checked = pulses.SampledWind(time=self.time, angle=self.angle)
        if checked.angle.ndim != 2:
            raise InputError(
                f"angle must hold one wind in each row; got an array of shape {checked.angle.shape}"
            )
        object.__setattr__(self, "time", checked.time)
        object.__setattr__(self, "angle", checked.angle)

    @property
    def count(self) -> int:
        """Number of winds in the ensemble, rows of `angle`."""
        return len(self.angle)

    @property
    def nominal(self) -> dict[str, float]:
        """Nominal values by the names of their dispersions: none, as winds are drawn by index."""
        return {}

    @property
    def max_angle(self) -> float:
        """Largest size of the wind angles [rad] of all winds of the ensemble."""
        return float(np.abs(self.angle).max())

    def chosen(self, numbers: ArrayLike) -> IntArray:
        """Return the index of the wind that each number in (0, 1) draws."""
        return np.asarray(np.asarray(numbers) * self.count, dtype=np.int64)

    def history(self, values: dict[str, Any]) -> History:
        """Return wind angles [rad] of n cases: winds with the indices ``values["wind"]``, ``(n,)``.

        `values`: dispersed values by name; without an index it is the first wind.
        """
        return pulses.SampledWind(time=self.time, angle=self.angle[values.get("wind", 0)])
