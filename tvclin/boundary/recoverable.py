"""Which states a limited deflection can still bring back: the recoverable set.

Each unstable mode of a plant has a coordinate z, a sum of its states scaled such that

    z' = s (z - u - k alpha_w),    u = deflection/B,    |u| <= D = limit/B,

s being the pole and k the strength of the wind in it. Without wind one mode is recoverable when
|z| < D; two real modes are recoverable together when they lie between the two paths that end at
rest with one switch of the full deflection. Outside, nothing helps any more.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, instance, single
from tvclin.kernels.choice import run
from tvclin.kernels.control_laws import REACH_COMPILED, REACH_PLAIN, minimum_reaches, slow_edges
from tvclin.linear.modes import left_eigenvector, poles_text, unstable_poles
from tvclin.linear.plant import PLANT_HINT, Plant

MOST_MODES = 2
"""Unstable modes for which the set is known in closed form."""


@dataclass(frozen=True, eq=False)
class UnstableCoordinates:
    """The coordinates of the unstable modes of one plant, the fastest first.

    `poles`: s [1/s], ``(N,)``, N being one or two. `rows`: z = rows @ states [rad], ``(N, n)``.
    `wind`: k, ``(N,)``: the report's K1 of each pole.
    """

    poles: FloatArray
    rows: FloatArray
    wind: FloatArray

    @cached_property
    def ratio(self) -> float:
        """Ratio of the slow pole to the fast one; zero with a single pole."""
        return float(self.poles[1] / self.poles[0]) if self.poles.size > 1 else 0.0

    def inside(self, z: FloatArray, reach: Any) -> Any:
        """Return whether the coordinates ``(..., N)`` are recoverable with |u| < reach ``(...)``.

        Strictly: on the edge the deflection keeps the state constant and cannot return it.
        """
        first = np.abs(z[..., 0]) < reach
        if self.poles.size == 1:
            return first
        low, high = self.slow_range(z[..., 0], reach)
        return first & (low < z[..., 1]) & (z[..., 1] < high)

    def slow_range(self, fast: Any, reach: Any) -> tuple[Any, Any]:
        """Return both ends [rad] of the slow coordinate's range at a fast one, |fast| <= reach."""
        low, high = slow_edges(np.clip(fast / reach, -1.0, 1.0), self.ratio)
        return reach * low, reach * high


def unstable_coordinates(plant: Plant) -> UnstableCoordinates:
    """Return the coordinates of the unstable modes of a plant.

    `plant`: one plant with one or two real unstable poles. `InputError` for a batch, a plant
    without an unstable pole, and one with more than two or a pair.

    Examples
    --------
    >>> import tvclin as tv
    >>> from tvclin.boundary.recoverable import unstable_coordinates
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> unstable_coordinates(plant).rows  # attitude + rate/(p + damping), here without damping
    array([[1., 2.]])
    """
    instance("plant", plant, Plant, PLANT_HINT)
    single("plant", plant.batch)
    poles = unstable_poles(plant)
    if not poles.size or np.iscomplexobj(poles) or poles.size > MOST_MODES:
        raise InputError(
            "plant must have one or two real unstable poles, as the models fixed-path, drift and"
            f" mostly drift-exact of an unstable vehicle have; {plant.model} has here:"
            f" {poles_text(poles)}"
        )
    # With l A = s l, z = c l x obeys z' = s z + c (l b) delta + c (l w) alpha_w. c (l b) = -s/B
    # makes that s (z - delta/B - k alpha_w), k = -c (l w)/s.
    A, inputs, _, _ = plant.matrices()
    rows = left_eigenvector(np.broadcast_to(A, (poles.size, *A.shape)), poles)[1]
    scaled = np.array(
        [
            row * (-pole / plant.coefficients.B) / (row @ inputs[:, 0])
            for row, pole in zip(rows, poles, strict=True)
        ]
    )
    return UnstableCoordinates(poles, scaled, -(scaled @ inputs[:, 1]) / poles)


def least_reach(fast: FloatArray, slow: FloatArray, ratio: FloatArray) -> FloatArray:
    """Return the reach [rad] on whose edge the coordinates of two real modes lie.

    It is the least peak of u = deflection/B that brings them to equilibrium, ``(n,)``.

    `fast`, `slow`: coordinates z of the two modes [rad], ``(n,)`` each. `ratio`: the slow pole over
    the fast one, in (0, 1), ``(n,)``.
    """
    reaches = np.empty(fast.size)
    columns = [np.require(values, float, ["C", "W"]) for values in (fast, slow, ratio)]
    count = reaches.size
    run(minimum_reaches, (*columns, reaches), count, REACH_PLAIN * count, REACH_COMPILED * count)
    return reaches
