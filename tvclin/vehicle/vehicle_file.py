"""Vehicle files: TOML with the table [vehicle], every key carrying its unit, and a structure.

[vehicle] holds the numbers of `Vehicle`; [structure], [engine], [sensors] and one [[bending]] and
[[slosh]] for each mode and tank hold its `Structure`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from importlib.resources import files
from os import PathLike, fspath
from typing import Any

import numpy as np

from tvclin.base.errors import Faults, InputError, naming, number, one_of, shown
from tvclin.base.errors import path as a_path
from tvclin.base.fields import file_table, parameters
from tvclin.base.files import ENCODINGS, UTF_8, EditedSource, called, exists, read_text, tables_of
from tvclin.base.tables import FileTable
from tvclin.base.units import UNITS
from tvclin.vehicle.filters import Filter
from tvclin.vehicle.structure import BendingMode, Engine, SloshTank, Structure
from tvclin.vehicle.vehicle import (
    AIR_FORCES,
    NUMBERS,
    STANDARD_GRAVITY,
    Vehicle,
    aerodynamic_damping,
    jet_damping,
)

_OPTIONAL = ("time", "control_force_slope", "pitch_damping")
_REQUIRED = tuple(name for name in NUMBERS if name not in (*AIR_FORCES, *_OPTIONAL))
_AERODYNAMICS = {
    "dynamic_pressure": "pressure",
    "reference_area": "area",
    "normal_force_coefficient_slope": "per angle",
    "axial_force_coefficient": "number",
}
DAMPING_QUANTITIES = {
    "pitch_damping_coefficient": "damping coefficient",
    "reference_length": "length",
    "jet_mass_flow": "mass flow",
    "inertia_rate": "inertia rate",
    "exit_arm": "length",
}
"""Sources of the damping in vehicle files, with their kinds; a coefficient is per q L/V."""

VEHICLE_TABLE = FileTable(
    "[vehicle]",
    {name: item.kind for name, item in parameters(Vehicle).items()}
    | _AERODYNAMICS
    | DAMPING_QUANTITIES
    | {"mass": "mass"},
    words=("name", "numbers_from"),
)
COEFFICIENTS = "coefficients"
"""Table of files of a `LinearVehicle`, see `load_any_vehicle`."""
SCHEDULE_HEADINGS = {"schedule", "structure", "engine", "sensors"}
"""Tables of a flight schedule in TOML; all but [schedule] are optional."""
HEADINGS = ("vehicle", "flight", "structure", "engine", "sensors", "bending", "slosh")
"""Tables of a vehicle file; [flight] belongs to `FlightCondition`."""
_SENSORS = ("attitude_sensor", "rate_gyro")
_TANK_SLOPES = {f"tank_slopes_{unit}": factor for unit, factor in UNITS["per length"].items()}

STRUCTURE_TABLE = FileTable("[structure]", words=("thrust_follows",))
ENGINE_TABLE = file_table("[engine]", Engine, required=("mass", "arm"))
SENSORS_TABLE = FileTable(
    "[sensors]",
    {f"{name}_frequency": "natural frequency" for name in _SENSORS}
    | {f"{name}_damping": "number" for name in _SENSORS},
)
BENDING_TABLE = file_table(
    "[[bending]]",
    BendingMode,
    lists=("tank_displacements", *_TANK_SLOPES),
    required=tuple(name for name, item in parameters(BendingMode).items() if item.default is None),
)
SLOSH_TABLE = file_table("[[slosh]]", SloshTank, required=("mass", "station", "damping"))


def list_vehicles() -> list[str]:
    """Return the names of the vehicles in the package."""
    entries = (entry.name for entry in files("tvclin.vehicle").joinpath("shipped").iterdir())
    return sorted(name.removesuffix(".toml") for name in entries if name.endswith(".toml"))


def load_vehicle(source: str | PathLike[str]) -> Vehicle:
    """Return a vehicle by its name in the package, or from a TOML file.

    The structure follows [vehicle] in tables of its own: [structure], [engine], [sensors], and one
    [[bending]] and [[slosh]] for each mode and tank. All are optional.

    Parameters
    ----------
    source : str or path
        One of `list_vehicles`, or the path of a file (anything that ends in .toml, holds a
        path separator, or exists).

    Raises
    ------
    InputError
        For an unknown name (similar names are listed) and for a file that cannot be read, is
        not TOML, lacks a key, has an unknown key, or holds a value that is not a number. One
        sentence says which and how to correct it.

    Examples
    --------
    >>> import tvclin as tv
    >>> tv.load_vehicle("configuration-i").weight
    1480000.0
    >>> structure = tv.load_vehicle("made-up-booster").structure
    >>> [mode.frequency for mode in structure.bending], len(structure.slosh)
    ([13.58, 30.18, 61.18], 2)
    """
    return parse_vehicle(*read_vehicle_text(source))


def read_vehicle_text(source: str | PathLike[str]) -> tuple[str, str]:
    """Return the text of a vehicle file, and its name for messages.

    `source`: name of a vehicle of the package (`list_vehicles`), or path of a TOML or CSV file.
    """
    path, text = a_path("vehicle", source, "a name or a path"), fspath(source)
    if text in list_vehicles():
        resource = files("tvclin.vehicle").joinpath("shipped", f"{text}.toml")
        return resource.read_text(encoding="utf-8"), text
    looks_like_a_path = isinstance(source, PathLike) or path.suffix or path.name != text
    if not looks_like_a_path and not exists(path):
        one_of("vehicle (or the path of a vehicle file)", text, list_vehicles())  # raises
    name = called(path)
    hint = f"write one with: tvclin init {name}, or a study file with: tvclin init --study {name}"
    if is_csv(path):
        hint = "tvclin init --keys lists the columns of a flight schedule"
    encodings = ENCODINGS if is_csv(path) else UTF_8
    return read_text(path, "a vehicle file", hint, encodings), text


def source_tables(source: str | PathLike[str]) -> dict[str, Any]:
    """Return the tables of the vehicle or study file `source` by heading; empty for CSV."""
    return {} if is_csv(source) else tables_of(*read_vehicle_text(source))


def is_csv(source: str | PathLike[str]) -> bool:
    """Return whether a source is a flight schedule in CSV: by its ending, or edited tables."""
    name = str(a_path("source", source, "a name or a path")).lower()
    # an `EditedSource` has `tables` that replace the content of its file, then it is no CSV
    return name.endswith(".csv") and getattr(source, "tables", None) is None


def is_schedule(source: str | PathLike[str]) -> bool:
    """Return whether a source is a flight schedule, in CSV or as tables of a TOML file."""
    return is_csv(source) or is_schedule_document(source_tables(source))


def is_schedule_document(document: Mapping[str, Any]) -> bool:
    """Return whether `document`, the tables of a TOML file by heading, is a flight schedule."""
    return "schedule" in document and document.keys() <= SCHEDULE_HEADINGS


def parse_vehicle(text: str, source: str) -> Vehicle:
    """Return the vehicle of a TOML `text`; `source` is the name of its file in messages.

    `InputError` with the faults of all its tables, a line each; and for a flight schedule.
    """
    if is_csv(source) or is_schedule_document(tables_of(text, source)):
        raise InputError(missing_time_message(source))
    faults, vehicle, structure = Faults(), None, None
    with faults.collect():
        table_of(text, source, VEHICLE_TABLE)  # raises for faulty headings
    document = tables_of(text, source)
    with faults.collect(), naming(called(source)):
        structure = build_structure(document)
    row = document.get("vehicle")
    with faults.collect(), naming(called(source)):
        vehicle = build_vehicle(row) if isinstance(row, dict) else None
    faults.raise_all()
    assert vehicle is not None  # or its table is at fault
    return vehicle.replace(structure=structure)


def missing_time_message(source: str) -> str:
    """Return the message that the flight schedule `source` needs a time of flight."""
    return (
        f"{called(source)} is a flight schedule: give the time of flight in s, --at TIME (time_s in"
        " [study], or load_schedule(FILE).at(TIME) in Python); tvclin margins, fly and ascent take"
        " the whole flight"
    )


def incomplete_vehicle_message(what: str) -> str:
    """Return the message that `what`, an answer, needs more than the coefficients of a vehicle."""
    return (
        f"{what} needs a whole vehicle, with weight, thrust and velocity; write a file with:"
        " tvclin init FILE"
    )


def table_of(text: str, source: str, table: FileTable) -> dict[str, Any]:
    """Return keys and values of one table of a vehicle file; empty if the file does not have it.

    `text`: of the file. `source`: its name in messages. `table`: declaration of the table, with its
    heading. `InputError` for unknown headings, and for a file without [vehicle].
    """
    document, source = tables_of(text, source), called(source)
    if COEFFICIENTS in document:
        raise InputError(
            f"{source} holds [{COEFFICIENTS}] alone: {incomplete_vehicle_message('this')}"
        )
    if not isinstance(document.get("vehicle"), dict):
        raise InputError(f"{source} has no table [vehicle]; write one with: tvclin init FILE")
    unknown = [shown(key) for key in document if key not in HEADINGS]
    if unknown:
        messages = (f"{source}: unknown heading or key {key} outside [vehicle]" for key in unknown)
        raise InputError("\n".join(messages))
    with naming(source):
        return table.one(document)


def template() -> str:
    """Return the text of a commented vehicle file with placeholders."""
    return files("tvclin.vehicle").joinpath("shipped", "template.txt").read_text(encoding="utf-8")


def build_vehicle(row: Mapping[str, Any], heading: str = "[vehicle]") -> Vehicle:
    """Return the vehicle of a table `row` of keys with units; `heading` names it in messages.

    Aerodynamic coefficients may stand in place of normal and axial force, a mass in place of the
    weight, and sources of the damping in place of pitch_damping. `InputError` for a missing key.
    """
    table = replace(VEHICLE_TABLE, heading=heading)
    values = _damping_of(table.read(row), table)
    _check_complete(values.keys(), table)
    if "mass" in values:
        values["weight"] = values.pop("mass") * STANDARD_GRAVITY
    build = Vehicle.from_aerodynamics if values.keys() & _AERODYNAMICS else Vehicle
    return build(**values)


def _damping_of(values: Mapping[str, Any], table: FileTable) -> dict[str, Any]:
    """Return the numbers of a vehicle with pitch_damping [N m s/rad] in place of its sources.

    `values`: numbers of `table`, the table [vehicle], in SI units by name: either pitch_damping, or
    an aerodynamic coefficient per q L/V and the numbers of the jet, whose dampings add up. The arm
    of the jet is the control arm unless exit_arm is given.
    """
    coefficient, flow = "pitch_damping_coefficient", "jet_mass_flow"
    sources = [name for name in (coefficient, flow) if name in values]
    result = {name: value for name, value in values.items() if name not in DAMPING_QUANTITIES}
    if "pitch_damping" in values and sources:
        raise InputError(
            f"{table.heading} has both pitch_damping and {sources[0]}; keep one (pitch_damping is"
            " that of air and jet together)"
        )
    required = {"reference_length": coefficient, "inertia_rate": flow, "exit_arm": flow}
    for name, source in required.items():
        if name in values and source not in values:
            raise InputError(f"{name} in {table.heading} needs {table.spelled(source)} beside it")
    dampings = []
    if coefficient in values:
        names = ("dynamic_pressure", "reference_area", "reference_length", "velocity")
        table.need(values, names)
        air = {name: values[name] for name in names}
        dampings.append(aerodynamic_damping(values[coefficient], "qL/V", **air))
    if flow in values:
        if "inertia_rate" not in values:
            raise InputError(
                f"jet_mass_flow in {table.heading} needs {table.spelled('inertia_rate')}, the rate"
                " of the moment of inertia: negative while propellant leaves, and 0 for an upper"
                " bound of the damping"
            )
        arm = values.get("exit_arm", values["control_arm"])
        dampings.append(jet_damping(values[flow], arm, values["inertia_rate"]))
    return result | ({"pitch_damping": sum(dampings)} if dampings else {})


def check_columns(keys: Collection[str], table: FileTable) -> None:
    """Raise `InputError` for all unknown and missing columns of vehicles in a `table`.

    `keys`: names of the columns, with units. A column that an unknown one may mean is not missing:
    `FileTable.similar` has the names of these, those of one value in other units joined by " or ".
    """
    faults, available = Faults(), []
    for key in keys:
        possible = [key]
        with faults.collect():
            if key not in table.every_key:
                possible = table.similar(key)[0]
                raise InputError(table.unknown(key))
        available += [k for keys_of_one in possible for k in keys_of_one.split(" or ")]
    with faults.collect():
        _check_complete({table.keys[key][0] for key in available if key in table.keys}, table)
    faults.raise_all()


def _check_complete(names: Collection[str], table: FileTable) -> None:
    """Raise `InputError` for missing or excess numbers of a vehicle, by their `names`.

    `table`: table of the file, which messages name.
    """
    faults = Faults()
    with faults.collect():
        if "mass" not in names and "weight" not in names:
            weight, mass = table.spelled("weight"), table.spelled("mass")
            raise InputError(f"a key is missing in {table.heading}: {weight}, or {mass}")
        if "mass" in names and "weight" in names:
            raise InputError(f"{table.heading} has both a weight and a mass; keep one")
    aerodynamic = _AERODYNAMICS.keys() & set(names)  # dynamic pressure, area, coefficients
    with faults.collect():
        required = (*_REQUIRED, *table.required, *(_AERODYNAMICS if aerodynamic else AIR_FORCES))
        table.need({*names, "weight"}, required)
    faults.raise_all()


def vehicle_table(vehicle: Vehicle) -> dict[str, Any]:
    """Return keys, with SI units, and values of a vehicle's table [vehicle], without structure.

    `build_vehicle` makes the same vehicle of them.
    """
    numbers = {name: getattr(vehicle, name) for name in NUMBERS}
    defined = {name: float(value) for name, value in numbers.items() if value is not None}
    words = {key: getattr(vehicle, key) for key in ("name", "numbers_from")}
    return {key: word for key, word in words.items() if word} | VEHICLE_TABLE.write(defined)


def vehicle_file(vehicle: Vehicle) -> str:
    """Return the text of a file of a vehicle without a structure, angles in degrees."""
    table = vehicle_table(vehicle)
    table["attitude_deg"] = float(f"{np.degrees(table.pop('attitude_rad')):.12g}")
    lines = "".join(f"{key} = {json.dumps(value)}\n" for key, value in table.items())
    return f"# A vehicle for tvclin, at one time of its flight.\n\n[vehicle]\n{lines}"


def numbers_as_written(source: str | PathLike[str]) -> dict[str, tuple[float, str]]:
    """Return number and unit of each key of [vehicle], as written in the file, by name.

    `source`: a vehicle file, or a study file with the edited source of its vehicle under [study];
    empty for a file without [vehicle].
    """
    tables = source_tables(source)
    vehicle = tables.get("study", {}).get("vehicle")
    row = (source_tables(vehicle) if isinstance(vehicle, EditedSource) else tables).get("vehicle")
    return VEHICLE_TABLE.units(row) if isinstance(row, dict) else {}


def build_structure(document: Mapping[str, Any]) -> Structure:
    """Return the structure of `document`, the tables of a vehicle file; all are optional."""
    engine = ENGINE_TABLE.one(document) if ENGINE_TABLE.name in document else None
    sensors = SENSORS_TABLE.read(SENSORS_TABLE.one(document))
    return Structure(
        bending=_built_elements(BENDING_TABLE, document, bending_mode),
        slosh=_built_elements(SLOSH_TABLE, document, SloshTank),
        engine=None if engine is None else Engine(**ENGINE_TABLE.read(engine)),
        attitude_sensor=_sensor_lag("attitude_sensor", sensors),
        rate_gyro=_sensor_lag("rate_gyro", sensors),
        **STRUCTURE_TABLE.read(STRUCTURE_TABLE.one(document)),
    )


def _built_elements(
    table: FileTable, document: Mapping[str, Any], make: Callable[..., Any]
) -> tuple[Any, ...]:
    """Return the elements of a repeated `table` of a vehicle file, such as modes or tanks.

    `document`: tables of the file by heading. `make`: function from the numbers of a row, in SI
    units by name, to an element. An `InputError` gets the number of the row in front.
    """
    values = []
    for k, row in enumerate(table.each(document), start=1):
        with naming(f"{table.name} {k}"):
            values.append(make(**table.read(row)))
    return tuple(values)


def bending_mode(**numbers: Any) -> BendingMode:
    """Return the bending mode of the numbers of a table [[bending]], in SI units by name.

    Only slopes at the tanks are still in the unit of their key, as tank_slopes_per_ft.
    """
    # _TANK_SLOPES: factors to 1/m by key
    slopes = {key: numbers.pop(key) for key in _TANK_SLOPES if key in numbers}
    if len(slopes) > 1:
        raise InputError(f"tank_slopes is given twice, as {' and '.join(slopes)}; keep one")
    for key, values in slopes.items():
        numbers["tank_slopes"] = tuple(
            number(f"{key}[{k}]", value) * _TANK_SLOPES[key] for k, value in enumerate(values)
        )
    return BendingMode(**numbers)


def _sensor_lag(name: str, sensors: Mapping[str, float]) -> Filter | None:
    """Return the lag of the sensor `name`, of first order without a damping; None without a lag.

    `sensors`: natural frequencies [rad/s] and dampings of both sensors, by name. `InputError` for a
    damping alone.
    """
    frequency, damping = sensors.get(f"{name}_frequency"), sensors.get(f"{name}_damping")
    if frequency is None:
        if damping is not None:
            SENSORS_TABLE.need(sensors, (f"{name}_frequency",))  # raises
        return None
    return Filter.low_pass(frequency, damping)
