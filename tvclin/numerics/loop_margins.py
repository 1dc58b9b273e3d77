"""What stability margins are made of: the verdict, every crossing, and the peaks of S and T.

Crossings and peaks are seen between frequencies that miss none, and then refined to rounding. A
loop has the same bits alone and wherever in a batch it stands.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, ComplexArray, FloatArray, IndexArray
from tvclin.numerics.loop_grid import frequencies
from tvclin.numerics.rational import inverse, product
from tvclin.numerics.searches import lowest, roots_between
from tvclin.numerics.stability import stability
from tvclin.numerics.state_loop import AnyLoop

_TOGETHER = 512
"""So many loops are worked on at a time, to bound the memory."""
_AT_CROSSING = 1e-3
"""The phase [rad] that may be left at a crossing; at a jump of the phase more is."""
_CLOSE = 1e-6
"""How far a crossing may be moved when it is polished, over its frequency."""
_WORTH = 0.3
"""Samples that stand above their neighbours are refined if they reach this part of the highest: a
lower one could overtake it only if the grid had missed more than two thirds of its height."""
_ROUNDS = 8
"""Of grids about a summit: its place is known to 6e-8 of the distance of the frequencies beside it,
which is of the order of its width, and so its height to the square of that."""


@dataclass(frozen=True, eq=False)
class LoopFindings:
    """The verdict on each of ``(k,)`` loops, its crossings, and its peaks if it is stable.

    `unstable_poles`, `marginal`: closed-loop poles in the right half plane, and whether one lies on
    the axis. `gain_frequencies`, `phases`: where |L| = 1 [rad/s], rising, and how far L may lag
    more there until it is -1 [rad], ``(k, n)``, filled with NaN. `delays`: how much later L may be
    there until it is -1 [s], ``(k, n)``. `phase_frequencies`, `factors`: where L is real and
    negative [rad/s], rising, and 1/|L| there, ``(k, m)``, filled with NaN. `peaks`: the largest
    |S|, |T| and |S - T|/2 on the axis, and their frequencies [rad/s], infinite where the value is
    approached there, ``(k, 3, 2)``; NaN where the loop is not stable.
    """

    unstable_poles: IndexArray
    marginal: BoolArray
    gain_frequencies: FloatArray
    phases: FloatArray
    delays: FloatArray
    phase_frequencies: FloatArray
    factors: FloatArray
    peaks: FloatArray

    @property
    def stable(self) -> BoolArray:
        """Whether all closed-loop poles lie in the left half plane."""
        return np.asarray((self.unstable_poles == 0) & ~self.marginal)


def loop_findings(loop: AnyLoop) -> LoopFindings:
    """Return the verdict, all crossings and the peaks of a batch of one axis, ``(k,)``."""
    return _joined([_findings(part) for part in _chunks(loop)])


def classical_margins(found: LoopFindings) -> FloatArray:
    """Return the least margins of stable loops and where they are, ``(4, 2, k)``.

    Aero margin and gain increase as factors, phase margin [rad] and delay margin [s]; infinite,
    and their frequencies [rad/s] NaN, where there is none.
    """
    # k L is -1 for k = 1/|L| where L is real and negative: the gain may fall by 1/k where k < 1 and
    # rise to k where k > 1.
    factors, at = found.factors, found.phase_frequencies
    omega, phases = found.gain_frequencies, found.phases
    with np.errstate(divide="ignore"):
        fall = np.where(factors < 1.0, 1.0 / factors, np.nan)
    rise = np.where(factors > 1.0, factors, np.nan)
    pairs = ((fall, at), (rise, at), (np.abs(phases), omega), (found.delays, omega))
    return np.asarray([least_of(values, where) for values, where in pairs])


def _chunks(loop: AnyLoop) -> Iterator[AnyLoop]:
    size = len(loop.delay)
    for start in range(0, max(size, 1), _TOGETHER):
        yield loop.take(np.arange(start, min(start + _TOGETHER, size)))


def _findings(loop: AnyLoop) -> LoopFindings:
    verdict = stability(loop)
    gains = verdict.crossovers
    phases = _left(loop, gains)
    omega = frequencies(loop, verdict)
    omega = np.concatenate([np.zeros((len(omega), 1)), omega], axis=-1)
    parts = loop.parts(omega)
    at, sizes = _phase_crossovers(loop, omega, *parts)
    peaks = np.full((len(omega), 3, 2), np.nan)
    with np.errstate(divide="ignore"):
        # L e^(-j omega T) is -1 where |L| = 1 and omega T = phi + 2 pi n
        delays, factors = phases % (2.0 * np.pi) / gains, 1.0 / sizes
        found = LoopFindings(
            verdict.unstable_poles, verdict.marginal, gains, phases, delays, at, factors, peaks
        )
    good = np.flatnonzero(found.stable)
    peaks[good] = _peaks(loop.take(good), omega[good], *(part[good] for part in parts))
    return found


def _phase_crossovers(
    loop: AnyLoop, omega: FloatArray, above: ComplexArray, below: ComplexArray
) -> tuple[FloatArray, FloatArray]:
    """Where L is real and negative, and its size there; both ``(k, m)``, filled with NaN.

    From zero on, omega ``(k, n)`` misses no crossing; numerator and denominator are values there.
    """

    def angle(frequency: FloatArray, index: IndexArray) -> FloatArray:
        return _angle(*loop.take(index).parts(frequency[:, np.newaxis]))[:, 0]

    side = np.sign(_imaginary(above, below))
    case, place = np.nonzero(side[:, 1:-1] * side[:, 2:] <= 0.0)
    place += 1
    begin, end = (_angle(above[case, k], below[case, k]) for k in (place, place + 1))
    rise = np.sign(end - begin)
    crossing = (begin * end <= 0.0) & (np.abs(end - begin) < np.pi) & (rise != 0.0)
    case, place, rise = case[crossing], place[crossing], rise[crossing]
    low, high = omega[case, place], omega[case, place + 1]
    found = roots_between(low, high, lambda w, i: rise[i] * angle(w, case[i]))
    true = np.abs(angle(found, case)) < _AT_CROSSING
    true &= ~loop.take(case).vanishes(found)  # at an undamped pole or zero the phase jumps
    case, found = case[true], found[true]
    found = _polished(loop.take(case), found)
    # L(0) = N(0)/D(0) is a crossing that no change of sign shows; and so is L at infinity.
    at_zero = np.flatnonzero(above[:, 0].real * below[:, 0].real < 0.0)
    at_infinity = np.flatnonzero(loop.direct < 0.0)
    case = np.concatenate([at_zero, case])
    found = np.concatenate([np.zeros(at_zero.size), found])
    above, below = loop.take(case).undelayed(found[:, np.newaxis])
    sizes = np.concatenate([np.abs(above / below)[:, 0], -loop.direct[at_infinity]])
    case = np.concatenate([case, at_infinity])
    found = np.concatenate([found, np.full(at_infinity.size, np.inf)])
    return _rows(case, found, found, len(omega)), _rows(case, found, sizes, len(omega))


def _left(loop: AnyLoop, omega: FloatArray) -> FloatArray:
    """How far L may lag more [rad] until it is real and negative, at a few frequencies ``(k, m)``.

    Of values that are solved for: a sum over poles has the rounding of its largest terms.
    """
    above, below = loop.undelayed(omega)
    return _angle(product(above, np.exp(-1j * omega * loop.delay[:, np.newaxis])), below)


def _polished(loop: AnyLoop, omega: FloatArray) -> FloatArray:
    """One step of Newton's to where L is real, from frequencies ``(k,)`` that lack a rounding."""
    omega = omega[:, np.newaxis]
    with np.errstate(all="ignore"):
        turn = loop.log_slope(omega).imag - loop.delay[:, np.newaxis]
        step = _left(loop, omega) / turn
        close = np.abs(step) <= _CLOSE * omega
    return np.where(close, omega - step, omega)[:, 0]


