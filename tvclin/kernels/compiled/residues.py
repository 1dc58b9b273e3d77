"""Compiled twin of `kernels.residues`, for one mode, with the discounted future at each knot."""

import numpy as np

from tvclin.kernels.compiled.compiler import lean, merged
from tvclin.kernels.compiled.forces import filled

_EPS = float(np.finfo(float).eps)
_ROUNDINGS = 32.0
_DEAD = 750.0
_SMALL = 1.0
"""Weights of exponents no larger than this come from a power series."""
_NOTHING = 1e-17
_MOST = 24


@merged
def residue(system, mode, forces, count, span, roundings):  # type: ignore[no-untyped-def]
    """Write the discounted future at every knot and the residue; False where it diverges.

    A residue that is zero within the rounding of its own sum is zero.
    """
    pole, future = system.poles[mode], span.future[mode]
    future[count] = 0.0
    size = 0.0
    for i in range(count - 1, -1, -1):
        width = forces.knots[i + 1] - forces.knots[i]
        total, own, known = 0.0 * pole, 0.0, 0.0 * pole
        for q in range(forces.rates.size):
            terms, gap = forces.terms[i, q], pole - forces.rates[q]
            if not filled(terms):
                continue
            if np.isinf(width) and not np.real(gap) > 0.0:
                return False
            gain = system.gains[mode, 0 if q < forces.own[0] else 1]
            if gap != known:
                _weights(gap, width, span.weights)
                if np.iscomplexobj(span.weights):
                    _weights(np.real(gap), width, span.real_weights)
                else:
                    for k in range(terms.size):
                        span.real_weights[k] = np.real(span.weights[k])
                known = gap
            for k in range(terms.size):
                total += gain * terms[k] * span.weights[k]
                own += abs(gain) * forces.sizes[i, q, k] * span.real_weights[k]
        if np.isinf(width):
            future[i], size = total, own
        else:
            decay = np.exp(-pole * width)
            future[i] = total + decay * future[i + 1]
            size = own + abs(decay) * size
    small = abs(future[0]) <= _EPS * roundings * size
    span.excess[mode] = 0.0 if small else future[0]
    return bool(np.isfinite(abs(future[0])))


@lean
def too_near(poles, span, near):  # type: ignore[no-untyped-def]
    """Whether two poles are too near for the modes to be told apart, as in the other twin."""
    separate, forward = near
    gap, size, fastest = np.inf, 0.0, -np.inf
    for i in range(poles.size):
        size, fastest = max(size, abs(poles[i])), max(fastest, np.real(poles[i]))
        for j in range(i):
            gap = min(gap, abs(poles[i] - poles[j]))
    close = gap <= separate * size or gap * span <= separate
    return close and (fastest * span <= forward or gap == 0.0)


@lean
def all_roundings(pole, start, first, second):  # type: ignore[no-untyped-def]
    """Return the roundings of a residue made of two histories with these knots."""
    both = _rounding_steps(pole, start, first) + _rounding_steps(pole, start, second)
    return _ROUNDINGS + both


@lean
def _rounding_steps(pole, start, knots):  # type: ignore[no-untyped-def]
    """Return how many roundings a transform of a history with these knots may have."""
    return min(abs(pole) * abs(knots[-1] - start), _DEAD) + np.sqrt(knots.size)


@lean
def _weights(s, width, weights):  # type: ignore[no-untyped-def]
    """The integrals of u^k e^(-s u) from 0 to the width."""
    z = s * width
    if np.isinf(width):
        weights[0] = 1.0 / s
        for k in range(1, weights.size):
            weights[k] = k * weights[k - 1] / s
    elif abs(z) > _SMALL:
        decay, power = np.exp(-z), 1.0
        weights[0] = (1.0 - decay) / s
        for k in range(1, weights.size):
            power *= width
            weights[k] = (k * weights[k - 1] - power * decay) / s
    else:
        power = 1.0
        for k in range(weights.size):
            power *= width
            total, term = 0.0 * s, 1.0 + 0.0 * s
            for j in range(_MOST):
                total += term / (k + j + 1)
                term *= -z / (j + 1)
                if abs(term) < _NOTHING:
                    break
            weights[k] = total * power
