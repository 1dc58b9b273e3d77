"""The tables of a study file: from a document to its plan."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from tvclin.ascent.measured_wind import GustOf, GustOfSpeed
from tvclin.ascent.wind_along import WINDOW_S, SoundingWind
from tvclin.base.errors import Faults, InputError, one_of, shown
from tvclin.base.errors import text as printable_text
from tvclin.base.files import called
from tvclin.base.lines import listed
from tvclin.case.load import LOAD_TABLE, LoadBound
from tvclin.case.turbulence import turbulence_of
from tvclin.control.autopilot.gain_schedule import design_at
from tvclin.control.margins.criteria import CRITERIA, CRITERIA_TABLE, Criteria
from tvclin.design.standard_trials import LAWS_TABLE, LawsRequest
from tvclin.ensembles.availability.availability import AVAILABILITY_TABLE, AvailabilityRequest
from tvclin.ensembles.availability.sounding_winds import PairGrowth
from tvclin.requirement.flight.request import SIZE_TABLE, SizingRequest, SoundingRequest
from tvclin.studyfile.campaign_file import (
    CONTROLLER_TABLE,
    PLANT_TABLE,
    design_of,
    differing_vehicle,
    dispersions_of,
    flight_of,
    is_rigid,
    nozzle_of,
    parse_campaign,
    question_of,
    subject_of,
    system_of,
    with_flight_data,
)
from tvclin.studyfile.study_plan import DOCUMENT_TABLE, Document, StudyPlan
from tvclin.winds.shaped import ShapedWind, refuse_gust_time
from tvclin.winds.soundings.sounding_files import SoundingReading, read_soundings
from tvclin.winds.wind_file import (
    GUST_TABLE,
    SOUNDING,
    SOUNDING_TABLE,
    WIND_TABLE,
    gust_of,
    is_wind_from_gust,
    is_wind_measured,
    wind_for_vehicle,
    wind_tables,
    wind_values,
    winds_of,
)


def parse_study(document: Mapping[str, Any], folder: Path = Path()) -> StudyPlan:
    """Return the plan of a document, whose campaign is checked too.

    `document`: tables of the file by name. `folder`: where the files that it names are. Each table
    is read on its own, so that an `InputError` has the faults of all. The structure and the
    actuator of the flight, and gains over it, are then taken at the time of the vehicle; the sizing
    keeps the gains over the flight.
    """
    subject = subject_of(document, folder)
    if "cases" in document.get("campaign", {}):
        parse_campaign(document, folder)
    study, campaign = document.get("study", {}), document.get("campaign", {})
    options = {key: study[key] for key in ("dead_band", "switch") if key in study}
    options |= {key: campaign[key] for key in ("cases", "seed", "method") if key in campaign}
    readers: dict[str, Callable[[], Any]] = {
        "wind": lambda: _wind(document, folder, subject),
        "reading": lambda: SoundingReading.of(document, folder),
        "sizing": lambda: _sizing(document, folder),
        "availability": lambda: _availability(document, folder),
        "laws": lambda: LAWS_TABLE.made(
            document, lambda keys: LawsRequest(**LAWS_TABLE.read(keys))
        ),
        "nozzle": lambda: nozzle_of(document),
        "load": lambda: LOAD_TABLE.made(document, lambda keys: LoadBound(**LOAD_TABLE.read(keys))),
        "turbulence": lambda: turbulence_of(document, folder),
        "design": lambda: design_of(document, folder),
        "plant_system": lambda: system_of(document, PLANT_TABLE, folder),
        "controller": lambda: system_of(document, CONTROLLER_TABLE, folder),
        "criteria": lambda: CRITERIA_TABLE.made(
            document, lambda keys: _criteria(keys, rigid=is_rigid(document))
        ),
        "document": lambda: DOCUMENT_TABLE.made(document, Document.from_table),
    }
    if "dispersion" in document:
        readers["dispersions"] = lambda: dispersions_of(document)
    faults, values = Faults(), {}
    for name, read in readers.items():
        with faults.collect():
            values[name] = read()
    faults.raise_all()
    data = with_flight_data(subject["vehicle"], values["nozzle"], document, folder)
    subject["vehicle"], values["nozzle"] = data["vehicle"], data["nozzle"]
    design, time = values["design"], getattr(subject["vehicle"], "time", None)
    if design is not None and design.schedule is not None:  # it varies over the flight
        if time is None:
            raise InputError("a schedule of gains and a notch at a mode need a vehicle with a time")
        flight = flight_of(document, folder)["schedule"]
        values["design"] = design_at(design, flight, float(time))
        if values["sizing"] is not None:
            values["sizing"] = replace(values["sizing"], scheduled_design=design)
    sizing = values["sizing"]
    # `another`: name of the study's vehicle where the flight is of another or has another number
    if sizing is not None and not sizing.another:
        another = differing_vehicle(subject["vehicle"], sizing.schedule)
        values["sizing"] = replace(sizing, another=another)
    return StudyPlan(**subject, **values, **question_of(document), **options)


def _wind(document: Mapping[str, Any], folder: Path, subject: Mapping[str, Any]) -> Any:
    """Return the wind of a study, with its gust: of one shape, or else the first sounding.

    `document`: tables of the file; `folder`: where the files that it names are. `subject`: vehicle
    and plane by field.
    """
    plane = subject.get("plane", "pitch")
    if is_wind_measured(document):
        reading = SoundingReading.of(document, folder)
        first_wind, *_ = wind_tables(document)
        name, sounding = _sounding(first_wind, folder, reading)
        return SoundingWind(
            name=name,
            **vars(sounding),
            schedule=flight_of(document, folder)["schedule"],
            window=reading.window or WINDOW_S,
            gust=_gust(document, plane),
        )
    wind, *_ = winds_of(document, folder)  # the wind of the case
    return wind_for_vehicle(document, wind, subject["vehicle"], plane)


def _criteria(table: dict[str, Any], *, rigid: bool) -> Criteria | None:
    """Return the criteria of the table [criteria]: a standard set, changed by its numbers.

    `rigid`: whether the vehicle is rigid; then without criteria of modes, None if none is left.
    """
    limits = CRITERIA_TABLE.read(table)
    standard = CRITERIA[one_of("name in [criteria]", limits.pop("name", "classic"), CRITERIA)]
    criteria = standard.with_limits(source="the study file", **limits)
    return criteria.without_mode_limits if rigid else criteria


def _sizing(document: Mapping[str, Any], folder: Path) -> SizingRequest | None:
    """Return the sizing request of a document; None without [schedule] and [size].

    `folder`: where the files that the document names are. The first pulse is the wind of the
    study, which is sized as well; further pulses are the others, and soundings stand by name.
    `InputError` for two soundings of one name, a sounding without a flight, and two pulses of which
    one is given by its speed.
    """
    reading = SoundingReading.of(document, folder)
    measured = [
        _sounding(table, folder, reading) for table in wind_tables(document) if SOUNDING in table
    ]
    soundings = dict(measured)
    if len(soundings) < len(measured):
        names = ", ".join(name for name, _ in measured)
        raise InputError(f"two soundings have one name among {names}; give each its own name")
    if "schedule" not in document and "size" not in document:
        if soundings and not is_wind_measured(document):
            raise InputError("a sounding needs a flight: add [schedule], see tvclin init --study")
        return None
    options = SIZE_TABLE.read(SIZE_TABLE.one(document))
    if not isinstance(options.get("varying", False), bool):
        raise InputError(
            f"varying in [size] must be true or false; got {shown(options['varying'])}"
        )
    pulses = [] if is_wind_measured(document) else winds_of(document, folder)
    others = pulses[1:]
    speed = next((wind.speed for wind in pulses if isinstance(wind, ShapedWind)), None)
    if speed is not None:
        if others and "peak_speed" not in options:
            raise InputError(
                "on a flight all pulses have one speed: give peak_speed_m_per_s in [size], or"
                " peak_deg in each [[wind]]"
            )
        options = {"peak_speed": speed} | options
    return SizingRequest(
        **flight_of(document, folder),
        pulse=bool(pulses),
        window=reading.window,
        others=tuple(wind for wind in others if isinstance(wind, ShapedWind)),
        soundings=soundings,
        gust_speed=_gust_speed(document),
        **options,
    )


def _availability(document: Mapping[str, Any], folder: Path) -> AvailabilityRequest | None:
    """Return the availability request of a document; None without [availability].

    `folder`: where the archive that the document names is. The persistence is the increase of the
    wind between balloon and launch: an angle [rad], or a time in hours, of which `PairGrowth` makes
    it from pairs of soundings. `InputError` for both, and for an archive that is no path.
    """
    if "availability" not in document:
        return None
    options = AVAILABILITY_TABLE.read(AVAILABILITY_TABLE.one(document))
    AVAILABILITY_TABLE.need(options, ("archive", "azimuth"))
    archive = options.pop("archive")
    names = archive if isinstance(archive, list) else [archive]
    if not names or not all(isinstance(name, str) and name.isprintable() for name in names):
        raise InputError(
            "archive in [availability] must be a station file, a folder, or a list of them; got"
            f" {shown(archive)}"
        )
    hours = options.pop("persistence_hours", None)
    if hours is not None:
        if "persistence" in options:
            raise InputError("[availability] has an angle and hours of persistence; keep one")
        options["persistence"] = PairGrowth(hours)
    keys = ("months", "years", "station", "in_order")
    selection = {key: options.pop(key) for key in keys if key in options}
    if "dates" in options:
        selection["dates"] = folder / str(options.pop("dates"))
    selection |= SoundingReading.of(document, folder).table
    offset = options.pop("utc_offset_hours", 0.0)
    return AvailabilityRequest(
        flight=flight_of(document, folder)["schedule"],
        soundings=read_soundings([folder / name for name in names], utc_offset=offset, **selection),
        gust_speed=_gust_speed(document),
        **options,
    )


def _gust(document: Mapping[str, Any], plane: str) -> GustOf | None:
    """Return the gust of [gust] in a document, on top of a sounding in a plane; None without it."""
    if "gust" not in document:
        return None
    values = wind_values(GUST_TABLE, GUST_TABLE.one(document))
    refuse_gust_time(values.get("peak_time"))
    gust = gust_of(values["peak"], values["duration"], values.get("plateau", 0.0))
    return gust if values["speed"] is None else GustOfSpeed(gust, values["speed"], plane)


def _gust_speed(document: Mapping[str, Any]) -> float | None:
    """Return the speed [m/s] of [gust] in a document; None for an angle, and without a gust."""
    on_top = "gust" in document and not is_wind_from_gust(document)
    return GUST_TABLE.read(GUST_TABLE.one(document)).get("peak_speed") if on_top else None


def _sounding(
    table: dict[str, Any], folder: Path, reading: SoundingReading
) -> tuple[str, SoundingRequest]:
    """Return name and request of the sounding of a table [[wind]].

    `table`: its keys, which override the keys of [sounding]. `folder`: where its file is.
    `reading`: the keys of [sounding].
    """
    of_pulse = [
        key for key in table if key in WIND_TABLE.every_key and key not in SOUNDING_TABLE.every_key
    ]
    if of_pulse:
        raise InputError(
            f"a [[wind]] with a sounding has no {listed(of_pulse, 'or')}: take that out, or give"
            " the sounding a [[wind]] of its own (in a shell: --winds FILE)"
        )
    options = SOUNDING_TABLE.read(table)
    file = table[SOUNDING]
    if not isinstance(file, str) or not file.isprintable():
        raise InputError(f"sounding in [[wind]] must be a path; got {shown(file)}")
    for key in ("name", "format", "time", "units"):
        printable_text(f"{key} in [[wind]]", table.get(key, ""))
    names = ("format", "time", "units", "above_ground")
    row = replace(reading, **{name: options[name] for name in names if name in options})
    profile = row.profile(folder / file)
    name = Path(file).name  # without its folder, so that the page is the same from another one
    profile = replace(profile, source=profile.source.replace(called(folder / file), name, 1))
    return table.get("name") or name, SoundingRequest(
        profile, options["azimuth"], reading.mean_wind
    )
