"""The autopilot requirement over a flight: at each flight time that of the winds placed there.

It is the smallest limit above which this autopilot survives with every limit, flown along the
flight with its samples, delay, filters, bending and rate limit, at the dynamic pressure
encountered. At one frozen time it is `autopilot_requirement`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from tvclin.ascent.wind_along import WindAlong, sounding_along, wind_along
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import (
    InputError,
    NotKnownError,
    callable_for,
    instance,
    number,
    one_of,
    positive,
    unlimited,
)
from tvclin.base.fields import spec
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.gain_schedule import GainSchedule
from tvclin.flights.closed_loop.fly_along import checked_flight
from tvclin.flights.closed_loop.limit_along import limit_of_flight
from tvclin.flights.closed_loop.survival_limit import OPEN
from tvclin.requirement.flight.flight_winds import (
    PlacedWind,
    WindOf,
    named_winds,
    place,
    placings,
)
from tvclin.requirement.flight.sizing import Sizing, flight_times
from tvclin.vehicle.coefficients import PLANES
from tvclin.winds.wind_angles import FROZEN, SIGNS


@dataclass(frozen=True, eq=False)
class AutopilotRequirements(Shown):
    """Autopilot requirements over a flight.

    Attributes
    ----------
    times : ndarray
        Flight times [s], ``(n,)``.
    winds : tuple of str
        Names of the winds.
    limit : ndarray
        Autopilot requirements [rad], ``(n, m)``: the larger of head and tail wind for a pulse.
        Infinite where no limit up to twice the largest trim deflection survives, NaN where the
        requirement is not known.
    reasons : tuple of str
        Reasons why requirements are not known or not certain; often none.
    """

    times: FloatArray = field(metadata=spec("time"))
    winds: tuple[str, ...] = field(metadata=spec())
    limit: FloatArray = field(metadata=spec("angle"))
    reasons: tuple[str, ...] = field(metadata=spec())

    @property
    def at_times(self) -> FloatArray:
        """Requirement [rad] in the worst wind of each time, ``(n,)``; NaN if one is not known."""
        return np.max(self.limit, axis=1)


def autopilot_requirements(
    sizing: Sizing,
    autopilot: Autopilot | GainSchedule,
    winds: WindOf | Mapping[str, WindOf],
    *,
    rate_limit: float = np.inf,
    sign: str | None = None,
    placing: str | Mapping[str, str] = "peak",
    window: float = 20.0,
    progress: Callable[[int, int], None] | None = None,
) -> AutopilotRequirements:
    """Return the autopilot requirement of each wind at each flight time of a sizing.

    Parameters
    ----------
    sizing : Sizing
        Flight, flight times, model and plane; of one plane.
    autopilot : Autopilot or GainSchedule
        Autopilot with a sample rate.
    winds, placing, window, progress
        Winds of the sizing; see `size`. Each is flown from its onset to the end of the flight.
    rate_limit : float
        Rate limit [rad/s], positive.
    sign : {"head", "tail", "frozen"}, optional
        Direction of pulses in the pitch plane, by default the worse of head and tail wind;
        "frozen" for the nominal dynamic pressure.

    Raises
    ------
    InputError
        For a sizing of both planes, other winds than its own, and as `size` and `fly_along`.
    """
    if progress is not None:
        callable_for("progress", progress, "of how many are done and how many there are")
    instance("sizing", sizing, Sizing, "see size")
    plane = one_of("the plane of the sizing", sizing.plane, PLANES)
    by_name = named_winds(winds)
    if tuple(by_name) != sizing.winds:
        raise InputError(
            f"winds must be those of the sizing, {', '.join(sizing.winds)}; got"
            f" {', '.join(by_name)}"
        )
    if sign is not None:
        one_of("sign", sign, (*SIGNS, FROZEN))
    signs = tuple(SIGNS) if sign is None and plane == "pitch" else (sign,)
    width = number("window", window, positive, "s")
    max_rate = unlimited("rate_limit", rate_limit, unit="rad/s")
    flight, placed_as = sizing.schedule, placings(by_name, placing)
    limit = np.full((sizing.times.size, len(by_name)), np.nan)
    unknown_at: dict[tuple[str, str], list[float]] = {}
    pairs = [(i, j) for i in range(sizing.times.size) for j in range(len(by_name))]
    for done, (i, j) in enumerate(pairs, start=1):
        name, time = sizing.winds[j], float(sizing.times[i])
        try:
            placed = place(by_name[name], flight.at(time).rigid, time, placed_as[name], width)
            for wind in _encountered(sizing, placed, plane, signs):
                begin = max(float(wind.history.onset), flight.span[0])
                along = checked_flight(flight, autopilot, wind, begin, None, sizing.model, plane)
                scan = limit_of_flight(along, max_rate)
                unknown = np.isinf(scan.limit) and OPEN in scan.status
                limit[i, j] = np.fmax(limit[i, j], np.nan if unknown else scan.limit)
                if unknown:
                    raise NotKnownError(scan.status)
        except NotKnownError as error:
            limit[i, j] = np.nan
            unknown_at.setdefault((name, str(error)), []).append(time)
        if progress is not None:
            progress(done, len(pairs))
    reasons = (f"{wind} at {flight_times(at)}: {why}" for (wind, why), at in unknown_at.items())
    return AutopilotRequirements(sizing.times, sizing.winds, limit, tuple(reasons))


def _encountered(
    sizing: Sizing, placed: PlacedWind, plane: str, signs: tuple[str | None, ...]
) -> list[WindAlong]:
    """Return a placed wind as the flight encounters it, by its possible directions."""
    if not placed.known:
        raise NotKnownError(placed.why or "the wind is not known")
    if placed.calm:
        raise NotKnownError("the wind is calm")
    if placed.speeds is not None:
        history = placed.two_sided or placed.history
        speeds = None if signs == (FROZEN,) else placed.speeds
        return [sounding_along(history, speeds, plane, sizing.schedule.span)]
    try:
        return [wind_along(sizing.schedule, placed.in_flight, plane, sign) for sign in signs]
    except InputError as error:  # no horizontal wind has the angle on this path
        raise NotKnownError(str(error)) from None
