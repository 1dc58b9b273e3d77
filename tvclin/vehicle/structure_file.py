"""What a vehicle file says of the structure: [engine], [sensors], [[bending]], [[slosh]]."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from tvclin.base.errors import InputError, naming, number
from tvclin.base.tables import FileTable
from tvclin.base.units import UNITS
from tvclin.vehicle.filters import Filter
from tvclin.vehicle.structure import BendingMode, Engine, SloshTank, Structure

_SENSORS = ("attitude_sensor", "rate_gyro")
_DISPLACEMENTS = "tank_displacements"
_SLOPES = {f"tank_slopes_{unit}": factor for unit, factor in UNITS["per length"].items()}

STRUCTURE_TABLE = FileTable("[structure]", words=("thrust_follows",))
ENGINE_TABLE = FileTable(
    "[engine]",
    {"mass": "mass", "arm": "length", "moment_of_inertia": "inertia"},
    required=("mass", "arm"),
)
SENSORS_TABLE = FileTable(
    "[sensors]",
    {f"{name}_frequency": "natural frequency" for name in _SENSORS}
    | {f"{name}_damping": "number" for name in _SENSORS},
)
_BENDING = {
    "frequency": "natural frequency",
    "damping": "number",
    "modal_mass": "mass",
    "gimbal_displacement": "number",
    "gimbal_slope": "per length",
    "attitude_slope": "per length",
    "rate_slope": "per length",
}
BENDING_TABLE = FileTable(
    "[[bending]]",
    _BENDING | {"pressure_displacement": "number"},
    lists=(_DISPLACEMENTS, *_SLOPES),
    required=tuple(_BENDING),
)
SLOSH_TABLE = FileTable(
    "[[slosh]]",
    {
        "mass": "mass",
        "station": "length",
        "damping": "number",
        "pendulum_length": "length",
        "frequency": "natural frequency",
    },
    required=("mass", "station", "damping"),
)


def build_structure(document: Mapping[str, Any]) -> Structure:
    """Return the structure of a vehicle file's tables, all of which are optional."""
    engine = ENGINE_TABLE.one(document) if ENGINE_TABLE.name in document else None
    sensors = SENSORS_TABLE.read(SENSORS_TABLE.one(document))
    return Structure(
        bending=_every(BENDING_TABLE, document, _mode),
        slosh=_every(SLOSH_TABLE, document, SloshTank),
        engine=None if engine is None else Engine(**ENGINE_TABLE.read(engine)),
        attitude_sensor=_lag("attitude_sensor", sensors),
        rate_gyro=_lag("rate_gyro", sensors),
        **STRUCTURE_TABLE.read(STRUCTURE_TABLE.one(document)),
    )


def _every(
    table: FileTable, document: Mapping[str, Any], make: Callable[..., Any]
) -> tuple[Any, ...]:
    """What is made of each of several tables; messages say of which."""
    made = []
    for k, row in enumerate(table.each(document), start=1):
        with naming(f"{table.name} {k}"):
            made.append(make(**table.read(row)))
    return tuple(made)


def _mode(**found: Any) -> BendingMode:
    slopes = {key: found.pop(key) for key in _SLOPES if key in found}
    if len(slopes) > 1:
        raise InputError(f"tank_slopes is given twice, as {' and '.join(slopes)}; keep one")
    for key, values in slopes.items():
        found["tank_slopes"] = tuple(
            number(f"{key}[{k}]", value) * _SLOPES[key] for k, value in enumerate(values)
        )
    return BendingMode(**found)


def _lag(name: str, sensors: Mapping[str, float]) -> Filter | None:
    frequency, damping = sensors.get(f"{name}_frequency"), sensors.get(f"{name}_damping")
    if frequency is None:
        if damping is not None:
            SENSORS_TABLE.need(sensors, (f"{name}_frequency",))
        return None
    return Filter.low_pass(frequency, damping)
