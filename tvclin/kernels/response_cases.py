"""Modal responses, exact from knot to knot, case by case: the kernel of `numerics.modal`.

Between two knots, with the local time u, the inputs are sums of c(u) e^(r u), and a mode

    z' = p z + g f     is     z(u) = w e^(p u) + sum over r of a(u) e^(r u),
                              a' + (r - p) a = g c.

Outputs are sums of modes, so they are such sums too: each is one polynomial for each rate, and
one number for each pole. Cases are independent.
"""

from typing import Any, NamedTuple

import numpy as np

from tvclin.kernels.source import allocation_free, kernel

NEGLIGIBLE_TERM = 1e-17
"""Term, relative to the largest, that is neglected."""
PLAIN_SECONDS, PLAIN_SECONDS_PER_TIME = 1e-3, 2e-6
"""Seconds that plain Python takes for a case, and for one time of one output."""
COMPILED_OVER_PLAIN = 1e-3
"""Ratio of the times of machine code and of plain Python."""
MARGINAL = 1e-12
"""Real part of a pole, over the largest pole, below which it is not unstable."""
MAX_FORWARD_GROWTH = 1.0
"""Exponent of growth up to which an unstable mode may be integrated forward."""
MAX_CANCELLATION = 4.0
"""Ratio of a response to its input beyond which terms cancel, and its series is used."""
MAX_ADDED_TERMS = 47
"""Largest number of terms of a series in excess of its input's."""
MIN_POLE_DISTANCE = 1e-3
"""Distance of poles, over the largest or over the time, below which they are not distinct: their
residues are large and cancel, by about its inverse."""
MAX_LAG_GROWTH = 20.0
"""Exponent of growth up to which a plant may be integrated forward, which loses as many digits as
e^20 has; a faster one keeps its modes although two poles are close."""
EPSILON, ROUNDINGS, UNDERFLOW_EXPONENT = 2.0**-52, 32.0, 750.0
"""As in `modal.residues`: relative rounding, roundings per term, and exponent of underflow."""


class Case(NamedTuple):
    """Both inputs of a case, deflection and wind [rad], on their common knots.

    From each knot on, an input is a sum of terms c u^k e^(rate u), with the time u since it.
    `knots`: [s], ``(K + 1,)``, the last at infinity. `rates`: [1/s], ``(Q,)``, distinct, the first
    zero. `forces`: c, by knot, input, rate and power k, ``(K, 2, Q, m)``. `lengths`: numbers of
    significant powers of both inputs, ``(K, Q)``.
    """

    knots: Any
    rates: Any
    forces: Any
    lengths: Any


@kernel
def merge_knots(first: Any, second: Any, knots: Any) -> Any:
    """Write the knots [s] of both inputs without repetition, then infinity; return their number.

    `first`, `second`: ascending knots of each. `knots`: written, with one element more than
    counted.
    """
    i, j, count = 0, 0, 0
    while i < first.size or j < second.size:
        if j == second.size or (i < first.size and first[i] <= second[j]):
            time, i = first[i], i + 1
        else:
            time, j = second[j], j + 1
        if count == 0 or time > knots[count - 1]:
            knots[count] = time
            count += 1
    knots[count] = np.inf
    return count


@kernel
def add_rates(new_rates: Any, rates: Any, used: Any) -> Any:
    """Append the rates of an input that a case does not have yet; return how many it has then.

    `new_rates`: rates of the input's terms c u^k e^(rate u) [1/s]. `rates`: of the case, of
    which the first `used` are set; changed.
    """
    for q in range(new_rates.size):
        if rate_index(new_rates[q], rates, used) == used:
            rates[used] = new_rates[q]
            used += 1
    return used


@kernel
def rate_index(rate: Any, rates: Any, used: Any) -> Any:
    """Return the index of `rate` [1/s] among the first `used` of `rates`; `used` if absent."""
    at = 0
    while at < used and rates[at] != rate:
        at += 1
    return at


