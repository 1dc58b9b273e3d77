"""`tvclin poles`: where the poles are, and how strongly the inputs excite the unstable ones."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from tvclin.cli.inputs import case_of
from tvclin.cli.options import AsJson, Plane, Plot, Source

if TYPE_CHECKING:
    from tvclin.linear.plant import Plant


def poles(
    vehicle: Source = "configuration-i",
    model: Annotated[
        str,
        typer.Option(help="fixed-path, drift, drift-exact, drift-and-speed, or all."),
    ] = "all",
    plane: Plane = None,
    as_json: AsJson = False,
    plot: Plot = None,
) -> None:
    """Print the poles of the models, and the residues at the unstable ones."""
    from tvclin.base.errors import one_of
    from tvclin.cli.output import print_json, print_table
    from tvclin.linear.models import MODELS, models_of
    from tvclin.linear.plant import Plant

    one_of("model", model, [*MODELS, "all"])
    case = case_of(vehicle, told=("poles",), plane=plane)
    loaded, plane = case.vehicle, case.plane
    models = models_of(loaded) if model == "all" else [model]
    plants = {name: Plant.from_vehicle(loaded, name, plane) for name in models}
    found = {name: _poles(plant) for name, plant in plants.items()}
    if plot is not None:
        from tvclin.plots import pole_map, save_figure

        save_figure(pole_map(plants[models[0]].coefficients, models), plot)
    if as_json:
        print_json({"vehicle": loaded.name, "plane": plane, "models": found})
        return
    rows = []
    for name, entries in found.items():
        upper = [pole for pole in entries if pole["pole_per_s"].imag >= 0.0]
        first, *others = [[_shown(value) for value in pole.values()] for pole in upper]
        rows += [[name, *first], *(["", *other] for other in others)]
    headings = ["model", "pole [1/s]", "residue, deflection [1/s]", "wind [1/s]"]
    print_table(f"{loaded.name or vehicle}, {plane}: poles of the attitude", headings, rows)


def _poles(plant: "Plant") -> list[dict[str, Any]]:
    from tvclin.linear.modes import all_modes

    every = all_modes(plant)
    columns = (every.poles, every.deflection_residues, every.wind_residues)
    return [
        {"pole_per_s": p, "deflection_residue_per_s": d, "wind_residue_per_s": w}
        for p, d, w in zip(*(column.tolist() for column in columns), strict=True)
    ]


def _shown(value: complex) -> str:
    """A complex pole stands for its pair; the residue of its mate is the conjugate."""
    if value.imag == 0.0:
        return f"{value.real:+.6f}"
    return f"{value.real:+.5f}{value.imag:+.5f}j"
