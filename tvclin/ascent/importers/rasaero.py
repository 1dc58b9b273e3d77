"""Flight schedules from the flight data that RASAero II exports."""

from __future__ import annotations

from os import PathLike

import numpy as np
from numpy.typing import ArrayLike

from tvclin.ascent.importers import powered_flight
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.errors import InputError, finite, number, one_row, positive, shown, times_row
from tvclin.base.sheet import Column, Headings, letters, read_sheet
from tvclin.base.units import POUND_FORCE

_POUNDS = {"lb": POUND_FORCE, "lbf": POUND_FORCE, "N": 1.0}
"""A pound is a force here, of a weight as well."""
_NEEDED = {
    "time": ("time", "Time"),
    "velocity": ("speed", "Velocity"),
    "weight": ("force", "Weight"),
    "pressure_station": ("length", "CP"),
    "gravity_station": ("length", "CG"),
    "thrust": ("force", "Thrust"),
    "axial_force": ("force", "Drag"),
    "drag_coefficient": ("number", "CD"),
    "angle_of_attack": ("angle", "Angle of Attack"),
    "mach": ("number", "Mach Number"),
    "attitude": ("angle", "Pitch Attitude"),
    "altitude": ("length", "Altitude"),
}

_MEND = "export all columns of the flight"


def read_rasaero(
    path: str | PathLike[str],
    *,
    gimbal_station: float,
    moment_of_inertia: tuple[ArrayLike, ArrayLike],
    normal_force_coefficient_slope: powered_flight.Slope,
    ground: float | None = None,
    start: float | None = None,
    stop: float | None = None,
    max_rows: int = powered_flight.MOST_ROWS,
) -> FlightSchedule:
    """Return the flight schedule of a flight that RASAero II exported.

    Parameters
    ----------
    path : str or path
        The CSV file of a flight without wind; `lb` is a force in it, as a weight too.
    gimbal_station : float
        Where the thrust is turned [m], from the nose tip aft.
    moment_of_inertia : (time, inertia)
        Two or more times [s] and the moments of inertia then [kg m^2], which the file does not
        have; straight lines between them, held beyond.
    normal_force_coefficient_slope : float, (mach, slope) or path
        dC_N/dalpha [1/rad], on RASAero's own area: most often its aerodynamics as a table.
    ground : float
        Elevation of the launch site above the sea [m], from -450 to 9000.
    start, stop, max_rows
        Earliest and latest time [s], by default of the first burn, and largest number of rows.

    Returns
    -------
    FlightSchedule
        The powered flight; its notes say where each column came from.

    Raises
    ------
    InputError
        As `read_openrocket`.

    Notes
    -----
    The normal force slope is q S dC_N/dalpha, eq (B1d), where q S is the drag over its coefficient,
    so that no area and no atmosphere need be known. The drag stands for the axial force: they are
    equal at zero angle of attack.
    """
    gimbal = number("gimbal_station", gimbal_station, finite, "m")
    times, inertias = _inertias(moment_of_inertia)
    missing = (
        "column names such as Time (sec), Thrust (lb), CG (in); export the flight again as CSV"
    )
    sheet = read_sheet(path, "a flight that RASAero II exports", _fit, missing)
    columns = {
        key: sheet.need(name, kind, _MEND, _POUNDS if kind == "force" else None)
        for key, (kind, name) in _NEEDED.items()
    }
    columns["altitude"] = powered_flight.above_sea(columns["altitude"], sheet.text.source, ground)
    omitted: list[str] = []
    climb = sheet.optional("climb", "Vel-V", "speed", omitted)
    flight = powered_flight.Flight(
        source=sheet.text.source,
        places=sheet.places,
        columns=columns | climb,
        notes=(*omitted, *sheet.notes),
    )
    flight = powered_flight.powered(
        flight, start, stop, np.isfinite(columns["pressure_station"].values)
    )
    slope = powered_flight.specified_slope(flight, normal_force_coefficient_slope)
    flight = flight.with_columns(
        gimbal_station=powered_flight.specified_gimbal(flight, gimbal),
        moment_of_inertia=Column(
            np.interp(flight["time"], times, inertias),
            f"given at {times.size} times from {times[0]:g} to {times[-1]:g} s",
        ),
        normal_force_slope=Column(
            flight["axial_force"] / flight["drag_coefficient"] * slope.values,
            f"q S dC_N/dalpha; q S = {flight.origin('axial_force')} over"
            f" {flight.origin('drag_coefficient')}; dC_N/dalpha = {slope.origin}",
        ),
    )
    return powered_flight.schedule_of_flight(flight, "RASAero II flight", max_rows)


def _inertias(times_and_inertias: tuple[ArrayLike, ArrayLike]) -> tuple[np.ndarray, np.ndarray]:
    """Return times [s] and moments of inertia [kg m^2] at them, ``(n,)``; `InputError` if invalid.

    `times_and_inertias`: the pair of both rows.
    """
    if not isinstance(times_and_inertias, tuple | list) or len(times_and_inertias) != 2:
        raise InputError(
            "moment_of_inertia must be a pair, of times [s] and of moments of inertia [kg m^2]"
            f" then; got {shown(times_and_inertias)}"
        )
    times = times_row("the times of moment_of_inertia", times_and_inertias[0])
    inertias = positive(
        "moment_of_inertia", one_row("moment_of_inertia", times_and_inertias[1], "kg m^2"), "kg m^2"
    )
    if times.shape != inertias.shape or times.size < 2 or np.any(np.diff(times) <= 0.0):
        raise InputError(
            "moment_of_inertia must hold two or more rising times and a moment of inertia for each;"
            f" got {times.size} and {inertias.size}"
        )
    return times, inertias


def _fit(headings: Headings) -> float:
    """Return how well the headings of a line fit: the number of needed columns among them."""
    available = {name for heading in headings for name in heading.names}
    matches = sum(letters(name) in available for _, name in _NEEDED.values())
    return matches if {"time", "cg", "thrust"} <= available else 0.0
