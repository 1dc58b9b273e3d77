"""Polynomials at Chebyshev points: smooth functions at many times, and initial value problems.

In each interval between breakpoints a function is evaluated at the extreme points of a Chebyshev
polynomial, whose degree is doubled until the interpolant of half the degree agrees with the new
values. Its error falls geometrically with the degree (Trefethen, 2013), so that the one that is
taken has about the square of that difference. Where it is not worth it, or does not converge, the
function is evaluated at each time.

The solution of x' = f(t, x) is such a polynomial in each interval, by the Picard iteration

    x <- x(a) + integral from a to t of f(t, x) dt,

with the integral of the polynomial of f, which contracts where the interval is short. An interval
in which it does not converge, or whose last Chebyshev coefficients, whose size is about the error,
have not decayed, is halved. So an interval with a jump of a derivative becomes short.
`scipy.integrate`, whose import takes as long as half a study, needs about as many evaluations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebint, chebpts2, chebvander

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray, Storage

_FIRST_DEGREE, _MAX_DEGREE = 5, 32
"""Degree of the first and the last interpolant."""
_X_DEGREES, _Y_DEGREE = (4, 10, 20), 4
"""Degrees of the interpolant of a surface, of x the first that suffices."""
_MIN_TIMES_PER_POINT = 2
"""Smallest number of times for each point of an interpolant that is worth it."""
_HALF_DEGREE_TOLERANCE = 1e-7
"""Largest difference from the interpolant of half the degree, relative to the largest value."""
_ROUNDING = 1e-13
"""Rounding of a value, relative to the largest of its array."""
_SOLUTION_DEGREE = 16
"""Degree of the polynomials of a solution."""
_MAX_ITERATIONS = 30
"""Iterations after which an interval is halved."""
_TOLERANCE = 1e-13
"""Error of an interval, relative to the largest value in it, or to one if that is larger."""
_MIN_INTERVAL = 1e-9
"""Shortest interval, relative to the whole, below which the solution ends."""


def smooth_values(
    function: Callable[[FloatArray, IndexArray], dict[str, FloatArray]],
    times: FloatArray,
    interval: IndexArray,
    storage: Storage | None = None,
) -> dict[str, FloatArray]:
    """Return the values of a function at times, ``(n, ...)`` by name, to 1e-13 of the largest.

    A value that is constant is exact. In an interval with many times the function is evaluated at
    Chebyshev points instead, of a degree that is doubled until the interpolant of half the degree
    agrees; without agreement, and where the times are few, at the times themselves.

    Parameters
    ----------
    function : callable
        Function from times ``(m,)``, and for each the index in `times` of a time in the same
        interval, to arrays ``(m, ...)`` by name; it is called with many times together.
    times : ndarray
        Times, rising within each interval, ``(n,)``.
    interval : ndarray of int
        Number of the interval in which the function is smooth, for each time; negative for a time
        at which it is evaluated itself. Times of an interval follow each other.
    storage : Storage, optional
        Memory of the arrays that are returned; by default new.
    """
    # runs: successive times of one interval; pending: those that may be interpolated
    edges = [0, *(np.flatnonzero(np.diff(interval)) + 1).tolist(), times.size]
    runs = [slice(*ends) for ends in pairwise(edges) if ends[0] < ends[1]]
    pending = [
        run for run in runs if interval[run.start] >= 0 and _has_times_for(run, _FIRST_DEGREE)
    ]
    interpolated = np.zeros(times.size, bool)
    for run in pending:
        interpolated[run] = True
    exact, degree = np.flatnonzero(~interpolated), 2 * _FIRST_DEGREE
    nodes = [_nodes(times[run], degree) for run in pending]
    first = function(
        np.concatenate([times[exact], *nodes]),
        np.concatenate([exact, np.repeat([run.start for run in pending], degree + 1)]).astype(int),
    )
    storage = storage or Storage()
    values = {name: storage.empty(name, (times.size, *a.shape[1:])) for name, a in first.items()}
    flat = [array.reshape(times.size, -1) for array in values.values()]
    columns = np.cumsum([0, *(array.shape[1] for array in flat)])
    for array, computed in zip(values.values(), first.values(), strict=True):
        array[exact] = computed[: exact.size]
    rows = _packed({name: array[exact.size :] for name, array in first.items()})
    at_nodes = list(np.split(rows, max(len(pending), 1)))
    remaining: list[slice] = []
    while pending:
        points = np.stack(at_nodes)  # (runs, degree + 1, elements)
        agree = _agree(points, columns[:-1])
        smooth = points[agree]
        runs = [run for run, accepted in zip(pending, agree, strict=True) if accepted]
        _write(flat, columns, times, runs, smooth[:, 0], np.nan_to_num(smooth - smooth[:, :1]))
        rest: list[tuple[slice, FloatArray]] = []
        for run, of_run, accepted in zip(pending, points, agree, strict=True):
            if not accepted and degree < _MAX_DEGREE and _has_times_for(run, degree):
                rest.append((run, of_run))
            elif not accepted:
                remaining.append(run)
        pending, degree = [run for run, _ in rest], 2 * degree  # those that do not agree yet
        at_nodes = _refined(function, times, rest, degree)
    if remaining:
        which = np.concatenate([np.arange(run.start, run.stop) for run in remaining])
        for name, array in function(times[which], which).items():
            values[name][which] = array
    return values


def _write(
    arrays: list[FloatArray],
    columns: IndexArray,
    times: FloatArray,
    runs: list[slice],
    first: FloatArray,
    changes: FloatArray,
) -> None:
    """Write the values of interpolants at the times of R runs into arrays ``(n, elements)``.

    `columns`: first column of each array in `first` and `changes`, where all arrays stand side by
    side, and the end of the last, ``(arrays + 1,)``. `times`: ``(n,)``. `runs`: slices of the times
    in one interval each. `first`: values at the first Chebyshev point of each run,
    ``(R, elements)``. `changes`: differences at all points from these, ``(R, degree + 1,
    elements)``.
    """
    angles = [_angles(times[run], *times[run][[0, -1]]) for run in runs]
    lengths = np.cumsum([run.stop - run.start for run in runs])
    # of the values at the points, for each time; the empty array is for no run at all, and the
    # empty last part that `split` adds is dropped by `zip`
    factors = _factors(changes.shape[1] - 1, np.concatenate([*angles, np.empty(0)]))
    for k, (run, of_run) in enumerate(zip(runs, np.split(factors, lengths), strict=False)):
        for array, low, high in zip(arrays, columns[:-1], columns[1:], strict=True):
            np.matmul(of_run, changes[k, :, low:high], out=array[run])
            array[run] += first[k, low:high]


@dataclass(frozen=True, eq=False)
class Surface:
    """Arrays that are smooth in x and y and linear in z, from Chebyshev points of x and y.

    `x`, `y`: ranges. `degree`: degree in x. `first`: values at the first point, by name. `table`:
    differences of the values at all points from these, and their slopes by z, ``(2 points, ...)``
    by name.
    """

    x: tuple[float, float]
    y: tuple[float, float]
    degree: int
    first: dict[str, FloatArray]
    table: dict[str, FloatArray]

    @classmethod
    def of(
        cls,
        function: Callable[[FloatArray, FloatArray, FloatArray], dict[str, FloatArray]],
        x: tuple[float, float],
        y: tuple[float, float],
        z: float,
    ) -> Surface | None:
        """Return the Chebyshev interpolant of a function linear in z, or None without convergence.

        `function`: from x, y and z, ``(m,)`` each, to arrays ``(m, ...)`` by name. `x`, `y`: ranges
        of the interpolant. `z`: largest z; the function is evaluated at both signs of it. The
        degree in x rises until the interpolant of half the degree agrees.
        """
        for degree in _X_DEGREES:
            shape = degree + 1, _Y_DEGREE + 1
            positions = np.meshgrid(
                _nodes(np.array(x), degree), _nodes(np.array(y), _Y_DEGREE), indexing="ij"
            )
            # every point once with z and once with -z: their mean and slope are exact
            at_x, at_y = (np.tile(position.ravel(), 2) for position in positions)
            count = at_x.size // 2
            samples = function(at_x, at_y, np.repeat([z, -z], count))
            values = {name: 0.5 * (a[:count] + a[count:]) for name, a in samples.items()}
            if not all(_converges(values, shape, axis) for axis in range(2)):
                continue
            table = {
                name: np.concatenate([value - value[0], (a[:count] - a[count:]) / (2.0 * z)])
                for (name, value), a in zip(values.items(), samples.values(), strict=True)
            }
            first = {name: value[0] for name, value in values.items()}
            return cls(x=x, y=y, degree=degree, first=first, table=table)
        return None

    def factors(self, x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
        """Return the matrix from rows of `table` to values at m points, ``(m, 2 points)``.

        `x`, `y`, `z`: coordinates of the m points, ``(m,)`` each. The first half of the rows of
        `table` are values at the Chebyshev points of x and y, minus the value at the first of
        these (`first`); the second half slopes by z there.
        """
        of_x = _factors(self.degree, _angles(x, *self.x))  # of the points of x
        of_y = _factors(_Y_DEGREE, _angles(y, *self.y))
        factors = (of_x[:, :, np.newaxis] * of_y[:, np.newaxis]).reshape(len(x), -1)
        return np.concatenate([factors, z[:, np.newaxis] * factors], axis=1)

    def write(self, name: str, part: Any, factors: FloatArray, out: FloatArray) -> None:
        """Write values of the array `name` at m points of x, y and z into `out`, ``(m, ...)``.

        They are the values `first` at one Chebyshev point plus `factors` times `table`, whose rows
        are differences of the values at all points from these, then slopes in z at all points.
        `part`: index of the elements of an array that are written; ... for all. `factors`: result
        of the method `factors` for the m points, ``(m, 2 points)``.
        """
        table = self.table[name][:, part]
        values = factors @ table.reshape(len(table), -1)  # of the flattened elements
        np.add(values.reshape(out.shape), self.first[name][part], out=out)


def _converges(values: dict[str, FloatArray], shape: tuple[int, int], axis: int) -> bool:
    """Return whether the interpolant of half the degree in x or y agrees with all values.

    `values`: arrays by name, ``(points, ...)``, at the Chebyshev points of a surface. `shape`:
    number of points in x and in y, whose product is `points`. `axis`: 0 for x, 1 for y.
    """
    arrays = [
        np.moveaxis(array.reshape(*shape, -1), axis, 0).reshape(shape[axis], -1)
        for array in values.values()
    ]
    # first column of each array: values are compared in proportion to the largest of their array
    starts = np.cumsum([0, *(array.shape[1] for array in arrays[:-1])])
    return bool(_agree(np.concatenate(arrays, axis=1), starts))


def _refined(
    function: Callable[[FloatArray, IndexArray], dict[str, FloatArray]],
    times: FloatArray,
    intervals: list[tuple[slice, FloatArray]],
    degree: int,
) -> list[FloatArray]:
    """Return the values at the Chebyshev points of a degree in each interval, ``(degree + 1, k)``.

    A row has the elements of all arrays of `function` at one time. `function`: from times, and for
    each the index in `times` of a time in the same interval, to arrays by name. `times`: all times.
    `intervals`: for each the slice of its `times`, and the values at the points of half the degree,
    ``(degree / 2 + 1, k)``.
    """
    refined = []
    if intervals:
        fresh = [_nodes(times[run], degree)[1::2] for run, _ in intervals]  # every second point
        index = np.repeat([run.start for run, _ in intervals], degree // 2)
        values = np.split(_packed(function(np.concatenate(fresh), index)), len(intervals))
        for (_, old), new in zip(intervals, values, strict=True):
            points = np.empty((degree + 1, new.shape[1]))
            points[::2], points[1::2] = old, new
            refined.append(points)
    return refined


def _packed(arrays: dict[str, FloatArray]) -> FloatArray:
    """Return arrays ``(m, ...)`` by name as m rows of all their k numbers, ``(m, k)``."""
    rows = (array.reshape(len(array), int(np.prod(array.shape[1:]))) for array in arrays.values())
    return np.concatenate([*rows], axis=1)


def _has_times_for(run: slice, degree: int) -> bool:
    """Return whether an interval has enough times for interpolants of a degree and of its double.

    With fewer, the function is better evaluated at the times themselves. `run`: slice of these
    times among all times.
    """
    return run.stop - run.start >= _MIN_TIMES_PER_POINT * (2 * degree + 1)


def _nodes(times: FloatArray, degree: int) -> FloatArray:
    """Return the d + 1 Chebyshev points of degree d between first and last of the times, rising."""
    return times[0] + (times[-1] - times[0]) * (0.5 + 0.5 * chebpts2(degree + 1))


def _angles(times: FloatArray, first: float, last: float) -> FloatArray:
    """Return the angles of times on the half circle [rad], 0 at the time `first`, pi at `last`.

    Their cosines are minus the times, scaled to -1 to 1; Chebyshev points have equidistant angles.
    """
    middle = 2.0 * (times - first) / (last - first) - 1.0
    return np.arccos(np.clip(-middle, -1.0, 1.0))


def _factors(degree: int, angles: FloatArray) -> FloatArray:
    """Return the interpolation factors ``(m, d + 1)`` from equidistant angles to others.

    The values are at d + 1 angles from 0 to pi, d being the `degree`, and are interpolated at the m
    `angles` as a polynomial of degree d in their cosine.
    """
    return interpolation_factors(np.cos(np.linspace(0.0, np.pi, degree + 1)), np.cos(angles))


def interpolation_factors(nodes: FloatArray, positions: FloatArray) -> FloatArray:
    """Return the factors ``(m, n)`` from values at Chebyshev nodes ``(n,)`` to other positions.

    By the barycentric formula (Berrut and Trefethen, 2004), whose weights are of alternating sign,
    and half as large at both ends. `nodes`: extreme points, on any interval. `positions`: points of
    that interval, ``(m,)``.
    """
    weights = (-1.0) ** np.arange(nodes.size)
    weights[[0, -1]] *= 0.5
    distances = positions[:, np.newaxis] - nodes
    at_node = distances == 0.0
    factors = weights / np.where(at_node, 1.0, distances)
    factors = np.where(at_node.any(axis=1, keepdims=True), at_node.astype(float), factors)
    return np.asarray(factors / factors.sum(axis=1, keepdims=True))


def _agree(points: FloatArray, starts: IndexArray) -> BoolArray:
    """Return whether interpolants of half the degree agree with the function, ``(...)``.

    `points`: values at the Chebyshev points of a degree d, ``(..., d + 1, k)``, of which every
    second one, from the first on, is a point of half the degree. `starts`: first of the k columns
    of each array, whose largest value sets its rounding. Columns that are all NaN agree; columns
    with some NaN do not.
    """
    degree = points.shape[-2] - 1
    middles = _factors(degree // 2, np.linspace(0.0, np.pi, degree + 1)[1::2])
    # from the first point, so that a constant is interpolated without rounding
    first = points[..., :1, :]
    guess = middles @ np.nan_to_num(points[..., ::2, :] - first) + first
    missing = np.isnan(points)
    partly_missing = missing.any(axis=-2) != missing.all(axis=-2)
    largest = np.abs(np.where(missing, 0.0, points)).max(axis=-2)
    of_array = np.maximum.reduceat(largest, starts, axis=-1)
    sizes = np.diff(starts, append=largest.shape[-1])
    tolerance = _HALF_DEGREE_TOLERANCE * largest + _ROUNDING * np.repeat(of_array, sizes, axis=-1)
    with np.errstate(invalid="ignore"):
        close = np.abs(guess - points[..., 1::2, :]) <= tolerance[..., np.newaxis, :]
    agree = np.all(close | missing[..., 1::2, :], axis=(-2, -1))
    return np.asarray(agree & ~partly_missing.any(axis=-1))


@dataclass(frozen=True)
class InitialValueSolution:
    """Solution x(t) ``(k,)`` between two times, to about 1e-12 of its size.

    `ends`: times between which it is a polynomial, ``(n + 1,)``, from the first time to the last,
    which may be earlier. `values`: x at the Chebyshev points of each, ``(n, degree + 1, k)``.
    """

    ends: FloatArray
    values: FloatArray

    def __call__(self, t: Any) -> FloatArray:
        """Return x ``(k,)`` at a time `t` [s], or ``(k, m)`` at times ``(m,)``.

        `ends` separate the intervals, `values` are x at the Chebyshev points of each, between which
        it is interpolated. A time outside the span counts as the nearer end of it.
        """
        times, rising = np.atleast_1d(t), np.sign(self.ends[-1] - self.ends[0])
        index = np.searchsorted(rising * self.ends[1:-1], rising * times)
        begin, end = self.ends[index], self.ends[index + 1]
        positions = np.clip((2.0 * times - begin - end) / (end - begin), -1.0, 1.0)
        factors = interpolation_factors(_points(), positions)
        x = np.einsum("md,mdk->km", factors, self.values[index])
        return x if np.ndim(t) else x[:, 0]


def initial_value_solution(
    rates: Callable[[FloatArray, FloatArray], FloatArray],
    begin: FloatArray,
    span: tuple[float, float],
    valid: Callable[[FloatArray], bool],
) -> InitialValueSolution:
    """Return the solution x(t) of x' = f(t, x) from the first time of a span to the last.

    It ends earlier where x would cease to be valid, or where the iteration does not converge. An
    interval is halved until the iteration converges in it and the last two Chebyshev coefficients
    of x are below the tolerance; the next one is twice as long as the last that was accepted.

    Parameters
    ----------
    rates : callable
        f from times ``(m,)`` and x ``(k, m)`` to derivatives ``(k, m)``.
    begin : ndarray
        x at the first time, ``(k,)``.
    span : tuple of float
        First and last time; the last may be the earlier one.
    valid : callable
        Function from x ``(k, m)`` to whether f may be evaluated there.
    """
    points = _points()
    to_coefficients = np.linalg.inv(chebvander(points, _SOLUTION_DEGREE))
    integral = chebvander(points, _SOLUTION_DEGREE + 1) @ chebint(to_coefficients, lbnd=-1.0)
    # from values at the points of an interval of length one to integrals from its start
    factors = np.asarray(0.5 * (integral - integral[0]), dtype=float)
    time, stop = span
    ends, polynomials, length = [time], [], stop - time
    x = np.asarray(begin, dtype=float)
    while time != stop and abs(length) > _MIN_INTERVAL * abs(span[1] - span[0]):
        times = time + length * (0.5 + 0.5 * points)
        values, tolerance = _picard(rates, x, times, length * factors, valid)
        if not np.all(np.abs(to_coefficients[-2:] @ values.T) <= tolerance):
            length *= 0.5
            continue
        x = values[:, -1]
        time = stop if length == stop - time else time + length
        ends.append(time)
        polynomials.append(values.T)
        length = np.copysign(min(2.0 * abs(length), abs(stop - time)), length)
    return InitialValueSolution(
        np.array(ends), np.reshape(polynomials, (-1, _SOLUTION_DEGREE + 1, x.size))
    )


@cache
def _points() -> FloatArray:
    """Return the Chebyshev points of an interval, in [-1, 1], ``(degree + 1,)``."""
    return np.asarray(chebpts2(_SOLUTION_DEGREE + 1))


def _picard(
    rates: Callable[[FloatArray, FloatArray], FloatArray],
    begin: FloatArray,
    times: FloatArray,
    integral: FloatArray,
    valid: Callable[[FloatArray], bool],
) -> tuple[FloatArray, FloatArray]:
    """Return x ``(k, m)`` at the times ``(m,)`` of an interval, and the tolerance of each ``(k,)``.

    NaN where the Picard iteration does not converge. `rates`: f of x' = f(t, x), from times and x
    to derivatives ``(k, m)``. `begin`: x at the start of the interval, ``(k,)``. `integral`:
    factors from values at the times to integrals up to the times, ``(m, m)``. `valid`: function
    that says whether f may be evaluated at x.
    """
    x = np.broadcast_to(begin[:, np.newaxis], (begin.size, times.size))
    for _ in range(_MAX_ITERATIONS):
        if not valid(x):
            break
        following = begin[:, np.newaxis] + rates(times, x) @ integral.T
        tolerance = _TOLERANCE * np.maximum(np.abs(following).max(axis=1), 1.0)
        if np.all(np.abs(following - x) <= tolerance[:, np.newaxis]):
            return following, tolerance
        x = following
    return np.full_like(x, np.nan), np.zeros(begin.shape)
