"""The commands together, and what becomes of a bad input: one sentence and exit code 2.

Only typer is imported at the top of this room; a command loads what it needs when it runs, so
that ``tvclin --help`` answers at once.
"""

import warnings
from collections.abc import Callable
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from tvclin.cli.autopilot import autopilot
from tvclin.cli.boundary import boundary
from tvclin.cli.campaign import campaign
from tvclin.cli.doctor import doctor
from tvclin.cli.explore import explore
from tvclin.cli.fly import fly
from tvclin.cli.laws import laws
from tvclin.cli.margins import margins
from tvclin.cli.optimum import optimum
from tvclin.cli.poles import poles
from tvclin.cli.report import report
from tvclin.cli.reproduce import reproduce
from tvclin.cli.respond import respond
from tvclin.cli.size import size
from tvclin.cli.study import study
from tvclin.cli.vehicles import init, vehicles


class Commands(TyperGroup):
    """The group of commands, which turns bad input into one sentence."""

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("always", UserWarning)
                said: set[str] = set()
                warnings.showwarning = lambda message, *_, **__: _say_once(str(message), said)
                return super().invoke(ctx)
        except ValueError as error:
            from tvclin.errors import InputError

            if not isinstance(error, InputError):
                raise
            typer.echo(f"Error: {error}", err=True)
            raise typer.Exit(2) from None


app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="How much thrust-vector deflection must this booster have to survive this wind?",
    epilog="First: tvclin study configuration-i | tvclin init my.toml | tvclin explore",
)
_PANELS: dict[str, tuple[Callable[..., None], ...]] = {
    "Start here": (study, init, vehicles, report, explore),
    "Theory": (boundary, optimum, respond, poles, reproduce),
    "Control": (autopilot, margins, laws),
    "Flights": (size, fly),
    "This installation": (doctor,),
}
for panel, commands in _PANELS.items():
    for command in commands:
        app.command(rich_help_panel=panel)(command)
app.add_typer(campaign, name="campaign", rich_help_panel="Flights")


def _say_once(message: str, said: set[str]) -> None:
    if message not in said:
        typer.echo(f"Warning: {message}", err=True)
    said.add(message)


def _version(wanted: bool) -> None:
    if wanted:
        from tvclin import __version__

        typer.echo(f"tvclin {__version__}")
        raise typer.Exit


@app.callback()
def _top(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    del version  # its callback has done the work


def main() -> None:
    """Run the command line."""
    app(prog_name="tvclin")
