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
    whole = np.concatenate([np.zeros((len(omega), 1)), omega], axis=-1)
    ends = enumerate(AT_INFINITY)
    return np.asarray([_largest(loop, whole, kind, end) for kind, end in ends])


def _size(loop: Rational, omega: FloatArray, kind: int) -> FloatArray:
    above, below = loop.parts(omega)
    tops = (below, above, (below - above) / 2.0)
    with np.errstate(invalid="ignore"):  # NaN fills rows of frequencies
        return np.abs(tops[kind] / (below + above))


def _largest(
    loop: Rational, omega: FloatArray, kind: int, at_infinity: float
) -> tuple[FloatArray, FloatArray]:
    from scipy.optimize.elementwise import find_minimum  # late: it takes 0.3 s to import

    values = np.nan_to_num(_size(loop, omega, kind), nan=-np.inf)
    inner = values[:, 1:-1]
    summit = (inner >= values[:, :-2]) & (inner > values[:, 2:])
    summit &= inner > _WORTH * values.max(axis=-1, keepdims=True)
    case, place = np.nonzero(summit)
    place = place + 1

    def lowness(frequency: FloatArray, index: NDArray[np.intp]) -> FloatArray:
        return -_size(loop.take(index), frequency[:, np.newaxis], kind)[:, 0]

    top = np.argmax(values, axis=-1)[:, np.newaxis]
    height, where = (np.take_along_axis(a, top, axis=-1)[:, 0] for a in (values, omega))
    if case.size:
        bracket = [omega[case, place + k] for k in (-1, 0, 1)]
        found = find_minimum(lowness, bracket, args=(case,), tolerances={"xrtol": _SHARP})
        rising = np.argsort(-found.f_x)  # of several summits the highest is written last
        rising = rising[found.success[rising] & (-found.f_x[rising] > height[case[rising]])]
        height[case[rising]], where[case[rising]] = -found.f_x[rising], found.x[rising]
    beyond = height <= at_infinity
    return np.where(beyond, at_infinity, height), np.where(beyond, np.inf, where)
