"""A vehicle along its axis, to scale: where gravity, air, control and liquids act."""

from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.errors import instance, number, positive, single, small_angle
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import COLOURS, INK, WARM, Style, control_plot, literal
from tvclin.vehicle.vehicle import Vehicle

if TYPE_CHECKING:
    from control import ControlPlot

_ALONG = np.linspace(0.0, 1.0, 21)
_SLIM, _NOSE, _BELL = 0.045, 0.10, 0.07
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

    instance("vehicle", vehicle, Vehicle, "see load_vehicle")
    single("vehicle", vehicle.batch)
    if limit is not None:
        limit = number("limit", limit, small_angle("a deflection", positive), "rad")
    curves = _curves(vehicle, limit)
    stations = _stations(vehicle)
    figure, axes = plt.subplots(layout="constrained")
    lines: list[Any] = []
    for name in dict.fromkeys(one.label.rpartition(" ")[0] for one in curves.columns):
        style: Style = {"color": INK, "lw": 1.6} if name == "body" else {"color": WARM, "lw": 1.4}
        xy = (curves.column(f"{name} {axis}") for axis in "xy")
        lines += axes.plot(*xy, label=name, **style)
    radius = _SLIM * float(np.ptp(list(stations.values())))
    axes.plot([min(stations.values()), max(stations.values())], [0, 0], color="0.6", lw=0.8)
    named: dict[float, str] = {}
    for name, at in stations.items():
        named[at] = f"{named[at]}, {name}" if at in named else name
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
        below = -2.2 * radius if name == "l_c" or end >= 0.0 else -4.2 * radius
        axes.annotate(
            "", (end, below), (0.0, below), arrowprops={"arrowstyle": "<|-|>", **_DIMENSION}
        )
        label = f"${name}$ = {abs(end):.4g} m"
        place: Style = {"ha": "center", "va": "top", "fontsize": 10, "color": COLOURS[0]}
        axes.text(end / 2.0, below - 0.4 * radius, label, **place)
    axes.set_title(literal(curves.parameters))
    axes.set_aspect("equal")
    axes.set_ylim((-4.2 if below > -3.0 * radius else -6.2) * radius, top)
    axes.set(xticks=[], yticks=[])
    axes.set_axis_off()
    high, wide = (float(np.ptp(ends)) for ends in (axes.get_ylim(), axes.get_xlim()))
    figure.set_size_inches(_WIDTH, _WIDTH * high / wide + _TITLE)
    return control_plot(lines, axes, curves)


def _stations(vehicle: Vehicle) -> dict[str, float]:
    """What acts where [m], forward of the centre of gravity."""
    found = {"gimbal" if vehicle.control_force_slope is None else "control": -vehicle.control_arm}
    found |= {"c.g.": 0.0, "c.p.": vehicle.aerodynamic_arm}
    tanks = () if vehicle.structure is None else vehicle.structure.slosh
    found |= {f"tank {k}": one.station for k, one in enumerate(tanks, start=1)}
    return {name: float(at) for name, at in found.items()}


def _curves(vehicle: Vehicle, limit: float | None) -> Curves:
    """The outline of the body, and of the nozzle to both sides of its axis."""
    stations = _stations(vehicle)
    aft, fore = min(stations.values()), max(stations.values())
    length = fore - aft
    radius, tip = _SLIM * length, fore + 2.0 * _NOSE * length
    shoulder = fore + _NOSE * length
    half = [(aft, radius), (shoulder, radius), (tip, 0.0)]
    drawn = {"body": [*half, *((x, -y) for x, y in reversed(half)), half[0]]}
    bell = [(0.0, 0.3), (-1.0, 0.8), (-1.0, -0.8), (0.0, -0.3)]
    for side in (1.0,) if limit is None else (1.0, -1.0):
        angle = side * (limit or 0.0)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        corners = [turn @ (x * _BELL * length, y * radius) for x, y in bell]
        name = "nozzle" if side > 0.0 else "nozzle to the other side"
        drawn[name] = [(-float(vehicle.control_arm) + x, y) for x, y in corners]
    columns = tuple(
        Column(f"{name} {axis}", values, "m")
        for name, corners in drawn.items()
        for axis, values in zip("xy", _polyline(corners), strict=True)
    )
    turned = "" if limit is None else f", nozzle at its stops of {np.degrees(limit):.3f} deg"
    words = f"{vehicle.name or 'vehicle'}, lengths to scale{turned}"
    return Curves("vehicle", words, "part of the line [-]", _ALONG, columns)


def _polyline(corners: list[Any]) -> Any:
    """Points along straight lines from corner to corner, ``(2, 21)``; each corner among them."""
    points, sides = np.array(corners), len(corners) - 1
    place = np.linspace(0.0, sides, sides * (_ALONG.size // sides) + 1)
    place = np.append(place, np.full(max(_ALONG.size - place.size, 0), float(sides)))[: _ALONG.size]
    return np.array([np.interp(place, np.arange(sides + 1), column) for column in points.T])
