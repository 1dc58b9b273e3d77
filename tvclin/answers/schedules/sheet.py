"""A text with a line of column names and units, and the numbers below it."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike

import numpy as np

from tvclin.answers.schedules.units import WRITTEN, Unit, unit_of
from tvclin.base.arrays import FloatArray, IntArray
from tvclin.base.errors import InputError, shown
from tvclin.winds.soundings.text import LATEST_HEADER, MOST_COLUMNS, Text, read_lines

Cells = tuple[str, ...]

_SEPARATORS = ",;\t"
_BEHIND_UNITS, _SPACES = "units", "spaces"
"""Separated by spaces, where names hold spaces too and end in units, and where they do not."""
_MARKS = "#%!'\" \ufeff"
"""What may stand before the first name: marks of comments, quotes, a byte order mark."""
_DECIMAL = re.compile(r"[+-]?\d*([.,])\d+([eE][+-]?\d+)?")
_SYMBOL = re.compile(r"\s*\((?![a-z ]{2,}\))[^()]*\)$")
"""A symbol in parentheses behind a name; words in small letters are part of the name."""
_LONGEST_NAME = 200


@dataclass(frozen=True)
class Heading:
    """The name of a column.

    `index`: which column. `text`: as it stands in the file, without letters that cannot be seen.
    `name`, `unit`: what stands before and in its last parentheses or brackets; a unit of None
    without.
    """

    index: int
    text: str
    name: str
    unit: str | None

    @property
    def names(self) -> tuple[str, ...]:
        """The letters and digits of its name, and without a symbol in parentheses behind it."""
        return letters(self.name), letters(_SYMBOL.sub("", self.name))


@dataclass(frozen=True, eq=False)
class Column:
    """Numbers in SI units ``(n,)``, NaN where there is none, and where they came from."""

    values: FloatArray
    origin: str


@dataclass(frozen=True, eq=False)
class Sheet:
    """The rows of a file below its line of names: of each its line and its cells."""

    text: Text
    headings: tuple[Heading, ...]
    line: IntArray
    cells: tuple[Cells, ...]

    @property
    def places(self) -> tuple[str, ...]:
        """What each row is called in messages."""
        return tuple(f"{self.text.source}, line {n}" for n in self.line)

    def find(self, *names: str) -> Heading | None:
        """Return the one column that has the first of some names that is there.

        A column of the very name counts before those that have a symbol behind it.
        """
        for name in names:
            named = [one for one in self.headings if letters(name) in one.names]
            found = [one for one in named if letters(name) == one.names[0]] or named
            if len(found) > 1:
                raise InputError(
                    f"{self.text.source}: the column {name} is there {len(found)} times; keep one"
                )
            if found:
                return found[0]
        return None

    def numbers(
        self, heading: Heading, dimension: str, known: dict[str, float] | None = None
    ) -> Column:
        """Return the numbers of a column in SI units.

        `dimension`: what it measures, of `WRITTEN`. `known`: units in place of those of `WRITTEN`.
        `InputError` for a unit that is missing or unknown, and for a cell that is no number.
        """
        unit = self._unit(heading, WRITTEN[dimension] if known is None else known)
        cells = [row[heading.index] for row in self.cells]
        values = self.text.numbers(heading.name, cells, self.line) * unit.factor + unit.zero
        damaged = unit.mangled and unit.spelling
        told = f" (its unit is damaged, and taken for {unit.spelling})" if damaged else ""
        return Column(values, f"column {heading.text}{told}")

    def need(
        self, name: str, dimension: str, mend: str, known: dict[str, float] | None = None
    ) -> Column:
        """Return the numbers of a column by name; `InputError` without it, with a way to mend."""
        heading = self.find(name)
        if heading is None:
            raise InputError(f"{self.text.source} has no column {name}; {mend}")
        return self.numbers(heading, dimension, known)

    def maybe(self, key: str, name: str, dimension: str) -> dict[str, Column]:
        """Return the numbers of a column under a key of ours; nothing where it is not there."""
        heading = self.find(name)
        return {} if heading is None else {key: self.numbers(heading, dimension)}

    def factor(self, heading: Heading, dimension: str) -> float:
        """Return the factor of a column's unit to SI; `InputError` where it is not known."""
        return self._unit(heading, WRITTEN[dimension]).factor

    def _unit(self, heading: Heading, known: dict[str, float]) -> Unit:
        unit = unit_of(heading.unit or "", known)
        if unit is None or (heading.unit is None and "" not in known):
            raise InputError(
                f"{self.text.source}: the unit of the column {shown(heading.text)} is not known;"
                f" export it in {', '.join(filter(None, known)) or 'no unit'}"
            )
        return unit


