"""Discounted remaining integrals of a wind: at its onset, at their maximum, and after trim.

W(t) = p integral from t on of e^(-p (r - t)) f(r) dr is the demand of `excess` for a wind that is
trimmed at once, so W' = p (W - f).

A control that trims up to K times its limit L leaves trim at the first time at which trim is as
large as K L, with either sign. From the state of that time every unstable pole p_i demands the mean

    z_i = p_i integral from t on of e^(-p_i (r - t)) g(r) dr

of the remaining trim g, the demand of `excess` for each mode by itself. Where trim stays below that
height during the wind, the control is free from the end of the wind on.
"""

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IntArray
from tvclin.kernels.excess import (
    EXCESS,
    HEIGHT,
    MAX_INTERVALS,
    TRIM_DRIVES,
    WIND_DRIVES,
    ExitLaw,
    Wind,
    demand,
    demand_of_integral,
    driver,
    filter_state,
    integrate_filter,
    integrate_wind,
    monotone_intervals,
    onset_piece,
    remaining_integral,
    root,
)
from tvclin.kernels.source import allocation_free, kernel

PLAIN, COMPILED = 1e-4, 5e-7
"""Seconds per breakpoint of a case and rate of its wind, in plain Python and as machine code."""
ONSET_PLAIN, ONSET_COMPILED = 3e-5, 1e-7
"""Seconds per breakpoint, rate and pole of `onset_integrals`, plain and as machine code."""
_B1, _B2, _Q = range(3)
"""Columns of the numbers of the filter of trim."""


@kernel
def largest_remaining_integrals(
    winds: tuple[FloatArray, AnyArray, AnyArray],
    which: IntArray,
    poles: FloatArray,
    out: FloatArray,
    first: int,
    last: int,
) -> None:
    """Write p times the remaining integral of winds of unit peak, at its onset and maximum.

    W(t) = p times the integral of e^(-p (r - t)) f(r) dr over the wind f from t on. To ``out (n,
    3)``: W at the onset, the maximum, and its time [s]. `winds`: knots [s] ``(w, k)``, coefficients
    ``(w, k, r, degree + 1)`` and rates [1/s] ``(w, r)`` of the winds' terms c u^k e^(rate u).
    `which`: index of the wind of each case, ``(n,)``. `poles`: p [1/s], ``(n,)``. Cases from
    `first` up to `last` are computed.
    """
    knots, coefficients, rates = winds
    marched, ends = np.empty((3, knots.shape[1])), np.empty(MAX_INTERVALS)
    work = np.empty((2, coefficients.shape[3]), coefficients.dtype)
    for case in range(first, last):
        i = which[case]
        wind = Wind(knots[i], coefficients[i], rates[i], marched, work)
        # no filter: the wind itself is trim, and W its demand
        law = ExitLaw(poles[case], K=1.0, gain=0.0, b1=0.0, q=0.0, trim_drives=WIND_DRIVES)
        integrate_wind(wind, law)
        largest, time = _largest_demand(wind, law, ends)
        out[case, 0] = demand(wind, law, onset_piece(wind), 0.0)
        out[case, 1], out[case, 2] = largest, time


@kernel
def onset_integrals(
    winds: tuple[FloatArray, AnyArray, AnyArray],
    which: IntArray,
    poles: AnyArray,
    out: AnyArray,
    first: int,
    last: int,
) -> None:
    """Write the discounted remaining integrals of winds at their onset to ``out (n, m)``.

    They are integrals of e^(-p r) f(t + r) dr over the wind f from its onset t on, in s times the
    unit of f, complex where a pole or a rate is. `winds`: knots [s]
    ``(w, k)``, coefficients ``(w, k, r, degree + 1)`` and rates [1/s] ``(w, r)``. `which`: index
    of the wind of each case, ``(n,)``. `poles`: p [1/s], which may be complex, ``(n, m)``. Cases
    from `first` up to `last` are computed.
    """
    knots, c, rates = winds
    for case in range(first, last):
        i = which[case]
        # integrals at knots and work array are not used
        wind = Wind(knots[i], c[i], rates[i], marched=knots, work=knots)
        for k in range(poles.shape[1]):
            out[case, k] = remaining_integral(wind, onset_piece(wind), 0.0, poles[case, k])


