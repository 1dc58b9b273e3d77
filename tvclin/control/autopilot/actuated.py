"""A plant and the actuator that turns its engine, as one state space.

The inertia of an engine follows the acceleration of the deflection, and only an actuator of second
order has one: with its states (delta, delta'),

    delta'' = w^2 (command - delta) - 2 zeta w delta'.

The actuator is stiff: what it does to the deflection holds whatever the vehicle does.
"""

from __future__ import annotations

import numpy as np

from tvclin.base.errors import InputError
from tvclin.control.autopilot.actuator import Actuator
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.system import LinearSystem, connect, gain

INPUTS = ("deflection_command", "deflection_disturbance", "wind")
_STATES = ("actuator_deflection", "actuator_rate")
_DISTURBED = gain("deflection", {"deflection_disturbance": 1.0})
_AT_ONCE = gain("deflection", {"deflection_command": 1.0})


def actuated(plant: AnyPlant, actuator: Actuator | None) -> LinearSystem:
    """Return a plant with its actuator, from the command to the outputs.

    The inputs are `INPUTS`. A disturbance turns the thrust and not the engine, so that it has no
    inertia. The outputs are those of the plant, and the deflection with its disturbance.

    `plant`: one plant or a batch. `actuator`: one actuator or a batch, which broadcasts with the
    plant; None: the deflection follows its command at once. `InputError` for an engine with inertia
    and any but a second-order actuator.
    """
    check_engine(plant, actuator)
    blocks = [plant.system, turning(actuator), _DISTURBED]
    return connect(blocks, INPUTS, (*plant.outputs, "deflection"))


def turning(actuator: Actuator | None) -> LinearSystem:
    """Return an actuator from its command to deflection and, of second order, its acceleration."""
    if actuator is None:
        return _AT_ONCE
    A, B, C, D = actuator.matrices()
    order = A.shape[-1]
    C, D = (
        np.concatenate([of, as_it_turns[..., 1:, :]], -2) for of, as_it_turns in ((C, A), (D, B))
    )
    outputs = ("deflection", "deflection_acceleration")[:order]
    return LinearSystem(A, B, C, D, ("deflection_command",), outputs, _STATES[:order])


def check_engine(plant: AnyPlant, actuator: Actuator | None) -> None:
    """Raise `InputError` for an engine with inertia and any but a second-order actuator."""
    if "deflection_acceleration" in plant.inputs and (actuator is None or actuator.damping is None):
        raise InputError(
            "the inertia of an engine needs an actuator of second order, which says how fast the"
            " deflection speeds up; give the actuator a damping, or leave the engine out"
        )
