"""Winds of files: the tables [wind] and [gust], and files of sampled winds."""

import csv
import io
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tvclin.base.errors import InputError, number, one_of, positive
from tvclin.base.files import called, read_text
from tvclin.base.tables import FileTable
from tvclin.base.units import UNITS
from tvclin.vehicle.linear_vehicle import AnyVehicle, whole_vehicle
from tvclin.winds.gusts import LayeredGust, OneMinusCosineGust
from tvclin.winds.histories import History
from tvclin.winds.shaped import ShapedWind, WindEnsemble

_PULSE = {"peak": "angle", "duration": "time"}
_DIRECTION = {"direction": "angle", "azimuth": "angle"}
SOUNDING = "sounding"
"""The key of a [[wind]] that stands over height."""
WIND_TABLE = FileTable(
    "[wind]",
    {**_PULSE, **_DIRECTION},
    words=("shape", "file", "unit", SOUNDING),
    required=("peak", "duration"),
)
SOUNDING_TABLE = FileTable(
    "[[wind]]", {"azimuth": "angle"}, (SOUNDING, "name", "format", "time"), required=("azimuth",)
)
GUST_TABLE = FileTable(
    "[gust]",
    {**_PULSE, "peak_speed": "speed", "plateau": "time", "peak_time": "time"},
    required=("duration",),
)
_ANY_PEAK = 0.01
"""Of a gust whose speed says its peak [rad]."""
_FILE_TABLE = FileTable("[wind]", words=("file", "unit"))


def winds_of(document: Mapping[str, Any], folder: Path) -> list[ShapedWind | WindEnsemble]:
    """Return the winds of [wind], or of each [[wind]], but for soundings, which need a flight."""
    if "wind" not in document:
        raise InputError("[wind] is missing: it gives shape, peak_deg and duration_s")
    tables = [table for table in wind_tables(document) if SOUNDING not in table]
    if not tables:
        raise InputError("beside soundings a wind of one shape is needed: give one more [[wind]]")
    return [wind_of(table, folder) for table in tables]


def wind_tables(document: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return [wind], or each [[wind]]."""
    given = document.get("wind", {})
    rows = given if isinstance(given, list) else [given]
    if not all(isinstance(row, dict) for row in rows):
        raise InputError("wind must be a table [wind], or [[wind]] once for each")
    return [dict(row) for row in rows]


def wind_of(table: dict[str, Any], folder: Path) -> ShapedWind | WindEnsemble:
    """Return the wind of the table [wind]; a file of winds is looked for in the folder."""
    if "file" in table:
        given = _FILE_TABLE.read(table)
        angles = UNITS["angle"]
        factor = angles[one_of("unit in [wind]", given.get("unit", "deg"), angles)]
        time, angle = _read_winds(folder / str(given["file"]))
        return WindEnsemble(time, angle * factor)
    given = {"shape": "triangular"} | WIND_TABLE.read(table)
    if "unit" in given:
        raise InputError("unit in [wind] stands without the file that it is of")
    directions = [given.pop(name, None) for name in _DIRECTION]
    return ShapedWind(**given, heading=heading_of(*directions))


def heading_of(
    direction: float | None,
    azimuth: float | None,
    names: tuple[str, str] = ("direction in [wind]", "azimuth"),
) -> float | None:
    """Return the heading of `ShapedWind` [rad]; None without a direction.

    `direction`, `azimuth`: where the wind blows from and where the flight goes to [rad], from
    north, clockwise. `names`: how a message calls them.
    """
    if direction is None and azimuth is None:
        return None
    if direction is None or azimuth is None:
        given, needed = names if azimuth is None else names[::-1]
        raise InputError(
            f"{given} needs {needed}: where the wind blows from and where the flight goes to, both"
            " from north, clockwise"
        )
    return direction - azimuth


def with_gust(
    document: Mapping[str, Any], wind: ShapedWind | WindEnsemble, vehicle: AnyVehicle, plane: str
) -> ShapedWind | WindEnsemble:
    """Return a wind with the gust of [gust] on top, by its speed as met by a vehicle in a plane."""
    if "gust" not in document:
        return wind
    if isinstance(wind, WindEnsemble):
        raise InputError("[gust] is on top of a wind of one shape; the winds of a file have theirs")
    given = GUST_TABLE.read(GUST_TABLE.one(document))
    speed, at = given.get("peak_speed"), given.get("peak_time")
    if (speed is None) == ("peak" not in given):
        raise InputError("[gust] needs its peak: peak_deg, or peak_speed_m_per_s; keep one")
    gust = gust_of(given.get("peak", _ANY_PEAK), given["duration"], given.get("plateau", 0.0))
    wind = replace(wind, gust=gust, gust_at=at)
    if speed is None:
        return wind
    return wind.gust_of_speed(speed, whole_vehicle(vehicle, "the speed of a gust"), plane)


def gust_of(peak: float, duration: float, plateau: float = 0.0) -> History:
    """Return a gust that rises and falls as a cosine, and stays at its peak [rad] between [s]."""
    if not plateau:
        return OneMinusCosineGust(peak=peak, duration=duration)
    rest = number("duration", duration, positive, "s") - number("plateau", plateau, positive, "s")
    if rest <= 0.0:
        raise InputError(
            "the plateau of a gust must be shorter than the gust; got"
            f" {plateau:g} of {duration:g} s"
        )
    return LayeredGust(peak=peak, blend=0.5 * rest, plateau=plateau)


def _read_winds(path: Path) -> tuple[Any, Any]:
    """Times [s] from the first column, and one wind for each further column."""
    text, name = read_text(path, "a file of winds"), called(path)
    try:
        rows = [row for row in csv.reader(io.StringIO(text, newline="")) if row]
    except csv.Error as error:
        raise InputError(f"{name} is not CSV: {error}") from None
    try:
        table = np.array([[float(cell) for cell in row] for row in rows[1:]])
    except ValueError:
        raise InputError(f"{name} must hold numbers in equal rows below its headings") from None
    if not rows or rows[0][0].strip() != "time_s" or table.ndim != 2 or table.shape[1] < 2:
        raise InputError(f"{name} must have a first column time_s and one for each wind")
    return table[:, 0], table[:, 1:].T
