"""`tvclin fly`: a flight of one law in a wind, beside the theory, or the limits of all laws.

`--law all` computes the required deflection of each law in standard winds, with its bounds.
"""

from dataclasses import dataclass, replace
from functools import partial
from math import degrees
from typing import Any

import numpy as np
import typer

from tvclin.ascent.nominal_flight import FlightCondition, load_flight_condition
from tvclin.base.errors import Faults, one_of
from tvclin.base.lines import listed, plural
from tvclin.base.quantities import NOMINAL
from tvclin.case.flexible_autopilot import textbook_notes, with_filters
from tvclin.cli.flight_cases import REPORT, Compared, Flying, flight_case, fly_nonlinear, worst_of
from tvclin.cli.fly_autopilot import LINEAR, AutopilotFlight, LinearCase, fly_autopilot, fly_linear
from tvclin.cli.inputs import FROZEN, case_of, chosen, note_omissions, note_single_time, only_with
from tvclin.cli.margins import print_parts
from tvclin.cli.options import (
    GROUP,
    LIMIT,
    MODEL_AND_PLANE,
    At,
    FlownLaw,
    More,
    Options,
    ShownCurves,
    Source,
    option,
)
from tvclin.cli.output import answer, bar, draw, print_answer, print_tables, say, waiting
from tvclin.cli.wind import FlightOptions, WindOptions, winds_in_flight, with_gust_for
from tvclin.control.laws.law import Law
from tvclin.control.laws.registry import AUTOPILOT, LAWS
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
from tvclin.flights.flown_boundary import ENGINES
from tvclin.linear.flexible import AnyPlant, plant_of
from tvclin.linear.plant import Plant
from tvclin.studyfile.read import is_flight, vehicle_source
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.wind_angles import SIGNS, linear_notes

ALL = "all"
"""Name of --law for the limits of all laws."""
_SINGLE_LAW = "a single law: tvclin fly --law NAME"
_VARYING = "-varying"
"""End of the name of an engine whose mass, speed and dynamic pressure vary in flight."""
_ENGINES = (LINEAR, *ENGINES, *(f"{name}{_VARYING}" for name in ENGINES))
_DURATIONS_SHOWN = 2.0
"""Length of the flight shown, in durations of the wind."""
_POINTS = 401
"""Number of times of the flight shown."""


@dataclass(frozen=True)
class EngineOptions:
    """Options of the law, the engine and the dead band; `grouped` gives them to a command."""

    law: str | None = option(
        f"Control law: {listed((REPORT, *LAWS), 'or')}; or all: the limit of each in standard"
        f" winds. Gains below are of {AUTOPILOT}.",
        shown=f"{AUTOPILOT} with gains or --engine {LINEAR}, else {REPORT}",
    )
    engine: str | None = option(
        "linear: linear equations with bending and slosh, a sampled law and an actuator; planar:"
        " nonlinear equations in one plane; sixdof: JSBSim, six degrees of freedom; planar-varying"
        " or sixdof-varying: mass, speed and dynamic pressure vary in flight.",
        shown=f"{LINEAR} for a flexible vehicle and for {AUTOPILOT}, else planar",
    )
    dead_band: float | None = option(
        "Dead band K of the laws report and dead-band.", shown="1 for report, 0.5 for dead-band"
    )

    def __post_init__(self) -> None:
        """Raise `InputError` for an unknown engine or law."""
        if self.engine is not None:
            one_of("--engine", self.engine, _ENGINES)
        one_of("--law", self.law or REPORT, [REPORT, *LAWS, ALL])

    def check_along_flight(self) -> None:
        """Raise `InputError` for a law, an engine or a dead band that flies no whole flight."""
        law = None if self.law == AUTOPILOT else self.law
        engine = None if self.engine == LINEAR else self.engine
        only_with(FROZEN, law=law, engine=engine, dead_band=self.dead_band)

    def resolved(
        self, source: str, case: StudyPlan, law_options: FlownLaw, model: Options
    ) -> tuple[StudyPlan, str, bool, str, Any]:
        """Return the case with its gust, engine, whether parameters vary, law and dead band.

        The law of gains, of options or of the file, is the autopilot. Options of another engine or
        law are refused first; notes name what is omitted of the file.

        `source`: name or path of the case. `law_options`: samples, delay and gains. `model`: its
        option. Gains of a file count only without --engine and --dead-band. The dead band is None
        where the law takes its own; the gust is where a control with it requires most.
        """
        # whether gains of the file make the autopilot the law
        in_file = self.engine is None and self.dead_band is None
        in_file &= not case.autopilot_design.unspecified
        law = self.law or (AUTOPILOT if in_file or law_options.has_gains(source) else None)
        # name of the engine, and "-varying" if its parameters vary, else empty
        engine, suffix, _ = (self.engine or "").partition(_VARYING)
        if not engine:
            rigid = isinstance(case.vehicle, Vehicle) and case.vehicle.structure is None
            engine = "planar" if rigid and law != AUTOPILOT else LINEAR
        law = law or (AUTOPILOT if engine == LINEAR else REPORT)
        if law != AUTOPILOT:
            law_options.only_with_autopilot(source)
        if engine != LINEAR:
            law_options.timing.only_with("--engine linear")
            model.only_with("--engine linear", "model")
        questions = ["fly"]  # names in docs/conventions.md, for the notes on omissions
        if law != AUTOPILOT:
            questions.append("fly without --law autopilot")
        if law == AUTOPILOT and engine == LINEAR:
            questions.append("fly --law autopilot")
        elif not (suffix and case.sign in SIGNS):  # which a varying engine flies
            questions.append("fly without the autopilot requirement")
        if engine != LINEAR:
            questions.append("fly --engine planar")
        note_omissions(case, *questions)
        band = chosen(self.dead_band, case.dead_band if law == REPORT else None)
        return with_gust_for(case, band), engine, bool(suffix), law, band


