"""A made-up stand-in for a flight of RocketPy, with the attributes that a schedule is made of."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np

BURN = 5.0
RADIUS = 0.0725


@dataclass(frozen=True)
class Surface:
    """A surface that pulls with `slope` at a distance `cpz` aft of its own position."""

    name: str
    slope: float
    cpz: float
    rocket_radius: float = RADIUS

    def clalpha(self, mach: float) -> float:
        return self.slope * (1.0 + 0.1 * mach)


class GenericSurface(Surface):
    """By the name of RocketPy's."""


@dataclass(frozen=True)
class Rocket:
    """Of 23 kg around `DRY`, and 6 kg of propellant around 0.8 m behind that, burnt evenly."""

    forward: float = 1.0
    surfaces: tuple[tuple[Surface, float], ...] = (
        (Surface("Nose Cone", 2.0, 0.28), 1.7),
        (Surface("Fins", 6.0, 0.05, 2 * RADIUS), -1.0),
    )
    radius: float = RADIUS
    area: float = np.pi * RADIUS**2
    motor: Any = field(
        default_factory=lambda: SimpleNamespace(
            burn_out_time=BURN, thrust=lambda t: 2400.0 if t < BURN else 0.0
        )
    )

    @property
    def _csys(self) -> float:
        return self.forward

    @property
    def aerodynamic_surfaces(self) -> list[tuple[Surface, Any]]:
        return [(one, SimpleNamespace(z=self.forward * at)) for one, at in self.surfaces]

    def propellant(self, t: float) -> float:
        return 6.0 * (1.0 - t / BURN)

    def total_mass(self, t: float) -> float:
        return 23.0 + self.propellant(t)

    def center_of_mass(self, t: float) -> float:
        return self.forward * -0.8 * self.propellant(t) / self.total_mass(t)

    def com_to_cdm_function(self, t: float) -> float:
        return 0.8 * self.propellant(t) / self.total_mass(t)

    def I_11(self, t: float) -> float:
        """About the centre of dry mass: 18, and the propellant's 0.5 m long at 0.8 m from it."""
        return 18.0 + self.propellant(t) * (0.5**2 / 12.0 + 0.8**2)

    def total_lift_coeff_der(self, mach: float) -> float:
        return sum((s.rocket_radius / RADIUS) ** 2 * s.clalpha(mach) for s, _ in self._counted)

    def cp_position(self, mach: float) -> float:
        moment = sum(
            (s.rocket_radius / RADIUS) ** 2 * s.clalpha(mach) * (at - s.cpz)
            for s, at in self._counted
        )
        return self.forward * moment / self.total_lift_coeff_der(mach)

    @property
    def _counted(self) -> list[tuple[Surface, float]]:
        return [surface for surface in self.surfaces if not isinstance(surface[0], GenericSurface)]


@dataclass(frozen=True)
class Flight:
    """Straight up at 84 deg, made up."""

    rocket: Rocket = Rocket()
    out_of_rail_time: float = 0.4
    degrees_of_attack: float = 0.1

    def speed(self, t: float) -> float:
        return 65.0 * t

    def z(self, t: float) -> float:
        return 1400.0 + 32.5 * t**2 * np.sin(np.radians(84.0))

    def mach_number(self, t: float) -> float:
        return self.speed(t) / 340.0

    def dynamic_pressure(self, t: float) -> float:
        return 0.5 * self.speed(t) ** 2

    def aerodynamic_drag(self, t: float) -> float:
        return 0.5 * self.rocket.area * self.dynamic_pressure(t)

    def attitude_angle(self, t: float) -> float:
        del t
        return 84.0

    def angle_of_attack(self, t: float) -> float:
        del t
        return self.degrees_of_attack
