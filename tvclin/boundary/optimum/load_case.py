"""The load of a plant in a wind, told from that of a deflection that survives.

The load is alpha + M delta [rad], M being a ratio of moments. The modes of eta = delta - delta_0
are scaled to z' = s z + |s| eta and must not grow. Those that would are summed from behind, the
others from the start, so that no number grows:

    z(t) = -|s| INT_t^inf e^(-s (u - t)) eta du,      z(t) = |s| INT_0^t e^(s (t - u)) eta du,
    load = load_0 + M eta + sum of c z.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray
from tvclin.linear.modes import unstable_poles
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.numerics.pieces import moments
from tvclin.winds.histories import History

Three = tuple[AnyArray, AnyArray, AnyArray]

_UNSEEN = 1e-12
"""A mode that decays and has this part of the load is left out."""
_NAME = "angle_of_attack"


@dataclass(frozen=True, eq=False)
class LoadCase:
    """A plant in a wind, and a known deflection [rad] that survives it, constant between nodes.

    `ratio`: M, deflection's part of the load. `rate`: the rate limit [rad/s]; infinite if none.
    """

    plant: Plant
    wind: History
    known: History
    ratio: float = 0.0
    rate: float = np.inf

    @cached_property
    def poles(self) -> AnyArray:
        """Poles s [1/s], complex ``(k,)``, of each pair the upper; those that grow first."""
        return self._modes[0]

    @cached_property
    def shares(self) -> AnyArray:
        """Their c, complex ``(k,)``; of a pair the real part of c z is its share of the load."""
        return self._modes[1]

    @cached_property
    def grows(self) -> BoolArray:
        """Which of them grow, ``(k,)``."""
        return np.arange(self.poles.size) < self._modes[2]

    @cached_property
    def rates(self) -> AnyArray:
        """The rates [1/s] at which they fade to the side from which they are summed, ``(k,)``."""
        return np.where(self.grows, self.poles, -self.poles)

    @cached_property
    def sizes(self) -> FloatArray:
        """|s| [1/s], ``(k,)``, and 1 for a pole at zero."""
        return np.where(self.poles == 0.0, 1.0, np.abs(self.poles))

    @cached_property
    def held(self) -> AnyArray:
        """-z of a deflection that is one for ever, of those that grow; else zero, ``(k,)``."""
        return np.where(self.grows, self.sizes / np.where(self.grows, self.poles, 1.0), 0.0)

    @property
    def fastest(self) -> float:
        """The largest |s| [1/s]."""
        return float(np.abs(self.poles).max())

    def column(self, values: AnyArray) -> FloatArray:
        """Numbers of the modes ``(..., k)`` as real ones, of a pair both parts, ``(..., m)``."""
        both = np.stack([values.real, values.imag], axis=-1)
        return both.reshape(*values.shape[:-1], -1)[..., self._kept]

    def matrix(self, values: AnyArray) -> FloatArray:
        """What multiplies each mode by a number ``(..., k)``, on real ones, ``(..., m, m)``."""
        k = values.shape[-1]
        found = np.zeros((*values.shape[:-1], 2 * k, 2 * k))
        even = 2 * np.arange(k)
        found[..., even, even] = found[..., even + 1, even + 1] = values.real
        found[..., even + 1, even], found[..., even, even + 1] = values.imag, -values.imag
        return found[..., self._kept, :][..., self._kept]

    def load(self, times: FloatArray) -> FloatArray:
        """The load [rad] of the known deflection at times [s] of any shape."""
        flat = times.ravel()
        found = attitude_responses(self.plant, self.known, self.wind, flat, [_NAME])[_NAME]
        return (found + self.ratio * self.known(flat)).reshape(times.shape)

    def load_in(self, shown: FloatArray, widths: FloatArray, ends: FloatArray) -> FloatArray:
        """The load [rad] of a deflection within cells, at even places, both ends among them.

        `shown`: that of the known one there, ``(n, q)``. `widths`: of the cells [s], ``(n,)``.
        `ends`: the deflection at start and end less the known one [rad], ``(2, n)``.
        """
        n, grows, x = widths.size, self.grows, np.linspace(0.0, 1.0, shown.shape[1])
        over, near, far = carried(self.rates, widths[:, np.newaxis])
        start, end = ends[0][:, np.newaxis], ends[1][:, np.newaxis]
        own = self.sizes * np.where(grows, -(near * start + far * end), far * start + near * end)
        z = np.zeros((n + 1, grows.size), dtype=complex)
        z[n] = -self.held * ends[1, -1]
        for k in range(n - 1, 0, -1):
            z[k] = np.where(grows, over[k] * z[k + 1] + own[k], 0.0)
        for k in range(n):
            z[k + 1] = np.where(grows, z[k + 1], over[k] * z[k] + own[k])
        value = start * (1.0 - x) + end * x
        found = shown + self.ratio * value
        for i in range(grows.size):
            way = 1.0 - x if grows[i] else x
            fade, close, beyond = carried(self.rates[i], widths[:, np.newaxis] * way)
            z_from, side, sign = (z[1:, i], end, -1.0) if grows[i] else (z[:-1, i], start, 1.0)
            added = sign * self.sizes[i] * (close * value + beyond * side)
            found = found + (self.shares[i] * (fade * z_from[:, np.newaxis] + added)).real
        return found

    @cached_property
    def _modes(self) -> tuple[AnyArray, AnyArray, int]:
        A, B, C, _ = self.plant.matrices()
        poles, right = np.linalg.eig(A)
        order = np.argsort(-poles.real, kind="stable")
        poles, right = poles[order].astype(complex), right[:, order]
        driven = np.linalg.solve(right, B[:, 0])
        share = (C[-1] @ right) * driven / np.where(poles == 0.0, 1.0, np.abs(poles))
        grows = np.arange(poles.size) < unstable_poles(self.plant).size
        seen = np.abs(share) > _UNSEEN * np.abs(share).max()
        kept = (poles.imag >= 0.0) & (grows | seen)
        whole = np.where(poles.imag > 0.0, 2.0, 1.0) * share
        return poles[kept], whole[kept], int(np.count_nonzero(grows & kept))

    @cached_property
    def _kept(self) -> BoolArray:
        pairs = self.poles.imag > 0.0
        return np.stack([np.ones_like(pairs), pairs], axis=-1).ravel()


def carried(rates: ArrayLike, widths: FloatArray) -> Three:
    """Return what fades to e^(-rate width), and what a straight line adds on the way.

    The line adds ``near`` times its value here and ``far`` times its value where it comes from:
    INT_0^width e^(-rate y) line(y) dy, y being the distance from here.
    """
    both = moments(np.asarray(rates) * widths, 1)
    far = widths * both[..., 1]
    return np.exp(-np.asarray(rates) * widths), widths * both[..., 0] - far, far
