"""`tvclin ascent`: the required deflection of a whole flight, and the verdict on the limit.

With an autopilot over the flight also its use of the nozzle.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from tvclin.ascent.measured_wind import hundredths
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.base.fields import document
from tvclin.base.lines import Table, listed
from tvclin.case.case import Case
from tvclin.cli.inputs import keys_set, note_omissions, note_source
from tvclin.cli.options import (
    BOTH_LIMITS,
    GROUP,
    MODEL,
    SIZING,
    AsJson,
    More,
    Options,
    Plot,
    option,
    to_write,
)
from tvclin.cli.output import (
    answer,
    bar,
    draw,
    note_below,
    print_answer,
    print_tables,
    say,
    say_lines,
)
from tvclin.cli.wind import FlightOptions, check_reading
from tvclin.requirement.flight import sizing_tables as tables
from tvclin.requirement.flight.controllability import ControllabilityRatio
from tvclin.requirement.flight.flight_turbulence import FlightTurbulence
from tvclin.requirement.flight.request import SizingRequest
from tvclin.requirement.flight.sizing import STEADY, Sizing
from tvclin.requirement.flight.total import DeflectionTotal, total_table
from tvclin.requirement.required_quantity import Requirement, deflection_warnings
from tvclin.requirement.study import uncounted_sign
from tvclin.studyfile.flight_loop import FlightLoop, FlightsOfLoop
from tvclin.studyfile.read import is_flight, load_sizing
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.coefficients import BOTH
from tvclin.vehicle.vehicle_file import source_tables
from tvclin.winds.soundings.sounding_files import SoundingReading
from tvclin.winds.wind_angles import FROZEN

if TYPE_CHECKING:
    from control import ControlPlot


def is_scheduled(case: Case, source: str) -> bool:
    """Return whether a case has an autopilot over the flight, not for a single flight time.

    Its gains vary along the flight, or its file `source`, of the whole flight, specifies them.
    """
    if not isinstance(case, StudyPlan) or case.sizing is None:
        return False
    return case.sizing.scheduled_design is not None or (
        case.design is not None and is_flight(source)
    )


def _autopilot_flights(
    case: StudyPlan, source: str, sizing: Sizing, more: bool
) -> FlightsOfLoop | None:
    """Return the flights of the autopilot of a case, and its use of the nozzle.

    None without an autopilot over the flight, or without a limit. `source`: file of the case.
    `sizing`: required deflections by flight time, for comparison. `more`: whether the autopilot
    requirement, which takes seconds for each flight time, is computed.
    """
    if case.nozzle.limit is None or not is_scheduled(case, source):
        return None
    with bar("flights of the autopilot") as progress:
        return FlightLoop.of(case).use(sizing, requirements=more, progress=progress)


_FIELDS = ("start", "stop", "every", "dead_bands", "varying")
"""Fields of `SizingRequest` that have an option."""
_MAX_WIND_COLUMNS = 6
"""Largest number of winds with a column each, for the width of a terminal."""
_OF_A_RAMP = (
    "the rate limit adds what a ramp from zero needs more than a step, a bound: a law may survive"
    " with less (tvclin nozzle --law trim flies one)"
)
SOURCE = (
    "A study file, with a table named schedule (see: tvclin init --study) or the flight of its"
    " vehicle; or a flight schedule (CSV, or TOML with that table alone); or a vehicle whose file"
    " has a table named flight: then its nominal flight."
)


@dataclass(frozen=True)
class PlaneOptions:
    """Option of the plane of a flight, or of both with a limit shape."""

    plane: str | None = option(
        "Plane of the motion: pitch, yaw, or both with one limit, of a shape: --set"
        " nozzle.limit_shape SHAPE.",
        shown="pitch",
    )

    def applied_to(self, plan: StudyPlan) -> StudyPlan:
        """Return a plan of this plane, or of both with a limit shape, round by default."""
        if self.plane is None:
            return plan
        two_planes = self.plane == BOTH
        plan = plan if two_planes else replace(plan, plane=self.plane)
        shape = (plan.nozzle.limit_shape or "round") if two_planes else None
        return replace(plan, nozzle=replace(plan.nozzle, limit_shape=shape))


def ascent(
    source: Annotated[
        str, typer.Argument(metavar="STUDY|SCHEDULE|VEHICLE", help=SOURCE)
    ] = "configuration-i",
    winds: FlightOptions = GROUP,
    model: Options = MODEL,
    planes: PlaneOptions = GROUP,
    limits: Options = BOTH_LIMITS,
    question: Options = Options(SIZING, _FIELDS, "sizing"),
    more: More = False,
    as_json: AsJson = False,
    csv: Path | None = option(
        "Also write every flight time and wind into this file.", callback=to_write
    ),
    plot: Plot = None,
) -> None:
    """Print the required deflection at each time of a flight, its budget, and the verdict on it.

    tvclin study is of one time, tvclin availability of many days. A pulse is placed so that its
    peak meets each flight time; a sounding is flown through. With --winds there is a pulse only if
    an option or the study file asks for one. Options count more than a study file. The budget also
    counts times between the listed ones, about its largest values.

    A flight with its autopilot, such as a table of gains, and a limit, is flown in these winds too:
    the table and the figure are of required, used and remaining deflection; --more also finds the
    autopilot requirement, in some seconds for each flight time.

    Exit code 0: the limit is SUFFICIENT and every flight of its autopilot SURVIVED, or no limit was
    given; 1: NOT SUFFICIENT, NOT SURVIVED, or NOT KNOWN, as where a sounding ends below the flight
    (tvclin availability assumes 130 m/s there, a bound); 2: bad input.
    """
    # `winds`: options of the winds; `question`: those of flight times, dead bands and variation
    case = case_over_flight("ascent", source, winds, question, limits, model, planes)
    request = case.sizing
    assert request is not None
    if plot is not None:
        _check_drawn(request.times(case))
    with bar("flight times and winds") as progress:
        sizing = request.sizing(case, progress)
        turbulence = request.turbulence(case, case.turbulence)
    result = _Answer(
        source=source,
        sizing=sizing,
        # the requirement that enters the budget as the wind's, of the direction `sign` alone if set
        counted=request.counted(sizing, case.sign),
        total=request.total(case, sizing, turbulence),
        # limit over trim in the wind with what adds to it
        ratio=request.ratio(case, sizing),
        turbulence=turbulence if isinstance(turbulence, FlightTurbulence) else None,
        flights=_autopilot_flights(case, source, sizing, more),
        notes_of_request=(*request.warnings, *request.notes, *_hints(request, sizing)),
    )
    if csv is not None:
        sizing.to_csv(csv)
    draw(plot, result.chart)
    answer(as_json, result.document, lambda: result.print(more), result.satisfied)


def _check_drawn(times: FloatArray) -> None:
    """Raise `InputError` where a figure over the flight would have one flight time [s] alone."""
    if times.size < 2:
        raise InputError(
            "--plot draws over the flight, which takes two or more flight times; got"
            f" {times[0]:g} s alone (--from, --to, --every)"
        )


@dataclass(frozen=True, eq=False)
class _Answer:
    """Sizing of a flight with its budget, and the autopilot flown in its winds where it has one.

    `counted`: the requirement of the sizing that enters the budget, which is `total`. `ratio`: the
    controllability ratio. `flights`: the flights of the autopilot, with its use of the nozzle. Both
    are None where they are not computed.
    """

    source: str
    sizing: Sizing
    counted: Requirement
    total: DeflectionTotal
    ratio: ControllabilityRatio | None
    turbulence: FlightTurbulence | None
    flights: FlightsOfLoop | None
    notes_of_request: tuple[str, ...]

    @property
    def notes(self) -> list[str]:
        """Notes of the flight, except of the sizing and of the controllability ratio."""
        flights = self.flights
        notes: list[str] = [*deflection_warnings(self.total.required)]
        if flights is not None:
            notes = [*notes, f"flown by the autopilot: {flights.verdict}", *flights.notes]
            unknown = () if flights.use is None else flights.use.reasons
            notes += [f"autopilot requirement NOT KNOWN: {reason}" for reason in unknown]
        if self.total.rate_limit is not None:
            notes.append(_OF_A_RAMP)
        if self.turbulence is not None:
            notes += [
                f"{line.name}, adds {np.degrees(line.deflection):.3f} deg to the budget, as a"
                " random contribution"
                for line in self.total.lines
                if line.name.startswith("turbulence")
            ]
            notes += self.turbulence.notes
        return [*notes, *self.notes_of_request]

    @property
    def satisfied(self) -> bool:
        """Whether limits are sufficient, or not given, and each flight of the autopilot survives.

        The limits are on deflection and on rate. False where one of these is not known.
        """
        total = self.total
        survived = self.flights is None or bool(self.flights.survived)
        return survived and not total.too_slow and (total.limit is None or bool(total.sufficient))

    @property
    def verdict(self) -> str:
        """Verdict on the limit, with the outcome of the autopilot."""
        return self.total.words_with(self._autopilot_outcome)

    @property
    def _autopilot_outcome(self) -> str:
        """The outcome of the autopilot in words; empty without one."""
        return "" if self.flights is None else self.flights.outcome

    def chart(self) -> "ControlPlot":
        """Return the figure: of requirements, or of required, used and remaining deflection."""
        from tvclin import plots

        if self.flights is not None and self.flights.use is not None:
            return plots.deflection_use_chart(self.flights.use, self.source)
        return plots.sizing_chart(self.sizing, self.total.limit, self.source)

    def document(self) -> dict[str, Any]:
        """Return sizing, budget, controllability, flights, notes and verdict for JSON."""
        sizing, total, ratio, flights = self.sizing, self.total, self.ratio, self.flights
        used: dict[str, Any] = {}
        if flights is not None:
            used = {"deflection_use": flights.use, "autopilot": flights.document()}
        return {
            **sizing.as_dict(),
            "total": total,
            "controllability": ratio,
            **({} if self.turbulence is None else {"turbulence": self.turbulence}),
            **used,
            "notes": [*sizing.notes, *self.notes, *(ratio.notes if ratio else ())],
            "verdict": {
                **document(total, "limit", "sufficient", "remaining", "not_sized"),
                **({"autopilot": self._autopilot_outcome} if self._autopilot_outcome else {}),
                "words": self.verdict,
                "satisfied": self.satisfied,
            },
        }

    def print(self, more: bool) -> None:
        """Print the verdict, the deflections by flight time and notes, and with `more` the rest.

        The first table is of the deflections that the flown autopilot uses, if it was flown, else
        of the requirements.
        """
        sizing, flights, ratio = self.sizing, self.flights, self.ratio
        name = sizing.schedule.vehicle.name or self.source
        planes, judged = sizing.plane, f"{sizing.plane} alone judged (--plane {BOTH} judges both)"
        if sizing.separate:  # sizings of each plane alone, beside that of both
            planes, judged = "both planes, one limit", "both planes judged"
        title = f"{name}, {sizing.model}, {planes}: {', '.join(sizing.winds)}"
        first, *further = tables.time_tables(sizing, self.counted)
        if flights is not None and flights.use is not None:
            first, further = flights.use.table(), [first, *further]
        in_turbulence = [] if self.turbulence is None else self.turbulence.tables()
        print_answer(
            f"{self.verdict}; {judged}",
            replace(first, caption=f"{title}\n{first.caption}"),
            *in_turbulence[:1],
            notes=(*sizing.notes, *self.notes, *(ratio.notes if ratio and more else ())),
            more=more,
            details=lambda: self._print_details(further, in_turbulence[1:]),
        )

    def _print_details(self, further: list[Table], in_turbulence: list[Table]) -> None:
        """Print the tables by time and wind, of the budget, and of turbulence.

        `further`: tables by flight time after the first. `in_turbulence`: tables of turbulence
        after the first.
        """
        sizing, counted, ratio = self.sizing, self.counted, self.ratio
        print_tables(*further)
        if len(sizing.winds) > 1:
            print_tables(tables.by_wind(sizing, counted))
        if 1 < len(sizing.winds) <= _MAX_WIND_COLUMNS:
            print_tables(*tables.wind_columns_table(sizing, counted))
        say(f"{tables.legend(sizing)}\n")
        print_tables(total_table(self.total), *in_turbulence)
        if ratio is not None:
            print_tables(ratio.table)
            say_lines([ratio.verdict])


def _hints(request: SizingRequest, sizing: Sizing) -> Iterator[str]:
    """Yield notes on options that change the flight times, or the window of a sounding.

    `request`: the flight, its times and winds. `sizing`: its result, with the required deflection
    by time and wind. Times may be added that no option excluded, or left out where a wind is not
    known; a window is advised where beta (rate of the attitude) or B (trim deflection per angle of
    attack) changes by more than a tenth within a sounding.
    """
    begin, end = (float(time) for time in (sizing.times.min(), sizing.times.max()))
    yield from _omitted_times(request, sizing.schedule.span, begin, end)
    starts, stops = sizing.known_times.T  # first and last time at which each wind is known [s]
    earliest, latest = starts.max(), stops.min()
    required = next(iter(sizing.required.values()))  # by time and wind; NaN where not known
    determined = sizing.times[np.isfinite(required).all(axis=1)]
    if determined.size:  # a gust may make more times unknown than the end of a sounding
        earliest = max(earliest, determined[0] if determined[0] > begin else -np.inf)
        latest = min(latest, determined[-1] if determined[-1] < end else np.inf)
    options = [f"--from {hundredths(earliest, up=True)}"] if begin < earliest else []
    options += [f"--to {hundredths(latest, up=False)}"] if end > latest else []
    if options:
        yield f"{' '.join(options)} leaves out the flight times at which a wind is not known"
    # the parameters are frozen at each time, though they change, and that error was not computed
    doubtful = not sizing.freezing_error and (sizing.change > STEADY).any()
    if request.soundings and request.window is None and doubtful:
        yield (
            "--set sounding.window_s 20 counts of a sounding only what is within 10 s of each time,"
            " while parameters change less"
        )


def _omitted_times(
    request: SizingRequest, span: tuple[float, float], begin: float, end: float
) -> Iterator[str]:
    """Yield the note on flight times that are left out though no option excluded them.

    `request`: the flight and its times. `span`: first and last time of the flight [s]. `begin`,
    `end`: first and last time that is sized [s].
    """
    first, last = span
    left_out = {}  # such times, by the option that takes them in
    if request.start is None and begin > first:
        left_out[f"--from {first:g}"] = f"before {begin:g} s"
    if request.stop is None and end < last:
        left_out[f"--to {last:g}"] = f"after {end:g} s"
    if left_out:
        yield (
            f"flight times {listed(left_out.values())} are left out, for a pulse about them"
            f" would blow beyond the schedule; {' '.join(left_out)}"
            f" {'takes' if len(left_out) == 1 else 'take'} them in"
        )


def case_over_flight(
    command: str,
    source: str,
    winds: FlightOptions,
    question: Options,
    *changes: Options | PlaneOptions,
) -> StudyPlan:
    """Return the case of a flight from the file `source` and options.

    `command`: name of the question, for notes on what it neglects. `winds`: options of the winds.
    `question`: options of flight times and tables. `changes`: further groups of options. Notes say
    what the question neglects of the file, and that a wind in yaw has no sign that counts.
    `InputError` for a sign of a sounding, and keys of soundings without one.
    """
    soundings = winds.soundings(SoundingReading.of(source_tables(source), Path(source).parent))
    note_source(source, command)
    case = load_sizing(source, soundings)
    if command == "ascent" and case.turbulence is None and not is_scheduled(case, source):
        note_omissions(case, "ascent without turbulence")
    for options in (question, *changes):
        case = options.applied_to(case)
    case = winds.applied_to(case)
    request = case.sizing
    assert request is not None
    check_reading(case)  # [sounding] has keys only beside a sounding
    if case.sign not in (None, FROZEN):
        if request.pulse or request.others:  # pulses of the case and of its file
            if case.planes == "yaw" and case.heading is None:  # a wind across the path
                note_below(uncounted_sign(case.sign))
        elif "study.sign" in keys_set(source):
            raise InputError("--set study.sign needs a pulse: a sounding has its own sign")
    return case
