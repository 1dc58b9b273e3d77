"""What happens to one lane: limits are reached and left, knots passed, the flight judged."""

import numpy as np

from tvclin.kernels import flight_table as table
from tvclin.kernels.compiled import lanes
from tvclin.kernels.compiled.arc_ends import ends, whole
from tvclin.kernels.compiled.arc_roots import root, turn
from tvclin.kernels.compiled.compiler import lean, merged
from tvclin.kernels.compiled.lanes import ALL, at, row

_SIDES = 3
"""Series that have bounds: the demand, the nozzle, and what watches its rate."""


@merged
def _exit(s, w, number, i, low, high, servo):  # type: ignore[no-untyped-def]
    """When a series first leaves its bounds within the step, and to which side; or inf, 0."""
    h = w[row(lanes.STEP) + i]
    begun, rise = s[at(number, 0) + i], s[at(number, 1) + i]
    end, fall = w[row(lanes.VALUE + number) + i], w[row(lanes.SLOPE + number) + i]
    inside, turns = low <= end <= high, rise * fall < 0.0
    last, top, steep = h, end, fall
    one, other = begun + rise * h, end - fall * h
    if inside and not (turns and (max(one, other) > high or min(one, other) < low)):
        return np.inf, 0.0
    start = whole(s, w, i, number, servo)
    if inside:
        last, top = turn(s, start, h, end, rise, fall)
        steep = 0.0
        if not (top > high + table.GRAZE * abs(high) or top < low - table.GRAZE * abs(low)):
            return np.inf, 0.0
    side = 1.0 if top > high else -1.0
    edge = high if side > 0.0 else low
    dips = side * rise < 0.0 < side * fall
    graze = table.GRAZE * max(abs(edge), abs(end)) if dips else 0.0
    if side * (begun - edge) < -graze:
        return root(s, start, 0.0, last, begun - edge, top - edge, (rise, steep), edge), side
    if not dips:
        return 0.0, side
    inner, bottom = turn(s, start, h, end, rise, fall)
    if side * (bottom - edge) >= 0.0:
        return 0.0, side
    return root(s, start, inner, h, bottom - edge, end - edge, (0.0, fall), edge), side


@merged
def _sooner(s, w, number, low, i, servo, found):  # type: ignore[no-untyped-def]
    """Return the first limit of a lane: what, side and time of the one that is known, or this."""
    if number == found[0]:
        return found
    t, side = _exit(s, w, number, i, w[row(low) + i], w[row(low + 1) + i], servo)
    return (number, side, t) if t < found[2] else found


@lean
def meet(s, w, i, order, servo, degree):  # type: ignore[no-untyped-def]
    """Shorten a lane's step to the first limit it meets; return what and which side, or -1.

    Looked for again: a step that one limit makes shorter may end beyond another.
    """
    found = (-1, 0.0, np.inf)
    for _ in range(_SIDES):
        before = found[0]
        found = _sooner(s, w, lanes.DEMAND, lanes.DEMAND_LOW, i, servo, found)
        if servo > 0:
            found = _sooner(s, w, lanes.SERVO, lanes.SERVO_LOW, i, servo, found)
            found = _sooner(s, w, lanes.WATCH, lanes.WATCH_LOW, i, servo, found)
        if found[0] == before:
            break
        w[row(lanes.STEP) + i] = found[2]
        ends(s, w, order, servo, degree, i, i + np.uint64(1))
    return found[0], found[1]


@lean
def summit(s, w, number, i, top, servo):  # type: ignore[no-untyped-def]
    """Raise a lane's largest size by the summit of a series within the step."""
    rise, fall = s[at(number, 1) + i], w[row(lanes.SLOPE + number) + i]
    end, h = w[row(lanes.VALUE + number) + i], w[row(lanes.STEP) + i]
    _, value = turn(s, whole(s, w, i, number, servo), h, end, rise, fall)
    w[row(top) + i] = max(w[row(top) + i], abs(value))


@lean
def switch(s, w, i, what, side, servo):  # type: ignore[no-untyped-def]
    """Put a lane into the region behind the limit it has met."""
    if what == lanes.DEMAND:
        mode = row(lanes.MODE) + i
        w[mode] = side if w[mode] == 0.0 else 0.0
        _hold(s, w, i, servo)
    elif what == lanes.SERVO:
        stop = row(lanes.STOP) + i
        w[stop] = side if w[stop] == 0.0 else 0.0
    elif w[row(lanes.HOLD) + i] != 0.0:
        w[row(lanes.HOLD) + i] = 0.0
    else:
        w[row(lanes.HOLD) + i] = side
        if servo == 2:
            s[at(lanes.SPIN, 0) + i] = side * w[row(table.RATE_LIMIT) + i]
    _bound(w, i, servo)


