"""Vehicle: the nine numbers of Table I, a damping, and the structure of a flexible vehicle.

The damping of the attitude rate M_q [N m s/rad] is the sum of that by the air and by the jet:

    aerodynamic:  M_q = -C_mq q S L^2/(f V),    f = 2 where C_mq is per q L/(2V), 1 where per q L/V
    of the jet:   M_q = m' l_e^2 + I'

C_mq is negative where it damps; the coefficient of the rate of the angle of attack (C_m alpha-dot)
may be added to it. m' is the mass flow, l_e the arm from the centre of gravity aft to the nozzle's
exit, and I' the rate of the moment of inertia, negative while propellant leaves: it takes its own
angular momentum along.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import FloatArray, Real
from tvclin.base.cards import card, card_rows, lines
from tvclin.base.fields import fields_of, parameters, quantity, spec
from tvclin.base.package_warnings import ImplausibleInput
from tvclin.vehicle.structure import Structure

STANDARD_GRAVITY = 9.80665
"""Standard gravity g [m/s^2]: the mass of a vehicle is its weight over g."""


_MIN_SIZE, _MAX_SIZE = 1e-9, 1e18
"""Sizes in SI units between which the numbers of a vehicle lie."""
_OPTIONAL = ("time", "control_force_slope")
"""Numbers that may be missing."""
_UNBOUNDED_BELOW = ("aerodynamic_arm", "attitude", "time")
"""Numbers without a smallest size."""
_MIN_THRUST_OVER_WEIGHT = 0.5
"""Thrust over weight below which a number is probably mistyped."""
_MAX_THRUST_OVER_WEIGHT = 10.0
"""Thrust over weight above which the weight is probably a mass: 1.05 at lift-off would be 10.3.
Boosters have about 1.05 to 5."""
_MIN_RADIUS_OVER_ARM = 0.1
"""Radius of gyration over the control arm below which the inertia is probably in another unit;
slender bodies have 0.5 to 1."""
_MAX_VELOCITY = 11.2e3
"""Velocity [m/s] of escape from the Earth, which no ascent in air exceeds."""


def _checked_attitude(name: str, value: ArrayLike, unit: str) -> FloatArray:
    """Return angles `value` [rad] as an array; `InputError` for sizes above 90 degrees.

    `name`, `unit`: of the angles, for the message.
    """
    array = errors.finite(name, value, unit)
    beyond = array[np.abs(array) > np.pi / 2]
    if beyond.size:
        raise errors.InputError(
            f"{name} must be within 90 degrees; got {errors.in_degrees(beyond[0])}"
        )
    return array


@dataclass(frozen=True, kw_only=True)
class Vehicle:
    """Booster at a time of its flight, or a batch of boosters.

    Every number may be an array; they broadcast with each other. Angles are measured from the
    nominal flight without wind and at zero angle of attack.

    Parameters
    ----------
    weight : array_like
        Gross weight W [N], positive. The mass is W/g with g = 9.80665 m/s^2.
    moment_of_inertia : array_like
        Moment of inertia I [kg m^2] about the centre of gravity, positive.
    normal_force_slope : array_like
        Aerodynamic normal force per angle of attack N [N/rad], zero or positive.
    thrust : array_like
        Total thrust T [N], positive.
    aerodynamic_arm : array_like
        Aerodynamic moment arm l_a [m], from the centre of gravity forward to the centre of
        pressure. Zero or negative is an aerodynamically stable vehicle, which is legal.
    control_arm : array_like
        Control moment arm l_c [m], from the centre of gravity aft to the control force; not
        zero. Negative for effectors ahead of the centre of gravity.
    axial_force : array_like
        Axial aerodynamic force F_A [N], zero or positive.
    velocity : array_like
        Nominal relative velocity V_n [m/s], positive.
    attitude : array_like
        Nominal flight attitude Theta_n [rad] above the horizontal, within 90 degrees.
    name : str
        Name of the vehicle.
    time : float, optional
        Time of flight [s] to which the numbers belong.
    control_force_slope : array_like, optional
        Control force per deflection [N/rad], positive; by default the thrust (a gimballed
        engine). It is needed for aerodynamic surfaces and for reaction control.
    pitch_damping : array_like
        Moment against the attitude rate M_q [N m s/rad], aerodynamic and of the jet, in either
        plane; zero, as in the report, or positive.
    numbers_from : str
        Source of the numbers, for the page.
    structure : Structure, optional
        Bending, slosh, engine inertia, and the lags of the sensors; None for a rigid vehicle.

    Raises
    ------
    InputError
        For a number that violates its rule above, and shapes that do not broadcast.

    Notes
    -----
    Table I and appendix A of the report. With T as control force the symbols are those of
    eqs (B1) and (B2); other effectors put their own slope in place of T where T multiplies the
    deflection.
    """

    weight: Real = quantity("force", check=errors.positive, label="gross weight W")
    moment_of_inertia: Real = quantity(
        "inertia", check=errors.positive, label="moment of inertia I"
    )
    normal_force_slope: Real = quantity(
        "force slope", check=errors.nonnegative, label="normal force slope N"
    )
    thrust: Real = quantity("force", check=errors.positive, label="thrust T")
    aerodynamic_arm: Real = quantity("length", label="aerodynamic arm l_a")
    control_arm: Real = quantity("length", check=errors.nonzero, label="control arm l_c")
    axial_force: Real = quantity("force", check=errors.nonnegative, label="axial force F_A")
    velocity: Real = quantity("speed", check=errors.positive, label="velocity V_n")
    attitude: Real = quantity("angle", check=_checked_attitude, label="attitude Theta_n")
    name: str = ""
    time: Real | None = quantity("time", None, label="time of flight")
    control_force_slope: Real | None = quantity("force slope", None, errors.positive)
    pitch_damping: Real = field(
        default=0.0,
        metadata=spec(
            "damping moment",
            of=lambda vehicle: vehicle.pitch_damping if np.any(vehicle.pitch_damping) else None,
            label="pitch damping M_q",
            check=errors.nonnegative,
        ),
    )
    numbers_from: str = field(default="", compare=False)
    structure: Structure | None = None

    def __post_init__(self) -> None:
        """Check all fields; set each number to a float or, in a batch, to an array.

        One `InputError` lists all faults of single numbers. A structure without parts becomes None.
        """
        errors.text("name", self.name)
        errors.text("numbers_from", self.numbers_from)
        checked, faults = {}, errors.Faults()
        for item in fields_of(self):
            with faults.collect():
                if item.name not in _OPTIONAL or getattr(self, item.name) is not None:
                    value = item.check(item.name, getattr(self, item.name), item.si_unit)
                    checked[item.name] = value
        faults.raise_all()
        errors.together(**checked)  # their shapes must broadcast
        for name, array in checked.items():
            _check_size(name, array)
            object.__setattr__(self, name, errors.plain(array))
        if self.structure is not None:
            errors.instance(
                "structure", self.structure, Structure, "Structure(bending=..., slosh=...)"
            )
            if self.structure.is_rigid:
                object.__setattr__(self, "structure", None)

    def _repr_html_(self) -> str:
        """Return the numbers of the vehicle as a table in HTML."""
        return card(self.name or "Vehicle", card_rows(self))

    def __repr__(self) -> str:
        """Return the numbers of the vehicle, and the parts of its structure, as lines of text."""
        title = f"Vehicle {self.name}".strip()
        flexible = [] if self.structure is None else [("structure", self.structure.parts, "")]
        return lines(title, [*card_rows(self), *flexible])

    @classmethod
    def from_aerodynamics(
        cls,
        *,
        dynamic_pressure: ArrayLike,
        reference_area: ArrayLike,
        normal_force_coefficient_slope: ArrayLike,
        axial_force_coefficient: ArrayLike,
        **others: Any,
    ) -> Self:
        """Return the vehicle with N = q S dC_N/dalpha and F_A = q S C_A, eq (B1d).

        Parameters
        ----------
        dynamic_pressure : array_like
            Dynamic pressure q = rho V_R^2/2 [Pa], positive.
        reference_area : array_like
            Reference area S [m^2], positive.
        normal_force_coefficient_slope : array_like
            dC_N/dalpha [1/rad], zero or positive.
        axial_force_coefficient : array_like
            C_A, zero or positive.
        **others
            The other arguments of `Vehicle`.

        Raises
        ------
        InputError
            As `Vehicle`, and when an argument is given twice.
        """
        for derived in ("normal_force_slope", "axial_force"):
            if derived in others:
                raise errors.InputError(f"{derived} follows from the coefficients; leave it out")
        slope = "normal_force_coefficient_slope"
        numbers = {
            "dynamic_pressure": errors.positive("dynamic_pressure", dynamic_pressure, "Pa"),
            "reference_area": errors.positive("reference_area", reference_area, "m^2"),
            slope: errors.nonnegative(slope, normal_force_coefficient_slope, "1/rad"),
            "axial_force_coefficient": errors.nonnegative(
                "axial_force_coefficient", axial_force_coefficient
            ),
        }
        errors.together(**numbers)
        for name, array in numbers.items():
            _check_size(name, array)
        pressure, area, lift, axial = numbers.values()
        force = pressure * area
        return cls(normal_force_slope=force * lift, axial_force=force * axial, **others)

    def replace(self, **changes: Any) -> Self:
        """Return a copy with the fields `changes` changed; `InputError` for an unknown one."""
        unknown = set(changes) - set(self.__dataclass_fields__)
        if unknown:
            raise errors.InputError(f"Vehicle has no field {', '.join(sorted(unknown))}")
        return replace(self, **changes)

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for one vehicle."""
        shapes = {name: np.shape(getattr(self, name)) for name in NUMBERS}
        return errors.broadcast(**shapes, structure=self.structure.batch if self.structure else ())

    @property
    def rigid(self) -> Self:
        """Vehicle without its structure."""
        return self if self.structure is None else replace(self, structure=None)

    @property
    def mass(self) -> Real:
        """Gross mass m = W/g [kg]."""
        return self.weight / STANDARD_GRAVITY

    @property
    def control_force(self) -> Real:
        """Control force per deflection [N/rad]: `control_force_slope`, by default the thrust."""
        return self.thrust if self.control_force_slope is None else self.control_force_slope


