"""The one style of all figures: colours, lines that stay apart in grey print, grid and panels.

pyplot is imported when the first figure is drawn, not before.
"""

import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from os import PathLike
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from tvclin.base.errors import InputError, instance, shown, whole_number
from tvclin.base.errors import path as a_path
from tvclin.base.files import called as quoted
from tvclin.base.files import printable, write_whole
from tvclin.plots.curves import Column, Curves

if TYPE_CHECKING:
    from control import ControlPlot
    from matplotlib.axes import Axes

INK = "#1a1a2e"
WARM = "#b4541a"
COLOURS = ("#1b4f9c", "#2a8a8a", "#7a6a12", WARM, "#8a2255")
LINES: tuple[Any, ...] = ("-", "--", "-.", (0, (5, 1, 1, 1, 1, 1)), ":")
MARKS = ("o", "s", "^", "D")
_WIDE, _NARROW = 90, 64
"""Letters in a line of a title over several panels, and over one with its legend beside it."""

Style = dict[str, Any]
QUANTITIES: dict[str, Style] = {
    "attitude": {"color": INK, "ls": "-", "lw": 2.0},
    "flight_path_angle": {"color": COLOURS[1], "ls": LINES[3], "lw": 1.8},
    "angle_of_attack": {"color": COLOURS[4], "ls": "-.", "lw": 1.8},
    "attitude_rate": {"color": INK, "ls": LINES[3], "lw": 1.8},
    "deflection": {"color": WARM, "ls": "-", "lw": 2.0},
    "wind": {"color": COLOURS[0], "ls": ":", "lw": 2.2},
}
"""How what varies over time is drawn in every figure."""
ANGLES = ("attitude", "flight_path_angle", "angle_of_attack")

_SYMBOLS = {
    "tau*beta": r"$\tau\beta$",
    "tau*p": r"$\tau p$",
    "t/tau": r"$t/\tau$",
    "y_BR": r"$y_{BR}$",
    "Theta - Theta_n": r"$\Theta - \Theta_n$",
    "alpha_w,max": r"$\alpha_{w,max}$",
    "angle_of_attack": "angle of attack",
    "flight_path_angle": "flight path angle",
    "attitude_rate": "attitude rate",
}


_MAX_PANELS = 16
"""Panels in one row of a figure."""


@dataclass(frozen=True)
class Look:
    """How the curves of a figure are drawn.

    `title`: title of the figure. `ordinate`: label of the ordinate with its unit, for all panels or
    for each. `styles`: for each label of a curve, what matplotlib is to draw it with. `legend`:
    heading of the legend. `limits`: for each panel, the ends of the ordinate. `across`: panels in
    one row.
    """

    title: str
    ordinate: str | Mapping[str, str]
    styles: Mapping[str, Style]
    legend: str = ""
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    across: int = 2

    def __post_init__(self) -> None:
        instance("title", self.title, str, "a text")
        if not 1 <= whole_number("across", self.across) <= _MAX_PANELS:
            raise InputError(f"across must be from 1 to {_MAX_PANELS}; got {shown(self.across)}")


def draw(curves: Curves, look: Look) -> "ControlPlot":
    """Draw curves, a panel for each heading, and one legend beside them all.

    `curves`: the numbers; nothing else is drawn. `look`: how they look. `InputError` for an
    abscissa of fewer than two values, which has no width.
    """
    instance("curves", curves, Curves, "the numbers of a figure")
    finite = curves.abscissa[np.isfinite(curves.abscissa)]
    if not finite.size or not np.ptp(finite) > 0.0:
        what, came = pretty(curves.abscissa_label), shown(curves.abscissa)
        raise InputError(f"{what} must hold two different values or more; got {came}")
    for column in curves.columns:
        if column.label not in look.styles:
            known = ", ".join(look.styles)
            raise InputError(f"curves must be among {known}; got {shown(column.label)}")
    panels = curves.panels
    shape, axes = new_panels(len(panels), look.across)
    lines: list[Any] = []
    for one, (heading, columns) in zip(axes, panels.items(), strict=False):
        for column in columns:
            style = look.styles[column.label]
            label = pretty(literal(column.label))
            lines += one.plot(curves.abscissa, column.values, label=label, **style)
        _label_panel(one, curves, look, heading)
        _write_notes(one, columns)
    for empty in axes[len(panels) :]:
        empty.set_axis_off()
    if len(panels) > 1:
        axes[0].figure.suptitle(pretty(literal(broken(look.title))))
    else:
        axes[0].set_title(pretty(literal(broken(look.title, _NARROW))))
    first = {line.get_label(): line for line in reversed(lines)}
    handles = [first[label] for label in dict.fromkeys(line.get_label() for line in lines)]
    axes[0].figure.legend(handles=handles, title=pretty(look.legend), loc="outside right center")
    return control_plot(lines, axes.reshape(shape), curves)


