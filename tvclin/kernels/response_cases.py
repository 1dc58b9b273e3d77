"""Modes carried exactly from knot to knot, one case after another: the kernel of `responses`.

Between two knots, with the local time u, the inputs are sums of c(u) e^(r u), and a mode

    z' = p z + g f     is     z(u) = w e^(p u) + sum over r of a(u) e^(r u),
                              a' + (r - p) a = g c.

Outputs are sums of modes, so they are such sums too: each is one polynomial for each rate, and
one number for each pole. A case needs nothing of its neighbours.
"""

from typing import Any, NamedTuple

import numpy as np

from tvclin.kernels.response_inputs import NOTHING, Case, distinct, measure, merge, put
from tvclin.kernels.source import bare, kernel

PLAIN, PLAIN_TIME = 1e-3, 2e-6
"""Seconds that plain Python takes for a case, and for one time of one output."""
COMPILED = 1e-3
"""What machine code takes of that."""
MARGINAL = 1e-12
"""A pole whose real part is below this part of the largest pole counts as not growing."""
SLOW = 1.0
"""A mode that grows by no more than e in the time asked for may go forward."""
LOSS = 4.0
"""An answer this many times as large as what drives it cancels: it comes from its series."""
MORE = 47
"""No series has so many terms beyond those of its input."""
SEPARATE = 1e-3
"""Poles nearer to each other than this, over the largest or over the time, count as near: their
residues are large and cancel, by about one over it."""
FORWARD = 20.0
"""A plant that grows by no more than e^20 may be carried forward, which loses as many digits as
e^20 has; one that grows more keeps its modes although two poles are near."""
EPS, ROUNDINGS, DEAD = 2.0**-52, 32.0, 750.0
"""As in `residues`: of numbers, in one term of a transform, and an exponent that ends it."""


class Plant(NamedTuple):
    """Poles ``(N,)``, gains ``(N, 2)``, outputs ``(N, R)``; the last is less the wind, or not."""

    poles: Any
    gains: Any
    outputs: Any
    less_wind: Any


class Span(NamedTuple):
    """What a span between two knots is made of.

    For each mode whether it is carried `backward`, its residue `excess`, the state at a knot
    (`state`, and `known` ``(N, K + 1)`` of those carried backward), and what there is of its
    exponential beside the answer, as seen from either end (`lead`, `tail`). One `answer`
    ``(Q, L)`` to the inputs with its `sizes` ``(Q,)``, and the outputs' sum of them, `shares`
    ``(R, Q, L)`` with its `lengths` ``(Q,)``.
    """

    backward: Any
    excess: Any
    state: Any
    lead: Any
    tail: Any
    known: Any
    answer: Any
    sizes: Any
    shares: Any
    lengths: Any


def room(
    kind: Any, plant: tuple[int, int], deflections: tuple[Any, ...], winds: tuple[Any, ...]
) -> tuple[Case, Span]:
    """Return the memory for one case: real or complex, so many modes and outputs, such inputs."""
    modes, rows = plant
    knots = deflections[0].shape[1] + winds[0].shape[1]
    rates = 1 + deflections[2].shape[1] + winds[2].shape[1]
    powers = max(deflections[1].shape[3], winds[1].shape[3])
    length = powers + MORE + 1
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
    near: Any,
    room: Any,
    first: Any,
    last: Any,
) -> None:
    """Answer the cases from `first` up to `last`.

    `times`: times, rising, ``(n,)``. `plants`: poles ``(P, N)``, gains ``(P, N, 2)``, outputs ``(P,
    N, R)``, and whether the wind is taken off the last of these. `deflections`, `winds`: knots
    ``(H, n)``, coefficients ``(H, n, r, m)`` and rates ``(H, r)``. `which`: the plant, the
    deflection and the wind of each case, ``(3, cases)``. `out`, `near`: written: ``(cases, R, n)``,
    and whether two poles are too near for modes to be told apart, ``(cases,)``; such a case is not
    answered. `room`: as from `room`; nobody else may use it meanwhile.
    """
    whole, span = room
    for number in range(first, last):
        p, d, w = which[0, number], which[1, number], which[2, number]
        plant = Plant(plants[0][p], plants[1][p], plants[2][p], plants[3])
        count = merge(deflections[0][d], winds[0][w], whole.knots)
        ahead = max(times[times.size - 1] - whole.knots[0], 0.0)
        near[number] = too_near(plant.poles, ahead)
        if near[number]:
            continue
        used = distinct(deflections[2][d], whole.rates, 1)
        used = distinct(winds[2][w], whole.rates, used)
        case = Case(whole.knots[: count + 1], whole.rates[:used], whole.forces, whole.lengths)
        put(case, case.forces[:, 0], deflections[0][d], deflections[1][d], deflections[2][d])
        put(case, case.forces[:, 1], winds[0][w], winds[1][w], winds[2][w])
        measure(case)
        fastest = 0.0
        for m in range(plant.poles.size):
            fastest = max(fastest, abs(plant.poles[m]))
        for m in range(plant.poles.size):
            pole, gain = plant.poles[m], plant.gains[m]
            span.state[m], span.excess[m], span.backward[m] = 0.0, 0.0, False
            grows = pole.real > MARGINAL * fastest and abs(pole) * ahead > SLOW
            if grows and foresee(pole, gain, case, m, span):
                span.backward[m] = True
                rounding = EPS * roundings(pole, deflections[0][d], winds[0][w])
                size = magnitude(pole, gain[0], case.knots[0], deflections, d)
                size += magnitude(pole, gain[1], case.knots[0], winds, w)
                if abs(span.known[m, 0]) > rounding * size:
                    span.excess[m] = -span.known[m, 0]
        carry(times, plant, case, span, out[number])


