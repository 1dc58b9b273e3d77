"""Linear systems driven by pieces, propagated exactly between knots by matrix exponentials.

A piece is itself the free motion of a small system, one Jordan block for each of its rates. With
its states z appended to the states x, the whole is a free motion,

    d/du [x, z] = M [x, z],    the input being the sum of the first z of each block,

so that nothing is discretised, and repeated poles are no special case. `peak_output` finds the
largest output of such a motion between its samples.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import factorial, hypot, log2

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IndexArray
from tvclin.base.errors import InputError
from tvclin.numerics.pieces import Pieces, locate, recentred

_AXES_OF_MATRICES = 3
"""Axes of an array ``(m, n, n)`` of matrices."""
_MAX_SERIES_NORM = 0.5
"""Norm up to which the exponential series is used, with terms up to the 15th power: 0.5^16/16! is
below 1e-18."""
_MATRICES_PER_BLOCK = 256
"""Exponentials that are computed together, so that they stay in the cache."""
_SERIES_BLOCK = 4
"""Terms of the series that are added before a product with the fourth power of the matrix."""
_BALANCING_SWEEPS, _WORTH_SCALING = 50, 0.95
"""Sweeps over rows and columns at most, and the sum of two norms after a scaling over that before
it, from which on it is not worth it."""
_STEPS_PER_BLOCK = 128
"""Equal steps in a block of samples, a power of two; the step may double between blocks."""
_FIRST_STEP, _MAX_STEP = 0.1, 0.4
"""First and largest step, times the fastest eigenvalue that has not decayed."""
_DECAY_EXPONENT = 40.0
"""Exponent at which a mode has decayed: e^-40."""
_SUMMIT_TOLERANCE = 1e-3
"""Relative height below the highest sample from which a cubic's summit is a candidate."""
_SUMMIT_ITERATIONS = 5
"""Newton iterations from the summit of a cubic to the zero of the slope."""
_PIECES_PER_BLOCK = 2048
"""Pieces that are searched together, to bound the memory."""
_RELATIVE_ROUNDING = 1e-13
"""Rounding of an output, relative to the sum of the sizes of its terms."""


GAUSS_NODES = 0.5 - np.sqrt(3.0) / 6.0, 0.5 + np.sqrt(3.0) / 6.0
"""Gauss points of a step, as fractions of it."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of a linear system with one input history.

    `matrix`: M [1/s], ``(n, n)``. `knots`: start of each piece [s], ``(k,)``. `starts`: states of
    system and input at the start of each piece, ``(k, n)``.
    """

    matrix: AnyArray
    knots: FloatArray
    starts: AnyArray

    def at(self, times: FloatArray) -> AnyArray:
        """Return the n states at m times [s], ``(m, n)``; zero before the first knot."""
        index = np.searchsorted(self.knots, times, side="right") - 1
        start = np.where((index < 0)[:, np.newaxis], 0.0, self.starts[np.maximum(index, 0)])
        steps = np.maximum(times - self.knots[np.maximum(index, 0)], 0.0)
        return matrices_on_states(_finite_exponentials(self.matrix, steps), start)


def motions(A: FloatArray, B: FloatArray, inputs: Sequence[Pieces]) -> list[Motion]:
    """Return the motions of x' = A x + B f from zero initial states, one for each input f.

    `A`, `B`: one system, ``(n, n)`` and ``(n,)``. `inputs`: histories with exponentials of equal
    rates [1/s] and equal degree, so that all have the same matrix M (`piece_matrix`) of the states
    [x, z], z being the input's. A
    piece starts with x at the end of the piece before, and with z of its own input. The
    exponentials over pieces of equal width are computed once.
    """
    order, matrix = len(A), piece_matrix(A, B, inputs[0])
    widths = [np.diff(pieces.knots) for pieces in inputs]
    lengths, which = np.unique(np.concatenate(widths), return_inverse=True)
    steps, ends = _finite_exponentials(matrix, lengths), np.cumsum([0, *map(len, widths)])
    of_inputs: list[Motion] = []
    for pieces, first, last in zip(inputs, ends[:-1], ends[1:], strict=True):
        states = input_states(pieces, pieces.knots)
        starts = np.zeros((len(states), len(matrix)), dtype=np.result_type(matrix, states))
        starts[:, order:] = states
        for k, step in enumerate(which[first:last]):
            starts[k + 1, :order] = (steps[step] @ starts[k])[:order]
        of_inputs.append(Motion(matrix, pieces.knots, starts))
    return of_inputs


