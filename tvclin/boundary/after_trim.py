"""What a control needs that trims first: the least peak over all modes from the switch on.

A control with the dead band K trims up to K L, and has its limit L from then on. Nothing that it
does after that brings the vehicle back if even the deflection of least peak, which knows the rest
of the wind, needs more than L from the state that trim has left:

    m(L) = the least peak over all unstable modes since trim first had the size K L,
    lost where m(L) > L;    required is the largest L that is lost.

Where trim stays below K L while the wind blows, m counts from the end of the wind on.

Trim is one of the controls that m compares. So for every L' from K L up to L, whose dead band is
left no later than that of L,

    m(L') <= max(K L, m(L)),

by trim until K L, and the best from there on. Hence no limit between max(K L, m(L)) and L is lost
if L is not, and

    L <- max(K L, m(L))

comes down from a limit that trim never exceeds to the largest that is lost, and steps over none.
With one mode m is the demand of (4b), and the largest limit lost is that of `boundary_limit`. With
three modes or more, whose least peak takes a search, limits are tried, and the highest that is lost
is closed in.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tvclin.boundary.optimum.least_peaks import peaks_of
from tvclin.boundary.switching import Problem
from tvclin.linear.modes import separated_poles

_ARRIVED = 1e-8
"""Of a limit: steps below this part of it end the search. It stays above what is lost."""
_NEAR, _SAME = 1e-5, 1e-9
"""A limit this near to another requirement that is not lost itself, within rounding, is that."""
_HIGHEST = 100.0
"""Over B alpha_w,max: where trim grows without end no larger limit is looked at."""
_STEPS = 2000
"""More than the search takes with dead bands up to 0.99."""
_LEVELS, _HALVINGS = 24, 16
"""Limits that are tried with three modes or more, and halvings of the step above the one lost."""


def least_after_trim(problem: Problem, poles: AnyArray, least: FloatArray) -> FloatArray:
    """Return the largest limit that is lost after trim, at least `least`.

    `problem`: plants with a moment, and winds of one sign. `poles`: all unstable poles [1/s], the
    fastest first, ``(..., N)``; NaN where there is none. `least`: what is needed anyhow, over B
    alpha_w,max, ``(...)``: no smaller limit is looked at. Returned: over B alpha_w,max, ``(...)``.
    `least` for K = 0, K = 1, and fewer than two modes.
    """
    shape, count = problem.shape, poles.shape[-1]
    K = np.broadcast_to(problem.dead_band, shape).ravel()
    found = np.array(np.broadcast_to(least, shape), dtype=float).ravel()
    modes = separated_poles(np.broadcast_to(poles, (*shape, count)).reshape(-1, count))
    number = (~np.isnan(modes)).sum(axis=-1)
    asked = (K > 0.0) & (K < 1.0) & np.isfinite(found) & (number > 1)
    highest = np.minimum(problem.largest_trim(asked.reshape(shape)).ravel(), _HIGHEST)
    asked &= highest > found
    after = _AfterTrim(problem, K, modes)
    for search, cases in ((_stepped_down, number == 2), (_closed_in, number > 2)):
        some = np.flatnonzero(asked & cases)
        if some.size:
            found[some] = search(after, some, found[some], highest[some])
    return found.reshape(shape)


@dataclass(frozen=True)
class _AfterTrim:
    """Dead bands ``(n,)`` and modes ``(n, m)`` of a problem, flattened."""

    problem: Problem
    dead_band: FloatArray
    modes: AnyArray

    def peaks(self, cases: IndexArray, limits: FloatArray, enough: FloatArray) -> FloatArray:
        """Return m(L) of some cases, or what is enough where that is proved to be no less."""
        poles = self.modes[cases]
        z = self.problem.left_at(cases, self.dead_band[cases] * limits, poles)
        return peaks_of(poles, z / poles, enough)


def _stepped_down(
    after: _AfterTrim, cases: IndexArray, least: FloatArray, highest: FloatArray
) -> FloatArray:
    """Come down from limits that are not lost, by L <- max(K L, m(L))."""
    limit, K = np.array(highest), after.dead_band[cases]
    left = np.arange(cases.size)
    for _ in range(_STEPS):
        if not left.size:
            break
        above, floor = limit[left], least[left]
        lowest = np.maximum(floor, K[left] * above)
        below = np.minimum(np.maximum(lowest, after.peaks(cases[left], above, lowest)), above)
        limit[left] = below
        ends = above - below <= _ARRIVED * above
        near = np.flatnonzero(~ends & (below <= floor * (1.0 + _NEAR)))
        level = floor[near]
        same = after.peaks(cases[left[near]], level, level) <= level * (1.0 + _SAME)
        limit[left[near[same]]] = level[same]
        ends[near[same]] = True
        left = left[~ends]
    return np.maximum(least, limit)


def _closed_in(
    after: _AfterTrim, cases: IndexArray, least: FloatArray, highest: FloatArray
) -> FloatArray:
    """Try limits, and close in on the highest that is lost; `least` where none is."""

    def lost(which: IndexArray, limits: FloatArray) -> BoolArray:
        flat = limits.ravel()
        every = np.repeat(cases[which], limits.size // which.size)
        return (after.peaks(every, flat, flat) > flat * (1.0 + _SAME)).reshape(limits.shape)

    everyone = np.arange(cases.size)
    levels = np.geomspace(least, highest, _LEVELS, axis=-1)
    gone = lost(everyone, levels[:, :-1])  # the highest is never exceeded by trim
    last = np.where(gone.any(axis=-1), _LEVELS - 2 - np.argmax(gone[:, ::-1], axis=-1), -1)
    found, some = np.array(least), np.flatnonzero(last >= 0)
    if not some.size:
        return found
    low, high = levels[some, last[some]], levels[some, last[some] + 1]
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        fails = lost(some, middle)
        low, high = np.where(fails, middle, low), np.where(fails, high, middle)
    found[some] = high
    return found
