"""The tables [schedule], [size] and [[wind]] with soundings: what is asked of a whole flight."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from tvclin.answers.campaign.keys import known, quantities_of, quantity, spellings
from tvclin.answers.campaign.tables import SOUNDING, wind_tables, winds_of
from tvclin.answers.campaign.winds import ShapedWind
from tvclin.answers.sizing.schedule_file import load_schedule, schedule_of
from tvclin.answers.study_file.sizing import SizingAsked, SoundingAsked
from tvclin.base.errors import InputError, shown
from tvclin.base.files import exists, tables_of
from tvclin.base.units import UNITS
from tvclin.vehicle.file import vehicle_text
from tvclin.winds.gusts import OneMinusCosineGust
from tvclin.winds.histories import History
from tvclin.winds.soundings.read import read_sounding

_TIME, _ANGLE = UNITS["time"], UNITS["angle"]
_GUST = {"peak": _ANGLE, "duration": _TIME, "peak_time": _TIME}


def sizing_of(
    document: Mapping[str, Any], folder: Path, gust: History | None, **study: Any
) -> SizingAsked | None:
    """Return what a document asks of a flight; None without [schedule] and [size].

    Parameters
    ----------
    document : mapping
        The study file.
    folder : Path
        Where the files that it names are.
    gust : History, optional
        On top of the winds.
    **study
        Model, plane and limit of the study, which count for the flight as well.

    Raises
    ------
    InputError
        For unknown keys, files that cannot be read, and as `SizingAsked`.
    """
    measured = [_sounding(table, folder) for table in wind_tables(document) if SOUNDING in table]
    soundings = dict(measured)
    if len(soundings) < len(measured):
        names = ", ".join(name for name, _ in measured)
        raise InputError(f"two soundings have one name among {names}; give each its own name")
    if "schedule" not in document and "size" not in document:
        if soundings:
            raise InputError("a sounding needs a flight: add [schedule], see tvclin init --study")
        return None
    table = dict(document.get("size", {}))
    given: dict[str, Any] = quantities_of("size", table) | table
    if not isinstance(given.get("varying", False), bool):
        raise InputError(f"varying in [size] must be true or false; got {shown(given['varying'])}")
    if "dead_bands" in given:
        if not isinstance(given["dead_bands"], list):
            raise InputError(
                f"dead_bands in [size] must be a list; got {shown(given['dead_bands'])}"
            )
        given["dead_bands"] = tuple(given["dead_bands"])
    pulses = tuple(one for one in winds_of(document, folder) if isinstance(one, ShapedWind))
    return SizingAsked(
        **_flight(document, folder),
        pulses=pulses,
        soundings=soundings,
        gust=gust,
        **(study | given),
    )


def gust_of(document: Mapping[str, Any], duration: float) -> History | None:
    """Return the gust of [gust] in the time of a wind of a duration [s]; None without it."""
    if "gust" not in document:
        return None
    table = dict(document["gust"])
    known("key in [gust]", table, spellings(_GUST))
    peak = quantity("[gust]", table, "peak", _ANGLE)
    lasts = quantity("[gust]", table, "duration", _TIME)
    at = quantity("[gust]", table, "peak_time", _TIME, required=False)
    gust = OneMinusCosineGust(peak=peak or 0.0, duration=lasts or 0.0)
    return gust.shift((0.5 * duration if at is None else at) - 0.5 * float(gust.duration))


def _flight(document: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """The flight of [schedule] and whose it is; that of the study's vehicle without it."""
    table = document.get("schedule", {})
    lists = "time_s" in table or any(isinstance(value, list) for value in table.values())
    if lists and "source" in table:
        raise InputError("[schedule] has a source, and the flight itself in lists; keep one")
    if lists:
        return {"schedule": schedule_of(table, "[schedule]"), "source": "the lists in [schedule]"}
    known("key in [schedule]", table, ("source",))
    study, campaign = document.get("study", {}), document.get("campaign", {})
    own = study.get("vehicle", campaign.get("vehicle"))
    source = table.get("source", own)
    if not isinstance(source, str) or not source.isprintable():
        raise InputError(
            "[schedule] needs a source: a CSV file, or a vehicle with a table [flight]; got"
            f" {shown(source)}"
        )
    found = {"schedule": load_schedule(_beside(folder, source)), "source": source}
    named = isinstance(own, str)
    same = named and Path(_beside(folder, source)) == Path(_beside(folder, own))
    if same or not _is_vehicle(_beside(folder, source)):
        return found
    return found | {"another": own if named else own.get("name") or "given by its numbers"}


def _is_vehicle(source: str | Path) -> bool:
    """Whether the source of a flight is a vehicle, not a table of its times."""
    text, name = vehicle_text(source)
    return not name.lower().endswith(".csv") and "vehicle" in tables_of(text, name)


def _sounding(table: dict[str, Any], folder: Path) -> tuple[str, SoundingAsked]:
    legal = (SOUNDING, "name", "format", "time", *spellings({"azimuth": _ANGLE}))
    known("key in [[wind]]", table, legal)
    azimuth = quantity("[[wind]] with a sounding", table, "azimuth", _ANGLE) or 0.0
    file = table[SOUNDING]
    if not isinstance(file, str) or not file.isprintable():
        raise InputError(f"sounding in [[wind]] must be a path; got {shown(file)}")
    for key in ("name", "format", "time"):
        if not isinstance(table.get(key, ""), str):
            raise InputError(f"{key} in [[wind]] must be a text; got {shown(table[key])}")
    profile = read_sounding(folder / file, table.get("format"), time=table.get("time"))
    named = Path(file).name
    return table.get("name") or named, SoundingAsked(replace(profile, source=named), azimuth)


def _beside(folder: Path, source: str) -> str | Path:
    beside = folder / source
    return beside if exists(beside) else source
