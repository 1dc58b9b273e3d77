"""What a page is made of: paragraphs, checks, tables, figures."""

from collections.abc import Iterable
from dataclasses import dataclass

from tvclin.base.lines import Line, Row


@dataclass(frozen=True)
class Paragraph:
    """A paragraph."""

    line: Line
    kind = "paragraph"


@dataclass(frozen=True)
class Check:
    """One assumption: whether it holds here ("ok"), does not ("doubt"), or is the reader's."""

    state: str
    line: Line


@dataclass(frozen=True)
class Checks:
    """A list of assumptions."""

    each: tuple[Check, ...]
    kind = "checks"


@dataclass(frozen=True)
class Table:
    """A table; the first cell of each row is its heading."""

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[Line, ...], ...]
    kind = "table"


@dataclass(frozen=True)
class Figure:
    """A figure: what it shows in words for those who do not see it, its caption, and its SVG."""

    label: str
    caption: str
    svg: str
    kind = "figure"


Block = Paragraph | Checks | Table | Figure


@dataclass(frozen=True)
class Section:
    """A part of the page; the name is the target of links to it."""

    name: str
    title: str
    blocks: tuple[Block, ...]


def no_answer(name: str, title: str, reason: str) -> Section:
    """Return the section of what has a reason in place of an answer."""
    return Section(name, title, (Paragraph((f"There is no answer: {reason}.",)),))


def pairs(rows: Iterable[Row]) -> tuple[tuple[Line, ...], ...]:
    """Return rows of a label and a value as those of a table."""
    return tuple(((label,), line) for label, line in rows)
