"""Modal responses, exact from knot to knot, case by case: the kernel of `numerics.modal`.

Between two knots, with the local time u, the inputs are sums of c(u) e^(r u), and a mode

    z' = p z + g f     is     z(u) = w e^(p u) + sum over r of a(u) e^(r u),
                              a' + (r - p) a = g c.

Outputs are sums of modes, so they are such sums too: each is one polynomial for each rate, and
one number for each pole. Cases are independent. All coefficients are real, or complex where a pole
or a rate of an input is.
"""

from typing import Any, NamedTuple

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IntArray
from tvclin.kernels.source import allocation_free, kernel

Histories = tuple[AnyArray, AnyArray, AnyArray]
"""H histories of an input [rad]: knots [s] ``(H, k)``, and the coefficients c ``(H, k, r, m)`` and
rates [1/s] ``(H, r)`` of its terms c u^power e^(rate u), power below m, in the time u since a
knot."""
PlantArrays = tuple[AnyArray, AnyArray, AnyArray, bool]
"""P plants of N modes: fields of `Plant` with a first axis for the plants, but for the last."""

NEGLIGIBLE_TERM = 1e-17
"""Term, relative to the largest, that is neglected."""
PLAIN_SECONDS, PLAIN_SECONDS_PER_TIME = 1e-3, 2e-6
"""Seconds that plain Python takes for a case, and for one time of one output."""
COMPILED_OVER_PLAIN = 1e-3
"""Ratio of the times of machine code and of plain Python."""
MARGINAL = 1e-12
"""Real part of a pole over the size of the largest pole, up to which the pole is not unstable."""
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
DEFLECTION, WIND = 0, 1
"""Index of each input among the gains of a mode and the coefficients of a case."""


class Case(NamedTuple):
    """Both inputs of a case, deflection and wind [rad], on their common knots.

    From each knot on, an input is a sum of terms c u^k e^(rate u), with the time u since it.
    `knots`: [s], ``(K + 1,)``, the last at infinity. `rates`: [1/s], ``(Q,)``, distinct, the first
    zero. `forces`: c, by knot, input (`DEFLECTION`, `WIND`), rate and power k, ``(K, 2, Q, m)``.
    `lengths`: numbers of significant powers of both inputs, ``(K, Q)``.
    """

    knots: FloatArray
    rates: AnyArray
    forces: AnyArray
    lengths: IntArray


@kernel
def merge_knots(first: AnyArray, second: AnyArray, knots: AnyArray) -> int:
    """Write the knots [s] of both inputs without repetition, then infinity; return their number.

    `first`, `second`: ascending knots of each input. `knots`: written: ascending; infinity follows
    the last and is not counted. Its size is that of both and one more.
    """
    i, j, count = 0, 0, 0  # next knot of each input, and number of knots that are written
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
def add_rates(new_rates: AnyArray, rates: AnyArray, used: int) -> int:
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
def rate_index(rate: complex, rates: AnyArray, used: int) -> int:
    """Return the index of `rate` [1/s] among the first `used` of `rates`; `used` if absent."""
    at = 0
    while at < used and rates[at] != rate:
        at += 1
    return at


