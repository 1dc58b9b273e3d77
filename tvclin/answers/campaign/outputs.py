"""What is computed for each case: a registry of pure functions from a batch to columns."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from tvclin.answers.campaign.batch import Batch, in_planes, required_name
from tvclin.answers.campaign.dispersions import names_of_modes
from tvclin.answers.campaign.flights import COLUMNS, flights
from tvclin.answers.campaign.plan import Campaign
from tvclin.answers.encountered_requirement import encountered_batch
from tvclin.answers.planes import VectorNeed, planes_needed, rectangle, vector_need
from tvclin.answers.requirement import required_deflection
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import naming
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.open_loop import ROUNDING
from tvclin.boundary.optimum.least_peaks import least_peaks
from tvclin.boundary.stops import stop_of
from tvclin.control.margins.margins import loop_margins
from tvclin.flights.flown_boundary import flown_boundary
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import within_linear

_FLOWN_TO = 5e-4
"""Boundaries are flown to this part of the largest trim deflection."""


_IN_BEYOND = dict.fromkeys(("flight_survived", *in_planes("flight_survived").values()), 0.0)
"""Of outputs that are no angle, the value in a wind beyond linear aerodynamics."""


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

    In a wind beyond linear aerodynamics no deflection is known to be sufficient: it is infinite,
    and a flight counts as lost. `InputError` when one of the cases cannot be answered.
    """
    found: dict[str, Any] = {}
    for name in campaign.outputs:
        if REGISTRY[name].alone(campaign) == alone:
            with naming(f"output {name}"):
                found |= REGISTRY[name].work(campaign, batch)
    shape, beyond = (batch.count,), ~within_linear(batch.wind_angle)
    return {
        name: np.broadcast_to(values, shape)
        if name.startswith("margin_")
        else np.where(np.broadcast_to(beyond, shape), _IN_BEYOND.get(name, np.inf), values)
        for name, values in found.items()
    }


def _of_planes(campaign: Campaign, columns: dict[str, str]) -> dict[str, str]:
    """Return columns and their units, and those of each plane where both are judged."""
    if campaign.planes != BOTH:
        return columns
    each = {of: unit for name, unit in columns.items() for of in in_planes(name).values()}
    return columns | each


def _required(campaign: Campaign, batch: Batch) -> dict[str, FloatArray]:
    every = (_required_at(campaign, batch, K) for K in campaign.dead_bands)
    return {name: values for one in every for name, values in one.items()}


def _required_at(campaign: Campaign, batch: Batch, dead_band: float) -> dict[str, FloatArray]:
    """Required deflections [rad] at the dynamic pressure encountered, as of a study.

    Of both planes each has a column beside that of the limit shape.
    """
    name, vehicles = required_name(dead_band), batch.vehicle.rigid
    of = partial(encountered_batch, campaign, batch.values, vehicles, dead_band)
    if not batch.parts:
        nominal = required_deflection(batch.plant, batch.wind, dead_band).deflection
        return {name: of(campaign.plane, np.abs(nominal))}
    stop = stop_of(campaign.nozzle.stop or "")
    found = planes_needed(batch.plants, batch.vectors, stop, dead_band)
    alone = {plane: of(plane, np.abs(found.alone[plane])) for plane in batch.parts}
    both = rectangle(stop, alone.get("pitch", 0.0), alone.get("yaw", 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = [np.nan_to_num(x / np.abs(found.alone[k])) for k, x in alone.items()]
    vector = found.deflection > rectangle(stop, **found.alone) * (1.0 + ROUNDING)
    both = np.where(vector, np.maximum(both, found.deflection * np.max(ratios, axis=0)), both)
    alone = {plane: alone.get(plane, found.alone[plane]) for plane in PLANES}
    return {name: both} | {column: alone[plane] for plane, column in in_planes(name).items()}


def _slow(campaign: Campaign) -> bool:
    """Whether the least peak is a search of its own for each case, which three poles ask for."""
    return campaign.model == "drift-and-speed"


def _forecast_free(plant: Plant, wind: History) -> FloatArray:
    return np.abs(forecast_free_limit(plant, wind).deflection)


def _least(
    name: str,
    alone: Callable[[Plant, History], Any],
    vector: Callable[[VectorNeed], float],
    campaign: Campaign,
    batch: Batch,
) -> dict[str, Any]:
    """What nothing undercuts; in both planes, and in each by itself, of the first case."""
    if not batch.parts:
        return {name: alone(batch.plant, batch.wind)}
    stop, shape = stop_of(campaign.nozzle.stop or ""), (batch.count,)
    each = dict.fromkeys(PLANES, 0.0)
    firsts = {plane: one.first for plane, one in batch.parts.items()}
    each |= {k: float(np.abs(alone(one.plant, one.wind))) for k, one in firsts.items()}
    reach = stop.support(np.array([1.0, 1j, -1.0, -1j])).reshape(2, 2).max(axis=0)
    both = max(one / most for one, most in zip(each.values(), reach.tolist(), strict=True))
    if len(batch.parts) > 1:
        pitch, yaw = (one.case(0, shape) for one in batch.plants.values())
        needs = vector_need(pitch, yaw, batch.vectors.case(0, shape), stop, np.ones(1))
        both = max(both, vector(needs))
    return {name: both} | {of: each[plane] for plane, of in in_planes(name).items()}


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
    return [name for some in names_of_modes(campaign.vehicle.structure).values() for name in some]


def _margins(campaign: Campaign, batch: Batch) -> dict[str, Any]:
    """The margins of the autopilot around each vehicle; of a flexible one also peaks by mode."""
    autopilot, peaks = replace(campaign.autopilot, **batch.gains), {}
    if batch.flexible is not None and _mode_names(campaign):
        bands = autopilot.band_margins(batch.flexible)
        whole = bands.margins
        pairs = zip(_mode_names(campaign), bands.modes, strict=True)
        peaks = {f"margin_{name}_peak_dB": mode.peak_dB for name, mode in pairs}
    else:
        whole = loop_margins(autopilot.exact_loop(batch.flying))
    values = (whole.aero_margin_dB, whole.gain_increase_dB, whole.phase_margin_deg)
    found = dict(zip(_MARGINS, (*values, whole.delay_margin), strict=True))
    return {"margin_stable": np.asarray(whole.stable, dtype=float)} | found | peaks


def _flown(campaign: Campaign, batch: Batch) -> dict[str, float]:
    """The boundary found by flights with six degrees of freedom, some dozen for each."""
    vehicle, wind = batch.first.vehicle, batch.first.wind

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
        partial(_least, "forecast_free", _forecast_free, lambda one: one.no_forecast),
        lambda campaign: campaign.planes == BOTH,
    ),
    "minimum": Output(
        lambda campaign: _of_planes(campaign, {"minimum": "rad"}),
        partial(_least, "minimum", least_peaks, lambda one: one.minimum),
        lambda campaign: _slow(campaign) or campaign.planes == BOTH,
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
