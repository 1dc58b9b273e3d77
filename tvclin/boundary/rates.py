"""Angle and rate together: the least deflection over the rate at which the nozzle turns.

With one unstable pole p that decides, (4b) integrated by parts asks of a deflection from rest

    integral of delta'(s) e^(-p s) ds = d0,

d0 the least peak at any rate. The earliest motion is worth most: a ramp at the full rate r, then a
hold. With f(x) = (1 - e^-x)/x

    d0 = d f(p d/r),    d = -(r/p) ln(1 - p d0/r),    r > p d0.

With an acceleration limit c too, from rest to rest, v is the rate that is reached:

    d0 = d f(p d/v) f(p v/c),    v = min(r, sqrt(c d)).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.documents import keyed
from tvclin.base.errors import (
    InputError,
    between,
    number,
    one_row,
    positive,
    small_angle,
    unlimited,
)
from tvclin.base.lines import Table, degrees, least
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.optimum.constraints import Constraints, constraints_of
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.boundary.optimum.rate_limit import optimum_with_rate_limit
from tvclin.linear.modes import poles_in_words, unstable_poles
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History

_MULTIPLES = (1.1, 1.25, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0)
"""Rates of a front over the least one, unless rates are given."""
_NOTHING = 1e-12
"""A part of the least angle that is none."""
_SIGN = 1e-12
"""What a wind of one sign may be beyond zero, over its peak."""
_RATES = (1e-15, 1e9)
"""Rates [rad/s] and accelerations that can be told from none, and from any."""
_ANY = float(np.radians(1.0))
"""A rate [rad/s] to begin with where none is needed."""
_FASTEST = 1e4
"""A rate so many times the least one is as good as any: the angle is within 5e-5 of the least."""


@dataclass(frozen=True, eq=False)
class RateFront(Shown):
    """The least deflection over the deflection rate, for one plant in one wind.

    Attributes
    ----------
    rates : ndarray
        Rate limits [rad/s], ``(n,)``.
    limits : ndarray
        Least deflection [rad] at each with the wind known beforehand, ``(n,)``; infinite where no
        angle is enough.
    bounds : ndarray or None
        Lower bound [rad] of every law that does not know when the wind will stop, ``(n,)``, of the
        rate alone; None for a wind that changes its sign.
    least_deflection, least_rate : float
        The least angle [rad] at any rate, and the rate [rad/s] that must be exceeded at any angle.
    least_rate_blind : float
        The same rate [rad/s] without a forecast, by the bound.
    acceleration_limit : float
        Largest deflection acceleration [rad/s2] that the limits have; infinite if none.
    limit, rate_limit : float or None
        The nozzle's [rad, rad/s].
    needed : float
        The larger of limit and bound [rad], at the nozzle's rate or else at any.
    needed_rate : float
        The least rate [rad/s], by the larger of both, at the nozzle's angle or else at any.
    """

    rates: FloatArray
    limits: FloatArray
    bounds: FloatArray | None
    least_deflection: float
    least_rate: float
    least_rate_blind: float
    acceleration_limit: float
    limit: float | None
    rate_limit: float | None
    needed: float
    needed_rate: float

    as_dict = keyed(
        "rates_deg_per_s limits_deg bounds_deg least_deflection_deg least_rate_deg_per_s"
        " least_rate_blind_deg_per_s acceleration_limit_deg_per_s2 limit_deg"
        " rate_limit_deg_per_s needed_deg needed_rate_deg_per_s left_deg left_rate_deg_per_s enough"
    )
    _keys = (
        "least_deflection_deg least_rate_deg_per_s limit_deg needed_deg rate_limit_deg_per_s"
        " needed_rate_deg_per_s enough"
    )

    @property
    def left(self) -> float | None:
        """Angle [rad] that is left over what is needed."""
        return None if self.limit is None else self.limit - self.needed

    @property
    def left_rate(self) -> float | None:
        """Rate [rad/s] that is left over what is needed."""
        return None if self.rate_limit is None else self.rate_limit - self.needed_rate

    @property
    def enough(self) -> bool | None:
        """Whether the nozzle's point is on the front or above; None where nothing is given.

        Of a limit or a rate limit alone, whether the other can make it enough.
        """
        if self.limit is None:
            return None if self.rate_limit is None else bool(np.isfinite(self.needed))
        if self.rate_limit is None:
            return bool(np.isfinite(self.needed_rate))
        return self.limit >= self.needed

    @property
    def _known(self) -> bool:
        """Whether it would be enough for who knows the wind; a faster nozzle needs no more."""
        fastest, limit = np.inf if self.rate_limit is None else self.rate_limit, self.limit
        can = np.isfinite(self.limits) & (self.limits <= (np.inf if limit is None else limit))
        free = self.rate_limit is None and limit is not None and self.least_deflection < limit
        return free or bool(np.any(can & (self.rates <= fastest)))

    @property
    def verdict(self) -> str:
        """Whether that is enough, in words."""
        if self.enough is None:
            return "nothing is asked; give a limit and a rate limit"
        if not self.enough:
            return f"NOT enough, {'without a forecast' if self._known else 'whatever the control'}"
        lacks = {"limit": self.limit, "rate limit": self.rate_limit}
        with_it = [f", with the {name} needed" for name, there in lacks.items() if there is None]
        return "".join(["enough by theory", *with_it])

    def tables(self) -> tuple[Table, ...]:
        """Return the front, and the nozzle's point beside what is needed."""
        blank = np.full(self.rates.size, np.nan)
        columns = {
            "rate": self.rates,
            "limit": self.limits,
            "bound": blank if self.bounds is None else self.bounds,
        }
        rows = tuple(
            tuple(least(degrees(f"front.{k}.{name}", x[k])) for name, x in columns.items())
            for k in range(self.rates.size)
        )
        head = ("rate limit [deg/s]", "wind known [deg]", "no forecast, at least [deg]")
        both = (
            ("limit [deg]", "limit", self.needed, self.limit, self.left),
            ("rate limit [deg/s]", "rate", self.needed_rate, self.rate_limit, self.left_rate),
        )
        point = tuple(
            (
                (label,),
                least(degrees(f"nozzle.{key}.needed", needed)),
                degrees(f"nozzle.{key}.there", np.nan if there is None else there),
                degrees(f"nozzle.{key}.left", np.nan if left in (None, -np.inf) else left),
            )
            for label, key, needed, there, left in both
        )
        return (
            Table("Least deflection over the rate limit", head, rows),
            Table(
                "Both at once: the limit at that rate, the rate limit at that angle",
                ("", "needed", "there", "left"),
                point,
            ),
        )

    @property
    def notes(self) -> Iterator[str]:
        """What the reader of the front should know."""
        if self.least_deflection == 0.0:
            yield "no unstable pole feels the wind: neither angle nor rate is needed"
        elif self.bounds is None:
            yield "the wind changes its sign: there is no bound for laws without a forecast"
        else:
            yield "without a forecast it is a lower bound: a law may need more angle and more rate"


