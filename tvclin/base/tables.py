"""Tables of files: which keys each may hold, in which units, and what a file says with them.

A table is declared once, beside the value that is made of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any, TypeVar

from tvclin.base.errors import Faults, InputError, naming, number, shown
from tvclin.base.units import UNITS, written

_T = TypeVar("_T")


@dataclass(frozen=True, eq=False)
class FileTable:
    """The keys of a table, of which numbers carry their unit: ``weight_N``, ``weight_lbf``.

    `heading`: as in a file: ``[vehicle]``, or ``[[dispersion]]`` of a table that may stand several
    times. `quantities`: names of numbers, without unit, and of what kind of `UNITS` each is.
    `words`: keys of which the value is taken as it stands. `required`: which of all these must be
    given. `fields`: what `read` calls a name that is another word in a file.
    """

    heading: str
    quantities: dict[str, str] = field(default_factory=dict)
    words: tuple[str, ...] = ()
    lists: tuple[str, ...] = ()
    required: tuple[str, ...] = ()
    fields: dict[str, str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The heading without its brackets."""
        return self.heading.strip("[]")

    @property
    def keys(self) -> dict[str, tuple[str, float]]:
        """Keys of all numbers, each with the name and its factor to SI units."""
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
        """Return the keys by which a name is given, the SI unit first."""
        return " or ".join(key for key, (of, _) in self.keys.items() if of == name) or name

    def made(self, document: Mapping[str, Any], make: Callable[[dict[str, Any]], _T]) -> _T | None:
        """Return what is made of the table of a document, if it is there; faults name the table."""
        if self.name not in document:
            return None
        with naming(self.heading):
            return make(self.one(document))

    def one(self, document: Mapping[str, Any]) -> dict[str, Any]:
        """Return the table of a document as it stands, empty where it is not there."""
        table = document.get(self.name, {})
        if not isinstance(table, dict):
            raise InputError(f"{self.heading} must be a table; got {shown(table)}")
        return dict(table)

    def each(self, document: Mapping[str, Any]) -> list[dict[str, Any]]:
        """Return the tables of a document that stand several times, as `one`."""
        rows = document.get(self.name, [])
        if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
            raise InputError(f"{self.name} must be given as {self.heading}, once for each")
        return [dict(row) for row in rows]

    def read(self, table: Mapping[str, Any]) -> dict[str, Any]:
        """Return what a table says, by name: numbers in SI units, lists as tuples, words.

        `InputError` for all that is wrong, a line for each.
        """
        if not isinstance(table, Mapping) or not all(isinstance(key, str) for key in table):
            raise InputError(f"{self.heading} must be a table; got {shown(table)}")
        keys, found = self.keys, {}
        given: dict[str, str] = {}
        faults = Faults()
        for key, value in table.items():
            with faults.kept():
                if key in self.words:
                    found[key] = value
                elif key in self.lists:
                    found[key] = self._list(key, value)
                elif key in keys:
                    name, factor = keys[key]
                    if name in given:
                        both = f"as {given[name]} and {key}"
                        raise InputError(
                            f"{name} is given twice in {self.heading}, {both}; keep one"
                        )
                    given[name] = key
                    found[name] = number(key, value) * factor
                else:
                    raise InputError(self._unknown(key))
        faults.tell()
        self.need(found, self.required)
        return {self.fields.get(name, name): value for name, value in found.items()}

    def units(self, table: Mapping[str, Any]) -> dict[str, tuple[float, str]]:
        """Return the numbers of a table as they stand, by name, each with the unit of its key."""
        keys = self.keys
        return {
            keys[key][0]: (float(value), written(key.removeprefix(keys[key][0]).strip("_")))
            for key, value in table.items()
            if key in keys
        }

    def need(self, found: Mapping[str, Any], names: Iterable[str]) -> None:
        """Raise `InputError` for names that are not among what was found."""
        faults = Faults()
        for name in names:
            with faults.kept():
                if name not in found:
                    raise InputError(f"a key is missing in {self.heading}: {self.spelled(name)}")
        faults.tell()

    def write(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return numbers in SI units by their keys, of which `read` makes the same again."""
        return {self.spelled(name).split(" or ")[0]: value for name, value in values.items()}

    def _list(self, key: str, value: object) -> tuple[Any, ...]:
        if not isinstance(value, list):
            raise InputError(f"{key} in {self.heading} must be a list; got {shown(value)}")
        return tuple(value)

    def _unknown(self, key: str) -> str:
        keys, words = self.keys, (*self.words, *self.lists)
        fields = [
            self.spelled(k) for k, of in self.fields.items() if f"{key}_".startswith(f"{of}_")
        ]
        near = fields or get_close_matches(key, [*words, *keys], n=2, cutoff=0.5)
        nearest = keys.get(near[0], ("",))[0] if near else None
        for name in sorted(self.quantities, key=len, reverse=True):
            if key == name or (key.startswith(f"{name}_") and nearest in (name, None)):
                write = self.spelled(name)
                return f"{key} has no known unit in {self.heading}; write {write}"
        known_ones = (*words, *(self.spelled(name).split(" or ")[0] for name in self.quantities))
        return f"unknown key in {self.heading}: {shown(key)}; {_hint(near, known_ones)}"


def known(what: str, given: Iterable[str], names: Iterable[str]) -> None:
    """Raise `InputError` for those that are not among the names, and offer the near ones."""
    legal, faults = list(names), Faults()
    for key in given:
        with faults.kept():
            if key not in legal:
                near = get_close_matches(key, legal, n=2, cutoff=0.5)
                raise InputError(f"unknown {what}: {shown(key)}; {_hint(near, legal)}")
    faults.tell()


def _hint(near: list[str], legal: Iterable[str]) -> str:
    return f"did you mean {' or '.join(near)}?" if near else f"known are {', '.join(legal)}"
