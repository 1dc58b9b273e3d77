"""The least peak of any control over all growing modes, in the air that is met, in batches.

With the rows p_i of the growing modes, p' = -A^T p integrated backwards from the end of the wind,

    integral of p_i.b delta dt = -d_i,    d_i = p_i.x + integral of p_i.w alpha_w dt,

and the least peak of all delta that meet these is, by its dual (appendix C with varying weights),

    max over lambda of |lambda.d| / integral |lambda.h| dt,    h_i = p_i.b.

Backwards all rows turn to the fastest, so that they are set at right angles again after each step,
and what was found in their coordinates with them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IndexArray
from tvclin.numerics.searches import lowest

_TAIL = np.expm1(np.linspace(0.0, 8.0, 64)) / np.expm1(8.0)
"""Ends of the cells of a deflection after the wind, over `_SPAN` times of the slowest mode; the
last has no end."""
_TOGETHER = 4
"""Steps for which the rows turn to the fastest: as many for all, so that none depends on others."""
_SPAN, _DIRECTIONS, _ROUNDS = 30.0, 16, 6
"""Also: directions of lambda that are looked at where three modes grow, and refinements."""


@dataclass(frozen=True, eq=False)
class ModesMet:
    """What grows after the wind: poles [1/s] ``(n, k)`` and rows ``(n, k, m)``, A^T p = s p.

    Of a complex pair the one of positive frequency. `cases` are the places ``(n,)`` in a batch.
    """

    cases: IndexArray
    poles: AnyArray
    rows: AnyArray

    def reaches(self, column: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return real rows ``(n, k, m)`` and what cells after the wind do to them of b ``(n, m)``.

        That is the integral of p.b over each cell, ``(n, k, cells)``.
        """
        slowest = np.real(self.poles).min(axis=-1, keepdims=True)
        ends = _TAIL * _SPAN / slowest
        left = np.exp(-self.poles[..., np.newaxis] * ends[:, np.newaxis])
        left[..., -1] = 0.0
        pushed = np.vecdot(np.conj(self.rows), column[:, np.newaxis]) / self.poles
        cells = -pushed[..., np.newaxis] * np.diff(left, axis=-1)
        turns = np.imag(self.poles[0]) != 0.0
        rows = np.broadcast_to(self.rows, (len(column), *self.rows.shape[1:]))
        parts = [np.concatenate([one.real, one.imag[:, turns]], axis=1) for one in (rows, cells)]
        return parts[0], parts[1]


def modes_met(A: FloatArray) -> tuple[ModesMet, ...]:
    """Return the modes of ``A (n, m, m)`` after a wind where two or three grow, first a real one.

    Cases with as many real modes and pairs are together.
    """
    values, columns = np.linalg.eig(np.swapaxes(A, -1, -2))
    order = np.argsort(-np.real(values), axis=-1)
    values = np.take_along_axis(values, order, axis=-1)
    rows = np.swapaxes(np.take_along_axis(columns, order[:, np.newaxis], axis=-1), -1, -2)
    kept = (np.real(values) > 0.0) & (np.imag(values) >= 0.0)
    turns = kept & (np.imag(values) > 0.0)
    kinds = np.add(kept, turns, dtype=int)  # 0, 1 of a real mode, 2 of a pair
    found = []
    for kind in np.unique(kinds, axis=0):
        if kind[0] != 1 or not 2 <= kind.sum() <= 3:
            continue
        some = np.flatnonzero(np.all(kinds == kind, axis=-1))
        poles, own = values[some][:, kind > 0], rows[some][:, kind > 0]
        if not np.any(kind == 2):
            poles, own = np.real(poles), np.real(own)
        found.append(ModesMet(some, poles, own))
    return tuple(found)


