"""The report's sketches: wind and control (a, b), and the switch of two poles (c)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import between, number, one_row, positive, whole_number, within
from tvclin.boundary.limit import boundary_limit
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.plant import Plant
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import COLOURS, INK, WARM, Look, broken_lines, draw
from tvclin.vehicle.coefficients import Coefficients
from tvclin.winds.histories import History
from tvclin.winds.pulses import RectangularWind, TriangularWind

if TYPE_CHECKING:
    from control import ControlPlot


_RATIOS = (1e-6, 1.0 - 1e-6)
"""Least and largest ratio of a slow pole to a fast one."""
_JUMP = 1e-9
"""How far before a jump, in units of tau, the value before it is drawn."""
_WIND = r"wind  $\alpha_w/\alpha_{w,max}$ [-]"
_CONTROL = r"control  $-(\delta - \delta_n)/(B\,\alpha_{w,max})$ [-]"


def sketch_a(tau_beta: float = 4.0) -> "ControlPlot":
    """Draw sketch (a): a rectangular wind, and the deflection held from its start, eq (7).

    Parameters
    ----------
    tau_beta : float
        Duration of the wind in units of 1/beta; it decides the height of the control.
    """
    wind, tau_beta = RectangularWind(peak=1.0, duration=1.0), number("tau_beta", tau_beta, positive)
    title = (
        f"Sketch (a). Rectangular wind and control on the boundary\neq (7), tau*beta = {tau_beta:g}"
    )
    return _wind_and_control("sketch-a", title, wind, tau_beta, 0.0)


def sketch_b(tau_beta: float = 4.0, dead_band: float = 0.5) -> "ControlPlot":
    """Draw sketch (b): a triangular wind, and trim until the dead band is left, eqs (11), (12).

    Parameters
    ----------
    tau_beta : float
        Duration of the wind in units of 1/beta.
    dead_band : float
        K, in [0, 1].
    """
    wind, tau_beta = TriangularWind(peak=1.0, duration=1.0), number("tau_beta", tau_beta, positive)
    dead_band = number("dead_band", dead_band, between(0.0, 1.0))
    title = (
        "Sketch (b). Triangular wind and control on the boundary\n"
        f"eqs (11), (12), tau*beta = {tau_beta:g}, K = {dead_band:g}"
    )
    return _wind_and_control("sketch-b", title, wind, tau_beta, dead_band)


def sketch_c(
    ratios: Sequence[float] = (0.1, 0.025), highest: float = 10.0, points: int = 401
) -> "ControlPlot":
    """Draw sketch (c): the solution x of eq (C6) against y.

    Parameters
    ----------
    ratios : sequence of float
        r = beta1/beta2, slow pole over fast, each between 0 and 1.
    highest : float
        End of the abscissa y, above 1.
    points : int
        Points of each curve.

    Notes
    -----
    The solution jumps at y = 1 from x = 0 (the switch comes never) to x = 1 (at once). For a
    large y it comes down to x = (y - 1 + 2^(1 - r))/(2 y); the report prints (y - 1)/(2 y).
    """
    from tvclin.boundary.optimum.two_poles import early_switch, switch_variable

    highest = number("highest", highest, between(1.0, 1e6))
    within("points", whole_number("points", points), 2, 1e6)
    ratios = one_row("ratios", np.atleast_1d(within("ratios", ratios, *_RATIOS))).tolist()
    y = np.linspace(0.0, highest, int(points))
    y = np.sort(np.concatenate([y[y != 1.0], [1.0 - _JUMP, 1.0, 1.0 + _JUMP]]))
    columns = []
    for r in ratios:
        x = np.array([np.nan if value == 1.0 else switch_variable(value, r) for value in y])
        columns.append(Column(f"exact, r = {r:g}", x))
    late = np.where(y > 1.0, y, np.nan)
    corrected = np.where(y > 1.0, early_switch(np.maximum(y, 1.0), ratios[0]), np.nan)
    columns.append(Column(f"large y, corrected, r = {ratios[0]:g}", corrected))
    columns.append(Column("large y, (y - 1)/(2y) as printed", (late - 1.0) / (2.0 * late)))
    curves = Curves(
        "sketch-c",
        "x of 2 x^r - 2 x y = 1 - y, eq (C6), r = beta1/beta2",
        r"$y = \beta_1 D_1/(\beta_2 D_2)$ [-]",
        y,
        tuple(columns),
    )
    styles = broken_lines([column.label for column in columns], width=1.8)
    look = Look(
        title="Sketch (c). Solution of eq (C6), 2xʳ - 2xy = 1 - y,  r = β₁/β₂",
        ordinate=r"$x = e^{-\beta_2 t_s}$ [-]",
        styles=styles,
        limits={"": (-0.02, 1.02)},
    )
    return draw(curves, look)


def _wind_and_control(
    name: str, title: str, wind: History, tau_beta: float, dead_band: float
) -> "ControlPlot":
    plant = Plant(Coefficients.from_beta(beta=tau_beta, B=1.0), "fixed-path")
    boundary = boundary_limit(plant, wind, dead_band)
    control = trim_then_hold(plant, wind, boundary.deflection, dead_band)
    x = _times_with_jumps(wind, control)
    columns = (
        Column("wind", wind(x), panel="wind"),
        Column("trim", wind(x), panel="control"),
        Column("control", -control(x), panel="control"),
    )
    what = f"tau*beta = {tau_beta:g}, K = {dead_band:g}, y_BR = {boundary.limit:.10g}"
    curves = Curves(name, what, "time t/tau [-]", x, columns)
    styles: dict[str, Any] = {
        "wind": {"color": COLOURS[0], "ls": "-", "lw": 2.0},
        "trim": {"color": "0.45", "ls": "--", "lw": 1.4},
        "control": {"color": WARM, "ls": "-", "lw": 2.2},
    }
    look = Look(
        title,
        {"wind": _WIND, "control": _CONTROL},
        styles,
        limits=dict.fromkeys(("wind", "control"), (-0.05, 1.15)),
        across=1,
    )
    plot = draw(curves, look)
    _mark_levels(plot.axes[1, 0], boundary.limit, float(boundary.switch_time), dead_band)
    return plot


def _mark_levels(axes: Any, limit: float, switch: float, dead_band: float) -> None:
    arrow = {"arrowstyle": "->", "color": INK, "lw": 0.9}
    axes.annotate(
        rf"$y_{{BR}} = {limit:.4f}$",
        (1.25, limit),
        (1.25, limit - 0.35),
        arrowprops=arrow,
        ha="center",
    )
    if 0.0 < dead_band < 1.0:
        axes.annotate(
            rf"$K\,y_{{BR}}$ at $t = a = {switch:.4f}\,\tau$",
            (switch, dead_band * limit),
            (switch + 0.12, 0.08),
            arrowprops=arrow,
        )


def _times_with_jumps(*histories: History) -> FloatArray:
    """Times from before the wind to after it, with both sides of every breakpoint."""
    knots = np.concatenate([history.knots.ravel() for history in histories])
    knots = knots[(knots >= 0.0) & (knots <= 1.5)]
    even = np.linspace(-0.25, 1.5, 351)
    return np.unique(np.concatenate([even, knots, knots - _JUMP]))
