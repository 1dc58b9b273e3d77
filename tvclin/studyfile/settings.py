"""Keys of a study file that are set beside it, as by --set of the commands.

A key is named with its table, as `autopilot.rate_gain_s`, and with the row of a repeated one, as
`wind.2.peak_deg` or `dispersion.thrust.percent`. The tables of the file are changed before they
are read, so that a key is checked as in the file.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from tvclin.ascent.nominal_flight import FLIGHT_TABLE
from tvclin.base.errors import InputError, naming, number, shown
from tvclin.base.files import EditedSource, called
from tvclin.base.tables import FileTable, check_known
from tvclin.case.case import DEFAULT_WIND
from tvclin.control.autopilot.design_rules import GIVEN_GAINS, RULE_KEYS
from tvclin.control.autopilot.gain_table import FILTER_TABLE
from tvclin.studyfile.campaign_file import CONTROLLER_TABLE, PLANT_TABLE, TABLES, vehicle_source
from tvclin.studyfile.study_plan import DOCUMENT_TABLE
from tvclin.vehicle.linear_vehicle import COEFFICIENTS_TABLE
from tvclin.vehicle.vehicle_file import (
    BENDING_TABLE,
    ENGINE_TABLE,
    SENSORS_TABLE,
    SLOSH_TABLE,
    STRUCTURE_TABLE,
    VEHICLE_TABLE,
    is_schedule,
    source_tables,
)
from tvclin.winds.wind_file import SOUNDING, SOUNDING_TABLE, WIND_TABLE

STUDY_TABLES = {table.name: table for table in TABLES}
"""Tables of a study file by heading."""
VEHICLE_TABLES = {
    table.name: table
    for table in (
        *(VEHICLE_TABLE, FLIGHT_TABLE, STRUCTURE_TABLE, ENGINE_TABLE, SENSORS_TABLE),
        *(BENDING_TABLE, SLOSH_TABLE, COEFFICIENTS_TABLE),
    )
}
"""Tables of a vehicle file by heading."""
_ALL_TABLES = STUDY_TABLES | VEHICLE_TABLES
_ROWS = {"wind": "name", "dispersion": "parameter", "correlation": "", "bending": "", "slosh": ""}
"""Repeated tables, and the key that names a row."""
_ROW_BY_NAME = "dispersion"
"""Table in which an unknown name begins a row."""
_PEAKS = ("peak",), ("peak_speed",)
_ALTERNATIVES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "wind": _PEAKS,
    "gust": _PEAKS,
    "vehicle": (("weight",), ("mass",)),
    "autopilot": (GIVEN_GAINS, RULE_KEYS),
    "availability": (("persistence",), ("persistence_hours",)),
}
"""Quantities of a table of which the first group excludes the second."""
_PULSE = ("shape", "peak", "peak_speed", "duration")
"""Quantities of a wind of one shape, which a sounding in its place removes."""
_TEXTS = (WIND_TABLE, SOUNDING_TABLE, VEHICLE_TABLE, DOCUMENT_TABLE, PLANT_TABLE, CONTROLLER_TABLE)
"""Tables whose words are texts, also where they look like numbers."""
_SINGLE_KEY_TABLES = {PLANT_TABLE.name, CONTROLLER_TABLE.name}
"""Tables that are removed with their only key."""
_REMOVAL = "none"
"""Value that removes a key."""


class Setting(NamedTuple):
    """A key as it was given, its parts, and its value; None removes the key."""

    key: str
    parts: list[str]
    value: Any


def with_settings(source: str, settings: Iterable[tuple[str, str]]) -> str:
    """Return a source with keys of its study file, or of its vehicle file, set.

    Parameters
    ----------
    source : str
        See `load_study`. A vehicle, or a flight schedule, becomes a study of that.
    settings : iterable of (str, str)
        Keys with their table, and their values as in a TOML file, strings without quotes; "none"
        removes a key. Keys in another unit, or that exclude the new one, are replaced.

    Raises
    ------
    InputError
        For an unknown table, key or row (similar ones are suggested), for a key that is given
        twice, and for keys of a vehicle whose source is a flight schedule.

    Examples
    --------
    >>> import tvclin as tv
    >>> source = with_settings("configuration-i", [("autopilot.rate_gain_s", "0.8")])
    >>> tv.load_study(source).design.rate_gain
    0.8
    """
    assigned = [_setting(key, value) for key, value in settings]
    keys = [setting.key for setting in assigned]
    for key in keys:
        if keys.count(key) > 1:
            raise InputError(f"--set {key} is given twice; keep one")
    of_vehicle = [setting for setting in assigned if setting.parts[0] in VEHICLE_TABLES]
    of_study = [setting for setting in assigned if setting.parts[0] in STUDY_TABLES]
    tables = source_tables(source)
    shown_keys = tuple(setting.key for setting in of_study if setting.value is not None)
    if {"study", "campaign"} & tables.keys():
        study = _study(tables, Path(source).parent, of_study, of_vehicle)
        return EditedSource(source, study, shown_keys)
    vehicle = _vehicle(source, tables, of_vehicle)
    if not of_study:
        return vehicle
    wind = {"shape": DEFAULT_WIND.shape, "peak_rad": DEFAULT_WIND.peak}
    document = {"study": {"vehicle": vehicle}, "wind": wind | {"duration_s": DEFAULT_WIND.duration}}
    return EditedSource(source, _changed(document, of_study), shown_keys)


def required_names(heading: str) -> tuple[str, ...]:
    """Return the names that a table requires, without units; `heading`: its name, such as gust."""
    return _ALL_TABLES[heading].required


def quantity_name(key: str) -> str:
    """Return the name of a key with its table, without its row and its unit.

    The key wind.2.peak_deg has wind.peak, and all keys of a filter, as autopilot.filter.1.kind,
    have autopilot.filter. An unknown key is unchanged.
    """
    parts = key.split(".")
    table = _ALL_TABLES.get(parts[0])
    if table is None or len(parts) == 1:
        return key
    if parts[0] == "autopilot" and len(parts) > 2:
        return ".".join(parts[:2])
    return f"{parts[0]}.{_quantity(table, parts[-1])}"


def _setting(key: str, value: str) -> Setting:
    """Return the setting of ``--set`` with a key, such as size.every_s, and the text of its value.

    Its table is checked: `InputError` for an unknown one.
    """
    parts = key.split(".")
    if not all(parts):
        raise InputError(
            f"--set takes a key with its table, such as autopilot.rate_gain_s; got {shown(key)}"
        )
    if len(parts) == 1 and parts[0] not in _ALL_TABLES:
        homes = [f"{name}.{key}" for name, table in _ALL_TABLES.items() if key in table.every_key]
        if homes:
            raise InputError(f"--set {key} needs its table: {' or '.join(homes)}")
    check_known("table of --set", parts[:1], _ALL_TABLES)
    return Setting(key, parts, _value(key, value))


def _value(key: str, text: str) -> Any:
    """Return the value of a text: a number, true or false, a list, or the text itself.

    None for the word that removes the key. `key`: the key, for messages.
    """
    text = text.strip()
    if text == _REMOVAL:
        return None
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    if text in ("true", "false"):
        return text == "true"
    if text[:1] not in ('"', "'", "[", "{"):
        return text
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        raise InputError(f"--set {key} is no value of a TOML file: {shown(text)}") from None


def _study(
    tables: dict[str, Any], folder: Path, of_study: list[Setting], of_vehicle: list[Setting]
) -> dict[str, Any]:
    """Return the tables of a study file with its keys, and the keys of its vehicle, set.

    `tables`: those of the file. `folder`: where the file is. `of_study`, `of_vehicle`: settings of
    the file, and of the vehicle that it names.
    """
    tables = _changed(tables, of_study)
    # the table that names the vehicle
    name = "study" if "vehicle" in tables.get("study", {}) else "campaign"
    home = tables.get(name, {})
    vehicle = home.get("vehicle")
    if not of_vehicle:
        return tables
    if isinstance(vehicle, dict):
        check_known(
            "table of --set", [item.parts[0] for item in of_vehicle], ["vehicle", *STUDY_TABLES]
        )
        return tables | {name: home | _changed({"vehicle": vehicle}, of_vehicle)}
    if not isinstance(vehicle, str):
        raise InputError(f"--set {of_vehicle[0].key} needs a vehicle in [study]")
    file = str(vehicle_source(vehicle, folder))
    # in place of the name of its file an `EditedSource`, the name with the changed tables
    edited = _vehicle(file, source_tables(file), of_vehicle)
    flight = tables.get("schedule")
    if isinstance(flight, dict) and flight.get("source") == vehicle:
        flight["source"] = edited
    home["vehicle"] = edited
    return tables


def _vehicle(source: str, tables: dict[str, Any], settings: list[Setting]) -> str:
    """Return the source of a vehicle, with keys of its file set.

    `source`: name or path. `tables`: of its file. `settings`: keys and values. `InputError`
    for keys of a flight schedule, whose columns are no keys of a vehicle file.
    """
    if settings and is_schedule(source):
        raise InputError(
            f"--set {settings[0].key} is of a vehicle, and {called(source)} a flight schedule:"
            " write its vehicle at a time with tvclin init FILE --from SCHEDULE --at TIME"
        )
    return EditedSource(source, _changed(tables, settings) if settings else None)


def _changed(tables: dict[str, Any], settings: list[Setting]) -> dict[str, Any]:
    """Return tables with keys set; `InputError` where two of the keys exclude each other.

    `tables`: of a file, which are changed. `settings`: keys and values. Two exclude each other
    where the later removes the key of the earlier. [plant] and [controller], which have a single
    key, are removed with it.
    """
    for k, setting in enumerate(settings):
        with naming(f"--set {setting.key}"):
            _put(tables, setting)
        for earlier in settings[:k]:
            if earlier.value is not None and not _exists(tables, earlier):
                raise InputError(
                    f"--set {earlier.key} and {setting.key} exclude each other; keep one"
                )
    for name in {setting.parts[0] for setting in settings} & _SINGLE_KEY_TABLES:
        if not tables.get(name):
            tables.pop(name, None)
    return tables


def _put(tables: dict[str, Any], setting: Setting) -> None:
    """Set the key of a setting in tables, or remove it, its row or its table.

    A key is TABLE.KEY, in a repeated table TABLE.ROW.KEY, and of a filter autopilot.filter.ROW.KEY;
    a table or a row takes no value but the one that removes it, None. A table that the file has not
    is made. `InputError` for a key of another form.
    """
    (name, *rest), value = setting.parts, setting.value
    if not rest:
        if value is not None:
            raise InputError(f"a table takes no value but none; write {name}.KEY")
        tables.pop(name, None)
        return
    table, entry = _ALL_TABLES[name], tables.get(name)
    if name in _ROWS:  # a repeated table; `_row` takes the row's number or name from `rest`
        row = _row(_rows_of(tables, name), name, rest, value)
        if row is None:  # removed
            return
        entry, table = row, _row_table(name, rest[0])
    elif entry is None:
        entry = tables[name] = {}
    elif not isinstance(entry, dict):
        raise InputError(f"{name} is no table in the file")
    if name == "autopilot" and rest[0] == "filter" and len(rest) > 1:
        filters, rest = entry.setdefault("filter", []), rest[1:]
        row = _row(filters, "autopilot.filter", rest, value)
        if row is None:
            return
        entry, table = row, FILTER_TABLE
    if len(rest) > 1:
        raise InputError(f"a key stands in a table; {'.'.join(rest)} are several")
    _put_key(table, name, entry, rest[0], value)


def _rows_of(tables: dict[str, Any], name: str) -> list[dict[str, Any]]:
    """Return the rows of the repeated table `name`, which is then a list in `tables`."""
    entry = tables.get(name, [])
    rows = entry if isinstance(entry, list) else [entry]
    if not all(isinstance(row, dict) for row in rows):
        raise InputError(f"{name} is no table in the file")
    tables[name] = rows
    return rows


def _row(
    rows: list[dict[str, Any]], name: str, rest: list[str], value: Any
) -> dict[str, Any] | None:
    """Return the row of a table to which a key belongs; None where the key removed the row.

    The key name.1.key is of the first row, name.key of the only one; the number after the last adds
    a row. `rows`: rows of the table `name`. `rest`: parts of the key after that name; number or
    name are taken from it. `value`: value to be set; None removes the row where no key is left.
    """
    k = _index(rows, name, rest)
    if k is None:
        if len(rows) > 1:
            raise InputError(
                f"the file has {len(rows)} of [[{name}]]: write {name}.1.{rest[0]}, for example"
            )
        if not rows:
            rows.append({})
        return rows[0]
    del rest[0]
    if rest:
        if k == len(rows):
            rows.append({})
        return rows[k]
    if value is not None:
        raise InputError("a row takes no value but none; name its key too")
    del rows[k : k + 1]
    return None


def _index(rows: list[dict[str, Any]], name: str, rest: list[str]) -> int | None:
    """Return the index of a row by its number or name; None if the key has neither.

    The number after the last is the index of a row that the caller adds. An unknown name adds a row
    to [[dispersion]], and is refused in other tables. `rows`: rows of the table `name`. `rest`:
    parts of the key after that name: number or name, then the key; or the key alone.
    """
    label, first = _ROWS.get(name, ""), rest[0]  # key whose value names a row, and first part
    names = [str(row.get(label, "")) for row in rows] if label else []
    if first.isdigit():
        if not 1 <= int(first) <= len(rows) + 1:
            raise InputError(f"the file has {len(rows)} of [[{name}]]; got number {first}")
        return int(first) - 1
    if first in names:
        return names.index(first)
    if len(rest) == 1:
        return None
    if name != _ROW_BY_NAME:
        check_known(f"row of [[{name}]]", [first], [*filter(None, names), "a number"])
    rows.append({label: first})
    return len(rows) - 1


def _row_table(name: str, key: str) -> FileTable:
    """Return the table of a key in a row of the table `name`; a wind may be a sounding."""
    table = _ALL_TABLES[name]
    of_sounding = name == "wind" and key not in table.every_key and key in SOUNDING_TABLE.every_key
    return SOUNDING_TABLE if of_sounding else table


def _put_key(table: FileTable, name: str, entry: dict[str, Any], key: str, value: Any) -> None:
    """Set or remove a key of a table, checked; other spellings of the quantity are removed.

    `table`: keys of the table `name`. `entry`: the table of the file, which is changed. `value`:
    new value; None removes the key. Keys of quantities that exclude this one are removed too. A
    text with commas becomes a list, and a number a text, where the table takes that. `InputError`
    for a key that is not of the table, unless keys are free: in [schedule], and spreads.
    """
    free = name == "schedule" or (name == "dispersion" and key.startswith("spread"))
    if not free and key not in table.every_key:
        raise InputError(table.unknown(key))
    if key in table.keys and value is not None:
        number(key, value)
    quantity = _quantity(table, key)
    # quantities of one of these tuples exclude those of the other
    excluded, (first, second) = {quantity}, _ALTERNATIVES.get(name, ((), ()))
    if value is not None and quantity in (*first, *second):
        excluded |= set(second if quantity in first else first)
    if value is not None and (name, key) == ("wind", SOUNDING):
        excluded |= set(_PULSE)
    for excluded_key in [
        excluded_key for excluded_key in entry if _quantity(table, excluded_key) in excluded
    ]:
        del entry[excluded_key]
    if value is None:
        return
    if key in table.lists and isinstance(value, str):
        value = [_value(key, item) for item in value.split(",")]
    elif key in table.lists and not isinstance(value, list):
        value = [value]
    elif key in table.words and table in _TEXTS and isinstance(value, int | float):
        value = str(value)
    entry[key] = value


def _quantity(table: FileTable, key: str) -> str:
    """Return the quantity of a key in a table, the key without its unit."""
    quantity, *_ = table.keys.get(key, (key,))  # with its factor to SI; a word has no unit
    return quantity


def _exists(tables: Mapping[str, Any], setting: Setting) -> bool:
    """Return whether the key of a setting is in the tables, in any row of a repeated one.

    Repeated are such as [[wind]], and the filters of [autopilot]: autopilot.filter.ROW.KEY.
    """
    key, entry = setting.parts[-1], tables.get(setting.parts[0])
    rows = entry if isinstance(entry, list) else [entry]
    if setting.parts[0] == "autopilot" and len(setting.parts) > 2:
        rows = tables["autopilot"].get("filter", [])
    return any(isinstance(row, dict) and key in row for row in rows)
