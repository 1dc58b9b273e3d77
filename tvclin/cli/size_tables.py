"""What `tvclin size` prints: tables of a sizing and its total."""

from typing import TYPE_CHECKING

from tvclin.cli.output import print_tables, say, say_lines, say_notes

if TYPE_CHECKING:
    from tvclin.answers.sizing.record import Sizing
    from tvclin.answers.sizing.total import DeflectionTotal


_COLUMNS = 6
"""Winds that have a column each, as many as a terminal has room for."""


def print_sizing(
    found: "Sizing", total: "DeflectionTotal", source: str, counted: str, said: list[str]
) -> None:
    """Print the required deflections, the total and all notes; some come from elsewhere."""
    from tvclin.answers.sizing import tables
    from tvclin.answers.sizing.total import total_table

    name = found.schedule.vehicle.name or source
    planes = "both planes, one stop" if found.alone else found.plane
    say(f"{name}, {found.model}, {planes}: {', '.join(found.winds)}\n")
    print_tables(*tables.over_time(found, counted))
    if not (found.steady.all() and found.known.all()) or found.beyond_one_pole.any():
        say(tables.MARKS)
    if len(found.winds) > 1:
        print_tables(tables.by_wind(found, counted))
    if 1 < len(found.winds) <= _COLUMNS:
        print_tables(tables.each_wind(found, counted))
    say(f"{tables.legend(found)}\n")
    print_tables(total_table(total, counted))
    say_lines(total.verdict)
    say_notes((*found.notes, *said))
