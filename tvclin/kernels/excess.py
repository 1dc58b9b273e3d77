"""Trim, driver, demand and excess in a segment of a wind, and when they change their sign.

With the wind f of a unit peak and the state y of its filter (see `terms`), trim is
g = f + (b2 - b1) y, eq (B8): (s^2 + b2 s + q)/(s^2 + b1 s + q) is 1 + (b2 - b1) s/(s^2 + b1 s + q).
The driver d is f or g, and the demand is the deflection that, held from t on, meets (4b),

    D(t) = p integral from t on of e^(-p (r - t)) g(r) dr,      D' = p (D - g).

The excess e = d - K D follows e' = p e + h with h = d' - p d + K p g. So between two changes of
sign of h it has one zero at most.

Everywhere `wind` is its breakpoints, coefficients and rates, what `carry` keeps, and room to work
in; `law` is p, K, b2 - b1, b1, q, and whether trim itself drives. Times u are local to segment i.
"""

from typing import Any

import numpy as np

from tvclin.kernels.source import bare
from tvclin.kernels.terms import filtered, future, value

RISES, TURNS, ABOVE, ENOUGH = map(np.int64, range(4))
"""What may change its sign: the driver's slope; h; the driver over a height; the excess. These are
numbers of numpy, since a kernel that takes constants of Python's own is compiled for each anew."""
WIND_DRIVES, TRIM_DRIVES = np.False_, np.True_
"""Whether trim itself is the driver."""
SLACK = 8.0 * 2.0**-52
"""Rounding of a height or a demand, over its size: an excess nearer to zero than this is zero. With
less, rounding alone would say that a limit is short; with more, limits would lose digits."""
_CELLS, _PER_RATE = 64.0, 4.0
"""Cells of a segment, at most and for each unit of its rates times its width: within one, no second
derivative changes its sign twice. With fewer a dip of the excess in a wind that swings fast could
be stepped over."""
ROOM = 3 * (1 + int(_CELLS)) + 1
"""Of `parts`, of which a cell has three at most."""
_STEPS = 80
"""Halvings after which a bracket of any width is down to its rounding (a number has 53 bits)."""
_ARRIVED = 1e-9
"""Newton's step over the width of the bracket after which the error is below rounding: the error
that follows is of the order of its square, with Halley's curvature of its cube."""


@bare
def carry(wind: Any, law: Any) -> None:
    """Keep the wind's discounted future and the filter's state at each breakpoint, ``kept (3, n)``.

    Backwards W_i = integral over the segment + e^(-p width) W_(i+1), forwards x and y = x' of the
    filter.
    """
    knots, c, rates, kept, _ = wind
    p, last = law[0], knots.size - 1
    kept[0, last] = 0.0
    for i in range(last - 1, -1, -1):
        width = knots[i + 1] - knots[i]
        rest = np.exp(-p * width) * kept[0, i + 1]
        kept[0, i] = future(c[i], rates, 0.0, width, p).real + rest
    drift(wind, law)


@bare
def drift(wind: Any, law: Any) -> None:
    """Keep the filter's state at each breakpoint alone, in the last two rows of ``kept (3, n)``."""
    knots, c, rates, kept, work = wind
    _, _, gain, b1, q, _ = law
    kept[1, 0], kept[2, 0] = 0.0, 0.0
    for i in range(knots.size - 1):
        x, y = 0.0, 0.0
        if gain != 0.0:
            width = knots[i + 1] - knots[i]
            x, y = filtered(c[i], rates, width, kept[1, i], kept[2, i], b1, q, work)
        kept[1, i + 1], kept[2, i + 1] = x, y


@bare
def onset(wind: Any) -> int:
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
    """Return in how many parts a segment is looked at.

    One more than the fastest rate in it times its width, at the scale of `_PER_RATE`: of the wind's
    exponentials, and where trim is driven through a filter of second order of that, b1 and sqrt(q).
    """
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
def parts(wind: Any, law: Any, i: int, ends: Any) -> int:
    """Write the times between which the driver only rises or only falls in a piece, ``ends``.

    Returned: in how many parts, in none where the piece has no width.
    """
    width, count = wind[0][i + 1] - wind[0][i], 0
    ends[0] = 0.0
    if width <= 0.0:
        return count
    every = cells(wind, law, i)
    for cell in range(every):
        a, b = width * cell / every, width * (cell + 1) / every
        turns, first, second = changes(RISES, wind, law, i, a, b)
        if turns > 0:
            ends[count + 1] = first
        if turns > 1:
            ends[count + 2] = second
        count += turns + 1
        ends[count] = b
    return count


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
    """Return trim, its slope and its curvature, of those of the wind and the filter's state.

    g = f + (b2 - b1) y with y' = f - b1 y - q x, x' = y, and so y'' = f' - b1 y' - q y.
    """
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
    """Return the demand of the wind to come and the filter's state: infinite as `demand` is.

    That is where the filter grows as fast as the mode, -b1/2 + sqrt(b1^2/4 - q) >= p.
    """
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
    if gain != 0.0 and -0.5 * b1 + np.sqrt(max(0.25 * b1 * b1 - q, 0.0)) >= p:
        return np.inf
    return of_future(law, p, ahead, x, y)


