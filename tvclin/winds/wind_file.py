"""Tables of winds in study files: [wind] or [[wind]], and [gust].

[wind] gives shape, peak (as an angle or as a speed) and duration, or a file of sampled winds;
[gust] adds a gust, or is the wind itself. Soundings over height ([[wind]] with `sounding`) need a
flight and are read elsewhere.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, number, one_of, positive, shown
from tvclin.base.sheet import Headings, read_sheet
from tvclin.base.tables import FileTable
from tvclin.base.units import UNITS, factor_of
from tvclin.vehicle.linear_vehicle import AnyVehicle, complete_vehicle
from tvclin.winds.histories import History
from tvclin.winds.pulses import LayeredGust, OneMinusCosineGust
from tvclin.winds.shaped import ShapedWind, WindEnsemble

_PULSE = {"peak": "angle", "duration": "time"}
_DIRECTION = {"direction": "angle", "azimuth": "angle"}
SOUNDING = "sounding"
"""Key of a [[wind]] that is given over height."""
WIND_TABLE = FileTable(
    "[wind]",
    {**_PULSE, "peak_speed": "speed", **_DIRECTION},
    words=("shape", "file", "unit", SOUNDING),
    required=("duration",),
)
SOUNDING_TABLE = FileTable(
    "[[wind]]",
    {"azimuth": "angle", "above_ground": "length"},
    (SOUNDING, "name", "format", "time", "units"),
    required=("azimuth",),
)
GUST_TABLE = FileTable(
    "[gust]",
    {**_PULSE, "peak_speed": "speed", "plateau": "time", "peak_time": "time"},
    required=("duration",),
)
_PLACEHOLDER_PEAK = 0.01
"""Placeholder [rad] of a peak given as a wind speed, until the vehicle is known."""
_FILE_TABLE = FileTable("[wind]", words=("file", "unit"))


def winds_of(document: Mapping[str, Any], folder: Path) -> list[ShapedWind | WindEnsemble]:
    """Return the winds of [wind], or of each [[wind]] except soundings, which need a flight.

    `document`: the study file as nested tables. `folder`: where files of winds are searched.
    Without [wind] the gust of [gust] is the wind, one-minus-cosine; a plateau and a time of the
    peak it has only on top of a wind. `wind_for_vehicle` replaces peaks that are given as a speed.
    """
    if is_wind_from_gust(document):
        values = wind_values(GUST_TABLE, GUST_TABLE.one(document))
        for name in ("plateau", "peak_time"):
            if name in values:
                raise InputError(f"{GUST_TABLE.spelled(name)} of a [gust] needs a [wind] below it")
        return [ShapedWind("one-minus-cosine", **values)]
    if "wind" not in document:
        raise InputError("[wind] is missing: it gives shape, peak_deg and duration_s")
    tables = _shaped_tables(document)
    if not tables:
        raise InputError("cases need a wind of one shape beside soundings: give one more [[wind]]")
    if any(name.startswith("peak_speed_") for table in tables[1:] for name in table):
        raise InputError("peak_speed_m_per_s stands in the first [[wind]] alone; give peak_deg")
    return [wind_of(table, folder) for table in tables]


def is_wind_from_gust(document: Mapping[str, Any]) -> bool:
    """Return whether the [gust] of a study file is itself the wind, not on top of another wind.

    Another wind is in [wind], or a sounding of [availability]. `document`: the file as nested
    tables.
    """
    return "gust" in document and not {"wind", "availability"} & document.keys()


def is_wind_measured(document: Mapping[str, Any]) -> bool:
    """Return whether all winds of [[wind]] are soundings, so that the first is the case's wind.

    `document`: study file as nested tables.
    """
    return "wind" in document and not _shaped_tables(document)


def _shaped_tables(document: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the tables of winds in a study file, `document`, that are no soundings."""
    return [table for table in wind_tables(document) if SOUNDING not in table]


