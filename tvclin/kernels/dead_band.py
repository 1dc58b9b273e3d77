"""Exit of the dead band of a wind, from the curves of trim and demand over its steps.

Of each step are known trim at begin, middle and end, which is the parabola of these, and the demand
with its slopes at both ends, which is Hermite's cubic. The exit is at a new maximum of trim:
between the last one short of K times the demand, and the next.
"""

import math

from tvclin.base.arrays import FloatArray
from tvclin.kernels.source import allocation_free, kernel

Curves = tuple[FloatArray, FloatArray, FloatArray, FloatArray]
"""Of one case over S steps: trim and demand [rad] at begin, middle and end, ``(S, 3)`` each, slopes
of the demand [rad/s] at begin and end, ``(S, 2)``, and lengths of the steps [s], ``(S,)``."""

PLAIN, COMPILED = 1.5e-6, 7e-9
"""Seconds per step, in plain Python and as machine code."""
HEIGHT_TOLERANCE = 1e-9
"""Relative distance from the largest trim so far at which trim counts as a new height."""
_BEFORE = 1.0 - 2.0**-53
"""Factor from a positive number to the next smaller one."""
_RELATIVE_TOLERANCE, _SMALLEST = 4.0 * 2.0**-52, 2.0**-1022
"""Width of a bracket over its end at which it is the root, and smallest normal number."""
_MAX_ITERATIONS = 200
"""Largest number of iterations, of which bisection takes 55 from a bracket of the size of one."""


