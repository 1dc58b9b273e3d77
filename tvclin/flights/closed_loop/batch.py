"""A batch of sampled flights as arrays of the kernel: plants, nozzles, laws and winds.

`Batch` holds plants, hardware and laws; `flights` writes it as `kernels.flights.Flights`.
Between samples of the law vehicle and nozzle are linear, x+ = A x + B u + wind, and their steps are
matrix exponentials. If samples are far apart for the nozzle, a sample is divided into substeps of
1/8 of 1/omega of the actuator. Laws are rows of gains and state space matrices, winds polynomials
between breakpoints.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray, IntArray
from tvclin.control.autopilot.actuator import INPUTS, Actuator, plant_with_actuator
from tvclin.control.autopilot.wiring import LAW_INPUTS
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.law_batch import LawBatch, law_batch
from tvclin.flights.closed_loop.outcomes import OutcomeCriteria, outcome_criteria
from tvclin.kernels import flights as kernel
from tvclin.kernels.control_laws import LawNumbers
from tvclin.kernels.flight_arrays import (
    MEASURED,
    NEVER,
    PEAKS,
    Cases,
    Flights,
    FlightStates,
    Laws,
    Steps,
    Vehicles,
    Winds,
)
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.system import LinearSystem, connect, polynomial_input, split_delay
from tvclin.numerics.pieces import polynomial_pieces
from tvclin.numerics.state_space import join_columns
from tvclin.winds.histories import History

COARSE = 0.5 + 1e-9
"""Samples of a law are steps of the hardware up to this part of 1/omega of its actuator."""
SUBSTEPS = 8.0
"""Substeps in the time 1/omega, where samples are further apart."""


def frequency(actuator: Actuator | None) -> FloatArray:
    """Return the natural frequency of an actuator [rad/s]; zero without one."""
    return np.zeros(()) if actuator is None else np.asarray(actuator.natural_frequency, float)


def with_ramp(plant: LinearSystem) -> LinearSystem:
    """Return a plant without wind and with two further states, which make its deflection linear.

    They are the deflection [rad] and its constant rate [rad/s].
    """
    return connect([plant, polynomial_input("deflection", 2)], (), ())


def joint_steps(driven: LinearSystem, vehicle: int, parts: FloatArray, terms: int) -> FloatArray:
    """Return the transition matrices J of `Steps` over the p vehicles' parts of a sample.

    J maps the N states, the command, and the `terms` coefficients of the wind's polynomial, which
    are the last states of `driven`, to the N states at the end, ``(p, parts, N, N + 1 + terms)``.
    `driven`: vehicles with nozzle and wind. `vehicle`: number of states without the nozzle.
    `parts`: lengths of the parts [s], ``(p, parts)``.
    """
    steps = driven.to_steps(parts.T)
    order = len(driven.states) - terms
    J = join_columns(steps.A[..., :order], steps.B, steps.A[..., order:])[..., :order, :]
    if order == vehicle:
        # Without an actuator the deflection is a state too, equal to its command.
        J = np.insert(np.insert(J, order, 0.0, axis=-1), order, 0.0, axis=-2)
        J[..., order, order + 1] = 1.0
    return np.ascontiguousarray(np.swapaxes(J, 0, 1))


def ramp_steps(ramp: LinearSystem, plant: LinearSystem, parts: FloatArray) -> FloatArray:
    """Return the response of n states to a linear deflection in a part of a sample, `Steps.ramp`.

    The deflection is a + (b - a) t/h, and the columns are of a and b, ``(p, parts, n, 2)``;
    of a plant with the input deflection_acceleration also of the rates before and after, ``(p,
    parts, n, 4)``. `ramp`: result of `with_ramp`. `parts`: lengths h [s], ``(p, parts)``, or zero.
    """
    n, span = len(plant.states), np.where(parts > 0.0, parts, 1.0)[..., np.newaxis]
    moved = ramp.to_steps(parts.T).A  # columns: n states, the deflection, its rate
    # e^(A h), and the response to a deflection that rises from zero by 1 rad/s
    free, rise = (np.swapaxes(moved[..., :n, k], 0, 1) for k in (slice(n), n + 1))
    # responses to a constant deflection of 1 rad, to one that rises to 1 rad, and to rates at ends
    start, rise, kick = np.swapaxes(moved[..., :n, n], 0, 1), rise / span, []
    if "deflection_acceleration" in plant.inputs:
        # x+ = .. + e^(A h) b3 (v - before) + b3 (after - v), v the constant rate of the part and
        # b3 the column of the acceleration: a jump of the rate is an impulse of it at either end
        b3 = np.broadcast_to(plant.B[:, np.newaxis, :, 2], rise.shape)
        later = (free @ b3[..., np.newaxis])[..., 0]
        rise, kick = rise + (later - b3) / span, [-later, b3]
    return np.stack([start - rise, rise, *kick], axis=-1)


def sensed_rows(plant: LinearSystem) -> FloatArray:
    """Return the output rows of p plants for a law, on n states and the wind, ``(p, 4, n + 1)``.

    They are attitude, attitude rate, flight path angle and angle of attack, as the sensors of the
    plant measure them. With lateral sensors rows of drift rate, drift and acceleration follow,
    ``(p, 7, n + 1)``.
    """
    columns = {name: k for k, name in enumerate(plant.outputs)}
    names = ["attitude", "attitude_rate", "flight_path_angle", "angle_of_attack"]
    lateral = LAW_INPUTS[5:]  # drift rate, drift and acceleration
    if columns.keys() & set(lateral):
        names += lateral
    n, rows = len(plant.states), np.zeros((len(plant.C), len(names), len(plant.states) + 1))
    for row, name in enumerate(names):
        k = columns.get(f"sensed_{name}", columns.get(name))
        if k is not None:
            wind = plant.D[:, k, 1]  # inputs: deflection, wind
            rows[:, row, :n], rows[:, row, n] = plant.C[:, k], wind
    return rows


@dataclass(frozen=True, eq=False)
class Hardware:
    """Hardware between a law and the deflection.

    `period`: sample period [s]. `delay`: computing delay [s]. `actuator`: one or a batch, which
    broadcasts with them. `rate_limit`: limit of the deflection rate [rad/s], of the shape of the
    flights.
    """

    period: float | FloatArray
    delay: float | FloatArray
    actuator: Actuator | None = None
    rate_limit: float | FloatArray = np.inf

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch of sample periods, delays and actuators, without the rate limit."""
        actuators = () if self.actuator is None else self.actuator.batch
        return np.broadcast_shapes(actuators, np.shape(self.period), np.shape(self.delay))

    def select(
        self, which: IntArray, shape: tuple[int, ...], flights: IntArray, flown: tuple[int, ...]
    ) -> Hardware:
        """Return the hardware of selected vehicles, with the rate limits of selected flights.

        `which`, `shape`: flat indices of the vehicles, and shape of their batch. `flights`,
        `flown`: flat indices of the flights, and shape of their batch.
        """
        actuator = self.actuator
        if actuator is not None:
            damping = None if actuator.damping is None else elements(actuator.damping, shape, which)
            frequency = elements(actuator.natural_frequency, shape, which)
            actuator = Actuator(natural_frequency=frequency, damping=damping)
        period, delay = (elements(a, shape, which) for a in (self.period, self.delay))
        rate_limit = elements(self.rate_limit, flown, flights)
        return Hardware(period, delay, actuator=actuator, rate_limit=rate_limit)