@kernel
def put_input(case: Case, forces: Any, knots: Any, coefficients: Any, rates: Any) -> None:
    """Write the coefficients of an input about the common knots of a case, to `forces`.

    `case`: its K + 1 knots and Q rates. `forces`: written: coefficients c of the terms
    c u^k e^(rate u) from each knot of the case on, with the time u since it, ``(K, Q, m)``.
    `knots`, `coefficients`, `rates`: the input itself, ``(n,)`` [s], ``(n, r, m)`` and ``(r,)``
    [1/s], whose knots and rates the case has too; before its first knot it is zero. Where the case
    has a knot between two of the input, its terms are expanded about that knot.
    """
    piece = -1  # of the input, at the knot of the case
    for i in range(case.knots.size - 1):
        for q in range(case.rates.size):
            for k in range(forces.shape[2]):
                forces[i, q, k] = 0.0
        while piece + 1 < knots.size and knots[piece + 1] <= case.knots[i]:
            piece += 1
        if piece < 0:
            continue
        u = case.knots[i] - knots[piece]
        for q in range(rates.size):
            terms = forces[i, rate_index(rates[q], case.rates, case.rates.size)]
            for k in range(coefficients.shape[2]):
                terms[k] += coefficients[piece, q, k]
        for q in range(case.rates.size if u > 0.0 else 0):
            recentre(forces[i, q], case.rates[q], u)


@kernel
def recentre(terms: Any, rate: Any, u: Any) -> None:
    """Expand a polynomial c(v) times e^(rate v) about the time v = u [s], in place.

    `terms`: coefficients of c, lowest power first, ``(m,)``; changed to those of the polynomial in
    v - u that gives the same product with e^(rate (v - u)). `rate`: [1/s].
    """
    count = significant_terms(terms, np.inf)  # up to the last that is not zero
    for low in range(count):
        for k in range(count - 2, low - 1, -1):
            terms[k] += u * terms[k + 1]
    if rate != 0.0:
        growth = np.exp(rate * u)
        for k in range(count):
            terms[k] *= growth


@kernel
def count_terms(case: Case) -> None:
    """Write numbers of significant powers of both inputs to `case.lengths`, by span and rate.

    A span lies between two knots of the case. Powers k of the terms c u^k e^(rate u) above the
    number are negligible in both inputs at all times u of the span.
    """
    for i in range(case.knots.size - 1):
        width = case.knots[i + 1] - case.knots[i]
        for q in range(case.rates.size):
            first, second = case.forces[i, 0, q], case.forces[i, 1, q]
            case.lengths[i, q] = max(
                significant_terms(first, width), significant_terms(second, width)
            )


@kernel
def significant_terms(terms: Any, width: Any) -> Any:
    """Return the number of terms of a polynomial up to the last significant one.

    A term c_k u^k is largest at the end of its span, u = width [s], and is significant if it is
    there above `NEGLIGIBLE_TERM` times the largest one before. `terms`: c, lowest power first; at
    an infinite width all that are not zero are significant.
    """
    power, largest, count = 1.0, 0.0, 0
    for k in range(terms.size):
        if terms[k] != 0.0:
            size = abs(terms[k]) * power
            largest = max(largest, size)
            if np.isinf(width) or size > NEGLIGIBLE_TERM * largest:
                count = k + 1
        power = power if np.isinf(width) else power * width
    return count


class Plant(NamedTuple):
    """Modes z' = p z + g f of a plant, with both inputs f, deflection and wind.

    `poles`: p [1/s], ``(N,)``. `gains`: g, ``(N, 2)``. `outputs`: coefficient of each mode in each
    output, ``(N, R)``. `less_wind`: whether the wind is subtracted from the last output.
    """

    poles: Any
    gains: Any
    outputs: Any
    less_wind: Any


