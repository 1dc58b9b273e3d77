"""One flight of a law that is computed without pause: event-exact.

Knots of the wind, the limit and the switches of the law, the rate limit and the stop of an
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
from itertools import pairwise
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tvclin.base.errors import InputError
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law, Measurement
from tvclin.flights.closed_loop.checks import LOST, check_not_lost
from tvclin.flights.closed_loop.equations import Equations
from tvclin.kernels.control_laws import switched
from tvclin.winds.histories import History

FloatArray = NDArray[np.float64]

_RTOL, _ATOL = 1e-9, 1e-12
"""Of the solver, for each step; the second over the peak of the wind."""
_NOZZLE = 0.01
"""Both are so many times as small with an actuator: between its corners steps are long."""
_LONGEST = 5.0
"""Of a step, over the time of the fastest pole: DOP853 is stable there, and between the ends of a
step off by at most 12 times the error that it controls; at 16 that is 400 times."""
_MOST_SWITCHES = 5000
"""Switches of the law and its nozzle in one flight."""
_LOOKS = 8
"""Looks between two steps of the solver for a mode that ends and returns there."""
_NEAR = 0.05
"""A look so near the end of the mode, over the limit, may stand beside a touch."""
_HAIR = 1e-12
"""A law lets go so little late, over the limit: as it engages it must not be at its end."""
_GRAZE = 1e-9
"""A nozzle is at its stop so little beyond it, over the limit, for it may come to rest there."""


class _Regime(NamedTuple):
    """On which side (+1, -1; 0 for none) law, rate and nozzle are held: all is smooth meanwhile."""

    mode: float = 0.0
    rate: float = 0.0
    stop: float = 0.0


class _End(NamedTuple):
    """How far a regime is past an end of it, ``f(t, states)``, its size, and what follows."""

    past: Callable[[Any, FloatArray], Any]
    size: float
    then: _Regime


@dataclass(frozen=True, eq=False)
class Arc:
    """A part of a flight without a switch: when it begins, its solution, and its mode."""

    start: float
    solution: Callable[[FloatArray], FloatArray]
    mode: float


@dataclass(frozen=True, eq=False)
class ContinuousFlight:
    """The equations of one flight.

    Attributes
    ----------
    equations, law, wind : Equations, Law, History
        What flies.
    limit, rate_limit : float
        Of the deflection [rad] and its rate [rad/s].
    actuator : Actuator or None
        What lies between command and deflection.
    farthest : float
        Attitude [rad] from the nominal at which the flight ends.
    """

    equations: Equations
    law: Law
    wind: History
    limit: float
    rate_limit: float
    actuator: Actuator | None
    farthest: float = LOST

    def arcs(self, start: float, stop: float) -> list[Arc]:
        """Return the flight from rest at `start` to `stop` [s], arc by arc.

        It ends early where the attitude is as far from the nominal as `farthest`.
        """
        knots = self.wind.knots
        edges = np.unique([start, *knots[(knots > start) & (knots < stop)], stop])
        state, regime = np.zeros(self._size), _Regime()
        self._check_law(start, state)
        found: list[Arc] = []
        for first, last in pairwise(edges):
            gust = smooth_piece(self.wind, float(first))
            now = float(first)
            regime = regime._replace(mode=self._mode(now, state, regime.mode, gust))
            regime = self._taken_up(now, state, regime, gust)
            while now < last:
                if len(found) > _MOST_SWITCHES:
                    raise InputError(
                        f"the law or its nozzle switches more than {_MOST_SWITCHES} times; give a"
                        " sample_rate to fly it"
                    )
                ends = self._ends(regime, gust)
                result = self._solved((now, float(last)), state, regime, gust, ends)
                found.append(Arc(now, result.sol, regime.mode))
                before = regime
                touched = _touched(result, ends)
                if touched is not None:
                    now, regime = touched
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
                    regime = self._taken_up(now, state, regime, gust)
                if regime.rate and self._servo > 1:
                    state = state.copy()
                    state[self._order + 1] = regime.rate * self.rate_limit
        return found

    def _solved(
        self,
        span: tuple[float, float],
        state: FloatArray,
        regime: _Regime,
        gust: Any,
        ends: list[_End],
    ) -> Any:
        """What the solver finds from a state on, until the regime seems to end or the span does."""
        from scipy.integrate import solve_ivp

        sharp = 1.0 if self.actuator is None else _NOZZLE
        result = solve_ivp(
            self._rates,
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
        order = self._order
        rows = np.zeros((order + 1, times.size))
        for k in np.unique(index[index >= 0]):
            here = index == k
            states = arcs[k].solution(times[here])
            measured = self._measured(times[here], states, self.wind(times[here]))
            rows[:order, here] = states[:order]
            rows[-1, here] = self._deflection(states, measured, arcs[k].mode)
        return rows

    @property
    def _size(self) -> int:
        return self._order + self._servo + len(self._memory[0])

    @cached_property
    def _order(self) -> int:
        return len(self.equations.states)

    @cached_property
    def _servo(self) -> int:
        return 0 if self.actuator is None else self.actuator.denominator.size - 1

    @cached_property
    def _smallest(self) -> FloatArray:
        """Of each state what the solver may take for zero."""
        smallest = np.full(self._size, _ATOL * abs(float(self.wind.peak)))
        smallest[: self._order] *= self.equations.scales
        return smallest

    @cached_property
    def _longest(self) -> float:
        """The longest step of the solver [s], for the poles of the actuator and of the law."""
        servo = np.zeros(0) if self.actuator is None else np.roots(self.actuator.denominator)
        poles = np.concatenate([servo, np.linalg.eigvals(self._memory[0])])
        fastest = float(np.abs(poles).max(initial=0.0))
        return _LONGEST / fastest if fastest else np.inf

    def _measured(
        self, t: Any, states: FloatArray, wind: Any, regime: _Regime | None = None
    ) -> Measurement:
        path = states[2] if self._order > 2 else 0.0 * states[0]
        alpha = self.equations.angle_of_attack(t, states[: self._order], wind)
        shown = np.nan if self.actuator is None else self._nozzle(states, regime)
        return Measurement(states[0], states[1], path, alpha, shown)

    def _nozzle(self, states: FloatArray, regime: _Regime | None = None) -> Any:
        """The deflection [rad]; within a regime it is smooth, even a step of the solver too far."""
        position = states[self._order]
        if regime is None:
            return np.clip(position, -self.limit, self.limit)
        return regime.stop * self.limit + 0.0 * position if regime.stop else position

    def _check_law(self, start: float, rest: FloatArray) -> None:
        """Without an actuator the deflection follows from the demand, and not the other way."""
        if np.isnan(self._demand(rest, self._measured(start, rest, 0.0))):
            raise InputError(
                "a law that looks at the deflection needs an actuator or a sample_rate"
            )

    def _demand(self, states: FloatArray, measured: Measurement) -> Any:
        memory = states[self._order + self._servo :]
        return self.law.demand(measured, memory, self.limit)

    def _deflection(self, states: FloatArray, measured: Measurement, mode: float) -> Any:
        if self.actuator is not None:
            return self._nozzle(states)
        demand = mode * self.limit if mode else self._demand(states, measured)
        return np.clip(demand, -self.limit, self.limit)

    def _rates(self, t: float, states: FloatArray, regime: _Regime, gust: Any) -> FloatArray:
        order = self._order
        wind = gust(t)
        measured = self._measured(t, states, wind, regime)
        command = float(self._command(states, measured, regime))
        if not isfinite(command):
            raise InputError(
                f"the flight lost its numbers near t = {t:.6g} s: the deflection that the law asks"
                " for is not finite"
            )
        deflection = command
        rates = np.zeros(states.size)
        if self.actuator is not None:
            deflection = float(measured.deflection)
            pull = self._pull(states, command)
            if regime.rate:
                rates[order] = regime.rate * self.rate_limit
            elif self._servo == 1:
                rates[order] = pull
            else:
                rates[order : order + 2] = states[order + 1], pull
        rates[:order] = self.equations.rates(t, states[:order], deflection, wind)
        F, G = self._memory
        if len(F):
            memory = states[order + self._servo :]
            rates[order + self._servo :] = F @ memory + G @ np.array([*measured[:4], deflection])
        return rates

    def _command(self, states: FloatArray, measured: Measurement, regime: _Regime) -> Any:
        return regime.mode * self.limit if regime.mode else self._demand(states, measured)

    def _pull(self, states: FloatArray, command: Any) -> Any:
        """What the servo does of itself: the rate of its last state."""
        assert self.actuator is not None
        w, order = float(np.asarray(self.actuator.natural_frequency)), self._order
        if self.actuator.damping is None:
            return w * (command - states[order])
        drag = 2.0 * float(np.asarray(self.actuator.damping)) * w
        return w * w * (command - states[order]) - drag * states[order + 1]

    @cached_property
    def _memory(self) -> tuple[FloatArray, FloatArray]:
        return self.law.states

    def _mode(self, t: float, states: FloatArray, mode: float, gust: Any) -> float:
        demand = self._demand(states, self._measured(t, states, gust(t)))
        law, limit = self.law, self.limit
        return switched(law.engage * limit, law.release * limit, float(demand), mode)

    def _taken_up(self, t: float, states: FloatArray, regime: _Regime, gust: Any) -> _Regime:
        """The regime after the command may have jumped: the rate is held at its limit, or not."""
        if self.actuator is None or self.rate_limit == np.inf:
            return regime
        measured = self._measured(t, states, gust(t), regime)
        pull = float(self._pull(states, self._command(states, measured, regime)))
        side, rate = np.sign(pull), pull if self._servo == 1 else float(states[self._order + 1])
        held = side * rate >= self.rate_limit * (1.0 - _HAIR)
        return regime._replace(rate=float(side) if held else 0.0)

    def _ends(self, regime: _Regime, gust: Any) -> list[_End]:
        """The ends of a regime."""
        ends = [self._mode_end(regime, gust, side) for side in _sides(regime.mode)]
        if self._servo and self.rate_limit < np.inf:
            ends += [self._rate_end(regime, gust, side) for side in _sides(regime.rate)]
        if self._servo > 1:  # of first order the nozzle never overshoots its command
            ends += [self._stop_end(regime, side) for side in _sides(regime.stop)]
        return ends

    def _mode_end(self, regime: _Regime, gust: Any, side: float) -> _End:
        then = regime._replace(mode=0.0 if regime.mode else side)
        return _End(lambda t, x: self._past(t, x, gust, regime, side), self.limit, then)

    def _rate_end(self, regime: _Regime, gust: Any, side: float) -> _End:
        most, order, first = self.rate_limit, self._order, self._servo == 1
        then = regime._replace(rate=0.0 if regime.rate else side)
        if not regime.rate and not first:
            return _End(lambda t, x: side * x[order + 1] - most, most, then)

        def pull(t: Any, states: FloatArray) -> Any:
            measured = self._measured(t, states, gust(t), regime)
            return side * self._pull(states, self._command(states, measured, regime))

        if not regime.rate:
            return _End(lambda t, x: pull(t, x) - most, most, then)
        if first:
            return _End(lambda t, x: most - pull(t, x), most, then)
        size = self.limit * float(np.asarray(self.actuator.natural_frequency)) ** 2  # type: ignore[union-attr]
        return _End(lambda t, x: -pull(t, x), size, then)

    def _stop_end(self, regime: _Regime, side: float) -> _End:
        limit, order = self.limit, self._order
        if regime.stop:
            return _End(lambda t, x: limit - side * x[order], limit, regime._replace(stop=0.0))
        beyond = limit * (1.0 + _GRAZE)
        return _End(lambda t, x: side * x[order] - beyond, limit, regime._replace(stop=side))

    def _past(self, t: Any, states: FloatArray, gust: Any, regime: _Regime, side: float) -> Any:
        """How far the demand is past the end of the mode [rad]; the mode ends as this rises."""
        demand = side * self._demand(states, self._measured(t, states, gust(t), regime))
        if regime.mode:
            return (self.law.release - _HAIR) * self.limit - demand
        return demand - self.law.engage * self.limit


def _event(end: _End) -> Any:
    """What rises through zero where the regime ends, as the solver asks for it."""

    def past(t: float, states: FloatArray, regime: _Regime, gust: Any) -> float:
        return float(end.past(t, states))

    past.terminal = True  # type: ignore[attr-defined]
    past.direction = 1.0  # type: ignore[attr-defined]
    return past


def _touched(result: Any, ends: list[_End]) -> tuple[float, _Regime] | None:
    """When a regime first ends between two steps that do not show it, and what follows."""
    from scipy.optimize import brentq, minimize_scalar

    parts = np.diff(result.t)[:, np.newaxis] * np.arange(_LOOKS) / _LOOKS
    times = np.append((result.t[:-1, np.newaxis] + parts).ravel(), result.t[-1])
    states = result.sol(times)
    found: list[tuple[float, _Regime]] = []
    for end in ends:

        def short(t: Any, end: _End = end) -> Any:
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


def _beyond(farthest: float) -> Any:
    """What falls through zero where a flight ends: lost, or its attitude a hair beyond."""

    def left(t: float, states: FloatArray, regime: _Regime, gust: Any) -> float:
        lost = LOST * (1.0 + 1e-6) - float(np.abs(states).max())
        return min(lost, farthest * (1.0 + 1e-6) - abs(float(states[0])))

    left.terminal = True  # type: ignore[attr-defined]
    return left


def _sides(mode: float) -> tuple[float, ...]:
    """The sides of the demand on which a mode can end."""
    return (mode,) if mode else (1.0, -1.0)


def smooth_piece(history: History, start: float) -> Callable[[Any], Any]:
    """Return a history from a knot on as its own smooth function.

    So the solver sees no jump at the next knot, and it takes half the time of ``history(t)``.
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
