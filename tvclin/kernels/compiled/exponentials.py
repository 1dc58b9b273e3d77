"""Exponentials without a branch and without a call, so that the compiler computes several at once.

They are right to the last digit but one, for exponents from -700 to 700.
"""

from math import factorial

import numpy as np

from tvclin.kernels.compiled.compiler import inlined

_PER_LN2 = 1.4426950408889634
_LN2, _LN2_REST = 6.93147180369123816490e-01, 1.90821492927058770002e-10
"""ln 2 as a number with trailing zeros, whose multiples are exact, and the rest."""
_C2, _C3, _C4, _C5, _C6, _C7, _C8, _C9, _C10, _C11, _C12, _C13 = (
    1.0 / factorial(k) for k in range(2, 14)
)
_WHOLE = 1.5 * 2.0**52
"""Beside so large a number nothing is left of fractions, and its last bits count the units."""
_BIAS, _MANTISSA = 1023, 52
"""Of a number of 64 bits: a power of two is its exponent and the bias, before the mantissa."""


@inlined
def exponential(x: float) -> float:
    """e^x."""
    power, near = _split(x)
    return power + power * near


@inlined
def exponential_less_one(x: float) -> float:
    """e^x - 1."""
    power, near = _split(x)
    return power * near + (power - 1.0)


@inlined
def small_exponential_less_one(x: float) -> float:
    """e^x - 1 where x is so small that seven terms of its series are enough."""
    return x * (1.0 + x * (_C2 + x * (_C3 + x * (_C4 + x * (_C5 + x * (_C6 + x * _C7))))))


@inlined
def _split(x: float) -> tuple[float, float]:
    """A power of two, and what is to be added to one: e^r - 1 with |r| below ln(2)/2."""
    counted = x * _PER_LN2 + _WHOLE
    k = counted - _WHOLE
    r = (x - k * _LN2) - k * _LN2_REST
    bits = (np.float64(counted).view(np.int64) + _BIAS) << _MANTISSA
    square = r * r
    low = (_C2 + r * _C3) + square * (_C4 + r * _C5)
    middle = (_C6 + r * _C7) + square * (_C8 + r * _C9)
    high = (_C10 + r * _C11) + square * (_C12 + r * _C13)
    near = r + square * (low + (square * square) * (middle + (square * square) * high))
    return np.int64(bits).view(np.float64), near
