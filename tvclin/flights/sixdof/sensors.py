"""What is read of a flight in its plane, and how the wind is told to the engine."""

from collections.abc import Callable
from math import asin, cos, sin
from typing import NamedTuple

from tvclin.base.units import FOOT
from tvclin.flights.sixdof.engine import Engine

_Two = Callable[[], tuple[float, float]]
_NONE = 1e-12
"""Part of the wind that is too small to be told."""


class Senses(NamedTuple):
    """Readers of one plane, each without arguments.

    `angles`: attitude and flight path angle [rad]. `rates`: attitude rate [rad/s] and acceleration
    [rad/s^2]. `alpha`: angle of attack [rad].
    """

    angles: _Two
    rates: _Two
    alpha: Callable[[], float]


def senses(engine: Engine, plane: str, heading: float) -> Senses:
    """Return the readers of a plane; in yaw angles lie between the vertical plane and the right."""
    read = engine.reader
    axis = "q" if plane == "pitch" else "r"
    rate, push = read(f"velocities/{axis}-rad_sec"), read(f"accelerations/{axis}dot-rad_sec2")
    theta = read("attitude/theta-rad")
    if plane == "pitch":
        gamma = read("flight-path/gamma-rad")
        return Senses(lambda: (theta(), gamma()), lambda: (rate(), push()), read("aero/alpha-rad"))
    psi, speed, sideslip = (
        read(name) for name in ("attitude/psi-rad", "velocities/vt-fps", "aero/beta-rad")
    )
    north, east = read("velocities/v-north-fps"), read("velocities/v-east-fps")
    ahead, right = cos(heading), sin(heading)

    def angles() -> tuple[float, float]:
        side = east() * ahead - north() * right
        return asin(cos(theta()) * sin(psi() - heading)), asin(side / speed())

    return Senses(angles, lambda: (rate(), push()), lambda: -sideslip())


def wind_setter(engine: Engine, plane: str, heading: float) -> Callable[[float], None]:
    """Return what sets a wind [m/s] along the flight (pitch) or to its right (yaw)."""
    north, east = cos(heading), sin(heading)
    if plane == "yaw":
        north, east = -east, north
    parts = [
        (engine.writer(f"atmosphere/wind-{name}-fps"), part / FOOT)
        for name, part in (("north", north), ("east", east))
        if abs(part) > _NONE
    ]
    if len(parts) == 1:
        ((write, part),) = parts
        return lambda speed: write(speed * part)

    def blow(speed: float) -> None:
        for write, part in parts:
            write(speed * part)

    return blow
