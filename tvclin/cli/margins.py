"""`tvclin margins`: the stability margins of an autopilot, and its criteria."""

from dataclasses import dataclass
from functools import cached_property
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tvclin.base.errors import one_of
from tvclin.base.fields import document
from tvclin.base.quantities import NOMINAL
from tvclin.case.autopilot_assumptions import gain_notes
from tvclin.cli.gains import GAINS
from tvclin.cli.inputs import FROZEN, case_of, note_omissions, only_with
from tvclin.cli.margin_tables import (
    JudgedMargins,
    margin_tables,
    margins_document,
    mode_notes,
    print_autopilot,
    print_bounds,
)
from tvclin.cli.options import (
    GROUP,
    LIMIT,
    MOTION,
    TIMING,
    At,
    Given,
    More,
    ShownCurves,
    Source,
    System,
    asked,
    switch,
    to_write,
)
from tvclin.cli.output import answer, draw, print_answer, say_lines
from tvclin.cli.wind import WindOptions, wind_words
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.design_rules import LEAST_NOZZLE
from tvclin.control.autopilot.detuning import Detuned
from tvclin.control.laws.attitude import SaturatedLaw
from tvclin.design.gain_designs import specified_autopilot
from tvclin.flights.closed_loop.flown_margins import FlownMargins, flown_margins, flown_table
from tvclin.linear.system_file import write_system
from tvclin.studyfile.read import is_flight
from tvclin.studyfile.study_plan import StudyPlan

if TYPE_CHECKING:
    from control import ControlPlot


_CHARTS = ("nichols", "bode", "nyquist", "root-locus")
"""Names of the charts of --chart."""
_MODES = "modes: a vehicle file with [[bending]] or [[slosh]], and no rigid = true in [study]"


@dataclass(frozen=True)
class _ShownMargins(ShownCurves):
    """Options for showing margins: the CSV file is that of a whole flight."""

    csv: Annotated[
        Path | None,
        typer.Option(
            help="Of a whole flight, also write the margins by flight time into this CSV file.",
            callback=to_write,
        ),
    ] = None


def margins(
    vehicle: Source = "configuration-i",
    time: At = None,
    gains: Given = GAINS,
    timing: Given = TIMING,
    motion: Given = MOTION,
    detuned: bool = switch(
        "--detuned",
        "Also print the margins with the frequency of each mode off by up to 20 percent,"
        " with half its damping, and with the signs of its slopes at the sensors reversed; the"
        " criteria judge these too.",
    ),
    limit: Given = LIMIT,
    winds: WindOptions = GROUP,
    chart: str = asked(
        "What --plot draws of a single time: nichols, bode, nyquist or root-locus.", "nichols"
    ),
    system: System = None,
    more: More = False,
    shown: _ShownMargins = GROUP,
) -> None:
    """Print the stability margins of an attitude and rate autopilot, and judge them.

    Of a flight schedule without --at, or a study of one without time_s, they are those of the
    whole flight, each time as if frozen, with the frequency of each mode 10 percent off too.

    The criteria are classic, 6 dB and 30 deg; --set criteria.name aircraft takes 6 dB and 45 deg,
    and other keys of the table criteria single numbers.

    A vehicle file with bending, slosh, engine inertia or sensor lags makes a flexible vehicle: its
    margins are printed as a whole and for each mode. --set study.rigid true leaves all that out.

    With --limit-deg it also flies through the wind with that limit, at nominal dynamic pressure,
    and prints how much gain, effectiveness and delay may change before a flight is lost. The
    criteria judge the linear margins, not these.

    --system writes the loop, opened at the nozzle's command, with the sign of 1 + L = 0.

    Exit code 0: the criteria are MET; 1: NOT MET, as of an unstable loop; 2: bad input.
    """
    one_of("--chart", chart, _CHARTS)
    flown = bool(limit.values)
    changes = [options.over for options in (limit, timing, motion, gains)]
    if time is None and is_flight(vehicle):
        from tvclin.cli.whole_flight import flight_loop, print_sweep

        only_with(FROZEN, system=system, detuned=detuned, limit_deg=flown or None, **vars(winds))
        print_sweep(vehicle, flight_loop(vehicle, *changes), more, shown)
        return
    only_with("a whole flight: a flight schedule without --at", csv=shown.csv)
    case = case_of(vehicle, *changes, wind=winds.over, time=time)
    only_with(_MODES, detuned=detuned and case.vehicle.structure is None)
    aside = ["margins without --limit-deg"] * (not flown)
    if not flown and case.autopilot_design.design != LEAST_NOZZLE:
        only_with("--limit-deg", **vars(winds))
        aside += ["margins without a wind"]
    note_omissions(case, "margins", *aside)
    autopilot = specified_autopilot(case, case.history, case.held_to)
    loop = JudgedMargins.of(autopilot, case.plant, case.held_to)
    in_wind = _flown(case, autopilot) if flown and loop.whole.stable else None
    result = _Answer(case, loop, winds.name(case), loop.detuned if detuned else None, in_wind)
    draw(shown.plot, lambda: _chart(chart, loop))
    if system is not None:
        write_system(autopilot.loop(case.plant), system)
    answer(shown.as_json, result.document, lambda: result.print(vehicle, more), result.satisfied)


