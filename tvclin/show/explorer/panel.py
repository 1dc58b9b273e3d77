"""The panel of widgets, its response to a moved control, and the picture of the answer.

Axes and ticks of the picture are drawn once, and then only the lines that moved.
"""

import asyncio
import io
from contextlib import suppress
from dataclasses import dataclass, field
from html import escape
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.errors import InputError, missing
from tvclin.control.autopilot.design_rules import GIVEN_GAINS
from tvclin.control.laws.registry import AUTOPILOT
from tvclin.plots.style import COLOURS, INK, WARM
from tvclin.requirement.case_requirement import pulse_of
from tvclin.show.explorer.answer import Answer, answer
from tvclin.show.explorer.choices import (
    LONGEST,
    Choices,
    Values,
    choices_of,
    idle_controls,
    lists,
    round_up,
    sliders,
    switches,
    with_numerical_gains,
    write_study,
)
from tvclin.show.explorer.lab import end, is_open
from tvclin.studyfile.read import load_study, vehicle_source
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.linear_vehicle import AnyVehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.vehicle.vehicle_file import list_vehicles, load_vehicle

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
        """Return the picture of an answer as PNG; parts without an answer stay empty.

        Curves are cut at `_MAX_OVER_FRAME` times the top of their panel.
        """
        from PIL.Image import fromarray

        data = curves(answer)
        frames = _frames(answer, data)
        if frames != self.frames:
            self._frame(frames)
        self.canvas.restore_region(self._empty)
        for name, line in self.lines.items():
            panel, _, _ = name.partition(".")  # names are panel.line
            _, (_, top) = frames[panel]
            beyond = _MAX_OVER_FRAME * top
            x, y = data[name]
            line.set_data(x, np.clip(y, -beyond, beyond))
            self.axes[panel].draw_artist(line)
        picture = io.BytesIO()
        opaque = fromarray(np.asarray(self.canvas.buffer_rgba())).convert("RGB")
        opaque.save(picture, "PNG", compress_level=1)
        return picture.getvalue()

    def _frame(self, frames: dict[str, tuple[Ends, Ends]]) -> None:
        """Draw the panels whose frames have changed; the others stay as they are.

        `frames`: limits of abscissa and ordinate by panel. The drawn axes, without curves, are kept
        as the empty picture on which `png` draws.
        """
        from matplotlib.patches import Rectangle

        if not self.frames:
            self.canvas.draw()
            self._empty = self.canvas.copy_from_bbox(self.canvas.figure.bbox)
        self.canvas.restore_region(self._empty)
        renderer, figure = self.canvas.get_renderer(), self.canvas.figure
        paper = {"color": figure.get_facecolor(), "lw": 0, "transform": figure.transFigure}
        for name, (across, up) in frames.items():
            if (across, up) != self.frames.get(name):
                x, y, width, height = _SLOTS[name]
                Rectangle((x, y), width, height, **paper).draw(renderer)
                self.axes[name].set(xlim=across, ylim=up)
                self.axes[name].draw(renderer)
        self._empty = self.canvas.copy_from_bbox(self.canvas.figure.bbox)
        self.frames = frames


def new_picture() -> Picture:
    """Return an empty picture, without pyplot.

    The boundary stands at the left, attitude above deflection at the right. Labels have fixed
    places, since matplotlib's search for them takes long.
    """
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
    """Return the empty lines in axes by name, to be set by each answer; `axes`: panels by name.

    A name is the panel and the line in it, as in "boundary.limit". An animated line is drawn by
    `Picture.png` alone.
    """
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
    """Return abscissas [s] and ordinates [deg] of every line of an answer, by panel and name.

    A line without an answer is empty: two arrays of no numbers. The limit is drawn nevertheless.
    """
    motion, duration = answer.motion, answer.choices.wind.duration
    nothing: tuple[Any, Any] = (np.zeros(0), np.zeros(0))
    limit = float(np.degrees(answer.choices.limit))
    lines = dict.fromkeys(("boundary.curve", "boundary.point"), nothing)
    if answer.boundary is not None and answer.required is not None:
        lines["boundary.curve"] = answer.durations, np.degrees(answer.boundary)
        lines["boundary.point"] = [duration], np.degrees([answer.required])
    lines["boundary.limit"] = [0.0, LONGEST], [limit, limit]
    lines["boundary.have"] = [duration], [limit]  # the limit at the chosen duration
    ends = [0.0, duration] if motion is None else [float(motion.time[0]), float(motion.time[-1])]
    lines["deflection.upper"] = ends, [limit, limit]
    lines["deflection.lower"] = ends, [-limit, -limit]
    for name in ("attitude.wind", "attitude.attitude", "deflection.deflection"):
        quantity = name.rpartition(".")[2]  # a field of the motion
        row = nothing if motion is None else (motion.time, np.degrees(getattr(motion, quantity)))
        lines[name] = row
    return lines


