"""Outputs of cases: a registry of pure functions from a batch to columns."""

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
from tvclin.boundary.limit_shapes import limit_shape_of
from tvclin.boundary.open_loop import ROUNDING
from tvclin.boundary.optimum.minimum_peak import minimum_peaks
from tvclin.control.margins.margins import loop_margins
from tvclin.flights.flown_boundary import flown_boundary
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import within_linear

_BOUNDARY_TOLERANCE = 5e-4
"""Tolerance of a flown boundary, relative to the largest trim deflection."""
_VALUES_BEYOND = dict.fromkeys(("flight_survived", *in_planes("flight_survived").values()), 0.0)
"""Values of outputs that are no angles, in a wind beyond linear aerodynamics."""


@dataclass(frozen=True)
class Output:
    """An output of campaigns: its columns and the function that computes them.

    `columns`: from a campaign to the units of the columns by name. `work`: from a campaign and a
    batch to the columns, ``(n,)`` each or a scalar for all cases; `InputError` when a case has no
    answer. `alone`: from a campaign to whether `work` takes a single case at a time.
    """

    columns: Callable[[Campaign], dict[str, str]]
    work: Callable[[Campaign, Batch], dict[str, Any]]
    alone: Callable[[Campaign], bool] = lambda _: False


def columns(campaign: Campaign) -> dict[str, str]:
    """Return the units of the columns of a campaign by name."""
    units: dict[str, str] = {}
    for output in campaign.outputs:
        units |= REGISTRY[output].columns(campaign)
    return units


def compute(campaign: Campaign, batch: Batch, *, alone: bool) -> dict[str, FloatArray]:
    """Return the columns of a batch by name, ``(n,)`` each.

    `alone`: compute the outputs that take a single case at a time, or else all other outputs.

    In a wind beyond linear aerodynamics no deflection is known to be sufficient: it is infinite,
    and a flight counts as lost. `InputError` when a case has no answer.
    """
    outputs: dict[str, Any] = {}
    for name in campaign.outputs:
        if REGISTRY[name].alone(campaign) == alone:
            with naming(f"output {name}"):
                outputs |= REGISTRY[name].work(campaign, batch)
    shape, beyond = (batch.count,), ~within_linear(batch.wind_angle)
    return {
        name: np.broadcast_to(values, shape)
        if name.startswith("margin_")
        else np.where(np.broadcast_to(beyond, shape), _VALUES_BEYOND.get(name, np.inf), values)
        for name, values in outputs.items()
    }


def _of_planes(campaign: Campaign, columns: dict[str, str]) -> dict[str, str]:
    """Return units by column, with the columns of each plane where both planes are judged."""
    if campaign.planes != BOTH:
        return columns
    by_plane = {k: unit for name, unit in columns.items() for k in in_planes(name).values()}
    return columns | by_plane


def _required(campaign: Campaign, batch: Batch) -> dict[str, FloatArray]:
    """Return the required deflections [rad] of a batch at all dead bands, ``(n,)`` by column."""
    required: dict[str, FloatArray] = {}
    for dead_band in campaign.dead_bands:
        required |= _required_at(campaign, batch, dead_band)
    return required


