"""What a page is made of: paragraphs, checks, tables, figures."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from tvclin.answers.findings import Findings
from tvclin.base.lines import Line, Table


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


def section_of(
    found: Findings, part: str, name: str, title: str, blocks: Callable[[Findings], Iterable[Block]]
) -> Section | None:
    """Return the section of a part of the findings.

    Where the part has no answer the section says why; where nobody asked for it there is none.
    """
    if part in found.reasons:
        why = Paragraph((f"There is no answer: {found.reasons[part]}.",))
        return Section(name, title, (why,))
    return Section(name, title, tuple(blocks(found))) if getattr(found, part) else None


def checks(doubts: Iterable[str], assumed: Iterable[str] = ()) -> list[Block]:
    """Return notes as a list of what to beware of and what is assumed; nothing without any."""
    each = [Check("doubt", (as_sentence(one),)) for one in doubts]
    each += [Check("reader", (as_sentence(one),)) for one in assumed]
    return [Checks(tuple(each))] if each else []


def as_sentence(note: str) -> str:
    """Return a note with a full stop and, where it begins with a plain word, a capital."""
    begins = note[:1].upper() if note.partition(" ")[0].rstrip(",:").isalpha() else note[:1]
    return f"{begins}{note[1:].rstrip('.')}."
