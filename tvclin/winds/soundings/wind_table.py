"""Tables of a wind over height whose names carry units, as height_m,speed_kt,direction_deg."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, between, number, shown
from tvclin.base.errors import text as a_text
from tvclin.base.files import called
from tvclin.base.lines import listed
from tvclin.base.sheet import Heading, Headings, Sheet, head_of, sheet_in
from tvclin.base.text import Text
from tvclin.base.units import DEGREE
from tvclin.base.written_units import WRITTEN, unit_of
from tvclin.winds.soundings.levels import Found, Levels, towards

_NAMES = {
    **dict.fromkeys(("geopotential height", "height", "altitude", "alt"), "height"),
    **dict.fromkeys(("speed", "windspeed", "wspd", "spd"), "speed"),
    **dict.fromkeys(("direction", "dir", "winddirection", "winddir", "wdir"), "direction"),
    **dict.fromkeys(("east", "eastward", "zonal", "u"), "east"),
    **dict.fromkeys(("north", "northward", "meridional", "v"), "north"),
}
"""Words of names, without a wind before them, and the quantities that they name."""
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
_SPELLED = {
    "length": "m, km, ft",
    "speed": "m_per_s, kt, km_per_h, ft_per_s, mph",
    "angle": "deg, rad",
}
_MISSING = (999.0, 9999.0, 99999.0, 999.9, 9999.9, -999.0, -999.9)
"""Numbers that no wind has in any unit, and that stand for a missing one."""
_PAIRS = (("speed", "direction"), ("east", "north"))
_ABSOLUTE, _RELATIVE = 1.0, 0.1
"""Components beside speed and direction agree within so many m/s and this part of the speed."""
LAND = (-450.0, 9000.0)
"""Elevations of land [m], from the shore of the Dead Sea to the highest mountain."""
_ASSUMED = {"length": 1.0, "speed": 1.0, "angle": DEGREE}
"""Units of OpenRocket's table of winds, to SI."""
_IN_WORDS = {"length": "altitudes in m", "speed": "speeds in m/s", "angle": "directions in deg"}


@dataclass(frozen=True)
class Reading:
    """What a user says of a table of winds.

    `units`: factors to SI, by kind of quantity, of columns whose names have no unit. `ground`:
    elevation of the site [m] where heights are above the ground. `assumed`: whether a unit that is
    given nowhere is that of OpenRocket.
    """

    units: dict[str, float] = field(default_factory=dict)
    ground: float | None = None
    assumed: bool = False

    @classmethod
    def of(cls, units: str | None, above_ground: float | None, *, assumed: bool) -> Reading:
        """Return the reading of units as "ft,mph", and of an elevation [m]; None where not said."""
        found: dict[str, float] = {}
        for word in () if units is None else a_text("units", units).split(","):
            fits = [(k, u) for k in _SPELLED if (u := unit_of(word, WRITTEN[k])) and not u.mangled]
            if not fits or fits[0][0] in found:
                raise InputError(
                    "units must name those of heights, speeds and directions, each once, such as"
                    f" ft,mph or m,kt,deg; got {shown(units)}"
                )
            found[fits[0][0]] = fits[0][1].factor
        if above_ground is not None:
            above_ground = number("above_ground", above_ground, between(*LAND), "m")
        return cls(found, above_ground, assumed)


@dataclass(frozen=True)
class _Column:
    """A column of a known quantity: its unit [SI], None without a known one, and its reference."""

    heading: Heading
    quantity: str
    factor: float | None
    geopotential: bool
    sea: bool
    ground: bool
    unnamed: bool


def soundings_in(text: Text, reading: Reading = Reading()) -> list[Found]:
    """Return the sounding of a table with units in its header."""
    return [Found(lambda: _read(text, reading))]


def head_line(text: Text) -> int | None:
    """Return the index of the line that names a height and more, or None."""
    head = head_of(text, _fit)
    return None if head is None else head[0]


def _fit(headings: Headings) -> float:
    """The known columns of a line with a height; one without a known unit counts a third."""
    found: dict[str, float] = {}
    for column in filter(None, map(_known, headings)):
        weight = 1.0 if column.factor is not None else 1 / 3
        found[column.quantity] = max(weight, found.get(column.quantity, 0.0))
    return sum(found.values()) if "height" in found else 0.0


def _known(heading: Heading) -> _Column | None:
    """The column of a name; None for what is no height and no wind."""
    words = heading.words
    while words and words[0] == "wind":
        words = words[1:]
    for size in (2, 1):
        first, rest = " ".join(words[:size]), words[size:]
        if first in _NAMES and len(words) >= size:
            quantity = _NAMES[first]
            unit = [word for word in rest if word not in _QUALIFIERS[quantity]]
            found = unit_of(" ".join(unit), WRITTEN[_KINDS[quantity]]) if unit else None
            return _Column(
                heading,
                quantity,
                found.factor if found is not None and not found.mangled else None,
                first.startswith("geopotential"),
                not _SEA.isdisjoint(rest),
                not _GROUND.isdisjoint(rest),
                not unit,
            )
    return None


