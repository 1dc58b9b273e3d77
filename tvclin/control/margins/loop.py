"""A loop as a rational function and a delay: all that its margins depend on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.base.errors import (
    InputError,
    broadcast,
    finite,
    nonnegative,
    within,
)
from tvclin.kernels.rational import Rational

if TYPE_CHECKING:
    import control

_STEPS, _BESIDE = 20, 0.05
_FASTEST = 1e15
"""Frequencies beyond this [rad/s] would overflow in polynomials."""


@dataclass(frozen=True, eq=False)
class Loop(Rational):
    """One loop L(s) = numerator(s)/denominator(s) e^(-s delay), or a batch of them.

    The closed loop is 1 + L = 0. The delay is exact wherever a loop is looked at.

    Parameters
    ----------
    numerator, denominator : array_like
        Polynomial coefficients, highest power first, ``(..., m)`` and ``(..., n)``; the leading
        axes broadcast. The denominator is of higher degree.
    delay : array_like
        Delay [s], ``(...)``.

    Raises
    ------
    InputError
        For numbers that are not finite, a delay below zero, a denominator that begins with zero,
        and an algebraic loop: a numerator of the same degree as the denominator, or higher.
    """

    def __init__(
        self, numerator: ArrayLike, denominator: ArrayLike, delay: ArrayLike = 0.0
    ) -> None:
        above = np.atleast_1d(finite("numerator", numerator))
        below = np.atleast_1d(finite("denominator", denominator))
        late = nonnegative("delay", delay, "s")
        if not below.shape[-1]:
            raise InputError("denominator must have a coefficient")
        if np.any(below[..., 0] == 0.0):
            raise InputError("denominator must not begin with a zero")
        while above.shape[-1] > 1 and not np.any(above[..., 0]):
            above = above[..., 1:]
        if above.shape[-1] >= below.shape[-1]:
            raise InputError(
                "this is an algebraic loop: its command comes back at once (numerator of degree"
                f" {above.shape[-1] - 1} over {below.shape[-1] - 1}); put an actuator into it"
            )
        shape = broadcast(
            numerator=above.shape[:-1], denominator=below.shape[:-1], delay=late.shape
        )
        missing = below.shape[-1] - above.shape[-1]
        above = np.pad(above, [(0, 0)] * (above.ndim - 1) + [(missing, 0)])
        size = below.shape[-1]
        object.__setattr__(self, "numerator", np.broadcast_to(above, (*shape, size)))
        object.__setattr__(self, "denominator", np.broadcast_to(below, (*shape, size)))
        object.__setattr__(self, "delay", np.broadcast_to(late, shape))

    @classmethod
    def from_system(
        cls, system: control.StateSpace | control.TransferFunction, delay: ArrayLike = 0.0
    ) -> Self:
        """Return the loop of a python-control system with one input and one output.

        Parameters
        ----------
        system : control.StateSpace or control.TransferFunction
            The open loop in continuous time, with the sign of 1 + L = 0.
        delay : array_like
            A delay [s] in series with it.

        Raises
        ------
        InputError
            For anything else: margins rest on the poles, which frequency data do not have.
        """
        import control

        if not isinstance(system, control.StateSpace | control.TransferFunction):
            raise InputError(
                "a loop must be a control.StateSpace or control.TransferFunction, whose poles are"
                f" known; got a {type(system).__name__}"
            )
        if not system.issiso() or system.isdtime(strict=True):
            raise InputError("a loop must have one input and one output, in continuous time")
        rational = control.tf(system)
        return cls(rational.num[0][0], rational.den[0][0], delay)

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for one loop."""
        return self.delay.shape

    def response(self, omega: ArrayLike) -> NDArray[np.complex128]:
        """Return L(j omega), shape ``batch + omega.shape``; infinite at a pole.

        Parameters
        ----------
        omega : array_like
            Frequencies [rad/s], of any shape.

        Raises
        ------
        InputError
            For frequencies that are not finite, or beyond 1e15 rad/s.
        """
        frequencies = within("omega", omega, -_FASTEST, _FASTEST, "rad/s")
        above, below = self.parts(frequencies.ravel())
        pole = (below == 0.0) & (above != 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            values = np.where(pole, np.inf, above / below)
        return np.asarray(values.reshape((*self.batch, *frequencies.shape)))


def beside_exact(found: NDArray[np.complex128], loop: Loop) -> NDArray[np.bool_]:
    """Return which poles of one loop, found with an approximate delay, lie beside an exact one.

    Newton's steps go from each [1/s] to a zero of ``D(s) + N(s) e^(-s delay)``; it is beside where
    it is away by at most a twentieth of the pole's size.
    """
    s = found.astype(complex)
    with np.errstate(all="ignore"):
        for _ in range(_STEPS):
            late = np.exp(-s * loop.delay)
            above, below = np.polyval(loop.numerator, s), np.polyval(loop.denominator, s)
            slope = np.polyval(np.polyder(loop.numerator), s) - loop.delay * above
            slope = np.polyval(np.polyder(loop.denominator), s) + slope * late
            s = s - (below + above * late) / slope
        return np.asarray(np.abs(s - found) <= _BESIDE * np.abs(found))
