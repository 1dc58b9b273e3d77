"""One piece of a history at one time, in scalars: its value, its future, the state of a filter.

A piece is a sum of terms c u^k e^(lambda u), `c` being coefficients ``(rates, degree + 1)``. The
filter is that of trim, x'' + b1 x' + q x = f and y = x'; with q = 0 it is the lag y' + b1 y = f.
"""

from typing import Any

import numpy as np

from tvclin.kernels.source import bare

_LOST = 1e-18
"""A part of a sum that leaves nothing in it."""
_SHORT, _FEW, _MANY = 0.25, 13, 19
"""Moments of arguments up to the first, and up to one, begin at so many orders higher."""


@bare
def value(c: Any, rates: Any, u: float) -> tuple[float, float, float]:
    """Return value, slope and curvature at the local time `u`."""
    level, slope, bend = 0.0, 0.0, 0.0
    for r in range(rates.size):
        rate = rates[r]
        a = c[r, c.shape[1] - 1]
        first, second = 0.0 * a, 0.0 * a
        for k in range(c.shape[1] - 2, -1, -1):
            second = second * u + first
            first = first * u + a
            a = a * u + c[r, k]
        second *= 2.0
        if rate != 0.0:
            grown = np.exp(rate * u)
            second = grown * (second + rate * (2.0 * first + rate * a))
            first = grown * (first + rate * a)
            a = grown * a
        level += a.real
        slope += first.real
        bend += second.real
    return level, slope, bend


@bare
def future(c: Any, rates: Any, u: float, left: float, p: Any) -> Any:
    """Return the integral of e^(-p v) f(u + v) dv over what is left of a piece.

    By the moments of `numerics.pieces`, each order from the direction that is stable for it. The
    mode p may be complex.
    """
    degree = c.shape[1] - 1
    total = 0.0 * (c[0, 0] * p)
    if left == 0.0:
        return total
    for r in range(rates.size):
        rate = rates[r]
        z = (p - rate) * left
        size = abs(z)
        decay = np.exp(-z)
        part = 0.0 * (c[r, 0] * decay)
        rising = min(int(min(size, 1e3)), degree) if size > 1.0 else -1
        moment, power = part, left
        for k in range(rising + 1):
            moment = (k * moment - decay) / z if k > 0 else (1.0 - decay) / z
            part += _moved(c, r, k, u) * power * moment
            power *= left
        if rising < degree:
            order, error = degree + (_FEW if size <= _SHORT else _MANY), 1.0
            if size > 1.0:
                order = degree + 1
                while error > _LOST:
                    order += 1
                    error *= size / order
            moment, power = 0.0 * part, left ** (degree + 1)
            for k in range(order, rising + 1, -1):
                moment = (z * moment + decay) * (1.0 / k)
                if k <= degree + 1:
                    part += _moved(c, r, k - 1, u) * power * moment
                    power /= left
        if rate != 0.0:
            part *= np.exp(rate * u)
        total += part
    return total


@bare
def _moved(c: Any, r: int, k: int, u: float) -> Any:
    """The coefficient of order k when local time starts at u, but for the exponential."""
    degree = c.shape[1] - 1
    if u == 0.0 or k == degree:
        return c[r, k]
    ways = 1.0
    for j in range(k + 1, degree + 1):
        ways *= j / (j - k)
    total = ways * c[r, degree]
    for j in range(degree, k, -1):
        ways *= (j - k) / j
        total = total * u + ways * c[r, j - 1]
    return total


@bare
def filtered(
    c: Any, rates: Any, u: float, x: float, y: float, b1: float, q: float, work: Any
) -> tuple[float, float]:
    """Return the filter's state (x, y) at the local time `u`, from that at the start of the piece.

    Its answers to the impulse and to v^k e^(lambda v) are series over so short a time that no rate
    counts more than one, and doubled as often as it takes. `work` is ``(2, degree + 2)``, of the
    kind of the coefficients.
    """
    found_x, found_y = 0.0, 0.0
    degree = c.shape[1] - 1
    slow = max(abs(b1), np.sqrt(q))
    for r in range(rates.size):
        rate = rates[r]
        there = r == 0
        for k in range(degree + 1):
            there = there or c[r, k] != 0.0
        if not there:
            continue
        step, doublings = u, 0
        while (slow + abs(rate)) * step > 1.0:
            step *= 0.5
            doublings += 1
        # The answer to the impulse f, its slope g, and above them the integrals of f e^(-rate v).
        f, g = _series(work, degree, rate, step, b1, q, (slow + abs(rate)) * step)
        for _ in range(doublings):
            grown = np.exp(rate * step)
            for k in range(degree, -1, -1):
                answer = work[1, k]
                turned = rate * answer + (k * work[1, k - 1] if k > 0 else f)
                ways, later = 1.0, 0.0 * answer
                for j in range(k, -1, -1):  # the binomial of (step + v)^k
                    later += ways * work[1, j]
                    ways *= step * j / (k - j + 1)
                work[1, k] = (g + b1 * f) * answer + f * turned + grown * later
            f, g = (2.0 * g + b1 * f) * f, g * g - q * f * f
            step *= 2.0
        for k in range(degree + 1):
            answer = work[1, k]
            turned = rate * answer + (k * work[1, k - 1] if k > 0 else f)
            found_x += (c[r, k] * answer).real
            found_y += (c[r, k] * turned).real
        if r == 0:
            found_x += (g + b1 * f) * x + f * y
            found_y += g * y - q * f * x
    return found_x, found_y


@bare
def _series(
    work: Any, degree: int, rate: Any, step: float, b1: float, q: float, size: float
) -> tuple[float, float]:
    """Return the answer to the impulse and its slope, and write those to v^k e^(rate v).

    The answer to the k-th is k! f(s)/(s - rate)^(k + 1), a ladder of sums over the terms of f.
    """
    for k in range(degree + 1):
        work[0, k], work[1, k] = 0.0, 0.0
    f, g, term_f, term_g = 0.0, 1.0, 0.0, 1.0
    n, error = 0, 1.0
    while error > _LOST or n < degree + 3:
        n += 1
        part = step / n
        error *= size / n
        for k in range(degree, -1, -1):
            below = k * work[0, k - 1] if k > 0 else term_f
            work[0, k] = (rate * work[0, k] + below) * part
            work[1, k] += work[0, k]
        term_f, term_g = term_g * part, -(b1 * term_g + q * term_f) * part
        f += term_f
        g += term_g
    return f, g
