"""Picture of an answer: axes and ticks are drawn once, and then only the lines that moved."""

import io
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.plots.style import COLOURS, INK, WARM
from tvclin.show.explorer.answer import Answer
from tvclin.show.explorer.choices import LONGEST, round_up

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_FRAME_OVER_ATTITUDE = 1.1
"""Ordinate of a frame over the largest attitude shown, before rounding."""
_MAX_OVER_FRAME = 20.0
"""Largest ordinate drawn relative to the frame; a longer curve would stall the renderer."""
_MAX_ATTITUDE_DEG = 90.0
"""Largest attitude [deg] of a frame."""

_TITLE, _LABEL = 0.012, 0.06
"""Distance of a panel from its title and from its label, in heights of the figure."""

_SLOTS = {
    "boundary": (0.0, 0.0, 0.5, 1.0),
    "attitude": (0.5, 0.546, 0.5, 0.454),
    "deflection": (0.5, 0.0, 0.5, 0.546),
}
"""Slot of each panel with its labels: left, bottom, width and height, as parts of the figure."""

Ends = tuple[float, float]


@dataclass(eq=False)
class Picture:
    """The boundary, the attitude and the deflection; make it with `new_picture`.

    `lines`: the curves, which move; `frames`: limits of abscissa and ordinate of each panel.
    """

    canvas: Any
    axes: dict[str, "Axes"]
    lines: dict[str, Any]
    frames: dict[str, tuple[Ends, Ends]] = field(default_factory=dict)
    _empty: Any = None

    def png(self, answer: Answer) -> bytes:
        """Return the picture of an answer as PNG; parts without an answer stay empty."""
        from PIL.Image import fromarray

        data = curves(answer)
        frames = _frames(answer, data)
        if frames != self.frames:
            self._frame(frames)
        self.canvas.restore_region(self._empty)
        for name, line in self.lines.items():
            panel = name.partition(".")[0]
            beyond = _MAX_OVER_FRAME * frames[panel][1][1]
            x, y = data[name]
            line.set_data(x, np.clip(y, -beyond, beyond))
            self.axes[panel].draw_artist(line)
        made = io.BytesIO()
        opaque = fromarray(np.asarray(self.canvas.buffer_rgba())).convert("RGB")
        opaque.save(made, "PNG", compress_level=1)
        return made.getvalue()

    def _frame(self, frames: dict[str, tuple[Ends, Ends]]) -> None:
        """Draw the panels whose frames have changed; the others stay as they are."""
        from matplotlib.patches import Rectangle

        if not self.frames:
            self.canvas.draw()
            self._empty = self.canvas.copy_from_bbox(self.canvas.figure.bbox)
        self.canvas.restore_region(self._empty)
        renderer, transform = self.canvas.get_renderer(), self.canvas.figure.transFigure
        for name, (across, up) in frames.items():
            if (across, up) != self.frames.get(name):
                x, y, width, height = _SLOTS[name]
                blank = Rectangle(
                    (x, y),
                    width,
                    height,
                    color=self.canvas.figure.get_facecolor(),
                    lw=0,
                    transform=transform,
                )
                blank.draw(renderer)
                self.axes[name].set(xlim=across, ylim=up)
                self.axes[name].draw(renderer)
        self._empty = self.canvas.copy_from_bbox(self.canvas.figure.bbox)
        self.frames = frames


