"""When the dead band is left on the stability boundary: the general problem, case by case.

With the wind f of a unit peak and the state y of its filter (see `terms`), trim is
g = f + (b2 - b1) y, the driver d is f or g, and the demand is

    D(t) = p integral from t on of e^(-p (r - t)) g(r) dr,      D' = p (D - g)

The excess e = d - K D follows e' = p e + h with h = d' - p d + K p g. So between two changes of
sign of h it has one zero at most, and where it is positive in the end it was only negative before
if it was so in the beginning, or where h changed to positive. Nothing else is looked at.
"""

from typing import Any

import numpy as np

from tvclin.kernels.source import bare, kernel
from tvclin.kernels.terms import filtered, future, value

FOUND, JUMPS, NEVER = 0, 1, 2
"""There is a solution; the demand jumps over it; it is above all that the driver reaches."""

_SLACK = 8.0 * 2.0**-52
_FALLEN = 1e-9
"""A driver that is lower than its earlier height by this part has fallen."""
_CELLS, _PER_RATE = 64.0, 4.0
"""Cells of a piece, at most and for each unit of its rates times its width: within one, no second
derivative changes its sign twice."""
_RISES, _TURNS, _ABOVE, _ENOUGH = 0, 1, 2, 3
_STEPS = 80
_ARRIVED = 1e-9
"""Newton's step over the width of the bracket after which the error is below rounding."""


@kernel
def switches(
    winds: Any, which: Any, numbers: Any, literal: Any, out: Any, first: int, last: int
) -> None:
    """Write time [s], demand and status of the cases from `first` up to `last`.

    Parameters
    ----------
    winds
        Knots, coefficients and rates of winds over their peaks, with one axis for the batch.
    which
        The wind of each case, ``(n,)``.
    numbers
        p, K, b1, b2 and q of each case, ``(n, 5)``.
    literal
        For each driver that is asked for, whether it is trim itself, ``(m,)``.
    out
        Time, demand and status, ``(n, m, 3)``.
    """
    knots, coefficients, rates = winds
    kept, marks = np.empty((3, knots.shape[1])), np.empty((4, 3))
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
        carry(wind, (p, K, b2 - b1, b1, q, False))
        for k in range(literal.size):
            law = (p, K, b2 - b1, b1, q, literal[k])
            time, needed, status = _solve(wind, law, marks)
            out[case, k, 0], out[case, k, 1], out[case, k, 2] = time, needed, status


@kernel
def largest_futures(winds: Any, which: Any, poles: Any, out: Any, first: int, last: int) -> None:
    """Write p times a wind's discounted future, over its peak, where it is largest.

    At the onset, the largest, and its time [s], to ``out (n, 3)``, for ``poles (n,)`` [1/s]. It
    rises as long as it is above the wind, W' = p (W - f): it is largest at a knot, or where a wind
    that rises comes up to it.
    """
    knots, coefficients, rates = winds
    kept = np.empty((3, knots.shape[1]))
    work = np.empty((2, coefficients.shape[3]), coefficients.dtype)
    for case in range(first, last):
        i = which[case]
        wind = (knots[i], coefficients[i], rates[i], kept, work)
        law = (poles[case], 1.0, 0.0, 0.0, 0.0, False)
        carry(wind, law)
        most, time = _largest_future(wind, law)
        out[case, 0], out[case, 1], out[case, 2] = demand(wind, law, _onset(wind), 0.0), most, time


@kernel
def from_onset(winds: Any, which: Any, poles: Any, out: Any, first: int, last: int) -> None:
    """Write the discounted futures of winds at their onset to ``out (n, m)``.

    For ``poles (n, m)`` [1/s], which may be complex.
    """
    knots, c, rates = winds
    for case in range(first, last):
        i = which[case]
        for k in range(poles.shape[1]):
            p, ahead = poles[case, k], 0.0 * (poles[case, k] * c[i, 0, 0, 0])
            onset = _onset((knots[i], c[i], rates[i], knots, knots))
            for j in range(knots.shape[1] - 2, onset - 1, -1):
                width = knots[i, j + 1] - knots[i, j]
                part = future(c[i, j], rates[i], 0.0, width, p)
                ahead = np.exp(-p * width) * ahead + part
            out[case, k] = ahead


