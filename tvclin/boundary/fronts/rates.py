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
"""Default rates of a front, relative to the smallest one."""
_NEGLIGIBLE = 1e-12
"""Size, relative to one, that counts as zero."""
_RELATIVE_TOLERANCE = 1e-10
"""Relative tolerance of a rate or an angle."""
_RATE_RANGE = (1e-15, 1e9)
"""Smallest and largest rate [rad/s] and acceleration that differ from zero and infinity."""
_DEFAULT_RATE = float(np.radians(1.0))
"""First rate of a front [rad/s] where none is required."""
_MAX_RATE_RATIO = 1e4
"""Largest rate over the smallest one, at which the angle is within 5e-5 of the minimum."""


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
        Rate limits [rad/s], ``(n,)``; by default 1.1 to 20 times the smallest one, and
        the nozzle's.
    limit, rate_limit : float, optional
        Limits of the nozzle [rad, rad/s].
    acceleration_limit : float
        Largest deflection acceleration [rad/s2]; none by default. It takes a case of one pole.

    Raises
    ------
    InputError
        Where `optimum_deflection` raises it; for a fastest pole that is not real, limits that are
        not positive, a rate limit of the nozzle or an acceleration with which no angle is enough,
        and an acceleration limit where two poles decide.

    Notes
    -----
    Where other unstable poles contribute, such as the flight path's after long winds,
    the limits are those of `optimum_with_rate_limit`. Without a forecast the bound is that of a
    state that must be recoverable after a stop and after the remaining wind, y* of
    `forecast_free_limit` in the place of d0.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> wind = tv.TriangularWind(peak=-0.1, duration=7.5)
    >>> front = tv.boundary.rate_front(plant, wind, [0.005, 0.05])
    >>> (front.limits / front.least_deflection).round(2).tolist()
    [1.28, 1.02]
    """
    c = unlimited("acceleration_limit", acceleration_limit, between(*_RATE_RANGE), "rad/s2")
    angle, turning = small_angle("a deflection", positive), between(*_RATE_RANGE)
    nozzle_limit = None if limit is None else number("limit", limit, angle, "rad")
    nozzle_rate = None if rate_limit is None else number("rate_limit", rate_limit, turning, "rad/s")
    requested = (
        None if rates is None else turning("rates", one_row("rates", rates, "rad/s"), "rad/s")
    )
    case = _case_of(plant, wind, c)
    minimum_rate = case.minimum_rate
    if nozzle_rate is not None and nozzle_rate <= minimum_rate:
        raise InputError(
            "rate_limit is too small for any deflection to survive this wind; got"
            f" {np.degrees(nozzle_rate):.4g} deg/s, and more than"
            f" {np.degrees(minimum_rate):.6g} deg/s ({minimum_rate:.6g} rad/s) is needed"
        )
    blind = case.blind
    usual = np.asarray(_MULTIPLES) * (minimum_rate or case.pole * case.minimum or _DEFAULT_RATE)
    if nozzle_rate is not None:
        usual = np.unique(np.append(usual, nozzle_rate))
    at = usual if requested is None else requested
    limits = np.array([case.deflection(float(rate)) for rate in at])
    bounds = None if blind is None else np.maximum(ramped_deflection(blind, case.pole, at), limits)
    front = RateFront(
        rates=at,
        limits=limits,
        bounds=bounds,
        least_deflection=case.minimum,
        least_rate=minimum_rate,
        least_rate_blind=np.nan if blind is None else case.pole * blind,
        acceleration_limit=c,
        limit=nozzle_limit,
        rate_limit=nozzle_rate,
        needed=case.needed(nozzle_rate)
        if nozzle_rate is not None
        else max(case.minimum, blind or 0.0),
        needed_rate=(
            case.needed_rate(nozzle_limit)
            if nozzle_limit is not None
            else max(minimum_rate, case.pole * (blind or 0.0))
        ),
        angle=abs(float(wind.peak)),
    )
    return replace(front, needed=np.nan, needed_rate=np.nan) if front.beyond else front


@dataclass(frozen=True, eq=False)
class _Case:
    """A plant in a wind, from its onset on: its conditions and least deflections."""

    wind: History
    constraints: Constraints
    unlimited: Optimum
    acceleration: float
    blind: float | None

    @property
    def minimum(self) -> float:
        """Least deflection [rad] at any rate."""
        return self.unlimited.peak

    @property
    def pole(self) -> float:
        """Fastest unstable pole [1/s]; 1 without one."""
        return float(np.real(self.constraints.poles[0])) if self.constraints.poles.size else 1.0

    @property
    def fast_deflection(self) -> float:
        """Least deflection [rad] for the condition of the fastest pole."""
        demands = self.constraints.demands
        return self.pole * abs(float(demands[0])) if demands.size else 0.0

    @property
    def minimum_rate(self) -> float:
        """Rate [rad/s] that must be exceeded; `InputError` for too low an acceleration."""
        p, c = self.pole, self.acceleration
        if self.minimum > 0.0 and c <= p**2 * self.fast_deflection:
            raise InputError(
                f"acceleration_limit must be above {p**2 * self.fast_deflection:.6g} rad/s2, or no"
                f" deflection survives this wind; got {c:.6g} rad/s2"
            )
        return (
            p * self.fast_deflection
            if np.isinf(c)
            else -c / p * float(np.log1p(-(p**2) * self.fast_deflection / c))
        )

    @cached_property
    def deflection(self) -> Callable[[float], float]:
        """Least deflection [rad] at a rate limit, the wind known; infinite if none suffices."""
        return cache(self._deflection)

    def _deflection(self, rate: float) -> float:
        """Return `deflection` at a rate limit [rad/s], without the cache."""
        deflection = self.single_pole_deflection(rate)
        if (
            self.minimum == 0.0
            or np.isinf(deflection)
            or self._decided_by_one_pole(deflection, rate)
        ):
            return deflection
        if np.isfinite(self.acceleration):
            raise InputError(
                "acceleration_limit needs a case that one unstable pole decides; leave it out"
            )
        return minimum_peak_at_rate(self.constraints, self.unlimited, float(self.wind.onset), rate)

    def single_pole_deflection(self, rate: float) -> float:
        """Return the least deflection [rad], the wind known, if the fastest pole alone decides."""
        return float(ramped_deflection(self.fast_deflection, self.pole, rate, self.acceleration))

    def unforeseen(self, rate: float) -> float:
        """Return the bound without a forecast [rad]; zero without one."""
        return float(ramped_deflection(self.blind or 0.0, self.pole, rate))

    def needed(self, rate: float) -> float:
        """Return the larger of the least deflection and the bound without a forecast [rad]."""
        return max(self.deflection(rate), self.unforeseen(rate))

    def needed_rate(self, limit: float) -> float:
        """Return the least rate [rad/s] at a limit [rad]; infinite if none is sufficient.

        The fastest pole alone requires a rate in closed form, which other poles can only raise.
        """
        if self.minimum == 0.0:
            return 0.0
        lowest = max(self.minimum_rate, self.pole * (self.blind or 0.0)) or self.pole * self.minimum
        single_pole_rate = _minimum_rate(
            lambda r: max(self.single_pole_deflection(r), self.unforeseen(r)), limit, lowest
        )
        if np.isinf(single_pole_rate) or self.deflection(single_pole_rate) <= limit * (
            1.0 + _RELATIVE_TOLERANCE
        ):
            return single_pole_rate
        return _minimum_rate(self.deflection, limit, single_pole_rate)

    def _decided_by_one_pole(self, d: float, rate: float) -> bool:
        """Return whether the other unstable pole q does not raise the deflection.

        Its condition is satisfied by a motion to -d at a time t, after which the fast pole counts
        e^(-p t): with v and f of `ramps`, and the demand d2 of q,

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
        demand = q * demands[1] * np.sign(demands[0])
        later = (-np.expm1(-q * d / v) - demand / worth) / -np.expm1(-2.0 * q * d / v)  # e^(-q t)
        return bool(0.0 <= later <= np.exp(-q * (d / v + v / c)) and later ** (p / q) < _NEGLIGIBLE)


def _minimum_rate(needed: Callable[[float], float], limit: float, lowest: float) -> float:
    """Return the least rate [rad/s] above `lowest` with a deflection within a limit, or inf."""
    from scipy.optimize import brentq

    if needed(_MAX_RATE_RATIO * lowest) > limit:
        return np.inf

    def excess(times: float) -> float:
        return 1.0 / needed(float(np.exp(times)) * lowest) - 1.0 / limit

    if excess(_NEGLIGIBLE) >= 0.0:
        return lowest
    return lowest * float(
        np.exp(brentq(excess, _NEGLIGIBLE, np.log(_MAX_RATE_RATIO), xtol=_RELATIVE_TOLERANCE))
    )


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
