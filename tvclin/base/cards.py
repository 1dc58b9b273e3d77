"""Records as cards: a line for each name, with value and unit; and as columns over named axes.

Columns are written as CSV and as an `xarray.Dataset`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.arrays import AnyArray
from tvclin.base.errors import imported
from tvclin.base.fields import chosen, document, fields_of
from tvclin.base.files import write_rows
from tvclin.base.lines import Line, Table, number, text

if TYPE_CHECKING:
    import xarray


_LINE_WIDTH = 88
"""Characters per line of a printed record."""

_MAX_LISTED_NUMBERS = 6
"""Largest number of elements of an array that is shown in full, not by its range."""

_MIN_FIXED_ANGLE = 1e-3
"""Angle [deg] above which it is shown to three decimals, not to six digits."""

Row = tuple[str, Any, str]


def card_rows(record: Any) -> Iterator[Row]:
    """Yield label, value and unit of each given field of a `record` for a card, also of nested.

    Fields are the `Field` specified at its attributes; those with ``card=False``, and values of
    None, are omitted.
    """
    for item in fields_of(record):
        if item.card:
            yield from _parts(item.title, item.unit, item.value(record))


def card(title: str, rows: Iterable[Row]) -> str:
    """Return a table in HTML of `rows` of name, value and unit under a `title`, all texts escaped.

    Numbers have six digits, angles three decimals of a degree; longer arrays are range and shape.
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
    """Return `rows` of name, value and unit as one line of text: <title: name value unit, ...>."""
    words = (
        " ".join((name, _shown(x, unit), unit.removeprefix("-"))).strip() for name, x, unit in rows
    )
    return f"<{title}: {', '.join(words)}>"


def lines(title: str, rows: Iterable[Row]) -> str:
    """Return the text of `line` for a `title` and `rows`, in lines of at most 88 characters."""
    return fill(line(title, rows), _LINE_WIDTH, subsequent_indent="  ", break_long_words=False)


class Record:
    """Value that a notebook shows as a small table, and JSON as a document, made of its fields."""

    def as_dict(self) -> dict[str, Any]:
        """Return the record as the command line prints it as JSON, angles in degrees."""
        return document(self)

    def _repr_html_(self) -> str:
        """Return the fields of the record as a table in HTML."""
        return card(_title(type(self)), card_rows(self))


class Shown(Record):
    """Answer whose printed text is a short form of its card."""

    def __init_subclass__(cls, **options: Any) -> None:
        """Give a subclass the text of `Shown` before a dataclass writes its own.

        A dataclass writes a ``__repr__`` of all fields unless the class itself has one. `options`:
        arguments of the class statement, for other bases.
        """
        super().__init_subclass__(**options)
        if "__repr__" not in vars(cls):
            cls.__repr__ = Shown.__repr__  # type: ignore[method-assign]  # ahead of a dataclass

    def __repr__(self) -> str:
        """Return the fields of the record as a line of text."""
        return line(_title(type(self)), card_rows(self))


def _parts(name: str, unit: str, value: Any) -> Iterator[Row]:
    """Yield rows (label, value, unit) of a field: one, or one per entry of a mapping or `Record`.

    A tuple of records has the rows of each record, labelled by its name; without names a row with
    the number of records. Nothing is yielded for None and an empty text or tuple. `name`: label of
    the field, which stands ahead of the labels of entries. `unit`: text, of the value and its
    entries.
    """
    if isinstance(value, dict):
        for label, item in value.items():
            yield from _parts(f"{name}, {label}", unit, item)
    elif isinstance(value, Record):
        yield from ((f"{name}, {label}", *rest) for label, *rest in card_rows(value))
    elif isinstance(value, tuple) and value and isinstance(value[0], Record):
        by_name = {item.name: item for item in value if hasattr(item, "name")}
        yield from _parts(name, "", by_name or len(value))
    elif value is not None and not (isinstance(value, str | tuple) and not value):
        yield name, value, unit


