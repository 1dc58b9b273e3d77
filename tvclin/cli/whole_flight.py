"""Answers of `tvclin margins FLIGHT` and `tvclin fly FLIGHT`: the autopilot over a whole flight.

The sweep of its margins over even flight times, and its flights in pulses and soundings.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from tvclin.cli.inputs import note_omissions
from tvclin.cli.options import ShownCurves
from tvclin.cli.output import answer, bar, draw, print_answer, print_tables, waiting
from tvclin.cli.wind import FlightOptions, check_reading
from tvclin.requirement.flight.request import SoundingRequest
from tvclin.studyfile.flight_loop import FlightLoop, FlightsOfLoop
from tvclin.studyfile.read import load_sizing
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.coefficients import BOTH
from tvclin.vehicle.vehicle_file import source_tables
from tvclin.winds.soundings.sounding_files import SoundingReading

_MAX_ROWS = 20
"""Largest number of winds, or of even flight times, in the table without --more."""
_DETUNED = (
    "detuned: the smallest margin with the frequency of one mode or tank 10 percent off, over its"
    " limit"
)
_FROZEN_NOTE = "margins of frozen flight times do not prove the flight: tvclin fly FLIGHT flies it"


def flight_loop(
    source: str,
    *changes: Callable[[StudyPlan], StudyPlan],
    soundings: dict[str, SoundingRequest] | None = None,
) -> FlightLoop:
    """Return the loop of a flight from the file `source` with soundings, by name.

    `changes`: functions that put options over the plan of the file. The design of the loop is that
    over the flight, over which options of gains are put too.
    """
    loop = FlightLoop.of(load_sizing(source, soundings))
    for change in changes:
        loop = replace(loop, plan=change(loop.plan))
    return loop


def print_sweep(source: str, loop: FlightLoop, more: bool, shown: ShownCurves) -> None:
    """Print the verdict on the criteria over the flight, and the margins by flight time.

    `source`: name of the file, for a vehicle without a name. `loop`: autopilot and vehicle over the
    flight. `more`: whether all flight times and notes are printed.
    """
    from tvclin import plots

    note_omissions(loop.plan, "margins", "margins along a flight")
    with waiting("margins"):
        swept = loop.sweep()
    # `changes`: of detuned modes; at each flight time the parameters are frozen
    notes = [*loop.notes, *([_DETUNED] if swept.changes else []), _FROZEN_NOTE]
    if shown.csv is not None:
        swept.to_csv(shown.csv)
    name = loop.flight.vehicle.name or source
    draw(shown.plot, lambda: plots.sweep_chart(swept, name))
    table = swept.time_table(None if more else _MAX_ROWS)
    title = f"{name}, {loop.model}, {loop.plan.plane}"
    table = replace(table, caption=f"{title}: {table.caption[:1].lower()}{table.caption[1:]}")
    document = {"vehicle": name, "model": loop.model, "plane": loop.plan.plane}
    further = {"verdict": swept.verdict, "margins": swept.margins, "bands": swept.modes}
    worst = [margin._asdict() for margin in swept.worst]
    answer(
        shown.as_json,
        lambda: document | swept.as_dict() | further | {"worst": worst, "notes": notes},
        lambda: print_answer(
            swept.verdict,
            table,
            notes=notes,
            more=more,
            details=lambda: print_tables(swept.table()),
        ),
        swept.all_satisfied,
    )


def fly_flight(
    source: str,
    winds: FlightOptions,
    changes: Sequence[Callable[[StudyPlan], StudyPlan]],
    more: bool,
    shown: ShownCurves,
) -> None:
    """Fly the autopilot of a flight through each wind, and print the verdict on the limit.

    `source`: file of the flight. `winds`: options of its winds and times. `changes`: functions that
    put options into its plan, as `winds.applied_to` does. `more`: whether all winds and notes are
    printed. `shown`: histories that are drawn or written.
    """
    reading = SoundingReading.of(source_tables(source), Path(source).parent)
    loop = flight_loop(source, *changes, winds.applied_to, soundings=winds.soundings(reading))
    check_reading(loop.plan)
    note_omissions(loop.plan, "fly along a flight")
    with bar("flights") as progress:
        flown = loop.fly(progress)
    _show(source, loop, flown, more, shown)


def _show(
    source: str, loop: FlightLoop, flown: FlightsOfLoop, more: bool, shown: ShownCurves
) -> None:
    """Write and print the flights: by wind, and all outputs of the worst.

    `source`: name of the file, for a vehicle without a name. `loop`: what is flown. `more`: whether
    all winds and notes are printed.
    """
    from tvclin import plots

    name, worst = loop.flight.vehicle.name or source, flown.worst_outcome
    notes = [*flown.notes, *loop.notes, *loop.wind_notes]
    if shown.csv is not None:
        flown.worst.to_csv(shown.csv)
    draw(
        shown.plot,
        lambda: plots.flight_along_chart(flown.worst, flown.limit, f"{name}, {worst.label}"),
    )
    largest = replace(flown.worst.table(), caption=f"Largest values, {worst.label}")
    table = flown.table(None if more else _MAX_ROWS)
    if len(flown.outcomes) == 1:
        table = largest
    planes = "both planes" if loop.plan.planes == BOTH else loop.plan.plane
    title = f"{name}, {loop.model}, {planes}"
    title += f", {worst.wind}" if flown.wind_count == 1 else ""
    head = {"vehicle": name, "model": loop.model, "plane": loop.plan.planes}
    answer(
        shown.as_json,
        lambda: head | flown.document() | {"notes": notes},
        lambda: print_answer(
            flown.verdict,
            replace(table, caption=f"{title}\n{table.caption}"),
            notes=notes,
            more=more,
            details=lambda: print_tables(largest),
        ),
        bool(flown.survived),
    )