@dataclass(frozen=True, eq=False)
class Batch:
    """Plants, hardware, laws, winds and limits of a batch of flights.

    `plant`, `hardware`, `wind`: one each or a batch, which broadcasts with the shape, unless
    `vehicle` and `encountered` are given. `laws`: laws of the flights. `limit`: deflection limits
    [rad], of the shape of the batch. `shape`: shape of the batch. `gain`: factors on the demands,
    of the same shape. `until`: end of the flights [s]; infinite until they are decided. `vehicle`,
    `encountered`: indices of the vehicle (plant with hardware) and the wind of each flight in their
    batches, ``(m,)``.
    """

    plant: AnyPlant
    hardware: Hardware
    wind: History
    laws: LawBatch
    limit: float | FloatArray
    shape: tuple[int, ...]
    gain: float | FloatArray = 1.0
    until: float = np.inf
    vehicle: IntArray | None = None
    encountered: IntArray | None = None

    @cached_property
    def system(self) -> LinearSystem:
        """Plants with the lateral sensors of the laws, whose states are the last ones."""
        return self.laws.sensors.system(self.plant)

    @property
    def vehicles(self) -> tuple[int, ...]:
        """Shape of the batch of vehicles, which are plants with their hardware."""
        return np.broadcast_shapes(self.plant.batch, self.hardware.batch)

    @property
    def indices(self) -> tuple[IntArray, IntArray]:
        """Flat indices of the vehicle and of the wind of each flight in their batches, ``(m,)``.

        They are `vehicle` and `encountered`; without these the batches `vehicles` (of plants with
        hardware) and `wind` broadcast to the shape of the flights.
        """
        vehicle, encountered = self.vehicle, self.encountered
        if vehicle is None or encountered is None:
            vehicle, encountered = (
                indices_in(a, self.shape) for a in (self.vehicles, self.wind.batch)
            )
        return vehicle, encountered

    def delayed(self, delay: float | FloatArray) -> Batch:
        """Return the batch with another computing delay [s]."""
        return replace(self, hardware=replace(self.hardware, delay=delay))

    def only(self, mask: BoolArray) -> Batch:
        """Return the flights at which a mask ``(m,)`` is true, with only their vehicles and winds.

        `vehicle` and `encountered`, the index of vehicle and of wind of each flight, then count
        among these. It is used to omit cases that are not possible.
        """
        shape, where = self.vehicles, np.flatnonzero(mask)
        # indices of the vehicles and winds of these flights
        (fleet, vehicle), (winds, encountered) = (
            np.unique(a[where], return_inverse=True) for a in self.indices
        )
        return replace(
            self,
            plant=self.plant.cases(fleet, shape),
            hardware=self.hardware.select(fleet, shape, where, self.shape),
            wind=self.wind.cases(winds, self.wind.batch),
            laws=replace(self.laws, which=self.laws.which[where]),
            limit=elements(self.limit, self.shape, where),
            shape=where.shape,
            gain=elements(self.gain, self.shape, where),
            vehicle=vehicle,
            encountered=encountered,
        )