def ramped_deflection(
    least: ArrayLike, pole: float, rate: ArrayLike, acceleration: ArrayLike = np.inf
) -> FloatArray:
    """Return the least deflection [rad] under limits of rate and acceleration, of one pole.

    `least`: d0 [rad], the least deflection at any rate, positive. `pole`: the unstable pole p
    [1/s]. `rate`, `acceleration`: their limits r [rad/s] and c [rad/s2], which broadcast with
    `least`; both may be infinite. Returned: infinite where no deflection is enough.
    """
    d0, r, c = np.broadcast_arrays(
        *(np.asarray(x, dtype=float) for x in (least, rate, acceleration))
    )
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        # full rate: d0 p/(r f(p r/c)) = 1 - e^(-p d/r), with r f(p r/c) = (c/p)(1 - e^(-p r/c))
        worth = np.where(np.isinf(c), r, -(c / pole) * np.expm1(-pole * r / c))
        held = np.where(np.isinf(r), d0, -(r / pole) * _log1m(d0 * pole / worth))
        # full rate is never reached: d0 = d f(x)^2 with x = p sqrt(d/c)
        x = -_log1m(pole * np.sqrt(d0 / c))
        short = np.where(np.isinf(c), d0, c * (x / pole) ** 2)
        return np.where(c * short < r**2, short, held)


