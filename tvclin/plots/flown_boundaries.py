"""The boundary limit against the duration of the wind, theoretical and flown: figures 10 and 11."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import instance, one_row, positive, within
from tvclin.boundary.closed_forms import triangular_limit, triangular_limit_with_drift
from tvclin.flights.flown_boundary import ENGINES
from tvclin.plots.boundaries import ABSCISSA, ORDINATE, drift_words
from tvclin.plots.curves import Column, Curves
from tvclin.plots.flown_boundaries import PEAK, chosen_engine, flown_limit
from tvclin.plots.style import COLOURS, INK, LINES, WARM, Look, Style, draw
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.file import load_vehicle

if TYPE_CHECKING:
    from control import ControlPlot


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
        As of `figure_10`.
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
    flies = chosen_engine(engine)
    instance("vehicle", name, str, "what load_vehicle finds it by")
    fractions = one_row("dead_bands", np.atleast_1d(within("dead_bands", dead_bands, 0.0, 1.0)))
    durations = [one_row("tau_beta", np.atleast_1d(positive("tau_beta", tau_beta)))]
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
    c = Coefficients.from_vehicle(load_vehicle(name))
    found = {
        _FIXED: np.asarray(triangular_limit(x, K)),
        _DRIFT: np.asarray(triangular_limit_with_drift(x, K, c.pole, c.b1, c.b2)),
    }
    frozen, along = durations
    for which in _engines(engine):
        places = frozen if which == engine else along
        limits = [flown_limit(name, b, K, engine=which) for b in places.tolist()]
        found[_flown(which)] = _at(x, places, limits)
    for label, (plane, peak) in ALONG.items():
        limits = [
            flown_limit(name, b, K, plane=plane, peak=peak, along=True) for b in along.tolist()
        ]
        found[label] = _at(x, along, limits)
    return [Column(label, values, panel=panel) for label, values in found.items()]


def _engines(engine: str) -> list[str]:
    """Planar flights stand beside those of another engine, but at fewer places."""
    return list(dict.fromkeys([engine, "planar"]))


def _flown(engine: str) -> str:
    return f"flown, {ENGINES[engine].words}"


def _at(x: FloatArray, places: FloatArray, values: Sequence[float]) -> FloatArray:
    """The values at their places among the abscissas, NaN elsewhere."""
    row = np.full(x.shape, np.nan)
    row[np.searchsorted(x, places)] = values
    return row


def _styles(engine: str) -> dict[str, Style]:
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
