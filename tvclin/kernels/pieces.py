"""Piecewise exponential polynomials: the arithmetic under every wind and deflection.

Between knot i and knot i+1, with the local time u = t - knot_i, a history is

    f(t) = sum over r, k of c[i, r, k] u^k e^(lambda_r u)

The last piece lasts for ever, and before the first knot the history is zero. The family
is closed under sums, shifts, cuts and first-order lags, and its Laplace integrals are
sums of exponential moments, so nothing here is ever sampled or truncated.
"""

from dataclasses import dataclass
from math import comb, factorial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.moments import moments

_NEAR = 0.25
"""A rate within this of a lag's pole, times the width, counts as resonant."""
_TAYLOR_TERMS = 13
"""0.25^13/13! is below 1e-17: the expansion of a resonant term is exact to rounding."""


@dataclass(frozen=True, slots=True)
class Pieces:
    """Knots ``(..., n)``, coefficients ``(..., n, rates, degree + 1)`` and rates ``(..., rates)``.

    Knots do not decrease; a piece of no width is legal and counts for nothing.
    """

    knots: NDArray[np.float64]
    coefficients: NDArray[Any]
    rates: NDArray[Any]

    @property
    def degree(self) -> int:
        """The highest power of the local time."""
        return self.coefficients.shape[-1] - 1

    @property
    def batch(self) -> tuple[int, ...]:
        """The leading axes: one history is the batch of shape ``()``."""
        return np.broadcast_shapes(
            self.knots.shape[:-1], self.coefficients.shape[:-3], self.rates.shape[:-1]
        )

    @property
    def widths(self) -> NDArray[np.float64]:
        """How long each piece lasts, ``(..., n)``; the last one for ever."""
        return np.diff(self.knots, axis=-1, append=np.inf)


def value(pieces: Pieces, t: NDArray[np.float64]) -> NDArray[Any]:
    """Return the values at the times ``t (..., m)``, whose leading axes broadcast with the batch.

    Continuous from the right; shape ``broadcast(batch, t.shape[:-1]) + (m,)``.
    """
    index, u = _locate(pieces, t)
    result = _evaluate(_at(pieces.coefficients, index, 2), pieces.rates, np.maximum(u, 0.0))
    return np.where(u < 0.0, 0.0, result)


def laplace(pieces: Pieces, s: NDArray[Any]) -> NDArray[Any]:
    """Return the Laplace integral over the whole history at `s`, which broadcasts with the batch.

    Infinite where the last piece does not die out faster than e^(s t) grows.
    """
    integrals = _integrals(pieces.coefficients, pieces.rates, pieces.widths, s)
    return np.asarray((np.exp(-s[..., np.newaxis] * pieces.knots) * integrals).sum(axis=-1))


def magnitude(pieces: Pieces, s: NDArray[Any]) -> NDArray[np.float64]:
    """Return the sum of the sizes of all terms of `laplace`: its rounding error per epsilon."""
    sizes = Pieces(pieces.knots, np.abs(pieces.coefficients), np.real(pieces.rates))
    return laplace(sizes, np.real(s))


def future(pieces: Pieces, s: NDArray[Any], t: NDArray[np.float64]) -> NDArray[Any]:
    """Return the discounted future, the integral from t on of e^(-s (r - t)) f(r) dr.

    At the times ``t (..., m)``, as in `value`; `s` broadcasts with the batch. Every exponential
    in it decays, so an unstable mode that is not excited stays exact however late the time.
    """
    at_knots = _future_at_knots(pieces, s)
    after = np.concatenate([at_knots[..., 1:], np.zeros_like(at_knots[..., :1])], axis=-1)
    index, u = _locate(pieces, t)
    early = u < 0.0
    u = np.maximum(u, 0.0)
    here = _moved(_at(pieces.coefficients, index, 2), pieces.rates, u)
    left = np.maximum(_at(pieces.widths, index, 0) - u, 0.0)
    column = s[..., np.newaxis]
    rest = _integrals(here, pieces.rates, left, s)
    endless = np.isinf(left)
    decay = np.exp(-column * np.where(endless, 0.0, left))
    tail = np.where(endless, 0.0, decay * _at(after, index, 0))
    lead = np.exp(-column * np.maximum(pieces.knots[..., :1] - t, 0.0)) * at_knots[..., :1]
    return np.where(early, lead, rest + tail)


