"""What turns the nozzle in a flight: a history, the report's control, or a law with limits.

The engine takes a second-order step of what acts at its samples, so each sample stands for the
step around it, and a deflection that jumps or bends inside that step is shown as its mean there.
"""

from collections.abc import Callable
from math import copysign

import numpy as np
from numpy.typing import NDArray

from tvclin.closed_loop.airframe import Nozzle
from tvclin.histories import History
from tvclin.kernels.propagation import exponentials
from tvclin.laws import Law, Seen

FloatArray = NDArray[np.float64]
Steering = Callable[[int, Seen], float]
"""Takes the number of a step and what is foreseen for its end; gives the deflection [rad]."""

_FINE = 128
"""Parts of the step in which the dead band is left."""
_ONSET = 1e-9
"""Part of the limit at which a control with no dead band takes a wind to have begun."""


def step_means(history: History, times: FloatArray, step: float) -> FloatArray:
    """Return the mean of one history over the step around each of the even times, ``(n,)``."""
    edges = np.append(times, times[-1] + step) - 0.5 * step
    return np.diff(history.filter([1.0], [1.0, 0.0])(edges)) / step


def by_history(history: History, times: FloatArray, step: float, limit: float) -> Steering:
    """Return what follows a deflection history, up to the limit."""
    means = np.clip(step_means(history, times, step), -limit, limit).tolist()
    return lambda k, seen: means[k]


class TrimThenHold:
    """The report's control: trim until K times the limit is asked for, then the limit for ever.

    Parameters
    ----------
    B : float
        Trim deflection per angle of attack.
    limit : float
        Deflection limit [rad], positive.
    dead_band : float
        K.
    wind : History
        One wind.
    times : ndarray
        Times of the steps [s], even, ``(n,)``.
    step : float
        Step [s].
    """

    def __init__(
        self,
        B: float,
        limit: float,
        dead_band: float,
        wind: History,
        times: FloatArray,
        step: float,
    ) -> None:
        self._B, self._limit, self._level = B, limit, max(dead_band, _ONSET) * limit
        self._wind, self._times, self._step = wind, times, step
        self._means = step_means(wind, times, step).tolist()
        self._ends = wind(times + 0.5 * step).tolist()
        self._held: float | None = None

    def __call__(self, k: int, seen: Seen) -> float:
        """Return the deflection at a step."""
        if self._held is not None:
            return self._held
        still = seen.angle_of_attack + self._means[k]
        if abs(self._B * (still - self._ends[k])) < self._level:
            return self._B * seen.angle_of_attack
        return self._leaving(k, still)

    def _leaving(self, k: int, still: float) -> float:
        """Find where in this step the dead band is left; `still` is alpha without the wind."""
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


class ByLaw:
    """A law with its limits, asked at every step; an actuator follows within the steps.

    Parameters
    ----------
    law : Law
        The law.
    nozzle : Nozzle
        Actuator and rate limit; its length is the step.
    limit : float
        Deflection limit [rad], positive.
    count : int
        Number of steps.
    """

    def __init__(self, law: Law, nozzle: Nozzle, limit: float, count: int) -> None:
        self._law, self._nozzle, self._limit = law, nozzle, limit
        self._servo, self._moves = np.zeros(nozzle.order), nozzle.matrices()
        self._memory = np.zeros(len(law.states[0]))
        self._memory_moves = _memory_step(law, nozzle.length)
        level, seed = law.rate_noise
        noise = np.random.default_rng([seed, 0]).normal(0.0, level, count)
        self._noise = noise.tolist() if level else None
        self._mode = self._command = 0.0

    def __call__(self, k: int, seen: Seen) -> float:
        """Return the deflection at a step."""
        if self._noise is not None:
            seen = seen._replace(attitude_rate=seen.attitude_rate + self._noise[k])
        if self._nozzle.jumps:
            return self._asked(seen)
        deflection = self._followed()
        self._command = self._asked(seen._replace(deflection=deflection))
        return deflection

    def _asked(self, seen: Seen) -> float:
        """Return the command within the limit, and move on what the law remembers."""
        law, limit = self._law, self._limit
        demand = float(law.demand(seen, self._memory, limit))
        if demand * self._mode <= law.release * limit:
            self._mode = 0.0
        if self._mode == 0.0 and abs(demand) >= law.engage * limit:
            self._mode = copysign(1.0, demand)
        if self._memory.size:
            self._memory = self._memory_moves[0] @ self._memory + self._memory_moves[1] @ seen
        return self._mode * limit if self._mode else min(max(demand, -limit), limit)

    def _followed(self) -> float:
        """Return where the nozzle is one step later."""
        most, before = self._nozzle.rate_limit, self._servo
        moved = self._moves[0] @ before + self._moves[1] * self._command
        if most < np.inf:
            reach = most * self._nozzle.length
            moved[0] = before[0] + np.clip(moved[0] - before[0], -reach, reach)
            moved[1:] = np.clip(moved[1:], -most, most)
        self._servo = moved
        return min(max(float(moved[0]), -self._limit), self._limit)


def _memory_step(law: Law, step: float) -> tuple[FloatArray, FloatArray]:
    """Return what takes the states of a law, and what it sees, to its states one step later."""
    F, G = law.states
    size = len(F)
    driven = np.zeros((size + G.shape[1],) * 2)
    driven[:size, :size], driven[:size, size:] = F, G
    whole = exponentials(driven, np.array([step]))[0]
    return whole[:size, :size], whole[:size, size:]
