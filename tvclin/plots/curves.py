"""The numbers of a figure: one record, from which the figure is drawn and its CSV written."""

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, array_of, each, instance, shown
from tvclin.base.files import printable, write_rows

_ROUNDING = 16.0 * float(np.finfo(float).eps)
"""Of a sum of few terms, over the largest number in sight."""


@dataclass(frozen=True, eq=False)
class Column:
    """One curve.

    Attributes
    ----------
    label : str
        What the legend calls it.
    values : ndarray
        Ordinates, ``(n,)``; NaN where the curve is broken.
    unit : str
        Unit of the ordinates; "-" for a pure number.
    panel : str
        Heading of the panel that it is drawn in; empty where there is one panel only.
    note : str
        What must be known about this curve in this panel, in a few words.
    """

    label: str
    values: FloatArray
    unit: str = "-"
    panel: str = ""
    note: str = ""

    def __post_init__(self) -> None:
        for name in ("label", "unit", "panel", "note"):
            instance(name, getattr(self, name), str, "a text")
        object.__setattr__(self, "values", row_of("values", self.values))


@dataclass(frozen=True, eq=False)
class Curves:
    """The curves of one figure over one abscissa.

    Attributes
    ----------
    name : str
        Name of the figure, as of its files.
    parameters : str
        What the figure is drawn for, in one line.
    abscissa_label : str
        What the abscissa is, with its unit in brackets.
    abscissa : ndarray
        ``(n,)``.
    columns : tuple of Column
        The curves, each of ``n`` values.
    """

    name: str
    parameters: str
    abscissa_label: str
    abscissa: FloatArray
    columns: tuple[Column, ...]

    def __post_init__(self) -> None:
        for name in ("name", "parameters", "abscissa_label"):
            instance(name, getattr(self, name), str, "a text")
        object.__setattr__(self, "abscissa", row_of("abscissa", self.abscissa))
        for column in each("columns", self.columns, Column, "one for each curve"):
            if column.values.shape != self.abscissa.shape:
                raise InputError(
                    f"{column.label} must have the shape of the abscissa,"
                    f" {self.abscissa.shape}; got {column.values.shape}"
                )

    @property
    def panels(self) -> dict[str, list[Column]]:
        """The columns of each panel, in their order."""
        found: dict[str, list[Column]] = {}
        for column in self.columns:
            found.setdefault(column.panel, []).append(column)
        return found

    @property
    def headings(self) -> list[str]:
        """What stands above the columns in the CSV, with the panel where a label is not enough."""
        times = Counter(column.label for column in self.columns)
        found = []
        for column in self.columns:
            panel = f"{column.panel}: " if times[column.label] > 1 else ""
            note = f" ({column.note})" if column.note else ""
            found.append(f"{panel}{column.label}{note} [{column.unit}]")
        return found

    def column(self, label: str, panel: str = "") -> FloatArray:
        """Return the values of one curve.

        Raises
        ------
        InputError
            When there is no such curve in this panel.
        """
        instance("label", label, str, "a text")
        instance("panel", panel, str, "a text")
        for column in self.columns:
            if (column.label, column.panel) == (label, panel):
                return column.values
        known = ", ".join(repr((c.label, c.panel)) for c in self.columns)
        raise InputError(
            f"label and panel must be one of {known}; got {shown(label)}, {shown(panel)}"
        )

    def csv(self) -> str:
        """Return the numbers as CSV: a comment, a line of headings, and a row for each abscissa.

        Every number is written so that it reads back as the same one; what the rounding of the
        largest number of its column leaves in place of a zero is zero.
        """
        values = (self.abscissa, *(column.values for column in self.columns))
        table = np.stack([without_rounding(one) for one in values], axis=-1)
        comment = printable(" ".join(f"# {self.name}: {self.parameters}".split("\n")))
        return f"{comment}\n{write_rows([[self.abscissa_label, *self.headings], *table.tolist()])}"


def row_of(name: str, value: object) -> FloatArray:
    """Return one row of numbers, of which some may be NaN; `InputError` for all else."""
    array = array_of(name, value, "iuf", "a row of numbers")  # type: ignore[arg-type]
    if array.ndim != 1:
        raise InputError(f"{name} must be one row of numbers; got an array of shape {array.shape}")
    return array if array.dtype == float else array.astype(float)


def without_rounding(values: FloatArray, size: float = 0.0) -> FloatArray:
    """Return numbers with zero, without a minus, for what rounding leaves in its place.

    `size`: the largest number in sight, if it is larger than all of them.
    """
    sizes = np.abs(np.where(np.isfinite(values), values, 0.0))
    return np.where(sizes <= _ROUNDING * sizes.max(initial=size), 0.0 * values, values) + 0.0


def curves_of(plot: Any) -> Curves:
    """Return the numbers from which a figure of this package was drawn.

    Parameters
    ----------
    plot : control.ControlPlot
        What a figure function returned.

    Raises
    ------
    InputError
        For a plot that was not drawn from such numbers.
    """
    found = getattr(plot, "curves", None)
    if not isinstance(found, Curves):
        raise InputError("plot must be a figure drawn from curves by tvclin; this one was not")
    return found
