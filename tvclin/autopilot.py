"""The autopilot: attitude and rate feedback, with actuator and delay, around one plant.

    delta = a0 (theta - command) + a1 theta' + b0 alpha + aI * integral of (theta - command)

Positive deflection pitches the nose down, so positive gains are negative feedback. `loop` and
`close` wire the same blocks and give python-control's own systems with named signals.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from inspect import cleandoc
from textwrap import indent
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.coefficients import Coefficients
from tvclin.errors import InputError, finite, nonnegative, positive
from tvclin.modes import unstable_modes
from tvclin.plant import Plant

if TYPE_CHECKING:
    import control

FloatArray = NDArray[np.float64]
Matrices = tuple[FloatArray, FloatArray, FloatArray, FloatArray]
_Method = TypeVar("_Method", bound=Callable[..., Any])

LOOP_DIAGRAM = """\
attitude_command                            deflection_disturbance   wind
       | -                                               |             |
       v     +-----------+                               |             v
 +-->( + )-->| a0 + aI/s |--+                            v         +-------+
 |           +-----------+  v     +-------+   +----------+  delta  |       |
 |  +------->|    a1     |>(+)-x->| delay |-->| actuator |>(+)---->| plant |
 |  |        +-----------+  ^     +-------+   +----------+         |       |
 |  |  +---->|    b0     |--+                                      +-------+
 |  |  |     +-----------+                                           | | |
 |  |  +----------- angle_of_attack ---------------------------------+ | |
 |  +-------------- attitude_rate -------------------------------------+ |
 +----------------- attitude --------------------------------------------+

 x  deflection_command: loop() is broken here, and its L is minus what returns"""

_DISTURBANCES = ("wind", "attitude_command", "deflection_disturbance")
_GAINS = ("attitude_gain", "rate_gain", "alpha_gain", "integral_gain")
_HIGHEST_PADE = 10


def _with_diagram(method: _Method) -> _Method:
    """Put the loop diagram where the docstring says LOOP_DIAGRAM."""
    text = cleandoc(method.__doc__ or "")
    method.__doc__ = text.replace("LOOP_DIAGRAM", indent(LOOP_DIAGRAM, "    "))
    return method


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
        frequency = _one("natural_frequency", positive, self.natural_frequency, "rad/s")
        object.__setattr__(self, "natural_frequency", frequency)
        if self.damping is not None:
            object.__setattr__(self, "damping", _one("damping", positive, self.damping))

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


@dataclass(frozen=True, kw_only=True)
class Autopilot:
    """Feedback of attitude, attitude rate, angle of attack and integrated attitude.

    Parameters
    ----------
    attitude_gain : float
        a0 [rad/rad]; positive is negative feedback, where mu_delta is positive.
    rate_gain : float
        a1 [s].
    alpha_gain : float
        b0 [rad/rad], on the angle of attack, of which the wind is a part.
    integral_gain : float
        aI [1/s], on the integral of attitude less command.
    actuator : Actuator, optional
        Without one the deflection follows its command at once.
    delay : float
        Delay [s] between the sum of the feedbacks and the actuator.
    pade_order : int
        Order of the Pade approximation that stands for the delay in `loop` and `close`, 1 to 10.
        `frequency_response` has the exact delay.

    Raises
    ------
    InputError
        For gains that are not finite or all zero, a delay below zero, and arrays.
    """

    attitude_gain: float
    rate_gain: float
    alpha_gain: float = 0.0
    integral_gain: float = 0.0
    actuator: Actuator | None = None
    delay: float = 0.0
    pade_order: int = 4

    def __post_init__(self) -> None:
        for name in _GAINS:
            object.__setattr__(self, name, _one(name, finite, getattr(self, name)))
        if not any(getattr(self, name) for name in _GAINS):
            raise InputError(f"an autopilot needs a gain; {', '.join(_GAINS)} are all zero")
        object.__setattr__(self, "delay", _one("delay", nonnegative, self.delay, "s"))
        if not isinstance(self.actuator, Actuator | None):
            raise InputError(f"actuator must be an Actuator or None; got {self.actuator!r}")
        order = self.pade_order
        if type(order) is not int or not 1 <= order <= _HIGHEST_PADE:
            raise InputError(f"pade_order must be an integer from 1 to 10; got {order!r}")

    @_with_diagram
    def loop(self, plant: Plant) -> "control.StateSpace":
        """Return the loop L, broken at the deflection command.

        LOOP_DIAGRAM

        Parameters
        ----------
        plant : Plant
            One plant of any model.

        Returns
        -------
        control.StateSpace
            From deflection_command to returned_command [rad]. The sign is such that the closed
            loop is 1 + L = 0: on eq (5), L = (a0 + a1 s) mu_delta/(s^2 - mu_alpha).

        Raises
        ------
        InputError
            For a batch.

        Warns
        -----
        UserWarning
            Where attitude_gain is positive feedback on this plant, and where the actuator is
            slower than its fastest unstable pole.
        """
        import control

        states, rows = self._wired(plant)
        return control.StateSpace(
            *_quarters(np.delete(rows[: len(states)], _inputs(states), axis=1), states),
            0,
        )
