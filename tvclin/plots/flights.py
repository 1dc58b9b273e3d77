"""A flight beside the linear theory over time, in degrees."""

from typing import TYPE_CHECKING

import numpy as np

from tvclin.flights.beside import FlightBeside
from tvclin.plots.curves import Column, Curves
from tvclin.plots.single_response import LIMITS, frames, limit_columns
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
    **LIMITS,
}


def flight_curves(
    flight: FlightBeside, limit: float, name: str, parameters: str, beside: str = "linear"
) -> Curves:
    """Return attitude, angle of attack and deflection, flown and linear, and the wind, in degrees.

    Parameters
    ----------
    flight : FlightBeside
        The flight.
    limit : float
        Its deflection limit [rad].
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
    columns += limit_columns(np.degrees(flight.flown[_PANELS["deflection"]]), limit)
    wind = Column("wind", np.degrees(flight.wind(flight.times)), "deg", "wind")
    return Curves(name, parameters, "time [s]", flight.times, (*columns, wind))


def flight_chart(curves: Curves, title: str) -> "ControlPlot":
    """Draw the curves of `flight_curves`, a panel for each.

    Parameters
    ----------
    curves : Curves
        The numbers.
    title : str
        Title of the figure.
    """
    ordinates = {panel: f"{panel} [deg]" for panel in _PANELS}
    ordinates["wind"] = "wind angle of attack [deg]"
    return draw(curves, Look(title, ordinates, _STYLES, limits=frames(curves)))
