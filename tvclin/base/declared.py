"""Declared fields: kind, check, default and help of a value, each stated once.

A field of a frozen dataclass is declared with `quantity`, `word`, `text`, `flag` or `count`; its
line of help is that of the docstring. From the declaration follow its check (`checked`), the keys
of a table of a file in all units (`file_table`), and the option of a command (`cli/options`).
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
_TEMPLATE_WIDTH = 96
"""Characters per line of a template."""
_UNIT = re.compile(r" \[[^\]]+\]")
_CLAUSE = re.compile(r"[;:.](?=\s|$)|$")
_ENTRY = re.compile(r"(?m)^(\w[\w, ]*) ?:?[^\n]*\n((?:    .*\n?|\n(?=    ))+)")


@dataclass(frozen=True)
class Declared:
    """Declaration of a field.

    `kind`: of a number, a kind of `UNITS`; else "text", "flag" or "count". `check`: function from a
    name and a value to the value, or its `InputError`; of numbers from a unit too. `many`: whether
    the field holds one or more values. `option`, `key`: its option, and its name in a file, where
    they differ from the field's name; None for no option or key. `shown`: text in place of the
    default in the help of its option. `choices`: possible words.
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
        """Name in a file."""
        return self.key or self.name

    @property
    def numeric(self) -> bool:
        """Whether the field is a quantity, with a unit."""
        return self.kind in UNITS

    def checked(self, name: str, value: Any, unit: str | None = None) -> Any:
        """Return a value that passes the check; `unit`: its unit, by default the SI unit."""
        if self.many:
            return self._each(name, value)
        if not self.numeric:
            return self.check(name, value)
        return one_number(name, value, self.check, si_unit(self.kind) if unit is None else unit)

    def _each(self, name: str, values: Any) -> tuple[Any, ...]:
        """Return several values that all pass the check."""
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
    """Return the field of a number in SI units, of a kind of `UNITS`; `more` as in `Declared`."""
    return _field(Declared(kind, check, **more), default)


def word(choices: Iterable[str], default: Any = MISSING, **more: Any) -> Any:
    """Return the field of a word from given choices."""
    allowed = tuple(choices)
    check = partial(one_of, choices=allowed)
    return _field(Declared("text", check, choices=allowed, **more), default)


def text(default: Any = MISSING, **more: Any) -> Any:
    """Return the field of a text of printable characters."""
    return _field(Declared("text", printable, **more), default)


def flag(default: Any = MISSING, **more: Any) -> Any:
    """Return the field of a truth value."""
    return _field(Declared("flag", true_or_false, **more), default)


def count(default: Any = MISSING, check: Callable[..., Any] = whole_number, **more: Any) -> Any:
    """Return the field of an integer."""
    return _field(Declared("count", check, **more), default)


def _field(declared: Declared, default: Any) -> Any:
    return field(default=default, metadata={_DECLARED: declared})


@cache
def declared(kind: Callable[..., Any]) -> dict[str, Declared]:
    """Return the declarations of the fields of a dataclass, by name."""
    helps: dict[str, str] = {}
    for item in reversed(inspect.getmro(kind)):  # type: ignore[arg-type]
        helps |= _helps(item)
    return {
        item.name: replace(
            item.metadata[_DECLARED],
            name=item.name,
            default=None if item.default is MISSING else item.default,
            help=helps.get(item.name, ""),
        )
        for item in fields(kind)  # type: ignore[arg-type]
        if _DECLARED in item.metadata
    }


def checked(record: Any) -> None:
    """Check each declared field of a record, and set it to the checked value.

    None passes where it is the default.
    """
    kind: Any = type(record)
    for name, declaration in declared(kind).items():
        value = getattr(record, name)
        if value is not None or declaration.default is not None:
            object.__setattr__(record, name, declaration.checked(name, value))


def file_table(heading: str, kind: type, names: str = "", **more: Any) -> FileTable:
    """Return the table of a file for declared fields, by default all that have a key.

    `more`: further words, lists and quantities of the table, as in `FileTable`.
    """
    declarations = [declared(kind)[name] for name in names.split()] or _keyed(kind)
    single = [declaration for declaration in declarations if not declaration.many]
    return replace(
        FileTable(heading, **more),
        quantities={
            declaration.called: declaration.kind for declaration in single if declaration.numeric
        }
        | more.get("quantities", {}),
        words=(
            *(declaration.called for declaration in single if not declaration.numeric),
            *more.get("words", ()),
        ),
        lists=(
            *(declaration.called for declaration in declarations if declaration.many),
            *more.get("lists", ()),
        ),
        fields={
            declaration.key: declaration.name for declaration in declarations if declaration.key
        },
    )


def _keyed(kind: type) -> list[Declared]:
    """Return the declared fields that have a key in files."""
    return [declaration for declaration in declared(kind).values() if declaration.key is not None]


def completed(text: str, table: FileTable, kind: type) -> str:
    """Return a template whose table names every key of its fields, the others in comments.

    `text`: the template, in which the table ends with an empty line.
    """
    start = text.index(f"\n{table.heading}\n")
    end = text.find("\n\n", start + 1) % len(text)
    written = text[start:end]
    missing = [
        declaration
        for declaration in _keyed(kind)
        if not re.search(rf"\b{declaration.called}(_|\b)", written)
    ]
    keys = [table.spelled(declaration.called).split(" or ")[0] for declaration in missing]
    remarks = [
        f"also {k}: {_UNIT.sub('', declaration.help)}"
        for k, declaration in zip(keys, missing, strict=True)
    ]
    lines = [
        line for remark in remarks for line in wrap(remark, _TEMPLATE_WIDTH, subsequent_indent="  ")
    ]
    return text[:end] + "".join(f"\n# {line}" for line in lines) + text[end:]


def _helps(kind: type) -> dict[str, str]:
    """Return the lines of help in the docstring of a class, by attribute."""
    doc = inspect.cleandoc(kind.__doc__ or "")
    _, _, attributes = doc.partition("Attributes\n----------\n")
    helps: dict[str, str] = {}
    for names, description in _ENTRY.findall(re.split(r"\n\n(?=\w)", attributes)[0] + "\n"):
        helps |= dict.fromkeys(names.split(", "), " ".join(description.split()))
    return {name.strip(): description for name, description in helps.items()}


def help_line(declaration: Declared) -> str:
    """Return the help of an option: the line of its field, in the unit of the option."""
    help_text = declaration.help.replace("`", "")
    if declaration.numeric and _UNIT.search(help_text):
        unit = optional_unit(declaration.kind)[1]
        help_text = _UNIT.sub("", help_text, count=1)
        help_text = _CLAUSE.sub(lambda end: f", in {unit}{end[0]}", help_text, count=1)
    if not all(choice in help_text for choice in declaration.choices):
        all_choices = listed(declaration.choices, "or")
        help_text = _CLAUSE.sub(lambda end: f": {all_choices}{end[0]}", help_text, count=1)
    return help_text
