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
attitude_command                          deflection_disturbance               wind
       | -                                                    |                  |
       v     +-----------+                                    |                  v
 +-->( + )-->| a0 + aI/s |--+                                 |              +-------+
 |           +-----------+  v     +-------+   +----------+    v              |       |
 |  +------->|    a1     |>(+)-x->| delay |-->| actuator |-->(+)-deflection->| plant |
 |  |        +-----------+  ^     +-------+   +----------+                   |       |
 |  |  +---->|    b0     |--+                                                +-------+
 |  |  |     +-----------+                                                     | | |
 |  |  +---------------------------- angle_of_attack --------------------------+ | |
 |  +------------------------------- attitude_rate ------------------------------+ |
 +---------------------------------- attitude -------------------------------------+

 x  deflection_command: loop() is broken here, and L is minus what returns"""

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

        self._warn(plant)
        states, motion, _, returned = self._wired(plant)
        n = len(states)
        return control.StateSpace(
            motion[:, :n],
            motion[:, -1:],
            0.0 - returned[:, :n],
            0.0 - returned[:, -1:],
            0,
            name=f"{plant.model} loop",
            inputs=["deflection_command"],
            outputs=["returned_command"],
            states=states,
        )

    @_with_diagram
    def close(self, plant: Plant) -> "control.StateSpace":
        """Return the plant with this autopilot around it.

        LOOP_DIAGRAM

        Parameters
        ----------
        plant : Plant
            One plant of any model.

        Returns
        -------
        control.StateSpace
            Inputs wind, attitude_command and deflection_disturbance [rad]; outputs those of the
            plant [rad, rad/s], and the deflection [rad] that acts on it, disturbance included.

        Raises
        ------
        InputError
            For a batch.

        Warns
        -----
        UserWarning
            As `loop`. An unstable closed loop is returned like any other: ask for its poles.
        """
        import control

        self._warn(plant)
        states, motion, outputs, returned = self._wired(plant)
        n = len(states)
        # No plant passes its deflection on at once, so the returned command does not contain the
        # deflection command, and to put the one for the other closes the loop.
        motion, outputs = (
            rows[:, :-1] + rows[:, -1:] @ returned[:, :-1] for rows in (motion, outputs)
        )
        return control.StateSpace(
            motion[:, :n],
            motion[:, n:],
            outputs[:, :n],
            outputs[:, n:],
            0,
            name=f"{plant.model} with autopilot",
            inputs=list(_DISTURBANCES),
            outputs=[*plant.outputs, "deflection"],
            states=states,
        )

    def frequency_response(self, plant: Plant, omega: ArrayLike) -> NDArray[np.complex128]:
        """Return L(j omega) of `loop`, with the exact delay e^(-j omega delay).

        Parameters
        ----------
        plant : Plant
            One plant of any model.
        omega : array_like
            Frequencies [rad/s], of any shape; where the loop has a pole the answer is infinite.

        Raises
        ------
        InputError
            For a batch, and for frequencies that are not finite.
        """
        _require_single(plant)
        s = 1j * finite("omega", omega, "rad/s")
        attitude = np.polyval(plant.numerator("attitude", "deflection"), s)
        angle = np.polyval(plant.numerator("angle_of_attack", "deflection"), s)
        top = (self.attitude_gain + self.rate_gain * s) * attitude + self.alpha_gain * angle
        bottom = np.polyval(plant.denominator, s)
        if self.integral_gain:
            top, bottom = top * s + self.integral_gain * attitude, bottom * s
        if self.actuator is not None:
            top = top * self.actuator.denominator[-1]
            bottom = bottom * np.polyval(self.actuator.denominator, s)
        pole = (bottom == 0.0) & (top != 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(pole, np.inf, -top / bottom * np.exp(-s * self.delay))

    def _wired(self, plant: Plant) -> tuple[list[str], FloatArray, FloatArray, FloatArray]:
        """Write down all signals of the broken loop.

        Each is a row of factors on the states, the three disturbances and the deflection command:
        the rates of the states, the outputs of `close`, and the returned command.
        """
        A, B, C, D = plant.matrices()
        delay = _pade(self.delay, self.pade_order)
        engine = _THROUGH if self.actuator is None else self.actuator.matrices()
        integrators = int(self.integral_gain != 0.0)
        sizes = [len(A), len(engine[0]), len(delay[0]), integrators, 1, 1, 1, 1]
        x, bent, late, held, wind, command, disturbance, sent = np.split(
            np.eye(sum(sizes)), np.cumsum(sizes)[:-1]
        )
        arrived = delay[2] @ late + delay[3] @ sent
        deflection = engine[2] @ bent + engine[3] @ arrived + disturbance
        forces = np.vstack([deflection, wind])
        seen = C @ x + D @ forces
        error = seen[:1] - command
        returned = (
            self.attitude_gain * error
            + self.rate_gain * seen[1:2]
            + self.alpha_gain * seen[-1:]
            + self.integral_gain * held.sum(axis=0, keepdims=True)
        )
        motion = np.vstack(
            [
                A @ x + B @ forces,
                engine[0] @ bent + engine[1] @ arrived,
                delay[0] @ late + delay[1] @ sent,
                error[:integrators],
            ]
        )
        names = [
            *plant.states,
            *("actuator_deflection", "actuator_rate")[: len(bent)],
            *(f"delay_{k}" for k in range(1, len(late) + 1)),
            *("attitude_error_integral",)[:integrators],
        ]
        return names, motion, np.vstack([seen, deflection]), returned

    def _warn(self, plant: Plant) -> None:
        _require_single(plant)
        mu_delta = float(plant.coefficients.mu_delta)
        if self.attitude_gain * mu_delta < 0.0:
            warnings.warn(
                f"attitude_gain = {self.attitude_gain:.6g} is positive feedback on a plant with"
                f" mu_delta = {mu_delta:.6g} 1/s^2; give it the sign of mu_delta",
                stacklevel=3,
            )
        poles = unstable_modes(plant).poles
        if self.actuator is None or not poles.size:
            return
        frequency, fastest = self.actuator.natural_frequency, float(poles[0].real)
        if frequency < fastest:
            warnings.warn(
                f"the actuator, natural_frequency = {frequency:.6g} rad/s, is slower than the"
                f" fastest unstable pole of the plant, {fastest:.6g} 1/s",
                stacklevel=3,
            )


def canonical_gains(coefficients: Coefficients, **options: Any) -> Autopilot:
    """Return the autopilot with a0 = 2B and a1 = B/beta.

    On eq (5), without actuator and delay, the closed loop is s^2 + beta s + beta^2: natural
    frequency beta, damping ratio 0.5.

    Parameters
    ----------
    coefficients : Coefficients
        Those of one aerodynamically unstable vehicle; for others see `design_gains`.
    **options
        The other arguments of `Autopilot`: actuator, delay, and so on.

    Raises
    ------
    InputError
        For a stable vehicle, which has no beta, and for a batch.
    """
    _require_single(coefficients)
    c = coefficients
    return Autopilot(attitude_gain=2.0 * c.B, rate_gain=c.B / c.beta, **options)


def design_gains(
    coefficients: Coefficients, *, natural_frequency: float, damping: float, **options: Any
) -> Autopilot:
    """Return the autopilot that gives eq (5) the poles asked for.

    Without actuator and delay the closed loop is
    s^2 + mu_delta a1 s + (mu_delta a0 - mu_alpha) = s^2 + 2 damping omega_n s + omega_n^2.

    Parameters
    ----------
    coefficients : Coefficients
        Those of one vehicle, stable or not.
    natural_frequency : float
        omega_n [rad/s] of the closed loop, positive.
    damping : float
        Damping ratio of the closed loop, positive.
    **options
        The other arguments of `Autopilot`: actuator, delay, and so on.

    Raises
    ------
    InputError
        For numbers that are not positive, and for a batch.
    """
    _require_single(coefficients)
    frequency = _one("natural_frequency", positive, natural_frequency, "rad/s")
    ratio, c = _one("damping", positive, damping), coefficients
    return Autopilot(
        attitude_gain=float((frequency**2 + c.mu_alpha) / c.mu_delta),
        rate_gain=float(2.0 * ratio * frequency / c.mu_delta),
        **options,
    )


_THROUGH: Matrices = (np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.ones((1, 1)))


def _pade(delay: float, order: int) -> Matrices:
    """Return A, B, C, D of the delay, in time units in which its poles are of size one."""
    if delay == 0.0:
        return _THROUGH
    import control

    numerator, denominator = (np.array(p) for p in control.pade(1.0, order))
    unit = denominator[-1] ** (1.0 / order)
    numerator, denominator = (p / unit ** np.arange(order + 1) for p in (numerator, denominator))
    A, B = np.eye(order, k=1), np.zeros((order, 1))
    A[-1], B[-1] = -denominator[:0:-1], 1.0
    C = (numerator - numerator[0] * denominator)[np.newaxis, :0:-1]
    return A * unit / delay, B * unit / delay, C, numerator[:1, np.newaxis]


def _one(name: str, check: Callable[..., FloatArray], value: ArrayLike, unit: str = "") -> float:
    array = check(name, value, unit)
    if array.ndim:
        raise InputError(f"{name} must be one number; got an array of shape {array.shape}")
    return float(array)


def _require_single(of: Plant | Coefficients) -> None:
    if of.batch:
        raise InputError(
            f"an autopilot is for one vehicle; got a batch of shape {of.batch} (take one at a time)"
        )
