"""How fast a sampled loop grows near rest, in still air and far below its limits."""

from __future__ import annotations

import numpy as np

from tvclin.flights.closed_loop.sampled import Batch, advanced, flights

_SMALL = 1e-7
"""A state so small, over the reach, is far below every limit and dead band."""


def growth_near_rest(batch: Batch) -> float:
    """Return the growth rate [1/s] of one loop: vehicle, nozzle, law and delay together.

    Its step is a matrix near rest, whose rows are what one step makes of small states; the
    spectral radius says how fast the worst mode grows (positive) or decays.
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
    step = (moved[:-1] - moved[-1]) / small
    radius = np.abs(np.linalg.eigvals(step)).max()
    return float(np.log(max(radius, np.finfo(float).tiny)) / float(batch.length))
