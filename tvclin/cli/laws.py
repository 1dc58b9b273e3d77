"""`tvclin laws`: what each control law needs in the standard winds, from trim to the minimum."""

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from tvclin.cli.bands import parts_line
from tvclin.cli.gains import GainOptions, LoopOptions
from tvclin.cli.inputs import case_of, note_left_out, only_with
from tvclin.cli.options import (
    MODEL_DEFAULT,
    MODELS_HELP,
    AsJson,
    Plane,
    Plot,
    RateLimitDeg,
    Rigid,
    SampleRate,
    Source,
    grouped,
)
from tvclin.cli.output import print_tables, say, say_notes
from tvclin.cli.progress import bar, share
from tvclin.cli.wind import BlowingOptions

if TYPE_CHECKING:
    from tvclin.answers.study_file.plan import StudyPlan
    from tvclin.answers.trials import LawTrial
    from tvclin.winds.histories import History


@grouped
def laws(
    vehicle: Source = "configuration-i",
    blows: BlowingOptions = BlowingOptions(),
    wind: Annotated[
        list[str] | None,
        typer.Option(
            help="Only this wind; may be given several times: triangle, 'sawtooth, stops dead',"
            " 'sawtooth, jumps first', '1 - cosine', trapezoid, 'two gusts', 'opposite gusts',"
            " 'flip to 0.3', 'full reversal'.",
            show_default="all",
        ),
    ] = None,
    cuts: Annotated[int, typer.Option(help="Also fly each wind cut off at so many instants.")] = 0,
    sample_rate: SampleRate = None,
    rate_limit_deg: RateLimitDeg = None,
    model: Annotated[
        str | None,
        typer.Option(
            help=f"Model with one or two real unstable poles: {MODELS_HELP}",
            show_default=MODEL_DEFAULT,
        ),
    ] = None,
    plane: Plane = None,
    gains: GainOptions = GainOptions(),
    loop: LoopOptions = LoopOptions(),
    rigid: Rigid = False,
    as_json: AsJson = False,
    plot: Plot = None,
) -> None:
    """Fly five laws in the standard winds and print the deflection limit that each needs.

    It takes about a second for each law and wind, and a minute more for a figure. A vehicle file
    with bending, slosh, engine inertia or sensor lags makes a flexible vehicle, which flies with an
    actuator; a rigid one does where an actuator is given. --rigid leaves all that out.

    A gust blows on top of each wind; a sounding, --winds, in place of them all. Gains are those of
    the law autopilot.

    Exit code 0: answered; 2: bad input.
    """
    import numpy as np

    from tvclin.answers.flexible import with_filters
    from tvclin.answers.least_gains.asked import autopilot_asked
    from tvclin.answers.trial_tables import LEGEND, bounds, doubts, loads, needed, tried
    from tvclin.answers.trials import law_trials, standard_laws
    from tvclin.base.errors import one_of, within
    from tvclin.cli.output import print_json
    from tvclin.linear.flexible import plant_of

    if plot is not None:
        only_with("no --plot: that is drawn of pulses alone", gust=blows.gust, winds=blows.winds)
    within("--cuts", cuts, 0, 1000)
    case = case_of(
        vehicle,
        *(_beside_boundaries, partial(_with_gains, gains), loop.over),
        blows=blows.over,
        told=("laws",),
        rigid=rigid,
        model=model,
        plane=plane,
        rate_limit_deg=rate_limit_deg,
        sample_rate=sample_rate,
    )
    asked, hardware = case.laws, case.hardware
    if asked is not None and sample_rate is None:
        hardware["sample_rate"] = asked.sample_rate
        note_left_out(case, "laws with a rate in [laws]")
    loaded, flying = case.vehicle, plant_of(case.vehicle, case.law_model, case.plane)
    plant, rate = flying.rigid, hardware["sample_rate"]
    peak, duration, every = _winds(blows, wind, case)
    autopilot = autopilot_asked(case, case.history, case.held_to)
    chosen = {
        name: with_filters(law, case.asked)
        for name, law in standard_laws(plant, peak, autopilot).items()
        if asked is None or name in asked.names
    }
    named = wind or (asked.winds if asked is not None and blows.winds is None else every)
    winds = {name: every[one_of("--wind", name, every)] for name in named}
    found: list[LawTrial] = []
    with bar("flights") as progress:
        for k, (name, law) in enumerate(chosen.items()):
            told = share(progress, k, len(chosen))
            found += law_trials(flying, {name: law}, winds, cuts=cuts, progress=told, **hardware)
    if plot is not None:
        from tvclin.plots import laws_chart, save_figure

        save_figure(laws_chart(flying, chosen, peak, **hardware), plot)
    beside = bounds(plant, winds)
    if as_json:
        head = {
            "vehicle": loaded.name,
            "model": plant.model,
            "plane": case.plane,
            "peak_deg": np.degrees(peak),
            "duration_s": duration,
            "flexible": flying.structure is not None,
            "cuts": cuts,
            "sample_rate_Hz": rate,
            "trim_deflection_deg": max(one.trim_deg for one in beside.values()),
        }
        trims = {name: one.trim_deg for name, one in beside.items()}
        trials = [{**vars(one), "limit_deg": trims[one.wind] * one.limit} for one in found]
        limits = {name: one.no_forecast for name, one in beside.items()}
        print_json({**head, "trials": trials, "no_forecast": limits})
    else:
        if flying.structure is not None:
            say(parts_line(flying.structure))
            say(f"law at {rate:g} Hz, delay {1000.0 * case.asked.delay:g} ms")
        wind_words = f"winds of {abs(float(np.degrees(peak))):.4g} deg and {duration:g} s"
        servo = case.nozzle.actuator
        engine = f"actuator {servo.natural_frequency:g} rad/s" if servo else "no actuator"
        say(f"{loaded.name or vehicle}, {plant.model}, {wind_words}, {engine}")
        print_tables(*needed(found, beside), loads(found))
        say(LEGEND)
        say(tried(found))
        say_notes(doubts(found))


def _beside_boundaries(plan: "StudyPlan") -> "StudyPlan":
    """Return the case of a file as laws fly it beside boundaries, which have no actuator."""
    if plan.vehicle.structure is not None:
        return plan
    note_left_out(plan, "laws of a rigid vehicle")
    design = plan.design and plan.design.bare
    return replace(plan, nozzle=replace(plan.nozzle, actuator=None), design=design)


def _with_gains(gains: GainOptions, plan: "StudyPlan") -> "StudyPlan":
    """Return a plan with the gains of options; `InputError` where no law of its file has them."""
    from tvclin.control.laws.registry import AUTOPILOT

    if plan.laws is not None and AUTOPILOT not in plan.laws.names:
        only_with("the law autopilot in the table [laws]", **vars(gains))
    return gains.over(plan)


def _winds(
    blows: BlowingOptions, names: list[str] | None, case: "StudyPlan"
) -> "tuple[float, float, dict[str, History]]":
    """Peak [rad] and duration [s] for which laws are designed, and the winds by name."""
    from tvclin.answers.trials import standard_winds
    from tvclin.winds.shaped import ShapedWind

    pulse = case.blows
    if not isinstance(pulse, ShapedWind):
        only_with("the standard winds in place of --winds", wind=names)
        met = case.history
        return float(met.peak), float(met.end - met.onset), {blows.name(case): met}
    every = standard_winds(pulse.peak, pulse.duration)
    if (gust := pulse.placed_gust) is not None:
        every = {name: one + gust for name, one in every.items()}
    return pulse.peak, pulse.duration, every
