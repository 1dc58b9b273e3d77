"""What is asked of a loop for its margins, however the loop is written down.

`Rational` answers from polynomials, `StateLoop` from the matrices of a state space. Both are
batches, and the engine of the margins (`stability`, `loop_grid`, `loop_margins`) asks nothing else.
"""

from __future__ import annotations

from typing import Any, Protocol, Self

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray


class AnyLoop(Protocol):
    """A batch ``(k,)`` of loops L(s) = G(s) e^(-s delay), closed by 1 + L = 0.

    Frequencies are in rad/s; NaN fills rows of roots and frequencies.
    """

    @property
    def delay(self) -> FloatArray:
        """Delay [s], ``(k,)``."""

    @property
    def direct(self) -> FloatArray:
        """G at infinity, ``(k,)``."""

    def take(self, index: Any) -> Self:
        """Return the loops at these positions."""

    def parts(self, omega: FloatArray) -> tuple[AnyArray, AnyArray]:
        """Return numerator, with the delay, and denominator at j omega, ``(k, m)``."""

    def value(self, s: AnyArray) -> AnyArray:
        """Return L at complex frequencies ``(k, m)`` [1/s], off the poles."""

    def undelayed(self, omega: FloatArray) -> tuple[AnyArray, AnyArray]:
        """Return numerator and denominator of G at j omega, ``(k, m)``, for a few frequencies."""

    def log_slope(self, omega: FloatArray) -> AnyArray:
        """Return d ln G/d omega at j omega, ``(k, m)``, for a few frequencies."""

    def vanishes(self, omega: FloatArray) -> BoolArray:
        """Return whether G is zero or infinite, to rounding, at one frequency each, ``(k,)``."""

    def open_poles(self) -> AnyArray:
        """Return the poles of G, ``(k, n)``."""

    def closed_poles(self) -> AnyArray:
        """Return the roots of 1 + G = 0, ``(k, n)``."""

    def zeros(self) -> AnyArray:
        """Return the zeros of G, ``(k, n)``."""

    def crossovers(self, size: float) -> tuple[FloatArray, BoolArray]:
        """Return where |G| is `size`, rising, and whether |G| falls there, ``(k, m)``."""

    def real_frequencies(self) -> FloatArray:
        """Return where G is real, ``(k, m)``."""

    def bound(self) -> FloatArray:
        """Return a number that no pole of G exceeds in size, ``(k,)``."""