def _check_size(name: str, array: FloatArray) -> None:
    """Raise `InputError` about `name` for sizes whose products over- or underflow.

    `array`: numbers in SI units, of size 1e-9 to 1e18, or zero; of some names with no smallest.
    """
    size = np.abs(array)
    tiny = (size < _MIN_SIZE) & (size > 0.0) & (name not in _UNBOUNDED_BELOW)
    if np.any(tiny | (size > _MAX_SIZE)):
        raise errors.InputError(
            f"{name} must be a size between {_MIN_SIZE:g} and {_MAX_SIZE:g} in SI units; got"
            f" {array.ravel()[np.argmax(tiny | (size > _MAX_SIZE))]:.6g}"
        )


NUMBERS = tuple(parameters(Vehicle))
"""Names of the numerical fields."""


AIR_FORCES = ("normal_force_slope", "axial_force")
"""Names of the numbers of a vehicle that are proportional to the dynamic pressure."""


def at_pressure(vehicle: Vehicle, ratio: ArrayLike) -> Vehicle:
    """Return the vehicle with normal and axial force at `ratio` times its dynamic pressure."""
    return vehicle.replace(
        **{name: np.multiply(getattr(vehicle, name), ratio) for name in AIR_FORCES}
    )


RATES = {"qL/2V": 2.0, "qL/V": 1.0}
"""Reference rates of a damping coefficient, and f: of aircraft and DATCOM, of missiles."""


