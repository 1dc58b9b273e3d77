"""Linear equations of vehicles over the steps of their winds, at any dynamic pressure.

Normal and axial force go with r = q/q_n, so that A and the columns of deflection and wind are

    [A b w] = E + (r - 1) E_1 + (1/r - 1) E_2,

linear in r but for b1/B of the model drift, where b1 has a part without the air and B has none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.boundary.limit import COMPARABLE, leading_pole
from tvclin.linear.modes import left_eigenvectors, unstable_poles
from tvclin.linear.plant import Plant
from tvclin.requirement.varying_minimum import UnstableModes, unstable_modes_of
from tvclin.vehicle.vehicle import Vehicle, at_pressure

PRESSURES = (1.0, 1.25, 2.0)
"""q/q_n at which equations are computed; three of them determine E, E_1 and E_2."""
_QUICK_PATH_FRACTION = 0.1
"""Fraction of the fastest rate from which on the rate b1 of the path is comparable with it."""


@dataclass(frozen=True, eq=False)
class Equations:
    """Linear equations ``[A b w]`` of vehicles over the steps of their winds.

    Attributes
    ----------
    nominal : ndarray
        E at begin, middle and end of each step, ``(n, S, 3, m, m + 2)``; n or S is one where a
        single entry holds for all.
    slopes : ndarray
        E_1 and E_2 there, ``(n, S, 3, 2, m, m + 2)``.
    end : ndarray
        Costate p and control reach R at the end, ``(n, m + 1)``; NaN without an unstable real mode.
    paired : ndarray of bool
        Whether two unstable modes are a pair there, so that trim must never be limited, of the
        shape of the steps; axes of length one hold for all.
    quick_path : ndarray of bool
        Whether flights of the limited law decide, since b1 is negative, or b1 or a second pole is
        comparable with the fastest, ``(n,)``.
    modes : tuple of UnstableModes
        Those of vehicles with several unstable modes at the end.
    """

    nominal: FloatArray
    slopes: FloatArray
    end: FloatArray
    paired: BoolArray
    quick_path: BoolArray
    modes: tuple[UnstableModes, ...]

    @classmethod
    def frozen(cls, vehicle: Vehicle, model: str, plane: str) -> Self:
        """Return the constant equations of one vehicle, or a batch ``(n,)``, of a model."""
        return cls._of(
            [Plant.from_vehicle(at_pressure(vehicle, r), model, plane) for r in PRESSURES]
        )

    @classmethod
    def of_plant(cls, plant: Plant) -> Self:
        """Return the constant equations of plants at nominal dynamic pressure, one or ``(n,)``."""
        return cls._of([plant] * len(PRESSURES))

    @classmethod
    def _of(cls, plants: Sequence[Plant]) -> Self:
        """Return the constant equations of plants at each of `PRESSURES`."""
        nominal, slopes = (
            x.reshape(-1, 1, 1, *x.shape[x.ndim - k :])
            for x, k in zip(of_pressure(plants), (2, 3), strict=True)
        )
        order = nominal.shape[-2]
        return cls(
            np.repeat(nominal, 3, axis=2),
            np.repeat(slopes, 3, axis=2),
            unstable_end(nominal[:, 0, 0]),
            np.reshape(leading_pole(plants[0])[1], (-1, 1, 1)),
            np.ravel(has_quick_path(plants[0])),
            unstable_modes_of(nominal[:, 0, 0, :, :order], fewest=2),
        )

    def at_steps(self, times: FloatArray) -> Self:
        """Return the equations at times [s] of steps, which are the same at all times."""
        return self

    @property
    def breakpoints(self) -> FloatArray:
        """Breakpoints [s] of the equations, in addition to the breakpoints of the wind: none."""
        return np.empty(0)

    @property
    def drifts(self) -> bool:
        """Whether the flight path takes part in the motion."""
        return self.nominal.shape[-2] > 2

    def of(self, cases: IndexArray) -> Equations:
        """Return the equations of some cases."""

        def some(x: Any) -> Any:
            return x if len(x) == 1 else x[cases]

        modes: tuple[UnstableModes, ...] = ()
        if self.modes:
            last = some(self.nominal)[:, -1, 2, :, : self.nominal.shape[-2]]
            modes = unstable_modes_of(last, fewest=2)
        return Equations(
            some(self.nominal),
            some(self.slopes),
            some(self.end),
            some(self.paired),
            some(self.quick_path),
            modes,
        )

    @property
    def fastest(self) -> FloatArray:
        """Largest rate [1/s] of the attitude of each vehicle, sqrt(mu_alpha) at its largest."""
        stiffness = np.abs(self.nominal[..., 1, 0]).max(axis=(1, 2))
        return np.asarray(np.sqrt(stiffness))

    @property
    def end_pole(self) -> FloatArray:
        """Growth rate p.A p [1/s] at the end of each, the pole of a constant vehicle, ``(n,)``."""
        order = self.nominal.shape[-2]
        costate, A = self.end[:, :order], self.nominal[:, -1, 2, :, :order]
        return np.asarray(np.einsum("ni,nij,nj->n", costate, A, costate))


def has_quick_path(plant: Plant) -> BoolArray:
    """Return whether the path is unstable, or b1 or a second pole comparable with the fastest."""
    poles = unstable_poles(plant)
    if plant.model == "fixed-path" or not poles.shape[-1]:
        return np.zeros(plant.batch, dtype=bool)
    fast, b1 = np.real(poles[..., 0]), np.asarray(plant.coefficients.b1)
    with np.errstate(invalid="ignore"):  # NaN stands for a pole that is not there
        quick = (b1 < 0.0) | (b1 > _QUICK_PATH_FRACTION * fast)
        if poles.shape[-1] > 1:
            quick = quick | (np.real(poles[..., 1]) > COMPARABLE * fast)
    return np.asarray(quick)


def unstable_end(equations: FloatArray) -> FloatArray:
    """Return costate and control reach of constant equations ``(n, m, m + 2)``, ``(n, m + 1)``.

    The costate p is the left eigenvector of the fastest real unstable mode, of length one and with
    a positive part of the attitude rate; the control reach is p.b over the pole. NaN without one.
    """
    order = equations.shape[-2]
    values, rows = left_eigenvectors(equations[..., :order])
    unstable = (np.imag(values) == 0.0) & (np.real(values) > 0.0)
    fastest = np.argmax(unstable, axis=-1)[..., np.newaxis]
    exists = np.any(unstable, axis=-1, keepdims=True)
    pole = np.where(exists, np.real(np.take_along_axis(values, fastest, axis=-1)), np.nan)
    costate = np.real(np.take_along_axis(rows, fastest[..., np.newaxis], axis=-2)[..., 0, :])
    costate = costate * np.where(costate[..., 1:2] < 0.0, -1.0, 1.0)
    reach = np.vecdot(costate, equations[..., order])[..., np.newaxis] / pole
    return np.where(exists, np.concatenate([costate, reach], axis=-1), np.nan)


def of_pressure(plants: Sequence[Plant]) -> tuple[FloatArray, FloatArray]:
    """Return E ``(..., m, m + 2)``, and E_1 and E_2 ``(..., 2, m, m + 2)``, of plants.

    `plants`: the same, at each of `PRESSURES` times their dynamic pressure.
    """
    nominal, *others = (np.concatenate(plant.matrices()[:2], axis=-1) for plant in plants)
    changes = np.stack([other - nominal for other in others], axis=-3)
    factors = np.array([[r - 1.0, 1.0 / r - 1.0] for r in PRESSURES[1:]])
    return nominal, np.einsum("kl,...lij->...kij", np.linalg.inv(factors), changes)
