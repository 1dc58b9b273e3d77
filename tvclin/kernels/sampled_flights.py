"""Flights of laws that are computed at a sample rate, each with a plant and a wind of its own.

Every step is exact, as in `closed_loop.sampled`: what the wind does in it follows from its
coefficients at the start, and from what each knot within it changes. Twins agree to rounding,
which an unstable plant multiplies like any other disturbance.
"""

from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels import flight_table as table
from tvclin.kernels.choice import compiled_twin
from tvclin.kernels.flight_table import FlightTable, FloatArray, SampledSteps
from tvclin.kernels.law_demand import demand, inside, switched
from tvclin.kernels.threads import in_slices

_TERMS = 24
"""Of the series of a gust that begins within a step."""
_NEVER = 1 << 60
_NUMPY, _COMPILED = 1e-4, 4e-6
"""Seconds for a sample of a small batch of flights, and of one flight compiled, or so."""
_AT_ONCE = 1000.0
"""A batch twice as large takes numpy twice the time when it is larger than this."""


def pays(samples: float) -> bool:
    """Return whether the compiled twin would fly a small batch of so many samples."""
    return compiled_twin("sampled_flights", samples * _NUMPY) is not None


def sampled_flights(flights: FlightTable, steps: SampledSteps) -> FloatArray:
    """Return the results of all flights, ``(9, m)``: the rows named in `flight_table`."""
    cases = flights.which.size
    out = np.zeros((table.RESULTS, cases))
    rows = flights.rows
    span = np.minimum(rows[table.UNTIL], rows[table.END] + rows[table.CALM]) - rows[table.START]
    samples = float(np.nan_to_num(span).max(initial=0.0)) / steps.length
    twin = compiled_twin("sampled_flights", samples * _NUMPY * (1.0 + cases / _AT_ONCE))
    if twin is None:
        with np.errstate(over="ignore", invalid="ignore"):  # a lost flight may leave all numbers
            _fly(flights, steps, out)
        return out
    arrays = (
        *steps.plant, steps.free, steps.first, steps.last, *steps.servo, *steps.memory, steps.gust
    )  # fmt: skip

    def work(first: int, last: int) -> None:
        twin.fly(
            rows, flights.servo, flights.knots, flights.wind, flights.which, steps.length,
            arrays, steps.noise, steps.hears, first, last, out,
        )  # fmt: skip

    in_slices(work, cases, samples * cases * _COMPILED / 40.0)
    return out


@dataclass(frozen=True, eq=False)
class _Given:
    """What does not change in a flight, each with the case last: see `FlightTable`."""

    case: NDArray[np.intp]
    rows: FloatArray
    plant: FloatArray
    gusts: FloatArray
    free: FloatArray
    first: FloatArray
    last: FloatArray
    servo_free: FloatArray
    servo_drive: FloatArray
    memory_free: FloatArray
    memory_drive: FloatArray
    gust: FloatArray
    hears: NDArray[np.int64]
    which: NDArray[np.int64]
    finish: NDArray[np.int64]
    ends: NDArray[np.int64]
    patience: NDArray[np.int64]
    calm: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class _State:
    """Where flights are: states of plant, nozzle and law, mode, samples of calm, fate, sizes."""

    x: FloatArray
    servo: FloatArray
    memory: FloatArray
    mode: FloatArray
    quiet: NDArray[np.int64]
    fate: NDArray[np.int64]
    tops: FloatArray
    cursor: NDArray[np.intp]


def _fly(flights: FlightTable, steps: SampledSteps, out: FloatArray) -> None:
    """Fly all cases side by side; one that has ended leaves."""
    given, state = _begun(flights, steps)
    k = 0
    while given.case.size:
        here = _wind(flights, given, state.cursor, given.rows[table.START] + steps.length * k)
        seen, state = _looked(given, state, here, k)
        open_still = (state.fate == table.UNDECIDED) & (k < given.ends + given.patience)
        ended = (k >= given.finish) | ~(open_still | (given.finish < _NEVER))
        if np.any(ended):
            _write(out, _taken(given, ended), _taken(state, ended), steps.length, k)
            given, state = _taken(given, ~ended), _taken(state, ~ended)
            here, seen = here[:, ~ended], seen[:, ~ended]
        state = _stepped(flights, steps, given, state, here, seen, k)
        k += 1


