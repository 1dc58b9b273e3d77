"""Vehicles whose equations vary over a wind, case by case: trim and demand, and limited flights.

    x' = A x + b delta + w alpha_w,    [A b w] = E(t) + (r - 1) E_1(t) + (1/r - 1) E_2(t),

with r = q/q_n, the dynamic pressure encountered over the nominal one. Backwards from the end of
the wind the costate p, the control reach R of a unit deflection and the remaining wind integral F,

    p' = -A^T p,    R' = -b.p,    F' = -w.p alpha_w,

scaled to |p| = 1 after each step; forwards the path x under ideal trim, attitude and rate at rest,

    delta_trim = -(A_2.x + w_2 alpha_w)/b_2,    demand = -(p.x + F)/R.

Of g = p.x + F the slope is g' = p.b delta_trim, so that demand' = p.b (demand - delta_trim)/R. Both
marches are Runge and Kutta's of fourth order; equations are given at the begin, the middle and the
end of each step, where the wind may jump between steps.

The ideal trim law with a deflection limit L is

    delta = clip(-(A_2.x + w_2 alpha_w + gain |mu_alpha| z)/b_2, -L, L),    z = theta + theta'/k,

with k the positive root of k^2 - d k = |mu_alpha| and the damping d = -A_22: all moments are
trimmed, that of damping too, and the unstable component of the attitude on a fixed path brought
back. Its flight diverges if in the end L, constant, cannot bring the unstable component back,
|p.x| > L |R|, or if its attitude has left the range of the linear equations before. Where the law
reaches its limit within a step the rule is of second order.
"""

import math
from typing import NamedTuple

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.kernels.source import inlined, kernel

PLAIN, COMPILED = 1.3e-4, 2e-7
"""About how many seconds a step takes, in plain Python and as machine code."""


class VaryingSteps(NamedTuple):
    """Steps of winds, and the equations x' = A x + b delta + w alpha_w of vehicles over them.

    E = [A b w] at nominal dynamic pressure has the m columns of A, column m for the deflection, and
    column m + 1 for the wind; states 0 and 1 are attitude and its rate. `lengths`: lengths of the
    steps [s], ``(n, S)``. `equations`: E at begin, middle and end of each step, ``(n, S, 3, m, m +
    2)``; of a first or second axis of length one the only entry holds for all. `slopes`: E_1 and
    E_2 there, the terms of E proportional to r and to 1/r, ``(n, S, 3, 2, m, m + 2)``. `ratio`,
    `wind`: r, dynamic pressure over nominal, and alpha_w [rad] there, ``(n, S, 3)``.
    """

    lengths: FloatArray
    equations: FloatArray
    slopes: FloatArray
    ratio: FloatArray
    wind: FloatArray


