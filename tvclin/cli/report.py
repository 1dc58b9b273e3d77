"""`tvclin report`: the whole answer as one page; and `tvclin reproduce`: figures of the report."""

from pathlib import Path
from typing import Annotated

import typer

from tvclin.base.files import called, write_whole
from tvclin.base.lines import text
from tvclin.cli.inputs import note_omissions, only_with
from tvclin.cli.options import At, option, to_write
from tvclin.cli.output import bar, say
from tvclin.studyfile.findings import Findings
from tvclin.studyfile.questions import all_yes
from tvclin.studyfile.read import example_plan, load_study
from tvclin.studyfile.verdict import sentence


def report(
    source: Annotated[
        str | None,
        typer.Argument(
            metavar="STUDY",
            help="A study file (see: tvclin init --study), a vehicle file or a vehicle of the"
            " package, or a flight schedule with --at. Without it: the example of the package.",
        ),
    ] = None,
    time: At = None,
    output: Annotated[
        Path,
        typer.Option("-o", "--output", help="The page to write.", callback=to_write),
    ] = Path("report.html"),
) -> None:
    """Write all answers of tvclin study, with figures and assumptions, as one HTML page.

    The page needs no network, and its headline is the first line of tvclin study.

    Exit code 0: the answer to every question of the file is yes, or no limit was given; 1: the
    answer to one is not yes; 2: bad input.
    """
    from tvclin.kernels.choice import announce
    from tvclin.plots.boundaries import CURVES_SECONDS
    from tvclin.show.report.page import page_of

    if source is None:
        only_with("a flight schedule", at=time)
    plan = example_plan() if source is None else load_study(source, time)
    warnings = plan.sizing.warnings if plan.sizing is not None else []
    findings: list[Findings] = []

    # The page is made within, so that a place that cannot be written is refused before the work.
    def write(target: str) -> None:
        """Write the page into the file `target`, and keep its findings."""
        page, result = page_of(plan, progress, Path(source).name if source else "example")
        Path(target).write_text(page, encoding="utf-8", newline="")
        findings.append(result)

    announce(CURVES_SECONDS)  # estimated run time, which decides between compiled and plain code
    with bar("parts of the page", even=False) as progress:
        write_whole(output, write)
    say(f"Wrote {called(output)}. {text(sentence(findings[0]))}")
    for warning in warnings:
        say(f"Note: {warning}.")
    note_omissions(plan, "report")
    if not all_yes(findings[0]):
        raise typer.Exit(1)


def reproduce(
    output: str = option(
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
