"""The least deflection over the rate at which the nozzle turns, as a record."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.documents import keyed
from tvclin.base.lines import Table, degrees, minimum_limit
from tvclin.base.quantities import NO_FORECAST, WIND_KNOWN, sufficiency
from tvclin.boundary.fronts.nozzle_point import lower_bound, point_table, remaining
from tvclin.winds.wind_angles import beyond_linear, linear_notes

_ROUNDING = 1e-9
"""Relative tolerance of two equal lower bounds."""


@dataclass(frozen=True, eq=False)
class RateFront(Shown):
    """The least deflection over the deflection rate, for one plant in one wind.

    Attributes
    ----------
    rates : ndarray
        Rate limits [rad/s], ``(n,)``.
    limits : ndarray
        Least deflection [rad] at each with the wind known beforehand, ``(n,)``; infinite where no
        angle is sufficient.
    bounds : ndarray or None
        Lower bound [rad] of every law that does not know when the wind will stop, ``(n,)``, of the
        rate alone; None for a wind that changes its sign.
    least_deflection, least_rate : float
        Least angle [rad] at any rate, and the rate [rad/s] that must be exceeded at any angle.
    least_rate_blind : float
        Lower bound [rad/s] of the rate without a forecast.
    acceleration_limit : float
        Largest deflection acceleration [rad/s2] that the limits have; infinite if none.
    limit, rate_limit : float or None
        Limits of the nozzle [rad, rad/s].
    needed : float
        The larger of limit and bound [rad], at the nozzle's rate or else at any.
    needed_rate : float
        The least rate [rad/s], by the larger of both, at the nozzle's angle or else at any.
    angle : float
        Largest wind angle [rad]. Above 30 deg the front is that of the linear equations alone, and
        the lower bound is NaN.
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
    angle: float = 0.0

    as_dict = keyed(
        "rates_deg_per_s limits_deg bounds_deg least_deflection_deg least_rate_deg_per_s"
        " least_rate_blind_deg_per_s acceleration_limit_deg_per_s2 limit_deg"
        " rate_limit_deg_per_s needed_deg needed_rate_deg_per_s left_deg left_rate_deg_per_s"
        " above_lower_bound"
    )
    _keys = (
        "least_deflection_deg least_rate_deg_per_s limit_deg needed_deg rate_limit_deg_per_s"
        " needed_rate_deg_per_s above_lower_bound"
    )

    @property
    def left(self) -> float | None:
        """Remaining angle [rad]: available minus required."""
        return remaining(self.limit, self.needed)

    @property
    def left_rate(self) -> float | None:
        """Remaining rate [rad/s]: available minus required."""
        return remaining(self.rate_limit, self.needed_rate)

    @property
    def above_lower_bound(self) -> bool | None:
        """Whether the nozzle's point is on the front or above; None if not given or not known.

        For a limit or a rate limit alone, whether some value of the other one satisfies this. A
        limit below the bound is never sufficient; one above it may be too small for a control.
        """
        if self.beyond:
            return None
        if self.limit is None:
            return None if self.rate_limit is None else bool(np.isfinite(self.needed))
        if self.rate_limit is None:
            return bool(np.isfinite(self.needed_rate))
        return self.limit >= self.needed

    @property
    def beyond(self) -> str:
        """Sentence of `beyond_linear` why the linear theory is not valid; empty where it is."""
        return beyond_linear(self.angle)

    @property
    def _sufficient_with_forecast(self) -> bool:
        """Whether the nozzle's point is on the front with the wind known, or above."""
        fastest, limit = np.inf if self.rate_limit is None else self.rate_limit, self.limit
        can = np.isfinite(self.limits) & (self.limits <= (np.inf if limit is None else limit))
        free = self.rate_limit is None and limit is not None and self.least_deflection < limit
        return free or bool(np.any(can & (self.rates <= fastest)))

    @property
    def bound_words(self) -> str:
        """The lower bound of the limit at the nozzle's rate, in words."""
        wind_known, at = self.least_deflection, ""
        if self.rate_limit is not None:
            here = self.limits[self.rates == self.rate_limit]
            wind_known, at = float(here[0]) if here.size else np.nan, " at this rate limit"
        name = WIND_KNOWN if self.needed <= wind_known * (1.0 + _ROUNDING) else NO_FORECAST
        return lower_bound(f"{name}{at}", self.needed)

    @property
    def verdict(self) -> str:
        """Whether the nozzle's point is below the lower bound, in words; empty where it is not."""
        if self.beyond:
            return f"{sufficiency(None)}: {self.beyond}"
        if self.above_lower_bound is not False:
            return ""
        whose = NO_FORECAST if self._sufficient_with_forecast else WIND_KNOWN
        return f"{sufficiency(False)}, below the {whose}"

    def tables(self) -> tuple[Table, ...]:
        """Return the tables of the front, and of the nozzle's point with the requirement."""
        blank = np.full(self.rates.size, np.nan)
        columns = {
            "rate": self.rates,
            "limit": self.limits,
            "bound": blank if self.bounds is None else self.bounds,
        }
        rows = tuple(
            tuple(minimum_limit(degrees(f"front.{k}.{name}", x[k])) for name, x in columns.items())
            for k in range(self.rates.size)
        )
        head = ("rate limit [deg/s]", f"{WIND_KNOWN} [deg]", f"{NO_FORECAST} [deg]")
        point = point_table(
            "Both at once: the limit at that rate, the rate limit at that angle",
            ("limit [deg]", "limit", self.needed, self.limit),
            ("rate limit [deg/s]", "rate", self.needed_rate, self.rate_limit),
        )
        return Table("Lower bounds of the limit over the rate limit", head, rows), point

    @property
    def notes(self) -> Iterator[str]:
        """Return the notes on the front, a sentence each."""
        yield from linear_notes(self.angle)
        if self.least_deflection == 0.0:
            yield "no unstable pole feels the wind: neither angle nor rate is needed"
        elif self.bounds is None:
            yield "the wind changes its sign: there is no bound for laws without a forecast"
        else:
            yield "these are lower bounds: a control may require more angle and more rate"
