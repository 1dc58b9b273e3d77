"""Readers of sounding files: one profile (`read_sounding`), or an archive (`read_soundings`).

The format of a file is recognised from its content (`READERS`). Files of one sounding get their
time [UTC] from the caller, a list of dates, their first level or their name, in this order.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from tvclin.base.errors import InputError, callable_for, flag, one_of, shown
from tvclin.base.errors import path as a_path
from tvclin.base.files import called, exists
from tvclin.base.sheet import MAX_COLUMNS, MAX_HEAD_LINE, Headings, sheet_in
from tvclin.base.text import Text, read_lines
from tvclin.winds.soundings import igra, rocketpy, synthetic, wind_table, wyoming
from tvclin.winds.soundings.archive import Collected, Soundings, Wanted, minutes
from tvclin.winds.soundings.igra import is_station, read_station
from tvclin.winds.soundings.levels import Found, profile_of
from tvclin.winds.soundings.profile import WindProfile
from tvclin.winds.soundings.wind_table import Reading

READERS = {
    "csv": wind_table.soundings_in,
    "openrocket": wind_table.soundings_in,
    "wyoming": wyoming.soundings_in,
    "igra": igra.soundings_in,
    "rocketpy": rocketpy.soundings_in,
    "synthetic": synthetic.soundings_in,
}
_TABLES = ("csv", "openrocket")
_SHOWN = 5
Source = str | PathLike[str]
Progress = Callable[[int, int], None]
_Reader = Callable[[Path], tuple[Text, list[Found]]]

_NAMED = re.compile(
    r"(?<!\d)((?:19|20)\d\d)[-_.]?(\d\d)[-_.]?(\d\d)(?:[-_T. ]?(\d\d)(?:\d\d)?)?(?!\d)"
)
"""A date, and an hour or noon, in the name of a file: 2024-02-15_12, 2024021512, 2024-02-15."""
_WRITTEN = re.compile(r"((?:19|20)\d\d-\d\d-\d\d)[ T](\d\d:\d\d)")
_LOOKED_AT = 50
"""Lines below a header, in which a time may stand."""
_NO_TIME = (
    "no date in it: name the file by it, as 2024-02-15_12.csv, list the dates (--dates), or take"
    " the files in their order (--in-order)"
)
_FIRST_DAY = np.datetime64("2000-01-01T00:00", "m")


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
        return wind_table.soundings_in(text, reading)
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
    if synthetic.HEADING in map(str.strip, text.lines):
        return "synthetic"
    if wind_table.head_line(text) is not None:
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


def read_soundings(
    source: Source | Iterable[Source],
    *,
    months: Iterable[int] | None = None,
    years: tuple[int, int] | None = None,
    station: str | None = None,
    times: Any = None,
    in_order: bool = False,
    dates: Source | None = None,
    utc_offset: float = 0.0,
    format: str | None = None,
    units: str | None = None,
    above_ground: float | None = None,
    progress: Progress | None = None,
) -> Soundings:
    """Return the soundings of a station.

    Parameters
    ----------
    source : str or path, or several of them
        Station files of IGRA, version 2, plain or in a .zip (``...-data.txt.zip``); files of one
        sounding in the formats of `read_sounding`; or folders of these.
    months : iterable of int, optional
        Only these, from 1 to 12.
    years : tuple of int, optional
        Only these, from the first to the last.
    station : str, optional
        Only this one, where there are several.
    times : array_like of datetime64, optional
        Times [UTC] of files of one sounding, one for each; without it the list or the file's first
        level says them, or the name of the file.
    in_order : bool
        Whether files of one sounding that have no time count by the order of their names, one a day
        from 2000-01-01 on.
    dates : str or path, optional
        A CSV file with the headings file and time: times [UTC] of files of one sounding, by their
        names.
    utc_offset : float
        Local time less UTC [h], by which months and years are counted.
    format, units, above_ground : optional
        Of files of one sounding, as of `read_sounding`.
    progress : callable, optional
        Is told how much is read, and how much there is: bytes of one station file, or files.

    Returns
    -------
    Soundings
        In the order of their times, each once. What cannot be used says why and where; what was
        left out is counted in the notes.

    Raises
    ------
    InputError
        For files that cannot be read, soundings of several stations, and if there is none at all.

    Examples
    --------
    >>> import tvclin as tv
    >>> tv.read_soundings("tests/soundings/igra.txt")
    Soundings(2 of USM00074794 from 2024-02-15 to 2024-02-16)
    """
    _check_rows(months=months, years=years)
    wanted = Wanted.of(months, years, station, utc_offset)
    if progress is not None:
        callable_for("progress", progress, "of how much is read and how much there is")
    listed = {} if dates is None else _listed(a_path("dates", dates))
    files = [file for file in _files(source) if dates is None or file != Path(dates)]
    given = None if times is None else minutes("times", times)
    if given is not None and given.shape != (len(files),):
        raise InputError(f"times must hold one for each of {len(files)} files; got {given.shape}")
    if flag("in_order", in_order) and given is not None:
        raise InputError("give times or in_order=True, not both")

    soundings = _reader(format, units, above_ground)
    found = Collected()
    for i, file in enumerate(files):
        day = _FIRST_DAY + np.timedelta64(i, "D") if in_order else None
        if is_station(file):
            if (units, above_ground) != (None, None):
                raise no_table(called(file), "igra")
            found.add(read_station(file, wanted, progress if len(files) == 1 else None))
        else:
            own = listed.get(file.name) if given is None else given[i]
            _add_single(found, file, soundings, wanted, own, day)
        if progress is not None and len(files) > 1:
            progress(i + 1, len(files))
    if not found.pieces and not found.stations and found.counted:
        remark, (count, where) = next(iter(found.counted.items()))
        raise InputError(f"source holds no sounding: {count} {remark} (the first: {where})")
    return found.soundings(wanted.utc_offset)


def _check_rows(**given: Any) -> None:
    """Raise `InputError` for an array without axes, which is no row of numbers."""
    for name, value in given.items():
        if isinstance(value, np.ndarray) and not value.ndim:
            raise InputError(f"{name} must be a row of whole numbers; got {shown(value)}")


def _listed(path: Path) -> dict[str, Any]:
    """Times of files by their names."""

    def fit(headings: Headings) -> float:
        return float([one.text for one in headings] == ["file", "time"])

    sheet = sheet_in(read_lines(path, "a list of dates"), fit, "names file,time")
    try:
        return {name: np.datetime64(time, "m") for name, time in sheet.cells}
    except ValueError:
        raise InputError(
            f"{called(path)} must have a name and a time in each line, as 7.csv,2024-02-15T12"
        ) from None


def _files(source: Any) -> list[Path]:
    """All files that are meant."""
    several = not isinstance(source, str | PathLike) and isinstance(source, Iterable)
    if isinstance(source, np.ndarray):  # one without axes is iterable, and cannot be iterated over
        several = source.ndim > 0
    asked = [a_path("source", one) for one in (source if several else [source])]
    files = []
    for one in asked:
        if not exists(one):
            raise InputError(f"{called(one)} does not exist; load it down from its archive first")
        inside = sorted(one.iterdir()) if one.is_dir() else [one]
        files += [file for file in inside if file.is_file() and not file.name.startswith(".")]
    if not files:
        raise InputError(f"source must name files or folders with files; got {shown(source)}")
    return files


def _reader(format: str | None, units: str | None, above_ground: float | None) -> _Reader:
    """Return what reads the text of a file and its soundings; arguments as of `read_sounding`."""
    if format is not None:
        one_of("format", format, READERS)
    Reading.of(units, above_ground, assumed=False)

    def read(file: Path) -> tuple[Text, list[Found]]:
        text = read_lines(file)
        return text, soundings_in(text, format, units, above_ground)

    return read


def _add_single(
    found: Collected,
    file: Path,
    soundings: _Reader,
    wanted: Wanted,
    given: Any,
    day: Any,
) -> None:
    """Add the soundings of a file of its own; a page that says there is none is no sounding."""
    name = called(file.name)
    try:
        text, those = soundings(file)
    except InputError as error:
        found.count("files without a sounding, left out", str(error))
        return
    for one in those:
        time = _time(text, one, file, given if len(those) == 1 else None)
        if time is None and day is not None and len(those) == 1:
            time = day
            found.count("files without a date, taken in their order as one a day")
        if time is None:
            found.count(f"files with {_NO_TIME}", name)
        elif wanted.takes(None, time):
            _add(found, one, time, name, wanted)


def _add(found: Collected, one: Found, time: Any, name: str, wanted: Wanted) -> None:
    when = np.array([time])
    try:
        profile = profile_of(one.levels())
    except InputError as error:
        found.pieces.append(([], [], [], np.array([0]), when))
        found.why.append(str(error))
        return
    number = re.search(r": (\w+) .*Observations", profile.source)
    if number is not None:
        if wanted.station not in (None, number[1]):
            return
        found.stations.setdefault(number[1], name)
    found.pieces.append(
        (profile.height, profile.east, profile.north, np.array([profile.height.size]), when)
    )
    found.why.append("")


def _time(text: Text, one: Found, file: Path, given: Any) -> Any:
    """The time [UTC]: the user's, that of the list, of the first level, or of the file's name."""
    if given is not None:
        return given
    if one.time:
        return np.datetime64(one.time.replace(" ", "T"), "m")
    header = wind_table.head_line(text)
    below = text.lines[header + 1 :][:_LOOKED_AT] if header is not None else ()
    for line in below:
        written = _WRITTEN.search(line)
        if written:
            return np.datetime64(f"{written[1]}T{written[2]}", "m")
    named = _NAMED.search(file.stem)
    try:
        return np.datetime64("{}-{}-{}T{}".format(*named.groups("12")), "m") if named else None
    except ValueError:
        return None
