"""Station files of NOAA's Integrated Global Radiosonde Archive (IGRA), version 2: fixed columns.

Columns as in igra2-data-format.txt, counted there from 1: level type 1, pressure 10-15 (Pa),
geopotential height 17-21 (m), wind direction 41-45 (degrees), wind speed 47-51 (tenths of m/s).

`soundings_in` reads a short file, one sounding at a time; `read_station` reads a whole station,
thousands of soundings, as a stream: headers are filtered before their levels are parsed, levels
are checked in blocks, and an invalid sounding is recorded with its reason. The rules are those of
`levels`, and one more: a level with a wind and a pressure but without a height gets a height
between its neighbours, linear in the logarithm of pressure.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray, IntArray
from tvclin.base.errors import InputError
from tvclin.base.files import called, reason
from tvclin.base.sheet import MISSING_NUMBERS, Text
from tvclin.winds.soundings.archive import TOO_FEW, SoundingCollection, SoundingFilter
from tvclin.winds.soundings.levels import (
    Faults,
    Levels,
    SoundingEntry,
    geometric,
    level_faults,
    wind_components,
)

_HEADER_LINE = re.compile(r"#(\w{11}) (\d{4}) (\d\d) (\d\d) (\d\d) (.{4})\s+(\d+)\b", re.ASCII)
_INTEGER = re.compile(r"-?\d+")
_PRESSURE, _HEIGHT, _DIRECTION, _SPEED = slice(9, 15), slice(16, 21), slice(40, 45), slice(46, 51)
"""Columns of pressure, height, wind direction and wind speed, from 0."""
_BLANK_COLUMNS = (33, 39, 45)
"""Columns between the last fields, from 0, that must be blank."""
_BROKEN = "a level is cut short or not in its columns"
_MIN_DERIVED_NUMBERS = 6
"""Smallest number of integers after the count of levels in a header of derived parameters."""
_HEADER_START = re.compile(rb"\s*#\w{11} \d{4} \d\d \d\d ")
_MAX_LINE_WIDTH = 60
_DERIVED_SUFFIX = "-drvd"
_LEVELS_PER_BLOCK = 100_000
"""Levels that are checked together."""
_MAX_LEVELS = 1_000_000
"""Largest number of levels of a sounding; the finest have some ten thousand."""
_MAX_LINE_BYTES = 1000
"""Largest number of bytes of a line; lines of IGRA have at most 71."""
_PROGRESS_BYTES = 1 << 22
"""Bytes between two calls of `progress`."""
_MISSING_HOUR, _MISSING_RELEASE = 99, "9999"

Progress = Callable[[int, int], None]
_SOUNDING_SPACING = 1e6
"""Offset [m] between the heights of successive soundings, so that one row holds all."""


def soundings_in(text: Text) -> list[SoundingEntry]:
    """Return the soundings in the lines of a station file, one entry for each header."""
    headers = [i for i, line in enumerate(text.lines) if line.startswith("#")]
    if not headers:
        raise text.error(1, "an IGRA file begins each sounding with a line # and the station")
    ends = [*headers[1:], len(text.lines)]
    return [_station_sounding(text, first, end) for first, end in zip(headers, ends, strict=True)]


def is_derived(header: str) -> bool:
    """Return whether a header announces derived parameters, with numbers in place of sources."""
    match = _HEADER_LINE.match(header)
    words = header[match.end() :].split() if match is not None else []
    return len(words) >= _MIN_DERIVED_NUMBERS and all(_INTEGER.fullmatch(word) for word in words)


def derived_error(name: str) -> InputError:
    """Return the error about a file of derived parameters, by its name."""
    return InputError(
        f"{name} holds derived parameters of IGRA in other columns; take the file that ends in"
        " -data"
    )


def _station_sounding(text: Text, first: int, end: int) -> SoundingEntry:
    """Return the sounding below a header in the text of a station file.

    `first`, `end`: indices of the line of the header, and of the line after the last level.
    `InputError` for a header out of its columns, and a file of parameters derived from soundings.
    """
    match = _HEADER_LINE.match(text.lines[first])
    if is_derived(text.lines[first]):
        raise derived_error(text.source)
    if match is None:
        raise text.error(first + 1, "the header of an IGRA sounding is not in its columns")
    station, year, month, day, hour, _, count = match.groups()
    time = f"{year}-{month}-{day} {hour}"
    title = f"{station}, {time} UTC"
    return SoundingEntry(lambda: _station_levels(text, first, end, title, int(count)), time=time)


def _station_levels(text: Text, first: int, end: int, title: str, count: int) -> Levels:
    """Return the levels of a sounding in the text of a station file; an error names the line.

    `first`, `end`: indices of the line of its header, and of the line after its last level.
    `title`: station and time. `count`: number of levels that the header announces.
    """
    line = np.array([i + 1 for i in range(first + 1, end) if text.lines[i].strip()], dtype=np.int64)
    if line.size != count:
        raise text.error(
            first + 1, f"{count} levels are announced and {line.size} follow; the file is cut short"
        )
    content = [text.lines[i - 1].encode("latin-1", "replace") for i in line]
    rows = _rows(content, line, np.array([count]))
    text.require(~rows.broken, line, lambda _: _BROKEN)
    return Levels.from_direction(
        text=text,
        line=line,
        speed=rows.speed,
        direction=rows.direction,
        height=rows.height,
        title=title,
        geopotential=True,
        balloon=True,
    )


def read_station(
    path: Path, accepted: SoundingFilter, progress: Progress | None = None
) -> SoundingCollection:
    """Return the soundings of a station file, plain or in a zip, that pass a filter.

    `accepted`: the filter. `progress`: called with the bytes read and the bytes of the file.
    """
    if _DERIVED_SUFFIX in path.name.lower():
        raise derived_error(called(path))
    stream = _StationStream(called(path), accepted)
    with _opened(path) as (file, total):
        position = reported = 0
        for line in _lines(file, called(path)):
            stream.take(line)
            position += len(line)
            if progress is not None and position - reported > _PROGRESS_BYTES:
                progress(reported := position, max(total, position))
        stream.end()
        if progress is not None:
            progress(position, position)
    if not stream.headers:
        stream.collection.count("station files without a header", stream.name)
    return stream.collection


def is_station(path: Path) -> bool:
    """Return whether a path is taken for a station file: any zip, or a text with its header."""
    if path.suffix.lower() == ".zip":
        return True
    try:
        with path.open("rb") as file:
            return _HEADER_START.match(file.read(200).removeprefix(b"\xef\xbb\xbf")) is not None
    except OSError:
        return False


@contextmanager
def _opened(path: Path) -> Iterator[tuple[IO[bytes], int]]:
    """Open the station file at a path, plain or in a zip; give the file and its size [bytes]."""
    import zipfile
    from io import BufferedReader

    try:
        if path.suffix.lower() != ".zip":
            with path.open("rb") as file:
                yield file, path.stat().st_size
            return
        with zipfile.ZipFile(path) as archive:
            texts = [
                entry for entry in archive.infolist() if entry.filename.lower().endswith(".txt")
            ]
            if len(texts) != 1:
                raise InputError(
                    f"{called(path)} must hold one .txt, as a station file does; got {len(texts)}"
                )
            if _DERIVED_SUFFIX in texts[0].filename.lower():
                raise derived_error(called(texts[0].filename))
            with archive.open(texts[0]) as member:
                yield BufferedReader(member, 1 << 20), texts[0].file_size  # type: ignore[type-var]
    except (zipfile.BadZipFile, RuntimeError):
        raise _no_zip(called(path)) from None
    except OSError as error:
        raise InputError(f"{called(path)} cannot be read: {reason(error)}") from None


def _lines(file: IO[bytes], name: str) -> Iterator[bytes]:
    """Yield the lines of a file; `InputError` for a line longer than `_MAX_LINE_BYTES`.

    `name`: name of the file in the error.
    """
    try:
        for number, line in enumerate(iter(partial(file.readline, _MAX_LINE_BYTES), b""), start=1):
            if len(line) == _MAX_LINE_BYTES:
                raise InputError(f"{name}, line {number}: it has {_MAX_LINE_BYTES} bytes or more")
            yield line
    except (InputError, OSError):
        raise
    except Exception:  # each way of packing has errors of its own
        raise _no_zip(name) from None


def _no_zip(name: str) -> InputError:
    """Return the error about a damaged zip, by its name."""
    return InputError(f"{name} is no zip that can be read; load it down again")


class _Header(NamedTuple):
    """Header of a sounding in a block of levels.

    `time`: time [UTC]. `line`: number of its line. `announced`: number of levels that it announces.
    `first`: index in the block of its first level.
    """

    time: Any
    line: int
    announced: int
    first: int


@dataclass
class _StationStream:
    """Parser of a station file, line by line, with checks in blocks of levels.

    `name`: name of the file. `accepted`: filter of the soundings. `number`, `headers`: numbers of
    the lines and headers so far. `accepting`: whether levels are of an accepted sounding. `lines`,
    `numbers`: lines of a block of levels, and their numbers. `heads`: headers of the soundings of
    the block.
    """

    name: str
    accepted: SoundingFilter
    collection: SoundingCollection = field(default_factory=SoundingCollection)
    number: int = 0
    headers: int = 0
    accepting: bool = False
    lines: list[bytes] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    heads: list[_Header] = field(default_factory=list)

    def take(self, line: bytes) -> None:
        """Parse the next line of the file, a header or a level, and collect it in the block.

        A block is the levels of many soundings that are parsed together. Levels are collected
        while `accepting`: the header above them passed the filter.
        """
        self.number += 1
        # the first line may begin with a byte order mark of three bytes
        if line[:1] == b"#" or (self.number == 1 and _HEADER_START.match(line[3:])):
            self._head(line.removeprefix(b"\xef\xbb\xbf").decode("latin-1").rstrip())
        elif self.accepting and not line.isspace():
            # `_head` ends a full block, so its last sounding may still have `_MAX_LEVELS` levels
            if len(self.lines) > _LEVELS_PER_BLOCK + _MAX_LEVELS:
                raise InputError(f"{self.name}, line {self.number}: more than {_MAX_LEVELS} levels")
            self.lines.append(line)
            self.numbers.append(self.number)

    def _head(self, line: str) -> None:
        """Parse the line of a header, and set `accepting`: whether its levels are collected.

        The first header tells whether the file holds derived parameters of IGRA, not observations:
        an `InputError`. A header holds station, date, nominal hour, release time of the balloon and
        number of levels; `stations` has the file name of each station.
        """
        if len(self.lines) > _LEVELS_PER_BLOCK:  # the block is full
            self.end()
        self.accepting = False
        self.headers += 1
        match = _HEADER_LINE.match(line)
        if self.headers == 1 and is_derived(line):
            raise derived_error(self.name)
        if match is None:
            where = f"{self.name}, line {self.number}"
            self.collection.count("headers not in their columns, left out", where)
            return
        station, *date, hour, release, count = match.groups()
        time = self._time("-".join(date), int(hour), release)
        if time is not None and self.accepted.accepts(station, time):
            self.accepting = True
            self.collection.stations.setdefault(station, called(self.name))
            self.heads.append(
                _Header(time, line=self.number, announced=int(count), first=len(self.lines))
            )

    def _time(self, date: str, hour: int, release: str) -> Any:
        """Return the nominal time [UTC] of a sounding; None for an impossible date.

        `date`: as 2024-02-15. `hour`: 99 for a missing one, in place of which the time of
        `release`, HHMM, counts, or noon.
        """
        note, minutes = "", 60 * hour
        if hour == _MISSING_HOUR:
            known = release.isdecimal() and release != _MISSING_RELEASE and int(release) % 100 < 60
            minutes = 60 * int(release[:2]) + int(release[2:]) if known else 720
            source = "that of release" if known else "noon"
            note = f"soundings without an hour, for which {source} is taken"
        try:
            time = np.datetime64(date, "m") + np.timedelta64(minutes, "m")
        except ValueError:
            self.collection.count("headers with an impossible date", f"line {self.number}")
            return None
        if note and self.accepted.accepts(None, time):
            self.collection.count(note, f"line {self.number}")
        return time

    def end(self) -> None:
        """Check the collected levels, add their soundings to the collection, and begin a new block.

        A sounding with another number of levels than its header announces is unusable.
        """
        if not self.heads:
            return
        starts = np.array([*(head.first for head in self.heads), len(self.lines)])
        rows = _rows(self.lines, np.array(self.numbers, dtype=np.int64), np.diff(starts))
        why = [""] * len(self.heads)
        for i, (head, follow) in enumerate(zip(self.heads, np.diff(starts), strict=True)):
            if follow != head.announced:
                why[i] = (
                    f"line {head.line}: {head.announced} levels are announced and {follow} follow;"
                    " the file is cut short"
                )
        times = np.array([head.time for head in self.heads], dtype="datetime64[m]")
        collect_levels(self.collection, rows, times, why)
        self.lines, self.numbers, self.heads = [], [], []


def _rows(lines: list[bytes], numbers: IntArray, counts: IntArray) -> Rows:
    """Return the levels of soundings from their lines.

    Lines have fixed columns, speeds in tenths of m/s and directions in degrees. `numbers`: line
    numbers in the file, one for each line. `counts`: number of lines of each sounding.
    """
    # of no lines the array would have no width
    characters = np.array(lines or [b""], dtype=f"S{_MAX_LINE_WIDTH}")[: len(lines)]
    letters = characters.view(np.uint8).reshape(len(lines), _MAX_LINE_WIDTH)
    valid = np.all(letters[:, _BLANK_COLUMNS] == ord(" "), axis=1)
    pressure, height, direction, speed = (
        _numbers(letters[:, columns], valid) for columns in (_PRESSURE, _HEIGHT, _DIRECTION, _SPEED)
    )
    return Rows(
        sounding=np.repeat(np.arange(counts.size), counts),
        line=numbers,
        broken=~valid,
        pressure=pressure,
        height=height,
        speed=speed / 10.0,
        direction=np.radians(direction),
    )


def _numbers(letters: NDArray[np.uint8], valid: BoolArray) -> FloatArray:
    """Return integers of n lines, ``(n,)``, NaN where missing; clear `valid` for malformed ones.

    They are right-aligned digits with an optional minus, after blanks. `letters`: codes of the
    letters in the columns of the integer, ``(n, columns)``. `valid`: whether a line is well-formed,
    ``(n,)``, which is changed.
    """
    digit = (letters >= ord("0")) & (letters <= ord("9"))
    minus = letters == ord("-")
    unbroken = digit[:, 1:] >= digit[:, :-1]  # no digit is followed by another letter
    valid &= (
        digit[:, -1] & unbroken.all(axis=1) & (digit | minus | (letters == ord(" "))).all(axis=1)
    )
    powers = 10.0 ** np.arange(letters.shape[1] - 1, -1, -1)
    values = np.where(digit, letters - np.uint8(ord("0")), np.uint8(0)) @ powers
    values = np.where(minus.any(axis=1), -values, values)
    return np.where(np.isin(values, MISSING_NUMBERS), np.nan, values)


@dataclass(frozen=True, eq=False)
class Rows:
    """Levels of several soundings in the order of the file, arrays ``(m,)``; NaN where missing.

    `sounding`: index of the sounding, ascending. `line`: line in the file. `broken`: whether the
    line is malformed. `pressure`, `height`, `speed`, `direction`: [Pa], geopotential [m], [m/s],
    direction from which the wind blows [rad].
    """

    sounding: IntArray
    line: IntArray
    broken: BoolArray
    pressure: FloatArray
    height: FloatArray
    speed: FloatArray
    direction: FloatArray


def collect_levels(
    collection: SoundingCollection, rows: Rows, times: NDArray[np.datetime64], why: list[str]
) -> None:
    """Check the levels of n soundings, and add the soundings to a collection.

    `rows`: the levels. `times`: times [UTC] of the soundings, ``(n,)``. `why`: reason why each is
    invalid already, or "", ``(n,)``; further reasons are written into it.
    """
    _note_faults(rows, why)
    east, north = wind_components(rows.speed, rows.direction)
    has_wind = _without_fault(why)[rows.sounding] & ~np.isnan(east + north)
    measured = np.flatnonzero(has_wind & ~np.isnan(rows.height))
    # indices of levels, a number of levels, and the sounding of each sunk level
    ascending, repeated, sunk = _above_previous(
        rows.sounding[measured], rows.height[measured], measured
    )
    without_height = np.flatnonzero(has_wind & np.isnan(rows.height))
    interpolated, heights = _interpolated_levels(rows, without_height)
    # indices and heights of the levels that count, by sounding and height
    index, level = _by_height(
        rows.sounding,
        np.concatenate([ascending, interpolated]),
        np.concatenate([rows.height[ascending], heights]),
    )
    count = partial(np.bincount, minlength=len(why))
    # numbers of levels by sounding
    falls = count(sunk) > count(rows.sounding[ascending])
    counts = count(rows.sounding[index])
    faults = {"more than half of its levels lie below the one before": falls, TOO_FEW: counts < 2}
    for fault, holds in faults.items():
        for i in np.flatnonzero(holds).tolist():
            why[i] = why[i] or fault
    valid = _without_fault(why)
    usable = valid[rows.sounding[index]]
    omitted = without_height.size - interpolated.size
    collection.count(
        "levels with a wind and a pressure, placed in its logarithm", times=interpolated.size
    )
    collection.count("levels with a wind but without a height, left out", times=omitted)
    collection.count("levels of a height that was there already, left out", times=repeated)
    collection.count("levels where the balloon sank, left out", times=sunk.size)
    height, east, north = geometric(level[usable]), east[index[usable]], north[index[usable]]
    collection.pieces.append((height, east, north, np.where(valid, counts, 0), times))
    collection.why.extend(why)


def _without_fault(why: list[str]) -> BoolArray:
    """Return whether each of n soundings is valid, `why` it is not being empty, ``(n,)``."""
    return np.array([not reason for reason in why], dtype=bool)


def _note_faults(rows: Rows, why: list[str]) -> None:
    """Write the first fault of the levels of a sounding into `why`, where it is empty.

    `why`: reason why each of n soundings is invalid, ``(n,)``.
    """
    checks: Faults = [(rows.broken, lambda _: _BROKEN)]
    checks += level_faults(rows.speed, height=rows.height, direction=rows.direction)
    for failed, message in checks:
        for i in np.flatnonzero(failed).tolist():
            sounding = int(rows.sounding[i])
            why[sounding] = why[sounding] or f"line {rows.line[i]}: {message(i)}"


def _by_height(
    sounding: IntArray, index: IndexArray, height: FloatArray
) -> tuple[IndexArray, FloatArray]:
    """Return indices and heights [m] of levels by sounding and height, one for each height.

    `sounding`: number of the sounding of every level. `index`, `height`: indices of the levels that
    count, and their heights, ``(m,)``. Of levels at one height the first in the file counts.
    """
    order = np.lexsort((index, height, sounding[index]))
    index, height = index[order], height[order]
    rises = (np.diff(height) > 0.0) | (np.diff(sounding[index]) > 0)
    distinct = np.append(True, rises)[: index.size]
    return index[distinct], height[distinct]


def _above_previous(
    sounding: IntArray, height: FloatArray, index: IndexArray
) -> tuple[IndexArray, int, IntArray]:
    """Return indices of ascending levels, the number of repeats, and soundings of sunk levels.

    A level ascends if it is above all levels before it in its sounding; a repeat has the height of
    the highest of these, and a sunk level is below it. `sounding`, `height`, `index`: number of the
    sounding, height [m], or minus the logarithm of pressure, and index of each level, ``(n,)``.
    """
    stacked = height + _SOUNDING_SPACING * sounding  # each sounding above the one before
    highest = np.maximum.accumulate(np.concatenate([[-np.inf], stacked]))[:-1]
    repeated, sunk = stacked == highest, stacked < highest
    return index[~(repeated | sunk)], int(repeated.sum()), sounding[sunk]


def _interpolated_levels(rows: Rows, index: IndexArray) -> tuple[IndexArray, FloatArray]:
    """Return indices of levels without a height, and heights [m] interpolated from the pressure.

    `index`: indices of these levels in `rows`. A level is omitted if it has no pressure, or no
    neighbours in its sounding with pressure and height, one below and one above it.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        # minus the logarithm of pressure, which rises with height
        height_by_pressure = -np.log(np.where(rows.pressure > 0.0, rows.pressure, np.nan))
    base = np.flatnonzero(~np.isnan(height_by_pressure + rows.height))
    # neighbours must ascend, in pressure and in height
    base, _, _ = _above_previous(rows.sounding[base], height_by_pressure[base], base)
    base, _, _ = _above_previous(rows.sounding[base], rows.height[base], base)
    index = index[~np.isnan(height_by_pressure[index])]
    if not base.size or not index.size:
        return index[:0], np.empty(0)
    # logarithms of pressures differ by less than 100: an offset keeps soundings apart in one row
    position, key = (height_by_pressure[i] + 100.0 * rows.sounding[i] for i in (index, base))
    after = np.searchsorted(key, position)
    inside = (after > 0) & (after < key.size)
    low, high = base[np.maximum(after - 1, 0)], base[np.minimum(after, key.size - 1)]
    in_sounding = (rows.sounding[low] == rows.sounding[index]) & (
        rows.sounding[high] == rows.sounding[index]
    )
    return index[inside & in_sounding], np.interp(position, key, rows.height[base])[
        inside & in_sounding
    ]
