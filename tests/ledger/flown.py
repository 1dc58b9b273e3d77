"""The theory against flights, for the ledger: boundaries, convergence and divergence.

Flights are planar, which needs no engine; in JSBSim they are the same with frozen parameters.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from tests.ledger.cases import FULL, HALF, NAMES, attitude_with_drift, with_drift
from tvclin.ascent.nominal_flight import load_flight_condition
from tvclin.flights.engine_interface import ReportControl
from tvclin.flights.planar import fly_planar
from tvclin.plots.boundaries import centred_wind, flown_limit
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle_file import load_vehicle

TAU_BETA = 4.0
BELOW, ABOVE = 0.9, 1.1
"""Deflection limits of the attitudes, over the boundary of eq (18)."""
AFTER = 1.0
"""The time t/tau at which attitudes are compared; later some are beyond what can be flown."""
GOOD = 5.0
"""Percent within which boundaries are in good agreement."""


@dataclass(frozen=True)
class Gust:
    """A triangular wind: its plane, and its peak [deg], in pitch positive for a tail wind."""

    plane: str
    degrees: float

    @property
    def name(self) -> str:
        """Plane, sign and size in words."""
        if self.plane == "yaw":
            return f"yaw, {self.degrees:g} deg"
        return (
            f"pitch, {'tail' if self.degrees > 0.0 else 'head'} wind of {abs(self.degrees):g} deg"
        )


TAIL, HEAD, ACROSS = Gust("pitch", 1.0), Gust("pitch", -1.0), Gust("yaw", 1.0)
STRONG_TAIL, STRONG_HEAD, STRONG_ACROSS = Gust("pitch", 5.0), Gust("pitch", -5.0), Gust("yaw", 5.0)
GUSTS = {
    False: (TAIL, STRONG_HEAD, STRONG_ACROSS),
    True: (TAIL, STRONG_TAIL, HEAD, STRONG_HEAD, ACROSS, STRONG_ACROSS),
}
"""The winds that are flown with frozen parameters (False), where sign, size and plane hardly
matter, and along the trajectory (True)."""


@dataclass(frozen=True)
class Boundaries:
    """Boundary limits of I and II at K = 1 in one wind.

    Attributes
    ----------
    along : bool
        Whether they are flown along the trajectory; frozen where not.
    gust : Gust
        The wind.
    flown : tuple of float
        The limits, flown.
    excess : tuple of float
        By how many percent eq (18) is above.
    """

    along: bool
    gust: Gust
    flown: tuple[float, ...]
    excess: tuple[float, ...]

    @property
    def agree(self) -> tuple[bool, ...]:
        """Whether theory and flight are in good agreement."""
        return tuple(abs(percent) < GOOD for percent in self.excess)

    @property
    def conservative(self) -> tuple[bool, ...]:
        """Whether the theory asks for no less than the flight."""
        return tuple(percent >= 0.0 for percent in self.excess)


@dataclass(frozen=True)
class Attitudes:
    """Attitude errors over the peak of one wind at the end of the wind, with one dead band.

    Attributes
    ----------
    along, gust
        As of `Boundaries`.
    dead_band : float
        K.
    below, above : tuple of tuple of float
        For I and II, eq (B9) and the flight with the same limit, 0.9 and 1.1 times eq (18).
    """

    along: bool
    gust: Gust
    dead_band: float
    below: tuple[tuple[float, float], ...]
    above: tuple[tuple[float, float], ...]

    @property
    def diverges_faster(self) -> tuple[bool, ...]:
        """Whether the theory is further off than the flight."""
        return tuple(theory > flown for theory, flown in self.below)

    @property
    def converges_slower(self) -> tuple[bool, ...]:
        """Whether the theory has come down less than the flight."""
        return tuple(theory > flown for theory, flown in self.above)


@cache
def boundaries() -> tuple[Boundaries, ...]:
    """Return the flown boundaries, frozen and along the trajectory, in every wind."""
    return tuple(_boundaries(along, gust) for along in GUSTS for gust in GUSTS[along])


@cache
def attitudes() -> tuple[Attitudes, ...]:
    """Return the attitudes, frozen and along the trajectory, in every wind and with both K."""
    return tuple(
        Attitudes(along, gust, K, *(_attitudes(along, gust, K, f) for f in (BELOW, ABOVE)))
        for along in GUSTS
        for gust in GUSTS[along]
        for K in (FULL, HALF)
    )


def _boundaries(along: bool, gust: Gust) -> Boundaries:
    # frozen, the theory is off by so much less
    finer: dict[str, float] = {} if along else {"tolerance": 1e-3}
    flown, excess = [], []
    for name in NAMES:
        options = {"plane": gust.plane, "peak": float(np.radians(gust.degrees)), "along": along}
        limit = flown_limit(name, TAU_BETA, FULL, **options, **finer)
        theory = with_drift(Coefficients.from_vehicle(load_vehicle(name)), TAU_BETA, FULL)
        flown.append(limit)
        excess.append(100.0 * (theory / limit - 1.0))
    return Boundaries(along, gust, tuple(flown), tuple(excess))


def _attitudes(along: bool, gust: Gust, K: float, factor: float) -> tuple[tuple[float, float], ...]:
    return tuple(_attitude(name, along, gust, K, factor) for name in NAMES)


def _attitude(name: str, along: bool, gust: Gust, K: float, factor: float) -> tuple[float, float]:
    vehicle, peak = load_vehicle(name), float(np.radians(gust.degrees))
    c = Coefficients.from_vehicle(vehicle)
    wind = centred_wind(vehicle, peak, TAU_BETA)
    end = float(wind.onset) + AFTER * TAU_BETA / float(c.beta)
    flown = fly_planar(
        vehicle,
        ReportControl(K),
        wind,
        [float(wind.onset), end],
        deflection_limit=factor * with_drift(c, TAU_BETA, K) * abs(float(c.B) * peak),
        plane=gust.plane,
        condition=load_flight_condition(name) if along else None,
    )
    theory = float(attitude_with_drift(c, AFTER, TAU_BETA, factor, K))
    return theory, float(flown.outputs["attitude"][-1]) / -peak
