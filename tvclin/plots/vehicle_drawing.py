"""Drawings of a vehicle: the report's figure 1 and sketches, and a vehicle to scale."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.boundary.limit import boundary_limit
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.plant import Plant
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import (
    COLOURS,
    INK,
    WARM,
    Look,
    Style,
    broken_lines,
    control_plot,
    draw,
    literal,
)
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.pulses import RectangularWind, TriangularWind

if TYPE_CHECKING:
    from control import ControlPlot
    from matplotlib.axes import Axes


_RATIOS = (1e-6, 1.0 - 1e-6)
"""Least and largest ratio of a slow pole to a fast one."""
_JUMP = 1e-9
"""How far before a jump, in units of tau, the value before it is drawn."""
_WIND = r"wind  $\alpha_w/\alpha_{w,max}$ [-]"
_CONTROL = r"control  $-(\delta - \delta_n)/(B\,\alpha_{w,max})$ [-]"


def sketch_a(tau_beta: float = 4.0) -> "ControlPlot":
    """Draw the report's sketch (a): a rectangular wind, and the constant deflection of eq (7).

    Parameters
    ----------
    tau_beta : float
        Duration of the wind in units of 1/beta, beta being the unstable pole; it decides the height
        of the control.
    """
    wind = RectangularWind(peak=1.0, duration=1.0)
    tau_beta = errors.number("tau_beta", tau_beta, errors.positive)
    title = (
        f"Sketch (a). Rectangular wind and control on the boundary\neq (7), tau*beta = {tau_beta:g}"
    )
    return _wind_and_control("sketch-a", title, wind, tau_beta, dead_band=0.0)


def sketch_b(tau_beta: float = 4.0, dead_band: float = 0.5) -> "ControlPlot":
    """Draw the report's sketch (b): a triangular wind, trim, then the limit, eqs (11), (12).

    Parameters
    ----------
    tau_beta : float
        Duration of the wind in units of 1/beta, beta being the unstable pole.
    dead_band : float
        K, in [0, 1]: trim up to K times the limit.
    """
    wind = TriangularWind(peak=1.0, duration=1.0)
    tau_beta = errors.number("tau_beta", tau_beta, errors.positive)
    dead_band = errors.number("dead_band", dead_band, errors.between(0.0, 1.0))
    title = (
        "Sketch (b). Triangular wind and control on the boundary\n"
        f"eqs (11), (12), tau*beta = {tau_beta:g}, K = {dead_band:g}"
    )
    return _wind_and_control("sketch-b", title, wind, tau_beta, dead_band)


def sketch_c(
    ratios: Sequence[float] = (0.1, 0.025), highest: float = 10.0, points: int = 401
) -> "ControlPlot":
    """Draw the report's sketch (c): the solution x of eq (C6) against y.

    x = exp(-beta2 t_s), with the time t_s at which the control of least peak changes its sign; y =
    beta1 D1/(beta2 D2), of unstable poles beta_i, with D_i the integral that the control must have,
    weighted by exp(-beta_i t).

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

    highest = errors.number("highest", highest, errors.between(1.0, 1e6))
    errors.within("points", errors.whole_number("points", points), 2, 1e6)
    checked = errors.within("ratios", ratios, *_RATIOS)
    ratios = errors.one_row("ratios", np.atleast_1d(checked)).tolist()
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
    what = "x of 2 x^r - 2 x y = 1 - y, eq (C6), r = beta1/beta2"
    abscissa = r"$y = \beta_1 D_1/(\beta_2 D_2)$ [-]"
    curves = Curves("sketch-c", what, abscissa, y, tuple(columns))
    styles = broken_lines([column.label for column in columns], width=1.8)
    title = "Sketch (c). Solution of eq (C6), 2xʳ - 2xy = 1 - y,  r = β₁/β₂"
    look = Look(title, r"$x = e^{-\beta_2 t_s}$ [-]", styles, limits={"": (-0.02, 1.02)})
    return draw(curves, look)


