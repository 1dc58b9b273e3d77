"""A wind with a direction: one history in pitch and one in yaw.

Vectors are complex numbers, pitch + j yaw, and angles are counted from the pitch plane, towards
positive yaw. Bearings are clockwise from north; `WindProfile.to_winds` converts them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, BoolArray, ComplexArray, FloatArray
from tvclin.base.errors import (
    InputError,
    broadcast,
    directions,
    ending,
    instance,
    plain,
    within,
)
from tvclin.numerics import pieces as algebra
from tvclin.numerics.pieces import Pieces
from tvclin.winds.histories import History, Piecewise

_ROUNDING = 1e-12
_FASTEST = 1e3
_TURNS = 100.0
"""A wind that veers faster [rad/s] or further than this is no wind."""


def unit(angle: ArrayLike) -> ComplexArray:
    """Return e^(j angle); a part below rounding is zero, so that an axis is met exactly."""
    parts = np.stack([np.cos(angle), np.sin(angle)])
    parts = np.where(np.abs(parts) < _ROUNDING, 0.0, parts)
    return np.asarray(parts[0] + 1j * parts[1])


@dataclass(frozen=True, kw_only=True, eq=False)
class PlaneWind:
    """Wind angles of attack in pitch and in yaw, or a batch of both.

    Parameters
    ----------
    pitch, yaw : History
        Wind angles [rad] in the two planes; one may be zero throughout. Batches broadcast.

    Raises
    ------
    InputError
        For what is no History, and batches that do not broadcast.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> gust = tv.TriangularWind(peak=0.08, duration=7.5)
    >>> wind = tv.winds.PlaneWind.veering(gust, angle=0.0, rate=np.radians(90) / 7.5)
    >>> wind.peak.round(3), np.degrees(np.angle(wind(3.75))).round(3)
    (np.float64(0.08), np.float64(45.0))
    """

    pitch: History
    yaw: History

    def __post_init__(self) -> None:
        for name in ("pitch", "yaw"):
            instance(name, getattr(self, name), History, "such as TriangularWind")
        broadcast(pitch=self.pitch.batch, yaw=self.yaw.batch)

    @classmethod
    def towards(cls, wind: History, angle: ArrayLike) -> Self:
        """Return a wind of one direction.

        Parameters
        ----------
        wind : History
            Its angle of attack [rad]; batches broadcast.
        angle : array_like
            Its direction [rad] from the pitch plane: pi/2 is a wind in yaw alone.

        Raises
        ------
        InputError
            For what is no History, an angle that is not finite, and shapes that do not broadcast.
        """
        instance("wind", wind, History, "such as TriangularWind")
        direction = unit(directions("angle", angle))
        broadcast(wind=wind.batch, angle=direction.shape)
        return cls(pitch=wind * np.real(direction), yaw=wind * np.imag(direction))

    @classmethod
    def veering(cls, wind: History, angle: ArrayLike, rate: ArrayLike) -> Self:
        """Return a wind that turns evenly: its size times e^(j (angle + rate (t - onset))).

        Parameters
        ----------
        wind : History
            Its angle of attack [rad], which ends; batches broadcast.
        angle : array_like
            Its direction [rad] from the pitch plane at its onset.
        rate : array_like
            How fast it turns [rad/s], towards positive yaw if positive.

        Raises
        ------
        InputError
            For what is no History, is zero throughout or never ends, angles and rates that are
            not finite, 100 turns or more, and shapes that do not broadcast.

        Notes
        -----
        It is exact: a piece c u^k e^(lambda u) becomes one of rate lambda + j rate and one of
        lambda - j rate. So all transforms of a veering wind are those of the straight one at
        s - j rate: veer is a complex pole.
        """
        instance("wind", wind, History, "such as TriangularWind")
        turns = within("rate", rate, -_FASTEST, _FASTEST, "rad/s")
        first = directions("angle", angle)
        shape = broadcast(wind=wind.batch, angle=first.shape, rate=turns.shape)
        ending("wind", wind.end)
        if np.any(np.abs(turns) * (wind.end - wind.onset) > 2.0 * np.pi * _TURNS):
            raise InputError(f"rate must turn the wind less than {_TURNS:g} times while it blows")
        turns = np.where(np.abs(turns) * (wind.end - wind.onset) < _ROUNDING, 0.0, turns)
        if not np.any(turns):
            return cls.towards(wind, first)
        return cls(
            pitch=_turned(wind, first, turns, shape),
            yaw=_turned(wind, first - np.pi / 2.0, turns, shape),
        )

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the leading axes."""
        return broadcast(pitch=self.pitch.batch, yaw=self.yaw.batch)

    def one(self, case: int, shape: tuple[int, ...]) -> PlaneWind:
        """Return one wind of the batch spread to `shape`, by its flat position there."""
        return PlaneWind(pitch=self.pitch.one(case, shape), yaw=self.yaw.one(case, shape))

    def __call__(self, t: ArrayLike) -> ComplexArray:
        """Return the vectors [rad] at the times `t` [s], shape ``batch + t.shape``."""
        return np.asarray(self.pitch(t) + 1j * self.yaw(t))

    def future(self, s: ArrayLike, t: ArrayLike) -> ComplexArray:
        """Return the vector of both `History.future`, the wind still to come after `t` [s].

        Shape ``broadcast(batch, s.shape) + t.shape``.
        """
        return np.asarray(self.pitch.future(s, t) + 1j * self.yaw.future(s, t))

    def component(self, angle: ArrayLike) -> History:
        """Return the part along a direction [rad] from the pitch plane, which may be a batch."""
        direction = unit(directions("angle", angle))
        broadcast(wind=self.batch, angle=direction.shape)
        return self.pitch * np.real(direction) + self.yaw * np.imag(direction)

    @cached_property
    def onset(self) -> FloatArray:
        """Time [s] at which either first differs from zero, shape ``batch``; inf if never."""
        return np.minimum(self.pitch.onset, self.yaw.onset)

    @cached_property
    def end(self) -> FloatArray:
        """Time [s] from which both are zero, shape ``batch``; inf if there is none."""
        return np.maximum(self.pitch.end, self.yaw.end)

    @cached_property
    def square(self) -> History:
        """The square of the vector's size [rad^2], a history as exact as the two."""
        return _squared(self.pitch) + _squared(self.yaw)

    @cached_property
    def peak(self) -> FloatArray:
        """Size [rad] of the largest vector, shape ``batch``: not that of the two peaks."""
        straight = np.abs(self.component(self.direction).peak)
        if np.all(self.one_direction):
            return straight
        return np.where(self.one_direction, straight, np.sqrt(np.maximum(self.square.peak, 0.0)))

    @cached_property
    def one_direction(self) -> BoolArray:
        """Whether the wind keeps to one line, shape ``batch``."""
        pitch, yaw = self._terms
        line = unit(self.direction)[..., np.newaxis]
        across = np.abs(yaw * np.real(line) - pitch * np.imag(line))
        return np.asarray(np.all(across <= _ROUNDING * (np.abs(pitch) + np.abs(yaw)), axis=-1))

    @cached_property
    def direction(self) -> Any:
        """Angle [rad] of that line, shape ``batch``; of a wind that turns, of its largest term."""
        pitch, yaw = self._terms
        largest = np.argmax(np.abs(pitch) + np.abs(yaw), axis=-1)[..., np.newaxis]
        x, y = (np.take_along_axis(np.real(one), largest, axis=-1)[..., 0] for one in (pitch, yaw))
        return plain(np.arctan2(y, x))

    @cached_property
    def _terms(self) -> tuple[AnyArray, AnyArray]:
        """The terms of both on common knots and rates, ``(..., m)``."""
        pitch, yaw = self.pitch.pieces, self.yaw.pieces
        still = [(0.0 * one).pieces for one in (self.pitch, self.yaw)]
        both = algebra.add(pitch, still[1]), algebra.add(still[0], yaw)
        c = [
            np.broadcast_to(p.coefficients, (*self.batch, *p.coefficients.shape[-3:])) for p in both
        ]
        flat = [one.reshape(*self.batch, int(np.prod(one.shape[-3:]))) for one in c]
        return flat[0], flat[1]


