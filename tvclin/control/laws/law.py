"""Control laws: a pure function from measurements to the commanded deflection, and its filters.

A law may have linear states (an integral, an observer): s' = F s + G m with the measurements m. It
keeps no memory itself: the flight passes the states in, so that one law flies many flights at once.

In both planes the scalar law acts along the measured wind and across it, within one limit. Vectors
are complex, pitch + j yaw, rotated into the direction of the wind, so that a nonlinear law leans
with the wind; a linear law is the same in every direction.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.cards import Record
from tvclin.base.errors import InputError, between, each, instance, one_of, unlimited
from tvclin.base.fields import spec
from tvclin.boundary.forecast_free import UnstableCoordinates, unstable_coordinates
from tvclin.boundary.limit_shapes import LimitShape, Vectors, limit_shape_of
from tvclin.control.autopilot.wiring import LAW_INPUTS
from tvclin.kernels.control_laws import LawNumbers, law_demand
from tvclin.linear.lateral import NO_LATERAL_SENSORS, LateralSensors
from tvclin.linear.plant import Plant
from tvclin.linear.system import LinearSystem
from tvclin.vehicle.filters import Filter

_MEASURED_STATES = 3
"""Number of plant states that a law measures: attitude, its rate, flight path angle."""


def law_rate_limit(name: str, value: ArrayLike, unit: str = "rad/s") -> float:
    """Return the rate limit [rad/s] of a law: infinite, or 1e-15 to 1e9; not zero, a divisor.

    `name`, `unit`: of the argument, for the `InputError` on another `value`.
    """
    return unlimited(name, value, between(1e-15, 1e9), unit)


class Measurement(NamedTuple):
    """Measurements of a law, each a number or an array over flights.

    Angles and angular rates [rad, rad/s]; and where its `Law.lateral_sensors` measure them, else
    zero, the lateral drift rate [m/s], the drift [m], and the lateral acceleration [m/s^2].
    """

    attitude: Any
    attitude_rate: Any
    flight_path_angle: Any
    angle_of_attack: Any
    deflection: Any
    drift_rate: Any = 0.0
    drift: Any = 0.0
    acceleration: Any = 0.0


class Chains(NamedTuple):
    """Filter chains of a law, each filter in the order of the signal.

    They run at the sample rate of the flight, by the bilinear rule, each exact at its own
    frequency.

    `attitude`, `attitude_rate`: between sensor and law. `demand`: between law and limit.
    """

    attitude: tuple[Filter, ...] = ()
    attitude_rate: tuple[Filter, ...] = ()
    demand: tuple[Filter, ...] = ()


class Law(Record, ABC):
    """A control law, to be flown with `fly`.

    Attributes
    ----------
    engage, release : float
        When the demanded deflection reaches `engage` times the limit, the full limit is commanded
        until the demand, of the same sign, falls to `release` times the limit. With one and one
        it is a plain limiter.
    """

    engage: float = 1.0
    release: float = 1.0

    @property
    def states(self) -> tuple[FloatArray, FloatArray]:
        """F ``(k, k)`` and G ``(k, 5)`` of s' = F s + G m, s being k states of the law.

        m: attitude, its rate, flight path angle, angle of attack, deflection. By default k is zero.
        """
        return np.zeros((0, 0)), np.zeros((0, 5))

    @property
    def state_space(self) -> LinearSystem:
        """State space from the measurements, by the names `LAW_INPUTS`, to the law's states."""
        F, G = self.states
        # The states follow no lateral sensors, the last inputs.
        G = np.pad(G, ((0, 0), (0, len(LAW_INPUTS) - G.shape[1])))
        C, D = np.eye(len(F)), np.zeros(G.shape)
        names = tuple(f"law_{k}" for k in range(1, len(F) + 1))
        return LinearSystem(F, G, C, D, inputs=LAW_INPUTS, outputs=names, states=names)

    @property
    def chains(self) -> Chains:
        """Filter chains of the law; empty by default."""
        return Chains()

    @property
    def lateral_sensors(self) -> LateralSensors:
        """Sensors of lateral motion that the law has; none by default."""
        return NO_LATERAL_SENSORS

    @property
    def rate_noise(self) -> tuple[float, int]:
        """Noise of the measured attitude rate [rad/s rms of each sample], and its seed."""
        return 0.0, 0

    @property
    def numbers(self) -> LawNumbers | None:
        """Parameters of the law for compiled flights; None for a law that only Python evaluates."""
        return None

    @abstractmethod
    def demand(self, measured: Measurement, states: FloatArray, limit: Any) -> Any:
        """Return the demanded deflection [rad], before the limit, ``(...)`` over flights.

        `measured`: measurements [rad, rad/s], numbers or ``(...)``. `states`: states of the law,
        ``(k, ...)``. `limit`: deflection limit [rad], which a law may use, ``(...)``.
        """