def aerodynamic_damping(
    coefficient: ArrayLike,
    per: str,
    *,
    dynamic_pressure: ArrayLike,
    reference_area: ArrayLike,
    reference_length: ArrayLike,
    velocity: ArrayLike,
) -> Any:
    """Return the aerodynamic damping M_q [N m s/rad], for the `pitch_damping` of `Vehicle`.

    Parameters
    ----------
    coefficient : array_like
        C_mq, zero or negative, about the centre of gravity.
    per : {"qL/2V", "qL/V"}
        Reference rate, q being the attitude rate [rad/s]: tables of aircraft and DATCOM have the
        first, those of missiles mostly the second. They differ by a factor of two.
    dynamic_pressure : array_like
        Dynamic pressure [Pa], positive.
    reference_area, reference_length : array_like
        S [m^2] and L [m] of the coefficient, positive.
    velocity : array_like
        Speed relative to the air [m/s], positive.

    Returns
    -------
    float or ndarray
        M_q [N m s/rad]; the arguments broadcast.

    Raises
    ------
    InputError
        For a positive coefficient (negative damping), another rate, and numbers out of range.

    Examples
    --------
    >>> import tvclin as tv
    >>> air = {"dynamic_pressure": 4e4, "reference_area": 0.02, "velocity": 250.0}
    >>> tv.vehicle.aerodynamic_damping(-50.0, "qL/V", reference_length=0.16, **air)
    4.096
    """
    C = errors.finite("coefficient", coefficient)
    if np.any(C > 0.0):
        raise errors.InputError(
            "the pitch damping coefficient must be zero or negative: C_mq below zero damps; got"
            f" {C.max():.6g}"
        )
    speeds = RATES[errors.one_of("per", per, RATES)]  # 2 of q L/(2 V), 1 of q L/V
    numbers = {
        "dynamic_pressure": errors.positive("dynamic_pressure", dynamic_pressure, "Pa"),
        "reference_area": errors.positive("reference_area", reference_area, "m^2"),
        "reference_length": errors.positive("reference_length", reference_length, "m"),
        "velocity": errors.positive("velocity", velocity, "m/s"),
    }
    errors.together(coefficient=C, **numbers)
    pressure, area, length, speed = numbers.values()
    with np.errstate(over="ignore", invalid="ignore"):  # refused below
        damping = np.abs(C) * pressure * area * length**2 / (speeds * speed)
    return errors.plain(errors.finite("the damping of these numbers", damping, "N m s/rad"))


