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
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray, IntArray
from tvclin.base.errors import InputError
from tvclin.base.files import called, reason
from tvclin.base.text import MISSING_NUMBERS, Text
from tvclin.winds.soundings.archive import TOO_FEW, Collected, Wanted
from tvclin.winds.soundings.levels import Faults, Found, Levels, faults, geometric, towards

_HEADER_LINE = re.compile(r"#(\w{11}) (\d{4}) (\d\d) (\d\d) (\d\d) .{4}\s+(\d+)\b")
_WHOLE = re.compile(r"-?\d+")
HEIGHT, DIRECTION, SPEED = slice(16, 21), slice(40, 45), slice(46, 51)
_WIDTH = 51
BLANK = (33, 39, 45)
"""Between the last columns nothing stands, counted from 0."""
_DERIVED_NUMBERS = 6
"""Whole numbers behind the count of levels in a header of derived parameters, at the least."""
_HEADER_BYTES = re.compile(rb"#(\w{11}) (\d{4}) (\d\d) (\d\d) (\d\d) (.{4})\s+(\d+)\b")
BEGINS = re.compile(rb"\s*#\w{11} \d{4} \d\d \d\d ")
_WIDEST = 60
_PRESSURE = slice(9, 15)
_DERIVED = "-drvd"
_AT_ONCE = 100_000
"""Levels that are looked at together."""
_MOST = 1_000_000
"""Levels of one sounding, at the most; the finest have some ten thousand."""
_LONGEST = 1000
"""Bytes of a line, at the most; those of IGRA have 71 and less."""
_TOLD = 1 << 22
"""Bytes between two words on how far it is."""
_NO_HOUR, _NO_TIME = 99, b"9999"

Progress = Callable[[int, int], None]
_APART = 1e6
"""m between the heights of one sounding and those of the next, where all stand in one row."""


def soundings_in(text: Text) -> list[Found]:
    """Return the soundings of a station file."""
    headers = [i for i, line in enumerate(text.lines) if line.startswith("#")]
    if not headers:
        raise text.error(1, "an IGRA file begins each sounding with a line # and the station")
    ends = [*headers[1:], len(text.lines)]
    return [_station_sounding(text, first, end) for first, end in zip(headers, ends, strict=True)]


def is_derived(header: str) -> bool:
    """Whether a header is that of derived parameters, with numbers in place of sources."""
    match = _HEADER_LINE.match(header)
    words = header[match.end() :].split() if match is not None else []
    return len(words) >= _DERIVED_NUMBERS and all(_WHOLE.fullmatch(word) for word in words)


def derived(name: str) -> InputError:
    """Return the error about a file of derived parameters."""
    return InputError(
        f"{name} holds derived parameters of IGRA in other columns; take the file that ends in"
        " -data"
    )


def _station_sounding(text: Text, first: int, end: int) -> Found:
    match = _HEADER_LINE.match(text.lines[first])
    if is_derived(text.lines[first]):
        raise derived(text.source)
    if match is None:
        raise text.error(first + 1, "the header of an IGRA sounding is not in its columns")
    station, year, month, day, hour, count = match.groups()
    time = f"{year}-{month}-{day} {hour}"
    title = f"{station}, {time} UTC"
    return Found(lambda: _station_levels(text, first, end, title, int(count)), time=time)


def _station_levels(text: Text, first: int, end: int, title: str, count: int) -> Levels:
    line = np.array([i + 1 for i in range(first + 1, end) if text.lines[i].strip()], dtype=np.int64)
    if line.size != count:
        raise text.error(
            first + 1, f"{count} levels are announced and {line.size} follow; the file is cut short"
        )
    rows = [text.lines[i - 1] for i in line]
    good = [len(row) >= _WIDTH and all(row[i] == " " for i in BLANK) for row in rows]
    text.require(
        np.array(good, dtype=bool), line, lambda _: "a level is cut short or not in its columns"
    )
    return Levels.blowing(
        text=text,
        line=line,
        speed=_station_column(text, "WSPD", [row[SPEED] for row in rows], line) / 10,
        direction=np.radians(_station_column(text, "WDIR", [row[DIRECTION] for row in rows], line)),
        height=_station_column(text, "GPH", [row[HEIGHT] for row in rows], line),
        title=title,
        geopotential=True,
        balloon=True,
    )


