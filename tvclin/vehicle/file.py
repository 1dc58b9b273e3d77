"""Vehicle files: TOML with one table [vehicle], every key carrying its unit."""

import json
from collections.abc import Mapping
from dataclasses import replace
from importlib.resources import files
from os import PathLike, fspath
from typing import Any

import numpy as np

from tvclin.base.errors import Faults, InputError, naming, one_of, shown
from tvclin.base.errors import path as a_path
from tvclin.base.files import ENCODINGS, UTF_8, called, exists, read_text, tables_of
from tvclin.base.tables import FileTable
from tvclin.vehicle.damping import QUANTITIES, damping_of
from tvclin.vehicle.structure_file import build_structure
from tvclin.vehicle.vehicle import NUMBERS, STANDARD_GRAVITY, Vehicle

_ALWAYS = {
    "weight": "force",
    "moment_of_inertia": "inertia",
    "thrust": "force",
    "aerodynamic_arm": "length",
    "control_arm": "length",
    "velocity": "speed",
    "attitude": "angle",
}
_FORCES = {"normal_force_slope": "force slope", "axial_force": "force"}
_AERODYNAMICS = {
    "dynamic_pressure": "pressure",
    "reference_area": "area",
    "normal_force_coefficient_slope": "per angle",
    "axial_force_coefficient": "number",
}
_OPTIONAL = {"time": "time", "control_force_slope": "force slope"}
_MASS = {"mass": "mass"}
"""In place of the weight."""

VEHICLE_TABLE = FileTable(
    "[vehicle]",
    _ALWAYS | _FORCES | _AERODYNAMICS | _OPTIONAL | QUANTITIES | _MASS,
    words=("name", "numbers_from"),
)
COEFFICIENTS = "coefficients"
"""The table of files that hold no vehicle, see `load_any_vehicle`."""
HEADINGS = ("vehicle", "flight", "structure", "engine", "sensors", "bending", "slosh")
"""Tables of a vehicle file: [flight] is for `FlightCondition`, the others for `structure_file`."""


def list_vehicles() -> list[str]:
    """Return the names of the vehicles that come with the package."""
    entries = (entry.name for entry in files("tvclin.vehicle").joinpath("shipped").iterdir())
    return sorted(name.removesuffix(".toml") for name in entries if name.endswith(".toml"))


def load_vehicle(source: str | PathLike[str]) -> Vehicle:
    """Return a vehicle by its name in the package, or from a TOML file.

    What bends and sloshes stands beside [vehicle], under headings of its own: [structure],
    [engine], [sensors], and one [[bending]] and [[slosh]] for each mode and tank. All are optional.

    Parameters
    ----------
    source : str or path
        One of `list_vehicles`, or the path of a file (anything that ends in .toml, holds a
        path separator, or exists).

    Raises
    ------
    InputError
        For an unknown name (the near ones are offered) and for a file that cannot be read, is
        not TOML, lacks a key, has one too many, or holds a value that is not a number. One
        sentence says which and how to mend it.

    Examples
    --------
    >>> import tvclin as tv
    >>> tv.load_vehicle("configuration-i").weight
    1480000.0
    >>> structure = tv.load_vehicle("made-up-booster").structure
    >>> [mode.frequency for mode in structure.bending], len(structure.slosh)
    ([13.58, 30.18, 61.18], 2)
    """
    return parse_vehicle(*vehicle_text(source))


def vehicle_text(source: str | PathLike[str]) -> tuple[str, str]:
    """Return the text of a vehicle file and what to call it; as `load_vehicle`."""
    path, text = a_path("vehicle", source, "a name or a path"), fspath(source)
    if text in list_vehicles():
        resource = files("tvclin.vehicle").joinpath("shipped", f"{text}.toml")
        return resource.read_text(encoding="utf-8"), text
    looks_like_a_path = isinstance(source, PathLike) or path.suffix or path.name != text
    if not looks_like_a_path and not exists(path):
        one_of("vehicle (or the path of a vehicle file)", text, list_vehicles())
    name = called(path)
    start = f"write one with: tvclin init {name}, or a study file with: tvclin init --study {name}"
    encodings = ENCODINGS if is_csv(path) else UTF_8
    return read_text(path, "a vehicle file", start, encodings), text


def source_tables(source: str | PathLike[str]) -> dict[str, Any]:
    """Return the tables of a vehicle or study file by heading; none of a schedule in CSV."""
    return {} if is_csv(source) else tables_of(*vehicle_text(source))


def is_csv(source: str | PathLike[str]) -> bool:
    """Whether a source is a flight schedule by its name: no vehicle or study file is in CSV."""
    return str(a_path("source", source, "a name or a path")).lower().endswith(".csv")