def _imaginary(above: ComplexArray, below: ComplexArray) -> FloatArray:
    """Im(-N conj(D)), in real products, which round alike in a batch of any shape."""
    return above.real * below.imag - above.imag * below.real


def _angle(above: ComplexArray, below: ComplexArray) -> FloatArray:
    """How far N/D may lag more [rad] until it is real and negative: arg(-N conj(D))."""
    real = -(above.real * below.real + above.imag * below.imag)
    return np.arctan2(_imaginary(above, below), real)


def _peaks(
    loop: AnyLoop, omega: FloatArray, above: ComplexArray, below: ComplexArray
) -> FloatArray:
    """The peaks of stable closed loops, ``(k, 3, 2)``.

    From zero on, omega ``(k, n)`` misses no peak; numerator and denominator are values there.
    """
    values = np.stack(_sizes(above, below), axis=1)
    values = np.nan_to_num(values, nan=-np.inf, copy=False)
    top = np.argmax(values, axis=-1)
    height = values.max(axis=-1)
    where = omega[np.arange(len(omega))[:, np.newaxis], top]
    inner = values[..., 1:-1]
    summit = (inner >= values[..., :-2]) & (inner > values[..., 2:])
    summit &= inner > _WORTH * height[..., np.newaxis]
    case, kind, place = np.nonzero(summit)

    if kind.size:
        some = loop.take(case)

        def lowness(frequency: FloatArray) -> FloatArray:
            return -np.choose(kind[:, np.newaxis], _sizes(*some.parts(frequency)))

        at, least = lowest(lowness, omega[case, place], omega[case, place + 2], _ROUNDS)
        rising = np.argsort(-least)  # of several summits the highest is written last
        at, size, which = at[rising], -least[rising], (case[rising], kind[rising])
        better = size > height[which]
        which = (which[0][better], which[1][better])
        height[which], where[which] = size[better], at[better]
    direct = loop.direct[:, np.newaxis]
    at_infinity = np.abs(np.concatenate([np.ones_like(direct), direct, 0.5 * (1.0 - direct)], -1))
    at_infinity /= np.abs(1.0 + direct)  # |S|, |T| and |S - T|/2
    beyond = height <= at_infinity
    pair = [np.where(beyond, at_infinity, height), np.where(beyond, np.inf, where)]
    return np.stack(pair, axis=-1)


