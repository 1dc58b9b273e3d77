"""Wind profiles over height, and the wind angle of attack along a flight through them.

A `WindProfile` is the horizontal wind (east, north) [m/s], linear between its levels. Along a
direction of flight psi it has the components

    u = east sin(psi) + north cos(psi)  (pitch, positive a tail wind),
    v = north sin(psi) - east cos(psi)  (yaw, positive from the right),

and a flight of speed V_R and flight path angle gamma encounters the wind angles of eq (B1e),
sin(alpha_w) = (u/V_R) sin(gamma) in pitch and v/V_R in yaw. `Climb` is the simplest flight.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.cards import Carded
from tvclin.base.errors import (
    LATEST,
    InputError,
    bearing,
    between,
    directions,
    each,
    finite,
    instance,
    number,
    one_of,
    positive,
    single,
    text,
    within,
)
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import Piecewise
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.pulses import SampledWind, straight_lines
from tvclin.winds.wind_angles import angle_from_speed

_FIELDS = {"time": "s", "height": "m", "speed": "m/s", "flight_path_angle": "rad"}
_FAR = 1e9
RANGES = {"height": (-1e4, 1e6, "m"), "east": (-1e3, 1e3, "m/s"), "north": (-1e3, 1e3, "m/s")}
"""What can be meant, generously."""
_THINNEST, _THICKEST = 1e-3, 1e6


class Flown(Protocol):
    """A flight as arrays over its time, each of the shape ``(n,)``."""

    @property
    def time(self) -> Any:
        """[s]."""

    @property
    def height(self) -> Any:
        """[m]."""

    @property
    def speed(self) -> Any:
        """[m/s]."""

    @property
    def flight_path_angle(self) -> Any:
        """[rad]."""


def angles_along(
    flight: Flown, height: FloatArray, wind: FloatArray, plane: str, largest: float | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return times [s] and wind angles [rad] of a flight through a wind [m/s] over heights [m].

    The flight is straight between its times. In yaw the wind meets it at right angles. With a
    `largest` angle [rad], the longest time that stays below it alone.
    """
    time, path, speed, climb = checked_flight(flight)
    low, high = max(height[0], path[0]), min(height[-1], path[-1])
    if not low < high:
        raise InputError(
            f"the flight does not reach the wind: it goes from {path[0]:.6g} to {path[-1]:.6g} m,"
            f" and the wind is known from {height[0]:.6g} to {height[-1]:.6g} m"
        )
    met = np.concatenate([height, path])
    met = np.unique(np.concatenate([met[(met > low) & (met < high)], [low, high]]))
    when, known = np.interp(met, path, time), np.interp(met, height, wind)
    apart = np.append(True, np.diff(when) > 0.0)
    when, known = when[apart], known[apart]
    angle = np.pi / 2 if plane == "yaw" else np.interp(when, time, climb)
    flown = np.interp(when, time, speed)
    sine = np.abs(known * np.sin(angle)) / flown
    if largest is not None:
        flat = longest_run(when, sine <= np.sin(largest))
        if flat.stop - flat.start < 2:
            raise InputError(
                f"the wind meets the flight at more than {np.degrees(largest):.3g} deg all the way,"
                " of which linear aerodynamics says nothing"
            )
        angle = np.broadcast_to(angle, when.shape)
        return when[flat], angle_from_speed(known[flat], flown[flat], angle[flat])
    if np.any(sine >= 1.0):
        slow = met[apart][sine >= 1.0]
        raise InputError(
            f"the wind is faster than the flight can meet, first at {slow[0]:.6g} m; leave out the"
            f" slow part of the flight with profile.between({slow[-1]:.6g}, ...)"
        )
    return when, angle_from_speed(known, flown, angle)


