"""Archive of soundings of one station: flat arrays over all levels, and their collection.

The levels of n soundings stand one behind the other in flat arrays; ``offsets (n + 1,)`` bounds
those of each. `SoundingFilter` selects months, years and a station while files are read, and
`SoundingCollection` gathers the levels and counts what is omitted.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray, IntArray
from tvclin.base.errors import (
    InputError,
    array_of,
    between,
    each,
    instance,
    number,
    shown,
    text,
    whole_number,
    within,
)
from tvclin.base.lines import plural
from tvclin.winds.soundings.profile import RANGES, WindProfile

TOO_FEW = "it has fewer than two levels with a height and a wind"
_MINUTE = "datetime64[m]"
_STEP = 100.0
"""Between heights of a mean [m]."""
_MONTHS = range(1, 13)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Soundings:
    """Soundings of one station, in the order of their times; see `read_soundings`.

    The levels of all stand one behind the other in flat arrays; those of the sounding i are
    ``height[offsets[i]:offsets[i + 1]]``. An index gives a `WindProfile`, a slice or a mask the
    `Soundings` of these; iteration goes over the profiles of those that can be used.

    Parameters
    ----------
    height, east, north : array_like
        As of `WindProfile`, ``(m,)``, ascending within each sounding.
    offsets : array_like of int
        Where each sounding begins, and the end, ``(n + 1,)``.
    times : array_like of datetime64
        Times [UTC], ``(n,)``.
    station : str
        Its name.
    why : tuple of str
        For each sounding, why it cannot be used, with its line; empty where it can. Without it,
        those with fewer than two levels cannot.
    notes : tuple of str
        What was left out, placed or converted, with counts.
    utc_offset : float
        Local time less UTC [h], by which months, years and hours are counted.

    Raises
    ------
    InputError
        For arrays that do not belong together, and as `WindProfile`.
    """

    height: FloatArray
    east: FloatArray
    north: FloatArray
    offsets: IntArray
    times: NDArray[np.datetime64]
    station: str = ""
    why: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    utc_offset: float = 0.0

    def __post_init__(self) -> None:
        for name, (low, high, unit) in RANGES.items():
            object.__setattr__(self, name, within(name, getattr(self, name), low, high, unit))
        set_ = object.__setattr__
        set_(self, "offsets", self._whole_offsets())
        set_(self, "times", minutes("times", self.times))
        self._check_shapes()
        text("station", self.station)
        set_(self, "notes", each("notes", self.notes, str, "one for each remark"))
        set_(self, "utc_offset", number("utc_offset", self.utc_offset, between(-14, 14), "h"))
        why = each("why", self.why, str, "one for each sounding, or none")
        if not why:
            why = tuple("" if n > 1 else TOO_FEW for n in self.counts.tolist())
        set_(self, "why", why)
        if len(why) != len(self) or np.any((self.counts < 2) & self.usable):
            raise InputError("why must hold a reason for each sounding with fewer than two levels")

    def _whole_offsets(self) -> IntArray:
        offsets = array_of("offsets", self.offsets, "iu", "a row of integers")
        if offsets.ndim != 1 or not offsets.size:
            raise InputError(f"offsets must be a row of integers; got {shown(self.offsets)}")
        return offsets.astype(np.int64)

    def _check_shapes(self) -> None:
        size, offsets = self.height.size, self.offsets
        flat = all(one.shape == (size,) for one in (self.height, self.east, self.north))
        if not flat or offsets.shape != (self.times.size + 1,) or self.times.ndim != 1:
            raise InputError(
                "height, east and north must be rows of one length, times one row, and offsets one"
                f" longer; got {self.height.shape}, {self.east.shape}, {self.north.shape},"
                f" {self.times.shape} and {offsets.shape}"
            )
        if offsets[0] != 0 or offsets[-1] != size or np.any(np.diff(offsets) < 0):
            raise InputError(f"offsets must rise from 0 to {size}, the number of levels")
        rises = np.diff(self.height) > 0.0
        rises[offsets[(offsets > 0) & (offsets < size)] - 1] = True
        if not np.all(rises):
            late = int(np.argmin(rises)) + 1
            raise InputError(f"height must ascend in each sounding; it does not at index {late}")

    def __repr__(self) -> str:
        where = f" of {self.station}" if self.station else ""
        if not len(self):
            return f"Soundings(none{where})"
        unusable = len(self) - int(np.sum(self.usable))
        rest = f", {unusable} of them not usable" if unusable else ""
        first, last = (str(np.datetime64(t, "D")) for t in (self.times[0], self.times[-1]))
        return f"Soundings({len(self)}{where} from {first} to {last}{rest})"

    def __len__(self) -> int:
        return int(self.times.size)

    def __iter__(self) -> Iterator[WindProfile]:
        return (self[i] for i in np.flatnonzero(self.usable).tolist())

    def __getitem__(self, index: Any) -> Any:
        """Return one profile, or the soundings of a slice, a mask or a row of indices.

        `InputError` for a sounding that cannot be used, with the reason, and what is no index.
        """
        if isinstance(index, int | np.integer) and not isinstance(index, bool):
            if not -len(self) <= index < len(self):
                raise InputError(f"there are {len(self)} soundings; got index {shown(index)}")
            return self._profile(int(index) % len(self))
        try:
            return self._some(np.arange(len(self))[index])
        except (IndexError, TypeError, ValueError):
            raise InputError(
                f"an index must be an integer, a slice or a mask; got {shown(index)}"
            ) from None

    def mean(self) -> WindProfile:
        """Return the mean wind, at every 100 m where at least half of those that can be used go.

        Raises
        ------
        InputError
            Where that is so at fewer than two heights.
        """
        each = list(self)
        top = max((one.height[-1] for one in each), default=0.0)
        bottom = min((one.height[0] for one in each), default=0.0)
        height = _STEP * np.arange(np.ceil(bottom / _STEP), np.floor(top / _STEP) + 1.0)
        total, known = np.zeros((2, height.size)), np.zeros(height.size)
        for one in each:
            there = (height >= one.height[0]) & (height <= one.height[-1])
            total[:, there] += one.at(height[there])
            known += there
        often = known >= max(len(each), 1) / 2.0
        if np.count_nonzero(often) < 2:
            raise InputError(
                "a mean wind needs soundings, half of which know the wind at two heights or more;"
                f" got {len(each)} that can be used"
            )
        east, north = total[:, often] / known[often]
        source = f"the mean of {plural(len(each), 'sounding')}"
        return WindProfile(height=height[often], east=east, north=north, source=source)

    @property
    def counts(self) -> IntArray:
        """Levels of each, ``(n,)``."""
        return np.diff(self.offsets)

    @property
    def usable(self) -> BoolArray:
        """Which can be used, ``(n,)``; `why` says what is wrong with the others."""
        return np.array([not reason for reason in self.why], dtype=bool)

    @property
    def local_times(self) -> NDArray[np.datetime64]:
        """Times by `utc_offset`, ``(n,)``."""
        return self.times + np.timedelta64(round(60 * self.utc_offset), "m")

    @property
    def months(self) -> IntArray:
        """Months from 1 to 12, ``(n,)``; 0 where a time is not known."""
        return np.asarray(months_of(self.local_times))

    @property
    def years(self) -> IntArray:
        """Years, ``(n,)``; 0 where a time is not known."""
        return np.asarray(years_of(self.local_times))

    def local(self, utc_offset: float) -> Self:
        """Return the same with months, years and hours counted by another local time [h]."""
        return replace(self, utc_offset=utc_offset)

    def of(
        self, *, month: int | None = None, year: int | None = None, hour: int | None = None
    ) -> Self:
        """Return those of a month, a year or an hour of the day, by `utc_offset`."""
        hours = (self.local_times - self.local_times.astype("datetime64[D]")).astype(int) // 60
        keep = np.ones(len(self), dtype=bool)
        for name, value, has in (
            ("month", month, self.months),
            ("year", year, self.years),
            ("hour", hour, hours),
        ):
            if value is not None:
                keep &= has == whole_number(name, value)
        return self._some(np.flatnonzero(keep))

    @classmethod
    def from_profiles(
        cls, profiles: Iterable[WindProfile], times: ArrayLike, station: str = ""
    ) -> Self:
        """Return the soundings of profiles and their times [UTC], sorted by these."""
        given = profiles if isinstance(profiles, list | tuple) else None
        if given is None:
            try:
                given = list(profiles)
            except TypeError:
                given = [profiles]
        for one in given:
            instance("profiles", one, WindProfile, "see read_sounding")
        when = minutes("times", times)
        if when.shape != (len(given),):
            raise InputError(f"times must hold one for each of {len(given)} profiles")
        sizes = [0, *(one.height.size for one in given)]
        levels: dict[str, Any] = {
            name: np.concatenate([np.empty(0), *(getattr(one, name) for one in given)])
            for name in RANGES
        }
        made = cls(**levels, offsets=np.cumsum(sizes), times=when, station=station)
        return made._some(np.argsort(made.times, kind="stable"))

    def _profile(self, index: int) -> WindProfile:
        when = self.times[index]
        if self.why[index]:
            raise InputError(f"the sounding of {when} cannot be used: {self.why[index]}")
        part = slice(*self.offsets[index : index + 2].tolist())
        return WindProfile(
            height=self.height[part],
            east=self.east[part],
            north=self.north[part],
            source=f"{self.station}, {when} UTC" if self.station else f"{when} UTC",
        )

    def _some(self, index: IndexArray) -> Self:
        offsets, levels = gathered(self.offsets, index)
        return replace(
            self,
            **{name: getattr(self, name)[levels] for name in RANGES},
            offsets=offsets,
            times=self.times[index],
            why=tuple(self.why[i] for i in index.tolist()),
        )


def gathered(offsets: IntArray, index: IndexArray) -> tuple[IntArray, IntArray]:
    """Return the offsets of some rows of a flat array, and where their elements are in it."""
    counts = np.diff(offsets)[index]
    made = np.concatenate([[0], np.cumsum(counts)])
    return made, np.arange(made[-1]) + np.repeat(offsets[index] - made[:-1], counts)


def months_of(times: NDArray[np.datetime64]) -> IntArray:
    """Return months from 1 to 12; 0 where a time is not known."""
    months = times.astype("datetime64[M]").astype(np.int64) % 12 + 1
    return np.where(np.isnat(times), 0, months)


def years_of(times: NDArray[np.datetime64]) -> IntArray:
    """Return years; 0 where a time is not known."""
    return np.where(np.isnat(times), 0, times.astype("datetime64[Y]").astype(np.int64) + 1970)


def minutes(name: str, values: ArrayLike) -> NDArray[np.datetime64]:
    """Return times to the minute; `InputError` for what is none."""
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "MUO" and array.size:
            raise TypeError
        return array.astype(_MINUTE)
    except (TypeError, ValueError, OverflowError):
        raise InputError(
            f"{name} must be times such as 2024-02-15T12:00, or datetime64; got {shown(values)}"
        ) from None


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
