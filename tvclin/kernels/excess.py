"""Trim, driver, demand and excess in a segment of a wind, and when they change their sign.

With the wind f of a unit peak and the state y of its filter (see `terms`), trim is
g = f + (b2 - b1) y, eq (B8): (s^2 + b2 s + q)/(s^2 + b1 s + q) is 1 + (b2 - b1) s/(s^2 + b1 s + q).
The driver d is f or g, and the demand is the deflection that, held from t on, meets (4b),

    D(t) = p integral from t on of e^(-p (r - t)) g(r) dr,      D' = p (D - g).

The excess e = d - K D follows e' = p e + h with h = d' - p d + K p g. So between two changes of
sign of h it has one zero at most.

Times u are local to segment i (or piece i), from breakpoint i to the next, in which the wind is a
sum of terms c u^k e^(lambda u). The filter of trim is x'' + b1 x' + q x = f and y = x'; with q = 0
it is the lag y' + b1 y = f.
"""

from typing import Any, NamedTuple

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray
from tvclin.kernels.source import allocation_free

_NEGLIGIBLE_TERM = 1e-18
"""Term of a sum, relative to it, that is below its rounding."""
_SMALL_ARGUMENT, _SMALL_ORDERS, _ORDERS = 0.25, 13, 19
"""Additional orders at which the downward recursion of moments starts: `_SMALL_ORDERS` for
arguments up to `_SMALL_ARGUMENT`, `_ORDERS` up to one."""
_MAX_UPWARD_ORDERS = 1e3
"""Bound on the orders of the upward recursion of moments, more than any piece has."""
DRIVER_SLOPE, EXCESS_FORCING, HEIGHT, EXCESS = map(np.int64, range(4))
"""Functions whose sign changes are located: the driver's slope; h; the driver above a height; the
excess. They are numpy integers, since a kernel is compiled anew for each constant of Python."""
WIND_DRIVES, TRIM_DRIVES = np.False_, np.True_
"""Whether trim itself is the driver."""
REMAINING_INTEGRAL, FILTER_X, FILTER_Y = range(3)
"""Rows of `Wind.marched`: remaining integral W [s], and the filter's states x [s^2] and y [s]."""
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


class Wind(NamedTuple):
    """Wind f of a unit peak, with integrals at its n breakpoints.

    `knots`: breakpoints [s], ``(n,)``. `coefficients`: c of the terms c u^k e^(rate u) of each
    piece, u being the time since its breakpoint, ``(n, rates, degree + 1)``; the last piece, after
    the wind, is zero. `rates`: [1/s], ``(rates,)``. `marched`: written by `integrate_wind`: the
    remaining integral [s], and the state x [s^2] and y [s] of trim's filter, at each breakpoint,
    ``(3, n)``. `work`: work array of `advance_filter`, ``(2, degree + 1)``.
    """

    knots: FloatArray
    coefficients: AnyArray
    rates: AnyArray
    marched: FloatArray
    work: AnyArray


class ExitLaw(NamedTuple):
    """Numbers of the exit of the dead band.

    `p`: unstable pole [1/s]. `K`: dead band, trim that is followed over the deflection limit.
    `gain`, `b1`, `q`: of trim's filter (s^2 + b2 s + q)/(s^2 + b1 s + q), the drift: b2 - b1 [1/s],
    zero for trim without drift, b1 [1/s] and q [1/s^2]. `trim_drives`: whether trim itself, not the
    wind, is the driver, which is compared with K times the demand.
    """

    p: float
    K: float
    gain: float
    b1: float
    q: float
    trim_drives: bool | np.bool_


@allocation_free
def piece_value(c: AnyArray, rates: AnyArray, u: float) -> tuple[float, float, float]:
    """Return value, slope and curvature of a piece of a history at the local time u [s].

    The piece is a sum of terms c_rk u^k e^(rate_r u), r and k numbers of rate and power. `c`:
    coefficients, ``(rates, degree + 1)``. `rates`: [1/s], ``(rates,)``. Complex terms come in
    conjugate pairs: the real part is taken.
    """
    value, slope, curvature = 0.0, 0.0, 0.0
    for r in range(rates.size):
        rate = rates[r]
        # the polynomial of this rate, its slope, and half of its curvature
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