def _label_panel(axes: "Axes", curves: Curves, look: Look, heading: str) -> None:
    ordinate = look.ordinate if isinstance(look.ordinate, str) else look.ordinate[heading]
    ends = curves.abscissa[np.isfinite(curves.abscissa)]
    axes.set(
        xlabel=pretty(curves.abscissa_label),
        ylabel=pretty(ordinate),
        xlim=(float(ends.min()), float(ends.max())),
    )
    if heading:
        axes.set_title(pretty(heading), fontsize="medium")
    if heading in look.limits:
        axes.set_ylim(*look.limits[heading])
    fine_grid(axes)


def _write_notes(axes: "Axes", columns: Sequence[Column]) -> None:
    notes: dict[str, list[str]] = {}
    for column in columns:
        if column.note:
            notes.setdefault(column.note, []).append(column.label)
    text = "\n".join(f"{', '.join(labels)}:\n{note}" for note, labels in notes.items())
    if text:
        box = {"facecolor": "white", "edgecolor": "0.6", "boxstyle": "round,pad=0.3"}
        place: Style = {"ha": "right", "va": "bottom", "transform": axes.transAxes, "bbox": box}
        axes.text(0.97, 0.04, pretty(text), fontsize=9, **place)


def broken(words: str, width: int = _WIDE) -> str:
    """Return words in lines that a title has room for, broken at commas alone."""
    lines = words.replace(" ", "\u00a0").replace(",\u00a0", ", ").split("\n")
    return "\n".join(fill(line, width) for line in lines).replace("\u00a0", " ")


def broken_lines(labels: Sequence[str], width: float = 1.6) -> dict[str, Style]:
    """Return a colour and a line for each label, apart in colour and in grey print."""
    pairs = zip(labels, cycle(COLOURS), cycle(LINES), strict=False)
    return {label: {"color": colour, "ls": line, "lw": width} for label, colour, line in pairs}


def law_styles(names: Iterable[str]) -> dict[str, Style]:
    """Return how the curves of laws are drawn, with a mark at each of their numbers."""
    kinds = zip(names, (*COLOURS[:3], COLOURS[4], WARM), LINES, strict=False)
    return {
        name: {"color": colour, "ls": line, "lw": 1.8, "marker": "o", "ms": 3.5}
        for name, colour, line in kinds
    }


def new_axes() -> "Axes":
    """Return the axes of a figure of one panel, with room for a legend beside it."""
    import matplotlib.pyplot as plt

    _, axes = plt.subplots(figsize=(8.6, 5.6), layout="constrained")
    return axes


