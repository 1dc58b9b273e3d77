"""Piecewise exponential polynomials: the arithmetic under every wind and deflection.

Between knot i and knot i+1, with the local time u = t - knot_i, a history is

    f(t) = sum over r, k of c[i, r, k] u^k e^(lambda_r u).

The last piece is endless, and before the first knot the history is zero. The family is closed
under sums, shifts, cuts and first-order lags. Its Laplace integrals are sums of the exponential
moments

    M_k(z) = integral from 0 to 1 of x^k e^(-z x) dx,    k = 0 ... degree,

so that nothing is sampled or truncated. The moments are entire in z, and nothing is lost where z
tends to zero: the textbook form (1 - e^(-z))/z and its higher relatives are never divided out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from math import comb, factorial, prod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray

_MAX_COMPARED_KNOTS = 16
"""Number of knots up to which each is compared with all times."""
_RESONANT_SPAN = 0.25
"""Largest |rate - pole| times the width at which a term is expanded as resonant."""
_TAYLOR_TERMS = 13
"""0.25^13/13! is below 1e-17: the expansion of a resonant term is exact to rounding."""
_SPLIT_SPANS = 16.0
"""The piece split off an endless one stays resonant for later lags with gaps so many times as
wide."""
_DECAYED_EXPONENT = 60.0
"""Exponent at which a decaying term is negligible: e^-60 of its initial value."""
_OVERFLOW_EXPONENT = 600.0
"""Exponent beyond which an unstable term is not followed: e^600."""
_PIECE_LENGTH_TIMES_RATE = 0.5
"""Longest piece on which an exponential becomes a polynomial, times its rate."""
_POLYNOMIAL_DEGREE = 10
"""Degree of that polynomial: its error, 0.5^11/11!, is below 2e-11."""


def moments(z: ArrayLike, degree: int) -> AnyArray:
    """Return M_0(z) ... M_degree(z), shape ``(..., degree + 1)``, real for a real z.

    M_k(z) is the integral from 0 to 1 of x^k e^(-z x) dx. The recursion z M_k = k M_(k-1) - e^(-z)
    loses digits upward where k > |z| and downward where k < |z|, so each order is taken from the
    direction that is stable for it.
    """
    z = np.asarray(z)
    z = z.astype(complex if np.iscomplexobj(z) else float)
    orders = np.arange(degree + 1)
    size = np.abs(z)
    small = size <= degree + 1.5
    # What the downward recursion starts from is wrong by a relative 1, and each order j multiplies
    # that by |z|/j; with |z| <= degree + 1.5 so many more orders bring it below 1e-16.
    start = 3 * degree + 26
    downward = np.empty((*z.shape, degree + 1), dtype=z.dtype)
    z_down = np.where(small, z, 0.0)
    decay, moment = np.exp(-z_down), np.zeros_like(z)
    for order in range(start, 0, -1):
        moment = (z_down * moment + decay) / order  # M_(order-1)
        if order <= degree + 1:
            downward[..., order - 1] = moment
    if np.all(size <= 1.0):
        return downward
    upward, z_up = np.empty_like(downward), np.where(size > 1.0, z, 2.0)
    with np.errstate(over="ignore", invalid="ignore"):
        decay = np.exp(-z_up)
        upward[..., 0] = -np.expm1(-z_up) / z_up
        for order in range(1, degree + 1):
            upward[..., order] = (order * upward[..., order - 1] - decay) / z_up
    upward[np.isinf(decay)] = np.inf
    use_upward = (size[..., np.newaxis] > np.maximum(orders, 1.0)) | ~small[..., np.newaxis]
    return np.where(use_upward, upward, downward)


@dataclass(frozen=True)
class Pieces:
    """Pieces of histories, sums of c u^k e^(rate u), with the time u [s] since a piece's knot.

    `knots` [s], ``(..., n)``; they do not decrease, and a piece of zero width contributes nothing.
    `coefficients` c, ``(..., n, rates, degree + 1)``. `rates` [1/s] of the exponentials, the same
    for all pieces, ``(..., rates)``; zero for a polynomial.
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
            return ()  # as below, which takes longer
        return np.broadcast_shapes(
            self.knots.shape[:-1], self.coefficients.shape[:-3], self.rates.shape[:-1]
        )

    @property
    def widths(self) -> FloatArray:
        """Width of each piece [s], ``(..., n)``; the last is infinite."""
        return np.diff(self.knots, axis=-1, append=np.inf)


