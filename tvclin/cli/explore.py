"""`tvclin explore`: a notebook in which everything is moved by hand."""

from pathlib import Path
from typing import Annotated

import typer

from tvclin.cli.options import VEHICLE_HELP


def explore(
    vehicle: Annotated[str, typer.Option(help=VEHICLE_HELP)] = "configuration-i",
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Start JupyterLab and print its address only.")
    ] = False,
) -> None:
    """Write explore-VEHICLE.ipynb, unless it is there, and open it in JupyterLab.

    Exit code 0: JupyterLab was left; 2: bad input, or the extra notebook is missing.
    """
    import subprocess
    import sys
    from importlib.util import find_spec

    from tvclin.errors import InputError
    from tvclin.explorer.notebook import notebook_text
    from tvclin.files import write_text
    from tvclin.vehicle_file import load_vehicle

    load_vehicle(vehicle)
    for needed in ("jupyterlab", "ipywidgets", "ipykernel"):
        if find_spec(needed) is None:
            raise InputError(f"tvclin explore needs {needed}; install tvclin[notebook]")
    path = Path(f"explore-{Path(vehicle).stem}.ipynb")
    if path.exists():
        typer.echo(f"Opening {path} as it is.")
    else:
        write_text(path, notebook_text(vehicle))
        typer.echo(f"Wrote {path}.")
    lab = [sys.executable, "-m", "jupyterlab", str(path)]
    try:
        code = subprocess.run(lab + ["--no-browser"] * no_browser, check=False).returncode
    except KeyboardInterrupt:
        code = 0
    if code:
        raise InputError(f"JupyterLab could not be started, exit code {code}; see above")
