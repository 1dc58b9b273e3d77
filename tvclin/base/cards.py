"""A record as a small table in a notebook: one line for each name, with value and unit."""

import re
from collections.abc import Iterable, Iterator
from html import escape
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np

from tvclin.base.arrays import AnyArray
from tvclin.base.documents import picked
from tvclin.base.lines import Line, Table, number, text
from tvclin.base.units import UNITS, written

_WIDTH = 88
"""Characters of a line of a record that is printed in several lines."""

_FEW = 6
"""An array of so many numbers at most is shown in full, a longer one by its range."""

_SUFFIXES = {suffix for kind in UNITS.values() for suffix in kind} | {"dB"}

_LEAST = 1e-3
"""Angles [deg] above their last digit are shown to it, smaller ones to six digits."""

Row = tuple[str, Any, str]


class Quantity(NamedTuple):
    """A number of a record as every table shows it: its key among others, label, value and unit."""

    key: str
    label: str
    value: Any
    unit: str


def card(title: str, rows: Iterable[Row]) -> str:
    """Return a table in HTML, all texts escaped.

    `title`: stands above the table. `rows`: name, value and unit of each line. Numbers are shown to
    six digits, arrays of more than six numbers by their range and shape, an angle to a thousandth
    of a degree.
    """
    lines = "".join(
        f'<tr><th scope="row" style="text-align:left">{escape(name)}</th>'
        f'<td style="text-align:right">{escape(_shown(value, unit))}</td>'
        f'<td style="text-align:left">{escape(unit)}</td></tr>'
        for name, value, unit in rows
    )
    caption = f'<caption style="text-align:left"><b>{escape(title)}</b></caption>'
    return f"<table>{caption}{lines}</table>"


def line(title: str, rows: Iterable[Row]) -> str:
    """Return the same rows as `card`, as text between angle brackets without line breaks."""
    words = (
        " ".join((name, _shown(x, unit), unit.removeprefix("-"))).strip() for name, x, unit in rows
    )
    return f"<{title}: {', '.join(words)}>"


def lines(title: str, rows: Iterable[Row]) -> str:
    """Return the same text as `line`, broken into lines of at most 88 characters."""
    return fill(line(title, rows), _WIDTH, subsequent_indent="  ", break_long_words=False)


class Carded:
    """A value that a notebook shows as a small table.

    What is shown are its `_keys`, as of `picked`, each with its unit at the end; of a value without
    any its `as_dict`.
    """

    _keys = ""

    def _quantities(self) -> Iterator[Row]:
        """Yield names, values and units; of each part of a mapping. What is not there is left out.

        A value in a value is one that has a card too.
        """
        record: Any = self
        found = picked(record, self._keys) if self._keys else record.as_dict()
        for key, value in found.items():
            yield from _parts(*named(key), value)

    def _repr_html_(self) -> str:
        return card(_title(type(self)), self._quantities())


class Shown(Carded):
    """An answer: `print` says in a few words what its card shows."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "__repr__" not in vars(cls):
            cls.__repr__ = Shown.__repr__  # type: ignore[method-assign]  # ahead of a dataclass

    def __repr__(self) -> str:
        return line(_title(type(self)), self._quantities())


def _parts(name: str, unit: str, value: Any) -> Iterator[Row]:
    if isinstance(value, dict):
        for part, one in value.items():
            yield from _parts(f"{name}, {part}", unit, one)
    elif isinstance(value, Carded):
        yield from ((f"{name}, {part}", *rest) for part, *rest in value._quantities())
    elif isinstance(value, tuple) and value and isinstance(value[0], Carded):
        named = {one.name: one for one in value if hasattr(one, "name")}
        yield from _parts(name, "", named or len(value))
    elif value is not None and not (isinstance(value, str | tuple) and not value):
        yield name, value, unit


def _title(kind: type) -> str:
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", kind.__name__).lower()
    return words[:1].upper() + words[1:]


def named(key: str) -> tuple[str, str]:
    """Return the name in a key, and the unit at its end."""
    for place in (k for k, one in enumerate(key) if one == "_"):
        if key[place + 1 :] in _SUFFIXES:
            return key[:place].replace("_", " "), written(key[place + 1 :])
    return key.replace("_", " "), ""


def table(shown: Table, said: Iterable[Line] = ()) -> str:
    """Return a table of an answer in HTML, and what is said below it, all texts escaped."""
    head = "".join(f'<th scope="col">{escape(name)}</th>' for name in shown.head)
    lines = "".join(
        f"<tr>{''.join(f'<td>{escape(text(cell))}</td>' for cell in row)}</tr>"
        for row in shown.rows
    )
    caption = f'<caption style="text-align:left"><b>{escape(shown.caption)}</b></caption>'
    words = "".join(f"<p>{escape(text(line))}</p>" for line in said)
    return f"<table>{caption}<tr>{head}</tr>{lines}</table>{words}"


def _shown(value: Any, unit: str = "") -> str:
    if isinstance(value, tuple) and all(isinstance(one, str) for one in value):
        value = "; ".join(value) or "none"
    if value is None or isinstance(value, str):
        return value or "not given"
    array = np.asarray(value)
    if array.size == 0:
        return "none"
    if array.dtype.kind == "b":
        return ", ".join("yes" if one else "no" for one in array.ravel()[:_FEW])
    if array.dtype.kind not in "iufc":
        return ", ".join(np.unique(array.astype(str)).tolist())
    return _numbers(array, unit)


def _numbers(array: AnyArray, unit: str) -> str:
    if array.size == 1 and unit == "deg" and np.isrealobj(array) and _LEAST <= abs(array) < np.inf:
        return text(number("", array.item()))
    if array.size <= _FEW:
        return ", ".join(f"{one:.6g}" for one in array.ravel().tolist())
    known = array[~np.isnan(array)]
    span = f"{known.min():.6g} to {known.max():.6g}" if known.size else "nan"
    return f"{span}, shape {array.shape}"