def flat_batch(array: AnyArray, trailing: int, kind: Any) -> AnyArray:
    """Return an array with its batch on one axis, C-contiguous and writeable as kernels expect.

    `array`: ``(..., *shape)``. `trailing`: number of the last axes, as in `shape`, which stay.
    `kind`: dtype of the result.
    """
    single = array.ndim == trailing
    rows = array[np.newaxis] if single else array.reshape(-1, *array.shape[array.ndim - trailing :])
    flags = rows.flags
    if rows.dtype == kind and flags.c_contiguous and flags.writeable:
        return rows
    return np.array(rows, dtype=kind, order="C")


def flat_arrays(pieces: Pieces, kind: Any) -> tuple[FloatArray, AnyArray, AnyArray]:
    """Return knots ``(k, n)``, coefficients ``(k, n, rates, degree + 1)``, rates ``(k, rates)``.

    For kernels: the arrays of `pieces` of k histories with n knots, the batch on one axis. `kind`:
    dtype of the coefficients and of the rates.
    """
    return (
        flat_batch(pieces.knots, 1, np.dtype(float)),
        flat_batch(pieces.coefficients, 3, kind),
        flat_batch(pieces.rates, 1, kind),
    )


def kernel_arrays(
    pieces: Pieces, shape: tuple[int, ...]
) -> tuple[tuple[AnyArray, AnyArray, AnyArray], IndexArray]:
    """Return knots, coefficients and rates for kernels, and the row of each case of a batch.

    The arrays have one row for each history of `pieces`; cases of one history share its row. All
    are writeable, for a kernel is compiled anew for read-only arrays. `shape`: of the batch of
    cases, to which the histories broadcast.
    """
    kind = np.result_type(pieces.coefficients, pieces.rates, float)
    arrays = flat_arrays(spread(pieces, pieces.batch), kind)
    which = np.arange(arrays[0].shape[0]).reshape(pieces.batch)
    return arrays, np.broadcast_to(which, shape).flatten()


def value(pieces: Pieces, t: FloatArray) -> AnyArray:
    """Return the values of histories at the times `t` ``(..., m)`` [s], continuous from the right.

    Shape ``broadcast(batch, t.shape[:-1]) + (m,)``: the leading axes of the times broadcast with
    the batch of `pieces`.
    """
    index, since_knot = locate(pieces, t)
    c = at_pieces(pieces.coefficients, index, trailing=2)
    u = np.maximum(since_knot, 0.0)[..., np.newaxis]
    terms = c[..., -1]  # (..., m, rates), by Horner's scheme
    for k in range(c.shape[-1] - 2, -1, -1):
        terms = terms * u + c[..., k]
    if pieces.rates.any():
        terms = terms * np.exp(pieces.rates[..., np.newaxis, :] * u)
    total = reduce(np.add, np.moveaxis(terms, -1, 0))  # numpy is slow along short axes
    return np.where(since_knot < 0.0, 0.0, total)


