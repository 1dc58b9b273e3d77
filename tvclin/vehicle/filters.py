"""Filters: rational transfer functions of sensor lags and command shaping."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, ComplexArray, FloatArray
from tvclin.base.cards import Record
from tvclin.base.errors import InputError, array_of, between, broadcast, finite, nonzero, within
from tvclin.base.fields import spec
from tvclin.base.lines import Line, significant
from tvclin.numerics import polynomials

MAX_NUMBER = 1e9
"""Largest frequency [rad/s] and damping ratio, and largest inverse of a frequency."""
_MAX_COEFFICIENT = 1e60
"""Largest coefficient over the first of the denominator."""
_MAX_POLE_BOUND = 1e20
"""Largest bound of the poles [rad/s]."""
_MAX_COMPLEX_FREQUENCY = 1e12
"""Largest real or imaginary part of s [1/s]."""
_MAX_ORDER = 12
"""Largest order of a filter; to this power the fastest pole must not overflow."""

_bounded_positive = between(1.0 / MAX_NUMBER, MAX_NUMBER)
_bounded_damping = between(-MAX_NUMBER, MAX_NUMBER)


@dataclass(frozen=True, eq=False)
class Filter(Record):
    """Filter numerator(s)/denominator(s), or a batch of filters.

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

    numerator: FloatArray = field(metadata=spec())
    denominator: FloatArray = field(metadata=spec())

    def __eq__(self, other: object) -> bool:
        """Return whether `other` is a filter with equal coefficients and an equal batch."""
        return isinstance(other, Filter) and self._bytes == other._bytes

    def __hash__(self) -> int:
        """Return the hash of all coefficients."""
        return hash(self._bytes)

    @property
    def _bytes(self) -> tuple[tuple[int, ...], bytes, tuple[int, ...], bytes]:
        """Shapes and coefficients of the filter, which can be compared and hashed."""
        numerator, denominator = self.numerator, self.denominator
        return numerator.shape, numerator.tobytes(), denominator.shape, denominator.tobytes()

    def __post_init__(self) -> None:
        """Check both polynomials, divide them by the leading coefficient of the denominator.

        Both get the shape of the batch; leading zeros of the numerator are dropped.
        """
        above, below = finite("numerator", self.numerator), finite("denominator", self.denominator)
        for name, coefficients in (("numerator", above), ("denominator", below)):
            if not coefficients.ndim or not 0 < coefficients.shape[-1] <= _MAX_ORDER + 1:
                raise InputError(
                    f"{name} must be 1 to {_MAX_ORDER + 1} coefficients, highest power first; got"
                    f" an array of shape {coefficients.shape}"
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
        for name, coefficients in (("numerator", above), ("denominator", below)):
            label = f"{name} over the first coefficient of the denominator"
            within(label, coefficients, -_MAX_COEFFICIENT, _MAX_COEFFICIENT)
        within("a bound of the poles", polynomials.bound(below), 0.0, _MAX_POLE_BOUND, "rad/s")
        for name, coefficients in (("numerator", above), ("denominator", below)):
            array = np.array(np.broadcast_to(coefficients, (*shape, coefficients.shape[-1])))
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    @classmethod
    def from_coefficients(cls, numerator: ArrayLike, denominator: ArrayLike) -> Self:
        """Return the filter of a `numerator` and `denominator` in s, highest power first."""
        return cls(numerator, denominator)  # type: ignore[arg-type]

    @classmethod
    def low_pass(cls, frequency: ArrayLike, damping: ArrayLike | None = None) -> Self:
        """Return the lag w^2/(s^2 + 2 zeta w s + w^2), or w/(s + w) without a damping.

        `frequency`: w [rad/s], positive. `damping`: zeta, positive.
        """
        w = _bounded_positive("frequency", frequency, "rad/s")
        if damping is None:
            return cls(_coefficient_rows(w), _coefficient_rows(1.0, w))
        zeta = _bounded_positive("damping", damping)
        broadcast(frequency=w.shape, damping=zeta.shape)
        return cls(_coefficient_rows(w**2), _coefficient_rows(1.0, 2.0 * zeta * w, w**2))

    @classmethod
    def lead_lag(cls, zero: ArrayLike, pole: ArrayLike) -> Self:
        """Return (1 + s/zero)/(1 + s/pole), of unit steady gain.

        `zero`: corner frequency of the numerator [rad/s], not zero; above the pole it is a lag,
        below it a lead; negative is a zero in the right half plane. `pole`: corner frequency of the
        denominator [rad/s], positive.
        """
        z, p = nonzero("zero", zero, "rad/s"), _bounded_positive("pole", pole, "rad/s")
        _bounded_positive("zero", np.abs(z), "rad/s")
        broadcast(zero=z.shape, pole=p.shape)
        return cls(_coefficient_rows(p / z, p), _coefficient_rows(1.0, p))

    @classmethod
    def notch(cls, frequency: ArrayLike, zero_damping: ArrayLike, pole_damping: ArrayLike) -> Self:
        """Return (s^2 + 2 zeta_z w s + w^2)/(s^2 + 2 zeta_p w s + w^2).

        `frequency`: w [rad/s], positive, where the gain is zeta_z/zeta_p. `zero_damping`: zeta_z;
        zero removes the frequency entirely, and a negative value shapes the phase. `pole_damping`:
        zeta_p, positive; the notch is about 2 zeta_p w wide.
        """
        w = _bounded_positive("frequency", frequency, "rad/s")
        poles = _bounded_positive("pole_damping", pole_damping)
        zeros = _bounded_damping("zero_damping", zero_damping)
        broadcast(frequency=w.shape, zero_damping=zeros.shape, pole_damping=poles.shape)
        return cls(
            _coefficient_rows(1.0, 2.0 * zeros * w, w**2),
            _coefficient_rows(1.0, 2.0 * poles * w, w**2),
        )

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for one filter."""
        return self.denominator.shape[:-1]

    @property
    def order(self) -> int:
        """Number of poles."""
        return self.denominator.shape[-1] - 1

    def __call__(self, s: ArrayLike) -> ComplexArray:
        """Return the values at complex frequencies s [1/s], ``(*batch, *s.shape)``.

        They are infinite at a pole. `InputError` for non-numbers, and for numbers beyond 1e12 1/s.
        """
        at = array_of("s", s, "iufc", "a complex number in 1/s").astype(complex)
        for component in (at.real, at.imag):
            within("s", component, -_MAX_COMPLEX_FREQUENCY, _MAX_COMPLEX_FREQUENCY, "1/s")
        above, below = (
            polynomials.value(p, at.ravel()) for p in (self.numerator, self.denominator)
        )
        poles = below == 0.0
        values = np.where(poles, np.inf, above / np.where(poles, 1.0, below))
        return values.reshape((*self.batch, *at.shape))

    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return A, B, C, D of x' = A x + B u, y = C x + D u, with the leading axes of the batch.

        They are in controllable form, with states scaled by a frequency above all poles, so that
        the entries of A are of its size.
        """
        n = self.order
        # the unit of frequency [rad/s], a bound of all poles that is not zero
        unit = np.maximum(polynomials.bound(self.denominator), 1.0 / MAX_NUMBER)
        powers = unit[..., np.newaxis] ** np.arange(n + 1)
        a = self.denominator / powers
        b = polynomials.add(self.numerator, np.zeros(n + 1)) / powers  # as long as a
        # (b_0 s^n + .. + b_n)/(s^n + a_1 s^(n-1) + .. + a_n): D = b_0, C = b_k - a_k b_0.
        A = np.zeros((*self.batch, n, n)) + np.eye(n, k=1)
        B = np.zeros((*self.batch, n, 1))
        if n:
            A[..., -1, :], B[..., -1, 0] = -a[..., :0:-1], 1.0
        C = (b - b[..., :1] * a)[..., np.newaxis, :0:-1]
        frequency = unit[..., np.newaxis, np.newaxis]
        return A * frequency, B * frequency, C, b[..., np.newaxis, :1]


def filter_cells(filter_: Filter, name: str) -> tuple[Line, Line, Line]:
    """Return zeros, poles and gain of one filter as cells of a table.

    `name`: first part of the keys of the numbers. A complex pair has a frequency and a damping. The
    gain is that at s = 0; where that is zero or infinite, the ratio of the leading coefficients.
    """
    numerator = np.trim_zeros(filter_.numerator, "f")  # without leading zeros
    zeros = _roots_line(f"{name}.zeros", np.roots(numerator))
    poles = _roots_line(f"{name}.poles", np.roots(filter_.denominator))
    if filter_.numerator[-1] and filter_.denominator[-1]:
        static_gain = filter_.numerator[-1] / filter_.denominator[-1]
        return zeros, poles, significant(f"{name}.rest", static_gain, 5, "at rest")
    lead = numerator[0] if numerator.size else 0.0  # the denominator begins with 1
    return zeros, poles, significant(f"{name}.lead", lead, 5, "of the leading coefficients")


def _roots_line(name: str, roots: AnyArray) -> Line:
    """Return the cell of a table that lists `roots` [1/s]: pairs by frequency and damping.

    `name`: first part of the keys of the numbers. Without roots the cell is "none".
    """
    line: Line = ()
    for k, root in enumerate(roots[np.imag(roots) >= 0.0]):  # of a pair the upper root
        line += (", ",) if k else ()
        if np.imag(root):
            size = float(np.abs(root))
            line += significant(f"{name}.{k}.frequency", size, 5, "rad/s, damping ")
            line += significant(f"{name}.{k}.damping", -float(np.real(root)) / size)
        else:
            line += significant(f"{name}.{k}", np.real(root), 5, "1/s")
    return line or ("none",)


def _coefficient_rows(*coefficients: Any) -> FloatArray:
    """Return numbers or arrays that broadcast as coefficients on a new last axis, ``(..., n)``."""
    return np.stack(np.broadcast_arrays(*coefficients), axis=-1)
