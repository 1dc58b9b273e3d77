"""What many winds ask of a vehicle along its flight: `varying_need` with K = 1, for all at once.

A law that trims up to the limit, and lets go of it when the attitude is back, needs at most the
largest min(trim, demand) of all times: that of the wind with both its sides, and that of what blows
to one side alone, whichever is more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tvclin.answers.availability.tables import FlightTables, TableRows
from tvclin.base.arrays import BoolArray, FloatArray

_MOST_STEPS, _MET = 40, 1e-10
"""Of the search on a line for where trim and demand meet; and how near, over either, they do."""
_NEAR = 0.01
"""On straight lines between knots, where they meet is known to less than this part."""
_CURVED = 0.002
"""Trim is above straight lines between knots by less than this part, but for what its product with
the wind adds: what makes it of a wind changes by a tenth at the most meanwhile."""
_MOST_LOOKS = 3
"""Places on lines that are looked at in each wind, those that may ask for most."""


@dataclass(frozen=True, eq=False)
class WindNeeds:
    """What winds ask for.

    `limit` is [rad], zero where nothing blows to that side; `at` when trim and demand are both as
    large [s], the first knot where nothing is asked for. With `returns` trim is above the limit
    more than once, on either side: the path of a flight that was limited before is then not that of
    trim, and the limit is met to some percent. A law with the largest size of `trim` [rad] for its
    limit is never limited. Each ``(r,)``.
    """

    limit: FloatArray
    at: FloatArray
    returns: BoolArray
    trim: FloatArray


def needs_of_winds(
    tables: FlightTables, times: FloatArray, wind: FloatArray, rows: TableRows | None = None
) -> WindNeeds:
    """Return the limits that winds ask for to the positive side.

    Of wind angles [rad] at the knots of each, times [s] that do not decrease, ``(r, k)``; lines of
    no length count for nothing. `rows` are ``tables.at(times)``, where they are there already.
    """
    rows = tables.at(times) if rows is None else rows
    blows = np.any(wind > 0.0, axis=-1)
    found = _Winds.of(tables, times, wind, rows, one_sided=False).needs()
    turns = np.flatnonzero(blows & np.any(wind < 0.0, axis=-1))
    if turns.size:
        some = TableRows(rows.rows[turns], rows.order)
        alone = _Winds.of(tables, times[turns], wind[turns], some, one_sided=True).needs()
        more = alone.limit > found.limit[turns]
        for name in ("limit", "at", "returns"):
            values = getattr(found, name)
            values[turns] = np.where(more, getattr(alone, name), values[turns])
    return found


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
    one_sided: bool

    @classmethod
    def of(
        cls,
        tables: FlightTables,
        times: FloatArray,
        wind: FloatArray,
        rows: TableRows,
        one_sided: bool,
    ) -> _Winds:
        """Return those of winds, or, `one_sided`, of what is above zero of them."""
        width = np.diff(times)
        goes = width > 0.0
        left, right = wind[:, :-1], wind[:, 1:]
        slope = np.divide(right - left, width, out=np.zeros_like(width), where=goes)
        counts, high = goes, wind[..., np.newaxis]
        turns = np.nonzero(np.zeros_like(goes))
        if one_sided:
            counts = goes & ((left > 0.0) | (right > 0.0))
            high = np.maximum(high, 0.0)
            turns = np.nonzero((left * right < 0.0) & goes)
        calm = times[:, :-1][turns] - left[turns] / slope[turns]
        turned = tables.at(calm)
        rises = (left[turns] < 0.0)[:, np.newaxis]
        sums = []
        for integrals, there in ((rows.ahead, turned.ahead), (rows.path, turned.path)):
            G0, G1 = integrals
            ends = [np.array(G1[:, :-1]), np.array(G1[:, 1:])]
            ends[0][turns] = np.where(rises, there[1], ends[0][turns])
            ends[1][turns] = np.where(rises, ends[1][turns], there[1])
            level = high[:, 1:] * G0[:, 1:] - high[:, :-1] * G0[:, :-1]
            one = level - slope[..., np.newaxis] * (ends[1] - ends[0])
            sums.append(np.where(counts[..., np.newaxis], one, 0.0))
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
            one_sided=one_sided,
        )

    def needs(self) -> WindNeeds:
        """The largest min(trim, demand) of each wind: at a knot, or on a line where both meet."""
        demand = self.rows.demand(self.to_come, self.path)
        trim = self.rows.trim(self._counted(self.wind), self.path)
        both = np.where(self.rows.paired, trim, np.minimum(trim, demand))
        everyone = np.arange(trim.shape[0])
        best = np.argmax(both, axis=-1)
        most, at = np.maximum(both[everyone, best], 0.0), self.times[everyone, best]
        over = trim - demand
        meets = over[:, :-1] * over[:, 1:] < 0.0
        # where straight lines through both ends meet
        part = np.divide(over[:, :-1], over[:, :-1] - over[:, 1:], where=meets, out=0.0 * meets)
        guess = demand[:, :-1] + part * (demand[:, 1:] - demand[:, :-1])
        guess = np.where(meets, guess, 0.0)
        for _ in range(_MOST_LOOKS):
            line = np.argmax(guess, axis=-1)
            which = np.flatnonzero(guess[everyone, line] * (1.0 + _NEAR) > most)
            if not which.size:
                break
            level, time = self.solved(which, line[which], over)
            at[which] = np.where(level > most[which], time, at[which])
            most[which] = np.maximum(most[which], level)
            guess[which, line[which]] = 0.0
        above = np.abs(trim) > most[:, np.newaxis]
        begins = above[:, 0].astype(int) + np.sum(above[:, 1:] & ~above[:, :-1], axis=-1)
        # of the product of two straight lines no more is above its ends
        bend = 0.25 * np.abs(np.diff(self.rows.per_wind) * np.diff(self.wind)).max(axis=-1)
        largest = (np.abs(trim).max(axis=-1) + bend) * (1.0 + _CURVED)
        return WindNeeds(most, at, begins > 1, largest)

    def solved(
        self, which: NDArray[np.intp], line: NDArray[np.intp], over: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """The demand [rad] where it meets trim, and the time [s], each on one line of one wind.

        By false position with the weight of an end that stays halved (the Illinois algorithm), of
        `over`, what trim is above demand at knots.
        """
        low, high = self.times[which, line], self.times[which, line + 1]
        below, above = over[which, line], over[which, line + 1]
        for _ in range(_MOST_STEPS):
            middle = high - above * (high - low) / (above - below)
            trim, demand = self._on_line(which, line, middle)
            left = trim - demand
            stays = left * above >= 0.0
            low, below = np.where(stays, low, high), np.where(stays, 0.5 * below, above)
            high, above = middle, left
            if np.all(np.abs(left) <= _MET * np.abs(demand)):
                break
        return demand, middle

    def _on_line(
        self, which: NDArray[np.intp], line: NDArray[np.intp], t: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Trim and demand [rad] at times on lines: a line up to there is taken off, or added."""
        begin, left = self.times[which, line], self.wind[which, line]
        wind = left + self.slope[which, line] * (t - begin)
        part, ends = np.stack([begin, t], axis=-1), np.stack([left, wind], axis=-1)
        rows = self.tables.at(part)
        begun = _Winds.of(self.tables, part, ends, rows, self.one_sided)
        to_come = self.to_come[which, line] - begun.to_come[:, 0]
        path = self.path[which, line] + begun.path[:, 1]
        here = TableRows(rows.rows[:, 1], rows.order)
        return here.trim(self._counted(wind), path), here.demand(to_come, path)

    def _counted(self, wind: FloatArray) -> FloatArray:
        return np.maximum(wind, 0.0) if self.one_sided else wind
