"""Winds in two planes: one history of the wind angle in pitch and one in yaw.

The wind vector is the complex number pitch + j yaw, and directions are measured from the pitch
plane towards positive yaw. Bearings are clockwise from north; `WindProfile.to_winds` converts them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, BoolArray, ComplexArray, FloatArray
from tvclin.base.errors import InputError, broadcast, directions, ending, instance, plain, within
from tvclin.numerics import pieces as algebra
from tvclin.numerics.pieces import Pieces
from tvclin.winds.histories import History, Piecewise

_ROUNDING = 1e-12
"""Relative rounding of a component, and of a veer angle [rad], that counts as zero."""
_MAX_VEER_RATE = 1e3
"""Largest rate of veer [rad/s]."""
_MAX_VEER_TURNS = 100.0
"""Largest veer of a wind from its onset to its end, in turns."""


def unit_vector(angle: ArrayLike) -> ComplexArray:
    """Return e^(j angle) of angles [rad], in their shape, exact along both axes.

    Components below rounding are set to zero.
    """
    components = np.stack([np.cos(angle), np.sin(angle)])
    components = np.where(np.abs(components) < _ROUNDING, 0.0, components)
    return np.asarray(components[0] + 1j * components[1])


@dataclass(frozen=True, kw_only=True, eq=False)
class PlaneWind:
    """Wind angles of attack in pitch and in yaw, or a batch of pairs.

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
        """Check the fields; `InputError` as the class says."""
        for name in ("pitch", "yaw"):
            instance(name, getattr(self, name), History, "such as TriangularWind")
        broadcast(pitch=self.pitch.batch, yaw=self.yaw.batch)

    @classmethod
    def towards(cls, wind: History, angle: ArrayLike) -> Self:
        """Return a wind of constant direction.

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
        direction = unit_vector(directions("angle", angle))
        broadcast(wind=wind.batch, angle=direction.shape)
        return cls(pitch=wind * np.real(direction), yaw=wind * np.imag(direction))

    @classmethod
    def veering(cls, wind: History, angle: ArrayLike, rate: ArrayLike) -> Self:
        """Return a wind whose direction changes at a constant rate.

        Its vector is the wind angle times e^(j (angle + rate (t - onset))).

        Parameters
        ----------
        wind : History
            Its angle of attack [rad], which ends; batches broadcast.
        angle : array_like
            Its direction [rad] from the pitch plane at its onset.
        rate : array_like
            Rate of veer [rad/s], positive towards positive yaw.

        Raises
        ------
        InputError
            For what is no History, is zero throughout or never ends, angles and rates that are
            not finite, 100 turns or more, and shapes that do not broadcast.

        Notes
        -----
        The histories are exact: a piece c u^k e^(lambda u) becomes one of rate lambda + j rate
        and one of lambda - j rate. So the transforms of a veering wind are those of the wind of
        constant direction at s - j rate: veer is a complex pole.
        """
        instance("wind", wind, History, "such as TriangularWind")
        rates = within("rate", rate, -_MAX_VEER_RATE, _MAX_VEER_RATE, "rad/s")
        direction = directions("angle", angle)
        shape = broadcast(wind=wind.batch, angle=direction.shape, rate=rates.shape)
        ending("wind", wind.end)
        if np.any(np.abs(rates) * (wind.end - wind.onset) > 2.0 * np.pi * _MAX_VEER_TURNS):
            raise InputError(
                f"rate must turn the wind less than {_MAX_VEER_TURNS:g} times while it blows"
            )
        rates = np.where(np.abs(rates) * (wind.end - wind.onset) < _ROUNDING, 0.0, rates)
        if not np.any(rates):
            return cls.towards(wind, direction)
        return cls(
            pitch=_veering_component(wind, direction, rates, shape),
            yaw=_veering_component(wind, direction - np.pi / 2.0, rates, shape),
        )

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the leading axes of both histories."""
        return broadcast(pitch=self.pitch.batch, yaw=self.yaw.batch)

    def case(self, index: int, shape: tuple[int, ...]) -> PlaneWind:
        """Return the wind at the flat position `index` of the batch broadcast to `shape`."""
        return PlaneWind(pitch=self.pitch.case(index, shape), yaw=self.yaw.case(index, shape))

    def __call__(self, t: ArrayLike) -> ComplexArray:
        """Return the wind vectors pitch + j yaw [rad] at `t` [s], shape ``batch + t.shape``."""
        return np.asarray(self.pitch(t) + 1j * self.yaw(t))

    def remaining_integral(self, s: ArrayLike, t: ArrayLike) -> ComplexArray:
        """Return the remaining integral, from `t` on, of e^(-s (r - t)) times pitch + j yaw over r.

        It is the effect that the wind will still have, after the time `t` [s], on unstable modes
        with the pole `s` [1/s]. Shape ``broadcast(batch, s.shape) + t.shape``.
        """
        return np.asarray(
            self.pitch.remaining_integral(s, t) + 1j * self.yaw.remaining_integral(s, t)
        )

    def component(self, angle: ArrayLike) -> History:
        """Return the wind component [rad] along directions, as a history.

        `angle`: directions [rad] from the pitch plane, pi/2 is yaw; broadcasts with ``batch``.
        """
        direction = unit_vector(directions("angle", angle))
        broadcast(wind=self.batch, angle=direction.shape)
        return self.pitch * np.real(direction) + self.yaw * np.imag(direction)

    @cached_property
    def onset(self) -> FloatArray:
        """Time [s] at which the first of both differs from zero, shape ``batch``; inf if never."""
        return np.minimum(self.pitch.onset, self.yaw.onset)

    @cached_property
    def end(self) -> FloatArray:
        """Time [s] from which both histories stay zero, shape ``batch``; inf if endless."""
        return np.maximum(self.pitch.end, self.yaw.end)

    @cached_property
    def square(self) -> History:
        """Squared size of the wind vector [rad^2], as an exact history."""
        return _squared(self.pitch) + _squared(self.yaw)

    @cached_property
    def peak(self) -> FloatArray:
        """Largest size of the wind vector [rad], shape ``batch``.

        Of a wind of one direction it is the peak of the component in that direction; else the root
        of the peak of the squared size, as pitch and yaw may have their peaks at different times.
        """
        along_direction = np.abs(self.component(self.direction).peak)
        if np.all(self.unidirectional):
            return along_direction
        return np.where(
            self.unidirectional, along_direction, np.sqrt(np.maximum(self.square.peak, 0.0))
        )

    @cached_property
    def unidirectional(self) -> BoolArray:
        """Whether the wind vector stays on one line, shape ``batch``.

        It does if all coefficients of pitch and yaw, with the same knots and rates of exponentials,
        have the ratio of `direction`: then the component across that line is zero.
        """
        pitch, yaw = self._terms
        line = unit_vector(self.direction)[..., np.newaxis]
        across = np.abs(yaw * np.real(line) - pitch * np.imag(line))
        return np.asarray(np.all(across <= _ROUNDING * (np.abs(pitch) + np.abs(yaw)), axis=-1))

    @cached_property
    def direction(self) -> Any:
        """Direction [rad] of the wind vector from the pitch plane, shape ``batch``.

        Of a veering wind it is the direction of the term c u^k e^(lambda u) with the largest c.
        """
        pitch, yaw = self._terms
        largest = np.argmax(np.abs(pitch) + np.abs(yaw), axis=-1)[..., np.newaxis]
        x, y = (
            np.take_along_axis(np.real(component), largest, axis=-1)[..., 0]
            for component in (pitch, yaw)
        )
        return plain(np.arctan2(y, x))

    @cached_property
    def _terms(self) -> tuple[AnyArray, AnyArray]:
        """Coefficients of pitch and yaw on common knots and rates, ``(..., m)`` each.

        A wind is a sum of c u^k e^(rate u) in each piece, and m counts all pieces, rates and powers
        k. Adding zero times the other wind gives each the knots and rates of both.
        """
        pitch, yaw = self.pitch.pieces, self.yaw.pieces
        zero = [(0.0 * wind).pieces for wind in (self.pitch, self.yaw)]
        components = algebra.add(pitch, zero[1]), algebra.add(zero[0], yaw)
        c = [
            np.broadcast_to(p.coefficients, (*self.batch, *p.coefficients.shape[-3:]))
            for p in components
        ]
        flat = [array.reshape(*self.batch, int(np.prod(array.shape[-3:]))) for array in c]
        return flat[0], flat[1]


