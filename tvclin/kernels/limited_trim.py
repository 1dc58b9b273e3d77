"""Flights of the ideal trim law with deflection limits, through winds of varying equations.

    delta = clip(-(A_2.x + w_2 alpha_w + gain |mu_alpha| z)/b_2, -L, L),    z = theta + theta'/k,

with k the positive root of k^2 - d k = |mu_alpha| and the damping d = -A_22: all moments are
trimmed, that of damping too, and the unstable component of the attitude on a fixed path brought
back. The flight diverges with the limit L if in
the end L, held, cannot bring the unstable component back, |p.x| > L |R| (`trim_and_demand`).
Runge and Kutta's rule of fourth order; where the law meets its limit within a step it is of second.
"""

import math
from typing import Any

import numpy as np

from tvclin.kernels.source import inlined, kernel
from tvclin.kernels.trim_and_demand import equations_at_ratio

PLAIN, COMPILED = 2.5e-5, 2e-8
"""Seconds that a step of one flight takes for each state, in plain Python and as machine code."""


@kernel
def limited_trim(
    lengths: Any,
    equations: Any,
    slopes: Any,
    ratio: Any,
    wind: Any,
    end: Any,
    onset: Any,
    gain: float,
    limits: Any,
    diverged: Any,
    first: int,
    last: int,
) -> None:
    """Write to ``diverged (n, tries)`` which flights with ``limits (n, tries)`` [rad] diverge.

    `lengths` to `onset` are those of `trim_and_demand`; `gain` is that of the attitude feedback
    over trim.
    """
    steps, m, tries = lengths.shape[1], equations.shape[3], limits.shape[1]
    matrix, law = np.empty((3, m, m + 2)), np.empty((3, m + 1))
    states, state, rates = np.empty((tries, m)), np.empty(m), np.empty((4, m))
    for case in range(first, last):
        c = case if equations.shape[0] > 1 else 0
        for k in range(tries):
            for i in range(m):
                states[k, i] = 0.0
        for s in range(int(onset[case]), steps):
            skipped = max(onset[case] - s, 0.0)
            equations_at_ratio(equations, slopes, c, s, ratio[case, s], skipped, matrix)
            for q in range(3):
                _feedback(matrix[q], gain, law[q])
            for k in range(tries):
                _step(
                    matrix,
                    law,
                    wind[case, s],
                    lengths[case, s],
                    limits[case, k],
                    states[k],
                    state,
                    rates,
                )
        for k in range(tries):
            component = 0.0
            for i in range(m):
                component += end[case, i] * states[k, i]
            reached = limits[case, k] * abs(end[case, m])
            diverged[case, k] = not abs(component) <= reached  # also of an overflow


@inlined
def _feedback(matrix: Any, gain: float, law: Any) -> None:
    """Write the feedback gains of the states, and last of the wind angle, ``(m + 1,)``."""
    m = matrix.shape[0]
    for i in range(m):
        law[i] = -matrix[1, i] / matrix[1, m]
    law[m] = -matrix[1, m + 1] / matrix[1, m]
    stiffness, half = abs(matrix[1, 0]), -0.5 * matrix[1, 1]
    rate = half + math.sqrt(half * half + stiffness)
    back = gain * stiffness / matrix[1, m]
    law[0] -= back
    if rate > 0.0:
        law[1] -= back / rate


@inlined
def _step(
    matrix: Any,
    law: Any,
    wind: Any,
    h: float,
    limit: float,
    states: Any,
    state: Any,
    rates: Any,
) -> None:
    """Advance the state x of one flight by one step."""
    m = matrix.shape[1]
    for stage in range(4):
        q, part = (stage + 1) // 2, 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
        deflection = law[q, m] * wind[q]
        for i in range(m):
            state[i] = states[i]
            if stage > 0:
                state[i] += h * part * rates[stage - 1, i]
            deflection += law[q, i] * state[i]
        deflection = max(-limit, min(limit, deflection))
        for i in range(m):
            rates[stage, i] = matrix[q, i, m] * deflection + matrix[q, i, m + 1] * wind[q]
            for j in range(m):
                rates[stage, i] += matrix[q, i, j] * state[j]
    for i in range(m):
        sums = rates[0, i] + 2.0 * (rates[1, i] + rates[2, i]) + rates[3, i]
        states[i] += h / 6.0 * sums