def _station_column(text: Text, name: str, cells: list[str], line: IntArray) -> FloatArray:
    return text.numbers(name, cells, line)


def read_station(path: Path, wanted: Wanted, progress: Progress | None = None) -> Collected:
    """Return the wanted soundings of a station file, plain or in a zip."""
    if _DERIVED in path.name.lower():
        raise derived(called(path))
    stream = _Stream(called(path), wanted)
    with _opened(path) as (file, total):
        done = told = 0
        for line in _lines(file, called(path)):
            stream.take(line)
            done += len(line)
            if progress is not None and done - told > _TOLD:
                progress(told := done, max(total, done))
        stream.end()
        if progress is not None:
            progress(done, done)
    if not stream.headers:
        stream.found.count("station files without a header", stream.name)
    return stream.found


def is_station(path: Path) -> bool:
    """Whether a file looks like one of a station: a zip, or a text that begins with a header."""
    if path.suffix.lower() == ".zip":
        return True
    try:
        with path.open("rb") as file:
            return BEGINS.match(file.read(200).removeprefix(b"\xef\xbb\xbf")) is not None
    except OSError:
        return False


@contextmanager
def _opened(path: Path) -> Iterator[tuple[IO[bytes], int]]:
    """The file, and how many bytes there are."""
    import zipfile
    from io import BufferedReader

    try:
        if path.suffix.lower() != ".zip":
            with path.open("rb") as file:
                yield file, path.stat().st_size
            return
        with zipfile.ZipFile(path) as packed:
            texts = [one for one in packed.infolist() if one.filename.lower().endswith(".txt")]
            if len(texts) != 1:
                raise InputError(
                    f"{called(path)} must hold one .txt, as a station file does; got {len(texts)}"
                )
            if _DERIVED in texts[0].filename.lower():
                raise derived(called(texts[0].filename))
            with packed.open(texts[0]) as inner:
                yield BufferedReader(inner, 1 << 20), texts[0].file_size  # type: ignore[type-var]
    except (zipfile.BadZipFile, RuntimeError):
        raise _no_zip(called(path)) from None
    except OSError as error:
        raise InputError(f"{called(path)} cannot be read: {reason(error)}") from None


def _lines(file: IO[bytes], name: str) -> Iterator[bytes]:
    """Yield the lines of a file, of which none may be longer than a line can be."""
    try:
        for number, line in enumerate(iter(partial(file.readline, _LONGEST), b""), start=1):
            if len(line) == _LONGEST:
                raise InputError(f"{name}, line {number}: it has {_LONGEST} bytes or more")
            yield line
    except (InputError, OSError):
        raise
    except Exception:  # each way of packing has errors of its own
        raise _no_zip(name) from None


def _no_zip(name: str) -> InputError:
    return InputError(f"{name} is no zip that can be read; load it down again")


