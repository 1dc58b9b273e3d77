"""Measured winds on a flight: what blows to one side, around a flight time, a gust on top."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.answers.sizing.schedule import FlightSchedule
from tvclin.base.errors import (
    InputError,
    ending,
    instance,
    number,
    positive,
    shown,
    single,
)
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.sampled import SampledWind
from tvclin.winds.soundings.profile import WindProfile


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
    gust : History, optional
        Added to it, on the wind's side if its peak is positive; its middle meets the flight time.
        Nothing is added to a calm.
    """

    wind: SampledWind
    window: float | None = None
    gust: History | None = None

    def __post_init__(self) -> None:
        instance("wind", self.wind, SampledWind, "see fly_through")
        single("wind", self.wind.batch)
        if self.window is not None:
            number("window", self.window, positive, "s")
        if self.gust is not None:
            instance("gust", self.gust, History, "such as OneMinusCosineGust")
            single("gust", self.gust.batch)
            ending("gust", self.gust.end)

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

    def _around(self, vehicle: Vehicle, other: float) -> History:
        """The wind around a vehicle's time, and to the other side what is below an angle [rad]."""
        instance("vehicle", vehicle, Vehicle, "see FlightSchedule.at")
        single("vehicle", vehicle.batch)
        if vehicle.time is None:
            raise InputError("vehicle must have a time [s], at which it meets the wind")
        time = float(np.asarray(vehicle.time))
        half = np.inf if self.window is None else 0.5 * self.window
        times, angles = cut_samples(self.wind, time - half, time + half)
        if times.size < 2 or not np.any(angles):
            return self.wind * 0.0
        side = float(np.sign(angles[np.argmax(np.abs(angles))]))
        around = SampledWind(time=times, angle=side * np.maximum(side * angles, -other))
        if self.gust is None:
            return around
        middle = 0.5 * (self.gust.onset + self.gust.end)
        return around + self.gust.shift(float(time - middle)) * side


def fly_through(
    profile: WindProfile,
    schedule: FlightSchedule,
    *,
    azimuth: float,
    plane: str = "pitch",
    window: float | None = None,
    gust: History | None = None,
) -> MeasuredWind:
    """Return the wind that a flight through a sounding meets, as `size` takes it.

    Parameters
    ----------
    profile : WindProfile
        The wind over height; see `read_sounding`.
    schedule : FlightSchedule
        The flight, with its altitude.
    azimuth : float
        Direction of flight [rad], from north, clockwise.
    plane : {"pitch", "yaw"}
        As of `WindProfile.to_wind`.
    window, gust
        As of `MeasuredWind`.

    Raises
    ------
    InputError
        For a schedule without altitude, and as `WindProfile.to_wind`.

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
    if gust is not None and (not isinstance(gust, History) or gust.batch):
        raise InputError(f"gust must be one history, such as OneMinusCosineGust; got {shown(gust)}")
    wind = profile.to_wind(schedule, azimuth=azimuth, plane=plane)
    return MeasuredWind(wind, window, gust)


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
