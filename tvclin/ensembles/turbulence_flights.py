"""Flights with limits in sampled turbulence, and what the linear loop says of the same.

The covariance of a loop in turbulence is exact while its nozzle stays within its limits. In
Gaussian motion a nozzle beyond its limit for a fraction p of the time has p less gain (the
random-input describing function of a saturation), so that the linear answer is one where p is
small. Flights by samples, whose winds have exactly the covariance of the turbulence, are right for
any p.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import partial
from typing import Any

import numpy as np

from tvclin.ascent.schedule import FlightSchedule, flight_variable
from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.fields import derived, spec
from tvclin.base.lines import Row, Table, degrees, quantities, significant
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.gain_schedule import GainSchedule
from tvclin.control.laws.autopilot_law import SaturatedLaw
from tvclin.control.turbulence.covariance_history import (
    CovarianceHistory,
    turbulence_along,
    turbulence_history,
)
from tvclin.control.turbulence.driven_loop import DEFLECTION_RATE
from tvclin.ensembles.statistics import Success, success_probability
from tvclin.flights.closed_loop.fly_along import fly_many_along
from tvclin.flights.closed_loop.fly_many import FlownCases, fly_many
from tvclin.linear.flexible import AnyPlant
from tvclin.winds.histories import History
from tvclin.winds.turbulence import Turbulence

MAX_LINEAR_EXCEEDANCE = 0.01
"""Fraction of time beyond the limit, so of lost gain, up to which a loop counts as linear."""
_STEP_OVER_TIME_SCALE, _MIN_STEP_S, _MAX_STEP_S = 0.01, 0.002, 0.05
"""Step of the sampled wind over L/V, and its bounds [s]."""
_RUNS_AT_ONCE, _MAX_RUNS = 200, 100_000
"""Flights in memory at one time, and of one call."""
_AT_LIMIT = 1.0 - 1e-9
"""Deflection over its limit from which the limit counts as reached."""


@dataclass(frozen=True, eq=False)
class TurbulenceFlights(Shown):
    """Sampled flights of an autopilot with limits in turbulence, beside its linear loop.

    Make it with `fly_turbulence` or `fly_turbulence_along`.

    Attributes
    ----------
    deflection_limit : float
        Deflection limit [rad].
    linear_time, largest_exceedance : float
        Expected fraction of time in which the linear loop without limits has its deflection beyond
        the limit, and the probability of that at the worst time.
    linear_probability_of_none : float or None
        Probability that it does not reach the limit; None for a deflection that jumps.
    limited_time, limited_time_error : float
        Mean fraction of a flight in which the demand is at or above the limit, and the standard
        error of this mean; NaN where a flight leaves all numbers.
    unlimited, survived : Success
        Probability that a flight does not meet its limit at a sample, and that it survives.
    flown : FlownCases
        Outcomes of the flights, ``(runs,)``.
    linear : CovarianceHistory
        Mean and covariance of the linear loop.
    """

    deflection_limit: float = field(metadata=spec("angle"))
    linear_time: float = field(metadata=spec())
    largest_exceedance: float = field(metadata=spec())
    linear_probability_of_none: float | None = field(metadata=spec())
    limited_time: float = field(metadata=spec())
    limited_time_error: float = field(metadata=spec())
    unlimited: Success
    survived: Success
    flown: FlownCases
    linear: CovarianceHistory

    @property
    @derived()
    def is_linear(self) -> bool:
        """Whether rms, travel and crossings of the linear loop hold for flights with the limit.

        They do if the linear loop is beyond the limit for at most a percent of the time, which
        lowers the gain by about as much (`MAX_LINEAR_EXCEEDANCE`). Survival follows from the
        flights alone: a rare excursion may lose an unstable vehicle.
        """
        return self.largest_exceedance <= MAX_LINEAR_EXCEEDANCE

    def tables(self) -> list[Table]:
        """Return the table of flights and linear loop."""
        key = "turbulence_flights"
        limit = degrees(f"{key}.deflection_limit", self.deflection_limit, unit="deg")
        beyond = significant(f"{key}.linear_time", 100.0 * self.linear_time, 3)
        worst = significant(f"{key}.largest_exceedance", 100.0 * self.largest_exceedance, 3, "%")
        validity = "holds" if self.is_linear else f"is none above {100 * MAX_LINEAR_EXCEEDANCE:g} %"
        time = significant(f"{key}.limited_time", 100.0 * self.limited_time, 3)
        error = significant(f"{key}.limited_time_error", 100.0 * self.limited_time_error, 2, "%")
        rows: list[Row] = [
            ("deflection limit", limit),
            (
                "linear loop beyond the limit",
                (*beyond, " % of the time, at worst ", *worst, f"; its answer {validity}"),
            ),
            ("flights at the limit", (*time, " +- ", *error, " of the time")),
        ]
        if self.linear_probability_of_none is not None:
            none = significant(
                f"{key}.linear_probability_of_none", 100.0 * self.linear_probability_of_none, 4, "%"
            )
            rows.append(("linear, limit not reached", none))
        rows += [
            ("flights, limit not reached", self.unlimited.line(f"{key}.unlimited")),
            ("flights, survived", self.survived.line(f"{key}.survived")),
        ]
        return [quantities("Flights with limits in sampled turbulence", rows)]


def fly_turbulence(
    autopilot: Autopilot,
    plant: AnyPlant,
    turbulence: Turbulence,
    speed: float,
    duration: float,
    *,
    deflection_limit: float,
    rate_limit: float = np.inf,
    altitude: float | None = None,
    wind: History | None = None,
    runs: int = 400,
    seed: int = 0,
) -> TurbulenceFlights:
    """Return sampled flights with limits in turbulence of one vehicle, from rest.

    Parameters
    ----------
    autopilot : Autopilot
        One autopilot with a sample rate.
    plant : Plant or FlexiblePlant
        One plant.
    turbulence : Turbulence
        The random wind; its angle is w/V.
    speed : float
        Airspeed V [m/s].
    duration : float
        Time in turbulence [s], after which the air is still until the flight is decided.
    deflection_limit, rate_limit : float
        Deflection limit [rad] and rate limit [rad/s].
    altitude : float, optional
        Altitude [m], for turbulence that is a table.
    wind : History, optional
        The known wind [rad], which ends within the duration; by default none.
    runs, seed : int
        Number of flights, and seed of their winds: flight k of a seed has the same wind whichever
        others are flown.

    Raises
    ------
    InputError
        For an autopilot without a sample rate, and as `turbulence_history` and `fly_many`.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> plant = tv.Plant.from_vehicle(vehicle, "drift-exact")
    >>> autopilot = tv.Autopilot(
    ...     attitude_gain=0.2144578, rate_gain=0.486223, sample_rate=25.0,
    ...     actuator=tv.Actuator(natural_frequency=25.0, damping=0.7))
    >>> air = tv.winds.Turbulence(intensity=6.0)
    >>> flights = tv.ensembles.fly_turbulence(
    ...     autopilot, plant, air, vehicle.velocity, 20.0,
    ...     deflection_limit=np.radians(0.1), runs=50)
    >>> flights.is_linear, round(flights.linear_time, 3)
    (False, 0.115)
    """
    errors.instance("autopilot", autopilot, Autopilot, "see design_gains")
    _check_sampled(autopilot)
    limit = errors.limit_angle(deflection_limit)
    linear = turbulence_history(
        autopilot, plant, turbulence, speed, duration, wind=wind, altitude=altitude
    )
    V = errors.number("speed", speed)
    _intensity, length = turbulence.over(altitude)  # the scale length [m] decides the steps
    times = _times(0.0, float(duration), time_scale=float(np.min(length)) / V)
    fly = partial(
        fly_many,
        plant,
        SaturatedLaw.of(autopilot),
        deflection_limit=limit,
        rate_limit=rate_limit,
        actuator=autopilot.actuator,
        sample_rate=float(np.asarray(autopilot.sample_rate)),
        delay=autopilot.delay,
    )
    gusts = partial(turbulence.winds, times, V, altitude=altitude, seed=seed)
    return _comparison(limit, linear, fly, gusts, wind, runs)


def fly_turbulence_along(
    schedule: FlightSchedule,
    autopilot: Autopilot | GainSchedule,
    turbulence: Turbulence,
    *,
    deflection_limit: float,
    rate_limit: float = np.inf,
    model: str = "drift-exact",
    plane: str = "pitch",
    start: float | None = None,
    stop: float | None = None,
    wind: History | None = None,
    runs: int = 400,
    seed: int = 0,
) -> TurbulenceFlights:
    """Return sampled flights with limits in turbulence along a flight, from rest.

    They are at the nominal dynamic pressure, as the linear loop without limits is.

    Parameters
    ----------
    schedule : FlightSchedule
        The vehicle at its flight times, with its structure and actuator where it has them.
    autopilot : Autopilot or GainSchedule
        One autopilot, or its gains over the flight, with a sample rate.
    turbulence : Turbulence
        The random wind.
    deflection_limit, rate_limit : float
        Deflection limit [rad] and rate limit [rad/s].
    model, plane : str
        Model of the plant, and plane of the motion, pitch or yaw.
    start, stop : float, optional
        First and last time [s] of the flights in turbulence; by default the schedule's.
    wind : History, optional
        The known wind [rad] over the time of flight; by default none.
    runs, seed : int
        Number of flights, and seed of their winds; see `fly_turbulence`.

    Raises
    ------
    InputError
        For an autopilot without a sample rate, and as `turbulence_along` and `fly_many_along`.
    """
    errors.instance("schedule", schedule, FlightSchedule, "see load_schedule")
    sampled = autopilot.autopilot if isinstance(autopilot, GainSchedule) else autopilot
    errors.instance("autopilot", sampled, Autopilot, "or a GainSchedule")
    _check_sampled(sampled)
    limit = errors.limit_angle(deflection_limit)
    options: dict[str, Any] = {"model": model, "plane": plane, "start": start, "stop": stop}
    linear = turbulence_along(schedule, autopilot, turbulence, wind=wind, **options)
    first_time, last_time = schedule.between(start, stop).span
    _intensity, lengths = turbulence.over(None if schedule.altitude is None else schedule.height)
    times = _times(first_time, last_time, time_scale=float(np.min(lengths / schedule.speed)))
    speeds = flight_variable(schedule, "speed", times)
    heights = None if schedule.altitude is None else flight_variable(schedule, "altitude", times)
    gusts = partial(turbulence.winds, times, speeds, altitude=heights, seed=seed)
    options |= {"deflection_limit": limit, "rate_limit": rate_limit, "sign": "frozen"}
    fly = partial(fly_many_along, schedule, autopilot, **options)
    return _comparison(limit, linear, fly, gusts, wind, runs)


def _check_sampled(autopilot: Autopilot) -> None:
    """Raise `InputError` for an autopilot without a sample rate."""
    if autopilot.sample_rate is None:
        raise errors.InputError(
            "flights with limits need samples: give the autopilot a sample_rate"
        )


def _times(start: float, stop: float, time_scale: float) -> FloatArray:
    """Return the even times [s] of a sampled wind from `start` to `stop` [s], ``(n,)``.

    `time_scale`: scale length over airspeed, L/V [s], of which a step is a small fraction.
    """
    step = float(np.clip(_STEP_OVER_TIME_SCALE * time_scale, _MIN_STEP_S, _MAX_STEP_S))
    return np.linspace(start, stop, int(np.ceil((stop - start) / step)) + 1)


def _comparison(
    limit: float,
    linear: CovarianceHistory,
    fly: Callable[[History], FlownCases],
    gusts: Callable[..., History],
    wind: History | None,
    runs: int,
) -> TurbulenceFlights:
    """Return flights in sampled turbulence, compared with the linear loop in it.

    `limit`: deflection limit [rad]. `linear`: mean and covariance of the linear loop. `fly`:
    function from winds [rad] to the outcomes of their flights. `gusts`: function that returns the
    turbulence [rad] of `runs` flights from the number `first` on. `wind`: known wind, which is
    added to each, or None. `runs`: number of all flights.
    """
    total = errors.whole_number("runs", runs)
    if not 2 <= total <= _MAX_RUNS:
        raise errors.InputError(f"runs must be 2 to {_MAX_RUNS}; got {errors.shown(runs)}")
    batches = []
    for first in range(0, total, _RUNS_AT_ONCE):  # as many as fit into memory
        sampled = gusts(first=first, runs=min(_RUNS_AT_ONCE, total - first))
        batches.append(fly(sampled if wind is None else sampled + wind))
    arrays = {
        item.name: np.concatenate([getattr(batch, item.name) for batch in batches])
        for item in fields(FlownCases)
    }
    flown = FlownCases(**arrays)
    limited = flown.saturated_time_fraction
    below = int(np.sum(flown.peak_deflection < _AT_LIMIT * limit))
    has_rate = DEFLECTION_RATE in linear.outputs  # a variance, so that crossings can be counted
    return TurbulenceFlights(
        deflection_limit=limit,
        linear_time=linear.time_fraction(limit),
        largest_exceedance=float(linear.exceedance(limit).max()),
        linear_probability_of_none=linear.probability_of_none(limit) if has_rate else None,
        limited_time=float(limited.mean()),
        limited_time_error=float(limited.std(ddof=1) / np.sqrt(total)),
        unlimited=success_probability(below, total),
        survived=success_probability(int(np.sum(flown.status == "survived")), total),
        flown=flown,
        linear=linear,
    )