def one_flight(
    plant: AnyPlant,
    law: Law,
    wind: History,
    limit: float,
    hardware: Hardware,
    gain: float = 1.0,
    until: float = np.inf,
) -> Batch:
    """Return the batch of one flight of a law in a wind, of shape ``()``.

    `limit`: deflection limit [rad]. `hardware`: sample period, delay, actuator and rate limit.
    `gain`: factor on the demand of the law. `until`: end of the flight [s]; infinite until it is
    decided.
    """
    laws = law_batch(law, ())
    return Batch(plant, hardware, wind, laws, limit=limit, shape=(), gain=gain, until=until)


def elements(array: float | FloatArray, shape: tuple[int, ...], which: IntArray) -> FloatArray:
    """Return the elements with flat indices `which` of an array that is broadcast to a shape."""
    return np.asarray(np.broadcast_to(array, shape).ravel()[which])


def indices_in(batch: tuple[int, ...], shape: tuple[int, ...]) -> IntArray:
    """Return the flat index into a `batch` of each element of a larger `shape`, flattened.

    The batch broadcasts to the shape.
    """
    index = np.arange(int(np.prod(batch)), dtype=np.int64).reshape(batch)
    return np.broadcast_to(index, shape).flatten()


_MAX_SAMPLES_AFTER_WIND = 1_000_000
"""Largest number of samples after the wind until a flight is undecided."""
_IDEAL_BANDWIDTH = 1e100
"""Bandwidth [1/s] of a nozzle without actuator."""