def fly(
    vehicle: Source = "configuration-i",
    time: At = None,
    winds: FlightOptions = GROUP,
    choice: EngineOptions = GROUP,
    limit: Options = replace(LIMIT, shown={"limit": "1.1 times the boundary of the law"}),
    law_options: FlownLaw = GROUP,
    model: Options = MODEL_AND_PLANE,
    more: More = False,
    shown: ShownCurves = GROUP,
) -> None:
    """Fly a vehicle through a wind with a control law and its limits, and compare with the theory.

    A flight schedule without --at, or a study of one without time_s, is flown from its begin to its
    end with all that varies: the linear loop of its autopilot, sampled, with the nozzle's limits,
    at the dynamic pressure encountered, with the peak of a pulse at each flight time (--set
    size.from_s, to_s, every_s), or through soundings.

    --law autopilot also prints the autopilot requirement, the smallest limit from which on every
    limit survives, flown with samples, delay, actuator, filters, bending and rate limit, and
    compares the autopilot with trim. --law report holds its limit until the wind ends, which turns
    the vehicle far to the other side; tvclin respond lets go of it as soon as the attitude is back
    at zero. --law all prints the limit that each law requires in standard
    winds, or in that of --wind or --winds; it takes about a second for each law and wind.

    A vehicle file with bending, slosh, engine inertia or sensor lags makes a flexible vehicle: that
    is flown with a sampled law, beside the rigid one. --set study.rigid true leaves all that out.

    The rate limit is a key, --set nozzle.rate_limit_deg_per_s 10 (the smallest that an autopilot
    requires: tvclin nozzle --law autopilot); so are actuator, filters, gust.

    Flights are at nominal dynamic pressure, or with a varying engine at that encountered in the
    wind: the worse of a head and a tail wind, or that of --set study.sign. tvclin study is the
    verdict on a limit. --more also finds, by flights, the smallest limit that survives.

    Exit code 0: SURVIVED, or SUFFICIENT for the autopilot; 1: not so, or NOT KNOWN; 2: bad input.
    """
    changes = [options.applied_to for options in (limit, model, law_options)]
    if choice.law != ALL and time is None and is_flight(vehicle):
        from tvclin.cli.whole_flight import fly_flight

        choice.check_along_flight()
        fly_flight(vehicle, winds, changes, more, shown)
        return
    single = winds.at_one_time(vehicle)
    if choice.law == ALL:
        only_with(_SINGLE_LAW, **vars(choice) | {"law": None}, csv=shown.csv)
        limit.only_with(_SINGLE_LAW)
        fly_laws(vehicle, time, model, single, law_options, more, shown)
        return
    condition, faults = None, Faults()
    case = case_of(vehicle, *changes, time=time)
    note_single_time(vehicle, time)
    with faults.collect():
        case = single.applied_to(case, vehicle)
    case, engine, varying, law, band = choice.resolved(vehicle, case, law_options, model)
    name, cases = single.name(case), {"": case}
    with faults.collect():
        cases = winds_in_flight(case) if varying else cases
    with faults.collect():
        condition = load_flight_condition(vehicle_source(vehicle)) if varying else None
    faults.raise_all()
    with waiting("flying"):
        flown = {k: Flying(case, name, law, band) for k, case in cases.items()}
        answer = _flown(flown, engine, condition, more)
    if not answer.show(shown, more):
        raise typer.Exit(1)