@lean
def _asked(s, w, i):  # type: ignore[no-untyped-def]
    """The deflection asked for where a lane is."""
    theta, path = s[at(lanes.THETA, 0) + i], s[at(lanes.PATH, 0) + i]
    asked = w[row(table.K_ATTITUDE) + i] * theta + w[row(table.K_PATH) + i] * path
    asked += w[row(table.K_RATE) + i] * s[at(lanes.RATE, 0) + i]
    asked += w[row(table.K_ALPHA) + i] * (theta - path - s[at(lanes.WIND, 0) + i])
    return asked + w[row(table.K_MEMORY) + i] * s[at(lanes.MEMORY, 0) + i]


@lean
def _engage(s, w, i):  # type: ignore[no-untyped-def]
    """Choose the mode of the law anew, where the demand may have jumped."""
    asked, mode = _asked(s, w, i), row(lanes.MODE) + i
    if not asked * w[mode] > w[row(table.RELEASE) + i]:
        w[mode] = 0.0
    if w[mode] == 0.0 and abs(asked) >= w[row(table.ENGAGE) + i]:
        w[mode] = np.sign(asked)


@lean
def _hold(s, w, i, servo):  # type: ignore[no-untyped-def]
    """Choose anew whether the rate limit holds the nozzle, where the command may have jumped."""
    mode, limit = w[row(lanes.MODE) + i], w[row(table.LIMIT) + i]
    asked = mode * limit if mode != 0.0 else min(max(_asked(s, w, i), -limit), limit)
    position, spin = s[at(lanes.SERVO, 0) + i], s[at(lanes.SPIN, 0) + i]
    pull = w[row(table.STIFFNESS) + i] * (asked - position)
    most, held = w[row(table.RATE_LIMIT) + i], row(lanes.HOLD) + i
    if servo == 1:
        w[held] = np.sign(pull) if abs(pull) >= most else 0.0
    elif servo == 2:
        pull -= w[row(table.DRAG) + i] * spin
        w[held] = np.sign(spin) if abs(spin) >= most and pull * spin > 0.0 else 0.0


@lean
def _bound(w, i, servo):  # type: ignore[no-untyped-def]
    """Write what the regions of a lane mean for its equations, and how far they reach."""
    mode, stop, held = w[row(lanes.MODE) + i], w[row(lanes.STOP) + i], w[row(lanes.HOLD) + i]
    limit, most = w[row(table.LIMIT) + i], w[row(table.RATE_LIMIT) + i]
    enters, lets_go = w[row(table.ENGAGE) + i], w[row(table.RELEASE) + i]
    _between(w, i, lanes.DEMAND_LOW, mode, enters, lets_go)
    w[row(lanes.COMMANDED) + i] = 1.0 if mode == 0.0 else 0.0
    w[row(lanes.COMMAND) + i] = mode * limit
    _between(w, i, lanes.SERVO_LOW, stop, (1.0 + table.SLACK) * limit, limit)
    w[row(lanes.MOVING) + i] = 1.0 if stop == 0.0 else 0.0
    w[row(lanes.STOPPED) + i] = stop * limit
    _between(w, i, lanes.WATCH_LOW, held, most, 0.0 if servo == 2 else most)
    w[row(lanes.FREE) + i] = 1.0 if held == 0.0 else 0.0
    w[row(lanes.HELD) + i] = held * most if held != 0.0 else 0.0
    if held != 0.0:
        w[row(lanes.TOP_WATCH) + i] = most
    _rule(w, i, servo)


@lean
def _rule(w, i, servo):  # type: ignore[no-untyped-def]
    """Write the equations of a lane's nozzle, and what it moves, in the regions of the lane."""
    free, moving = w[row(lanes.FREE) + i], w[row(lanes.MOVING) + i]
    stiff = free * w[row(table.STIFFNESS) + i] if servo else 1.0
    gain, felt = stiff * w[row(lanes.COMMANDED) + i], w[row(table.K_ALPHA) + i]
    w[row(lanes.PULL_ATTITUDE) + i] = gain * (w[row(table.K_ATTITUDE) + i] + felt)
    w[row(lanes.PULL_RATE) + i] = gain * w[row(table.K_RATE) + i]
    w[row(lanes.PULL_PATH) + i] = gain * (w[row(table.K_PATH) + i] - felt)
    w[row(lanes.PULL_MEMORY) + i] = gain * w[row(table.K_MEMORY) + i]
    w[row(lanes.PULL_GUST) + i] = -gain * felt
    w[row(lanes.PULL_SERVO) + i] = -stiff if servo else 0.0
    w[row(lanes.PULL_SPIN) + i] = -free * w[row(table.DRAG) + i]
    pull = stiff * w[row(lanes.COMMAND) + i]
    w[row(lanes.PULL) + i] = pull + w[row(lanes.HELD) + i] if servo == 1 else pull
    held, command = w[row(table.STIFFNESS) + i], w[row(lanes.COMMAND) + i]
    held *= 1.0 if servo == 1 else 1.0 - free
    w[row(lanes.WATCH_ASKED) + i] = held * w[row(lanes.COMMANDED) + i]
    w[row(lanes.WATCH_SERVO) + i], w[row(lanes.WATCHED) + i] = -held, held * command
    w[row(lanes.WATCH_SPIN) + i] = free - (1.0 - free) * w[row(table.DRAG) + i]
    moment, stopped = w[row(table.MOMENT) + i], w[row(lanes.STOPPED) + i]
    w[row(lanes.TURN_SERVO) + i], w[row(lanes.TURN) + i] = moment * moving, moment * stopped
    drift = w[row(table.PATH_DEFLECTION) + i]
    w[row(lanes.DRIFT_SERVO) + i], w[row(lanes.DRIFT) + i] = drift * moving, drift * stopped