def is_schedule(source: str | PathLike[str]) -> bool:
    """Whether a source is a flight schedule, in CSV or as the one table of a TOML file."""
    return is_csv(source) or source_tables(source).keys() == {"schedule"}


def parse_vehicle(text: str, source: str) -> Vehicle:
    """Return the vehicle that a TOML text describes; `source` names it in messages."""
    if is_csv(source) or tables_of(text, source).keys() == {"schedule"}:
        raise InputError(needs_time(source))
    faults, vehicle, structure = Faults(), None, None
    with faults.kept():
        table_of(text, source, VEHICLE_TABLE)
    document = tables_of(text, source)
    with faults.kept(), naming(called(source)):
        structure = build_structure(document)
    given = document.get("vehicle")
    with faults.kept(), naming(called(source)):
        vehicle = build_vehicle(given) if isinstance(given, dict) else None
    faults.tell()
    assert vehicle is not None  # or its table is at fault
    return vehicle.replace(structure=structure)


def needs_time(source: str) -> str:
    """Return the one sentence for a flight schedule without the time of its vehicle."""
    return (
        f"{called(source)} is a flight schedule: give the time of flight of its vehicle, as --at 52"
        ' of a command, time_s in [study], or load_schedule("flight.csv").at(52) in Python'
    )


def needs_whole(what: str) -> str:
    """Return the one sentence for what coefficients alone cannot answer."""
    return (
        f"{what} needs a whole vehicle, with weight, thrust and velocity; write a file with:"
        " tvclin init FILE"
    )


def table_of(text: str, source: str, table: FileTable) -> dict[str, Any]:
    """Return one table of a vehicle file as it stands, empty where [flight] is not there."""
    document, source = tables_of(text, source), called(source)
    if COEFFICIENTS in document:
        raise InputError(f"{source} holds [{COEFFICIENTS}] alone: {needs_whole('this')}")
    if not isinstance(document.get("vehicle"), dict):
        raise InputError(f"{source} has no table [vehicle]; write one with: tvclin init FILE")
    unknown = [shown(key) for key in document if key not in HEADINGS]
    if unknown:
        said = (f"{source}: unknown heading or key {one} outside [vehicle]" for one in unknown)
        raise InputError("\n".join(said))
    with naming(source):
        return table.one(document)


def template() -> str:
    """Return a commented vehicle file to fill in."""
    return files("tvclin.vehicle").joinpath("shipped", "template.txt").read_text(encoding="utf-8")


def build_vehicle(given: Mapping[str, Any], heading: str = "[vehicle]") -> Vehicle:
    """Return the vehicle of a table of keys with their units; the heading is for messages."""
    table = replace(VEHICLE_TABLE, heading=heading)
    values = _weighed(damping_of(table.read(given), table), table)
    table.need(values, _ALWAYS)
    aerodynamic = values.keys() & _AERODYNAMICS
    table.need(values, _AERODYNAMICS if aerodynamic else _FORCES)
    build = Vehicle.from_aerodynamics if aerodynamic else Vehicle
    return build(**values)


def vehicle_table(vehicle: Vehicle) -> dict[str, Any]:
    """Return the keys and values of one vehicle, as `build_vehicle` takes them."""
    numbers = {name: getattr(vehicle, name) for name in NUMBERS}
    known = {name: float(value) for name, value in numbers.items() if value is not None}
    words = {key: getattr(vehicle, key) for key in ("name", "numbers_from")}
    return {key: word for key, word in words.items() if word} | VEHICLE_TABLE.write(known)


def vehicle_file(vehicle: Vehicle) -> str:
    """Return the text of a file of one vehicle without a structure, angles in degrees."""
    table = vehicle_table(vehicle)
    table["attitude_deg"] = float(f"{np.degrees(table.pop('attitude_rad')):.12g}")
    lines = "".join(f"{key} = {json.dumps(value)}\n" for key, value in table.items())
    return f"# A vehicle for tvclin, at one time of its flight.\n\n[vehicle]\n{lines}"


def as_written(source: str | PathLike[str]) -> dict[str, tuple[float, str]]:
    """Return the numbers of a vehicle file in its own units, by name; none of another file."""
    given = source_tables(source).get("vehicle")
    return VEHICLE_TABLE.units(given) if isinstance(given, dict) else {}


def _weighed(values: dict[str, Any], table: FileTable) -> dict[str, Any]:
    """The values with the weight m g of a mass that is given in its place."""
    if "mass" not in values:
        if "weight" not in values:
            raise InputError(
                f"a key is missing in {table.heading}: {table.spelled('weight')}, or"
                f" {table.spelled('mass')}"
            )
        return values
    if "weight" in values:
        raise InputError(f"{table.heading} has both a weight and a mass; keep one")
    return {name: value for name, value in values.items() if name != "mass"} | {
        "weight": values["mass"] * STANDARD_GRAVITY
    }
