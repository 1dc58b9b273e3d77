"""Real poles that straight lines drive, at even times: the common case of compiled responses.

Some cases at a time are laid out in lanes, their modes solved side by side (`straight`), and then
their times written, one case after the other. What is not plain is left to `responses`: cases
with a mode that is slow in one of the spans, with poles near to each other, or with exponentials
too large for a table.
"""

from typing import Any, NamedTuple

import numpy as np

from tvclin.kernels.compiled.blocks import BLOCK, LARGE, UNEVEN, add, grid, real_powers
from tvclin.kernels.compiled.compiler import compiled, lean
from tvclin.kernels.compiled.exponentials import exponential
from tvclin.kernels.compiled.residues import all_roundings, too_near
from tvclin.kernels.compiled.straight import (
    BEGIN,
    CONSTANT,
    DEFLECTION,
    FAR,
    GAINS,
    KNOT,
    LANES,
    LINEAR,
    POLE,
    ROUNDINGS,
    SCALE,
    SIZE,
    SLOPE,
    SPAN,
    VALUE,
    WIDTH,
    WIND,
    head,
    part,
    solve,
)

DONE = 1
"""The status of a case that is answered."""
_SLOW = 0.5
"""No pole of a plain case times one of its spans is smaller."""


class Room(NamedTuple):
    """What a group of cases is made of.

    Rows of spans and of modes for `straight`; for each lane the positions of the first times of
    its spans, and whether it is plain; exponentials of all modes at the steps of an even grid, and
    what they are multiplied by in one output, each with a row for a mode that is not there.
    """

    spans: Any
    modes: Any
    edges: Any
    plain: Any
    tables: Any
    factors: Any


@compiled
def respond_straight(  # type: ignore[no-untyped-def]
    times, plants, deflections, winds, which, near, out, status, first, last
):
    """Answer the plain cases from `first` up to `last`, and mark them as done.

    The parameters are those of `responses.respond`.
    """
    if not (_straight(deflections[1], deflections[2]) and _straight(winds[1], winds[2])):
        return
    step, off = grid(times)
    if step == 0.0:
        return
    modes, count = plants[0].shape[1], deflections[0].shape[1] + winds[0].shape[1]
    room = Room(
        np.zeros(SPAN * count * LANES),
        np.zeros(head(modes, count) * LANES),
        np.zeros((LANES, count + 1), np.int64),
        np.zeros(LANES, np.bool_),
        np.zeros((modes + 1, BLOCK)),
        np.zeros(modes + 1),
    )
    known = np.int64(-1)
    for begin in range(first, last, LANES):
        end = min(begin + LANES, last)
        some = which[:, begin:end]
        if not _lay_out(times, step, off, plants, deflections, winds, some, near, room):
            continue
        for mode in range(modes):
            solve(room.spans, room.modes, mode, count)
        known = _write(times, step, plants, some[0], known, room, out[begin:end])
        _note(room.plain, status[begin:end])


@lean
def _straight(coefficients, rates):  # type: ignore[no-untyped-def]
    """Whether all histories are straight lines between their knots."""
    straight = coefficients.shape[2] == 1 and coefficients.shape[3] == 2
    for i in range(rates.shape[0]):
        straight = straight and rates[i, 0] == 0.0
    return straight


@lean
def _note(plain, status):  # type: ignore[no-untyped-def]
    for lane in range(status.size):
        if plain[lane]:
            status[lane] = DONE


@lean
def _at(number, lane):  # type: ignore[no-untyped-def]
    """Return where one number of a case stands."""
    return np.uint64(number * LANES + lane)


@lean
def _lay_out(times, step, off, plants, deflections, winds, which, near, room):  # type: ignore[no-untyped-def]
    """Put some cases into lanes, and return whether one of them is plain."""
    count, found = room.edges.shape[1] - 1, False
    for lane in range(which.shape[1]):
        p, d, w = which[0, lane], which[1, lane], which[2, lane]
        poles, gains = plants[0][p], plants[1][p]
        deflection, wind = (deflections[0][d], deflections[1][d]), (winds[0][w], winds[1][w])
        slowest, fastest = _sizes(poles)
        since = max(times[-1] - min(deflection[0][0], wind[0][0]), 0.0)
        plain = fastest * max(since, step * BLOCK) <= LARGE and fastest * off <= UNEVEN
        plain = plain and slowest * since >= _SLOW and not too_near(poles, since, near)
        if plain:
            _put_plant(poles, gains, deflection[0], wind[0], room.modes, count, lane)
            least = _put_inputs(times, step, deflection, wind, room.spans, room.edges[lane], lane)
            room.spans[_at(SPAN * (count - 1) + WIDTH, lane)] = FAR / slowest
            plain = slowest * least >= _SLOW
        room.plain[lane] = plain
        found = found or plain
    return found


@lean
def _sizes(poles):  # type: ignore[no-untyped-def]
    """Return the sizes of the slowest pole and of the fastest."""
    slowest, fastest = np.inf, 0.0
    for mode in range(poles.size):
        size = abs(poles[mode])
        slowest, fastest = min(slowest, size), max(fastest, size)
    return slowest, fastest