@kernel
def put_input(
    case: Case, forces: AnyArray, knots: AnyArray, coefficients: AnyArray, rates: AnyArray
) -> None:
    """Write the coefficients of an input about the common knots of a case, to `forces`.

    `case`: its K + 1 knots and Q rates. `forces`: written: coefficients c of the terms
    c u^k e^(rate u) from each knot of the case on, with the time u since it, ``(K, Q, m)``.
    `knots`, `coefficients`, `rates`: the input itself, ``(n,)`` [s], ``(n, r, m)`` and ``(r,)``
    [1/s], whose knots and rates the case has too; before its first knot it is zero. Where the case
    has a knot between two of the input, its terms are expanded about that knot.
    """
    piece = -1  # index of the input's last knot that is not after knot i of the case
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
def recentre(terms: AnyArray, rate: complex, u: float) -> None:
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
def significant_terms(terms: AnyArray, width: float) -> int:
    """Return the number of terms of a polynomial up to the last significant one.

    A term c_k u^k is largest at the end of its span, u = width [s], and is significant if it is
    there above `NEGLIGIBLE_TERM` times the largest one before. `terms`: c, lowest power first; at
    an infinite width all that are not zero are significant.
    """
    power, largest, count = 1.0, 0.0, 0  # power: width^k
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

    `poles`: p [1/s], ``(N,)``. `gains`: g of each mode and input, ``(N, 2)``. `outputs`:
    coefficient of each mode in each output, ``(N, R)``. `less_wind`: whether the wind is subtracted
    from the last output, then the angle of attack.
    """

    poles: AnyArray
    gains: AnyArray
    outputs: AnyArray
    less_wind: bool


class Span(NamedTuple):
    """Work arrays of a span, the time u between two knots, for N modes, Q rates and R outputs.

    A mode z' = p z + g f is a particular solution, a polynomial in u times e^(rate u) for each rate
    of the input f, and coefficients times e^(p u). Of each mode, ``(N,)``: `backward`, whether it
    is unstable and integrated from the last knot to the first; `excess`, coefficient of e^(p t)
    with the time t since the first knot, the negative residue of such a mode; `state`, z at the
    begin of the span, of the others; `lead` and `tail`, coefficients of e^(p u) and of
    e^(p (u - width)). `bounded`: solution z without the excess at the knots, ``(N, K + 1)``.
    `solution`: particular solution of a mode, ``(Q, L)``, lowest power first, and its numbers of
    terms, `sizes` ``(Q,)``. `shares`: sums of these in the outputs, ``(R, Q, L)``, and their
    numbers of terms, `lengths` ``(Q,)``.
    """

    backward: BoolArray
    excess: AnyArray
    state: AnyArray
    lead: AnyArray
    tail: AnyArray
    bounded: AnyArray
    solution: AnyArray
    sizes: IntArray
    shares: AnyArray
    lengths: IntArray


def workspace(
    kind: np.dtype[Any], plant: tuple[int, int], deflections: Histories, winds: Histories
) -> tuple[Case, Span]:
    """Return the arrays of one case and of a span of it, which `respond` overwrites.

    They are not initialised, but for `Case.rates`, zeros. Sizes suffice for each of the cases, so
    that the knots and the rates are those of both inputs together. `kind`: type of poles and
    coefficients, float or complex. `plant`: numbers of modes and of outputs. `deflections`,
    `winds`: histories of each input.
    """
    modes, outputs = plant
    deflection_knots, deflection_terms, deflection_rates = deflections
    wind_knots, wind_terms, wind_rates = winds
    knots = deflection_knots.shape[1] + wind_knots.shape[1]
    rates = 1 + deflection_rates.shape[1] + wind_rates.shape[1]  # 1: the rate zero
    powers = max(deflection_terms.shape[3], wind_terms.shape[3])
    length = powers + MAX_ADDED_TERMS + 1  # of a power series
    case = Case(
        knots=np.empty(knots + 1),
        rates=np.zeros(rates, kind),
        forces=np.empty((knots, 2, rates, powers), kind),
        lengths=np.empty((knots, rates), np.int64),
    )
    span = Span(
        backward=np.empty(modes, np.bool_),
        excess=np.empty(modes, kind),
        state=np.empty(modes, kind),
        lead=np.empty(modes, kind),
        tail=np.empty(modes, kind),
        bounded=np.empty((modes, knots + 1), kind),
        solution=np.empty((rates, length), kind),
        sizes=np.empty(rates, np.int64),
        shares=np.empty((outputs, rates, length), kind),
        lengths=np.empty(rates, np.int64),
    )
    return case, span


@kernel
def respond(
    times: FloatArray,
    plants: PlantArrays,
    deflections: Histories,
    winds: Histories,
    which: IntArray,
    out: FloatArray,
    close: BoolArray,
    memory: tuple[Case, Span],
    first: int,
    last: int,
) -> None:
    """Write the R outputs of plants at n times, for the cases from `first` up to `last`.

    An unstable mode that grows enough is the bounded solution, computed backwards, and its residue
    times e^(p t); a residue below its rounding is zero, so that the mode does not diverge.

    Parameters
    ----------
    times : ndarray
        Times [s], ascending, ``(n,)``.
    plants : tuple
        Poles [1/s] ``(P, N)``, gains of deflection and wind ``(P, N, 2)``, outputs of the modes
        ``(P, N, R)``, and whether the wind is subtracted from the last output.
    deflections, winds : tuple
        H histories of each input [rad], sums of terms c u^k e^(rate u) in the time u since a knot:
        knots [s] ``(H, k)``, coefficients c ``(H, k, r, m)`` and rates [1/s] ``(H, r)``.
    which : ndarray of int
        Indices of plant, deflection and wind of each case, ``(3, cases)``.
    out : ndarray
        Written: outputs in the unit of the inputs, ``(cases, R, n)``.
    close : ndarray of bool
        Written: whether two poles are too close for distinct modes, ``(cases,)``; the outputs of
        such a case are not.
    memory : tuple
        Work arrays of `workspace`, for this thread alone.
    first, last : int
        Cases from the first up to the last are computed.
    """
    arrays, span = memory
    poles, gains, mode_outputs, less_wind = plants
    deflection_knots, deflection_terms, deflection_rates = deflections
    wind_knots, wind_terms, wind_rates = winds
    for number in range(first, last):
        p, d, w = which[0, number], which[1, number], which[2, number]
        plant = Plant(poles[p], gains[p], mode_outputs[p], less_wind)
        count = merge_knots(deflection_knots[d], wind_knots[w], arrays.knots)
        horizon = max(times[times.size - 1] - arrays.knots[0], 0.0)  # the response's length [s]
        close[number] = has_close_poles(plant.poles, horizon)
        if close[number]:
            continue
        used = add_rates(deflection_rates[d], arrays.rates, 1)  # behind the first rate, zero
        used = add_rates(wind_rates[w], arrays.rates, used)
        case = Case(arrays.knots[: count + 1], arrays.rates[:used], arrays.forces, arrays.lengths)
        deflection, wind = case.forces[:, DEFLECTION], case.forces[:, WIND]
        put_input(case, deflection, deflection_knots[d], deflection_terms[d], deflection_rates[d])
        put_input(case, wind, wind_knots[w], wind_terms[w], wind_rates[w])
        count_terms(case)
        fastest = 0.0  # size of the largest pole [1/s]
        for m in range(plant.poles.size):
            fastest = max(fastest, abs(plant.poles[m]))
        for m in range(plant.poles.size):
            pole, gain = plant.poles[m], plant.gains[m]
            span.state[m], span.excess[m], span.backward[m] = 0.0, 0.0, False
            unstable = pole.real > MARGINAL * fastest and abs(pole) * horizon > MAX_FORWARD_GROWTH
            if unstable and bounded_solution(pole, gain, case, m, span):
                span.backward[m] = True
                rounding = EPSILON * residue_roundings(pole, deflection_knots[d], wind_knots[w])
                size = residue_magnitude(pole, gain[DEFLECTION], case.knots[0], deflections, d)
                size += residue_magnitude(pole, gain[WIND], case.knots[0], winds, w)
                # z is zero at the first knot: the bounded z there is the negative of the excess
                if abs(span.bounded[m, 0]) > rounding * size:
                    span.excess[m] = -span.bounded[m, 0]
        march_case(times, plant, case, span, out[number])


@kernel
def march_case(times: FloatArray, plant: Plant, case: Case, span: Span, out: FloatArray) -> None:
    """Write the outputs of a case at ascending times ``(n,)`` [s] to `out` ``(R, n)``, by spans.

    A span lies between two knots. `plant`: its poles, gains and outputs. `case`: both inputs.
    `span`: work arrays, with `backward`, `excess` and `bounded` of unstable modes, which are
    computed backwards, and zero as the state of the others. Outputs are zero before the first knot.
    """
    first = np.searchsorted(times, case.knots[0])  # index of the span's first time; `last`: its end
    for r in range(out.shape[0]):
        for j in range(first):
            out[r, j] = 0.0
    for i in range(case.knots.size - 1):
        if first == times.size:
            break
        width = case.knots[i + 1] - case.knots[i]
        reach = min(case.knots[i + 1], times[times.size - 1]) - case.knots[i]  # to the last time
        for q in range(case.rates.size):
            span.lengths[q] = 0  # the outputs' polynomials are zero
        for m in range(plant.poles.size):
            pole, horizon = plant.poles[m], width if span.backward[m] else reach
            # z(u) - a(u) = w e^(p u), with w from the end at which z is known: from the left
            # z(0) - a(0) (lead), or of an unstable mode from the right z(width) - a(width) (tail).
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
def write_outputs(
    times: FloatArray, plant: Plant, case: Case, i: int, span: Span, out: FloatArray
) -> None:
    """Write the outputs at n times of span i, between knots i and i + 1, to `out` ``(R, n)``.

    Output r is the real part of a sum over rates q and modes m, u being the time since knot i:
    `span.shares` (r, q), a polynomial in u of `span.lengths` (q) terms, times e^(rate u); and
    `plant.outputs` (m, r) times the mode's free exponential (`amplitude`). `times`: in the span
    [s]. `case`: knots and rates. Products of parts that are zero are omitted: 0 times inf is 0.
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
def add_polynomials(u: float, rate: complex, shares: AnyArray, out: FloatArray) -> None:
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
def amplitude(
    pole: complex, mode: int, u: float, width: float, since: float, span: Span
) -> tuple[float, float]:
    """Return real and imaginary part of a mode's free exponential at the local time u [s].

    It is lead e^(p u) + tail e^(p (u - width)) + excess e^(p (u + since)): known from the left end
    of the span, from its right end, and from the first knot, the last being an unstable mode's
    residue. `pole`, `mode`: p [1/s] and its index. `width`: of the span [s]. `since`: from the
    first knot to the span [s]. `span`: these three coefficients of each mode.
    """
    real, imaginary = 0.0, 0.0
    for term in range(3):  # lead, tail and excess
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
def exponential(exponent: complex, u: float) -> tuple[float, float]:
    """Return the real and the imaginary part of e^(exponent u), for a complex exponent [1/s]."""
    real, angle = np.exp(exponent.real * u), exponent.imag * u
    return (real, 0.0) if angle == 0.0 else (real * np.cos(angle), real * np.sin(angle))