def flights(batch: Batch, *, track: bool = False) -> Flights:
    """Return the arrays of the kernel for the flights of a batch at their start, in equilibrium.

    p vehicles are plants with hardware, m flights refer to them by index, and N states are of
    vehicle and nozzle. `track`: whether the samples of a single flight are recorded. All arrays are
    writable: the kernel would be compiled again for others.
    """
    batch_shape, (vehicle, encountered) = batch.vehicles, batch.indices
    knots, pieces = (np.ascontiguousarray(array) for array in polynomial_pieces(batch.wind.pieces))
    terms = pieces.shape[2]
    plant = batch.system.cases(np.arange(int(np.prod(batch_shape))), batch_shape)
    steps = _steps(batch, plant, terms)
    judges = outcome_criteria(batch.plant)  # criteria of loss and survival of each plant
    criteria_index = indices_in(batch.plant.batch, batch_shape)
    cases, noise = _cases(batch, judges, criteria_index)
    h = steps.lengths[vehicle, 0]  # sample periods of the flights [s]; the others are of parts
    memory = batch.laws.memory(h)
    if len(memory.states) > 1:  # matrices for each flight, else one for all
        cases.memory[:] = np.arange(vehicle.size)
    N = steps.joint.shape[2]
    sensor_states = len(plant.states) - len(batch.plant.system.states)  # of lateral sensors
    now = equilibrium(vehicle.size, len(plant.states), steps, terms, memory.states.shape[1])
    # index of the last breakpoint of the wind that is not after the start, -1 before all
    now.piece[:] = (knots[encountered] <= cases.start[:, np.newaxis]).sum(axis=1) - 1
    rows = int(steps.substeps.sum() * cases.finish.max()) if track else 0
    return Flights(
        steps=steps,
        vehicles=Vehicles(
            shown=sensed_rows(plant),
            A=plant.A,
            gust=np.ascontiguousarray(plant.B[..., 1]),  # the column of the wind
            fastest=np.abs(plant.poles).max(axis=-1),
            judges=widened(judges.rows[criteria_index], N, sensor_states),
            reach=judges.reach[criteria_index],
            ratio=judges.ratio[criteria_index],
        ),
        winds=Winds(knots, pieces),
        laws=Laws([numbers or LawNumbers() for numbers in batch.laws.numbers], *memory, noise),
        cases=cases,
        now=now,
        track=np.full((rows, N + 4), np.nan),  # states, command, deflection, limited, begin
    )


def _steps(batch: Batch, plant: LinearSystem, terms: int) -> Steps:
    """Return the transition matrices over the parts of a sample of the p vehicles of a batch.

    The parts are before and after the arrival of a delayed command. `plant`: plants of the vehicles
    with lateral sensors, ``(p,)``. `terms`: number of coefficients of a wind's polynomial. Matrices
    of plant and actuator serve while the nozzle is within its limits; at a limit `plant` alone is
    driven by a deflection that is a straight line.
    """
    hardware, shape = batch.hardware, batch.vehicles
    period, delay = (spread_to(a, shape) for a in (hardware.period, hardware.delay))
    with_actuator = plant_with_actuator(batch.plant, hardware.actuator, batch.laws.sensors)
    with_actuator = with_actuator.cases(np.arange(period.size), shape)  # batch axis (p,)
    # further states generate the polynomial wind; the command of the nozzle stays an input
    driven = connect([with_actuator, polynomial_input("wind", terms)], INPUTS[:1], ())
    timing = Timing.of(hardware, shape, period, delay)
    # at a limit: plants with further states for a straight deflection, and their own equations
    return steps_of(driven, with_ramp(plant), plant, timing, terms)


class Timing(NamedTuple):
    """Lengths of the samples of p vehicles and of their parts; fields as in `Steps`.

    `bandwidth`: rate of a nozzle over its distance from the command [1/s], ``(p, 1)``: the
    bandwidth of first order, 1e100 without an actuator, and zero of second order, whose rate is a
    state instead.
    """

    lengths: FloatArray
    substeps: IntArray
    bandwidth: FloatArray
    late: IntArray

    @classmethod
    def of(
        cls, hardware: Hardware, shape: tuple[int, ...], period: FloatArray, delay: FloatArray
    ) -> Timing:
        """Return the timing of the samples of p vehicles.

        A delay is whole samples, `late`, and a rest, after which a command arrives within a sample.
        The intervals are the sample itself, its part after the arrival, and with a rest its part
        before that; each has `lengths` and a number of `substeps`, one unless the sample is longer
        than half of 1/omega of the actuator (`COARSE`). `hardware`: gives the actuators.
        `shape`: shape of the batch of vehicles. `period`, `delay`: sample periods and computing
        delays [s], ``(p,)``.
        """
        late, rest = split_delay(delay, period)
        parts = [period - rest, rest] if np.any(rest) else [period]
        lengths, actuator = np.stack([period, *parts], axis=-1), hardware.actuator
        frequencies = spread_to(frequency(actuator), shape)
        angles = frequencies[:, np.newaxis] * lengths  # omega times length, of sample and parts
        # 1e-9 is rounding: a whole number of substeps stays that number
        substeps = np.maximum(np.ceil(SUBSTEPS * angles[:, 1:] - 1e-9), 1.0)
        bandwidth = np.full(period.shape, _IDEAL_BANDWIDTH)
        if actuator is not None:
            bandwidth = frequencies if actuator.damping is None else np.zeros(period.shape)
        return cls(
            lengths=lengths,
            substeps=np.where(angles[:, :1] > COARSE, substeps, 1.0).astype(np.int64),
            bandwidth=bandwidth[:, np.newaxis],
            late=late.astype(np.int64),
        )

    @property
    def short(self) -> FloatArray:
        """Lengths [s] of the substeps of each part of a sample of p vehicles, ``(p, parts)``."""
        return self.lengths[:, 1:] / self.substeps

    def steps(self, joint: FloatArray, fine: FloatArray, ramp: FloatArray) -> Steps:
        """Return the `Steps` of these samples with transition matrices of their vehicles.

        `joint`, `fine`: matrices J from states, command and wind to the next states, over the parts
        of a sample and over their substeps. `ramp`: response to a linear deflection in a substep.
        With them go `quick`, bandwidth times substep of a first-order nozzle, the lengths [s], and
        `late`, the whole samples of a delay.
        """
        lengths, substeps, bandwidth, late = self
        quick = np.where(self.short > 0.0, bandwidth * self.short, 0.0)
        return Steps(
            joint=joint,
            fine=fine,
            substeps=substeps,
            ramp=ramp,
            lengths=lengths,
            short=self.short,
            quick=quick,
            late=late,
        )


