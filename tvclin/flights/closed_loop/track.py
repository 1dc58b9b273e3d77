"""One sampled flight at any time: from the start of the substep in which the time lies."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tvclin.control.autopilot.actuated import actuated
from tvclin.control.autopilot.actuator import Actuator
from tvclin.flights.closed_loop.checks import LOST, check_not_lost
from tvclin.kernels.flight_arrays import Flights
from tvclin.kernels.propagation import answering, driven, exponentials, inputs_at
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.plant import INPUTS
from tvclin.linear.system import LinearSystem
from tvclin.winds.histories import History

FloatArray = NDArray[np.float64]


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

    Parameters
    ----------
    f : Flights
        One flight, flown with its track.
    plant, actuator, wind : Plant or FlexiblePlant, Actuator or None, History
        What flew.
    times : ndarray
        Times [s] up to its end.
    """
    A, inputs, _, _ = plant.matrices()
    n, N = len(A), f.y.shape[1]
    limit, track = float(f.limit[0]), _flown(f)
    begins = track[:, -1]
    row = np.clip(np.searchsorted(begins, times, side="right") - 1, 0, len(begins) - 1)
    u = np.maximum(times - begins[row], 0.0)
    y, (command, last, met) = track[row, :N], track[row, N:-1].T
    bounded = met > 0.0
    free = _free(actuated(plant, actuator), y, command, u)
    lengths = np.diff(begins, append=f.start[0] + f.lengths[0, 0] * f.ended[0])[row]
    first = np.clip(y[:, n], -limit, limit)
    slope = (last - first) / lengths
    even = exponentials(driven(A, np.column_stack([inputs[:, 0], np.zeros(n)]), np.eye(2, k=1)), u)
    vehicle = y[:, :n]
    if inputs.shape[1] > len(INPUTS):  # b3 delta'' is an impulse where the even rate begins
        before = np.where(np.abs(y[:, n]) <= limit, y[:, n + 1], 0.0)
        vehicle = vehicle + (slope - before)[:, np.newaxis] * inputs[:, 2]
    begun = np.column_stack([vehicle, first, slope])
    straight = np.einsum("mij,mj->im", even[:, :n], begun)
    rows = np.zeros((n + 1, times.size))
    rows[:n] = np.where(bounded, straight, free[:n]) + _blown(A, inputs[:, 1], wind, begins[row], u)
    position = command if actuator is None else np.clip(free[n], -limit, limit)
    rows[n] = np.where(bounded, first + slope * u, position)
    return np.where(times < begins[0], 0.0, rows)


def _flown(f: Flights) -> FloatArray:
    """The rows of the track that were written."""
    return f.track[~np.isnan(f.track[:, -1])]


def _free(whole: LinearSystem, y: FloatArray, command: FloatArray, u: FloatArray) -> FloatArray:
    """States of plant and nozzle after times `u` without a limit, in still air, ``(N, m)``."""
    order = len(whole.A)
    moved = exponentials(driven(whole.A, whole.B[:, :1]), u)[:, :order]
    return np.einsum("mij,mj->im", moved, np.column_stack([y[:, :order], command]))


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
