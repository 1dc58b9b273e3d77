"""Which pole of a flexible plant belongs to which bending mode and tank."""

from __future__ import annotations

import numpy as np

from tvclin.base.arrays import ComplexArray
from tvclin.linear.flexible import FlexiblePlant
from tvclin.linear.motions import axial_acceleration


def named_modes(plant: FlexiblePlant) -> tuple[tuple[str, ...], ComplexArray]:
    """Return the names of bending modes and tanks, and their poles in the airframe.

    The names are "bending 1", .., "slosh 1", .., as in the structure, and the poles the upper ones
    [1/s], ``(..., n)``; NaN of a mode that does not oscillate.

    Motion together moves the frequencies, and hardly ever changes their order: in it poles and the
    frequencies of the structure are matched. An oscillation of the rigid vehicle is left out.
    """
    structure = plant.structure
    bending = {f"bending {k}": mode.frequency for k, mode in enumerate(structure.bending, start=1)}
    slosh = {}
    for k, tank in enumerate(structure.slosh, start=1):
        own = tank.frequency
        if own is None:
            own = np.sqrt(axial_acceleration(plant.vehicle) / np.asarray(tank.pendulum_length))
        slosh[f"slosh {k}"] = own
    names = (*bending, *slosh)
    given = [np.broadcast_to(f, plant.batch) for f in (*bending.values(), *slosh.values())]
    if not given:
        return (), np.zeros((*plant.batch, 0), dtype=complex)
    poles = np.where(plant.poles.imag > 0.0, plant.poles, np.nan)
    for rigid in np.moveaxis(plant.rigid.poles.astype(complex), -1, 0):
        apart = np.abs(poles - rigid[..., np.newaxis])
        taken = apart <= np.nanmin(np.where(np.isnan(apart), np.inf, apart), -1, keepdims=True)
        surplus = np.sum(~np.isnan(poles), axis=-1, keepdims=True) > len(names)
        oscillates = rigid.imag[..., np.newaxis] > 0.0
        poles = np.where(taken & surplus & oscillates, np.nan, poles)
    order = np.argsort(np.where(np.isnan(poles), np.inf, poles.imag), axis=-1)
    poles = np.take_along_axis(poles, order, axis=-1)[..., : len(names)]
    rank = np.argsort(np.argsort(np.stack(given, axis=-1), axis=-1), axis=-1)
    return names, np.take_along_axis(poles, rank, axis=-1)
