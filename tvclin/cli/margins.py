"""`tvclin margins`: the stability margins of an autopilot, and whether they are enough."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tvclin.cli.box import Box, met_in_box, print_worst, worst_in_box
from tvclin.cli.criteria import MODES, CriteriaOptions
from tvclin.cli.detuned import IsDetuned, detuned_of, print_detuned
from tvclin.cli.flown import Flown, FlownLimitDeg, flown_of, print_flown
from tvclin.cli.gains import GainOptions, LoopOptions
from tvclin.cli.inputs import case_of, note_left_out, only_with
from tvclin.cli.options import (
    AsJson,
    Model,
    Plane,
    Plot,
    RateLimitDeg,
    Rigid,
    SampleRate,
    Source,
    grouped,
)
from tvclin.cli.wind import WindOptions

if TYPE_CHECKING:
    from tvclin.control.autopilot.autopilot import Autopilot
    from tvclin.control.margins.criteria import Criteria

_CHARTS = ("nichols", "bode", "nyquist", "root-locus")


@grouped
def margins(
    vehicle: Source = "configuration-i",
    gains: GainOptions = GainOptions(),
    loop: LoopOptions = LoopOptions(),
    criteria: CriteriaOptions = CriteriaOptions(),
    rigid: Rigid = False,
    detuned: IsDetuned = False,
    box: Box = None,
    model: Model = None,
    plane: Plane = None,
    chart: Annotated[
        str, typer.Option(help="What --plot draws: nichols, bode, nyquist or root-locus.")
    ] = "nichols",
    flown: Flown = False,
    limit_deg: FlownLimitDeg = None,
    rate_limit_deg: RateLimitDeg = None,
    blows: WindOptions = WindOptions(),
    sample_rate: SampleRate = None,
    as_json: AsJson = False,
    plot: Plot = None,
) -> None:
    """Print the stability margins of an attitude and rate autopilot, and judge them.

    A vehicle file with bending, slosh, engine inertia or sensor lags makes a flexible vehicle: its
    margins are printed as a whole and for each mode. --rigid leaves all that out.

    --flown flies through the wind with the limit --limit-deg, and prints how much gain,
    effectiveness and delay may change before a flight is lost. The criteria judge the linear
    margins, not these.

    --box lets numbers lie anywhere between two values, and prints the worst margins of the rigid
    vehicle there, and the worst required deflection. The criteria judge the worst margins too.

    Exit code 0: the criteria are met; 1: they are not, or the loop is unstable; 2: bad input.
    """
    from tvclin.answers.least_gains.asked import autopilot_asked
    from tvclin.base.errors import one_of
    from tvclin.cli.margin_tables import MarginsFound, margins_document, print_margins
    from tvclin.cli.output import print_json, say
    from tvclin.control.autopilot.rules import LEAST_NOZZLE

    one_of("--chart", chart, _CHARTS)
    case = case_of(
        vehicle,
        *(criteria.over, gains.over, loop.over),
        blows=blows.over,
        rigid=rigid,
        model=model,
        plane=plane,
        limit_deg=limit_deg,
        rate_limit_deg=rate_limit_deg,
        sample_rate=sample_rate,
    )
    loaded, plant, asked, name = case.vehicle, case.plant, case.held_to, blows.name(case)
    sought = case.asked.design == LEAST_NOZZLE
    only_with(MODES, detuned=detuned and loaded.structure is None)
    if not flown:
        only_with("--flown", limit_deg=limit_deg, rate_limit_deg=rate_limit_deg)
    if not (flown or box or sought):
        only_with("--flown or --box", **vars(blows))
    aside = ["margins --box"] * bool(box) + ["margins without --flown"] * (not flown)
    aside += ["margins without --flown and --box"] * (not (flown or box or sought))
    note_left_out(case, "margins", *aside)
    autopilot = autopilot_asked(case, case.history, asked)
    found = MarginsFound.of(autopilot, plant, asked)
    moved = detuned_of(found) if detuned else None
    in_wind = flown_of(case, autopilot) if flown and found.whole.stable else None
    in_box = worst_in_box(box or [], case, autopilot)
    in_all = asked.without_modes or asked  # the box is of the rigid vehicle
    if in_box is not None and autopilot.sample_rate is not None:
        say("Note: the margins in the box are of the continuous autopilot.", err=True)
    if plot is not None:
        _draw(chart, autopilot, plant, asked, plot)
    if as_json:
        head = {"vehicle": loaded.name, "model": plant.model, "plane": case.plane}
        wind = {"name": name, "peak_deg": math.degrees(case.history.peak)}
        met = None if in_box is None else in_box.as_dict() | {"met": met_in_box(in_box, in_all)}
        beside = {"wind": in_wind and wind, "detuned": moved, "flown": in_wind, "box": met}
        more = {name: one for name, one in beside.items() if one is not None}
        print_json(head | margins_document(found) | more)
    else:
        print_margins(f"{loaded.name or vehicle}, {plant.model}, {case.plane}", found)
        if moved is not None:
            print_detuned(moved)
        if in_wind is not None:
            print_flown(in_wind, case, name)
        if in_box is not None:
            print_worst(in_box, in_all)
    if not (found.met and (in_box is None or met_in_box(in_box, in_all))):
        raise typer.Exit(1)


def _draw(chart: str, autopilot: "Autopilot", plant: Any, asked: "Criteria", plot: Path) -> None:
    from tvclin import plots

    draw = {
        "nichols": lambda: plots.nichols_chart(autopilot, plant, asked),
        "bode": lambda: plots.bode_chart(autopilot, plant),
        "nyquist": lambda: plots.nyquist_chart(autopilot, plant),
        "root-locus": lambda: plots.root_locus_chart(autopilot, plant),
    }
    plots.save_figure(draw[chart](), plot)
