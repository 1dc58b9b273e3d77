"""Campaign files: TOML in, a `Campaign` out, and back into the document that a manifest keeps."""

import csv
import tomllib
from collections.abc import Mapping
from dataclasses import fields
from difflib import get_close_matches
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from tvclin.campaign.dispersions import PARAMETERS, Dispersion, Dispersions
from tvclin.campaign.flights import Flight
from tvclin.campaign.plan import Campaign
from tvclin.campaign.winds import ShapedWind, WindEnsemble
from tvclin.errors import InputError, number, one_of
from tvclin.units import UNITS
from tvclin.vehicle import Vehicle
from tvclin.vehicle_file import list_vehicles, load_vehicle

_TABLES = ("campaign", "wind", "outputs", "question", "flight", "dispersion", "correlation")
_PLAIN = ("model", "plane", "cases", "seed", "method", "chunk")
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
_FLIGHT: dict[str, dict[str, float]] = {
    "deflection_limit": UNITS["angle"],
    "rate_limit": {f"{unit}_per_s": factor for unit, factor in UNITS["angle"].items()},
    "sample_rate": {"Hz": 1.0},
    "attitude_gain": {"": 1.0},
    "rate_gain": {"s": 1.0},
    "alpha_gain": {"": 1.0},
    "integral_gain": {"per_s": 1.0},
    "natural_frequency": {"rad_per_s": 1.0},
    "damping": {"": 1.0},
}
_PERCENT = 100.0


