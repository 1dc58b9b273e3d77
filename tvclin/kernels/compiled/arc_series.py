"""Taylor series of 32 flights, each within its regions of limits, where the flight is linear."""

from typing import Any

import numpy as np

from tvclin.kernels import flight_table as table
from tvclin.kernels.compiled import lanes
from tvclin.kernels.compiled.compiler import lean, merged
from tvclin.kernels.compiled.lanes import ALL, LANES, ORDER, at, row


@merged
def _asked(w, i, theta, rate, gamma, alpha, memory):  # type: ignore[no-untyped-def]
    """Return a term of the deflection asked for."""
    asked = w[row(table.K_ATTITUDE) + i] * theta + w[row(table.K_RATE) + i] * rate
    asked += w[row(table.K_PATH) + i] * gamma + w[row(table.K_ALPHA) + i] * alpha
    return asked + w[row(table.K_MEMORY) + i] * memory


@merged
def _drift(w, i, theta, gamma, speed, wind, deflection):  # type: ignore[no-untyped-def]
    """Return a term of the rate at which the path turns."""
    drift = w[row(table.PATH_ATTITUDE) + i] * theta + w[row(table.PATH_PATH) + i] * gamma
    drift += w[row(table.PATH_SPEED) + i] * speed + w[row(table.PATH_GUST) + i] * wind
    return drift + w[row(table.PATH_DEFLECTION) + i] * deflection


def _recurrence(servo: int, path: bool) -> Any:
    """Return the kernel of a nozzle of that order, and of a plant whose path turns or does not."""

    @lean
    def terms(s, w, k):  # type: ignore[no-untyped-def]
        """Write some terms of all series, from the k-th on."""
        theta_, rate_, memory_ = at(lanes.THETA, k), at(lanes.RATE, k), at(lanes.MEMORY, k)
        path_, speed_ = at(lanes.PATH, k), at(lanes.SPEED, k)
        servo_, spin_ = at(lanes.SERVO, k), at(lanes.SPIN, k)
        demand_, alpha_, watch_ = at(lanes.DEMAND, k), at(lanes.ALPHA, k), at(lanes.WATCH, k)
        wind_ = at(lanes.WIND, k)
        begin = 1.0 if k == 0 else 0.0
        for i in range(ALL):
            theta, rate, memory = s[theta_ + i], s[rate_ + i], s[memory_ + i]
            position, spin, gamma, speed = s[servo_ + i], s[spin_ + i], 0.0, 0.0
            if path:
                gamma, speed = s[path_ + i], s[speed_ + i]
            for j in range(lanes.TOGETHER):
                now, further = np.uint64(j * LANES) + i, np.uint64((j + 1) * LANES) + i
                share, first = 1.0 / (k + j + 1), begin if j == 0 else 0.0
                wind = s[wind_ + now]
                alpha = theta - gamma - wind
                asked = _asked(w, i, theta, rate, gamma, alpha, memory)
                s[demand_ + now], s[alpha_ + now] = asked, alpha
                asked = w[row(lanes.COMMANDED) + i] * asked + first * w[row(lanes.COMMAND) + i]
                deflection = asked
                if servo:
                    deflection = w[row(lanes.MOVING) + i] * position
                    deflection += first * w[row(lanes.STOPPED) + i]
                pull = w[row(table.STIFFNESS) + i] * (asked - position)
                free = w[row(lanes.FREE) + i]
                if servo == 2:
                    pull -= w[row(table.DRAG) + i] * spin
                    s[watch_ + now] = free * spin + (1.0 - free) * pull
                    position, spin = spin * share, free * pull * share
                    s[servo_ + further], s[spin_ + further] = position, spin
                elif servo == 1:
                    s[watch_ + now] = pull
                    position = (free * pull + first * w[row(lanes.HELD) + i]) * share
                    s[servo_ + further] = position
                else:
                    s[servo_ + now] = asked
                turn = w[row(table.MU) + i] * theta + w[row(table.MOMENT) + i] * deflection
                turn += w[row(table.GUST) + i] * wind
                if path:
                    turn += w[row(table.MU_PATH) + i] * gamma
                    drift = _drift(w, i, theta, gamma, speed, wind, deflection)
                    speed = w[row(table.SPEED_PATH) + i] * gamma * share
                    gamma = drift * share
                    s[path_ + further], s[speed_ + further] = gamma, speed
                memory, theta, rate = theta * share, rate * share, turn * share
                s[memory_ + further], s[theta_ + further], s[rate_ + further] = memory, theta, rate

    return terms


_DIRECT, _FIRST, _SECOND = (_recurrence(servo, False) for servo in range(3))
_DIRECT_PATH, _FIRST_PATH, _SECOND_PATH = (_recurrence(servo, True) for servo in range(3))


@lean
def series(s, w, order, servo):  # type: ignore[no-untyped-def]
    """Write the series of all lanes about where they are."""
    for k in range(0, ORDER + 1, lanes.TOGETHER):
        if servo == 2 and order > 2:
            _SECOND_PATH(s, w, k)
        elif servo == 2:
            _SECOND(s, w, k)
        elif servo == 1 and order > 2:
            _FIRST_PATH(s, w, k)
        elif servo == 1:
            _FIRST(s, w, k)
        elif order > 2:
            _DIRECT_PATH(s, w, k)
        else:
            _DIRECT(s, w, k)
    if servo == 0:
        _spin(s)


