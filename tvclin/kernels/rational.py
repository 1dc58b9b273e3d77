"""A batch of rational functions, each with a delay, on the imaginary axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.kernels import polynomials

FloatArray = NDArray[np.float64]

_ROUNDING = 1e-13


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
        s = 1j * np.asarray(omega, dtype=float)
        late = np.exp(-s * self.delay[..., np.newaxis])
        above = polynomials.value(self.numerator, s) * late
        return above, polynomials.value(self.denominator, s)

    def vanishes(self, omega: FloatArray) -> NDArray[np.bool_]:
        """Return whether numerator or denominator is zero, to rounding, at one frequency each.

        Parameters
        ----------
        omega : ndarray
            Frequencies [rad/s], of the shape of the batch.
        """
        s = 1j * omega[..., np.newaxis]
        parts = []
        for polynomial in (self.numerator, self.denominator):
            size = polynomials.value(np.abs(polynomial), np.abs(s))
            parts.append(np.abs(polynomials.value(polynomial, s)) <= _ROUNDING * size)
        return np.asarray(parts[0] | parts[1])[..., 0]

    def take(self, index: Any) -> Self:
        """Return the functions at the positions `index` of the flattened batch."""
        size = self.numerator.shape[-1]
        above, below = (p.reshape(-1, size)[index] for p in (self.numerator, self.denominator))
        return type(self)(above, below, self.delay.reshape(-1)[index])
