"""Campaign files: the `Campaign` of a TOML file, and the tables that study files share with it."""

from collections.abc import Mapping
from dataclasses import replace
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.schedule import FlightSchedule
from tvclin.ascent.schedule_file import (
    SOURCE_TABLE,
    load_schedule,
    load_vehicle_at,
    schedule_of,
    with_structure,
)
from tvclin.base.errors import Faults, InputError, between, naming, number, one_of, shown
from tvclin.base.errors import path as a_path
from tvclin.base.errors import text as printable_text
from tvclin.base.files import EditedSource, called, exists, read_text, tables_of
from tvclin.base.tables import FileTable, check_known
from tvclin.case.case import FLIGHT_SAMPLE_RATE_HZ
from tvclin.case.load import LOAD_TABLE
from tvclin.case.nozzle import NOZZLE_TABLE, USUAL_ACTUATOR, Nozzle
from tvclin.case.turbulence import TURBULENCE_TABLE, turbulence_of
from tvclin.control.autopilot.design_rules import AUTOPILOT_TABLE, AutopilotDesign
from tvclin.control.autopilot.gain_schedule import (
    design_at,
    even_times,
    flight_actuator,
    flight_autopilot,
)
from tvclin.control.margins.criteria import CRITERIA_TABLE
from tvclin.design.standard_trials import LAWS_TABLE
from tvclin.ensembles.availability.availability import AVAILABILITY_TABLE
from tvclin.ensembles.campaign.campaign_plan import (
    CAMPAIGN_TABLE,
    OUTPUTS_TABLE,
    QUESTION_TABLE,
    Campaign,
    FlightPlan,
)
from tvclin.ensembles.dispersions import (
    CORRELATION_TABLE,
    DEFAULT_DISPERSIONS,
    DISPERSION_TABLE,
    Dispersion,
    Dispersions,
    spread_table,
)
from tvclin.linear.plant import DEFAULT_MODEL, flexible_model
from tvclin.linear.system import LinearSystem
from tvclin.linear.system_file import read_system
from tvclin.requirement.flight.request import EVERY_S, SIZE_TABLE
from tvclin.studyfile.study_plan import DOCUMENT_TABLE, STUDY_TABLE, named_vehicle
from tvclin.vehicle.linear_vehicle import AnyVehicle, coefficients_of
from tvclin.vehicle.vehicle import STANDARD_GRAVITY, Vehicle
from tvclin.vehicle.vehicle_file import (
    HEADINGS,
    build_vehicle,
    is_schedule,
    list_vehicles,
    source_tables,
)
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.soundings.sounding_files import READING_TABLE
from tvclin.winds.wind_file import (
    GUST_TABLE,
    WIND_TABLE,
    is_wind_measured,
    wind_for_vehicle,
    winds_of,
)

PLANT_TABLE = FileTable("[plant]", words=("system",))
CONTROLLER_TABLE = FileTable("[controller]", words=("system",))
"""Files of a plant and of a controller in state space."""
_STUDY_TABLES = (
    *(STUDY_TABLE, SIZE_TABLE, AVAILABILITY_TABLE, LAWS_TABLE, AUTOPILOT_TABLE),
    *(CRITERIA_TABLE, DOCUMENT_TABLE, LOAD_TABLE, TURBULENCE_TABLE, READING_TABLE),
    *(PLANT_TABLE, CONTROLLER_TABLE),
)
"""Tables that no campaign reads; their keys are checked nevertheless."""
_SINGLE_TABLES = (
    *_STUDY_TABLES,
    CAMPAIGN_TABLE,
    GUST_TABLE,
    SOURCE_TABLE,
    OUTPUTS_TABLE,
    QUESTION_TABLE,
    NOZZLE_TABLE,
)
"""Tables that a file has at most once."""
TABLES = (*_SINGLE_TABLES, WIND_TABLE, DISPERSION_TABLE, CORRELATION_TABLE)
"""All tables of a file for studies, campaigns and pages, each of which reads some of them."""
_SUBJECT_KEYS = ("vehicle", "time_s", "model", "plane", "sign")
"""Keys of vehicle, model and plane, in [study] or in [campaign]."""
CASES = 2000
"""Default number of cases."""
_FIELDS = {"names": "outputs"}
"""Fields of `Campaign` by key, where the two names differ."""


