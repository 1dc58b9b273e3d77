"""When a flight is lost or settled, for a batch of plants: the recoverable set of each."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.boundary.recoverable import MOST_MODES
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.modes import left_eigenvector, select_unstable
from tvclin.linear.plant import INPUTS

SETTLING = 5.0
"""Saved: settled for so long, over the fastest pole."""
WAITING = 60.0
"""A flight that is neither lost nor settled by so long after the wind, over the slowest pole."""


class Judging(NamedTuple):
    """What judges the flights of plants ``(p,)`` with states ``(n,)``.

    `rows`: of the fast and of the slow unstable coordinate [rad], ``(p, 2, n + 2)``: of the states,
    of the deflection and its rate; zeros for no second. `reach`: of the coordinates, over the
    deflection limit, ``(p,)``. NaN where a plant has not one or two real unstable poles, so that
    nothing can be said of its flights. `ratio`: the slow pole over the fast one; zero where there
    is one, ``(p,)``. `settling`, `waiting`: how long a flight must be settled to be saved, and may
    be open [s], ``(p,)``.
    """

    rows: FloatArray
    reach: FloatArray
    ratio: FloatArray
    settling: FloatArray
    waiting: FloatArray


def judging(plant: AnyPlant) -> Judging:
    """Return what judges the flights of a batch of plants, flattened."""
    fast, slow, reach = _growing(plant)
    two, B = ~np.isnan(slow), np.broadcast_to(plant.coefficients.B, plant.batch).ravel()
    slow = np.where(two, slow, fast)
    first = _coordinate(plant, fast, B)
    second = _coordinate(plant, slow, B) if np.any(two) else first
    return Judging(
        rows=np.stack([first, np.where(two[:, np.newaxis], second, 0.0)], axis=1),
        reach=reach,
        ratio=np.where(two, slow / fast, 0.0),
        settling=SETTLING / fast,
        waiting=WAITING / slow,
    )


def decidable(plant: AnyPlant) -> BoolArray:
    """Return which plants of a batch have one or two real unstable poles and a moment."""
    reach = _growing(plant)[-1]
    return (np.isfinite(reach) & (reach > 0.0)).reshape(plant.batch)


def _growing(plant: AnyPlant) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The fast and the slow real unstable pole, NaN where there is none, and `reach`."""
    poles = select_unstable(plant.poles)
    size = int(np.prod(plant.batch))
    poles = poles.reshape(-1, poles.shape[-1]) if poles.size else np.full((size, 1), np.nan)
    columns = np.ascontiguousarray(poles.T)
    real = np.all((np.imag(columns) == 0.0) | np.isnan(columns), axis=0)
    count = np.sum(~np.isnan(columns), axis=0)
    known = real & (count > 0) & (count <= MOST_MODES)
    s = np.full((MOST_MODES, len(poles)), np.nan)
    width = min(MOST_MODES, poles.shape[-1])
    s[:width] = np.real(columns[:width])
    fast, slow = np.where(known, s[0], 1.0), np.where(known, s[1], np.nan)
    B = np.broadcast_to(plant.coefficients.B, plant.batch).ravel()
    return fast, slow, 1.0 / np.abs(np.where(known, B, np.nan))


def _coordinate(plant: AnyPlant, pole: FloatArray, B: FloatArray) -> FloatArray:
    """The rows z of `recoverable.unstable_coordinates`, of states, delta and delta'.

    With l A = p l and z = l x, z' = p z + l b delta + l b3 delta'', b3 being what an engine with
    inertia does. What the deflection moves alone is

        z - l b3 (delta' + p delta),    by l b + p^2 l b3.
    """
    A, inputs, _, _ = plant.matrices()
    n, count = A.shape[-1], inputs.shape[-1]
    A, inputs = A.reshape(-1, n, n), inputs.reshape(-1, n, count)
    row = np.real(left_eigenvector(A, pole)[1])
    moved = np.einsum("mi,mij->mj", row, inputs)
    swing = moved[:, len(INPUTS) :].sum(axis=1)
    rows = np.column_stack([row, -pole * swing, -swing])
    with np.errstate(divide="ignore", invalid="ignore"):  # a plant without moments
        return rows * (-pole / B / (moved[:, 0] + pole**2 * swing))[:, np.newaxis]
