"""Flight schedules from any table with a line of column names, by a map from quantities to them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from os import PathLike

import numpy as np

from tvclin.ascent.importers.powered_flight import (
    MOST_ROWS,
    Flight,
    aerodynamic_arm_of,
    check_slope,
    control_arm_of,
    powered,
    schedule_of_flight,
    weight_of,
)
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.errors import InputError, number, shown
from tvclin.base.sheet import Column, Fit, Heading, Headings, Sheet, letters, read_sheet
from tvclin.base.tables import FileTable
from tvclin.base.units import POUND_FORCE, UNITS
from tvclin.base.written_units import WRITTEN, unit_of

QUANTITIES = {
    "time": "time",
    "weight": "force",
    "mass": "mass",
    "moment_of_inertia": "inertia",
    "thrust": "force",
    "aerodynamic_arm": "length",
    "control_arm": "length",
    "pressure_station": "length",
    "gravity_station": "length",
    "gimbal_station": "length",
    "normal_force_slope": "force slope",
    "axial_force": "force",
    "dynamic_pressure": "pressure",
    "reference_area": "area",
    "normal_force_coefficient_slope": "per angle",
    "axial_force_coefficient": "number",
    "velocity": "speed",
    "attitude": "angle",
    "angle_of_attack": "angle",
    "altitude": "length",
    "nominal_deflection": "angle",
    "pitch_damping": "damping moment",
}
"""What may be mapped: the names of vehicle files, and what arms and forces are made of."""
_EITHER = {
    "weight": ("mass",),
    "aerodynamic_arm": ("gravity_station", "pressure_station"),
    "control_arm": ("gravity_station", "gimbal_station"),
    "normal_force_slope": ("dynamic_pressure", "reference_area", "normal_force_coefficient_slope"),
    "axial_force": ("dynamic_pressure", "reference_area", "axial_force_coefficient"),
}
"""What stands in the place of a quantity."""
_PLAIN = ("moment_of_inertia", "thrust", "velocity", "attitude")


def read_table(
    path: str | PathLike[str],
    columns: Mapping[str, str | float],
    *,
    start: float | None = None,
    stop: float | None = None,
    most_rows: int = MOST_ROWS,
) -> FlightSchedule:
    """Return the flight schedule of any table, by a map from quantities to its columns.

    Parameters
    ----------
    path : str or path
        A text with a line of column names, separated by commas, semicolons, tabs or spaces.
    columns : dict of str to str or float
        For each of our names the name of the column, or a number that does not change. Our name
        carries a unit as in vehicle files (`weight_kN`), or none where the column's name has one in
        parentheses: ``{"weight": "Gross weight (lbf)"}``. Besides the names of vehicle files there
        are mass, gravity_station, pressure_station and gimbal_station (from the nose tip aft),
        angle_of_attack, altitude and nominal_deflection.
    start, stop : float, optional
        Earliest and latest time [s]; the first burn if not given.
    most_rows : int
        More rows than that are thinned by straight lines.

    Returns
    -------
    FlightSchedule
        The powered flight; its notes say where each column came from.

    Raises
    ------
    InputError
        For a name that is not known, not there, or there twice, a unit that is missing, a
        coefficient in the place of a slope, and as `read_openrocket`.

    Examples
    --------
    >>> import tvclin as tv
    >>> names = {"time": "t (s)", "mass": "m (kg)", "moment_of_inertia": "Iyy (kg m2)"}
    >>> arms = {"gimbal_station_m": 2.95, "gravity_station": "xcg (m)", "pressure_station_m": 0.96}
    >>> forces = {"thrust": "T (kN)", "axial_force_N": 190.0, "normal_force_slope_N_per_rad": "N"}
    >>> path = {"velocity": "V (m/s)", "attitude_deg": 84.0}
    >>> flight = tv.ascent.read_table("tests/schedules/table.csv", names | arms | forces | path)
    >>> flight.span, round(flight.at(3.0).control_arm, 3)
    ((1.0, 5.0), 1.214)
    """
    wanted = map_of(columns, QUANTITIES)
    time = str(wanted["time"][2])
    missing = f"column names with {shown(time)} among them"
    sheet = read_sheet(path, "a table of a flight", fit_of(wanted), missing)
    found = mapped_columns(sheet, wanted, QUANTITIES)
    flight = Flight(source=sheet.text.source, places=sheet.places, columns=found, notes=sheet.notes)
    flight = powered(flight, np.ones(sheet.line.size, dtype=bool), start, stop)
    return schedule_of_flight(flight, vehicle_columns(flight), "mapped table", most_rows)


Wanted = dict[str, tuple[str, float | None, str | float]]
"""For each quantity our key, the factor of its unit where it has one, and what is to be read."""


def map_of(columns: Mapping[str, str | float], quantities: Mapping[str, str]) -> Wanted:
    """Return what a map asks for; `InputError` for what is not known, twice there or missing."""
    if not isinstance(columns, Mapping):
        raise InputError(
            "columns must be a dict of quantities and the names of their columns, as"
            f" {{'time': 'Time (s)'}}; got {shown(columns)}"
        )
    known = FileTable("columns", dict(quantities)).keys
    found: Wanted = {}
    for key, source in columns.items():
        bare = key if isinstance(key, str) and key in quantities else None
        if bare is None and key not in known:
            raise InputError(
                f"columns must be among {', '.join(QUANTITIES)}, with or without a unit; got"
                f" {shown(key)}"
            )
        name, factor = (bare, None) if bare is not None else known[key]
        if name in found:
            raise InputError(f"columns has {name} twice, as {found[name][0]} and {key}; keep one")
        if not isinstance(source, str):
            number(f"columns: {key}", source)
            if factor is None and quantities[name] != "number":
                unit = next(iter(UNITS[quantities[name]]))
                raise InputError(f"columns: {key} is a number without a unit; write {name}_{unit}")
        found[name] = (key, factor, source)
    _check_complete(found)
    return found


def _check_complete(found: Wanted) -> None:
    if "time" not in found or not isinstance(found["time"][2], str):
        raise InputError("columns must name the column of the time, as time = 'Time (s)'")
    for name in (*_PLAIN, *_EITHER):
        others = _EITHER.get(name, ())
        if name in found and others and others[-1] in found:
            raise InputError(f"columns has both {name} and {others[-1]}; keep one")
        if name not in found and not (others and all(one in found for one in others)):
            made = f", or {', '.join(others)}" if others else ""
            raise InputError(f"columns must have {name}{made}")


def fit_of(wanted: Wanted) -> Fit:
    """Return the fit of a line of names: its columns that a map names, with the time among them."""
    names = {" ".join(one[2].split()) for one in wanted.values() if isinstance(one[2], str)}
    time = " ".join(str(wanted["time"][2]).split())

    def fit(headings: Headings) -> float:
        here = {name for one in headings for name in (one.text, one.name)}
        return len(names & here) if time in here else 0.0

    return fit


def _named(headings: tuple[Heading, ...], name: str) -> Heading | None:
    same = " ".join(name.split())
    found = [one for one in headings if same in (one.text, one.name)]
    if len(found) > 1:
        raise InputError(f"the column {shown(name)} is there {len(found)} times; keep one")
    return found[0] if found else None


def mapped_columns(
    sheet: Sheet, wanted: Wanted, quantities: Mapping[str, str]
) -> dict[str, Column]:
    """Return the columns of a sheet that a map asks for."""
    return {name: _column(sheet, name, quantities[name], *one) for name, one in wanted.items()}


def _column(
    sheet: Sheet, name: str, dimension: str, key: str, factor: float | None, source: str | float
) -> Column:
    if not isinstance(source, str):
        value = float(source) * (1.0 if factor is None else factor)
        return Column(np.full(sheet.line.size, value), f"given, {key} = {source:g}")
    heading = _named(sheet.headings, source)
    if heading is None:
        raise InputError(
            f"{sheet.text.source} has no column {shown(source)}, which columns has for {key}; it"
            f" has {shown(', '.join(one.text for one in sheet.headings))}"
        )
    if name == "normal_force_coefficient_slope" and _is_coefficient(heading):
        raise InputError(
            f"{sheet.text.source}: {heading.text} is a coefficient and not its slope over the angle"
            " of attack; give a column of the slope, or a number"
        )
    if factor is None:
        return sheet.numbers(heading, dimension)
    known = WRITTEN[dimension]
    if name in ("weight", "thrust", "axial_force"):
        known = known | {"lb": POUND_FORCE}  # as many tools write a force
    theirs = unit_of(heading.unit, known) if heading.unit else None
    if heading.unit and theirs is None:
        raise InputError(
            f"{sheet.text.source}: the unit of the column {shown(heading.text)}, which columns has"
            f" for {key}, is not known; known are {', '.join(filter(None, known)) or 'none'}; if"
            " the bracket is no unit, leave it out of the name"
        )
    if theirs is not None and not np.isclose(theirs.factor, factor):
        raise InputError(
            f"{sheet.text.source}: {heading.text} is not in the unit of {key}; write {name} with"
            " the unit of the column, or without a unit where the column names its own"
        )
    values = sheet.numbers(replace(heading, unit=""), "number").values
    return Column(values * factor, f"column {heading.text}, read as {key}")


def _is_coefficient(heading: Heading) -> bool:
    """Whether a name is that of C_N and not of its slope."""
    name = letters(heading.name)
    slope = ("alpha", "derivative", "slope", "cna", "perrad", "perdeg", "cla")
    if any(not c.isascii() for c in heading.name):  # an alpha, or what became of it
        return False
    return ("coefficient" in name or name in ("cn", "cl", "cnpotential")) and not any(
        word in name for word in slope
    )


def vehicle_columns(flight: Flight) -> dict[str, Column]:
    """Return the fields of a vehicle, and altitude and nominal deflection, of a flight."""
    have = flight.columns
    known = (*_PLAIN, "altitude", "nominal_deflection", "pitch_damping", *_EITHER)
    made = {name: have[name] for name in known if name in have}
    if "weight" not in made:
        made["weight"] = weight_of(flight)
    if "aerodynamic_arm" not in made:
        made["aerodynamic_arm"] = aerodynamic_arm_of(flight)
    if "control_arm" not in made:
        made["control_arm"] = control_arm_of(flight, have["gimbal_station"])
    for name in ("normal_force_slope", "axial_force"):
        if name not in made:
            parts = [have[one] for one in _EITHER[name]]
            values = parts[0].values * parts[1].values * parts[2].values
            made[name] = Column(values, " times ".join(one.origin for one in parts))
            if name == "normal_force_slope":
                check_slope(parts[2].values)
    return made
