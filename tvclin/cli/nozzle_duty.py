"""Answer of `tvclin nozzle --over flight`: the duty of the nozzle, and its data sheet."""

from dataclasses import replace

from tvclin.base.errors import InputError
from tvclin.cli.ascent import flight_asked
from tvclin.cli.gains import FlownLaw
from tvclin.cli.inputs import note_left_out
from tvclin.cli.nozzle_options import NozzleOptions
from tvclin.cli.options import ShownCurves
from tvclin.cli.output import answer, print_answer, print_tables
from tvclin.cli.progress import bar
from tvclin.control.laws.registry import AUTOPILOT
from tvclin.nozzle.duty_over_flight import flight_duty

_QUESTION = "nozzle --over flight"
_USED = (
    "used is what the law uses in its samples, within the limits, at least the lower bound; the"
    " required deflection is that of tvclin ascent or study"
)


def print_duty(source: str, options: NozzleOptions, more: bool, shown: ShownCurves) -> None:
    """Print what a law in a whole flight takes of the nozzle, and the verdict on its limits."""
    groups = (options.limits, options.model, options.planes)
    case = flight_asked(_QUESTION, source, options.winds, options.times, *groups)
    request, names = case.sizing, options.names
    assert request is not None
    if len(names) > 1:
        raise InputError(f"--law may be given once with --over flight; got {len(names)}")
    law = names[0] if names else request.card or "trim"
    if law != AUTOPILOT:
        FlownLaw().only_with_autopilot(source)
        note_left_out(case, f"{_QUESTION} without the law {AUTOPILOT}")
    with bar("flight times and winds") as progress:
        duty = flight_duty(case, request, law, progress=progress)
    notes = [*request.warnings, *request.notes, *duty.notes]
    if shown.csv is not None:
        duty.to_csv(shown.csv)
    sheet, *further = duty.tables()
    sheet = replace(sheet, caption=f"{duty.vehicle}, {law} flown\n{sheet.caption}")
    answer(
        shown.as_json,
        lambda: duty.as_dict() | {"notes": notes},
        lambda: print_answer(
            duty.verdict.words,
            sheet,
            notes=[*notes, _USED],
            more=more,
            details=lambda: print_tables(*further),
        ),
        bool(duty.verdict.satisfied),
    )
