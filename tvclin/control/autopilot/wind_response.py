"""Response of the closed loop to a wind, without limits: exact history, its peaks, and many loops.

`WindResponse` is one loop in one wind, evaluated at any time from matrix exponentials.
`deflection_peaks` is for searches over gains: many loops in one wind, exact at even samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, FloatArray
from tvclin.base.errors import InputError, each, finite, instance, one_of, single
from tvclin.control.autopilot.feedback import Feedback
from tvclin.control.autopilot.wiring import closed_loop
from tvclin.linear.flexible import AnyPlant
from tvclin.numerics import propagation
from tvclin.numerics.propagation import Motion
from tvclin.winds.histories import History

_DECAY_EXPONENT = 40.0
"""Exponent of the decay, e^-40, of the slowest mode until which the last piece is searched."""
_RELATIVE_JUMP = 1e-9
"""Smallest step of the wind that counts as a jump, relative to the wind's largest value."""


@dataclass(frozen=True, eq=False)
class WindResponse:
    """Outputs of one closed loop in one wind, at any time, and their peaks.

    Attributes
    ----------
    labels : tuple of str
        Names of the outputs: the plant's, and "deflection".
    """

    labels: tuple[str, ...]
    _motion: Motion
    _rows: AnyArray
    _settling_time: float
    _jumps: FloatArray

    def __call__(self, times: ArrayLike) -> FloatArray:
        """Return the outputs [rad, rad/s] at times [s], ``(outputs,) + times.shape``."""
        at = finite("times", times, "s")
        states = self._motion.at(at.ravel())  # of loop and wind, (times, states)
        return np.real(self._rows @ states.T).reshape((-1, *at.shape))

    def peak(self, output: str) -> tuple[float, float]:
        """Return the value of largest magnitude [rad, rad/s], with its sign, and its time [s].

        `output`: one of the labels. Both are infinite where the closed loop is unstable.
        """
        row = self._row(output)
        if not self._settling_time:  # unstable
            return np.inf, np.inf
        return propagation.peak_output(self._motion, row, self._settling_time)

    def peak_rate(self, output: str) -> float:
        """Return the largest magnitude of the output's rate of change [rad/s, rad/s^2].

        It is infinite where the output jumps, and where the closed loop is unstable.
        """
        row = self._row(output) @ self._motion.matrix  # of y': y = row x with x' = matrix x
        if self._jumps[self.labels.index(output)] or not self._settling_time:  # zero: unstable
            return float(np.inf)
        peak, _ = propagation.peak_output(self._motion, row, self._settling_time)
        return abs(peak)

    def _row(self, output: str) -> AnyArray:
        """Return the row r ``(n,)`` of an output y = r x, by the n states x of loop and wind.

        `output`: one of the labels; `InputError` for another.
        """
        return self._rows[self.labels.index(one_of("output", output, self.labels))]


def wind_response_of(
    A: FloatArray,
    B: FloatArray,
    C: FloatArray,
    D: FloatArray,
    labels: tuple[str, ...],
    wind: History,
) -> WindResponse:
    """Return the response of x' = A x + B w, y = C x + D w to a wind w, from x = 0.

    `A`, `B`, `C`, `D`: one system, ``(n, n)``, ``(n,)``, ``(outputs, n)`` and ``(outputs,)``.
    `labels`: names of the outputs. `wind`: one wind [rad], in pieces that are sums over rates r of
    polynomials in t times e^(r t). `InputError` for a batch of winds.
    """
    instance("wind", wind, History, "such as TriangularWind")
    single("wind", wind.batch)
    pieces, powers = wind.pieces, wind.pieces.degree + 1
    # Behind x the motion has states of the wind; the first of each rate add up to the wind.
    wind_row = np.zeros(pieces.rates.size * powers)
    wind_row[::powers] = 1.0
    rows = np.hstack([C, D[:, np.newaxis] * wind_row])
    (motion,) = propagation.motions(A, B, [pieces])
    decay = -np.real(np.linalg.eigvals(A)).max()
    settling_time = _DECAY_EXPONENT / decay if decay > 0.0 else 0.0  # zero: unstable
    # jumps of the wind: its value at the start of a piece, less that at the end of the piece before
    order = len(A)
    starts = motion.starts[:, order:]
    steps = propagation.matrix_exponentials(motion.matrix[order:, order:], np.diff(motion.knots))
    ends = np.einsum("i,kij,kj->k", wind_row, steps, starts[:-1])
    values, before = starts @ wind_row, np.append(0.0, np.real(ends))
    jumps = np.abs(np.real(values) - before) > _RELATIVE_JUMP * np.abs(values).max(initial=0.0)
    output_jumps = (D != 0.0) & np.any(jumps)
    return WindResponse(labels, motion, rows, settling_time, output_jumps)


