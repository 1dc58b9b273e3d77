"""The response or the flight of one vehicle and its inputs over time, in degrees."""

from typing import TYPE_CHECKING

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import (
    InputError,
    instance,
    number,
    one_of,
    positive,
    shown,
    single,
    small_angle,
)
from tvclin.flights.theory_comparison import FlightBeside
from tvclin.linear.response import Responses
from tvclin.plots.curves import Column, Curves, without_rounding
from tvclin.plots.style import COLOURS, INK, QUANTITIES, WARM, Look, Style, draw
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from control import ControlPlot, TimeResponseData


_ORDINATES = {
    "angles": "angles [deg]",
    "rate": "attitude rate [deg/s]",
    "deflection": "deflection [deg]",
    "wind": "wind angle [deg]",
}
_ROOM = 0.05
"""Above and below the curves, of the height of a panel."""
_PANELS = {"attitude_rate": "rate", "deflection": "deflection", "wind": "wind"}
"""What is no angle of the vehicle, and its panel."""
_LEVEL: Style = {"color": INK, "ls": "--", "lw": 1.2}
_LIMITS = {"upper limit": _LEVEL, "lower limit": _LEVEL}
_STYLES = QUANTITIES | _LIMITS
_FLOWN = {"attitude": 0, "angle of attack": 3, "deflection": 4}
"""What is drawn, and its row of a flight."""
_FLIGHT: dict[str, Style] = {
    "flown": {"color": INK, "ls": "-", "lw": 2.2},
    "linear": {"color": WARM, "ls": "--", "lw": 1.8},
    "rigid": {"color": WARM, "ls": "--", "lw": 1.8},
    "wind": {"color": COLOURS[0], "ls": ":", "lw": 2.2},
    **_LIMITS,
}


def response_curves(
    response: "Responses | TimeResponseData",
    name: str = "response",
    parameters: str = "",
    *,
    limit: float | None = None,
    deflection: History | None = None,
    wind: History | None = None,
) -> Curves:
    """Return a response and its inputs over time, in degrees.

    Parameters
    ----------
    response : Responses or control.TimeResponseData
        One response, not a batch.
    name, parameters : str
        As of `Curves`.
    limit : float, optional
        Deflection limit [rad].
    deflection, wind : History, optional
        Inputs that the response does not hold: `Responses` hold none.
    """
    limit = None if limit is None else _limit(limit)
    for what, history in (("deflection", deflection), ("wind", wind)):
        if history is not None:
            instance(what, history, History, "such as TriangularWind")
            single(what, history.batch)
    if isinstance(response, Responses):
        rows = dict(zip(response.labels, response.outputs, strict=True))
    elif "TimeResponseData" not in [one.__name__ for one in type(response).__mro__]:
        raise InputError(
            f"response must be Responses or control.TimeResponseData; got {shown(response)}"
        )
    else:
        labels = (*response.output_labels, *response.input_labels)
        both = (np.reshape(rows, (-1, response.time.size)) for rows in (response.y, response.u))
        rows = dict(zip(labels, np.concatenate(list(both)), strict=True))
    inputs = {"deflection": deflection, "wind": wind}
    rows |= {label: one(response.time) for label, one in inputs.items() if one is not None}
    size = float(np.degrees(max(np.nanmax(np.abs(row)) for row in rows.values())))
    columns = []
    for label, row in rows.items():
        unit = "deg/s" if label == "attitude_rate" else "deg"
        values = without_rounding(np.degrees(row), size)
        columns.append(Column(label, values, unit, _PANELS.get(label, "angles")))
        if label == "deflection" and limit is not None:
            columns += _limit_columns(values, limit)
    return Curves(name, parameters, "time [s]", np.asarray(response.time), tuple(columns))


def _limit(value: float) -> float:
    return number("limit", value, small_angle("a deflection", positive), "rad")


def _limit_columns(deflection: FloatArray, limit: float) -> list[Column]:
    """Return a limit [rad] on each side to which a deflection [deg] goes at least halfway.

    Where it goes so far to neither, on that to which it goes farther.
    """
    reach = {"upper limit": np.nanmax(deflection), "lower limit": -np.nanmin(deflection)}
    least = min(0.5 * np.degrees(limit), max(reach.values()))
    return [
        Column(label, np.full(deflection.size, sign * np.degrees(limit)), "deg", "deflection")
        for (label, far), sign in zip(reach.items(), (1.0, -1.0), strict=True)
        if far >= least
    ]


def response_chart(
    response: "Curves | TimeResponseData",
    title: str = "",
    *,
    limit: float | None = None,
    across: int = 2,
) -> "ControlPlot":
    """Draw angles, rate, deflection and wind over time, in degrees.

    Parameters
    ----------
    response : Curves or control.TimeResponseData
        The numbers of `response_curves`, or a response that they are made of.
    title : str
        Title of the figure.
    limit : float, optional
        Deflection limit [rad]; of curves those that they hold count.
    across : int
        Panels in one row.
    """
    curves = response
    if not isinstance(curves, Curves):
        curves = response_curves(curves, limit=limit)
    return draw(curves, Look(title, _ORDINATES, _STYLES, limits=_frames(curves), across=across))


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
    instance("flight", flight, FlightBeside, "see fly_beside")
    limit, beside = _limit(limit), one_of("beside", beside, ("linear", "rigid"))
    columns = [
        Column(label, np.degrees(rows[row]), "deg", panel)
        for panel, row in _FLOWN.items()
        for label, rows in (("flown", flight.flown), (beside, flight.linear))
    ]
    columns += _limit_columns(np.degrees(flight.flown[_FLOWN["deflection"]]), limit)
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
    instance("curves", curves, Curves, "see flight_curves")
    ordinates = {panel: f"{panel} [deg]" for panel in _FLOWN}
    ordinates["wind"] = "wind angle of attack [deg]"
    return draw(curves, Look(title, ordinates, _FLIGHT, limits=_frames(curves)))


def _frames(curves: Curves) -> dict[str, tuple[float, float]]:
    """Return the ends of the ordinate of each panel: around all that it shows, and zero."""
    limits = {}
    for panel, columns in curves.panels.items():
        values = np.concatenate([[0.0], *(column.values for column in columns)])
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        room = _ROOM * (high - low) or 1.0
        limits[panel] = low - room, high + room
    return limits
