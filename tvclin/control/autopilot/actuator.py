"""The actuator between a deflection command and the deflection, and the plant behind it.

With the natural frequency w and the damping ratio zeta a second-order actuator has the states delta
and delta', and

    delta'' = w^2 (command - delta) - 2 zeta w delta'.

The inertia of an engine follows this acceleration; a first-order actuator, delta' = w (command -
delta), has none to give. The actuator is stiff: the motion of the vehicle does not move the nozzle.
Rate and deflection limits belong to the flight, not to the actuator.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Record
from tvclin.base.errors import InputError, finite, plain, positive, together, within
from tvclin.base.fields import spec
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.lateral import NO_LATERAL_SENSORS, LateralSensors
from tvclin.linear.system import LinearSystem, connect, gain
from tvclin.numerics.state_space import Matrices

if TYPE_CHECKING:
    import control


MAX_MAGNITUDE = 1e9
"""Largest gain, frequency, damping ratio or time in SI units; its reciprocal is the smallest. The
polynomials of a loop multiply several of them: beyond, they overflow or vanish."""
MIN_GAIN = 1e-30
"""Smallest magnitude of a gain other than zero; smaller ones are mistakes."""


def positive_in_range(name: str, value: ArrayLike, unit: str = "") -> FloatArray:
    """Return `value` as an array; `InputError` unless it is within 1e-9 to 1e9.

    `name`, `unit`: name and unit of the quantity in the message.
    """
    return within(name, positive(name, value, unit), 1.0 / MAX_MAGNITUDE, MAX_MAGNITUDE, unit)


def zero_or_in_range(name: str, value: ArrayLike, minimum: float, unit: str = "") -> FloatArray:
    """Return `value` as an array; `InputError` unless its magnitude is 0 or `minimum` to 1e9.

    `name`, `unit`: name and unit of the quantity in the message.
    """
    array = finite(name, value, unit)
    size = np.abs(array)
    outside = (size > MAX_MAGNITUDE) | ((size > 0.0) & (size < minimum))
    if np.any(outside):
        raise InputError(
            f"{name} must be zero or {minimum:.6g} to {MAX_MAGNITUDE:.6g}{unit and ' ' + unit} in"
            f" size; got {array[outside].flat[0]:.6g}"
        )
    return array


@dataclass(frozen=True, kw_only=True)
class Actuator(Record):
    """The dynamics of an actuator, of unit steady gain; its limits are not part of it.

    Parameters
    ----------
    natural_frequency : array_like
        Natural frequency [rad/s], positive; of a first-order actuator its bandwidth.
    damping : array_like or None
        Damping ratio, positive; None makes the actuator first order.

    Raises
    ------
    InputError
        For numbers that are not positive or are beyond 1e-9 to 1e9, and shapes that do not
        broadcast.
    """

    natural_frequency: float | FloatArray = field(
        default=25.1, metadata=spec("natural frequency", key="natural_frequency_rad_s")
    )
    damping: float | FloatArray | None = field(default=0.7, metadata=spec())

    def __post_init__(self) -> None:
        """Check natural frequency and damping, and that their shapes broadcast."""
        frequency = positive_in_range("natural_frequency", self.natural_frequency, "rad/s")
        object.__setattr__(self, "natural_frequency", plain(frequency))
        if self.damping is not None:
            damping = positive_in_range("damping", self.damping)
            together(natural_frequency=frequency, damping=damping)
            object.__setattr__(self, "damping", plain(damping))

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for one actuator."""
        return self.denominator.shape[:-1]

    @property
    def denominator(self) -> FloatArray:
        """Characteristic polynomial ``(..., order + 1)``, highest power first.

        It is s + w or s^2 + 2 zeta w s + w^2, with the natural frequency w [rad/s] and the damping
        ratio zeta. The last coefficient is the numerator of the transfer function.
        """
        w = np.asarray(self.natural_frequency)
        if self.damping is None:
            return np.stack([np.ones_like(w), w], axis=-1)
        columns = np.broadcast_arrays(1.0, 2.0 * np.asarray(self.damping) * w, w**2)
        return np.stack(columns, axis=-1)

    def tf(self) -> control.TransferFunction:
        """Return the actuator as `control.TransferFunction`, deflection per command.

        `InputError` for a batch.
        """
        import control

        if self.batch:
            raise InputError(f"tf() is for one actuator; got a batch of shape {self.batch}")
        return control.TransferFunction(
            self.denominator[-1:],
            self.denominator,
            dt=0,  # continuous
            name="actuator",
            inputs=["deflection_command"],
            outputs=["deflection"],
        )

    def matrices(self) -> Matrices:
        """Return A ``(..., n, n)``, B ``(..., n, 1)``, C ``(..., 1, n)``, D of order n.

        The input is the command [rad]; the states are the deflection [rad] and, of second order,
        its rate [rad/s]; the output is the deflection. With the `denominator` s^2 + 2 zeta w s +
        w^2 or s + w the last row of A has its coefficients, negative and lowest first, and B has
        the last of them, w^2 or w: natural frequency w [rad/s], damping ratio zeta.
        """
        order = self.denominator.shape[-1] - 1
        A = np.zeros((*self.batch, order, order)) + np.eye(order, k=1)
        B = np.zeros((*self.batch, order, 1))
        C, D = np.zeros((*self.batch, 1, order)) + np.eye(1, order), np.zeros((*self.batch, 1, 1))
        A[..., -1, :] = -self.denominator[..., :0:-1]
        B[..., -1, 0] = self.denominator[..., -1]
        return A, B, C, D


