"""Style of all figures: colours, line styles that differ in grey print, grid, panels, and marks.

pyplot is imported when the first figure is drawn, not before.

Marks are points of interest in a figure: a symbol, an entry of the legend, and a number next to it,
which `number_layout` places.
"""

import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
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
"""Characters in a line of a title over several panels, and over one panel with its legend."""

Style = dict[str, Any]
QUANTITIES: dict[str, Style] = {
    "attitude": {"color": INK, "ls": "-", "lw": 2.0},
    "flight_path_angle": {"color": COLOURS[1], "ls": LINES[3], "lw": 1.8},
    "angle_of_attack": {"color": COLOURS[4], "ls": "-.", "lw": 1.8},
    "attitude_rate": {"color": INK, "ls": LINES[3], "lw": 1.8},
    "deflection": {"color": WARM, "ls": "-", "lw": 2.0},
    "wind": {"color": COLOURS[0], "ls": ":", "lw": 2.2},
}
"""Line styles of quantities over time, in every figure."""
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


_ON_FRAME = 1.0
"""Height of a title over its panel, which matplotlib otherwise finds from all tick labels."""
_MAX_PANELS = 16
"""Largest number of panels in one row of a figure."""


@dataclass(frozen=True)
class Look:
    """Layout of a figure.

    `title`: title of the figure. `ordinate`: label of the ordinate with its unit, for all panels or
    by panel. `styles`: line style in matplotlib's terms, by label of the curve. `legend`: heading
    of the legend. `limits`: ends of the ordinate, by panel. `across`: number of panels in one row.
    """

    title: str
    ordinate: str | Mapping[str, str]
    styles: Mapping[str, Style]
    legend: str = ""
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    across: int = 2

    def __post_init__(self) -> None:
        """Check the title and the number of panels in a row."""
        instance("title", self.title, str, "a text")
        if not 1 <= whole_number("across", self.across) <= _MAX_PANELS:
            raise InputError(f"across must be from 1 to {_MAX_PANELS}; got {shown(self.across)}")


def draw(curves: Curves, look: Look) -> "ControlPlot":
    """Return the figure of curves, a panel for each heading, with one legend.

    `curves`: the numbers. `look`: the layout. `InputError` for an abscissa of fewer than two
    values.
    """
    instance("curves", curves, Curves, "the numbers of a figure")
    finite = curves.abscissa[np.isfinite(curves.abscissa)]
    if not finite.size or not np.ptp(finite) > 0.0:
        label, came = pretty(curves.abscissa_label), shown(curves.abscissa)
        raise InputError(f"{label} must hold two different values or more; got {came}")
    for column in curves.columns:
        if column.label not in look.styles:
            labels = ", ".join(look.styles)
            raise InputError(f"curves must be among {labels}; got {shown(column.label)}")
    panels = curves.panels
    shape, axes = new_panels(len(panels), look.across)
    lines: list[Any] = []
    for panel, (heading, columns) in zip(axes, panels.items(), strict=False):
        for column in columns:
            style = look.styles[column.label]
            label = pretty(literal(column.label))
            lines += panel.plot(curves.abscissa, column.values, label=label, **style)
        _label_panel(panel, curves, look, heading)
        _write_notes(panel, columns)
    for empty in axes[len(panels) :]:
        empty.set_axis_off()
    if len(panels) > 1:
        axes[0].figure.suptitle(pretty(literal(broken(look.title))))
    else:
        axes[0].set_title(pretty(literal(broken(look.title, _NARROW))), y=_ON_FRAME)
    # one entry of the legend for each label, in the order of their first lines
    first = {line.get_label(): line for line in reversed(lines)}
    handles = [first[label] for label in dict.fromkeys(line.get_label() for line in lines)]
    axes[0].figure.legend(handles=handles, title=pretty(look.legend), loc="outside right center")
    return control_plot(lines, axes.reshape(shape), curves)