def longest_run(times: FloatArray, good: BoolArray) -> slice:
    """Return the places of the longest time in which all is good."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(int)))
    runs = [slice(a, b) for a, b in ends.reshape(-1, 2).tolist()]
    return max(runs, key=lambda one: times[one.stop - 1] - times[one.start], default=slice(0, 0))


def checked_flight(flight: Flown) -> list[FloatArray]:
    """Return the four arrays of a flight; `InputError` where they are none, or do not ascend."""
    try:
        given = {name: getattr(flight, name) for name in _FIELDS}
    except AttributeError:
        raise InputError(
            f"flight must have arrays {', '.join(_FIELDS)} (see steady_climb); got"
            f" {type(flight).__name__}"
        ) from None
    arrays = [within(name, given[name], -_FAR, _FAR, unit) for name, unit in _FIELDS.items()]
    directions("flight_path_angle", arrays[3])
    shape = arrays[0].shape
    if len(shape) != 1 or shape[0] < 2 or any(array.shape != shape for array in arrays):
        raise InputError(
            f"{', '.join(_FIELDS)} of a flight must be arrays of one length, two or more; got"
            f" {', '.join(str(array.shape) for array in arrays)}"
        )
    for name, array in zip(("time", "height"), arrays, strict=False):
        wrong = np.diff(array) <= 0.0
        if np.any(wrong):
            raise InputError(
                f"{name} of a flight must ascend; it does not at index {wrong.argmax()}"
            )
    positive("speed", arrays[2], "m/s")
    return arrays


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class WindProfile(Carded):
    """The horizontal wind over height, straight between its levels.

    Parameters
    ----------
    height : array_like
        Geometric height above the sea [m], ascending, shape ``(n,)``, two levels or more.
    east, north : array_like
        Wind towards east and north [m/s], shape ``(n,)``.
    source : str
        Where it comes from.
    notes : tuple of str
        What a reader should know: gaps bridged, levels left out, heights converted.

    Raises
    ------
    InputError
        For lengths that differ, fewer than two levels, heights that do not ascend, and numbers
        that are not finite or mean neither a height nor a wind.
    """

    height: FloatArray
    east: FloatArray
    north: FloatArray
    source: str = ""
    notes: tuple[str, ...] = ()

    _keys = "height_m speed_m_per_s notes"

    def __post_init__(self) -> None:
        for name, (low, high, unit) in RANGES.items():
            array = within(name, getattr(self, name), low, high, unit)
            object.__setattr__(self, name, array)
            if array.ndim != 1 or array.size < 2 or array.shape != self.height.shape:
                raise InputError(
                    "height, east and north must each hold one number for each of two or more"
                    f" levels; got {name} of shape {array.shape}"
                )
        if np.any(np.diff(self.height) <= 0.0):
            late = int(np.argmax(np.diff(self.height) <= 0.0)) + 1
            raise InputError(
                f"height must ascend; got {self.height[late]:.6g} m at index {late} after"
                f" {self.height[late - 1]:.6g} m"
            )
        text("source", self.source)
        object.__setattr__(self, "notes", each("notes", self.notes, str, "one for each remark"))

    def __repr__(self) -> str:
        low, high = self.height[0], self.height[-1]
        named = f", {self.source}" if self.source else ""
        return f"WindProfile({self.height.size} levels from {low:.6g} to {high:.6g} m{named})"

    @property
    def speed(self) -> FloatArray:
        """Wind speed [m/s] at the levels, shape ``(n,)``."""
        return np.hypot(self.east, self.north)

    def in_plane(self, azimuth: float) -> FloatArray:
        """Return the wind along a direction of flight [m/s] at the levels: positive, a tail wind.

        Parameters
        ----------
        azimuth : float
            Direction of flight [rad], from north, clockwise.
        """
        angle = bearing("azimuth", azimuth)
        return np.asarray(self.east * np.sin(angle) + self.north * np.cos(angle))

    def cross_plane(self, azimuth: float) -> FloatArray:
        """Return the wind across a direction of flight [m/s]: positive, from the right.

        Parameters
        ----------
        azimuth : float
            Direction of flight [rad], from north, clockwise.
        """
        angle = bearing("azimuth", azimuth)
        return np.asarray(self.north * np.sin(angle) - self.east * np.cos(angle))

    def at(self, height: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the wind towards east and north [m/s] at heights [m], in their shape.

        Raises
        ------
        InputError
            For heights beyond the levels.
        """
        wanted = finite("height", height, "m")
        if np.any((wanted < self.height[0]) | (wanted > self.height[-1])):
            raise InputError(
                f"height must be between {self.height[0]:.6g} and {self.height[-1]:.6g} m, where"
                f" the wind is known; got {wanted.min():.6g} to {wanted.max():.6g} m"
            )
        return (
            np.asarray(np.interp(wanted, self.height, self.east)),
            np.asarray(np.interp(wanted, self.height, self.north)),
        )

    def between(self, low: float, high: float) -> Self:
        """Return the part between two heights [m], which become its first and last level.

        Raises
        ------
        InputError
            For heights beyond the levels, or not in order.
        """
        bottom, top = number("low", low, unit="m"), number("high", high, unit="m")
        if not bottom < top:
            raise InputError(f"low must be below high; got {bottom:.6g} and {top:.6g} m")
        inside = self.height[(self.height > bottom) & (self.height < top)]
        height = np.concatenate([[bottom], inside, [top]])
        note = f"cut to {bottom:.6g} to {top:.6g} m"
        return self._changed(height, *self.at(height), note)

    def __sub__(self, other: object) -> WindProfile:
        """Return what is left of the wind if another is taken out of it, where both are known.

        A flight path that is biased for the other wind leaves this to the nozzle.

        Raises
        ------
        InputError
            For profiles without a height in common.
        """
        if not isinstance(other, WindProfile):
            return NotImplemented
        low = max(self.height[0], other.height[0])
        high = min(self.height[-1], other.height[-1])
        if not low < high:
            raise InputError(
                f"the wind taken out is known from {other.height[0]:.6g} to"
                f" {other.height[-1]:.6g} m, and the other one from {self.height[0]:.6g} to"
                f" {self.height[-1]:.6g} m: no height is in both"
            )
        every = np.union1d(self.height, other.height)
        height = every[(every >= low) & (every <= high)]
        east, north = (a - b for a, b in zip(self.at(height), other.at(height), strict=True))
        out = f"without the wind of {other.source}" if other.source else "a mean wind taken out"
        return self._changed(height, east, north, out)

    def smoothed(self, thickness: float) -> Self:
        """Return the running mean over layers of a thickness [m] about each level.

        Near the ends the layer is cut to what is known. The mean is that of the straight lines,
        exactly; between the levels the new profile is straight again.

        Raises
        ------
        InputError
            For a thickness below a millimetre or beyond 1000 km.
        """
        half = number("thickness", thickness, between(_THINNEST, _THICKEST), "m") / 2
        low = np.maximum(self.height - half, self.height[0])
        high = np.minimum(self.height + half, self.height[-1])
        east, north = (
            (self._integral(wind, high) - self._integral(wind, low)) / (high - low)
            for wind in (self.east, self.north)
        )
        note = f"running mean over {2.0 * half:.6g} m"
        return self._changed(self.height, east, north, note)

    def to_wind(self, flight: Flown, *, azimuth: float, plane: str = "pitch") -> SampledWind:
        """Return the wind angle over time that a flight through the profile meets, eq (B1e).

        Parameters
        ----------
        flight : NominalFlight, Climb, or anything like them
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
            In the flight's time, with knots where the flight meets a level of the profile and at
            the flight's own times. Where profile and flight have no height in common it is zero,
            which nobody has measured: the wind is unknown there, not calm.

        Raises
        ------
        InputError
            For a flight that does not reach the wind or does not ascend, an unknown plane, and a
            wind that is zero throughout.

        Notes
        -----
        The speed of the flight stands for V_R, as in the linear theory, where the dynamic
        pressure does not change with the wind either.
        """
        one_of("plane", plane, ("pitch", "yaw"))
        wind = self.in_plane(azimuth) if plane == "pitch" else self.cross_plane(azimuth)
        time, angle = angles_along(flight, self.height, wind, plane)
        return SampledWind(time=time, angle=angle)

    def to_winds(self, flight: Flown, *, azimuth: float) -> PlaneWind:
        """Return the wind angles in both planes that a flight through the profile meets.

        Parameters
        ----------
        flight : NominalFlight, Climb, or anything like them
            As of `to_wind`.
        azimuth : float
            Direction of flight [rad], from north, clockwise.

        Returns
        -------
        PlaneWind
            In pitch with the sine of the flight path angle, eq (B1e), in yaw without. A wind that
            blows in one plane alone is zero in the other.

        Raises
        ------
        InputError
            As `to_wind`; of a wind that is zero in both planes.
        """
        planes = {"pitch": self.in_plane(azimuth), "yaw": self.cross_plane(azimuth)}
        met = [angles_along(flight, self.height, wind, plane) for plane, wind in planes.items()]
        if not any(np.any(angle) for _, angle in met):
            raise InputError("the wind must blow along the flight; it is zero throughout there")
        pitch, yaw = (Piecewise(straight_lines(*one)) for one in met)
        return PlaneWind(pitch=pitch, yaw=yaw)

    def to_rocketpy(self) -> dict[str, list[tuple[float, float]]]:
        """Return ``wind_u`` and ``wind_v`` of RocketPy's custom atmosphere: (height m, m/s)."""
        height = self.height.tolist()
        return {
            name: list(zip(height, wind.tolist(), strict=True))
            for name, wind in (("wind_u", self.east), ("wind_v", self.north))
        }

    def _changed(self, height: FloatArray, east: FloatArray, north: FloatArray, note: str) -> Self:
        notes = (*self.notes, note)
        return replace(self, height=height, east=east, north=north, notes=notes)

    def _integral(self, wind: FloatArray, height: FloatArray) -> FloatArray:
        """Integrate a component from the lowest level to heights, straight lines exactly."""
        widths = np.diff(self.height)
        whole = np.concatenate([[0.0], np.cumsum(widths * (wind[1:] + wind[:-1]) / 2)])
        level = np.clip(np.searchsorted(self.height, height, side="right") - 1, 0, widths.size - 1)
        above, here = height - self.height[level], np.interp(height, self.height, wind)
        return np.asarray(whole[level] + above * (wind[level] + here) / 2)


