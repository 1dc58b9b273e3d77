"""Both inputs of one case on the knots of both, for `response_cases`."""

from typing import Any, NamedTuple

import numpy as np

from tvclin.kernels.source import kernel

NOTHING = 1e-17
"""A term that is smaller, beside the largest, is left out."""


class Case(NamedTuple):
    """Both inputs of one case on the knots of both.

    `knots` ``(K + 1,)``, the last one at infinity; `rates` ``(Q,)``, all of them different and
    the first one zero; `forces` ``(K, 2, Q, m)``; `lengths` ``(K, Q)``, of their terms that count.
    """

    knots: Any
    rates: Any
    forces: Any
    lengths: Any


@kernel
def merge(first: Any, second: Any, knots: Any) -> Any:
    """Write the knots of both, each once and infinity behind them; return how many there are."""
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
def distinct(own: Any, rates: Any, used: Any) -> Any:
    """Write those rates that are new behind the first `used`; return how many there are then."""
    for q in range(own.size):
        if place_of(own[q], rates, used) == used:
            rates[used] = own[q]
            used += 1
    return used


@kernel
def place_of(rate: Any, rates: Any, used: Any) -> Any:
    """Return where a rate is among the first `used`; `used` where it is not."""
    at = 0
    while at < used and rates[at] != rate:
        at += 1
    return at


@kernel
def put(case: Any, forces: Any, knots: Any, coefficients: Any, rates: Any) -> None:
    """Write one input on the common knots, to its `forces` ``(K, Q, m)`` of a case."""
    piece = -1
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
            terms = forces[i, place_of(rates[q], case.rates, case.rates.size)]
            for k in range(coefficients.shape[2]):
                terms[k] += coefficients[piece, q, k]
        for q in range(case.rates.size if u > 0.0 else 0):
            move(forces[i, q], case.rates[q], u)


@kernel
def move(terms: Any, rate: Any, u: Any) -> None:
    """Let the terms of c(v) e^(rate v) begin at v = u."""
    count = needed(terms, np.inf)
    for low in range(count):
        for k in range(count - 2, low - 1, -1):
            terms[k] += u * terms[k + 1]
    if rate != 0.0:
        growth = np.exp(rate * u)
        for k in range(count):
            terms[k] *= growth


@kernel
def measure(case: Any) -> None:
    """Write how many terms count in each span."""
    for i in range(case.knots.size - 1):
        width = case.knots[i + 1] - case.knots[i]
        for q in range(case.rates.size):
            first, second = case.forces[i, 0, q], case.forces[i, 1, q]
            case.lengths[i, q] = max(needed(first, width), needed(second, width))


@kernel
def needed(terms: Any, width: Any) -> Any:
    """Return how many terms count beside the largest, c u^k being largest at u = width."""
    power, most, count = 1.0, 0.0, 0
    for k in range(terms.size):
        if terms[k] != 0.0:
            size = abs(terms[k]) * power
            most = max(most, size)
            if np.isinf(width) or size > NOTHING * most:
                count = k + 1
        power = power if np.isinf(width) else power * width
    return count