@kernel
def carry(times: Any, plant: Any, case: Any, span: Any, out: Any) -> None:
    """Write the outputs of one case, span by span."""
    first = np.searchsorted(times, case.knots[0])
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
            pole, ahead = plant.poles[m], width if span.backward[m] else reach
            # z(u) - a(u) = w e^(p u), with w from the end at which z is known: from the left
            # z(0) - a(0) (lead), or for what grows from the right z(width) - a(width) (tail).
            start, stop = follow(pole, plant.gains[m], case, i, ahead, span)
            if span.backward[m]:
                span.lead[m] = 0.0
                span.tail[m] = 0.0 if np.isinf(width) else span.known[m, i + 1] - stop
            else:
                span.lead[m], span.tail[m] = span.state[m] - start, 0.0
                span.state[m] = span.lead[m] * np.exp(pole * reach) + stop
            share(plant.outputs[m], case.rates.size, span)
        if plant.less_wind:
            subtract_wind(case, i, span)
        last = np.searchsorted(times, case.knots[i + 1])
        sum_up(times[first:last], plant, case, i, span, out[:, first:last])
        first = last


@bare
def sum_up(times: Any, plant: Any, case: Any, i: Any, span: Any, out: Any) -> None:
    """Write the outputs ``(R, n)`` at times of span `i`: real parts, where 0 times inf is 0."""
    width, since = case.knots[i + 1] - case.knots[i], case.knots[i] - case.knots[0]
    for j in range(times.size):
        u = times[j] - case.knots[i]
        for r in range(out.shape[0]):
            out[r, j] = 0.0
        for q in range(case.rates.size):
            if span.lengths[q] > 0:
                add_answer(u, case.rates[q], span.shares[:, q, : span.lengths[q]], out[:, j])
        for m in range(plant.poles.size):
            real, imaginary = amplitude(plant.poles[m], m, u, width, since, span)
            for r in range(out.shape[0]):
                share = plant.outputs[m, r]
                if real != 0.0 and share.real != 0.0:
                    out[r, j] += share.real * real
                if imaginary != 0.0 and share.imag != 0.0:
                    out[r, j] -= share.imag * imaginary


@bare
def add_answer(u: Any, rate: Any, shares: Any, out: Any) -> None:
    """Add the real parts of polynomials ``(R, L)`` times e^(rate u) to the outputs ``(R,)``."""
    real, imaginary = exponential(rate, u)
    for r in range(out.size):
        total = shares[r, shares.shape[1] - 1]
        for k in range(shares.shape[1] - 2, -1, -1):
            total = total * u + shares[r, k]
        out[r] += total.real * real
        if imaginary != 0.0:
            out[r] -= total.imag * imaginary


@bare
def amplitude(pole: Any, mode: Any, u: Any, width: Any, since: Any, span: Any) -> Any:
    """Return real and imaginary part of what there is of a mode's exponential at `u`.

    lead e^(p u) + tail e^(p (u - width)) + excess e^(p (u + since)): the shares that are counted
    from the left end, from the right end, and from the first knot of all.
    """
    real, imaginary = 0.0, 0.0
    for part in range(3):
        share, time = span.lead[mode], u
        if part == 1:
            share, time = span.tail[mode], u - width
        elif part == 2:
            share, time = span.excess[mode], u + since
        if share != 0.0:
            a, b = exponential(pole, time)
            real += share.real * a
            if pole.imag != 0.0:
                real -= share.imag * b
                imaginary += share.real * b + share.imag * a
    return real, imaginary


@bare
def exponential(exponent: Any, u: Any) -> Any:
    """Return the real and the imaginary part of e^(exponent u)."""
    real, angle = np.exp(exponent.real * u), exponent.imag * u
    return (real, 0.0) if angle == 0.0 else (real * np.cos(angle), real * np.sin(angle))


