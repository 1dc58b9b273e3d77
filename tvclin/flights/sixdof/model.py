"""The vehicle as a JSBSim aircraft: XML of mass, forces and moments, and the Earth below it."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, radians, sin
from typing import Any
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np

from tvclin.ascent.nominal_flight import FlightCondition, nominal_flight, time_of
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import between, directions
from tvclin.base.fields import checked, quantity
from tvclin.base.units import FOOT, POUND_FORCE, SLUG
from tvclin.vehicle.vehicle import STANDARD_GRAVITY, Vehicle


@dataclass(frozen=True)
class InitialState:
    """Initial state of a flight in the standard atmosphere over a flat planet without rotation.

    `altitude`: altitude [m]. `path_rate`: rate of the flight path [rad/s]. `dynamic_pressure`:
    dynamic pressure of the vehicle's aerodynamic forces [Pa]. `mass_flow`: mass flow [kg/s].
    """

    altitude: float
    path_rate: float
    dynamic_pressure: float
    mass_flow: float


@dataclass(frozen=True, eq=False)
class NominalTrajectory:
    """Nominal flight as a reference for JSBSim.

    `vehicle`: the vehicle at the start. `departure`: initial state. `speeds`: speed [m/s] at each
    step, ``(n,)``. `rows`: attitude, attitude rate, flight path angle, angle of attack and
    deflection at each step [rad, rad/s], ``(n, 5)``, in pitch. The nose is on the path.
    """

    vehicle: Vehicle
    departure: InitialState
    speeds: FloatArray
    rows: FloatArray


def nominal_trajectory(
    vehicle: Vehicle, condition: FlightCondition, times: FloatArray
) -> NominalTrajectory:
    """Return the nominal flight through a vehicle's state at its time, at equidistant times [s].

    `condition`: altitude and dynamic pressure of that state. `InputError` as `nominal_flight`. The
    states of the nominal flight are speed [m/s], path angle [rad] and altitude [m].
    """
    start, reference = float(times[0]), time_of(vehicle)
    first, last = min(start, reference), max(float(times[-1]), reference)
    nominal = nominal_flight(vehicle, condition, start=first, stop=last)
    speeds, paths, altitudes = states = nominal.states(times)
    _, path_rate, _ = nominal.rates(times, states)  # of speed, path angle and altitude
    zeros = np.zeros(times.size)
    departure = InitialState(
        altitude=float(altitudes[0]),
        path_rate=float(path_rate[0]),
        dynamic_pressure=float(nominal.dynamic_pressure(start)),
        mass_flow=float(nominal.mass(start) - nominal.mass(start + 1.0)),  # in 1 s
    )
    # `OUTPUTS`: attitude and its rate are the path's, without an angle of attack
    rows = np.stack([paths, path_rate, paths, zeros, nominal.deflection(times)], axis=-1)
    return NominalTrajectory(nominal.vehicle_at(start), departure, speeds=speeds, rows=rows)


@dataclass(frozen=True)
class Earth:
    """The rotating Earth, WGS84 with its gravity, in place of a flat planet at rest.

    Parameters
    ----------
    latitude : float
        Geodetic latitude [rad] at which the flight begins.
    heading : float
        Direction of flight [rad], from north over east.
    altitude : float
        Altitude [m] at which it begins.

    Raises
    ------
    InputError
        For a latitude beyond the poles, and numbers that are not finite.
    """

    latitude: float = quantity("angle", radians(28.5), between(-pi / 2, pi / 2))
    heading: float = quantity("angle", pi / 2, directions)
    altitude: float = quantity("length", 12e3)

    def __post_init__(self) -> None:
        """Raise `InputError` for a latitude beyond the poles, and numbers that are not finite."""
        checked(self)


DEFLECTIONS = {
    "pitch": "tvclin/pitch-deflection-rad",
    "yaw": "tvclin/yaw-deflection-rad",
}
"""JSBSim properties of the deflections. Positive ones push the tail up, and to the right."""

_POUNDS_PER_SLUG = 32.174049
"""JSBSim's ratio of pounds to slugs."""
_INERTIA_OVER_ROLL_INERTIA = 20.0
"""Transverse moment of inertia over that of roll, which does not matter: nothing rolls."""
_FLAT_RADIUS = 1e13
"""Radius of a planet [m] that is practically flat and leaves digits for positions."""
_ALONG = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}

Direction = tuple[float, float, float]
"""Components x, y and z of a unit vector."""
Tree = str | float | tuple[Any, ...]
"""A formula: a property, a number, or the name of an operation with its parts."""


def planet_xml() -> str:
    """Return the XML of a flat planet without rotation, with standard gravity at its surface."""
    planet = Element("planet", name="flat")
    for axis in ("semimajor_axis", "semiminor_axis"):
        _text(planet, axis, _FLAT_RADIUS, unit="M")
    _text(planet, "rotation_rate", 0.0, unit="RAD/SEC")
    _text(planet, "GM", STANDARD_GRAVITY * _FLAT_RADIUS**2, unit="M3/SEC2")
    _text(planet, "J2", 0.0)
    return tostring(planet, encoding="unicode")


