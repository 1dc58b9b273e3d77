"""From the columns of a flight to its schedule: checked, thinned, with a note on each column."""

from typing import Any

import numpy as np

from tvclin.ascent.importers.checks import (
    check_angle_of_attack,
    check_attitude,
    check_gimbal,
    check_inertia,
    check_masses,
)
from tvclin.ascent.importers.flight import Flight
from tvclin.ascent.importers.slopes import Slope, slope_over_mach
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import FloatArray, IndexArray
from tvclin.base.errors import InputError, between, number, whole_number
from tvclin.base.sheet import Column
from tvclin.vehicle.vehicle import STANDARD_GRAVITY, Vehicle
from tvclin.winds.soundings.wind_table import LAND

MOST_ROWS = 200
"""Rows of a schedule, where not asked for otherwise."""
_CLOSE = 1e-3
"""Rows are added until straight lines between them are so close, in parts of the largest."""
_BESIDE = ("altitude", "nominal_deflection")
"""What a schedule holds beside its vehicle."""


def schedule_of_flight(
    flight: Flight, columns: dict[str, Column], name: str, most_rows: int = MOST_ROWS
) -> FlightSchedule:
    """Return the schedule of a powered flight.

    `flight`: the rows, with an `angle_of_attack` and the speed upwards, `climb`, where they are
    known. `columns`: the fields of a vehicle but its name and time, and altitude and nominal
    deflection where they are known, for the same rows; see `checks` for what is refused.
    """
    most = whole_number("most_rows", most_rows)
    if most < 2:
        raise InputError(f"most_rows must be 2 or more; got {most}")
    values = {key: column.values for key, column in columns.items()}
    if "angle_of_attack" in flight.columns:
        check_angle_of_attack(flight)
    if "climb" in flight.columns:
        check_attitude(flight, values["attitude"])
    check_masses(flight, values["weight"])
    check_inertia(flight, values["moment_of_inertia"], values["weight"], values["control_arm"])
    time = flight["time"]
    kept, off = rows_kept(time, values, most)
    thin = f"thinned to {kept.size} rows: straight lines are within {100 * off:.2g} percent"
    thinned = (thin,) if kept.size < time.size else ()
    beside = {key: values.pop(key)[kept] for key in _BESIDE if key in values}
    numbers: dict[str, Any] = {key: one[kept] for key, one in values.items()}
    vehicle = Vehicle(name=name, time=time[kept], **numbers)
    origins = [f"{key}: {column.origin}" for key, column in columns.items()]
    notes = (f"time: {flight.origin('time')}", *origins, *flight.notes, *thinned, *_stable(vehicle))
    return FlightSchedule(vehicle, **beside, notes=notes)


def aerodynamic_arm_of(flight: Flight) -> Column:
    """Return l_a = x_CG - x_CP [m] of stations from the nose tip aft; negative: stable."""
    gravity, pressure = flight.columns["gravity_station"], flight.columns["pressure_station"]
    return Column(gravity.values - pressure.values, f"{gravity.origin} less {pressure.origin}")


def control_arm_of(flight: Flight, gimbal: Column) -> Column:
    """Return l_c = x_gimbal - x_CG [m]; `InputError` unless it is that of a gimbal in metres."""
    gravity = flight.columns["gravity_station"]
    check_gimbal(flight, gimbal.values, gravity.values)
    return Column(gimbal.values - gravity.values, f"{gimbal.origin} less {gravity.origin}")


def weight_of(flight: Flight) -> Column:
    """Return the weight [N] of the mass at each row."""
    mass = flight.columns["mass"]
    return Column(mass.values * STANDARD_GRAVITY, f"{mass.origin} times 9.80665 m/s^2")


def given_slope(flight: Flight, given: Slope) -> Column:
    """Return the slope that is given [1/rad] at the Mach number of each row."""
    slopes = slope_over_mach(given)
    return Column(slopes.at(flight["mach"]), slopes.origin)


def given_gimbal(flight: Flight, station: float) -> Column:
    """Return the station of a gimbal [m] at each row of a flight."""
    return Column(np.full(len(flight.places), station), f"gimbal at {station:g} m, given,")


def above_sea(above_ground: Column, source: str, ground: float | None) -> Column:
    """Return altitudes above the sea [m] of those above the ground."""
    if ground is None:
        raise InputError(
            f"{source} has altitudes above the ground, and winds are above the sea: give ground,"
            " the elevation of the launch site in m (0 at the sea)"
        )
    site = number("ground", ground, between(*LAND), "m")
    return Column(above_ground.values + site, f"{above_ground.origin}, plus {site:g} m of ground")


def _stable(vehicle: Vehicle) -> tuple[str, ...]:
    arm = np.asarray(vehicle.aerodynamic_arm)
    if np.all(arm > 0.0):
        return ()
    if np.all(arm <= 0.0):
        return (
            "stable throughout: the centre of pressure lies behind the centre of gravity, and a"
            " fixed path needs no deflection; does the vehicle that is steered have these fins?",
        )
    part = int(np.sum(arm <= 0.0))
    return (f"stable at {part} of {arm.size} times, where a fixed path needs no deflection",)


def rows_kept(
    time: FloatArray, values: dict[str, FloatArray], most: int
) -> tuple[IndexArray, float]:
    """Return the rows to keep, and how far lines between them are off, in parts of the largest.

    All where they are few; else the ends, and again and again the row that is farthest off.
    """
    if time.size <= most:
        return np.arange(time.size), 0.0
    sizes = {key: float(np.abs(value).max()) for key, value in values.items()}
    table = np.array([values[key] / size for key, size in sizes.items() if size > 0.0])
    kept = np.array([0, time.size - 1])
    while True:
        lines = np.array([np.interp(time, time[kept], row[kept]) for row in table])
        far = np.abs(lines - table).max(axis=0)
        worst = int(np.argmax(far))
        if far[worst] <= _CLOSE or kept.size >= most:
            return kept, float(far[worst])
        kept = np.sort(np.append(kept, worst))
