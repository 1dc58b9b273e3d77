"""Sampled flights of a vehicle whose matrices vary: a stage of the kernel for each sample.

Each part of a sample has the constant matrices with the same step, to fourth order, as those that
vary (`constant_over_steps`): exact for whatever is stiff, and for a frozen vehicle the very
matrices of `fly_many`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tvclin.base.arrays import FloatArray, IndexArray, IntArray
from tvclin.control.autopilot.actuator import plant_with_actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.wiring import attitude_integral
from tvclin.control.laws.attitude import gain_numbers
from tvclin.control.laws.law import Chains
from tvclin.flights.closed_loop.batch import (
    Batch,
    Hardware,
    LawBatch,
    Memory,
    Timing,
    equilibrium,
    memory_of,
    samples_in,
    sensed_rows,
    steps_of,
    widened,
    with_ramp,
    with_wind,
)
from tvclin.flights.closed_loop.outcomes import outcome_criteria
from tvclin.kernels.control_laws import LawNumbers
from tvclin.kernels.flights import JUDGED_SAMPLES, Cases, Flights, Laws, Steps, Vehicles, Winds
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.lateral import LateralSensors
from tvclin.linear.system import LinearSystem, constant_over_steps
from tvclin.numerics.pieces import polynomial_pieces
from tvclin.numerics.propagation import GAUSS_NODES
from tvclin.winds.histories import History

Loops = Callable[[FloatArray], tuple[AnyPlant, Autopilot]]
"""A function from times [s] ``(n,)`` to plants and autopilots of that batch."""


@dataclass(frozen=True, eq=False)
class Stages:
    """Sampled loop over a flight: plants and autopilots at its samples, and winds.

    `loops`: plants and autopilots at any times. `times`: times of the samples [s], ``(n + 1,)``,
    the last that of the end. `plants`, `laws`: at these times. `hardware`: sample period and
    delay; its actuator is that of the laws. `wind`: winds ``(w,)`` over the time of flight.
    """

    loops: Loops
    times: FloatArray
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
        gains = gain_numbers(self.laws)
        columns = (np.broadcast_to(gain, self.times.shape).tolist() for gain in gains.values())
        numbers: list[LawNumbers | None] = [
            LawNumbers(**dict(zip(gains, row, strict=True))) for row in zip(*columns, strict=True)
        ]
        first = np.zeros(limit.size, np.int64)
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
            memory.moved.shape[1],
        )
        now.piece[:] = ((knots <= self.times[0]).sum(axis=1) - 1)[cases.wind]
        rows = int(steps.substeps[0].sum()) * self.samples if track else 0
        return Flights(
            steps=steps,
            vehicles=self.vehicles,
            winds=Winds(knots, pieces),
            laws=Laws(list(batch.laws.numbers), *memory, np.zeros((1, 0))),
            cases=cases,
            now=now,
            track=np.full((rows, order + 4), np.nan),
        )

    @cached_property
    def _pieces(self) -> tuple[FloatArray, FloatArray]:
        """Breakpoints [s] and polynomials of the winds."""
        knots, pieces = polynomial_pieces(self.wind.pieces)
        return np.ascontiguousarray(knots), np.ascontiguousarray(pieces)

    @cached_property
    def _sensed(self) -> LinearSystem:
        """Plants with the sensors of the laws at the samples."""
        count = self.times.size
        return self.sensors.system(self.plants).cases(np.arange(count), (count,))

    @cached_property
    def steps(self) -> Steps:
        """Steps of all stages."""
        count, terms = self.times.size, self._pieces[1].shape[2]
        length, delay = (
            np.full(count, float(x)) for x in (self.hardware.length, self.hardware.delay)
        )
        timing = Timing.of(self.hardware, (count,), length, delay)
        timing = timing._replace(  # the rows of a track are as many in each sample
            substeps=np.broadcast_to(timing.substeps.max(axis=0), timing.substeps.shape).copy()
        )
        lengths = np.ascontiguousarray(timing.lengths[:, 1:].T)  # (parts, n + 1)
        begins = self.times + np.stack([length - lengths[0], np.zeros(count)])[: len(lengths)]
        driven, ramps = [], []
        for node in GAUSS_NODES:
            at = begins + node * lengths
            plants, laws = self.loops(np.minimum(at, self.times[-1]).ravel())
            moving = plant_with_actuator(plants, laws.actuator, self.sensors)
            driven.append(_in_parts(with_wind(moving, terms), at.shape))
            ramps.append(_in_parts(with_ramp(self.sensors.system(plants)), at.shape))
        return steps_of(
            constant_over_steps(driven[0], driven[1], lengths),
            constant_over_steps(ramps[0], ramps[1], lengths),
            self._sensed,
            timing,
            terms,
        )

    @cached_property
    def _memory(self) -> Memory:
        """Return the steps of the states of laws and filters of all stages."""
        laws, count = self.laws, self.times.size
        integral = attitude_integral(bool(np.any(laws.integral_gain)))
        chains = Chains(laws.attitude_filters, laws.rate_filters, laws.filters)
        size = len(integral.states) + sum(f.order for chain in chains for f in chain)
        lengths = np.full(count, float(self.hardware.length))
        memory = memory_of(integral, chains, lengths, size)
        if any(chains):
            return memory
        return Memory(memory.moved, memory.seen[:0], memory.told[:0])

    @cached_property
    def _judged(self) -> tuple[IntArray, IntArray]:
        """Samples after which flights through each wind are judged, and for which they settle.

        Both are ``(w,)``. In a wind that lasts until the end of the flight they are the settling
        time before the end.
        """
        h = float(self.hardware.length)
        ends = samples_in(self.wind.end.ravel() - self.times[0], np.array(h))
        ends = np.minimum(ends, self.samples)
        at_end = outcome_criteria(self._plants_at(np.append(ends, self.samples)))
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

    def _plants_at(self, stages: IntArray | IndexArray) -> AnyPlant:
        """Return the plants at indices of samples, ``(k,)``."""
        return self.loops(self.times[stages])[0]

    @cached_property
    def vehicles(self) -> Vehicles:
        """Further numbers of all stages.

        Criteria exist from the sample on from which flights are judged, and the fastest pole where
        a wind has a knot within the sample.
        """
        count, h, knots = self.times.size, float(self.hardware.length), self._pieces[0]
        middle = np.minimum(self.times + 0.5 * h, self.times[-1])
        plants = self.loops(middle)[0]
        system = self.sensors.system(plants).cases(np.arange(count), (count,))
        judged = np.arange(min(int(self._judged[0].min()), self.samples), count)
        criteria = outcome_criteria(self._plants_at(judged))
        rows = np.zeros((count, 2, self.steps.joint.shape[2]))
        reach, ratio, fastest = np.full(count, np.nan), np.zeros(count), np.zeros(count)
        rows[judged] = widened(criteria.rows, rows.shape[2], self.sensors)
        reach[judged], ratio[judged] = criteria.reach, criteria.ratio
        inside = np.floor((knots[np.isfinite(knots)] - self.times[0]) / h)
        near = np.unique(np.concatenate([inside - 1, inside, inside + 1]))
        near = near[(near >= 0) & (near < count)].astype(np.int64)
        fastest[near] = np.abs(np.linalg.eigvals(system.A[near])).max(axis=-1)
        return Vehicles(
            shown=sensed_rows(self._sensed),
            A=np.array(system.A),
            gust=np.ascontiguousarray(system.B[..., 1]),
            fastest=fastest,
            judges=rows,
            reach=reach,
            ratio=ratio,
        )


def stages_of(loops: Loops, start: float, stop: float, rate: float, wind: History) -> Stages:
    """Return the stages of a loop between two times [s] in winds ``(w,)``; `rate`: samples [Hz]."""
    h = 1.0 / rate
    count = int(samples_in(np.array(stop - start), np.array(h)))
    times = np.asarray(start + h * np.arange(count + 1), np.float64)
    inside = np.asarray(np.minimum(times, stop), np.float64)

    def until_stop(at: FloatArray) -> tuple[AnyPlant, Autopilot]:
        return loops(np.minimum(at, stop))

    plants, laws = loops(inside)
    delay = float(np.unique(laws.delay)[0])
    return Stages(until_stop, times, plants, laws, Hardware(h, delay, laws.actuator), wind)


def _in_parts(system: LinearSystem, shape: tuple[int, ...]) -> LinearSystem:
    """Return systems of a flat batch, or one system for all, in the shape of parts and samples."""

    def shaped(matrix: FloatArray) -> FloatArray:
        tail = matrix.shape[-2:]
        return np.broadcast_to(matrix, (int(np.prod(shape)), *tail)).reshape(*shape, *tail)

    A, B, C, D = (shaped(matrix) for matrix in system.matrices())
    return replace(system, A=A, B=B, C=C, D=D)
