"""Requirements of a deflection limit that follow from open-loop controls, without a flight.

The boundary limit y_BR of eq (4b) is one of them, and not always the largest:

- the boundary of the control with the exit on trim, as in a flight;
- the minimum peak over all unstable poles, appendix C, from the onset of the wind on;
- for K = 1 the bound of all laws without a forecast of the wind;
- for 0 < K < 1 the minimum peak from the state at the exit of the dead band.

A control with the dead band K trims up to K L, and has its limit L from then on. For the last of
these requirements let m(L) be the minimum peak over all unstable modes from the time at which trim
first has the size K L, or, where trim stays below it during the wind, from the end of the wind. It
knows the remaining wind, so that the vehicle diverges where m(L) > L; required is the largest such
L. Trim is one of the controls that m compares. So for every L' from K L up to L, at which the exit
of the dead band is no later than at L,

    m(L') <= max(K L, m(L)),

by trim until K L, and the optimum from there on. Hence no limit between max(K L, m(L)) and L
diverges if L does not, and

    L <- max(K L, m(L))

descends from a limit that trim never exceeds to the largest that diverges, without passing one.
With one mode m is the demand of (4b), and the largest limit that diverges is `boundary_limit`. With
three modes or more, whose minimum peak takes a search, the highest limit that diverges is found on
a grid and by bisection.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from enum import StrEnum
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.limit import OK, BoundaryLimit, ExitProblem, boundary_limit, leading_pole
from tvclin.boundary.optimum.minimum_peak import minimum_peaks, peaks_for_demands
from tvclin.linear.modes import separated_poles, unstable_poles
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History

_RELATIVE_STEP = 1e-8
"""Step of the iteration, relative to the limit, at which it ends, above the limits that diverge."""
_RELATIVE_RANGE = 1e-5
"""Relative distance to another requirement within which its own survival is tested."""
_RELATIVE_ROUNDING = 1e-9
"""Rounding of a minimum peak, relative to the limit."""
_MAX_LIMIT = 100.0
"""Largest limit, normalised by B alpha_w,max, that is computed where trim is not bounded."""
_MAX_ITERATED_DEAD_BAND = 0.99
"""Dead band K up to which limits are iterated; above it each step, to K L, is too short."""
_MAX_STEPS = 2000
"""Largest number of steps of the iteration."""
_GRID_LEVELS = 24
"""Limits on the grid that is computed with three modes or more, or a dead band near 1."""
_BISECTIONS = 16
"""Bisections of the grid step above the highest limit that diverges."""
ROUNDING = 1e-9
"""Relative difference up to which two requirements count as equal."""


MinimumPeaks = Callable[[IndexArray, FloatArray, FloatArray], FloatArray]
"""Function from n cases, their limits L and sufficient limits to the minimum peaks m(L), ``(n,)``.

