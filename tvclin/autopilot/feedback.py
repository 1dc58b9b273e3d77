"""The autopilot: attitude and rate feedback, with actuator and delay, around one plant.

    delta = a0 (theta - command) + a1 theta' + b0 alpha + aI * integral of (theta - command)

Positive deflection pitches the nose down, so positive gains are negative feedback. `loop` and
`close` wire the same blocks and give python-control's own systems with named signals.
"""

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.autopilot.actuator import THROUGH, Actuator, one_number, pade_delay
from tvclin.autopilot.diagram import with_diagram
from tvclin.coefficients import Coefficients
from tvclin.errors import InputError, finite, nonnegative
from tvclin.modes import unstable_modes
from tvclin.plant import Plant

if TYPE_CHECKING:
    import control

FloatArray = NDArray[np.float64]

_DISTURBANCES = ("wind", "attitude_command", "deflection_disturbance")
_GAINS = ("attitude_gain", "rate_gain", "alpha_gain", "integral_gain")
_HIGHEST_PADE = 10


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

    Examples
    --------
    >>> import tvclin as tv
    >>> c = tv.Coefficients(mu_alpha=0.228, mu_delta=1.317)
    >>> plant = tv.Plant.from_coefficients(c)
    >>> tv.Autopilot(attitude_gain=1.88, rate_gain=1.59).close(plant).poles().round(3)
    array([-1.047+1.073j, -1.047-1.073j])
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
            object.__setattr__(self, name, one_number(name, finite, getattr(self, name)))
        if not any(getattr(self, name) for name in _GAINS):
            raise InputError(f"an autopilot needs a gain; {', '.join(_GAINS)} are all zero")
        object.__setattr__(self, "delay", one_number("delay", nonnegative, self.delay, "s"))
        if not isinstance(self.actuator, Actuator | None):
            raise InputError(f"actuator must be an Actuator or None; got {self.actuator!r}")
        order = self.pade_order
        whole = isinstance(order, int | np.integer) and not isinstance(order, bool)
        if not whole or not 1 <= order <= _HIGHEST_PADE:
            raise InputError(
                f"pade_order must be an integer from 1 to {_HIGHEST_PADE}; got {order!r}"
            )

    @with_diagram
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

    @with_diagram
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
        require_single(plant, Plant)
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
        delay = pade_delay(self.delay, self.pade_order)
        engine = THROUGH if self.actuator is None else self.actuator.matrices()
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
        require_single(plant, Plant)
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


def require_single(of: Plant | Coefficients, kind: type) -> None:
    """Raise `InputError` unless `of` is a plant, or coefficients, of one vehicle."""
    if not isinstance(of, kind):
        raise InputError(f"expected a tvclin {kind.__name__}; got a {type(of).__name__}")
    if of.batch:
        raise InputError(
            f"an autopilot is for one vehicle; got a batch of shape {of.batch} (take one at a time)"
        )
