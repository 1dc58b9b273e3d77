"""Control laws as kernels, from the numbers of each law, and the edges of recoverable sets.

A law that is linear in its measurements is its gains. The recoverable-attitude law lets the
coordinate z of the fast unstable mode follow a lean Z, as in `laws.recoverable`.
"""

import math
from typing import Any, NamedTuple

from tvclin.base.arrays import FloatArray, Real
from tvclin.kernels.source import allocation_free, inlined, kernel

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
"""Ratio r of the poles from which on the edge of the recoverable set for r = 4 lies inside it."""
_DRIFT_RATE, _DRIFT, _ACCELERATION = 5, 6, 7
"""Index of drift rate [m/s], drift [m] and lateral acceleration [m/s^2] in the measurements."""
_ESTIMATED_RATE, _ESTIMATED_WIND, _ESTIMATES = 0, 1, 2
"""Index of the estimates of attitude rate, and of wind plus path angle, in the states of a law; and
their number."""
_MAX_REACH_ITERATIONS = 100
"""Largest number of Newton iterations; about ten suffice unless the path is nearly an edge."""
_LAST_RELATIVE_STEP = 2.0**-51
"""Last relative step: two roundings."""


REACH_PLAIN, REACH_COMPILED = 5e-5, 5e-7
"""Seconds per reach, in plain Python and as machine code."""


class LawNumbers(NamedTuple):
    """Numbers of a law: gains on measurements and on its state, or of a lean into the wind.

    The gains, deflection over the measurement, are `attitude` ... `acceleration`. `engage` and
    `release` are over the deflection limit. With `leans`, the rows of the fast and of the slow
    coordinate [rad] on attitude, its rate and path angle (zeros without one), `ratio` of slow to
    fast pole (or zero), `wind`, the factor k of the wind angle w in z' = s (z - u - k w), B, trim
    deflection per angle of attack, and numbers of the law, see `lean_demand` and `lean_command`;
    `peak` [rad] is infinite without a design peak, and `rate_travel`, `reach` times the rate limit
    over B and the fast pole [rad], without a rate limit. With `estimates` the first two states are
    attitude rate and wind plus path angle, which replace the measurements, and the law's own state
    follows them.
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

    `law`: `LawNumbers`, or a row of an array with their fields: gains on the measurements, or where
    `law.leans` numbers of `lean_demand`, the recoverable-attitude law. `measured`: attitude, its
    rate, flight path angle, angle of attack, deflection [rad, rad/s], drift rate, drift [m/s, m]
    and lateral acceleration [m/s^2], ``(8,)``. `states`: of the law, ``(s,)``, of which the first
    has the gain `first_state`; behind the attitude rate and the wind plus path angle of an
    estimator, which replace the measured ones, where `law.estimates`.
    `limit`: deflection limit [rad].
    """
    theta, rate, path, alpha = measured[0], measured[1], measured[2], measured[3]
    wind_and_path, state = theta - alpha, 0  # index of the law's own first state
    if law.estimates:
        rate, wind_and_path = states[_ESTIMATED_RATE], states[_ESTIMATED_WIND]
        state = _ESTIMATES
        alpha = theta - wind_and_path
    if law.leans:
        return lean_demand(law, theta, rate, path, wind_and_path, limit)
    demand = law.attitude * theta + law.attitude_rate * rate
    demand += law.flight_path_angle * path + law.angle_of_attack * alpha
    demand += law.drift_rate * measured[_DRIFT_RATE] + law.drift * measured[_DRIFT]
    demand += law.acceleration * measured[_ACCELERATION]
    return demand + law.first_state * states[state] if law.first_state != 0.0 else demand


