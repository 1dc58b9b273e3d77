"""Whole station files of NOAA's IGRA, version 2: thousands of soundings, read as a stream.

Columns as in `igra`, counted from 1: pressure 10-15 (Pa), the others there. What is not wanted is
left out before its levels are looked at; one bad sounding stops nothing.
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

from tvclin.base.arrays import BoolArray, FloatArray, IntArray
from tvclin.base.errors import InputError
from tvclin.base.files import called, reason
from tvclin.base.text import MISSING_NUMBERS
from tvclin.winds.soundings.igra import BLANK, DIRECTION, HEIGHT, SPEED, derived, is_derived
from tvclin.winds.soundings.many import Collected, Wanted
from tvclin.winds.soundings.many_levels import Rows, collected

_HEADER = re.compile(rb"#(\w{11}) (\d{4}) (\d\d) (\d\d) (\d\d) (.{4})\s+(\d+)\b")
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
        match = _HEADER.match(line)
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