@allocation_free
def piece_integral(c: AnyArray, rates: AnyArray, u: float, remainder: float, p: complex) -> Any:
    """Return the integral [s] of e^(-p v) f(u + v) dv, v from zero to the end of a piece f.

    It is complex where p or a term is. `c`, `rates`: coefficients ``(rates, degree + 1)`` and rates
    [1/s] ``(rates,)`` of f, a sum of terms c_rk t^k e^(rate_r t) in the local time t. `u`: local
    time at which the integral begins [s]. `remainder`: time from there to the end [s]. `p`: [1/s].

    With c' the coefficients about u (`_recentred`), h the remainder and z = (p - rate) h, a rate
    adds e^(rate u) times the sum over k of c'_k h^(k + 1) M_k. The moments M_k, integrals of
    s^k e^(-z s) over s from 0 to 1, follow from each other by z M_k = k M_(k-1) - e^(-z): upwards
    for k below ``|z|``, downwards from an order high enough to be neglected for the others, which
    is the direction in which rounding does not grow.
    """
    degree = c.shape[1] - 1
    total = 0.0 * (c[0, 0] * p)  # zero, of the type of the result
    if remainder == 0.0:
        return total
    for r in range(rates.size):
        rate = rates[r]
        z = (p - rate) * remainder
        size = abs(z)
        decay = np.exp(-z)
        term = 0.0 * (c[r, 0] * decay)
        # the largest k whose moment is computed upwards
        upward_orders = min(int(min(size, _MAX_UPWARD_ORDERS)), degree) if size > 1.0 else -1
        moment, power = term, remainder  # M_k and h^(k + 1)
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
            moment, power = 0.0 * term, remainder ** (degree + 1)  # M_order is neglected
            for k in range(order, upward_orders + 1, -1):  # M_(k-1) from M_k
                moment = (z * moment + decay) * (1.0 / k)
                if k <= degree + 1:
                    term += _recentred(c, r, k - 1, u) * power * moment
                    power /= remainder
        if rate != 0.0:
            term *= np.exp(rate * u)
        total += term
    return total


@allocation_free
def _recentred(c: AnyArray, r: int, k: int, u: float) -> Any:
    """Return the coefficient of (v - u)^k of the polynomial number r of a piece, about v = u [s].

    It is the sum over j from k on of binomial(j, k) u^(j - k) c_rj. `c`: coefficients of the
    piece's terms c_rj v^j e^(rate_r v) in the local time v, ``(rates, degree + 1)``. The caller has
    the factor e^(rate_r u).
    """
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


@allocation_free
def advance_filter(
    c: AnyArray,
    rates: AnyArray,
    u: float,
    x: float,
    y: float,
    b1: float,
    q: float,
    work: AnyArray,
) -> tuple[float, float]:
    """Return the state (x, y) of trim's filter, x' = y, y' = f - b1 y - q x, a time u [s] later.

    In the time v since the start the wind f is the sum over r and k of c_rk v^k e^(rate_r v): for
    each rate a polynomial times an exponential. `c`: coefficients, row r for rate number r, column
    k for the power k of v, ``(rates, degree + 1)``. `rates`: [1/s], ``(rates,)``. Complex terms
    come in conjugate pairs: the real part is taken. `x`, `y`: the state at the start [s^2, s]
    where f is a number. `b1`, `q`: of the filter [1/s, 1/s^2]. `work`: work array, ``(2, degree +
    1)``, of the type of the coefficients.

    The responses of x to an impulse and to v^k e^(rate v) are series over a time so short that no
    rate times it exceeds one (`_impulse_series`); then this time is doubled repeatedly up to u.
    """
    new_x, new_y = 0.0, 0.0
    degree = c.shape[1] - 1
    slow = max(abs(b1), np.sqrt(q))  # rate of the filter [1/s]
    for r in range(rates.size):
        rate = rates[r]
        present = r == 0  # the first also for the response to the state at the start
        for k in range(degree + 1):
            present = present or c[r, k] != 0.0
        if not present:
            continue
        step, doublings = u, 0
        while (slow + abs(rate)) * step > 1.0:
            step *= 0.5
            doublings += 1
        # impulse response of x and its slope; responses of x to v^k e^(rate v) are in work[1, k]
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
        if r == 0:  # once: the response to the state at the start
            new_x += (g + b1 * f) * x + f * y
            new_y += g * y - q * f * x
    return new_x, new_y


