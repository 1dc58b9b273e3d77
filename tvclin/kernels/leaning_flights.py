"""Flights of recoverable-attitude laws without pause: fixed steps, cut at the knots of the wind.

The lean has too many corners to meet each of them, and a curved edge where two modes are
unstable; the method is the classical one of Runge and Kutta. Twins agree to rounding, which an
unstable plant multiplies.
"""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels import flight_table as table
from tvclin.kernels.choice import compiled_twin
from tvclin.kernels.flight_table import FlightTable, FloatArray
from tvclin.kernels.law_demand import demand, judged
from tvclin.kernels.threads import in_slices

_NUMPY, _COMPILED = 1.5e-3, 1.5e-6
"""Seconds for a step of a small batch of flights, and of one flight compiled, or so."""


def leaning_flights(flights: FlightTable) -> FloatArray:
    """Return the results of all flights, ``(9, m)``: the rows of `flight_table`."""
    rows, cases = flights.rows, flights.which.size
    out = np.zeros((table.RESULTS, cases))
    longest = _longest_steps(flights)
    span = np.minimum(rows[table.UNTIL], rows[table.END] + rows[table.CALM]) - rows[table.START]
    steps = float(np.nan_to_num(span / longest).max(initial=0.0))
    twin = compiled_twin("leaning_flights", steps * _NUMPY * (1.0 + cases / 1000.0))
    if twin is None:
        _fly(flights, longest, out)
        return out

    def work(first: int, last: int) -> None:
        twin.fly(
            rows, flights.order, flights.servo, flights.knots, flights.wind, flights.which,
            flights.free, flights.driven, longest, first, last, out,
        )  # fmt: skip

    in_slices(work, cases, steps * cases * _COMPILED)
    return out


def _longest_steps(flights: FlightTable) -> FloatArray:
    """The longest step [s] of each flight."""
    rows = flights.rows
    servo = rows[table.STIFFNESS] if flights.servo < 2 else np.sqrt(rows[table.STIFFNESS])
    F = flights.free
    estimator = np.sqrt(np.abs(F[:, 0, 0] * F[:, 1, 1] - F[:, 0, 1] * F[:, 1, 0]))
    gain = rows[table.LEAN_B] * (1.0 + rows[table.LEAN_GAIN])
    feedback = np.abs(rows[table.MOMENT] * gain * rows[table.LEAN_RATE])
    fastest = np.maximum(np.maximum(servo, estimator), feedback)
    return np.minimum(table.STEP, table.SHARE / np.maximum(fastest, 1e-30))


@dataclass(frozen=True, eq=False)
class _State:
    """Where flights are, the case last: states ``(8, m)`` of plant, nozzle and law, and so on."""

    case: NDArray[np.intp]
    rows: FloatArray
    which: NDArray[np.int64]
    free: FloatArray
    driven: FloatArray
    longest: FloatArray
    y: FloatArray
    now: FloatArray
    stop: FloatArray
    quiet: FloatArray
    full: FloatArray
    tops: FloatArray
    fate: NDArray[np.int64]
    cursor: NDArray[np.intp]

    def take(self, index: NDArray[np.bool_]) -> "_State":
        return _State(**{f.name: getattr(self, f.name)[..., index] for f in fields(self)})


def _fly(flights: FlightTable, longest: FloatArray, out: FloatArray) -> None:
    m, rows = flights.which.size, flights.rows
    zero = np.zeros(m)
    begin = np.minimum(rows[table.START], rows[table.UNTIL])
    state = _State(
        np.arange(m), rows, flights.which,
        np.moveaxis(flights.free, 0, -1), np.moveaxis(flights.driven, 0, -1), longest,
        np.zeros((8, m)), begin, begin, rows[table.END], zero, np.zeros((5, m)),
        np.zeros(m, np.int64), np.full(m, -1),
    )  # fmt: skip
    for _ in range(table.MOST):
        state = _arrived(flights, state)
        fate, quiet = judged(state.rows, state.y[:4], state.now, state.fate, state.quiet)
        state = replace(state, fate=fate, quiet=quiet)
        until, patience = state.rows[table.UNTIL], state.rows[table.PATIENCE]
        known = (state.fate != table.UNDECIDED) | (state.now >= state.rows[table.END] + patience)
        ended = (state.now >= until) | (known & np.isinf(until))
        if np.any(ended):
            _write(out, state.take(ended), begin)
            state = state.take(~ended)
        if not state.case.size:
            return
        state = _stepped(flights, state)
    _write(out, state, begin)


def _arrived(flights: FlightTable, state: _State) -> _State:
    """Put flights that have come to a knot upon the next piece of wind."""
    last = flights.knots.shape[1] - 1
    cursor = state.cursor
    while True:
        knot = flights.knots[state.which, np.minimum(cursor + 1, last)]
        following = np.where(cursor < last, knot, np.inf)
        passed = following <= state.now
        if not np.any(passed):
            break
        cursor = cursor + passed
    stop = np.minimum(following, state.rows[table.UNTIL])
    return replace(state, cursor=cursor, stop=stop)