@kernel
def particular_solution(
    pole: complex, gain: AnyArray, case: Case, i: int, width: float, span: Span
) -> tuple[complex, complex]:
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
        # number of terms of c; r - p; and the terms of a, lowest power first
        count, gap, terms = case.lengths[i, q], case.rates[q] - pole, span.solution[q]
        per_gap = 1.0 / gap if gap != 0.0 else gap + np.inf
        first, second = case.forces[i, DEFLECTION, q], case.forces[i, WIND, q]
        span.sizes[q] = count
        if count == 0:
            continue
        # (k + 1) a_(k+1) + gap a_k = g c_k, from the highest power on
        coefficient, input_bound = 0.0 * pole, 0.0  # the bound is of g c, over the span, per width
        for k in range(count - 1, -1, -1):
            forcing = gain[DEFLECTION] * first[k] + gain[WIND] * second[k]
            coefficient = (forcing - (k + 1) * coefficient) * per_gap
            terms[k] = coefficient
            input_bound = input_bound * width + abs(forcing) / (k + 1)
        if np.isinf(width):
            start += coefficient
            continue
        if not abs(coefficient) <= MAX_CANCELLATION * input_bound * width:
            # the same from the lowest power on, with a_0 = 0
            terms[0], k, term = 0.0, 0, 1.0  # `term`: size of the last over the last of the input
            while k < count or (term > NEGLIGIBLE_TERM and k + 1 < terms.size):
                forcing = 0.0 * pole
                if k < count:
                    forcing = gain[DEFLECTION] * first[k] + gain[WIND] * second[k]
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
def bounded_solution(pole: complex, gain: AnyArray, case: Case, mode: int, span: Span) -> bool:
    """Write the bounded solution of an unstable mode at each knot; return whether there is one.

    It is written to row `mode` of `span.bounded`. `pole`, `gain`: p [1/s] and g ``(2,)`` of the
    mode z' = p z + g f. `case`: both inputs f. After the last knot the bounded z is the particular
    solution a, and there is none where an input grows as fast as e^(p t); in each span before it,
    backwards, z(0) = a(0) + e^(-p width) [z(width) - a(width)].
    """
    last = case.knots.size - 2  # index of the last span, whose end is at infinity
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
def residue_magnitude(
    pole: complex, gain: complex, start: float, histories: Histories, number: int
) -> float:
    """Return the sum of the sizes of all terms of the residue of one input, within a quarter.

    Times the relative rounding it bounds the error of the residue, g times the integral of
    e^(-p t) f. `pole`, `gain`: p [1/s] and g of the mode z' = p z + g f. `start`: time from which t
    counts [s]. `histories`: knots, coefficients and rates of an input, of which `number` is f.

    The integral of u^k e^(-gap u) up to a width, with gap = p - rate, is approximated by
    1/(1/a + 1/b): a = width^(k+1)/(k+1) is that without decay, b = k!/gap^(k+1) that without end.
    """
    knots_of_all, coefficients_of_all, rates_of_all = histories
    knots, coefficients = knots_of_all[number], coefficients_of_all[number]
    rates, total = rates_of_all[number], 0.0
    for i in range(knots.size):
        width = knots[i + 1] - knots[i] if i + 1 < knots.size else np.inf
        late = np.exp(-pole.real * (knots[i] - start))
        for q in range(rates.size):
            gap = (pole - rates[q]).real
            power, endless = 1.0, 1.0  # become width^(k+1) and gap^(k+1)/k!
            growth = np.exp(-gap * width) if gap < 0.0 else 1.0
            for k in range(coefficients.shape[2]):
                power *= width
                endless *= max(gap, 0.0) / max(k, 1)
                if coefficients[i, q, k] != 0.0:
                    weight = late * growth / ((k + 1) / power + endless)
                    total += abs(gain) * abs(coefficients[i, q, k]) * weight
    return total


