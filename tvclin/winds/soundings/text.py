"""Text files of winds: their lines, the numbers in them, and errors that name the line."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray, IntArray
from tvclin.base.errors import InputError, shown
from tvclin.base.errors import path as a_path
from tvclin.base.files import called, read_text

MOST_COLUMNS, LATEST_HEADER = 1000, 1000
"""Columns of a table, and lines up to that with their names: no real one has more."""
_MISSING = {"", "-", "--", "nan", "na", "n/a", "null", "none"}


@dataclass(frozen=True)
class Text:
    """The lines of a file without their ends, and what to call it; line numbers count from 1."""

    source: str
    lines: tuple[str, ...]

    def error(self, line: int, message: str) -> InputError:
        """Return an error about a line."""
        return InputError(f"{self.source}, line {line}: {message}")

    def numbers(self, column: str, cells: Sequence[str], line: IntArray) -> FloatArray:
        """Return the numbers in the cells of a column, NaN where one is empty."""
        try:
            values = np.array(cells, dtype=float)
        except ValueError:
            values = np.array([np.inf])
        if np.any(np.isinf(values)):  # empty cells, or worse: look at each
            pairs = zip(cells, line.tolist(), strict=True)
            return np.array([self._number(column, *pair) for pair in pairs], dtype=float)
        return values

    def _number(self, column: str, cell: str, line: int) -> float:
        try:
            value = float(cell)
        except ValueError:
            if cell.strip().lower() in _MISSING:
                return np.nan
            value = np.inf
        if np.isinf(value):
            raise self.error(
                line, f"{column} must be a number, or empty; got {shown(cell.strip())}"
            )
        return value

    def require(self, good: BoolArray, line: IntArray, say: Callable[[int], str]) -> None:
        """Raise an error about the first line that is not good; `say` gets its index."""
        if not np.all(good):
            first = int(np.argmin(good))
            raise self.error(int(line[first]), say(first))


def read_lines(
    path: str | PathLike[str], kind: str = "a file of winds", errors: str = "strict"
) -> Text:
    """Return the lines of a text file, whatever their ends; `kind` and `errors` as `read_text`."""
    content = read_text(a_path("path", path), kind, errors=errors)
    if "\0" in content:
        raise InputError(f"{called(path)} is not a text file")
    return Text(called(path), tuple(re.split(r"\r\n|\r|\n", content)))
