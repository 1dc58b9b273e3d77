"""`tvclin loads`: the deflection required with a bound on load, and the load in flights of laws."""

import numpy as np

from tvclin.base.errors import one_of
from tvclin.base.lines import listed
from tvclin.base.quantities import NOMINAL
from tvclin.boundary.limit_over_load import LoadTradeOff, load_trade_off
from tvclin.case.load import FlownLoad
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
)
from tvclin.cli.output import answer, print_tables, say, say_bound, say_notes
from tvclin.cli.progress import waiting
from tvclin.cli.wind import WindOptions
from tvclin.control.laws.registry import AUTOPILOT, LAWS
from tvclin.requirement.case_requirement import CaseRequirement, study_requirement
from tvclin.studyfile.study_plan import StudyPlan


def loads(
    vehicle: Source = "configuration-i",
    time: At = None,
    winds: WindOptions = GROUP,
    limits: Given = BOTH_LIMITS,
    bound: Given = Given("case.load.LoadBound", ("load",), "load"),
    law: list[str] | None = asked(
        f"Also fly this law with the limit, and tell its load: {listed(LAWS, 'or')}; gains below"
        f" are of {AUTOPILOT}. May be given several times.",
        shown="none is flown",
    ),
    flies: FlownLaw = GROUP,
    rigid: Rigid = False,
    motion: Given = MOTION,
    shown: ShownCurves = GROUP,
) -> None:
    """Print the minimum deflection over the largest angle of attack, or bending moment.

    With --law also the load in the flight of the law, with the limit as a stop.

    All of it is at nominal dynamic pressure. A limit below the lower bound is never sufficient; of
    one above it tvclin study is the verdict.

    Exit code 0: the limit is not below the lower bound, and each law survives within the load; 1:
    NOT SUFFICIENT, below the lower bound, or a flight NOT SURVIVED or beyond the load, or NOT
    KNOWN; 2: bad input.
    """
    from tvclin import plots

    names = [one_of("--law", item, LAWS) for item in law or ()]
    if not names:
        flies.only_with("--law")
    elif AUTOPILOT not in names:
        flies.only_with_autopilot(vehicle)
    changes = [item.over for item in (limits, bound, motion, flies)]
    case = case_of(vehicle, *changes, wind=winds.over, told=("loads",), rigid=rigid, time=time)
    flown = _flown(case, names)
    with waiting("angle over load"):
        front = _trade_off(case)
    title = winds.title(case, vehicle)
    shown.write(
        lambda: plots.load_curves(front, flown),
        lambda _: plots.load_chart(front, flown, title.replace(": ", "\n")),
    )
    note_nominal_pressure(case)
    required = study_requirement(case)
    answer(
        shown.as_json,
        lambda: winds.document(case, required) | {"trade_off": front, "flown": flown},
        lambda: _print(title, front, flown, required),
        (front.limit is None or not front.verdict) and all(item.survives_within for item in flown),
    )


def _trade_off(case: StudyPlan) -> LoadTradeOff:
    """Return the trade-off curve of limit over load, by the load limit of a file if it has one."""
    if case.load is not None:
        return case.load.trade_off(case)
    limit, rate = case.nozzle.limit, case.nozzle.rate_limit
    fastest = np.inf if rate is None else rate
    return load_trade_off(case.plant.rigid, case.history, limit=limit, rate_limit=fastest)


def _print(
    title: str, front: LoadTradeOff, flown: list[FlownLoad], required: CaseRequirement | None
) -> None:
    """Print the trade-off of limit and load, and the flown loads."""
    say(title)
    print_tables(*front.tables())
    say_notes(front.notes)
    say_bound(front, required)
    for load in flown:
        say(f"Flown {NOMINAL}: {load.words}.")


def _flown(case: StudyPlan, names: list[str]) -> list[FlownLoad]:
    """Return the loads in the flights of laws."""
    if not names:
        note_left_out(case, "loads without --law")
        return []
    with waiting("flying"):
        return [FlownLoad.of(case, name, law_with_a_stop(case, name), case.load) for name in names]
