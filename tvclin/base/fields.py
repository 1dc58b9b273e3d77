"""Fields of records, each specified once: kind of unit, label, digits, check and help.

A `Field` stands in the metadata of the attribute of a dataclass (`spec`), or at a property
(`derived`). All that shows a record is made of its fields (`fields_of`): the document for JSON and
the card of a notebook (`base/cards`), the rows of a table, and the columns of a CSV
(`base/cards`). A key ends with the unit of its value.

A parameter of a request is made with `quantity`, `word`, `text`, `flag` or `count`; its help is the
entry of its name in the class's docstring, which `help` shows too, so that it is written once.
Python keeps no text with an attribute, and the parser of numpydoc would bring Sphinx with it; two
expressions (`help_lines`) find the section and its entries. Its field makes the check (`checked`),
the keys of a table of a file in all units (`file_table`), and the option of a command
(`cli/options`).
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields, is_dataclass, replace
from functools import cache, partial
from operator import attrgetter
from textwrap import wrap
from typing import Any, TypeVar

import numpy as np

from tvclin.base import errors, lines
from tvclin.base.lines import listed
from tvclin.base.tables import FileTable
from tvclin.base.units import UNITS, document_unit, optional_unit, si_unit, written

_Getter = TypeVar("_Getter", bound=Callable[..., Any])


def plain(value: Any) -> Any:
    """Return a value as JSON can hold it: a record by its fields, None for NaN and infinity.

    Arrays become lists, numbers of numpy Python's, and a complex number its two parts.
    """
    if hasattr(value, "as_dict"):
        value = value.as_dict()
    elif is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in fields(value)}
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, complex):
        return {"real": value.real, "imag": value.imag}
    return None if isinstance(value, float) and not np.isfinite(value) else value


def decibels(factor: Any) -> Any:
    """Return a positive factor on an amplitude in dB, 20 log10(factor)."""
    with np.errstate(divide="ignore"):
        return errors.plain(20.0 * np.log10(np.asarray(factor)))


def degrees(value: Any) -> Any:
    """Return angles `value` [rad], also complex ones, in degrees."""
    return np.degrees(1.0) * np.asarray(value) if np.iscomplexobj(value) else np.degrees(value)


_SPECIFICATION = "tvclin_fields"
_CONVERSIONS: dict[str, Callable[[Any], Any]] = {
    **dict.fromkeys(("angle", "angular rate", "angular acceleration"), degrees),
    "gain": decibels,
}
"""Functions from SI units to other units of documents, by kind of quantity."""
_ROUNDED_UNITS = ("dB", "deg", "deg_per_s", "deg_per_s2")
"""Units with a fixed number of decimals in tables."""
_ANGLE_DIGITS = 3
"""Decimals of an angle in tables."""
_SIGNIFICANT_DIGITS = 4
"""Significant digits of another number in tables."""
_EXPONENTS = str.maketrans("23", "²³")
_SIGN_CHECKS = (errors.positive, errors.nonnegative, errors.nonzero)
_TEMPLATE_WIDTH = 96
"""Characters per line of a template."""
_UNIT = re.compile(r" \[[^\]]+\]")
_CLAUSE = re.compile(r"[;:.](?=\s|$)|$")
_SECTION = re.compile(r"(?:Attributes|Parameters)\n----------\n")
_ENTRY = re.compile(r"(?m)^(\w[\w, ]*) ?:?[^\n]*\n((?:    .*\n?|\n(?=    ))+)")


@dataclass(frozen=True)
class Field:
    """Specification of a field of a record.

    `name`: name in the record and, with its unit, in documents and columns; by default the
    attribute's. `kind`: of a number with a unit, a kind of `UNITS`, or "gain" for a factor that is
    shown in dB, "decibels" or "degrees" for a value that is given in them; of a parameter also
    "text", "flag" or "count". `of`: the attribute, also a nested one as "vehicle.name", or a
    function of the record, where that is not the attribute `name`. `label`: name in tables.
    `digits`: decimals in tables, by default three for an angle. `significant`: significant digits
    in place of decimals, by default four for another number. `infinite`: text of an infinite
    number. `card`, `document`: whether notebooks, and JSON, show the field. `key`: name in a file,
    or in a document with its unit, where it differs; None for a parameter without key.

    Of a parameter: `check`: function from a name and a value to the value, or its `InputError`; of
    numbers from a unit too. `many`: whether the field holds one or more values. `option`: its
    option, where it differs from the name; None for no option. `shown`: text in place of the
    default in the help of its option. `choices`: possible words. `help`: line of the docstring.
    """

    name: str = ""
    kind: str = ""
    of: str | Callable[[Any], Any] = ""
    label: str = ""
    digits: int | None = None
    significant: int | None = None
    infinite: str = ""
    card: bool = True
    document: bool = True
    key: str | None = ""
    check: Callable[..., Any] = errors.finite
    many: bool = False
    option: str | None = ""
    shown: str = ""
    choices: tuple[str, ...] = ()
    default: Any = None
    help: str = ""

    @property
    def file_key(self) -> str:
        """Key in a file, without a unit: `key`, or where that is empty `name`."""
        return self.key or self.name

    @property
    def title(self) -> str:
        """Label in tables."""
        return self.label or self.name.replace("_", " ")

    @property
    def suffix(self) -> str:
        """Unit at the end of the key of a document; empty without a unit."""
        return document_unit(self.kind)

    @property
    def si_unit(self) -> str:
        """SI unit in messages; empty without a unit."""
        return si_unit(self.kind) if self.numeric else ""

    @property
    def unit(self) -> str:
        """Unit in tables; empty without a unit."""
        return written(self.suffix).translate(_EXPONENTS)

    @property
    def heading(self) -> str:
        """Label in tables with its unit."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title

    @property
    def document_key(self) -> str:
        """Key in a document, with its unit: peak_deg."""
        return self.key or (f"{self.name}_{self.suffix}" if self.suffix else self.name)

    def value(self, record: Any) -> Any:
        """Return the field's value of a `record` in the unit of documents: degrees, dB."""
        return self.in_document_unit(self.si_value(record))

    def in_document_unit(self, value: Any) -> Any:
        """Return a stored `value` of the field in the unit of documents: degrees, dB."""
        convert = _CONVERSIONS.get(self.kind)
        return value if convert is None else _converted(value, convert)

    def si_value(self, record: Any) -> Any:
        """Return the field's value of a `record`, as it is stored: in SI units."""
        source = self.of or self.name
        return source(record) if callable(source) else attrgetter(source)(record)

    def line(self, record: Any, prefix: str) -> lines.Line:
        """Return the value of a record as a cell with unit, whose number is called `prefix`.key.

        The key has the unit at its end, as in documents: study.peak_deg.
        """
        return self.cell(f"{prefix}.{self.document_key}", self.value(record), self.unit)

    def cell(self, name: str, value: Any, unit: str = "") -> lines.Line:
        """Return a `value` in the unit of documents as the cell `name` of a table, with `unit`.

        A flag is yes or no, None a dash. Angles and decibels have a fixed number of decimals, other
        numbers significant digits, unless the field says otherwise.
        """
        if isinstance(value, bool | np.bool_ | str):
            return (value or "none",) if isinstance(value, str) else ("yes" if value else "no",)
        if value is None or (self.infinite and np.isinf(value)):
            return ("-" if value is None else self.infinite,)
        by_decimals = self.digits is not None or self.suffix in _ROUNDED_UNITS
        if self.significant or not by_decimals:
            return lines.significant(name, value, self.significant or _SIGNIFICANT_DIGITS, unit)
        digits = _ANGLE_DIGITS if self.digits is None else self.digits
        return lines.number(name, value, digits, unit)

    def cell_of(self, name: str, value: Any) -> lines.Line:
        """Return a stored `value` as the cell `name` of a table, in the unit of documents."""
        return self.cell(name, self.in_document_unit(value), self.unit)

    @property
    def numeric(self) -> bool:
        """Whether the field is a quantity, with a unit."""
        return self.kind in UNITS

    def checked(self, name: str, value: Any, unit: str | None = None) -> Any:
        """Return a `value`, unconverted, if it passes the check of an argument `name`.

        Else the check raises `InputError`, in which numbers have the `unit`, by default in SI.
        A number becomes a float, and several values (`many`), always in SI, a tuple.
        """
        if self.many:
            return self._each(name, value)
        if not self.numeric:
            return self.check(name, value)
        return errors.number(name, value, self.check, si_unit(self.kind) if unit is None else unit)

    def _each(self, name: str, values: Any) -> tuple[Any, ...]:
        """Return a tuple of `values` that all pass the check, as the argument `name`.

        `InputError` if there is none, and for words that are repeated.
        """
        if not self.numeric:
            return tuple(self.check(name, item) for item in errors.different(name, values))
        requested = errors.finite(name, values)
        if requested.ndim != 1 or not requested.size:
            raise errors.InputError(f"{name} must hold one number or more")
        return tuple(self.check(name, requested).tolist())

    def from_option(self, name: str, value: Any) -> Any:
        """Return the `value` of the option `name`, which is in the option's unit, in SI units."""
        if not self.numeric:
            return self._each(name, tuple(value)) if self.many else self.check(name, value)
        _, unit, factor = optional_unit(self.kind)  # text of the unit, and its factor to SI
        if self.many:
            return tuple(factor * errors.number(name, item, self.check, unit) for item in value)
        return factor * errors.number(name, value, self.check, unit)


