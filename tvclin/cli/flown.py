"""What `tvclin margins --flown` adds: how much may change in this wind, with this stop."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from tvclin.cli.inputs import only_with
from tvclin.cli.options import RateLimitDeg
from tvclin.cli.output import print_tables, say, say_notes

if TYPE_CHECKING:
    from tvclin.answers.case import Case
    from tvclin.control.autopilot.autopilot import Autopilot
    from tvclin.flights.closed_loop.flown_record import FlownMargins


@dataclass(frozen=True)
class FlownOptions:
    """The options in one place; `grouped` gives them to a command."""

    flown: Annotated[
        bool,
        typer.Option(
            "--flown",
            help="Also fly the wind with --limit-deg, and print what may change before it is lost.",
        ),
    ] = False
    limit_deg: Annotated[
        float | None, typer.Option(help="Deflection limit of --flown, in deg.")
    ] = None
    rate_limit_deg: RateLimitDeg = None

    def __post_init__(self) -> None:
        if not self.flown:
            only_with("--flown", limit_deg=self.limit_deg, rate_limit_deg=self.rate_limit_deg)

    def found(self, case: "Case", autopilot: "Autopilot") -> "FlownMargins":
        """Return the flown margins of a case and its autopilot, its delay that of a computer."""
        from tvclin.base.errors import InputError
        from tvclin.control.laws.attitude import SaturatedLaw
        from tvclin.flights.closed_loop.flown_margins import flown_margins

        limit, law = case.nozzle.limit, SaturatedLaw.of(autopilot)
        if limit is None:
            raise InputError("--flown needs --limit-deg, the deflection limit in deg")
        return flown_margins(case.plant, law, case.history, limit=limit, **case.hardware)


def print_flown(found: "FlownMargins", case: "Case", name: str) -> None:
    """Print the flown margins of a case in a wind with a name, and what is odd about them."""
    import numpy as np

    from tvclin.cli.wind import wind_words
    from tvclin.flights.closed_loop.flown_record import flown_table

    title = (
        f"In this {wind_words(name, case)}, with a stop at"
        f" {np.degrees(case.nozzle.limit or 0.0):g} deg, {case.hardware['sample_rate']:g} Hz"
    )
    print_tables(flown_table(found, title))
    say(
        f"The limit is {found.limit:.4g} of full trim, {found.spare:.4g} times the boundary of the"
        " autopilot."
    )
    say_notes(found.notes)
