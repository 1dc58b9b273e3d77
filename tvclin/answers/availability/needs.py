"""What many winds ask of a vehicle along its flight: `varying_need` with K = 1, for all at once.

Trim until its deflection reaches the limit, then the limit held: the least limit with which this
brings the growing part to zero. As in `switching`, only new heights of the trim deflection leave
the dead band, and of several solutions the last has the largest limit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tvclin.answers.availability.tables import FlightTables, TableRows

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_SLACK = 1e-9
"""A height that is lower by this part is as high."""
_HALVINGS = 30
"""Of a line between two knots, half a second or so, in which the limit is reached."""

_TILTS = (-1.6, -0.8, 0.0, 0.8, 1.6)
"""Of the logarithm of what winds weigh, from one end of a flight to the other."""


def needs_of_winds(
    tables: FlightTables, times: FloatArray, wind: FloatArray, rows: TableRows | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return the limits that winds ask for, and when trim first takes so much.

    Parameters
    ----------
    tables : FlightTables
        The flight.
    times : ndarray
        Knots of each wind [s], not decreasing, ``(r, k)``; lines of no length count for nothing.
    wind : ndarray
        Wind angles [rad] at the knots, ``(r, k)``; what is below zero is taken as zero.
    rows : TableRows, optional
        ``tables.at(times)``, where it is there already.

    Returns
    -------
    need, leaves : ndarray
        [rad] and [s], ``(r,)``; zero and the first knot where nothing blows to that side.
    """
    winds = _Winds.of(tables, times, wind, tables.at(times) if rows is None else rows)
    demand = winds.rows.demand(winds.to_come, winds.path)
    trim = winds.rows.trim(np.maximum(wind, 0.0), winds.path)
    last, then, floor = _last_short(trim, demand)
    everyone, end = np.arange(last.size), times.shape[-1] - 1
    never, at = then > end, np.minimum(then, end)
    need = np.where(last < 0, demand[everyone, at], floor)
    need = np.where(never, np.maximum(trim.max(axis=-1), 0.0), need)
    leaves = times[everyone, at]
    solved = np.flatnonzero((last >= 0) & ~never & (2 * then - last <= 2))
    if solved.size:
        need[solved], leaves[solved] = winds.solved(solved, then[solved] - 1, floor[solved])
    return need, leaves


def most_returning(
    tables: FlightTables, times: FloatArray, wind: FloatArray, rows: TableRows | None = None
) -> FloatArray:
    """Return what winds that come back may take of a trim law flown, over (4b), ``(r,)``.

    The limit that (4b) asks for is that of the first time at which trim takes so much. A law that
    has let go meets all that comes later anew: it survives where at no time both trim and demand
    are above the limit. A frozen vehicle weighs early and late winds otherwise than one whose
    parameters vary: B is taken out, and what is left tilts by `_TILTS`.

    Parameters
    ----------
    tables, times, wind, rows
        As of `needs_of_winds`.
    """
    winds = _Winds.of(tables, times, wind, tables.at(times) if rows is None else rows)
    demand = winds.rows.demand(winds.to_come, winds.path)
    trim = winds.rows.trim(np.maximum(wind, 0.0), winds.path)
    part = (times - tables.start) / (tables.step * (tables.rows.shape[0] - 1))
    everyone, end = np.arange(times.shape[0]), times.shape[-1] - 1
    places, most = np.arange(times.shape[1]), np.ones(times.shape[0])
    for tilt in _TILTS:
        weight = np.exp(tilt * part) / winds.rows.rows[..., 3]
        d, own = weight * demand, weight * trim
        last, then, floor = _last_short(own, d)
        at = np.minimum(then, end)
        both = np.minimum(own, d)
        least = np.minimum(d[everyone, np.maximum(at - 1, 0)], d[everyone, at])
        least = np.where(last < 0, d[everyone, at], np.maximum(least, floor))
        # as long as trim stays above the demand it is the same time of no return
        after = places >= at[:, np.newaxis]
        held = after & ~np.logical_or.accumulate(after & (own < d), axis=-1)
        least = np.maximum(least, np.max(np.where(held, both, 0.0), axis=-1))
        least = np.where(then > end, own.max(axis=-1), least)
        returns = both.max(axis=-1)
        more = np.divide(returns, least, out=np.ones_like(least), where=least > 0.0)
        most = np.maximum(most, more)
    return most