def _frames(answer: Answer, data: dict[str, tuple[Any, Any]]) -> dict[str, tuple[Ends, Ends]]:
    """Return the limits of abscissa and ordinate of each panel for an answer, by its name.

    Abscissas are in seconds, ordinates in degrees, both rounded so that they seldom change while a
    slider moves. A curve that exceeds them after the wind, such as that of a diverging vehicle, is
    cut. `data`: result of `curves`, abscissas and ordinates by "panel.line".
    """
    c = answer.choices
    limit, wind_end = float(np.degrees(c.limit)), c.wind.duration
    time, attitude = (np.asarray(array) for array in data["attitude.attitude"])
    ordinates = {name: ordinate for name, (_, ordinate) in data.items()}
    shown = [*np.abs(attitude[time <= wind_end]), *np.abs(ordinates["attitude.wind"])]
    tall = round_up(min(_FRAME_OVER_ATTITUDE * max(shown, default=1.0), _MAX_ATTITUDE_DEG))
    required = max([limit, *ordinates["boundary.curve"], *ordinates["boundary.point"]])
    span = (0.0, round_up(max(float(time[-1]) if time.size else wind_end, 1.0)))
    deflection = round_up(1.05 * limit)
    return {
        "boundary": ((0.0, LONGEST), (0.0, round_up(1.05 * required))),
        "attitude": (span, (-tall, tall)),
        "deflection": (span, (-deflection, deflection)),
    }


_WIDE = {"description_width": "115px"}
_GROUPS = {
    "vehicle": ("vehicle", "structure", "plane", "model"),
    "wind": (
        *("shape", "duration", "peak", "gust_peak", "gust_duration"),
        *("direction", "heading", "sign"),
    ),
    "nozzle": ("limit", "dead_band", "stop", "rate_limit", "actuator", "law"),
    "loop": (
        *("design", "attitude_gain", "rate_gain", "alpha_gain"),
        *("delay", "sample_rate", "filters"),
    ),
}
_WAIT = 0.15
"""Longest wait [s] of a slider for its first picture; later steps are drawn as they end."""
_EVENT_TIME = 0.05
"""Pause [s] between two steps, in which the kernel handles events of the controls."""


