"""What lies between a deflection command and the deflection: the actuator and the delay."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb, perm
from typing import TYPE_CHECKING

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Carded
from tvclin.base.documents import keyed
from tvclin.base.errors import InputError, plain, together
from tvclin.control.autopilot.sizes import sized

if TYPE_CHECKING:
    import control

Matrices = tuple[FloatArray, FloatArray, FloatArray, FloatArray]

THROUGH: Matrices = (np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.ones((1, 1)))
"""No dynamics at all."""


@dataclass(frozen=True, kw_only=True)
class Actuator(Carded):
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

    natural_frequency: float | FloatArray = 25.1
    damping: float | FloatArray | None = 0.7

    _keys = "natural_frequency_rad_per_s damping"
    as_dict = keyed("natural_frequency_rad_s damping")

    def __post_init__(self) -> None:
        frequency = sized("natural_frequency", self.natural_frequency, "rad/s")
        object.__setattr__(self, "natural_frequency", plain(frequency))
        if self.damping is not None:
            damping = sized("damping", self.damping)
            together(natural_frequency=frequency, damping=damping)
            object.__setattr__(self, "damping", plain(damping))

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for one actuator."""
        return self.denominator.shape[:-1]

    @property
    def denominator(self) -> FloatArray:
        """The characteristic polynomial ``(..., order + 1)``, highest power first.

        Its last term is the numerator.
        """
        w = np.asarray(self.natural_frequency)
        if self.damping is None:
            return np.stack([np.ones_like(w), w], axis=-1)
        rows = np.broadcast_arrays(1.0, 2.0 * np.asarray(self.damping) * w, w**2)
        return np.stack(rows, axis=-1)

    def tf(self) -> control.TransferFunction:
        """Return the actuator as `control.TransferFunction`, deflection per command.

        Raises
        ------
        InputError
            For a batch.
        """
        import control

        if self.batch:
            raise InputError(f"tf() is for one actuator; got a batch of shape {self.batch}")
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
        order = self.denominator.shape[-1] - 1
        A = np.zeros((*self.batch, order, order)) + np.eye(order, k=1)
        B = np.zeros((*self.batch, order, 1))
        C, D = np.zeros((*self.batch, 1, order)) + np.eye(1, order), np.zeros((*self.batch, 1, 1))
        A[..., -1, :] = -self.denominator[..., :0:-1]
        B[..., -1, 0] = self.denominator[..., -1]
        return A, B, C, D


def pade_delay(delay: float, order: int) -> Matrices:
    """Return A, B, C, D of the delay, in time units in which its poles are of size one."""
    if delay == 0.0:
        return THROUGH
    powers = np.arange(order, -1, -1)
    denominator = np.array([float(comb(order, k) * perm(2 * order - k, order - k)) for k in powers])
    unit = denominator[-1] ** (1.0 / order)
    denominator /= unit ** powers[::-1]
    numerator = denominator * (-1.0) ** powers
    A, B = np.eye(order, k=1), np.zeros((order, 1))
    A[-1], B[-1] = -denominator[:0:-1], 1.0
    C = (numerator - numerator[0] * denominator)[np.newaxis, :0:-1]
    return A * unit / delay, B * unit / delay, C, numerator[:1, np.newaxis]
