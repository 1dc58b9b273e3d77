"""Tables of a wind over height with units in the header, as height_m,speed_kt,direction_deg.

A column is recognised by the words of its name, which also give its unit and the reference of a
height (sea or ground). Speed and direction or the components east and north are read; if both are
present, they are compared.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, between, number, shown
from tvclin.base.errors import text as a_text
from tvclin.base.files import called
from tvclin.base.lines import listed
from tvclin.base.sheet import Heading, Headings, Sheet, Text, head_of, sheet_in
from tvclin.base.units import DEGREE, factor_of
from tvclin.winds.soundings.levels import Levels, SoundingEntry, wind_components

_NAMES = {
    **dict.fromkeys(("geopotential height", "height", "altitude", "alt"), "height"),
    **dict.fromkeys(("speed", "windspeed", "wspd", "spd"), "speed"),
    **dict.fromkeys(("direction", "dir", "winddirection", "winddir", "wdir"), "direction"),
    **dict.fromkeys(("east", "eastward", "zonal", "u"), "east"),
    **dict.fromkeys(("north", "northward", "meridional", "v"), "north"),
}
"""Quantities by the words of names, without a leading "wind"."""
_KINDS = {"height": "length", "direction": "angle"} | dict.fromkeys(
    ("speed", "east", "north"), "speed"
)
_SEA = {"msl", "amsl", "asl", "a.m.s.l.", "a.s.l.", "sea"}
_GROUND = {"agl", "a.g.l.", "ground", "surface"}
_QUALIFIERS = {
    "height": _SEA | _GROUND | {"above", "mean", "level", "the"},
    "direction": {"from", "true"},
    "east": {"component", "wind"},
    "north": {"component", "wind"},
    "speed": set[str](),
}
_UNIT_SPELLINGS = {
    "length": "m, km, ft",
    "speed": "m_per_s, kt, km_per_h, ft_per_s, mph",
    "angle": "deg, rad",
}
_MISSING_VALUES = (999.0, 9999.0, 99999.0, 999.9, 9999.9, -999.0, -999.9)
"""Numbers that stand for a missing value, and are no wind in any unit."""
_PAIRS = (("speed", "direction"), ("east", "north"))
_MAX_DIFFERENCE, _MAX_RELATIVE_DIFFERENCE = 1.0, 0.1
"""Difference [m/s] of components from speed and direction, and a further one over the speed."""
SITE_ELEVATIONS = (-450.0, 9000.0)
"""Smallest and largest elevation of a site [m], from the Dead Sea to the highest mountain."""
_DEFAULT_UNITS = {"length": 1.0, "speed": 1.0, "angle": DEGREE}
"""Units of OpenRocket's table of winds, to SI."""
_DEFAULT_UNIT_TEXTS = {
    "length": "altitudes in m",
    "speed": "speeds in m/s",
    "angle": "directions in deg",
}


@dataclass(frozen=True)
class TableOptions:
    """Units and site elevation of a table of winds, as the user gives them.

    `units`: factors to SI, by kind of quantity, of columns whose names have no unit. `ground`:
    elevation of the site [m] for heights above the ground. `openrocket_units`: whether columns
    without any unit have the units of OpenRocket: m, m/s and degrees.
    """

    units: dict[str, float] = field(default_factory=dict)
    ground: float | None = None
    openrocket_units: bool = False

    @classmethod
    def of(
        cls, units: str | None, above_ground: float | None, *, openrocket_units: bool
    ) -> TableOptions:
        """Return the options from texts and numbers of the user; `InputError` if invalid.

        `units`: units of columns whose names have none, such as "ft,mph"; None for no such units.
        `above_ground`: elevation [m] of the site for heights above the ground; None for heights
        above the sea. `openrocket_units`: whether columns without any unit are in m, m/s, degrees.
        """
        factors: dict[str, float] = {}
        for word in () if units is None else a_text("units", units).split(","):
            fits = {k: f for k in _UNIT_SPELLINGS if (f := factor_of(word, k)) is not None}
            kind = next(iter(fits), "")
            if not kind or kind in factors:
                raise InputError(
                    "units must name those of heights, speeds and directions, each once, such as"
                    f" ft,mph or m,kt,deg; got {shown(units)}"
                )
            factors[kind] = fits[kind]
        if above_ground is not None:
            above_ground = number("above_ground", above_ground, between(*SITE_ELEVATIONS), "m")
        return cls(units=factors, ground=above_ground, openrocket_units=openrocket_units)


