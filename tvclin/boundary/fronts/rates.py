"""Angle and rate together: the least deflection of a plant over its rate limit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.errors import (
    InputError,
    between,
    number,
    one_row,
    positive,
    small_angle,
    unlimited,
)
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.fronts.ramps import ramped_deflection
from tvclin.boundary.fronts.rate_record import RateFront
from tvclin.boundary.optimum.constraints import Constraints, constraints_of
from tvclin.boundary.optimum.minimum_peak import Optimum, optimum_deflection
from tvclin.boundary.optimum.rate_limit import minimum_peak_at_rate
from tvclin.linear.modes import poles_text, unstable_poles
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History

_MULTIPLES = (1.1, 1.25, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0)
"""Rates of a front over the least one, unless rates are given."""
_NOTHING = 1e-12
"""A part of the least angle that is none."""
_EQUAL = 1e-10
"""A part by which a rate or an angle may differ and be the same."""
_RATES = (1e-15, 1e9)
"""Rates [rad/s] and accelerations that can be told from none, and from any."""
_ANY = float(np.radians(1.0))
"""A rate [rad/s] to begin with where none is needed."""
_FASTEST = 1e4
"""A rate so many times the least one is as good as any: the angle is within 5e-5 of the least."""


def rate_front(
    plant: Plant,
    wind: History,
    rates: ArrayLike | None = None,
    *,
    limit: float | None = None,
    rate_limit: float | None = None,
    acceleration_limit: float = np.inf,
) -> RateFront:
    """Return the least deflection over the rate limit, from the onset of the wind on.

    Parameters
    ----------
    plant : Plant
        One plant whose fastest unstable pole is real.
    wind : History
        One wind that ends.
    rates : array_like, optional
        Rate limits [rad/s], ``(n,)``; unless given 1.1 to 20 times the least one, and that
        of the nozzle.
    limit, rate_limit : float, optional
        The nozzle's [rad, rad/s].
    acceleration_limit : float
        Largest deflection acceleration [rad/s2]; none by default. It takes a case of one pole.

    Raises
    ------
    InputError
        As `optimum_deflection`; for a fastest pole that is not real, limits that are not positive,
        a rate limit of the nozzle or an acceleration with which no angle is enough, and an
        acceleration limit where two poles decide.

    Notes
    -----
    Where other unstable poles take part, as that of the flight path after long winds, the limits
    are those of `optimum_with_rate_limit`. Without a forecast the bound is that of a state which
    both a stop and the wind still to come must leave recoverable, y* of `forecast_free_limit` in
    the place of d0.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> wind = tv.TriangularWind(peak=-0.1, duration=7.5)
    >>> front = tv.boundary.rate_front(plant, wind, [0.005, 0.05])
    >>> (front.limits / front.least_deflection).round(2).tolist()
    [1.28, 1.02]
    """
    c = unlimited("acceleration_limit", acceleration_limit, between(*_RATES), "rad/s2")
    angle, turning = small_angle("a deflection", positive), between(*_RATES)
    most = None if limit is None else number("limit", limit, angle, "rad")
    there = None if rate_limit is None else number("rate_limit", rate_limit, turning, "rad/s")
    given = None if rates is None else turning("rates", one_row("rates", rates, "rad/s"), "rad/s")
    case = _case_of(plant, wind, c)
    least_rate = case.least_rate
    if there is not None and there <= least_rate:
        raise InputError(
            "rate_limit is too small for any deflection to survive this wind; got"
            f" {np.degrees(there):.4g} deg/s, and more than {np.degrees(least_rate):.6g} deg/s"
            f" ({least_rate:.6g} rad/s) is needed"
        )
    blind = case.blind
    usual = np.asarray(_MULTIPLES) * (least_rate or case.pole * case.least or _ANY)
    if there is not None:
        usual = np.unique(np.append(usual, there))
    at = usual if given is None else given
    limits = np.array([case.known(float(rate)) for rate in at])
    bounds = None if blind is None else np.maximum(ramped_deflection(blind, case.pole, at), limits)
    front = RateFront(
        rates=at,
        limits=limits,
        bounds=bounds,
        least_deflection=case.least,
        least_rate=least_rate,
        least_rate_blind=np.nan if blind is None else case.pole * blind,
        acceleration_limit=c,
        limit=most,
        rate_limit=there,
        needed=case.needed(there) if there is not None else max(case.least, blind or 0.0),
        needed_rate=(
            case.needed_rate(most)
            if most is not None
            else max(least_rate, case.pole * (blind or 0.0))
        ),
        angle=abs(float(wind.peak)),
    )
    return replace(front, needed=np.nan, needed_rate=np.nan) if front.beyond else front


@dataclass(frozen=True, eq=False)
class _Case:
    """A plant in a wind, from its onset on: the conditions, and the least angles at any rate."""

    wind: History
    constraints: Constraints
    unlimited: Optimum
    acceleration: float
    blind: float | None

    @property
    def least(self) -> float:
        """The least deflection [rad] at any rate."""
        return self.unlimited.peak

    @property
    def pole(self) -> float:
        """The fastest unstable pole [1/s]; 1 where there is none."""
        return float(np.real(self.constraints.poles[0])) if self.constraints.poles.size else 1.0

    @property
    def alone(self) -> float:
        """The least deflection [rad] that the fastest pole asks for."""
        demands = self.constraints.demands
        return self.pole * abs(float(demands[0])) if demands.size else 0.0

    @property
    def least_rate(self) -> float:
        """The rate [rad/s] that must be exceeded; `InputError` for too low an acceleration."""
        p, c = self.pole, self.acceleration
        if self.least > 0.0 and c <= p**2 * self.alone:
            raise InputError(
                f"acceleration_limit must be above {p**2 * self.alone:.6g} rad/s2, or no deflection"
                f" survives this wind; got {c:.6g} rad/s2"
            )
        return p * self.alone if np.isinf(c) else -c / p * float(np.log1p(-(p**2) * self.alone / c))

    @cached_property
    def known(self) -> Callable[[float], float]:
        """The least deflection [rad] at a rate limit, the wind known; infinite if none suffices."""
        return cache(self._known)

    def _known(self, rate: float) -> float:
        found = self.by_one_pole(rate)
        if self.least == 0.0 or np.isinf(found) or self._one_pole(found, rate):
            return found
        if np.isfinite(self.acceleration):
            raise InputError(
                "acceleration_limit needs a case that one unstable pole decides; leave it out"
            )
        return minimum_peak_at_rate(self.constraints, self.unlimited, float(self.wind.onset), rate)

    def by_one_pole(self, rate: float) -> float:
        """The least deflection [rad], the wind known, if the fastest pole alone decides."""
        return float(ramped_deflection(self.alone, self.pole, rate, self.acceleration))

    def unforeseen(self, rate: float) -> float:
        """The bound without a forecast [rad]; zero where none is known."""
        return float(ramped_deflection(self.blind or 0.0, self.pole, rate))

    def needed(self, rate: float) -> float:
        """The larger of the least deflection and the bound without a forecast [rad]."""
        return max(self.known(rate), self.unforeseen(rate))

    def needed_rate(self, limit: float) -> float:
        """The least rate [rad/s] at an angle [rad]; infinite if none is enough.

        The fastest pole alone asks for a rate in closed form, which other poles can only raise.
        """
        if self.least == 0.0:
            return 0.0
        lowest = max(self.least_rate, self.pole * (self.blind or 0.0)) or self.pole * self.least
        alone = _least_rate(lambda r: max(self.by_one_pole(r), self.unforeseen(r)), limit, lowest)
        if np.isinf(alone) or self.known(alone) <= limit * (1.0 + _EQUAL):
            return alone
        return _least_rate(self.known, limit, alone)

    def _one_pole(self, d: float, rate: float) -> bool:
        """Whether the other unstable pole q takes nothing from the fast one.

        It is met by going to -d at a time t, after which the fast one counts e^(-p t): with v and
        f as above, and d2 what q alone asks for,

            (v/q) f(q v/c) (1 - e^(-q d/v) - e^(-q t) (1 - e^(-2 q d/v))) = d2.
        """
        poles, demands, c = self.constraints.poles, self.constraints.demands, self.acceleration
        if poles.size == 1:
            return True
        if poles.size > 2 or not self.constraints.real or d == 0.0:
            return False
        p, q = poles
        v = min(rate, float(np.sqrt(c * d)))
        worth = v / q if np.isinf(c) else -(c / q**2) * np.expm1(-q * v / c)
        asked = q * demands[1] * np.sign(demands[0])
        later = (-np.expm1(-q * d / v) - asked / worth) / -np.expm1(-2.0 * q * d / v)  # e^(-q t)
        return bool(0.0 <= later <= np.exp(-q * (d / v + v / c)) and later ** (p / q) < _NOTHING)


def _least_rate(needed: Callable[[float], float], limit: float, lowest: float) -> float:
    """The least rate [rad/s] above `lowest` with a deflection within a limit, or infinite."""
    from scipy.optimize import brentq

    if needed(_FASTEST * lowest) > limit:
        return np.inf

    def excess(times: float) -> float:
        return 1.0 / needed(float(np.exp(times)) * lowest) - 1.0 / limit

    if excess(_NOTHING) >= 0.0:
        return lowest
    return lowest * float(np.exp(brentq(excess, _NOTHING, np.log(_FASTEST), xtol=_EQUAL)))


def _case_of(plant: Plant, wind: History, acceleration: float) -> _Case:
    start = float(wind.onset) if isinstance(wind, History) and not wind.batch else 0.0
    constraints = constraints_of(plant, wind, start if np.isfinite(start) else 0.0)
    poles = constraints.poles
    if poles.size and np.imag(poles[0]):
        raise InputError(
            "plant must have a real unstable pole as its fastest; it has"
            f" {poles_text(unstable_poles(plant))}"
        )
    unlimited = optimum_deflection(plant, wind, start)
    blind: float | None = 0.0
    if not wind.constant_sign:
        blind = None
    elif unlimited.peak > 0.0:
        blind = abs(float(forecast_free_limit(plant, wind).deflection))
    return _Case(wind, constraints, unlimited, acceleration, blind)