@lean
def _spin(s):  # type: ignore[no-untyped-def]
    """Write the rate of a nozzle that follows at once."""
    for k in range(1, ORDER + 1):
        servo, watch = at(lanes.SERVO, k), at(lanes.WATCH, k - 1)
        for i in range(ALL):
            s[watch + i] = k * s[servo + i]


@merged
def lengths(s, w):  # type: ignore[no-untyped-def]
    """Choose the steps: the last two terms stay within the tolerance, and no knot is passed.

    A step changes about as the 11th root of what there is to spare: the bits of a number are its
    logarithm, or so, and 1/16 and 1/32 of them are quick to take.
    """
    last, before = ORDER, ORDER - 1
    theta, servo = at(lanes.THETA, last), at(lanes.SERVO, last)
    theta_1, servo_1 = at(lanes.THETA, before), at(lanes.SERVO, before)
    trial, left, step = row(lanes.TRIAL), row(lanes.LEFT), row(lanes.STEP)
    scale, servo_scale = row(table.SCALE), row(table.SERVO_SCALE)
    for i in range(ALL):
        h = w[trial + i]
        h5 = (h * h) * (h * h) * h
        error = abs(s[theta + i]) * h + abs(s[theta_1 + i])
        moved = abs(s[servo + i]) * h + abs(s[servo_1 + i])
        error = error * w[scale + i] + table.SERVO_SHARE * moved * w[servo_scale + i]
        spare = table.TOLERANCE / max(error * (h5 * h5), 1e-30)
        bits = np.float64(spare).view(np.int64) - table.ONE
        factor = np.int64(table.ONE + (bits >> 4) + (bits >> 5)).view(np.float64)
        h = min(h * min(table.SAFE * factor, table.GROWTH), 1e6)
        w[trial + i] = h
        w[step + i] = h if h < w[left + i] else w[left + i]


@merged
def sums(s, w, number):  # type: ignore[no-untyped-def]
    """Sum a series and its slope at the ends of the steps."""
    start, value, slope = at(number, 0), row(lanes.VALUE + number), row(lanes.SLOPE + number)
    step = row(lanes.STEP)
    for i in range(ALL):
        h = w[step + i]
        total, rise = 0.0, 0.0
        for k in range(ORDER, -1, -1):
            rise = rise * h + total
            total = total * h + s[start + np.uint64(k * lanes.LANES) + i]
        w[value + i] = total
        w[slope + i] = rise


@merged
def leaving(s, w, number, least_, most_):  # type: ignore[no-untyped-def]
    """Flag the lanes in which a series may leave its bounds within the step."""
    start, slope = at(number, 0), at(number, 1)
    end, end_slope = row(lanes.VALUE + number), row(lanes.SLOPE + number)
    least, most, step, flag = row(least_), row(most_), row(lanes.STEP), row(lanes.FLAG)
    for i in range(ALL):
        a, b, rise, fall = s[start + i], w[end + i], s[slope + i], w[end_slope + i]
        low, high, flagged = w[least + i], w[most + i], w[flag + i]
        one, other = a + rise * w[step + i], b - fall * w[step + i]
        out = (b > high) | (b < low)
        out |= (rise > 0.0) & (fall < 0.0) & (max(one, other) > high)
        out |= (rise < 0.0) & (fall > 0.0) & (min(one, other) < low)
        w[flag + i] = 1.0 if out else flagged


@merged
def topping(s, w, number, top, share):  # type: ignore[no-untyped-def]
    """Raise the largest size of a series by both ends, and flag lanes with a summit between.

    Only the lanes in which the share is one, not zero, count.
    """
    start, slope = at(number, 0), at(number, 1)
    end, end_slope = row(lanes.VALUE + number), row(lanes.SLOPE + number)
    highest, step, flag = row(top), row(lanes.STEP), row(lanes.FLAG)
    part = row(share)
    for i in range(ALL):
        a, b = w[part + i] * s[start + i], w[part + i] * w[end + i]
        rise, fall = w[part + i] * s[slope + i], w[part + i] * w[end_slope + i]
        known, flagged = max(w[highest + i], abs(a), abs(b)), w[flag + i]
        one, other = a + rise * w[step + i], b - fall * w[step + i]
        beyond = (rise > 0.0) & (fall < 0.0) & (max(one, other) > known)
        beyond |= (rise < 0.0) & (fall > 0.0) & (min(one, other) < -known)
        w[highest + i] = known
        w[flag + i] = 1.0 if beyond else flagged


@lean
def advance(s, w, degree):  # type: ignore[no-untyped-def]
    """Move all lanes to the ends of their steps; the wind has the degree of its pieces."""
    step, now, left = row(lanes.STEP), row(lanes.NOW), row(lanes.LEFT)
    full, commanded = row(lanes.FULL), row(lanes.COMMANDED)
    for i in range(ALL):
        w[now + i] += w[step + i]
        w[left + i] -= w[step + i]
        w[full + i] += (1.0 - w[commanded + i]) * w[step + i]
    for number in range(lanes.MEMORY + 1):
        start, end = at(number, 0), row(lanes.VALUE + number)
        for i in range(ALL):
            s[start + i] = w[end + i]
    for low in range(degree):
        for k in range(degree - 1, low - 1, -1):
            c, above = at(lanes.WIND, k), at(lanes.WIND, k + 1)
            for i in range(ALL):
                s[c + i] += s[above + i] * w[step + i]
