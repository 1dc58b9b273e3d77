"""Where a regime of a flight ends, what follows, and whether one ended between two steps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.flights.closed_loop.regimes import Loop, Regime
from tvclin.kernels.control_laws import switched

_LOOKS = 8
"""Looks between two steps of the solver for a regime that ends and returns there: an excursion
that is shorter than an eighth of a step, and steps are bounded by `_LONGEST`, is not seen."""
_NEAR = 0.05
"""A look so near the end of a regime, over the size of what ends it, may stand beside a touch:
what is measured there goes on to a minimum that is searched. Further off none is searched."""
_LATE = 1e-12
"""A law lets go so little late, over the limit: as it engages it must not be at its end, or the two
would switch to and fro at the same time without end."""
_GRAZE = 1e-9
"""A nozzle is at its stop so little beyond it, over the limit, for it may come to rest there."""


class End(NamedTuple):
    """How far a regime is past an end of it, ``f(t, states)``, its size, and what follows."""

    past: Callable[[Any, FloatArray], Any]
    size: float
    then: Regime


def mode_at(loop: Loop, t: float, states: FloatArray, mode: float, gust: Any) -> float:
    """Return the mode of the law at a time: +1 or -1 while it commands the whole limit, else 0."""
    demand = loop.demand(states, loop.measured(t, states, gust(t)))
    law, limit = loop.law, loop.limit
    return switched(law.engage * limit, law.release * limit, float(demand), mode)


def taken_up(loop: Loop, t: float, states: FloatArray, regime: Regime, gust: Any) -> Regime:
    """Return the regime after the command may have jumped: the rate is held at its limit, or not.

    It is where what the nozzle is drawn to points on, and the rate is at its limit that way.
    """
    if loop.actuator is None or loop.rate_limit == np.inf:
        return regime
    measured = loop.measured(t, states, gust(t), regime)
    pull = float(loop.pull(states, loop.command(states, measured, regime)))
    side, rate = np.sign(pull), pull if loop.servo == 1 else float(states[loop.order + 1])
    held = side * rate >= loop.rate_limit * (1.0 - _LATE)
    return regime._replace(rate=float(side) if held else 0.0)


def ends_of(loop: Loop, regime: Regime, gust: Any) -> list[End]:
    """Return the ends of a regime."""
    ends = [_mode_end(loop, regime, gust, side) for side in _sides(regime.mode)]
    if loop.servo and loop.rate_limit < np.inf:
        ends += [_rate_end(loop, regime, gust, side) for side in _sides(regime.rate)]
    if loop.servo > 1:  # of first order the nozzle never overshoots its command
        ends += [_stop_end(loop, regime, side) for side in _sides(regime.stop)]
    return ends


def _mode_end(loop: Loop, regime: Regime, gust: Any, side: float) -> End:
    """Past its end a demand is below `release` while the law is switched, else above `engage`."""

    def past(t: Any, states: FloatArray) -> Any:
        demand = side * loop.demand(states, loop.measured(t, states, gust(t), regime))
        if regime.mode:
            return (loop.law.release - _LATE) * loop.limit - demand
        return demand - loop.law.engage * loop.limit

    return End(past, loop.limit, regime._replace(mode=0.0 if regime.mode else side))


def _rate_end(loop: Loop, regime: Regime, gust: Any, side: float) -> End:
    """A rate is held when it comes to its limit r, and let go when the pull no longer asks for it.

    First order, s' = pull: held where |pull| > r, let go where |pull| < r. Second order, s'' =
    pull: held where |s'| > r, let go where the pull changes its sign.
    """
    most, order, first = loop.rate_limit, loop.order, loop.servo == 1
    then = regime._replace(rate=0.0 if regime.rate else side)
    if not regime.rate and not first:
        return End(lambda t, x: side * x[order + 1] - most, most, then)

    def pull(t: Any, states: FloatArray) -> Any:
        measured = loop.measured(t, states, gust(t), regime)
        return side * loop.pull(states, loop.command(states, measured, regime))

    if not regime.rate:
        return End(lambda t, x: pull(t, x) - most, most, then)
    if first:
        return End(lambda t, x: most - pull(t, x), most, then)
    size = loop.limit * float(np.asarray(loop.actuator.natural_frequency)) ** 2  # type: ignore[union-attr]
    return End(lambda t, x: -pull(t, x), size, then)


def _stop_end(loop: Loop, regime: Regime, side: float) -> End:
    limit, order = loop.limit, loop.order
    if regime.stop:
        return End(lambda t, x: limit - side * x[order], limit, regime._replace(stop=0.0))
    beyond = limit * (1.0 + _GRAZE)
    return End(lambda t, x: side * x[order] - beyond, limit, regime._replace(stop=side))


def _sides(held: float) -> tuple[float, ...]:
    """The sides on which what is held, or not, can end."""
    return (held,) if held else (1.0, -1.0)


def touched(result: Any, ends: list[End]) -> tuple[float, Regime] | None:
    """Return when a regime first ends between two steps that do not show it, and what follows."""
    from scipy.optimize import brentq, minimize_scalar

    parts = np.diff(result.t)[:, np.newaxis] * np.arange(_LOOKS) / _LOOKS
    times = np.append((result.t[:-1, np.newaxis] + parts).ravel(), result.t[-1])
    states = result.sol(times)
    found: list[tuple[float, Regime]] = []
    for end in ends:

        def short(t: Any, end: End = end) -> Any:
            return -end.past(t, result.sol(t))

        left = -end.past(times, states)
        least = (left[1:-1] <= left[:-2]) & (left[1:-1] <= left[2:])
        for k in 1 + np.flatnonzero(least & (left[1:-1] < _NEAR * end.size)):
            around = (times[k - 1], times[k + 1])
            best = minimize_scalar(short, bounds=around, options={"xatol": 1e-9})
            before = np.flatnonzero(left[:k] > 0.0)
            if best.fun < 0.0 and before.size:
                when = float(brentq(short, times[before[-1]], best.x, xtol=1e-13))
                found.append((when, end.then))
                break
    return min(found, key=lambda one: one[0], default=None)
