"""The wind of a flight: its polynomial about now, and what begins within a step."""

from tvclin.base.arrays import FloatArray
from tvclin.kernels.flight_arrays import Flights
from tvclin.kernels.source import inlined

_TERMS, _FAR = 24, 2.0
"""Of the series of a wind that begins within a step, and how far it goes: 2^24/24! is 3e-17."""


@inlined
def about(f: Flights, i: int, now: float) -> None:
    """Write the polynomial of the wind about a time in its piece."""
    here, w, j = f.now.here[i], f.cases.wind[i], f.now.piece[i]
    polynomial(f.winds.pieces, f.winds.knots, w, j, now, here)


@inlined
def polynomial(
    pieces: FloatArray, knots: FloatArray, w: int, j: int, now: float, here: FloatArray
) -> None:
    """Write the coefficients of a piece of a wind about a time; zeros before the first."""
    terms = here.size
    if j < 0:
        for r in range(terms):
            here[r] = 0.0
        return
    for r in range(terms):
        here[r] = pieces[w, j, r]
    shifted(here, now - knots[w, j])


@inlined
def shifted(c: FloatArray, u: float) -> None:
    """Make of a polynomial the same about a point u later, by Horner's scheme again and again."""
    for low in range(c.size - 1):
        for r in range(c.size - 2, low - 1, -1):
            c[r] += c[r + 1] * u


@inlined
def blown(f: Flights, i: int, begin: float, end: float) -> None:
    """Add what the knots of the wind within a part change, and find the piece at its end."""
    knots = f.winds.knots[f.cases.wind[i]]
    while f.now.piece[i] + 1 < knots.size and knots[f.now.piece[i] + 1] <= end:
        knot = knots[f.now.piece[i] + 1]
        if begin < knot < end:
            answered(f, i, knot, end - knot)
        f.now.piece[i] += 1


@inlined
def answered(f: Flights, i: int, knot: float, time: float) -> None:
    """Add the answer to what the next piece of wind is more than this, by Taylor series.

    The terms about the start of a stretch t are x_(k+1) = (A x_k t + gust w_k t^(k+1))/(k + 1),
    x_0 being what came of the stretch before.
    """
    p, n, w = f.cases.vehicle[i], f.vehicles.A.shape[1], f.cases.wind[i]
    more, j = f.now.here[i], f.now.piece[i] + 1
    old, term, found = f.now.series[i, 0], f.now.series[i, 1], f.now.series[i, 2]
    polynomial(f.winds.pieces, f.winds.knots, w, j - 1, knot, more)
    for r in range(more.size):
        more[r] = f.winds.pieces[w, j, r] - more[r]
    for r in range(n):
        found[r] = 0.0
    stretches = 1 + int(f.vehicles.fastest[p] * time / _FAR)
    for stretch in range(stretches):
        if stretch > 0:
            shifted(more, time / stretches)
        for r in range(n):
            term[r] = found[r]
        added(f.vehicles.A[p], f.vehicles.gust[p], more, time / stretches, old, term, found)
    for r in range(n):
        f.now.y[i, r] += found[r]


@inlined
def added(
    A: FloatArray,
    gust: FloatArray,
    more: FloatArray,
    length: float,
    old: FloatArray,
    term: FloatArray,
    found: FloatArray,
) -> None:
    """Add the terms of a stretch that follow the first."""
    n, power = found.size, length
    for k in range(_TERMS):
        pushed = power * more[k] if k < more.size else 0.0
        for r in range(n):
            old[r] = term[r]
        for r in range(n):
            total = 0.0
            for q in range(n):
                total += A[r, q] * old[q]
            term[r] = (length * total + gust[r] * pushed) / (k + 1)
            found[r] += term[r]
        power *= length
