"""Solution of a smooth initial value problem x' = f(t, x), by Picard iteration.

In each interval x is a polynomial at Chebyshev points, and the iteration

    x <- x(a) + integral from a to t of f(t, x) dt,

with the integral of the polynomial of f, contracts where the interval is short. An interval in
which it does not converge, or whose last Chebyshev coefficients have not decayed, is halved: their
size is about the error (Trefethen, 2013). So an interval with a jump of a derivative becomes short.

`scipy.integrate`, whose import takes as long as half a study, needs about as many evaluations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebint, chebpts2, chebvander

from tvclin.base.arrays import FloatArray
from tvclin.numerics.chebyshev import interpolation_factors

_DEGREE = 16
"""Degree of the polynomial in an interval."""
_MAX_ITERATIONS = 30
"""Iterations after which an interval is halved."""
_TOLERANCE = 1e-13
"""Error of an interval, relative to the largest value in it, or to one if that is larger."""
_MIN_INTERVAL = 1e-9
"""Shortest interval, relative to the whole, below which the solution ends."""


@dataclass(frozen=True)
class InitialValueSolution:
    """Solution x(t) ``(k,)`` between two times, to about 1e-12 of its size.

    `ends`: times between which it is a polynomial, ``(n + 1,)``, from the first time to the last,
    which may be earlier. `values`: x at the Chebyshev points of each, ``(n, degree + 1, k)``.
    """

    ends: FloatArray
    values: FloatArray

    def __call__(self, t: Any) -> FloatArray:
        """Return x ``(k,)`` at a time `t` [s], or ``(k, m)`` at times ``(m,)``.

        `ends` separate the intervals, `values` are x at the Chebyshev points of each, between which
        it is interpolated. A time outside the span counts as the nearer end of it.
        """
        times, rising = np.atleast_1d(t), np.sign(self.ends[-1] - self.ends[0])
        index = np.searchsorted(rising * self.ends[1:-1], rising * times)
        begin, end = self.ends[index], self.ends[index + 1]
        positions = np.clip((2.0 * times - begin - end) / (end - begin), -1.0, 1.0)
        factors = interpolation_factors(_points(), positions)
        x = np.einsum("md,mdk->km", factors, self.values[index])
        return x if np.ndim(t) else x[:, 0]


def initial_value_solution(
    rates: Callable[[FloatArray, FloatArray], FloatArray],
    begin: FloatArray,
    span: tuple[float, float],
    valid: Callable[[FloatArray], bool],
) -> InitialValueSolution:
    """Return the solution x(t) of x' = f(t, x) from the first time of a span to the last.

    It ends earlier where x would cease to be valid, or where the iteration does not converge. An
    interval is halved until the iteration converges in it and the last two Chebyshev coefficients
    of x are below the tolerance; the next one is twice as long as the last that was accepted.

    Parameters
    ----------
    rates : callable
        f from times ``(m,)`` and x ``(k, m)`` to derivatives ``(k, m)``.
    begin : ndarray
        x at the first time, ``(k,)``.
    span : tuple of float
        First and last time; the last may be the earlier one.
    valid : callable
        Function from x ``(k, m)`` to whether f may be evaluated there.
    """
    points = _points()
    to_coefficients = np.linalg.inv(chebvander(points, _DEGREE))
    integral = chebvander(points, _DEGREE + 1) @ chebint(to_coefficients, lbnd=-1.0)
    # from values at the points of an interval of length one to integrals from its start
    factors = np.asarray(0.5 * (integral - integral[0]), dtype=float)
    time, stop = span
    ends, polynomials, length = [time], [], stop - time
    x = np.asarray(begin, dtype=float)
    while time != stop and abs(length) > _MIN_INTERVAL * abs(span[1] - span[0]):
        times = time + length * (0.5 + 0.5 * points)
        values, tolerance = _picard(rates, x, times, length * factors, valid)
        if not np.all(np.abs(to_coefficients[-2:] @ values.T) <= tolerance):
            length *= 0.5
            continue
        x = values[:, -1]
        time = stop if length == stop - time else time + length
        ends.append(time)
        polynomials.append(values.T)
        length = np.copysign(min(2.0 * abs(length), abs(stop - time)), length)
    return InitialValueSolution(np.array(ends), np.reshape(polynomials, (-1, _DEGREE + 1, x.size)))


@cache
def _points() -> FloatArray:
    """Return the Chebyshev points of an interval, in [-1, 1], ``(degree + 1,)``."""
    return np.asarray(chebpts2(_DEGREE + 1))


def _picard(
    rates: Callable[[FloatArray, FloatArray], FloatArray],
    begin: FloatArray,
    times: FloatArray,
    integral: FloatArray,
    valid: Callable[[FloatArray], bool],
) -> tuple[FloatArray, FloatArray]:
    """Return x ``(k, m)`` at the times ``(m,)`` of an interval, and the tolerance of each ``(k,)``.

    NaN where the Picard iteration does not converge. `rates`: f of x' = f(t, x), from times and x
    to derivatives ``(k, m)``. `begin`: x at the start of the interval, ``(k,)``. `integral`:
    factors from values at the times to integrals up to the times, ``(m, m)``. `valid`: function
    that says whether f may be evaluated at x.
    """
    x = np.broadcast_to(begin[:, np.newaxis], (begin.size, times.size))
    for _ in range(_MAX_ITERATIONS):
        if not valid(x):
            break
        following = begin[:, np.newaxis] + rates(times, x) @ integral.T
        tolerance = _TOLERANCE * np.maximum(np.abs(following).max(axis=1), 1.0)
        if np.all(np.abs(following - x) <= tolerance[:, np.newaxis]):
            return following, tolerance
        x = following
    return np.full_like(x, np.nan), np.zeros(begin.shape)
