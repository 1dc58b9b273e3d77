"""Tables with a header whose names carry their units, such as height_m,speed_kt,direction_deg."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import FloatArray, IntArray
from tvclin.base.errors import InputError, shown
from tvclin.base.files import called
from tvclin.base.units import UNITS
from tvclin.winds.soundings.levels import Found, Levels
from tvclin.winds.soundings.text import LATEST_HEADER, MOST_COLUMNS, Text

_NAMES = {
    "geopotential_height": "height",
    "height": "height",
    "altitude": "height",
    "alt": "height",
    "speed": "speed",
    "direction": "direction",
    "dir": "direction",
    "east": "east",
    "u": "east",
    "north": "north",
    "v": "north",
}
_KNOT = UNITS["speed"]["kt"]
_METRE = {"m": 1.0, "km": 1e3, "ft": UNITS["length"]["ft"]}
_SPEED = (
    dict.fromkeys(("m_per_s", "m/s", "mps"), 1.0)
    | dict.fromkeys(("kt", "kts", "knot", "knots"), _KNOT)
    | dict.fromkeys(("km_per_h", "km/h"), 1 / 3.6)
    | dict.fromkeys(("ft_per_s", "ft/s"), UNITS["length"]["ft"])
    | {"mph": 1609.344 / 3600}
)
_ANGLE = dict.fromkeys(("deg", "degree", "degrees"), np.pi / 180) | {"rad": 1.0}
_UNITS = {"height": _METRE, "speed": _SPEED, "direction": _ANGLE, "east": _SPEED, "north": _SPEED}
_AROUND = ' "'


@dataclass(frozen=True)
class _Column:
    index: int
    cell: str
    factor: float
    geopotential: bool


def soundings_in(text: Text) -> list[Found]:
    """Return the sounding of a table with units in its header."""
    return [Found(lambda: _read(text, units=True))]


def openrocket_soundings_in(text: Text) -> list[Found]:
    """Return the sounding of a table altitude,speed,direction in m, m/s and degrees."""
    return [Found(lambda: _read(text, units=False))]


def header_line(text: Text) -> int | None:
    """Return the index of the first line that names a height and more, or None."""
    for i, line in enumerate(text.lines[:LATEST_HEADER]):
        delimiter = _delimiter(line)
        if line.count(delimiter) >= MOST_COLUMNS:
            continue
        names = [_split(_key(cell))[0] for cell in _cells(line, delimiter)]
        if len(names) > 1 and any(_NAMES.get(name) == "height" for name in names):
            return i
    return None


def _read(text: Text, *, units: bool) -> Levels:
    header = header_line(text)
    if header is None:
        raise InputError(
            f"{text.source} has no header with a height; write one such as"
            " height_m,speed_m_per_s,direction_deg"
        )
    delimiter = _delimiter(text.lines[header])
    cells = _cells(text.lines[header], delimiter)
    columns = _columns(text, header + 1, cells, units)
    rows, line = _rows(text, header, delimiter, len(cells))
    values = {name: _values(text, column, rows, line) for name, column in columns.items()}
    made: Callable[..., Levels] = Levels.blowing if "speed" in values else Levels
    return made(
        text=text,
        line=line,
        **values,
        geopotential=columns["height"].geopotential,
        balloon="time" in (cell.strip().lower() for cell in cells),
    )


def _columns(text: Text, line: int, cells: list[str], units: bool) -> dict[str, _Column]:
    columns: dict[str, _Column] = {}
    for i, cell in enumerate(cells):
        name, unit = _split(_key(cell))
        quantity = _NAMES.get(name)
        if quantity is None:
            continue
        if quantity in columns:
            first = columns[quantity].cell
            both = f"{called(first)} and {called(cell)}"
            raise text.error(line, f"{quantity} is given twice, as {both}; keep one")
        factors = _UNITS[quantity]
        if not units and not unit:
            unit = next(iter(factors))
        if unit not in factors:
            spelled = ", ".join(f"{name}_{unit}" for unit in factors)
            raise text.error(line, f"{shown(cell)} has no known unit; write {spelled}")
        columns[quantity] = _Column(i, cell, factors[unit], name == "geopotential_height")
    _check_complete(text, line, columns)
    return columns


def _check_complete(text: Text, line: int, columns: dict[str, _Column]) -> None:
    pairs = (("speed", "direction"), ("east", "north"))
    given = [pair for pair in pairs if all(name in columns for name in pair)]
    if len(given) != 1 or len(columns) != 3:
        found = ", ".join(columns)
        raise text.error(
            line,
            "the header must name a height and either speed and direction or east and north, with"
            f" their units; got {found}",
        )


def _rows(text: Text, header: int, delimiter: str, width: int) -> tuple[list[list[str]], IntArray]:
    rows, line = [], []
    for i, content in enumerate(text.lines[header + 1 :], start=header + 2):
        if content.lstrip().startswith("<"):
            break
        if not content.strip() or content.lstrip().startswith("#"):
            continue
        cells = content.split(delimiter)
        if len(cells) != width:
            raise text.error(
                i, f"the header has {width} columns and this line {len(cells)}; complete it"
            )
        rows.append(cells)
        line.append(i)
    return rows, np.array(line, dtype=np.int64)


def _values(text: Text, column: _Column, rows: list[list[str]], line: IntArray) -> FloatArray:
    cells = [row[column.index].strip(_AROUND) for row in rows]
    return column.factor * text.numbers(column.cell, cells, line)


def _delimiter(line: str) -> str:
    return max(",;\t", key=line.count)


def _cells(line: str, delimiter: str) -> list[str]:
    return [cell.strip(_AROUND) for cell in line.split(delimiter)]


def _key(cell: str) -> str:
    """Write "Wind Speed (m/s)" as speed_m/s."""
    key = re.sub(r"[\s_(\[\])]+", "_", cell.lower()).strip("_")
    return key.removeprefix("wind_")


def _split(key: str) -> tuple[str, str]:
    for name in _NAMES:
        if key == name or key.startswith(f"{name}_"):
            return name, key[len(name) + 1 :]
    return key, ""
