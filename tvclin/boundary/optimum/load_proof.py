"""A lower bound of the peak of every deflection that survives a wind within a load bound.

For any weights w of the load, and the density h for which INT h eta = INT w (load - load_0),

    peak >= (INT w load_0 - INT h delta_0 - bound INT |w| - rate INT |K|) / INT |h - K'|,

K being zero without a rate limit. In h each growing mode may have a price of its own, since nothing
is left of it. The weights and prices of a linear program are nearly the best there are.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tvclin.base.arrays import BoolArray, ComplexArray, FloatArray
from tvclin.boundary.optimum.load_case import LoadCase, carried

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_PLACES, _SHARES = (_NODES + 1.0) / 2.0, _WEIGHTS / 2.0


@dataclass(frozen=True, eq=False)
class Weighed:
    """Weights of the load, at nodes and all over the cells, and prices of what grows.

    `widths`: of the cells [s], ``(n,)``. `at`: weights at the nodes, ``(n + 1,)``. `spread`: the
    density [1/s] at start and end of each cell, straight between, ``(2, n)``. `prices`: of the
    growing modes at the first node, ``(k,)``; zero for the others.
    """

    case: LoadCase
    widths: FloatArray
    at: FloatArray
    spread: FloatArray
    prices: ComplexArray

    def proof(self, known: FloatArray, turning: FloatArray | None) -> tuple[float, float]:
        """Return INT h delta_0 + rate INT |K|, and INT |h - K'|.

        `known`: delta_0 in the cells [rad], ``(n,)``. `turning`: prices of the rate there: K' = h
        where there is one.
        """
        n = self.widths.size
        edge = self._density(np.tile([0.0, 1.0], (n, 1)))
        crosses = edge[:, 0] * edge[:, 1] < 0.0
        root = np.where(crosses, edge[:, 0] / np.where(crosses, edge[:, 0] - edge[:, 1], 1.0), 1.0)
        areas, first = np.zeros((2, n)), np.zeros(n)  # before and after h changes its sign
        for k, (low, high) in enumerate(((np.zeros(n), root), (root, np.ones(n)))):
            x = low[:, np.newaxis] + (high - low)[:, np.newaxis] * _PLACES
            h = self._density(x) * _SHARES * ((high - low) * self.widths)[:, np.newaxis]
            areas[k] = h.sum(axis=1)
            first += (h * x).sum(axis=1) * self.widths
        area, size, used = areas.sum(axis=0), np.abs(areas).sum(axis=0), 0.0
        if turning is not None:
            used = self._ramps(area, first, size, turning != 0.0)
        rest = (self._before[-1] * -self.case.held)[self.case.grows]  # of h after the last node
        norm = float(size.sum() + np.abs(rest).sum())
        return float(area @ known) + float(rest.real.sum() * known[-1]) + used, norm

    @cached_property
    def _before(self) -> ComplexArray:
        """Weights before each node as its growing modes feel them, ``(n + 1, k)``."""
        c, n = self.case, self.widths.size
        over, near, far = carried(c.rates, self.widths[:, np.newaxis])
        own = near * self.spread[1][:, np.newaxis] + far * self.spread[0][:, np.newaxis]
        found = np.zeros((n + 1, c.poles.size), dtype=complex)
        found[0] = self.prices
        for k in range(n):
            found[k + 1] = over[k] * found[k] + c.shares * (own[k] + self.at[k + 1])
        return found

    @cached_property
    def _after(self) -> ComplexArray:
        """Weights from each node on as its fading modes feel them, ``(n + 1, k)``."""
        c, n = self.case, self.widths.size
        over, near, far = carried(c.rates, self.widths[:, np.newaxis])
        own = near * self.spread[0][:, np.newaxis] + far * self.spread[1][:, np.newaxis]
        found = np.zeros((n + 1, c.poles.size), dtype=complex)
        found[n] = c.shares * self.at[n]
        for k in range(n - 1, -1, -1):
            found[k] = over[k] * found[k + 1] + c.shares * (own[k] + self.at[k])
        return found

    def _density(self, x: FloatArray) -> FloatArray:
        """H [1/s] at parts x of the cells, ``(n, q)``."""
        c = self.case
        start, end = self.spread[:, :, np.newaxis]
        here = start * (1.0 - x) + end * x
        found = c.ratio * here
        for i in range(c.poles.size):
            if c.grows[i]:
                way, side, node, sign = x, start, self._before[:-1, i], -1.0
            else:
                way, side, node, sign = 1.0 - x, end, self._after[1:, i], 1.0
            over, near, far = carried(c.rates[i], self.widths[:, np.newaxis] * way)
            weight = over * node[:, np.newaxis] + c.shares[i] * (near * here + far * side)
            found = found + sign * c.sizes[i] * weight.real
        return found

    def _ramps(
        self, area: FloatArray, first: FloatArray, size: FloatArray, ramp: BoolArray
    ) -> float:
        """Return the rate times INT |K|; what is left of |h| goes into `size`.

        K' = h on a ramp, less a constant, so that K is zero at both its ends; at the onset, where
        the deflection is zero, it need not be.
        """
        used = 0.0
        edges = np.flatnonzero(np.diff(np.concatenate([[0], ramp, [0]])))
        for low, high in edges.reshape(-1, 2):
            w, own = self.widths[low:high], area[low:high]
            mean = own.sum() / w.sum() if low else 0.0
            K = -np.append(np.cumsum((own - mean * w)[::-1])[::-1], 0.0)
            inside = np.abs(K[1:] * w - first[low:high] + mean * w**2 / 2.0)
            across = w * (np.abs(K[1:]) + np.abs(K[:-1])) / 2.0
            used += float(np.where(K[1:] * K[:-1] < 0.0, across, inside).sum())
            size[low:high] = abs(mean) * w
        return self.case.rate * used
