"""Flights of laws that are computed at a sample rate: their numbers for the kernel, and its answer.

Between samples the deflection moves as the nozzle does. All of a step is linear and exact while the
nozzle meets no limit; in a step in which its rate or its stop bounds it the deflection goes evenly
from where it begins to where it ends.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law, Measurement
from tvclin.flights.closed_loop.gusts import polynomial_pieces
from tvclin.flights.closed_loop.law_batch import LawBatch, law_batch
from tvclin.flights.closed_loop.outcomes import judging
from tvclin.kernels import flights as kernel
from tvclin.kernels.choice import swiftest
from tvclin.kernels.control_laws import LawNumbers
from tvclin.kernels.flights import NEVER, PEAKS, Flights
from tvclin.kernels.propagation import exponentials
from tvclin.kernels.threads import in_slices
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_LONGEST = 1_000_000
"""Samples after its wind in which a flight may be decided; then it stays undecided."""
_WHOLE = 1e-9
"""A delay is a whole number of samples within this."""
_AT_ONCE = 1e100
"""Bandwidth [1/s] of no nozzle at all."""
_PLAIN, _COMPILED = 3e-5, 5e-8
"""Seconds for a sample of one flight, in plain Python and compiled, or so."""
_TYPES = {float: np.float64, bool: np.bool_}


@dataclass(frozen=True, eq=False)
class Batch:
    """What is flown: all of one shape, which is flattened, but for the plants.

    Attributes
    ----------
    plant, wind : Plant, History
        One each or a batch.
    laws : LawBatch
        Of the flights.
    gain : ndarray
        Factor on what each asks for, of the shape of the batch.
    limit, rate_limit : ndarray
        Of the deflection, of the shape of the batch.
    actuator : Actuator or None
        One or a batch.
    length, delay : ndarray
        Of a sample and of computing [s]; they broadcast with the batch.
    until : float
        When flights end [s]; infinite for when they are decided.
    shape : tuple of int
        Of the batch.
    """

    plant: Plant
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

    def repeated(self, times: int) -> Batch:
        """Return the same flight many times, of one alone."""
        laws = replace(self.laws, which=np.repeat(self.laws.which, times))
        return replace(
            self,
            laws=laws,
            gain=np.repeat(self.gain, times),
            limit=np.repeat(self.limit, times),
            rate_limit=np.repeat(self.rate_limit, times),
            shape=(times,),
        )


def one_flight(
    plant: Plant,
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
    """Return the flights of a batch at their start, at rest; of one alone with its track."""
    shape, m = batch.shape, int(np.prod(batch.shape))
    hardware = () if batch.actuator is None else batch.actuator.batch
    own = np.broadcast_shapes(batch.plant.batch, hardware, batch.length.shape, batch.delay.shape)
    vehicle = _places(own, shape)
    A, inputs, C, D = batch.plant.matrices()
    n = A.shape[-1]
    A, inputs, C, D = (_spread(a, own, 2) for a in (A, inputs, C, D))
    knots, pieces = polynomial_pieces(batch.wind)
    wind = _places(batch.wind.batch, shape)
    length, delay = (_spread(a, own, 0) for a in (batch.length, batch.delay))
    late, lengths = _parts(length, delay)
    servo = _servo(batch.actuator, own)
    pace = np.minimum(_quickness(servo, len(A)), _AT_ONCE)[:, np.newaxis]
    joint, ramp = _steps(A, inputs, servo, lengths[:, 1:], pieces.shape[2])
    judges = judging(batch.plant)
    place = _places(batch.plant.batch, own)
    start, end = (np.broadcast_to(a, shape).ravel() for a in (batch.wind.onset, batch.wind.end))
    h = length[vehicle]
    known = ~np.isnan(judges.reach[place][vehicle])
    waiting, settling = (
        np.ceil(np.where(known, a[place][vehicle], 0.0) / h)
        for a in (judges.waiting, judges.settling)
    )
    waiting = -(-np.minimum(waiting, _LONGEST) // kernel.LOOK) * kernel.LOOK
    finish, ends = (_samples(a - start, h) for a in (np.full(m, batch.until), end))
    kept, learnt = batch.laws.steps(h)
    noise, sequence = _noise(batch.laws, np.where(finish < NEVER, finish, ends + waiting))
    N, states, terms = joint.shape[2], kept.shape[1], pieces.shape[2]
    rows = joint.shape[1] * int(finish.max()) if track else 0
    return Flights(
        vehicle=vehicle,
        wind=wind,
        law=np.ascontiguousarray(batch.laws.which),
        joint=joint,
        ramp=ramp,
        lengths=lengths,
        quick=np.where(lengths[:, 1:] > 0.0, pace * lengths[:, 1:], 0.0),
        late=late,
        shown=_shown(batch.plant, C, D),
        A=A,
        gust=np.ascontiguousarray(inputs[..., 1]),
        judges=np.ascontiguousarray(judges.rows[place]),
        reach=judges.reach[place],
        ratio=judges.ratio[place],
        knots=knots,
        pieces=pieces,
        laws=[one or LawNumbers() for one in batch.laws.numbers],
        own=kept,
        driven=learnt,
        gain=_flat(batch.gain, shape),
        limit=_flat(batch.limit, shape),
        rate_limit=_flat(batch.rate_limit, shape),
        start=start.copy(),
        finish=finish,
        ends=ends,
        waiting=waiting.astype(np.int64),
        settling=settling.astype(np.int64),
        noise=noise,
        sequence=sequence,
        y=np.zeros((m, N)),
        states=np.zeros((m, states)),
        measured=np.zeros((m, 5)),
        here=np.zeros((m, terms)),
        next=np.zeros((m, max(N, states))),
        series=np.zeros((m, n)),
        commands=np.zeros((m, int(late.max(initial=0)) + joint.shape[1])),
        mode=np.zeros(m),
        peaks=np.zeros((m, PEAKS)),
        piece=(knots[wind] <= start[:, np.newaxis]).sum(axis=1) - 1,
        settled=np.zeros(m, np.int64),
        outcome=np.zeros(m, np.int64),
        ended=np.full(m, -1, np.int64),
        track=np.zeros((rows, N + 3)),
    )


def flown(batch: Batch, *, track: bool = False) -> Flights:
    """Return the flights of a batch at their ends; of one alone with its track if asked for."""
    f, laws = flights(batch, track=track), batch.laws
    if any(one is None for one in laws.numbers):
        _in_python(f, laws)
        return f
    cases = f.limit.size
    last = np.where(f.finish < NEVER, f.finish, f.ends + f.settling)
    samples, first = float(last.sum()), 0
    seconds = samples * _PLAIN
    with np.errstate(all="ignore"):  # a lost flight may leave all numbers
        while first < cases and (fly := swiftest(kernel.fly, seconds)) is kernel.fly:
            begun = perf_counter()  # one that stays open takes longer than was thought
            fly(f, first, first + 1)
            seconds, first = perf_counter() - begun, first + 1
    if first < cases:
        compact = f._replace(laws=_table(f.laws))
        work = samples * _COMPILED
        in_slices(lambda a, b: fly(compact, first + a, first + b), cases - first, work)
    return f


def _in_python(f: Flights, laws: LawBatch) -> None:
    """Fly laws that Python must be asked for, all flights of a law at once."""
    whole = float(np.where(f.finish < NEVER, f.finish, f.ends + f.settling).sum())
    look, advance = (swiftest(one, whole * _PLAIN / 2.0) for one in (kernel.look, kernel.advance))
    compact = f if look is kernel.look else f._replace(laws=_table(f.laws))
    k = 0
    while advanced(compact, laws, k, look, advance):
        k += 1


def advanced(
    f: Flights,
    laws: LawBatch,
    k: int,
    look: Callable[..., int] = kernel.look,
    advance: Callable[..., None] = kernel.advance,
) -> bool:
    """Move all flights that go on by a sample, whatever their laws; return whether any did."""
    with np.errstate(all="ignore"):  # a lost flight may leave all numbers
        if not look(f, k):
            return False
        going, demand = f.ended < 0, np.zeros(f.limit.size)
        for place, law in enumerate(laws.laws):
            mine = np.flatnonzero(going & (f.law == place))
            if mine.size:
                demand[mine] = _asked(law, f, mine)
        engage, release = (
            np.array([getattr(law, name) for law in laws.laws], float)[f.law]
            for name in ("engage", "release")
        )
        advance(f, k, demand, engage, release)
    return True


def _asked(law: Any, f: Flights, mine: IntArray) -> FloatArray:
    """What a law asks for; one flight is told in plain numbers, which take half the time."""
    own = len(law.states[0])
    if mine.size > 1:
        measured = Measurement(*f.measured[mine].T)
        return np.asarray(law.demand(measured, f.states[mine, :own].T, f.limit[mine]), dtype=float)
    i = int(mine[0])
    asked = law.demand(Measurement(*f.measured[i].tolist()), f.states[i, :own], float(f.limit[i]))
    return np.asarray(asked, dtype=float)


def _table(laws: list[LawNumbers]) -> NDArray[Any]:
    """The laws as an array with their fields, for machine code."""
    kinds = [(name, _TYPES[type(value)]) for name, value in LawNumbers()._asdict().items()]
    return np.array([tuple(one) for one in laws], dtype=kinds)


def _places(own: tuple[int, ...], shape: tuple[int, ...]) -> IntArray:
    """The position of each element of a batch in a smaller one that broadcasts to it."""
    index = np.arange(int(np.prod(own)), dtype=np.int64).reshape(own)
    return np.broadcast_to(index, shape).ravel()


def _flat(array: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    return np.broadcast_to(array, shape).astype(float).ravel()


def _spread(array: FloatArray, shape: tuple[int, ...], trailing: int) -> FloatArray:
    """An array whose leading axes are a batch, spread to a shape and flattened."""
    rest = array.shape[array.ndim - trailing :]
    spread = np.broadcast_to(array, (*shape, *rest)).reshape(-1, *rest)
    return np.ascontiguousarray(spread, dtype=float)


def _samples(span: FloatArray, length: FloatArray) -> IntArray:
    known = np.isfinite(span)
    counted = np.ceil(np.where(known, span, 0.0) / length - 1e-9)
    return np.where(known, np.maximum(counted, 1), NEVER).astype(np.int64)


def _parts(length: FloatArray, delay: FloatArray) -> tuple[IntArray, FloatArray]:
    """Whole samples of delay, and the lengths [s] of a step and its parts, the later first."""
    samples = delay / length
    late = np.floor(samples + _WHOLE)
    rest = np.where(samples - late > _WHOLE, samples - late, 0.0) * length
    parts = [length - rest, rest] if np.any(rest) else [length]
    return late.astype(np.int64), np.stack([length, *parts], axis=-1)


def _servo(actuator: Actuator | None, shape: tuple[int, ...]) -> FloatArray | None:
    """The nozzle's s' = F s + g c as [F, g], ``(p, q, q + 1)``."""
    if actuator is None:
        return None
    terms = actuator.denominator
    q = terms.shape[-1] - 1
    rows = np.zeros((*terms.shape[:-1], q, q + 1))
    rows[..., :, :q] = np.eye(q, k=1)
    rows[..., -1, :q], rows[..., -1, q] = -terms[..., :0:-1], terms[..., -1]
    return _spread(rows, shape, 2)


def _quickness(servo: FloatArray | None, vehicles: int) -> FloatArray:
    """The bandwidth of a nozzle of first order [1/s], infinite without one, else zero."""
    if servo is None:
        return np.full(vehicles, np.inf)
    return servo[:, 0, -1] if servo.shape[1] == 1 else np.zeros(vehicles)


def _steps(
    A: FloatArray, inputs: FloatArray, servo: FloatArray | None, parts: FloatArray, terms: int
) -> tuple[FloatArray, FloatArray]:
    """J and ramp of `Flights`.

    d/dt [x, s, c, w0, w1, ...] is constant in these, the wind being w0' = w1, w1' = 2 w2, ...;
    and so is that of x with a deflection that goes evenly.
    """
    p, n = A.shape[:2]
    q = 1 if servo is None else servo.shape[1]
    N, wind = n + q, n + q + 1
    whole = np.zeros((p, wind + terms, wind + terms))
    whole[:, :n, :n], whole[:, :n, wind] = A, inputs[..., 1]
    whole[:, :n, N if servo is None else n] = inputs[..., 0]
    if servo is not None:
        whole[:, n:N, n : N + 1] = servo
    for k in range(1, terms):
        whole[:, wind + k - 1, wind + k] = k
    even = np.zeros((p, n + 2, n + 2))
    even[:, :n, :n], even[:, :n, n] = A, inputs[..., 0]
    joint, ramp = [], []
    for part in parts.T:
        J = exponentials(whole, part)[:, :N]
        if servo is None:  # the deflection is at its command at once
            J[:, n], J[:, n, N] = 0.0, 1.0
        joint.append(J)
        gone = exponentials(even + _slope(n, part), part)
        rise = gone[:, :n, n + 1]
        ramp.append(np.stack([gone[:, :n, n] - rise, rise], axis=-1))
    return np.stack(joint, axis=1), np.stack(ramp, axis=1)


def _slope(n: int, part: FloatArray) -> FloatArray:
    """The entry that makes a deflection go by one in a part."""
    slope = np.zeros((part.size, n + 2, n + 2))
    slope[:, n, n + 1] = 1.0 / np.where(part > 0.0, part, 1.0)
    return slope


def _shown(plant: Plant, C: FloatArray, D: FloatArray) -> FloatArray:
    """Attitude, rate, path and angle of attack, of the states and of the wind."""
    n = C.shape[-1]
    rows = np.zeros((len(C), 4, n + 1))
    rows[:, :3, :n] = np.eye(3, n)
    angle = plant.outputs.index("angle_of_attack")
    rows[:, 3, :n], rows[:, 3, n] = C[:, angle], D[:, angle, 1]
    return rows


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
