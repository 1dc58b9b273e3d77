"""What comes of flying the law of a campaign with its nozzle, in one plane or in both."""

from __future__ import annotations

from typing import Any

import numpy as np

from tvclin.answers.campaign.batch import Batch, in_planes
from tvclin.answers.campaign.plan import Campaign
from tvclin.answers.flexible import with_filters
from tvclin.answers.planes import rectangle
from tvclin.base.arrays import FloatArray
from tvclin.boundary.stops import stop_of
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import CHAINS
from tvclin.control.laws.law import Law
from tvclin.control.laws.registry import AUTOPILOT, design_law
from tvclin.flights.closed_loop.fly_many import fly_many
from tvclin.vehicle.coefficients import PLANES

COLUMNS = {
    "flight_survived": "",
    "flight_peak_attitude": "rad",
    "flight_peak_angle_of_attack": "rad",
    "flight_peak_deflection": "rad",
}
"""Of the output "flight"."""
_MOTIONS = ("flight_peak_attitude", "flight_peak_angle_of_attack")
MOTIONS = (*_MOTIONS, *(one for name in _MOTIONS for one in in_planes(name).values()))
"""Angles that are no deflections, with which a deflection limit is not compared."""


def law_of(campaign: Campaign, batch: Batch) -> Law:
    """Return the law that flies the first case: the nominal one, or with gains of its own."""
    own: dict[str, Any] = {}
    if campaign.law == AUTOPILOT:
        own[AUTOPILOT] = Autopilot(**batch.first.gains)
    own["rate_limit"] = campaign.hardware["rate_limit"]
    law = design_law(campaign.law, campaign.rigid_plant, campaign.wind.max_angle, **own)
    return with_filters(law, campaign.asked)


def flights(campaign: Campaign, batch: Batch) -> dict[str, Any]:
    """Return `COLUMNS` of the flights of a batch; of both planes with those of each beside them."""
    limit = campaign.nozzle.limit
    assert limit is not None
    if not batch.parts:
        return _flown(campaign, batch, limit)
    shares = shares_of(campaign, batch)
    each = {
        plane: _flown(part, batch.parts[plane], limit * shares[plane])
        for plane, part in campaign.parts.items()
    }
    calm = {name: np.zeros(batch.count) for name in COLUMNS} | {"flight_survived": np.ones(1)}
    pitch, yaw = (each.get(plane, calm) for plane in PLANES)
    lost = (pitch["flight_survived"] == 0.0) | (yaw["flight_survived"] == 0.0)
    both = {name: np.hypot(pitch[name], yaw[name]) for name in _MOTIONS}
    both["flight_peak_deflection"] = rectangle(
        stop_of(campaign.nozzle.stop or ""),
        *(one["flight_peak_deflection"] for one in (pitch, yaw)),
    )
    found = {"flight_survived": pitch["flight_survived"] + yaw["flight_survived"] - 1.0} | both
    found = {name: np.where(lost, np.inf, one) for name, one in found.items()}
    found["flight_survived"] = np.where(lost, 0.0, found["flight_survived"])
    for name in COLUMNS:
        of = in_planes(name)
        found |= {of["pitch"]: pitch[name], of["yaw"]: yaw[name]}
    return found


def shares_of(campaign: Campaign, batch: Batch) -> dict[str, FloatArray]:
    """Return the part of the limit that each plane has: of a rectangle inside, as its winds are."""
    peaks = {plane: np.abs(one.wind.peak) for plane, one in batch.parts.items()}
    stop = stop_of(campaign.nozzle.stop or "")
    whole = rectangle(stop, *(peaks.get(plane, 0.0) for plane in PLANES))
    return {plane: one / whole for plane, one in peaks.items()}


def _flown(campaign: Campaign, batch: Batch, limit: FloatArray | float) -> dict[str, Any]:
    dispersed = any(np.ndim(value) for value in batch.gains.values())
    chains = {name: getattr(campaign.asked, name) for name in CHAINS}
    own = dispersed and campaign.law == AUTOPILOT
    found = fly_many(
        batch.flying,
        Autopilot(**batch.gains, **chains) if own else law_of(campaign, batch),
        batch.wind,
        deflection_limit=limit,
        **campaign.hardware,
    )
    lost = (found.status == "lost") | (found.status == "rings")
    fate = np.select([found.status == "survived", lost], [1.0, 0.0], np.nan)
    return {"flight_survived": fate} | {
        f"flight_peak_{name}": np.where(fate == 0.0, np.inf, getattr(found, f"peak_{name}"))
        for name in ("attitude", "angle_of_attack", "deflection")
    }
