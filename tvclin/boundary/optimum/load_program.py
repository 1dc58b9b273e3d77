"""The linear program of the least peak, or the least load, of a deflection on some nodes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.base.arrays import ComplexArray, FloatArray, IndexArray
from tvclin.boundary.optimum.grid import apart
from tvclin.boundary.optimum.load_case import LoadCase, carried
from tvclin.boundary.optimum.load_proof import Weighed

PEAK, LOAD = "peak", "load"
_INSIDE = np.linspace(0.0, 1.0, 9)
"""Where in a cell the load is looked at."""
_SIMPSON = np.array([1.0, 4.0, 2.0, 4.0, 2.0, 4.0, 2.0, 4.0, 1.0]) / 24.0
"""Weights of a mean over these."""
_AT = 1e-6
"""So near to a limit, relative, a value is at it: the tolerance of a linear program is 1e-7."""
_WIDE, _REST = 0.25, 0.98
"""Over the fastest mode's time, a cell within which loads are not held; what they may be there."""
_EXCESS = 0.2
"""Cells with this part of the largest excess of the load are split too."""
_PARTS = 4
"""Of a cell that is split."""
_MAX_ITERATIONS_PER_UNKNOWN = 50
"""Iterations of a program over its unknowns, which are two or three unless numbers are extreme."""


@dataclass(frozen=True, eq=False)
class Solution:
    """A deflection that survives, and what the prices of its program prove.

    `value`: the least that was asked for [rad], the load at the nodes alone. `peak`, `load`: the
    largest size [rad] of it and of its load, between the nodes too. `ends`: deflection [rad] at
    start and end of each cell, ``(2, n)``. `bound`, `slope`: no deflection has a peak below
    ``bound - slope * load`` [rad]. `finer`: nodes [s] of a program that may do better.
    """

    value: float
    peak: float
    load: float
    ends: FloatArray
    bound: float
    slope: float
    finer: FloatArray