def past(pieces: Pieces, pole: NDArray[Any], t: NDArray[np.float64]) -> NDArray[Any]:
    """Return the discounted past, the integral up to t of e^(pole (t - r)) f(r) dr.

    At the times ``t (..., m)``, as in `value`; `pole` broadcasts with the batch. It is the
    answer of a first-order lag at the time t; accurate for poles that do not grow.
    """
    shape = np.broadcast_shapes(pieces.batch, pole.shape)
    index, u = _locate(pieces, t)
    u = np.maximum(u, 0.0)
    here = _moved(_at(pieces.coefficients, index, 2), pieces.rates, u)
    # Seen backwards from t, the part of the piece before t is an integral over -u.
    part = -_integrals(here, pieces.rates, -u, pole)
    carried = _at(_states(pieces, pole, shape), index, 0)
    return np.asarray(np.exp(pole[..., np.newaxis] * u) * carried + part)


def lag(pieces: Pieces, pole: NDArray[Any]) -> Pieces:
    """Return y with y' = pole y + f and y = 0 before the first knot; the pole joins the rates.

    Where a rate is so near to the pole that their difference would cancel, the answer is
    written as a polynomial times e^(pole u) instead of a difference of two exponentials.
    """
    shape = np.broadcast_shapes(pieces.batch, pole.shape)
    rates = np.broadcast_to(pieces.rates, (*shape, pieces.rates.shape[-1]))
    gap = rates - pole[..., np.newaxis]
    width = pieces.widths[..., np.newaxis]
    with np.errstate(invalid="ignore"):
        span = np.abs(gap)[..., np.newaxis, :] * width
    near = np.where(np.isnan(span), True, span < _NEAR)
    near &= np.any(pieces.coefficients != 0.0, axis=-1)
    terms = _TAYLOR_TERMS if np.any(near & (gap[..., np.newaxis, :] != 0.0)) else 1
    degree = pieces.degree + (terms if np.any(near) else 0)
    c = np.broadcast_to(pieces.coefficients, (*near.shape, pieces.degree + 1))
    far_part = _particular(np.where(near[..., np.newaxis], 0.0, c), gap)
    near_part = _resonant(np.where(near[..., np.newaxis], c, 0.0), gap, degree)
    own = near_part.sum(axis=-2)
    own[..., 0] = own[..., 0] - far_part[..., 0].sum(axis=-1)
    own[..., 0] = own[..., 0] + _states(pieces, pole, shape)
    out = np.zeros((*own.shape[:-1], rates.shape[-1] + 1, degree + 1), dtype=own.dtype)
    out[..., :-1, : far_part.shape[-1]] = far_part
    out[..., -1, :] = own
    poles = np.broadcast_to(pole[..., np.newaxis], (*shape, 1))
    return Pieces(pieces.knots, out, np.concatenate([rates, poles], axis=-1))


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
    if np.array_equal(rates[0], rates[1]):
        return Pieces(merged, c[0] + c[1], rates[0])
    return Pieces(merged, np.concatenate(c, axis=-2), np.concatenate(rates, axis=-1))


def before(pieces: Pieces, time: NDArray[np.float64]) -> Pieces:
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


def take(pieces: Pieces, index: NDArray[np.intp]) -> Pieces:
    """Return the histories at the positions `index` ``(k,)`` of the flattened batch."""
    shape = pieces.batch or (1,)
    pieces, where = spread(pieces, shape), np.unravel_index(index, shape)
    return Pieces(pieces.knots[where], pieces.coefficients[where], pieces.rates[where])


def _locate(pieces: Pieces, t: NDArray[np.float64]) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """The piece in which each time lies, and the local time there (negative: before the first)."""
    index = np.maximum(_last_at_or_before(pieces.knots, t), 0)
    return index, t - _at(pieces.knots, index, 0)


def _last_at_or_before(knots: NDArray[np.float64], t: NDArray[np.float64]) -> NDArray[np.intp]:
    if knots.ndim == 1:
        return np.searchsorted(knots, t, side="right") - 1
    return np.sum(knots[..., np.newaxis, :] <= t[..., np.newaxis], axis=-1) - 1


def _at(array: NDArray[Any], index: NDArray[np.intp], trailing: int) -> NDArray[Any]:
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


def _evaluate(c: NDArray[Any], rates: NDArray[Any], u: NDArray[np.float64]) -> NDArray[Any]:
    """Sum the terms ``c (..., m, rates, degree + 1)`` at the local times ``u (..., m)``."""
    u = u[..., np.newaxis]
    polynomial = c[..., -1]
    for k in range(c.shape[-1] - 2, -1, -1):
        polynomial = polynomial * u + c[..., k]
    return np.asarray((polynomial * np.exp(rates[..., np.newaxis, :] * u)).sum(axis=-1))


