"""The minimum-peak problem with any number of unstable poles, by its dual.

    least peak = max over lambda of  lambda . d / integral |lambda . e(u)| du

and the deflection is the peak times the sign of the best lambda . e (the L-problem of moments).
A small linear program on a grid finds where the sign changes, Newton's iteration on

    L1(lambda)^2/2 - lambda . d  ->  min,      at the minimum L1 = peak,

takes it to rounding. With m = integral e sgn(lambda . e), the gradient of L1, and the zeros t_j of
the sum, its gradient is L1 m - d and its Hessian

    m m' + L1 sum over j of 2 e(t_j) e(t_j)'/|slope of the sum at t_j| .
"""

from __future__ import annotations

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.boundary.optimum.constraints import Constraints
from tvclin.boundary.optimum.exponential_sums import SignedSum, Window
from tvclin.boundary.optimum.grid import first_cells, grid_optimum, split, switches_in

_NEWTON_STEPS = 60
"""Beyond those that a quadratic end takes, for a start with several small multipliers; where they
do not suffice the grid is refined, and a result that does not arrive says so."""
_HALVINGS = 12
"""Of a step that makes the conditions worse: 1/2048 of it is the last that is tried."""
_ARRIVED = 1e-13
"""Violation of a condition over the sizes of its terms: some hundred roundings."""
_LOST = 1e-200
"""Multipliers so far below the largest are not told from zero: e^-460."""
_SINGULAR = 1e-13
"""Singular values of a Newton step below this part of the largest are rounding: no step along."""
_ROUNDS = 4
"""So often the grid of the linear program is refined if Newton's iteration does not arrive."""


def best_multipliers(window: Window) -> SignedSum:
    """Return the sum whose sign is the deflection of least peak, scaled so that L1 = peak.

    `window`: the functions e_i and their demands, which must not all be zero.

    Where a real pole p is so fast that the others count only after p t = 700, their multipliers
    cannot be told from zero. What the fast pole does to the peak is then over long before, and
    a slower pole that asks for the same peak stands in for it. Where that is so of all poles but
    the slowest, they alone decide, and the slowest is met by a switch long after.
    """
    best = _from_grid(window)
    if _misfit(window, best) < _ARRIVED:
        return best
    last = _slowest_last(window)
    if last is not None and _misfit(window, last) < _ARRIVED:
        return last
    c = window.constraints
    fast = int(np.argmax(c.decays))
    place = int(np.argmax(np.real(c.poles)))
    slower = c.poles[place] / 3.0
    if not _lost(window, best.multipliers) or c.pulsations[fast] or slower < np.sort(c.decays)[-2]:
        return best
    poles = np.where(np.arange(c.poles.size) == place, slower, c.poles)
    demands = np.where(np.arange(c.decays.size) == fast, 3.0 * c.demands, c.demands)
    found = best_multipliers(Window(Constraints(poles, demands, c.horizon)))
    moments = c.moments(np.concatenate([[0.0], found.zeros, [window.end]])) @ found.signs
    return SignedSum(found.multipliers, found.zeros, found.signs, found.norm, moments)


def _slowest_last(window: Window) -> SignedSum | None:
    """The sum without the slowest real pole, and one switch more, which meets that pole.

    No deflection has a smaller peak than the others need. So this is the answer if the conditions
    at the others do not feel the switch. None where there is no such pole or switch.
    """
    c = window.constraints
    place, row = int(np.argmin(np.real(c.poles))), int(np.argmin(c.decays))
    poles, demands = np.delete(c.poles, place), np.delete(c.demands, row)
    if c.pulsations[row] or not np.any(demands):
        return None
    poles = poles if np.any(np.imag(poles)) else np.real(poles)
    found = best_multipliers(Window(Constraints(poles, demands, c.horizon)))
    pole, end = float(c.decays[row]), window.end
    moments = c.moments(np.concatenate([[0.0], found.zeros, [end]]))[row]
    side = found.signs[-1]
    # The switch at t takes 2 side times the integral of e^(-p u) from t to the end off the moment,
    # which shall be d/L1: that integral is `beyond` = (e^(-p t) - e^(-p end))/p.
    beyond = 0.5 * side * (moments @ found.signs - c.demands[row] / found.norm)
    if not 0.0 < beyond < moments[-1]:
        return None
    time = -np.log(pole * beyond + np.exp(-pole * end)) / pole
    zeros, signs = np.append(found.zeros, time), np.append(found.signs, -side)
    return SignedSum(
        np.insert(found.multipliers, row, 0.0),
        zeros,
        signs,
        found.norm,
        c.moments(np.concatenate([[0.0], zeros, [end]])) @ signs,
    )


def _from_grid(window: Window) -> SignedSum:
    cells, best = first_cells(window), None
    for _ in range(_ROUNDS):
        levels, prices = grid_optimum(window.constraints, cells)
        switches, doubtful = switches_in(cells, levels)
        for guess in _scaled(window, [_vanishing_at(window, switches), prices]):
            found = _newton(window, guess)
            if best is None or _misfit(window, found) < _misfit(window, best):
                best = found
            if _misfit(window, best) < _ARRIVED:
                return best
        if _lost(window, prices):
            break
        cells = split(cells, doubtful)
    assert best is not None
    return best


