"""Control laws as kernels, from the numbers of each law, and the edges of recoverable sets.

A law that is linear in its measurements is its gains. The recoverable-attitude law lets the
coordinate z of the fast unstable mode follow a lean Z, as in `laws.recoverable`.
"""

import math
from typing import Any, NamedTuple

from tvclin.kernels.source import bare, inlined, kernel

MAX_SLOW_COORDINATE = 0.9999
"""Largest slow coordinate, over its reach, that the law assumes."""
WIND_FACTOR = 1.1
"""Factor by which a felt wind beyond the design peak is assumed stronger."""
FAST_LIMIT_FRACTION = 0.9
"""Fraction of the limit for the fast mode against the felt wind."""
SLOW_LOOP_GAIN = 3.0
"""Gain of the slow mode's outer loop, in units of its coordinate."""
_RECOVERY_ITERATIONS = 5
"""Newton iterations: the first guess is within a third, and convergence is quadratic."""
_BOUND_POWER = 4.0
"""Exponent beyond which (1 - x)^4 bounds the edge of the recoverable set."""
_MAX_REACH_ITERATIONS = 100
"""Largest number of Newton iterations; about ten suffice unless the path is nearly an edge."""
_LAST_RELATIVE_STEP = 2.0**-51
"""Last relative step: two roundings."""


REACH_PLAIN, REACH_COMPILED = 5e-5, 5e-7
"""Seconds per reach, in plain Python and as machine code."""


class LawNumbers(NamedTuple):
    """Numbers of a law: gains on measurements and on its state, or of a lean into the wind.

    `engage` and `release` are over the deflection limit. With `leans`, the rows of the fast and of
    the slow coordinate (zeros without one), `ratio` of slow and fast pole (or zero), the wind per
    angle, B, and the law's own numbers; `peak` is infinite without a design peak, and
    `rate_travel`, `reach` times the rate limit over B and the fast pole [rad], without a rate
    limit. With `estimates` the first two states are attitude rate and wind, which replace the
    measurements, and the law's own state follows them.
    """

    attitude: float = 0.0
    attitude_rate: float = 0.0
    flight_path_angle: float = 0.0
    angle_of_attack: float = 0.0
    first_state: float = 0.0
    drift_rate: float = 0.0
    drift: float = 0.0
    acceleration: float = 0.0
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
    rate_travel: float = math.inf
    estimates: bool = False


@inlined
def law_demand(law: Any, measured: Any, states: Any, limit: float) -> float:
    """Return the deflection that a law demands [rad].

    `law`: `LawNumbers`, or a row of an array with their fields. `measured`: measurements in the
    order of `laws.Measurement`: attitude, its rate, path angle, angle of attack, deflection, drift
    rate, drift, acceleration. `states`: states of the law. `limit`: the deflection limit [rad].
    """
    if law.leans:
        if law.estimates:
            return lean_demand(law, measured[0], states[0], measured[2], states[1], limit)
        return lean_demand(
            law, measured[0], measured[1], measured[2], measured[0] - measured[3], limit
        )
    rate, alpha, state = measured[1], measured[3], 0
    if law.estimates:
        rate, alpha, state = states[0], measured[0] - states[1], 2
    demand = law.attitude * measured[0] + law.attitude_rate * rate
    demand += law.flight_path_angle * measured[2] + law.angle_of_attack * alpha
    demand += law.drift_rate * measured[5] + law.drift * measured[6]
    demand += law.acceleration * measured[7]
    return demand + law.first_state * states[state] if law.first_state != 0.0 else demand


