"""Eqs (12) and (18), element by element; for the formulas see `kernels.limits`.

Eq (12) is written without a branch and without a call, so that the compiler computes several
elements at once. It goes through a block in several short loops, because the processor works
ahead over the elements of a short loop, while in a long one it waits for each result in turn.
"""

from math import exp, expm1, log, log1p

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.compiled.compiler import compiled, inlined, lean
from tvclin.kernels.compiled.exponentials import (
    exponential_less_one,
    small_exponential_less_one,
)

FloatArray = NDArray[np.float64]

_BLOCK = 256
"""Elements whose intermediate results stay in the nearest cache."""
_EPS = 2.0**-52
_DIED = 43.0
"""e^-43 is nothing beside one."""
_SHORT = 0.6
_MIDDLE = 1.72
_LOG_MIDDLE = log(_MIDDLE)
_NEVER = 1e-150
"""Stands for 1 - K where K is one."""


@compiled
def triangular(p: FloatArray, K: FloatArray, y: FloatArray) -> None:
    """Write y of eq (12), which is (1 - e^(-s))/(p (1 - K)) with s + c (1 - e^(-s)) = L."""
    work = np.empty((3, _BLOCK))
    for first in range(0, p.size, _BLOCK):
        last = min(first + _BLOCK, p.size)
        L, c, s = work[0, : last - first], work[1, : last - first], work[2, : last - first]
        _begin(p[first:last], K[first:last], L, c)
        _estimate(L, c, s)
        _improve(L, c, s)
        _finish(p[first:last], K[first:last], L, c, s, y[first:last])


@lean
def _begin(p: FloatArray, K: FloatArray, L: FloatArray, c: FloatArray) -> None:
    for i in range(p.size):
        L[i] = _minus_log_R(p[i])
        c[i] = K[i] / _rest(K[i])


@lean
def _estimate(L: FloatArray, c: FloatArray, s: FloatArray) -> None:
    for i in range(L.size):
        s[i] = _start(L[i], c[i])


@lean
def _improve(L: FloatArray, c: FloatArray, s: FloatArray) -> None:
    for i in range(L.size):
        s[i] += _step(L[i], c[i], s[i], _expm1(s[i]))


@lean
def _finish(
    p: FloatArray, K: FloatArray, L: FloatArray, c: FloatArray, s: FloatArray, y: FloatArray
) -> None:
    for i in range(p.size):
        y[i] = _last(L[i], c[i], s[i]) / (p[i] * _rest(K[i]))


@inlined
def _limit(p: float, K: float) -> float:
    """Return y of eq (12) for one element."""
    L, c = _minus_log_R(p), K / _rest(K)
    s = _start(L, c)
    s += _step(L, c, s, _expm1(s))
    return _last(L, c, s) / (p * _rest(K))


@inlined
def _rest(K: float) -> float:
    return _NEVER if 1.0 - K < _NEVER else 1.0 - K


@inlined
def _start(L: float, c: float) -> float:
    """A solution within a fifth: 1 - e^(-s) as s/(1 + a s), with a better a the second time."""
    s = _hyperbola(L, c, 0.5)
    return _hyperbola(L, c, 1.0 - (1.0 + s / 12.0) / (2.0 + s * (0.5 + s / 12.0)))


@inlined
def _hyperbola(L: float, c: float, a: float) -> float:
    """The solution if 1 - e^(-s) were s/(1 + a s)."""
    half = 1.0 + c - a * L
    root = np.sqrt(half * half + 4.0 * a * L)
    positive = half > 0.0
    return (2.0 * L if positive else root - half) / (root + half if positive else 2.0 * a)


@inlined
def _step(L: float, c: float, s: float, e: float) -> float:
    """Halley's step from s, where e is e^(-s) - 1."""
    excess, slope = (s - c * e) - L, 1.0 + c * (1.0 + e)
    return -excess * slope / (slope * slope + 0.5 * excess * (slope - 1.0))


@inlined
def _last(L: float, c: float, s: float) -> float:
    """1 - e^(-s) after Halley's step and one of Newton's, on the series of that small step."""
    e = _expm1(s)
    excess, bend = (s - c * e) - L, c * (1.0 + e)
    t = -_step(L, c, s, e)
    change = small_exponential_less_one(t)
    t += (excess - t - bend * change) / (1.0 + bend + bend * change)
    return -(e + (1.0 + e) * small_exponential_less_one(t))


@inlined
def _minus_log_R(p: float) -> float:
    """L, by the series of atanh: of a short wind as -ln(1 - q^2), otherwise as p - ln(1 + q)."""
    q = -_expm1(p)
    short = p < _SHORT
    w = (q * q if short else (1.0 + q) - _MIDDLE) / (2.0 - q * q if short else (1.0 + q) + _MIDDLE)
    x = w * w
    near = (1.0 / 3.0 + x / 5.0) + x * x * (1.0 / 7.0 + x / 9.0)
    far = (1.0 / 11.0 + x / 13.0) + x * x * (1.0 / 15.0 + x / 17.0)
    atanh = 2.0 * (w + w * (x * (near + (x * x) * (x * x) * far)))
    return atanh if short else (p - _LOG_MIDDLE) - atanh


@inlined
def _expm1(s: float) -> float:
    """e^(-s) - 1 for s >= 0."""
    return exponential_less_one(-_DIED if s > _DIED else -s)


@compiled
def triangular_with_drift(
    p: FloatArray,
    K: FloatArray,
    kappa: FloatArray,
    K1: FloatArray,
    rho: FloatArray,
    z: FloatArray,
    found: NDArray[np.bool_],
) -> None:
    """Write z of eq (18), and whether it was found."""
    for i in range(p.size):
        z[i], found[i] = _with_drift(p[i], K[i], kappa[i], K1[i], rho[i])


@compiled
def _with_drift(p: float, K: float, kappa: float, K1: float, rho: float) -> tuple[float, bool]:
    L = -log1p(-(expm1(-p) ** 2)) if p < 1.0 else p - log(2.0 - exp(-p))
    high = min(p / K, 1.0 / (1.0 - K))
    for _ in range(60):
        if _left_side(high, K, kappa, K1, rho, L) <= 0.0:
            break
        high *= 1.5
    low, z = 0.0, min(K1 * p * _limit(p, K), high)
    for _ in range(100):
        left = _left_side(z, K, kappa, K1, rho, L)
        if left == 0.0:
            return z, True
        x = K * z
        slope = 1.0 + x * _moment(rho * x)
        slope = -K1 * K * exp(x - L) - (1.0 - K) - kappa * K * slope
        low, high = (z, high) if left > 0.0 else (low, z)
        new = z - left / slope
        new = new if low <= new <= high else (low + high) / 2.0
        if abs(new - z) <= 4.0 * _EPS * new:
            return new, True
        z = new
    return z, False


@compiled
def _left_side(z: float, K: float, kappa: float, K1: float, rho: float, L: float) -> float:
    x = K * z
    return -K1 * expm1(x - L) - (1.0 - K) * z - kappa * (x + x * x * _psi(rho * x))


@compiled
def _psi(x: float) -> float:
    """(e^(-x) - 1 + x)/x^2, by its series where that would cancel."""
    if abs(x) > 1.0:
        return (expm1(-x) + x) / (x * x)
    total = 0.0
    for k in range(20, 1, -1):
        total = (1.0 - x * total) / k
    return total


@compiled
def _moment(x: float) -> float:
    """(1 - e^(-x))/x."""
    return -expm1(-x) / x if x != 0.0 else 1.0
