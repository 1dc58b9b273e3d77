"""What 32 flights come to at the ends of their steps, and which may pass a limit or a peak there.

States at the ends are sums of their series, and their slopes are those of the equations. What is
made of them (the demand, the angle of attack, what the rate limit watches) needs a series of its
own only where it turns, or meets its limit, within the step.
"""

from typing import Any

from tvclin.kernels import flight_table as table
from tvclin.kernels.compiled import lanes
from tvclin.kernels.compiled.arc_series import drifted, pulled, turned
from tvclin.kernels.compiled.compiler import lean, merged
from tvclin.kernels.compiled.lanes import ALL, ORDER, at, row


@merged
def _sum(s, w, number, i, h):  # type: ignore[no-untyped-def]
    """Return a series at the end of a step, and write it."""
    total = s[at(number, ORDER) + i]
    for k in range(ORDER - 1, -1, -1):
        total = total * h + s[at(number, k) + i]
    w[row(lanes.VALUE + number) + i] = total
    return total


@merged
def _direct(s, i, h):  # type: ignore[no-untyped-def]
    """Return deflection, its slope and its curvature where the nozzle follows at once."""
    position, moves, bend = 0.0, 0.0, 0.0
    for k in range(ORDER, -1, -1):
        bend = bend * h + moves
        moves = moves * h + position
        position = position * h + s[at(lanes.SERVO, k) + i]
    return position, moves, 2.0 * bend


@merged
def _alpha_asked(w, i, path, theta, rate, gamma, memory, wind):  # type: ignore[no-untyped-def]
    """Return angle of attack and deflection asked for, or a term of each."""
    alpha = theta - wind
    asked = w[row(table.K_ATTITUDE) + i] * theta + w[row(table.K_RATE) + i] * rate
    if path:
        alpha -= gamma
        asked += w[row(table.K_PATH) + i] * gamma
    return alpha, asked + (w[row(table.K_ALPHA) + i] * alpha + w[row(table.K_MEMORY) + i] * memory)


@merged
def _watched(w, i, servo, asked, position, spin):  # type: ignore[no-untyped-def]
    """Return what the rate limit watches, but for what is constant, or a term of it."""
    watch = w[row(lanes.WATCH_ASKED) + i] * asked + w[row(lanes.WATCH_SERVO) + i] * position
    return watch + w[row(lanes.WATCH_SPIN) + i] * spin if servo == 2 else watch


@merged
def _term(s, w, i, servo, path, k):  # type: ignore[no-untyped-def]
    """Return a term of demand, angle of attack, and what the rate limit watches."""
    theta, rate, gamma = s[at(lanes.THETA, k) + i], s[at(lanes.RATE, k) + i], 0.0
    if path:
        gamma = s[at(lanes.PATH, k) + i]
    memory, wind = s[at(lanes.MEMORY, k) + i], s[at(lanes.WIND, k) + i]
    alpha, asked = _alpha_asked(w, i, path, theta, rate, gamma, memory, wind)
    if servo == 0:
        return asked, alpha, (k + 1.0) * s[at(lanes.SERVO, k + 1) + i]
    position, spin = s[at(lanes.SERVO, k) + i], s[at(lanes.SPIN, k) + i]
    watch = _watched(w, i, servo, asked, position, spin)
    return asked, alpha, watch + w[row(lanes.WATCHED) + i] if k == 0 else watch


@lean
def whole(s, w, i, number, servo):  # type: ignore[no-untyped-def]
    """Return where a series of a lane begins; write what is not yet written of it."""
    if number < lanes.DEMAND:
        return at(number, 0) + i
    if number == lanes.WATCH and servo == 2 and w[row(lanes.FREE) + i] != 0.0:
        return at(lanes.SPIN, 0) + i
    for k in range(2, ORDER + 1):
        if number == lanes.DEMAND:
            s[at(number, k) + i] = _term(s, w, i, servo, True, k)[0]
        elif number == lanes.ALPHA:
            s[at(number, k) + i] = _term(s, w, i, servo, True, k)[1]
        elif number == lanes.WATCH:
            s[at(number, k) + i] = _term(s, w, i, servo, True, k)[2]
    return at(number, 0) + i


