"""Trim, driver, demand and excess in a segment of a wind, and when they change their sign.

With the wind f of a unit peak and the state y of its filter (see `terms`), trim is
g = f + (b2 - b1) y, eq (B8): (s^2 + b2 s + q)/(s^2 + b1 s + q) is 1 + (b2 - b1) s/(s^2 + b1 s + q).
The driver d is f or g, and the demand is the deflection that, held from t on, meets (4b),

    D(t) = p integral from t on of e^(-p (r - t)) g(r) dr,      D' = p (D - g).

The excess e = d - K D follows e' = p e + h with h = d' - p d + K p g. So between two changes of
sign of h it has one zero at most.

In all functions `wind` is the tuple of its breakpoints, coefficients and rates, the results of
`march_wind` at the breakpoints, and a work array; `law` is p, K, b2 - b1, b1, q, and whether trim
itself is the driver. Times u are local to segment i.

A piece of the wind is a sum of terms c u^k e^(lambda u), `c` being coefficients ``(rates, degree +
1)``. The filter of trim is x'' + b1 x' + q x = f and y = x'; with q = 0 it is the lag
y' + b1 y = f.
"""

from typing import Any

import numpy as np

from tvclin.kernels.source import bare

_NEGLIGIBLE_TERM = 1e-18
"""Term of a sum, relative to it, that is below its rounding."""
_SMALL_ARGUMENT, _SMALL_ORDERS, _ORDERS = 0.25, 13, 19
"""Additional orders at which the downward recursion of moments starts: for arguments up to the
first, and up to one."""
DRIVER_SLOPE, EXCESS_FORCING, HEIGHT, EXCESS = map(np.int64, range(4))
"""Functions whose sign changes are located: the driver's slope; h; the driver above a height; the
excess. They are numpy integers, since a kernel is compiled anew for each constant of Python."""
WIND_DRIVES, TRIM_DRIVES = np.False_, np.True_
"""Whether trim itself is the driver."""
RELATIVE_ROUNDING = 8.0 * 2.0**-52
"""Relative rounding of a height or a demand, within which an excess is zero. With less, rounding
alone would make a limit insufficient; with more, limits would lose digits."""
_MAX_CELLS, _CELLS_PER_RATE = 64.0, 4.0
"""Cells of a segment, at most and per unit of its rates times its width: within a cell no second
derivative changes its sign twice. Fewer cells could miss a dip of the excess in an oscillating
wind."""
MAX_INTERVALS = 3 * (1 + int(_MAX_CELLS)) + 1
"""Size of the array of `monotone_intervals`, of which a cell has at most three."""
_MAX_ITERATIONS = 80
"""Largest number of halvings: a bracket of any width is then at its rounding (53 bits)."""
_LAST_RELATIVE_STEP = 1e-9
"""Newton step over the width of the bracket after which the error is below rounding: it is of the
order of the step's square, with Halley's curvature of its cube."""


@bare
def piece_value(c: Any, rates: Any, u: float) -> tuple[float, float, float]:
    """Return value, slope and curvature of a piece at the local time `u` [s]."""
    value, slope, curvature = 0.0, 0.0, 0.0
    for r in range(rates.size):
        rate = rates[r]
        a = c[r, c.shape[1] - 1]
        first, second = 0.0 * a, 0.0 * a
        for k in range(c.shape[1] - 2, -1, -1):
            second = second * u + first
            first = first * u + a
            a = a * u + c[r, k]
        second *= 2.0
        if rate != 0.0:
            growth = np.exp(rate * u)
            second = growth * (second + rate * (2.0 * first + rate * a))
            first = growth * (first + rate * a)
            a = growth * a
        value += a.real
        slope += first.real
        curvature += second.real
    return value, slope, curvature