def piece_matrix(A: FloatArray, B: FloatArray, pieces: Pieces) -> AnyArray:
    """Return M of [x, z]' = M [x, z] within a piece, for x' = A x + B f, ``(n + k, n + k)``.

    z are the k states of the input f, a sum of c u^j e^(rate u): one Jordan block for each of its
    rates, as large as f has powers; f is the sum of the first elements of the blocks. `A`, `B`:
    ``(n, n)`` and ``(n,)``.
    `pieces`: f, one history.
    """
    rates, powers = pieces.rates, pieces.degree + 1
    input_matrix = np.zeros((len(A), rates.size * powers))
    input_matrix[:, ::powers] = B[:, np.newaxis]
    blocks = np.kron(np.diag(rates), np.eye(powers))
    blocks += np.kron(np.eye(rates.size), np.eye(powers, k=1))
    return augmented_matrix(A, input_matrix, blocks)


def augmented_matrix(A: AnyArray, B: AnyArray, inputs: AnyArray | None = None) -> AnyArray:
    """Return M of d/dt [x, z] = M [x, z] for x' = A x + B z, ``(..., n + k, n + k)``.

    `A`, `B`: ``(..., n, n)`` and ``(..., n, k)``; batches broadcast. `inputs`: Z of z' = Z z,
    ``(..., k, k)``; without it z is constant (zero-order hold).

    e^(M t) maps states and inputs at the start to those at t.
    """
    order, count = B.shape[-2:]
    inputs = np.zeros((count, count)) if inputs is None else inputs
    batch = np.broadcast_shapes(*(array.shape[:-2] for array in (A, B, inputs)))
    matrix = np.zeros((*batch, order + count, order + count), np.result_type(A, B, inputs))
    matrix[..., :order, :order], matrix[..., :order, order:] = A, B
    matrix[..., order:, order:] = inputs
    return matrix


def constant_generator(first: FloatArray, second: FloatArray, lengths: FloatArray) -> FloatArray:
    """Return the constant A ``(..., n, n)`` with the same step, to order four, as one that varies.

    Magnus' expansion with two Gauss points (Blanes, Casas, Oteo and Ros, 2009); for equal matrices
    the matrix itself. `first`, `second`: A at the two Gauss points (`GAUSS_NODES`) of each step,
    ``(..., n, n)``. `lengths`: lengths of the steps [s], ``(...)``.
    """
    factor = np.sqrt(3.0) / 12.0 * np.asarray(lengths)[..., np.newaxis, np.newaxis]
    return np.asarray(0.5 * (first + second) + factor * (second @ first - first @ second))


def input_states(pieces: Pieces, times: FloatArray) -> AnyArray:
    """Return the states z ``(m, size)`` of an input f at times ``(m,)`` [s], zero before f starts.

    `pieces`: f, a sum of terms c_k u^k e^(rate u). z has k! c_k for each rate and power k, with u
    counted from the time itself, so that z' = Z z with a constant Z, and f is a sum of elements of
    z.
    """
    index, u = locate(pieces, times)
    c = recentred(pieces.coefficients[index], pieces.rates, np.maximum(u, 0.0))
    scale = np.array([factorial(k) for k in range(pieces.degree + 1)], dtype=float)
    states = (c * scale).reshape(len(times), -1)
    return np.where((u < 0.0)[:, np.newaxis], 0.0, states)


