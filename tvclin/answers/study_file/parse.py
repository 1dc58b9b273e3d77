"""The tables of a study file: from a document to its plan."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from tvclin.answers.availability.growth import PairGrowth
from tvclin.answers.availability.request import AVAILABILITY_TABLE, AvailabilityRequest
from tvclin.answers.campaign.file import (
    beside,
    design_of,
    dispersions_of,
    nozzle_of,
    parse_campaign,
    question_of,
    subject_of,
)
from tvclin.answers.document import DOCUMENT_TABLE, Document
from tvclin.answers.load import LOAD_TABLE, LoadBound
from tvclin.answers.sizing.request import SIZE_TABLE, SizingRequest, SoundingRequest
from tvclin.answers.study_file.plan import StudyPlan
from tvclin.answers.trials import LAWS_TABLE, LawsRequest
from tvclin.ascent.schedule_file import SOURCE_TABLE, load_schedule, schedule_of
from tvclin.base.errors import Faults, InputError, one_of, shown
from tvclin.base.errors import text as printable_text
from tvclin.base.files import called
from tvclin.control.margins.criteria import CRITERIA, CRITERIA_TABLE, Criteria
from tvclin.vehicle.vehicle_file import source_tables
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.soundings.sounding_files import read_sounding, read_soundings
from tvclin.winds.wind_file import (
    GUST_TABLE,
    SOUNDING,
    SOUNDING_TABLE,
    is_wind_from_gust,
    peak_speed_of,
    wind_for_vehicle,
    wind_tables,
    winds_of,
)


def parse_study(document: Mapping[str, Any], folder: Path = Path()) -> StudyPlan:
    """Return the plan of a document; see `load_study`.

    A campaign that stands in it as well is checked too.
    """
    subject = subject_of(document, folder)
    if "cases" in document.get("campaign", {}):
        parse_campaign(document, folder)
    head, drawn = document.get("study", {}), document.get("campaign", {})
    given = {key: head[key] for key in ("dead_band", "switch") if key in head}
    given |= {key: drawn[key] for key in ("cases", "seed", "method") if key in drawn}
    parts: dict[str, Callable[[], Any]] = {
        "wind": lambda: _wind(document, folder, subject),
        "sizing": lambda: _sizing(document, folder),
        "availability": lambda: _availability(document, folder),
        "laws": lambda: LAWS_TABLE.made(document, lambda one: LawsRequest(**LAWS_TABLE.read(one))),
        "nozzle": lambda: nozzle_of(document),
        "load": lambda: LOAD_TABLE.made(document, lambda one: LoadBound(**LOAD_TABLE.read(one))),
        "design": lambda: design_of(document),
        "criteria": lambda: CRITERIA_TABLE.made(document, _criteria),
        "document": lambda: DOCUMENT_TABLE.made(document, Document.from_table),
    }
    if "dispersion" in document:
        parts["dispersions"] = lambda: dispersions_of(document)
    faults, found = Faults(), {}
    for name, make in parts.items():
        with faults.kept():
            found[name] = make()
    faults.tell()
    return StudyPlan(**subject, **found, **question_of(document), **given)


def _wind(document: Mapping[str, Any], folder: Path, subject: Mapping[str, Any]) -> Any:
    """Return the wind of a study as its vehicle meets it, with its gust."""
    wind, plane = winds_of(document, folder)[0], subject.get("plane", "pitch")
    return wind_for_vehicle(document, wind, subject["vehicle"], plane)


def _criteria(table: dict[str, Any]) -> Criteria:
    limits = CRITERIA_TABLE.read(table)
    name = limits.pop("name", None)
    if name is None:
        return Criteria.custom("own", "the study file", **limits)
    named = CRITERIA[one_of("name in [criteria]", name, CRITERIA)]
    return named.with_limits("the study file", **limits)


def _sizing(document: Mapping[str, Any], folder: Path) -> SizingRequest | None:
    """Return what a document asks of a flight; None without [schedule] and [size]."""
    measured = [_sounding(table, folder) for table in wind_tables(document) if SOUNDING in table]
    soundings = dict(measured)
    if len(soundings) < len(measured):
        names = ", ".join(name for name, _ in measured)
        raise InputError(f"two soundings have one name among {names}; give each its own name")
    if "schedule" not in document and "size" not in document:
        if soundings:
            raise InputError("a sounding needs a flight: add [schedule], see tvclin init --study")
        return None
    given = SIZE_TABLE.read(SIZE_TABLE.one(document))
    if not isinstance(given.get("varying", False), bool):
        raise InputError(f"varying in [size] must be true or false; got {shown(given['varying'])}")
    others = winds_of(document, folder)[1:]
    if (speed := peak_speed_of(document)) is not None:
        if others and "peak_speed" not in given:
            raise InputError(
                "on a flight all pulses have one speed: give peak_speed_m_per_s in [size], or"
                " peak_deg in each [[wind]]"
            )
        given = {"peak_speed": speed} | given
    return SizingRequest(
        **_flight(document, folder),
        others=tuple(one for one in others if isinstance(one, ShapedWind)),
        soundings=soundings,
        gust_speed=_gust_speed(document),
        **given,
    )


def _availability(document: Mapping[str, Any], folder: Path) -> AvailabilityRequest | None:
    """Return what a document asks of an archive of soundings; None without [availability]."""
    if "availability" not in document:
        return None
    given = AVAILABILITY_TABLE.read(AVAILABILITY_TABLE.one(document))
    AVAILABILITY_TABLE.need(given, ("archive", "azimuth"))
    archive = given.pop("archive")
    names = archive if isinstance(archive, list) else [archive]
    if not names or not all(isinstance(one, str) and one.isprintable() for one in names):
        raise InputError(
            "archive in [availability] must be a station file, a folder, or a list of them; got"
            f" {shown(archive)}"
        )
    hours = given.pop("persistence_hours", None)
    if hours is not None:
        if "persistence" in given:
            raise InputError("[availability] has an angle and hours of persistence; keep one")
        given["persistence"] = PairGrowth(hours)
    keys = ("months", "years", "station", "in_order")
    wanted = {key: given.pop(key) for key in keys if key in given}
    if "dates" in given:
        wanted["dates"] = folder / str(given.pop("dates"))
    offset = given.pop("utc_offset_hours", 0.0)
    return AvailabilityRequest(
        flight=_flight(document, folder)["schedule"],
        soundings=read_soundings([folder / one for one in names], utc_offset=offset, **wanted),
        gust_speed=_gust_speed(document),
        **given,
    )


def _gust_speed(document: Mapping[str, Any]) -> float | None:
    """The speed [m/s] of [gust]; None where it has an angle."""
    on_top = "gust" in document and not is_wind_from_gust(document)
    return GUST_TABLE.read(GUST_TABLE.one(document)).get("peak_speed") if on_top else None


def _flight(document: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """The flight of [schedule] and whose it is; that of the study's vehicle without it."""
    table = document.get("schedule", {})
    lists = "time_s" in table or any(isinstance(value, list) for value in table.values())
    if lists and "source" in table:
        raise InputError("[schedule] has a source, and the flight itself in lists; keep one")
    if lists:
        return {"schedule": schedule_of(table, "[schedule]"), "source": "the lists in [schedule]"}
    SOURCE_TABLE.read(table)
    study, campaign = document.get("study", {}), document.get("campaign", {})
    own = study.get("vehicle", campaign.get("vehicle"))
    source = table.get("source", own)
    if not isinstance(source, str) or not source.isprintable():
        raise InputError(
            "[schedule] needs a source: a CSV file, or a vehicle with a table [flight]; got"
            f" {shown(source)}"
        )
    found = {"schedule": load_schedule(beside(source, folder)), "source": source}
    named = isinstance(own, str)
    same = named and Path(beside(source, folder)) == Path(beside(own, folder))
    if same or not _is_vehicle(beside(source, folder)):
        return found
    return found | {"another": own if named else own.get("name") or "given by its numbers"}


def _is_vehicle(source: str | Path) -> bool:
    """Whether the source of a flight is a vehicle, not a table of its times."""
    return "vehicle" in source_tables(source)


def _sounding(table: dict[str, Any], folder: Path) -> tuple[str, SoundingRequest]:
    given = SOUNDING_TABLE.read(table)
    file = table[SOUNDING]
    if not isinstance(file, str) or not file.isprintable():
        raise InputError(f"sounding in [[wind]] must be a path; got {shown(file)}")
    for key in ("name", "format", "time", "units"):
        printable_text(f"{key} in [[wind]]", table.get(key, ""))
    how = {key: given.get(key) for key in ("format", "time", "units", "above_ground")}
    profile = read_sounding(folder / file, **how)
    named = Path(file).name
    whole = called(folder / file)  # the name alone: the page is the same from another folder
    profile = replace(profile, source=profile.source.replace(whole, named, 1))
    return table.get("name") or named, SoundingRequest(profile, given["azimuth"])
