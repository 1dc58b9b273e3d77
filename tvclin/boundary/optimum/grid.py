"""The deflection of least peak that is constant in cells, by a linear program, and its switches."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from tvclin.base.arrays import FloatArray, IndexArray
from tvclin.boundary.optimum.constraints import Constraints
from tvclin.boundary.optimum.exponential_sums import TRUNCATED, Window, even_for

_FAINT = 1e-6
"""What is below this part of the largest counts as lost in the tolerance of a linear program."""


def grid_optimum(constraints: Constraints, cells: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the best deflection that is constant in each cell, over its peak, and its prices.

    `constraints`: conditions on the moments. `cells`: knots [s] of the cells, ``(k + 1,)``; the
    last may be infinite. Returned: levels in [-1, 1], ``(k,)``, and the multipliers, ``(n,)``, not
    scaled.

    The multiplier of a slow pole that matters only long after the others have died out is many
    decades below theirs and lost in the tolerance of a linear program. So the program is solved
    again for the cells from there on: the poles whose multipliers are known are served best,
    under the conditions at the others.
    """
    # The largest t for which some |v_j| <= 1 have the moments t d: then 1/t is the peak.
    moments = constraints.moments(cells)
    sizes = np.abs(moments).sum(axis=1)
    demands = constraints.demands / np.abs(constraints.demands / sizes).max()
    rows = np.column_stack([moments, -demands]) / sizes[:, np.newaxis]
    cost = np.append(np.zeros(cells.size - 1), -1.0)
    found = _linear_program(cost, rows, np.zeros(sizes.size), (0.0, None))
    if found is None:
        return np.ones(cells.size - 1), constraints.demands / sizes**2
    levels, prices = found[0][:-1], found[1] / sizes
    known, first = np.abs(prices) * sizes > _FAINT, 0
    while not np.all(known) and np.any(known):
        strength = np.abs(prices[known]) @ np.exp(-constraints.decays[known, None] * cells[:-1])
        later = np.flatnonzero(strength < _FAINT * strength[first])
        if not later.size or strength[later[0]] < 1e-290:
            break
        first, late = int(later[0]), moments[:, later[0] :]
        cost = -(prices[known] @ late[known])
        unit, sizes = np.abs(cost).sum(), np.abs(late).sum(axis=1)
        if not np.all(sizes[~known] > 0.0):
            break
        left = found[0][-1] * demands - moments[:, :first] @ levels[:first]
        rows, left = late[~known] / sizes[~known, None], left[~known] / sizes[~known]
        stage = _linear_program(cost / unit, rows, left)
        if stage is None:
            break
        levels[first:], prices[~known] = stage[0], stage[1] * unit / sizes[~known]
        known |= np.abs(prices) * sizes > _FAINT * unit
    return levels, prices


def _linear_program(
    cost: FloatArray,
    rows: FloatArray,
    right: FloatArray,
    last: tuple[float, float | None] = (-1, 1),
) -> tuple[FloatArray, FloatArray] | None:
    """Minimise cost . x under rows x = right and |x| <= 1; None where that cannot be."""
    from scipy.optimize import linprog  # late: it takes 0.3 s to import

    bounds = [*[(-1.0, 1.0)] * (cost.size - 1), last]
    found = linprog(cost, A_eq=rows, b_eq=right, bounds=bounds, method="highs-ds")
    return (found.x, found.eqlin.marginals) if found.status == 0 else None


def first_cells(window: Window) -> FloatArray:
    """Return cells as even as can be for every pole: in e^(-p u/4), and within each period."""
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
    """Return where levels of -1 and 1 change, and the cells in which that is not certain.

    Cells between that are neither count for the parts of them that are.
    """
    full = np.flatnonzero(np.abs(levels) > 1.0 - 1e-6)
    times: list[float] = []
    doubtful: list[int] = []
    edges = np.concatenate([[-1], full, [levels.size]])
    for before, after in pairwise(edges):
        left = np.sign(levels[before]) if before >= 0 else 0.0
        right = np.sign(levels[after]) if after < levels.size else 0.0
        if after == before + 1 and not left * right:
            continue
        left, right = left or -right, right or -left
        start, stop = cells[before + 1], min(cells[after], cells[-1] if after else np.inf)
        if after > before + 1:
            doubtful.extend(range(before + 1, after))
        if np.isinf(stop) or not left:
            continue
        widths = np.diff(cells[before + 1 : after + 1])
        mean = widths @ levels[before + 1 : after] / widths.sum() if widths.size else 0.0
        share = (stop - start) * (1.0 + left * mean) / 2.0
        if left != right:
            times.append(start + share)
        elif widths.size:
            times.extend([start + share / 2.0, stop - share / 2.0])
    return np.array(times), np.array(doubtful, dtype=np.intp)


def split(cells: FloatArray, doubtful: IndexArray) -> FloatArray:
    """Return cells of which the doubtful, and those beside them, are cut in 16 parts."""
    near = np.unique(np.concatenate([doubtful - 1, doubtful, doubtful + 1]))
    near = near[(near >= 0) & (near < cells.size - 1)]
    near = near[np.isfinite(cells[near + 1])]
    widths = cells[near + 1] - cells[near]
    new = cells[near] + widths * (np.arange(1, 16) / 16.0)[:, np.newaxis]
    return np.unique(np.concatenate([cells, new.ravel()]))


def apart(nodes: FloatArray, gap: float) -> FloatArray:
    """Return nodes in order, without those that all but coincide; the last stays."""
    nodes = np.unique(nodes)
    return np.append(nodes[:-1][np.diff(nodes) > gap], nodes[-1])
