"""Flights of laws that are computed without pause: chains of Taylor series, side by side.

Where no limit is met, left or passed over, a flight is linear and its series is a recurrence. A
step is as long as the last terms allow; it ends early at a knot of the wind, and where a limit is
met: the deflection asked for reaches the limit (or lets go), the nozzle its stop, or its rate the
rate limit. Twins choose the same steps but for rounding, and agree as well as either is exact.
"""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels import flight_table as table
from tvclin.kernels.choice import compiled_twin
from tvclin.kernels.flight_table import FlightTable, FloatArray
from tvclin.kernels.law_demand import inside, switched
from tvclin.kernels.ringing import CALM, RINGING, ringings, settled
from tvclin.kernels.series import Series, exits, jet, lengths, summits, taylor
from tvclin.kernels.threads import in_slices

_NUMPY, _COMPILED = 0.5, 5e-6
"""Seconds for a batch of a thousand flights, and of one flight compiled, or so."""
_SIDES = 3
_POWERS = table.ORDER + 2
"""Coefficients of a piece of wind for which the compiled twin has room."""


def linear_flights(flights: FlightTable) -> FloatArray:
    """Return the results of flights of linear laws, ``(9, m)``: the rows of `flight_table`."""
    cases = flights.which.size
    out = np.zeros((table.RESULTS, cases))
    twin = compiled_twin("arcs", _NUMPY * (1.0 + cases / 1000.0))
    if twin is None or flights.wind.shape[2] > _POWERS:
        _fly(flights, out)
        return out

    def work(first: int, last: int) -> None:
        twin.fly(
            flights.rows, flights.order, flights.servo, flights.knots, flights.wind,
            flights.which, first, last, out,
        )  # fmt: skip

    in_slices(work, cases, cases * _COMPILED)
    return out


@dataclass(frozen=True, eq=False)
class _State:
    """Where flights are, the case last.

    The ringing of the nozzles, states of plant, nozzle and law ``(7, m)``, coefficients of the
    wind, the regions of command, stop and rate limit (one side, the other, or zero), times (now,
    left to the next stop, of the next look), sizes and fate.
    """

    case: NDArray[np.intp]
    rows: FloatArray
    which: NDArray[np.int64]
    own: NDArray[np.complex128]
    y: FloatArray
    wind: FloatArray
    regions: FloatArray
    now: FloatArray
    left: FloatArray
    look: FloatArray
    trial: FloatArray
    quiet: FloatArray
    full: FloatArray
    tops: FloatArray
    fate: NDArray[np.int64]
    cursor: NDArray[np.intp]

    def take(self, index: Any) -> "_State":
        return _State(**{f.name: getattr(self, f.name)[..., index] for f in fields(self)})

    def put(self, index: Any, part: "_State") -> None:
        for f in fields(self):
            getattr(self, f.name)[..., index] = getattr(part, f.name)


def _fly(flights: FlightTable, out: FloatArray) -> None:
    state = _begun(flights)
    begin = state.now.copy()
    for _ in range(table.MOST):
        if not state.case.size:
            return
        state = _stepped(flights, state)
        ended = np.isinf(state.look) & np.isinf(state.rows[table.UNTIL])
        ended |= state.now >= state.rows[table.UNTIL]
        if np.any(ended):
            _write(out, state.take(ended), begin)
            state = state.take(~ended)
    _write(out, state, begin)


def _begun(flights: FlightTable) -> _State:
    m = flights.which.size
    zero, own = np.zeros(m), np.zeros((RINGING, m), complex)
    if flights.servo == 2:
        with np.errstate(divide="ignore", invalid="ignore"):  # nozzles that do not swing
            own = ringings(flights.rows)
        own = np.where(own[CALM].real > 0.0, own, 0.0)
    end = flights.rows[table.END]
    until = flights.rows[table.UNTIL]
    look = np.where(np.isinf(until), end, until)
    look = np.where(np.isnan(flights.rows[table.REACH]), np.inf, look)
    state = _State(
        np.arange(m), flights.rows, flights.which, own,
        np.zeros((7, m)), np.zeros((flights.wind.shape[2], m)), np.zeros((3, m)),
        zero, zero.copy(), look, np.full(m, table.BEGIN), end.copy(), zero.copy(),
        np.zeros((5, m)), np.zeros(m, np.int64), np.full(m, -1),
    )  # fmt: skip
    return _arrived(flights, state)


