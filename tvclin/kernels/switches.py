"""Exit times of the dead band on the stability boundary, in the general problem, case by case.

The driver is the quantity that is compared with the demand: the wind itself, or its trim deflection
over -B, as the exit law says. The dead band is exited when the driver first equals K times the
demand (see `excess`), at a new maximum of the driver, and the last such time has the largest limit.
Between two sign changes of h the excess has at most one zero, and where it is positive at the end
of an interval it was negative before only if it was so at the start, or where h changed to
positive. Nothing else is evaluated.
"""

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IntArray
from tvclin.kernels.excess import (
    EXCESS,
    EXCESS_FORCING,
    FILTER_X,
    FILTER_Y,
    HEIGHT,
    MAX_INTERVALS,
    RELATIVE_ROUNDING,
    TRIM_DRIVES,
    WIND_DRIVES,
    ExitLaw,
    Wind,
    advance_filter,
    demand,
    driver,
    evaluate,
    integrate_wind,
    monotone_intervals,
    onset_piece,
    root,
    sign_changes,
)
from tvclin.kernels.source import allocation_free, kernel

SOLVED, JUMP, UNREACHED = 0, 1, 2
"""Status: a solution; a demand that jumps over it; a demand above all heights of the driver."""

PLAIN, COMPILED = 1e-4, 5e-7
"""Seconds per breakpoint of a case and rate of its wind, in plain Python and as machine code."""
FILTERED = {"f": 3, "c": 10}
"""Factor on these times for filtered trim, by the type of the rates (real, complex)."""
_RELATIVE_JUMP = 1e-9
"""Relative decrease of the driver that is a jump: more than rounding, less than any real jump."""
_POLE, _DEAD_BAND, _B1, _B2, _Q = range(5)
"""Columns of the numbers of each case."""
_LOCAL_TIME, _LEVEL, _MARGIN = range(3)
"""Columns of the new maxima of the driver: time since the begin of the piece [s], height of the
driver, and this height less K times the demand then."""
_MAX_MARKS = 4
"""Largest number of these maxima in a monotone interval."""


@kernel
def switches(
    winds: tuple[FloatArray, AnyArray, AnyArray],
    which: IntArray,
    numbers: FloatArray,
    literal: np.bool_,
    out: FloatArray,
    first: int,
    last: int,
) -> None:
    """Write time [s], demand and status of the exit of the dead band, of each case.

    The exit is where the driver, the wind or its trim, is as large as K times the demand, the
    constant deflection that then suffices. `winds`: w winds over their peaks: knots [s] ``(w, k)``,
    coefficients ``(w, k, r, degree + 1)`` and rates [1/s] ``(w, r)`` of terms c u^k e^(rate u).
    `which`: index of the wind of each case, ``(n,)``. `numbers`: of each case, ``(n, 5)``: unstable
    pole p [1/s], dead band K, and b1, b2 [1/s], q [1/s^2] of trim's filter
    (s^2 + b2 s + q)/(s^2 + b1 s + q). `literal`: whether the driver is trim itself. `out`: written,
    ``(3, n)``: time, demand over -B (trim deflection per angle of attack) and the wind's peak, and
    status SOLVED, JUMP or UNREACHED. Cases from `first` up to `last` are computed.
    """
    knots, coefficients, rates = winds
    marched, ends = np.empty((3, knots.shape[1])), np.empty(MAX_INTERVALS)
    marks = np.empty((_MAX_MARKS, 3))
    work = np.empty((2, coefficients.shape[3]), coefficients.dtype)
    for case in range(first, last):
        i = which[case]
        p, K = numbers[case, _POLE], numbers[case, _DEAD_BAND]
        b1, b2, q = numbers[case, _B1], numbers[case, _B2], numbers[case, _Q]
        wind = Wind(knots[i], coefficients[i], rates[i], marched, work)
        # the integrals do not depend on the driver
        integrate_wind(wind, ExitLaw(p, K, gain=b2 - b1, b1=b1, q=q, trim_drives=WIND_DRIVES))
        law = ExitLaw(p, K, gain=b2 - b1, b1=b1, q=q, trim_drives=literal)
        out[0, case], out[1, case], out[2, case] = _solve(wind, law, marks, ends)