@kernel
def trim_and_demand(
    steps: VaryingSteps,
    end: FloatArray,
    onset: FloatArray,
    trim: FloatArray,
    trim_range: FloatArray,
    demand: FloatArray,
    demand_slope: FloatArray,
    path: FloatArray,
    first: int,
    last: int,
) -> None:
    """Write trim [rad], demand [rad], its slopes [rad/s] and the path under trim of each case.

    The demand is the constant deflection that suffices from then on, -(p.x + F)/R with costate p of
    the unstable mode, control reach R of a unit deflection, and integral F of the remaining wind.

    Parameters
    ----------
    steps : VaryingSteps
        Steps, equations and winds of the n cases.
    end : ndarray
        Costate p of the fastest unstable mode and control reach R, at the end of the last step,
        ``(n, m + 1)``.
    onset : ndarray
        Position at which each wind begins, in steps, ``(n,)``: 2.3 is in the third, whose length,
        pressure ratio and wind then hold from there on. Before it nothing is written.
    trim, demand : ndarray
        Written: both at begin, middle and end of each step [rad], ``(n, S, 3)``.
    trim_range : ndarray
        Widened: smallest and largest trim [rad], ``(n, 2)``, to the parabolas of trim in the steps.
    demand_slope : ndarray
        Written: slopes of the demand at begin and end of each step [rad/s], ``(n, S, 2)``.
    path : ndarray
        Written: states beyond attitude and rate at the ends of the steps, ``(n, S + 1, m - 2)``.
    first, last : int
        Cases from the first up to the last are computed.
    """
    count, m = steps.lengths.shape[1], steps.equations.shape[3]
    # of each step [A b w] at begin, middle and end; and at its ends p, R and F, ``m + 2`` numbers
    matrices, costate = np.empty((count, 3, m, m + 2)), np.empty((count + 1, m + 2))
    state, rates = np.empty((2, m + 2)), np.empty((4, m + 2))
    for case in range(first, last):
        lengths, wind = steps.lengths[case], steps.wind[case]
        for i in range(m + 1):
            costate[count, i] = end[case, i]
        costate[count, m + 1] = 0.0  # no wind remains
        begin = int(onset[case])
        for s in range(count - 1, begin - 1, -1):
            matrix = matrices[s]
            equations_at_ratio(steps, case, s, max(onset[case] - s, 0.0), matrix)
            costate_step(matrix, wind[s], lengths[s], costate, s, state, rates)
            _normalise(costate[s])
        for i in range(2, m):
            path[case, begin, i - 2] = 0.0
        for s in range(begin, count):
            h, matrix = lengths[s], matrices[s]
            _path_step(matrix, wind[s], h, path[case], s, state, rates)
            trim[case, s, 0] = _trim(matrix, 0, path[case, s], wind[s, 0])
            trim[case, s, 2] = _trim(matrix, 2, path[case, s + 1], wind[s, 2])
            for i in range(m - 2):  # the path in the middle, by Hermite's cubic
                total = path[case, s, i] + path[case, s + 1, i]
                state[0, i] = 0.5 * total + h / 8.0 * (rates[0, i + 2] - rates[3, i + 2])
            trim[case, s, 1] = _trim(matrix, 1, state[0], wind[s, 1])
            _widen(trim_range[case], trim[case, s])
            for j in range(2):  # begin and end of the step, numbers 0 and 2 of three
                # g = p.x + F, p.b, and the control reach R
                g, effect, R = costate[s + j, m + 1], 0.0, costate[s + j, m]
                for i in range(m):
                    effect += costate[s + j, i] * matrix[2 * j, i, m]
                for i in range(m - 2):
                    g += costate[s + j, i + 2] * path[case, s + j, i]
                demand[case, s, 2 * j] = -g / R
                demand_slope[case, s, j] = effect * (-g / R - trim[case, s, 2 * j]) / R
            # the demand in the middle, by Hermite's cubic
            mean = 0.5 * (demand[case, s, 0] + demand[case, s, 2])
            bend = demand_slope[case, s, 0] - demand_slope[case, s, 1]
            demand[case, s, 1] = mean + h / 8.0 * bend


@inlined
def equations_at_ratio(
    steps: VaryingSteps, case: int, s: int, skipped: float, matrix: FloatArray
) -> None:
    """Write [A b w] of a case at begin, middle and end of step s, at the encountered pressure.

    They are E + (r - 1) E_1 + (1/r - 1) E_2, r being the dynamic pressure encountered over the
    nominal one: `steps` has E, `equations`, which hold at r = 1, the terms E_1 and E_2 that are
    proportional to r and to 1/r, `slopes`, and r, `ratio`. `skipped`: fraction of the step before
    the wind begins; the matrices are then at begin, middle and end of the rest, by parabolas
    through the three given ones. `matrix`: written, ``(3, m, m + 2)``.
    """
    equations, slopes, m = steps.equations, steps.slopes, matrix.shape[1]
    # an axis of length one has the only entry for all cases, or for all steps
    c, k = case if equations.shape[0] > 1 else 0, s if equations.shape[1] > 1 else 0
    for q in range(3):
        ratio = steps.ratio[case, s, q]
        direct, inverse = ratio - 1.0, 1.0 / ratio - 1.0
        u = skipped + 0.5 * q * (1.0 - skipped)  # fraction of the step
        for i in range(m):
            for j in range(m + 2):
                change = direct * slopes[c, k, q, 0, i, j] + inverse * slopes[c, k, q, 1, i, j]
                matrix[q, i, j] = equations[c, k, q, i, j] + change
                if skipped > 0.0:
                    matrix[q, i, j] = 0.0
                    for p in range(3):  # of the parabola through begin, middle and end
                        change = direct * slopes[c, k, p, 0, i, j]
                        change += inverse * slopes[c, k, p, 1, i, j]
                        weight = 4.0 * u * (1.0 - u)
                        if p != 1:
                            weight = (2.0 * u - 1.0) * (u if p == 2 else u - 1.0)
                        matrix[q, i, j] += weight * (equations[c, k, p, i, j] + change)


