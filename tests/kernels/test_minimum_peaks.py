"""The kernel of minimum peaks, against linear programs for the deflections themselves."""

import numpy as np
import pytest
from scipy.optimize import linprog

from tvclin.kernels.choice import pinned, run
from tvclin.kernels.minimum_peaks import minimum_peaks
from tvclin.kernels.trim_and_demand import VaryingSteps

STEPS, H = 12, 0.05
FOURTH_ORDER = 1e-6
"""Twelve steps of (H p)^5/120 at a pole p of 1/s, with the rounding of the program."""
CELLS = 2e-5
"""What a deflection that changes its sign within one of a thousand cells needs more."""


def integrals(pole, begin, end):
    """Of exp(-pole t)."""
    return (np.exp(-pole * begin) - np.exp(-pole * end)) / pole


def peak_by_program(weights, d):
    """Return the least peak of deflections of the cells with which weights @ deflection = -d."""
    scale = np.abs(weights).sum(axis=1)
    count = weights.shape[1]
    return linprog(
        np.append(np.zeros(count), 1.0),
        A_ub=np.block([[sign * np.eye(count), -np.ones((count, 1))] for sign in (1.0, -1.0)]),
        b_ub=np.zeros(2 * count),
        A_eq=np.c_[weights / scale[:, np.newaxis], np.zeros(len(d))],
        b_eq=-d / scale,
        bounds=(None, None),
    ).fun


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("poles", [(1.0, 0.3), (1.0, 0.6, 0.2)])
def test_no_deflection_of_constant_equations_has_a_smaller_peak(poles, compiled) -> None:
    """From three steps on; after the end two modes are exact, and three have the same cells."""
    rng = np.random.default_rng(3)
    p, two = np.array(poles)[:, np.newaxis], len(poles) == 2
    left, (b, w) = rng.normal(size=(len(poles), 3)), rng.normal(size=(2, 3))
    A = np.linalg.pinv(left) @ (p * left)
    pushed, blown = (left @ b)[:, np.newaxis], (left @ w)[:, np.newaxis]
    wind, path = rng.normal(size=STEPS), rng.normal(size=STEPS + 1)
    ends = np.append(30.0 / poles[-1] * np.linspace(0.0, 1.0, 1000 if two else 200) ** 2, 1e4)
    after = pushed * integrals(p, ends[:-1], ends[1:])
    steps = VaryingSteps(
        np.full((1, STEPS), H),
        np.tile(np.c_[A, b, w], (1, 1, 3, 1, 1)),
        np.zeros((1, 1, 3, 2, 3, 5)),
        np.ones((1, STEPS, 3)),
        np.repeat(wind, 3).reshape(1, STEPS, 3),
    )
    arguments = (
        steps,
        left[np.newaxis].copy(),
        (pushed / p).reshape(1, -1) if two else np.zeros((1, 2)),
        p.reshape(1, -1) if two else np.zeros((1, 2)),
        after[np.newaxis, :, : 0 if two else None].copy(),
        path.reshape(1, -1, 1),
        np.full((1, STEPS + 1), np.inf),
    )
    peaks = np.zeros((1, STEPS + 1))
    with pinned(compiled):
        run(minimum_peaks, (*arguments, peaks), 1, 1.0, 1.0)
    for first in (0, 5, STEPS):
        remaining = H * np.arange(STEPS - first, -1.0, -1.0)
        inside = integrals(-p, remaining[1:], remaining[:-1])
        d = (
            np.exp(p * remaining[0]) * left[:, 2:] * path[first]
            + blown * inside @ wind[first:, None]
        )
        expected = peak_by_program(np.c_[pushed * inside, after], d[:, 0])
        over = peaks[0, first] / expected - 1.0
        assert -(CELLS if two else FOURTH_ORDER) < over < FOURTH_ORDER