@dataclass(frozen=True, eq=False)
class LoadProgram:
    """A case on nodes [s], ``(n + 1,)``, the onset first; the last value is held.

    In a cell the deflection is level; straight where it is a part of the load; and straight from
    zero on, without a step, where its rate is limited.
    """

    case: LoadCase
    nodes: FloatArray

    @cached_property
    def widths(self) -> FloatArray:
        """Lengths of the cells [s], ``(n,)``."""
        return np.diff(self.nodes)

    @cached_property
    def known(self) -> FloatArray:
        """The known deflection in the cells [rad], ``(n,)``."""
        return self.case.known(0.5 * (self.nodes[1:] + self.nodes[:-1]))

    @cached_property
    def shown(self) -> FloatArray:
        """The load of the known deflection within the cells, ``(n, 9)``, both ends from inside."""
        times = self.nodes[:-1, np.newaxis] + self.widths[:, np.newaxis] * _INSIDE
        times[:, -1] = np.nextafter(self.nodes[1:], -np.inf)
        return self.case.load(times)

    def solve(self, aim: str, most: float) -> Solution | None:
        """The least peak at a load bound, or the least load at a peak [rad]; None if none."""
        from scipy.optimize import linprog  # late: it takes 0.3 s to import

        below, over = self._limits(aim, most)
        equal, right = self._states
        free = np.full(equal.shape[1], np.inf)
        if aim == LOAD:
            free[: self._unknowns] = most / self._unit
        else:
            places, rest = self._resting
            free[places] = rest * most / self._unit
        bounds, cost = np.column_stack([-free, free]), np.append(np.zeros(free.size - 1), 1.0)
        for method in ("highs-ds", "highs-ipm"):
            # with presolve two modes far apart end "unknown"
            options = {"presolve": False, "maxiter": _MAX_ITERATIONS_PER_UNKNOWN * free.size}
            found = linprog(cost, below, over, equal, right, bounds, method=method, options=options)
            if found.status == 0:
                return self._told(found, most if aim == PEAK else float(found.fun) * self._unit)
            if found.status == 2:
                break
        return None

    @cached_property
    def _unit(self) -> float:
        c = self.case
        own = abs(float(c.plant.coefficients.B) * float(c.wind.peak))
        return float(np.abs(self.known).max()) or own

    @cached_property
    def _levels(self) -> tuple[Any, Any]:
        """What takes the unknowns to the deflection at start and end of each cell."""
        from scipy import sparse  # late: it takes 0.1 s to import

        n = self.widths.size
        one, none = sparse.identity(n, format="csr"), sparse.csr_matrix((n, n))
        if np.isfinite(self.case.rate):
            return sparse.diags([np.ones(n - 1)], [-1], shape=(n, n), format="csr"), one
        if self.case.ratio == 0.0:
            return one, one
        return sparse.hstack([one, none]).tocsr(), sparse.hstack([none, one]).tocsr()

    @property
    def _unknowns(self) -> int:
        return int(self._levels[0].shape[1])

    @cached_property
    def _resting(self) -> tuple[IndexArray, float]:
        """Unknowns in wide cells, long after the wind, and what they may be over the load bound.

        With rows at the nodes alone a deflection could swing between them; so the load at rest is
        within the bound.
        """
        B, M = float(self.case.plant.coefficients.B), self.case.ratio
        wide = np.flatnonzero(self.widths * self.case.fastest > _WIDE)
        places = np.concatenate([level[wide].indices for level in self._levels])
        return np.unique(places), _REST * abs(B / (1.0 + M * B))

    @cached_property
    def _states(self) -> tuple[Any, FloatArray]:
        """Rows that must be zero: states at neighbouring nodes, and what is held at the end."""
        from scipy import sparse

        case, n = self.case, self.widths.size
        first, last = self._levels
        over, near, far = carried(case.rates, self.widths[:, np.newaxis])
        start = case.column(case.sizes * np.where(case.grows, near, -far))
        end = case.column(case.sizes * np.where(case.grows, far, -near))
        here = case.matrix(np.where(case.grows, 1.0, -over))
        after = case.matrix(np.where(case.grows, -over, 1.0))
        growing = case.column(np.where(case.grows, 1.0 + 1.0j, 0.0)) > 0.0
        held, m = case.column(case.held)[growing], growing.size
        driven = _diagonal(start[..., np.newaxis]) @ first + _diagonal(end[..., np.newaxis]) @ last
        between = sparse.hstack([driven, _diagonal(after) + _diagonal(here, 1)])
        final = sparse.hstack(
            [
                sparse.csr_matrix(held[:, np.newaxis]) @ last[n - 1],
                sparse.csr_matrix((held.size, (n - 1) * m)),
                sparse.csr_matrix(np.eye(m)[growing]),
            ]
        )
        rows = sparse.vstack([between, final])
        rows = sparse.hstack([rows, sparse.csr_matrix((rows.shape[0], 1))]).tocsr()
        right = (start + end) * self.known[:, np.newaxis]
        return rows, np.append(right.ravel(), held * self.known[-1]) / self._unit

    @cached_property
    def _loads(self) -> tuple[Any, FloatArray, FloatArray]:
        """Rows of the load over all unknowns, and its largest and least value without them.

        At the nodes; where it jumps with the deflection at both ends of each cell.
        """
        from scipy import sparse

        n, M = self.widths.size, self.case.ratio
        c = self.case.column(np.conj(self.case.shares))
        at = sparse.kron(sparse.identity(n), c[np.newaxis], format="csr")
        start, end = self.shown[:, 0] / self._unit, self.shown[:, -1] / self._unit
        first, last = self._levels
        if M == 0.0:
            after = np.append(start[1:], end[-1])
            whole = [sparse.csr_matrix((n, self._unknowns)), at, sparse.csr_matrix((n, 1))]
            return sparse.hstack(whole).tocsr(), np.maximum(end, after), np.minimum(end, after)
        before = sparse.vstack([sparse.csr_matrix((1, at.shape[1])), at[:-1]])
        both = [sparse.vstack([M * first, M * last]), sparse.vstack([before, at])]
        whole = sparse.hstack([*both, sparse.csr_matrix((2 * n, 1))]).tocsr()
        base = np.concatenate([start, end]) - M * np.tile(self.known, 2) / self._unit
        return whole, base, base

    def _limits(self, aim: str, most: float) -> tuple[Any, FloatArray]:
        """Rows that must not exceed the values: load above and below, peak, and rate."""
        from scipy import sparse

        loads, high, low = self._loads
        count, unknowns = loads.shape[1], self._unknowns

        def under(rows: Any, there: bool) -> Any:
            return sparse.hstack([rows[:, :-1], np.full((rows.shape[0], 1), -float(there))])

        one = sparse.eye(unknowns, count, format="csr")
        parts = [under(loads, aim == LOAD), under(-loads, aim == LOAD)]
        a = most / self._unit if aim == PEAK else 0.0
        values = [a - high, a + low]
        if aim == PEAK:
            parts += [under(one, True), under(-one, True)]
            values += [np.zeros(2 * unknowns)]
        else:
            places, rest = self._resting
            some = one[places] * (1.0 / rest)
            parts += [under(some, True), under(-some, True)]
            values += [np.zeros(2 * places.size)]
        if np.isfinite(self.case.rate):
            first, last = self._levels
            rest = sparse.csr_matrix((last.shape[0], count - unknowns))
            turned = sparse.hstack([last - first, rest])
            parts += [turned, -turned]
            values += [np.tile(self.case.rate * self.widths / self._unit, 2)]
        return sparse.vstack(parts).tocsr(), np.concatenate(values)

    def _told(self, found: Any, bound: float) -> Solution:
        first, last = self._levels
        u = self._mended(found.x[: self._unknowns] * self._unit)
        ends = np.stack([first @ u, last @ u])
        inside = self.case.load_in(self.shown, self.widths, ends - self.known)
        n, rows, prices = self.widths.size, self._loads[1].size, found.ineqlin.marginals
        turning = None
        if np.isfinite(self.case.rate):
            turning = prices[-n:] - prices[-2 * n : -n]
        lower, slope = self._proof(
            prices[rows : 2 * rows] - prices[:rows], found.eqlin.marginals, turning
        )
        return Solution(
            value=float(found.fun) * self._unit,
            peak=float(np.abs(ends).max()),
            load=float(np.abs(inside).max()),
            ends=ends,
            bound=lower,
            slope=slope,
            finer=self._finer(ends, inside, bound),
        )

    def _mended(self, u: FloatArray) -> FloatArray:
        """The unknowns moved by as little as can be, so that they meet the conditions exactly."""
        case = self.case
        first, last = self._levels
        _, near, far = carried(case.rates, self.widths[:, np.newaxis])
        faded = np.exp(
            -np.where(case.grows, case.rates, 0.0) * (self.nodes - self.nodes[0])[:, np.newaxis]
        )
        start, stop = (faded[:-1] * one * case.sizes for one in (near, far))
        stop[-1] += faded[-1] * case.held
        growing = case.column(np.where(case.grows, 1.0 + 1.0j, 0.0)) > 0.0
        start, stop = (case.column(one)[:, growing].T for one in (start, stop))
        rows, sizes = start @ first + stop @ last, np.abs(start).sum(axis=1) + 1e-300
        lacking = ((start + stop) @ self.known - rows @ u) / sizes
        return u + np.linalg.lstsq(rows / sizes[:, np.newaxis], lacking, rcond=None)[0]

    def _proof(
        self, weights: FloatArray, prices: FloatArray, turning: FloatArray | None
    ) -> tuple[float, float]:
        """The lower bound of every peak at no load, and by how much it falls with the load."""
        case, n = self.case, self.widths.size
        if case.ratio == 0.0:
            _, high, low = self._loads
            at, spread = np.append(0.0, weights), np.zeros((2, n))
            met = float(weights @ np.where(weights > 0.0, high, low)) * self._unit
        else:  # the density with the same moments, straight in each cell
            at, (start, end) = np.zeros(n + 1), weights.reshape(2, n) / self.widths
            both = start + end
            share = np.where(both == 0.0, 0.5, start / np.where(both == 0.0, 1.0, both))
            share = np.clip(3.0 * share - 1.0, 0.0, 1.0)
            spread = 2.0 * both * np.stack([share, 1.0 - share])
            here = spread[0][:, np.newaxis] * (1.0 - _INSIDE) + spread[1][:, np.newaxis] * _INSIDE
            met = float(self.widths @ (self.shown * here @ _SIMPSON))
        weighed = Weighed(case, self.widths, at, spread, _complex(case, prices))
        used, norm = weighed.proof(self.known, turning)
        if norm == 0.0:
            return 0.0, 0.0
        return (met - used) / norm, float(np.abs(weights).sum()) / norm

    def _finer(self, ends: FloatArray, inside: FloatArray, bound: float) -> FloatArray:
        """The nodes, and more where limits begin or cease to bind, and where a load is exceeded."""
        peak, rate, most = np.abs(ends).max(), self.case.rate, np.abs(inside).max(axis=1)
        marks = [np.where(np.abs(one) > peak * (1.0 - _AT), np.sign(one), 0.0) for one in ends]
        marks.append(np.where(most > bound * (1.0 - _AT), 1.0, 0.0))
        slope = (ends[1] - ends[0]) / self.widths
        marks.append(np.where(np.abs(slope) > rate * (1.0 - _AT), np.sign(slope), 0.0))
        new = np.any(np.diff(np.stack(marks), axis=1) != 0.0, axis=0)
        over = most - bound
        loose = np.append(new, False) | np.append(False, new)
        loose |= over > _EXCESS * max(float(over.max()), _AT * bound / _EXCESS)
        start, width, (left, right) = self.nodes[:-1][loose], self.widths[loose], ends[:, loose]
        level = 0.5 * (1.0 + left / (peak or 1.0))  # where a switch would be
        parts = [np.full(width.size, k / _PARTS) for k in range(1, _PARTS)] + [level, 1.0 - level]
        for side in (peak, -peak):  # where a line of full rate through an end meets the peak
            parts.append(np.clip(np.abs(side - left) / (rate * width), 0.0, 1.0))
            parts.append(np.clip(1.0 - np.abs(side - right) / (rate * width), 0.0, 1.0))
        new_nodes = np.concatenate([self.nodes, *(start + width * x for x in parts)])
        return apart(new_nodes, 1e-6 / self.case.fastest)


def _complex(case: LoadCase, prices: FloatArray) -> ComplexArray:
    """The prices of the growing modes at the onset; a pair has two."""
    found, place = np.zeros(case.poles.size, dtype=complex), 0
    for i in np.flatnonzero(case.grows):
        pair = bool(case.poles[i].imag)
        found[i] = prices[place] - (1j * prices[place + 1] if pair else 0.0)
        place += 1 + pair
    return found


def _diagonal(blocks: FloatArray, behind: int = 0) -> Any:
    """Blocks ``(n, m, q)`` along a diagonal; with `behind` without the first, one to the left."""
    from scipy import sparse

    n, m, q = blocks.shape
    starts = np.concatenate([np.zeros(behind, dtype=int), np.arange(n - behind + 1)])
    parts = (blocks[behind:], np.arange(n - behind), starts)
    found = sparse.bsr_matrix(parts, shape=(n * m, n * q)).tocsr()
    found.eliminate_zeros()
    return found
