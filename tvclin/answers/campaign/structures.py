"""Flexible vehicles in campaigns: what is dispersed in them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.control.autopilot.detuning import with_modes
from tvclin.linear.flexible import FlexiblePlant
from tvclin.vehicle.filters import Filter
from tvclin.vehicle.structure import Structure


def modes_nominal(structure: Structure) -> dict[str, float]:
    """Return what can be dispersed in a structure: factors on the numbers of its modes, one.

    "bending_frequency" is a factor on all bending modes, "bending_2_frequency" on the second one.
    """
    counts = {"bending": len(structure.bending), "slosh": len(structure.slosh)}
    bodies = [kind for kind, count in counts.items() if count]
    bodies += [f"{kind}_{k}" for kind, count in counts.items() for k in range(1, count + 1)]
    return {f"{body}_{number}": 1.0 for body in bodies for number in ("frequency", "damping")}


def dispersed_modes(plant: FlexiblePlant, values: Mapping[str, Any]) -> FlexiblePlant:
    """Return a plant with the drawn factors on the frequencies and dampings of its modes."""
    names = modes_nominal(plant.structure)
    factors = {name: np.asarray(values[name], dtype=float) for name in names if name in values}
    if not factors:
        return plant
    counts = {"bending": len(plant.structure.bending), "slosh": len(plant.structure.slosh)}
    shape = next(iter(factors.values())).shape

    def of(number: str) -> FloatArray:
        columns = []
        for kind, count in counts.items():
            every = factors.get(f"{kind}_{number}", np.ones(shape))
            names = (f"{kind}_{k}_{number}" for k in range(1, count + 1))
            columns += [every * factors.get(name, 1.0) for name in names]
        return np.stack(columns, axis=-1)

    return with_modes(plant, of("frequency"), of("damping"))


def first_plant(plant: FlexiblePlant, count: int) -> FlexiblePlant:
    """Return the first of so many plants, no longer as a batch."""
    few = plant.some(np.array([0]), (count,))
    return replace(few, vehicle=_single(few.vehicle), structure=_single(few.structure))


def _single(value: Any) -> Any:
    """A value whose batches of one are none."""
    if isinstance(value, Filter):
        return Filter(*(np.ravel(one) for one in (value.numerator, value.denominator)))
    if isinstance(value, tuple):
        return tuple(_single(one) for one in value)
    if is_dataclass(value):
        kind: Any = type(value)
        return kind(**{f.name: _single(getattr(value, f.name)) for f in fields(value)})
    return float(value[0]) if isinstance(value, np.ndarray) else value
