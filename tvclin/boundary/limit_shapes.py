"""Limit shapes: the deflections that a nozzle, or a cluster of engines, reaches in two planes.

A limit shape S is convex and contains zero; the nozzle reaches the limit times S. Vectors are
complex, pitch + j yaw, and angles are counted from the pitch plane. The support is the furthest
that the shape reaches along d, and the gauge is the least factor by which it contains v:

    h(d) = max over v in S of Re(conj(d) v),    g(v) = min{ r >= 0 : v in r S }.

The thrust of several engines turns by the mean of their deflections, weighted with the thrusts. Its
shape is the Minkowski sum of the moving engines' shapes, displaced by the engines that are stuck,
and where roll is held at zero, the part of it in which the side forces have no moment about the
axis.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import ComplexArray, FloatArray, IndexArray
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
_RATIO_RANGE = (1e-6, 1e6)
"""Sizes of a shape, normalised by the limit, beyond which it is in another unit."""
STATES = ("moving", "centred", "stuck", "out")
_DIRECTIONS = 720
"""Directions in which the support function of a cluster is checked."""
_MIN_SUPPORT = 1e-4
"""Smallest support, relative to the limit, with which a cluster can trim itself."""
_MAX_CENTRAL_RADIUS = 1e-9
"""Radius of an engine, relative to the largest, below which it has no roll moment."""
_MAX_ENGINES = 100
"""Largest number of engines of a cluster."""


def vectors(name: str, value: ArrayLike) -> Vectors:
    """Return `value` as complex vectors pitch + j yaw; `InputError` about `name` above 1e100."""
    rule = f"numbers up to {_MAX_SIZE:g} in size, pitch + 1j*yaw"
    array = errors.array_of(name, value, "iufc", rule).astype(complex)  # any kind of number
    good = np.maximum(np.abs(array.real), np.abs(array.imag)) <= _MAX_SIZE
    if array.ndim > errors.MAX_AXES or not np.all(good):
        raise errors.InputError(f"{name} must be {rule}; got {errors.shown(value)}")
    return array


def scalar_product(direction: ArrayLike, vector: ArrayLike) -> FloatArray:
    """Return the scalar product Re(conj(direction) vector) of complex vectors, which broadcast."""
    return np.asarray(np.real(np.conj(direction) * vector))


class LimitShape(ABC):
    """The shape of the deflections that a nozzle can reach, over its limit."""

    @abstractmethod
    def support(self, direction: ArrayLike) -> FloatArray:
        """Return the largest scalar product of the shape and each `direction`, a complex vector."""

    def farthest(self, direction: ArrayLike) -> Vectors:
        """Return the point of the shape, or a polygon inside, furthest along each `direction`."""
        return self.inscribed().farthest(direction)

    @property
    @abstractmethod
    def symmetric(self) -> bool:
        """Whether the shape is symmetric about zero."""

    @property
    def plane_limits(self) -> FloatArray:
        """Largest size of the deflection in pitch and in yaw, normalised by the limit, ``(2,)``."""
        return self.support(np.array([1.0, -1.0, 1j, -1j])).reshape(2, 2).max(axis=1)

    def gauge(self, vector: ArrayLike) -> FloatArray:
        """Return the minimum limit that reaches each complex `vector`, in its shape and unit.

        Raises
        ------
        InputError
            For what is no finite number, real or complex.
        """
        v = vectors("vector", vector)
        size = np.abs(v)
        u = np.where(size > 0.0, v / np.where(size > 0.0, size, 1.0), 1.0)
        # of each direction u, with the support h and the gauge g:
        # 1/g(u) = min over x of h(u (1 + j x)); h(j u x) <= h(u (1 + j x)) + h(-u) bounds x
        ends = self.support(u) + self.support(-u)
        low, high = (-ends / self.support(-1j * u), ends / self.support(1j * u))
        column = u[..., np.newaxis]
        _, smallest = grid_minimum(lambda x: self.support(column * (1.0 + 1j * x)), low, high)
        return np.asarray(size / smallest)

    @property
    def inside(self) -> LimitShape:
        """The shape; or a polygon inside it of almost its size, whose `gauge` takes no search.

        The gauge of a vector is the minimum limit that reaches it.
        """
        return self

    def reach(self, angle: ArrayLike) -> FloatArray:
        """Return the largest deflection in directions `angle` [rad], over the limit."""
        return 1.0 / self.gauge(unit_vector(errors.directions("angle", angle)))

    def each_plane(self) -> PolygonShape:
        """Return the square inside the shape, for planes that are limited separately.

        For a round shape it is 1/sqrt(2) in each plane, so up to 1.41 times the limit is required.
        """
        corners = np.array([1.0 + 1.0j, -1.0 + 1.0j, -1.0 - 1.0j, 1.0 - 1.0j])
        return PolygonShape(corners / self.gauge(corners).max())

    def inscribed(self, sides: int = _SIDES) -> PolygonShape:
        """Return a polygon inside, with its corners on the edge, at the `reach` in each direction.

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
        if not 4 <= errors.whole_number("sides", sides) <= _MAX_CORNERS:
            raise errors.InputError(f"sides must be 4 to {_MAX_CORNERS}; got {errors.shown(sides)}")
        around = unit_vector(2.0 * np.pi * np.arange(sides) / sides)
        return PolygonShape(around * self.reach(np.angle(around)))


