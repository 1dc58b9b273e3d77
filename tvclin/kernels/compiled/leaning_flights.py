"""Compiled twin of `kernels.leaning_flights`: one flight after the other."""

import numpy as np

from tvclin.kernels import flight_table as table
from tvclin.kernels.compiled.compiler import compiled, lean
from tvclin.kernels.compiled.law_demand import demand, inside

_STATES = 8


@compiled
def fly(  # type: ignore[no-untyped-def]
    rows, order, servo, knots, wind, which, free, driven, longest, first, last, out
):
    """Fly the cases from `first` up to `last` and write their results."""
    y, trial = np.zeros(_STATES), np.zeros(_STATES)
    stages, tops = np.zeros((4, _STATES)), np.zeros(6)
    for case in range(first, last):
        law, knot, gust = rows[:, case].copy(), knots[which[case]], wind[which[case]]
        y[:], tops[:] = 0.0, 0.0
        until, end = law[table.UNTIL], law[table.END]
        begin = now = min(law[table.START], until)
        fate, quiet, cursor, count = table.UNDECIDED, end, -1, 0
        while True:
            while cursor + 1 < knot.size and knot[cursor + 1] <= now:
                cursor += 1
            stop = min(knot[cursor + 1] if cursor + 1 < knot.size else np.inf, until)
            if now >= end and fate == table.UNDECIDED:
                fate, quiet = _judged(law, y, order, now, quiet)
            known = fate != table.UNDECIDED or now >= end + law[table.PATIENCE]
            if now >= until or (known and until == np.inf) or count >= table.MOST:
                break
            piece, local = gust[max(cursor, 0)], now - knot[max(cursor, 0)]
            h, now = _length(now, stop, longest[case])
            _step(
                y, trial, stages, tops, law, order, servo, piece, local, h, free[case], driven[case]
            )
            count += 1
        out[: table.FINAL_ATTITUDE, case] = tops[:5]
        out[table.FINAL_ATTITUDE, case], out[table.ENDED, case] = y[0], now
        out[table.SATURATED, case] = tops[5] / max(now - begin, 1e-300)
        out[table.FATE, case] = fate


@lean
def _length(now, stop, longest):  # type: ignore[no-untyped-def]
    """The length of a step and the time at its end."""
    if stop == np.inf:
        return longest, now + longest
    parts = max(np.ceil((stop - now) / longest - 1e-9), 1.0)
    h = (stop - now) / parts
    return h, (now + h if parts > 1.0 else stop)


@lean
def _value(c, u):  # type: ignore[no-untyped-def]
    total = c[-1]
    for k in range(c.size - 2, -1, -1):
        total = total * u + c[k]
    return total


@lean
def _step(y, trial, stages, tops, law, order, servo, piece, local, h, F, G):  # type: ignore[no-untyped-def]
    """Move the states by a step, and raise the largest sizes."""
    begun = _value(piece, local)
    middle, ended = _value(piece, local + 0.5 * h), _value(piece, local + h)
    command = _rates(law, order, servo, y, begun, F, G, stages[0])
    for k in range(_STATES):
        trial[k] = y[k] + 0.5 * h * stages[0, k]
    _rates(law, order, servo, trial, middle, F, G, stages[1])
    for k in range(_STATES):
        trial[k] = y[k] + 0.5 * h * stages[1, k]
    _rates(law, order, servo, trial, middle, F, G, stages[2])
    for k in range(_STATES):
        trial[k] = y[k] + h * stages[2, k]
    later = _rates(law, order, servo, trial, ended, F, G, stages[3])
    limit = law[table.LIMIT]
    nozzle = command if servo == 0 else min(max(y[4], -limit), limit)
    rate = stages[0, 4] if servo > 0 else (later - command) / h
    tops[1], tops[2] = max(tops[1], abs(y[1])), max(tops[2], abs(nozzle))
    tops[3] = max(tops[3], abs(rate))
    alpha, before, spin = y[0] - y[2] - begun, y[0], y[1]
    for k in range(_STATES):
        slopes = stages[0, k] + 2.0 * stages[1, k] + 2.0 * stages[2, k] + stages[3, k]
        y[k] += h / 6.0 * slopes
    tops[0] = max(tops[0], abs(before), abs(y[0]))
    if spin * y[1] < 0.0:
        tops[0] = max(tops[0], abs(before + 0.5 * spin * (spin / (spin - y[1])) * h))
    tops[4] = max(tops[4], abs(alpha), abs(y[0] - y[2] - ended))
    tops[5] += h if abs(command) >= limit else 0.0


@lean
def _rates(law, order, servo, y, wind, F, G, rates):  # type: ignore[no-untyped-def]
    """Write the rates of the states; return the command."""
    limit, most = law[table.LIMIT], law[table.RATE_LIMIT]
    alpha = y[0] - y[2] - wind
    command = min(max(demand(law, y[0], y[1], y[2], alpha, y[6], y[7]), -limit), limit)
    deflection = command if servo == 0 else min(max(y[4], -limit), limit)
    rates[0] = y[1]
    pull = law[table.MU] * y[0] + law[table.MU_PATH] * y[2]
    rates[1] = pull + (law[table.MOMENT] * deflection + law[table.GUST] * wind)
    rates[2] = rates[3] = rates[4] = rates[5] = 0.0
    if order > 2:
        drift = law[table.PATH_ATTITUDE] * y[0] + law[table.PATH_PATH] * y[2]
        drift += law[table.PATH_SPEED] * y[3] + law[table.PATH_GUST] * wind
        rates[2] = drift + law[table.PATH_DEFLECTION] * deflection
        rates[3] = law[table.SPEED_PATH] * y[2]
    pull = law[table.STIFFNESS] * (command - y[4])
    if servo == 1:
        rates[4] = min(max(pull, -most), most)
    elif servo == 2:
        pull -= law[table.DRAG] * y[5]
        rates[4] = min(max(y[5], -most), most)
        rates[5] = 0.0 if abs(y[5]) >= most and pull * y[5] > 0.0 else pull
    for k in range(2):
        seen = G[k, 0] * y[0] + G[k, 1] * y[1] + G[k, 2] * y[2] + G[k, 3] * alpha
        rates[6 + k] = F[k, 0] * y[6] + F[k, 1] * y[7] + (seen + G[k, 4] * deflection)
    return command


@compiled
def _judged(law, y, order, now, quiet):  # type: ignore[no-untyped-def]
    """The fate of a flight after its wind, and since when it has been calm."""
    reach = law[table.REACH]
    if np.isnan(reach):
        return table.UNDECIDED, quiet
    recoverable, size = inside(law, y[:order])
    if not recoverable:
        return table.LOST, quiet
    if size >= table.SETTLED * reach:
        quiet = now
    calm = now - quiet >= law[table.CALM]
    return (table.SURVIVED if calm else table.UNDECIDED), quiet
