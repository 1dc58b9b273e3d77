"""Flight schedules from the data that OpenRocket exports of a simulation."""

from __future__ import annotations

import re
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.answers.schedules.build import (
    MOST_ROWS,
    above_sea,
    aerodynamic_arm_of,
    control_arm_of,
    given_gimbal,
    schedule_of_flight,
)
from tvclin.answers.schedules.checks import check_slope
from tvclin.answers.schedules.flight import Flight, powered
from tvclin.answers.schedules.slopes import Slope, slope_over_mach
from tvclin.answers.schedules.table import Column, Heading, Table, read_table_text
from tvclin.answers.sizing.schedule import FlightSchedule
from tvclin.base.errors import InputError, between, finite, number
from tvclin.vehicle.vehicle import STANDARD_GRAVITY

_NEEDED = {
    "time": ("time", "Time"),
    "velocity": ("speed", "Total velocity"),
    "mass": ("mass", "Mass"),
    "moment_of_inertia": ("inertia", "Longitudinal moment of inertia"),
    "pressure_station": ("length", "CP location"),
    "gravity_station": ("length", "CG location"),
    "thrust": ("force", "Thrust"),
    "axial_force": ("force", "Drag force"),
    "angle_of_attack": ("angle", "Angle of attack"),
    "mach": ("number", "Mach number"),
    "area": ("area", "Reference area"),
}
"""What is read: the quantity, and the name of its column."""
_SLOPE = "Normal force coefficient derivative"
_COEFFICIENT = "Normal force coefficient"
_DAMPING = ("Damping moment coefficient", "Pitch damping coefficient")
_ROD = re.compile(r"Event LAUNCHROD occurred at t=([\d.eE+-]+) s")
_WINDY = 0.02
"""Speeds over the ground and through the air that differ by more: there was wind."""
_ROUGH = 5e-3
"""An inertia that is rounded by more is told."""
_HEAT_RATIO = 1.4


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
        Elevation of the launch site above the sea [m]; needed where the file has no altitude above
        the sea.
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
    with q = rho V^2/2 or, where there is no density, 0.7 p M^2. OpenRocket's drag force is that
    along the axis. Its coefficient C_N is never taken for a slope, nor divided by the angle.

    Examples
    --------
    >>> import tvclin as tv
    >>> flight = tv.read_openrocket(
    ...     "tests/schedules/openrocket.csv",
    ...     gimbal_station=2.95, normal_force_coefficient_slope=2.0, ground=160.0,
    ... )
    >>> flight.span, round(flight.at(3.0).normal_force_slope, 1)
    ((0.5, 5.0), 756.6)
    """
    gimbal = number("gimbal_station", gimbal_station, finite, "m")
    table = _table(path)
    columns = {name: _column(table, name) for name in _NEEDED}
    columns |= _air(table) | _attitude(table) | _altitude(table, ground)
    if normal_force_coefficient_slope is None:
        columns |= _own_slope(table)
    flight = Flight(source=table.text.source, places=table.places, columns=columns)
    flight = powered(flight, _free(table, flight), start, stop)
    slope = _slope(flight, normal_force_coefficient_slope)
    made = _vehicle(flight, gimbal, slope, reference_area)
    flight = flight.noted(*_unread(table), *_rounded(table, flight), *_wind(flight))
    return schedule_of_flight(flight, made, "OpenRocket simulation", most_rows)


def _table(path: str | PathLike[str]) -> Table:
    def is_header(headings: tuple[Heading, ...]) -> bool:
        return any("time" in one.names and one.unit is not None for one in headings)

    table = read_table_text(path, "data that OpenRocket exports", is_header)
    if table is None:
        raise InputError(
            f"{path} has no line of column names with their units, such as Time (s); export it"
            " again with field descriptions included"
        )
    return table


def _column(table: Table, name: str) -> Column:
    dimension, called = _NEEDED[name]
    heading = table.find(called)
    if heading is None:
        raise InputError(
            f"{table.text.source} has no column {called}; tick it and export the file again"
        )
    return table.numbers(heading, dimension)


def _air(table: Table) -> dict[str, Column]:
    """Density, or pressure, and the speed of sound where it is there."""
    density, pressure = table.find("Air density"), table.find("Air pressure")
    sound = table.find("Speed of sound")
    found = {} if sound is None else {"sound": table.numbers(sound, "speed")}
    if density is not None:
        return found | {"density": table.numbers(density, "density")}
    if pressure is not None:
        return found | {"pressure": table.numbers(pressure, "pressure")}
    raise InputError(
        f"{table.text.source} has neither a column Air density nor Air pressure, of which the"
        " dynamic pressure is made; tick one and export the file again"
    )


def _attitude(table: Table) -> dict[str, Column]:
    """The attitude above the horizon, or else the direction of flight."""
    heading = table.find("Vertical orientation (zenith)", "Vertical orientation")
    vertical = table.find("Vertical velocity")
    if heading is not None:
        found = table.numbers(heading, "angle")
        told = {"attitude": Column(found.values, f"{found.origin}, above the horizon")}
        return told if vertical is None else told | {"climb": table.numbers(vertical, "speed")}
    if vertical is None:
        raise InputError(
            f"{table.text.source} has neither a column Vertical orientation nor Vertical velocity,"
            " of which the attitude is made; tick one and export the file again"
        )
    up, total = table.numbers(vertical, "speed"), _column(table, "velocity")
    speed = np.where(total.values > 0.0, total.values, np.nan)
    angle = np.arcsin(np.clip(up.values / speed, -1.0, 1.0))
    return {"attitude": Column(angle, f"asin of {up.origin} over the speed: that of the path")}


def _altitude(table: Table, ground: float | None) -> dict[str, Column]:
    """The altitude above the sea, to which winds belong."""
    sea = table.find("Altitude above sea level")
    if sea is not None:
        return {"altitude": table.numbers(sea, "length")}
    heading = table.find("Altitude")
    if heading is None:
        raise InputError(f"{table.text.source} has no column Altitude; tick it and export again")
    found = table.numbers(heading, "length")
    return {"altitude": above_sea(found, table.text.source, ground)}


def _own_slope(table: Table) -> dict[str, Column]:
    heading = table.find(_SLOPE)
    if heading is not None:
        return {"slope": table.numbers(heading, "per angle")}
    near = table.find(_COEFFICIENT)
    is_none = f"; {near.text} is the coefficient of the flight, not its slope" if near else ""
    raise InputError(
        f"{table.text.source} has no column {_SLOPE}{is_none}: give"
        " normal_force_coefficient_slope, a number per rad or a table over Mach"
    )


def _unread(table: Table) -> list[str]:
    found = [one for one in map(table.find, _DAMPING) if one is not None]
    return [f"not read: column {one.text}; damping is not part of the model" for one in found]


def _rounded(table: Table, flight: Flight) -> list[str]:
    """What to say of an inertia that was written with too few decimals."""
    heading = table.find(_NEEDED["moment_of_inertia"][1])
    assert heading is not None  # by `_column`
    written = [row[heading.index] for row in table.cells]
    if any("e" in cell.lower() for cell in written):
        return []
    decimals = max(len(cell.partition(".")[2]) for cell in written)
    part = 0.5 * 10.0**-decimals * table.factor(heading, "inertia") / flight["moment_of_inertia"]
    if part.max() < _ROUGH:
        return []
    return [
        f"{heading.text} is written with {decimals} decimals, {100 * part.max():.2g} percent of it;"
        " export more, or another unit"
    ]


def _free(table: Table, flight: Flight) -> NDArray[np.bool_]:
    """The rows beyond the launch rod: where there is a centre of pressure, after that event."""
    events = [_ROD.search(content) for content in table.text.lines]
    times = [float(one[1]) for one in events if one is not None and _is_number(one[1])]
    cleared = min(times, default=-np.inf)
    return np.isfinite(flight["pressure_station"]) & (flight["time"] >= cleared)


def _is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False


def _slope(flight: Flight, given: Slope | None) -> Column:
    """The slope at each row [1/rad]."""
    if given is None:
        found = flight.columns["slope"]
    else:
        slopes = slope_over_mach(given)
        found = Column(slopes.at(flight["mach"]), slopes.origin)
    check_slope(found.values)
    return found


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
    if "density" in flight.columns:
        q = 0.5 * flight["density"] * flight["velocity"] ** 2
        told = f"q = rho V^2/2 of {flight.origin('density')}"
    else:
        q = 0.5 * _HEAT_RATIO * flight["pressure"] * flight["mach"] ** 2
        told = f"q = 0.7 p M^2 of {flight.origin('pressure')} and {flight.origin('mach')}"
    area: Any = flight["area"]
    on = f"S of {flight.origin('area')}, on which the slope must be"
    if reference_area is not None:
        area = number("reference_area", reference_area, between(1e-6, 1e4), "m^2")
        on = f"S = {area:g} m^2 as given (the file has {flight['area'][0]:.6g})"
    return {
        "weight": Column(
            flight["mass"] * STANDARD_GRAVITY, f"{flight.origin('mass')} times 9.80665 m/s^2"
        ),
        "moment_of_inertia": flight.columns["moment_of_inertia"],
        "normal_force_slope": Column(
            q * area * slope.values, f"q S dC_N/dalpha; {told}; {on}; slope: {slope.origin}"
        ),
        "thrust": flight.columns["thrust"],
        "aerodynamic_arm": aerodynamic_arm_of(flight),
        "control_arm": control_arm_of(flight, given_gimbal(flight, gimbal)),
        "axial_force": flight.columns["axial_force"],
        "velocity": flight.columns["velocity"],
        "attitude": flight.columns["attitude"],
        "altitude": flight.columns["altitude"],
    }