@dataclass(frozen=True)
class CircularShape(LimitShape):
    """A limit shape that is the same in all directions: the limit is its radius."""

    symmetric = True

    def support(self, direction: ArrayLike) -> FloatArray:
        """Return the size of each `direction`, a complex vector: the support of a unit circle."""
        return np.asarray(np.abs(vectors("direction", direction)))

    def gauge(self, vector: ArrayLike) -> FloatArray:
        """Return the size of each complex `vector`, the limit of a circle that just reaches it."""
        return np.asarray(np.abs(vectors("vector", vector)))

    def farthest(self, direction: ArrayLike) -> Vectors:
        """Return the point of the unit circle along each `direction`, a complex vector."""
        d = vectors("direction", direction)
        size = np.abs(d)
        return np.asarray(d / np.where(size < _MIN_SIZE, 1.0, size))


@dataclass(frozen=True)
class EllipticShape(LimitShape):
    """A limit shape of two half axes, normalised by the limit.

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
        """Check both half axes, and set them to floats."""
        for name in ("pitch", "yaw"):
            axis = errors.number(name, getattr(self, name), errors.between(*_RATIO_RANGE))
            object.__setattr__(self, name, axis)

    symmetric = True

    def support(self, direction: ArrayLike) -> FloatArray:
        """Return the support function of the ellipse along each `direction`, a complex vector."""
        d = vectors("direction", direction)
        return np.asarray(np.hypot(self.pitch * np.real(d), self.yaw * np.imag(d)))

    def gauge(self, vector: ArrayLike) -> FloatArray:
        """Return the gauge of each complex `vector`: the scale of the ellipse that contains it."""
        v = vectors("vector", vector)
        return np.asarray(np.hypot(np.real(v) / self.pitch, np.imag(v) / self.yaw))

    def farthest(self, direction: ArrayLike) -> Vectors:
        """Return the point of the ellipse furthest along each `direction`, a complex vector."""
        d = vectors("direction", direction)
        grown = self.pitch**2 * np.real(d) + 1j * self.yaw**2 * np.imag(d)
        return np.asarray(grown / np.where(np.abs(d) < _MIN_SIZE, 1.0, self.support(d)))


@dataclass(frozen=True, eq=False)
class PolygonShape(LimitShape):
    """A limit shape of straight edges.

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
        """Check the corners, and keep them counterclockwise, without those on an edge."""
        c = vectors("corners", self.corners)
        if c.ndim != 1 or not 3 <= c.size <= _MAX_CORNERS:
            raise errors.InputError(
                f"corners must be one row of 3 to {_MAX_CORNERS} numbers, pitch + 1j*yaw; got an"
                f" array of shape {c.shape}"
            )
        size = errors.within("the largest of corners", np.abs(c).max(), *_RATIO_RANGE)
        # counterclockwise: twice the signed area is positive
        c = c if scalar_product(1j * c, np.roll(c, -1)).sum() > 0.0 else c[::-1]
        edges = (np.roll(c, -1) - c) / size
        turns = scalar_product(1j * edges, np.roll(edges, -1))
        around = np.angle(np.roll(edges, -1) * np.conj(edges)).sum()
        inside = scalar_product(-1j * edges, c) > _ROUNDING * size * np.abs(edges)
        if np.any(turns < -_ROUNDING) or not np.isclose(around, 2.0 * np.pi) or not np.all(inside):
            raise errors.InputError(
                "corners must go once around a convex polygon that has zero inside; got"
                f" {errors.shown(self.corners)}"
            )
        object.__setattr__(self, "corners", _vertices(c))

    @cached_property
    def symmetric(self) -> bool:
        """Whether the shape is symmetric about zero."""
        return bool(np.all(self.gauge(-self.corners) <= 1.0 + _ROUNDING))

    @property
    def plane_limits(self) -> FloatArray:
        """Largest size of the deflection in pitch and in yaw, normalised by the limit, ``(2,)``."""
        return np.array([np.abs(self.corners.real).max(), np.abs(self.corners.imag).max()])

    @property
    def by_planes(self) -> bool:
        """Whether the shape is a rectangle that limits each plane separately."""
        sizes = np.stack([np.abs(self.corners.real), np.abs(self.corners.imag)])
        limits = self.plane_limits[:, np.newaxis] * (1.0 - _ROUNDING)
        return bool(self.corners.size == 4 and np.all(sizes >= limits))

    @cached_property
    def normals(self) -> Vectors:
        """Outward normals of the edges, complex, over their distance from zero, ``(n,)``.

        A vector v is on edge k where its scalar product with normal k is one.
        """
        outward = -1j * (np.roll(self.corners, -1) - self.corners)
        return np.asarray(outward / scalar_product(outward, self.corners))

    def support(self, direction: ArrayLike) -> FloatArray:
        """Return the support function of the polygon along each `direction`, a complex vector."""
        return scalar_product(direction, self.farthest(direction))

    def gauge(self, vector: ArrayLike) -> FloatArray:
        """Return the gauge of each complex `vector`: the scale of the polygon that contains it."""
        v = vectors("vector", vector)
        # the edge that the ray along v meets; its normal is over its distance from zero
        return scalar_product(self.normals[_sector(self.corners, v)], v)

    def farthest(self, direction: ArrayLike) -> Vectors:
        """Return the corner that is furthest along each `direction`, a complex vector."""
        d = vectors("direction", direction)
        # edge k goes from corner k to corner k + 1, which is furthest up to the next normal
        return np.asarray(np.roll(self.corners, -1)[_sector(self.normals, d)])


