"""Minimum peak of any control over all unstable modes of vehicles whose equations vary.

With the costates p_i of the unstable modes, p' = -A^T p integrated backwards from the end of the
wind, a deflection delta brings all unstable components to zero if

    integral of p_i.b delta dt = -d_i,    d_i = p_i.x + integral of p_i.w alpha_w dt,

and the minimum peak of all delta that do is, by the dual of appendix C with varying weights,

    maximum over lambda of |lambda.d| / J(lambda),    J = integral |lambda.h| dt,    h_i = p_i.b.

Backwards all costates turn to that of the fastest mode, so that they are made orthogonal again
every few steps, with the integrals in their coordinates. With lambda.d = 1, J is a convex function
of one variable less than there are modes. Its minimum is where two of its tangents cross, which
are moved until it is known (Kelley's cutting planes); of two variables the tangents of the
minimum over the first are mixed from those that cross there.
"""

import math

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.kernels.source import allocation_free, kernel
from tvclin.kernels.trim_and_demand import VaryingSteps, costate_step, equations_at_ratio

PLAIN, COMPILED = 6e-5, 2e-7
"""Seconds per step and mode of the costates, in plain Python and as machine code."""
CELL_PLAIN, CELL_COMPILED = 5e-7, 1e-9
"""Seconds per step or cell of a sum of J, plain and as machine code."""
_STEPS_PER_ORTHOGONALISATION = 4
"""Steps between two orthogonalisations, the same for all cases so that none depends on others."""
TANGENTS, _MAX_TANGENTS = 15, 60
"""Usual and largest number of tangents of a minimum."""
_RELATIVE_GAP = 1e-9
"""Distance of J from the crossing of its tangents, over J, at which the minimum is known."""
_MAX_MODES = 3
"""Largest number of unstable modes, a complex one counting twice."""
_BEGIN, _END = 0, 1
"""Rows of a mode's work array: begin of a step, to which the costate is integrated, and its end;
between two steps the present time is in the second row."""
_AFTER_WIND = 2
"""Number of the last columns of the weights, integrals over all time after the end of the wind:
the first is of the fastest real mode, the second of the other one."""


@kernel
def minimum_peaks(
    steps: VaryingSteps,
    costates: FloatArray,
    reaches: FloatArray,
    poles: FloatArray,
    cells: FloatArray,
    path: FloatArray,
    heights: FloatArray,
    peaks: FloatArray,
    first: int,
    last: int,
) -> None:
    """Write the minimum peaks [rad] of all control from the begin of steps on, ``(n, S + 1)``.

    The minimum peak from a time on is the smallest size of a deflection that brings the unstable
    modes, from trim at that time, to zero in the end. It is written for the S + 1 times between
    the S steps: number 0 is the begin of the first, number S the end of the wind. The costate p of
    an unstable mode is the row with which p.x is its component of the state x (of m numbers), and
    h = p.b the effect on it of a unit deflection at that time.

    Parameters
    ----------
    steps : VaryingSteps
        Steps, equations and winds of the n cases.
    costates : ndarray
        Costates p of k unstable modes at the end of the last step, the fastest first,
        ``(n, k, m)``, k up to three.
    reaches, poles : ndarray
        Integrals of h over all time after the end, and poles [1/s], of two real modes at most,
        ``(n, 2)``; zero where they are in the cells.
    cells : ndarray
        Integrals of h over cells of the time after the end, in which the deflection is constant,
        ``(n, k, cells)``.
    path : ndarray
        States beyond attitude and rate that trim has led to at the ends of steps,
        ``(n, S + 1, m - 2)``.
    heights : ndarray
        Limits [rad] of the control at these times, ``(n, S + 1)``, NaN where the peak is not
        requested. Backwards from the last, peaks are written where there is a limit, until one is
        above its limit.
    peaks : ndarray
        Written: minimum peaks [rad], ``(n, S + 1)``; always that at the begin of the first step.
    first, last : int
        Cases from the first up to the last are computed.
    """
    count, m, modes = steps.lengths.shape[1], steps.equations.shape[3], costates.shape[1]
    size = count + cells.shape[2] + _AFTER_WIND
    # a row of the work array has p, and the integrals of p.b and of p.w alpha_w: see `costate_step`
    matrix, rates, state = np.empty((3, m, m + 2)), np.empty((4, m + 2)), np.empty((2, m + 2))
    costate, weights = np.empty((modes, 2, m + 2)), np.empty((modes, size))
    d, sums = np.empty(_MAX_MODES), np.empty((_MAX_MODES, size))
    for case in range(first, last):
        _initialise_costates(costates[case], reaches[case], cells[case], costate, weights)
        exceeded = False  # whether a peak is above its limit
        for s in range(count, -1, -1):
            if s < count:
                equations_at_ratio(steps, case, s, 0.0, matrix)
                h, wind = steps.lengths[case, s], steps.wind[case, s]
                for k in range(modes):
                    costate_step(matrix, wind, h, costate[k], _BEGIN, state, rates)
                    weights[k, s] = costate[k, _BEGIN, m]  # integral of p.b over the step
                    costate[k, _END] = costate[k, _BEGIN]
                    costate[k, _END, m] = 0.0
            if s == 0 or (count - s) % _STEPS_PER_ORTHOGONALISATION == 0:
                _orthogonalise(costate, weights, s)
            if s == 0 or not (exceeded or math.isnan(heights[case, s])):
                _unstable_components(costate, path[case, s], d)
                peaks[case, s] = _dual_value(weights, s, d, poles[case], sums)
                exceeded = exceeded or heights[case, s] < peaks[case, s]


