"""Campaign files: TOML in, a `Campaign` out; and the tables that study files share with them."""

from collections.abc import Mapping
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from tvclin.answers.availability.request import AVAILABILITY_TABLE
from tvclin.answers.campaign.dispersions import (
    CORRELATION_TABLE,
    DEFAULT_DISPERSIONS,
    DISPERSION_TABLE,
    Dispersion,
    Dispersions,
    spread_table,
)
from tvclin.answers.campaign.plan import CAMPAIGN_TABLE, OUTPUTS_TABLE, QUESTION_TABLE, Campaign
from tvclin.answers.document import DOCUMENT_TABLE
from tvclin.answers.load import LOAD_TABLE
from tvclin.answers.nozzle import NOZZLE_TABLE, Nozzle
from tvclin.answers.sizing.request import SIZE_TABLE
from tvclin.answers.study import STUDY_TABLE
from tvclin.answers.trials import LAWS_TABLE
from tvclin.ascent.schedule_file import SOURCE_TABLE, load_vehicle_at
from tvclin.base.errors import Faults, InputError, between, naming, number, one_of, shown
from tvclin.base.errors import path as a_path
from tvclin.base.files import called, exists, read_text, tables_of
from tvclin.base.tables import FileTable, known
from tvclin.control.autopilot.design_rules import AUTOPILOT_TABLE, AutopilotDesign
from tvclin.control.margins.criteria import CRITERIA_TABLE
from tvclin.vehicle.linear_vehicle import AnyVehicle
from tvclin.vehicle.vehicle_file import HEADINGS, build_vehicle, list_vehicles
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.wind_file import GUST_TABLE, WIND_TABLE, wind_for_vehicle, winds_of

_OF_STUDIES = (
    *(STUDY_TABLE, SIZE_TABLE, AVAILABILITY_TABLE, LAWS_TABLE, AUTOPILOT_TABLE),
    *(CRITERIA_TABLE, DOCUMENT_TABLE, LOAD_TABLE),
)
"""Tables that no campaign reads; what stands in them is checked nevertheless."""
_SINGLE = (
    *_OF_STUDIES,
    CAMPAIGN_TABLE,
    GUST_TABLE,
    SOURCE_TABLE,
    OUTPUTS_TABLE,
    QUESTION_TABLE,
    NOZZLE_TABLE,
)
TABLES = (*_SINGLE, WIND_TABLE, DISPERSION_TABLE, CORRELATION_TABLE)
"""Of a file that drives studies, campaigns and pages; each of these reads those that concern it."""
_SUBJECT = ("vehicle", "time_s", "model", "plane", "sign")
"""What is studied: keys of [study], or of [campaign] where there is no [study]."""
_FIELDS = {"names": "outputs"}
"""Fields of `Campaign` of another name than their keys."""


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
    file = a_path("path", path)
    start = f"write a campaign file with: tvclin campaign init {called(file)}"
    document = tables_of(read_text(file, "a campaign file", start), str(file))
    with naming(called(file)):
        return parse_campaign(document, file.parent)


def template() -> str:
    """Return a commented campaign file to fill in."""
    return files("tvclin.answers.campaign").joinpath("template.txt").read_text(encoding="utf-8")


def parse_campaign(document: Mapping[str, Any], folder: Path = Path()) -> Campaign:
    """Return the campaign of a document; see `load_campaign`."""
    subject = subject_of(document, folder)
    head = CAMPAIGN_TABLE.read(CAMPAIGN_TABLE.one(document))
    head.pop("time", None)
    study = STUDY_TABLE.one(document)
    outputs: dict[str, Any] = {}
    if "dead_band" in study:
        outputs["dead_bands"] = [number("dead_band", study["dead_band"], between(0.0, 1.0))]
    outputs |= OUTPUTS_TABLE.read(OUTPUTS_TABLE.one(document))
    CAMPAIGN_TABLE.need(head, ["cases"])
    wind = winds_of(document, folder)[0]
    vehicle, plane = subject["vehicle"], subject.get("plane", "pitch")
    wind = wind_for_vehicle(document, wind, vehicle, plane)
    nozzle = nozzle_of(document)
    assumed = "dispersion" not in document and isinstance(wind, ShapedWind)
    return Campaign(
        nozzle=nozzle,
        design=design_of(document),
        wind=wind,
        dispersions=DEFAULT_DISPERSIONS if assumed else dispersions_of(document),
        **(head | subject),
        **{_FIELDS.get(key, key): value for key, value in outputs.items()},
        **question_of(document),
    )