def _stepped(flights: FlightTable, state: _State) -> _State:
    """Take a step, an even part of what is left to the next knot."""
    left = state.stop - state.now
    parts = np.maximum(np.ceil(np.where(np.isinf(left), 1.0, left) / state.longest - 1e-9), 1.0)
    h = np.where(np.isinf(left), state.longest, left / parts)
    piece = np.maximum(state.cursor, 0)
    c = flights.wind[state.which, piece].T
    u = state.now - flights.knots[state.which, piece]
    wind = [_value(c, u + part * h) for part in (0.0, 0.5, 1.0)]
    y = state.y
    first, command, rate = _rates(flights, state, y, wind[0])
    second = _rates(flights, state, y + 0.5 * h * first, wind[1])[0]
    third = _rates(flights, state, y + 0.5 * h * second, wind[1])[0]
    fourth, later, _ = _rates(flights, state, y + h * third, wind[2])
    moved = y + h / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
    limit = state.rows[table.LIMIT]
    deflection = np.clip(command if flights.servo == 0 else y[4], -limit, limit)
    rate = rate if flights.servo else (later - command) / h
    tops = np.maximum(
        state.tops,
        np.abs(np.stack([y[0], y[1], deflection, rate, y[0] - y[2] - wind[0]])),
    )
    end = moved[0] - moved[2] - wind[2]
    tops[0] = np.maximum(tops[0], _summit(y, moved, h))
    tops[4] = np.maximum(tops[4], np.abs(end))
    full = state.full + np.where(np.abs(command) >= limit, h, 0.0)
    now = np.where(parts > 1.0, state.now + h, np.where(np.isinf(left), state.now + h, state.stop))
    return replace(state, y=moved, now=now, tops=tops, full=full)


def _value(c: FloatArray, u: FloatArray) -> FloatArray:
    total = c[-1]
    for k in range(len(c) - 2, -1, -1):
        total = total * u + c[k]
    return np.asarray(total)


def _summit(y: FloatArray, moved: FloatArray, h: FloatArray) -> FloatArray:
    """The largest attitude within a step, where its rate goes evenly through zero, and after it."""
    turns = y[1] * moved[1] < 0.0
    part = np.where(turns, y[1] / np.where(turns, y[1] - moved[1], 1.0), 0.0)
    top = np.abs(y[0] + 0.5 * y[1] * part * h)
    return np.maximum(np.where(turns, top, 0.0), np.abs(moved[0]))


def _rates(
    flights: FlightTable, state: _State, y: FloatArray, wind: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rates of the states, command, and rate of the nozzle."""
    rows, servo = state.rows, flights.servo
    limit, most = rows[table.LIMIT], rows[table.RATE_LIMIT]
    alpha = y[0] - y[2] - wind
    command = np.clip(demand(rows, y[0], y[1], y[2], alpha, y[6:]), -limit, limit)
    deflection = command if servo == 0 else np.clip(y[4], -limit, limit)
    rates = np.zeros_like(y)
    rates[0] = y[1]
    rates[1] = rows[table.MU] * y[0] + rows[table.MU_PATH] * y[2]
    rates[1] += rows[table.MOMENT] * deflection + rows[table.GUST] * wind
    if flights.order > 2:
        rates[2] = rows[table.PATH_ATTITUDE] * y[0] + rows[table.PATH_PATH] * y[2]
        rates[2] += rows[table.PATH_SPEED] * y[3] + rows[table.PATH_GUST] * wind
        rates[2] += rows[table.PATH_DEFLECTION] * deflection
        rates[3] = rows[table.SPEED_PATH] * y[2]
    pull = rows[table.STIFFNESS] * (command - y[4])
    if servo == 1:
        rates[4] = np.clip(pull, -most, most)
    elif servo == 2:
        pull = pull - rows[table.DRAG] * y[5]
        rates[4] = np.clip(y[5], -most, most)
        rates[5] = np.where((np.abs(y[5]) >= most) & (pull * y[5] > 0.0), 0.0, pull)
    seen = np.stack([y[0], y[1], y[2], alpha, deflection])
    rates[6:] = (state.free * y[6:]).sum(axis=1) + (state.driven * seen).sum(axis=1)
    return rates, command, rates[4]


def _write(out: FloatArray, state: Any, begin: FloatArray) -> None:
    case, ended = state.case, state.now
    out[: table.FINAL_ATTITUDE, case] = state.tops
    out[table.FINAL_ATTITUDE, case], out[table.ENDED, case] = state.y[0], ended
    out[table.SATURATED, case] = state.full / np.maximum(ended - begin[case], 1e-300)
    out[table.FATE, case] = state.fate
