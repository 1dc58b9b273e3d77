"""Which format a file has, which of its soundings is meant, and the profile of that."""

import re
from os import PathLike

from tvclin.base.errors import InputError, one_of, shown
from tvclin.base.sheet import MAX_COLUMNS, MAX_HEAD_LINE
from tvclin.base.text import Text, read_lines
from tvclin.winds.soundings import columns, igra, rocketpy, synthetic_file, wyoming
from tvclin.winds.soundings.columns import Reading
from tvclin.winds.soundings.levels import Found, profile_of
from tvclin.winds.soundings.profile import WindProfile

READERS = {
    "csv": columns.soundings_in,
    "openrocket": columns.soundings_in,
    "wyoming": wyoming.soundings_in,
    "igra": igra.soundings_in,
    "rocketpy": rocketpy.soundings_in,
    "synthetic": synthetic_file.soundings_in,
}
_TABLES = ("csv", "openrocket")
_SHOWN = 5


def read_sounding(
    path: str | PathLike[str],
    format: str | None = None,
    *,
    time: str | None = None,
    units: str | None = None,
    above_ground: float | None = None,
) -> WindProfile:
    """Return the wind profile in a file.

    Parameters
    ----------
    path : str or path
        The file.
    format : {"csv", "openrocket", "wyoming", "igra", "rocketpy", "synthetic"}, optional
        Recognised from the content where it is not named. "csv" has a header whose names carry
        their units (height_m, speed_kt, direction_deg; or east_m_per_s, north_m_per_s), as the
        CSV of the University of Wyoming does. "openrocket" has no units in its header: m above the
        sea, m/s and degrees are assumed, with a note. "wyoming" is the text list, "igra" the
        station file of NOAA's IGRA version 2, "rocketpy" Python or JSON with the lists wind_u and
        wind_v, "synthetic" TOML with a table [synthetic] for `synthetic_profile`, and [[gust]] for
        `add_gust`.
    time : str, optional
        Which sounding of a file that holds several, as "2024-01-15 12" [UTC]; the first where it
        is not given, with a note.
    units : str, optional
        Units of a table that names none, as "ft,mph": those of heights, speeds and directions.
    above_ground : float, optional
        Elevation of the site above the sea [m], from -450 to 9000, for a table of heights above the
        ground.

    Returns
    -------
    WindProfile
        Directions are taken as where the wind comes from; geopotential heights become geometric.

    Raises
    ------
    InputError
        For a file that cannot be read or is in no known format, a unit that is missing or
        unknown, numbers out of range, and heights out of order; the message names the line.
    """
    text = read_lines(path)
    found = soundings_in(text, format, units, above_ground)
    return profile_of(_chosen(text, found, time).levels())


def soundings_in(
    text: Text, format: str | None, units: str | None, above_ground: float | None
) -> list[Found]:
    """Return the soundings of a text; the other arguments as of `read_sounding`."""
    name = recognised(text) if format is None else one_of("format", format, READERS)
    if name in _TABLES:
        reading = Reading.of(units, above_ground, assumed=name == "openrocket")
        return columns.soundings_in(text, reading)
    if units is not None or above_ground is not None:
        raise no_table(text.source, name)
    return READERS[name](text)


def no_table(source: str, name: str) -> InputError:
    """Return the error about units or a site of a file whose format says both itself."""
    return InputError(
        "units and above_ground (--units, --above-ground) are for tables of the formats"
        f" {' and '.join(_TABLES)}; {source} is of the format {name}"
    )


def recognised(text: Text) -> str:
    """Return the format of a file by its content; `InputError` for none that is known."""
    content = "\n".join(text.lines[:200])
    if re.search(r"^#\w{11} \d{4} \d\d \d\d ", content, flags=re.MULTILINE):
        return "igra"
    if re.search(r"W I N D {2,}S T A T", content):
        raise InputError(
            f"{text.source} holds monthly statistics, not one wind; read it with"
            " read_range_reference"
        )
    if re.search(r"\bPRES\s+HGHT\b", content):
        return "wyoming"
    if re.search(r"\bwind_[uv][\"']?\s*[=:]", "\n".join(text.lines)):
        return "rocketpy"
    if synthetic_file.HEADING in map(str.strip, text.lines):
        return "synthetic"
    if columns.head_line(text) is not None:
        return "csv"
    raise InputError(
        f"{text.source} is in no format that is recognised; a table needs a header such as"
        f" height_m,speed_m_per_s,direction_deg in its first {MAX_HEAD_LINE} lines, with at most"
        f" {MAX_COLUMNS} columns (or name the format,"
        f" --winds-format in a shell: {', '.join(READERS)})"
    )


def _chosen(text: Text, found: list[Found], time: str | None) -> Found:
    known = [one.time for one in found if one.time]
    if time is None:
        note = f"the first of {len(found)} soundings in the file; choose another by its time"
        return found[0].noted(note) if len(found) > 1 else found[0]
    for one in found:
        if isinstance(time, str) and one.time == time:
            return one
    there = ", ".join(repr(name) for name in known[:_SHOWN]) or "none"
    more = f" and {len(known) - _SHOWN} more" if len(known) > _SHOWN else ""
    raise InputError(f"{text.source} has no sounding of time {shown(time)}; it has {there}{more}")
