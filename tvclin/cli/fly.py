"""`tvclin fly`: one flight in one wind, with what the linear theory says of it beside it."""

from typing import Annotated

import typer

from tvclin.cli.flight_cases import REPORT, Flying, flight_case, fly_nonlinear
from tvclin.cli.fly_linear import LinearCase, fly_linear
from tvclin.cli.fly_shown import Shown
from tvclin.cli.gains import GainOptions, LoopOptions
from tvclin.cli.inputs import case_of, chosen, note_left_out, only_with
from tvclin.cli.options import (
    AsJson,
    Csv,
    Plane,
    Plot,
    Points,
    RateLimitDeg,
    Rigid,
    SampleRate,
    Source,
    Until,
    grouped,
)
from tvclin.cli.progress import waiting
from tvclin.cli.wind import WindOptions

_LONGEST = 20.0


@grouped
def fly(
    vehicle: Source = "configuration-i",
    blows: WindOptions = WindOptions(),
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
    rate_limit_deg: RateLimitDeg = None,
    sample_rate: SampleRate = None,
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
    plane: Plane = None,
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
    from dataclasses import replace

    import numpy as np

    from tvclin.answers.study_file.read import vehicle_source
    from tvclin.base.errors import one_of, within
    from tvclin.control.laws.registry import AUTOPILOT, LAWS
    from tvclin.flights.condition import load_flight_condition
    from tvclin.flights.engines import ENGINES
    from tvclin.vehicle.linear_vehicle import whole_vehicle

    if engine is not None:
        one_of("--engine", engine, (*ENGINES, "linear"))
    one_of("--law", law or REPORT, [REPORT, *LAWS])
    within("--until", until, 1e-3, _LONGEST)
    within("--points", points, 2, 1_000_000)
    case = case_of(
        vehicle,
        *(gains.over, loop.over),
        rigid=rigid,
        plane=plane,
        limit_deg=limit_deg,
        rate_limit_deg=rate_limit_deg,
        sample_rate=sample_rate,
    )
    loaded = whole_vehicle(case.vehicle, "a flight")
    linear = engine == "linear" or (
        engine is None and loaded.structure is not None and not along_trajectory
    )
    law = law or (AUTOPILOT if linear else REPORT)
    if law != AUTOPILOT:
        only_with(f"--law {AUTOPILOT}", **vars(gains))
    if law == REPORT:
        dead_band = chosen(dead_band, case.dead_band)
    aside = ["fly without --law autopilot"] * (law != AUTOPILOT)
    note_left_out(case, "fly", *aside, *["fly --engine planar"] * (not linear))
    name = blows.name(case)
    case = (blows.in_flight if along_trajectory else blows.over)(case, vehicle)
    wind = case.history
    span, shown = (until * float(wind.end - wind.onset), points), Shown(csv, plot, as_json)
    flying = name, law, dead_band
    if linear:
        only_with("--engine planar or sixdof", along_trajectory=along_trajectory)
        with waiting("flying"):
            times = float(wind.onset) + np.linspace(0.0, *span)
            found = fly_linear(LinearCase(case, *flying), boundary, times)
    else:
        only_with(
            "--engine linear",
            **vars(loop),
            rigid=rigid and engine is not None,
            sample_rate=sample_rate,
            rate_limit_deg=rate_limit_deg,
        )
        condition = load_flight_condition(vehicle_source(vehicle)) if along_trajectory else None
        one = flight_case(
            Flying(replace(case, model=""), *flying), engine or "planar", condition, span[0]
        )
        with waiting("flying"):
            found = fly_nonlinear(one, boundary, *span)
    if not found.show(shown):
        raise typer.Exit(1)
