"""The motion of a plant carried from knot to knot with as many digits as mpmath is set to keep."""

from itertools import pairwise

import mpmath as mp
import numpy as np

import tvclin as tv


def carried(
    inputs: list[tv.winds.History], times: np.ndarray, matrices: list[np.ndarray]
) -> np.ndarray:
    """The outputs at rising times from zero on: one matrix exponential a step.

    The inputs are straight lines between their knots; beside the states the exponential carries
    their values and slopes.
    """
    A, B, C, D = (mp.matrix(m.tolist()) for m in matrices)
    n = A.rows
    big = mp.zeros(n + 4)
    big[:n, :n], big[:n, n : n + 2] = A, B
    big[n, n + 2] = big[n + 1, n + 3] = 1
    edges = sorted({0.0, *times.tolist(), *(float(k) for h in inputs for k in h.knots)})
    state, rows = mp.zeros(n, 1), []
    for start, stop in pairwise([*edges, edges[-1] + 1.0]):
        lines = mp.zeros(4, 1)
        for i, history in enumerate(inputs):
            piece = int(np.searchsorted(history.knots, start, side="right")) - 1
            if piece >= 0:
                value, slope = (mp.mpf(float(c)) for c in history.pieces.coefficients[piece, 0])
                since = mp.mpf(start) - mp.mpf(float(history.knots[piece]))
                lines[i], lines[i + 2] = value + slope * since, slope
        if start in times:
            rows.append([float(v) for v in C * state + D * lines[:2, 0]])
        state = (mp.expm(big * (mp.mpf(stop) - mp.mpf(start))) * mp.matrix([*state, *lines]))[:n, 0]
    return np.array(rows).T