@allocation_free
def _impulse_series(
    work: AnyArray, degree: int, rate: complex, step: float, b1: float, q: float, size: float
) -> tuple[float, float]:
    """Return impulse response f [s] and its slope g of x'' + b1 x' + q x, after a time `step`.

    By power series in the `step` [s]. Responses of x after the step to the inputs v^k e^(rate v), v
    being the time and k up to `degree`, are written to row 1 of `work` ``(2, degree + 1)``. Row 0
    has the last term of each: term n of power k is (rate T_k + k T_(k-1)) step/n with the terms
    n - 1, T; of power zero f's term takes the place of k T_(k-1). `rate`: [1/s]. `b1`, `q`: [1/s,
    1/s^2]. `size`: bound of all rates times the step, at most one, by which terms are bounded.
    """
    for k in range(degree + 1):
        work[0, k], work[1, k] = 0.0, 0.0
    f, g, term_f, term_g = 0.0, 1.0, 0.0, 1.0  # sums, and terms number n
    n, error = 0, 1.0  # number of the term, and its bound
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


@allocation_free
def integrate_wind(wind: Wind, law: ExitLaw) -> None:
    """Write the remaining integral and the filter's state at each breakpoint of a wind f.

    Row `REMAINING_INTEGRAL` of `wind.marched` becomes W [s], the integral of e^(-p r) f(t + r) dr
    over all time r after each breakpoint t: backwards from zero, W_i = the integral over piece i +
    e^(-p width) W_(i+1). Rows `FILTER_X` and `FILTER_Y` become the state x [s^2] and y = x' [s] of
    trim's filter x'' + b1 x' + q x = f, forwards from zero.
    `wind`: breakpoints, and pieces: coefficients c and rates of terms c u^k e^(rate u); complex
    ones come in conjugate pairs, so that the real part is the integral. `law`: p, b1 and q.
    """
    knots, c, rates, marched, _ = wind
    p, last = law.p, knots.size - 1
    marched[REMAINING_INTEGRAL, last] = 0.0
    for i in range(last - 1, -1, -1):
        width = knots[i + 1] - knots[i]
        later = np.exp(-p * width) * marched[REMAINING_INTEGRAL, i + 1]
        integral = piece_integral(c[i], rates, 0.0, width, p).real
        marched[REMAINING_INTEGRAL, i] = integral + later
    integrate_filter(wind, law)


@allocation_free
def integrate_filter(wind: Wind, law: ExitLaw) -> None:
    """Write the state (x, y) of trim's filter at n breakpoints of a wind f, from zero on.

    The filter is the effect of drift on trim, x'' + b1 x' + q x = f and y = x': trim is f + gain y,
    times -B, trim deflection per angle of attack. Without drift, where `law.gain` = b2 - b1 is
    zero, the states are zero. They become rows `FILTER_X` [s^2] and `FILTER_Y` [s] of
    `wind.marched`, ``(3, n)``.
    """
    knots, c, rates, marched, work = wind
    gain, b1, q = law.gain, law.b1, law.q
    x, y = 0.0, 0.0
    marched[FILTER_X, 0], marched[FILTER_Y, 0] = x, y
    for i in range(knots.size - 1):
        if gain != 0.0:
            x, y = advance_filter(c[i], rates, knots[i + 1] - knots[i], x, y, b1, q, work)
        marched[FILTER_X, i + 1], marched[FILTER_Y, i + 1] = x, y


