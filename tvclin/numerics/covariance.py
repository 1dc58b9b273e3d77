"""Gaussian processes: covariance of linear systems in white noise, and crossings of a limit.

Covariance of x' = A x + n, E[n(t) n(t')'] = N delta(t - t'): stationary, A P + P A' + N = 0, and in
exact steps, P(t + h) = F P(t) F' + Q(h) with

    F = e^(A h),    Q = int_0^h e^(A s) N e^(A' s) ds.

The steps are found by series and doubling, Q(2 h) = Q + F Q F', which adds nothing but positive
matrices: Van Loan's exponential contains e^(-A h), which loses all digits where fast poles decay.
The states are scaled by powers of two before, so that A h is small and few doublings do.
A system that varies over a step is replaced by the constant one with the same step to order four,
Magnus' expansion with two Gauss points (Blanes, Casas, Oteo and Ros, 2009).

Gaussian values have absolute values with E|x| = d sqrt(2/pi) exp(-mu^2/2) + m erf(mu/sqrt 2), m
and d being mean and standard deviation and mu = m/d, and with a covariance by Price's theorem; they
cross a limit at the rate of Rice's formula (Cramer and Leadbetter, 1967).
"""

from __future__ import annotations

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.numerics.propagation import balanced, constant_generator, exponential_series

_MAX_SERIES_NORM, _SERIES_TERMS = 0.25, 12
"""Norm of A h up to which the series is used, and its terms: (2 x 0.25)^13/13! is below 1e-13."""