class LinearLaw(Law):
    """Law that is linear in measurements and states; its `numbers` are its gains."""

    @property
    @abstractmethod
    def numbers(self) -> LawNumbers:
        """Gains of the law, for flights in Python and as machine code."""

    def demand(self, measured: Measurement, states: FloatArray, limit: Any) -> Any:
        """Return the demanded deflection [rad], before the limit: gains times measurements.

        `measured`: numbers or ``(...)`` over flights. `states`: of the law, ``(k, ...)``, which
        have gains too. `limit`: is not used by a linear law.
        """
        return law_demand(self.numbers, measured, states, limit)


def measured_coordinates(plant: Plant) -> UnstableCoordinates:
    """Return the coordinates of the unstable modes of a plant as combinations of measurements.

    Attitude, its rate and the flight path angle are the first states of every plant; the left
    eigenvectors, whose product with the states is the coordinate, are ``(N, 3)``; on a fixed path
    the last of each is zero.
    `InputError` for a plant without a real unstable pole, and one whose unstable modes include its
    speed, the fourth state.
    """
    modes = unstable_coordinates(plant)
    if np.any(modes.left_eigenvectors[:, _MEASURED_STATES:]):
        raise InputError(
            f'a law does not measure the speed, which model "{plant.model}" needs; design the law'
            ' on "drift-exact"'
        )
    rows = np.pad(modes.left_eigenvectors, ((0, 0), (0, 1)))[:, :_MEASURED_STATES]
    return replace(modes, left_eigenvectors=rows)


def rate_limit_angle(plant: Plant, rate_limit: float) -> float:
    """Return the wind angle r/(p |B|) [rad] of a rate limit r [rad/s].

    It is the wind angle whose trim deflection the nozzle turns by at the rate r in the time 1/p. p
    is the fastest unstable pole [1/s] of the plant, and B its trim deflection per wind angle.
    """
    pole = float(measured_coordinates(plant).poles[0])
    return rate_limit / (pole * abs(float(plant.coefficients.B)))


@dataclass(frozen=True)
class FilteredLaw(Law):
    """Law with filters, for sampled flights.

    Parameters
    ----------
    law : Law
        The law, without filters.
    filters : tuple of Filter
        Filters between the law's demand and the limit, as in `Autopilot`.
    attitude_filters, rate_filters : tuple of Filter
        Filters between the sensors and the law.

    Raises
    ------
    InputError
        For another type than law or filter, batches of filters, and a law with filters.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> notch = tv.vehicle.Filter.notch(30.0, zero_damping=0.05, pole_damping=0.5)
    >>> law = tv.control.FilteredLaw(tv.TrimLaw(plant), filters=(notch,))
    """

    law: Law = field(metadata=spec())
    filters: tuple[Filter, ...] = field(default=(), metadata=spec())
    attitude_filters: tuple[Filter, ...] = field(default=(), metadata=spec())
    rate_filters: tuple[Filter, ...] = field(default=(), metadata=spec())

    def __post_init__(self) -> None:
        """Check law and filters, and take `engage` and `release` of the law: its switching levels.

        They are ratios of the demand to the limit at which the full limit begins and ends.
        """
        instance("law", self.law, Law, "such as TrimLaw")
        if any(self.law.chains):
            raise InputError("law has filters already; give all of them to one FilteredLaw")
        for name in ("filters", "attitude_filters", "rate_filters"):
            chain = each(name, getattr(self, name), Filter, "Filter.notch(...)")
            if any(filter_.batch for filter_ in chain):
                raise InputError(f"{name} must be single filters; a law flies with one of each")
            object.__setattr__(self, name, chain)
        for name in ("engage", "release"):
            object.__setattr__(self, name, getattr(self.law, name))

    @property
    def states(self) -> tuple[FloatArray, FloatArray]:
        """F and G of s' = F s + G m, s being states of the law without its filters.

        m: measurements. The states of the filters are not in s: samples update them.
        """
        return self.law.states

    @property
    def state_space(self) -> LinearSystem:
        """State space of the law without filters."""
        return self.law.state_space

    @property
    def chains(self) -> Chains:
        """Filter chains of attitude, rate and demand."""
        return Chains(
            attitude=self.attitude_filters, attitude_rate=self.rate_filters, demand=self.filters
        )

    @property
    def lateral_sensors(self) -> LateralSensors:
        """Sensors of lateral motion of the law without filters."""
        return self.law.lateral_sensors

    @property
    def rate_noise(self) -> tuple[float, int]:
        """Noise of the attitude rate [rad/s] and its seed, from the law without filters."""
        return self.law.rate_noise

    @property
    def numbers(self) -> LawNumbers | None:
        """Parameters of the law for compiled flights, without filters."""
        return self.law.numbers

    def demand(self, measured: Measurement, states: FloatArray, limit: Any) -> Any:
        """Return the deflection [rad] that the unfiltered `law` demands, before `limit` [rad].

        `measured`, `states`: measurements behind the filters, and states of the law.
        """
        return self.law.demand(measured, states, limit)


