"""Numbers of an answer as columns over named axes: as CSV, and as an `xarray.Dataset`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.arrays import AnyArray
from tvclin.base.cards import Shown
from tvclin.base.errors import imported
from tvclin.base.fields import chosen
from tvclin.base.files import write_rows

if TYPE_CHECKING:
    import xarray

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
        """Return a CSV line for each position on the axes, and write it if there is a path."""
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
        return make(
            {
                column.key: (
                    names if column.axes is None else column.axes,
                    column.values,
                    column.attributes,
                )
                for column in self.columns
            },
            coords={
                column.key: (column.key, column.values, column.attributes) for column in self.axes
            },
            attrs=dict(self.about),
        )

    def _broadcast_axes(self, column: Column) -> AnyArray:
        """Return the values of a column in the units of CSV, with all axes of the table."""
        values, axes = np.asarray(column.values), column.axes
        if column.unit == "rad":
            values = np.degrees(values)
        elif column.unit == "UTC":
            values = values.astype("datetime64[m]").astype(str)
        if column in self.axes:
            axes, values = (column.key,), values.round(12) if column.unit == "rad" else values
        if axes is None:
            return values
        return values.reshape([len(x.values) if x.key in axes else 1 for x in self.axes])


def columns_of(record: Any, *names: str, axes: tuple[str, ...] | None = None) -> tuple[Column, ...]:
    """Return fields of a record, by their names, as columns."""
    return tuple(
        Column(item.name, np.asarray(item.si_value(record)), item.si_unit or "1", axes)
        for item in chosen(record, *names)
    )


class Tabled(Shown):
    """Answer whose numbers are `_columns`."""

    def _columns(self) -> Columns:
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
        """Return all numbers as an `xarray.Dataset` in SI units, which stand beside each variable.

        Raises
        ------
        InputError
            Where xarray is not installed.
        """
        return self._columns().dataset()


def _cell(value: Any) -> Any:
    """Return a value as a cell, empty for an unknown value."""
    return "" if value is None or (isinstance(value, float) and np.isnan(value)) else value
