"""`tvclin laws`: required deflection of each law in the standard winds, with its bounds."""

from dataclasses import dataclass, replace
from functools import partial
from math import degrees
from typing import Any

from tvclin.base.errors import one_of, within
from tvclin.base.lines import listed
from tvclin.base.quantities import NOMINAL
from tvclin.case.flexible_autopilot import with_filters
from tvclin.cli.gains import FlownLaw
from tvclin.cli.inputs import case_of, note_left_out, only_with
from tvclin.cli.margin_tables import parts_line
from tvclin.cli.options import GROUP, MOTION, RATE_LIMIT, At, Given, Rigid, Shown, Source, asked
from tvclin.cli.output import answer, draw, print_tables, say, say_notes
from tvclin.cli.progress import bar
from tvclin.cli.wind import SoundingOptions
from tvclin.control.laws.law import Law
from tvclin.control.laws.registry import AUTOPILOT
from tvclin.design.gain_designs import specified_autopilot
from tvclin.design.standard_trials import (
    LEGEND,
    WINDS,
    Bounds,
    LawTrials,
    bounds,
    law_trials,
    limit_tables,
    limit_warnings,
    load_table,
    scan_text,
    standard_laws,
    standard_winds,
)
from tvclin.linear.flexible import AnyPlant, plant_of
from tvclin.linear.plant import Plant
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.winds.histories import History
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.wind_angles import linear_notes


def _quoted(name: str) -> str:
    return f"'{name}'" if " " in name else name


def laws(
    vehicle: Source = "configuration-i",
    time: At = None,
    wind_options: SoundingOptions = GROUP,
    wind: list[str] | None = asked(
        f"Only this wind; may be given several times: {listed(map(_quoted, WINDS), 'or')}.",
        shown="all",
    ),
    cuts: int = asked("Also fly each wind cut off at so many instants.", 0),
    flies: FlownLaw = GROUP,
    rate_limit: Given = RATE_LIMIT,
    motion: Given = MOTION,
    rigid: Rigid = False,
    shown: Shown = GROUP,
) -> None:
    """Fly five laws in the standard winds and print the deflection limit that each needs.

    It takes about a second for each law and wind, and a minute more for a figure. A vehicle file
    with bending, slosh, engine inertia or sensor lags makes a flexible vehicle, which flies with an
    actuator; a rigid one without, as its bounds. --rigid leaves all that out.

    A gust blows on top of each wind; a sounding, --winds, in place of them all. Gains are those of
    the law autopilot.

    Flights and bounds are at nominal dynamic pressure; tvclin study is the verdict on a limit.

    Exit code 0: answered; 2: bad input.
    """
    from tvclin import plots

    if shown.plot is not None:
        only_with(
            "no --plot: that is drawn of pulses alone",
            winds=wind_options.winds,
        )
    within("--cuts", cuts, 0, 1000)
    changes = rate_limit.over, motion.over, _without_actuator, partial(_with_gains, flies)
    case = case_of(
        vehicle, *changes, wind=wind_options.over, told=("laws",), rigid=rigid, time=time
    )
    plant, hardware = plant_of(case.vehicle, case.law_model, case.plane), case.hardware
    if case.laws is not None and "sample_rate" not in flies.timing.values:
        hardware["sample_rate"] = case.laws.sample_rate
        note_left_out(case, "laws with a rate in [laws]")
    peak, duration, winds = _winds(wind_options, wind, case)
    chosen = _laws(case, plant.rigid, peak)
    with bar("flights") as progress:
        trials = law_trials(plant, chosen, winds, cuts=cuts, progress=progress, **hardware)
    draw(shown.plot, lambda: plots.laws_chart(plant, chosen, peak, **hardware))
    reference_bounds = bounds(plant.rigid, winds)
    result = _Answer(case, plant, peak, duration, hardware["sample_rate"], trials, reference_bounds)
    answer(shown.as_json, lambda: result.document(cuts), lambda: result.print(vehicle))


