"""A made-up launcher of 25 t, from the pad to burnout: vertical at first, then a gravity turn."""

from pathlib import Path

import numpy as np

import tvclin as tv
from tvclin.ascent.atmosphere import standard_atmosphere
from tvclin.base.arrays import FloatArray

KEYS = (
    "time_s,weight_N,moment_of_inertia_kg_m2,normal_force_slope_N_per_rad,thrust_N,"
    "aerodynamic_arm_m,control_arm_m,axial_force_N,velocity_m_per_s,attitude_deg,altitude_m"
)
STEP, ROW, BURNOUT = 0.01, 50, 122.0


def rows() -> FloatArray:
    """A row of `KEYS` every half second; in the first the vehicle stands still."""
    mass, speed, path, height, computed = 25e3, 0.0, np.pi / 2, 0.0, []
    for k in range(round(BURNOUT / STEP) + 1):
        t = k * STEP
        air = standard_atmosphere(min(height, 80e3))
        pressure = 0.5 * air.density * speed**2
        thrust, drag = 380e3 - 45e3 * air.pressure / 101325.0, 0.4 * 1.13 * pressure
        if k % ROW == 0:
            part, mach = t / BURNOUT, speed / 300.0
            arm = 4.2 - 1.2 * part + 0.8 * np.exp(-(((mach - 1.2) / 0.4) ** 2))
            computed.append(
                [
                    t,
                    9.80665 * mass,
                    mass * 20.0**2 / 12.0,
                    1.13 * 5.5 * pressure,
                    thrust,
                    arm,
                    8.6 + 1.2 * part,
                    drag,
                    speed,
                    np.degrees(path),
                    height,
                ]
            )
        if 8.0 < t < 10.0:
            path -= np.radians(0.3) * STEP
        elif t >= 10.0:
            path -= 9.80665 * np.cos(path) / speed * STEP
        speed += ((thrust - drag) / mass - 9.80665 * np.sin(path)) * STEP
        height += speed * np.sin(path) * STEP
        mass -= 118.0 * STEP
    return np.array(computed, dtype=float)


def write(path: Path) -> Path:
    """Write the schedule, with its first row."""
    lines = [",".join(f"{x:.12g}" for x in row) for row in rows()]
    path.write_text("\n".join([KEYS, *lines]) + "\n")
    return path


def sounding(strength: float = 1.0) -> tv.WindProfile:
    """A wind that blows on the ground too, with a jet at 12 km."""
    height = np.array([0, 50, 200, 500, 1e3, 2e3, 4e3, 6e3, 8e3, 1e4, 12e3, 14e3, 16e3, 2e4, 6e4])
    speed = strength * np.array([6, 8, 10, 12, 14, 18, 26, 35, 45, 55, 58, 50, 35, 15, 10])
    turn = np.radians(270.0 + 10.0 * np.sin(height / 3e3))
    return tv.WindProfile(height=height, east=-speed * np.sin(turn), north=-speed * np.cos(turn))
