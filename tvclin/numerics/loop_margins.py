"""Stability of closed loops with their delay exact, all crossovers, and the peaks of S and T.

Without the delay T the closed-loop poles are known. As a delay grows from zero, poles can cross the
imaginary axis only at the frequencies at which |L| = 1, whatever the delay; they cross each time
the phase comes round to -180 degrees, to the right where |L| falls with the frequency and to the
left where it rises. So they can be counted (after Walton and Marshall, IEE Proceedings D 134,
1987): no approximation of the delay enters the verdict.

Crossovers and peaks are bracketed on a frequency grid that misses none, and then refined to
rounding, so that no result depends on the grid. A loop has the same bits alone and in any batch.
"""

from dataclasses import dataclass, fields

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, ComplexArray, FloatArray, IndexArray
from tvclin.numerics.loops import AnyLoop, inverse, product
from tvclin.numerics.searches import grid_minimum, roots_between

_AXIS_TOLERANCE = 1e-12
"""Distance from the imaginary axis, relative to the largest pole, that counts as zero."""
_FULL_TURN = 2.0 * np.pi
"""Phase of a full turn [rad]."""
_PHASE_ROUNDING = 1e-6
"""Phase [rad] below which a pole starts on the imaginary axis, to rounding."""
_MAX_POLES = 1e15
"""Largest count of unstable poles."""
_POLISHING_ITERATIONS, _MAX_POLISHING_STEP = 4, 1e-6
"""Newton iterations on ln |L| from a root of the squares, and the largest relative step."""
_LOGARITHMIC_POINTS = 401
"""Logarithmically spaced frequencies over the whole range."""
_LOW_OVER_SMALLEST_ROOT, _HIGH_OVER_LARGEST_ROOT = 1e-3, 1e2
"""Ends of the frequency range over the smallest and over the largest pole or zero."""
_ROOT_OFFSETS = np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.5, 5.0])
"""Offsets of frequencies around a root, in units of its distance from the imaginary axis."""
_MIN_AXIS_DISTANCE = 1e-6
"""Smallest distance from the axis, over the size of a root, by which points are spread."""
_MAX_ZERO_OVER_POLE, _MIN_ROOT_OVER_POLE = 1e7, 1e-12
"""Zeros above and roots below these ratios to the fastest pole are rounding."""
_REAL_FREQUENCY_OFFSET = 1e-3
"""Relative offset of the points on both sides of a frequency at which L is real."""
_MIN_SPACING = 1e-11
"""Relative spacing that separates equal frequencies, so that each has two neighbours."""
_NEGLIGIBLE_GAIN, _END_OVER_POLE_BOUND = 1e-2, 2.0
"""The phase of a delay is followed until |L| stays below the first, and at least up to the second
times the bound of the poles of L."""
_PHASE_STEP, _ADDED_STEPS, _MAX_STEPS = np.pi / 4.0, 12, 20_000
"""Step of the delay's phase [rad], number of steps added at the end, and their largest number."""
_LOOPS_PER_BLOCK = 512
"""Loops that are analysed together, to bound the memory."""
_CROSSING_PHASE_TOLERANCE = 1e-3
"""Phase [rad] remaining at a phase crossover; at a jump of the phase it is larger."""
_MAX_CROSSOVER_CORRECTION = 1e-6
"""Largest correction of a phase crossover by a Newton step, over its frequency."""
_CANDIDATE_PEAK_HEIGHT = 0.3
"""Height of local maxima of the grid that are refined, relative to the highest: a lower one could
exceed it only if the grid had missed more than two thirds of its height."""
PEAK_REFINEMENTS = 4
"""Grid refinements about a smooth peak: with a last parabola its frequency is known to 6e-8 of the
distance of its neighbours, of the order of its width, and its height to the square of that."""


@dataclass(frozen=True, eq=False)
class Stability:
    """Closed-loop poles, their stability, and the gain crossovers of a batch of loops.

    `poles`: the closed-loop poles without the delay, ``(..., n)``. `unstable_poles`: closed-loop
    poles in the right half plane, ``(...)``. `marginal`: whether one lies on the imaginary axis,
    ``(...)``. `crossovers`: frequencies [rad/s] at which |L| = 1, ascending, ``(..., k)``, filled
    with NaN.
    """

    poles: AnyArray
    unstable_poles: IndexArray
    marginal: BoolArray
    crossovers: FloatArray