@kernel
def demands_at_heights(
    winds: tuple[FloatArray, AnyArray, AnyArray],
    which: IntArray,
    numbers: FloatArray,
    poles: AnyArray,
    heights: FloatArray,
    out: AnyArray,
    first: int,
    last: int,
) -> None:
    """Write the demands of the modes when trim reaches a height, over B times the wind's peak.

    A demand is the mean of the remaining trim in a mode: p times its integral with e^(-p r) over
    the time r from then on. B is trim deflection per angle of attack. `winds`: knots [s]
    ``(w, k)``, coefficients ``(w, k, r, degree + 1)`` and rates [1/s] ``(w, r)`` of winds over
    their peaks. `which`: index of the wind of each case, ``(n,)``. `numbers`: b1, b2 [1/s] and q
    [1/s^2] of each case's filter of trim, (s^2 + b2 s + q)/(s^2 + b1 s + q), ``(n, 3)``. `poles`:
    p of the modes [1/s], which may be complex, ``(n, m)``. `heights`: over B times the wind's peak,
    positive, ``(n,)``. `out`: written: demands, ``(n, m)``; where trim stays below the height
    during the wind, at its end. Cases from `first` up to `last` are computed.
    """
    knots, coefficients, rates = winds
    marched, ends = np.empty((3, knots.shape[1])), np.empty(MAX_INTERVALS)
    work = np.empty((2, coefficients.shape[3]), coefficients.dtype)
    for case in range(first, last):
        j = which[case]
        b1, b2, q = numbers[case, _B1], numbers[case, _B2], numbers[case, _Q]
        wind = Wind(knots[j], coefficients[j], rates[j], marched, work)
        # p and K are not used
        law = ExitLaw(p=1.0, K=1.0, gain=b2 - b1, b1=b1, q=q, trim_drives=TRIM_DRIVES)
        integrate_filter(wind, law)
        i, u = _height_time(wind, law, heights[case], ends)
        x, y = filter_state(wind, law, i, u)
        for k in range(poles.shape[1]):
            p = poles[case, k]
            out[case, k] = demand_of_integral(law, p, remaining_integral(wind, i, u, p), x, y)


@allocation_free
def _largest_demand(wind: Wind, law: ExitLaw, ends: FloatArray) -> tuple[float, float]:
    """Return the largest demand of a wind trimmed at once, over its peak, and its time [s].

    The demand W is the discounted mean of the remaining wind, and W' = p (W - f): it rises while it
    is above the wind f, so that its maximum is at a knot, or where a rising wind reaches it: where
    f - W, negative before, changes its sign in an interval in which f is monotone. `law`: the pole
    p, K = 1, a filter without effect, and f as the driver, the first result of `driver`. `ends`:
    work array of `monotone_intervals`.
    """
    knots = wind.knots
    largest, time = -np.inf, 0.0
    for i in range(knots.size - 1):
        level = demand(wind, law, i, 0.0)
        if level > largest:
            largest, time = level, knots[i]
        for k in range(monotone_intervals(wind, law, i, ends)):
            a, b = ends[k], ends[k + 1]
            top = driver(wind, law, i, b)[0]
            before = driver(wind, law, i, a)[0] - demand(wind, law, i, a)
            after = top - demand(wind, law, i, b)
            if before < 0.0 < after and top > largest:
                # EXCESS with K = 1 is f - W, and counts from all heights on
                u = root(EXCESS, -np.inf, wind, law, i, a, before, b, after)
                level = demand(wind, law, i, u)
                if level > largest:
                    largest, time = level, knots[i] + u
    return largest, time


@allocation_free
def _height_time(wind: Wind, law: ExitLaw, height: float, ends: FloatArray) -> tuple[int, float]:
    """Return piece and local time [s] at which trim first reaches a height with either sign.

    The end of the wind where it never does. `law`: the filter that makes trim of the wind, with
    `trim_drives` true, so that the first result of `driver` is trim divided by -B and the wind's
    peak; B is trim deflection per angle of attack. `height`: in the same measure. `ends`: work
    array of `monotone_intervals`.
    """
    knots = wind.knots
    for i in range(knots.size - 1):
        for k in range(monotone_intervals(wind, law, i, ends)):
            a, b = ends[k], ends[k + 1]
            start, stop = driver(wind, law, i, a)[0], driver(wind, law, i, b)[0]
            if abs(start) >= height:
                return i, a
            if abs(stop) >= height:
                level = height if stop > 0.0 else -height
                return i, root(HEIGHT, level, wind, law, i, a, start - level, b, stop - level)
    i = knots.size - 2
    return i, knots[i + 1] - knots[i]
