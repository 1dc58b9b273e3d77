"""The deflection of least peak that is constant in cells, by a linear program, and its switches."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from tvclin.base.arrays import FloatArray, IndexArray
from tvclin.boundary.optimum.constraints import Constraints
from tvclin.boundary.optimum.exponential_sums import TRUNCATED, Window, even_for

_RELATIVE_LP_TOLERANCE = 1e-6
"""Size, relative to the largest, that counts as below the tolerance of a linear program."""


def grid_optimum(constraints: Constraints, cells: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the deflection of least peak that is constant in each cell, and its multipliers.

    `constraints`: conditions on the moments. `cells`: breakpoints [s] of the cells, ``(k + 1,)``;
    the last may be infinite. Returned: levels in [-1, 1], the deflection normalised by its peak,
    ``(k,)``, and the multipliers (prices of the conditions), ``(n,)``, not scaled.

    The multiplier of a slow pole that matters only long after the others have decayed is many
    decades below theirs, and below the tolerance of a linear program. So the program is solved
    again for the later cells: it maximises the moments of the poles whose multipliers are
    determined, under the conditions of the others.
    """
    # The largest t for which some |v_j| <= 1 have the moments t d: then 1/t is the peak.
    moments = constraints.moments(cells)
    sizes = np.abs(moments).sum(axis=1)
    demands = constraints.demands / np.abs(constraints.demands / sizes).max()
    rows = np.column_stack([moments, -demands]) / sizes[:, np.newaxis]
    cost = np.append(np.zeros(cells.size - 1), -1.0)
    solution = _linear_program(cost, rows, np.zeros(sizes.size), (0.0, None))
    if solution is None:
        return np.ones(cells.size - 1), constraints.demands / sizes**2
    levels, prices = solution[0][:-1], solution[1] / sizes
    determined, first = np.abs(prices) * sizes > _RELATIVE_LP_TOLERANCE, 0
    while not np.all(determined) and np.any(determined):
        strength = np.abs(prices[determined]) @ np.exp(
            -constraints.decays[determined, None] * cells[:-1]
        )
        later = np.flatnonzero(strength < _RELATIVE_LP_TOLERANCE * strength[first])
        if not later.size or strength[later[0]] < 1e-290:
            break
        first, late = int(later[0]), moments[:, later[0] :]
        cost = -(prices[determined] @ late[determined])
        unit, sizes = np.abs(cost).sum(), np.abs(late).sum(axis=1)
        if not np.all(sizes[~determined] > 0.0):
            break
        remaining = solution[0][-1] * demands - moments[:, :first] @ levels[:first]
        rows, remaining = (
            late[~determined] / sizes[~determined, None],
            remaining[~determined] / sizes[~determined],
        )
        stage = _linear_program(cost / unit, rows, remaining)
        if stage is None:
            break
        levels[first:], prices[~determined] = stage[0], stage[1] * unit / sizes[~determined]
        determined |= np.abs(prices) * sizes > _RELATIVE_LP_TOLERANCE * unit
    return levels, prices


def _linear_program(
    cost: FloatArray,
    rows: FloatArray,
    right: FloatArray,
    last: tuple[float, float | None] = (-1, 1),
) -> tuple[FloatArray, FloatArray] | None:
    """Return x that minimises cost . x under rows x = right and |x| <= 1, and prices of the rows.

    `last`: bounds of the last variable. None where the program has no solution.
    """
    from scipy.optimize import linprog  # late: it takes 0.3 s to import

    bounds = [*[(-1.0, 1.0)] * (cost.size - 1), last]
    result = linprog(cost, A_eq=rows, b_eq=right, bounds=bounds, method="highs-ds")
    return (result.x, result.eqlin.marginals) if result.status == 0 else None


def first_cells(window: Window) -> FloatArray:
    """Return breakpoints [s] of cells: even in e^(-p u/4) for every pole, and in each period."""
    c = window.constraints
    last = min(window.end, TRUNCATED / c.decays.min())
    parts = [np.array([0.0, last])]
    for pole in c.poles:
        decay = np.real(pole)
        parts.append(even_for(decay, last, 150))
        if np.imag(pole):
            count = min(last * np.imag(pole) / np.pi * 24.0, 4000.0)
            parts.append(np.linspace(0.0, last, int(count) + 2))
    inside = np.unique(np.minimum(np.concatenate(parts), last))
    return inside if last == window.end else np.append(inside, window.end)


def switches_in(cells: FloatArray, levels: FloatArray) -> tuple[FloatArray, IndexArray]:
    """Return the times [s] at which levels change between -1 and 1, and indices of uncertain cells.

    A cell at neither level is uncertain: its level gives the fraction that is at each.
    """
    full = np.flatnonzero(np.abs(levels) > 1.0 - 1e-6)
    times: list[float] = []
    doubtful: list[int] = []
    edges = np.concatenate([[-1], full, [levels.size]])
    for before, after in pairwise(edges):
        sign_before = np.sign(levels[before]) if before >= 0 else 0.0
        sign_after = np.sign(levels[after]) if after < levels.size else 0.0
        if after == before + 1 and not sign_before * sign_after:
            continue
        sign_before, sign_after = sign_before or -sign_after, sign_after or -sign_before
        start, stop = cells[before + 1], min(cells[after], cells[-1] if after else np.inf)
        if after > before + 1:
            doubtful.extend(range(before + 1, after))
        if np.isinf(stop) or not sign_before:
            continue
        widths = np.diff(cells[before + 1 : after + 1])
        mean = widths @ levels[before + 1 : after] / widths.sum() if widths.size else 0.0
        share = (stop - start) * (1.0 + sign_before * mean) / 2.0
        if sign_before != sign_after:
            times.append(start + share)
        elif widths.size:
            times.extend([start + share / 2.0, stop - share / 2.0])
    return np.array(times), np.array(doubtful, dtype=np.intp)


def split(cells: FloatArray, doubtful: IndexArray) -> FloatArray:
    """Return breakpoints [s] with uncertain cells and their neighbours divided into 16."""
    selected = np.unique(np.concatenate([doubtful - 1, doubtful, doubtful + 1]))
    selected = selected[(selected >= 0) & (selected < cells.size - 1)]
    selected = selected[np.isfinite(cells[selected + 1])]
    widths = cells[selected + 1] - cells[selected]
    new = cells[selected] + widths * (np.arange(1, 16) / 16.0)[:, np.newaxis]
    return np.unique(np.concatenate([cells, new.ravel()]))


def apart(nodes: FloatArray, gap: float) -> FloatArray:
    """Return nodes [s] in order, without those within `gap` [s] of the next; the last stays."""
    nodes = np.unique(nodes)
    return np.append(nodes[:-1][np.diff(nodes) > gap], nodes[-1])
