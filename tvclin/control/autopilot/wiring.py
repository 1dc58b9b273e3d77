"""The loop written down: in state space for python-control, and as polynomials for the rest.

Both say the same blocks, those of `diagram`; tests hold them to each other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tvclin.control.autopilot.actuated import actuated
from tvclin.control.autopilot.actuator import THROUGH, Matrices, pade_delay
from tvclin.control.autopilot.feedback import CHAINS, Feedback
from tvclin.control.margins.loop import Loop
from tvclin.kernels import polynomials
from tvclin.kernels.state_space import stacked
from tvclin.linear.flexible import AnyPlant, FlexiblePlant
from tvclin.linear.plant import Plant

FloatArray = NDArray[np.float64]


class Wires(NamedTuple):
    """All signals of a broken loop, each a row of factors on what it depends on.

    That is the states, then wind, attitude command, deflection disturbance, and the deflection
    command; ``(..., rows, columns)``.

    Attributes
    ----------
    states : tuple of str
        Names of the states.
    motion : ndarray
        Their rates.
    outputs : ndarray
        The outputs of the plant, then the deflection.
    sensed : ndarray
        Attitude and attitude rate as the sensors say them, and the angle of attack.
    returned : ndarray
        The returned command.
    """

    states: tuple[str, ...]
    motion: FloatArray
    outputs: FloatArray
    sensed: FloatArray
    returned: FloatArray


def wired(autopilot: Feedback, plant: AnyPlant, delay: Matrices = THROUGH) -> Wires:
    """Return all signals of the broken loop, of one or of a batch.

    The states are those of the plant, of the actuator, of the delay as it is given here, of the
    integrator and of the filters.
    """
    A, B, C, D, names, _ = actuated(plant, autopilot.actuator)
    integrators = int(np.any(np.asarray(autopilot.integral_gain)))
    chains = {name: getattr(autopilot, name) for name in CHAINS}
    orders = [one.order for chain in chains.values() for one in chain]
    sizes = [A.shape[-1], len(delay[0]), integrators, *orders, 1, 1, 1, 1]
    x, late, held, *stored, wind, command, disturbance, sent = np.split(
        np.eye(sum(sizes)), np.cumsum(sizes)[:-1]
    )
    rest = iter(stored)
    rates: list[FloatArray] = []

    def filtered(name: str, signal: FloatArray) -> FloatArray:
        for one in chains[name]:
            a, b, c, d = one.matrices()
            own = next(rest)
            rates.append(a @ own + b @ signal)
            signal = c @ own + d @ signal
        return signal

    forces = np.vstack([delay[2] @ late + delay[3] @ sent, disturbance, wind])
    seen = C @ x + D @ forces
    sensed = stacked(*(seen[..., k : k + 1, :] for k in sensed_places(plant)))
    error = filtered("attitude_filters", sensed[..., :1, :]) - command
    returned = (
        _factor(autopilot.attitude_gain) * error
        + _factor(autopilot.rate_gain) * filtered("rate_filters", sensed[..., 1:2, :])
        + _factor(autopilot.alpha_gain) * sensed[..., 2:, :]
        + _factor(autopilot.integral_gain) * held.sum(axis=0, keepdims=True)
    )
    returned = filtered("filters", returned)
    moving = [A @ x + B @ forces, delay[0] @ late + delay[1] @ sent]
    states = [
        *names,
        *(f"delay_{k}" for k in range(1, len(late) + 1)),
        *("attitude_error_integral",)[:integrators],
        *(
            f"{name.removesuffix('s')}_{k}_{state}"
            for name, chain in chains.items()
            for k, one in enumerate(chain, start=1)
            for state in range(1, one.order + 1)
        ),
    ]
    motion = stacked(*moving, error[..., :integrators, :], *rates)
    return Wires(tuple(states), motion, seen, sensed, returned)


def _factor(gain: float | FloatArray) -> FloatArray:
    return np.asarray(gain)[..., np.newaxis, np.newaxis]


def sensed_places(plant: AnyPlant) -> tuple[int, int, int]:
    """Return the places of sensed attitude, sensed rate and angle of attack among the outputs."""
    names = ("attitude", "attitude_rate", "angle_of_attack")
    if isinstance(plant, FlexiblePlant):
        names = ("sensed_attitude", "sensed_attitude_rate", "angle_of_attack")
    first, second, third = (plant.outputs.index(name) for name in names)
    return first, second, third


def exact_loop(autopilot: Feedback, plant: AnyPlant) -> Loop:
    """Return the loop with its exact delay: of a `Plant` as polynomials, else in state space."""
    if isinstance(plant, Plant):
        return rational_loop(autopilot, plant)
    wires = wired(autopilot, plant)
    n = len(wires.states)
    A, B = wires.motion[..., :n], wires.motion[..., -1:]
    return Loop.from_matrices(A, B, 0.0 - wires.returned[..., :n], delay=autopilot.delay)


class ClosedLoop(NamedTuple):
    """Names of the states, and the matrices of x' = A x + B w, y = C x + D w."""

    states: tuple[str, ...]
    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray


def closed(autopilot: Feedback, plant: AnyPlant) -> ClosedLoop:
    """Return the closed loop of one plant."""
    delay = pade_delay(float(autopilot.delay), autopilot.pade_order)
    states, motion, outputs, _, returned = wired(autopilot, plant, delay)
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
    for name in CHAINS:
        if getattr(autopilot, name):
            denominator = polynomials.multiply(denominator, _chain(autopilot, name)[1])
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

    It stands over the denominator of the plant times s, if there is an integrator, and times those
    of all filters.
    """
    integrators = int(np.any(np.asarray(autopilot.integral_gain)))
    gains = [autopilot.rate_gain, autopilot.attitude_gain, autopilot.integral_gain]
    on_angle = np.asarray(autopilot.alpha_gain)[..., np.newaxis] * np.eye(1, 1 + integrators)[0]
    angle = polynomials.multiply(on_angle, plant.numerator("angle_of_attack", source))
    on_attitude = np.stack(np.broadcast_arrays(*gains[: 2 + integrators]), axis=-1)
    if autopilot.attitude_filters or autopilot.rate_filters:
        # (a1 s F_r + (a0 + aI/s) F_a) theta + b0 alpha over the denominators of both filters
        (above_a, below_a), (above_r, below_r) = (_chain(autopilot, name) for name in CHAINS[:2])
        rate = polynomials.multiply(on_attitude[..., :1], np.eye(1, 2 + integrators)[0])
        rate = polynomials.multiply(polynomials.multiply(rate, above_r), below_a)
        rest = polynomials.multiply(polynomials.multiply(on_attitude[..., 1:], above_a), below_r)
        on_attitude = polynomials.add(rate, rest)
        angle = polynomials.multiply(angle, polynomials.multiply(below_a, below_r))
    attitude = polynomials.multiply(on_attitude, plant.numerator("attitude", source))
    asked = polynomials.add(attitude, angle)
    if autopilot.filters:
        asked = polynomials.multiply(asked, _chain(autopilot, "filters")[0])
    return asked, integrators


def _chain(autopilot: Feedback, name: str) -> tuple[FloatArray, FloatArray]:
    """Numerator and denominator of a chain of filters."""
    above, below = np.ones(1), np.ones(1)
    for one in getattr(autopilot, name):
        above = polynomials.multiply(above, one.numerator)
        below = polynomials.multiply(below, one.denominator)
    return above, below


def _engine(autopilot: Feedback) -> tuple[FloatArray, FloatArray]:
    if autopilot.actuator is None:
        return np.ones(1), np.ones(1)
    below = autopilot.actuator.denominator
    return below[..., -1:], below