@kernel
def largest_trims(
    winds: tuple[FloatArray, AnyArray, AnyArray],
    which: IntArray,
    numbers: FloatArray,
    out: FloatArray,
    first: int,
    last: int,
) -> None:
    """Write the largest size of trim, over B and the wind's peak, to ``out (n,)``.

    B is trim deflection per angle of attack, so that it is one without drift; infinite where trim
    grows without bound after the wind. `winds`: w winds over their peaks: knots [s] ``(w, k)``,
    coefficients ``(w, k, r, degree + 1)`` and rates [1/s] ``(w, r)``. `which`: index of the wind of
    each case, ``(n,)``. `numbers`: of each case, ``(n, 5)``: p and K, without effect here, and b1,
    b2 [1/s], q [1/s^2] of trim's filter (s^2 + b2 s + q)/(s^2 + b1 s + q). Cases from `first` up to
    `last` are computed.
    """
    knots, coefficients, rates = winds
    marched, ends = np.empty((3, knots.shape[1])), np.empty(MAX_INTERVALS)
    work = np.empty((2, coefficients.shape[3]), coefficients.dtype)
    for case in range(first, last):
        i = which[case]
        b1, b2, q = numbers[case, _B1], numbers[case, _B2], numbers[case, _Q]
        wind = Wind(knots[i], coefficients[i], rates[i], marched, work)
        # K has no effect
        law = ExitLaw(numbers[case, _POLE], 1.0, b2 - b1, b1=b1, q=q, trim_drives=TRIM_DRIVES)
        integrate_wind(wind, law)
        out[case] = _largest_trim(wind, law, ends)


@allocation_free
def _solve(
    wind: Wind, law: ExitLaw, marks: FloatArray, ends: FloatArray
) -> tuple[float, float, int]:
    """Return time [s], demand and status of the exit of the dead band of one wind.

    A height is a new maximum of the driver, the wind or its trim. The demand is the constant
    deflection that satisfies (4b) of the report from then on; both are over -B (trim deflection per
    angle of attack) and the wind's peak. The exit lies between the last height below K times the
    demand, and the first one after it that is not; without such a one it is the end of the wind
    with status UNREACHED. With K = 0 it is the onset of the wind. `law`: p, K, the filter of trim
    and the driver. `marks`, `ends`: work arrays of `_new_heights` and of `monotone_intervals`.
    """
    knots = wind.knots
    K = law.K
    if K == 0.0:
        i = onset_piece(wind)
        return knots[i], demand(wind, law, i, 0.0), SOLVED
    # low: piece, local time [s], height and margin of the last height below K times the demand;
    # high: piece, local time and margin of the first one after it that is not
    insufficient, sufficient = False, False  # whether there is a low one, and a high one after it
    low, high = (0, 0.0, 0.0, 0.0), (0, 0.0, 0.0)
    highest = 0.0
    for i in range(knots.size - 1):
        for interval in range(monotone_intervals(wind, law, i, ends)):
            heights = _new_heights(wind, law, marks, highest, i, ends[interval], ends[interval + 1])
            for k in range(heights):
                u, level, margin = marks[k, _LOCAL_TIME], marks[k, _LEVEL], marks[k, _MARGIN]
                if margin < -RELATIVE_ROUNDING * level:
                    insufficient, sufficient, low = True, False, (i, u, level, margin)
                elif not sufficient:
                    sufficient, high = True, (i, u, margin)
                highest = max(highest, level)
    if not sufficient:
        return knots[-1], 0.0, UNREACHED
    if not insufficient:
        low = (0, 0.0, -np.inf, 0.0)  # a negative height: there is none
    return _exit(wind, law, low, high)


