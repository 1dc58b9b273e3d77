"""`tvclin explore`: a notebook in which everything is moved by hand."""

from pathlib import Path
from typing import Annotated

import typer

from tvclin.cli.options import VEHICLE_HELP


def explore(
    options: Annotated[
        list[str] | None,
        typer.Argument(metavar="[-- OPTIONS]", help="Options of JupyterLab, such as --allow-root."),
    ] = None,
    vehicle: Annotated[str, typer.Option(help=VEHICLE_HELP)] = "configuration-i",
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Start JupyterLab and print its address only.")
    ] = False,
) -> None:
    """Write explore-VEHICLE.ipynb, unless it is there, and open it in JupyterLab.

    Exit code 0: JupyterLab was left; 2: bad input, or the extra notebook is missing.
    """
    import sys
    from importlib.util import find_spec

    from tvclin.base.errors import InputError, missing
    from tvclin.base.files import exists, write_text
    from tvclin.show.explorer.notebook import notebook_text
    from tvclin.vehicle.file import load_vehicle

    if options and not options[0].startswith("-"):
        raise InputError(f"name the vehicle with --vehicle {options[0]}")
    load_vehicle(vehicle)
    for needed in ("jupyterlab", "ipywidgets", "ipykernel"):
        if find_spec(needed) is None:
            raise missing(f"tvclin explore needs {needed}", "notebook")
    path = Path(f"explore-{Path(vehicle).stem}.ipynb")
    if exists(path):
        typer.echo(f"Opening {path} as it is.")
    else:
        write_text(path, notebook_text(vehicle))
        typer.echo(f"Wrote {path}.")
    given = [*["--no-browser"] * no_browser, *(options or ())]
    code = _run([sys.executable, "-m", "jupyterlab", str(path), *given])
    if code:
        raise InputError(f"JupyterLab ended with exit code {code}, see above")


def _run(command: list[str]) -> int:
    import subprocess

    process = subprocess.Popen(command)
    while True:
        try:
            return process.wait()
        except KeyboardInterrupt:  # JupyterLab has had it too, and asks whether to stop
            continue