@dataclass(frozen=True)
class NoisyLaw(FilteredLaw):
    """Law with filters and a noisy gyro; `noise` [rad/s] is the rms of each sample."""

    noise: float = 0.0
    seed: int = 0

    @property
    def rate_noise(self) -> tuple[float, int]:
        """Noise of the attitude rate [rad/s rms of each sample], and its seed."""
        return self.noise, self.seed


SATURATE = ("radial", "each plane")


@dataclass(frozen=True)
class LawInPlanes:
    """Law for both planes, and the saturation of its demand.

    `law`: one law. `limit_shape`: of the nozzle. `saturate`: "radial" if the limited demand
    keeps its direction, "each plane" if each component is limited by the largest rectangle within
    the shape. `InputError` for another type than a law, a law that switches, has filters or noise,
    and unknown words.
    """

    law: Law
    limit_shape: LimitShape | str = "round"
    saturate: str = "radial"

    def __post_init__(self) -> None:
        """Check that the law is continuous, without filters and noise, and the word `saturate`."""
        law = self.law
        instance("law", law, Law, "such as TrimLaw")
        if (law.engage, law.release) != (1.0, 1.0):
            raise InputError("law must not switch to the whole limit: that has one direction only")
        noise, _seed = law.rate_noise
        if any(law.chains) or noise:
            raise InputError("law must be without filters and noise in two planes")
        one_of("saturate", self.saturate, SATURATE)

    @property
    def radial(self) -> bool:
        """Whether the limited demand keeps its direction."""
        return self.saturate == "radial"

    @cached_property
    def shape(self) -> LimitShape:
        """Limit shape for a unit limit: the nozzle's, or without `radial` a rectangle within it."""
        limit_shape = limit_shape_of(self.limit_shape).inside
        return limit_shape if self.radial else limit_shape.each_plane()

    @cached_property
    def plane_limits(self) -> FloatArray:
        """Largest pitch and yaw deflection of the limit shape, ``(2,)``."""
        return self.shape.plane_limits

    def demand(self, measured: Vectors, states: Vectors, limit: FloatArray) -> Vectors:
        """Return the demands [rad] of m flights, before the limit, pitch + j yaw, ``(m,)``.

        With a radial limit the scalar law acts along the measured wind and across it, each with the
        limit of the shape in that direction; else in pitch and in yaw.

        `measured`: measurements of both planes in the order of `Measurement`, complex ``(m, 8)``.
        `states`: states of the law, complex ``(m, k)``. `limit`: scale [rad] of the limit shape,
        ``(m,)``.
        """
        if not self.radial:
            limits = [limit * plane_limit for plane_limit in self.plane_limits]
            return self._by_components(measured, states, limits)
        # The wind is attitude - alpha - path angle; an estimator estimates attitude - alpha.
        attitude, _, path, alpha, *_ = measured.T  # in the order of `Measurement`
        estimates = getattr(self.law, "estimator", None) is not None
        wind = (states[:, 1] if estimates else attitude - alpha) - path
        size = np.abs(wind)
        direction = np.where(size > 0.0, wind / np.where(size > 0.0, size, 1.0), 1.0)
        shape, rotation = self.shape, np.conj(direction)[:, np.newaxis]
        # the gauge of a unit vector is one over the limit in its direction
        limits = [
            limit / np.maximum(shape.gauge(axis), shape.gauge(-axis))
            for axis in (direction, 1j * direction)
        ]
        demand = self._by_components(measured * rotation, states * rotation, limits)
        return np.asarray(direction * demand)

    def limited(self, demand: Vectors, limit: FloatArray) -> tuple[Vectors, BoolArray]:
        """Return the limited demands [rad] of m flights, and whether on the limit, ``(m,)`` each.

        With `radial` a demand outside the limit shape keeps its direction; else each plane is
        limited separately, to `plane_limits` times the scale. `demand`: pitch + j yaw [rad],
        ``(m,)``. `limit`: scale [rad] of the limit shape, ``(m,)``.
        """
        if self.radial:
            with np.errstate(over="ignore"):  # the limit may be the smallest positive number
                ratio = self.shape.gauge(demand) / limit
            return demand / np.maximum(ratio, 1.0), ratio >= 1.0
        bounds = self.plane_limits[:, np.newaxis] * limit
        components = np.stack([demand.real, demand.imag])
        pitch, yaw = np.clip(components, -bounds, bounds)
        return pitch + 1j * yaw, np.any(np.abs(components) >= bounds, axis=0)

    def _by_components(
        self, measured: Vectors, states: Vectors, limits: list[FloatArray]
    ) -> Vectors:
        """Return the demands [rad] of the scalar law in two directions, real + j imaginary.

        Of m flights, ``(m,)``. `measured` ``(m, 8)`` and `states` ``(m, k)``: complex, of both
        directions. `limits`: deflection limits [rad] of the real and of the imaginary direction,
        ``(m,)`` each.
        """
        real, imaginary = (
            np.asarray(self.law.demand(Measurement(*take(measured).T), take(states).T, limit))
            for take, limit in zip((np.real, np.imag), limits, strict=True)
        )
        return np.asarray(real + 1j * imaginary)