def _label_panel(axes: "Axes", curves: Curves, look: Look, heading: str) -> None:
    """Set labels, limits, heading and grid of the axes of a panel.

    `curves`: numbers of the figure. `look`: its layout. `heading`: heading of the panel, or empty.
    """
    ordinate = look.ordinate if isinstance(look.ordinate, str) else look.ordinate[heading]
    finite = curves.abscissa[np.isfinite(curves.abscissa)]
    axes.set(
        xlabel=pretty(curves.abscissa_label),
        ylabel=pretty(ordinate),
        xlim=(float(finite.min()), float(finite.max())),
    )
    if heading:
        axes.set_title(pretty(heading), fontsize="medium", y=_ON_FRAME)
    if heading in look.limits:
        axes.set_ylim(*look.limits[heading])
    fine_grid(axes)


def _write_notes(axes: "Axes", columns: Sequence[Column]) -> None:
    """Write the notes of the curves `columns` in the lower right corner of the axes of a panel.

    Curves with the same note share it, below their labels.
    """
    notes: dict[str, list[str]] = {}
    for column in columns:
        if column.note:
            notes.setdefault(column.note, []).append(column.label)
    text = "\n".join(f"{', '.join(labels)}:\n{note}" for note, labels in notes.items())
    if text:
        box = {"facecolor": "white", "edgecolor": "0.6", "boxstyle": "round,pad=0.3"}
        position: Style = {"ha": "right", "va": "bottom", "transform": axes.transAxes, "bbox": box}
        axes.text(0.97, 0.04, pretty(text), fontsize=9, **position)


def broken(words: str, width: int = _WIDE) -> str:
    """Return a text in lines of a width [characters], broken only at commas.

    `words`: the text, whose own lines stay apart.
    """
    # blanks at which no line is broken, \u00a0, but for those after commas
    lines = words.replace(" ", "\u00a0").replace(",\u00a0", ", ").split("\n")
    return "\n".join(fill(line, width) for line in lines).replace("\u00a0", " ")


def broken_lines(labels: Sequence[str], width: float = 1.6) -> dict[str, Style]:
    """Return a line style for each label; they differ in colour and in grey print.

    `width`: width of the lines [points].
    """
    pairs = zip(labels, cycle(COLOURS), cycle(LINES), strict=False)
    return {label: {"color": colour, "ls": line, "lw": width} for label, colour, line in pairs}


def law_styles(names: Iterable[str]) -> dict[str, Style]:
    """Return the line styles of laws, of five at most, by name, with a marker at each number."""
    kinds = zip(names, (*COLOURS[:3], COLOURS[4], WARM), LINES, strict=False)
    return {
        name: {"color": colour, "ls": line, "lw": 1.8, "marker": "o", "ms": 3.5}
        for name, colour, line in kinds
    }


def new_axes() -> "Axes":
    """Return the axes of a figure of one panel, with room for a legend at its right."""
    import matplotlib.pyplot as plt

    _, axes = plt.subplots(figsize=(8.6, 5.6), layout="constrained")
    return axes


