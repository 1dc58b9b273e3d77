"""What the autopilot of a flight uses of the nozzle, in `tvclin ascent`."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from tvclin.base.lines import Table
from tvclin.case.case import Case
from tvclin.cli.output import bar
from tvclin.requirement.flight.deflection_use import DeflectionUse
from tvclin.requirement.flight.sizing import Sizing
from tvclin.requirement.required_quantity import Requirement
from tvclin.studyfile.flight_loop import FlightLoop, FlightsOfLoop
from tvclin.studyfile.read import is_flight
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.coefficients import BOTH


@dataclass(frozen=True, eq=False)
class AutopilotUse:
    """Required, used and remaining deflection by flight time, and the flights of the autopilot."""

    use: DeflectionUse
    flights: FlightsOfLoop

    @property
    def table(self) -> Table:
        """The joint table by flight time."""
        caption = "Required, used by the autopilot, and remaining deflection [deg]"
        return replace(self.use.table(), caption=caption)

    @property
    def notes(self) -> Iterator[str]:
        """The verdict on the flights of the autopilot, and notes on them."""
        yield f"flown by the autopilot: {self.flights.verdict}"
        yield from self.flights.notes
        yield from (f"autopilot requirement NOT KNOWN: {reason}" for reason in self.use.reasons)

    @property
    def document(self) -> dict[str, Any]:
        """The deflections and the flights, for JSON."""
        return {"deflection_use": self.use, "autopilot": self.flights.document()}


def is_scheduled(case: Case, source: str) -> bool:
    """Return whether a file has an autopilot over the flight, not of one flight time."""
    if not isinstance(case, StudyPlan) or case.sizing is None:
        return False
    return case.sizing.scheduled_design is not None or (
        case.design is not None and is_flight(source)
    )


def autopilot_use(
    case: StudyPlan, source: str, sizing: Sizing, counted: Requirement, more: bool
) -> AutopilotUse | None:
    """Return the use of the nozzle by the autopilot of a file; None without a limit.

    None also in both planes, at a single flight time, and without an autopilot over the flight.
    `more`: whether the autopilot requirement, which takes seconds for each flight time, is found.
    """
    single = case.planes == BOTH or sizing.times.size < 2
    if single or case.nozzle.limit is None or not is_scheduled(case, source):
        return None
    loop = FlightLoop.of(case)
    with bar("flights of the autopilot") as progress:
        return AutopilotUse(*loop.use(sizing, counted, requirements=more, progress=progress))