def add(first: Pieces, second: Pieces) -> Pieces:
    """Return the sum of two batches of histories, which broadcast, on the knots of both.

    It has the rates of both. Where the rates of one history begin with the other's, they are
    not repeated, and the coefficients are added. Coefficients have the axes knots, rates, powers.
    """
    shape = np.broadcast_shapes(first.batch, second.batch)
    knots = [np.broadcast_to(p.knots, (*shape, p.knots.shape[-1])) for p in (first, second)]
    if np.array_equal(knots[0], knots[1]):
        merged = knots[0]
    else:
        merged = np.sort(np.concatenate(knots, axis=-1), axis=-1)
        merged = merged if shape else np.unique(merged)
    degree = max(first.degree, second.degree)
    c = []
    for p in (first, second):
        # coefficients of the history about each merged knot, from the piece in which that lies, at
        # its local time u; zero before the first knot of the history
        index = _last_at_or_before(p.knots, merged)
        piece = np.maximum(index, 0)
        u = np.maximum(merged - at_pieces(p.knots, piece, trailing=0), 0.0)
        terms = recentred(at_pieces(p.coefficients, piece, trailing=2), p.rates, u)
        terms = np.where((index < 0)[..., np.newaxis, np.newaxis], 0.0, terms)
        padding = [(0, 0)] * (terms.ndim - 1) + [(0, degree - p.degree)]  # zeros up to the degree
        terms = np.pad(terms, padding)
        c.append(np.broadcast_to(terms, (*shape, merged.shape[-1], *terms.shape[-2:])))
    rates = [np.broadcast_to(p.rates, (*shape, p.rates.shape[-1])) for p in (first, second)]
    shorter, longer = sorted((0, 1), key=lambda i: rates[i].shape[-1])
    count = rates[shorter].shape[-1]
    if np.array_equal(rates[shorter], rates[longer][..., :count]):
        total = c[longer].copy()
        total[..., :count, :] += c[shorter]
        return Pieces(merged, total, rates[longer])
    return Pieces(merged, np.concatenate(c, axis=-2), np.concatenate(rates, axis=-1))


def before(pieces: Pieces, time: FloatArray) -> Pieces:
    """Return the histories up to `time` ``(...)`` [s], zero from there on.

    An infinite time leaves the histories of `pieces` as they are.
    """
    shape = np.broadcast_shapes(pieces.batch, time.shape)
    # Knots after the end move to it, so that their pieces have no width; one more piece is zero.
    edge = time[..., np.newaxis]
    original = np.broadcast_to(pieces.knots, (*shape, pieces.knots.shape[-1]))
    knots = np.minimum(original, edge)
    final = np.where(np.isinf(edge), original[..., -1:], np.maximum(edge, knots[..., -1:]))
    c = np.broadcast_to(pieces.coefficients, (*shape, *pieces.coefficients.shape[-3:]))
    last = np.where(np.isinf(edge)[..., np.newaxis, np.newaxis], c[..., -1:, :, :], 0.0)
    return Pieces(
        np.concatenate([knots, final], axis=-1), np.concatenate([c, last], axis=-3), pieces.rates
    )


def spread(pieces: Pieces, shape: tuple[int, ...]) -> Pieces:
    """Return the histories of `pieces` broadcast to a batch of the shape `shape`."""
    return Pieces(
        np.broadcast_to(pieces.knots, (*shape, *pieces.knots.shape[-1:])),
        np.broadcast_to(pieces.coefficients, (*shape, *pieces.coefficients.shape[-3:])),
        np.broadcast_to(pieces.rates, (*shape, *pieces.rates.shape[-1:])),
    )


def take(pieces: Pieces, index: IndexArray) -> Pieces:
    """Return the histories of `pieces` at the positions `index` ``(k,)`` of the flattened batch."""
    shape = pieces.batch or (1,)
    pieces, where = spread(pieces, shape), np.unravel_index(index, shape)
    return Pieces(pieces.knots[where], pieces.coefficients[where], pieces.rates[where])


def locate(pieces: Pieces, t: FloatArray) -> tuple[IndexArray, FloatArray]:
    """Return the index of the piece at each time t ``(..., m)``, and the time since its knot [s].

    The latter is negative before the first knot.
    """
    index = np.maximum(_last_at_or_before(pieces.knots, t), 0)
    return index, t - at_pieces(pieces.knots, index, trailing=0)


