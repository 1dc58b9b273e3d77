"""`tvclin optimum`: the least peak deflection with which a wind can be survived (appendix C)."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

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
from tvclin.cli.output import say
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
    from tvclin.boundary.optimum.minimum_peak import NOT_CONVERGED, optimum_deflection
    from tvclin.boundary.optimum.rate_limit import optimum_with_rate_limit
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
    best = optimum_deflection(plant, history, start, horizon)
    limited = None
    if case.nozzle.rate_limit is not None:
        limited = optimum_with_rate_limit(plant, history, case.nozzle.rate_limit, start, horizon)
    shown = best.deflection if limited is None else limited.deflection
    name = blows.name(case)
    title = f"{case.vehicle.name or vehicle}, {plant.model}: {wind_words(name, case)}"
    if csv is not None or plot is not None:
        _write(plant, shown, history, title, csv, plot)
    document = {"plane": case.plane, **_document(plant, history, best, limited)}
    if as_json:
        wind = {"name": name, **document.pop("wind")}
        print_json({"vehicle": case.vehicle.name, "model": plant.model, "wind": wind, **document})
    else:
        _print(title, document)
    if best.status == NOT_CONVERGED:
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


def _document(plant: "Plant", wind: "History", best: Any, limited: Any) -> dict[str, Any]:
    import numpy as np

    from tvclin.base.documents import picked
    from tvclin.boundary.limit import boundary_limit

    trim = abs(float(plant.coefficients.B * wind.peak))
    held = abs(float(boundary_limit(plant, wind, 0.0).deflection))
    return {
        "wind": picked(wind, "peak_deg onset_s end_s"),
        **picked(best, "peak_deg"),
        "part_of_trim": best.peak / trim if trim else None,
        "trim_deg": np.degrees(trim),
        "held_deg": np.degrees(held),
        "first_segment": _first_segment(plant, wind, best.deflection),
        **picked(best, "switch_times_s status"),
        "certificate": best.certificate.as_dict(),
        **({} if limited is None else {"with_rate_limit": limited.as_dict()}),
    }


def _first_segment(plant: "Plant", wind: "History", deflection: "History") -> str:
    import numpy as np

    if np.isinf(deflection.onset):
        return "none"
    first = np.sign(deflection(np.nextafter(deflection.onset, np.inf)))
    against = -np.sign(plant.coefficients.B * wind.peak)
    return "opposes the wind" if first == against else "goes with the wind"


def _print(title: str, found: dict[str, Any]) -> None:
    from tvclin.cli.output import limit_cell, print_pairs

    switches = ", ".join(f"{t:.4g} s" for t in found["switch_times_s"][:6])
    more = len(found["switch_times_s"]) - 6
    part = "" if found["part_of_trim"] is None else f" ({found['part_of_trim']:.4f} of trim)"
    rows = [
        ("least peak deflection", f"{found['peak_deg']:.4f} deg{part}"),
        ("first segment", found["first_segment"]),
        ("switches", (switches or "none") + (f" and {more} more" if more > 0 else "")),
        ("fast pole alone (K = 0)", limit_cell(found["held_deg"], unit="deg")),
        ("ideal trim", f"{found['trim_deg']:.4f} deg"),
        ("lower bound (dual)", f"{found['certificate']['dual_deg']:.4f} deg"),
        ("certificate", f"gap {found['certificate']['gap']:.1e}, {found['status']}"),
    ]
    limited = found.get("with_rate_limit")
    if limited is not None:
        rate, peak = limited["rate_deg_per_s"], limited["peak_deg"]
        rows.insert(1, (f"with {rate:.4g} deg/s", f"{peak:.4f} deg, {limited['status']}"))
    print_pairs(title, rows, columns=1)
