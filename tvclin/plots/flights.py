"""A flight beside the linear theory over time, in degrees."""

from typing import TYPE_CHECKING

import numpy as np

from tvclin.flights.beside import FlightBeside
from tvclin.plots.curves import Column, Curves
from tvclin.plots.single_response import frames
from tvclin.plots.style import COLOURS, INK, WARM, Look, Style, draw

if TYPE_CHECKING:
    from control import ControlPlot

_PANELS = {"attitude": 0, "angle of attack": 3, "deflection": 4}
"""What is drawn, and its row of a flight."""
_STYLES: dict[str, Style] = {
    "flown": {"color": INK, "ls": "-", "lw": 2.2},
    "linear": {"color": WARM, "ls": "--", "lw": 1.8},
    "rigid": {"color": WARM, "ls": "--", "lw": 1.8},
    "wind": {"color": COLOURS[0], "ls": ":", "lw": 2.2},
}


def flight_curves(
    flight: FlightBeside, name: str, parameters: str, beside: str = "linear"
) -> Curves:
    """Return attitude, angle of attack and deflection, flown and linear, and the wind, in degrees.

    Parameters
    ----------
    flight : FlightBeside
        The flight.
    name, parameters : str
        As of `Curves`.
    beside : {"linear", "rigid"}
        What the linear flight is called.
    """
    columns = [
        Column(label, np.degrees(rows[row]), "deg", panel)
        for panel, row in _PANELS.items()
        for label, rows in (("flown", flight.flown), (beside, flight.linear))
    ]
    wind = Column("wind", np.degrees(flight.wind(flight.times)), "deg", "wind")
    return Curves(name, parameters, "time [s]", flight.times, (*columns, wind))


def flight_chart(curves: Curves, title: str, wind_end: float = np.inf) -> "ControlPlot":
    """Draw the curves of `flight_curves`, a panel for each.

    Parameters
    ----------
    curves, title, wind_end
        As of `response_chart`.
    """
    ordinates = {panel: f"{panel} [deg]" for panel in _PANELS}
    ordinates["wind"] = "wind angle of attack [deg]"
    return draw(curves, Look(title, ordinates, _STYLES, limits=frames(curves, wind_end)))
