"""Compiled twin of `kernels.sampled_flights`: one flight after the other."""

import numpy as np

from tvclin.kernels import flight_table as table
from tvclin.kernels.compiled.compiler import compiled, lean
from tvclin.kernels.compiled.law_demand import demand, inside, switched

_TERMS = 24
"""Of the series of a gust that begins within a step."""
_NEVER = 1 << 60


@compiled
def fly(rows, servo, knots, wind, which, length, steps, noise, hears, first, last, out):  # type: ignore[no-untyped-def]
    """Fly the cases from `first` up to `last` and write their results."""
    x, s, m = np.zeros(steps[1].shape[1]), np.zeros(2), np.zeros(2)
    old = np.zeros(x.size)
    here, seen, tops = np.zeros(wind.shape[2]), np.zeros(5), np.zeros(6)
    for case in range(first, last):
        law, knot, gust = rows[:, case].copy(), knots[which[case]], wind[which[case]]
        own = _own(steps, case)
        for array in (x, s, m, here, tops):
            array[:] = 0.0
        start, limit, fate, mode, quiet = law[table.START], law[table.LIMIT], 0, 0.0, 0
        finish, ends, patience, calm = _horizon(law, length)
        cursor = np.searchsorted(knot, start, side="right") - 1
        k = 0
        while True:
            _about(gust, knot, cursor, start + length * k, here)
            _look(x, here, s, limit, seen, tops)
            if k > ends and (k - ends) % table.LOOK == 0 and fate == table.UNDECIDED:
                fate, quiet = _judged(law, x, quiet, calm)
            open_still = fate == table.UNDECIDED and k < ends + patience
            if k >= finish or not (open_still or finish < _NEVER):
                break
            seen[1] += noise[hears[case], k] if k < noise.shape[1] else 0.0
            mode = _served(law, servo, length, own, seen, s, m, mode, tops)
            _flown(x, old, seen[4], s, here, servo, law, own)
            cursor = _blown(x, knot, gust, cursor, start, length, k, own)
            k += 1
        _written(out, case, tops, x, start, k, length, fate)


@compiled
def _own(steps, case):  # type: ignore[no-untyped-def]
    """The matrices of one case."""
    A, B, free, first, last, nozzle, drive, kept, seen, gust = steps
    return (
        A[case], B[case], free[case], first[case], last[case],
        nozzle[case], drive[case], kept[case], seen[case], gust[case],
    )  # fmt: skip


