"""Series connection and discretisation of systems in state space, in batches (A, B, C, D).

`to_steps` and `from_steps` are the bilinear rule and its inverse (Franklin, Powell and Workman,
Digital Control of Dynamic Systems); a series connection is the same in discrete and in continuous
time. python-control and scipy have them for one system at a time: for 1000 systems of order eight
`scipy.signal.cont2discrete` takes thirty times as long.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tvclin.base.arrays import FloatArray

Matrices = tuple[FloatArray, FloatArray, FloatArray, FloatArray]
DIRECT: Matrices = (np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.ones((1, 1)))
"""Matrices A, B, C, D of a direct connection, without states."""


def series(first: Matrices, second: Matrices) -> Matrices:
    """Return A, B, C and D of the second system in series behind the first."""
    (A1, B1, C1, D1), (A2, B2, C2, D2) = first, second
    n = A1.shape[-1], A2.shape[-1]
    A = stacked(join_columns(A1, np.zeros(n)), join_columns(B2 @ C1, A2))
    return A, stacked(B1, B2 @ D1), join_columns(D2 @ C1, C2), D2 @ D1


def to_steps(system: Matrices, c: FloatArray) -> Matrices:
    """Return the discrete-time system by the bilinear rule s = c (z - 1)/(z + 1).

    `system`: A, B, C and D in continuous time. `c`: two over the period, or its value of exact
    mapping at one frequency [1/s], ``(...)``.
    """
    A, B, C, D = system
    c = np.asarray(c)[..., np.newaxis, np.newaxis]
    unit = np.eye(A.shape[-1])
    # (s - A)^-1 = (z + 1) (z - Z)^-1 (c - A)^-1 with Z = (c - A)^-1 (c + A)
    inverse = np.linalg.inv(c * unit - A)
    return inverse @ (c * unit + A), 2.0 * c * (inverse @ B), C @ inverse, D + C @ inverse @ B


def from_steps(system: Matrices, half: FloatArray) -> Matrices:
    """Return the system in w, z = (1 + w h/2)/(1 - w h/2), of a discrete-time system.

    `system`: A, B, C and D. `half`: half the period [s], ``(...)``.
    """
    A, B, C, D = system
    half = np.asarray(half)[..., np.newaxis, np.newaxis]
    unit = np.eye(A.shape[-1])
    # (z - A)^-1 = (1 - w h/2) (w - W)^-1 (1 + A)^-1/(h/2) with W = (1 + A)^-1 (A - 1)/(h/2)
    inverse = np.linalg.inv(unit + A)
    return inverse @ (A - unit) / half, 2.0 / half * (inverse @ B), C @ inverse, D - C @ inverse @ B


def join_columns(*blocks: FloatArray) -> FloatArray:
    """Return blocks concatenated along columns, their batches broadcast."""
    return np.concatenate(_spread(blocks), axis=-1)


def stacked(*blocks: FloatArray) -> FloatArray:
    """Return blocks concatenated along rows, their batches broadcast."""
    return np.concatenate(_spread(blocks), axis=-2)


def _spread(blocks: Sequence[FloatArray]) -> list[FloatArray]:
    shape = np.broadcast_shapes(*(block.shape[:-2] for block in blocks))
    return [np.broadcast_to(block, (*shape, *block.shape[-2:])) for block in blocks]
