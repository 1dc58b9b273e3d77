"""`tvclin nozzle`: angle and rate that a wind asks for, and what a law's flight asks of both."""

from tvclin.answers.nozzle_cards.flown import FlownCard
from tvclin.answers.study_file.plan import StudyPlan
from tvclin.base.errors import InputError, one_of
from tvclin.base.lines import listed
from tvclin.boundary.rates import RateFront, rate_front
from tvclin.cli.fly_linear import LinearCase
from tvclin.cli.gains import GAINS, LoopOptions
from tvclin.cli.inputs import case_of, note_left_out, only_with
from tvclin.cli.options import (
    GROUP,
    MOTION,
    NOZZLE,
    SAMPLE_RATE,
    Given,
    Rigid,
    ShownCurves,
    Source,
    asked,
)
from tvclin.cli.output import answer, print_tables, say, say_notes
from tvclin.cli.progress import waiting
from tvclin.cli.wind import WindOptions
from tvclin.control.laws.registry import AUTOPILOT, LAWS

_OF_FLIGHTS = ("acceleration_limit", "travel_limit", "torque_limit", "power_limit")
"""What a flight is held to, and no theory."""


def nozzle(
    vehicle: Source = "configuration-i",
    blows: WindOptions = GROUP,
    limits: Given = Given(NOZZLE, at="nozzle"),
    law: str | None = asked(
        f"Also fly this law with both limits: {listed(LAWS, 'or')}; gains below are of {AUTOPILOT}."
        " It needs a deflection limit.",
        shown="none is flown",
    ),
    samples: Given = SAMPLE_RATE,
    gains: Given = GAINS,
    loop: LoopOptions = GROUP,
    rigid: Rigid = False,
    motion: Given = MOTION,
    shown: ShownCurves = GROUP,
) -> None:
    """Print the least deflection over the deflection rate, and what a nozzle has left of both.

    With --law also what the flight of the law asks of the nozzle: rate, travel, time at the stop.

    Exit code 0: enough, or not asked; 1: not enough, or the law does not survive; 2: bad input.
    """
    from tvclin import plots

    if law is None:
        for one in (gains, samples):
            one.only_with("--law")
        limits.only_with("--law", *_OF_FLIGHTS)
        only_with("--law", **vars(loop))
    elif one_of("--law", law, LAWS) != AUTOPILOT:
        gains.only_with(f"--law {AUTOPILOT}")
    changes = [one.over for one in (limits, samples, motion, gains, loop)]
    case = case_of(vehicle, *changes, blows=blows.over, told=("nozzle",), rigid=rigid)
    flown, given = _flown(case, law, blows.name(case)), case.nozzle
    with waiting("angle over rate"):
        front = rate_front(
            case.plant.rigid, case.history, limit=given.limit, rate_limit=given.rate_limit
        )
    title = blows.title(case, vehicle)
    shown.write(
        lambda: plots.rate_curves(front),
        lambda _: plots.rate_chart(front, title.replace(": ", "\n")),
    )
    lost = front.enough is False or (flown is not None and flown.verdict.enough is False)
    answer(
        shown.as_json,
        lambda: blows.document(case) | {"front": front, "flown": flown},
        lambda: _print(title, front, flown),
        not lost,
    )


def _flown(case: StudyPlan, law: str | None, wind: str) -> FlownCard | None:
    """What the flight of a law in a wind with a name asks of the nozzle; None without a law."""
    if law is None:
        note_left_out(case, "nozzle without --law")
        return None
    if case.nozzle.limit is None:
        raise InputError("--law needs --limit-deg, the stop of the nozzle")
    with waiting("flying"):
        return FlownCard.of(case, law, LinearCase(case, wind, law, None).control)


def _print(title: str, front: RateFront, flown: FlownCard | None) -> None:
    say(title)
    print_tables(*front.tables(), *(flown.tables() if flown is not None else ()))
    say_notes([*front.notes, *(flown.notes if flown is not None else ())])
    say(f"Verdict: {front.verdict}.")
    if flown is not None:
        say(f"Flown: {flown.words}. {flown.verdict.words}.")
