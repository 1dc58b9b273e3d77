"""Lines of text files, the numbers in them, and errors that name the line."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray, IntArray
from tvclin.base.errors import InputError, shown
from tvclin.base.errors import path as a_path
from tvclin.base.files import ENCODINGS, called, read_text

MISSING_NUMBERS = (-8888.0, -9999.0, -32768.0, -99999.0)
"""Numbers that mark a missing value in every column."""
_MISSING_WORDS = {"", "-", "--", "---", "nan", "na", "n/a", "m", "null", "none"}


@dataclass(frozen=True)
class Text:
    """Lines of a file without their ends, and its name in messages; line numbers start at 1."""

    source: str
    lines: tuple[str, ...]

    def error(self, line: int, message: str) -> InputError:
        """Return an error about a line."""
        return InputError(f"{self.source}, line {line}: {message}")

    def numbers(self, column: str, cells: Sequence[str], line: IntArray) -> FloatArray:
        """Return the numbers in the cells of a column, NaN where a value is missing."""
        try:
            values = np.array(cells, dtype=float)
        except ValueError:
            values = np.array([np.inf])
        if np.any(np.isinf(values)):  # empty or invalid cells: parse each
            pairs = zip(cells, line.tolist(), strict=True)
            values = np.array([self._number(column, *pair) for pair in pairs], dtype=float)
        return np.where(np.isin(values, MISSING_NUMBERS), np.nan, values)

    def _number(self, column: str, cell: str, line: int) -> float:
        """Return the number of a cell; NaN for a missing value, an error for other text."""
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
        """Raise an error about the first line that is not good; `say` makes it from the index."""
        if not np.all(good):
            first = int(np.argmin(good))
            raise self.error(int(line[first]), say(first))


def read_lines(path: str | PathLike[str], kind: str = "a file of winds") -> Text:
    """Return the lines of a text file in any of `ENCODINGS`; `kind` as `read_text`."""
    content = read_text(a_path("path", path), kind, encodings=ENCODINGS)
    return lines_of(content, str(path))


def lines_of(content: str, source: str) -> Text:
    """Return the lines of a text, with any line ends; `source` names it in messages."""
    if "\0" in content:
        raise InputError(f"{called(source)} is not a text file")
    return Text(called(source), tuple(re.split(r"\r\n|\r|\n", content)))
