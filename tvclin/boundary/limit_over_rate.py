"""Trade-off of angle and rate: the minimum deflection limit of a plant over its rate limit.

With one unstable pole p that decides, (4b) integrated by parts is, for a deflection from rest,

    integral of delta'(s) e^(-p s) ds = d0,

d0 the minimum peak without a rate limit. The earliest motion has the largest weight: a ramp at the
full rate r, then a constant. With f(x) = (1 - e^-x)/x

    d0 = d f(p d/r),    d = -(r/p) ln(1 - p d0/r),    r > p d0.

With an acceleration limit c too, from rest to rest, v is the rate that is reached:

    d0 = d f(p d/v) f(p v/c),    v = min(r, sqrt(c d)).

Where a second pole contributes the limits are the same as in `optimum_with_rate_limit`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.fields import array_table, cells, columns, derived, record_table, spec
from tvclin.base.lines import NONE_SUFFICIENT, Table
from tvclin.base.quantities import (
    FORECAST_FREE,
    NO_FORECAST,
    REQUIRED_RATE,
    WIND_KNOWN,
    sufficiency,
)
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.optimum.minimum_peak import Optimum, optimum_under
from tvclin.boundary.optimum.moments import Constraints, constraints_of
from tvclin.boundary.optimum.rate_limit import RATE_RANGE, minimum_peak_at_rate
from tvclin.linear.modes import poles_text, unstable_poles
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import beyond_linear, linear_notes

_ROUNDING = 1e-9
"""Relative tolerance of two equal lower bounds."""
_MULTIPLES = (1.1, 1.25, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0)
"""Default rates of a trade-off, relative to the smallest one."""
_NEGLIGIBLE = 1e-12
"""Size, relative to one, that counts as zero."""
_RELATIVE_TOLERANCE = 1e-10
"""Relative tolerance of a rate or an angle."""
_DEFAULT_RATE = float(np.radians(1.0))
"""First rate of a trade-off [rad/s] where none is required."""
_MAX_RATE_RATIO = 1e4
"""Largest rate over the smallest one, at which the angle is within 5e-5 of the minimum."""


def lower_bound_text(name: str, deflection: float, at: str = "") -> str:
    """Return the sentence that a lower bound of the limit is `deflection` [rad].

    `name`: of the bound, in `QUANTITIES`. `at`: its condition, such as " at this rate limit".
    """
    for_law = f" for a {FORECAST_FREE}" if name == NO_FORECAST else ""
    if np.isinf(deflection):
        return f"{name}{at}: no limit is sufficient{for_law}"
    never = "not sufficient" if for_law else "never sufficient"
    return f"{name}{at}: {np.degrees(deflection):.3f} deg; a limit below it is {never}{for_law}"


def point_table(caption: str, trade_off: TradeOff, *rows: tuple[str, str, str]) -> Table:
    """Return the table of lower bound, available and remaining quantity of a nozzle, in degrees.

    `caption`: above the table. `trade_off`: record of the quantities. `rows`: names of its fields
    for these three columns, of each row. A row is headed by the label of its available quantity.
    """
    labels = columns(trade_off, *(available for _, available, _ in rows))
    shown = tuple(
        ((item.heading,), *cells(trade_off, "nozzle", *names))
        for item, names in zip(labels, rows, strict=True)
    )
    return Table(caption, ("", "lower bound", "available", "remaining"), shown)


def required_rate_table(trade_off: RateTradeOff, deflection: str) -> Table:
    """Return the table of required, available and remaining rate of a trade-off at its limit.

    `deflection`: text that says what the limit is.
    """
    return record_table(
        f"{REQUIRED_RATE.capitalize()}, a lower bound of {trade_off.bounded_laws}",
        "required_rate",
        [trade_off],
        *("limit", "required_rate", "rate_limit", "remaining_rate"),
        labels=("at", [deflection]),
    )


def ramped_deflection(
    minimum: ArrayLike, pole: float, rate: ArrayLike, acceleration: ArrayLike = np.inf
) -> FloatArray:
    """Return the minimum deflection [rad] under limits of rate and acceleration, of one pole.

    `minimum`: d0 [rad], the minimum deflection without a rate limit, positive.
    `pole`: the unstable pole p [1/s]. `rate`, `acceleration`: their limits r [rad/s] and c
    [rad/s2], which broadcast with `minimum`; both may be infinite. Returned: d of d0 = d f(p d/v)
    f(p v/c), f(x) = (1 - e^-x)/x, v = min(r, sqrt(c d)); infinite where none is sufficient.
    """
    d0, r, c = np.broadcast_arrays(
        *(np.asarray(x, dtype=float) for x in (minimum, rate, acceleration))
    )
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        # full rate: d0 p/(r f(p r/c)) = 1 - e^(-p d/r), with r f(p r/c) = (c/p)(1 - e^(-p r/c))
        reduced_rate = np.where(np.isinf(c), r, -(c / pole) * np.expm1(-pole * r / c))
        full_rate = np.where(np.isinf(r), d0, -(r / pole) * _log1m(d0 * pole / reduced_rate))
        # full rate is never reached: d0 = d f(x)^2 with x = p sqrt(d/c)
        x = -_log1m(pole * np.sqrt(d0 / c))
        below_full_rate = np.where(np.isinf(c), d0, c * (x / pole) ** 2)
        return np.where(c * below_full_rate < r**2, below_full_rate, full_rate)


def ramp_rate(minimum: ArrayLike, pole: ArrayLike, deflection: ArrayLike) -> FloatArray:
    """Return the minimum rate [rad/s] of a ramp to a limit `deflection` d [rad], of one pole.

    `minimum`: d0 [rad], the minimum deflection without a rate limit. `pole`: the unstable pole p
    [1/s]. It is the inverse of `ramped_deflection`: d0 = d (1 - e^-x)/x with x = p d/r, which
    Lambert's W solves. Zero where no deflection is required, and infinite where no rate is
    sufficient. All broadcast.
    """
    from scipy.special import lambertw

    d0, p, d = np.broadcast_arrays(*(np.asarray(x, float) for x in (minimum, pole, deflection)))
    # with a = d/d0, x = a (1 - e^-x), whose solution is x = a + W(-a e^-a)
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.maximum(d / d0, 1.0)
        x = ratio + np.real(lambertw(-ratio * np.exp(-ratio)))
        return np.where(d0 <= 0.0, 0.0, np.where(ratio > 1.0, p * d / x, np.inf))


def _log1m(x: FloatArray) -> FloatArray:
    """Return ln(1 - x), minus infinity from x = 1 on."""
    return np.where(x < 1.0, np.log1p(-np.minimum(x, 1.0)), -np.inf)


class TradeOff(Shown):
    """A trade-off with the nozzle's point, whose limit is compared with its lower bound."""

    limit: float | None
    lower_bound: float
    no_forecast_bounds: FloatArray | None
    angle: float

    @property
    @derived("angle", infinite="-", card=False)
    def remaining(self) -> float | None:
        """Remaining angle [rad]: available minus required."""
        return None if self.limit is None else self.limit - self.lower_bound

    @property
    def beyond_linear(self) -> str:
        """Sentence of `beyond_linear` why the linear theory is not valid; empty where it is."""
        return beyond_linear(self.angle)


