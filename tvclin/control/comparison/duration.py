"""The wind of a family in which an autopilot needs the largest deflection."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import FloatArray, IndexArray
from tvclin.base.cards import Shown
from tvclin.base.documents import keyed
from tvclin.base.errors import InputError, callable_for, instance, number, positive
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.warnings import warn_of_feedback
from tvclin.control.autopilot.wiring import closed_loop
from tvclin.control.margins.record import loop_margins
from tvclin.linear.flexible import AnyPlant, check_plant
from tvclin.winds.histories import History

_DURATIONS, _EACH_SWING, _MOST_IN_A_SWING = 41, 16, 2000
"""Durations tried first: over the whole range, in each swing of a mode, and at most for one."""
_FIRST, _ABOUT = 4, 6
"""Each so many of them is tried at first, and so many of these show how tall a swing is."""
_DECAYED = 5.0
"""The swings of a mode are counted until it has fallen to e^-5."""
_NEAR = 1e-6
"""To which a worst duration is sought, over the shortest."""
_FLAT = 1e-9
"""A summit that rises less than this part above its samples is not refined."""


@dataclass(frozen=True)
class WorstDuration(Shown):
    """The wind of a family in which an autopilot needs the largest deflection.

    Attributes
    ----------
    duration : float
        Its duration [s].
    peak_deflection : float
        The deflection [rad].
    at_the_end : bool
        Whether it is the shortest or longest that was asked about: beyond it may be worse.
    """

    duration: float
    peak_deflection: float
    at_the_end: bool

    as_dict = keyed("duration_s peak_deflection_deg at_the_end")


def worst_duration(
    plant: AnyPlant,
    autopilot: Autopilot,
    *,
    peak: float,
    shortest: float,
    longest: float,
    shape: Callable[..., History],
) -> WorstDuration:
    """Return the duration in a family of winds that needs the largest deflection.

    Parameters
    ----------
    plant, autopilot : Plant or FlexiblePlant, Autopilot
        One each, with a stable closed loop.
    peak : float
        Peak [rad] of every wind of the family.
    shortest, longest : float
        The durations [s] in question.
    shape : callable
        Such as `TriangularWind`: called with peak and duration.

    Raises
    ------
    InputError
        For an unstable closed loop, and durations that are not positive and rising.

    Notes
    -----
    Durations are tried over the whole range and in every swing of the loop's modes until they
    have died out (at most 2000 for one mode), and those that may be the worst are refined. A
    family whose winds swing by themselves, faster than the loop, may hide a worse one.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> gains = tv.control.canonical_gains(plant.coefficients)
    >>> worst = tv.control.worst_duration(
    ...     plant, gains, peak=0.1, shortest=1, longest=60, shape=tv.TriangularWind
    ... )
    >>> round(worst.duration, 1), worst.at_the_end
    (12.8, False)
    """
    check_plant(plant)
    instance("autopilot", autopilot, Autopilot, "see design_gains")
    if plant.batch or autopilot.batch:
        raise InputError("worst_duration is for one case; take those of a batch one by one")
    callable_for("shape", shape, "of peak and duration, such as TriangularWind")
    peak = number("peak", peak, unit="rad")
    low = number("shortest", shortest, positive, "s")
    high = number("longest", longest, positive, "s")
    if low >= high:
        raise InputError(f"longest must be above shortest; got {high:.6g} and {low:.6g} s")
    margins = loop_margins(autopilot.exact_loop(plant))
    warn_of_feedback(autopilot, plant)
    if not margins.stable:
        raise InputError(f"no duration is the worst: {margins.reason}")
    answer = autopilot.in_winds(plant)

    def deflection(duration: float) -> float:
        return abs(answer(shape(peak=peak, duration=duration)).peak("deflection")[0])

    return _worst(deflection, _durations(closed_loop(autopilot, plant).A, low, high))


def _worst(deflection: Callable[[float], float], durations: FloatArray) -> WorstDuration:
    """The worst of the durations, or what is worse between them."""
    from scipy.optimize import minimize_scalar  # late: it takes 0.3 s to import

    durations, values = _tried(deflection, durations)
    top = int(np.argmax(values))
    ends = (0, durations.size - 1)
    worst = WorstDuration(float(durations[top]), float(values[top]), top in ends)
    for k in _summits(durations, values):
        edges = durations[k - 1], durations[k + 1]
        near = minimize_scalar(
            lambda d: -deflection(d), bounds=edges, options={"xatol": _NEAR * durations[0]}
        )
        if -near.fun > worst.peak_deflection:
            worst = WorstDuration(float(near.x), float(-near.fun), False)
    return worst


def _tried(
    deflection: Callable[[float], float], durations: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Some of the durations and their values; all of them where a swing may be the tallest.

    That is where the highest of those about rises above the rest by as much as they differ.
    """
    values = np.full(durations.shape, np.nan)

    def fill(places: IndexArray) -> None:
        values[places] = [deflection(duration) for duration in durations[places]]

    first = np.unique(np.append(np.arange(0, durations.size, _FIRST), durations.size - 1))
    fill(first)
    about = np.pad(values[first], _ABOUT // 2 - 1, mode="edge")
    about = np.lib.stride_tricks.sliding_window_view(about, _ABOUT)
    tall = 2.0 * about.max(axis=-1) - about.min(axis=-1) >= values[first].max()
    between = np.searchsorted(first, np.arange(durations.size), side="right") - 1
    fill(np.flatnonzero(np.isnan(values) & np.append(tall, False)[between]))
    known = ~np.isnan(values)
    return durations[known], values[known]


def _summits(x: FloatArray, values: FloatArray) -> list[int]:
    """The middles of the triples whose parabola may have the highest summit of all."""
    steps, slopes = np.diff(x), np.diff(values) / np.diff(x)
    bend = np.diff(slopes) / (x[2:] - x[:-2])
    slope = slopes[:-1] + bend * steps[:-1]
    hollow = np.where(bend < 0.0, bend, np.nan)
    way, gain = -slope / (2.0 * hollow), -(slope**2) / (4.0 * hollow)
    before, after = 0.5 * steps[:-1], 0.5 * steps[1:]
    before[0], after[-1] = steps[0], steps[-1]
    likely = (-before <= way) & (way <= after) & (gain > _FLAT * values.max())
    likely &= values[1:-1] + 2.0 * gain > values.max()
    return (1 + np.flatnonzero(likely)).tolist()


def _durations(A: FloatArray, low: float, high: float) -> FloatArray:
    """Durations [s] between which no swing of the closed loop A is lost, until it has decayed."""
    parts = [np.geomspace(low, high, _DURATIONS)]
    for pole in np.linalg.eigvals(A):
        last = min(_DECAYED / -pole.real, high)
        if pole.imag > 0.0 and last > low:
            count = int((last - low) * pole.imag / (2.0 * np.pi) * _EACH_SWING) + 2
            parts.append(np.linspace(low, last, min(count, _MOST_IN_A_SWING)))
    return np.unique(np.concatenate(parts))
