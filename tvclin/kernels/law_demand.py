"""What the laws of a batch of flights ask for, and which states they can come back from.

The laws of this package as arithmetic on the rows of a `FlightTable`: gains on what is seen, or a
lean that is followed. A compiled twin does the same for one flight.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels import flight_table as table

FloatArray = NDArray[np.float64]


def demand(
    law: FloatArray, theta: Any, rate: Any, path: Any, alpha: Any, memory: FloatArray
) -> FloatArray:
    """Return the deflections asked for [rad], ``(m,)``.

    Parameters
    ----------
    law : ndarray
        Rows of the table, ``(55, m)``.
    theta, rate, path, alpha : ndarray
        What is seen [rad, rad/s], ``(m,)``.
    memory : ndarray
        The laws' own states, ``(2, m)``.
    """
    asked = law[table.K_ATTITUDE] * theta + law[table.K_RATE] * rate + law[table.K_PATH] * path
    asked = asked + law[table.K_ALPHA] * alpha + law[table.K_MEMORY] * memory[0]
    leans = law[table.LEAN] != 0.0
    if not np.any(leans):
        return asked
    theta, rate, path, alpha = (a[leans] for a in (theta, rate, path, alpha))
    asked[leans] = _leaning(law[:, leans], theta, rate, path, alpha, memory[:, leans])
    return asked


def _leaning(
    law: FloatArray, theta: Any, rate: Any, path: Any, alpha: Any, memory: FloatArray
) -> FloatArray:
    estimates = law[table.LEAN_ESTIMATES] != 0.0
    rate = np.where(estimates, memory[0], rate)
    wind = np.where(estimates, memory[1], theta - alpha) - path
    wind = np.sign(wind) * np.maximum(np.abs(wind) - law[table.LEAN_BAND], 0.0)
    fast = law[table.LEAN_ATTITUDE] * theta + law[table.LEAN_RATE] * rate
    fast = fast + law[table.LEAN_PATH] * path
    slow = law[table.LEAN_SLOW] * theta + law[table.LEAN_SLOW_RATE] * rate
    slow = slow + law[table.LEAN_SLOW_PATH] * path
    felt, B = law[table.LEAN_WIND] * wind, law[table.LEAN_B]
    lean = _lean(law, slow, felt, np.abs(wind))
    return np.asarray(B * (fast - felt + law[table.LEAN_GAIN] * (fast - lean)))


def _lean(law: FloatArray, slow: Any, felt: Any, wind: Any) -> FloatArray:
    D = law[table.LIMIT] / np.abs(law[table.LEAN_B])
    reach, peak = law[table.LEAN_REACH] * D, law[table.LEAN_PEAK]
    known = np.where(peak < np.inf, peak, 0.0)
    asked = law[table.LEAN_WIND] * np.maximum(known, table.HEADROOM * wind)
    asked = asked - law[table.LEAN_TRUST] * D
    most = np.where(peak < np.inf, np.minimum(reach, np.maximum(asked, 0.0)), reach)
    turn = table.SLOW_LOOP * slow
    lean = np.minimum(most + np.maximum(turn, 0.0), felt + turn)
    lean = np.maximum(lean, np.minimum(turn, 0.0) - most)
    spare = table.FAST_FIRST * D
    lean = np.where(felt > 0.0, np.maximum(lean, felt - spare), lean)
    lean = np.where(felt < 0.0, np.minimum(lean, felt + spare), lean)
    low, high = -reach, reach
    ratio = law[table.LEAN_RATIO]
    two = ratio > 0.0
    if np.any(two):
        x = np.clip(slow / reach, -table.EDGE, table.EDGE)
        power = 1.0 / np.where(two, ratio, 1.0)
        low = np.where(two, reach * (2.0 * ((1.0 + x) / 2.0) ** power - 1.0), low)
        high = np.where(two, reach * (1.0 - 2.0 * ((1.0 - x) / 2.0) ** power), high)
    return np.minimum(np.maximum(lean, low), high)


def switched(law: FloatArray, asked: FloatArray, mode: FloatArray) -> FloatArray:
    """Return the modes that follow: engaged at the limit, or let go."""
    held = np.where(asked * mode > law[table.RELEASE], mode, 0.0)
    beyond = np.abs(asked) >= law[table.ENGAGE]
    return np.where((held == 0.0) & beyond, np.sign(asked), held)


def inside(law: FloatArray, states: FloatArray) -> tuple[NDArray[np.bool_], FloatArray]:
    """Return which states ``(n, m)`` are recoverable, and the larger of their coordinates."""
    n = len(states)
    fast = (law[table.FAST : table.FAST + n] * states).sum(axis=0)
    slow = (law[table.SLOW : table.SLOW + n] * states).sum(axis=0)
    reach, ratio = law[table.REACH], law[table.RATIO]
    part = np.clip(fast / reach, -1.0, 1.0)
    low = reach * (1.0 - 2.0 * ((1.0 - part) / 2.0) ** ratio)
    high = reach * (2.0 * ((1.0 + part) / 2.0) ** ratio - 1.0)
    between = (low < slow) & (slow < high)
    recoverable = (np.abs(fast) < reach) & ((ratio == 0.0) | between)
    return recoverable, np.maximum(np.abs(fast), np.abs(slow))


def judged(
    law: FloatArray,
    states: FloatArray,
    now: FloatArray,
    fate: NDArray[np.int64],
    quiet: FloatArray,
) -> tuple[NDArray[np.int64], FloatArray]:
    """Return what is known of fates after the winds, and since when flights have been calm [s]."""
    reach = law[table.REACH]
    due = (now >= law[table.END]) & (fate == table.UNDECIDED) & ~np.isnan(reach)
    if not np.any(due):
        return fate, quiet
    recoverable, size = inside(law, states)
    quiet = np.where(due & (size >= table.SETTLED * reach), now, quiet)
    calm = np.where(now - quiet >= law[table.CALM], table.SURVIVED, table.UNDECIDED)
    return np.where(due, np.where(recoverable, calm, table.LOST), fate), quiet
