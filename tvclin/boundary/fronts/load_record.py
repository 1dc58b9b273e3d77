"""The least deflection over the largest load of the structure, as a record."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.documents import keyed
from tvclin.base.lines import Table, degrees, minimum_limit
from tvclin.base.lines import number as figure
from tvclin.base.quantities import NO_FORECAST, WIND_KNOWN, sufficiency
from tvclin.boundary.fronts.nozzle_point import lower_bound, point_table, remaining
from tvclin.winds.wind_angles import beyond_linear, linear_notes

PROVED = 1e-4
"""A limit so near to its bound, relative, is found."""


@dataclass(frozen=True, eq=False)
class LoadFront(Shown):
    """The least deflection over a load bound, for one plant in one wind.

    Attributes
    ----------
    loads : ndarray
        Bounds of the load [rad], ``(n,)``.
    limits : ndarray
        Deflection limit [rad] with which a control that knows the wind stays within each load,
        ``(n,)``; infinite where no angle is sufficient.
    proofs : ndarray
        Lower bound [rad] of that limit, ``(n,)``: the minimum is between the two.
    slopes : ndarray
        Decrease of the deflection with the load bound, ``(n,)``: its reciprocal is the decrease of
        the load for a degree of the nozzle.
    holds : tuple of str
        Condition that sets each limit: the least angle, turning in time into the wind, or both
        together.
    bounds : ndarray or None
        Lower bound [rad] of every law that does not know when the wind will stop, ``(n,)``; None
        for a wind that changes its sign.
    least_deflection, its_load : float
        Least deflection [rad] at any load, and the load [rad] of its control.
    least_load, least_load_blind : float
        Least load [rad] of a computed control at any deflection, and a lower bound [rad] of the
        load without a forecast.
    moment_ratio, rate_limit : float
        M, and the rate limit [rad/s]; infinite if none.
    limit, load : float or None
        Limit of the nozzle and load limit of the structure [rad].
    needed : float
        Required limit [rad] at that load, or at any.
    needed_load : float
        Least load [rad] of a control with that limit, or with any; infinite without one.
    angle : float
        Largest wind angle [rad]. Above 30 deg the front is that of the linear equations alone, and
        the lower bound is NaN.
    """

    loads: FloatArray
    limits: FloatArray
    proofs: FloatArray
    slopes: FloatArray
    holds: tuple[str, ...]
    bounds: FloatArray | None
    least_deflection: float
    its_load: float
    least_load: float
    least_load_blind: float
    moment_ratio: float
    rate_limit: float
    limit: float | None
    load: float | None
    needed: float
    needed_load: float
    angle: float = 0.0

    as_dict = keyed(
        "loads_deg limits_deg proofs_deg slopes holds bounds_deg least_deflection_deg its_load_deg"
        " least_load_deg least_load_blind_deg moment_ratio rate_limit_deg_per_s limit_deg load_deg"
        " needed_deg needed_load_deg left_deg left_load_deg above_lower_bound"
    )
    _keys = (
        "least_deflection_deg least_load_deg limit_deg needed_deg load_deg needed_load_deg"
        " above_lower_bound"
    )

    @property
    def left(self) -> float | None:
        """Remaining angle [rad]: available minus required."""
        return remaining(self.limit, self.needed)

    @property
    def left_load(self) -> float | None:
        """Remaining load [rad]: the structure's limit minus the required load."""
        return remaining(self.load, self.needed_load)

    @property
    def above_lower_bound(self) -> bool | None:
        """Whether the limit is on the front with the wind known, or above.

        None without a limit, and where the front is not proved to be above the limit. A limit below
        the bound is never sufficient; one above it may be too small for a control.
        """
        if self.limit is None or self.beyond:
            return None
        return True if self.limit >= self.needed else None if self._proved <= self.limit else False

    @property
    def _proved(self) -> float:
        """Proved lower bound [rad] of the limit at the load."""
        at = np.flatnonzero(self.loads == self.load)
        return float(self.proofs[at[0]]) if at.size else self.needed

    @property
    def takes_a_forecast(self) -> bool:
        """Whether every law that does not know when the wind stops exceeds the load."""
        return self.load is not None and self.load < self.least_load_blind

    @property
    def beyond(self) -> str:
        """Sentence of `beyond_linear` why the linear theory is not valid; empty where it is."""
        return beyond_linear(self.angle)

    @property
    def bound_words(self) -> str:
        """The lower bound of the limit within the load, in words."""
        load = "" if self.load is None else " within this load"
        return lower_bound(f"{WIND_KNOWN}{load}", self._proved)

    @property
    def verdict(self) -> str:
        """Whether the limit is below the lower bound, in words; empty where it is not."""
        if self.beyond:
            return f"{sufficiency(None)}: {self.beyond}"
        if self.limit is None or self.above_lower_bound:
            return ""
        if self.above_lower_bound is None:
            low, high = np.degrees([self._proved, self.needed])
            between = f"between {low:.4g} and {high:.4g}" if high < 90.0 else f"above {low:.4g}"
            return f"{sufficiency(None)}: the lower bound is {between} deg"
        return f"{sufficiency(False)}, below the {WIND_KNOWN}"

    def tables(self) -> tuple[Table, ...]:
        """Return the tables of the front, and of the nozzle's point with the requirement."""
        blank = np.full(self.loads.size, np.nan)
        bounds = blank if self.bounds is None else self.bounds
        buys = 1.0 / np.where(self.slopes > 0.0, self.slopes, np.nan)
        rows = tuple(
            (
                degrees(f"front.{k}.load", self.loads[k]),
                minimum_limit(degrees(f"front.{k}.limit", self.limits[k])),
                figure(f"front.{k}.buys_deg", buys[k], 2),
                minimum_limit(degrees(f"front.{k}.bound", bounds[k])),
                (self.holds[k],),
            )
            for k in range(self.loads.size)
        )
        head = (
            *("load [deg]", f"{WIND_KNOWN} [deg]", "a degree buys [deg]"),
            *(f"{NO_FORECAST} [deg]", "set by"),
        )
        point = point_table(
            "Both at once: the limit at that load, the load at that limit",
            ("limit [deg]", "limit", self.needed, self.limit),
            ("load [deg]", "load", self.needed_load, self.load),
        )
        return Table("Lower bounds of the limit over the largest load", head, rows), point

    @property
    def notes(self) -> Iterator[str]:
        """Return the notes on the front, a sentence each."""
        yield from linear_notes(self.angle)
        what = "the angle of attack" if self.moment_ratio == 0.0 else "alpha + M delta, as an angle"
        yield f"the load is {what}, during the wind and after it"
        if self.bounds is None:
            yield "the wind changes its sign: there is no bound for laws without a forecast"
        elif np.isfinite(self.least_load_blind) and self.least_load_blind > 0.0:
            half = np.degrees(self.least_load_blind)
            more = ", more than this load" * self.takes_a_forecast
            yield f"a law without a forecast bears {half:.4g} deg at least{more}"
        if np.any(self.limits > self.proofs * (1.0 + 2.0 * PROVED)):
            gaps = 1.0 - self.proofs / np.maximum(self.limits, 1e-300)
            worst, at = np.max(gaps), np.degrees(self.loads[np.argmax(gaps)])
            percent = f"{100.0 * worst:.2g} percent"
            yield f"the limits are proved to {percent}, that at {at:.4g} deg least"
