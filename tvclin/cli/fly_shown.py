"""What `tvclin fly` shows of a flight, whatever flew: a table, JSON, a CSV file and a figure."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tvclin.cli.output import print_tables, say

if TYPE_CHECKING:
    from tvclin.flights.beside import FlightBeside


@dataclass(frozen=True)
class Shown:
    """Where a flight goes: files, and whether JSON is printed."""

    csv: Path | None
    plot: Path | None
    as_json: bool


@dataclass(frozen=True, eq=False)
class Compared:
    """A flight, and beside it the linear theory or the rigid vehicle.

    Attributes
    ----------
    case : FlightCase or LinearCase
        What was flown.
    flight : FlightBeside
        The flight.
    limit : float
        Of its deflection [rad].
    beside : str
        What stands beside it: linear or rigid.
    columns : tuple of str
        Headings of the table: of the flight, and of what stands beside it where anything does.
    boundary : tuple of float or None
        Both boundaries [rad], the first None where it was not sought; None where neither was.
    heads, ends : list of str
        What is said above the table and below it.
    title : str
        Of the table.
    facts : dict
        What JSON says besides.
    """

    case: Any
    flight: "FlightBeside"
    limit: float
    beside: str
    columns: tuple[str, ...]
    boundary: tuple[float | None, float] | None
    heads: list[str]
    ends: list[str]
    title: str
    facts: dict[str, Any] = field(default_factory=dict)

    def both(self, values: Any) -> dict[str, Any]:
        """Return two values by what they are of."""
        return dict(zip(("flown", self.beside), values, strict=True))

    def show(self, shown: Shown) -> bool:
        """Write and print the flight, and return whether it survived."""
        from tvclin.cli.output import print_json

        self._write(shown)
        if shown.as_json:
            print_json(self._document())
        else:
            self._print()
        return self.flight.survived

    def _peaks(self) -> dict[str, list[float]]:
        """The largest of each over the wind, of both [deg]."""
        import numpy as np

        from tvclin.flights.beside import PEAKS

        return {name: np.degrees(self.flight.peaks(name)).tolist() for name in PEAKS}

    def _ends(self) -> list[float | None] | None:
        """Both boundaries [deg]."""
        import numpy as np

        if self.boundary is None:
            return None
        return [None if one is None else float(np.degrees(one)) for one in self.boundary]

    def _print(self) -> None:
        say("\n".join(self.heads))
        print_tables(self.flight.table(self.title, self.columns, self.boundary))
        say("\n".join(self.ends))

    def _document(self) -> dict[str, Any]:
        from tvclin.base.documents import picked

        case, ends = self.case, self._ends()
        return {
            **picked(case, "vehicle=case.vehicle.name engine plane=case.plane law dead_band"),
            "wind": {"shape": case.shape, **picked(case.wind, "peak_deg onset_s end_s")},
            **picked(self, "limit_deg survived=flight.survived"),
            "peaks_over_the_wind_deg": {k: self.both(v) for k, v in self._peaks().items()},
            "boundary_deg": None if ends is None else self.both(ends),
            **self.facts,
        }

    def _write(self, shown: Shown) -> None:
        import numpy as np

        from tvclin.base.files import write_text
        from tvclin.plots import flight_chart, flight_curves, save_figure

        if shown.csv is None and shown.plot is None:
            return
        said = f"{self.case.title}, limit {np.degrees(self.limit):.3f} deg, {self.case.engine}"
        numbers = flight_curves(self.flight, "fly", said.replace("\n", ", "), self.beside)
        if shown.csv is not None:
            write_text(shown.csv, numbers.csv())
        if shown.plot is not None:
            save_figure(flight_chart(numbers, said, float(self.flight.wind.end)), shown.plot)


def wind_line(case: Any) -> str:
    """Return the vehicle of a case, and in a second line its wind and law."""
    from tvclin.cli.wind import wind_words

    words = wind_words(case.shape, case.case)
    return f"{case.case.vehicle.name or 'Vehicle'}\n{words}, {case.case.plane}, law {case.law}"
