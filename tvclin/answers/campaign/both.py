"""What dispersed cases ask of both planes, which share one stop."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from tvclin.answers.campaign.batch import Batch, in_planes, required_name
from tvclin.answers.campaign.plan import Campaign
from tvclin.answers.planes import VectorNeed, planes_needed, vector_need
from tvclin.answers.sizing.wind_sign import OWN, batch_factors
from tvclin.base.arrays import FloatArray
from tvclin.boundary.stops import stop_of
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import PLANES
from tvclin.winds.histories import History


def required_of_both(campaign: Campaign, batch: Batch, dead_band: float) -> dict[str, FloatArray]:
    """Return what both planes require, and each by itself, in the dynamic pressure of their wind.

    As a study has it: the larger factor of the planes counts for both.
    """
    stop = stop_of(campaign.nozzle.stop or "")
    found = planes_needed(batch.plants, batch.vectors, stop, dead_band)
    along = batch.parts["pitch"].wind if "pitch" in batch.parts else None
    factor: Any = 1.0
    for plane, one in batch.parts.items():
        given = (batch.vehicle.rigid, campaign.model, plane, one.wind, dead_band)
        factor = np.maximum(factor, batch_factors(*given, campaign.sign or OWN, along))
    name = required_name(dead_band)
    alone = {of: found.alone[plane] for plane, of in in_planes(name).items()}
    return {k: one * factor for k, one in ({name: found.deflection} | alone).items()}


def least_of_both(
    campaign: Campaign,
    batch: Batch,
    name: str,
    alone: Callable[[Plant, History], Any],
    vector: Callable[[VectorNeed], float],
) -> dict[str, float]:
    """Return what nothing undercuts in both planes, and in each by itself, of the first case."""
    stop, shape = stop_of(campaign.nozzle.stop or ""), (batch.count,)
    each = dict.fromkeys(PLANES, 0.0)
    each |= {plane: float(np.abs(alone(*one.one()))) for plane, one in batch.parts.items()}
    reach = stop.support(np.array([1.0, 1j, -1.0, -1j])).reshape(2, 2).max(axis=0)
    both = max(one / most for one, most in zip(each.values(), reach.tolist(), strict=True))
    if len(batch.parts) > 1:
        pitch, yaw = (one.one(0, shape) for one in batch.plants.values())
        needs = vector_need(pitch, yaw, batch.vectors.one(0, shape), stop, np.ones(1))
        both = max(both, vector(needs))
    return {name: both} | {of: each[plane] for plane, of in in_planes(name).items()}