def _title(kind: type) -> str:
    """Return the name of a class, `kind`, as words: BoundaryLimit is "Boundary limit"."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", kind.__name__).lower()
    return words[:1].upper() + words[1:]


def table(shown: Table, said: Iterable[Line] = ()) -> str:
    """Return the table `shown` of an answer in HTML, and the lines `said` below it, all escaped."""
    head = "".join(f'<th scope="col">{escape(name)}</th>' for name in shown.head)
    lines = "".join(
        f"<tr>{''.join(f'<td>{escape(text(cell))}</td>' for cell in row)}</tr>"
        for row in shown.rows
    )
    caption = f'<caption style="text-align:left"><b>{escape(shown.caption)}</b></caption>'
    words = "".join(f"<p>{escape(text(line))}</p>" for line in said)
    return f"<table>{caption}<tr>{head}</tr>{lines}</table>{words}"


def _shown(value: Any, unit: str = "") -> str:
    """Return the text of a `value` in a card, to six digits; a `unit` "deg" to three decimals.

    Texts are themselves, flags yes or no, and an array of words its different words.
    """
    if isinstance(value, tuple) and all(isinstance(item, str) for item in value):
        value = "; ".join(value) or "none"
    if value is None or isinstance(value, str):
        return value or "not given"
    array = np.asarray(value)
    if array.size == 0:
        return "none"
    if array.dtype.kind == "b":
        return ", ".join("yes" if item else "no" for item in array.ravel()[:_MAX_LISTED_NUMBERS])
    if array.dtype.kind not in "iufc":  # no numbers: words
        return ", ".join(np.unique(array.astype(str)).tolist())
    return _numbers(array, unit)


def _numbers(array: AnyArray, unit: str) -> str:
    """Return the text of an array in a `unit`: its numbers, or range and shape of a long one."""
    is_angle = array.size == 1 and unit == "deg" and np.isrealobj(array)
    if is_angle and _MIN_FIXED_ANGLE <= abs(array) < np.inf:
        return text(number("", array.item()))  # a number without a name, to three decimals
    if array.size <= _MAX_LISTED_NUMBERS:
        return ", ".join(f"{value:.6g}" for value in array.ravel().tolist())
    defined = array[~np.isnan(array)]
    span = f"{defined.min():.6g} to {defined.max():.6g}" if defined.size else "nan"
    return f"{span}, shape {array.shape}"


_CSV_UNITS = {"rad": "deg", "UTC": "utc", "1": "", "": ""}
"""Units in the headings of CSV that differ from the units of a column."""


@dataclass(frozen=True, eq=False)
class Column:
    """Numbers or words over some axes of a table; an axis is a column over itself.

    `key`: name without a unit. `values`: in SI units. `unit`: that unit; empty for words, and "UTC"
    for dates. `axes`: by default all axes of the table.
    """

    key: str
    values: AnyArray
    unit: str = "1"
    axes: tuple[str, ...] | None = None

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of the variable in a Dataset."""
        return {} if self.unit in ("", "UTC") else {"units": self.unit}

    @property
    def heading(self) -> str:
        """Name in CSV, with the unit there."""
        unit = _CSV_UNITS.get(self.unit, self.unit.replace("/", "_per_").replace(" ", "_"))
        return f"{self.key}_{unit}" if unit else self.key


@dataclass(frozen=True, eq=False)
class Columns:
    """Columns of an answer over its axes; in CSV the last axis runs fastest.

    `about`: attributes of the Dataset.
    """

    axes: tuple[Column, ...]
    columns: tuple[Column, ...]
    about: Mapping[str, Any] = field(default_factory=dict)

    def csv(self, path: Path | None = None) -> str:
        """Return CSV, a line for each position on the axes; also written to `path`, if given."""
        shape = tuple(len(column.values) for column in self.axes)
        columns = (*self.axes, *self.columns)
        cells = [np.broadcast_to(self._broadcast_axes(column), shape).ravel() for column in columns]
        texts = [[_cell(x) for x in column.tolist()] for column in cells]
        return write_rows([[column.heading for column in columns], *zip(*texts, strict=True)], path)

    def dataset(self) -> xarray.Dataset:
        """Return all columns as a Dataset in SI units, which are attributes of each variable."""
        make: type[xarray.Dataset]
        make = imported("xarray", "a Dataset needs xarray", "campaign").Dataset
        names = tuple(column.key for column in self.axes)
        variables = {
            x.key: (names if x.axes is None else x.axes, x.values, x.attributes)
            for x in self.columns
        }
        coordinates = {x.key: (x.key, x.values, x.attributes) for x in self.axes}
        return make(variables, coords=coordinates, attrs=dict(self.about))

    def _broadcast_axes(self, column: Column) -> AnyArray:
        """Return the values of a `column` in units of CSV, in a shape that broadcasts to all axes.

        It has a length of one along axes of the table on which the column does not depend.
        """
        values, axes = np.asarray(column.values), column.axes
        if column.unit == "rad":
            values = np.degrees(values)
        elif column.unit == "UTC":
            values = values.astype("datetime64[m]").astype(str)
        if column in self.axes:  # an axis; degrees are rounded, so that 0.3 is not 0.30000000000004
            axes, values = (column.key,), values.round(12) if column.unit == "rad" else values
        if axes is None:
            return values
        return values.reshape([len(x.values) if x.key in axes else 1 for x in self.axes])


def columns_of(record: Any, *names: str, axes: tuple[str, ...] | None = None) -> tuple[Column, ...]:
    """Return the fields `names` of a record as columns in SI units over `axes`, by their names.

    Without axes they are over all axes of the table; "1" is the unit of a number without one.
    """
    return tuple(
        Column(item.name, np.asarray(item.si_value(record)), item.si_unit or "1", axes)
        for item in chosen(record, *names)
    )


class Tabled(Shown):
    """Answer whose numbers are columns over axes, for a CSV and a Dataset: `_columns`."""

    def _columns(self) -> Columns:
        """Return the numbers of the answer as columns over its axes."""
        raise NotImplementedError

    def to_csv(self, path: Path | None = None) -> str:
        """Return all numbers as CSV, and write it where a path is given.

        Angles are in degrees, units at the end of the headings; what is not known is empty. Every
        number reads back as the same one. A name that begins with ``=``, ``+``, ``-`` or ``@`` has
        an apostrophe ahead of it, so that no spreadsheet takes it for a formula.

        Raises
        ------
        InputError
            When the file cannot be written.
        """
        return self._columns().csv(path)

    def to_xarray(self) -> xarray.Dataset:
        """Return all numbers as an `xarray.Dataset` in SI units, which its variables name.

        Raises
        ------
        InputError
            Where xarray is not installed.
        """
        return self._columns().dataset()


def _cell(value: Any) -> Any:
    """Return a number or text `value` for a cell of CSV; "" for None and NaN."""
    return "" if value is None or (isinstance(value, float) and np.isnan(value)) else value
