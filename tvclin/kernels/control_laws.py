"""What the laws of this package ask for, from the numbers that each gives of itself.

A law that is linear in what it sees is its gains. The recoverable-attitude law follows a lean Z
with the coordinate z of the fast unstable mode, as `laws.recoverable` says it.
"""

import math
from typing import Any, NamedTuple

from tvclin.kernels.source import inlined, kernel

EDGE = 0.9999
"""A slow coordinate is taken for no nearer than this to the end of its reach."""
HEADROOM = 1.1
"""A wind felt beyond the design peak is taken for so many times as strong."""
FAST_FIRST = 0.9
"""Part of the limit that the fast mode may need against the felt wind."""
SLOW_LOOP = 3.0
"""Gain of the slow mode's outer loop, in units of its coordinate."""
_NEWTON = 5
"""Steps: all digits, since the first guess is within a third and the steps are quadratic."""
_POWER = 4.0
"""For exponents beyond this, (1 - x)^4 bounds the edge of the recoverable set."""


class LawNumbers(NamedTuple):
    """One law: gains on what is measured and on a state of its own, or those of a lean.

    `engage` and `release` are over the deflection limit. With `leans`, the rows of the fast and
    of the slow coordinate (zeros where there is none), `ratio` of slow and fast pole (or zero),
    the strength of the wind, B, and the law's own numbers; `peak` is infinite without a design
    peak, and `swing`, `reach` times the rate limit over B and the fast pole [rad], without that.
    With `estimates` the first two states are attitude rate and wind, to be used in place of what is
    measured, and the law's own state comes behind them.
    """

    attitude: float = 0.0
    attitude_rate: float = 0.0
    flight_path_angle: float = 0.0
    angle_of_attack: float = 0.0
    first_state: float = 0.0
    engage: float = 1.0
    release: float = 1.0
    leans: bool = False
    fast_attitude: float = 0.0
    fast_rate: float = 0.0
    fast_path: float = 0.0
    slow_attitude: float = 0.0
    slow_rate: float = 0.0
    slow_path: float = 0.0
    ratio: float = 0.0
    wind: float = 0.0
    B: float = 1.0
    reach: float = 0.0
    gain: float = 0.0
    peak: float = math.inf
    trust: float = 0.0
    dead_band: float = 0.0
    swing: float = math.inf
    estimates: bool = False


@inlined
def asked(law: Any, measured: Any, states: Any, limit: float) -> float:
    """Return the deflection asked for [rad].

    `law`: or a row of an array with its fields. `measured`: attitude, rate, flight path angle and
    angle of attack, as of `laws.Measurement`. `states`: the law's own. `limit`: the deflection
    limit [rad].
    """
    if law.leans:
        if law.estimates:
            return leaning(law, measured[0], states[0], measured[2], states[1], limit)
        return leaning(law, measured[0], measured[1], measured[2], measured[0] - measured[3], limit)
    rate, alpha, own = measured[1], measured[3], 0
    if law.estimates:
        rate, alpha, own = states[0], measured[0] - states[1], 2
    found = law.attitude * measured[0] + law.attitude_rate * rate
    found += law.flight_path_angle * measured[2] + law.angle_of_attack * alpha
    return found + law.first_state * states[own] if law.first_state != 0.0 else found


@inlined
def leaning(law: Any, theta: float, rate: float, path: float, wind: float, limit: float) -> float:
    """Return u = z - k w + gain (z - Z), as a deflection; `wind` counts from the path too.

    With it z' = s (z - u - k w) of `boundary.recoverable` is s gain (Z - z): z follows Z. Where the
    rate limit is known the feedback is no larger than can be taken back in time, and u stays where
    z can be brought back if the wind stops.
    """
    wind = wind - path
    size = max(abs(wind) - law.dead_band, 0.0)
    felt = law.wind * (-size if wind < 0.0 else size)
    fast = law.fast_attitude * theta + law.fast_rate * rate + law.fast_path * path
    slow = law.slow_attitude * theta + law.slow_rate * rate + law.slow_path * path
    D = limit / abs(law.B)
    error = fast - leant(law, slow, felt, size, D)
    turn = law.gain * error
    if law.swing < math.inf:
        reach, most = law.reach * D, turned_back(abs(error), law.swing) - abs(error)
        turn = fast - felt + min(max(turn, -most), most)
        turn = max(turn, reach - turned_back(reach - fast, law.swing))
        return law.B * min(turn, turned_back(reach + fast, law.swing) - reach)
    return law.B * (fast - felt + turn)


