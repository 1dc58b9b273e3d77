"""`tvclin margins`: the stability margins of an autopilot, and its criteria."""

from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tvclin.base.errors import InputError, one_of
from tvclin.base.fields import document
from tvclin.base.quantities import NOMINAL, satisfaction
from tvclin.base.tables import known
from tvclin.case.autopilot_assumptions import gain_notes
from tvclin.cli.criteria import MODES, CriteriaOptions
from tvclin.cli.gains import GAINS
from tvclin.cli.inputs import case_of, note_left_out, only_with
from tvclin.cli.margin_tables import MarginsFound, margins_document, print_margins
from tvclin.cli.options import (
    BOTH_LIMITS,
    GROUP,
    MOTION,
    TIMING,
    At,
    Given,
    Rigid,
    Shown,
    Source,
    asked,
    switch,
)
from tvclin.cli.output import answer, draw, print_tables, say, say_lines, say_notes
from tvclin.cli.wind import WindOptions, wind_words
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.design_rules import LEAST_NOZZLE
from tvclin.control.autopilot.detuning import Detuned
from tvclin.control.laws.attitude import SaturatedLaw
from tvclin.control.margins.criteria import Criteria
from tvclin.design.gain_designs import specified_autopilot
from tvclin.design.worst_case import BOX_TABLE, WorstCase, unit_of, worst_case
from tvclin.flights.closed_loop.flown_margins import FlownMargins, flown_margins, flown_table
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.linear_vehicle import complete_vehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.shaped import ShapedWind

if TYPE_CHECKING:
    from control import ControlPlot


Box = Annotated[
    list[str] | None,
    typer.Option(
        "--box",
        metavar="KEY=LO..HI",
        help="A number that may lie anywhere between two values, as delay_ms=0..40 or"
        " thrust_kN=2400..2600: a key with its unit, as in a vehicle file. Or in percent of the"
        " nominal value, without a unit: thrust=-3%..3%. May be given several times. Keys: those"
        " of a vehicle, wind_peak, wind_duration, the gains, gain (a factor on all gains), delay,"
        " actuator_frequency and actuator_damping.",
    ),
]


