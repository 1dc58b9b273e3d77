"""`tvclin laws`: what each control law needs in the standard winds, from trim to the minimum."""

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

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
from tvclin.cli.output import say
from tvclin.cli.progress import bar, share
from tvclin.cli.wind import BlowingOptions

if TYPE_CHECKING:
    from tvclin.answers.study_file.plan import StudyPlan
    from tvclin.answers.trials import LawTrial
    from tvclin.linear.plant import Plant
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
    from tvclin.answers.trials import law_trials, standard_laws
    from tvclin.base.errors import one_of, within
    from tvclin.cli.output import print_json
    from tvclin.linear.flexible import plant_of

    if plot is not None:
        only_with("no --plot: that is drawn of pulses alone", gust=blows.gust, winds=blows.winds)
    within("--cuts", cuts, 0, 1000)
    case = case_of(
        vehicle,
        *(_beside_boundaries, gains.over, loop.over),
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
    limits = {name: _without_forecast(plant, history) for name, history in winds.items()}
    trims = {
        name: abs(float(np.degrees(plant.coefficients.B * history.peak)))
        for name, history in winds.items()
    }
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
            "trim_deflection_deg": max(trims.values()),
        }
        trials = [{**vars(one), "limit_deg": trims[one.wind] * one.limit} for one in found]
        print_json({**head, "trials": trials, "no_forecast": limits})
    else:
        if flying.structure is not None:
            say(parts_line(flying.structure))
            say(f"law at {rate:g} Hz, delay {1000.0 * case.asked.delay:g} ms")
        wind_words = f"winds of {abs(float(np.degrees(peak))):.4g} deg and {duration:g} s"
        servo = case.nozzle.actuator
        engine = f"actuator {servo.natural_frequency:g} rad/s" if servo else "no actuator"
        say(f"{loaded.name or vehicle}, {plant.model}, {wind_words}, {engine}")
        _print(found, limits, list(chosen), trims)


def _beside_boundaries(plan: "StudyPlan") -> "StudyPlan":
    """Return the case of a file as laws fly it beside boundaries, which have no actuator."""
    if plan.vehicle.structure is not None:
        return plan
    note_left_out(plan, "laws of a rigid vehicle")
    design = plan.design and plan.design.bare
    return replace(plan, nozzle=replace(plan.nozzle, actuator=None), design=design)


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
    if pulse.gust is not None:
        every = {name: one + pulse.gust for name, one in every.items()}
    return pulse.peak, pulse.duration, every


def _without_forecast(plant: "Plant", wind: "History") -> float | None:
    from tvclin.base.errors import InputError
    from tvclin.boundary.forecast_free import forecast_free_limit

    try:
        return forecast_free_limit(plant, wind).limit
    except InputError:
        return None


def _print(
    found: list["LawTrial"],
    limits: dict[str, float | None],
    names: list[str],
    trims: dict[str, float],
) -> None:
    from tvclin.cli.output import print_table
    from tvclin.flights.closed_loop.edges import ABOVE, PARTS, STEPS

    headings = ["wind", *(name.replace("-", " ") for name in names), "any law"]
    table = {(one.wind, one.law): one for one in found}

    def rows(show: Any) -> list[list[str]]:
        return [[wind, *(show(table[wind, law]) for law in names), ""] for wind in limits]

    takes = " to ".join(f"{one:.4f}" for one in sorted({min(trims.values()), max(trims.values())}))
    for title, scales in (
        (f"Deflection limit needed [deg]; trim of the whole wind takes {takes}", trims),
        ("The same over |B alpha_w,max|, trim of the whole wind", dict.fromkeys(trims, 1.0)),
    ):
        needed = rows(lambda one, scales=scales: _limit(one, scales[one.wind]))
        for row, (wind, limit) in zip(needed, limits.items(), strict=True):
            row[-1] = "-" if limit is None else f"{scales[wind] * limit:.3f}"
        print_table(title, headings, needed)
    loads = rows(_loads)
    print_table(
        "Largest angle of attack / attitude over the wind, with 1.2 times that limit",
        headings[:-1],
        [row[:-1] for row in loads],
    )
    say(
        "any law: lower bound for all laws without a forecast that also survive if the wind stops"
        " for good at any instant (--cuts); - where the wind changes its sign."
    )
    one = found[0]
    scanned = (one.highest - one.lowest) / STEPS
    say(
        f"Tried: limits from {one.lowest:g} to {one.highest:g} in steps of {scanned:.2g}, and for"
        f" {ABOVE * scanned:.2g} above each edge in steps of {scanned / PARTS:.2g}, finer still"
        " near the edge. A narrower range of lost limits would not be seen."
    )
    if not all(one.monotone for one in found):
        say("*: some lower limits survive as well; above this one all that were tried survive.")
    for said in dict.fromkeys(f"!: {one.law}, {one.status}" for one in found if _doubtful(one)):
        say(said)


def _loads(one: "LawTrial") -> str:
    found = one.limit <= one.highest
    return f"{one.peak_angle_of_attack:.2f}/{one.peak_attitude:.2f}" if found else "-"


def _limit(one: "LawTrial", scale: float = 1.0) -> str:
    """The boundary times a scale, or on which side of the range that was tried it lies."""
    shown = f"{scale * one.limit:.3f}"
    if one.limit > one.highest:
        shown = f">{scale * one.highest:.4g}"
    elif one.limit <= one.lowest:
        shown = f"<{scale * one.lowest:.4g}"
    return shown + ("" if one.monotone else "*") + ("!" if _doubtful(one) else "")


def _doubtful(one: "LawTrial") -> bool:
    """Whether there is more to be said of a boundary than the table shows."""
    from tvclin.flights.closed_loop.edges import ALWAYS, NEVER, OK

    return one.status not in (OK, NEVER, ALWAYS)
