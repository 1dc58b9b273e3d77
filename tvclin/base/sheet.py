"""Text files and tables of other programs: a line of column names, and rows of cells below it.

Errors name the line. One reader for winds, soundings and schedules: any separator, decimal commas,
quoted cells, comments and lines of other text above the names. Units are the same as in `units`.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from os import PathLike

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray, IntArray
from tvclin.base.errors import InputError, shown
from tvclin.base.errors import path as a_path
from tvclin.base.files import ENCODINGS, called, read_text
from tvclin.base.lines import plural
from tvclin.base.units import WRITTEN, Unit, unit_of

Cells = tuple[str, ...]
MISSING_NUMBERS = (-8888.0, -9999.0, -32768.0, -99999.0)
"""Numbers that mark a missing value in every column."""
_MISSING_WORDS = {"", "-", "--", "---", "nan", "na", "n/a", "m", "null", "none"}

MAX_COLUMNS, MAX_HEAD_LINE = 1000, 1000
"""Largest number of columns, and of the line of the names."""
_SEPARATORS = ",;\t"
_AFTER_UNITS, _BLANKS = "units", "blanks"
"""Separation by blanks: with names that contain blanks and end in units, and without."""
_LEADING_MARKS = "#%!' \ufeff"
"""Characters before the first name: marks of comments, a byte order mark."""
_NUMBER = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)(e[+-]?\d+)?", flags=re.IGNORECASE)
_FIRST_NUMBER = re.compile(rf"[\s\"]*{_NUMBER.pattern}[\s\"]*([,;\t ]|$)", flags=re.IGNORECASE)
_DECIMAL = re.compile(r"[+-]?\d*([.,])\d+([eE][+-]?\d+)?")
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
_SYMBOL = re.compile(r"\s*\((?![a-z ]{2,}\))[^()]*\)$")
"""Symbol in parentheses after a name; lower-case words belong to the name."""
_MAX_NAME_LENGTH = 200
_CERTAIN_COLUMNS = 3
"""Known columns of a line that is certainly the head, if the next row has as many cells."""


@dataclass(frozen=True)
class Text:
    """Lines of a file without their ends, and its name in messages; line numbers start at 1."""

    source: str
    lines: tuple[str, ...]

    def error(self, line: int, message: str) -> InputError:
        """Return the error `message` about the line of that number, with the file's name."""
        return InputError(f"{self.source}, line {line}: {message}")

    def numbers(self, column: str, cells: Sequence[str], line: IntArray) -> FloatArray:
        """Return the numbers ``(n,)`` in the `cells` of a `column`, NaN where a value is missing.

        `column`: its name, and `line`: line numbers ``(n,)`` of the cells, for messages.
        """
        try:
            values = np.array(cells, dtype=float)
        except ValueError:
            values = np.array([np.inf])  # so that each cell is read by itself
        if np.any(np.isinf(values)):  # empty or invalid cells: parse each
            pairs = zip(cells, line.tolist(), strict=True)
            values = np.array([self._number(column, *pair) for pair in pairs], dtype=float)
        return np.where(np.isin(values, MISSING_NUMBERS), np.nan, values)

    def _number(self, column: str, cell: str, line: int) -> float:
        """Return the number of a `cell`, NaN if missing; else an error on `column`, `line`.

        Missing is an empty cell or a word such as "n/a". Infinity is no number either.
        """
        try:
            value = float(cell)
        except ValueError:
            if cell.strip().lower() in _MISSING_WORDS:
                return np.nan
            value = np.inf
        if np.isinf(value):
            raise self.error(
                line, f"{column} must be a number, or empty; got {shown(cell.strip())}"
            )
        return value

    def require(self, good: BoolArray, line: IntArray, say: Callable[[int], str]) -> None:
        """Raise an error about the first line that is not `good`; `say` makes it from the index.

        `good`: whether each row is valid, ``(n,)``. `line`: line number of each row, ``(n,)``.
        """
        if not np.all(good):
            first = int(np.argmin(good))
            raise self.error(int(line[first]), say(first))


def read_lines(path: str | PathLike[str], kind: str = "a file of winds") -> Text:
    """Return the lines of the text file `path` in any of `ENCODINGS`; `kind` is for messages."""
    content = read_text(a_path("path", path), kind, encodings=ENCODINGS)
    return lines_of(content, str(path))


def lines_of(content: str, source: str) -> Text:
    """Return the lines of the text `content`, with any line ends; `source` names it in messages."""
    if "\0" in content:
        raise InputError(f"{called(source)} is not a text file")
    return Text(called(source), tuple(re.split(r"\r\n|\r|\n", content)))