def stability(loop: AnyLoop) -> Stability:
    """Return the number of unstable closed-loop poles with the delay, and the gain crossovers.

    `loop`: a batch of loops L(s) ``(...)``, closed by 1 + L = 0.

    The count begins with the closed-loop poles without the delay T. As T grows a pair crosses the
    imaginary axis at each frequency omega with |L| = 1, when omega T comes to the phase lag of L to
    -1 plus full turns: to the right where |L| falls with the frequency, else to the left.
    """
    poles = loop.closed_poles()
    tolerance = _AXIS_TOLERANCE * np.abs(poles).max(axis=-1, keepdims=True)
    unstable = np.sum(np.real(poles) > tolerance, axis=-1)
    on_axis = np.abs(np.real(poles)) <= tolerance
    at_origin = np.any(on_axis & (np.abs(poles) <= tolerance), axis=-1)
    # whether |L| falls at each gain crossover, where poles cross to the right
    frequencies, to_right = loop.crossovers(1.0)
    frequencies = _polished_gain_crossover(loop, frequencies)
    N, D = loop.undelayed(frequencies)
    with np.errstate(invalid="ignore"):
        phase = np.angle(-N / D) % _FULL_TURN  # lag of a delay that brings L to -1
        starts_on_axis = (phase < _PHASE_ROUNDING) | (phase > _FULL_TURN - _PHASE_ROUNDING)
        phase = np.where(
            starts_on_axis, _initial_phase_to_axis(poles, tolerance, frequencies, to_right), phase
        )
        # number of times, with a fraction, that poles have crossed at a frequency up to the delay
        crossings_due = (frequencies * loop.delay[..., np.newaxis] - phase) / _FULL_TURN
        crossings = np.maximum(np.ceil(crossings_due), 0.0)
        at_crossing = (np.abs(crossings_due - np.round(crossings_due)) < _AXIS_TOLERANCE) & (
            crossings_due > -_AXIS_TOLERANCE
        )
    added = np.nansum(np.where(to_right, 2.0, -2.0) * crossings, axis=-1)  # in conjugate pairs
    added = np.clip(added, -_MAX_POLES, _MAX_POLES)
    delayed = loop.delay > 0.0
    at_axis = np.where(delayed, np.any(at_crossing, axis=-1), np.any(on_axis, axis=-1))
    count = unstable + np.where(delayed, added, 0.0).astype(np.intp)
    return Stability(
        poles=poles,
        unstable_poles=np.asarray(count),
        marginal=np.asarray(at_origin | at_axis),
        crossovers=frequencies,
    )


def _initial_phase_to_axis(
    poles: AnyArray, tolerance: FloatArray, omega: FloatArray, to_right: BoolArray
) -> FloatArray:
    """Return the lag of a delay [rad] at which poles at the axis first cross it, 0 or 2 pi.

    As the delay grows, a pole crosses in one direction each time that the lag, omega times delay,
    has grown by 2 pi: the first time at once if it starts on the other side, else after a turn. A
    pole on the axis counts as left. `poles`: closed-loop poles without the delay [1/s], ``(...,
    n)``. `tolerance`: distance from the axis that is zero, ``(..., 1)``. `omega`, `to_right`: gain
    crossovers [rad/s], and whether poles cross to the right there, ``(..., k)`` as the result.
    """
    distance = np.abs(poles[..., np.newaxis, :] - 1j * omega[..., np.newaxis])
    # the closed-loop pole nearest to j omega, of each crossover
    nearest = np.argmin(np.nan_to_num(distance, nan=np.inf), axis=-1)
    right = np.take_along_axis(np.real(poles) > tolerance, nearest, axis=-1)
    return np.where(right != to_right, 0.0, _FULL_TURN)


def _polished_gain_crossover(loop: AnyLoop, omega: FloatArray) -> FloatArray:
    """Return gain crossovers ``(..., k)`` [rad/s] after Newton's steps on ln |L|.

    `loop`: a batch of loops L(s). `omega`: estimates ``(..., k)``, from the squared magnitude,
    which have half the digits near undamped poles.
    """
    with np.errstate(all="ignore"):
        for _ in range(_POLISHING_ITERATIONS):
            N, D = loop.undelayed(omega)
            step = np.log(np.abs(N / D)) / loop.log_slope(omega).real
            omega = np.where(np.abs(step) <= _MAX_POLISHING_STEP * omega, omega - step, omega)
    return omega