def matrix_exponentials(matrix: AnyArray, steps: FloatArray) -> AnyArray:
    """Return e^(matrix step) for each of the steps, ``(m, n, n)``.

    By Taylor series, scaling and squaring, each with as many squarings as it requires: a result
    does not depend on the others. One matrix is balanced first. Elements that overflow are infinite
    or NaN. For ten thousand steps of a matrix of order six `scipy.linalg.expm` takes four times as
    long, and its import half a second.

    `matrix`: one for all ``(n, n)``, or one for each step ``(m, n, n)``. `steps`: ``(m,)``.
    """
    if not matrix.size:
        return np.zeros((len(steps), *matrix.shape[-2:]))
    scale = np.ones(matrix.shape[-1])
    if matrix.ndim < _AXES_OF_MATRICES:
        matrix, scale = balanced(matrix)
    size = np.abs(matrix).sum(axis=-2).max(axis=-1)
    # x = f 2^e with f in [0.5, 1): e squarings scale x _MAX_SERIES_NORM below it.
    squarings = np.maximum(np.frexp(size * np.abs(steps) / _MAX_SERIES_NORM)[1], 0)
    factors = np.ldexp(steps, -squarings)[:, np.newaxis, np.newaxis]
    result = np.empty((len(steps), *matrix.shape[-2:]), np.result_type(matrix, float))
    with np.errstate(over="ignore", invalid="ignore"):
        for start in range(0, len(steps), _MATRICES_PER_BLOCK):
            block = slice(start, start + _MATRICES_PER_BLOCK)
            matrices = matrix if matrix.ndim < _AXES_OF_MATRICES else matrix[block]
            part = exponential_series(matrices * factors[block])
            for k in range(int(squarings[block].max(initial=0))):
                squared = squarings[block] > k
                if np.all(squared):
                    part = part @ part
                else:
                    part[squared] = part[squared] @ part[squared]
            result[block] = part
        result *= scale[:, np.newaxis]
        result /= scale
        return result


def exponential_series(matrix: AnyArray) -> AnyArray:
    """Return the series of e^matrix up to the 15th power of small matrices, ``(m, n, n)``.

    In six products (Paterson and Stockmeyer, 1973): polynomials of third degree, by Horner's scheme
    in the fourth power. The norm of each matrix is at most one half, so that the next term is below
    1e-18.
    """
    square = matrix @ matrix
    powers = [np.broadcast_to(np.eye(matrix.shape[-1]), matrix.shape), matrix, square]
    powers.append(square @ matrix)
    fourth, result = square @ square, np.zeros_like(matrix)
    for block in range(_SERIES_BLOCK - 1, -1, -1):
        if block < _SERIES_BLOCK - 1:
            result = result @ fourth
        for k, power in enumerate(powers):
            result += power * (1.0 / factorial(_SERIES_BLOCK * block + k))
    return result


def balanced(matrix: AnyArray) -> tuple[AnyArray, FloatArray]:
    """Return D^-1 A D with rows and columns of like size, and the diagonal of D, powers of two.

    As `scipy.linalg.matrix_balance`, whose import takes as long as half a study (Parlett and
    Reinsch, 1969). `matrix`: A, ``(n, n)``. Each state in turn is scaled by the power of two that
    brings the norms of its row and column nearest to each other.
    """
    sizes = np.abs(matrix).tolist()
    order = range(len(sizes))
    scale = [1.0] * len(sizes)
    for _ in range(_BALANCING_SWEEPS):
        changed = False
        for i in order:
            column, row = hypot(*(line[i] for line in sizes)), hypot(*sizes[i])
            if not 0.0 < column * row < np.inf:
                continue
            factor = 2.0 ** round(0.5 * log2(row / column))
            if column * factor + row / factor >= _WORTH_SCALING * (column + row):
                continue
            changed, scale[i] = True, scale[i] * factor
            for j in order:
                sizes[j][i] *= factor
                sizes[i][j] /= factor
        if not changed:
            break
    diagonal = np.array(scale)
    return matrix * diagonal / diagonal[:, np.newaxis], diagonal


def _finite_exponentials(matrix: AnyArray, steps: FloatArray) -> AnyArray:
    """Return e^(matrix step) ``(m, n, n)`` of one matrix ``(n, n)`` [1/s] and steps ``(m,)`` [s].

    Raises `InputError` where one of them overflows.
    """
    exponentials = matrix_exponentials(matrix, steps)
    if not np.all(np.isfinite(exponentials)):
        raise InputError(
            f"the motion grows beyond all numbers within {float(np.abs(steps).max()):.6g} s; ask"
            " for an earlier time, or a shorter wind"
        )
    return exponentials