def _last_at_or_before(knots: FloatArray, t: FloatArray) -> IndexArray:
    """Return the index ``(..., m)`` of the last knot at or before each time; -1 before the first.

    `knots`: ascending, ``(..., n)`` [s]. `t`: times ``(..., m)`` [s].
    """
    if knots.size and not any(knots.strides[:-1]):  # one row of knots for the whole batch
        return np.searchsorted(knots[(0,) * (knots.ndim - 1)], t, side="right") - 1
    shape = np.broadcast_shapes(knots.shape[:-1], t.shape[:-1])
    if knots.shape[-1] <= _MAX_COMPARED_KNOTS:
        index = np.full((*shape, t.shape[-1]), -1)
        for knot in np.moveaxis(knots, -1, 0):  # numpy is slow along short axes
            index += knot[..., np.newaxis] <= t
        return index
    rows = np.broadcast_to(knots, (*shape, knots.shape[-1])).reshape(-1, knots.shape[-1])
    times = np.broadcast_to(t, (*shape, t.shape[-1])).reshape(-1, t.shape[-1])
    counts = [np.searchsorted(row, x, side="right") for row, x in zip(rows, times, strict=True)]
    return np.array(counts, dtype=np.intp).reshape(*shape, t.shape[-1]) - 1


def at_pieces(array: AnyArray, index: IndexArray, trailing: int) -> AnyArray:
    """Return the elements ``(..., m, *rest)`` of an array for pieces ``(..., n, *rest)``.

    `array`: an element of shape `rest` for each of n pieces. `index`: positions of m pieces ``(...,
    m)``. `trailing`: number of axes of `rest`. The leading axes of both broadcast.
    """
    axis = array.ndim - 1 - trailing
    batch, count = array.shape[:axis], array.shape[axis]
    if array.size and not any(array.strides[:axis]):  # one row for the whole batch
        shape = np.broadcast_shapes(batch, index.shape[:-1])
        return np.take(
            array[(0,) * axis], np.broadcast_to(index, (*shape, index.shape[-1])), axis=0
        )
    first = count * np.arange(prod(batch)).reshape(*batch, 1)
    return np.take(array.reshape(prod(batch) * count, *array.shape[axis + 1 :]), first + index, 0)


def recentred(c: AnyArray, rates: AnyArray, u: FloatArray) -> AnyArray:
    """Return the coefficients of terms c_k u^k e^(rate u) about a later time, of the shape of `c`.

    `c`: coefficients of m pieces, lowest power first, ``(..., m, rates, order)``. `rates`: ``(...,
    rates)`` [1/s]. `u`: new zero of the local time of each piece, ``(..., m)`` [s].
    """
    order = c.shape[-1]
    step = u[..., np.newaxis]
    # (v + u)^k = sum of comb(k, low) u^(k - low) v^low: each power of v by Horner's rule in u
    columns = []
    for low in range(order):
        column = c[..., order - 1] * comb(order - 1, low)
        for k in range(order - 2, low - 1, -1):
            column = column * step + comb(k, low) * c[..., k]
        columns.append(column)
    growth = np.exp(rates[..., np.newaxis, :] * step)
    return np.stack(np.broadcast_arrays(*columns), axis=-1) * growth[..., np.newaxis]