def chosen(record: Any, *names: str) -> list[Field]:
    """Return the `Field` of each of `names` of a record; without names, all that documents show.

    They are in the order of the record. `AttributeError` for a name that is no field of it.
    """
    specified = fields_of(record)
    if missing := set(names) - {item.name for item in specified}:
        raise AttributeError(f"{type(record).__name__} has no field {', '.join(sorted(missing))}")
    return [item for item in specified if (item.name in names if names else item.document)]


def document(record: Any, *names: str) -> dict[str, Any]:
    """Return the fields `names`, or all, of a record by key, in degrees and dB, for JSON.

    A key is the field's name with the unit at its end, such as "peak_deg". Keys of a mapping among
    the values become text, as JSON requires.
    """
    values = {item.document_key: item.value(record) for item in chosen(record, *names)}
    return {
        key: {str(name): entry for name, entry in value.items()}
        if isinstance(value, dict)
        else value
        for key, value in values.items()
    }


def rows(record: Any, prefix: str, *names: str) -> list[lines.Row]:
    """Return labels and values of fields of a record for a table, except missing values.

    `prefix`: start of the numbers' names, "optimum" in "optimum.peak_deg". `names`: fields, or all.
    """
    return [
        (item.title, item.line(record, prefix))
        for item in chosen(record, *names)
        if item.value(record) is not None
    ]


