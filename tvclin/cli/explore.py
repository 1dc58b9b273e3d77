"""`tvclin explore`: a notebook in which everything is moved by hand."""

from pathlib import Path
from typing import Annotated

import typer

from tvclin.cli.options import VEHICLE_HELP, asked, switch
from tvclin.cli.output import say


def explore(
    options: Annotated[
        list[str] | None,
        typer.Argument(metavar="[-- OPTIONS]", help="Options of JupyterLab, such as --allow-root."),
    ] = None,
    vehicle: str = asked(VEHICLE_HELP, "configuration-i"),
    no_browser: bool = switch("--no-browser", "Start JupyterLab and print its address only."),
) -> None:
    """Write explore-VEHICLE.ipynb, unless it is there, and open and run it in JupyterLab.

    The panel in it moves vehicle, wind, limit, law and gains by hand. What it leaves out (gusts,
    both planes, filters) it names; a study file, which it writes, has room for that.

    JupyterLab ends with "End" in the panel, with Ctrl-C here, and some minutes after its last page
    was closed (not with --no-browser).

    Exit code 0: JupyterLab was closed; 2: bad input, or the extra notebook is missing.
    """
    from importlib.util import find_spec

    from tvclin.base.errors import InputError, missing
    from tvclin.base.files import exists, write_text
    from tvclin.show.explorer.lab import open_notebook
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
        say(f"Opening {path} as it is.")
    else:
        write_text(path, notebook_text(vehicle))
        say(f"Wrote {path}.")
    try:
        open_notebook(path, [*["--no-browser"] * no_browser, *(options or ())])
    except SystemExit as ended:
        if ended.code:
            raise InputError(f"JupyterLab ended with exit code {ended.code}, see above") from None