def polynomial_pieces(pieces: Pieces) -> tuple[FloatArray, FloatArray]:
    """Return breakpoints [s] and coefficients of the histories of a batch as polynomials.

    Breakpoints ``(histories, k)`` and coefficients ``(histories, k, degree + 1)``, lowest power
    first. Piecewise polynomials are exact; pieces with exponentials are divided until a polynomial
    approximates them to 2e-11 of their magnitude.
    """
    kind = np.result_type(pieces.coefficients, pieces.rates, float)
    knots, c, rates = flat_arrays(spread(pieces, pieces.batch), kind)
    if not np.any(rates):
        return knots.copy(), np.real(c.sum(axis=-2)).astype(float)
    edges = _cut(knots, np.abs(rates).max(axis=-1))
    flat = Pieces(knots, c, rates)
    index, u = locate(flat, edges)
    local = recentred(at_pieces(c, index, trailing=2), rates, np.maximum(u, 0.0))
    order = local.shape[-1] + _POLYNOMIAL_DEGREE
    coefficients = np.zeros((*edges.shape, order), dtype=complex)
    # each polynomial times the Taylor series of its e^(rate u)
    for k in range(_POLYNOMIAL_DEGREE + 1):
        growth = rates[:, np.newaxis, :, np.newaxis] ** k / factorial(k)
        coefficients[..., k : k + local.shape[-1]] += (local * growth).sum(axis=-2)
    return edges, np.ascontiguousarray(np.real(coefficients))


def _cut(knots: FloatArray, fastest: FloatArray) -> FloatArray:
    """Return knots [s] with further ones between, close enough for a fast exponential, ``(k, m)``.

    `knots`: of k histories, ``(k, n)`` [s]. `fastest`: size of the fastest rate of each, ``(k,)``
    [1/s].
    """
    widths = np.diff(knots, axis=-1)
    parts = np.ceil(
        (widths * fastest[:, np.newaxis]).max(axis=0, initial=0.0) / _PIECE_LENGTH_TIMES_RATE
    )
    columns = [
        knots[:, k : k + 1] + widths[:, k : k + 1] * np.arange(n) / n
        for k, n in enumerate(np.maximum(parts, 1.0).astype(int))
    ]
    return np.concatenate([*columns, knots[:, -1:]], axis=-1)


def laplace(pieces: Pieces, s: AnyArray) -> AnyArray:
    """Return the integral of f(t) e^(-s t) over all t of each history f, broadcast with `s`.

    `pieces`: the histories. `s`: Laplace variable [1/s], ``(...)``. The integral is infinite where
    the last piece does not decay faster than e^(-s t) grows.
    """
    # of each piece, from its own knot on
    values, diverges = integrals(pieces.coefficients, pieces.rates, pieces.widths, s)
    total = (np.exp(-s[..., np.newaxis] * pieces.knots) * values).sum(axis=-1)
    return np.where(diverges.any(axis=-1), np.inf, total)


def magnitude(pieces: Pieces, s: AnyArray) -> FloatArray:
    """Return the sum of the sizes of all terms of the Laplace integral, which has no cancellation.

    Times the relative spacing of floating-point numbers it is about the integral's rounding error.
    `pieces`: the histories. `s`: ``(...)`` [1/s], which broadcasts with their batch.
    """
    sizes = Pieces(pieces.knots, np.abs(pieces.coefficients), np.real(pieces.rates))
    return laplace(sizes, np.real(s))


