"""Where a loop has to be looked at: frequencies that miss no crossing and no peak.

Crossings and peaks are found between these and then refined to rounding, so that no result
depends on how fine they are.
"""

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels import polynomials
from tvclin.kernels.rational import Rational
from tvclin.kernels.stability import last_frequency

FloatArray = NDArray[np.float64]

_EVEN = 401
"""Logarithmic frequencies over the whole range."""
_BELOW, _BEYOND = 1e-3, 1e2
"""The range begins so far below the smallest root and ends so far beyond the largest."""
_AROUND = np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.5, 5.0])
"""Around a root, in units of its distance from the axis."""
_ON_AXIS = 1e-6
_FAR, _ZERO = 1e7, 1e-12
"""Over the fastest pole: a zero farther out is rounding, and so is a smaller root."""
_BESIDE, _FARTHEST = 1e-3, 1e30
"""So near to a frequency at which L is real one looks on both sides; none is beyond the second."""
_APART = 1e-6
"""Equal frequencies are moved apart by less than this part, so that each has two neighbours."""
QUIET, PAST = 1e-2, 2.0
"""A delay turns the phase for ever. It is followed until |L| stays below the first, at least so
many times as far as any pole of L can be, and a turn more."""
STEP, MORE, MOST = np.pi / 4.0, 12, 20_000
"""Steps of the delay's phase [rad], how many are added at the end, and the most there may be."""


def frequencies(loop: Rational, crossovers: FloatArray) -> FloatArray:
    """Return frequencies [rad/s] above zero, rising, ``(k, m)``; NaN fills the ends of rows.

    Parameters
    ----------
    loop : Rational
        A batch of one axis, ``(k,)``.
    crossovers : ndarray
        Frequencies at which |L| = 1, ``(k, n)``, filled with NaN.
    """
    closed = loop.denominator + loop.numerator
    poles = [polynomials.roots(p).astype(complex) for p in (closed, loop.denominator)]
    fastest = np.abs(np.concatenate(poles, axis=-1)).max(axis=-1)[:, np.newaxis]
    zeros = _zeros(loop.numerator)
    with np.errstate(invalid="ignore"):
        zeros = np.where(np.abs(zeros) < _FAR * fastest, zeros, np.nan)
    roots = np.concatenate([*poles, zeros], axis=-1)
    roots = np.where(roots.imag >= 0.0, roots, np.nan)  # one of each pair
    size = np.abs(roots)
    largest = np.nan_to_num(size).max(axis=-1)
    counted = size > _ZERO * fastest
    low = _BELOW * np.where(counted, size, np.inf).min(axis=-1)
    low = np.where(np.isfinite(low), low, 1e-3)
    high = np.maximum(_BEYOND * largest, 1e3 * low)
    steps = np.geomspace(low, high, _EVEN, axis=-1)
    width = np.maximum(np.abs(roots.real), _ON_AXIS * size)
    offsets = np.concatenate([-_AROUND[:0:-1], _AROUND])
    near = np.abs(roots.imag)[..., np.newaxis] + width[..., np.newaxis] * offsets
    turning = np.sqrt(_real_crossings(loop))
    parts = [steps, near.reshape(len(near), roots.shape[-1] * offsets.size), crossovers]
    parts += [turning * factor for factor in (1.0 - _BESIDE, 1.0 + _BESIDE)]
    if np.any(loop.delay > 0.0):
        even, end = _turning(loop, low)
        parts = [*(_up_to(part, end[:, np.newaxis]) for part in parts), even]
    every = np.concatenate(parts, axis=-1)
    bounded = (every >= low[:, np.newaxis]) & np.isfinite(every)
    every = np.sort(np.where(bounded, every, np.nan), axis=-1)
    return every * np.linspace(1.0, 1.0 + _APART, every.shape[-1])


def _real_crossings(loop: Rational) -> FloatArray:
    """The squares of the frequencies at which L is real, but for its delay; NaN fills the rest."""
    polynomial = polynomials.imaginary_part(loop.numerator, loop.denominator)
    lead = np.abs(polynomial).max(axis=-1, keepdims=True)
    polynomial = np.where(lead > 0.0, polynomial, 1.0)
    live = int(np.argmax(np.any(polynomial != 0.0, axis=0)))
    polynomial = np.array(polynomial[:, live:])
    first = polynomial[:, 0]
    polynomial[:, 0] = np.where(first == 0.0, 1e-300 + 1e-30 * lead[:, 0], first)
    with np.errstate(all="ignore"):
        roots = polynomials.roots(polynomial)
    real = (np.imag(roots) == 0.0) & (np.real(roots) > 0.0) & (np.real(roots) < _FARTHEST)
    return np.where(real, np.real(roots), np.nan)


def _up_to(part: FloatArray, end: FloatArray) -> FloatArray:
    return np.where(part <= end, part, np.nan)


def end_of_turns(loop: Rational) -> FloatArray:
    """Return how far [rad/s] the turns of a delay are followed, ``(k,)``; infinite without one."""
    turn = STEP / np.where(loop.delay > 0.0, loop.delay, np.inf)  # [rad/s]
    end = np.maximum(last_frequency(loop, QUIET), PAST * polynomials.bound(loop.denominator))
    return np.where(loop.delay > 0.0, np.minimum(end + MORE * turn, MOST * turn), np.inf)


def _turning(loop: Rational, low: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Even steps in which the delay turns the phase by no more than an eighth of a turn."""
    end = end_of_turns(loop)
    followed = np.where(np.isfinite(end), end, 0.0)
    steps = float((followed * loop.delay / STEP).max(initial=0.0))
    share = np.linspace(0.0, 1.0, int(np.ceil(steps)) + 2)
    last = np.where(np.isfinite(end), end, low)
    return last[:, np.newaxis] * share, end


def _zeros(numerator: FloatArray) -> NDArray[np.complex128]:
    """The zeros; where the numerators of a batch are of different degree, some lie far out."""
    live = np.flatnonzero(np.any(numerator != 0.0, axis=0))
    if not live.size:
        return np.full((len(numerator), 0), np.nan, dtype=complex)
    trimmed = np.array(numerator[:, live[0] :])
    tiny = 1e-12 * np.abs(trimmed).max(axis=-1)
    lead = trimmed[:, 0]
    trimmed[:, 0] = np.where(lead == 0.0, np.where(tiny > 0.0, tiny, 1.0), lead)
    return polynomials.roots(trimmed).astype(complex)