def _wind_and_control(
    name: str, title: str, wind: History, tau_beta: float, dead_band: float
) -> "ControlPlot":
    """Return sketch (a) or (b): a wind, trim, and the deflection of the control.

    `name`: name of its numbers. `title`: title. `tau_beta`: duration of the wind times the pole.
    `dead_band`: K of the control. Peak and duration of the wind, and trim deflection per angle of
    attack are one, so that trim is minus the wind; the control is shown with the opposite sign.
    """
    plant = Plant(Coefficients.from_beta(beta=tau_beta, B=1.0), "fixed-path")
    boundary = boundary_limit(plant, wind, dead_band)
    control = trim_then_hold(plant, wind, boundary.deflection, dead_band)
    # from before the wind to after it, with both sides of every breakpoint
    knots = np.concatenate([wind.knots.ravel(), control.knots.ravel()])
    knots = knots[(knots >= 0.0) & (knots <= 1.5)]
    x = np.unique(np.concatenate([np.linspace(-0.25, 1.5, 351), knots, knots - _JUMP]))
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
    ordinates, limits = {"wind": _WIND, "control": _CONTROL}, (-0.05, 1.15)
    look = Look(title, ordinates, styles, limits=dict.fromkeys(ordinates, limits), across=1)
    plot = draw(curves, look)
    # limit, dead band and its exit are marked in the lower panel, of the control
    axes, limit, switch = plot.axes[1, 0], boundary.limit, float(boundary.switch_time)
    arrow: Style = {"arrowprops": {"arrowstyle": "->", "color": INK, "lw": 0.9}}
    text = rf"$y_{{BR}} = {limit:.4f}$"
    axes.annotate(text, (1.25, limit), (1.25, limit - 0.35), ha="center", **arrow)
    if 0.0 < dead_band < 1.0:
        text = rf"$K\,y_{{BR}}$ at $t = a = {switch:.4f}\,\tau$"
        axes.annotate(text, (switch, dead_band * limit), (switch + 0.12, 0.08), **arrow)
    return plot


_ARM_A, _ARM_C, _NOSE, _TAIL, _RADIUS, _SPEED = 3.2, 6.0, 6.4, -6.0, 0.55, 11.0
"""Lengths in figure 1, which is not to scale: moment arms, ends and radius of the body, speed."""
_ALONG = np.linspace(0.0, 1.0, 41)
"""Parts of a line at which its points are."""

_BODY: Style = {"color": INK, "ls": "-", "lw": 1.8}
_FORCE: Style = {"color": WARM, "ls": "-", "lw": 2.0}
_SPEEDS: Style = {"color": COLOURS[0], "ls": "-", "lw": 1.6}
_ANGLE: Style = {"color": COLOURS[4], "ls": "-", "lw": 1.1}
_THIN: Style = {"color": "0.45", "ls": "--", "lw": 1.0}
_ARM: Style = {"color": COLOURS[1], "ls": "-", "lw": 1.1}

_SIGNS = "\n".join(
    (
        "All angles are positive as drawn:",
        r"$\Theta,\ \gamma$  up from the local horizontal",
        r"$\alpha_w$  tail wind: $\sin\alpha_w = (V_w/V_R)\,\sin\gamma$, eq (B1e)",
        r"$\alpha = \Theta - \gamma - \alpha_w$, eq (B1f)",
        r"$\delta$  thrust turned so that the nose goes down",
        r"$I\,\ddot\Theta = N l_a\,\alpha - T l_c\,\delta$, eq (B2c)",
    )
)


@dataclass(frozen=True)
class _Line:
    """One line of the drawing, and the text beside one of its points."""

    points: FloatArray  # (41, 2)
    style: Style
    text: str = ""
    fraction: float = 1.0  # where on the line the text stands, 0 to 1
    shift: tuple[float, float] = (0.0, 0.0)
    arrow: str = ""  # as matplotlib's arrowstyle


