"""The boundary limit against the duration of the wind: figures 2 and 5, and figures of a study."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import (
    InputError,
    between,
    instance,
    one_row,
    positive,
    shown,
    single,
    within,
)
from tvclin.boundary.closed_forms import (
    rectangular_limit,
    triangular_limit,
    triangular_limit_with_drift,
)
from tvclin.linear.plant import Plant
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import (
    COLOURS,
    INK,
    LINES,
    MARKS,
    WARM,
    Look,
    Style,
    broken_lines,
    called,
    control_plot,
    cycle,
    draw,
    fine_grid,
    literal,
    new_axes,
)
from tvclin.requirement.nominal_requirement import required_deflection
from tvclin.requirement.study import Study
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.vehicle.vehicle_file import load_vehicle
from tvclin.winds.wind_angles import BEYOND_LINEAR, FROZEN

if TYPE_CHECKING:
    from control import ControlPlot
    from matplotlib.axes import Axes


DEAD_BANDS = (1.0, 0.75, 0.5, 0.25, 0.0)
CONFIGURATIONS = ("configuration-i", "configuration-ii")

ABSCISSA = "wind duration tau*{} [-]"
ORDINATE = r"boundary limit  $y_{BR} = -\delta_{max}/(B\,\alpha_{w,max})$ [-]"
_DURATIONS = between(1e-6, 1e6)
"""Check of the durations tau beta of an abscissa."""
_FIXED, _DRIFT = "without drift: eqs (7), (12)", "with drift: eqs (16), (18)"
_POINTS, _FLOWN_POINTS = 200, 40
"""Durations of the wind; with a gust, where the trim law is flown for each."""


def boundary_chart(
    tau_beta: ArrayLike | None = None,
    dead_bands: Sequence[float] = DEAD_BANDS,
    coefficients: Coefficients | None = None,
) -> ControlPlot:
    """Draw the boundary limit against tau beta for rectangular and triangular winds.

    Parameters
    ----------
    tau_beta : array_like, optional
        Abscissas, ``(n,)``, positive; 0.05 to 20 where not given. With damping tau times the pole.
    dead_bands : sequence of float
        K of the curves for triangular winds.
    coefficients : Coefficients, optional
        Of one vehicle; the boundaries with drift, eqs (16) and (18), are then drawn instead of
        eqs (7) and (12).
    """
    if coefficients is not None:
        instance("coefficients", coefficients, Coefficients, "see Coefficients.from_vehicle")
        single("coefficients", coefficients.batch)
    what = _FIXED if coefficients is None else _DRIFT
    name = "" if coefficients is None else coefficients.name
    title = called(name, f"Stability boundary {what}")
    return _draw_boundaries("boundary", title, tau_beta, dead_bands, coefficients)


def figure_2(
    tau_beta: ArrayLike | None = None, dead_bands: Sequence[float] = DEAD_BANDS
) -> ControlPlot:
    """Draw the report's figure 2: the boundary without drift, eqs (7) and (12).

    Parameters
    ----------
    tau_beta, dead_bands
        Same as in `boundary_chart`.
    """
    title = f"Figure 2. Stability boundary {_FIXED}"
    return _draw_boundaries("figure-2", title, tau_beta, dead_bands, None)


def figure_5(
    tau_beta: ArrayLike | None = None,
    dead_bands: Sequence[float] = (1.0, 0.5),
    vehicles: Sequence[Vehicle | str] = CONFIGURATIONS,
) -> ControlPlot:
    """Draw the report's figure 5: triangular winds without drift, eq (12), and with it, eq (18).

    Parameters
    ----------
    tau_beta
        Same as in `boundary_chart`.
    dead_bands : sequence of float
        K, one for each panel.
    vehicles : sequence of Vehicle or str
        Vehicles, or what `load_vehicle` finds them by; one curve each.
    """
    x = _abscissas(tau_beta)
    dead_bands = _fractions(dead_bands)
    if not isinstance(vehicles, tuple | list):
        raise InputError(f"vehicles must be a tuple of vehicles or names; got {shown(vehicles)}")
    loaded = [v if isinstance(v, Vehicle) else load_vehicle(v) for v in vehicles]
    for vehicle in loaded:
        single("vehicle", vehicle.batch)
    symbols = [Coefficients.from_vehicle(vehicle).pole_symbol for vehicle in loaded]
    columns = []
    for letter, K in zip("abcdefghij", dead_bands, strict=False):
        panel = f"({letter}) K = {K:g}"
        columns.append(Column("without drift, eq (12)", _row(triangular_limit(x, K)), panel=panel))
        for number, vehicle in enumerate(loaded, 1):
            c = Coefficients.from_vehicle(vehicle)
            y = triangular_limit_with_drift(x, K, c.pole, c.b1, c.b2)
            label = f"{_short(vehicle, number)}, eq (18)"
            columns.append(Column(label, _row(y), panel=panel))
    names = ", ".join(_short(vehicle, number) for number, vehicle in enumerate(loaded, 1))
    damped = next((s for s in symbols if s != "beta"), "beta")
    curves = Curves(
        "figure-5", f"triangular wind, y_BR; {names}", ABSCISSA.format(damped), x, tuple(columns)
    )
    labels = list(dict.fromkeys(column.label for column in columns))
    styles: dict[str, Any] = {labels[0]: {"color": INK, "ls": "-", "lw": 2.0}}
    broken = zip(labels[1:], cycle(COLOURS[::3]), cycle(LINES[1::3]), strict=False)
    styles |= {label: {"color": c, "ls": line, "lw": 2.0} for label, c, line in broken}
    look = Look(
        title="Figure 5. Stability boundary in triangular winds: eqs (12) and (18)",
        ordinate=ORDINATE,
        styles=styles,
        limits=dict.fromkeys(curves.panels, (0.0, 1.02)),
    )
    plot = draw(curves, look)
    for axes in plot.axes.flat:
        _mark_durations(axes, x)
    return plot


def study_chart(study: Study, durations: ArrayLike | None = None) -> ControlPlot:
    """Draw the required deflection against the duration of the wind, for one study.

    Solid lines are the first model of the study's boundaries, broken ones the second; marks tell
    the dead bands apart. The wind and the limit of the study are shown.

    Parameters
    ----------
    study : Study
        The study; its peak, shape and vehicle are kept.
    durations : array_like, optional
        Abscissas [s], positive; up to three times the study's duration where not given.
    """
    instance("study", study, Study, "see Study.from_vehicle")
    chosen = float(study.wind.duration)
    points = _POINTS if study.gust is None else _FLOWN_POINTS
    x = (
        np.linspace(0.02, 3.0, points) * chosen
        if durations is None
        else one_row("durations", positive("durations", durations))
    )
    curves = _study_curves(study, x)
    axes = new_axes()
    lines: list[Any] = []
    curves_per_model = len(curves.columns) // len(study.boundaries)
    for index, column in enumerate(curves.columns):
        model, row = divmod(index, curves_per_model)
        look: Style = {"color": cycle(COLOURS)[row], "marker": cycle(MARKS)[row], "ms": 4.5}
        look |= {"ls": ("-", "--")[model], "markevery": max(x.size // 10, 1)}
        lines += axes.plot(x, column.values, lw=1.6, label=column.label, **look)
    axes.axvline(chosen, color=INK, lw=1.0)
    sign = study.direction
    needs = "required, both planes" if study.judges_both_planes else "required"
    needs += "" if sign == FROZEN else f", {sign} wind"
    axes.plot(chosen, np.degrees(study.required_deflection), "o", color=INK, label=needs)
    trim = float(np.degrees(study.trim_deflection))
    axes.axhline(trim, color="0.4", lw=1.0, ls=":", label="trim, no drift")
    if study.limit is not None:
        limit = float(np.degrees(study.limit))
        axes.axhline(limit, color=WARM, lw=1.6, label="available limit")
    axes.set(
        title=literal(curves.parameters),
        xlabel="wind duration [s]",
        ylabel="deflection [deg]",
        xlim=(0.0, float(x.max())),
        ylim=(0.0, None),
    )
    fine_grid(axes)
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0))
    return control_plot(lines, axes, curves)


def _study_curves(study: Study, durations: FloatArray) -> Curves:
    """Return the boundary over durations [s] for the models and dead bands of a study."""
    wind = study.wind_in_plane.history({"wind_duration": durations[:, np.newaxis]})
    shown = np.array(sorted({1.0, 0.5, 0.0, study.dead_band}, reverse=True))
    columns = []
    for model in study.boundaries:
        requirement = required_deflection(Plant(study.coefficients, model), wind, shown)
        sizes = np.abs(np.degrees(requirement.deflection)).T
        columns += [
            Column(f"K = {K:g}, {model}", y, "deg") for K, y in zip(shown, sizes, strict=True)
        ]
    shape = type(study.wind).__name__.removesuffix("Wind").lower()
    peak = float(np.degrees(study.wind.peak))
    gust = "" if study.gust is None else f", gust of {np.degrees(study.gust.peak):.3g} deg"
    words = f"{shape} winds of {peak:.3g} deg{gust}"
    words = f"{study.vehicle.name}: {words}" if study.vehicle.name else words
    words = f"{words}; {BEYOND_LINEAR}" if study.beyond else words
    return Curves("study", words, "wind duration [s]", durations, tuple(columns))


def _draw_boundaries(
    name: str,
    title: str,
    tau_beta: ArrayLike | None,
    dead_bands: Sequence[float],
    coefficients: Coefficients | None,
) -> ControlPlot:
    """Return the figure of the boundary in rectangular and triangular winds."""
    x, c = _abscissas(tau_beta), coefficients
    dead_bands = _fractions(dead_bands)
    columns = [Column("rectangular", _row(rectangular_limit(x, 1.0 if c is None else c.K1)))]
    for K in dead_bands:
        if c is None:
            y = triangular_limit(x, K)
        else:
            y = triangular_limit_with_drift(x, K, c.pole, c.b1, c.b2)
        columns.append(Column(f"triangular, K = {K:g}", _row(y)))
    styles: dict[str, Any] = broken_lines([column.label for column in columns[1:]])
    styles["rectangular"] = {"color": INK, "ls": "-", "lw": 2.0}
    what = f"y_BR {_FIXED if c is None else _DRIFT}"
    if c is not None:
        what += f"; {drift_words(c)}"
    symbol = "beta" if c is None else c.pole_symbol
    curves = Curves(name, what, ABSCISSA.format(symbol), x, tuple(columns))
    plot = draw(
        curves, Look(title, ORDINATE, styles, "wind and dead band", limits={"": (0.0, 1.02)})
    )
    axes = plot.axes[0, 0]
    axes.set_yticks(np.arange(0, 1.01, 0.1))
    _mark_durations(axes, x)
    return plot


def drift_words(c: Coefficients) -> str:
    """Return the numbers of a vehicle that enter eq (18), as text."""
    return f"{c.pole_symbol} = {c.pole:.6g} 1/s, b1 = {c.b1:.6g} 1/s, b2 = {c.b2:.6g} 1/s"


def _mark_durations(axes: Axes, tau_beta: FloatArray) -> None:
    """Set limits and ticks of the abscissa tau*beta."""
    axes.set_xlim(0.0, float(tau_beta.max()))
    axes.locator_params(axis="x", nbins=11, steps=[1, 2, 4, 5, 10])


def _abscissas(tau_beta: ArrayLike | None) -> FloatArray:
    """Return the abscissas tau*beta; `InputError` unless they are a positive row."""
    abscissas = np.linspace(0.05, 20.0, 400) if tau_beta is None else tau_beta
    return one_row("tau_beta", np.atleast_1d(_DURATIONS("tau_beta", abscissas)))


def _fractions(dead_bands: Sequence[float]) -> list[float]:
    """Return dead bands K as a list; `InputError` for what is no row of numbers from 0 to 1."""
    fractions = within("dead_bands", dead_bands, 0.0, 1.0)
    return one_row("dead_bands", np.atleast_1d(fractions)).tolist()


def _row(values: Any) -> FloatArray:
    """Return values as an array of floats."""
    return np.asarray(values, dtype=float)


def _short(vehicle: Vehicle, number: int) -> str:
    """Return the name of a vehicle without its parentheses, or its number."""
    return vehicle.name.partition(" (")[0] or f"vehicle {number}"
