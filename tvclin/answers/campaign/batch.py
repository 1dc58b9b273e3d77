"""Plants, winds and gains of the cases that are computed together, in a plane or in both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.linear.flexible import AnyPlant, FlexiblePlant
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import PLANES
from tvclin.vehicle.structure import select_cases
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind


@dataclass(frozen=True, eq=False)
class Batch:
    """Plants, winds and gains of `count` cases that are computed together.

    `plant`, `wind`: batches of shape ``(n,)``, or a single plant or wind for all cases. `gains`:
    gains of the autopilot where an output depends on them, ``(n,)`` where they are dispersed.
    `vehicle`: the vehicles that the plant linearises. `flexible`: flexible plants of the vehicles
    with their structure. `values`: dispersed values by name, ``(n,)``. `parts`: batches by plane,
    for each plane with a component of the wind, where both planes are judged.
    """

    plant: Plant
    wind: History
    gains: dict[str, Any]
    count: int
    vehicle: Vehicle
    flexible: FlexiblePlant | None = None
    values: Mapping[str, Any] = field(default_factory=dict)
    parts: Mapping[str, Batch] = field(default_factory=dict)

    @property
    def each(self) -> tuple[Batch, ...]:
        """The batches of all planes that are judged; this batch where only a single plane is."""
        return tuple(self.parts.values()) or (self,)

    @property
    def plants(self) -> dict[str, Plant]:
        """The plants by plane, for both planes."""
        model = self.plant.model
        return {name: Plant.from_vehicle(self.vehicle, model, name) for name in PLANES}

    @property
    def vectors(self) -> PlaneWind:
        """The winds of both planes; zero in a plane without a component of the wind."""
        winds = {plane: batch.wind for plane, batch in self.parts.items()}
        return PlaneWind(**(dict.fromkeys(PLANES, 0.0 * self.wind) | winds))

    @property
    def wind_angle(self) -> FloatArray:
        """Largest wind angle [rad], for both planes that of the vector, ``(n,)`` or a scalar."""
        return np.abs(np.asarray((self.vectors if self.parts else self.wind).peak))

    @property
    def flying(self) -> AnyPlant:
        """The plant that flies and that the autopilot controls: flexible with a structure."""
        return self.plant if self.flexible is None else self.flexible

    @cached_property
    def first(self) -> Batch:
        """The first case, with scalars in place of a batch axis."""
        shape = (self.count,)
        return Batch(
            self.plant.case(0, shape),
            self.wind.case(0, shape),
            {name: float(np.ravel(value)[0]) for name, value in self.gains.items()},
            1,
            select_cases(self.vehicle, 0, shape),
            None if self.flexible is None else self.flexible.cases(0, shape),
            {name: value[:1] for name, value in self.values.items()},
        )


def in_planes(name: str) -> dict[str, str]:
    """Return the names of a column by plane, for a column that both planes have together."""
    return {plane: f"{name}_{plane}" for plane in PLANES}


def required_name(dead_band: float, kind: str = "required") -> str:
    """Return the name of the column of a dead band K, as in "required_K1"."""
    short = f"{dead_band:g}"
    return f"{kind}_K{short if float(short) == dead_band else repr(dead_band)}"
