"""The response of one vehicle and its inputs over time, in degrees."""

from typing import TYPE_CHECKING

import numpy as np

from tvclin.linear.response import Responses
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import COLOURS, INK, LINES, WARM, Look, Style, draw
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from control import ControlPlot

_ORDINATES = {
    "angles": "angles [deg]",
    "rate": "attitude rate [deg/s]",
    "deflection": "deflection [deg]",
    "wind": "wind angle of attack [deg]",
}
_STYLES: dict[str, Style] = {
    "attitude": {"color": INK, "ls": "-", "lw": 2.0},
    "flight_path_angle": {"color": COLOURS[1], "ls": "--", "lw": 1.8},
    "angle_of_attack": {"color": COLOURS[4], "ls": "-.", "lw": 1.8},
    "attitude_rate": {"color": INK, "ls": LINES[3], "lw": 1.8},
    "deflection": {"color": WARM, "ls": "-", "lw": 2.0},
    "wind": {"color": COLOURS[0], "ls": ":", "lw": 2.2},
}


def response_curves(
    response: Responses, deflection: History, wind: History, name: str, parameters: str
) -> Curves:
    """Return a response and its inputs over time, in degrees.

    Parameters
    ----------
    response : Responses
        One response, not a batch.
    deflection, wind : History
        Its inputs.
    name, parameters : str
        As of `Curves`.
    """
    columns = []
    for label in response.labels:
        unit, panel = ("deg/s", "rate") if label.endswith("rate") else ("deg", "angles")
        columns.append(Column(label, np.degrees(response[label]), unit, panel))
    for label, history in (("deflection", deflection), ("wind", wind)):
        values = np.degrees(history(response.time))
        columns.append(Column(label, values, "deg", label))
    return Curves(name, parameters, "time [s]", response.time, tuple(columns))


def response_chart(
    curves: Curves, title: str, wind_end: float = np.inf, across: int = 2
) -> "ControlPlot":
    """Draw the curves of `response_curves`: angles, rate, deflection and wind.

    Parameters
    ----------
    curves : Curves
        The numbers.
    title : str
        Title of the figure.
    wind_end : float
        Time [s]. What the response exceeds later leaves the frame.
    across : int
        Panels in one row.
    """
    return draw(
        curves, Look(title, _ORDINATES, _STYLES, limits=frames(curves, wind_end), across=across)
    )


def frames(curves: Curves, until: float) -> dict[str, tuple[float, float]]:
    """Return the ends of the ordinate of each panel, by what it shows up to a time [s].

    What exceeds that later leaves the frame.
    """
    before = curves.abscissa <= until
    limits = {}
    for panel, columns in curves.panels.items():
        values = np.stack([column.values for column in columns])
        reach = 1.15 * float(np.nanmax(np.abs(values[:, before]), initial=0.0)) or 1.0
        low, high = max(1.15 * np.nanmin(values), -reach), min(1.15 * np.nanmax(values), reach)
        limits[panel] = (min(low, 0.0), max(high, 0.0)) if low < high else (low - 1.0, high + 1.0)
    return limits