def _closing(servo: int, path: bool) -> Any:
    """Return the kernel of a nozzle of that order, and of a plant whose path turns or does not."""

    @lean
    def ends(s, w, first, last):  # type: ignore[no-untyped-def]
        """Write how some lanes begin their steps, and what they come to."""
        value, slope = lanes.VALUE, lanes.SLOPE
        for i in range(first, last):
            for k in range(2):
                asked, alpha, watch = _term(s, w, i, servo, path, k)
                s[at(lanes.DEMAND, k) + i], s[at(lanes.ALPHA, k) + i] = asked, alpha
                s[at(lanes.WATCH, k) + i] = watch
            h = w[row(lanes.STEP) + i]
            wind, gusts = w[row(value + lanes.WIND) + i], w[row(slope + lanes.WIND) + i]
            theta, rate = _sum(s, w, lanes.THETA, i, h), _sum(s, w, lanes.RATE, i, h)
            memory = _sum(s, w, lanes.MEMORY, i, h)
            gamma, speed, drift, spin = 0.0, 0.0, 0.0, 0.0
            if path:
                gamma, speed = _sum(s, w, lanes.PATH, i, h), _sum(s, w, lanes.SPEED, i, h)
            if servo:
                position = _sum(s, w, lanes.SERVO, i, h)
                if servo == 2:
                    spin = _sum(s, w, lanes.SPIN, i, h)
                pull = pulled(w, i, path, theta, rate, gamma, memory, position, spin)
                pull += w[row(lanes.PULL_GUST) + i] * wind + w[row(lanes.PULL) + i]
                moves = spin if servo == 2 else pull
            else:
                position, moves, watch_rise = _direct(s, i, h)
            turn = turned(w, i, path, theta, gamma, position)
            turn += w[row(table.GUST) + i] * wind + w[row(lanes.TURN) + i]
            if path:
                drift = drifted(w, i, theta, gamma, speed, position)
                drift += w[row(table.PATH_GUST) + i] * wind + w[row(lanes.DRIFT) + i]
            alpha, asked = _alpha_asked(w, i, path, theta, rate, gamma, memory, wind)
            alpha_rise, asked_rise = _alpha_asked(w, i, path, rate, turn, drift, theta, gusts)
            watch = moves
            if servo:
                watch = _watched(w, i, servo, asked, position, spin) + w[row(lanes.WATCHED) + i]
                watch_rise = _watched(w, i, servo, asked_rise, moves, pull)
            w[row(value + lanes.SERVO) + i], w[row(slope + lanes.SERVO) + i] = position, moves
            w[row(value + lanes.DEMAND) + i], w[row(slope + lanes.DEMAND) + i] = asked, asked_rise
            w[row(value + lanes.ALPHA) + i], w[row(slope + lanes.ALPHA) + i] = alpha, alpha_rise
            w[row(value + lanes.WATCH) + i], w[row(slope + lanes.WATCH) + i] = watch, watch_rise
            w[row(slope + lanes.THETA) + i], w[row(slope + lanes.RATE) + i] = rate, turn

    return ends


_DIRECT, _FIRST, _SECOND = (_closing(servo, False) for servo in range(3))
_DIRECT_PATH, _FIRST_PATH, _SECOND_PATH = (_closing(servo, True) for servo in range(3))


@lean
def ends(s, w, order, servo, degree, first, last):  # type: ignore[no-untyped-def]
    """Write values and slopes of what some lanes come to at the ends of their steps."""
    wind, gusts = row(lanes.VALUE + lanes.WIND), row(lanes.SLOPE + lanes.WIND)
    for i in range(first, last):
        w[wind + i], w[gusts + i] = s[at(lanes.WIND, degree) + i], 0.0
    for k in range(degree - 1, -1, -1):
        start = at(lanes.WIND, k)
        for i in range(first, last):
            h, total = w[row(lanes.STEP) + i], w[wind + i]
            w[gusts + i] = w[gusts + i] * h + total
            w[wind + i] = total * h + s[start + i]
    if servo == 2 and order > 2:
        _SECOND_PATH(s, w, first, last)
    elif servo == 2:
        _SECOND(s, w, first, last)
    elif servo == 1 and order > 2:
        _FIRST_PATH(s, w, first, last)
    elif servo == 1:
        _FIRST(s, w, first, last)
    elif order > 2:
        _DIRECT_PATH(s, w, first, last)
    else:
        _DIRECT(s, w, first, last)