m(L) is the smallest limit of a deflection that cancels all unstable modes from the time at which
trim has the size K L; the vehicle diverges where m(L) > L. Where m(L) is proved to be no more than
the sufficient limit, that is returned. All are over static trim, of a fixed path."""


def _iterated(
    K: FloatArray, peaks: MinimumPeaks, cases: IndexArray, lower: FloatArray, highest: FloatArray
) -> FloatArray:
    """Return the largest limits L that diverge after trim, ``(n,)``, by L <- max(K L, m(L)).

    No limit between both sides of a step diverges. `K`: dead bands of all cases. `peaks`: m.
    `cases`: n indices. `lower`: other requirements, below which no limit counts. `highest`: starts,
    which do not diverge. Limits are normalised by static trim.
    """
    limit, K = np.array(highest), K[cases]
    active = np.arange(cases.size)
    for _ in range(_MAX_STEPS):
        if not active.size:
            break
        L, floor = limit[active], lower[active]
        lowest = np.maximum(floor, K[active] * L)
        next_L = np.minimum(np.maximum(lowest, peaks(cases[active], L, lowest)), L)
        limit[active] = next_L
        done = L - next_L <= _RELATIVE_STEP * L
        # a limit close to `lower` is not approached in small steps: it is `lower` if that survives
        close = np.flatnonzero(~done & (next_L <= floor * (1.0 + _RELATIVE_RANGE)))
        level = floor[close]
        survives = peaks(cases[active[close]], level, level) <= level * (1.0 + _RELATIVE_ROUNDING)
        limit[active[close[survives]]] = level[survives]
        done[close[survives]] = True
        active = active[~done]
    return np.maximum(lower, limit)


def _bisected(
    peaks: MinimumPeaks, cases: IndexArray, lower: FloatArray, highest: FloatArray
) -> FloatArray:
    """Return the highest limits that diverge after trim, ``(n,)``, by a grid and bisection.

    L diverges if m(L) exceeds it. `peaks`: m. `cases`: n indices. `lower`: result if none above it
    diverges. `highest`: a limit that trim never exceeds. All are normalised by static trim.
    """

    def diverges(which: IndexArray, limits: FloatArray) -> BoolArray:
        """Return whether limits ``(c, ...)`` diverge after trim; `which`: c indices in `cases`."""
        flat = limits.ravel()
        repeated = np.repeat(cases[which], limits.size // which.size)
        exceeded = peaks(repeated, flat, flat) > flat * (1.0 + _RELATIVE_ROUNDING)
        return exceeded.reshape(limits.shape)

    indices = np.arange(cases.size)
    levels = np.geomspace(lower, highest, _GRID_LEVELS, axis=-1)
    diverged = diverges(indices, levels[:, :-1])  # the highest is never exceeded by trim
    steps_down = np.argmax(diverged[:, ::-1], axis=-1)
    last = np.where(diverged.any(axis=-1), _GRID_LEVELS - 2 - steps_down, -1)
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


class Reason(StrEnum):
    """Requirement that sets the required deflection at nominal dynamic pressure, as text."""

    BOUNDARY = "the boundary of the control with the exit on trim"
    MINIMUM = "the minimum over all unstable poles"
    AFTER_TRIM = "the minimum over all unstable poles after trim"
    NO_FORECAST = "the bound without a forecast"
    TRIM_LAW = "the trim law flown"
    ONE_PLANE = "the plane that requires the larger part of the limit"
    BOTH_PLANES = "the boundary of both planes together"
    NOTHING = "nothing"

    def __repr__(self) -> str:
        """Return the text in quotes."""
        return repr(self.value)

    @property
    def larger(self) -> str:
        """Sentence that this requirement is larger than the boundary limit."""
        if self is Reason.BOUNDARY:
            return "in flight, where trim itself exits the dead band, the requirement is larger"
        return f"{self} is larger"


def open_loop_requirements(
    plant: Plant,
    wind: History,
    dead_band: ArrayLike,
    boundary: BoundaryLimit,
    sufficient: FloatArray | None = None,
) -> dict[Reason, FloatArray]:
    """Return the requirements of a deflection limit by name, sizes [rad] of shape ``(...)``.

    Parameters
    ----------
    plant, wind, dead_band
        Same parameters as `boundary_limit`.
    boundary : BoundaryLimit
        The boundary limit of these with the "literal" switch: as in a flight, the dead band ends
        where trim, not the wind, exceeds K times the limit.
    sufficient : ndarray, optional
        Peaks [rad] in place of the minimum where they are proved to be no less, see
        `minimum_peaks`.

    Returns
    -------
    dict of Reason to ndarray
        The boundary, the minimum, the bound without a forecast (for K = 1) and the minimum after
        trim (for 0 < K < 1); zero where one does not apply.
    """
    K = np.asarray(dead_band)
    size = np.abs(np.asarray(boundary.deflection))
    poles, free = unstable_poles(plant), np.zeros(())  # `free`: bound without a forecast [rad]
    # the bound of a single plant raises where the fastest pole is not real; in a batch it is NaN
    if np.any(K == 1.0) and (plant.batch or (poles.size and not np.imag(poles[0]))):
        free = np.abs(np.asarray(forecast_free_limit(plant, wind).deflection))
    free = np.where(K == 1.0, np.nan_to_num(free), 0.0)
    required = {
        Reason.BOUNDARY: size,
        Reason.MINIMUM: np.broadcast_to(minimum_peaks(plant, wind, sufficient), size.shape),
        Reason.NO_FORECAST: np.broadcast_to(free, size.shape),
    }
    largest = np.max(list(required.values()), axis=0)
    return required | {Reason.AFTER_TRIM: _limit_after_trim(plant, wind, K, largest)}


def with_larger_requirements(
    plant: Plant, wind: History, dead_band: ArrayLike, boundary: BoundaryLimit
) -> BoundaryLimit:
    """Return boundary limits ``(...)`` whose status names the open-loop requirement above them.

    Parameters
    ----------
    plant, wind, dead_band
        Same parameters as `boundary_limit`.
    boundary : BoundaryLimit
        The boundary limit of these, with either switch.
    """
    literal = boundary_limit(plant, wind, dead_band, "literal")
    size, status = np.abs(np.asarray(boundary.deflection)), np.asarray(boundary.status)
    required = open_loop_requirements(plant, wind, dead_band, literal, size)
    largest = np.max(list(required.values()), axis=0)
    larger = largest > size * (1.0 + ROUNDING)
    if not np.any(larger):
        return boundary
    governs = [(sizes * (1.0 + ROUNDING) >= largest)[larger] for sizes in required.values()]
    # sentence on the requirement that governs, behind the status of the boundary unless it is "ok"
    words, before = np.select(governs, [reason.larger for reason in required], ""), status[larger]
    combined = np.where(before == OK, words, np.char.add(np.char.add(before, "; "), words))
    status = status.astype(np.result_type(status, combined))
    status[larger] = combined
    return replace(boundary, status=status if status.ndim else str(status))


def _limit_after_trim(
    plant: Plant, wind: History, dead_band: FloatArray, smallest: FloatArray
) -> FloatArray:
    """Return the largest limit [rad] that diverges after trim up to K times it, else 0.

    `plant`, `wind`: one or a batch. `dead_band`: K. `smallest`: limits [rad] up to which the result
    is zero, of its shape. Zero for K = 0, K = 1, fewer than two modes, and two that are a pair. A
    limit L diverges if the minimum peak over all unstable modes, after trim up to K L, exceeds L.
    """
    poles, shape = unstable_poles(plant), smallest.shape
    if poles.shape[-1] < 2 or not np.any((dead_band > 0.0) & (dead_band < 1.0)):
        return np.zeros(shape)
    pole, paired = leading_pole(plant)
    K = np.broadcast_to(np.where(paired, 1.0, dead_band), shape)  # 1: zero for a pair
    problem = ExitProblem(plant, wind, pole=pole, dead_band=K, shape=shape)
    # limits are normalised by static trim [rad] from here on
    static_trim = np.abs(np.asarray(plant.coefficients.B) * wind.peak)
    with np.errstate(divide="ignore", invalid="ignore"):  # no moment, nothing to trim
        lower = np.broadcast_to(smallest / static_trim, shape)
    limits = lower.flatten()
    modes = separated_poles(np.broadcast_to(poles, (*shape, poles.shape[-1])))
    modes = modes.reshape(-1, modes.shape[-1])
    number = (~np.isnan(modes)).sum(axis=-1)  # NaN stands for a mode that is not there
    applicable = (K.ravel() > 0.0) & (K.ravel() < 1.0) & np.isfinite(limits) & (number > 1)
    # trim never exceeds `highest`, so that no limit above it is ever reached
    highest = np.minimum(problem.largest_trim(applicable.reshape(shape)).ravel(), _MAX_LIMIT)
    applicable &= highest > limits
    dead_bands = K.ravel()

    def peaks(cases: IndexArray, limits: FloatArray, sufficient: FloatArray) -> FloatArray:
        """Return m(L) of `MinimumPeaks` for n `cases` and `limits` L, ``(n,)``."""
        # z: constant deflection that each mode requires by itself after trim up to K L; z over the
        # pole p is the integral of e^(-p t) times the deflection that the mode demands
        z = problem.demands_after_trim(cases, dead_bands[cases] * limits, modes[cases])
        return peaks_for_demands(modes[cases], z / modes[cases], sufficient)

    iterated = (number == 2) & (dead_bands <= _MAX_ITERATED_DEAD_BAND)
    for search, cases in ((partial(_iterated, dead_bands), iterated), (_bisected, ~iterated)):
        selected = np.flatnonzero(applicable & cases)
        if selected.size:
            limits[selected] = search(peaks, selected, limits[selected], highest[selected])
    limit = limits.reshape(shape)
    return np.where(limit > lower, limit * static_trim, 0.0)
