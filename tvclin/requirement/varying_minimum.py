"""Unstable modes of vehicles after a wind, and the minimum peak of any control over all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IndexArray
from tvclin.kernels import minimum_peaks as marches
from tvclin.kernels.choice import run
from tvclin.linear.modes import left_eigenvectors

_CELL_ENDS = np.expm1(np.linspace(0.0, 8.0, 256)) / np.expm1(8.0)
"""Ends of the cells of a deflection after the wind, over `_CELL_SPAN` times the time constant of
the slowest mode; the last cell has no end."""
_CELL_SPAN = 30.0
"""Length of the cells that end, over the time constant of the slowest mode."""


@dataclass(frozen=True, eq=False)
class UnstableModes:
    """Unstable modes of constant equations after a wind, of cases with the same kinds of modes.

    Attributes
    ----------
    cases : ndarray of int
        Positions in the batch, ``(n,)``.
    poles, costates : ndarray
        Poles s [1/s] ``(n, k)`` and left eigenvectors ``(n, k, m)``, A^T p = s p; of a complex pair
        the pole of positive frequency.
    """

    cases: IndexArray
    poles: AnyArray
    costates: AnyArray

    def after(self, end: FloatArray, column: FloatArray) -> tuple[FloatArray, ...]:
        """Return real costates, control reaches, poles, and integrals of p.b over cells.

        They are the arguments of `kernels.minimum_peaks`, ``(n, k, m)``, ``(n, 2)``, ``(n, 2)`` and
        ``(n, k, cells)``. Of one or two real modes there are no cells.

        Parameters
        ----------
        end : ndarray
            Costate and control reach of the fastest mode, ``(n, m + 1)``, of the rest of a
            flight are not the eigenvector.
        column : ndarray
            Column b of the deflection, ``(n, m)``.
        """
        n, k = len(end), self.poles.shape[1]
        complex_modes = np.imag(self.poles[0]) != 0.0
        costates = np.broadcast_to(self.costates, (n, *self.costates.shape[1:]))
        reach = np.vecdot(np.conj(costates), column[:, np.newaxis]) / self.poles
        costates = np.concatenate([costates.real, costates.imag[:, complex_modes]], axis=1)
        costates[:, 0] = end[:, :-1]
        reaches, poles = np.zeros((n, 2)), np.zeros((n, 2))
        if k <= 2 and not np.any(complex_modes):
            reaches[:, :k], poles[:, :k] = reach, self.poles
            reaches[:, 0] = end[:, -1]
            return costates, reaches, poles, np.zeros((n, k, 0))
        slowest = np.real(self.poles).min(axis=-1, keepdims=True)
        ends = _CELL_ENDS * _CELL_SPAN / slowest
        decay = np.exp(-self.poles[..., np.newaxis] * ends[:, np.newaxis])
        decay[..., -1] = 0.0
        reach[:, 0] = end[:, -1]
        cells = -reach[..., np.newaxis] * np.diff(decay, axis=-1)
        cells = np.concatenate([cells.real, cells.imag[:, complex_modes]], axis=1)
        return costates, reaches, poles, cells


def unstable_modes_of(A: FloatArray, fewest: int = 1) -> tuple[UnstableModes, ...]:
    """Return the unstable modes of ``A (n, m, m)``, up to three of them, the fastest one real.

    `fewest`: cases with fewer unstable modes are left out, as are those with more than three.

    Cases with as many real modes and pairs are together; the others are left out.
    """
    values, vectors = left_eigenvectors(A)
    unstable = (np.real(values) > 0.0) & (np.imag(values) >= 0.0)
    pairs = unstable & (np.imag(values) > 0.0)
    kinds = np.add(unstable, pairs, dtype=int)  # 0, 1 of a real mode, 2 of a pair
    groups = []
    for kind in np.unique(kinds, axis=0):
        if kind[0] != 1 or not fewest <= kind.sum() <= 3:
            continue
        cases = np.flatnonzero(np.all(kinds == kind, axis=-1))
        poles, costates = values[cases][:, kind > 0], vectors[cases][:, kind > 0]
        if not np.any(kind == 2):
            poles, costates = np.real(poles), np.real(costates)
        groups.append(UnstableModes(cases, poles, costates))
    return tuple(groups)


def minimum_peaks(
    modes: UnstableModes,
    march: Sequence[FloatArray],
    path: FloatArray,
    heights: FloatArray | None = None,
) -> FloatArray:
    """Return the minimum peaks [rad] of all control from the begin of steps on, ``(n, S + 1)``.

    Zero where they are not known: without `heights` from the second step on.

    Parameters
    ----------
    modes : UnstableModes
        Of these cases.
    march : sequence of ndarray
        The first six arguments of `kernels.trim_and_demand`, of these cases.
    path : ndarray
        States beyond attitude and rate that trim has led to at the ends of steps,
        ``(n, S + 1, m - 2)``.
    heights : ndarray, optional
        Trim over K [rad] from which steps on minimum peaks are known, see `Curves.trim_ratios`:
        backwards to the first above it.
    """
    *columns, end = march
    column = columns[1][:, -1, 2, :, -2]
    column = np.broadcast_to(column, (len(end), column.shape[-1]))
    costates, reaches, poles, cells = modes.after(end, column)
    peaks = np.zeros(path.shape[:2])
    if heights is None:
        heights = np.full(peaks.shape, np.nan)
    arrays = *columns, costates, reaches, poles, cells, path, heights
    count = costates.shape[1]
    steps = peaks.size * count
    duals = len(path) + np.sum(~np.isnan(heights))
    sums = duals * marches.TANGENTS ** (count - 1) * float(path.shape[1] + cells.shape[-1])
    run(
        marches.minimum_peaks,
        (*(np.require(x, float, ["C", "W"]) for x in arrays), peaks),
        len(peaks),
        marches.PLAIN * steps + marches.CELL_PLAIN * sums,
        marches.COMPILED * steps + marches.CELL_COMPILED * sums,
    )
    return peaks