@inlined
def lean_demand(
    law: Any, theta: float, rate: float, path: float, wind: float, limit: float
) -> float:
    """Return the deflection u = z - k w + gain (z - Z) [rad], times B, of a law that leans.

    z is the coordinate of the fast unstable mode, Z its lean, w the wind angle and k the demand per
    wind angle. `law`: `LawNumbers`. `theta`, `rate`: attitude [rad] and its rate [rad/s]. `path`:
    flight path angle [rad]. `wind`: attitude less angle of attack [rad], the wind angle plus the
    path angle. `limit`: deflection limit [rad].

    With it z' = s (z - u - k w) of `boundary.recoverable` is s gain (Z - z): z follows Z. With a
    known rate limit the feedback is bounded so that it can be reversed in time, and u so that z is
    recoverable if the wind stops.
    """
    wind = wind - path
    size = max(abs(wind) - law.dead_band, 0.0)
    wind_term = law.wind * (-size if wind < 0.0 else size)
    fast = law.fast_attitude * theta + law.fast_rate * rate + law.fast_path * path
    slow = law.slow_attitude * theta + law.slow_rate * rate + law.slow_path * path
    D = limit / abs(law.B)
    error = fast - lean_command(law, slow, wind_term, size, D)
    feedback = law.gain * error
    if law.rate_travel < math.inf:
        reach = law.reach * D
        max_feedback = recovery_travel(abs(error), law.rate_travel) - abs(error)
        feedback = fast - wind_term + min(max(feedback, -max_feedback), max_feedback)
        feedback = max(feedback, reach - recovery_travel(reach - fast, law.rate_travel))
        return law.B * min(feedback, recovery_travel(reach + fast, law.rate_travel) - reach)
    return law.B * (fast - wind_term + feedback)


@inlined
def recovery_travel(room: float, rate_travel: float) -> float:
    """Return the largest travel D - u of a deflection to its limit D that recovers z without wind.

    `room`: D - z [rad]. `rate_travel`: R [rad], the travel at the full rate in a time constant of
    the fast mode. At that rate to D, and constant there, z up to u + R (1 - e^(-x)) is recovered, x
    = (D - u)/R: the root of x - 1 + e^(-x) = room/R, by Newton's steps from above. It is also the u
    from which that rate comes to an end together with z = `room`.
    """
    q = max(room, 0.0) / rate_travel
    x = q + math.sqrt(2.0 * q)
    for _ in range(_RECOVERY_ITERATIONS):
        slope = -math.expm1(-x)
        if slope > 0.0:
            x -= (x - slope - q) / slope
    return rate_travel * x


@inlined
def lean_command(law: Any, slow: float, wind_term: float, wind: float, D: float) -> float:
    """Return the lean Z [rad] that the wind, the recoverable set and the design wind allow.

    `law`: `LawNumbers`. `slow`: slow coordinate z2 [rad]. `wind_term`: k w [rad], the demand of the
    wind, with k = `law.wind`. `wind`: size of the wind angle w [rad]. `D`: deflection limit over B
    [rad].

    Z = k w + 3 z2, with ``|Z| <= M`` = min(reach D, k max(A, 1.1 |w|) - trust D), A being the
    design peak, extended by the contribution of the slow coordinate z2. Z differs from k w by at
    most 0.9 D, so that the remaining limit stabilises the fast mode; and Z lies in the recoverable
    set with z2.
    """
    reach = law.reach * D
    max_lean = reach
    if law.peak < math.inf:
        required = law.wind * max(law.peak, WIND_FACTOR * wind) - law.trust * D
        max_lean = min(reach, max(required, 0.0))
    slow_term = SLOW_LOOP_GAIN * slow
    lean = min(max_lean + max(slow_term, 0.0), wind_term + slow_term)
    lean = max(lean, min(slow_term, 0.0) - max_lean)
    if wind_term > 0.0:
        lean = max(lean, wind_term - FAST_LIMIT_FRACTION * D)
    elif wind_term < 0.0:
        lean = min(lean, wind_term + FAST_LIMIT_FRACTION * D)
    if law.ratio == 0.0:
        return min(max(lean, -reach), reach)
    x = min(max(slow / reach, -MAX_SLOW_COORDINATE), MAX_SLOW_COORDINATE)
    return reach * bounded_coordinate(lean / reach, x, 1.0 / law.ratio)