def _required_at(campaign: Campaign, batch: Batch, dead_band: float) -> dict[str, FloatArray]:
    """Return required deflections [rad] at the encountered dynamic pressure, ``(n,)`` by column.

    Where both planes are judged there are three columns: the limit shape, pitch and yaw.
    """
    name, vehicles = required_name(dead_band), batch.vehicle.rigid
    at_encountered = partial(encountered_batch, campaign, batch.values, vehicles, dead_band)
    if not batch.parts:
        nominal = required_deflection(batch.plant, batch.wind, dead_band).deflection
        return {name: at_encountered(campaign.plane, np.abs(nominal))}
    stop = limit_shape_of(campaign.nozzle.stop or "")
    nominal_needs = planes_needed(batch.plants, batch.vectors, stop, dead_band)
    alone = {
        plane: at_encountered(plane, np.abs(nominal_needs.alone[plane])) for plane in batch.parts
    }
    both = rectangle(stop, alone.get("pitch", 0.0), alone.get("yaw", 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = [np.nan_to_num(x / np.abs(nominal_needs.alone[k])) for k, x in alone.items()]
    vector = nominal_needs.deflection > rectangle(stop, **nominal_needs.alone) * (1.0 + ROUNDING)
    both = np.where(
        vector, np.maximum(both, nominal_needs.deflection * np.max(ratios, axis=0)), both
    )
    alone = {plane: alone.get(plane, nominal_needs.alone[plane]) for plane in PLANES}
    return {name: both} | {column: alone[plane] for plane, column in in_planes(name).items()}


def _slow(campaign: Campaign) -> bool:
    """Return whether the minimum peak is a search for each case, as three poles require."""
    return campaign.model == "drift-and-speed"


def _forecast_free(plant: Plant, wind: History) -> FloatArray:
    """Return the limits [rad] sufficient for a law without a forecast, ``(n,)``."""
    return np.abs(forecast_free_limit(plant, wind).deflection)


def _bound(
    name: str,
    alone: Callable[[Plant, History], Any],
    vector: Callable[[VectorNeed], float],
    campaign: Campaign,
    batch: Batch,
) -> dict[str, Any]:
    """Return a lower bound of the deflection [rad] by column, by `alone` in each plane by itself.

    Where both planes are judged, of the first case only, and by `vector` in both planes together.
    """
    if not batch.parts:
        return {name: alone(batch.plant, batch.wind)}
    stop, shape = limit_shape_of(campaign.nozzle.stop or ""), (batch.count,)
    bounds = dict.fromkeys(PLANES, 0.0)
    for plane, in_plane in batch.parts.items():
        first = in_plane.first
        bounds[plane] = float(np.abs(alone(first.plant, first.wind)))
    largest = stop.support(np.array([1.0, 1j, -1.0, -1j])).reshape(2, 2).max(axis=0)
    both = max(x / limit for x, limit in zip(bounds.values(), largest.tolist(), strict=True))
    if len(batch.parts) > 1:
        pitch, yaw = (plant.case(0, shape) for plant in batch.plants.values())
        needs = vector_need(pitch, yaw, batch.vectors.case(0, shape), stop, np.ones(1))
        both = max(both, vector(needs))
    return {name: both} | {k: bounds[plane] for plane, k in in_planes(name).items()}


_MARGINS = {
    "margin_aero_dB": "dB",
    "margin_gain_dB": "dB",
    "margin_phase_deg": "deg",
    "margin_delay": "s",
}
"""Units of the margins of a loop by column."""


def _margin_columns(campaign: Campaign) -> dict[str, str]:
    """Return the units of the columns of margins by name."""
    peaks = {f"margin_{mode}_peak_dB": "dB" for mode in _mode_names(campaign)}
    return {"margin_stable": ""} | _MARGINS | peaks


def _mode_names(campaign: Campaign) -> list[str]:
    """Return the names of all modes of the nominal vehicle, in the order of their bands."""
    return [k for names in names_of_modes(campaign.vehicle.structure).values() for k in names]


def _margins(campaign: Campaign, batch: Batch) -> dict[str, Any]:
    """Return the margins of the autopilot around each vehicle, with the peaks of its modes."""
    autopilot, peaks = replace(campaign.autopilot, **batch.gains), {}
    if batch.flexible is not None and _mode_names(campaign):
        bands = autopilot.band_margins(batch.flexible)
        margins = bands.margins
        pairs = zip(_mode_names(campaign), bands.modes, strict=True)
        peaks = {f"margin_{name}_peak_dB": mode.peak_dB for name, mode in pairs}
    else:
        margins = loop_margins(autopilot.exact_loop(batch.flying))
    values = (margins.aero_margin_dB, margins.gain_increase_dB, margins.phase_margin_deg)
    columns = dict(zip(_MARGINS, (*values, margins.delay_margin), strict=True))
    return {"margin_stable": np.asarray(margins.stable, dtype=float)} | columns | peaks


def _flown(campaign: Campaign, batch: Batch) -> dict[str, float]:
    """Return boundary limits [rad] of a case by column, flown with six degrees of freedom."""
    vehicle, wind = batch.first.vehicle, batch.first.wind

    def flown(K: float) -> float:
        boundary = flown_boundary(
            vehicle, wind, K, engine="sixdof", plane=campaign.plane, tolerance=_BOUNDARY_TOLERANCE
        )
        return abs(boundary.deflection)

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
        partial(_bound, "forecast_free", _forecast_free, lambda need: need.no_forecast),
        lambda campaign: campaign.planes == BOTH,
    ),
    "minimum": Output(
        lambda campaign: _of_planes(campaign, {"minimum": "rad"}),
        partial(_bound, "minimum", minimum_peaks, lambda need: need.minimum),
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
"""Outputs of a campaign by name."""
