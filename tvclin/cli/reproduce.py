"""`tvclin reproduce`: the report's figures and their numbers, in a directory."""

from pathlib import Path

import typer

from tvclin.cli.options import asked
from tvclin.cli.output import bar, say


def reproduce(
    output: str = asked(
        "Directory for the files; made if it is missing.", "reproduced", metavar="DIRECTORY"
    ),
) -> None:
    """Write the report's figures (PNG) and their numbers (CSV); say where they differ from print.

    Figures 6 to 11 also show flights, so it takes a minute or two.
    """
    from tvclin.base.errors import InputError, install
    from tvclin.base.files import called
    from tvclin.base.lines import plural
    from tvclin.plots.boundaries import chosen_engine
    from tvclin.show.reproduce import DIFFERENCES
    from tvclin.show.reproduce import reproduce as write_everything

    if not output.strip():
        raise InputError("--output must name a directory; got an empty name")
    with bar("figures") as progress:
        written = write_everything(Path(output), progress)
    for path in written:
        typer.echo(called(path))
    if chosen_engine(None) == "planar":
        say(
            "Figures 6 to 11 show planar flights alone: those with six degrees of freedom need"
            f" JSBSim, {install('sixdof')}."
        )
    files = plural(len(written), "file")
    say(f"Wrote {files} into {called(output)}. Where they differ from the print:")
    for figure, words in DIFFERENCES.items():
        say(f"{figure}: {words}")
