"""Requirement of a control that trims first: the least peak over all modes from the switch on.

A control with the dead band K trims up to K L, and has its limit L from then on. The vehicle
diverges if even the deflection of least peak, which knows the remaining wind, requires more than L
from the state at the exit of the dead band:

    m(L) = the least peak over all unstable modes since trim first had the size K L,
    diverges where m(L) > L;    required is the largest L that diverges.

Where trim stays below K L during the wind, m counts from the end of the wind on.

Trim is one of the controls that m compares. So for every L' from K L up to L, at which the exit
of the dead band is no later than at L,

    m(L') <= max(K L, m(L)),

by trim until K L, and the optimum from there on. Hence no limit between max(K L, m(L)) and L
diverges if L does not, and

    L <- max(K L, m(L))

descends from a limit that trim never exceeds to the largest that diverges, without passing one.
With one mode m is the demand of (4b), and the largest limit that diverges is `boundary_limit`. With
three modes or more, whose least peak takes a search, the highest limit that diverges is found on a
grid and by bisection.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tvclin.boundary.optimum.least_peaks import peaks_of
from tvclin.boundary.switching import Problem
from tvclin.linear.modes import separated_poles

_RELATIVE_STEP = 1e-8
"""Step of the iteration, relative to the limit, at which it ends, above the limits that diverge."""
_RELATIVE_RANGE = 1e-5
"""Relative distance to another requirement within which its own survival is tested."""
_RELATIVE_ROUNDING = 1e-9
"""Rounding of a least peak, relative to the limit."""
_MAX_LIMIT = 100.0
"""Largest limit, normalised by B alpha_w,max, that is computed where trim is not bounded."""
_MAX_STEPS = 2000
"""Largest number of steps of the iteration: sufficient for dead bands up to 0.99."""
_GRID_LEVELS = 24
"""Limits on the grid that is computed with three modes or more."""
_BISECTIONS = 16
"""Bisections of the grid step above the highest limit that diverges."""


def limit_after_trim(problem: Problem, poles: AnyArray, lower: FloatArray) -> FloatArray:
    """Return the largest limit that diverges after trim, at least `lower`; ``(...)``.

    `problem`: plants with a moment, and winds of one sign. `poles`: all unstable poles [1/s], the
    fastest first, ``(..., N)``; NaN for no pole. `lower`: smallest limit of interest, normalised by
    B alpha_w,max, ``(...)``. Returned: normalised by B alpha_w,max; `lower` for K = 0, K = 1, and
    fewer than two modes.
    """
    shape, count = problem.shape, poles.shape[-1]
    K = np.broadcast_to(problem.dead_band, shape).ravel()
    limits = np.array(np.broadcast_to(lower, shape), dtype=float).ravel()
    modes = separated_poles(np.broadcast_to(poles, (*shape, count)).reshape(-1, count))
    number = (~np.isnan(modes)).sum(axis=-1)
    applicable = (K > 0.0) & (K < 1.0) & np.isfinite(limits) & (number > 1)
    highest = np.minimum(problem.largest_trim(applicable.reshape(shape)).ravel(), _MAX_LIMIT)
    applicable &= highest > limits
    after = _AfterTrim(problem, K, modes)
    for search, cases in ((_iterated, number == 2), (_bisected, number > 2)):
        selected = np.flatnonzero(applicable & cases)
        if selected.size:
            limits[selected] = search(after, selected, limits[selected], highest[selected])
    return limits.reshape(shape)


@dataclass(frozen=True)
class _AfterTrim:
    """Dead bands ``(n,)`` and modes ``(n, m)`` of a problem, flattened."""

    problem: Problem
    dead_band: FloatArray
    modes: AnyArray

    def peaks(self, cases: IndexArray, limits: FloatArray, sufficient: FloatArray) -> FloatArray:
        """Return m(L) of cases ``(n,)``, or `sufficient` where that is proved to be no less."""
        poles = self.modes[cases]
        z = self.problem.demands_after_trim(cases, self.dead_band[cases] * limits, poles)
        return peaks_of(poles, z / poles, sufficient)


def _iterated(
    after: _AfterTrim, cases: IndexArray, lower: FloatArray, highest: FloatArray
) -> FloatArray:
    """Return the largest limits that diverge, at least `lower`, by L <- max(K L, m(L))."""
    limit, K = np.array(highest), after.dead_band[cases]
    active = np.arange(cases.size)
    for _ in range(_MAX_STEPS):
        if not active.size:
            break
        above, floor = limit[active], lower[active]
        lowest = np.maximum(floor, K[active] * above)
        below = np.minimum(np.maximum(lowest, after.peaks(cases[active], above, lowest)), above)
        limit[active] = below
        done = above - below <= _RELATIVE_STEP * above
        close = np.flatnonzero(~done & (below <= floor * (1.0 + _RELATIVE_RANGE)))
        level = floor[close]
        equal = after.peaks(cases[active[close]], level, level) <= level * (
            1.0 + _RELATIVE_ROUNDING
        )
        limit[active[close[equal]]] = level[equal]
        done[close[equal]] = True
        active = active[~done]
    return np.maximum(lower, limit)


def _bisected(
    after: _AfterTrim, cases: IndexArray, lower: FloatArray, highest: FloatArray
) -> FloatArray:
    """Return the highest limit that diverges, by a grid and bisection, or `lower` without one."""

    def diverges(which: IndexArray, limits: FloatArray) -> BoolArray:
        """Return whether each limit diverges, the shape of `limits`."""
        flat = limits.ravel()
        repeated = np.repeat(cases[which], limits.size // which.size)
        return (after.peaks(repeated, flat, flat) > flat * (1.0 + _RELATIVE_ROUNDING)).reshape(
            limits.shape
        )

    indices = np.arange(cases.size)
    levels = np.geomspace(lower, highest, _GRID_LEVELS, axis=-1)
    diverged = diverges(indices, levels[:, :-1])  # the highest is never exceeded by trim
    last = np.where(
        diverged.any(axis=-1), _GRID_LEVELS - 2 - np.argmax(diverged[:, ::-1], axis=-1), -1
    )
    highest_limits, selected = np.array(lower), np.flatnonzero(last >= 0)
    if not selected.size:
        return highest_limits
    low, high = levels[selected, last[selected]], levels[selected, last[selected] + 1]
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        failed = diverges(selected, middle)
        low, high = np.where(failed, middle, low), np.where(failed, high, middle)
    highest_limits[selected] = high
    return highest_limits
