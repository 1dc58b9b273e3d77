"""Flight schedules from any table with a line of column names, by a map from quantities to them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from os import PathLike
from typing import NamedTuple

import numpy as np

from tvclin.ascent.importers.powered_flight import MOST_ROWS, Flight, powered, schedule_of_flight
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.errors import InputError, number, shown
from tvclin.base.sheet import Column, Fit, Heading, Headings, Sheet, letters, read_sheet
from tvclin.base.tables import FileTable
from tvclin.base.units import POUND_FORCE, UNITS, WRITTEN, unit_of
from tvclin.vehicle.vehicle_file import DAMPING_QUANTITIES, VEHICLE_TABLE

_UNMAPPED = {"control_force_slope", *DAMPING_QUANTITIES}
"""Numbers of vehicle files that no column has."""
QUANTITIES = {
    **{name: kind for name, kind in VEHICLE_TABLE.quantities.items() if name not in _UNMAPPED},
    **dict.fromkeys(("pressure_station", "gravity_station", "gimbal_station"), "length"),
    **{"angle_of_attack": "angle", "altitude": "altitude", "nominal_deflection": "angle"},
}
"""Dimensions of the quantities of a map: keys of vehicle files, and factors of arms and forces."""
_FACTORS = {
    "weight": ("mass",),
    "aerodynamic_arm": ("gravity_station", "pressure_station"),
    "control_arm": ("gravity_station", "gimbal_station"),
    "normal_force_slope": ("dynamic_pressure", "reference_area", "normal_force_coefficient_slope"),
    "axial_force": ("dynamic_pressure", "reference_area", "axial_force_coefficient"),
}
"""Quantities from which another one is computed."""
_PATH_ANGLES = ("path_angle", "flight_path_angle", "gamma")
"""Names of a quantity that is no column of a map; the attitude stands for it."""
_DIRECT = ("moment_of_inertia", "thrust", "velocity", "attitude")


def read_table(
    path: str | PathLike[str],
    columns: Mapping[str, str | float],
    *,
    start: float | None = None,
    stop: float | None = None,
    max_rows: int = MOST_ROWS,
) -> FlightSchedule:
    """Return the flight schedule of any table, by a map from quantities to its columns.

    Parameters
    ----------
    path : str or path
        A text with a line of column names, separated by commas, semicolons, tabs or spaces.
    columns : dict of str to str or float
        For each of our names the name of the column, or a number that does not change. Our name
        carries a unit as in vehicle files (`weight_kN`), or none where the column's name has one,
        in parentheses or behind it: ``{"weight": "Gross weight (lbf)", "time": "t_s"}``. Besides
        the names of vehicle files there are mass, gravity_station, pressure_station and
        gimbal_station (from the nose tip aft), angle_of_attack, altitude and nominal_deflection.
    start, stop : float, optional
        Earliest and latest time [s], such as the burn of one stage; by default the first burn.
    max_rows : int
        Largest number of rows; a longer flight is thinned to straight lines.

    Returns
    -------
    FlightSchedule
        The powered flight; its notes say where each column came from.

    Raises
    ------
    InputError
        For a name that is unknown, missing or repeated, a unit that is missing, a coefficient in
        the place of a slope, and the reasons of `read_openrocket`.

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
    missing = f"column names with {shown(str(wanted['time'].source))} among them"
    sheet = read_sheet(path, "a table of a flight", fit_of(wanted), missing)
    read = {k: mapped_column(sheet, k, QUANTITIES[k], entry) for k, entry in wanted.items()}
    flight = Flight(source=sheet.text.source, places=sheet.places, columns=read, notes=sheet.notes)
    return schedule_of_flight(powered(flight, start, stop), "mapped table", max_rows)


class MapEntry(NamedTuple):
    """Entry of a map from quantities to columns.

    `key`: key of the quantity in the map. `factor`: factor to SI of the unit in the key; None where
    the column names its unit. `source`: name of the column, or a constant.
    """

    key: str
    factor: float | None
    source: str | float


Wanted = dict[str, MapEntry]
"""Entries of a map by quantity."""


def map_of(columns: Mapping[str, str | float], quantities: Mapping[str, str]) -> Wanted:
    """Return the entries of a map from quantities to columns, each with its key and unit.

    `columns`: the map, from our names with a unit or without to names of columns, or constants.
    `quantities`: kind of unit of each known quantity. `InputError` for unknown, double and missing
    ones.
    """
    if not isinstance(columns, Mapping):
        raise InputError(
            "columns must be a dict of quantities and the names of their columns, as"
            f" {{'time': 'Time (s)'}}; got {shown(columns)}"
        )
    table = FileTable("[columns]", dict(quantities))
    table_keys = table.keys
    mapped: Wanted = {}
    for key, source in columns.items():
        without_unit = isinstance(key, str) and key in quantities
        if not without_unit and key not in table_keys:
            raise InputError(_unknown_key(table, key))
        name, factor = (key, None) if without_unit else table_keys[key]
        if name in mapped:
            raise InputError(f"columns has {name} twice, as {mapped[name].key} and {key}; keep one")
        if not isinstance(source, str):
            number(f"columns: {key}", source)
            if factor is None and quantities[name] != "number":
                unit = next(iter(UNITS[quantities[name]]))
                raise InputError(f"columns: {key} is a number without a unit; write {name}_{unit}")
        mapped[name] = MapEntry(key, factor, source)
    _check_complete(mapped)
    return mapped


