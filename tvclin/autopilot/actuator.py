"""What lies between a deflection command and the deflection: the actuator and the delay."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.errors import InputError, positive

if TYPE_CHECKING:
    import control

FloatArray = NDArray[np.float64]
Matrices = tuple[FloatArray, FloatArray, FloatArray, FloatArray]

THROUGH: Matrices = (np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.ones((1, 1)))
"""No dynamics at all."""


@dataclass(frozen=True, kw_only=True)
class Actuator:
    """The dynamics of an actuator, of unit steady gain; its limits are not part of it.

    Parameters
    ----------
    natural_frequency : float
        Natural frequency [rad/s], positive; of a first-order actuator its bandwidth.
    damping : float or None
        Damping ratio, positive; None makes the actuator first order.

    Raises
    ------
    InputError
        For numbers that are not finite and positive, and for arrays.
    """

    natural_frequency: float = 25.1
    damping: float | None = 0.7

    def __post_init__(self) -> None:
        frequency = one_number("natural_frequency", positive, self.natural_frequency, "rad/s")
        object.__setattr__(self, "natural_frequency", frequency)
        if self.damping is not None:
            object.__setattr__(self, "damping", one_number("damping", positive, self.damping))

    @property
    def denominator(self) -> FloatArray:
        """The characteristic polynomial, highest power first; its last term is the numerator."""
        w = self.natural_frequency
        if self.damping is None:
            return np.array([1.0, w])
        return np.array([1.0, 2.0 * self.damping * w, w**2])

    def tf(self) -> "control.TransferFunction":
        """Return the actuator as `control.TransferFunction`, deflection per command."""
        import control

        return control.TransferFunction(
            self.denominator[-1:],
            self.denominator,
            0,
            name="actuator",
            inputs=["deflection_command"],
            outputs=["deflection"],
        )

    def matrices(self) -> Matrices:
        """Return A, B, C, D; the states are the deflection [rad] and its rate [rad/s]."""
        order = self.denominator.size - 1
        A, B, C = np.eye(order, k=1), np.zeros((order, 1)), np.eye(1, order)
        A[-1] = -self.denominator[:0:-1]
        B[-1] = self.denominator[-1]
        return A, B, C, np.zeros((1, 1))


def pade_delay(delay: float, order: int) -> Matrices:
    """Return A, B, C, D of the delay, in time units in which its poles are of size one."""
    if delay == 0.0:
        return THROUGH
    import control

    numerator, denominator = (np.array(p) for p in control.pade(1.0, order))
    unit = denominator[-1] ** (1.0 / order)
    numerator, denominator = (p / unit ** np.arange(order + 1) for p in (numerator, denominator))
    A, B = np.eye(order, k=1), np.zeros((order, 1))
    A[-1], B[-1] = -denominator[:0:-1], 1.0
    C = (numerator - numerator[0] * denominator)[np.newaxis, :0:-1]
    return A * unit / delay, B * unit / delay, C, numerator[:1, np.newaxis]


def one_number(
    name: str, check: Callable[..., FloatArray], value: ArrayLike, unit: str = ""
) -> float:
    """Return `value` as a float; `InputError` unless it passes the check and is no array."""
    array = check(name, value, unit)
    if array.ndim:
        raise InputError(f"{name} must be one number; got an array of shape {array.shape}")
    return float(array)