def _read(text: Text, reading: Reading) -> Levels:
    sheet = sheet_in(
        text, _fit, "names with a height; write one such as height_m,speed_m_per_s,direction_deg"
    )
    columns, assumed = _chosen(sheet, reading)
    notes = [*sheet.notes]
    if assumed:
        notes.append(
            f"assumed, as the file does not say: {listed(assumed)} (else give units and"
            " above_ground, or --units ft,mph and --above-ground)"
        )
    values = {name: _values(sheet, column, notes) for name, column in columns.items()}
    if reading.ground is not None:
        values["height"] = values["height"] + reading.ground
        notes.append(f"heights above the ground, at {reading.ground:g} m: above the sea")
    if len(values) == 5:
        _compare(sheet, values, notes)
    made: Callable[..., Levels] = Levels.blowing if "speed" in values else Levels
    return made(
        text=text,
        line=sheet.line,
        **values,
        geopotential=columns["height"].geopotential,
        balloon=any("time" in heading.names for heading in sheet.headings),
        notes=tuple(notes),
    )


def _chosen(sheet: Sheet, reading: Reading) -> tuple[dict[str, _Column], list[str]]:
    """The columns to read by quantity, with their factors, and in words what is assumed."""
    known = [column for column in map(_known, sheet.headings) if column is not None]
    units = reading.units
    if reading.assumed:
        units = _ASSUMED | units
    elif units:
        units = {"angle": DEGREE} | units
    usable: dict[str, list[_Column]] = {}
    for column in _of_reference(sheet, known, reading.ground):
        factor = units.get(_KINDS[column.quantity]) if column.unnamed else column.factor
        if factor is not None:
            usable.setdefault(column.quantity, []).append(replace(column, factor=factor))
    for quantity, columns in usable.items():
        if len(columns) > 1:
            both = " and ".join(called(column.heading.text) for column in columns)
            raise sheet.error(f"{quantity} is given twice, as {both}; keep one")
    pairs = [pair for pair in _PAIRS if all(name in usable for name in pair)]
    if "height" not in usable or not pairs:
        raise _incomplete(sheet, known, list(usable))
    found = {name: usable[name][0] for name in ("height", *(n for pair in pairs for n in pair))}
    of_file = {_KINDS[name] for name, column in found.items() if column.unnamed}
    words = [word for kind, word in _IN_WORDS.items() if kind in of_file - reading.units.keys()]
    if "length" in of_file and reading.ground is None:
        words.append("altitudes above the sea")
    return found, words


def _of_reference(sheet: Sheet, known: list[_Column], ground: float | None) -> list[_Column]:
    """The columns but for heights above another reference; `ground`: the site's elevation [m]."""
    heights = [column for column in known if column.quantity == "height"]
    above_sea = [column for column in heights if not column.ground]
    names = ", ".join(called(column.heading.text) for column in heights)
    if heights and ground is None and not above_sea:
        raise sheet.error(
            f"{names} is above the ground (AGL), and winds are above the sea: give above_ground"
            " (--above-ground), the elevation of the site in m, or export heights above the sea"
        )
    if ground is not None and any(column.sea or column.geopotential for column in heights):
        raise sheet.error(f"there are heights above the sea ({names}): leave above_ground out")
    dropped = above_sea if ground is not None and len(above_sea) < len(heights) else ()
    if ground is None:
        dropped = [column for column in heights if column.ground]
    return [column for column in known if column not in dropped]


def _incomplete(sheet: Sheet, known: list[_Column], usable: list[str]) -> InputError:
    for column in known:
        if column.factor is None and column.quantity not in usable:
            name, kind = column.quantity, _KINDS[column.quantity]
            spelled = ", ".join(f"{name}_{unit}" for unit in _SPELLED[kind].split(", "))
            more = (
                ", or give the units of a file that names none (units, --units ft,mph; those of"
                " OpenRocket's winds: format openrocket, --winds-format openrocket)"
            )
            return sheet.error(
                f"{shown(column.heading.text)} has no known unit; write {spelled}"
                f"{more * column.unnamed}"
            )
    return sheet.error(
        "the header must name a height and either speed and direction or east and north, with"
        f" their units; got {', '.join(usable) or 'none of them'}"
    )


def _values(sheet: Sheet, column: _Column, notes: list[str]) -> FloatArray:
    """The numbers of a column in SI units, NaN where one is missing."""
    assert column.factor is not None
    heading = column.heading
    values = sheet.text.numbers(heading.text, sheet.column(heading), sheet.line)
    missing = np.isin(values, _MISSING) & (column.quantity != "height")
    if np.any(missing):
        number = f"{values[np.argmax(missing)]:g}"
        notes.append(f"{number} in {called(heading.text)} taken for a missing value")
    return column.factor * np.where(missing, np.nan, values)


def _compare(sheet: Sheet, values: dict[str, FloatArray], notes: list[str]) -> None:
    """Take components that stand beside speed and direction away, if these say the same."""
    east, north = (values.pop(name) for name in _PAIRS[1])
    own = towards(values["speed"], values["direction"])
    off = np.hypot(east - own[0], north - own[1])
    good = ~(off > _ABSOLUTE + _RELATIVE * values["speed"])
    sheet.text.require(
        good,
        sheet.line,
        lambda i: (
            f"speed and direction give {own[0][i]:.4g} m/s towards the east and {own[1][i]:.4g}"
            f" towards the north, and the components are {east[i]:.4g} and {north[i]:.4g}; keep the"
            " right pair of columns"
        ),
    )
    largest = np.nanmax(off, initial=0.0)
    notes.append(
        f"speed and direction read; the components beside them differ by up to {largest:.2g} m/s"
    )
