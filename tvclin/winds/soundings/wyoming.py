"""Text lists of the University of Wyoming, as plain text or as a saved page."""

from __future__ import annotations

import re

import numpy as np

from tvclin.base.sheet import Text
from tvclin.base.units import UNITS
from tvclin.winds.soundings.levels import Levels, SoundingEntry

_MONTHS = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"]
_SPEEDS = {"SKNT": UNITS["speed"]["kt"], "SPED": 1.0}
_UNIT_WORDS = {"SKNT": ("knot", "knots", "kt", "kts"), "SPED": ("m/s",)}
_TITLE = re.compile(
    r"(.*Observations.* at (?P<hour>\d\d) ?(?:Z|UTC)"
    r" (?P<day>\d\d) (?P<month>\w{3}) (?P<year>\d{4}))"
)
_MAX_TITLE_WIDTH = 300


def soundings_in(text: Text) -> list[SoundingEntry]:
    """Return the soundings of a text list, one below each header PRES HGHT ..."""
    headers = [i for i, line in enumerate(text.lines) if re.search(r"\bPRES\s+HGHT\b", line)]
    if not headers:
        raise text.error(1, "a Wyoming list needs a header PRES HGHT ... DRCT and SKNT or SPED")
    return [_list_entry(text, header) for header in headers]


def _list_entry(text: Text, header: int) -> SoundingEntry:
    """Return the sounding below a header of a text list, with title and time of the lines above.

    `header`: index of the line of the header.
    """
    title, time = "", ""
    for line in text.lines[max(header - 6, 0) : header]:  # the title is at most six lines above
        match = _TITLE.match(re.sub(r"<[^>]*>", "", line[:_MAX_TITLE_WIDTH]).strip())
        if match and match["month"] in _MONTHS:
            title, month = match[1], _MONTHS.index(match["month"]) + 1
            time = f"{match['year']}-{month:02d}-{match['day']} {match['hour']}"
    return SoundingEntry(lambda: _read(text, header, title), time=time)


def _read(text: Text, header: int, title: str) -> Levels:
    """Return the levels below a header of a text list; errors name the line.

    `header`: index of the line of the header. `title`: station and time.
    """
    if re.search(r"\S\s{2,}\S", text.lines[header]) is None:
        raise text.error(
            header + 1,
            "the blanks between the columns of this Wyoming list are collapsed to one, and empty"
            " cells are lost with them; save the page again as it stands, or as CSV",
        )
    fields = _fields(text.lines[header])
    speeds = [name for name in _SPEEDS if name in fields]
    if len(speeds) != 1 or not {"HGHT", "DRCT"} <= fields.keys():
        raise text.error(
            header + 1,
            "the header must name HGHT, DRCT and either SKNT (knots) or SPED (m/s), for the unit",
        )
    rows = []  # line numbers of the levels, up to a blank line or a rule
    for i in range(_after_units(text, header, speeds[0]), len(text.lines)):
        content = text.lines[i].strip()
        if not content or content.startswith(("<", "Station", "-----")):
            break
        rows.append(i + 1)
    line = np.array(rows, dtype=np.int64)
    height, direction, speed = (
        text.numbers(name, [text.lines[i - 1][fields[name]] for i in line], line)
        for name in ("HGHT", "DRCT", speeds[0])
    )
    return Levels.from_direction(
        text=text,
        line=line,
        speed=_SPEEDS[speeds[0]] * speed,
        direction=np.radians(direction),
        height=height,
        title=title,
        geopotential=True,
    )


def _fields(header: str) -> dict[str, slice]:
    """Return the columns of each field by name: from the end of the name before to its own end.

    `header`: line of the names, which stand flush right.
    """
    names = list(re.finditer(r"\S+", header))
    starts = [0, *(name.end() for name in names)]
    return {name[0]: slice(start, name.end()) for start, name in zip(starts, names, strict=False)}


def _after_units(text: Text, header: int, speed: str) -> int:
    """Return the index of the line of the first level, below the line of units and the rule.

    `header`: index of the line of names. `speed`: name of the speed, SKNT [kt] or SPED [m/s], whose
    unit is checked.
    """
    i = header + 1
    while i < len(text.lines) and re.match(r"\s*(-{5,}|hPa\b)", text.lines[i]):
        words = text.lines[i].split()
        if words[0] == "hPa" and not set(_UNIT_WORDS[speed]) & set(words):
            raise text.error(
                i + 1, f"the unit of {speed} must be {_UNIT_WORDS[speed][0]}; got {' '.join(words)}"
            )
        i += 1
    return i
