"""Margins of the linear loop over the flight, flown margins over the limit, and boundary maps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, each, instance, limit_angle
from tvclin.control.autopilot.sweep import Sweep
from tvclin.control.margins.criteria import Judgement
from tvclin.control.margins.margins import MARGINS, unit_factor
from tvclin.flights.closed_loop.flown_margins import CHANGES, FlownMargins
from tvclin.flights.closed_loop.survival_limit import BoundaryMap
from tvclin.plots.curves import Column, Curves, finite_or_nan
from tvclin.plots.style import (
    COLOURS,
    INK,
    LINES,
    WARM,
    Look,
    Style,
    called,
    control_plot,
    cycle,
    draw,
    fine_grid,
    new_axes,
)

if TYPE_CHECKING:
    from control import ControlPlot
    from matplotlib.axes import Axes

_NOMINAL, _DETUNED, _CRITERION = "whole loop", "worst detuned mode", "criterion"
_COLOURS = tuple(colour for colour in COLOURS if colour != WARM)  # that of the criteria


def sweep_chart(sweep: Sweep, name: str = "") -> ControlPlot:
    """Draw each margin that a criterion limits over the flight time, with its limit.

    A panel for each criterion: the whole loop or the modes, the smallest margin with a detuned
    mode, and the limit. Curves are interrupted where the loop is unstable or has no such margin.

    Parameters
    ----------
    sweep : Sweep
        Sweep of two or more times.
    name : str
        Name of the vehicle.

    Raises
    ------
    InputError
        For a sweep of one time.
    """
    instance("sweep", sweep, Sweep, "see sweep")
    if sweep.times.size < 2:
        raise InputError("a figure over the flight needs two or more flight times; got 1")
    order = np.argsort(sweep.times)
    columns: list[Column] = []
    ordinates: dict[str, str] = {}
    styles: dict[str, Style] = {
        _NOMINAL: {"color": INK, "lw": 1.8},
        _DETUNED: {"color": INK, "lw": 1.2, "ls": ":"},
        _CRITERION: {"color": WARM, "lw": 1.2, "ls": "--"},
    }
    styles |= {
        mode: {"color": colour, "lw": 1.5}
        for mode, colour in zip(sweep.mode_names, cycle(_COLOURS), strict=False)
    }
    for limit in sweep.criteria.limits:
        # the label of a margin of the loop, or of the criterion for a margin of modes
        panel, *_ = MARGINS.get(limit.margin, (limit.name,))
        required, unit = limit.shown  # the required margin, and its unit in tables
        factor = unit_factor(unit)
        ordinates[panel] = f"margin [{unit}]" if unit else "margin"
        unit = unit or "-"
        for judged in sweep.judgements:
            if judged.criterion == limit:
                values = factor * finite_or_nan(np.asarray(judged.value)[order])
                if np.any(np.isfinite(values)):
                    columns.append(Column(judged.band or _NOMINAL, values, unit, panel))
        detuned = [judged for judged in sweep.detuned_judgements if judged.criterion == limit]
        if detuned:
            columns.append(Column(_DETUNED, factor * _lowest(detuned)[order], unit, panel))
        columns.append(Column(_CRITERION, np.full(order.size, required), unit, panel))
    words = f"margins over the flight, criteria {sweep.criteria.name}"
    curves = Curves("sweep", words, "flight time [s]", sweep.times[order], tuple(columns))
    ordinate = ordinates if len(ordinates) > 1 else next(iter(ordinates.values()))
    return draw(curves, Look(called(name, words), ordinate, styles))


def _lowest(judgements: list[Judgement]) -> FloatArray:
    """Return the margin with the smallest surplus at each of n flight times, ``(n,)``.

    `judgements`: of each mode or detuned loop, margins and their surplus over one criterion,
    ``(n,)``. A surplus is NaN where the loop is unstable, which counts as the smallest; so is the
    result there.
    """
    values = np.concatenate([np.atleast_2d(judged.value) for judged in judgements])
    surplus = np.concatenate([np.atleast_2d(judged.surplus) for judged in judgements])
    worst = np.argmin(np.where(np.isnan(surplus), -np.inf, surplus), axis=0)
    return finite_or_nan(np.take_along_axis(values, worst[np.newaxis], axis=0)[0])


_FACTORS, _DELAY = "gain and effectiveness", "delay"
"""Panels of the changes by a factor, and of the delay."""
_LINEAR_LABEL = ": grows near rest"
"""End of the label of the change from which the linear loop is unstable."""
_BOUNDARY: Style = {"color": COLOURS[0], "lw": 0.9}
_LIMIT_LINE: Style = {"color": WARM, "lw": 2.4}
_UNSTABLE_AREA: Style = {"color": "0.88"}


def flown_margins_chart(flown_margins: Sequence[FlownMargins]) -> ControlPlot:
    """Draw flown margins over the limit, with the margins of the linear loop as dotted lines.

    Parameters
    ----------
    flown_margins : sequence of FlownMargins
        Margins of one law in one wind with two or more limits.

    Raises
    ------
    InputError
        For fewer than two different limits.
    """
    checked = each("flown_margins", flown_margins, FlownMargins, "see flown_margins")
    ordered = sorted(checked, key=lambda margins: margins.spare)
    spare = np.array([margins.spare for margins in ordered])  # limit over the boundary of the law
    columns, styles = [], {}
    for name, colour, line in zip(CHANGES, (*COLOURS[:4], INK), (*LINES[:4], "-"), strict=True):
        margins = [getattr(m, name) for m in ordered]
        unit, panel = ("s", _DELAY) if name == "delay" else ("dB", _FACTORS)
        kinds = [("value", "", 2.0), ("linear", _LINEAR_LABEL, 1.0)]
        # of effectiveness, control moment per deflection, the linear loop has no margin of its own
        for field, suffix, width in kinds[: 1 if name.startswith("effect") else 2]:
            values = np.array([getattr(margin, field) for margin in margins])
            shown = values if name == "delay" else 20.0 * np.log10(values)
            label = name.replace("_", " ") + suffix
            columns.append(Column(label, finite_or_nan(shown), unit, panel))
            styles[label] = {"color": colour, "ls": ":" if suffix else line, "lw": width}
    words, label = "flown margins over the limit", "limit over the boundary of the law [-]"
    curves = Curves("flown-margins", words, label, spare, tuple(columns))
    ordinate = {_FACTORS: "may change by [dB]", _DELAY: "may grow by [s]"}
    plot = draw(curves, Look("Flown margins over the limit", ordinate, styles))
    for axes in plot.axes.flat:
        axes.set_ylim(bottom=0.0)
        _set_logarithmic_abscissa(axes)
    return plot


def boundary_map_chart(boundary_map: BoundaryMap, limit: float | None = None) -> ControlPlot:
    """Draw the boundary of a law over gain and delay as contours, and a limit as one of them.

    A flight with the limit survives where the boundary is below it. Grey is where the linear loop
    is unstable near rest.

    Parameters
    ----------
    boundary_map : BoundaryMap
        Map of two or more gains and two or more delays.
    limit : float, optional
        Deflection limit [rad].

    Raises
    ------
    InputError
        For fewer gains or delays, and a map without a finite boundary.
    """
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    instance("boundary_map", boundary_map, BoundaryMap, "see boundary_map")
    if min(boundary_map.limit.shape) < 2:
        raise InputError(
            f"a map needs two or more gains and delays; got {boundary_map.limit.shape}"
        )
    if not np.any(np.isfinite(boundary_map.limit)):
        raise InputError("a map needs a finite boundary somewhere; got none")
    level = None if limit is None else limit_angle(limit, "limit") / boundary_map.full_trim
    axes, coordinates = new_axes(), (boundary_map.gains, boundary_map.delays)
    values = np.ma.masked_invalid(boundary_map.limit.T)
    lines = axes.contour(*coordinates, values, levels=12, colors=COLOURS[0], linewidths=0.9)
    handles: list[Line2D | Patch] = [Line2D([], [], label="boundary, of full trim", **_BOUNDARY)]
    if level is not None:
        handles.append(Line2D([], [], label=f"limit, {level:.3g} of full trim", **_LIMIT_LINE))
        if values.min() < level < values.max():
            axes.contour(*coordinates, values, levels=[level], colors=WARM, linewidths=2.4)
    # `growth`: real part of the dominant pole in the linear range, positive where it is unstable
    if boundary_map.growth.max() > 0.0:
        handles.append(Patch(label="grows near rest", **_UNSTABLE_AREA))
        growth, ends = boundary_map.growth.T, [0.0, 2.0 * boundary_map.growth.max()]
        grey = {"colors": _UNSTABLE_AREA["color"], "zorder": 3}
        axes.contourf(*coordinates, growth, levels=ends, **grey)
    axes.set(xlabel="gain, over that of the law [-]", ylabel="delay [s]")
    axes.set_title("Boundary over gain and delay")
    fine_grid(axes)
    _set_logarithmic_abscissa(axes)
    axes.figure.canvas.draw()
    frame = axes.get_window_extent()
    for label in axes.clabel(lines, fmt="%.3g", fontsize=9, zorder=2):
        box = label.get_window_extent()
        label.set_visible(frame.contains(*box.min) and frame.contains(*box.max))
    axes.figure.legend(handles=handles, loc="outside right center")
    return control_plot([], axes, _numbers(boundary_map))


def _numbers(boundary_map: BoundaryMap) -> Curves:
    """Return the numbers of a boundary map, with a column for each of its delays."""
    columns = [
        Column(f"{name}, delay {delay:g} s", row, unit)
        for name, table, unit in (
            ("boundary", boundary_map.limit, "-"),
            ("growth", boundary_map.growth, "1/s"),
        )
        for delay, row in zip(boundary_map.delays.tolist(), table.T, strict=True)
    ]
    words = "boundary over the largest trim deflection, and growth near rest"
    label = "gain, over that of the law [-]"
    return Curves("boundary-map", words, label, boundary_map.gains, tuple(columns))


def _set_logarithmic_abscissa(axes: Axes) -> None:
    """Make the abscissa of axes logarithmic, with plain numbers."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 1.5, 2.0, 3.0, 5.0, 7.0)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