def _last_short(
    trim: FloatArray, demand: FloatArray
) -> tuple[NDArray[np.intp], NDArray[np.intp], FloatArray]:
    """Where a new height of trim is last below the demand, which knot is new next, and that height.

    The place is 2 k for the knot k, and 2 k - 1 where trim, after it had fallen, comes back to its
    height between the knots k - 1 and k; -1 for nowhere.
    """
    highest = np.maximum.accumulate(trim, axis=-1)
    new = (trim >= highest * (1.0 - _SLACK)) & (trim > 0.0)
    count = trim.shape[-1]
    short = np.zeros((trim.shape[0], 2 * count), dtype=bool)
    short[:, ::2] = new & (trim < demand)
    # on straight lines between knots, trim comes back to the height h at the part p of the way
    h, rise = highest[:, :-1], trim[:, 1:] - trim[:, :-1]
    comes = new[:, 1:] & ~new[:, :-1] & (h > 0.0) & (rise > 0.0)
    p = np.divide(h - trim[:, :-1], rise, out=np.zeros_like(h), where=comes)
    short[:, 1:-2:2] = comes & (demand[:, :-1] + p * (demand[:, 1:] - demand[:, :-1]) > h)
    last = np.max(np.where(short, np.arange(2 * count), -1), axis=-1)
    later = new & (2 * np.arange(count) > last[:, np.newaxis])
    then = np.where(later.any(axis=-1), np.argmax(later, axis=-1), count)
    return last, then, highest[np.arange(last.size), np.maximum(last, 0) // 2]


@dataclass(frozen=True, eq=False)
class _Winds:
    """Winds of straight lines with their integrals: U and X of `tables` at each knot."""

    tables: FlightTables
    times: FloatArray
    wind: FloatArray
    slope: FloatArray
    rows: TableRows
    to_come: FloatArray
    path: FloatArray

    @classmethod
    def of(
        cls, tables: FlightTables, times: FloatArray, wind: FloatArray, rows: TableRows
    ) -> _Winds:
        width = np.diff(times)
        goes = width > 0.0
        left, right = wind[:, :-1], wind[:, 1:]
        slope = np.divide(right - left, width, out=np.zeros_like(width), where=goes)
        blows = np.where(goes & ((left > 0.0) | (right > 0.0)), 1.0, 0.0)
        turns = np.nonzero((left * right < 0.0) & goes)
        calm = times[:, :-1][turns] - left[turns] / slope[turns]
        turned = tables.at(calm)
        rises = (left[turns] < 0.0)[:, np.newaxis]
        high = np.maximum(wind, 0.0)[..., np.newaxis]
        sums = []
        for integrals, there in ((rows.ahead, turned.ahead), (rows.path, turned.path)):
            G0, G1 = integrals
            ends = [np.array(G1[:, :-1]), np.array(G1[:, 1:])]
            ends[0][turns] = np.where(rises, there[1], ends[0][turns])
            ends[1][turns] = np.where(rises, ends[1][turns], there[1])
            level = high[:, 1:] * G0[:, 1:] - high[:, :-1] * G0[:, :-1]
            sums.append(
                blows[..., np.newaxis] * (level - slope[..., np.newaxis] * (ends[1] - ends[0]))
            )
        nothing = np.zeros_like(wind[:, :1])
        ahead = np.cumsum(sums[0][:, ::-1, 0], axis=-1)[:, ::-1]
        return cls(
            tables=tables,
            times=times,
            wind=wind,
            slope=slope,
            rows=rows,
            to_come=np.concatenate([ahead, nothing], axis=-1),
            path=np.concatenate([0.0 * sums[1][:, :1], np.cumsum(sums[1], axis=1)], axis=1),
        )

    def solved(
        self, which: NDArray[np.intp], line: NDArray[np.intp], floor: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """The demand [rad] where it meets trim, and the time [s], each on one line of one wind."""
        at = which, line
        begin, stop = self.times[at], self.times[which, line + 1]
        left, slope = self.wind[at], self.slope[at]
        low, high = np.array(begin), np.array(stop)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            trim, demand = self._on_line(which, line, middle, left + slope * (middle - begin))
            short = np.maximum(trim, floor) < demand
            low, high = np.where(short, middle, low), np.where(short, high, middle)
        _, demand = self._on_line(which, line, high, left + slope * (high - begin))
        return demand, high

    def _on_line(
        self, which: NDArray[np.intp], line: NDArray[np.intp], t: FloatArray, wind: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Trim and demand [rad] at times on lines: a line up to there is taken off, or added."""
        part = np.stack([self.times[which, line], t], axis=-1)
        ends = np.stack([self.wind[which, line], wind], axis=-1)
        rows = self.tables.at(part)
        begun = _Winds.of(self.tables, part, ends, rows)
        to_come = self.to_come[which, line] - begun.to_come[:, 0]
        path = self.path[which, line] + begun.path[:, 1]
        here = TableRows(rows.rows[:, 1], rows.order)
        return here.trim(np.maximum(wind, 0.0), path), here.demand(to_come, path)
