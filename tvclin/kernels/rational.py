"""A batch of rational functions, each with a delay, on the imaginary axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.kernels import polynomials

FloatArray = NDArray[np.float64]

_ROUNDING = 1e-13
"""A value below this part of the sum of its terms is their rounding: a zero on the axis."""


@dataclass(frozen=True, eq=False)
class Rational:
    """The functions L(s) = numerator(s)/denominator(s) e^(-s delay).

    Attributes
    ----------
    numerator, denominator : ndarray
        Coefficients, highest power first, both ``(..., n + 1)``.
    delay : ndarray
        Delay [s], ``(...)``.
    """

    numerator: FloatArray
    denominator: FloatArray
    delay: FloatArray

    def parts(self, omega: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return numerator, with the delay, and denominator at j omega, ``(..., k)``.

        Parameters
        ----------
        omega : array_like
            Frequencies [rad/s], ``(..., k)``.
        """
        omega = np.asarray(omega, dtype=float)
        above = polynomials.on_axis(self.numerator, omega)
        if np.any(self.delay):
            above = product(above, np.exp(-1j * omega * self.delay[..., np.newaxis]))
        return above, polynomials.on_axis(self.denominator, omega)

    def vanishes(self, omega: FloatArray) -> NDArray[np.bool_]:
        """Return whether numerator or denominator is zero, to rounding, at one frequency each.

        Parameters
        ----------
        omega : ndarray
            Frequencies [rad/s], of the shape of the batch.
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


def product(first: NDArray[Any], second: NDArray[Any]) -> NDArray[Any]:
    """Return the product of complex numbers in real ones: numpy's own rounds by place in memory."""
    found = np.empty(np.broadcast_shapes(first.shape, second.shape), dtype=complex)
    found.real = first.real * second.real - first.imag * second.imag
    found.imag = first.real * second.imag + first.imag * second.real
    return found


def inverse(values: NDArray[Any]) -> NDArray[Any]:
    """Return the inverses of complex numbers in real ones, as `product`, of any size."""
    scale = np.maximum(np.abs(values.real), np.abs(values.imag))
    real, imag = values.real / scale, values.imag / scale
    scale *= real**2 + imag**2
    found = np.empty(values.shape, dtype=complex)
    found.real, found.imag = real / scale, -imag / scale
    return found
