"""Flight schedules from the data that OpenRocket exports of a simulation, and its columns."""

from __future__ import annotations

import re
from os import PathLike

import numpy as np

from tvclin.ascent.importers import powered_flight
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.errors import InputError, between, finite, number, shown
from tvclin.base.sheet import Column, Headings, Sheet, letters, read_sheet

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
    "reference_area": ("area", "Reference area"),
}
"""Quantity and column head of each value that a file must have."""
_SLOPE = "Normal force coefficient derivative"
_COEFFICIENT = "Normal force coefficient"
_DENSITY = "Air density"
_DAMPING, _UNREAD = "Damping moment coefficient", "Pitch damping coefficient"
_OF_OPENROCKET = {
    letters(name)
    for name in (
        *(name for _, name in _NEEDED.values()),
        *("Altitude", "Altitude above sea level", "Vertical velocity", "Vertical orientation"),
        *("Vertical orientation (zenith)", "Air pressure", "Air temperature", "Speed of sound"),
        *(_SLOPE, _COEFFICIENT, _DENSITY, _DAMPING, _UNREAD),
    )
}
"""Names in English that are known."""
_ROD = re.compile(r"Event LAUNCHROD occurred at t=([+-]?\d+\.?\d*(?:[eE][+-]?\d+)?) s")
_ROUGH = 5e-3
"""Relative rounding of an inertia or a density above which there is a note."""


_WITH_UNITS = 3
"""Names with a unit that make a line the head of an export in another language."""
_QUOTED = 3
"""Names of other languages that a message quotes."""


def _export(path: str | PathLike[str]) -> Sheet:
    """Return the rows of the export at a path; `InputError` where its line of names is missing."""
    names = [letters(name) for _, name in _NEEDED.values()]

    def fit(headings: Headings) -> float:
        """Return one plus the number of needed columns of a line; zero if it is no line of names.

        A line of names has a time, or several names with units, as in another language.
        """
        with_units = [heading for heading in headings if heading.unit is not None]
        available = {name for heading in with_units for name in heading.names}
        if "time" not in available and len(with_units) < _WITH_UNITS:
            return 0.0
        return 1.0 + sum(name in available for name in names)

    missing = (
        "column names with their units, such as Time (s); export it again with field descriptions"
        " included"
    )
    return read_sheet(path, "data that OpenRocket exports", fit, missing)


def _columns(
    sheet: Sheet, ground: float | None, slope_column: bool
) -> tuple[dict[str, Column], list[str]]:
    """Return the columns of a sheet by name, in SI units, and notes on those that are not read.

    `ground`: elevation of the site [m]. `slope_column`: whether the normal force slope is read too.
    """
    _check_names(sheet)
    columns = {
        name: sheet.need(header, dimension, "tick it and export the file again")
        for name, (dimension, header) in _NEEDED.items()
    }
    notes: list[str] = []
    columns["altitude"] = _altitude(sheet, ground)
    columns |= _air(sheet, notes) | _attitude(sheet, columns["velocity"], notes)
    columns |= sheet.optional("damping", _DAMPING, "damping moment", notes)
    return columns | (_slope_column(sheet) if slope_column else {}), notes


def _check_names(sheet: Sheet) -> None:
    """Raise `InputError` for a sheet that lacks columns, and say where names are translated."""
    missing = [name for _, name in _NEEDED.values() if sheet.find(name) is None]
    if not missing:
        return
    others = [heading.text for heading in sheet.headings if not _OF_OPENROCKET & set(heading.names)]
    if "Time" in missing and others:
        raise sheet.error(
            f"the names of columns are translated ({', '.join(map(shown, others[:_QUOTED]))});"
            f" missing are {', '.join(missing)}: set the language of OpenRocket to English and"
            " export the file again"
        )
    several = len(missing) > 1
    raise InputError(
        f"{sheet.text.source} has no column{'s' * several} {', '.join(missing)}; tick"
        f" {'them' if several else 'it'} and export the file again"
    )


def _air(sheet: Sheet, notes: list[str]) -> dict[str, Column]:
    """Return columns of the air by name [SI], with the speed of sound where a sheet has it.

    They are pressure and temperature, or density, or pressure, of which `InputError` if there is
    none. `notes`: notes on columns that cannot be read are appended.
    """
    columns = sheet.optional("sound", "Speed of sound", "speed", notes)
    pressure = sheet.optional("pressure", "Air pressure", "pressure", notes)
    if pressure:
        pressure |= sheet.optional("temperature", "Air temperature", "temperature", notes)
    if "temperature" in pressure:
        return columns | pressure
    if density := sheet.optional("density", _DENSITY, "density", notes):
        return columns | density
    if pressure:
        return columns | pressure
    why = "".join(f" ({note})" for note in notes)
    raise InputError(
        f"{sheet.text.source} has neither a column Air density nor Air pressure, of which the"
        f" dynamic pressure is made{why}; tick one and export the file again"
    )


