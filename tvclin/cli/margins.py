"""`tvclin margins`: the stability margins of an autopilot, and its criteria; also for `design`."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from tvclin.base.errors import InputError, one_of
from tvclin.base.fields import document
from tvclin.base.lines import Table, quantities
from tvclin.base.quantities import NOMINAL, survival
from tvclin.case.flexible_autopilot import gain_notes
from tvclin.cli.inputs import FROZEN, case_of, note_omissions, note_single_time, only_with
from tvclin.cli.options import (
    GAINS,
    GROUP,
    LIMIT,
    MODEL_AND_PLANE,
    TIMING,
    At,
    More,
    Options,
    ShownCurves,
    Source,
    System,
    option,
    switch,
    to_write,
)
from tvclin.cli.output import answer, draw, print_answer, print_tables, say, say_lines
from tvclin.cli.wind import WindOptions, wind_words
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.design_rules import LEAST_NOZZLE
from tvclin.control.autopilot.detuning import Detuned, detuning_note, stable_ranges
from tvclin.control.autopilot.judged_margins import JudgedMargins
from tvclin.control.autopilot.margin_bounds import MarginBounds, margin_bounds
from tvclin.control.laws.autopilot_law import SaturatedLaw
from tvclin.control.margins.criteria import band_table, margin_table
from tvclin.control.margins.loop import Loop, SampledLoop, poles_in_s
from tvclin.design.gain_designs import specified_autopilot
from tvclin.flights.closed_loop.flown_margins import (
    FlownMargins,
    LostFlightError,
    flown_margins,
    flown_table,
)
from tvclin.linear.flexible import AnyPlant, FlexiblePlant
from tvclin.linear.system_file import write_system
from tvclin.studyfile.read import is_flight
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.structure import Structure

if TYPE_CHECKING:
    from control import ControlPlot


_MAX_POLE_DISTANCE_RATIO = 0.05
"""Largest distance of a pole with approximate delay from an exact pole, over its magnitude."""
_MIN_SHOWN_Z = 1e-3
"""Smallest pole z of a sampled loop that is shown: below, rounding turns those at 0 into others.
These are counted."""
_KEYS = {"gain": "mode_gain_margin_dB", "phase": "mode_phase_margin_deg"}
"""Key of the required margin of a mode, by its stabilisation."""


def margin_tables(result: JudgedMargins, title: str = "Margins") -> tuple[Table, ...]:
    """Return the tables of the margins of a loop and, of a flexible vehicle, by band.

    `title`: caption of the first.
    """
    tables = [margin_table(result.whole, result.judged)] if result.whole.stable else []
    if result.bands is not None:
        tables.append(band_table(result.bands, result.judged))
    return tuple(
        replace(table, caption=title if not k else table.caption) for k, table in enumerate(tables)
    )


def mode_notes(result: JudgedMargins) -> Iterator[str]:
    """Yield notes on modes without a required margin."""
    if result.bands is None:
        return
    judged = {item.band for item in result.judged if item.band and not isnan(item.value)}
    for word, key in _KEYS.items():
        free = [mode.name for mode in result.bands.modes if mode.stabilised == word]
        if free and judged.isdisjoint(free):
            yield (
                f"{', '.join(free)}: {word}-stabilised, without a required margin ({key} in"
                " [criteria]); the margins of the whole loop count"
            )


def print_autopilot(title: str, autopilot: Autopilot, plant: AnyPlant) -> None:
    """Print an autopilot, with the poles of its loop.

    `title`: caption of the table. `plant`: plant of the loop.
    """
    rows = autopilot.rows()
    label = "closed-loop poles" if autopilot.sample_rate is None else "closed-loop poles, log(z)/h"
    rows.append((f"{label} [1/s]", (_poles(autopilot, plant),)))
    print_tables(quantities(title, rows), *autopilot.filter_tables())


def print_parts(plant: AnyPlant) -> None:
    """Print the line that lists the parts of a flexible vehicle; nothing for a rigid `plant`."""
    if plant.structure is not None:
        say(parts_line(plant.structure))


def parts_line(structure: Structure) -> str:
    """Return the line that lists the parts of a flexible vehicle."""
    return f"Flexible vehicle (--set study.rigid true: without): {structure.parts}"


def print_bounds(autopilot: Autopilot, plant: AnyPlant) -> None:
    """Print the bounds on the margins of any autopilot with this plant, actuator and delay."""
    bounds = _bounds(autopilot, plant)
    if bounds is not None and bounds.sentence:
        say(f"Bounds: {bounds.sentence}.")


def _bounds(autopilot: Autopilot, plant: AnyPlant) -> MarginBounds | None:
    """Return the bounds on the margins of any autopilot with a plant, and this actuator and delay.

    None for a plant without an unstable pole.
    """
    try:
        return margin_bounds(plant, actuator=autopilot.actuator, delay=float(autopilot.delay))
    except InputError:
        return None


def _poles(autopilot: Autopilot, plant: AnyPlant) -> str:
    """Return the closed-loop poles [1/s] as text, without the poles that only model a delay.

    Of a loop in continuous time these are stable poles of the Pade approximation that no pole of
    the exact loop is near, of a sampled loop, whose poles are log(z)/h, those at z = 0, which are
    counted. A conjugate pair is one entry, with ±.
    """
    if autopilot.sample_rate is not None:
        return _sampled_poles(autopilot.exact_loop(plant))
    poles = autopilot.closed_loop_poles(plant)
    if autopilot.delay:
        exact = autopilot.exact_loop(plant).closed_loop_poles
        distance = np.abs(poles[:, np.newaxis] - exact).min(axis=1)
        poles = poles[(poles.real > 0.0) | (distance <= _MAX_POLE_DISTANCE_RATIO * np.abs(poles))]
    shown = [_pole_or_pair(p) for p in np.sort_complex(poles)[::-1] if p.imag >= 0.0]
    return ", ".join(dict.fromkeys(shown))


def _sampled_poles(loop: Loop) -> str:
    """Return the closed-loop poles log(z)/h [1/s] of a sampled loop as text.

    That of a real z < 0 has no conjugate pole and is shown with its z.
    """
    z, poles = loop.closed_loop_poles, poles_in_s(loop)
    visible = np.abs(z) > _MIN_SHOWN_Z
    shown = [
        f"{p.real:.4g}+{p.imag:.4g}j (z = {z[k].real:.4g})"
        if z[k].imag == 0.0 and z[k].real < 0.0
        else _pole_or_pair(p)
        for k, p in sorted(enumerate(poles), key=lambda item: (-item[1].real, -item[1].imag))
        if visible[k] and p.imag >= 0.0
    ]
    if not np.all(visible):
        shown.append(f"{np.sum(~visible)} with |z| < {_MIN_SHOWN_Z:g}")
    return ", ".join(dict.fromkeys(shown))


def _pole_or_pair(pole: complex) -> str:
    """Return a real pole [1/s] as text, or a complex one with its conjugate."""
    return f"{pole.real:.4g}" if pole.imag == 0.0 else f"{pole.real:.4g}±{pole.imag:.4g}j"


def margins_document(result: JudgedMargins) -> dict[str, Any]:
    """Return gains, poles, margins and criteria for JSON; what does not exist becomes null."""
    loop_margins, autopilot = result.whole, result.autopilot
    return {
        "flexible": result.bands is not None,
        "autopilot": autopilot,
        **poles_document(autopilot, result.plant),
        "stable": loop_margins.stable,
        "status": loop_margins.status,
        "reason": loop_margins.reason or None,
        "margins": loop_margins,
        "bounds": _bounds(autopilot, result.plant),
        **({} if result.bands is None else {"bands": result.bands}),
        "criteria": {
            "name": result.criteria.name,
            "satisfied": result.satisfied,
            "limits": result.judged,
        },
        "notes": loop_margins.notes,
    }


def poles_document(autopilot: Autopilot, plant: AnyPlant) -> dict[str, Any]:
    """Return the closed-loop poles: s [1/s], or z of a sampled autopilot."""
    if autopilot.sample_rate is None:
        return {"closed_loop_poles": autopilot.closed_loop_poles(plant).tolist()}
    loop = autopilot.exact_loop(plant)
    assert isinstance(loop, SampledLoop)
    return {"closed_loop_poles_z": loop.closed_loop_poles.tolist()}


_CHARTS = ("nichols", "bode", "nyquist", "root-locus")
"""Names of the charts of --chart."""
_MODES = "modes: a vehicle file with [[bending]] or [[slosh]], and no rigid = true in [study]"


@dataclass(frozen=True)
class _ShownMargins(ShownCurves):
    """Options for showing margins: the CSV file holds the margins over a flight."""

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
    gains: Options = GAINS,
    timing: Options = TIMING,
    model: Options = MODEL_AND_PLANE,
    detuned: bool = switch(
        "--detuned",
        "Also print the margins with the frequency of each mode off by up to 20 percent,"
        " with half its damping, and with the signs of its slopes at the sensors reversed; the"
        " criteria judge these too.",
    ),
    limit: Options = LIMIT,
    winds: WindOptions = GROUP,
    chart: str = option(
        "What --plot draws of a single time: nichols, bode, nyquist or root-locus.", "nichols"
    ),
    system: System = None,
    more: More = False,
    shown: _ShownMargins = GROUP,
) -> None:
    """Print the stability margins of an autopilot whose gains are given, and judge them.

    tvclin design finds gains. Without any, these are textbook gains. --more also prints the poles
    of the closed loop.

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

    Exit code 0: the criteria are MET; 1: NOT MET, as of an unstable loop, or the flight is NOT
    SURVIVED even without such changes; 2: bad input.
    """
    one_of("--chart", chart, _CHARTS)
    flown = bool(limit.values)
    changes = [options.applied_to for options in (limit, timing, model, gains)]
    if time is None and is_flight(vehicle):
        from tvclin.cli.whole_flight import flight_loop, print_sweep

        only_with(FROZEN, system=system, detuned=detuned, limit_deg=flown or None, **vars(winds))
        print_sweep(vehicle, flight_loop(vehicle, *changes), more, shown)
        return
    only_with("a whole flight: a flight schedule without --at", csv=shown.csv)
    case = case_of(vehicle, *changes, wind=winds.applied_to, time=time)
    note_single_time(vehicle, time)
    only_with(_MODES, detuned=detuned and case.vehicle.structure is None)
    questions = ["margins without --limit-deg"] * (not flown)
    if not flown and case.autopilot_design.design != LEAST_NOZZLE:
        only_with("--limit-deg", **vars(winds))
        questions += ["margins without a wind"]
    note_omissions(case, "margins", *questions)
    autopilot = specified_autopilot(case, case.history, criteria=case.margin_criteria)
    loop = JudgedMargins.of(autopilot, case.plant, case.margin_criteria)
    in_wind = _flown(case, autopilot) if flown and loop.whole.stable else None
    result = _Answer(case, loop, winds.name(case), loop.detuned if detuned else None, in_wind)
    draw(shown.plot, lambda: _chart(chart, loop))
    if system is not None:
        write_system(autopilot.loop(case.plant), system)
    answer(shown.as_json, result.document, lambda: result.print(vehicle, more), result.satisfied)


@dataclass(frozen=True, eq=False)
class _Answer:
    """Margins of a loop, of its detuned modes, and of its flights in a wind with a limit.

    `in_wind` is the error where the flight is lost without any change of gain or delay.
    """

    case: StudyPlan
    margins: JudgedMargins
    wind: str
    detuned: Detuned | None
    in_wind: FlownMargins | LostFlightError | None

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Notes on modes slightly off their frequency, and on the gains of the autopilot.

        The note on modes that make a stable loop unstable near their frequency is left out where
        the table of detuned modes, `detuned`, shows that anyway.
        """
        loop, of_modes = self.margins, ""
        if self.detuned is None and loop.whole.stable and loop.bands and loop.bands.modes:
            assert isinstance(loop.plant, FlexiblePlant)
            of_modes = detuning_note(stable_ranges(loop.autopilot, loop.plant))
        notes = (f"{of_modes}; --detuned shows the margins",) if of_modes else ()
        delay, criteria = loop.whole.delay_margin, self.case.margin_criteria
        return (*notes, *gain_notes(self.case, criteria, loop.satisfied, delay))

    @property
    def satisfied(self) -> bool:
        """Whether the criteria are satisfied, with detuned modes too, and no flight is lost."""
        detuned = self.detuned is None or bool(self.detuned.all_satisfied)
        return self.margins.satisfied and detuned and not self._diverged_verdict

    @property
    def _flown_notes(self) -> tuple[str, ...]:
        """Notes on the flights in the wind, or on what the flight that is lost needs."""
        flown = self.in_wind
        if flown is None:
            return ()
        if isinstance(flown, LostFlightError):
            return (flown.sentence,)
        unknown = f"survival is not known: {self.case.unknown_wind}"
        of_boundary = f"{flown.spare:.4g} times the boundary of the autopilot"
        size = f"the limit is {flown.limit:.4g} of full trim, {of_boundary}"
        return (*([unknown] if self.case.unknown_wind else []), size, *flown.notes)

    @property
    def _diverged_verdict(self) -> str:
        """Verdict on a flight that is lost with gain and delay unchanged; empty for another one."""
        if not isinstance(self.in_wind, LostFlightError):
            return ""
        limit = degrees(self.case.nozzle.limit or 0.0)
        return f"{survival(False)} with {limit:g} deg, {NOMINAL}"

    def document(self) -> dict[str, Any]:
        """Return the margins, the criteria and the verdict as a document for JSON.

        Margins in flight, with their wind, are in it if flights were flown (`in_wind`), and the
        verdict on a flight that is lost without any change (`_diverged_verdict`) in their place.
        """
        case = self.case
        wind = {"name": self.wind, **document(case.history, "peak")}
        further = {
            "wind": self.in_wind and wind,
            "detuned": self.detuned,
            "flown": None if self._diverged_verdict else self.in_wind,
        }
        head = {"vehicle": case.vehicle.name, "model": case.plant.model, "plane": case.plane}
        more = {name: value for name, value in further.items() if value is not None}
        margins = margins_document(self.margins)
        notes = (*margins["notes"], *self._flown_notes, *self.notes)
        return (
            head | margins | more | {"notes": tuple(filter(None, (self._diverged_verdict, *notes)))}
        )

    def print(self, source: str, more: bool) -> None:
        """Print the verdict, the margins, notes and, with `more`, the autopilot and its bounds.

        `source`: name of the file, for a vehicle without a name.
        """
        case, loop = self.case, self.margins
        head = f"{case.vehicle.name or source}, {case.plant.model}, {case.plane}"
        tables = list(margin_tables(loop, f"{head}: margins"))
        verdict, notes = loop.verdict, [*self.notes, *mode_notes(loop)]
        if self.detuned is not None:
            verdict += f"; with detuned modes: {self.detuned.verdict}"
            tables.append(self.detuned.table())
        if self._diverged_verdict:
            verdict += f"; {self._diverged_verdict}"
        elif isinstance(self.in_wind, FlownMargins):
            limit, rate = degrees(case.nozzle.limit or 0.0), case.hardware["sample_rate"]
            title = f"In this {wind_words(self.wind, case)}, {NOMINAL}"
            title = f"{title}, with a limit of {limit:g} deg, {rate:g} Hz"
            tables.append(flown_table(self.in_wind, title))

        def details() -> None:
            """Print the stability of detuned modes, the autopilot, and bounds on any margins."""
            if self.detuned is not None:
                say_lines(self.detuned.stability_lines)
            print_parts(case.plant)
            print_autopilot("Autopilot", loop.autopilot, case.plant)
            if loop.whole.stable:
                print_bounds(loop.autopilot, case.plant)

        notes = [*loop.whole.notes, *self._flown_notes, *notes]
        print_answer(verdict, *tables, notes=notes, more=more, details=details)


def _flown(case: StudyPlan, autopilot: Autopilot) -> FlownMargins | LostFlightError:
    """Return the flown margins of a case and its autopilot, sampled with a computer's delay.

    The hardware of the case is sample rate, delay, actuator and rate limit of the flights; its
    deflection limit [rad] is the stop of the law. Margins are changes of gain, effectiveness or
    delay until a flight is lost; of a case lost without any of them, return the error.
    """
    limit, law = case.nozzle.limit, SaturatedLaw.of(autopilot)
    assert limit is not None  # by --limit-deg
    try:
        return flown_margins(case.plant, law, case.history, limit=limit, **case.hardware)
    except LostFlightError as error:
        return error


def _chart(name: str, margins: JudgedMargins) -> "ControlPlot":
    """Return the figure of judged margins with a name, one of `_CHARTS`."""
    from tvclin import plots

    if name == "nichols":
        return plots.nichols_chart(margins.autopilot, margins.plant, margins.criteria)
    charts = {
        "bode": plots.bode_chart,
        "nyquist": plots.nyquist_chart,
        "root-locus": plots.root_locus_chart,
    }
    return charts[name](margins.autopilot, margins.plant)
