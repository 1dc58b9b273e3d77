"""Straight lines between the rows of tables, at many times of several tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray, IndexArray


@dataclass(frozen=True, eq=False)
class TableLines:
    """Times at which tables with rows at common times are read, constant outside them.

    `rows`: times of the rows, rising, ``(n,)``. `at`: times at which they are read, ``(...)``.
    `table`: index of the table that is read at each, ``(...)`` or one for all.
    """

    rows: FloatArray
    at: FloatArray
    table: IndexArray | int = 0

    @cached_property
    def _lines(self) -> tuple[IndexArray, FloatArray]:
        """Index of the row before each time, and the time since that row, zero before the first.

        It counts after the last row too, where the slope of the table is zero.
        """
        before = np.searchsorted(self.rows, self.at, side="right") - 1
        before = np.maximum(before, 0)
        return before, np.maximum(self.at - self.rows[before], 0.0)

    def values(self, columns: Sequence[Any]) -> Any:
        """Return one column of the tables, interpolated linearly at the times, ``(...)``.

        Each time is read in its own table, `self.table`; before the first and after the last row
        the value is constant. `columns`: this column in each table, ``(n,)`` or a number. A number
        that all tables share is returned as it is.
        """
        alike = all(column is columns[0] for column in columns)
        if alike and np.ndim(columns[0]) == 0:
            return columns[0]
        if all(np.ndim(column) == 0 for column in columns):
            return np.array(columns)[self.table]
        table = 0 if alike else self.table
        values = np.stack(
            [np.broadcast_to(column, self.rows.shape) for column in columns[: 1 if alike else None]]
        )
        slopes = np.zeros_like(values)
        slopes[:, :-1] = np.diff(values) / np.diff(self.rows)
        before, since = self._lines  # row before each time, and the time since that row
        return slopes[table, before] * since + values[table, before]
