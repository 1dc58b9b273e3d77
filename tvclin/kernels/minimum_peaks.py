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
from typing import Any

import numpy as np

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


@kernel
def minimum_peaks(
    steps: VaryingSteps,
    costates: Any,
    reaches: Any,
    poles: Any,
    cells: Any,
    path: Any,
    heights: Any,
    peaks: Any,
    first: int,
    last: int,
) -> None:
    """Write the minimum peaks [rad] of all control from the begin of steps on, ``(n, S + 1)``.

    h = p.b is the effectiveness of the deflection on the costate p of each unstable mode.

    Parameters
    ----------
    steps : VaryingSteps
        Steps, equations and winds of the n cases.
    costates : ndarray
        Of the unstable modes at the end of the last step, the fastest first, ``(n, k, m)``, k up to
        three.
    reaches, poles : ndarray
        Integrals of h after the end, and poles [1/s], of two real modes at most, ``(n, 2)``; zero
        where they are in the cells.
    cells : ndarray
        Integrals of h after the end over cells in which the deflection is constant,
        ``(n, k, cells)``.
    path : ndarray
        States beyond attitude and rate that trim has led to at the ends of steps,
        ``(n, S + 1, m - 2)``.
    heights : ndarray
        Limits [rad] at the ends of steps, ``(n, S + 1)``, NaN where there is none. From the last on
        backwards peaks are written where there is one, down to the first limit below its peak.
    peaks : ndarray
        Written: minimum peaks [rad], ``(n, S + 1)``; always at the begin of the first step.
    first, last : int
        Cases from the first up to the last are computed.
    """
    count, m, modes = steps.lengths.shape[1], steps.equations.shape[3], costates.shape[1]
    size = count + cells.shape[2] + 2
    matrix, rates, state = np.empty((3, m, m + 2)), np.empty((4, m + 2)), np.empty((2, m + 2))
    costate, weights = np.empty((modes, 2, m + 2)), np.empty((modes, size))
    d, sums = np.empty(3), np.empty((3, size))
    for case in range(first, last):
        _initialise_costates(costates[case], reaches[case], cells[case], costate, weights)
        exceeded = False
        for s in range(count, -1, -1):
            if s < count:
                equations_at_ratio(steps, case, s, 0.0, matrix)
                h, wind = steps.lengths[case, s], steps.wind[case, s]
                for k in range(modes):
                    costate_step(matrix, wind, h, costate[k], 0, state, rates)
                    weights[k, s] = costate[k, 0, m]  # integral of h over the step
                    costate[k, 1] = costate[k, 0]
                    costate[k, 1, m] = 0.0
            if s == 0 or (count - s) % _STEPS_PER_ORTHOGONALISATION == 0:
                _orthogonalise(costate, weights, s)
            if s == 0 or not (exceeded or math.isnan(heights[case, s])):
                _unstable_components(costate, path[case, s], d)
                peaks[case, s] = _dual_value(weights, s, d, poles[case], sums)
                exceeded = exceeded or heights[case, s] < peaks[case, s]


@allocation_free
def _initialise_costates(
    costates: Any, reaches: Any, cells: Any, costate: Any, weights: Any
) -> None:
    """Write costates and weights of k modes at the end of the wind, where the integration begins.

    `costates`: p at the end, ``(k, m)``. `reaches`: integrals of p.b after it, of two real modes,
    ``(2,)``. `cells`: such integrals over cells of constant deflection, ``(k, cells)``. `costate`:
    written: p, and its integrals with control and wind, zero, in the second row of ``(k, 2, m +
    2)``. `weights`: written: effect of the deflection after the end on each mode, the last columns
    of ``(k, size)``.
    """
    modes, m = costates.shape
    size, count = weights.shape[1], cells.shape[1]
    for k in range(modes):
        for i in range(m):
            costate[k, 1, i] = costates[k, i]
        costate[k, 1, m], costate[k, 1, m + 1] = 0.0, 0.0
        for j in range(count):
            weights[k, size - 2 - count + j] = cells[k, j]
        for j in range(2):
            weights[k, size - 2 + j] = reaches[j] if j == k else 0.0  # each acts on its own mode


@allocation_free
def _unstable_components(costate: Any, path: Any, d: Any) -> None:
    """Write d ``(k,)``, the unstable components at the end of the wind without further deflection.

    d = p.x + the integral of p.w alpha_w from now on. `costate`: p, the integral of p.b and this
    one, of each mode in the second row of ``(k, 2, m + 2)``. `path`: states x beyond attitude and
    rate, ``(m - 2,)``; those two are zero.
    """
    for k in range(costate.shape[0]):
        d[k] = costate[k, 1, path.size + 3]
        for i in range(path.size):
            d[k] += costate[k, 1, i + 2] * path[i]


