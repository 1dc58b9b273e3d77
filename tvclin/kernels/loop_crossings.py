"""Where a loop crosses the negative real axis."""

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.crossings import roots_between
from tvclin.kernels.rational import Rational

FloatArray = NDArray[np.float64]

_AT_CROSSING = 1e-3
"""The phase [rad] that may be left at a crossing; at a jump of the phase more is."""


def phase_crossovers(loop: Rational, omega: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where L is real and negative, and its size there; both ``(k, m)``, filled with NaN.

    Parameters
    ----------
    loop : Rational
        A batch of one axis, ``(k,)``.
    omega : ndarray
        Frequencies [rad/s] that miss no crossing, ``(k, n)``.
    """

    def angle(frequency: FloatArray, index: NDArray[np.intp]) -> FloatArray:
        above, below = loop.take(index).parts(frequency[:, np.newaxis])
        return np.angle(-above * np.conj(below))[:, 0]

    above, below = loop.parts(omega)
    values = np.angle(-above * np.conj(below))
    step = np.diff(values, axis=-1)
    crossing = (values[:, :-1] * values[:, 1:] <= 0.0) & (np.abs(step) < np.pi) & (step != 0.0)
    case, place = np.nonzero(crossing)
    rise = np.sign(step[case, place])
    low, high = omega[case, place], omega[case, place + 1]
    found = roots_between(low, high, lambda w, i: rise[i] * angle(w, case[i]))
    true = np.abs(angle(found, case)) < _AT_CROSSING
    true &= ~loop.take(case).vanishes(found)  # at an undamped pole or zero the phase jumps
    at_zero = loop.numerator[:, -1] * loop.denominator[:, -1] < 0.0
    case = np.concatenate([np.flatnonzero(at_zero), case[true]])
    found = np.concatenate([np.zeros(int(at_zero.sum())), found[true]])
    above, below = loop.take(case).parts(found[:, np.newaxis])
    sizes = np.abs(above / below)[:, 0]
    return _rows(case, found, found, len(omega)), _rows(case, found, sizes, len(omega))


def _rows(case: NDArray[np.intp], key: FloatArray, values: FloatArray, count: int) -> FloatArray:
    """Write the values of each case into its own row, in the order of the key."""
    order = np.lexsort((key, case))
    case, values = case[order], values[order]
    sizes = np.bincount(case, minlength=count)
    place = np.arange(case.size) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    rows = np.full((count, int(sizes.max(initial=0))), np.nan)
    rows[case, place] = values
    return rows
