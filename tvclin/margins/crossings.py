"""Where a loop crosses the negative real axis, and where its sensitivities are largest."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.crossings import roots_between
from tvclin.margins.loop import Loop

FloatArray = NDArray[np.float64]

_WORTH = 0.3
"""Samples that stand above their neighbours are refined if they reach this part of the highest."""
_AT_CROSSING = 1e-3
"""The phase [rad] that may be left at a crossing; at a jump of the phase more is."""


@dataclass(frozen=True, eq=False)
class Peaks:
    """The largest sizes on the imaginary axis and their frequencies [rad/s], each ``(k,)``.

    Attributes
    ----------
    sensitivity, complementary, balanced : tuple of ndarray
        Of S = 1/(1 + L), of T = L/(1 + L), and of (S - T)/2; an infinite frequency means that
        the value is approached there.
    """

    sensitivity: tuple[FloatArray, FloatArray]
    complementary: tuple[FloatArray, FloatArray]
    balanced: tuple[FloatArray, FloatArray]


def phase_crossovers(loop: Loop, omega: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where L is real and negative, and its size there; both ``(k, m)``, filled with NaN.

    Parameters
    ----------
    loop : Loop
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


def peaks(loop: Loop, omega: FloatArray) -> Peaks:
    """Return the peaks of S, T and (S - T)/2, sought between the frequencies.

    Parameters
    ----------
    loop : Loop
        A batch of stable closed loops, ``(k,)``.
    omega : ndarray
        Frequencies [rad/s] that miss no peak, ``(k, n)``.
    """
    whole = np.concatenate([np.zeros((len(omega), 1)), omega], axis=-1)
    return Peaks(
        _largest(loop, whole, 0, 1.0), _largest(loop, whole, 1, 0.0), _largest(loop, whole, 2, 0.5)
    )


def _size(loop: Loop, omega: FloatArray, kind: int) -> FloatArray:
    above, below = loop.parts(omega)
    tops = (below, above, (below - above) / 2.0)
    with np.errstate(invalid="ignore"):  # NaN fills rows of frequencies
        return np.abs(tops[kind] / (below + above))


def _largest(
    loop: Loop, omega: FloatArray, kind: int, at_infinity: float
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
        found = find_minimum(lowness, bracket, args=(case,))
        rising = np.argsort(-found.f_x)  # of several summits the highest is written last
        rising = rising[found.success[rising] & (-found.f_x[rising] > height[case[rising]])]
        height[case[rising]], where[case[rising]] = -found.f_x[rising], found.x[rising]
    beyond = height <= at_infinity
    return np.where(beyond, at_infinity, height), np.where(beyond, np.inf, where)


def _rows(case: NDArray[np.intp], key: FloatArray, values: FloatArray, count: int) -> FloatArray:
    """Write the values of each case into its own row, in the order of the key."""
    order = np.lexsort((key, case))
    case, values = case[order], values[order]
    sizes = np.bincount(case, minlength=count)
    place = np.arange(case.size) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    rows = np.full((count, int(sizes.max(initial=0))), np.nan)
    rows[case, place] = values
    return rows
