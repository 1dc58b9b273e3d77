"""Filters: rational transfer functions, for the lags of sensors and the shaping of commands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, ComplexArray, FloatArray
from tvclin.base.cards import Carded
from tvclin.base.errors import InputError, array_of, between, broadcast, finite, nonzero, within
from tvclin.base.lines import Line, significant
from tvclin.numerics import polynomials

LARGEST = 1e9
"""Of frequencies [rad/s] and damping ratios, and one over the smallest frequency."""
_LARGEST_COEFFICIENT = 1e60
_FASTEST = 1e20
_FURTHEST = 1e12
_MOST = 12
"""The highest order of one filter; to this power the fastest pole must not overflow."""

_sized = between(1.0 / LARGEST, LARGEST)
_damping = between(-LARGEST, LARGEST)


@dataclass(frozen=True, eq=False)
class Filter(Carded):
    """A filter, or a batch of them: numerator(s)/denominator(s).

    Most are made with `low_pass`, `lead_lag`, `notch` or `from_coefficients`. Zeros in the right
    half plane are legal; they shape the phase alone.

    Parameters
    ----------
    numerator, denominator : array_like
        Coefficients, highest power first, ``(..., m + 1)`` and ``(..., n + 1)`` with m <= n; the
        leading axes broadcast. They are kept divided by the first of the denominator.

    Raises
    ------
    InputError
        For a numerator of higher degree than the denominator, a denominator that begins with
        zero, an order above 12, poles that may lie beyond 1e20 rad/s, and numbers that are not
        finite.

    Examples
    --------
    >>> import tvclin as tv
    >>> notch = tv.vehicle.Filter.notch(32.0, 0.06, 0.6)
    >>> abs(notch([0.0, 32j])).round(6)
    array([1. , 0.1])
    """

    numerator: FloatArray
    denominator: FloatArray

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Filter) and self._bytes == other._bytes

    def __hash__(self) -> int:
        return hash(self._bytes)

    @property
    def _bytes(self) -> tuple[tuple[int, ...], bytes, tuple[int, ...], bytes]:
        above, below = self.numerator, self.denominator
        return above.shape, above.tobytes(), below.shape, below.tobytes()

    def __post_init__(self) -> None:
        above, below = finite("numerator", self.numerator), finite("denominator", self.denominator)
        for name, given in (("numerator", above), ("denominator", below)):
            if not given.ndim or not 0 < given.shape[-1] <= _MOST + 1:
                raise InputError(
                    f"{name} must be 1 to {_MOST + 1} coefficients, highest power first; got an"
                    f" array of shape {given.shape}"
                )
        shape = broadcast(numerator=above.shape[:-1], denominator=below.shape[:-1])
        lead = nonzero("the first coefficient of the denominator", below[..., :1])
        with np.errstate(over="ignore"):  # refused below
            above, below = above / lead, below / lead
        while above.shape[-1] > below.shape[-1] and not np.any(above[..., 0]):
            above = above[..., 1:]
        if above.shape[-1] > below.shape[-1]:
            raise InputError(
                "numerator must not be of higher degree than the denominator, for no filter"
                f" differentiates; got degrees {above.shape[-1] - 1} and {below.shape[-1] - 1}"
            )
        for name, given in (("numerator", above), ("denominator", below)):
            over = f"{name} over the first coefficient of the denominator"
            within(over, given, -_LARGEST_COEFFICIENT, _LARGEST_COEFFICIENT)
        within("a bound of the poles", polynomials.bound(below), 0.0, _FASTEST, "rad/s")
        for name, given in (("numerator", above), ("denominator", below)):
            held = np.array(np.broadcast_to(given, (*shape, given.shape[-1])))
            held.flags.writeable = False
            object.__setattr__(self, name, held)

    _keys = "numerator denominator"

    @classmethod
    def from_coefficients(cls, numerator: ArrayLike, denominator: ArrayLike) -> Self:
        """Return the filter of two polynomials, highest power first, as `Filter` itself."""
        return cls(numerator, denominator)  # type: ignore[arg-type]

    @classmethod
    def low_pass(cls, frequency: ArrayLike, damping: ArrayLike | None = None) -> Self:
        """Return w^2/(s^2 + 2 zeta w s + w^2), or w/(s + w) without a damping.

        Parameters
        ----------
        frequency : array_like
            w [rad/s], positive.
        damping : array_like, optional
            zeta, positive.
        """
        w = _sized("frequency", frequency, "rad/s")
        if damping is None:
            return cls(_rows(w), _rows(1.0, w))
        zeta = _sized("damping", damping)
        broadcast(frequency=w.shape, damping=zeta.shape)
        return cls(_rows(w**2), _rows(1.0, 2.0 * zeta * w, w**2))

    @classmethod
    def lead_lag(cls, zero: ArrayLike, pole: ArrayLike) -> Self:
        """Return (1 + s/zero)/(1 + s/pole), of unit steady gain.

        Parameters
        ----------
        zero : array_like
            Corner frequency of the numerator [rad/s], not zero. Above the pole it is a lag,
            below it a lead; negative is a zero in the right half plane.
        pole : array_like
            Corner frequency of the denominator [rad/s], positive.
        """
        z, p = nonzero("zero", zero, "rad/s"), _sized("pole", pole, "rad/s")
        _sized("zero", np.abs(z), "rad/s")
        broadcast(zero=z.shape, pole=p.shape)
        return cls(_rows(p / z, p), _rows(1.0, p))

    @classmethod
    def notch(cls, frequency: ArrayLike, zero_damping: ArrayLike, pole_damping: ArrayLike) -> Self:
        """Return (s^2 + 2 zeta_z w s + w^2)/(s^2 + 2 zeta_p w s + w^2).

        Parameters
        ----------
        frequency : array_like
            w [rad/s], positive. The gain there is zeta_z/zeta_p.
        zero_damping : array_like
            zeta_z; zero takes the frequency out wholly, and a negative one shapes the phase.
        pole_damping : array_like
            zeta_p, positive; the notch is about 2 zeta_p w wide.
        """
        w, poles = _sized("frequency", frequency, "rad/s"), _sized("pole_damping", pole_damping)
        zeros = _damping("zero_damping", zero_damping)
        broadcast(frequency=w.shape, zero_damping=zeros.shape, pole_damping=poles.shape)
        return cls(_rows(1.0, 2.0 * zeros * w, w**2), _rows(1.0, 2.0 * poles * w, w**2))

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for one filter."""
        return self.denominator.shape[:-1]

    @property
    def order(self) -> int:
        """How many poles the filter has."""
        return self.denominator.shape[-1] - 1

    def __call__(self, s: ArrayLike) -> ComplexArray:
        """Return the values at complex frequencies s [1/s], after the leading axes of the batch.

        Infinite at a pole.

        `InputError` for what is no number, and for numbers beyond 1e12 1/s.
        """
        at = array_of("s", s, "iufc", "a complex number in 1/s").astype(complex)
        for part in (at.real, at.imag):
            within("s", part, -_FURTHEST, _FURTHEST, "1/s")
        above, below = (
            polynomials.value(p, at.ravel()) for p in (self.numerator, self.denominator)
        )
        poles = below == 0.0
        values = np.where(poles, np.inf, above / np.where(poles, 1.0, below))
        return values.reshape((*self.batch, *at.shape))

    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return A, B, C, D with the leading axes of the batch, in controllable form.

        The states are scaled by a frequency above all poles, so that the entries of A are of its
        size.
        """
        n = self.order
        below = self.denominator
        above = polynomials.add(self.numerator, np.zeros(n + 1))
        unit = np.maximum(polynomials.bound(below), 1.0 / LARGEST)
        powers = unit[..., np.newaxis] ** np.arange(n + 1)
        below, above = below / powers, above / powers
        # (b_0 s^n + .. + b_n)/(s^n + a_1 s^(n-1) + .. + a_n): D = b_0, C = b_k - a_k b_0.
        A = np.zeros((*self.batch, n, n)) + np.eye(n, k=1)
        B = np.zeros((*self.batch, n, 1))
        if n:
            A[..., -1, :], B[..., -1, 0] = -below[..., :0:-1], 1.0
        C = (above - above[..., :1] * below)[..., np.newaxis, :0:-1]
        frequency = unit[..., np.newaxis, np.newaxis]
        return A * frequency, B * frequency, C, above[..., np.newaxis, :1]


def cells_of(one: Filter, name: str) -> tuple[Line, Line, Line]:
    """Return zeros, poles and gain of one filter as tables show them, its numbers by name.

    A pair that is not real has a frequency and a damping. The gain is that at rest; where that
    is zero or infinite, the first coefficient of the numerator over that of the denominator.
    """
    above = np.trim_zeros(one.numerator, "f")
    zeros = _roots(f"{name}.zeros", np.roots(above))
    poles = _roots(f"{name}.poles", np.roots(one.denominator))
    if one.numerator[-1] and one.denominator[-1]:
        rest = one.numerator[-1] / one.denominator[-1]
        return zeros, poles, significant(f"{name}.rest", rest, 5, "at rest")
    lead = above[0] if above.size else 0.0
    return zeros, poles, significant(f"{name}.lead", lead, 5, "of the leading coefficients")


def _roots(name: str, roots: AnyArray) -> Line:
    """What zeros or poles [1/s] are: a frequency with a damping of each pair, and the real ones."""
    found: Line = ()
    for k, root in enumerate(roots[np.imag(roots) >= 0.0]):
        found += (", ",) if k else ()
        if np.imag(root):
            size = float(np.abs(root))
            found += significant(f"{name}.{k}.frequency", size, 5, "rad/s, damping ")
            found += significant(f"{name}.{k}.damping", -float(np.real(root)) / size)
        else:
            found += significant(f"{name}.{k}", np.real(root), 5, "1/s")
    return found or ("none",)


def _rows(*coefficients: Any) -> FloatArray:
    return np.stack(np.broadcast_arrays(*coefficients), axis=-1)
