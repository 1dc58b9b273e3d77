"""Bending, slosh and engine inertia of a flexible vehicle, and the lags of its sensors.

Stations are measured forward from the centre of gravity of the complete vehicle, liquid frozen and
engine straight; displacements are positive up and slopes are per metre forward. Mass, inertia and
arms of the `Vehicle` include liquid and engine.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.base.arrays import IndexArray, Real
from tvclin.base.cards import Row, card, card_rows, lines
from tvclin.base.errors import InputError, between, broadcast, each, flag, instance, plain, shown
from tvclin.base.fields import fields_of, quantity
from tvclin.base.lines import Line, Table, plural, significant
from tvclin.vehicle.filters import Filter, filter_cells

_MAX_NUMBER = 1e12
"""Largest size of a number, in SI units."""
_positive_size = between(1.0 / _MAX_NUMBER, _MAX_NUMBER)
_bounded = between(-_MAX_NUMBER, _MAX_NUMBER)
_damping = between(0.0, 1e3)
_inertia = between(0.0, _MAX_NUMBER**2)


@dataclass(frozen=True)
class _Batched:
    """Part of a structure whose numbers belong to one vehicle or to a batch."""

    def __post_init__(self) -> None:
        """Check all numbers, and set each to a float or an array.

        A number whose default is None may be None. `InputError` for shapes that do not broadcast.
        """
        optional = {item.name for item in fields(self) if item.default is None}
        for item in fields_of(self):
            value = item.si_value(self)
            if value is not None or item.name not in optional:
                checked = item.check(item.name, value, item.si_unit)
                object.__setattr__(self, item.name, plain(checked))
        _ = self.batch  # raises unless the shapes broadcast

    @cached_property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for one structure."""
        return broadcast(**dict(_shapes(self, "")))


@dataclass(frozen=True, kw_only=True)
class BendingMode(_Batched):
    """Free-free bending mode of the complete vehicle, or a batch of modes.

    Displacements, slopes and modal mass have one normalisation: displacements and slopes times c
    and the mass times c^2 are the same mode.

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
    drift_displacement : array_like
        Displacement at the inertial unit that measures drift and drift rate.
    accelerometer_displacement, accelerometer_slope : array_like
        Displacement, and slope [1/m], at the lateral accelerometer.
    tank_displacements, tank_slopes : tuple of array_like
        Displacement, and slope [1/m], at each tank, in the order of `Structure.slosh`; empty: the
        mode does not move the tanks.

    Raises
    ------
    InputError
        For a damping below zero, sizes beyond 1e-12 to 1e12, and shapes that do not broadcast.
    """

    frequency: Real = quantity("natural frequency", check=_positive_size)
    damping: Real = quantity("number", check=_damping)
    modal_mass: Real = quantity("mass", check=_positive_size, card=False)
    gimbal_displacement: Real = quantity("number", check=_bounded, card=False)
    gimbal_slope: Real = quantity("per length", check=_bounded, card=False)
    attitude_slope: Real = quantity("per length", check=_bounded, card=False)
    rate_slope: Real = quantity("per length", check=_bounded, card=False)
    pressure_displacement: Real = quantity("number", 0.0, _bounded, card=False)
    drift_displacement: Real = quantity("number", 0.0, _bounded, card=False)
    accelerometer_displacement: Real = quantity("number", 0.0, _bounded, card=False)
    accelerometer_slope: Real = quantity("per length", 0.0, _bounded, card=False)
    tank_displacements: tuple[Real, ...] = ()
    tank_slopes: tuple[Real, ...] = ()

    def __post_init__(self) -> None:
        """Check displacements and slopes at the tanks, then all other numbers."""
        for name, unit in (("tank_displacements", ""), ("tank_slopes", "1/m")):
            sequence = getattr(self, name)
            if not isinstance(sequence, tuple | list):
                raise InputError(
                    f"{name} must be a tuple, one for each tank; got {shown(sequence)}"
                )
            values = tuple(
                plain(_bounded(f"{name}[{k}]", value, unit)) for k, value in enumerate(sequence)
            )
            object.__setattr__(self, name, values)
        super().__post_init__()


