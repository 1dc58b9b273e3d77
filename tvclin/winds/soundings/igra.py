"""Station files of NOAA's Integrated Global Radiosonde Archive, version 2: fixed columns.

Columns as in igra2-data-format.txt, counted there from 1: level type 1, geopotential height 17-21
(m), wind direction 41-45 (degrees), wind speed 47-51 (tenths of m/s).
"""

from __future__ import annotations

import re

import numpy as np

from tvclin.base.arrays import FloatArray, IntArray
from tvclin.base.errors import InputError
from tvclin.base.text import Text
from tvclin.winds.soundings.levels import Found, Levels

_HEADER = re.compile(r"#(\w{11}) (\d{4}) (\d\d) (\d\d) (\d\d) .{4}\s+(\d+)\b")
_WHOLE = re.compile(r"-?\d+")
HEIGHT, DIRECTION, SPEED = slice(16, 21), slice(40, 45), slice(46, 51)
_WIDTH = 51
BLANK = (33, 39, 45)
"""Between the last columns nothing stands, counted from 0."""
_DERIVED_NUMBERS = 6
"""Whole numbers behind the count of levels in a header of derived parameters, at the least."""


def soundings_in(text: Text) -> list[Found]:
    """Return the soundings of a station file."""
    headers = [i for i, line in enumerate(text.lines) if line.startswith("#")]
    if not headers:
        raise text.error(1, "an IGRA file begins each sounding with a line # and the station")
    ends = [*headers[1:], len(text.lines)]
    return [_found(text, first, end) for first, end in zip(headers, ends, strict=True)]


def is_derived(header: str) -> bool:
    """Whether a header is that of derived parameters, with numbers in place of sources."""
    match = _HEADER.match(header)
    words = header[match.end() :].split() if match is not None else []
    return len(words) >= _DERIVED_NUMBERS and all(_WHOLE.fullmatch(word) for word in words)


def derived(name: str) -> InputError:
    """Return the error about a file of derived parameters."""
    return InputError(
        f"{name} holds derived parameters of IGRA in other columns; take the file that ends in"
        " -data"
    )


def _found(text: Text, first: int, end: int) -> Found:
    match = _HEADER.match(text.lines[first])
    if is_derived(text.lines[first]):
        raise derived(text.source)
    if match is None:
        raise text.error(first + 1, "the header of an IGRA sounding is not in its columns")
    station, year, month, day, hour, count = match.groups()
    time = f"{year}-{month}-{day} {hour}"
    title = f"{station}, {time} UTC"
    return Found(lambda: _read(text, first, end, title, int(count)), time=time)


def _read(text: Text, first: int, end: int, title: str, count: int) -> Levels:
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
        speed=_column(text, "WSPD", [row[SPEED] for row in rows], line) / 10,
        direction=np.radians(_column(text, "WDIR", [row[DIRECTION] for row in rows], line)),
        height=_column(text, "GPH", [row[HEIGHT] for row in rows], line),
        title=title,
        geopotential=True,
        balloon=True,
    )


def _column(text: Text, name: str, cells: list[str], line: IntArray) -> FloatArray:
    return text.numbers(name, cells, line)
