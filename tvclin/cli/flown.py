"""What `tvclin margins --flown` adds: how much may change in this wind, with this stop."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

import typer

from tvclin.cli.output import say

if TYPE_CHECKING:
    from tvclin.cli.pulse import PulseOptions
    from tvclin.control.autopilot.autopilot import Autopilot
    from tvclin.flights.closed_loop.flown_record import FlownMargin, FlownMargins
    from tvclin.linear.flexible import AnyPlant
    from tvclin.vehicle.linear_vehicle import AnyVehicle

Flown = Annotated[
    bool,
    typer.Option(
        "--flown",
        help="Also fly the wind with --limit-deg, and print what may change before it is lost.",
    ),
]
FlownLimitDeg = Annotated[float | None, typer.Option(help="Deflection limit of --flown, in deg.")]
SampleRate = Annotated[
    float | None,
    typer.Option(
        help="Sample rate of the autopilot, in Hz. Without it the margins are of a continuous"
        " autopilot, and --flown samples it at 100."
    ),
]
_RATE = 100.0


@dataclass(frozen=True)
class FlownCase:
    """What is flown: the options of the wind and of the limit."""

    limit_deg: float | None
    blows: "PulseOptions"
    sample_rate: float | None

    def margins(
        self, vehicle: "AnyVehicle", plane: str, plant: "AnyPlant", autopilot: "Autopilot"
    ) -> "FlownMargins":
        """Return the flown margins of an autopilot, in place of its delay a computing delay."""
        import numpy as np

        from tvclin.base.errors import InputError, positive
        from tvclin.control.laws.attitude import SaturatedLaw
        from tvclin.flights.closed_loop.flown_margins import flown_margins

        if self.limit_deg is None:
            raise InputError("--flown needs --limit-deg, the deflection limit in deg")
        limit = float(np.radians(positive("--limit-deg", self.limit_deg, "deg")))
        return flown_margins(
            plant,
            SaturatedLaw(replace(autopilot, actuator=None, delay=0.0, sample_rate=None)),
            self.blows.blowing(vehicle, plane),
            limit=limit,
            actuator=autopilot.actuator,
            sample_rate=self.rate,
            delay=float(autopilot.delay),
        )

    @property
    def rate(self) -> float:
        """Samples of the flights [Hz]."""
        return _RATE if self.sample_rate is None else self.sample_rate

    @property
    def title(self) -> str:
        """The case in one line."""
        return (
            f"In this {self.blows.wind} wind of {self.blows.duration:g} s, with a stop at"
            f" {self.limit_deg:g} deg, {self.rate:g} Hz"
        )


def print_flown(found: "FlownMargins", title: str) -> None:
    """Print flown margins as a table, with what is to be known about them."""
    from tvclin.cli.output import print_table
    from tvclin.flights.closed_loop.flown_record import CHANGES

    rows = [_row(name, getattr(found, name)) for name in CHANGES]
    print_table(title, ["may change", "by", "then it", "near rest"], rows)
    say(
        f"The limit is {found.limit:.4g} of full trim, {found.spare:.4g} times the boundary of the"
        " autopilot."
    )
    for note in found.notes:
        say(f"Note: {note}")


def _row(name: str, one: "FlownMargin") -> list[str]:
    def shown(value: float) -> str:
        if name == "delay":
            return f"{1000.0 * value:.1f} ms"
        return f"{replace(one, value=value).dB:.2f} dB ({value:.4g}x)"

    cause = {"lost": "is lost"}.get(one.cause, one.cause)
    return [name.replace("_", " "), shown(one.value), cause, shown(one.near_rest)]