def _attitude(sheet: Sheet, speed: Column, notes: list[str]) -> dict[str, Column]:
    """Return the attitude above the horizon [rad] and the speed upwards [m/s], as columns by name.

    Where a sheet has no attitude it is the path angle, from the vertical and the total `speed`
    [m/s]; the speed upwards, which gives nothing new then, is left out, as where it is unknown.
    `notes`: notes on columns that cannot be read are appended.
    """
    heading = sheet.find("Vertical orientation (zenith)", "Vertical orientation")
    if heading is not None:
        columns = sheet.numbers(heading, "angle")
        attitude = {"attitude": Column(columns.values, f"{columns.origin}, above the horizon")}
        return attitude | sheet.optional("climb", "Vertical velocity", "speed", notes)
    vertical = sheet.find("Vertical velocity")
    if vertical is None:
        raise InputError(
            f"{sheet.text.source} has neither a column Vertical orientation nor Vertical velocity,"
            " of which the attitude is made; tick one and export the file again"
        )
    up = sheet.numbers(vertical, "speed")
    sine = up.values / np.where(speed.values > 0.0, speed.values, np.nan)
    angle = np.arcsin(np.clip(sine, -1.0, 1.0))
    return {"attitude": Column(angle, f"asin of {up.origin} over the speed: that of the path")}


def _altitude(sheet: Sheet, ground: float | None) -> Column:
    """Return the altitude above the sea [m], which winds refer to, of a sheet.

    `ground`: elevation of the launch site [m], for altitudes above it; else None.
    """
    sea = sheet.find("Altitude above sea level")
    if sea is not None:
        if ground is not None:
            raise InputError(
                f"{sheet.text.source} has altitudes above the sea already, in {sea.name}: leave"
                " ground out"
            )
        return sheet.numbers(sea, "length")
    above_ground = sheet.need("Altitude", "length", "tick it and export again")
    return powered_flight.above_sea(above_ground, sheet.text.source, ground)


def _slope_column(sheet: Sheet) -> dict[str, Column]:
    """Return the slope of the normal force coefficient [1/rad] of a sheet, as a column by name.

    `InputError` without such a column.
    """
    heading = sheet.find(_SLOPE)
    if heading is not None:
        return {"normal_force_coefficient_slope": sheet.numbers(heading, "per angle")}
    coefficient = sheet.find(_COEFFICIENT)
    is_none = ""
    if coefficient is not None:
        is_none = f"; {coefficient.text} is the coefficient of the flight, not its slope"
    raise InputError(
        f"{sheet.text.source} has no column {_SLOPE}{is_none}: give"
        " normal_force_coefficient_slope, a number per rad or a table over Mach"
    )


def _unread(sheet: Sheet) -> list[str]:
    """Return notes on columns of a sheet that are not read.

    They are a part of the damping where the whole is missing, and a damping coefficient whose name
    does not say to which rate it refers.
    """
    headings, notes = sheet.headings, []
    if not any(letters(_DAMPING) in heading.names for heading in headings):
        notes = [
            f"not read: column {heading.text}, for it is a part of the damping"
            for heading in headings
            if heading.names[0].startswith(letters(_DAMPING))
        ]
    ambiguous = [heading.text for heading in headings if letters(_UNREAD) in heading.names]
    if ambiguous:
        why = "for its name does not say which rate it refers to"
        notes.append(f"not read: column {ambiguous[0]}, {why}")
    return notes


def _damping(flight: powered_flight.Flight) -> tuple[dict[str, Column], list[str]]:
    """Return the damping of a flight, unless its jet has the wrong sign, and notes on it.

    OpenRocket adds damping of the air and of the jet, m' l_c^2 (mass flow times the square of the
    control arm), which it subtracted before August 2026.
    """
    if "damping" not in flight.columns:
        return {}, []
    damping = flight.columns["damping"]
    control_arm = flight["gimbal_station"] - flight["gravity_station"]
    jet = -np.gradient(flight["mass"], flight["time"]) * control_arm**2  # [N m s]
    smallest = int(np.argmin(damping.values))
    if damping.values[smallest] < 0.0:
        return {}, [
            f"not read: {damping.origin}, for it is negative at {flight['time'][smallest]:g} s:"
            " OpenRocket before August 2026 subtracts the jet damping instead of adding it; the"
            " damping is left out"
        ]
    doubted = ""
    if np.median(damping.values - jet) < 0.0:
        doubted = ", and here it is mostly less than that of the jet alone: take a newer one"
    return {"pitch_damping": damping}, [
        f"the damping is that of {damping.origin}; OpenRocket before August 2026 subtracts the jet"
        f" damping instead of adding it{doubted}"
    ]


