"""Angle of attack under trim and under the report's controls, for the ledger."""

from dataclasses import dataclass
from functools import cache

from tests.ledger.cases import FULL, HALF, NONE, gust, vehicles
from tvclin.boundary.limit import boundary_limit
from tvclin.linear.deflections import trim_deflection, trim_then_hold
from tvclin.linear.extremes import wind_loads
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import Coefficients

TAU_BETA = (4.0, 8.0, 20.0)
DEAD_BANDS = (FULL, HALF, NONE)


@dataclass(frozen=True)
class Case:
    """One vehicle, one model and one duration.

    Attributes
    ----------
    name : str
        Vehicle and model.
    tau_beta : float
        Duration of the triangular wind times beta.
    trim : float
        Peak angle of attack over the peak of the wind, with ideal trim throughout.
    held : tuple of float
        The same on the boundary, for each of `DEAD_BANDS`.
    """

    name: str
    tau_beta: float
    trim: float
    held: tuple[float, ...]


@cache
def cases() -> tuple[Case, ...]:
    """Return the cases: without drift, where vehicles make no difference, and I and II with it."""
    first, second = vehicles()
    plants = {
        "I, II; fixed path": Plant(first, "fixed-path"),
        "I; drift": Plant(first, "drift"),
        "II; drift": Plant(second, "drift"),
    }
    return tuple(
        Case(name, b, *_relative(plant, plant.coefficients, b))
        for name, plant in plants.items()
        for b in TAU_BETA
    )


def _relative(plant: Plant, c: Coefficients, tau_beta: float) -> tuple[float, tuple[float, ...]]:
    wind = gust(c, tau_beta)
    trim = wind_loads(plant, trim_deflection(plant, wind), wind).relative
    held = []
    for K in DEAD_BANDS:
        limit = boundary_limit(plant, wind, K).deflection
        held.append(wind_loads(plant, trim_then_hold(plant, wind, limit, K), wind).relative)
    return trim, tuple(held)