class Span(NamedTuple):
    """Work arrays of a span, the time u between two knots, for N modes, Q rates and R outputs.

    A mode z' = p z + g f is a particular solution, a polynomial in u times e^(rate u) for each rate
    of the input f, and coefficients times e^(p u). Of each mode, ``(N,)``: `backward`, whether it
    is unstable and integrated from the last knot to the first; `state`, z at the begin of the span;
    `lead`, `tail` and `excess`, coefficients of e^(p u), of e^(p (u - width)), and of e^(p t) with
    the time t since the first knot. `bounded`: bounded z at the knots, ``(N, K + 1)``.
    `solution`: particular solution of a mode, ``(Q, L)``, lowest power first, and its numbers of
    terms, `sizes` ``(Q,)``. `shares`: sums of these in the outputs, ``(R, Q, L)``, and their
    numbers of terms, `lengths` ``(Q,)``.
    """

    backward: Any
    excess: Any
    state: Any
    lead: Any
    tail: Any
    bounded: Any
    solution: Any
    sizes: Any
    shares: Any
    lengths: Any


def workspace(
    kind: Any, plant: tuple[int, int], deflections: tuple[Any, ...], winds: tuple[Any, ...]
) -> tuple[Case, Span]:
    """Return the arrays for one case, which the kernel overwrites.

    `kind`: type of poles and coefficients, float or complex. `plant`: numbers of modes and of
    outputs. `deflections`, `winds`: H histories of each input: knots ``(H, n)``, coefficients
    ``(H, n, r, m)`` and rates ``(H, r)``.
    """
    modes, rows = plant
    knots = deflections[0].shape[1] + winds[0].shape[1]
    rates = 1 + deflections[2].shape[1] + winds[2].shape[1]
    powers = max(deflections[1].shape[3], winds[1].shape[3])
    length = powers + MAX_ADDED_TERMS + 1
    case = Case(
        np.empty(knots + 1),
        np.zeros(rates, kind),
        np.empty((knots, 2, rates, powers), kind),
        np.empty((knots, rates), np.int64),
    )
    span = Span(
        np.empty(modes, np.bool_),
        np.empty(modes, kind),
        np.empty(modes, kind),
        np.empty(modes, kind),
        np.empty(modes, kind),
        np.empty((modes, knots + 1), kind),
        np.empty((rates, length), kind),
        np.empty(rates, np.int64),
        np.empty((rows, rates, length), kind),
        np.empty(rates, np.int64),
    )
    return case, span


