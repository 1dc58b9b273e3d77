"""When the dead band is left on the stability boundary, for any wind of one sign.

The report's control trims until the driver (B alpha_w, or the trim deflection) reaches K times
the limit, and holds the limit from then on. Held from the time t on, the limit that meets (4b)
is the demand, the discounted mean of the trim deflection still to come. On the boundary

    driver(t) = K demand(t),    t being the first time at which the driver is so high.

Only new heights of the driver count, for a lower limit was reached before. Of several solutions
the last has the largest limit, and every larger limit is sufficient.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tvclin.kernels import switches
from tvclin.kernels.choice import run
from tvclin.kernels.remaining_integrals import demands_at_heights
from tvclin.linear.plant import Plant
from tvclin.numerics.pieces import kernel_arrays
from tvclin.winds.histories import History


@dataclass(frozen=True)
class Switch:
    """The solution: when the dead band is left, and two ways in which there is none.

    `time`: time [s], ``(...)``. `demand`: what (4b) asks for when the limit is held from that time
    on, over B alpha_w,max. `jumps`: the demand jumps over the limit where the driver comes back to
    an earlier height. `never`: the demand stays above what the driver reaches, so the dead band is
    never left.
    """

    time: FloatArray
    demand: FloatArray
    jumps: BoolArray
    never: BoolArray


@dataclass(frozen=True)
class Problem:
    """Which wind a plant is in, and what decides about it.

    `plant`, `wind`: batches; the wind ends. `pole`: the growth rate [1/s] whose condition (4b) is
    met, positive. `dead_band`: K. All broadcast to `shape`. `shape`: of the batch.
    """

    plant: Plant
    wind: History
    pole: FloatArray
    dead_band: FloatArray
    shape: tuple[int, ...]

    def solve(self, literal: bool) -> Switch:
        """Return the solution for the driver B alpha_w, or where `literal` for trim itself."""
        winds, which, numbers = self._arrays
        out = np.empty((3, which.size))
        self._run(switches.switches, self._filtering, winds, which, numbers, literal, out)
        time, demand, status = out.reshape(3, *self.shape)
        return Switch(time, demand, status == switches.JUMP, status == switches.UNREACHED)

    def largest_trim(self, cases: BoolArray) -> FloatArray:
        """Return the largest trim over B alpha_w,max of some cases; zero for the others."""
        found = np.zeros(self.shape)
        winds, which, numbers = self._arrays
        some = np.flatnonzero(cases)
        out = np.empty(some.size)
        self._run(switches.largest_trims, self._filtering, winds, which[some], numbers[some], out)
        found.ravel()[some] = out
        return found

    def left_at(self, cases: IndexArray, heights: FloatArray, poles: AnyArray) -> AnyArray:
        """Return what modes ask for when trim is left at a height; all over B alpha_w,max.

        `cases`: places of some cases in the flattened batch, ``(n,)``. `heights`: of trim to
        either side, positive, ``(n,)``. `poles`: of the modes [1/s], real or complex, ``(n, m)``.
        Returned: the limit that each mode by itself asks for, held from then on, ``(n, m)``.
        """
        winds, which, numbers = self._arrays
        found = np.empty(poles.shape, dtype=np.result_type(poles, winds[1]))
        work = (np.ascontiguousarray(numbers[cases, 2:]), np.ascontiguousarray(poles), heights)
        self._run(demands_at_heights, 1, winds, which[cases], *work, found)
        return found if np.iscomplexobj(poles) else np.real(found)

    @cached_property
    def _arrays(self) -> tuple[Any, IndexArray, FloatArray]:
        """The winds over their peaks, the wind of each case, and the numbers of each."""
        winds, which = kernel_arrays((self.wind * (1.0 / self.wind.peak)).pieces, self.shape)
        filtering = self.plant.trim_filter
        every = (self.pole, self.dead_band, *filtering)
        columns = [np.broadcast_to(one, self.shape).ravel() for one in every]
        return winds, which, np.stack(columns, axis=-1)

    @property
    def _filtering(self) -> int:
        """How often as long it takes to follow trim as where it is the wind."""
        winds, _, numbers = self._arrays
        return switches.FILTERED[winds[1].dtype.kind] if np.any(numbers[:, 2:]) else 1

    def _run(self, function: Any, longer: int, winds: Any, which: IndexArray, *arrays: Any) -> None:
        terms = longer * winds[0].shape[-1] * winds[2].shape[-1] * which.size
        seconds = (switches.PLAIN * terms, switches.COMPILED * terms)
        run(function, (winds, which, *arrays), which.size, *seconds)
