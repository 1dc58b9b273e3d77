"""`tvclin laws`: what each control law needs in the standard winds, from trim to the minimum."""

from typing import TYPE_CHECKING, Annotated

import typer

from tvclin.cli.bands import parts_line
from tvclin.cli.gains import LoopOptions
from tvclin.cli.inputs import only_with, vehicle_of
from tvclin.cli.options import (
    MODEL_DEFAULT,
    MODELS_HELP,
    AsJson,
    LinearVehicle,
    Plane,
    Plot,
    Rigid,
    grouped,
)
from tvclin.cli.output import print_tables, say, say_notes
from tvclin.cli.progress import bar, share
from tvclin.cli.wind import BlowingOptions

if TYPE_CHECKING:
    from tvclin.answers.trials import LawTrial
    from tvclin.vehicle.linear_vehicle import AnyVehicle
    from tvclin.winds.histories import History


@grouped
def laws(
    vehicle: LinearVehicle = "configuration-i",
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
    sample_rate: Annotated[float, typer.Option(help="Sample rate of the law, in Hz.")] = 100.0,
    rate_limit_deg: Annotated[
        float | None, typer.Option(help="Rate limit of the nozzle, in deg/s.")
    ] = None,
    model: Annotated[
        str | None,
        typer.Option(
            help=f"Model with one or two real unstable poles: {MODELS_HELP}",
            show_default=MODEL_DEFAULT,
        ),
    ] = None,
    plane: Plane = "pitch",
    loop: LoopOptions = LoopOptions(),
    rigid: Rigid = False,
    as_json: AsJson = False,
    plot: Plot = None,
) -> None:
    """Fly five laws in the standard winds and print the deflection limit that each needs.

    It takes about a second for each law and wind, and a minute more for a figure. A vehicle file
    with bending, slosh, engine inertia or sensor lags makes a flexible vehicle, which flies with an
    actuator; a rigid one does where an actuator is given. --rigid leaves all that out.

    A gust blows on top of each wind; a sounding, --winds, in place of them all.

    Exit code 0: answered; 2: bad input.
    """
    import numpy as np

    from tvclin.answers.case import Case
    from tvclin.answers.flexible import with_filters
    from tvclin.answers.trial_tables import LEGEND, bounds, doubts, loads, needed, tried
    from tvclin.answers.trials import law_trials, standard_laws
    from tvclin.base.errors import one_of, within
    from tvclin.cli.output import print_json

    loaded = vehicle_of(vehicle, rigid)
    flexible, rate = loaded.structure is not None, rate_limit_deg
    if plot is not None:
        only_with("no --plot: that is drawn of pulses alone", gust=blows.gust, winds=blows.winds)
    case = Case(
        vehicle=loaded,
        model=model or "",
        plane=plane,
        nozzle=loop.nozzle(None, rate) if flexible else loop.nozzle(None, rate, actuator=0.0),
        design=loop.design(sample_rate=sample_rate),
    )
    flying, plant = case.plant, case.plant.rigid
    peak, duration, every = _winds(blows, wind, vehicle, loaded, plane)
    within("--cuts", cuts, 0, 1000)
    chosen = standard_laws(plant, peak)
    chosen = {name: with_filters(law, case.asked) for name, law in chosen.items()}
    winds = {name: every[one_of("--wind", name, every)] for name in wind or every}
    found: list[LawTrial] = []
    with bar("flights") as progress:
        for k, (name, law) in enumerate(chosen.items()):
            told = share(progress, k, len(chosen))
            found += law_trials(
                flying, {name: law}, winds, cuts=cuts, progress=told, **case.hardware
            )
    if plot is not None:
        from tvclin.plots import laws_chart, save_figure

        save_figure(laws_chart(flying, chosen, peak, **case.hardware), plot)
    beside = bounds(plant, winds)
    if as_json:
        head = {
            "vehicle": loaded.name,
            "model": plant.model,
            "plane": plane,
            "peak_deg": np.degrees(peak),
            "duration_s": duration,
            "flexible": flexible,
            "cuts": cuts,
            "sample_rate_Hz": sample_rate,
            "trim_deflection_deg": max(one.trim_deg for one in beside.values()),
        }
        trims = {name: one.trim_deg for name, one in beside.items()}
        trials = [{**vars(one), "limit_deg": trims[one.wind] * one.limit} for one in found]
        limits = {name: one.no_forecast for name, one in beside.items()}
        print_json({**head, "trials": trials, "no_forecast": limits})
    else:
        if flying.structure is not None:
            say(parts_line(flying.structure))
            say(f"law at {sample_rate:g} Hz, delay {loop.delay_ms:g} ms")
        wind_words = f"winds of {abs(float(np.degrees(peak))):.4g} deg and {duration:g} s"
        servo = case.nozzle.actuator
        engine = f"actuator {servo.natural_frequency:g} rad/s" if servo else "no actuator"
        say(f"{loaded.name or vehicle}, {plant.model}, {wind_words}, {engine}")
        print_tables(*needed(found, beside), loads(found))
        say(LEGEND)
        say(tried(found))
        say_notes(doubts(found))


def _winds(
    blows: BlowingOptions,
    names: list[str] | None,
    source: str,
    vehicle: "AnyVehicle",
    plane: str,
) -> "tuple[float, float, dict[str, History]]":
    """Peak [rad] and duration [s] for which laws are designed, and the winds by name."""
    from tvclin.answers.trials import standard_winds

    if blows.winds is not None:
        only_with("the standard winds in place of --winds", wind=names)
        met = blows.sounding(source, vehicle, plane)
        return float(met.peak), float(met.end - met.onset), {blows.winds.name: met}
    pulse = blows.pulse(vehicle, plane)
    every = standard_winds(pulse.peak, pulse.duration)
    if pulse.gust is not None:
        every = {name: one + pulse.gust for name, one in every.items()}
    return pulse.peak, pulse.duration, every