def remaining_integral(pieces: Pieces, s: AnyArray) -> Callable[[FloatArray], AnyArray]:
    """Return the function of t whose value is the integral from t on of e^(-s (r - t)) f(r) dr.

    `pieces`: histories f, in each piece a sum of terms c_k u^k e^(rate u) of the time u since its
    knot. `s`: ``(...)`` [1/s], which broadcasts with their batch. The function takes times ``(...,
    m)`` [s] and returns integrals ``(..., m)``: the rest of the piece at t, plus the integral from
    the next knot on, those at the knots being computed once. Every exponential in it decays, so
    that an unstable mode that is not excited stays exact at any later time.
    """
    values, piece_diverges = integrals(pieces.coefficients, pieces.rates, pieces.widths, s)
    diverges = np.asarray(piece_diverges.any(axis=-1))
    # F(t_i) = I_i + e^(-s (t_i+1 - t_i)) F(t_i+1), from the last knot on, I_i being of its piece
    decay_over_piece = np.exp(-s[..., np.newaxis] * np.diff(pieces.knots, axis=-1))
    at_knots = np.array(values)
    for i in range(at_knots.shape[-1] - 2, -1, -1):
        at_knots[..., i] += decay_over_piece[..., i] * at_knots[..., i + 1]
    after = np.concatenate([at_knots[..., 1:], np.zeros_like(at_knots[..., :1])], axis=-1)
    column, widths = s[..., np.newaxis], pieces.widths

    def at(t: FloatArray) -> AnyArray:
        """Return the integrals from times t ``(..., m)`` [s] on; infinite where they diverge.

        `local` is of the rest of the piece at t, `tail` of the later ones, and `lead` of all,
        where t is before the first knot.
        """
        index, u = locate(pieces, t)
        before_first = u < 0.0
        u = np.maximum(u, 0.0)
        local_terms = at_pieces(pieces.coefficients, index, trailing=2)
        coefficients = recentred(local_terms, pieces.rates, u)
        remaining = np.maximum(at_pieces(widths, index, trailing=0) - u, 0.0)  # of the piece [s]
        local, _ = integrals(coefficients, pieces.rates, remaining, s)
        endless = np.isinf(remaining)
        decay = np.exp(-column * np.where(endless, 0.0, remaining))
        tail = np.where(endless, 0.0, decay * at_pieces(after, index, trailing=0))
        lead = np.exp(-column * np.maximum(pieces.knots[..., :1] - t, 0.0)) * at_knots[..., :1]
        return np.where(
            diverges[..., np.newaxis], np.inf, np.where(before_first, lead, local + tail)
        )

    return at


def integrals(
    c: AnyArray, rates: AnyArray, widths: FloatArray, s: AnyArray
) -> tuple[AnyArray, BoolArray]:
    """Return the integral of each piece times e^(-s u) over its width, and whether it diverges.

    Both ``(..., m)``, for pieces that are sums of terms c_k u^k e^(rate u). `c`: coefficients,
    ``(..., m, rates, degree + 1)``. `rates`: ``(..., rates)`` [1/s]. `widths`: ``(..., m)`` [s],
    infinite for an endless piece. `s`: ``(...)`` [1/s].

    A term contributes, with M_k of `moments`, over a width h and without end,

        c_k h^(k+1) M_k((s - rate) h),        c_k k!/(s - rate)^(k+1);

    the latter diverges unless Re(s) > Re(rate).
    """
    excess = (s[..., np.newaxis] - rates)[..., np.newaxis, :]
    endless = np.isinf(widths)
    width = np.where(endless, 0.0, widths)[..., np.newaxis]
    order = c.shape[-1]
    result = (c * powers(width, order) * moments(excess * width, order - 1)).sum(axis=(-2, -1))
    if not np.any(endless):
        return np.asarray(result), np.zeros(result.shape, dtype=bool)
    dying = (np.real(excess) > 0.0) & endless[..., np.newaxis]
    growing: BoolArray = ~dying & endless[..., np.newaxis] & (c != 0.0).any(axis=-1)
    factorials = np.array([factorial(k) for k in range(order)], dtype=float)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        divisor = np.where(dying, excess, 1.0)[..., np.newaxis] ** np.arange(1, order + 1)
        tails = c * factorials / divisor
    tails = np.where(dying[..., np.newaxis] & (c != 0.0), tails, 0.0).sum(axis=(-2, -1))
    return np.where(endless, tails, result), np.asarray(growing.any(axis=-1))


def powers(width: FloatArray, order: int) -> AnyArray:
    """Return width^1 ... width^order of widths ``(...)``, ``(..., order)``."""
    return np.cumprod(np.repeat(width[..., np.newaxis], order, axis=-1), axis=-1)


