"""`tvclin fly`: one flight in one wind, with what the linear theory says of it beside it."""

from typing import Annotated

import typer

from tvclin.cli.flight_cases import REPORT, Flying, flight_case, flight_wind, fly_nonlinear
from tvclin.cli.fly_linear import LinearCase, fly_linear
from tvclin.cli.fly_shown import Shown
from tvclin.cli.fly_winds import Window, Winds, WindsTime, sounding_wind
from tvclin.cli.gains import GainOptions, LoopOptions, given
from tvclin.cli.inputs import note_structure, only_with, vehicle_of
from tvclin.cli.options import (
    AsJson,
    AzimuthDeg,
    Csv,
    Plane,
    Plot,
    Points,
    Rigid,
    Until,
    Vehicle,
    grouped,
)
from tvclin.cli.progress import waiting
from tvclin.cli.pulse import PulseOptions

_LONGEST = 20.0


@grouped
def fly(
    vehicle: Vehicle = "configuration-i",
    blows: PulseOptions = PulseOptions(),
    winds: Winds = None,
    winds_time: WindsTime = None,
    azimuth_deg: AzimuthDeg = None,
    window: Window = None,
    engine: Annotated[
        str | None,
        typer.Option(
            help="planar: nonlinear equations in one plane; sixdof: JSBSim, six degrees of freedom;"
            " linear: linear equations with bending and slosh, a sampled law and an actuator.",
            show_default="linear for a flexible vehicle, else planar",
        ),
    ] = None,
    law: Annotated[
        str | None,
        typer.Option(
            help="Control law: report, autopilot (the gains below), trim, dead-band, half-relief or"
            " recoverable-attitude.",
            show_default="autopilot for --engine linear, else report",
        ),
    ] = None,
    dead_band: Annotated[
        float | None,
        typer.Option(
            help="Dead band K of the laws report and dead-band.",
            show_default="1 for report, 0.5 for dead-band",
        ),
    ] = None,
    limit_deg: Annotated[
        float | None,
        typer.Option(
            help="Deflection limit, in deg.", show_default="1.1 times the linear boundary"
        ),
    ] = None,
    rate_limit_deg: Annotated[
        float | None, typer.Option(help="Rate limit of the nozzle, in deg/s, of --engine linear.")
    ] = None,
    sample_rate: Annotated[
        float | None,
        typer.Option(help="Sample rate of the law of --engine linear, in Hz.", show_default="100"),
    ] = None,
    gains: GainOptions = GainOptions(),
    loop: LoopOptions = LoopOptions(),
    rigid: Rigid = False,
    along_trajectory: Annotated[
        bool,
        typer.Option(
            "--along-trajectory", help="Let mass, speed and dynamic pressure change in flight."
        ),
    ] = False,
    boundary: Annotated[
        bool,
        typer.Option("--boundary", help="Also find, by flights, the least limit that survives."),
    ] = False,
    plane: Plane = "pitch",
    until: Until = 2.0,
    points: Points = 401,
    csv: Csv = None,
    as_json: AsJson = False,
    plot: Plot = None,
) -> None:
    """Fly a vehicle through a wind with a control law, beside the prediction of the linear theory.

    A vehicle file with bending, slosh, engine inertia or sensor lags makes a flexible vehicle: that
    is flown with a sampled law, beside the rigid one. --rigid leaves all that out.

    Exit code 0: survived; 1: not survived; 2: bad input.
    """
    import numpy as np

    from tvclin.answers.case import Case
    from tvclin.base.errors import one_of, positive, within
    from tvclin.control.laws.registry import AUTOPILOT, LAWS
    from tvclin.flights.condition import load_flight_condition
    from tvclin.flights.engines import ENGINES
    from tvclin.vehicle.linear_vehicle import whole_vehicle

    if engine is not None:
        one_of("--engine", engine, (*ENGINES, "linear"))
    one_of("--law", law or REPORT, [REPORT, *LAWS])
    wind, duration = blows.wind, float(positive("--duration", blows.duration, "s"))
    within("--until", until, 1e-3, _LONGEST)
    within("--points", points, 2, 1_000_000)
    loaded = whole_vehicle(vehicle_of(vehicle, rigid), "a flight")
    if winds is None:
        only_with(
            "a sounding, --winds", azimuth_deg=azimuth_deg, window=window, winds_time=winds_time
        )
        gust = flight_wind(loaded, blows, plane, along_trajectory)
    else:
        only_with(
            "a pulse in place of --winds: a sounding has its own peak",
            peak_deg=blows.peak_deg,
            peak_speed=blows.peak_speed,
        )
        asked_of = winds, winds_time, azimuth_deg, window, plane, along_trajectory
        gust, wind = sounding_wind(vehicle, loaded, *asked_of), winds.name
        duration = float(gust.end - gust.onset)
    span, shown = (until * duration, points), Shown(csv, plot, as_json)
    linear = engine == "linear" or (
        engine is None and loaded.structure is not None and not along_trajectory
    )
    chosen = law or (AUTOPILOT if linear else REPORT)
    only_with(f"--law {AUTOPILOT}", **({} if chosen == AUTOPILOT else given(gains)))
    case = Case(
        vehicle=loaded,
        plane=plane,
        wind=gust,
        nozzle=loop.nozzle(limit_deg, rate_limit_deg),
        design=gains.asked(loop, sample_rate),
    )
    flying = wind, chosen, dead_band
    if linear:
        only_with("--engine planar or sixdof", along_trajectory=along_trajectory)
        with waiting("flying"):
            found = fly_linear(LinearCase(case, *flying), boundary, np.linspace(0.0, *span))
    else:
        only_with(
            "--engine linear",
            **given(loop),
            rigid=rigid and engine is not None,
            sample_rate=sample_rate,
            rate_limit_deg=rate_limit_deg,
        )
        note_structure(loaded, plane)
        condition = load_flight_condition(vehicle) if along_trajectory else None
        one = flight_case(Flying(case, *flying), engine or "planar", condition, span[0])
        with waiting("flying"):
            found = fly_nonlinear(one, boundary, *span)
    if not found.show(shown):
        raise typer.Exit(1)