def _vertices(corners: Vectors) -> Vectors:
    """Return the vertices of a convex polygon: `corners` that are not repeated and on no edge.

    A corner is removed where the edges do not turn to the left; the rest is tested again.
    """
    corners = corners[corners != np.roll(corners, -1)]
    while True:
        edges = np.roll(corners, -1) - corners
        is_vertex = np.angle(edges * np.conj(np.roll(edges, 1))) > 0.0
        if np.all(is_vertex):
            return corners
        corners = corners[is_vertex]


def _sector(rays: Vectors, vector: Vectors) -> IndexArray:
    """Return the index of the last of `rays`, in order around zero, before each `vector`.

    Both complex. The order is by angle from the first ray, and a parallel ray counts as before.
    """
    turns = np.cumsum(np.angle(rays[1:] / rays[:-1]))  # back by rounding where two are parallel
    angles = np.maximum.accumulate(np.append(0.0, turns))
    beyond_first = np.angle(vector / rays[0]) % (2.0 * np.pi)
    return np.searchsorted(angles, beyond_first, side="right") - 1


class SquareShape(PolygonShape):
    """Two actuators at right angles, each with the limit for itself.

    Parameters
    ----------
    rotation : float
        Angle [rad] of the first actuator from the pitch plane; a roll of the body turns it too.
    """

    def __init__(self, rotation: float = 0.0) -> None:
        """Make the square of half width one that is turned by `rotation` [rad]."""
        angle = errors.number("rotation", rotation, errors.directions, "rad")
        PolygonShape.__init__(
            self, np.array([1.0 - 1.0j, 1.0 + 1.0j, -1.0 + 1.0j, -1.0 - 1.0j]) * unit_vector(angle)
        )