@dataclass(frozen=True, eq=False)
class RateTradeOff(TradeOff):
    """The minimum deflection over the deflection rate, for one plant in one wind.

    Attributes
    ----------
    rates : ndarray
        Rate limits [rad/s], ``(n,)``.
    limits : ndarray
        Minimum deflection [rad] at each with the wind known beforehand, ``(n,)``; infinite where no
        angle is sufficient.
    no_forecast_bounds : ndarray or None
        Lower bound [rad] of laws without a forecast, which survive if the wind stops for good at
        any instant, ``(n,)``, of the rate alone; None for a wind that changes its sign.
    minimum_deflection, minimum_rate : float
        Minimum angle [rad] without a rate limit, and the rate [rad/s] that must be exceeded however
        large the angle is.
    no_forecast_rate : float
        Lower bound [rad/s] of the rate without a forecast.
    acceleration_limit : float
        Largest deflection acceleration [rad/s2] that the limits have; infinite if none.
    limit, rate_limit : float or None
        Limits of the nozzle [rad, rad/s].
    lower_bound : float
        The larger of limit and bound [rad], at the nozzle's rate or else without a rate limit; of a
        law with a forecast the limit. Infinite where no angle is sufficient at that rate.
    required_rate : float
        The minimum rate [rad/s], by the larger of both, at the nozzle's angle or else without a
        limit of the angle.
    angle : float
        Largest wind angle [rad]. Above 30 deg the trade-off holds for the linear equations only,
        and the lower bound is NaN.
    forecast : bool
        Whether the law has a forecast of the wind; without one `required_rate` bounds such laws.
    """

    rates: FloatArray = field(metadata=spec("angular rate", "rate limit", card=False))
    limits: FloatArray = field(
        metadata=spec("angle", WIND_KNOWN, infinite=NONE_SUFFICIENT, card=False)
    )
    no_forecast_bounds: FloatArray | None = field(
        metadata=spec("angle", NO_FORECAST, infinite=NONE_SUFFICIENT, card=False)
    )
    minimum_deflection: float = field(metadata=spec("angle"))
    minimum_rate: float = field(metadata=spec("angular rate"))
    no_forecast_rate: float = field(metadata=spec("angular rate", card=False))
    acceleration_limit: float = field(metadata=spec("angular acceleration", card=False))
    limit: float | None = field(metadata=spec("angle"))
    rate_limit: float | None = field(metadata=spec("angular rate"))
    lower_bound: float = field(metadata=spec("angle", infinite=NONE_SUFFICIENT))
    required_rate: float = field(metadata=spec("angular rate", infinite="no rate is sufficient"))
    angle: float = 0.0
    forecast: bool = False

    @property
    def bounded_laws(self) -> str:
        """The laws whose rates `required_rate` is a lower bound of, in words."""
        bounds_all = self.forecast or self.no_forecast_bounds is None
        return "any law" if bounds_all else "any law without a forecast"

    @property
    @derived("angular rate", label="remaining", infinite="-", card=False)
    def remaining_rate(self) -> float | None:
        """Remaining rate [rad/s]: available minus required."""
        return None if self.rate_limit is None else self.rate_limit - self.required_rate

    @property
    @derived()
    def above_lower_bound(self) -> bool | None:
        """Whether the nozzle's point is on the trade-off or above; None if not given or not known.

        For a limit or a rate limit alone, whether some value of the other one satisfies this. A
        limit above the bound may be too small for a control.
        """
        if self.beyond_linear:
            return None
        if self.limit is None:
            return None if self.rate_limit is None else bool(np.isfinite(self.lower_bound))
        if self.rate_limit is None:
            return bool(np.isfinite(self.required_rate))
        return self.limit >= self.lower_bound

    @property
    def bound_text(self) -> str:
        """The lower bound of the limit at the nozzle's rate, in words.

        It is the larger of two: the minimum deflection with the wind known, and for a law without a
        forecast the bound of such laws. The text names the one that it is.
        """
        minimum, at = self.minimum_deflection, ""  # [rad], with the wind known
        if self.rate_limit is not None:
            here = self.limits[self.rates == self.rate_limit]
            minimum, at = float(here[0]) if here.size else np.nan, " at this rate limit"
        name = WIND_KNOWN if self.lower_bound <= minimum * (1.0 + _ROUNDING) else NO_FORECAST
        return lower_bound_text(name, self.lower_bound, at)

    @property
    def verdict(self) -> str:
        """Verdict in words: NOT SUFFICIENT below a lower bound, NOT KNOWN beyond the linear range.

        Empty without limits of a nozzle, and for limits above the bound, which may be too small for
        a control. The text names the bound without a forecast if they suffice with the wind known.
        """
        if self.beyond_linear:
            return f"{sufficiency(None)}: {self.beyond_linear}"
        if self.above_lower_bound is not False:  # above it, or None: no nozzle given
            return ""
        # sufficient with a forecast: a point of the trade-off has no larger rate or limit; None is
        # no limit
        rate = np.inf if self.rate_limit is None else self.rate_limit
        limit = np.inf if self.limit is None else self.limit
        within = np.isfinite(self.limits) & (self.limits <= limit) & (self.rates <= rate)
        at_any_rate = self.rate_limit is None and self.minimum_deflection < limit < np.inf
        whose = NO_FORECAST if at_any_rate or np.any(within) else WIND_KNOWN
        return f"{sufficiency(False)}, below the {whose}"

    def tables(self) -> tuple[Table, ...]:
        """Return the tables of the trade-off, and of the nozzle's point with the requirement."""
        return (
            array_table(
                "Lower bounds of the limit over the rate limit",
                "trade_off",
                self,
                *("rates", "limits", "no_forecast_bounds"),
            ),
            point_table(
                "Both at once: the limit at that rate, the rate limit at that angle",
                self,
                ("lower_bound", "limit", "remaining"),
                ("required_rate", "rate_limit", "remaining_rate"),
            ),
        )

    @property
    def notes(self) -> Iterator[str]:
        """Yield the notes on the trade-off, a sentence each.

        `no_forecast_bounds` is None where the wind changes its sign, which that bound excludes.
        """
        yield from linear_notes(self.angle)  # of the largest wind angle [rad]
        if self.minimum_deflection == 0.0:
            yield "the wind excites no unstable pole: neither angle nor rate is required"
        elif self.no_forecast_bounds is None:
            yield f"the wind changes its sign: there is no {NO_FORECAST}"
        else:
            yield "these are lower bounds: a control may require more angle and more rate"


