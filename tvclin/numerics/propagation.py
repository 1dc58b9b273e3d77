"""Linear systems driven by pieces, carried exactly from knot to knot by matrix exponentials.

A piece is itself the free motion of a small system, one Jordan block for each of its rates. Put
beside the states x it makes the whole a free motion,

    d/du [x, z] = M [x, z],    the input being the sum of the first z of each block,

so that nothing is discretised, and repeated poles are nothing special.
"""

from dataclasses import dataclass
from math import factorial

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray
from tvclin.base.errors import InputError
from tvclin.numerics.pieces import Pieces, locate, moved

_BATCH = 3
"""Axes of many matrices."""
_SMALL, _TERMS = 0.5, 14
"""0.5^15/15! is below 1e-16: the series of an exponent of that size ends after so many terms."""


@dataclass(frozen=True, eq=False)
class Motion:
    """One linear system with one input history.

    `matrix`: M [1/s], ``(n, n)``. `knots`: where the pieces begin [s], ``(k,)``. `starts`: the
    state of system and input at the start of each piece, ``(k, n)``.
    """

    matrix: AnyArray
    knots: FloatArray
    starts: AnyArray

    def at(self, times: FloatArray) -> AnyArray:
        """Return the states at the times ``(m,)``, shape ``(m, n)``; zero before the first knot."""
        index = np.searchsorted(self.knots, times, side="right") - 1
        start = np.where((index < 0)[:, np.newaxis], 0.0, self.starts[np.maximum(index, 0)])
        steps = np.maximum(times - self.knots[np.maximum(index, 0)], 0.0)
        return applied(_countable(self.matrix, steps), start)


def motion(A: FloatArray, B: FloatArray, pieces: Pieces) -> Motion:
    """Return the motion of x' = A x + B f from rest, f being the pieces of one history.

    `A`, `B`: one system, ``(n, n)`` and ``(n,)``. `pieces`: the input, not a batch.
    """
    order, matrix = len(A), answering(A, B, pieces)
    inputs = inputs_at(pieces, pieces.knots)
    starts = np.zeros((len(inputs), len(matrix)), dtype=np.result_type(matrix, inputs))
    starts[:, order:] = inputs
    widths, which = np.unique(np.diff(pieces.knots), return_inverse=True)
    steps = _countable(matrix, widths)
    for k, step in enumerate(which):
        starts[k + 1, :order] = (steps[step] @ starts[k])[:order]
    return Motion(matrix, pieces.knots, starts)


def answering(A: FloatArray, B: FloatArray, pieces: Pieces) -> AnyArray:
    """Return M of the states of a system and of its input within a piece; as `driven`."""
    rates, powers = pieces.rates, pieces.degree + 1
    given = np.zeros((len(A), rates.size * powers))
    given[:, ::powers] = B[:, np.newaxis]
    blocks = np.kron(np.diag(rates), np.eye(powers))
    blocks += np.kron(np.eye(rates.size), np.eye(powers, k=1))
    return driven(A, given, blocks)


def driven(A: AnyArray, B: AnyArray, inputs: AnyArray | None = None) -> AnyArray:
    """Return M of d/dt [x, z] = M [x, z] for x' = A x + B z, ``(..., n + k, n + k)``.

    `A`, `B`: ``(..., n, n)`` and ``(..., n, k)``; batches broadcast. `inputs`: Z of z' = Z z,
    ``(..., k, k)``; without it z is held.

    e^(M t) says what states and inputs at the start make of the states at t.
    """
    order, count = B.shape[-2:]
    inputs = np.zeros((count, count)) if inputs is None else inputs
    batch = np.broadcast_shapes(*(one.shape[:-2] for one in (A, B, inputs)))
    whole = np.zeros((*batch, order + count, order + count), np.result_type(A, B, inputs))
    whole[..., :order, :order], whole[..., :order, order:] = A, B
    whole[..., order:, order:] = inputs
    return whole


def inputs_at(pieces: Pieces, times: FloatArray) -> AnyArray:
    """Return the states z of the input at the times ``(m,)``, shape ``(m, size)``."""
    index, u = locate(pieces, times)
    c = moved(pieces.coefficients[index], pieces.rates, np.maximum(u, 0.0))
    scale = np.array([factorial(k) for k in range(pieces.degree + 1)], dtype=float)
    states = (c * scale).reshape(len(times), -1)
    return np.where((u < 0.0)[:, np.newaxis], 0.0, states)


def exponentials(matrix: AnyArray, steps: FloatArray) -> AnyArray:
    """Return e^(matrix step) of one matrix for each of the steps ``(m,)``, or of each with its own.

    By Taylor series, scaling and squaring, each with as many squarings as it needs: what it
    gives does not depend on the others. One matrix is balanced first. What is beyond all numbers
    is infinite or NaN.

    `matrix`: ``(n, n)`` or ``(m, n, n)``. `steps`: ``(m,)``.
    """
    from scipy.linalg import matrix_balance  # late: it takes 0.1 s to import

    if not matrix.size:
        return np.zeros((len(steps), *matrix.shape[-2:]))
    scale = np.ones(matrix.shape[-1])
    if matrix.ndim < _BATCH:
        matrix, (scale, _) = matrix_balance(matrix, permute=False, separate=True)
    size = np.abs(matrix).sum(axis=-2).max(axis=-1)
    # x = f 2^e with f in [0.5, 1): e squarings take a size of x times _SMALL below _SMALL.
    squarings = np.maximum(np.frexp(size * np.abs(steps) / _SMALL)[1], 0)
    scaled = matrix * np.ldexp(steps, -squarings)[:, np.newaxis, np.newaxis]
    unit = np.eye(matrix.shape[-1])
    result = np.broadcast_to(unit, scaled.shape)
    for k in range(_TERMS, 0, -1):
        result = unit + scaled @ result / k
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(int(squarings.max(initial=0))):
            more = squarings > k
            result[more] = result[more] @ result[more]
        return np.asarray(scale[:, np.newaxis] * result / scale)


def _countable(matrix: AnyArray, steps: FloatArray) -> AnyArray:
    """Return `exponentials`; `InputError` where one of them is beyond all numbers."""
    found = exponentials(matrix, steps)
    if not np.all(np.isfinite(found)):
        raise InputError(
            f"the motion grows beyond all numbers within {float(np.abs(steps).max()):.6g} s; ask"
            " for an earlier time, or a shorter wind"
        )
    return found


def applied(matrices: AnyArray, states: AnyArray) -> AnyArray:
    """Return each of the matrices ``(m, n, n)`` on its state, ``(m, n)``."""
    return np.asarray((matrices @ states[..., np.newaxis])[..., 0])
