"""Taylor series of 32 flights, each within its regions of limits, where the flight is linear."""

from typing import Any

import numpy as np

from tvclin.kernels import flight_table as table
from tvclin.kernels.compiled import lanes
from tvclin.kernels.compiled.compiler import lean, merged
from tvclin.kernels.compiled.lanes import ALL, LANES, ORDER, at, row


@merged
def pulled(w, i, path, theta, rate, gamma, memory, position, spin):  # type: ignore[no-untyped-def]
    """Return what moves the nozzle, but for the wind and what is constant."""
    pull = w[row(lanes.PULL_ATTITUDE) + i] * theta + w[row(lanes.PULL_RATE) + i] * rate
    pull += w[row(lanes.PULL_MEMORY) + i] * memory + w[row(lanes.PULL_SERVO) + i] * position
    if path:
        pull += w[row(lanes.PULL_PATH) + i] * gamma
    return pull + w[row(lanes.PULL_SPIN) + i] * spin


@merged
def turned(w, i, path, theta, gamma, position):  # type: ignore[no-untyped-def]
    """Return what turns the vehicle, but for the wind and what is constant."""
    turn = w[row(table.MU) + i] * theta + w[row(lanes.TURN_SERVO) + i] * position
    return turn + w[row(table.MU_PATH) + i] * gamma if path else turn


@merged
def drifted(w, i, theta, gamma, speed, position):  # type: ignore[no-untyped-def]
    """Return what turns the path, but for the wind and what is constant."""
    drift = w[row(table.PATH_ATTITUDE) + i] * theta + w[row(table.PATH_PATH) + i] * gamma
    drift += w[row(table.PATH_SPEED) + i] * speed
    return drift + w[row(lanes.DRIFT_SERVO) + i] * position


@merged
def _forced(s, w, i, forced, place, gust, constant, first):  # type: ignore[no-untyped-def]
    """Return the share of the wind, and in the first term of what is constant."""
    if not forced:
        return -0.0  # which adds nothing, not even to zero
    return w[row(gust) + i] * s[place] + first * w[row(constant) + i]


def _recurrence(servo: int, path: bool, forced: bool) -> Any:
    """Return the kernel of a nozzle of that order, and of a plant whose path turns or does not.

    Terms that are forced are those that have a share of the wind, or of what is constant.
    """

    @lean
    def terms(s, w, k):  # type: ignore[no-untyped-def]
        """Write some terms of all series, from the k-th on."""
        theta_, rate_, memory_ = at(lanes.THETA, k), at(lanes.RATE, k), at(lanes.MEMORY, k)
        path_, speed_ = at(lanes.PATH, k), at(lanes.SPEED, k)
        servo_, spin_ = at(lanes.SERVO, k), at(lanes.SPIN, k)
        begin = 1.0 if k == 0 else 0.0
        for i in range(ALL):
            theta, rate, memory = s[theta_ + i], s[rate_ + i], s[memory_ + i]
            position, spin, gamma, speed = s[servo_ + i], 0.0, s[path_ + i], s[speed_ + i]
            if servo == 2:
                spin = s[spin_ + i]
            for j in range(lanes.TOGETHER):
                now, further = np.uint64(j * LANES) + i, np.uint64((j + 1) * LANES) + i
                share, first = 1.0 / (k + j + 1), begin if j == 0 else 0.0
                felt = at(lanes.WIND, k) + now
                pull = pulled(w, i, path, theta, rate, gamma, memory, position, spin)
                pull += _forced(s, w, i, forced, felt, lanes.PULL_GUST, lanes.PULL, first)
                if servo == 0:
                    position = pull
                    s[servo_ + now] = position
                turn = turned(w, i, path, theta, gamma, position)
                turn += _forced(s, w, i, forced, felt, table.GUST, lanes.TURN, first)
                if path:
                    drift = drifted(w, i, theta, gamma, speed, position)
                    drift += _forced(s, w, i, forced, felt, table.PATH_GUST, lanes.DRIFT, first)
                    speed, gamma = w[row(table.SPEED_PATH) + i] * gamma * share, drift * share
                    s[path_ + further], s[speed_ + further] = gamma, speed
                if servo == 2:
                    position, spin = spin * share, pull * share
                    s[servo_ + further], s[spin_ + further] = position, spin
                elif servo == 1:
                    position = pull * share
                    s[servo_ + further] = position
                memory, theta, rate = theta * share, rate * share, turn * share
                s[memory_ + further], s[theta_ + further], s[rate_ + further] = memory, theta, rate

    return terms


_DIRECT, _FIRST, _SECOND = (_recurrence(servo, False, True) for servo in range(3))
_DIRECT_PATH, _FIRST_PATH, _SECOND_PATH = (_recurrence(servo, True, True) for servo in range(3))
_SECOND_FREE, _SECOND_PATH_FREE = (_recurrence(2, path, False) for path in (False, True))


@lean
def series(s, w, order, servo, degree):  # type: ignore[no-untyped-def]
    """Write the series of all lanes about where they are."""
    for k in range(0, ORDER + 1, lanes.TOGETHER):
        if servo == 2 and order > 2 and k > degree:
            _SECOND_PATH_FREE(s, w, k)
        elif servo == 2 and order > 2:
            _SECOND_PATH(s, w, k)
        elif servo == 2 and k > degree:
            _SECOND_FREE(s, w, k)
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


@merged
def lengths(s, w):  # type: ignore[no-untyped-def]
    """Choose the steps: the last two terms stay within the accuracy, and no knot is passed.

    The accuracy is over the wind's peak, or over an attitude that is larger. A step changes about
    as the 11th root of what there is to spare: the bits of a number are its logarithm, or so, and
    1/16 and 1/32 of them are quick to take.
    """
    last, before = ORDER, ORDER - 1
    begun, theta, servo = at(lanes.THETA, 0), at(lanes.THETA, last), at(lanes.SERVO, last)
    theta_1, servo_1 = at(lanes.THETA, before), at(lanes.SERVO, before)
    trial, left, step = row(lanes.TRIAL), row(lanes.LEFT), row(lanes.STEP)
    scale, servo_scale = row(table.SCALE), row(table.SERVO_SCALE)
    for i in range(ALL):
        h = w[trial + i]
        h5 = (h * h) * (h * h) * h
        error = abs(s[theta + i]) * h + abs(s[theta_1 + i])
        moved = abs(s[servo + i]) * h + abs(s[servo_1 + i])
        error = error * w[scale + i] + table.SERVO_SHARE * moved * w[servo_scale + i]
        spare = w[row(table.ACCURACY) + i] * max(abs(s[begun + i]) * w[scale + i], 1.0)
        spare = spare / max(error * (h5 * h5), 1e-30)
        bits = np.float64(spare).view(np.int64) - table.ONE
        factor = np.int64(table.ONE + (bits >> 4) + (bits >> 5)).view(np.float64)
        h = min(h * min(table.SAFE * factor, table.GROWTH), 1e6)
        w[trial + i] = h
        w[step + i] = h if h < w[left + i] else w[left + i]