@allocation_free
def onset_piece(wind: Wind) -> int:
    """Return the index of the first piece of a wind that differs from zero; the last if none."""
    knots, c = wind.knots, wind.coefficients
    for i in range(knots.size - 1):
        if knots[i + 1] > knots[i]:
            for r in range(c.shape[1]):
                for k in range(c.shape[2]):
                    if c[i, r, k] != 0.0:
                        return i
    return knots.size - 1


@allocation_free
def cell_count(wind: Wind, law: ExitLaw, i: int) -> int:
    """Return the number of cells into which segment i of a wind is divided to find sign changes.

    Within a cell no second derivative changes its sign twice. The number is one more than the width
    times the fastest rate: `_CELLS_PER_RATE` times the rates of the wind's terms u^k e^(rate u), or
    b1 and sqrt(q) of trim's filter x'' + b1 x' + q x (`law`), without effect where its gain is
    zero; and more for powers k above one. `_MAX_CELLS` bounds it.
    """
    knots, c, rates, _, _ = wind
    gain, b1, q = law.gain, law.b1, law.q
    fastest = 0.0  # [1/s]
    for r in range(rates.size):
        for k in range(c.shape[2]):
            if c[i, r, k] != 0.0:
                fastest = max(fastest, _CELLS_PER_RATE * abs(rates[r]))
    if gain != 0.0 and q != 0.0:
        fastest = max(fastest, abs(b1), np.sqrt(q))
    degree = c.shape[2] - 1  # highest power k
    from_degree = _CELLS_PER_RATE * (degree - 1) if degree > 1 else 0.0
    return 1 + int(min(fastest * (knots[i + 1] - knots[i]) + from_degree, _MAX_CELLS))


@allocation_free
def monotone_intervals(wind: Wind, law: ExitLaw, i: int, ends: FloatArray) -> int:
    """Return the number of intervals of segment i of a wind in which the driver is monotone.

    The driver, which is compared with K times the demand, is trim where `law.trim_drives`, else the
    wind. `ends`: written: the ends of the intervals, one more than these, as times since the begin
    of the segment [s]. They are the ends of cells, parts of the segment in which the slope has at
    most two sign changes, and the times at which the driver's slope changes its sign. A segment
    without width has no interval.
    """
    width, count = wind.knots[i + 1] - wind.knots[i], 0
    ends[0] = 0.0
    if width <= 0.0:
        return count
    cells = cell_count(wind, law, i)
    for cell in range(cells):
        a, b = width * cell / cells, width * (cell + 1) / cells
        turns, first, second = sign_changes(DRIVER_SLOPE, wind, law, i, a, b)
        if turns > 0:  # number of sign changes of the slope, and their times
            ends[count + 1] = first
        if turns > 1:
            ends[count + 2] = second
        count += turns + 1
        ends[count] = b
    return count


@allocation_free
def filter_state(wind: Wind, law: ExitLaw, i: int, u: float) -> tuple[float, float]:
    """Return the state (x, y) of trim's filter at the local time u [s] of segment i of a wind f.

    `law`: the filter, x'' + b1 x' + q x = f with y = x', x in s^2 and y in s; without its term in
    trim (`law.gain` zero) the state is zero. `wind`: with the states at its breakpoints, rows
    `FILTER_X` and `FILTER_Y` of `marched`.
    """
    knots, c, rates, marched, work = wind
    gain, b1, q = law.gain, law.b1, law.q
    x, y = marched[FILTER_X, i], marched[FILTER_Y, i]
    if gain == 0.0 or u == 0.0:
        return x, y
    if u == knots[i + 1] - knots[i]:
        return marched[FILTER_X, i + 1], marched[FILTER_Y, i + 1]
    return advance_filter(c[i], rates, u, x, y, b1, q, work)


