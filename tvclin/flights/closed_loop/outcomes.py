"""Outcome of a flight: lost outside the recoverable set of its unstable modes, settled inside."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.boundary.forecast_free import MAX_MODES, coordinate_rows
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.modes import select_unstable

SETTLING = 5.0
"""Time that a flight must be settled to survive, times the fastest pole."""
WAITING = 60.0
"""Time after the wind after which a flight is undecided, times the slowest unstable pole."""


class OutcomeCriteria(NamedTuple):
    """Criteria of loss and survival for p plants with n states.

    `rows`: coefficients of the fast and the slow unstable coordinate [rad] on states, deflection
    and deflection rate, ``(p, 2, n + 2)``; zeros without a slow one. `reach`: largest recoverable
    coordinate over the deflection limit, ``(p,)``; NaN for a plant without one or two real unstable
    poles, whose flights have no outcome. `ratio`: slow over fast pole, ``(p,)``; zero for one pole.
    `settling`, `waiting`: times [s] of settling and until a flight is undecided, ``(p,)``.
    """

    rows: FloatArray
    reach: FloatArray
    ratio: FloatArray
    settling: FloatArray
    waiting: FloatArray


def outcome_criteria(plant: AnyPlant) -> OutcomeCriteria:
    """Return the criteria of loss and survival of a batch of plants, flattened to p plants.

    `rows`, ``(p, 2, n + 2)``, times n states, deflection and its rate is the coordinate [rad] of
    the fast and the slow unstable mode, the second zero without a slow one. A single one can be
    brought back below `reach` = 1/``|B|`` times the deflection limit, B being the trim deflection
    per angle of attack; of two that depends on both, and on `ratio`, the slow over the fast pole.
    `settling` and `waiting` [s]: 5 time constants of the fastest and 60 of the slowest mode.
    """
    fast, slow, reach = _unstable_poles(plant)
    two, B = ~np.isnan(slow), np.broadcast_to(plant.coordinate_scale, plant.batch).ravel()
    slow = np.where(two, slow, fast)  # a single pole is the fastest and the slowest
    first = coordinate_rows(plant, fast, B)
    second = coordinate_rows(plant, slow, B) if np.any(two) else first
    return OutcomeCriteria(
        rows=np.stack([first, np.where(two[:, np.newaxis], second, 0.0)], axis=1),
        reach=reach,
        ratio=np.where(two, slow / fast, 0.0),
        settling=SETTLING / fast,
        waiting=WAITING / slow,
    )


def decidable(plant: AnyPlant) -> BoolArray:
    """Return whether flights of each plant have an outcome, in the shape of the batch.

    They have for one or two real unstable poles and a control moment, where the reach of the
    recoverable set, its largest unstable coordinate over the limit, is finite and positive.
    """
    _, _, reach = _unstable_poles(plant)  # angle of attack that a unit deflection trims
    return (np.isfinite(reach) & (reach > 0.0)).reshape(plant.batch)


def _unstable_poles(plant: AnyPlant) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the fast and the slow real unstable pole [1/s], NaN without it, and the reach 1/|B|.

    All are ``(p,)``. A plant with other unstable poles has a reach of NaN, and a fast pole of 1 in
    place of one. B is the trim deflection per angle of attack.
    """
    poles = select_unstable(plant.poles)
    size = int(np.prod(plant.batch))
    poles = poles.reshape(-1, poles.shape[-1]) if poles.size else np.full((size, 1), np.nan)
    columns = np.ascontiguousarray(poles.T)  # a row for each mode, the fastest first, NaN after
    real = np.all((np.imag(columns) == 0.0) | np.isnan(columns), axis=0)
    count = np.sum(~np.isnan(columns), axis=0)
    valid = real & (count > 0) & (count <= MAX_MODES)
    s = np.full((MAX_MODES, len(poles)), np.nan)
    width = min(MAX_MODES, poles.shape[-1])
    s[:width] = np.real(columns[:width])
    fast, slow = np.where(valid, s[0], 1.0), np.where(valid, s[1], np.nan)
    B = np.broadcast_to(plant.coordinate_scale, plant.batch).ravel()  # scales the coordinates
    return fast, slow, 1.0 / np.abs(np.where(valid, B, np.nan))
