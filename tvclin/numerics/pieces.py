"""Piecewise exponential polynomials: the arithmetic under every wind and deflection.

Between knot i and knot i+1, with the local time u = t - knot_i, a history is

    f(t) = sum over r, k of c[i, r, k] u^k e^(lambda_r u)

The last piece lasts for ever, and before the first knot the history is zero. The family
is closed under sums, shifts, cuts and first-order lags, and its Laplace integrals are
sums of exponential moments, so nothing here is ever sampled or truncated. `integrals` and
`lags` stand beside this file.
"""

from dataclasses import dataclass
from math import comb
from typing import Any

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IndexArray

_FEW = 4096
"""Up to so many pairs of a knot and a time all are compared at once."""


@dataclass(frozen=True)
class Pieces:
    """Knots ``(..., n)``, coefficients ``(..., n, rates, degree + 1)`` and rates ``(..., rates)``.

    Knots do not decrease; a piece of no width is legal and counts for nothing.
    """

    knots: FloatArray
    coefficients: AnyArray
    rates: AnyArray

    @property
    def degree(self) -> int:
        """The highest power of the local time."""
        return self.coefficients.shape[-1] - 1

    @property
    def batch(self) -> tuple[int, ...]:
        """The leading axes: one history is the batch of shape ``()``."""
        if self.knots.ndim == 1 and self.coefficients.ndim == 3 and self.rates.ndim == 1:
            return ()
        return np.broadcast_shapes(
            self.knots.shape[:-1], self.coefficients.shape[:-3], self.rates.shape[:-1]
        )

    @property
    def widths(self) -> FloatArray:
        """How long each piece lasts, ``(..., n)``; the last one for ever."""
        return np.diff(self.knots, axis=-1, append=np.inf)


def flat(array: AnyArray, trailing: int, kind: Any) -> AnyArray:
    """Return an array with its batch on one axis, in the one kind of memory that kernels take."""
    one = array.ndim == trailing
    rows = array[np.newaxis] if one else array.reshape(-1, *array.shape[array.ndim - trailing :])
    flags = rows.flags
    if rows.dtype == kind and flags.c_contiguous and flags.writeable:
        return rows
    return np.array(rows, dtype=kind, order="C")


def rows(
    pieces: Pieces, shape: tuple[int, ...]
) -> tuple[tuple[AnyArray, AnyArray, AnyArray], IndexArray]:
    """Return knots, coefficients and rates for kernels, and which row each case of `shape` takes.

    Histories on one axis, as many as there are; the cases that share one share its row. All can be
    written to, for a kernel is compiled anew for arrays that can not.
    """
    own = spread(pieces, pieces.batch)
    kind = np.result_type(pieces.coefficients, pieces.rates, float)
    coefficients, rates = flat(own.coefficients, 3, kind), flat(own.rates, 1, kind)
    arrays = flat(own.knots, 1, np.dtype(float)), coefficients, rates
    which = np.arange(arrays[0].shape[0]).reshape(pieces.batch)
    return arrays, np.broadcast_to(which, shape).flatten()


def value(pieces: Pieces, t: FloatArray) -> AnyArray:
    """Return the values at the times ``t (..., m)``, whose leading axes broadcast with the batch.

    Continuous from the right; shape ``broadcast(batch, t.shape[:-1]) + (m,)``.
    """
    index, u = locate(pieces, t)
    result = _evaluate(at_pieces(pieces.coefficients, index, 2), pieces.rates, np.maximum(u, 0.0))
    return np.where(u < 0.0, 0.0, result)


def add(first: Pieces, second: Pieces) -> Pieces:
    """Return the sum, on the knots of both."""
    shape = np.broadcast_shapes(first.batch, second.batch)
    knots = [np.broadcast_to(p.knots, (*shape, p.knots.shape[-1])) for p in (first, second)]
    if np.array_equal(knots[0], knots[1]):
        merged = knots[0]
    else:
        merged = np.sort(np.concatenate(knots, axis=-1), axis=-1)
        merged = merged if shape else np.unique(merged)
    degree = max(first.degree, second.degree)
    both = [_widened(_on_knots(p, merged), degree) for p in (first, second)]
    c = [np.broadcast_to(a, (*shape, merged.shape[-1], *a.shape[-2:])) for a in both]
    rates = [np.broadcast_to(p.rates, (*shape, p.rates.shape[-1])) for p in (first, second)]
    shorter, longer = sorted((0, 1), key=lambda i: rates[i].shape[-1])
    count = rates[shorter].shape[-1]
    if np.array_equal(rates[shorter], rates[longer][..., :count]):
        total = c[longer].copy()
        total[..., :count, :] += c[shorter]
        return Pieces(merged, total, rates[longer])
    return Pieces(merged, np.concatenate(c, axis=-2), np.concatenate(rates, axis=-1))


