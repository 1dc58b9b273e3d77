"""Taylor series of 64 flights, each within its regions of limits, where the flight is linear."""

import numpy as np

from tvclin.kernels import flight_table as table
from tvclin.kernels.compiled import lanes
from tvclin.kernels.compiled.compiler import lean, merged
from tvclin.kernels.compiled.lanes import ALL, ORDER, at, row


@lean
def series(w, order, servo):  # type: ignore[no-untyped-def]
    """Write the series of all lanes about where they are."""
    for k in range(ORDER + 1):
        _command(w, k)
        if servo == 2:
            _second_order(w, k)
        elif servo == 1:
            _first_order(w, k)
        else:
            _direct(w, k)
        _attitude(w, k)
        if order > 2:
            _path(w, k)


@lean
def _command(w, k):  # type: ignore[no-untyped-def]
    theta, rate, path = at(lanes.THETA, k), at(lanes.RATE, k), at(lanes.PATH, k)
    wind, alpha, demand = at(lanes.WIND, k), at(lanes.ALPHA, k), at(lanes.DEMAND, k)
    memory, further = at(lanes.MEMORY, k), at(lanes.MEMORY, k + 1)
    k_theta, k_rate, k_path = row(table.K_ATTITUDE), row(table.K_RATE), row(table.K_PATH)
    k_alpha, k_memory = row(table.K_ALPHA), row(table.K_MEMORY)
    share = 1.0 / (k + 1)
    for i in range(ALL):
        angle = w[theta + i] - w[path + i] - w[wind + i]
        asked = w[k_theta + i] * w[theta + i] + w[k_rate + i] * w[rate + i]
        asked += w[k_path + i] * w[path + i] + w[k_alpha + i] * angle
        w[demand + i] = asked + w[k_memory + i] * w[memory + i]
        w[alpha + i] = angle
        w[further + i] = w[theta + i] * share


@lean
def _second_order(w, k):  # type: ignore[no-untyped-def]
    servo, spin = at(lanes.SERVO, k), at(lanes.SPIN, k)
    servo_next, spin_next = at(lanes.SERVO, k + 1), at(lanes.SPIN, k + 1)
    demand, watch, deflection = at(lanes.DEMAND, k), at(lanes.WATCH, k), row(lanes.DEFLECTION)
    stiffness, drag, free = row(table.STIFFNESS), row(table.DRAG), row(lanes.FREE)
    commanded, command = row(lanes.COMMANDED), row(lanes.COMMAND)
    moving, stopped = row(lanes.MOVING), row(lanes.STOPPED)
    share = 1.0 / (k + 1)
    first = 1.0 if k == 0 else 0.0
    for i in range(ALL):
        asked = w[commanded + i] * w[demand + i] + first * w[command + i]
        pull = w[stiffness + i] * (asked - w[servo + i]) - w[drag + i] * w[spin + i]
        w[watch + i] = w[free + i] * w[spin + i] + (1.0 - w[free + i]) * pull
        w[servo_next + i] = w[spin + i] * share
        w[spin_next + i] = w[free + i] * pull * share
        w[deflection + i] = w[moving + i] * w[servo + i] + first * w[stopped + i]


@lean
def _first_order(w, k):  # type: ignore[no-untyped-def]
    servo, further = at(lanes.SERVO, k), at(lanes.SERVO, k + 1)
    demand, watch, deflection = at(lanes.DEMAND, k), at(lanes.WATCH, k), row(lanes.DEFLECTION)
    bandwidth, free, held = row(table.STIFFNESS), row(lanes.FREE), row(lanes.HELD)
    commanded, command = row(lanes.COMMANDED), row(lanes.COMMAND)
    moving, stopped = row(lanes.MOVING), row(lanes.STOPPED)
    share = 1.0 / (k + 1)
    first = 1.0 if k == 0 else 0.0
    for i in range(ALL):
        asked = w[commanded + i] * w[demand + i] + first * w[command + i]
        pull = w[bandwidth + i] * (asked - w[servo + i])
        w[watch + i] = pull
        w[further + i] = (w[free + i] * pull + first * w[held + i]) * share
        w[deflection + i] = w[moving + i] * w[servo + i] + first * w[stopped + i]


@lean
def _direct(w, k):  # type: ignore[no-untyped-def]
    servo, demand, deflection = at(lanes.SERVO, k), at(lanes.DEMAND, k), row(lanes.DEFLECTION)
    commanded, command = row(lanes.COMMANDED), row(lanes.COMMAND)
    watch = at(lanes.WATCH, max(k - 1, 0))
    first = 1.0 if k == 0 else 0.0
    for i in range(ALL):
        asked = w[commanded + i] * w[demand + i] + first * w[command + i]
        w[servo + i] = asked
        w[deflection + i] = asked
        w[watch + i] = k * asked


@lean
def _attitude(w, k):  # type: ignore[no-untyped-def]
    theta, rate, path = at(lanes.THETA, k), at(lanes.RATE, k), at(lanes.PATH, k)
    theta_next, rate_next = at(lanes.THETA, k + 1), at(lanes.RATE, k + 1)
    wind, deflection = at(lanes.WIND, k), row(lanes.DEFLECTION)
    mu, mu_path = row(table.MU), row(table.MU_PATH)
    moment, gust = row(table.MOMENT), row(table.GUST)
    share = 1.0 / (k + 1)
    for i in range(ALL):
        pull = w[mu + i] * w[theta + i] + w[mu_path + i] * w[path + i]
        pull += w[moment + i] * w[deflection + i] + w[gust + i] * w[wind + i]
        w[theta_next + i] = w[rate + i] * share
        w[rate_next + i] = pull * share


