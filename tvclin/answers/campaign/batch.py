"""Cases that are computed together: their plants and winds, in one plane or in both."""

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
    """Cases to be computed together.

    `plant`: a batch of shape ``(n,)``, or one plant for all. `wind`: a batch of shape ``(n,)``, or
    one wind for all. `gains`: gains of the autopilot, if one flies, ``(n,)`` where they are
    dispersed. `vehicle`: what the plant was made of. `flexible`: the same vehicles with their
    structure. `values`: dispersed values by name, ``(n,)``. `parts`:
    the same in each plane in which the wind blows, where both are judged.
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
        """Those of all planes that are judged."""
        return tuple(self.parts.values()) or (self,)

    @property
    def plants(self) -> dict[str, Plant]:
        """The plants of both planes."""
        model = self.plant.model
        return {name: Plant.from_vehicle(self.vehicle, model, name) for name in PLANES}

    @property
    def vectors(self) -> PlaneWind:
        """The winds of both planes; of one in which nothing blows zero."""
        winds = {name: one.wind for name, one in self.parts.items()}
        return PlaneWind(**(dict.fromkeys(PLANES, 0.0 * self.wind) | winds))

    @property
    def wind_angle(self) -> FloatArray:
        """Largest wind angle [rad], of both planes that of the vector, ``(n,)`` or one for all."""
        return np.abs(np.asarray((self.vectors if self.parts else self.wind).peak))

    @property
    def flying(self) -> AnyPlant:
        """What flies, and what the autopilot controls."""
        return self.plant if self.flexible is None else self.flexible

    @cached_property
    def first(self) -> Batch:
        """The first case, no longer as a batch."""
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
    """Return the names of a column of both planes in each."""
    return {plane: f"{name}_{plane}" for plane in PLANES}


def required_name(dead_band: float, kind: str = "required") -> str:
    """Return the name of the column of a dead band."""
    short = f"{dead_band:g}"
    return f"{kind}_K{short if float(short) == dead_band else repr(dead_band)}"