@dataclass(frozen=True)
class _Column:
    """Column of a wind table.

    `factor`: to SI, None without a known unit. `geopotential`, `sea`, `ground`: whether its name
    says that a height is geopotential, above the sea or above the ground. `unnamed`: whether it has
    no unit in its name.
    """

    heading: Heading
    quantity: str
    factor: float | None
    geopotential: bool
    sea: bool
    ground: bool
    unnamed: bool


def soundings_in(text: Text, reading: TableOptions = TableOptions()) -> list[SoundingEntry]:
    """Return the sounding of a text that is a table with units in its header.

    `reading`: units and site elevation that the file does not say.
    """
    return [SoundingEntry(lambda: _read(text, reading))]


def header_index(text: Text) -> int | None:
    """Return the index of the line of a text that names a height and a wind, or None."""
    head = head_of(text, _header_score)
    return None if head is None else head[0]


def _header_score(headings: Headings) -> float:
    """Return how well a line of headings fits a table of winds, as a number.

    It is the number of its quantities, of which one without a known unit counts a third; zero
    without a height.
    """
    weights: dict[str, float] = {}
    for column in filter(None, map(_wind_column, headings)):
        weight = 1.0 if column.factor is not None else 1 / 3
        weights[column.quantity] = max(weight, weights.get(column.quantity, 0.0))
    return sum(weights.values()) if "height" in weights else 0.0


def _wind_column(heading: Heading) -> _Column | None:
    """Return the column of a heading; None for one that is no height and no wind."""
    words = heading.words
    while words and words[0] == "wind":
        words = words[1:]
    for size in (2, 1):  # names of two words first
        first, qualifiers = " ".join(words[:size]), words[size:]
        if first in _NAMES and len(words) >= size:
            quantity = _NAMES[first]
            unit = [word for word in qualifiers if word not in _QUALIFIERS[quantity]]
            return _Column(
                heading=heading,
                quantity=quantity,
                factor=factor_of(" ".join(unit), _KINDS[quantity]),
                geopotential=first.startswith("geopotential"),
                sea=not _SEA.isdisjoint(qualifiers),
                ground=not _GROUND.isdisjoint(qualifiers),
                unnamed=not unit,
            )
    return None


def _read(text: Text, reading: TableOptions) -> Levels:
    """Return the levels of a table in a text, with notes on assumptions and conversions.

    `reading`: units and site elevation that the file does not say.
    """
    sheet = sheet_in(
        text,
        _header_score,
        "names with a height; write one such as height_m,speed_m_per_s,direction_deg",
    )
    columns, assumed = _selected_columns(sheet, reading)
    notes = [*sheet.notes]
    if assumed:
        notes.append(
            f"assumed, as the file does not say: {listed(assumed)} (else give units and"
            " above_ground, as keys of [sounding])"
        )
    values = {name: _values(sheet, column, notes) for name, column in columns.items()}
    if reading.ground is not None:
        values["height"] = values["height"] + reading.ground
        notes.append(f"heights above the ground, at {reading.ground:g} m: above the sea")
    if len(values) == 5:  # height, speed, direction, and the east and north components
        _compare_components(sheet, values, notes)
    make: Callable[..., Levels] = Levels.from_direction if "speed" in values else Levels
    return make(
        text=text,
        line=sheet.line,
        **values,
        geopotential=columns["height"].geopotential,
        # a column of time: levels in the order of an ascent, of which some may descend
        balloon=any("time" in heading.names for heading in sheet.headings),
        notes=tuple(notes),
    )


def _selected_columns(sheet: Sheet, reading: TableOptions) -> tuple[dict[str, _Column], list[str]]:
    """Return the columns to read by quantity, with their factors, and texts of assumed units.

    `reading`: units and site elevation that the `sheet` does not say.
    """
    candidates = [column for column in map(_wind_column, sheet.headings) if column is not None]
    # factors to SI by kind of quantity, for columns whose names have no unit
    units = reading.units
    if reading.openrocket_units:
        units = _DEFAULT_UNITS | units
    elif units:  # directions are in degrees where the user names other units alone
        units = {"angle": DEGREE} | units
    usable: dict[str, list[_Column]] = {}  # heights above the sea or, with `ground`, above that
    for column in _by_reference(sheet, candidates, reading.ground):
        factor = units.get(_KINDS[column.quantity]) if column.unnamed else column.factor
        if factor is not None:
            usable.setdefault(column.quantity, []).append(replace(column, factor=factor))
    for quantity, columns in usable.items():
        if len(columns) > 1:
            names = " and ".join(called(column.heading.text) for column in columns)
            raise sheet.error(f"{quantity} is given twice, as {names}; keep one")
    pairs = [pair for pair in _PAIRS if all(name in usable for name in pair)]
    if "height" not in usable or not pairs:
        raise _missing_columns_error(sheet, candidates, list(usable))
    selected = {name: usable[name][0] for name in ("height", *(n for pair in pairs for n in pair))}
    # kinds of quantity with an assumed unit, of which there is a text
    unnamed = {_KINDS[name] for name, column in selected.items() if column.unnamed}
    texts = [
        text for kind, text in _DEFAULT_UNIT_TEXTS.items() if kind in unnamed - reading.units.keys()
    ]
    if "length" in unnamed and reading.ground is None:
        texts.append("altitudes above the sea")
    return selected, texts


