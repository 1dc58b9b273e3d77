"""The widgets, and what happens when one is moved."""

import asyncio
from html import escape
from time import perf_counter
from typing import Any

import numpy as np

from tvclin.answers.case import Case
from tvclin.answers.parts import told
from tvclin.base.errors import InputError, missing
from tvclin.control.autopilot.gains import canonical_gains
from tvclin.control.laws.registry import AUTOPILOT
from tvclin.linear.models import MODELS, USUAL_MODEL
from tvclin.show.explorer.answer import Answer, answer
from tvclin.show.explorer.choices import CONTROLS, TRIM, Choices, idle
from tvclin.show.explorer.lab import end, is_open
from tvclin.show.explorer.parts import LONGEST
from tvclin.show.explorer.picture import new_picture, round_up
from tvclin.show.explorer.study import write_study
from tvclin.vehicle.coefficients import PLANES, Coefficients
from tvclin.vehicle.file import list_vehicles, load_vehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.shaped import PULSES

_PEAK = 5.0
_TO_SI = {"peak": np.pi / 180.0, "limit": np.pi / 180.0, "delay": 1e-3}
_WIDE = {"description_width": "115px"}
_LEFT_OUT = (
    "Not in this panel: gusts, both planes with one stop, filters and samples of the autopilot, a"
    " rate limit. Write a study file, add them there, and ask tvclin report."
)
_WAIT = 0.3
"""A picture waits so long [s] for its curve; the rest is drawn as it is found."""

Slider = tuple[str, float, float, float, float]
"""Label, start, least, largest and step."""


