"""The smallest limit from which on an autopilot survives a wind along a flight that varies."""

from __future__ import annotations

from typing import Any

import numpy as np

from tvclin.ascent.measured_wind import MeasuredWind
from tvclin.ascent.schedule import FlightSchedule
from tvclin.ascent.wind_along import WindAlong, wind_along
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, number, positive, single
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.gain_schedule import GainSchedule
from tvclin.flights.closed_loop.checks import check_rate_limit
from tvclin.flights.closed_loop.flown_flights import FlownFlight, checked_flight, fly_together
from tvclin.flights.closed_loop.fly_many import MAX_DEFLECTION_LIMIT
from tvclin.flights.closed_loop.survival_limit import (
    LEVELS,
    STEPS,
    SurvivalLimit,
    Words,
    limit_above_losses,
)
from tvclin.kernels.choice import repeated
from tvclin.linear.plant import DEFAULT_MODEL
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import checked_linear

_LOWEST, _HIGHEST = 0.02, 2.0
"""Ends of the scanned limits, over the largest trim deflection of the flight."""


def survival_limit_along(
    flight: FlightSchedule,
    autopilot: Autopilot | GainSchedule,
    wind: History | MeasuredWind,
    *,
    rate_limit: float = np.inf,
    sign: str | None = None,
    gust_time: float | None = None,
    start: float | None = None,
    stop: float | None = None,
    model: str = DEFAULT_MODEL,
    plane: str = "pitch",
    highest: float = _HIGHEST,
) -> SurvivalLimit:
    """Return the smallest deflection limit [rad] above which an autopilot survives along a flight.

    Parameters
    ----------
    flight, autopilot, wind, rate_limit, sign, gust_time, start, stop, model, plane
        Same as in `fly_along`; the autopilot has a sample rate.
    highest : float
        Largest limit of the scan, over the largest trim deflection ``|B(t) alpha_w(t)|`` of the
        flight.

    Returns
    -------
    SurvivalLimit
        Limit and scan [rad], refined as in `closed_loop_boundary`: 61 limits from 0.02 of the
        largest trim deflection on.

    Raises
    ------
    InputError
        Same as `fly_along`, for a calm, a wind angle above 30 deg, and a `highest` of 0.02 or less.

    Examples
    --------
    >>> from dataclasses import replace
    >>> import numpy as np, tvclin as tv
    >>> flight = tv.load_schedule("configuration-i")
    >>> plants = flight.plants(66.0, "drift-exact", "pitch")
    >>> gains = tv.design_gains(plants.coefficients, natural_frequency=1.1, damping=0.7)
    >>> law = replace(gains, actuator=tv.Actuator(), sample_rate=25.0)
    >>> gust = tv.TriangularWind(peak=np.radians(4), duration=7.5).shift(62.0)
    >>> limit = tv.flights.survival_limit_along(flight, law, gust).limit
    >>> print(f"{np.degrees(limit):.2f}")
    0.41
    """
    if isinstance(wind, History):
        single("wind", wind.batch)
    encountered = wind_along(flight, wind, plane, sign, gust_time)
    along = checked_flight(flight, autopilot, encountered, start, stop, model, plane)
    return limit_of_flight(along, check_rate_limit(rate_limit), highest)


def limit_of_flight(
    along: FlownFlight, rate_limit: float, highest: float = _HIGHEST
) -> SurvivalLimit:
    """Return the smallest deflection limit [rad] above which a flight survives its wind.

    `along`: flight of an autopilot with a sample rate. `rate_limit`: limit of the deflection rate
    [rad/s]. `highest`: largest limit of the scan, over the largest trim deflection. The scan begins
    at 0.02 of that trim deflection. Same exceptions as `survival_limit_along`.
    """
    top = number("highest", highest, positive)
    if not _LOWEST < top:
        raise InputError(f"highest must be above {_LOWEST:g}; got {top:.6g}")
    scale = _largest_trim(along)

    def survives(limits: FloatArray) -> Words:
        """Return the status of the flight `along` with each of m limits [rad], ``(m,)``."""
        which = np.zeros(limits.size, np.int64)
        return fly_together([along], which, limits, np.full(limits.size, rate_limit)).status

    low, high = (min(end * scale, MAX_DEFLECTION_LIMIT) for end in (_LOWEST, top))
    with repeated(1 + LEVELS):  # similar runs, which decide between compiled and plain code
        return limit_above_losses(survives, np.linspace(low, high, STEPS + 1))


def _largest_trim(along: FlownFlight) -> float:
    """Return the largest trim deflection ``|B(t) alpha_w(t)|`` [rad] of a flight in its wind.

    It is at the dynamic pressure encountered; B is the trim deflection per angle of attack. After
    the end of the schedule the vehicle is as at its end. `InputError` for a calm;
    `NotKnownError` for a wind beyond linear aerodynamics.
    """
    wind: WindAlong = along.wind
    _begin, schedule_end = along.flight.span
    times = np.maximum(wind.history.probe_times(), along.start)
    if not along.goes_on:
        times = np.minimum(times, along.stop)
    angles = np.abs(wind.history(times))
    checked_linear(float(angles.max()))
    within = np.minimum(times, schedule_end)
    coefficients: Any = along.flight.plants(within, along.model, along.plane).coefficients
    largest = float((np.abs(coefficients.B) * wind.pressure(times) * angles).max())
    if not largest > 0.0:
        raise InputError("the wind must blow during the flight; it is calm")
    return largest
