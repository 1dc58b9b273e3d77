"""Bending, slosh and engine inertia of a vehicle, and the lags of its sensors: all optional.

Stations are measured forward from the centre of gravity of the whole vehicle, liquid frozen and
engine straight; displacements are positive up and slopes are per metre forward. Mass, inertia and
arms of the `Vehicle` are those of the whole: liquid and engine are in them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray, IndexArray
from tvclin.base.cards import Row, card, lines
from tvclin.base.errors import (
    InputError,
    between,
    broadcast,
    each,
    flag,
    instance,
    plain,
    shown,
)
from tvclin.vehicle.filters import Filter

Number = float | FloatArray
Check = Callable[..., FloatArray]

_LARGEST = 1e12
_size = between(1.0 / _LARGEST, _LARGEST)
_any = between(-_LARGEST, _LARGEST)
_damping = between(0.0, 1e3)
_inertia = between(0.0, _LARGEST**2)


class _Batched:
    @cached_property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for one."""
        return broadcast(**dict(_shapes(self, "")))


@dataclass(frozen=True, kw_only=True)
class BendingMode(_Batched):
    """A free-free bending mode of the whole vehicle, or a batch of them.

    Displacements and slopes belong together with the modal mass: all displacements and slopes times
    c and the mass times c^2 are the same mode.

    Parameters
    ----------
    frequency : array_like
        Natural frequency [rad/s], positive: liquid frozen, engine locked, under axial load.
    damping : array_like
        Damping ratio, zero or positive.
    modal_mass : array_like
        Modal mass [kg], positive.
    gimbal_displacement, gimbal_slope : array_like
        Displacement, and slope [1/m], at the gimbal.
    attitude_slope, rate_slope : array_like
        Slopes [1/m] at the attitude sensor and at the rate gyro.
    pressure_displacement : array_like
        Displacement at the centre of pressure.
    tank_displacements, tank_slopes : tuple of array_like
        Displacement, and slope [1/m], at each tank, in the order of `Structure.slosh`; empty: the
        mode does not move the tanks.

    Raises
    ------
    InputError
        For a damping below zero, sizes beyond 1e-12 to 1e12, and shapes that do not broadcast.
    """

    frequency: Number
    damping: Number
    modal_mass: Number
    gimbal_displacement: Number
    gimbal_slope: Number
    attitude_slope: Number
    rate_slope: Number
    pressure_displacement: Number = 0.0
    tank_displacements: tuple[Number, ...] = ()
    tank_slopes: tuple[Number, ...] = ()

    def __post_init__(self) -> None:
        _keep(self, _OF_BENDING)
        for name, unit in (("tank_displacements", ""), ("tank_slopes", "1/m")):
            given = getattr(self, name)
            if not isinstance(given, tuple | list):
                raise InputError(f"{name} must be a tuple, one for each tank; got {shown(given)}")
            values = tuple(plain(_any(f"{name}[{k}]", one, unit)) for k, one in enumerate(given))
            object.__setattr__(self, name, values)
        _ = self.batch  # refuses shapes that do not broadcast


@dataclass(frozen=True, kw_only=True)
class SloshTank(_Batched):
    """The liquid of one tank that sloshes, as a pendulum or as a sliding mass, or a batch of them.

    Parameters
    ----------
    mass : array_like
        Sloshing mass [kg], positive; a part of the vehicle's mass.
    station : array_like
        Where the mass rests [m], forward of the centre of gravity. The hinge of a pendulum lies
        its length ahead of that.
    damping : array_like
        Damping ratio, zero or positive.
    pendulum_length : array_like, optional
        Length [m] of the pendulum, positive: omega^2 = (T - F_A)/(m L).
    frequency : array_like, optional
        In its place the natural frequency [rad/s], positive, with the vehicle held.

    Raises
    ------
    InputError
        As `BendingMode`, and unless one of length and frequency is given.
    """

    mass: Number
    station: Number
    damping: Number
    pendulum_length: Number | None = None
    frequency: Number | None = None

    def __post_init__(self) -> None:
        if (self.pendulum_length is None) == (self.frequency is None):
            raise InputError("a slosh tank needs a pendulum_length or a frequency, and not both")
        unknown = "frequency" if self.frequency is None else "pendulum_length"
        _keep(self, tuple(check for check in _OF_SLOSH if check[0] != unknown))
        _ = self.batch  # refuses shapes that do not broadcast


