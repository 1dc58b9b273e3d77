"""A made-up flight with two bending modes, a tank and an autopilot, for tests of whole flights."""

from __future__ import annotations

import numpy as np

import tvclin as tv
from tvclin.ascent import StructureSchedule
from tvclin.ascent.atmosphere import standard_atmosphere
from tvclin.vehicle import BendingMode, Filter, SloshTank, Structure
from tvclin.vehicle.vehicle_file import BENDING_TABLE, SLOSH_TABLE

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


def write_flight(folder) -> None:
    """Write the flight, its structure and the gains of `autopilot` as the files of a study."""
    made, law = flight(), autopilot().autopilot
    made.to_csv(folder / "plain.csv")
    head, *rows = (folder / "plain.csv").read_text(encoding="utf-8").splitlines()
    named = [f"{rows[0]},modes.csv", *(f"{row}," for row in rows[1:])]
    (folder / "flight.csv").write_text("\n".join([f"{head},structure", *named]), encoding="utf-8")
    gains = zip(TIMES, law.attitude_gain, law.rate_gain, strict=True)
    lines = ["time_s,attitude_gain,rate_gain_s", *(f"{t},{a},{r}" for t, a, r in gains)]
    (folder / "gains.csv").write_text("\n".join(lines), encoding="utf-8")
    names = ("frequency", "damping", "modal_mass", "gimbal_displacement", "gimbal_slope")
    names = (*names, "attitude_slope", "rate_slope", "pressure_displacement")
    tank = ("mass", "station", "damping", "pendulum_length")
    keys = {**BENDING_TABLE.write(dict.fromkeys(names)), **SLOSH_TABLE.write(dict.fromkeys(tank))}
    lines = [",".join(["time_s", "name", *keys])]
    for k, time in enumerate(TIMES):
        whole = made.structure.structure
        elements = [*zip(("first", "second"), whole.bending, strict=True), ("lox", whole.slosh[0])]
        for name, element in elements:
            of_kind = tank if name == "lox" else names
            table = SLOSH_TABLE if name == "lox" else BENDING_TABLE
            values = {n: np.broadcast_to(getattr(element, n), TIMES.shape)[k] for n in of_kind}
            cells = table.write(values)
            lines.append(",".join([f"{time}", name, *(f"{cells.get(key, '')}" for key in keys)]))
    (folder / "modes.csv").write_text("\n".join(lines), encoding="utf-8")
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")


STUDY = """
[study]
vehicle = "flight.csv"

[nozzle]
limit_deg = 5.0
rate_limit_deg_per_s = 20.0

[autopilot]
schedule = "gains.csv"
delay_ms = 10
sample_rate_Hz = 50

[[autopilot.filter]]
kind = "low-pass"
frequency_rad_per_s = 40.0
damping = 0.7

[[autopilot.filter]]
kind = "notch"
mode = "first"
zero_damping = 0.1
pole_damping = 0.6

[[autopilot.filter]]
kind = "notch"
mode = "second"
zero_damping = 0.1
pole_damping = 0.6

[size]
every_s = 20
"""
