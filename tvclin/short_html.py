"""Small tables in which a notebook shows a record."""

from collections.abc import Mapping
from html import escape


def short_html(caption: str, rows: Mapping[str, str]) -> str:
    """Return a table of names and texts, both escaped."""
    lines = "".join(
        f'<tr><th scope="row" style="text-align: left">{escape(name)}</th>'
        f'<td style="text-align: left">{escape(text)}</td></tr>'
        for name, text in rows.items()
    )
    return f"<table><caption>{escape(caption)}</caption>{lines}</table>"