@bare
def piece_integral(c: Any, rates: Any, u: float, remainder: float, p: Any) -> Any:
    """Return the integral of e^(-p v) f(u + v) dv over the remainder of a piece.

    By the moments of `numerics.pieces`, each order from the direction that is stable for it. The
    pole p may be complex; `remainder`: length of the remainder [s].
    """
    degree = c.shape[1] - 1
    total = 0.0 * (c[0, 0] * p)
    if remainder == 0.0:
        return total
    for r in range(rates.size):
        rate = rates[r]
        z = (p - rate) * remainder
        size = abs(z)
        decay = np.exp(-z)
        term = 0.0 * (c[r, 0] * decay)
        upward_orders = min(int(min(size, 1e3)), degree) if size > 1.0 else -1
        moment, power = term, remainder
        for k in range(upward_orders + 1):
            moment = (k * moment - decay) / z if k > 0 else (1.0 - decay) / z
            term += _recentred(c, r, k, u) * power * moment
            power *= remainder
        if upward_orders < degree:
            order, error = degree + (_SMALL_ORDERS if size <= _SMALL_ARGUMENT else _ORDERS), 1.0
            if size > 1.0:
                order = degree + 1
                while error > _NEGLIGIBLE_TERM:
                    order += 1
                    error *= size / order
            moment, power = 0.0 * term, remainder ** (degree + 1)
            for k in range(order, upward_orders + 1, -1):
                moment = (z * moment + decay) * (1.0 / k)
                if k <= degree + 1:
                    term += _recentred(c, r, k - 1, u) * power * moment
                    power /= remainder
        if rate != 0.0:
            term *= np.exp(rate * u)
        total += term
    return total


@bare
def _recentred(c: Any, r: int, k: int, u: float) -> Any:
    """Return the coefficient of order k about a local time u, without the exponential."""
    degree = c.shape[1] - 1
    if u == 0.0 or k == degree:
        return c[r, k]
    binomial = 1.0
    for j in range(k + 1, degree + 1):
        binomial *= j / (j - k)
    total = binomial * c[r, degree]
    for j in range(degree, k, -1):
        binomial *= (j - k) / j
        total = total * u + binomial * c[r, j - 1]
    return total


@bare
def filtered_state(
    c: Any, rates: Any, u: float, x: float, y: float, b1: float, q: float, work: Any
) -> tuple[float, float]:
    """Return the filter's state (x, y) at the local time `u` from that at the start of the piece.

    Its responses to the impulse and to v^k e^(lambda v) are series over a time so short that no
    rate times it exceeds one, then doubled repeatedly. `work` is ``(2, degree + 2)``, of the type
    of the coefficients.
    """
    new_x, new_y = 0.0, 0.0
    degree = c.shape[1] - 1
    slow = max(abs(b1), np.sqrt(q))
    for r in range(rates.size):
        rate = rates[r]
        present = r == 0
        for k in range(degree + 1):
            present = present or c[r, k] != 0.0
        if not present:
            continue
        step, doublings = u, 0
        while (slow + abs(rate)) * step > 1.0:
            step *= 0.5
            doublings += 1
        # The impulse response f, its slope g, and above them the integrals of f e^(-rate v).
        f, g = _impulse_series(work, degree, rate, step, b1, q, (slow + abs(rate)) * step)
        for _ in range(doublings):
            growth = np.exp(rate * step)
            for k in range(degree, -1, -1):
                response = work[1, k]
                derivative = rate * response + (k * work[1, k - 1] if k > 0 else f)
                binomial, doubled = 1.0, 0.0 * response
                for j in range(k, -1, -1):  # the binomial of (step + v)^k
                    doubled += binomial * work[1, j]
                    binomial *= step * j / (k - j + 1)
                work[1, k] = (g + b1 * f) * response + f * derivative + growth * doubled
            f, g = (2.0 * g + b1 * f) * f, g * g - q * f * f
            step *= 2.0
        for k in range(degree + 1):
            response = work[1, k]
            derivative = rate * response + (k * work[1, k - 1] if k > 0 else f)
            new_x += (c[r, k] * response).real
            new_y += (c[r, k] * derivative).real
        if r == 0:
            new_x += (g + b1 * f) * x + f * y
            new_y += g * y - q * f * x
    return new_x, new_y


