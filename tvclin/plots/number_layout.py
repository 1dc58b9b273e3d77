"""Layout of a figure whose marks have numbers: each clear of curves and of the other numbers.

matplotlib places legends clear of the curves, but no other text.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.path import Path
from matplotlib.text import Annotation, Text
from matplotlib.transforms import Bbox

from tvclin.base.arrays import FloatArray

_DISTANCES = (11.0, 20.0, 34.0, 52.0, 74.0)
"""Distances of a number from its mark, in points, the preferred first."""
_DIRECTIONS = ((1, 1), (1, -1), (-1, 1), (-1, -1), (1, 0), (-1, 0), (0, 1), (0, -1))
"""Directions from a mark to its number, to the right and up, the preferred first."""
_OUTSIDE, _LABEL, _MARK, _LEADER, _CURVE = 100.0, 40.0, 20.0, 10.0, 6.0
"""Costs of a number outside the frame, and over numbers, marks, their leaders, and curves."""
_DISTANCE_COST = 0.02
"""Cost of a number for each point of distance from its mark: less than for hiding a curve."""
_BOX_MARGIN = 2.0
"""Margin of the box of a number around its text [pixels]."""
_MARK_MARGIN = 3.5
"""Margin of the box around the middle of a mark that it should not hide [pixels]."""


class NumberLayout(ConstrainedLayoutEngine):
    """Constrained layout, which then places the numbers by their cost: overlaps and distance."""

    def execute(self, fig: Any) -> Any:
        """Lay out a figure, and place the numbers of its panels."""
        grids = super().execute(fig)
        for axes in fig.axes:
            axes.apply_aspect()
        for axes in fig.axes:
            points, curves = _points(axes), list(_outlines(axes))
            obstacles = _Obstacles(axes.get_window_extent(), curves, points, labels=[])
            for note in axes.texts:
                if isinstance(note, Annotation) and note.arrow_patch is not None:
                    box = _put(note, axes.transData.transform(note.xy), obstacles)
                    obstacles.labels.append(box)
        return grids


@dataclass(frozen=True, eq=False)
class _Obstacles:
    """Frame, curves, marks and other numbers of a panel, in pixels."""

    frame: Bbox
    curves: list[tuple[Path, float]]
    points: FloatArray
    labels: list[Bbox]


def _put(note: Annotation, point: FloatArray, obstacles: _Obstacles) -> Bbox:
    """Return the box of a number, in pixels, after moving it to the place of least cost.

    `note`: the number, as matplotlib's annotation. `point`: its mark in pixels, ``(2,)``.
    `obstacles`: frame, curves, marks and numbers, which it should not hide. Of places of equal cost
    the first one counts. The annotation stores its place as an offset from the mark in points
    (1/72 inch), and the alignment of its text towards the mark.
    """
    extent = Text.get_window_extent(note)  # of the text alone, without the line to the mark
    size, scale = np.array([extent.width, extent.height]), note.figure.dpi / 72.0
    candidates: list[Any] = []
    for distance in _DISTANCES:
        for direction in np.array(_DIRECTIONS):
            # in points; diagonals go a little farther than straight offsets
            offset = distance * direction / np.hypot(*direction) ** 0.5
            # lower left, in pixels: the text begins, is centred or ends at the offset
            corner = point + offset * scale + size * (direction - 1) / 2.0
            box = Bbox.from_bounds(*(corner - _BOX_MARGIN), *(size + 2.0 * _BOX_MARGIN))
            cost = _cost(box, point, obstacles) + _DISTANCE_COST * distance
            candidates.append((cost, len(candidates), offset, direction, box))
        if min(candidates)[0] <= _DISTANCE_COST * distance:  # hides nothing: none is better
            break
    _, _, offset, (x_sign, y_sign), box = min(candidates, key=lambda candidate: candidate[:2])
    note.set_position(tuple(offset))
    # items by sign: 0, 1 and, as the last item, -1
    note.set_horizontalalignment(("center", "left", "right")[int(x_sign)])
    note.set_verticalalignment(("center", "bottom", "top")[int(y_sign)])
    return box


def _cost(box: Bbox, point: FloatArray, obstacles: _Obstacles) -> float:
    """Return the cost of a number's box, in pixels, over the obstacles of its panel.

    `point`: mark of the number in pixels, ``(2,)``, to which a leader is drawn. Each overlap adds
    its cost: with the frame, other numbers and their leaders, marks, and curves.
    """
    frame = obstacles.frame
    leader = Path([0.5 * np.add(box.min, box.max), point])
    out = box.x0 < frame.x0 or box.x1 > frame.x1 or box.y0 < frame.y0 or box.y1 > frame.y1
    room, points = box.padded(_MARK_MARGIN), obstacles.points
    covered = np.all((points >= room.min) & (points <= room.max), axis=-1)
    return (
        _OUTSIDE * out
        + _LABEL * sum(bool(box.overlaps(label)) for label in obstacles.labels)
        + _MARK * int(np.sum(covered))
        + _LEADER * sum(leader.intersects_bbox(label, filled=True) for label in obstacles.labels)
        + sum(cost for path, cost in obstacles.curves if path.intersects_bbox(box, filled=False))
    )


def _points(axes: Axes) -> FloatArray:
    """Return the marks drawn in the axes of a panel, in pixels, ``(n, 2)``."""
    points = [np.zeros((0, 2))]
    for line in axes.get_lines():
        if line.get_linestyle() == "None":
            points.append(line.get_transform().transform(np.column_stack(line.get_data())))
    return np.concatenate(points)


def _outlines(axes: Axes) -> Iterator[tuple[Path, float]]:
    """Yield the curves and boxes in axes in pixels, each with the cost of hiding it.

    What is drawn below the order (zorder) 1, such as grid and levels, may be hidden at no cost; a
    box costs half as much as a curve.
    """
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
