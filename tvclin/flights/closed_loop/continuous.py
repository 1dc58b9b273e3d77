"""Flights of laws without sampling: event-exact integration through the regimes of the nozzle.

A regime is what is constant between two events: the law demands or commands the full limit (mode),
the nozzle moves freely or at its rate limit (rate), or rests at its deflection limit (stop). Within
a regime the equations are smooth; the solver restarts at each end of a regime and at each
breakpoint of the wind.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
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
from tvclin.kernels.control_laws import next_mode
from tvclin.winds.histories import History


class Equations(Protocol):
    """Equations of motion; the first states are attitude, its rate and, with drift, the path."""

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""

    @property
    def scales(self) -> FloatArray:
        """Magnitude of each state that corresponds to an angle of one."""

    def rates(self, t: float, x: FloatArray, deflection: float, gust: float) -> FloatArray:
        """Return the derivatives of the states `x` at a time `t` [s], ``(n,)``.

        `deflection`: deflection [rad]. `gust`: wind angle [rad].
        """

    def angle_of_attack(self, t: Any, x: FloatArray, gust: Any) -> Any:
        """Return the angle of attack [rad], of the shape of the states but for their first axis.

        `t`: times [s]. `x`: states, ``(n, ...)``. `gust`: wind angles [rad].
        """

    def lateral(self, t: Any, x: FloatArray) -> dict[str, Any]:
        """Return the measurements of the lateral sensors, by name; empty without any.

        They are drift_rate [m/s], drift [m] and acceleration [m/s^2]. `t`: times [s]. `x`: states,
        ``(n, ...)``.
        """


class Regime(NamedTuple):
    """Sign of each active limit, 0 for none; the equations are smooth within a regime.

    `mode`: sign of the full limit that the law commands. `rate`: sign of the limited nozzle rate.
    `stop`: sign of the limited deflection.
    """

    mode: float = 0.0
    rate: float = 0.0
    stop: float = 0.0


@dataclass(frozen=True, eq=False)
class Loop:
    """Equations of vehicle, law and nozzle of one flight in a wind.

    `limit`, `rate_limit`: limits of the deflection [rad] and its rate [rad/s]. `actuator`: actuator
    between command and deflection. `gain`: factor on the demand of the law. `gust`: function from
    times [s] to wind angles [rad]. The states are of the vehicle, of the nozzle and of the
    law, in this order.
    """

    equations: Equations
    law: Law
    limit: float
    rate_limit: float
    actuator: Actuator | None
    gain: float = 1.0
    gust: Callable[[Any], Any] = np.zeros_like

    @cached_property
    def order(self) -> int:
        """Number of states of the vehicle."""
        return len(self.equations.states)

    @cached_property
    def servo(self) -> int:
        """Number of states of the nozzle: 0 without an actuator, else its order, 1 or 2.

        They are the deflection s, and of second order also its rate s'. The denominator has a
        coefficient more than there are states.
        """
        return 0 if self.actuator is None else self.actuator.denominator.size - 1

    @cached_property
    def memory(self) -> tuple[FloatArray, FloatArray]:
        """Matrices F and G of the law's states x, with x' = F x + G y.

        y: the first five measurements, from attitude to deflection.
        """
        return self.law.states

    @property
    def size(self) -> int:
        """Number of all states, of the vehicle, the nozzle and the law."""
        return self.order + self.servo + len(self.memory[0])

    @cached_property
    def fastest(self) -> float:
        """Largest magnitude of a pole of actuator and law [1/s], which bounds the solver's steps.

        Zero without poles.
        """
        servo = np.zeros(0) if self.actuator is None else np.roots(self.actuator.denominator)
        F, _ = self.memory  # of the law's states s' = F s + G m
        poles = np.concatenate([servo, np.linalg.eigvals(F)])
        return float(np.abs(poles).max(initial=0.0))

    def measured(self, t: Any, states: FloatArray, regime: Regime | None = None) -> Measurement:
        """Return the measurements of the law; the deflection is NaN without an actuator.

        The first states are attitude [rad], its rate, and perhaps the flight path angle. `t`: time
        [s]. `states`: all states of the loop, ``(n, ...)``. `regime`: active limits; without it the
        deflection is clipped at its limit.
        """
        path = states[2] if "flight_path_angle" in self.equations.states else 0.0 * states[0]
        alpha = self.equations.angle_of_attack(t, states[: self.order], self.gust(t))
        deflection = np.nan if self.actuator is None else self.nozzle(states, regime)
        lateral = self.equations.lateral(t, states[: self.order])
        return Measurement(
            attitude=states[0],
            attitude_rate=states[1],
            flight_path_angle=path,
            angle_of_attack=alpha,
            deflection=deflection,
            **lateral,
        )

    def nozzle(self, states: FloatArray, regime: Regime | None = None) -> Any:
        """Return the deflection [rad] of the actuator, ``(...)``, from all states of the loop.

        `states`: ``(n, ...)``. `regime`: active limits; `regime.stop` is the sign of the deflection
        limit while it is active, else zero. A deflection that is not at its limit then passes it
        without a kink, so that the solver finds the instant; without `regime` it is clipped there.
        """
        position = states[self.order]  # the first state after the vehicle's
        if regime is None:
            return np.clip(position, -self.limit, self.limit)
        # at the limit: a constant, in the shape of the states
        return regime.stop * self.limit + 0.0 * position if regime.stop else position

    def demand(self, states: FloatArray, measured: Measurement) -> Any:
        """Return the demand of the law [rad], times the gain.

        `states`: all states of the loop, ``(n, ...)``. `measured`: measurements of the law.
        """
        memory = states[self.order + self.servo :]
        return self.gain * self.law.demand(measured, memory, self.limit)

    def command(self, states: FloatArray, measured: Measurement, regime: Regime) -> Any:
        """Return the command [rad]: the demand of the law, or the full limit while that is engaged.

        `states`: all states of the loop, ``(n, ...)``. `measured`: measurements of the law.
        `regime`: active limits, whose `mode` is the sign of the full limit, or zero.
        """
        return regime.mode * self.limit if regime.mode else self.demand(states, measured)

    def deflection(self, states: FloatArray, measured: Measurement, mode: float) -> Any:
        """Return the deflection [rad]: the actuator's, or else the limited command.

        `states`: all states of the loop, ``(n, ...)``. `measured`: measurements of the law. `mode`:
        sign of the full limit that the law commands, or zero.
        """
        if self.actuator is not None:
            return self.nozzle(states)
        demand = mode * self.limit if mode else self.demand(states, measured)
        return np.clip(demand, -self.limit, self.limit)

    def pull(self, states: FloatArray, command: Any) -> Any:
        """Return s' [rad/s] of a first-order nozzle, or s'' [rad/s^2] of second order.

        s is the deflection; its rate limit does not count here. First order: s' = w (command - s).
        Second: s'' = w^2 (command - s) - 2 zeta w s', with the natural frequency w [rad/s] and the
        damping ratio zeta. `states`: all states of the loop, ``(n, ...)``, s behind the vehicle's,
        then s'. `command`: commanded deflection [rad].
        """
        assert self.actuator is not None
        w, deflection = float(np.asarray(self.actuator.natural_frequency)), states[self.order]
        if self.actuator.damping is None:
            return w * (command - deflection)
        drag = 2.0 * float(np.asarray(self.actuator.damping)) * w * states[self.order + 1]
        return w * w * (command - deflection) - drag

    def rates(self, t: float, states: FloatArray, regime: Regime) -> FloatArray:
        """Return the derivatives of all states at a time `t` [s], ``(n,)``.

        `regime`: signs of the active limits of law and nozzle. The states are of the vehicle, the
        nozzle (`servo`, its order) and the law, in this order; `memory` is F, G of the law's m' = F
        m + G measurements. The nozzle has s' or s'' of `pull` [rad/s, rad/s^2], s being its
        deflection, unless its rate is at the limit. `InputError` for a command that is not finite.
        """
        order = self.order
        measured = self.measured(t, states, regime)
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
            if regime.rate:  # of second order the rate is constant then, and its derivative zero
                rates[order] = regime.rate * self.rate_limit
            elif self.servo == 1:
                rates[order] = pull
            else:
                rates[order : order + 2] = states[order + 1], pull
        rates[:order] = self.equations.rates(t, states[:order], deflection, self.gust(t))
        F, G = self.memory
        if len(F):
            memory = states[order + self.servo :]
            inputs = measured._replace(deflection=deflection)[: G.shape[1]]
            rates[order + self.servo :] = F @ memory + G @ np.array(inputs)
        return rates


_TIMES_PER_STEP = 8
"""Number of times in a solver step at which the end of a regime is evaluated: an excursion that is
shorter than an eighth of a step is not seen; steps are bounded by `_MAX_STEP_TIMES_POLE`."""
_MAX_DISTANCE_OVER_SIZE = 0.05
"""Largest distance from the end of a regime at a local minimum that is refined, over its size."""
_RELEASE_MARGIN = 1e-12
"""Demand below the release level at which a law releases the limit, over the limit: at the instant
of engagement it must not be at its release, or the two would switch without end."""
_STOP_MARGIN = 1e-9
"""Deflection beyond the limit at which a nozzle stops, over the limit: it may settle there."""


class End(NamedTuple):
    """End of a regime: the event function `past`, its scale `size`, and the regime `then`.

    `past` is a function of time and states, positive after the end.
    """

    past: Callable[[Any, FloatArray], Any]
    size: float
    then: Regime


def mode_at(loop: Loop, t: float, states: FloatArray, mode: float) -> float:
    """Return the mode of the law at a time `t` [s]: +1 or -1 if it commands the full limit, else 0.

    A law engages the full limit when its demand reaches `engage` times the limit, and releases it
    at `release` times the limit, so that the mode depends on that before. `states`: all states of
    the loop. `mode`: mode before that time.
    """
    demand = loop.demand(states, loop.measured(t, states))
    law, limit = loop.law, loop.limit
    return next_mode(law.engage * limit, law.release * limit, float(demand), mode)


def regime_after_jump(loop: Loop, t: float, states: FloatArray, regime: Regime) -> Regime:
    """Return the regime after a possible jump of the command, with the rate limited or not.

    The rate is limited if it is at its limit in the direction in which the command accelerates the
    nozzle, the sign of `Loop.pull`. For a nozzle of first order this is the rate without its limit,
    for one of second order the acceleration, and the rate is a state. `t`: time [s]. `states`:
    all states of the loop. `regime`: active limits before.
    """
    if loop.actuator is None or loop.rate_limit == np.inf:
        return regime
    measured = loop.measured(t, states, regime)
    pull = float(loop.pull(states, loop.command(states, measured, regime)))
    sign, rate = np.sign(pull), pull if loop.servo == 1 else float(states[loop.order + 1])
    limited = sign * rate >= loop.rate_limit * (1.0 - _RELEASE_MARGIN)
    return regime._replace(rate=float(sign) if limited else 0.0)


def ends_of(loop: Loop, regime: Regime) -> list[End]:
    """Return the events that can end a regime, in which the active limits stay the same.

    They are events of the law's full limit (`mode`), of the nozzle's rate limit if there is one,
    and of its deflection limit (`stop`) with two states (`servo`): of first order the nozzle never
    overshoots. Fields of the regime are the signs of active limits, 0 for none.
    """
    ends = [_mode_end(loop, regime, sign) for sign in _signs(regime.mode)]
    if loop.servo and loop.rate_limit < np.inf:
        ends += [_rate_end(loop, regime, sign) for sign in _signs(regime.rate)]
    if loop.servo > 1:
        ends += [_stop_end(loop, regime, sign) for sign in _signs(regime.stop)]
    return ends


def _mode_end(loop: Loop, regime: Regime, sign: float) -> End:
    """Return the event at which the law engages the full limit, or if engaged, releases it.

    It has the function that passes zero there, its scale [rad], and the regime that follows. The
    thresholds are `engage` and `release` of the law times the limit. `regime`: active limits, whose
    `mode` is 0 while the full limit is not engaged. `sign`: sign of the full limit.
    """

    def past(t: Any, states: FloatArray) -> Any:
        """Return by how much [rad] the law's demand, times `sign`, is past a threshold.

        While the law is not engaged (mode 0) the demand is past the threshold of the full limit if
        it is above; while the limit is applied it is past the threshold of release if it is below.
        """
        demand = sign * loop.demand(states, loop.measured(t, states, regime))
        if regime.mode:  # the end is below `release`, by a margin against chatter
            return (loop.law.release - _RELEASE_MARGIN) * loop.limit - demand
        return demand - loop.law.engage * loop.limit

    return End(past, loop.limit, regime._replace(mode=0.0 if regime.mode else sign))


def _rate_end(loop: Loop, regime: Regime, sign: float) -> End:
    """Return the event at which the nozzle leaves its rate limit r, or if free, reaches it.

    First order, s' = pull: at the limit while ``|pull| > r``. Second order, s'' = pull: at the
    limit from ``|s'| > r`` until the pull changes its sign. s is the deflection, which is the state
    after the `order` states of the vehicle; the next one is s'. `regime`: active limits. `sign`:
    sign of the rate.
    """
    max_rate, order, first = loop.rate_limit, loop.order, loop.servo == 1
    then = regime._replace(rate=0.0 if regime.rate else sign)
    if not regime.rate and not first:
        return End(lambda t, x: sign * x[order + 1] - max_rate, max_rate, then)

    def pull(t: Any, states: FloatArray) -> Any:
        """Return s' [rad/s] (first order) or s'' [rad/s^2] at a time `t` [s], times `sign`."""
        measured = loop.measured(t, states, regime)
        return sign * loop.pull(states, loop.command(states, measured, regime))

    if not regime.rate:
        return End(lambda t, x: pull(t, x) - max_rate, max_rate, then)
    if first:
        return End(lambda t, x: max_rate - pull(t, x), max_rate, then)
    # Scale of s'': that of an undamped oscillation w [rad/s] with the limit as its amplitude.
    size = loop.limit * float(np.asarray(loop.actuator.natural_frequency)) ** 2  # type: ignore[union-attr]
    return End(lambda t, x: -pull(t, x), size, then)


