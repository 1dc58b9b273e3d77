"""Wind profiles over height, and the wind angle of attack along a flight through them.

A `WindProfile` is the horizontal wind (east, north) [m/s], linear between its levels. Along a
direction of flight psi it has the components

    u = east sin(psi) + north cos(psi)  (pitch, positive a tail wind),
    v = north sin(psi) - east cos(psi)  (yaw, positive from the right),

and a flight of speed V_R and flight path angle gamma encounters the wind angles of eq (B1e),
sin(alpha_w) = (u/V_R) sin(gamma) in pitch and v/V_R in yaw. `Climb` is the simplest flight.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.cards import Record
from tvclin.base.fields import derived, spec
from tvclin.base.lines import plural
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import Piecewise
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.pulses import SampledWind, piecewise_linear
from tvclin.winds.wind_angles import angle_from_speed

_FLIGHT_ARRAYS = {"time": "s", "height": "m", "speed": "m/s", "flight_path_angle": "rad"}
_MAX_FLIGHT_NUMBER = 1e9
RANGES = {"height": (-1e4, 1e6, "m"), "east": (-1e3, 1e3, "m/s"), "north": (-1e3, 1e3, "m/s")}
"""Smallest and largest value, with its unit, of each array of a profile."""
MAX_LEVEL_DISTANCE = 2000.0
"""Largest distance of two levels [m] between which the wind of an archive is known."""
_MIN_THICKNESS, _MAX_THICKNESS = 1e-3, 1e6
"""Smallest and largest thickness [m] of a running mean."""


class FlightPath(Protocol):
    """Flight as arrays over its time, each of the shape ``(n,)``."""

    @property
    def time(self) -> Any:
        """Time [s], ``(n,)``."""

    @property
    def height(self) -> Any:
        """Height [m], ``(n,)``."""

    @property
    def speed(self) -> Any:
        """Speed relative to the air [m/s], ``(n,)``."""

    @property
    def flight_path_angle(self) -> Any:
        """Flight path angle [rad], ``(n,)``."""


def wind_angles_along(
    flight: FlightPath,
    height: FloatArray,
    wind: FloatArray,
    plane: str,
    largest: float | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Return times [s] and wind angles [rad] of a flight through a wind [m/s] over heights [m].

    `height`, `wind`: heights of the levels and winds there, ``(n,)``, along the flight in the plane
    "pitch", and at right angles to it in "yaw". The flight is linear between its times. With a
    `largest` angle [rad] only the longest interval below it is returned.
    """
    time, path, speed, climb = checked_flight(flight)
    bottom, top = max(height[0], path[0]), min(height[-1], path[-1])
    if not bottom < top:
        raise errors.InputError(
            f"the flight does not reach the wind: it goes from {path[0]:.6g} to {path[-1]:.6g} m,"
            f" and the wind is known from {height[0]:.6g} to {height[-1]:.6g} m"
        )
    heights = np.concatenate([height, path])
    heights = np.unique(
        np.concatenate([heights[(heights > bottom) & (heights < top)], [bottom, top]])
    )
    times, wind_speed = np.interp(heights, path, time), np.interp(heights, height, wind)
    # heights within rounding of each other have one time
    distinct = np.append(True, np.diff(times) > 0.0)
    times, wind_speed = times[distinct], wind_speed[distinct]
    # a wind across the path is at right angles to it: the sine of eq (B1e) is one
    angle = np.pi / 2 if plane == "yaw" else np.interp(times, time, climb)
    flight_speed = np.interp(times, time, speed)
    sine = np.abs(wind_speed * np.sin(angle)) / flight_speed
    interval = slice(None)
    if largest is not None:
        interval = longest_interval(times, sine <= np.sin(largest))
        if interval.stop - interval.start < 2:
            raise errors.InputError(
                f"the wind meets the flight at more than {np.degrees(largest):.3g} deg all the way,"
                " of which linear aerodynamics says nothing"
            )
    elif np.any(sine >= 1.0):
        unreachable = heights[distinct][sine >= 1.0]
        raise errors.InputError(
            f"the wind is faster than the flight can meet, first at {unreachable[0]:.6g} m; leave"
            f" out the slow part of the flight with profile.between({unreachable[-1]:.6g}, ...)"
        )
    angle = np.broadcast_to(angle, times.shape)[interval]
    return times[interval], angle_from_speed(wind_speed[interval], flight_speed[interval], angle)


