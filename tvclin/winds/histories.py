"""Time histories, exact: the one kind of thing that winds and deflections are.

A history is a row of pieces between knots, each a sum of terms c t^k e^(lambda t). It has a
value at any time, an exact Laplace transform, and it stays a history when it is added, scaled,
shifted, cut short, or sent through a rational filter. Boundaries and verdicts need only the
transform; nothing is sampled.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, reduce

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tvclin.base.cards import Carded
from tvclin.base.errors import InputError, array_of, finite, real, shown, whole_number
from tvclin.numerics import pieces as algebra
from tvclin.numerics import polynomials
from tvclin.numerics.pieces import Pieces
from tvclin.numerics.searches import grid_minimum

_FASTEST = 1e100
"""Laplace variables beyond this [rad/s] would overflow in products."""
_PROBES = 8192
"""About so many times, over all knots, are looked at for each rate of a curved history."""
_SLOWEST = 1e-100
"""A rate below this [1/s] is none: its time scale is beyond all numbers that a time may have."""
_SAME = 1e-12
"""A part of all times, and of the largest value, that does not count."""


class History(Carded, ABC):
    """A real function of time, zero before its first knot, given exactly.

    Histories come in batches: every quantity has the leading axes ``batch``, and one history
    is the batch of shape ``()``. Concrete winds and deflections only say what their pieces are.
    """

    _keys = "peak_deg onset_s end_s"

    @property
    @abstractmethod
    def pieces(self) -> Pieces:
        """The pieces as arrays: knots, coefficients and rates."""

    @property
    def knots(self) -> FloatArray:
        """Times [s] at which one piece ends and the next begins, shape ``(..., n)``."""
        return self.pieces.knots

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the leading axes."""
        return self.pieces.batch

    def __call__(self, t: ArrayLike) -> FloatArray:
        """Return the value at the times `t` [s], shape ``batch + t.shape``.

        At a jump it is the value after the jump.
        """
        times = finite("t", t, "s")
        values = np.real(algebra.value(self.pieces, times.ravel()))
        return values.reshape((*self.batch, *times.shape))

    def laplace(self, s: ArrayLike) -> AnyArray:
        """Return the Laplace transform, the integral of e^(-s t) times the history.

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
            return _real_if_real(_carried(algebra.laplace(self.pieces, s), s), s)

    def laplace_magnitude(self, s: ArrayLike) -> FloatArray:
        """Return the sum of the sizes of all terms of ``laplace(s)``.

        Times the floating-point epsilon it bounds the rounding error of the transform.
        """
        s = _laplace_variable(s)
        with np.errstate(over="ignore", invalid="ignore"):
            return _carried(algebra.magnitude(self.pieces, s), s)

    def future(self, s: ArrayLike, t: ArrayLike) -> AnyArray:
        """Return the discounted future, the integral from `t` on of e^(-s (r - t)) f(r) dr.

        It is what the history will still do, after the time `t` [s], to a mode that grows with
        the rate `s` [1/s]. Shape ``broadcast(batch, s.shape) + t.shape``.
        """
        return self.future_of(s)(t)

    def future_of(self, s: ArrayLike) -> Callable[[ArrayLike], AnyArray]:
        """Return `future` at `s` as a function of times, for many calls: it is made ready once."""
        s = _laplace_variable(s)
        with np.errstate(over="ignore", invalid="ignore"):
            ahead = algebra.remaining_integral(self.pieces, s)

        def at(t: ArrayLike) -> AnyArray:
            times = finite("t", t, "s")
            with np.errstate(over="ignore", invalid="ignore"):
                values = _carried(ahead(times.ravel()), s)
            values = _real_if_real(values, s)
            return values.reshape((*values.shape[:-1], *times.shape))

        return at

    def __add__(self, other: object) -> History:
        if not isinstance(other, History):
            return NotImplemented
        return Piecewise(algebra.add(self.pieces, other.pieces))

    def __sub__(self, other: object) -> History:
        return self + (-other) if isinstance(other, History) else NotImplemented

    def __neg__(self) -> History:
        return self * -1.0

    def __mul__(self, factor: ArrayLike) -> History:
        """Return the history times `factor`, which broadcasts with ``batch``."""
        if isinstance(factor, History):
            return NotImplemented
        return Piecewise(_scaled(self.pieces, finite("factor", factor)))

    __rmul__ = __mul__
    __array_ufunc__ = None  # so that numpy leaves `array * history` to __rmul__

    def shift(self, dt: ArrayLike) -> History:
        """Return the same history, later by `dt` [s], which broadcasts with ``batch``."""
        dt = finite("dt", dt, "s")[..., np.newaxis]
        return Piecewise(Pieces(self.knots + dt, self.pieces.coefficients, self.pieces.rates))

    def before(self, time: ArrayLike) -> History:
        """Return the history up to `time` [s], zero from there on; an infinite time keeps all."""
        edge = np.maximum(real("time", time, "s"), self.knots[..., 0])
        return Piecewise(algebra.before(self.pieces, edge))

    def filter(self, numerator: ArrayLike, denominator: ArrayLike) -> History:
        """Return the exact answer of the filter numerator(s)/denominator(s), at rest before.

        Parameters
        ----------
        numerator, denominator : array_like
            Polynomial coefficients, highest power first, ``(..., m)`` and ``(..., n)``; the
            leading axes broadcast with ``batch``. The filter must not differentiate: m <= n.

        Raises
        ------
        InputError
            When the filter differentiates, its denominator begins with zero, or its poles are so
            far from each other or so fast that numbers cannot tell its answer.
        """
        num = np.atleast_1d(finite("numerator", numerator))
        den = np.atleast_1d(finite("denominator", denominator))
        if num.shape[-1] > den.shape[-1] or not np.all(den[..., 0]):
            raise InputError(
                "numerator must not be of higher degree than denominator, which must not begin"
                f" with zero; got {num.shape[-1] - 1} over {den.shape[-1] - 1}"
            )
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            carried = np.all(np.isfinite(den / den[..., :1]))
            answer = _cascade(self.pieces, num, den) if carried else None
        if answer is None or not np.all(np.isfinite(answer.pieces.coefficients)):
            raise InputError("denominator has poles too large for floating-point numbers; scale it")
        return answer

    def one(self, case: int, shape: tuple[int, ...]) -> History:
        """Return one history of the batch spread to `shape`, by its flat position there."""
        p = self.some(np.array([case]), shape).pieces
        return Piecewise(Pieces(p.knots[0], p.coefficients[0], p.rates[0]))

    def some(self, cases: IndexArray, shape: tuple[int, ...]) -> History:
        """Return some histories of the batch spread to `shape`, ``(k,)``, by flat positions."""
        return Piecewise(algebra.take(algebra.spread(self.pieces, shape), cases))

    @cached_property
    def onset(self) -> FloatArray:
        """Time [s] at which the history first differs from zero, shape ``batch``; inf if never."""
        return np.where(self._live, self.knots, np.inf).min(axis=-1)

    @cached_property
    def end(self) -> FloatArray:
        """Time [s] from which the history is zero for ever, shape ``batch``; inf if there is none.

        A history that is zero throughout ends at -inf.
        """
        return np.where(self._live, self.knots + self.pieces.widths, -np.inf).max(axis=-1)

    @cached_property
    def final_value(self) -> FloatArray:
        """The value that is approached for ever, shape ``batch``; NaN when there is none."""
        last, rates = self.pieces.coefficients[..., -1, :, :], self.pieces.rates
        constant = np.where(rates == 0.0, last[..., 0], 0.0).sum(axis=-1)
        endless = (np.real(rates) >= 0.0)[..., np.newaxis] & (last != 0.0)
        endless[..., 0] &= rates != 0.0
        value = np.where(np.any(endless, axis=(-2, -1)), np.nan, np.real(constant))
        return np.broadcast_to(value, self.batch)

    @cached_property
    def peak(self) -> FloatArray:
        """The value that is largest in size, with its sign, shape ``batch``.

        It is sought at the knots, on both sides of each jump, between them, and beyond the last
        one where the history goes on.
        """
        if self._linear:
            values = self.looked_at
            where = np.argmax(np.abs(values), axis=-1)[..., np.newaxis]
            return np.take_along_axis(values, where, axis=-1)[..., 0]
        times = self._close_probes()
        values = np.real(algebra.value(self.pieces, times))
        where = np.argmax(np.abs(values), axis=-1)[..., np.newaxis]
        largest = np.take_along_axis(values, where, axis=-1)[..., 0]
        return self._refined_peak(times, where, largest)

    @cached_property
    def looked_at(self) -> FloatArray:
        """Values that show the shape, ``(..., m)``: of straight lines those at their ends.

        Of other pieces, those at `probe_times`. A last piece that goes on shows its beginning.
        """
        if not self._linear:
            return np.real(algebra.value(self.pieces, self.probe_times()))
        p = self.pieces
        c = np.real(p.coefficients)
        c = c[..., 0, :] if c.shape[-2] == 1 else c.sum(axis=-2)
        start = np.broadcast_to(c[..., 0], (*p.batch, p.knots.shape[-1]))
        if p.degree == 0:
            return start
        stop = start[..., :-1] + np.diff(p.knots, axis=-1) * c[..., :-1, 1]
        both = np.stack([start[..., :-1], stop], axis=-1).reshape(*p.batch, 2 * stop.shape[-1])
        return np.concatenate([both, start[..., -1:]], axis=-1)

    @cached_property
    def extent(self) -> tuple[FloatArray, FloatArray]:
        """The lowest and the highest of the values that are `looked_at`, shape ``batch``."""
        return self.looked_at.min(axis=-1), self.looked_at.max(axis=-1)

    @property
    def one_sign(self) -> BoolArray:
        """Whether these values keep their sign but for rounding, shape ``batch``."""
        low, high = self.extent
        return np.asarray(np.minimum(-low, high) <= _SAME * np.maximum(-low, high))

    def probe_times(self, between: int = 8) -> FloatArray:
        """Return times [s] that show the shape: both sides of every knot and `between` more.

        Shape ``(..., m)``, not decreasing. The left side of a knot is the last floating-point
        number before it.
        """
        if whole_number("between", between) > _PROBES:
            raise InputError(f"between must be at most {_PROBES}; got {shown(between)}")
        start, stop = self.knots[..., :-1, np.newaxis], self.knots[..., 1:, np.newaxis]
        inside = start + (stop - start) * (np.arange(between + 1) / (between + 1))
        times = np.concatenate([inside, np.maximum(np.nextafter(stop, -np.inf), start)], axis=-1)
        flat = times.reshape(*times.shape[:-2], times.shape[-2] * times.shape[-1])
        return np.concatenate([flat, self.knots[..., -1:]], axis=-1)

    def _close_probes(self) -> FloatArray:
        """Times that show a curved history: after each knot every rate has its own time scale."""
        count = self.knots.shape[-1]
        each = np.linspace(0.0, 20.0, int(np.clip(_PROBES // count, 8, 128)))
        rates = np.abs(self.pieces.rates)[..., np.newaxis]
        offsets = each / np.where(rates > _SLOWEST, rates, np.inf)
        widths = np.diff(self.knots, axis=-1)
        row = (*offsets.shape[:-2], offsets.shape[-2] * offsets.shape[-1])
        after = np.sort(offsets.reshape(row), axis=-1)[..., np.newaxis, :]
        inside = np.minimum(after, np.nextafter(widths, 0.0)[..., np.newaxis])
        first = self.knots[..., :-1, np.newaxis]
        within = np.broadcast_shapes(first.shape, inside.shape)
        parts = [
            self.probe_times(64 if count < _PROBES // 64 else 8),
            (first + inside).reshape(*within[:-2], within[-2] * within[-1]),
            self.knots[..., -1:] + after[..., 0, :],
        ]
        shape = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
        every = [np.broadcast_to(part, (*shape, part.shape[-1])) for part in parts]
        return np.sort(np.concatenate(every, axis=-1), axis=-1)

    @property
    def _live(self) -> BoolArray:
        c = self.pieces.coefficients  # column by column: numpy is slow along short axes
        columns = np.moveaxis(c.reshape(*c.shape[:-2], c.shape[-2] * c.shape[-1]), -1, 0)
        filled = reduce(np.logical_or, columns != 0.0)
        return np.asarray(filled & (self.pieces.widths > 0.0))

    @property
    def _linear(self) -> bool:
        return self.pieces.degree <= 1 and not np.any(self.pieces.rates)

    def _refined_peak(
        self, times: FloatArray, where: IndexArray, largest: FloatArray
    ) -> FloatArray:
        times = np.broadcast_to(times, (*self.batch, times.shape[-1]))
        last = times.shape[-1] - 1
        here = np.take_along_axis(times, where, axis=-1)
        apart = _SAME * (times[..., -1:] - times[..., :1])  # rates that are alike repeat a time
        before = np.sum(times < here - apart, axis=-1, keepdims=True) - 1
        after = np.sum(times <= here + apart, axis=-1, keepdims=True)
        at = np.concatenate([np.maximum(before, 0), where, np.minimum(after, last)], axis=-1)
        near, sign = np.take_along_axis(times, at, axis=-1), np.asarray(np.sign(largest))
        low, middle, high = np.moveaxis(np.real(algebra.value(self.pieces, near)), -1, 0) * sign
        inside = np.asarray((middle > low) & (middle > high))
        if not np.any(inside):
            return largest
        some, side = algebra.take(self.pieces, np.flatnonzero(inside)), sign[inside]

        def below(t: FloatArray) -> FloatArray:
            return -side[:, np.newaxis] * np.real(algebra.value(some, t))

        refined = np.zeros(self.batch)
        refined[inside] = -side * grid_minimum(below, near[inside, 0], near[inside, 2])[1]
        return np.where(np.abs(refined) > np.abs(largest), refined, largest)


@dataclass(frozen=True, eq=False, repr=False)
class Piecewise(History):
    """A history given by its pieces; sums, shifts and filters of other histories are these."""

    arrays: Pieces

    @property
    def pieces(self) -> Pieces:
        """The pieces as arrays: knots, coefficients and rates."""
        return self.arrays

    def __repr__(self) -> str:
        n = self.knots.shape[-1]
        low, high = np.min(self.knots, initial=np.inf), np.max(self.knots, initial=-np.inf)
        return f"Piecewise({n} pieces from {low:.6g} s to {high:.6g} s)"


def linear_pieces(knots: ArrayLike, values: ArrayLike, slopes: ArrayLike) -> Pieces:
    """Return pieces that start at ``knots (..., n)`` with the given values and slopes [1/s]."""
    coefficients = np.stack(np.broadcast_arrays(values, slopes), axis=-1).astype(float)
    return Pieces(np.asarray(knots, float), coefficients[..., np.newaxis, :], np.zeros(1))


def _scaled(pieces: Pieces, factor: AnyArray) -> Pieces:
    factor = factor[..., np.newaxis, np.newaxis, np.newaxis]
    return Pieces(pieces.knots, pieces.coefficients * factor, pieces.rates)


def _cascade(pieces: Pieces, num: FloatArray, den: FloatArray) -> Piecewise:
    """Filter by a chain of lags: num/den = c0 + c1/(s-p1) + c2/((s-p1)(s-p2)) + ...

    Unlike partial fractions it needs no distinct poles.
    """
    poles = polynomials.roots(den)
    order = poles.shape[-1]
    rest = np.pad(num, [(0, 0)] * (num.ndim - 1) + [(order + 1 - num.shape[-1], 0)]) / den[..., :1]
    gains = []
    for k in reversed(range(order)):
        rest, remainder = polynomials.divide(rest, poles[..., k])
        gains.append(remainder)
    answer, stage = _scaled(pieces, rest[..., 0]), pieces
    for k, gain in enumerate(reversed(gains)):
        stage = algebra.lag(stage, poles[..., k])
        answer = algebra.add(answer, _scaled(stage, gain))
    return Piecewise(answer)


def _laplace_variable(s: ArrayLike) -> AnyArray:
    rule = f"numbers up to {_FASTEST:g} in size, real or complex"
    array = array_of("s", s, "iufc", rule)
    if not np.all(np.abs(array) <= _FASTEST):
        raise InputError(f"s must be {rule}; got {shown(s)}")
    return array.astype(complex if array.dtype.kind == "c" else float)


def _carried(values: AnyArray, s: AnyArray) -> AnyArray:
    """The values; `InputError` where e^(-s t) has outgrown every number and left none."""
    if np.any(np.isnan(values)):
        raise InputError(f"s must be such that e^(-s t) does not overflow; got {shown(s)}")
    return values


def _real_if_real(values: AnyArray, s: AnyArray) -> AnyArray:
    return values if np.iscomplexobj(s) else np.real(values)
