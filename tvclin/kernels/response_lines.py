"""The outputs of one case at the times of one span, for `response_cases`.

An output is a sum of polynomials, each times the exponential of one rate of the inputs, and of
numbers, each times the exponential of one pole. On an even grid these exponentials are a table,
so that a time costs a few products.
"""

from typing import Any, NamedTuple

import numpy as np

from tvclin.kernels.source import kernel

BLOCK, STRIDE = 512, 32
"""Times in one block, at most. In a table an exponential is a product of two: one for whole
strides, one for the rest.
"""
UNEVEN = 1e-14
"""A grid is even where its times, times the fastest exponent, are off by no more than this."""
LARGE = 300.0
"""No exponential grows by more than e^300 in a block."""


class Table(NamedTuple):
    """Exponentials ``(N + Q, BLOCK)`` of the poles, and behind them of the rates; and scratch.

    They count from the first time of a block. The row of the first rate, zero, is not used.
    """

    real: Any
    imaginary: Any
    local: Any
    line: Any
    terms: Any


@kernel
def grid(times: Any) -> Any:
    """Return the step of the times, and the most by which one of them is off an even grid."""
    last = times.size - 1
    if last < 1:
        return 0.0, np.inf
    step, off = (times[last] - times[0]) / last, 0.0
    for j in range(last + 1):
        off = max(off, abs(times[j] - (times[0] + j * step)))
    return step, off


@kernel
def exponent_at(e: Any, poles: Any, rates: Any) -> Any:
    """Return a pole, or behind all poles a rate of the inputs."""
    return poles[e] if e < poles.size else rates[e - poles.size]


@kernel
def exponential(exponent: Any, u: Any) -> Any:
    """Return the real and the imaginary part of e^(exponent u)."""
    real, angle = np.exp(exponent.real * u), exponent.imag * u
    return (real, 0.0) if angle == 0.0 else (real * np.cos(angle), real * np.sin(angle))


@kernel
def fill_evenly(poles: Any, rates: Any, count: Any, step: Any, off: Any, table: Any) -> Any:
    """Write all exponentials on the steps of an even grid; False if the grid is not even enough."""
    size = min(count, BLOCK)
    for e in range(poles.size + rates.size):
        exponent = exponent_at(e, poles, rates)
        if e == poles.size:
            continue  # the rate of zero
        if abs(exponent) * off > UNEVEN or abs(exponent.real) * step * size > LARGE:
            return False
        real, imaginary = table.real[e, :size], table.imaginary[e, :size]
        for j in range(min(STRIDE, size)):
            real[j], imaginary[j] = exponential(exponent, j * step)
        for j in range(STRIDE, size, STRIDE):
            a, b = exponential(exponent, j * step)
            if exponent.imag == 0.0:
                scale(a, real[:STRIDE], real[j:])
            else:
                turn(a, b, real[:STRIDE], imaginary[:STRIDE], real[j:], imaginary[j:])
    return True


@kernel
def scale(a: Any, row: Any, new: Any) -> None:
    """Multiply a row by a number."""
    for j in range(min(row.size, new.size)):
        new[j] = a * row[j]


@kernel
def turn(a: Any, b: Any, real: Any, imaginary: Any, new_real: Any, new_imaginary: Any) -> None:
    """Multiply a row of complex numbers by one of them."""
    for j in range(min(real.size, new_real.size)):
        new_real[j] = a * real[j] - b * imaginary[j]
        new_imaginary[j] = a * imaginary[j] + b * real[j]


@kernel
def block_end(times: Any, first: Any, last: Any, poles: Any, rates: Any) -> Any:
    """Return where a block of times ends: after so many, or before an exponential is too large."""
    fastest = 0.0
    for e in range(poles.size + rates.size):
        fastest = max(fastest, abs((exponent_at(e, poles, rates)).real))
    end = min(last, first + BLOCK)
    while fastest * (times[end - 1] - times[first]) > LARGE:
        end -= (end - first) // 2
    return end


@kernel
def fill_unevenly(poles: Any, rates: Any, local: Any, table: Any) -> None:
    """Write all exponentials at the times of one block."""
    for e in range(poles.size + rates.size):
        exponent = exponent_at(e, poles, rates)
        for j in range(local.size if e != poles.size else 0):
            table.real[e, j], table.imaginary[e, j] = exponential(exponent, local[j] - local[0])


