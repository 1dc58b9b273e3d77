"""`tvclin fly`: one flight in one wind, with what the linear theory says of it beside it."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tvclin.cli.flight_cases import FlightCase, flight_case, flight_wind
from tvclin.cli.inputs import load_rigid, peak_angle
from tvclin.cli.options import (
    AsJson,
    Duration,
    PeakDeg,
    PeakSpeed,
    Plane,
    Plot,
    Points,
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


def fly(
    vehicle: Vehicle = "configuration-i",
    wind: Wind = "triangular",
    duration: Duration = 7.5,
    peak_deg: PeakDeg = None,
    peak_speed: PeakSpeed = None,
    engine: Annotated[
        str, typer.Option(help="planar: nonlinear, one plane; sixdof: JSBSim, six degrees.")
    ] = "planar",
    law: Annotated[
        str, typer.Option(help="report, trim, dead-band, saturated, half-relief or recoverable.")
    ] = "report",
    dead_band: Annotated[
        float | None, typer.Option(help="Dead band K: of report (1) or of dead-band (0.5).")
    ] = None,
    limit_deg: Annotated[
        float | None,
        typer.Option(help="Deflection limit, in deg; without it 1.1 times the linear boundary."),
    ] = None,
    along_trajectory: Annotated[
        bool, typer.Option("--along-trajectory", help="Let mass, speed and pressure vary.")
    ] = False,
    boundary: Annotated[
        bool, typer.Option("--boundary", help="Also find the boundary by flying.")
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

    Exit code 0: survived; 1: not survived; 2: bad input.
    """
    from tvclin.base.errors import one_of, positive, within
    from tvclin.cli.output import print_json
    from tvclin.flights.condition import load_flight_condition
    from tvclin.flights.flown_boundary import ENGINES

    loaded = load_rigid(vehicle, plane)
    peak = peak_angle(loaded, plane, peak_deg, peak_speed)
    positive("--duration", duration, "s")
    within("--until", until, 1e-3, _LONGEST)
    within("--points", points, 2, 1_000_000)
    one_of("--engine", engine, ENGINES)
    condition = load_flight_condition(vehicle) if along_trajectory else None
    gust = flight_wind(loaded, wind, duration, peak, along_trajectory)
    length, asked = until * duration, (law, dead_band, limit_deg)
    case = flight_case(loaded, wind, gust, engine, plane, *asked, condition, length)
    with waiting("flying"):
        flight = _flown(case, length, points)
        found = _flown_boundary(case) if boundary else None
    if csv is not None or plot is not None:
        _write(flight, case, csv, plot)
    if as_json:
        print_json(_document(flight, case, found))
    else:
        _print(flight, case, found)
    if not flight.survived:
        raise typer.Exit(1)


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


def _write(flight: "FlightBeside", case: FlightCase, csv: Path | None, plot: Path | None) -> None:
    import numpy as np

    from tvclin.base.files import write_text
    from tvclin.plots import flight_chart, flight_curves, save_figure

    title = f"{case.title}, limit {np.degrees(case.limit):.4f} deg, {case.engine}"
    numbers = flight_curves(flight, "fly", title.replace("\n", ", "))
    if csv is not None:
        write_text(csv, numbers.csv())
    if plot is not None:
        save_figure(flight_chart(numbers, title, float(case.wind.end)), plot)


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