def before(pieces: Pieces, time: FloatArray) -> Pieces:
    """Return the history up to `time` and zero from there on; an infinite time changes nothing."""
    shape = np.broadcast_shapes(pieces.batch, time.shape)
    edge = time[..., np.newaxis]
    own = np.broadcast_to(pieces.knots, (*shape, pieces.knots.shape[-1]))
    knots = np.minimum(own, edge)
    final = np.where(np.isinf(edge), own[..., -1:], np.maximum(edge, knots[..., -1:]))
    c = np.broadcast_to(pieces.coefficients, (*shape, *pieces.coefficients.shape[-3:]))
    last = np.where(np.isinf(edge)[..., np.newaxis, np.newaxis], c[..., -1:, :, :], 0.0)
    return Pieces(
        np.concatenate([knots, final], axis=-1), np.concatenate([c, last], axis=-3), pieces.rates
    )


def spread(pieces: Pieces, shape: tuple[int, ...]) -> Pieces:
    """Return the same histories as a batch of the shape `shape`, which they broadcast to."""
    return Pieces(
        np.broadcast_to(pieces.knots, (*shape, *pieces.knots.shape[-1:])),
        np.broadcast_to(pieces.coefficients, (*shape, *pieces.coefficients.shape[-3:])),
        np.broadcast_to(pieces.rates, (*shape, *pieces.rates.shape[-1:])),
    )


def take(pieces: Pieces, index: IndexArray) -> Pieces:
    """Return the histories at the positions `index` ``(k,)`` of the flattened batch."""
    shape = pieces.batch or (1,)
    pieces, where = spread(pieces, shape), np.unravel_index(index, shape)
    return Pieces(pieces.knots[where], pieces.coefficients[where], pieces.rates[where])


def locate(pieces: Pieces, t: FloatArray) -> tuple[IndexArray, FloatArray]:
    """The piece in which each time lies, and the local time there (negative: before the first)."""
    index = np.maximum(_last_at_or_before(pieces.knots, t), 0)
    return index, t - at_pieces(pieces.knots, index, 0)


def _last_at_or_before(knots: FloatArray, t: FloatArray) -> IndexArray:
    if knots.size and not any(knots.strides[:-1]):  # one row of knots for the whole batch
        return np.searchsorted(knots[(0,) * (knots.ndim - 1)], t, side="right") - 1
    if knots.shape[-1] * t.shape[-1] <= _FEW:
        return np.sum(knots[..., np.newaxis, :] <= t[..., np.newaxis], axis=-1) - 1
    shape = np.broadcast_shapes(knots.shape[:-1], t.shape[:-1])
    rows = np.broadcast_to(knots, (*shape, knots.shape[-1])).reshape(-1, knots.shape[-1])
    times = np.broadcast_to(t, (*shape, t.shape[-1])).reshape(-1, t.shape[-1])
    found = [np.searchsorted(row, x, side="right") for row, x in zip(rows, times, strict=True)]
    return np.array(found, dtype=np.intp).reshape(*shape, t.shape[-1]) - 1


def at_pieces(array: AnyArray, index: IndexArray, trailing: int) -> AnyArray:
    """Take pieces ``(..., n, *trailing)`` by `index` ``(..., m)``; the leading axes broadcast."""
    axis = array.ndim - 1 - trailing
    if axis == 0:
        return array[index]
    if index.ndim == 1:
        return np.take(array, index, axis=axis)
    shape = np.broadcast_shapes(array.shape[:axis], index.shape[:-1])
    array = np.broadcast_to(array, (*shape, *array.shape[axis:]))
    index = np.broadcast_to(index, (*shape, index.shape[-1]))
    return np.take_along_axis(array, index.reshape(*index.shape, *(1,) * trailing), axis=len(shape))


def moved(c: AnyArray, rates: AnyArray, u: FloatArray) -> AnyArray:
    """The same pieces with their local time starting at ``u (..., m)`` instead of zero."""
    order = c.shape[-1]
    step = u[..., np.newaxis]
    columns = []
    for low in range(order):
        column = c[..., order - 1] * comb(order - 1, low)
        for k in range(order - 2, low - 1, -1):
            column = column * step + comb(k, low) * c[..., k]
        columns.append(column)
    growth = np.exp(rates[..., np.newaxis, :] * step)
    return np.stack(np.broadcast_arrays(*columns), axis=-1) * growth[..., np.newaxis]


def _evaluate(c: AnyArray, rates: AnyArray, u: FloatArray) -> AnyArray:
    """Sum the terms ``c (..., m, rates, degree + 1)`` at the local times ``u (..., m)``."""
    u = u[..., np.newaxis]
    polynomial = c[..., -1]
    for k in range(c.shape[-1] - 2, -1, -1):
        polynomial = polynomial * u + c[..., k]
    return np.asarray((polynomial * np.exp(rates[..., np.newaxis, :] * u)).sum(axis=-1))


def _on_knots(pieces: Pieces, knots: FloatArray) -> AnyArray:
    """The coefficients of the same history on finer knots, zero before its first."""
    index = _last_at_or_before(pieces.knots, knots)
    own = np.maximum(index, 0)
    u = np.maximum(knots - at_pieces(pieces.knots, own, 0), 0.0)
    c = moved(at_pieces(pieces.coefficients, own, 2), pieces.rates, u)
    return np.where((index < 0)[..., np.newaxis, np.newaxis], 0.0, c)


def _widened(c: AnyArray, degree: int) -> AnyArray:
    extra = degree + 1 - c.shape[-1]
    return np.pad(c, [(0, 0)] * (c.ndim - 1) + [(0, extra)])
