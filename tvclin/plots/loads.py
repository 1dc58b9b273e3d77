"""The least deflection over the largest load, the nozzle's point, and flights of laws."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from tvclin.answers.load import FlownLoad
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import each, instance
from tvclin.boundary.fronts.load_record import LoadFront
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import COLOURS, INK, WARM, Look, Style, draw

if TYPE_CHECKING:
    from control import ControlPlot

_POINT: Style = {"ls": "", "marker": "o", "ms": 7.0}
_STYLES: dict[str, Style] = {
    "wind known": {"color": COLOURS[0], "lw": 2.0},
    "no forecast, at least": {"color": INK, "ls": "--", "lw": 1.4},
    "the nozzle": {"color": WARM, **_POINT},
}
_FLOWN: tuple[Style, ...] = tuple(
    {"color": colour, **_POINT, "marker": marker}
    for colour, marker in zip((one for one in COLOURS[1:] if one != WARM), "s^vDP", strict=False)
)


def load_curves(front: LoadFront, flown: Sequence[FlownLoad] = ()) -> Curves:
    """Return the curves of `load_chart`; broken where no deflection is enough."""
    instance("front", front, LoadFront, "see load_front")
    flown = each("flown", flown, FlownLoad, "one for each law")
    points = {}
    if front.limit is not None:
        if front.load is not None:
            points["the nozzle"] = front.load
        points |= {one.law: one.load for one in flown if np.isfinite(one.load)}
    loads = np.unique(np.concatenate([front.loads, list(points.values())]))

    def over(values: FloatArray) -> FloatArray:
        known = np.where(np.isinf(values), np.nan, values)
        return np.interp(loads, front.loads, known, left=np.nan)

    values = {"wind known": over(front.limits)}
    if front.bounds is not None:
        values["no forecast, at least"] = over(front.bounds)
    for name, load in points.items():
        values[name] = np.where(loads == load, front.limit or np.nan, np.nan)
    columns = [Column(name, np.degrees(angles), "deg") for name, angles in values.items()]
    words = "least deflection over the largest load"
    return Curves("loads", words, "load [deg]", np.degrees(loads), tuple(columns))


def load_chart(
    front: LoadFront,
    flown: Sequence[FlownLoad] = (),
    title: str = "Least deflection over the largest load",
) -> "ControlPlot":
    """Draw the least deflection over the load, the nozzle where it has a load, and flights.

    Parameters
    ----------
    front : LoadFront
        As of `load_front`.
    flown : sequence of FlownLoad
        Flights of laws with the limit of the front.
    title : str
        Stands above the figure.
    """
    laws = [one.law for one in flown]
    styles = _STYLES | dict(zip(laws, _FLOWN, strict=False))
    curves = load_curves(front, flown)
    plot = draw(curves, Look(title, "deflection [deg]", styles))
    axes = plot.axes.flat[0]
    axes.set_xlim(0.0, 1.03 * float(curves.abscissa.max()))
    axes.set_ylim(bottom=0.0)
    return plot
