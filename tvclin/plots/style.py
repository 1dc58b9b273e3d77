"""The one style of all figures: colours, lines that stay apart in grey print, grid and panels.

pyplot is imported when the first figure is drawn, not before.

Marks are points of interest in a figure: a symbol, an entry of the legend, and a number next to it.
"""

import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from io import BytesIO
from os import PathLike
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, instance, shown, whole_number
from tvclin.base.errors import path as a_path
from tvclin.base.files import called as quoted
from tvclin.base.files import printable, write_whole
from tvclin.plots.curves import Column, Curves

if TYPE_CHECKING:
    from control import ControlPlot
    from matplotlib.axes import Axes
    from matplotlib.path import Path as Polyline
    from matplotlib.text import Annotation
    from matplotlib.transforms import Bbox


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


_DISTANCES = (11.0, 20.0, 34.0, 52.0, 74.0)
"""How far from its mark a number may stand, in points; the nearest clear place is taken."""
_DIRECTIONS = ((1, 1), (1, -1), (-1, 1), (-1, -1), (1, 0), (-1, 0), (0, 1), (0, -1))
_OUTSIDE, _LABEL, _MARK, _LEADER, _CURVE = 100.0, 40.0, 20.0, 10.0, 6.0
_MARK_SIZE = 7.0


@dataclass(frozen=True)
class Mark:
    """One point.

    `x`, `y`: where it is. `text`: what stands beside it; empty for a mark alone. `shape`: marker,
    as of matplotlib. `name`: entry of the legend; empty for none. `colour`: colour of the mark.
    """

    x: float
    y: float
    text: str = ""
    shape: str = "o"
    name: str = ""
    colour: str = INK

    def inside(self, axes: "Axes") -> bool:
        """Whether it lies in the frame."""
        (left, right), (low, high) = sorted(axes.get_xlim()), sorted(axes.get_ylim())
        return bool(left <= self.x <= right and low <= self.y <= high)


def numbered(mark: Mark, told: bool) -> Mark:
    """Return the mark with its number, or without it."""
    return mark if told else replace(mark, text="")


def named_once(marks: Iterable[Mark]) -> list[Mark]:
    """Return marks of one kind, of which the first alone has its entry in the legend."""
    return [replace(mark, name="") if k else mark for k, mark in enumerate(marks)]


def draw_marks(axes: "Axes", marks: Sequence[Mark]) -> list[Any]:
    """Draw the marks without their numbers, and return their lines."""
    lines: list[Any] = []
    for mark in marks:
        style: dict[str, Any] = {"mfc": "white", "mec": mark.colour, "mew": 1.8, "zorder": 6}
        label = mark.name or "_mark"
        lines += axes.plot(
            mark.x, mark.y, mark.shape, ls="", ms=_MARK_SIZE, label=label, clip_on=False, **style
        )
        lines[-1].set_clip_on(not mark.inside(axes))
    return lines


def write_numbers(*panels: tuple["Axes", Sequence[Mark]]) -> None:
    """Write the numbers beside the marks in the frame, clear of curves and of each other.

    `panels`: the panels of one figure, with their final frames, titles and legends, and the marks
    in each of them.
    """
    for axes, marks in panels:
        for mark in marks:
            if mark.text and mark.inside(axes):
                _write(axes, mark)
    place_numbers(*(axes for axes, _ in panels))


def place_numbers(*panels: "Axes") -> None:
    """Put the numbers of the panels of one figure where they hide least at its present size."""
    from matplotlib.text import Annotation

    _lay_out(panels)
    for axes in panels:
        points, curves = _points(axes), list(_outlines(axes))
        around = _Around(axes.get_window_extent(), curves, points, [])
        for note in axes.texts:
            if isinstance(note, Annotation) and note.arrow_patch is not None:
                around.taken.append(_put(note, axes.transData.transform(note.xy), around))


def _lay_out(panels: "Sequence[Axes]") -> None:
    """Put the panels of a figure where they will be drawn, without drawing them."""
    figure: Any = panels[0].figure
    figure.get_layout_engine().execute(figure)
    for axes in panels:
        axes.apply_aspect()


