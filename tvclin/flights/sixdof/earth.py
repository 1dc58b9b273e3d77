"""Where a flight is: over a flat planet at rest, unless it is over the Earth."""

from dataclasses import dataclass
from math import pi, radians

from tvclin.base.errors import directions, finite, number, within


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

    latitude: float = radians(28.5)
    heading: float = pi / 2
    altitude: float = 12e3

    def __post_init__(self) -> None:
        within("latitude", self.latitude, -pi / 2, pi / 2, "rad")
        for name, check, unit in (
            ("latitude", finite, "rad"),
            ("heading", directions, "rad"),
            ("altitude", finite, "m"),
        ):
            object.__setattr__(self, name, number(name, getattr(self, name), check, unit))