@allocation_free
def _trim(
    law: ExitLaw, wind_terms: tuple[float, float, float], x: float, y: float
) -> tuple[float, float, float]:
    """Return g = f + gain y, its slope and curvature [1, 1/s, 1/s^2], for a wind f of unit peak.

    Trim with drift is -B g, with B = trim deflection per angle of attack; the minus, since a wind
    lowers the angle of attack. `law`: gain (b2 - b1), b1 and q of its filter y' = f - b1 y - q x,
    x' = y, so that y'' = f' - b1 y' - q y. `wind_terms`: f, f' and f''. `x`, `y`: the filter's
    state.
    """
    gain, b1, q = law.gain, law.b1, law.q
    f, slope, curvature = wind_terms
    first = f - b1 * y - q * x
    return f + gain * y, slope + gain * first, curvature + gain * (slope - b1 * first - q * y)


@allocation_free
def driver(wind: Wind, law: ExitLaw, i: int, u: float) -> tuple[float, float, float]:
    """Return the driver, its slope and its curvature [1, 1/s, 1/s^2] at a time of a wind.

    The driver is compared with K times the demand, the limit that from then on survives the rest of
    the wind, at the exit of the dead band. It is the wind of unit peak, or where `law.trim_drives`
    its trim over -B, B being trim deflection per angle of attack; without drift
    (`law.gain` zero) trim over -B is the wind. `i`, `u`: segment of the wind, and time since its
    begin [s].
    """
    wind_terms = piece_value(wind.coefficients[i], wind.rates, u)
    if not law.trim_drives or law.gain == 0.0:
        return wind_terms
    x, y = filter_state(wind, law, i, u)
    return _trim(law, wind_terms, x, y)


@allocation_free
def demand(wind: Wind, law: ExitLaw, i: int, u: float) -> float:
    """Return the demand at the local time u [s] of segment i of a wind, over -B and its peak.

    It is the constant deflection that, from then on, satisfies the boundary condition (4b) of the
    report; infinite where trim grows faster than the unstable mode. B is trim deflection per angle
    of attack, so that the demand is a number. `law`: unstable pole and filter of trim.
    """
    x, y = filter_state(wind, law, i, u)
    return _demand(wind, law, i, u, x, y)


@allocation_free
def _demand(wind: Wind, law: ExitLaw, i: int, u: float, x: float, y: float) -> float:
    """Return the demand at the local time u [s] of segment i, from the filter's state (x, y) there.

    It is the constant deflection, over -B (trim deflection per angle of attack), that from then on
    satisfies eq (4b) of the report; infinite where the filter y'' + b1 y' + q y of trim grows as
    fast as the mode, -b1/2 + sqrt(b1^2/4 - q) >= p. `wind`: with its remaining integrals at
    breakpoints, row `REMAINING_INTEGRAL` of `marched`. `law`: p, gain, b1 and q.
    """
    knots, c, rates, marched, _ = wind
    gain, b1, q = law.gain, law.b1, law.q
    width = knots[i + 1] - knots[i] if i < knots.size - 1 else 0.0
    if u == 0.0:
        integral = marched[REMAINING_INTEGRAL, i]
    elif u == width:
        integral = marched[REMAINING_INTEGRAL, i + 1]
    else:
        remainder = width - u
        integral = (
            piece_integral(c[i], rates, u, remainder, law.p).real
            + np.exp(-law.p * remainder) * marched[REMAINING_INTEGRAL, i + 1]
        )
    if gain != 0.0 and -0.5 * b1 + np.sqrt(max(0.25 * b1 * b1 - q, 0.0)) >= law.p:
        return np.inf
    return demand_of_integral(law, law.p, integral, x, y)


