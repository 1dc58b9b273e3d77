"""A plant and the actuator that turns its engine, as one state space.

The inertia of an engine follows the acceleration of the deflection, and only an actuator of second
order has one: with its states (delta, delta'),

    delta'' = w^2 (command - delta) - 2 zeta w delta'.

The actuator is stiff: what it does to the deflection holds whatever the vehicle does.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tvclin.base.errors import InputError, broadcast
from tvclin.control.autopilot.actuator import THROUGH, Actuator
from tvclin.linear.flexible import AnyPlant

FloatArray = NDArray[np.float64]

INPUTS = ("deflection_command", "deflection_disturbance", "wind")
_STATES = ("actuator_deflection", "actuator_rate")


class Actuated(NamedTuple):
    """A, B, C, D with leading batch axes, and the names of states and outputs.

    The inputs are `INPUTS`. A disturbance turns the thrust and not the engine, so that it has no
    inertia. The outputs are those of the plant, and the deflection with its disturbance.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    states: tuple[str, ...]
    outputs: tuple[str, ...]


def actuated(plant: AnyPlant, actuator: Actuator | None) -> Actuated:
    """Return a plant with its actuator, from the command to the outputs.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        One plant or a batch.
    actuator : Actuator or None
        One actuator or a batch, which broadcasts with the plant; None: the deflection follows its
        command at once.

    Raises
    ------
    InputError
        For an engine with inertia and any but a second-order actuator.
    """
    check_engine(plant, actuator)
    A, B, C, D = plant.matrices()
    swinging = B.shape[-1] - 2
    a, b, c, d = THROUGH if actuator is None else actuator.matrices()
    batch = broadcast(plant=A.shape[:-2], actuator=a.shape[:-2])
    n, k = A.shape[-1], a.shape[-1]
    # Each signal is a row of factors on the states and the inputs.
    signals = np.zeros((*batch, 1, 1)) + np.eye(n + k + len(INPUTS))
    x, bent, command, disturbance, wind = np.split(signals, np.cumsum([n, k, 1, 1]), axis=-2)
    turning = a @ bent + b @ command
    deflection = c @ bent + d @ command + disturbance
    forces = np.concatenate([deflection, wind, turning[..., k - swinging :, :]], axis=-2)
    motion = np.concatenate([A @ x + B @ forces, turning], axis=-2)
    seen = np.concatenate([C @ x + D @ forces, deflection], axis=-2)
    return Actuated(
        *(motion[..., : n + k], motion[..., n + k :], seen[..., : n + k], seen[..., n + k :]),
        (*plant.states, *_STATES[:k]),
        (*plant.outputs, "deflection"),
    )


def check_engine(plant: AnyPlant, actuator: Actuator | None) -> None:
    """Raise `InputError` for an engine with inertia and any but a second-order actuator."""
    if "deflection_acceleration" in plant.inputs and (actuator is None or actuator.damping is None):
        raise InputError(
            "the inertia of an engine needs an actuator of second order, which says how fast the"
            " deflection speeds up; give the actuator a damping, or leave the engine out"
        )