@bare
def _impulse_series(
    work: Any, degree: int, rate: Any, step: float, b1: float, q: float, size: float
) -> tuple[float, float]:
    """Return the impulse response and its slope, and write the responses to v^k e^(rate v).

    The k-th response is k! f(s)/(s - rate)^(k + 1), a ladder of sums over the terms of f.
    """
    for k in range(degree + 1):
        work[0, k], work[1, k] = 0.0, 0.0
    f, g, term_f, term_g = 0.0, 1.0, 0.0, 1.0
    n, error = 0, 1.0
    while error > _NEGLIGIBLE_TERM or n < degree + 3:
        n += 1
        fraction = step / n
        error *= size / n
        for k in range(degree, -1, -1):
            lower = k * work[0, k - 1] if k > 0 else term_f
            work[0, k] = (rate * work[0, k] + lower) * fraction
            work[1, k] += work[0, k]
        term_f, term_g = term_g * fraction, -(b1 * term_g + q * term_f) * fraction
        f += term_f
        g += term_g
    return f, g


@bare
def march_wind(wind: Any, law: Any) -> None:
    """Write the remaining integral and the filter's state at each breakpoint, ``marched (3, n)``.

    Backwards W_i = integral over the segment + e^(-p width) W_(i+1), forwards x and y = x' of the
    filter.
    """
    knots, c, rates, marched, _ = wind
    p, last = law[0], knots.size - 1
    marched[0, last] = 0.0
    for i in range(last - 1, -1, -1):
        width = knots[i + 1] - knots[i]
        later = np.exp(-p * width) * marched[0, i + 1]
        marched[0, i] = piece_integral(c[i], rates, 0.0, width, p).real + later
    march_filter(wind, law)


@bare
def march_filter(wind: Any, law: Any) -> None:
    """Write the state (x, y) of trim's filter at each of n breakpoints of the wind.

    It becomes the last two rows of `marched`, ``(3, n)``, whose first is the remaining integral.
    `wind` and `law` are the tuples of all functions here.
    """
    knots, c, rates, marched, work = wind
    _, _, gain, b1, q, _ = law
    marched[1, 0], marched[2, 0] = 0.0, 0.0
    for i in range(knots.size - 1):
        x, y = 0.0, 0.0
        if gain != 0.0:
            width = knots[i + 1] - knots[i]
            x, y = filtered_state(c[i], rates, width, marched[1, i], marched[2, i], b1, q, work)
        marched[1, i + 1], marched[2, i + 1] = x, y


@bare
def onset_piece(wind: Any) -> int:
    """Return the index of the first piece that differs from zero."""
    knots, c, _, _, _ = wind
    for i in range(knots.size - 1):
        if knots[i + 1] > knots[i]:
            for r in range(c.shape[1]):
                for k in range(c.shape[2]):
                    if c[i, r, k] != 0.0:
                        return i
    return knots.size - 1


@bare
def cell_count(wind: Any, law: Any, i: int) -> int:
    """Return the number of cells of a segment.

    One more than the fastest rate in it times its width, at the scale of `_CELLS_PER_RATE`: of the
    wind's exponentials, and where trim is filtered by a second-order filter of that, b1 and
    sqrt(q).
    """
    knots, c, rates, _, _ = wind
    _, _, gain, b1, q, _ = law
    fastest = 0.0
    for r in range(rates.size):
        for k in range(c.shape[2]):
            if c[i, r, k] != 0.0:
                fastest = max(fastest, _CELLS_PER_RATE * abs(rates[r]))
    if gain != 0.0 and q != 0.0:
        fastest = max(fastest, abs(b1), np.sqrt(q))
    from_degree = _CELLS_PER_RATE * (c.shape[2] - 2) if c.shape[2] > 2 else 0.0
    return 1 + int(min(fastest * (knots[i + 1] - knots[i]) + from_degree, _MAX_CELLS))


@bare
def monotone_intervals(wind: Any, law: Any, i: int, ends: Any) -> int:
    """Write the ends of intervals in which the driver is monotone in a piece; return their number.

    `ends`: written, local times [s]. A piece without width has none.
    """
    width, count = wind[0][i + 1] - wind[0][i], 0
    ends[0] = 0.0
    if width <= 0.0:
        return count
    cells = cell_count(wind, law, i)
    for cell in range(cells):
        a, b = width * cell / cells, width * (cell + 1) / cells
        turns, first, second = sign_changes(DRIVER_SLOPE, wind, law, i, a, b)
        if turns > 0:
            ends[count + 1] = first
        if turns > 1:
            ends[count + 2] = second
        count += turns + 1
        ends[count] = b
    return count


