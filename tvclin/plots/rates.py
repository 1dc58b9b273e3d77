"""The least deflection over the deflection rate, and the nozzle's point."""

from typing import TYPE_CHECKING

import numpy as np

from tvclin.base.errors import instance
from tvclin.boundary.rates import RateFront
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import COLOURS, INK, WARM, Look, Style, draw

if TYPE_CHECKING:
    from control import ControlPlot

_STYLES: dict[str, Style] = {
    "wind known": {"color": COLOURS[0], "lw": 2.0},
    "no forecast, at least": {"color": INK, "ls": "--", "lw": 1.4},
    "the nozzle": {"color": WARM, "ls": "", "marker": "o", "ms": 7.0},
}


def rate_curves(front: RateFront) -> Curves:
    """Return the curves of `rate_chart`; broken where no deflection is enough."""
    instance("front", front, RateFront, "see rate_front")
    values = {"wind known": front.limits}
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


def rate_chart(front: RateFront, title: str = "Least deflection over rate") -> "ControlPlot":
    """Draw the least deflection over the rate limit, and the nozzle where its rate is among them.

    Parameters
    ----------
    front : RateFront
        As of `rate_front`.
    title : str
        Stands above the figure.
    """
    plot = draw(rate_curves(front), Look(title, "deflection [deg]", _STYLES))
    plot.axes.flat[0].set_xlim(0.0, 1.03 * float(np.degrees(front.rates.max())))
    return plot