def new_panels(count: int, across: int) -> tuple[tuple[int, int], Any]:
    """Return the shape (rows, columns) of `count` panels and their axes, ``(rows * columns,)``.

    `across`: largest number of panels in one row.
    """
    import matplotlib.pyplot as plt

    columns = min(count, across)
    rows = -(-count // columns)
    width, height = 3.0 + 4.4 * columns, 0.6 + 3.9 * rows  # [inch]
    if columns == 1:
        width, height = 8.6, 5.6 if rows == 1 else 0.8 + 2.7 * rows
    _, axes = plt.subplots(
        rows, columns, figsize=(width, height), layout="constrained", squeeze=False
    )
    return (rows, columns), axes.ravel()


def fine_grid(axes: "Axes") -> None:
    """Draw the grid of axes, fine enough to read values off."""
    axes.minorticks_on()
    axes.grid(which="major", color="0.75", lw=0.8)
    axes.grid(which="minor", color="0.9", lw=0.5)
    axes.set_axisbelow(True)


def literal(text: str) -> str:
    """Return a text without control characters, in which $ does not begin a formula."""
    return printable(text).replace("$", r"\$")


def pretty(text: str) -> str:
    """Return a text, a label, with the report's symbols, and words instead of identifiers."""
    for plain, symbol in _SYMBOLS.items():
        text = text.replace(plain, symbol)
    return text


def called(name: str, text: str) -> str:
    """Return a title, `text`, with the name of the vehicle, if any, in a line above."""
    instance("name", name, str, "a text")
    return f"{name}\n{text}" if name else text


def cycle(items: Sequence[Any]) -> list[Any]:
    """Return the items repeated eight times, for more curves than a figure can show."""
    return list(items) * 8  # a list, whose items are also looked up by number


def control_plot(lines: list[Any], axes: Any, curves: Curves | None = None) -> "ControlPlot":
    """Return lines and axes as python-control's plot, with the numbers it shows as `.curves`.

    Its lines are a table of lists in the shape of the panels. While python-control is not imported
    the plot is a substitute of the same attributes.
    """
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
    """Substitute of `ControlPlot` while python-control is not imported, which takes a second.

    It is an instance of it to `isinstance`, and delegates further attributes to it.
    """

    lines: Any
    axes: Any
    figure: Any
    curves: Curves | None
    legend: None = None

    def savefig(self, *positional: Any, **options: Any) -> None:
        """Write the figure as `matplotlib.figure.Figure.savefig`."""
        self.figure.savefig(*positional, **options)

    @property  # type: ignore[misc]
    def __class__(self) -> Any:
        """Class for `isinstance`: `ControlPlot` of python-control, imported on first use."""
        from control import ControlPlot

        return ControlPlot

    def __getattr__(self, name: str) -> Any:
        """Return a further attribute of the figure as a `ControlPlot`, by its name."""
        if name.startswith("__"):
            raise AttributeError(name)
        from control import ControlPlot

        return getattr(ControlPlot(self.lines, self.axes, self.figure), name)


def figure_format(path: Path) -> str:
    """Return the format of a figure by the ending of its file, such as "png".

    `path`: the file. `InputError` for an unknown ending.
    """
    from matplotlib.backend_bases import FigureCanvasBase

    kind = path.suffix.lstrip(".").lower()
    if kind not in FigureCanvasBase.get_supported_filetypes():
        raise InputError(
            f"a figure needs a file name such as boundary.png, .pdf or .svg; got {quoted(path)}"
        )
    return kind


def save_figure(plot: "ControlPlot", path: str | PathLike[str]) -> None:
    """Write a figure, whole or not at all, and close it even if it cannot be written.

    Parameters
    ----------
    plot : control.ControlPlot
        The figure.
    path : str or path
        The file; its ending says the format.

    Raises
    ------
    InputError
        For another type than a figure, an unknown ending, and a file that cannot be written.
    """
    import matplotlib.pyplot as plt
    from matplotlib.figure import Figure

    if not isinstance(getattr(plot, "figure", None), Figure):
        raise InputError(f"plot must be a figure, such as of boundary_chart; got {shown(plot)}")
    try:
        path = a_path("path", path)
        kind = figure_format(path)
        with plt.rc_context({"svg.hashsalt": "tvclin"}):
            options = {"pil_kwargs": {"compress_level": _COMPRESSION}} if kind == "png" else {}
            drawn = figure_bytes(plot.figure, format=kind, dpi=_DPI, **options)
        write_whole(path, lambda target: Path(target).write_bytes(drawn))
    finally:
        plt.close(plot.figure)


def figure_bytes(figure: Any, **options: Any) -> bytes:
    """Return the file of a figure in memory; its layout is computed once and stays.

    `savefig` of a figure with a layout engine draws all of it twice. In memory, since on a full
    disk the writer of PDF fails in its own way. `options`: options of `savefig`.
    """
    from matplotlib.ticker import NullFormatter, NullLocator

    if (engine := figure.get_layout_engine()) is not None:
        # minor ticks without labels take no room, but most of the time
        axis_of_panels = [axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
        unlabelled = [
            (axis, axis.get_minor_locator())
            for axis in axis_of_panels
            if isinstance(axis.get_minor_formatter(), NullFormatter)
        ]
        for axis, _ in unlabelled:
            axis.set_minor_locator(NullLocator())
        engine.execute(figure)
        for axis, locator in unlabelled:
            axis.set_minor_locator(locator)
        figure.set_layout_engine(None)
    drawn = BytesIO()
    figure.savefig(drawn, **options)
    return drawn.getvalue()


_DPI = 150
"""Dots per inch of a figure in pixels."""
_COMPRESSION = 3
"""Level of compression of PNG: with 6, the usual one, a figure takes twice as long to write, and is
a twentieth smaller."""
_MARK_SIZE = 7.0
"""Diameter of a mark [points]."""
_OFFSET = 11.0
"""First distance of a number from its mark, to the right and up [points]."""


@dataclass(frozen=True)
class Mark:
    """Point of interest in a figure.

    `x`, `y`: coordinates. `text`: number or name next to it; empty without. `shape`: marker of
    matplotlib. `name`: entry of the legend; empty without. `colour`: colour of the mark.
    """

    x: float
    y: float
    text: str = ""
    shape: str = "o"
    name: str = ""
    colour: str = INK

    def inside(self, axes: "Axes") -> bool:
        """Return whether the mark lies within the frame of axes."""
        (x_min, x_max), (low, high) = sorted(axes.get_xlim()), sorted(axes.get_ylim())
        return bool(x_min <= self.x <= x_max and low <= self.y <= high)


def numbered(mark: Mark, with_number: bool) -> Mark:
    """Return the mark with its number, or without it."""
    return mark if with_number else replace(mark, text="")


def named_once(marks: Iterable[Mark]) -> list[Mark]:
    """Return marks of one kind, with an entry in the legend for the first alone."""
    return [replace(mark, name="") if k else mark for k, mark in enumerate(marks)]


def draw_marks(axes: "Axes", marks: Sequence[Mark]) -> list[Any]:
    """Return the drawn lines of marks in axes, without their numbers."""
    lines: list[Any] = []
    for mark in marks:
        style: dict[str, Any] = {"mfc": "white", "mec": mark.colour, "mew": 1.8, "zorder": 6}
        label = mark.name or "_mark"  # matplotlib omits labels with _ from the legend
        lines += axes.plot(
            mark.x, mark.y, mark.shape, ls="", ms=_MARK_SIZE, label=label, clip_on=False, **style
        )
        lines[-1].set_clip_on(not mark.inside(axes))  # whole on the edge, hidden outside
    return lines


def write_numbers(*panels: tuple["Axes", Sequence[Mark]]) -> None:
    """Write the numbers of the marks in the frame; the layout of the figure then places them.

    `panels`: the panels of one figure, with their final frames, and the marks in each of them.
    """
    from tvclin.plots.number_layout import NumberLayout  # late, with matplotlib

    leader = {"arrowstyle": "-", "color": "0.35", "lw": 0.8, "shrinkB": 4.0, "shrinkA": 0.0}
    for axes, marks in panels:
        for mark in marks:
            if not (mark.text and mark.inside(axes)):
                continue
            note = axes.annotate(
                mark.text,
                (mark.x, mark.y),
                xytext=(_OFFSET, _OFFSET),
                textcoords="offset points",
                fontsize=9,
                color=INK,
                linespacing=1.1,
                zorder=7,
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0},
                arrowprops=leader,
            )
            note.set_in_layout(False)
    figure: Any = panels[0][0].figure
    figure.set_layout_engine(NumberLayout())
