"""`tvclin optimum`: the least peak deflection with which a wind can be survived (appendix C)."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tvclin.cli.inputs import case_of
from tvclin.cli.options import (
    AsJson,
    Csv,
    Model,
    Plane,
    Plot,
    RateLimitDeg,
    Source,
    grouped,
)
from tvclin.cli.output import print_tables, say
from tvclin.cli.wind import WindOptions, wind_words

if TYPE_CHECKING:
    from tvclin.linear.plant import Plant
    from tvclin.winds.histories import History


@grouped
def optimum(
    vehicle: Source = "configuration-i",
    blows: WindOptions = WindOptions(),
    start: Annotated[
        float | None,
        typer.Option(
            help="Start of the control, in s; negative: before the wind.",
            show_default="the onset of the wind",
        ),
    ] = None,
    horizon: Annotated[
        float | None, typer.Option(help="Time after which the deflection must be zero again, in s.")
    ] = None,
    rate_limit_deg: RateLimitDeg = None,
    model: Model = None,
    plane: Plane = None,
    csv: Csv = None,
    as_json: AsJson = False,
    plot: Plot = None,
) -> None:
    """Print the least peak deflection that survives a wind known beforehand.

    Exit code 0: found; 1: only a lower bound was found; 2: bad input.
    """
    from tvclin.answers.optimum import KnownWind
    from tvclin.base.documents import picked
    from tvclin.boundary.optimum.minimum_peak import NOT_CONVERGED
    from tvclin.cli.output import print_json

    case = case_of(
        vehicle,
        blows=blows.over,
        told=("optimum",),
        model=model,
        plane=plane,
        rate_limit_deg=rate_limit_deg,
    )
    history, plant = case.history, case.plant.rigid
    start = float(history.onset) if start is None else start
    found = KnownWind.of(plant, history, start, horizon, case.nozzle.rate_limit)
    name = blows.name(case)
    title = f"{case.vehicle.name or vehicle}, {plant.model}: {wind_words(name, case)}"
    if csv is not None or plot is not None:
        _write(plant, found.deflection, history, title, csv, plot)
    if as_json:
        wind = {"name": name, **picked(history, "peak_deg onset_s end_s")}
        head = {"vehicle": case.vehicle.name, "model": plant.model, "wind": wind}
        print_json(head | {"plane": case.plane} | found.as_dict())
    else:
        print_tables(found.table(title))
    if found.best.status == NOT_CONVERGED:
        say("Error: the optimum was not reached; only the lower bound is proved", err=True)
        raise typer.Exit(1)


def _write(
    plant: "Plant",
    deflection: "History",
    wind: "History",
    title: str,
    csv: Path | None,
    plot: Path | None,
) -> None:
    import numpy as np

    from tvclin.base.files import write_text
    from tvclin.linear.response import attitude_responses
    from tvclin.plots import response_chart, response_curves, save_figure

    end = 3.0 * float(wind.end)
    times = np.linspace(min(0.0, float(deflection.onset), float(wind.onset)), end, 601)
    response = attitude_responses(plant, deflection, wind, times)
    curves = response_curves(response, deflection, wind, "optimum", title)
    if csv is not None:
        write_text(csv, curves.csv())
    if plot is not None:
        save_figure(response_chart(curves, f"Minimum-peak control\n{title}"), plot)
