"""When the dead band is left on the stability boundary: the general problem, case by case.

It is left when the driver first is as high as K times the demand (see `excess`), on a new height,
and the last such time has the largest limit. Between two changes of sign of h the excess has one
zero at most, and where it is positive in the end it was only negative before if it was so in the
beginning, or where h changed to positive. Nothing else is looked at.
"""

from typing import Any

import numpy as np

from tvclin.kernels.excess import (
    ABOVE,
    ENOUGH,
    ROOM,
    SLACK,
    TRIM_DRIVES,
    TURNS,
    WIND_DRIVES,
    carry,
    changes,
    demand,
    driver,
    onset,
    parts,
    root,
    sought,
)
from tvclin.kernels.source import bare, kernel
from tvclin.kernels.terms import filtered

FOUND, JUMPS, NEVER = 0, 1, 2
"""There is a solution; the demand jumps over it; it is above all that the driver reaches."""

PLAIN, COMPILED = 1e-4, 5e-7
"""Seconds that a breakpoint of a case takes for each rate of its wind, in plain Python and
as machine code."""
FILTERED = {"f": 3, "c": 10}
"""How often as long it takes where trim is filtered, by the kind of the rates."""
_FALLEN = 1e-9
"""A driver that is lower than its earlier height by this part has fallen: more than the rounding of
a time, and less than any jump of a wind that is meant."""


@kernel
def switches(
    winds: Any, which: Any, numbers: Any, literal: Any, out: Any, first: int, last: int
) -> None:
    """Write time [s], demand and status of the cases from `first` up to `last`.

    `winds`: knots, coefficients and rates of winds over their peaks, with one axis for the batch.
    `which`: the wind of each case, ``(n,)``. `numbers`: p, K, b1, b2 and q of each case, ``(n,
    5)``. `literal`: whether the driver is trim itself. `out`: time, demand and status, ``(3, n)``.
    """
    knots, coefficients, rates = winds
    kept, marks, ends = np.empty((3, knots.shape[1])), np.empty((4, 3)), np.empty(ROOM)
    work = np.empty((2, coefficients.shape[3]), coefficients.dtype)
    for case in range(first, last):
        i = which[case]
        p, K, b1, b2, q = (
            numbers[case, 0],
            numbers[case, 1],
            numbers[case, 2],
            numbers[case, 3],
            numbers[case, 4],
        )
        wind = (knots[i], coefficients[i], rates[i], kept, work)
        carry(wind, (p, K, b2 - b1, b1, q, WIND_DRIVES))
        law = (p, K, b2 - b1, b1, q, literal)
        out[0, case], out[1, case], out[2, case] = _solve(wind, law, marks, ends)


@kernel
def largest_trims(winds: Any, which: Any, numbers: Any, out: Any, first: int, last: int) -> None:
    """Write the largest size of trim, over the wind's peak, to ``out (n,)``; the rest as above.

    Infinite where trim grows without end after the wind.
    """
    knots, coefficients, rates = winds
    kept, ends = np.empty((3, knots.shape[1])), np.empty(ROOM)
    work = np.empty((2, coefficients.shape[3]), coefficients.dtype)
    for case in range(first, last):
        i = which[case]
        b1, b2, q = numbers[case, 2], numbers[case, 3], numbers[case, 4]
        wind = (knots[i], coefficients[i], rates[i], kept, work)
        law = (numbers[case, 0], 1.0, b2 - b1, b1, q, TRIM_DRIVES)
        carry(wind, law)
        out[case] = _largest_trim(wind, law, ends)


@bare
def _solve(wind: Any, law: Any, marks: Any, ends: Any) -> tuple[float, float, int]:
    """Return time, demand and status of one case."""
    knots = wind[0]
    K = law[1]
    if K == 0.0:
        i = onset(wind)
        return knots[i], demand(wind, law, i, 0.0), FOUND
    # The last height that is short of the demand, and the first one after it that is not.
    short, enough = False, False
    low, high = (0, 0.0, 0.0, 0.0), (0, 0.0, 0.0)
    highest = 0.0
    for i in range(knots.size - 1):
        for part in range(parts(wind, law, i, ends)):
            heights = _marked(wind, law, marks, highest, i, ends[part], ends[part + 1])
            for k in range(heights):
                u, level, spare = marks[k, 0], marks[k, 1], marks[k, 2]
                if spare < -SLACK * level:
                    short, enough, low = True, False, (i, u, level, spare)
                elif not enough:
                    enough, high = True, (i, u, spare)
                highest = max(highest, level)
    if not enough:
        return knots[-1], 0.0, NEVER
    return _met(wind, law, low if short else (0, 0.0, -np.inf, 0.0), high)


@bare
def _met(wind: Any, law: Any, low: Any, high: Any) -> tuple[float, float, int]:
    """Return time, demand and status, after a low height, which there may not be."""
    i, u, _ = high
    status = FOUND
    if low[2] >= 0.0:
        i, u = _between(wind, law, low, high)
        if _after(wind, law, i, u) < low[2] * (1.0 - _FALLEN):
            status = JUMPS
    return wind[0][i] + u, demand(wind, law, i, u), status