@dataclass
class _Stream:
    """Lines, one after the other, gathered until there are enough to be looked at together."""

    name: str
    wanted: Wanted
    found: Collected = field(default_factory=Collected)
    number: int = 0
    headers: int = 0
    takes: bool = False
    announced: int = 0
    lines: list[bytes] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    heads: list[tuple[Any, int, int, int]] = field(default_factory=list)

    def take(self, line: bytes) -> None:
        """Take the next line."""
        self.number += 1
        if line[:1] == b"#" or (self.number == 1 and BEGINS.match(line[3:])):
            self._head(line.removeprefix(b"\xef\xbb\xbf"))
        elif self.takes and not line.isspace():
            if len(self.lines) > _AT_ONCE + _MOST:
                raise InputError(f"{self.name}, line {self.number}: more than {_MOST} levels")
            self.lines.append(line)
            self.numbers.append(self.number)

    def _head(self, line: bytes) -> None:
        if len(self.lines) > _AT_ONCE:
            self.end()
        self.takes = False
        self.headers += 1
        match = _HEADER_BYTES.match(line)
        if self.headers == 1 and is_derived(line.decode("latin-1").strip()):
            raise derived(self.name)
        if match is None:
            said = f"{self.name}, line {self.number}"
            self.found.count("headers not in their columns, left out", said)
            return
        station, *date, hour, release, count = match.groups()
        time = self._time("-".join(part.decode() for part in date), int(hour), release)
        if time is not None and self.wanted.takes(station.decode(), time):
            self.takes = True
            self.found.stations.setdefault(station.decode(), called(self.name))
            self.heads.append((time, self.number, int(count), len(self.lines)))

    def _time(self, date: str, hour: int, release: bytes) -> Any:
        """The nominal time; that of release, or noon, where there is none. None for no date."""
        note, minutes = "", 60 * hour
        if hour == _NO_HOUR:
            known = release.isdigit() and release != _NO_TIME and int(release) % 100 < 60
            minutes = 60 * int(release[:2]) + int(release[2:]) if known else 720
            of = "that of release" if known else "noon"
            note = f"soundings without an hour, for which {of} is taken"
        try:
            time = np.datetime64(date, "m") + np.timedelta64(minutes, "m")
        except ValueError:
            self.found.count("headers with an impossible date", f"line {self.number}")
            return None
        if note and self.wanted.takes(None, time):
            self.found.count(note, f"line {self.number}")
        return time

    def end(self) -> None:
        """Look at what was gathered."""
        if not self.heads:
            return
        starts = np.array([*(head[3] for head in self.heads), len(self.lines)])
        rows = _rows(self.lines, np.array(self.numbers, dtype=np.int64), np.diff(starts))
        why = [""] * len(self.heads)
        for i, (_, line, announced, _) in enumerate(self.heads):
            follow = int(starts[i + 1] - starts[i])
            if follow != announced:
                why[i] = (
                    f"line {line}: {announced} levels are announced and {follow} follow; the file"
                    " is cut short"
                )
        times = np.array([head[0] for head in self.heads], dtype="datetime64[m]")
        collected(self.found, rows, times, why)
        self.lines, self.numbers, self.heads = [], [], []


def _rows(lines: list[bytes], numbers: IntArray, counts: IntArray) -> Rows:
    """The levels of some soundings, of their lines."""
    whole = np.array(lines or [b""], dtype=f"S{_WIDEST}")[: len(lines)]
    letters = whole.view(np.uint8).reshape(len(lines), _WIDEST)
    good = np.all(letters[:, BLANK] == ord(" "), axis=1)
    pressure, height, direction, speed = (
        _numbers(letters[:, columns], good) for columns in (_PRESSURE, HEIGHT, DIRECTION, SPEED)
    )
    return Rows(
        sounding=np.repeat(np.arange(counts.size), counts),
        line=numbers,
        broken=~good,
        pressure=pressure,
        height=height,
        speed=speed / 10.0,
        direction=np.radians(direction),
    )


def _numbers(letters: NDArray[np.uint8], good: BoolArray) -> FloatArray:
    """Whole numbers in their columns, NaN where missing; clears `good` for what is none."""
    digit = (letters >= ord("0")) & (letters <= ord("9"))
    minus = letters == ord("-")
    begins = digit[:, 1:] >= digit[:, :-1]  # no digit is followed by another letter
    good &= digit[:, -1] & begins.all(axis=1) & (digit | minus | (letters == ord(" "))).all(axis=1)
    powers = 10.0 ** np.arange(letters.shape[1] - 1, -1, -1)
    values = np.where(digit, letters - np.uint8(ord("0")), np.uint8(0)) @ powers
    values = np.where(minus.any(axis=1), -values, values)
    return np.where(np.isin(values, MISSING_NUMBERS), np.nan, values)


@dataclass(frozen=True, eq=False)
class Rows:
    """Levels of some soundings in the order of the file, each array ``(m,)``; NaN where missing.

    `sounding`: which sounding, rising. `line`: line in the file. `broken`: not in its columns.
    `pressure`, `height`, `speed`, `direction`: [Pa], geopotential [m], [m/s], from where [rad].
    """

    sounding: IntArray
    line: IntArray
    broken: BoolArray
    pressure: FloatArray
    height: FloatArray
    speed: FloatArray
    direction: FloatArray