@dataclass(frozen=True, eq=False)
class _Answer:
    """Margins of a loop, of its detuned modes, and of its flights in a wind with a limit."""

    case: StudyPlan
    margins: JudgedMargins
    wind: str
    detuned: Detuned | None
    in_wind: FlownMargins | None

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Notes on gains that were not specified, and on gains that satisfy the criteria."""
        return tuple(gain_notes(self.case, self.case.held_to, self.margins.satisfied))

    @property
    def satisfied(self) -> bool:
        """Whether the criteria are satisfied, with detuned modes too."""
        return self.margins.satisfied and (self.detuned is None or bool(self.detuned.all_satisfied))

    def document(self) -> dict[str, Any]:
        """Return the document of the answer for JSON."""
        case = self.case
        wind = {"name": self.wind, **document(case.history, "peak")}
        further = {
            "wind": self.in_wind and wind,
            "detuned": self.detuned,
            "flown": self.in_wind,
        }
        head = {"vehicle": case.vehicle.name, "model": case.plant.model, "plane": case.plane}
        more = {name: value for name, value in further.items() if value is not None}
        margins = margins_document(self.margins)
        return head | margins | more | {"notes": (*margins["notes"], *self.notes)}

    def print(self, source: str, more: bool) -> None:
        """Print the verdict, the margins, notes and, with `more`, the autopilot and its bounds."""
        case, loop = self.case, self.margins
        head = f"{case.vehicle.name or source}, {case.plant.model}, {case.plane}"
        tables = list(margin_tables(loop, f"{head}: margins"))
        verdict, notes = loop.verdict, [*self.notes, *mode_notes(loop)]
        if self.detuned is not None:
            verdict += f"; with detuned modes: {self.detuned.verdict}"
            tables.append(self.detuned.table())
        if self.in_wind is not None:
            title = (
                f"In this {wind_words(self.wind, case)}, {NOMINAL}, with a limit of"
                f" {degrees(case.nozzle.limit or 0.0):g} deg,"
                f" {case.hardware['sample_rate']:g} Hz"
            )
            tables.append(flown_table(self.in_wind, title))
            notes = [
                f"the limit is {self.in_wind.limit:.4g} of full trim, {self.in_wind.spare:.4g}"
                " times the boundary of the autopilot",
                *self.in_wind.notes,
                *notes,
            ]

        def details() -> None:
            if self.detuned is not None:
                say_lines(self.detuned.stability_lines)
            print_autopilot("Autopilot", loop.autopilot, case.plant)
            if loop.whole.stable:
                print_bounds(loop.autopilot, case.plant)

        notes = [*loop.whole.notes, *notes]
        print_answer(verdict, *tables, notes=notes, more=more, details=details)


def _flown(case: StudyPlan, autopilot: Autopilot) -> FlownMargins:
    """Return the flown margins of a case and its autopilot, sampled with a computer's delay."""
    limit, law = case.nozzle.limit, SaturatedLaw.of(autopilot)
    assert limit is not None  # by --limit-deg
    return flown_margins(case.plant, law, case.history, limit=limit, **case.hardware)


def _chart(name: str, margins: JudgedMargins) -> "ControlPlot":
    """Return the figure with a name, one of `_CHARTS`."""
    from tvclin import plots

    if name == "nichols":
        return plots.nichols_chart(margins.autopilot, margins.plant, margins.criteria)
    charts = {
        "bode": plots.bode_chart,
        "nyquist": plots.nyquist_chart,
        "root-locus": plots.root_locus_chart,
    }
    return charts[name](margins.autopilot, margins.plant)
