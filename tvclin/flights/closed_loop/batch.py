"""A batch of sampled flights as arrays of the kernel: plants, nozzles, laws and winds.

`Batch` holds plants, hardware and laws; `flights` writes it as `kernels.flights.Flights`.
Between samples of the law vehicle and nozzle are linear, x+ = A x + B u + wind, and their steps are
matrix exponentials. If samples are far apart for the nozzle, a sample is divided into substeps of
1/8 of 1/omega of the actuator. Laws are rows of gains and state space matrices, winds polynomials
between breakpoints.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import factorial
from typing import Any, NamedTuple

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IntArray
from tvclin.base.errors import MAX_AXES, InputError
from tvclin.control.autopilot.actuator import INPUTS, Actuator, plant_with_actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import CHAINS
from tvclin.control.autopilot.wiring import (
    LAW_INPUTS,
    LAW_OUTPUT,
    RETURNED,
    attitude_integral,
    law_blocks,
)
from tvclin.control.laws.law import Chains, Law
from tvclin.flights.closed_loop.outcomes import OutcomeCriteria, outcome_criteria
from tvclin.kernels import flights as kernel
from tvclin.kernels.control_laws import LawNumbers
from tvclin.kernels.flights import (
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
from tvclin.numerics.pieces import at_pieces, locate, recentred, spread
from tvclin.numerics.state_space import beside
from tvclin.winds.histories import History

COARSE = 0.5 + 1e-9
"""Samples of a law are steps of the hardware up to this part of 1/omega of its actuator."""
SUBSTEPS = 8.0
"""Substeps in the time 1/omega, where samples are further apart."""


def quickness(actuator: Actuator | None) -> FloatArray:
    """Return the bandwidth of a nozzle of first order [1/s], infinite without one, else zero."""
    if actuator is None:
        return np.asarray(np.inf)
    bandwidth = np.asarray(actuator.natural_frequency, dtype=float)
    return bandwidth if actuator.damping is None else np.zeros(actuator.batch)


def frequency(actuator: Actuator | None) -> FloatArray:
    """Return the natural frequency of a nozzle [rad/s], zero without one."""
    return np.zeros(()) if actuator is None else np.asarray(actuator.natural_frequency, float)


def substeps_of(frequencies: FloatArray, lengths: FloatArray) -> IntArray:
    """Return in how many substeps each part ``(p, parts)`` of a step may have to be walked.

    One where the samples of the law are as close as the nozzle needs; more where they are not.

    `frequencies`: of the nozzles [rad/s], ``(p,)``. `lengths`: of a step and its parts [s], ``(p, 1
    + parts)``.
    """
    turns = frequencies[:, np.newaxis] * lengths
    wanted = np.maximum(np.ceil(SUBSTEPS * turns[:, 1:] - 1e-9), 1.0)
    return np.where(turns[:, :1] > COARSE, wanted, 1.0).astype(np.int64)


def joint_steps(moving: LinearSystem, vehicle: int, parts: FloatArray, terms: int) -> FloatArray:
    """Return J of `Flights` for a vehicle with its nozzle, see `plant_with_actuator`.

    The wind goes on as the polynomial that it is now.
    """
    steps = connect([moving, polynomial_input("wind", terms)], INPUTS[:1], ()).to_steps(parts.T)
    order = len(moving.states)
    J = beside(steps.A[..., :order], steps.B, steps.A[..., order:])[..., :order, :]
    if order == vehicle:
        # Without a nozzle the deflection is a state all the same: at its command at once.
        J = np.insert(np.insert(J, order, 0.0, axis=-1), order, 0.0, axis=-2)
        J[..., order, order + 1] = 1.0
    return np.ascontiguousarray(np.swapaxes(J, 0, 1))


def even_steps(plant: LinearSystem, parts: FloatArray) -> FloatArray:
    """Return the ramp of `Flights`, of a plant whose deflection goes evenly from a to b in a part.

    As a polynomial it is a + (b - a) t/h.
    """
    n, span = len(plant.states), np.where(parts > 0.0, parts, 1.0)[..., np.newaxis]
    moved = connect([plant, polynomial_input("deflection", 2)], (), ()).to_steps(parts.T).A
    free, rise = (np.swapaxes(moved[..., :n, k], 0, 1) for k in (slice(n), n + 1))
    start, rise, kick = np.swapaxes(moved[..., :n, n], 0, 1), rise / span, []
    if "deflection_acceleration" in plant.inputs:
        # x+ = .. + e^(A h) b3 (v - before) + b3 (after - v), v the even rate of the part
        b3 = np.broadcast_to(plant.B[:, np.newaxis, :, 2], rise.shape)
        later = (free @ b3[..., np.newaxis])[..., 0]
        rise, kick = rise + (later - b3) / span, [-later, b3]
    return np.stack([start - rise, rise, *kick], axis=-1)


def sensed_rows(plant: LinearSystem) -> FloatArray:
    """Return attitude, rate, path and angle of attack as sensors give them, of states and wind."""
    n, rows = len(plant.states), np.zeros((len(plant.C), 4, len(plant.states) + 1))
    places = {name: k for k, name in enumerate(plant.outputs)}
    for row, name in enumerate(
        ("attitude", "attitude_rate", "flight_path_angle", "angle_of_attack")
    ):
        k = places.get(f"sensed_{name}", places.get(name))
        if k is not None:
            rows[:, row, :n], rows[:, row, n] = plant.C[:, k], plant.D[:, k, 1]
    return rows


_SPAN = 0.5
"""Exponentials become polynomials on pieces so wide, over their rate."""
_TERMS = 10
"""0.5^11/11! is below 2e-11."""


def polynomial_pieces(wind: History) -> tuple[FloatArray, FloatArray]:
    """Return a batch of winds as polynomials between breakpoints.

    Breakpoints ``(winds, k)`` and coefficients ``(winds, k, degree + 1)``, lowest power first.
    Winds of straight lines stay exact; pieces with exponentials are cut until a polynomial
    stands for them to 2e-11 of their size.
    """
    pieces = wind.pieces
    batch = pieces.batch or (1,)
    pieces = spread(pieces, batch)
    size = int(np.prod(batch))
    knots = pieces.knots.reshape(size, pieces.knots.shape[-1])
    c = pieces.coefficients.reshape(size, *pieces.coefficients.shape[-3:])
    rates = pieces.rates.reshape(size, pieces.rates.shape[-1])
    if not np.any(rates):
        return knots.copy(), np.real(c.sum(axis=-2)).astype(float)
    edges = _cut(knots, np.abs(rates).max(axis=-1))
    flat = type(pieces)(knots, c, rates)
    index, u = locate(flat, edges)
    here = recentred(at_pieces(c, index, 2), rates, np.maximum(u, 0.0))
    order = here.shape[-1] + _TERMS
    found = np.zeros((*edges.shape, order), dtype=complex)
    for k in range(_TERMS + 1):
        growth = rates[:, np.newaxis, :, np.newaxis] ** k / factorial(k)
        found[..., k : k + here.shape[-1]] += (here * growth).sum(axis=-2)
    return edges, np.ascontiguousarray(np.real(found))


def _cut(knots: FloatArray, fastest: FloatArray) -> FloatArray:
    """Knots with as many more between them as the fastest rate of any wind asks for."""
    widths = np.diff(knots, axis=-1)
    parts = np.ceil((widths * fastest[:, np.newaxis]).max(axis=0, initial=0.0) / _SPAN)
    columns = [
        knots[:, k : k + 1] + widths[:, k : k + 1] * np.arange(n) / n
        for k, n in enumerate(np.maximum(parts, 1.0).astype(int))
    ]
    return np.concatenate([*columns, knots[:, -1:]], axis=-1)


SENSED = ("sensed_attitude", "sensed_attitude_rate", *LAW_INPUTS[2:])
"""What the sensors give, as of `Measurement`."""


class Memory(NamedTuple):
    """What a step makes of the s states of laws with their filters, for each flight or for all.

    Each row acts on the states, then on what is sensed, five numbers, and what a law asks for.

    `moved`: the next states, ``(l, s, s + 6)``. `seen`: what the laws see, ``(l, 5, s + 6)``; of no
    length without filters. `told`: what the limit is told, ``(l, s + 6)``; likewise.
    """

    moved: FloatArray
    seen: FloatArray
    told: FloatArray


@dataclass(frozen=True, eq=False)
class LawBatch:
    """The laws of m flights.

    `laws`: those that there are; none where a batch of gains stands for them. `numbers`: of each;
    None where Python must be asked. `chains`: the filters of each law; of all at once where a batch
    of gains stands for them. `which`: the law of each flight, ``(m,)``.
    """

    laws: tuple[Law, ...]
    numbers: list[LawNumbers | None]
    chains: list[Chains]
    which: IntArray

    @property
    def noise(self) -> list[tuple[float, int]]:
        """The noise of each law: a level [rad/s] and a seed."""
        return [law.rate_noise for law in self.laws] or [(0.0, 0)] * len(self.numbers)

    def memory(self, lengths: FloatArray) -> Memory:
        """Return what steps [s] ``(m,)`` make of the states of the laws and their filters."""
        integral = any(one is not None and one.first_state for one in self.numbers)
        systems = [law.state_space for law in self.laws] or [attitude_integral(integral)]
        which = self.which if self.laws else np.zeros(lengths.size, np.int64)
        size = max(
            len(own.states) + sum(one.order for chain in chains for one in chain)
            for own, chains in zip(systems, self.chains, strict=True)
        )
        wide = size + MEASURED + 1
        filtered = any(any(chains) for chains in self.chains)
        if not size and not filtered:
            return Memory(
                np.zeros((1, 0, wide)), np.zeros((0, MEASURED, wide)), np.zeros((0, wide))
            )
        moved = np.zeros((lengths.size, size, wide))
        seen = np.zeros((lengths.size if filtered else 0, MEASURED, wide))
        told = np.zeros((lengths.size if filtered else 0, wide))
        for k, (own, chains) in enumerate(zip(systems, self.chains, strict=True)):
            mine = np.flatnonzero(which == k)
            one = _with_filters(own, chains, lengths[mine], size)
            moved[mine] = one.moved
            if filtered:
                seen[mine], told[mine] = one.seen, one.told
        return Memory(moved, seen, told)


def shape_of(law: Any) -> tuple[int, ...]:
    """Return the shape of a law, a batch of gains, or an array of laws."""
    if isinstance(law, Law):
        return ()
    return law.batch if isinstance(law, Autopilot) else np.shape(_array(law))


def law_batch(law: Any, shape: tuple[int, ...]) -> LawBatch:
    """Return the laws of a batch of flights of this shape.

    `InputError` for what is no law, and for an autopilot with an actuator or a delay.
    """
    if isinstance(law, Autopilot):
        return _gains(law, shape)
    laws = _array(law)
    different = {id(one): one for one in laws.flat}
    places = {key: k for k, key in enumerate(different)}
    index = np.array([places[id(one)] for one in laws.flat], dtype=np.int64).reshape(laws.shape)
    every = tuple(different.values())
    numbers = [one.numbers for one in every]
    chains = [one.chains for one in every]
    return LawBatch(every, numbers, chains, np.broadcast_to(index, shape).ravel())


def _array(law: Any) -> AnyArray:
    laws = np.asarray(law, dtype=object)
    if not laws.size or laws.ndim > MAX_AXES or not all(isinstance(one, Law) for one in laws.flat):
        raise InputError(
            "law must be a Law such as TrimLaw, an array of them, or an Autopilot with a batch of"
            f" gains; got {type(law).__name__}"
        )
    return laws


def _gains(gains: Autopilot, shape: tuple[int, ...]) -> LawBatch:
    late = gains.actuator is not None or np.any(np.asarray(gains.delay))
    if late or gains.sample_rate is not None:
        raise InputError(
            "an autopilot is flown for its gains and filters only: give actuator, delay and"
            " sample_rate to the flight"
        )
    chains = Chains(gains.attitude_filters, gains.rate_filters, gains.filters)
    if any(one.batch for chain in chains for one in chain):
        raise InputError(
            "an autopilot with a batch of filters is flown as an array of SaturatedLaw, one each"
        )
    fields = (gains.attitude_gain, gains.rate_gain, gains.alpha_gain, gains.integral_gain)
    rows = zip(*(np.broadcast_to(one, gains.batch).ravel().tolist() for one in fields), strict=True)
    numbers: list[LawNumbers | None] = [
        LawNumbers(attitude=a, attitude_rate=r, angle_of_attack=b, first_state=i)
        for a, r, b, i in rows
    ]
    index = np.arange(len(numbers)).reshape(gains.batch)
    return LawBatch((), numbers, [chains], np.broadcast_to(index, shape).ravel())


def _with_filters(own: LinearSystem, chains: Chains, lengths: FloatArray, size: int) -> Memory:
    """The memory of one law in steps of the lengths [s] ``(m,)``, with rows for `size` states.

    Its own states first, then those of each chain.
    """
    blocks = law_blocks(dict(zip(CHAINS, chains, strict=True)), own, SENSED[:2], lengths)
    law = connect(blocks, (*SENSED, LAW_OUTPUT), (*LAW_INPUTS, RETURNED))
    n, wide = len(law.states), size + MEASURED + 1
    columns = [*range(n), *range(size, wide)]
    rows = np.zeros((lengths.size, size + MEASURED + 1, wide))
    rows[:, :n, columns] = beside(law.A, law.B)
    rows[:, size:, columns] = beside(law.C, law.D)
    return Memory(rows[:, :size], rows[:, size:-1], rows[:, -1])


@dataclass(frozen=True, eq=False)
class Hardware:
    """What stands between a law and the deflection.

    `length`, `delay`: of a sample and of computing [s]. `actuator`: one or a batch, which
    broadcasts with them. `rate_limit`: of the deflection [rad/s], of the shape of the flights.
    """

    length: float | FloatArray
    delay: float | FloatArray
    actuator: Actuator | None = None
    rate_limit: float | FloatArray = np.inf

    @property
    def batch(self) -> tuple[int, ...]:
        """The shape of all but the rate limit."""
        own = () if self.actuator is None else self.actuator.batch
        return np.broadcast_shapes(own, np.shape(self.length), np.shape(self.delay))

    def some(
        self, which: IntArray, shape: tuple[int, ...], flights: IntArray, flown: tuple[int, ...]
    ) -> Hardware:
        """Return that of vehicles of a batch of a shape, and of flights of theirs."""
        actuator = self.actuator
        if actuator is not None:
            damping = None if actuator.damping is None else some(actuator.damping, shape, which)
            frequency = some(actuator.natural_frequency, shape, which)
            actuator = Actuator(natural_frequency=frequency, damping=damping)
        length, delay = (some(a, shape, which) for a in (self.length, self.delay))
        return Hardware(length, delay, actuator, some(self.rate_limit, flown, flights))


@dataclass(frozen=True, eq=False)
class Batch:
    """What is flown: all of one shape, which is flattened, but for plants, hardware and winds.

    `plant`, `hardware`, `wind`: one each or a batch, which broadcast with the shape; or as
    `vehicle` and `met` say. `laws`: of the flights. `limit`: of the deflection [rad], of the shape
    of the batch. `shape`: of the batch. `gain`: factor on what each asks for, of the same shape.
    `until`: when flights end [s]; infinite for when they are decided. `vehicle`, `met`: the vehicle
    (plant with hardware) and the wind of each flight, by their places in their own batches,
    ``(m,)``.
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
    met: IntArray | None = None

    @property
    def vehicles(self) -> tuple[int, ...]:
        """The shape of the batch of vehicles."""
        return np.broadcast_shapes(self.plant.batch, self.hardware.batch)

    @property
    def places(self) -> tuple[IntArray, IntArray]:
        """The vehicle and the wind of each flight, ``(m,)``."""
        vehicle, met = self.vehicle, self.met
        if vehicle is None or met is None:
            vehicle, met = (places_in(a, self.shape) for a in (self.vehicles, self.wind.batch))
        return vehicle, met

    def delayed(self, delay: float | FloatArray) -> Batch:
        """Return the same with another delay of computing [s]."""
        return replace(self, hardware=replace(self.hardware, delay=delay))

    def only(self, good: BoolArray) -> Batch:
        """Return those flights of the batch, each vehicle and wind that they need once."""
        own, where = self.vehicles, np.flatnonzero(good)
        (fleet, vehicle), (winds, met) = (
            np.unique(a[where], return_inverse=True) for a in self.places
        )
        return replace(
            self,
            plant=self.plant.cases(fleet, own),
            hardware=self.hardware.some(fleet, own, where, self.shape),
            wind=self.wind.cases(winds, self.wind.batch),
            laws=replace(self.laws, which=self.laws.which[where]),
            limit=some(self.limit, self.shape, where),
            shape=where.shape,
            gain=some(self.gain, self.shape, where),
            vehicle=vehicle,
            met=met,
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
    """Return the batch of a single flight; the arguments are those of `Batch`."""
    return Batch(plant, hardware, wind, law_batch(law, ()), limit, (), gain, until)


def some(array: float | FloatArray, shape: tuple[int, ...], which: IntArray) -> FloatArray:
    """Return those elements of an array that broadcasts to a shape, flat."""
    return np.asarray(np.broadcast_to(array, shape).ravel()[which])


def places_in(own: tuple[int, ...], shape: tuple[int, ...]) -> IntArray:
    """Return the position of each element of a batch in a smaller one that broadcasts to it."""
    index = np.arange(int(np.prod(own)), dtype=np.int64).reshape(own)
    return np.broadcast_to(index, shape).flatten()


_LONGEST = 1_000_000
"""Samples after its wind in which a flight may be decided; then it stays undecided."""
_AT_ONCE = 1e100
"""Bandwidth [1/s] of no nozzle at all."""


def flights(batch: Batch, *, track: bool = False) -> Flights:
    """Return the flights of a batch at their start, at rest; of one alone with its track.

    All arrays can be written to: the kernel is compiled anew for those that can not.
    """
    own, (vehicle, met) = batch.vehicles, batch.places
    knots, pieces = (np.ascontiguousarray(one) for one in polynomial_pieces(batch.wind))
    terms = pieces.shape[2]
    steps = _steps(batch, own, terms)
    judges, place = outcome_criteria(batch.plant), places_in(batch.plant.batch, own)
    cases, noise = _cases(batch, judges, place)
    h = steps.lengths[vehicle, 0]
    memory = batch.laws.memory(h)
    N = steps.joint.shape[2]
    plant = batch.plant.system.cases(np.arange(int(np.prod(own))), own)
    now = _at_rest(vehicle.size, len(plant.states), steps, terms, memory.moved.shape[1])
    now.piece[:] = (knots[met] <= cases.start[:, np.newaxis]).sum(axis=1) - 1
    rows = int(steps.substeps.sum() * cases.finish.max()) if track else 0
    return Flights(
        steps=steps,
        vehicles=Vehicles(
            shown=sensed_rows(plant),
            A=plant.A,
            gust=np.ascontiguousarray(plant.B[..., 1]),
            fastest=np.abs(plant.poles).max(axis=-1),
            judges=_widened(judges.rows[place], N),
            reach=judges.reach[place],
            ratio=judges.ratio[place],
        ),
        winds=Winds(knots, pieces),
        laws=Laws([one or LawNumbers() for one in batch.laws.numbers], *memory, noise),
        cases=cases,
        now=now,
        track=np.full((rows, N + 4), np.nan),
    )


def _steps(batch: Batch, own: tuple[int, ...], terms: int) -> Steps:
    """The steps of vehicles in winds of so many terms.

    They are of a whole sample, and of its parts before and after a late command.
    """
    hardware, every = batch.hardware, np.arange(int(np.prod(own)))
    plant = batch.plant.system.cases(every, own)
    length, delay = (_spread(a, own) for a in (hardware.length, hardware.delay))
    late, rest = split_delay(delay, length)
    parts = [length - rest, rest] if np.any(rest) else [length]
    lengths = np.stack([length, *parts], axis=-1)
    pace = np.minimum(_spread(quickness(hardware.actuator), own), _AT_ONCE)[:, np.newaxis]
    substeps = substeps_of(_spread(frequency(hardware.actuator), own), lengths)
    short = lengths[:, 1:] / substeps
    moving = plant_with_actuator(batch.plant, hardware.actuator).cases(every, own)
    n = len(plant.states)
    joint = joint_steps(moving, n, lengths[:, 1:], terms)
    return Steps(
        joint=joint,
        fine=joint_steps(moving, n, short, terms) if np.any(substeps > 1) else joint,
        substeps=substeps,
        ramp=even_steps(plant, short),
        lengths=lengths,
        short=short,
        quick=np.where(short > 0.0, pace * short, 0.0),
        late=late.astype(np.int64),
    )


def _cases(batch: Batch, judges: OutcomeCriteria, place: IntArray) -> tuple[Cases, FloatArray]:
    """What each flight has, and the rows of noise; judges stand at a place for each vehicle."""
    shape, (vehicle, met) = batch.shape, batch.places
    h = _spread(batch.hardware.length, batch.vehicles)[vehicle]
    start, end = (a.ravel()[met] for a in (batch.wind.onset, batch.wind.end))
    known = ~np.isnan(judges.reach[place][vehicle])
    waiting, settling = (
        np.ceil(np.where(known, a[place][vehicle], 0.0) / h)
        for a in (judges.waiting, judges.settling)
    )
    waiting = -(-np.minimum(waiting, _LONGEST) // kernel.JUDGED_SAMPLES) * kernel.JUDGED_SAMPLES
    finish, ends = (_samples(a - start, h) for a in (np.full(h.shape, batch.until), end))
    noise, sequence = _noise(batch.laws, np.where(finish < NEVER, finish, ends + waiting))
    cases = Cases(
        vehicle=vehicle,
        wind=met,
        law=batch.laws.which.copy(),
        sequence=sequence,
        gain=_spread(batch.gain, shape),
        limit=_spread(batch.limit, shape),
        rate_limit=_spread(batch.hardware.rate_limit, shape),
        start=start.copy(),
        finish=finish,
        ends=ends,
        waiting=waiting.astype(np.int64),
        settling=settling.astype(np.int64),
    )
    return cases, noise


def _at_rest(m: int, n: int, steps: Steps, terms: int, memory: int) -> FlightStates:
    """The state of m flights of n states, in winds of so many terms, of laws that remember."""
    N, late = steps.joint.shape[2], int(steps.late.max(initial=0))
    return FlightStates(
        y=np.zeros((m, N)),
        states=np.zeros((m, memory)),
        here=np.zeros((m, terms)),
        sensed=np.zeros((m, MEASURED + 1)),
        measured=np.zeros((m, MEASURED)),
        next=np.zeros((m, max(N, memory))),
        series=np.zeros((m, 3, n)),
        commands=np.zeros((m, late + steps.joint.shape[1])),
        mode=np.zeros(m),
        bounded=np.zeros(m, np.bool_),
        peaks=np.zeros((m, PEAKS)),
        piece=np.zeros(m, np.int64),
        settled=np.zeros(m, np.int64),
        outcome=np.zeros(m, np.int64),
        ended=np.full(m, -1, np.int64),
    )


def _widened(rows: FloatArray, width: int) -> FloatArray:
    """Rows of states, with zeros for those that follow, and without what is no state here."""
    wide = np.zeros((*rows.shape[:-1], width))
    some = min(width, rows.shape[-1])
    wide[..., :some] = rows[..., :some]
    return wide


def _spread(array: float | FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """An array that broadcasts to a shape, spread to it, flat, and free to be written to."""
    return np.array(np.broadcast_to(array, shape), float).ravel()


def _samples(span: FloatArray, length: FloatArray) -> IntArray:
    known = np.isfinite(span)
    counted = np.ceil(np.where(known, span, 0.0) / length - 1e-9)
    return np.where(known, np.maximum(counted, 1), NEVER).astype(np.int64)


def _noise(laws: LawBatch, samples: FloatArray) -> tuple[FloatArray, IntArray]:
    """A row of noise for each level and seed, and the row of each flight."""
    every = list(dict.fromkeys(laws.noise))
    sequence = np.array([every.index(one) for one in laws.noise], dtype=np.int64)[laws.which]
    if not any(level for level, _ in every):
        return np.zeros((1, 0)), sequence
    count = int(samples.max()) + 2 * kernel.JUDGED_SAMPLES
    rows = [
        np.random.default_rng([seed, 0]).normal(0.0, level, count) if level else np.zeros(count)
        for level, seed in every
    ]
    return np.stack(rows), sequence
