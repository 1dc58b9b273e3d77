"""`tvclin explore`: a notebook with a panel in which all values are changed by hand."""

from pathlib import Path
from typing import Annotated

import typer

from tvclin.cli.options import VEHICLE_HELP, At, option, switch
from tvclin.cli.output import say


def explore(
    options: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SOURCE] [-- OPTIONS]",
            help="A study file, a vehicle file, or the name of a vehicle (configuration-i if left"
            " out); then options of JupyterLab, such as --allow-root.",
        ),
    ] = None,
    vehicle: str | None = option(f"The same as SOURCE: {VEHICLE_HELP}"),
    time: At = None,
    no_browser: bool = switch("--no-browser", "Start JupyterLab and print its address only."),
) -> None:
    """Open a panel in JupyterLab that moves vehicle, wind, nozzle and autopilot by hand.

    It writes explore-SOURCE.ipynb, unless it is there, and runs it. The panel begins with the case
    of a study file, and writes what is set as one, for all other commands.

    JupyterLab ends with "End" in the panel, with Ctrl-C here, and some minutes after its last page
    was closed (not with --no-browser).

    Exit code 0: JupyterLab was closed; 2: bad input, or the extra notebook is missing.
    """
    from importlib.util import find_spec

    from tvclin.base.errors import InputError, missing
    from tvclin.base.files import exists, write_text
    from tvclin.requirement.case_requirement import pulse_of
    from tvclin.show.explorer.lab import notebook_text, open_notebook
    from tvclin.studyfile.read import load_study

    words = list(options or ())
    source = words.pop(0) if words and not words[0].startswith("-") else None
    if source is not None and vehicle is not None:
        raise InputError("give SOURCE or --vehicle, not both")
    source = source or vehicle or "configuration-i"
    pulse_of(load_study(source, time))  # raises where the wind is none that the panel can show
    for needed in ("jupyterlab", "ipywidgets", "ipykernel"):
        if find_spec(needed) is None:
            raise missing(f"tvclin explore needs {needed}", "notebook")
    path = Path(f"explore-{Path(source).stem}.ipynb")
    if exists(path):
        say(f"Opening {path} as it is.")
    else:
        write_text(path, notebook_text(source, time))
        say(f"Wrote {path}.")
    try:
        open_notebook(path, [*["--no-browser"] * no_browser, *words])
    except SystemExit as ended:
        if ended.code:
            raise InputError(f"JupyterLab ended with exit code {ended.code}, see above") from None
