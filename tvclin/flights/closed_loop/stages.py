"""Sampled flights of a vehicle whose matrices vary: a stage of the kernel for each sample.

Each part of a sample has the constant matrices with the same step, to fourth order, as those that
vary (`constant_over_steps`): exact for whatever is stiff, and for a frozen vehicle the very
matrices of `fly_many`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IntArray
from tvclin.control.autopilot.actuator import INPUTS, plant_blocks
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.wiring import attitude_integral
from tvclin.control.laws.autopilot_law import gain_numbers
from tvclin.control.laws.law import Chains
from tvclin.flights.closed_loop.batch import (
    Batch,
    Hardware,
    LawBatch,
    Memory,
    Timing,
    equilibrium,
    law_rows,
    memory_of,
    samples_in,
    sensed_rows,
    steps_of,
    widened,
    with_ramp,
)
from tvclin.flights.closed_loop.outcomes import outcome_criteria
from tvclin.kernels.control_laws import LawNumbers
from tvclin.kernels.flights import JUDGED_SAMPLES, Cases, Flights, Laws, Steps, Vehicles, Winds
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.lateral import LateralSensors
from tvclin.linear.system import LinearSystem, connect, constant_over_steps, polynomial_input
from tvclin.numerics.chebyshev import smooth_values
from tvclin.numerics.pieces import polynomial_pieces
from tvclin.numerics.propagation import GAUSS_NODES
from tvclin.winds.histories import History

PlantsAt = Callable[[FloatArray], AnyPlant]
LawsAt = Callable[[FloatArray], Autopilot]
"""Functions from times [s] ``(n,)`` to plants, and to autopilots, of that batch."""


@dataclass(frozen=True, eq=False)
class Stages:
    """Sampled loop over a flight: plants and autopilots at its samples, and winds.

    `plants_at`, `laws_at`: plants and autopilots at any times. `times`: times of the samples [s],
    ``(n + 1,)``, the last that of the end. `breaks`: times [s] between which plants and actuator
    are smooth, rising. `plants`: at both ends. `laws`: at the samples. `hardware`: sample period
    and delay; its actuator is that of the laws. `wind`: winds ``(w,)`` over the time of flight.
    """

    plants_at: PlantsAt
    laws_at: LawsAt
    times: FloatArray
    breaks: FloatArray
    plants: AnyPlant
    laws: Autopilot
    hardware: Hardware
    wind: History

    @property
    def samples(self) -> int:
        """Number of samples n."""
        return self.times.size - 1

    @property
    def sensors(self) -> LateralSensors:
        """Sensors of drift and acceleration of the laws."""
        return self.laws.lateral_sensors

    def batch(self, which: IntArray, limit: FloatArray, rate_limit: FloatArray) -> Batch:
        """Return the batch of flights through winds of indices ``(m,)``, with limits [rad, rad/s].

        `limit`, `rate_limit`: limits of deflection and deflection rate, ``(m,)``.
        """
        chains = Chains(self.laws.attitude_filters, self.laws.rate_filters, self.laws.filters)
        first = np.zeros(limit.size, np.int64)
        numbers: Any = self._law_rows.view(np.recarray)
        laws = LawBatch((), numbers, [chains], first, self.sensors)
        return Batch(
            self.plants,
            replace(self.hardware, rate_limit=rate_limit),
            self.wind,
            laws,
            limit,
            limit.shape,
            until=float(self.times[-1]),
            vehicle=first.copy(),
            encountered=which,
        )

    def flights(self, batch: Batch, *, track: bool = False) -> Flights:
        """Return the arrays of the flights of a batch of `batch` at their start, in equilibrium."""
        steps, (knots, pieces) = self.steps, self._pieces
        order, memory, cases = steps.joint.shape[2], self._memory, self._cases(batch)
        now = equilibrium(
            cases.limit.size,
            self.vehicles.A.shape[1],
            steps,
            pieces.shape[2],
            memory.states.shape[1],
        )
        now.piece[:] = ((knots <= self.times[0]).sum(axis=1) - 1)[cases.wind]
        rows = int(steps.substeps[0].sum()) * self.samples if track else 0
        return Flights(
            steps=steps,
            vehicles=self.vehicles,
            winds=Winds(knots, pieces),
            laws=Laws(self._law_rows, *memory, np.zeros((1, 0))),
            cases=cases,
            now=now,
            track=np.full((rows, order + 4), np.nan),
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
        """Breakpoints [s] and polynomials of the winds."""
        knots, pieces = polynomial_pieces(self.wind.pieces)
        return np.ascontiguousarray(knots), np.ascontiguousarray(pieces)

    @cached_property
    def _timing(self) -> Timing:
        """Timing of the samples, with the same substeps in each."""
        count = self.times.size
        length, delay = (
            np.full(count, float(x)) for x in (self.hardware.length, self.hardware.delay)
        )
        timing = Timing.of(self.hardware, (count,), length, delay)
        return timing._replace(  # the rows of a track are as many in each sample
            substeps=np.broadcast_to(timing.substeps.max(axis=0), timing.substeps.shape).copy()
        )

    @cached_property
    def steps(self) -> Steps:
        """Steps of all stages."""
        timing, arrays = self._timing, self._arrays
        short = timing.lengths[:, 1:] / timing.substeps
        return Steps(
            joint=arrays["joint"],
            fine=arrays.get("fine", arrays["joint"]),
            substeps=timing.substeps,
            ramp=arrays["ramp"],
            lengths=timing.lengths,
            short=short,
            quick=np.where(short > 0.0, timing.pace * short, 0.0),
            late=timing.late,
        )

    @cached_property
    def _arrays(self) -> dict[str, FloatArray]:
        """Steps and sensor rows of all stages by name, as in `Steps` and `Vehicles`.

        Samples within an interval of smooth plants are interpolated.
        """
        ends = self.times + float(self.hardware.length)
        interval = np.searchsorted(self.breaks, self.times, side="right") - 1
        same = interval == np.searchsorted(self.breaks, ends * (1.0 - 1e-15), side="left") - 1
        interval = np.where(same, interval, -1)
        return smooth_values(self._arrays_at, self.times, interval)

    def _arrays_at(self, times: FloatArray, _: IntArray) -> dict[str, FloatArray]:
        """Return the arrays of stages that begin at times [s], by name."""
        count, terms, last = times.size, self._pieces[1].shape[2], self.times[-1]
        timing = Timing._make(np.repeat(field_[:1], count, axis=0) for field_ in self._timing)
        lengths = np.ascontiguousarray(timing.lengths[:, 1:].T)  # (parts, m)
        length = timing.lengths[:, 0]
        begins = times + np.stack([length - lengths[0], np.zeros(count)])[: len(lengths)]
        at = [begins + node * lengths for node in GAUSS_NODES]
        flat = np.concatenate([*(a.ravel() for a in at), times])
        flat, shape = np.minimum(flat, last), (flat.size,)
        plants = self.plants_at(flat)
        system = self.sensors.system(plants)
        blocks = [
            *plant_blocks(plants, self.laws_at(flat).actuator, self.sensors),
            polynomial_input("wind", terms),
        ]

        def at_nodes(made: LinearSystem) -> LinearSystem:
            """Return the constant systems of the parts of samples, ``(parts, m)``."""
            count = lengths.size
            first, second = (
                _in_parts(made.cases(np.arange(k * count, (k + 1) * count), shape), lengths.shape)
                for k in range(2)
            )
            return constant_over_steps(first, second, lengths)

        plant = system.cases(np.arange(flat.size - count, flat.size), shape)
        driven = at_nodes(connect(blocks, INPUTS[:1], ()))
        steps = steps_of(driven, at_nodes(with_ramp(system)), plant, timing, terms)
        arrays = {"joint": steps.joint, "ramp": steps.ramp, "shown": sensed_rows(plant)}
        if steps.fine is not steps.joint:
            arrays["fine"] = steps.fine
        return arrays

    @cached_property
    def _criteria(self) -> dict[str, FloatArray]:
        """Rows, reach and ratio of the outcome criteria of all stages, as in `Vehicles`.

        Those of samples at which no flight is judged are NaN.
        """
        ends, judged = self._judged[0], np.zeros(self.times.size, bool)
        for end in np.unique(ends):
            judged[end + JUDGED_SAMPLES :: JUDGED_SAMPLES] = True
        times, width = self.times[judged], self.steps.joint.shape[2]

        def at(times: FloatArray, _: IntArray) -> dict[str, FloatArray]:
            criteria = outcome_criteria(self.plants_at(times))
            rows = widened(criteria.rows, width, len(self.sensors.states))
            return {"judges": rows, "reach": criteria.reach, "ratio": criteria.ratio}

        interval = np.searchsorted(self.breaks, times, side="right") - 1
        arrays = {}
        for name, values in smooth_values(at, times, interval).items():
            arrays[name] = np.full((judged.size, *values.shape[1:]), np.nan)
            arrays[name][judged] = values
        return arrays

    @cached_property
    def _memory(self) -> Memory:
        """Return the steps of the states of laws and filters of all stages, or one for all."""
        laws, count = self.laws, self.times.size
        integral = attitude_integral(bool(np.any(laws.integral_gain)))
        chains = Chains(laws.attitude_filters, laws.rate_filters, laws.filters)
        size = len(integral.states) + sum(f.order for chain in chains for f in chain)
        varies = any(filter_.batch for chain in chains for filter_ in chain)
        lengths = np.full(count if varies else 1, float(self.hardware.length))
        memory = memory_of(integral, chains, lengths, size)
        if any(chains):
            return memory
        return memory._replace(inputs=memory.inputs[:0], demand=memory.demand[:0])

    @cached_property
    def _judged(self) -> tuple[IntArray, IntArray]:
        """Samples after which flights through each wind are judged, and for which they settle.

        Both are ``(w,)``. In a wind that lasts until the end of the flight they are the settling
        time before the end.
        """
        h = float(self.hardware.length)
        ends = samples_in(self.wind.end.ravel() - self.times[0], np.array(h))
        ends = np.minimum(ends, self.samples)
        at_end = outcome_criteria(self.plants_at(self.times[np.append(ends, self.samples)]))
        settling = np.ceil(np.where(np.isnan(at_end.reach), 0.0, at_end.settling) / h)
        settling = settling.astype(np.int64)
        late = ends >= self.samples
        before = self.samples - settling[-1] - 2 * JUDGED_SAMPLES
        ends = np.where(late, max(before, 1), ends)
        settling = np.where(late, settling[-1], settling[:-1])
        return ends.astype(np.int64), settling

    def _cases(self, batch: Batch) -> Cases:
        """Return the numbers of each flight; outcomes are judged after its wind."""
        count, (vehicle, wind) = batch.shape[0], batch.indices
        ends, settling = self._judged
        zeros = np.zeros(count, np.int64)
        return Cases(
            vehicle=vehicle.copy(),
            wind=wind.copy(),
            law=zeros.copy(),
            memory=zeros.copy(),
            sequence=zeros.copy(),
            stages=np.full(count, self.times.size, np.int64),
            gain=np.ones(count),
            limit=np.array(batch.limit, float),
            rate_limit=np.array(np.broadcast_to(batch.hardware.rate_limit, (count,)), float),
            start=np.full(count, float(self.times[0])),
            finish=np.full(count, self.samples, np.int64),
            ends=ends[wind],
            waiting=zeros.copy(),
            settling=settling[wind],
        )

    @cached_property
    def vehicles(self) -> Vehicles:
        """Vehicles of all stages; A and gust input in samples next to a knot of the wind."""
        count, h, knots = self.times.size, float(self.hardware.length), self._pieces[0]
        inside = np.floor((knots[np.isfinite(knots)] - self.times[0]) / h)
        neighbours = np.unique(np.concatenate([inside - 1, inside, inside + 1]))
        neighbours = neighbours[(neighbours >= 0) & (neighbours < count)].astype(np.int64)
        middles = np.minimum(self.times[neighbours] + 0.5 * h, self.times[-1])
        moving, fastest = self.sensors.system(self.plants_at(middles)), np.zeros(count)
        fastest[neighbours] = np.abs(np.linalg.eigvals(moving.A)).max(axis=-1)
        A, gust = (np.zeros((count, *moving.A.shape[-k:])) for k in (2, 1))
        A[neighbours], gust[neighbours] = moving.A, moving.B[..., 1]
        shown = self._arrays["shown"]
        return Vehicles(shown=shown, A=A, gust=gust, fastest=fastest, **self._criteria)


def stages_of(
    plants_at: PlantsAt,
    laws_at: LawsAt,
    breaks: FloatArray,
    span: tuple[float, float],
    rate: float,
    wind: History,
) -> Stages:
    """Return the stages of a loop over a span [s] in winds ``(w,)``.

    `rate`: samples [Hz]. Others: see `Stages`.
    """
    h, (start, stop) = 1.0 / rate, span
    count = int(samples_in(np.array(stop - start), np.array(h)))
    times = np.asarray(start + h * np.arange(count + 1), np.float64)

    def plants_until(at: FloatArray) -> AnyPlant:
        return plants_at(np.minimum(at, stop))

    def laws_until(at: FloatArray) -> Autopilot:
        return laws_at(np.minimum(at, stop))

    laws = laws_until(times)
    hardware = Hardware(h, float(np.unique(laws.delay)[0]), laws.actuator)
    ends = np.array([start, stop])
    inside = np.unique(np.concatenate([breaks, ends]))
    plants = plants_at(ends)
    return Stages(plants_until, laws_until, times, inside, plants, laws, hardware, wind)


def _in_parts(system: LinearSystem, shape: tuple[int, ...]) -> LinearSystem:
    """Return a system, or a flat batch of systems, as a batch of the shape (substeps, samples)."""

    def shaped(matrix: FloatArray) -> FloatArray:
        tail = matrix.shape[-2:]
        return np.broadcast_to(matrix, (int(np.prod(shape)), *tail)).reshape(*shape, *tail)

    A, B, C, D = (shaped(matrix) for matrix in system.matrices())
    return replace(system, A=A, B=B, C=C, D=D)