def jet_damping(mass_flow: ArrayLike, exit_arm: ArrayLike, inertia_rate: ArrayLike) -> Any:
    """Return the damping M_q of the jet [N m s/rad], for the `pitch_damping` of `Vehicle`.

    Parameters
    ----------
    mass_flow : array_like
        m' [kg/s], zero or positive.
    exit_arm : array_like
        l_e [m], from the centre of gravity aft to the nozzle's exit, positive.
    inertia_rate : array_like
        I' [kg m^2/s], zero or negative while propellant leaves. Zero gives an upper bound.

    Returns
    -------
    float or ndarray
        M_q [N m s/rad]; the arguments broadcast.

    Raises
    ------
    InputError
        For numbers out of range, and an inertia rate that makes the damping negative.

    Examples
    --------
    >>> import tvclin as tv
    >>> tv.vehicle.jet_damping(2.0, 1.5, inertia_rate=-0.5)
    4.0
    """
    flow = errors.nonnegative("mass_flow", mass_flow, "kg/s")
    arm = errors.positive("exit_arm", exit_arm, "m")
    rate = errors.finite("inertia_rate", inertia_rate, "kg m^2/s")
    errors.together(mass_flow=flow, exit_arm=arm, inertia_rate=rate)
    with np.errstate(over="ignore", invalid="ignore"):  # refused below
        damping = errors.finite("the damping of these numbers", flow * arm**2 + rate, "N m s/rad")
    if np.any(damping < 0.0):
        raise errors.InputError(
            "mass_flow times exit_arm squared must be at least what the moment of inertia loses,"
            f" -inertia_rate: the damping would be negative, {damping.min():.6g} N m s/rad (check"
            " the units, and that exit_arm reaches to the nozzle's exit)"
        )
    return errors.plain(damping)


_MAX_SLOPE_TIMES_LENGTH = 100.0
"""Largest plausible slope of a bending mode, times the length and over the displacement."""


