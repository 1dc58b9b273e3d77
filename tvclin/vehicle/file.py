"""Vehicle files: TOML with one table [vehicle], every key carrying its unit."""

from difflib import get_close_matches
from importlib.resources import files
from os import PathLike, fspath
from typing import Any

from tvclin.base.errors import InputError, number, one_of, shown
from tvclin.base.errors import path as a_path
from tvclin.base.files import called, exists, read_text, tables_of
from tvclin.base.units import UNITS
from tvclin.vehicle.vehicle import Vehicle

_REQUIRED = {
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

_QUANTITIES = _REQUIRED | _FORCES | _AERODYNAMICS | _OPTIONAL
HEADINGS = ("vehicle", "flight")
"""Tables of a vehicle file; what stands under [flight] is for `flight.FlightCondition`."""


def list_vehicles() -> list[str]:
    """Return the names of the vehicles that come with the package."""
    entries = (entry.name for entry in files("tvclin.vehicle").joinpath("shipped").iterdir())
    return sorted(name.removesuffix(".toml") for name in entries if name.endswith(".toml"))


def load_vehicle(source: str | PathLike[str]) -> Vehicle:
    """Return a vehicle by its name in the package, or from a TOML file.

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
    return read_text(path, "a vehicle file", start), text


def parse_vehicle(text: str, source: str) -> Vehicle:
    """Return the vehicle that a TOML text describes; `source` names it in messages."""
    table = table_of(text, source, "vehicle")
    try:
        return build_vehicle(table)
    except InputError as error:
        raise InputError(f"{called(source)}: {error}") from None


def table_of(text: str, source: str, heading: str) -> dict[str, Any]:
    """Return one table of a vehicle file, empty where [flight] is not there."""
    document, source = tables_of(text, source), called(source)
    if not isinstance(document.get("vehicle"), dict):
        raise InputError(f"{source} has no table [vehicle]; write one with: tvclin init FILE")
    for key in document.keys() - set(HEADINGS):
        raise InputError(f"{source}: unknown heading or key {shown(key)} outside [vehicle]")
    table = document.get(heading, {})
    if not isinstance(table, dict):
        raise InputError(f"{source}: {heading} must be a table [{heading}]; got {shown(table)}")
    return dict(table)


def template() -> str:
    """Return a commented vehicle file to fill in."""
    return files("tvclin.vehicle").joinpath("shipped", "template.txt").read_text(encoding="utf-8")


def quantities(
    table: dict[str, Any], known: dict[str, str], heading: str, others: tuple[str, ...] = ()
) -> dict[str, float]:
    """Return the numbers of a table in SI units, by name without the unit.

    Parameters
    ----------
    table : dict
        Keys with their units, and numbers.
    known : dict of str to str
        The names, and of what dimension of `units.UNITS` each is.
    heading : str
        Name of the table, for messages.
    others : tuple of str
        Further keys that are legal there, for messages.

    Raises
    ------
    InputError
        For an unknown key or unit, a quantity given twice, and a value that is no number.
    """
    keys = {
        (f"{name}_{suffix}" if suffix else name): (name, factor)
        for name, dimension in known.items()
        for suffix, factor in UNITS[dimension].items()
    }
    values: dict[str, float] = {}
    given: dict[str, str] = {}
    for key, value in table.items():
        if key not in keys:
            raise InputError(_unknown(key, known, [*others, *keys], heading))
        quantity, factor = keys[key]
        if quantity in given:
            raise InputError(f"{quantity} is given twice, as {given[quantity]} and {key}; keep one")
        given[quantity] = key
        values[quantity] = number(key, value) * factor
    return values


def build_vehicle(table: dict[str, Any], heading: str = "vehicle") -> Vehicle:
    """Return the vehicle of a table of keys with their units; the heading is for messages.

    Raises
    ------
    InputError
        As `load_vehicle`, but for the file.
    """
    rest = dict(table)
    name = rest.pop("name", "")
    values: dict[str, Any] = quantities(rest, _QUANTITIES, heading, ("name",))
    aerodynamic = values.keys() & _AERODYNAMICS
    needed = _REQUIRED | (_AERODYNAMICS if aerodynamic else _FORCES)
    for quantity, dimension in needed.items():
        if quantity not in values:
            raise InputError(f"a key is missing: {_spellings(quantity, dimension)}")
    build = Vehicle.from_aerodynamics if aerodynamic else Vehicle
    return build(name=name, **values)


def _unknown(key: str, known: dict[str, str], keys: list[str], heading: str) -> str:
    for quantity, dimension in sorted(known.items(), key=lambda item: -len(item[0])):
        if key == quantity or key.startswith(f"{quantity}_"):
            return f"{key} has no known unit; write {_spellings(quantity, dimension)}"
    near = get_close_matches(key, keys, n=2, cutoff=0.5)
    hint = f"did you mean {' or '.join(near)}?" if near else f"known are {', '.join(known)}"
    return f"unknown key {shown(key)} in [{heading}]; {hint}"


def _spellings(quantity: str, dimension: str) -> str:
    return " or ".join(f"{quantity}_{unit}" if unit else quantity for unit in UNITS[dimension])