@kernel
def largest_trims(winds: Any, which: Any, numbers: Any, out: Any, first: int, last: int) -> None:
    """Write the largest size of trim, over the wind's peak, to ``out (n,)``; the rest as above.

    Infinite where trim grows without end after the wind.
    """
    knots, coefficients, rates = winds
    kept = np.empty((3, knots.shape[1]))
    work = np.empty((2, coefficients.shape[3]), coefficients.dtype)
    for case in range(first, last):
        i = which[case]
        b1, b2, q = numbers[case, 2], numbers[case, 3], numbers[case, 4]
        wind = (knots[i], coefficients[i], rates[i], kept, work)
        law = (numbers[case, 0], 1.0, b2 - b1, b1, q, True)
        carry(wind, law)
        out[case] = _largest_trim(wind, law)


@bare
def carry(wind: Any, law: Any) -> None:
    """Keep the wind's discounted future and the filter's state at each knot, in ``kept (3, n)``."""
    knots, c, rates, kept, work = wind
    p, _, gain, b1, q, _ = law
    last = knots.size - 1
    kept[0, last] = 0.0
    for i in range(last - 1, -1, -1):
        width = knots[i + 1] - knots[i]
        rest = np.exp(-p * width) * kept[0, i + 1]
        kept[0, i] = future(c[i], rates, 0.0, width, p).real + rest
    kept[1, 0], kept[2, 0] = 0.0, 0.0
    for i in range(last):
        x, y = 0.0, 0.0
        if gain != 0.0:
            width = knots[i + 1] - knots[i]
            x, y = filtered(c[i], rates, width, kept[1, i], kept[2, i], b1, q, work)
        kept[1, i + 1], kept[2, i + 1] = x, y


@bare
def _solve(wind: Any, law: Any, marks: Any) -> tuple[float, float, int]:
    """Return time, demand and status of one case."""
    knots = wind[0]
    K = law[1]
    if K == 0.0:
        i = _onset(wind)
        return knots[i], demand(wind, law, i, 0.0), FOUND
    # The last height that is short of the demand, and the first one after it that is not.
    short, enough = False, False
    low, high = (0, 0.0, 0.0, 0.0), (0, 0.0, 0.0)
    highest = 0.0
    for i in range(knots.size - 1):
        width = knots[i + 1] - knots[i]
        if width <= 0.0:
            continue
        count = cells(wind, law, i)
        for cell in range(count):
            a, end = width * cell / count, width * (cell + 1) / count
            turns, first, second = changes(_RISES, wind, law, i, a, end)
            for part in range(turns + 1):
                b = end if part == turns else (first if part == 0 else second)
                heights = _marked(wind, law, marks, highest, i, a, b)
                for k in range(heights):
                    u, level, spare = marks[k, 0], marks[k, 1], marks[k, 2]
                    if spare < -_SLACK * level:
                        short, enough, low = True, False, (i, u, level, spare)
                    elif not enough:
                        enough, high = True, (i, u, spare)
                    highest = max(highest, level)
                a = b
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
def _largest_future(wind: Any, law: Any) -> tuple[float, float]:
    """Return the largest demand of the wind itself, and its time."""
    knots = wind[0]
    most, time = -np.inf, 0.0
    for i in range(knots.size - 1):
        width = knots[i + 1] - knots[i]
        here = demand(wind, law, i, 0.0)
        if here > most:
            most, time = here, knots[i]
        if width <= 0.0:
            continue
        count = cells(wind, law, i)
        for cell in range(count):
            a, end = width * cell / count, width * (cell + 1) / count
            turns, first, second = changes(_RISES, wind, law, i, a, end)
            for part in range(turns + 1):
                b = end if part == turns else (first if part == 0 else second)
                top = driver(wind, law, i, b)[0]
                before = driver(wind, law, i, a)[0] - demand(wind, law, i, a)
                after = top - demand(wind, law, i, b)
                if before < 0.0 < after and top > most:
                    u = root(_ENOUGH, -np.inf, wind, law, i, a, before, b, after)
                    here = demand(wind, law, i, u)
                    if here > most:
                        most, time = here, knots[i] + u
                a = b
    return most, time


@bare
def _largest_trim(wind: Any, law: Any) -> float:
    """Return the largest size of trim, during the wind and after it."""
    knots = wind[0]
    most, last = 0.0, knots.size - 1
    for i in range(last):
        width = knots[i + 1] - knots[i]
        if width <= 0.0:
            continue
        count = cells(wind, law, i)
        for cell in range(count):
            a, b = width * cell / count, width * (cell + 1) / count
            turns, first, second = changes(_RISES, wind, law, i, a, b)
            most = max(most, abs(driver(wind, law, i, a)[0]), abs(driver(wind, law, i, b)[0]))
            if turns > 0:
                most = max(most, abs(driver(wind, law, i, first)[0]))
            if turns > 1:
                most = max(most, abs(driver(wind, law, i, second)[0]))
    return max(most, _largest_swing(wind, law))