_SHAPES: dict[str, Callable[[], LimitShape]] = {
    "round": CircularShape,
    "round-each-plane": lambda: CircularShape().each_plane(),
    "square": SquareShape,
    "square-45": lambda: SquareShape(np.pi / 4.0),
}
LIMIT_SHAPES = tuple(_SHAPES)
"""Limit shapes that files and options name."""


def limit_shape_of(limit_shape: LimitShape | str, name: str = "limit_shape") -> LimitShape:
    """Return a limit shape, given as argument `name` or by its name among `LIMIT_SHAPES`."""
    if isinstance(limit_shape, LimitShape):
        return limit_shape
    if not isinstance(limit_shape, str):
        raise errors.InputError(
            f"{name} must be one of {', '.join(LIMIT_SHAPES)}, or a LimitShape; got"
            f" {errors.shown(limit_shape)}"
        )
    return _SHAPES[errors.one_of(name, limit_shape, LIMIT_SHAPES)]()


@dataclass(frozen=True)
class ClusterEngine:
    """An engine of a cluster.

    Parameters
    ----------
    at : complex
        Its place about the roll axis [m]: in the pitch plane + 1j in the yaw plane.
    share : float
        Its thrust, from 1e-6 to 1e9; only the ratios in a cluster count.
    limit_shape : LimitShape
        What it can do, over the limit.
    state : {"moving", "centred", "stuck", "out"}
        Centred: it stays at zero. Stuck: it stays at `deflection`. Out: see `Cluster`.
    deflection : complex
        Where it is stuck, over the limit: 1 is hard over in pitch.

    Raises
    ------
    InputError
        For numbers beyond their range, an unknown state, a
        deflection beyond the stop, and one of an engine that is not stuck.
    """

    at: complex
    share: float = 1.0
    limit_shape: LimitShape = field(default_factory=CircularShape)
    state: str = "moving"
    deflection: complex = 0.0

    def __post_init__(self) -> None:
        """Check place, deflection, thrust share, limit shape and state; set numbers to one type."""
        for name in ("at", "deflection"):  # vectors pitch + j yaw
            array = vectors(name, getattr(self, name))
            if array.ndim or abs(array) > 1e9:
                raise errors.InputError(
                    f"{name} must be one number within 1e9 in size, pitch + 1j*yaw"
                )
            object.__setattr__(self, name, complex(array))
        object.__setattr__(
            self, "share", errors.number("share", self.share, errors.between(1e-6, 1e9))
        )
        errors.instance("limit_shape", self.limit_shape, LimitShape, "such as CircularShape")
        errors.one_of("state", self.state, STATES)
        if self.deflection and self.state != "stuck":
            raise errors.InputError('deflection must be zero, or state "stuck"')
        if self.limit_shape.gauge(self.deflection) > 1.0 + 1e-12:
            raise errors.InputError("deflection must be within the stop; 1 is the limit")


