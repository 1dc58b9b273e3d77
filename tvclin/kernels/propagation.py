"""Linear systems driven by pieces, carried exactly from knot to knot by matrix exponentials.

A piece is itself the free motion of a small system, one Jordan block for each of its rates. Put
beside the states x it makes the whole a free motion,

    d/du [x, z] = M [x, z],    the input being the sum of the first z of each block,

so that nothing is discretised, and repeated poles are nothing special.
"""

from dataclasses import dataclass
from math import factorial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.pieces import Pieces, locate, moved

FloatArray = NDArray[np.float64]

_EACH = 128
"""Steps of one size in the ladder of times; the size doubles from one lot to the next."""
_FINE, _COARSE = 0.1, 0.4
"""The first step, and the coarsest, over the fastest eigenvalue that is still alive."""
_CLOSE = 0.03
"""Summits among the samples that are lower by less than this may be the highest ones."""
_BEGUN = 1e-3
"""Where a derivative that begins with zero is looked at, over the width of the step."""
_DEAD = 40.0
"""A mode is dead when it has fallen to e^-40."""
_SMALL, _TERMS = 0.5, 14
"""0.5^15/15! is below 1e-16: the series of an exponent of that size ends after so many terms."""


@dataclass(frozen=True, eq=False)
class Motion:
    """One linear system with one input history.

    Attributes
    ----------
    matrix : ndarray
        M [1/s], ``(n, n)``.
    knots : ndarray
        Where the pieces begin [s], ``(k,)``.
    starts : ndarray
        The state of system and input at the start of each piece, ``(k, n)``.
    """

    matrix: NDArray[Any]
    knots: FloatArray
    starts: NDArray[Any]

    def at(self, times: FloatArray) -> NDArray[Any]:
        """Return the states at the times ``(m,)``, shape ``(m, n)``; zero before the first knot."""
        index = np.searchsorted(self.knots, times, side="right") - 1
        start = np.where((index < 0)[:, np.newaxis], 0.0, self.starts[np.maximum(index, 0)])
        steps = np.maximum(times - self.knots[np.maximum(index, 0)], 0.0)
        return _applied(exponentials(self.matrix, steps), start)

    def probes(self, beyond: float) -> tuple[FloatArray, NDArray[Any]]:
        """Return times ``(m,)``, rising, that miss no peak, and the states there ``(m, n)``.

        Both sides of every knot are among them; the last piece is followed for `beyond` [s].
        """
        widths = np.append(np.diff(self.knots), beyond)
        steps, ladder = _ladder(self.matrix, float(widths.max()))
        last = exponentials(self.matrix, widths)
        times: list[Any] = []
        states: list[Any] = []
        for knot, width, start, end in zip(self.knots, widths, self.starts, last, strict=True):
            inside = steps < width
            times += [knot + steps[inside], [knot + width]]
            states += [ladder[inside] @ start, [end @ start]]
        return np.concatenate(times), np.concatenate(states)

    def largest(self, row: NDArray[Any], beyond: float) -> tuple[float, float]:
        """Return the value of largest size of ``row . state``, with its sign, and its time [s].

        It is sought at the probe times, and beside the best of them, and those nearly as good,
        where the exact derivative is zero.
        """
        from scipy.optimize import brentq  # late: it takes 0.3 s to import

        times, states = self.probes(beyond)
        values = np.real(states @ row)
        sizes = np.abs(values)
        k = int(np.argmax(sizes))
        value, time = float(values[k]), float(times[k])
        beside = np.maximum(np.append(sizes[1:], 0.0), np.append(0.0, sizes[:-1]))
        near = np.flatnonzero((sizes >= beside) & (sizes >= (1.0 - _CLOSE) * sizes[k]))

        def rise(step: float, start: NDArray[Any], slope: NDArray[Any]) -> float:
            return float(np.real(slope @ exponentials(self.matrix, np.array([step]))[0] @ start))

        # Knots are there twice, so that a sample may be two places from its summit.
        inside = np.unique(near[:, np.newaxis] + np.arange(-2, 2))
        for i in inside[(inside >= 0) & (inside < times.size - 1)]:
            width, start = float(times[i + 1] - times[i]), states[i]
            slope = np.sign(values[i] + values[i + 1]) * (row @ self.matrix)
            low = 0.0 if rise(0.0, start, slope) > 0.0 else _BEGUN * width
            if width > 0.0 and rise(low, start, slope) > 0.0 > rise(width, start, slope):
                step = float(brentq(rise, low, width, args=(start, slope), xtol=1e-13 * width))
                top = exponentials(self.matrix, np.array([step]))[0] @ start
                found = float(np.real(row @ top))
                if abs(found) > abs(value):
                    value, time = found, float(times[i]) + step
        return value, time