@allocation_free
def _exit(
    wind: Wind,
    law: ExitLaw,
    low: tuple[int, float, float, float],
    high: tuple[int, float, float],
) -> tuple[float, float, int]:
    """Return time [s], demand and status of the exit of the dead band between two heights.

    Heights are new maxima of the driver (wind or trim over -B), margins these less K times the
    demand. `low`: piece, local time, height and margin of the last one with a negative margin; the
    height is negative if there is none. `high`: piece, local time and margin of the next. `law`: p,
    K and the filter of trim of a wind. The status is JUMP where the driver falls below the lower
    height just after the exit, else SOLVED.
    """
    i, u, _ = high
    _, _, low_height, _ = low
    status = SOLVED
    if low_height >= 0.0:
        i, u = _crossing(wind, law, low, high)
        if _driver_after(wind, law, i, u) < low_height * (1.0 - _RELATIVE_JUMP):
            status = JUMP
    return wind.knots[i] + u, demand(wind, law, i, u), status


@allocation_free
def _new_heights(
    wind: Wind, law: ExitLaw, marks: FloatArray, highest: float, i: int, a: float, b: float
) -> int:
    """Write new maxima of the driver in a monotone interval to `marks`; return their number.

    The driver is the wind, or its trim over -B (trim deflection per angle of attack), as `law`
    says. `marks`: written, ``(4, 3)``: a row for each maximum, with the local time [s], the height
    of the driver, and the margin, this height less K times the demand. `highest`: largest height
    before. `i`: segment of the wind. `a`, `b`: ends of the interval, local times [s]. Noted are the
    ends, and between them a time at which the margin may be negative.
    """
    start, _, _ = driver(wind, law, i, a)
    stop, _, _ = driver(wind, law, i, b)
    maximum, K = max(start, stop), law.K
    # Only new heights count, above the highest so far.
    if maximum <= 0.0 or maximum < highest * (1.0 - RELATIVE_ROUNDING):
        return 0
    if start < highest and stop > highest:
        a = root(HEIGHT, highest, wind, law, i, a, start - highest, b, stop - highest)
        start = highest
    elif start < min(stop, highest):
        a, start = b, stop
    # The height before and the height now at a, which differ where the driver jumps.
    demanded, count = K * demand(wind, law, i, a), 0
    for level in (min(highest, start), start):
        if level > highest or count == 0:
            marks[count, _LOCAL_TIME], marks[count, _LEVEL] = a, level
            marks[count, _MARGIN] = level - demanded
            count += 1
    if stop < start or b == a:
        return count
    # The margin e has e' = p e + h, h being EXCESS_FORCING: if e is positive at b, it was negative
    # between only if it was so at a, or where h changes from - to +, which is noted.
    margin = stop - K * demand(wind, law, i, b)
    if margin >= -RELATIVE_ROUNDING * stop:
        falling = evaluate(EXCESS_FORCING, 0.0, wind, law, i, a)[0] < 0.0
        turns, first, second = sign_changes(EXCESS_FORCING, wind, law, i, a, b)
        if turns == 2 or (turns == 1 and falling):
            u = first if falling else second
            level, _, _ = driver(wind, law, i, u)
            marks[count, _LOCAL_TIME], marks[count, _LEVEL] = u, level
            marks[count, _MARGIN] = level - K * demand(wind, law, i, u)
            count += 1
    marks[count, _LOCAL_TIME], marks[count, _LEVEL], marks[count, _MARGIN] = b, stop, margin
    return count + 1