@lean
def _between(w, i, low, region, enters, lets_go):  # type: ignore[no-untyped-def]
    """Bounds of a region: in the middle, or beyond one side."""
    w[row(low) + i] = -enters if region == 0.0 else (lets_go if region > 0.0 else -np.inf)
    w[row(low + 1) + i] = enters if region == 0.0 else (-lets_go if region < 0.0 else np.inf)


@lean
def arrive(s, w, i, cursor, knots, wind, servo):  # type: ignore[no-untyped-def]
    """Put a lane that has come to a knot upon the next piece of its wind; return the piece."""
    now, before = min(w[row(lanes.KNOT) + i], _stop(w, i)), cursor
    while cursor + 1 < knots.size and knots[cursor + 1] <= now:
        cursor += 1
    w[row(lanes.NOW) + i] = now
    w[row(lanes.KNOT) + i] = knots[cursor + 1] if cursor + 1 < knots.size else np.inf
    if cursor > before:
        for k in range(wind.shape[1]):
            s[at(lanes.WIND, k) + i] = wind[cursor, k]
        _engage(s, w, i)
        _hold(s, w, i, servo)
        _bound(w, i, servo)
    _look(s, w, i)
    w[row(lanes.LEFT) + i] = min(w[row(lanes.KNOT) + i], _stop(w, i)) - now
    return cursor


@lean
def _stop(w, i):  # type: ignore[no-untyped-def]
    """When a lane is stopped next, wherever the knots are: to be looked at, or for good."""
    return min(w[row(lanes.LOOK) + i], w[row(table.UNTIL) + i])


@lean
def _look(s, w, i):  # type: ignore[no-untyped-def]
    """Judge a lane that is due after its wind; look again until all is known."""
    now, look, end = w[row(lanes.NOW) + i], row(lanes.LOOK) + i, w[row(table.END) + i]
    if w[look] == np.inf or now < max(end, _stop(w, i)):
        return
    fate = _judged(s, w, i)
    late = now >= end + w[row(table.PATIENCE) + i]
    known = late or fate != table.UNDECIDED
    w[row(lanes.FATE) + i] = fate
    w[look] = np.inf if known else now + w[row(table.CALM) + i] / table.LOOKS


@merged
def stir(s, w):  # type: ignore[no-untyped-def]
    """Note when lanes were last not calm: at a look alone a swing may just pass zero."""
    quiet, reach, end, now = row(lanes.QUIET), row(table.REACH), row(table.END), row(lanes.NOW)
    for i in range(ALL):
        fast, slow = 0.0, 0.0
        for k in range(4):
            x = s[at(lanes.THETA + k, 0) + i]
            fast += w[row(table.FAST + k) + i] * x
            slow += w[row(table.SLOW + k) + i] * x
        large = max(abs(fast), abs(slow)) >= table.SETTLED * w[reach + i]
        after = w[now + i] >= w[end + i]
        w[quiet + i] = w[now + i] if large & after else w[quiet + i]


@lean
def _judged(s, w, i):  # type: ignore[no-untyped-def]
    """Return what is known of a lane's fate after its wind."""
    fast, slow = 0.0, 0.0
    for k in range(4):
        x = s[at(lanes.THETA + k, 0) + i]
        fast += w[row(table.FAST + k) + i] * x
        slow += w[row(table.SLOW + k) + i] * x
    now, reach, ratio = w[row(lanes.NOW) + i], w[row(table.REACH) + i], w[row(table.RATIO) + i]
    inside = abs(fast) < reach
    if inside and ratio > 0.0:
        x = fast / reach
        low = reach * (1.0 - 2.0 * ((1.0 - x) / 2.0) ** ratio)
        high = reach * (2.0 * ((1.0 + x) / 2.0) ** ratio - 1.0)
        inside = low < slow < high
    if not inside:
        return table.LOST
    calm = now - w[row(lanes.QUIET) + i] >= table.NEARLY * w[row(table.CALM) + i]
    return table.SURVIVED if calm else table.UNDECIDED
