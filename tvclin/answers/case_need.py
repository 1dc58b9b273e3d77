"""What is required of the nozzle of a case: the number that the verdict of a study rests on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.answers.case import FROZEN, Case
from tvclin.answers.planes import PlanesNeeded, of_heading
from tvclin.answers.requirement import RequiredDeflection, covers, required_deflection
from tvclin.answers.sizing.wind_sign import sign_factors, survived_size
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, between, nonnegative, number, single, within
from tvclin.boundary.stops import stop_of
from tvclin.linear.plant import Plant
from tvclin.vehicle.linear_vehicle import AnyVehicle, coefficients_of, whole_vehicle
from tvclin.winds.histories import History
from tvclin.winds.linear_range import MAX_LINEAR_ANGLE, beyond_linear
from tvclin.winds.shaped import ShapedWind

_LEAST_SIZE, _LARGEST_SIZE = 0.01, 1e9
_SIZES = 5
"""Sizes of a wind at which what its sign changes is computed for dispersed winds."""


@dataclass(frozen=True, eq=False)
class CaseNeed:
    """What a wind requires of the nozzle of a case, at one dead band.

    The verdict rests on the model of the case. `blows` is the wind in the plane, with its gust.
    `requirement` is what a limit must be in the dynamic pressure of calm air, `sign_factors` what
    is required of a head and of a tail wind over that, empty where the wind blows across the path,
    or, as `sign_unknown` says, that is not known. `planes` is what a wind with a direction asks of
    both. All these are NaN, or empty, in a wind `beyond` linear aerodynamics.
    """

    case: Case
    dead_band: float
    blows: ShapedWind
    requirement: RequiredDeflection
    planes: PlanesNeeded | None
    sign_factors: dict[str, float]
    sign_unknown: str

    @property
    def vehicle(self) -> AnyVehicle:
        """The vehicle."""
        return self.case.vehicle

    @property
    def plane(self) -> str:
        """The plane of the boundaries, and of the verdict where that is not on both."""
        return self.case.plane

    @property
    def model(self) -> str:
        """The model on which the verdict rests."""
        return self.case.model

    @property
    def sign(self) -> str | None:
        """The sign of the wind along the path that counts, as of the case."""
        return self.case.sign

    @property
    def limit(self) -> float | None:
        """The capability [rad] in question."""
        return self.case.nozzle.limit

    @property
    def slanting(self) -> ShapedWind | None:
        """The wind with its direction, where that is known, its gust at its time."""
        wind = self.case.wind
        if not isinstance(wind, ShapedWind) or wind.heading is None:
            return None
        return replace(wind, gust_at=self.blows.gust_at)

    @property
    def in_both(self) -> bool:
        """Whether the verdict is on both planes."""
        return self.case.nozzle.stop is not None

    @property
    def history(self) -> History:
        """The wind in the plane with its gust."""
        return self.blows.history({})

    @property
    def required_deflection(self) -> float:
        """The deflection [rad] that is required at the verdict's model and dead band, a size."""
        return self.frozen_deflection * self.counts[1]

    @property
    def frozen_deflection(self) -> float:
        """The same [rad] in the dynamic pressure of calm air."""
        if self.planes is not None and self.in_both:
            return self.planes.deflection
        return abs(float(self.requirement.deflection))

    @property
    def sign_needs(self) -> dict[str, float]:
        """What is required [rad] of a head and of a tail wind, by `sign_factors`."""
        return {name: self.frozen_deflection * one for name, one in self.sign_factors.items()}

    @property
    def counts(self) -> tuple[str, float]:
        """Which sign of the wind counts, and its factor on `frozen_deflection`."""
        if self.sign in self.sign_factors:
            return str(self.sign), self.sign_factors[str(self.sign)]
        every = {FROZEN: 1.0} | self.sign_factors
        name = max(every, key=lambda one: every[one])
        return name, every[name]

    @property
    def in_calm_air(self) -> bool:
        """Whether the dynamic pressure of calm air counts."""
        return self.counts[0] == FROZEN

    def factors_at(self, sizes: ArrayLike) -> FloatArray:
        """Return the factor of the sign that counts in winds of so many times this size.

        Between a few sizes it is interpolated; infinite for a wind that turns the path too far.
        `InputError` for sizes that are negative, or no numbers.
        """
        wanted = within("sizes", nonnegative("sizes", sizes), 0.0, _LARGEST_SIZE)
        name, factor = self.counts
        if name == FROZEN or np.all(wanted == 1.0):
            return np.full(wanted.shape, factor)
        wanted = np.maximum(wanted, _LEAST_SIZE)
        nodes = np.linspace(wanted.min(), wanted.max(), _SIZES)
        found = [self._factor_at(float(size)) for size in nodes]
        factors = np.interp(wanted, nodes, found)
        return np.where(np.isnan(factors), np.inf, factors)

    def _factor_at(self, size: float) -> float:
        """The same of one size."""
        name, factor = self.counts
        if name == FROZEN or size == 1.0:
            return factor
        asked = None if self.slanting is not None else name
        try:
            calm = self.requirement.needs
            return sign_factors(self.case, self.history, self.dead_band, asked, size, calm)[name]
        except InputError:
            return np.inf

    @property
    def judged_peak(self) -> float:
        """The peak [rad] of the wind that is judged: in both planes that of its vector."""
        blows = self.planes if self.planes is not None and self.in_both else self.history
        return float(blows.peak)

    @property
    def wind_angle(self) -> float:
        """Largest angle [rad] at which the wind meets the flight: of a direction, its vector."""
        return abs(float((self.planes or self.history).peak))

    @property
    def beyond(self) -> str:
        """Sentence why nothing is known in this wind, as of `beyond_linear`; empty where it is."""
        return beyond_linear(self.wind_angle)

    @property
    def peak_bound(self) -> float:
        """Largest survivable peak [rad] that is known, with its sign, as of `judged_peak`.

        There the wind angle is `MAX_LINEAR_ANGLE`; a limit that survives it may survive more.
        """
        return self.judged_peak * (MAX_LINEAR_ANGLE / self.wind_angle)

    @property
    def judged(self) -> dict[str, Any]:
        """Whether the limit is enough, and what peak it survives; None without one."""
        limit, needed = self.limit, self.required_deflection
        if limit is None:
            return {"sufficient": None, "survivable_peak": None}
        if self.beyond:
            size = MAX_LINEAR_ANGLE / self.wind_angle
            known = replace(self.case, wind=_scaled(self.slanting or self.blows, size))
            within = case_need(known, self.dead_band).judged
            return {"sufficient": None, "survivable_peak": within["survivable_peak"]}
        size = limit / needed if needed else np.inf
        if not self.in_calm_air and 0.0 < size < np.inf:
            size = survived_size(
                limit, lambda size: size * self.frozen_deflection * self._factor_at(size)
            )
        bound = self.peak_bound
        peak = bound if np.isinf(size) else self.judged_peak * size
        return {
            "sufficient": bool(covers(limit, needed)),
            "survivable_peak": float(np.copysign(min(abs(peak), abs(bound)), bound)),
        }

    @property
    def governs(self) -> str:
        """What the required deflection is governed by, in words."""
        if not self.in_calm_air:
            return f"the dynamic pressure in a {self.counts[0]} wind"
        if self.planes is not None and self.in_both:
            return self.planes.governs
        return self.requirement.governs