@bare
def filter_state(wind: Any, law: Any, i: int, u: float) -> tuple[float, float]:
    """Return the filter's state (x, y) at a local time of a piece."""
    knots, c, rates, marched, work = wind
    _, _, gain, b1, q, _ = law
    if gain == 0.0 or u == 0.0:
        return marched[1, i], marched[2, i]
    if u == knots[i + 1] - knots[i]:
        return marched[1, i + 1], marched[2, i + 1]
    return filtered_state(c[i], rates, u, marched[1, i], marched[2, i], b1, q, work)


@bare
def _trim(law: Any, wind_terms: Any, x: float, y: float) -> tuple[float, float, float]:
    """Return trim, its slope and its curvature, from the wind's and the filter's state.

    g = f + (b2 - b1) y with y' = f - b1 y - q x, x' = y, and so y'' = f' - b1 y' - q y.
    """
    _, _, gain, b1, q, _ = law
    f, slope, curvature = wind_terms
    first = f - b1 * y - q * x
    return f + gain * y, slope + gain * first, curvature + gain * (slope - b1 * first - q * y)


@bare
def driver(wind: Any, law: Any, i: int, u: float) -> tuple[float, float, float]:
    """Return the driver, its slope and its curvature at a local time of a piece."""
    wind_terms = piece_value(wind[1][i], wind[2], u)
    if not law[5] or law[2] == 0.0:
        return wind_terms
    x, y = filter_state(wind, law, i, u)
    return _trim(law, wind_terms, x, y)


@bare
def demand(wind: Any, law: Any, i: int, u: float) -> float:
    """Return the demand at a local time of a piece: infinite where trim outgrows the mode."""
    x, y = filter_state(wind, law, i, u)
    return _demand(wind, law, i, u, x, y)


@bare
def _demand(wind: Any, law: Any, i: int, u: float, x: float, y: float) -> float:
    """Return the demand from the wind's remaining integral and the filter's state.

    It is infinite where the filter grows as fast as the mode, -b1/2 + sqrt(b1^2/4 - q) >= p.
    """
    knots, c, rates, marched, _ = wind
    p, _, gain, b1, q, _ = law
    width = knots[i + 1] - knots[i] if i < knots.size - 1 else 0.0
    if u == 0.0:
        integral = marched[0, i]
    elif u == width:
        integral = marched[0, i + 1]
    else:
        remainder = width - u
        integral = (
            piece_integral(c[i], rates, u, remainder, p).real
            + np.exp(-p * remainder) * marched[0, i + 1]
        )
    if gain != 0.0 and -0.5 * b1 + np.sqrt(max(0.25 * b1 * b1 - q, 0.0)) >= p:
        return np.inf
    return demand_of_integral(law, p, integral, x, y)


@bare
def remaining_integral(wind: Any, i: int, u: float, p: Any) -> Any:
    """Return the integral of e^(-p r) f(t + r) dr over all the wind after a time t."""
    knots, c, rates, _, _ = wind
    total = 0.0 * (p * c[0, 0, 0])
    for j in range(knots.size - 2, i, -1):
        width = knots[j + 1] - knots[j]
        total = piece_integral(c[j], rates, 0.0, width, p) + np.exp(-p * width) * total
    remainder = knots[i + 1] - knots[i] - u
    return piece_integral(c[i], rates, u, remainder, p) + np.exp(-p * remainder) * total


@bare
def demand_of_integral(law: Any, p: Any, integral: Any, x: float, y: float) -> Any:
    """Return the demand of a pole p, possibly complex, from the integral and a filter state.

    With W the integral of e^(-p r) f(t + r) dr, and the state (x, y) at t, the Laplace transform of
    y' = f - b1 y - q x, x' = y from t on is

        Y (p + b1 + q/p) = W + y - q x/p,        D = p [W + (b2 - b1) Y].
    """
    _, _, gain, b1, q, _ = law
    if gain == 0.0:
        return p * integral
    return p * (integral + gain * (y + integral - q * x / p) / (p + b1 + q / p))


