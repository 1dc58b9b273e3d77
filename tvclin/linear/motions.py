"""The equations of motion of a flexible vehicle: M q'' + C q' + K q = forces.

The amplitudes are q = (z, theta, eta_1, .., zeta_1, ..): translation, rotation, bending modes, and
the displacements of the liquids in their tanks. A body motion b has a displacement phi_b(x) and a
slope sigma_b(x) at the station x forward of the centre of gravity: 1 and 0, x and 1, or those of
its mode. docs/flexible.md derives the terms.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, broadcast
from tvclin.vehicle.structure import SloshTank, Structure
from tvclin.vehicle.vehicle import Vehicle

_MIN_MASS_EIGENVALUE = 1e-12
"""Smallest eigenvalue of a mass matrix scaled to a unit diagonal; rounding is 1e-15."""
_Rows = Callable[..., FloatArray]


@dataclass(frozen=True, eq=False)
class Motions:
    """Accelerations q'' per unit of states and inputs: the equations divided by M.

    `displacement`, `rate`: per amplitude and per its rate, -K/M and -C/M, ``(..., n, n)``.
    `deflection`, `deflection_acceleration`, `angle_of_attack`: per angle [rad], and per its second
    derivative, ``(..., n)``.
    """

    displacement: FloatArray
    rate: FloatArray
    deflection: FloatArray
    deflection_acceleration: FloatArray
    angle_of_attack: FloatArray


def axial_acceleration(vehicle: Vehicle) -> Any:
    """Return a = (T - F_A)/m of a vehicle [m/s^2], ``(...)``, without gravity.

    Liquid and structure do not feel gravity in flight.
    """
    return (vehicle.thrust - vehicle.axial_force) / vehicle.mass


def motions(vehicle: Vehicle, structure: Structure) -> Motions:
    """Return the accelerations per state and input of a vehicle with its structure.

    From M q'' + C q' + K q = forces, with mass, damping and stiffness matrix, of the amplitudes q:
    translation, rotation, bending modes and liquids. The air acts at the centre of pressure, with
    the normal force slope N [N/rad] times the displacement of each motion there. Batches of both
    broadcast. `InputError` where the mass matrix is not positive definite, and for a pendulum
    without a positive axial acceleration.
    """
    shape = broadcast(vehicle=vehicle.batch, structure=structure.batch)
    rows = partial(_amplitude_row, shape, structure)
    mass, damping, stiffness = _mass_damping_stiffness(vehicle, structure, rows)
    per_deflection, per_acceleration = _engine_forces(vehicle, structure, rows, mass)
    modes = structure.bending
    # at the centre of pressure, for a unit of translation, rotation and each mode
    displacements = rows(1.0, vehicle.aerodynamic_arm, *(b.pressure_displacement for b in modes))
    slope = rows(vehicle.normal_force_slope)[..., :1]  # N with the batch axes, ``(..., 1)``
    # forces per deflection, per its second derivative and per angle of attack
    per_input = (per_deflection, per_acceleration, slope * displacements)
    forces = [force[..., np.newaxis] for force in per_input]
    scale = _diagonal_scaling(mass)[..., np.newaxis]  # S: (S M S) x = S f, q'' = S x
    right_hand_side = scale * np.concatenate([-stiffness, -damping, *forces], axis=-1)
    accelerations = scale * np.linalg.solve(
        scale * mass * np.swapaxes(scale, -1, -2), right_hand_side
    )
    n = mass.shape[-1]
    return Motions(
        displacement=accelerations[..., :n],
        rate=accelerations[..., n : 2 * n],
        deflection=accelerations[..., 2 * n],
        deflection_acceleration=accelerations[..., 2 * n + 1],
        angle_of_attack=accelerations[..., 2 * n + 2],
    )


def _amplitude_row(shape: tuple[int, ...], structure: Structure, *values: Any) -> FloatArray:
    """Return the row ``(..., n)`` of numbers, one for each motion; the last may be omitted.

    `shape`: leading axes. `values`: of translation, rotation, bending modes, then liquids; omitted
    ones are zero.
    """
    row = np.zeros((*shape, 2 + len(structure.bending) + len(structure.slosh)))
    for k, value in enumerate(values):
        row[..., k] = value
    return row


def _mass_damping_stiffness(
    v: Vehicle, structure: Structure, rows: _Rows
) -> tuple[FloatArray, ...]:
    """Return the matrices M, C and K of the amplitudes, ``(..., n, n)``, K with the axial forces.

    In M a liquid j of mass m_j shares the motion of its station, m_j phi_b, with the displacement
    phi_b there of the motion b; in K its weight under the axial acceleration a turns the vehicle,
    -m_j a sigma_b, with the slope sigma_b there, and the axial forces turn with the body.

    `v`, `structure`: vehicle and structure. `rows`: `_amplitude_row` of their shape.
    """
    modes, tanks = structure.bending, structure.slosh
    bodies = 2 + len(modes)  # translation, rotation and modes
    a = axial_acceleration(v)
    inertias = rows(
        v.mass,
        v.moment_of_inertia,
        *(mode.modal_mass for mode in modes),
        *(tank.mass for tank in tanks),
    )
    frequency = rows(
        0.0, 0.0, *(mode.frequency for mode in modes), *(tank_frequency(tank, a) for tank in tanks)
    )
    zeta = rows(0.0, 0.0, *(mode.damping for mode in modes), *(tank.damping for tank in tanks))
    diagonal = np.eye(bodies + len(tanks))
    mass = inertias[..., np.newaxis] * diagonal
    damping_terms = 2.0 * zeta * frequency * inertias + rows(0.0, v.pitch_damping)
    damping = damping_terms[..., np.newaxis] * diagonal
    stiffness = (frequency**2 * inertias)[..., np.newaxis] * diagonal
    # A tank at x_j: M[b,j] = m_j phi_b(x_j) and K[b,j] = -m_j a sigma_b(x_j), both symmetric.
    for k, tank in enumerate(tanks):
        phi = rows(1.0, tank.station, *(_tank_value(mode.tank_displacements, k) for mode in modes))
        sigma = rows(0.0, 1.0, *(_tank_value(mode.tank_slopes, k) for mode in modes))
        for matrix, factor, row in ((mass, tank.mass, phi), (stiffness, -tank.mass * a, sigma)):
            coupling = rows(*(factor * row[..., b] for b in range(bodies)))[..., :bodies]
            matrix[..., :bodies, bodies + k] = matrix[..., bodies + k, :bodies] = coupling
    # Forces on translation 0 and moments on rotation 1: the body axis turns T - F_A; a following
    # thrust turns with the bent gimbal, and acts there.
    stiffness[..., 0, 1] -= v.thrust - v.axial_force
    for b, mode in enumerate(modes if structure.thrust_follows else (), start=2):
        moment_arm = v.control_arm * mode.gimbal_slope + mode.gimbal_displacement
        stiffness[..., 0, b] -= v.thrust * mode.gimbal_slope
        stiffness[..., 1, b] += v.thrust * moment_arm
    return mass, damping, stiffness


def _engine_forces(
    v: Vehicle, structure: Structure, rows: _Rows, mass: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the forces per deflection and per its second derivative, ``(..., n)`` each.

    T_c phi_b delta + (s_E phi_b - J_E sigma_b) delta'' - s_E a sigma_b delta, on the motion b with
    displacement phi_b and slope sigma_b at the gimbal: T_c control force per angle [N/rad], a axial
    acceleration, s_E = m_E l_E static moment and J_E = I_E + m_E l_E^2 inertia of the engine about
    the gimbal. `v`, `structure`: vehicle and structure. `rows`: `_amplitude_row` of their shape.
    `mass`: mass matrix, ``(..., n, n)``; `InputError` unless it is positive definite with the
    engine's.
    """
    modes, engine = structure.bending, structure.engine
    # of translation, rotation about the centre of gravity, the control arm ahead, and modes
    phi = [1.0, -v.control_arm, *(mode.gimbal_displacement for mode in modes)]
    sigma = [0.0, 1.0, *(mode.gimbal_slope for mode in modes)]
    deflection = rows(*(v.control_force * displacement for displacement in phi))
    if engine is None:
        return deflection, rows()
    s, J = engine.static_moment, engine.inertia_about_gimbal
    a = axial_acceleration(v)
    deflection -= rows(*(s * a * slope for slope in sigma))
    inertia_forces = rows(
        *(s * displacement - J * slope for displacement, slope in zip(phi, sigma, strict=True))
    )
    # the mass matrix of vehicle and engine, delta being one more motion: checked, not returned
    coupling = inertia_forces[..., np.newaxis]
    inertia = rows(J)[..., :1, np.newaxis]
    _diagonal_scaling(np.block([[mass, -coupling], [-np.swapaxes(coupling, -1, -2), inertia]]))
    return deflection, inertia_forces


