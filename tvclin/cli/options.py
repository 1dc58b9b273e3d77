"""The options that several commands share, with their meaning said once."""

from pathlib import Path
from typing import Annotated

import typer

VEHICLE_HELP = "A vehicle of the package (see: tvclin vehicles) or a TOML file."

Vehicle = Annotated[str, typer.Argument(help=VEHICLE_HELP)]
Wind = Annotated[str, typer.Option(help="Shape of the wind: triangular or rectangular.")]
Duration = Annotated[float, typer.Option(help="Duration of the wind [s].")]
Plane = Annotated[str, typer.Option(help="Plane of the motion: pitch or yaw.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")]
Plot = Annotated[
    Path | None, typer.Option(help="Also draw a figure into this file (png, pdf, svg).")
]