def wind_values(table: FileTable, row: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values [SI] of a table of a wind, with its peak speed as "speed", or None.

    A peak by its speed has no angle until the vehicle is known: "peak" is then a placeholder [rad].
    `table`: specification of the keys. `row`: the table in the file. `InputError` unless it has one
    of both peaks.
    """
    values = table.read(row)
    if ("peak_speed" in values) == ("peak" in values):
        raise InputError(
            f"{table.heading} needs its peak: peak_deg, or peak_speed_m_per_s; keep one"
        )
    speed = values.pop("peak_speed", None)
    return {"peak": _PLACEHOLDER_PEAK, **values, "speed": speed}


def wind_tables(document: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the table [wind] of a study file, `document`, or each of its tables [[wind]]."""
    entry = document.get("wind", {})
    rows = entry if isinstance(entry, list) else [entry]
    if not all(isinstance(row, dict) for row in rows):
        raise InputError("wind must be a table [wind], or [[wind]] once for each")
    return [dict(row) for row in rows]


def directed_winds(document: Mapping[str, Any]) -> list[int]:
    """Return the indices of the winds of a study file, `document`, that need an azimuth."""
    tables = wind_tables(document) if "wind" in document else []
    return [
        k
        for k, table in enumerate(tables)
        if SOUNDING in table or any(key.startswith("direction_") for key in table)
    ]


def wind_of(table: dict[str, Any], folder: Path) -> ShapedWind | WindEnsemble:
    """Return the wind of a table [wind], from keys to values.

    `folder`: folder in which a file of winds that it names is searched.
    """
    if "file" in table:
        values = _FILE_TABLE.read(table)
        unit = values.get("unit")
        if unit is not None:
            one_of("unit in [wind]", unit, UNITS["angle"])
        return WindEnsemble(*_sampled_winds(folder / str(values["file"]), unit))
    values = {"shape": "triangular"} | wind_values(WIND_TABLE, table)
    if "unit" in values:
        raise InputError("unit in [wind] stands without the file that it is of")
    heading = heading_of(values.pop("direction", None), values.pop("azimuth", None))
    return ShapedWind(**values, heading=heading)


def heading_of(direction: float | None, azimuth: float | None) -> float | None:
    """Return the heading of `ShapedWind` [rad]; None without a direction.

    It is the direction from which the wind blows, clockwise from the flight. `direction`,
    `azimuth`: direction from which the wind blows and azimuth of the flight [rad], clockwise from
    north.
    """
    if direction is None and azimuth is None:
        return None
    if direction is None or azimuth is None:
        names = "direction in [wind]", "azimuth"
        present_name, missing_name = names if azimuth is None else names[::-1]
        option = " (--azimuth-deg)" if azimuth is None else ""
        raise InputError(
            f"{present_name} needs {missing_name}{option}: where the wind blows from and where the"
            " flight goes to, both from north, clockwise"
        )
    return direction - azimuth


def wind_for_vehicle(
    document: Mapping[str, Any], wind: ShapedWind | WindEnsemble, vehicle: AnyVehicle, plane: str
) -> ShapedWind | WindEnsemble:
    """Return a wind with its peak, and with the gust of [gust], as wind angles of a vehicle.

    `document`: study file as nested tables. `wind`: its wind, of `winds_of`. Speeds become angles
    in a plane by eq (B1e).
    """
    if isinstance(wind, ShapedWind) and wind.speed is not None:
        wind = wind.with_speed(wind.speed, complete_vehicle(vehicle, "the speed of a wind"), plane)
    if "gust" not in document or is_wind_from_gust(document):
        return wind
    if isinstance(wind, WindEnsemble):
        raise InputError("[gust] is on top of a wind of one shape; the winds of a file have theirs")
    values = wind_values(GUST_TABLE, GUST_TABLE.one(document))
    gust = gust_of(values["peak"], values["duration"], values.get("plateau", 0.0))
    wind = replace(wind, gust=gust, gust_at=values.get("peak_time"))
    if (speed := values["speed"]) is None:
        return wind
    return wind.with_gust_speed(speed, complete_vehicle(vehicle, "the speed of a gust"), plane)


def gust_of(peak: float, duration: float, plateau: float = 0.0) -> History:
    """Return a one-minus-cosine gust with a peak [rad], a duration, and a plateau at the peak [s].

    `duration`: from begin to end, with the plateau, which is zero or shorter.
    """
    if not plateau:
        return OneMinusCosineGust(peak=peak, duration=duration)
    blends = number("duration", duration, positive, "s") - number("plateau", plateau, positive, "s")
    if blends <= 0.0:
        raise InputError(
            "the plateau of a gust must be shorter than the gust; got"
            f" {plateau:g} of {duration:g} s"
        )
    return LayeredGust(peak=peak, blend=0.5 * blends, plateau=plateau)


def _sampled_winds(path: Path, unit: str | None) -> tuple[FloatArray, FloatArray]:
    """Return the times [s] of the first column of a file, and the winds [rad] of the others.

    Times are ``(n,)``, winds ``(winds, n)``. `path`: the file. `unit`: unit in [wind], for columns
    whose names have none; by default degrees.
    """
    missing = "names: a first column time_s and one for each wind"
    sheet = read_sheet(path, "a file of winds", _fit_of_winds, missing)
    time, *winds = sheet.headings
    time_factor = factor_of(" ".join(time.words[1:]), "time")
    assert time_factor is not None  # `_fit_of_winds` accepts no other heading
    columns = [time_factor * sheet.complete_numbers(time)]
    for wind in winds:
        factor = UNITS["angle"][unit or "deg"]
        column_factor = factor_of(wind.unit or "", "angle")
        if column_factor is not None:
            if unit is not None and not np.isclose(column_factor, factor):
                raise sheet.error(f"{shown(wind.text)} is not in {unit}, the unit in [wind]")
            factor = column_factor
        columns.append(factor * sheet.complete_numbers(wind))
    return columns[0], np.array(columns[1:])


def _fit_of_winds(headings: Headings) -> float:
    """Return 1 if the first heading of a line is a time with a known unit, else 0."""
    first, *units = headings[0].words or [""]
    return 1.0 if first == "time" and factor_of(" ".join(units), "time") is not None else 0.0
