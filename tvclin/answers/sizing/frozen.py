"""Requirements of one wind on the deflection limit of a vehicle frozen at its flight time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.answers.requirement import required_deflection
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.limit import OK, PAIRED_POLES, STABLE
from tvclin.boundary.optimum.minimum_peak import minimum_peaks
from tvclin.control.laws.recoverable import RecoverableAttitudeLaw
from tvclin.flights.closed_loop.survival_limit import closed_loop_boundary
from tvclin.linear.modes import unstable_modes
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History

LAWS = ("bound", "flown")
"""Bases of the requirement without a forecast."""
_SAMPLE_RATE_HZ = 100.0
"""Sample rate [Hz] of flights of the recoverable-attitude law."""
_MAX_LIMIT_OVER_TRIM = 4.0
"""Largest limit of these flights over the largest trim deflection."""


@dataclass(frozen=True, eq=False)
class FrozenRequirement:
    """Required deflections [rad] of a frozen vehicle in one wind; NaN where one is not defined.

    `trim` is the static trim |B alpha_w,max|; `required` for each dead band, ``(k,)``;
    `no_forecast` the lower bound of laws without a forecast; `minimum` the minimum peak of appendix
    C; `slow_mode` y of eq (C8), from one on the slow mode of the flight path decides. `said` is why
    one is not defined, or not satisfied exactly.
    """

    trim: float
    required: FloatArray
    no_forecast: float
    minimum: float
    slow_mode: float
    said: tuple[str, ...]


def frozen_requirement(
    plant: Plant,
    wind: History,
    dead_bands: FloatArray,
    law: str,
    whole: History | None = None,
) -> FrozenRequirement:
    """Return the requirements [rad] of a wind that ends, at dead bands ``(k,)``.

    With the law "bound" `no_forecast` is the bound of all laws without a forecast, with "flown" the
    smallest limit that the recoverable-attitude law survives with. `whole` is the wind with the
    angles of both signs.
    """
    said: list[str] = []

    def value_or(function: Callable[[], Any], missing: Any) -> Any:
        try:
            return function()
        except InputError as error:
            said.append(str(error))
            return missing

    paired = False

    def largest() -> FloatArray:
        nonlocal paired
        limit = required_deflection(plant, wind, dead_bands, whole=whole)
        statuses = dict.fromkeys(np.ravel(limit.status).tolist())
        said.extend(status for status in statuses if status not in (OK, STABLE))
        paired = PAIRED_POLES in statuses
        return np.abs(np.asarray(limit.deflection))

    slow = slow_mode(plant, wind)
    exact = Plant.from_coefficients(plant.coefficients, "drift-exact")
    two = exact if (slow > 1.0 or slow < 0.0) and _unstable(plant) == 1 else plant
    minimum = value_or(lambda: float(minimum_peaks(two, wind)), np.nan)
    required = np.maximum(
        value_or(largest, np.nan), np.full(dead_bands.shape, np.nan_to_num(minimum))
    )
    no_forecast = np.nan
    if paired:
        said.append("no bound of laws without a forecast is known where two modes grow as a pair")
    else:
        no_forecast = value_or(lambda: _no_forecast(plant, wind, law), np.nan)
    return FrozenRequirement(
        trim=abs(float(plant.coefficients.B * wind.peak)),
        required=required,
        no_forecast=no_forecast,
        minimum=minimum,
        slow_mode=slow,
        said=tuple(dict.fromkeys(said)),
    )


def slow_mode(plant: Plant, wind: History) -> float:
    """Return y of eq (C8) for any wind: the ratio of the slow mode's demand to the fast mode's.

    It is one at the edge of the single-pole theory, for a triangle at `single_pole_validity`, and
    negative where the modes are driven in opposite directions. NaN without two real unstable poles.
    """
    modes = unstable_modes(Plant.from_coefficients(plant.coefficients, "drift-exact"))
    if modes.poles.size < 2 or np.iscomplexobj(modes.poles) or not np.isfinite(wind.onset):
        return float("nan")
    from_onset = wind.shift(-wind.onset).laplace(modes.poles)
    demands = modes.poles * from_onset * modes.wind_residues / modes.deflection_residues
    return float(demands[1] / demands[0])


def _no_forecast(plant: Plant, wind: History, law: str) -> float:
    """Return the required deflection [rad] without a forecast; zero for a stable plant."""
    if not _unstable(plant):
        return 0.0
    if law == "bound":
        return abs(forecast_free_limit(plant, wind).deflection)
    flown = RecoverableAttitudeLaw(plant, design_peak=abs(float(wind.peak)))
    boundary = closed_loop_boundary(
        plant, flown, wind, sample_rate=_SAMPLE_RATE_HZ, highest=_MAX_LIMIT_OVER_TRIM
    )
    return abs(boundary.deflection)


def _unstable(plant: Plant) -> int:
    """Return the number of unstable poles."""
    return int(unstable_modes(plant).poles.size)
