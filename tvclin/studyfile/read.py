"""Study files: the `StudyPlan` of a TOML file.

A plan of a vehicle alone needs no other table of a study file, so that these are imported late.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.errors import InputError, instance, naming, path
from tvclin.base.fields import completed
from tvclin.base.files import EditedSource, called, tables_of
from tvclin.case.case import DEFAULT_WIND
from tvclin.studyfile.study_plan import StudyPlan, named_vehicle
from tvclin.vehicle.linear_vehicle import load_any_vehicle
from tvclin.vehicle.vehicle_file import COEFFICIENTS, is_schedule, read_vehicle_text, source_tables
from tvclin.winds.shaped import ShapedWind

if TYPE_CHECKING:
    from tvclin.requirement.flight.request import SoundingRequest

_STUDY_HEADINGS, _VEHICLE_HEADINGS = {"study", "campaign"}, {COEFFICIENTS, "vehicle"}
"""Tables of a study, which names its vehicle, and of a vehicle file, which has its numbers."""

_DEFAULT_TABLES = {
    "wind": {
        "shape": DEFAULT_WIND.shape,
        "peak_rad": DEFAULT_WIND.peak,
        "duration_s": DEFAULT_WIND.duration,
    }
}
"""Wind of a flight schedule, whose study needs none for margins."""


def load_study(source: str | PathLike[str], time: float | None = None) -> StudyPlan:
    """Return the plan of a study file, or a plan of a vehicle alone.

    Parameters
    ----------
    source : str or path
        A study file, a campaign file, a vehicle file, a flight schedule, or the name of a vehicle.
        The paths in a study file are relative to its folder; `tvclin init --study` writes one.
    time : float, optional
        Time of flight [s] of the vehicle, where the source is a flight schedule, or a vehicle with
        a table [flight], whose nominal flight then counts.

    Raises
    ------
    InputError
        For a file that cannot be read, is not TOML, or has an unknown key (similar keys are
        suggested), for a flight schedule without a time, and as `StudyPlan`. One sentence says
        which and how to correct it.

    Examples
    --------
    >>> import tvclin as tv
    >>> plan = tv.load_study("configuration-i")
    >>> plan.wind.shape, plan.nozzle.limit
    ('triangular', None)
    """
    document, (_text, name) = source_tables(source), read_vehicle_text(source)
    if not _is_study(source):
        if time is None:
            return StudyPlan(vehicle=load_any_vehicle(source))
        from tvclin.ascent.schedule_file import load_schedule, load_vehicle_at
        from tvclin.studyfile.campaign_file import with_flight_actuator

        plan = StudyPlan(vehicle=load_vehicle_at(source, time))
        if not is_schedule(source):
            return plan
        nozzle = with_flight_actuator(plan.nozzle, load_schedule(source), time)
        return replace(plan, nozzle=nozzle)
    from tvclin.studyfile.parse import parse_study

    with naming(called(name)):
        if time is not None and not (_of_a_vehicle(document) or is_flight(source)):
            raise InputError("the time of the vehicle of a study file is time_s in its [study]")
        if time is not None:
            document = _DEFAULT_TABLES | document
            document["study"]["time_s"] = time
        return _with_altitude(parse_study(document, Path(name).parent), source)


def _with_altitude(plan: StudyPlan, source: str | PathLike[str]) -> StudyPlan:
    """Return a plan whose turbulence has the altitude of the vehicle in its own flight, if known.

    `source`: vehicle of the plan, by name or path. A plan with a flight has the altitudes of that.
    The plan is unchanged where its turbulence needs no altitude, and where that is not known.
    """
    request, time = plan.turbulence, getattr(plan.vehicle, "time", None)
    if request is None or not request.needs_altitude or plan.sizing is not None or time is None:
        return plan
    from tvclin.ascent.schedule_file import load_schedule

    with suppress(InputError):  # a vehicle without a flight
        flight = load_schedule(vehicle_source(source))
        if flight.altitude is not None:
            altitude = float(np.interp(float(np.asarray(time)), flight.times, flight.height))
            return replace(plan, turbulence=replace(request, altitude=altitude))
    return plan


def load_sizing(
    source: str | PathLike[str], soundings: Mapping[str, SoundingRequest] | None = None
) -> StudyPlan:
    """Return the plan of a sizing, from a study file, or from a schedule or vehicle with defaults.

    Parameters
    ----------
    source : str or path
        A study file, or a source of `load_schedule`. The flight of a study without [schedule] is
        that of its vehicle.
    soundings : dict of str to SoundingRequest, optional
        Winds over height, added to the winds of a study file. Without any wind the default is a
        triangle of 5 degrees for 7.5 seconds.

    Raises
    ------
    InputError
        For a study file without [schedule] that has the numbers of its vehicle, and as `load_study`
        and `load_schedule`.

    Examples
    --------
    >>> import tvclin as tv
    >>> plan = tv.studyfile.load_sizing("configuration-i")
    >>> plan.sizing.times(plan)[[0, 1, -1]]
    array([ 44.75,  45.  , 112.25])
    """
    from tvclin.ascent.schedule_file import load_schedule
    from tvclin.requirement.flight.request import SizingRequest

    if soundings is not None:
        instance("soundings", soundings, Mapping, "of names to SoundingRequest")
    winds = dict(soundings or {})
    if _is_study(source):
        # a vehicle or schedule alone, with keys of --set, or a study of a schedule without a time
        of_flight = _of_a_vehicle(source_tables(source)) or is_flight(source)
        plan = _flight_of_a_vehicle(source, winds) if of_flight else load_study(source)
        plan = plan if plan.sizing else _plan_over_flight(source)
        sizing = plan.sizing
        assert sizing is not None
        winds = {**sizing.soundings, **winds}
        return replace(plan, sizing=replace(sizing, soundings=winds))
    flight = load_schedule(source)
    sizing = SizingRequest(schedule=flight, source=str(source), pulse=not winds, soundings=winds)
    return StudyPlan(vehicle=flight.vehicle, sizing=sizing)


def vehicle_source(source: str | PathLike[str]) -> str | PathLike[str]:
    """Return the name or the file of the vehicle of a study file; another source unchanged.

    The vehicle stands in [study] or in [campaign]. `InputError` where it is a table of numbers.
    """
    vehicle, (_text, name) = named_vehicle(source_tables(source)), read_vehicle_text(source)
    if vehicle is None:
        return source
    if not isinstance(vehicle, str):
        raise InputError(
            f"{called(name)} has the numbers of its vehicle, and no flight with them: name a"
            " vehicle file with a table [flight]"
        )
    from tvclin.studyfile import campaign_file

    return campaign_file.vehicle_source(vehicle, Path(name).parent)


def _flight_of_a_vehicle(
    source: str | PathLike[str], winds: Mapping[str, SoundingRequest]
) -> StudyPlan:
    """Return the study plan of a whole flight, of a source that may have keys of --set.

    `source`: name or path of a vehicle or flight schedule. `winds`: soundings of the flight by
    name. The wind of the plan is a pulse at each flight time (`pulse`), unless there are soundings
    and it is the default wind, of a source without a wind.
    """
    from tvclin.ascent.schedule_file import load_schedule

    document, vehicle = source_tables(source), vehicle_source(source)
    tables = _DEFAULT_TABLES | {"size": {}} | document  # [size] makes it a plan of a flight
    flight = load_schedule(vehicle) if is_schedule(vehicle) else None
    if flight is not None:  # at the largest speed, so that a gust by its speed has an angle
        fastest = float(flight.times[np.argmax(flight.vehicle.velocity)])
        tables["study"] = tables["study"] | {"time_s": fastest}
    plan = load_study(EditedSource(str(source), tables))
    assert plan.sizing is not None
    soundings = {**plan.sizing.soundings, **winds}
    pulse = isinstance(plan.wind, ShapedWind)  # whether a pulse counts at each flight time
    if isinstance(plan.wind, ShapedWind) and soundings:  # a gust is added to soundings too
        pulse = replace(plan.wind, gust=None, gust_at=None, gust_speed=None) != DEFAULT_WIND
    plan = replace(plan, sizing=replace(plan.sizing, pulse=pulse, soundings=soundings))
    return plan if flight is None else replace(plan, vehicle=flight.vehicle)


def _plan_over_flight(source: str | PathLike[str]) -> StudyPlan:
    """Return the plan of a study over the flight of its vehicle, as with an empty table [size].

    `source`: name or path of a study without [schedule] and [size]. `InputError` where its vehicle
    is a table of numbers, which has no flight, and for a vehicle without [flight].
    """
    document = source_tables(source)
    if isinstance(named_vehicle(document), dict):
        raise InputError(
            f"{called(source)} has no flight; add [schedule], see tvclin init --study; at one"
            " time tvclin study answers for a pulse, tvclin fly for a sounding"
        )
    return load_study(EditedSource(str(source), document | {"size": {}}))


def is_flight(source: str | PathLike[str]) -> bool:
    """Return whether a source is a flight schedule, or a study of one without a time.

    A study with a flight time, or with the numbers of its vehicle, is of a single time.
    """
    document = source_tables(source)
    tables = [document.get(table, {}) for table in ("study", "campaign")]
    if any("time_s" in keys for keys in tables) or isinstance(named_vehicle(document), dict):
        return False
    return is_schedule(vehicle_source(source))


def is_flight_with_keys(source: str | PathLike[str]) -> bool:
    """Return whether a source is a flight schedule to which --set has added keys.

    Such a source is the text of a study whose tables are of its vehicle alone, as --set leaves
    them, and whose vehicle is the schedule.
    `source`: text or name of the file, as `source_tables` takes it.
    """
    return _of_a_vehicle(source_tables(source)) and is_schedule(vehicle_source(source))


def _of_a_vehicle(document: Mapping[str, Any]) -> bool:
    """Return whether a document is of a vehicle or schedule alone, with further keys of --set.

    The vehicle in its [study] is then an `EditedSource`, in place of a name or path.
    """
    return isinstance(document.get("study", {}).get("vehicle"), EditedSource)


def _is_study(source: str | PathLike[str]) -> bool:
    """Return whether a source is a study, or at least neither a vehicle nor a schedule."""
    path("source", source, "a name or a path")
    headings = source_tables(source).keys()
    if _STUDY_HEADINGS & headings:
        return True
    return not (_VEHICLE_HEADINGS & headings or is_schedule(source))


def example() -> str:
    """Return the study file of the package, which is commented and names every declared key."""
    from tvclin.case.nozzle import NOZZLE_TABLE
    from tvclin.control.autopilot.design_rules import AUTOPILOT_TABLE
    from tvclin.requirement.flight.request import SIZE_TABLE

    text = files("tvclin.studyfile").joinpath("example.toml").read_text(encoding="utf-8")
    for table in (NOZZLE_TABLE, AUTOPILOT_TABLE, SIZE_TABLE):
        text = completed(text, table)
    return text


def study_template() -> str:
    """Return the study file to fill in: the example with its whole flight as comments.

    The flight of the example belongs to its own vehicle. It reaches from [schedule] to the comment
    on many cases; its lines of keys become comments, and comments stay.
    """
    head, heading, rest = example().partition("[schedule]\n")
    flight, many, others = rest.partition("# Many cases")
    lines = f"{heading}{flight}".splitlines(keepends=True)
    comments = (
        line
        if line.isspace() or line.lstrip().startswith("#")
        else f"# {line.replace('   # ', ' # ', 1)}"
        for line in lines
    )
    return f"{head}{''.join(comments)}{many}{others}"


def example_plan() -> StudyPlan:
    """Return the plan of the study file of the package."""
    from tvclin.studyfile.parse import parse_study

    return parse_study(tables_of(example(), "the example"))