def least_met(
    modes: ModesMet,
    times: FloatArray,
    both: FloatArray,
    wind: FloatArray,
    drifted: FloatArray,
    every: bool,
) -> FloatArray:
    """Return the least peaks [rad] of all control from ends of steps on, ``(ends, n)``.

    Of `every` one, or of the first alone, ``(1, n)``.
    `times` are ends of steps and their middles by turns [s], ``(k, n)``; `both` A beside the
    columns of deflection and wind there, ``(k, n, m, m + 2)``; `wind` [rad] ``(k, n)``; `drifted`
    the states that trim has left at the ends, the last ones, ``(ends, n, m - 2)``.
    """
    m, count = both.shape[-2], times.shape[0]
    drifted = np.pad(drifted, ((0, 0), (0, 0), (m - drifted.shape[-1], 0)))
    rows, cells = modes.reaches(both[-1, :, :, m])
    held = np.concatenate([np.zeros((*rows.shape[:2], count // 2)), cells], axis=-1)
    to_come = np.zeros((*rows.shape[:2], 1))
    found = []

    def rates(j: int, p: FloatArray) -> FloatArray:
        rate = p @ both[j]
        rate[..., m + 1] *= wind[j][:, np.newaxis]
        return np.asarray(rate)

    def ahead(j: int, p: FloatArray, h: FloatArray, rate: FloatArray) -> FloatArray:
        return rates(j, p + h * rate[..., :m])

    for i in range(count // 2, -1, -1):
        if 2 * i < count - 1:
            c, b, a = 2 * i + 2, 2 * i + 1, 2 * i
            h = (times[c] - times[a])[:, np.newaxis, np.newaxis]
            first = rates(c, rows)
            second = ahead(b, rows, 0.5 * h, first)
            third = ahead(b, rows, 0.5 * h, second)
            last = ahead(a, rows, h, third)
            step = h / 6.0 * (first + 2.0 * (second + third) + last)
            rows = rows + step[..., :m]
            held[..., i] = step[..., m]
            to_come = to_come + step[..., m + 1 :]
        if i == 0 or (count // 2 - i) % _TOGETHER == 0:
            square, below = np.linalg.qr(np.swapaxes(rows, -1, -2))
            turn = np.linalg.inv(np.swapaxes(below, -1, -2))
            rows, to_come = np.swapaxes(square, -1, -2), turn @ to_come
            held[..., i:] = turn @ held[..., i:]
        if every or i == 0:
            demand = np.vecdot(rows, drifted[i][:, np.newaxis]) + to_come[..., 0]
            found.append(_least(held[..., i:], demand))
    return np.stack(found[::-1])


def _least(held: FloatArray, demand: FloatArray) -> FloatArray:
    """Max over lambda of lambda.d / sum |lambda.h| for h ``(n, k, cells)`` and d ``(n, k)``."""
    size = np.linalg.norm(demand, axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        along = demand / size[:, np.newaxis]
        sums = np.einsum("nk,nkj->nj", along, held)
        across = _across(along)  # (n, k, k - 1)
        others = np.swapaxes(across, -1, -2) @ held
        if others.shape[1] == 1:
            return np.where(size > 0.0, size / _least_sum(sums, others[:, 0]), 0.0)

        def norms(angle: FloatArray) -> FloatArray:
            turned = np.stack([np.cos(angle), np.sin(angle)], axis=-1) @ others
            return _least_sum(sums[:, np.newaxis], turned)

        step = np.pi / _DIRECTIONS
        grid = np.broadcast_to(step * np.arange(_DIRECTIONS), (size.size, _DIRECTIONS))
        best = step * np.argmin(norms(grid), axis=-1)
        least = lowest(norms, best - step, best + step, _ROUNDS)[1]
    return np.where(size > 0.0, size / least, 0.0)


def _across(along: FloatArray) -> FloatArray:
    """Return unit vectors at right angles to ``(n, k)``, ``(n, k, k - 1)``: Householder's."""
    first = np.where(along[:, :1] < 0.0, -1.0, 1.0)
    turned = along.copy()
    turned[:, :1] += first
    outer = turned[..., np.newaxis] * turned[:, np.newaxis, 1:]
    return np.asarray(
        np.eye(along.shape[-1])[:, 1:] - 2.0 * outer / np.sum(turned**2, -1)[:, None, None]
    )


def _least_sum(a: FloatArray, b: FloatArray) -> FloatArray:
    """Min over u of sum |a + u b| over the last axis: at the weighted median of -a/b."""
    a = np.broadcast_to(a, b.shape)
    crossing = np.where(b == 0.0, np.inf, -a / b)
    order = np.argsort(crossing, axis=-1, kind="stable")
    weight = np.cumsum(np.take_along_axis(np.abs(b), order, axis=-1), axis=-1)
    middle = np.argmax(weight >= 0.5 * weight[..., -1:], axis=-1)[..., np.newaxis]
    u = np.take_along_axis(crossing, np.take_along_axis(order, middle, axis=-1), axis=-1)
    u = np.where(np.isfinite(u), u, 0.0)
    return np.asarray(np.sum(np.abs(a + u * b), axis=-1))
