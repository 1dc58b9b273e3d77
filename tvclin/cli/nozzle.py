"""`tvclin nozzle`: angle and rate that a wind asks for, and what a law's flight asks of both."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tvclin.cli.fly_linear import LinearCase
from tvclin.cli.gains import GainOptions, LoopOptions
from tvclin.cli.inputs import case_of, note_left_out, only_with
from tvclin.cli.options import (
    AsJson,
    Csv,
    LimitDeg,
    Model,
    Plane,
    Plot,
    RateLimitDeg,
    Rigid,
    SampleRate,
    Source,
    grouped,
)
from tvclin.cli.output import print_tables, say, say_notes
from tvclin.cli.progress import waiting
from tvclin.cli.wind import WindOptions, wind_words

if TYPE_CHECKING:
    from tvclin.boundary.rates import RateFront


@grouped
def nozzle(
    vehicle: Source = "configuration-i",
    blows: WindOptions = WindOptions(),
    limit_deg: LimitDeg = None,
    rate_limit_deg: RateLimitDeg = None,
    law: Annotated[
        str | None,
        typer.Option(
            help="Also fly this law with both limits: autopilot (the gains below), trim, dead-band,"
            " half-relief or recoverable-attitude. It needs a deflection limit.",
            show_default="none is flown",
        ),
    ] = None,
    sample_rate: SampleRate = None,
    gains: GainOptions = GainOptions(),
    loop: LoopOptions = LoopOptions(),
    rigid: Rigid = False,
    model: Model = None,
    plane: Plane = None,
    csv: Csv = None,
    as_json: AsJson = False,
    plot: Plot = None,
) -> None:
    """Print the least deflection over the deflection rate, and what a nozzle has left of both.

    With --law also what the flight of the law asks of the nozzle: rate, travel, time at the stop.

    Exit code 0: enough, or not asked; 1: not enough, or the law does not survive; 2: bad input.
    """
    from tvclin.answers.nozzle_motion import FlownCard
    from tvclin.base.documents import picked
    from tvclin.base.errors import InputError, one_of
    from tvclin.boundary.rates import rate_front
    from tvclin.cli.output import print_json
    from tvclin.control.laws.registry import AUTOPILOT, LAWS

    if law is None:
        only_with("--law", **vars(gains), **vars(loop), sample_rate=sample_rate)
    elif one_of("--law", law, LAWS) != AUTOPILOT:
        only_with(f"--law {AUTOPILOT}", **vars(gains))
    case = case_of(
        vehicle,
        *(gains.over, loop.over),
        blows=blows.over,
        told=("nozzle",),
        rigid=rigid,
        model=model,
        plane=plane,
        limit_deg=limit_deg,
        rate_limit_deg=rate_limit_deg,
        sample_rate=sample_rate,
    )
    if law is None:
        note_left_out(case, "nozzle without --law")
    elif case.nozzle.limit is None:
        raise InputError("--law needs --limit-deg, the stop of the nozzle")
    history, plant, given = case.history, case.plant.rigid, case.nozzle
    with waiting("angle over rate"):
        front = rate_front(plant, history, limit=given.limit, rate_limit=given.rate_limit)
    name = blows.name(case)
    flown = None
    if law is not None:
        with waiting("flying"):
            flown = FlownCard.of(case, law, LinearCase(case, name, law, None).control)
    title = f"{case.vehicle.name or vehicle}, {plant.model}: {wind_words(name, case)}"
    if csv is not None or plot is not None:
        _write(front, title, csv, plot)
    if as_json:
        wind = {"name": name, **picked(history, "peak_deg onset_s end_s")}
        head = {"vehicle": case.vehicle.name, "model": plant.model, "wind": wind}
        print_json(head | {"plane": case.plane, "front": front, "flown": flown})
    else:
        say(title)
        print_tables(*front.tables(), *(flown.tables() if flown is not None else ()))
        say_notes([*front.notes, *(flown.notes if flown is not None else ())])
        say(f"Verdict: {front.verdict}.")
        if flown is not None:
            say(f"Flown: {flown.words}.")
    if front.enough is False or (flown is not None and not flown.survived):
        raise typer.Exit(1)


def _write(front: "RateFront", title: str, csv: Path | None, plot: Path | None) -> None:
    from tvclin.base.files import write_text
    from tvclin.plots import rate_chart, rate_curves, save_figure

    if csv is not None:
        write_text(csv, rate_curves(front).csv())
    if plot is not None:
        save_figure(rate_chart(front, title.replace(": ", "\n")), plot)
