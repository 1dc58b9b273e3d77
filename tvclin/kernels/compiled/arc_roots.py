"""Where the series of one lane pass a target, and where they turn."""

import numpy as np

from tvclin.kernels import flight_table as table
from tvclin.kernels.compiled import lanes
from tvclin.kernels.compiled.compiler import lean
from tvclin.kernels.compiled.lanes import ORDER


@lean
def jet(s, start, t):  # type: ignore[no-untyped-def]
    """Value, slope and half the curvature of a lane's series.

    Its even and its odd terms are summed side by side, in powers of the square.
    """
    x = t * t
    even, even_slope, even_bend, odd, odd_slope, odd_bend = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(ORDER - 1, -1, -2):
        even_bend = even_bend * x + even_slope
        odd_bend = odd_bend * x + odd_slope
        even_slope = even_slope * x + even
        odd_slope = odd_slope * x + odd
        even = even * x + s[start + np.uint64(k * lanes.LANES)]
        odd = odd * x + s[start + np.uint64((k + 1) * lanes.LANES)]
    value, slope = even + t * odd, 2.0 * (t * even_slope + x * odd_slope) + odd
    bend = even_slope + 3.0 * t * odd_slope + 4.0 * x * (even_bend + t * odd_bend)
    return value, slope, bend


@lean
def _cubic(below, above, rise, fall):  # type: ignore[no-untyped-def]
    """The powers one to three of the cubic between 0 and 1 with these ends, and slopes there."""
    far = above - below
    return rise, 3.0 * far - 2.0 * rise - fall, rise + fall - 2.0 * far


@lean
def root(s, start, low, high, below, above, slopes, target):  # type: ignore[no-untyped-def]
    """Where a series passes the target between two times, at which it misses it by so much.

    Halley's method from the root of a cubic, bisection where it leaves the bracket.
    """
    width, t = high - low, 0.5 * (low + high)
    if below * above < 0.0:
        a, b, c = _cubic(below, above, width * slopes[0], width * slopes[1])
        u = below / (below - above)
        miss, slope, bend = below + u * (a + u * (b + u * c)), a + u * (2.0 * b + 3.0 * c * u), b
        bend += 3.0 * c * u
        new = u - miss * slope / (slope * slope - miss * bend)
        t = low + width * (new if 0.0 < new < 1.0 else u)
    for _ in range(table.ROUNDS):
        value, slope, bend = jet(s, start, t)
        miss = value - target
        if (miss < 0.0) == (below < 0.0):
            low = t
        else:
            high = t
        if miss == 0.0:
            return t
        new = t - miss * slope / (slope * slope - miss * bend)
        if abs(miss) <= table.NEAR * width * abs(slope):
            return min(max(new, low), high)  # near the root `t` is an end, and `new` may be beyond
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - t) <= table.FINE * width:
            return new
        t = new
    return t


@lean
def turn(s, start, high, end, below, above):  # type: ignore[no-untyped-def]
    """Where a series turns before a time, of its slopes at both ends, and its value there."""
    a, b, c = _cubic(s[start], end, high * below, high * above)
    width = np.sqrt(max(b * b - 3.0 * a * c, 0.0))
    t = high * (a / ((width if a > 0.0 else -width) - b))
    low = 0.0
    if not low < t < high:
        t = 0.5 * high
    fine = table.SUMMIT * high
    value, slope, bend = jet(s, start, t)
    for _ in range(table.ROUNDS):
        if (slope < 0.0) == (below < 0.0):
            low = t
        else:
            high = t
        if slope == 0.0:
            return t, value
        new = t - 0.5 * slope / bend
        if abs(slope) <= 2.0 * fine * abs(bend):
            new = min(max(new, low), high)
        elif not low < new < high:
            new = 0.5 * (low + high)
        far = new - t
        if abs(far) <= fine:
            return new, value + far * (slope + far * bend)
        t = new
        value, slope, bend = jet(s, start, t)
    return t, value
