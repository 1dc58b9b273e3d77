"""Blocks of a page: paragraphs, checks, tables, figures."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from tvclin.base.lines import Line, Table
from tvclin.studyfile.findings import Findings


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
class Figure:
    """A figure: its description for screen readers, its caption, and its SVG."""

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


def section_of(
    findings: Findings,
    attribute: str,
    name: str,
    title: str,
    blocks: Callable[[Findings], Iterable[Block]],
) -> Section | None:
    """Return the section of an attribute of the findings; None where it was not requested.

    Where the attribute has no answer the section gives the reason.
    """
    if attribute in findings.reasons:
        why = Paragraph((f"There is no answer: {findings.reasons[attribute]}.",))
        return Section(name, title, (why,))
    return Section(name, title, tuple(blocks(findings))) if getattr(findings, attribute) else None


def checks(warnings: Iterable[str], assumed: Iterable[str] = ()) -> list[Block]:
    """Return one block of checks, warnings before assumptions; an empty list without notes."""
    items = [Check("doubt", (as_sentence(note),)) for note in warnings]
    items += [Check("reader", (as_sentence(note),)) for note in assumed]
    return [Checks(tuple(items))] if items else []


def as_sentence(note: str) -> str:
    """Return a note with a full stop and, where it begins with a plain word, a capital."""
    begins = note[:1].upper() if note.partition(" ")[0].rstrip(",:").isalpha() else note[:1]
    return f"{begins}{note[1:].rstrip('.')}."
