"""The minimum-peak problem with any number of unstable poles, by its dual.

    minimum peak = max over lambda of  lambda . d / integral |lambda . e(u)| du

and the deflection is the peak times the sign of the best lambda . e (the L-problem of moments).
A small linear program on a grid, for a deflection that is constant in cells, finds where the sign
changes; its prices are multipliers. Newton's iteration on

    L1(lambda)^2/2 - lambda . d  ->  min,      at the minimum L1 = peak,

takes it to rounding. With m = integral e sgn(lambda . e), the gradient of L1, and the zeros t_j of
the sum, its gradient is L1 m - d and its Hessian

    m m' + L1 sum over j of 2 e(t_j) e(t_j)'/|slope of the sum at t_j| .
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from operator import attrgetter

import numpy as np

from tvclin.base.arrays import FloatArray, IndexArray
from tvclin.boundary.optimum.moments import (
    TRUNCATED,
    Constraints,
    SignedSum,
    Window,
    decay_spaced_times,
)

_RELATIVE_LP_TOLERANCE = 1e-6
"""Size, relative to the largest, that counts as below the tolerance of a linear program."""
_NEWTON_STEPS = 60
"""Newton steps from one start: more than quadratic convergence takes, for several small
multipliers. Where they do not suffice the grid is refined, and a result that has not converged says
so."""
_STEP_LENGTHS = 12
"""Number of trial lengths of a Newton step, each half the previous: down to 1/2048 of it."""
_RELATIVE_RESIDUAL = 1e-13
"""Violation of a condition relative to the sizes of its terms: some hundred roundings."""
_SINGULAR_VALUE_CUTOFF = 1e-13
"""Singular value of a Newton step, relative to the largest, below which it is rounding: no step
along its direction."""
_GRID_REFINEMENTS = 4
"""Grids of the linear program, each finer, on which Newton's iteration is started."""


