"""Sums of exponentials lambda . e(u): where they change sign, and their L1 norm.

They are all that the dual of the minimum-peak problem requires.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tvclin.base.arrays import FloatArray, IndexArray
from tvclin.boundary.optimum.constraints import Constraints
from tvclin.numerics.searches import roots_between

_MAX_DECAY_TIMES = 60.0
"""Times of the slowest real pole, in e-folding times, up to which a change of sign is sought."""
TRUNCATED = 34.0
"""Length of the window, in e-folding times, for a complex pair, whose sign changes without end."""
_GEOMETRIC_POINTS = 600
"""Points of the grid, evenly spaced in their logarithm: fifty or so a decade. Two zeros between
neighbours are detected by the dip between them; two dips would be missed."""
_POINTS_PER_HALF_PERIOD = 16
"""Points of the grid for each half wave of a complex pole."""
_MAX_POINTS = 200_000
"""Largest number of points for a complex pole, to bound the memory; beyond it they are coarser."""


@dataclass(frozen=True, eq=False)
class Window:
    """The functions e_i on a grid fine enough to resolve every change of sign.

    `constraints`: the functions and their demands.
    """

    constraints: Constraints

    @cached_property
    def end(self) -> float:
        """Time [s] at which the window is cut: the horizon; infinite for real poles without."""
        c = self.constraints
        if c.real or np.isfinite(c.horizon):
            return float(c.horizon)
        return float(TRUNCATED / c.decays.min())

    @cached_property
    def grid(self) -> FloatArray:
        """Times [s] from zero on, evenly spaced in their logarithm and within each period."""
        c = self.constraints
        last = min(self.end, _MAX_DECAY_TIMES / c.decays.min())
        first = min(1e-6 / np.abs(c.poles).max(), 1e-3 * last)
        parts = [np.zeros(1), np.geomspace(first, last, _GEOMETRIC_POINTS)]
        for pole in c.poles[np.imag(c.poles) > 0.0]:
            step = np.pi / np.imag(pole) / _POINTS_PER_HALF_PERIOD
            reach = min(last, 700.0 / np.real(pole))
            parts.append(np.linspace(0.0, reach, int(min(reach / step + 2, _MAX_POINTS))))
        return np.unique(np.concatenate(parts))

    @cached_property
    def values(self) -> FloatArray:
        """Functions e_i on the grid, ``(n, k)``."""
        return self.constraints.basis(self.grid)

    @cached_property
    def slopes(self) -> FloatArray:
        """Derivatives of e_i on the grid, ``(n, k)``."""
        return self.constraints.slopes(self.grid)

    @cached_property
    def sizes(self) -> FloatArray:
        """Upper bounds of the L1 norm of each e_i, ``(n,)``: the norms of the envelopes."""
        decays = self.constraints.decays
        return -np.expm1(-decays * self.end) / decays

    def zeros(self, multipliers: FloatArray) -> FloatArray:
        """Return the times [s] at which lambda . e changes its sign, rising."""
        c = self.constraints
        values, slopes = multipliers @ self.values, multipliers @ self.slopes
        sides, rises = np.sign(values), np.sign(slopes)
        dips = (sides[:-1] == sides[1:]) & (sides[:-1] == -rises[:-1]) & (sides[1:] == rises[1:])
        times = self.grid
        if np.any(dips):  # perhaps two zeros between neighbours: look at the bottom of the dip
            bottoms = _refined(multipliers, c.slopes, times, np.flatnonzero(dips))
            times = np.concatenate([times, bottoms])
            order = np.argsort(times, kind="stable")
            values = np.concatenate([values, multipliers @ c.basis(bottoms)])[order]
            times = times[order]
        values, times = values[values != 0.0], times[values != 0.0]
        crossed = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
        return _refined(multipliers, c.basis, times, crossed) if crossed.size else np.zeros(0)

    def signed(self, multipliers: FloatArray) -> SignedSum:
        """Return the sum lambda . e with its changes of sign and the moments of its sign."""
        zeros = self.zeros(multipliers)
        knots = np.concatenate([[0.0], zeros, [self.end]])
        moments = self.constraints.moments(knots)
        areas = multipliers @ moments
        signs = np.where(areas < 0.0, -1.0, 1.0)
        return SignedSum(multipliers, zeros, signs, float(np.abs(areas).sum()), moments @ signs)

    def tail(self, multipliers: FloatArray) -> float:
        """Return a bound of the integral of |lambda . e| past the end of a cut window."""
        c = self.constraints
        if np.isinf(self.end) or np.isfinite(c.horizon):
            return 0.0
        beyond = np.exp(-c.decays * self.end) / c.decays
        return float(np.abs(multipliers) @ beyond)


@dataclass(frozen=True, eq=False)
class SignedSum:
    """A sum lambda . e, its changes of sign, norm and gradient.

    `multipliers`: lambda, ``(n,)``. `zeros`: times [s] of its changes of sign, ``(k,)``. `signs`:
    its sign between them, ``(k + 1,)``. `norm`: its L1 norm on the window. `moments`: the moments
    of its sign, ``(n,)``: the gradient of the norm.
    """

    multipliers: FloatArray
    zeros: FloatArray
    signs: FloatArray
    norm: float
    moments: FloatArray


def even_for(decay: float, last: float, count: int) -> FloatArray:
    """Return times [s] from zero on, even in e^(-decay u/4), up to `last` or 100 decay times."""
    reach = -np.expm1(-decay * min(last, 100.0 / decay) / 4.0)
    return -4.0 / decay * np.log1p(-np.linspace(0.0, reach, count))


def _refined(
    multipliers: FloatArray,
    function: Callable[[FloatArray], FloatArray],
    times: FloatArray,
    intervals: IndexArray,
) -> FloatArray:
    """Return the zeros [s] of lambda . function, each in the interval from ``times[intervals]``."""
    sign = np.sign(multipliers @ function(times[intervals + 1]))

    def rising(u: FloatArray, k: IndexArray) -> FloatArray:
        return np.asarray(sign[k] * (multipliers @ function(u)))

    return roots_between(times[intervals], times[intervals + 1], rising)