def _stop_end(loop: Loop, regime: Regime, sign: float) -> End:
    """Return the event at which the deflection leaves its limit, or if free, reaches it.

    `loop`: gives the limit [rad], and the deflection as the state after the `order` states of the
    vehicle. `regime`: active limits; `stop` is not zero where the deflection is at its limit.
    `sign`: sign of the deflection. The limit is also the scale, `size`, of the event function.
    """
    limit, order = loop.limit, loop.order
    if regime.stop:
        free = regime._replace(stop=0.0)
        return End(past=lambda t, x: limit - sign * x[order], size=limit, then=free)
    # a little beyond, as a deflection may come to rest at the limit without being stopped
    beyond, stopped = limit * (1.0 + _STOP_MARGIN), regime._replace(stop=sign)
    return End(past=lambda t, x: sign * x[order] - beyond, size=limit, then=stopped)


def _signs(active: float) -> tuple[float, ...]:
    """Return the signs of a limit that an event changes: that of the active limit, else both."""
    return (active,) if active else (1.0, -1.0)


def first_missed_end(result: Any, ends: list[End]) -> tuple[float, Regime] | None:
    """Return time [s] and next regime of the first end of a regime that the solver stepped over.

    Such an end lies within a solver step, with the same sign of its event function at both sides:
    the function has a local maximum between them, which is refined, and its first zero before it is
    the end. None without such an end. `result`: solution of `solve_ivp`. `ends`: events that can
    end the regime: `past`, positive after the end, its scale `size`, and the regime `then`.
    """
    from scipy.optimize import brentq, minimize_scalar

    offsets = np.diff(result.t)[:, np.newaxis] * np.arange(_TIMES_PER_STEP) / _TIMES_PER_STEP
    times = np.append((result.t[:-1, np.newaxis] + offsets).ravel(), result.t[-1])
    states = result.sol(times)
    missed: list[tuple[float, Regime]] = []
    for end in ends:

        def distance(t: Any, end: End = end) -> Any:
            """Return the distance to the end of the regime at times `t` [s], negative beyond it."""
            return -end.past(t, result.sol(t))

        values = -end.past(times, states)
        minimum = (values[1:-1] <= values[:-2]) & (values[1:-1] <= values[2:])
        close = values[1:-1] < _MAX_DISTANCE_OVER_SIZE * end.size
        for k in 1 + np.flatnonzero(minimum & close):
            bracket = (times[k - 1], times[k + 1])
            lowest = minimize_scalar(distance, bounds=bracket, options={"xatol": 1e-9})
            before = np.flatnonzero(values[:k] > 0.0)
            if lowest.fun < 0.0 and before.size:
                time = float(brentq(distance, times[before[-1]], lowest.x, xtol=1e-13))
                missed.append((time, end.then))
                break
    return min(missed, key=lambda event: event[0], default=None)


