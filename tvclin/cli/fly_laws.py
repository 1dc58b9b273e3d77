"""`tvclin fly --law all`: required deflection of each law in standard winds, with its bounds."""

from dataclasses import dataclass, replace
from functools import partial
from math import degrees
from typing import Any

from tvclin.base.errors import one_of
from tvclin.base.lines import plural
from tvclin.base.quantities import NOMINAL
from tvclin.case.flexible_autopilot import with_filters
from tvclin.cli.inputs import case_of, note_omissions, only_with
from tvclin.cli.margins import parts_line
from tvclin.cli.options import FlownLaw, Options, ShownCurves
from tvclin.cli.output import answer, bar, draw, print_answer, print_tables, say
from tvclin.cli.wind import WindOptions
from tvclin.control.laws.law import Law
from tvclin.control.laws.registry import AUTOPILOT
from tvclin.design.gain_designs import specified_autopilot
from tvclin.design.standard_trials import (
    LEGEND,
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


def fly_laws(
    vehicle: str,
    time: float | None,
    motion: Options,
    winds: WindOptions,
    flies: FlownLaw,
    more: bool,
    shown: ShownCurves,
) -> None:
    """Fly laws in the standard winds, or in that of the options, and print their limits."""
    from tvclin import plots

    if shown.plot is not None:
        only_with("no --plot: that is drawn of pulses alone", winds=winds.winds)
    case = case_of(
        vehicle,
        motion.over,
        _without_actuator,
        partial(_with_gains, flies),
        wind=winds.over,
        questions=("fly --law all",),
        time=time,
    )
    plant, hardware = plant_of(case.vehicle, case.law_model, case.plane), case.hardware
    if case.laws is not None and "sample_rate" not in flies.timing.values:
        hardware["sample_rate"] = case.laws.sample_rate
        note_omissions(case, "laws with a rate in [laws]")
    peak, duration, histories = _winds(winds, case)
    chosen = _laws(case, plant.rigid, peak)
    cuts = 0 if case.laws is None else case.laws.cuts
    with bar("flights") as progress:
        trials = law_trials(plant, chosen, histories, cuts=cuts, progress=progress, **hardware)
    draw(shown.plot, lambda: plots.laws_chart(plant, chosen, peak, **hardware))
    reference_bounds = bounds(plant.rigid, histories)
    result = _Answer(case, plant, peak, duration, hardware["sample_rate"], trials, reference_bounds)
    answer(shown.as_json, lambda: result.document(cuts), lambda: result.print(vehicle, more))


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
        """Return the document of the answer for JSON."""
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

    def print(self, source: str, more: bool) -> None:
        """Print the law with the lowest limit, the limits of each law, and notes."""
        winds = f"winds of {abs(degrees(self.peak)):.4g} deg and {self.duration:g} s"
        servo = self.case.nozzle.actuator
        engine = f"actuator {servo.natural_frequency:g} rad/s" if servo else "no actuator"
        name = self.case.vehicle.name or source
        rate = f"{self.rate:g} Hz, delay {1000.0 * self.case.autopilot_design.delay:g} ms"
        limits, *others = limit_tables(self.trials, self.bounds)
        notes = (*linear_notes(self.peak), *limit_warnings(self.trials), LEGEND)

        def details() -> None:
            print_tables(*others, load_table(self.trials))
            if self.plant.structure is not None:
                say(parts_line(self.plant.structure))
            say(f"{name}, {self.plant.model}, {winds}, {NOMINAL}, {rate}, {engine}")
            say(scan_text(self.trials))

        print_answer(self._verdict, limits, notes=notes, more=more, details=details)

    @property
    def _verdict(self) -> str:
        """The law that requires the least in the worst of the winds."""
        largest: dict[str, float] = {}
        for trial in self.trials:
            limit = self.bounds[trial.wind].trim_deg * trial.limit
            largest[trial.law] = max(limit, largest.get(trial.law, 0.0))
        worst = "this wind" if len(self.bounds) == 1 else f"the worst of {len(self.bounds)} winds"
        best = min(largest, key=lambda law: largest[law])
        return (
            f"{best} requires the lowest limit of {plural(len(largest), 'law')}:"
            f" {largest[best]:.3f} deg in {worst}"
        )


def _without_actuator(plan: StudyPlan) -> StudyPlan:
    """Return the case of laws compared with boundaries: a rigid vehicle has no actuator."""
    if plan.vehicle.structure is not None:
        return plan
    note_omissions(plan, "laws of a rigid vehicle")
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


def _winds(options: WindOptions, case: StudyPlan) -> tuple[float, float, dict[str, History]]:
    """Return peak [rad] and duration [s] for which laws are designed, and the winds by name."""
    pulse, wind = case.wind_in_plane, case.history
    if not isinstance(pulse, ShapedWind):
        return float(wind.peak), float(wind.end - wind.onset), {options.name(case): wind}
    if options.wind is not None:
        return pulse.peak, pulse.duration, {pulse.shape: wind}
    standard = standard_winds(pulse.peak, pulse.duration)
    if (gust := pulse.placed_gust) is not None:
        standard = {name: standard_wind + gust for name, standard_wind in standard.items()}
    named = standard if case.laws is None else case.laws.winds
    winds = {name: standard[one_of("winds in [laws]", name, standard)] for name in named}
    return pulse.peak, pulse.duration, winds
