"""What is computed for each case: a registry of pure functions from a batch to columns."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tvclin.answers.campaign.plan import Campaign
from tvclin.answers.campaign.structures import first_plant
from tvclin.answers.flexible import with_filters
from tvclin.answers.requirement import required_deflection
from tvclin.answers.sizing.wind_sign import OWN, batch_factors
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import naming
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.optimum.least_peaks import least_peaks
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import CHAINS
from tvclin.control.laws.law import Law
from tvclin.control.laws.registry import AUTOPILOT, design_law
from tvclin.control.margins.record import loop_margins
from tvclin.flights.closed_loop.many import fly_many
from tvclin.flights.flown_boundary import flown_boundary
from tvclin.linear.flexible import AnyPlant, FlexiblePlant
from tvclin.linear.plant import Plant
from tvclin.vehicle.vehicle import NUMBERS, Vehicle
from tvclin.winds.histories import History

COLUMNS = {
    "flight_survived": "",
    "flight_peak_attitude": "rad",
    "flight_peak_angle_of_attack": "rad",
    "flight_peak_deflection": "rad",
}
"""Of the output "flight"."""
MOTIONS = ("flight_peak_attitude", "flight_peak_angle_of_attack")
"""Angles that are no deflections, with which a deflection limit is not compared."""
_FLOWN_TO = 5e-4
"""Boundaries are flown to this part of the largest trim deflection."""


@dataclass(frozen=True, eq=False)
class Batch:
    """Cases to be computed together.

    `plant`: a batch of shape ``(n,)``, or one plant for all. `wind`: a batch of shape ``(n,)``, or
    one wind for all. `gains`: gains of the autopilot, if one flies, ``(n,)`` where they are
    dispersed. `vehicle`: what the plant was made of. `flexible`: the same vehicles with their
    structure.
    """

    plant: Plant
    wind: History
    gains: dict[str, Any]
    count: int
    vehicle: Vehicle
    flexible: FlexiblePlant | None = None

    @property
    def flying(self) -> AnyPlant:
        """What flies, and what the autopilot controls."""
        return self.plant if self.flexible is None else self.flexible

    def one(self) -> tuple[Plant, History]:
        """Return the plant and the wind of the first case, no longer as a batch."""
        shape = (self.count,)
        return self.plant.one(0, shape), self.wind.one(0, shape)

    def one_flexible(self) -> FlexiblePlant | None:
        """Return the flexible plant of the first case; None where vehicles are rigid."""
        return None if self.flexible is None else first_plant(self.flexible, self.count)

    def one_vehicle(self) -> Vehicle:
        """Return the vehicle of the first case."""
        given = ((name, getattr(self.vehicle, name)) for name in NUMBERS)
        return self.vehicle.replace(
            **{name: float(np.ravel(v)[0]) for name, v in given if np.ndim(v)}
        )


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


def required_name(dead_band: float, kind: str = "required") -> str:
    """Return the name of the column of a dead band."""
    short = f"{dead_band:g}"
    return f"{kind}_K{short if float(short) == dead_band else repr(dead_band)}"


def _required(campaign: Campaign, batch: Batch) -> dict[str, FloatArray]:
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


def law_of(campaign: Campaign, batch: Batch) -> Law:
    """Return the law that flies the first case: the nominal one, or with gains of its own."""
    gains: dict[str, Any] = {name: float(np.ravel(value)[0]) for name, value in batch.gains.items()}
    own: dict[str, Any] = {AUTOPILOT: Autopilot(**gains)} if campaign.law == AUTOPILOT else {}
    own["rate_limit"] = campaign.hardware["rate_limit"]
    law = design_law(campaign.law, campaign.rigid_plant, campaign.wind.largest, **own)
    return with_filters(law, campaign.asked)


def _flight(campaign: Campaign, batch: Batch) -> dict[str, Any]:
    dispersed = any(np.ndim(value) for value in batch.gains.values())
    chains = {name: getattr(campaign.asked, name) for name in CHAINS}
    own = dispersed and campaign.law == AUTOPILOT
    assert campaign.nozzle.limit is not None
    found = fly_many(
        batch.flying,
        Autopilot(**batch.gains, **chains) if own else law_of(campaign, batch),
        batch.wind,
        deflection_limit=campaign.nozzle.limit,
        **campaign.hardware,
    )
    lost = (found.status == "lost") | (found.status == "rings")
    fate = np.select([found.status == "survived", lost], [1.0, 0.0], np.nan)
    return {"flight_survived": fate} | {
        f"flight_peak_{name}": np.where(fate == 0.0, np.inf, getattr(found, f"peak_{name}"))
        for name in ("attitude", "angle_of_attack", "deflection")
    }


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
        lambda campaign: {required_name(K): "rad" for K in campaign.dead_bands}, _required, _slow
    ),
    "forecast-free": Output(
        lambda _: {"forecast_free": "rad"},
        lambda _, one: {
            "forecast_free": np.abs(forecast_free_limit(one.plant, one.wind).deflection)
        },
    ),
    "minimum": Output(
        lambda _: {"minimum": "rad"},
        lambda _, one: {"minimum": least_peaks(one.plant, one.wind)},
        _slow,
    ),
    "margins": Output(_margin_columns, _margins),
    "flight": Output(lambda _: COLUMNS, _flight),
    "flown": Output(
        lambda campaign: {required_name(K, "flown"): "rad" for K in campaign.dead_bands},
        _flown,
        lambda _: True,
    ),
}
"""By the names that a campaign may ask for."""