def model_xml(vehicle: Vehicle, heading: float = 0.0, departure: InitialState | None = None) -> str:
    """Return the XML of one vehicle, frozen or varying from an initial state on.

    Thrust, a fraction of which is turned by the deflection, acts the control arm aft of the centre
    of gravity; the normal force N alpha (alpha: angle of attack in body axes) and the axial force
    act the aerodynamic arm ahead of it. A
    damping moment opposes the rates of pitch and yaw. Two further forces freeze the flight: the
    first balances the weight across the nominal path, the second cancels all changes of speed. With
    a departure only inertia and damping are constant: aerodynamic forces are proportional to the
    dynamic pressure, and the mass falls.

    `vehicle`: one vehicle. `heading`: nominal direction of flight [rad], from north over east.
    `departure`: initial state with the vehicle's parameters; without it they are constant.
    """
    root = Element("fdm_config", name="tvclin", version="2.0")
    metrics = SubElement(root, "metrics")
    for name in ("wingarea", "wingspan", "chord"):  # unused, since no force has a coefficient
        _text(metrics, name, 1.0)
    _place(metrics, -float(vehicle.aerodynamic_arm), name="AERORP")  # centre of pressure
    across = float(vehicle.moment_of_inertia)
    inertias = across / _INERTIA_OVER_ROLL_INERTIA, across, across
    balance = mass_balance(root, float(vehicle.mass), inertias)
    SubElement(root, "ground_reactions")
    load: Tree = 1.0  # formula of the dynamic pressure over the vehicle's
    if departure is not None:
        _burning(root, balance, departure)
        load = ("quotient", "aero/qbar-psf", departure.dynamic_pressure * FOOT**2 / POUND_FORCE)
    _aerodynamics(root, vehicle, load)
    reactions = SubElement(root, "external_reactions")
    for path in DEFLECTIONS.values():
        _text(reactions, "property", path)
    _nozzle(reactions, vehicle)
    if departure is None:
        _frozen(reactions, vehicle, heading)
    return tostring(root, encoding="unicode")


def mass_balance(root: Element, mass: float, inertias: tuple[float, float, float]) -> Element:
    """Return the new element of a mass [kg] and its moments of inertia [kg m^2] about x, y, z.

    `root`: element to which it is added.
    """
    balance = SubElement(root, "mass_balance")
    for name, inertia in zip(("ixx", "iyy", "izz"), inertias, strict=True):
        _text(balance, name, inertia / (SLUG * FOOT**2), unit="SLUG*FT2")
    _text(balance, "emptywt", mass / SLUG * _POUNDS_PER_SLUG, unit="LBS")
    _place(balance, 0.0, name="CG")
    return balance


def _burning(root: Element, balance: Element, departure: InitialState) -> None:
    """Add the burnt propellant, as a negative point mass at the centre of gravity.

    JSBSim takes its weight [lb], proportional to the time since the start [s]. `root`: element of
    the aircraft. `balance`: its mass balance. `departure`: gives the mass flow.
    """
    burnt = SubElement(balance, "pointmass", name="burnt")
    _text(burnt, "weight", 0.0, unit="LBS")
    _place(burnt, 0.0)
    channel = SubElement(SubElement(root, "system", name="burning"), "channel", name="burning")
    flow = -departure.mass_flow / SLUG * _POUNDS_PER_SLUG  # from kg/s to lb/s; a mass below zero
    function = SubElement(channel, "fcs_function", name="tvclin/burnt-lbs")
    _function(function, ("product", flow, "simulation/sim-time-sec"))
    _text(function, "output", "inertia/pointmass-weight-lbs")


def _aerodynamics(root: Element, vehicle: Vehicle, load: Tree) -> None:
    """Add the aerodynamic forces and the damping moment of a vehicle to the aircraft `root`.

    In body axes x is forward, y to the right and z down; the normal force is proportional to the
    angles of sideslip and of attack, atan(v/u) and atan(w/u) of the air speed. `load`: formula of
    the dynamic pressure over the nominal one of the vehicle's forces.
    """
    aerodynamics = SubElement(root, "aerodynamics")
    slope = -float(vehicle.normal_force_slope) / POUND_FORCE
    forces: dict[str, Tree] = {
        "X": ("product", -float(vehicle.axial_force) / POUND_FORCE, load),
        "Y": ("product", slope, load, ("atan2", "velocities/v-aero-fps", "velocities/u-aero-fps")),
        "Z": ("product", slope, load, ("atan2", "velocities/w-aero-fps", "velocities/u-aero-fps")),
    }
    for name, force in forces.items():
        axis = SubElement(aerodynamics, "axis", name=name)
        _function(axis, force, name=f"tvclin/aerodynamic-{name.lower()}-lbs")
    damping = -float(vehicle.pitch_damping) / (POUND_FORCE * FOOT)
    rates = {"PITCH": "velocities/q-rad_sec", "YAW": "velocities/r-rad_sec"}
    for name, rate in rates.items() if damping else ():
        axis = SubElement(aerodynamics, "axis", name=name)
        _function(axis, ("product", damping, rate), name=f"tvclin/damping-{name.lower()}-lbsft")
    SubElement(aerodynamics, "axis", name="ROLL")  # or JSBSim remarks that there is no moment