def load_campaign(path: str | PathLike[str]) -> Campaign:
    """Return the campaign that a TOML file describes, by default of 2000 cases.

    Parameters
    ----------
    path : str or path
        The file; the paths in it are relative to its folder. `template` shows one.

    Raises
    ------
    InputError
        For a file that cannot be read, is not TOML, or has an unknown key (similar keys are
        suggested), and as `Campaign`. One sentence says which and how to correct it.
    """
    file = a_path("path", path)
    start = f"write a campaign file with: tvclin init --campaign {called(file)}"
    if isinstance(path, EditedSource):
        document = tables_of("", path)
    else:
        document = tables_of(read_text(file, "a campaign file", start), str(file))
    with naming(called(file)):
        return parse_campaign(document, file.parent)


def template() -> str:
    """Return a commented campaign file to fill in."""
    return files("tvclin.studyfile").joinpath("campaign_template.txt").read_text(encoding="utf-8")


def parse_campaign(document: Mapping[str, Any], folder: Path = Path()) -> Campaign:
    """Return the campaign of a document; `folder`: where the files that it names are.

    `document`: tables of the file by name. In a pulse the default dispersions are assumed where the
    file has none. With ``along = true`` the cases fly along the whole flight, and the output is
    that flight. `InputError` for an unknown key, and for values out of range.
    """
    subject = subject_of(document, folder)
    if PLANT_TABLE.name in document:
        raise InputError(
            "a campaign takes no [plant], whose matrices are one vehicle; leave the table out"
            " (--set plant none)"
        )
    design = design_of(document, folder)
    _ = turbulence_of(document, folder)  # refuses values out of range
    options = {"cases": CASES} | CAMPAIGN_TABLE.read(CAMPAIGN_TABLE.one(document))
    options.pop("time", None)  # the vehicle has it
    along = options.pop("along", False)
    if not isinstance(along, bool):
        raise InputError(f"along in [campaign] must be true or false; got {shown(along)}")
    if not along and design is not None and design.schedule is not None:
        raise InputError(
            "a campaign of one flight time takes no schedule and no filter with a mode; add along ="
            " true to [campaign], for flights along the whole flight"
        )
    study = STUDY_TABLE.one(document)
    outputs: dict[str, Any] = {"names": ("flight",)} if along else {}
    if "dead_band" in study:
        outputs["dead_bands"] = [number("dead_band", study["dead_band"], between(0.0, 1.0))]
    outputs |= OUTPUTS_TABLE.read(OUTPUTS_TABLE.one(document))
    wind = winds_of(document, folder)[0]
    vehicle, plane = subject["vehicle"], subject.get("plane", "pitch")
    wind = wind_for_vehicle(document, wind, vehicle, plane)
    subject |= with_flight_data(vehicle, nozzle_of(document), document, folder)
    nozzle = subject.pop("nozzle")
    assumed = "dispersion" not in document and isinstance(wind, ShapedWind)
    if along:
        options["along"] = _along(document, folder, design, nozzle, subject)
        time = getattr(vehicle, "time", None)
        if design is not None and time is not None:
            design = design_at(design, options["along"].flight, float(time))
    return Campaign(
        nozzle=nozzle,
        design=design,
        controller=system_of(document, CONTROLLER_TABLE, folder),
        wind=wind,
        dispersions=DEFAULT_DISPERSIONS if assumed else dispersions_of(document),
        **(options | subject),
        **{_FIELDS.get(key, key): value for key, value in outputs.items()},
        **question_of(document),
    )


def _along(
    document: Mapping[str, Any],
    folder: Path,
    design: AutopilotDesign | None,
    nozzle: Nozzle,
    subject: Mapping[str, Any],
) -> FlightPlan:
    """Return the flight and the autopilot of a campaign along a flight.

    `document`: tables of the file; `folder`: where the files that it names are. `design`: autopilot
    design; None for `canonical_gains`. `nozzle`: nozzle with its actuator. `subject`: vehicle,
    model and plane by field. A rule for the gains is applied at even flight times, of `every_s` in
    [size].
    """
    flight: FlightSchedule = flight_of(document, folder)["schedule"]
    size = SIZE_TABLE.read(SIZE_TABLE.one(document))
    gains = flight_autopilot(
        design or AutopilotDesign(),
        flight,
        even_times(*flight.span, size.get("every", EVERY_S)),
        actuator=nozzle.actuator,
        model=flexible_model(flight.structure, subject.get("model", DEFAULT_MODEL)),
        plane=subject.get("plane", "pitch"),
    )
    rate = gains.autopilot.sample_rate or FLIGHT_SAMPLE_RATE_HZ
    sampled = replace(gains.autopilot, sample_rate=rate)
    return FlightPlan(flight, replace(gains, autopilot=sampled))


