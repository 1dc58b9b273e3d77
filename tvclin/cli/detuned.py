"""What `tvclin margins --detuned` adds: margins with detuned modes."""

from math import isnan
from typing import TYPE_CHECKING, Annotated

import typer

from tvclin.cli.output import say

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
_NUMBERS = ("aero_margin_dB", "gain_increase_dB", "phase_margin_deg")

_SIDES = {"aero_margin_dB": "down", "gain_increase_dB": "up"}
"""In the words of the headings."""


def detuned_of(found: "MarginsFound") -> "Detuned":
    """Return the margins of the loop with detuned modes."""
    from tvclin.control.autopilot.detuning import detuned
    from tvclin.linear.flexible import FlexiblePlant

    assert isinstance(found.plant, FlexiblePlant)  # margins refuses --detuned of all else
    return detuned(found.autopilot, found.plant, criteria=found.asked)


def fails_first(name: str) -> str:
    """Return the name of a margin in the words of the headings; "bending 1, gain" of a mode."""
    from tvclin.control.margins.record import MARGINS

    margin, _, mode = name.partition(" of ")
    if mode:
        return f"{mode}, {'gain' if 'gain' in margin else 'phase'}"
    return _SIDES.get(name) or (MARGINS[name][0] if name in MARGINS else name.upper())


def print_detuned(found: "Detuned") -> None:
    """Print a row for each change, what fails first in it, and where the loop is lost."""
    from tvclin.cli.output import print_table

    def cell(name: str, k: int) -> str:
        value = getattr(found.margins, name)[k]
        return "-" if isnan(value) else f"{value:.2f}"

    rows = []
    for k, (change, first) in enumerate(zip(found.changes, found.first, strict=True)):
        judged = "met" if found.met[k] else "NOT MET"
        short = change.replace(" at the sensors", "").replace("half its", "half")
        rows.append([short, *(cell(name, k) for name in _NUMBERS), fails_first(first), judged])
    headings = ["change", "down", "up", "phase", "fails first", "asked"]
    print_table("Detuned modes, in dB and deg", headings, rows)
    for edge in found.edges:
        sides = [f"{side:.3f}" for side in (edge.lower, edge.upper) if not isnan(side)]
        if sides:
            say(f"{edge.name}: unstable at {' and '.join(sides)} of its frequency")
    if all(isnan(side) for edge in found.edges for side in (edge.lower, edge.upper)):
        say("Between these frequencies the loop becomes unstable nowhere.")
