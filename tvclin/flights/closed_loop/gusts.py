"""Winds as polynomials between knots, for kernels that fly many cases at once."""

from __future__ import annotations

from math import factorial

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.numerics.pieces import at_pieces, locate, recentred, spread
from tvclin.winds.histories import History

_SPAN = 0.5
"""Exponentials become polynomials on pieces so wide, over their rate."""
_TERMS = 10
"""0.5^11/11! is below 2e-11."""


def polynomial_pieces(wind: History) -> tuple[FloatArray, FloatArray]:
    """Return a batch of winds as polynomials between breakpoints.

    Breakpoints ``(winds, k)`` and coefficients ``(winds, k, degree + 1)``, lowest power first.
    Winds of straight lines stay exact; pieces with exponentials are cut until a polynomial
    stands for them to 2e-11 of their size.
    """
    pieces = wind.pieces
    batch = pieces.batch or (1,)
    pieces = spread(pieces, batch)
    size = int(np.prod(batch))
    knots = pieces.knots.reshape(size, pieces.knots.shape[-1])
    c = pieces.coefficients.reshape(size, *pieces.coefficients.shape[-3:])
    rates = pieces.rates.reshape(size, pieces.rates.shape[-1])
    if not np.any(rates):
        return knots.copy(), np.real(c.sum(axis=-2)).astype(float)
    edges = _cut(knots, np.abs(rates).max(axis=-1))
    flat = type(pieces)(knots, c, rates)
    index, u = locate(flat, edges)
    here = recentred(at_pieces(c, index, 2), rates, np.maximum(u, 0.0))
    order = here.shape[-1] + _TERMS
    found = np.zeros((*edges.shape, order), dtype=complex)
    for k in range(_TERMS + 1):
        growth = rates[:, np.newaxis, :, np.newaxis] ** k / factorial(k)
        found[..., k : k + here.shape[-1]] += (here * growth).sum(axis=-2)
    return edges, np.ascontiguousarray(np.real(found))


def _cut(knots: FloatArray, fastest: FloatArray) -> FloatArray:
    """Knots with as many more between them as the fastest rate of any wind asks for."""
    widths = np.diff(knots, axis=-1)
    parts = np.ceil((widths * fastest[:, np.newaxis]).max(axis=0, initial=0.0) / _SPAN)
    columns = [
        knots[:, k : k + 1] + widths[:, k : k + 1] * np.arange(n) / n
        for k, n in enumerate(np.maximum(parts, 1.0).astype(int))
    ]
    return np.concatenate([*columns, knots[:, -1:]], axis=-1)
