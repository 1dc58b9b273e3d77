"""Fields that are declared once: the kind of a value, its check, its default and its line of help.

A field of a frozen dataclass says what it is with `quantity`, `word`, `text`, `flag` or `count`;
its line of help is that of the docstring. From that are made its check (`checked`), the keys of a
table of a file in all units (`file_table`), and the option of a command (`cli/options`).
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable
from dataclasses import MISSING, dataclass, field, fields, replace
from functools import cache, partial
from textwrap import wrap
from typing import Any

from tvclin.base.errors import InputError, different, finite, one_of, whole_number
from tvclin.base.errors import flag as true_or_false
from tvclin.base.errors import number as one_number
from tvclin.base.errors import text as printable
from tvclin.base.lines import listed
from tvclin.base.tables import FileTable
from tvclin.base.units import UNITS, optional_unit, si_unit

_DECLARED = "declared"
_WIDE = 96
"""Letters in a line of a template."""
_UNIT = re.compile(r" \[[^\]]+\]")
_CLAUSE = re.compile(r"[;:.](?=\s|$)|$")
_ENTRY = re.compile(r"(?m)^(\w[\w, ]*) ?:?[^\n]*\n((?:    .*\n?|\n(?=    ))+)")


@dataclass(frozen=True)
class Declared:
    """What is declared of a field.

    `kind`: of a number, as of `UNITS`; else "text", "flag" or "count". `check`: from a name and a
    value to the value, or its `InputError`; of numbers from a unit too. `many`: whether it holds
    one or more of them. `option`, `key`: its option, and its name in a file, where they are others
    than the field's name; None where there is none. `shown`: what stands for the default in the
    help of its option. `choices`: what a word may be.
    """

    kind: str
    check: Callable[..., Any]
    many: bool = False
    option: str | None = ""
    shown: str = ""
    choices: tuple[str, ...] = ()
    key: str | None = ""
    name: str = ""
    default: Any = None
    help: str = ""

    @property
    def called(self) -> str:
        """Its name in a file."""
        return self.key or self.name

    @property
    def numeric(self) -> bool:
        """Whether it is a quantity, which has a unit."""
        return self.kind in UNITS

    def checked(self, name: str, value: Any, unit: str | None = None) -> Any:
        """Return a value that passes the check, in a unit if it is another than that of SI."""
        if self.many:
            return self._each(name, value)
        if not self.numeric:
            return self.check(name, value)
        return one_number(name, value, self.check, si_unit(self.kind) if unit is None else unit)

    def _each(self, name: str, values: Any) -> tuple[Any, ...]:
        """Return several values that each pass the check."""
        if not self.numeric:
            return tuple(self.check(name, one) for one in different(name, values))
        given = finite(name, values)
        if given.ndim != 1 or not given.size:
            raise InputError(f"{name} must hold one number or more")
        return tuple(self.check(name, given).tolist())

    def from_option(self, name: str, value: Any) -> Any:
        """Return the value of an option, which is in its own unit, as the field has it."""
        if not self.numeric:
            return self._each(name, tuple(value)) if self.many else self.check(name, value)
        _, unit, factor = optional_unit(self.kind)
        if self.many:
            return tuple(factor * one_number(name, one, self.check, unit) for one in value)
        return factor * one_number(name, value, self.check, unit)


def quantity(
    kind: str, default: Any = MISSING, check: Callable[..., Any] = finite, **more: Any
) -> Any:
    """Return the field of a number in SI units, of a kind of `UNITS`; `more` as of `Declared`."""
    return _field(Declared(kind, check, **more), default)


def word(choices: Iterable[str], default: Any = MISSING, **more: Any) -> Any:
    """Return the field of one of several words."""
    known = tuple(choices)
    check = partial(one_of, choices=known)
    return _field(Declared("text", check, choices=known, **more), default)


def text(default: Any = MISSING, **more: Any) -> Any:
    """Return the field of a text of printable characters."""
    return _field(Declared("text", printable, **more), default)


def flag(default: Any = MISSING, **more: Any) -> Any:
    """Return the field of what is true or false."""
    return _field(Declared("flag", true_or_false, **more), default)


def count(default: Any = MISSING, check: Callable[..., Any] = whole_number, **more: Any) -> Any:
    """Return the field of a whole number."""
    return _field(Declared("count", check, **more), default)


def _field(declared: Declared, default: Any) -> Any:
    return field(default=default, metadata={_DECLARED: declared})


@cache
def declared(kind: Callable[..., Any]) -> dict[str, Declared]:
    """Return what is declared of the fields of a dataclass, by name."""
    helps: dict[str, str] = {}
    for one in reversed(inspect.getmro(kind)):  # type: ignore[arg-type]
        helps |= _helps(one)
    return {
        one.name: replace(
            one.metadata[_DECLARED],
            name=one.name,
            default=None if one.default is MISSING else one.default,
            help=helps.get(one.name, ""),
        )
        for one in fields(kind)  # type: ignore[arg-type]
        if _DECLARED in one.metadata
    }


def checked(record: Any) -> None:
    """Check each declared field of a record, and keep it as its check returns it.

    None passes where that is the default.
    """
    kind: Any = type(record)
    for name, one in declared(kind).items():
        value = getattr(record, name)
        if value is not None or one.default is not None:
            object.__setattr__(record, name, one.checked(name, value))


def file_table(heading: str, kind: type, names: str = "", **more: Any) -> FileTable:
    """Return the table of a file for declared fields, all that have a key where none are named.

    `more` are other words, lists and quantities of the table, as of `FileTable`.
    """
    chosen = [declared(kind)[name] for name in names.split()] or _keyed(kind)
    single = [one for one in chosen if not one.many]
    return replace(
        FileTable(heading, **more),
        quantities={one.called: one.kind for one in single if one.numeric}
        | more.get("quantities", {}),
        words=(*(one.called for one in single if not one.numeric), *more.get("words", ())),
        lists=(*(one.called for one in chosen if one.many), *more.get("lists", ())),
        fields={one.key: one.name for one in chosen if one.key},
    )


def _keyed(kind: type) -> list[Declared]:
    """The fields that a file has."""
    return [one for one in declared(kind).values() if one.key is not None]


def completed(text: str, table: FileTable, kind: type) -> str:
    """Return a template whose table names every key of its fields: those it leaves out as comments.

    `text`: the template, in which the table ends with an empty line.
    """
    start = text.index(f"\n{table.heading}\n")
    place = text.find("\n\n", start + 1) % len(text)
    written = text[start:place]
    missing = [one for one in _keyed(kind) if not re.search(rf"\b{one.called}(_|\b)", written)]
    keys = [table.spelled(one.called).split(" or ")[0] for one in missing]
    said = [f"also {k}: {_UNIT.sub('', one.help)}" for k, one in zip(keys, missing, strict=True)]
    lines = [line for each in said for line in wrap(each, _WIDE, subsequent_indent="  ")]
    return text[:place] + "".join(f"\n# {line}" for line in lines) + text[place:]


def _helps(kind: type) -> dict[str, str]:
    """The lines of help of the attributes that the docstring of a class describes."""
    doc = inspect.cleandoc(kind.__doc__ or "")
    _, _, attributes = doc.partition("Attributes\n----------\n")
    found: dict[str, str] = {}
    for names, said in _ENTRY.findall(re.split(r"\n\n(?=\w)", attributes)[0] + "\n"):
        found |= dict.fromkeys(names.split(", "), " ".join(said.split()))
    return {name.strip(): said for name, said in found.items()}


def help_line(one: Declared) -> str:
    """Return the help of an option: the line of its field, with the option's own unit."""
    said = one.help.replace("`", "")
    if one.numeric and _UNIT.search(said):
        unit = optional_unit(one.kind)[1]
        said = _UNIT.sub("", said, count=1)
        said = _CLAUSE.sub(lambda end: f", in {unit}{end[0]}", said, count=1)
    if not all(choice in said for choice in one.choices):
        every = listed(one.choices, "or")
        said = _CLAUSE.sub(lambda end: f": {every}{end[0]}", said, count=1)
    return said
