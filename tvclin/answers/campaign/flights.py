"""Survival and peaks of flights of the law of a campaign, in a plane or in both."""

from __future__ import annotations

from typing import Any

import numpy as np

from tvclin.answers.campaign.batch import Batch, in_planes
from tvclin.answers.campaign.plan import Campaign
from tvclin.answers.flexible import with_filters
from tvclin.answers.planes import rectangle
from tvclin.base.arrays import FloatArray
from tvclin.boundary.limit_shapes import limit_shape_of
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
"""Units of the columns of the output "flight", by name."""
_MOTIONS = ("flight_peak_attitude", "flight_peak_angle_of_attack")
"""Columns of the motion of the vehicle."""
MOTIONS = (*_MOTIONS, *(column for name in _MOTIONS for column in in_planes(name).values()))
"""Columns of the motion, in a plane and in both: angles, but no deflections."""


def law_of(campaign: Campaign, batch: Batch) -> Law:
    """Return the law that flies the first case: with its gains where they are dispersed."""
    options: dict[str, Any] = {}
    if campaign.law == AUTOPILOT:
        options[AUTOPILOT] = Autopilot(**batch.first.gains)
    options["rate_limit"] = campaign.hardware["rate_limit"]
    law = design_law(campaign.law, campaign.rigid_plant, campaign.wind.max_angle, **options)
    return with_filters(law, campaign.asked)


def flights(campaign: Campaign, batch: Batch) -> dict[str, Any]:
    """Return `COLUMNS` of the flights of a batch, ``(n,)`` each; of both planes, and by plane."""
    limit = campaign.nozzle.limit
    assert limit is not None
    if not batch.parts:
        return _flown(campaign, batch, limit)
    shares = shares_of(campaign, batch)
    flown = {
        plane: _flown(in_plane, batch.parts[plane], limit * shares[plane])
        for plane, in_plane in campaign.parts.items()
    }
    calm = {name: np.zeros(batch.count) for name in COLUMNS} | {"flight_survived": np.ones(1)}
    pitch, yaw = (flown.get(plane, calm) for plane in PLANES)
    lost = (pitch["flight_survived"] == 0.0) | (yaw["flight_survived"] == 0.0)
    both = {name: np.hypot(pitch[name], yaw[name]) for name in _MOTIONS}
    both["flight_peak_deflection"] = rectangle(
        limit_shape_of(campaign.nozzle.stop or ""),
        pitch["flight_peak_deflection"],
        yaw["flight_peak_deflection"],
    )
    columns = {name: np.where(lost, np.inf, peak) for name, peak in both.items()}
    survived = pitch["flight_survived"] + yaw["flight_survived"] - 1.0
    columns["flight_survived"] = np.where(lost, 0.0, survived)
    for name in COLUMNS:
        by_plane = in_planes(name)
        columns |= {by_plane["pitch"]: pitch[name], by_plane["yaw"]: yaw[name]}
    return columns


def shares_of(campaign: Campaign, batch: Batch) -> dict[str, FloatArray]:
    """Return the fractions of the limit by plane, ``(n,)``, in the ratio of the peak winds."""
    peaks = {plane: np.abs(in_plane.wind.peak) for plane, in_plane in batch.parts.items()}
    stop = limit_shape_of(campaign.nozzle.stop or "")
    total = rectangle(stop, *(peaks.get(plane, 0.0) for plane in PLANES))
    return {plane: peak / total for plane, peak in peaks.items()}


def _flown(campaign: Campaign, batch: Batch, limit: FloatArray | float) -> dict[str, Any]:
    """Return `COLUMNS` of the flights of a batch in a plane with a deflection limit [rad]."""
    dispersed = any(np.ndim(value) for value in batch.gains.values())
    chains = {name: getattr(campaign.asked, name) for name in CHAINS}
    gains_vary = dispersed and campaign.law == AUTOPILOT
    flown = fly_many(
        batch.flying,
        Autopilot(**batch.gains, **chains) if gains_vary else law_of(campaign, batch),
        batch.wind,
        deflection_limit=limit,
        **campaign.hardware,
    )
    lost = (flown.status == "lost") | (flown.status == "rings")
    fate = np.select([flown.status == "survived", lost], [1.0, 0.0], np.nan)
    return {"flight_survived": fate} | {
        f"flight_peak_{name}": np.where(fate == 0.0, np.inf, getattr(flown, f"peak_{name}"))
        for name in ("attitude", "angle_of_attack", "deflection")
    }
