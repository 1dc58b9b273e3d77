"""The equations of what flies, for a flight of a continuous law."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.linear.plant import Plant


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


@dataclass(frozen=True, eq=False)
class LinearEquations:
    """Those of a plant."""

    plant: Plant

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return self.plant.states

    @property
    def scales(self) -> FloatArray:
        """All are angles, or angles in a second."""
        return np.ones(len(self.states))

    def rates(self, t: float, x: FloatArray, deflection: float, gust: float) -> FloatArray:
        """Return A x + B u."""
        del t
        A, B = self._matrices
        return A @ x + B[:, 0] * deflection + B[:, 1] * gust

    def angle_of_attack(self, t: Any, x: FloatArray, gust: Any) -> Any:
        """Return theta - gamma - alpha_w."""
        del t
        return x[0] - gust if len(x) < 3 else x[0] - x[2] - gust

    @cached_property
    def _matrices(self) -> tuple[FloatArray, FloatArray]:
        return self.plant.matrices()[:2]
