"""Where a loop has to be looked at: frequencies that miss no crossing and no peak.

Crossings and peaks are found between these and then refined to rounding, so that no result
depends on how fine they are.
"""

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.numerics.stability import Stability, last_frequency
from tvclin.numerics.state_loop import AnyLoop

_EVEN = 401
"""Logarithmic frequencies over the whole range."""
BELOW, BEYOND = 1e-3, 1e2
"""The range begins so far below the smallest root and ends so far beyond the largest."""
AROUND = np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.5, 5.0])
"""Around a root, in units of its distance from the axis."""
_ON_AXIS = 1e-6
"""The least distance from the axis by which points are spread around a root, over its size."""
_FAR, _ZERO = 1e7, 1e-12
"""Over the fastest pole: a zero farther out is rounding, and so is a smaller root."""
_BESIDE = 1e-3
"""So near to a frequency at which L is real one looks on both sides."""
_APART = 1e-11
"""Each is moved on beside the one before by this part, so that equal ones have two neighbours."""
_QUIET, _PAST = 1e-2, 2.0
"""A delay turns the phase for ever. It is followed until |L| stays below the first, at least so
many times as far as any pole of L can be, and a turn more."""
_PHASE_STEP, _STEPS_ADDED, _MOST_STEPS = np.pi / 4.0, 12, 20_000
"""Steps of the delay's phase [rad], how many are added at the end, and the most there may be."""


def frequencies(loop: AnyLoop, found: Stability) -> FloatArray:
    """Return frequencies [rad/s] above zero, rising, ``(k, m)``; NaN fills the ends of rows.

    `loop`: a batch of one axis, ``(k,)``. `found`: its closed-loop poles and gain crossovers.
    """
    poles = [found.poles.astype(complex), loop.open_poles().astype(complex)]
    fastest = np.abs(np.concatenate(poles, axis=-1)).max(axis=-1)[:, np.newaxis]
    zeros = loop.zeros()
    with np.errstate(invalid="ignore"):
        zeros = np.where(np.abs(zeros) < _FAR * fastest, zeros, np.nan)
    roots = np.concatenate([*poles, zeros], axis=-1)
    roots = np.where(roots.imag >= 0.0, roots, np.nan)  # one of each pair
    size = np.abs(roots)
    largest = np.nan_to_num(size).max(axis=-1)
    counted = size > _ZERO * fastest
    low = BELOW * np.where(counted, size, np.inf).min(axis=-1)
    low = np.where(np.isfinite(low), low, 1e-3)
    high = np.maximum(BEYOND * largest, 1e3 * low)
    steps = np.geomspace(low, high, _EVEN, axis=-1)
    width = np.maximum(np.abs(roots.real), _ON_AXIS * size)
    offsets = np.concatenate([-AROUND[:0:-1], AROUND])
    near = np.abs(roots.imag)[..., np.newaxis] + width[..., np.newaxis] * offsets
    turning = loop.real_frequencies()
    parts = [steps, near.reshape(len(near), roots.shape[-1] * offsets.size), found.crossovers]
    parts += [turning * factor for factor in (1.0 - _BESIDE, 1.0 + _BESIDE)]
    if np.any(loop.delay > 0.0):
        even, end = _turning(loop)
        parts = [*(np.where(part <= end[:, np.newaxis], part, np.nan) for part in parts), even]
    every = np.concatenate(parts, axis=-1)
    bounded = (every >= low[:, np.newaxis]) & np.isfinite(every)
    every = np.sort(np.where(bounded, every, np.nan), axis=-1)
    return every * (1.0 + _APART * np.arange(every.shape[-1]))


def _turning(loop: AnyLoop) -> tuple[FloatArray, FloatArray]:
    """Even steps in which the delay turns the phase by an eighth of a turn, and their end.

    It is infinite, and the steps NaN, without a delay.
    """
    delayed = loop.delay > 0.0
    step = _PHASE_STEP / np.where(delayed, loop.delay, 1.0)  # [rad/s]
    end = np.maximum(last_frequency(loop, _QUIET), _PAST * loop.bound())
    count = np.minimum(np.ceil(end / step) + _STEPS_ADDED, _MOST_STEPS)
    every = np.arange(int(count[delayed].max(initial=0.0)) + 1)
    taken = delayed[:, np.newaxis] & (every <= count[:, np.newaxis])
    steps = np.where(taken, every * step[:, np.newaxis], np.nan)
    return steps, np.where(delayed, count * step, np.inf)
