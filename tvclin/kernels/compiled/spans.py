"""One case taken apart between its knots, for the compiled responses.

Between two knots every output is a sum of three kinds of terms in the local time u:

    w e^(p u)    the modes that are fast there, |p| width > 1;
    a(u) e^(r u) what inputs with a fast rate r force;
    P(u)         everything slow, as one power series that has converged to rounding.

Nothing is divided by a small pole or a small difference of rates, so nothing cancels there.
"""

from typing import Any, NamedTuple

import numpy as np

from tvclin.kernels.compiled.compiler import compiled, lean, merged
from tvclin.kernels.compiled.forces import filled

SLOW = 1.0
"""An exponent moves slowly where it times the width is no larger."""
_APART = 0.25
"""The least difference of a fast exponent and another one, over the width."""
_NOTHING = 1e-17
"""A term of a power series that is smaller, beside the first, ends it."""
_MOST = 24
"""No series has more terms."""


class System(NamedTuple):
    """One plant as a sum of modes: poles ``(N,)``, gains ``(N, 2)``, outputs ``(N, R)``.

    The wind is taken off the last output if `less_wind`.
    """

    poles: Any
    gains: Any
    outputs: Any
    less_wind: Any


class Span(NamedTuple):
    """What one span between knots is made of, and what it is made from.

    `state` (the modes at its start), `start` and `end` (amplitudes of fast modes, as seen from
    either end), `lift` (of modes that grow for ever), `excess` (their residues), all ``(N,)``;
    `live` ``(N + r,)``, the exponentials that are there at all;
    `future` ``(N, K + 1)``; `forced` ``(R, r, m)``; `powers` ``(R, most)``; the rest is scratch.
    """

    state: Any
    start: Any
    end: Any
    lift: Any
    excess: Any
    backward: Any
    live: Any
    future: Any
    forced: Any
    powers: Any
    answer: Any
    source: Any
    particular: Any
    steady: Any
    weights: Any
    real_weights: Any


