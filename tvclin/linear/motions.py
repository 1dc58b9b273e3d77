"""The equations of motion of a flexible vehicle: M q'' + C q' + K q = forces.

The amplitudes are q = (z, theta, eta_1, .., zeta_1, ..): translation, rotation, bending modes, and
the displacements of the liquids in their tanks. A body motion b has a displacement phi_b(x) and a
slope sigma_b(x) at the station x forward of the centre of gravity: 1 and 0, x and 1, or those of
its mode. docs/flexible.md derives the terms.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, broadcast
from tvclin.vehicle.structure import SloshTank, Structure
from tvclin.vehicle.vehicle import Vehicle

_LEAST = 1e-12
"""Of the eigenvalues of a mass matrix scaled to a diagonal of about one; rounding leaves 1e-15."""


@dataclass(frozen=True, eq=False)
class Motions:
    """Accelerations q'' per unit of everything they follow, solved for: M is divided out.

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
    """Return a = (T - F_A)/m [m/s^2], without gravity, which liquid and structure do not feel."""
    return (vehicle.thrust - vehicle.axial_force) / vehicle.mass


def motions(vehicle: Vehicle, structure: Structure) -> Motions:
    """Return the motions of a vehicle and its structure, which broadcast.

    `InputError` where the mass matrix is not positive definite, and for a pendulum that nothing
    pulls straight.
    """
    shape = broadcast(vehicle=vehicle.batch, structure=structure.batch)
    rows = _Rows(shape, 2 + len(structure.bending), len(structure.slosh))
    mass, damping, stiffness = _matrices(vehicle, structure, rows)
    deflection, swinging = _engine(vehicle, structure, rows, mass)
    modes = structure.bending
    pressed = rows.of(1.0, vehicle.aerodynamic_arm, *(b.pressure_displacement for b in modes))
    air = rows.of(vehicle.normal_force_slope)[..., :1] * pressed
    forces = [one[..., np.newaxis] for one in (deflection, swinging, air)]
    scale = _scale(mass)[..., np.newaxis]
    known = scale * np.concatenate([-stiffness, -damping, *forces], axis=-1)
    found = scale * np.linalg.solve(scale * mass * np.swapaxes(scale, -1, -2), known)
    n = mass.shape[-1]
    return Motions(
        found[..., :n], found[..., n : 2 * n], *(found[..., 2 * n + k] for k in range(3))
    )


@dataclass(frozen=True)
class _Rows:
    """How the numbers of all motions stand in a row ``(..., n)``: the bodies, then the liquids."""

    batch: tuple[int, ...]
    bodies: int
    tanks: int

    def of(self, *values: Any) -> FloatArray:
        """Return the row that begins with these values, and goes on with zeros."""
        found = np.zeros((*self.batch, self.bodies + self.tanks))
        for k, value in enumerate(values):
            found[..., k] = value
        return found


def _matrices(v: Vehicle, structure: Structure, rows: _Rows) -> tuple[FloatArray, ...]:
    """M, C and K, the latter with the axial forces."""
    modes, tanks, bodies = structure.bending, structure.slosh, rows.bodies
    a = axial_acceleration(v)
    inertias = rows.of(
        v.mass,
        v.moment_of_inertia,
        *(mode.modal_mass for mode in modes),
        *(tank.mass for tank in tanks),
    )
    own = rows.of(
        0.0, 0.0, *(mode.frequency for mode in modes), *(_frequency(tank, a) for tank in tanks)
    )
    zeta = rows.of(0.0, 0.0, *(mode.damping for mode in modes), *(tank.damping for tank in tanks))
    diagonal = np.eye(bodies + rows.tanks)
    mass = inertias[..., np.newaxis] * diagonal
    lossy = 2.0 * zeta * own * inertias + rows.of(0.0, v.pitch_damping)
    damping = lossy[..., np.newaxis] * diagonal
    stiffness = (own**2 * inertias)[..., np.newaxis] * diagonal
    # A tank at x_j: M[b,j] = m_j phi_b(x_j) and K[b,j] = -m_j a sigma_b(x_j), both symmetric.
    for k, tank in enumerate(tanks):
        phi = rows.of(1.0, tank.station, *(_at(mode.tank_displacements, k) for mode in modes))
        sigma = rows.of(0.0, 1.0, *(_at(mode.tank_slopes, k) for mode in modes))
        for matrix, factor, row in ((mass, tank.mass, phi), (stiffness, -tank.mass * a, sigma)):
            shared = rows.of(*(factor * row[..., b] for b in range(bodies)))[..., :bodies]
            matrix[..., :bodies, bodies + k] = matrix[..., bodies + k, :bodies] = shared
    # The body axis turns T - F_A; a following thrust turns with the bent gimbal, and acts there.
    stiffness[..., 0, 1] -= v.thrust - v.axial_force
    for b, mode in enumerate(modes if structure.thrust_follows else (), start=2):
        moved = v.control_arm * mode.gimbal_slope + mode.gimbal_displacement
        stiffness[..., 0, b] -= v.thrust * mode.gimbal_slope
        stiffness[..., 1, b] += v.thrust * moved
    return mass, damping, stiffness


def _engine(
    v: Vehicle, structure: Structure, rows: _Rows, mass: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Forces per deflection and per its second derivative, at x = -l_c.

    T_c phi_b delta + (s_E phi_b - J_E sigma_b) delta'' - s_E a sigma_b delta,
    s_E = m_E l_E,    J_E = I_E + m_E l_E^2
    """
    modes, engine = structure.bending, structure.engine
    phi = [1.0, -v.control_arm, *(mode.gimbal_displacement for mode in modes)]
    sigma = [0.0, 1.0, *(mode.gimbal_slope for mode in modes)]
    deflection = rows.of(*(v.control_force * one for one in phi))
    if engine is None:
        return deflection, rows.of()
    s, J = engine.static_moment, engine.inertia_about_gimbal
    a = axial_acceleration(v)
    deflection -= rows.of(*(s * a * one for one in sigma))
    swinging = rows.of(*(s * up - J * turn for up, turn in zip(phi, sigma, strict=True)))
    # The kinetic energy of vehicle and engine, with delta' as a motion of its own.
    side = swinging[..., np.newaxis]
    corner = rows.of(J)[..., :1, np.newaxis]
    _scale(np.block([[mass, -side], [-np.swapaxes(side, -1, -2), corner]]))
    return deflection, swinging


def _at(values: tuple[Any, ...], k: int) -> Any:
    return values[k] if values else 0.0


def _frequency(tank: SloshTank, a: Any) -> Any:
    if tank.pendulum_length is None:
        return tank.frequency
    if np.any(np.asarray(a) <= 0.0):
        raise InputError(
            "a pendulum_length needs a thrust above the axial force, whose difference"
            " accelerates the tank; give the tank a frequency"
        )
    return np.sqrt(a / tank.pendulum_length)


def _scale(mass: FloatArray) -> FloatArray:
    """Return powers of two that bring the diagonal to about one; refuse what is not positive."""
    diagonal = np.diagonal(mass, axis1=-2, axis2=-1)
    scale = 2.0 ** -np.round(0.5 * np.log2(diagonal))
    least = np.linalg.eigvalsh(scale[..., :, np.newaxis] * mass * scale[..., np.newaxis, :])
    if np.any(least <= _LEAST):
        raise InputError(
            "slosh and engine weigh more than the vehicle: the mass matrix is not positive definite"
            " (weight and moment_of_inertia are those of the whole, liquid and engine included)"
        )
    return scale