def lag(pieces: Pieces, pole: AnyArray) -> Pieces:
    """Return y with y' = pole y + f and y = 0 before the first knot; the pole joins the rates.

    `pieces`: histories f. `pole`: ``(...)`` [1/s], which broadcasts with their batch. Where a rate
    is so close to the pole that their difference would cancel, the solution is written as a
    polynomial times e^(pole u) instead of a difference of two exponentials. An endless last piece
    is resonant for a limited time only: there it gets one more knot. In each piece y is a
    particular solution, with the rates of f, plus a polynomial times e^(pole u), whose constant
    makes y continuous at the knot. Coefficients have the axes knots, rates, powers of u.
    """
    shape = np.broadcast_shapes(pieces.batch, pole.shape)
    pieces = _split_endless(spread(pieces, shape), pole)
    c, rates = pieces.coefficients, pieces.rates
    gap = rates - pole[..., np.newaxis]
    with np.errstate(invalid="ignore"):  # NaN: no gap in an endless piece, which is resonant
        span = np.abs(gap)[..., np.newaxis, :] * pieces.widths[..., np.newaxis]
    resonant = np.where(np.isnan(span), True, span < 1.01 * _RESONANT_SPAN) & np.any(
        c != 0.0, axis=-1
    )
    terms = _TAYLOR_TERMS if np.any(resonant & (gap[..., np.newaxis, :] != 0.0)) else 1
    degree = pieces.degree + (terms if np.any(resonant) else 0)
    particular = _particular_solution(np.where(resonant[..., np.newaxis], 0.0, c), gap)
    resonant_terms = _resonant_solution(np.where(resonant[..., np.newaxis], c, 0.0), gap, degree)
    homogeneous = resonant_terms.sum(axis=-2)  # polynomials of e^(pole u), (knots, powers)
    # the constant: y at the knot, less the particular solution there
    homogeneous[..., 0] = homogeneous[..., 0] - particular[..., 0].sum(axis=-1)
    homogeneous[..., 0] = homogeneous[..., 0] + _knot_states(pieces, pole)
    out = np.zeros(
        (*homogeneous.shape[:-1], rates.shape[-1] + 1, degree + 1), dtype=homogeneous.dtype
    )
    out[..., :-1, : particular.shape[-1]] = particular
    out[..., -1, :] = homogeneous
    poles = np.broadcast_to(pole[..., np.newaxis], (*shape, 1))
    return Pieces(pieces.knots, out, np.concatenate([rates, poles], axis=-1))


def _knot_states(pieces: Pieces, pole: AnyArray) -> AnyArray:
    """Return y of the lag y' = pole y + f at each of n knots, ``(..., n)``; zero at the first.

    `pieces`: histories f. `pole`: pole [1/s], ``(...)``.
    """
    shape = np.broadcast_shapes(pieces.batch, pole.shape)
    width = np.diff(pieces.knots, axis=-1)
    forced = _forced_states(pieces.coefficients[..., :-1, :, :], pieces.rates, width, pole)
    growth = np.exp(pole[..., np.newaxis] * width)
    forced, growth = (np.broadcast_to(a, (*shape, width.shape[-1])) for a in (forced, growth))
    state = np.zeros((*shape, width.shape[-1] + 1), dtype=np.result_type(forced, growth))
    for i in range(width.shape[-1]):
        state[..., i + 1] = growth[..., i] * state[..., i] + forced[..., i]
    return state


def _forced_states(c: AnyArray, rates: AnyArray, widths: FloatArray, pole: AnyArray) -> AnyArray:
    """Return y at the end of each piece of f, from y = 0 at its start, for y' = pole y + f.

    Shape ``(..., m)``. `c` ``(..., m, rates, degree + 1)``, `rates` ``(..., rates)``: f is the sum
    of c_k u^k e^(rate u). `widths`: h [s], ``(..., m)``. `pole`: p [1/s], ``(...)``. A term adds
    c_k h^(k+1) e^(p h) M_k((p - rate) h) with M_k of `moments`; where the rate does not decay
    faster than the pole, expanded from the end of the piece, so that no exponential overflows.
    """
    # products below have the axes pieces, rates and powers k; both are summed at the end
    order, width = c.shape[-1], widths[..., np.newaxis]
    gap = (pole[..., np.newaxis] - rates)[..., np.newaxis, :]
    from_start = np.real(gap) > 0.0
    scale = powers(width, order)  # h^(k+1)
    span = gap * width
    # terms expanded from the start of the piece, then from its end
    first = c * moments(np.where(from_start, span, 0.0), order - 1)
    first = first * np.exp(pole[..., np.newaxis] * widths)[..., np.newaxis, np.newaxis]
    last = recentred(c, rates, widths) * moments(np.where(from_start, 0.0, -span), order - 1)
    last = last * (-1.0) ** np.arange(order)  # powers of a time counted backward
    return (scale * np.where(from_start[..., np.newaxis], first, last)).sum(axis=(-2, -1))


