"""Required deflection of the nozzle of a case: the number that the verdict of a study rests on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np

from tvclin.base.errors import InputError, NotKnownError, between, number, positive, single, within
from tvclin.base.fields import Field, spec, specs
from tvclin.base.quantities import NOMINAL, sufficiency
from tvclin.boundary.limit_shapes import limit_shape_of
from tvclin.case.case import Case
from tvclin.linear.plant import Plant
from tvclin.requirement.encountered_requirement import encountered_requirements
from tvclin.requirement.nominal_requirement import RequiredDeflection, covers, required_deflection
from tvclin.requirement.plane_requirement import TwoPlaneRequirement, heading_requirement
from tvclin.vehicle.linear_vehicle import (
    AnyVehicle,
    LinearVehicle,
    coefficients_of,
    complete_vehicle,
)
from tvclin.winds.histories import History
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.wind_angles import FROZEN, MAX_LINEAR_ANGLE, beyond_linear

_SIZE_TOLERANCE = 1e-9
"""Tolerance of the logarithm of a factor on the wind."""
_MIN_SIZE = 1e-9
"""Factor on the wind up to which the requirement is proportional to it, as at nominal pressure."""


@dataclass(frozen=True, eq=False)
class CaseRequirement:
    """Requirement of a wind on the nozzle of a case, at one dead band.

    Attributes
    ----------
    case : Case
        The case; the verdict rests on its model.
    dead_band : float
        K of the verdict.
    wind_in_plane : ShapedWind
        The wind in the plane, with its gust.
    requirement : RequiredDeflection
        Required deflection at nominal dynamic pressure.
    planes : TwoPlaneRequirement or None
        Requirement of both planes at nominal dynamic pressure, in a wind with a direction.
    encountered : dict of str to float
        Required deflection [rad] at the wind's own angle and dynamic pressure, by its possible
        directions: head and tail, one of them, or cross. Empty by request, and where it is not
        known.
    encountered_unknown : str
        Reason why it is not known.

    All requirements are NaN, or empty, in a wind beyond linear aerodynamics (`beyond_linear`).
    """

    case: Case = field(
        metadata=specs(
            Field("vehicle", of="vehicle.name", document=False),
            Field("model", of="model"),
            Field("plane", of="plane", document=False),
            Field("sign", of="sign", card=False),
            Field("limit", "angle", of="limit"),
        )
    )
    dead_band: float = field(metadata=spec())
    wind_in_plane: ShapedWind
    requirement: RequiredDeflection = field(
        metadata=specs(
            Field("required_deflection", "angle", of="known_deflection"),
            Field("governed_by", of="governs"),
            Field("requirements", "angle", of="requirement.needs", card=False),
            Field("nominal_deflection", "angle", of="nominal_deflection", card=False),
        )
    )
    planes: TwoPlaneRequirement | None
    encountered: dict[str, float] = field(metadata=spec("angle", card=False))
    encountered_unknown: str

    @property
    def vehicle(self) -> AnyVehicle:
        """The vehicle of the case."""
        return self.case.vehicle

    @property
    def plane(self) -> str:
        """Plane of the boundaries, and of the verdict unless it is on both planes."""
        return self.case.plane

    @property
    def model(self) -> str:
        """The model on which the verdict rests."""
        return self.case.model

    @property
    def sign(self) -> str | None:
        """Sign of the wind along the path that counts, as the case specifies it."""
        return self.case.sign

    @property
    def limit(self) -> float | None:
        """Available deflection [rad]; None if the case specifies none."""
        return self.case.nozzle.limit

    @property
    def slanting(self) -> ShapedWind | None:
        """The wind with its heading and its gust placed in time; None without a heading."""
        return None if self.case.heading is None else self.placed

    @property
    def placed(self) -> ShapedWind:
        """The wind of the case as one shape, with its gust at the time that `wind_in_plane` has.

        It keeps the direction (heading) and the wind speeds of the case, where it has these.
        """
        return replace(pulse_of(self.case), gust_at=self.wind_in_plane.gust_at)

    @property
    def judges_both_planes(self) -> bool:
        """Whether the verdict is on pitch and yaw together, not on one plane."""
        return self.case.nozzle.limit_shape is not None

    @property
    def judged_planes(self) -> TwoPlaneRequirement | None:
        """The requirement of both planes where the verdict is on them together; else None."""
        return self.planes if self.judges_both_planes else None

    @property
    def history(self) -> History:
        """The wind angle [rad] over time in the plane `plane`, with its gust."""
        return self.wind_in_plane.history({})

    @property
    def required_deflection(self) -> float:
        """The required deflection [rad] at the verdict's model and dead band, a size.

        It is the largest of `encountered`, or if that is empty, at nominal dynamic pressure.
        """
        if self.direction == FROZEN:
            return self.nominal_deflection
        return self.encountered[self.direction]

    @property
    def known_deflection(self) -> float:
        """The required deflection [rad]; NaN if unknown at the dynamic pressure encountered."""
        return np.nan if self.unknown else self.required_deflection

    @property
    def nominal_deflection(self) -> float:
        """The required deflection [rad] at nominal dynamic pressure, a size."""
        if self.judged_planes is not None:
            return self.judged_planes.deflection
        return abs(float(self.requirement.deflection))

    @property
    def see_study(self) -> str:
        """Required deflection in a clause, for answers other than the study."""
        if self.unknown:
            return f"required deflection {sufficiency(None)}, see study"
        if np.isinf(self.required_deflection):
            return "no limit is sufficient, see study"
        band = "" if self.dead_band == 1.0 else f" with K = {self.dead_band:g}"
        where = NOMINAL if self.at_nominal_pressure else f"in a {self.direction} wind"
        required = f"{np.degrees(self.required_deflection):.3f} deg"
        return f"required deflection {required}{band} {where}, see study"

    @property
    def plane_ratio(self) -> float:
        """Limit of both planes over the limit of this plane; 1 if no other plane is judged.

        The wind's peaks in both planes give it.
        """
        return 1.0 if self.judged_planes is None else self.judged_planes.ratio_to(self.plane)

    @property
    def direction(self) -> str:
        """The direction of the wind that sets the required deflection: head, tail or cross.

        `FROZEN` where that is at nominal dynamic pressure, so that `encountered` is empty.
        """
        return max(self.encountered, key=self.encountered.__getitem__, default=FROZEN)

    @property
    def at_nominal_pressure(self) -> bool:
        """Whether the required deflection is that at nominal dynamic pressure."""
        return self.direction == FROZEN

    @property
    def unknown(self) -> str:
        """Reason why the required deflection may be larger in the wind's worst direction, or empty.

        A vehicle without speed and attitude is judged at nominal dynamic pressure.
        """
        if not self.encountered_unknown or isinstance(self.vehicle, LinearVehicle):
            return ""
        if not self.nominal_deflection:  # zero at any dynamic pressure
            return ""
        reason = self.encountered_unknown
        return f"the requirement at the pressure encountered is not known: {reason}"

    @property
    def ratio_to_nominal(self) -> float:
        """The required deflection over that at nominal dynamic pressure; one where that is zero."""
        nominal = self.nominal_deflection
        return self.required_deflection / nominal if nominal else 1.0

    def required_at(self, size: float) -> float:
        """Return the required deflection [rad] in `size` times this wind, in its worse direction.

        Infinite for an angle that no horizontal wind has, so that its dynamic pressure is unknown.
        `InputError` for a size that is not between 1e-9 and 1e9.
        """
        within("size", number("size", size, positive), 1e-9, 1e9)
        if self.at_nominal_pressure:
            return self.nominal_deflection * (self.peak_at(size) / self.judged_peak)
        try:
            return max(_encountered(self, size).values())
        except InputError:
            return np.inf

    def peak_at(self, size: float) -> float:
        """Return the peak [rad] of `size` times the judged wind, with the sign of `judged_peak`.

        A wind by its speed has the nominal angle of `size` times this speed, eq (B1e).
        """
        if not self.is_by_speed or not size:
            return size * self.judged_peak
        wind = self._scaled(size)
        if not self.judges_both_planes:
            return float(replace(self.case, wind=wind).history.peak)
        return self.judged_peak * (wind.peak / self.placed.peak)  # of vectors in both planes

    @property
    def is_by_speed(self) -> bool:
        """Whether the wind, or its gust, is given by its speed."""
        return self.placed.speed is not None or self.placed.gust_speed is not None

    def _scaled(self, size: float) -> ShapedWind:
        """Return `size` times the wind, of a wind by its speed with the angles of that speed."""
        wind = self.placed.scaled(size)
        if not self.is_by_speed:
            return wind
        return wind.for_vehicle(complete_vehicle(self.vehicle, "a wind by its speed"), self.plane)

    @property
    def judged_peak(self) -> float:
        """Peak [rad] of the judged wind; for both planes the peak of its vector."""
        return float((self.judged_planes or self.history).peak)

    @property
    def wind_angle(self) -> float:
        """Peak size [rad] of the wind angle that the flight encounters.

        Of the vector of pitch and yaw for a wind with a direction (`planes`), else in the plane.
        """
        return abs(float((self.planes or self.history).peak))

    @property
    def beyond_linear(self) -> str:
        """Reason why nothing is known in this wind, of more than 30 deg; empty otherwise."""
        return beyond_linear(self.wind_angle)

    @property
    def largest_size(self) -> float:
        """Factor on the wind at which its wind angle is `MAX_LINEAR_ANGLE`; see `peak_at`."""
        if self.is_by_speed:
            return float(np.sin(MAX_LINEAR_ANGLE) / np.sin(self.wind_angle))
        return MAX_LINEAR_ANGLE / self.wind_angle

    @property
    def peak_bound(self) -> float:
        """Largest survivable peak [rad] that is known, with the sign of `judged_peak`.

        There the wind angle is `MAX_LINEAR_ANGLE`; a limit that survives it may survive more.
        """
        return self.judged_peak * (MAX_LINEAR_ANGLE / self.wind_angle)

    @property
    def judged(self) -> dict[str, Any]:
        """Fields `sufficient`, `survivable_peak` [rad] and `survivable_factor` on this wind.

        None without a limit or where `unknown`. A limit below the requirement at nominal dynamic
        pressure is not sufficient in any case. The peak has the sign of `judged_peak`, and at most
        the size of `peak_bound`, at 30 deg.
        """
        limit, needed, largest = self.limit, self.required_deflection, self.largest_size
        not_known = {"sufficient": None, "survivable_peak": None, "survivable_factor": None}
        if limit is None:
            return not_known
        if self.beyond_linear:
            # the peak is that of the largest wind of this shape within linear aerodynamics
            linear = replace(self.case, wind=self._scaled(largest))
            judged = case_requirement(linear, self.dead_band).judged
            factor = judged["survivable_factor"]
            of_this = {"survivable_factor": None if factor is None else largest * factor}
            return judged | of_this | {"sufficient": None}
        if self.unknown:  # the requirement at the pressure in the wind, at least the nominal one
            return not_known | {"sufficient": None if covers(limit, needed) else False}
        # factor on the wind that the limit survives, if the requirement is in proportion to it
        size = limit / needed if needed else np.inf
        in_proportion = self.at_nominal_pressure and not self.is_by_speed
        if not in_proportion and _MIN_SIZE < size < np.inf:
            # pressure or angle are not in proportion to the wind, so the factor is a root
            size = survived_size(limit, needed, self.required_at, largest)
        bound = self.peak_bound
        peak = bound if size >= largest else self.peak_at(size)  # infinite: nothing is required
        return {
            "sufficient": bool(covers(limit, needed)),
            "survivable_peak": float(np.copysign(min(abs(peak), abs(bound)), bound)),
            "survivable_factor": min(size, largest),
        }

    @property
    def governs(self) -> str:
        """What sets the required deflection, in words: a requirement, or dynamic pressure."""
        if not self.at_nominal_pressure:
            return f"the dynamic pressure in a {self.direction} wind"
        if self.judged_planes is not None:
            return self.judged_planes.governs
        return self.requirement.governs


def case_requirement(case: Case, dead_band: float = 1.0) -> CaseRequirement:
    """Return the requirement of a wind of one shape on the nozzle of a case.

    `dead_band`: K, from 0 to 1. Where the requirement at the dynamic pressure in the wind is not
    known, the reason is in `encountered_unknown`. `InputError` for a wind that is not of one shape,
    a batch, a limit of both planes without a direction of the wind, and a sign of the wind whose
    effect on this pressure cannot be computed.
    """
    K, wind = number("dead_band", dead_band, between(0.0, 1.0)), pulse_of(case)
    single("vehicle", coefficients_of(case.vehicle, case.plane).batch)
    limit_shape = (
        None if case.nozzle.limit_shape is None else limit_shape_of(case.nozzle.limit_shape)
    )
    (in_plane, unplaced), planes = case.placed_wind(K), None  # its gust at the worst time for K
    assert isinstance(in_plane, ShapedWind)
    if wind.heading is not None:
        vehicle = complete_vehicle(case.vehicle, "a wind with a direction")
        placed = replace(wind, gust_at=in_plane.gust_at)
        planes = heading_requirement(vehicle, case.model, placed, limit_shape, K)
    elif limit_shape is not None:
        raise InputError(
            "a limit of both planes needs a wind with a direction: give where it blows from,"
            " direction_deg in [wind], and the direction of flight, azimuth_deg"
        )
    plant = Plant.from_vehicle(case.vehicle, case.model, case.plane)
    history = in_plane.history({})  # nothing is dispersed
    required = required_deflection(plant, history, K)
    if beyond_linear(float((planes or history).peak)):  # nothing is known: NaN
        unknown = dict.fromkeys(required.needs, np.nan)
        required = replace(required, deflection=np.nan, needs=unknown)
        if planes is not None:
            separate = dict.fromkeys(planes.separate, np.nan)
            planes = replace(planes, deflection=np.nan, separate=separate)
    need = CaseRequirement(
        case=case,
        dead_band=K,
        wind_in_plane=in_plane,
        requirement=required,
        planes=planes,
        encountered={},
        encountered_unknown="",
    )
    if not np.isfinite(required.deflection):
        return need
    if unplaced:  # the requirement with the gust at another time may be too small
        reason = f"the worst time of the gust is not known: {unplaced}"
        return replace(need, encountered_unknown=reason)
    try:
        return replace(need, encountered=_encountered(need))
    except InputError as error:
        if case.sign is not None and not isinstance(error, NotKnownError):
            raise
        return replace(need, encountered_unknown=str(error))


def study_requirement(case: Case, dead_band: float = 1.0) -> CaseRequirement | None:
    """Return the requirement in the study of a case; None where no study is defined.

    `dead_band`: K, from 0 to 1. There is none in a wind that is not of one shape, and beyond linear
    aerodynamics.
    """
    try:
        need = case_requirement(case, dead_band)
    except InputError:
        return None
    return None if np.isnan(need.required_deflection) else need


def pulse_of(case: Case) -> ShapedWind:
    """Return the wind of a case; `InputError` for one that is not of one shape."""
    if not isinstance(case.wind, ShapedWind):
        raise InputError(
            "a study needs a wind of one shape, a [wind] with a peak and no sounding or file;"
            " tvclin fly or tvclin boundary answers for a sounding, tvclin ascent over a flight"
        )
    return case.wind


def _encountered(need: CaseRequirement, size: float = 1.0) -> dict[str, float]:
    """Return required deflections [rad] of a case in `size` times its wind, by direction.

    `need`: requirement of the case at nominal dynamic pressure. Empty where that is to count.
    """
    if need.sign == FROZEN:
        return {}
    directions = encountered_requirements(need.case, need.placed, need.dead_band, size)
    planes = need.judged_planes
    return {
        name: by_plane[need.plane] if planes is None else float(planes.encountered(by_plane, size))
        for name, by_plane in directions.items()
    }


def survived_size(
    limit: float,
    required: float,
    need: Callable[[float], float],
    largest: float = np.inf,
    tolerance: float = _SIZE_TOLERANCE,
) -> float:
    """Return the factor on a wind at which the required deflection is the limit [rad].

    The requirement is taken to rise with the factor; the factor returned is survived.
    `required`: required deflection [rad] of the wind itself; `need`: function that returns it of a
    factor. `largest`: factor beyond which nothing is known, at least one; returned where it is
    survived. `tolerance`: of the logarithm of the factor, not below the relative error of the
    requirement. The root is bracketed from the wind itself, at the logarithm 0, outwards.
    """
    from scipy.optimize import brentq  # late: it takes 0.3 s to import

    @cache
    def excess(x: float) -> float:
        """Return log(requirement/limit) in the wind times e^`x`.

        `need`: function from a factor on the wind to the requirement [rad], `required` for one.
        """
        ratio = (need(float(np.exp(x))) if x else required) / limit
        # zero and infinite requirements have a sign alone
        return float(np.log(ratio)) if 0.0 < ratio < np.inf else np.copysign(1.0, ratio - 1.0)

    first = -excess(0.0)  # logarithm of the factor if the requirement were in proportion
    if abs(first) < tolerance:
        return 1.0
    highest = float(np.log(largest))
    end = min(first, highest)  # other end of the bracket
    if end < highest and excess(end) * first <= 0.0:  # no change of sign up to here
        end = min(2.0 * first, highest)
    while first < 0.0 < excess(end):  # towards smaller winds
        end *= 2.0
    if excess(end) < 0.0 < first:  # the largest factor tried is survived
        return float(np.exp(end))
    root = brentq(excess, 0.0, end, xtol=tolerance)
    return float(np.exp(root - tolerance))  # on the side that survives