def columns(record: Any, *names: str) -> list[Field]:
    """Return the `Field` of each of some `names` of a record, in the order of the names."""
    return [chosen(record, name)[0] for name in names]


def cells(record: Any, prefix: str, *names: str) -> tuple[lines.Line, ...]:
    """Return the values of fields of a record as cells of a table, without units.

    `prefix`: start of the names of the numbers, "optimum" in "optimum.peak_deg". `names`: fields to
    be shown, in this order.
    """
    return tuple(
        item.cell(f"{prefix}.{item.document_key}", item.value(record))
        for item in columns(record, *names)
    )


def record_table(
    caption: str,
    prefix: str,
    records: Sequence[Any],
    *names: str,
    labels: tuple[str, Iterable[str]] | None = None,
) -> lines.Table:
    """Return the table of `records` of one kind, a row for each, with a column for each of `names`.

    `caption`: above the table. `prefix`: first part of the names of the numbers, before the index
    of the record, as in "trial.0.limit". `records`: one or more. `labels`: heading and texts of a
    first column of labels that are no field.
    """
    head = tuple(item.heading for item in columns(records[0], *names))
    rows = [cells(record, f"{prefix}.{k}", *names) for k, record in enumerate(records)]
    if labels is not None:
        heading, texts = labels
        head = (heading, *head)
        rows = [((label,), *row) for label, row in zip(texts, rows, strict=True)]
    return lines.Table(caption, head, tuple(rows))


def array_table(
    caption: str, prefix: str, record: Any, *names: str, rows: Iterable[int] | None = None
) -> lines.Table:
    """Return the table of the fields `names` of a record, arrays ``(n,)``, a column for each.

    `caption`: above the table. `prefix`: first part of the names of the numbers, before the index
    of the row. `rows`: indices of the rows; by default all. A field without values, None, is a
    column of dashes.
    """
    specified = columns(record, *names)
    arrays = [item.value(record) for item in specified]
    count = max(len(values) for values in arrays if values is not None)
    return lines.Table(
        caption,
        tuple(item.heading for item in specified),
        tuple(
            tuple(
                item.cell(f"{prefix}.{k}.{item.document_key}", None if array is None else array[k])
                for item, array in zip(specified, arrays, strict=True)
            )
            for k in (range(count) if rows is None else rows)
        ),
    )


def _converted(value: Any, convert: Callable[[Any], Any]) -> Any:
    """Return a converted value, also in a mapping; None stays None."""
    if isinstance(value, dict):
        return {name: _converted(entry, convert) for name, entry in value.items()}
    return None if value is None else convert(value)


