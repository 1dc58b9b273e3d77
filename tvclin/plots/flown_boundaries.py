"""Boundary limit over the duration of the wind, theoretical and flown: figures 10 and 11."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from functools import cache
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.flight_condition import load_flight_condition
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import instance, one_of, one_row, positive, within
from tvclin.boundary.closed_forms import triangular_limit, triangular_limit_with_drift
from tvclin.flights.engine_interface import OUTPUTS, ReportControl
from tvclin.flights.flown_boundary import ENGINES, flown_boundary
from tvclin.plots.boundaries import ABSCISSA, ORDINATE, drift_words
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import COLOURS, INK, LINES, WARM, Look, Style, draw
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle import Vehicle
from tvclin.vehicle.vehicle_file import load_vehicle
from tvclin.winds.histories import History
from tvclin.winds.pulses import TriangularWind

if TYPE_CHECKING:
    from control import ControlPlot


Flights = Callable[[History, float, float, FloatArray], FloatArray]
"""Function from a wind, a deflection limit [rad], a dead band and times [s], ``(n,)``, to the
attitude [rad] of the flight, ``(n,)``; NaN after its end."""

PEAK = float(np.radians(1.0))
"""Peak of the winds of the flights [rad], tail winds. The report does not give it."""


def chosen_engine(engine: str | None) -> str:
    """Return the name of an engine; the default is JSBSim if it is installed, else "planar".

    `InputError` for an unknown name.
    """
    if engine is None:
        return "sixdof" if find_spec("jsbsim") else "planar"
    return one_of("engine", engine, ENGINES)


def flown_attitudes(vehicle: Vehicle, engine: str) -> Flights:
    """Return the function that flies the report's control in pitch, with frozen parameters.

    `engine`: one of `ENGINES`.
    """
    fly = ENGINES[engine].outputs

    def attitude(wind: History, limit: float, dead_band: float, times: FloatArray) -> FloatArray:
        control = ReportControl(dead_band)
        with warnings.catch_warnings():  # that a flight below the boundary ends is what is shown
            warnings.filterwarnings("ignore", "the flight ends", UserWarning)
            _, outputs = fly(vehicle, control, wind, times, deflection_limit=limit)
        return np.asarray(outputs[OUTPUTS.index("attitude")])

    return attitude


@cache
def flown_limit(
    name: str,
    tau_beta: float,
    dead_band: float,
    *,
    plane: str = "pitch",
    peak: float = PEAK,
    engine: str = "planar",
    along: bool = False,
    tolerance: float = 2.5e-3,
) -> float:
    """Return the boundary limit of the report's control in a triangular wind, by flying.

    `name`: what `load_vehicle` and `load_flight_condition` find the vehicle by. `tau_beta`,
    `dead_band`: duration of the wind, and K. `plane` ({"pitch", "yaw"}): plane of the wind. `peak`:
    its peak [rad], at the vehicle's own time. `engine`: one of `ENGINES`. `along`: whether the
    parameters vary along the trajectory, which planar flights know; frozen where not. `tolerance`:
    same as in `flown_boundary`.
    """
    vehicle = load_vehicle(name)
    options: dict[str, Any] = {}
    if along:
        options = {"frozen": False, "condition": load_flight_condition(name)}
    wind = centred_wind(vehicle, peak, tau_beta)
    return flown_boundary(
        vehicle, wind, dead_band, engine=engine, plane=plane, tolerance=tolerance, **options
    ).limit


def centred_wind(vehicle: Vehicle, peak: float, tau_beta: float) -> History:
    """Return the triangular wind of a given tau p that has its peak at the vehicle's time."""
    wind = TriangularWind(peak=peak, duration=tau_beta / Coefficients.from_vehicle(vehicle).pole)
    peak_time = 0.0 if vehicle.time is None else float(np.asarray(vehicle.time))
    return wind.shift(peak_time - wind.duration / 2.0)


TAU_BETA = (1.0, 2.0, 4.0, 8.0, 14.0, 20.0)
ALONG = {
    "along the trajectory, tail wind": ("pitch", PEAK),
    "along the trajectory, head wind": ("pitch", -PEAK),
    "along the trajectory, yaw": ("yaw", PEAK),
}
"""Plane and peak [rad] of the winds that are flown with varying parameters."""
_FIXED, _DRIFT = "without drift, eq (12)", "with drift, eq (18)"
_CURVES = np.linspace(0.05, 20.0, 400)


def figure_10(
    vehicle: str = "configuration-i",
    dead_bands: Sequence[float] = (1.0, 0.5),
    *,
    tau_beta: ArrayLike = TAU_BETA,
    along: ArrayLike = 4.0,
    engine: str | None = None,
) -> ControlPlot:
    """Draw the report's figure 10: the boundary of configuration I, theoretical and flown.

    Parameters
    ----------
    vehicle : str
        What `load_vehicle` and `load_flight_condition` find a vehicle by.
    dead_bands : sequence of float
        K, one for each panel.
    tau_beta : array_like
        Durations of the winds that are flown with frozen parameters, ``(n,)``, positive.
    along : array_like
        Durations of those that are flown along the trajectory, ``(m,)``, and in any case also by
        planar flights with frozen parameters. Their peak is at the vehicle's own time.
    engine : {"sixdof", "planar"}, optional
        What flies with frozen parameters; JSBSim where it is installed, else "planar".

    Raises
    ------
    InputError
        For durations that are not positive, an unknown engine, and as `load_flight_condition`.

    Notes
    -----
    The points of the report are not printed as numbers. All winds here are of 1 degree, which is
    assumed. Along the trajectory planar equations are flown, and what the report does not give is
    assumed too.
    """
    return _figure(10, vehicle, dead_bands, tau_beta=tau_beta, along=along, engine=engine)


