"""Exit time of the dead band on the stability boundary, for any wind of one sign.

The report's control trims until the driver (B alpha_w, or the trim deflection) reaches K times
the limit, and the deflection is at the limit from then on. The constant deflection from the time t
on that satisfies (4b) is the demand, the discounted mean of the remaining trim. On the boundary

    driver(t) = K demand(t),    t being the first time at which the driver has this height.

Only new maxima of the driver are exits, for a lower height was reached before. Of several solutions
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
    """Exit of the dead band: time and demand, and two flags of cases without a solution.

    `time`: of the exit [s], ``(...)``. `demand`: constant deflection from that time on that
    satisfies (4b), normalised by B alpha_w,max. `jumps`: the demand jumps over the limit where the
    driver returns to an earlier height. `never`: the demand stays above the driver, so that the
    dead band has no exit.
    """

    time: FloatArray
    demand: FloatArray
    jumps: BoolArray
    never: BoolArray


@dataclass(frozen=True)
class Problem:
    """A plant in a wind, with the unstable pole and the dead band of condition (4b).

    `plant`, `wind`: batches; the wind ends. `pole`: the growth rate [1/s] whose condition (4b) is
    satisfied, positive. `dead_band`: K. All broadcast to `shape`. `shape`: of the batch.
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
        """Return the largest trim of cases, normalised by B alpha_w,max; zero for the others."""
        trims = np.zeros(self.shape)
        winds, which, numbers = self._arrays
        selected = np.flatnonzero(cases)
        out = np.empty(selected.size)
        self._run(
            switches.largest_trims, self._filtering, winds, which[selected], numbers[selected], out
        )
        trims.ravel()[selected] = out
        return trims

    def demands_after_trim(
        self, cases: IndexArray, heights: FloatArray, poles: AnyArray
    ) -> AnyArray:
        """Return the demand of each mode after trim up to a height, normalised by B alpha_w,max.

        `cases`: indices in the flattened batch, ``(n,)``. `heights`: sizes of trim, positive,
        ``(n,)``. `poles`: of the modes [1/s], real or complex, ``(n, m)``. Returned: the constant
        deflection from then on that each mode requires by itself, ``(n, m)``.
        """
        winds, which, numbers = self._arrays
        demands = np.empty(poles.shape, dtype=np.result_type(poles, winds[1]))
        work = (np.ascontiguousarray(numbers[cases, 2:]), np.ascontiguousarray(poles), heights)
        self._run(demands_at_heights, 1, winds, which[cases], *work, demands)
        return demands if np.iscomplexobj(poles) else np.real(demands)

    @cached_property
    def _arrays(self) -> tuple[Any, IndexArray, FloatArray]:
        """Winds normalised by their peaks, the wind index of each case, and its parameters."""
        winds, which = kernel_arrays((self.wind * (1.0 / self.wind.peak)).pieces, self.shape)
        filtering = self.plant.trim_filter
        numbers = (self.pole, self.dead_band, *filtering)
        columns = [np.broadcast_to(values, self.shape).ravel() for values in numbers]
        return winds, which, np.stack(columns, axis=-1)

    @property
    def _filtering(self) -> int:
        """Ratio of the time to compute trim to that where trim is the wind itself."""
        winds, _, numbers = self._arrays
        return switches.FILTERED[winds[1].dtype.kind] if np.any(numbers[:, 2:]) else 1

    def _run(self, function: Any, longer: int, winds: Any, which: IndexArray, *arrays: Any) -> None:
        terms = longer * winds[0].shape[-1] * winds[2].shape[-1] * which.size
        seconds = (switches.PLAIN * terms, switches.COMPILED * terms)
        run(function, (winds, which, *arrays), which.size, *seconds)
