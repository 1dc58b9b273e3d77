"""Schedules from files: a row for each time, with the keys of vehicle files."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from tvclin.ascent.atmosphere import pressure_notes
from tvclin.ascent.nominal_flight import FLIGHT_TABLE, load_flight_condition, time_of
from tvclin.ascent.schedule import FlightSchedule
from tvclin.ascent.structure_schedule import load_structure
from tvclin.base.errors import InputError, naming, number, path, shown
from tvclin.base.files import called, exists, tables_of
from tvclin.base.package_warnings import ImplausibleInput
from tvclin.base.sheet import MISSING_NUMBERS, Headings, cell_number, lines_of, sheet_in
from tvclin.base.tables import FileTable
from tvclin.base.units import factor_of
from tvclin.vehicle import vehicle_file
from tvclin.vehicle.linear_vehicle import AnyVehicle, load_any_vehicle
from tvclin.vehicle.structure import Structure
from tvclin.vehicle.vehicle import NUMBERS, Vehicle

_BEFORE, _AFTER = 25.0, 50.0
"""Nominal flight before and after the time of a vehicle [s], where no span is given."""
FLIGHT_COLUMNS = FileTable(
    "[schedule]",
    {
        "nominal_deflection": "angle",
        "altitude": "altitude",
        "actuator_frequency": "natural frequency",
        "actuator_damping": "number",
    },
)
"""Columns of a flight schedule beside the keys of [vehicle]."""
_WORDS = ("name", "structure")
"""Columns of text: names of the vehicle and of the table of its structure."""
_COLUMNS = replace(
    vehicle_file.VEHICLE_TABLE,
    heading="the schedule",
    quantities=vehicle_file.VEHICLE_TABLE.quantities | FLIGHT_COLUMNS.quantities,
    words=("structure", *vehicle_file.VEHICLE_TABLE.words),
    required=("time",),
)
"""Columns of a flight schedule."""
_REQUIRED = (
    "time_s,weight_N,moment_of_inertia_kg_m2,thrust_N,aerodynamic_arm_m,control_arm_m,"
    "velocity_m_per_s,attitude_deg,normal_force_slope_N_per_rad,axial_force_N"
)
"""Line of the columns that a schedule must have."""
_CONVERSION = (
    "tvclin import table FILE --columns MAP.toml -o NEW.csv converts other names and units"
)
"""What makes a schedule of a table with other headings."""
_PRESSURE_NUMBERS = ("time", "dynamic_pressure", "velocity", "altitude")
"""Parameters of `pressure_notes`."""
SOURCE_TABLE = FileTable("[schedule]", words=("source", "structure"))
"""A [schedule] that names the flight, and the table of its structure, in place of its lists."""


def load_schedule(
    source: str | PathLike[str],
    *,
    start: float | None = None,
    stop: float | None = None,
    step: float = 0.5,
) -> FlightSchedule:
    """Return a flight schedule from a file, or along the nominal flight of a vehicle.

    Parameters
    ----------
    source : str or path
        A CSV file: one line of the keys of vehicle files, `time_s` among them, or of their names
        with the unit in brackets, ``Time (s)``, then a line for each time; a constant may stand in
        the first line only. A TOML file with a table
        [schedule]: lists of one length, and numbers that do not change. Or a vehicle with a table
        [flight], by name or file: its nominal flight. Tables may hold nominal_deflection_deg,
        altitude_m, actuator_frequency_rad_per_s with actuator_damping, and as `structure` the name
        of the table of modes and tanks, see `load_structure`; a TOML file then also [structure],
        [engine] and [sensors], as vehicle files have them.
    start, stop : float, optional
        Span [s] of the nominal flight; from 25 s before the vehicle's time to 50 s after it where
        not given. A table has its own.
    step : float
        Time [s] between rows of the nominal flight.

    Raises
    ------
    InputError
        As `load_vehicle` and `FlightSchedule`, naming the line or row of a table that is wrong.

    Examples
    --------
    >>> import tvclin as tv
    >>> tv.load_schedule("configuration-i").span
    (41.0, 116.0)
    """
    path("source", source, "a name or a path")
    if vehicle_file.is_csv(source) and not exists(source):
        raise InputError(f"{called(source)} does not exist; name a flight schedule, or a vehicle")
    text, name = vehicle_file.read_vehicle_text(source)
    folder = Path(name).parent
    if vehicle_file.is_csv(name):
        return _from_rows(_csv_rows(text, name), name, folder, Structure())
    document, source_name = tables_of(text, name), called(name)
    table = document.get("schedule")
    if table is not None:
        others = document.keys() - vehicle_file.SCHEDULE_HEADINGS
        if others:
            raise InputError(
                f"{source_name}: a schedule has nothing beside [schedule], [structure], [engine]"
                f" and [sensors]; got {shown(min(others))}"
            )
        if not isinstance(table, dict):
            raise InputError(
                f"{source_name}: schedule must be a table [schedule]; got {shown(table)}"
            )
        return schedule_of(table, name, folder, vehicle_file.build_structure(document))
    vehicle, condition = vehicle_file.parse_vehicle(text, name), load_flight_condition(source)
    reference = time_of(vehicle)
    first = reference - _BEFORE if start is None else start
    last = reference + _AFTER if stop is None else stop
    return FlightSchedule.from_flight(vehicle, condition, start=first, stop=last, step=step)


def load_vehicle_at(source: str | PathLike[str], time: float | None = None) -> AnyVehicle:
    """Return the vehicle of a name, a file, or a flight schedule at a time of flight [s].

    `source`: without a time the name of a vehicle or its file; with a time a flight schedule, or a
    vehicle with a table [flight], by name or file. `InputError` for a schedule without a time, a
    time outside the flight, a vehicle that bends at another time than its own, and as
    `load_any_vehicle` and `load_schedule`.
    """
    if time is None:
        return load_any_vehicle(source)
    structure_tables = {"bending", "slosh", "engine", "sensors", "structure"}
    if (
        not vehicle_file.is_schedule(source)
        and vehicle_file.source_tables(source).keys() & structure_tables
    ):
        raise InputError(
            f"{called(source)} has a structure, which is known at the vehicle's own time alone:"
            f" leave out the time of flight; got {time:g} s"
        )
    flight = load_schedule(source)
    vehicle = flight.at(number("time", time, unit="s"))
    return vehicle.replace(numbers_from=f"{called(source)} at {time:g} s")


def schedule_of(
    table: dict[str, Any], source: str, folder: Path, common: Structure | None = None
) -> FlightSchedule:
    """Return the schedule of a table [schedule] of a TOML file: lists by the keys of vehicle files.

    `source`: name of the file. `folder`: folder of the table of its structure. `common`: engine and
    sensors of the structure, which do not change over the flight.
    """
    name, times = called(source), table.get("time_s")
    if not isinstance(times, list):
        raise InputError(f"{name}: [schedule] needs time_s, a list of times in s")
    for key, values in table.items():
        if isinstance(values, list) and len(values) != len(times):
            raise InputError(
                f"{name}: {key} must have a value for each of the {len(times)} times, or be one"
                f" number; got {len(values)}"
            )
    with naming(name):
        vehicle_file.check_columns(table.keys(), _COLUMNS)
    rows = _rows(table, [f"row {i + 1}" for i in range(len(times))])
    return _from_rows(rows, source, folder, common)


def with_structure(
    schedule: FlightSchedule, name: Any, folder: Path, common: Structure | None = None
) -> FlightSchedule:
    """Return the schedule with the structure of a table of modes, a CSV file in `folder`.

    `name`: name of this file. `common`: engine and sensors of the structure.
    """
    if not isinstance(name, str) or not name.isprintable():
        raise InputError(f"structure must be the path of a table of modes; got {shown(name)}")
    structure = load_structure(folder / name, common)
    return replace(schedule, structure=structure, notes=(*schedule.notes, *structure.notes))


Row = tuple[str, dict[str, Any]]
"""Label of a row in messages, and its values by key."""


def _from_rows(
    rows: list[Row], source: str, folder: Path, common: Structure | None
) -> FlightSchedule:
    """Return the schedule of rows of keys and values; `InputError` for fewer than two times.

    `source`: file of the rows. `folder`: folder of the table of the structure. `common`: engine and
    sensors of the structure.
    """
    source = called(source)
    # names of tables, each once; removed from the rows
    structures = {str(row.pop("structure")): None for _, row in rows if "structure" in row}
    if len(structures) > 1:
        raise InputError(f"{source}: structure must be one table; got {', '.join(structures)}")
    if common is not None and not common.is_rigid and not structures:
        raise InputError(f"{source}: [engine] and [sensors] need the table structure of the modes")
    rows, notes = _moving(rows)  # without the rows at rest before the flight
    if values := _numbers_of(rows, *_PRESSURE_NUMBERS):
        columns = (np.array([v[name] for v in values]) for name in _PRESSURE_NUMBERS)
        notes = (*notes, *pressure_notes(*columns))
    if len(rows) < 2:
        raise InputError(f"{source} must hold two or more times; got {len(rows)}")
    vehicles, others = [], []
    for label, row in _with_inertia_rates(rows):
        with naming(f"{source}, {label}"):
            # altitude, nominal deflection and actuator; the other keys are those of a vehicle
            keys = [key for key in FLIGHT_COLUMNS.keys if key in row]
            others.append(FLIGHT_COLUMNS.read({key: row.pop(key) for key in keys}))
            vehicles.append(vehicle_file.build_vehicle(row, _COLUMNS.heading))
            if vehicles[-1].time is None:
                raise InputError("a key is missing: time_s")
    times = [float(np.asarray(v.time)) for v in vehicles]
    for (label, _), (before, now) in zip(rows[1:], pairwise(times), strict=True):
        if now <= before:
            raise InputError(f"{source}, {label}: time_s must rise; got {now:g} after {before:g}")
    first = vehicles[0]
    names = [name for name in NUMBERS if getattr(first, name) is not None]
    numbers: dict[str, Any] = {name: [getattr(v, name) for v in vehicles] for name in names}
    of_flight: dict[str, Any] = {key: [values.get(key) for values in others] for key in others[0]}
    with naming(source):
        schedule = FlightSchedule(Vehicle(name=first.name, **numbers), notes=notes, **of_flight)
        for name in structures:
            schedule = with_structure(schedule, name, folder, common)
    return schedule


def _moving(rows: list[Row]) -> tuple[list[Row], tuple[str, ...]]:
    """Return the rows without those at rest before the flight, and a note on these.

    All rows, without a note, if the first moves or none does.
    """
    # keys of the velocity, each with its unit
    keys = [key for key, (name, _) in vehicle_file.VEHICLE_TABLE.keys.items() if name == "velocity"]
    at_rest = 0  # number of the first rows with the velocity zero
    for label, values in rows:
        if not any(values.get(key) == 0.0 for key in keys):
            break
        at_rest, last_label = at_rest + 1, label
    if not at_rest or at_rest == len(rows):
        return rows, ()
    note = f"the vehicle does not move before {last_label}, after which it begins"
    return rows[at_rest:], (note,)


def _numbers_of(rows: list[Row], *names: str) -> list[dict[str, float]]:
    """Return the numbers of rows in SI units by name; empty where one of `names` is missing."""
    keys = _COLUMNS.keys  # name and factor to SI by key
    numbers = []
    for _label, row in rows:
        values = {key: value for key, value in row.items() if key in keys}
        if not all(isinstance(value, float | int) for value in values.values()):
            return []
        by_name = {}
        for key, value in values.items():
            name, factor = keys[key]
            by_name[name] = value * factor
        if not set(names) <= by_name.keys():
            return []
        numbers.append(by_name)
    return numbers


def pressure_warnings(source: str | PathLike[str]) -> Iterator[ImplausibleInput]:
    """Yield a warning on a dynamic pressure of a file that contradicts its speed and altitude.

    `source`: name of a vehicle of the package, path of a vehicle file, whose altitude stands in
    [flight], or a flight schedule. Nothing is yielded without a pressure or an altitude.
    """
    if vehicle_file.is_schedule(source):
        notes = load_schedule(source).notes
        yield from (note for note in notes if isinstance(note, ImplausibleInput))
        return
    tables = vehicle_file.source_tables(source)
    if "vehicle" in tables and "flight" in tables:
        values = vehicle_file.VEHICLE_TABLE.one(tables), FLIGHT_TABLE.one(tables)
        numbers = vehicle_file.VEHICLE_TABLE.read(values[0]) | FLIGHT_TABLE.read(values[1])
        numbers.setdefault("time", np.nan)
        if {"dynamic_pressure", "altitude"} <= numbers.keys():
            yield from pressure_notes(*(np.array([numbers[name]]) for name in _PRESSURE_NUMBERS))


def _with_inertia_rates(rows: list[Row]) -> list[Row]:
    """Return rows with the rate of the inertia, by differences, where jet damping needs it.

    Rows without time or inertia, or with times that do not rise, are returned as they are.
    """
    values = _numbers_of(rows, "time", "moment_of_inertia")
    if not values or "jet_mass_flow" not in values[0] or "inertia_rate" in values[0]:
        return rows
    times, inertias = (
        np.array([v[name] for v in values]) for name in ("time", "moment_of_inertia")
    )
    if not np.all(np.diff(times) > 0.0):
        return rows
    # the key of the rate, with its unit
    (key,) = vehicle_file.VEHICLE_TABLE.write({"inertia_rate": 0.0})
    rates = np.gradient(inertias, times).tolist()
    return [(label, row | {key: rate}) for (label, row), rate in zip(rows, rates, strict=True)]


def _csv_rows(text: str, source: str) -> list[Row]:
    """Return the rows of a schedule in the text of a CSV file; `source`: its path, for errors."""
    missing = f"keys: {_REQUIRED}, or Time (s),... (tvclin init --keys has all; {_CONVERSION})"
    sheet = sheet_in(lines_of(text, source), _key_count, missing)
    keys = _keys_of(sheet.headings)
    for key in keys:
        if keys.count(key) > 1:
            raise sheet.error(f"every column needs a key of its own; got {shown(key)}")
    with naming(f"{called(source)}, line {sheet.head + 1}"):
        try:
            vehicle_file.check_columns(keys, _COLUMNS)
        except InputError as error:
            if set(keys) <= {*_COLUMNS.every_key}:
                raise
            raise InputError(f"{error}\n{_CONVERSION}") from None
    labels = [f"line {n}" for n in sheet.line]
    columns = zip(keys, zip(*sheet.cells, strict=True), strict=True)
    return _rows({k: _column(called(source), labels, k, c) for k, c in columns}, labels)


def _key_count(headings: Headings) -> float:
    """Return how well a line of headings fits: the number of keys, also without their units."""
    schedule_keys = {*_COLUMNS.every_key, *_COLUMNS.quantities}
    return float(sum(key.lower() in schedule_keys for key in _keys_of(headings)))


def _keys_of(headings: Headings) -> list[str]:
    """Return the keys of headings: ``weight_kN`` of ``weight_kN`` and of ``Weight [kN]``.

    A number without a unit needs none: ``axial_force_coefficient`` of ``Axial force coefficient``.
    A heading without a key, or with a unit that no key has, keeps its text.
    """
    kinds = _COLUMNS.quantities
    key_of = {quantity_and_factor: key for key, quantity_and_factor in _COLUMNS.keys.items()}
    keys = []
    for heading in headings:
        name, unit, factor = heading.quantity, heading.unit, None
        if name in kinds and (unit is not None or name in _COLUMNS.keys):
            factor = factor_of(unit or "", kinds[name])
        keys.append(heading.text if factor is None else key_of.get((name, factor), heading.text))
    return keys


def _column(source: str, labels: list[str], key: str, cells: tuple[str, ...]) -> Any:
    """Return the values of a column, or one value if its first line alone has it.

    `source`, `labels`: file, and label of each line, for errors. `key`: heading of the column.
    `cells`: its texts.
    """
    if key != "time_s" and cells[0] and not any(cells[1:]):
        return _cell(source, labels[0], key, cells[0])
    return [_cell(source, label, key, cell) for label, cell in zip(labels, cells, strict=True)]


def _cell(source: str, label: str, key: str, text: str) -> Any:
    """Return the value of a cell of a CSV file: a number, or a text.

    `source`, `label`: file and line, for errors. `key`: heading of the column. `text`: of the cell.
    """
    if text and key in _WORDS:
        return text
    with naming(f"{source}, {label}"):
        value = cell_number(key, text) if text else MISSING_NUMBERS[0]
        if value in MISSING_NUMBERS:
            raise InputError(f"{key} is missing; give it in every line, or in the first only")
    return value


def _rows(table: dict[str, Any], labels: list[str]) -> list[Row]:
    """Return the rows of a table of columns by key; a single value counts in every row.

    `labels`: label of each row in errors.
    """
    return [
        (label, {key: v[i] if isinstance(v, list) else v for key, v in table.items()})
        for i, label in enumerate(labels)
    ]
