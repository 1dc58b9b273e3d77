"""Answer of `tvclin margins FLIGHT`: the sweep of the margins over a whole flight."""

from collections.abc import Callable
from dataclasses import replace

from tvclin.cli.inputs import note_omissions
from tvclin.cli.options import ShownCurves
from tvclin.cli.output import answer, draw, print_answer, print_tables, waiting
from tvclin.requirement.flight.request import SoundingRequest
from tvclin.studyfile.flight_loop import FlightLoop
from tvclin.studyfile.read import load_sizing
from tvclin.studyfile.study_plan import StudyPlan

_MAX_ROWS = 20
"""Largest number of even flight times in the table without --more."""
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
    """Return the loop of a flight from a file with soundings, over which options count."""
    loop = FlightLoop.of(load_sizing(source, soundings))
    for change in changes:
        loop = replace(loop, plan=change(loop.plan))
    return loop


def print_sweep(source: str, loop: FlightLoop, more: bool, shown: ShownCurves) -> None:
    """Print the verdict on the criteria over the flight, and the margins by flight time."""
    from tvclin import plots

    note_omissions(loop.plan, "margins", "margins without --limit-deg", "margins without a wind")
    with waiting("margins"):
        swept = loop.sweep()
    notes = [*loop.notes, *(_DETUNED for _ in swept.changes[:1]), _FROZEN_NOTE]
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
