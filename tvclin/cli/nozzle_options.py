"""Options of `tvclin nozzle`."""

from dataclasses import dataclass

from tvclin.base.errors import one_of
from tvclin.base.lines import listed
from tvclin.cli.ascent import FlightOptions, PlaneOptions
from tvclin.cli.options import BOTH_LIMITS, GROUP, MODEL, STUDY, Given, asked, switch
from tvclin.control.laws.registry import LAWS

RATE, LOAD, FLIGHT = "rate", "load", "flight"
IN_A_WIND = f"--over {RATE} or {LOAD}"
"""Option of the answers at one flight time."""


@dataclass(frozen=True)
class NozzleOptions:
    """Options of the case of a nozzle; `grouped` gives them to a command."""

    winds: FlightOptions = GROUP
    limits: Given = BOTH_LIMITS
    load: Given = Given("case.load.LoadBound", ("load",), "load")
    law: list[str] | None = asked(
        f"Fly this law with the limits too: {listed(LAWS, 'or')}. May be given several times"
        f" with {IN_A_WIND}.",
        shown=f"none; with --over {FLIGHT} that of the study file, or trim",
    )
    laws: bool = switch(
        "--laws",
        "Fly every law, of a study file those of its laws, at each rate limit, for the limit that"
        " it needs; it takes about a minute.",
    )
    times: Given = Given(
        "requirement.flight.request.SizingRequest", ("start", "stop", "every"), "sizing"
    )
    model: Given = MODEL
    planes: PlaneOptions = GROUP
    dead_band: Given = Given(STUDY, ("dead_band",))

    @property
    def names(self) -> list[str]:
        """Names of the flown laws."""
        return [one_of("--law", item, LAWS) for item in self.law or ()]
