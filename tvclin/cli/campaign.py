"""`tvclin campaign`: many dispersed cases, run, continued, shown and replayed."""

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, replace
from math import radians
from pathlib import Path
from typing import Annotated, Any

import typer

from tvclin.base.errors import InputError, number, positive
from tvclin.base.files import called, write_new
from tvclin.cli.inputs import note_left_out
from tvclin.cli.options import GROUP, SIGN, AsJson, Given, asked, grouped
from tvclin.cli.output import answer, print_tables, say
from tvclin.cli.progress import bar
from tvclin.cli.settings import settable
from tvclin.ensembles.campaign.chunk_runner import (
    cluster,
    damaged,
    open_campaign,
    processes,
    resume_campaign,
    run_campaign,
)
from tvclin.ensembles.campaign.folder import read_manifest
from tvclin.ensembles.campaign.results import CampaignResults
from tvclin.ensembles.campaign.summary import CampaignSummary
from tvclin.ensembles.dispersions import DEFAULT_DISPERSIONS
from tvclin.studyfile.campaign_file import load_campaign, template

campaign = typer.Typer(
    no_args_is_help=True,
    help="Many dispersed cases of one vehicle: how much deflection covers them?",
    epilog="First steps: tvclin campaign init my.toml | tvclin campaign run my.toml -o results",
)

Folder = Annotated[Path, typer.Argument(help="The folder of the campaign.")]
Output = Annotated[
    str | None, typer.Option("--output", help="Output to show. Without it: the first.")
]


@dataclass(frozen=True)
class WorkOptions:
    """Options of the workers and of the shard computed; `grouped` gives them to a command."""

    workers: int | None = asked("Number of worker processes. Without it: none but this one.")
    scheduler: str | None = asked("A Dask scheduler to run on, such as tcp://10.0.0.1:8786.")
    shard: str | None = asked("Compute part i of n of the chunks, i/n; for job arrays.")

    @contextmanager
    def told(self, folder: Path) -> Iterator[dict[str, Any]]:
        """Yield the arguments of a run into a folder; on an interrupt print how to resume."""
        try:
            with self._executor() as executor, bar("cases") as progress:
                yield {"executor": executor, "shard": self.shard, "progress": progress}
        except KeyboardInterrupt:
            name = called(folder)
            said = f"Stopped; finished chunks are kept. Go on with: tvclin campaign resume {name}"
            say(said, err=True)
            raise typer.Exit(130) from None

    def _executor(self) -> AbstractContextManager[Executor | None]:
        if self.workers is not None and self.scheduler is not None:
            raise InputError("give --workers or --scheduler, not both")
        if self.scheduler is not None:
            return cluster(self.scheduler)
        return nullcontext() if self.workers is None else processes(self.workers)


@campaign.command()
def init(
    file: Annotated[Path, typer.Argument(help="The campaign file to write, such as my.toml.")],
) -> None:
    """Write a commented campaign file to fill in."""
    write_new(file, template())
    name = called(file)
    say(f"Wrote {name}. Change what differs, then: tvclin campaign run {name} -o results")


@campaign.command()
@settable
@grouped
def run(
    campaign_file: Annotated[
        str, typer.Argument(metavar="FILE", help="The campaign file (see: tvclin campaign init).")
    ],
    folder: Annotated[Path, typer.Option("-o", "--folder", help="Folder for the results.")],
    work: WorkOptions = GROUP,
    until_converged: float | None = asked(
        "Stop when both bounds lie within this percentage of the answer."
    ),
    sign: Given = SIGN,
) -> None:
    """Run a campaign; in a folder where it has begun already, continue it.

    Exit code 0: done; 2: bad input, or stopped by what one sentence says.
    """
    plan = load_campaign(campaign_file)
    note_left_out(plan, "campaign")
    if plan.dispersions == DEFAULT_DISPERSIONS:
        say(f"Note: these dispersions are assumed: {plan.dispersions.words}.", err=True)
    if until_converged is not None:
        plan = replace(plan, until=until_converged / 100.0)
    plan = sign.over(plan)
    with work.told(folder) as arguments:
        results = run_campaign(plan, folder, **arguments)
    _print_done(results)


@campaign.command()
@grouped
def resume(folder: Folder, work: WorkOptions = GROUP) -> None:
    """Continue a campaign; chunks that are damaged or of another one are named and computed again.

    Exit code 0: done; 2: bad input, or stopped by what one sentence says.
    """
    for said in damaged(folder, read_manifest(folder)).values():
        say(f"Warning: {said}", err=True)
    with work.told(folder) as arguments:
        results = resume_campaign(folder, **arguments)
    _print_done(results)


@campaign.command()
def show(
    folder: Folder,
    output: Output = None,
    limit_deg: float | None = asked(
        "Also print how probable it is that this limit, in deg, is sufficient."
    ),
    probability: float | None = asked("Fraction of all flights to be covered, below 1."),
    confidence: float | None = asked("Confidence of every bound, below 1."),
    as_json: AsJson = False,
) -> None:
    """Print what a campaign has found so far.

    Exit code 0: answered; 2: bad input.
    """
    limit = (
        None if limit_deg is None else radians(number("--limit-deg", limit_deg, positive, "deg"))
    )
    results = open_campaign(folder)
    summary = CampaignSummary.of(results, output, limit, probability, confidence)
    answer(as_json, lambda: summary, lambda: print_tables(*summary.tables()))


@campaign.command()
def replay(
    folder: Folder,
    case: Annotated[int, typer.Argument(help="The number of the case.")],
    as_json: AsJson = False,
) -> None:
    """Compute one case again and print it in full, with its exact response.

    The response is that on its boundary: trim until the dead band is left, then the limit held. A
    case that is lost has the limit of the campaign in place of what it needs.

    Exit code 0: answered; 2: bad input.
    """
    replayed = open_campaign(folder).replay(case)
    answer(as_json, lambda: replayed, lambda: print_tables(*replayed.tables()))


def _print_done(results: CampaignResults) -> None:
    of = f"{results.cases} of {results.campaign.cases} cases are done"
    convergence = "; the answer has converged" if results.converged else ""
    say(f"{of}{convergence}. Show them with: tvclin campaign show {called(results.folder)}")