def ramp_rate(least: ArrayLike, pole: ArrayLike, deflection: ArrayLike) -> FloatArray:
    """Return the least deflection rate [rad/s] at a limit, of one pole.

    It is `ramped_deflection` turned round: d0 = d f(x) with x = p d/r, which Lambert's W solves.

    Parameters
    ----------
    least, pole, deflection : array_like
        d0 [rad], p [1/s] and the limit d [rad], which broadcast.

    Returns
    -------
    ndarray
        Zero where nothing is needed, and infinite where no rate is enough.
    """
    from scipy.special import lambertw

    d0, p, d = np.broadcast_arrays(*(np.asarray(x, float) for x in (least, pole, deflection)))
    with np.errstate(invalid="ignore", divide="ignore"):
        over = np.maximum(d / d0, 1.0)
        x = over + np.real(lambertw(-over * np.exp(-over)))
        return np.where(d0 <= 0.0, 0.0, np.where(over > 1.0, p * d / x, np.inf))


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
    return RateFront(
        rates=at,
        limits=np.array([case.known(float(rate)) for rate in at]),
        bounds=None if blind is None else ramped_deflection(blind, case.pole, at),
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
    )


@dataclass(frozen=True)
class _Case:
    """A plant in a wind, from its onset on: the conditions, and the least angles at any rate."""

    plant: Plant
    wind: History
    constraints: Constraints
    acceleration: float
    least: float
    blind: float | None

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

    def known(self, rate: float) -> float:
        """The least deflection [rad] at a rate limit, the wind known; infinite if none suffices."""
        found = float(ramped_deflection(self.alone, self.pole, rate, self.acceleration))
        if self.least == 0.0 or np.isinf(found) or self._one_pole(found, rate):
            return found
        if np.isfinite(self.acceleration):
            raise InputError(
                "acceleration_limit needs a case that one unstable pole decides; leave it out"
            )
        start = float(self.wind.onset)
        try:
            return optimum_with_rate_limit(self.plant, self.wind, rate, start).peak
        except InputError:  # the rate is too small for the other poles
            return np.inf

    def needed(self, rate: float) -> float:
        """The larger of the least deflection and the bound without a forecast [rad]."""
        bound = 0.0 if self.blind is None else ramped_deflection(self.blind, self.pole, rate)
        return max(self.known(rate), float(bound))

    def needed_rate(self, limit: float) -> float:
        """The least rate [rad/s] at an angle [rad]; infinite if none is enough."""
        from scipy.optimize import brentq

        if self.least == 0.0:
            return 0.0
        lowest = max(self.least_rate, self.pole * (self.blind or 0.0)) or self.pole * self.least
        if self.needed(_FASTEST * lowest) > limit:
            return np.inf

        def excess(times: float) -> float:
            return 1.0 / self.needed(float(np.exp(times)) * lowest) - 1.0 / limit

        if excess(_NOTHING) >= 0.0:
            return lowest
        return lowest * float(np.exp(brentq(excess, _NOTHING, np.log(_FASTEST), xtol=1e-10)))

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


def _case_of(plant: Plant, wind: History, acceleration: float) -> _Case:
    start = float(wind.onset) if isinstance(wind, History) and not wind.batch else 0.0
    constraints = constraints_of(plant, wind, start if np.isfinite(start) else 0.0)
    poles = constraints.poles
    if poles.size and np.imag(poles[0]):
        raise InputError(
            "plant must have a real unstable pole as its fastest; it has"
            f" {poles_in_words(unstable_poles(plant))}"
        )
    least, low, high = optimum_deflection(plant, wind, start).peak, *wind.extent
    blind: float | None = 0.0
    if min(-float(low), float(high)) > _SIGN * abs(float(wind.peak)):
        blind = None
    elif least > 0.0:
        blind = abs(float(forecast_free_limit(plant, wind).deflection))
    return _Case(plant, wind, constraints, acceleration, least, blind)


def _log1m(x: FloatArray) -> FloatArray:
    """ln(1 - x), and minus infinity from x = 1 on."""
    return np.where(x < 1.0, np.log1p(-np.minimum(x, 1.0)), -np.inf)
