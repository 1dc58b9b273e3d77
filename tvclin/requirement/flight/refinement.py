"""Flight times between the listed ones of a sizing, about the largest totals.

The largest total of listed flight times is a lower bound of that over the flight. The intervals
beside each local maximum are halved until a parabola through it and its neighbours can rise above
it by no more than 0.1 percent: by an eighth of the second difference.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.requirement.flight.sizing import Sizing, joined_sizing

_MAX_FIRST_STEP_S = 5.0
"""Largest interval between flight times [s] before the first halving."""
_MAX_FIRST_STEPS = 1000
"""Number of such intervals in a flight above which they are longer."""
_MIN_STEP_S = 0.3
"""Interval between flight times [s] below which none is halved."""
_MAX_HALVINGS = 6
"""Largest number of halvings, each of all intervals at once."""
_MAX_RELATIVE_RISE = 1e-3
"""Largest rise of the total between flight times, over the largest total, that is neglected."""
_MAX_PARABOLIC_STEP_S = 2.5
"""Interval between flight times [s] above which a total may be no parabola: always halved."""
_RELATIVE_TOLERANCE = 1e-6
"""Relative difference of totals below which they count as equal."""
_LOCAL_MAXIMUM_FRACTION = 0.9
"""Fraction of the largest total below which local maxima are omitted."""


def refined_sizing(
    sizing: Sizing,
    size_at: Callable[[FloatArray], Sizing],
    totals_of: Callable[[Sizing], Mapping[float, float]],
) -> Sizing:
    """Return a sizing with further flight times about the largest required deflections.

    Intervals are halved beside each maximum that a parabola through three times may exceed.

    Parameters
    ----------
    sizing : Sizing
        The sizing of the listed flight times; returned as it is if these are fewer than two.
    size_at : callable
        From flight times [s] to the sizing there.
    totals_of : callable
        From a sizing to its totals by flight time [s], where they are known: required deflections
        with all that adds to them [rad].
    """
    totals = dict(totals_of(sizing))
    # even times in long intervals at first, then middles of intervals
    step = max(_MAX_FIRST_STEP_S, np.ptp(sizing.times) / _MAX_FIRST_STEPS)
    even = [
        np.linspace(*ends, 1 + int(np.ceil((ends[1] - ends[0]) / step - _RELATIVE_TOLERANCE)))
        for ends in pairwise(np.unique(sizing.times).tolist())
    ]
    further = np.concatenate([[], *(times[1:-1] for times in even)])
    for _ in range(1 + _MAX_HALVINGS):
        if further.size:
            further_sizing = size_at(further)
            totals |= totals_of(further_sizing)
            sizing = joined_sizing(sizing, further_sizing)
        times = np.sort(sizing.times)
        further = _middles(times, np.array([totals.get(t, np.nan) for t in times.tolist()]))
        if not further.size:
            break
    return sizing


def neighbouring_times(
    time: float | None, listed: FloatArray, refined: FloatArray
) -> tuple[float, ...]:
    """Return the two listed flight times [s] between which a time [s] was inserted.

    `listed`: flight times of the request. `refined`: these and the inserted ones. Empty for a
    listed time, and for one that is none of them.
    """
    if time is None or time in listed or time not in refined:
        return ()
    order = np.sort(listed)
    after = int(np.searchsorted(order, time))
    return tuple(order[after - 1 : after + 1].tolist())


def _middles(times: FloatArray, totals: FloatArray) -> FloatArray:
    """Return the middles [s] of intervals beside local maxima of totals [rad] at `times` [s].

    A maximum counts whose second difference is so large that the total may rise above it between
    the times. Intervals that are short, or have an end at which the total is NaN, have no middle.
    """
    finite, step = ~np.isnan(totals), np.diff(times)
    finite_ends = finite[:-1] & finite[1:]
    totals = np.where(finite, totals, 0.0)
    largest, rise = totals.max(), np.where(finite_ends, np.diff(totals), 0.0)
    before, after = np.append(0.0, rise), np.append(rise, 0.0)  # rises to and from each time
    longer_step = np.maximum(np.append(0.0, step), np.append(step, 0.0))
    parabolic = longer_step <= _MAX_PARABOLIC_STEP_S
    # a parabola rises above its middle value by at most an eighth of its second difference
    negligible = largest * np.where(parabolic, 8.0 * _MAX_RELATIVE_RISE, _RELATIVE_TOLERANCE)
    is_maximum = (before >= 0.0) & (after <= 0.0) & (before - after > negligible)
    is_maximum &= totals >= _LOCAL_MAXIMUM_FRACTION * largest
    halved = (is_maximum[:-1] | is_maximum[1:]) & finite_ends & (step >= _MIN_STEP_S)
    return np.asarray(times[:-1] + 0.5 * step)[halved]
