"""Positive roots of many polynomials with real coefficients, the constant first.

What takes time is the search for one root between two bounds, where each step waits for the one
before. So sixteen searches go side by side, of whatever polynomials have one to do.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.compiled.compiler import lean
from tvclin.kernels.compiled.polynomials import degree_of, value

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

SIZE = 32
"""Room for the coefficients of the longest polynomial: of order 23, for a loop of order 12."""
LANES = 16
"""Searches side by side."""
_ALL = np.uint64(LANES)
_TOGETHER = 4
"""Coefficients that are added in one loop over the lanes; they divide `SIZE`."""
_STEPS = 200
_LAST = 1e-8
"""After so small a step, over the root, it is exact: Laguerre's steps cube what is left."""

_PLACE, _LOW, _HIGH, _UP, _DEGREE, _SOUGHT, _VALUE, _SLOPE, _BEND = (
    np.uint64(LANES * number) for number in range(9)
)
"""Where the rows of the searches begin: where each is, its bounds and whether its polynomial
rises between them, the degree, 1 until the root is found, and value, slope and half the second
derivative."""


class Searches(NamedTuple):
    """Sixteen searches: coefficients and rows, lanes innermost, and where the roots belong.

    Behind them what the next searches are made of: a polynomial and the roots of another, and of
    all polynomials the degree and how often the coefficients change their sign.
    """

    terms: FloatArray
    rows: FloatArray
    cases: IntArray
    numbers: IntArray
    reduced: FloatArray
    edges: FloatArray
    degrees: IntArray
    changes: IntArray


def searches(cases: int) -> Searches:
    """Return room for searches for roots of so many polynomials."""
    terms, rows = np.zeros(SIZE * LANES), np.zeros(9 * LANES)
    which, one = np.zeros((2, LANES), dtype=np.intp), np.zeros((2, SIZE))
    counts = np.zeros((2, cases), dtype=np.intp)
    return Searches(terms, rows, which[0], which[1], one[0], one[1], counts[0], counts[1])


@lean
def positive_roots(
    p: FloatArray, cases: int, work: Searches, roots: FloatArray, counts: IntArray
) -> None:
    """Write the positive roots at which each polynomial changes its sign, rising.

    Between two roots of p there is one of x p' - j p, whatever j is. Its coefficients (k - j) p_k
    change their sign once less often than p_k if these change it behind the j-th. So for each
    polynomial others are made, down to one with a single root by the rule of Descartes, and their
    roots are found in turn: between two of them there is one of the next at most. Nothing can be
    missed or found twice.

    Parameters
    ----------
    p : ndarray
        Coefficients, ``(>= cases, SIZE)``.
    cases : int
        How many polynomials there are.
    work : Searches
        Work space.
    roots, counts : ndarray
        Where to write the roots, and how many there are, ``(>= cases, SIZE)`` and ``(>= cases,)``.
    """
    most, highest = 0, 0
    for case in range(cases):
        degree = degree_of(p[case])
        changes = _changes(p[case], degree)
        work.degrees[case], work.changes[case], counts[case] = degree, changes, 0
        most, highest = max(most, changes), max(highest, degree)
    parts = highest // _TOGETHER + 1
    for removed in range(most - 1, -1, -1):
        waiting = 0
        for case in range(cases):
            if work.changes[case] > removed:
                waiting = _between(p[case], removed, parts, work, waiting, case, roots, counts)
        _solve(work, parts, waiting, roots)


@lean
def _changes(p: FloatArray, degree: int) -> int:
    """Return how often the coefficients change their sign."""
    changes, positive = 0, p[degree] > 0.0
    for k in range(degree - 1, -1, -1):
        if p[k] != 0.0 and (p[k] > 0.0) != positive:
            changes, positive = changes + 1, not positive
    return changes


@lean
def _reduce(p: FloatArray, degree: int, removed: int, q: FloatArray) -> int:
    """Write the polynomial that lacks the first changes of sign, and return its degree."""
    for k in range(degree + 1):
        q[k] = p[k]
    last = 0
    for k in range(degree + 1):
        if removed > 0 and p[k] != 0.0:
            if (p[k] > 0.0) != (p[last] > 0.0) and p[last] != 0.0:
                for i in range(degree + 1):
                    q[i] *= float(i - last)
                removed -= 1
            last = k
    lowest = 0
    while q[lowest] == 0.0:
        lowest += 1
    if lowest > 0:
        for k in range(degree - lowest + 1):
            q[k] = q[k + lowest]
    return degree - lowest


@lean
def _between(
    p: FloatArray,
    removed: int,
    parts: int,
    work: Searches,
    waiting: int,
    case: int,
    roots: FloatArray,
    counts: IntArray,
) -> int:
    """Begin a search in each part in which a reduced polynomial changes its sign.

    The parts lie between the roots of the next one. Return how many searches wait.
    """
    q, edges, count = work.reduced, work.edges, counts[case]
    degree = _reduce(p, work.degrees[case], removed, q)
    for j in range(count):
        edges[j] = roots[case, j]
    found, left, left_positive = 0, 0.0, q[0] > 0.0
    for j in range(count + 1):
        right, right_positive = math.inf, q[degree] > 0.0
        if j < count:
            right = edges[j]
            height = value(q, degree, right)
            right_positive = left_positive if height == 0.0 else height > 0.0
        if right_positive != left_positive:
            if waiting == LANES:
                _solve(work, parts, waiting, roots)
                waiting = 0
            _begin(work, waiting, degree, parts, left, right, right_positive)
            work.cases[waiting], work.numbers[waiting] = case, found
            found += 1
            waiting += 1
        left, left_positive = right, right_positive
    counts[case] = found
    return waiting