def rate_trade_off(
    plant: Plant,
    wind: History,
    rates: ArrayLike | None = None,
    *,
    limit: float | None = None,
    rate_limit: float | None = None,
    acceleration_limit: float = np.inf,
    forecast: bool = False,
) -> RateTradeOff:
    """Return the minimum deflection over the rate limit, from the onset of the wind on.

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
    forecast : bool
        Whether the law has a forecast of the wind, as with a dead band below 1: then the bound
        without one counts neither in the lower bound of the limit nor in the required rate.

    Raises
    ------
    InputError
        Where `optimum_deflection` raises it; for a fastest pole that is not real, limits that are
        not positive, an acceleration with which no angle is sufficient, and an acceleration limit
        where two poles decide.

    Notes
    -----
    Where other unstable poles contribute, such as the flight path's after long winds,
    the limits are the same as in `optimum_with_rate_limit`. Without a forecast the bound belongs
    to a state that must be recoverable after a stop and after the remaining wind: a ramp must
    have the effect of the constant deflection y*, the bound of `forecast_free_limit`.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> wind = tv.TriangularWind(peak=-0.1, duration=7.5)
    >>> front = tv.boundary.rate_trade_off(plant, wind, [0.005, 0.05])
    >>> (front.limits / front.minimum_deflection).round(2).tolist()
    [1.28, 1.02]
    """
    angle, check = errors.small_angle("a deflection", errors.positive), errors.between(*RATE_RANGE)
    c = errors.unlimited("acceleration_limit", acceleration_limit, check, "rad/s2")
    nozzle_limit = None if limit is None else errors.number("limit", limit, angle, "rad")
    nozzle_rate = (
        None if rate_limit is None else errors.number("rate_limit", rate_limit, check, "rad/s")
    )
    if rates is not None:
        at = check("rates", errors.one_row("rates", rates, "rad/s"), "rad/s")
    case = _case_of(plant, wind, c, errors.flag("forecast", forecast))
    minimum_rate, no_forecast = case.minimum_rate, case.no_forecast
    if rates is None:  # multiples of the smallest rate, or of one that is of the motion's order
        at = np.asarray(_MULTIPLES) * (minimum_rate or case.pole * case.minimum or _DEFAULT_RATE)
        at = at if nozzle_rate is None else np.unique(np.append(at, nozzle_rate))
    limits = np.array([case.deflection(float(rate)) for rate in at])
    bounds = None
    if no_forecast is not None:
        bounds = np.maximum(ramped_deflection(no_forecast, case.pole, at), limits)
    front = RateTradeOff(
        rates=at,
        limits=limits,
        no_forecast_bounds=bounds,
        minimum_deflection=case.minimum,
        minimum_rate=minimum_rate,
        no_forecast_rate=np.nan if no_forecast is None else case.pole * no_forecast,
        acceleration_limit=c,
        limit=nozzle_limit,
        rate_limit=nozzle_rate,
        lower_bound=case.lower_bound(nozzle_rate),
        required_rate=case.required_rate(nozzle_limit),
        angle=abs(float(wind.peak)),
        forecast=forecast,
    )
    if front.beyond_linear:
        return replace(front, lower_bound=np.nan, required_rate=np.nan)
    return front


