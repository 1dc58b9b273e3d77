"""Flights of a law that is computed at a sample rate: many deflection limits at once.

Between samples everything is linear and stepped exactly, the wind with all its knots; the law
sees the state at each sample. So a late gust is never missed and nothing depends on a solver.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tvclin.closed_loop.airframe import Nozzle, Steps
from tvclin.kernels.propagation import driven, exponentials
from tvclin.laws import Law, Seen

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Flights:
    """The states of several flights at one sample.

    Attributes
    ----------
    airframe : ndarray
        States of the plant, ``(n, flights)``.
    servo : ndarray
        States of the nozzle, ``(order, flights)``.
    memory : ndarray
        States of the law, ``(k, flights)``.
    mode : ndarray
        +1 or -1 while the whole limit is commanded, else 0, ``(flights,)``.
    limit : ndarray
        Deflection limits [rad], ``(flights,)``.
    """

    airframe: FloatArray
    servo: FloatArray
    memory: FloatArray
    mode: FloatArray
    limit: FloatArray

    def take(self, index: NDArray[np.bool_]) -> Flights:
        """Return some of the flights."""
        return Flights(
            self.airframe[:, index],
            self.servo[:, index],
            self.memory[:, index],
            self.mode[index],
            self.limit[index],
        )


def at_rest(law: Law, steps: Steps, nozzle: Nozzle, limit: FloatArray) -> Flights:
    """Return flights that begin at rest."""
    size = limit.size
    return Flights(
        np.zeros((steps.first.size, size)),
        np.zeros((nozzle.order, size)),
        np.zeros((len(law.states[0]), size)),
        np.zeros(size),
        limit,
    )


@dataclass(frozen=True, eq=False)
class Sampler:
    """A law, a nozzle and the steps of a plant in a wind.

    Attributes
    ----------
    law : Law
        The law.
    steps : Steps
        The plant in its wind.
    nozzle : Nozzle
        The nozzle, of the same step length.
    still : bool
        Whether this is the still air after the wind, which has noise of its own.
    """

    law: Law
    steps: Steps
    nozzle: Nozzle
    still: bool = False

    def each(self, flights: Flights, first: int, last: int) -> Iterator[Flights]:
        """Yield the flights after each of the steps from `first` up to `last`."""
        for k in range(first, last):
            flights = self._advanced(flights, k)
            yield flights

    def flown(self, flights: Flights, first: int, last: int) -> Flights:
        """Return the flights after the step before `last`."""
        for k in range(first, last):
            flights = self._advanced(flights, k)
        return flights

    @cached_property
    def _noise(self) -> FloatArray:
        level, seed = self.law.rate_noise
        count = self.steps.wind.size
        rng = np.random.default_rng([seed, int(self.still)])
        return rng.normal(0.0, level, count) if level else np.zeros(count)

    def seen(self, flights: Flights, k: int, noise: float = 0.0) -> Seen:
        """Return what the law is shown at a sample."""
        x = flights.airframe
        path = x[2] if len(x) > 2 else np.zeros_like(x[0])
        angle = x[0] - path - self.steps.wind[k]
        deflection = np.clip(flights.servo[0], -flights.limit, flights.limit)
        return Seen(x[0], x[1] + noise, path, angle, deflection)

    def _advanced(self, flights: Flights, k: int) -> Flights:
        law, limit = self.law, flights.limit
        memory, servo = self._memory_step, self._servo_step
        seen = self.seen(flights, k, float(self._noise[k]))
        demand = self._demand(seen, flights)
        mode = switched(law, demand, flights.mode, limit)
        command = np.where(mode != 0.0, mode * limit, np.clip(demand, -limit, limit))
        before = flights.servo
        moved = servo[0] @ before + servo[1][:, np.newaxis] * command
        if self.nozzle.rate_limit < np.inf:
            reach = self.nozzle.rate_limit * self.nozzle.length
            moved[0] = before[0] + np.clip(moved[0] - before[0], -reach, reach)
            moved[1:] = np.clip(moved[1:], -self.nozzle.rate_limit, self.nozzle.rate_limit)
        last = np.clip(moved[0], -limit, limit)
        first = last if self.nozzle.jumps else seen.deflection
        s = self.steps
        x = s.free @ flights.airframe + s.first[:, np.newaxis] * first
        x += s.last[:, np.newaxis] * last + s.gusts[k][:, np.newaxis]
        kept = flights.memory
        if len(kept):
            shown = np.stack(np.broadcast_arrays(*seen))
            kept = memory[0] @ kept + memory[1] @ shown
        return Flights(x, moved, kept, mode, limit)

    def _demand(self, seen: Seen, flights: Flights) -> FloatArray:
        """What the law asks for; one flight is told in plain numbers, which take half the time."""
        if flights.limit.size > 1:
            return self.law.demand(seen, flights.memory, flights.limit)
        plain = Seen(*(float(value[0]) for value in seen))
        asked = self.law.demand(plain, flights.memory[:, 0], float(flights.limit[0]))
        return np.atleast_1d(np.asarray(asked, dtype=float))

    @cached_property
    def _servo_step(self) -> tuple[FloatArray, FloatArray]:
        return self.nozzle.matrices()

    @cached_property
    def _memory_step(self) -> tuple[FloatArray, FloatArray]:
        F, G = self.law.states
        size = len(F)
        whole = exponentials(driven(F, G), np.array([self.nozzle.length]))[0]
        return whole[:size, :size], whole[:size, size:]


def switched(law: Law, demand: FloatArray, mode: FloatArray, limit: FloatArray) -> FloatArray:
    """Return the mode that follows: engaged at the limit, or let go."""
    held = np.where(demand * mode > law.release * limit, mode, 0.0)
    beyond = np.abs(demand) >= law.engage * limit
    return np.where((held == 0.0) & beyond, np.sign(demand), held)