@merged
def _leaves(s, w, i, number, low_):  # type: ignore[no-untyped-def]
    """Tell whether a series may leave its bounds within the step."""
    low, high, h = w[row(low_) + i], w[row(low_ + 1) + i], w[row(lanes.STEP) + i]
    rise, fall = s[at(number, 1) + i], w[row(lanes.SLOPE + number) + i]
    end = w[row(lanes.VALUE + number) + i]
    one, other = s[at(number, 0) + i] + rise * h, end - fall * h
    turns = (rise * fall < 0.0) & ((max(one, other) > high) | (min(one, other) < low))
    return turns | (end > high) | (end < low)


@merged
def leaving(s, w, servo):  # type: ignore[no-untyped-def]
    """Flag the lanes in which what has bounds may leave them within the step."""
    for i in range(ALL):
        out = _leaves(s, w, i, lanes.DEMAND, lanes.DEMAND_LOW)
        if servo:
            out |= _leaves(s, w, i, lanes.SERVO, lanes.SERVO_LOW)
            out |= _leaves(s, w, i, lanes.WATCH, lanes.WATCH_LOW)
        w[row(lanes.FLAG) + i] = 1.0 if out else 0.0


@merged
def _tops(s, w, i, number, top, share):  # type: ignore[no-untyped-def]
    """Raise a largest size by the ends of the step; tell whether there is a summit between."""
    h, rise, fall = w[row(lanes.STEP) + i], s[at(number, 1) + i], w[row(lanes.SLOPE + number) + i]
    begin, end = s[at(number, 0) + i], w[row(lanes.VALUE + number) + i]
    one, other = begin + rise * h, end - fall * h
    known = max(w[row(top) + i], share * max(abs(begin), abs(end)))
    w[row(top) + i] = known
    inside = max(one, other) if rise > 0.0 else -min(one, other)
    return (rise * fall < 0.0) & (share * inside > known)


@merged
def topping(s, w):  # type: ignore[no-untyped-def]
    """Raise the largest sizes by the ends of the steps; flag lanes with summits between.

    Each size has a bit of the flag. What pulls at a nozzle that is held is no rate.
    """
    for i in range(ALL):
        free = w[row(lanes.FREE) + i]
        flag = 1.0 if _tops(s, w, i, lanes.THETA, lanes.TOP_THETA, 1.0) else 0.0
        flag += 2.0 if _tops(s, w, i, lanes.RATE, lanes.TOP_RATE, 1.0) else 0.0
        flag += 4.0 if _tops(s, w, i, lanes.SERVO, lanes.TOP_SERVO, 1.0) else 0.0
        flag += 8.0 if _tops(s, w, i, lanes.WATCH, lanes.TOP_WATCH, free) else 0.0
        flag += 16.0 if _tops(s, w, i, lanes.ALPHA, lanes.TOP_ALPHA, 1.0) else 0.0
        w[row(lanes.FLAG) + i] = flag


@lean
def advance(s, w, degree):  # type: ignore[no-untyped-def]
    """Move all lanes to the ends of their steps; the wind has the degree of its pieces."""
    for i in range(ALL):
        h = w[row(lanes.STEP) + i]
        w[row(lanes.NOW) + i] += h
        w[row(lanes.LEFT) + i] -= h
        w[row(lanes.FULL) + i] += (1.0 - w[row(lanes.COMMANDED) + i]) * h
        for number in range(lanes.WIND + 1):
            s[at(number, 0) + i] = w[row(lanes.VALUE + number) + i]
    for low in range(degree):
        for k in range(degree - 1, max(low, 1) - 1, -1):
            for i in range(ALL):
                s[at(lanes.WIND, k) + i] += s[at(lanes.WIND, k + 1) + i] * w[row(lanes.STEP) + i]