def new_picture() -> Picture:
    """Return an empty picture, without pyplot."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.4, 4.6), dpi=120)
    grid = figure.add_gridspec(
        2, 2, left=0.065, right=0.985, bottom=0.12, top=0.93, wspace=0.22, hspace=0.22
    )
    axes = {
        "boundary": figure.add_subplot(grid[:, 0]),
        "attitude": figure.add_subplot(grid[0, 1]),
        "deflection": figure.add_subplot(grid[1, 1]),
    }
    headings = {
        "boundary": "needed (curve), limit (dashed) [deg]",
        "attitude": "attitude, wind (dotted) [deg]",
        "deflection": "deflection, limits (dashed) [deg]",
    }
    for name, panel in axes.items():
        tall = panel.get_position().height
        panel.set_title(headings[name], fontsize="medium", loc="left", y=1.0 + _TITLE / tall)
        panel.grid(color="0.85", lw=0.8)
        panel.set_axisbelow(True)
        panel.locator_params(nbins=5)
        for axis in (panel.xaxis, panel.yaxis):  # placed by hand, titles too: searching takes long
            axis.set_label_coords(0.5, -_LABEL / tall)
    axes["attitude"].tick_params(labelbottom=False)  # as below
    axes["boundary"].set_xlabel("wind duration [s]")
    axes["deflection"].set_xlabel("time [s]")
    return Picture(FigureCanvasAgg(figure), axes, _lines(axes))


def _lines(axes: dict[str, "Axes"]) -> dict[str, Any]:
    """Return the empty lines of the figure by name, to be set by each answer."""
    edge = {"color": WARM, "ls": "--", "lw": 1.4}
    looks: dict[str, dict[str, Any]] = {
        "boundary.curve": {"color": COLOURS[0], "lw": 2.0},
        "boundary.limit": edge,
        "boundary.point": {"color": INK, "marker": "o", "ms": 7.0, "ls": ""},
        "boundary.have": {"color": WARM, "marker": "D", "ms": 6.0, "ls": ""},
        "attitude.wind": {"color": COLOURS[0], "ls": ":", "lw": 2.0},
        "attitude.attitude": {"color": INK, "lw": 2.0},
        "deflection.upper": edge,
        "deflection.lower": edge,
        "deflection.deflection": {"color": WARM, "lw": 2.0},
    }
    return {
        name: axes[name.partition(".")[0]].plot([], [], animated=True, **look)[0]
        for name, look in looks.items()
    }


def curves(answer: Answer) -> dict[str, tuple[Any, Any]]:
    """Return abscissas [s] and ordinates [deg] of every line, by panel and name."""
    c, m, deg = answer.choices, answer.motion, np.degrees
    long = c.wind.duration
    nothing: tuple[Any, Any] = (np.zeros(0), np.zeros(0))
    limit = float(deg(c.limit))
    lines = dict.fromkeys(("boundary.curve", "boundary.point"), nothing)
    if answer.boundary is not None and answer.required is not None:
        lines["boundary.curve"] = answer.durations, deg(answer.boundary)
        lines["boundary.point"] = [long], deg([answer.required])
    lines["boundary.limit"] = [0.0, LONGEST], [limit, limit]
    lines["boundary.have"] = [long], [limit]
    ends = [0.0 if m is None else float(m.time[0]), long if m is None else float(m.time[-1])]
    lines["deflection.upper"] = ends, [limit, limit]
    lines["deflection.lower"] = ends, [-limit, -limit]
    rows = {
        "attitude.wind": None if m is None else m.wind,
        "attitude.attitude": None if m is None else m.attitude,
        "deflection.deflection": None if m is None else m.deflection,
    }
    for name, row in rows.items():
        lines[name] = nothing if m is None or row is None else (m.time, deg(row))
    return lines


def _frames(answer: Answer, data: dict[str, tuple[Any, Any]]) -> dict[str, tuple[Ends, Ends]]:
    """Return the frames, rounded so that they seldom change while a slider moves.

    A curve that leaves its frame after the wind, as of a diverging vehicle, is cut.
    """
    c = answer.choices
    limit, calm = float(np.degrees(c.limit)), c.wind.duration
    time, attitude = (np.asarray(array) for array in data["attitude.attitude"])
    shown = [*np.abs(attitude[time <= calm]), *np.abs(data["attitude.wind"][1])]
    tall = round_up(min(_FRAME_OVER_ATTITUDE * max(shown, default=1.0), _MAX_ATTITUDE_DEG))
    needed = max([limit, *data["boundary.curve"][1], *data["boundary.point"][1]])
    long = (0.0, round_up(max(float(time[-1]) if time.size else calm, 1.0)))
    deflection = round_up(1.05 * limit)
    return {
        "boundary": ((0.0, LONGEST), (0.0, round_up(1.05 * needed))),
        "attitude": (long, (-tall, tall)),
        "deflection": (long, (-deflection, deflection)),
    }