@dataclass(frozen=True, eq=False)
class Climb:
    """A flight as `WindProfile.to_wind` asks for it; every array has the shape ``(n,)``.

    Attributes
    ----------
    time : ndarray
        [s], ascending.
    height : ndarray
        Geometric height above the sea [m], ascending.
    speed : ndarray
        [m/s].
    flight_path_angle : ndarray
        [rad].

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
        for field, array in zip(fields(self), checked_flight(self), strict=True):
            object.__setattr__(self, field.name, array)


def steady_climb(vehicle: Vehicle, *, height: float, start: float, stop: float) -> Climb:
    """Return the climb of a vehicle that keeps its speed and its flight path angle.

    Parameters
    ----------
    vehicle : Vehicle
        One vehicle; its attitude is the flight path angle, as in the nominal flight.
    height : float
        Where it is [m above the sea] at its own time (zero where it has none).
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
    instance("vehicle", vehicle, Vehicle, "see load_vehicle")
    single("vehicle", vehicle.batch)
    begin, end = (
        number(name, value, between(-LATEST, LATEST), "s")
        for name, value in (("start", start), ("stop", stop))
    )
    if not begin < end:
        raise InputError(f"stop must be after start; got {begin:.6g} and {end:.6g} s")
    rate = float(vehicle.velocity * np.sin(vehicle.attitude))
    if not rate > 0.0:
        raise InputError(f"vehicle must climb; its height changes by {rate:.6g} m/s")
    time = np.array([begin, end])
    own = 0.0 if vehicle.time is None else float(vehicle.time)
    return Climb(
        time=time,
        height=number("height", height, unit="m") + rate * (time - own),
        speed=np.full(2, float(vehicle.velocity)),
        flight_path_angle=np.full(2, float(vehicle.attitude)),
    )