@bare
def _largest_swing(wind: Any, law: Any) -> float:
    """Return the largest size of trim after the wind; infinite where it grows without end.

    The state is y' = 0 where tan(w u)/w = -y'/(y'' + b1 y'/2), w^2 = q - b1^2/4.
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


@bare
def _marked(wind: Any, law: Any, marks: Any, highest: float, i: int, a: float, b: float) -> int:
    """Write the times to look at where the driver does not turn: the new heights and what is spare.

    The first is the height that it had before: it may come back to that, or jump over it.
    """
    start, _, _ = driver(wind, law, i, a)
    stop, _, _ = driver(wind, law, i, b)
    top, K = max(start, stop), law[1]
    if top <= 0.0 or top < highest * (1.0 - _SLACK):
        return 0
    if start < highest and stop > highest:
        a = root(_ABOVE, highest, wind, law, i, a, start - highest, b, stop - highest)
        start = highest
    elif start < min(stop, highest):
        a, start = b, stop
    needed, count = K * demand(wind, law, i, a), 0
    for level in (min(highest, start), start):
        if level > highest or count == 0:
            marks[count, 0], marks[count, 1], marks[count, 2] = a, level, level - needed
            count += 1
    if stop < start or b == a:
        return count
    spare = stop - K * demand(wind, law, i, b)
    if spare >= -_SLACK * stop:
        falls = sought(_TURNS, 0.0, wind, law, i, a)[0] < 0.0
        turns, first, second = changes(_TURNS, wind, law, i, a, b)
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
            return i, root(_ENOUGH, floor, wind, law, i, u, spare, width, after)
        i, u = i + 1, 0.0
        spare = max(driver(wind, law, i, u)[0], floor) - K * demand(wind, law, i, u)
        if spare >= 0.0:
            return i, u
    if high[1] == u:
        return i, u
    return i, root(_ENOUGH, floor, wind, law, i, u, spare, high[1], high[2])


@bare
def _after(wind: Any, law: Any, i: int, u: float) -> float:
    """Return the driver just after a time."""
    knots = wind[0]
    while i < knots.size - 1 and u >= knots[i + 1] - knots[i]:
        i, u = i + 1, 0.0
    return driver(wind, law, i, u)[0]


@bare
def _onset(wind: Any) -> int:
    """Return the first piece in which the wind blows."""
    knots, c, _, _, _ = wind
    for i in range(knots.size - 1):
        if knots[i + 1] > knots[i]:
            for r in range(c.shape[1]):
                for k in range(c.shape[2]):
                    if c[i, r, k] != 0.0:
                        return i
    return knots.size - 1


@bare
def cells(wind: Any, law: Any, i: int) -> int:
    """Return in how many parts a piece is looked at."""
    knots, c, rates, _, _ = wind
    _, _, gain, b1, q, _ = law
    fastest = 0.0
    for r in range(rates.size):
        for k in range(c.shape[2]):
            if c[i, r, k] != 0.0:
                fastest = max(fastest, _PER_RATE * abs(rates[r]))
    if gain != 0.0 and q != 0.0:
        fastest = max(fastest, abs(b1), np.sqrt(q))
    bent = _PER_RATE * (c.shape[2] - 2) if c.shape[2] > 2 else 0.0
    return 1 + int(min(fastest * (knots[i + 1] - knots[i]) + bent, _CELLS))


@bare
def state(wind: Any, law: Any, i: int, u: float) -> tuple[float, float]:
    """Return the filter's state in a piece."""
    knots, c, rates, kept, work = wind
    _, _, gain, b1, q, _ = law
    if gain == 0.0 or u == 0.0:
        return kept[1, i], kept[2, i]
    if u == knots[i + 1] - knots[i]:
        return kept[1, i + 1], kept[2, i + 1]
    return filtered(c[i], rates, u, kept[1, i], kept[2, i], b1, q, work)


@bare
def _trim(law: Any, blows: Any, x: float, y: float) -> tuple[float, float, float]:
    """Return trim, its slope and its curvature, of those of the wind and the filter's state."""
    _, _, gain, b1, q, _ = law
    f, slope, bend = blows
    first = f - b1 * y - q * x
    return f + gain * y, slope + gain * first, bend + gain * (slope - b1 * first - q * y)


@bare
def driver(wind: Any, law: Any, i: int, u: float) -> tuple[float, float, float]:
    """Return the driver, its slope and its curvature in a piece."""
    blows = value(wind[1][i], wind[2], u)
    if not law[5] or law[2] == 0.0:
        return blows
    x, y = state(wind, law, i, u)
    return _trim(law, blows, x, y)