@bare
def evaluate(
    kind: Any, floor: float, wind: Any, law: Any, i: int, u: float
) -> tuple[float, float, float]:
    """Return the function `kind`, its slope, and its curvature or zero, at a local time.

    DRIVER_SLOPE: d'. EXCESS_FORCING: h = d' - p d + K p g. HEIGHT: d - floor. EXCESS: e = max(d,
    floor) - K D, with D' = p (D - g) and D'' = p (D' - g'). The first two have no curvature: their
    roots are found by Newton's steps.
    """
    p, K, gain, _, _, literal = law
    wind_terms = piece_value(wind[1][i], wind[2], u)
    x, y = 0.0, 0.0
    if gain != 0.0 and (literal or kind in (EXCESS_FORCING, EXCESS)):
        x, y = filter_state(wind, law, i, u)
    g, g_slope, g_curvature = _trim(law, wind_terms, x, y)
    d, slope, curvature = (g, g_slope, g_curvature) if literal else wind_terms
    if kind == DRIVER_SLOPE:
        return slope, curvature, 0.0
    if kind == EXCESS_FORCING:
        return slope - p * d + K * p * g, curvature - p * slope + K * p * g_slope, 0.0
    if kind == HEIGHT:
        return d - floor, slope, curvature
    if d < floor:
        d, slope, curvature = floor, 0.0, 0.0
    demanded = _demand(wind, law, i, u, x, y)
    demand_slope = p * (demanded - g)
    return d - K * demanded, slope - K * demand_slope, curvature - K * p * (demand_slope - g_slope)


@bare
def sign_changes(
    kind: Any, wind: Any, law: Any, i: int, a: float, b: float
) -> tuple[int, float, float]:
    """Return the number of sign changes of a function in a cell, at most two, and their times."""
    at_a, slope_a, _ = evaluate(kind, 0.0, wind, law, i, a)
    at_b, slope_b, _ = evaluate(kind, 0.0, wind, law, i, b)
    if at_a * at_b < 0.0:
        return 1, root(kind, 0.0, wind, law, i, a, at_a, b, at_b), b
    # With one sign at both ends, it may dip to the other sign between them. Where it is convex (as
    # seen from there) it lies above the tangents at the ends, which cross at
    #     u = (f_b - f_a + f_a' a - f_b' b)/(f_a' - f_b'):
    # if they cross with the sign of the ends there is no root, else the bracket shrinks to u.
    sign = 1.0 if at_a > 0.0 or at_b > 0.0 else -1.0
    start, at_start, end, at_end = a, at_a, b, at_b
    for _ in range(_MAX_ITERATIONS):
        if not sign * slope_a < 0.0 < sign * slope_b:
            break
        bottom = (at_b - at_a + slope_a * a - slope_b * b) / (slope_a - slope_b)
        if sign * (at_a + slope_a * (bottom - a)) >= 0.0 or not a < bottom < b:
            break
        at_bottom, slope, _ = evaluate(kind, 0.0, wind, law, i, bottom)
        if sign * at_bottom < 0.0:
            first = root(kind, 0.0, wind, law, i, start, at_start, bottom, at_bottom)
            return 2, first, root(kind, 0.0, wind, law, i, bottom, at_bottom, end, at_end)
        if sign * slope < 0.0:
            a, at_a, slope_a = bottom, at_bottom, slope
        else:
            b, at_b, slope_b = bottom, at_bottom, slope
    return 0, start, end


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
    """Return the local time of a sign change, by Halley's steps in a bracket.

    u <- u - f f'/(f'^2 - f f''/2), starting at the zero of the secant; the middle of the bracket
    where such a step would leave it.
    """
    if at_a * at_b >= 0.0:
        return a if at_a == 0.0 else b
    last_step = _LAST_RELATIVE_STEP * (b - a)
    u = a + (b - a) * at_a / (at_a - at_b)
    for _ in range(_MAX_ITERATIONS):
        at_u, slope, curvature = evaluate(kind, floor, wind, law, i, u)
        if at_u * at_b < 0.0:
            a = u
        else:
            b = u
        divisor = slope * slope - 0.5 * at_u * curvature
        step = -at_u * slope / divisor if divisor > 0.0 else 2.0 * (b - a)
        if a <= u + step <= b:
            u += step
            if abs(step) <= last_step:
                return u
        else:
            step = 0.5 * (a + b) - u
            u += step
            if abs(step) <= RELATIVE_ROUNDING * b:
                return u
    return u