def grid_frequencies(loop: AnyLoop, stability: Stability) -> FloatArray:
    """Return frequencies [rad/s] that bracket crossovers and peaks of L, ``(k, m)``, NaN-filled.

    Positive and ascending: over the whole range, dense around poles and zeros, and in steps of the
    phase of a delay. `loop`: k loops L(s). `stability`: their closed-loop poles and gain
    crossovers.
    """
    poles = [stability.poles.astype(complex), loop.open_poles().astype(complex)]
    fastest = np.abs(np.concatenate(poles, axis=-1)).max(axis=-1)[:, np.newaxis]
    zeros = loop.zeros()
    with np.errstate(invalid="ignore"):
        zeros = np.where(np.abs(zeros) < _MAX_ZERO_OVER_POLE * fastest, zeros, np.nan)
    roots = np.concatenate([*poles, zeros], axis=-1)
    roots = np.where(roots.imag >= 0.0, roots, np.nan)  # one of each pair
    size = np.abs(roots)
    largest = np.nan_to_num(size).max(axis=-1)
    counted = size > _MIN_ROOT_OVER_POLE * fastest
    low = _LOW_OVER_SMALLEST_ROOT * np.where(counted, size, np.inf).min(axis=-1)
    low = np.where(np.isfinite(low), low, 1e-3)  # [rad/s], without a root other than zero
    high = np.maximum(_HIGH_OVER_LARGEST_ROOT * largest, 1e3 * low)
    steps = np.geomspace(low, high, _LOGARITHMIC_POINTS, axis=-1)
    width = np.maximum(np.abs(roots.real), _MIN_AXIS_DISTANCE * size)
    offsets = np.concatenate([-_ROOT_OFFSETS[:0:-1], _ROOT_OFFSETS])
    around = np.abs(roots.imag)[..., np.newaxis] + width[..., np.newaxis] * offsets
    real_frequencies = loop.real_frequencies()  # where L is real: candidates of crossovers
    parts = [
        steps,
        around.reshape(len(around), roots.shape[-1] * offsets.size),
        stability.crossovers,
        real_frequencies * (1.0 - _REAL_FREQUENCY_OFFSET),
        real_frequencies * (1.0 + _REAL_FREQUENCY_OFFSET),
    ]
    if np.any(loop.delay > 0.0):
        delay_points, end = _delay_frequencies(loop)  # beyond the end |L| is small
        parts = [
            *(np.where(part <= end[:, np.newaxis], part, np.nan) for part in parts),
            delay_points,
        ]
    points = np.concatenate(parts, axis=-1)
    bounded = (points >= low[:, np.newaxis]) & np.isfinite(points)
    points = np.sort(np.where(bounded, points, np.nan), axis=-1)
    # equal points are moved apart
    return points * (1.0 + _MIN_SPACING * np.arange(points.shape[-1]))


def _delay_frequencies(loop: AnyLoop) -> tuple[FloatArray, FloatArray]:
    """Return frequencies ``(k, m)`` [rad/s] in even steps of an eighth of a turn of the delay.

    The second result is their end ``(k,)`` [rad/s], beyond all poles and crossings of a small gain,
    so that |L| is negligible above. For a loop without delay it is infinite, and the frequencies
    are NaN. `loop`: a batch of k loops.
    """
    delayed = loop.delay > 0.0
    step = _PHASE_STEP / np.where(delayed, loop.delay, 1.0)  # [rad/s]
    frequencies, _ = loop.crossovers(_NEGLIGIBLE_GAIN)
    last = np.nan_to_num(frequencies).max(axis=-1, initial=0.0)
    end = np.maximum(last, _END_OVER_POLE_BOUND * loop.bound())
    count = np.minimum(np.ceil(end / step) + _ADDED_STEPS, _MAX_STEPS)
    index = np.arange(int(count[delayed].max(initial=0.0)) + 1)
    used = delayed[:, np.newaxis] & (index <= count[:, np.newaxis])
    steps = np.where(used, index * step[:, np.newaxis], np.nan)
    return steps, np.where(delayed, count * step, np.inf)