@dataclass(frozen=True)
class Heading:
    """Name of a column.

    `index`: of the column. `text`: as in the file, without invisible characters. `name`, `unit`:
    text before and inside its last parentheses or brackets; a unit of None without them.
    """

    index: int
    text: str
    name: str
    unit: str | None

    @property
    def names(self) -> tuple[str, ...]:
        """Name in letters and digits, with and without the symbol in parentheses after it."""
        return letters(self.name), letters(_SYMBOL.sub("", self.name))

    @property
    def quantity(self) -> str:
        """Name as keys of files have it: in lower case, its words joined by underscores."""
        return "_".join(self.name.lower().split())

    @property
    def words(self) -> list[str]:
        """Words of name and unit in lower case, split at blanks, underscores and brackets."""
        return [word for word in re.split(r"[\s_()\[\]]+", self.text.lower()) if word]


@dataclass(frozen=True, eq=False)
class Column:
    """Numbers in SI units ``(n,)``, NaN where missing, and their origin."""

    values: FloatArray
    origin: str


@dataclass(frozen=True, eq=False)
class Sheet:
    """Rows of a file below its line of names: line numbers and cells.

    `head`: index of the line of names. `notes`: lines above it that were skipped.
    """

    text: Text
    headings: tuple[Heading, ...]
    line: IntArray
    cells: tuple[Cells, ...]
    head: int = 0
    notes: tuple[str, ...] = ()

    @property
    def places(self) -> tuple[str, ...]:
        """Name of each row in messages: the file and the line number."""
        return tuple(f"{self.text.source}, line {n}" for n in self.line)

    def error(self, message: str) -> InputError:
        """Return the error `message` about the line of names."""
        return self.text.error(self.head + 1, message)

    def find(self, *names: str) -> Heading | None:
        """Return the heading of the first of `names` that the file has; None without any.

        A column of exactly that name precedes columns with a symbol after it, "speed (V)".
        Names are compared by their letters and digits. `InputError` if several columns fit.
        """
        for name in names:
            candidates = [heading for heading in self.headings if letters(name) in heading.names]
            matching = [
                heading for heading in candidates if letters(name) == heading.names[0]
            ] or candidates
            if len(matching) > 1:
                raise InputError(
                    f"{self.text.source}: the column {name} is there {len(matching)} times; keep"
                    " one"
                )
            if matching:
                return matching[0]
        return None

    def column(self, heading: Heading) -> list[str]:
        """Return the texts of all cells of the column of a `heading`, from top to bottom."""
        return [row[heading.index] for row in self.cells]

    def complete_numbers(self, heading: Heading) -> FloatArray:
        """Return the numbers in the column of a `heading`, ``(n,)``, in the unit of the file.

        An `InputError` names the line of a missing number.
        """
        values = self.text.numbers(heading.text, self.column(heading), self.line)
        missing = f"there is no number in {heading.text}"
        self.text.require(~np.isnan(values), self.line, lambda _: missing)
        return values

    def numbers(
        self, heading: Heading, dimension: str, units: dict[str, float] | None = None
    ) -> Column:
        """Return the numbers of the column of a `heading` in SI units.

        `dimension`: kind of quantity of the column, a key of `WRITTEN`. `units`: factors to SI of
        its units by spelling, by default of `WRITTEN`. `InputError` for a unit that is missing or
        unknown, and for a cell that is no number.
        """
        unit = self._unit(heading, WRITTEN[dimension] if units is None else units)
        cells = self.column(heading)
        values = self.text.numbers(heading.name, cells, self.line) * unit.factor + unit.zero
        # characters of a unit may be damaged by encodings, such as a degree sign
        damaged = unit.damaged and unit.spelling
        remark = f" (its unit is damaged, and taken for {unit.spelling})" if damaged else ""
        return Column(values, f"column {heading.text}{remark}")

    def need(
        self, name: str, dimension: str, mend: str, units: dict[str, float] | None = None
    ) -> Column:
        """Return the numbers of the column `name` in SI units; `InputError` if there is none.

        `dimension`: kind of quantity, a key of `WRITTEN`. `units`: factors to SI by spelling, by
        default of `WRITTEN`. `mend`: text of the remedy.
        """
        heading = self.find(name)
        if heading is None:
            raise InputError(f"{self.text.source} has no column {name}; {mend}")
        return self.numbers(heading, dimension, units)

    def optional(self, key: str, name: str, dimension: str, notes: list[str]) -> dict[str, Column]:
        """Return the numbers of the column `name` by `key`; empty if the file has no such column.

        `dimension`: kind of quantity, a key of `WRITTEN`. A column that cannot be read is omitted,
        and `notes` gets the reason.
        """
        try:
            heading = self.find(name)
            return {} if heading is None else {key: self.numbers(heading, dimension)}
        except InputError as error:
            why = str(error).removeprefix(self.text.source).lstrip(":, ")
            notes.append(f"not read: column {name}, which is not needed: {why}")
            return {}

    def factor(self, heading: Heading, dimension: str) -> float:
        """Return the factor to SI of the unit of a column, by its `heading`; else `InputError`.

        `dimension`: kind of quantity of the column, a key of `WRITTEN`.
        """
        return self._unit(heading, WRITTEN[dimension]).factor

    def _unit(self, heading: Heading, units: dict[str, float]) -> Unit:
        """Return the unit of the column of a `heading`, of `units`; `InputError` for any other."""
        unit = unit_of(heading.unit or "", units)
        if unit is None or (heading.unit is None and "" not in units):
            raise InputError(
                f"{self.text.source}: the unit of the column {shown(heading.text)} is not known;"
                f" export it in {', '.join(filter(None, units)) or 'no unit'}"
            )
        return unit