@dataclass(frozen=True, eq=False)
class BoxResult:
    """The worst case in a box, and the criteria of its margins."""

    worst: WorstCase
    criteria: Criteria

    @property
    def met(self) -> bool:
        """Whether the worst margins satisfy the criteria, as far as they are known."""
        return self.worst.stable and all(
            self.worst.margins[criterion.margin].value >= criterion.limit
            for criterion in self.criteria.limits
            if criterion.margin in self.worst.margins
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the worst case and the verdict, for JSON."""
        return self.worst.as_dict() | {"met": self.met}

    def print(self) -> None:
        """Print the worst margins and deflection, the numbers that give them, and the verdict."""
        print_tables(self.worst.table())
        if not self.worst.stable:
            say("In this box the loop becomes UNSTABLE; its margins count as zero there.")
        disk = self.worst.margins["disk_margin"]
        at = ", ".join(f"{k} = {v:.5g} {unit_of(k)}".rstrip() for k, v in disk.at.items())
        say(f"Worst disk margin at: {at}")
        say(f"Criteria {self.criteria.name} in the box: {satisfaction(self.met)}")


def worst_in_box(given: list[str], case: StudyPlan, autopilot: Autopilot) -> BoxResult | None:
    """Return the worst case in the box of the options, of the rigid vehicle; None without one."""
    if not given:
        return None
    vehicle, wind = complete_vehicle(case.vehicle, "--box"), case.wind_in_plane
    loop = replace(autopilot, sample_rate=None)
    if not isinstance(wind, ShapedWind):
        raise InputError(
            "--box moves peak and duration of a pulse: give no --winds with it; --flown goes"
            " through a sounding"
        )
    box: dict[str, tuple[float, float]] = {}
    for text in given:
        name, ends = _interval(text, vehicle, loop, wind)
        if name in box:
            raise InputError(f"--box gives {name} twice")
        box[name] = ends
    if autopilot.sample_rate is not None:
        say("Note: the margins in the box are of the continuous autopilot.", err=True)
    worst = worst_case(vehicle, loop, box, model=case.plant.model, plane=case.plane, wind=wind)
    return BoxResult(worst, case.held_to.without_mode_limits or case.held_to)


def _interval(
    text: str, vehicle: Vehicle, autopilot: Autopilot, wind: ShapedWind
) -> tuple[str, tuple[float, float]]:
    """Return the name of a number, and its two ends [SI]."""
    key, (low, high), percent = _split(text)
    if not low < high:
        raise InputError(f"--box must have a smaller and a larger value, LO..HI; got {text!r}")
    if not percent:
        ((name, factor),) = BOX_TABLE.read({key: 1.0}).items()
        return name, (factor * low, factor * high)
    known("number of --box", [key], BOX_TABLE.quantities)
    centre = _nominal(key, vehicle, autopilot, wind)
    if not centre:
        raise InputError(
            f"--box {text}: {key} has no nominal value for a percentage; give both ends in its unit"
        )
    factor = 0.01 * abs(centre)
    return key, (centre + factor * low, centre + factor * high)


def _split(text: str) -> tuple[str, tuple[float, float], bool]:
    """Return the key, the two numbers, and whether they are in percent."""
    key, equals, ends = text.partition("=")
    low, dots, high = (end.strip() for end in ends.partition(".."))
    if not equals or not dots:
        raise InputError(
            f"--box must be KEY=LO..HI, as in delay_ms=0..40 or thrust=-3%..3%; got {text!r}"
        )
    percent = low.endswith("%") and high.endswith("%")
    if percent:
        low, high = low.removesuffix("%"), high.removesuffix("%")
    try:
        return key.strip(), (float(low), float(high)), percent
    except ValueError:
        raise InputError(
            f"--box must have two numbers beside the dots, both in percent or neither; got {text!r}"
        ) from None


def _nominal(name: str, vehicle: Vehicle, autopilot: Autopilot, wind: ShapedWind) -> float:
    """Return the nominal value of a number; zero where none is defined."""
    actuator = autopilot.actuator
    values: dict[str, Any] = {**vars(vehicle), **vars(autopilot), **wind.nominal, "gain": 1.0}
    if actuator is not None:
        values["actuator_frequency"] = actuator.natural_frequency
        values["actuator_damping"] = actuator.damping
    value = values.get(name)
    return float(value) if isinstance(value, int | float) else 0.0


_CHARTS = ("nichols", "bode", "nyquist", "root-locus")
"""Names of the charts of --chart."""


def margins(
    vehicle: Source = "configuration-i",
    time: At = None,
    gains: Given = GAINS,
    criteria: CriteriaOptions = GROUP,
    rigid: Rigid = False,
    detuned: bool = switch(
        "--detuned",
        "Also print the margins with the frequency of each mode off by up to 20 percent,"
        " with half its damping, and with the signs of its slopes at the sensors reversed; the"
        " criteria judge these too.",
    ),
    box: Box = None,
    motion: Given = MOTION,
    chart: str = asked("What --plot draws: nichols, bode, nyquist or root-locus.", "nichols"),
    flown: bool = switch(
        "--flown",
        "Also fly the wind with --limit-deg, and print what may change before it is lost.",
    ),
    limits: Given = BOTH_LIMITS,
    winds: WindOptions = GROUP,
    timing: Given = TIMING,
    shown: Shown = GROUP,
) -> None:
    """Print the stability margins of an attitude and rate autopilot, and judge them.

    A vehicle file with bending, slosh, engine inertia or sensor lags makes a flexible vehicle: its
    margins are printed as a whole and for each mode. --rigid leaves all that out. With --detuned
    the criteria judge the margins with each change of a mode too.

    --flown flies through the wind with the limit --limit-deg, at nominal dynamic pressure, and
    prints how much gain, effectiveness and delay may change before a flight is lost. The criteria
    judge the linear margins, not these.

    --box lets numbers lie anywhere between two values, and prints the worst margins of the rigid
    vehicle there, and the worst required deflection. The criteria judge the worst margins too.

    Exit code 0: the criteria are MET; 1: NOT MET, as of an unstable loop; 2: bad input.
    """
    one_of("--chart", chart, _CHARTS)
    if not flown:
        limits.only_with("--flown")
    changes = [options.over for options in (limits, timing, motion, criteria, gains)]
    case = case_of(vehicle, *changes, wind=winds.over, rigid=rigid, time=time)
    only_with(MODES, detuned=detuned and case.vehicle.structure is None)
    aside = ["margins --box"] * bool(box) + ["margins without --flown"] * (not flown)
    if not (flown or box or case.autopilot_design.design == LEAST_NOZZLE):
        only_with("--flown or --box", **vars(winds))
        aside += ["margins without --flown and --box"]
    note_left_out(case, "margins", *aside)
    autopilot = specified_autopilot(case, case.history, case.held_to)
    loop_margins = MarginsFound.of(autopilot, case.plant, case.held_to)
    moved = loop_margins.detuned if detuned else None
    in_wind = _flown(case, autopilot) if flown and loop_margins.whole.stable else None
    in_box = worst_in_box(box or [], case, autopilot)
    draw(shown.plot, lambda: _chart(chart, loop_margins))
    result = _Answer(case, loop_margins, winds.name(case), moved, in_wind, in_box)
    answer(shown.as_json, result.document, lambda: result.print(vehicle), result.met)


@dataclass(frozen=True, eq=False)
class _Answer:
    """Margins, with those of detuned modes, flown in a wind, and in a box, on request."""

    case: StudyPlan
    found: MarginsFound
    wind: str
    moved: Detuned | None
    in_wind: FlownMargins | None
    in_box: BoxResult | None

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Notes on gains that were not specified, and on gains that satisfy the criteria."""
        return tuple(gain_notes(self.case, self.case.held_to, self.found.met))

    @property
    def met(self) -> bool:
        """Whether the criteria are satisfied, with detuned modes and in the box too."""
        more = (self.moved and self.moved.all_satisfied, self.in_box and self.in_box.met)
        return self.found.met and False not in more

    def document(self) -> dict[str, Any]:
        """Return it for JSON."""
        case = self.case
        wind = {"name": self.wind, **document(case.history, "peak")}
        further = {
            "wind": self.in_wind and wind,
            "detuned": self.moved,
            "flown": self.in_wind,
            "box": self.in_box,
        }
        head = {"vehicle": case.vehicle.name, "model": case.plant.model, "plane": case.plane}
        more = {name: value for name, value in further.items() if value is not None}
        margins = margins_document(self.found)
        return head | margins | more | {"notes": (*margins["notes"], *self.notes)}

    def print(self, source: str) -> None:
        """Print all margins, notes and verdicts."""
        case = self.case
        head = f"{case.vehicle.name or source}, {case.plant.model}, {case.plane}"
        print_margins(head, self.found)
        say_notes(self.notes)
        if self.moved is not None:
            print_tables(self.moved.table())
            say_lines(self.moved.stability_lines)
            say(f"Criteria {self.found.asked.name} with detuned modes: {self.moved.verdict}")
        if self.in_wind is not None:
            _print_flown(self.in_wind, case, self.wind)
        if self.in_box is not None:
            self.in_box.print()


def _flown(case: StudyPlan, autopilot: Autopilot) -> FlownMargins:
    """Return the flown margins of a case and its autopilot, sampled with a computer's delay."""
    limit, law = case.nozzle.limit, SaturatedLaw.of(autopilot)
    if limit is None:
        raise InputError("--flown needs --limit-deg, the deflection limit in deg")
    return flown_margins(case.plant, law, case.history, limit=limit, **case.hardware)


def _print_flown(flown: FlownMargins, case: StudyPlan, name: str) -> None:
    """Print flown margins in a wind with a name, and notes on them."""
    title = (
        f"In this {wind_words(name, case)}, {NOMINAL}, with a limit of"
        f" {degrees(case.nozzle.limit or 0.0):g} deg, {case.hardware['sample_rate']:g} Hz"
    )
    print_tables(flown_table(flown, title))
    say(
        f"The limit is {flown.limit:.4g} of full trim, {flown.spare:.4g} times the boundary of the"
        " autopilot."
    )
    say_notes(flown.notes)


def _chart(name: str, loop_margins: MarginsFound) -> "ControlPlot":
    """Return the figure with a name, one of `_CHARTS`."""
    from tvclin import plots

    if name == "nichols":
        return plots.nichols_chart(loop_margins.autopilot, loop_margins.plant, loop_margins.asked)
    charts = {
        "bode": plots.bode_chart,
        "nyquist": plots.nyquist_chart,
        "root-locus": plots.root_locus_chart,
    }
    return charts[name](loop_margins.autopilot, loop_margins.plant)