class Panel:
    """The panel of widgets; each change answers anew.

    Attributes
    ----------
    controls : dict of str to Widget
        By the field of `Choices` that they set, in the units of their labels.
    verdict, notes, margins : HTML
        What is said.
    image : Image
        The picture.
    canonical, study, end : Button
        Sets the gains to the report's; writes a study file; ends JupyterLab, where
        `tvclin explore` has started it.
    said : HTML
        What a button did.
    box : HBox
        All of it, to be shown.
    """

    def __init__(self, vehicle: str | Vehicle) -> None:
        widgets = _widgets()
        first, own = _named(vehicle)
        self._vehicles = {first: own} | {
            name: load_vehicle(name) for name in list_vehicles() if name != first
        }
        self._picture = new_picture()
        self.controls = _controls(widgets, first, self._vehicles)
        self.canonical, self.study, self.end = (
            widgets.Button(description=label, tooltip=does)
            for label, does in (
                ("canonical gains", "the report's a0 and a1 for this vehicle"),
                ("write study file", "what is set here, for tvclin study and tvclin report"),
                ("End", "ends JupyterLab and what it runs; save the notebook first"),
            )
        )
        self.verdict, self.notes, self.margins, self.said = (widgets.HTML() for _ in range(4))
        self.image = widgets.Image(format="png", layout={"max_width": "100%"})
        self.box = self._arranged(widgets)
        for control in self.controls.values():
            control.observe(self._show, "value")
        self.canonical.on_click(self._set_canonical_gains)
        self.study.on_click(self._write_study)
        self.end.on_click(self._end)
        self._rest: asyncio.TimerHandle | None = None
        self._show()

    @property
    def choices(self) -> Choices:
        """What the widgets ask for."""
        asked = {field: control.value for field, control in self.controls.items()}
        asked["vehicle"] = self._vehicles[asked["vehicle"]].rigid
        return Choices(
            **{
                field: value * _TO_SI[field] if field in _TO_SI else value
                for field, value in asked.items()
            }
        )

    def _show(self, _change: Any = None) -> None:
        choices = self.choices
        reasons = idle(choices.law)
        for field, control in self.controls.items():
            control.disabled, control.tooltip = field in reasons, reasons.get(field)
        self.canonical.disabled = choices.law != AUTOPILOT
        self._complete(choices, 0)

    def _complete(self, choices: Choices, known: int) -> None:
        """Show what is known of the curve some time later, and go on where it is not whole.

        Between two pictures the kernel takes what was moved meanwhile.
        """
        if self._rest is not None:
            self._rest.cancel()
        begun, found = perf_counter(), answer(choices, known)
        while not found.whole and perf_counter() - begun < _WAIT:
            known += 1
            found = answer(choices, known)
        self._draw(found)
        if not found.whole:
            try:
                loop = asyncio.get_running_loop()
            except RuntimeError:  # not in a notebook
                self._draw(answer(choices))
            else:
                self._rest = loop.call_later(0.05, self._complete, choices, known + 1)

    def _draw(self, found: Answer) -> None:
        self.verdict.value = _paragraphs(found.verdict, weight="bold")
        self.margins.value = _paragraphs(_margins(found))
        bends = _bends(self._vehicles[self.controls["vehicle"].value], found.choices.plane)
        self.notes.value = _paragraphs(*found.notes, *bends, _LEFT_OUT)
        self.image.value = self._picture.png(found)

    def _set_canonical_gains(self, _button: Any) -> None:
        asked = self.choices
        try:
            gains = canonical_gains(Coefficients.from_vehicle(asked.vehicle, asked.plane))
        except InputError as error:
            self.notes.value = _paragraphs(str(error))
            return
        for field in ("attitude_gain", "rate_gain"):
            self.controls[field].value = float(getattr(gains, field))

    def _write_study(self, _button: Any) -> None:
        try:
            path = write_study(self.choices, self.controls["vehicle"].value)
        except InputError as error:
            self.said.value = _paragraphs(str(error))
            return
        commands = f"tvclin study {path.name}, tvclin report {path.name}"
        self.said.value = _paragraphs(f"Wrote {path}, for: {commands}")

    def _end(self, _button: Any) -> None:
        self.said.value = _paragraphs("JupyterLab has ended; close this page.")
        end()

    def _arranged(self, widgets: Any) -> Any:
        groups = (
            ("vehicle", "plane", "model"),
            ("shape", "duration", "peak"),
            ("limit", "dead_band", "law"),
            ("attitude_gain", "rate_gain", "delay"),
        )
        column = [self.controls[field] for group in groups for field in group]
        buttons = [self.canonical, self.study, *[self.end] * is_open()]
        left = widgets.VBox(
            [*column, widgets.HBox(buttons, layout={"flex_flow": "row wrap"})],
            layout={"flex": "0 0 310px"},
        )
        right = widgets.VBox(
            [self.verdict, self.image, self.margins, self.notes, self.said],
            layout={"flex": "1 1 350px", "min_width": "0"},
        )
        return widgets.HBox([left, right], layout={"flex_flow": "row wrap"})


def explore(vehicle: str | Vehicle = "configuration-i") -> Any:
    """Return a panel for a notebook, in which all values can be changed by hand.

    Parameters
    ----------
    vehicle : str or Vehicle
        One vehicle, or what `load_vehicle` finds it by; those of the package are in the panel's
        list as well.

    Returns
    -------
    ipywidgets.HBox
        Widgets, the verdict, a picture of boundary and response, and the margins.

    Raises
    ------
    InputError
        Where ipywidgets, of the extra `notebook`, is missing, for a batch, and as `load_vehicle`.
    """
    return Panel(vehicle).box


def _named(vehicle: str | Vehicle) -> tuple[str, Vehicle]:
    """What the list calls a vehicle, and the vehicle."""
    if not isinstance(vehicle, Vehicle):
        known = load_vehicle(vehicle)  # which refuses what has no name
        return str(vehicle), known
    if batch := Coefficients.from_vehicle(vehicle).batch:
        raise InputError(f"vehicle must be one vehicle; got a batch of shape {batch}")
    return vehicle.name or "vehicle", vehicle


def _bends(vehicle: Vehicle, plane: str) -> tuple[str, ...]:
    """What is to be said of a vehicle with a structure: that all here is rigid."""
    return tuple(
        f"{one[0].upper()}{one[1:]}." for one in told(Case(vehicle=vehicle, plane=plane), "explore")
    )


