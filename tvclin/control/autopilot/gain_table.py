"""Gains over the flight in a file, and notches that follow a bending mode."""

from __future__ import annotations

from dataclasses import dataclass, field
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Record
from tvclin.base.errors import InputError, naming, number, positive, text
from tvclin.base.fields import spec
from tvclin.base.sheet import Headings, cell_number, read_sheet
from tvclin.base.tables import FileTable
from tvclin.control.autopilot.feedback import GAINS
from tvclin.vehicle.filters import Filter

_VARIABLES = {
    "time": "time",
    "speed": "speed",
    "altitude": "length",
    "mach": "number",
    "dynamic_pressure": "pressure",
}
"""Variables of the flight with their kinds of units."""
GAIN_COLUMNS = FileTable("a table of gains", _VARIABLES | GAINS)
"""Columns of a table of gains: one variable of the flight, and gains."""


@dataclass(frozen=True, kw_only=True)
class ModeNotch(Record):
    """Notch behind the sum of all feedbacks, at the frequency of a bending mode at each time.

    Parameters
    ----------
    mode : str
        Name of the mode in the structure of the flight.
    zero_damping, pole_damping : float
        As in `Filter.notch`.
    ratio : float
        Frequency of the notch over the mode's, positive.

    Raises
    ------
    InputError
        For numbers out of range.
    """

    mode: str = field(metadata=spec())
    zero_damping: float = field(metadata=spec())
    pole_damping: float = field(metadata=spec())
    ratio: float = field(default=1.0, metadata=spec())

    def __post_init__(self) -> None:
        text("mode", self.mode)
        object.__setattr__(self, "zero_damping", number("zero_damping", self.zero_damping))
        for name in ("pole_damping", "ratio"):
            object.__setattr__(self, name, number(name, getattr(self, name), positive))

    def at(self, flight: Any, time: ArrayLike) -> Filter:
        """Return the notch at times [s] of a `FlightSchedule`.

        Raises
        ------
        InputError
            For a flight whose structure has no mode of this name.
        """
        structure: Any = getattr(flight, "structure", None)
        if not hasattr(structure, "mode_number"):
            raise InputError(f"a notch at {self.mode} needs a flight with a structure over time")
        mode = structure.at(time).bending[structure.mode_number(self.mode)]
        frequency = self.ratio * np.asarray(mode.frequency)
        return Filter.notch(frequency, self.zero_damping, self.pole_damping)


@dataclass(frozen=True, eq=False)
class GainTable:
    """Part of an autopilot's specification that varies over the flight.

    `breakpoints`: rising values ``(n,)`` of `variable` in SI units. `gains`: gains by name,
    ``(n,)``; without gains the specification's, constant or by a rule, count. `notches`:
    notches that follow a mode.
    """

    variable: str = "time"
    breakpoints: FloatArray = field(default_factory=lambda: np.zeros(0))
    gains: dict[str, FloatArray] = field(default_factory=dict)
    notches: tuple[ModeNotch, ...] = ()


def load_gains(source: str | PathLike[str]) -> GainTable:
    """Return the gains over a variable of the flight in a CSV table.

    Parameters
    ----------
    source : str or path
        A table with one column of time_s, speed_m_per_s, altitude_m, mach or dynamic_pressure_Pa,
        rising, and columns with the keys of the gains in [autopilot]: attitude_gain, rate_gain_s...

    Raises
    ------
    InputError
        For a cell that is no number, no or several columns of variables, values that do not rise,
        and a table without both attitude_gain and rate_gain.
    """
    sheet = read_sheet(source, "a table of gains", _known_keys, "keys such as mach,attitude_gain")
    keys = [heading.text for heading in sheet.headings]
    rows: list[dict[str, Any]] = []
    for position, cells in zip(sheet.places, sheet.cells, strict=True):
        with naming(position):
            rows.append(
                GAIN_COLUMNS.read(
                    {k: cell_number(k, cell) for k, cell in zip(keys, cells, strict=True)}
                )
            )
    with naming(sheet.text.source):
        variables = [name for name in rows[0] if name in _VARIABLES] if rows else []
        if len(variables) != 1:
            raise InputError(
                "a table of gains needs one column of time_s, speed_m_per_s, altitude_m, mach or"
                f" dynamic_pressure_Pa; got {', '.join(variables) or 'none'}"
            )
        columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        points = columns.pop(variables[0])
        if points.size < 2 or np.any(np.diff(points) <= 0.0):
            raise InputError(f"{variables[0]} must have two or more values, which rise")
        if not {"attitude_gain", "rate_gain"} <= columns.keys():
            raise InputError("a table of gains needs attitude_gain and rate_gain_s, both")
    return GainTable(variables[0], points, columns)


def _known_keys(headings: Headings) -> float:
    """Return the number of known columns in a line of names."""
    return float(sum(heading.text in GAIN_COLUMNS.keys for heading in headings))