@kernel
def respond(
    times: Any,
    plants: Any,
    deflections: Any,
    winds: Any,
    which: Any,
    out: Any,
    close: Any,
    memory: Any,
    first: Any,
    last: Any,
) -> None:
    """Write the R outputs of plants at n times, for the cases from `first` up to `last`.

    `times`: [s], ascending, ``(n,)``. `plants`: poles [1/s] ``(P, N)``, gains of deflection and
    wind ``(P, N, 2)``, outputs of the modes ``(P, N, R)``, and whether the wind is subtracted from
    the last output. `deflections`, `winds`: H histories of each input, sums of terms c u^k
    e^(rate u) with the time u since a knot: knots [s] ``(H, k)``, coefficients c ``(H, k, r, m)``
    and rates [1/s] ``(H, r)``. `which`: indices of plant, deflection and wind of each case,
    ``(3, cases)``. `out`: written, ``(cases, R, n)``. `close`: written: whether two poles are too
    close for distinct modes, ``(cases,)``; such a case is skipped. `memory`: arrays of `workspace`,
    not shared with another thread.

    An unstable mode that grows enough is the bounded solution, computed backwards, and its residue
    times e^(p t); a residue below its rounding is zero, so that the mode does not diverge.
    """
    arrays, span = memory
    for number in range(first, last):
        p, d, w = which[0, number], which[1, number], which[2, number]
        plant = Plant(plants[0][p], plants[1][p], plants[2][p], plants[3])
        count = merge_knots(deflections[0][d], winds[0][w], arrays.knots)
        horizon = max(times[times.size - 1] - arrays.knots[0], 0.0)
        close[number] = has_close_poles(plant.poles, horizon)
        if close[number]:
            continue
        used = add_rates(deflections[2][d], arrays.rates, 1)  # behind the first rate, zero
        used = add_rates(winds[2][w], arrays.rates, used)
        case = Case(arrays.knots[: count + 1], arrays.rates[:used], arrays.forces, arrays.lengths)
        put_input(case, case.forces[:, 0], deflections[0][d], deflections[1][d], deflections[2][d])
        put_input(case, case.forces[:, 1], winds[0][w], winds[1][w], winds[2][w])
        count_terms(case)
        fastest = 0.0  # size of the largest pole
        for m in range(plant.poles.size):
            fastest = max(fastest, abs(plant.poles[m]))
        for m in range(plant.poles.size):
            pole, gain = plant.poles[m], plant.gains[m]
            span.state[m], span.excess[m], span.backward[m] = 0.0, 0.0, False
            unstable = pole.real > MARGINAL * fastest and abs(pole) * horizon > MAX_FORWARD_GROWTH
            if unstable and bounded_solution(pole, gain, case, m, span):
                span.backward[m] = True
                rounding = EPSILON * residue_roundings(pole, deflections[0][d], winds[0][w])
                size = residue_magnitude(pole, gain[0], case.knots[0], deflections, d)
                size += residue_magnitude(pole, gain[1], case.knots[0], winds, w)
                if abs(span.bounded[m, 0]) > rounding * size:
                    span.excess[m] = -span.bounded[m, 0]
        march_case(times, plant, case, span, out[number])


@kernel
def march_case(times: Any, plant: Plant, case: Case, span: Span, out: Any) -> None:
    """Write the outputs of a case at ascending times ``(n,)`` [s] to `out` ``(R, n)``, by spans.

    A span lies between two knots. `plant`: its poles, gains and outputs. `case`: both inputs.
    `span`: work arrays, with the residues and the bounded solutions of unstable modes, which are
    computed backwards. Outputs are zero before the first knot.
    """
    first = np.searchsorted(times, case.knots[0])  # the first time of the span, then `last` its end
    for r in range(out.shape[0]):
        for j in range(first):
            out[r, j] = 0.0
    for i in range(case.knots.size - 1):
        if first == times.size:
            break
        width = case.knots[i + 1] - case.knots[i]
        reach = min(case.knots[i + 1], times[times.size - 1]) - case.knots[i]
        for q in range(case.rates.size):
            span.lengths[q] = 0
        for m in range(plant.poles.size):
            pole, horizon = plant.poles[m], width if span.backward[m] else reach
            # z(u) - a(u) = w e^(p u), with w from the end at which z is known: from the left
            # z(0) - a(0) (lead), or for what grows from the right z(width) - a(width) (tail).
            start, stop = particular_solution(pole, plant.gains[m], case, i, horizon, span)
            if span.backward[m]:
                span.lead[m] = 0.0
                span.tail[m] = 0.0 if np.isinf(width) else span.bounded[m, i + 1] - stop
            else:
                span.lead[m], span.tail[m] = span.state[m] - start, 0.0
                span.state[m] = span.lead[m] * np.exp(pole * reach) + stop
            add_share(plant.outputs[m], case.rates.size, span)
        if plant.less_wind:
            subtract_wind(case, i, span)
        last = np.searchsorted(times, case.knots[i + 1])
        write_outputs(times[first:last], plant, case, i, span, out[:, first:last])
        first = last


