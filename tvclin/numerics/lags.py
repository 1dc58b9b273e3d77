"""First-order lags of pieces, as pieces again."""

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray
from tvclin.numerics.integrals import powers
from tvclin.numerics.moments import moments
from tvclin.numerics.pieces import Pieces, moved, spread

_NEAR = 0.25
"""A rate within this of a lag's pole, times the width, counts as resonant."""
_TAYLOR_TERMS = 13
"""0.25^13/13! is below 1e-17: the expansion of a resonant term is exact to rounding."""
_ROOM = 16.0
"""The piece split off an endless one stays near for later lags with gaps so many times as wide."""
_DIED = 60.0
"""e^-60 of a decaying term is nothing beside its beginning."""
_OVERFLOWS = 600.0
"""A growing term is not followed beyond e^600."""


def lag(pieces: Pieces, pole: AnyArray) -> Pieces:
    """Return y with y' = pole y + f and y = 0 before the first knot; the pole joins the rates.

    Where a rate is so near to the pole that their difference would cancel, the answer is
    written as a polynomial times e^(pole u) instead of a difference of two exponentials. A last
    piece that never ends is near for a while only: there it gets one more knot.
    """
    shape = np.broadcast_shapes(pieces.batch, pole.shape)
    pieces = _split_end(spread(pieces, shape), pole)
    c, rates = pieces.coefficients, pieces.rates
    gap = rates - pole[..., np.newaxis]
    with np.errstate(invalid="ignore"):
        span = np.abs(gap)[..., np.newaxis, :] * pieces.widths[..., np.newaxis]
    near = np.where(np.isnan(span), True, span < 1.01 * _NEAR) & np.any(c != 0.0, axis=-1)
    terms = _TAYLOR_TERMS if np.any(near & (gap[..., np.newaxis, :] != 0.0)) else 1
    degree = pieces.degree + (terms if np.any(near) else 0)
    far_part = _particular(np.where(near[..., np.newaxis], 0.0, c), gap)
    near_part = _resonant(np.where(near[..., np.newaxis], c, 0.0), gap, degree)
    own = near_part.sum(axis=-2)
    own[..., 0] = own[..., 0] - far_part[..., 0].sum(axis=-1)
    own[..., 0] = own[..., 0] + _states(pieces, pole)
    out = np.zeros((*own.shape[:-1], rates.shape[-1] + 1, degree + 1), dtype=own.dtype)
    out[..., :-1, : far_part.shape[-1]] = far_part
    out[..., -1, :] = own
    poles = np.broadcast_to(pole[..., np.newaxis], (*shape, 1))
    return Pieces(pieces.knots, out, np.concatenate([rates, poles], axis=-1))


def _states(pieces: Pieces, pole: AnyArray) -> AnyArray:
    """The lag's value at each knot, ``(..., n)``, carried exactly from knot to knot."""
    shape = np.broadcast_shapes(pieces.batch, pole.shape)
    width = np.diff(pieces.knots, axis=-1)
    forced = _answers(pieces.coefficients[..., :-1, :, :], pieces.rates, width, pole)
    growth = np.exp(pole[..., np.newaxis] * width)
    forced, growth = (np.broadcast_to(a, (*shape, width.shape[-1])) for a in (forced, growth))
    state = np.zeros((*shape, width.shape[-1] + 1), dtype=np.result_type(forced, growth))
    for i in range(width.shape[-1]):
        state[..., i + 1] = growth[..., i] * state[..., i] + forced[..., i]
    return state


def _answers(c: AnyArray, rates: AnyArray, widths: FloatArray, pole: AnyArray) -> AnyArray:
    """What a lag makes of each piece alone by the end of its width, ``(..., m)``.

    The integral from 0 to h of e^(p (h - v)) v^k e^(lambda v) dv is seen from the start of the
    piece where the rate dies faster than the pole, and from its end where the pole does.
    """
    order, width = c.shape[-1], widths[..., np.newaxis]
    gap = (pole[..., np.newaxis] - rates)[..., np.newaxis, :]
    from_start = np.real(gap) > 0.0
    scale = powers(width, order)
    span = gap * width
    first = c * moments(np.where(from_start, span, 0.0), order - 1)
    first = first * np.exp(pole[..., np.newaxis] * widths)[..., np.newaxis, np.newaxis]
    last = moved(c, rates, widths) * moments(np.where(from_start, 0.0, -span), order - 1)
    last = last * (-1.0) ** np.arange(order)
    return (scale * np.where(from_start[..., np.newaxis], first, last)).sum(axis=(-2, -1))


def _split_end(pieces: Pieces, pole: AnyArray) -> Pieces:
    """Part the endless piece where its slowest gap from the pole stops being small."""
    last = pieces.coefficients[..., -1:, :, :]
    gap = np.abs(pieces.rates - pole[..., np.newaxis])
    gap = np.where(np.any(last[..., 0, :, :] != 0.0, axis=-1) & (gap > 0.0), gap, np.inf)
    smallest = gap.min(axis=-1, keepdims=True)
    if np.all(np.isinf(smallest)):
        return pieces
    rate = np.real(pole[..., np.newaxis])
    with np.errstate(divide="ignore"):
        matters = np.where(rate > 0.0, _OVERFLOWS, _DIED) / np.abs(rate)
    width = np.where(np.isinf(smallest), 0.0, np.minimum(_NEAR / (_ROOM * smallest), matters))
    knots = np.concatenate([pieces.knots, pieces.knots[..., -1:] + width], axis=-1)
    end = moved(last, pieces.rates, width)
    return Pieces(knots, np.concatenate([pieces.coefficients, end], axis=-3), pieces.rates)


def _particular(c: AnyArray, gap: AnyArray) -> AnyArray:
    """The polynomial a with a' + gap a = c, for each rate off the pole."""
    gap = np.where(gap == 0.0, 1.0, gap)[..., np.newaxis, :]
    result = np.zeros(c.shape, dtype=np.result_type(c, gap))
    above = np.zeros_like(result[..., 0])
    for k in range(c.shape[-1] - 1, -1, -1):
        above = (c[..., k] - (k + 1) * above) / gap
        result[..., k] = above
    return result


def _resonant(c: AnyArray, gap: AnyArray, degree: int) -> AnyArray:
    """The polynomial, times e^(pole u), that answers a rate on or near the pole.

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