def read_sheet(
    path: str | PathLike[str],
    kind: str,
    is_header: Callable[[tuple[Heading, ...]], bool],
    missing: str,
) -> Sheet:
    """Return the table of a file below the line of names that is looked for.

    A byte order mark, comments, quotes, and letters of another encoding are legal. `kind`,
    `missing`: what the file should be, and what is said where no line is the header.
    """
    text = read_lines(path, kind, errors="replace")
    for i, content in enumerate(text.lines[:LATEST_HEADER]):
        for separator in (*_SEPARATORS, _BEHIND_UNITS, _SPACES):
            cells = _cells(content, separator)
            if len(cells) > MOST_COLUMNS:
                raise text.error(i + 1, f"it has more than {MOST_COLUMNS} columns")
            headings = tuple(_heading(k, cell) for k, cell in enumerate(cells))
            if len(headings) > 1 and is_header(headings):
                return _rows(text, i, headings, separator)
    raise InputError(f"{text.source} has no line of {missing}")


def letters(name: str) -> str:
    """Return the letters and digits of a name, which no encoding damages, in lower case."""
    return "".join(c for c in name.lower() if c.isascii() and c.isalnum())


def _cells(content: str, separator: str) -> list[str]:
    content = content.lstrip(_MARKS).rstrip()
    if separator == _BEHIND_UNITS:
        return re.split(r"(?<=[)\]])\s+(?=[^\s(\[])", content)
    if separator == _SPACES:
        return content.split()
    return content.rstrip(separator).split(separator)


def _heading(index: int, cell: str) -> Heading:
    text = " ".join("".join(c for c in cell if c.isprintable()).strip(' "').split())
    found = re.fullmatch(r"(.*\S)\s*[(\[]([^()\[\]]*)[)\]]", text)
    name, unit = (found[1], found[2].strip()) if found else (text, None)
    return Heading(index, text, name, unit)


def _rows(text: Text, header: int, headings: Sequence[Heading], separator: str) -> Sheet:
    for one in headings:
        if len(one.text) > _LONGEST_NAME:
            raise text.error(
                header + 1,
                f"a name of a column has at most {_LONGEST_NAME} letters; got {shown(one.text)}",
            )
    rows: list[Cells] = []
    line: list[int] = []
    for n, content in enumerate(text.lines[header + 1 :], start=header + 2):
        if not content.strip(" \t,;") or is_comment(content):
            continue
        cells = content.split(separator if separator in _SEPARATORS else None)
        cells = [cell.strip(' "\u200b') for cell in cells]
        while len(cells) > len(headings) and not cells[-1]:
            cells.pop()
        if len(cells) != len(headings):
            hint = "; are there decimal commas?" if len(cells) > len(headings) else ""
            raise text.error(
                n, f"there are {len(headings)} names and {len(cells)} cells in this line{hint}"
            )
        rows.append(tuple(cells))
        line.append(n)
    if not rows:
        raise InputError(f"{text.source} has no row below its line of names")
    rows = _with_points(text, separator, line, rows)
    return Sheet(text, tuple(headings), np.array(line, dtype=np.int64), tuple(rows))


def _with_points(text: Text, separator: str, line: list[int], rows: list[Cells]) -> list[Cells]:
    """Cells with decimal points: between semicolons, and without any point, commas are decimal."""
    if separator == ",":
        return rows
    marks = [{one[1] for cell in row if (one := _DECIMAL.fullmatch(cell))} for row in rows]
    if not any("," in one for one in marks):
        return rows
    points = any("." in one for one in marks)
    if separator != ";" or points:
        at = next(n for n, one in zip(line, marks, strict=True) if "," in one)
        others = ", others points" if points else ""
        raise text.error(at, f"numbers have decimal commas{others}; export the file with points")
    return [
        tuple(cell.replace(",", ".") if _DECIMAL.fullmatch(cell) else cell for cell in row)
        for row in rows
    ]


def is_comment(content: str) -> bool:
    """Whether a line is a comment: by its mark, or an event where the mark was taken off."""
    bare = content.lstrip("\"' \t\ufeff")
    return bare.startswith(("#", "%", "!", "//")) or bare.startswith("Event ")