@dataclass(frozen=True, eq=False)
class _Answer:
    """Trials of laws in winds of a peak [rad] and a duration [s], with bounds of the theory."""

    case: StudyPlan
    plant: AnyPlant
    peak: float
    duration: float
    rate: float
    trials: LawTrials
    bounds: dict[str, Bounds]

    def document(self, cuts: int) -> dict[str, Any]:
        """Return it for JSON."""
        trims = {name: entry.trim_deg for name, entry in self.bounds.items()}
        return {
            "vehicle": self.case.vehicle.name,
            "model": self.plant.model,
            "plane": self.case.plane,
            "peak_deg": degrees(self.peak),
            "duration_s": self.duration,
            "flexible": self.plant.structure is not None,
            "cuts": cuts,
            "notes": linear_notes(self.peak),
            "sample_rate_Hz": self.rate,
            "trim_deflection_deg": max(trims.values()),
            "trials": [
                {**vars(entry), "limit_deg": trims[entry.wind] * entry.limit}
                for entry in self.trials
            ],
            "no_forecast": {name: entry.no_forecast for name, entry in self.bounds.items()},
        }

    def print(self, source: str) -> None:
        """Print the setting of the trials, the required deflection of each law, and notes."""
        if self.plant.structure is not None:
            say(parts_line(self.plant.structure))
            say(f"law at {self.rate:g} Hz, delay {1000.0 * self.case.autopilot_design.delay:g} ms")
        winds = f"winds of {abs(degrees(self.peak)):.4g} deg and {self.duration:g} s"
        servo = self.case.nozzle.actuator
        engine = f"actuator {servo.natural_frequency:g} rad/s" if servo else "no actuator"
        name = self.case.vehicle.name or source
        say(f"{name}, {self.plant.model}, {winds}, {NOMINAL}, {engine}")
        print_tables(*limit_tables(self.trials, self.bounds), load_table(self.trials))
        say(LEGEND)
        say(scan_text(self.trials))
        say_notes((*linear_notes(self.peak), *limit_warnings(self.trials)))


def _without_actuator(plan: StudyPlan) -> StudyPlan:
    """Return the case of laws compared with boundaries: a rigid vehicle has no actuator."""
    if plan.vehicle.structure is not None:
        return plan
    note_left_out(plan, "laws of a rigid vehicle")
    design = plan.design and plan.design.without_filters_and_delay
    return replace(plan, nozzle=replace(plan.nozzle, actuator=None), design=design)


def _with_gains(flies: FlownLaw, plan: StudyPlan) -> StudyPlan:
    """Return a plan with options; `InputError` for gains where no law of its file has them."""
    if plan.laws is not None and AUTOPILOT not in plan.laws.names:
        flies.gains.only_with("the law autopilot in the table [laws]")
    return flies.over(plan)


def _laws(case: StudyPlan, plant: Plant, peak: float) -> dict[str, Law]:
    """Return the laws of the case, designed for a peak [rad], with its filters."""
    autopilot = specified_autopilot(case, case.history, case.held_to)
    laws_by_name = standard_laws(plant, peak, autopilot, case.hardware["rate_limit"])
    return {
        name: with_filters(law, case.autopilot_design)
        for name, law in laws_by_name.items()
        if case.laws is None or name in case.laws.names
    }


def _winds(
    wind_options: SoundingOptions, names: list[str] | None, case: StudyPlan
) -> tuple[float, float, dict[str, History]]:
    """Return peak [rad] and duration [s] for which laws are designed, and the winds by name."""
    pulse = case.wind_in_plane
    if not isinstance(pulse, ShapedWind):
        only_with("the standard winds in place of --winds", wind=names)
        wind = case.history
        return float(wind.peak), float(wind.end - wind.onset), {wind_options.name(case): wind}
    standard = standard_winds(pulse.peak, pulse.duration)
    if (gust := pulse.placed_gust) is not None:
        standard = {name: standard_wind + gust for name, standard_wind in standard.items()}
    named = names or (standard if case.laws is None else case.laws.winds)
    winds = {name: standard[one_of("--wind", name, standard)] for name in named}
    return pulse.peak, pulse.duration, winds