def _split_endless(pieces: Pieces, pole: AnyArray) -> Pieces:
    """Return histories with their endless last piece split in two where a rate is near the pole.

    Such a rate is resonant: its term is expanded as a polynomial times e^(pole u), which is exact
    only in a piece of limited width, the first of the two. `pieces`: the histories. `pole`: of the
    lag that they drive, ``(...)`` [1/s].
    """
    last = pieces.coefficients[..., -1:, :, :]
    gap = np.abs(pieces.rates - pole[..., np.newaxis])
    gap = np.where(np.any(last[..., 0, :, :] != 0.0, axis=-1) & (gap > 0.0), gap, np.inf)
    smallest = gap.min(axis=-1, keepdims=True)
    if np.all(np.isinf(smallest)):
        return pieces
    # The first piece is a sixteenth of the resonant span, or ends where nothing is left to follow.
    rate = np.real(pole[..., np.newaxis])
    with np.errstate(divide="ignore"):
        horizon = np.where(rate > 0.0, _OVERFLOW_EXPONENT, _DECAYED_EXPONENT) / np.abs(rate)
    width = np.where(
        np.isinf(smallest), 0.0, np.minimum(_RESONANT_SPAN / (_SPLIT_SPANS * smallest), horizon)
    )
    knots = np.concatenate([pieces.knots, pieces.knots[..., -1:] + width], axis=-1)
    remainder = recentred(last, pieces.rates, width)
    return Pieces(knots, np.concatenate([pieces.coefficients, remainder], axis=-3), pieces.rates)


def _particular_solution(c: AnyArray, gap: AnyArray) -> AnyArray:
    """Return the polynomial a with a' + gap a = c, for each rate that differs from the pole.

    a e^(rate u) then solves y' = pole y + c e^(rate u). `c`: coefficients, lowest power first,
    ``(..., rates, order)``, as the result. `gap`: rate - pole [1/s]; where it is zero, c must be.
    """
    gap = np.where(gap == 0.0, 1.0, gap)[..., np.newaxis, :]
    result = np.zeros(c.shape, dtype=np.result_type(c, gap))
    coefficient = np.zeros_like(result[..., 0])
    for k in range(c.shape[-1] - 1, -1, -1):
        coefficient = (c[..., k] - (k + 1) * coefficient) / gap
        result[..., k] = coefficient
    return result


def _resonant_solution(c: AnyArray, gap: AnyArray, degree: int) -> AnyArray:
    """Return the polynomial factor of e^(pole u) of the solution, for rates at or near the pole.

    Of y' = pole y + f with y = 0 at u = 0, for each rate of f. `c`: coefficients of f, lowest power
    first, ``(..., pieces, rates, order)``. `gap`: rate - pole [1/s] of all pieces, ``(...,
    rates)``. `degree`: of the result, ``(..., pieces, rates, degree + 1)``.

    integral from 0 to u of c v^k e^(gap v) dv = sum over j of c gap^j/j! u^(k+j+1)/(k + j + 1).
    """
    gap = gap[..., np.newaxis, :]
    result = np.zeros((*c.shape[:-1], degree + 1), dtype=np.result_type(c, gap))
    for k in range(c.shape[-1]):
        term = c[..., k]
        for j in range(degree - k):
            result[..., k + j + 1] += term / (k + j + 1)
            term = term * gap / (j + 1)
    return result
