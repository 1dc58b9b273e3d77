"""Flexible vehicles in campaigns: what is dispersed in them, and how a manifest keeps them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar

import numpy as np

from tvclin.answers.nozzle import Nozzle
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.detuning import with_modes
from tvclin.control.autopilot.feedback import CHAINS
from tvclin.control.autopilot.rules import AutopilotDesign
from tvclin.kernels.pieces import Pieces
from tvclin.linear.flexible import FlexiblePlant
from tvclin.vehicle.filters import Filter
from tvclin.vehicle.structure import BendingMode, Engine, SloshTank, Structure
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import Piecewise
from tvclin.winds.shaped import ShapedWind, WindEnsemble

Recorded = TypeVar("Recorded", Vehicle, Nozzle, AutopilotDesign)
_BODIES = {"bending": BendingMode, "slosh": SloshTank, "engine": Engine}
_PARTS = {"structure": Structure, "actuator": Actuator, **_BODIES} | dict.fromkeys(
    ("attitude_sensor", "rate_gyro", *CHAINS), Filter
)
"""What the parts of a vehicle, a nozzle and an autopilot are, by name; all else are numbers."""


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


def record_of(value: Any) -> Any:
    """Return a vehicle or an autopilot as numbers in SI units, of which `of_record` makes it."""
    if is_dataclass(value):
        return {f.name: record_of(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, tuple):
        return [record_of(one) for one in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


def of_record(kind: type[Recorded], record: Any) -> Recorded:
    """Return the vehicle or the autopilot of a record.

    `InputError` for a record that holds something else.
    """
    try:
        made = _made(kind, record)
    except TypeError:
        made = None
    if not isinstance(made, kind):
        raise InputError(f"a manifest must hold every number of a {kind.__name__}")
    return made


def _made(kind: Any, record: Any) -> Any:
    if isinstance(record, list):
        return tuple(_made(kind, one) for one in record)
    if isinstance(record, dict):
        return kind(**{name: _made(_PARTS.get(name), one) for name, one in record.items()})
    return record


def gust_record(wind: ShapedWind | WindEnsemble) -> dict[str, Any]:
    """Return the gust of a wind as a manifest keeps it: its exact pieces; nothing without one."""
    if isinstance(wind, WindEnsemble) or wind.gust is None:
        return {}
    pieces = wind.gust.pieces
    parts = {"coefficients": pieces.coefficients, "rates": pieces.rates}
    kept = {name: [np.real(one).tolist(), np.imag(one).tolist()] for name, one in parts.items()}
    placed = {} if wind.gust_at is None else {"gust_at": wind.gust_at}
    return {"gust": {"knots": pieces.knots.tolist(), **kept, **placed}}


def recorded_gust(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the gust that a manifest keeps, as `gust_of`; empty of any other document."""
    kept = document.get("gust", {})
    if "knots" not in kept:
        return {}
    parts = (np.array(kept[name]) for name in ("coefficients", "rates"))
    coefficients, rates = (real + 1j * imag if imag.any() else real for real, imag in parts)
    gust = Piecewise(Pieces(np.array(kept["knots"]), coefficients, rates))
    return {"gust": gust, "gust_at": kept.get("gust_at")}
