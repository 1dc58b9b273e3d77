"""Files of sampled winds: a table with a column of times and one for each wind."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import shown
from tvclin.base.sheet import Heading, Headings, Sheet, read_lines, sheet_in
from tvclin.base.units import UNITS, WRITTEN, unit_of


def read_winds(path: Path, unit: str | None) -> tuple[FloatArray, FloatArray]:
    """Return the times [s] of the first column, and the winds [rad] ``(winds, n)`` of the rest.

    `unit`: unit in [wind], for columns whose names have none; degrees where it is None.
    """
    text = read_lines(path)
    sheet = sheet_in(text, _fit_of_winds, "names: a first column time_s and one for each wind")
    time, *winds = sheet.headings
    time_unit = unit_of(" ".join(time.words[1:]), WRITTEN["time"])
    assert time_unit is not None  # by the fit
    columns = [time_unit.factor * _column(sheet, time)]
    for wind in winds:
        factor = UNITS["angle"][unit or "deg"]
        column_unit = None if wind.unit is None else unit_of(wind.unit, WRITTEN["angle"])
        if column_unit is not None and not column_unit.mangled:
            if unit is not None and not np.isclose(column_unit.factor, factor):
                raise sheet.error(f"{shown(wind.text)} is not in {unit}, the unit in [wind]")
            factor = column_unit.factor
        columns.append(factor * _column(sheet, wind))
    return columns[0], np.array(columns[1:])


def _fit_of_winds(headings: Headings) -> float:
    first, *units = headings[0].words or [""]
    unit = unit_of(" ".join(units), WRITTEN["time"])
    return 1.0 if first == "time" and unit is not None and not unit.mangled else 0.0


def _column(sheet: Sheet, heading: Heading) -> FloatArray:
    """Return the numbers of a column; an error names the line of a missing one."""
    values = sheet.text.numbers(heading.text, sheet.column(heading), sheet.line)
    sheet.text.require(
        ~np.isnan(values), sheet.line, lambda _: f"there is no number in {heading.text}"
    )
    return values