def matrices_on_states(matrices: AnyArray, states: AnyArray) -> AnyArray:
    """Return the products ``(m, n)`` of m matrices ``(m, n, n)`` and states ``(m, n)``."""
    return np.asarray((matrices @ states[..., np.newaxis])[..., 0])


def peak_output(response: Motion, row: AnyArray, horizon: float) -> tuple[float, float]:
    """Return the value of largest size of ``row . state``, with its sign, and its time [s].

    `response`: motion of a system and of the states that generate its input. `row`: factors on all
    these states, ``(n,)``. `horizon`: time for which the last piece, which does not end, is
    followed [s].
    """
    widths = np.append(np.diff(response.knots), horizon)
    values, offsets = piece_peaks(response.matrix, response.starts, widths, row)
    largest = int(np.argmax(np.abs(values)))
    return float(values[largest]), float(response.knots[largest] + offsets[largest])


def peak_outputs(responses: Sequence[Motion], row: AnyArray, horizon: float) -> FloatArray:
    """Return the largest size of ``row . state`` in each motion of one system, ``(motions,)``.

    The value of the motion with the largest is exact, as in `peak_output`; others may be too small.

    `responses`: motions of one system in several inputs. `row`: factors on the states of system and
    input, ``(n,)``. `horizon`: time for which the last piece of each is followed [s].
    """
    widths = [np.append(np.diff(response.knots), horizon) for response in responses]
    starts = np.concatenate([response.starts for response in responses])
    values, _ = piece_peaks(responses[0].matrix, starts, np.concatenate(widths), row)
    firsts = np.cumsum([0, *map(len, widths)])[:-1]
    return np.maximum.reduceat(np.abs(values), firsts)


def piece_peaks(
    matrix: AnyArray, starts: AnyArray, widths: FloatArray, row: AnyArray
) -> tuple[FloatArray, FloatArray]:
    """Return the value of largest size of ``row . state`` in each piece, and its time in it [s].

    Both ``(k,)``. `matrix`: M of state' = M state, ``(n, n)``. `starts`: states at the starts of
    the pieces, ``(k, n)``. `widths`: their durations [s], ``(k,)``. `row`: factors on the states,
    ``(n,)``. The largest of all is exact; those that cannot be the largest may be too small.

    Each piece is sampled in steps that resolve its fastest mode, both its ends included. Where
    values and slopes at two samples indicate a summit between them that may be the highest, the
    zero of the exact slope is computed. A piece is finished as soon as its modes, were they all in
    phase, could not exceed the highest summit.
    """
    rows = np.stack([row, row @ matrix, row @ matrix @ matrix])  # value, slope, curvature
    modes = _modal_bounds(matrix, row, float(widths.max()))
    rounding = _RELATIVE_ROUNDING * (np.abs(starts) @ np.abs(row)).max()
    values, offsets = np.zeros(len(widths)), np.zeros(len(widths))
    lengths, which = np.unique(widths, return_inverse=True)
    to_end = matrix_exponentials(matrix, lengths)
    for first in range(0, len(widths), _PIECES_PER_BLOCK):
        remaining = np.arange(first, min(first + _PIECES_PER_BLOCK, len(widths)))
        states = starts[remaining]
        ends = np.real(rows @ matrices_on_states(to_end[which[remaining]], states).T)
        # powers: transition matrices from the start of a block of samples to each of them
        for start, step, powers in _sample_steps(matrix, float(widths[remaining].max())):
            steps = start + step * np.arange(_STEPS_PER_BLOCK + 1.0)[:, np.newaxis]
            inside = (steps < widths[remaining])[:, np.newaxis]
            samples = np.where(inside, np.real(rows @ powers @ states.T), ends)
            steps = np.minimum(steps, widths[remaining])
            highest = float(np.abs(values).max())
            block, times = _highest_samples(rows, matrix, powers, states, steps, samples, highest)
            higher = np.abs(block) > np.abs(values[remaining])
            values[remaining[higher]], offsets[remaining[higher]] = block[higher], times[higher]
            states = states @ powers[-1].T
            with np.errstate(over="ignore", invalid="ignore"):
                bound = np.abs(states @ modes.T).sum(axis=1)
            highest = float(np.abs(values).max())
            active = (steps[-1] < widths[remaining]) & ~(bound <= highest + rounding)
            states, ends, remaining = states[active], ends[:, active], remaining[active]
            if not remaining.size:
                break
    return values, offsets


