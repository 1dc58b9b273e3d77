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
_RESIDUAL_SCALE = 1e8
"""Factor of the residual in a program that corrects a solution: the tolerance is 1e-7."""
_MAX_CORRECTIONS = (1e5, 1e2, 1e2)
"""Largest change of a variable in each correction, times `_RESIDUAL_SCALE`."""


@dataclass(frozen=True, eq=False)
class RateProgram:
    """Programs of least peak, motion and rate of a deflection that is linear between nodes.

    `nodes`: times [s] after the start, ``(k,)``, from zero on; the last value stays constant.
    `rate`: rate limit [rad/s]. `unit`: unit [rad] of the values.
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
        integrals = moments(column * widths, 1)
        lead = np.exp(-column * self.nodes[:-1]) * widths
        rising = c.in_rows(lead * integrals[..., 1])
        falling = c.in_rows(lead * (integrals[..., 0] - integrals[..., 1]))
        last = c.moments(np.array([self.nodes[-1], c.horizon]))
        zero = np.zeros((last.shape[0], 1))
        return np.hstack([falling, last]) + np.hstack([zero, rising])

    @cached_property
    def sizes(self) -> FloatArray:
        """Sizes of the conditions, ``(n,)``, by which the rows are divided."""
        return np.abs(self.moments).sum(axis=1)

    @property
    def steps(self) -> FloatArray:
        """Largest change of the deflection in each interval, in units, ``(k - 1,)``."""
        return self.rate * np.diff(self.nodes) / self.unit

    def residual(self, values: FloatArray) -> float:
        """Return the largest relative violation of a condition by the values [rad] at the nodes."""
        demands = self.constraints.demands
        violation = np.abs(self.moments @ values - demands)
        return float((violation / (np.abs(self.moments) @ np.abs(values) + np.abs(demands))).max())

    def minimum_peak(self) -> tuple[FloatArray, FloatArray] | None:
        """Return values of least peak, in units, and prices ``(n,)``; None if infeasible."""
        result = self._solve(_PEAK)
        if result is None:
            return None
        prices = result.eqlin.marginals[-self.sizes.size :] / self.sizes
        return self._values(result.x), prices

    def minimum_motion(self, peak: float) -> FloatArray | None:
        """Return values ``(k,)`` of least total motion within a peak, in units; None if infeasible.

        Each further program corrects the solution, for 1e8 times its residual.
        """
        result = self._solve(_MOTION, peak) or self._solve(_PEAK)
        if result is None:
            return None
        solution = result.x
        for max_change in _MAX_CORRECTIONS:
            correction = self._solve(_PEAK, around=solution, max_change=max_change)
            if correction is not None:
                solution = solution + correction.x / _RESIDUAL_SCALE
        return self._values(solution)

    def minimum_rate(self) -> float:
        """Return the smallest rate [rad/s] that satisfies the conditions on these nodes, or inf."""
        result = self._solve(_RATE)
        return np.inf if result is None else float(result.x[-1]) * self.unit / self.nodes[-1]

    def _values(self, solution: FloatArray) -> FloatArray:
        """Return the values at all nodes, ``(k,)``, the first zero."""
        return np.append(0.0, solution[: self.nodes.size - 1])

    @cached_property
    def _rows(self) -> Callable[[bool], tuple[Any, Any]]:
        """Inequality and equality rows of the program of the rate (True), or of the others."""
        return cache(self._rows_of)

    def _rows_of(self, of_rate: bool) -> tuple[Any, Any]:
        """Return rows that must not be positive, and rows that equal zero or the demands.

        Variables are the values at the nodes after the first, their changes up and down, and
        the bound, which is the peak, or the rate times the last time.
        """
        from scipy import sparse  # late: it takes 0.1 s to import

        count = self.nodes.size - 1
        identity, none = sparse.identity(count), sparse.csr_matrix((count, count))
        share = np.diff(self.nodes)[:, np.newaxis] / self.nodes[-1]
        bound = -share if of_rate else -np.ones((count, 1))
        blocks = (
            [[none, identity, identity]]
            if of_rate
            else [[identity, none, none], [-identity, none, none]]
        )
        conditions = np.zeros((self.sizes.size, 3 * count + 1))
        conditions[:, :count] = self.moments[:, 1:] / self.sizes[:, np.newaxis]
        change = identity - sparse.eye(count, k=-1)
        motion = sparse.hstack([change, -identity, identity, sparse.csr_matrix((count, 1))])
        below = sparse.vstack([sparse.hstack([*block, bound]) for block in blocks])
        return below.tocsr(), sparse.vstack([motion, conditions]).tocsr()

    def _solve(
        self,
        aim: str,
        peak: float = np.inf,
        around: FloatArray | None = None,
        max_change: float = np.inf,
    ) -> Any:
        """Return the result of least peak, rate or total motion (`aim`); None if infeasible.

        With a solution `around`, the result is 1e8 times the change from it, each variable of it
        within `max_change`.
        """
        from scipy.optimize import linprog  # late: it takes 0.3 s to import

        count = self.nodes.size - 1
        below, equal = self._rows(aim == _RATE)
        demands = self.constraints.demands / self.sizes / self.unit
        right, upper = np.append(np.zeros(count), demands), np.zeros(below.shape[0])
        steps = np.full(count, np.inf) if aim == _RATE else np.minimum(self.steps, 1e6)
        highest = np.concatenate([np.full(count, np.inf), steps, steps, [peak]])
        lowest = np.concatenate([np.full(count, -np.inf), np.zeros(2 * count + 1)])
        if around is not None:
            right, upper = (
                _RESIDUAL_SCALE * (right - equal @ around),
                -_RESIDUAL_SCALE * (below @ around),
            )
            lowest, highest = (
                np.clip(_RESIDUAL_SCALE * (b - around), -max_change, max_change)
                for b in (lowest, highest)
            )
        cost = np.zeros(3 * count + 1)
        cost[slice(count, -1) if aim == _MOTION else -1] = 1.0
        for method in ("highs", "highs-ipm"):
            result = linprog(
                cost, below, upper, equal, right, np.column_stack([lowest, highest]), method=method
            )
            if result.status == 0:
                return result
        return None