@allocation_free
def write_outputs(times: Any, plant: Plant, case: Case, i: Any, span: Span, out: Any) -> None:
    """Write the outputs at n times of span i to `out` ``(R, n)``: the real parts of sums.

    They are the polynomials of the particular solutions times e^(rate u), and the free exponentials
    of the modes. `times`: [s], between two knots. `plant`, `case`: poles and outputs, and knots and
    rates of the inputs. `span`: coefficients of both. Products of parts that are zero are omitted,
    so that 0 times inf is 0.
    """
    width, since = case.knots[i + 1] - case.knots[i], case.knots[i] - case.knots[0]
    for j in range(times.size):
        u = times[j] - case.knots[i]
        for r in range(out.shape[0]):
            out[r, j] = 0.0
        for q in range(case.rates.size):
            if span.lengths[q] > 0:
                add_polynomials(u, case.rates[q], span.shares[:, q, : span.lengths[q]], out[:, j])
        for m in range(plant.poles.size):
            real, imaginary = amplitude(plant.poles[m], m, u, width, since, span)
            for r in range(out.shape[0]):
                share = plant.outputs[m, r]  # of the mode in the output
                if real != 0.0 and share.real != 0.0:
                    out[r, j] += share.real * real
                if imaginary != 0.0 and share.imag != 0.0:
                    out[r, j] -= share.imag * imaginary


@allocation_free
def add_polynomials(u: Any, rate: Any, shares: Any, out: Any) -> None:
    """Add the real parts of polynomials in u, times e^(rate u), to the outputs `out` ``(R,)``.

    `u`: time since the begin of the span [s]. `rate`: [1/s], which may be complex. `shares`:
    coefficients of each output's polynomial, lowest power first, ``(R, L)``.
    """
    real, imaginary = exponential(rate, u)
    for r in range(out.size):
        total = shares[r, shares.shape[1] - 1]
        for k in range(shares.shape[1] - 2, -1, -1):
            total = total * u + shares[r, k]
        out[r] += total.real * real
        if imaginary != 0.0:
            out[r] -= total.imag * imaginary


@allocation_free
def amplitude(pole: Any, mode: Any, u: Any, width: Any, since: Any, span: Span) -> Any:
    """Return real and imaginary part of a mode's free exponential at the local time u [s].

    It is lead e^(p u) + tail e^(p (u - width)) + excess e^(p (u + since)): known from the left end
    of the span, from its right end, and from the first knot, the last being an unstable mode's
    residue. `pole`, `mode`: p [1/s] and its index. `width`: of the span [s]. `since`: from the
    first knot to the span [s]. `span`: coefficients.
    """
    real, imaginary = 0.0, 0.0
    for term in range(3):
        coefficient, time = span.lead[mode], u
        if term == 1:
            coefficient, time = span.tail[mode], u - width
        elif term == 2:
            coefficient, time = span.excess[mode], u + since
        if coefficient != 0.0:
            a, b = exponential(pole, time)
            real += coefficient.real * a
            if pole.imag != 0.0:
                real -= coefficient.imag * b
                imaginary += coefficient.real * b + coefficient.imag * a
    return real, imaginary


@allocation_free
def exponential(exponent: Any, u: Any) -> Any:
    """Return the real and the imaginary part of e^(exponent u), for a complex exponent [1/s]."""
    real, angle = np.exp(exponent.real * u), exponent.imag * u
    return (real, 0.0) if angle == 0.0 else (real * np.cos(angle), real * np.sin(angle))