@inlined
def turned_back(room: float, swing: float) -> float:
    """Return D - u for the furthest u from which D - z = `room` is brought back in still air.

    At the full rate R = `swing` to D, and held there, z up to u + R (1 - e^(-x)) is brought back,
    x = (D - u)/R: the root of x - 1 + e^(-x) = room/R, by Newton's steps from above. It is also the
    u from which that rate comes to rest together with z = `room`.
    """
    q = max(room, 0.0) / swing
    x = q + math.sqrt(2.0 * q)
    for _ in range(_NEWTON):
        slope = -math.expm1(-x)
        if slope > 0.0:
            x -= (x - slope - q) / slope
    return swing * x


@inlined
def leant(law: Any, slow: float, felt: float, wind: float, D: float) -> float:
    """Return Z: the lean that the wind, the recoverable set and the design wind allow.

    Z = k w + 3 z2, no further than M = min(reach D, k max(A, 1.1 |w|) - trust D) and beyond that by
    as much as the slow coordinate z2 asks for on its side. Z lags behind k w by 0.9 D at the most,
    so that the fast mode is held with what is left; and Z lies in the recoverable set with z2.
    """
    reach = law.reach * D
    most = reach
    if law.peak < math.inf:
        needed = law.wind * max(law.peak, HEADROOM * wind) - law.trust * D
        most = min(reach, max(needed, 0.0))
    turn = SLOW_LOOP * slow
    lean = min(most + max(turn, 0.0), felt + turn)
    lean = max(lean, min(turn, 0.0) - most)
    if felt > 0.0:
        lean = max(lean, felt - FAST_FIRST * D)
    elif felt < 0.0:
        lean = min(lean, felt + FAST_FIRST * D)
    if law.ratio == 0.0:
        return min(max(lean, -reach), reach)
    x = min(max(slow / reach, -EDGE), EDGE)
    return reach * bounded(lean / reach, x, 1.0 / law.ratio)


@inlined
def bounded(lean: float, slow: float, power: float) -> float:
    """Return a fast coordinate no further out than the edges that go with a slow one.

    All over the reach. The edges are 2 ((1 + x)/2)^r - 1 and 1 - 2 ((1 - x)/2)^r with r above
    one, and x between them; a power is computed only where r = 1 or 4 does not answer already.
    """
    above = lean > slow
    if not above:
        lean, slow = -lean, -slow
    q = 0.5 * (1.0 - slow)
    square = q * q
    if power < _POWER or lean > 1.0 - 2.0 * square * square:
        lean = min(lean, 1.0 - 2.0 * q**power)
    return lean if above else -lean


@inlined
def switched(engage: float, release: float, demand: float, mode: float) -> float:
    """Return the mode that follows: +1 or -1 while the whole limit is commanded, else 0.

    `engage` and `release` are deflections [rad].
    """
    if not demand * mode > release:
        mode = 0.0
    if mode == 0.0 and abs(demand) >= engage:
        mode = 1.0 if demand > 0.0 else -1.0
    return mode


@kernel
def slow_ends(fast: Any, ratio: Any) -> Any:
    """Return the ends of the slow coordinate that go with a fast one in [-1, 1], over the reach.

    They are the paths that end at rest with one switch, 1 - 2 ((1 - x)/2)^r and its mirror image.
    Numbers or arrays.
    """
    return 1.0 - 2.0 * ((1.0 - fast) / 2.0) ** ratio, 2.0 * ((1.0 + fast) / 2.0) ** ratio - 1.0