@kernel
def dead_band_exits(
    lengths: FloatArray,
    trim: FloatArray,
    demand: FloatArray,
    slopes: FloatArray,
    signs: FloatArray,
    dead_band: float,
    limits: FloatArray,
    positions: FloatArray,
    first: int,
    last: int,
) -> None:
    """Write the demand at the exit of the dead band, and its position in steps, ``(n,)`` each.

    The demand is the constant deflection that suffices from then on; the exit is at a new maximum
    of trim that is as large as K times the demand. The position (2.5: middle of the third step) is
    negative, and the limit zero, where trim stays within the dead band.

    Parameters
    ----------
    lengths, trim, demand, slopes : ndarray
        Lengths of the steps [s] ``(n, S)``, trim and demand [rad] at begin, middle and end of each,
        ``(n, S, 3)``, and slopes of the demand [rad/s] at begin and end, ``(n, S, 2)``.
    signs : ndarray
        Sign of the trim of largest size, ``(n,)``.
    dead_band : float
        K, above zero and below one.
    limits, positions : ndarray
        Written: sizes of the demand [rad], and positions.
    first, last : int
        Cases from the first up to the last are computed.
    """
    count = 3 * lengths.shape[1]  # sample k: begin, middle or end (k % 3) of step k // 3
    for case in range(first, last):
        # the last new maximum that is short of K times the demand, and the next one that is not
        sign, short, following, highest = signs[case], -1, count, -math.inf
        for k in range(count):
            height = sign * trim[case, k // 3, k % 3]
            highest = max(highest, height)
            rises = height > 0.0 and height >= highest * (1.0 - HEIGHT_TOLERANCE)
            if (rises or k == 0) and height < dead_band * sign * demand[case, k // 3, k % 3]:
                short, following = k, count
            elif rises and following == count:
                following = k
        if following == count:
            limits[case], positions[case] = 0.0, -1.0
            continue
        short = max(short, 0)
        # positions in steps, between which the exit is
        low, high = 0.5 * (short % 3) + short // 3, 0.5 * (following % 3) + following // 3
        if high > low:
            high *= _BEFORE  # of a jump at the end of a step, the value before
        floor = max(sign * trim[case, short // 3, short % 3], 0.0)
        curves = trim[case], demand[case], slopes[case], lengths[case]
        position = _exit(curves, sign, dead_band, floor, low, high)
        limits[case] = sign * _demand_at(curves, position)
        positions[case] = position


@allocation_free
def _demand_at(curves: Curves, position: float) -> float:
    """Return the demand [rad] at a position in steps (2.5: middle of the third step).

    The demand is the deflection that suffices if constant from then on; between begin and end of a
    step it is Hermite's cubic. `curves`: trim and demand [rad] ``(S, 3)``, slopes of the demand
    [rad/s] ``(S, 2)``, and lengths of the steps [s] ``(S,)``.
    """
    _, demand, slopes, lengths = curves
    step = min(int(position), lengths.shape[0] - 1)
    # the fraction u of the step, and the demand at begin a and end b, with its slopes s and e by u
    u, a, b = position - step, demand[step, 0], demand[step, 2]
    s, e = lengths[step] * slopes[step, 0], lengths[step] * slopes[step, 1]
    quadratic, cubic = 3.0 * (b - a) - 2.0 * s - e, 2.0 * (a - b) + s + e
    return a + u * (s + u * (quadratic + u * cubic))


@allocation_free
def _excess(curves: Curves, sign: float, dead_band: float, floor: float, position: float) -> float:
    """Return trim, at least `floor`, minus K times the demand [rad], at a position in steps.

    Trim is the parabola of its values at begin, middle and end of the step. `curves`: trim, demand,
    its slopes, and lengths of the steps. `sign`: of the largest trim, which counts as positive.
    `dead_band`: K. `floor`: [rad]. `position`: 2.5 is the middle of the third step.
    """
    trim, _, _, _ = curves
    # the fraction u of the step, and trim at its begin a, middle b and end c
    step = min(int(position), trim.shape[0] - 1)
    u, a, b, c = position - step, trim[step, 0], trim[step, 1], trim[step, 2]
    height = sign * (a + u * (4.0 * b - 3.0 * a - c + u * 2.0 * (a - 2.0 * b + c)))
    return max(height, floor) - dead_band * sign * _demand_at(curves, position)


@allocation_free
def _exit(
    curves: Curves, sign: float, dead_band: float, floor: float, low: float, high: float
) -> float:
    """Return the position in steps at which the excess rises through zero, `high` if it does not.

    The excess is trim minus K times the demand [rad]. `curves`: trim, demand, its slopes, and
    lengths of the steps. `sign`: of the largest trim. `dead_band`: K. `floor`: smallest trim that
    counts [rad]. `low`, `high`: positions between which the exit is sought. By Chandrupatla's
    method: inverse quadratic interpolation where it is safe, else bisection.
    """
    # x1, x2: ends of the bracket; x3: the point before; f1, f2, f3: excess at these
    f1 = _excess(curves, sign, dead_band, floor, low)
    f2 = _excess(curves, sign, dead_band, floor, high)
    if not f1 < 0.0 < f2:
        return high
    x1, x2, x3, f3 = low, high, high, f2
    best = high
    for _ in range(_MAX_ITERATIONS):
        best = x1 if abs(f1) < abs(f2) else x2
        width, tolerance = abs(x2 - x1), _RELATIVE_TOLERANCE * abs(best) + 4.0 * _SMALLEST
        if width < tolerance or f1 == 0.0 or f2 == 0.0:
            break
        step_fraction = 0.5  # of the bracket from x1, the newest point, to x2
        if x3 != x2 and f3 != f2:  # x3: the point before
            fraction, height = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
            if 1.0 - math.sqrt(max(1.0 - fraction, 0.0)) < height < math.sqrt(max(fraction, 0.0)):
                step_fraction = f1 / (f1 - f2) * f3 / (f3 - f2)
                step_fraction -= (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f2 - f3)
        nearest = 0.5 * tolerance / width
        x = x1 + min(max(step_fraction, nearest), 1.0 - nearest) * (x2 - x1)
        f = _excess(curves, sign, dead_band, floor, x)
        if (f > 0.0 and f1 > 0.0) or (f < 0.0 and f1 < 0.0):
            x3, f3 = x1, f1
        else:
            x3, f3, x2, f2 = x2, f2, x1, f1
        x1, f1 = x, f
    return best
