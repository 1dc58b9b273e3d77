"""When the dead band is left on the stability boundary, for any wind of one sign.

The report's control trims until the driver (B alpha_w, or the trim deflection) reaches K times
the limit, and holds the limit from then on. Held from the time t on, the limit that meets (4b)
is the demand, the discounted mean of the trim deflection still to come. On the boundary

    driver(t) = K demand(t),    t being the first time at which the driver is so high.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.histories import Piecewise
from tvclin.kernels import integrals
from tvclin.kernels import pieces as kernel
from tvclin.kernels.crossings import refine, roots_between
from tvclin.kernels.pieces import Pieces

FloatArray = NDArray[np.float64]

_SLACK = 8.0 * np.finfo(float).eps


@dataclass(frozen=True)
class Switch:
    """The solution: when the dead band is left, and two ways in which there is none.

    Attributes
    ----------
    time : ndarray
        Time [s], ``(...)``.
    jumps : ndarray of bool
        The demand jumps over the limit where the driver comes back to an earlier height.
    never : ndarray of bool
        The demand stays above what the driver reaches, so the dead band is never left.
    """

    time: FloatArray
    jumps: NDArray[np.bool_]
    never: NDArray[np.bool_]


@dataclass(frozen=True)
class Problem:
    """Driver and trim deflection over B alpha_w,max with its sign; all fields of one batch."""

    driver: Pieces
    trim: Pieces
    pole: FloatArray
    dead_band: FloatArray

    def demand(self, t: FloatArray) -> FloatArray:
        """Return the limit that (4b) asks for when it is held from the times ``t (..., m)`` on."""
        future = integrals.future(self.trim, self.pole, t)
        return np.real(future) * self.pole[..., np.newaxis]

    def solve(self) -> Switch:
        """Return the last time at which the driver rises through K times the demand.

        Only new heights of the driver count, for a lower limit was reached before. Of several
        solutions the last has the largest limit, and every larger limit is sufficient.
        """
        times, level = self._with_returns(*self._probed())
        excess = level - self.dead_band[..., np.newaxis] * self.demand(times)
        highest, earlier = _heights(level)
        new = (level >= earlier * (1.0 - _SLACK)) & (level > 0.0)
        last = level.shape[-1] - 1
        short = new & (excess < -_SLACK * level)
        low = np.where(np.any(short, axis=-1), last - np.argmax(short[..., ::-1], axis=-1), -1)
        after = new & (np.arange(last + 1) > low[..., np.newaxis])
        reached = np.any(after, axis=-1)
        high = np.where(reached, np.argmax(after, axis=-1), np.maximum(low, 0))
        low = np.where(low < 0, np.maximum(high - 1, 0), low)
        floor = np.take_along_axis(highest, low[..., np.newaxis], axis=-1)[..., 0]
        return self._between(times, low, high, np.where(high == 0, 0.0, floor), ~reached)

    def _probed(self) -> tuple[FloatArray, FloatArray]:
        times = Piecewise(self.driver).probe_times()
        return times, np.real(kernel.value(self.driver, times))

    def _with_returns(self, times: FloatArray, level: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Add the times at which the driver comes back up to an earlier height."""
        _, earlier = _heights(level)
        back = (level > earlier) & (np.roll(level, 1, axis=-1) < earlier)
        back[..., 0] = False
        case, column = np.nonzero(back.reshape(-1, back.shape[-1]))
        flat, height = times.reshape(-1, times.shape[-1]), earlier[back]

        def above(t: FloatArray, i: NDArray[np.intp]) -> FloatArray:
            return self._level(t, case[i]) - height[i]

        extra, extra_level = times.copy(), level.copy()
        extra[back] = roots_between(flat[case, column - 1], flat[case, column], above)
        extra_level[back] = height
        # The earlier height comes first: where the driver jumps, both stand at the same time.
        both = np.concatenate([extra, times], axis=-1)
        order = np.argsort(both, axis=-1, kind="stable")
        levels = np.concatenate([extra_level, level], axis=-1)
        return (
            np.take_along_axis(both, order, axis=-1),
            np.take_along_axis(levels, order, axis=-1),
        )

    def _between(
        self, times: FloatArray, low: Any, high: Any, floor: FloatArray, never: Any
    ) -> Switch:
        band, lowest = self.dead_band.ravel(), floor.ravel()
        pole = self.pole.ravel()

        def excess(t: FloatArray, i: NDArray[np.intp]) -> FloatArray:
            future = integrals.future(kernel.take(self.trim, i), pole[i], t[:, np.newaxis])[:, 0]
            return np.maximum(self._level(t, i), lowest[i]) - band[i] * np.real(future) * pole[i]

        ends = [np.take_along_axis(times, i[..., np.newaxis], axis=-1) for i in (low, high)]
        time = refine(np.concatenate(ends, axis=-1), np.ones_like(high), excess)
        after = np.nextafter(time, np.inf)[..., np.newaxis]
        level = np.real(kernel.value(self.driver, after))[..., 0]
        return Switch(time, (level < floor * (1.0 - 1e-9)) & ~never, never)

    def _level(self, t: FloatArray, case: NDArray[np.intp]) -> FloatArray:
        return np.real(kernel.value(kernel.take(self.driver, case), t[:, np.newaxis]))[:, 0]


def _heights(level: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The highest level so far, with and without the present one."""
    highest = np.maximum.accumulate(np.maximum(level, 0.0), axis=-1)
    return highest, np.concatenate([np.zeros_like(highest[..., :1]), highest[..., :-1]], axis=-1)
