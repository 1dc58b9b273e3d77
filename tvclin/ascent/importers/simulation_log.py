"""Logs of simulations in wind: the schedule of the flight, and the wind that it encountered."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path

import numpy as np

from tvclin.ascent.importers import powered_flight
from tvclin.ascent.importers.column_map import QUANTITIES, Wanted, fit_of, map_of, mapped_column
from tvclin.ascent.importers.matlab_file import MAX_NUMBERS, read_matlab, too_large
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, shown
from tvclin.base.errors import path as a_path
from tvclin.base.fields import Field, spec, specs
from tvclin.base.files import called, write_rows
from tvclin.base.sheet import Heading, Headings, Sheet, Text, read_sheet
from tvclin.base.tables import FileTable
from tvclin.base.units import WRITTEN, unit_of
from tvclin.winds.pulses import SampledWind
from tvclin.winds.soundings.profile import WindProfile
from tvclin.winds.wind_angles import angle_in_plane

_WIND = {"wind_angle": "angle", "wind_speed": "speed", "flight_path_angle": "angle"}
"""Quantities of a log for its wind; the angle of attack is one of a flight as well."""
_KNOWN = QUANTITIES | _WIND
_OPTIONAL = ("altitude", "nominal_deflection", "pitch_damping")
"""Quantities of which a column in an unknown unit is omitted."""


@dataclass(frozen=True, eq=False)
class SimulatedFlight(Shown):
    """A simulated flight and the wind that it encountered.

    Attributes
    ----------
    schedule : FlightSchedule
        The vehicle over its flight.
    wind : SampledWind
        Wind angle of attack [rad] in flight time: `size` takes it with ``placing="flight"``.
    """

    schedule: FlightSchedule = field(
        metadata=specs(
            Field(name="vehicle", of="schedule.vehicle.name"),
            Field(kind="time", name="times", of="schedule.times"),
        )
    )
    wind: SampledWind = field(metadata=spec("angle", of="wind.angle"))

    @property
    def profile(self) -> WindProfile:
        """Wind over height along a flight to the north (azimuth zero).

        `InputError` for a log without altitude, and one that does not rise.
        """
        heights = self.schedule.height
        if np.any(np.diff(heights) <= 0.0):
            raise InputError("the altitude of the log must rise, or its wind has no height")
        v = self.schedule.clamped_at(self.wind.time)
        # from eq (B1e) of the report: sin(angle) = (wind speed/speed) sin(path)
        speed = v.velocity * np.sin(self.wind.angle) / np.sin(v.attitude)
        height = np.interp(self.wind.time, self.schedule.times, heights)
        return WindProfile(height=height, east=np.zeros(height.size), north=speed, source="the log")

    def write_wind(self, path: str | PathLike[str]) -> None:
        """Write the wind over height to a file that `read_sounding` reads.

        Parameters
        ----------
        path : str or path
            The file, a CSV.

        Raises
        ------
        InputError
            As `profile`, and for a file that cannot be written.
        """
        target, wind = a_path("path", path), self.profile
        rows = np.column_stack([wind.height, wind.east, wind.north]).tolist()
        write_rows([["height_m", "east_m_per_s", "north_m_per_s"], *rows], target)


def read_log(
    path: str | PathLike[str],
    columns: Mapping[str, str | float] | None = None,
    *,
    start: float | None = None,
    stop: float | None = None,
    max_rows: int = powered_flight.MOST_ROWS,
) -> SimulatedFlight:
    """Return the schedule and the wind of a simulation's log.

    Parameters
    ----------
    path : str or path
        A text with a line of column names, or a .mat file of version 5 (to MATLAB's -v7) with a
        vector for each, in one structure or by themselves.
    columns : dict of str to str or float, optional
        Map of `read_table`, with wind_angle, wind_speed (along the flight, from behind positive)
        and flight_path_angle. Without it columns are known by our names, with the unit behind them
        (``thrust_kN``) or in parentheses (``thrust (kN)``); others are left out, with a note.
    start, stop, max_rows
        Earliest and latest time [s], by default of the first burn, and largest number of rows.

    Returns
    -------
    SimulatedFlight
        The wind is the wind angle, or follows from the wind's speed, or else from the angle of
        attack: attitude less flight path less it. Without a flight path the angle of attack is
        taken for the wind's, with the motion of the vehicle in it; a note says so.

    Raises
    ------
    InputError
        As `read_table`; for a log without wind and angle of attack, and a .mat file that cannot be
        read or is of version 7.3.

    Examples
    --------
    >>> import tvclin as tv
    >>> log = tv.ascent.read_log("tests/schedules/log.csv")
    >>> log.schedule.span, log.wind.time.size
    ((2.0, 8.0), 7)
    """
    wanted = None if columns is None else map_of(columns, _KNOWN)
    sheet = _sheet(path, wanted)
    if wanted is None:  # a map from our keys, or names, to the texts of the headings
        keys, named = FileTable("columns", _KNOWN).keys, _names(sheet.headings)
        ours = {(text if text in keys else name): text for text, name in named.items()}
        wanted = map_of(ours, _KNOWN)
    read = {k: mapped_column(sheet, k, _KNOWN[k], entry) for k, entry in wanted.items()}
    flight = powered_flight.Flight(source=sheet.text.source, places=sheet.places, columns=read)
    flight = powered_flight.powered(flight, start, stop)
    angle, how = _wind(flight)
    sources = {str(entry.source) for entry in wanted.values()}
    omitted = [heading.text for heading in sheet.headings if heading.text not in sources]
    notes = [f"left out: {', '.join(omitted)}"] if omitted else []
    notes += sheet.notes
    others = {k: v for k, v in flight.columns.items() if k not in (*_WIND, "angle_of_attack")}
    flight = replace(flight, columns=others).noted(f"wind: {how}", *notes)
    name = Path(a_path("path", path)).stem
    schedule = powered_flight.schedule_of_flight(flight, name, max_rows)
    rows, _error = powered_flight.thinned_rows(flight["time"], {"wind": angle}, max_rows)
    return SimulatedFlight(schedule, SampledWind(time=flight["time"][rows], angle=angle[rows]))


def _sheet(path: str | PathLike[str], wanted: Wanted | None) -> Sheet:
    """Return the sheet of the log of a simulation at a path, from text or a MAT file.

    `wanted`: entries of a map of columns, by quantity; None where headings are tvclin's names.
    """
    if a_path("path", path).suffix.lower() == ".mat":
        return _matlab_sheet(path)

    def fit(headings: Headings) -> float:
        """Return the number of known columns in a line of headings with a time, else 0."""
        names = _names(headings).values()
        return len(names) if "time" in names else 0.0

    missing = "column names with the time among them, as time_s"
    counted = fit if wanted is None else fit_of(wanted)
    return read_sheet(path, "the log of a simulation", counted, missing)


def _matlab_sheet(path: str | PathLike[str]) -> Sheet:
    """Return the vectors of equal length in the .mat file at a path as the columns of a table.

    A single number is a constant column.
    """
    source, variables = called(file := a_path("path", path)), read_matlab(file)
    if len(variables) == 1 and isinstance(structure := next(iter(variables.values())), dict):
        variables = dict(structure)
    numbers = {
        name: values.astype(float)
        for name, values in variables.items()
        if isinstance(values, np.ndarray) and values.ndim <= 1
    }
    rows = max((values.size for values in numbers.values()), default=0)
    columns = {name: values for name, values in numbers.items() if values.size in (1, rows)}
    if rows < 2:
        names = shown(", ".join(variables)) if variables else "nothing"
        raise InputError(f"{source} must hold vectors of one length; it holds {names}")
    if rows * len(columns) > MAX_NUMBERS:
        raise too_large(source, f"{MAX_NUMBERS // 1_000_000} million numbers")
    table = np.stack([np.broadcast_to(values, rows) for values in columns.values()], axis=1)
    return Sheet(
        text=Text(source, ()),
        headings=tuple(Heading(k, name, name, None) for k, name in enumerate(columns)),
        line=np.arange(1, rows + 1),
        cells=tuple(tuple(map(repr, row)) for row in table.tolist()),
    )


def _names(headings: tuple[Heading, ...]) -> dict[str, str]:
    """Return the quantities of those headings that are known, by the text of the heading.

    Known are our keys, as thrust_kN, and our names with a unit in parentheses, as thrust (kN).
    An optional quantity in an unknown unit is omitted.
    """
    keys = FileTable("columns", _KNOWN).keys  # name and factor to SI of each key
    by_key = {heading.text: keys[heading.text][0] for heading in headings if heading.text in keys}
    by_name = {}
    for heading in headings:
        name, unit = heading.name, heading.unit
        if name not in _KNOWN or unit is None:
            continue
        unknown_unit = unit_of(unit, WRITTEN[_KNOWN[name]]) is None
        if not (name in _OPTIONAL and unknown_unit):
            by_name[heading.text] = name
    return by_name | by_key


def _wind(flight: powered_flight.Flight) -> tuple[FloatArray, str]:
    """Return the wind angle [rad] at each row of a flight, ``(n,)``, and its origin in words."""
    have = flight.columns
    if "wind_angle" in have:
        return flight["wind_angle"], flight.origin("wind_angle")
    if "wind_speed" in have:
        at = (flight["velocity"], flight["attitude"])
        angle = angle_in_plane(flight["wind_speed"], *at, "pitch")
        return np.asarray(angle), f"{flight.origin('wind_speed')}, by eq (B1e)"
    if "angle_of_attack" not in have:
        raise InputError(
            f"{flight.source} has no wind: give wind_angle, wind_speed or angle_of_attack, each"
            " with its unit"
        )
    alpha, origin = flight["angle_of_attack"], flight.origin("angle_of_attack")
    if "flight_path_angle" in have:
        inertial = flight["attitude"] - flight["flight_path_angle"]
        return inertial - alpha, f"attitude less flight path less {origin}"
    return -alpha, f"{origin} with its sign turned, and the motion of the vehicle in it"
