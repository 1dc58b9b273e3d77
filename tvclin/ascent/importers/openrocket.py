"""Flight schedules from the data that OpenRocket exports of a simulation."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from tvclin.ascent.importers.build import (
    MOST_ROWS,
    aerodynamic_arm_of,
    control_arm_of,
    given_gimbal,
    given_slope,
    schedule_of_flight,
    weight_of,
)
from tvclin.ascent.importers.checks import check_slope
from tvclin.ascent.importers.flight import Flight, powered
from tvclin.ascent.importers.openrocket_columns import (
    columns_of,
    free,
    rounded,
    table_of,
    trusted_damping,
    unread,
)
from tvclin.ascent.importers.slopes import Slope
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.errors import between, finite, number
from tvclin.base.sheet import Column

_WINDY = 0.02
"""Speeds over the ground and through the air that differ by more: there was wind."""
_HEAT_RATIO = 1.4
_GAS_CONSTANT = 287.053
"""R of dry air [J/(kg K)], as OpenRocket has it."""


def read_openrocket(
    path: str | PathLike[str],
    *,
    gimbal_station: float,
    normal_force_coefficient_slope: Slope | None = None,
    ground: float | None = None,
    reference_area: float | None = None,
    start: float | None = None,
    stop: float | None = None,
    most_rows: int = MOST_ROWS,
) -> FlightSchedule:
    """Return the flight schedule of a simulation that OpenRocket exported.

    Parameters
    ----------
    path : str or path
        The CSV file, with field descriptions, of a simulation without wind. Any separator, comment
        character and unit that OpenRocket offers; `NaN` where it knows no number.
    gimbal_station : float
        Where the thrust is turned [m], from the nose tip aft.
    normal_force_coefficient_slope : float, (mach, slope) or path, optional
        dC_N/dalpha [1/rad]: a number, two rows over Mach, or a table that RASAero II or OpenRocket
        (component analysis) exports. From the column of that name, which exists since 2026, where
        it is not given.
    ground : float, optional
        Elevation of the launch site above the sea [m], from -450 to 9000; for a file that has no
        altitude above the sea, and not for another.
    reference_area : float, optional
        The area [m^2] on which a given slope is; that of the file where it is not given.
    start, stop : float, optional
        Earliest and latest time [s], as for one stage of several; the first burn if not given.
    most_rows : int
        More rows than that are thinned by straight lines.

    Returns
    -------
    FlightSchedule
        The powered flight from the launch rod on; its notes say where each column came from.

    Raises
    ------
    InputError
        For a column or unit that is missing, rows above 2 degrees of angle of attack, numbers that
        another unit would explain, and damaged rows; the message names the line.

    Notes
    -----
    Arms from stations: l_a = x_CG - x_CP, l_c = x_gimbal - x_CG. N = q S dC_N/dalpha, eq (B1d),
    with q = p V^2/(2 R T) where pressure and temperature are there, else rho V^2/2, else 0.7 p M^2,
    which is up to 1.4 percent too small: OpenRocket's speed of sound is a straight line over the
    temperature. Its drag force is that along the axis. Its coefficient C_N is never taken for a
    slope, nor divided by the angle. The column Damping moment coefficient, where it is there,
    becomes the `pitch_damping`; where it is negative anywhere it is left out, and a note says why.

    Examples
    --------
    >>> import tvclin as tv
    >>> flight = tv.ascent.read_openrocket(
    ...     "tests/schedules/openrocket.csv",
    ...     gimbal_station=2.95, normal_force_coefficient_slope=2.0, ground=160.0,
    ... )
    >>> flight.span, round(flight.at(3.0).normal_force_slope, 1)
    ((0.5, 5.0), 756.6)
    """
    gimbal = number("gimbal_station", gimbal_station, finite, "m")
    sheet = table_of(path)
    columns, omitted = columns_of(sheet, ground, normal_force_coefficient_slope is None)
    flight = Flight(source=sheet.text.source, places=sheet.places, columns=columns)
    flight = powered(flight, free(sheet, flight), start, stop)
    given = normal_force_coefficient_slope
    slope = flight.columns["slope"] if given is None else given_slope(flight, given)
    check_slope(slope.values)
    made = _vehicle(flight, gimbal, slope, reference_area)
    damping, told = trusted_damping(flight, made["control_arm"])
    made |= damping
    flight = flight.noted(
        *omitted, *unread(sheet), *told, *rounded(sheet, flight), *_wind(flight), *sheet.notes
    )
    return schedule_of_flight(flight, made, "OpenRocket simulation", most_rows)


def _wind(flight: Flight) -> list[str]:
    if "sound" not in flight.columns:
        return []
    through_air = flight["mach"] * flight["sound"]
    off = np.abs(through_air - flight["velocity"]) / flight["velocity"]
    worst = int(np.argmax(off))
    if off[worst] <= _WINDY:
        return []
    return [
        f"the simulation has wind: at {flight['time'][worst]:g} s the speed through the air differs"
        f" by {100 * off[worst]:.2g} percent from that over the ground; simulate without"
    ]


def _vehicle(
    flight: Flight, gimbal: float, slope: Column, reference_area: float | None
) -> dict[str, Column]:
    """The fields of a vehicle over the rows of a flight."""
    if "temperature" in flight.columns:
        density = flight["pressure"] / (_GAS_CONSTANT * flight["temperature"])
        q = 0.5 * density * flight["velocity"] ** 2
        air = f"{flight.origin('pressure')} and {flight.origin('temperature')}"
        told = f"q = p V^2/(2 R T) of {air}"
    elif "density" in flight.columns:
        q = 0.5 * flight["density"] * flight["velocity"] ** 2
        told = f"q = rho V^2/2 of {flight.origin('density')}"
    else:
        q = 0.5 * _HEAT_RATIO * flight["pressure"] * flight["mach"] ** 2
        told = (
            f"q = 0.7 p M^2 of {flight.origin('pressure')} and {flight.origin('mach')}, up to 1.4"
            " percent too small: export Air temperature too"
        )
    area: Any = flight["area"]
    on = f"S of {flight.origin('area')}, on which the slope must be"
    if reference_area is not None:
        area = number("reference_area", reference_area, between(1e-6, 1e4), "m^2")
        on = f"S = {area:g} m^2 as given (the file has {flight['area'][0]:.6g})"
    origin = f"q S dC_N/dalpha; {told}; {on}; slope: {slope.origin}"
    return {
        "weight": weight_of(flight),
        "moment_of_inertia": flight.columns["moment_of_inertia"],
        "normal_force_slope": Column(q * area * slope.values, origin),
        "thrust": flight.columns["thrust"],
        "aerodynamic_arm": aerodynamic_arm_of(flight),
        "control_arm": control_arm_of(flight, given_gimbal(flight, gimbal)),
        **{k: flight.columns[k] for k in ("axial_force", "velocity", "attitude", "altitude")},
    }
