"""When a flight is lost or saved, for a batch of plants: the recoverable set of each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels import flight_table as table
from tvclin.modes import unstable_poles
from tvclin.plant import Plant

FloatArray = NDArray[np.float64]

CALM = 5.0
"""Saved: settled for so long, over the fastest pole."""
PATIENCE = 60.0
"""A flight that is neither lost nor saved by so long after the wind, over the slowest pole."""
_MOST = 2


def judging_rows(plant: Plant) -> FloatArray:
    """Return the rows from FAST to PATIENCE of a `FlightTable`, ``(12, *batch)``.

    The reach is one over B, to be multiplied by the deflection limit; NaN where a plant has not
    one or two real unstable poles, so that nothing can be said of its flights.
    """
    size = int(np.prod(plant.batch))
    poles = unstable_poles(plant)
    poles = poles.reshape(-1, poles.shape[-1]) if poles.size else np.full((size, 1), np.nan)
    columns = np.ascontiguousarray(poles.T)
    real = np.all((np.imag(columns) == 0.0) | np.isnan(columns), axis=0)
    count = np.sum(~np.isnan(columns), axis=0)
    known = real & (count > 0) & (count <= _MOST)
    s = np.full((_MOST, len(poles)), np.nan)
    width = min(_MOST, poles.shape[-1])
    s[:width] = np.real(columns[:width])
    fast, slow = np.where(known, s[0], 1.0), s[1]
    two = known & ~np.isnan(slow)
    slow = np.where(two, slow, fast)
    B = np.broadcast_to(plant.coefficients.B, plant.batch).ravel()
    found = np.zeros((12, len(poles)))
    found[0:4] = _coordinate(plant, fast, B)
    if np.any(two):
        found[4:8] = np.where(two, _coordinate(plant, slow, B), 0.0)
    found[table.REACH - table.FAST] = np.where(known, 1.0 / np.abs(B), np.nan)
    found[table.RATIO - table.FAST] = np.where(two, slow / fast, 0.0)
    found[table.CALM - table.FAST] = CALM / fast
    found[table.PATIENCE - table.FAST] = PATIENCE / slow
    return found.reshape(12, *plant.batch)


def _coordinate(plant: Plant, pole: FloatArray, B: FloatArray) -> FloatArray:
    """The rows z of `recoverable.unstable_coordinates`, ``(4, plants)``: l with l A = pole l."""
    A, inputs, _, _ = plant.matrices()
    n = A.shape[-1]
    A, drive = A.reshape(-1, n, n), inputs.reshape(-1, n, 2)[..., 0]
    row = np.zeros((4, len(A)))
    row[1], row[0] = 1.0, pole
    if n > 2:
        turning = A[:, 2, 3] * A[:, 3, 2] / pole if n > 3 else 0.0
        row[2] = A[:, 1, 2] / (pole - A[:, 2, 2] - turning)
    if n > 3:
        row[3] = row[2] * A[:, 2, 3] / pole
    with np.errstate(divide="ignore", invalid="ignore"):  # a plant without moments
        return row * (-pole / B) / np.einsum("im,mi->m", row[:n], drive)