@allocation_free
def remaining_integral(wind: Wind, i: int, u: float, p: complex) -> Any:
    """Return the integral [s] of e^(-p r) f(t + r) dr over all the wind f after a time t.

    `i`, `u`: segment of the wind in which t is, and time since its begin [s]. `p`: pole [1/s],
    which may be complex, as is the result then. The segments after t are added from the last one
    on, each discounted by e^(-p width).
    """
    knots, c, rates, _, _ = wind
    total = 0.0 * (p * c[0, 0, 0])  # zero, of the type of the result
    for j in range(knots.size - 2, i, -1):
        width = knots[j + 1] - knots[j]
        total = piece_integral(c[j], rates, 0.0, width, p) + np.exp(-p * width) * total
    remainder = knots[i + 1] - knots[i] - u
    return piece_integral(c[i], rates, u, remainder, p) + np.exp(-p * remainder) * total


@allocation_free
def demand_of_integral(law: ExitLaw, p: complex, integral: complex, x: float, y: float) -> Any:
    """Return the demand D of a pole p, possibly complex, from the wind's integral and filter state.

    D is the constant deflection, over -B (trim deflection per angle of attack), that balances the
    remaining trim g = f + gain y in the mode: p times the Laplace transform of g from t on. With
    `integral` W, of e^(-p r) f(t + r) dr, and the state (x, y) of the filter y' = f - b1 y - q x,
    x' = y (`law`, with gain b2 - b1) at t, Y being the transform of y,

            Y (p + b1 + q/p) = W + y - q x/p,        D = p [W + gain Y].
    """
    gain, b1, q = law.gain, law.b1, law.q
    if gain == 0.0:
        return p * integral
    return p * (integral + gain * (y + integral - q * x / p) / (p + b1 + q / p))


@allocation_free
def evaluate(
    kind: Any, floor: float, wind: Wind, law: ExitLaw, i: int, u: float
) -> tuple[float, float, float]:
    """Return the function `kind`, its slope, and its curvature or zero, at the local time u [s].

    Of segment i of a wind f, all over its peak: g is trim over -B (trim deflection per angle of
    attack), the driver d is g or f, and the demand D the constant deflection over -B that suffices
    from then on. `kind`: DRIVER_SLOPE is d', EXCESS_FORCING h = d' - p d + K p g, HEIGHT d - floor,
    and EXCESS e = max(d, floor) - K D, with D' = p (D - g) and D'' = p (D' - g'), so that e' = p e
    + h above the floor. `floor`: without effect on the first two, which have no curvature either:
    their roots are found by Newton's steps. `law`: p, K, the filter of trim, and which is the
    driver.
    """
    p, K = law.p, law.K
    wind_terms = piece_value(wind.coefficients[i], wind.rates, u)
    x, y = 0.0, 0.0
    if law.gain != 0.0 and (law.trim_drives or kind in (EXCESS_FORCING, EXCESS)):
        x, y = filter_state(wind, law, i, u)
    g, g_slope, g_curvature = _trim(law, wind_terms, x, y)
    d, slope, curvature = (g, g_slope, g_curvature) if law.trim_drives else wind_terms
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


@allocation_free
def sign_changes(
    kind: Any, wind: Wind, law: ExitLaw, i: int, a: float, b: float
) -> tuple[int, float, float]:
    """Return the number of sign changes of a function in a cell, at most two, and their times.

    `kind`: function of `evaluate`. `wind`, `law`, `i`: wind, numbers of the dead band, and segment.
    `a`, `b`: ends of the cell, local times [s], within which the function's curvature changes its
    sign once at most. With fewer than two sign changes the remaining times are ends of the cell.
    """
    # values and slopes at both ends
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


@allocation_free
def root(
    kind: Any,
    floor: float,
    wind: Wind,
    law: ExitLaw,
    i: int,
    a: float,
    at_a: float,
    b: float,
    at_b: float,
) -> float:
    """Return the local time [s] of a sign change of a function, by Halley's steps in a bracket.

    `kind`, `floor`, `wind`, `law`, `i`: arguments of `evaluate`: function, level from which it
    counts, wind, numbers of the dead band, and segment. `a`, `b`: ends of the bracket, local times
    [s]. `at_a`, `at_b`: values there; where their signs are equal b is returned, or the end at
    which the function is zero.

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
        # without a divisor a step that leaves the bracket
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
