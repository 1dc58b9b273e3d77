"""Sampled flights of a vehicle whose matrices vary: a stage of the kernel for each sample.

Each part of a sample has the constant matrices with the same step, to fourth order, as those that
vary (`constant_over_steps`): exact for whatever is stiff, and for a frozen vehicle the very
matrices of `fly_many`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise
from typing import Any

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IntArray, Storage
from tvclin.base.errors import InputError
from tvclin.control.autopilot.actuator import INPUTS, plant_blocks
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.wiring import attitude_integral
from tvclin.control.laws.autopilot_law import gain_numbers
from tvclin.control.laws.law import Chains
from tvclin.flights.closed_loop.batch import (
    Batch,
    Hardware,
    Timing,
    equilibrium,
    samples_in,
    sensed_rows,
    steps_of,
    widened,
    with_ramp,
)
from tvclin.flights.closed_loop.law_batch import LawBatch, Memory, law_rows, memory_of
from tvclin.flights.closed_loop.outcomes import outcome_criteria
from tvclin.kernels.control_laws import LawNumbers
from tvclin.kernels.flight_arrays import Cases, Flights, Laws, Steps, Vehicles, Winds
from tvclin.kernels.flights import JUDGED_SAMPLES
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.lateral import LateralSensors
from tvclin.linear.system import LinearSystem, connect, constant_over_steps, polynomial_input
from tvclin.numerics.chebyshev import Surface, smooth_values
from tvclin.numerics.pieces import polynomial_pieces
from tvclin.numerics.propagation import GAUSS_NODES
from tvclin.winds.histories import History

_SAMPLES_PER_BREAK = 30
"""Samples for each breakpoint of a wind below which stages are interpolated in its pressure."""
_MIN_SAMPLES_OF_SURFACE = 50
"""Smallest number of samples that are interpolated in their pressure."""
_PRESSURE_RANGE = 0.25
"""Width of the ranges of q/q_n in which stages are interpolated."""
_PRESSURE_CHANGE = 1e-3
"""Change of q/q_n within a part of a sample from which its effect is taken, which is linear."""
PlantsAt = Callable[[FloatArray, IntArray, FloatArray], AnyPlant]
LawsAt = Callable[[FloatArray, IntArray], Autopilot]
PressureAt = Callable[[FloatArray, IntArray], FloatArray]
"""Functions from times [s] and indices of flights ``(n,)`` to plants (at a dynamic pressure q/q_n
``(n,)``), to autopilots, and to the dynamic pressure encountered."""


@dataclass(frozen=True, eq=False)
class Stages:
    """Sampled loops over flights: plants and autopilots at their samples, and winds.

    `flown_plants`, `flown_laws`, `pressure_at`: plants, autopilots and dynamic pressure at any
    times. `starts`, `stops`, `samples`: start and end [s] and number of samples of each flight,
    ``(f,)``. `vehicle_breaks`, `breaks`: times [s] between which plants and actuator of each flight
    are smooth at constant pressure, and in its winds, rising, the ends included. `alike`: a number
    for each flight, the same for flights with the same plants at the same pressure and time.
    `period`: length of a sample [s]. `winds`: winds ``(w,)`` of each flight over the time of
    flight. `storage`: memory of the large arrays. `surfaces`: interpolants in time and pressure by
    number, interval and range, None where they do not converge.
    """

    flown_plants: PlantsAt
    flown_laws: LawsAt
    pressure_at: PressureAt
    starts: FloatArray
    stops: FloatArray
    samples: IntArray
    vehicle_breaks: Sequence[FloatArray]
    breaks: Sequence[FloatArray]
    alike: Sequence[int]
    period: float
    winds: Sequence[History]
    storage: Storage
    surfaces: dict[Any, Surface | None]

    def plants_at(self, times: FloatArray, flight: IntArray) -> AnyPlant:
        """Return the plants at times [s] of the flights with indices `flight`, each ``(n,)``.

        After the end of a flight they are those at its end. They are at the dynamic pressure
        encountered in its winds.
        """
        inside = np.minimum(times, self.stops[flight])
        return self.flown_plants(inside, flight, self.pressure_at(inside, flight))

    @cached_property
    def plants(self) -> AnyPlant:
        """Plants of all flights at times of three kinds, in one batch axis.

        These are first the `vehicle_breaks` of each flight in turn, then the ends of winds and of
        flights, then the middles of the samples next to a knot of the wind.
        """
        ends, knots = self._ends.ravel(), self._next_to_knots
        times = [*self.vehicle_breaks, self.times[ends], self.times[knots] + 0.5 * self.period]
        at_breaks = np.repeat(np.arange(self.starts.size), [t.size for t in self.vehicle_breaks])
        flight = np.concatenate([at_breaks, self.flight[ends], self.flight[knots]])
        return self.plants_at(np.concatenate(times), flight)

    @cached_property
    def times(self) -> FloatArray:
        """Times of the samples [s], the end of each flight included, ``(n,)``, flight by flight."""
        flight = self.flight  # index of the flight of each sample
        sample = np.arange(flight.size) - self.first_sample[flight]  # number within its flight
        return np.asarray(self.starts[flight] + self.period * sample)

    @cached_property
    def flight(self) -> IntArray:
        """Index of the flight of each sample, ``(n,)``; the end of a flight counts as a sample."""
        return np.repeat(np.arange(self.samples.size), self.samples + 1)

    @cached_property
    def first_sample(self) -> IntArray:
        """Index of the first sample of each flight, ``(f,)``."""
        return np.cumsum(np.append(0, self.samples[:-1] + 1))

    @cached_property
    def flight_of_wind(self) -> IntArray:
        """Index of the flight of each wind, ``(w,)``."""
        counts = [int(np.prod(wind.batch)) for wind in self.winds]
        return np.repeat(np.arange(len(counts)), counts)

    @cached_property
    def laws(self) -> Autopilot:
        """Autopilots at the n samples of all flights, a batch ``(n,)``, or one for all."""
        return self.flown_laws(np.minimum(self.times, self.stops[self.flight]), self.flight)

    @cached_property
    def hardware(self) -> Hardware:
        """Sample period, delay, and the actuator of the laws."""
        delay = np.unique(self.laws.delay)[0]  # [s], the same at all samples
        return Hardware(self.period, float(delay), self.laws.actuator)

    @property
    def sensors(self) -> LateralSensors:
        """Sensors of drift and acceleration of the laws."""
        return self.laws.lateral_sensors

    def batch(self, which: IntArray, limit: FloatArray, rate_limit: FloatArray) -> Batch:
        """Return a batch of m flights with limits, from equilibrium.

        Numbers of laws and matrices of vehicles have a row for each sample, flight by flight; a
        flight of the batch has the index of the row of its first sample, from which the kernel
        steps to the next. `which`: index of the wind of each flight, ``(m,)``, which also selects
        its vehicle. `limit`, `rate_limit`: limits of deflection [rad] and its rate [rad/s],
        ``(m,)``.
        """
        chains = Chains(self.laws.attitude_filters, self.laws.rate_filters, self.laws.filters)
        first_row = self.first_sample[self.flight_of_wind[which]]
        numbers: Any = self._law_rows.view(np.recarray)
        laws = LawBatch(  # no `laws`: the kernel takes their numbers
            laws=(), numbers=numbers, chains=[chains], which=first_row, sensors=self.sensors
        )
        return Batch(
            self.plants,
            replace(self.hardware, rate_limit=rate_limit),
            self.winds[0],  # `flights` takes all winds
            laws,
            limit=limit,
            shape=limit.shape,
            until=float(self.times.max()),
            vehicle=first_row,
            encountered=which,  # indices of winds
        )

    def flights(self, batch: Batch, *, track: bool = False) -> Flights:
        """Return the arrays of the kernel for flights at their start, in equilibrium.

        `batch`: result of `Stages.batch`. `track`: whether the samples of a single flight are
        recorded. The kernel steps from sample to sample with the matrices of each.
        """
        steps, (knots, pieces) = self.steps, self._pieces  # breakpoints and polynomials of winds
        order = steps.joint.shape[2]  # number of states of vehicle and nozzle
        memory, cases = self._memory, self._cases(batch)
        now = equilibrium(
            m=cases.limit.size,
            n=self.vehicles.A.shape[1],
            steps=steps,
            terms=pieces.shape[2],
            memory=memory.states.shape[1],
        )
        # index of the last breakpoint of the wind that is not after the start
        now.piece[:] = (knots[cases.wind] <= cases.start[:, np.newaxis]).sum(axis=1) - 1
        # rows of the track: one for each substep of the samples of a single flight
        samples = int(self.samples[self.flight_of_wind[cases.wind[0]]])
        rows = int(steps.substeps[0].sum()) * samples if track else 0
        no_noise = np.zeros((1, 0))
        return Flights(
            steps=steps,
            vehicles=self.vehicles,
            winds=Winds(knots, pieces),
            laws=Laws(self._law_rows, *memory, no_noise),
            cases=cases,
            now=now,
            track=np.full((rows, order + 4), np.nan),  # states, command, deflection, limited, begin
        )

    @cached_property
    def _law_rows(self) -> AnyArray:
        """Numbers of the law of each sample, with the fields of `LawNumbers`."""
        rows = np.repeat(law_rows([LawNumbers()]), self.times.size)
        for name, gain in gain_numbers(self.laws).items():
            rows[name] = gain
        return rows

    @cached_property
    def _pieces(self) -> tuple[FloatArray, FloatArray]:
        """Breakpoints [s] ``(w, k)`` and polynomials ``(w, k, terms)`` of all w winds.

        Winds with fewer than k breakpoints have infinite ones at the end.
        """
        # breakpoints and polynomials of the winds of each flight
        by_flight = [polynomial_pieces(wind.pieces) for wind in self.winds]
        count, terms = (max(pieces.shape[axis] for _, pieces in by_flight) for axis in (1, 2))
        all_knots = np.full((self.flight_of_wind.size, count), np.inf)
        all_pieces, row = np.zeros((*all_knots.shape, terms)), 0
        for knots, pieces in by_flight:
            rows = slice(row, row + len(knots))
            all_knots[rows, : knots.shape[1]] = knots
            all_pieces[rows, : pieces.shape[1], : pieces.shape[2]] = pieces
            row += len(knots)
        return all_knots, all_pieces

    @cached_property
    def _timing(self) -> Timing:
        """Lengths [s] of all samples and of their parts, with equally many substeps in each sample.

        So each sample has equally many recorded rows. The parts of a sample are before and after
        the arrival of a delayed command.
        """
        count = self.times.size
        period, delay = (np.full(count, float(x)) for x in (self.period, self.hardware.delay))
        timing = Timing.of(self.hardware, (count,), period, delay)
        return timing._replace(
            substeps=np.broadcast_to(timing.substeps.max(axis=0), timing.substeps.shape).copy()
        )

    @cached_property
    def steps(self) -> Steps:
        """Transition matrices over each of the n samples of all flights, and over their substeps.

        `joint` is of whole parts of a sample, `fine` of substeps, the same unless a part has
        several, `ramp` of a deflection that is linear over a substep.
        """
        arrays = self._arrays
        fine = arrays.get("fine", arrays["joint"])
        return self._timing.steps(arrays["joint"], fine, arrays["ramp"])

    @cached_property
    def _arrays(self) -> dict[str, FloatArray]:
        """Transition matrices and sensor rows of all samples by name, as in `Steps` and `Vehicles`.

        Samples within an interval of smooth plants are interpolated, in time; in winds with many
        breakpoints, such as soundings (`_by_pressure`), in time and in dynamic pressure.
        """
        if not self._by_pressure:
            interval = self._interval(self.breaks)
            return smooth_values(self._arrays_at, self.times, interval, self.storage)
        interval = self._interval(self.vehicle_breaks)
        places = self._places(self.times)  # times within each sample at which plants are evaluated
        inside = np.minimum(places, self.stops[self.flight])  # not after the end of the flight
        pressure = self.pressure_at(inside.ravel(), np.tile(self.flight, len(places)))
        return self._in_pressure(interval, pressure.reshape(places.shape))

    @property
    def _by_pressure(self) -> bool:
        """Whether winds have so many breakpoints that matrices are rarely smooth in time alone.

        They are then interpolated in time and dynamic pressure; `vehicle_breaks` omits the winds.
        """
        added = sum(map(np.size, self.breaks)) - sum(map(np.size, self.vehicle_breaks))
        return added > self.times.size / _SAMPLES_PER_BREAK

    def _in_pressure(self, interval: IntArray, pressure: FloatArray) -> dict[str, FloatArray]:
        """Return the matrices of all n samples by name, interpolated in time and dynamic pressure.

        `interval`: number of the interval of each sample in which its vehicle is smooth, ``(n,)``;
        negative for none. `pressure`: q/q_n at the times of `_places`, ``(places, n)``. A run of
        samples in one interval is interpolated if it is long and its interpolant (`_surface`), over
        time, pressure and its change in a part of a sample, converges; else they are computed.
        """
        edges = [0, *(np.flatnonzero(np.diff(interval)) + 1).tolist(), interval.size]
        exact, pending = np.ones(interval.size, bool), []
        for run in (slice(*ends) for ends in pairwise(edges)):
            surface = None
            if interval[run.start] >= 0 and run.stop - run.start >= _MIN_SAMPLES_OF_SURFACE:
                surface = self._surface(run.start, pressure[:, run])
            if surface is not None:
                exact[run] = False
                pending.append((run, surface))
        rows = np.flatnonzero(exact)
        computed = self._arrays_at(self.times[rows], rows, middle=True)
        arrays = {
            name: self.storage.empty(name, (self.times.size, *array.shape[1:]))
            for name, array in computed.items()
        }
        for name, array in computed.items():
            arrays[name][rows] = array
        parts = len(pressure) // 2 - 1  # places: two Gauss points of each part, start, middle
        for run, surface in pending:
            times, at = self.times[run], pressure[:, run]
            no_change = np.zeros(times.size)
            # matrices over a part of a sample depend on the pressure at its two Gauss points
            for p in range(parts):
                # pressure in the middle of the part, and its change to the second Gauss point
                mean, change = 0.5 * (at[p] + at[parts + p]), 0.5 * (at[parts + p] - at[p])
                factors = surface.factors(times, mean, change)
                for name in arrays.keys() - {"shown", "A", "gust"}:
                    surface.write(name, p, factors, arrays[name][run, p])
            # sensor rows at the start of a sample, A and gust input in its middle
            for place, names in ((-2, ("shown",)), (-1, ("A", "gust"))):
                factors = surface.factors(times, at[place], no_change)
                for name in names:
                    surface.write(name, ..., factors, arrays[name][run])
        return arrays

    def _surface(self, sample: int, pressure: FloatArray) -> Surface | None:
        """Return the interpolant of the matrices in the interval of time that contains a sample.

        Its variables are time, dynamic pressure q/q_n, from a multiple of `_PRESSURE_RANGE` below
        the values `pressure` to one above, and the change of it within a sample, in which matrices
        are linear. It is kept for flights with the same plants (`alike`). `sample`: index of the
        sample. None where it does not converge, and where a vehicle is impossible.
        """
        flight = int(self.flight[sample])
        breaks = self.vehicle_breaks[flight]
        k = int(np.searchsorted(breaks, self.times[sample], side="right")) - 1
        low, high = (np.floor(x / _PRESSURE_RANGE) for x in (pressure.min(), pressure.max()))
        span = float(low * _PRESSURE_RANGE), float((high + 1.0) * _PRESSURE_RANGE)
        # starts of samples in the interval: later ones have the next breakpoint inside
        ends = float(breaks[k]), float(breaks[k + 1]) - self.period
        key = (self.alike[flight], ends, span)
        if key not in self.surfaces:
            arrays_in = partial(self._arrays_in, flight)
            self.surfaces[key] = None
            with suppress(InputError, ArithmeticError):
                self.surfaces[key] = Surface.of(arrays_in, ends, span, _PRESSURE_CHANGE)
        return self.surfaces[key]

    def _arrays_in(
        self, flight: int, times: FloatArray, pressure: FloatArray, change: FloatArray
    ) -> dict[str, FloatArray]:
        """Return the matrices of m samples of one flight by name, with a pressure for each sample.

        `flight`: index of the flight. `times`: starts of the samples [s], ``(m,)``. `pressure`:
        dynamic pressure over the nominal one in a sample, ``(m,)``, the same in the middle of all
        its parts. `change`: its change from there to the second Gauss point of each part, ``(m,)``.
        """
        places = self._places(times)  # rows: both Gauss points of each part, start, middle
        parts = len(places) // 2 - 1
        # -1 at the first Gauss points, 1 at the second ones, 0 at start and middle of a sample
        signs = np.repeat([-1.0, 1.0, 0.0], [parts, parts, 2])[:, np.newaxis]
        flights = np.full(places.size, flight)
        return self._assembled(places, flights, (pressure + signs * change).ravel(), middle=True)

    def _places(self, times: FloatArray) -> FloatArray:
        """Return the times [s] within m samples at which the vehicle is evaluated, ``(places, m)``.

        Rows: the first Gauss points of the parts of a sample, their second ones, its start and its
        middle. Parts: after the arrival of a command, and, where that is within a sample, before
        it. `times`: starts of the samples [s], ``(m,)``.
        """
        # `lengths` has the length of the sample [s] ahead of those of its parts, as in all flights
        lengths = self._timing.lengths[0, 1:, np.newaxis]
        # the part after the arrival is the last in time, that before begins with the sample
        begins = times + np.stack([self.period - lengths[0], [0.0]])[: len(lengths)]
        at = [begins + node * lengths for node in GAUSS_NODES]
        return np.concatenate([*at, [times, times + 0.5 * self.period]])

    def _interval(self, breaks: Sequence[FloatArray], *, crossing: bool = False) -> IntArray:
        """Return the number of the smooth interval of the samples of all flights, ``(n,)``.

        Intervals are counted over all flights. A sample with a breakpoint inside, which cannot be
        interpolated, is -1; with `crossing` it has the number of the interval in which it starts.
        `breaks`: times [s] between which each flight is smooth.
        """
        numbers, before = np.empty(self.times.size, np.int64), 0
        # a rounding before the end, so that a breakpoint there is not inside the sample
        ends = (self.times + self.period) * (1.0 - 1e-15)
        for k, times in enumerate(breaks):
            of_flight = slice(self.first_sample[k], self.first_sample[k] + self.samples[k] + 1)
            at = np.searchsorted(times, self.times[of_flight], side="right")
            inside = crossing | (at == np.searchsorted(times, ends[of_flight], side="left"))
            numbers[of_flight] = np.where(inside, before + at, -1)
            before += times.size + 1  # intervals of this flight
        return numbers

    def _arrays_at(
        self, times: FloatArray, sample: IntArray, *, middle: bool = False
    ) -> dict[str, FloatArray]:
        """Return the matrices of m samples by name, ``(m, ...)``.

        `times`: starts of the samples [s], ``(m,)``. `sample`: for each the index of any sample of
        its flight. `middle`: whether A and gust input in the middle of the samples are among the
        matrices. The vehicle is evaluated at the `_places`; after the end of its schedule it is
        frozen.
        """
        places = self._places(times)[: None if middle else -1]
        flight = np.tile(self.flight[sample], len(places))
        inside = np.minimum(places.ravel(), self.stops[flight])
        pressure = self.pressure_at(inside, flight)
        return self._assembled(inside.reshape(places.shape), flight, pressure, middle=middle)

    def _assembled(
        self, places: FloatArray, flight: IntArray, pressure: FloatArray, *, middle: bool
    ) -> dict[str, FloatArray]:
        """Return the matrices of m samples by name, ``(m, ...)``, from plants at times within them.

        Of `Steps`, for the parts of a sample: joint, transition matrices of plant and nozzle; fine,
        those of substeps; ramp, effect on the plant of a deflection that changes at a constant
        rate. Of `Vehicles`: shown, rows of the outputs at the start; A and gust, plant matrices
        in the middle. `places`: times [s] ``(places, m)``: the first Gauss points of each part, the
        second ones, the starts of the samples, and their middles if `middle`. `flight`, `pressure`:
        indices of flights, and dynamic pressures over the nominal one, ``(places m,)``.
        """
        # m samples; coefficients of a piece of the wind, a polynomial
        count, terms, shape = places.shape[1], self._pieces[1].shape[2], flight.shape
        # all samples have the same parts
        timing = Timing._make(np.repeat(field_[:1], count, axis=0) for field_ in self._timing)
        # (parts, m): the first column of a timing's lengths is the whole sample
        lengths = np.ascontiguousarray(timing.lengths[:, 1:].T)
        plants = self.flown_plants(places.ravel(), flight, pressure)
        system = self.sensors.system(plants)
        actuator = self.flown_laws(places.ravel(), flight).actuator
        blocks = [*plant_blocks(plants, actuator, self.sensors), polynomial_input("wind", terms)]

        def at_place(first: int) -> LinearSystem:
            """Return the plants of the m samples at their time with the index `first` in `places`.

            `count` is m; the batch of `system`, of the `shape`, has all places one after another.
            """
            return system.cases(np.arange(first * count, (first + 1) * count), shape)

        def over_parts(loops: LinearSystem) -> LinearSystem:
            """Return the constant system that equals a varying one over each part of m samples.

            To fourth order; a batch ``(parts, m)``, as `lengths`. `loops`: the varying system at
            `places`, a flat batch ``(places m,)``: first Gauss points of all parts, then second.
            """
            first_points = np.arange(lengths.size).reshape(lengths.shape)
            first, second = (
                loops.cases(points, shape) for points in (first_points, first_points + lengths.size)
            )
            return constant_over_steps(first, second, lengths)

        plant = at_place(2 * len(lengths))  # at the starts: after two Gauss points of each part
        driven = over_parts(connect(blocks, INPUTS[:1], ()))  # plant and nozzle
        ramped = over_parts(with_ramp(system))  # plant with a deflection of constant rate
        steps = steps_of(driven, ramped, plant, timing, terms)
        arrays = {"joint": steps.joint, "ramp": steps.ramp, "shown": sensed_rows(plant)}
        if steps.fine is not steps.joint:
            arrays["fine"] = steps.fine
        if middle:
            plant_in_middle = at_place(len(places) - 1)
            gust_input = plant_in_middle.B[..., 1]  # column of the wind
            arrays |= {"A": plant_in_middle.A, "gust": np.ascontiguousarray(gust_input)}
        return arrays

    @cached_property
    def _criteria(self) -> dict[str, FloatArray]:
        """Criteria of loss and survival at all samples, by their names in `Vehicles`.

        "judges": rows that give the unstable coordinates of the loop's states. "reach": the largest
        coordinate that a unit limit recovers. "ratio": the slower unstable pole over the
        fastest, or zero. They are NaN at samples at which no flight is judged: each is judged every
        `JUDGED_SAMPLES` samples after its wind, or in its last seconds.
        """
        is_judged = np.zeros(self.times.size, bool)
        after, _ = self._judged  # from the start of the flight, samples before each wind is judged
        for flight, sample in zip(self.flight_of_wind, after, strict=True):
            start = self.first_sample[flight]
            last = start + self.samples[flight]
            is_judged[start + sample + JUDGED_SAMPLES : last + 1 : JUDGED_SAMPLES] = True
        judged, width = np.flatnonzero(is_judged), self.steps.joint.shape[2]

        def at(times: FloatArray, index: IntArray) -> dict[str, FloatArray]:
            """Return the criteria of loss and survival at times [s], by name.

            As in `OutcomeCriteria`, with its rows as "judges", on the `width` states of the loop.
            `index`: of the samples in `judged`.
            """
            criteria = outcome_criteria(self.plants_at(times, self.flight[judged[index]]))
            judges = widened(criteria.rows, width, len(self.sensors.states))
            return {"judges": judges, "reach": criteria.reach, "ratio": criteria.ratio}

        # criteria are smooth between breakpoints; a sample counts to the interval of its start
        interval = self._interval(self.breaks, crossing=True)[judged]
        arrays = {}
        for name, values in smooth_values(at, self.times[judged], interval).items():
            arrays[name] = self.storage.empty(name, (is_judged.size, *values.shape[1:]))
            arrays[name].fill(np.nan)
            arrays[name][judged] = values
        return arrays

    @cached_property
    def _memory(self) -> Memory:
        """Step matrices of the states of the law and its filters over a sample.

        One for each sample where a filter varies along the flight, else one for all. The state of a
        law without filters is the integral of the attitude, if it is fed back. The rows `inputs`
        and `demand` give the filtered sensor outputs and the filtered demand.
        """
        laws, count = self.laws, self.times.size
        integral = attitude_integral(bool(np.any(laws.integral_gain)))
        chains = Chains(laws.attitude_filters, laws.rate_filters, laws.filters)
        size = len(integral.states) + sum(f.order for chain in chains for f in chain)
        varies = any(filter_.batch for chain in chains for filter_ in chain)
        lengths = np.full(count if varies else 1, self.period)
        memory = memory_of(integral, chains, lengths, size)
        if any(chains):
            return memory
        # without filters the kernel takes sensors and demand as they are: no rows for them
        return memory._replace(inputs=memory.inputs[:0], demand=memory.demand[:0])

    @cached_property
    def _judged(self) -> tuple[IntArray, IntArray]:
        """Sample from which flights through a wind are judged, and number of settled samples.

        Each ``(w,)``, from the start of the flight, which survives if it stays settled, well inside
        the recoverable set, for that number. It is judged every `JUDGED_SAMPLES` from the end of
        its wind; if that is its own end, settling time and two more judgements earlier.
        """
        h, flight = self.period, self.flight_of_wind
        # last samples of flights, and of their winds, from the start of the flight
        of_winds, _ = self._ends
        samples, ends = self.samples[flight], of_winds - self.first_sample[flight]
        # of `plants` those at the ends of winds and of flights follow those at the breakpoints
        criteria, begin = outcome_criteria(self.plants), sum(map(np.size, self.vehicle_breaks))
        # reach is NaN without one or two real unstable poles; such flights have no outcome
        settling = np.ceil(np.where(np.isnan(criteria.reach), 0.0, criteria.settling) / h)
        after_wind, at_end = (
            settling[begin : begin + self._ends.size].astype(np.int64).reshape(2, -1)
        )
        late = ends >= samples  # the wind lasts until the end of its flight
        before = np.maximum(samples - at_end - 2 * JUDGED_SAMPLES, 1)
        return np.where(late, before, ends), np.where(late, at_end, after_wind)

    @cached_property
    def _ends(self) -> IntArray:
        """Indices of the samples at the end of each wind, and of its flight, ``(2, w)``.

        They count the samples of all flights. A wind ends with its flight at the latest.
        """
        flight = self.flight_of_wind
        wind_end = np.concatenate([wind.end.ravel() for wind in self.winds])
        samples = self.samples[flight]  # number of samples in the flight of each wind
        # samples from the start of a flight to the end of its wind, in time counted in periods
        ends = samples_in(wind_end - self.starts[flight], np.array(self.period))
        return self.first_sample[flight] + np.stack([np.minimum(ends, samples), samples])

    def _cases(self, batch: Batch) -> Cases:
        """Return indices, limits and numbers of samples of m flights, as `Cases` of the kernel.

        `batch`: result of `Stages.batch`. It has a vehicle and a law for each sample of a flight,
        the end included, `stages` in number: `vehicle`, `law` and `memory`, the matrices of the
        law's states if these vary, are the indices of those of the first sample. A flight ends at
        its last sample (`finish`), without samples after the wind (`waiting`), and without noise.
        """
        count, (vehicle, wind) = batch.shape[0], batch.indices
        flight, (ends, settling) = self.flight_of_wind[wind], self._judged
        zeros, several = np.zeros(count, np.int64), len(self._memory.states) > 1
        return Cases(
            vehicle=vehicle.copy(),
            wind=wind.copy(),
            law=vehicle.copy(),
            memory=vehicle.copy() if several else zeros.copy(),
            sequence=zeros.copy(),
            stages=self.samples[flight] + 1,
            gain=np.ones(count),
            limit=np.array(batch.limit, float),
            rate_limit=np.array(np.broadcast_to(batch.hardware.rate_limit, (count,)), float),
            start=self.starts[flight],
            finish=self.samples[flight],
            ends=ends[wind],
            waiting=zeros.copy(),
            settling=settling[wind],
        )

    @cached_property
    def vehicles(self) -> Vehicles:
        """Sensor rows (`shown`) and outcome criteria of the vehicles of all samples.

        The state matrix A and the column of the wind in B (`gust`) are set in all samples if
        `_arrays` has them, else in the samples next to a knot of the wind, within which it changes.
        `fastest` is the size of the largest pole [1/s] at the breakpoints of a flight, the same in
        all its samples.
        """
        arrays, moving = self._arrays, self.sensors.system(self.plants)
        # the first of `plants` are at the breakpoints of each flight, the last next to knots
        starts = np.cumsum([0, *(times.size for times in self.vehicle_breaks)])
        poles = np.abs(np.linalg.eigvals(moving.A[: starts[-1]])).max(axis=-1)
        fastest = np.maximum.reduceat(poles, starts[:-1])[self.flight]
        if "A" not in arrays:
            count, n, rows = self.times.size, len(moving.states), self._next_to_knots
            A, gust = self.storage.empty("A", (count, n, n)), self.storage.empty("gust", (count, n))
            A[rows], gust[rows] = (x[len(x) - rows.size :] for x in (moving.A, moving.B[..., 1]))
            arrays = arrays | {"A": A, "gust": gust}
        named = {name: arrays[name] for name in ("shown", "A", "gust")}
        return Vehicles(**named, fastest=fastest, **self._criteria)

    @cached_property
    def _next_to_knots(self) -> IntArray:
        """Indices of samples with a breakpoint (knot) of the wind, and of the next on both sides.

        A sample without one is a step of a table; in these the kernel integrates x' = A x + gust w,
        with the vector `gust`, over parts. None in winds that change the dynamic pressure
        (`_by_pressure`), which have many knots: `_arrays` has A and gust of all samples then.
        """
        if self._by_pressure:
            return np.zeros(0, np.int64)
        flight, (knots, _) = self.flight_of_wind, self._pieces  # knots by wind [s]
        inside = np.floor((knots - self.starts[flight, np.newaxis]) / self.period)  # sample of each
        # of each flight the number of samples, and the index of its first among those of all
        samples, firsts = (
            a[flight, np.newaxis, np.newaxis] for a in (self.samples, self.first_sample)
        )
        neighbours = inside[..., np.newaxis] + np.array([-1, 0, 1])
        is_flown = (neighbours >= 0) & (neighbours <= samples)
        return np.unique((firsts + np.where(is_flown, neighbours, 0))[is_flown]).astype(np.int64)
