"""Archive of soundings of one station: flat arrays over all levels, and their collection.

The levels of n soundings stand one behind the other in flat arrays; ``offsets (n + 1,)`` bounds
those of each. `SoundingFilter` selects months, years and a station while files are read, and
`SoundingCollection` gathers the levels and counts what is omitted.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.base import errors
from tvclin.base.arrays import BoolArray, FloatArray, IndexArray, IntArray
from tvclin.base.lines import plural
from tvclin.winds.soundings.profile import RANGES, WindProfile

TOO_FEW = "it has fewer than two levels with a height and a wind"
"""Reason why a sounding cannot be used that has no profile."""
_MINUTE = "datetime64[m]"
_MEAN_HEIGHT_STEP = 100.0
"""Step [m] between the heights of a mean wind."""
_MONTHS = range(1, 13)
_UTC_OFFSETS = errors.between(-14, 14)
"""Check of a local time less UTC [h]."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Soundings:
    """Soundings of one station, in the order of their times; see `read_soundings`.

    The levels of all soundings are concatenated in flat arrays; those of sounding i are
    ``height[offsets[i]:offsets[i + 1]]``. An integer index gives a `WindProfile`, a slice or a mask
    the `Soundings` it selects; iteration yields the profiles of usable soundings.

    Parameters
    ----------
    height, east, north : array_like
        See `WindProfile`, ``(m,)``, ascending within each sounding.
    offsets : array_like of int
        Where each sounding begins, and the end, ``(n + 1,)``.
    times : array_like of datetime64
        Times [UTC], ``(n,)``.
    station : str
        Name of the station.
    why : tuple of str
        Reason why each sounding cannot be used, with its line; empty where it can. By default
        soundings with fewer than two levels cannot.
    notes : tuple of str
        Levels and soundings that were omitted, interpolated or converted, with counts.
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
        """Check all fields, and set them to arrays and tuples; `InputError` as the class says.

        Without `why` soundings with fewer than two levels get the reason `TOO_FEW`.
        """
        set_field = partial(object.__setattr__, self)  # the class is frozen
        for name, (low, high, unit) in RANGES.items():  # height, east and north
            set_field(name, errors.within(name, getattr(self, name), low, high, unit))
        offsets = errors.array_of("offsets", self.offsets, "iu", "a row of integers")
        if offsets.ndim != 1 or not offsets.size:
            raise errors.InputError(
                f"offsets must be a row of integers; got {errors.shown(self.offsets)}"
            )
        set_field("offsets", offsets.astype(np.int64))
        set_field("times", to_minutes(self.times))
        self._check_shapes()
        errors.text("station", self.station)
        set_field("notes", errors.each("notes", self.notes, str, "one for each remark"))
        set_field("utc_offset", errors.number("utc_offset", self.utc_offset, _UTC_OFFSETS, "h"))
        why = errors.each("why", self.why, str, "one for each sounding, or none")
        if not why:
            why = tuple("" if n > 1 else TOO_FEW for n in self.counts.tolist())
        set_field("why", why)
        # `usable` says of each sounding that its reason is empty
        if len(why) != len(self) or np.any((self.counts < 2) & self.usable):
            raise errors.InputError(
                "why must hold a reason for each sounding with fewer than two levels"
            )

    def _check_shapes(self) -> None:
        """Raise `InputError` for arrays whose shapes or offsets do not fit."""
        size, offsets = self.height.size, self.offsets
        matching = all(array.shape == (size,) for array in (self.height, self.east, self.north))
        if not matching or offsets.shape != (self.times.size + 1,) or self.times.ndim != 1:
            raise errors.InputError(
                "height, east and north must be rows of one length, times one row, and offsets one"
                f" longer; got {self.height.shape}, {self.east.shape}, {self.north.shape},"
                f" {self.times.shape} and {offsets.shape}"
            )
        if offsets[0] != 0 or offsets[-1] != size or np.any(np.diff(offsets) < 0):
            raise errors.InputError(f"offsets must rise from 0 to {size}, the number of levels")
        ascending = np.diff(self.height) > 0.0
        # from the top of one sounding to the next
        ascending[offsets[(offsets > 0) & (offsets < size)] - 1] = True
        if not np.all(ascending):
            position = int(np.argmin(ascending)) + 1
            raise errors.InputError(
                f"height must ascend in each sounding; it does not at index {position}"
            )

    def __repr__(self) -> str:
        """Return number, station and dates of the soundings, as text."""
        return f"Soundings({len(self) or 'none'}{self._where_and_when})"

    def __str__(self) -> str:
        """Return number, station and dates of the soundings in words, for a sentence."""
        return f"{plural(len(self), 'sounding')}{self._where_and_when}"

    @property
    def _where_and_when(self) -> str:
        """Station, dates, and number of soundings that are not usable, in words."""
        where = f" of {self.station}" if self.station else ""
        if not len(self):
            return where
        unusable = len(self) - int(np.sum(self.usable))
        unusable_text = f", {unusable} of them not usable" if unusable else ""
        first, last = (str(np.datetime64(t, "D")) for t in (self.times[0], self.times[-1]))
        return f"{where} from {first} to {last}{unusable_text}"

    def __len__(self) -> int:
        """Return the number of soundings, usable or not."""
        return int(self.times.size)

    def __iter__(self) -> Iterator[WindProfile]:
        """Iterate over the profiles of usable soundings, in the order of their times."""
        return (self[i] for i in np.flatnonzero(self.usable).tolist())

    def __getitem__(self, index: Any) -> Any:
        """Return a profile by an integer, or the soundings of a slice, a mask or indices.

        `InputError` for a sounding that cannot be used, with the reason, and for an invalid index.
        """
        if isinstance(index, int | np.integer) and not isinstance(index, bool):
            if not -len(self) <= index < len(self):
                raise errors.InputError(
                    f"there are {len(self)} soundings; got index {errors.shown(index)}"
                )
            return self._profile(int(index) % len(self))
        try:
            return self._selected(np.arange(len(self))[index])
        except (IndexError, TypeError, ValueError):
            raise errors.InputError(
                f"an index must be an integer, a slice or a mask; got {errors.shown(index)}"
            ) from None

    def mean(self) -> WindProfile:
        """Return the mean wind of all usable soundings, at every 100 m that half of them reach.

        `InputError` where that is so at fewer than two heights.
        """
        profiles = list(self)
        top = max((profile.height[-1] for profile in profiles), default=0.0)
        bottom = min((profile.height[0] for profile in profiles), default=0.0)
        height = _MEAN_HEIGHT_STEP * np.arange(
            np.ceil(bottom / _MEAN_HEIGHT_STEP), np.floor(top / _MEAN_HEIGHT_STEP) + 1.0
        )
        # sums of the winds towards east and north [m/s], and numbers of soundings, at the heights
        total, count = np.zeros((2, height.size)), np.zeros(height.size)
        for profile in profiles:
            reached = (height >= profile.height[0]) & (height <= profile.height[-1])
            total[:, reached] += profile.at(height[reached])
            count += reached
        common = count >= max(len(profiles), 1) / 2.0
        if np.count_nonzero(common) < 2:
            raise errors.InputError(
                "a mean wind needs soundings, half of which know the wind at two heights or more;"
                f" got {len(profiles)} that can be used"
            )
        east, north = total[:, common] / count[common]
        source = f"the mean of {plural(len(profiles), 'sounding')}"
        return WindProfile(height=height[common], east=east, north=north, source=source)

    @property
    def counts(self) -> IntArray:
        """Number of levels of each sounding, ``(n,)``."""
        return np.diff(self.offsets)

    @property
    def usable(self) -> BoolArray:
        """Whether each sounding can be used, ``(n,)``; `why` has the reasons of the others."""
        return np.array([not reason for reason in self.why], dtype=bool)

    @property
    def local_times(self) -> NDArray[np.datetime64]:
        """Local times by `utc_offset`, ``(n,)``."""
        return self.times + np.timedelta64(round(60 * self.utc_offset), "m")

    @property
    def months(self) -> IntArray:
        """Months from 1 to 12 in local time, ``(n,)``; 0 for an unknown time."""
        return np.asarray(months_of(self.local_times))

    @property
    def years(self) -> IntArray:
        """Years in local time, ``(n,)``; 0 for an unknown time."""
        return np.asarray(years_of(self.local_times))

    def with_utc_offset(self, utc_offset: float) -> Self:
        """Return the soundings with months, years and hours in another local time [h from UTC]."""
        return replace(self, utc_offset=utc_offset)

    def select(
        self, *, month: int | None = None, year: int | None = None, hour: int | None = None
    ) -> Self:
        """Return the soundings of a month (from 1), a year or an hour of the day, in local time."""
        hours = (self.local_times - self.local_times.astype("datetime64[D]")).astype(int) // 60
        keep = np.ones(len(self), dtype=bool)
        for name, value, numbers in (
            ("month", month, self.months),
            ("year", year, self.years),
            ("hour", hour, hours),
        ):
            if value is not None:
                keep &= numbers == errors.whole_number(name, value)
        return self._selected(np.flatnonzero(keep))

    @classmethod
    def from_profiles(
        cls, profiles: Iterable[WindProfile], times: ArrayLike, station: str = ""
    ) -> Self:
        """Return the soundings of profiles and their times [UTC], in the order of the times.

        `times`: one for each profile, such as 2024-02-15T12. `station`: name of the station.
        """
        iterable = isinstance(profiles, Iterable) and not isinstance(profiles, np.ndarray)
        entries = list(profiles) if iterable else profiles
        sequence = errors.each("profiles", entries, WindProfile, "see read_sounding")
        checked_times = to_minutes(times)
        if checked_times.shape != (len(sequence),):
            raise errors.InputError(f"times must hold one for each of {len(sequence)} profiles")
        sizes = [0, *(profile.height.size for profile in sequence)]
        levels: dict[str, Any] = {
            name: np.concatenate([np.empty(0), *(getattr(profile, name) for profile in sequence)])
            for name in RANGES
        }
        soundings = cls(**levels, offsets=np.cumsum(sizes), times=checked_times, station=station)
        return soundings._selected(np.argsort(soundings.times, kind="stable"))

    def _profile(self, index: int) -> WindProfile:
        """Return the profile of a sounding by its `index`; `InputError` with why it is unusable."""
        time = self.times[index]
        if self.why[index]:
            raise errors.InputError(f"the sounding of {time} cannot be used: {self.why[index]}")
        levels = slice(*self.offsets[index : index + 2].tolist())
        return WindProfile(
            height=self.height[levels],
            east=self.east[levels],
            north=self.north[levels],
            source=f"{self.station}, {time} UTC" if self.station else f"{time} UTC",
        )

    def _selected(self, index: IndexArray) -> Self:
        """Return the soundings at the positions `index`, ``(k,)``, in their order.

        `RANGES` names the arrays over the levels of all soundings.
        """
        offsets, levels = gather(self.offsets, index)
        return replace(
            self,
            **{name: getattr(self, name)[levels] for name in RANGES},
            offsets=offsets,
            times=self.times[index],
            why=tuple(self.why[i] for i in index.tolist()),
        )


def gather(offsets: IntArray, index: IndexArray) -> tuple[IntArray, IntArray]:
    """Return new offsets of rows selected from a flat array, and the positions of their elements.

    `offsets`: where each of n rows begins, and the end, ``(n + 1,)``. `index`: rows, ``(k,)``.
    """
    counts = np.diff(offsets)[index]
    new_offsets = np.concatenate([[0], np.cumsum(counts)])
    return new_offsets, np.arange(new_offsets[-1]) + np.repeat(
        offsets[index] - new_offsets[:-1], counts
    )


def months_of(times: NDArray[np.datetime64]) -> IntArray:
    """Return months from 1 to 12, in the shape of the times; 0 for an unknown time."""
    months = times.astype("datetime64[M]").astype(np.int64) % 12 + 1
    return np.where(np.isnat(times), 0, months)


def years_of(times: NDArray[np.datetime64]) -> IntArray:
    """Return years, in the shape of the times; 0 for an unknown time."""
    return np.where(np.isnat(times), 0, times.astype("datetime64[Y]").astype(np.int64) + 1970)


def to_minutes(times: ArrayLike) -> NDArray[np.datetime64]:
    """Return times to the minute; `InputError` for values that are no times."""
    try:
        array = np.asarray(times)
        if array.dtype.kind not in "MUO" and array.size:
            raise TypeError
        return array.astype(_MINUTE)
    except (TypeError, ValueError, OverflowError):
        raise errors.InputError(
            "times must be times such as 2024-02-15T12:00, or datetime64; got"
            f" {errors.shown(times)}"
        ) from None


@dataclass(frozen=True)
class SoundingFilter:
    """Months, years and station of the soundings that are read.

    `months`: from 1 to 12; empty for all. `years`: first and last year. `station`: the only
    station. `utc_offset`: local time minus UTC [h], by which months and years are counted.
    """

    months: frozenset[int] = frozenset()
    years: tuple[int, int] | None = None
    station: str | None = None
    utc_offset: float = 0.0

    @classmethod
    def of(cls, months: Any, years: Any, station: Any, utc_offset: Any) -> SoundingFilter:
        """Return the filter of arguments of `read_soundings`; `InputError` if invalid.

        `months`: numbers from 1 to 12, and `years`: first and last; None for all. `station`: its
        name, or None. `utc_offset`: local time minus UTC [h].
        """
        offset = errors.number("utc_offset", utc_offset, _UTC_OFFSETS, "h")
        name = None if station is None else errors.text("station", station)
        chosen = _integers("months", months, "from 1 to 12, as [2]") if months is not None else ()
        if months is not None and (not chosen or not all(m in _MONTHS for m in chosen)):
            raise errors.InputError(
                f"months must be from 1 to 12, as [2]; got {errors.shown(months)}"
            )
        span = None
        if years is not None:
            rule = "the first and the last, as (1996, 2025)"
            numbers = _integers("years", years, rule)
            if len(numbers) != 2 or numbers[0] > numbers[1]:
                raise errors.InputError(f"years must be {rule}; got {errors.shown(years)}")
            span = (numbers[0], numbers[1])
        return cls(months=frozenset(chosen), years=span, station=name, utc_offset=offset)

    def accepts(self, station: str | None, time: Any) -> bool:
        """Return whether a sounding passes the filter of station, months and years.

        `station`: its station; None, unknown, passes. `time`: its time [UTC]; months and years are
        in local time.
        """
        if station is not None and self.station is not None and station != self.station:
            return False
        if not self.months and self.years is None:
            return True
        local = time + np.timedelta64(round(60 * self.utc_offset), "m")
        if self.months and int(months_of(local)) not in self.months:
            return False
        return self.years is None or self.years[0] <= int(years_of(local)) <= self.years[1]


@dataclass
class SoundingCollection:
    """Soundings read so far: pieces of the arrays of `Soundings`, and counts of omissions.

    `pieces`: of height [m], winds towards east and north [m/s], counts of levels, and times [UTC].
    `why`: reason why each sounding cannot be used, or "". `stations`: each station, and its first
    file. `counted`: for each remark its count, and its first place.
    """

    pieces: list[tuple[Any, ...]] = field(default_factory=list)
    why: list[str] = field(default_factory=list)
    stations: dict[str, str] = field(default_factory=dict)
    counted: dict[str, list[Any]] = field(default_factory=dict)

    def count(self, remark: str, where: str = "", times: int = 1) -> None:
        """Add a number of `times` to the count of a remark; `where`: place of the first of them."""
        if times:
            self.counted.setdefault(remark, [0, where])[0] += times

    def add(self, addition: SoundingCollection) -> None:
        """Append the soundings of a further collection, `addition`, and its counts of remarks."""
        self.pieces += addition.pieces
        self.why += addition.why
        for name, file in addition.stations.items():
            self.stations.setdefault(name, file)
        for remark, (times, where) in addition.counted.items():
            self.count(remark, where, times)

    def soundings(self, utc_offset: float) -> Soundings:
        """Return all soundings in the order of their times, without repeated times, with notes.

        `why` has for each sounding the reason why it cannot be used, empty if it can; `counted` has
        by remark the number of soundings or lines, and the place of the first. `utc_offset`: local
        time minus UTC [h]. `InputError` for soundings of two stations.
        """
        if len(self.stations) > 1:
            (a, where), (b, second_file) = list(self.stations.items())[:2]
            raise errors.InputError(
                f"soundings must be of one station; got {a} ({where}) and {b} ({second_file}), so"
                " name one with station"
            )
        if not self.pieces:
            # heights, winds east and north, counts and times of no sounding: empty arrays
            self.pieces.append(([], [], [], [], np.empty(0, "datetime64[m]")))
        height, east, north, counts, times = (
            np.concatenate(column) for column in zip(*self.pieces, strict=True)
        )
        # of a repeated time the first usable sounding is kept
        order = np.lexsort((np.array([bool(reason) for reason in self.why], dtype=bool), times))
        repeated = np.append(False, np.diff(times[order]) == np.timedelta64(0, "m"))[: order.size]
        self.count(
            "soundings of a time that was there already, left out", times=int(repeated.sum())
        )
        soundings = Soundings(
            height=height,
            east=east,
            north=north,
            offsets=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
            times=times,
            station=next(iter(self.stations), ""),
            why=tuple(self.why),
            utc_offset=utc_offset,
        )
        unique = soundings[order[~repeated]]
        unusable = [
            f"{when} UTC, {why}" for when, why in zip(unique.times, unique.why, strict=True) if why
        ]
        self.count("soundings that cannot be used", unusable[0] if unusable else "", len(unusable))
        notes = tuple(
            f"{times} {remark}{f' (the first: {where})' if where else ''}"
            for remark, (times, where) in self.counted.items()
        )
        return replace(unique, notes=notes)


def _integers(name: str, values: Any, rule: str) -> list[int]:
    """Return a sequence of `values` as integers; `InputError` for anything else.

    `name`: name of the argument in the error. `rule`: what it must be, after "must be".
    """
    row = isinstance(values, Iterable) and not isinstance(values, str | bytes)
    # an array without axes cannot be iterated; None is refused below
    items: list[Any] = list(values) if row and getattr(values, "ndim", True) else [None]
    if not all(isinstance(item, int | np.integer) and not isinstance(item, bool) for item in items):
        raise errors.InputError(f"{name} must be {rule}; got {errors.shown(values)}")
    return [int(item) for item in items]