def vehicle_warnings(vehicle: Vehicle) -> Iterator[ImplausibleInput]:
    """Yield warnings on implausible numbers of a vehicle or a batch, without full stops.

    They concern a thrust far below or above the weight, or below the axial force, a velocity above
    the escape velocity, an inertia and slopes of modes in another unit, and a centre of pressure
    behind the centre of gravity.
    """
    yield from map(ImplausibleInput, _vehicle_warnings(vehicle))


def _vehicle_warnings(vehicle: Vehicle) -> Iterator[str]:
    """Yield the sentences of `vehicle_warnings`."""
    ratio = np.asarray(vehicle.thrust) / vehicle.weight
    arm = np.asarray(vehicle.aerodynamic_arm)
    if np.any(ratio < _MIN_THRUST_OVER_WEIGHT):
        yield f"thrust is far below weight (T/W {ratio.min():.2g}): a power of ten may be missing"
    if np.any(ratio > _MAX_THRUST_OVER_WEIGHT):
        yield (
            f"thrust is far above weight (T/W {ratio.max():.2g}): if the weight is a mass, write it"
            " as mass_kg, mass_lb or mass_slug"
        )
    if np.any(np.asarray(vehicle.axial_force) > vehicle.thrust):
        yield (
            f"the axial force F_A is {np.max(vehicle.axial_force):.4g} N, larger than the thrust:"
            " the vehicle slows down; the unit or the coefficient of F_A may be wrong"
        )
    if np.any(np.asarray(vehicle.velocity) > _MAX_VELOCITY):
        yield (
            f"the velocity V_n is {np.max(vehicle.velocity):.4g} m/s, above the escape velocity:"
            " its unit may be wrong"
        )
    # the radius of gyration, sqrt(I/m), of any booster is shorter than its two arms together
    length = np.asarray(vehicle.control_arm) + np.maximum(arm, 0.0)
    radius = np.sqrt(vehicle.moment_of_inertia * STANDARD_GRAVITY / np.asarray(vehicle.weight))
    if np.any(radius > length):
        yield (
            f"the radius of gyration is {radius.max():.4g} m, longer than control and aerodynamic"
            f" arm together, {length.max():.4g} m: the unit of the moment of inertia may be wrong"
        )
    if np.any(radius < _MIN_RADIUS_OVER_ARM * np.asarray(vehicle.control_arm)):
        yield (
            f"the radius of gyration is {radius.min():.4g} m, and that of a slender body at least"
            f" {100 * _MIN_RADIUS_OVER_ARM:g} % of the control arm: the unit of the moment of"
            " inertia may be wrong"
        )
    if vehicle.structure is not None:
        yield from _slope_warnings(vehicle.structure, float(length.max()))
    if np.any(arm < 0.0):
        yield (
            f"the aerodynamic arm l_a is negative ({arm.min():.4g} m): the centre of pressure"
            " lies behind the centre of gravity, and the air turns the vehicle back by itself; the"
            " arm is positive where it lies ahead"
        )


def _slope_warnings(structure: Structure, length: float) -> Iterator[str]:
    """Yield a warning on each bending mode of a `structure` with implausible slopes.

    `length`: sum of control and aerodynamic arm [m]. The slope of the n-th mode of a free beam at
    its end is about (n + 1/2) pi over the length, per displacement there.
    """
    for k, mode in enumerate(structure.bending, 1):
        displacements = (mode.gimbal_displacement, mode.pressure_displacement)
        displacement = max(float(np.abs(x).max()) for x in displacements)
        slopes_of_mode = (mode.gimbal_slope, mode.attitude_slope, mode.rate_slope)
        slopes = max(float(np.abs(x).max()) for x in slopes_of_mode)
        if slopes * length > _MAX_SLOPE_TIMES_LENGTH * displacement:
            yield (
                f"a slope of bending mode {k} is {slopes:.4g} 1/m, with displacements of at most"
                f" {displacement:.3g}: its unit or its normalisation may be wrong"
            )
