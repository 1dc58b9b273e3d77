"""`tvclin study`: the main job, one vehicle in one wind."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

import typer

from tvclin.cli.inputs import CaseOptions, case_of, changed, only_with
from tvclin.cli.options import (
    STOPS_HELP,
    AsJson,
    LimitDeg,
    Model,
    Plane,
    Plot,
    Sign,
    Source,
    grouped,
)
from tvclin.cli.output import print_tables, say, say_lines, say_notes
from tvclin.cli.progress import bar, waiting
from tvclin.cli.wind import ShapedOptions

if TYPE_CHECKING:
    from tvclin.answers.findings import Findings
    from tvclin.answers.study_file.plan import StudyPlan


@dataclass(frozen=True)
class QuestionOptions:
    """What a study is held to; `grouped` gives the options."""

    dead_band: Annotated[
        float | None,
        typer.Option(
            help="Dead band K of the verdict, from 0 to 1; only 1 needs no forecast of the wind.",
            show_default="1",
        ),
    ] = None
    switch: Annotated[
        str | None,
        typer.Option(
            help="What is compared with the dead band, in the boundaries shown: trim (literal) or"
            " the wind (report).",
            show_default="literal",
        ),
    ] = None
    sign: Sign = None

    def over(self, plan: "StudyPlan") -> "StudyPlan":
        """Return a plan with what these options ask."""
        return changed(plan, **vars(self))


@dataclass(frozen=True)
class DisperseOptions:
    """What is dispersed; `grouped` gives the options."""

    disperse: Annotated[
        bool,
        typer.Option(
            "--disperse",
            help="Also find the deflection that covers dispersed vehicles and winds, with assumed"
            " dispersions where no study file gives them.",
        ),
    ] = False
    cases: Annotated[
        int | None, typer.Option(help="Number of cases of --disperse.", show_default="2000")
    ] = None
    seed: Annotated[int | None, typer.Option(help="Seed of --disperse.", show_default="0")] = None

    def over(self, plan: "StudyPlan") -> "StudyPlan":
        """Return a plan with the dispersions of its file, or with assumed ones."""
        if self.disperse and plan.dispersions is None:
            from tvclin.answers.campaign.dispersions import DEFAULT_DISPERSIONS

            plan = replace(plan, dispersions=DEFAULT_DISPERSIONS)
        if plan.dispersions is None:
            needed = "--disperse, or a study file with dispersions"
            only_with(needed, cases=self.cases, seed=self.seed)
        return changed(plan, cases=self.cases, seed=self.seed)


@grouped
def study(
    source: Source = "configuration-i",
    blows: ShapedOptions = ShapedOptions(),
    question: QuestionOptions = QuestionOptions(),
    limit_deg: LimitDeg = None,
    model: Model = None,
    plane: Plane = None,
    stop: Annotated[
        str | None,
        typer.Option(
            metavar="SHAPE",
            help=f"Judge both planes with one stop of the nozzle: {STOPS_HELP} The peak that the"
            " limit survives is then that of the wind's vector; without, that of its part in"
            " --plane. Needs --wind-direction-deg.",
        ),
    ] = None,
    drawn: DisperseOptions = DisperseOptions(),
    explain: Annotated[
        bool, typer.Option("--explain", help="Explain each symbol in one line.")
    ] = False,
    as_json: AsJson = False,
    plot: Plot = None,
) -> None:
    """Say how much deflection a booster needs in a wind, and whether its limit is enough.

    A study file may also ask about the whole flight, an archive of soundings, dispersed vehicles
    and an autopilot. Options count more than the file.

    Exit code 0: the answer to every question is yes, or no limit was given; 1: the answer to one is
    not yes; 2: bad input.
    """
    from tvclin.answers.findings import find
    from tvclin.answers.questions import all_yes, questioned
    from tvclin.base.errors import InputError

    own = CaseOptions(limit_deg, model=model, plane=plane, stop=stop).over
    plan = case_of(source, own, question.over, drawn.over, blows=blows.over, told=("study",))
    with bar("answers") as progress:
        found = find(questioned(plan), progress)
    if drawn.disperse and found.dispersed is None:
        raise InputError(found.reasons["dispersed"])
    if plot is not None:
        from tvclin.plots import save_figure, study_chart, study_planes_chart

        chart = study_planes_chart if found.study.in_both else study_chart
        with waiting("drawing"):
            save_figure(chart(found.study), plot)
    if as_json:
        _print_json(found)
    else:
        _print(found, source, explain)
    if not all_yes(found):
        raise typer.Exit(1)


def _print_json(found: "Findings") -> None:
    from tvclin.answers.questions import questions, sufficient
    from tvclin.cli.output import print_json

    extra = {} if found.dispersed is None else {"dispersed": found.dispersed}
    answers = {"questions": questions(found), "sufficient": sufficient(found)}
    print_json(found.study.as_dict() | extra | answers)


def _print(found: "Findings", source: str, explain: bool) -> None:
    """Print the vehicle, the boundaries and the verdict, and all else that was asked."""
    from tvclin.answers import study_tables as tables
    from tvclin.answers.asked_table import asked_table
    from tvclin.answers.questions import questions, sufficient
    from tvclin.vehicle.file import as_written

    s, d, each = found.study, found.dispersed, questions(found)
    print_tables(tables.vehicle(s, source, as_written(source)), tables.coefficients(s))
    print_tables(tables.poles(s), tables.boundaries(s))
    say_lines(tables.verdict(s))
    say(tables.LEGEND)
    say_notes(s.notes)
    if explain:
        from tvclin.answers.glossary import symbol_table

        say("")
        print_tables(symbol_table())
    if d is not None:
        say("")
        print_tables(*d.tables())
        say(d.spreads)
    if len(each) < 2:
        return
    say("")
    print_tables(asked_table(found))
    others = ", ".join(one.name for one in each if one.yes is not True)
    said = {
        True: "SUFFICIENT in all",
        False: f"NOT SUFFICIENT: {others}",
        None: "no limit was given" if s.limit is None else f"NOT KNOWN: {others}",
    }
    say(f"Verdict: {said[sufficient(found)]}")
    say_notes(() if found.availability is None else found.availability.notes)