def _flown(
    flights: dict[str, Flying], engine: str, condition: FlightCondition | None, more: bool
) -> Compared | AutopilotFlight:
    """Return the worst flight of a law in the winds of its cases, over two durations of each.

    `flights`: cases by the direction of the wind, "" for frozen parameters. `engine`: name of the
    engine. `condition`: altitude and specific impulse for parameters that vary in flight, None for
    frozen ones. `more`: whether the boundary is flown too.
    """
    flying = next(iter(flights.values()))
    wind = flying.wind
    length = _DURATIONS_SHOWN * float(wind.end - wind.onset)
    if engine != LINEAR:
        cases = {
            direction: flight_case(flying, engine, condition, length, direction)
            for direction, flying in flights.items()
        }
        return worst_of({k: fly_nonlinear(x, more, length, _POINTS) for k, x in cases.items()})
    # the linear engine flies in one wind, with parameters frozen
    times = float(wind.onset) + np.linspace(0.0, length, _POINTS)
    fly_case = fly_autopilot if flying.law == AUTOPILOT else fly_linear
    return fly_case(LinearCase(**vars(flying)), more, times)


def fly_laws(
    vehicle: str,
    time: float | None,
    model: Options,
    winds: WindOptions,
    law_options: FlownLaw,
    more: bool,
    shown: ShownCurves,
) -> None:
    """Fly laws in the standard winds, or in that of the options, and print their limits.

    `vehicle`: name of a vehicle or of a file. `time`: flight time [s] of a schedule. `model`,
    `winds`, `law_options`: options of model and plane, of the wind, and of samples and delay
    (`timing`) and gains. `more`: whether all tables and notes are printed. A study file with [laws]
    has the rate of the samples, and in `cuts` how many sudden ends of each wind are tried too.
    """
    from tvclin import plots

    if shown.plot is not None:
        only_with("no --plot: that is drawn of pulses alone", winds=winds.winds)
    changes = (model.applied_to, _without_actuator, partial(_with_gains, law_options))
    questions = ("fly --law all",)
    case = case_of(vehicle, *changes, wind=winds.applied_to, questions=questions, time=time)
    plant, hardware = plant_of(case.vehicle, case.law_model, case.plane), case.hardware
    if case.laws is not None and "sample_rate" not in law_options.timing.values:
        hardware["sample_rate"] = case.laws.sample_rate
        note_omissions(case, "laws with a rate in [laws]")
    peak, duration, histories = _winds(winds, case)
    laws = _laws(case, plant.rigid, peak)
    cuts = 0 if case.laws is None else case.laws.cuts
    with bar("flights") as progress:
        trials = law_trials(plant, laws, histories, cuts=cuts, progress=progress, **hardware)
    draw(shown.plot, lambda: plots.laws_chart(plant, laws, peak, **hardware))
    rate, lower = hardware["sample_rate"], bounds(plant.rigid, histories)
    result = _Answer(case, plant, peak, duration, rate=rate, trials=trials, bounds=lower)
    answer(shown.as_json, lambda: result.document(cuts), lambda: result.print(vehicle, more))