@inlined
def costate_step(
    matrix: FloatArray,
    wind: FloatArray,
    h: float,
    costate: FloatArray,
    s: int,
    state: FloatArray,
    rates: FloatArray,
) -> None:
    """Write costate p, control reach R and wind integral F at the begin of a step, by Runge-Kutta.

    R and F are the effects of a unit deflection and of the wind on the unstable component from
    then on: dp/dt = -p A, dR/dt = -p.b, dF/dt = -p.w alpha_w. The step goes backwards from row
    `s + 1` of `costate`, p, R and F ``(m + 2,)``, to row `s`; a factor common to the first remains,
    since the equations are linear in p. `matrix`: columns ``[A b w]`` at begin, middle and end of
    the step, ``(3, m, m + 2)``. `wind`: alpha_w there [rad], ``(3,)``. `h`: its length [s].
    `state`, `rates`: work arrays, of m columns at least, and ``(4, m + 2)`` by stage.
    """
    m = matrix.shape[1]
    for stage in range(4):
        # q: end, middle, middle and begin of the step, of which the fraction is gone back
        q, fraction = 2 - (stage + 1) // 2, 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
        for i in range(m):
            state[0, i] = costate[s + 1, i]
            if stage > 0:
                state[0, i] += h * fraction * rates[stage - 1, i]
        for j in range(m + 2):
            rates[stage, j] = 0.0
            for i in range(m):
                rates[stage, j] += matrix[q, i, j] * state[0, i]
        rates[stage, m + 1] *= wind[q]
    for j in range(m + 2):
        sums = rates[0, j] + 2.0 * (rates[1, j] + rates[2, j]) + rates[3, j]
        costate[s, j] = costate[s + 1, j] + h / 6.0 * sums


@inlined
def _normalise(costate: FloatArray) -> None:
    """Scale costate p and its integrals R and F, a row ``(m + 2,)``, to ``|p| = 1`` in place."""
    size = 0.0
    for i in range(costate.size - 2):
        size += costate[i] * costate[i]
    for i in range(costate.size):
        costate[i] /= math.sqrt(size)


@inlined
def _path_step(
    matrix: FloatArray,
    wind: FloatArray,
    h: float,
    path: FloatArray,
    s: int,
    state: FloatArray,
    rates: FloatArray,
) -> None:
    """Write the path states under ideal trim at the end of step s, by Runge-Kutta.

    They are the states beyond attitude and rate, which stay at rest: rows s and s + 1 of `path`
    ``(S + 1, m - 2)``. `matrix`: columns ``[A b w]`` of x' = A x + b delta + w alpha_w at begin,
    middle and end of the step. `wind`: alpha_w there [rad], ``(3,)``. `h`: its length [s]. `state`,
    `rates`: work arrays; the slopes at begin and end stay in rows 0 and 3 of `rates`, by state.
    """
    m = matrix.shape[1]
    for stage in range(4):
        # q: begin, middle, middle and end of the step
        q, fraction = (stage + 1) // 2, 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
        for i in range(m - 2):
            state[0, i] = path[s, i]
            if stage > 0:
                state[0, i] += h * fraction * rates[stage - 1, i + 2]
        _path_rates(matrix, q, state[0], wind[q], rates[stage])
    for i in range(m - 2):
        sums = rates[0, i + 2] + 2.0 * (rates[1, i + 2] + rates[2, i + 2]) + rates[3, i + 2]
        path[s + 1, i] = path[s, i] + h / 6.0 * sums
    _path_rates(matrix, 2, path[s + 1], wind[2], rates[3])


