"""Gains and numbers of filters over the flight in a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Column, Columns
from tvclin.base.errors import InputError, naming, shown
from tvclin.base.sheet import Headings, cell_number, read_sheet
from tvclin.base.tables import FileTable
from tvclin.base.units import si_unit
from tvclin.control.autopilot.feedback import GAINS
from tvclin.control.autopilot.filter_table import COLUMN_PREFIX, ModeNotch
from tvclin.vehicle.filters import Filter

_VARIABLES = {
    "time": "time",
    "speed": "speed",
    "altitude": "altitude",
    "mach": "number",
    "dynamic_pressure": "pressure",
}
"""Variables of the flight with their kinds of units."""
GAIN_COLUMNS = FileTable("a table of gains", _VARIABLES | GAINS)
"""Columns of a table of gains: one variable of the flight, and gains."""
_REQUIRED_GAINS = {"attitude_gain", "rate_gain"}
"""Gains that a table must have."""
_KEYS = "keys such as mach,attitude_gain,rate_gain_s (tvclin init --keys lists them)"
"""Expected line of names, for a message."""


@dataclass(frozen=True, eq=False)
class GainTable:
    """Part of an autopilot's specification that varies over the flight.

    `breakpoints`: rising values ``(n,)`` of `variable` in SI units. `gains`: gains by name,
    ``(n,)``; without gains the specification's, constant or by a rule, count. `chains`: filters at
    the breakpoints, ``(n,)``, by the chain names of an `Autopilot`. `notches`: notches that follow
    a mode.
    """

    variable: str = "time"
    breakpoints: FloatArray = field(default_factory=lambda: np.zeros(0))
    gains: dict[str, FloatArray] = field(default_factory=dict)
    chains: dict[str, tuple[Filter, ...]] = field(default_factory=dict)
    notches: tuple[ModeNotch, ...] = ()


def gain_columns(
    variable: str, breakpoints: FloatArray, gains: Mapping[str, FloatArray | float]
) -> Columns:
    """Return the columns of a CSV table of gains over a variable of the flight.

    Gains of zero are omitted, but not on attitude and rate. `variable`: name of the variable.
    `breakpoints`: its values ``(n,)`` in SI units. `gains`: gains by name, ``(n,)`` or constant.
    """
    columns = [  # axes () of a constant: one number for all breakpoints
        Column(name, np.asarray(gain), si_unit(GAINS[name]), () if np.ndim(gain) == 0 else None)
        for name, gain in gains.items()
        if name in _REQUIRED_GAINS or np.any(gain)
    ]
    points = Column(variable, breakpoints, si_unit(_VARIABLES[variable]))
    return Columns((points,), tuple(columns))


def load_gains(source: str | PathLike[str]) -> tuple[GainTable, dict[str, FloatArray]]:
    """Return the gains over a variable of the flight in a CSV table, and its columns of filters.

    Parameters
    ----------
    source : str or path
        A table with one column of time_s, speed_m_per_s, altitude_m, mach or dynamic_pressure_Pa,
        rising, and columns with the keys of the gains in [autopilot]: attitude_gain, rate_gain_s...
        Columns of filters are filter.N.KEY or filter.MODE.KEY, see `specified_filters`.

    Raises
    ------
    InputError
        For a cell that is no number, an unknown column, no or several columns of variables, values
        that do not rise, and a table without both attitude_gain and rate_gain.
    """

    def known_keys(headings: Headings) -> float:
        """Return in how many columns a line of the file has names of a table of gains.

        The line with most of them has the headings.
        """
        return float(sum(_is_known(heading.text) for heading in headings))

    sheet = read_sheet(source, "a table of gains", known_keys, _KEYS)
    keys = [heading.text for heading in sheet.headings]
    for key in keys:
        if not _is_known(key):
            raise sheet.error(
                f"{GAIN_COLUMNS.unknown(key)}; numbers of filters are {COLUMN_PREFIX}N.KEY or"
                f" {COLUMN_PREFIX}MODE.KEY, as filter.1.frequency_rad_per_s"
            )
        if keys.count(key) > 1:
            raise sheet.error(f"every column needs a key of its own; got {shown(key)}")
    rows: list[dict[str, float]] = []
    for position, cells in zip(sheet.places, sheet.cells, strict=True):
        with naming(position):
            numbers = {k: cell_number(k, cell) for k, cell in zip(keys, cells, strict=True)}
            of_filters = {k: numbers.pop(k) for k in keys if k.startswith(COLUMN_PREFIX)}
            rows.append(GAIN_COLUMNS.read(numbers) | of_filters)
    with naming(sheet.text.source):
        variables = [name for name in rows[0] if name in _VARIABLES] if rows else []
        if len(variables) != 1:
            raise InputError(
                "a table of gains needs one column of time_s, speed_m_per_s, altitude_m, mach or"
                f" dynamic_pressure_Pa; got {', '.join(variables) or 'none'}"
            )
        (variable,) = variables
        columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        points = columns.pop(variable)
        if points.size < 2 or np.any(np.diff(points) <= 0.0):
            raise InputError(f"{variable} must have two or more values, which rise")
        if not _REQUIRED_GAINS <= columns.keys():
            raise InputError("a table of gains needs attitude_gain and rate_gain_s, both")
    gains = {name: columns.pop(name) for name in GAINS if name in columns}
    return GainTable(variable, points, gains), columns


def _is_known(column: str) -> bool:
    """Return whether a column of this name in a table of gains is read.

    It is a variable of the flight, a gain, or a number of a filter, "filter.N.KEY".
    """
    return column in GAIN_COLUMNS.keys or column.startswith(COLUMN_PREFIX)