def new_panels(count: int, across: int) -> tuple[tuple[int, int], Any]:
    """Return the shape (rows, columns) of `count` panels and their axes, ``(rows * columns,)``."""
    import matplotlib.pyplot as plt

    columns = min(count, across)
    rows = -(-count // columns)
    width, height = 3.0 + 4.4 * columns, 0.6 + 3.9 * rows
    if columns == 1:
        width, height = 8.6, 5.6 if rows == 1 else 0.8 + 2.7 * rows
    _, axes = plt.subplots(
        rows, columns, figsize=(width, height), layout="constrained", squeeze=False
    )
    return (rows, columns), axes.ravel()


def fine_grid(axes: "Axes") -> None:
    """Draw the grid, fine enough to read values off."""
    axes.minorticks_on()
    axes.grid(which="major", color="0.75", lw=0.8)
    axes.grid(which="minor", color="0.9", lw=0.5)
    axes.set_axisbelow(True)


def literal(text: str) -> str:
    """Return a text with names of users, without control characters, in which no $ is a formula."""
    return printable(text).replace("$", r"\$")


def pretty(text: str) -> str:
    """Return a label with the report's symbols and with words in place of plain names."""
    for plain, symbol in _SYMBOLS.items():
        text = text.replace(plain, symbol)
    return text


def called(name: str, text: str) -> str:
    """Return a title with the name of the vehicle above it, where there is one."""
    instance("name", name, str, "a text")
    return f"{name}\n{text}" if name else text


def cycle(items: Sequence[Any]) -> list[Any]:
    """Return the items over and over, for more curves than a figure can show."""
    return list(items) * 8


def control_plot(lines: list[Any], axes: Any, curves: Curves | None = None) -> "ControlPlot":
    """Return lines and axes as python-control's plot, with the numbers it shows as `.curves`."""
    panels = np.atleast_2d(axes)
    table = np.empty(panels.shape, dtype=object)
    for index, panel in np.ndenumerate(panels):
        table[index] = [line for line in lines if line.axes is panel]
    if "control" not in sys.modules:
        return cast("ControlPlot", _Drawn(table, panels, panels[0, 0].figure, curves))
    from control import ControlPlot

    plot = ControlPlot(table, panels, panels[0, 0].figure)
    plot.curves, plot.savefig = curves, plot.figure.savefig
    return plot


@dataclass(eq=False)
class _Drawn:
    """A `ControlPlot` for those who have not imported python-control, which takes a second.

    It is one to `isinstance`, and what only python-control knows is asked there.
    """

    lines: Any
    axes: Any
    figure: Any
    curves: Curves | None
    legend: None = None

    def savefig(self, *given: Any, **options: Any) -> None:
        """Write the figure as `matplotlib.figure.Figure.savefig`."""
        self.figure.savefig(*given, **options)

    @property  # type: ignore[misc]
    def __class__(self) -> Any:
        from control import ControlPlot

        return ControlPlot

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        from control import ControlPlot

        return getattr(ControlPlot(self.lines, self.axes, self.figure), name)


def figure_format(path: Path) -> str:
    """Return the format that the ending of a file says; `InputError` for one that is none."""
    from matplotlib.backend_bases import FigureCanvasBase

    kind = path.suffix.lstrip(".").lower()
    if kind not in FigureCanvasBase.get_supported_filetypes():
        raise InputError(
            f"a figure needs a file name such as boundary.png, .pdf or .svg; got {quoted(path)}"
        )
    return kind


def save_figure(plot: "ControlPlot", path: str | PathLike[str]) -> None:
    """Write a figure, whole or not at all, and close it, also where it cannot be written.

    Parameters
    ----------
    plot : control.ControlPlot
        The figure.
    path : str or path
        The file; its ending says the format.

    Raises
    ------
    InputError
        For what is no figure, an ending that is no format, and a file that cannot be written.
    """
    import matplotlib.pyplot as plt
    from matplotlib.figure import Figure

    if not isinstance(getattr(plot, "figure", None), Figure):
        raise InputError(f"plot must be a figure, such as of boundary_chart; got {shown(plot)}")
    try:
        path = a_path("path", path)
        kind = figure_format(path)
        drawn = BytesIO()  # not the file: on a full disk the writer of PDF fails in its own way
        with plt.rc_context({"svg.hashsalt": "tvclin"}):
            plot.figure.savefig(drawn, format=kind, dpi=150)
        write_whole(path, lambda target: Path(target).write_bytes(drawn.getvalue()))
    finally:
        plt.close(plot.figure)
