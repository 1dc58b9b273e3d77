"""The columns of the data that OpenRocket exports: which are read, and what is said of them."""

from __future__ import annotations

import re
from os import PathLike

import numpy as np

from tvclin.answers.schedules.build import above_sea
from tvclin.answers.schedules.flight import Flight
from tvclin.answers.schedules.table import Column, Heading, Table, letters, read_table_text
from tvclin.base.arrays import BoolArray
from tvclin.base.errors import InputError
from tvclin.base.files import called

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
_DENSITY = "Air density"
_DAMPING, _UNREAD = "Damping moment coefficient", "Pitch damping coefficient"
_ROD = re.compile(r"Event LAUNCHROD occurred at t=([\d.eE+-]+) s")
_ROUGH = 5e-3
"""An inertia or a density that is rounded by more is told."""


def table_of(path: str | PathLike[str]) -> Table:
    """Return the rows of an export; `InputError` where its line of names was left off."""

    def is_header(headings: tuple[Heading, ...]) -> bool:
        return any("time" in one.names and one.unit is not None for one in headings)

    table = read_table_text(path, "data that OpenRocket exports", is_header)
    if table is None:
        raise InputError(
            f"{called(path)} has no line of column names with their units, such as Time (s);"
            " export it again with field descriptions included"
        )
    return table


def columns_of(table: Table, ground: float | None, own_slope: bool) -> dict[str, Column]:
    """Return the columns of an export by name, in SI units.

    `ground`: elevation of the launch site [m]. `own_slope`: whether the slope of the normal force
    coefficient is to be read too. `InputError` for a column that is not there, is there twice, or
    has no known unit.
    """
    found = {name: _column(table, name) for name in _NEEDED}
    found |= _air(table) | _attitude(table) | _altitude(table, ground) | _damping(table)
    return found | _own_slope(table) if own_slope else found


def _column(table: Table, name: str) -> Column:
    dimension, called = _NEEDED[name]
    heading = table.find(called)
    if heading is None:
        raise InputError(
            f"{table.text.source} has no column {called}; tick it and export the file again"
        )
    return table.numbers(heading, dimension)


def _air(table: Table) -> dict[str, Column]:
    """Pressure and temperature, else density, else pressure; and the speed of sound if any."""
    density, pressure = table.find(_DENSITY), table.find("Air pressure")
    temperature, sound = table.find("Air temperature"), table.find("Speed of sound")
    found = {} if sound is None else {"sound": table.numbers(sound, "speed")}
    if pressure is not None and temperature is not None:
        found |= {"temperature": table.numbers(temperature, "temperature")}
    elif density is not None:
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
        if ground is not None:
            raise InputError(
                f"{table.text.source} has altitudes above the sea already, in {sea.name}: leave"
                " ground out"
            )
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


def _damping(table: Table) -> dict[str, Column]:
    """The damping of air and jet, where it is there."""
    heading = table.find(_DAMPING)
    return {} if heading is None else {"damping": table.numbers(heading, "damping moment")}


def unread(table: Table) -> list[str]:
    """Return what to say of columns that are not read."""
    one, parts = table.find(_UNREAD), []
    if table.find(_DAMPING) is None:
        parts = [h for h in table.headings if h.names[0].startswith(letters(_DAMPING))]
    told = [f"not read: column {part.text}, for it is a part of the damping" for part in parts]
    if one is not None:
        told += [f"not read: column {one.text}, for its name does not say which rate it refers to"]
    return told


def trusted_damping(flight: Flight, exit_arm: Column) -> tuple[dict[str, Column], list[str]]:
    """Return the damping of a flight, unless its jet has the wrong sign, and what to say of it.

    OpenRocket's is that of the air and of the jet, m' l_e^2, which before August 2026 it took away.

    `exit_arm`: l_e [m].
    """
    if "damping" not in flight.columns:
        return {}, []
    found = flight.columns["damping"]
    jet = -np.gradient(flight["mass"], flight["time"]) * exit_arm.values**2
    least = int(np.argmin(found.values))
    if found.values[least] < 0.0:
        return {}, [
            f"not read: {found.origin}, for it is negative at {flight['time'][least]:g} s:"
            " OpenRocket before August 2026 subtracts the jet damping instead of adding it; the"
            " damping is left out"
        ]
    doubted = ""
    if np.median(found.values - jet) < 0.0:
        doubted = ", and here it is mostly less than that of the jet alone: take a newer one"
    return {"pitch_damping": found}, [
        f"the damping is that of {found.origin}; OpenRocket before August 2026 subtracts the jet"
        f" damping instead of adding it{doubted}"
    ]


def rounded(table: Table, flight: Flight) -> list[str]:
    """Return what to say of an inertia or a density that was written with too few decimals."""
    told = []
    for name, dimension, header in (
        ("moment_of_inertia", *_NEEDED["moment_of_inertia"]),
        ("density", "density", _DENSITY),
    ):
        heading = table.find(header)
        if heading is None or name not in flight.columns:
            continue
        written = [row[heading.index] for row in table.cells]
        if any("e" in cell.lower() for cell in written):
            continue
        decimals = max(len(cell.partition(".")[2]) for cell in written)
        part = 0.5 * 10.0**-decimals * table.factor(heading, dimension) / flight[name]
        if part.max() >= _ROUGH:
            told.append(
                f"{heading.text} is written with {decimals} decimals, {100 * part.max():.2g}"
                " percent of it; export more, or another unit"
            )
    return told


def free(table: Table, flight: Flight) -> BoolArray:
    """Return the rows beyond the rod: where there is a centre of pressure, after that event."""
    events = [_ROD.search(content) for content in table.text.lines]
    times = [float(one[1]) for one in events if one is not None and _is_number(one[1])]
    cleared = min(times, default=-np.inf)
    return np.isfinite(flight["pressure_station"]) & (flight["time"] >= cleared)


def _is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False
