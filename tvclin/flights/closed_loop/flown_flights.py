"""Sampled flights whose vehicles, gains and winds differ, flown together along a schedule.

And the smallest limit from which on an autopilot survives a wind along such a flight.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.ascent.measured_wind import MeasuredWind
from tvclin.ascent.schedule import FlightSchedule, vehicles_at
from tvclin.ascent.wind_along import WindAlong, wind_along
from tvclin.base import errors
from tvclin.base.arrays import AnyArray, FloatArray, IntArray, Storage
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.gain_schedule import GainSchedule, autopilot_along, gains_along
from tvclin.flights.closed_loop.batch import samples_in
from tvclin.flights.closed_loop.checks import (
    check_delays,
    check_rate_limit,
    check_sample_rates,
    check_samples,
)
from tvclin.flights.closed_loop.fly_many import (
    MAX_DEFLECTION_LIMIT,
    UNDECIDED,
    FlownCases,
    flown_cases,
    unstable_loops,
)
from tvclin.flights.closed_loop.outcomes import decidable, outcome_criteria
from tvclin.flights.closed_loop.sampled import finish
from tvclin.flights.closed_loop.stages import Stages
from tvclin.flights.closed_loop.survival_limit import (
    LEVELS,
    STEPS,
    SurvivalLimit,
    Words,
    limit_above_losses,
)
from tvclin.kernels.choice import repeated
from tvclin.kernels.flight_arrays import Flights
from tvclin.linear.flexible import AnyPlant, plant_of
from tvclin.linear.plant import DEFAULT_MODEL
from tvclin.numerics.chebyshev import Surface
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import checked_linear

SIMILAR_RUNS = 4
"""Runs of the kernel for a flight with its continuations in still air."""
_SETTLINGS = 6.0
"""Time that a flight goes on after its wind, over the settling time at the end of the schedule."""
_MAX_FURTHER_SAMPLES = 20_000
"""Largest number of samples after the end of the schedule."""
_MAX_STAGES = 60_000
"""Largest number of samples of flights whose stages are in memory at one time, some 200 MB."""


@dataclass(frozen=True, eq=False)
class FlownFlight:
    """Checked arguments of a flight: the loop at any times, its span [s] and its law.

    After the end of the schedule vehicle and autopilot are frozen as they are then. `scheduled`:
    flight by which gains and notches are scheduled, if another than that of the plant. `goes_on`:
    whether a flight that is not decided at the end of the schedule goes on.
    """

    flight: FlightSchedule
    autopilot: Autopilot | GainSchedule
    wind: WindAlong
    model: str
    plane: str
    start: float
    stop: float
    scheduled: FlightSchedule | None = None
    goes_on: bool = False

    def loops(self, times: FloatArray) -> tuple[AnyPlant, Autopilot]:
        """Return the plants and the autopilots of the flight at times [s], batches ``(n,)``.

        Plants are at the dynamic pressure encountered in the wind.
        """
        # this flight alone, whose index is 0 at all times
        together, which = FlownFlights([self]), np.zeros(times.size, np.int64)
        pressure = together.pressure_at(times, which)
        return together.plants_at(times, which, pressure), together.laws_at(times, which)

    @property
    def breaks(self) -> FloatArray:
        """Times [s], the ends included, between which plants and autopilots are smooth."""
        return self._times_between([self.vehicle_breaks, self.wind.breaks])

    @property
    def vehicle_breaks(self) -> FloatArray:
        """Times [s], the ends included, between which vehicle and autopilot are smooth.

        They are the times of the schedule, of the structure, also in the flight that schedules the
        gains, and of the gains, if scheduled on time: on another variable theirs are not known.
        """
        times = [self.flight.times]
        for flight in (self.flight, self.scheduled):
            if flight is not None and flight.structure is not None:
                times.append(flight.structure.times)
        schedule = self.autopilot
        if isinstance(schedule, GainSchedule) and schedule.variable == "time":
            times.append(schedule.breakpoints)
        return self._times_between(times)

    def _times_between(self, times: Sequence[FloatArray]) -> FloatArray:
        """Return the ends of the flight and several arrays of times [s] between them, rising."""
        ends = self.start, self.stop
        return np.unique(np.clip(np.concatenate([*times, ends]), *ends))

    @property
    def gain_flight(self) -> FlightSchedule:
        """Flight by which gains and notches are scheduled."""
        return self.scheduled or self.flight

    @property
    def law(self) -> Autopilot:
        """Autopilot at the breakpoints of a schedule, or the autopilot of all times."""
        autopilot = self.autopilot
        return autopilot.autopilot if isinstance(autopilot, GainSchedule) else autopilot

    @cached_property
    def stages(self) -> Stages:
        """Matrices of the loop at all samples of this flight alone."""
        return sampled_stages([self])

    @cached_property
    def further(self) -> FlownFlight | None:
        """The same flight with a later end, at which it can be settled; None if it cannot go on.

        It cannot with a given end (`goes_on` is False), in a wind that lasts as long as it is
        known, and with a vehicle whose flights have no outcome (`decidable`). The end is six
        settling times after the wind, and limited by a number of samples.
        """
        end = float(np.max(self.wind.history.end))  # [s]
        # `known`: first and last time [s] at which the wind is known
        if not self.goes_on or not end < self.wind.known[1]:
            return None
        last, _ = self.loops(np.array([self.flight.span[1]]))  # plants at the schedule's end
        latest = self.stop + _MAX_FURTHER_SAMPLES / float(np.asarray(self.law.sample_rate))
        stop = min(end + _SETTLINGS * float(outcome_criteria(last).settling[0]), latest)
        settles = decidable(last)[0] and stop > self.stop  # `last` is a batch of one
        return replace(self, stop=stop, goes_on=False) if settles else None


@dataclass(frozen=True, eq=False)
class FlownFlights:
    """Flights with one model, structure and autopilot, whose numbers, gains and winds differ."""

    flights: Sequence[FlownFlight]

    def plants_at(self, times: FloatArray, which: IntArray, pressure: FloatArray) -> AnyPlant:
        """Return the plants at times [s] of the flights with the indices `which`, each ``(n,)``.

        `pressure`: dynamic pressure q/q_n, ``(n,)``.
        """
        # model and plane are those of all flights
        first, schedules = self.flights[0], [flight.flight for flight in self.flights]
        vehicles = vehicles_at(schedules, self._within(times), which, pressure)
        return plant_of(vehicles, first.model, first.plane)

    def pressure_at(self, times: FloatArray, which: IntArray) -> FloatArray:
        """Return the dynamic pressure q/q_n encountered at n times [s] of flights, ``(n,)``.

        `which`: indices of the flights, ``(n,)``.
        """
        pressure = np.empty(times.shape)
        for flight, inside in self._by_flight(which):
            pressure[inside] = flight.wind.pressure(times[inside])
        return pressure

    def laws_at(self, times: FloatArray, which: IntArray) -> Autopilot:
        """Return the autopilots at times [s] of the flights with indices `which`, each ``(n,)``.

        Only their gains differ between flights; filters and hardware are the first's.
        """
        first, times = self.flights[0], self._within(times)
        laws = autopilot_along(first.autopilot, first.gain_flight, times)
        if all(flight.autopilot is first.autopilot for flight in self.flights):
            return laws
        gains: dict[str, Any] = {}
        for flight, inside in self._by_flight(which):
            of_flight = gains_along(flight.autopilot, flight.gain_flight, times[inside])
            for name, values in of_flight.items():
                gains.setdefault(name, np.empty(times.shape))[inside] = values
        return replace(laws, **gains)

    def _within(self, times: FloatArray) -> FloatArray:
        """Return times [s], those after the end of the schedule as its end."""
        return np.minimum(times, self.flights[0].flight.span[1])

    def _by_flight(self, which: IntArray) -> Iterator[tuple[FlownFlight, AnyArray]]:
        """Yield each flight among the indices `which`, and the positions of its index in them."""
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
    """Return the checked arguments of a flight of an autopilot in a wind.

    `flight`: vehicle at its flight times. `start`, `stop`: ends of the flight [s], by default those
    of flight and wind; without a stop an undecided flight goes on (`goes_on`). `model`, `plane`:
    model and plane of the motion. `InputError` for a batch of autopilots, and a delay or sample
    rate that varies.
    """
    first, last = wind.span(flight, start, stop)
    along = FlownFlight(
        flight, autopilot, wind, model, plane, start=first, stop=last, goes_on=stop is None
    )
    if not isinstance(autopilot, GainSchedule):
        errors.instance("autopilot", autopilot, Autopilot, "or a GainSchedule")
        if autopilot.batch:
            raise errors.InputError(
                "autopilot must be one autopilot for all times, or a GainSchedule"
            )
    if np.unique(along.law.delay).size > 1 or np.ndim(along.law.sample_rate or 0.0):
        raise errors.InputError("delay and sample_rate must be the same along the flight")
    return along


def sampled_stages(
    flights: Sequence[FlownFlight],
    storage: Storage | None = None,
    surfaces: dict[Any, Surface | None] | None = None,
) -> Stages:
    """Return the loops of several flights at all samples, from which `Stages` makes matrices.

    `flights`: flights with the same model and structure, and the same autopilot but for its gains.
    `storage`: memory to use again for the large arrays. `surfaces`: interpolants of the matrices of
    earlier flights in time and pressure, as in `Stages`; new ones are added. `InputError` for an
    autopilot without a sample rate, and as `fly_many`.
    """
    first, together = flights[0], FlownFlights(flights)
    law = first.law
    if law.sample_rate is None:
        raise errors.InputError("many flights need samples: give the autopilot a sample_rate")
    actuator = autopilot_along(first.autopilot, first.gain_flight, np.array([first.start])).actuator
    rate = float(np.asarray(law.sample_rate))
    check_sample_rates(rate, actuator)
    delay = np.unique(law.delay)[0]  # [s], the same at all times
    check_delays(delay, np.array(1.0 / rate))
    starts, stops = np.array([(flight.start, flight.stop) for flight in flights]).T
    for span in stops - starts:
        check_samples(float(span), 1.0 / rate)
    winds = [flight.wind.history for flight in flights]
    return Stages(
        flown_plants=together.plants_at,
        flown_laws=together.laws_at,
        pressure_at=together.pressure_at,
        starts=starts,
        stops=stops,
        samples=samples_in(stops - starts, np.array(1.0 / rate)),
        vehicle_breaks=[flight.vehicle_breaks for flight in flights],
        breaks=[flight.breaks for flight in flights],
        # flights of one schedule object have the same plants at the same time and pressure
        alike=[id(flight.flight) for flight in flights],
        period=1.0 / rate,
        # a single wind becomes a batch of one
        winds=[wind if wind.batch else wind.cases(np.zeros(1, np.int64), ()) for wind in winds],
        storage=storage or Storage(),
        surfaces={} if surfaces is None else surfaces,
    )


def flown_in_winds(
    stages: Stages,
    which: IntArray,
    limit: FloatArray,
    rate_limit: FloatArray,
    *,
    track: bool = False,
) -> tuple[FlownCases, Flights]:
    """Return the outcomes of m sampled flights, and the arrays of the kernel at their ends.

    `stages`: matrices of the loops at their samples, and winds. `which`: index of the wind of each
    flight, ``(m,)``. `limit`, `rate_limit`: limits of deflection [rad] and rate [rad/s], ``(m,)``.
    `track`: whether the samples of a single flight are recorded. A flight that survives, but with
    an unstable loop at its end, goes on in a limit cycle: its status is "rings".
    """
    batch = stages.batch(which, limit, rate_limit)
    f = stages.flights(batch, track=track)
    with repeated(SIMILAR_RUNS):  # similar runs, which decide between compiled and plain code
        finish(f, batch.laws)
        rings = unstable_loops(batch, f)
    possible = np.ones(limit.size, bool)  # every case is flown
    return flown_cases(f, possible, rings), f


def fly_together(
    flights: Sequence[FlownFlight], which: IntArray, limit: FloatArray, rate_limit: FloatArray
) -> FlownCases:
    """Return the outcomes of m sampled flights in their winds; undecided ones go on, if they can.

    `flights`: as in `sampled_stages`, each with a wind or a batch of winds. `which`: indices of the
    winds of the m flights, counted from the first wind of the first flight to the last of the last.
    `limit`, `rate_limit`: limits of deflection [rad] and rate [rad/s], ``(m,)``.
    """
    # index of the first wind of each flight among all
    winds = np.cumsum([0, *(int(np.prod(flight.wind.history.batch)) for flight in flights)])
    columns: dict[str, AnyArray] = {}  # outcomes of the m flights by field of `FlownCases`
    for part, stages in stages_in_parts(flights):
        first, last = winds[part.start], winds[part.stop]
        cases = np.flatnonzero((which >= first) & (which < last))
        outcomes, _ = flown_in_winds(stages, which[cases] - first, limit[cases], rate_limit[cases])
        for name, values in vars(outcomes).items():
            columns.setdefault(name, np.empty(which.size, values.dtype))[cases] = values
    # Undecided flights are flown anew to a later end: their flight's `further` one, if it has one.
    flight = np.searchsorted(winds, which, side="right") - 1  # index of the flight of each wind
    undecided = columns["status"] == UNDECIDED
    going_on = [k for k in np.unique(flight[undecided]).tolist() if flights[k].further is not None]
    cases = np.flatnonzero(undecided & np.isin(flight, going_on))
    if not cases.size:
        return FlownCases(**columns)
    further_flights = [further for k in going_on if (further := flights[k].further) is not None]
    # the same winds, counted from the first wind of the first of `further_flights`
    further_winds = np.cumsum([0, *np.diff(winds)[going_on[:-1]]])  # first wind of each of these
    in_flight = which[cases] - winds[flight[cases]]
    renumbered = further_winds[np.searchsorted(going_on, flight[cases])] + in_flight
    continued = fly_together(further_flights, renumbered, limit[cases], rate_limit[cases])
    for name, values in vars(continued).items():
        columns[name][cases] = values
    return FlownCases(**columns)


def stages_in_parts(flights: Sequence[FlownFlight]) -> Iterator[tuple[slice, Stages]]:
    """Yield slices of flights, and the matrices of their loops at all samples, of limited memory.

    The flights of a slice have at most `_MAX_STAGES` samples together, or are a single one. The
    matrices of a slice are overwritten by those of the next; a single flight keeps its own.
    """
    if len(flights) == 1:
        yield slice(0, 1), flights[0].stages
        return
    storage, surfaces = Storage(), dict[Any, Surface | None]()
    samples = [
        (flight.stop - flight.start) * float(np.asarray(flight.law.sample_rate or 1.0))
        for flight in flights
    ]
    first, total = 0, 0.0
    for k, count in enumerate([*samples, np.inf]):  # infinity ends the last slice
        if k > first and total + count > _MAX_STAGES:
            part = slice(first, k)
            yield part, sampled_stages(flights[part], storage, surfaces)
            first, total = k, 0.0
        total += count


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
        errors.single("wind", wind.batch)
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
    top = errors.number("highest", highest, errors.positive)
    if not _LOWEST < top:
        raise errors.InputError(f"highest must be above {_LOWEST:g}; got {top:.6g}")
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
    wind = along.wind
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
        raise errors.InputError("the wind must blow during the flight; it is calm")
    return largest