@dataclass(frozen=True, kw_only=True)
class SloshTank(_Batched):
    """Sloshing liquid of a tank, as a pendulum or as a sliding mass, or a batch of them.

    Parameters
    ----------
    mass : array_like
        Sloshing mass [kg], positive; included in the vehicle's mass.
    station : array_like
        Equilibrium station of the mass [m], forward of the centre of gravity. The hinge of a
        pendulum lies its length ahead of it.
    damping : array_like
        Damping ratio, zero or positive.
    pendulum_length : array_like, optional
        Length [m] of the pendulum, positive: omega^2 = (T - F_A)/(m L).
    frequency : array_like, optional
        Natural frequency [rad/s] in its place, positive, of the fixed vehicle.

    Raises
    ------
    InputError
        As `BendingMode`, and unless either length or frequency is given.
    """

    mass: Real = quantity("mass", check=_positive_size)
    station: Real = quantity("length", check=_bounded)
    damping: Real = quantity("number", check=_damping, card=False)
    pendulum_length: Real | None = quantity("length", None, _positive_size, card=False)
    frequency: Real | None = quantity("natural frequency", None, _positive_size, card=False)

    def __post_init__(self) -> None:
        """Check that either length or frequency is given, then all numbers."""
        if (self.pendulum_length is None) == (self.frequency is None):
            raise InputError("a slosh tank needs a pendulum_length or a frequency, and not both")
        super().__post_init__()


@dataclass(frozen=True, kw_only=True)
class Engine(_Batched):
    """Inertia of an engine about its gimbal, or a batch of engines.

    Parameters
    ----------
    mass : array_like
        Moving mass m_E [kg], positive; included in the vehicle's mass.
    arm : array_like
        Distance l_E [m] of its centre of gravity aft of the gimbal.
    moment_of_inertia : array_like
        Moment of inertia I_E [kg m^2] about that centre of gravity; zero or positive, and
        positive where the arm is zero.

    Raises
    ------
    InputError
        As `BendingMode`.
    """

    mass: Real = quantity("mass", check=_positive_size)
    arm: Real = quantity("length", check=_bounded, card=False)
    moment_of_inertia: Real = quantity("inertia", 0.0, _inertia, card=False)

    def __post_init__(self) -> None:
        """Check all numbers, and that the inertia about the gimbal is not zero."""
        super().__post_init__()
        if np.any(np.asarray(self.inertia_about_gimbal) == 0.0):
            raise InputError("an engine needs an arm or a moment_of_inertia other than zero")

    @property
    def static_moment(self) -> Real:
        """Static moment s_E = m_E l_E [kg m]."""
        return self.mass * self.arm

    @property
    def inertia_about_gimbal(self) -> Real:
        """Moment of inertia about the gimbal J_E = I_E + m_E l_E^2 [kg m^2]."""
        return self.moment_of_inertia + self.mass * self.arm**2


