"""Responses over time: of one vehicle, and the report's figures 3, 4 and 6 to 9 of the attitude."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.boundary.limit import boundary_limit
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.plant import Plant
from tvclin.linear.response import Responses, attitude_responses
from tvclin.plots.boundaries import PEAK, Flights, chosen_engine, drift_words, flown_attitudes
from tvclin.plots.curves import Column, Curves, row_of, without_rounding
from tvclin.plots.style import (
    COLOURS,
    INK,
    LINES,
    MARKS,
    QUANTITIES,
    WARM,
    Look,
    Style,
    cycle,
    draw,
)
from tvclin.requirement.study_tables import StudyResponse
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.vehicle.vehicle_file import load_vehicle
from tvclin.winds.histories import History
from tvclin.winds.pulses import TriangularWind

if TYPE_CHECKING:
    from control import ControlPlot, TimeResponseData

    from tvclin.flights.theory_comparison import FlightComparison


_ORDINATES = {
    "angles": "angles [deg]",
    "rate": "attitude rate [deg/s]",
    "deflection": "deflection [deg]",
    "wind": "wind angle [deg]",
}
_ROOM = 0.05
"""Margin above and below the curves, over their range."""
_PANELS = {"attitude_rate": "rate", "deflection": "deflection", "wind": "wind"}
"""Panels of the quantities that are not angles of the vehicle."""
_LEVEL: Style = {"color": INK, "ls": "--", "lw": 1.2}
_LIMITS = {"upper limit": _LEVEL, "lower limit": _LEVEL}
_STYLES = QUANTITIES | _LIMITS
_FLOWN = {"attitude": 0, "angle of attack": 3, "deflection": 4}
"""Quantities of a flight's figure, and their rows of its outputs."""
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
        Name of the figure, and its parameters in one line.
    limit : float, optional
        Deflection limit [rad].
    deflection, wind : History, optional
        Inputs that are not part of the response: `Responses` have none.
    """
    limit = None if limit is None else errors.limit_angle(limit, "limit")
    for what, history in (("deflection", deflection), ("wind", wind)):
        if history is not None:
            errors.instance(what, history, History, "such as TriangularWind")
            errors.single(what, history.batch)
    if isinstance(response, Responses):
        rows = dict(zip(response.labels, response.outputs, strict=True))
    # by the name of its class: python-control takes a second to import
    elif "TimeResponseData" not in [base.__name__ for base in type(response).__mro__]:
        raise errors.InputError(
            f"response must be Responses or control.TimeResponseData; got {errors.shown(response)}"
        )
    else:
        labels = (*response.output_labels, *response.input_labels)
        data = (np.reshape(rows, (-1, response.time.size)) for rows in (response.y, response.u))
        rows = dict(zip(labels, np.concatenate(list(data)), strict=True))
    inputs = {"deflection": deflection, "wind": wind}
    rows |= {
        label: history(response.time) for label, history in inputs.items() if history is not None
    }
    size = float(np.degrees(max(np.nanmax(np.abs(row)) for row in rows.values())))
    columns = []
    for label, row in rows.items():
        unit = "deg/s" if label == "attitude_rate" else "deg"
        values = without_rounding(np.degrees(row), size)
        columns.append(Column(label, values, unit, _PANELS.get(label, "angles")))
        if label == "deflection" and limit is not None:
            columns += _limit_columns(values, limit)
    return Curves(name, parameters, "time [s]", np.asarray(response.time), tuple(columns))


def _limit_columns(deflection: FloatArray, limit: float) -> list[Column]:
    """Return the lines of a limit [rad] with the signs with which a deflection reaches half of it.

    If it reaches half with neither sign, the line has the sign of the larger peak. `deflection`:
    values [deg], ``(n,)``; the lines are in deg too.
    """
    reach = {"upper limit": np.nanmax(deflection), "lower limit": -np.nanmin(deflection)}
    threshold = min(0.5 * np.degrees(limit), max(reach.values()))
    return [
        Column(label, np.full(deflection.size, sign * np.degrees(limit)), "deg", "deflection")
        for (label, peak), sign in zip(reach.items(), (1.0, -1.0), strict=True)
        if peak >= threshold
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
        Deflection limit [rad] of a `TimeResponseData`; curves have their own limits.
    across : int
        Panels in one row.
    """
    curves = response
    if not isinstance(curves, Curves):
        curves = response_curves(curves, limit=limit)
    return draw(curves, Look(title, _ORDINATES, _STYLES, limits=_frames(curves), across=across))


