"""Where the sensitivities of a loop are largest."""

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.rational import Rational

FloatArray = NDArray[np.float64]

AT_INFINITY = (1.0, 0.0, 0.5)
"""What |S|, |T| and |S - T|/2 tend to."""
_WORTH = 0.3
"""Samples that stand above their neighbours are refined if they reach this part of the highest."""
_SHARP = 1e-11
"""The part of its frequency that may be missing at a summit: light damping makes them sharp."""


def peaks(loop: Rational, omega: FloatArray) -> FloatArray:
    """Return the largest sizes on the imaginary axis and their frequencies, ``(3, 2, k)``.

    Of S = 1/(1 + L), of T = L/(1 + L), and of (S - T)/2; an infinite frequency [rad/s] means
    that the value is approached there.

    Parameters
    ----------
    loop : Rational
        A batch of stable closed loops, ``(k,)``.
    omega : ndarray
        Frequencies [rad/s] that miss no peak, ``(k, n)``.
    """
    from scipy.optimize.elementwise import find_minimum  # late: it takes 0.3 s to import

    whole = np.concatenate([np.zeros((len(omega), 1)), omega], axis=-1)
    values = np.nan_to_num(_sizes(loop, whole), nan=-np.inf)
    top = np.argmax(values, axis=-1)
    height, where = values.max(axis=-1), whole[np.arange(len(whole)), top]
    inner = values[..., 1:-1]
    summit = (inner >= values[..., :-2]) & (inner > values[..., 2:])
    summit &= inner > _WORTH * values.max(axis=-1, keepdims=True)
    kind, case, place = np.nonzero(summit)

    def lowness(
        frequency: FloatArray, kind: NDArray[np.intp], case: NDArray[np.intp]
    ) -> FloatArray:
        sizes = _sizes(loop.take(case), frequency[:, np.newaxis])
        return -sizes[kind, np.arange(kind.size), 0]

    if kind.size:  # all in one call, whose rounds cost more than what is done in them
        bracket = [whole[case, place + k] for k in range(3)]
        found = find_minimum(lowness, bracket, args=(kind, case), tolerances={"xrtol": _SHARP})
        rising = np.argsort(-found.f_x)  # of several summits the highest is written last
        size, at = -found.f_x[rising], (kind[rising], case[rising])
        better = found.success[rising] & (size > height[at])
        at = (at[0][better], at[1][better])
        height[at], where[at] = size[better], found.x[rising][better]
    ends = np.asarray(AT_INFINITY)[:, np.newaxis]
    beyond = height <= ends
    return np.stack([np.where(beyond, ends, height), np.where(beyond, np.inf, where)], axis=1)


def _sizes(loop: Rational, omega: FloatArray) -> FloatArray:
    """Sizes of S, T and (S - T)/2 at frequencies ``(k, n)``, ``(3, k, n)``."""
    above, below = loop.parts(omega)
    with np.errstate(invalid="ignore"):  # NaN fills rows of frequencies
        return np.abs(np.stack([below, above, (below - above) / 2.0]) / (below + above))
