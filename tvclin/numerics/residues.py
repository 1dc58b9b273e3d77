"""Residues of the answer to pieces at the poles of a plant, and the rounding in them."""

from typing import Any

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray
from tvclin.numerics import integrals
from tvclin.numerics.pieces import Pieces

_EPS = float(np.finfo(float).eps)
_DEAD = 750.0
"""e^-750 is nothing: later knots do not count."""
_ROUNDINGS = 32.0
"""Roundings in one term of a transform; its knots and its exponent add to them."""


def residues(
    poles: AnyArray, gains: tuple[AnyArray, ...], inputs: tuple[Pieces, ...], start: FloatArray
) -> tuple[AnyArray, FloatArray]:
    """Return the residue at each pole, with the time counted from `start` [s], and its rounding.

    `poles`: in 1/s, ``(..., N)``; what is NaN stays NaN. `gains`: for each input the residues of
    its transfer function there. `inputs`: their batches broadcast with that of the poles.
    """
    terms, sizes = [], []
    roundings = np.asarray(_ROUNDINGS)
    for gain, pieces in zip(gains, inputs, strict=True):
        late = Pieces(pieces.knots - start[..., np.newaxis], pieces.coefficients, pieces.rates)
        terms.append(gain * _at_poles(integrals.laplace, late, poles))
        sizes.append(np.abs(gain) * _at_poles(integrals.magnitude, late, poles))
        last = np.abs(late.knots[..., -1])[..., np.newaxis]
        exponent = np.minimum(np.abs(poles) * last, _DEAD)
        roundings = roundings + exponent + np.sqrt(late.knots.shape[-1])
    return np.asarray(terms[0] + terms[1]), _EPS * roundings * np.real(sizes[0] + sizes[1])


def _at_poles(transform: Any, pieces: Pieces, poles: AnyArray) -> AnyArray:
    """Evaluate a transform at each pole; NaN poles stay NaN."""
    columns = []
    for pole in np.moveaxis(poles, -1, 0):
        missing = np.isnan(pole)
        found = transform(pieces, np.where(missing, 1.0, pole))
        found = found if np.iscomplexobj(poles) else np.real(found)
        columns.append(np.where(missing, np.nan, found))
    return np.stack(columns, axis=-1) if columns else np.zeros((*poles.shape[:-1], 0))