def _highest_samples(
    rows: AnyArray,
    matrix: AnyArray,
    powers: AnyArray,
    states: AnyArray,
    steps: FloatArray,
    samples: FloatArray,
    bound: float,
) -> tuple[FloatArray, FloatArray]:
    """Return the largest sample or summit of each of m pieces, and its time in the piece [s].

    `rows`: rows of value, slope and curvature, ``(3, n)``. `matrix`: M of state' = M state.
    `powers`: e^(M t) from the start of the block to each of k steps, ``(k, n, n)``. `states`:
    states at this start, ``(m, n)``. `steps`: times of the samples in their piece [s], ``(k, m)``.
    `samples`: values, slopes and curvatures, ``(k, 3, m)``. `bound`: size of a summit that counts.
    """
    sizes = np.abs(samples[:, 0])
    pieces = np.arange(sizes.shape[1])
    highest = np.argmax(sizes, axis=0)
    values, times = samples[highest, 0, pieces], steps[highest, pieces]
    widths = np.diff(steps, axis=0)
    which, guess = _candidate_summits(
        samples, widths, (1.0 - _SUMMIT_TOLERANCE) * max(bound, float(sizes.max()))
    )
    if not guess.size:
        return values, times
    before, piece = which  # the sample before each summit, and its piece
    starts = matrices_on_states(powers[before], states[piece])
    sign = np.sign(samples[:-1, 1][which])  # of the slope there, which is that of the summit
    summits, offsets = _refined_summits(rows, matrix, starts, sign, guess, widths[which])
    rising = np.argsort(np.abs(summits), kind="stable")  # of two in a piece the higher is last
    rising = rising[np.abs(summits[rising]) > np.abs(values[piece[rising]])]
    i, j = before[rising], piece[rising]
    values[j], times[j] = summits[rising], steps[i, j] + offsets[rising]
    return values, times


def _candidate_summits(
    samples: FloatArray, widths: FloatArray, threshold: float
) -> tuple[tuple[IndexArray, IndexArray], FloatArray]:
    """Return the positions of samples before summits above `threshold`, and the time [s] to them.

    Positions are pairs of sample and piece. `samples`: values, slopes and curvatures of k samples
    of m pieces, ``(k, 3, m)``. `widths`: times between samples [s], ``(k - 1, m)``. A Hermite
    cubic, start + first x + square x^2 + cube x^3 on x from 0 to 1, has its summit at x =
    first/(sqrt(square^2 - 3 first cube) - square).
    """
    values, slopes = samples[:, 0], samples[:, 1]
    sign = np.sign(values[:-1] + values[1:])
    first, last = sign * widths * slopes[:-1], sign * widths * slopes[1:]
    sample, piece = np.nonzero((first > 0.0) & (last < 0.0))  # before a summit, and its piece
    which = sample, piece
    sign, first, last = sign[which], first[which], last[which]
    value_at_start, rise = sign * values[:-1][which], sign * np.diff(values, axis=0)[which]
    square, cube = 3.0 * rise - 2.0 * first - last, first + last - 2.0 * rise
    root = np.sqrt(np.maximum(square**2 - 3.0 * first * cube, 0.0))
    x = np.divide(first, root - square, where=root - square > first, out=np.ones_like(first))
    high = value_at_start + x * (first + x * (square + x * cube)) >= threshold
    which = sample[high], piece[high]
    return which, x[high] * widths[which]


