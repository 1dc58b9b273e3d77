"""Flights of laws without sampling: event-exact integration through the regimes of the nozzle.

A regime is what is constant between two events: the law demands or commands the full limit (mode),
the nozzle moves freely or at its rate limit (rate), or rests at its deflection limit (stop). Within
a regime the equations are smooth; the solver restarts at each end of a regime and at each
breakpoint of the wind.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import count, pairwise
from math import isfinite
from typing import Any, NamedTuple, Protocol

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law, Measurement
from tvclin.flights.closed_loop.checks import LOST, check_not_lost
from tvclin.kernels.control_laws import switched
from tvclin.winds.histories import History


class Equations(Protocol):
    """States, of which the first are attitude, rate and perhaps flight path, and their rates."""

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""

    @property
    def scales(self) -> FloatArray:
        """Size of each state where an angle has the size 1."""

    def rates(self, t: float, x: FloatArray, deflection: float, gust: float) -> FloatArray:
        """Return the derivatives of the states."""

    def angle_of_attack(self, t: Any, x: FloatArray, gust: Any) -> Any:
        """Return the angle of attack [rad]."""


class Regime(NamedTuple):
    """On which side (+1, -1; 0 for none) law, rate and nozzle are held: all is smooth meanwhile."""

    mode: float = 0.0
    rate: float = 0.0
    stop: float = 0.0


@dataclass(frozen=True, eq=False)
class Loop:
    """The equations of one flight in a regime.

    `limit`, `rate_limit`: of the deflection [rad] and its rate [rad/s]. `actuator`: what lies
    between command and deflection. `gain`: factor on what the law asks for.
    """

    equations: Equations
    law: Law
    limit: float
    rate_limit: float
    actuator: Actuator | None
    gain: float = 1.0

    @cached_property
    def order(self) -> int:
        """States of the vehicle."""
        return len(self.equations.states)

    @cached_property
    def servo(self) -> int:
        """States of the nozzle."""
        return 0 if self.actuator is None else self.actuator.denominator.size - 1

    @cached_property
    def memory(self) -> tuple[FloatArray, FloatArray]:
        """F and G of the law's own states."""
        return self.law.states

    @property
    def size(self) -> int:
        """States of all."""
        return self.order + self.servo + len(self.memory[0])

    @cached_property
    def fastest(self) -> float:
        """The largest size of a pole of the nozzle or of the law [1/s]; zero without any."""
        servo = np.zeros(0) if self.actuator is None else np.roots(self.actuator.denominator)
        poles = np.concatenate([servo, np.linalg.eigvals(self.memory[0])])
        return float(np.abs(poles).max(initial=0.0))

    def measured(
        self, t: Any, states: FloatArray, wind: Any, regime: Regime | None = None
    ) -> Measurement:
        """Return what a law is shown; the deflection is NaN where there is no nozzle."""
        path = states[2] if self.order > 2 else 0.0 * states[0]
        alpha = self.equations.angle_of_attack(t, states[: self.order], wind)
        shown = np.nan if self.actuator is None else self.nozzle(states, regime)
        return Measurement(states[0], states[1], path, alpha, shown)

    def nozzle(self, states: FloatArray, regime: Regime | None = None) -> Any:
        """Return the deflection [rad], in a regime smooth even a step of the solver too far."""
        position = states[self.order]
        if regime is None:
            return np.clip(position, -self.limit, self.limit)
        return regime.stop * self.limit + 0.0 * position if regime.stop else position

    def demand(self, states: FloatArray, measured: Measurement) -> Any:
        """Return what the law asks for, times the gain [rad]."""
        memory = states[self.order + self.servo :]
        return self.gain * self.law.demand(measured, memory, self.limit)

    def command(self, states: FloatArray, measured: Measurement, regime: Regime) -> Any:
        """Return what is commanded [rad]: the demand, or the limit that the law is switched to."""
        return regime.mode * self.limit if regime.mode else self.demand(states, measured)

    def deflection(self, states: FloatArray, measured: Measurement, mode: float) -> Any:
        """Return the deflection [rad] that acts."""
        if self.actuator is not None:
            return self.nozzle(states)
        demand = mode * self.limit if mode else self.demand(states, measured)
        return np.clip(demand, -self.limit, self.limit)

    def pull(self, states: FloatArray, command: Any) -> Any:
        """Return what no limit holds: s' of a nozzle of first order, s'' of one of second."""
        assert self.actuator is not None
        w, order = float(np.asarray(self.actuator.natural_frequency)), self.order
        if self.actuator.damping is None:
            return w * (command - states[order])
        drag = 2.0 * float(np.asarray(self.actuator.damping)) * w
        return w * w * (command - states[order]) - drag * states[order + 1]

    def rates(self, t: float, states: FloatArray, regime: Regime, gust: Any) -> FloatArray:
        """Return the derivatives of the states in a wind ``gust(t)``."""
        order = self.order
        wind = gust(t)
        measured = self.measured(t, states, wind, regime)
        command = float(self.command(states, measured, regime))
        if not isfinite(command):
            raise InputError(
                f"the flight fails near t = {t:.6g} s: the deflection that the law commands is not"
                " finite"
            )
        deflection = command
        rates = np.zeros(states.size)
        if self.actuator is not None:
            deflection = float(measured.deflection)
            pull = self.pull(states, command)
            if regime.rate:
                rates[order] = regime.rate * self.rate_limit
            elif self.servo == 1:
                rates[order] = pull
            else:
                rates[order : order + 2] = states[order + 1], pull
        rates[:order] = self.equations.rates(t, states[:order], deflection, wind)
        F, G = self.memory
        if len(F):
            memory = states[order + self.servo :]
            rates[order + self.servo :] = F @ memory + G @ np.array([*measured[:4], deflection])
        return rates


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
