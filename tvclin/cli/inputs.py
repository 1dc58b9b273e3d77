"""Cases and notes that several commands make of their options."""

from collections.abc import Callable, Collection
from contextlib import suppress
from dataclasses import replace
from typing import Any, TypeVar

from tvclin.ascent.measured_wind import GustOfSpeed
from tvclin.ascent.wind_along import SoundingWind
from tvclin.base.errors import InputError
from tvclin.base.files import EditedSource
from tvclin.base.lines import listed
from tvclin.case.case import Case
from tvclin.case.features import is_rigid_only, omission_notes
from tvclin.cli.output import note_below
from tvclin.studyfile.read import (
    is_flight,
    is_flight_with_keys,
    load_sizing,
    load_study,
    vehicle_source,
)
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.linear_vehicle import AnyVehicle
from tvclin.vehicle.vehicle import Vehicle, vehicle_warnings
from tvclin.vehicle.vehicle_file import is_schedule, source_tables
from tvclin.winds.shaped import ShapedWind

FROZEN = "a single flight time: --at TIME"
"""Condition of options that a whole flight does not take."""
T = TypeVar("T")


def flag_of(parameter: str) -> str:
    """Return the option of a parameter, as --limit-deg of limit_deg."""
    return f"--{parameter.strip('_').replace('_', '-')}"


def only_with(needed: str, **options: Any) -> None:
    """Raise `InputError` for options that are given without what they require.

    `needed`: what they require, in words. `options`: values by the names of parameters; one that is
    None or False is not given.
    """
    flags = [
        flag_of(name) for name, value in options.items() if value is not None and value is not False
    ]
    if flags:
        raise InputError(f"{listed(flags)} {'need' if len(flags) > 1 else 'needs'} {needed}")


def case_of(
    source: str,
    *changes: "Callable[[StudyPlan], StudyPlan]",
    time: float | None = None,
    wind: Callable[[StudyPlan, str], StudyPlan] | None = None,
    questions: tuple[str, ...] = (),
) -> StudyPlan:
    """Return the case of a study file, a vehicle, or a flight at a time [s].

    `source`: name of a vehicle or of a file. `changes`: functions that put options over the plan of
    the file, as `GainOptions.applied_to`. `wind`: likewise for the wind, as
    `PulseOptions.applied_to`. Notes on stderr name the effects that the `questions` neglect, and
    implausible numbers of the vehicle, such as a dynamic pressure that contradicts speed and
    altitude; a question of the rigid vehicle alone gets that.
    """
    from tvclin.ascent.schedule_file import pressure_warnings  # late: with a flight

    plan = load_study(source, time)
    if "study" not in questions:  # which has them among its own notes
        note_vehicle_warnings(plan.vehicle)
    with suppress(InputError):  # a study with the numbers of its vehicle, which have no altitude
        for warning in pressure_warnings(vehicle_source(source)):
            note_below(warning)
    plane = plan.plane
    for change in changes:
        plan = change(plan)
    if plan.plane != plane:  # speeds of the wind have other angles in this plane
        own = plan.wind
        if isinstance(own, SoundingWind) and isinstance(own.gust, GustOfSpeed):
            own = replace(own, gust=replace(own.gust, plane=plan.plane))
        elif isinstance(own, ShapedWind) and isinstance(plan.vehicle, Vehicle):
            own = own.for_vehicle(plan.vehicle, plan.plane)
        plan = replace(plan, wind=own)
    if wind is not None:
        plan = wind(plan, source)
    if questions:
        note_omissions(plan, *questions)
    if any(map(is_rigid_only, questions)):
        criteria = plan.criteria and plan.criteria.without_mode_limits
        plan = replace(plan, vehicle=plan.vehicle.rigid, criteria=criteria)
    return plan


def keys_set(source: str) -> tuple[str, ...]:
    """Return the keys of --set on a source; empty for a file or name with none set."""
    return source.keys if isinstance(source, EditedSource) else ()


def note_vehicle_warnings(vehicle: AnyVehicle) -> None:
    """Print warnings on implausible numbers of a vehicle, on stderr."""
    for doubt in vehicle_warnings(vehicle) if isinstance(vehicle, Vehicle) else ():
        note_below(doubt)


def note_omissions(case: Case, *questions: str, tables: Collection[str] = ()) -> None:
    """Print on stderr the effects of a case that questions neglect, such as bending.

    `questions`: names of questions, as "nozzle --over load". `tables`: tables of the case's file.
    """
    for sentence in omission_notes(case, *questions, tables=tables):
        note_below(sentence)


def note_nominal_pressure(case: Case) -> None:
    """Print on stderr that an answer is at nominal dynamic pressure, and how much higher it may be.

    Nothing for a case with the sign of its wind.
    """
    from tvclin.requirement.study import nominal_pressure  # late: with all of a study

    for words in nominal_pressure(case) if case.sign is None else ():
        note_below(f"the answer is {words} (tvclin study counts it)")


def note_single_time(source: str, time: float | None) -> None:
    """Print on stderr that time_s of a study of a flight schedule selects a single flight time.

    `time`: flight time of the options [s], with which nothing is printed.
    """
    study = source_tables(source).get("study", {})
    if time is None and "time_s" in study and is_schedule(vehicle_source(source)):
        note_below(
            f"this is the single flight time {study['time_s']:g} s, time_s in [study]; --set"
            " study.time_s none takes the whole flight"
        )


def note_source(source: str, question: str) -> None:
    """Print on stderr what a question neglects of a file, and other notes on reading it.

    `source`: a vehicle, study or campaign file, or a flight schedule. `question`: its name.
    """
    if is_flight_with_keys(source) or is_flight(source):
        with suppress(InputError):  # a file without [schedule], which availability reads itself
            note_omissions(load_sizing(source), question)
        return
    # called for its notes on stderr alone
    if {"vehicle", "study", "campaign"} & source_tables(source).keys():
        case_of(source, questions=(question,))


def chosen(option: T | None, otherwise: T) -> T:
    """Return an option, or `otherwise` where it is not given."""
    return otherwise if option is None else option