def _turned(
    wind: History, first: FloatArray, turns: FloatArray, shape: tuple[int, ...]
) -> Piecewise:
    """The wind times cos(first + turns (t - onset)), as two terms for each of its own."""
    p = algebra.spread(wind.pieces, shape)
    turns = np.broadcast_to(turns, shape)[..., np.newaxis]
    begun = np.broadcast_to(first - turns[..., 0] * wind.onset, shape)[..., np.newaxis]
    straight = np.where(turns == 0.0, np.real(unit(begun)), 0.0)
    half = np.where(turns == 0.0, 0.0, 0.5 * np.exp(1j * (begun + turns * p.knots)))
    factors = [one[..., np.newaxis, np.newaxis] for one in (half + straight, np.conj(half))]
    both = np.concatenate([p.coefficients * one for one in factors], axis=-2)
    return Piecewise(
        Pieces(p.knots, both, np.concatenate([p.rates + 1j * turns, p.rates - 1j * turns], axis=-1))
    )


def _squared(wind: History) -> Piecewise:
    """Each term times each: c u^i e^(a u) times d u^k e^(b u)."""
    p = wind.pieces
    c, order = p.coefficients, p.degree + 1
    products = np.zeros((*c.shape[:-1], c.shape[-2], 2 * order - 1), dtype=c.dtype)
    for i in range(order):
        products[..., i : i + order] += (
            c[..., :, np.newaxis, i, np.newaxis] * c[..., np.newaxis, :, :]
        )
    rates = p.rates[..., :, np.newaxis] + p.rates[..., np.newaxis, :]
    terms = c.shape[-2] ** 2
    return Piecewise(
        Pieces(
            p.knots,
            products.reshape(*c.shape[:-2], terms, 2 * order - 1),
            rates.reshape(*p.rates.shape[:-1], terms),
        )
    )
