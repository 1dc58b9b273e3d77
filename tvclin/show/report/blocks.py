"""What a page is made of: paragraphs, checks, tables, figures."""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from tvclin.answers.findings import Findings
from tvclin.base.lines import Formula, Line, Row, number

_SYMBOL = re.compile(r"(Theta|beta|[A-Za-z])(?:_([A-Za-z]+)|(\d))?")
"""Letter and index of a symbol, such as beta, K1 or F_A."""

_DIGITS = {"dB": 1, "deg": 1, "ms": 0, "": 2}
"""Digits behind the point of margins."""


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


def pairs(rows: Iterable[Row]) -> tuple[tuple[Line, ...], ...]:
    """Return rows of a label and a value as those of a table."""
    return tuple((labelled(label), line) for label, line in rows)


def labelled(label: str) -> Line:
    """Return a label; its last word is a formula where that is a symbol, as in "thrust T"."""
    words, space, last = label.rpartition(" ")
    found = _SYMBOL.fullmatch(last)
    if found is None:
        return (label,)
    letter, index = found[1], found[2] or found[3]
    tex = f"\\{letter}" if len(letter) > 1 else letter
    return (words + space, Formula(tex + (f"_{{{index}}}" if index else ""), last))


def margin(name: str, value: float, unit: str) -> Line:
    """Return a margin with the digits of its unit."""
    return number(name, value, _DIGITS[unit], unit)