@compiled
def room_for_span(like, modes, outputs, knots, rates, degree):  # type: ignore[no-untyped-def]
    """Return a span with room for cases of this size, real or complex like `like`."""
    kind, most = like.dtype, 4 * ((degree + _MOST + 4) // 4)
    return Span(
        np.zeros(modes, kind),
        np.zeros(modes, kind),
        np.zeros(modes, kind),
        np.zeros(modes, kind),
        np.zeros(modes, kind),
        np.zeros(modes, np.bool_),
        np.zeros(modes + rates, np.bool_),
        np.zeros((modes, knots + 1), kind),
        np.zeros((outputs, rates, degree), kind),
        np.zeros((outputs, most)),
        np.zeros(most, kind),
        np.zeros(most, kind),
        np.zeros(degree, kind),
        np.zeros(degree, kind),
        np.zeros(degree, kind),
        np.zeros(degree),
    )


@merged
def lay_out(system, forces, i, reach, span):  # type: ignore[no-untyped-def]
    """Write what the outputs are made of in span `i`, as far as `reach`; and the next state.

    Returns how many powers there are; 0 where a fast exponent is too near to another one.
    """
    length = _length(system, forces, reach, span.answer.size)
    _clear(forces, length, span)
    for mode in range(system.poles.size):
        if forces.own[1] == 0 and abs(system.poles[mode]) * reach > SLOW:
            _follow(system, mode, forces, i, span)
        elif not _answer(system, mode, forces, i, reach, length, span):
            return 0
    if system.less_wind:
        _subtract_wind(forces, i, reach, length, span)
    for q in range(forces.rates.size):
        span.live[system.poles.size + q] = False
        for r in range(span.forced.shape[0] if forces.rates[q] != 0.0 else 0):
            if filled(span.forced[r, q]):
                span.live[system.poles.size + q] = True
    return length


@merged
def _clear(forces, length, span):  # type: ignore[no-untyped-def]
    for r in range(span.powers.shape[0]):
        for k in range(4 * ((length + 3) // 4)):
            span.powers[r, k] = 0.0
        for q in range(forces.rates.size if forces.own[1] else 0):
            for k in range(span.forced.shape[2]):
                span.forced[r, q, k] = 0.0


@merged
def _length(system, forces, reach, most):  # type: ignore[no-untyped-def]
    """Return how many powers of the time bring every slow exponential to rounding.

    Where all modes are fast, the inputs' own powers are enough.
    """
    degree, slowest = forces.terms.shape[2], -1.0
    for k in range(system.poles.size):
        size = abs(system.poles[k]) * reach
        slowest = max(slowest, size if size <= SLOW else -1.0)
    for q in range(forces.rates.size):
        size = abs(forces.rates[q]) * reach
        slowest = max(slowest, size if 0.0 < size <= SLOW else -1.0)
    if slowest < 0.0:
        return degree
    term, more = 1.0, 1
    while slowest > 0.0 and term > _NOTHING and degree + more < most:
        term *= slowest / more
        more += 1
    return degree + more


@merged
def _subtract_wind(forces, i, reach, length, span):  # type: ignore[no-untyped-def]
    last = span.powers.shape[0] - 1
    for q in range(forces.own[0], forces.rates.size):
        terms = forces.terms[i, q]
        if abs(forces.rates[q]) * reach > SLOW:
            for k in range(terms.size):
                span.forced[last, q, k] -= terms[k]
        elif forces.rates[q] == 0.0:
            for k in range(terms.size):
                span.powers[last, k] -= np.real(terms[k])
        else:
            for k in range(length):
                span.source[k] = 0.0
            _series(span.source, terms, forces.rates[q], 1.0, length)
            for k in range(length):
                span.powers[last, k] -= np.real(span.source[k])


@lean
def _series(target, terms, rate, scale, length):  # type: ignore[no-untyped-def]
    """Add the power series of scale sum_k terms[k] u^k e^(rate u)."""
    for k in range(terms.size):
        term = terms[k] * scale
        for n in range(k, length):
            target[n] += term
            if rate == 0.0:
                break
            term *= rate / (n - k + 1)


@merged
def _follow(system, mode, forces, i, span):  # type: ignore[no-untyped-def]
    """As `_answer`, for a fast mode that polynomials drive: it follows them by a polynomial."""
    pole, width = system.poles[mode], forces.knots[i + 1] - forces.knots[i]
    above, ending = 0.0 * pole, 0.0 * pole
    for k in range(forces.terms.shape[2] - 1, -1, -1):
        drive = 0.0 * pole
        for q in range(forces.rates.size):
            drive += system.gains[mode, 0 if q < forces.own[0] else 1] * forces.terms[i, q, k]
        above = ((k + 1) * above - drive) / pole
        ending = ending * width + above
        for r in range(span.powers.shape[0]):
            span.powers[r, k] += np.real(system.outputs[mode, r] * above)
    _fast(pole, mode, i, width, span.state[mode] - above, ending, span)
    _note_live(mode, span)


@merged
def _note_live(mode, span):  # type: ignore[no-untyped-def]
    found = span.start[mode] != 0.0 or span.end[mode] != 0.0
    span.live[mode] = found or span.lift[mode] != 0.0


@merged
def _answer(system, mode, forces, i, reach, length, span):  # type: ignore[no-untyped-def]
    """What one mode adds to the outputs; its state moves on to the next knot."""
    pole, width = system.poles[mode], forces.knots[i + 1] - forces.knots[i]
    fast = abs(pole) * reach > SLOW
    for n in range(length):
        span.source[n], span.answer[n] = 0.0, 0.0
    good, value, ending = _driven(system, mode, forces, i, reach, length, fast, span)
    if fast:
        _particular(span.steady, 1.0, -pole, span.particular)
        for k in range(span.steady.size):
            span.answer[k] += span.particular[k]
        value -= span.particular[0]
        if not np.isinf(width):
            ending += _polynomial(span.particular, width)
        _fast(pole, mode, i, width, value, ending, span)
    else:
        for k in range(span.steady.size):
            span.source[k] += span.steady[k]
        _slow(pole, mode, width, value, ending, length, span)
    _note_live(mode, span)
    for r in range(span.powers.shape[0]):
        for k in range(length):
            span.powers[r, k] += np.real(system.outputs[mode, r] * span.answer[k])
    return good


@merged
def _driven(system, mode, forces, i, reach, length, fast, span):  # type: ignore[no-untyped-def]
    """Sum what drives the mode at rate zero; answer the other rates.

    Returns whether no exponents were too near, what is left of the state at the start for the
    mode's own exponential, and what the inputs' exponentials are at the end.
    """
    pole, width = system.poles[mode], forces.knots[i + 1] - forces.knots[i]
    value, ending = span.state[mode], 0.0 * pole
    for k in range(span.steady.size):
        span.steady[k] = 0.0
    for q in range(forces.rates.size):
        terms, rate = forces.terms[i, q], forces.rates[q]
        gain = system.gains[mode, 0 if q < forces.own[0] else 1]
        quick = abs(rate) * reach > SLOW
        if rate == 0.0:
            for k in range(span.steady.size):
                span.steady[k] += gain * terms[k]
        elif not filled(terms):
            continue
        elif not fast and not quick:
            _series(span.source, terms, rate, gain, length)
        else:
            if abs(rate - pole) * reach < _APART:
                return False, value, ending
            _particular(terms, gain, rate - pole, span.particular)
            value -= span.particular[0]
            if not np.isinf(width):
                ending += _polynomial(span.particular, width) * np.exp(rate * width)
            if quick:
                _force(system, mode, q, span)
            else:
                _series(span.answer, span.particular, rate, 1.0, length)
    return True, value, ending


@merged
def _force(system, mode, q, span):  # type: ignore[no-untyped-def]
    for r in range(span.forced.shape[0]):
        for k in range(span.particular.size):
            span.forced[r, q, k] += system.outputs[mode, r] * span.particular[k]


@merged
def _fast(pole, mode, i, width, value, ending, span):  # type: ignore[no-untyped-def]
    span.start[mode], span.end[mode], span.lift[mode] = 0.0, 0.0, 0.0
    if span.backward[mode]:
        span.lift[mode] = span.excess[mode]
        if not np.isinf(width):
            span.end[mode] = -span.future[mode, i + 1] - ending
    else:
        span.start[mode] = value
        if not np.isinf(width):
            span.state[mode] = value * np.exp(pole * width) + ending


@merged
def _slow(pole, mode, width, value, ending, length, span):  # type: ignore[no-untyped-def]
    span.start[mode], span.end[mode], span.lift[mode] = 0.0, 0.0, 0.0
    answer = span.answer
    answer[0] += value
    for n in range(length - 1):
        answer[n + 1] = (pole * answer[n] + span.source[n]) / (n + 1)
    if not np.isinf(width):
        span.state[mode] = _polynomial(answer[:length], width) + ending


@lean
def _particular(terms, gain, gap, result):  # type: ignore[no-untyped-def]
    """The polynomial a with a' + gap a = gain terms."""
    above = 0.0 * gap
    for k in range(terms.size - 1, -1, -1):
        above = (gain * terms[k] - (k + 1) * above) / gap
        result[k] = above


@lean
def _polynomial(terms, u):  # type: ignore[no-untyped-def]
    total = terms[terms.size - 1]
    for k in range(terms.size - 2, -1, -1):
        total = total * u + terms[k]
    return total
