"""Minimum peak deflection in a known wind, with trim and the boundary at K = 0."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from tvclin.base.cards import Shown
from tvclin.base.documents import picked
from tvclin.base.lines import Row, Table, degrees, minimum_limit, number, quantities, significant
from tvclin.base.quantities import STATIC_TRIM, WIND_KNOWN
from tvclin.boundary.limit import boundary_limit
from tvclin.boundary.optimum.minimum_peak import Optimum, optimum_deflection
from tvclin.boundary.optimum.rate_limit import RateLimitedOptimum, optimum_with_rate_limit
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History

_MAX_SHOWN_SWITCHES = 6
"""Number of switch times that are shown."""


@dataclass(frozen=True, eq=False)
class KnownWind(Shown):
    """Minimum peak deflection in a known wind, with the numbers it is compared with.

    `best` is the deflection of minimum peak, `limited` that with a rate limit; None without one.
    """

    plant: Plant
    wind: History
    best: Optimum
    limited: RateLimitedOptimum | None = None

    @classmethod
    def of(
        cls,
        plant: Plant,
        wind: History,
        start: float,
        horizon: float | None = None,
        rate_limit: float | None = None,
    ) -> Self:
        """Return the optimum of a plant in a wind; arguments and errors of its two functions."""
        best = optimum_deflection(plant, wind, start, horizon)
        if rate_limit is None:
            return cls(plant, wind, best)
        limited = optimum_with_rate_limit(plant, wind, rate_limit, start, horizon)
        return cls(plant, wind, best, limited)

    @property
    def deflection(self) -> History:
        """Deflection [rad] of minimum peak, with the rate limit where there is one."""
        return (self.limited or self.best).deflection

    @property
    def trim(self) -> float:
        """Static trim [rad]: the largest deflection of ideal trim."""
        return abs(float(self.plant.coefficients.B * self.wind.peak))

    @property
    def part_of_trim(self) -> float | None:
        """Minimum peak over static trim; None without trim."""
        return self.best.peak / self.trim if self.trim else None

    @property
    def held(self) -> float:
        """Boundary limit [rad] at K = 0, for one pole: constant from the onset of the wind on."""
        return abs(float(boundary_limit(self.plant, self.wind, 0.0).deflection))

    @property
    def first_segment(self) -> str:
        """Direction of the first segment of the deflection, in words."""
        deflection = self.best.deflection
        if np.isinf(deflection.onset):
            return "none"
        first = np.sign(deflection(np.nextafter(deflection.onset, np.inf)))
        against = -np.sign(self.plant.coefficients.B * self.wind.peak)
        return "opposes the wind" if first == against else "goes with the wind"

    def as_dict(self) -> dict[str, Any]:
        """Return the record as the command line prints it as JSON, angles in degrees."""
        return {
            **picked(self.best, "peak_deg"),
            **picked(self, "part_of_trim trim_deg held_deg first_segment"),
            **picked(self.best, "switch_times_s status certificate"),
            **({} if self.limited is None else {"with_rate_limit": self.limited}),
        }

    def table(self, caption: str) -> Table:
        """Return the peak, its certificate, and the numbers it is compared with."""
        best, proof = self.best, self.best.certificate
        peak = degrees("optimum.peak", best.peak, unit="deg")
        if self.part_of_trim is not None:
            part = number("optimum.part_of_trim", self.part_of_trim)
            peak = (*peak, " (", *part, " of trim)")
        rows: list[Row] = [(WIND_KNOWN, peak)]
        if self.limited is not None:
            rate = f"with {np.degrees(self.limited.rate):.4g} deg/s"
            limited = degrees("optimum.limited", self.limited.peak, unit="deg")
            rows.append((rate, (*limited, f", {self.limited.status}")))
        switches = (
            ", ".join(f"{t:.4g} s" for t in best.switch_times[:_MAX_SHOWN_SWITCHES]) or "none"
        )
        more = best.switch_times.size - _MAX_SHOWN_SWITCHES
        gap = significant("optimum.gap", proof.gap, 2)
        rows += [
            ("first segment", (self.first_segment,)),
            ("switches", (switches + (f" and {more} more" if more > 0 else ""),)),
            (
                "fast pole alone (K = 0)",
                minimum_limit(degrees("optimum.held", self.held, unit="deg")),
            ),
            (STATIC_TRIM, degrees("optimum.trim", self.trim, unit="deg")),
            ("dual bound", degrees("optimum.dual", proof.dual, unit="deg")),
            ("certificate", ("gap ", *gap, f", {best.status}")),
        ]
        return quantities(caption, rows)