class Panel:
    """The panel of widgets; each change answers anew.

    `controls`: by field, in the units of their labels. `study`, `end`: the buttons, and `said` what
    they did. `box`: all of it, to be shown.
    """

    def __init__(self, source: str | Vehicle) -> None:
        """Make the controls and the figure for a source: a vehicle, its name, or a file.

        The vehicles of the package are offered too; `_sources` are their files, for a study file
        that is written. `study`, `end`: buttons. `said`: text on the last use of a button.
        `_timer`: next step of an answer, which a new choice cancels. `_setting_gains`: whether the
        panel itself moves the controls of the gains.
        """
        try:
            import ipywidgets as widgets
        except ImportError:
            raise missing("the panel needs ipywidgets", "notebook") from None
        first, plan, named = _opened(source)
        self._base = with_numerical_gains(plan)
        self._vehicles: dict[str, AnyVehicle] = {first: plan.vehicle} | {
            name: load_vehicle(name) for name in list_vehicles() if name != first
        }
        self._sources = {first: named} | {name: name for name in list_vehicles() if name != first}
        self._picture = new_picture()
        self.controls = _controls(widgets, self._base, self._vehicles)
        self.study, self.end = (
            widgets.Button(description=label, tooltip=does)
            for label, does in (
                ("write study file", "what is set here, for every command"),
                ("End", "ends JupyterLab and what it runs; save the notebook first"),
            )
        )
        self.verdict, self.notes, self.margins, self.said = (widgets.HTML() for _ in range(4))
        self.image = widgets.Image(format="png", layout={"max_width": "100%"})
        self.box = self._arranged(widgets)
        for control in self.controls.values():
            control.observe(self._show, "value")
        self.study.on_click(self._write_study)
        self.end.on_click(self._end)
        self._timer: asyncio.TimerHandle | None = None
        self._setting_gains = False
        self._show()

    @property
    def vehicle(self) -> AnyVehicle:
        """The vehicle that is chosen, with its structure."""
        return self._vehicles[self.controls["vehicle"].value]

    @property
    def choices(self) -> Choices:
        """Choices that the widgets specify; raises `InputError` for contradictory values."""
        return choices_of(self._base, self.vehicle, self._values)

    @property
    def _values(self) -> Values:
        """Values of the controls, by field."""
        return {key: control.value for key, control in self.controls.items()}

    def _show(self, _change: Any = None) -> None:
        """Show the answer to the present choices, its later steps as they are computed, or errors.

        `_change`: event of the control that moved, which is not read.
        """
        if self._setting_gains:  # by the panel itself, not by hand
            return
        if self._timer is not None:
            self._timer.cancel()  # the later steps for choices before
        reasons = idle_controls(self._base, self.vehicle, self._values)
        for key, control in self.controls.items():
            control.disabled, control.tooltip = key in reasons, reasons.get(key)
        try:
            choices = self.choices
        except InputError as error:
            self.verdict.value = _paragraphs("No answer for these choices.", weight="bold")
            self.notes.value = _paragraphs(str(error))
            return
        self._show_gains(choices)
        self._complete(choices, steps=0)

    def _show_gains(self, choices: Choices) -> None:
        """Set the sliders of gains to the gains that the rule of choices gives.

        `_setting_gains` tells the event of a slider that the panel moved it. Nothing is set for
        gains that are given, and for a rule without a solution.
        """
        design = choices.plan.design
        if design is None or design.attitude_gain is not None:
            return
        with suppress(InputError):
            autopilot, self._setting_gains = choices.plan.autopilot, True
            for key in GIVEN_GAINS:
                self.controls[key].value = float(getattr(autopilot, key))
        self._setting_gains = False

    def _complete(self, choices: Choices, steps: int) -> None:
        """Show the answer to choices after some steps, and continue where steps remain.

        Fast steps are added to it for a short time; before a slow step (`remaining` says which are)
        the answer so far is shown. Between two pictures the kernel handles moved controls. `steps`:
        number of steps to compute.
        """
        begun, result = perf_counter(), answer(choices, steps)
        while result.remaining and perf_counter() - begun < _WAIT and not result.remaining[0]:
            steps += 1
            result = answer(choices, steps)
        self._draw(result)
        if not result.remaining:
            return
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:  # not in a notebook
            self._draw(answer(choices))
        else:
            self._timer = loop.call_later(_EVENT_TIME, self._next, choices, steps + 1)

    def _next(self, choices: Choices, steps: int) -> None:
        """Compute the first `steps` of an answer's results, then show them (`_complete`).

        `choices`: values of the controls. The last step may be slow.
        """
        answer(choices, steps)  # cached, so that the slow step takes no time of `_complete`
        self._complete(choices, steps)

    def _draw(self, result: Answer) -> None:
        """Show an answer, `result`: verdict, margins, notes and figure."""
        self.verdict.value = _paragraphs(result.verdict, weight="bold")
        self.margins.value = _paragraphs(_margins(result))
        self.notes.value = _paragraphs(*result.notes)
        self.image.value = self._picture.png(result)

    def _write_study(self, _button: Any) -> None:
        """Write the choices as a study file and show the commands that read it.

        `_button`: the button that was pressed, which is not read.
        """
        name = self.controls["vehicle"].value
        try:
            path = write_study(self.choices, name, self._sources[name])
        except InputError as error:
            self.said.value = _paragraphs(str(error))
            return
        commands = f"tvclin study {path.name}, tvclin report {path.name}"
        self.said.value = _paragraphs(f"Wrote {path}, for: {commands}")

    def _end(self, _button: Any) -> None:
        """Say that the panel has ended, and end JupyterLab; `_button` is not read."""
        self.said.value = _paragraphs("JupyterLab has ended; close this page.")
        end()

    def _arranged(self, widgets: Any) -> Any:
        """Return the layout of controls and outputs; `widgets`: module ipywidgets."""
        groups = [[self.controls[key] for key in group] for group in _GROUPS.values()]
        tabs = widgets.Tab([widgets.VBox(group) for group in groups], selected_index=1)
        for index, name in enumerate(_GROUPS):
            tabs.set_title(index, name)
        buttons = [self.study, self.end] if is_open() else [self.study]  # where it ends JupyterLab
        inputs = widgets.VBox(
            [tabs, widgets.HBox(buttons, layout={"flex_flow": "row wrap"})],
            layout={"flex": "0 0 340px", "margin": "0 8px 0 0"},
        )
        outputs = widgets.VBox(
            [self.verdict, self.image, self.margins, self.notes, self.said],
            layout={"flex": "1 1 350px", "min_width": "0"},
        )
        return widgets.HBox([inputs, outputs], layout={"flex_flow": "row wrap"})


