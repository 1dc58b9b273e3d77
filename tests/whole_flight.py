"""A made-up flight with two bending modes, a tank and an autopilot, for tests of whole flights."""

from __future__ import annotations

import numpy as np

import tvclin as tv
from tvclin.ascent import StructureSchedule
from tvclin.ascent.atmosphere import standard_atmosphere
from tvclin.vehicle import BendingMode, Filter, SloshTank, Structure

TIMES = np.array([30.0, 50.0, 70.0, 90.0, 110.0])


def mode(frequency, modal_mass, slope) -> BendingMode:
    """Return a bending mode over `TIMES`."""
    return BendingMode(
        frequency=np.interp(TIMES, [30.0, 110.0], frequency),
        damping=0.005,
        modal_mass=modal_mass,
        gimbal_displacement=1.0,
        gimbal_slope=-0.068,
        attitude_slope=slope * np.linspace(1.0, 1.2, TIMES.size),
        rate_slope=0.9 * slope,
        pressure_displacement=-0.4,
    )


def structure() -> StructureSchedule:
    """Return two modes, a tank and a gyro with a lag over the flight."""
    tank = SloshTank(
        mass=np.linspace(2400.0, 1200.0, TIMES.size),
        station=np.linspace(19.9, 16.0, TIMES.size),
        damping=0.02,
        pendulum_length=2.1,
    )
    modes = (mode((14.0, 20.0), 5.1e4, 0.027), mode((31.0, 40.0), 2.1e4, -0.02))
    whole = Structure(bending=modes, slosh=(tank,), rate_gyro=Filter.low_pass(120.0, 0.7))
    return StructureSchedule(TIMES, whole, ("first", "second"), ("lox",))


def flight(*, flexible: bool = True) -> tv.FlightSchedule:
    """Return a flight whose dynamic pressure rises and falls."""
    speed, altitude = 8.0 * TIMES, 3.0 * TIMES**2
    density = standard_atmosphere(altitude).density
    vehicle = tv.load_vehicle("configuration-i").replace(
        time=TIMES,
        velocity=speed,
        weight=np.linspace(1.9e6, 1.1e6, TIMES.size),
        moment_of_inertia=np.linspace(2.8e7, 1.4e7, TIMES.size),
        attitude=np.radians(np.linspace(80.0, 25.0, TIMES.size)),
        normal_force_slope=14.0 * 0.5 * density * speed**2,
        aerodynamic_arm=np.linspace(11.0, 8.0, TIMES.size),
    )
    bent = structure() if flexible else None
    return tv.FlightSchedule(vehicle, altitude=altitude, structure=bent)


def autopilot(**options) -> tv.control.GainSchedule:
    """Return gains over time, by a rule, with an actuator and a delay."""
    made = flight(flexible=False)
    plants = made.plants(TIMES, "drift-exact", "pitch")
    settings = {"natural_frequency": 1.1, "damping": 0.7, "actuator": tv.Actuator(), "delay": 0.01}
    return tv.control.GainSchedule.design(
        TIMES, plants.coefficients, tv.design_gains, **settings | options
    )