def _rounded(sheet: Sheet, flight: powered_flight.Flight) -> list[str]:
    """Return notes on an inertia or a density that was written with too few decimals.

    `sheet`: the cells as texts. `flight`: the powered rows, as numbers [SI].
    """
    notes = []
    for name, dimension, header in (
        ("moment_of_inertia", *_NEEDED["moment_of_inertia"]),
        ("density", "density", _DENSITY),
    ):
        heading = sheet.find(header)
        if heading is None or name not in flight.columns:
            continue
        written = [row[heading.index] for row in sheet.cells]
        if any("e" in cell.lower() for cell in written):  # with an exponent: digits, not decimals
            continue
        decimals = max(len(cell.partition(".")[2]) for cell in written)
        # half of the last decimal, in SI units, over the number
        rounding = 0.5 * 10.0**-decimals * sheet.factor(heading, dimension) / flight[name]
        if rounding.max() >= _ROUGH:
            notes.append(
                f"{heading.text} is written with {decimals} decimals, {100 * rounding.max():.2g}"
                " percent of it; export more, or another unit"
            )
    return notes


_WINDY = 0.02
"""Relative difference of ground speed and air speed above which the simulation had wind."""
_HEAT_RATIO = 1.4
_GAS_CONSTANT = 287.053
"""R of dry air [J/(kg K)], as OpenRocket has it."""


def read_openrocket(
    path: str | PathLike[str],
    *,
    gimbal_station: float,
    normal_force_coefficient_slope: powered_flight.Slope | None = None,
    ground: float | None = None,
    reference_area: float | None = None,
    start: float | None = None,
    stop: float | None = None,
    max_rows: int = powered_flight.MOST_ROWS,
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
        Reference area [m^2] of a given slope; by default the area of the file.
    start, stop, max_rows
        Earliest and latest time [s], by default of the first burn, and largest number of rows.

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
    slope = normal_force_coefficient_slope
    sheet = _export(path)
    columns, notes = _columns(sheet, ground, slope_column=slope is None)
    flight = powered_flight.Flight(source=sheet.text.source, places=sheet.places, columns=columns)
    # rows in free flight have left the rod, by the event in a comment, and a centre of pressure
    events = [_ROD.search(content) for content in sheet.text.lines]
    rod_times = [float(event[1]) for event in events if event is not None]
    cleared = min((time for time in rod_times if np.isfinite(time)), default=-np.inf)
    free = np.isfinite(flight["pressure_station"]) & (flight["time"] >= cleared)
    flight = powered_flight.powered(flight, start, stop, free)
    if slope is not None:
        flight = flight.with_columns(
            normal_force_coefficient_slope=powered_flight.specified_slope(flight, slope)
        )
    flight = flight.with_columns(
        gimbal_station=powered_flight.specified_gimbal(flight, gimbal),
        dynamic_pressure=_dynamic_pressure(flight),
        reference_area=_reference_area(flight, reference_area),
    )
    damping, damping_notes = _damping(flight)
    notes += [*_unread(sheet), *damping_notes, *_rounded(sheet, flight), *_wind(flight)]
    flight = flight.with_columns(**damping).noted(*notes, *sheet.notes)
    return powered_flight.schedule_of_flight(flight, "OpenRocket simulation", max_rows)


def _wind(flight: powered_flight.Flight) -> list[str]:
    """Return a note where the air speed of a flight, Mach times sound, is not that over ground."""
    if "sound" not in flight.columns:
        return []
    through_air = flight["mach"] * flight["sound"]
    difference = np.abs(through_air - flight["velocity"]) / flight["velocity"]
    worst = int(np.argmax(difference))
    if difference[worst] <= _WINDY:
        return []
    return [
        f"the simulation has wind: at {flight['time'][worst]:g} s the speed through the air differs"
        f" by {100 * difference[worst]:.2g} percent from that over the ground; simulate without"
    ]


def _dynamic_pressure(flight: powered_flight.Flight) -> Column:
    """Return the dynamic pressure q [Pa] of a flight, of the most exact columns of its air."""
    if "temperature" in flight.columns:
        temperature = flight.columns["temperature"]
        density = flight["pressure"] / (_GAS_CONSTANT * temperature.values)
        origin = f"p V^2/(2 R T) of {flight.origin('pressure')} and {temperature.origin}"
    elif "density" in flight.columns:
        density = flight["density"]
        origin = f"rho V^2/2 of {flight.origin('density')}"
    else:
        return Column(
            0.5 * _HEAT_RATIO * flight["pressure"] * flight["mach"] ** 2,
            f"0.7 p M^2 of {flight.origin('pressure')} and {flight.origin('mach')}, up to 1.4"
            " percent too small: export Air temperature too",
        )
    return Column(0.5 * density * flight["velocity"] ** 2, origin)


def _reference_area(flight: powered_flight.Flight, reference_area: float | None) -> Column:
    """Return the reference area S [m^2] at each row of a flight: of the file, or a specified one.

    `reference_area`: area [m^2] in place of the file's, or None.
    """
    area = flight.columns["reference_area"]
    if reference_area is None:
        return Column(area.values, f"{area.origin}, on which the slope must be")
    value = number("reference_area", reference_area, between(1e-6, 1e4), "m^2")
    origin = f"{value:g} m^2 as given (the file has {area.values[0]:.6g})"
    return Column(np.full(area.values.size, value), origin)