@allocation_free
def _orthogonalise(costate: Any, weights: Any, s: int) -> None:
    """Make costates orthonormal in place, and combine their integrals and weights likewise.

    `costate`: p, and integrals of control and wind, of each mode in the second row of ``(k, 2, m +
    2)``. `weights`: effect of the deflection of each step on each mode, ``(k, size)``, from step s
    on.
    """
    modes, m = costate.shape[0], costate.shape[2] - 2
    for k in range(modes):
        for j in range(k + 1):
            product = 0.0
            for i in range(m):
                product += costate[k, 1, i] * costate[j, 1, i]
            if j == k:
                scale, projection = 1.0 / math.sqrt(product), 0.0
            else:
                scale, projection = 1.0, product
            for i in range(m + 2):
                costate[k, 1, i] = scale * (costate[k, 1, i] - projection * costate[j, 1, i])
            for i in range(s, weights.shape[1]):
                weights[k, i] = scale * (weights[k, i] - projection * weights[j, i])


@allocation_free
def _dual_value(weights: Any, s: int, d: Any, poles: Any, sums: Any) -> float:
    """Return the minimum peak [rad] from step s on, the largest ``|lambda.d|/J(lambda)``.

    J is the sum over steps of ``|lambda.weights|``, and lambda a multiplier for each mode.
    `weights`: effect of the deflection of each step on each of k modes, ``(k, size)``. `d`:
    unstable components to be brought to zero, ``(k,)``. `poles`: of two real modes [1/s], ``(2,)``.
    `sums`: work array ``(3, size)``: with lambda.d = 1, J is the sum of ``|a + u b + v c|``, its
    rows.
    """
    modes, cells = weights.shape
    largest, row = 0, 0
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
        return 1.0 / _derivatives(sums, s, 1.0, 0.0, 0.0, poles)[0]  # J, linear in its factor
    if modes == 2:
        return 1.0 / _minimum(sums, s, 1.0, 0.0, poles)[0]  # without v c
    return 1.0 / _minimum_of_three_modes(sums, s, poles)


@allocation_free
def _minimum_of_three_modes(sums: Any, s: int, poles: Any) -> float:
    """Return the minimum over u and v of J, the sum of ``|a + u b + v c|``, by cutting planes.

    `sums`: a, b and c, ``(3, size)``, counted from step s on. `poles`: of two real modes [1/s],
    ``(2,)``, whose integrals after the wind are the last two numbers. The minimum over u is a
    convex function of v, nowhere below its tangents, whose heights at zero are here a_... and
    slopes c_...; the first two touch it at large v, and where two cross the next is taken.
    """
    minimum, a_high, c_high = _minimum(sums, s, 0.0, 1.0, poles)
    a_low, c_low = -a_high, -c_high
    if c_high == 0.0:
        return _minimum(sums, s, 1.0, 0.0, poles)[0]
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
def _minimum(sums: Any, s: int, t: float, v: float, poles: Any) -> tuple[float, float, float]:
    """Return the minimum over u of J, the sum of ``|t a + u b + v c|``, and its slopes by t and v.

    `sums`: a, b and c, ``(3, size)``, counted from step s on. `poles`: of two real modes [1/s],
    ``(2,)``, as in `_derivatives`. J is convex, and nowhere below a tangent t J_t + u J_u + v J_v,
    whose slopes are here a_..., b_... and c_...; the first two touch J at large u of either sign,
    and the next is taken where two cross.
    """
    a_high, b_high, c_high = _derivatives(sums, s, 0.0, 1.0, 0.0, poles)
    a_low, b_low, c_low = -a_high, -b_high, -c_high
    minimum = 0.0
    if b_high == 0.0:
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
    sums: Any, s: int, t: float, u: float, v: float, poles: Any
) -> tuple[float, float, float]:
    """Return the derivatives by t, u and v of J, the sum of ``|t a + u b + v c|``.

    J itself is t, u and v times them. `sums`: a, b and c, ``(3, size)``, counted from step s on.
    The last two numbers of each are integrals of e^(-pole r) over all time r after the end, of two
    modes with `poles` [1/s], ``(2,)``: their sum changes its sign once there at most, at the time
    `turns`.
    """
    a, b, c = 0.0, 0.0, 0.0
    cells = sums.shape[1] - 2
    for i in range(s, cells):
        if t * sums[0, i] + u * sums[1, i] + v * sums[2, i] < 0.0:
            a, b, c = a - sums[0, i], b - sums[1, i], c - sums[2, i]
        else:
            a, b, c = a + sums[0, i], b + sums[1, i], c + sums[2, i]
    fast = poles[0] * (t * sums[0, cells] + u * sums[1, cells] + v * sums[2, cells])
    slow = poles[1] * (t * sums[0, cells + 1] + u * sums[1, cells + 1] + v * sums[2, cells + 1])
    sign = 1.0 if fast + slow >= 0.0 else -1.0
    first, second = sign, sign
    if fast * slow < 0.0 and abs(fast) > abs(slow) and poles[0] > poles[1]:
        turns = math.log(abs(fast) / abs(slow)) / (poles[0] - poles[1])
        first *= 1.0 - 2.0 * math.exp(-poles[0] * turns)
        second *= 1.0 - 2.0 * math.exp(-poles[1] * turns)
    a += first * sums[0, cells] + second * sums[0, cells + 1]
    b += first * sums[1, cells] + second * sums[1, cells + 1]
    c += first * sums[2, cells] + second * sums[2, cells + 1]
    return a, b, c