def _moved(c: NDArray[Any], rates: NDArray[Any], u: NDArray[np.float64]) -> NDArray[Any]:
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
    return np.stack(columns, axis=-1) * growth[..., np.newaxis]


def _integrals(
    c: NDArray[Any], rates: NDArray[Any], widths: NDArray[np.float64], s: NDArray[Any]
) -> NDArray[Any]:
    """Integrate each piece times e^(-s u) over its width, ``(..., m)``."""
    excess = s[..., np.newaxis] - rates
    excess = excess[..., np.newaxis, :]
    endless = np.isinf(widths)
    width = np.where(endless, 0.0, widths)[..., np.newaxis]
    powers = np.cumprod(np.repeat(width[..., np.newaxis], c.shape[-1], axis=-1), axis=-1)
    result = (c * powers * moments(excess * width, c.shape[-1] - 1)).sum(axis=(-2, -1))
    if not np.any(endless):
        return np.asarray(result)
    factorials = np.array([factorial(k) for k in range(c.shape[-1])], dtype=float)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        tails = factorials / excess[..., np.newaxis] ** np.arange(1, c.shape[-1] + 1)
        dying = (np.real(excess) > 0.0)[..., np.newaxis]
        tails = np.where(c == 0.0, 0.0, np.where(dying, c * tails, np.inf)).sum(axis=(-2, -1))
    return np.where(endless, tails, result)


def _future_at_knots(pieces: Pieces, s: NDArray[Any]) -> NDArray[Any]:
    integrals = _integrals(pieces.coefficients, pieces.rates, pieces.widths, s)
    decay = np.exp(-s[..., np.newaxis] * np.diff(pieces.knots, axis=-1))
    result = np.array(integrals)
    for i in range(result.shape[-1] - 2, -1, -1):
        result[..., i] += decay[..., i] * result[..., i + 1]
    return result


def _states(pieces: Pieces, pole: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """The lag's value at each knot, ``(..., n)``, carried exactly from knot to knot."""
    width = np.diff(pieces.knots, axis=-1)
    c = pieces.coefficients[..., :-1, :, :]
    # Seen backwards from its end a piece is an integral with the pole as Laplace variable.
    forced = _integrals(_moved(c, pieces.rates, width), pieces.rates, -width, pole)
    growth = np.exp(pole[..., np.newaxis] * width)
    forced, growth = (np.broadcast_to(a, (*shape, width.shape[-1])) for a in (-forced, growth))
    state = np.zeros((*shape, width.shape[-1] + 1), dtype=np.result_type(forced, growth))
    for i in range(width.shape[-1]):
        state[..., i + 1] = growth[..., i] * state[..., i] + forced[..., i]
    return state


def _particular(c: NDArray[Any], gap: NDArray[Any]) -> NDArray[Any]:
    """The polynomial a with a' + gap a = c, for each rate off the pole."""
    gap = np.where(gap == 0.0, 1.0, gap)[..., np.newaxis, :]
    result = np.zeros(c.shape, dtype=np.result_type(c, gap))
    above = np.zeros_like(result[..., 0])
    for k in range(c.shape[-1] - 1, -1, -1):
        above = (c[..., k] - (k + 1) * above) / gap
        result[..., k] = above
    return result


def _resonant(c: NDArray[Any], gap: NDArray[Any], degree: int) -> NDArray[Any]:
    """The polynomial, times e^(pole u), that answers a rate on or near the pole."""
    gap = gap[..., np.newaxis, :]
    result = np.zeros((*c.shape[:-1], degree + 1), dtype=np.result_type(c, gap))
    for k in range(c.shape[-1]):
        term = c[..., k]
        for j in range(degree - k):
            result[..., k + j + 1] += term / (k + j + 1)
            term = term * gap / (j + 1)
    return result


def _on_knots(pieces: Pieces, knots: NDArray[np.float64]) -> NDArray[Any]:
    """The coefficients of the same history on finer knots, zero before its first."""
    index = _last_at_or_before(pieces.knots, knots)
    own = np.maximum(index, 0)
    u = np.maximum(knots - _at(pieces.knots, own, 0), 0.0)
    c = _moved(_at(pieces.coefficients, own, 2), pieces.rates, u)
    return np.where((index < 0)[..., np.newaxis, np.newaxis], 0.0, c)


def _widened(c: NDArray[Any], degree: int) -> NDArray[Any]:
    extra = degree + 1 - c.shape[-1]
    return np.pad(c, [(0, 0)] * (c.ndim - 1) + [(0, extra)])