@inlined
def lean_demand(
    law: Any, theta: float, rate: float, path: float, wind: float, limit: float
) -> float:
    """Return the deflection [rad] of the recoverable-attitude law, which leans into the wind.

    It is B u, u = z - k w + gain (z - Z), with the coordinate z of the fast unstable mode, its lean
    Z (`lean_command`), the wind angle w, and k = `law.wind`; so that z' = s (z - u - k w) with the
    pole s is s gain (Z - z), and z follows Z. `law`: `LawNumbers`; its `fast_...` and `slow_...`
    are the rows of z and of the slow coordinate, its `rate_travel` is R of `recovery_travel`.
    `theta`, `rate`: attitude [rad] and its rate [rad/s]. `path`: flight path angle [rad]. `wind`:
    attitude less angle of attack [rad], the wind angle plus the path angle. `limit`: deflection
    limit [rad].

    With a known rate limit u is bounded twice. The feedback is at most R(|error|) - |error|, from
    where a return at that rate ends as the error does. And u keeps z where a travel at that rate,
    to the fraction `law.reach` of the limit, recovers it if the wind stops, on either side.
    """
    wind = wind - path  # the wind angle [rad]
    size = max(abs(wind) - law.dead_band, 0.0)  # that is felt
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

    The unstable coordinate obeys z' = s (z - u), u the deflection over B. `room`: D - z [rad].
    `rate_travel`: R [rad], the travel at the full rate in a time constant 1/s. If u moves to D at
    that rate and stays there, z up to u + R (1 - e^(-x)) is recovered, x = (D - u)/R being the time
    of the travel over 1/s: the root of x - 1 + e^(-x) = room/R, by Newton's steps from above.
    Reversed, it is the u from which a return at that rate ends together with z = `room`.
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

    Z is the value that the coordinate of the fast unstable mode shall take. `law`: `LawNumbers`.
    `slow`: slow coordinate z2 [rad]. `wind_term`: k w [rad], the deflection over B that w calls
    for, with k = `law.wind`. `wind`: size of the wind angle w [rad]. `D`: deflection limit over B
    [rad].

    Z = k w + 3 z2, with ``|Z| <= M`` = min(reach D, k max(A, 1.1 |w|) - trust D), A being the
    design peak `law.peak`, extended by the contribution of the slow coordinate z2; `reach` and
    `trust` are fractions of the limit. Z differs from k w by at most 0.9 D, so that the remaining
    limit stabilises the fast mode; and Z lies in the recoverable set with z2, where there are two
    modes (`law.ratio`, slow over fast pole, not zero).
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

    `lean`, `slow`: coordinates of the fast and of the slow mode, over the largest recoverable one.
    `power`: r, the ratio of the fast to the slow pole, above one. The edges for x = slow, which
    lies between them, are 2 ((1 + x)/2)^r - 1 and its mirror image 1 - 2 ((1 - x)/2)^r. For r >= 4
    the power is computed only beyond the edge for r = 4, which lies inside that for r.
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
    """Return the next mode: +1 or -1 while the whole limit is commanded with that sign, else 0.

    `engage`, `release`: sizes of the demand [rad] from which the whole limit is commanded, and down
    to which it stays commanded. `demand`: deflection that the law demands [rad]. `mode`: the mode
    before.
    """
    if not demand * mode > release:
        mode = 0.0
    if mode == 0.0 and abs(demand) >= engage:
        mode = 1.0 if demand > 0.0 else -1.0
    return mode


@kernel
def slow_edges(fast: Real, ratio: Real) -> tuple[Real, Real]:
    """Return both edges of the recoverable set, bounds of the slow coordinate for a fast one.

    `fast`, `ratio`: fast coordinate x in [-1, 1], and ratio r of the slow to the fast pole, numbers
    or arrays. All coordinates are over the largest recoverable one. The edges are the paths that
    reach equilibrium with one change of the limit's sign: 1 - 2 ((1 - x)/2)^r, the lower one and
    first result, and its mirror image.
    """
    return 1.0 - 2.0 * ((1.0 - fast) / 2.0) ** ratio, 2.0 * ((1.0 + fast) / 2.0) ** ratio - 1.0


@kernel
def minimum_reaches(
    fast: FloatArray, slow: FloatArray, ratio: FloatArray, out: FloatArray, first: int, last: int
) -> None:
    """Write the smallest reach with which two unstable coordinates are recoverable, ``out (n,)``.

    The reach is the largest coordinate of a mode that the deflection limit brings back to zero;
    with the smallest, the pair lies on the edge of the recoverable set. `fast`, `slow`, `ratio`:
    coordinates, in the unit of the reach, and the ratio of the slow to the fast pole, ``(n,)``
    each. Cases from `first` up to `last` are computed.
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


@allocation_free
def _recoverable_fraction(z: float, w: float, power: float) -> float:
    """Return the largest fraction of (z, w), at most one, that is recoverable.

    `z`, `w`: fast and slow coordinate over the reach. `power`: ratio r of the fast to the slow
    pole. The set ends at z = 2 ((1 + w)/2)^r - 1. The margin above that edge is concave in the
    fraction and positive at zero, so that Newton's steps from beyond its zero converge from above.
    """
    fraction = 1.0  # of (z, w)
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
