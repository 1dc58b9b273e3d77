"""A record as a small table in a notebook: one line for each name, with value and unit."""

from collections.abc import Iterable
from html import escape
from typing import Any, NamedTuple

import numpy as np

_FEW = 6
"""An array of so many numbers at most is shown in full, a longer one by its range."""

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


def _shown(value: Any) -> str:
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
