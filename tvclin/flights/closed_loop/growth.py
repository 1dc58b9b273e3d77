"""How fast sampled loops grow near rest, in still air and far below their limits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tvclin.flights.closed_loop.outcomes import SETTLING
from tvclin.flights.closed_loop.sampled import Batch, finish, flights
from tvclin.kernels.flight_arrays import Flights

FloatArray = NDArray[np.float64]

_SMALL = 1e-7
"""A state so small, over the reach, is far below every limit and dead band."""
SLOW = 0.1
"""What turns more slowly, over the fastest growing pole, does not swing but creeps."""
_TOGETHER = 20_000
"""Flights of one sample that are flown together."""
_SHARED = {"memory", "seen", "told"}
"""One for each flight, or one for all."""
_OF_EACH = (
    *("vehicle", "wind", "law", "gain", "limit", "rate_limit", "start", "finish", "ends"),
    *("waiting", "settling", "sequence", "y", "states", "here", "sensed", "measured", "next"),
    *("series", "commands", "mode", "bounded", "peaks", "piece", "settled", "outcome", "ended"),
)
"""Arrays of `Flights` with a row for each flight."""


def growth_near_rest(batch: Batch) -> float:
    """Return the growth rate [1/s] of one loop: vehicle, nozzle, law and delay together.

    The spectral radius of its step near rest says how fast the worst mode grows (positive) or
    decays.
    """
    return worst_near_rest(batch).real


def worst_near_rest(batch: Batch) -> complex:
    """Return the pole [1/s] of the worst mode of one loop, log(z)/h, upper where there are two.

    Its frequency is what the samples show, at most half their rate.
    """
    values = np.linalg.eigvals(step_near_rest(batch)).astype(complex)
    worst = values[np.abs(values).argmax()]
    growth = np.log(max(abs(worst), np.finfo(float).tiny))
    return complex(growth, abs(np.angle(worst))) / float(batch.length)


def swing_near_rest(batch: Batch) -> FloatArray:
    """Return the growth rate [1/s] of the worst oscillation of each of many loops, ``(m,)``.

    What creeps does not count: a real positive eigenvalue of the step, and one that turns by less
    than a tenth of the fastest growing pole, as the path does.
    """
    f = flights(batch)
    size = 1 + f.y.shape[1] + f.states.shape[1] + f.commands.shape[1]
    parts = np.array_split(np.arange(f.limit.size), -(-f.limit.size * size // _TOGETHER))
    steps = [np.linalg.eigvals(_steps(batch, f, part)) for part in parts]
    values = np.concatenate(steps).astype(complex)
    h = f.lengths[f.vehicle, 0]
    turns = np.abs(np.angle(values)) / h[:, np.newaxis]
    slowest = SLOW * SETTLING / np.maximum(f.settling * h, h)
    swings = (turns > slowest[:, np.newaxis]) & (np.angle(values) != 0.0)
    radius = np.where(swings, np.abs(values), 0.0).max(axis=1, initial=np.finfo(float).tiny)
    return np.asarray(np.log(radius) / h)


def step_near_rest(batch: Batch) -> FloatArray:
    """Return the step of one loop near rest, where it is a matrix.

    Its columns are what a step makes of small states: those of the vehicle, of the nozzle and of
    the law, and the commands that are still to come, the latest first.
    """
    return _steps(batch, flights(batch), np.zeros(1, np.intp))[0]


def _steps(batch: Batch, f: Flights, cases: NDArray[np.intp]) -> FloatArray:
    """The steps of some flights at their start, ``(k, size, size)``."""
    order, own, ring = f.y.shape[1], f.states.shape[1], f.commands.shape[1]
    ages = np.arange(1, ring)  # of commands that are still to come
    size = order + own + ages.size
    reach = max(float(np.abs(batch.plant.coefficients.B).max()), 1.0)
    small = _SMALL / reach * f.limit[cases, np.newaxis, np.newaxis]
    f = chosen(f, np.repeat(cases, size + 1))  # the last of each is at rest: what noise does
    states = np.split((small * np.eye(size + 1, size)).reshape(-1, size), [order, order + own], 1)
    f.y[:], f.states[:], f.commands[:, -ages % ring] = states
    finish(f, batch.laws)
    moved = np.concatenate([f.y, f.states, f.commands[:, (1 - ages) % ring]], axis=1)
    moved = moved.reshape(-1, size + 1, size)
    return np.asarray(np.swapaxes((moved[:, :-1] - moved[:, -1:]) / small, 1, 2))


def chosen(f: Flights, index: NDArray[np.intp]) -> Flights:
    """Return some flights, of one sample in still air; those that are named twice are two."""
    own = {name for name in _SHARED if len(getattr(f, name)) > 1}
    rows = {name: getattr(f, name)[index] for name in {*_OF_EACH, *own}}
    rows["finish"][:] = 1
    return f._replace(pieces=np.zeros_like(f.pieces), **rows)
