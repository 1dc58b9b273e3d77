"""What `tvclin margins --detuned` adds: margins with detuned modes."""

from typing import TYPE_CHECKING, Annotated

import typer

from tvclin.cli.output import print_tables, say_lines

if TYPE_CHECKING:
    from tvclin.cli.margin_tables import MarginsFound
    from tvclin.control.autopilot.detuning import Detuned

IsDetuned = Annotated[
    bool,
    typer.Option(
        "--detuned",
        help="Also print the margins with the frequency of each mode off by up to 20 percent, with"
        " half its damping, and with the signs of its slopes at the sensors reversed.",
    ),
]


def detuned_of(found: "MarginsFound") -> "Detuned":
    """Return the margins of the loop with detuned modes."""
    from tvclin.control.autopilot.detuning import detuned
    from tvclin.linear.flexible import FlexiblePlant

    assert isinstance(found.plant, FlexiblePlant)  # margins refuses --detuned of all else
    return detuned(found.autopilot, found.plant, criteria=found.asked)


def print_detuned(found: "Detuned") -> None:
    """Print a row for each change, what fails first in it, and where the loop is lost."""
    print_tables(found.table())
    say_lines(found.said)
