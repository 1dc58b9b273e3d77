"""`tvclin fly`: one flight in one wind, with what the linear theory says of it beside it."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tvclin.cli.flight_cases import LAWS, FlightCase, flight_case, flight_wind
from tvclin.cli.fly_linear import LinearCase, Steps, fly_linear
from tvclin.cli.fly_winds import Window, Winds, WindsTime, sounding_wind
from tvclin.cli.gains import GainOptions, takes_gains
from tvclin.cli.inputs import load_plant, note_structure, only_with, peak_angle
from tvclin.cli.options import (
    AsJson,
    AzimuthDeg,
    Duration,
    PeakDeg,
    PeakSpeed,
    Plane,
    Plot,
    Points,
    Rigid,
    Until,
    Vehicle,
    Wind,
)
from tvclin.cli.progress import waiting

if TYPE_CHECKING:
    from tvclin.flights.beside import FlightBeside
    from tvclin.flights.flown_boundary import FlownBoundary

_LONGEST = 20.0
_TOLERANCE, _HIGHEST = 5e-4, 4.0
"""Of --boundary, over the largest trim deflection."""
_ENGINES = {
    "planar": "the report's nonlinear equations in one plane",
    "sixdof": "JSBSim, six degrees of freedom, steps of 0.01 s",
}


@takes_gains
def fly(
    vehicle: Vehicle = "configuration-i",
    wind: Wind = "triangular",
    duration: Duration = 7.5,
    peak_deg: PeakDeg = None,
    peak_speed: PeakSpeed = None,
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
            help="Control law: report, trim, dead-band, saturated (the gains below), half-relief or"
            " recoverable.",
            show_default="saturated for --engine linear, else report",
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
    rigid: Rigid = False,
    along_trajectory: Annotated[
        bool,
        typer.Option(
            "--along-trajectory", help="Let mass, speed and dynamic pressure change in flight."
        ),
    ] = False,
    boundary: Annotated[
        bool, typer.Option("--boundary", help="Also find the least limit that survives, by flying.")
    ] = False,
    plane: Plane = "pitch",
    until: Until = 2.0,
    points: Points = 401,
    csv: Annotated[
        Path | None, typer.Option(help="Also write the flight into this CSV file.")
    ] = None,
    as_json: AsJson = False,
    plot: Plot = None,
) -> None:
    """Fly a vehicle through a wind with a law, beside what the linear theory predicts.

    A vehicle file with bending, slosh, engine inertia or sensor lags makes a flexible vehicle: that
    is flown with a sampled law, beside the rigid one. --rigid leaves all that out.

    Exit code 0: survived; 1: not survived; 2: bad input.
    """
    from tvclin.base.errors import one_of, positive, within
    from tvclin.flights.condition import load_flight_condition
    from tvclin.vehicle.linear_vehicle import load_any_vehicle, whole_vehicle

    if engine is not None:
        one_of("--engine", engine, (*_ENGINES, "linear"))
    one_of("--law", law or "report", ["report", *LAWS])
    positive("--duration", duration, "s")
    within("--until", until, 1e-3, _LONGEST)
    within("--points", points, 2, 1_000_000)
    loaded = whole_vehicle(load_any_vehicle(vehicle), "a flight")
    _, plant, frame = load_plant(vehicle, "drift-exact", plane, rigid)
    if winds is None:
        only_with(
            "a sounding, --winds", azimuth_deg=azimuth_deg, window=window, winds_time=winds_time
        )
        peak = peak_angle(loaded, plane, peak_deg, peak_speed)
        gust = flight_wind(loaded, wind, duration, peak, along_trajectory)
    else:
        only_with(
            "a pulse in place of --winds: a sounding has its own peak",
            peak_deg=peak_deg,
            peak_speed=peak_speed,
        )
        asked_of = winds, winds_time, azimuth_deg, window, plane, along_trajectory
        gust, wind = sounding_wind(vehicle, loaded, *asked_of), winds.name
        duration = float(gust.end - gust.onset)
    span, shown = (until * duration, points), Shown(csv, plot, as_json)
    if engine == "linear" or (engine is None and plant is not frame and not along_trajectory):
        only_with("--engine planar or sixdof", along_trajectory=along_trajectory)
        steps = Steps(gains, sample_rate, rate_limit_deg)
        case = LinearCase(
            loaded, plant, frame, plane, wind, gust, law or "saturated", dead_band, steps
        )
        survived = _by_steps(case, limit_deg, boundary, span, shown)
    else:
        only_with(
            "--engine linear",
            **gains.given,
            sample_rate=sample_rate,
            rate_limit_deg=rate_limit_deg,
        )
        note_structure(loaded, getattr(plant, "structure", None), plane)
        condition = load_flight_condition(vehicle) if along_trajectory else None
        asked = (law or "report", dead_band, limit_deg)
        one = flight_case(loaded, wind, gust, engine or "planar", plane, *asked, condition, span[0])
        survived = _beside_theory(one, boundary, span, shown)
    if not survived:
        raise typer.Exit(1)


@dataclass(frozen=True)
class Shown:
    """Where a flight goes: files, and whether JSON is printed."""

    csv: Path | None
    plot: Path | None
    as_json: bool


def _by_steps(
    case: LinearCase,
    limit_deg: float | None,
    boundary: bool,
    span: tuple[float, int],
    shown: Shown,
) -> bool:
    """Fly a law in steps, show it, and return whether it survived."""
    import numpy as np

    from tvclin.cli.output import print_json

    with waiting("flying"):
        found = fly_linear(case, limit_deg, boundary, np.linspace(0.0, *span))
    _write(found.flight, case.title, found.limit, "linear", shown, "rigid")
    if shown.as_json:
        print_json(found.document())
    else:
        found.print()
    return found.flight.survived


def _beside_theory(case: FlightCase, boundary: bool, span: tuple[float, int], shown: Shown) -> bool:
    """Fly beside the linear theory, show it, and return whether it survived."""
    from tvclin.cli.output import print_json

    with waiting("flying"):
        flight = _flown(case, *span)
        found = _flown_boundary(case) if boundary else None
    _write(flight, case.title, case.limit, case.engine, shown)
    if shown.as_json:
        print_json(_document(flight, case, found))
    else:
        _print(flight, case, found)
    return flight.survived


def _flown(case: FlightCase, length: float, points: int) -> "FlightBeside":
    import numpy as np

    from tvclin.flights.beside import fly_beside

    start = float(case.wind.onset)
    return fly_beside(
        case.vehicle,
        case.control,
        case.wind,
        np.linspace(start, start + length, points),
        deflection_limit=case.limit,
        boundary=case.boundary,
        **case.options,
    )


def _flown_boundary(case: FlightCase) -> "FlownBoundary":
    from tvclin.flights.control import ReportControl
    from tvclin.flights.flown_boundary import flown_boundary

    chosen: dict[str, Any] = {"law": case.control}
    if isinstance(case.control, ReportControl):
        chosen = {"dead_band": case.control.dead_band}
    return flown_boundary(
        case.vehicle,
        case.wind,
        frozen=case.condition is None,
        tolerance=_TOLERANCE,
        highest=_HIGHEST,
        **chosen,
        **case.options,
    )


def _write(
    flight: "FlightBeside",
    title: str,
    limit: float,
    engine: str,
    shown: Shown,
    beside: str = "linear",
) -> None:
    import numpy as np

    from tvclin.base.files import write_text
    from tvclin.plots import flight_chart, flight_curves, save_figure

    if shown.csv is None and shown.plot is None:
        return
    said = f"{title}, limit {np.degrees(limit):.4f} deg, {engine}"
    numbers = flight_curves(flight, "fly", said.replace("\n", ", "), beside)
    if shown.csv is not None:
        write_text(shown.csv, numbers.csv())
    if shown.plot is not None:
        save_figure(flight_chart(numbers, said, float(flight.wind.end)), shown.plot)


def _peaks(flight: "FlightBeside") -> dict[str, list[float]]:
    """The largest of each over the wind, flown and linear [deg]."""
    import numpy as np

    names = ("attitude", "deflection", "angle_of_attack")
    return {name: np.degrees(flight.peaks(name)).tolist() for name in names}


def _print(flight: "FlightBeside", case: FlightCase, found: "FlownBoundary | None") -> None:
    import numpy as np

    from tvclin.cli.output import print_table
    from tvclin.flights.beside import MODEL as LINEAR_MODEL

    limit, least = (float(np.degrees(angle)) for angle in (case.limit, case.boundary))
    typer.echo(case.title)
    typer.echo(f"flown: {_ENGINES[case.engine]}")
    typer.echo(case.assumed)
    typer.echo(f"linear: model {LINEAR_MODEL}, parameters frozen")
    rows = [
        [f"largest {name.replace('_', ' ')}", *_compared(*both)]
        for name, both in _peaks(flight).items()
    ]
    if found is not None:
        rows.append(["boundary", *_compared(abs(float(np.degrees(found.deflection))), least)])
    title = f"Limit {limit:.4f} deg, {limit / least:.4g} times the linear boundary"
    print_table(title, ["over the wind, in deg", "flown", "linear", "difference"], rows)
    words = {True: "SURVIVED", False: "NOT SURVIVED"}
    typer.echo(f"Flown: {words[flight.survived]}. Linear theory: {words[flight.predicted]}.")
    if case.limit < case.minimum and (flight.survived or flight.predicted):
        typer.echo(
            f"Note: {np.degrees(case.minimum):.4f} deg is the least of all by linear theory; with"
            "\nless a mode goes on growing, more slowly than this flight shows."
        )
    if np.isfinite(flight.let_go[0]):
        typer.echo(
            f"The limit is let go at t = {flight.let_go[0]:.4g} s, as the attitude is back at"
            "\nzero or beyond; the flight, and what is largest in it, is shown until then."
        )


def _compared(flown: float, linear: float) -> list[str]:
    return [f"{flown:.4f}", f"{linear:.4f}", f"{flown - linear:+.4f}"]


def _document(
    flight: "FlightBeside", case: FlightCase, found: "FlownBoundary | None"
) -> dict[str, Any]:
    import numpy as np

    from tvclin.flights.beside import MODEL as LINEAR_MODEL

    deg = np.degrees
    return {
        "vehicle": case.vehicle.name,
        "engine": case.engine,
        "plane": case.plane,
        "law": case.law,
        "dead_band": case.dead_band,
        "along_trajectory": case.condition is not None,
        "linear_model": LINEAR_MODEL,
        "wind": {
            "shape": case.shape,
            "peak_deg": deg(case.wind.peak),
            "onset_s": case.wind.onset,
            "end_s": case.wind.end,
        },
        "limit_deg": deg(case.limit),
        "survived": flight.survived,
        "predicted": flight.predicted,
        "let_go_s": dict(zip(("flown", "linear"), flight.let_go, strict=True)),
        "peaks_over_the_wind_deg": {
            name: {"flown": flown, "linear": linear}
            for name, (flown, linear) in _peaks(flight).items()
        },
        "boundary_deg": {
            "linear": deg(case.boundary),
            "flown": None if found is None else deg(abs(found.deflection)),
        },
        "minimum_deg": deg(case.minimum),
    }