def figure_11(
    vehicle: str = "configuration-ii", dead_bands: Sequence[float] = (1.0, 0.5), **options: Any
) -> ControlPlot:
    """Draw the report's figure 11: the boundary of configuration II, theoretical and flown.

    Parameters
    ----------
    vehicle, dead_bands, **options
        Same as in `figure_10`.
    """
    return _figure(11, vehicle, dead_bands, **options)


def _figure(
    number: int,
    name: str,
    dead_bands: Sequence[float],
    *,
    tau_beta: ArrayLike = TAU_BETA,
    along: ArrayLike = 4.0,
    engine: str | None = None,
) -> ControlPlot:
    """Return figure 10 or 11."""
    flies = chosen_engine(engine)
    instance("vehicle", name, str, "what load_vehicle finds it by")
    fractions = one_row("dead_bands", np.atleast_1d(within("dead_bands", dead_bands, 0.0, 1.0)))
    durations = [one_row("tau_beta", np.atleast_1d(within("tau_beta", tau_beta, 1e-6, 1e6)))]
    trajectory = np.atleast_1d(positive("along", along))
    durations.append(one_row("along", trajectory) if trajectory.size else trajectory.ravel())
    x = np.unique(np.concatenate([_CURVES, *durations]))
    vehicle = load_vehicle(name)
    columns = [
        column
        for letter, K in zip("abcdefghij", fractions.tolist(), strict=False)
        for column in _panel(f"({letter}) K = {K:g}", name, K, x, durations, flies)
    ]
    c = Coefficients.from_vehicle(vehicle)
    what = f"triangular wind of 1 deg, y_BR; {drift_words(c)}; flown within 0.0015"
    curves = Curves(f"figure-{number}", what, ABSCISSA.format(c.pole_symbol), x, tuple(columns))
    look = Look(
        title=f"Figure {number}. Stability boundary, theoretical and flown\n{vehicle.name or name};"
        " winds of 1 deg, parameters frozen unless flown along the trajectory",
        ordinate=ORDINATE,
        styles=_styles(flies),
        limits=dict.fromkeys(curves.panels, (0.0, 1.02)),
    )
    plot = draw(curves, look)
    for axes in plot.axes.flat:
        axes.set_xlim(0.0, 1.03 * float(x.max()))
    return plot


def _panel(
    panel: str, name: str, K: float, x: FloatArray, durations: Sequence[FloatArray], engine: str
) -> list[Column]:
    """Return the curves of one dead band."""
    c = Coefficients.from_vehicle(load_vehicle(name))
    limits_of = {
        _FIXED: np.asarray(triangular_limit(x, K)),
        _DRIFT: np.asarray(triangular_limit_with_drift(x, K, c.pole, c.b1, c.b2)),
    }
    frozen, along = durations
    for which in _engines(engine):
        places = frozen if which == engine else along
        limits = [flown_limit(name, b, K, engine=which) for b in places.tolist()]
        limits_of[_flown(which)] = _at(x, places, limits)
    for label, (plane, peak) in ALONG.items():
        limits = [
            flown_limit(name, b, K, plane=plane, peak=peak, along=True) for b in along.tolist()
        ]
        limits_of[label] = _at(x, along, limits)
    return [Column(label, values, panel=panel) for label, values in limits_of.items()]


def _engines(engine: str) -> list[str]:
    """Return the engines of a figure: the chosen one, and planar flights for comparison."""
    return list(dict.fromkeys([engine, "planar"]))


def _flown(engine: str) -> str:
    """Return the label of the flights of an engine."""
    return f"flown, {ENGINES[engine].words}"


def _at(x: FloatArray, places: FloatArray, values: Sequence[float]) -> FloatArray:
    """Return values at their abscissas among `x`, NaN elsewhere, ``(n,)``."""
    row = np.full(x.shape, np.nan)
    row[np.searchsorted(x, places)] = values
    return row


def _styles(engine: str) -> dict[str, Style]:
    """Return the line styles of theory and flights."""
    styles: dict[str, Style] = {
        _FIXED: {"color": "0.45", "ls": LINES[1], "lw": 1.6},
        _DRIFT: {"color": INK, "ls": "-", "lw": 2.0},
    }
    points: list[tuple[str, Any, str, float]] = [
        *zip(map(_flown, _engines(engine)), COLOURS[::4], "ox", (8.0, 6.0), strict=False),
        *zip(ALONG, (WARM, WARM, COLOURS[1]), "^vD", (7.0, 7.0, 6.0), strict=True),
    ]
    for label, colour, mark, size in points:
        styles[label] = {
            "color": colour,
            "ls": "",
            "marker": mark,
            "ms": size,
            "mfc": "none",
            "mew": 1.5,
        }
    return styles