def subject_of(document: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return vehicle, model, plane and sign of a document by field, where they are specified.

    They stand in [study] or in [campaign], so that one file serves both. `document`: tables of the
    file; `folder`: where the files that it names are.
    """
    if not document:
        raise InputError(
            "the file is neither a vehicle file (it has no [vehicle]) nor a study (no [study])"
        )
    _check_tables(document, folder)
    keys = {table: table.one(document) for table in _SINGLE_TABLES}
    if not {"study", "campaign"} & document.keys():
        raise InputError(
            '[study] or [campaign] is missing: it names the vehicle, as vehicle = "my.toml"'
        )
    study, campaign = keys[STUDY_TABLE], keys[CAMPAIGN_TABLE]
    for key in _SUBJECT_KEYS:
        if key in study and key in campaign:
            raise InputError(f"{key} is given in [study] and in [campaign]; keep one")
    subject = {k: table[k] for table in (study, campaign) for k in _SUBJECT_KEYS if k in table}
    where = STUDY_TABLE if "study" in document else CAMPAIGN_TABLE
    if "vehicle" not in subject:
        raise InputError(f'a key is missing in {where.heading}: vehicle, as vehicle = "my.toml"')
    time = subject.pop("time_s", None)
    if time is not None:
        time = number("time_s", time)
    vehicle = _vehicle(subject["vehicle"], folder, where.name, time)
    return subject | {"vehicle": vehicle.rigid if is_rigid(document) else vehicle}


def flight_of(document: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the flight of a document by "schedule" and "source", its file or a text.

    A third key, "another", is the name of the study's vehicle where the flight is of another one.
    `document`: tables of the file; `folder`: where the files that it names are. The flight stands
    in [schedule] as lists over time_s, or as a source: a CSV file, or a vehicle with [flight].
    `InputError` for both, and for neither.
    """
    table = document.get("schedule", {})
    lists = "time_s" in table or any(isinstance(value, list) for value in table.values())
    if lists and "source" in table:
        raise InputError("[schedule] has a source, and the flight itself in lists; keep one")
    if lists:
        schedule = _as_specified(schedule_of(table, "[schedule]", folder), document)
        return {"schedule": schedule, "source": "the lists in [schedule]"}
    SOURCE_TABLE.read(table)
    vehicle = named_vehicle(document)
    source = table.get("source", vehicle)
    if not isinstance(source, str) or not source.isprintable():
        raise InputError(
            "[schedule] needs a source: a CSV file, or a vehicle with a table [flight]; got"
            f" {shown(source)}"
        )
    schedule = load_schedule(vehicle_source(source, folder))
    if "structure" in table:
        schedule = with_structure(schedule, table["structure"], folder)
    flight = {"schedule": _as_specified(schedule, document), "source": source}
    named, file = isinstance(vehicle, str), vehicle_source(source, folder)
    same = named and Path(file) == Path(vehicle_source(vehicle, folder))
    if same or "vehicle" not in source_tables(file):  # a file without [vehicle] is a flight alone
        return flight
    name = vehicle if named else vehicle.get("name") or _NAMELESS
    return flight | {"another": name}


_NAMELESS = "given by its numbers"
"""Name of a vehicle without one, in messages."""
_MAX_VEHICLE_DIFFERENCE = 0.05
"""Relative difference of a number of the vehicle from that of its flight that has a note."""


def differing_vehicle(vehicle: AnyVehicle, schedule: FlightSchedule) -> str:
    """Return the name of a vehicle whose flight has other numbers at its time, with one of them.

    Empty for a vehicle without a time of the flight, and where speed, and moment over inertia per
    angle of attack and per deflection (mu_alpha, mu_delta) in pitch agree. `vehicle`: that of the
    study. `schedule`: the flight.
    """
    first, last = schedule.span
    time = vehicle.time if isinstance(vehicle, Vehicle) else None
    if time is None or not first <= time <= last:
        return ""
    own, flown = (coefficients_of(v.rigid, "pitch") for v in (vehicle, schedule.at(float(time))))
    for name, unit in {"mu_alpha": "1/s^2", "mu_delta": "1/s^2", "velocity": "m/s"}.items():
        value, other = (float(getattr(c, name)) for c in (own, flown))
        if abs(value - other) > _MAX_VEHICLE_DIFFERENCE * max(abs(value), abs(other)):
            of_study = f"{name} {value:.4g} {unit} at {time:.4g} s, in the flight {other:.4g}"
            return f"{vehicle.name or _NAMELESS} ({of_study})"
    return ""


def with_flight_data(
    vehicle: AnyVehicle, nozzle: Nozzle, document: Mapping[str, Any], folder: Path
) -> dict[str, Any]:
    """Return "vehicle" and "nozzle", with structure and actuator of the flight at a time.

    The time is the vehicle's, time_s in its file. A structure of the vehicle file counts unless
    [schedule] names one. A flight of another vehicle, "another" of `flight_of`, changes neither.
    `document`: tables of the file; `folder`: where the files that it names are.
    """
    same = {"vehicle": vehicle, "nozzle": nozzle}
    table, time = document.get("schedule"), getattr(vehicle, "time", None)
    if not isinstance(vehicle, Vehicle):
        return same
    source = named_vehicle(document)
    named = isinstance(source, str) and is_schedule(vehicle_source(source, folder))
    if table is None and not named:  # neither the file nor its vehicle has a flight
        return same
    flight = flight_of(document, folder)
    schedule: FlightSchedule = flight["schedule"]
    if "another" in flight:
        return same
    if schedule.structure is not None and (
        vehicle.structure is None or "structure" in (table or {})
    ):
        if time is None:
            raise InputError(
                "the structure in [schedule] varies over the flight: the vehicle needs a time,"
                " time_s in its file"
            )
        vehicle = vehicle.replace(structure=schedule.at(time).structure)
    if time is not None:
        nozzle = with_flight_actuator(nozzle, schedule, time)
    return {"vehicle": vehicle, "nozzle": nozzle}


def with_flight_actuator(nozzle: Nozzle, flight: FlightSchedule, time: ArrayLike) -> Nozzle:
    """Return the nozzle with the actuator of a flight at a time [s], if the flight has one."""
    actuator = flight_actuator(flight, time)
    return nozzle if actuator is None else replace(nozzle, actuator=actuator)


def _as_specified(schedule: FlightSchedule, document: Mapping[str, Any]) -> FlightSchedule:
    """Return a flight schedule without what a document replaces: its structure, its actuator.

    The structure is left out of a rigid vehicle. An actuator in [nozzle] counts more than the
    flight's own, at a single time as over the flight; without one the nozzle has `USUAL_ACTUATOR`.
    """
    if is_rigid(document):
        schedule = replace(schedule, structure=None)
    if nozzle_of(document).actuator is not USUAL_ACTUATOR:
        schedule = replace(schedule, actuator_frequency=None, actuator_damping=None)
    return schedule


def is_rigid(document: Mapping[str, Any]) -> bool:
    """Return whether [study] of a document leaves out the structure of its vehicle."""
    rigid = STUDY_TABLE.one(document).get("rigid", False)
    if not isinstance(rigid, bool):
        raise InputError(f"rigid in [study] must be true or false; got {shown(rigid)}")
    return rigid


def _check_tables(document: Mapping[str, Any], folder: Path) -> None:
    """Raise `InputError` for all faults in the tables of a document, a line for each fault.

    `folder`: where the files that the document names are. Faults are a key outside all tables, an
    unknown table, keys and values of single tables, winds, and dispersions.
    """
    faults = Faults()
    with faults.collect():
        # a file without [study] and [campaign] may be a vehicle file
        vehicle_tables = () if {"study", "campaign"} & document.keys() else HEADINGS
        loose = [key for key, value in document.items() if not isinstance(value, dict | list)]
        if loose and loose[0] not in {*HEADINGS, *(table.name for table in TABLES)}:
            raise InputError(
                f"key {shown(loose[0])} stands in no table; write the table above it, such as"
                " [vehicle] or [study]"
            )
        check_known("table", document, [*vehicle_tables, *(table.name for table in TABLES)])
    for table in _SINGLE_TABLES:
        with faults.collect():
            keys = table.one(document)
            if table is SOURCE_TABLE:
                continue  # it may hold a whole flight
            if table.name in document or table in _STUDY_TABLES:
                _check_keys(table, keys)
                table.read(keys)
    with faults.collect():
        if "wind" in document and not is_wind_measured(document):
            winds_of(document, folder)
    with faults.collect():
        dispersions_of(document)
    faults.raise_all()


def _check_keys(table: FileTable, keys: Mapping[str, Any]) -> None:
    """Raise `InputError` for keys that belong to another table, and name that table.

    All are collected first, and raised together. A key of no table is left to the reader.
    """
    faults = Faults()
    for key in keys:
        homes = [other.heading for other in TABLES if key in other.every_key]
        with faults.collect():
            if homes and key not in (*table.every_key, *table.quantities):
                raise InputError(f"{key} stands in {' or '.join(homes)}, not in {table.heading}")
    faults.raise_all()


def question_of(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return probability and confidence by field, where the document specifies them."""
    return QUESTION_TABLE.read(QUESTION_TABLE.one(document))


def nozzle_of(document: Mapping[str, Any]) -> Nozzle:
    """Return the nozzle of [nozzle] in a document; without the table, one without any limit."""
    return NOZZLE_TABLE.made(document, Nozzle.from_table) or Nozzle()


def _vehicle(source: Any, folder: Path, where: str, time: float | None) -> AnyVehicle:
    """Return the vehicle of a table, of the package by name, or of a file by path.

    `source`: the table, name or path. `folder`: where relative paths begin. `where`: table that has
    `source`, for messages. `time`: flight time [s] at which a flight schedule is taken.
    """
    if isinstance(source, dict):
        if time is not None:
            raise InputError(f"time_s is that of a flight schedule; take it out of [{where}]")
        return build_vehicle(source, f"[{where}.vehicle]")
    if not isinstance(source, str) or not source.isprintable():
        raise InputError(f"vehicle must be a name or a path; got {shown(source)}")
    return load_vehicle_at(vehicle_source(source, folder), time)


def vehicle_source(source: str, folder: Path) -> str | Path:
    """Return a vehicle's name or path: `source` itself, or its file in `folder` if that exists."""
    if isinstance(source, EditedSource):
        return source
    path = folder / source
    return path if source not in list_vehicles() and exists(path) else source


def design_of(document: Mapping[str, Any], folder: Path) -> AutopilotDesign | None:
    """Return the autopilot design of [autopilot] in a document; None without the table.

    `folder`: where the file of a gain schedule is.
    """
    return AUTOPILOT_TABLE.made(document, lambda keys: AutopilotDesign.from_table(keys, folder))


def system_of(document: Mapping[str, Any], table: FileTable, folder: Path) -> LinearSystem | None:
    """Return the system of the file that a table of a document names; None without the table.

    `folder`: where that file is.
    """

    def read(keys: dict[str, Any]) -> LinearSystem:
        """Return the system of the file that the `keys` of the table name."""
        table.need(keys, ("system",))
        return read_system(folder / printable_text(f"system in {table.heading}", keys["system"]))

    return table.made(document, read)


def dispersions_of(document: Mapping[str, Any]) -> Dispersions:
    """Return the dispersions of the tables [[dispersion]] and [[correlation]] in a document.

    Each [[correlation]] is a coefficient between two of the parameters; other pairs have none, and
    the diagonal of the matrix is one. `InputError` for other than two different parameters.
    """
    rows = DISPERSION_TABLE.each(document)
    correlation = CORRELATION_TABLE.each(document)
    dispersions, faults = [], Faults()
    for row in rows:
        with faults.collect():
            dispersions.append(_dispersion(row))
    faults.raise_all()
    names = [row["parameter"] for row in rows]
    if not correlation:
        return Dispersions(tuple(dispersions))
    matrix = np.eye(len(dispersions))
    for row in correlation:
        keys = CORRELATION_TABLE.read(row)
        between = keys.get("between")
        if not isinstance(between, list) or len(between) != 2 or between[0] == between[1]:
            raise InputError(
                f"between in [[correlation]] must name two parameters; got {shown(between)}"
            )
        i, j = (names.index(one_of("between in [[correlation]]", name, names)) for name in between)
        matrix[i, j] = matrix[j, i] = number("coefficient", keys.get("coefficient", ""))
    return Dispersions(tuple(dispersions), tuple(map(tuple, matrix.tolist())))


def _dispersion(row: dict[str, Any]) -> Dispersion:
    """Return the distribution of a parameter, from the keys of a table [[dispersion]] in `row`.

    Its spread is the one key besides parameter and shape: relative as percent or part, or else in
    the unit of the parameter. A mass is dispersed as its weight. `InputError` for none and for
    several.
    """
    table = spread_table(row.get("parameter"))
    keys = table.read(row)
    parameter, shape = keys.pop("parameter"), keys.pop("shape", "normal")
    if len(keys) != 1:
        raise InputError(
            f"the spread of {parameter} must be given once, as percent or as"
            f" {table.spelled('spread').replace(' or ', ', ')}"
        )
    ((name, spread),) = keys.items()
    relative = name != "spread"
    if parameter == "mass":
        parameter, spread = "weight", spread if relative else spread * STANDARD_GRAVITY
    return Dispersion(parameter, shape, spread, relative=relative)
