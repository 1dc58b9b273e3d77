"""Tables and JSON."""

import json
import os
import textwrap
from collections.abc import Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from tvclin.base.lines import Row
    from tvclin.base.lines import Table as Answer


_BESIDE = 3
"""Blanks beside a column of a table, at the most."""


def say(words: str, err: bool = False) -> None:
    """Print words: in lines that fit the terminal, and as they are into files and pipes."""
    from rich.console import Console

    console = Console(stderr=err)
    if console.is_terminal or "COLUMNS" in os.environ:
        words = "\n".join(map(partial(_filled, console.width), words.split("\n")))
    typer.echo(words, err=err)


def _filled(width: int, line: str) -> str:
    """Return a line in lines broken between words; names of files and the like stay in one."""
    return textwrap.fill(
        line, width, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False
    )


def print_table(title: str, headings: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print one table: the first column to the left, numbers to the right.

    Words stay in one piece where the terminal is wide enough for all of them.
    """
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(title), title_justify="left", title_style="bold", box=SIMPLE_HEAD)
    console, rows = Console(highlight=False), list(rows)
    words = [" ".join(column).split() for column in zip(headings, *rows, strict=True)]
    widths = [max(map(len, column), default=0) for column in words]
    fits = sum(widths) + _BESIDE * len(widths) <= console.width
    for k, (heading, width) in enumerate(zip(headings, widths, strict=True)):
        table.add_column(
            Text(heading),
            justify="right" if k else "left",
            overflow="fold",
            min_width=width if fits else None,
        )
    for row in rows:
        table.add_row(*map(Text, row))
    console.print(table)


def print_tables(*tables: "Answer") -> None:
    """Print tables of an answer."""
    from tvclin.base.lines import text

    for one in tables:
        print_table(one.caption, one.head, [tuple(map(text, row)) for row in one.rows])


def print_pairs(title: str, pairs: Iterable[tuple[str, str]], columns: int = 2) -> None:
    """Print names and values side by side, `columns` pairs to a line."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(
        title=Text(title),
        title_justify="left",
        title_style="bold",
        box=None,
        show_header=False,
        padding=(0, 2, 0, 0),
    )
    cells = [Text(text) for pair in pairs for text in pair]
    for start in range(0, len(cells), 2 * columns):
        table.add_row("", *cells[start : start + 2 * columns])
    Console(highlight=False).print(table)


def shown(rows: "Iterable[Row]") -> list[tuple[str, str]]:
    """Return the rows of a record as names and values for `print_pairs`."""
    from tvclin.base.lines import text

    return [(label, text(line)) for label, line in rows]


def limit_cell(number: float, digits: int = 4, unit: str = "") -> str:
    """Return a deflection limit in words; it is infinite where none is enough."""
    from math import isinf

    return "none is enough" if isinf(number) else f"{number:.{digits}f} {unit}".rstrip()


def print_json(document: Any) -> None:
    """Print a document, with records in it, as JSON; numbers that do not exist become null."""
    from tvclin.base.documents import plain

    typer.echo(json.dumps(plain(document), indent=2, allow_nan=False))
