"""A batch of rational functions, each with a delay, on the imaginary axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray
from tvclin.numerics import polynomials

_ROUNDING = 1e-13
"""A value below this part of the sum of its terms is their rounding: a zero on the axis."""
_FARTHEST = 1e30
"""A frequency at which L is real is not beyond this [rad/s]."""


@dataclass(frozen=True, eq=False)
class Rational:
    """The functions L(s) = numerator(s)/denominator(s) e^(-s delay).

    `numerator`, `denominator`: coefficients, highest power first, both ``(..., n + 1)``. `delay`:
    delay [s], ``(...)``.
    """

    numerator: FloatArray
    denominator: FloatArray
    delay: FloatArray

    @property
    def direct(self) -> FloatArray:
        """The value at infinity, ``(...)``."""
        return np.asarray(self.numerator[..., 0] / self.denominator[..., 0])

    def parts(self, omega: ArrayLike) -> tuple[AnyArray, AnyArray]:
        """Return numerator, with the delay, and denominator at j omega, ``(..., k)``.

        `omega`: frequencies [rad/s], ``(..., k)``.
        """
        omega = np.asarray(omega, dtype=float)
        above = polynomials.on_axis(self.numerator, omega)
        if np.any(self.delay):
            above = product(above, np.exp(-1j * omega * self.delay[..., np.newaxis]))
        return above, polynomials.on_axis(self.denominator, omega)

    def value(self, s: AnyArray) -> AnyArray:
        """Return L with its delay at complex frequencies ``(..., k)`` [1/s], off the poles."""
        above, below = (polynomials.value(p, s) for p in (self.numerator, self.denominator))
        return np.asarray(above / below * np.exp(-s * self.delay[..., np.newaxis]))

    def undelayed(self, omega: FloatArray) -> tuple[AnyArray, AnyArray]:
        """Return numerator and denominator at j omega, ``(..., k)``, without the delay."""
        return (
            polynomials.on_axis(self.numerator, omega),
            polynomials.on_axis(self.denominator, omega),
        )

    def log_slope(self, omega: FloatArray) -> AnyArray:
        """Return d ln G/d omega = j (N'/N - D'/D) at j omega, without the delay, ``(..., k)``."""
        slopes = [polynomials.derivative(p) for p in (self.numerator, self.denominator)]
        rises = [polynomials.on_axis(slope, omega) for slope in slopes]
        above, below = map(product, rises, map(inverse, self.undelayed(omega)))
        return 1j * (above - below)

    def open_poles(self) -> AnyArray:
        """Return the roots of the denominator."""
        return polynomials.roots(self.denominator)

    def closed_poles(self) -> AnyArray:
        """Return the roots of D + N, the closed-loop poles without the delay."""
        return polynomials.roots(self.denominator + self.numerator)

    def zeros(self) -> AnyArray:
        """Return the roots of numerators ``(k, n + 1)``; NaN fills the rows."""
        return polynomials.roots_of_each(self.numerator)

    def crossovers(self, size: float) -> tuple[FloatArray, BoolArray]:
        """Return where |L| is `size` [rad/s], and whether |L| falls with the frequency there.

        They are roots of |D|^2 size^2 - |N|^2 in omega^2; rising, NaN fills the rows.
        """
        squares = polynomials.squared_size(self.denominator)
        squares = size**2 * squares - polynomials.squared_size(self.numerator)
        roots = polynomials.roots(squares)
        real = (np.imag(roots) == 0.0) & (np.real(roots) > 0.0)
        frequencies = np.sort(np.sqrt(np.where(real, np.real(roots), np.nan)), axis=-1)
        with np.errstate(invalid="ignore"):
            slope = polynomials.value(polynomials.derivative(squares), frequencies**2)
        return frequencies, np.asarray(slope > 0.0)

    def real_frequencies(self) -> FloatArray:
        """Return where L, but for its delay, is real [rad/s], of ``(k,)`` loops."""
        polynomial = polynomials.imaginary_part(self.numerator, self.denominator)
        with np.errstate(all="ignore"):
            roots = polynomials.roots_of_each(polynomial)
            real = (np.imag(roots) == 0.0) & (np.real(roots) > 0.0) & (np.real(roots) < _FARTHEST)
        return np.sqrt(np.where(real, np.real(roots), np.nan))

    def bound(self) -> FloatArray:
        """Return a number that no pole exceeds in size [rad/s], ``(...)``."""
        return polynomials.bound(self.denominator)

    def vanishes(self, omega: FloatArray) -> BoolArray:
        """Return whether numerator or denominator is zero, to rounding, at one frequency each.

        `omega`: frequencies [rad/s], of the shape of the batch.
        """
        omega, parts = omega[..., np.newaxis], []
        for polynomial in (self.numerator, self.denominator):
            size = polynomials.value(np.abs(polynomial), np.abs(omega))
            parts.append(np.abs(polynomials.on_axis(polynomial, omega)) <= _ROUNDING * size)
        return np.asarray(parts[0] | parts[1])[..., 0]

    def take(self, index: Any) -> Self:
        """Return the functions at the positions `index` of the flattened batch."""
        size = self.numerator.shape[-1]
        above, below = (p.reshape(-1, size)[index] for p in (self.numerator, self.denominator))
        return type(self)(above, below, self.delay.reshape(-1)[index])


def product(first: AnyArray, second: AnyArray) -> AnyArray:
    """Return the product of complex numbers in real ones: numpy's own rounds by place in memory."""
    found = np.empty(np.broadcast_shapes(first.shape, second.shape), dtype=complex)
    found.real = first.real * second.real - first.imag * second.imag
    found.imag = first.real * second.imag + first.imag * second.real
    return found


def inverse(values: AnyArray) -> AnyArray:
    """Return the inverses of complex numbers in real ones, as `product`, of any size."""
    scale = np.maximum(np.abs(values.real), np.abs(values.imag))
    real, imag = values.real / scale, values.imag / scale
    scale *= real**2 + imag**2
    found = np.empty(values.shape, dtype=complex)
    found.real, found.imag = real / scale, -imag / scale
    return found