@kernel
def follow(pole: Any, gain: Any, case: Any, i: Any, width: Any, span: Any) -> Any:
    """Write one answer of a mode to its inputs in span `i`; return it at 0 and at the width.

    At infinity it stays what it is at 0.
    """
    start, stop = 0.0 * pole, 0.0 * pole
    for q in range(case.rates.size):
        count, gap, terms = case.lengths[i, q], case.rates[q] - pole, span.answer[q]
        per_gap = 1.0 / gap if gap != 0.0 else gap + np.inf
        first, second = case.forces[i, 0, q], case.forces[i, 1, q]
        span.sizes[q] = count
        if count == 0:
            continue
        # (k + 1) a_(k+1) + gap a_k = c_k, from above
        above, driven = 0.0 * pole, 0.0
        for k in range(count - 1, -1, -1):
            drive = gain[0] * first[k] + gain[1] * second[k]
            above = (drive - (k + 1) * above) * per_gap
            terms[k] = above
            driven = driven * width + abs(drive) / (k + 1)
        if np.isinf(width):
            start += above
            continue
        if not abs(above) <= LOSS * driven * width:
            # the same from below, beginning with nothing
            terms[0], k, term = 0.0, 0, 1.0
            while k < count or (term > NOTHING and k + 1 < terms.size):
                drive = gain[0] * first[k] + gain[1] * second[k] if k < count else 0.0 * pole
                terms[k + 1] = (drive - gap * terms[k]) / (k + 1)
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
def foresee(pole: Any, gain: Any, case: Any, mode: Any, span: Any) -> Any:
    """Write what a mode that grows is at each knot if it stays bounded; False if it cannot.

    After the last knot a bounded z is the answer a alone; before it, from the right,
    z(0) = a(0) + e^(-p width) [z(width) - a(width)].
    """
    last = case.knots.size - 2
    for q in range(case.rates.size):
        if case.lengths[last, q] > 0 and not (case.rates[q] - pole).real < 0.0:
            return False
    span.known[mode, last + 1] = 0.0
    for i in range(last, -1, -1):
        width = case.knots[i + 1] - case.knots[i]
        start, stop = follow(pole, gain, case, i, width, span)
        span.known[mode, i] = start
        if i < last:
            span.known[mode, i] += np.exp(-pole * width) * (span.known[mode, i + 1] - stop)
    return bool(np.isfinite(abs(span.known[mode, 0])))


@kernel
def magnitude(pole: Any, gain: Any, start: Any, histories: Any, number: Any) -> Any:
    """Return the sum of the sizes of all terms of a residue, within a quarter.

    The integral of u^k e^(-g u) up to the width is nearly that of u^k alone, width^(k+1)/(k+1),
    beside that without end, k!/g^(k+1): one over the sum of one over either.
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
def roundings(pole: Any, first: Any, second: Any) -> Any:
    """Return how many roundings a residue made of two histories with these knots may have."""
    start, total = min(first[0], second[0]), ROUNDINGS
    for knots in (first, second):
        exponent = abs(pole) * abs(knots[knots.size - 1] - start)
        total += min(exponent, DEAD) + np.sqrt(knots.size)
    return total


@kernel
def too_near(poles: Any, ahead: Any) -> Any:
    """Return whether two poles are too near for the modes to be told apart in the time ahead.

    A plant that grows fast all the same keeps its modes: a chain of lags runs forward.
    """
    gap, size, fastest = np.inf, 0.0, -np.inf
    for i in range(poles.size):
        size, fastest = max(size, abs(poles[i])), max(fastest, poles[i].real)
        for j in range(i):
            gap = min(gap, abs(poles[i] - poles[j]))
    close = gap <= SEPARATE * size or gap * ahead <= SEPARATE
    return close and (fastest * ahead <= FORWARD or gap == 0.0)


@kernel
def share(outputs: Any, used: Any, span: Any) -> None:
    """Add a mode's answer to the outputs that have it."""
    for q in range(used):
        lengthen(q, span.sizes[q], span)
        for r in range(outputs.size):
            for k in range(span.sizes[q]):
                span.shares[r, q, k] += outputs[r] * span.answer[q, k]


@kernel
def subtract_wind(case: Any, i: Any, span: Any) -> None:
    """Take the wind off the last output."""
    last = span.shares.shape[0] - 1
    for q in range(case.rates.size):
        lengthen(q, case.lengths[i, q], span)
        for k in range(case.lengths[i, q]):
            span.shares[last, q, k] -= case.forces[i, 1, q, k]


@kernel
def lengthen(q: Any, length: Any, span: Any) -> None:
    """Let the outputs have so many terms at one rate, if they have fewer."""
    for r in range(span.shares.shape[0]):
        for k in range(span.lengths[q], length):
            span.shares[r, q, k] = 0.0
    span.lengths[q] = max(span.lengths[q], length)