@allocation_free
def _initialise_costates(
    costates: FloatArray,
    reaches: FloatArray,
    cells: FloatArray,
    costate: FloatArray,
    weights: FloatArray,
) -> None:
    """Write costates and weights of k modes at the end of the wind, where the integration begins.

    `costates`: p at the end, ``(k, m)``. `reaches`: integrals of p.b after it, of two real modes,
    ``(2,)``. `cells`: such integrals over cells of constant deflection, ``(k, cells)``. `costate`:
    written: p, and the integrals of p.b and p.w alpha_w, zero, in the row `_END` of ``(k, 2, m +
    2)``. `weights`: written: effect of the deflection after the end on each mode, the last columns
    of ``(k, size)``: of each cell, and `_AFTER_WIND` for the `reaches`.
    """
    modes, m = costates.shape
    size, count = weights.shape[1], cells.shape[1]
    for k in range(modes):
        for i in range(m):
            costate[k, _END, i] = costates[k, i]
        costate[k, _END, m], costate[k, _END, m + 1] = 0.0, 0.0
        for j in range(count):
            weights[k, size - _AFTER_WIND - count + j] = cells[k, j]
        for j in range(_AFTER_WIND):  # each column acts on its own mode
            weights[k, size - _AFTER_WIND + j] = reaches[j] if j == k else 0.0


@allocation_free
def _unstable_components(costate: FloatArray, path: FloatArray, d: FloatArray) -> None:
    """Write d ``(k,)``, the unstable components at the end of the wind without further deflection.

    d = p.x + the integral of p.w alpha_w from the present time on. `costate`: of each mode in the
    row `_END` of ``(k, 2, m + 2)``: the m numbers of p, the integral of p.b, and last that of p.w
    alpha_w. `path`: the m - 2 states x beyond attitude and rate, which are zero, at this time.
    """
    m = path.size + 2
    for k in range(costate.shape[0]):
        d[k] = costate[k, _END, m + 1]  # the integral of p.w alpha_w
        for i in range(path.size):
            d[k] += costate[k, _END, i + 2] * path[i]


