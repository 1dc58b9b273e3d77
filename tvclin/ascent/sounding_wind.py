"""Sounding as the wind of a vehicle at one time of its flight."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from tvclin.ascent.measured_wind import GustOf, MeasuredWind, fly_through
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.errors import InputError, NotKnownError, instance, number, positive
from tvclin.vehicle.linear_vehicle import complete_vehicle
from tvclin.winds.histories import History, VehicleWind
from tvclin.winds.soundings.profile import WindProfile

WINDOW_S = 20.0
"""Default length [s] of the part of a sounding that counts, about the time of the vehicle."""
_TIME = "the vehicle's time"
"""Name of the flight time in messages."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SoundingWind(VehicleWind):
    """Wind of a sounding that a vehicle encounters around its time of flight.

    As over a whole flight, the part with the sign of its peak counts, for boundaries are defined
    for winds of one sign.

    Attributes
    ----------
    name : str
        Name of the sounding.
    profile : WindProfile
        Wind over height.
    schedule : FlightSchedule
        Flight of the vehicle, with its altitude.
    azimuth : float
        Direction of flight [rad], from north, clockwise.
    window : float
        Length [s] of the interval that counts, about the time of the vehicle.
    gust : History or callable, optional
        Gust on top of it; see `MeasuredWind`.
    bias : WindProfile, optional
        Mean wind for which the flight path is biased; see `fly_through`.
    in_flight : bool
        Whether the history is in flight time, or begins at zero.
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
        instance("profile", self.profile, WindProfile, "see read_sounding")
        instance("schedule", self.schedule, FlightSchedule, "see load_schedule")
        number("window", self.window, positive, "s")

    @property
    def shape(self) -> str:
        """Name of the sounding."""
        return self.name

    def history(self, vehicle: Any, plane: str) -> History:
        """Return the wind angle of attack [rad] of a vehicle in a plane.

        Raises
        ------
        InputError
            For a vehicle without a time of flight, and for a wind that is calm or not known at
            that time.
        """
        wind, time = self._along(plane), self._time(vehicle)
        first, last = wind.known
        history = wind(complete_vehicle(vehicle, "a sounding")) if first <= time <= last else None
        if history is None:
            raise NotKnownError(f"the wind of {self.name} is not known at {time:g} s, {_TIME}")
        if not history.peak:
            raise InputError(f"the wind of {self.name} is calm at {time:g} s, {_TIME}")
        return history if self.in_flight else history.shift(-float(history.onset))

    def notes(self, vehicle: Any, plane: str) -> Iterator[str]:
        """Yield notes on the sounding, and that it ends within its window."""
        yield from (f"{self.name}: {note}" for note in self.profile.notes)
        first, last = self._along(plane).known
        time, half = self._time(vehicle), self.window / 2
        if time - half < first or last < time + half:
            yield (
                f"{self.name} is known from {first:.6g} to {last:.6g} s of flight only; the wind"
                " beyond is not counted"
            )

    def _along(self, plane: str) -> MeasuredWind:
        """Return the wind in a plane along the whole flight."""
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
        """Return the time [s] of a vehicle in its flight."""
        time = complete_vehicle(vehicle, "a sounding").time
        if time is None:
            raise InputError("a sounding needs a vehicle with its time of flight, time_s")
        return float(time)