@dataclass(frozen=True, eq=False)
class LoopAnalysis:
    """Stability, crossovers, and closed-loop peaks of ``(k,)`` loops.

    `unstable_poles`, `marginal`: number of closed-loop poles in the right half plane, and whether
    one lies on the imaginary axis. `gain_frequencies`, `phases`: frequencies [rad/s] with |L| = 1,
    ascending, and the phase lag [rad] to -1 there, ``(k, n)``, filled with NaN. `delays`:
    additional delay [s] to -1 there, ``(k, n)``. `phase_frequencies`, `factors`: frequencies
    [rad/s] at which L is real and negative, ascending, and 1/|L| there, ``(k, m)``, filled with
    NaN. `peaks`: maxima of |S|, |T| and |S - T|/2 on the imaginary axis, and their frequencies
    [rad/s], infinite where the supremum is approached there, ``(k, 3, 2)``; NaN for an unstable
    loop.
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
        """Whether all closed-loop poles lie in the left half plane, ``(k,)``."""
        return np.asarray((self.unstable_poles == 0) & ~self.marginal)


def analyse_loops(loop: AnyLoop) -> LoopAnalysis:
    """Return stability, crossovers and peaks of a batch of loops ``(k,)``, in blocks for memory.

    Rows of crossovers have one width for all blocks, filled with NaN.
    """
    starts = range(0, max(len(loop.delay), 1), _LOOPS_PER_BLOCK)
    blocks = [_block_analysis(loop.take(slice(k, k + _LOOPS_PER_BLOCK))) for k in starts]
    joined: list[AnyArray] = []
    for field in fields(LoopAnalysis):
        arrays = [getattr(block, field.name) for block in blocks]
        if arrays[0].ndim == 2:
            width = max(array.shape[-1] for array in arrays)
            padding = [(0, 0), (0, width)]
            # padded by more than enough, then cut
            arrays = [np.pad(a, padding, constant_values=np.nan)[:, :width] for a in arrays]
        joined.append(np.concatenate(arrays))
    return LoopAnalysis(*joined)


def classical_margins(analysis: LoopAnalysis) -> FloatArray:
    """Return the smallest margins of stable loops and their frequencies [rad/s], ``(4, 2, k)``.

    Aero margin (gain reduction) and gain increase are factors, then phase [rad] and delay margin
    [s]; infinite without a crossover, with the frequency NaN. `analysis`: crossovers of k loops.
    """
    # k L is -1 for k = 1/|L| where L is real and negative: the gain may fall by 1/k where k < 1 and
    # rise to k where k > 1.
    factors, frequencies = analysis.factors, analysis.phase_frequencies
    omega, phases = analysis.gain_frequencies, analysis.phases
    with np.errstate(divide="ignore"):
        fall = np.where(factors < 1.0, 1.0 / factors, np.nan)
    rise = np.where(factors > 1.0, factors, np.nan)
    pairs = (
        (fall, frequencies),
        (rise, frequencies),
        (np.abs(phases), omega),
        (analysis.delays, omega),
    )
    return np.asarray([row_minimum(values, where) for values, where in pairs])


def _block_analysis(loop: AnyLoop) -> LoopAnalysis:
    """Return stability, crossovers and closed-loop peaks of the k loops of one block."""
    verdict = stability(loop)
    gain_frequencies = verdict.crossovers
    phases = _remaining_lag(loop, gain_frequencies)
    omega = grid_frequencies(loop, verdict)
    omega = np.concatenate([np.zeros((len(omega), 1)), omega], axis=-1)
    parts = loop.parts(omega)  # numerator and denominator of L, with its delay
    phase_frequencies, sizes = _phase_crossovers(loop, omega, *parts)  # [rad/s], and |L| there
    peaks = np.full((len(omega), 3, 2), np.nan)  # of |S|, |T| and |S - T|/2: height, frequency
    with np.errstate(divide="ignore"):
        # L e^(-j omega T) is -1 where |L| = 1 and omega T is the phase lag to -1, plus full turns
        delays, factors = phases % (2.0 * np.pi) / gain_frequencies, 1.0 / sizes
        analysis = LoopAnalysis(
            unstable_poles=verdict.unstable_poles,
            marginal=verdict.marginal,
            gain_frequencies=gain_frequencies,
            phases=phases,
            delays=delays,
            phase_frequencies=phase_frequencies,
            factors=factors,
            peaks=peaks,
        )
    stable = np.flatnonzero(analysis.stable)
    # into the array that `analysis` holds; peaks of unstable loops stay NaN
    peaks[stable] = _closed_loop_peaks(
        loop.take(stable), omega[stable], *(part[stable] for part in parts)
    )
    return analysis


def _phase_crossovers(
    loop: AnyLoop, omega: FloatArray, N: ComplexArray, D: ComplexArray
) -> tuple[FloatArray, FloatArray]:
    """Return the frequencies [rad/s] at which L is real and negative, and |L| there, ``(k, m)``.

    Both are filled with NaN. `loop`: k loops L(s). `omega`: grid of frequencies from zero on, ``(k,
    n)`` [rad/s]. `N`, `D`: numerator and denominator of L on it, ``(k, n)``. A sign change of Im L
    between two points of the grid is a crossover where the phase lag to -1 passes through zero
    there and does not jump. Frequency zero and infinity are crossovers where L is negative there.
    """

    def angle(frequency: FloatArray, index: IndexArray) -> FloatArray:
        """Return the phase lag [rad] of L to the negative real axis, of the loops at `index`."""
        return _lag_to_real_axis(*loop.take(index).parts(frequency[:, np.newaxis]))[:, 0]

    sign = np.sign(_imaginary(N, D))
    case, index = np.nonzero(sign[:, 1:-1] * sign[:, 2:] <= 0.0)
    index += 1
    start, end = (_lag_to_real_axis(N[case, k], D[case, k]) for k in (index, index + 1))
    rise = np.sign(end - start)
    crossing = (start * end <= 0.0) & (np.abs(end - start) < np.pi) & (rise != 0.0)
    case, index, rise = case[crossing], index[crossing], rise[crossing]
    low, high = omega[case, index], omega[case, index + 1]
    crossover = roots_between(low, high, lambda w, i: rise[i] * angle(w, case[i]))
    genuine = np.abs(angle(crossover, case)) < _CROSSING_PHASE_TOLERANCE
    genuine &= ~loop.take(case).is_pole_or_zero(crossover)  # the phase jumps at an undamped one
    case, crossover = case[genuine], crossover[genuine]
    crossover = _polished_phase_crossover(loop.take(case), crossover)
    # L(0) = N(0)/D(0) is a crossing that no change of sign shows; and so is L at infinity.
    at_zero = np.flatnonzero(N[:, 0].real * D[:, 0].real < 0.0)
    at_infinity = np.flatnonzero(loop.direct < 0.0)
    case = np.concatenate([at_zero, case])
    crossover = np.concatenate([np.zeros(at_zero.size), crossover])
    N, D = loop.take(case).undelayed(crossover[:, np.newaxis])
    sizes = np.concatenate([np.abs(N / D)[:, 0], -loop.direct[at_infinity]])
    case = np.concatenate([case, at_infinity])
    crossover = np.concatenate([crossover, np.full(at_infinity.size, np.inf)])
    # a row for each loop, in the order of the frequencies
    return _rows(case, crossover, crossover, len(omega)), _rows(case, crossover, sizes, len(omega))


def _remaining_lag(loop: AnyLoop, omega: FloatArray) -> FloatArray:
    """Return the phase lag ``(k, m)`` [rad] until L, with its delay, is real and negative.

    `loop`: k loops. `omega`: frequencies ``(k, m)`` [rad/s]. The values come from linear solves: a
    sum over poles has the rounding of its largest terms.
    """
    N, D = loop.undelayed(omega)
    return _lag_to_real_axis(product(N, np.exp(-1j * omega * loop.delay[:, np.newaxis])), D)


def _polished_phase_crossover(loop: AnyLoop, omega: FloatArray) -> FloatArray:
    """Return phase crossovers ``(k,)`` [rad/s], where L is real and negative, by one Newton step.

    `loop`: k loops. `omega`: an estimate for each, ``(k,)``.
    """
    omega = omega[:, np.newaxis]
    with np.errstate(all="ignore"):
        phase_slope = loop.log_slope(omega).imag - loop.delay[:, np.newaxis]
        step = _remaining_lag(loop, omega) / phase_slope
        close = np.abs(step) <= _MAX_CROSSOVER_CORRECTION * omega
    return np.where(close, omega - step, omega)[:, 0]


def _imaginary(N: ComplexArray, D: ComplexArray) -> FloatArray:
    """Return Im(-N conj(D)) of numerators N and denominators D, of one shape.

    It has the sign of Im(-N/D). In real products, which round alike in a batch of any shape.
    """
    return N.real * D.imag - N.imag * D.real


def _lag_to_real_axis(N: ComplexArray, D: ComplexArray) -> FloatArray:
    """Return the phase lag [rad] until N/D is real and negative: arg(-N conj(D))."""
    real = -(N.real * D.real + N.imag * D.imag)
    return np.arctan2(_imaginary(N, D), real)  # of -N conj(D), as `real`


def _closed_loop_peaks(
    loop: AnyLoop, omega: FloatArray, N: ComplexArray, D: ComplexArray
) -> FloatArray:
    """Return the maxima of |S|, |T| and |S - T|/2 and their frequencies [rad/s], ``(k, 3, 2)``.

    S = 1/(1 + L) = D/(D + N) and T = N/(D + N) for L = N/D. The inverse of the maximum of |S - T|/2
    is the disk margin alpha: L f is stable for all f in the disk (1 + d/2)/(1 - d/2), |d| < alpha,
    exactly if alpha |S - T|/2 < 1 everywhere. `loop`: k stable loops L. `omega`: grid of
    frequencies from zero on, ``(k, n)`` [rad/s]. `N`, `D`: numerator and denominator on it, ``(k,
    n)``. Local maxima of the grid that may be the highest are refined, and compared with the values
    at infinity, where L is its direct term.
    """
    inverse_return = inverse(D + N)
    sizes = [_size(product(numerator, inverse_return)) for numerator in _numerators(N, D)]
    values = np.stack(sizes, axis=1)
    values = np.nan_to_num(values, nan=-np.inf, copy=False)
    top = np.argmax(values, axis=-1)
    height = values.max(axis=-1)
    where = omega[np.arange(len(omega))[:, np.newaxis], top]
    inner = values[..., 1:-1]
    summit = (inner >= values[..., :-2]) & (inner > values[..., 2:])
    summit &= inner > _CANDIDATE_PEAK_HEIGHT * height[..., np.newaxis]
    case, kind, index = np.nonzero(summit)

    if kind.size:
        candidates = loop.take(case)

        def lowness(frequency: FloatArray) -> FloatArray:
            """Return minus the size of S, T or (S - T)/2, by `kind`, of s candidates, ``(s, m)``.

            `frequency`: m frequencies [rad/s] of each.
            """
            N, D = candidates.parts(frequency)
            selected = np.choose(kind[:, np.newaxis], _numerators(N, D))
            return -_size(product(selected, inverse(D + N)))

        at, minimum = grid_minimum(
            lowness, omega[case, index], omega[case, index + 2], PEAK_REFINEMENTS, smooth=True
        )
        rising = np.argsort(-minimum)  # of several summits the highest is written last
        # entry: loop and kind (0, 1, 2 of S, T, (S - T)/2) of each summit
        at, size, entry = at[rising], -minimum[rising], (case[rising], kind[rising])
        better = size > height[entry]
        entry = (entry[0][better], entry[1][better])
        height[entry], where[entry] = size[better], at[better]
    direct = loop.direct[:, np.newaxis]
    at_infinity = np.abs(np.concatenate([np.ones_like(direct), direct, 0.5 * (1.0 - direct)], -1))
    at_infinity /= np.abs(1.0 + direct)  # |S|, |T| and |S - T|/2
    beyond = height <= at_infinity
    pair = [np.where(beyond, at_infinity, height), np.where(beyond, np.inf, where)]
    return np.stack(pair, axis=-1)


def _numerators(N: ComplexArray, D: ComplexArray) -> tuple[ComplexArray, ...]:
    """Return the numerators D, N and (D - N)/2 of S, T and (S - T)/2 over D + N, for L = N/D."""
    return D, N, 0.5 * (D - N)


def _size(values: ComplexArray) -> FloatArray:
    """Return absolute values of complex numbers, in real arithmetic.

    The complex functions of numpy round differently by position in memory.
    """
    return np.sqrt(values.real**2 + values.imag**2)


def _rows(case: IndexArray, key: FloatArray, values: FloatArray, count: int) -> FloatArray:
    """Return values scattered into one row per case, in ascending order of the key, NaN-filled.

    `case`: row of each of m values, ``(m,)``. `key`, `values`: ``(m,)``. `count`: number of rows.
    """
    order = np.lexsort((key, case))
    case, values = case[order], values[order]
    sizes = np.bincount(case, minlength=count)
    column = np.arange(case.size) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    rows = np.full((count, int(sizes.max(initial=0))), np.nan)
    rows[case, column] = values
    return rows


def row_minimum(values: FloatArray, frequencies: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the minimum of each row ``(k,)`` and its frequency; infinity and NaN for an empty row.

    `values`, `frequencies`: of k loops at m frequencies, ``(k, m)``; NaN is no value.
    """
    if not values.shape[-1]:
        return np.full(len(values), np.inf), np.full(len(values), np.nan)
    filled = np.where(np.isnan(values), np.inf, values)
    index = np.argmin(filled, axis=-1)[:, np.newaxis]
    minimum, frequency = (
        np.take_along_axis(a, index, axis=-1)[:, 0] for a in (filled, frequencies)
    )
    return minimum, np.where(np.isinf(minimum), np.nan, frequency)
