"""Lines of text with numbers in them, each as displayed and in full precision.

Angles and limits over trim have three decimals everywhere: a deflection is built, and flights are
searched, to about a thousandth.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Number:
    """Number of a page.

    `name`: unique name, with the unit. `value`: in full precision, in the displayed unit. `text`:
    as displayed.
    """

    name: str
    value: float
    text: str


@dataclass(frozen=True)
class Formula:
    """Formula: in LaTeX for the page, and as plain text."""

    tex: str
    text: str


Inline = str | Number | Formula
Line = tuple[Inline, ...]
"""Text with numbers and formulas in it, or a cell of a table."""


Row = tuple[str, Line]
"""Row of a table of a record: a label and its line."""


@dataclass(frozen=True)
class Table:
    """Table of an answer, the same in a terminal, in a notebook and on a page.

    `caption`: text above the table. `head`: headings of the columns, with units. `rows`: cells of
    each row, of which the first is its heading.
    """

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[Line, ...], ...]
    kind = "table"


QUANTITIES = ("quantity", "value")
"""Head of a table of names and values."""
_UNLIMITED = "unlimited"
NONE_SUFFICIENT = "none is sufficient"
"""Text of an infinite minimum limit."""
_SYMBOL = re.compile(r"(Theta|beta|[A-Za-z])(?:_([A-Za-z]+)|(\d))?")
"""Letter and index of a symbol, such as beta, K1 or F_A."""
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def plural(count: int, noun: str) -> str:
    """Return a count with its noun: 1 row, 2 rows."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def listed(names: Iterable[str], word: str = "and") -> str:
    """Return names with commas between, and a word before the last."""
    *others, last = names
    return f"{', '.join(others)} {word} {last}" if others else last


def text(line: Line) -> str:
    """Return a line as displayed text."""
    return "".join(item if isinstance(item, str) else item.text for item in line)


def labelled(label: str) -> Line:
    """Return a label; its last word is a formula where that is a symbol, as in "thrust T".

    A symbol is a letter or Theta or beta, with an index or without: K1, F_A.
    """
    words, space, last = label.rpartition(" ")
    symbol = _SYMBOL.fullmatch(last)
    if symbol is None:
        return (label,)
    letter, index = symbol[1], symbol[2] or symbol[3]  # letters after an underscore, or a digit
    tex = f"\\{letter}" if len(letter) > 1 else letter
    return (words + space, Formula(tex + (f"_{{{index}}}" if index else ""), last))


def quantities(caption: str, rows: Iterable[Row]) -> Table:
    """Return the table of `rows`, names and lines, with a `caption`; a last symbol is a formula."""
    return Table(caption, QUANTITIES, tuple((labelled(label), line) for label, line in rows))


def words(caption: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    """Return the table of `rows` of words under a `caption`, with the headings `head`."""
    return Table(caption, tuple(head), tuple(tuple((cell,) for cell in row) for row in rows))


def as_sentence(note: str) -> str:
    """Return a note with a full stop and, where it begins with a plain word, a capital.

    A symbol or a number, such as "K = 1", stays as it is.
    """
    begins = note[:1].upper() if note.partition(" ")[0].rstrip(",:").isalpha() else note[:1]
    return f"{begins}{note[1:].rstrip('.')}."


_MAX_FIXED = 1e6
"""Size from which a number with decimals would be too wide for a column."""


def number(name: str, value: Any, digits: int = 3, unit: str = "") -> Line:
    """Return `value`, called `name`, to some decimal `digits`, with its `unit` after it.

    NaN is a dash, infinity "unlimited"; from a million on it has four digits and a power of ten.
    """
    if _MAX_FIXED <= abs(float(value)) < np.inf:
        return significant(name, value, unit=unit)
    rounded = round(float(value), digits) or 0.0  # no minus before a zero
    return _shown(name, value, f"{rounded:.{digits}f}", unit)


def minimum_limit(limit: Line) -> Line:
    """Return the cell `limit` of a minimum deflection limit; "none is sufficient" if infinite.

    The cell of an infinite number is the text "unlimited".
    """
    return (NONE_SUFFICIENT,) if limit == (_UNLIMITED,) else limit


def significant(name: str, value: Any, digits: int = 4, unit: str = "") -> Line:
    """Return `value`, called `name`, to some significant `digits`, with its `unit` after it."""
    mantissa, _, power = f"{float(value) + 0.0:.{digits}g}".partition("e")  # no minus before a zero
    shown = f"{mantissa}·10{str(int(power)).translate(_RAISED)}" if power else mantissa
    return _shown(name, value, shown, unit)


def upper_pole(name: str, pole: complex) -> Line:
    """Return `pole` [1/s], called `name`, to five digits; a complex one is its pair, with ±."""
    return complex_number(name, pole, 5, "±")


def complex_number(name: str, value: complex, digits: int = 4, sign: str = "") -> Line:
    """Return `value`, called `name`, to some `digits`, maybe with another `sign` ahead of j."""
    real = significant(f"{name}.real", value.real, digits)
    if not value.imag:
        return real
    sign = sign or ("-" if value.imag < 0.0 else "+")
    return (*real, sign, *significant(f"{name}.imaginary", abs(value.imag), digits), "j")


def degrees(name: str, angle: Any, digits: int = 3, unit: str = "") -> Line:
    """Return `angle` [rad] in degrees to some `digits` and with its `unit`, called `name`_deg."""
    return number(f"{name}_deg", float(np.degrees(angle)), digits, unit)


def _shown(name: str, value: Any, shown: str, unit: str) -> Line:
    """Return `value`, called `name`, as the text `shown` and its `unit`; "-" or "unlimited"."""
    plain = float(value)
    if not np.isfinite(plain):
        return ("-" if np.isnan(plain) else _UNLIMITED,)
    cell = Number(name, plain, shown)
    return (cell, f" {unit}") if unit else (cell,)