@allocation_free
def _orthogonalise(costate: FloatArray, weights: FloatArray, s: int) -> None:
    """Make costates orthonormal in place, and combine their integrals and weights likewise.

    By Gram and Schmidt's method, the first mode first. `costate`: p ``(m,)``, and the integrals of
    p.b and p.w alpha_w, of each mode in the row `_END` of ``(k, 2, m + 2)``. `weights`: effect of a
    unit deflection in each step or cell on each mode, ``(k, size)``, set from step s on.
    """
    modes, m = costate.shape[0], costate.shape[2] - 2
    for k in range(modes):
        for j in range(k + 1):
            product = 0.0
            for i in range(m):
                product += costate[k, _END, i] * costate[j, _END, i]
            if j == k:
                scale, projection = 1.0 / math.sqrt(product), 0.0
            else:
                scale, projection = 1.0, product
            for i in range(m + 2):
                difference = costate[k, _END, i] - projection * costate[j, _END, i]
                costate[k, _END, i] = scale * difference
            for i in range(s, weights.shape[1]):
                weights[k, i] = scale * (weights[k, i] - projection * weights[j, i])


@allocation_free
def _dual_value(
    weights: FloatArray, s: int, d: FloatArray, poles: FloatArray, sums: FloatArray
) -> float:
    """Return the minimum peak [rad] from step s on, the largest ``|lambda.d|/J(lambda)``.

    J is the sum over steps of ``|lambda.weights|``, and lambda a multiplier for each mode.
    `weights`: effect of the deflection of each step on each of k modes, ``(k, size)``. `d`:
    unstable components to be brought to zero, ``(k,)``. `poles`: of two real modes [1/s], ``(2,)``.
    `sums`: work array, whose rows a, b and c ``(3, size)`` eliminate the multiplier of the largest
    component by lambda.d = 1: J is then the sum of ``|a + u b + v c|``, u and v being the others.
    """
    modes, cells = weights.shape
    largest, row = 0, 0  # mode of the largest component; row of another mode in the sums
    for k in range(modes):
        if abs(d[k]) > abs(d[largest]):
            largest = k
    if d[largest] == 0.0:
        return 0.0
    for i in range(s, cells):
        sums[0, i], sums[1, i], sums[2, i] = weights[largest, i] / d[largest], 0.0, 0.0
    for k in range(modes):
        if k != largest:
            row += 1
            for i in range(s, cells):
                sums[row, i] = weights[k, i] - d[k] * sums[0, i]
    if modes == 1:
        J, _, _ = _derivatives(sums, s, 1.0, 0.0, 0.0, poles)  # J of t a is t times J_t, t = 1
        return 1.0 / J
    if modes == 2:
        minimum, _, _ = _minimum(sums, s, 1.0, 0.0, poles)  # t = 1 and v = 0: without v c
        return 1.0 / minimum
    return 1.0 / _minimum_of_three_modes(sums, s, poles)


@allocation_free
def _minimum_of_three_modes(sums: FloatArray, s: int, poles: FloatArray) -> float:
    """Return the minimum over u and v of J, the sum of ``|a + u b + v c|``, by cutting planes.

    `sums`: rows a, b and c, ``(3, size)``, summed from column s on. `poles`: of two real modes
    [1/s], ``(2,)``, whose integrals after the wind are the last two columns. The minimum over u is
    a convex function of v, nowhere below its tangents a_... + c_... v; those of negative slope are
    `low` and those of positive slope `high`. The first two touch it at large v of either sign, and
    where two cross the next is taken.
    """
    # t = 0, v = 1: the slope at large v; the tangents there pass through zero
    minimum, a_high, c_high = _minimum(sums, s, 0.0, 1.0, poles)
    a_low, c_low = -a_high, -c_high
    if c_high == 0.0:  # J does not depend on v
        minimum, _, _ = _minimum(sums, s, 1.0, 0.0, poles)
        return minimum
    for _ in range(_MAX_TANGENTS):
        v = (a_low - a_high) / (c_high - c_low)
        minimum, a, c = _minimum(sums, s, 1.0, v, poles)
        if minimum - (a_high + c_high * v) <= _RELATIVE_GAP * minimum:
            break
        if c > 0.0:
            a_high, c_high = a, c
        else:
            a_low, c_low = a, c
    return minimum


