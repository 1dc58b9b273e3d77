"""Control laws: a pure function from measurements to the commanded deflection, and its filters.

A law may have linear states (an integral, an observer): s' = F s + G m with the measurements m. It
keeps no memory itself: the flight passes the states in, so that one law flies many flights at once.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Carded
from tvclin.base.errors import InputError, between, each, instance
from tvclin.boundary.recoverable import UnstableCoordinates, unstable_coordinates
from tvclin.control.autopilot.wiring import SEEN
from tvclin.kernels.control_laws import LawNumbers
from tvclin.linear.plant import Plant
from tvclin.linear.system import LinearSystem
from tvclin.vehicle.filters import Filter

RATES = between(1e-15, 1e9)
"""Check of rate limits [rad/s] that a law knows: from as good as none to as good as any."""
_SHOWN = 3
"""States of the plant that a law is shown."""


class Measurement(NamedTuple):
    """What a law measures, each a number or an array of flights [rad, rad/s]."""

    attitude: Any
    attitude_rate: Any
    flight_path_angle: Any
    angle_of_attack: Any
    deflection: Any


class Chains(NamedTuple):
    """Filters about a law, each chain in the order in which it is passed.

    They run at the sample rate of the flight, by the bilinear rule, each exact at its own
    frequency.

    `attitude`, `attitude_rate`: between a sensor and the law. `demand`: between what the law asks
    for and the limit.
    """

    attitude: tuple[Filter, ...] = ()
    attitude_rate: tuple[Filter, ...] = ()
    demand: tuple[Filter, ...] = ()


class Law(Carded, ABC):
    """A control law, to be flown with `fly`.

    Attributes
    ----------
    engage, release : float
        When the deflection asked for reaches `engage` times the limit, the whole limit is
        commanded until what is asked for, on the same side, falls to `release` times the limit.
        With one and one it is a plain limiter.
    """

    engage: float = 1.0
    release: float = 1.0

    _keys = "engage release"

    @property
    def states(self) -> tuple[FloatArray, FloatArray]:
        """F ``(k, k)`` and G ``(k, 5)`` of its own states: s' = F s + G m. None by default."""
        return np.zeros((0, 0)), np.zeros((0, 5))

    @property
    def memory(self) -> LinearSystem:
        """Its own states, which follow what it is shown (`SEEN`)."""
        F, G = self.states
        names = tuple(f"law_{k}" for k in range(1, len(F) + 1))
        return LinearSystem(F, G, np.eye(len(F)), np.zeros(G.shape), SEEN, names, names)

    @property
    def chains(self) -> Chains:
        """Filters before and behind it. None by default."""
        return Chains()

    @property
    def rate_noise(self) -> tuple[float, int]:
        """Noise of the measured attitude rate [rad/s rms for each sample], and its seed."""
        return 0.0, 0

    @property
    def numbers(self) -> LawNumbers | None:
        """The law as numbers, for compiled flights; None for a law that only Python can ask."""
        return None

    @abstractmethod
    def demand(self, measured: Measurement, states: FloatArray, limit: Any) -> Any:
        """Return the deflection asked for [rad], without limit.

        Parameters
        ----------
        measured : Measurement
            What is measured.
        states : ndarray
            The law's own states, ``(k, ...)``.
        limit : float or ndarray
            The deflection limit [rad], which a law may know, ``(...)``.
        """


def seen_coordinates(plant: Plant) -> UnstableCoordinates:
    """Return the coordinates of the unstable modes in what a law is shown.

    `Measurement` has the attitude, its rate and the flight path angle, which are the first states
    of every plant; ``rows`` is ``(N, 2)`` or ``(N, 3)``.

    `InputError` as `unstable_coordinates`, and for a plant whose unstable modes move its speed.
    """
    modes = unstable_coordinates(plant)
    if np.any(modes.rows[:, _SHOWN:]):
        raise InputError(
            f'a law does not measure the speed, which model "{plant.model}" needs; design the law'
            ' on "drift-exact"'
        )
    return replace(modes, rows=modes.rows[:, :_SHOWN])


def rate_over_pole(plant: Plant, rate_limit: float) -> float:
    """Return r/(p |B|) [rad]: a rate limit r as an angle, with the fastest unstable pole p."""
    pole = float(seen_coordinates(plant).poles[0])
    return rate_limit / (pole * abs(float(plant.coefficients.B)))


@dataclass(frozen=True)
class FilteredLaw(Law):
    """Any law, with filters; for flights by samples.

    Parameters
    ----------
    law : Law
        The law, without filters of its own.
    filters : tuple of Filter
        Between what the law asks for and the limit, as of an `Autopilot`.
    attitude_filters, rate_filters : tuple of Filter
        Between the sensors and the law.

    Raises
    ------
    InputError
        For what is no law or no filter, batches of filters, and a law that has filters already.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> notch = tv.vehicle.Filter.notch(30.0, zero_damping=0.05, pole_damping=0.5)
    >>> law = tv.control.FilteredLaw(tv.TrimLaw(plant), filters=(notch,))
    """

    law: Law
    filters: tuple[Filter, ...] = ()
    attitude_filters: tuple[Filter, ...] = ()
    rate_filters: tuple[Filter, ...] = ()

    def __post_init__(self) -> None:
        instance("law", self.law, Law, "such as TrimLaw")
        if any(self.law.chains):
            raise InputError("law has filters already; give all of them to one FilteredLaw")
        for name in ("filters", "attitude_filters", "rate_filters"):
            chain = each(name, getattr(self, name), Filter, "Filter.notch(...)")
            if any(one.batch for one in chain):
                raise InputError(f"{name} must be single filters; a law flies with one of each")
            object.__setattr__(self, name, chain)
        for name in ("engage", "release"):
            object.__setattr__(self, name, getattr(self.law, name))

    _keys = "law attitude_filters rate_filters filters"

    @property
    def states(self) -> tuple[FloatArray, FloatArray]:
        """Those of the law; the flight keeps those of the filters."""
        return self.law.states

    @property
    def chains(self) -> Chains:
        """The filters."""
        return Chains(self.attitude_filters, self.rate_filters, self.filters)

    @property
    def rate_noise(self) -> tuple[float, int]:
        """That of the law, which its filters pass."""
        return self.law.rate_noise

    @property
    def numbers(self) -> LawNumbers | None:
        """Those of the law."""
        return self.law.numbers

    def demand(self, measured: Measurement, states: FloatArray, limit: Any) -> Any:
        """Return what the law asks for [rad], before the filters behind it."""
        return self.law.demand(measured, states, limit)


@dataclass(frozen=True)
class NoisyLaw(FilteredLaw):
    """A law with filters and a gyro that is noisy: its noise [rad/s], rms for each sample."""

    noise: float = 0.0
    seed: int = 0

    @property
    def rate_noise(self) -> tuple[float, int]:
        """Its own noise."""
        return self.noise, self.seed