def longest_interval(times: FloatArray, good: BoolArray) -> slice:
    """Return the slice of the longest interval of times [s] in which all elements are `good`.

    `times`, `good`: ``(n,)`` each. An empty slice if none is good.
    """
    # begins and ends of runs, one after the other: where `good` changes
    ends = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(int)))
    runs = [slice(a, b) for a, b in ends.reshape(-1, 2).tolist()]
    return max(runs, key=lambda run: times[run.stop - 1] - times[run.start], default=slice(0, 0))


def gap_words(gaps: FloatArray) -> str:
    """Return gaps of a sounding in words: the widest, and the number of others; empty for none.

    `gaps`: heights [m] of the levels below and above each gap, ``(gaps, 2)``.
    """
    if not gaps.size:
        return ""
    lower, upper = gaps[np.argmax(np.diff(gaps))] / 1e3
    others = f" and in {plural(len(gaps) - 1, 'other gap')}" if len(gaps) > 1 else ""
    return f"from {lower:.3g} to {upper:.3g} km{others}"


def checked_flight(flight: FlightPath) -> list[FloatArray]:
    """Return time [s], height [m], speed [m/s] and path angle [rad] of a flight, ``(n,)`` each.

    `InputError` for a flight that is malformed, or does not ascend.
    """
    try:
        values = {name: getattr(flight, name) for name in _FLIGHT_ARRAYS}
    except AttributeError:
        raise errors.InputError(
            f"flight must have arrays {', '.join(_FLIGHT_ARRAYS)} (see steady_climb); got"
            f" {type(flight).__name__}"
        ) from None
    arrays = [
        errors.within(name, values[name], -_MAX_FLIGHT_NUMBER, _MAX_FLIGHT_NUMBER, unit)
        for name, unit in _FLIGHT_ARRAYS.items()
    ]
    time, height, speed, path_angle = arrays
    errors.directions("flight_path_angle", path_angle)
    shape = time.shape
    if len(shape) != 1 or shape[0] < 2 or any(array.shape != shape for array in arrays):
        raise errors.InputError(
            f"{', '.join(_FLIGHT_ARRAYS)} of a flight must be arrays of one length, two or more;"
            f" got {', '.join(str(array.shape) for array in arrays)}"
        )
    for name, array in (("time", time), ("height", height)):
        descending = np.diff(array) <= 0.0
        if np.any(descending):
            raise errors.InputError(
                f"{name} of a flight must ascend; it does not at index {descending.argmax()}"
            )
    errors.positive("speed", speed, "m/s")
    return arrays


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class WindProfile(Record):
    """Horizontal wind over height, linear between its levels.

    Parameters
    ----------
    height : array_like
        Geometric height above the sea [m], ascending, shape ``(n,)``, two levels or more.
    east, north : array_like
        Wind towards east and north [m/s], shape ``(n,)``.
    source : str
        Origin of the data.
    notes : tuple of str
        Remarks: gaps bridged, levels omitted, heights converted.

    Raises
    ------
    InputError
        For lengths that differ, fewer than two levels, heights that do not ascend, and numbers
        that are not finite or mean neither a height nor a wind.
    """

    height: FloatArray = field(metadata=spec("length"))
    east: FloatArray
    north: FloatArray
    source: str = ""
    notes: tuple[str, ...] = field(default=(), metadata=spec())

    def __post_init__(self) -> None:
        """Check the levels, and set them to arrays; `InputError` as the class says."""
        for name, (low, high, unit) in RANGES.items():
            array = errors.within(name, getattr(self, name), low, high, unit)
            object.__setattr__(self, name, array)
            if array.ndim != 1 or array.size < 2 or array.shape != self.height.shape:
                raise errors.InputError(
                    "height, east and north must each hold one number for each of two or more"
                    f" levels; got {name} of shape {array.shape}"
                )
        if np.any(np.diff(self.height) <= 0.0):
            index = int(np.argmax(np.diff(self.height) <= 0.0)) + 1
            raise errors.InputError(
                f"height must ascend; got {self.height[index]:.6g} m at index {index} after"
                f" {self.height[index - 1]:.6g} m"
            )
        errors.text("source", self.source)
        object.__setattr__(
            self, "notes", errors.each("notes", self.notes, str, "one for each remark")
        )

    def __repr__(self) -> str:
        """Return the number of levels, their range of height and the source, as text."""
        low, high = self.height[0], self.height[-1]
        named = f", {self.source}" if self.source else ""
        return f"WindProfile({self.height.size} levels from {low:.6g} to {high:.6g} m{named})"

    @property
    @derived("speed")
    def speed(self) -> FloatArray:
        """Wind speed [m/s] at the levels, shape ``(n,)``."""
        return np.hypot(self.east, self.north)

    @property
    def resolved_wavelength(self) -> float:
        """Vertical wavelength [m] that all levels resolve: twice their widest gap."""
        return 2.0 * float(np.diff(self.height).max())

    def notes_along(self, flight: FlightPath) -> list[str]:
        """Return the notes, and one on wide gaps between levels along a flight.

        `InputError` for a flight that is malformed or does not ascend.
        """
        _, height, _, _ = checked_flight(flight)
        gap = self.gaps_between(height[0], height[-1])
        if not gap:
            return [*self.notes]
        unknown = "in gaps of more than 2 km the wind is not known, and straight lines are shown"
        return [*self.notes, f"no level {gap}: {unknown}"]

    def gaps_between(self, low: float, high: float) -> str:
        """Return the gaps between levels that reach into an interval of heights, in words.

        `low`, `high`: ends of the interval [m]. In a gap of more than `MAX_LEVEL_DISTANCE` the wind
        is not known; empty without one. `InputError` for heights that are no numbers.
        """
        bottom, top = errors.number("low", low, unit="m"), errors.number("high", high, unit="m")
        gaps = self.gaps
        return gap_words(gaps[(gaps[:, 0] < top) & (gaps[:, 1] > bottom)])

    @property
    def gaps(self) -> FloatArray:
        """Heights [m] of the levels below and above each gap, ``(gaps, 2)``.

        In a gap, between levels more than `MAX_LEVEL_DISTANCE` apart, the wind is not known.
        """
        levels = np.stack([self.height[:-1], self.height[1:]], axis=-1)
        return levels[np.diff(levels)[:, 0] > MAX_LEVEL_DISTANCE]

    def in_plane(self, azimuth: float) -> FloatArray:
        """Return the wind component along a direction of flight [m/s], positive a tail wind.

        Parameters
        ----------
        azimuth : float
            Direction of flight [rad], from north, clockwise.
        """
        angle = errors.bearing("azimuth", azimuth)
        return np.asarray(self.east * np.sin(angle) + self.north * np.cos(angle))

    def cross_plane(self, azimuth: float) -> FloatArray:
        """Return the wind component across a direction of flight [m/s], positive from the right.

        Parameters
        ----------
        azimuth : float
            Direction of flight [rad], from north, clockwise.
        """
        angle = errors.bearing("azimuth", azimuth)
        return np.asarray(self.north * np.sin(angle) - self.east * np.cos(angle))

    def at(self, height: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the wind towards east and north [m/s] at heights [m], in their shape.

        `InputError` for heights beyond the levels.
        """
        heights = errors.finite("height", height, "m")
        if np.any((heights < self.height[0]) | (heights > self.height[-1])):
            raise errors.InputError(
                f"height must be between {self.height[0]:.6g} and {self.height[-1]:.6g} m, where"
                f" the wind is known; got {heights.min():.6g} to {heights.max():.6g} m"
            )
        return (
            np.asarray(np.interp(heights, self.height, self.east)),
            np.asarray(np.interp(heights, self.height, self.north)),
        )

    def between(self, low: float, high: float) -> Self:
        """Return the profile between heights `low` and `high` [m], its new first and last level.

        `InputError` for heights beyond the levels, or not in order.
        """
        bottom, top = errors.number("low", low, unit="m"), errors.number("high", high, unit="m")
        if not bottom < top:
            raise errors.InputError(f"low must be below high; got {bottom:.6g} and {top:.6g} m")
        inside = self.height[(self.height > bottom) & (self.height < top)]
        height = np.concatenate([[bottom], inside, [top]])
        note = f"cut to {bottom:.6g} to {top:.6g} m"
        return self._changed(height, *self.at(height), note)

    def __sub__(self, mean: object) -> WindProfile:
        """Return the difference to another profile, such as a mean wind, at the heights of both.

        A flight path that is biased for the other wind encounters this difference. `InputError` for
        profiles without a height in common.
        """
        if not isinstance(mean, WindProfile):
            return NotImplemented
        low, high = max(self.height[0], mean.height[0]), min(self.height[-1], mean.height[-1])
        if not low < high:
            raise errors.InputError(
                f"the wind taken out is known from {mean.height[0]:.6g} to"
                f" {mean.height[-1]:.6g} m, and the other one from {self.height[0]:.6g} to"
                f" {self.height[-1]:.6g} m: no height is in both"
            )
        heights = np.union1d(self.height, mean.height)
        height = heights[(heights >= low) & (heights <= high)]
        east, north = (a - b for a, b in zip(self.at(height), mean.at(height), strict=True))
        note = f"without the wind of {mean.source}" if mean.source else "a mean wind taken out"
        return self._changed(height, east, north, note)

    def smoothed(self, thickness: float) -> Self:
        """Return the running mean over layers of a thickness [m] about each level.

        Near the ends the layer is cut to the known heights. The mean of the linear profile is
        exact; between the levels the new profile is linear again. `InputError` for a thickness
        below a millimetre or beyond 1000 km.
        """
        allowed = errors.between(_MIN_THICKNESS, _MAX_THICKNESS)
        half = errors.number("thickness", thickness, allowed, "m") / 2
        low = np.maximum(self.height - half, self.height[0])
        high = np.minimum(self.height + half, self.height[-1])
        east, north = (
            (self._integral(wind, high) - self._integral(wind, low)) / (high - low)
            for wind in (self.east, self.north)
        )
        note = f"running mean over {2.0 * half:.6g} m"
        return self._changed(self.height, east, north, note)

    def to_wind(self, flight: FlightPath, *, azimuth: float, plane: str = "pitch") -> SampledWind:
        """Return the wind angle over time along a flight through the profile, eq (B1e).

        Parameters
        ----------
        flight : FlightSchedule, Climb, or anything like them
            Has arrays ``time`` [s], ``height`` [m], ``speed`` [m/s] and ``flight_path_angle``
            [rad], one number for each time, and ascends.
        azimuth : float
            Direction of flight [rad], from north, clockwise.
        plane : {"pitch", "yaw"}
            Pitch: the wind along the flight, positive a tail wind. Yaw: the wind across,
            positive from the right.

        Returns
        -------
        SampledWind
            Wind over the flight's time, with knots at the levels of the profile and at the flight's
            own times. Where profile and flight have no height in common it is zero, which is not a
            measurement: the wind is unknown there, not calm.

        Raises
        ------
        InputError
            For a flight that does not reach the wind or does not ascend, an unknown plane, and a
            wind that is zero throughout.

        Notes
        -----
        The speed of the flight stands for V_R, the speed through the air, as in the linear
        theory, where the dynamic pressure does not change with the wind either.
        """
        errors.one_of("plane", plane, ("pitch", "yaw"))
        wind = self.in_plane(azimuth) if plane == "pitch" else self.cross_plane(azimuth)
        time, angle = wind_angles_along(flight, self.height, wind, plane)
        return SampledWind(time=time, angle=angle)

    def to_winds(self, flight: FlightPath, *, azimuth: float) -> PlaneWind:
        """Return the wind angles in both planes along a flight through the profile.

        Parameters
        ----------
        flight : FlightSchedule, Climb, or anything like them
            Same as in `to_wind`.
        azimuth : float
            Direction of flight [rad], from north, clockwise.

        Returns
        -------
        PlaneWind
            Pitch with the sine of the flight path angle, eq (B1e), yaw without it. A wind in a
            single plane is zero in the other.

        Raises
        ------
        InputError
            For a flight that does not reach the wind or does not ascend, and a wind that is zero in
            both planes.
        """
        planes = {"pitch": self.in_plane(azimuth), "yaw": self.cross_plane(azimuth)}
        samples = [
            wind_angles_along(flight, self.height, wind, plane) for plane, wind in planes.items()
        ]
        if not any(np.any(angle) for _, angle in samples):
            raise errors.InputError(
                "the wind must blow along the flight; it is zero throughout there"
            )
        pitch, yaw = (Piecewise(piecewise_linear(*sample)) for sample in samples)
        return PlaneWind(pitch=pitch, yaw=yaw)

    def to_rocketpy(self) -> dict[str, list[tuple[float, float]]]:
        """Return ``wind_u`` and ``wind_v`` of RocketPy's custom atmosphere: (height m, m/s)."""
        height = self.height.tolist()
        return {
            name: list(zip(height, wind.tolist(), strict=True))
            for name, wind in (("wind_u", self.east), ("wind_v", self.north))
        }

    def _changed(self, height: FloatArray, east: FloatArray, north: FloatArray, note: str) -> Self:
        """Return the profile with other levels [m] and winds [m/s], ``(k,)``, and one more note."""
        notes = (*self.notes, note)
        return replace(self, height=height, east=east, north=north, notes=notes)

    def _integral(self, wind: FloatArray, height: FloatArray) -> FloatArray:
        """Return the integral [m^2/s] of a wind from the lowest level to heights [m], ``(k,)``.

        `wind`: component at the levels [m/s], ``(n,)``, linear between them, so that the integral
        is exact by trapezoids.
        """
        widths = np.diff(self.height)
        cumulative = np.concatenate([[0.0], np.cumsum(widths * (wind[1:] + wind[:-1]) / 2)])
        level = np.clip(np.searchsorted(self.height, height, side="right") - 1, 0, widths.size - 1)
        offset, value = height - self.height[level], np.interp(height, self.height, wind)
        return np.asarray(cumulative[level] + offset * (wind[level] + value) / 2)


@dataclass(frozen=True, eq=False)
class Climb:
    """Flight with the arrays that `WindProfile.to_wind` takes, each of the shape ``(n,)``.

    Attributes
    ----------
    time : ndarray
        Time [s], ascending.
    height : ndarray
        Geometric height above the sea [m], ascending.
    speed : ndarray
        Speed relative to the air [m/s].
    flight_path_angle : ndarray
        Flight path angle [rad].

    Raises
    ------
    InputError
        For arrays of different lengths or of one time, and for numbers that are not finite, times
        and heights that do not ascend, and speeds that are not positive.
    """

    time: FloatArray
    height: FloatArray
    speed: FloatArray
    flight_path_angle: FloatArray

    def __post_init__(self) -> None:
        """Check the arrays, and set them; `InputError` as the class says."""
        for item, array in zip(fields(self), checked_flight(self), strict=True):
            object.__setattr__(self, item.name, array)


def steady_climb(vehicle: Vehicle, *, height: float, start: float, stop: float) -> Climb:
    """Return the climb of a vehicle at constant speed and flight path angle.

    Parameters
    ----------
    vehicle : Vehicle
        One vehicle; its attitude is the flight path angle, as in the nominal flight.
    height : float
        Height above the sea [m] at the vehicle's own time (zero where it has none).
    start, stop : float
        First and last time [s].

    Raises
    ------
    InputError
        For a batch, a stop not after the start, and a vehicle that does not climb.

    Examples
    --------
    >>> import tvclin as tv
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> tv.winds.steady_climb(vehicle, height=11950.0, start=53.0, stop=79.0).height.round(1)
    array([ 7011.8, 16888.2])
    """
    errors.instance("vehicle", vehicle, Vehicle, "see load_vehicle")
    errors.single("vehicle", vehicle.batch)
    begin, end = (
        errors.number(name, value, errors.between(-errors.MAX_TIME, errors.MAX_TIME), "s")
        for name, value in (("start", start), ("stop", stop))
    )
    if not begin < end:
        raise errors.InputError(f"stop must be after start; got {begin:.6g} and {end:.6g} s")
    rate = float(vehicle.velocity * np.sin(vehicle.attitude))
    if not rate > 0.0:
        raise errors.InputError(f"vehicle must climb; its height changes by {rate:.6g} m/s")
    time = np.array([begin, end])
    vehicle_time = 0.0 if vehicle.time is None else float(vehicle.time)
    return Climb(
        time=time,
        height=errors.number("height", height, unit="m") + rate * (time - vehicle_time),
        speed=np.full(2, float(vehicle.velocity)),
        flight_path_angle=np.full(2, float(vehicle.attitude)),
    )
