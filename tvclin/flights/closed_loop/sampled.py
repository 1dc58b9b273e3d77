"""Flights of sampled laws: the run of the kernel, and the history of one flight at any time.

A step is linear and exact while the nozzle reaches no limit. If it reaches one, and samples are far
apart for it, the step is divided into substeps; in a substep bounded by the rate or deflection
limit the deflection is a straight line from its start to its end. `tracked` evaluates one flight
at any time from the start of the substep that contains it.
"""

from __future__ import annotations

from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray, IntArray
from tvclin.control.autopilot.actuator import INPUTS, Actuator, plant_with_actuator
from tvclin.control.laws.law import Measurement
from tvclin.flights.closed_loop.batch import Batch, LawBatch, flights
from tvclin.flights.closed_loop.checks import LOST, check_not_lost
from tvclin.kernels import choice
from tvclin.kernels import flights as kernel
from tvclin.kernels.control_laws import LawNumbers
from tvclin.kernels.flight_arrays import NEVER, Flights
from tvclin.kernels.threads import in_slices
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.plant import INPUTS as VEHICLE_INPUTS
from tvclin.linear.system import LinearSystem, connect, polynomial_input
from tvclin.numerics.propagation import input_states, matrix_exponentials, piece_matrix
from tvclin.winds.histories import History

_TYPES = {float: np.float64, bool: np.bool_}


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
    seconds = samples * kernel.PLAIN
    with np.errstate(all="ignore"):  # a lost flight may leave all numbers
        fly = choice.swiftest(kernel.fly, seconds)
        while first < cases and fly is kernel.fly:
            begun = perf_counter()  # one that stays open takes longer than was thought
            fly(f, first, first + 1)
            fly, first = choice.chosen(kernel.fly, perf_counter() - begun), first + 1
    if first < cases:
        compact = _compact(f)
        work = samples * kernel.COMPILED
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
        seconds = float(_last(f).sum()) * kernel.PLAIN / 2.0
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


_DIGITS = 12
"""Of a time in a substep [s]: times on a grid fall on few of them."""
_FEW = 64
"""So many of them are taken one after the other."""
_MAX_NUMBERS = 4_000_000
"""Numbers of the matrices that are gathered at once, 32 or 64 MB."""


class Tracked(NamedTuple):
    """One flight by samples at some times ``(m,)``, zero before its start.

    `rows`: states of the plant and the deflection, ``(n + 1, m)``. `rate`, `acceleration`: of the
    actuator right after the times [rad/s, rad/s2]; None without one. They are those of its
    equation. In a substep in which its rate or its stop bounds the nozzle it goes evenly; that it
    is stopped short there counts as no acceleration, nor does a jump of the rate of an actuator of
    first order.
    """

    rows: FloatArray
    rate: FloatArray | None
    acceleration: FloatArray | None


def tracked(flight: Batch, times: FloatArray) -> Tracked:
    """Fly one flight by samples, and return it at times [s] up to its end.

    `InputError` when its states have grown beyond all meaning.
    """
    plant, actuator, f = flight.plant, flight.hardware.actuator, flown(flight, track=True)
    n, whole = len(plant.states), plant_with_actuator(plant, actuator)
    _check(f, n)
    at = _substeps(f, whole, n, times)
    rows = _rows(at, plant, actuator, flight.wind, times)
    if actuator is None:
        return Tracked(rows, None, None)
    moves = whole.A @ at.free + whole.B[:, :1] * at.command
    still = times < at.onset
    rate = np.where(still, 0.0, np.where(at.bounded, at.slope, moves[n]))
    return Tracked(rows, rate, np.where(still | at.bounded, 0.0, whole.A[n] @ moves))


def outputs_of(plant: AnyPlant, rows: FloatArray, gusts: FloatArray) -> FloatArray:
    """Return the outputs of a plant, of its states with the deflection, and of the wind [rad]."""
    _, _, C, D = plant.matrices()
    return np.asarray(C @ rows[:-1] + D[:, : len(VEHICLE_INPUTS)] @ np.stack([rows[-1], gusts]))


def _check(f: Flights, order: int) -> None:
    """Raise `InputError` when states of a flight have grown beyond all meaning."""
    track = _written(f)
    with np.errstate(invalid="ignore"):
        beyond = ~(np.abs(track[:, :order]).max(axis=1) <= LOST)
    if np.any(beyond):
        first = track[np.argmax(beyond)]
        check_not_lost(float(first[-1]), first[:order])