def _lost(window: Window, multipliers: FloatArray) -> bool:
    part = np.abs(multipliers) * window.sizes
    return bool(part.min() < _LOST * part.max())


def _vanishing_at(window: Window, times: FloatArray) -> FloatArray:
    """Multipliers whose sum is zero, or as small as can be, at the given times."""
    c = window.constraints
    if not times.size:
        return c.demands / window.sizes**2
    values = c.basis(times)
    with np.errstate(divide="ignore", over="ignore"):
        scale = 1.0 / np.abs(values).max(axis=1)
    scale = np.where(np.isfinite(scale), scale, 1.0)
    weight = np.abs(values / window.sizes[:, np.newaxis]).max(axis=0)
    rows = np.nan_to_num((values * scale[:, np.newaxis] * weight).T, posinf=0.0, neginf=0.0)
    return np.linalg.svd(rows)[2][-1] * scale


def _scaled(window: Window, guesses: list[FloatArray]) -> list[SignedSum]:
    """The guesses with their best scale and sign, first the one that meets the conditions best.

    Not the one with the highest dual value: that does not feel multipliers of very small size.
    """
    trials = []
    for guess in guesses:
        size = np.abs(guess) @ window.sizes
        if np.isfinite(size) and size > 0.0:
            trial = window.signed(guess / size)
            height = trial.multipliers @ window.constraints.demands / trial.norm
            trials.append(window.signed(trial.multipliers * (height / trial.norm)))
    return sorted(trials, key=lambda trial: _misfit(window, trial))


def _misfit(window: Window, found: SignedSum) -> float:
    """Largest violation of a condition by the deflection L1 sgn(lambda . e), relative."""
    demands = window.constraints.demands
    with np.errstate(over="ignore", invalid="ignore"):  # multipliers may be beyond all measure
        sizes = found.norm * window.sizes + np.abs(demands)
        misfits = np.abs(found.norm * found.moments - demands) / sizes
    return float(np.where(np.isnan(misfits), np.inf, misfits).max())


def _newton(window: Window, found: SignedSum) -> SignedSum:
    """Newton's iteration on the conditions, with steps in the logarithms of the multipliers.

    A switch moves in proportion to those. Where such a step does not help, perhaps because a
    multiplier has the wrong sign, it is a plain step.
    """
    for _ in range(_NEWTON_STEPS):
        step = _newton_step(window, found)
        for geometric in (True, False):
            trial = _shortened(window, found, step, geometric)
            if trial is not None:
                break
        if trial is None:
            break
        found = trial
    return found


def _shortened(
    window: Window, found: SignedSum, step: FloatArray, geometric: bool
) -> SignedSum | None:
    """The result of the longest part of a step that meets the conditions better."""
    misfit = _misfit(window, found)
    for halvings in range(_HALVINGS):
        part = 0.5**halvings
        moved = found.multipliers + part * step
        if geometric:
            moved = _in_logarithms(window.constraints, found.multipliers, part * step)
        if not np.all(np.isfinite(moved)):
            continue
        trial = window.signed(moved)
        if _misfit(window, trial) < misfit * (1.0 - 1e-4 * part):
            return trial
    return None


def _in_logarithms(
    constraints: Constraints, multipliers: FloatArray, step: FloatArray
) -> FloatArray:
    """Multiply each multiplier by e^(step/multiplier), those of a pair as one complex number."""
    size, change = constraints.joined(multipliers), constraints.joined(step)
    still = size == 0.0
    with np.errstate(over="ignore", invalid="ignore"):
        moved = size * np.exp(change / np.where(still, 1.0, size))
    return constraints.in_rows(np.where(still, change, moved))


def _newton_step(window: Window, found: SignedSum) -> FloatArray:
    """The step of Newton's iteration, with columns scaled: multipliers differ by many decades."""
    # The Hessian is R'R, R having the rows m' and e(t_j)' sqrt(2 L1/slope); R = U S V' inverts it.
    c = window.constraints
    slopes = np.abs(found.multipliers @ c.slopes(found.zeros))
    weights = np.sqrt(2.0 * found.norm / np.maximum(slopes, 1e-200 * found.norm + 1e-300))
    rows = np.vstack([found.moments, (c.basis(found.zeros) * weights).T])
    scale = np.linalg.norm(rows, axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    try:
        _, sizes, directions = np.linalg.svd(rows / scale, full_matrices=False)
    except np.linalg.LinAlgError:  # two zeros on top of each other: there is no step
        return np.zeros_like(found.multipliers)
    downhill = directions @ ((c.demands - found.norm * found.moments) / scale)
    safe = sizes > _SINGULAR * sizes[0]
    inverse = np.where(safe, 1.0 / np.where(safe, sizes, 1.0) ** 2, 0.0)
    return directions.T @ (inverse * downhill) / scale
