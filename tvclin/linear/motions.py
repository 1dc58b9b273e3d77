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
from numpy.typing import NDArray

from tvclin.base.errors import InputError, broadcast
from tvclin.vehicle.structure import SloshTank, Structure
from tvclin.vehicle.vehicle import Vehicle

FloatArray = NDArray[np.float64]

_LEAST = 1e-12
"""Of the eigenvalues of a mass matrix scaled to a diagonal of about one; rounding leaves 1e-15."""


@dataclass(frozen=True, eq=False)
class Motions:
    """Accelerations q'' per unit of everything they follow, solved for: M is divided out.

    Attributes
    ----------
    displacement, rate : ndarray
        Per amplitude and per its rate, -K/M and -C/M, ``(..., n, n)``.
    deflection, deflection_acceleration, angle_of_attack : ndarray
        Per angle [rad], and per its second derivative, ``(..., n)``.
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

    Raises
    ------
    InputError
        Where the mass matrix is not positive definite, and for a pendulum that nothing pulls
        straight.
    """
    batch = broadcast(vehicle=vehicle.batch, structure=structure.batch)
    v, modes, tanks = vehicle, structure.bending, structure.slosh
    bodies = 2 + len(modes)
    n = bodies + len(tanks)
    a = axial_acceleration(v)

    def row(*values: Any) -> FloatArray:
        """What all motions have in common; the liquids have nothing of it."""
        rest = (0.0,) * (n - len(values))
        return np.stack(np.broadcast_arrays(*values, *rest, np.zeros(batch))[:-1], axis=-1)

    # Displacements and slopes at the gimbal, x = -l_c, and displacements at the centre of pressure.
    phi = row(1.0, -np.asarray(v.control_arm), *(mode.gimbal_displacement for mode in modes))
    sigma = row(0.0, 1.0, *(mode.gimbal_slope for mode in modes))
    pressed = row(1.0, v.aerodynamic_arm, *(mode.pressure_displacement for mode in modes))

    mass, stiffness = np.zeros((*batch, n, n)), np.zeros((*batch, n, n))
    inertias = row(v.mass, v.moment_of_inertia, *(b.modal_mass for b in modes), *_masses(tanks))
    own = row(
        0.0, 0.0, *(mode.frequency for mode in modes), *(_frequency(tank, a) for tank in tanks)
    )
    rubbing = row(0.0, 0.0, *(body.damping for body in (*modes, *tanks)))
    each = np.arange(n)
    mass[..., each, each] = inertias
    stiffness[..., each, each] = own**2 * inertias
    damping = 2.0 * rubbing * own * inertias

    # A tank at x_j: M[b,j] = m_j phi_b(x_j) and K[b,j] = -m_j a sigma_b(x_j), both symmetric.
    for k, tank in enumerate(tanks):
        j = bodies + k
        at = row(1.0, tank.station, *(_at(mode.tank_displacements, k) for mode in modes))
        slopes = row(0.0, 1.0, *(_at(mode.tank_slopes, k) for mode in modes))
        liquid = np.asarray(tank.mass)[..., np.newaxis]
        pull = -np.asarray(tank.mass * a)[..., np.newaxis]
        for matrix, terms in ((mass, liquid * at), (stiffness, pull * slopes)):
            matrix[..., :bodies, j] = matrix[..., j, :bodies] = terms[..., :bodies]

    # The body axis turns T - F_A; a following thrust turns with the bent gimbal, and moves with it.
    stiffness[..., 0, 1] -= v.thrust - v.axial_force
    if structure.thrust_follows:
        T, l_c = (np.asarray(one)[..., np.newaxis] for one in (v.thrust, v.control_arm))
        bent, moved = sigma[..., 2:bodies], phi[..., 2:bodies]
        stiffness[..., 0, 2:bodies] -= T * bent
        stiffness[..., 1, 2:bodies] += T * (l_c * bent + moved)

    # The control force, and what a swinging engine adds: s_E = m_E l_E, J_E = I_E + m_E l_E^2,
    #   T_c phi_b delta + (s_E phi_b - J_E sigma_b) delta'' - s_E a sigma_b delta.
    deflection = np.asarray(v.control_force)[..., np.newaxis] * phi
    swinging = np.zeros_like(phi)
    if structure.engine is not None:
        s_E, J_E = structure.engine.static_moment, structure.engine.inertia_about_gimbal
        swinging = np.asarray(s_E)[..., np.newaxis] * phi - np.asarray(J_E)[..., np.newaxis] * sigma
        deflection = deflection - np.asarray(s_E * a)[..., np.newaxis] * sigma
        # Its kinetic energy: -swinging is the mass that the deflection shares with each motion.
        whole = np.zeros((*batch, n + 1, n + 1))
        whole[..., :n, :n] = mass
        whole[..., :n, n] = whole[..., n, :n] = -swinging
        whole[..., n, n] = J_E
        _scale(whole)
    air = np.asarray(v.normal_force_slope)[..., np.newaxis] * pressed

    scale = _scale(mass)
    known = np.concatenate(
        [
            -stiffness,
            -damping[..., np.newaxis] * np.eye(n),
            *(force[..., np.newaxis] for force in (deflection, swinging, air)),
        ],
        axis=-1,
    )
    outer = scale[..., :, np.newaxis]
    found = outer * np.linalg.solve(outer * mass * scale[..., np.newaxis, :], outer * known)
    return Motions(
        found[..., :n], found[..., n : 2 * n], *(found[..., 2 * n + k] for k in range(3))
    )


def _masses(tanks: tuple[SloshTank, ...]) -> tuple[Any, ...]:
    return tuple(tank.mass for tank in tanks)


def _at(values: tuple[Any, ...], k: int) -> Any:
    return values[k] if values else 0.0


def _frequency(tank: SloshTank, a: Any) -> Any:
    if tank.pendulum_length is None:
        return tank.frequency
    if np.any(np.asarray(a) <= 0.0):
        raise InputError(
            "a pendulum_length needs a thrust above the axial force, which pulls the pendulum"
            " straight; give the tank a frequency"
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
