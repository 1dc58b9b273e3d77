"""Soundings as they come out of files: which are wanted, and what has been found so far."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tvclin.base.errors import InputError, between, number, shown, text
from tvclin.winds.soundings.archive import Soundings, months_of, years_of

_MONTHS = range(1, 13)


@dataclass(frozen=True)
class Wanted:
    """Which soundings of a file are wanted.

    `months`: from 1 to 12; empty for all. `years`: the first and the last. `station`: the only one.
    `utc_offset`: local time less UTC [h], by which months and years are counted.
    """

    months: frozenset[int] = frozenset()
    years: tuple[int, int] | None = None
    station: str | None = None
    utc_offset: float = 0.0

    @classmethod
    def of(cls, months: Any, years: Any, station: Any, utc_offset: Any) -> Wanted:
        """Return what the arguments of `read_soundings` ask for; `InputError` for what is none."""
        offset = number("utc_offset", utc_offset, between(-14, 14), "h")
        name = None if station is None else text("station", station)
        chosen = _integers("months", months, "from 1 to 12, as [2]") if months is not None else ()
        if months is not None and (not chosen or not all(m in _MONTHS for m in chosen)):
            raise InputError(f"months must be from 1 to 12, as [2]; got {shown(months)}")
        if years is None:
            return cls(frozenset(chosen), None, name, offset)
        span = _integers("years", years, "the first and the last, as (1996, 2025)")
        if len(span) != 2 or span[0] > span[1]:
            raise InputError(
                f"years must be the first and the last, as (1996, 2025); got {shown(years)}"
            )
        return cls(frozenset(chosen), (span[0], span[1]), name, offset)

    def takes(self, station: str | None, time: Any) -> bool:
        """Whether a sounding of a station and a time [UTC] is wanted."""
        if station is not None and self.station is not None and station != self.station:
            return False
        if not self.months and self.years is None:
            return True
        local = time + np.timedelta64(round(60 * self.utc_offset), "m")
        if self.months and int(months_of(local)) not in self.months:
            return False
        return self.years is None or self.years[0] <= int(years_of(local)) <= self.years[1]


@dataclass
class Collected:
    """What has been found so far: pieces of the arrays of `Soundings`, and counts of what was left.

    `pieces`: of height, east, north, counts of levels, and times. `why`: as of `Soundings`.
    `stations`: each station, and the first file it was in. `counted`: for each remark how often it
    holds, and where first.
    """

    pieces: list[tuple[Any, ...]] = field(default_factory=list)
    why: list[str] = field(default_factory=list)
    stations: dict[str, str] = field(default_factory=dict)
    counted: dict[str, list[Any]] = field(default_factory=dict)

    def count(self, remark: str, where: str = "", times: int = 1) -> None:
        """Count that a remark holds."""
        if times:
            self.counted.setdefault(remark, [0, where])[0] += times

    def add(self, other: Collected) -> None:
        """Take what was found in another file."""
        self.pieces += other.pieces
        self.why += other.why
        for name, file in other.stations.items():
            self.stations.setdefault(name, file)
        for remark, (times, where) in other.counted.items():
            self.count(remark, where, times)

    def soundings(self, utc_offset: float) -> Soundings:
        """Return all in the order of their times, each time once."""
        if len(self.stations) > 1:
            (a, where), (b, there) = list(self.stations.items())[:2]
            raise InputError(
                f"soundings must be of one station; got {a} ({where}) and {b} ({there}), so name"
                " one with station"
            )
        if not self.pieces:
            self.pieces.append(([], [], [], [], np.empty(0, "datetime64[m]")))
        height, east, north, counts, times = (
            np.concatenate(one) for one in zip(*self.pieces, strict=True)
        )
        # of one time that is there twice the first that can be used is kept
        order = np.lexsort((np.array([bool(one) for one in self.why], dtype=bool), times))
        again = np.append(False, np.diff(times[order]) == np.timedelta64(0, "m"))[: order.size]
        self.count("soundings of a time that was there already, left out", times=int(again.sum()))
        made = Soundings(
            height=height,
            east=east,
            north=north,
            offsets=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
            times=times,
            station=next(iter(self.stations), ""),
            why=tuple(self.why),
            utc_offset=utc_offset,
        )
        kept = made[order[~again]]
        bad = [f"{when} UTC, {why}" for when, why in zip(kept.times, kept.why, strict=True) if why]
        self.count("soundings that cannot be used", bad[0] if bad else "", len(bad))
        notes = tuple(
            f"{times} {remark}{f' (the first: {where})' if where else ''}"
            for remark, (times, where) in self.counted.items()
        )
        return replace(kept, notes=notes)


def _integers(name: str, values: Any, rule: str) -> list[int]:
    whole = isinstance(values, Iterable) and not isinstance(values, str | bytes)
    given: list[Any] = list(values) if whole else [None]
    if not all(isinstance(one, int | np.integer) and not isinstance(one, bool) for one in given):
        raise InputError(f"{name} must be {rule}; got {shown(values)}")
    return [int(one) for one in given]
