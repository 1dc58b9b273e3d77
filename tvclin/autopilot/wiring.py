"""The loop written down: in state space for python-control, and as polynomials for the rest.

Both say the same blocks, those of `diagram`; tests hold them to each other.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tvclin.autopilot.actuator import THROUGH, pade_delay, pade_polynomials
from tvclin.errors import InputError
from tvclin.kernels import polynomials
from tvclin.plant import Plant

if TYPE_CHECKING:
    from tvclin.autopilot.feedback import Autopilot

FloatArray = NDArray[np.float64]


def wired(
    autopilot: "Autopilot", plant: Plant
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


def loop_polynomials(autopilot: "Autopilot", plant: Plant) -> tuple[FloatArray, FloatArray]:
    """Return numerator and denominator ``(..., n)`` of the loop without its delay."""
    asked, integrators = _feedback(autopilot, plant, "deflection")
    above, below = _engine(autopilot)
    denominator = polynomials.times_variable(plant.denominator, integrators)
    return polynomials.multiply(-asked, above), polynomials.multiply(denominator, below)


def wind_polynomials(
    autopilot: "Autopilot", plant: Plant, output: str
) -> tuple[FloatArray, FloatArray]:
    """Return numerator and denominator ``(..., n)`` from the wind to an output, loop closed.

    The denominator is the characteristic polynomial of the closed loop; a delay enters as its
    Pade approximation. With plant numerators N over D, feedback K, and F = above/below between
    command and deflection,

        y/w = [N_yw s^k below - above (N_yw K_d - N_yd K_w)/D] / (D s^k below - above K_d),

    k being 1 with an integrator; the division by D leaves no remainder.
    """
    above, below = _with_delay(autopilot, *_engine(autopilot))
    by_deflection, integrators = _feedback(autopilot, plant, "deflection")
    by_wind, _ = _feedback(autopilot, plant, "wind")
    open_loop = polynomials.times_variable(plant.denominator, integrators)
    open_loop = polynomials.multiply(open_loop, below)
    closed = polynomials.add(open_loop, -polynomials.multiply(by_deflection, above))
    if output == "deflection":
        return polynomials.multiply(by_wind, above), closed
    own = plant.numerator(output, "wind")
    cross = polynomials.add(
        polynomials.multiply(own, by_deflection),
        -polynomials.multiply(plant.numerator(output, "deflection"), by_wind),
    )
    cross = polynomials.quotient(cross, plant.denominator)
    direct = polynomials.multiply(polynomials.times_variable(own, integrators), below)
    return polynomials.add(direct, -polynomials.multiply(cross, above)), closed


def _feedback(autopilot: "Autopilot", plant: Plant, source: str) -> tuple[FloatArray, int]:
    """The numerator from an input of the plant to the command, and how many powers of s it has.

    It stands over the denominator of the plant times s, if there is an integrator.
    """
    integrators = int(np.any(np.asarray(autopilot.integral_gain)))
    attitude = plant.numerator("attitude", source)
    angle = plant.numerator("angle_of_attack", source)
    gains = [autopilot.rate_gain, autopilot.attitude_gain, autopilot.integral_gain]
    on_attitude = np.stack(np.broadcast_arrays(*gains[: 2 + integrators]), axis=-1)
    on_angle = np.asarray(autopilot.alpha_gain)[..., np.newaxis] * np.eye(1, 1 + integrators)[0]
    return (
        polynomials.add(
            polynomials.multiply(on_attitude, attitude), polynomials.multiply(on_angle, angle)
        ),
        integrators,
    )


def _engine(autopilot: "Autopilot") -> tuple[FloatArray, FloatArray]:
    if autopilot.actuator is None:
        return np.ones(1), np.ones(1)
    below = autopilot.actuator.denominator
    return below[..., -1:], below


def _with_delay(
    autopilot: "Autopilot", above: FloatArray, below: FloatArray
) -> tuple[FloatArray, FloatArray]:
    delay = np.asarray(autopilot.delay)
    if not np.any(delay):
        return above, below
    if not np.all(delay):
        raise InputError(
            "delay must be zero for none or for all of a batch whose time responses are asked for"
        )
    top, bottom = pade_polynomials(delay, autopilot.pade_order)
    return polynomials.multiply(above, top), polynomials.multiply(below, bottom)
