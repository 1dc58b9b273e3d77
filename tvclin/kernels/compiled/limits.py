"""Eqs (12) and (18), element by element; for the formulas see `kernels.limits`.

Eq (12) is written without a branch and without a call, so that the compiler computes several
elements at once: exponentials and logarithms are series here, right to the last digit.
"""

from math import exp, expm1, factorial, log, log1p

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.compiled.compiler import compiled, inlined

FloatArray = NDArray[np.float64]

_EPS = 2.0**-52
_PER_LN2 = 1.4426950408889634
_LN2, _LN2_REST = 6.93147180369123816490e-01, 1.90821492927058770002e-10
"""ln 2 as a number with trailing zeros, whose multiples are exact, and the rest."""
_C2, _C3, _C4, _C5, _C6, _C7, _C8, _C9, _C10, _C11, _C12, _C13 = (
    1.0 / factorial(k) for k in range(2, 14)
)
_DIED = 43.0
"""e^-43 is nothing beside one."""
_MIDDLE = 1.8
_LOG_MIDDLE = log(_MIDDLE)
_NEVER = 1e-150
"""Stands for 1 - K where K is one."""


@compiled
def triangular(p: FloatArray, K: FloatArray, y: FloatArray) -> None:
    """Write y of eq (12)."""
    for i in range(p.size):
        y[i] = _limit(p[i], K[i])


@inlined
def _limit(p: float, K: float) -> float:
    """Solve y = (1 - e^(-s))/(p (1 - K)) with s + c (1 - e^(-s)) = L and c = K/(1 - K).

    Two of Halley's steps, the second with one more of Newton's on its own series.
    """
    L = _minus_log_R(p)
    rest = 1.0 - K
    rest = _NEVER if rest < _NEVER else rest
    c = K / rest
    s = _start(L, c, 0.5)
    s = _start(L, c, 1.0 - (1.0 + s / 12.0) / (2.0 + s * (0.5 + s / 12.0)))
    e = _expm1(s)
    excess, slope = (s - c * e) - L, 1.0 + c * (1.0 + e)
    s -= excess * slope / (slope * slope + 0.5 * excess * (slope - 1.0))
    e = _expm1(s)
    excess, slope = (s - c * e) - L, 1.0 + c * (1.0 + e)
    t = excess * slope / (slope * slope + 0.5 * excess * (slope - 1.0))
    change = _small(t)
    t += (excess - t - (slope - 1.0) * change) / (slope + (slope - 1.0) * change)
    return -(e + (1.0 + e) * _small(t)) / (p * rest)


@inlined
def _start(L: float, c: float, a: float) -> float:
    """The solution if 1 - e^(-s) were s/(1 + a s)."""
    half = 1.0 + c - a * L
    root = np.sqrt(half * half + 4.0 * a * L)
    side = 1.0 if half > 0.0 else 0.0
    other = 1.0 - side
    return (side * 2.0 * L + other * (root - half)) / (side * (root + half) + other * 2.0 * a)


@inlined
def _minus_log_R(p: float) -> float:
    """L, by the series of atanh; below p = 1 as -ln(1 - q^2), above as p - ln(1 + q)."""
    q = -_expm1(p)
    short = 1.0 if p < 1.0 else 0.0
    long = 1.0 - short
    above = short * q * q + long * ((1.0 + q) - _MIDDLE)
    below = short * (2.0 - q * q) + long * ((1.0 + q) + _MIDDLE)
    w = above / below
    x = w * w
    series = 0.0
    for k in range(27, 1, -2):
        series = x * (1.0 / k + series)
    atanh = 2.0 * (w + w * series)
    return short * atanh + long * ((p - _LOG_MIDDLE) - atanh)


@inlined
def _expm1(s: float) -> float:
    """e^(-s) - 1 for s >= 0, from e^(-r) with |r| below ln(2)/2 and a power of two."""
    s = _DIED if s > _DIED else s
    k = np.floor(s * _PER_LN2 + 0.5)
    r = (k * _LN2 - s) + k * _LN2_REST
    near = _C8 + r * (_C9 + r * (_C10 + r * (_C11 + r * (_C12 + r * _C13))))
    near = _C2 + r * (_C3 + r * (_C4 + r * (_C5 + r * (_C6 + r * (_C7 + r * near)))))
    near = r + r * r * near
    power = 1.0
    for bit in (32.0, 16.0, 8.0, 4.0, 2.0, 1.0):
        there = k >= bit
        power = power * 0.5**bit if there else power
        k = k - bit if there else k
    return power * near + (power - 1.0)


@inlined
def _small(t: float) -> float:
    """e^t - 1 for a small t."""
    return t * (1.0 + t * (_C2 + t * (_C3 + t * (_C4 + t * (_C5 + t * (_C6 + t * _C7))))))


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