def _stepped(flights: FlightTable, state: _State) -> _State:
    """Step all flights: to the tolerance, to a knot, or to the first limit that is met."""
    rows, regions, servo = state.rows, state.regions, flights.servo
    start = state.y
    if servo == 2:
        start = settled(rows, state.own, start, state.wind, regions)
    series = taylor(rows, flights.order, servo, start, state.wind, regions)
    trial = lengths(rows, series, state.trial)
    h = np.minimum(trial, state.left)
    met = np.full(h.size, -1)
    side = np.zeros(h.size)
    watched = (series.demand, series.y[4], series.watch)[: 1 if servo == 0 else _SIDES]
    for _ in range(_SIDES):  # a step that one limit makes shorter may end beyond another
        before = met
        for k, c in enumerate(watched):
            time, which = exits(c, h, *_bounds(rows, regions[k], k, servo))
            sooner = (which != 0.0) & (met != k) & ((time < h) | ((time == h) & (met < 0)))
            met, side = np.where(sooner, k, met), np.where(sooner, which, side)
            h = np.where(sooner, time, h)
        if np.all(met == before):
            break
    tops = _tops(rows, regions, series, h, servo, state.tops)
    y = jet(series.y, h)[0]
    wind = state.wind.copy()
    for low in range(len(wind) - 1):
        for j in range(len(wind) - 2, low - 1, -1):
            wind[j] += wind[j + 1] * h
    left = state.left - h
    full = state.full + np.where(regions[0] != 0.0, h, 0.0)
    state = replace(
        state, y=y, wind=wind, now=state.now + h, left=left, trial=trial, full=full, tops=tops,
        regions=regions.copy(),
    )  # fmt: skip
    state = replace(state, quiet=_stirred(state))
    _switch(state, met, side, servo)
    here = left <= 0.0
    if np.any(here):
        state = replace(state, **{f.name: getattr(state, f.name).copy() for f in fields(state)})
        state.put(here, _arrived(flights, state.take(here)))
    return state


def _bounds(rows: FloatArray, region: FloatArray, which: int, servo: int) -> Any:
    """Least and largest value in a region: of the demand, the nozzle, or what watches its rate."""
    limit, most = rows[table.LIMIT], rows[table.RATE_LIMIT]
    enters = (rows[table.ENGAGE], (1.0 + table.SLACK) * limit, most)[which]
    leaves = (rows[table.RELEASE], limit, 0.0 * limit if servo == 2 else most)[which]
    low = np.where(region == 0.0, -enters, np.where(region > 0.0, leaves, -np.inf))
    high = np.where(region == 0.0, enters, np.where(region < 0.0, -leaves, np.inf))
    return low, high


def _tops(
    rows: FloatArray,
    regions: FloatArray,
    series: Series,
    h: FloatArray,
    servo: int,
    tops: FloatArray,
) -> FloatArray:
    """Largest sizes so far of attitude, rate, nozzle, its rate, and angle of attack."""
    rate = np.where(regions[2] == 0.0, series.watch, 0.0)
    watched = (series.y[0], series.y[1], series.y[4], rate, series.alpha)
    found = np.stack([summits(c, h, top) for c, top in zip(watched, tops, strict=True)])
    if servo:
        held = (regions[2] != 0.0) * 1.0
        found[3] = np.maximum(found[3], np.where(held > 0.0, rows[table.RATE_LIMIT], 0.0))
    return found


def _switch(state: _State, met: NDArray[Any], side: FloatArray, servo: int) -> None:
    """Put flights into the regions behind the limits they have met."""
    regions, rows = state.regions, state.rows
    for k in range(_SIDES):
        here = met == k
        regions[k, here] = np.where(regions[k, here] == 0.0, side[here], 0.0)
    caught = (met == 2) & (regions[2] != 0.0)
    if servo == 2:
        state.y[5, caught] = regions[2, caught] * rows[table.RATE_LIMIT, caught]
    commanded = met == 0
    if servo and np.any(commanded):
        some = state.take(commanded)
        regions[2, commanded] = _held(some, servo)


def _asked(state: _State) -> FloatArray:
    rows, y = state.rows, state.y
    alpha = y[0] - y[2] - state.wind[0]
    asked = rows[table.K_ATTITUDE] * y[0] + rows[table.K_PATH] * y[2] + rows[table.K_RATE] * y[1]
    return np.asarray(asked + rows[table.K_ALPHA] * alpha + rows[table.K_MEMORY] * y[6])