def stationary_covariance(A: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the stationary covariance P ``(n, n)`` of A P + P A' + N = 0 of a stable system.

    P is E[x x']. `A`: A of x' = A x + n [1/s], ``(n, n)``. `noise`: N, spectral density of the
    white noise n, E[n(t) n(t')'] = N delta(t - t'), symmetric.
    """
    from scipy.linalg import solve_continuous_lyapunov  # late: it takes half a second to import

    P = solve_continuous_lyapunov(A, -noise)
    return np.asarray(0.5 * (P + P.T))


def periodic_covariance(step: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the stationary covariance P ``(n, n)`` of P = F P F' + Q of a stable discrete system.

    `step`: F, which maps the states to those one period later, ``(n, n)``. `noise`: Q, the
    covariance that noise adds in a period, ``(n, n)``.
    """
    from scipy.linalg import solve_discrete_lyapunov  # late: scipy takes long to import

    P = solve_discrete_lyapunov(step, noise)
    return np.asarray(0.5 * (P + P.T))


def steps(A: FloatArray, noise: FloatArray, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return F = e^(A h) and the covariance Q that white noise adds in steps h, each ``(m, n, n)``.

    `A`, `noise`: A of x' = A x + n [1/s] and the spectral density N of n, ``(n, n)`` or ``(m, n,
    n)``. `times`: lengths h of the steps [s], ``(m,)``. Elements that overflow are infinite or NaN.
    """
    lengths, n = np.asarray(times, float), A.shape[-1]
    sizes = np.abs(A) + np.abs(noise)
    couplings = sizes if sizes.ndim == 2 else sizes.max(axis=0, initial=0.0)
    moving = np.flatnonzero(np.any(couplings, axis=0) | np.any(couplings, axis=1))
    if moving.size < n:  # the other states are constant and act on none
        F, Q = np.tile(np.eye(n), (lengths.size, 1, 1)), np.zeros((lengths.size, n, n))
        row, column = moving[:, np.newaxis], moving
        moved = steps(A[..., row, column], noise[..., row, column], lengths)
        F[:, row, column], Q[:, row, column] = moved
        return F, Q
    # states over powers of two, `scale`, with which rows and columns of A have similar norms
    _, scale = balanced(np.abs(A) if A.ndim == 2 else np.abs(A).max(axis=0, initial=0.0))
    A, noise = A * (scale / scale[:, np.newaxis]), noise / np.multiply.outer(scale, scale)
    norm = np.abs(A).sum(axis=-2).max(axis=-1, initial=0.0)
    size = float(np.max(norm * lengths, initial=0.0))
    _, exponent = np.frexp(size / _MAX_SERIES_NORM)  # of two
    doublings = max(int(exponent), 0)
    first = np.ldexp(lengths, -doublings)[:, np.newaxis, np.newaxis]
    step = A * first
    F = exponential_series(step)
    term = noise * first  # h^k/k! times the k-th derivative of Q(h) at zero, here k = 1
    Q = term.copy()
    for k in range(2, _SERIES_TERMS + 1):
        term = _noise_slope(step, term) * (1.0 / k)
        Q += term
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(doublings):  # from h to 2 h
            Q += F @ Q @ np.swapaxes(F, -1, -2)
            F = F @ F
        return F * (scale[:, np.newaxis] / scale), Q * np.multiply.outer(scale, scale)


def constant_over_steps(
    A: tuple[FloatArray, FloatArray], noise: tuple[FloatArray, FloatArray], times: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the constant A and N of m steps with the effect, to fourth order, of varying ones.

    Both ``(m, n, n)``. `A`, `noise`: state matrix A [1/s] and noise density N of x' = A x + n, at
    the two Gauss points (`GAUSS_NODES`) of each step, each ``(m, n, n)``; N is symmetric. `times`:
    lengths of the steps [s], ``(m,)``.

    By Magnus' expansion with two Gauss points (Blanes, Casas, Oteo and Ros, 2009).
    """
    (A1, A2), (N1, N2) = A, noise
    factor = np.sqrt(3.0) / 12.0 * np.asarray(times)[:, np.newaxis, np.newaxis]
    density = 0.5 * (N1 + N2) + factor * (_noise_slope(A2, N1) - _noise_slope(A1, N2))
    return constant_generator(A1, A2, times), density


def _noise_slope(matrix: FloatArray, noise: FloatArray) -> FloatArray:
    """Return A N + N A' of m matrices A and symmetric noise densities N, ``(m, n, n)``.

    It is the rate at which motion by A changes a covariance N.
    """
    product = matrix @ noise
    return product + np.swapaxes(product, -1, -2)


_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
"""Gauss-Legendre rule of the covariance of absolute values, over the angle asin(r)."""
_MAX_CORRELATION = 1.0 - 1e-12
"""Correlation of a value and its rate above which it counts as this."""


def mean_absolute(mean: FloatArray, deviation: FloatArray) -> FloatArray:
    """Return E|x| of Gaussian values x by their mean and standard deviation, which broadcast."""
    from scipy.special import erf  # late: scipy takes long to import

    ratio = _ratio(mean, deviation)
    # ratios up to 40, beyond which the exponential is zero, so that no square overflows
    spread = deviation * np.sqrt(2.0 / np.pi) * np.exp(-0.5 * np.minimum(np.abs(ratio), 40.0) ** 2)
    return np.asarray(spread + mean * erf(ratio / np.sqrt(2.0)))


def absolute_covariance(
    mean: tuple[FloatArray, FloatArray],
    deviation: tuple[FloatArray, FloatArray],
    correlation: FloatArray,
) -> FloatArray:
    """Return the covariance of |x| and |y| for Gaussian pairs (x, y); all arrays broadcast.

    `mean`, `deviation`: means and standard deviations, each of x and of y. `correlation`: r of x
    and y, from -1 to 1. For unit deviations its second derivative over r is four times the joint
    density at zero (Price's theorem); this is integrated twice, over the angle asin(r). Without
    means the result is (2/pi) d_x d_y (sqrt(1 - r^2) + r asin r - 1).
    """
    from scipy.special import erf  # late: scipy takes long to import

    first, second = (_ratio(m, d) for m, d in zip(mean, deviation, strict=True))
    r = np.clip(correlation, -1.0, 1.0)
    half = 0.5 * np.arcsin(r)
    total = r * erf(first / np.sqrt(2.0)) * erf(second / np.sqrt(2.0))
    squares, product = first**2 + second**2, 2.0 * first * second
    for node, weight in zip(_NODES, _WEIGHTS, strict=True):
        angle = half * (1.0 + node)
        sine = np.sin(angle)
        room = np.maximum(1.0 - sine**2, 1e-300)  # not zero, to be divided by
        exponent = np.minimum((squares - product * sine) / (2.0 * room), 700.0)
        total = total + weight * half * (r - sine) * np.exp(-exponent) * (2.0 / np.pi)
    return np.asarray(deviation[0] * deviation[1] * total)


def exceedance(limit: float, mean: FloatArray, deviation: FloatArray) -> FloatArray:
    """Return the probability of ``|x| > limit`` of Gaussian values x, by mean and deviation.

    `mean`, `deviation`: mean and standard deviation of x, arrays that broadcast.
    """
    from scipy.special import ndtr  # late: scipy takes long to import

    spread = np.maximum(deviation, np.finfo(float).tiny)
    # beyond 40 deviations the probability is zero, or one, to rounding
    with np.errstate(over="ignore"):  # of a limit far beyond the spread
        sides = [np.clip((sign * mean - limit) / spread, -40.0, 40.0) for sign in (1.0, -1.0)]
    return np.asarray(ndtr(sides[0]) + ndtr(sides[1]))


def crossing_rate(
    limit: float,
    mean: FloatArray,
    deviation: FloatArray,
    mean_rate: FloatArray,
    rate_deviation: FloatArray,
    correlation: FloatArray,
) -> FloatArray:
    """Return the expected rate [1/s] of crossings of +limit upwards and of -limit downwards.

    By Rice's formula: with u = (limit - mean)/s and e = (mean_rate/d + rho u)/sqrt(1 - rho^2) the
    upward rate is (d/s) sqrt(1 - rho^2) phi(u) (phi(e) + e Phi(e)), s and d being the deviations of
    value and rate, rho their correlation, phi and Phi the normal density and distribution.

    `limit`: positive, in the unit of the values. `mean`, `deviation`: mean and standard deviation
    of Gaussian values; `mean_rate`, `rate_deviation`: of their rates. `correlation`: between value
    and rate. The arrays broadcast; where a deviation is zero nothing is random, and the rate counts
    as zero.
    """
    from scipy.special import ndtr  # late: scipy takes long to import

    rho = np.clip(correlation, -_MAX_CORRELATION, _MAX_CORRELATION)
    free = np.sqrt(1.0 - rho**2)
    total = np.zeros(np.broadcast_shapes(np.shape(mean), np.shape(deviation)))
    random = (deviation > 0.0) & (rate_deviation > 0.0)
    s, d = np.where(random, deviation, 1.0), np.where(random, rate_deviation, 1.0)
    for sign in (1.0, -1.0):  # beyond a thousand deviations nothing crosses
        u = np.clip(limit - sign * mean, -1e3 * s, 1e3 * s) / s
        e = (sign * mean_rate / d + rho * u) / free
        rate = d / s * free * _density(u) * (_density(e) + e * ndtr(e))
        total = total + np.where(random, rate, 0.0)
    return total


def _ratio(mean: FloatArray, deviation: FloatArray) -> FloatArray:
    """Return mean over standard deviation, up to 1e6 in size where the deviation is near zero.

    The bound is far beyond the range in which a normal distribution changes.
    """
    floor = np.maximum(deviation, np.maximum(1e-6 * np.abs(mean), np.finfo(float).tiny))
    return np.asarray(mean / floor)


def _density(x: FloatArray) -> FloatArray:
    """Return the standard normal density at x, constant beyond 40 in size."""
    return np.asarray(np.exp(-0.5 * np.minimum(np.abs(x), 40.0) ** 2) / np.sqrt(2.0 * np.pi))
