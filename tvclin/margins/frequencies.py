"""Where a loop has to be looked at: frequencies that miss no crossing and no peak.

Crossings and peaks are found between these and then refined to rounding, so that no result
depends on how fine they are.
"""

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels import polynomials
from tvclin.margins.loop import Loop
from tvclin.margins.stability import last_frequency

FloatArray = NDArray[np.float64]

_EVEN = 401
"""Logarithmic frequencies over the whole range."""
_BELOW, _BEYOND = 1e-3, 1e2
"""The range begins so far below the smallest root and ends so far beyond the largest."""
_AROUND = np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.5, 5.0])
"""Around a root, in units of its distance from the axis."""
_ON_AXIS = 1e-6
_APART = 1e-6
"""Equal frequencies are moved apart by less than this part, so that each has two neighbours."""
_QUIET = 1e-2
"""A delay turns the phase for ever; it is followed until |L| stays below this, and a turn more."""
_STEP, _MORE, _MOST = np.pi / 4.0, 12, 20_000
"""Steps of the delay's phase [rad], how many are added at the end, and the most there may be."""


def frequencies(loop: Loop, crossovers: FloatArray) -> FloatArray:
    """Return frequencies [rad/s] above zero, rising, ``(k, m)``.

    Parameters
    ----------
    loop : Loop
        A batch of one axis, ``(k,)``.
    crossovers : ndarray
        Frequencies at which |L| = 1, ``(k, n)``, filled with NaN.
    """
    closed = loop.denominator + loop.numerator
    roots = np.concatenate(
        [
            polynomials.roots(closed).astype(complex),
            polynomials.roots(loop.denominator).astype(complex),
            _zeros(loop.numerator),
        ],
        axis=-1,
    )
    roots = np.where(roots.imag >= 0.0, roots, np.nan)  # one of each pair
    size = np.abs(roots)
    largest = np.where(np.isfinite(size), size, 0.0).max(axis=-1)
    counted = np.isfinite(size) & (size > 1e-9 * largest[:, np.newaxis])
    low = _BELOW * np.where(counted, size, np.inf).min(axis=-1)
    low = np.where(np.isfinite(low) & (low > 0.0), low, 1e-3)
    high = np.maximum(_BEYOND * largest, 1e3 * low)
    steps = np.geomspace(low, high, _EVEN, axis=-1)
    width = np.maximum(np.abs(roots.real), _ON_AXIS * size)
    offsets = np.concatenate([-_AROUND[:0:-1], _AROUND])
    near = np.abs(roots.imag)[..., np.newaxis] + width[..., np.newaxis] * offsets
    parts = [steps, near.reshape(len(near), -1), crossovers]
    if np.any(loop.delay > 0.0):
        turning, end = _turning(loop, largest, low)
        parts = [*(np.fmin(part, end[:, np.newaxis]) for part in parts), turning]
    every = np.concatenate(parts, axis=-1)
    bounded = (every >= low[:, np.newaxis]) & np.isfinite(every)
    every = np.sort(np.where(bounded, every, low[:, np.newaxis]), axis=-1)
    return every * np.linspace(1.0, 1.0 + _APART, every.shape[-1])


def _turning(loop: Loop, largest: FloatArray, low: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Even steps in which the delay turns the phase by no more than an eighth of a turn."""
    delay = loop.delay
    turn = _STEP / np.where(delay > 0.0, delay, np.inf)  # [rad/s]
    end = np.maximum(last_frequency(loop, _QUIET), 20.0 * largest)
    end = np.minimum(end + _MORE * turn, _MOST * turn)
    end = np.where(delay > 0.0, end, np.inf)
    steps = np.max(end / turn, where=delay > 0.0, initial=0.0)
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
