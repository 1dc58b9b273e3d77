"""Flights of laws that are computed at a sample rate: their numbers for the kernel, and its answer.

Between samples the deflection moves as the nozzle does. All of a step is linear and exact while the
nozzle meets no limit. Where it meets one, and samples are far apart for it, the step is walked in
substeps; in one in which its rate or its stop bounds it the deflection goes evenly from where it
begins to where it ends.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import BoolArray, FloatArray, IntArray
from tvclin.control.autopilot.actuated import actuated
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law, Measurement
from tvclin.flights.closed_loop.gusts import polynomial_pieces
from tvclin.flights.closed_loop.law_batch import LawBatch, law_batch
from tvclin.flights.closed_loop.outcomes import judging
from tvclin.flights.closed_loop.step_matrices import (
    even_steps,
    frequency,
    joint_steps,
    quickness,
    sensed_rows,
    substeps_of,
)
from tvclin.kernels import choice
from tvclin.kernels import flights as kernel
from tvclin.kernels.control_laws import LawNumbers
from tvclin.kernels.flight_arrays import (
    MEASURED,
    NEVER,
    PEAKS,
    Cases,
    Flights,
    Laws,
    Now,
    Steps,
    Vehicles,
    Winds,
)
from tvclin.kernels.threads import in_slices
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.system import delay_parts
from tvclin.winds.histories import History

_LONGEST = 1_000_000
"""Samples after its wind in which a flight may be decided; then it stays undecided."""
_AT_ONCE = 1e100
"""Bandwidth [1/s] of no nozzle at all."""
_PLAIN, _COMPILED = 3e-5, 5e-8
"""Seconds for a sample of one flight, in plain Python and compiled, or so."""
_TYPES = {float: np.float64, bool: np.bool_}


@dataclass(frozen=True, eq=False)
class Batch:
    """What is flown: all of one shape, which is flattened, but for plants and winds.

    `plant`, `wind`: one each or a batch, which broadcast with the shape; or as `vehicle` and `met`
    say. `laws`: of the flights. `gain`: factor on what each asks for, of the shape of the batch.
    `limit`, `rate_limit`: of the deflection, of the shape of the batch. `actuator`: one or a batch.
    `length`, `delay`: of a sample and of computing [s]; they broadcast with the plants. `until`:
    when flights end [s]; infinite for when they are decided. `vehicle`, `met`: the vehicle (plant
    with actuator, samples and delay) and the wind of each flight, by their places in their own
    batches, ``(m,)``.
    """

    plant: AnyPlant
    wind: History
    laws: LawBatch
    gain: FloatArray
    limit: FloatArray
    rate_limit: FloatArray
    actuator: Actuator | None
    length: FloatArray
    delay: FloatArray
    until: float
    shape: tuple[int, ...]
    vehicle: IntArray | None = None
    met: IntArray | None = None

    @property
    def vehicles(self) -> tuple[int, ...]:
        """The shape of the batch of vehicles."""
        hardware = () if self.actuator is None else self.actuator.batch
        return np.broadcast_shapes(self.plant.batch, hardware, self.length.shape, self.delay.shape)

    @property
    def places(self) -> tuple[IntArray, IntArray]:
        """The vehicle and the wind of each flight, ``(m,)``."""
        vehicle, met = self.vehicle, self.met
        if vehicle is None or met is None:
            vehicle, met = (_places(a, self.shape) for a in (self.vehicles, self.wind.batch))
        return vehicle, met

    def only(self, good: BoolArray) -> Batch:
        """Return those flights of the batch, each vehicle and wind that they need once."""
        own, where = self.vehicles, np.flatnonzero(good)
        (fleet, vehicle), (winds, met) = (
            np.unique(a[where], return_inverse=True) for a in self.places
        )

        def some(array: ArrayLike, shape: tuple[int, ...], which: IntArray) -> FloatArray:
            return np.broadcast_to(array, shape).ravel()[which]

        gain, limit, rate_limit = (
            some(a, self.shape, where) for a in (self.gain, self.limit, self.rate_limit)
        )
        actuator = self.actuator
        if actuator is not None:
            damping = None if actuator.damping is None else some(actuator.damping, own, fleet)
            frequency = some(actuator.natural_frequency, own, fleet)
            actuator = Actuator(natural_frequency=frequency, damping=damping)
        return replace(
            self,
            plant=self.plant.some(fleet, own),
            wind=self.wind.some(winds, self.wind.batch),
            laws=replace(self.laws, which=self.laws.which[where]),
            gain=gain,
            limit=limit,
            rate_limit=rate_limit,
            actuator=actuator,
            length=some(self.length, own, fleet),
            delay=some(self.delay, own, fleet),
            shape=where.shape,
            vehicle=vehicle,
            met=met,
        )


def one_flight(
    plant: AnyPlant,
    law: Law,
    wind: History,
    limit: float,
    rate_limit: float,
    actuator: Actuator | None,
    length: float,
    delay: float,
    gain: float = 1.0,
    until: float = np.inf,
) -> Batch:
    """Return the batch of a single flight; the arguments are those of `Batch`."""
    factor, most, quickest, step, late = map(np.asarray, (gain, limit, rate_limit, length, delay))
    laws = law_batch(law, ())
    return Batch(plant, wind, laws, factor, most, quickest, actuator, step, late, until, ())


def flights(batch: Batch, *, track: bool = False) -> Flights:
    """Return the flights of a batch at their start, at rest; of one alone with its track.

    All arrays can be written to: the kernel is compiled anew for those that can not.
    """
    shape, m = batch.shape, int(np.prod(batch.shape))
    own, (vehicle, wind) = batch.vehicles, batch.places
    every = np.arange(int(np.prod(own)))
    plant = batch.plant.system.some(every, own)
    n = len(plant.states)
    knots, pieces = (np.ascontiguousarray(one) for one in polynomial_pieces(batch.wind))
    length, delay = (_spread(a, own, 0) for a in (batch.length, batch.delay))
    late, rest = delay_parts(delay, length)
    parts = [length - rest, rest] if np.any(rest) else [length]
    lengths = np.stack([length, *parts], axis=-1)
    pace = np.minimum(_spread(quickness(batch.actuator), own, 0), _AT_ONCE)[:, np.newaxis]
    substeps = substeps_of(_spread(frequency(batch.actuator), own, 0), lengths)
    short = lengths[:, 1:] / substeps
    moving, terms = actuated(batch.plant, batch.actuator).some(every, own), pieces.shape[2]
    joint = joint_steps(moving, n, lengths[:, 1:], terms)
    fine = joint_steps(moving, n, short, terms) if np.any(substeps > 1) else joint
    judges = judging(batch.plant)
    place = _places(batch.plant.batch, own)
    start, end = (a.ravel()[wind] for a in (batch.wind.onset, batch.wind.end))
    h = length[vehicle]
    known = ~np.isnan(judges.reach[place][vehicle])
    waiting, settling = (
        np.ceil(np.where(known, a[place][vehicle], 0.0) / h)
        for a in (judges.waiting, judges.settling)
    )
    waiting = -(-np.minimum(waiting, _LONGEST) // kernel.LOOK) * kernel.LOOK
    finish, ends = (_samples(a - start, h) for a in (np.full(m, batch.until), end))
    memory = batch.laws.memory(h)
    noise, sequence = _noise(batch.laws, np.where(finish < NEVER, finish, ends + waiting))
    N, states = joint.shape[2], memory.moved.shape[1]
    rows = int(substeps.sum() * finish.max()) if track else 0
    return Flights(
        steps=Steps(
            joint=joint,
            fine=fine,
            substeps=substeps,
            ramp=even_steps(plant, short),
            lengths=lengths,
            short=short,
            quick=np.where(short > 0.0, pace * short, 0.0),
            late=late.astype(np.int64),
        ),
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
        cases=Cases(
            vehicle=vehicle,
            wind=wind,
            law=batch.laws.which.copy(),
            sequence=sequence,
            gain=_flat(batch.gain, shape),
            limit=_flat(batch.limit, shape),
            rate_limit=_flat(batch.rate_limit, shape),
            start=start.copy(),
            finish=finish,
            ends=ends,
            waiting=waiting.astype(np.int64),
            settling=settling.astype(np.int64),
        ),
        now=Now(
            y=np.zeros((m, N)),
            states=np.zeros((m, states)),
            here=np.zeros((m, terms)),
            sensed=np.zeros((m, MEASURED + 1)),
            measured=np.zeros((m, MEASURED)),
            next=np.zeros((m, max(N, states))),
            series=np.zeros((m, 3, n)),
            commands=np.zeros((m, int(late.max(initial=0)) + joint.shape[1])),
            mode=np.zeros(m),
            bounded=np.zeros(m, np.bool_),
            peaks=np.zeros((m, PEAKS)),
            piece=(knots[wind] <= start[:, np.newaxis]).sum(axis=1) - 1,
            settled=np.zeros(m, np.int64),
            outcome=np.zeros(m, np.int64),
            ended=np.full(m, -1, np.int64),
        ),
        track=np.full((rows, N + 4), np.nan),
    )


def flown(batch: Batch, *, track: bool = False) -> Flights:
    """Return the flights of a batch at their ends; of one alone with its track if asked for."""
    f = flights(batch, track=track)
    finish(f, batch.laws)
    return f


def finish(f: Flights, laws: LawBatch) -> None:
    """Fly flights of such laws to their ends."""
    if any(one is None for one in laws.numbers):
        _in_python(f, laws)
        return
    cases = f.cases.limit.size
    samples, first = float(_last(f).sum()), 0
    seconds = samples * _PLAIN
    with np.errstate(all="ignore"):  # a lost flight may leave all numbers
        while first < cases and (fly := choice.swiftest(kernel.fly, seconds)) is kernel.fly:
            begun = perf_counter()  # one that stays open takes longer than was thought
            fly(f, first, first + 1)
            seconds, first = perf_counter() - begun, first + 1
    if first < cases:
        compact = _compact(f)
        work = samples * _COMPILED
        in_slices(lambda a, b: fly(compact, first + a, first + b), cases - first, work)


def _in_python(f: Flights, laws: LawBatch) -> None:
    """Fly laws that Python must be asked for, all flights of a law at once."""
    stepper, k = Stepper(f), 0
    engage, release = (
        np.array([getattr(law, name) for law in laws.laws], float)[f.cases.law]
        for name in ("engage", "release")
    )
    with np.errstate(all="ignore"):  # a lost flight may leave all numbers
        while stepper.look(k):
            going, demand = f.now.ended < 0, np.zeros(f.cases.limit.size)
            for place, law in enumerate(laws.laws):
                mine = np.flatnonzero(going & (f.cases.law == place))
                if mine.size:
                    demand[mine] = _asked(law, f, mine)
            stepper.advance(k, demand, engage, release)
            k += 1


class Stepper:
    """Flights that are moved by what stands beside them, a sample at a time."""

    def __init__(self, f: Flights) -> None:
        seconds = float(_last(f).sum()) * _PLAIN / 2.0
        looks, moves = (choice.swiftest(one, seconds) for one in (kernel.look, kernel.advance))
        self._look, self._advance = looks, moves
        self._flights = f if looks is kernel.look else _compact(f)

    def look(self, k: int) -> int:
        """Look at all flights at a sample; return how many go on."""
        return self._look(self._flights, k)

    def advance(self, k: int, demand: FloatArray, engage: FloatArray, release: FloatArray) -> None:
        """Move all that go on by a sample, with what is asked of them [rad], each ``(m,)``."""
        self._advance(self._flights, k, demand, engage, release)


def _last(f: Flights) -> IntArray:
    """The samples that flights take at the least."""
    return np.where(f.cases.finish < NEVER, f.cases.finish, f.cases.ends + f.cases.settling)


def _asked(law: Any, f: Flights, mine: IntArray) -> FloatArray:
    """What a law asks for; one flight is told in plain numbers, which take half the time."""
    own = len(law.states[0])
    states, limit = f.now.states[mine, :own], f.cases.limit[mine]
    if mine.size > 1:
        asked = law.demand(Measurement(*f.now.measured[mine].T), states.T, limit)
    else:
        measured = Measurement(*f.now.measured[mine[0]].tolist())
        asked = law.demand(measured, states[0], float(limit[0]))
    return np.asarray(asked, dtype=float)


def _compact(f: Flights) -> Flights:
    """Flights whose laws are an array with their fields, for machine code."""
    kinds = [(name, _TYPES[type(value)]) for name, value in LawNumbers()._asdict().items()]
    numbers = np.array([tuple(one) for one in f.laws.numbers], dtype=kinds)
    return f._replace(laws=f.laws._replace(numbers=numbers))


def _places(own: tuple[int, ...], shape: tuple[int, ...]) -> IntArray:
    """The position of each element of a batch in a smaller one that broadcasts to it."""
    index = np.arange(int(np.prod(own)), dtype=np.int64).reshape(own)
    return np.broadcast_to(index, shape).flatten()


def _widened(rows: FloatArray, width: int) -> FloatArray:
    """Rows of states, with zeros for those that follow, and without what is no state here."""
    wide = np.zeros((*rows.shape[:-1], width))
    some = min(width, rows.shape[-1])
    wide[..., :some] = rows[..., :some]
    return wide


def _flat(array: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    return np.broadcast_to(array, shape).astype(float).ravel()


def _spread(array: FloatArray, shape: tuple[int, ...], trailing: int) -> FloatArray:
    """An array whose leading axes are a batch, spread to a shape and flattened."""
    rest = array.shape[array.ndim - trailing :]
    return np.array(np.broadcast_to(array, (*shape, *rest)).reshape(-1, *rest), float, order="C")


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
    count = int(samples.max()) + 2 * kernel.LOOK
    rows = [
        np.random.default_rng([seed, 0]).normal(0.0, level, count) if level else np.zeros(count)
        for level, seed in every
    ]
    return np.stack(rows), sequence
