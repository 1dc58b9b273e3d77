"""The answer of `tvclin fly`, of any engine: a table, JSON, a CSV file and a figure."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.base.documents import picked
from tvclin.cli.inputs import chosen
from tvclin.cli.options import ShownCurves
from tvclin.cli.output import print_json, print_tables, say, say_notes, say_required
from tvclin.cli.wind import wind_words
from tvclin.flights.theory_comparison import PEAKS, FlightComparison
from tvclin.requirement.case_requirement import CaseRequirement, study_requirement
from tvclin.winds.wind_angles import linear_notes


@dataclass(frozen=True, eq=False)
class Compared:
    """A flight, compared with the linear theory or the rigid vehicle; deflections in rad.

    Both boundaries are None where neither was sought, and the first where that was not. `heads` and
    `ends` stand above and below the table, `title` and `columns` in it; `facts` are for JSON alone.
    """

    case: Any
    flight: FlightComparison
    limit: float
    beside: str
    columns: tuple[str, ...]
    boundary: tuple[float | None, float] | None
    heads: list[str]
    ends: list[str]
    title: str
    facts: dict[str, Any] = field(default_factory=dict)

    def both(self, values: Any) -> dict[str, Any]:
        """Return the values of the flight and of its comparison, by name."""
        return dict(zip(("flown", self.beside), values, strict=True))

    def show(self, shown: ShownCurves) -> bool:
        """Write and print the flight, and return whether it survived."""
        from tvclin.plots import flight_chart, flight_curves

        said = f"{self.case.title}, limit {np.degrees(self.limit):.3f} deg, {self.case.engine}"
        shown.write(
            lambda: flight_curves(
                self.flight, self.limit, "fly", said.replace("\n", ", "), self.beside
            ),
            lambda numbers: flight_chart(numbers, said),
        )
        if shown.as_json:
            print_json(self._document())
        else:
            say("\n".join(self.heads))
            print_tables(self.flight.table(self.title, self.columns, self.boundary))
            say("\n".join(self.ends))
            say_required(self.required)
            say_notes(self.notes)
        return bool(self.flight.survived)

    @cached_property
    def required(self) -> CaseRequirement | None:
        """The required deflection of the study of the case."""
        return study_requirement(self.case.case, chosen(self.case.dead_band, 1.0))

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the wind angle."""
        return linear_notes(float(self.case.wind.peak))

    def _peaks(self) -> dict[str, list[float]]:
        """Return the peak of each quantity over the wind, of flight and comparison [deg]."""
        return {name: np.degrees(self.flight.peaks(name)).tolist() for name in PEAKS}

    def _ends(self) -> list[float | None] | None:
        """Return the boundaries of flight and comparison [deg]; None without boundaries."""
        if self.boundary is None:
            return None
        return [
            None if boundary is None else float(np.degrees(boundary)) for boundary in self.boundary
        ]

    def _document(self) -> dict[str, Any]:
        case, ends = self.case, self._ends()
        return {
            **picked(case, "vehicle=case.vehicle.name engine plane=case.plane law dead_band"),
            "wind": {"shape": case.shape, **picked(case.wind, "peak_deg onset_s end_s")},
            **picked(self, "limit_deg survived=flight.survived"),
            "peaks_over_the_wind_deg": {k: self.both(v) for k, v in self._peaks().items()},
            "boundary_deg": None if ends is None else self.both(ends),
            "pressure": self.case.pressure,
            "required_deflection_deg": self.required
            and float(np.degrees(self.required.required_deflection)),
            "notes": self.notes,
            **self.facts,
        }


def wind_line(case: Any) -> str:
    """Return the vehicle of a case, and in a second line its wind and law."""
    words = wind_words(case.shape, case.case)
    said = f"{words}, {case.case.plane}, law {case.law}"
    return f"{case.case.vehicle.name}\n{said}" if case.case.vehicle.name else said
