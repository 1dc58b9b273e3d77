"""Flexible vehicles in campaigns: what is dispersed in them, and how a manifest keeps them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.base.errors import InputError
from tvclin.control.autopilot.detuning import with_modes
from tvclin.control.autopilot.feedback import CHAINS
from tvclin.control.autopilot.rules import GainsAsked
from tvclin.linear.flexible import FlexiblePlant
from tvclin.vehicle.filters import Filter
from tvclin.vehicle.structure import BendingMode, Engine, SloshTank, Structure

FloatArray = NDArray[np.float64]

_LAGS = ("attitude_sensor", "rate_gyro")


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


def record_of(structure: Structure) -> dict[str, Any]:
    """Return a structure as numbers in SI units, of which `structure_of_record` makes it again."""
    lags = {name: getattr(structure, name) for name in _LAGS}
    return {
        "bending": [_numbers(mode) for mode in structure.bending],
        "slosh": [_numbers(tank) for tank in structure.slosh],
        "engine": None if structure.engine is None else _numbers(structure.engine),
        **{name: None if lag is None else _filter(lag) for name, lag in lags.items()},
        "thrust_follows": structure.thrust_follows,
    }


def structure_of_record(record: Mapping[str, Any]) -> Structure:
    """Return the structure of a record.

    Raises
    ------
    InputError
        For a record that holds something else.
    """
    try:
        engine, lags = record["engine"], {name: record[name] for name in _LAGS}
        return Structure(
            bending=tuple(BendingMode(**_made(one)) for one in record["bending"]),
            slosh=tuple(SloshTank(**_made(one)) for one in record["slosh"]),
            engine=None if engine is None else Engine(**engine),
            thrust_follows=record["thrust_follows"],
            **{name: None if one is None else _filter_of(one) for name, one in lags.items()},
        )
    except (KeyError, TypeError):
        raise InputError("the structure of a manifest must hold every number of it") from None


def gains_record(asked: GainsAsked) -> dict[str, Any]:
    """Return an autopilot as numbers in SI units, of which `gains_of_record` makes it again."""
    plain = {f.name: getattr(asked, f.name) for f in fields(asked) if f.name not in CHAINS}
    return plain | {name: [_filter(one) for one in getattr(asked, name)] for name in CHAINS}


def gains_of_record(record: Mapping[str, Any]) -> GainsAsked:
    """Return the autopilot of a record.

    Raises
    ------
    InputError
        For a record that holds something else.
    """
    try:
        chains = {name: tuple(_filter_of(one) for one in record[name]) for name in CHAINS}
        return GainsAsked(**{**record, **chains})
    except (KeyError, TypeError):
        raise InputError("the autopilot of a manifest must hold every number of it") from None


def _numbers(value: Any) -> dict[str, Any]:
    found = {f.name: getattr(value, f.name) for f in fields(value)}
    lists = {name: list(one) for name, one in found.items() if isinstance(one, tuple)}
    return {name: one for name, one in (found | lists).items() if one is not None}


def _made(record: Mapping[str, Any]) -> dict[str, Any]:
    return {name: tuple(one) if isinstance(one, list) else one for name, one in record.items()}


def _filter(one: Filter) -> dict[str, list[float]]:
    return {"numerator": one.numerator.tolist(), "denominator": one.denominator.tolist()}


def _filter_of(record: Mapping[str, Any]) -> Filter:
    return Filter.from_coefficients(record["numerator"], record["denominator"])
