"""The cases of the report: its two vehicles, its winds, and the limits and responses in them."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from tests.ledger.computed import Value
from tests.report_responses import triangular_attitude, triangular_attitude_with_drift
from tvclin.boundary.closed_forms import triangular_limit, triangular_limit_with_drift
from tvclin.boundary.limit import boundary_limit
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle_file import load_vehicle
from tvclin.winds.pulses import TriangularWind

FULL, HALF, NONE = 1.0, 0.5, 0.0
"""The dead bands K of the report's text."""
PEAK = -0.1
"""Of the winds [rad]; the equations are linear, so it does not matter."""
NAMES = ("configuration-i", "configuration-ii")


@cache
def vehicles() -> tuple[Coefficients, Coefficients]:
    """Return the coefficients of the two vehicles of Table I."""
    first, second = (Coefficients.from_vehicle(load_vehicle(name)) for name in NAMES)
    return first, second


def both(label: str, function: Callable[[Coefficients], Any]) -> Value:
    """Return one quantity of both vehicles.

    Parameters
    ----------
    label : str
        As of `Value`.
    function : callable
        The quantity of one vehicle.
    """
    first, second = (float(function(c)) for c in vehicles())
    return Value(label, first, second)


def band(dead_band: float) -> str:
    """Return the words for a dead band."""
    return f"dead band {100.0 * dead_band:g} percent" if dead_band else "no dead band"


def gust(c: Coefficients, tau_beta: float) -> TriangularWind:
    """Return the triangular wind of a given tau beta."""
    return TriangularWind(peak=PEAK, duration=tau_beta / c.beta)


def without_drift(tau_beta: float, dead_band: float) -> float:
    """Return y_BR of eq (12)."""
    return float(triangular_limit(tau_beta, dead_band))


def with_drift(c: Coefficients, tau_beta: float, dead_band: float) -> float:
    """Return y_BR of eq (18)."""
    return float(triangular_limit_with_drift(tau_beta, dead_band, c.beta, c.b1, c.b2))


def on_model(
    c: Coefficients,
    tau_beta: float,
    dead_band: float,
    model: str = "drift-exact",
    switch: str = "report",
) -> float:
    """Return y_BR in a triangular wind on any model, from exact transforms."""
    wind = gust(c, tau_beta)
    return float(boundary_limit(Plant(c, model), wind, dead_band, switch).limit)


def drift_reduction(c: Coefficients, tau_beta: float, dead_band: float) -> float:
    """Return by how many percent eq (18) is below eq (12)."""
    return 100.0 * (1.0 - with_drift(c, tau_beta, dead_band) / without_drift(tau_beta, dead_band))


def drift_points(c: Coefficients, tau_beta: float, dead_band: float) -> float:
    """Return by how many points of trim eq (18) is below eq (12)."""
    return 100.0 * (without_drift(tau_beta, dead_band) - with_drift(c, tau_beta, dead_band))


def attitude(x: Any, tau_beta: float, factor: float, dead_band: float) -> Any:
    """Return eq (13) at x = t/tau, at `factor` times the boundary (12)."""
    limit = factor * without_drift(tau_beta, dead_band)
    return triangular_attitude(x, tau_beta, limit, dead_band)


def attitude_with_drift(
    c: Coefficients, x: Any, tau_beta: float, factor: float, dead_band: float
) -> Any:
    """Return eq (B9) as corrected at x = t/tau, at `factor` times the boundary (18)."""
    limit = factor * with_drift(c, tau_beta, dead_band)
    return triangular_attitude_with_drift(x, tau_beta, limit, dead_band, c.beta, c.b1, c.b2)


def zero(function: Callable[[float], Any], first: float, last: float) -> float:
    """Return the zero between two ends at which the function has opposite signs."""
    from scipy.optimize import brentq  # late: it takes 0.3 s to import

    return float(brentq(lambda x: float(function(x)), first, last, xtol=1e-12))


def summit(function: Callable[[float], Any], first: float, last: float) -> tuple[float, float]:
    """Return where a function with one peak between two ends has it, and how high it is."""
    from scipy.optimize import minimize_scalar

    options = {"xatol": 1e-9}
    best = minimize_scalar(
        lambda x: -float(function(x)), bounds=(first, last), method="bounded", options=options
    )
    return float(best.x), -float(best.fun)


def crossing(function: Callable[[Any], Any], last: float = 10.0) -> float:
    """Return the first time t/tau at which an attitude falls through zero; NaN where it does not.

    Parameters
    ----------
    function : callable
        Attitude of an array of t/tau; zero while the vehicle is trimmed.
    last : float
        Where the search ends.
    """
    times = np.linspace(0.0, last, 2001)
    values = np.asarray(function(times))
    falls = np.flatnonzero((values[:-1] > 1e-9) & (values[1:] <= 0.0))
    if not falls.size:
        return float("nan")
    return zero(function, float(times[falls[0]]), float(times[falls[0] + 1]))