def peaks_in_winds(
    A: FloatArray,
    B: FloatArray,
    row: tuple[FloatArray, float],
    winds: Sequence[History],
) -> FloatArray:
    """Return the largest sizes of an output of x' = A x + B w in winds w, from x = 0, ``(winds,)``.

    The largest of them is exact; in winds that cannot have the largest it may be too small. `A`,
    `B`: one stable system, ``(n, n)`` and ``(n,)``. `row`: C and D of the output, ``(n,)`` and one
    number. `winds`: single winds [rad], in pieces that are sums over rates r of polynomials in t
    times e^(r t); those with rates and degree in common are computed together.
    """
    C, D = row
    decay = -np.real(np.linalg.eigvals(A)).max()
    if not decay > 0.0:
        raise InputError("peaks in winds are of a stable closed loop; this loop is not stable")
    groups: dict[tuple[bytes, int], list[int]] = {}  # indices of winds, by rates and degree
    for k, wind in enumerate(each("winds", winds, History, "such as TriangularWind")):
        single("winds", wind.batch)
        groups.setdefault((wind.pieces.rates.tobytes(), wind.pieces.degree), []).append(k)
    settling_time = _DECAY_EXPONENT / decay
    peaks = np.zeros(len(winds))
    for (_, degree), group in groups.items():
        trajectories = propagation.motions(A, B, [winds[k].pieces for k in group])
        # Behind x a motion has states of the wind; the first of each rate add up to the wind.
        direct = np.zeros(len(trajectories[0].matrix) - len(A))
        direct[:: degree + 1] = D
        output_row = np.concatenate([C, direct])
        peaks[group] = propagation.peak_outputs(trajectories, output_row, settling_time)
    return peaks


_STEPS = 400
"""Number of samples over the wind and the time after it; each piece has a tenth of them or more."""
_INITIAL_FRACTION = 0.1
"""First fraction of a piece, with as many samples as the rest: after a corner all is faster."""


def deflection_peaks(
    autopilot: Feedback, plant: AnyPlant, wind: History, after: float
) -> FloatArray:
    """Return the magnitude of the largest deflection [rad] of each of m autopilots, ``(m,)``.

    The loops are those of `Autopilot.wind_response`, exact at every sample; the peak is the
    vertex of a parabola through the highest sample and its neighbours. It is meant for searches,
    whose result `Autopilot.wind_response` then confirms.

    `autopilot`: gains ``(m,)`` and one delay. `plant`: one plant. `wind`: one wind that ends.
    `after`: time after its end [s] during which peaks are searched.
    """
    loop, m = closed_loop(autopilot, plant), autopilot.batch[0]
    A, B, C, D = (np.broadcast_to(a, (m, *a.shape[-2:])) for a in loop.matrices())
    B, row, direct = B[..., 0], C[:, -1], D[:, -1, 0]  # from the wind to the deflection
    pieces, n, powers = wind.pieces, A.shape[1], wind.pieces.degree + 1
    # States x of the loop and z of the wind, [x, z]' = matrix [x, z]: piece_matrix() of one loop,
    # with the A and B of each. The wind is the sum of every `powers`-th of z.
    matrix = np.repeat(propagation.piece_matrix(A[0], B[0], pieces)[np.newaxis], m, axis=0)
    matrix[:, :n, :n] = A
    matrix[:, :n, n::powers] = B[..., np.newaxis]
    output = np.zeros((m, matrix.shape[-1]), dtype=matrix.dtype)
    output[:, :n], output[:, n::powers] = row, direct[:, np.newaxis]
    starts = propagation.input_states(pieces, pieces.knots)  # z at the start of each piece
    widths = np.append(np.diff(pieces.knots), after)  # [s]
    state = np.zeros((m, matrix.shape[-1]), dtype=np.result_type(matrix, starts))
    highest = np.zeros(m)
    # Each piece of the wind between breakpoints, and the time after it; at least a tenth of the
    # samples. Half of those of a piece are in its first tenth, as after a corner all is faster.
    for width, start in zip(widths.tolist(), starts, strict=True):
        count = int(np.ceil(_STEPS * max(width / widths.sum(), 0.1)))
        state[:, n:] = start
        for fraction in (_INITIAL_FRACTION, 1.0 - _INITIAL_FRACTION):
            step = propagation.matrix_exponentials(matrix, np.full(m, fraction * width / count))
            values = np.empty((count + 1, m))
            values[0] = _sizes(output, state)
            for k in range(count):
                state = (step @ state[..., np.newaxis])[..., 0]
                values[k + 1] = _sizes(output, state)
            highest = np.maximum(highest, _parabola_maxima(values))
    return np.where(np.isfinite(highest), highest, np.inf)


def _sizes(rows: AnyArray, states: AnyArray) -> FloatArray:
    """Return the magnitude of the output r x of each of m systems, ``(m,)``.

    `rows`: r, ``(m, n)``. `states`: x, ``(m, n)``.
    """
    return np.asarray(np.abs(np.real(np.einsum("mi,mi->m", rows, states))))


def _parabola_maxima(values: FloatArray) -> FloatArray:
    """Return the maximum of each column of even samples ``(n, m)``, refined between the samples.

    It is the vertex of the parabola through the highest sample and its neighbours.
    """
    columns = np.arange(values.shape[1])
    top = np.clip(np.argmax(values, axis=0), 1, len(values) - 2)
    before, middle, after = (values[top + k, columns] for k in (-1, 0, 1))
    # negative, not zero: where the middle is not the highest the parabola is not used
    second_difference = np.minimum(before - 2.0 * middle + after, -np.finfo(float).tiny)
    inside = (middle >= before) & (middle >= after)
    rise = np.where(inside, -0.125 * (after - before) ** 2 / second_difference, 0.0)
    return np.asarray(np.maximum(values.max(axis=0), middle + rise))
