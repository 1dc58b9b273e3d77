"""Notes of a study: limits of validity of its numbers, and inputs that were assumed."""

from __future__ import annotations

from collections.abc import Iterator
from math import radians
from typing import Any

import numpy as np

from tvclin.answers.case import FROZEN, Case
from tvclin.answers.case_requirement import CaseRequirement
from tvclin.answers.requirement import RequiredDeflection, required_deflection
from tvclin.base.quantities import NOMINAL
from tvclin.boundary.forecast_free import ForecastFreeLimit
from tvclin.boundary.limit import PAIRED_POLES
from tvclin.boundary.open_loop import ROUNDING, Reason
from tvclin.boundary.optimum.two_poles import single_pole_validity
from tvclin.linear.modes import Modes
from tvclin.linear.plant import DEFAULT_MODEL, ONE_POLE, Plant
from tvclin.vehicle.linear_vehicle import AnyVehicle, LinearVehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.vehicle.vehicle import vehicle_warnings as slips
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.wind_angles import pressure_ratio

_MAX_NOMINAL_PRESSURE_ANGLE_RAD = radians(1.5)
"""Wind angle [rad] above which the change of dynamic pressure exceeds the error of the boundary."""

_POLE_REDUCTION = 0.04
"""Relative reduction of the pole of a booster by the damping of air and jet, about."""
_MAX_DURATION_OVER_TIME_CONSTANT = 2.5
"""Duration over the time constant of the pole, above which a slower pole may require more."""
OUTLASTS = "is too long for the single-pole theory"
"""Words on a wind in the notes of a study."""
TRUSTS = "trusts a forecast"
"""Words on a dead band in the notes of a study."""


def doubts(vehicle: AnyVehicle) -> Iterator[str]:
    """Yield warnings on implausible or unknown numbers of a vehicle."""
    if isinstance(vehicle, LinearVehicle):
        if not vehicle.path_known:
            yield (
                "the flight path is held fixed: how the vehicle drifts with the wind is not known"
                " from mu_alpha and mu_delta, and a long wind may then need more"
            )
    else:
        yield from slips(vehicle)


def along_the_path(need: CaseRequirement) -> Iterator[str]:
    """Yield a note where a strong wind in the pitch plane changes the dynamic pressure."""
    if need.plane != "pitch" or abs(float(need.history.peak)) <= _MAX_NOMINAL_PRESSURE_ANGLE_RAD:
        return
    changes = "this wind along the path also changes the dynamic pressure, which is frozen here"
    if need.sign == FROZEN:
        yield f"{changes}, as asked: a head wind needs more"
    elif need.encountered_unknown:
        yield f"{changes}; what a head wind needs more is not known: {need.encountered_unknown}"


def nominal_pressure(case: Case) -> Iterator[str]:
    """Yield a note on the rise of the dynamic pressure in a head wind over the nominal one."""
    peak = abs(float(getattr(case.wind, "peak", 0.0)))
    if (
        case.plane != "pitch"
        or peak <= _MAX_NOMINAL_PRESSURE_ANGLE_RAD
        or not isinstance(case.vehicle, Vehicle)
    ):
        return
    ratio = float(pressure_ratio(case.vehicle.attitude, np.asarray(-peak)))
    if ratio > 1.0:
        yield (
            f"computed {NOMINAL}; a head wind of this size raises it by up to"
            f" {100.0 * (ratio - 1.0):.2g} percent and requires more"
        )


def gust_placed(asked: ShapedWind, placed: ShapedWind) -> Iterator[str]:
    """Yield the time of a gust that was placed where it requires most."""
    if asked.gust_at is None and placed.gust_at is not None:
        yield (
            f"the gust comes when it asks for most, at {placed.gust_at:.4g} s (--gust-at, or"
            " peak_time_s in [gust], gives another time)"
        )


def slow_or_paired(
    plant: Plant, wind: Any, required: RequiredDeflection, dead_band: float
) -> Iterator[str]:
    """Yield a note on a pair of unstable modes, or a wind too long for the single-pole theory."""
    if required.status == PAIRED_POLES:
        yield (
            "two unstable poles are a pair or equal here, and no limit meets the condition (4b) of"
            " both: required is the largest trim deflection over K, so that the dead band is never"
            " left (tvclin optimum shows the minimum)"
        )
        return
    edge = float(single_pole_validity(plant.coefficients))
    flown = dead_band == 1.0 and plant.model not in ONE_POLE
    if wind.end - wind.onset > edge and required.governs == Reason.BOUNDARY and not flown:
        yield (
            f"a wind of more than {edge:.1f} s {OUTLASTS}: the slow mode of the flight path may"
            " then need more (tvclin optimum)"
        )


def left_out(plant: Plant, modes: dict[str, Modes]) -> Iterator[str]:
    """Yield a note where the exact model has unstable modes that this model omits."""
    name = DEFAULT_MODEL
    if plant.model not in ONE_POLE or name not in modes:
        return
    more = modes[name].poles.size > modes[plant.model].poles.size
    if more and np.isnan(single_pole_validity(plant.coefficients)):
        yield (
            f"the exact model has unstable modes that {plant.model} leaves out, and may need more"
            f" (--model {name})"
        )


def forecast_trusted(
    required: RequiredDeflection, dead_band: float, free: ForecastFreeLimit | None
) -> Iterator[str]:
    """Yield a note where the required limit is below the bound of laws without a forecast."""
    if free is None or dead_band == 1.0:
        return
    bound = abs(float(free.deflection))
    if bound > abs(float(required.deflection)) * (1.0 + ROUNDING):
        yield (
            f"K = {dead_band:g} {TRUSTS}: any law that does not know when this wind will"
            f" stop needs at least {np.degrees(bound):.3f} deg"
        )


def undamped(
    plant: Plant, wind: Any, required: RequiredDeflection, dead_band: float
) -> Iterator[str]:
    """Yield a note where a vehicle without damping requires less, because its pole is faster."""
    c = plant.coefficients
    if dead_band == 1.0 or np.any(c.damping) or float(c.mu_alpha) <= 0.0:
        return
    if float(wind.end - wind.onset) * float(c.pole) <= _MAX_DURATION_OVER_TIME_CONSTANT:
        return
    slower = (1.0 - _POLE_REDUCTION) * float(c.pole)
    damped = c.replace(damping=float(c.mu_alpha) / slower - slower)  # p (p + d) = mu_alpha
    needed = required_deflection(Plant(damped, plant.model), wind, dead_band)
    damped_limit, undamped_limit = (abs(float(r.deflection)) for r in (needed, required))
    if damped_limit > undamped_limit * (1.0 + ROUNDING):
        excess = damped_limit / undamped_limit - 1.0
        yield (
            "no pitch_damping is given, and leaving it out is not conservative here: a pole"
            f" {100 * _POLE_REDUCTION:.0f} percent slower would need {100 * excess:.1f}"
            " percent more"
        )
