"""Structure of a vehicle over its flight: bending modes and tanks by the rows of a table."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray, IndexArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, each, finite, instance, naming, one_of, shown, text
from tvclin.base.fields import spec
from tvclin.base.lines import listed
from tvclin.base.sheet import Headings, Sheet, cell_number, read_sheet
from tvclin.vehicle.filters import Filter
from tvclin.vehicle.structure import BendingMode, SloshTank, Structure
from tvclin.vehicle.vehicle_file import BENDING_TABLE, SLOSH_TABLE, bending_mode

_TABLES = {"modal_mass": BENDING_TABLE, "mass": SLOSH_TABLE}
"""Tables of vehicle files whose keys a row has, by the number that only their rows have."""
_KEYS = {*BENDING_TABLE.every_key, *SLOSH_TABLE.every_key}
_SHAPE = (
    "gimbal_displacement",
    "gimbal_slope",
    "attitude_slope",
    "rate_slope",
    "pressure_displacement",
)
"""Numbers of a bending mode that change their sign with its normalisation."""


@dataclass(frozen=True, eq=False)
class StructureSchedule(Shown):
    """Bending modes and tanks at several times of a flight, straight lines between them.

    Parameters
    ----------
    times : array_like
        Times of flight [s], rising, ``(n,)``, two or more.
    structure : Structure
        Structure at the times, a batch ``(n,)``; engine and sensors may be constant.
    modes, tanks : tuple of str
        Name of each bending mode and of each tank, in the order of the structure.
    notes : tuple of str
        Changes of the data on reading.

    Raises
    ------
    InputError
        For times that do not rise, a structure of another shape, lags of sensors that vary, and
        names that are repeated or not one for each mode and tank.
    """

    times: FloatArray
    structure: Structure = field(metadata=spec(of="structure.parts"))
    modes: tuple[str, ...] = field(default=(), metadata=spec())
    tanks: tuple[str, ...] = field(default=(), metadata=spec())
    notes: tuple[str, ...] = field(default=(), metadata=spec())

    def __post_init__(self) -> None:
        """Check the fields, and set them; `InputError` as the class says."""
        times = finite("times", self.times, "s")
        if times.ndim != 1 or times.size < 2 or np.any(np.diff(times) <= 0.0):
            raise InputError("times must be two or more rising times of flight in s")
        object.__setattr__(self, "times", times)
        instance("structure", self.structure, Structure, "Structure(bending=..., slosh=...)")
        if self.structure.batch not in {(), times.shape}:
            raise InputError(
                f"structure must have one number or one for each of the {times.size} times; got a"
                f" batch of shape {self.structure.batch}"
            )
        lags = (self.structure.attitude_sensor, self.structure.rate_gyro)
        if any(lag is not None and lag.batch for lag in lags):
            raise InputError("the lags of the sensors must be the same over the flight")
        names = {"modes": self.structure.bending, "tanks": self.structure.slosh}
        for name, elements in names.items():
            mode_names = each(name, getattr(self, name), str, "a name for each")
            mode_names = tuple(text(name, label) for label in mode_names)
            if len(mode_names) != len(elements) or len(set(mode_names)) < len(mode_names):
                raise InputError(
                    f"{name} must be {len(elements)} different names, as the structure has; got"
                    f" {shown(mode_names)}"
                )
            object.__setattr__(self, name, mode_names)
        object.__setattr__(self, "notes", each("notes", self.notes, str, "one for each remark"))

    @property
    def span(self) -> tuple[float, float]:
        """The first and the last time [s]."""
        return float(self.times[0]), float(self.times[-1])

    def at(self, time: ArrayLike) -> Structure:
        """Return the structure at any times [s], of their shape, constant outside the table."""
        return structures_at([self], finite("time", time, "s"))

    def mode_number(self, name: str) -> int:
        """Return the index of a bending mode in the structure by its name.

        `InputError` for a name that no mode has.
        """
        return self.modes.index(one_of("mode", name, self.modes))


def load_structure(
    source: str | PathLike[str], common: Structure | None = None
) -> StructureSchedule:
    """Return the structure over a flight from a CSV table.

    Parameters
    ----------
    source : str or path
        A table with the columns time_s and name, and columns with the keys of [[bending]] and
        [[slosh]] of vehicle files; a row for each mode and each tank at each time. A row with a
        modal mass is a mode, one with a mass a tank; columns of the other kind stay empty.
        Displacements and slopes at several tanks stand in one cell, with blanks between.
    common : Structure, optional
        Engine, lags of the sensors, and `thrust_follows`, which do not change.

    Raises
    ------
    InputError
        As `load_vehicle`, naming the line; for a mode or a tank without a row at a time that others
        have, and for two rows of one name at one time.

    Notes
    -----
    Rows belong to each other by their name alone, whatever the order of the frequencies. A mode
    and its negative are the same mode: where displacements and slopes have changed their sign
    against the row before, they are turned, and a note says so.
    """
    sheet = read_sheet(source, "a table of modes", _key_count, "keys such as time_s,name,damping")
    for needed in ("time_s", "name"):
        if needed not in [heading.text for heading in sheet.headings]:
            raise sheet.error(f"a table of modes needs the column {needed}")
    rows, times = _rows_by_name(sheet)
    series = {name: [of_name[time] for time in times] for name, of_name in rows.items()}
    notes = []
    for name, elements in series.items():
        sign_changes = _align_signs(elements)
        if sign_changes:
            at = listed([f"{times[k]:g}" for k in sign_changes])
            notes.append(f"{name}: the sign of its displacements and slopes is reversed at {at} s")
    common = Structure() if common is None else common
    instance("common", common, Structure, "Structure(engine=..., rate_gyro=...)")
    kinds = {
        kind: {name: s for name, s in series.items() if isinstance(s[0], kind)}
        for kind in (BendingMode, SloshTank)
    }
    bending, slosh = (
        tuple(_stacked(name, s) for name, s in of_kind.items()) for of_kind in kinds.values()
    )
    with naming(sheet.text.source):
        return StructureSchedule(
            times=np.array(times),
            structure=replace(common, bending=bending, slosh=slosh),
            modes=tuple(kinds[BendingMode]),
            tanks=tuple(kinds[SloshTank]),
            notes=tuple(notes),
        )


def _rows_by_name(
    sheet: Sheet,
) -> tuple[dict[str, dict[float, BendingMode | SloshTank]], list[float]]:
    """Return the modes and tanks of a table by name and time [s], and all times [s], rising.

    `sheet`: the table, with a row for each mode and tank at each time.
    """
    rows: dict[str, dict[float, BendingMode | SloshTank]] = {}
    for position, cells in zip(sheet.places, sheet.cells, strict=True):
        with naming(position):
            time, name, element = _row(sheet, cells)
            of_name = rows.setdefault(name, {})
            if time in of_name:
                raise InputError(f"{name} has two rows at {time:g} s; keep one")
            if any(type(earlier) is not type(element) for earlier in of_name.values()):
                raise InputError(f"{name} is a mode in one row and a tank in another")
            of_name[time] = element
    times = sorted({time for of_name in rows.values() for time in of_name})
    for name, of_name in rows.items():
        missing = [f"{time:g}" for time in times if time not in of_name]
        if missing:
            raise InputError(
                f"{sheet.text.source}: {name} has no row at {listed(missing)} s, where others have"
                " one"
            )
    if len(times) < 2:
        raise InputError(f"{sheet.text.source} must hold two or more times; got {len(times)}")
    return rows, times


def _key_count(headings: Headings) -> float:
    """Return how well a line of headings fits: the number of columns of a table of modes."""
    return float(sum(heading.text in {"time_s", "name", *_KEYS} for heading in headings))


def _row(sheet: Sheet, cells: tuple[str, ...]) -> tuple[float, str, BendingMode | SloshTank]:
    """Return time [s], name and mode or tank of a row of a table.

    `sheet`: the table, with its headings. `cells`: texts of the row.
    """
    row: dict[str, Any] = {
        heading.text: cell for heading, cell in zip(sheet.headings, cells, strict=True) if cell
    }
    for key in ("time_s", "name"):
        if key not in row:
            raise InputError(f"{key} is missing")
    name = row.pop("name")
    lists = BENDING_TABLE.lists
    values: dict[str, Any] = {
        key: [cell_number(key, word) for word in cell.replace(";", " ").split()]
        if key in lists
        else cell_number(key, cell)
        for key, cell in row.items()
    }
    time = values.pop("time_s")
    # "modal_mass" of a mode or "mass" of a tank: those that the row has, by a key of any unit
    masses = [
        mass
        for mass, table in _TABLES.items()
        if any(key in table.keys and table.keys[key][0] == mass for key in values)  # [0]: its field
    ]
    if len(masses) != 1:
        raise InputError(
            f"{name} must have a modal mass, as a mode has, or a mass, as a tank has, and not both"
        )
    numbers: Mapping[str, Any] = _TABLES[masses[0]].read(values)  # arguments in SI units
    return time, name, (bending_mode if masses == ["modal_mass"] else SloshTank)(**numbers)


def _shape_of(mode: BendingMode) -> FloatArray:
    """Return all displacements and slopes of a mode, of the structure and at tanks, ``(k,)``."""
    numbers = [getattr(mode, name) for name in _SHAPE]
    return np.array([*numbers, *mode.tank_displacements, *mode.tank_slopes], float)


def _align_signs(elements: list[Any]) -> list[int]:
    """Change signs of a mode at several times where needed; return the indices of these times.

    `elements`: the mode, or a tank, at each time, in which changed modes are replaced. A shape
    whose product with the shape before is negative changes its sign, each number weighted with its
    largest size over the flight.
    """
    if not isinstance(elements[0], BendingMode):
        return []
    shapes = [_shape_of(mode) for mode in elements]
    if len({shape.size for shape in shapes}) > 1:
        raise InputError("a mode must have displacements at the same tanks at all times")
    size = np.abs(shapes).max(axis=0)  # largest size of each number over the flight
    size[size == 0.0] = 1.0
    reversed_rows = []
    for k in range(1, len(elements)):
        if np.sum(_shape_of(elements[k - 1]) * shapes[k] / size**2) < 0.0:
            mode = elements[k]
            # a mode with all displacements and slopes negative is the same mode
            changes: dict[str, Any] = {name: -getattr(mode, name) for name in _SHAPE}
            for name in ("tank_displacements", "tank_slopes"):
                changes[name] = tuple(-value for value in getattr(mode, name))
            elements[k] = replace(mode, **changes)
            reversed_rows.append(k)
    return reversed_rows


def _stacked(name: str, elements: list[Any]) -> Any:
    """Return modes, or tanks, of one name at n times as a batch ``(n,)``.

    `elements`: one `BendingMode` or `SloshTank` for each time.
    """
    kind = type(elements[0])
    values: dict[str, Any] = {}
    for item in fields(kind):
        column = [getattr(element, item.name) for element in elements]
        if any(value is None for value in column):
            if any(value is not None for value in column):
                raise InputError(f"{name} must have {item.name} at all times, or at none")
            values[item.name] = None
        elif isinstance(column[0], tuple):
            values[item.name] = tuple(np.array(row) for row in zip(*column, strict=True))
        else:
            values[item.name] = np.array(column)
    return kind(**values)


def structures_at(
    schedules: Sequence[StructureSchedule], time: FloatArray, which: IndexArray | int = 0
) -> Structure:
    """Return structures at any times [s] of schedules with equal times, constant outside them.

    `time`: times, ``(...)``. `which`: index of the schedule of each, ``(...)``.
    """
    read = table_reader(schedules[0].times, time, which)
    structure: Structure = _interpolated([schedule.structure for schedule in schedules], read)
    return structure


ReadColumn = Callable[[Sequence[Any]], Any]
"""Function from one column in each of several tables to its values at the times that are read."""


def table_reader(times: FloatArray, at: FloatArray, table: IndexArray | int) -> ReadColumn:
    """Return a function that reads tables with rows at common times by straight lines.

    Before the first and after the last row the value is constant. `times`: of the rows [s], rising,
    ``(n,)``. `at`: times [s] at which the tables are read, ``(...)``. `table`: index of the table
    that is read at each, ``(...)`` or one for all. The function takes one column in each table,
    ``(n,)`` or a number, and returns values ``(...)``, or a number that all tables share.
    """
    before = np.maximum(np.searchsorted(times, at, side="right") - 1, 0)  # row before each time
    # the time since that row, zero before the first; behind the last the slope is zero
    since = np.maximum(at - times[before], 0.0)

    def read(columns: Sequence[Any]) -> Any:
        """Return the values ``(...)`` of one column of the tables."""
        alike = all(column is columns[0] for column in columns)
        if alike and np.ndim(columns[0]) == 0:
            return columns[0]
        if all(np.ndim(column) == 0 for column in columns):
            return np.array(columns)[table]
        index, columns = (0, columns[:1]) if alike else (table, columns)
        values = np.stack([np.broadcast_to(column, times.shape) for column in columns])
        slopes = np.zeros_like(values)
        slopes[:, :-1] = np.diff(values) / np.diff(times)
        return slopes[index, before] * since + values[index, before]

    return read


def _interpolated(values: Sequence[Any], read: ReadColumn) -> Any:
    """Return a record, tuple, array or number of several schedules, interpolated in time.

    Records and tuples are interpolated field by field; filters, texts and None do not change over
    the flight, and are those of the first schedule. `values`: one for each schedule, all of one
    type. `read`: function that reads one column of them.
    """
    first = values[0]
    if isinstance(first, tuple):
        return tuple(_interpolated(elements, read) for elements in zip(*values, strict=True))
    if is_dataclass(first) and not isinstance(first, Filter):
        numbers = {
            item.name: _interpolated([getattr(value, item.name) for value in values], read)
            for item in fields(first)
        }
        kind: Any = type(first)
        return kind(**numbers)
    return read(values) if isinstance(first, np.ndarray | float) else first