@inlined
def bounded_coordinate(lean: float, slow: float, power: float) -> float:
    """Return the fast coordinate `lean` bounded by the edges of the recoverable set.

    `lean`, `slow`: coordinates of the fast and of the slow mode, over the reach. `power`: r, the
    ratio of the fast to the slow pole, above one. The edges for x = slow, which it lies between,
    are 2 ((1 + x)/2)^r - 1 and 1 - 2 ((1 - x)/2)^r; a power is computed only where r = 1 or 4 does
    not decide.
    """
    above = lean > slow
    if not above:
        lean, slow = -lean, -slow
    q = 0.5 * (1.0 - slow)
    square = q * q
    if power < _BOUND_POWER or lean > 1.0 - 2.0 * square * square:
        lean = min(lean, 1.0 - 2.0 * q**power)
    return lean if above else -lean


@inlined
def next_mode(engage: float, release: float, demand: float, mode: float) -> float:
    """Return the next mode: +1 or -1 while the whole limit is commanded, else 0.

    `engage`, `release`: sizes of the demand [rad] from which the whole limit is commanded, and
    below which it is released. `demand`: of the law [rad]. `mode`: the mode before.
    """
    if not demand * mode > release:
        mode = 0.0
    if mode == 0.0 and abs(demand) >= engage:
        mode = 1.0 if demand > 0.0 else -1.0
    return mode


@kernel
def slow_edges(fast: Any, ratio: Any) -> Any:
    """Return the edges of the recoverable set: bounds of the slow coordinate for a fast one.

    All over the reach. `fast`, `ratio`: fast coordinate x in [-1, 1], and ratio r of slow and fast
    pole, numbers or arrays. The edges are the paths that reach equilibrium with one switch, 1 - 2
    ((1 - x)/2)^r and its mirror image.
    """
    return 1.0 - 2.0 * ((1.0 - fast) / 2.0) ** ratio, 2.0 * ((1.0 + fast) / 2.0) ** ratio - 1.0


@kernel
def minimum_reaches(fast: Any, slow: Any, ratio: Any, out: Any, first: int, last: int) -> None:
    """Write the smallest reach with two unstable coordinates in the recoverable set, ``out (n,)``.

    The reach is the largest coordinate that the deflection limit recovers; with the smallest, both
    lie on the edge of the set. `fast`, `slow`, `ratio`: the coordinates and the ratio of the slow
    to the fast pole, ``(n,)`` each (see `boundary.recoverable`). Cases from `first` up to `last`
    are computed.
    """
    for case in range(first, last):
        z, w = fast[case], slow[case]
        size = max(abs(z), abs(w))
        out[case] = size
        if size > 0.0:
            z, w, power = z / size, w / size, 1.0 / ratio[case]
            out[case] = size / min(
                _recoverable_fraction(z, w, power), _recoverable_fraction(-z, -w, power)
            )


@bare
def _recoverable_fraction(z: float, w: float, power: float) -> float:
    """Return the largest fraction of (z, w), at most one, on the recoverable side of a path.

    `z`, `w`: fast and slow coordinate over the reach. `power`: ratio of the fast to the slow pole.
    The side is z > 2 ((1 + w)/2)^power - 1. The margin is concave in the fraction and first
    positive, so that Newton's steps from beyond converge to the end from above.
    """
    fraction = 1.0
    for _ in range(_MAX_REACH_ITERATIONS):
        base = 0.5 * (1.0 + fraction * w)
        power_term = base ** (power - 1.0) if base > 0.0 else 0.0
        margin = 1.0 + fraction * z - 2.0 * power_term * base
        slope = z - power * power_term * w
        if margin >= 0.0 or slope >= 0.0:
            break
        step = margin / slope
        fraction -= step
        if step <= _LAST_RELATIVE_STEP * fraction:
            break
    return fraction