def _rows(
    at: _Substeps, plant: AnyPlant, actuator: Actuator | None, wind: History, times: FloatArray
) -> FloatArray:
    bare, y, first, slope = plant.system, at.y, at.first, at.slope
    n = len(bare.states)
    vehicle = y[:, :n]
    if "deflection_acceleration" in bare.inputs:  # an impulse where the even rate begins
        before = np.where(np.abs(y[:, n]) <= at.limit, y[:, n + 1], 0.0)
        vehicle = vehicle + (slope - before)[:, np.newaxis] * bare.B[:, 2]
    rows = np.zeros((n + 1, times.size))
    rows[:n] = at.free[:n]
    if np.any(at.bounded):
        even = connect([bare, polynomial_input("deflection", 2)], (), ()).to_steps(at.once).A
        straight = at.moved(even, np.column_stack([vehicle, first, slope]))[:n]
        rows[:n] = np.where(at.bounded, straight, rows[:n])
    rows[:n] += _blown(bare.A, bare.B[:, 1], wind, at)
    position = at.command if actuator is None else np.clip(at.free[n], -at.limit, at.limit)
    rows[n] = np.where(at.bounded, first + slope * at.u, position)
    return np.where(times < at.onset, 0.0, rows)


class _Substeps(NamedTuple):
    """For each of m times the substep in which it lies, and how long after its begin.

    `once` are these lengths of time, each once, and `which` says which of them each is.
    """

    onset: float
    limit: float
    begins: FloatArray
    u: FloatArray
    once: FloatArray
    which: IndexArray
    y: FloatArray
    command: FloatArray
    bounded: BoolArray
    first: FloatArray
    slope: FloatArray
    free: FloatArray

    def moved(self, steps: AnyArray, states: AnyArray) -> AnyArray:
        """Return what matrices of `once` make of states ``(m, n)``, as columns."""
        found = np.empty((steps.shape[1], len(states)), np.result_type(steps, states))
        if self.once.size > _FEW:
            width = max(_MAX_NUMBERS // max(steps[0].size, 1), 1)
            for k in range(0, len(states), width):
                part = slice(k, k + width)
                found[:, part] = np.einsum("mij,mj->im", steps[self.which[part]], states[part])
            return found
        for k, one in enumerate(steps):
            mine = self.which == k
            found[:, mine] = one @ states[mine].T
        return found


def _substeps(f: Flights, whole: LinearSystem, n: int, times: FloatArray) -> _Substeps:
    """Of a system with n states of the plant, then those of its actuator."""
    N, order = f.now.y.shape[1], len(whole.states)
    limit, track = float(f.cases.limit[0]), _written(f)
    begins = track[:, -1]
    row = np.clip(np.searchsorted(begins, times, side="right") - 1, 0, len(begins) - 1)
    u = np.maximum(times - begins[row], 0.0)
    once, which = np.unique(np.round(u, _DIGITS), return_inverse=True)
    y, (command, last, met) = track[row, :N], track[row, N:-1].T
    lengths = np.diff(begins, append=f.cases.start[0] + f.steps.lengths[0, 0] * f.now.ended[0])[row]
    first = np.clip(y[:, n], -limit, limit)
    at = _Substeps(
        onset=float(begins[0]),
        limit=limit,
        begins=begins[row],
        u=u,
        once=np.asarray(once, dtype=np.float64),
        which=which,
        y=y,
        command=command,
        bounded=met > 0.0,
        first=first,
        slope=(last - first) / lengths,
        free=y,
    )
    moved = whole.select(INPUTS[:1], ()).to_steps(at.once)
    free = at.moved(
        np.concatenate([moved.A, moved.B], axis=2), np.column_stack([y[:, :order], command])
    )
    return at._replace(free=free)


def _written(f: Flights) -> FloatArray:
    """The rows of the track that were written."""
    return f.track[~np.isnan(f.track[:, -1])]


def _blown(A: FloatArray, gust: FloatArray, wind: History, at: _Substeps) -> FloatArray:
    """What the wind adds to the states since the begin of a substep, ``(n, m)``."""
    n, pieces = len(A), wind.pieces
    matrix, begins = piece_matrix(A, gust, pieces), at.begins
    steps = matrix_exponentials(matrix, at.once)[:, :n, n:]
    added = np.real(at.moved(steps, input_states(pieces, begins)))
    knots = pieces.knots[:, np.newaxis]
    ends = begins + at.u
    for k in np.flatnonzero(np.any((begins < knots) & (knots < ends), axis=0)):
        inside = pieces.knots[(begins[k] < pieces.knots) & (pieces.knots < ends[k])]
        edges = np.concatenate([begins[k : k + 1], inside, ends[k : k + 1]])
        state = np.zeros(n, dtype=complex)
        for part, begun in zip(
            matrix_exponentials(matrix, np.diff(edges)),
            input_states(pieces, edges[:-1]),
            strict=True,
        ):
            state = part[:n, :n] @ state + part[:n, n:] @ begun
        added[:, k] = np.real(state)
    return np.asarray(added)
