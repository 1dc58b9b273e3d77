"""The commands together, and what becomes of a bad input: one sentence and exit code 2.

Only typer is imported at the top of this file; a command loads what it needs when it runs, so
that ``tvclin --help`` answers at once.
"""

import gc
import warnings
from collections.abc import Callable
from functools import wraps
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from tvclin.cli.autopilot import autopilot
from tvclin.cli.availability import availability
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
        except (ValueError, ArithmeticError, MemoryError, OSError) as error:
            sentence = _sentence(error)
            if sentence is None:
                raise
            typer.echo(f"Error: {sentence}", err=True)
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
    "Flights": (size, availability, fly),
    "This installation": (doctor,),
}
_LIGHT = (init, explore, doctor)
"""Commands that compute nothing."""


def _strict(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command in which arithmetic that overflows is an error, and no number is none."""

    @wraps(command)
    def run(*given: Any, **options: Any) -> None:
        import numpy as np

        with np.errstate(over="raise", divide="raise", invalid="raise"):
            command(*given, **options)

    return run


for panel, commands in _PANELS.items():
    for command in commands:
        made = command if command in _LIGHT else _strict(command)
        app.command(rich_help_panel=panel)(made)
app.add_typer(campaign, name="campaign", rich_help_panel="Flights")


def _sentence(error: Exception) -> str | None:
    """What to say of an error; nothing of a fault of the package, and of a pipe that was closed."""
    from errno import EPIPE

    from tvclin.base.errors import InputError
    from tvclin.base.files import called, reason

    if isinstance(error, InputError):
        return str(error)
    if isinstance(error, OSError) and error.errno != EPIPE:
        return f"{called(error.filename or 'a file')} cannot be used: {reason(error)}"
    if isinstance(error, MemoryError):
        return f"there is not enough memory for what was asked: {error}"
    if isinstance(error, ArithmeticError) or type(error).__name__ == "LinAlgError":
        return (
            f"the numbers are beyond what floating-point arithmetic carries ({error}); bring"
            " vehicle and options nearer to those of configuration-i"
        )
    return None


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
    gc.set_threshold(100_000)  # to look for garbage again and again while modules load finds none
    app(prog_name="tvclin")