_RTOL, _ATOL = 1e-9, 1e-12
"""Relative tolerance of a solver step, and its absolute tolerance over the peak of the wind."""
_ACTUATOR_FACTOR = 0.01
"""Factor on both tolerances with an actuator: between its switches steps are long."""
_MAX_STEP_TIMES_POLE = 5.0
"""Longest solver step, times the fastest pole: DOP853 is stable there, and its dense output has at
most 12 times the controlled error; at 16 it has 400 times."""
_MAX_SWITCHES = 5000
"""Largest number of switches of the law and its nozzle in one flight."""
_MAX_EVALUATIONS = 500_000
"""Largest number of evaluations of the equations in one flight: hours with an actuator of 4 Hz.
Long after t = 0 the rounding of the time alone shortens the steps so much."""
_END_MARGIN = 1e-6
"""Distance beyond the largest attitude, and state, at which a flight ends, over that limit: the end
found by the solver must not be on the near side of the limit."""


@dataclass(frozen=True, eq=False)
class Arc:
    """Interval of a flight without a switch: its start [s], its solution, and the law's mode."""

    start: float
    solution: Callable[[FloatArray], FloatArray]
    mode: float


@dataclass(frozen=True, eq=False)
class ContinuousFlight:
    """Flight of one loop in one wind, up to the attitude `max_attitude` from the nominal [rad]."""

    loop: Loop
    wind: History
    max_attitude: float = LOST

    def arcs(self, start: float, stop: float) -> list[Arc]:
        """Return the arcs of the flight from equilibrium at `start` to just beyond `stop` [s].

        An arc is the solution between two events: breakpoints of the wind, and changes of the
        active limits (the regime). They end early where the attitude reaches `max_attitude`.
        `InputError` for too many switches of the law, and for a flight that cannot be integrated.
        """
        stop = max(float(np.nextafter(stop, np.inf)), start + 1e-9)
        knots = self.wind.knots
        edges = np.unique([start, *knots[(knots > start) & (knots < stop)], stop])
        state, regime, evaluations = np.zeros(self.loop.size), Regime(), count(1)
        # without an actuator the measured deflection is NaN, and so is a demand that depends on it
        if np.isnan(self.loop.demand(state, self.loop.measured(start, state))):
            raise InputError(
                "a law that looks at the deflection needs an actuator or a sample_rate"
            )
        arcs: list[Arc] = []
        for first, end in pairwise(edges):
            now = float(first)
            loop = replace(self.loop, gust=smooth_piece(self.wind, now))
            rates = _with_evaluation_limit(loop.rates, evaluations)
            regime = regime._replace(mode=mode_at(loop, now, state, regime.mode))
            regime = regime_after_jump(loop, now, state, regime)
            while now < end:
                if len(arcs) > _MAX_SWITCHES:
                    raise InputError(
                        f"the law or its nozzle switches more than {_MAX_SWITCHES} times; give a"
                        " sample_rate to fly it"
                    )
                ends = ends_of(loop, regime)
                result = self._solved(rates, (now, float(end)), state, regime, ends)
                arcs.append(Arc(now, result.sol, regime.mode))
                before = regime
                between = first_missed_end(result, ends)
                if between is not None:  # an end within a solver step, at which the arc ends
                    now, regime = between
                    state = result.sol(now)
                else:
                    now, state = float(result.t[-1]), result.y[:, -1]
                    if abs(state[0]) >= self.max_attitude:
                        return arcs
                    if result.status == 1:  # an event ended the regime
                        regime = next(
                            end.then
                            for end, times in zip(ends, result.t_events, strict=False)
                            if times.size
                        )
                if regime.mode != before.mode:  # the command jumps
                    regime = regime_after_jump(loop, now, state, regime)
                if regime.rate and loop.servo > 1:  # the deflection rate, a state, at its limit
                    state = state.copy()
                    state[loop.order + 1] = regime.rate * loop.rate_limit
        return arcs

    def _solved(
        self,
        rates: Callable[..., FloatArray],
        span: tuple[float, float],
        state: FloatArray,
        regime: Regime,
        ends: list[End],
    ) -> Any:
        """Return the result of `solve_ivp` from a state to the first event or the end of a span.

        `rates`: derivatives of the states. `span`: start and end [s]. `state`: all states of the
        loop. `regime`: active limits. `ends`: events that can end the regime. `InputError` where
        the solver fails, and for states without bounds.
        """
        from scipy.integrate import solve_ivp

        loop = self.loop
        # of the states of the vehicle times the magnitude that corresponds to an angle of one
        tolerance = np.full(loop.size, _ATOL * abs(float(self.wind.peak)))
        tolerance[: loop.order] *= loop.equations.scales
        factor = 1.0 if loop.actuator is None else _ACTUATOR_FACTOR
        result = solve_ivp(
            rates,
            span,
            state,
            method="DOP853",
            rtol=factor * _RTOL,
            atol=factor * tolerance,
            max_step=_MAX_STEP_TIMES_POLE / loop.fastest if loop.fastest else np.inf,
            dense_output=True,
            events=[*(_event(end) for end in ends), _flight_end(self.max_attitude)],
            args=(regime,),
        )
        time = float(result.t[-1])
        if result.status < 0:
            raise InputError(f"the solver fails at t = {time:.6g} s; give a sample_rate to fly it")
        check_not_lost(time, result.y[:, -1])
        return result

    def rows(self, arcs: list[Arc], times: FloatArray) -> FloatArray:
        """Return n plant states and deflection [rad] at times [s] ``(m,)``, shape ``(n + 1, m)``.

        `arcs`: solutions between events, which cover the times. All is zero before the first.
        """
        starts = np.array([arc.start for arc in arcs])
        index = np.searchsorted(starts, times, side="right") - 1
        # the whole wind: solutions between events have one smooth piece of it each
        loop, order = replace(self.loop, gust=self.wind), self.loop.order
        rows = np.zeros((order + 1, times.size))
        for k in np.unique(index[index >= 0]):
            inside = index == k
            states = arcs[k].solution(times[inside])
            measured = loop.measured(times[inside], states)
            rows[:order, inside] = states[:order]
            rows[-1, inside] = loop.deflection(states, measured, arcs[k].mode)
        return rows


