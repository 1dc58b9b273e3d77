"""The largest size of an output of a motion, found between its samples."""

from collections.abc import Iterator

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IndexArray
from tvclin.numerics.propagation import Motion, applied, exponentials

_EACH = 128
"""Steps of one size in the ladder of times; the size may double from one lot to the next."""
_FINE, _COARSE = 0.1, 0.4
"""The first step, and the coarsest, over the fastest eigenvalue that is still alive."""
_DEAD = 40.0
"""A mode is dead when it has fallen to e^-40."""
_CLOSE = 1e-3
"""A summit that seems lower than the highest by less than this may be the highest."""
_CLIMB = 5
"""Steps of Newton's method from the summit of a cubic, which is near the true one."""
_BLOCK = 2048
"""Pieces that are looked through together, to bound the memory."""
_ROUNDING = 1e-13
"""What is below this part of the terms of an output is their rounding."""


def largest(flown: Motion, row: AnyArray, beyond: float) -> tuple[float, float]:
    """Return the value of largest size of ``row . state``, with its sign, and its time [s].

    `row`: factors on the states of system and input, ``(n,)``. `beyond`: how long the last piece is
    followed [s].

    Each piece is sampled in steps that no mode outruns, both its ends included. Where values and
    slopes at two samples tell of a summit between them that may be the highest, it is found
    where the exact slope is zero. A piece is left as soon as its modes, were they all in phase,
    could not reach the highest summit any more.
    """
    matrix, widths = flown.matrix, np.append(np.diff(flown.knots), beyond)
    rows = np.stack([row, row @ matrix, row @ matrix @ matrix])
    ends = np.real(rows @ applied(exponentials(matrix, widths), flown.starts).T)
    modes = _modes(matrix, row, float(widths.max()))
    rounding = _ROUNDING * (np.abs(flown.starts) @ np.abs(row)).max()
    value, time = 0.0, float(flown.knots[0])
    for first in range(0, len(widths), _BLOCK):
        left = np.arange(first, min(first + _BLOCK, len(widths)))
        states = flown.starts[left]
        for begun, step, powers in _ladder(matrix, float(widths[left].max())):
            steps = begun + step * np.arange(_EACH + 1.0)[:, np.newaxis]
            inside = (steps < widths[left])[:, np.newaxis]
            samples = np.where(inside, np.real(rows @ powers @ states.T), ends[:, left])
            steps = np.minimum(steps, widths[left])
            found = _highest(rows, matrix, powers, states, steps, samples, abs(value))
            if abs(found[0]) > abs(value):
                value, time = found[0], float(flown.knots[left[found[2]]]) + found[1]
            states = states @ powers[-1].T
            with np.errstate(over="ignore", invalid="ignore"):
                reach = np.abs(states @ modes.T).sum(axis=1)
            going = (steps[-1] < widths[left]) & ~(reach <= abs(value) + rounding)
            states, left = states[going], left[going]
            if not left.size:
                break
    return value, time


def _highest(
    rows: AnyArray,
    matrix: AnyArray,
    powers: AnyArray,
    states: AnyArray,
    steps: FloatArray,
    samples: FloatArray,
    known: float,
) -> tuple[float, float, int]:
    """The highest sample or summit: its value, its time after the knot [s], and its piece."""
    sizes = np.abs(samples[:, 0])
    i, j = np.unravel_index(int(np.argmax(sizes)), sizes.shape)
    best = float(samples[i, 0, j]), float(steps[i, j]), int(j)
    widths = np.diff(steps, axis=0)
    which, guess = _promising(samples, widths, (1.0 - _CLOSE) * max(known, abs(best[0])))
    if not guess.size:
        return best
    starts, sign = applied(powers[which[0]], states[which[1]]), np.sign(samples[:-1, 1][which])
    values, offsets = _climbed(rows, matrix, starts, sign, guess, widths[which])
    k = int(np.argmax(np.abs(values)))
    i, j = which[0][k], which[1][k]
    summit = float(values[k]), float(steps[i, j] + offsets[k]), int(j)
    return max(best, summit, key=lambda one: abs(one[0]))