@dataclass(frozen=True, eq=False)
class _Around:
    """What a number must keep clear of, in pixels."""

    frame: "Bbox"
    curves: "list[tuple[Polyline, float]]"
    points: FloatArray
    taken: "list[Bbox]"


def _write(axes: "Axes", mark: Mark) -> None:
    note = axes.annotate(
        mark.text,
        (mark.x, mark.y),
        xytext=(_DISTANCES[0], _DISTANCES[0]),
        textcoords="offset points",
        fontsize=9,
        color=INK,
        linespacing=1.1,
        zorder=7,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0},
        arrowprops={"arrowstyle": "-", "color": "0.35", "lw": 0.8, "shrinkB": 4.0, "shrinkA": 0.0},
    )
    note.set_in_layout(False)


def _put(note: "Annotation", point: FloatArray, around: _Around) -> "Bbox":
    """Put one number where it hides least, and return the place it takes, in pixels."""
    from matplotlib.text import Text
    from matplotlib.transforms import Bbox

    extent = Text.get_window_extent(note)  # of the text alone, without the line to the mark
    size, scale = np.array([extent.width, extent.height]), note.figure.dpi / 72.0
    found: list[Any] = []
    for distance in _DISTANCES:
        for direction in np.array(_DIRECTIONS):
            offset = distance * direction / np.hypot(*direction) ** 0.5
            corner = point + offset * scale + size * (direction - 1) / 2.0
            place = Bbox.from_bounds(*(corner - 2.0), *(size + 4.0))
            found.append(
                (
                    _cost(place, point, around) + 0.02 * distance,
                    *(len(found), offset, direction, place),
                )
            )
        if min(one[0] for one in found) <= 0.02 * distance:  # hides nothing: none is better
            break
    _, _, offset, (right, up), place = min(found, key=lambda one: one[:2])
    note.set_position(tuple(offset))
    note.set_horizontalalignment(("center", "left", "right")[int(right)])
    note.set_verticalalignment(("center", "bottom", "top")[int(up)])
    return place


def _cost(place: "Bbox", point: FloatArray, around: _Around) -> float:
    from matplotlib.path import Path as Polyline

    frame = around.frame
    leader = Polyline([0.5 * np.add(place.min, place.max), point])
    out = place.x0 < frame.x0 or place.x1 > frame.x1 or place.y0 < frame.y0 or place.y1 > frame.y1
    room, points = place.padded(_MARK_SIZE / 2.0), around.points
    covered = np.all((points >= room.min) & (points <= room.max), axis=-1)
    return (
        _OUTSIDE * out
        + _LABEL * sum(bool(place.overlaps(other)) for other in around.taken)
        + _MARK * int(np.sum(covered))
        + _LEADER * sum(leader.intersects_bbox(other, filled=True) for other in around.taken)
        + sum(cost for path, cost in around.curves if path.intersects_bbox(place, filled=False))
    )


def _points(axes: "Axes") -> FloatArray:
    """The marks of a panel in pixels, ``(n, 2)``."""
    found = [np.zeros((0, 2))]
    for line in axes.get_lines():
        if line.get_linestyle() == "None":
            found.append(line.get_transform().transform(np.column_stack(line.get_data())))
    return np.concatenate(found)


def _outlines(axes: "Axes") -> Iterator[tuple["Polyline", float]]:
    """The curves and boxes of a panel in pixels, with what it costs to hide them."""
    from matplotlib.path import Path as Polyline

    for line in axes.get_lines():
        if line.get_linestyle() == "None" or line.get_zorder() < 1.0:
            continue
        points = np.ma.filled(np.ma.column_stack(line.get_data(orig=False)), np.nan)
        points = line.get_transform().transform(points.astype(float))
        points = points[np.all(np.isfinite(points), axis=-1)]
        if len(points) > 1:
            yield Polyline(points), _CURVE
    for patch in axes.patches:
        if patch.get_zorder() >= 1.0:
            yield patch.get_transform().transform_path(patch.get_path()), _CURVE / 2.0
