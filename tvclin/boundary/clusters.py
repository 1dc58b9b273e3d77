"""Mean deflections of several engines together, with some engines centred or stuck.

The thrust turns by the mean of the deflections, weighted with the thrusts. What it can be is the
sum of the stops of the engines that move (Minkowski), and where roll is held at zero, the part of
it in which the side forces have no moment about the axis.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, between, each, flag, instance, nonzero, number, one_of
from tvclin.boundary.stops import CircularStop, Stop, Vectors, along, vectors
from tvclin.numerics.searches import grid_minimum

STATES = ("moving", "centred", "stuck", "out")
_DIRECTIONS = 720
"""Directions in which the support function of a cluster is checked."""
_MIN_SUPPORT = 1e-4
"""Smallest support, relative to the limit, with which a cluster can trim itself."""
_MAX_CENTRAL_RADIUS = 1e-9
"""Radius of an engine, relative to the largest, below which it has no roll moment."""
_MAX_ENGINES = 100
"""Largest number of engines of a cluster."""


@dataclass(frozen=True)
class ClusterEngine:
    """An engine of a cluster.

    Parameters
    ----------
    at : complex
        Its place about the roll axis [m]: in the pitch plane + 1j in the yaw plane.
    share : float
        Its thrust, from 1e-6 to 1e9; only the ratios in a cluster count.
    stop : Stop
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
    stop: Stop = field(default_factory=CircularStop)
    state: str = "moving"
    deflection: complex = 0.0

    def __post_init__(self) -> None:
        for name in ("at", "deflection"):
            array = vectors(name, getattr(self, name))
            if array.ndim or abs(array) > 1e9:
                raise InputError(f"{name} must be one number within 1e9 in size, pitch + 1j*yaw")
            object.__setattr__(self, name, complex(array))
        object.__setattr__(self, "share", number("share", self.share, between(1e-6, 1e9)))
        instance("stop", self.stop, Stop, "such as CircularStop")
        one_of("state", self.state, STATES)
        if self.deflection and self.state != "stuck":
            raise InputError('deflection must be zero, or state "stuck"')
        if self.stop.gauge(self.deflection) > 1.0 + 1e-12:
            raise InputError("deflection must be within the stop; 1 is the limit")


@dataclass(frozen=True)
class Cluster(Stop):
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
        engines = each("engines", self.engines, ClusterEngine, "each with its place")
        if len(engines) > _MAX_ENGINES or not any(engine.state == "moving" for engine in engines):
            raise InputError(f"engines must be 1 to {_MAX_ENGINES}, one of them moving at least")
        if any(engine.state == "out" for engine in engines):
            raise InputError(
                "engines must all have thrust: of an engine that is out, give the vehicle without"
                " its thrust, and a cluster of the others (Cluster.offset is what they must trim)"
            )
        object.__setattr__(self, "engines", engines)
        object.__setattr__(self, "hold_roll", flag("hold_roll", self.hold_roll))
        directions = np.exp(2j * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS)
        bias, roll = self._stuck
        if min(self._rolls(1.0) + roll, self._rolls(-1.0) - roll) <= 0.0 and roll:
            raise InputError("engines must balance the roll moment of the one that is stuck")
        worst = -bias / abs(bias) if bias else 1.0
        if self.support(np.append(directions, worst)).min() < _MIN_SUPPORT:
            raise InputError(
                "engines must reach to every side; those that move cannot trim the stuck one"
            )

    @property
    def symmetric(self) -> bool:
        """Whether the shape is symmetric about zero."""
        return not any(self._stuck) and all(engine.stop.symmetric for engine in self._moving)

    def support(self, direction: ArrayLike) -> FloatArray:
        """Return the support function of the mean deflection along vectors."""
        d = vectors("direction", direction)
        bias, roll = self._stuck
        free = self._sum(d, np.zeros(d.shape))
        sides = self._rolls(1.0) + roll, self._rolls(-1.0) - roll
        if min(sides) > 0.0:
            # sum s_j h_j(j rho r_j) <= sum s_j h_j(d + j rho r_j) + sum s_j h_j(-d) bounds rho
            ends = free + self._sum(-d, np.zeros(d.shape))
            column = d[..., np.newaxis]
            _, free = grid_minimum(
                lambda rho: self._sum(column, rho) + rho * roll, -ends / sides[1], ends / sides[0]
            )
        return np.asarray(free + along(d, bias))

    @cached_property
    def inside(self) -> Stop:
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
            sum s_j r_j/l_c [rad], as a vector, for ever. Add its gauge to a limit for the wind:
            the sum is enough, for the gauge of a sum is at most the sum of the gauges.
        """
        arm = number("control_arm", control_arm, nonzero, "m")
        return complex(sum(engine.at * share for engine, share in self._shares) / arm)

    @property
    def _shares(self) -> list[tuple[ClusterEngine, float]]:
        total = sum(engine.share for engine in self.engines)
        return [(engine, engine.share / total) for engine in self.engines]

    @property
    def _moving(self) -> list[ClusterEngine]:
        return [engine for engine in self.engines if engine.state == "moving"]

    @property
    def _stuck(self) -> tuple[complex, float]:
        """Mean deflection [rad] of engines that are stuck, and their roll moment."""
        stuck = [(engine, share) for engine, share in self._shares if engine.state == "stuck"]
        bias = sum((engine.deflection * share for engine, share in stuck), 0j)
        roll = sum(
            share * float(along(self._arm(engine), engine.deflection)) for engine, share in stuck
        )
        return bias, roll if self.hold_roll else 0.0

    def _rolls(self, sign: float) -> float:
        """Return the largest roll moment of a sign; zero where roll is not held."""
        still = np.zeros((), dtype=complex)
        return float(self._sum(still, np.asarray(sign))) if self.hold_roll else 0.0

    def _sum(self, d: Vectors, rho: FloatArray) -> FloatArray:
        moving = [(engine, share) for engine, share in self._shares if engine.state == "moving"]
        supports = [
            share * engine.stop.support(d + rho * self._arm(engine)) for engine, share in moving
        ]
        return np.asarray(np.sum(supports, axis=0))

    def _arm(self, engine: ClusterEngine) -> complex:
        """Return j r of an engine, normalised by the largest r."""
        largest = max(abs(member.at) for member in self.engines)
        return 1j * engine.at / largest if abs(engine.at) > _MAX_CENTRAL_RADIUS * largest else 0j
