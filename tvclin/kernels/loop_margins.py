"""What stability margins are made of: the verdict, every crossing, and the peaks of S and T.

The compiled twin finds crossings from the real roots of polynomials instead of on a grid; both
agree to 1e-12 of a crossing and 1e-9 of a peak. What is so near to the edge of stability that
rounding matters is always left to numpy.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.choice import compiled_twin
from tvclin.kernels.loop_crossings import phase_crossovers
from tvclin.kernels.loop_grid import frequencies
from tvclin.kernels.loop_peaks import peaks
from tvclin.kernels.rational import Rational
from tvclin.kernels.stability import stability

FloatArray = NDArray[np.float64]

_TOGETHER = 256
"""So many loops are worked on at a time, to bound the memory."""
_SECONDS = 5e-4
"""About what numpy takes for crossings and peaks of one loop."""
_HIGHEST = 12
"""The compiled twin trusts the squared polynomials of loops up to this order."""


@dataclass(frozen=True, eq=False)
class LoopCrossings:
    """The verdict on each of ``(k,)`` loops, and where it crosses |L| = 1 and -180 degrees.

    Attributes
    ----------
    unstable_poles, marginal : ndarray
        Closed-loop poles in the right half plane, and whether one lies on the axis.
    gain_frequencies, phases : ndarray
        Where |L| = 1 [rad/s], rising, and how far L may lag more there until it is -1 [rad],
        ``(k, n)``, filled with NaN.
    phase_frequencies, factors : ndarray
        Where L is real and negative [rad/s], rising, and 1/|L| there, ``(k, m)``, filled with NaN.
    """

    unstable_poles: NDArray[np.intp]
    marginal: NDArray[np.bool_]
    gain_frequencies: FloatArray
    phases: FloatArray
    phase_frequencies: FloatArray
    factors: FloatArray


def loop_crossings(loop: Rational) -> LoopCrossings:
    """Return the verdict and all crossings of a batch of one axis, ``(k,)``."""
    twin = _twin(loop)
    if twin is None:
        return _joined([_crossings(part) for part in _chunks(loop)])
    arrays, doubtful = twin.loop_crossings(loop)
    found = LoopCrossings(*arrays)
    if not np.any(doubtful):
        return found
    careful = [_crossings(part) for part in _chunks(loop.take(doubtful))]
    order = np.concatenate([np.flatnonzero(~doubtful), np.flatnonzero(doubtful)])
    return _taken(_joined([_taken(found, ~doubtful), *careful]), np.argsort(order))


def classical_margins(found: LoopCrossings) -> FloatArray:
    """Return the least margins of stable loops and where they are, ``(4, 2, k)``.

    Aero margin and gain increase as factors, phase margin [rad] and delay margin [s]; infinite,
    and their frequencies [rad/s] NaN, where there is none.
    """
    factors, at = found.factors, found.phase_frequencies
    omega, phases = found.gain_frequencies, found.phases
    with np.errstate(divide="ignore"):
        fall = np.where(factors < 1.0, 1.0 / factors, np.nan)
    rise = np.where(factors > 1.0, factors, np.nan)
    late = phases % (2.0 * np.pi) / omega
    pairs = ((fall, at), (rise, at), (np.abs(phases), omega), (late, omega))
    return np.asarray([_least(values, where) for values, where in pairs])


def loop_peaks(loop: Rational) -> FloatArray:
    """Return the peaks of S, T and (S - T)/2 of stable closed loops ``(k,)``, ``(3, 2, k)``.

    Each with its frequency [rad/s], which is infinite where the value is approached there.
    """
    twin = _twin(loop)
    if twin is not None:
        return np.asarray(twin.loop_peaks(loop))
    found = [peaks(part, frequencies(part, stability(part).crossovers)) for part in _chunks(loop)]
    return np.concatenate(found, axis=-1)


def _twin(loop: Rational) -> Any:
    low = loop.denominator.shape[-1] - 1 <= _HIGHEST
    return compiled_twin("loop_margins", _SECONDS * len(loop.delay)) if low else None


def _chunks(loop: Rational) -> Iterator[Rational]:
    size = len(loop.delay)
    for start in range(0, max(size, 1), _TOGETHER):
        yield loop.take(np.arange(start, min(start + _TOGETHER, size)))


def _crossings(loop: Rational) -> LoopCrossings:
    found = stability(loop)
    omega = found.crossovers
    above, below = loop.parts(np.nan_to_num(omega, nan=1.0))
    phases = np.where(np.isnan(omega), np.nan, np.angle(-above * np.conj(below)))
    at, sizes = phase_crossovers(loop, frequencies(loop, omega))
    with np.errstate(divide="ignore"):
        return LoopCrossings(found.unstable_poles, found.marginal, omega, phases, at, 1.0 / sizes)


def _least(values: FloatArray, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The least of each row and its frequency; infinite and NaN in an empty one."""
    if not values.shape[-1]:
        return np.full(len(values), np.inf), np.full(len(values), np.nan)
    filled = np.where(np.isnan(values), np.inf, values)
    place = np.argmin(filled, axis=-1)[:, np.newaxis]
    least, where = (np.take_along_axis(a, place, axis=-1)[:, 0] for a in (filled, at))
    return least, np.where(np.isinf(least), np.nan, where)


def _taken(found: LoopCrossings, index: Any) -> LoopCrossings:
    return LoopCrossings(*(getattr(found, field.name)[index] for field in fields(found)))


def _joined(parts: list[LoopCrossings]) -> LoopCrossings:
    """One out of several, the rows as wide as the widest."""
    whole = []
    for field in fields(LoopCrossings):
        arrays = [getattr(part, field.name) for part in parts]
        if arrays[0].ndim == 2:
            width = max(array.shape[-1] for array in arrays)
            wide = [(0, 0), (0, width)]
            arrays = [np.pad(a, wide, constant_values=np.nan)[:, :width] for a in arrays]
        whole.append(np.concatenate(arrays))
    return LoopCrossings(*whole)
