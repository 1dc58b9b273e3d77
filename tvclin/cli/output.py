"""Output of answers: tables, JSON and figures, and the progress of a long command."""

from __future__ import annotations

import json
import os
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

import typer

from tvclin.base.package_warnings import ImplausibleInput

if TYPE_CHECKING:
    from control import ControlPlot
    from rich.console import Console

    from tvclin.base.lines import Line, Table

_MAX_COLUMN_PADDING = 3
"""Largest number of blanks around a column of a table."""
_MIN_WORDS_OF_PROSE = 6
"""Smallest number of words of a cell that is set as a sentence."""
_MIN_PROSE_WIDTH = 16
"""Smallest width of a last column of sentences; in less they are set below the table."""
_MAX_SINGLE_COLUMN_ROWS, _MAX_PAIRS_ACROSS = 6, 4
"""Largest number of values in a single column, and of values side by side beyond that."""
_MAX_NOTES = 3
"""Largest number of notes of an answer without --more."""


def say(words: str, err: bool = False) -> None:
    """Print words: in lines that fit the terminal, and as they are into files and pipes.

    A control character, as in a file name, is a question mark. `err`: whether to stderr.
    """
    from rich.console import Console

    from tvclin.base.files import printable

    words, console = printable(words), Console(stderr=err)
    if console.is_terminal or "COLUMNS" in os.environ:
        form: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
        form |= {"width": console.width, "subsequent_indent": "  "}
        words = "\n".join(textwrap.fill(line, **form) for line in words.split("\n"))
    typer.echo(words, err=err)


def say_lines(lines: Iterable[Line]) -> None:
    """Print lines of an answer."""
    from tvclin.base.lines import text

    for line in lines:
        say(text(line))


_NOTES_BELOW: list[str] = []
"""Notes of the running command that are printed on stderr below its answer."""


def note_below(sentence: str) -> None:
    """Print a note on stderr when the command ends, so that its verdict stands first."""
    _NOTES_BELOW.append(sentence)


@contextmanager
def notes_last() -> Iterator[None]:
    """Print on stderr, at the end, each note of `note_below` once."""
    try:
        yield
    finally:
        notes = dict.fromkeys(_NOTES_BELOW)
        _NOTES_BELOW.clear()
        for sentence in notes:
            say(f"Note: {sentence.rstrip('.')}.", err=True)


def print_answer(
    verdict: str,
    *tables: Table,
    notes: Iterable[str] = (),
    more: bool = False,
    details: Callable[[], None] | None = None,
) -> None:
    """Print the verdict, the tables that answer, and notes.

    `notes`: those on implausible input come first. The first three are printed, or all on
    implausible input, and with `more`, the option --more, all of them. A note that stands in the
    verdict is not repeated.
    `details`: prints further tables below, with `more` alone. Without it a last line says that
    there is more.
    """
    say(f"{verdict[0].upper()}{verdict[1:].rstrip('.')}.\n")
    print_tables(*tables)
    unique = dict.fromkeys(note for note in notes if note not in verdict)
    implausible = [note for note in unique if isinstance(note, ImplausibleInput)]
    others = [note for note in unique if not isinstance(note, ImplausibleInput)]
    remaining = len(others) if more else max(0, _MAX_NOTES - len(implausible))
    for note in (*implausible, *others[:remaining]):
        say(f"Note: {note.rstrip('.')}.")
    if more and details is not None:
        details()
    elif not more and (details is not None or len(unique) > _MAX_NOTES):
        say("--more prints all tables and notes.")


def print_tables(*tables: Table) -> None:
    """Print tables of an answer: names beside their values, or columns below their headings."""
    from tvclin.base.files import printable
    from tvclin.base.lines import QUANTITIES, text

    for table in tables:
        rows = [tuple(printable(text(cell)) for cell in row) for row in table.rows]
        caption = printable(table.caption)
        if table.head == QUANTITIES:
            _print_quantities(caption, rows)
        else:
            _print_columns(caption, tuple(map(printable, table.head)), rows)