@bare
def _marked(wind: Any, law: Any, marks: Any, highest: float, i: int, a: float, b: float) -> int:
    """Write the times to look at where the driver does not turn: the new heights and what is spare.

    The first is the height that it had before: it may come back to that, or jump over it.
    """
    start, _, _ = driver(wind, law, i, a)
    stop, _, _ = driver(wind, law, i, b)
    top, K = max(start, stop), law[1]
    # Only new heights count. Below the highest so far: nothing, or what is above it.
    if top <= 0.0 or top < highest * (1.0 - SLACK):
        return 0
    if start < highest and stop > highest:
        a = root(ABOVE, highest, wind, law, i, a, start - highest, b, stop - highest)
        start = highest
    elif start < min(stop, highest):
        a, start = b, stop
    # The height before and the height now at a, which differ where the driver jumps.
    needed, count = K * demand(wind, law, i, a), 0
    for level in (min(highest, start), start):
        if level > highest or count == 0:
            marks[count, 0], marks[count, 1], marks[count, 2] = a, level, level - needed
            count += 1
    if stop < start or b == a:
        return count
    # e' = p e + h: if e is positive at b, it was negative between only if it was so at a, or where
    # h changes from - to +, which is looked at.
    spare = stop - K * demand(wind, law, i, b)
    if spare >= -SLACK * stop:
        falls = sought(TURNS, 0.0, wind, law, i, a)[0] < 0.0
        turns, first, second = changes(TURNS, wind, law, i, a, b)
        if turns == 2 or (turns == 1 and falls):
            u = first if falls else second
            level, _, _ = driver(wind, law, i, u)
            marks[count, 0], marks[count, 1] = u, level
            marks[count, 2] = level - K * demand(wind, law, i, u)
            count += 1
    marks[count, 0], marks[count, 1], marks[count, 2] = b, stop, spare
    return count + 1


@bare
def _between(wind: Any, law: Any, low: Any, high: Any) -> tuple[int, float]:
    """Return the piece and the local time at which the demand is met, between two heights."""
    knots, K = wind[0], law[1]
    i, u, floor, spare = low
    while i < high[0]:
        width = knots[i + 1] - knots[i]
        after = max(driver(wind, law, i, width)[0], floor) - K * demand(wind, law, i, width)
        if width > u and after >= 0.0:
            return i, root(ENOUGH, floor, wind, law, i, u, spare, width, after)
        i, u = i + 1, 0.0
        spare = max(driver(wind, law, i, u)[0], floor) - K * demand(wind, law, i, u)
        if spare >= 0.0:
            return i, u
    if high[1] == u:
        return i, u
    return i, root(ENOUGH, floor, wind, law, i, u, spare, high[1], high[2])


@bare
def _after(wind: Any, law: Any, i: int, u: float) -> float:
    """Return the driver just after a time."""
    knots = wind[0]
    while i < knots.size - 1 and u >= knots[i + 1] - knots[i]:
        i, u = i + 1, 0.0
    return driver(wind, law, i, u)[0]


@bare
def _largest_trim(wind: Any, law: Any, ends: Any) -> float:
    """Return the largest size of trim, during the wind and after it."""
    most = 0.0
    for i in range(wind[0].size - 1):
        for part in range(parts(wind, law, i, ends)):
            for k in (part, part + 1):
                most = max(most, abs(driver(wind, law, i, ends[k])[0]))
    return max(most, _largest_swing(wind, law))


@bare
def _largest_swing(wind: Any, law: Any) -> float:
    """Return the largest size of trim after the wind; infinite where it grows without end.

    Without wind v = y' obeys v'' + b1 v' + q v = 0, so with w^2 = q - b1^2/4 it is

        v(u) = e^(-b1 u/2) [v cos(w u) + (v' + b1 v/2) sin(w u)/w],

    and y is largest where that is zero, tan(w u) = -w v/(v' + b1 v/2): at the first u > 0, and with
    tanh where w^2 is negative.
    """
    _, c, rates, kept, work = wind
    _, _, gain, b1, q, _ = law
    last = kept.shape[1] - 1
    x, y = kept[1, last], kept[2, last]
    if gain == 0.0 or (y == 0.0 and q * x == 0.0):
        return 0.0
    if b1 < 0.0:
        return np.inf
    slope = -b1 * y - q * x
    bend = -0.5 * b1 * slope - q * y
    square = q - 0.25 * b1 * b1
    pace = np.sqrt(abs(square))
    u = 0.0
    if square > 0.0:
        turn = np.arctan2(-slope * pace, bend)
        u = (turn if turn > 0.0 else turn + np.pi) / pace
    elif 0.0 < -slope * pace < bend or bend < -slope * pace < 0.0:
        u = np.arctanh(-slope * pace / bend) / pace
    _, later = filtered(c[last], rates, u, x, y, b1, q, work)
    return abs(gain) * max(abs(y), abs(later))