def _nozzle(reactions: Element, vehicle: Vehicle) -> None:
    """Add the thrust: the control force turns with the deflection, the rest acts along the body.

    Formulas of nozzle force and of nozzle with aerodynamic force, "without weight", are named, so
    that they can be read. `reactions`: element of the external forces.
    """
    thrust, rotated = (float(f) / POUND_FORCE for f in (vehicle.thrust, vehicle.control_force))
    pitch, yaw = DEFLECTIONS["pitch"], DEFLECTIONS["yaw"]
    forces: dict[str, Tree] = {
        "x": ("sum", thrust - rotated, ("product", rotated, ("cos", pitch), ("cos", yaw))),
        "y": ("product", rotated, ("sin", yaw)),
        "z": ("product", -rotated, ("sin", pitch)),
    }
    for axis, force in forces.items():
        name = f"tvclin/nozzle-{axis}-lbs"
        both: Tree = ("sum", f"tvclin/aerodynamic-{axis}-lbs", name)
        _function(reactions, force, name=name)
        _function(reactions, both, name=f"tvclin/without-weight-{axis}-lbs")
        arm = float(vehicle.control_arm)
        _force(reactions, f"nozzle-{axis}", "BODY", name, _ALONG[axis], aft=arm)


def _frozen(reactions: Element, vehicle: Vehicle, heading: float) -> None:
    """Add the forces that keep the nominal flight straight, and the speed of every flight.

    The first carries the weight across the nominal path. The second acts along the velocity and has
    minus the power of all other forces, ``-(F v) v / v^2``. Both act at the centre of gravity
    (`aft` of it by zero), so that they make no moment. `reactions`: element of the external forces.
    `heading`: nominal direction of flight [rad], from north over east.
    """
    weight = float(vehicle.weight) / POUND_FORCE
    sine, cosine = sin(vehicle.attitude), cos(vehicle.attitude)
    north, east = cos(heading), sin(heading)
    upright = (-sine * north, -sine * east, -cosine)
    _force(reactions, "straight", "LOCAL", weight * cosine, upright, aft=0.0)
    # With that force the weight acts as W sin(Theta_n) against the nominal direction of flight.
    forward: Tree = (
        "sum",
        ("product", cosine * north, "velocities/v-north-fps"),
        ("product", cosine * east, "velocities/v-east-fps"),
        ("product", -sine, "velocities/v-down-fps"),
    )
    speeds = {"x": "velocities/u-fps", "y": "velocities/v-fps", "z": "velocities/w-fps"}
    work = [("product", f"tvclin/without-weight-{axis}-lbs", v) for axis, v in speeds.items()]
    # power of the forces [lb ft/s] over the square of the speed: push per speed [lb/(ft/s)]
    power: Tree = ("sum", *work, ("product", -weight * sine, forward))
    square: Tree = ("sum", *(("product", v, v) for v in speeds.values()))
    _function(reactions, ("quotient", power, square), name="tvclin/push-per-speed")
    for axis, speed in speeds.items():
        force: Tree = ("product", -1.0, "tvclin/push-per-speed", speed)
        _force(reactions, f"speed-{axis}", "BODY", force, _ALONG[axis], aft=0.0)


def _force(
    parent: Element, name: str, frame: str, size: Tree, direction: Direction, aft: float
) -> None:
    """Add an external force to an element `parent`.

    `name`: its name. `frame`, `direction`: axes, "BODY" or "LOCAL" (north, east, down), and the
    components in them of the force's unit vector. `size`: formula of its magnitude [lb]. `aft`:
    distance of its point of action aft of the centre of gravity [m].
    """
    force = SubElement(parent, "force", name=name, frame=frame)
    _function(force, size)
    _place(force, aft)
    towards = SubElement(force, "direction")
    for axis, component in zip("xyz", direction, strict=True):
        _text(towards, axis, component)


def _place(parent: Element, aft: float, **names: str) -> None:
    """Add a position on the body axis to an element, `aft` of the centre of gravity [m]."""
    location = SubElement(parent, "location", {"unit": "M", **names})
    for axis, value in zip("xyz", (aft, 0.0, 0.0), strict=True):
        _text(location, axis, value)


def _function(parent: Element, tree: Tree, **names: str) -> None:
    """Add a function with a formula `tree` to an element `parent`; `names` are its attributes."""
    _add(SubElement(parent, "function", names), tree)


def _add(parent: Element, tree: Tree) -> None:
    """Add the elements of a formula `tree` to an element `parent`, operation by operation.

    A tuple is an operation and its parts, a text the name of a property, and else it is a number.
    """
    if isinstance(tree, tuple):
        inner = SubElement(parent, str(tree[0]))
        for part in tree[1:]:
            _add(inner, part)
    else:
        _text(parent, "property" if isinstance(tree, str) else "value", tree)


def _text(parent: Element, tag: str, value: str | float, **attributes: str) -> None:
    """Add an element `tag` with a text or a number to an element `parent`."""
    SubElement(parent, tag, attributes).text = value if isinstance(value, str) else repr(value)
