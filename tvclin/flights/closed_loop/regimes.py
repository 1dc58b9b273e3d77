"""The closed loop of a flight while nothing switches: smooth equations of vehicle, nozzle and law.

The states are those of the vehicle x, of the nozzle s and of the law m:

    x' = f(t, x, delta, w),    m' = F m + G [measured, delta],    delta = s, or the command c

and the nozzle follows its command c by s' = omega (c - s), or s'' = omega^2 (c - s) - 2 zeta omega
s'. The command is what the law asks for, or while it is switched a limit; while its rate or its
stop holds the nozzle, s' = +/- rate limit or s = +/- limit in its place.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from typing import Any, NamedTuple, Protocol

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law, Measurement


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