def steps_of(
    driven: LinearSystem, ramp: LinearSystem, plant: LinearSystem, timing: Timing, terms: int
) -> Steps:
    """Return the transition matrices of p vehicles in winds of `terms` polynomial coefficients.

    `driven`, `ramp`: vehicles with nozzle and with the states of a polynomial wind, and plants with
    those of a linear deflection, ``(p,)``; ``(parts, p)`` if the matrices differ between the parts
    of a sample. `plant`: plants without nozzle, ``(p,)``. `timing`: samples and parts of the
    vehicles. Parts have one matrix each, `joint`; a limited nozzle is stepped by their substeps,
    `fine`, of which the deflection is a straight line, a `ramp`.
    """
    # lengths [s] of the parts, without the whole sample ahead of them, and of their substeps
    lengths, n, short = timing.lengths[:, 1:], len(plant.states), timing.short
    joint = joint_steps(driven, n, lengths, terms)
    fine = joint_steps(driven, n, short, terms) if np.any(timing.substeps > 1) else joint
    return timing.steps(joint, fine, ramp_steps(ramp, plant, short))


def _cases(
    batch: Batch, judges: OutcomeCriteria, criteria_index: IntArray
) -> tuple[Cases, FloatArray]:
    """Return indices, limits and numbers of samples of m flights, as `Cases` of the kernel.

    The second result is rows of noise of measured attitude rates [rad/s]. A flight is judged every
    `JUDGED_SAMPLES` samples, so that the time of waiting is a multiple of them. `judges`: outcome
    criteria of the different plants, with times [s] of settling and waiting; `reach`, the largest
    unstable coordinate that a unit limit recovers, is NaN where flights have no outcome.
    `criteria_index`: index in `judges` of each of p vehicles, ``(p,)``.
    """
    shape, (vehicle, encountered) = batch.shape, batch.indices
    h = spread_to(batch.hardware.period, batch.vehicles)[vehicle]  # sample periods [s], (m,)
    start, end = (a.ravel()[encountered] for a in (batch.wind.onset, batch.wind.end))
    has_reach = ~np.isnan(judges.reach[criteria_index][vehicle])
    waiting, settling = (
        np.ceil(np.where(has_reach, a[criteria_index][vehicle], 0.0) / h)
        for a in (judges.waiting, judges.settling)
    )
    waiting = (  # rounded up: -(-a // b)
        -(-np.minimum(waiting, _MAX_SAMPLES_AFTER_WIND) // kernel.JUDGED_SAMPLES)
        * kernel.JUDGED_SAMPLES
    )
    # samples from the start to the fixed end of a flight, `NEVER` without, and to the wind's end
    finish, ends = (samples_in(a - start, h) for a in (np.full(h.shape, batch.until), end))
    noise, sequence = _noise(batch.laws, np.where(finish < NEVER, finish, ends + waiting))
    cases = Cases(
        vehicle=vehicle,
        wind=encountered,
        law=batch.laws.which.copy(),
        memory=np.zeros_like(
            vehicle
        ),  # row of the matrices of the law's states: all have the first
        sequence=sequence,  # row of noise
        stages=np.ones_like(vehicle),  # a single stage: the vehicle is the same at all samples
        gain=spread_to(batch.gain, shape),
        limit=spread_to(batch.limit, shape),
        rate_limit=spread_to(batch.hardware.rate_limit, shape),
        start=start.copy(),
        finish=finish,
        ends=ends,
        waiting=waiting.astype(np.int64),
        settling=settling.astype(np.int64),
    )
    return cases, noise


def equilibrium(m: int, n: int, steps: Steps, terms: int, memory: int) -> FlightStates:
    """Return the state of `m` flights in equilibrium, with all numbers zero.

    `n`: number of states of the plant. `steps`: transition matrices of the vehicles. `terms`:
    number of coefficients of the wind's polynomial. `memory`: number of states of the laws.
    """
    # intervals of a sample; N states of vehicle and nozzle; `late` whole samples of delay, of which
    # commands are kept
    (_, intervals, N, _), late = steps.joint.shape, int(steps.late.max(initial=0))
    return FlightStates(
        y=np.zeros((m, N)),
        states=np.zeros((m, memory)),
        here=np.zeros((m, terms)),
        sensed=np.zeros((m, MEASURED + 1)),
        measured=np.zeros((m, MEASURED)),
        next=np.zeros((m, max(N, memory))),
        series=np.zeros((m, 3, n)),
        commands=np.zeros((m, late + intervals)),
        mode=np.zeros(m),
        bounded=np.zeros(m, np.bool_),
        peaks=np.zeros((m, PEAKS)),
        piece=np.zeros(m, np.int64),
        settled=np.zeros(m, np.int64),
        outcome=np.zeros(m, np.int64),
        ended=np.full(m, -1, np.int64),
    )


def widened(rows: FloatArray, width: int, count: int) -> FloatArray:
    """Return rows that read a vehicle's states, as rows of `width` columns on a loop's states.

    `rows`: coefficients on n states, deflection and deflection rate, ``(..., n + 2)``. Columns of
    zeros for the `count` states of lateral sensors are inserted before the last two. Then columns
    beyond `width`, of a deflection rate that the loop has not, are cut, or zeros appended.
    """
    rows = np.insert(rows, [rows.shape[-1] - 2] * count, 0.0, axis=-1)
    wide = np.zeros((*rows.shape[:-1], width))
    common = min(width, rows.shape[-1])
    wide[..., :common] = rows[..., :common]
    return wide


def spread_to(array: float | FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """Return an array broadcast to a shape, flattened and writable."""
    return np.array(np.broadcast_to(array, shape), float).ravel()


def samples_in(span: FloatArray, period: FloatArray) -> IntArray:
    """Return the number of samples, at least one, that cover a span [s]; `NEVER` if it is infinite.

    `period`: sampling period [s]. The two are broadcast.
    """
    is_finite = np.isfinite(span)
    # 1e-9 of a sample is rounding: a span of ten periods has ten samples
    samples = np.ceil(np.where(is_finite, span, 0.0) / period - 1e-9)
    return np.where(is_finite, np.maximum(samples, 1), NEVER).astype(np.int64)


def _noise(laws: LawBatch, samples: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return rows of noise [rad/s], one for each level and seed, and the row of each flight.

    The noise of a law is its level [rad/s rms] and its seed; without any the rows are empty.
    `laws`: laws of the flights, with their noise. `samples`: number of samples of each flight,
    ``(m,)``.
    """
    sources = list(dict.fromkeys(laws.noise))
    rows_of_laws = [sources.index(noise) for noise in laws.noise]
    sequence = np.array(rows_of_laws, dtype=np.int64)[laws.which]
    if not any(level for level, _ in sources):
        return np.zeros((1, 0)), sequence
    # a reserve of two judgements of the outcome, which is judged every `JUDGED_SAMPLES`
    count = int(samples.max()) + 2 * kernel.JUDGED_SAMPLES
    rows = [
        np.random.default_rng([seed, 0]).normal(0.0, level, count) if level else np.zeros(count)
        for level, seed in sources
    ]
    return np.stack(rows), sequence