def _controls(widgets: Any, first: str, vehicles: dict[str, Vehicle]) -> dict[str, Any]:
    """The lists and sliders, by the field of `Choices` that they set."""
    lists = {
        "vehicle": ("vehicle", vehicles, first),
        "plane": ("plane", PLANES, "pitch"),
        "model": ("model", MODELS, USUAL_MODEL),
        "shape": ("wind shape", PULSES, "triangular"),
        "law": ("law", CONTROLS, TRIM),
    }
    controls: dict[str, Any] = {
        field: widgets.Dropdown(description=label, options=list(options), value=value, style=_WIDE)
        for field, (label, options, value) in lists.items()
    }
    sliders = _sliders(vehicles[first], list(vehicles.values()))
    for field, (label, value, least, most, step) in sliders.items():
        controls[field] = widgets.FloatSlider(
            description=label,
            value=value,
            min=least,
            max=most,
            step=step,
            style=_WIDE,
            readout_format=f".{max(0, -round(np.floor(np.log10(step))))}f",
        )
    return controls


def _sliders(first: Vehicle, every: list[Vehicle]) -> dict[str, Slider]:
    """The sliders, in the units of their labels: starts for one vehicle, room enough for all."""
    start, *others = map(_sizes, (first, *every))
    B, per_rate = (max(both) for both in zip(*others, strict=True))
    return {
        "duration": ("wind duration [s]", 7.5, 0.5, LONGEST, 0.1),
        "peak": ("wind peak [deg]", _PEAK, 0.5, 4.0 * _PEAK, 0.1),
        "dead_band": ("dead band K [-]", 1.0, 0.0, 1.0, 0.01),
        "limit": _fitted("limit [deg]", 0.75 * start[0] * _PEAK, 3.0 * B * _PEAK, 1),
        "attitude_gain": _fitted("gain a0 [-]", 5.0 * start[0], 15.0 * B, 0),
        "rate_gain": _fitted("gain a1 [s]", 3.0 * start[1], 15.0 * per_rate, 0),
        "delay": ("delay [ms]", 20.0, 0.0, 200.0, 1.0),
    }


def _fitted(label: str, start: float, most: float, least: int) -> Slider:
    """A slider to a round number, of some hundred steps, from so many steps on."""
    most = round_up(most)
    step = 10.0 ** (np.floor(np.log10(most)) - 2.0)
    return label, step * round(start / step), least * step, most, step


def _sizes(vehicle: Vehicle) -> tuple[float, float]:
    """|B|, and |B|/beta [s], of which canonical gains are made; 1 where there is no moment."""
    c = Coefficients.from_vehicle(vehicle)
    B, beta = float(np.abs(c.B)) or 1.0, float(np.sqrt(np.abs(np.asarray(c.mu_alpha)))) or 1.0
    return B, B / beta


def _widgets() -> Any:
    try:
        import ipywidgets
    except ImportError:
        raise missing("the panel needs ipywidgets", "notebook") from None
    return ipywidgets


def _paragraphs(*texts: str, weight: str = "normal") -> str:
    style = f"margin:0 0 0.4em; line-height:1.4; font-weight:{weight}"
    return "".join(f'<p style="{style}">{escape(text)}</p>' for text in texts)


def _margins(found: Answer) -> str:
    m = found.margins
    if m is None:
        return f"Margins: none, with the law {found.choices.law}."
    if m.reason:
        return f"Margins: none, {m.reason}."
    return (
        f"Margins of the gains: aero {m.aero_margin_dB:.1f} dB, gain increase"
        f" {m.gain_increase_dB:.1f} dB, phase {m.phase_margin_deg:.1f} deg at"
        f" {m.crossover_frequency:.2f} rad/s, delay {1000.0 * m.delay_margin:.0f} ms, peak"
        f" sensitivity {m.peak_sensitivity:.2f}."
    )