def _with_evaluation_limit(
    rates: Callable[..., FloatArray], evaluations: Iterator[int]
) -> Callable[..., FloatArray]:
    """Return derivatives of states as a function that raises `InputError` after too many calls.

    `rates`: the derivatives, a function of the time [s], the states and more. `evaluations`:
    counter of all calls in a flight.
    """

    def counted(t: float, *state: Any) -> FloatArray:
        """Return the derivatives `rates` of the states at a time `t` [s].

        `InputError` beyond the largest number of `evaluations`, which all arcs count together.
        """
        if next(evaluations) > _MAX_EVALUATIONS:
            raise InputError(
                f"the flight takes more than {_MAX_EVALUATIONS} evaluations of its equations, at"
                f" t = {t:.6g} s; let it begin near t = 0, or give a sample_rate to fly it"
            )
        return rates(t, *state)

    return counted


def _event(end: End) -> Any:
    """Return the event function for `solve_ivp` of an end, which rises through zero there."""

    def past(t: float, states: FloatArray, regime: Regime) -> float:
        """Return by how much the states are past the end; negative before it.

        `regime` is not used: `solve_ivp` calls events with the arguments of the equations.
        """
        return float(end.past(t, states))

    past.terminal = True  # type: ignore[attr-defined]
    past.direction = 1.0  # type: ignore[attr-defined]
    return past


