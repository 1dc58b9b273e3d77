"""The group of all commands, and the handling of bad input: one sentence and exit code 2.

Only typer is imported at the top of this file; a command is loaded when it is called, with its
imports but those of figures.
"""

import gc
import os
import re
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import wraps
from importlib import import_module
from io import TextIOWrapper
from keyword import iskeyword
from pkgutil import get_data
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

_PANELS = {
    "Start here": ("study", "init", "vehicles", "report", "explore"),
    "Theory": ("boundary", "poles", "respond", "reproduce"),
    "Control": ("design", "margins", "fly"),
    "Whole flight": ("ascent", "nozzle", "availability"),
    "Many cases": ("disperse",),
    "This installation": ("import", "doctor"),
}
NAMES = {name: panel for panel, names in _PANELS.items() for name in names}
"""Panel of the help of each command, by name."""
_FILE_OF_COMMAND = {"init": "vehicles", "import": "flight_import", "reproduce": "report"}
"""File of a command that shares the file of another."""
_STRICT_HANDLERS = ("strict", "surrogateescape")
"""Error handlers of a stream that raise for a letter which its encoding lacks."""
_NUMBERS = {
    "number": "a number, such as 0.4",
    "float": "a number, such as 0.4",
    "integer": "a whole number, such as 100",
}
"""Values of an option in words, by the name of its type in the messages of typer."""
_CLOSED_PIPE = 141
"""Exit code of a command whose reader closed the pipe: 128 + SIGPIPE, as of other programs."""
_WITHOUT_ARITHMETIC = ("init", "explore", "doctor")
"""Commands that compute nothing."""


class _Late(Mapping[str, Any]):
    """The commands by name, each loaded when it is looked up."""

    def __iter__(self) -> Iterator[str]:
        """Yield the names of all commands."""
        return iter(NAMES)

    def __len__(self) -> int:
        """Return the number of commands."""
        return len(NAMES)

    def __getitem__(self, name: str) -> Any:
        """Return the command with a name, whose file is then loaded.

        It has the options of its groups and --set; overflow raises in it if it computes anything.
        """
        from tvclin.cli.options import grouped
        from tvclin.cli.settings import settable

        module = import_module(f"tvclin.cli.{_FILE_OF_COMMAND.get(name, name)}")
        command = getattr(module, f"{name}_" if iskeyword(name) else name)
        if not isinstance(command, typer.Typer):
            command = settable(grouped(command), name)
            command = command if name in _WITHOUT_ARITHMETIC else _strict(command)
        return _named(_registered(name, command))


def _registered(name: str, command: Any) -> Any:
    """Return the command of a function, or the group of an app, in the panel of its name."""
    app = typer.Typer()
    if isinstance(command, typer.Typer):
        app.add_typer(command, name=name, rich_help_panel=NAMES[name])
    else:
        app.command(name, rich_help_panel=NAMES[name])(command)
    return _unwrapped(typer.main.get_group(app).commands[name])


def _named(command: Any) -> Any:
    """Return a command, and those below it, whose messages name options, not arguments.

    The command itself is changed: its callback first refuses a key of --set beside its own option.
    """
    for below in getattr(command, "commands", {}).values():
        _named(below)
    run, options = command.callback, command.params

    @wraps(run)
    def call(*arguments: Any, **values: Any) -> Any:
        """Run a command, `run`; its `ValueError` names which of its `options` is at fault."""
        from tvclin.cli.settings import check_settings, faulty_key, keys_of_arguments, named

        try:
            check_settings(options, values)
            return run(*arguments, **values)
        except ValueError as error:
            keys = keys_of_arguments(options, values)
            raise named(faulty_key(error, values), options, values, keys) from None

    command.callback = None if run is None else call
    return command


def _listed(name: str) -> Any:
    """Return the command with a name for a list: its help is read from its file, not loaded.

    To load all commands takes 1.8 s, to parse their files 0.05 s, and this 0.01 s. The help is the
    docstring of a function, or the argument `help` of an app, up to its first quote; the returned
    command does nothing.
    """

    def command() -> None:
        """Do nothing; the help of the command that it stands for replaces this text."""

    text = get_data("tvclin.cli", f"{_FILE_OF_COMMAND.get(name, name)}.py") or b""
    pattern = rf'(?s)^(?:def {name}\(.*?"""|{name}_ = .*?help=")(.+?)"'
    match = re.search(pattern, text.decode(), re.M)
    command.__doc__ = match[1] if match else None
    return _registered(name, command)


