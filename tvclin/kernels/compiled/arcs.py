"""Compiled twin of `kernels.arcs`: 64 flights side by side, each at its own time."""

import numpy as np

from tvclin.kernels import flight_table as table
from tvclin.kernels.compiled import lanes
from tvclin.kernels.compiled.arc_events import arrive, due, judged, meet, summit, switch
from tvclin.kernels.compiled.arc_series import advance, leaving, lengths, series, sums, topping
from tvclin.kernels.compiled.compiler import compiled, lean
from tvclin.kernels.compiled.lanes import ALL, LANES, at, row


@compiled
def fly(rows, order, servo, knots, wind, which, first, last, out):  # type: ignore[no-untyped-def]
    """Fly the cases from `first` up to `last`, block by block, and write their results."""
    s, w = np.zeros(lanes.SERIES_SIZE), np.zeros(lanes.SIZE)
    for start in range(first, last, LANES):
        cases = np.minimum(np.arange(start, start + LANES), last - 1)
        cursor, alive = _begun(s, w, rows, servo, knots, wind, which, cases)
        for _ in range(table.MOST):
            _step(s, w, order, servo, wind.shape[2] - 1, alive)
            due(s, w)
            for i in range(ALL):
                if alive[i] and w[row(lanes.FLAG) + i] != 0.0:
                    if w[row(lanes.LEFT) + i] <= 0.0:
                        gust = which[cases[i]]
                        cursor[i] = arrive(s, w, i, cursor[i], knots[gust], wind[gust], servo)
                    alive[i] = _goes_on(s, w, i)
                    if not alive[i] and np.int64(i) < last - start:
                        _write(s, w, i, out[:, cases[i]])
            if not np.any(alive):
                break


@compiled
def _begun(s, w, rows, servo, knots, wind, which, cases):  # type: ignore[no-untyped-def]
    """Put all lanes at rest before the first knots of their winds."""
    s[:] = 0.0
    w[:] = 0.0
    for number in range(table.ROWS):
        begin = row(number)
        for i in range(ALL):
            w[begin + i] = rows[number, cases[i]]
    cursor = np.full(LANES, -1)
    for i in range(ALL):
        w[row(lanes.TRIAL) + i] = table.BEGIN
        w[row(lanes.ONE) + i] = 1.0
        w[row(lanes.QUIET) + i] = w[row(table.END) + i]
        gust = which[cases[i]]
        cursor[i] = arrive(s, w, i, -1, knots[gust], wind[gust], servo)
        w[row(table.START) + i] = w[row(lanes.NOW) + i]
    return cursor, np.ones(LANES, np.bool_)


@compiled
def _step(s, w, order, servo, degree, alive):  # type: ignore[no-untyped-def]
    """Step all lanes: to the tolerance, to a knot, or to the first limit that is met."""
    series(s, w, order, servo)
    lengths(s, w)
    flag = row(lanes.FLAG)
    w[flag : flag + ALL] = 0.0
    for number in (lanes.DEMAND, lanes.SERVO, lanes.WATCH):
        sums(s, w, number)
    leaving(s, w, lanes.DEMAND, lanes.DEMAND_LOW, lanes.DEMAND_HIGH)
    if servo > 0:
        leaving(s, w, lanes.SERVO, lanes.SERVO_LOW, lanes.SERVO_HIGH)
        leaving(s, w, lanes.WATCH, lanes.WATCH_LOW, lanes.WATCH_HIGH)
    met, sides = np.full(LANES, -1), np.zeros(LANES)
    for i in range(ALL):
        if alive[i] and w[flag + i] != 0.0:
            met[i], sides[i] = meet(s, w, i, servo)
    for number in (lanes.THETA, lanes.RATE, lanes.MEMORY, lanes.ALPHA):
        sums(s, w, number)
    if order > 2:
        sums(s, w, lanes.PATH)
        sums(s, w, lanes.SPEED)
    if servo == 2:
        sums(s, w, lanes.SPIN)
    _peaks(s, w)
    advance(s, w, degree)
    for i in range(ALL):
        if met[i] >= 0:
            switch(s, w, i, met[i], sides[i], servo)


@lean
def _peaks(s, w):  # type: ignore[no-untyped-def]
    flag = row(lanes.FLAG)
    w[flag : flag + ALL] = 0.0
    topping(s, w, lanes.THETA, lanes.TOP_THETA, lanes.ONE)
    topping(s, w, lanes.RATE, lanes.TOP_RATE, lanes.ONE)
    topping(s, w, lanes.SERVO, lanes.TOP_SERVO, lanes.ONE)
    topping(s, w, lanes.WATCH, lanes.TOP_WATCH, lanes.FREE)
    topping(s, w, lanes.ALPHA, lanes.TOP_ALPHA, lanes.ONE)
    for i in range(ALL):
        if w[flag + i] != 0.0:
            summit(s, w, lanes.THETA, i, lanes.TOP_THETA, lanes.ONE)
            summit(s, w, lanes.RATE, i, lanes.TOP_RATE, lanes.ONE)
            summit(s, w, lanes.SERVO, i, lanes.TOP_SERVO, lanes.ONE)
            summit(s, w, lanes.WATCH, i, lanes.TOP_WATCH, lanes.FREE)
            summit(s, w, lanes.ALPHA, i, lanes.TOP_ALPHA, lanes.ONE)


@lean
def _goes_on(s, w, i):  # type: ignore[no-untyped-def]
    """Judge a lane; end it at its time, or when its fate is known and was all that was asked."""
    now, until = w[row(lanes.NOW) + i], w[row(table.UNTIL) + i]
    end, patience = w[row(table.END) + i], w[row(table.PATIENCE) + i]
    fate = row(lanes.FATE) + i
    if now >= end and w[fate] == table.UNDECIDED:
        w[fate] = judged(s, w, i)
    known = w[fate] != table.UNDECIDED or now >= end + patience
    ended = now >= until or (known and until == np.inf)
    if ended:
        w[row(lanes.LEFT) + i] = 0.0
    return not ended


@lean
def _write(s, w, i, out):  # type: ignore[no-untyped-def]
    """Write the results of a lane that has ended; the lane goes on standing still."""
    now, start = w[row(lanes.NOW) + i], w[row(table.START) + i]
    out[table.PEAK_ATTITUDE] = w[row(lanes.TOP_THETA) + i]
    out[table.PEAK_RATE] = w[row(lanes.TOP_RATE) + i]
    out[table.PEAK_DEFLECTION] = min(w[row(lanes.TOP_SERVO) + i], w[row(table.LIMIT) + i])
    top = w[row(lanes.TOP_WATCH) + i]
    out[table.PEAK_DEFLECTION_RATE] = min(top, w[row(table.RATE_LIMIT) + i])
    out[table.PEAK_ALPHA] = w[row(lanes.TOP_ALPHA) + i]
    out[table.FINAL_ATTITUDE] = s[at(lanes.THETA, 0) + i]
    out[table.ENDED] = now
    out[table.SATURATED] = w[row(lanes.FULL) + i] / max(now - start, 1e-300)
    out[table.FATE] = w[row(lanes.FATE) + i]
