"""Compiled twin of `kernels.arcs`: 32 flights side by side, each at its own time."""

import numpy as np

from tvclin.kernels import flight_table as table
from tvclin.kernels.compiled import lanes
from tvclin.kernels.compiled.arc_ends import advance, ends, leaving, topping
from tvclin.kernels.compiled.arc_events import arrive, meet, stir, summit, switch
from tvclin.kernels.compiled.arc_ringing import begin_ringing, settle
from tvclin.kernels.compiled.arc_series import lengths, series
from tvclin.kernels.compiled.compiler import compiled, lean
from tvclin.kernels.compiled.lanes import ALL, LANES, at, row


@compiled
def fly(rows, order, servo, knots, wind, which, first, last, out):  # type: ignore[no-untyped-def]
    """Fly the cases from `first` up to `last`, block by block, and write their results."""
    s, columns = np.zeros(lanes.SERIES_SIZE), np.zeros((lanes.SIZE // LANES, LANES))
    w = columns.reshape(lanes.SIZE)
    cases, cursor, met = np.zeros((3, LANES), np.int64)
    for start in range(first, last, LANES):
        for i in range(LANES):
            cases[i] = min(start + i, last - 1)
        _fly_block(s, w, columns, rows, order, servo, knots, wind, which, cases, cursor, met, out)


@lean
def _fly_block(s, w, columns, rows, order, servo, knots, wind, which, cases, cursor, met, out):  # type: ignore[no-untyped-def]
    _begin(s, w, columns, rows, servo, knots, wind, which, cases, cursor)
    flying = LANES
    for _ in range(table.MOST):
        _step(s, w, order, servo, wind.shape[2] - 1, met)
        for i in range(ALL):
            if w[row(lanes.LEFT) + i] <= 0.0 and w[row(lanes.ALIVE) + i] != 0.0:
                gust = which[cases[i]]
                cursor[i] = arrive(s, w, i, cursor[i], knots[gust], wind[gust], servo)
                if not _goes_on(w, i):
                    _write(s, w, i, out[:, cases[i]])
                    flying -= 1
        if flying == 0:
            return
    for i in range(ALL):
        if w[row(lanes.ALIVE) + i] != 0.0:
            _write(s, w, i, out[:, cases[i]])


@lean
def _begin(s, w, columns, rows, servo, knots, wind, which, cases, cursor):  # type: ignore[no-untyped-def]
    """Put all lanes at rest before the first knots of their winds."""
    s[:] = 0.0
    w[:] = 0.0
    for number in range(table.LEAN):  # the rest is of laws that lean
        begin = row(number)
        for i in range(ALL):
            w[begin + i] = rows[number, cases[i]]
    if servo == 2:
        begin_ringing(w, columns)
    for i in range(ALL):
        w[row(lanes.TRIAL) + i] = table.BEGIN
        w[row(lanes.ALIVE) + i] = 1.0
        end, until = w[row(table.END) + i], w[row(table.UNTIL) + i]
        w[row(lanes.QUIET) + i] = end
        look = end if until == np.inf else until
        w[row(lanes.LOOK) + i] = np.inf if np.isnan(w[row(table.REACH) + i]) else look
        gust = which[cases[i]]
        w[row(lanes.KNOT) + i] = knots[gust, 0]
        cursor[i] = arrive(s, w, i, -1, knots[gust], wind[gust], servo)
        w[row(table.START) + i] = w[row(lanes.NOW) + i]


@lean
def _step(s, w, order, servo, degree, met):  # type: ignore[no-untyped-def]
    """Step all lanes: to the tolerance, to a knot, or to the first limit that is met."""
    if servo == 2:
        settle(s, w, degree)
    series(s, w, order, servo, degree)
    lengths(s, w)
    ends(s, w, order, servo, degree, np.uint64(0), ALL)
    changes = _meet_limits(s, w, order, servo, degree, met)
    _peaks(s, w, servo)
    advance(s, w, degree)
    stir(s, w)
    for j in range(changes):
        i = np.uint64(met[j])
        switch(s, w, i, w[row(lanes.MET) + i], w[row(lanes.SIDE) + i], servo)


@lean
def _meet_limits(s, w, order, servo, degree, met):  # type: ignore[no-untyped-def]
    """Shorten the steps of lanes that meet a limit, list these, and return how many there are."""
    leaving(s, w, servo)
    count = 0
    for i in range(ALL):
        if w[row(lanes.FLAG) + i] != 0.0 and w[row(lanes.ALIVE) + i] != 0.0:
            what, side = meet(s, w, i, order, servo, degree)
            if what >= 0:
                met[count] = np.int64(i)
                w[row(lanes.MET) + i], w[row(lanes.SIDE) + i] = what, side
                count += 1
    return count


@lean
def _peaks(s, w, servo):  # type: ignore[no-untyped-def]
    topping(s, w)
    for i in range(ALL):
        flag = np.int64(w[row(lanes.FLAG) + i])
        if flag != 0:
            if flag & 1:
                summit(s, w, lanes.THETA, i, lanes.TOP_THETA, servo)
            if flag & 2:
                summit(s, w, lanes.RATE, i, lanes.TOP_RATE, servo)
            if flag & 4:
                summit(s, w, lanes.SERVO, i, lanes.TOP_SERVO, servo)
            if flag & 8:
                summit(s, w, lanes.WATCH, i, lanes.TOP_WATCH, servo)
            if flag & 16:
                summit(s, w, lanes.ALPHA, i, lanes.TOP_ALPHA, servo)


@lean
def _goes_on(w, i):  # type: ignore[no-untyped-def]
    """End a lane at its time, or when its fate is known and was all that was asked."""
    until = w[row(table.UNTIL) + i]
    ended = w[row(lanes.NOW) + i] >= until
    ended |= until == np.inf and w[row(lanes.LOOK) + i] == np.inf
    if ended:
        w[row(lanes.LEFT) + i], w[row(lanes.ALIVE) + i] = 0.0, 0.0
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
