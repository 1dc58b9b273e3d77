"""The numbers of an answer as columns over named axes: as CSV, and as an `xarray.Dataset`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.arrays import AnyArray
from tvclin.base.cards import Shown
from tvclin.base.errors import imported
from tvclin.base.files import write_rows

if TYPE_CHECKING:
    import xarray

_IN_CSV = {"rad": "deg", "UTC": "utc", "1": "", "": ""}
"""What units are in the headings of CSV, where not as they are."""


@dataclass(frozen=True, eq=False)
class Column:
    """Numbers or words over axes, of which some may be left out; an axis has itself alone.

    `key`: its name, without a unit. `values`: in SI units. `unit`: that unit; empty of words, and
    "UTC" of dates. `axes`: all of the table where they are not given.
    """

    key: str
    values: AnyArray
    unit: str = "1"
    axes: tuple[str, ...] | None = None

    @property
    def attributes(self) -> dict[str, str]:
        """What a Dataset says of it."""
        return {} if self.unit in ("", "UTC") else {"units": self.unit}

    @property
    def heading(self) -> str:
        """Its name in CSV, with the unit there."""
        unit = _IN_CSV.get(self.unit, self.unit.replace("/", "_per_").replace(" ", "_"))
        return f"{self.key}_{unit}" if unit else self.key


@dataclass(frozen=True, eq=False)
class Columns:
    """Columns of one answer over its axes; of a CSV the last axis runs fastest.

    `about`: what a Dataset says of the whole.
    """

    axes: tuple[Column, ...]
    columns: tuple[Column, ...]
    about: Mapping[str, Any] = field(default_factory=dict)

    def csv(self, path: Path | None = None) -> str:
        """Return a line for each place on the axes, and write it where a path is given."""
        shape = tuple(len(one.values) for one in self.axes)
        every = (*self.axes, *self.columns)
        cells = [np.broadcast_to(self._over_all(one), shape).ravel() for one in every]
        texts = [[_cell(x) for x in column.tolist()] for column in cells]
        return write_rows([[one.heading for one in every], *zip(*texts, strict=True)], path)

    def dataset(self) -> xarray.Dataset:
        """Return all of it as a Dataset, in SI units, which stand beside each variable."""
        make: type[xarray.Dataset]
        make = imported("xarray", "a Dataset needs xarray", "campaign").Dataset
        names = tuple(one.key for one in self.axes)
        return make(
            {
                one.key: (names if one.axes is None else one.axes, one.values, one.attributes)
                for one in self.columns
            },
            coords={one.key: (one.key, one.values, one.attributes) for one in self.axes},
            attrs=dict(self.about),
        )

    def _over_all(self, one: Column) -> AnyArray:
        """The values of a column in the units of CSV, with an axis for each of the table."""
        values, own = np.asarray(one.values), one.axes
        if one.unit == "rad":
            values = np.degrees(values)
        elif one.unit == "UTC":
            values = values.astype("datetime64[m]").astype(str)
        if one in self.axes:
            own, values = (one.key,), values.round(12) if one.unit == "rad" else values
        if own is None:
            return values
        return values.reshape([len(x.values) if x.key in own else 1 for x in self.axes])


class Tabled(Shown):
    """An answer whose numbers are `_columns`."""

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
    """Return a value as a cell, empty for what is not known."""
    return "" if value is None or (isinstance(value, float) and np.isnan(value)) else value