def _by_reference(sheet: Sheet, candidates: list[_Column], ground: float | None) -> list[_Column]:
    """Return the columns of a sheet but heights above the unwanted reference, sea or ground.

    `candidates`: columns of heights and winds. `ground`: elevation of the site [m]: heights above
    the ground are wanted; None: above the sea. `InputError` where no height has the wanted
    reference, or one says that it is above the sea though `ground` is given.
    """
    heights = [column for column in candidates if column.quantity == "height"]
    above_sea = [column for column in heights if not column.ground]
    names = ", ".join(called(column.heading.text) for column in heights)
    if heights and ground is None and not above_sea:
        raise sheet.error(
            f"{names} is above the ground (AGL), and winds are above the sea: give above_ground"
            ", the elevation of the site in m, in [sounding], or export heights above the sea"
        )
    if ground is not None and any(column.sea or column.geopotential for column in heights):
        raise sheet.error(f"there are heights above the sea ({names}): leave above_ground out")
    above_ground = [column for column in heights if column.ground]
    dropped = above_ground
    if ground is not None:  # heights without a reference count where none is above the ground
        dropped = above_sea if above_ground else []
    return [column for column in candidates if column not in dropped]


def _missing_columns_error(
    sheet: Sheet, candidates: list[_Column], usable: list[str]
) -> InputError:
    """Return the error on the header of a sheet without a height or a complete wind.

    `candidates`: columns of heights and winds in it. `usable`: quantities with a known unit.
    """
    for column in candidates:
        if column.factor is None and column.quantity not in usable:
            name, kind = column.quantity, _KINDS[column.quantity]
            spelled = ", ".join(f"{name}_{unit}" for unit in _UNIT_SPELLINGS[kind].split(", "))
            hint = (
                ", or give the units of a file that names none (units in [sounding], as ft,mph;"
                " those of OpenRocket's winds: --set sounding.format openrocket)"
                if column.unnamed
                else ""
            )
            return sheet.error(
                f"{shown(column.heading.text)} has no known unit; write {spelled}{hint}"
            )
    return sheet.error(
        "the header must name a height and either speed and direction or east and north, with"
        f" their units, as height_m,speed_m_per_s,direction_deg; got {', '.join(usable) or 'none'}"
    )


def _values(sheet: Sheet, column: _Column, notes: list[str]) -> FloatArray:
    """Return the numbers in a column of a sheet in SI units, ``(n,)``, NaN for missing values.

    `column`: of a known unit. A note on numbers that stand for a missing value, which none does
    among heights, is appended to `notes`.
    """
    assert column.factor is not None
    heading = column.heading
    values = sheet.text.numbers(heading.text, sheet.column(heading), sheet.line)
    missing = np.isin(values, _MISSING_VALUES) & (column.quantity != "height")
    if np.any(missing):
        number = f"{values[np.argmax(missing)]:g}"
        notes.append(f"{number} in {called(heading.text)} taken for a missing value")
    return column.factor * np.where(missing, np.nan, values)


def _compare_components(sheet: Sheet, values: dict[str, FloatArray], notes: list[str]) -> None:
    """Remove components given besides speed and direction, if they agree with these.

    `values`: columns of the sheet by quantity, in SI units, ``(n,)``, from which both are removed.
    `notes`: a note on their difference is appended. An `InputError` names the line of a difference
    that is too large.
    """
    _, components = _PAIRS
    east, north = (values.pop(name) for name in components)
    to_east, to_north = wind_components(values["speed"], values["direction"])
    difference = np.hypot(east - to_east, north - to_north)
    agrees = ~(difference > _MAX_DIFFERENCE + _MAX_RELATIVE_DIFFERENCE * values["speed"])
    sheet.text.require(
        agrees,
        sheet.line,
        lambda i: (
            f"speed and direction give {to_east[i]:.4g} m/s towards the east and"
            f" {to_north[i]:.4g} towards the north, and the components are {east[i]:.4g} and"
            f" {north[i]:.4g}; keep the right pair of columns"
        ),
    )
    largest = np.nanmax(difference, initial=0.0)
    notes.append(
        f"speed and direction read; the components beside them differ by up to {largest:.2g} m/s"
    )