@kernel
def particular_solution(pole: Any, gain: Any, case: Case, i: Any, width: Any, span: Span) -> Any:
    """Write a particular solution of a mode in span i; return its values at both ends.

    Of z' = p z + g f, where f is the input's polynomial c times e^(r u) for each rate r, it is
    a polynomial a times e^(r u) with a' + (r - p) a = g c, written to `span.solution`. `pole`,
    `gain`: p [1/s], and g of both inputs, ``(2,)``. `case`: both inputs. `width`: length of the
    span [s], or of its beginning up to the last time of the response. At infinite width, after the
    last knot, the second value is zero and not used. Where r - p is so small that the finite sum
    cancels, a is the power series with a = 0 at the begin.
    """
    start, stop = 0.0 * pole, 0.0 * pole
    for q in range(case.rates.size):
        count, gap, terms = case.lengths[i, q], case.rates[q] - pole, span.solution[q]
        per_gap = 1.0 / gap if gap != 0.0 else gap + np.inf
        first, second = case.forces[i, 0, q], case.forces[i, 1, q]
        span.sizes[q] = count
        if count == 0:
            continue
        # (k + 1) a_(k+1) + gap a_k = g c_k, from the highest power on
        coefficient, input_bound = 0.0 * pole, 0.0
        for k in range(count - 1, -1, -1):
            forcing = gain[0] * first[k] + gain[1] * second[k]
            coefficient = (forcing - (k + 1) * coefficient) * per_gap
            terms[k] = coefficient
            input_bound = input_bound * width + abs(forcing) / (k + 1)
        if np.isinf(width):
            start += coefficient
            continue
        if not abs(coefficient) <= MAX_CANCELLATION * input_bound * width:
            # the same from the lowest power on, with a_0 = 0
            terms[0], k, term = 0.0, 0, 1.0
            while k < count or (term > NEGLIGIBLE_TERM and k + 1 < terms.size):
                forcing = gain[0] * first[k] + gain[1] * second[k] if k < count else 0.0 * pole
                terms[k + 1] = (forcing - gap * terms[k]) / (k + 1)
                k += 1
                if k >= count:
                    term *= abs(gap) * width / (k + 1)
            span.sizes[q] = k + 1
        start += terms[0]
        total = terms[span.sizes[q] - 1]
        for k in range(span.sizes[q] - 2, -1, -1):
            total = total * width + terms[k]
        stop += total * np.exp(case.rates[q] * width) if case.rates[q] != 0.0 else total
    return start, stop


@kernel
def bounded_solution(pole: Any, gain: Any, case: Case, mode: Any, span: Span) -> Any:
    """Write the bounded solution of an unstable mode at each knot; return whether there is one.

    It is written to row `mode` of `span.bounded`. `pole`, `gain`: p [1/s] and g ``(2,)`` of the
    mode z' = p z + g f. `case`: both inputs f. After the last knot the bounded z is the particular
    solution a, if no rate of the input grows as fast as p; in each span before it, backwards,
    z(0) = a(0) + e^(-p width) [z(width) - a(width)].
    """
    last = case.knots.size - 2
    for q in range(case.rates.size):
        if case.lengths[last, q] > 0 and not (case.rates[q] - pole).real < 0.0:
            return False
    span.bounded[mode, last + 1] = 0.0
    for i in range(last, -1, -1):
        width = case.knots[i + 1] - case.knots[i]
        start, stop = particular_solution(pole, gain, case, i, width, span)
        span.bounded[mode, i] = start
        if i < last:
            span.bounded[mode, i] += np.exp(-pole * width) * (span.bounded[mode, i + 1] - stop)
    return bool(np.isfinite(abs(span.bounded[mode, 0])))


@kernel
def residue_magnitude(pole: Any, gain: Any, start: Any, histories: Any, number: Any) -> Any:
    """Return the sum of the sizes of all terms of the residue of one input, within a quarter.

    Times the relative rounding it bounds the error of the residue, g times the integral of
    e^(-p t) f. `pole`, `gain`: p [1/s] and g of the mode z' = p z + g f. `start`: time from which t
    counts [s]. `histories`: knots, coefficients and rates of inputs, of which `number` is f.

    The integral of u^k e^(-gap u) up to a width, with gap = p - rate, is approximated by
    1/(1/a + 1/b): a = width^(k+1)/(k+1) is that without decay, b = k!/gap^(k+1) that without end.
    """
    knots, coefficients, rates = histories[0][number], histories[1][number], histories[2][number]
    total = 0.0
    for i in range(knots.size):
        width = knots[i + 1] - knots[i] if i + 1 < knots.size else np.inf
        late = np.exp(-pole.real * (knots[i] - start))
        for q in range(rates.size):
            gap = (pole - rates[q]).real
            power, endless = 1.0, 1.0
            growth = np.exp(-gap * width) if gap < 0.0 else 1.0
            for k in range(coefficients.shape[2]):
                power *= width
                endless *= max(gap, 0.0) / max(k, 1)
                if coefficients[i, q, k] != 0.0:
                    weight = late * growth / ((k + 1) / power + endless)
                    total += abs(gain) * abs(coefficients[i, q, k]) * weight
    return total


