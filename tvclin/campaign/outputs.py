"""What is computed for each case: a registry of pure functions from a batch to columns."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.boundary import boundary_limit
from tvclin.campaign.forecast import forecast_free_deflections
from tvclin.campaign.plan import Campaign
from tvclin.coefficients import Coefficients
from tvclin.histories import History, Piecewise
from tvclin.kernels import pieces as kernel
from tvclin.optimum import optimum_deflection
from tvclin.plant import Plant

FloatArray = NDArray[np.float64]

_ONE_POLE = ("fixed-path", "drift")


@dataclass(frozen=True, eq=False)
class Batch:
    """Cases to be computed together.

    Attributes
    ----------
    plant : Plant
        A batch of shape ``(n,)``, or one plant for all.
    wind : History
        A batch of shape ``(n,)``, or one wind for all.
    count : int
        n.
    """

    plant: Plant
    wind: History
    count: int

    def each(self) -> list[tuple[Plant, History]]:
        """Return the plant and the wind of each case."""
        shape = (self.count,)
        fields = Coefficients.__dataclass_fields__
        held = {
            name: np.broadcast_to(getattr(self.plant.coefficients, name), shape) for name in fields
        }
        winds = kernel.spread(self.wind.pieces, shape)
        return [
            (
                Plant(Coefficients(**{k: float(v[i]) for k, v in held.items()}), self.plant.model),
                Piecewise(kernel.Pieces(winds.knots[i], winds.coefficients[i], winds.rates[i])),
            )
            for i in range(self.count)
        ]


def columns(campaign: Campaign) -> dict[str, str]:
    """Return the names of the outputs of a campaign and their units."""
    return {
        name: unit for output in campaign.outputs for name, unit in _NAMES[output](campaign).items()
    }


def compute(campaign: Campaign, batch: Batch) -> dict[str, FloatArray]:
    """Return every output of a batch, ``(n,)`` each.

    Raises
    ------
    InputError
        When one of the cases cannot be answered.
    """
    found: dict[str, FloatArray] = {}
    for output in campaign.outputs:
        found |= _WORK[output](campaign, batch)
    return {name: np.broadcast_to(values, (batch.count,)) for name, values in found.items()}


def boundary_name(dead_band: float) -> str:
    """Return the name of the column of a dead band."""
    return f"boundary_K{dead_band:g}"


def _boundary(campaign: Campaign, batch: Batch) -> dict[str, FloatArray]:
    return {
        boundary_name(K): np.abs(boundary_limit(batch.plant, batch.wind, K).deflection)
        for K in campaign.dead_bands
    }


def _forecast_free(campaign: Campaign, batch: Batch) -> dict[str, FloatArray]:
    del campaign
    return {"forecast_free": forecast_free_deflections(batch.plant, batch.wind)}


def _minimum(campaign: Campaign, batch: Batch) -> dict[str, FloatArray]:
    """With one unstable pole the deflection of least peak is the one held without a dead band."""
    if campaign.model in _ONE_POLE:
        return {"minimum": np.abs(boundary_limit(batch.plant, batch.wind, 0.0).deflection)}
    return {"minimum": np.array([optimum_deflection(*one).peak for one in batch.each()])}


_NAMES: dict[str, Callable[[Campaign], dict[str, str]]] = {
    "boundary": lambda campaign: {boundary_name(K): "rad" for K in campaign.dead_bands},
    "forecast-free": lambda _: {"forecast_free": "rad"},
    "minimum": lambda _: {"minimum": "rad"},
}
_WORK: dict[str, Callable[[Campaign, Batch], Any]] = {
    "boundary": _boundary,
    "forecast-free": _forecast_free,
    "minimum": _minimum,
}
