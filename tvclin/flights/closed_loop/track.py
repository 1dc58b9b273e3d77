"""One sampled flight at any time: from the start of the substep in which the time lies."""

from __future__ import annotations

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.control.autopilot.actuated import INPUTS, actuated
from tvclin.control.autopilot.actuator import Actuator
from tvclin.flights.closed_loop.checks import LOST, check_not_lost
from tvclin.kernels.flight_arrays import Flights
from tvclin.kernels.propagation import answering, exponentials, inputs_at
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.system import connect, rising
from tvclin.winds.histories import History


def check_track(f: Flights, order: int) -> None:
    """Raise `InputError` when states of a flight have grown beyond all meaning."""
    track = _flown(f)
    with np.errstate(invalid="ignore"):
        beyond = ~(np.abs(track[:, :order]).max(axis=1) <= LOST)
    if np.any(beyond):
        first = track[np.argmax(beyond)]
        check_not_lost(float(first[-1]), first[:order])


def between_samples(
    f: Flights, plant: AnyPlant, actuator: Actuator | None, wind: History, times: FloatArray
) -> FloatArray:
    """Return the states of the plant and the deflection at times ``(n,)``, zero before the start.

    `f`: one flight, flown with its track. `plant`, `actuator`, `wind`: what flew. `times`: times
    [s] up to its end.
    """
    bare, whole = plant.system, actuated(plant, actuator).select(INPUTS[:1], ())
    n, N, order = len(bare.states), f.y.shape[1], len(whole.states)
    limit, track = float(f.limit[0]), _flown(f)
    begins = track[:, -1]
    row = np.clip(np.searchsorted(begins, times, side="right") - 1, 0, len(begins) - 1)
    u = np.maximum(times - begins[row], 0.0)
    y, (command, last, met) = track[row, :N], track[row, N:-1].T
    bounded = met > 0.0
    moved = whole.to_steps(u)
    free = np.einsum("mij,mj->im", moved.A, y[:, :order]) + moved.B[..., 0].T * command
    lengths = np.diff(begins, append=f.start[0] + f.lengths[0, 0] * f.ended[0])[row]
    first = np.clip(y[:, n], -limit, limit)
    slope = (last - first) / lengths
    even = connect([bare, rising("deflection", 2)], (), ()).to_steps(u).A
    vehicle = y[:, :n]
    if "deflection_acceleration" in bare.inputs:  # an impulse where the even rate begins
        before = np.where(np.abs(y[:, n]) <= limit, y[:, n + 1], 0.0)
        vehicle = vehicle + (slope - before)[:, np.newaxis] * bare.B[:, 2]
    begun = np.column_stack([vehicle, first, slope])
    straight = np.einsum("mij,mj->im", even[:, :n], begun)
    rows = np.zeros((n + 1, times.size))
    blown = _blown(bare.A, bare.B[:, 1], wind, begins[row], u)
    rows[:n] = np.where(bounded, straight, free[:n]) + blown
    position = command if actuator is None else np.clip(free[n], -limit, limit)
    rows[n] = np.where(bounded, first + slope * u, position)
    return np.where(times < begins[0], 0.0, rows)


def _flown(f: Flights) -> FloatArray:
    """The rows of the track that were written."""
    return f.track[~np.isnan(f.track[:, -1])]


def _blown(
    A: FloatArray, gust: FloatArray, wind: History, begins: FloatArray, u: FloatArray
) -> FloatArray:
    """What the wind adds to the states from `begins` to `u` later, ``(n, m)``."""
    n, pieces = len(A), wind.pieces
    matrix = answering(A, gust, pieces)
    whole = exponentials(matrix, u)[:, :n, n:]
    added = np.real(np.einsum("mij,mj->im", whole, inputs_at(pieces, begins)))
    knots = pieces.knots[:, np.newaxis]
    ends = begins + u
    for k in np.flatnonzero(np.any((begins < knots) & (knots < ends), axis=0)):
        inside = pieces.knots[(begins[k] < pieces.knots) & (pieces.knots < ends[k])]
        edges = np.concatenate([begins[k : k + 1], inside, ends[k : k + 1]])
        state = np.zeros(n, dtype=complex)
        for part, begun in zip(
            exponentials(matrix, np.diff(edges)), inputs_at(pieces, edges[:-1]), strict=True
        ):
            state = part[:n, :n] @ state + part[:n, n:] @ begun
        added[:, k] = np.real(state)
    return np.asarray(added)
