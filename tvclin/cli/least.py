"""What `tvclin autopilot --least` adds: gains for the least nozzle."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tvclin.cli.inputs import only_with

if TYPE_CHECKING:
    from tvclin.answers.least_gains.record import LeastGains
    from tvclin.cli.gains import GainOptions, LoopOptions
    from tvclin.control.margins.criteria import Criteria
    from tvclin.linear.flexible import AnyPlant
    from tvclin.winds.histories import History

Least = Annotated[
    bool,
    typer.Option(
        "--least",
        help="Find the gains that need the least deflection of all that meet the criteria: in the"
        " wind, and in winds half and twice as long.",
    ),
]
ThreeGains = Annotated[
    bool, typer.Option("--three-gains", help="With --least: also feed back the angle of attack.")
]
Crossover = Annotated[
    float | None, typer.Option(help="With --least: highest gain crossover, in rad/s.")
]
Limits = Annotated[
    bool,
    typer.Option(
        "--limits",
        help="With --least: find the least limit that flights survive, not the least peak.",
    ),
]
Stops = Annotated[
    int,
    typer.Option(
        help="With --least --limits: number of sudden ends of each wind to survive as well."
    ),
]
_DURATIONS = (1.0, 0.5, 2.0)
"""Of the winds, over the one that is asked about: one wind alone is overfitted."""


def found_least(
    gains: "GainOptions",
    loop: "LoopOptions",
    plant: "AnyPlant",
    wind: Any,
    criteria: "Criteria",
    least: bool,
    three_gains: bool,
    crossover: float | None,
    limits: bool,
    stops: int,
) -> "LeastGains | None":
    """Return the gains for the least nozzle where they are asked for."""
    from tvclin.answers.least_gains.asked import least_asked
    from tvclin.base.errors import InputError
    from tvclin.control.autopilot.rules import LEAST_NOZZLE

    if not least and gains.design != LEAST_NOZZLE:
        only_with(
            "--least",
            three_gains=three_gains,
            crossover=crossover,
            limits=limits,
            stops=stops or None,
        )
        return None
    if gains.design not in (None, LEAST_NOZZLE):
        raise InputError(f"give --least or --design {gains.design}, not both")
    asked = gains.asked(loop, design=LEAST_NOZZLE, crossover=crossover)
    free = ("attitude", "rate", "alpha") if three_gains else ("attitude", "rate")
    winds: list[History] = [
        type(wind)(peak=wind.peak, duration=part * wind.duration) for part in _DURATIONS
    ]
    return least_asked(asked, plant, winds, criteria, gains=free, limits=limits, stops=stops)


def draw_front(found: "LeastGains | None", plot: Path) -> None:
    """Draw what the same gains need when more disk margin is asked for."""
    from tvclin.answers.least_gains.front import least_gains_front
    from tvclin.plots import least_gains_chart, save_figure

    assert found is not None
    save_figure(least_gains_chart([least_gains_front(found)]), plot)


def print_least(found: "LeastGains") -> None:
    """Print what was sought, what holds it, and what is to be known about it."""
    import numpy as np

    from tvclin.cli.output import print_table

    what = {
        "peak": "largest deflection of the linear loop",
        "boundary": "least limit with which flights survive",
    }[found.meaning]
    trims = found.question.trims
    rows = [
        [name, f"{np.degrees(one):.4f}", f"{one / trim:.3f}"]
        for name, one, trim in zip(found.question.names, found.each, trims, strict=True)
    ]
    print_table(f"Least nozzle: {what}", ["", "[deg]", "of trim"], rows)
    typer.echo(f"Held by: {', '.join(found.active) or 'no constraint, a flat minimum'}")
    for note in found.notes:
        typer.echo(f"Note: {note}")
