"""Integrals of pieces: the Laplace transform, and the discounted future of a growing mode."""

from collections.abc import Callable
from math import factorial

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray
from tvclin.numerics.moments import moments
from tvclin.numerics.pieces import Pieces, at_pieces, locate, moved


def laplace(pieces: Pieces, s: AnyArray) -> AnyArray:
    """Return the Laplace integral over the whole history at `s`, which broadcasts with the batch.

    Infinite where the last piece does not die out faster than e^(-s t) grows.
    """
    each, diverges = integrals(pieces.coefficients, pieces.rates, pieces.widths, s)
    total = (np.exp(-s[..., np.newaxis] * pieces.knots) * each).sum(axis=-1)
    return np.where(diverges.any(axis=-1), np.inf, total)


def magnitude(pieces: Pieces, s: AnyArray) -> FloatArray:
    """Return the sum of the sizes of all terms of `laplace`: its rounding error per epsilon."""
    sizes = Pieces(pieces.knots, np.abs(pieces.coefficients), np.real(pieces.rates))
    return laplace(sizes, np.real(s))


def future(pieces: Pieces, s: AnyArray) -> Callable[[FloatArray], AnyArray]:
    """Return the discounted future, the integral from t on of e^(-s (r - t)) f(r) dr, of t.

    A function of times ``t (..., m)``, as in `value`, for which the futures at the knots are found
    once; `s` broadcasts with the batch. Every exponential in it decays, so an unstable mode that is
    not excited stays exact however late the time.
    """
    at_knots, diverges = _future_at_knots(pieces, s)
    after = np.concatenate([at_knots[..., 1:], np.zeros_like(at_knots[..., :1])], axis=-1)
    column, widths = s[..., np.newaxis], pieces.widths

    def at(t: FloatArray) -> AnyArray:
        index, u = locate(pieces, t)
        early = u < 0.0
        u = np.maximum(u, 0.0)
        here = moved(at_pieces(pieces.coefficients, index, 2), pieces.rates, u)
        left = np.maximum(at_pieces(widths, index, 0) - u, 0.0)
        rest, _ = integrals(here, pieces.rates, left, s)
        endless = np.isinf(left)
        decay = np.exp(-column * np.where(endless, 0.0, left))
        tail = np.where(endless, 0.0, decay * at_pieces(after, index, 0))
        lead = np.exp(-column * np.maximum(pieces.knots[..., :1] - t, 0.0)) * at_knots[..., :1]
        return np.where(diverges[..., np.newaxis], np.inf, np.where(early, lead, rest + tail))

    return at


def _future_at_knots(pieces: Pieces, s: AnyArray) -> tuple[AnyArray, BoolArray]:
    each, diverges = integrals(pieces.coefficients, pieces.rates, pieces.widths, s)
    # F(t_i) = I_i + e^(-s (t_i+1 - t_i)) F(t_i+1), from the last piece on
    decay = np.exp(-s[..., np.newaxis] * np.diff(pieces.knots, axis=-1))
    result = np.array(each)
    for i in range(result.shape[-1] - 2, -1, -1):
        result[..., i] += decay[..., i] * result[..., i + 1]
    return result, np.asarray(diverges.any(axis=-1))


def integrals(
    c: AnyArray, rates: AnyArray, widths: FloatArray, s: AnyArray
) -> tuple[AnyArray, BoolArray]:
    """Integrate each piece times e^(-s u) over its width, ``(..., m)``; and say which diverge.

    Of the term c_k u^k e^(rate u), with M_k of `moments`, over the width h and without end:

        c_k h^(k+1) M_k((s - rate) h)        c_k k!/(s - rate)^(k+1)
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
    """width^1 ... width^order, on a new last axis."""
    return np.cumprod(np.repeat(width[..., np.newaxis], order, axis=-1), axis=-1)
