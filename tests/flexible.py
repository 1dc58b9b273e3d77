"""What bends and sloshes in the tests: a made-up booster, and configuration I with one of each.

The booster has three bending modes, two tanks and a swinging engine.
"""

import numpy as np

import tvclin as tv

BOOSTER = tv.Vehicle(
    name="made-up booster",
    weight=1.48e7,
    moment_of_inertia=2.25e8,
    normal_force_slope=6.67e6,
    thrust=2.495e7,
    aerodynamic_arm=9.45,
    control_arm=23.56,
    axial_force=8.07e5,
    velocity=538.81,
    attitude=np.radians(44.83),
)
MODES = (
    tv.vehicle.BendingMode(
        frequency=13.58,
        damping=0.005,
        modal_mass=5.10e5,
        gimbal_displacement=1.0,
        gimbal_slope=-0.0682,
        attitude_slope=0.2724,
        rate_slope=0.2548,
        pressure_displacement=-0.434,
        tank_displacements=(0.250, 1.305),
        tank_slopes=(0.1664, 0.2452),
    ),
    tv.vehicle.BendingMode(
        frequency=30.18,
        damping=0.005,
        modal_mass=2.15e5,
        gimbal_displacement=1.0,
        gimbal_slope=-0.0921,
        attitude_slope=-0.2260,
        rate_slope=-0.2007,
        pressure_displacement=0.170,
        tank_displacements=(0.679, 0.105),
        tank_slopes=(-0.0473, -0.1721),
    ),
    tv.vehicle.BendingMode(
        frequency=61.18,
        damping=0.005,
        modal_mass=1.96e5,
        gimbal_displacement=1.0,
        gimbal_slope=-0.1206,
        attitude_slope=0.3321,
        rate_slope=0.2216,
        pressure_displacement=0.344,
        tank_displacements=(-0.788, -0.738),
        tank_slopes=(-0.1226, 0.1494),
    ),
)
TANKS = (
    tv.vehicle.SloshTank(mass=24000.0, station=19.94, damping=0.01, pendulum_length=2.10),
    tv.vehicle.SloshTank(mass=7000.0, station=24.94, damping=0.01, pendulum_length=1.79),
)
ENGINE = tv.vehicle.Engine(mass=7000.0, arm=1.4, moment_of_inertia=2.0e4)
STRUCTURE = tv.Structure(
    bending=MODES, slosh=TANKS, engine=ENGINE, rate_gyro=tv.vehicle.Filter.low_pass(120.0, 0.7)
)

MODE = tv.vehicle.BendingMode(
    frequency=24.0 * np.pi,
    damping=0.005,
    modal_mass=5e4,
    gimbal_displacement=1.0,
    gimbal_slope=-0.07,
    attitude_slope=-0.4,
    rate_slope=-0.4,
)
TANK = tv.vehicle.SloshTank(mass=2000.0, station=12.0, damping=0.01, pendulum_length=2.0)
MODE_AND_TANK = """
[[bending]]
frequency_Hz = 12.0
damping = 0.005
modal_mass_kg = 5.0e4
gimbal_displacement = 1.0
gimbal_slope_per_m = -0.07
attitude_slope_per_m = -0.40
rate_slope_per_m = -0.40

[[slosh]]
mass_kg = 2000
station_m = 12.0
damping = 0.01
pendulum_length_m = 2.0
"""
"""What a vehicle file says of both."""


def transfer(matrices, s):
    """Return C (s - A)^-1 B + D at one complex frequency."""
    A, B, C, D = matrices
    return C @ np.linalg.solve(s * np.eye(A.shape[-1]) - A, B) + D


PHASED = """
[vehicle]
mass_kg = 1.2e6
moment_of_inertia_kg_m2 = 1.6e8
thrust_kN = 20000
control_arm_m = 22.0
aerodynamic_arm_m = 8.0
velocity_m_per_s = 520.0
attitude_deg = 50.0
dynamic_pressure_kPa = 38.0
reference_area_m2 = 30.0
normal_force_coefficient_slope_per_deg = 0.08
axial_force_coefficient = 0.5
[[bending]]
frequency_Hz = 2.5
damping = 0.005
modal_mass_kg = 4.0e5
gimbal_displacement = 1.0
gimbal_slope_per_m = -0.06
attitude_slope_per_m = 0.10
rate_slope_per_m = 0.10
"""
"""A vehicle whose mode is held by its phase, near its crossovers."""
