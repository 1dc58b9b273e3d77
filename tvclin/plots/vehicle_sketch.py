"""Figure 1: the vehicle with its angles, forces and moment arms, and their signs."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import between, number
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import COLOURS, INK, WARM, Style, control_plot

if TYPE_CHECKING:
    from control import ControlPlot
    from matplotlib.axes import Axes


_ARM_A, _ARM_C, _NOSE, _TAIL, _RADIUS, _SPEED = 3.2, 6.0, 6.4, -6.0, 0.55, 11.0
_ALONG = np.linspace(0.0, 1.0, 41)

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
    place: float = 1.0  # where on the line the text stands, 0 to 1
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

    given = {
        "attitude_deg": attitude_deg,
        "flight_path_deg": flight_path_deg,
        "wind_deg": wind_deg,
        "deflection_deg": deflection_deg,
    }
    angles = np.radians([number(*one, between(-360.0, 360.0), "deg") for one in given.items()])
    drawn = _body(*angles) | _forces(*angles) | _speeds(*angles) | _arcs(*angles) | _arms(*angles)
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
        _finish(axes, line, x, y)
    axes.plot(0.0, 0.0, "o", color=INK, ms=6)
    axes.text(0.75, -0.5, "c.g.", fontsize=12)
    axes.text(0.48, 0.04, _SIGNS, transform=axes.transAxes, va="bottom", linespacing=1.7)
    axes.set_title("Figure 1. Vehicle configuration, not to scale: eqs (B1), (B2c)")
    axes.set_aspect("equal")
    axes.set_axis_off()
    return control_plot(lines, axes, curves)


def _finish(axes: "Axes", line: _Line, x: FloatArray, y: FloatArray) -> None:
    """Put heads on an arrow and the text beside its line."""
    if line.arrow:
        head = {"arrowstyle": line.arrow, "color": line.style["color"], "lw": line.style["lw"]}
        head |= {"shrinkA": 0, "shrinkB": 0, "mutation_scale": 16}
        start = 0 if line.arrow == "<|-|>" else -3
        axes.annotate("", (x[-1], y[-1]), (x[start], y[start]), arrowprops=head)
    if line.text:
        i = round(line.place * (x.size - 1))
        place = (x[i] + line.shift[0], y[i] + line.shift[1])
        axes.text(
            *place, line.text, color=line.style["color"], fontsize=12, ha="center", va="center"
        )


def _body(attitude: float, path: float, wind: float, turned: float) -> dict[str, _Line]:
    u, n = _axes_of(attitude)
    corners = [(_TAIL, -1), (4.6, -1), (_NOSE, 0), (4.6, 1), (_TAIL, 1), (_TAIL, -1)]
    outline = [a * u + side * _RADIUS * n for a, side in corners]
    aft, across = _axes_of(attitude + turned)
    gimbal = _TAIL * u
    nozzle = [gimbal + s * w * across - d * aft for s, w, d in _NOZZLE]
    reach = np.array([9.6, 0.0])
    return {
        "body": _Line(_polyline(outline), _BODY),
        "nozzle": _Line(_polyline(nozzle), _BODY),
        "axis": _Line(_straight((_TAIL - 4.4) * u, (_NOSE + 2.9) * u), _THIN),
        "local horizontal": _Line(
            _straight(0.0 * reach, reach), _THIN, "local horizontal", 0.8, (0.0, -0.35)
        ),
    }


_NOZZLE = ((-1, 0.2, 0.0), (-1, 0.5, 1.1), (1, 0.5, 1.1), (1, 0.2, 0.0), (-1, 0.2, 0.0))


def _forces(attitude: float, path: float, wind: float, turned: float) -> dict[str, _Line]:
    u, n = _axes_of(attitude)
    along = _axes_of(attitude + turned)[0]
    gimbal, centre, nose = _TAIL * u, _ARM_A * u, _NOSE * u
    return {
        "thrust": _Line(
            _straight(gimbal - 4.4 * along, gimbal - 1.1 * along),
            _FORCE,
            "thrust $T$ [N]",
            0.3,
            (1.5, 0.0),
            "-|>",
        ),
        "normal force": _Line(
            _straight(centre, centre + 3.2 * n), _FORCE, r"$N\alpha$ [N]", 1.0, (-0.2, 0.5), "-|>"
        ),
        "axial force": _Line(
            _straight(nose + 2.6 * u, nose), _FORCE, "$F_A$ [N]", 0.4, (-0.9, 0.2), "-|>"
        ),
        "weight": _Line(
            _straight(0.0 * u, np.array([0.0, -3.4])), _FORCE, "$W$ [N]", 1.0, (0.95, 0.15), "-|>"
        ),
    }


def _speeds(attitude: float, path: float, wind: float, turned: float) -> dict[str, _Line]:
    speed = _SPEED * _axes_of(path)[0]
    relative = speed[1] / np.sin(path + wind) * _axes_of(path + wind)[0]
    origin = np.zeros(2)
    return {
        "velocity": _Line(
            _straight(origin, speed), _SPEEDS, "velocity $V$ [m/s]", 0.85, (1.3, -0.5), "-|>"
        ),
        "relative velocity": _Line(
            _straight(origin, relative), _SPEEDS, "$V_R$ [m/s]", 1.0, (-1.15, 0.05), "-|>"
        ),
        "wind": _Line(
            _straight(relative, speed), _SPEEDS, "wind $V_w$ [m/s]", 0.5, (0.2, 0.4), "-|>"
        ),
    }


def _arcs(attitude: float, path: float, wind: float, turned: float) -> dict[str, _Line]:
    u = _axes_of(attitude)[0]
    into_wind, back = path + wind, attitude + np.pi
    return {
        "gamma": _Line(_arc(2.6, 0.0, path), _ANGLE, r"$\gamma$", 0.5, (0.35, 0.1), "-|>"),
        "Theta": _Line(_arc(5.6, 0.0, attitude), _ANGLE, r"$\Theta$", 0.2, (0.4, 0.05), "-|>"),
        "alpha_w": _Line(
            _arc(4.0, path, into_wind), _ANGLE, r"$\alpha_w$", 0.5, (0.45, 0.3), "-|>"
        ),
        "alpha": _Line(
            _arc(4.0, into_wind, attitude), _ANGLE, r"$\alpha$", 0.25, (0.25, 0.35), "-|>"
        ),
        "delta": _Line(
            _arc(3.6, back, back + turned) + _TAIL * u,
            _ANGLE,
            r"$\delta$",
            0.5,
            (-0.15, -0.4),
            "-|>",
        ),
    }


def _arms(attitude: float, path: float, wind: float, turned: float) -> dict[str, _Line]:
    u, n = _axes_of(attitude)
    off = 1.6 * n
    ends = {"at the gimbal": -_ARM_C * u, "at c.g.": 0.0 * u, "at c.p.": _ARM_A * u}
    lines = {
        "arm l_c": _Line(
            _straight(off - _ARM_C * u, off), _ARM, "$l_c$ [m]", 0.5, (-0.7, 0.3), "<|-|>"
        ),
        "arm l_a": _Line(
            _straight(off, off + _ARM_A * u), _ARM, "$l_a$ [m]", 0.5, (-0.7, 0.3), "<|-|>"
        ),
    }
    for name, end in ends.items():
        lines[name] = _Line(_straight(end, end + 1.15 * off), _THIN)
    return lines


def _axes_of(angle: float) -> tuple[FloatArray, FloatArray]:
    """The unit vector at an angle from the horizontal, and the one to its left."""
    along = np.array([np.cos(angle), np.sin(angle)])
    return along, np.array([-along[1], along[0]])


def _straight(start: FloatArray, end: FloatArray) -> FloatArray:
    return start + _ALONG[:, np.newaxis] * (end - start)


def _arc(radius: float, start: float, end: float) -> FloatArray:
    angle = start + _ALONG * (end - start)
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _polyline(corners: list[FloatArray]) -> FloatArray:
    """Straight lines from corner to corner, with every corner among the points."""
    points = np.array(corners)
    sides = len(points) - 1
    place = np.clip(_ALONG * sides, 0.0, sides)
    return np.stack(
        [np.interp(place, np.arange(sides + 1), column) for column in points.T], axis=-1
    )