def _held(state: _State, servo: int) -> FloatArray:
    """Whether the rate limit holds the nozzle, chosen anew where the command may have jumped."""
    rows, mode, limit = state.rows, state.regions[0], state.rows[table.LIMIT]
    asked = np.where(mode != 0.0, mode * limit, np.clip(_asked(state), -limit, limit))
    pull, most = rows[table.STIFFNESS] * (asked - state.y[4]), rows[table.RATE_LIMIT]
    if servo == 1:
        return np.where(np.abs(pull) >= most, np.sign(pull), 0.0)
    spin = state.y[5]
    pull = pull - rows[table.DRAG] * spin
    return np.where((np.abs(spin) >= most) & (pull * spin > 0.0), np.sign(spin), 0.0)


def _arrived(flights: FlightTable, state: _State) -> _State:
    """Put flights that have come to a knot upon the next piece of wind; look at those due."""
    last = flights.knots.shape[1] - 1

    def following(cursor: NDArray[np.intp]) -> FloatArray:
        knot = flights.knots[state.which, np.minimum(cursor + 1, last)]
        return np.where(cursor < last, knot, np.inf)

    now, cursor = np.minimum(following(state.cursor), _stop(state)), state.cursor
    while np.any(passed := following(cursor) <= now):
        cursor = cursor + passed
    new = cursor > state.cursor
    wind = flights.wind[state.which, np.maximum(cursor, 0)].T
    wind = np.where(new, wind, state.wind)
    state = replace(state, now=now, cursor=cursor, wind=wind)
    regions = state.regions.copy()
    regions[0] = np.where(new, switched(state.rows, _asked(state), regions[0]), regions[0])
    state = replace(state, regions=regions)
    if flights.servo:
        regions[2] = np.where(new, _held(state, flights.servo), regions[2])
    state = _looked_at(state)
    return replace(state, left=np.minimum(following(cursor), _stop(state)) - now)


def _stop(state: _State) -> FloatArray:
    """When flights are stopped next, wherever the knots are: to be looked at, or for good."""
    return np.minimum(state.look, state.rows[table.UNTIL])


def _looked_at(state: _State) -> _State:
    """Judge flights that are due after their winds; look again until all is known."""
    rows, now, end = state.rows, state.now, state.rows[table.END]
    due = (now >= np.maximum(end, _stop(state))) & np.isfinite(state.look)
    if not np.any(due):
        return state
    recoverable, _ = inside(rows, state.y[:4])
    calm = now - state.quiet >= table.NEARLY * rows[table.CALM]
    fate = np.where(calm, table.SURVIVED, table.UNDECIDED)
    fate = np.where(recoverable, fate, table.LOST)
    again = np.where(
        (fate == table.UNDECIDED) & (now < end + rows[table.PATIENCE]),
        now + rows[table.CALM] / table.LOOKS,
        np.inf,
    )
    look, fate = np.where(due, again, state.look), np.where(due, fate, state.fate)
    return replace(state, fate=fate, look=look)


def _stirred(state: _State) -> FloatArray:
    """When flights were last not calm [s]; at a look alone a swing may just pass zero."""
    after = state.now >= state.rows[table.END]
    if not np.any(after):
        return state.quiet
    _, size = inside(state.rows, state.y[:4])
    large = size >= table.SETTLED * state.rows[table.REACH]
    return np.where(after & large, state.now, state.quiet)


def _write(out: FloatArray, state: _State, begin: FloatArray) -> None:
    rows, tops, case = state.rows, state.tops, state.case
    out[table.PEAK_ATTITUDE, case], out[table.PEAK_RATE, case] = tops[0], tops[1]
    out[table.PEAK_DEFLECTION, case] = np.minimum(tops[2], rows[table.LIMIT])
    out[table.PEAK_DEFLECTION_RATE, case] = np.minimum(tops[3], rows[table.RATE_LIMIT])
    out[table.PEAK_ALPHA, case], out[table.FINAL_ATTITUDE, case] = tops[4], state.y[0]
    out[table.ENDED, case] = state.now
    out[table.SATURATED, case] = state.full / np.maximum(state.now - begin[case], 1e-300)
    out[table.FATE, case] = state.fate
