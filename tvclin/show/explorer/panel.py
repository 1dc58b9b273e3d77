"""The panel of widgets, and its response to a moved control."""

import asyncio
from contextlib import suppress
from html import escape
from time import perf_counter
from typing import Any

import numpy as np

from tvclin.base.errors import InputError, missing
from tvclin.control.autopilot.design_rules import GIVEN_GAINS
from tvclin.control.laws.registry import AUTOPILOT
from tvclin.requirement.case_requirement import pulse_of
from tvclin.show.explorer.answer import Answer, answer
from tvclin.show.explorer.choices import (
    Choices,
    Values,
    choices_of,
    idle_controls,
    lists,
    sliders,
    switches,
    with_numerical_gains,
    write_study,
)
from tvclin.show.explorer.lab import end, is_open
from tvclin.show.explorer.picture import new_picture
from tvclin.studyfile.read import load_study, vehicle_source
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.linear_vehicle import AnyVehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.vehicle.vehicle_file import list_vehicles, load_vehicle

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
        widgets = _widgets()
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
        return {field: control.value for field, control in self.controls.items()}

    def _show(self, _change: Any = None) -> None:
        """Start the computation for the present choices, after a pause; show errors at once."""
        if self._setting_gains:
            return
        if self._timer is not None:
            self._timer.cancel()
        reasons = idle_controls(self._base, self.vehicle, self._values)
        for field, control in self.controls.items():
            control.disabled, control.tooltip = field in reasons, reasons.get(field)
        try:
            choices = self.choices
        except InputError as error:
            self.verdict.value = _paragraphs("No answer for these choices.", weight="bold")
            self.notes.value = _paragraphs(str(error))
            return
        self._show_gains(choices)
        self._complete(choices, 0)

    def _show_gains(self, choices: Choices) -> None:
        """Set the sliders of gains to the gains of a rule."""
        design = choices.plan.design
        if design is None or design.attitude_gain is not None:
            return
        with suppress(InputError):
            autopilot, self._setting_gains = choices.plan.autopilot, True
            for field in GIVEN_GAINS:
                self.controls[field].value = float(getattr(autopilot, field))
        self._setting_gains = False

    def _complete(self, choices: Choices, steps: int) -> None:
        """Show the answer after some steps, and continue where steps remain.

        Between two pictures the kernel handles moved controls; before a slow step the answer so far
        is shown.
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
        answer(choices, steps)
        self._complete(choices, steps)

    def _draw(self, result: Answer) -> None:
        self.verdict.value = _paragraphs(result.verdict, weight="bold")
        self.margins.value = _paragraphs(_margins(result))
        self.notes.value = _paragraphs(*result.notes)
        self.image.value = self._picture.png(result)

    def _write_study(self, _button: Any) -> None:
        """Write the choices as a study file and show the commands that read it."""
        name = self.controls["vehicle"].value
        try:
            path = write_study(self.choices, name, self._sources[name])
        except InputError as error:
            self.said.value = _paragraphs(str(error))
            return
        commands = f"tvclin study {path.name}, tvclin report {path.name}"
        self.said.value = _paragraphs(f"Wrote {path}, for: {commands}")

    def _end(self, _button: Any) -> None:
        self.said.value = _paragraphs("JupyterLab has ended; close this page.")
        end()

    def _arranged(self, widgets: Any) -> Any:
        """Return the layout of controls and outputs."""
        groups = [[self.controls[field] for field in group] for group in _GROUPS.values()]
        tabs = widgets.Tab([widgets.VBox(group) for group in groups], selected_index=1)
        for index, name in enumerate(_GROUPS):
            tabs.set_title(index, name)
        buttons = [self.study, *[self.end] * is_open()]
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
    """Return the list's name of a vehicle, its plan, and the file that defines it."""
    if not isinstance(source, Vehicle):
        plan = load_study(source)  # which refuses what has no name
        pulse_of(plan)
        in_numbers = isinstance(plan.vehicle, Vehicle) and plan.vehicle.structure is None
        return str(source), plan, None if in_numbers else str(vehicle_source(source))
    if batch := Coefficients.from_vehicle(source).batch:
        raise InputError(f"vehicle must be one vehicle; got a batch of shape {batch}")
    return source.name or "vehicle", StudyPlan(vehicle=source), None


def _controls(widgets: Any, plan: StudyPlan, vehicles: dict[str, AnyVehicle]) -> dict[str, Any]:
    """Return the lists, switches and sliders, by field."""
    controls: dict[str, Any] = {
        field: widgets.Dropdown(description=label, options=options, value=value, style=_WIDE)
        for field, (label, options, value) in lists(plan, list(vehicles)).items()
    }
    for field, (label, value) in switches(plan).items():
        controls[field] = widgets.Checkbox(description=label, value=value, style=_WIDE)
    for field, slider in sliders(plan, list(vehicles.values())).items():
        controls[field] = widgets.FloatSlider(
            description=slider.label,
            value=slider.value,
            min=slider.minimum,
            max=slider.maximum,
            step=slider.step,
            style=_WIDE,
            readout_format=f".{max(0, -round(np.floor(np.log10(slider.step))))}f",
        )
    return controls


def _widgets() -> Any:
    try:
        import ipywidgets
    except ImportError:
        raise missing("the panel needs ipywidgets", "notebook") from None
    return ipywidgets


def _paragraphs(*texts: str, weight: str = "normal") -> str:
    style = f"margin:0 0 0.4em; line-height:1.4; font-weight:{weight}"
    return "".join(f'<p style="{style}">{escape(text)}</p>' for text in texts)


def _margins(result: Answer) -> str:
    """Return the gains and margins of the autopilot, in a sentence."""
    m, plan = result.margins, result.choices.plan
    if m is None:
        return "Margins: none."
    gains = plan.autopilot.gains_text
    said = f"Margins of the autopilot ({gains}), which the law {AUTOPILOT} flies: "
    if m.reason:
        return f"{said}none, {m.reason}."
    return said + (
        f"aero {m.aero_margin_dB:.1f} dB, gain increase {m.gain_increase_dB:.1f} dB, phase"
        f" {m.phase_margin_deg:.1f} deg at {m.crossover_frequency:.2f} rad/s, delay"
        f" {1000.0 * m.delay_margin:.0f} ms, peak sensitivity {m.peak_sensitivity:.2f}."
    )