def _taken(record: Any, which: NDArray[np.bool_]) -> Any:
    return replace(record, **{f.name: getattr(record, f.name)[..., which] for f in fields(record)})


def _begun(flights: FlightTable, steps: SampledSteps) -> tuple[_Given, _State]:
    rows, h, m = flights.rows, steps.length, flights.which.size
    start = rows[table.START]
    judged = ~np.isnan(rows[table.REACH])
    patience = np.ceil(np.where(judged, rows[table.PATIENCE], 0.0) / h).astype(np.int64)
    calm = np.ceil(np.where(judged, rows[table.CALM], 0.0) / h).astype(np.int64)
    last = partial(np.moveaxis, source=0, destination=-1)
    given = _Given(
        np.arange(m),
        rows,
        last(steps.plant[0]),
        last(steps.plant[1]),
        last(steps.free),
        last(steps.first),
        last(steps.last),
        last(steps.servo[0]),
        last(steps.servo[1]),
        last(steps.memory[0]),
        last(steps.memory[1]),
        last(steps.gust),
        steps.hears,
        flights.which,
        _samples(rows[table.UNTIL] - start, h),
        _samples(rows[table.END] - start, h),
        -(-patience // table.LOOK) * table.LOOK,
        calm,
    )
    cursor = (flights.knots[flights.which] <= start[:, np.newaxis]).sum(axis=1) - 1
    none = np.zeros(m, np.int64)
    states = np.zeros((steps.free.shape[1], m)), np.zeros((2, m)), np.zeros((2, m))
    return given, _State(*states, np.zeros(m), none, none, np.zeros((6, m)), cursor)


def _samples(span: FloatArray, length: float) -> NDArray[np.int64]:
    known = np.isfinite(span)
    counted = np.ceil(np.where(known, span, 0.0) / length - 1e-9).astype(np.int64)
    return np.where(known, np.maximum(counted, 1), _NEVER)


def _wind(
    flights: FlightTable, given: _Given, cursor: NDArray[np.intp], now: FloatArray
) -> FloatArray:
    """Coefficients of the winds about a time, ``(degree + 1, m)``."""
    before, piece = cursor < 0, np.maximum(cursor, 0)
    here = flights.wind[given.which, piece].T.copy()
    u = now - flights.knots[given.which, piece]
    for low in range(len(here) - 1):
        for j in range(len(here) - 2, low - 1, -1):
            here[j] += here[j + 1] * u
    return np.where(before, 0.0, here)


def _looked(given: _Given, state: _State, here: FloatArray, k: int) -> tuple[FloatArray, _State]:
    """What the laws are shown at a sample, and what becomes of fates and largest sizes."""
    x, limit = state.x, given.rows[table.LIMIT]
    path = x[2] if len(x) > 2 else np.zeros_like(x[0])
    deflection = np.clip(state.servo[0], -limit, limit)
    seen = np.stack([x[0], x[1], path, x[0] - path - here[0], deflection])
    tops = state.tops.copy()
    tops[[0, 1, 4]] = np.fmax(tops[[0, 1, 4]], np.abs(seen[[0, 1, 3]]))
    fate, quiet = state.fate, state.quiet
    due = (k > given.ends) & ((k - given.ends) % table.LOOK == 0) & (fate == table.UNDECIDED)
    due &= ~np.isnan(given.rows[table.REACH])
    if np.any(due):
        recoverable, size = inside(given.rows, x)
        settled = size < table.SETTLED * given.rows[table.REACH]
        quiet = np.where(due, np.where(settled, quiet + table.LOOK, 0), quiet)
        found = np.where(quiet >= given.calm, table.SURVIVED, table.UNDECIDED)
        fate = np.where(due, np.where(recoverable, found, table.LOST), fate)
    return seen, replace(state, fate=fate, quiet=quiet, tops=tops)


def _stepped(
    flights: FlightTable,
    steps: SampledSteps,
    given: _Given,
    state: _State,
    here: FloatArray,
    seen: FloatArray,
    k: int,
) -> _State:
    rows, limit, most = given.rows, given.rows[table.LIMIT], given.rows[table.RATE_LIMIT]
    if k < steps.noise.shape[1]:
        seen[1] += steps.noise[given.hears, k]
    asked = demand(rows, seen[0], seen[1], seen[2], seen[3], state.memory)
    mode = switched(rows, asked, state.mode)
    command = np.where(mode != 0.0, mode * limit, np.clip(asked, -limit, limit))
    moved = _times(given.servo_free, state.servo) + given.servo_drive * command
    reach = np.where(most < np.inf, most * steps.length, np.inf)
    moved[0] = state.servo[0] + np.clip(moved[0] - state.servo[0], -reach, reach)
    moved[1] = np.clip(moved[1], -most, most)
    end = np.clip(moved[0], -limit, limit)
    jumps = (flights.servo == 0) & (most == np.inf)
    x = _times(given.free, state.x) + given.first * np.where(jumps, end, seen[4])
    x += given.last * end + _times(given.gust, here)
    memory = _times(given.memory_free, state.memory) + _times(given.memory_drive, seen)
    tops = state.tops.copy()
    tops[2] = np.fmax(tops[2], np.abs(end))
    tops[3] = np.fmax(tops[3], np.abs(end - seen[4]) / steps.length)
    tops[5] += np.abs(command) >= limit
    now = rows[table.START] + steps.length * k
    then = rows[table.START] + steps.length * (k + 1)
    cursor = _blown(flights, given, state.cursor, x, now, then)
    return replace(state, x=x, servo=moved, memory=memory, mode=mode, tops=tops, cursor=cursor)


def _times(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    """Matrices ``(i, j, m)`` times vectors ``(j, m)``."""
    return np.asarray((matrices * vectors).sum(axis=1))


def _blown(
    flights: FlightTable,
    given: _Given,
    cursor: NDArray[np.intp],
    x: FloatArray,
    now: FloatArray,
    then: FloatArray,
) -> NDArray[np.intp]:
    """Add to the states what the knots within a step change; return the pieces at its end."""
    last = flights.knots.shape[1] - 1
    while True:
        knot = flights.knots[given.which, np.minimum(cursor + 1, last)]
        passed = (cursor < last) & (knot <= then)
        if not np.any(passed):
            return cursor
        within = passed & (now < knot) & (knot < then)
        if np.any(within):
            some = _taken(given, within)
            before = _wind(flights, some, cursor[within], knot[within])
            more = flights.wind[some.which, cursor[within] + 1].T - before
            x[:, within] += _kick(some, more, (then - knot)[within])
        cursor = cursor + passed


def _kick(given: _Given, more: FloatArray, time: FloatArray) -> FloatArray:
    """Return the answers to more wind from within a step to its end, by Taylor series."""
    term = np.zeros_like(given.gusts)
    total, factor = np.zeros_like(term), np.ones_like(time)
    for k in range(_TERMS):
        term = _times(given.plant, term) + (given.gusts * more[k] if k < len(more) else 0.0)
        term /= k + 1
        factor = factor * time
        total += term * factor
    return total


def _write(out: FloatArray, given: _Given, state: _State, length: float, k: int) -> None:
    tops, case = state.tops, given.case
    out[[table.PEAK_ATTITUDE, table.PEAK_RATE], case[:, np.newaxis]] = tops[:2].T
    out[[table.PEAK_DEFLECTION, table.PEAK_DEFLECTION_RATE], case[:, np.newaxis]] = tops[2:4].T
    out[table.PEAK_ALPHA, case] = tops[4]
    out[table.FINAL_ATTITUDE, case] = state.x[0]
    out[table.ENDED, case] = given.rows[table.START] + k * length
    out[table.SATURATED, case] = tops[5] / max(k, 1)
    out[table.FATE, case] = state.fate