@lean
def _begin(
    work: Searches, lane: int, degree: int, parts: int, low: float, high: float, rising: bool
) -> None:
    """Begin to search the only root between two bounds, zero and infinity included."""
    i, rows = np.uint64(lane), work.rows
    for k in range(_TOGETHER * parts):
        work.terms[np.uint64(k * LANES) + i] = work.reduced[k] if k <= degree else 0.0
    if high == math.inf:
        start = max(_guess(work.reduced, degree), 2.0 * low)
    else:
        start = math.sqrt(low * high) if low > 0.0 else 0.25 * high
    rows[_PLACE + i], rows[_LOW + i], rows[_HIGH + i] = start, low, high
    rows[_UP + i], rows[_DEGREE + i] = 1.0 if rising else -1.0, float(degree)
    rows[_SOUGHT + i] = 1.0


@lean
def _guess(q: FloatArray, degree: int) -> float:
    """Return where the two terms are equal between which the sign changes last."""
    above = degree
    for k in range(degree - 1, -1, -1):
        if q[k] != 0.0:
            if (q[k] > 0.0) != (q[degree] > 0.0):
                ratio, apart = abs(q[k] / q[above]), above - k
                return ratio if apart == 1 else ratio ** (1.0 / apart)
            above = k
    return 1.0


@lean
def _solve(work: Searches, parts: int, waiting: int, roots: FloatArray) -> None:
    """Go to the ends of the first searches, and write the roots."""
    for i in range(np.uint64(waiting), _ALL):
        work.rows[_SOUGHT + i] = 0.0
    for _ in range(_STEPS):
        _look(work.terms, work.rows, parts)
        if _step(work.rows) == 0:
            break
    for lane in range(waiting):
        roots[work.cases[lane], work.numbers[lane]] = work.rows[_PLACE + np.uint64(lane)]


@lean
def _look(terms: FloatArray, rows: FloatArray, parts: int) -> None:
    """Write value, slope and half the second derivative where the searches are."""
    for i in range(_ALL):
        rows[_VALUE + i], rows[_SLOPE + i], rows[_BEND + i] = 0.0, 0.0, 0.0
    for part in range(parts - 1, -1, -1):
        _add(terms, rows, np.uint64(part * _TOGETHER * LANES))


@lean
def _add(terms: FloatArray, rows: FloatArray, begin: np.uint64) -> None:
    """Go on with value, slope and half the second derivative by some coefficients."""
    for i in range(_ALL):
        x = rows[_PLACE + i]
        height, slope, bend = rows[_VALUE + i], rows[_SLOPE + i], rows[_BEND + i]
        for k in range(_TOGETHER - 1, -1, -1):
            bend = bend * x + slope
            slope = slope * x + height
            height = height * x + terms[begin + np.uint64(k * LANES) + i]
        rows[_VALUE + i], rows[_SLOPE + i], rows[_BEND + i] = height, slope, bend


@lean
def _step(rows: FloatArray) -> int:
    """Take a step of Laguerre, or halve the bounds where it leads out; return how many go on."""
    left = 0
    for i in range(_ALL):
        x, height, slope = rows[_PLACE + i], rows[_VALUE + i], rows[_SLOPE + i]
        beyond = height * rows[_UP + i] > 0.0
        low = rows[_LOW + i] if beyond else x
        high = x if beyond else rows[_HIGH + i]
        apart, bent = height / slope, rows[_BEND + i] / slope
        others = rows[_DEGREE + i] - 1.0
        square = others * (others - 2.0 * (others + 1.0) * apart * bent)
        new = x - (others + 1.0) * apart / (1.0 + math.sqrt(max(square, 0.0)))
        half = _half(low, high)
        near = abs(new - x) <= _LAST * x
        inside = (new > low) & (new < high)
        stuck = (half == low) | (half == high)
        new = new if near | inside else half
        new = x if height == 0.0 else new
        ended = near | (height == 0.0) | (stuck & (not inside))
        sought = rows[_SOUGHT + i]
        rows[_PLACE + i] = new if sought > 0.0 else x
        rows[_LOW + i], rows[_HIGH + i] = low, high
        sought = 0.0 if ended else sought
        rows[_SOUGHT + i] = sought
        left += 1 if sought > 0.0 else 0
    return left


@lean
def _half(low: float, high: float) -> float:
    """Return a place between two bounds, zero and infinity included."""
    middle = math.sqrt(low * high)
    middle = 4.0 * low if high == math.inf else middle
    return 0.25 * high if low == 0.0 else middle
