"""What turns the nozzle in a flight: a history, the report's control, or a law with limits.

The engine takes a second-order step of what acts at its samples, so each sample stands for the
step around it, and a deflection that jumps or bends inside that step is shown as its mean there.
"""

from __future__ import annotations

from collections.abc import Callable
from math import copysign

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.control.autopilot.actuator import actuator_system
from tvclin.control.laws.law import Law, Measurement
from tvclin.control.laws.trim import TrimLaw
from tvclin.flights.nozzle_command import ONSET_OVER_LIMIT, Command
from tvclin.winds.histories import History

Steering = Callable[[int, Measurement], float]
"""Takes the number of a step and what is foreseen for its end; gives the deflection [rad]."""

_NOTHING = np.zeros(0)
_FINE = 128
"""Parts of the step in which the dead band is left."""


def step_means(history: History, times: FloatArray, step: float) -> FloatArray:
    """Return the mean of one history over the step around each of the even times, ``(n,)``."""
    edges = np.append(times, times[-1] + step) - 0.5 * step
    return np.diff(history.filter([1.0], [1.0, 0.0])(edges)) / step


def by_history(history: History, times: FloatArray, step: float, limit: float) -> Steering:
    """Return what follows a deflection history, up to the limit."""
    means = np.clip(step_means(history, times, step), -limit, limit).tolist()
    return lambda k, measured: means[k]


class TrimThenHold:
    """The report's control: trim until K times the limit is asked for, then the limit for ever.

    Without a dead band the wind alone says when.

    `trim`: trim, and the feedback that holds what it leaves. `limit`: deflection limit [rad],
    positive. `dead_band`: K. `wind`: one wind. `times`: times of the steps [s], even, ``(n,)``.
    `step`: step [s].
    """

    def __init__(
        self,
        trim: TrimLaw,
        limit: float,
        dead_band: float,
        wind: History,
        times: FloatArray,
        step: float,
    ) -> None:
        self._trim, self._B = trim, float(trim.plant.coefficients.B)
        self._limit, self._level = limit, max(dead_band, ONSET_OVER_LIMIT) * limit
        self._at_onset = dead_band == 0.0
        self._wind, self._times, self._step = wind, times, step
        self._means = step_means(wind, times, step).tolist()
        self._ends = wind(times + 0.5 * step).tolist()
        self._held: float | None = None

    def __call__(self, k: int, measured: Measurement) -> float:
        """Return the deflection at a step."""
        if self._held is not None:
            return self._held
        asked = float(self._trim.demand(measured, _NOTHING, self._limit))
        still = 0.0 if self._at_onset else asked / self._B + self._means[k]
        if abs(self._B * (still - self._ends[k])) < self._level:
            return asked
        return self._leaving(k, still)

    def _leaving(self, k: int, still: float) -> float:
        """Find where in this step the dead band is left; `still` is asked for without the wind."""
        part = np.linspace(-0.5, 0.5, _FINE + 1)
        trim = self._B * (still - self._wind(self._times[k] + part * self._step))
        i = int(np.argmax(np.abs(trim) >= self._level))
        side = copysign(1.0, trim[i])
        self._held = side * self._limit
        leaves = part[0]
        if i > 0:
            leaves = np.interp(self._level, side * trim[i - 1 : i + 1], part[i - 1 : i + 1])
        before = np.append(trim[:i], side * self._level), np.append(part[:i], leaves)
        return float(np.trapezoid(*before) + self._held * (0.5 - leaves))


def by_law(command: Command, limit: float, step: float, count: int) -> Steering:
    """Return what asks a law at every step, within its limits; an actuator follows in the steps.

    `command`: the law, its actuator and the rate limit of its servo; the stop stands outside it.
    `limit`, `step`, `count`: deflection limit [rad], length [s] and number of the steps.
    """
    assert isinstance(command.control, Law)
    asked, most = _command(command.control, limit, step, count), command.rate_limit
    free, pulled = np.zeros((1, 1)), np.ones(1)
    if command.actuator is not None:
        moving = actuator_system(command.actuator).to_steps(step)
        free, pulled = moving.A, moving.B[:, 0]
    elif most == np.inf:
        return asked
    reach, servo, told = most * step, np.zeros(pulled.size), 0.0

    def followed(k: int, measured: Measurement) -> float:
        nonlocal servo, told
        moved = free @ servo + pulled * told
        if most < np.inf:
            moved[0] = servo[0] + np.clip(moved[0] - servo[0], -reach, reach)
            moved[1:] = np.clip(moved[1:], -most, most)
        servo, deflection = moved, min(max(float(moved[0]), -limit), limit)
        told = asked(k, measured._replace(deflection=deflection))
        return deflection

    return followed


def _command(law: Law, limit: float, step: float, count: int) -> Steering:
    """Return what gives the command within the limit, and remembers what the law remembers."""
    demanded, engage, release = law.demand, law.engage * limit, law.release * limit
    memory = np.zeros(len(law.states[0]))
    learning = law.state_space.to_steps(step)
    level, seed = law.rate_noise
    noise = np.random.default_rng([seed, 0]).normal(0.0, level, count).tolist() if level else None
    mode = 0.0

    def asked(k: int, measured: Measurement) -> float:
        nonlocal memory, mode
        if noise is not None:
            measured = measured._replace(attitude_rate=measured.attitude_rate + noise[k])
        demand = float(demanded(measured, memory, limit))
        if mode and demand * mode <= release:
            mode = 0.0
        if not mode and abs(demand) >= engage:
            mode = copysign(1.0, demand)
        if memory.size:
            memory = learning.A @ memory + learning.B @ measured
        return mode * limit if mode else min(max(demand, -limit), limit)

    return asked
