"""Minimum peak of any control over all unstable modes of vehicles whose equations vary.

With the costates p_i of the unstable modes, p' = -A^T p integrated backwards from the end of the
wind, a deflection delta brings all unstable components to zero if

    integral of p_i.b delta dt = -d_i,    d_i = p_i.x + integral of p_i.w alpha_w dt,

and the minimum peak of all delta that do is, by the dual of appendix C with varying weights,

    maximum over lambda of |lambda.d| / integral |lambda.h| dt,    h_i = p_i.b.

Backwards all costates turn to that of the fastest mode, so that they are made orthogonal again
every few steps, with the integrals in their coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IndexArray
from tvclin.linear.modes import left_eigenvectors
from tvclin.numerics.searches import grid_minimum

_TAIL_CELLS = np.expm1(np.linspace(0.0, 8.0, 256)) / np.expm1(8.0)
"""Ends of the cells of a deflection after the wind, over `_TAIL_SPAN` times the time constant of
the slowest mode; the last cell has no end."""
_TAIL_SPAN = 30.0
"""Length of the cells that end, over the time constant of the slowest mode."""
_STEPS_PER_ORTHOGONALISATION = 4
"""Steps between two orthogonalisations, the same for all cases so that none depends on others."""
_DIRECTIONS, _REFINEMENTS = 16, 6
"""Directions of lambda where three modes are unstable, and refinements of the best."""


@dataclass(frozen=True, eq=False)
class UnstableModes:
    """Unstable modes of constant equations after a wind, of cases with the same kinds of modes.

    Attributes
    ----------
    cases : ndarray of int
        Positions in the batch, ``(n,)``.
    poles, costates : ndarray
        Poles s [1/s] ``(n, k)`` and left eigenvectors ``(n, k, m)``, A^T p = s p; of a complex pair
        that of positive frequency.
    """

    cases: IndexArray
    poles: AnyArray
    costates: AnyArray

    def tail(self, column: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return real costates ``(n, k, m)``, and integrals of p.b over cells after the wind.

        `column`: that of the deflection, ``(n, m)``. The integrals are ``(n, k, cells)``.
        """
        slowest = np.real(self.poles).min(axis=-1, keepdims=True)
        ends = _TAIL_CELLS * _TAIL_SPAN / slowest
        decay = np.exp(-self.poles[..., np.newaxis] * ends[:, np.newaxis])
        decay[..., -1] = 0.0
        pushed = np.vecdot(np.conj(self.costates), column[:, np.newaxis]) / self.poles
        cells = -pushed[..., np.newaxis] * np.diff(decay, axis=-1)
        complex_modes = np.imag(self.poles[0]) != 0.0
        costates = np.broadcast_to(self.costates, (len(column), *self.costates.shape[1:]))
        real, tail = (
            np.concatenate([x.real, x.imag[:, complex_modes]], axis=1) for x in (costates, cells)
        )
        return real, tail


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
    end: FloatArray,
    column: FloatArray,
    lengths: FloatArray,
    equations: FloatArray,
    wind: FloatArray,
    path: FloatArray,
    heights: FloatArray | None = None,
) -> FloatArray:
    """Return the minimum peaks [rad] of all control from the begin of steps on, ``(n, S + 1)``.

    Without `heights` from the first alone, ``(n, 1)``.

    Parameters
    ----------
    modes : UnstableModes
        Of these cases.
    end : ndarray
        Costate and control reach of the fastest mode at the end, ``(n, m + 1)``: those of the rest
        of a flight are not the eigenvector there.
    column : ndarray
        Column b of the deflection after the end, ``(n, m)``.
    lengths : ndarray
        Lengths of steps [s], ``(n, S)``.
    equations : ndarray
        ``[A b w]`` at begin, middle and end of each step, ``(n, S, 3, m, m + 2)``.
    wind : ndarray
        Wind angles of attack there [rad], ``(n, S, 3)``.
    path : ndarray
        States beyond attitude and rate that trim has led to at the ends of steps,
        ``(n, S + 1, m - 2)``.
    heights : ndarray, optional
        Trim over K [rad] from which steps on minimum peaks are known, see `Curves.heights_over`:
        backwards to the first above it. Elsewhere that of the fastest mode stands, a lower bound.
    """
    m, steps = equations.shape[-2], lengths.shape[1]
    costates, tail = modes.tail(column)
    costates[:, 0] = end[:, :m]
    tail[:, 0] *= (end[:, m] / tail[:, 0].sum(axis=-1))[:, np.newaxis]
    cases, count = costates.shape[:2]
    weights = np.concatenate([np.zeros((cases, count, steps)), tail], axis=-1)
    remaining = np.zeros((cases, count, 1))
    peaks = []
    open_cases = np.ones(cases, dtype=bool)

    def rates(s: int, q: int, p: FloatArray) -> FloatArray:
        rate = p @ equations[:, s, q]
        rate[..., m + 1] *= wind[:, s, q, np.newaxis]
        return np.asarray(rate)

    for s in range(steps, -1, -1):
        if s < steps:
            h = lengths[:, s, np.newaxis, np.newaxis]
            first = rates(s, 2, costates)
            second = rates(s, 1, costates + 0.5 * h * first[..., :m])
            third = rates(s, 1, costates + 0.5 * h * second[..., :m])
            last = rates(s, 0, costates + h * third[..., :m])
            change = h / 6.0 * (first + 2.0 * (second + third) + last)
            costates = costates + change[..., :m]
            weights[..., s] = change[..., m]
            remaining = remaining + change[..., m + 1 :]
        if s == 0 or (steps - s) % _STEPS_PER_ORTHOGONALISATION == 0:
            orthogonal, upper = np.linalg.qr(np.swapaxes(costates, -1, -2))
            turn = np.linalg.inv(np.swapaxes(upper, -1, -2))
            costates, remaining = np.swapaxes(orthogonal, -1, -2), turn @ remaining
            weights[..., s:] = turn @ weights[..., s:]
        if heights is not None or s == 0:
            component = np.einsum("nki,ni->nk", costates[..., 2:], path[:, s])
            d = component + remaining[..., 0]
            peak = np.abs(d[:, 0]) / np.abs(weights[:, 0, s:]).sum(axis=-1)  # of the fastest alone
            some = np.arange(cases)
            if heights is not None and s > 0:
                some = np.flatnonzero(open_cases & ~np.isnan(heights[:, s]))
            if some.size:
                peak[some] = np.maximum(_dual_value(weights[some, :, s:], d[some]), peak[some])
            if heights is not None:
                open_cases[some] = ~(heights[some, s] < peak[some])
            peaks.append(peak)
    return np.stack(peaks[::-1], axis=-1)