@bare
def to_come(wind: Any, i: int, u: float, p: Any) -> Any:
    """Return the wind's future at a time, integral of e^(-p r) f(t + r) dr over what is to come."""
    knots, c, rates, _, _ = wind
    total = 0.0 * (p * c[0, 0, 0])
    for j in range(knots.size - 2, i, -1):
        width = knots[j + 1] - knots[j]
        total = future(c[j], rates, 0.0, width, p) + np.exp(-p * width) * total
    left = knots[i + 1] - knots[i] - u
    return future(c[i], rates, u, left, p) + np.exp(-p * left) * total


@bare
def of_future(law: Any, p: Any, ahead: Any, x: float, y: float) -> Any:
    """Return the demand of a mode p, which may be complex, by the wind's future and a state.

    With W the future of the wind, integral of e^(-p r) f(t + r), and the state (x, y) at t, the
    Laplace transform of y' = f - b1 y - q x, x' = y from t on is

        Y (p + b1 + q/p) = W + y - q x/p,        D = p [W + (b2 - b1) Y].
    """
    _, _, gain, b1, q, _ = law
    if gain == 0.0:
        return p * ahead
    return p * (ahead + gain * (y + ahead - q * x / p) / (p + b1 + q / p))


@bare
def sought(
    kind: Any, floor: float, wind: Any, law: Any, i: int, u: float
) -> tuple[float, float, float]:
    """Return what is zero where something happens, its slope, and its curvature or zero.

    RISES: d'. TURNS: h = d' - p d + K p g. ABOVE: d - floor. ENOUGH: e = max(d, floor) - K D, with
    D' = p (D - g) and D'' = p (D' - g'). The first two have no curvature: a root of them is then
    sought by Newton's steps.
    """
    p, K, gain, _, _, literal = law
    blows = value(wind[1][i], wind[2], u)
    x, y = 0.0, 0.0
    if gain != 0.0 and (literal or kind in (TURNS, ENOUGH)):
        x, y = state(wind, law, i, u)
    g, g_slope, g_bend = _trim(law, blows, x, y)
    d, slope, bend = (g, g_slope, g_bend) if literal else blows
    if kind == RISES:
        return slope, bend, 0.0
    if kind == TURNS:
        return slope - p * d + K * p * g, bend - p * slope + K * p * g_slope, 0.0
    if kind == ABOVE:
        return d - floor, slope, bend
    if d < floor:
        d, slope, bend = floor, 0.0, 0.0
    needed = _demand(wind, law, i, u, x, y)
    grows = p * (needed - g)
    return d - K * needed, slope - K * grows, bend - K * p * (grows - g_slope)


@bare
def changes(kind: Any, wind: Any, law: Any, i: int, a: float, b: float) -> tuple[int, float, float]:
    """Return how often something changes its sign in a cell, twice at most, and when."""
    at_a, slope_a, _ = sought(kind, 0.0, wind, law, i, a)
    at_b, slope_b, _ = sought(kind, 0.0, wind, law, i, b)
    if at_a * at_b < 0.0:
        return 1, root(kind, 0.0, wind, law, i, a, at_a, b, at_b), b
    # Of one sign at both ends, it may dip to the other side between them. Where it is convex (seen
    # from that side) it lies above the tangents at the ends, which meet at
    #     u = (f_b - f_a + f_a' a - f_b' b)/(f_a' - f_b'):
    # if they meet on the side of the ends there is no root, else the bracket shrinks to u.
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
    kind: Any,
    floor: float,
    wind: Any,
    law: Any,
    i: int,
    a: float,
    at_a: float,
    b: float,
    at_b: float,
) -> float:
    """Return the local time at which something changes its sign, by Halley's steps in a bracket.

    u <- u - f f'/(f'^2 - f f''/2), from where the secant is zero; the middle of the bracket where
    such a step would leave it.
    """
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
            if abs(step) <= SLACK * b:
                return u
    return u
