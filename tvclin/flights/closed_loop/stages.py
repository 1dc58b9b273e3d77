"""Sampled flights of a vehicle whose matrices vary: a stage of the kernel for each sample.

Each part of a sample has the constant matrices with the same step, to fourth order, as those that
vary (`constant_over_steps`): exact for whatever is stiff, and for a frozen vehicle the very
matrices of `fly_many`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

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
    """Sampled loop over a flight: plants and autopilots at its samples.

    `loops`: plants and autopilots at any times. `times`: times of the samples [s], ``(n + 1,)``,
    the last that of the end. `plants`, `laws`: at these times. `hardware`: sample period, delay and
    rate limit; its actuator is that of the laws.
    """

    loops: Loops
    times: FloatArray
    plants: AnyPlant
    laws: Autopilot
    hardware: Hardware

    @property
    def samples(self) -> int:
        """Number of samples n."""
        return self.times.size - 1

    @property
    def sensors(self) -> LateralSensors:
        """Sensors of drift and acceleration of the laws."""
        return self.laws.lateral_sensors

    def batch(self, wind: History, limit: FloatArray) -> Batch:
        """Return the batch of flights through winds ``(m,)`` with deflection limits [rad]."""
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
            self.hardware,
            wind,
            laws,
            limit,
            limit.shape,
            until=float(self.times[-1]),
            vehicle=first.copy(),
            encountered=np.arange(limit.size),
        )

    def flights(self, batch: Batch, *, track: bool = False) -> Flights:
        """Return the arrays of the flights of a batch of `batch` at their start, in equilibrium."""
        knots, pieces = (np.ascontiguousarray(one) for one in polynomial_pieces(batch.wind.pieces))
        count, start = self.times.size, float(self.times[0])
        plant = self.sensors.system(self.plants).cases(np.arange(count), (count,))
        steps = self._steps(plant, pieces.shape[2])
        memory, order = self._memory(), steps.joint.shape[2]
        cases = self._cases(batch, start)
        now = equilibrium(
            cases.limit.size, len(plant.states), steps, pieces.shape[2], memory.moved.shape[1]
        )
        now.piece[:] = (knots <= start).sum(axis=1) - 1
        rows = int(steps.substeps[0].sum()) * self.samples if track else 0
        return Flights(
            steps=steps,
            vehicles=self._vehicles(knots, int(cases.ends.min()), order),
            winds=Winds(knots, pieces),
            laws=Laws(list(batch.laws.numbers), *memory, np.zeros((1, 0))),
            cases=cases,
            now=now,
            track=np.full((rows, order + 4), np.nan),
        )

    def _steps(self, plant: LinearSystem, terms: int) -> Steps:
        """Return the steps of all stages in winds of `terms` polynomial coefficients."""
        count = self.times.size
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
            plant,
            timing,
            terms,
        )

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

    def _cases(self, batch: Batch, start: float) -> Cases:
        """Return the numbers of each flight; outcomes are judged after its wind.

        In a wind that lasts until the end of the flight they are judged over the settling time
        before the end.
        """
        count, wind = batch.shape[0], batch.wind
        h = np.full(count, float(self.hardware.length))
        ends = np.minimum(samples_in(wind.end.ravel() - start, h), self.samples)
        finish = np.full(count, self.samples, np.int64)
        at_end = outcome_criteria(self._plants_at(np.append(ends, self.samples)))
        settling = np.ceil(np.where(np.isnan(at_end.reach), 0.0, at_end.settling) / h[0])
        settling = settling.astype(np.int64)
        late = ends >= self.samples
        before = self.samples - settling[-1] - 2 * JUDGED_SAMPLES
        ends = np.where(late, max(before, 1), ends)
        settling = np.where(late, settling[-1], settling[:-1])
        zeros = np.zeros(count, np.int64)
        return Cases(
            vehicle=zeros.copy(),
            wind=np.arange(count),
            law=zeros.copy(),
            memory=zeros.copy(),
            sequence=zeros.copy(),
            stages=np.full(count, self.times.size, np.int64),
            gain=np.ones(count),
            limit=np.array(batch.limit, float),
            rate_limit=np.array(np.broadcast_to(self.hardware.rate_limit, (count,)), float),
            start=np.full(count, start),
            finish=finish,
            ends=ends.astype(np.int64),
            waiting=zeros.copy(),
            settling=settling,
        )

    def _plants_at(self, stages: IntArray | IndexArray) -> AnyPlant:
        """Return the plants at indices of samples, ``(k,)``."""
        return self.loops(self.times[stages])[0]

    def _vehicles(self, knots: FloatArray, judged_from: int, order: int) -> Vehicles:
        """Return the further numbers of all stages.

        Criteria exist from the sample on from which flights are judged, and the fastest pole where
        a wind has a knot within the sample.
        """
        count, h = self.times.size, float(self.hardware.length)
        shown = sensed_rows(self.sensors.system(self.plants).cases(np.arange(count), (count,)))
        middle = np.minimum(self.times + 0.5 * h, self.times[-1])
        plants = self.loops(middle)[0]
        system = self.sensors.system(plants).cases(np.arange(count), (count,))
        judged = np.arange(min(judged_from, self.samples), count)
        criteria = outcome_criteria(self._plants_at(judged))
        rows = np.zeros((count, 2, order))
        reach, ratio, fastest = np.full(count, np.nan), np.zeros(count), np.zeros(count)
        rows[judged] = widened(criteria.rows, order, self.sensors)
        reach[judged], ratio[judged] = criteria.reach, criteria.ratio
        inside = np.floor((knots[np.isfinite(knots)] - self.times[0]) / h)
        near = np.unique(np.concatenate([inside - 1, inside, inside + 1]))
        near = near[(near >= 0) & (near < count)].astype(np.int64)
        fastest[near] = np.abs(np.linalg.eigvals(system.A[near])).max(axis=-1)
        return Vehicles(
            shown=shown,
            A=np.array(system.A),
            gust=np.ascontiguousarray(system.B[..., 1]),
            fastest=fastest,
            judges=rows,
            reach=reach,
            ratio=ratio,
        )


def stages_of(
    loops: Loops, start: float, stop: float, rate: float, rate_limit: FloatArray
) -> Stages:
    """Return the stages of a loop between two times [s] at a sample rate [Hz]."""
    h = 1.0 / rate
    count = int(samples_in(np.array(stop - start), np.array(h)))
    times = np.asarray(start + h * np.arange(count + 1), np.float64)
    inside = np.asarray(np.minimum(times, stop), np.float64)

    def until_stop(at: FloatArray) -> tuple[AnyPlant, Autopilot]:
        return loops(np.minimum(at, stop))

    plants, laws = loops(inside)
    delay = float(np.unique(laws.delay)[0])
    return Stages(until_stop, times, plants, laws, Hardware(h, delay, laws.actuator, rate_limit))


def _in_parts(system: LinearSystem, shape: tuple[int, ...]) -> LinearSystem:
    """Return systems of a flat batch, or one system for all, in the shape of parts and samples."""

    def shaped(matrix: FloatArray) -> FloatArray:
        tail = matrix.shape[-2:]
        return np.broadcast_to(matrix, (int(np.prod(shape)), *tail)).reshape(*shape, *tail)

    A, B, C, D = (shaped(matrix) for matrix in system.matrices())
    return replace(system, A=A, B=B, C=C, D=D)
