"""`tvclin report`: the whole answer as one page."""

from pathlib import Path
from typing import Annotated

import typer

from tvclin.cli.progress import waiting


def report(
    source: Annotated[
        str | None,
        typer.Argument(
            metavar="STUDY",
            help="A study file (see: tvclin init --study), a vehicle file or a vehicle of the"
            " package; the example of the package without it.",
        ),
    ] = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="The page to write.")] = Path(
        "report.html"
    ),
) -> None:
    """Write the whole answer of a study as one HTML page, which needs no network.

    Exit code 0: sufficient in the wind and over the flight, or no limit was given; 1: not
    sufficient; 2: bad input.
    """
    from tvclin.files import called, write_whole
    from tvclin.report import page_of
    from tvclin.study_file import example_plan, load_study

    plan = example_plan() if source is None else load_study(source)
    sufficient, doubts = None, plan.sizing.doubts if plan.sizing is not None else []

    # The page is made within, so that a place that cannot be written is told before the work.
    def write(target: str) -> None:
        nonlocal sufficient
        page, found = page_of(plan)
        Path(target).write_text(page, encoding="utf-8", newline="")
        sufficient = found.sufficient

    with waiting("making the page"):
        write_whole(output, write)
    said = {True: "sufficient", False: "NOT sufficient", None: "no limit was given"}
    typer.echo(f"Wrote {called(output)}: {said[sufficient]}.")
    for doubt in doubts:
        typer.echo(f"Note: {doubt}.")
    if sufficient is False:
        raise typer.Exit(1)