@bare
def demand(wind: Any, law: Any, i: int, u: float) -> float:
    """Return the demand in a piece: infinite where trim outgrows the mode."""
    x, y = state(wind, law, i, u)
    return _demand(wind, law, i, u, x, y)


@bare
def _demand(wind: Any, law: Any, i: int, u: float, x: float, y: float) -> float:
    """Return the demand of the wind to come and the filter's state."""
    knots, c, rates, kept, _ = wind
    p, _, gain, b1, q, _ = law
    width = knots[i + 1] - knots[i] if i < knots.size - 1 else 0.0
    if u == 0.0:
        ahead = kept[0, i]
    elif u == width:
        ahead = kept[0, i + 1]
    else:
        left = width - u
        ahead = future(c[i], rates, u, left, p).real + np.exp(-p * left) * kept[0, i + 1]
    if gain == 0.0:
        return p * ahead
    if -0.5 * b1 + np.sqrt(max(0.25 * b1 * b1 - q, 0.0)) >= p:
        return np.inf
    return p * (ahead + gain * (y + ahead - q * x / p) / (p + b1 + q / p))


@bare
def sought(
    kind: int, floor: float, wind: Any, law: Any, i: int, u: float
) -> tuple[float, float, float]:
    """Return what is zero where something happens, its slope, and its curvature or zero."""
    p, K, gain, _, _, literal = law
    blows = value(wind[1][i], wind[2], u)
    x, y = 0.0, 0.0
    if gain != 0.0 and (literal or kind in (_TURNS, _ENOUGH)):
        x, y = state(wind, law, i, u)
    g, g_slope, g_bend = _trim(law, blows, x, y)
    d, slope, bend = (g, g_slope, g_bend) if literal else blows
    if kind == _RISES:
        return slope, bend, 0.0
    if kind == _TURNS:
        return slope - p * d + K * p * g, bend - p * slope + K * p * g_slope, 0.0
    if kind == _ABOVE:
        return d - floor, slope, bend
    if d < floor:
        d, slope, bend = floor, 0.0, 0.0
    needed = _demand(wind, law, i, u, x, y)
    grows = p * (needed - g)
    return d - K * needed, slope - K * grows, bend - K * p * (grows - g_slope)


@bare
def changes(kind: int, wind: Any, law: Any, i: int, a: float, b: float) -> tuple[int, float, float]:
    """Return how often something changes its sign in a cell, twice at most, and when."""
    at_a, slope_a, _ = sought(kind, 0.0, wind, law, i, a)
    at_b, slope_b, _ = sought(kind, 0.0, wind, law, i, b)
    if at_a * at_b < 0.0:
        return 1, root(kind, 0.0, wind, law, i, a, at_a, b, at_b), b
    # A dip lies above the tangents at its ends, which are drawn closer to its bottom.
    side = 1.0 if at_a > 0.0 or at_b > 0.0 else -1.0
    begin, at_begin, end, at_end = a, at_a, b, at_b
    for _ in range(_STEPS):
        if not side * slope_a < 0.0 < side * slope_b:
            break
        bottom = (at_b - at_a + slope_a * a - slope_b * b) / (slope_a - slope_b)
        if side * (at_a + slope_a * (bottom - a)) >= 0.0 or not a < bottom < b:
            break
        here, slope, _ = sought(kind, 0.0, wind, law, i, bottom)
        if side * here < 0.0:
            first = root(kind, 0.0, wind, law, i, begin, at_begin, bottom, here)
            return 2, first, root(kind, 0.0, wind, law, i, bottom, here, end, at_end)
        if side * slope < 0.0:
            a, at_a, slope_a = bottom, here, slope
        else:
            b, at_b, slope_b = bottom, here, slope
    return 0, begin, end


@bare
def root(
    kind: int,
    floor: float,
    wind: Any,
    law: Any,
    i: int,
    a: float,
    at_a: float,
    b: float,
    at_b: float,
) -> float:
    """Return the local time at which something changes its sign, by Halley's steps in a bracket."""
    if at_a * at_b >= 0.0:
        return a if at_a == 0.0 else b
    least = _ARRIVED * (b - a)
    u = a + (b - a) * at_a / (at_a - at_b)
    for _ in range(_STEPS):
        here, slope, bend = sought(kind, floor, wind, law, i, u)
        if here * at_b < 0.0:
            a = u
        else:
            b = u
        curved = slope * slope - 0.5 * here * bend
        step = -here * slope / curved if curved > 0.0 else 2.0 * (b - a)
        if a <= u + step <= b:
            u += step
            if abs(step) <= least:
                return u
        else:
            step = 0.5 * (a + b) - u
            u += step
            if abs(step) <= _SLACK * b:
                return u
    return u
