"""The linear program of the rate-limited minimum-peak problem on one set of nodes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.boundary.optimum.constraints import Constraints
from tvclin.numerics.pieces import moments

_PEAK, _MOTION, _RATE = "peak", "motion", "rate"
_MAGNIFIED = 1e8
"""What a linear program leaves is enlarged by this and solved for again: its tolerance is 1e-7."""
_MENDINGS = (1e5, 1e2, 1e2)
"""How far a solution is moved to mend it, in units of 1/_MAGNIFIED."""


@dataclass(frozen=True, eq=False)
class RateProgram:
    """Least peak, least motion and least rate of a deflection that is straight between nodes.

    `nodes`: times [s] after the start, ``(k,)``, from zero on; the last value is held. `rate`: rate
    limit [rad/s]. `unit`: deflection [rad] in units of which the values are given.
    """

    constraints: Constraints
    nodes: FloatArray
    rate: float
    unit: float

    @cached_property
    def moments(self) -> FloatArray:
        """Moments of the deflection that is one at a node and zero at the others, ``(n, k)``."""
        # On an interval of width h from t, with x = (u - t)/h, a node's share is x or 1 - x, and
        # integral e^(-p u) x du = e^(-p t) h M_1(p h), with the moments M_k of `numerics.pieces`.
        c, widths = self.constraints, np.diff(self.nodes)
        column = c.poles[:, np.newaxis]
        both = moments(column * widths, 1)
        lead = np.exp(-column * self.nodes[:-1]) * widths
        rising = c.in_rows(lead * both[..., 1])
        falling = c.in_rows(lead * (both[..., 0] - both[..., 1]))
        held = c.moments(np.array([self.nodes[-1], c.horizon]))
        zero = np.zeros((held.shape[0], 1))
        return np.hstack([falling, held]) + np.hstack([zero, rising])

    @cached_property
    def sizes(self) -> FloatArray:
        """Sizes of the conditions, by which the rows are divided."""
        return np.abs(self.moments).sum(axis=1)

    @property
    def steps(self) -> FloatArray:
        """The largest change of the deflection in each interval, in units."""
        return self.rate * np.diff(self.nodes) / self.unit

    def residual(self, values: FloatArray) -> float:
        """The largest violation of a condition by the values [rad] at the nodes."""
        demands = self.constraints.demands
        violation = np.abs(self.moments @ values - demands)
        return float((violation / (np.abs(self.moments) @ np.abs(values) + np.abs(demands))).max())

    def least_peak(self) -> tuple[FloatArray, FloatArray] | None:
        """Values of least peak, in units, and prices of the conditions ``(n,)``; None if none."""
        found = self._solve(_PEAK)
        if found is None:
            return None
        prices = found.eqlin.marginals[-self.sizes.size :] / self.sizes
        return self._values(found.x), prices

    def least_motion(self, peak: float) -> FloatArray | None:
        """Values within a peak, in units, that move as little as can be, to rounding ``(k,)``.

        The tolerance of a linear program is mended by another, for 1e8 times what is left.
        """
        found = self._solve(_MOTION, peak) or self._solve(_PEAK)
        if found is None:
            return None
        solution = found.x
        for reach in _MENDINGS:
            mended = self._solve(_PEAK, around=solution, reach=reach)
            if mended is not None:
                solution = solution + mended.x / _MAGNIFIED
        return self._values(solution)

    def least_rate(self) -> float:
        """The smallest rate [rad/s] with which the conditions can be met on these nodes."""
        found = self._solve(_RATE)
        return np.inf if found is None else float(found.x[-1]) * self.unit / self.nodes[-1]

    def _values(self, solution: FloatArray) -> FloatArray:
        return np.append(0.0, solution[: self.nodes.size - 1])

    @cached_property
    def _rows(self) -> Callable[[bool], tuple[Any, Any]]:
        """Rows that must not be positive, and rows that must be zero or the demands.

        Of the program of the rate, or of the others.
        """
        return cache(self._rows_of)

    def _rows_of(self, of_rate: bool) -> tuple[Any, Any]:
        """Make the rows.

        Variables are the values at the nodes after the first, their changes up and down, and
        the bound, which is the peak, or the rate times the last time.
        """
        from scipy import sparse  # late: it takes 0.1 s to import

        count = self.nodes.size - 1
        one, none = sparse.identity(count), sparse.csr_matrix((count, count))
        share = np.diff(self.nodes)[:, np.newaxis] / self.nodes[-1]
        bound = -share if of_rate else -np.ones((count, 1))
        sides = [[none, one, one]] if of_rate else [[one, none, none], [-one, none, none]]
        conditions = np.zeros((self.sizes.size, 3 * count + 1))
        conditions[:, :count] = self.moments[:, 1:] / self.sizes[:, np.newaxis]
        change = one - sparse.eye(count, k=-1)
        motion = sparse.hstack([change, -one, one, sparse.csr_matrix((count, 1))])
        below = sparse.vstack([sparse.hstack([*side, bound]) for side in sides])
        return below.tocsr(), sparse.vstack([motion, conditions]).tocsr()

    def _solve(
        self,
        aim: str,
        peak: float = np.inf,
        around: FloatArray | None = None,
        reach: float = np.inf,
    ) -> Any:
        """Minimise the peak, the rate or the sum of all motion; None where nothing is feasible.

        With a solution `around` which to search, the answer is 1e8 times the way from it, and
        within `reach`.
        """
        from scipy.optimize import linprog  # late: it takes 0.3 s to import

        count = self.nodes.size - 1
        below, equal = self._rows(aim == _RATE)
        demands = self.constraints.demands / self.sizes / self.unit
        right, over = np.append(np.zeros(count), demands), np.zeros(below.shape[0])
        steps = np.full(count, np.inf) if aim == _RATE else np.minimum(self.steps, 1e6)
        most = np.concatenate([np.full(count, np.inf), steps, steps, [peak]])
        least = np.concatenate([np.full(count, -np.inf), np.zeros(2 * count + 1)])
        if around is not None:
            right, over = _MAGNIFIED * (right - equal @ around), -_MAGNIFIED * (below @ around)
            least, most = (np.clip(_MAGNIFIED * (b - around), -reach, reach) for b in (least, most))
        cost = np.zeros(3 * count + 1)
        cost[slice(count, -1) if aim == _MOTION else -1] = 1.0
        for method in ("highs", "highs-ipm"):
            found = linprog(
                cost, below, over, equal, right, np.column_stack([least, most]), method=method
            )
            if found.status == 0:
                return found
        return None
