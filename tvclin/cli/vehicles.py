"""`tvclin vehicles` and `tvclin init`."""

from pathlib import Path
from typing import Annotated

import typer

from tvclin.cli.options import AsJson


def vehicles(as_json: AsJson = False) -> None:
    """List the vehicles that come with the package."""
    import numpy as np

    from tvclin.cli.output import print_json, print_table
    from tvclin.coefficients import Coefficients
    from tvclin.vehicle_file import list_vehicles, load_vehicle

    rows, document = [], {}
    for key in list_vehicles():
        vehicle = load_vehicle(key)
        c = Coefficients.from_vehicle(vehicle)
        document[key] = {"name": vehicle.name, "beta_per_s": np.sqrt(c.mu_alpha), "B": c.B}
        rows.append([key, vehicle.name, f"{np.sqrt(c.mu_alpha):.4f}", f"{c.B:.4f}"])
    if as_json:
        print_json(document)
    else:
        print_table("Vehicles", ["key", "name", "beta [1/s]", "B [-]"], rows)


def init(
    file: Annotated[Path, typer.Argument(help="The vehicle file to write, such as my.toml.")],
) -> None:
    """Write a commented vehicle file to fill in."""
    from tvclin.errors import InputError
    from tvclin.files import write_text
    from tvclin.vehicle_file import template

    if file.exists() and not file.is_dir():
        raise InputError(f"{file} exists already; name another file or move it away")
    write_text(file, template())
    typer.echo(f"Wrote {file}. Fill in its numbers, then: tvclin study {file}")
