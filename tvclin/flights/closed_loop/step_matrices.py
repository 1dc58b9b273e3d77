"""What a sample does to vehicle and nozzle, and what sensors see: the matrices of the kernel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tvclin.control.autopilot.actuator import Actuator
from tvclin.kernels.propagation import driven_steps
from tvclin.kernels.state_space import beside
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.plant import INPUTS
from tvclin.linear.system import delay_parts

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

COARSE = 0.5 + 1e-9
"""Samples of a law are steps of the hardware up to this part of 1/omega of its actuator."""
SUBSTEPS = 8.0
"""Substeps in the time 1/omega, where samples are further apart."""


def parts_of(length: FloatArray, delay: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return samples of delay, and the lengths [s] of a step and its parts, the later first."""
    late, rest = delay_parts(delay, length)
    parts = [length - rest, rest] if np.any(rest) else [length]
    return late.astype(np.int64), np.stack([length, *parts], axis=-1)


def quickness(actuator: Actuator | None) -> FloatArray:
    """Return the bandwidth of a nozzle of first order [1/s], infinite without one, else zero."""
    if actuator is None:
        return np.asarray(np.inf)
    bandwidth = np.asarray(actuator.natural_frequency, dtype=float)
    return bandwidth if actuator.damping is None else np.zeros(actuator.batch)


def frequency(actuator: Actuator | None) -> FloatArray:
    """Return the natural frequency of a nozzle [rad/s], zero without one."""
    return np.zeros(()) if actuator is None else np.asarray(actuator.natural_frequency, float)


def substeps_of(frequencies: FloatArray, lengths: FloatArray) -> IntArray:
    """Return in how many substeps each part ``(p, parts)`` of a step may have to be walked.

    One where the samples of the law are as close as the nozzle needs; more where they are not.

    Parameters
    ----------
    frequencies : ndarray
        Of the nozzles [rad/s], ``(p,)``.
    lengths : ndarray
        Of a step and its parts [s], ``(p, 1 + parts)``.
    """
    turns = frequencies[:, np.newaxis] * lengths
    wanted = np.maximum(np.ceil(SUBSTEPS * turns[:, 1:] - 1e-9), 1.0)
    return np.where(turns[:, :1] > COARSE, wanted, 1.0).astype(np.int64)


def joint_steps(
    A: FloatArray, B: FloatArray, vehicle: int, parts: FloatArray, terms: int
) -> FloatArray:
    """Return J of `Flights`, of a vehicle and its nozzle, which `actuated` has put together.

    d/dt [x, s, c, w0, w1, ...] is linear in these, the wind being w0' = w1, w1' = 2 w2, ..., and J
    the upper rows of the exponential of its matrix.
    """
    command, _, gust = range(B.shape[-1])
    order, given = A.shape[-1], np.zeros((*A.shape[:2], 1 + terms))
    given[..., 0], given[..., 1] = B[..., command], B[..., gust]
    rising = np.diag(np.arange(float(terms)), k=1)  # the command is held
    free, pushed = driven_steps(A, given, parts, rising)
    steps = beside(free, pushed)
    if order > vehicle:
        return steps
    # Without a nozzle the deflection is a state all the same: at its command at once.
    at_once = np.insert(np.insert(steps, order, 0.0, axis=-1), order, 0.0, axis=-2)
    at_once[..., order, order + 1] = 1.0
    return at_once


def even_steps(A: FloatArray, inputs: FloatArray, parts: FloatArray) -> FloatArray:
    """Return the ramp of `Flights`: x' = A x + b d, d going evenly from a to b in h.

    d' = (b - a)/h: what d = 1 does, less what a rise by one does, is the factor of a, and the
    latter that of b.
    """
    turned, slope = inputs[..., 0], np.zeros((*parts.shape, 2, 2))
    span = np.where(parts > 0.0, parts, 1.0)
    slope[..., 0, 1] = 1.0 / span
    given = np.stack([turned, np.zeros_like(turned)], axis=-1)
    free, pushed = driven_steps(A, given, parts, slope)
    rise, kick = pushed[..., 1], []
    if inputs.shape[2] > len(INPUTS):
        # x+ = .. + e^(A h) b3 (v - before) + b3 (after - v), v the even rate of the part
        b3 = np.broadcast_to(inputs[:, np.newaxis, :, 2], rise.shape)
        later = (free @ b3[..., np.newaxis])[..., 0]
        rise = rise + (later - b3) / span[..., np.newaxis]
        kick = [-later, b3]
    return np.stack([pushed[..., 0] - rise, rise, *kick], axis=-1)


def sensed_rows(plant: AnyPlant, C: FloatArray, D: FloatArray) -> FloatArray:
    """Return attitude, rate, path and angle of attack as sensors give them, of states and wind."""
    n, rows = C.shape[-1], np.zeros((len(C), 4, C.shape[-1] + 1))
    places = {name: k for k, name in enumerate(plant.outputs)}
    for row, name in enumerate(
        ("attitude", "attitude_rate", "flight_path_angle", "angle_of_attack")
    ):
        k = places.get(f"sensed_{name}", places.get(name))
        if k is not None:
            rows[:, row, :n], rows[:, row, n] = C[:, k], D[:, k, 1]
    return rows