@dataclass(frozen=True, kw_only=True)
class Structure(_Batched):
    """Structure of a flexible vehicle, in addition to the rigid vehicle, or a batch.

    Parameters
    ----------
    bending : tuple of BendingMode
        Bending modes.
    slosh : tuple of SloshTank
        Tanks.
    engine : Engine, optional
        Engine with inertia; by default the engine has none.
    attitude_sensor, rate_gyro : Filter, optional
        Lags of the sensors; by default a sensor has none.
    thrust_follows : bool
        Whether the thrust turns with the slope of the bent gimbal.

    Raises
    ------
    InputError
        For a mode with displacements or slopes at a wrong number of tanks, and shapes that do
        not broadcast.
    """

    bending: tuple[BendingMode, ...] = ()
    slosh: tuple[SloshTank, ...] = ()
    engine: Engine | None = None
    attitude_sensor: Filter | None = None
    rate_gyro: Filter | None = None
    thrust_follows: bool = True

    def __post_init__(self) -> None:
        """Check the elements; a mode has displacements and slopes at all tanks, or none."""
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
        super().__post_init__()

    def tables(self) -> list[Table]:
        """Return the tables of bending modes, tanks, engine and sensors that exist, in SI units."""
        tables = [
            _element_table(kind, elements) for kind, elements in self._elements.items() if elements
        ]
        lags = {"attitude": self.attitude_sensor, "rate gyro": self.rate_gyro}
        sensors = tuple(
            ((name,), *filter_cells(lag, f"structure.{name.replace(' ', '_')}"))
            for name, lag in lags.items()
            if lag is not None
        )
        head = ("sensor", "zeros", "poles", "gain")
        return [*tables, *([Table("Sensors", head, sensors)] if sensors else [])]

    def _rows(self) -> list[Row]:
        """Return label, value and unit of every number of modes, tanks and engine, for `repr`."""
        return [
            (f"{kind} {k}, {label}".replace("engine 1,", "engine,"), value, unit)
            for kind, elements in self._elements.items()
            for k, element in enumerate(elements, start=1)
            for label, value, unit in card_rows(element)
        ]

    @property
    def _elements(self) -> dict[str, tuple[Any, ...]]:
        """Modes, tanks and engine by kind: "bending", "slosh" and "engine"."""
        engine = () if self.engine is None else (self.engine,)
        return {"bending": self.bending, "slosh": self.slosh, "engine": engine}

    @property
    def parts(self) -> str:
        """Text that lists modes, tanks, engine and lags of the structure."""
        counted = (("bending mode", len(self.bending)), ("tank", len(self.slosh)))
        texts = [plural(count, name) for name, count in counted if count]
        texts += [] if self.engine is None else ["engine with inertia"]
        lags = {"attitude sensor": self.attitude_sensor, "rate gyro": self.rate_gyro}
        texts += [f"lag of the {name}" for name, lag in lags.items() if lag is not None]
        return ", ".join(texts)

    def _repr_html_(self) -> str:
        """Return modes, tanks and engine as a table in HTML."""
        return card("Structure", self._rows())

    def __repr__(self) -> str:
        """Return modes, tanks and engine as lines of text."""
        return lines("Structure", self._rows())

    @property
    def is_rigid(self) -> bool:
        """Whether the structure has no mode, tank, engine or lag."""
        return not self.parts


def select_cases(value: Any, cases: IndexArray | int, shape: tuple[int, ...]) -> Any:
    """Return `value` with its numbers for some cases of a batch of the shape `shape`.

    `value`: a vehicle, a structure, an element or a number of them; its numbers broadcast to
    `shape`. `cases`: flat positions ``(k,)`` in the batch, or one position.
    """
    if isinstance(value, Filter):
        polynomials = [
            np.broadcast_to(coefficients, (*shape, coefficients.shape[-1]))
            for coefficients in (value.numerator, value.denominator)
        ]
        return Filter(*(rows.reshape(-1, rows.shape[-1])[cases] for rows in polynomials))
    if isinstance(value, tuple):
        return tuple(select_cases(element, cases, shape) for element in value)
    if is_dataclass(value):
        numbers = {
            field.name: select_cases(getattr(value, field.name), cases, shape)
            for field in fields(value)
        }
        kind: Any = type(value)
        return kind(**numbers)
    if value is None or isinstance(value, bool | str):
        return value
    return np.broadcast_to(value, shape).ravel()[cases]


def _shapes(value: Any, name: str) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Yield name and shape of every number in `value`: a structure, an element or a number.

    `name`: of the value; a number of an element has names such as "bending 1 frequency".
    """
    if isinstance(value, Filter):
        yield name, value.batch
    elif is_dataclass(value):
        for element in fields(value):
            yield from _shapes(getattr(value, element.name), f"{name} {element.name}".strip())
    elif isinstance(value, tuple):
        for k, element in enumerate(value, start=1):
            yield from _shapes(element, f"{name} {k}")
    else:
        yield name, np.shape(value)


def _element_table(kind: str, elements: Sequence[Any]) -> Table:
    """Return the table of one or more elements of a `kind`, such as "bending", a column each.

    A quantity that none of them has is omitted.
    """
    rows: list[tuple[Line, ...]] = []
    for item in fields_of(elements[0]):  # label, unit and value of each quantity
        values = [item.value(element) for element in elements]
        if any(value is not None for value in values):
            cells = (
                ("-",)
                if value is None
                else significant(f"structure.{kind}.{k}.{item.name}", value, 6)
                for k, value in enumerate(values)
            )
            rows.append(((item.heading,), *cells))
    head = ("quantity", *(f"{kind} {k}" for k in range(1, len(elements) + 1)))
    return Table(kind.capitalize(), head, tuple(rows))
