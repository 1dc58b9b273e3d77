"""Winds of files: the tables [wind] and [gust]."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from tvclin.base.errors import InputError, number, one_of, positive
from tvclin.base.tables import FileTable
from tvclin.base.units import UNITS
from tvclin.vehicle.linear_vehicle import AnyVehicle, whole_vehicle
from tvclin.winds.histories import History
from tvclin.winds.pulses import LayeredGust, OneMinusCosineGust
from tvclin.winds.shaped import ShapedWind, WindEnsemble

_PULSE = {"peak": "angle", "duration": "time"}
_DIRECTION = {"direction": "angle", "azimuth": "angle"}
SOUNDING = "sounding"
"""The key of a [[wind]] that stands over height."""
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
_ANY_PEAK = 0.01
"""Placeholder [rad] of a peak that is given as a wind speed, until the vehicle is known."""
_FILE_TABLE = FileTable("[wind]", words=("file", "unit"))


def winds_of(document: Mapping[str, Any], folder: Path) -> list[ShapedWind | WindEnsemble]:
    """Return the winds of [wind], or of each [[wind]], but for soundings, which need a flight.

    Without [wind] that is the gust of [gust] alone. Peaks given as a speed are those of `met_by`.
    """
    if is_gust_alone(document):
        return [_gust_alone(document)]
    if "wind" not in document:
        raise InputError("[wind] is missing: it gives shape, peak_deg and duration_s")
    tables = _shaped_tables(document)
    if not tables:
        raise InputError("beside soundings a wind of one shape is needed: give one more [[wind]]")
    if any(name.startswith("peak_speed_") for table in tables[1:] for name in table):
        raise InputError("peak_speed_m_per_s stands in the first [[wind]] alone; give peak_deg")
    return [wind_of(table, folder) for table in tables]


def is_gust_alone(document: Mapping[str, Any]) -> bool:
    """Whether the gust of [gust] is the wind, and not on top of one, or of an archive's."""
    return "gust" in document and not {"wind", "availability"} & document.keys()


def peak_speed_of(document: Mapping[str, Any]) -> float | None:
    """Return the peak speed [m/s] of the first wind of one shape; None where it has an angle."""
    if is_gust_alone(document):
        return GUST_TABLE.read(GUST_TABLE.one(document)).get("peak_speed")
    if "wind" not in document:
        return None
    first = next((table for table in _shaped_tables(document) if "file" not in table), {})
    return WIND_TABLE.read(first).get("peak_speed") if first else None


def _shaped_tables(document: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The tables of winds that are no soundings."""
    return [table for table in wind_tables(document) if SOUNDING not in table]


def _gust_alone(document: Mapping[str, Any]) -> ShapedWind:
    """The gust of [gust] as the wind itself, of the shape one-minus-cosine."""
    given = _peaked(GUST_TABLE, GUST_TABLE.one(document))
    for name in ("plateau", "peak_time"):
        if name in given:
            raise InputError(f"{GUST_TABLE.spelled(name)} of a [gust] needs a [wind] below it")
    return ShapedWind("one-minus-cosine", **given)


def _peaked(table: FileTable, given: Mapping[str, Any]) -> dict[str, Any]:
    """What a table says of a wind, with a placeholder for a peak that is given as its speed."""
    found = table.read(given)
    if ("peak_speed" in found) == ("peak" in found):
        raise InputError(
            f"{table.heading} needs its peak: peak_deg, or peak_speed_m_per_s; keep one"
        )
    return {"peak": _ANY_PEAK} | {key: one for key, one in found.items() if key != "peak_speed"}


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
        from tvclin.winds.ensemble_file import read_winds  # late: most winds have a shape

        given = _FILE_TABLE.read(table)
        unit = given.get("unit")
        if unit is not None:
            one_of("unit in [wind]", unit, UNITS["angle"])
        return WindEnsemble(*read_winds(folder / str(given["file"]), unit))
    given = {"shape": "triangular"} | _peaked(WIND_TABLE, table)
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


def met_by(
    document: Mapping[str, Any], wind: ShapedWind | WindEnsemble, vehicle: AnyVehicle, plane: str
) -> ShapedWind | WindEnsemble:
    """Return a wind with its peak, and the gust of [gust] on top, as a vehicle meets them.

    Speeds are turned into angles in a plane by eq (B1e).
    """
    speed = peak_speed_of(document)
    if speed is not None and isinstance(wind, ShapedWind):
        wind = wind.of_speed(speed, whole_vehicle(vehicle, "the speed of a wind"), plane)
    if "gust" not in document or is_gust_alone(document):
        return wind
    if isinstance(wind, WindEnsemble):
        raise InputError("[gust] is on top of a wind of one shape; the winds of a file have theirs")
    table = GUST_TABLE.one(document)
    given, speed = _peaked(GUST_TABLE, table), GUST_TABLE.read(table).get("peak_speed")
    gust = gust_of(given["peak"], given["duration"], given.get("plateau", 0.0))
    wind = replace(wind, gust=gust, gust_at=given.get("peak_time"))
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
