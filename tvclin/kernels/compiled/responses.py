"""Compiled twin of `kernels.responses`: one case after another, time innermost.

Each case is taken apart between its knots (`spans`), and the times of each span are answered in
blocks (`blocks`). A case needs nothing of its neighbours. Plain ones are answered before, several
side by side (`straight_cases`).

The machine code of `forces`, `residues`, `spans` and `blocks` is kept with this file's, and made
anew when this file changes: who changes one of those deletes `__pycache__`.
"""

import numpy as np

from tvclin.kernels.compiled.blocks import BLOCK, block, fill, grid, room_for_tables
from tvclin.kernels.compiled.compiler import compiled, lean, merged
from tvclin.kernels.compiled.forces import merge, put_on_knots, room_for_forces, values
from tvclin.kernels.compiled.residues import all_roundings, residue, too_near
from tvclin.kernels.compiled.spans import SLOW, System, lay_out, room_for_span
from tvclin.kernels.compiled.straight_cases import DONE, respond_straight

__all__ = ["DONE", "NEAR", "OTHER", "respond", "respond_straight", "rises", "values"]

NEAR, OTHER = DONE + 1, DONE + 2
"""What else becomes of a case: its poles are too near; it needs the other twin."""


@compiled
def rises(times):  # type: ignore[no-untyped-def]
    """Whether the times do not decrease."""
    falls = 0
    for j in range(1, times.size):
        falls += times[j] < times[j - 1]
    return falls == 0


@compiled
def respond(times, plants, deflections, winds, which, near, out, status, first, last):  # type: ignore[no-untyped-def]
    """Answer the cases from `first` up to `last`.

    Parameters
    ----------
    times : ndarray
        Times, rising, ``(n,)``.
    plants : tuple of ndarray
        Poles ``(P, N)``, gains ``(P, N, 2)``, outputs ``(P, N, R)``, and whether the wind is taken
        off the last of these.
    deflections, winds : tuple of ndarray
        Knots ``(H, n)``, coefficients ``(H, n, r, m)`` and rates ``(H, r)``.
    which : ndarray
        The plant, the deflection and the wind of each case, ``(3, cases)``.
    near : tuple of float
        What `too_near` takes.
    out, status : ndarray
        Written: ``(cases, R, n)`` and ``(cases,)``.
    """
    modes, outputs = plants[0].shape[1], plants[2].shape[2]
    rates = deflections[2].shape[1] + winds[2].shape[1]
    degree = max(deflections[1].shape[3], winds[1].shape[3])
    knots = deflections[0].shape[1] + winds[0].shape[1]
    forces = room_for_forces(plants[0], knots, rates, degree)
    span = room_for_span(plants[0], modes, outputs, knots, rates, degree)
    forces.own[0] = deflections[2].shape[1]
    tables = room_for_tables(plants[0], modes + rates, outputs)
    step, off = grid(times)
    for case in range(first, last):
        p, d, w = which[0, case], which[1, case], which[2, case]
        system = System(plants[0][p], plants[1][p], plants[2][p], plants[3])
        count = merge(deflections[0][d], winds[0][w], forces.knots)
        start = forces.knots[0]
        if too_near(system.poles, max(times[-1] - start, 0.0), near):
            status[case] = NEAR
            continue
        put_on_knots(forces, count, 0, deflections[0][d], deflections[1][d], deflections[2][d])
        put_on_knots(forces, count, forces.own[0], winds[0][w], winds[1][w], winds[2][w])
        status[case] = OTHER
        if _directions(
            system, forces, count, times[-1] - start, deflections[0][d], winds[0][w], span
        ):
            even = fill(tables, system.poles, forces.rates, step, off)
            if _one(times, step, even, system, forces, count, span, tables, out[case]):
                status[case] = DONE


@merged
def _directions(system, forces, count, ahead, first, second, span):  # type: ignore[no-untyped-def]
    """Choose which modes are carried backward, with their residues and futures; False if none is.

    One that does not grow by more than e may as well go forward.
    """
    size = 0.0
    for mode in range(system.poles.size):
        size = max(size, abs(system.poles[mode]))
    for mode in range(system.poles.size):
        pole = system.poles[mode]
        grows = np.real(pole) > 1e-12 * size and abs(pole) * ahead > SLOW
        span.backward[mode] = grows
        span.state[mode] = 0.0
        if grows:
            roundings = all_roundings(pole, forces.knots[0], first, second)
            if not residue(system, mode, forces, count, span, roundings):
                return False
    return True


@merged
def _one(times, step, even, system, forces, count, span, tables, out):  # type: ignore[no-untyped-def]
    """Answer one case, span by span."""
    first, last = 0, times.size
    while first < last and times[first] < forces.knots[0]:
        first += 1
    for r in range(out.shape[0]):
        for j in range(first):
            out[r, j] = 0.0
    for i in range(count):
        here = forces.knots[i]
        if first == last:
            break
        _turn_back(system, forces, i, span)
        reach = min(forces.knots[i + 1], times[last - 1]) - here
        length = lay_out(system, forces, i, reach, span)
        if length == 0:
            return False
        stop = _first_at(times, first, last, forces.knots[i + 1])
        while first < stop:
            size = min(BLOCK, stop - first)
            block(times, first, size, even, system, forces, i, length, span, tables, out)
            first += size
    return True


@merged
def _turn_back(system, forces, i, span):  # type: ignore[no-untyped-def]
    """Set the states of modes carried backward at the beginning of span `i`."""
    for mode in range(system.poles.size):
        if span.backward[mode]:
            span.state[mode] = -span.future[mode, i]
            if span.excess[mode] != 0.0:
                since = forces.knots[i] - forces.knots[0]
                span.state[mode] += span.excess[mode] * np.exp(system.poles[mode] * since)


@lean
def _first_at(times, low, high, knot):  # type: ignore[no-untyped-def]
    """Return the position of the first time at or after the knot."""
    while low < high:
        middle = (low + high) // 2
        if times[middle] < knot:
            low = middle + 1
        else:
            high = middle
    return low
