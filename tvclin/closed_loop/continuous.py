"""One flight of a law that is computed without pause: event-exact.

Knots of the wind, the limit and the switches of the law are hit, not stepped over: scipy's DOP853
runs from each to the next, and what it did between two steps is looked at afterwards, so that a
limit which is touched for a moment is hit as well. Corners that leave everything continuous (the
rate limit and the stop of an actuator, the ends of a lean) are left to its error control.

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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.autopilot import Actuator
from tvclin.closed_loop.checks import LOST, check_not_lost
from tvclin.closed_loop.equations import Equations
from tvclin.closed_loop.sampled import switched
from tvclin.errors import InputError
from tvclin.histories import History
from tvclin.laws import Law, Seen

FloatArray = NDArray[np.float64]

_RTOL, _ATOL = 1e-9, 1e-12
"""Of the solver, for each step; the second over the peak of the wind."""
_LONGEST = 5.0
"""Of a step, over the time of the fastest pole: DOP853 is stable there, and between the ends of a
step off by at most 12 times the error that it controls; at 16 that is 400 times."""
_MOST = 5000
"""Switches of the law in one flight."""
_LOOKS = 8
"""Looks between two steps of the solver for a mode that ends and returns there."""
_NEAR = 0.05
"""A look so near the end of the mode, over the limit, may stand beside a touch."""
_HAIR = 1e-12
"""A law lets go so little late, over the limit: as it engages it must not be at its end."""


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
        state, mode = np.zeros(self._size), 0.0
        self._check_law(start, state)
        found: list[Arc] = []
        for first, last in pairwise(edges):
            gust = smooth_piece(self.wind, float(first))
            now = float(first)
            mode = self._mode(now, state, mode, gust)
            while now < last:
                if len(found) > _MOST:
                    raise InputError(
                        f"the law switches more than {_MOST} times; give a sample_rate to fly it"
                    )
                result = self._solved((now, float(last)), state, mode, gust)
                found.append(Arc(now, result.sol, mode))
                touched = self._touched(result, mode, gust)
                if touched is not None:
                    now, mode = touched
                    state = result.sol(now)
                    continue
                now, state = float(result.t[-1]), result.y[:, -1]
                if abs(state[0]) >= self.farthest:
                    return found
                if result.status == 1:
                    mode = self._after(mode, 1.0 if result.t_events[0].size else -1.0)
        return found

    def _solved(self, span: tuple[float, float], state: FloatArray, mode: float, gust: Any) -> Any:
        """What the solver finds from a state on, until the mode seems to end or the span does."""
        from scipy.integrate import solve_ivp

        result = solve_ivp(
            self._rates,
            span,
            state,
            method="DOP853",
            rtol=_RTOL,
            atol=_ATOL * abs(float(self.wind.peak)),
            max_step=self._longest,
            dense_output=True,
            events=self._events(mode),
            args=(mode, gust),
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
            seen = self._seen(times[here], states, self.wind(times[here]))
            rows[:order, here] = states[:order]
            rows[-1, here] = self._deflection(states, seen, arcs[k].mode)
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
    def _longest(self) -> float:
        """The longest step of the solver [s], for the poles of the actuator and of the law."""
        servo = np.zeros(0) if self.actuator is None else np.roots(self.actuator.denominator)
        poles = np.concatenate([servo, np.linalg.eigvals(self._memory[0])])
        fastest = float(np.abs(poles).max(initial=0.0))
        return _LONGEST / fastest if fastest else np.inf

    def _seen(self, t: Any, states: FloatArray, wind: Any) -> Seen:
        path = states[2] if self._order > 2 else 0.0 * states[0]
        alpha = self.equations.angle_of_attack(t, states[: self._order], wind)
        shown = np.nan if self.actuator is None else self._nozzle(states)
        return Seen(states[0], states[1], path, alpha, shown)

    def _nozzle(self, states: FloatArray) -> Any:
        return np.clip(states[self._order], -self.limit, self.limit)

    def _check_law(self, start: float, rest: FloatArray) -> None:
        """Without an actuator the deflection follows from the demand, and not the other way."""
        if np.isnan(self._demand(rest, self._seen(start, rest, 0.0))):
            raise InputError(
                "a law that looks at the deflection needs an actuator or a sample_rate"
            )

    def _demand(self, states: FloatArray, seen: Seen) -> Any:
        memory = states[self._order + self._servo :]
        return self.law.demand(seen, memory, self.limit)

    def _deflection(self, states: FloatArray, seen: Seen, mode: float) -> Any:
        if self.actuator is not None:
            return self._nozzle(states)
        demand = mode * self.limit if mode else self._demand(states, seen)
        return np.clip(demand, -self.limit, self.limit)

    def _rates(self, t: float, states: FloatArray, mode: float, gust: Any) -> FloatArray:
        order = self._order
        wind = gust(t)
        seen = self._seen(t, states, wind)
        demand = self._demand(states, seen)
        command = mode * self.limit if mode else float(demand)
        if not isfinite(command):
            raise InputError(
                f"the flight lost its numbers near t = {t:.6g} s: the deflection that the law asks"
                " for is not finite"
            )
        deflection = command
        rates = np.zeros(states.size)
        if self.actuator is not None:
            servo = states[order : order + self._servo]
            deflection = float(seen.deflection)
            rates[order : order + self._servo] = self._servo_rates(servo, command)
        rates[:order] = self.equations.rates(t, states[:order], deflection, wind)
        F, G = self._memory
        if len(F):
            memory = states[order + self._servo :]
            rates[order + self._servo :] = F @ memory + G @ np.array([*seen[:4], deflection])
        return rates

    def _servo_rates(self, servo: FloatArray, command: float) -> FloatArray:
        assert self.actuator is not None
        most, w = self.rate_limit, float(np.asarray(self.actuator.natural_frequency))
        if self.actuator.damping is None:
            return np.clip([w * (command - servo[0])], -most, most)
        pull = w * w * (command - servo[0])
        pull -= 2.0 * float(np.asarray(self.actuator.damping)) * w * servo[1]
        if abs(servo[1]) >= most and pull * servo[1] > 0.0:
            pull = 0.0
        return np.array([min(max(servo[1], -most), most), pull])

    @cached_property
    def _memory(self) -> tuple[FloatArray, FloatArray]:
        return self.law.states

    def _mode(self, t: float, states: FloatArray, mode: float, gust: Any) -> float:
        demand = self._demand(states, self._seen(t, states, gust(t)))
        found = switched(self.law, np.asarray(demand), np.asarray(mode), np.asarray(self.limit))
        return float(found)

    def _past(self, t: Any, states: FloatArray, gust: Any, mode: float, side: float) -> Any:
        """How far the demand is past the end of the mode [rad]; the mode ends as this rises."""
        demand = side * self._demand(states, self._seen(t, states, gust(t)))
        if mode:
            return (self.law.release - _HAIR) * self.limit - demand
        return demand - self.law.engage * self.limit

    def _events(self, mode: float) -> list[Any]:
        """What rises through zero where the mode ends."""
        events = []
        for side in _sides(mode):

            def past(
                t: float, states: FloatArray, mode: float, gust: Any, side: float = side
            ) -> float:
                return float(self._past(t, states, gust, mode, side))

            past.terminal = True  # type: ignore[attr-defined]
            past.direction = 1.0  # type: ignore[attr-defined]
            events.append(past)
        return [*events, _beyond(self.farthest)]

    def _touched(self, result: Any, mode: float, gust: Any) -> tuple[float, float] | None:
        """When the mode first ends between two steps that do not show it, and the next mode."""
        from scipy.optimize import brentq, minimize_scalar

        parts = np.diff(result.t)[:, np.newaxis] * np.arange(_LOOKS) / _LOOKS
        times = np.append((result.t[:-1, np.newaxis] + parts).ravel(), result.t[-1])
        found = []
        for side in _sides(mode):

            def short(t: Any, side: float = side) -> Any:
                return -self._past(t, result.sol(t), gust, mode, side)

            left = short(times)
            least = (left[1:-1] <= left[:-2]) & (left[1:-1] <= left[2:])
            for k in 1 + np.flatnonzero(least & (left[1:-1] < _NEAR * self.limit)):
                around = (times[k - 1], times[k + 1])
                best = minimize_scalar(short, bounds=around, options={"xatol": 1e-9})
                before = np.flatnonzero(left[:k] > 0.0)
                if best.fun < 0.0 and before.size:
                    end = float(brentq(short, times[before[-1]], best.x, xtol=1e-13))
                    found.append((end, self._after(mode, side)))
                    break
        return min(found, default=None)

    def _after(self, mode: float, side: float) -> float:
        return 0.0 if mode else side


def _beyond(farthest: float) -> Any:
    """What falls through zero where a flight ends: lost, or its attitude a hair beyond."""

    def left(t: float, states: FloatArray, mode: float, gust: Any) -> float:
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
