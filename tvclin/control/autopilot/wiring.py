"""The loop written down: in state space for python-control, and as polynomials for the rest.

Both say the same blocks, those of `diagram`; tests hold them to each other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tvclin.control.autopilot.actuator import THROUGH, pade_delay
from tvclin.control.autopilot.feedback import Feedback
from tvclin.control.margins.loop import Loop
from tvclin.kernels import polynomials
from tvclin.linear.plant import Plant

FloatArray = NDArray[np.float64]


def wired(
    autopilot: Feedback, plant: Plant
) -> tuple[list[str], FloatArray, FloatArray, FloatArray]:
    """Return all signals of the broken loop of one plant, and the names of its states.

    Each is a row of factors on the states, the three disturbances (wind, attitude command,
    deflection disturbance) and the deflection command: the rates of the states, the outputs of
    the plant and the deflection, and the returned command.
    """
    A, B, C, D = plant.matrices()
    delay = pade_delay(float(autopilot.delay), autopilot.pade_order)
    engine = THROUGH if autopilot.actuator is None else autopilot.actuator.matrices()
    integrators = int(autopilot.integral_gain != 0.0)
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
        autopilot.attitude_gain * error
        + autopilot.rate_gain * seen[1:2]
        + autopilot.alpha_gain * seen[-1:]
        + autopilot.integral_gain * held.sum(axis=0, keepdims=True)
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


class ClosedLoop(NamedTuple):
    """Names of the states, and the matrices of x' = A x + B w, y = C x + D w."""

    states: list[str]
    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray


def closed(autopilot: Feedback, plant: Plant) -> ClosedLoop:
    """Return the closed loop of one plant."""
    states, motion, outputs, returned = wired(autopilot, plant)
    n = len(states)
    # No plant passes its deflection on at once, so the returned command does not contain the
    # deflection command, and to put the one for the other closes the loop.
    motion, outputs = (rows[:, :-1] + rows[:, -1:] @ returned[:, :-1] for rows in (motion, outputs))
    return ClosedLoop(states, motion[:, :n], motion[:, n:], outputs[:, :n], outputs[:, n:])


def rational_loop(autopilot: Feedback, plant: Plant) -> Loop:
    """Return the loop as polynomials and an exact delay."""
    asked, integrators = _feedback(autopilot, plant, "deflection")
    above, below = _engine(autopilot)
    denominator = polynomials.times_variable(plant.denominator, integrators)
    return Loop(
        polynomials.multiply(-asked, above),
        polynomials.multiply(denominator, below),
        autopilot.delay,
    )


def wind_numerator(autopilot: Feedback, plant: Plant) -> FloatArray:
    """Return the numerator ``(..., n)`` from wind to deflection with the loop left open.

    It stands over the denominator of `rational_loop`, and has the same delay.
    """
    return polynomials.multiply(_feedback(autopilot, plant, "wind")[0], _engine(autopilot)[0])


def _feedback(autopilot: Feedback, plant: Plant, source: str) -> tuple[FloatArray, int]:
    """The numerator from a source to the command, and how many integrators there are.

    It stands over the denominator of the plant times s, if there is an integrator.
    """
    integrators = int(np.any(np.asarray(autopilot.integral_gain)))
    gains = [autopilot.rate_gain, autopilot.attitude_gain, autopilot.integral_gain]
    on_attitude = np.stack(np.broadcast_arrays(*gains[: 2 + integrators]), axis=-1)
    on_angle = np.asarray(autopilot.alpha_gain)[..., np.newaxis] * np.eye(1, 1 + integrators)[0]
    attitude = polynomials.multiply(on_attitude, plant.numerator("attitude", source))
    angle = polynomials.multiply(on_angle, plant.numerator("angle_of_attack", source))
    return polynomials.add(attitude, angle), integrators


def _engine(autopilot: Feedback) -> tuple[FloatArray, FloatArray]:
    if autopilot.actuator is None:
        return np.ones(1), np.ones(1)
    below = autopilot.actuator.denominator
    return below[..., -1:], below