@dataclass(frozen=True)
class Cluster(LimitShape):
    """The mean deflections that a cluster can reach, normalised by the limit of an engine.

    Parameters
    ----------
    engines : list or tuple of ClusterEngine
        All that have thrust.
    hold_roll : bool
        Whether the side forces must have no moment about the roll axis; otherwise something else
        holds the roll.

    Raises
    ------
    InputError
        For no engine that moves, an engine that is out (its thrust is missing in B, beta and the
        drift as well: give the vehicle without it, and a cluster of the others), and a cluster
        that cannot trim its own stuck engine.

    Notes
    -----
    Without roll h(d) = sum s_j h_j(d), s_j = T_j/T; with roll held the least over rho of
    sum s_j h_j(d + j rho r_j), r_j the place of engine j. A stuck engine moves the shape.

    Examples
    --------
    >>> import tvclin as tv
    >>> places = (1, 1j, -1, -1j)
    >>> fixed = tv.boundary.ClusterEngine(at=1, state="centred")
    >>> moving = [tv.boundary.ClusterEngine(at=at) for at in places[1:]]
    >>> three = tv.boundary.Cluster([fixed, *moving])
    >>> three.gauge([1, 1j]).round(4)
    array([1.3333, 1.4641])
    """

    engines: tuple[ClusterEngine, ...]
    hold_roll: bool = True

    def __post_init__(self) -> None:
        """Check number and states of the engines, and that those that move trim the others."""
        engines = errors.each("engines", self.engines, ClusterEngine, "each with its place")
        if len(engines) > _MAX_ENGINES or not any(engine.state == "moving" for engine in engines):
            raise errors.InputError(
                f"engines must be 1 to {_MAX_ENGINES}, one of them moving at least"
            )
        if any(engine.state == "out" for engine in engines):
            raise errors.InputError(
                "engines must all have thrust: of an engine that is out, give the vehicle without"
                " its thrust, and a cluster of the others (Cluster.offset is what they must trim)"
            )
        object.__setattr__(self, "engines", engines)
        object.__setattr__(self, "hold_roll", errors.flag("hold_roll", self.hold_roll))
        directions = np.exp(2j * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS)
        bias, roll = self._stuck  # mean deflection and roll moment of the engines that are stuck
        # the moving engines' largest moment in either direction must exceed that of the stuck ones
        if min(self._rolls(1.0) + roll, self._rolls(-1.0) - roll) <= 0.0 and roll:
            raise errors.InputError("engines must balance the roll moment of the one that is stuck")
        worst = -bias / abs(bias) if bias else 1.0
        if self.support(np.append(directions, worst)).min() < _MIN_SUPPORT:
            raise errors.InputError(
                "engines must reach to every side; those that move cannot trim the stuck one"
            )

    @property
    def symmetric(self) -> bool:
        """Whether the shape is symmetric about zero: no engine stuck, all moving ones symmetric."""
        return not any(self._stuck) and all(
            engine.limit_shape.symmetric for engine, _ in self._moving
        )

    def support(self, direction: ArrayLike) -> FloatArray:
        """Return the support of the mean deflection along each `direction`, a complex vector.

        It is the support of the moving engines, sum s_j h_j(d) over engines j of the thrust share
        s_j and the support h_j of their limit shape, plus the scalar product with the mean
        deflection of the stuck ones. Where the engines must keep the roll moment zero, it is the
        minimum over the multiplier rho of this condition, with h_j(d + rho a_j), a_j being the arm.
        """
        d = vectors("direction", direction)
        bias, roll = self._stuck  # mean deflection and roll moment of the stuck engines
        free = self._sum(d, np.zeros(d.shape))
        # largest roll moments of both signs, of all engines; zero where roll is free
        sides = self._rolls(1.0) + roll, self._rolls(-1.0) - roll
        if min(sides) > 0.0:
            # sum s_j h_j(rho a_j) <= sum s_j h_j(d + rho a_j) + sum s_j h_j(-d) bounds rho
            ends = free + self._sum(-d, np.zeros(d.shape))
            column = d[..., np.newaxis]
            _, free = grid_minimum(
                lambda rho: self._sum(column, rho) + rho * roll, -ends / sides[1], ends / sides[0]
            )
        return np.asarray(free + scalar_product(d, bias))

    @cached_property
    def inside(self) -> LimitShape:
        """Inscribed polygon, by `inscribed`."""
        return self.inscribed()

    def offset(self, control_arm: float) -> complex:
        """Return the mean deflection that trims thrusts whose sum is not on the axis.

        Parameters
        ----------
        control_arm : float
            From the centre of gravity to the engines [m], not zero.

        Returns
        -------
        complex
            sum s_j r_j/l_c [rad], as a vector, for ever, of engines at r_j with the shares s_j of
            the thrust and the arm l_c. Add its gauge to a limit for the wind: the sum is enough,
            for the gauge of a sum is at most the sum of the gauges.
        """
        arm = errors.number("control_arm", control_arm, errors.nonzero, "m")
        return complex(sum(engine.at * share for engine, share in self._shares) / arm)

    @property
    def _shares(self) -> list[tuple[ClusterEngine, float]]:
        """Engines, each with its share of the thrust."""
        total = sum(engine.share for engine in self.engines)
        return [(engine, engine.share / total) for engine in self.engines]

    @property
    def _moving(self) -> list[tuple[ClusterEngine, float]]:
        """Engines that move, each with its share of the thrust."""
        return [(engine, share) for engine, share in self._shares if engine.state == "moving"]

    @property
    def _stuck(self) -> tuple[complex, float]:
        """Mean deflection of the engines that are stuck, over the limit, and their roll moment.

        The deflection is pitch + j yaw, weighted with each engine's share of the thrust.
        The moment is normalised by the total thrust and the largest distance from the axis; zero
        where the moving engines need not balance it (`hold_roll`).
        """
        stuck = [(engine, share) for engine, share in self._shares if engine.state == "stuck"]
        bias = sum((engine.deflection * share for engine, share in stuck), 0j)
        roll = sum(
            share * float(scalar_product(self._arm(engine), engine.deflection))
            for engine, share in stuck
        )
        return bias, roll if self.hold_roll else 0.0

    def _rolls(self, sign: float) -> float:
        """Return the largest roll moment of the moving engines with a `sign`; zero if roll is free.

        Normalised by the total thrust and the largest distance from the axis, as in `_stuck`.
        Moving engines are not stuck. The moment is the sum of s_j h_j(sign a_j), share of the
        thrust times the furthest deflection along the arm a_j of each engine j: `_sum` with the
        direction d zero and rho the sign.
        """
        no_direction = np.zeros((), dtype=complex)
        return float(self._sum(d=no_direction, rho=np.asarray(sign))) if self.hold_roll else 0.0

    def _sum(self, d: Vectors, rho: FloatArray) -> FloatArray:
        """Return the sum over moving engines of s_j h_j(d + rho a_j), in the shape of d and rho.

        Of engine j, s_j is the share of the thrust, h_j the support function of its limit shape and
        a_j its arm about the roll axis (`_arm`). `d`: directions, complex. `rho`: multiplier of the
        condition that the roll moment is zero: with roll held, the support along d is the minimum
        of this sum over rho.
        """
        supports = [
            share * engine.limit_shape.support(d + rho * self._arm(engine))
            for engine, share in self._moving
        ]
        return np.asarray(np.sum(supports, axis=0))

    def _arm(self, engine: ClusterEngine) -> complex:
        """Return the arm a = j r of an engine at r, over the largest r; zero on the axis.

        It points as the side force at r that has a moment about the roll axis.
        """
        largest = max(abs(member.at) for member in self.engines)
        return 1j * engine.at / largest if abs(engine.at) > _MAX_CENTRAL_RADIUS * largest else 0j
