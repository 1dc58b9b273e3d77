"""Response of the closed loop to a wind, without limits: exact history, its peaks, and many loops.

`WindResponse` is one loop in one wind, evaluated at any time from matrix exponentials.
`deflection_peaks` is for searches over gains: many loops in one wind, exact at even samples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, FloatArray
from tvclin.base.errors import InputError, finite, instance, one_of, single
from tvclin.control.autopilot.feedback import Feedback
from tvclin.control.autopilot.wiring import closed_loop
from tvclin.linear.flexible import AnyPlant
from tvclin.numerics.propagation import (
    Motion,
    input_states,
    matrix_exponentials,
    motion,
    peak_output,
    piece_matrix,
)
from tvclin.winds.histories import History

_SETTLED = 40.0
"""The last piece is followed until the slowest mode has decayed by e^-40."""
_JUMP = 1e-9
"""A step of the wind above this part of its largest value is one; less is its rounding."""


@dataclass(frozen=True, eq=False)
class WindAnswer:
    """The outputs of one closed loop in one wind, at any time, and their peaks.

    Attributes
    ----------
    labels : tuple of str
        Names of the outputs: those of the plant, and the deflection.
    """

    labels: tuple[str, ...]
    _motion: Motion
    _rows: AnyArray
    _settled: float
    _through: FloatArray

    def __call__(self, times: ArrayLike) -> FloatArray:
        """Return the outputs [rad, rad/s] at times [s] of any shape, which follows theirs."""
        when = finite("times", times, "s")
        values = np.real(self._rows @ self._motion.at(when.ravel()).T)
        return values.reshape((-1, *when.shape))

    def peak(self, output: str) -> tuple[float, float]:
        """Return the value of largest size [rad, rad/s], with its sign, and its time [s].

        Both are infinite where the closed loop is unstable.
        """
        row = self._row(output)
        return peak_output(self._motion, row, self._settled) if self._settled else (np.inf, np.inf)

    def peak_rate(self, output: str) -> float:
        """Return the largest rate of change in size [1/s of the output].

        It is infinite where the output jumps, and where the closed loop is unstable.
        """
        row = self._row(output) @ self._motion.matrix
        if self._through[self.labels.index(output)] or not self._settled:
            return float(np.inf)
        return abs(peak_output(self._motion, row, self._settled)[0])

    def _row(self, output: str) -> AnyArray:
        return self._rows[self.labels.index(one_of("output", output, self.labels))]


def wind_answer(
    A: FloatArray,
    B: FloatArray,
    C: FloatArray,
    D: FloatArray,
    labels: tuple[str, ...],
    wind: History,
) -> WindAnswer:
    """Return the answer of x' = A x + B w, y = C x + D w to a wind, from rest.

    `A`, `B`, `C`, `D`: one system, ``(n, n)``, ``(n,)``, ``(outputs, n)`` and ``(outputs,)``.
    `labels`: names of the outputs. `wind`: one wind [rad]. `InputError` for a batch of winds.
    """
    instance("wind", wind, History, "such as TriangularWind")
    single("wind", wind.batch)
    pieces = wind.pieces
    inputs = np.zeros(pieces.rates.size * (pieces.degree + 1))
    inputs[:: pieces.degree + 1] = 1.0
    rows = np.hstack([C, D[:, np.newaxis] * inputs])
    found = motion(A, B, pieces)
    decay = -np.real(np.linalg.eigvals(A)).max()
    settled = _SETTLED / decay if decay > 0.0 else 0.0
    values = found.starts[:, len(A) :] @ inputs
    before = np.append(0.0, np.real(_ends(found, inputs, len(A))))
    jumps = np.abs(np.real(values) - before) > _JUMP * np.abs(values).max(initial=0.0)
    return WindAnswer(labels, found, rows, settled, (D != 0.0) & np.any(jumps))


def _ends(found: Motion, inputs: FloatArray, order: int) -> AnyArray:
    """The wind at the end of each piece but the last."""
    alone = found.matrix[order:, order:]
    steps = matrix_exponentials(alone, np.diff(found.knots))
    return np.einsum("i,kij,kj->k", inputs, steps, found.starts[:-1, order:])


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
    matrix = np.repeat(piece_matrix(A[0], B[0], pieces)[np.newaxis], m, axis=0)
    matrix[:, :n, :n] = A
    matrix[:, :n, n::powers] = B[..., np.newaxis]
    felt = np.zeros((m, matrix.shape[-1]), dtype=matrix.dtype)
    felt[:, :n], felt[:, n::powers] = row, through[:, np.newaxis]
    starts = input_states(pieces, pieces.knots)
    widths = np.append(np.diff(pieces.knots), after)
    state = np.zeros((m, matrix.shape[-1]), dtype=np.result_type(matrix, starts))
    highest = np.zeros(m)
    for width, start in zip(widths.tolist(), starts, strict=True):
        count = int(np.ceil(_STEPS * max(width / widths.sum(), 0.1)))
        state[:, n:] = start
        for part in (_BEGIN, 1.0 - _BEGIN):
            step = matrix_exponentials(matrix, np.full(m, part * width / count))
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