def grid_optimum(constraints: Constraints, cells: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the deflection of minimum peak that is constant in each cell, and its multipliers.

    `constraints`: n conditions on the moments. `cells`: breakpoints [s] of k cells, ``(k + 1,)``;
    the last may be infinite. Returned: levels in [-1, 1], the deflection normalised by its peak,
    ``(k,)``, and the multipliers (prices of the conditions), ``(n,)``, not scaled.

    The multiplier of a slow pole that matters only long after the others have decayed is many
    decades below theirs, and below the tolerance of a linear program. So the program is solved
    again for the later cells: it maximises the moments of the poles whose multipliers are
    determined, under the conditions of the others.
    """
    # The largest t for which some levels |v_j| <= 1 have the moments t d: then 1/t is the peak.
    moments = constraints.moments(cells)
    sizes = np.abs(moments).sum(axis=1)
    demands = constraints.demands / np.abs(constraints.demands / sizes).max()
    # variables: the level of each cell, and t
    rows = np.column_stack([moments, -demands]) / sizes[:, np.newaxis]
    cost = np.append(np.zeros(cells.size - 1), -1.0)
    solution = _linear_program(cost, rows, np.zeros(sizes.size), (0.0, None))
    if solution is None:
        return np.ones(cells.size - 1), constraints.demands / sizes**2
    variables, prices = solution
    levels, prices = variables[:-1], prices / sizes
    determined, first = np.abs(prices) * sizes > _RELATIVE_LP_TOLERANCE, 0
    while not np.all(determined) and np.any(determined):
        decays = constraints.decays[determined, None]
        # size of the sum of the determined poles at the cells: the rest decides where it is small
        strength = np.abs(prices[determined]) @ np.exp(-decays * cells[:-1])
        later = np.flatnonzero(strength < _RELATIVE_LP_TOLERANCE * strength[first])
        if not later.size or strength[later[0]] < 1e-290:  # the end of floating point
            break
        first, late = int(later[0]), moments[:, later[0] :]
        cost = -(prices[determined] @ late[determined])
        unit, sizes = np.abs(cost).sum(), np.abs(late).sum(axis=1)
        if not np.all(sizes[~determined] > 0.0):
            break
        # moments t d that the later cells must have
        remaining = variables[-1] * demands - moments[:, :first] @ levels[:first]
        rows = late[~determined] / sizes[~determined, None]
        remaining = remaining[~determined] / sizes[~determined]
        stage = _linear_program(cost / unit, rows, remaining)
        if stage is None:
            break
        levels[first:], stage_prices = stage
        prices[~determined] = stage_prices * unit / sizes[~determined]
        determined |= np.abs(prices) * sizes > _RELATIVE_LP_TOLERANCE * unit
    return levels, prices


def _linear_program(
    cost: FloatArray,
    rows: FloatArray,
    right: FloatArray,
    last: tuple[float, float | None] = (-1, 1),
) -> tuple[FloatArray, FloatArray] | None:
    """Return x of minimum `cost` . x under rows x = right and |x| <= 1, and the rows' prices.

    `cost`: ``(k,)``. `rows`: ``(n, k)``. `right`: ``(n,)``. `last`: bounds of the last variable in
    place of -1 and 1; None is infinite. None where the program has no solution.
    """
    from scipy.optimize import linprog  # late: it takes 0.3 s to import

    bounds = [*[(-1.0, 1.0)] * (cost.size - 1), last]
    result = linprog(cost, A_eq=rows, b_eq=right, bounds=bounds, method="highs-ds")
    return (result.x, result.eqlin.marginals) if result.status == 0 else None


def initial_cells(window: Window) -> FloatArray:
    """Return breakpoints [s] of cells up to the end of a `window`, ``(k + 1,)``, from zero on.

    For every pole p they are 150 even in e^(-u Re(p)/4), and for a complex pair 24 in half a period
    (within 4000), up to `TRUNCATED` e-folding times of the slowest pole; one more cell reaches to
    the end.
    """
    c = window.constraints
    last = min(window.end, TRUNCATED / c.decays.min())
    parts = [np.array([0.0, last])]
    for pole in c.poles:
        decay = np.real(pole)
        parts.append(decay_spaced_times(decay, last, 150))
        if np.imag(pole):
            count = min(last * np.imag(pole) / np.pi * 24.0, 4000.0)
            parts.append(np.linspace(0.0, last, int(count) + 2))
    inside = np.unique(np.minimum(np.concatenate(parts), last))
    return inside if last == window.end else np.append(inside, window.end)


def switch_times_of(cells: FloatArray, levels: FloatArray) -> tuple[FloatArray, IndexArray]:
    """Return times [s] at which levels change between -1 and 1, and indices of uncertain cells.

    `cells`: breakpoints [s], ``(k + 1,)``. `levels`: deflection over its peak, ``(k,)``. A cell at
    neither level is uncertain: its level gives the fraction of it that is at each. A run of such
    cells between two signs has one switch, between equal signs two, and at an end of the window
    none or one.
    """
    full = np.flatnonzero(np.abs(levels) > 1.0 - 1e-6)  # within the tolerance of the program
    times: list[float] = []
    uncertain: list[int] = []
    edges = np.concatenate([[-1], full, [levels.size]])
    for before, after in pairwise(edges):
        sign_before = np.sign(levels[before]) if before >= 0 else 0.0
        sign_after = np.sign(levels[after]) if after < levels.size else 0.0
        if after == before + 1 and not sign_before * sign_after:
            continue
        # an end of the window counts as a level of the opposite sign
        sign_before, sign_after = sign_before or -sign_after, sign_after or -sign_before
        start, stop = cells[before + 1], cells[after]  # of the uncertain cells [s]
        if after > before + 1:
            uncertain.extend(range(before + 1, after))
        if np.isinf(stop) or not sign_before:
            continue
        # mean level of the uncertain cells, and the length for which they have the sign before
        widths = np.diff(cells[before + 1 : after + 1])
        mean = widths @ levels[before + 1 : after] / widths.sum() if widths.size else 0.0
        share = (stop - start) * (1.0 + sign_before * mean) / 2.0
        if sign_before != sign_after:
            times.append(start + share)
        elif widths.size:
            times.extend([start + share / 2.0, stop - share / 2.0])
    return np.array(times), np.array(uncertain, dtype=np.intp)


def split_cells(cells: FloatArray, uncertain: IndexArray) -> FloatArray:
    """Return breakpoints [s] of `cells`, with `uncertain` ones and their neighbours in 16 parts.

    `uncertain`: indices of the cells. An endless cell is not divided.
    """
    selected = np.unique(np.concatenate([uncertain - 1, uncertain, uncertain + 1]))
    selected = selected[(selected >= 0) & (selected < cells.size - 1)]
    selected = selected[np.isfinite(cells[selected + 1])]
    widths = cells[selected + 1] - cells[selected]
    new = cells[selected] + widths * (np.arange(1, 16) / 16.0)[:, np.newaxis]
    return np.unique(np.concatenate([cells, new.ravel()]))


def best_multipliers(window: Window) -> SignedSum:
    """Return the sum lambda . e whose sign is the optimal deflection, its L1 norm being the peak.

    `window`: the poles' exponentials e_i, and their demands d_i, which the integrals of e_i times
    the deflection must equal, not all zero.

    Where a real pole p is so fast that the others count only after p t = 700, their multipliers
    cannot be distinguished from zero. The influence of the fast pole on the peak has then ended
    long before, and a slower pole that requires the same peak takes its place. Where that is so of
    all poles but the slowest, they alone decide, and a switch long after satisfies the condition of
    the slowest.
    """
    best = _from_grid(window)
    if best.residual < _RELATIVE_RESIDUAL:
        return best
    last = _with_last_switch(window)
    if last is not None and last.residual < _RELATIVE_RESIDUAL:
        return last
    c = window.constraints  # its poles p, and decays and pulsations of the e_i
    fast = int(np.argmax(c.decays))
    fastest = int(np.argmax(np.real(c.poles)))
    slower = c.poles[fastest] / 3.0  # whose demand is three times as large: equal p d, equal peak
    overtaken = slower < np.sort(c.decays)[-2]
    if overtaken or c.pulsations[fast] or not window.is_underflowing(best.multipliers):
        return best
    poles = np.where(np.arange(c.poles.size) == fastest, slower, c.poles)
    demands = np.where(np.arange(c.decays.size) == fast, 3.0 * c.demands, c.demands)
    slowed = best_multipliers(Window(Constraints(poles, demands, c.horizon)))
    # the switches of the slower pole, with the moments of the poles themselves
    moments = c.moments(np.concatenate([[0.0], slowed.zeros, [window.end]])) @ slowed.signs
    return replace(slowed, window=window, moments=moments)


def _with_last_switch(window: Window) -> SignedSum | None:
    """Return the sum lambda . e whose sign is the optimum without the slowest pole plus one switch.

    The faster poles alone set its peak. A switch after theirs satisfies the condition of the
    slowest; it is optimal if so late that it does not change their moments, which the caller
    checks. None if the slowest pole is complex, the faster demand nothing, or no switch serves.
    `window`: exponentials e_i of the poles, and demands d_i of their moments with the deflection.
    """
    c = window.constraints
    # index of the slowest pole, and of its condition, which differ after complex pairs
    slowest, row = int(np.argmin(np.real(c.poles))), int(np.argmin(c.decays))
    poles, demands = np.delete(c.poles, slowest), np.delete(c.demands, row)
    if c.pulsations[row] or not np.any(demands):  # complex slowest pole, or nothing demanded
        return None
    poles = poles if np.any(np.imag(poles)) else np.real(poles)  # real for `Constraints.real`
    faster = best_multipliers(Window(Constraints(poles, demands, c.horizon)))
    pole, end = float(c.decays[row]), window.end
    moments = c.moments(np.concatenate([[0.0], faster.zeros, [end]]))[row]
    last_sign = faster.signs[-1]
    # The switch at t takes 2 last_sign times the integral of e^(-p u) from t to the end off the
    # moment, which shall be the demand over the norm: that integral is
    # `beyond` = (e^(-p t) - e^(-p end))/p.
    beyond = 0.5 * last_sign * (moments @ faster.signs - c.demands[row] / faster.norm)
    if not 0.0 < beyond < moments[-1]:
        return None
    time = -np.log(pole * beyond + np.exp(-pole * end)) / pole
    zeros, signs = np.append(faster.zeros, time), np.append(faster.signs, -last_sign)
    moments = c.moments(np.concatenate([[0.0], zeros, [end]])) @ signs
    multipliers = np.insert(faster.multipliers, row, 0.0)
    return SignedSum(
        window, multipliers, zeros=zeros, signs=signs, norm=faster.norm, moments=moments
    )


def _from_grid(window: Window) -> SignedSum:
    """Return the sum of smallest residual, by Newton's iteration from grids in a `window`.

    A sum of multipliers times the exponentials of the poles gives the deflection its sign; the
    residual is the largest relative violation of a condition by that deflection. A linear program
    on the grid's cells gives the first switches (changes of sign) and the multipliers (`prices`);
    the cells next to a switch are divided for the next grid.
    """
    cells, best = initial_cells(window), None
    for _ in range(_GRID_REFINEMENTS):
        levels, prices = grid_optimum(window.constraints, cells)  # levels: deflection over the peak
        switches, uncertain = switch_times_of(cells, levels)
        # two guesses of the multipliers: those whose sum is zero at the switches, and the program's
        for guess in _scaled(window, [window.vanishing_at(switches), prices]):
            solution = _newton(guess)
            best = solution if best is None or solution.residual < best.residual else best
            if best.residual < _RELATIVE_RESIDUAL:
                return best
        if window.is_underflowing(prices):
            break
        cells = split_cells(cells, uncertain)
    assert best is not None
    return best


def _scaled(window: Window, guesses: list[FloatArray]) -> list[SignedSum]:
    """Return the sum of each of `guesses`, multipliers ``(n,)``, at its best scale and sign.

    `window`: n exponentials e_i of the poles, and demands d_i of their integrals times the
    deflection. The multipliers lambda are scaled until the L1 norm of the sum equals the dual
    value, lambda . d over that norm, a bound of the peak that no scale changes. The sums ascend by
    residual, not by the dual value, which very small multipliers do not change.
    """
    trials = []
    for guess in guesses:
        size = np.abs(guess) @ window.sizes
        if np.isfinite(size) and size > 0.0:
            trial = window.signed(guess / size)
            height = trial.multipliers @ window.constraints.demands / trial.norm
            trials.append(window.signed(trial.multipliers * (height / trial.norm)))
    return sorted(trials, key=attrgetter("residual"))


def _newton(current: SignedSum) -> SignedSum:
    """Return the sum of exponentials after Newton's iteration from the sum `current`.

    Its multipliers are sought with which the deflection that changes its sign at the zeros of the
    sum satisfies the conditions; the residual is by how much it does not. Steps are in the
    logarithms of the multipliers, for a zero moves in proportion to these. Where such a step does
    not reduce the residual, perhaps because a multiplier has the wrong sign, a plain step is tried.
    """
    for _ in range(_NEWTON_STEPS):
        step = _newton_step(current)
        # logarithmic, then plain; None for a step that does not reduce the residual
        trials = (_shortened(current, step, geometric) for geometric in (True, False))
        trial = next((trial for trial in trials if trial is not None), None)
        if trial is None:
            break
        current = trial
    return current


def _shortened(current: SignedSum, step: FloatArray, geometric: bool) -> SignedSum | None:
    """Return the sum after the longest fraction of a step that reduces the residual, or None.

    The residual is the largest relative violation of a condition. `current`: the sum. `step`: of
    its multipliers, ``(n,)``. `geometric`: whether the step is taken in their logarithms.
    """
    for halvings in range(_STEP_LENGTHS):
        length = 0.5**halvings
        moved = current.multipliers + length * step
        if geometric:  # times e^(step/multiplier), a pair's multipliers being one complex number
            c = current.window.constraints
            size, change = map(c.complex_values, (current.multipliers, length * step))
            # a multiplier of zero has no logarithm: the step is added
            still = size == 0.0
            with np.errstate(over="ignore", invalid="ignore"):
                factor = np.exp(change / np.where(still, 1.0, size))
                moved = c.real_rows(np.where(still, change, size * factor))
        if not np.all(np.isfinite(moved)):
            continue
        trial = current.window.signed(moved)
        if trial.residual < current.residual * (1.0 - 1e-4 * length):  # enough of a decrease
            return trial
    return None


def _newton_step(current: SignedSum) -> FloatArray:
    """Return the Newton step ``(n,)`` of the multipliers lambda of the sum `current`, lambda . e.

    The step is to the minimum of L1^2/2 - lambda . d, whose gradient is L1 m - d. e: the n
    exponentials of the poles; d: the demands, which their integrals times the deflection must
    equal; L1: the L1 norm of the sum; m: the moments of its sign; t_j: its zeros.
    """
    # The Hessian is R'R, R having the rows m' and e(t_j)' sqrt(2 L1/slope); R = U S V' inverts it.
    c = current.window.constraints
    slopes = np.abs(current.multipliers @ c.slopes(current.zeros))
    weights = np.sqrt(2.0 * current.norm / np.maximum(slopes, 1e-200 * current.norm + 1e-300))
    rows = np.vstack([current.moments, (c.basis(current.zeros) * weights).T])
    scale = np.linalg.norm(rows, axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    try:
        _, sizes, directions = np.linalg.svd(rows / scale, full_matrices=False)
    except np.linalg.LinAlgError:  # two zeros on top of each other: there is no step
        return np.zeros_like(current.multipliers)
    downhill = directions @ ((c.demands - current.norm * current.moments) / scale)
    safe = sizes > _SINGULAR_VALUE_CUTOFF * sizes[0]
    inverse = np.where(safe, 1.0 / np.where(safe, sizes, 1.0) ** 2, 0.0)
    return directions.T @ (inverse * downhill) / scale