Headings = tuple[Heading, ...]
Fit = Callable[[Headings], float]
"""The number of known columns among the names of a line; zero where it cannot be the head."""


def read_sheet(path: str | PathLike[str], kind: str, fit: Fit, missing: str) -> Sheet:
    """Return the table of the file `path` below its line of names, the line that fits best.

    `kind`: of the expected file, `missing`: the line of names in words; both for messages. `fit`:
    function of headings to the number of known columns among them. `InputError` without that line.
    """
    return sheet_in(read_lines(path, kind), fit, missing)


def sheet_in(text: Text, fit: Fit, missing: str) -> Sheet:
    """Return the table of a `text` below its line of names, the line that fits best.

    `fit`: function from headings to the number of known ones. `missing`: that line, for the error.
    """
    head = head_of(text, fit)
    if head is not None:
        return _rows(text, *head)
    for i, content in enumerate(text.lines[:MAX_HEAD_LINE]):
        if max(map(content.count, _SEPARATORS)) >= MAX_COLUMNS:
            raise text.error(i + 1, f"it has more than {MAX_COLUMNS} columns")
    raise InputError(f"{text.source} has no line of {missing}")


def head_of(text: Text, fit: Fit) -> tuple[int, Headings, str] | None:
    """Return index, names and separator of the line of names in a `text`; None without one.

    It is the line with the most known columns, by `fit`; of equal ones the first above a row with
    as many cells (`matches`). The search ends at a line that is certain, with three known columns
    above such a row.
    """
    best, head = (0.0, False), None
    for i, headings, separator in _candidates(text):
        score = fit(headings)
        if not score or (score, True) <= best:
            continue
        below = text.lines[i + 1 : i + 1 + MAX_HEAD_LINE]
        row = next((line for line in below if line.strip() and not is_comment(line)), "")
        matches = len(_split(row, separator)) == len(headings)
        if (score, matches) > best:
            best, head = (score, matches), (i, headings, separator)
        if matches and score >= _CERTAIN_COLUMNS:
            break
    return head


def cell_number(key: str, cell: str) -> float:
    """Return the number of a `cell`; `InputError` about `key` for another text."""
    try:
        return float(cell)
    except ValueError:
        raise InputError(f"{key} must be a number; got {shown(cell)}") from None


def letters(name: str) -> str:
    """Return the letters and digits of a name in lower case, which no encoding damages."""
    return "".join(c for c in name.lower() if c.isascii() and c.isalnum())


def is_comment(content: str) -> bool:
    """Return whether a line `content` is a comment: by its mark, or an event of OpenRocket."""
    bare = content.lstrip("\"' \t\ufeff")
    return bare.startswith(("#", "%", "!", "//")) or bare.startswith("Event ")


def _candidates(text: Text) -> Iterator[tuple[int, Headings, str]]:
    """Yield index, headings and separator of each line of `text` without a number in its cells.

    A line is split by each possible separator in turn; empty cells at its end are omitted.
    """
    for i, content in enumerate(text.lines[:MAX_HEAD_LINE]):
        if len(content) > MAX_COLUMNS * _MAX_NAME_LENGTH or _FIRST_NUMBER.match(content):
            continue
        for separator in (*_SEPARATORS, _AFTER_UNITS, _BLANKS):
            cells = _split(content.lstrip(_LEADING_MARKS), separator)
            while cells and not cells[-1].strip():
                cells.pop()
            if cells:
                cells[0] = cells[0].lstrip(_LEADING_MARKS)
            if 1 < len(cells) <= MAX_COLUMNS and not any(map(_NUMBER.fullmatch, cells)):
                yield i, tuple(_heading(k, cell) for k, cell in enumerate(cells)), separator


