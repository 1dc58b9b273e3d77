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

from tvclin.kernels.pieces import Pieces

FloatArray = NDArray[np.float64]

_EACH = 128
"""Steps of one size in the ladder of times; the size doubles from one lot to the next."""
_FINE = 0.1
"""The first step, over the fastest eigenvalue."""
_NEWTON = 6


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

        It is sought at the probe times, and from the best of them by Newton's method on the
        exact derivative, between its neighbours.
        """
        times, states = self.probes(beyond)
        values = np.real(states @ row)
        k = int(np.argmax(np.abs(values)))
        value, time, state = float(values[k]), float(times[k]), states[k]
        low, high = float(times[max(k - 1, 0)]), float(times[min(k + 1, times.size - 1)])
        slope, bend = row @ self.matrix, row @ self.matrix @ self.matrix
        for _ in range(_NEWTON):
            curvature = float(np.real(bend @ state))
            wanted = time - float(np.real(slope @ state)) / curvature if curvature else time
            step = min(max(wanted, low), high) - time
            moved = exponentials(self.matrix, np.array([step]))[0] @ state
            found = float(np.real(row @ moved))
            if abs(found) <= abs(value):
                break
            value, time, state = found, time + step, moved
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
    scale = np.array([factorial(k) for k in range(powers)], dtype=float)
    inputs = (pieces.coefficients * scale).reshape(-1, rates.size * powers)
    starts = np.zeros((len(inputs), size), dtype=np.result_type(matrix, inputs))
    starts[:, order:] = inputs
    widths, which = np.unique(np.diff(pieces.knots), return_inverse=True)
    steps = exponentials(matrix, widths)
    for k, step in enumerate(which):
        starts[k + 1, :order] = (steps[step] @ starts[k])[:order]
    return Motion(matrix, pieces.knots, starts)


def exponentials(matrix: NDArray[Any], steps: FloatArray) -> NDArray[Any]:
    """Return e^(matrix step) for each of the steps ``(m,)``, shape ``(m, n, n)``."""
    from scipy.linalg import expm  # late: it takes 0.1 s to import

    return np.asarray(expm(matrix * steps[:, np.newaxis, np.newaxis]))


def _ladder(matrix: NDArray[Any], longest: float) -> tuple[FloatArray, NDArray[Any]]:
    """Times from zero up to `longest` and beyond, in steps that double, and e^(matrix t) there."""
    fastest = float(np.abs(np.linalg.eigvals(matrix)).max())
    step = min(_FINE / fastest if fastest else np.inf, longest / _EACH)
    factor, start = exponentials(matrix, np.array([step]))[0], np.eye(len(matrix))
    times: list[Any] = [np.zeros(1)]
    powers, now = [start[np.newaxis]], 0.0
    while now < longest:
        lot = start[np.newaxis] @ factor
        single = factor
        while len(lot) < _EACH:
            lot = np.concatenate([lot, factor @ lot])
            factor = factor @ factor
        times.append(now + step * np.arange(1, _EACH + 1))
        powers.append(lot)
        start, now = lot[-1], now + step * _EACH
        factor, step = single @ single, 2.0 * step
    return np.concatenate(times), np.concatenate(powers)


def _applied(matrices: NDArray[Any], states: NDArray[Any]) -> NDArray[Any]:
    return np.asarray((matrices @ states[..., np.newaxis])[..., 0])
