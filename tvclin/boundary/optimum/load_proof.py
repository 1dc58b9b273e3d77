"""A lower bound of the peak of every deflection that survives a wind within a load bound.

For any weights w of the load, and the density h for which INT h eta = INT w (load - load_0),

    peak >= (INT w load_0 - INT h delta_0 - bound INT |w| - rate INT |K|) / INT |h - K'|,

K being zero without a rate limit. In h each unstable mode may have a price, since its state must
be zero at the end. The weights and prices of a linear program are close to the best.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tvclin.base.arrays import BoolArray, ComplexArray, FloatArray
from tvclin.boundary.optimum.load_case import LoadCase, convolution_weights

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_FRACTIONS, _SHARES = (_NODES + 1.0) / 2.0, _WEIGHTS / 2.0


@dataclass(frozen=True, eq=False)
class LoadWeights:
    """Weights of the load at nodes and within cells, and prices of the unstable modes.

    `widths`: of the cells [s], ``(n,)``. `node_weights`: weights at the nodes, ``(n + 1,)``.
    `density_ends`: the weight density [1/s] at start and end of each cell, linear between, ``(2,
    n)``. `prices`: of the unstable modes at the first node, ``(k,)``; zero for the others.
    """

    case: LoadCase
    widths: FloatArray
    node_weights: FloatArray
    density_ends: FloatArray
    prices: ComplexArray

    def proof(self, reference: FloatArray, rate_prices: FloatArray | None) -> tuple[float, float]:
        """Return INT h delta_0 + rate INT |K|, and INT |h - K'|.

        `reference`: delta_0 in the cells [rad], ``(n,)``. `rate_prices`: prices of the rate limit
        in the cells, ``(n,)``, or None: K' = h where a price is not zero.
        """
        n = self.widths.size
        edge = self._density(np.tile([0.0, 1.0], (n, 1)))
        crosses = edge[:, 0] * edge[:, 1] < 0.0
        root = np.where(crosses, edge[:, 0] / np.where(crosses, edge[:, 0] - edge[:, 1], 1.0), 1.0)
        areas, first = np.zeros((2, n)), np.zeros(n)  # before and after h changes its sign
        for k, (low, high) in enumerate(((np.zeros(n), root), (root, np.ones(n)))):
            x = low[:, np.newaxis] + (high - low)[:, np.newaxis] * _FRACTIONS
            h = self._density(x) * _SHARES * ((high - low) * self.widths)[:, np.newaxis]
            areas[k] = h.sum(axis=1)
            first += (h * x).sum(axis=1) * self.widths
        area, size, used = areas.sum(axis=0), np.abs(areas).sum(axis=0), 0.0
        if rate_prices is not None:
            used = self._ramps(area, first, size, rate_prices != 0.0)
        rest = (self._before[-1] * -self.case.step_states)[
            self.case.unstable
        ]  # of h after the last node
        norm = float(size.sum() + np.abs(rest).sum())
        return float(area @ reference) + float(rest.real.sum() * reference[-1]) + used, norm

    @cached_property
    def _before(self) -> ComplexArray:
        """Weights before each node, discounted by the unstable modes, ``(n + 1, k)``."""
        c, n = self.case, self.widths.size
        decay, near, far = convolution_weights(c.rates, self.widths[:, np.newaxis])
        increment = (
            near * self.density_ends[1][:, np.newaxis] + far * self.density_ends[0][:, np.newaxis]
        )
        weights = np.zeros((n + 1, c.poles.size), dtype=complex)
        weights[0] = self.prices
        for k in range(n):
            weights[k + 1] = decay[k] * weights[k] + c.shares * (
                increment[k] + self.node_weights[k + 1]
            )
        return weights

    @cached_property
    def _after(self) -> ComplexArray:
        """Weights from each node on, discounted by the stable modes, ``(n + 1, k)``."""
        c, n = self.case, self.widths.size
        decay, near, far = convolution_weights(c.rates, self.widths[:, np.newaxis])
        increment = (
            near * self.density_ends[0][:, np.newaxis] + far * self.density_ends[1][:, np.newaxis]
        )
        weights = np.zeros((n + 1, c.poles.size), dtype=complex)
        weights[n] = c.shares * self.node_weights[n]
        for k in range(n - 1, -1, -1):
            weights[k] = decay[k] * weights[k + 1] + c.shares * (
                increment[k] + self.node_weights[k]
            )
        return weights

    def _density(self, x: FloatArray) -> FloatArray:
        """Return the density h [1/s] at fractions x of the cells, ``(n, q)``."""
        c = self.case
        start, end = self.density_ends[:, :, np.newaxis]
        here = start * (1.0 - x) + end * x
        density = c.ratio * here
        for i in range(c.poles.size):
            if c.unstable[i]:
                distance, origin, node, sign = x, start, self._before[:-1, i], -1.0
            else:
                distance, origin, node, sign = 1.0 - x, end, self._after[1:, i], 1.0
            decay, near, far = convolution_weights(
                c.rates[i], self.widths[:, np.newaxis] * distance
            )
            weight = decay * node[:, np.newaxis] + c.shares[i] * (near * here + far * origin)
            density = density + sign * c.sizes[i] * weight.real
        return density

    def _ramps(
        self, area: FloatArray, first: FloatArray, size: FloatArray, ramp: BoolArray
    ) -> float:
        """Return the rate times INT |K|; the integral of |h - K'| is put into `size`.

        K' = h minus a constant on a ramp, so that K is zero at both its ends; at the onset, where
        the deflection is zero, it need not be.
        """
        used = 0.0
        edges = np.flatnonzero(np.diff(np.concatenate([[0], ramp, [0]])))
        for low, high in edges.reshape(-1, 2):
            w, areas = self.widths[low:high], area[low:high]
            mean = areas.sum() / w.sum() if low else 0.0
            K = -np.append(np.cumsum((areas - mean * w)[::-1])[::-1], 0.0)
            inside = np.abs(K[1:] * w - first[low:high] + mean * w**2 / 2.0)
            across = w * (np.abs(K[1:]) + np.abs(K[:-1])) / 2.0
            used += float(np.where(K[1:] * K[:-1] < 0.0, across, inside).sum())
            size[low:high] = abs(mean) * w
        return self.case.rate * used
