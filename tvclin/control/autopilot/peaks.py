"""The largest deflections of many closed loops in one wind, each between even samples."""

from __future__ import annotations

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray
from tvclin.base.errors import InputError
from tvclin.control.autopilot.feedback import Feedback
from tvclin.control.autopilot.wiring import closed_loop
from tvclin.linear.flexible import AnyPlant
from tvclin.numerics.propagation import answering, exponentials, inputs_at
from tvclin.winds.histories import History

_STEPS = 400
"""Over the wind and what follows it, and at least a tenth of them in each piece of the wind."""
_BEGIN = 0.1
"""The first part of a piece has as many steps again: behind a corner of the wind all is faster."""


def deflection_peaks(
    autopilot: Feedback, plant: AnyPlant, wind: History, after: float
) -> FloatArray:
    """Return the largest deflection [rad] of each of a row of autopilots, ``(m,)``, in size.

    The loops are those of `Autopilot.answer`, and exact at every sample; beside the highest sample
    a parabola stands for the motion. For searches: what they find is to be asked of `answer`.

    `autopilot`: a row of gains, ``(m,)``, and one delay. `plant`: one plant. `wind`: one wind that
    ends. `after`: how long the loops are followed behind its end [s].
    """
    A, B, row, through = _closed(autopilot, plant)
    pieces, (m, n) = wind.pieces, A.shape[:2]
    powers = pieces.degree + 1
    # answering() of one loop, with the A and B of each
    matrix = np.repeat(answering(A[0], B[0], pieces)[np.newaxis], m, axis=0)
    matrix[:, :n, :n] = A
    matrix[:, :n, n::powers] = B[..., np.newaxis]
    felt = np.zeros((m, matrix.shape[-1]), dtype=matrix.dtype)
    felt[:, :n], felt[:, n::powers] = row, through[:, np.newaxis]
    starts = inputs_at(pieces, pieces.knots)
    widths = np.append(np.diff(pieces.knots), after)
    state = np.zeros((m, matrix.shape[-1]), dtype=np.result_type(matrix, starts))
    highest = np.zeros(m)
    for width, start in zip(widths.tolist(), starts, strict=True):
        count = int(np.ceil(_STEPS * max(width / widths.sum(), 0.1)))
        state[:, n:] = start
        for part in (_BEGIN, 1.0 - _BEGIN):
            step = exponentials(matrix, np.full(m, part * width / count))
            values = np.empty((count + 1, m))
            values[0] = _sizes(felt, state)
            for k in range(count):
                state = (step @ state[..., np.newaxis])[..., 0]
                values[k + 1] = _sizes(felt, state)
            highest = np.maximum(highest, _summits(values))
    return np.where(np.isfinite(highest), highest, np.inf)


def _sizes(felt: AnyArray, state: AnyArray) -> FloatArray:
    return np.asarray(np.abs(np.real(np.einsum("mi,mi->m", felt, state))))


def _summits(values: FloatArray) -> FloatArray:
    """The highest of each column ``(n, m)``, by a parabola through it and its neighbours."""
    columns = np.arange(values.shape[1])
    top = np.clip(np.argmax(values, axis=0), 1, len(values) - 2)
    left, mid, right = (values[top + k, columns] for k in (-1, 0, 1))
    bend = np.minimum(left - 2.0 * mid + right, -np.finfo(float).tiny)
    inside = (mid >= left) & (mid >= right)
    rise = np.where(inside, -0.125 * (right - left) ** 2 / bend, 0.0)
    return np.asarray(np.maximum(values.max(axis=0), mid + rise))


def _closed(autopilot: Feedback, plant: AnyPlant) -> tuple[FloatArray, ...]:
    """A and B from the wind of each closed loop, and the rows of its deflection."""
    if np.ndim(autopilot.delay):
        raise InputError("deflection_peaks() is for one delay")
    loop, m = closed_loop(autopilot, plant), autopilot.batch[0]
    A, B, C, D = (np.broadcast_to(one, (m, *one.shape[-2:])) for one in loop.matrices())
    return A, B[..., 0], C[:, -1], D[:, -1, 0]
