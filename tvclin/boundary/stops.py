"""Where a nozzle may be in two planes: the limit times a convex shape about zero.

Vectors are complex, pitch + j yaw, and angles are counted from the pitch plane. The support h(d)
is the furthest that the shape reaches along d, max Re(conj(d) v); the gauge g(v) is the least
factor by which the shape must grow to contain v.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import ComplexArray, FloatArray, IndexArray
from tvclin.base.errors import (
    MAX_AXES,
    InputError,
    array_of,
    between,
    directions,
    number,
    one_of,
    shown,
    whole_number,
    within,
)
from tvclin.numerics.searches import grid_minimum
from tvclin.winds.plane_wind import unit_vector

Vectors = ComplexArray

_MAX_CORNERS = 10_000
"""Largest number of corners of a polygon."""
_MAX_SIZE = 1e100
"""Largest component of a vector [rad]."""
_MIN_SIZE = 1e-290
"""Size [rad] of a vector below which it has no direction."""
_ROUNDING = 1e-12
"""Relative rounding of a gauge."""
_SIDES = 360
"""Default number of sides of an inscribed polygon."""
_MIN_RATIO = 1e-6
"""Smallest size of a shape, normalised by the limit; smaller ones are in another unit."""
_MAX_RATIO = 1e6
"""Largest size of a shape, normalised by the limit; larger ones are in another unit."""


def vectors(name: str, value: ArrayLike) -> Vectors:
    """Return `value` as complex numbers; `InputError` unless they are within 1e100 in size."""
    rule = f"numbers up to {_MAX_SIZE:g} in size, pitch + 1j*yaw"
    array = array_of(name, value, "iufc", rule).astype(complex)
    good = np.maximum(np.abs(array.real), np.abs(array.imag)) <= _MAX_SIZE
    if array.ndim > MAX_AXES or not np.all(good):
        raise InputError(f"{name} must be {rule}; got {shown(value)}")
    return array


def along(direction: ArrayLike, vector: ArrayLike) -> FloatArray:
    """Return the scalar product of vectors as complex numbers."""
    return np.asarray(np.real(np.conj(direction) * vector))


class Stop(ABC):
    """The shape of the deflections that a nozzle can reach, over its limit."""

    @abstractmethod
    def support(self, direction: ArrayLike) -> FloatArray:
        """Return how far the shape reaches along vectors, times their size; in their shape."""

    def farthest(self, direction: ArrayLike) -> Vectors:
        """Return a point of the shape, or of a polygon inside, that is furthest along vectors."""
        return self.inscribed().farthest(direction)

    @property
    @abstractmethod
    def symmetric(self) -> bool:
        """Whether the shape is symmetric about zero."""

    def gauge(self, vector: ArrayLike) -> FloatArray:
        """Return the least limit that reaches vectors, in their shape and unit.

        Raises
        ------
        InputError
            For what is no finite number, real or complex.
        """
        v = vectors("vector", vector)
        size = np.abs(v)
        u = np.where(size > 0.0, v / np.where(size > 0.0, size, 1.0), 1.0)
        # 1/g(u) = min over x of h(u (1 + j x)); h(j u x) <= h(u (1 + j x)) + h(-u) bounds x
        ends = self.support(u) + self.support(-u)
        low, high = (-ends / self.support(-1j * u), ends / self.support(1j * u))
        column = u[..., np.newaxis]
        _, smallest = grid_minimum(lambda x: self.support(column * (1.0 + 1j * x)), low, high)
        return np.asarray(size / smallest)

    @property
    def inside(self) -> Stop:
        """Shape itself, or where its gauge is slow, a polygon inside it of almost its size."""
        return self

    def reach(self, angle: ArrayLike) -> FloatArray:
        """Return the largest deflection of a unit limit in directions [rad], a ratio."""
        return 1.0 / self.gauge(unit_vector(directions("angle", angle)))

    def each_plane(self) -> PolygonStop:
        """Return the square inside the shape, for planes that are limited separately.

        For a round shape it is 1/sqrt(2) in each plane, so up to 1.41 times the limit is required.
        """
        corners = np.array([1.0 + 1.0j, -1.0 + 1.0j, -1.0 - 1.0j, 1.0 - 1.0j])
        return PolygonStop(corners / self.gauge(corners).max())

    def inscribed(self, sides: int = _SIDES) -> PolygonStop:
        """Return a polygon inside, with its corners on the edge: never more than the shape.

        It misses 1 - cos(pi/sides) of a circle, and up to pi/sides of a corner.

        Parameters
        ----------
        sides : int
            At least 4.

        Raises
        ------
        InputError
            For less than 4, or more than 10000.
        """
        if not 4 <= whole_number("sides", sides) <= _MAX_CORNERS:
            raise InputError(f"sides must be 4 to {_MAX_CORNERS}; got {shown(sides)}")
        around = unit_vector(2.0 * np.pi * np.arange(sides) / sides)
        return PolygonStop(around * self.reach(np.angle(around)))


@dataclass(frozen=True)
class CircularStop(Stop):
    """A stop that is the same in all directions: the limit is its radius."""

    @property
    def symmetric(self) -> bool:
        """Whether the shape is symmetric about zero."""
        return True

    def support(self, direction: ArrayLike) -> FloatArray:
        """Return the size of vectors."""
        return np.asarray(np.abs(vectors("direction", direction)))

    def gauge(self, vector: ArrayLike) -> FloatArray:
        """Return the size of vectors."""
        return np.asarray(np.abs(vectors("vector", vector)))

    def farthest(self, direction: ArrayLike) -> Vectors:
        """Return the point of the shape that is furthest along vectors."""
        d = vectors("direction", direction)
        size = np.abs(d)
        return np.asarray(d / np.where(size < _MIN_SIZE, 1.0, size))


@dataclass(frozen=True)
class EllipticStop(Stop):
    """A stop of two half axes, over the limit.

    Parameters
    ----------
    pitch, yaw : float
        Half axes, from 1e-6 to 1e6.

    Raises
    ------
    InputError
        For other half axes: with one of zero, a nozzle that turns in one plane alone, no limit
        reaches the other.
    """

    pitch: float
    yaw: float

    def __post_init__(self) -> None:
        for name in ("pitch", "yaw"):
            axis = number(name, getattr(self, name), between(_MIN_RATIO, _MAX_RATIO))
            object.__setattr__(self, name, axis)

    @property
    def symmetric(self) -> bool:
        """Whether the shape is symmetric about zero."""
        return True

    def support(self, direction: ArrayLike) -> FloatArray:
        """Return the support function of the ellipse along vectors."""
        d = vectors("direction", direction)
        return np.asarray(np.hypot(self.pitch * np.real(d), self.yaw * np.imag(d)))

    def gauge(self, vector: ArrayLike) -> FloatArray:
        """Return the gauge of vectors: the scale of the ellipse that just contains each."""
        v = vectors("vector", vector)
        return np.asarray(np.hypot(np.real(v) / self.pitch, np.imag(v) / self.yaw))

    def farthest(self, direction: ArrayLike) -> Vectors:
        """Return the point of the shape that is furthest along vectors."""
        d = vectors("direction", direction)
        grown = self.pitch**2 * np.real(d) + 1j * self.yaw**2 * np.imag(d)
        return np.asarray(grown / np.where(np.abs(d) < _MIN_SIZE, 1.0, self.support(d)))


@dataclass(frozen=True, eq=False)
class PolygonStop(Stop):
    """A stop of straight edges.

    Parameters
    ----------
    corners : array_like of complex
        Its corners over the limit, pitch + 1j*yaw, in order around zero, ``(n,)``. Those at which
        its edges do not turn are left out.

    Raises
    ------
    InputError
        For fewer than three corners, or more than 10000, a polygon that is not convex, and one
        that does not have zero inside.
    """

    corners: Vectors

    def __post_init__(self) -> None:
        c = vectors("corners", self.corners)
        if c.ndim != 1 or not 3 <= c.size <= _MAX_CORNERS:
            raise InputError(
                f"corners must be one row of 3 to {_MAX_CORNERS} numbers, pitch + 1j*yaw; got an"
                f" array of shape {c.shape}"
            )
        size = within("the largest of corners", np.abs(c).max(), _MIN_RATIO, _MAX_RATIO)
        c = c if along(1j * c, np.roll(c, -1)).sum() > 0.0 else c[::-1]
        edges = (np.roll(c, -1) - c) / size
        turns = along(1j * edges, np.roll(edges, -1))
        around = np.angle(np.roll(edges, -1) * np.conj(edges)).sum()
        inside = along(-1j * edges, c) > _ROUNDING * size * np.abs(edges)
        if np.any(turns < -_ROUNDING) or not np.isclose(around, 2.0 * np.pi) or not np.all(inside):
            raise InputError(
                "corners must go once around a convex polygon that has zero inside; got"
                f" {shown(self.corners)}"
            )
        object.__setattr__(self, "corners", _vertices(c))

    @cached_property
    def symmetric(self) -> bool:
        """Whether the shape is symmetric about zero."""
        return bool(np.all(self.gauge(-self.corners) <= 1.0 + _ROUNDING))

    @cached_property
    def _normals(self) -> Vectors:
        """Normals of the edges, divided by their distance from zero, ``(n,)``."""
        outward = -1j * (np.roll(self.corners, -1) - self.corners)
        return np.asarray(outward / along(outward, self.corners))

    def support(self, direction: ArrayLike) -> FloatArray:
        """Return the support function of the polygon along vectors."""
        return along(direction, self.farthest(direction))

    def gauge(self, vector: ArrayLike) -> FloatArray:
        """Return the gauge of vectors: the scale of the polygon that just contains each."""
        v = vectors("vector", vector)
        return along(self._normals[_sector(self.corners, v)], v)

    def farthest(self, direction: ArrayLike) -> Vectors:
        """Return the corner that is furthest along vectors."""
        d = vectors("direction", direction)
        return np.asarray(np.roll(self.corners, -1)[_sector(self._normals, d)])


def _vertices(corners: Vectors) -> Vectors:
    """Return the vertices of a convex polygon, without repeated ones and points on an edge."""
    corners = corners[corners != np.roll(corners, -1)]
    while True:
        edges = np.roll(corners, -1) - corners
        is_vertex = np.angle(edges * np.conj(np.roll(edges, 1))) > 0.0
        if np.all(is_vertex):
            return corners
        corners = corners[is_vertex]


def _sector(rays: Vectors, vector: Vectors) -> IndexArray:
    """Return the index of the last ray before each vector; the rays go once around."""
    turns = np.cumsum(np.angle(rays[1:] / rays[:-1]))  # back by rounding where two are parallel
    angles = np.maximum.accumulate(np.append(0.0, turns))
    beyond_first = np.angle(vector / rays[0]) % (2.0 * np.pi)
    return np.searchsorted(angles, beyond_first, side="right") - 1


class SquareStop(PolygonStop):
    """Two actuators at right angles, each with the limit for itself.

    Parameters
    ----------
    turn : float
        Angle [rad] of the first actuator from the pitch plane; a roll of the body turns it too.
    """

    def __init__(self, turn: float = 0.0) -> None:
        angle = number("turn", turn, directions, "rad")
        PolygonStop.__init__(
            self, np.array([1.0 - 1.0j, 1.0 + 1.0j, -1.0 + 1.0j, -1.0 - 1.0j]) * unit_vector(angle)
        )


_SHAPES: dict[str, Callable[[], Stop]] = {
    "round": CircularStop,
    "round-each-plane": lambda: CircularStop().each_plane(),
    "square": SquareStop,
    "square-45": lambda: SquareStop(np.pi / 4.0),
}
STOPS = tuple(_SHAPES)
"""Stops that files and options name."""


def stop_of(stop: Stop | str) -> Stop:
    """Return a limit shape, or the shape of a name of `STOPS`; else raise `InputError`."""
    if isinstance(stop, Stop):
        return stop
    if not isinstance(stop, str):
        raise InputError(f"stop must be one of {', '.join(STOPS)}, or a Stop; got {shown(stop)}")
    return _SHAPES[one_of("stop", stop, STOPS)]()
