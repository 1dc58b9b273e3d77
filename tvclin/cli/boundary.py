"""`tvclin boundary`: the boundary limit over the duration of the wind."""

from typing import Annotated, Any

import numpy as np
import typer

from tvclin.base.errors import one_of, positive, within
from tvclin.base.quantities import NOMINAL
from tvclin.boundary.limit import OK, boundary_limit
from tvclin.boundary.open_loop import with_larger_requirements
from tvclin.cli.inputs import case_of, chosen, only_with
from tvclin.cli.options import MOTION, SHAPE, SOURCE_HELP, AsJson, At, Given, Plot, asked
from tvclin.cli.output import draw, print_json, print_tables, say_notes
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import Coefficients
from tvclin.winds.shaped import SHAPES

TAU_BETA = [0.5, 1.0, 2.0, 4.0, 6.0, 8.0, 12.0, 16.0, 20.0]
DEAD_BANDS = [1.0, 0.75, 0.5, 0.25, 0.0]


def boundary(
    vehicle: Annotated[
        str | None,
        typer.Argument(
            metavar="VEHICLE|STUDY",
            help=f"{SOURCE_HELP} Without one the flight path is held fixed.",
        ),
    ] = None,
    time: At = None,
    wind: str | None = SHAPE,
    tau_beta: list[float] | None = asked(
        "Duration of the wind times beta (with damping, times the pole); may be given"
        " several times."
    ),
    dead_band: list[float] | None = asked("Dead band K from 0 to 1; may be given several times."),
    motion: Given = MOTION,
    as_json: AsJson = False,
    plot: Plot = None,
) -> None:
    """Print boundary limits y_BR over tau*beta and the dead band, as in figure 2.

    A boundary limit is a ratio to static trim, at nominal dynamic pressure, and no verdict.
    """
    from tvclin import plots

    x = within("--tau-beta", positive("--tau-beta", tau_beta or TAU_BETA), 1e-6, 1e6)
    K = within("--dead-band", dead_band or DEAD_BANDS, 0.0, 1.0)
    name, plant, plane, file_shape = _subject(vehicle, time, motion)
    wind = chosen(wind, file_shape)
    shape: Any = SHAPES[one_of("--wind", wind, SHAPES)]
    # of one unit of peak: the boundary limit does not depend on it
    pulses = shape(peak=1.0, duration=x[:, None] / plant.coefficients.pole)
    limits = with_larger_requirements(plant, pulses, K, boundary_limit(plant, pulses, K))
    shown = None if vehicle is None else plant.coefficients
    axis = "tau*beta" if shown is None else f"tau*{shown.pole_symbol}"
    curve = np.linspace(0.05, max(float(x.max()), 1.0), 200)
    draw(plot, lambda: plots.boundary_chart(curve, K.tolist(), shown))
    if as_json:
        head = {"vehicle": name or None, "wind": wind, "model": plant.model, "plane": plane}
        results = {"dead_band": K, "limit": limits.limit, "status": limits.status.tolist()}
        print_json(head | {axis.replace("*", "_"): x} | results)
        return
    title = f"{name}, {plant.model}, {plane}" if vehicle else "Any vehicle, flight path fixed"
    caption = f"{title}: boundary limit y_BR {NOMINAL}, {wind} wind"
    print_tables(limits.table(caption, axis, x, K))
    say_notes(_notes(axis, x, K, limits.status))


def _subject(vehicle: str | None, time: float | None, motion: Given) -> tuple[str, Plant, str, str]:
    """Return name, plant, plane and wind shape of a file, or of a vehicle with beta = B = 1."""
    if vehicle is None:
        motion.only_with("a vehicle")
        only_with("a vehicle", at=time)
        plant = Plant(Coefficients.from_beta(beta=1.0, B=1.0), "fixed-path")
        return "", plant, "pitch", "triangular"
    case = case_of(vehicle, motion.over, time=time, told=("boundary",))
    return case.vehicle.name or vehicle, case.plant.rigid, case.plane, case.shape


def _notes(axis: str, x: Any, K: Any, status: Any) -> list[str]:
    """Return notes on irregular entries of the table, with their K and range of duration."""
    where: dict[tuple[str, str], list[str]] = {}
    for k, column in zip(K, status.T, strict=True):
        for said in dict.fromkeys(column[column != OK].tolist()):
            odd = x[column == said]
            span = f"{odd.min():g} to {odd.max():g}" if odd.size > 1 else f"{odd[0]:g}"
            where.setdefault((said, span), []).append(f"{k:g}")
    return [f"K = {', '.join(k)}, {axis} {span}: {said}" for (said, span), k in where.items()]