def quantity(
    kind: str, default: Any = MISSING, check: Callable[..., Any] = errors.finite, **more: Any
) -> Any:
    """Return a dataclass field for a number in SI units, of a `kind` of `UNITS`.

    `default`: of the field; required without one. `check`: of the number, a function of name, value
    and unit. `more`: further attributes of its `Field`.
    """
    return field(default=default, metadata=specs(Field(kind=kind, check=check, **more)))


def word(choices: Iterable[str], default: Any = MISSING, **more: Any) -> Any:
    """Return a dataclass field for one of `choices`, with a `default`; `more`: of its `Field`."""
    allowed = tuple(choices)
    more = {"check": partial(errors.one_of, choices=allowed)} | more
    return field(default=default, metadata=specs(Field(kind="text", choices=allowed, **more)))


def text(default: Any = MISSING, **more: Any) -> Any:
    """Return a dataclass field for a printable text, with a `default`; `more`: of its `Field`."""
    return field(default=default, metadata=specs(Field(kind="text", check=errors.text, **more)))


def flag(default: Any = MISSING, **more: Any) -> Any:
    """Return a dataclass field for True or False, with a `default`; `more`: of its `Field`."""
    return field(default=default, metadata=specs(Field(kind="flag", check=errors.flag, **more)))


def count(
    default: Any = MISSING, check: Callable[..., Any] = errors.whole_number, **more: Any
) -> Any:
    """Return a dataclass field for an integer, with `default`, `check`; `more`: of its `Field`."""
    return field(default=default, metadata=specs(Field(kind="count", check=check, **more)))


def spec(kind: str = "", label: str = "", **more: Any) -> Mapping[str, Any]:
    """Return the metadata of a dataclass attribute, with a `Field` of this kind and label.

    `more`: further attributes of the `Field`.
    """
    return specs(Field(kind=kind, label=label, **more))


def specs(*specified: Field) -> Mapping[str, Any]:
    """Return the metadata of a dataclass attribute, with several `Field`.

    Several are shown of one attribute, such as a wind by its shape, peak and duration.
    """
    return {_SPECIFICATION: specified}


def derived(kind: str = "", **more: Any) -> Callable[[_Getter], _Getter]:
    """Return the decorator, below ``@property``, that gives a property a `Field` of this kind.

    `more`: further attributes of the `Field`.
    """

    def mark(getter: _Getter) -> _Getter:
        """Attach a `Field` of `kind`, with `more` attributes, to a getter, and return that."""
        setattr(getter, _SPECIFICATION, (Field(kind=kind, **more),))
        return getter

    return mark


def fields_of(record: Any) -> tuple[Field, ...]:
    """Return the `Field` of each attribute, then of each property, of a record or its class."""
    kind: Any = record if isinstance(record, type) else type(record)
    return _fields_of(kind)


@cache
def _fields_of(kind: Any) -> tuple[Field, ...]:
    """Return the `Field` of each attribute and property of a class `kind`, cached.

    Attributes come first, then properties, base classes ahead; an attribute may have several
    fields. `name` is the label, `of` the attribute whose value is shown: where a field does not
    give them, both are the attribute's name.
    """
    specified: dict[str, tuple[Field, ...]] = {}
    if is_dataclass(kind):
        specified = {x.name: x.metadata.get(_SPECIFICATION, ()) for x in fields(kind)}
    for base in reversed(kind.__mro__):
        for name, member in vars(base).items():
            # the function of a property, or of a cached property
            getter = getattr(member, "fget", getattr(member, "func", None))
            if hasattr(getter, _SPECIFICATION):
                specified[name] = getattr(getter, _SPECIFICATION)
    return tuple(
        replace(item, name=item.name or name, of=item.of or name)
        for name, several in specified.items()
        for item in several
    )


@cache
def parameters(kind: Callable[..., Any]) -> dict[str, Field]:
    """Return the `Field` of each parameter of a dataclass `kind`, by name, with its help.

    The help is the entry of the name in the docstring of the class or of a base. Attributes without
    a `Field` are omitted.
    """
    helps: dict[str, str] = {}
    for item in reversed(inspect.getmro(kind)):  # type: ignore[arg-type]
        helps |= help_lines(item)
    return {
        item.name: replace(
            item.metadata[_SPECIFICATION][0],  # a parameter has one `Field`
            name=item.name,
            default=None if item.default is MISSING else item.default,
            help=helps.get(item.name, ""),
        )
        for item in fields(kind)  # type: ignore[arg-type]
        if _SPECIFICATION in item.metadata
    }


