"""`tvclin card`: the duty of the nozzle in a whole flight, as the lines of its data sheet."""

from math import radians
from pathlib import Path
from typing import Annotated

import typer

from tvclin.base.errors import nonnegative, number, one_of, positive
from tvclin.base.lines import listed
from tvclin.cli.ascent import SOURCE, FlightOptions, PlaneOptions, flight_asked
from tvclin.cli.gains import FlownLaw
from tvclin.cli.inputs import note_left_out, only_with
from tvclin.cli.options import BOTH_LIMITS, GROUP, MODEL, STUDY, AsJson, Given, asked, to_write
from tvclin.cli.output import answer, print_tables, say, say_notes
from tvclin.cli.progress import bar
from tvclin.control.laws.registry import AUTOPILOT, LAWS
from tvclin.nozzle.data_sheet import FlightDuty
from tvclin.nozzle.duty_over_flight import flight_duty

_SIZING_FIELDS = ("start", "stop", "every", "window")
"""Fields of `SizingRequest` that a card takes as options too."""


def card(
    source: Annotated[
        str, typer.Argument(metavar="STUDY|SCHEDULE|VEHICLE", help=SOURCE)
    ] = "configuration-i",
    winds: FlightOptions = GROUP,
    law: str | None = asked(
        f"The law that is flown: {listed(LAWS, 'or')}; gains below are of {AUTOPILOT}.",
        shown="that of the study file, or trim",
    ),
    sheet: Given = BOTH_LIMITS,
    noise_deg: float = asked(
        "Noise of the rate gyro, rms for each sample: it makes travel.", 0.0, metavar="DEG/S"
    ),
    seed: int | None = asked("Seed of the noise.", shown="0"),
    steady: float = asked("Length of the window of the steady rate, in s.", 0.5),
    question: Given = Given("requirement.flight.request.SizingRequest", _SIZING_FIELDS, "sizing"),
    model: Given = MODEL,
    planes: PlaneOptions = GROUP,
    sign: Given = Given(STUDY, ("sign",)),
    own: FlownLaw = GROUP,
    as_json: AsJson = False,
    csv: Path | None = asked("Also write every flight into this CSV file.", callback=to_write),
) -> None:
    """Say what a whole flight asks of the nozzle: angle, rate, acceleration, travel, and torque.

    A law is flown at each flight time in each wind. Torque, power and energy need what turns and
    what resists, in a table named nozzle of a study file. Limits of the nozzle are judged.

    Exit code 0: MET, every flight survives within the limits; 1: NOT MET, NOT SURVIVED, or NOT
    KNOWN, as where a wind is not known along the flight; 2: bad input.
    """
    case = flight_asked("card", source, winds, question, sign, sheet, model, own, planes)
    assert case.sizing is not None
    flies = one_of("--law", law or case.sizing.card or "trim", LAWS)
    if flies != AUTOPILOT:
        own.only_with_autopilot(source)
        note_left_out(case, f"card without the law {AUTOPILOT}")
    noise = radians(number("--noise-deg", noise_deg, nonnegative, "deg/s"))
    length = number("--steady", steady, positive, "s")
    if not noise:
        only_with("--noise-deg", seed=seed)
    with bar("flight times and winds") as progress:
        result = flight_duty(
            case,
            case.sizing,
            flies,
            noise=noise,
            seed=seed or 0,
            window=length,
            progress=progress,
        )
    notes = [*case.sizing.warnings, *case.sizing.notes, *result.notes]
    if csv is not None:
        result.to_csv(csv)
    answer(
        as_json,
        lambda: result.as_dict() | {"notes": notes},
        lambda: _print(result, notes),
        bool(result.verdict.satisfied),
    )


def _print(result: FlightDuty, notes: list[str]) -> None:
    print_tables(*result.tables())
    say_notes(notes)
    say(
        "Used is what the law uses in its samples, within the limits, at least the lower bound."
        " Required deflection: see size or study; it is for the ideal trim law, at the"
        " dynamic pressure encountered at each time."
    )
    say(f"Verdict: {result.verdict.words}.")