def _veering_component(
    wind: History, direction: FloatArray, rates: FloatArray, shape: tuple[int, ...]
) -> Piecewise:
    """Return the wind times cos(direction + rates (t - onset)), exact: two terms for each term.

    `wind`: wind angle [rad]. `direction`: at its onset [rad]. `rates`: rates of veer [rad/s].
    `shape`: shape of the batch to which all three broadcast. `unit_vector` is exact at right
    angles, where the cosine of a rounded angle is not zero.
    """
    p = algebra.spread(wind.pieces, shape)
    # The cosine is half the sum of exponentials with the rates +j rates and -j rates, which are
    # added to the rates of the wind's terms; of a rate of zero one constant term remains.
    rates = np.broadcast_to(rates, shape)[..., np.newaxis]
    phase = np.broadcast_to(direction - rates[..., 0] * wind.onset, shape)[..., np.newaxis]
    constant = np.where(rates == 0.0, np.real(unit_vector(phase)), 0.0)
    half = np.where(rates == 0.0, 0.0, 0.5 * np.exp(1j * (phase + rates * p.knots)))
    factors = [array[..., np.newaxis, np.newaxis] for array in (half + constant, np.conj(half))]
    coefficients = np.concatenate([p.coefficients * array for array in factors], axis=-2)
    return Piecewise(
        Pieces(
            p.knots,
            coefficients,
            np.concatenate([p.rates + 1j * rates, p.rates - 1j * rates], axis=-1),
        )
    )


def _squared(wind: History) -> Piecewise:
    """Return the square of a wind [rad^2], exact: all products of two terms of a piece.

    Two terms c u^i e^(a u) and d u^k e^(b u), u being the time from the begin of the piece, make
    one of power i + k and rate a + b.
    """
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