def figure_1(
    attitude_deg: float = 60.0,
    flight_path_deg: float = 30.0,
    wind_deg: float = 12.0,
    deflection_deg: float = 10.0,
) -> "ControlPlot":
    """Draw the report's figure 1: the vehicle, its angles, forces and moment arms.

    Parameters
    ----------
    attitude_deg, flight_path_deg, wind_deg, deflection_deg : float
        Theta, gamma, alpha_w and delta [deg] as drawn, far larger than in flight.
    """
    import matplotlib.pyplot as plt

    angles_deg = {
        "attitude_deg": attitude_deg,
        "flight_path_deg": flight_path_deg,
        "wind_deg": wind_deg,
        "deflection_deg": deflection_deg,
    }
    angles = np.radians(
        [errors.number(*item, errors.between(-360.0, 360.0), "deg") for item in angles_deg.items()]
    )
    attitude, path, wind, deflection = angles
    drawn = _body(attitude, deflection) | _forces(attitude, deflection) | _speeds(path, wind)
    drawn |= _arcs(*angles) | _arms(attitude)
    columns = tuple(
        Column(f"{name} {axis}", line.points[:, i])
        for name, line in drawn.items()
        for i, axis in enumerate("xy")
    )
    what = (
        f"lines of the drawing, not to scale; Theta = {attitude_deg:g} deg,"
        f" gamma = {flight_path_deg:g} deg, alpha_w = {wind_deg:g} deg,"
        f" delta = {deflection_deg:g} deg"
    )
    curves = Curves("figure-1", what, "part of the line [-]", _ALONG, columns)
    _, axes = plt.subplots(figsize=(9.2, 8.4), layout="constrained")
    lines: list[Any] = []
    for name, line in drawn.items():
        x, y = curves.column(f"{name} x"), curves.column(f"{name} y")
        lines += axes.plot(x, y, label=name, solid_capstyle="butt", **line.style)
        _annotate(axes, line, x, y)
    axes.plot(0.0, 0.0, "o", color=INK, ms=6)
    axes.text(0.75, -0.5, "c.g.", fontsize=12)
    axes.text(0.48, 0.04, _SIGNS, transform=axes.transAxes, va="bottom", linespacing=1.7)
    axes.set_title("Figure 1. Vehicle configuration, not to scale: eqs (B1), (B2c)")
    axes.set_aspect("equal")
    axes.set_axis_off()
    return control_plot(lines, axes, curves)


def _annotate(axes: "Axes", line: _Line, x: FloatArray, y: FloatArray) -> None:
    """Put heads on the arrow of a line, and its text beside it, into axes.

    `line`: the line with its text. `x`, `y`: its points, ``(n,)``.
    """
    if line.arrow:
        head = {"arrowstyle": line.arrow, "color": line.style["color"], "lw": line.style["lw"]}
        head |= {"shrinkA": 0, "shrinkB": 0, "mutation_scale": 16}
        start = 0 if line.arrow == "<|-|>" else -3  # heads at both ends, or along the last points
        axes.annotate("", (x[-1], y[-1]), (x[start], y[start]), arrowprops=head)
    if line.text:
        i = round(line.fraction * (x.size - 1))
        right, up = line.shift
        style: Style = {"color": line.style["color"], "fontsize": 12, "ha": "center"}
        axes.text(x[i] + right, y[i] + up, line.text, va="center", **style)


def _body(attitude: float, deflection: float) -> dict[str, _Line]:
    """Return the lines of vehicle, axis, nozzle and horizontal by name, at two angles [rad]."""
    u, n = _axes_of(attitude)  # along the body axis, and to its left
    # along the axis, and the side; the nose begins at 4.6
    corners = [(_TAIL, -1), (4.6, -1), (_NOSE, 0), (4.6, 1), (_TAIL, 1), (_TAIL, -1)]
    outline = [a * u + sign * _RADIUS * n for a, sign in corners]
    aft, across = _axes_of(attitude + deflection)
    gimbal = _TAIL * u
    nozzle = [gimbal + sign * width * across - back * aft for sign, width, back in _NOZZLE]
    right = np.array([9.6, 0.0])  # end of the local horizontal
    return {
        "body": _Line(_polyline(outline, _ALONG.size), _BODY),
        "nozzle": _Line(_polyline(nozzle, _ALONG.size), _BODY),
        "axis": _Line(_straight((_TAIL - 4.4) * u, (_NOSE + 2.9) * u), _THIN),
        "local horizontal": _Line(
            _straight(0.0 * right, right), _THIN, "local horizontal", 0.8, shift=(0.0, -0.35)
        ),
    }


_NOZZLE = ((-1, 0.2, 0.0), (-1, 0.5, 1.1), (1, 0.5, 1.1), (1, 0.2, 0.0), (-1, 0.2, 0.0))
"""Corners of the nozzle: side, half width, and distance behind the gimbal."""


