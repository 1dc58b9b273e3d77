"""`tvclin ascent`: the required deflection of a whole flight, and the verdict on the limit."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.base.fields import document
from tvclin.cli.inputs import changed, keys_set, note_omissions, note_source
from tvclin.cli.options import (
    BOTH_LIMITS,
    GROUP,
    MODEL,
    AsJson,
    Given,
    More,
    Plot,
    asked,
    to_write,
)
from tvclin.cli.output import answer, bar, draw, print_answer, print_tables, say, say_lines
from tvclin.cli.wind import FlightOptions, check_reading
from tvclin.requirement.flight import sizing_tables as tables
from tvclin.requirement.flight.controllability import ControllabilityRatio
from tvclin.requirement.flight.flight_turbulence import FlightTurbulence
from tvclin.requirement.flight.request import SizingRequest
from tvclin.requirement.flight.sizing import STEADY, Sizing, hundredths
from tvclin.requirement.flight.total import DeflectionTotal, total_table
from tvclin.requirement.required_quantity import Requirement
from tvclin.studyfile.read import load_sizing
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.coefficients import BOTH
from tvclin.vehicle.vehicle_file import source_tables
from tvclin.winds.soundings.reading import SoundingReading
from tvclin.winds.wind_angles import FROZEN

_FIELDS = ("start", "stop", "every", "dead_bands", "varying")
"""Fields of `SizingRequest` that have an option."""
_MAX_WIND_COLUMNS = 6
"""Largest number of winds with a column each, for the width of a terminal."""
SOURCE = (
    "A study file with a table named schedule (see: tvclin init --study); or a flight schedule"
    " (CSV, or TOML with that table alone); or a vehicle whose file has a table named flight: then"
    " its nominal flight."
)


@dataclass(frozen=True)
class PlaneOptions:
    """Option of the plane of a flight, or of both with a limit shape."""

    plane: str | None = asked(
        "Plane of the motion: pitch, yaw, or both with one limit, of a shape: --set"
        " nozzle.limit_shape SHAPE.",
        shown="pitch",
    )

    def over(self, plan: StudyPlan) -> StudyPlan:
        """Return a plan of this plane, or of both with a limit shape, round by default."""
        if self.plane is None:
            return plan
        both = self.plane == BOTH
        plan = plan if both else changed(plan, plane=self.plane)
        shape = (plan.nozzle.limit_shape or "round") if both else None
        return replace(plan, nozzle=replace(plan.nozzle, limit_shape=shape))


def ascent(
    source: Annotated[
        str, typer.Argument(metavar="STUDY|SCHEDULE|VEHICLE", help=SOURCE)
    ] = "configuration-i",
    winds: FlightOptions = GROUP,
    model: Given = MODEL,
    planes: PlaneOptions = GROUP,
    limits: Given = BOTH_LIMITS,
    question: Given = Given("requirement.flight.request.SizingRequest", _FIELDS, "sizing"),
    more: More = False,
    as_json: AsJson = False,
    csv: Path | None = asked(
        "Also write every flight time and wind into this file.", callback=to_write
    ),
    plot: Plot = None,
) -> None:
    """Print the required deflection at each time of a flight, its budget, and the verdict on it.

    A pulse is placed so that its peak meets each flight time; a sounding is flown through. With
    --winds there is a pulse only if an option or the study file asks for one. Options count more
    than a study file.

    Exit code 0: the limit is SUFFICIENT, or none was given; 1: NOT SUFFICIENT, or NOT KNOWN, as
    where a sounding ends below the flight; 2: bad input.
    """
    from tvclin import plots

    case = case_over_flight("ascent", source, winds, question, limits, model, planes)
    request = case.sizing
    assert request is not None
    if plot is not None:
        _check_drawn(request.times(case))
    with bar("flight times and winds") as progress:
        sizing = request.sizing(case, progress)
        turbulence = request.turbulence(case, case.turbulence)
    total, ratio = request.total(case, sizing, turbulence), request.ratio(case, sizing)
    counted = request.counted(sizing, case.sign)
    said = [*request.warnings, *request.notes, *_hints(request, sizing), *_of_loop(turbulence)]
    if csv is not None:
        sizing.to_csv(csv)
    draw(plot, lambda: plots.sizing_chart(sizing, total.limit, source))
    further = {
        "total": total,
        "controllability": ratio,
        **({"turbulence": turbulence} if isinstance(turbulence, FlightTurbulence) else {}),
        "notes": [*sizing.notes, *said, *(ratio.notes if ratio else ())],
        "verdict": document(total, "limit", "sufficient", "remaining", "not_sized"),
    }
    answer(
        as_json,
        lambda: sizing.as_dict() | further,
        lambda: _print(sizing, total, ratio, turbulence, source, counted, said, more),
        not total.too_slow and (total.limit is None or bool(total.sufficient)),
    )


def _check_drawn(times: FloatArray) -> None:
    """Raise `InputError` where a figure over the flight would have one flight time [s] alone."""
    if times.size < 2:
        raise InputError(
            "--plot draws over the flight, which takes two or more flight times; got"
            f" {times[0]:g} s alone (--from, --to, --every)"
        )


def _print(
    sizing: Sizing,
    total: DeflectionTotal,
    ratio: ControllabilityRatio | None,
    turbulence: FlightTurbulence | str | None,
    source: str,
    counted: Requirement,
    notes: list[str],
    more: bool,
) -> None:
    """Print the verdict, the required deflections and notes, and the budget with `more`."""
    name = sizing.schedule.vehicle.name or source
    planes = "both planes, one limit" if sizing.separate else sizing.plane
    title = f"{name}, {sizing.model}, {planes}: {', '.join(sizing.winds)}"
    first, further = (all_tables := tables.time_tables(sizing, counted))[:1], all_tables[1:]
    random = turbulence.tables() if isinstance(turbulence, FlightTurbulence) else []

    def details() -> None:
        print_tables(*further)
        if marks := tables.marks_line(sizing):
            say(marks)
        if len(sizing.winds) > 1:
            print_tables(tables.by_wind(sizing, counted))
        if 1 < len(sizing.winds) <= _MAX_WIND_COLUMNS:
            print_tables(*tables.wind_columns_table(sizing, counted))
        say(f"{tables.legend(sizing)}\n")
        print_tables(total_table(total, counted.label), *random[1:])
        if ratio is not None:
            print_tables(ratio.table)
            say_lines([ratio.verdict])

    print_answer(
        total.words,
        *(replace(table, caption=f"{title}\n{table.caption}") for table in first),
        *random[:1],
        notes=(*sizing.notes, *notes, *(ratio.notes if ratio and more else ())),
        more=more,
        details=details,
    )


def _of_loop(turbulence: FlightTurbulence | str | None) -> Iterator[str]:
    """Yield notes on the autopilot that turbulence is answered for."""
    if isinstance(turbulence, FlightTurbulence):
        yield from turbulence.notes


def _hints(request: SizingRequest, sizing: Sizing) -> Iterator[str]:
    """Yield notes on options that would cover flight times which this sizing does not."""
    first, last = sizing.schedule.span
    begin, end = (float(time) for time in (sizing.times.min(), sizing.times.max()))
    if (request.start is None and begin > first) or (request.stop is None and end < last):
        yield (
            f"flight times before {begin:g} s and after {end:g} s are left out, for a pulse about"
            f" them would blow beyond the schedule; --from {first:g} --to {last:g} takes them in"
        )
    first_known, last_known = sizing.known_times[:, 0].max(), sizing.known_times[:, 1].min()
    required = next(iter(sizing.required.values()))
    determined = sizing.times[np.isfinite(required).all(axis=1)]
    if determined.size:  # a gust may make more times unknown than the end of a sounding
        first_known = max(first_known, determined[0] if determined[0] > begin else -np.inf)
        last_known = min(last_known, determined[-1] if determined[-1] < end else np.inf)
    options = [f"--from {hundredths(first_known, up=True)}"] if begin < first_known else []
    options += [f"--to {hundredths(last_known, up=False)}"] if end > last_known else []
    if options:
        yield f"{' '.join(options)} leaves out the flight times at which a wind is not known"
    doubtful = not sizing.freezing_error and (sizing.change > STEADY).any()
    if request.soundings and request.window is None and doubtful:
        yield (
            "--set sounding.window_s 20 counts of a sounding only what is within 10 s of each time,"
            " while parameters change less"
        )


def case_over_flight(
    command: str,
    source: str,
    winds: FlightOptions,
    question: Given,
    *changes: Given | PlaneOptions,
) -> StudyPlan:
    """Return the case of a flight from a file and options."""
    soundings = winds.soundings(SoundingReading.of(source_tables(source), Path(source).parent))
    note_source(source, command)
    case = load_sizing(source, soundings)
    if command == "ascent" and case.turbulence is None:
        note_omissions(case, "ascent without turbulence")
    for options in (question, *changes):
        case = options.over(case)
    case = winds.over(case)
    request = case.sizing
    assert request is not None
    check_reading(case)
    if "study.sign" in keys_set(source) and case.sign != FROZEN:
        if request.soundings and not (request.pulse or request.others):
            raise InputError("--set study.sign needs a pulse: a sounding has its own sign")
        if not request.soundings and case.planes == "yaw" and case.heading is None:
            raise InputError("--set study.sign needs --plane pitch: of a wind along the path")
    return case