INPUTS = ("deflection_command", "deflection_disturbance", "wind")


def plant_with_actuator(
    plant: AnyPlant, actuator: Actuator | None, sensors: LateralSensors = NO_LATERAL_SENSORS
) -> LinearSystem:
    """Return the state space of a plant behind its actuator.

    Inputs: `INPUTS`, the deflection command, a disturbance of the deflection and the wind [rad].
    The disturbance turns the thrust without the mass of the engine: it has no inertia. Outputs: the
    plant's, the lateral sensors', and the deflection, disturbance included.

    `plant`: one plant or a batch. `actuator`: one actuator or a batch, which broadcasts with the
    plant; None: the deflection equals its command. `sensors`: sensors of drift and acceleration.
    `InputError` for an engine with inertia whose actuator is not of second order.
    """
    blocks = plant_blocks(plant, actuator, sensors)
    return connect(blocks, INPUTS, (*blocks[0].outputs, "deflection"))


def plant_blocks(
    plant: AnyPlant, actuator: Actuator | None, sensors: LateralSensors
) -> list[LinearSystem]:
    """Return three blocks, to be connected by signal name: plant, actuator, and their sum point.

    The first has the outputs of `plant` and of the lateral `sensors` of drift and acceleration. The
    second turns the command into the deflection; with `actuator` None they are equal. The third
    adds the disturbance to the deflection. `InputError` for an engine with inertia whose actuator
    is not of second order.
    """
    check_engine(plant, actuator)
    disturbance = gain("deflection", {"deflection_disturbance": 1.0})
    return [sensors.system(plant), actuator_system(actuator), disturbance]


def actuator_system(actuator: Actuator | None) -> LinearSystem:
    """Return the state space of an actuator from command to deflection [rad]; of None a unit gain.

    A second-order actuator has the acceleration of the deflection as a further output.
    """
    if actuator is None:
        return gain("deflection", {"deflection_command": 1.0})
    A, B, C, D = actuator.matrices()
    order = A.shape[-1]
    # of second order the acceleration is the second row of A and B; of first order none is added
    C, D = np.concatenate([C, A[..., 1:, :]], axis=-2), np.concatenate([D, B[..., 1:, :]], axis=-2)
    outputs = ("deflection", "deflection_acceleration")[:order]
    states = ("actuator_deflection", "actuator_rate")[:order]
    return LinearSystem(A, B, C, D, inputs=("deflection_command",), outputs=outputs, states=states)


def check_engine(plant: AnyPlant, actuator: Actuator | None) -> None:
    """Raise `InputError` for a plant with engine inertia whose actuator is not second order."""
    if "deflection_acceleration" in plant.inputs and (actuator is None or actuator.damping is None):
        raise InputError(
            "the inertia of an engine needs an actuator of second order, which says how fast the"
            " deflection speeds up; give the actuator a damping, or leave the engine out"
        )