def _forces(attitude: float, deflection: float) -> dict[str, _Line]:
    """Return the arrows of the forces by name, at attitude and deflection [rad], not to scale.

    A text stands at a fraction of its arrow, and is shifted from there.
    """
    u, n = _axes_of(attitude)  # along the body axis, and to its left
    along, _ = _axes_of(attitude + deflection)
    gimbal, pressure, nose = _TAIL * u, _ARM_A * u, _NOSE * u
    thrust = _straight(gimbal - 4.4 * along, gimbal - 1.1 * along)
    normal, axial = _straight(pressure, pressure + 3.2 * n), _straight(nose + 2.6 * u, nose)
    weight = _straight(0.0 * u, np.array([0.0, -3.4]))
    arrow = partial(_Line, style=_FORCE, arrow="-|>")
    return {
        "thrust": arrow(thrust, text="thrust $T$ [N]", fraction=0.3, shift=(1.5, 0.0)),
        "normal force": arrow(normal, text=r"$N\alpha$ [N]", fraction=1.0, shift=(-0.2, 0.5)),
        "axial force": arrow(axial, text="$F_A$ [N]", fraction=0.4, shift=(-0.9, 0.2)),
        "weight": arrow(weight, text="$W$ [N]", fraction=1.0, shift=(0.95, 0.15)),
    }


def _speeds(path: float, wind: float) -> dict[str, _Line]:
    """Return the arrows of flight speed, wind and air speed by name.

    `path`, `wind`: flight path angle, and wind angle of attack [rad]. A text stands at a fraction
    of its arrow, and is shifted from there.
    """
    along, _ = _axes_of(path)
    into_wind, _ = _axes_of(path + wind)
    origin, speed = np.zeros(2), _SPEED * along
    relative = speed[1] / into_wind[1] * into_wind  # to the same height: the wind is horizontal
    arrow = partial(_Line, style=_SPEEDS, arrow="-|>")
    to_speed, to_relative = _straight(origin, speed), _straight(origin, relative)
    between = _straight(relative, speed)
    return {
        "velocity": arrow(to_speed, text="velocity $V$ [m/s]", fraction=0.85, shift=(1.3, -0.5)),
        "relative velocity": arrow(to_relative, text="$V_R$ [m/s]", shift=(-1.15, 0.05)),
        "wind": arrow(between, text="wind $V_w$ [m/s]", fraction=0.5, shift=(0.2, 0.4)),
    }


def _arcs(attitude: float, path: float, wind: float, deflection: float) -> dict[str, _Line]:
    """Return the arcs of the angles by name, with arrowheads.

    `attitude`, `path`, `wind`, `deflection`: the angles [rad], of which `path` is the flight path
    angle. A text stands at a fraction of its arc, and is shifted from there.
    """
    u, _ = _axes_of(attitude)  # along the body axis
    into_wind, back = path + wind, attitude + np.pi
    delta = _arc(3.6, back, back + deflection) + _TAIL * u  # radius, angles; about the gimbal
    arc = partial(_Line, style=_ANGLE, arrow="-|>")
    theta, alpha = _arc(5.6, 0.0, attitude), _arc(4.0, into_wind, attitude)
    wind_arc = _arc(4.0, path, into_wind)
    return {
        "gamma": arc(_arc(2.6, 0.0, path), text=r"$\gamma$", fraction=0.5, shift=(0.35, 0.1)),
        "Theta": arc(theta, text=r"$\Theta$", fraction=0.2, shift=(0.4, 0.05)),
        "alpha_w": arc(wind_arc, text=r"$\alpha_w$", fraction=0.5, shift=(0.45, 0.3)),
        "alpha": arc(alpha, text=r"$\alpha$", fraction=0.25, shift=(0.25, 0.35)),
        "delta": arc(delta, text=r"$\delta$", fraction=0.5, shift=(-0.15, -0.4)),
    }


