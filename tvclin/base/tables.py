"""Declarations of tables in files: their keys, units, and the values that are read.

A table is declared once, next to the value that is made of it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any, TypeVar

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import Faults, InputError, naming, number, shown
from tvclin.base.units import UNITS, written

_T = TypeVar("_T")
_MAX_LISTED_CHARACTERS = 300
"""Largest length of a list of known keys in a message."""


@dataclass(frozen=True, eq=False)
class FileTable:
    """Declaration of a table, whose numbers carry a unit in the key: ``weight_N``, ``weight_lbf``.

    `heading`: as in a file: ``[vehicle]``, or ``[[dispersion]]`` of a repeated table. `quantities`:
    names of numbers, without unit, and the kind of `UNITS` of each. `words`: keys whose value is
    taken unchanged. `required`: required names of all these. `fields`: results' names in `read`
    that differ from the file's. `checks`: of numbers, by name, in the unit of the key. `record`:
    dataclass that is made of the table, with the defaults and the help of its keys.
    """

    heading: str
    quantities: dict[str, str] = field(default_factory=dict)
    words: tuple[str, ...] = ()
    lists: tuple[str, ...] = ()
    required: tuple[str, ...] = ()
    fields: dict[str, str] = field(default_factory=dict)
    checks: dict[str, Callable[..., FloatArray]] = field(default_factory=dict)
    record: type | None = None

    @property
    def name(self) -> str:
        """Heading without its brackets."""
        return self.heading.strip("[]")

    @property
    def keys(self) -> dict[str, tuple[str, float]]:
        """Keys of all numbers, with the name and its factor to SI units."""
        return {
            f"{name}_{unit}" if unit else name: (name, factor)
            for name, kind in self.quantities.items()
            for unit, factor in UNITS[kind].items()
        }

    @property
    def every_key(self) -> tuple[str, ...]:
        """Keys of numbers, words and lists."""
        return (*self.keys, *self.words, *self.lists)

    def spelled(self, name: str) -> str:
        """Return the possible keys of a `name`, as "weight_N or weight_lbf", the SI unit first."""
        return " or ".join(key for key, (of, _) in self.keys.items() if of == name) or name

    def made(self, document: Mapping[str, Any], make: Callable[[dict[str, Any]], _T]) -> _T | None:
        """Return what `make` returns of the table in a `document`; None without the table.

        An `InputError` of `make` gets the heading of the table in front.
        """
        if self.name not in document:
            return None
        with naming(self.heading):
            return make(self.one(document))

    def one(self, document: Mapping[str, Any]) -> dict[str, Any]:
        """Return the table in a `document` with its keys; empty if it is missing."""
        table = document.get(self.name, {})
        if not isinstance(table, dict):
            raise InputError(f"{self.heading} must be a table; got {shown(table)}")
        return dict(table)

    def each(self, document: Mapping[str, Any]) -> list[dict[str, Any]]:
        """Return all tables of the repeated heading in a `document`, each with its keys."""
        rows = document.get(self.name, [])
        if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
            raise InputError(f"{self.name} must be given as {self.heading}, once for each")
        return [dict(row) for row in rows]

    def read(self, table: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values of a table by name: numbers in SI units, lists as tuples, words.

        `InputError` for all faults, a line for each.
        """
        if not isinstance(table, Mapping) or not all(isinstance(key, str) for key in table):
            raise InputError(f"{self.heading} must be a table; got {shown(table)}")
        keys, values = self.keys, {}
        key_of: dict[str, str] = {}
        faults = Faults()
        for key, value in table.items():
            with faults.collect():
                if key in self.words:
                    values[key] = value
                elif key in self.lists:
                    if not isinstance(value, list):
                        place = f"{key} in {self.heading}"
                        raise InputError(f"{place} must be a list; got {shown(value)}")
                    values[key] = tuple(value)
                elif key in keys:
                    name, factor = keys[key]  # of the quantity without unit; its unit to SI
                    if name in key_of:
                        both_keys = f"as {key_of[name]} and {key}"
                        raise InputError(
                            f"{name} is given twice in {self.heading}, {both_keys}; keep one"
                        )
                    key_of[name] = key
                    plain = number(key, value)
                    if name in self.checks:  # in the unit of the key, which the message has
                        unit = written(key.removeprefix(name).strip("_"))
                        self.checks[name](f"{key} in {self.heading}", plain, unit)
                    values[name] = plain * factor
                else:
                    raise InputError(self.unknown(key))
        faults.raise_all()
        self.need(values, self.required)
        return {self.fields.get(name, name): value for name, value in values.items()}

    def units(self, table: Mapping[str, Any]) -> dict[str, tuple[float, str]]:
        """Return number and unit, as they are written, of each key of a `table`, by name."""
        names = {key: name for key, (name, _) in self.keys.items()}
        return {
            names[key]: (float(value), written(key.removeprefix(names[key]).strip("_")))
            for key, value in table.items()
            if key in names
        }

    def need(self, values: Collection[str], names: Iterable[str]) -> None:
        """Raise `InputError` for required `names` that are missing in `values`."""
        faults = Faults()
        for name in names:
            with faults.collect():
                if name not in values:
                    raise InputError(f"a key is missing in {self.heading}: {self.spelled(name)}")
        faults.raise_all()

    def write(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the numbers `values`, by name, in SI units by key: the inverse of `read`.

        The key is the one with the SI unit, the first of `spelled`.
        """
        return {self.spelled(name).split(" or ")[0]: value for name, value in values.items()}

    def similar(self, key: str) -> tuple[list[str], bool]:
        """Return the keys that an unknown `key` may mean, and whether only its unit is wrong.

        The unit is missing or unknown if the key, written with the unit in brackets too, begins
        with the name of a quantity, and no other key is more similar. The name of a result
        (`fields`) is answered with its key in the file.
        """
        keys, words = self.keys, (*self.words, *self.lists)
        plain = "_".join(re.findall(r"\w+", key.lower().replace("/", " per ")))
        fields = [
            self.spelled(k) for k, of in self.fields.items() if f"{plain}_".startswith(f"{of}_")
        ]
        similar = fields or get_close_matches(plain, [*words, *keys], n=2, cutoff=0.5)
        # name of the quantity of the most similar key, "" for a word
        nearest, _ = keys.get(similar[0], ("", 1.0)) if similar else (None, 1.0)
        for name in sorted(self.quantities, key=len, reverse=True):
            if plain == name or (plain.startswith(f"{name}_") and nearest in (name, None)):
                return [self.spelled(name)], True
        return similar, False

    def unknown(self, key: str) -> str:
        """Return the message on an unknown `key`: its missing unit, or similar keys."""
        similar, of_unit = self.similar(key)
        if of_unit:
            return f"{key} has no known unit in {self.heading}; write {similar[0]}"
        words = (*self.words, *self.lists)
        legal = (*words, *(self.spelled(name).split(" or ")[0] for name in self.quantities))
        return f"unknown key in {self.heading}: {shown(key)}; {_hint(similar, legal)}"


def check_known(what: str, keys: Iterable[str], names: Iterable[str]) -> None:
    """Raise `InputError` for `keys`, each a `what`, not among `names`, with similar names."""
    legal, faults = list(names), Faults()
    for key in keys:
        with faults.collect():
            if key not in legal:
                similar = get_close_matches(key, legal, n=2, cutoff=0.5)
                raise InputError(f"unknown {what}: {shown(key)}; {_hint(similar, legal)}")
    faults.raise_all()


def _hint(similar: list[str], legal: Iterable[str]) -> str:
    """Return the end of a message on an unknown key: `similar` keys, or else the `legal` ones."""
    if similar:
        return f"did you mean {' or '.join(similar)}?"
    names = ", ".join(legal)
    if len(names) <= _MAX_LISTED_CHARACTERS:
        return f"known are {names}"
    return "tvclin init --keys lists the known ones"
