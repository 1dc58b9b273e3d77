"""The least deflection over the deflection rate, and the nozzle's point."""

from typing import TYPE_CHECKING

import numpy as np

from tvclin.answers.flown_front import FlownFront
from tvclin.base.errors import instance
from tvclin.boundary.fronts.rate_record import RateFront
from tvclin.control.laws.registry import LAWS
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import COLOURS, INK, LINES, WARM, Look, Style, draw

if TYPE_CHECKING:
    from control import ControlPlot

_STYLES: dict[str, Style] = {
    "wind known": {"color": "0.7", "ls": "-", "lw": 4.0},
    "no forecast, at least": {"color": INK, "ls": "-", "lw": 1.6},
    "the nozzle": {"color": INK, "ls": "", "marker": "D", "ms": 7.0},
    **{
        name: {"color": colour, "ls": line, "lw": 1.8, "marker": "o", "ms": 3.5}
        for name, colour, line in zip(LAWS, (*COLOURS[:3], COLOURS[4], WARM), LINES, strict=False)
    },
}


def rate_curves(front: RateFront | FlownFront) -> Curves:
    """Return the curves of `rate_chart`; broken where no deflection is enough."""
    flown = front.limits if isinstance(front, FlownFront) else {}
    front = front.front if isinstance(front, FlownFront) else front
    instance("front", front, RateFront, "see rate_front")
    values = {**flown, "wind known": front.limits}
    if front.bounds is not None:
        values["no forecast, at least"] = front.bounds
    if front.limit is not None and front.rate_limit in front.rates:
        values["the nozzle"] = np.where(front.rates == front.rate_limit, front.limit, np.nan)
    columns = [
        Column(name, np.degrees(np.where(np.isinf(angles), np.nan, angles)), "deg")
        for name, angles in values.items()
    ]
    words, rates = "least deflection over the rate limit", np.degrees(front.rates)
    return Curves("rates", words, "rate limit [deg/s]", rates, tuple(columns))


def rate_chart(
    front: RateFront | FlownFront, title: str = "Least deflection over rate"
) -> "ControlPlot":
    """Draw the least deflection over the rate limit, and the nozzle where its rate is among them.

    Parameters
    ----------
    front : RateFront or FlownFront
        As of `rate_front`, or of `flown_fronts` with a curve of each law.
    title : str
        Stands above the figure.
    """
    curves = rate_curves(front)
    plot = draw(curves, Look(title, "deflection [deg]", _STYLES))
    plot.axes.flat[0].set_xlim(0.0, 1.03 * float(curves.abscissa.max()))
    return plot
