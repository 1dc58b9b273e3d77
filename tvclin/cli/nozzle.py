"""`tvclin nozzle`: angle and rate that a wind requires, and the duty in a law's flight."""

from tvclin.base.errors import one_of
from tvclin.base.lines import listed
from tvclin.base.quantities import NOMINAL
from tvclin.boundary.limit_over_rate import RateTradeOff, rate_trade_off
from tvclin.cli.fly_linear import law_with_a_stop
from tvclin.cli.gains import FlownLaw
from tvclin.cli.inputs import case_of, note_left_out, note_nominal_pressure
from tvclin.cli.options import (
    BOTH_LIMITS,
    GROUP,
    MOTION,
    At,
    Given,
    Rigid,
    ShownCurves,
    Source,
    asked,
    switch,
)
from tvclin.cli.output import answer, print_tables, say, say_bound, say_notes
from tvclin.cli.progress import bar, waiting
from tvclin.cli.wind import WindOptions
from tvclin.control.laws.registry import AUTOPILOT, LAWS
from tvclin.nozzle.duty_over_flight import FlownDuty
from tvclin.nozzle.flown_trade_off import FlownTradeOff, flown_trade_offs
from tvclin.requirement.case_requirement import CaseRequirement, study_requirement
from tvclin.studyfile.study_plan import StudyPlan


def nozzle(
    vehicle: Source = "configuration-i",
    time: At = None,
    winds: WindOptions = GROUP,
    limits: Given = BOTH_LIMITS,
    law: str | None = asked(
        f"Also fly this law with both limits: {listed(LAWS, 'or')}; gains below are of {AUTOPILOT}."
        " It needs a deflection limit.",
        shown="none is flown",
    ),
    laws: bool = switch(
        "--laws",
        "Also fly every law, of a study file those of its laws, at each rate limit, for the limit"
        " that it needs; it takes about a minute.",
    ),
    flies: FlownLaw = GROUP,
    rigid: Rigid = False,
    motion: Given = MOTION,
    shown: ShownCurves = GROUP,
) -> None:
    """Print the minimum deflection over the deflection rate, and what remains of both.

    With --law also what the flight of the law asks of the nozzle: rate, travel, time at the stop.
    With --laws also the limit that each law needs flown, in the whole wind and with a sudden stop.

    All of it is at nominal dynamic pressure. A limit below the lower bound is never sufficient; of
    one above it tvclin study is the verdict.

    Exit code 0: the limits are not below the lower bounds, and the flight of the law is MET; 1: NOT
    SUFFICIENT, below a lower bound, or the flight NOT SURVIVED or NOT MET, or NOT KNOWN; 2: bad
    input.
    """
    from tvclin import plots

    if law is None and not laws:
        flies.only_with("--law")
    elif law is not None and one_of("--law", law, LAWS) != AUTOPILOT and not laws:
        flies.only_with_autopilot(vehicle)
    changes = [options.over for options in (limits, motion, flies)]
    case = case_of(vehicle, *changes, wind=winds.over, told=("nozzle",), rigid=rigid, time=time)
    if law is None and not laws:
        note_left_out(case, "nozzle without --law")
    flown = _flown(case, law)
    with waiting("angle over rate"):
        front = _front(case)
    title, needed = winds.title(case, vehicle), _needed(case) if laws else None
    drawn, more = needed or front, {} if needed is None else {"laws": needed}
    required = study_requirement(case)
    limited = front.limit is not None or front.rate_limit is not None
    shown.write(
        lambda: plots.rate_curves(drawn),
        lambda _: plots.rate_chart(drawn, title.replace(": ", "\n")),
    )
    note_nominal_pressure(case)
    answer(
        shown.as_json,
        lambda: winds.document(case, required) | {"trade_off": front, "flown": flown} | more,
        lambda: _print(title, front, needed, flown, required),
        not (limited and front.verdict) and (flown is None or bool(flown.verdict.satisfied)),
    )


def _front(case: StudyPlan) -> RateTradeOff:
    limit, rate_limit = case.nozzle.limit, case.nozzle.rate_limit
    return rate_trade_off(case.plant.rigid, case.history, limit=limit, rate_limit=rate_limit)


def _flown(case: StudyPlan, law: str | None) -> FlownDuty | None:
    """Return the duty of the nozzle in the flight of a law; None without a law."""
    if law is None:
        return None
    with waiting("flying"):
        return FlownDuty.of(case, law, law_with_a_stop(case, law))


def _needed(case: StudyPlan) -> FlownTradeOff:
    """Return the required deflection of each law at each rate limit."""
    names = tuple(LAWS) if case.laws is None else case.laws.names
    with bar("boundaries") as progress:
        return flown_trade_offs({"": case}, laws=names, progress=progress)[""]


def _print(
    title: str,
    front: RateTradeOff,
    needed: FlownTradeOff | None,
    flown: FlownDuty | None,
    required: CaseRequirement | None,
) -> None:
    """Print trade-off, requirements of laws and duty of the nozzle, with the verdict."""
    said = [result for result in (front, needed, flown) if result is not None]
    say(title)
    print_tables(*(table for result in said for table in result.tables()))
    say_notes([note for result in said for note in result.notes])
    say_bound(front, required)
    if flown is not None:
        say(f"Flown {NOMINAL}: {flown.words}. {flown.verdict.words}.")