@lean
def _horizon(law, length):  # type: ignore[no-untyped-def]
    """Samples until the flight must end, its wind has ended, patience has, and calm is enough."""
    start, until = law[table.START], law[table.UNTIL]
    finish = _NEVER
    if until < np.inf:
        finish = max(int(np.ceil((until - start) / length - 1e-9)), 1)
    ends = max(int(np.ceil((law[table.END] - start) / length - 1e-9)), 1)
    if np.isnan(law[table.REACH]):
        return finish, ends, 0, 0
    patience = int(np.ceil(law[table.PATIENCE] / length))
    patience = -(-patience // table.LOOK) * table.LOOK
    return finish, ends, patience, int(np.ceil(law[table.CALM] / length))


@lean
def _about(gust, knot, cursor, now, here):  # type: ignore[no-untyped-def]
    """Write the coefficients of the wind about a time."""
    for j in range(here.size):
        here[j] = gust[cursor, j] if cursor >= 0 else 0.0
    u = now - knot[max(cursor, 0)]
    for low in range(here.size - 1):
        for j in range(here.size - 2, low - 1, -1):
            here[j] += here[j + 1] * u


@lean
def _look(x, here, s, limit, seen, tops):  # type: ignore[no-untyped-def]
    """Write what the law is shown, and raise the largest sizes."""
    path = x[2] if x.size > 2 else 0.0
    seen[0], seen[1], seen[2], seen[3] = x[0], x[1], path, x[0] - path - here[0]
    seen[4] = min(max(s[0], -limit), limit)
    tops[0], tops[1] = max(tops[0], abs(x[0])), max(tops[1], abs(x[1]))
    tops[4] = max(tops[4], abs(seen[3]))


@lean
def _judged(law, x, quiet, calm):  # type: ignore[no-untyped-def]
    """The fate of a flight at a look after its wind, and for how many samples it is calm."""
    if np.isnan(law[table.REACH]):
        return table.UNDECIDED, 0
    recoverable, size = inside(law, x)
    if not recoverable:
        return table.LOST, 0
    quiet = quiet + table.LOOK if size < table.SETTLED * law[table.REACH] else 0
    return (table.SURVIVED if quiet >= calm else table.UNDECIDED), quiet


@lean
def _served(law, servo, length, own, seen, s, m, mode, tops):  # type: ignore[no-untyped-def]
    """Move nozzle and law by a step; return the mode, and in `tops` what the limits did."""
    limit, most = law[table.LIMIT], law[table.RATE_LIMIT]
    asked = demand(law, seen[0], seen[1], seen[2], seen[3], m[0], m[1])
    mode = switched(law, asked, mode)
    command = mode * limit if mode != 0.0 else min(max(asked, -limit), limit)
    free, drive = own[5], own[6]
    before = s[0]
    moved = free[0, 0] * before + free[0, 1] * s[1] + drive[0] * command
    s[1] = free[1, 0] * before + free[1, 1] * s[1] + drive[1] * command
    if most < np.inf:
        moved = before + min(max(moved - before, -most * length), most * length)
        s[1] = min(max(s[1], -most), most)
    s[0] = moved
    first, second = 0.0, 0.0
    for j in range(2):
        first += own[7][0, j] * m[j]
        second += own[7][1, j] * m[j]
    for j in range(5):
        first += own[8][0, j] * seen[j]
        second += own[8][1, j] * seen[j]
    m[0], m[1] = first, second
    end = min(max(moved, -limit), limit)
    tops[2] = max(tops[2], abs(end))
    tops[3] = max(tops[3], abs(end - seen[4]) / length)
    tops[5] += 1.0 if abs(command) >= limit else 0.0
    return mode


@lean
def _flown(x, old, begun, s, here, servo, law, own):  # type: ignore[no-untyped-def]
    """Move the states by a step whose wind is that of its start."""
    limit, n = law[table.LIMIT], x.size
    end = min(max(s[0], -limit), limit)
    begun = end if servo == 0 and law[table.RATE_LIMIT] == np.inf else begun
    for i in range(n):
        old[i] = x[i]
    for i in range(n):
        total = own[3][i] * begun + own[4][i] * end
        for j in range(n):
            total += own[2][i, j] * old[j]
        for j in range(here.size):
            total += own[9][i, j] * here[j]
        x[i] = total


@compiled
def _blown(x, knot, gust, cursor, start, length, k, own):  # type: ignore[no-untyped-def]
    """Add what the knots within a step change; return the piece at its end."""
    then = start + length * (k + 1)
    while cursor + 1 < knot.size and knot[cursor + 1] <= then:
        cursor += 1
        if start + length * k < knot[cursor] < then:
            _kick(x, own[0], own[1], gust, knot, cursor, then - knot[cursor])
    return cursor


@compiled
def _kick(x, A, B, gust, knot, cursor, time):  # type: ignore[no-untyped-def]
    """Add the answer to what a piece of wind is more than the one before, by Taylor series."""
    n, size = x.size, gust.shape[1]
    more = np.zeros(size)
    if cursor > 0:
        _about(gust, knot, cursor - 1, knot[cursor], more)
    more = gust[cursor] - more
    term, further, factor = np.zeros(n), np.zeros(n), 1.0
    for k in range(_TERMS):
        for i in range(n):
            further[i] = B[i] * more[k] if k < size else 0.0
            for j in range(n):
                further[i] += A[i, j] * term[j]
        factor *= time
        for i in range(n):
            term[i] = further[i] / (k + 1)
            x[i] += term[i] * factor


@compiled
def _written(out, case, tops, x, start, k, length, fate):  # type: ignore[no-untyped-def]
    out[table.PEAK_ATTITUDE, case] = tops[0]
    out[table.PEAK_RATE, case] = tops[1]
    out[table.PEAK_DEFLECTION, case] = tops[2]
    out[table.PEAK_DEFLECTION_RATE, case] = tops[3]
    out[table.PEAK_ALPHA, case] = tops[4]
    out[table.FINAL_ATTITUDE, case] = x[0]
    out[table.ENDED, case] = start + k * length
    out[table.SATURATED, case] = tops[5] / max(k, 1)
    out[table.FATE, case] = fate