@inlined
def _path_rates(
    matrix: FloatArray, q: int, path: FloatArray, wind: float, rates: FloatArray
) -> None:
    """Write the derivatives of the path states under ideal trim to `rates`, from index 2 on.

    Indices 0 and 1 are of attitude and rate, which are zero. `matrix`: columns ``[A b w]`` of x' =
    A x + b delta + w alpha_w at three times, ``(3, m, m + 2)``, of which number q is taken. `path`:
    the states beyond these two, ``(m - 2,)``. `wind`: wind angle of attack [rad].
    """
    m = matrix.shape[1]
    deflection = _trim(matrix, q, path, wind)
    for i in range(2, m):
        rates[i] = matrix[q, i, m] * deflection + matrix[q, i, m + 1] * wind
        for j in range(2, m):
            rates[i] += matrix[q, i, j] * path[j - 2]


@inlined
def _trim(matrix: FloatArray, q: int, path: FloatArray, wind: float) -> float:
    """Return the deflection [rad] of ideal trim, with attitude and rate zero.

    It balances the moments, row 1 of the equations, that of the attitude rate. `matrix`: columns
    ``[A b w]`` of x' = A x + b delta + w alpha_w at three times, ``(3, m, m + 2)``, of which number
    q is taken; b is column m, w column m + 1. `path`: states beyond attitude and rate, ``(m -
    2,)``. `wind`: wind angle of attack [rad].
    """
    m = matrix.shape[1]
    moment = matrix[q, 1, m + 1] * wind
    for j in range(2, m):
        moment += matrix[q, 1, j] * path[j - 2]
    return -moment / matrix[q, 1, m]


@inlined
def _widen(trim_range: FloatArray, trim: FloatArray) -> None:
    """Widen the smallest and the largest trim [rad], ``(2,)``, to those of the parabola of a step.

    `trim`: at begin, middle and end of the step [rad], ``(3,)``. Both stay NaN from a NaN on.
    """
    slope, bend = 4.0 * trim[1] - 3.0 * trim[0] - trim[2], trim[0] - 2.0 * trim[1] + trim[2]
    for k in range(4):
        value = trim[min(k, 2)]
        if k == 3 and 0.0 < -slope * bend < 4.0 * bend * bend:  # the vertex, within the step
            value = trim[0] - slope * slope / (8.0 * bend)
        if value < trim_range[0] or math.isnan(value):
            trim_range[0] = value
        if value > trim_range[1] or math.isnan(value):
            trim_range[1] = value


LIMITED_PLAIN, LIMITED_COMPILED = 2.5e-5, 2e-8
"""Seconds that a step of one flight takes for each state, in plain Python and as machine code."""