@kernel
def residue_roundings(pole: Any, first: Any, second: Any) -> Any:
    """Return a bound on the roundings in the residue of two inputs, in units of one rounding.

    The exponential e^(-p t) of a large exponent has a relative error of as many roundings as the
    exponent, and a sum over n knots about sqrt(n). `pole`: p [1/s]. `first`, `second`: knots of
    both inputs [s].
    """
    start, total = min(first[0], second[0]), ROUNDINGS
    for knots in (first, second):
        exponent = abs(pole) * abs(knots[knots.size - 1] - start)
        total += min(exponent, UNDERFLOW_EXPONENT) + np.sqrt(knots.size)
    return total


@kernel
def has_close_poles(poles: Any, horizon: Any) -> Any:
    """Return whether two poles are too close for a response by modes within a time.

    The residues of two close poles are large and cancel. `poles`: of a plant [1/s], ``(N,)``.
    `horizon`: the time [s]. A plant with a fast unstable pole keeps its modes all the same, unless
    two are equal: the alternative, a chain of lags, is integrated forward and would lose its
    digits.
    """
    gap, size, fastest = np.inf, 0.0, -np.inf
    for i in range(poles.size):
        size, fastest = max(size, abs(poles[i])), max(fastest, poles[i].real)
        for j in range(i):
            gap = min(gap, abs(poles[i] - poles[j]))
    close = gap <= MIN_POLE_DISTANCE * size or gap * horizon <= MIN_POLE_DISTANCE
    return close and (fastest * horizon <= MAX_LAG_GROWTH or gap == 0.0)


@kernel
def add_share(outputs: Any, used: Any, span: Span) -> None:
    """Add a mode's particular solution to the outputs, times the mode's coefficient in each.

    `outputs`: these coefficients, ``(R,)``. `used`: number of rates. `span`: the `solution`, a
    polynomial for each rate, and the sums of such polynomials in the outputs, `shares`; changed.
    """
    for q in range(used):
        lengthen(q, span.sizes[q], span)
        for r in range(outputs.size):
            for k in range(span.sizes[q]):
                span.shares[r, q, k] += outputs[r] * span.solution[q, k]


@kernel
def subtract_wind(case: Case, i: Any, span: Span) -> None:
    """Subtract the wind in span i of a case, its second input, from the last output, in place.

    The last output, the angle of attack, is the last of `span.shares`, a polynomial for each rate.
    """
    last = span.shares.shape[0] - 1
    for q in range(case.rates.size):
        lengthen(q, case.lengths[i, q], span)
        for k in range(case.lengths[i, q]):
            span.shares[last, q, k] -= case.forces[i, 1, q, k]


@kernel
def lengthen(q: Any, length: Any, span: Span) -> None:
    """Pad the outputs' polynomials that multiply e^(rate u) with zeros, to at least `length` terms.

    `q`: index of the rate. `span`: the coefficients are its `shares` ``(R, Q, L)`` by output, rate
    and power, and the numbers of terms in use its `lengths` ``(Q,)``; both are changed.
    """
    for r in range(span.shares.shape[0]):
        for k in range(span.lengths[q], length):
            span.shares[r, q, k] = 0.0
    span.lengths[q] = max(span.lengths[q], length)
