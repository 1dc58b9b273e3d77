"""One sampled flight at any time: from the start of the substep in which the time lies."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tvclin.control.autopilot.actuator import INPUTS, Actuator, plant_with_actuator
from tvclin.flights.closed_loop.batch import Batch
from tvclin.flights.closed_loop.checks import LOST, check_not_lost
from tvclin.flights.closed_loop.sampled import flown
from tvclin.kernels.flight_arrays import Flights
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.plant import INPUTS as VEHICLE_INPUTS
from tvclin.linear.system import LinearSystem, connect, polynomial_input
from tvclin.numerics.propagation import input_states, matrix_exponentials, piece_matrix
from tvclin.winds.histories import History

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