@lean
def _path(w, k):  # type: ignore[no-untyped-def]
    theta, path, speed = at(lanes.THETA, k), at(lanes.PATH, k), at(lanes.SPEED, k)
    path_next, speed_next = at(lanes.PATH, k + 1), at(lanes.SPEED, k + 1)
    wind, deflection = at(lanes.WIND, k), row(lanes.DEFLECTION)
    by_theta, by_path = row(table.PATH_ATTITUDE), row(table.PATH_PATH)
    by_speed, by_wind = row(table.PATH_SPEED), row(table.PATH_GUST)
    by_deflection, turning = row(table.PATH_DEFLECTION), row(table.SPEED_PATH)
    share = 1.0 / (k + 1)
    for i in range(ALL):
        drift = w[by_theta + i] * w[theta + i] + w[by_path + i] * w[path + i]
        drift += w[by_speed + i] * w[speed + i] + w[by_wind + i] * w[wind + i]
        w[path_next + i] = (drift + w[by_deflection + i] * w[deflection + i]) * share
        w[speed_next + i] = w[turning + i] * w[path + i] * share


@merged
def lengths(w):  # type: ignore[no-untyped-def]
    """Choose the steps: the last two terms stay within the tolerance, and no knot is passed.

    A step changes as the 8th root of what there is to spare, or the 16th if it may grow: both on
    the safe side of the 12th, and square roots are cheap.
    """
    last, before = ORDER, ORDER - 1
    theta, servo = at(lanes.THETA, last), at(lanes.SERVO, last)
    theta_1, servo_1 = at(lanes.THETA, before), at(lanes.SERVO, before)
    trial, left, step = row(lanes.TRIAL), row(lanes.LEFT), row(lanes.STEP)
    scale, limit = row(table.SCALE), row(table.LIMIT)
    for i in range(ALL):
        h = w[trial + i]
        h4 = (h * h) * (h * h)
        h11 = h4 * h4 * (h * h * h)
        error = abs(w[theta + i]) * h + abs(w[theta_1 + i])
        error = (
            error * w[scale + i]
            + table.SERVO_SHARE * (abs(w[servo + i]) * h + abs(w[servo_1 + i])) / w[limit + i]
        )
        spare = table.TOLERANCE / max(error * h11, 1e-30)
        root = np.sqrt(np.sqrt(np.sqrt(spare)))
        factor = max(root, 1e-3) if spare < 1.0 else min(np.sqrt(root), 2.0)
        h = min(h * factor, 1e6)
        w[trial + i] = h
        w[step + i] = h if h < w[left + i] else w[left + i]


@merged
def sums(w, number):  # type: ignore[no-untyped-def]
    """Sum a series and its slope at the ends of the steps."""
    start, value, slope = at(number, 0), row(lanes.VALUE + number), row(lanes.SLOPE + number)
    step = row(lanes.STEP)
    for i in range(ALL):
        h = w[step + i]
        total, rise = 0.0, 0.0
        for k in range(ORDER, -1, -1):
            rise = rise * h + total
            total = total * h + w[start + np.uint64(k * lanes.LANES) + i]
        w[value + i] = total
        w[slope + i] = rise


@merged
def leaving(w, number, least_, most_):  # type: ignore[no-untyped-def]
    """Flag the lanes in which a series may leave its bounds within the step."""
    start, slope = at(number, 0), at(number, 1)
    end, end_slope = row(lanes.VALUE + number), row(lanes.SLOPE + number)
    least, most, step, flag = row(least_), row(most_), row(lanes.STEP), row(lanes.FLAG)
    for i in range(ALL):
        a, b, rise, fall = w[start + i], w[end + i], w[slope + i], w[end_slope + i]
        low, high, flagged = w[least + i], w[most + i], w[flag + i]
        one, other = a + rise * w[step + i], b - fall * w[step + i]
        out = (b > high) | (b < low)
        out |= (rise > 0.0) & (fall < 0.0) & (min(one, other) > high)
        out |= (rise < 0.0) & (fall > 0.0) & (max(one, other) < low)
        w[flag + i] = 1.0 if out else flagged


@merged
def topping(w, number, top, share):  # type: ignore[no-untyped-def]
    """Raise the largest size of a series by both ends, and flag lanes with a summit between.

    Only the lanes in which the share is one, not zero, count.
    """
    start, slope = at(number, 0), at(number, 1)
    end, end_slope = row(lanes.VALUE + number), row(lanes.SLOPE + number)
    highest, step, flag = row(top), row(lanes.STEP), row(lanes.FLAG)
    part = row(share)
    for i in range(ALL):
        a, b = w[part + i] * w[start + i], w[part + i] * w[end + i]
        rise, fall = w[part + i] * w[slope + i], w[part + i] * w[end_slope + i]
        known, flagged = max(w[highest + i], abs(a), abs(b)), w[flag + i]
        one, other = a + rise * w[step + i], b - fall * w[step + i]
        beyond = (rise > 0.0) & (fall < 0.0) & (min(one, other) > known)
        beyond |= (rise < 0.0) & (fall > 0.0) & (max(one, other) < -known)
        w[highest + i] = known
        w[flag + i] = 1.0 if beyond else flagged


@lean
def advance(w, degree):  # type: ignore[no-untyped-def]
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
            w[start + i] = w[end + i]
    for low in range(degree):
        for k in range(degree - 1, low - 1, -1):
            c, above = at(lanes.WIND, k), at(lanes.WIND, k + 1)
            for i in range(ALL):
                w[c + i] += w[above + i] * w[step + i]