def _print_columns(title: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table: labels and sentences aligned to the left, numbers to the right.

    `title`: line above it. `headings`: of the columns. `rows`: cells of each row, as text. No word
    is broken where the terminal has room for the longest word of each column, unlike in rich alone;
    headings are wrapped before cells. Sentences of the last column that have too little room are
    printed below the table, each with the label of its row.
    """
    from rich.console import Console

    console = Console(highlight=False)
    columns = list(zip(headings, *rows, strict=True))  # heading first, then cells
    counts = [max((len(cell.split()) for cell in column[1:]), default=0) for column in columns]
    prose = [count >= _MIN_WORDS_OF_PROSE for count in counts]
    pieces = [" ".join((column[0].replace("-", "- "), *column[1:])).split() for column in columns]
    minima = [max(map(len, words), default=0) for words in pieces]  # widths of the longest words
    # further width for the whole of the longest text of each column, and what the terminal has left
    wanted = [max(map(len, cells)) - width for cells, width in zip(columns, minima, strict=True)]
    spare = console.width - sum(minima) - _MAX_COLUMN_PADDING * len(columns) - 1
    fits, wider = spare >= 0, dict.fromkeys(range(len(columns)), 0)  # wider: further width given
    of_cells = [max(map(len, cells[1:]), default=0) for cells in columns]
    for_cells = [n - low for n, low in zip(of_cells, minima, strict=True)]
    for lengths in (for_cells, wanted):  # cells before headings, which are broken first
        spare = _widen(wider, lengths, spare, prose)  # changes `wider`, returns what is left
    last = len(columns) - 1
    narrow = not fits or minima[last] + wider[last] < _MIN_PROSE_WIDTH
    if last and prose[last] and wanted[last] > wider[last] and narrow:
        _print_columns(title, headings[:-1], [row[:-1] for row in rows])
        for row in rows:
            if row[-1]:
                say(f"  {row[0]}: {row[-1]}")
        return
    widths = [width + wider[k] for k, width in enumerate(minima)]
    _print_grid(console, title, headings, rows, widths, prose, fits)


def _widen(wider: dict[int, int], wanted: Sequence[int], spare: int, prose: Sequence[bool]) -> int:
    """Widen columns to what they want, labels first, and return the remaining spare width.

    `wider`: additional width of each column, which is changed. `wanted`: additional width that each
    column asks for. `spare`: width that the terminal has left. `prose`: whether each column holds
    sentences. The first column of labels takes all it asks for; each further one, the least
    demanding first, at most an equal share of what is left.
    """
    labels_first = sorted(wider, key=lambda k: (k > 0 or prose[k], wanted[k]))
    for n, k in enumerate(labels_first):
        # the labels share with no column, others with all columns that follow in this order
        shared = 1 if not k and not prose[k] else len(wider) - n
        more = max(min(wanted[k] - wider[k], max(spare, 0) // shared), 0)
        wider[k] += more
        spare -= more
    return spare


def _print_grid(
    console: Console,
    title: str,
    headings: Sequence[str],
    rows: Sequence[Sequence[str]],
    widths: Sequence[int],
    prose: Sequence[bool],
    fits: bool,
) -> None:
    """Print a table with columns of given widths, which rich chooses unless `fits`.

    `headings`, `rows`: texts of the columns and of the cells by row. `widths`: width of each column
    [characters]; `fits`: whether all of them have room in the terminal. `prose`: whether each
    column holds sentences, which are aligned to the left, as is the first column.
    """
    from rich.box import SIMPLE_HEAD
    from rich.table import Table as Grid
    from rich.text import Text

    grid = Grid(box=SIMPLE_HEAD)
    for k, (heading, width) in enumerate(zip(headings, widths, strict=True)):
        grid.add_column(
            Text(textwrap.fill(heading, max(width, 1), break_long_words=False)),
            justify="left" if prose[k] or not k else "right",
            overflow="fold",
            width=width if fits else None,
        )
    for row in rows:
        grid.add_row(*map(Text, row))
    console.print(Text(title, "bold"))
    console.print(grid)


def _print_quantities(title: str, rows: Sequence[Sequence[str]]) -> None:
    """Print names and values (`rows`) below a title, side by side where there are many.

    They are in as many pairs of columns as the terminal has room for, at most
    `_MAX_PAIRS_ACROSS`.
    """
    from rich.console import Console
    from rich.table import Table as Grid
    from rich.text import Text

    console = Console(highlight=False)
    grid = Grid(box=None, show_header=False, padding=(0, 2, 0, 0))
    widest = sum(max(map(len, column), default=0) + 2 for column in zip(*rows, strict=True))
    across = 1
    if len(rows) > _MAX_SINGLE_COLUMN_ROWS:
        across = max(1, min(_MAX_PAIRS_ACROSS, console.width // (widest + 2)))
    cells = [Text(text) for row in rows for text in row]
    for start in range(0, len(cells), 2 * across):
        grid.add_row("", *cells[start : start + 2 * across])
    console.print(Text(title, "bold"))
    console.print(grid)
    typer.echo()


def print_json(document: Any) -> None:
    """Print a document, with records in it, as JSON; numbers that do not exist become null."""
    from tvclin.base.fields import plain

    typer.echo(json.dumps(plain(document), indent=2, allow_nan=False))


def answer(
    as_json: bool, document: Callable[[], Any], words: Callable[[], None], good: bool = True
) -> None:
    """Print an answer, its document as JSON or in words; exit code 1 says that it is not good."""
    if as_json:
        print_json(document())
    else:
        words()
    if not good:
        raise typer.Exit(1)


def draw(plot: Path | None, chart: Callable[[], ControlPlot]) -> None:
    """Write the figure into the file `plot`, if it is not None; `chart`: function that draws it."""
    if plot is not None:
        from tvclin.plots import save_figure

        save_figure(chart(), plot)


Progress = Callable[[float, float], None]
"""Function called with the amount of work done, and with its total."""
_RATE_PERIOD_S = 3600.0
"""Period of the estimate of a rate [s]: slow work may report nothing for minutes."""
_MIN_DONE_FRACTION = 0.1
"""Fraction of the work done, since the first report, before a remaining time is shown."""
_LINE_INTERVAL_S = 20.0
"""Time [s] between two lines without a terminal, and before the first."""


@contextmanager
def bar(what: str, *, even: bool = True) -> Iterator[Progress]:
    """Yield the function that shows a bar with the remaining time, or lines in a pipe.

    `what`: the units of work in words, as "flights". `even`: whether all take about the same time;
    else no remaining time is shown.
    """
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lines(what, even=even)
        return
    from rich import progress as rich  # late: a terminal alone needs it

    counted = rich.TextColumn(f"{{task.completed:.0f}} of {{task.total:.0f}} {what}")
    time = rich.TimeRemainingColumn() if even else rich.TimeElapsedColumn()
    columns = (rich.BarColumn(), counted, time)
    with rich.Progress(*columns, console=console, speed_estimate_period=_RATE_PERIOD_S) as progress:
        task = progress.add_task(what, total=None, visible=False)
        yield lambda done, total: progress.update(task, completed=done, total=total, visible=True)


def lines(what: str, *, even: bool = True) -> Progress:
    """Return the function that writes progress on stderr, a line in twenty seconds at most.

    `what`, `even`: the units of work in words, and whether all take about the same time; else no
    remaining time is written. The rate counts from the first report on: earlier work, and
    the compilation of kernels until then, do not enter it. A remaining time is written after
    `_MIN_DONE_FRACTION` of the work since then.
    """
    last = monotonic()
    first: tuple[float, float] | None = None

    def tell(done: float, total: float) -> None:
        """Print how much of a total of the work, `what`, is done, unless a line is recent.

        `last` is the time [s] of that line, `first` time and work of the first call. Nothing is
        printed before the work begins and when it is complete.
        """
        nonlocal first, last
        now = monotonic()
        first = first or (now, done)
        if now - last < _LINE_INTERVAL_S or not 0.0 < done < total:
            return
        last = now
        passed, worked, rest = now - first[0], done - first[1], total - done
        known = even and worked >= _MIN_DONE_FRACTION * (worked + rest)
        remaining = f", about {passed * rest / worked:.0f} s left" if known else ""
        typer.echo(f"{done:.0f} of {total:.0f} {what}{remaining}", err=True)

    return tell


@contextmanager
def waiting(what: str) -> Iterator[None]:
    """Show the current work `what`, in words, and its elapsed time; on a terminal alone."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield
        return
    from rich import progress as rich  # late: a terminal alone needs it

    shown = (rich.SpinnerColumn(), rich.TextColumn("{task.description}"), rich.TimeElapsedColumn())
    with rich.Progress(*shown, console=console, transient=True) as progress:
        progress.add_task(what, total=None)
        yield
