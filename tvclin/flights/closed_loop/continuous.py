"""One flight of a continuous law: event-exact.

Breakpoints of the wind, the limit and the switches of the law, the rate limit and the stop of an
actuator are hit, not stepped over: scipy's DOP853 runs from each to the next, and what it did
between two steps is looked at afterwards, so that a limit which is touched for a moment is hit as
well. The ends of a lean, corners that leave everything continuous, are left to its error control.

That control sees the ends of steps only. With a fast actuator or observer steps grow to where the
solver is no longer stable, and are a thousand times less exact between their ends than at them. So
they are held shorter than that.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import count, pairwise
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.flights.closed_loop.checks import LOST, check_not_lost
from tvclin.flights.closed_loop.regime_ends import End, ends_of, mode_at, taken_up, touched
from tvclin.flights.closed_loop.regimes import Loop, Regime
from tvclin.winds.histories import History

_RTOL, _ATOL = 1e-9, 1e-12
"""Of the solver, for each step; the second over the peak of the wind."""
_NOZZLE = 0.01
"""Both are so many times as small with an actuator: between its corners steps are long."""
_LONGEST = 5.0
"""Of a step, over the time of the fastest pole: DOP853 is stable there, and between the ends of a
step off by at most 12 times the error that it controls; at 16 that is 400 times."""
_MOST_SWITCHES = 5000
"""Switches of the law and its nozzle in one flight."""
_MOST_EVALUATIONS = 500_000
"""Of the equations in one flight: hours with an actuator of 4 Hz. Long after t = 0 the rounding of
the time alone asks for so many, for steps become as short as it."""


@dataclass(frozen=True, eq=False)
class Arc:
    """A part of a flight without a switch: when it begins, its solution, and its mode."""

    start: float
    solution: Callable[[FloatArray], FloatArray]
    mode: float


@dataclass(frozen=True, eq=False)
class ContinuousFlight:
    """One loop in one wind; it ends where its attitude is `farthest` from the nominal [rad]."""

    loop: Loop
    wind: History
    farthest: float = LOST

    def arcs(self, start: float, stop: float) -> list[Arc]:
        """Return the flight from rest at `start` to just beyond `stop` [s], arc by arc."""
        stop = max(float(np.nextafter(stop, np.inf)), start + 1e-9)
        knots = self.wind.knots
        edges = np.unique([start, *knots[(knots > start) & (knots < stop)], stop])
        loop, rates = self.loop, _counted(self.loop.rates)
        state, regime = np.zeros(loop.size), Regime()
        self._check_law(start, state)
        found: list[Arc] = []
        for first, last in pairwise(edges):
            gust = smooth_piece(self.wind, float(first))
            now = float(first)
            regime = regime._replace(mode=mode_at(loop, now, state, regime.mode, gust))
            regime = taken_up(loop, now, state, regime, gust)
            while now < last:
                if len(found) > _MOST_SWITCHES:
                    raise InputError(
                        f"the law or its nozzle switches more than {_MOST_SWITCHES} times; give a"
                        " sample_rate to fly it"
                    )
                ends = ends_of(loop, regime, gust)
                result = self._solved(rates, (now, float(last)), state, regime, gust, ends)
                found.append(Arc(now, result.sol, regime.mode))
                before = regime
                between = touched(result, ends)
                if between is not None:
                    now, regime = between
                    state = result.sol(now)
                else:
                    now, state = float(result.t[-1]), result.y[:, -1]
                    if abs(state[0]) >= self.farthest:
                        return found
                    if result.status == 1:
                        regime = next(
                            end.then
                            for end, times in zip(ends, result.t_events, strict=False)
                            if times.size
                        )
                if regime.mode != before.mode:
                    regime = taken_up(loop, now, state, regime, gust)
                if regime.rate and loop.servo > 1:
                    state = state.copy()
                    state[loop.order + 1] = regime.rate * loop.rate_limit
        return found

    def _solved(
        self,
        rates: Callable[..., FloatArray],
        span: tuple[float, float],
        state: FloatArray,
        regime: Regime,
        gust: Any,
        ends: list[End],
    ) -> Any:
        """What the solver finds from a state on, until the regime seems to end or the span does."""
        from scipy.integrate import solve_ivp

        sharp = 1.0 if self.loop.actuator is None else _NOZZLE
        result = solve_ivp(
            rates,
            span,
            state,
            method="DOP853",
            rtol=sharp * _RTOL,
            atol=sharp * self._smallest,
            max_step=self._longest,
            dense_output=True,
            events=[*(_event(end) for end in ends), _beyond(self.farthest)],
            args=(regime, gust),
        )
        time = float(result.t[-1])
        if result.status < 0:
            raise InputError(f"the solver fails at t = {time:.6g} s; give a sample_rate to fly it")
        check_not_lost(time, result.y[:, -1])
        return result

    def shown(self, arcs: list[Arc], times: FloatArray) -> FloatArray:
        """Return plant states and deflection at the times ``(m,)``, shape ``(n + 1, m)``."""
        starts = np.array([arc.start for arc in arcs])
        index = np.searchsorted(starts, times, side="right") - 1
        loop, order = self.loop, self.loop.order
        rows = np.zeros((order + 1, times.size))
        for k in np.unique(index[index >= 0]):
            here = index == k
            states = arcs[k].solution(times[here])
            measured = loop.measured(times[here], states, self.wind(times[here]))
            rows[:order, here] = states[:order]
            rows[-1, here] = loop.deflection(states, measured, arcs[k].mode)
        return rows

    @cached_property
    def _smallest(self) -> FloatArray:
        """Of each state what the solver may take for zero."""
        smallest = np.full(self.loop.size, _ATOL * abs(float(self.wind.peak)))
        smallest[: self.loop.order] *= self.loop.equations.scales
        return smallest

    @property
    def _longest(self) -> float:
        """The longest step of the solver [s], for the poles of the actuator and of the law."""
        return _LONGEST / self.loop.fastest if self.loop.fastest else np.inf

    def _check_law(self, start: float, rest: FloatArray) -> None:
        """Without an actuator the deflection follows from the demand, and not the other way."""
        if np.isnan(self.loop.demand(rest, self.loop.measured(start, rest, 0.0))):
            raise InputError(
                "a law that looks at the deflection needs an actuator or a sample_rate"
            )


def _counted(rates: Callable[..., FloatArray]) -> Callable[..., FloatArray]:
    """Return the equations of one flight, refused when they are asked for too often."""
    asked = count(1)

    def counted(t: float, *state: Any) -> FloatArray:
        if next(asked) > _MOST_EVALUATIONS:
            raise InputError(
                f"the flight takes more than {_MOST_EVALUATIONS} evaluations of its equations, at"
                f" t = {t:.6g} s; let it begin near t = 0, or give a sample_rate to fly it"
            )
        return rates(t, *state)

    return counted


def _event(end: End) -> Any:
    """What rises through zero where the regime ends, as the solver asks for it."""

    def past(t: float, states: FloatArray, regime: Regime, gust: Any) -> float:
        return float(end.past(t, states))

    past.terminal = True  # type: ignore[attr-defined]
    past.direction = 1.0  # type: ignore[attr-defined]
    return past


def _beyond(farthest: float) -> Any:
    """What falls through zero where a flight ends: lost, or its attitude a millionth beyond."""

    def left(t: float, states: FloatArray, regime: Regime, gust: Any) -> float:
        lost = LOST * (1.0 + 1e-6) - float(np.abs(states).max())
        return min(lost, farthest * (1.0 + 1e-6) - abs(float(states[0])))

    left.terminal = True  # type: ignore[attr-defined]
    return left


def smooth_piece(history: History, start: float) -> Callable[[Any], Any]:
    """Return a history from a breakpoint on as its own smooth function.

    So the solver sees no jump at the next one, and it takes half the time of ``history(t)``.
    """
    pieces = history.pieces
    k = int(np.searchsorted(pieces.knots, start, side="right")) - 1
    if k < 0:
        return np.zeros_like
    knot, rates = float(pieces.knots[k]), pieces.rates
    coefficients = pieces.coefficients[k, :, ::-1]

    def value(t: Any) -> Any:
        u = t - knot
        terms = [np.polyval(c, u) * np.exp(r * u) for c, r in zip(coefficients, rates, strict=True)]
        return np.real(sum(terms))

    return value