@dataclass(frozen=True, eq=False)
class _Case:
    """A plant in a wind, from its onset on: its conditions and minimum deflections.

    `constraints`: of every unstable mode on the deflection, the integral of e^(-p t) delta dt from
    the onset on being its demand [rad s] for each of `constraints.poles` p. `unlimited`: deflection
    of minimum peak without a rate limit. `acceleration`: its limit [rad/s2]; infinite if none.
    `no_forecast`: lower bound [rad] without a forecast and without a rate limit; None for a wind
    that changes its sign. `forecast`: whether the law has a forecast, to which that bound does not
    apply.
    """

    wind: History
    constraints: Constraints
    unlimited: Optimum
    acceleration: float
    no_forecast: float | None
    forecast: bool

    @property
    def law_bound(self) -> float:
        """Lower bound [rad] of a law without a forecast or a rate limit; zero with a forecast."""
        return 0.0 if self.forecast else self.no_forecast or 0.0

    @property
    def minimum(self) -> float:
        """Minimum deflection [rad] without a rate limit."""
        return self.unlimited.peak

    @property
    def pole(self) -> float:
        """Fastest unstable pole [1/s]; 1 without one."""
        return float(np.real(self.constraints.poles[0])) if self.constraints.poles.size else 1.0

    @property
    def fast_deflection(self) -> float:
        """Minimum deflection [rad] for the condition of the fastest pole p, without a rate limit.

        The condition is that the integral of e^(-p t) delta dt over all time equals a demand
        [rad s] of the wind; a constant deflection satisfies it with p times the demand. Zero
        without an unstable pole.
        """
        demands = self.constraints.demands  # by pole, the fastest first
        return self.pole * abs(float(demands[0])) if demands.size else 0.0

    @property
    def minimum_rate(self) -> float:
        """Rate [rad/s] that must be exceeded; `InputError` for too low an acceleration.

        An endless ramp at the rate r has the mean r/p with the weight p e^(-p t), p being the
        fastest pole, so that r > p d0, d0 being its minimum deflection without a rate limit
        (`fast_deflection`); an acceleration limit c delays it: r > -(c/p) ln(1 - p^2 d0/c).
        """
        p, c = self.pole, self.acceleration
        if self.minimum > 0.0 and c <= p**2 * self.fast_deflection:
            raise errors.InputError(
                f"acceleration_limit must be above {p**2 * self.fast_deflection:.6g} rad/s2, or no"
                f" deflection survives this wind; got {c:.6g} rad/s2"
            )
        if np.isinf(c):
            return p * self.fast_deflection
        return -c / p * float(np.log1p(-(p**2) * self.fast_deflection / c))

    def deflection(self, rate: float) -> float:
        """Return the minimum deflection [rad] at a rate limit [rad/s], the wind known, or inf."""
        d = self.single_pole_deflection(rate)  # [rad], from the fastest pole alone
        # nothing is required, no deflection is sufficient, or the other pole requires no more
        if self.minimum == 0.0 or np.isinf(d) or self._decided_by_one_pole(d, rate):
            return d
        if np.isfinite(self.acceleration):
            raise errors.InputError(
                "acceleration_limit requires a case that one unstable pole decides; leave it out"
            )
        onset = float(self.wind.onset)  # `unlimited`: the deflection without a rate limit
        return minimum_peak_at_rate(self.constraints, self.unlimited, onset, rate)

    def single_pole_deflection(self, rate: float) -> float:
        """Return the minimum deflection [rad] of the fastest pole alone, at a `rate` [rad/s]."""
        return float(ramped_deflection(self.fast_deflection, self.pole, rate, self.acceleration))

    def no_forecast_limit(self, rate: float) -> float:
        """Return the lower bound [rad] without a forecast, at a rate limit `rate` [rad/s].

        It is the end of a ramp at this rate that moves the fastest mode as much as the bound
        without a rate limit, `law_bound`, does at once. Zero for a wind that changes its sign,
        which has no such bound, and for a law with a forecast.
        """
        return float(ramped_deflection(self.law_bound, self.pole, rate))

    def lower_bound(self, rate: float | None) -> float:
        """Return the larger of both lower bounds [rad] at a rate limit `rate` [rad/s].

        They are the minimum deflection with the wind known, and the bound without a forecast. For
        None the rate is not limited, with the bounds `minimum` and `law_bound`.
        """
        if rate is None:
            return max(self.minimum, self.law_bound)
        return max(self.deflection(rate), self.no_forecast_limit(rate))

    def required_rate(self, limit: float | None) -> float:
        """Return the minimum rate [rad/s] at a deflection limit [rad], or at any for None.

        Infinite if none is sufficient. The rate of the fastest pole alone, in closed form, is tried
        first: other poles can only raise it. `deflection(r)` is the minimum deflection [rad] at the
        rate r, `minimum` without a rate limit.
        """
        # a ramp slower than pole times the constant deflection required is too late at any angle
        lowest = max(self.minimum_rate, self.pole * self.law_bound)
        if limit is None or self.minimum == 0.0:
            return lowest if limit is None else 0.0
        lowest = lowest or self.pole * self.minimum  # where the fastest pole requires none
        single_pole_rate = _minimum_rate(  # of the fastest pole alone
            lambda r: max(self.single_pole_deflection(r), self.no_forecast_limit(r)), limit, lowest
        )
        largest = limit * (1.0 + _RELATIVE_TOLERANCE)
        if np.isinf(single_pole_rate) or self.deflection(single_pole_rate) <= largest:
            return single_pole_rate
        return _minimum_rate(self.deflection, limit, single_pole_rate)

    def _decided_by_one_pole(self, d: float, rate: float) -> bool:
        """Return whether the other unstable pole q does not raise a deflection `d` [rad].

        `d`: what the fastest pole p requires at the rate limit `rate` [rad/s]. It is sufficient for
        q if a second motion, from d to -d from a time t on, satisfies the condition of q, and t is
        so late that the weight e^(-p t) of this motion in the condition of p is negligible.
        """
        poles, demands, c = self.constraints.poles, self.constraints.demands, self.acceleration
        if poles.size == 1:
            return True
        if poles.size > 2 or not self.constraints.real or d == 0.0:
            return False
        p, q = poles
        v = min(rate, float(np.sqrt(c * d)))  # reached in a motion by d that also comes to rest
        # condition of q, solved for e^(-q t): q times its demand = (v/q) f(q v/c) (1 - e^(-q d/v)
        # - e^(-q t) (1 - e^(-2 q d/v))), with f(x) = (1 - e^-x)/x and the acceleration limit c
        factor = v / q if np.isinf(c) else -(c / q**2) * np.expm1(-q * v / c)  # (v/q) f(q v/c)
        demand = q * demands[1] * np.sign(demands[0])  # [rad], positive if towards d
        decay = (-np.expm1(-q * d / v) - demand / factor) / -np.expm1(-2.0 * q * d / v)  # e^(-q t)
        after_first_motion = 0.0 <= decay <= np.exp(-q * (d / v + v / c))
        return bool(after_first_motion and decay ** (p / q) < _NEGLIGIBLE)  # e^(-p t)


