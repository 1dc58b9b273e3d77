"""A law in both planes: the scalar law along the felt wind and across it, within one stop.

Vectors are complex, pitch + j yaw. Turned into the direction of the wind a law leans with the wind,
and one that is linear in what it sees is the same in every direction.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.errors import InputError, instance, one_of
from tvclin.boundary.stops import PolygonStop, Stop, Vectors, stop_of
from tvclin.control.laws.law import Law, Measurement

SATURATE = ("radial", "each plane")


@dataclass(frozen=True)
class LawInPlanes:
    """A law for both planes, and how its demand is brought back into the stop.

    `law`: one law. `stop`: what the nozzle can do; where each plane is limited by itself, the
    square inside. `saturate`: whether the vector that is asked for keeps its direction when it is
    limited. `InputError` for what is no law, a law that switches, has filters or noise, and unknown
    words.
    """

    law: Law
    stop: Stop | str = "round"
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
        """Whether the demand keeps its direction."""
        return self.saturate == "radial"

    @cached_property
    def shape(self) -> Stop:
        """What can be reached."""
        stop = stop_of(self.stop).inside
        return stop if self.radial else stop.each_plane()

    @cached_property
    def sides(self) -> FloatArray:
        """How far the shape reaches in pitch and in yaw, ``(2,)``."""
        shape = self.shape
        if isinstance(shape, PolygonStop):
            return np.array([np.abs(shape.corners.real).max(), np.abs(shape.corners.imag).max()])
        return shape.support(np.array([1.0, -1.0, 1j, -1j])).reshape(2, 2).max(axis=1)

    def demand(self, measured: Vectors, states: Vectors, limit: FloatArray) -> Vectors:
        """Return the deflections asked for [rad], without limit, ``(m,)``.

        `measured`: what is measured in both planes, as of `Measurement`, ``(m, 5)``. `states`: the
        law's own states, ``(m, k)``. `limit`: the limit [rad] of the stop, ``(m,)``.
        """
        if not self.radial:
            return self._by_parts(measured, states, [limit * side for side in self.sides])
        estimates = getattr(self.law, "estimator", None) is not None
        felt = states[:, 1] if estimates else measured[:, 0] - measured[:, 3]
        felt = felt - measured[:, 2]
        size = np.abs(felt)
        turn = np.where(size > 0.0, felt / np.where(size > 0.0, size, 1.0), 1.0)
        shape, back = self.shape, np.conj(turn)[:, np.newaxis]
        limits = [
            limit / np.maximum(shape.gauge(way), shape.gauge(-way)) for way in (turn, 1j * turn)
        ]
        return np.asarray(turn * self._by_parts(measured * back, states * back, limits))

    def limited(self, demand: Vectors, limit: FloatArray) -> tuple[Vectors, BoolArray]:
        """Return the demand within the limits [rad], and which of them meet the stop."""
        if self.radial:
            with np.errstate(over="ignore"):  # of the least limit that a number can be
                over = self.shape.gauge(demand) / limit
            return demand / np.maximum(over, 1.0), over >= 1.0
        most = self.sides[:, np.newaxis] * limit
        parts = np.stack([demand.real, demand.imag])
        bounded = np.clip(parts, -most, most)
        return bounded[0] + 1j * bounded[1], np.any(np.abs(parts) >= most, axis=0)

    def _by_parts(self, measured: Vectors, states: Vectors, limits: list[FloatArray]) -> Vectors:
        parts = [
            self.law.demand(Measurement(*part(measured).T), part(states).T, limit)
            for part, limit in zip((np.real, np.imag), limits, strict=True)
        ]
        return np.asarray(parts[0] + 1j * np.asarray(parts[1]))