@allocation_free
def _minimum(
    sums: FloatArray, s: int, t: float, v: float, poles: FloatArray
) -> tuple[float, float, float]:
    """Return the minimum over u of J, the sum of ``|t a + u b + v c|``, and its slopes by t and v.

    `sums`: rows a, b and c, ``(3, size)``, summed from column s on. `poles`: of two real modes
    [1/s], ``(2,)``, as in `_derivatives`. J is convex, and nowhere below a tangent t J_t + u J_u +
    v J_v, whose slopes are here a_..., b_... and c_...: `low` with a negative b, `high` with a
    positive one. The first two touch J at large u of either sign, and the next is taken where two
    cross.
    """
    a_high, b_high, c_high = _derivatives(sums, s, 0.0, 1.0, 0.0, poles)
    a_low, b_low, c_low = -a_high, -b_high, -c_high
    minimum = 0.0
    if b_high == 0.0:  # J does not depend on u
        a_high, b_high, c_high = _derivatives(sums, s, t, 0.0, v, poles)
        return t * a_high + v * c_high, a_high, c_high
    for _ in range(_MAX_TANGENTS):
        u = (t * (a_low - a_high) + v * (c_low - c_high)) / (b_high - b_low)
        a, b, c = _derivatives(sums, s, t, u, v, poles)
        minimum = t * a + u * b + v * c
        if minimum - (t * a_high + u * b_high + v * c_high) <= _RELATIVE_GAP * minimum:
            break
        if b > 0.0:
            a_high, b_high, c_high = a, b, c
        else:
            a_low, b_low, c_low = a, b, c
    low_weight = b_high / (b_high - b_low)  # of the lower tangent, with which J_u is zero
    return (
        minimum,
        low_weight * a_low + (1.0 - low_weight) * a_high,
        low_weight * c_low + (1.0 - low_weight) * c_high,
    )


@allocation_free
def _derivatives(
    sums: FloatArray, s: int, t: float, u: float, v: float, poles: FloatArray
) -> tuple[float, float, float]:
    """Return the derivatives J_t, J_u, J_v of J, the sum over columns of ``|t a + u b + v c|``.

    J itself is t J_t + u J_u + v J_v. `t`, `u`, `v`: the multipliers, t that of the end conditions
    together, u and v of two further modes (see `_dual_value`). `sums`: their rows a, b and c,
    ``(3, size)``, summed from column s on. A column has the effects of a unit deflection, on the
    modes in the measure of their multipliers, in a step of the wind or a part of one. The last two
    are integrals over all time r after the end, of w e^(-pole r) with the `poles` [1/s] of two
    modes, ``(2,)``, so that w = pole times the column. Their contribution to J is the integral of
    the size of fast e^(-pole_0 r) + slow e^(-pole_1 r), whose sign changes once at most, at the
    time `turns`.
    """
    a, b, c = 0.0, 0.0, 0.0  # J_t, J_u and J_v
    cells = sums.shape[1] - _AFTER_WIND  # index of the integral of the fast mode; the slow is next
    for i in range(s, cells):
        if t * sums[0, i] + u * sums[1, i] + v * sums[2, i] < 0.0:
            a, b, c = a - sums[0, i], b - sums[1, i], c - sums[2, i]
        else:
            a, b, c = a + sums[0, i], b + sums[1, i], c + sums[2, i]
    # the terms of both modes at r = 0; and the factors of their columns, +1 or -1 without a change
    fast = poles[0] * (t * sums[0, cells] + u * sums[1, cells] + v * sums[2, cells])
    slow = poles[1] * (t * sums[0, cells + 1] + u * sums[1, cells + 1] + v * sums[2, cells + 1])
    sign = 1.0 if fast + slow >= 0.0 else -1.0
    fast_factor, slow_factor = sign, sign
    if fast * slow < 0.0 and abs(fast) > abs(slow) and poles[0] > poles[1]:
        turns = math.log(abs(fast) / abs(slow)) / (poles[0] - poles[1])
        fast_factor *= 1.0 - 2.0 * math.exp(-poles[0] * turns)
        slow_factor *= 1.0 - 2.0 * math.exp(-poles[1] * turns)
    a += fast_factor * sums[0, cells] + slow_factor * sums[0, cells + 1]
    b += fast_factor * sums[1, cells] + slow_factor * sums[1, cells + 1]
    c += fast_factor * sums[2, cells] + slow_factor * sums[2, cells + 1]
    return a, b, c