def _arms(attitude: float) -> dict[str, _Line]:
    """Return the lines of the moment arms by name, at an attitude [rad], to the side of the axis.

    Each has heads at both ends, and thin lines lead to gimbal, c.g. and c.p. on the axis.
    """
    u, n = _axes_of(attitude)  # along the body axis, and to its left
    off = 1.6 * n
    ends = {"at the gimbal": -_ARM_C * u, "at c.g.": 0.0 * u, "at c.p.": _ARM_A * u}
    arm = partial(_Line, style=_ARM, fraction=0.5, shift=(-0.7, 0.3), arrow="<|-|>")
    lines = {
        "arm l_c": arm(_straight(off - _ARM_C * u, off), text="$l_c$ [m]"),
        "arm l_a": arm(_straight(off, off + _ARM_A * u), text="$l_a$ [m]"),
    }
    for name, end in ends.items():
        lines[name] = _Line(_straight(end, end + 1.15 * off), _THIN)
    return lines


def _axes_of(angle: float) -> tuple[FloatArray, FloatArray]:
    """Return the unit vectors at an angle [rad] from the horizontal, and to its left."""
    along = np.array([np.cos(angle), np.sin(angle)])
    return along, np.array([-along[1], along[0]])


def _straight(start: FloatArray, end: FloatArray) -> FloatArray:
    """Return points on a straight line from `start` to `end`, both ``(2,)``, as ``(n, 2)``."""
    return start + _ALONG[:, np.newaxis] * (end - start)