def checked(record: Any, *names: str) -> None:
    """Set parameters `names`, by default all, of a `record` to checked values.

    None stays where it is the default. The record may be frozen: it is called while it is made.
    `InputError` for a value that does not pass the check of its field.
    """
    kind: Any = type(record)
    optional = {item.name for item in fields(kind) if item.default is None}
    specified = parameters(kind)
    for name in names or specified:
        value = getattr(record, name)
        if value is not None or name not in optional:
            object.__setattr__(record, name, specified[name].checked(name, value))


def file_table(heading: str, kind: type, names: Iterable[str] = (), **more: Any) -> FileTable:
    """Return the table of a file, under `heading`, for parameters of the dataclass `kind`.

    Numbers become quantities with a unit in the key, others words or lists. Their `file_key` is the
    key without unit, the name of the attribute unless it has a `key`. Checks that hold in any unit
    are made where the file is read, so that messages have its key. `names`: of the parameters; by
    default all that have a key. `more`: further words, lists and quantities, as in `FileTable`.
    """
    specified = [parameters(kind)[name] for name in names] or _keyed(kind)
    single = [item for item in specified if not item.many]
    return replace(
        FileTable(heading, **more),
        quantities={item.file_key: item.kind for item in single if item.numeric}
        | more.get("quantities", {}),
        words=(*(item.file_key for item in single if not item.numeric), *more.get("words", ())),
        lists=(*(item.file_key for item in specified if item.many), *more.get("lists", ())),
        # attributes by key, where that is not the attribute's name
        fields={item.key: item.name for item in specified if item.key},
        # checks that hold in any unit: of a sign, and of angles, which know rad and deg; a range of
        # other numbers (`between`) is in SI units
        checks={
            item.file_key: item.check
            for item in single
            if item.numeric and (item.kind == "angle" or item.check in _SIGN_CHECKS)
        },
        record=kind,
    )


def _keyed(kind: type) -> list[Field]:
    """Return the parameters of the dataclass `kind` that have a key in files."""
    return [item for item in parameters(kind).values() if item.key is not None]


def completed(text: str, table: FileTable) -> str:
    """Return a template whose table names every key of its record, the others in comments.

    A missing key gets a comment with its name and its help below the table. `text`: the template,
    in which `table` ends with an empty line.
    """
    assert table.record is not None
    start = text.index(f"\n{table.heading}\n")
    end = text.find("\n\n", start + 1) % len(text)  # not found, -1, is the last line feed
    written = text[start:end]
    missing = [
        item for item in _keyed(table.record) if not re.search(rf"\b{item.file_key}(_|\b)", written)
    ]
    # of spellings in several units, such as "x_deg or x_rad", the first
    keys = [table.spelled(item.file_key).split(" or ")[0] for item in missing]
    remarks = [
        f"also {k}: {_UNIT.sub('', item.help)}" for k, item in zip(keys, missing, strict=True)
    ]
    lines = [
        line for remark in remarks for line in wrap(remark, _TEMPLATE_WIDTH, subsequent_indent="  ")
    ]
    return text[:end] + "".join(f"\n# {line}" for line in lines) + text[end:]


def help_lines(kind: type) -> dict[str, str]:
    """Return the lines of help in the docstring of a class `kind`, by attribute or parameter.

    They are the entries of its section Parameters, or Attributes, in numpydoc's form; an entry of
    several names, "start, stop : float", holds for each.
    """
    doc = inspect.cleandoc(kind.__doc__ or "")
    *_, attributes = _SECTION.split(doc, maxsplit=1)  # the text after the section's underline
    helps: dict[str, str] = {}
    for names, description in _ENTRY.findall(re.split(r"\n\n(?=\w)", attributes)[0] + "\n"):
        helps |= dict.fromkeys(names.split(", "), " ".join(description.split()))
    return {name.strip(): description for name, description in helps.items()}


def help_line(item: Field) -> str:
    """Return the help of the option of a field `item`: its line, in the unit of the option.

    The unit in brackets becomes ", in deg" at the end of the first clause, and choices that the
    line does not name are listed there.
    """
    help_text = item.help.replace("`", "")
    if item.numeric and _UNIT.search(help_text):
        _, unit, _ = optional_unit(item.kind)
        help_text = _UNIT.sub("", help_text, count=1)
        help_text = _CLAUSE.sub(lambda end: f", in {unit}{end[0]}", help_text, count=1)
    if not all(choice in help_text for choice in item.choices):
        all_choices = listed(item.choices, "or")
        help_text = _CLAUSE.sub(lambda end: f": {all_choices}{end[0]}", help_text, count=1)
    return help_text