@dataclass(frozen=True, kw_only=True)
class Engine(_Batched):
    """The part of an engine that turns about its gimbal, or a batch of them.

    Parameters
    ----------
    mass : array_like
        Mass that turns m_E [kg], positive; a part of the vehicle's mass.
    arm : array_like
        Its centre of gravity l_E [m], aft of the gimbal.
    moment_of_inertia : array_like
        Its moment of inertia I_E [kg m^2] about that centre of gravity; zero or positive, and
        positive where the arm is zero.

    Raises
    ------
    InputError
        As `BendingMode`.
    """

    mass: Number
    arm: Number
    moment_of_inertia: Number = 0.0

    def __post_init__(self) -> None:
        _keep(self, _OF_ENGINES)
        _ = self.batch  # refuses shapes that do not broadcast
        if np.any(np.asarray(self.inertia_about_gimbal) == 0.0):
            raise InputError("an engine needs an arm or a moment_of_inertia other than zero")

    @property
    def static_moment(self) -> Number:
        """s_E = m_E l_E [kg m]."""
        return self.mass * self.arm

    @property
    def inertia_about_gimbal(self) -> Number:
        """J_E = I_E + m_E l_E^2 [kg m^2]."""
        return self.moment_of_inertia + self.mass * self.arm**2


@dataclass(frozen=True, kw_only=True)
class Structure(_Batched):
    """All that a flexible vehicle adds to the rigid one, or a batch of it.

    Parameters
    ----------
    bending : tuple of BendingMode
        Bending modes.
    slosh : tuple of SloshTank
        Tanks.
    engine : Engine, optional
        Without one the engine has no inertia.
    attitude_sensor, rate_gyro : Filter, optional
        Lags of the sensors; without one a sensor follows at once.
    thrust_follows : bool
        Whether the thrust turns with the slope of the bent gimbal.

    Raises
    ------
    InputError
        For a mode with displacements or slopes at another number of tanks than there are, and
        shapes that do not broadcast.
    """

    bending: tuple[BendingMode, ...] = ()
    slosh: tuple[SloshTank, ...] = ()
    engine: Engine | None = None
    attitude_sensor: Filter | None = None
    rate_gyro: Filter | None = None
    thrust_follows: bool = True

    def __post_init__(self) -> None:
        for name, kind in (("bending", BendingMode), ("slosh", SloshTank)):
            maker = f"{kind.__name__}(...)"
            object.__setattr__(self, name, each(name, getattr(self, name), kind, maker))
        if self.engine is not None:
            instance("engine", self.engine, Engine, "Engine(mass=..., arm=...)")
        for name in ("attitude_sensor", "rate_gyro"):
            if getattr(self, name) is not None:
                instance(name, getattr(self, name), Filter, "Filter.low_pass(...)")
        object.__setattr__(self, "thrust_follows", flag("thrust_follows", self.thrust_follows))
        for k, mode in enumerate(self.bending, start=1):
            for name in ("tank_displacements", "tank_slopes"):
                if len(getattr(mode, name)) not in {0, len(self.slosh)}:
                    raise InputError(
                        f"{name} of bending mode {k} must be one for each of {len(self.slosh)}"
                        f" tanks, or none; got {len(getattr(mode, name))}"
                    )
        _ = self.batch  # refuses shapes that do not broadcast

    def _rows(self) -> list[Row]:
        rows: list[Row] = []
        for k, mode in enumerate(self.bending, start=1):
            rows += [(f"bending {k}, frequency", mode.frequency, "rad/s")]
            rows += [(f"bending {k}, damping", mode.damping, "-")]
        for k, tank in enumerate(self.slosh, start=1):
            rows += [(f"slosh {k}, mass", tank.mass, "kg"), (f"slosh {k}, at", tank.station, "m")]
        if self.engine is not None:
            rows += [("engine, mass", self.engine.mass, "kg")]
        return rows

    @property
    def parts(self) -> str:
        """What bends, sloshes, swings and lags, in words."""
        counted = (("bending mode", len(self.bending)), ("tank", len(self.slosh)))
        words = [f"{count} {name}{'s' * (count > 1)}" for name, count in counted if count]
        words += ["engine with inertia"] * (self.engine is not None)
        lags = {"attitude sensor": self.attitude_sensor, "rate gyro": self.rate_gyro}
        words += [f"lag of the {name}" for name, lag in lags.items() if lag is not None]
        return ", ".join(words)

    def _repr_html_(self) -> str:
        return card("Structure", self._rows())

    def __repr__(self) -> str:
        return lines("Structure", self._rows())

    @property
    def is_rigid(self) -> bool:
        """Whether nothing bends, sloshes or swings, and no sensor lags."""
        parts = (self.engine, self.attitude_sensor, self.rate_gyro)
        return not (self.bending or self.slosh) and all(part is None for part in parts)