def _sizes(above: ComplexArray, below: ComplexArray) -> list[FloatArray]:
    """The sizes of S = 1/(1 + L) = D/(D + N), T = L/(1 + L) = N/(D + N) and (S - T)/2.

    One over the largest of the last is the disk margin: L f is stable for all f in the disk
    (1 + d/2)/(1 - d/2), |d| < alpha, exactly if alpha |S - T|/2 < 1 everywhere.
    """
    over = inverse(below + above)
    S, T = product(below, over), product(above, over)
    return [np.sqrt(of.real**2 + of.imag**2) for of in (S, T, 0.5 * (S - T))]


def _rows(case: IndexArray, key: FloatArray, values: FloatArray, count: int) -> FloatArray:
    """Write the values of each case into its own row, in the order of the key."""
    order = np.lexsort((key, case))
    case, values = case[order], values[order]
    sizes = np.bincount(case, minlength=count)
    place = np.arange(case.size) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    rows = np.full((count, int(sizes.max(initial=0))), np.nan)
    rows[case, place] = values
    return rows


def least_of(values: FloatArray, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the least of each row and its frequency; infinite and NaN in an empty one."""
    if not values.shape[-1]:
        return np.full(len(values), np.inf), np.full(len(values), np.nan)
    filled = np.where(np.isnan(values), np.inf, values)
    place = np.argmin(filled, axis=-1)[:, np.newaxis]
    found, where = (np.take_along_axis(a, place, axis=-1)[:, 0] for a in (filled, at))
    return found, np.where(np.isinf(found), np.nan, where)


def _joined(parts: list[LoopFindings]) -> LoopFindings:
    """One out of several, the rows as wide as the widest."""
    whole: list[AnyArray] = []
    for field in fields(LoopFindings):
        arrays = [getattr(part, field.name) for part in parts]
        if arrays[0].ndim == 2:
            width = max(array.shape[-1] for array in arrays)
            wide = [(0, 0), (0, width)]
            arrays = [np.pad(a, wide, constant_values=np.nan)[:, :width] for a in arrays]
        whole.append(np.concatenate(arrays))
    return LoopFindings(*whole)
