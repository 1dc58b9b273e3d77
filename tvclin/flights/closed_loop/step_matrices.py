"""What a sample does to vehicle and nozzle, and what sensors see: the matrices of the kernel."""

from __future__ import annotations

import numpy as np

from tvclin.base.arrays import FloatArray, IntArray
from tvclin.control.autopilot.actuator import INPUTS, Actuator
from tvclin.linear.system import LinearSystem, connect, polynomial_input
from tvclin.numerics.state_space import beside

COARSE = 0.5 + 1e-9
"""Samples of a law are steps of the hardware up to this part of 1/omega of its actuator."""
SUBSTEPS = 8.0
"""Substeps in the time 1/omega, where samples are further apart."""


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

    `frequencies`: of the nozzles [rad/s], ``(p,)``. `lengths`: of a step and its parts [s], ``(p, 1
    + parts)``.
    """
    turns = frequencies[:, np.newaxis] * lengths
    wanted = np.maximum(np.ceil(SUBSTEPS * turns[:, 1:] - 1e-9), 1.0)
    return np.where(turns[:, :1] > COARSE, wanted, 1.0).astype(np.int64)


def joint_steps(moving: LinearSystem, vehicle: int, parts: FloatArray, terms: int) -> FloatArray:
    """Return J of `Flights` for a vehicle with its nozzle, see `plant_with_actuator`.

    The wind goes on as the polynomial that it is now.
    """
    steps = connect([moving, polynomial_input("wind", terms)], INPUTS[:1], ()).to_steps(parts.T)
    order = len(moving.states)
    J = beside(steps.A[..., :order], steps.B, steps.A[..., order:])[..., :order, :]
    if order == vehicle:
        # Without a nozzle the deflection is a state all the same: at its command at once.
        J = np.insert(np.insert(J, order, 0.0, axis=-1), order, 0.0, axis=-2)
        J[..., order, order + 1] = 1.0
    return np.ascontiguousarray(np.swapaxes(J, 0, 1))


def even_steps(plant: LinearSystem, parts: FloatArray) -> FloatArray:
    """Return the ramp of `Flights`, of a plant whose deflection goes evenly from a to b in a part.

    As a polynomial it is a + (b - a) t/h.
    """
    n, span = len(plant.states), np.where(parts > 0.0, parts, 1.0)[..., np.newaxis]
    moved = connect([plant, polynomial_input("deflection", 2)], (), ()).to_steps(parts.T).A
    free, rise = (np.swapaxes(moved[..., :n, k], 0, 1) for k in (slice(n), n + 1))
    start, rise, kick = np.swapaxes(moved[..., :n, n], 0, 1), rise / span, []
    if "deflection_acceleration" in plant.inputs:
        # x+ = .. + e^(A h) b3 (v - before) + b3 (after - v), v the even rate of the part
        b3 = np.broadcast_to(plant.B[:, np.newaxis, :, 2], rise.shape)
        later = (free @ b3[..., np.newaxis])[..., 0]
        rise, kick = rise + (later - b3) / span, [-later, b3]
    return np.stack([start - rise, rise, *kick], axis=-1)


def sensed_rows(plant: LinearSystem) -> FloatArray:
    """Return attitude, rate, path and angle of attack as sensors give them, of states and wind."""
    n, rows = len(plant.states), np.zeros((len(plant.C), 4, len(plant.states) + 1))
    places = {name: k for k, name in enumerate(plant.outputs)}
    for row, name in enumerate(
        ("attitude", "attitude_rate", "flight_path_angle", "angle_of_attack")
    ):
        k = places.get(f"sensed_{name}", places.get(name))
        if k is not None:
            rows[:, row, :n], rows[:, row, n] = plant.C[:, k], plant.D[:, k, 1]
    return rows