def subject_of(document: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return what is studied: the vehicle, and model and plane where they are given.

    They stand in [study] or in [campaign], so that one file serves both.
    """
    if not document:
        raise InputError(
            "the file is neither a vehicle file (it has no [vehicle]) nor a study (no [study])"
        )
    _check_tables(document, folder)
    each = {table: table.one(document) for table in _SINGLE}
    if not {"study", "campaign"} & document.keys():
        raise InputError("[study] is missing: it names the vehicle")
    study, campaign = each[STUDY_TABLE], each[CAMPAIGN_TABLE]
    for key in _SUBJECT:
        if key in study and key in campaign:
            raise InputError(f"{key} is given in [study] and in [campaign]; keep one")
    found = {key: table[key] for table in (study, campaign) for key in _SUBJECT if key in table}
    where = STUDY_TABLE if "study" in document else CAMPAIGN_TABLE
    where.need(found, ["vehicle"])
    time = found.pop("time_s", None)
    if time is not None:
        time = number("time_s", time)
    return found | {"vehicle": _vehicle(found["vehicle"], folder, where.name, time)}


def _check_tables(document: Mapping[str, Any], folder: Path) -> None:
    """Raise `InputError` for all that is at fault in the tables of a file, a line for each."""
    faults = Faults()
    with faults.kept():
        vehicle = () if {"study", "campaign"} & document.keys() else HEADINGS
        known("table", document, [*vehicle, *(table.name for table in TABLES)])
    for table in _SINGLE:
        with faults.kept():
            given = table.one(document)
            if table is SOURCE_TABLE:
                continue  # it may hold a whole flight
            if table.name in document or table in _OF_STUDIES:
                _at_home(table, given)
                table.read(given)
    with faults.kept():
        if "wind" in document:
            winds_of(document, folder)
    with faults.kept():
        dispersions_of(document)
    faults.tell()


def _at_home(table: FileTable, given: Mapping[str, Any]) -> None:
    """Raise `InputError` for keys that another table has, and say which."""
    faults = Faults()
    for key in given:
        homes = [one.heading for one in TABLES if key in one.every_key]
        with faults.kept():
            if homes and key not in (*table.every_key, *table.quantities):
                raise InputError(f"{key} stands in {' or '.join(homes)}, not in {table.heading}")
    faults.tell()


def question_of(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return probability and confidence where they are given."""
    return QUESTION_TABLE.read(QUESTION_TABLE.one(document))


def nozzle_of(document: Mapping[str, Any]) -> Nozzle:
    """Return what the table [nozzle] says."""
    return NOZZLE_TABLE.made(document, Nozzle.from_table) or Nozzle()


def _vehicle(source: Any, folder: Path, where: str, time: float | None) -> AnyVehicle:
    if isinstance(source, dict):
        if time is not None:
            raise InputError(f"time_s is that of a flight schedule; take it out of [{where}]")
        return build_vehicle(source, f"[{where}.vehicle]")
    if not isinstance(source, str) or not source.isprintable():
        raise InputError(f"vehicle must be a name or a path; got {shown(source)}")
    return load_vehicle_at(beside(source, folder), time)


def beside(source: str, folder: Path) -> str | Path:
    """The name of a vehicle of the package, or the path of a file, in the folder if it is there."""
    path = folder / source
    return path if source not in list_vehicles() and exists(path) else source


def design_of(document: Mapping[str, Any]) -> AutopilotDesign | None:
    """Return what the table [autopilot] asks for; None without it."""
    return AUTOPILOT_TABLE.made(document, AutopilotDesign.from_table)


def dispersions_of(document: Mapping[str, Any]) -> Dispersions:
    """Return the dispersions of the tables [[dispersion]] and [[correlation]]."""
    rows = DISPERSION_TABLE.each(document)
    correlation = CORRELATION_TABLE.each(document)
    made, faults = [], Faults()
    for row in rows:
        with faults.kept():
            made.append(_dispersion(row))
    faults.tell()
    names = [one.parameter for one in made]
    if not correlation:
        return Dispersions(tuple(made))
    matrix = np.eye(len(made))
    for row in correlation:
        given = CORRELATION_TABLE.read(row)
        between = given.get("between")
        if not isinstance(between, list) or len(between) != 2 or between[0] == between[1]:
            raise InputError(
                f"between in [[correlation]] must name two parameters; got {shown(between)}"
            )
        i, j = (names.index(one_of("between in [[correlation]]", name, names)) for name in between)
        matrix[i, j] = matrix[j, i] = number("coefficient", given.get("coefficient", ""))
    return Dispersions(tuple(made), tuple(map(tuple, matrix.tolist())))


def _dispersion(row: dict[str, Any]) -> Dispersion:
    table = spread_table(row.get("parameter"))
    given = table.read(row)
    parameter, shape = given.pop("parameter"), given.pop("shape", "normal")
    if len(given) != 1:
        raise InputError(
            f"the spread of {parameter} must be given once, as percent or as"
            f" {table.spelled('spread').replace(' or ', ', ')}"
        )
    ((name, spread),) = given.items()
    return Dispersion(parameter, shape, spread, relative=name != "spread")