def _promising(
    samples: FloatArray, widths: FloatArray, least: float
) -> tuple[tuple[IndexArray, IndexArray], FloatArray]:
    """Where cubics through values and slopes have summits as high as `least`, and at what step.

    begin + first x + square x^2 + cube x^3 on x from 0 to 1 (Hermite), whose slope falls through
    zero at x = first/(sqrt(square^2 - 3 first cube) - square).
    """
    values, slopes = samples[:, 0], samples[:, 1]
    sign = np.sign(values[:-1] + values[1:])
    first, last = sign * widths * slopes[:-1], sign * widths * slopes[1:]
    turns = np.nonzero((first > 0.0) & (last < 0.0))
    which = turns[0], turns[1]
    sign, first, last = sign[which], first[which], last[which]
    begin, rise = sign * values[:-1][which], sign * np.diff(values, axis=0)[which]
    square, cube = 3.0 * rise - 2.0 * first - last, first + last - 2.0 * rise
    root = np.sqrt(np.maximum(square**2 - 3.0 * first * cube, 0.0))
    x = np.divide(first, root - square, where=root - square > first, out=np.ones_like(first))
    high = begin + x * (first + x * (square + x * cube)) >= least
    which = which[0][high], which[1][high]
    return which, x[high] * widths[which]


def _climbed(
    rows: AnyArray,
    matrix: AnyArray,
    starts: AnyArray,
    sign: FloatArray,
    steps: FloatArray,
    widths: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """The values where the slope is zero, and the steps there, by Newton's method in a bracket."""
    low, high = np.zeros_like(steps), widths
    for _ in range(_CLIMB):
        _, slopes, curvatures = np.real(rows @ applied(exponentials(matrix, steps), starts).T)
        rising = sign * slopes > 0.0
        low, high = np.where(rising, steps, low), np.where(rising, high, steps)
        moved = steps - slopes / np.where(curvatures == 0.0, np.nan, curvatures)
        steps = np.where((low <= moved) & (moved <= high), moved, 0.5 * (low + high))
    return np.real(applied(exponentials(matrix, steps), starts) @ rows[0]), steps


def _modes(matrix: AnyArray, row: AnyArray, longest: float) -> AnyArray:
    """Factors that take a state to the sizes at which ``row . state`` sees its modes, ``(n, n)``.

    The sum of the sizes is never exceeded in the time `longest`. Where modes coincide the factors
    are very large, or not numbers, and say nothing; a mode that the row does not see counts with
    its rounding, or it would hide that.
    """
    rates, vectors = np.linalg.eig(matrix)
    least = np.finfo(float).eps * (np.abs(row) @ np.abs(vectors))
    with np.errstate(over="ignore", invalid="ignore"):
        seen = np.maximum(np.abs(row @ vectors), least)
        seen = seen * np.exp(np.maximum(np.real(rates), 0.0) * longest)
        try:
            return np.asarray(seen[:, np.newaxis] * np.linalg.inv(vectors))
        except np.linalg.LinAlgError:
            return np.full(matrix.shape, np.nan)


def _ladder(matrix: AnyArray, longest: float) -> Iterator[tuple[float, float, AnyArray]]:
    """Lots of equal steps, without end: where one begins, its step [s], and e^(matrix t) in it.

    The first lot is as long as one step of the next, as a motion that starts with no slope may
    turn soon. Later a step doubles when every mode that would be too fast for it has died out.
    """
    rates = np.linalg.eigvals(matrix)
    fastest = float(np.abs(rates).max())
    step = min(_FINE / fastest if fastest else np.inf, longest / _EACH)
    each, whole = exponentials(matrix, np.array([step / _EACH, step]))
    powers = _powers(each)
    powers[-1] = whole  # the same, with less rounding
    yield 0.0, step / _EACH, powers
    begun, powers = step, _powers(whole)
    while True:
        yield begun, step, powers
        begun += step * _EACH
        alive = np.abs(rates[-np.real(rates) * begun < _DEAD])
        if 2.0 * step * alive.max(initial=0.0) <= _COARSE:
            step, powers = 2.0 * step, _powers(powers[2])


def _powers(factor: AnyArray) -> AnyArray:
    """The powers from 0 to `_EACH`, which is a power of two, ``(_EACH + 1, n, n)``."""
    powers, doubled = np.eye(len(factor))[np.newaxis], factor
    while len(powers) < _EACH:
        powers = np.concatenate([powers, doubled @ powers])
        doubled = doubled @ doubled
    return np.concatenate([powers, doubled[np.newaxis]])