def _flight_end(max_attitude: float) -> Any:
    """Return the event function of a flight's end: states or attitude [rad] are too large."""
    beyond = 1.0 + _END_MARGIN  # the flight goes a little beyond its limits

    def remaining(t: float, states: FloatArray, regime: Regime) -> float:
        """Return the smaller distance of states and attitude to their limits; negative beyond.

        Both limits are widened by the factor `beyond`. `LOST` limits the states, in any unit, to a
        size that no vehicle reaches: in a valid flight the attitude [rad] decides. `t` and `regime`
        are not used: `solve_ivp` passes them.
        """
        to_loss = LOST * beyond - float(np.abs(states).max())
        return min(to_loss, max_attitude * beyond - abs(float(states[0])))

    remaining.terminal = True  # type: ignore[attr-defined]
    return remaining


def smooth_piece(history: History, start: float) -> Callable[[Any], Any]:
    """Return the piece of a history after a time [s] as a function, smooth beyond the piece's end.

    A piece is a sum over the `rates` r [1/s] of a polynomial in u times e^(r u), u [s] being the
    time since its breakpoint; a plain polynomial has r = 0. The function is zero before the first
    piece. `start`: the time, such as a breakpoint. The solver does not see the next jump in it, and
    it takes half the time of ``history(t)``.
    """
    pieces = history.pieces
    k = int(np.searchsorted(pieces.knots, start, side="right")) - 1
    if k < 0:
        return np.zeros_like
    knot = float(pieces.knots[k])
    coefficients, rates = pieces.coefficients[k, :, ::-1].tolist(), pieces.rates.tolist()

    def value(t: Any) -> Any:
        """Return the sum of polynomial(t - knot) e^(rate (t - knot)) at times [s], over `rates`."""
        u, total = t - knot, 0.0
        for polynomial, rate in zip(coefficients, rates, strict=True):
            term = 0.0 * u
            for coefficient in polynomial:  # Horner's rule, highest power first
                term = term * u + coefficient
            total = total + (term * np.exp(rate * u) if rate else term)
        return np.real(total)

    return value