def chosen(value: Any, cases: IndexArray | int, shape: tuple[int, ...]) -> Any:
    """Return some of a batch spread to `shape`, ``(k,)``, or one, by flat positions there."""
    if isinstance(value, Filter):
        rows = [
            np.broadcast_to(one, (*shape, one.shape[-1]))
            for one in (value.numerator, value.denominator)
        ]
        return Filter(*(one.reshape(-1, one.shape[-1])[cases] for one in rows))
    if isinstance(value, tuple):
        return tuple(chosen(one, cases, shape) for one in value)
    if is_dataclass(value):
        parts = {one.name: chosen(getattr(value, one.name), cases, shape) for one in fields(value)}
        kind: Any = type(value)
        return kind(**parts)
    if value is None or isinstance(value, bool | str):
        return value
    return np.broadcast_to(value, shape).ravel()[cases]


def _keep(value: Any, checks: tuple[tuple[str, Check, str], ...]) -> None:
    """Put the checked numbers of a frozen value in place of those that were given."""
    for name, check, unit in checks:
        array = check(name, getattr(value, name), unit)
        object.__setattr__(value, name, plain(array))


def _shapes(value: Any, name: str) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Yield the shapes of all numbers in a value, each by the words that lead to it."""
    if isinstance(value, Filter):
        yield name, value.batch
    elif is_dataclass(value):
        for one in fields(value):
            yield from _shapes(getattr(value, one.name), f"{name} {one.name}".strip())
    elif isinstance(value, tuple):
        for k, one in enumerate(value, start=1):
            yield from _shapes(one, f"{name} {k}")
    else:
        yield name, np.shape(value)


_OF_BENDING = (
    ("frequency", _size, "rad/s"),
    ("damping", _damping, ""),
    ("modal_mass", _size, "kg"),
    ("gimbal_displacement", _any, ""),
    ("gimbal_slope", _any, "1/m"),
    ("attitude_slope", _any, "1/m"),
    ("rate_slope", _any, "1/m"),
    ("pressure_displacement", _any, ""),
)
_OF_SLOSH = (
    ("mass", _size, "kg"),
    ("station", _any, "m"),
    ("damping", _damping, ""),
    ("pendulum_length", _size, "m"),
    ("frequency", _size, "rad/s"),
)
_OF_ENGINES = (("mass", _size, "kg"), ("arm", _any, "m"), ("moment_of_inertia", _inertia, "kg m^2"))
