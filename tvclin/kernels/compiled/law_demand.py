"""Compiled twin of `kernels.law_demand`: what a law asks for, one flight at a time."""

import numpy as np

from tvclin.kernels import flight_table as table
from tvclin.kernels.compiled.compiler import lean


@lean
def demand(law, theta, rate, path, alpha, kept, second):  # type: ignore[no-untyped-def]
    """Return the deflection asked for [rad]; `law` is a column of the table."""
    if law[table.LEAN] != 0.0:
        return _leaning(law, theta, rate, path, alpha, kept, second)
    asked = law[table.K_ATTITUDE] * theta + law[table.K_RATE] * rate + law[table.K_PATH] * path
    return asked + law[table.K_ALPHA] * alpha + law[table.K_MEMORY] * kept


@lean
def _leaning(law, theta, rate, path, alpha, kept, second):  # type: ignore[no-untyped-def]
    wind = theta - alpha
    if law[table.LEAN_ESTIMATES] != 0.0:
        rate, wind = kept, second
    wind = wind - path
    wind = np.sign(wind) * max(abs(wind) - law[table.LEAN_BAND], 0.0)
    fast = law[table.LEAN_ATTITUDE] * theta + law[table.LEAN_RATE] * rate
    fast += law[table.LEAN_PATH] * path
    slow = law[table.LEAN_SLOW] * theta + law[table.LEAN_SLOW_RATE] * rate
    slow += law[table.LEAN_SLOW_PATH] * path
    felt, B = law[table.LEAN_WIND] * wind, law[table.LEAN_B]
    lean = _lean(law, slow, felt, abs(wind), law[table.LIMIT] / abs(B))
    return B * (fast - felt + law[table.LEAN_GAIN] * (fast - lean))


@lean
def _lean(law, slow, felt, wind, D):  # type: ignore[no-untyped-def]
    reach = most = law[table.LEAN_REACH] * D
    if law[table.LEAN_PEAK] < np.inf:
        asked = law[table.LEAN_WIND] * max(law[table.LEAN_PEAK], table.HEADROOM * wind)
        asked -= law[table.LEAN_TRUST] * D
        most = min(reach, max(asked, 0.0))
    turn = table.SLOW_LOOP * slow
    lean = min(most + max(turn, 0.0), felt + turn)
    lean = max(lean, min(turn, 0.0) - most)
    spare = table.FAST_FIRST * D
    if felt > 0.0:
        lean = max(lean, felt - spare)
    elif felt < 0.0:
        lean = min(lean, felt + spare)
    low, high = -reach, reach
    if law[table.LEAN_RATIO] > 0.0:
        x = min(max(slow / reach, -table.EDGE), table.EDGE)
        power = 1.0 / law[table.LEAN_RATIO]
        low = reach * (2.0 * ((1.0 + x) / 2.0) ** power - 1.0)
        high = reach * (1.0 - 2.0 * ((1.0 - x) / 2.0) ** power)
    return min(max(lean, low), high)


@lean
def switched(law, asked, mode):  # type: ignore[no-untyped-def]
    """Return the mode that follows: engaged at the limit, or let go."""
    if not asked * mode > law[table.RELEASE]:
        mode = 0.0
    if mode == 0.0 and abs(asked) >= law[table.ENGAGE]:
        mode = np.sign(asked)
    return mode


@lean
def inside(law, x):  # type: ignore[no-untyped-def]
    """Return whether the states of a plant are recoverable, and the larger coordinate."""
    fast, slow = 0.0, 0.0
    for k in range(x.size):
        fast += law[table.FAST + k] * x[k]
        slow += law[table.SLOW + k] * x[k]
    reach, ratio = law[table.REACH], law[table.RATIO]
    recoverable = abs(fast) < reach
    if recoverable and ratio > 0.0:
        part = fast / reach
        low = reach * (1.0 - 2.0 * ((1.0 - part) / 2.0) ** ratio)
        high = reach * (2.0 * ((1.0 + part) / 2.0) ** ratio - 1.0)
        recoverable = low < slow < high
    return recoverable, max(abs(fast), abs(slow))
