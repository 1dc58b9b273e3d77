"""`tvclin nozzle`: limits over rate or load in a wind, and the duty of the nozzle over a flight."""

from typing import Annotated

import typer

from tvclin.base.errors import InputError, one_of
from tvclin.cli.gains import FlownLaw
from tvclin.cli.inputs import case_of, note_left_out, note_nominal_pressure, only_with
from tvclin.cli.nozzle_duty import print_duty
from tvclin.cli.nozzle_options import FLIGHT, IN_A_WIND, LOAD, RATE, NozzleOptions
from tvclin.cli.options import (
    GROUP,
    SOURCE_HELP,
    At,
    More,
    ShownCurves,
    asked,
)
from tvclin.cli.output import answer, print_answer, print_tables
from tvclin.cli.trade_offs import over_load, over_rate
from tvclin.cli.wind import WindOptions
from tvclin.control.laws.registry import AUTOPILOT
from tvclin.requirement.case_requirement import study_requirement
from tvclin.studyfile.read import vehicle_source
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.coefficients import BOTH
from tvclin.vehicle.vehicle_file import is_schedule


def nozzle(
    vehicle: Annotated[
        str,
        typer.Argument(metavar="VEHICLE|STUDY|SCHEDULE", help=SOURCE_HELP),
    ] = "configuration-i",
    over: str | None = asked(
        f"What the deflection is traded for: its {RATE}, or the {LOAD} on the structure, in one"
        f" wind; or the duty of the nozzle over a {FLIGHT}: angle, rate, travel, torque.",
        shown=f"{RATE}; {FLIGHT} for a flight schedule without --at",
    ),
    time: At = None,
    options: NozzleOptions = GROUP,
    more: More = False,
    shown: ShownCurves = GROUP,
) -> None:
    """Print the minimum deflection over its rate or over the load, or the duty over a flight.

    Over rate or load it is at nominal dynamic pressure: a limit below the lower bound is never
    sufficient; of one above it tvclin study is the verdict.

    Over a flight, a law is flown at each flight time in each wind, and judged by the limits of the
    data sheet; torque, power and energy need what turns and what resists, in a table named nozzle.

    Exit code 0: no limit is below its lower bound, and flights survive within limits and load; 1:
    NOT SUFFICIENT, NOT SURVIVED, NOT MET, or NOT KNOWN; 2: bad input.
    """
    flight = over is None and time is None and is_schedule(vehicle_source(vehicle))
    over = one_of("--over", over or (FLIGHT if flight else RATE), (RATE, LOAD, FLIGHT))
    if over != LOAD:
        options.load.only_with(f"--over {LOAD}")
    if over != RATE:
        only_with(f"--over {RATE}", laws=options.laws)
    if over == FLIGHT:
        only_with(IN_A_WIND, at=time, plot=shown.plot)
        options.dead_band.only_with(IN_A_WIND)
        print_duty(vehicle, options, more, shown)
    else:
        _print_in_a_wind(vehicle, over, time, options, more, shown)


def _print_in_a_wind(
    vehicle: str,
    over: str,
    time: float | None,
    options: NozzleOptions,
    more: bool,
    shown: ShownCurves,
) -> None:
    """Print the deflection over rate or load in the wind of a case."""
    winds, names = options.winds.at_one_time(vehicle), options.names
    case = _case_in_a_wind(vehicle, over, time, options, winds)
    title, required = winds.title(case, vehicle), study_requirement(case, case.dead_band)
    result = (
        over_rate(case, title, names, options.laws)
        if over == RATE
        else over_load(case, title, names)
    )
    shown.write(result.curves, result.chart)
    note_nominal_pressure(case)
    answer(
        shown.as_json,
        lambda: winds.document(case, required) | result.document,
        lambda: print_answer(
            result.verdict(required),
            *result.tables,
            notes=result.notes,
            more=more,
            details=lambda: print_tables(*result.further),
        ),
        result.satisfied,
    )


def _case_in_a_wind(
    vehicle: str, over: str, time: float | None, options: NozzleOptions, winds: WindOptions
) -> StudyPlan:
    """Return the case of a trade-off in one wind; `InputError` for options of a flight."""
    question = "nozzle" if over == RATE else f"nozzle --over {over}"
    options.times.only_with(f"--over {FLIGHT}")
    if options.planes.plane == BOTH:
        raise InputError(f"--plane {BOTH} needs tvclin nozzle --over {FLIGHT}")
    if AUTOPILOT not in options.names and not options.laws:
        FlownLaw().only_with_autopilot(vehicle)
    groups = (options.limits, options.load, options.model, options.planes, options.dead_band)
    changes = [group.over for group in groups]
    case = case_of(vehicle, *changes, wind=winds.over, told=(question,), time=time)
    if not options.names and not options.laws:
        note_left_out(case, f"{question} without --law")
    return case