def motion(A: FloatArray, B: FloatArray, pieces: Pieces) -> Motion:
    """Return the motion of x' = A x + B f from rest, f being the pieces of one history.

    Parameters
    ----------
    A, B : ndarray
        One system, ``(n, n)`` and ``(n,)``.
    pieces : Pieces
        The input, not a batch.
    """
    order, rates, powers = len(A), pieces.rates, pieces.degree + 1
    size = order + rates.size * powers
    matrix = np.zeros((size, size), dtype=np.result_type(rates, float))
    matrix[:order, :order] = A
    matrix[:order, order::powers] = B[:, np.newaxis]
    matrix[order:, order:] = np.kron(np.diag(rates), np.eye(powers))
    matrix[order:, order:] += np.kron(np.eye(rates.size), np.eye(powers, k=1))
    inputs = inputs_at(pieces, pieces.knots)
    starts = np.zeros((len(inputs), size), dtype=np.result_type(matrix, inputs))
    starts[:, order:] = inputs
    widths, which = np.unique(np.diff(pieces.knots), return_inverse=True)
    steps = exponentials(matrix, widths)
    for k, step in enumerate(which):
        starts[k + 1, :order] = (steps[step] @ starts[k])[:order]
    return Motion(matrix, pieces.knots, starts)


def inputs_at(pieces: Pieces, times: FloatArray) -> NDArray[Any]:
    """Return the states z of the input at the times ``(m,)``, shape ``(m, size)``."""
    index, u = locate(pieces, times)
    c = moved(pieces.coefficients[index], pieces.rates, np.maximum(u, 0.0))
    scale = np.array([factorial(k) for k in range(pieces.degree + 1)], dtype=float)
    states = (c * scale).reshape(len(times), -1)
    return np.where((u < 0.0)[:, np.newaxis], 0.0, states)


def exponentials(matrix: NDArray[Any], steps: FloatArray) -> NDArray[Any]:
    """Return e^(matrix step) for each of the steps ``(m,)``, shape ``(m, n, n)``.

    By Taylor series, scaling and squaring of the balanced matrix. `scipy.linalg.expm` does the
    same with a linear solve, which for matrices as small as these waits for the threads of its
    BLAS: 16 ms instead of 0.05 ms on a busy machine.
    """
    from scipy.linalg import matrix_balance  # late: it takes 0.1 s to import

    if not matrix.size:
        return np.zeros((len(steps), *matrix.shape))
    matrix, (scale, _) = matrix_balance(matrix, permute=False, separate=True)
    size = float(np.abs(matrix).sum(axis=0).max(initial=0.0))
    longest = float(np.abs(steps).max(initial=0.0))
    squarings = max(int(np.ceil(np.log2(max(size * longest / _SMALL, 1e-300)))), 0)
    scaled = matrix * (steps / 2.0**squarings)[:, np.newaxis, np.newaxis]
    unit = np.eye(len(matrix))
    result = np.broadcast_to(unit, scaled.shape)
    for k in range(_TERMS, 0, -1):
        result = unit + scaled @ result / k
    for _ in range(squarings):
        result = result @ result
    return np.asarray(scale[:, np.newaxis] * result / scale)


def _ladder(matrix: NDArray[Any], longest: float) -> tuple[FloatArray, NDArray[Any]]:
    """Times from zero up to `longest` and beyond, in steps that grow, and e^(matrix t) there.

    A step doubles when every mode that would be too fast for it has died out.
    """
    rates = np.linalg.eigvals(matrix)
    fastest = float(np.abs(rates).max())
    step = min(_FINE / fastest if fastest else np.inf, longest / _EACH)
    factor, start = exponentials(matrix, np.array([step]))[0], np.eye(len(matrix))
    times: list[Any] = [np.zeros(1)]
    powers, now = [start[np.newaxis]], 0.0
    while now < longest:
        lot = start[np.newaxis] @ factor
        single, many = factor, factor
        while len(lot) < _EACH:
            lot = np.concatenate([lot, many @ lot])
            many = many @ many
        times.append(now + step * np.arange(1, _EACH + 1))
        powers.append(lot)
        start, now = lot[-1], now + step * _EACH
        alive = np.abs(rates[-np.real(rates) * now < _DEAD])
        if 2.0 * step * alive.max(initial=0.0) <= _COARSE:
            factor, step = single @ single, 2.0 * step
    return np.concatenate(times), np.concatenate(powers)


def _applied(matrices: NDArray[Any], states: NDArray[Any]) -> NDArray[Any]:
    return np.asarray((matrices @ states[..., np.newaxis])[..., 0])