def _minimum_rate(deflection: Callable[[float], float], limit: float, lowest: float) -> float:
    """Return the minimum rate [rad/s], above `lowest`, with a deflection within a `limit` [rad].

    `deflection`: function of the rate [rad/s] to the minimum deflection [rad], which falls.
    Infinite without such a rate.
    """
    from scipy.optimize import brentq

    if deflection(_MAX_RATE_RATIO * lowest) > limit:
        return np.inf

    def excess(exponent: float) -> float:
        """Return 1/minimum - 1/limit [1/rad] at the rate `lowest` e^`exponent`; it rises.

        Near the lowest rate, where no deflection is sufficient, 1/minimum is zero.
        """
        minimum = deflection(float(np.exp(exponent)) * lowest)
        return 1.0 / minimum - 1.0 / limit

    # exponents: just above the lowest rate, and at the largest
    first, last = _NEGLIGIBLE, np.log(_MAX_RATE_RATIO)
    if excess(first) >= 0.0:
        return lowest
    return lowest * float(np.exp(brentq(excess, first, last, xtol=_RELATIVE_TOLERANCE)))


def _case_of(plant: Plant, wind: History, acceleration: float, forecast: bool) -> _Case:
    """Return the case of a plant in a wind, and of a law with or without a `forecast` of it.

    `acceleration`: limit of the deflection's acceleration [rad/s^2], infinite without one.
    """
    # the control starts with the wind; `constraints_of` refuses what is not one wind
    start = float(wind.onset) if isinstance(wind, History) and not wind.batch else 0.0
    constraints = constraints_of(plant, wind, start if np.isfinite(start) else 0.0)
    poles = constraints.poles
    if poles.size and np.imag(poles[0]):
        raise errors.InputError(
            "plant must have a real unstable pole as its fastest; it has"
            f" {poles_text(unstable_poles(plant))}"
        )
    return _Case(
        wind=wind,
        constraints=constraints,
        unlimited=optimum_under(constraints, start),
        acceleration=acceleration,
        no_forecast=no_forecast_deflection(plant, wind),
        forecast=forecast,
    )


def no_forecast_deflection(plant: Plant, wind: History) -> float | None:
    """Return the lower bound [rad] without a forecast, as `forecast_free_limit`, of one plant.

    It holds for every law that must survive a stop of the wind at any instant. Zero without a real
    fastest unstable pole; None for a wind that changes its sign.
    """
    poles = unstable_poles(plant)
    if not wind.constant_sign:
        return None
    bounded = poles.size > 0 and not np.imag(poles[0])
    return abs(float(forecast_free_limit(plant, wind).deflection)) if bounded else 0.0
