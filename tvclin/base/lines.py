"""Lines of text with numbers in them, each as it is shown and in full precision."""

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Number:
    """A number of the page.

    Attributes
    ----------
    name : str
        What it is, with its unit; every number of a page has another.
    value : float
        In full precision, in the unit shown.
    text : str
        As it is shown.
    """

    name: str
    value: float
    text: str


Inline = str | Number
Line = tuple[Inline, ...]
"""A run of text with numbers in it; a table's cell is one too."""


Row = tuple[str, Line]
"""What records yield for tables on a page and in a terminal: a label, and what is beside it."""
_UNLIMITED = "unlimited"


def text(line: Line) -> str:
    """Return a line as it is shown."""
    return "".join(part if isinstance(part, str) else part.text for part in line)


def number(name: str, value: Any, digits: int = 4, unit: str = "") -> Line:
    """Return a number with so many digits behind the point; a dash or "none" where it is none."""
    plain = float(value)
    if not np.isfinite(plain):
        return ("-" if np.isnan(plain) else _UNLIMITED,)
    shown = Number(name, plain, f"{plain:.{digits}f}")
    return (shown, f" {unit}") if unit else (shown,)


def least(limit: Line) -> Line:
    """Return a least deflection limit: an infinite one says that none is enough."""
    return ("none is enough",) if limit == (_UNLIMITED,) else limit


def significant(name: str, value: Any, digits: int = 4, unit: str = "") -> Line:
    """Return a number with so many significant digits."""
    plain = float(value)
    shown = Number(name, plain, f"{plain:.{digits}g}")
    return (shown, f" {unit}") if unit else (shown,)


def degrees(name: str, angle: Any, digits: int = 4, unit: str = "") -> Line:
    """Return an angle [rad] in degrees; the name gets its unit."""
    return number(f"{name}_deg", float(np.degrees(angle)), digits, unit)
