"""A law in both planes: the scalar law along the measured wind and across it, within one limit.

Vectors are complex, pitch + j yaw. They are rotated into the direction of the wind, so that a
nonlinear law leans with the wind; a linear law is the same in every direction.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.errors import InputError, instance, one_of
from tvclin.boundary.limit_shapes import LimitShape, PolygonShape, Vectors, limit_shape_of
from tvclin.control.laws.law import Law, Measurement

SATURATE = ("radial", "each plane")


@dataclass(frozen=True)
class LawInPlanes:
    """Law for both planes, and the saturation of its demand.

    `law`: one law. `limit_shape`: that of the nozzle. `saturate`: "radial" if the limited demand
    keeps its direction, "each plane" if each component is limited by the largest rectangle within
    the shape. `InputError` for another type than a law, a law that switches, has filters or noise,
    and unknown words.
    """

    law: Law
    limit_shape: LimitShape | str = "round"
    saturate: str = "radial"

    def __post_init__(self) -> None:
        law = self.law
        instance("law", law, Law, "such as TrimLaw")
        if (law.engage, law.release) != (1.0, 1.0):
            raise InputError("law must not switch to the whole limit: that has one direction only")
        if any(law.chains) or law.rate_noise[0]:
            raise InputError("law must be without filters and noise in two planes")
        one_of("saturate", self.saturate, SATURATE)

    @property
    def radial(self) -> bool:
        """Whether the limited demand keeps its direction."""
        return self.saturate == "radial"

    @cached_property
    def shape(self) -> LimitShape:
        """Limit shape, of unit limit."""
        limit_shape = limit_shape_of(self.limit_shape).inside
        return limit_shape if self.radial else limit_shape.each_plane()

    @cached_property
    def plane_limits(self) -> FloatArray:
        """Largest pitch and yaw deflection of the limit shape, ``(2,)``."""
        shape = self.shape
        if isinstance(shape, PolygonShape):
            return np.array([np.abs(shape.corners.real).max(), np.abs(shape.corners.imag).max()])
        return shape.support(np.array([1.0, -1.0, 1j, -1j])).reshape(2, 2).max(axis=1)

    def demand(self, measured: Vectors, states: Vectors, limit: FloatArray) -> Vectors:
        """Return the demanded deflections [rad], before the limit, ``(m,)``.

        `measured`: measurements of both planes in the order of `Measurement`, ``(m, 8)``. `states`:
        states of the law, ``(m, k)``. `limit`: scale [rad] of the limit shape, ``(m,)``.
        """
        if not self.radial:
            limits = [limit * plane_limit for plane_limit in self.plane_limits]
            return self._by_components(measured, states, limits)
        estimates = getattr(self.law, "estimator", None) is not None
        wind = states[:, 1] if estimates else measured[:, 0] - measured[:, 3]
        wind = wind - measured[:, 2]
        size = np.abs(wind)
        direction = np.where(size > 0.0, wind / np.where(size > 0.0, size, 1.0), 1.0)
        shape, rotation = self.shape, np.conj(direction)[:, np.newaxis]
        limits = [
            limit / np.maximum(shape.gauge(axis), shape.gauge(-axis))
            for axis in (direction, 1j * direction)
        ]
        along = self._by_components(measured * rotation, states * rotation, limits)
        return np.asarray(direction * along)

    def limited(self, demand: Vectors, limit: FloatArray) -> tuple[Vectors, BoolArray]:
        """Return the limited demand [rad] and whether it is on the limit, both ``(m,)``."""
        if self.radial:
            with np.errstate(over="ignore"):  # the limit may be the smallest positive number
                ratio = self.shape.gauge(demand) / limit
            return demand / np.maximum(ratio, 1.0), ratio >= 1.0
        bounds = self.plane_limits[:, np.newaxis] * limit
        components = np.stack([demand.real, demand.imag])
        limited = np.clip(components, -bounds, bounds)
        return limited[0] + 1j * limited[1], np.any(np.abs(components) >= bounds, axis=0)

    def _by_components(
        self, measured: Vectors, states: Vectors, limits: list[FloatArray]
    ) -> Vectors:
        """Return the demand of the scalar law on real and imaginary components [rad], ``(m,)``."""
        real, imaginary = (
            np.asarray(self.law.demand(Measurement(*take(measured).T), take(states).T, limit))
            for take, limit in zip((np.real, np.imag), limits, strict=True)
        )
        return np.asarray(real + 1j * imaginary)