def _arc(radius: float, start: float, end: float) -> FloatArray:
    """Return points on an arc about the origin from angle `start` to `end` [rad], ``(n, 2)``.

    `radius`: its radius, in the unit of the drawing.
    """
    angle = start + _ALONG * (end - start)
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _polyline(corners: list[Any], count: int) -> FloatArray:
    """Return points on straight lines from corner to corner, all of these included, ``(n, 2)``.

    `corners`: pairs (x, y). `count`: number n of points.
    """
    sides = len(corners) - 1
    # position in sides from the first corner: steps that divide a side, and the last corner again
    position = np.minimum(np.arange(count) / (count // sides), sides)
    columns = np.array(corners).T
    return np.stack([np.interp(position, np.arange(sides + 1), xs) for xs in columns], axis=-1)


_OUTLINE_PARAMETER = np.linspace(0.0, 1.0, 21)
_SLIM, _NOSE_OVER_LENGTH, _BELL = 0.045, 0.10, 0.07
"""Radius of the body, length of the nose and of the nozzle, over the length between the forces."""
_WIDTH, _TITLE = 8.6, 0.4
"""Of the figure, and of its title [inch]."""
_CLOSE = 0.2
"""Names nearer than this part of that length stand above each other."""
_DIMENSION: Style = {"color": COLOURS[0], "lw": 1.2}


def vehicle_chart(vehicle: Vehicle, limit: float | None = None) -> "ControlPlot":
    """Draw a vehicle along its axis, nose to the right, lengths to scale.

    Drawn are the centre of gravity, the centre of pressure, the gimbal and the tanks. Neither
    radius nor nose is among the numbers of a vehicle: the outline is a sketch.

    Parameters
    ----------
    vehicle : Vehicle
        One vehicle.
    limit : float, optional
        Deflection limit [rad]; the nozzle is drawn turned to both sides by so much.

    Raises
    ------
    InputError
        For a batch of vehicles.
    """
    import matplotlib.pyplot as plt

    errors.instance("vehicle", vehicle, Vehicle, "see load_vehicle")
    errors.single("vehicle", vehicle.batch)
    if limit is not None:
        limit = errors.limit_angle(limit, "limit")
    curves = _curves(vehicle, limit)
    stations = _stations(vehicle)
    figure, axes = plt.subplots(layout="constrained")
    lines: list[Any] = []
    for name in dict.fromkeys(item.label.rpartition(" ")[0] for item in curves.columns):
        style: Style = {"color": INK, "lw": 1.6} if name == "body" else {"color": WARM, "lw": 1.4}
        xy = (curves.column(f"{name} {axis}") for axis in "xy")
        lines += axes.plot(*xy, label=name, **style)
    radius = _SLIM * float(np.ptp(list(stations.values())))
    axes.plot([min(stations.values()), max(stations.values())], [0, 0], color="0.6", lw=0.8)
    named: dict[float, str] = {}
    for name, at in stations.items():
        named[at] = f"{named[at]}, {name}" if at in named else name
    # a name near the one before it stands at the other of two heights
    before, level, top = -np.inf, 1, 3.6 * radius
    for at, name in sorted(named.items()):
        level = 1 - level if at - before < _CLOSE * float(np.ptp(list(stations.values()))) else 0
        before, height = at, (1.7, 3.4)[level] * radius
        top = max(top, height + 2.0 * radius)
        axes.plot(at, 0.0, "o", color=INK, ms=5)
        axes.plot([at, at], [0.0, height], color="0.6", lw=0.8)
        axes.text(at, height, name, ha="center", va="bottom", fontsize=10)
    arms = {"l_a": float(vehicle.aerodynamic_arm), "l_c": -float(vehicle.control_arm)}
    below = 0.0
    for name, end in sorted(arms.items(), reverse=True):
        # dimension lines below the body; that of an l_a towards the tail below that of l_c
        below = -2.2 * radius if name == "l_c" or end >= 0.0 else -4.2 * radius
        axes.annotate(
            "", (end, below), (0.0, below), arrowprops={"arrowstyle": "<|-|>", **_DIMENSION}
        )
        label = f"${name}$ = {abs(end):.4g} m"
        text_position: Style = {"ha": "center", "va": "top", "fontsize": 10, "color": COLOURS[0]}
        axes.text(end / 2.0, below - 0.4 * radius, label, **text_position)
    axes.set_title(literal(curves.parameters))
    axes.set_aspect("equal")
    axes.set_ylim((-4.2 if below > -3.0 * radius else -6.2) * radius, top)
    axes.set(xticks=[], yticks=[])
    axes.set_axis_off()
    high, wide = (float(np.ptp(ends)) for ends in (axes.get_ylim(), axes.get_xlim()))
    figure.set_size_inches(_WIDTH, _WIDTH * high / wide + _TITLE)
    return control_plot(lines, axes, curves)


def _stations(vehicle: Vehicle) -> dict[str, float]:
    """Return the stations [m] of effector, centres of gravity and pressure, and tanks, by name.

    They are measured forward of the centre of gravity. The effector is the gimbal, or "control"
    where a force other than thrust steers the vehicle.
    """
    stations = {
        "gimbal" if vehicle.control_force_slope is None else "control": -vehicle.control_arm
    }
    stations |= {"c.g.": 0.0, "c.p.": vehicle.aerodynamic_arm}
    tanks = () if vehicle.structure is None else vehicle.structure.slosh
    stations |= {f"tank {k}": tank.station for k, tank in enumerate(tanks, start=1)}
    return {name: float(at) for name, at in stations.items()}


def _curves(vehicle: Vehicle, limit: float | None) -> Curves:
    """Return the outlines of the body of a vehicle, and of its nozzle to both sides [m].

    `limit`: deflection [rad] to which the nozzle is turned; None for a straight one. The abscissa
    is along the axis, forward of the centre of gravity; radius and nose are fractions of the length
    between the outermost stations.
    """
    stations = _stations(vehicle)
    aft, fore = min(stations.values()), max(stations.values())
    length = fore - aft
    radius, tip = _SLIM * length, fore + 2.0 * _NOSE_OVER_LENGTH * length
    shoulder = fore + _NOSE_OVER_LENGTH * length
    half = [(aft, radius), (shoulder, radius), (tip, 0.0)]
    drawn = {"body": [*half, *((x, -y) for x, y in reversed(half)), half[0]]}
    # corners of the nozzle: distance ahead of the gimbal over its length, and over the body radius
    bell = [(0.0, 0.3), (-1.0, 0.8), (-1.0, -0.8), (0.0, -0.3)]
    for sign in (1.0,) if limit is None else (1.0, -1.0):
        angle = sign * (limit or 0.0)
        rotation = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        corners = [rotation @ (x * _BELL * length, y * radius) for x, y in bell]
        name = "nozzle" if sign > 0.0 else "nozzle at the opposite limit"
        drawn[name] = [(-float(vehicle.control_arm) + x, y) for x, y in corners]
    columns = tuple(
        Column(f"{name} {axis}", values, "m")
        for name, corners in drawn.items()
        for axis, values in zip("xy", _polyline(corners, _OUTLINE_PARAMETER.size).T, strict=True)
    )
    deflection = "" if limit is None else f", nozzle at its stops of {np.degrees(limit):.3f} deg"
    words = f"{vehicle.name or 'vehicle'}, lengths to scale{deflection}"
    return Curves("vehicle", words, "part of the line [-]", _OUTLINE_PARAMETER, columns)