def _dual_value(weights: FloatArray, d: FloatArray) -> FloatArray:
    """Return max over lambda of lambda.d / sum |lambda.h|, of h ``(n, k, cells)``, d ``(n, k)``."""
    size = np.linalg.norm(d, axis=-1)
    if d.shape[-1] == 1:
        return np.asarray(size / np.abs(weights).sum(axis=(1, 2)))
    with np.errstate(divide="ignore", invalid="ignore"):
        along = d / size[:, np.newaxis]
        sums = np.einsum("nk,nkj->nj", along, weights)
        others = np.swapaxes(_orthogonal_complement(along), -1, -2) @ weights
        if others.shape[1] == 1:
            return np.where(size > 0.0, size / _minimum_sum(sums, others[:, 0]), 0.0)

        def norms(angle: FloatArray) -> FloatArray:
            turned = np.stack([np.cos(angle), np.sin(angle)], axis=-1) @ others
            return _minimum_sum(sums[:, np.newaxis], turned)

        step = np.pi / _DIRECTIONS
        grid = np.broadcast_to(step * np.arange(_DIRECTIONS), (size.size, _DIRECTIONS))
        best = step * np.argmin(norms(grid), axis=-1)
        minimum = grid_minimum(norms, best - step, best + step, _REFINEMENTS)[1]
    return np.where(size > 0.0, size / minimum, 0.0)


def _orthogonal_complement(along: FloatArray) -> FloatArray:
    """Return unit vectors orthogonal to ``(n, k)``, ``(n, k, k - 1)``, by a reflection."""
    first = np.where(along[:, :1] < 0.0, -1.0, 1.0)
    mirror = along.copy()
    mirror[:, :1] += first
    outer = mirror[..., np.newaxis] * mirror[:, np.newaxis, 1:]
    return np.asarray(
        np.eye(along.shape[-1])[:, 1:] - 2.0 * outer / np.sum(mirror**2, -1)[:, None, None]
    )


def _minimum_sum(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return min over u of sum |a + u b| over the last axis, at the weighted median of -a/b."""
    a = np.broadcast_to(a, b.shape)
    crossing = np.where(b == 0.0, np.inf, -a / b)
    order = np.argsort(crossing, axis=-1, kind="stable")
    weight = np.cumsum(np.take_along_axis(np.abs(b), order, axis=-1), axis=-1)
    middle = np.argmax(weight >= 0.5 * weight[..., -1:], axis=-1)[..., np.newaxis]
    u = np.take_along_axis(crossing, np.take_along_axis(order, middle, axis=-1), axis=-1)
    u = np.where(np.isfinite(u), u, 0.0)
    return np.asarray(np.sum(np.abs(a + u * b), axis=-1))