def _unwrapped(command: Any) -> Any:
    """Return a command whose help has one line per paragraph, for the terminal to wrap.

    typer keeps the line ends of a docstring in every paragraph but the first.
    """
    paragraphs = (command.help or "").split("\n\n")
    command.help = "\n\n".join(" ".join(paragraph.split()) for paragraph in paragraphs)
    for below in getattr(command, "commands", {}).values():
        _unwrapped(below)
    return command


class Commands(TyperGroup):
    """The group of commands, which turns bad input into one sentence."""

    def __init__(self, **options: Any) -> None:
        """Make the group, whose commands are loaded when they are looked up."""
        super().__init__(**options)
        self.commands = _Late()  # type: ignore[assignment]  # nothing is ever added to it

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of all commands."""
        return list(NAMES)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command as the help and the completion list it."""
        return _listed(cmd_name) if cmd_name in NAMES else None

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return name, command and arguments of a command line, --set KEY VALUE as KEY=VALUE."""
        from tvclin.cli.settings import joined

        name, _, rest = super().resolve_command(ctx, args)
        return name, name and self.commands[name], joined(rest)  # None: no command was named

    def make_context(self, *arguments: Any, **options: Any) -> Any:
        """Read the command line; this prints help and version."""
        with _input_errors_as_messages():
            return super().make_context(*arguments, **options)

    def invoke(self, ctx: Any) -> Any:
        """Run a command, with its errors, warnings and last its notes as sentences on stderr."""
        from tvclin.base.files import separate_outputs
        from tvclin.base.package_warnings import pass_warnings
        from tvclin.cli.output import notes_last, say

        def tell(sentence: str) -> None:
            """Print a warning on stderr."""
            say(f"Warning: {sentence}", err=True)

        # `machine` warnings, of this computer and not of the case, are printed too
        sentences = pass_warnings(tell, machine=tell)
        with _input_errors_as_messages(ctx), sentences, notes_last(), separate_outputs():
            return super().invoke(ctx)


app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="How much thrust-vector deflection must this booster have to survive this wind?\n\n"
    "Exit codes: 0, the answer is yes, or no limit was given; 1, it is no or not known; 2, bad"
    " input, with one sentence on what to change. The help of each command says what its yes is.",
    epilog="First: tvclin study configuration-i | tvclin init my.toml | tvclin explore",
)


def _strict(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command in which overflow, division by zero and invalid arithmetic raise."""

    @wraps(command)
    def run(*arguments: Any, **options: Any) -> None:
        """Run the command; overflow, division by zero and invalid arithmetic raise."""
        import numpy as np

        from tvclin.kernels.choice import in_a_command

        with np.errstate(over="raise", divide="raise", invalid="raise"), in_a_command():
            command(*arguments, **options)

    return run


@contextmanager
def _input_errors_as_messages(context: Any = None) -> Iterator[None]:
    """Print the message of an input error, and exit with code 2; of a closed pipe, with 141.

    `context`: context of the group of commands, which knows the command that runs; None before.
    """
    try:
        yield
    except (SystemExit, BrokenPipeError) as error:  # rich exits with 1 on a closed pipe
        if not any(isinstance(e, BrokenPipeError) for e in (error, error.__context__)):
            raise
        # 1: the descriptor of stdout
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what is buffered goes nowhere
        raise typer.Exit(_CLOSED_PIPE) from None
    except Exception as error:
        message = _sentence(error, context)
        if message is None:
            raise
        from tvclin.cli.output import say

        say(f"Error: {message}", err=True)
        raise typer.Exit(2) from None


def _sentence(error: Exception, group: Any = None) -> str | None:
    """Return the message of an error; None for a fault of the package.

    `group`: context of the group of commands, None before it is read. Input, command line, files,
    memory and arithmetic are faults of others. Errors of click are told by the names of their
    classes, since click is not imported here.
    """
    from tvclin.base.errors import InputError
    from tvclin.base.files import called, reason

    if isinstance(error, InputError):
        return str(error)
    kinds = [kind.__name__ for kind in type(error).__mro__]
    if "UsageError" in kinds and kinds[0] != "NoArgsIsHelpError":
        return _usage(error, group)
    if isinstance(error, OSError):
        return f"{called(error.filename or 'a file')} cannot be used: {reason(error)}"
    if isinstance(error, MemoryError):
        return f"there is not enough memory for this question: {error}"
    if isinstance(error, ArithmeticError) or type(error).__name__ == "LinAlgError":
        return (
            f"floating-point arithmetic fails on these numbers ({error}); bring vehicle and options"
            " nearer to those of configuration-i"
        )
    return None


