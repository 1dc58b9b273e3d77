"""A record as a small table in a notebook: one line for each name, with value and unit."""

from collections.abc import Callable, Iterable
from functools import reduce
from html import escape
from typing import Any, NamedTuple

import numpy as np

from tvclin.base.lines import Line, Table, text

_FEW = 6
"""An array of so many numbers at most is shown in full, a longer one by its range."""

_DEGREES = float(np.degrees(1.0))

Row = tuple[str, Any, str]


class Quantity(NamedTuple):
    """A number of a record as every table shows it: its key among others, label, value and unit."""

    key: str
    label: str
    value: Any
    unit: str


def card(title: str, rows: Iterable[Row]) -> str:
    """Return a table in HTML, all texts escaped.

    Parameters
    ----------
    title : str
        Stands above the table.
    rows : iterable of (str, object, str)
        Name, value and unit of each line. Numbers are shown to six digits, arrays of more than
        six numbers by their range and shape.
    """
    lines = "".join(
        f'<tr><th scope="row" style="text-align:left">{escape(name)}</th>'
        f'<td style="text-align:right">{escape(_shown(value))}</td>'
        f'<td style="text-align:left">{escape(unit)}</td></tr>'
        for name, value, unit in rows
    )
    caption = f'<caption style="text-align:left"><b>{escape(title)}</b></caption>'
    return f"<table>{caption}{lines}</table>"


def shows(title: str, *names: str) -> Callable[[Any], str]:
    """Return the method `_repr_html_` of a record with a line for each of some attributes.

    Parameters
    ----------
    title : str
        Stands above the table.
    *names : str
        Attributes, of attributes too: "plant.model", each with its unit in brackets if it has
        one: "peak_deflection [deg]". What is held in radians is shown in degrees where the unit
        says so. What is None or empty is left out; of filters and the like there is the number.
    """

    def shown(record: Any) -> str:
        rows = []
        for name in names:
            path, _, unit = name.rstrip("]").partition(" [")
            value = reduce(_of, path.split("."), record)
            if value is None or (isinstance(value, str | tuple) and not value):
                continue
            if isinstance(value, tuple) and not isinstance(value[0], str):
                value = len(value)
            if unit.startswith("deg"):
                value = _DEGREES * np.asarray(value)  # may be complex
            rows.append((path.replace(".", " ").replace("_", " "), value, unit))
        return card(title, rows)

    return shown


def _of(record: Any, name: str) -> Any:
    return None if record is None else getattr(record, name)


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


def _shown(value: Any) -> str:
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
        texts = np.unique(array.astype(str)).tolist()
        return ", ".join(texts)
    if array.size <= _FEW:
        return ", ".join(f"{one:.6g}" for one in array.ravel().tolist())
    return f"{np.nanmin(array):.6g} to {np.nanmax(array):.6g}, shape {array.shape}"