def explore(vehicle: str | Vehicle = "configuration-i") -> Any:
    """Return a panel for a notebook, in which all values can be changed by hand.

    Parameters
    ----------
    vehicle : str or Vehicle
        One vehicle, or what `load_study` finds it by: a study file begins with its whole case. The
        vehicles of the package are in the panel's list as well.

    Returns
    -------
    ipywidgets.HBox
        Widgets, the verdict, a picture of boundary and response, and the margins.

    Raises
    ------
    InputError
        Where ipywidgets, of the extra `notebook`, is missing, for a batch, a study without a wind
        of one shape, and as `load_study`.
    """
    return Panel(vehicle).box


def _opened(source: str | Vehicle) -> tuple[str, StudyPlan, str | None]:
    """Return the name of a vehicle in the list, its plan, and the file that defines it.

    `source`: vehicle, or name or path of a vehicle or study file. The file is None for a vehicle
    whose numbers a study can hold.
    """
    if not isinstance(source, Vehicle):
        plan = load_study(source)
        pulse_of(plan)  # refuses another wind than a pulse
        in_numbers = isinstance(plan.vehicle, Vehicle) and plan.vehicle.structure is None
        return str(source), plan, None if in_numbers else str(vehicle_source(source))
    if batch := Coefficients.from_vehicle(source).batch:
        raise InputError(f"vehicle must be one vehicle; got a batch of shape {batch}")
    return source.name or "vehicle", StudyPlan(vehicle=source), None


def _controls(widgets: Any, plan: StudyPlan, vehicles: dict[str, AnyVehicle]) -> dict[str, Any]:
    """Return the lists, switches and sliders of the panel for a plan, by field.

    `widgets`: module ipywidgets. `vehicles`: vehicles by name.
    """
    controls: dict[str, Any] = {
        key: widgets.Dropdown(description=label, options=options, value=value, style=_WIDE)
        for key, (label, options, value) in lists(plan, list(vehicles)).items()
    }
    for key, (label, value) in switches(plan).items():
        controls[key] = widgets.Checkbox(description=label, value=value, style=_WIDE)
    for key, slider in sliders(plan, list(vehicles.values())).items():
        controls[key] = widgets.FloatSlider(
            description=slider.label,
            value=slider.value,
            min=slider.minimum,
            max=slider.maximum,
            step=slider.step,
            style=_WIDE,
            readout_format=f".{max(0, -round(np.floor(np.log10(slider.step))))}f",
        )
    return controls


def _paragraphs(*texts: str, weight: str = "normal") -> str:
    """Return texts as HTML, a paragraph each; `weight`: weight of the letters in CSS."""
    style = f"margin:0 0 0.4em; line-height:1.4; font-weight:{weight}"
    return "".join(f'<p style="{style}">{escape(text)}</p>' for text in texts)


def _margins(result: Answer) -> str:
    """Return gains, margins and verdict on the autopilot of an answer, `result`, in sentences."""
    judged, plan = result.margins, result.choices.plan
    if judged is None:
        return "Margins: none."
    m, gains = judged.whole, plan.autopilot.gains_text
    verdict = f"{judged.verdict[0].upper()}{judged.verdict[1:]}."
    head = f"Margins of the autopilot ({gains}), which the law {AUTOPILOT} flies: "
    if m.reason:
        return f"{head}none. {verdict}"
    return head + (
        f"aero {m.aero_margin_dB:.1f} dB, gain increase {m.gain_increase_dB:.1f} dB, phase"
        f" {m.phase_margin_deg:.1f} deg at {m.crossover_frequency:.2f} rad/s, delay"
        f" {1000.0 * m.delay_margin:.0f} ms, peak sensitivity {m.peak_sensitivity:.2f}. {verdict}"
    )