def case_need(case: Case, dead_band: float = 1.0) -> CaseNeed:
    """Return what a wind of one shape requires of the nozzle of a case; it raises as `Study.of`."""
    K, wind = number("dead_band", dead_band, between(0.0, 1.0)), pulse_of(case)
    single("vehicle", coefficients_of(case.vehicle, case.plane).batch)
    stop = None if case.nozzle.stop is None else stop_of(case.nozzle.stop)
    blows, planes = case.blows_at(K), None
    assert isinstance(blows, ShapedWind)
    if wind.heading is not None:
        whole = whole_vehicle(case.vehicle, "a wind with a direction")
        placed = replace(wind, gust_at=blows.gust_at)
        planes = of_heading(whole, case.model, placed, stop, K)
    elif stop is not None:
        raise InputError(
            "a stop of both planes needs a wind with a direction: give where it blows from,"
            " and the azimuth of the flight"
        )
    plant, history = Plant.from_vehicle(case.vehicle, case.model, case.plane), blows.history({})
    required = required_deflection(plant, history, K)
    if beyond_linear(float((planes or history).peak)):
        required, planes = _unknown(required), planes and _unknown_planes(planes)
    factors, unknown = _factors(case, history, required, K)
    return CaseNeed(case, K, blows, required, planes, factors, unknown)


def _unknown(required: RequiredDeflection) -> RequiredDeflection:
    """Requirement [rad] of a wind beyond linear aerodynamics: no number but that over trim."""
    return replace(required, deflection=np.nan, needs=dict.fromkeys(required.needs, np.nan))


def _unknown_planes(planes: PlanesNeeded) -> PlanesNeeded:
    """Requirement [rad] of both planes in such a wind."""
    return replace(planes, deflection=np.nan, alone=dict.fromkeys(planes.alone, np.nan))


def _scaled(wind: ShapedWind, factor: float) -> ShapedWind:
    """Wind with its peak and its gust times a factor."""
    gust = None if wind.gust is None else wind.gust * factor
    return replace(wind, peak=wind.peak * factor, gust=gust)


def pulse_of(case: Case) -> ShapedWind:
    """Return the wind of a case; `InputError` for one that is not of one shape."""
    if not isinstance(case.wind, ShapedWind):
        raise InputError(
            "a study needs a wind of one shape: give shape, peak and duration in [wind]"
        )
    return case.wind


def _factors(
    case: Case, history: History, required: RequiredDeflection, dead_band: float
) -> tuple[dict[str, float], str]:
    """What the sign of a wind changes, and why it is not known; what is asked for must be."""
    if not np.isfinite(required.deflection):
        return {}, ""
    try:
        return sign_factors(case, history, dead_band, calm=required.needs), ""
    except InputError as error:
        if case.sign is not None:
            raise
        return {}, str(error)
