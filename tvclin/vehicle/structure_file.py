"""What a vehicle file says of the structure: [engine], [sensors], [[bending]], [[slosh]]."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from os import PathLike
from typing import Any

from tvclin.base.errors import InputError, naming, number
from tvclin.base.files import called, tables_of
from tvclin.base.tables import Table
from tvclin.base.units import UNITS
from tvclin.vehicle.file import VEHICLE_TABLE, table_of, vehicle_text
from tvclin.vehicle.filters import Filter
from tvclin.vehicle.structure import BendingMode, Engine, SloshTank, Structure

_SENSORS = ("attitude_sensor", "rate_gyro")
_DISPLACEMENTS = "tank_displacements"
_SLOPES = {f"tank_slopes_{unit}": factor for unit, factor in UNITS["per length"].items()}

STRUCTURE_TABLE = Table("[structure]", words=("thrust_follows",))
ENGINE_TABLE = Table(
    "[engine]",
    {"mass": "mass", "arm": "length", "moment_of_inertia": "inertia"},
    required=("mass", "arm"),
)
SENSORS_TABLE = Table(
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
BENDING_TABLE = Table(
    "[[bending]]",
    _BENDING | {"pressure_displacement": "number"},
    lists=(_DISPLACEMENTS, *_SLOPES),
    required=tuple(_BENDING),
)
SLOSH_TABLE = Table(
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


def load_structure(source: str | PathLike[str]) -> Structure:
    """Return bending, slosh, engine and sensors, by the name of a vehicle or from its file.

    It stands in the file beside [vehicle], under headings of its own: [structure], [engine],
    [sensors], and one [[bending]] and [[slosh]] for each mode and tank. All are optional; a file
    with none of them is that of a rigid vehicle.

    Parameters
    ----------
    source : str or path
        As of `load_vehicle`.

    Raises
    ------
    InputError
        As `load_vehicle`, and as the values that are made of the tables.

    Examples
    --------
    >>> import tvclin as tv
    >>> structure = tv.load_structure("made-up-booster")
    >>> [mode.frequency for mode in structure.bending], len(structure.slosh)
    ([13.58, 30.18, 61.18], 2)
    """
    text, place = vehicle_text(source)
    table_of(text, place, VEHICLE_TABLE)  # a vehicle file, with no heading that is unknown
    return parse_structure(text, place) or Structure()


def parse_structure(text: str, place: str) -> Structure | None:
    """Return the structure of a vehicle file's text, and None where it has none.

    Raises
    ------
    InputError
        As `load_structure`, but for the file.
    """
    with naming(called(place)):
        found = build_structure(tables_of(text, place))
    return None if found.is_rigid else found


def build_structure(document: Mapping[str, Any]) -> Structure:
    """Return the structure of a document's tables.

    Raises
    ------
    InputError
        As `load_structure`, but for the file.
    """
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


def _every(table: Table, document: Mapping[str, Any], make: Callable[..., Any]) -> tuple[Any, ...]:
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