def load_campaign(path: str | PathLike[str]) -> Campaign:
    """Return the campaign that a TOML file describes.

    Parameters
    ----------
    path : str or path
        The file; the paths in it are relative to its folder. `template` shows one.

    Raises
    ------
    InputError
        For a file that cannot be read, is not TOML, or has an unknown key (the near ones are
        offered), and as `Campaign`. One sentence says which and how to mend it.
    """
    file = Path(path)
    try:
        document = tomllib.loads(file.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise InputError(
            f"{file} cannot be read: {error.strerror}; write a campaign file with: tvclin campaign"
            f" init {file}"
        ) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InputError(f"{file} is not valid TOML: {error}") from None
    try:
        return parse_campaign(document, file.parent)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None


def template() -> str:
    """Return a commented campaign file to fill in."""
    return files("tvclin").joinpath("campaign", "template.txt").read_text(encoding="utf-8")


def parse_campaign(document: Mapping[str, Any], folder: Path = Path()) -> Campaign:
    """Return the campaign of a document; see `load_campaign`."""
    _known("table", document, _TABLES)
    for name in document.keys() - {"dispersion", "correlation"}:
        if not isinstance(document[name], dict):
            raise InputError(f"[{name}] must be a table")
    head, asked = dict(document.get("campaign", {})), dict(document.get("question", {}))
    outputs = dict(document.get("outputs", {}))
    _known("key in [campaign]", head, ("vehicle", *_PLAIN, "until_percent", "until_part"))
    _known("key in [outputs]", outputs, ("names", "dead_bands"))
    for key in ("vehicle", "cases"):
        if key not in head:
            raise InputError(f"a key is missing in [campaign]: {key}")
    until = head.get("until_part")
    if "until_percent" in head:
        until = number("until_percent", head["until_percent"]) / _PERCENT
    given: dict[str, Any] = {key: head[key] for key in _PLAIN if key in head}
    for key, field in (("names", "outputs"), ("dead_bands", "dead_bands")):
        if key in outputs:
            if not isinstance(outputs[key], list):
                raise InputError(f"{key} in [outputs] must be a list; got {outputs[key]!r}")
            given[field] = tuple(outputs[key])
    limit = _quantity("[question]", asked, "limit", _ANGLE, required=False)
    _known("key in [question]", asked, ("probability", "confidence"))
    return Campaign(
        vehicle=_vehicle(head["vehicle"], folder),
        wind=_wind(dict(document.get("wind", {})), folder),
        dispersions=_dispersions(document.get("dispersion", []), document.get("correlation", [])),
        limit=limit,
        flight=_flight(dict(document["flight"])) if "flight" in document else None,
        until=until,
        **given,
        **asked,
    )


def document_of(campaign: Campaign) -> dict[str, Any]:
    """Return the document of a campaign, in SI units and complete in itself.

    `parse_campaign` makes the same campaign of it.
    """
    vehicle, until = campaign.vehicle, campaign.until
    head = {key: getattr(campaign, key) for key in _PLAIN} | {
        "vehicle": {
            f.name: getattr(vehicle, f.name)
            for f in fields(Vehicle)
            if getattr(vehicle, f.name) is not None
        }
    }
    wind = campaign.wind
    question = {"probability": campaign.probability, "confidence": campaign.confidence}
    flown = {} if campaign.flight is None else {"flight": _flight_table(campaign.flight)}
    return flown | {
        "campaign": head | ({} if until is None else {"until_part": until}),
        "wind": {"time_s": wind.time.tolist(), "angle_rad": wind.angle.tolist()}
        if isinstance(wind, WindEnsemble)
        else {"shape": wind.shape, "peak_rad": wind.peak, "duration_s": wind.duration},
        "outputs": {"names": list(campaign.outputs), "dead_bands": list(campaign.dead_bands)},
        "question": question | ({} if campaign.limit is None else {"limit_rad": campaign.limit}),
        "dispersion": [
            {
                "parameter": one.parameter,
                "shape": one.shape,
                ("part" if one.relative else "spread"): one.spread,
            }
            for one in campaign.dispersions.each
        ],
        "correlation": _pairs(campaign.dispersions),
    }


def _vehicle(source: Any, folder: Path) -> Vehicle:
    if isinstance(source, dict):
        _known("key in [campaign.vehicle]", source, [f.name for f in fields(Vehicle)])
        try:
            return Vehicle(**source)
        except TypeError:
            raise InputError("[campaign.vehicle] must hold every number of a Vehicle") from None
    if not isinstance(source, str):
        raise InputError(f"vehicle must be a name or a path; got {source!r}")
    beside = folder / source
    return load_vehicle(beside if source not in list_vehicles() and beside.exists() else source)


def _wind(table: dict[str, Any], folder: Path) -> ShapedWind | WindEnsemble:
    if "file" in table:
        _known("key in [wind]", table, ("file", "unit"))
        factor = _ANGLE[one_of("unit in [wind]", table.get("unit", "deg"), _ANGLE)]
        time, angle = _read_winds(folder / str(table["file"]))
        return WindEnsemble(time, angle * factor)
    if "angle_rad" in table:
        _known("key in [wind]", table, ("time_s", "angle_rad"))
        return WindEnsemble(np.array(table.get("time_s")), np.array(table["angle_rad"]))
    rest = dict(table)
    shape = rest.pop("shape", "triangular")
    peak = _quantity("[wind]", rest, "peak", _ANGLE)
    duration = _quantity("[wind]", rest, "duration", _TIME)
    _known("key in [wind]", rest, ("shape", "file", "unit"))
    return ShapedWind(shape, float(peak or 0.0), float(duration or 0.0))


def _flight(table: dict[str, Any]) -> Flight:
    law = table.pop("law", "autopilot")
    given: dict[str, Any] = {}
    for name, units in _FLIGHT.items():
        value = _quantity("[flight]", table, name, units, required=name == "deflection_limit")
        if value is not None:
            given[name] = value
    _known("key in [flight]", table, ("law", *_keys(_FLIGHT)))
    return Flight(law=law, **given)


def _flight_table(flight: Flight) -> dict[str, Any]:
    return {"law": flight.law} | {
        key: getattr(flight, name)
        for name, units in _FLIGHT.items()
        for key in _keys({name: units})[:1]
        if getattr(flight, name) is not None and np.isfinite(getattr(flight, name))
    }


def _keys(quantities: Mapping[str, Mapping[str, float]]) -> list[str]:
    return [f"{k}_{unit}" if unit else k for k, units in quantities.items() for unit in units]


def _read_winds(path: Path) -> tuple[Any, Any]:
    """Times [s] from the first column, and one wind for each further column."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            rows = [row for row in csv.reader(stream) if row]
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path} cannot be read: {error}") from None
    try:
        table = np.array([[float(cell) for cell in row] for row in rows[1:]])
    except ValueError:
        raise InputError(f"{path} must hold numbers in equal rows below its headings") from None
    if not rows or rows[0][0].strip() != "time_s" or table.ndim != 2 or table.shape[1] < 2:
        raise InputError(f"{path} must have a first column time_s and one for each wind")
    return table[:, 0], table[:, 1:].T


def _dispersions(each: Any, correlation: Any) -> Dispersions:
    for name, rows in (("dispersion", each), ("correlation", correlation)):
        if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
            raise InputError(f"{name} must be given as [[{name}]], once for each")
    made = tuple(_dispersion(row) for row in each)
    names = [one.parameter for one in made]
    if not correlation:
        return Dispersions(made)
    matrix = np.eye(len(made))
    for row in correlation:
        _known("key in [[correlation]]", row, ("between", "coefficient"))
        between = row.get("between")
        if not isinstance(between, list) or len(between) != 2 or between[0] == between[1]:
            raise InputError(f"between in [[correlation]] must name two parameters; got {between}")
        i, j = (names.index(one_of("between in [[correlation]]", name, names)) for name in between)
        matrix[i, j] = matrix[j, i] = number("coefficient", row.get("coefficient"))
    return Dispersions(made, tuple(map(tuple, matrix.tolist())))


def _dispersion(row: dict[str, Any]) -> Dispersion:
    rest = dict(row)
    parameter = one_of("parameter in [[dispersion]]", rest.pop("parameter", None), PARAMETERS)
    units = UNITS[_SPREADS[parameter]] if parameter in _SPREADS else {"": 1.0}
    shape = rest.pop("shape", "normal")
    keys = dict(zip(_keys({"spread": units}), units.values(), strict=True))
    spreads = {"part": 1.0, "percent": 1.0 / _PERCENT, "spread": 1.0} | keys
    _known(f"key in [[dispersion]] of {parameter}", rest, spreads)
    if len(rest) != 1:
        raise InputError(
            f"the spread of {parameter} must be given once, as percent or as {', '.join(keys)}"
        )
    (key, value) = rest.popitem()
    spread = number(f"{key} of {parameter}", value) * spreads[key]
    return Dispersion(parameter, shape, spread, relative=key in ("part", "percent"))


def _pairs(dispersions: Dispersions) -> list[dict[str, Any]]:
    matrix, names = dispersions.correlation or (), dispersions.parameters
    return [
        {"between": [names[i], names[j]], "coefficient": row[j]}
        for i, row in enumerate(matrix)
        for j in range(i)
        if row[j]
    ]


def _quantity(
    where: str, table: dict[str, Any], name: str, units: Mapping[str, float], required: bool = True
) -> float | None:
    """Take a number with its unit in its key out of a table."""
    keys = dict(zip(_keys({name: units}), units.values(), strict=True))
    found = [key for key in keys if key in table]
    if len(found) > 1 or (required and not found):
        raise InputError(f"{where} must give {name} once, as {' or '.join(keys)}")
    return number(found[0], table.pop(found[0])) * keys[found[0]] if found else None


def _known(what: str, given: Mapping[str, Any], known: Any) -> None:
    for key in given:
        if key not in known:
            near = get_close_matches(key, list(known), n=2, cutoff=0.5)
            hint = f"did you mean {' or '.join(near)}?" if near else f"known are {', '.join(known)}"
            raise InputError(f"unknown {what}: {key!r}; {hint}")
