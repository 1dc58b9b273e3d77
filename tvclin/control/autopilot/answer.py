"""What the closed loop makes of a wind, exactly and without limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, FloatArray
from tvclin.base.errors import finite, instance, one_of, single
from tvclin.numerics.peaks import largest
from tvclin.numerics.propagation import Motion, exponentials, motion
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
        return largest(self._motion, row, self._settled) if self._settled else (np.inf, np.inf)

    def peak_rate(self, output: str) -> float:
        """Return the largest rate of change in size [1/s of the output].

        It is infinite where the output jumps, and where the closed loop is unstable.
        """
        row = self._row(output) @ self._motion.matrix
        if self._through[self.labels.index(output)] or not self._settled:
            return float(np.inf)
        return abs(largest(self._motion, row, self._settled)[0])

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
    steps = exponentials(alone, np.diff(found.knots))
    return np.einsum("i,kij,kj->k", inputs, steps, found.starts[:-1, order:])
