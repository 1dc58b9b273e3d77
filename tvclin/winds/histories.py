"""Exact time histories of winds and deflections, as piecewise exponential polynomials.

A history f(t) is a row of pieces between knots, each a sum of terms c t^k e^(lambda t). It has a
value at any time, an exact Laplace transform, and its sums, multiples, shifts, cuts and responses
of rational filters are histories again. Boundaries and verdicts need only the transform; nothing is
sampled.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tvclin.base.cards import Record
from tvclin.base.errors import InputError, array_of, finite, real, shown, whole_number
from tvclin.base.fields import derived
from tvclin.numerics import pieces as algebra
from tvclin.numerics import polynomials
from tvclin.numerics.pieces import Pieces
from tvclin.numerics.searches import grid_minimum

_MAX_LAPLACE_VARIABLE = 1e100
"""Largest size of a Laplace variable [rad/s]: beyond it products overflow."""
_MAX_PROBES = 8192
"""Approximate number of sample times, over all knots, for each rate of a curved history."""
_MIN_RATE = 1e-100
"""Rate [1/s] below which the time scale overflows, so that the rate counts as zero."""
_RELATIVE_ROUNDING = 1e-12
"""Relative rounding of times, and of values over the largest."""


class History(Record, ABC):
    """Real function of time, zero before its first knot, in exact pieces.

    Histories come in batches: every quantity has the leading axes ``batch``, and a single history
    is the batch of shape ``()``. A concrete wind or deflection defines its `_pieces` only.
    """

    @abstractmethod
    def _pieces(self) -> Pieces:
        """Return the `pieces`, which a wind or a deflection defines."""

    @cached_property
    def pieces(self) -> Pieces:
        """Pieces of the history: sums of c u^k e^(rate u), u [s] being the time since a knot.

        Knots [s], coefficients c by piece, rate and power k, and rates [1/s].
        """
        return self._pieces()

    @property
    def knots(self) -> FloatArray:
        """Times [s] at which one piece ends and the next begins, shape ``(..., n)``."""
        return self.pieces.knots

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch of histories, the leading axes of every array."""
        return self.pieces.batch

    def __call__(self, t: ArrayLike) -> FloatArray:
        """Return the value at times `t` [s], at a jump that after it, ``batch + t.shape``."""
        times = finite("t", t, "s")
        values = np.real(algebra.value(self.pieces, times.ravel()))
        return values.reshape((*self.batch, *times.shape))

    def laplace(self, s: ArrayLike) -> AnyArray:
        """Return the Laplace transform, the integral of e^(-s t) times the history over time.

        Parameters
        ----------
        s : array_like
            Laplace variable [rad/s], real or complex; broadcasts with ``batch``.

        Returns
        -------
        ndarray
            Shape ``broadcast(batch, s.shape)``, real for a real `s`; infinite where the
            integral diverges. Accurate for s near zero and for large s t.

        Notes
        -----
        The integral starts at the first knot, so that a history that begins before t = 0 keeps
        its whole effect; for all others it is the usual one-sided transform.
        """
        s = _laplace_variable(s)
        with np.errstate(over="ignore", invalid="ignore"):
            return _real_if_real(_finite_values(algebra.laplace(self.pieces, s), s), s)

    def laplace_magnitude(self, s: ArrayLike) -> FloatArray:
        """Return the sum of the sizes of all terms of ``laplace(s)``.

        Its product with the floating-point epsilon bounds the rounding error of the transform.
        """
        s = _laplace_variable(s)
        with np.errstate(over="ignore", invalid="ignore"):
            return _finite_values(algebra.magnitude(self.pieces, s), s)

    def remaining_integral(self, s: ArrayLike, t: ArrayLike) -> AnyArray:
        """Return the remaining integral, over r from `t` on, of e^(-s (r - t)) times the history.

        It is the effect that the history will still have, after the time `t` [s], on an unstable
        mode with the pole `s` [1/s]. Shape ``broadcast(batch, s.shape) + t.shape``.
        """
        return self.remaining_integral_of(s)(t)

    def remaining_integral_of(self, s: ArrayLike) -> Callable[[ArrayLike], AnyArray]:
        """Return a function of times t [s]: the remaining integral, over r from t on.

        Its integrand is e^(-s (r - t)) times the history at r; it is precomputed at the knots. `s`:
        poles [1/s] of unstable modes, which broadcast with ``batch``.
        """
        s = _laplace_variable(s)
        with np.errstate(over="ignore", invalid="ignore"):
            integral = algebra.remaining_integral(self.pieces, s)

        def at(t: ArrayLike) -> AnyArray:
            """Return the integrals from `t` [s] on, ``broadcast(batch, s.shape) + t.shape``."""
            times = finite("t", t, "s")
            with np.errstate(over="ignore", invalid="ignore"):
                values = _finite_values(integral(times.ravel()), s)
            values = _real_if_real(values, s)
            return values.reshape((*values.shape[:-1], *times.shape))

        return at

    def __add__(self, addend: object) -> History:
        """Return the sum of two histories, whose batches broadcast."""
        if not isinstance(addend, History):
            return NotImplemented
        return Piecewise(algebra.add(self.pieces, addend.pieces))

    def __sub__(self, subtrahend: object) -> History:
        """Return the difference of two histories, whose batches broadcast."""
        return self + (-subtrahend) if isinstance(subtrahend, History) else NotImplemented

    def __neg__(self) -> History:
        """Return the history with the opposite sign."""
        return self * -1.0

    def __mul__(self, factor: ArrayLike) -> History:
        """Return the history times `factor`, which broadcasts with ``batch``."""
        if isinstance(factor, History):
            return NotImplemented
        return Piecewise(_scaled(self.pieces, finite("factor", factor)))

    __rmul__ = __mul__
    __array_ufunc__ = None  # so that numpy leaves `array * history` to __rmul__

    def shift(self, dt: ArrayLike) -> History:
        """Return the history delayed by `dt` [s], which broadcasts with ``batch``."""
        dt = finite("dt", dt, "s")[..., np.newaxis]
        return Piecewise(Pieces(self.knots + dt, self.pieces.coefficients, self.pieces.rates))

    def before(self, time: ArrayLike) -> History:
        """Return the history up to `time` [s], zero from there on; whole for infinite `time`.

        `time` broadcasts with ``batch``; one before the first knot gives zero throughout.
        """
        edge = np.maximum(real("time", time, "s"), self.knots[..., 0])
        return Piecewise(algebra.before(self.pieces, edge))

    def filter(self, numerator: ArrayLike, denominator: ArrayLike) -> History:
        """Return the exact response of the filter numerator(s)/denominator(s) from zero state.

        Parameters
        ----------
        numerator, denominator : array_like
            Polynomial coefficients, highest power first, ``(..., m)`` and ``(..., n)``; the
            leading axes broadcast with ``batch``. The filter must not differentiate: m <= n.

        Raises
        ------
        InputError
            When the filter differentiates, its denominator begins with zero, or its poles are so
            far from each other or so fast that its response overflows.
        """
        num = np.atleast_1d(finite("numerator", numerator))
        den = np.atleast_1d(finite("denominator", denominator))
        if num.shape[-1] > den.shape[-1] or not np.all(den[..., 0]):
            raise InputError(
                "numerator must not be of higher degree than denominator, which must not begin"
                f" with zero; got {num.shape[-1] - 1} over {den.shape[-1] - 1}"
            )
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            representable = np.all(np.isfinite(den / den[..., :1]))
            response = _cascade(self.pieces, num, den) if representable else None
        if response is None or not np.all(np.isfinite(response.pieces.coefficients)):
            raise InputError("denominator has poles too large for floating-point numbers; scale it")
        return response

    def case(self, index: int, shape: tuple[int, ...]) -> History:
        """Return the history at the flat position `index` of the batch broadcast to `shape`."""
        p = self.cases(np.array([index]), shape).pieces
        return Piecewise(Pieces(p.knots[0], p.coefficients[0], p.rates[0]))

    def cases(self, index: IndexArray, shape: tuple[int, ...]) -> History:
        """Return the histories at flat positions of the batch, as a batch ``(k,)``.

        `index`: the positions, ``(k,)``. `shape`: shape to which the batch is broadcast first.
        """
        return Piecewise(algebra.take(algebra.spread(self.pieces, shape), index))

    @cached_property
    @derived("time")
    def onset(self) -> FloatArray:
        """Time [s] at which the history first differs from zero, shape ``batch``; inf if never."""
        return np.where(self._nonzero, self.knots, np.inf).min(axis=-1)

    @cached_property
    @derived("time")
    def end(self) -> FloatArray:
        """Time [s] from which the history stays zero, shape ``batch``; inf for an endless history.

        A history that is zero throughout ends at -inf.
        """
        return np.where(self._nonzero, self.knots + self.pieces.widths, -np.inf).max(axis=-1)

    @cached_property
    def final_value(self) -> FloatArray:
        """Value of the history for t to infinity, shape ``batch``; NaN where it has no limit."""
        # coefficients of the last piece by rate and power of time, ``(..., rates, degree + 1)``; a
        # term c u^k e^(rate u) stays if its rate is zero or positive, unless it is the constant
        last, rates = self.pieces.coefficients[..., -1, :, :], self.pieces.rates
        constant = np.where(rates == 0.0, last[..., 0], 0.0).sum(axis=-1)
        endless = (np.real(rates) >= 0.0)[..., np.newaxis] & (last != 0.0)
        endless[..., 0] &= rates != 0.0
        value = np.where(np.any(endless, axis=(-2, -1)), np.nan, np.real(constant))
        return np.broadcast_to(value, self.batch)

    @cached_property
    @derived("angle")
    def peak(self) -> FloatArray:
        """Value of largest magnitude, with its sign [rad], shape ``batch``.

        It is searched at the knots, on both sides of each jump, between them, and beyond the last
        one in an endless piece.
        """
        if self._linear:  # straight pieces, whose largest value is at an end
            values = self.shape_samples
            where = np.argmax(np.abs(values), axis=-1)[..., np.newaxis]
            return np.take_along_axis(values, where, axis=-1)[..., 0]
        times = self._curve_probe_times()
        values = np.real(algebra.value(self.pieces, times))
        where = np.argmax(np.abs(values), axis=-1)[..., np.newaxis]
        largest = np.take_along_axis(values, where, axis=-1)[..., 0]
        return self._refined_peak(times, where, largest)

    @cached_property
    def shape_samples(self) -> FloatArray:
        """Samples of the value that show its shape, ``(..., m)``: of linear pieces at their ends.

        Other pieces are sampled at `probe_times`, an endless last piece at its start.
        """
        if not self._linear:
            return np.real(algebra.value(self.pieces, self.probe_times()))
        p = self.pieces
        c = np.real(p.coefficients)
        c = c[..., 0, :] if c.shape[-2] == 1 else c.sum(axis=-2)  # all rates are zero: value, slope
        start = np.broadcast_to(c[..., 0], (*p.batch, p.knots.shape[-1]))
        if p.degree == 0:
            return start
        end_values = start[..., :-1] + np.diff(p.knots, axis=-1) * c[..., :-1, 1]
        ends = np.stack([start[..., :-1], end_values], axis=-1).reshape(
            *p.batch, 2 * end_values.shape[-1]
        )
        return np.concatenate([ends, start[..., -1:]], axis=-1)

    @cached_property
    def extent(self) -> tuple[FloatArray, FloatArray]:
        """Minimum and maximum of the `shape_samples`, shape ``batch``."""
        return self.shape_samples.min(axis=-1), self.shape_samples.max(axis=-1)

    @property
    def constant_sign(self) -> BoolArray:
        """Whether the `shape_samples` have one sign, to rounding, shape ``batch``."""
        low, high = self.extent
        return np.asarray(np.minimum(-low, high) <= _RELATIVE_ROUNDING * np.maximum(-low, high))

    def probe_times(self, between: int = 8) -> FloatArray:
        """Return sample times [s] at both sides of every knot and `between` more in each piece.

        Shape ``(..., m)``, not decreasing. The left side of a knot is the last floating-point
        number before it.
        """
        if whole_number("between", between) > _MAX_PROBES:
            raise InputError(f"between must be at most {_MAX_PROBES}; got {shown(between)}")
        start, stop = self.knots[..., :-1, np.newaxis], self.knots[..., 1:, np.newaxis]
        inside = start + (stop - start) * (np.arange(between + 1) / (between + 1))
        times = np.concatenate([inside, np.maximum(np.nextafter(stop, -np.inf), start)], axis=-1)
        flat = times.reshape(*times.shape[:-2], times.shape[-2] * times.shape[-1])
        return np.concatenate([flat, self.knots[..., -1:]], axis=-1)

    def _curve_probe_times(self) -> FloatArray:
        """Return sample times [s] of a curved history, rising, ``(..., m)``.

        They are `probe_times`, and after each knot evenly spaced times over twenty time constants
        of each rate; those within a piece end just before the next knot.
        """
        count = self.knots.shape[-1]
        steps = np.linspace(0.0, 20.0, int(np.clip(_MAX_PROBES // count, 8, 128)))
        rates = np.abs(self.pieces.rates)[..., np.newaxis]
        # times [s] after a knot, of all rates in one row
        after_rate = steps / np.where(rates > _MIN_RATE, rates, np.inf)
        row = (*after_rate.shape[:-2], after_rate.shape[-2] * after_rate.shape[-1])
        after = np.sort(after_rate.reshape(row), axis=-1)[..., np.newaxis, :]
        widths = np.diff(self.knots, axis=-1)
        inside = np.minimum(after, np.nextafter(widths, 0.0)[..., np.newaxis])
        in_pieces = self.knots[..., :-1, np.newaxis] + inside  # a row for each piece
        groups = [
            self.probe_times(64 if count < _MAX_PROBES // 64 else 8),
            in_pieces.reshape(*in_pieces.shape[:-2], in_pieces.shape[-2] * in_pieces.shape[-1]),
            self.knots[..., -1:] + after[..., 0, :],
        ]
        shape = np.broadcast_shapes(*(group.shape[:-1] for group in groups))
        samples = [np.broadcast_to(group, (*shape, group.shape[-1])) for group in groups]
        return np.sort(np.concatenate(samples, axis=-1), axis=-1)

    @cached_property
    def _nonzero(self) -> BoolArray:
        """Whether each piece of the history has a width and is not zero, ``(..., n)``."""
        c = self.pieces.coefficients  # column by column: numpy is slow along short axes
        columns = np.moveaxis(c.reshape(*c.shape[:-2], c.shape[-2] * c.shape[-1]), -1, 0)
        filled = reduce(np.logical_or, columns != 0.0)
        return np.asarray(filled & (self.pieces.widths > 0.0))

    @property
    def _linear(self) -> bool:
        """Whether all pieces of the history are linear in time, without exponentials."""
        return self.pieces.degree <= 1 and not np.any(self.pieces.rates)

    def _refined_peak(self, times: FloatArray, at: IndexArray, largest: FloatArray) -> FloatArray:
        """Return the peak [rad], shape ``batch``, refined around the largest of several samples.

        A peak inside is searched between the samples on both sides of the largest, if that is
        larger than both. `times`: sample times [s], ``(..., m)``. `at`: index of the sample of
        largest size, ``(..., 1)``. `largest`: its value [rad], shape ``batch``.
        """
        times = np.broadcast_to(times, (*self.batch, times.shape[-1]))
        last = times.shape[-1] - 1
        peak_time = np.take_along_axis(times, at, axis=-1)
        # sample times repeat where pieces decay at equal rates
        tolerance = _RELATIVE_ROUNDING * (times[..., -1:] - times[..., :1])
        # indices of the next distinct sample on either side of the largest
        before = np.sum(times < peak_time - tolerance, axis=-1, keepdims=True) - 1
        after = np.sum(times <= peak_time + tolerance, axis=-1, keepdims=True)
        at = np.concatenate([np.maximum(before, 0), at, np.minimum(after, last)], axis=-1)
        bracket, sign = np.take_along_axis(times, at, axis=-1), np.asarray(np.sign(largest))
        low, middle, high = np.moveaxis(np.real(algebra.value(self.pieces, bracket)), -1, 0) * sign
        inside = np.asarray((middle > low) & (middle > high))
        if not np.any(inside):
            return largest
        pieces, peak_sign = algebra.take(self.pieces, np.flatnonzero(inside)), sign[inside]

        def negative_size(t: FloatArray) -> FloatArray:
            """Return minus the size of the `pieces` at times `t` [s], a row for each case."""
            return -peak_sign[:, np.newaxis] * np.real(algebra.value(pieces, t))

        refined, ends = np.zeros(self.batch), (bracket[inside, 0], bracket[inside, 2])
        _, minimum = grid_minimum(negative_size, *ends)
        refined[inside] = -peak_sign * minimum
        return np.where(np.abs(refined) > np.abs(largest), refined, largest)


@dataclass(frozen=True, eq=False, repr=False)
class Piecewise(History):
    """History defined by its pieces, as sums, shifts and filter responses of others are."""

    arrays: Pieces

    def _pieces(self) -> Pieces:
        """Return the pieces from which the history was made."""
        return self.arrays

    def __repr__(self) -> str:
        """Return the number of pieces and the range of the knots [s], as text."""
        n = self.knots.shape[-1]
        low, high = np.min(self.knots, initial=np.inf), np.max(self.knots, initial=-np.inf)
        return f"Piecewise({n} pieces from {low:.6g} s to {high:.6g} s)"


def linear_pieces(knots: ArrayLike, values: ArrayLike, slopes: ArrayLike) -> Pieces:
    """Return linear pieces that begin at `knots` [s] with values and slopes [1/s], ``(..., n)``."""
    coefficients = np.stack(np.broadcast_arrays(values, slopes), axis=-1).astype(float)
    knots = np.asarray(knots, float)
    return Pieces(knots, coefficients=coefficients[..., np.newaxis, :], rates=np.zeros(1))


def _scaled(pieces: Pieces, factor: AnyArray) -> Pieces:
    """Return histories, as pieces, times factors, which broadcast with their batch.

    Only the coefficients are multiplied: the rates stand in e^(rate u), u being local time.
    """
    # behind the batch, coefficients have axes of pieces, rates and powers of time
    factor = factor[..., np.newaxis, np.newaxis, np.newaxis]
    return Pieces(pieces.knots, pieces.coefficients * factor, pieces.rates)


def _cascade(pieces: Pieces, num: FloatArray, den: FloatArray) -> Piecewise:
    """Return the response of a filter num(s)/den(s) to a history, by a chain of lags.

        num/den = c0 + c1/(s - p1) + c2/((s - p1)(s - p2)) + ...

    with the poles p and constants c, which repeated divisions by s - p leave as remainders; each
    lag 1/(s - p) acts on the response of the one before.

    Unlike partial fractions it needs no distinct poles. `pieces`: of the history. `num`, `den`:
    coefficients, highest power first, ``(..., m)``, ``(..., n)`` with m <= n.
    """
    poles = polynomials.roots(den)
    order = poles.shape[-1]
    quotient = (
        np.pad(num, [(0, 0)] * (num.ndim - 1) + [(order + 1 - num.shape[-1], 0)]) / den[..., :1]
    )
    gains = []  # c of the last lag first
    for k in reversed(range(order)):
        quotient, remainder = polynomials.divide(quotient, poles[..., k])
        gains.append(remainder)
    response, stage = _scaled(pieces, quotient[..., 0]), pieces
    for k, gain in enumerate(reversed(gains)):
        stage = algebra.lag(stage, poles[..., k])
        response = algebra.add(response, _scaled(stage, gain))
    return Piecewise(response)


def _laplace_variable(s: ArrayLike) -> AnyArray:
    """Return s [rad/s] as a float or complex array; `InputError` beyond the largest size."""
    rule = f"numbers up to {_MAX_LAPLACE_VARIABLE:g} in size, real or complex"
    array = array_of("s", s, "iufc", rule)
    if not np.all(np.abs(array) <= _MAX_LAPLACE_VARIABLE):
        raise InputError(f"s must be {rule}; got {shown(s)}")
    return array.astype(complex if array.dtype.kind == "c" else float)


def _finite_values(values: AnyArray, s: AnyArray) -> AnyArray:
    """Return transforms, `values`; `InputError` where they are NaN, since e^(-s t) overflows.

    `s`: the Laplace variable [rad/s].
    """
    if np.any(np.isnan(values)):
        raise InputError(f"s must be such that e^(-s t) does not overflow; got {shown(s)}")
    return values


def _real_if_real(values: AnyArray, s: AnyArray) -> AnyArray:
    """Return transforms, `values`, or their real parts for a real Laplace variable `s`."""
    return values if np.iscomplexobj(s) else np.real(values)


class VehicleWind(ABC):
    """Wind of a case whose angle follows from the vehicle, such as a measured wind speed."""

    @property
    @abstractmethod
    def shape(self) -> str:
        """Name of the wind."""

    @abstractmethod
    def history(self, vehicle: Any, plane: str) -> History:
        """Return the wind angle of attack [rad] of a vehicle in a plane."""

    def of_one_sign(self, vehicle: Any, plane: str) -> History:
        """Return the part [rad] of `history` with the sign of its largest angle."""
        return self.history(vehicle, plane)

    def unknown(self, vehicle: Any, plane: str) -> str:
        """Return why parts of the wind of a vehicle in a plane are not known; "" if it is known."""
        return ""

    @abstractmethod
    def largest_pressure(self, vehicle: Any, plane: str) -> float:
        """Return the largest dynamic pressure in the wind over the nominal one, q/q_n.

        `vehicle`, `plane`: as in `history`.
        """