def _split(content: str, separator: str) -> list[str]:
    """Return the cells of a line `content`, also of a line that is quoted entirely.

    `separator`: a character, or one of `_AFTER_UNITS`, blanks after a closing bracket, and
    `_BLANKS`, all blanks.
    """
    if separator == _AFTER_UNITS:
        return re.split(r"(?<=[)\]])\s+(?=[^\s(\[])", content.strip())
    if separator == _BLANKS:
        return content.split()
    try:
        cells = next(csv.reader([content], delimiter=separator, skipinitialspace=True), [])
    except csv.Error:
        return content.split(separator)
    # a line in one pair of quotation marks
    if len(cells) == 1 and separator in cells[0] and content.lstrip().startswith('"'):
        return cells[0].split(separator)
    return cells


def _heading(index: int, cell: str) -> Heading:
    """Return the heading of a `cell` at a column `index`, with the unit in its last parentheses."""
    text = " ".join("".join(c for c in cell if c.isprintable()).strip(' "').split())
    match = re.fullmatch(r"(.*\S)\s*[(\[]([^()\[\]]*)[)\]]", text)
    name, unit = (match[1], match[2].strip()) if match else (text, None)
    return Heading(index=index, text=text, name=name, unit=unit)


def _rows(text: Text, head: int, headings: Headings, separator: str) -> Sheet:
    """Return the sheet of the rows of `text` below the line of names, of index `head`.

    Empty lines and comments are skipped, and rows end at the markup of a page. `headings`,
    `separator`: of that line. `InputError` naming the line for another number of cells.
    """
    for cell in headings:
        if len(cell.text) > _MAX_NAME_LENGTH:
            raise text.error(
                head + 1,
                f"a name of a column has at most {_MAX_NAME_LENGTH} letters; got"
                f" {shown(cell.text)}",
            )
    rows: list[Cells] = []
    line: list[int] = []
    separator = separator if separator in _SEPARATORS else _BLANKS
    for n, content in enumerate(text.lines[head + 1 :], start=head + 2):  # n: line number, from 1
        if content.lstrip().startswith("<"):  # the markup of a page goes on
            break
        if not content.strip(" \t,;") or is_comment(content):
            continue
        cells = [cell.strip(' "\u200b') for cell in _split(content, separator)]
        while len(cells) > len(headings) and not cells[-1]:
            cells.pop()
        if len(cells) != len(headings):
            hint = "; are there decimal commas?" if len(cells) > len(headings) else ""
            raise text.error(
                n,
                f"there are {len(headings)} names and {plural(len(cells), 'cell')} in this line"
                f"{hint}",
            )
        rows.append(tuple(cells))
        line.append(n)
    if not rows:
        raise InputError(f"{text.source} has no row below its line of names")
    rows = _with_decimal_points(text, line, rows)
    numbers, notes = np.array(line, dtype=np.int64), _skipped(text.lines[:head])
    return Sheet(text, headings, line=numbers, cells=tuple(rows), head=head, notes=notes)


def _skipped(lines: tuple[str, ...]) -> tuple[str, ...]:
    """Return notes on lines above the names, except comments and markup."""
    above = [line.strip() for line in lines if line.strip() and not is_comment(line)]
    above = [line for line in above if not line.startswith("<")]
    if not above:
        return ()
    count, first = plural(len(above), "line"), shown(above[0])
    return (f"{count} above the names of columns skipped, the first {first}",)


def _with_decimal_points(text: Text, line: list[int], rows: list[Cells]) -> list[Cells]:
    """Return the cells of `rows` with decimal points: without any point, commas are decimal.

    A comma is doubtful if all commas may separate thousands, "1,234". `line`: line numbers of
    the rows of `text`, for the error about a mixture or a doubtful comma.
    """
    decimals = [
        [(match[1], cell) for cell in row if (match := _DECIMAL.fullmatch(cell))] for row in rows
    ]
    commas = [cell for row in decimals for mark, cell in row if mark == ","]
    if not commas:
        return rows
    problem = ""
    if any(mark == "." for row in decimals for mark, _ in row):
        problem = "numbers have decimal commas, others points"
    elif all(map(_THOUSANDS.fullmatch, commas)):
        problem = f"the comma of {commas[0]} may be that of decimals or of thousands"
    if problem:
        line_number = next(
            n for n, row in zip(line, decimals, strict=True) if any(m == "," for m, _ in row)
        )
        raise text.error(line_number, f"{problem}; export the file with points")
    return [
        tuple(cell.replace(",", ".") if _DECIMAL.fullmatch(cell) else cell for cell in row)
        for row in rows
    ]
