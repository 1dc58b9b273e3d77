"""What is computed for each case: a registry of pure functions from a batch to columns."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tvclin.answers.campaign.batch import Batch, in_planes, required_name
from tvclin.answers.campaign.both import least_of_both, required_of_both
from tvclin.answers.campaign.flights import COLUMNS, flights
from tvclin.answers.campaign.plan import Campaign
from tvclin.answers.requirement import required_deflection
from tvclin.answers.sizing.wind_sign import OWN, batch_factors
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import naming
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.optimum.least_peaks import least_peaks
from tvclin.control.margins.record import loop_margins
from tvclin.flights.flown_boundary import flown_boundary
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import BOTH
from tvclin.winds.histories import History

_FLOWN_TO = 5e-4
"""Boundaries are flown to this part of the largest trim deflection."""


@dataclass(frozen=True)
class Output:
    """One kind of answer.

    `columns`: from a campaign to the names of its columns and their units. `work`: from a campaign
    and a batch to those columns, ``(n,)`` each or one number for all; `InputError` when one of the
    cases cannot be answered. `alone`: from a campaign to whether the work takes one case at a time.
    """

    columns: Callable[[Campaign], dict[str, str]]
    work: Callable[[Campaign, Batch], dict[str, Any]]
    alone: Callable[[Campaign], bool] = lambda _: False


def columns(campaign: Campaign) -> dict[str, str]:
    """Return the names of the outputs of a campaign and their units."""
    every = [REGISTRY[output].columns(campaign) for output in campaign.outputs]
    return {name: unit for some in every for name, unit in some.items()}


def compute(campaign: Campaign, batch: Batch, *, alone: bool) -> dict[str, FloatArray]:
    """Return the outputs of a batch that are computed together or alone, ``(n,)`` each.

    `InputError` when one of the cases cannot be answered.
    """
    found: dict[str, Any] = {}
    for name in campaign.outputs:
        if REGISTRY[name].alone(campaign) == alone:
            with naming(f"output {name}"):
                found |= REGISTRY[name].work(campaign, batch)
    return {name: np.broadcast_to(values, (batch.count,)) for name, values in found.items()}


def _of_planes(campaign: Campaign, columns: dict[str, str]) -> dict[str, str]:
    """Return columns and their units, and those of each plane where both are judged."""
    if campaign.planes != BOTH:
        return columns
    each = {of: unit for name, unit in columns.items() for of in in_planes(name).values()}
    return columns | each


def _required(campaign: Campaign, batch: Batch) -> dict[str, FloatArray]:
    if batch.parts:
        every = (required_of_both(campaign, batch, K) for K in campaign.dead_bands)
        return {name: values for one in every for name, values in one.items()}
    sign = OWN if campaign.wind.count and campaign.sign is None else campaign.sign
    given = (batch.vehicle.rigid, campaign.model, campaign.plane, batch.wind)
    return {
        required_name(K): np.abs(required_deflection(batch.plant, batch.wind, K).deflection)
        * batch_factors(*given, K, sign)
        for K in campaign.dead_bands
    }


def _slow(campaign: Campaign) -> bool:
    """Whether the least peak is a search of its own for each case, which three poles ask for."""
    return campaign.model == "drift-and-speed"


def _searched(campaign: Campaign) -> bool:
    """Whether the minimum is, as that of vectors is too."""
    return _slow(campaign) or campaign.planes == BOTH


def _forecast_free(campaign: Campaign, batch: Batch) -> dict[str, Any]:
    def alone(plant: Plant, wind: History) -> Any:
        return np.abs(forecast_free_limit(plant, wind).deflection)

    if batch.parts:
        return least_of_both(campaign, batch, "forecast_free", alone, lambda one: one.no_forecast)
    return {"forecast_free": alone(batch.plant, batch.wind)}


def _minimum(campaign: Campaign, batch: Batch) -> dict[str, Any]:
    if batch.parts:
        return least_of_both(campaign, batch, "minimum", least_peaks, lambda one: one.minimum)
    return {"minimum": least_peaks(batch.plant, batch.wind)}


_MARGINS = {
    "margin_aero_dB": "dB",
    "margin_gain_dB": "dB",
    "margin_phase_deg": "deg",
    "margin_delay": "s",
}


def _margin_columns(campaign: Campaign) -> dict[str, str]:
    peaks = {f"margin_{one}_peak_dB": "dB" for one in _mode_names(campaign)}
    return {"margin_stable": ""} | _MARGINS | peaks


def _mode_names(campaign: Campaign) -> list[str]:
    """Names of the modes, as in "bending_1", in the order of their bands."""
    s = campaign.vehicle.structure
    counts = {} if s is None else {"bending": len(s.bending), "slosh": len(s.slosh)}
    return [f"{kind}_{k}" for kind, count in counts.items() for k in range(1, count + 1)]


def _margins(campaign: Campaign, batch: Batch) -> dict[str, Any]:
    """The margins of the autopilot around each vehicle; of a flexible one also peaks by mode."""
    autopilot, peaks = replace(campaign.autopilot, **batch.gains), {}
    if batch.flexible is not None and _mode_names(campaign):
        bands = autopilot.band_margins(batch.flexible)
        whole = bands.whole
        pairs = zip(_mode_names(campaign), bands.modes, strict=True)
        peaks = {f"margin_{name}_peak_dB": mode.peak_dB for name, mode in pairs}
    else:
        whole = loop_margins(autopilot.exact_loop(batch.flying))
    values = (whole.aero_margin_dB, whole.gain_increase_dB, whole.phase_margin_deg)
    found = dict(zip(_MARGINS, (*values, whole.delay_margin), strict=True))
    return {"margin_stable": np.asarray(whole.stable, dtype=float)} | found | peaks


def _flown(campaign: Campaign, batch: Batch) -> dict[str, float]:
    """The boundary found by flights with six degrees of freedom, some dozen for each."""
    vehicle, wind = batch.one_vehicle(), batch.one()[1]

    def flown(K: float) -> float:
        found = flown_boundary(
            vehicle, wind, K, engine="sixdof", plane=campaign.plane, tolerance=_FLOWN_TO
        )
        return abs(found.deflection)

    return {required_name(K, "flown"): flown(K) for K in campaign.dead_bands}


REGISTRY = {
    "required": Output(
        lambda campaign: _of_planes(
            campaign, {required_name(K): "rad" for K in campaign.dead_bands}
        ),
        _required,
        _slow,
    ),
    "forecast-free": Output(
        lambda campaign: _of_planes(campaign, {"forecast_free": "rad"}),
        _forecast_free,
        lambda campaign: campaign.planes == BOTH,
    ),
    "minimum": Output(
        lambda campaign: _of_planes(campaign, {"minimum": "rad"}), _minimum, _searched
    ),
    "margins": Output(_margin_columns, _margins),
    "flight": Output(lambda campaign: _of_planes(campaign, COLUMNS), flights),
    "flown": Output(
        lambda campaign: {required_name(K, "flown"): "rad" for K in campaign.dead_bands},
        _flown,
        lambda _: True,
    ),
}
"""By the names that a campaign may ask for."""
