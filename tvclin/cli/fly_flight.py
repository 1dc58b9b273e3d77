"""Answer of `tvclin fly FLIGHT`: the loop flown along a whole flight, in pulses and soundings."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from tvclin.cli.flight_margins import flight_loop
from tvclin.cli.inputs import note_omissions
from tvclin.cli.options import ShownCurves
from tvclin.cli.output import answer, bar, draw, print_answer, print_tables
from tvclin.cli.wind import FlightOptions, check_reading
from tvclin.studyfile.flight_loop import FlightLoop, FlightsOfLoop
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.vehicle_file import source_tables
from tvclin.winds.soundings.reading import SoundingReading

_MAX_ROWS = 20
"""Largest number of winds in the table without --more."""


def fly_flight(
    source: str,
    winds: FlightOptions,
    changes: Sequence[Callable[[StudyPlan], StudyPlan]],
    more: bool,
    shown: ShownCurves,
) -> None:
    """Fly the autopilot of a flight through each wind, and print the verdict on the limit."""
    reading = SoundingReading.of(source_tables(source), Path(source).parent)
    loop = flight_loop(source, *changes, winds.over, soundings=winds.soundings(reading))
    check_reading(loop.plan)
    note_omissions(loop.plan, "fly")
    with bar("flights") as progress:
        flown = loop.fly(progress)
    _show(source, loop, flown, more, shown)


def _show(
    source: str, loop: FlightLoop, flown: FlightsOfLoop, more: bool, shown: ShownCurves
) -> None:
    """Write and print the flights: by wind, and all outputs of the worst."""
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
    title = f"{name}, {loop.model}, {loop.plan.plane}" + f", {worst.wind}" * (flown.wind_count == 1)
    head = {"vehicle": name, "model": loop.model, "plane": loop.plan.plane}
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
