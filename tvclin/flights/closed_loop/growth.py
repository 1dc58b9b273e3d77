"""How fast a sampled loop grows near rest, in still air and far below its limits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tvclin.flights.closed_loop.sampled import Batch, advanced, flights

FloatArray = NDArray[np.float64]

_SMALL = 1e-7
"""A state so small, over the reach, is far below every limit and dead band."""


def growth_near_rest(batch: Batch) -> float:
    """Return the growth rate [1/s] of one loop: vehicle, nozzle, law and delay together.

    The spectral radius of its step near rest says how fast the worst mode grows (positive) or
    decays.
    """
    radius = np.abs(np.linalg.eigvals(step_near_rest(batch))).max()
    return float(np.log(max(radius, np.finfo(float).tiny)) / float(batch.length))


def step_near_rest(batch: Batch) -> FloatArray:
    """Return the step of one loop near rest, where it is a matrix.

    Its columns are what a step makes of small states: those of the vehicle, of the nozzle and of
    the law, and the commands that are still to come, the latest first.
    """
    f = flights(batch)
    order, own, ring = f.y.shape[1], f.states.shape[1], f.commands.shape[1]
    ages = np.arange(1, int(f.late[0]) + f.joint.shape[1])  # of commands that are still to come
    size = order + own + ages.size
    small = _SMALL * float(batch.limit) / abs(float(batch.plant.coefficients.B))
    f = flights(batch.repeated(size + 1))  # the last is at rest: what noise does
    f.pieces[:] = 0.0
    states = np.split(small * np.eye(size + 1, size), [order, order + own], axis=1)
    f.y[:], f.states[:], f.commands[:, -ages % ring] = states
    advanced(f, batch.laws, 0)
    moved = np.concatenate([f.y, f.states, f.commands[:, (1 - ages) % ring]], axis=1)
    return np.asarray((moved[:-1] - moved[-1]).T / small)
