"""Limits of a nozzle in angle, rate and work, its actuator, its inertia and its hinge."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from tvclin.base import errors
from tvclin.base.fields import checked, file_table, quantity
from tvclin.boundary.limit_shapes import LimitShape, limit_shape_of
from tvclin.control.autopilot.actuator import Actuator, positive_in_range
from tvclin.vehicle.structure import Engine

_ACTUATOR = {"actuator_frequency": "natural frequency", "actuator_damping": "number"}
"""Keys of the actuator in a file, and their kinds."""
_ENGINE = {"mass": "mass", "arm": "arm", "inertia": "moment_of_inertia"}
"""Keys of the engine in a file, and their names in `Engine`."""
USUAL_ACTUATOR = Actuator()
"""The assumed actuator; a specified actuator is another object, even if it is equal."""


@dataclass(frozen=True, kw_only=True)
class NozzleData:
    """Inertia, hinge and friction that resist the actuators of a nozzle.

    Attributes
    ----------
    engine : Engine
        The engine that turns: mass m_E, arm l_E aft of the hinge, moment of inertia.
    stiffness : float
        Stiffness k of the hinge [N m/rad].
    damping : float
        Viscous damping c of the hinge [N m s/rad].
    friction : float
        Friction moment M_f [N m], independent of the rate.
    offset : float
        Lateral offset e of the centre of mass from the hinge [m]; a positive one resists a positive
        deflection.
    thrust_offset : float
        Lateral offset e_T of the line of thrust from the hinge [m], with the same sign.

    Raises
    ------
    InputError
        For a batch, and a negative stiffness, damping or friction.
    """

    engine: Engine
    stiffness: float = quantity("moment slope", 0.0, errors.nonnegative)
    damping: float = quantity("damping moment", 0.0, errors.nonnegative)
    friction: float = quantity("moment", 0.0, errors.nonnegative)
    offset: float = quantity("length", 0.0)
    thrust_offset: float = quantity("length", 0.0)

    def __post_init__(self) -> None:
        """Raise `InputError` for a batch, and a negative stiffness, damping or friction."""
        errors.instance("engine", self.engine, Engine, "Engine(mass=..., arm=...)")
        errors.single("engine", self.engine.batch)
        checked(self)


@dataclass(frozen=True, kw_only=True)
class Nozzle:
    """Limits of a nozzle in angle, rate and work, with its actuator.

    Attributes
    ----------
    limit : float, optional
        Deflection limit [rad], which is judged.
    limit_shape : LimitShape or str, optional
        Limit shape of both planes, normalised by the limit, or its name: "round",
        "round-each-plane" (within it each plane is limited separately), "square", "square-45"
        (turned by 45 degrees). With it both planes are judged, which share the limit.
    rate_limit : float, optional
        Limit of the deflection rate [rad/s]; flights keep to it, and the laws trim and
        recoverable-attitude are designed for it.
    actuator : Actuator or None
        Dynamics between command and deflection.
    data : NozzleData, optional
        Inertia, hinge and friction, for torque and power.
    acceleration_limit : float, optional
        Largest deflection acceleration [rad/s2]; it is judged, and limits no flight.
    travel_limit : float, optional
        Angle that the nozzle may turn in a flight, there and back [rad]; it is judged.
    torque_limit : float, optional
        Largest torque of the actuators [N m]; a file gives the data of the hinge with it.
    power_limit : float, optional
        Largest power of the actuators [W]; a file gives the data of the hinge with it.

    Raises
    ------
    InputError
        For numbers out of range, an unknown limit shape, another type than an actuator, and a
        torque or power limit without data.
    """

    limit: float | None = quantity(
        "angle", None, errors.small_angle("a deflection", errors.positive)
    )
    limit_shape: LimitShape | str | None = None
    rate_limit: float | None = quantity("angular rate", None, errors.positive)
    actuator: Actuator | None = USUAL_ACTUATOR
    data: NozzleData | None = None
    acceleration_limit: float | None = quantity(
        "angular acceleration", None, errors.positive, label="acceleration"
    )
    travel_limit: float | None = quantity(
        "angle", None, errors.positive, label="travel of a flight"
    )
    torque_limit: float | None = quantity("moment", None, errors.positive, label="torque")
    power_limit: float | None = quantity("power", None, errors.positive, label="power")

    def __post_init__(self) -> None:
        """Raise `InputError` for numbers out of range, wrong types, and limits without data."""
        checked(self)
        if self.limit_shape is not None:
            limit_shape_of(self.limit_shape, "limit_shape")
        if self.actuator is not None:
            errors.instance("actuator", self.actuator, Actuator, "or None")
        if self.data is not None:
            errors.instance("data", self.data, NozzleData, "of an engine and its hinge")
        elif self.torque_limit is not None or self.power_limit is not None:
            raise errors.InputError(
                "torque_limit and power_limit need the engine: mass_kg and arm_m in [nozzle]"
            )

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> Self:
        """Return the nozzle of the table [nozzle] of a file; an actuator of 0 rad/s is none.

        `InputError` for unknown keys of the table, data of the hinge without mass and arm of the
        engine, and numbers out of range.
        """
        values = NOZZLE_TABLE.read(table)
        servo = {name: values.pop(name) for name in _ACTUATOR if name in values}
        actuator = actuator_of(**servo) if servo else USUAL_ACTUATOR
        hinge = {name: values.pop(name) for name in _HINGE if name in values}
        engine = {field: values.pop(name) for name, field in _ENGINE.items() if name in values}
        data = None
        if engine or hinge:
            NOZZLE_TABLE.need(engine, ("mass", "arm"))
            data = NozzleData(engine=Engine(**engine), **hinge)
        return cls(data=data, actuator=actuator, **values)


_HINGE = file_table("[nozzle]", NozzleData).quantities
NOZZLE_TABLE = file_table(
    "[nozzle]",
    Nozzle,
    quantities={**_ACTUATOR, "mass": "mass", "arm": "length", "inertia": "inertia", **_HINGE},
    words=("limit_shape",),
)


def actuator_of(actuator_frequency: float = 25.1, actuator_damping: float = 0.7) -> Actuator | None:
    """Return an actuator of a natural frequency [rad/s] and a damping ratio; None for zero."""
    if errors.number("actuator_frequency", actuator_frequency) == 0.0:
        return None
    return Actuator(
        natural_frequency=positive_in_range("actuator_frequency", actuator_frequency, "rad/s"),
        damping=positive_in_range("actuator_damping", actuator_damping),
    )
