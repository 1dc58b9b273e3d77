"""Points of interest in a figure: a mark, an entry of the legend, and a number beside it.

The numbers are put where they hide neither a curve nor each other.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.plots.style import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.path import Path
    from matplotlib.text import Annotation
    from matplotlib.transforms import Bbox


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
    curves: "list[tuple[Path, float]]"
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
    from matplotlib.path import Path

    frame = around.frame
    leader = Path([0.5 * np.add(place.min, place.max), point])
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


def _outlines(axes: "Axes") -> Iterator[tuple["Path", float]]:
    """The curves and boxes of a panel in pixels, with what it costs to hide them."""
    from matplotlib.path import Path

    for line in axes.get_lines():
        if line.get_linestyle() == "None" or line.get_zorder() < 1.0:
            continue
        points = np.ma.filled(np.ma.column_stack(line.get_data(orig=False)), np.nan)
        points = line.get_transform().transform(points.astype(float))
        points = points[np.all(np.isfinite(points), axis=-1)]
        if len(points) > 1:
            yield Path(points), _CURVE
    for patch in axes.patches:
        if patch.get_zorder() >= 1.0:
            yield patch.get_transform().transform_path(patch.get_path()), _CURVE / 2.0
