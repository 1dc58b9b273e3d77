"""The head of a page: project, author, date and revision."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from datetime import date
from typing import Any, Self

from tvclin.base.errors import InputError, shown
from tvclin.base.tables import FileTable

DOCUMENT_TABLE = FileTable("[document]", words=("project", "author", "date", "revision"))


@dataclass(frozen=True, kw_only=True)
class Document:
    """The head of a page: project, author, date and revision. No number depends on it.

    Attributes
    ----------
    project, author, date, revision : str
        As they are to be shown; empty where nothing is given.
    """

    project: str = ""
    author: str = ""
    date: str = ""
    revision: str = ""

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not isinstance(value, str):
                raise InputError(f"{item.name} in [document] must be a text; got {shown(value)}")

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> Self:
        """Return the head of a page from a table [document]; its date may be one of TOML.

        Raises
        ------
        InputError
            For an unknown key, and a value that is no text.
        """
        values = DOCUMENT_TABLE.read(table)
        if isinstance(values.get("date"), date):
            values["date"] = values["date"].isoformat()
        return cls(**values)
