"""Edited sources: the name of a file together with the tables that stand for its content."""

from __future__ import annotations

from copy import deepcopy
from typing import Any, Self


class EditedSource(str):
    """Complete name or path of a file, whose tables are these in place of those in the file.

    `tables_of` (`base/files`) returns them, so that every reader of the source has the same.

    Parameters
    ----------
    source : str
        Name or path, as messages quote it.
    tables : dict, optional
        Tables by heading, as of a TOML file; without them the content is that of the file.
    keys : tuple of str, optional
        Names of the keys that were set, other than those removed.

    Attributes
    ----------
    keys : tuple of str
        As the parameter.
    """

    _tables: dict[str, Any] | None
    keys: tuple[str, ...]

    def __new__(  # noqa: D102
        cls, source: str, tables: dict[str, Any] | None = None, keys: tuple[str, ...] = ()
    ) -> Self:
        made = super().__new__(cls, source)
        made._tables, made.keys = tables, keys
        return made

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    @property
    def tables(self) -> dict[str, Any] | None:
        """A copy of the tables; None where they equal the tables of the file."""
        return deepcopy(self._tables)
