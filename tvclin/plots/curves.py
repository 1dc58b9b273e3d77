"""Curves of a figure: the record from which the figure is drawn and its CSV written."""

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, array_of, each, instance, shown
from tvclin.base.files import printable, write_rows

_ROUNDING = 16.0 * float(np.finfo(float).eps)
"""Rounding of a sum of few terms, over the largest number of the sum."""


@dataclass(frozen=True, eq=False)
class Column:
    """Curve of a figure.

    Attributes
    ----------
    label : str
        Entry of the legend.
    values : ndarray
        Ordinates, ``(n,)``; NaN where the curve is interrupted.
    unit : str
        Unit of the ordinates; "-" for a pure number.
    panel : str
        Heading of its panel; empty for a figure of one panel.
    note : str
        Short warning about this curve in its panel.
    """

    label: str
    values: FloatArray
    unit: str = "-"
    panel: str = ""
    note: str = ""

    def __post_init__(self) -> None:
        """Check that labels are texts, and make a row of the values."""
        for name in ("label", "unit", "panel", "note"):
            instance(name, getattr(self, name), str, "a text")
        object.__setattr__(self, "values", row_of("values", self.values))


@dataclass(frozen=True, eq=False)
class Curves:
    """Curves of one figure over one abscissa.

    Attributes
    ----------
    name : str
        Name of the figure and of its files.
    parameters : str
        Parameters of the figure, in one line.
    abscissa_label : str
        Label of the abscissa, with its unit in brackets.
    abscissa : ndarray
        Abscissas, ``(n,)``.
    columns : tuple of Column
        Curves, each of ``n`` values.
    """

    name: str
    parameters: str
    abscissa_label: str
    abscissa: FloatArray
    columns: tuple[Column, ...]

    def __post_init__(self) -> None:
        """Check that labels are texts, and that each curve has the shape of the abscissa."""
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
        """Columns of each panel, in their order."""
        panels: dict[str, list[Column]] = {}
        for column in self.columns:
            panels.setdefault(column.panel, []).append(column)
        return panels

    @property
    def headings(self) -> list[str]:
        """Headings of the columns in the CSV, with the panel if the label is not unique."""
        count_of = Counter(column.label for column in self.columns)
        headings = []
        for column in self.columns:
            panel = f"{column.panel}: " if count_of[column.label] > 1 else ""
            note = f" ({column.note})" if column.note else ""
            headings.append(f"{panel}{column.label}{note} [{column.unit}]")
        return headings

    def column(self, label: str, panel: str = "") -> FloatArray:
        """Return the values of the curve with a label in a panel, ``(n,)``.

        Raises
        ------
        InputError
            If this panel has no such curve.
        """
        instance("label", label, str, "a text")
        instance("panel", panel, str, "a text")
        for column in self.columns:
            if (column.label, column.panel) == (label, panel):
                return column.values
        available = ", ".join(repr((c.label, c.panel)) for c in self.columns)
        raise InputError(
            f"label and panel must be one of {available}; got {shown(label)}, {shown(panel)}"
        )

    def csv(self) -> str:
        """Return the numbers as CSV: a comment, a line of headings, and a row for each abscissa.

        Numbers are in full precision; within the rounding of their column's largest they are zero.
        """
        values = (self.abscissa, *(column.values for column in self.columns))
        table = np.stack([without_rounding(numbers) for numbers in values], axis=-1)
        comment = printable(" ".join(f"# {self.name}: {self.parameters}".split("\n")))
        return f"{comment}\n{write_rows([[self.abscissa_label, *self.headings], *table.tolist()])}"


def row_of(name: str, value: object) -> FloatArray:
    """Return values as a row of numbers, ``(n,)``; `name`: their name in messages."""
    kinds = "iuf"  # integers and floating-point numbers
    array = array_of(name, value, kinds, "a row of numbers")  # type: ignore[arg-type]
    if array.ndim != 1:
        raise InputError(f"{name} must be one row of numbers; got an array of shape {array.shape}")
    return array if array.dtype == float else array.astype(float)


def finite_or_nan(values: FloatArray) -> FloatArray:
    """Return values with NaN in place of what is not finite, where a curve is interrupted."""
    return np.where(np.isfinite(values), values, np.nan)


def without_rounding(values: FloatArray, size: float = 0.0) -> FloatArray:
    """Return numbers with those that are rounding of the largest one replaced by zero.

    `size`: largest number of the computation, if it is larger than all of `values`. NaN and
    infinite values stay.
    """
    sizes = np.abs(np.where(np.isfinite(values), values, 0.0))
    return np.where(sizes <= _ROUNDING * sizes.max(initial=size), 0.0 * values, values) + 0.0


def curves_of(plot: Any) -> Curves:
    """Return the numbers from which a figure of this package was drawn.

    Parameters
    ----------
    plot : control.ControlPlot
        Figure of a function of this chapter.

    Raises
    ------
    InputError
        For a plot that was not drawn from `Curves`.
    """
    curves = getattr(plot, "curves", None)
    if not isinstance(curves, Curves):
        raise InputError("plot must be a figure drawn from curves by tvclin; this one was not")
    return curves