def _refined_summits(
    rows: AnyArray,
    matrix: AnyArray,
    starts: AnyArray,
    sign: FloatArray,
    steps: FloatArray,
    widths: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return values at s summits, and the time [s] from sample to summit, by bracketed Newton.

    `rows`: rows of value, slope and curvature, ``(3, n)``. `matrix`: M of state' = M state.
    `starts`: states at the samples before the summits, ``(s, n)``. `sign`: signs of the values.
    `steps`: first estimates [s]. `widths`: times to the next sample [s], ``(s,)``. The method is
    for the zero of the slope; an iterate outside its bracket is replaced by the middle.
    """
    low, high = np.zeros_like(steps), widths
    for _ in range(_SUMMIT_ITERATIONS):
        _, slopes, curvatures = np.real(
            rows @ matrices_on_states(matrix_exponentials(matrix, steps), starts).T
        )
        rising = sign * slopes > 0.0
        low, high = np.where(rising, steps, low), np.where(rising, high, steps)
        iterate = steps - slopes / np.where(curvatures == 0.0, np.nan, curvatures)
        steps = np.where((low <= iterate) & (iterate <= high), iterate, 0.5 * (low + high))
    return np.real(matrices_on_states(matrix_exponentials(matrix, steps), starts) @ rows[0]), steps


def _modal_bounds(matrix: AnyArray, row: AnyArray, horizon: float) -> AnyArray:
    """Return the matrix ``(n, n)`` with a row for each mode; with a state, bounds of its output.

    The output is ``row . state``, with state' = `matrix` state, a sum over modes. The size of the
    product of a row with the state bounds what that mode adds to it within the time `horizon` [s],
    so their sum bounds the output. Where modes coincide the elements are very large or NaN and
    give no bound; a mode that `row` does not observe counts with its rounding.
    """
    rates, vectors = np.linalg.eig(matrix)
    rounding = np.finfo(float).eps * (np.abs(row) @ np.abs(vectors))
    with np.errstate(over="ignore", invalid="ignore"):
        observed = np.maximum(np.abs(row @ vectors), rounding)
        observed = observed * np.exp(np.maximum(np.real(rates), 0.0) * horizon)
        try:
            return np.asarray(observed[:, np.newaxis] * np.linalg.inv(vectors))
        except np.linalg.LinAlgError:
            return np.full(matrix.shape, np.nan)


def _sample_steps(matrix: AnyArray, horizon: float) -> Iterator[tuple[float, float, AnyArray]]:
    """Yield blocks of equal steps, without end: start [s], step [s] and e^(matrix k step).

    k is from 0 to `_STEPS_PER_BLOCK`. `matrix`: M of state' = M state [1/s]. `horizon`: longest
    time of interest [s]. The first block is as long as one step of the next, as a motion that
    starts with zero slope may turn soon. A step doubles when every mode that is too fast for the
    longer step has decayed.
    """
    rates = np.linalg.eigvals(matrix)
    fastest = float(np.abs(rates).max())
    step = min(_FIRST_STEP / fastest if fastest else np.inf, horizon / _STEPS_PER_BLOCK)
    short, long = matrix_exponentials(matrix, np.array([step / _STEPS_PER_BLOCK, step]))
    powers = _matrix_powers(short)
    powers[-1] = long  # equal, with less rounding
    yield 0.0, step / _STEPS_PER_BLOCK, powers
    start, powers = step, _matrix_powers(long)
    while True:
        yield start, step, powers
        start += step * _STEPS_PER_BLOCK
        # sizes of the eigenvalues whose modes have not decayed by then [1/s]
        alive = np.abs(rates[-np.real(rates) * start < _DECAY_EXPONENT])
        if 2.0 * step * alive.max(initial=0.0) <= _MAX_STEP:
            step, powers = 2.0 * step, _matrix_powers(powers[2])  # of e^(M 2 step)


def _matrix_powers(factor: AnyArray) -> AnyArray:
    """Return the powers of a matrix from 0 to n = `_STEPS_PER_BLOCK`, ``(n + 1, ...)``."""
    powers, doubled = np.eye(len(factor))[np.newaxis], factor
    while len(powers) < _STEPS_PER_BLOCK:
        powers = np.concatenate([powers, doubled @ powers])
        doubled = doubled @ doubled
    return np.concatenate([powers, doubled[np.newaxis]])
