"""Both inputs of a case on the knots of both, and their values, for the compiled twins."""

from typing import Any, NamedTuple

import numpy as np

from tvclin.kernels.compiled.compiler import compiled, lean, merged, unfused


class Forces(NamedTuple):
    """Both inputs on common knots.

    Knots ``(K + 1,)``, the last one at infinity; coefficients ``(K, r, m)`` and the sizes of
    their terms; rates ``(r,)``, of which the first `own[0]` belong to the deflection, and
    `own[1]` are not zero.
    """

    knots: Any
    terms: Any
    sizes: Any
    rates: Any
    own: Any


@compiled
def room_for_forces(like, knots, rates, degree):  # type: ignore[no-untyped-def]
    """Return room for inputs of this size, real or complex like `like`."""
    kind = like.dtype
    return Forces(
        np.empty(knots + 1),
        np.empty((knots, rates, degree), kind),
        np.empty((knots, rates, degree)),
        np.empty(rates, kind),
        np.zeros(2, np.int64),
    )


@merged
def merge(first, second, knots):  # type: ignore[no-untyped-def]
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


@merged
def put_on_knots(forces, count, before, knots, coefficients, rates):  # type: ignore[no-untyped-def]
    """Write one history behind the `before` rates that are there, on the common knots."""
    degree = coefficients.shape[2]
    piece = -1
    forces.own[1] = forces.own[1] if before else 0
    for q in range(rates.size):
        forces.rates[before + q] = rates[q]
        forces.own[1] += rates[q] != 0.0
    for i in range(count):
        while piece + 1 < knots.size and knots[piece + 1] <= forces.knots[i]:
            piece += 1
        for q in range(rates.size):
            terms, sizes = forces.terms[i, before + q], forces.sizes[i, before + q]
            for k in range(terms.size):
                terms[k], sizes[k] = 0.0, 0.0
            if piece < 0:
                continue
            u = forces.knots[i] - knots[piece]
            for k in range(degree):
                terms[k] = coefficients[piece, q, k]
                sizes[k] = abs(coefficients[piece, q, k])
            if u > 0.0:
                growth = _growth(rates[q], u)
                _move(terms, u, growth)
                _move(sizes, u, abs(growth))


@lean
def _growth(rate, u):  # type: ignore[no-untyped-def]
    return np.exp(rate * u) if rate != 0.0 else 1.0 + rate


@lean
def _move(terms, u, growth):  # type: ignore[no-untyped-def]
    for low in range(terms.size):
        for k in range(terms.size - 2, low - 1, -1):
            terms[k] += u * terms[k + 1]
    for k in range(terms.size):
        terms[k] *= growth


@lean
def filled(terms):  # type: ignore[no-untyped-def]
    """Whether there is anything but zeros."""
    found = False
    for k in range(terms.size):
        found = found or terms[k] != 0.0
    return found


@compiled
def values(times, first, second, out):  # type: ignore[no-untyped-def]
    """Write the values of two histories made of polynomials, ``(2, n)``; False if they are not.

    To the last bit those of `kernels.pieces.value`.
    """
    for row, history in enumerate((first, second)):
        knots, coefficients, rates = history[0][0], history[1][0], history[2][0]
        for q in range(rates.size):
            if rates[q] != 0.0:
                return False
        _polynomials(times, knots, coefficients, out[row])
    return True


@lean
def _polynomials(times, knots, coefficients, out):  # type: ignore[no-untyped-def]
    first = 0
    while first < times.size:
        piece = -1
        while piece + 1 < knots.size and knots[piece + 1] <= times[first]:
            piece += 1
        low = knots[piece] if piece >= 0 else -np.inf
        high = knots[piece + 1] if piece + 1 < knots.size else np.inf
        last = first + 1
        while last < times.size and low <= times[last] < high:
            last += 1
        for j in range(first, last):
            out[j] = 0.0
        for q in range(coefficients.shape[1] if piece >= 0 else 0):
            _add_polynomial(times[first:last], low, coefficients[piece, q], out[first:last])
        first = last


@unfused
def _add_polynomial(times, start, terms, out):  # type: ignore[no-untyped-def]
    if terms.size == 2:
        for j in range(times.size):
            out[j] += terms[1] * (times[j] - start) + terms[0]
        return
    for j in range(times.size):
        total = terms[terms.size - 1]
        for k in range(terms.size - 2, -1, -1):
            total = total * (times[j] - start) + terms[k]
        out[j] += total