@kernel
def residue_roundings(pole: complex, first: AnyArray, second: AnyArray) -> float:
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
def has_close_poles(poles: AnyArray, horizon: float) -> bool:
    """Return whether two poles are too close for a response by modes within a time.

    The residues of two close poles are large and cancel. `poles`: of a plant [1/s], ``(N,)``.
    `horizon`: the time [s]. A plant with a fast unstable pole keeps its modes all the same, unless
    two are equal: the alternative, matrix exponentials, is integrated forward and would lose its
    digits.
    """
    gap, size, fastest = np.inf, 0.0, -np.inf  # smallest distance, largest size and real part
    for i in range(poles.size):
        size, fastest = max(size, abs(poles[i])), max(fastest, poles[i].real)
        for j in range(i):
            gap = min(gap, abs(poles[i] - poles[j]))
    close = gap <= MIN_POLE_DISTANCE * size or gap * horizon <= MIN_POLE_DISTANCE
    return close and (fastest * horizon <= MAX_LAG_GROWTH or gap == 0.0)


@kernel
def add_share(outputs: AnyArray, used: int, span: Span) -> None:
    """Add a mode's particular solution to the outputs, times the mode's coefficient in each.

    `outputs`: these coefficients, ``(R,)``. `used`: number of rates. `span`: the `solution`, a
    polynomial of `sizes` terms for each rate, and its sums over the modes by output and rate,
    `shares`; changed.
    """
    for q in range(used):
        lengthen(q, span.sizes[q], span)
        for r in range(outputs.size):
            for k in range(span.sizes[q]):
                span.shares[r, q, k] += outputs[r] * span.solution[q, k]


@kernel
def subtract_wind(case: Case, i: int, span: Span) -> None:
    """Subtract the wind in span i of a case, its second input, from the last output, in place.

    The last output, the angle of attack, is the last of `span.shares`, a polynomial for each rate.
    """
    last = span.shares.shape[0] - 1
    for q in range(case.rates.size):
        lengthen(q, case.lengths[i, q], span)
        for k in range(case.lengths[i, q]):
            span.shares[last, q, k] -= case.forces[i, WIND, q, k]


@kernel
def lengthen(q: int, length: int, span: Span) -> None:
    """Pad the outputs' polynomials that multiply e^(rate u) with zeros, to at least `length` terms.

    `q`: index of the rate. `span`: the coefficients are its `shares` ``(R, Q, L)`` by output, rate
    and power, and the numbers of terms in use its `lengths` ``(Q,)``; both are changed.
    """
    for r in range(span.shares.shape[0]):
        for k in range(span.lengths[q], length):
            span.shares[r, q, k] = 0.0
    span.lengths[q] = max(span.lengths[q], length)