def collected(found: Collected, rows: Rows, times: NDArray[np.datetime64], why: list[str]) -> None:
    """Add soundings to what was found; `why` says what is already wrong with each."""
    bad = np.array([bool(reason) for reason in why], dtype=bool)
    wrongs: Faults = [(rows.broken, lambda _: "a level is cut short or not in its columns")]
    wrongs += faults(height=rows.height, speed=rows.speed, direction=rows.direction)
    for wrong, say in wrongs:
        for i in np.flatnonzero(wrong).tolist():
            sounding = int(rows.sounding[i])
            if not bad[sounding]:
                bad[sounding], why[sounding] = True, f"line {rows.line[i]}: {say(i)}"
    good = ~bad[rows.sounding]
    east, north = towards(rows.speed, rows.direction)
    blows = good & ~np.isnan(east + north)
    kept = np.flatnonzero(blows & ~np.isnan(rows.height))
    kept, twice, sunk = _above_previous(rows.sounding[kept], rows.height[kept], kept)
    mostly = np.bincount(sunk, minlength=bad.size) > np.bincount(
        rows.sounding[kept], minlength=bad.size
    )
    for i in np.flatnonzero(mostly & ~bad).tolist():
        bad[i], why[i] = True, "more than half of its levels lie below the one before"
    placed, height = _placed(rows, np.flatnonzero(blows & np.isnan(rows.height)))
    index = np.concatenate([kept, placed])
    level = np.concatenate([rows.height[kept], height])
    order = np.lexsort((index, level, rows.sounding[index]))  # where two are at one height
    index, level = index[order], level[order]
    sounding = rows.sounding[index]
    new = np.append(True, (np.diff(level) > 0.0) | (np.diff(sounding) > 0))[: index.size]
    index, level, sounding = (one[new] for one in (index, level, sounding))
    counts = np.bincount(sounding, minlength=bad.size)
    for i in np.flatnonzero((counts < 2) & ~bad).tolist():
        bad[i], why[i] = True, TOO_FEW
    use = ~bad[sounding]
    left = int(np.sum(blows & np.isnan(rows.height))) - placed.size
    found.count("levels with a wind and a pressure, placed in its logarithm", times=placed.size)
    found.count("levels with a wind but without a height, left out", times=left)
    found.count("levels of a height that was there already, left out", times=twice)
    found.count("levels where the balloon sank, left out", times=sunk.size)
    made = geometric(level[use]), east[index[use]], north[index[use]]
    found.pieces.append((*made, np.where(bad, 0, counts), times))
    found.why.extend(why)


def _above_previous(
    sounding: IntArray, height: FloatArray, index: IndexArray
) -> tuple[IndexArray, int, IntArray]:
    """Levels above all before them; how many stand twice; and of which soundings the others are."""
    above = height + _APART * sounding
    highest = np.maximum.accumulate(np.concatenate([[-np.inf], above]))[:-1]
    twice, sunk = above == highest, above < highest
    return index[~(twice | sunk)], int(twice.sum()), sounding[sunk]


def _placed(rows: Rows, index: IndexArray) -> tuple[IndexArray, FloatArray]:
    """Of levels without a height those that lie between two with one, and their heights [m]."""
    with np.errstate(invalid="ignore", divide="ignore"):
        up = -np.log(np.where(rows.pressure > 0.0, rows.pressure, np.nan))
    base = np.flatnonzero(~np.isnan(up + rows.height))
    base = _above_previous(rows.sounding[base], up[base], base)[0]
    base = _above_previous(rows.sounding[base], rows.height[base], base)[0]
    index = index[~np.isnan(up[index])]
    if not base.size or not index.size:
        return index[:0], np.empty(0)
    place, key = (up[i] + 100.0 * rows.sounding[i] for i in (index, base))
    after = np.searchsorted(key, place)
    inside = (after > 0) & (after < key.size)
    low, high = base[np.maximum(after - 1, 0)], base[np.minimum(after, key.size - 1)]
    same = (rows.sounding[low] == rows.sounding[index]) & (
        rows.sounding[high] == rows.sounding[index]
    )
    return index[inside & same], np.interp(place, key, rows.height[base])[inside & same]
