"""The tables that campaign files share with study files."""

import csv
import io
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from tvclin.answers.campaign.dispersions import PARAMETERS, Dispersion, Dispersions
from tvclin.answers.campaign.keys import PERCENT, SUBJECT, check_keys, known, quantity, spellings
from tvclin.answers.campaign.winds import ShapedWind, WindEnsemble
from tvclin.base.errors import InputError, number, one_of, shown
from tvclin.base.files import called, exists, read_text, tables_of
from tvclin.base.units import UNITS
from tvclin.vehicle.file import build_vehicle, list_vehicles, load_vehicle
from tvclin.vehicle.vehicle import Vehicle

TABLES = (
    "study",
    "campaign",
    "wind",
    "gust",
    "schedule",
    "size",
    "outputs",
    "question",
    "flight",
    "laws",
    "autopilot",
    "criteria",
    "dispersion",
    "correlation",
)
"""Of a file that drives studies, campaigns and pages; each of these reads those that concern it."""
LISTS = ("dispersion", "correlation")
SOUNDING = "sounding"
"""The key of a [[wind]] that stands over height."""

_ANGLE, _TIME = UNITS["angle"], UNITS["time"]
_SPREADS = {
    "weight": "force",
    "moment_of_inertia": "inertia",
    "normal_force_slope": "force slope",
    "thrust": "force",
    "aerodynamic_arm": "length",
    "control_arm": "length",
    "axial_force": "force",
    "velocity": "speed",
    "attitude": "angle",
    "control_force_slope": "force slope",
    "wind_peak": "angle",
    "wind_duration": "time",
}


def read_tables(path: Path, hint: str) -> dict[str, Any]:
    """Return the document of a TOML file; the hint says how to write one that is missing."""
    text = read_text(path, "a campaign file", f"{hint} {called(path)}")
    return tables_of(text, str(path))


