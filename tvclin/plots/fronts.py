"""The least deflection over the rate, the load or the disk margin that is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from tvclin.answers.flown_front import FlownFront
from tvclin.answers.least_gains.front import GainsFront
from tvclin.answers.load import FlownLoad
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, each, instance
from tvclin.base.lines import plural
from tvclin.base.quantities import NO_FORECAST, WIND_KNOWN
from tvclin.boundary.fronts.load_record import LoadFront
from tvclin.boundary.fronts.rate_record import RateFront
from tvclin.control.laws.registry import LAWS
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import COLOURS, INK, WARM, Look, Style, draw, law_styles

if TYPE_CHECKING:
    from control import ControlPlot

_NOZZLE = "the nozzle"
_RATES: dict[str, Style] = {
    WIND_KNOWN: {"color": "0.7", "ls": "-", "lw": 4.0},
    NO_FORECAST: {"color": INK, "ls": "-", "lw": 1.6},
    _NOZZLE: {"color": INK, "ls": "", "marker": "D", "ms": 7.0},
    **law_styles(LAWS),
}
_POINT: Style = {"ls": "", "marker": "o", "ms": 7.0}
_LOADS: dict[str, Style] = {
    WIND_KNOWN: {"color": COLOURS[0], "lw": 2.0},
    NO_FORECAST: {"color": INK, "ls": "--", "lw": 1.4},
    _NOZZLE: {"color": WARM, **_POINT},
}
_FLOWN: tuple[Style, ...] = tuple(
    {"color": colour, **_POINT, "marker": marker}
    for colour, marker in zip((one for one in COLOURS[1:] if one != WARM), "s^vDP", strict=False)
)
_MARGINS: dict[str, Style] = {
    "boundary, K = 1": {"color": "0.45", "ls": "--", "lw": 1.4},
    "boundary, K = 0.5": {"color": "0.45", "ls": "-.", "lw": 1.4},
    WIND_KNOWN: {"color": INK, "ls": ":", "lw": 2.0},
}
_MEANS = {"peak": "linear peak", "boundary": "flown limit"}


def rate_curves(front: RateFront | FlownFront) -> Curves:
    """Return the curves of `rate_chart`; broken where no deflection is enough."""
    flown = front.limits if isinstance(front, FlownFront) else {}
    front = front.front if isinstance(front, FlownFront) else front
    instance("front", front, RateFront, "see rate_front")
    values = {**flown, WIND_KNOWN: front.limits}
    if front.bounds is not None:
        values[NO_FORECAST] = front.bounds
    if front.limit is not None and front.rate_limit in front.rates:
        values[_NOZZLE] = np.where(front.rates == front.rate_limit, front.limit, np.nan)
    columns = [Column(name, np.degrees(_broken(angles)), "deg") for name, angles in values.items()]
    words, rates = "least deflection over the rate limit", np.degrees(front.rates)
    return Curves("rates", words, "rate limit [deg/s]", rates, tuple(columns))


def rate_chart(
    front: RateFront | FlownFront, title: str = "Least deflection over rate"
) -> ControlPlot:
    """Draw the least deflection over the rate limit, and the nozzle where its rate is among them.

    Parameters
    ----------
    front : RateFront or FlownFront
        As of `rate_front`, or of `flown_fronts` with a curve of each law.
    title : str
        Stands above the figure.
    """
    curves = rate_curves(front)
    plot = draw(curves, Look(title, "deflection [deg]", _RATES))
    plot.axes.flat[0].set_xlim(0.0, 1.03 * float(curves.abscissa.max()))
    return plot


def load_curves(front: LoadFront, flown: Sequence[FlownLoad] = ()) -> Curves:
    """Return the curves of `load_chart`; broken where no deflection is enough."""
    instance("front", front, LoadFront, "see load_front")
    flown = each("flown", flown, FlownLoad, "one for each law")
    points = {}
    if front.limit is not None:
        if front.load is not None:
            points[_NOZZLE] = front.load
        points |= {one.law: one.load for one in flown if np.isfinite(one.load)}
    loads = np.unique(np.concatenate([front.loads, list(points.values())]))

    def over(values: FloatArray) -> FloatArray:
        return np.interp(loads, front.loads, _broken(values), left=np.nan)

    values = {WIND_KNOWN: over(front.limits)}
    if front.bounds is not None:
        values[NO_FORECAST] = over(front.bounds)
    for name, load in points.items():
        values[name] = np.where(loads == load, front.limit or np.nan, np.nan)
    columns = [Column(name, np.degrees(angles), "deg") for name, angles in values.items()]
    words = "least deflection over the largest load"
    return Curves("loads", words, "load [deg]", np.degrees(loads), tuple(columns))


def load_chart(
    front: LoadFront,
    flown: Sequence[FlownLoad] = (),
    title: str = "Least deflection over the largest load",
) -> ControlPlot:
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
    curves = load_curves(front, flown)
    styles = _LOADS | dict(zip([one.law for one in flown], _FLOWN, strict=False))
    plot = draw(curves, Look(title, "deflection [deg]", styles))
    axes = plot.axes.flat[0]
    axes.set_xlim(0.0, 1.03 * float(curves.abscissa.max()))
    axes.set_ylim(bottom=0.0)
    return plot


def least_gains_chart(fronts: Sequence[GainsFront]) -> ControlPlot:
    """Draw what margins cost: the least deflection over the disk margin that is asked for.

    Parameters
    ----------
    fronts : sequence of GainsFront
        Of one vehicle in one set of winds, over the same disk margins: of two gains and of three,
        of linear peaks and of limits that were flown.

    Raises
    ------
    InputError
        For none, and for fronts over different disk margins.
    """
    every = each("fronts", fronts, GainsFront, "see least_gains_front")
    if not every:
        raise InputError("fronts must be one or more; got none")
    disk = every[0].disk_margin
    if any(not np.array_equal(one.disk_margin, disk) for one in every):
        raise InputError("fronts must be over the same disk margins")
    columns, styles = [], dict(_MARGINS)
    for k, one in enumerate(every):
        label = f"{plural(len(one.gains), 'gain')}, {_MEANS[one.meaning]}"
        columns.append(Column(label, _broken(one.relative)))
        styles[label] = {"color": COLOURS[k % len(COLOURS)], "lw": 2.0, "marker": "o", "ms": 4.0}
    columns += [Column(name, np.full(disk.shape, value)) for name, value in every[0].limits.items()]
    curves = Curves(
        "least-gains",
        "least deflection over the disk margin that is asked for",
        "disk margin asked for [-]",
        disk,
        tuple(columns),
    )
    plot = draw(
        curves, Look("Least deflection over disk margin", "deflection over |B alpha_w,max|", styles)
    )
    plot.axes.flat[0].set_ylim(bottom=0.0)
    return plot


def _broken(values: FloatArray) -> FloatArray:
    """Values with NaN where no deflection is enough."""
    return np.where(np.isinf(values), np.nan, values)