@lean
def _put_inputs(times, step, deflection, wind, spans, edges, lane):  # type: ignore[no-untyped-def]
    """Write both inputs on the knots of both; return the least time that one span is in use."""
    i, j, least, before, end = 0, 0, np.inf, 0.0, times[-1]
    for k in range(edges.size - 1):
        if j == wind[0].size or (i < deflection[0].size and deflection[0][i] <= wind[0][j]):
            knot, i = deflection[0][i], i + 1
        else:
            knot, j = wind[0][j], j + 1
        first = _first_at(times, step, knot)
        edges[k] = first
        spans[_at(SPAN * k + KNOT, lane)] = knot
        spans[_at(SPAN * k + BEGIN, lane)] = times[first] - knot if first < times.size else 0.0
        _put_line(deflection, i - 1, knot, spans, SPAN * k + DEFLECTION, lane)
        _put_line(wind, j - 1, knot, spans, SPAN * k + WIND, lane)
        if k > 0:
            spans[_at(SPAN * (k - 1) + WIDTH, lane)] = knot - before
            least = min(least, _used(before, knot, end))
        before = knot
    edges[edges.size - 1] = times.size
    return min(least, _used(before, np.inf, end))


@lean
def _used(begin, stop, end):  # type: ignore[no-untyped-def]
    """Return how long a span lasts, or until the end if that is within; no span of no width."""
    if stop == begin:
        return np.inf
    return min(stop, end) - begin if begin < end else stop - begin


@lean
def _put_line(history, piece, knot, spans, first, lane):  # type: ignore[no-untyped-def]
    """Write what one input is from the knot on."""
    value, slope, size = 0.0, 0.0, 0.0
    if piece >= 0:
        value, slope = history[1][piece, 0, 0], history[1][piece, 0, 1]
        since = knot - history[0][piece]
        size = abs(value) + abs(slope) * since
        value += slope * since
    spans[_at(first + VALUE, lane)] = value
    spans[_at(first + SLOPE, lane)] = slope
    spans[_at(first + SIZE, lane)] = size


@lean
def _first_at(times, step, knot):  # type: ignore[no-untyped-def]
    """Return the position of the first of even times at or after the knot."""
    near = np.ceil((knot - times[0]) / step)
    first = int(min(max(near, 0.0), float(times.size)))
    while first > 0 and times[first - 1] >= knot:
        first -= 1
    while first < times.size and times[first] < knot:
        first += 1
    return first


@lean
def _put_plant(poles, gains, deflection, wind, modes, count, lane):  # type: ignore[no-untyped-def]
    """Write what a plant is."""
    start = min(deflection[0], wind[0])
    for mode in range(poles.size):
        first = head(mode, count)
        modes[_at(first + POLE, lane)] = poles[mode]
        modes[_at(first + GAINS, lane)] = gains[mode, 0]
        modes[_at(first + GAINS + 1, lane)] = gains[mode, 1]
        roundings = all_roundings(poles[mode], start, deflection, wind)
        modes[_at(first + ROUNDINGS, lane)] = roundings


@lean
def _write(times, step, plants, which, known, room, out):  # type: ignore[no-untyped-def]
    """Write the outputs of the plain cases; return the plant of which there are tables now."""
    modes, size = plants[0].shape[1], min(times.size, BLOCK)
    for lane in range(which.size):
        if not room.plain[lane]:
            continue
        poles, outputs = plants[0][which[lane]], plants[2][which[lane]]
        if which[lane] != known:
            known = which[lane]
            for mode in range(modes):
                real_powers(poles[mode] * step, size, room.tables[modes], room.tables[mode])
        for r in range(out.shape[1]):
            less_wind = plants[3] and r == out.shape[1] - 1
            _write_output(times, step, poles, outputs[:, r], less_wind, room, lane, out[lane, r])
    return known


@lean
def _write_output(times, step, poles, shares, less_wind, room, lane, line):  # type: ignore[no-untyped-def]
    """Write one output of one case, span by span."""
    edges, spans, modes = room.edges[lane], room.spans, room.modes
    tables, factors = room.tables, room.factors
    count = edges.size - 1
    for j in range(edges[0]):
        line[j] = 0.0
    for i in range(count):
        knot, constant, linear = spans[_at(SPAN * i + KNOT, lane)], 0.0, 0.0
        if less_wind:
            constant = -spans[_at(SPAN * i + WIND + VALUE, lane)]
            linear = -spans[_at(SPAN * i + WIND + SLOPE, lane)]
        for mode in range(shares.size):
            constant += shares[mode] * modes[_at(part(mode, i, count) + CONSTANT, lane)]
            linear += shares[mode] * modes[_at(part(mode, i, count) + LINEAR, lane)]
        for start in range(edges[i], edges[i + 1], BLOCK):
            stop, passed = min(start + BLOCK, edges[i + 1]), step * (start - edges[i])
            for mode in range(shares.size):
                factors[mode] = shares[mode] * modes[_at(part(mode, i, count) + SCALE, lane)]
                if passed > 0.0:
                    factors[mode] *= exponential(poles[mode] * passed)
            some, local, first, second = line[start:stop], times[start:stop], tables[0], tables[1]
            _begin(some, local, knot, constant, linear, factors[0], first, factors[1], second)
            for mode in range(2, shares.size, 2):
                first, second = tables[mode], tables[mode + 1]
                add(some, factors[mode], first, factors[mode + 1], second)


@lean
def _begin(line, times, knot, constant, linear, a, first, b, second):  # type: ignore[no-untyped-def]
    for j in range(line.size):
        line[j] = constant + linear * (times[j] - knot) + (a * first[j] + b * second[j])
