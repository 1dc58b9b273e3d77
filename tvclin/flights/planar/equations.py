"""The report's planar equations of motion (B1a) to (B1f), as deviations from a nominal flight.

    m V'         = T cos(Theta - gamma + delta) - F_A cos(Theta - gamma)
                   - N alpha sin(Theta - gamma) - W sin gamma
    m V gamma'   = T sin(Theta - gamma + delta) - F_A sin(Theta - gamma)
                   + N alpha cos(Theta - gamma) - W cos gamma
    I Theta''    = N l_a alpha - T l_c sin delta - M_q Theta'

In the yaw plane gravity has no part across the path but that of a path turned away from it,
W sin(Theta_n) sin(sigma), and Theta, gamma are the yaw angle and the heading of the path. A
deviation is what the equations give beyond the nominal flight, so rest is a solution. The report
has no damping M_q; where parameters vary it stays, as the inertia does.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from tvclin.ascent.nominal_flight import NominalFlight
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import one_of, single
from tvclin.vehicle.vehicle import STANDARD_GRAVITY, Vehicle

PLANES = ("pitch", "yaw")
STATES = ("attitude", "attitude_rate", "flight_path_angle", "relative_speed", "altitude")


@dataclass(frozen=True, eq=False)
class PlanarMotion:
    """The motion of one vehicle in one plane.

    `vehicle`: the vehicle. `plane`: "pitch" or "yaw". `drift`: whether the path turns and the speed
    changes; without it the attitude moves alone. `nominal`: the nominal flight along which all
    parameters vary; without one they are frozen, and the wind is an angle that does not depend on
    the motion.
    """

    vehicle: Vehicle
    plane: str = "pitch"
    drift: bool = True
    nominal: NominalFlight | None = None

    def __post_init__(self) -> None:
        one_of("plane", self.plane, PLANES)
        single("vehicle", self.vehicle.replace(time=None).batch)

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states; the altitude counts where parameters vary."""
        return STATES[: 4 if self.nominal is None else 5]

    @property
    def scales(self) -> FloatArray:
        """Size of each state where an angle has the size 1: an altitude changes by the speed."""
        scales = np.ones(len(self.states))
        scales[4:] = self.vehicle.velocity
        return scales

    def rates(self, t: float, x: FloatArray, deflection: float, gust: float) -> FloatArray:
        """Return the derivatives of the states `x`.

        `t`: time [s]. `x`: deviations from the nominal flight [rad, rad/s, rad, 1, m].
        `deflection`: deflection beyond the nominal one [rad]. `gust`: wind angle of attack [rad],
        seen from the nominal flight.
        """
        now = self._now(t)
        alpha, speed = self._air(now, x, gust)
        ratio = self._ratio(speed, now.altitude + x[-1])
        v = self.vehicle
        found = np.zeros(len(self.states))
        found[0] = x[1]
        found[1] = v.normal_force_slope * ratio * v.aerodynamic_arm * alpha
        found[1] -= v.control_force * v.control_arm * np.sin(deflection)
        found[1] -= v.pitch_damping * x[1]
        found[1] /= v.moment_of_inertia
        if self.drift:
            actual = self._path(now, x[0], x[2], now.speed * (1.0 + x[3]), alpha, ratio, deflection)
            calm = self._ratio(now.speed, now.altitude)
            rest = self._path(now, 0.0, 0.0, now.speed, 0.0, calm, 0.0)
            found[2] = actual[0] - rest[0]
            # V = V_n (1 + x): V' - V_n' = V_n x' + V_n' x
            found[3] = (actual[1] - rest[1] - rest[1] * self._moving * x[3]) / now.speed
        if self.nominal is not None and self.plane == "pitch":
            climb = now.speed * (1.0 + x[3]) * np.sin(now.path + x[2])
            found[4] = climb - now.speed * np.sin(now.path) if self.drift else 0.0
        return found

    def angle_of_attack(self, t: Any, x: FloatArray, gust: Any) -> Any:
        """Return the angle of attack [rad] at times and states of one shape, ``(states, ...)``."""
        return self._air(self._now(t), x, gust)[0]

    def _air(self, now: _Now, x: Any, gust: Any) -> tuple[Any, Any]:
        """The angle of attack [rad], and the air speed [m/s]."""
        if self.nominal is None:
            return x[0] - x[2] - gust, now.speed
        speed = now.speed * (1.0 + x[3])
        if self.plane == "pitch":
            path = now.path + x[2]
            wind = now.speed * np.sin(gust) / np.sin(now.path + gust)
            along, across = speed * np.cos(path) - wind, speed * np.sin(path)
            turned = np.arctan2(across, along) - now.path
        else:
            wind = now.speed * np.tan(gust)
            along, across = speed * np.cos(x[2]), speed * np.sin(x[2]) + wind
            turned = np.arctan2(across, along)
        return x[0] - turned, np.hypot(along, across)

    @property
    def _moving(self) -> float:
        """Whether the nominal speed changes; frozen, its change is left out."""
        return 0.0 if self.nominal is None else 1.0

    def _path(
        self, now: _Now, theta: Any, gamma: Any, speed: Any, alpha: Any, ratio: Any, delta: Any
    ) -> tuple[Any, Any]:
        """The rates of the path and of the speed, nominal ones included."""
        v, lean = self.vehicle, theta - gamma
        weight = now.mass * STANDARD_GRAVITY
        normal, axial = v.normal_force_slope * ratio * alpha, v.axial_force * ratio
        side = v.control_force * np.sin(delta)
        push = v.thrust - v.control_force * (1.0 - np.cos(delta))
        across = (push - axial) * np.sin(lean) + (side + normal) * np.cos(lean)
        along = (push - axial) * np.cos(lean) - (side + normal) * np.sin(lean)
        if self.plane == "pitch":
            across = across - weight * np.cos(now.path + gamma)
            along = along - weight * np.sin(now.path + gamma)
        else:
            across = across + weight * np.sin(now.path) * np.sin(gamma)
            along = along - weight * np.sin(now.path) * np.cos(gamma)
        return across / (now.mass * speed), along / now.mass

    def _ratio(self, speed: Any, altitude: Any) -> Any:
        """The dynamic pressure over that of the vehicle."""
        return 1.0 if self.nominal is None else self.nominal.pressure_ratio(speed, altitude)

    def _now(self, t: Any) -> _Now:
        v = self.vehicle
        if self.nominal is None:
            return _Now(v.mass, v.velocity, v.attitude, 0.0)
        return _nominal_at(self.nominal, t) if np.ndim(t) else _latest(self.nominal, float(t))


@dataclass(frozen=True, eq=False)
class _Now:
    """The nominal flight at a time."""

    mass: Any
    speed: Any
    path: Any
    altitude: Any


def _nominal_at(nominal: NominalFlight, t: Any) -> _Now:
    return _Now(nominal.mass(t), *nominal.states_within(t))


_latest = lru_cache(maxsize=1)(_nominal_at)
"""The same at one time [s]: a law and the equations of motion ask for it in turn."""