@allocation_free
def _crossing(
    wind: Wind,
    law: ExitLaw,
    low: tuple[int, float, float, float],
    high: tuple[int, float, float],
) -> tuple[int, float]:
    """Return the piece and the local time [s] at which the driver reaches K times the demand.

    The driver is the wind, or its trim over -B (trim deflection per angle of attack), and counts at
    least as its height at `low`. The time is between two new maxima of it. `low`: the earlier, with
    a negative margin: piece, local time [s], height, and margin, the height less K times the
    demand. `high`: the later: piece, local time and margin. `wind`, `law`: wind with its integrals,
    and p, K and the filter of trim.
    """
    knots, K = wind.knots, law.K
    i, u, floor, margin = low
    high_piece, high_time, high_margin = high
    while i < high_piece:
        width = knots[i + 1] - knots[i]
        margin_after = max(driver(wind, law, i, width)[0], floor) - K * demand(wind, law, i, width)
        if width > u and margin_after >= 0.0:
            return i, root(EXCESS, floor, wind, law, i, u, margin, width, margin_after)
        i, u = i + 1, 0.0
        margin = max(driver(wind, law, i, u)[0], floor) - K * demand(wind, law, i, u)
        if margin >= 0.0:
            return i, u
    if high_time == u:
        return i, u
    return i, root(EXCESS, floor, wind, law, i, u, margin, high_time, high_margin)


@allocation_free
def _driver_after(wind: Wind, law: ExitLaw, i: int, u: float) -> float:
    """Return the driver just after the local time u [s] of piece i, behind a jump at its end.

    The driver is the wind of unit peak, or where `law.trim_drives` its trim over -B, trim
    deflection per angle of attack. At the end of a piece it is that at the begin of the next one
    that has a width.
    """
    knots = wind.knots
    while i < knots.size - 1 and u >= knots[i + 1] - knots[i]:
        i, u = i + 1, 0.0
    return driver(wind, law, i, u)[0]


@allocation_free
def _largest_trim(wind: Wind, law: ExitLaw, ends: FloatArray) -> float:
    """Return the largest size of trim, over B and the wind's peak, during the wind and after it.

    B is trim deflection per angle of attack. During the wind it is at an end of an interval in
    which trim is monotone. `law`: the filter of trim, with `trim_drives` true: then trim over -B is
    what `driver` returns and what is monotone in `monotone_intervals`. `ends`: work array of that.
    """
    largest = 0.0
    for i in range(wind.knots.size - 1):
        for interval in range(monotone_intervals(wind, law, i, ends)):
            for k in (interval, interval + 1):
                trim, _, _ = driver(wind, law, i, ends[k])
                largest = max(largest, abs(trim))
    return max(largest, _largest_free_trim(wind, law))


@allocation_free
def _largest_free_trim(wind: Wind, law: ExitLaw) -> float:
    """Return the largest size of trim after the wind; infinite where it grows without end.

    Over B, trim deflection per angle of attack, and the peak of the wind it is then gain y, with
    the filter y'' + b1 y' + q y = 0 (`law`), whose state x, y = x' at the end of the wind is in the
    last column of `wind.marched`. Its slope v = y' obeys the same equation: with w^2 = q - b1^2/4

            v(u) = e^(-b1 u/2) [v cos(w u) + (v' + b1 v/2) sin(w u)/w],

    and y is extreme where that is zero, tan(w u) = -w v/(v' + b1 v/2): at the first u > 0, and with
    tanh where w^2 is negative.
    """
    _, c, rates, marched, work = wind
    gain, b1, q = law.gain, law.b1, law.q
    last = marched.shape[1] - 1
    x, y = marched[FILTER_X, last], marched[FILTER_Y, last]
    if gain == 0.0 or (y == 0.0 and q * x == 0.0):
        return 0.0
    if b1 < 0.0:
        return np.inf
    slope = -b1 * y - q * x
    cosine_term = -0.5 * b1 * slope - q * y  # v' + b1 v/2 at the start
    square = q - 0.25 * b1 * b1
    frequency = np.sqrt(abs(square))  # w
    u = 0.0  # time of the extreme, zero if there is none
    if square > 0.0:
        phase = np.arctan2(-slope * frequency, cosine_term)
        u = (phase if phase > 0.0 else phase + np.pi) / frequency
    elif 0.0 < -slope * frequency < cosine_term or cosine_term < -slope * frequency < 0.0:
        u = np.arctanh(-slope * frequency / cosine_term) / frequency
    # the last piece, after the wind, is zero
    _, extreme = advance_filter(c[last], rates, u, x, y, b1, q, work)
    return abs(gain) * max(abs(y), abs(extreme))
