"""Sampled flights whose vehicles, gains and winds differ, flown together along a schedule."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tvclin.ascent.schedule import FlightSchedule, vehicles_at
from tvclin.ascent.wind_along import WindAlong
from tvclin.base import errors
from tvclin.base.arrays import AnyArray, FloatArray, IntArray
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.gain_schedule import GainSchedule, autopilot_along, gains_along
from tvclin.control.autopilot.sweep import plants_of
from tvclin.flights.closed_loop.checks import check_delays, check_sample_rates, check_samples
from tvclin.flights.closed_loop.fly_many import FlownCases, flown_cases, unstable_loops
from tvclin.flights.closed_loop.sampled import finish
from tvclin.flights.closed_loop.stages import Stages, stages_of
from tvclin.kernels.choice import repeated
from tvclin.kernels.flights import Flights
from tvclin.linear.flexible import AnyPlant
from tvclin.numerics.storage import Storage

_SIMILAR_RUNS = 4
"""Runs of the kernel for a flight with its continuations in still air."""
_MAX_STAGES = 60_000
"""Largest number of samples of flights whose stages are in memory at one time, some 200 MB."""


@dataclass(frozen=True, eq=False)
class FlownFlight:
    """Checked arguments of a flight: the loop at any times, its span [s] and its law.

    `scheduled`: flight by which gains and notches are scheduled, if another than that of the plant.
    """

    flight: FlightSchedule
    autopilot: Autopilot | GainSchedule
    wind: WindAlong
    model: str
    plane: str
    start: float
    stop: float
    scheduled: FlightSchedule | None = None

    def loops(self, times: FloatArray) -> tuple[AnyPlant, Autopilot]:
        """Return plants and autopilots at times [s]."""
        together, which = FlownFlights([self]), np.zeros(times.size, np.int64)
        return together.plants_at(times, which), together.laws_at(times, which)

    @property
    def breaks(self) -> FloatArray:
        """Times [s] within the flight between which plants and autopilots are smooth.

        Those of a schedule on another variable than time are not known, and not among them.
        """
        times = [self.flight.times, self.wind.breaks]
        for flight in (self.flight, self.scheduled):
            if flight is not None and flight.structure is not None:
                times.append(flight.structure.times)
        schedule = self.autopilot
        if isinstance(schedule, GainSchedule) and schedule.variable == "time":
            times.append(schedule.breakpoints)
        inner = np.unique(np.concatenate(times))
        return inner[(inner > self.start) & (inner < self.stop)]

    @property
    def gain_flight(self) -> FlightSchedule:
        """Flight by which gains and notches are scheduled."""
        return self.scheduled or self.flight

    @property
    def law(self) -> Autopilot:
        """Autopilot at the breakpoints of a schedule, or the autopilot of all times."""
        made = self.autopilot
        return made.autopilot if isinstance(made, GainSchedule) else made


@dataclass(frozen=True, eq=False)
class FlownFlights:
    """Flights with one model, structure and autopilot, whose numbers, gains and winds differ."""

    flights: Sequence[FlownFlight]

    def plants_at(self, times: FloatArray, which: IntArray) -> AnyPlant:
        """Return the plants at times [s] of the flights with the indices `which`, each ``(n,)``."""
        first, pressure = self.flights[0], np.empty(times.shape)
        for flight, inside in self._by_flight(which):
            pressure[inside] = flight.wind.pressure(times[inside])
        schedules = [flight.flight for flight in self.flights]
        vehicles = vehicles_at(schedules, times, which, pressure)
        return plants_of(vehicles, first.model, first.plane)

    def laws_at(self, times: FloatArray, which: IntArray) -> Autopilot:
        """Return the autopilots at times [s] of the flights with the indices `which`."""
        first = self.flights[0]
        laws = autopilot_along(first.autopilot, first.gain_flight, times)
        if all(flight.autopilot is first.autopilot for flight in self.flights):
            return laws
        gains: dict[str, Any] = {}
        for flight, inside in self._by_flight(which):
            of_flight = gains_along(flight.autopilot, flight.gain_flight, times[inside])
            for name, values in of_flight.items():
                gains.setdefault(name, np.empty(times.shape))[inside] = values
        return replace(laws, **gains)

    def _by_flight(self, which: IntArray) -> Iterator[tuple[FlownFlight, AnyArray]]:
        """Yield each flight among the indices `which`, with its positions there."""
        for index in np.unique(which).tolist():
            yield self.flights[index], np.flatnonzero(which == index)


def checked_flight(
    flight: FlightSchedule,
    autopilot: Autopilot | GainSchedule,
    wind: WindAlong,
    start: float | None,
    stop: float | None,
    model: str,
    plane: str,
) -> FlownFlight:
    """Return the checked arguments of a flight."""
    along = FlownFlight(flight, autopilot, wind, model, plane, *wind.span(flight, start, stop))
    if not isinstance(autopilot, GainSchedule):
        errors.instance("autopilot", autopilot, Autopilot, "or a GainSchedule")
        if autopilot.batch:
            raise errors.InputError(
                "autopilot must be one autopilot for all times, or a GainSchedule"
            )
    if np.unique(along.law.delay).size > 1 or np.ndim(along.law.sample_rate or 0.0):
        raise errors.InputError("delay and sample_rate must be the same along the flight")
    return along


def sampled_stages(flights: Sequence[FlownFlight], storage: Storage | None = None) -> Stages:
    """Return the stages of sampled flights with one model, structure and autopilot but for gains.

    `storage`: memory of the large arrays, by default new. `InputError` for an autopilot without a
    sample rate, and as `fly_many`.
    """
    first, together = flights[0], FlownFlights(flights)
    law = first.law
    if law.sample_rate is None:
        raise errors.InputError("many flights need samples: give the autopilot a sample_rate")
    actuator = autopilot_along(first.autopilot, first.gain_flight, np.array([first.start])).actuator
    rate = float(np.asarray(law.sample_rate))
    check_sample_rates(rate, actuator)
    check_delays(np.unique(law.delay)[0], np.array(1.0 / rate))
    for flight in flights:
        check_samples(flight.stop - flight.start, 1.0 / rate)
    winds = [flight.wind.history for flight in flights]
    return stages_of(
        together.plants_at,
        together.laws_at,
        [flight.breaks for flight in flights],
        [(flight.start, flight.stop) for flight in flights],
        rate,
        [wind if wind.batch else wind.cases(np.zeros(1, np.int64), ()) for wind in winds],
        storage or Storage(),
    )


def flown_in_winds(
    stages: Stages,
    which: IntArray,
    limit: FloatArray,
    rate_limit: FloatArray,
    *,
    track: bool = False,
) -> tuple[FlownCases, Flights]:
    """Return the outcomes of sampled flights ``(m,)``, and their arrays at their ends.

    `which`: indices of their winds. `limit`, `rate_limit`: of the deflection [rad, rad/s].
    """
    batch = stages.batch(which, limit, rate_limit)
    f = stages.flights(batch, track=track)
    with repeated(_SIMILAR_RUNS):
        finish(f, batch.laws)
        rings = unstable_loops(batch, f)
    return flown_cases(f, np.ones(limit.size, bool), rings), f


def fly_together(
    flights: Sequence[FlownFlight], which: IntArray, limit: FloatArray, rate_limit: FloatArray
) -> FlownCases:
    """Return the outcomes of sampled flights in their winds, ``(m,)``.

    `flights`: as in `sampled_stages`; `which`: indices of their winds, counted from the first wind
    of the first flight to the last of the last. `limit`, `rate_limit`: of the deflection [rad,
    rad/s].
    """
    winds = np.cumsum([0, *(int(np.prod(flight.wind.history.batch)) for flight in flights)])
    parts: list[tuple[IntArray, FlownCases]] = []
    storage = Storage()
    for part in _parts(flights):
        first, last = winds[part.start], winds[part.stop]
        cases = np.flatnonzero((which >= first) & (which < last))
        stages = sampled_stages(flights[part], storage)
        made, _ = flown_in_winds(stages, which[cases] - first, limit[cases], rate_limit[cases])
        parts.append((cases, made))
    order = np.argsort(np.concatenate([cases for cases, _ in parts]))
    return FlownCases(
        **{
            name: np.concatenate([getattr(made, name) for _, made in parts])[order]
            for name in FlownCases.__dataclass_fields__
        }
    )


def _parts(flights: Sequence[FlownFlight]) -> Iterator[slice]:
    """Yield slices of flights whose stages are in memory at one time."""
    samples = [
        (flight.stop - flight.start) * float(np.asarray(flight.law.sample_rate or 1.0))
        for flight in flights
    ]
    first, total = 0, 0.0
    for k, count in enumerate(samples):
        if k > first and total + count > _MAX_STAGES:
            yield slice(first, k)
            first, total = k, 0.0
        total += count
    yield slice(first, len(flights))