def subject_of(document: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return what is studied: the vehicle, and model and plane where they are given.

    They stand in [study] or in [campaign], so that one file serves both.

    Raises
    ------
    InputError
        For an unknown table, one that is none, an unknown key in a table that only studies read, a
        vehicle or its table that is missing, and what is given twice.
    """
    if not document:
        raise InputError(
            "the file is neither a vehicle file (it has no [vehicle]) nor a study (no [study])"
        )
    known("table", document, TABLES)
    for name in document.keys() - {*LISTS, "wind"}:
        if not isinstance(document[name], dict):
            raise InputError(f"[{name}] must be a table")
    check_keys(document)
    if not {"study", "campaign"} & document.keys():
        raise InputError("[study] is missing: it names the vehicle")
    recorded = _recorded(document)
    if not recorded:
        _units_of_spreads(document.get("dispersion"))
    study, campaign = document.get("study", {}), document.get("campaign", {})
    for key in SUBJECT:
        if key in study and key in campaign:
            raise InputError(f"{key} is given in [study] and in [campaign]; keep one")
    found = {key: table[key] for table in (study, campaign) for key in SUBJECT if key in table}
    where = "study" if "study" in document else "campaign"
    if "vehicle" not in found:
        raise InputError(f"a key is missing in [{where}]: vehicle")
    return found | {"vehicle": _vehicle(found["vehicle"], folder, where, recorded)}


def _recorded(document: Mapping[str, Any]) -> bool:
    """Whether it is the document of a manifest: only there numbers in SI units have bare names."""
    vehicle = document.get("campaign", {}).get("vehicle")
    return "study" not in document and isinstance(vehicle, dict) and "weight" in vehicle


def _units_of_spreads(rows: Any) -> None:
    """Raise `InputError` for a spread that has a unit and does not say which."""
    for row in rows if isinstance(rows, list) else ():
        parameter = row.get("parameter") if isinstance(row, dict) else None
        if isinstance(parameter, str) and parameter in _SPREADS and "spread" in row:
            keys = spellings({"spread": UNITS[_SPREADS[parameter]]})
            raise InputError(f"spread of {parameter} has no unit; write {' or '.join(keys)}")


def question_of(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the limit [rad], and probability and confidence where they are given."""
    asked = dict(document.get("question", {}))
    keys = spellings({"limit": _ANGLE})
    known("key in [question]", asked, (*keys, "probability", "confidence"))
    limit = quantity("[question]", asked, "limit", _ANGLE, required=False)
    return asked | {"limit": limit}


def _vehicle(source: Any, folder: Path, where: str, recorded: bool) -> Vehicle:
    if isinstance(source, dict) and not recorded:
        return build_vehicle(dict(source), f"{where}.vehicle")
    if isinstance(source, dict):
        known(f"key in [{where}.vehicle]", source, [f.name for f in fields(Vehicle)])
        try:
            return Vehicle(**source)
        except TypeError:
            raise InputError(f"[{where}.vehicle] must hold every number of a Vehicle") from None
    if not isinstance(source, str) or not source.isprintable():
        raise InputError(f"vehicle must be a name or a path; got {shown(source)}")
    beside = folder / source
    return load_vehicle(beside if source not in list_vehicles() and exists(beside) else source)


def winds_of(document: Mapping[str, Any], folder: Path) -> list[ShapedWind | WindEnsemble]:
    """Return the winds of [wind], or of each [[wind]], but for soundings, which need a flight.

    Raises
    ------
    InputError
        For what is no table, and where there is no such wind.
    """
    if "wind" not in document:
        raise InputError("[wind] is missing: it gives shape, peak_deg and duration_s")
    tables = [table for table in wind_tables(document) if SOUNDING not in table]
    if not tables:
        raise InputError("beside soundings a wind of one shape is needed: give one more [[wind]]")
    return [wind_of(table, folder) for table in tables]


def wind_tables(document: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return [wind], or each [[wind]]."""
    given = document.get("wind", {})
    rows = given if isinstance(given, list) else [given]
    if not all(isinstance(row, dict) for row in rows):
        raise InputError("wind must be a table [wind], or [[wind]] once for each")
    return [dict(row) for row in rows]


def wind_of(table: dict[str, Any], folder: Path) -> ShapedWind | WindEnsemble:
    """Return the wind of the table [wind]; a file of winds is looked for in the folder."""
    if "file" in table:
        known("key in [wind]", table, ("file", "unit"))
        factor = _ANGLE[one_of("unit in [wind]", table.get("unit", "deg"), _ANGLE)]
        time, angle = _read_winds(folder / str(table["file"]))
        return WindEnsemble(time, angle * factor)
    if "angle_rad" in table:
        known("key in [wind]", table, ("time_s", "angle_rad"))
        return WindEnsemble(np.array(table.get("time_s")), np.array(table["angle_rad"]))
    keys = spellings({"peak": _ANGLE, "duration": _TIME})
    known("key in [wind]", table, ("shape", "file", "unit", SOUNDING, *keys))
    rest = dict(table)
    shape = rest.pop("shape", "triangular")
    peak = quantity("[wind]", rest, "peak", _ANGLE)
    duration = quantity("[wind]", rest, "duration", _TIME)
    if rest:
        raise InputError(f"{min(rest)} in [wind] stands without the file that it is of")
    return ShapedWind(shape, float(peak or 0.0), float(duration or 0.0))


def _read_winds(path: Path) -> tuple[Any, Any]:
    """Times [s] from the first column, and one wind for each further column."""
    text, name = read_text(path, "a file of winds"), called(path)
    try:
        rows = [row for row in csv.reader(io.StringIO(text, newline="")) if row]
    except csv.Error as error:
        raise InputError(f"{name} is not CSV: {error}") from None
    try:
        table = np.array([[float(cell) for cell in row] for row in rows[1:]])
    except ValueError:
        raise InputError(f"{name} must hold numbers in equal rows below its headings") from None
    if not rows or rows[0][0].strip() != "time_s" or table.ndim != 2 or table.shape[1] < 2:
        raise InputError(f"{name} must have a first column time_s and one for each wind")
    return table[:, 0], table[:, 1:].T


def dispersions_of(each: Any, correlation: Any) -> Dispersions:
    """Return the dispersions of the tables [[dispersion]] and [[correlation]]."""
    for name, rows in (("dispersion", each), ("correlation", correlation)):
        if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
            raise InputError(f"{name} must be given as [[{name}]], once for each")
    made = tuple(_dispersion(row) for row in each)
    names = [one.parameter for one in made]
    if not correlation:
        return Dispersions(made)
    matrix = np.eye(len(made))
    for row in correlation:
        known("key in [[correlation]]", row, ("between", "coefficient"))
        between = row.get("between")
        if not isinstance(between, list) or len(between) != 2 or between[0] == between[1]:
            raise InputError(
                f"between in [[correlation]] must name two parameters; got {shown(between)}"
            )
        i, j = (names.index(one_of("between in [[correlation]]", name, names)) for name in between)
        matrix[i, j] = matrix[j, i] = number("coefficient", row.get("coefficient"))
    return Dispersions(made, tuple(map(tuple, matrix.tolist())))


def _dispersion(row: dict[str, Any]) -> Dispersion:
    rest = dict(row)
    parameter = one_of("parameter in [[dispersion]]", rest.pop("parameter", None), PARAMETERS)
    units = UNITS[_SPREADS[parameter]] if parameter in _SPREADS else {"": 1.0}
    shape = rest.pop("shape", "normal")
    keys = dict(zip(spellings({"spread": units}), units.values(), strict=True))
    spreads = {"part": 1.0, "percent": 1.0 / PERCENT, "spread": 1.0} | keys
    offered = ("part", "percent", *keys)
    named = {key: value for key, value in rest.items() if key != "spread"}
    known(f"key in [[dispersion]] of {parameter}", named, offered)
    if len(rest) != 1:
        raise InputError(
            f"the spread of {parameter} must be given once, as percent or as {', '.join(keys)}"
        )
    (key, value) = rest.popitem()
    spread = number(f"{key} of {parameter}", value) * spreads[key]
    return Dispersion(parameter, shape, spread, relative=key in ("part", "percent"))