def _usage(error: Any, group: Any) -> str:
    """Return the message on a command line that cannot be read, with the help that explains it.

    `error`: usage error of click, such as an unknown option or a value of a wrong type. `group`:
    context of the group, whose command counts where the error does not know its own.
    """
    from tvclin.base.lines import listed

    context, option = error.ctx, getattr(error, "option_name", None) or ""
    path = " ".join(["tvclin", *context.command_path.split()[1:]]) if context else "tvclin"
    if context is None and group is not None and group.invoked_subcommand:
        path = f"tvclin {group.invoked_subcommand}"
    kind = type(error).__name__
    unknown = kind == "NoSuchOption"
    gain = _GAINS.get(option, option)
    if unknown and (message := _refused_option(context, path, gain)):
        return message.replace(f"takes no {gain}", f"takes no {option}")
    param = getattr(error, "param", None)  # of a wrong value
    if kind == "BadOptionUsage" and group is not None and group.invoked_subcommand in NAMES:
        taken = getattr(group.command.commands[group.invoked_subcommand], "params", ())
        param = next((item for item in taken if option in item.opts), None)  # of too few values
    if param is not None and param.nargs > 1:
        return f"{param.opts[0]} takes {param.nargs} values, {param.metavar}"
    if kind == "BadParameter" and param is not None:
        if valid := re.search(r"\bvalid (number|float|integer)\b", error.message):
            return f"{param.opts[0]} must be {_NUMBERS[valid[1]]}"
        return f"{param.opts[0]}: {error.message[:1].lower()}{error.message[1:].rstrip('.')}"
    if unknown and (close := [name for name in error.possibilities or () if name != "--set"]):
        return f"{path} takes no {option}: did you mean {listed(close, 'or')}?"
    words = f"no option {option}" if unknown else error.format_message().rstrip(".")
    words = f"{path}: {words[:1].lower()}{words[1:]}"
    return words if words.endswith("?") else f"{words}; see {path} --help"


_GAINS = {"--kp": "--attitude-gain", "--kd": "--rate-gain"}
"""Options of gains by other names of them."""


def _refused_option(context: Any, path: str, option: str) -> str | None:
    """Return the message on an unknown option: the option in its unit, who takes it, or its key.

    None for a misspelling. `context`: context of the command, None before it is known. `path`: the
    command with the program, as "tvclin study".
    """
    from tvclin.case.features import refusal
    from tvclin.cli import settings

    if context is None:
        return None
    command, taken = str(context.info_name), context.command.params
    flags = [flag for item in taken for flag in item.opts if flag.startswith("--")]
    if option == "--at" and {"--from", "--to"} <= {*flags}:
        return (
            f"{path} takes no --at: --from TIME --to TIME gives one flight time (tvclin study"
            " VEHICLE --at TIME answers at one)"
        )
    name = settings.without_unit(option.replace("-", "_"))
    same = [flag for flag in flags if settings.without_unit(flag.replace("-", "_")) == name]
    if same:
        return f"{path} takes no {option}: did you mean {same[0]}?"
    settable = "--set" in flags
    refused = refusal(command, option, settings.field_key(option) if settable else None)
    key = settings.similar_key(option) if settable else None
    if not refused and key and (flag := settings.option_of_key(key, flags)):
        return f"{path} takes no {option}: did you mean {flag}?"
    if refused or not key:
        return refused
    keys = settings.required_with(key, option)
    values = " ".join(f"--set {name} VALUE" for name in keys)
    return f"{path} takes no {option}: {values} {'gives' if len(keys) == 1 else 'give'} it"


def _version(wanted: bool) -> None:
    """Print the version and end the command, where --version is given (`wanted`)."""
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
    """Take the option --version, whose callback does the work."""
    del version  # its callback has done the work


def main() -> None:
    """Run the command line.

    A letter that the terminal lacks becomes a question mark. A width of the terminal that is no
    positive number (``COLUMNS=0``) counts as none. SIGTERM cleans up as Ctrl-C does.
    """
    if isinstance(sys.stdout, TextIOWrapper) and sys.stdout.errors in _STRICT_HANDLERS:
        sys.stdout.reconfigure(errors="replace")
    if not re.fullmatch(r"0*[1-9]\d{0,3}", os.environ.get("COLUMNS", "1")):
        del os.environ["COLUMNS"]
    if sys.argv[1:2] != ["explore"]:  # a kernel draws by its own; all other figures go into files
        os.environ["MPLBACKEND"] = "agg"
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))
    gc.set_threshold(100_000)  # to look for garbage again and again while modules load finds none
    app(prog_name="tvclin")
