"""Study files: TOML in, a `StudyPlan` out.

A vehicle alone needs nothing of what a whole study file may ask for, so that is imported late.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from tvclin.answers.study_file.plan import StudyPlan
from tvclin.base.declared import completed
from tvclin.base.errors import InputError, instance, naming, path
from tvclin.base.files import called, tables_of
from tvclin.base.tables import FileTable
from tvclin.vehicle.linear_vehicle import load_any_vehicle
from tvclin.vehicle.vehicle_file import COEFFICIENTS, is_schedule, read_vehicle_text, source_tables

if TYPE_CHECKING:
    from tvclin.answers.sizing.request import SoundingRequest


_STUDIES, _VEHICLES = {"study", "campaign"}, {COEFFICIENTS, "vehicle"}
"""Tables of a file that names its vehicle, and of one that has its numbers."""


def load_study(source: str | PathLike[str], time: float | None = None) -> StudyPlan:
    """Return what a study file asks for, or a plan with nothing but a vehicle.

    Parameters
    ----------
    source : str or path
        A study file, a campaign file, a vehicle file, a flight schedule, or the name of a vehicle.
        The paths in a study file are relative to its folder; `tvclin init --study` writes one.
    time : float, optional
        Time of flight [s] of the vehicle, where the source is a flight schedule, or a vehicle with
        a table [flight]: then that of its nominal flight.

    Raises
    ------
    InputError
        For a file that cannot be read, is not TOML, or has an unknown key (the near ones are
        offered), for a flight schedule without a time, and as `StudyPlan`. One sentence says which
        and how to mend it.

    Examples
    --------
    >>> import tvclin as tv
    >>> plan = tv.load_study("configuration-i")
    >>> plan.wind.shape, plan.nozzle.limit
    ('triangular', None)
    """
    document, name = source_tables(source), read_vehicle_text(source)[1]
    if not _STUDIES & document.keys() and (_VEHICLES & document.keys() or is_schedule(source)):
        if time is None:
            return StudyPlan(vehicle=load_any_vehicle(source))
        from tvclin.ascent.schedule_file import load_vehicle_at

        return StudyPlan(vehicle=load_vehicle_at(source, time))
    from tvclin.answers.study_file.parse import parse_study

    with naming(called(name)):
        if time is not None:
            raise InputError("the time of the vehicle of a study file is time_s in its [study]")
        return parse_study(document, Path(name).parent)


def load_sizing(
    source: str | PathLike[str], soundings: Mapping[str, SoundingRequest] | None = None
) -> StudyPlan:
    """Return a plan that asks of a flight: of a study file, or a schedule or vehicle with defaults.

    Parameters
    ----------
    source : str or path
        A study file with [schedule], or what `load_schedule` makes a schedule of.
    soundings : dict of str to SoundingRequest, optional
        Winds over height, beside those of a study file. Where neither gives a wind it is a triangle
        of 5 degrees for 7.5 seconds.

    Raises
    ------
    InputError
        For a study file without [schedule], and as `load_study` and `load_schedule`.

    Examples
    --------
    >>> import tvclin as tv
    >>> plan = tv.answers.load_sizing("configuration-i")
    >>> plan.sizing.times(plan)[[0, 1, -1]]
    array([ 44.75,  45.  , 112.25])
    """
    from tvclin.answers.sizing.request import SizingRequest
    from tvclin.ascent.schedule_file import load_schedule

    if soundings is not None:
        instance("soundings", soundings, Mapping, "of names to SoundingRequest")
    more = dict(soundings or {})
    if _is_study(source):
        plan = load_study(source)
        if plan.sizing is None:
            raise InputError(
                f"{called(source)} has no flight; add [schedule], see tvclin init --study"
            )
        more = {**plan.sizing.soundings, **more}
        return replace(plan, sizing=replace(plan.sizing, soundings=more))
    flight = load_schedule(source)
    asked = SizingRequest(schedule=flight, source=str(source), pulse=not more, soundings=more)
    return StudyPlan(vehicle=flight.vehicle, sizing=asked)


def vehicle_source(source: str | PathLike[str]) -> str | PathLike[str]:
    """Return the name or the file of the vehicle of a study file, or a vehicle as it is."""
    document, name = source_tables(source), read_vehicle_text(source)[1]
    named = [
        document[table]["vehicle"]
        for table in ("study", "campaign")
        if "vehicle" in document.get(table, {})
    ]
    if not named:
        return source
    if not isinstance(named[0], str):
        raise InputError(
            f"{called(name)} has the numbers of its vehicle, and no flight with them: name a"
            " vehicle file with a table [flight]"
        )
    from tvclin.answers.campaign.file import beside

    return beside(named[0], Path(name).parent)


def _is_study(source: str | PathLike[str]) -> bool:
    """Whether a file is a study, or neither that nor anything that has a flight."""
    path("source", source, "a name or a path")
    headings = source_tables(source).keys()
    return bool(_STUDIES & headings) or not (_VEHICLES & headings or is_schedule(source))


def example() -> str:
    """Return the study file of the package, which is commented and names every declared key."""
    from tvclin.answers.nozzle import NOZZLE_TABLE, Nozzle
    from tvclin.answers.sizing.request import SIZE_TABLE, SizingRequest
    from tvclin.control.autopilot.design_rules import AUTOPILOT_TABLE, AutopilotDesign

    folder = files("tvclin.answers.study_file")
    text = folder.joinpath("example.toml").read_text(encoding="utf-8")
    each: tuple[tuple[FileTable, type], ...] = (
        (NOZZLE_TABLE, Nozzle),
        (AUTOPILOT_TABLE, AutopilotDesign),
        (SIZE_TABLE, SizingRequest),
    )
    for table, kind in each:
        text = completed(text, table, kind)
    return text


def example_plan() -> StudyPlan:
    """Return the plan of the study file of the package."""
    from tvclin.answers.study_file.parse import parse_study

    return parse_study(tables_of(example(), "the example"))