@kernel
def limited_trim(
    steps: VaryingSteps,
    end: FloatArray,
    onset: FloatArray,
    gain: float,
    max_attitude: FloatArray,
    checked: int,
    limits: FloatArray,
    diverged: BoolArray,
    first: int,
    last: int,
) -> None:
    """Write to ``diverged (n, tries)`` which flights with ``limits (n, tries)`` [rad] diverge.

    They are flights of the ideal trim law with a deflection limit L, which diverge if in the end L
    cannot bring the unstable component back, ``|p.x| > L |R|``. `steps`: steps, equations and winds
    of the n cases. `end`: costate p and control reach R of a unit deflection at the end, ``(n, m +
    1)``. `onset`: position at which each wind begins, in steps, ``(n,)``: 2.3 is in the third,
    whose length and wind in `steps` are of the rest from there on. `gain`: feedback of the attitude
    in the law (head of this file), in multiples of ``|mu_alpha|``. `max_attitude`:
    attitudes [rad] beyond which a flight counts as diverged, ``(n,)``, in the first `checked`
    steps. Cases from `first` up to `last` are computed.
    """
    count, m, tries = steps.lengths.shape[1], steps.equations.shape[3], limits.shape[1]
    matrix, law = np.empty((3, m, m + 2)), np.empty((3, m + 1))
    states, state, rates = np.empty((tries, m)), np.empty(m), np.empty((4, m))
    for case in range(first, last):
        for k in range(tries):
            diverged[case, k] = False
            for i in range(m):
                states[k, i] = 0.0
        for s in range(int(onset[case]), count):
            equations_at_ratio(steps, case, s, max(onset[case] - s, 0.0), matrix)
            for q in range(3):
                _trim_law_gains(matrix[q], gain, law[q])
            h, wind = steps.lengths[case, s], steps.wind[case, s]
            for k in range(tries):
                _limited_step(matrix, law, wind, h, limits[case, k], states[k], state, rates)
                if s < checked and abs(states[k, 0]) > max_attitude[case]:
                    diverged[case, k] = True
        for k in range(tries):
            component = 0.0  # p.x
            for i in range(m):
                component += end[case, i] * states[k, i]
            reached = limits[case, k] * abs(end[case, m])  # L |R|
            diverged[case, k] = diverged[case, k] or not abs(component) <= reached  # or an overflow


@inlined
def _trim_law_gains(matrix: FloatArray, gain: float, law: FloatArray) -> None:
    """Write the feedback gains of the states, and last of the wind angle, ``law (m + 1,)``.

    The ideal trim law is delta = -(A_2.x + w_2 alpha_w + gain ``|mu_alpha|`` z)/b_2 with A_2, w_2
    and b_2 the row of the moments, mu_alpha = A_21 and z = theta + theta'/k, the unstable component
    of the attitude: k is the positive root of k^2 - d k = ``|mu_alpha|``, d = -A_22 the damping.
    `matrix`: ``[A b w]``, ``(m, m + 2)``, row 1 that of the moments, b column m, w column m + 1.
    `gain`: feedback of z, in multiples of ``|mu_alpha|``.
    """
    m = matrix.shape[0]
    for i in range(m):
        law[i] = -matrix[1, i] / matrix[1, m]
    law[m] = -matrix[1, m + 1] / matrix[1, m]
    stiffness, half = abs(matrix[1, 0]), -0.5 * matrix[1, 1]
    rate = half + math.sqrt(half * half + stiffness)  # k
    back = gain * stiffness / matrix[1, m]
    law[0] -= back
    if rate > 0.0:
        law[1] -= back / rate


@inlined
def _limited_step(
    matrix: FloatArray,
    law: FloatArray,
    wind: FloatArray,
    h: float,
    limit: float,
    states: FloatArray,
    state: FloatArray,
    rates: FloatArray,
) -> None:
    """Advance the states ``(m,)`` of a flight of the limited trim law by a step, by Runge-Kutta.

    `matrix`: columns ``[A b w]`` of x' = A x + b delta + w alpha_w at begin, middle and end of the
    step. `law`: gains of states and wind there, ``(3, m + 1)``. `wind`: alpha_w there [rad],
    ``(3,)``. `h`: its length [s]. `limit`: deflection limit [rad]. `states`: changed. `state`,
    `rates`: work arrays, ``(m,)``, and ``(4, m)`` by stage.
    """
    m = matrix.shape[1]
    for stage in range(4):
        # q: begin, middle, middle and end of the step
        q, fraction = (stage + 1) // 2, 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
        deflection = law[q, m] * wind[q]
        for i in range(m):
            state[i] = states[i]
            if stage > 0:
                state[i] += h * fraction * rates[stage - 1, i]
            deflection += law[q, i] * state[i]
        deflection = max(-limit, min(limit, deflection))
        for i in range(m):
            rates[stage, i] = matrix[q, i, m] * deflection + matrix[q, i, m + 1] * wind[q]
            for j in range(m):
                rates[stage, i] += matrix[q, i, j] * state[j]
    for i in range(m):
        sums = rates[0, i] + 2.0 * (rates[1, i] + rates[2, i]) + rates[3, i]
        states[i] += h / 6.0 * sums