def study_response_chart(response: StudyResponse) -> "ControlPlot":
    """Draw angles, deflection with its limit, and wind of the response of a study, in a column.

    Parameters
    ----------
    response : StudyResponse
        Response of one study to its wind.
    """
    errors.instance("response", response, StudyResponse, "see study_response")
    curves = response_curves(
        response.response,
        limit=response.limit,
        deflection=response.deflection,
        wind=response.study.history,
    )
    columns = tuple(column for column in curves.columns if column.panel != "rate")
    return response_chart(replace(curves, columns=columns), across=1)


def flight_curves(
    flight: "FlightComparison", limit: float, name: str, parameters: str, reference: str = "linear"
) -> Curves:
    """Return attitude, angle of attack and deflection, flown and linear, and the wind, in degrees.

    Parameters
    ----------
    flight : FlightComparison
        The flight.
    limit : float
        Its deflection limit [rad].
    name, parameters : str
        Name of the figure, and its parameters in one line.
    reference : {"linear", "rigid"}
        Name of the flight compared with.
    """
    from tvclin.flights.theory_comparison import FlightComparison  # late, with the engines

    errors.instance("flight", flight, FlightComparison, "see compare_flight")
    limit = errors.limit_angle(limit, "limit")
    reference = errors.one_of("reference", reference, ("linear", "rigid"))
    columns = [
        Column(label, np.degrees(rows[row]), "deg", panel)
        for panel, row in _FLOWN.items()  # a row of the outputs of a flight for each panel
        for label, rows in (("flown", flight.flown), (reference, flight.linear))
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
    errors.instance("curves", curves, Curves, "see flight_curves")
    ordinates = {panel: f"{panel} [deg]" for panel in _FLOWN}
    ordinates["wind"] = "wind angle of attack [deg]"
    return draw(curves, Look(title, ordinates, _FLIGHT, limits=_frames(curves)))


def _frames(curves: Curves) -> dict[str, tuple[float, float]]:
    """Return the ends of the ordinate of each panel, around its curves and zero.

    They are `_ROOM` of the range beyond it; one unit where all curves are zero.
    """
    limits = {}
    for panel, columns in curves.panels.items():
        values = np.concatenate([[0.0], *(column.values for column in columns)])
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        room = _ROOM * (high - low) or 1.0
        limits[panel] = low - room, high + room
    return limits


TAU_BETA = (2.0, 4.0, 8.0, 20.0)
FACTORS = (0.8, 0.9, 1.0, 1.1, 1.2)

_COLOURS = (COLOURS[3], COLOURS[2], COLOURS[1], COLOURS[0])
_NEVER = "trim never saturates"
_STILL = 1e-3
"""Largest attitude over the wind's peak of a flight with trim alone."""
_DURATIONS, _FACTORS = errors.between(1e-3, 1e3), errors.between(1e-6, 1e6)
_UNTIL = errors.between(1e-3, 1e2)
"""Checks of the durations tau beta, of limits over the boundary limit, and of the end t/tau."""
_ORDINATE = r"attitude error  $(\Theta - \Theta_n)/(-\alpha_{w,max})$ [-]"


def attitude_chart(
    plant: Plant,
    dead_band: float = 1.0,
    *,
    tau_beta: Sequence[float] = TAU_BETA,
    factors: Sequence[float] = FACTORS,
    until: float = 2.0,
    points: int = 401,
    flights: Flights | None = None,
    name: str = "attitude",
    title: str = "Attitude error in triangular winds, analytic",
) -> "ControlPlot":
    """Draw the attitude in triangular winds for deflections below, on and above the boundary.

    Parameters
    ----------
    plant : Plant
        One aerodynamically unstable plant of any model.
    dead_band : float
        K, in [0, 1].
    tau_beta : sequence of float
        Durations of the wind in units of 1/beta, or with damping of 1/p, p being the unstable pole;
        one for each panel.
    factors : sequence of float
        Deflection limits in units of the boundary limit of each wind, one for each curve.
    until : float
        End of the abscissa t/tau.
    points : int
        Points of each curve.
    flights : callable, optional
        Function that flies the same winds, of 1 degree, with the same limits, for the marks.
    name, title : str
        Name of the numbers, and title of the figure.

    Notes
    -----
    The control trims until K times the limit is reached and then holds the limit for ever, as
    in the report: a real autopilot would not go back beyond zero. The frame ends near the curve on
    the boundary; diverging curves leave it.
    """
    errors.instance("plant", plant, Plant, "see Plant.from_vehicle")
    errors.single("plant", plant.batch)
    dead_band = _fraction(dead_band)
    tau_beta = row_of("tau_beta", np.atleast_1d(_DURATIONS("tau_beta", tau_beta))).tolist()
    factors = row_of("factors", np.atleast_1d(_FACTORS("factors", factors))).tolist()
    if not tau_beta or not factors:
        raise errors.InputError("tau_beta and factors must hold one number or more")
    if flights is not None:
        errors.callable_for("flights", flights, "of wind, limit, dead band and times")
    errors.within("points", errors.whole_number("points", points), 2, 1e6)
    x = np.linspace(0.0, errors.number("until", until, _UNTIL), int(points))
    columns = [
        column for b in tau_beta for column in _attitudes(plant, x, b, factors, dead_band, flights)
    ]
    c = plant.coefficients
    what = f"(Theta - Theta_n)/(-alpha_w,max); model {plant.model}, K = {dead_band:g}"
    if plant.model != "fixed-path":
        what += f", {drift_words(c)}"
    if flights is not None:
        what += "; flown with the same deflection limits in pitch, tail wind of 1 deg (assumed)"
    curves = Curves(name, what, "time t/tau [-]", x, tuple(columns))
    middle = int(np.argmin(np.abs(np.array(factors) - 1.0)))  # the curve nearest the boundary
    limits = {panel: _frame(group[middle].values) for panel, group in curves.panels.items()}
    styles = _styles(factors, x.size)
    return draw(curves, Look(title, _ORDINATE, styles, "deflection limit", limits=limits))


def figure_3(dead_band: float = 1.0, **options: Any) -> "ControlPlot":
    """Draw the report's figure 3: attitude without drift, K = 1, eq (13).

    Parameters
    ----------
    dead_band : float
        K.
    **options
        Of `attitude_chart`: tau_beta, durations of the winds times the unstable pole beta; factors,
        limits over the boundary limit; until, the end of the abscissa t/tau; and points, a number.
    """
    return _without_drift(3, dead_band, options)


def figure_4(dead_band: float = 0.5, **options: Any) -> "ControlPlot":
    """Draw the report's figure 4: attitude without drift, K = 0.5, eq (13).

    Same parameters as `figure_3`.
    """
    return _without_drift(4, dead_band, options)


def figure_6(
    vehicle: Vehicle | str = "configuration-i", dead_band: float = 1.0, **options: Any
) -> "ControlPlot":
    """Draw the report's figure 6: attitude of configuration I with drift, K = 1, and flown.

    Parameters
    ----------
    vehicle : Vehicle or str
        One vehicle, or what `load_vehicle` finds it by.
    dead_band : float
        K.
    **options
        Of `attitude_chart`: tau_beta, durations of the winds times the unstable pole; factors,
        limits over the boundary limit; until, the end of the abscissa t/tau; and points. The engine
        of the flights: "sixdof", JSBSim, which is the default if it is installed, or "planar".

    Notes
    -----
    Curves are its eq (B9), marks are flights with the same deflection limits. The flights of the
    report are not printed as numbers; these are frozen at the vehicle's own time, and the size
    of the wind is assumed.
    """
    return _with_drift(6, vehicle, dead_band, **options)


def figure_7(
    vehicle: Vehicle | str = "configuration-i", dead_band: float = 0.5, **options: Any
) -> "ControlPlot":
    """Draw the report's figure 7: attitude of configuration I with drift, K = 0.5, and flown.

    Same parameters as `figure_6`.
    """
    return _with_drift(7, vehicle, dead_band, **options)


def figure_8(
    vehicle: Vehicle | str = "configuration-ii", dead_band: float = 1.0, **options: Any
) -> "ControlPlot":
    """Draw the report's figure 8: attitude of configuration II with drift, K = 1, and flown.

    Same parameters as `figure_6`.
    """
    return _with_drift(8, vehicle, dead_band, **options)


def figure_9(
    vehicle: Vehicle | str = "configuration-ii", dead_band: float = 0.5, **options: Any
) -> "ControlPlot":
    """Draw the report's figure 9: attitude of configuration II with drift, K = 0.5, and flown.

    Same parameters as `figure_6`.
    """
    return _with_drift(9, vehicle, dead_band, **options)


def _without_drift(number: int, dead_band: float, options: dict[str, Any]) -> "ControlPlot":
    """Return figure 3 or 4 of the report, by its number: attitudes on a fixed path.

    `dead_band`: K. `options`: further arguments of `attitude_chart`.
    """
    dead_band = _fraction(dead_band)
    # over the duration and the peak of the wind, the attitude depends on tau beta and K alone
    plant = Plant(Coefficients.from_beta(beta=1.0, B=1.0), "fixed-path")
    title = f"Figure {number}. Attitude error without drift, K = {dead_band:g}, analytic: eq (13)"
    return attitude_chart(plant, dead_band, name=f"figure-{number}", title=title, **options)


def _with_drift(
    number: int,
    vehicle: Vehicle | str,
    dead_band: float,
    *,
    engine: str | None = None,
    **options: Any,
) -> "ControlPlot":
    """Return figure 6, 7, 8 or 9 of the report, by its number: attitudes with drift, also flown.

    `vehicle`: vehicle, or its name. `dead_band`: K. `engine`: name of the engine of flights, None
    for the usual one. `options`: further arguments of `attitude_chart`.
    """
    dead_band = _fraction(dead_band)
    loaded = vehicle if isinstance(vehicle, Vehicle) else load_vehicle(vehicle)
    errors.single("vehicle", loaded.batch)
    engine = chosen_engine(engine)
    plant = Plant.from_vehicle(loaded, "drift")
    exact = "exact" if np.any(loaded.pitch_damping) else "eq (B9)"
    from tvclin.flights.flown_boundary import ENGINES  # late, with the engines

    words = ENGINES[engine].words
    title = (
        f"Figure {number}. Attitude error with drift, K = {dead_band:g}: {exact}, and flown with"
        f" {words}\n{loaded.name or 'one vehicle'}; flights in a tail wind of 1 deg,"
        " parameters frozen, same deflection limits"
    )
    options = {"flights": flown_attitudes(loaded, engine), **options}
    return attitude_chart(plant, dead_band, name=f"figure-{number}", title=title, **options)


def _fraction(dead_band: float) -> float:
    """Return a dead band K; `InputError` unless it is from 0 to 1."""
    return errors.number("dead_band", dead_band, errors.between(0.0, 1.0))


def _attitudes(
    plant: Plant,
    x: FloatArray,
    tau_beta: float,
    factors: Sequence[float],
    dead_band: float,
    flights: Flights | None,
) -> list[Column]:
    """Return the curves of one panel: each factor of the boundary limit, in one wind.

    `plant`: the plant. `x`: times over the duration of the wind, ``(n,)``. `tau_beta`: that
    duration times the pole. `dead_band`: K. `flights`: function of `flown_attitudes` for marks of
    flights, or None. Attitudes are over minus the peak of the wind. Where K times the limit exceeds
    the largest trim the control never leaves trim, which a note says.
    """
    duration = tau_beta / float(plant.coefficients.pole)
    wind = TriangularWind(peak=PEAK, duration=duration)
    boundary = boundary_limit(plant, wind, dead_band)
    limits = boundary.deflection * np.array(factors)
    control = trim_then_hold(plant, wind, limits, dead_band)
    attitudes = attitude_responses(plant, control, wind, x * duration)["attitude"] / -PEAK
    panel = f"tau*{plant.coefficients.pole_symbol} = {tau_beta:g}"
    columns = []
    for factor, row in zip(factors, attitudes, strict=True):
        note = _NEVER if factor * boundary.limit * dead_band > 1.0 else ""
        columns.append(Column(_name(factor), row, panel=panel, note=note))
    if flights is None:
        return columns
    for factor, limit in zip(factors, limits, strict=True):
        row = flights(wind, abs(limit), dead_band, x * duration) / -PEAK
        # with trim alone the attitude hardly moves
        note = _NEVER if np.nanmax(np.abs(row)) < _STILL else ""
        columns.append(Column(_name(factor, flown=True), row, panel=panel, note=note))
    return columns


def _name(factor: float, flown: bool = False) -> str:
    """Return the label of a curve by its factor on the boundary limit.

    `flown`: whether a flight has it.
    """
    theory = "y_BR (boundary)" if factor == 1.0 else f"{factor:g} y_BR"
    return f"{theory}, flown" if flown else theory


def _styles(factors: Sequence[float], points: int) -> dict[str, Style]:
    """Return line styles by label: solid on the boundary, broken elsewhere, and marks of flights.

    `factors`: factors on the boundary limit. `points`: number of times, of which some are marked.
    """
    others = [factor for factor in factors if factor != 1.0]
    broken = zip(others, cycle(_COLOURS), cycle(LINES[1:]), cycle(MARKS), strict=False)
    looks = [*broken, (1.0, INK, "-", "x")]
    styles: dict[str, Style] = {}
    for factor, colour, line, mark in looks:
        width = 2.2 if factor == 1.0 else 1.8
        styles[_name(factor)] = {"color": colour, "ls": line, "lw": width}
        marks: Style = {"color": colour, "ls": "", "marker": mark, "mfc": "none", "ms": 5.0}
        styles[_name(factor, flown=True)] = marks | {"markevery": max(points // 40, 1)}
    return styles


def _frame(boundary: FloatArray) -> tuple[float, float]:
    """Return ends of the ordinate, around the curve on the boundary and a part of it below zero.

    `boundary`: attitudes of that curve, ``(n,)``. At least 0.35 of its size on both sides of zero
    shows where curves beside it, which diverge, leave the frame.
    """
    size = float(np.abs(boundary).max()) or 1.0
    low, high = float(boundary.min()), float(boundary.max())
    return min(-0.35 * size, 1.2 * low), max(0.35 * size, 1.3 * high)