@dataclass(frozen=True, eq=False)
class _Answer:
    """Trials of laws in winds of a peak [rad] and a duration [s], with bounds of the theory.

    `rate`: sample rate of the laws [Hz]. `trials`: limit of each law in each wind, over trim.
    `bounds`: by wind, its trim deflection and the lower bounds of any law.
    """

    case: StudyPlan
    plant: AnyPlant
    peak: float
    duration: float
    rate: float
    trials: LawTrials
    bounds: dict[str, Bounds]

    def document(self, cuts: int) -> dict[str, Any]:
        """Return the document of the answer for JSON.

        `cuts`: number of instants at which each wind is also flown with a sudden end.
        """
        trims = {name: entry.trim_deg for name, entry in self.bounds.items()}
        return {
            "vehicle": self.case.vehicle.name,
            "model": self.plant.model,
            "plane": self.case.plane,
            "peak_deg": degrees(self.peak),
            "duration_s": self.duration,
            "flexible": self.plant.structure is not None,
            "cuts": cuts,
            "notes": self._notes,
            "sample_rate_Hz": self.rate,
            "trim_deflection_deg": max(trims.values()),
            "trials": [
                {**vars(entry), "limit_deg": trims[entry.wind] * entry.limit}
                for entry in self.trials
            ],
            "no_forecast": {name: entry.no_forecast for name, entry in self.bounds.items()},
        }

    def print(self, source: str, more: bool) -> None:
        """Print the law with the lowest limit, the limits of each law, and notes.

        `source`: name of the file, for a vehicle without a name. `more`: whether the details are
        printed, and all notes.
        """
        winds = f"winds of {abs(degrees(self.peak)):.4g} deg and {self.duration:g} s"
        servo = self.case.nozzle.actuator
        engine = f"actuator {servo.natural_frequency:g} rad/s" if servo else "no actuator"
        name = self.case.vehicle.name or source
        rate = f"{self.rate:g} Hz, delay {1000.0 * self.case.autopilot_design.delay:g} ms"
        limits, *others = limit_tables(self.trials, self.bounds)
        title = f"{name}, {self.plant.model}, {winds}, {NOMINAL}, {rate}, {engine}"
        limits = replace(limits, caption=f"{title}\n{limits.caption}")
        notes = (*self._notes, *limit_warnings(self.trials), LEGEND)

        def details() -> None:
            """Print tables below the answer, and lines on vehicle and scan of limits."""
            print_tables(*others, load_table(self.trials))
            print_parts(self.plant)
            say(scan_text(self.trials))

        print_answer(self._verdict, limits, notes=notes, more=more, details=details)

    @property
    def _notes(self) -> tuple[str, ...]:
        """Notes on a wind that is not known throughout, or beyond linear aerodynamics, and gains.

        The note on gains is that nobody specified those of the autopilot.
        """
        unknown = self.case.unknown_wind
        notes = (f"survival is not known: {unknown}",) if unknown else ()
        flown = AUTOPILOT in {trial.law for trial in self.trials}
        gains = [f"{AUTOPILOT}: {note}" for note in textbook_notes(self.case)] if flown else ()
        return (*notes, *linear_notes(self.peak), *gains)

    @property
    def _verdict(self) -> str:
        """The law that requires the least in the worst of the winds."""
        largest: dict[str, float] = {}
        for trial in self.trials:
            limit = self.bounds[trial.wind].trim_deg * trial.limit  # [deg], a multiple of trim
            largest[trial.law] = max(limit, largest.get(trial.law, 0.0))
        worst = "this wind" if len(self.bounds) == 1 else f"the worst of {len(self.bounds)} winds"
        best = min(largest, key=lambda law: largest[law])
        return (
            f"{best} requires the lowest limit of {plural(len(largest), 'law')}:"
            f" {largest[best]:.3f} deg in {worst}"
            f"{', which is not known throughout' if self.case.unknown_wind else ''}"
        )


def _without_actuator(plan: StudyPlan) -> StudyPlan:
    """Return a plan whose autopilot has no actuator, filters and delay if its vehicle is rigid.

    The boundaries, with which the laws are compared, have none either.
    """
    if plan.vehicle.structure is not None:
        return plan
    note_omissions(plan, "laws of a rigid vehicle")
    design = plan.design and plan.design.without_filters_and_delay
    return replace(plan, nozzle=replace(plan.nozzle, actuator=None), design=design)


def _with_gains(law_options: FlownLaw, plan: StudyPlan) -> StudyPlan:
    """Return a plan with the samples, delay and gains of `law_options`.

    `InputError` for gains where no law of the file has them.
    """
    if plan.laws is not None and AUTOPILOT not in plan.laws.names:
        law_options.gains.only_with("the law autopilot in the table [laws]")
    return law_options.applied_to(plan)


def _laws(case: StudyPlan, plant: Plant, peak: float) -> dict[str, Law]:
    """Return the laws of a case by name, with filters, designed on a plant for a peak [rad]."""
    autopilot = specified_autopilot(case, case.history, criteria=case.margin_criteria)
    laws_by_name = standard_laws(plant, peak, autopilot, case.hardware["rate_limit"])
    return {
        name: with_filters(law, case.autopilot_design)
        for name, law in laws_by_name.items()
        if case.laws is None or name in case.laws.names
    }


def _winds(options: WindOptions, case: StudyPlan) -> tuple[float, float, dict[str, History]]:
    """Return peak [rad] and duration [s] for which laws are designed, and the winds to fly by name.

    `options`: options of the wind, which name the shape of a single wind. `case`: case with it. A
    sounding, or a pulse of a given shape, is the only wind; else the standard winds of its peak and
    duration are flown, with its gust, of a study file those of [laws].
    """
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
