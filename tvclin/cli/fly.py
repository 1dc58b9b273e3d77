"""`tvclin fly`: one flight in one wind, with what the linear theory says of it beside it."""

from typing import Annotated

import typer

from tvclin.cli.flight_cases import REPORT, Flying, flight_case, fly_nonlinear
from tvclin.cli.fly_linear import LinearCase, fly_linear
from tvclin.cli.fly_shown import Shown
from tvclin.cli.gains import GainOptions, LoopOptions, given
from tvclin.cli.inputs import note_left_out, only_with, vehicle_of
from tvclin.cli.options import (
    AsJson,
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
from tvclin.cli.wind import WindOptions

_LONGEST = 20.0


@grouped
def fly(
    vehicle: Vehicle = "configuration-i",
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
    loaded = whole_vehicle(vehicle_of(vehicle, rigid), "a flight")
    linear = engine == "linear" or (
        engine is None and loaded.structure is not None and not along_trajectory
    )
    chosen = law or (AUTOPILOT if linear else REPORT)
    only_with(f"--law {AUTOPILOT}", **({} if chosen == AUTOPILOT else given(gains)))
    nozzle = loop.nozzle(limit_deg, rate_limit_deg)
    design, in_flight = gains.asked(loop, sample_rate), along_trajectory
    case = blows.case(vehicle, loaded, None, plane, nozzle, design, in_flight=in_flight)
    wind = case.history
    span, shown = (until * float(wind.end - wind.onset), points), Shown(csv, plot, as_json)
    flying = blows.name, chosen, dead_band
    if linear:
        only_with("--engine planar or sixdof", along_trajectory=along_trajectory)
        with waiting("flying"):
            times = float(wind.onset) + np.linspace(0.0, *span)
            found = fly_linear(LinearCase(case, *flying), boundary, times)
    else:
        only_with(
            "--engine linear",
            **given(loop),
            rigid=rigid and engine is not None,
            sample_rate=sample_rate,
            rate_limit_deg=rate_limit_deg,
        )
        note_left_out("fly --engine planar", loaded, plane)
        condition = load_flight_condition(vehicle) if along_trajectory else None
        one = flight_case(Flying(case, *flying), engine or "planar", condition, span[0])
        with waiting("flying"):
            found = fly_nonlinear(one, boundary, *span)
    if not found.show(shown):
        raise typer.Exit(1)
