"""The nozzle in JSBSim's steps: how the deflection follows its command."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tvclin.control.autopilot.actuator import Actuator
from tvclin.kernels.propagation import driven, exponentials

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Nozzle:
    """How the deflection follows its command in steps of one length.

    A rate limit bounds the rate of the servo; the stop at the deflection limit stands outside it.
    """

    actuator: Actuator | None
    rate_limit: float
    length: float

    @property
    def order(self) -> int:
        """Number of states: the position [rad], and the rate [rad/s] of a second-order servo."""
        return 1 if self.actuator is None else self.actuator.denominator.size - 1

    @property
    def jumps(self) -> bool:
        """Whether the deflection is at its command at once."""
        return self.actuator is None and self.rate_limit == np.inf

    def matrices(self) -> tuple[FloatArray, FloatArray]:
        """Return what takes states and command to the states one step later."""
        if self.actuator is None:
            return np.zeros((1, 1)), np.ones(1)
        A, B, _, _ = self.actuator.matrices()
        whole = exponentials(driven(A, B), np.array([self.length]))[0]
        return whole[:-1, :-1], whole[:-1, -1]