@kernel
def block(
    times: Any,
    plant: Any,
    case: Any,
    i: Any,
    even: Any,
    span: Any,
    table: Any,
    out: Any,
    first: Any,
) -> None:
    """Write the outputs at some times of span `i`, behind the `first` that are there."""
    poles, rates, local = plant.poles, case.rates, table.local[: times.size]
    for j in range(times.size):
        local[j] = times[j] - case.knots[i]
    if not even:
        fill_unevenly(poles, rates, local, table)
    for r in range(out.shape[0]):
        line, values = out[r, first : first + times.size], table.line[: times.size]
        polynomial(line, local, span.shares[r, 0], span.lengths[0], 1.0, 0.0, table)
        for q in range(1, rates.size):
            terms, count, e = span.shares[r, q], span.lengths[q], poles.size + q
            a, b = exponential(rates[q], local[0])
            if count > 0:
                polynomial(values, local, terms, count, a, b, table)
                add_product(line, values, table.real[e])
            if count > 0 and rates[q].imag != 0.0:
                # Re(c e) = Re c Re e + Re(j c) Im e
                polynomial(values, local, terms, count, -b, a, table)
                add_product(line, values, table.imaginary[e])
    add_modes(plant, case, i, span, table, out, first, local)


@kernel
def add_modes(
    plant: Any, case: Any, i: Any, span: Any, table: Any, out: Any, first: Any, local: Any
) -> None:
    """Add the exponentials of the poles."""
    width, since = case.knots[i + 1] - case.knots[i], case.knots[i] - case.knots[0]
    for m in range(plant.poles.size):
        pole = plant.poles[m]
        real, imaginary = amplitude(pole, m, local[0], width, since, span)
        for r in range(out.shape[0]):
            line, output = out[r, first : first + local.size], plant.outputs[m, r]
            # Re(output amplitude e), in which nothing times infinity is nothing
            if real != 0.0 and output.real != 0.0:
                add(line, output.real * real, table.real[m])
            if pole.imag != 0.0:
                add(line, -output.imag * imaginary, table.real[m])
                turned = output.real * imaginary + output.imag * real
                add(line, -turned, table.imaginary[m])


@kernel
def amplitude(pole: Any, mode: Any, u: Any, width: Any, since: Any, span: Any) -> Any:
    """Return how much of e^(pole (t - u)) there is from u on, real and imaginary part.

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


@kernel
def polynomial(line: Any, u: Any, terms: Any, count: Any, a: Any, b: Any, table: Any) -> None:
    """Write the real part of (a + j b) times a polynomial, four terms at a time."""
    c = table.terms
    for k in range(4 * (max(count + 3, 4) // 4)):
        c[k] = a * terms[k].real - b * terms[k].imag if k < count else 0.0
    top = 4 * (max(count - 1, 0) // 4)
    begin_with_four(line, u, c[top], c[top + 1], c[top + 2], c[top + 3])
    for low in range(top - 4, -1, -4):
        raise_by_four(line, u, c[low], c[low + 1], c[low + 2], c[low + 3])


@kernel
def begin_with_four(line: Any, u: Any, c0: Any, c1: Any, c2: Any, c3: Any) -> None:
    """Write the highest four terms by Horner's rule."""
    for j in range(line.size):
        line[j] = ((c3 * u[j] + c2) * u[j] + c1) * u[j] + c0


@kernel
def raise_by_four(line: Any, u: Any, c0: Any, c1: Any, c2: Any, c3: Any) -> None:
    """Go on with Horner's rule, by four terms."""
    for j in range(line.size):
        line[j] = (((line[j] * u[j] + c3) * u[j] + c2) * u[j] + c1) * u[j] + c0


@kernel
def add_product(line: Any, first: Any, second: Any) -> None:
    """Add the product of two rows."""
    for j in range(line.size):
        line[j] += first[j] * second[j]


@kernel
def add(line: Any, factor: Any, row: Any) -> None:
    """Add a row times a factor."""
    for j in range(line.size):
        line[j] += factor * row[j]