def _unknown_key(table: FileTable, key: object) -> str:
    """Return the message on a `key` of a map that `table` does not have, with similar keys."""
    if not isinstance(key, str):
        return f"columns must have texts as keys, as 'time'; got {shown(key)}"
    if key.startswith(_PATH_ANGLES):
        return (
            f"unknown key in [columns]: {shown(key)}; give attitude, as attitude_deg, which equals"
            " the path angle of a flight without an angle of attack"
        )
    return table.unknown(key)


def _check_complete(mapped: Wanted) -> None:
    """Raise `InputError` for a map without time, or with missing or doubly given quantities.

    `mapped`: its entries by quantity.
    """
    if "time" not in mapped or not isinstance(mapped["time"].source, str):
        raise InputError("columns must name the column of the time, as time = 'Time (s)'")
    for name in (*_DIRECT, *_FACTORS):
        # Quantities from which it may be computed; the last belongs to this one alone, others such
        # as the dynamic pressure may be given for another quantity.
        factors = _FACTORS.get(name, ())
        if name in mapped and factors and factors[-1] in mapped:
            raise InputError(f"columns has both {name} and {factors[-1]}; keep one")
        if name not in mapped and not (factors and mapped.keys() >= set(factors)):
            alternative = f", or {', '.join(factors)}" if factors else ""
            raise InputError(f"columns must have {name}{alternative}")


def fit_of(wanted: Wanted) -> Fit:
    """Return the function that counts the columns of a line that a map names; 0 without a time.

    `wanted`: entries of the map by quantity.
    """
    # names of columns, with single blanks
    sources = [entry.source for entry in wanted.values()]
    names = {" ".join(source.split()) for source in sources if isinstance(source, str)}
    time = " ".join(str(wanted["time"].source).split())

    def fit(headings: Headings) -> float:
        """Return the number of headings of a line in `names`; 0 without the mapped time."""
        available = {name for heading in headings for name in (heading.text, heading.name)}
        return len(names & available) if time in available else 0.0

    return fit


def _named(headings: tuple[Heading, ...], name: str) -> Heading | None:
    """Return the heading of a name; None without one, `InputError` for several."""
    words = " ".join(name.split())
    matches = [heading for heading in headings if words in (heading.text, heading.name)]
    if len(matches) > 1:
        raise InputError(f"the column {shown(name)} is there {len(matches)} times; keep one")
    return matches[0] if matches else None


def mapped_column(sheet: Sheet, name: str, dimension: str, entry: MapEntry) -> Column:
    """Return the column [SI] of a quantity from a sheet, or a constant one.

    `name`, `dimension`: name of the quantity, and kind of its unit. `entry`: its key in the map,
    the unit of the key, and the name of the column or the constant.
    """
    key, factor, source = entry
    if not isinstance(source, str):
        value = float(source) * (1.0 if factor is None else factor)
        return Column(np.full(sheet.line.size, value), f"given, {key} = {source:g}")
    heading = _named(sheet.headings, source)
    if heading is None:
        raise InputError(
            f"{sheet.text.source} has no column {shown(source)}, which columns has for {key}; it"
            f" has {shown(', '.join(heading.text for heading in sheet.headings))}"
        )
    if name == "normal_force_coefficient_slope" and _is_coefficient(heading):
        raise InputError(
            f"{sheet.text.source}: {heading.text} is a coefficient and not its slope over the angle"
            " of attack; give a column of the slope, or a number"
        )
    if factor is None and heading.unit is None:
        factor = _unit_behind(heading.text, dimension)
    if factor is None and heading.unit is None and "" not in WRITTEN[dimension]:
        ours = FileTable("[columns]", {name: dimension}).spelled(name)
        raise InputError(
            f"{sheet.text.source}: the unit of the column {shown(heading.text)} is not known; write"
            f" our name with its unit in [columns], {ours}"
        )
    if factor is None:
        return sheet.numbers(heading, dimension)
    units = WRITTEN[dimension]
    if name in ("weight", "thrust", "axial_force"):
        units = units | {"lb": POUND_FORCE}  # as many tools write a force
    unit = unit_of(heading.unit, units) if heading.unit else None
    if heading.unit and unit is None:
        raise InputError(
            f"{sheet.text.source}: the unit of the column {shown(heading.text)}, which columns has"
            f" for {key}, is not known; known are {', '.join(filter(None, units)) or 'none'}; if"
            " the bracket is no unit, leave it out of the name"
        )
    # from here on the key has a unit, which the unit in the heading, if any, must equal
    if unit is not None and not np.isclose(unit.factor, factor):
        raise InputError(
            f"{sheet.text.source}: {heading.text} is not in the unit of {key}; write {name} with"
            " the unit of the column, or without a unit where the column names its own"
        )
    # read as bare numbers, so that the unit of the key alone converts them
    values = sheet.numbers(replace(heading, unit=""), "number").values
    return Column(values * factor, f"column {heading.text}, read as {key}")


def _unit_behind(name: str, dimension: str) -> float | None:
    """Return the factor to SI of the unit behind the `name` of a column, as in attitude_deg.

    `dimension`: kind of the unit. None without one.
    """
    units = [unit for unit in UNITS[dimension] if unit and name.endswith(f"_{unit}")]
    return UNITS[dimension][max(units, key=len)] if units else None


def _is_coefficient(heading: Heading) -> bool:
    """Return whether a column, by its heading, holds the coefficient C_N itself, not its slope."""
    name = letters(heading.name)
    slope_words = ("alpha", "derivative", "slope", "cna", "perrad", "perdeg", "cla")
    # a letter beyond ASCII is an alpha, or what became of it
    if not heading.name.isascii() or any(word in name for word in slope_words):
        return False
    return "coefficient" in name or name in ("cn", "cl", "cnpotential")