def _tank_value(values: tuple[Any, ...], k: int) -> Any:
    """Return displacement or slope of a mode at tank k, of its `values` by tank; zero without."""
    return values[k] if values else 0.0


def tank_frequency(tank: SloshTank, a: Any) -> Any:
    """Return the natural frequency of a tank [rad/s]: specified, or of a pendulum sqrt(a/L).

    `a`: axial acceleration [m/s^2], ``(...)``.
    """
    if tank.pendulum_length is None:
        return tank.frequency
    if np.any(np.asarray(a) <= 0.0):
        raise InputError(
            "a pendulum_length needs a thrust above the axial force, whose difference"
            " accelerates the tank; give the tank a frequency"
        )
    return np.sqrt(a / tank.pendulum_length)


def _diagonal_scaling(mass: FloatArray) -> FloatArray:
    """Return powers of two ``(..., n)`` that scale a mass matrix to a diagonal of about one.

    `mass`: M, ``(..., n, n)``. `InputError` for one that is not positive definite.
    """
    diagonal = np.diagonal(mass, axis1=-2, axis2=-1)
    scale = 2.0 ** -np.round(0.5 * np.log2(diagonal))  # of both rows and columns
    eigenvalues = np.linalg.eigvalsh(scale[..., :, np.newaxis] * mass * scale[..., np.newaxis, :])
    if np.any(eigenvalues <= _MIN_MASS_EIGENVALUE):
        raise InputError(
            "slosh and engine weigh more than the vehicle: the mass matrix is not positive definite"
            " (weight and moment_of_inertia are those of the whole, liquid and engine included)"
        )
    return scale
