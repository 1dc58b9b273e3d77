"""Where in the flight a wind blows: moved so that its peak meets a time, or cut where it is."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from tvclin.answers.sizing.measured import MeasuredWind
from tvclin.base.errors import (
    InputError,
    instance,
    number,
    one_of,
    positive,
)
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History

PLACINGS = ("peak", "flight")

WindOf = History | Callable[[Vehicle], History]
"""A wind, or what gives the wind that a vehicle meets: of a wind speed, an angle."""

_TOP = 1.0 - 1e-12
"""All that is higher than this part of the peak belongs to it: the top may be flat."""


@dataclass(frozen=True, eq=False)
class PlacedWind:
    """A wind in a flight.

    Attributes
    ----------
    history : History
        The wind in its own time.
    zero : float
        Flight time [s] at its own zero.
    known : bool
        Whether it is known at all; what stands for an unknown wind is calm.
    whole : History or None
        The same with what blows to the other side, where the wind blows to both.
    """

    history: History
    zero: float
    known: bool = True
    whole: History | None = None

    @property
    def calm(self) -> bool:
        """Whether no wind is left."""
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
    """Return winds by name; one alone is called "wind". `InputError` if there is none."""
    found = dict(winds) if isinstance(winds, Mapping) else {"wind": winds}
    if not found:
        raise InputError("winds must hold one wind or more; got none")
    return found


def placings(winds: Mapping[str, WindOf], placing: str | Mapping[str, str]) -> dict[str, str]:
    """Return the placing of each wind by its name; `InputError` for unknown ones."""
    if isinstance(placing, str):
        return dict.fromkeys(winds, one_of("placing", placing, PLACINGS))
    instance("placing", placing, Mapping, "of names to peak or flight, or one of these")
    for name, value in placing.items():
        one_of("placing's winds", name, winds)
        one_of(f"placing of {name}", value, PLACINGS)
    return {name: placing.get(name, PLACINGS[0]) for name in winds}


def known_times(wind: WindOf) -> tuple[float, float]:
    """Return the first and the last flight time [s] at which a wind is known."""
    return wind.known if isinstance(wind, MeasuredWind) else (-np.inf, np.inf)


def place(wind: WindOf, vehicle: Vehicle, time: float, placing: str, window: float) -> PlacedWind:
    """Return a wind placed at a flight time; a measured one has its place already.

    Parameters
    ----------
    wind : History or callable
        One wind that ends, or what gives it for a vehicle.
    vehicle : Vehicle
        The vehicle at that time.
    time : float
        Flight time [s].
    placing : {"peak", "flight"}
        Whether the wind's peak is moved to that time (the middle of a flat top), or the wind is in
        flight time already and what blows within half a window of it counts.
    window : float
        Length of the window [s].

    Raises
    ------
    InputError
        For a batch of winds, and one that never ends or is zero.
    """
    if isinstance(wind, MeasuredWind):
        first, last = wind.known
        if not first <= time <= last:
            return PlacedWind(wind.wind * 0.0, 0.0, known=False)
        both = wind.to_both_sides(vehicle)
        values = both(both.probe_times())
        two_sided = values.min() < 0.0 < values.max()
        return PlacedWind(wind(vehicle), 0.0, whole=both if two_sided else None)
    history = wind(vehicle) if not isinstance(wind, History) and callable(wind) else wind
    if not isinstance(history, History) or history.batch:
        raise InputError("each wind must be one history, such as TriangularWind, or give one")
    if not np.isfinite(history.end):
        raise InputError("each wind must end, and be other than zero")
    if placing == "peak":
        return PlacedWind(history, time - _middle_of_the_top(history))
    half = 0.5 * number("window", window, positive, "s")
    return PlacedWind(history.before(time + half) - history.before(time - half), 0.0)


def _middle_of_the_top(wind: History) -> float:
    times = wind.probe_times()
    values = np.abs(wind(times))
    top = times[values >= _TOP * values.max()]
    return 0.5 * float(top[0] + top[-1])
