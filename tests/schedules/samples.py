"""The sample of an OpenRocket export in pieces, to be written otherwise or damaged."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

import tvclin as tv

FOLDER = Path(__file__).parent
OPENROCKET = FOLDER / "openrocket.csv"
LINES = OPENROCKET.read_text(encoding="utf-8").splitlines()
HEADER = 3
"""Index of the line of names."""
NAMES = LINES[HEADER].removeprefix("# ").split(",")
GIVEN = {"gimbal_station": 2.95, "normal_force_coefficient_slope": 2.0, "ground": 0.0}

MAP: dict[str, str | float] = {
    "time": "t (s)",
    "mass": "m (kg)",
    "moment_of_inertia": "Iyy (kg m2)",
    "gravity_station": "xcg (m)",
    "pressure_station_m": 0.96,
    "gimbal_station_m": 2.95,
    "thrust": "T (kN)",
    "normal_force_slope_N_per_rad": "N",
    "axial_force_N": 190.0,
    "velocity": "V (m/s)",
    "attitude_deg": 84.0,
}
"""Of the table table.csv."""
FIELDS = (
    *("weight", "moment_of_inertia", "normal_force_slope", "thrust", "aerodynamic_arm"),
    *("control_arm", "axial_force", "velocity", "attitude"),
)


def column(name: str) -> int:
    """Return the index of the column whose name begins so."""
    (computed,) = [i for i, one in enumerate(NAMES) if one.startswith(name)]
    return computed


def changed(
    name: str, change: Callable[[float, float], object], called: str | None = None
) -> list[str]:
    """Return the lines with a column as a function of its value and the time, or another name."""
    lines, index = list(LINES), column(name)
    for i, line in enumerate(lines):
        cells = line.split(",")
        if i == HEADER and called is not None:
            cells = [*NAMES[:index], called, *NAMES[index + 1 :]]
            lines[i] = "# " + ",".join(cells)
        elif not line.startswith("#"):
            cells[index] = str(change(float(cells[index]), float(cells[0])))
            lines[i] = ",".join(cells)
    return lines


def kept(value: float, time: float) -> float:
    """Return a value as it is."""
    del time
    return value


def written(folder: Path, lines: Sequence[str], encoding: str = "utf-8") -> Path:
    """Write lines into a file and return its name."""
    file = folder / "flight.csv"
    file.write_bytes("\n".join([*lines, ""]).encode(encoding))
    return file


def read(file: Path, **others: object) -> tv.FlightSchedule:
    """Return the schedule of a file with the gimbal and slope of the sample."""
    return tv.ascent.read_openrocket(file, **(GIVEN | others))  # type: ignore[arg-type]


def number_of(line: str) -> int:
    """Return the number of the line in the file that begins so."""
    (computed,) = [i for i, one in enumerate(LINES, start=1) if one.startswith(line)]
    return computed


def same(schedule: tv.FlightSchedule, expected: tv.FlightSchedule, rtol: float) -> None:
    """Assert two schedules equal but for the rounding with which one was written."""
    np.testing.assert_allclose(schedule.times, expected.times, rtol=rtol)
    np.testing.assert_allclose(schedule.height, expected.height, rtol=rtol)
    for name in FIELDS:
        one, other = getattr(schedule.vehicle, name), getattr(expected.vehicle, name)
        np.testing.assert_allclose(one, other, rtol=rtol, err_msg=name)


def with_column(name: str, cell: Callable[[float], str], lines: Sequence[str] = LINES) -> list[str]:
    """Return lines with a column behind the others, of a function of the time."""
    return [
        f"{line},{name}" if i == HEADER else line if line.startswith("#")
        else f"{line},{cell(float(line.split(',')[0]))}"
        for i, line in enumerate(lines)
    ]  # fmt: skip
