"""Readers of sounding files: one profile (`read_sounding`), or an archive (`read_soundings`).

The format of a file is recognised from its content (`READERS`). Files of one sounding get their
time [UTC] from the caller, a list of dates, their first level or their name, in this order.

`SoundingReading` is the table [sounding], which holds for all soundings of a case.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from tvclin.base import errors
from tvclin.base.fields import checked, count, file_table, quantity, text
from tvclin.base.files import called, check_not_output, exists
from tvclin.base.sheet import MAX_COLUMNS, MAX_HEAD_LINE, Headings, Text, read_lines, sheet_in
from tvclin.winds.soundings import igra, rocketpy, synthetic, wind_table, wyoming
from tvclin.winds.soundings.archive import SoundingCollection, SoundingFilter, Soundings, to_minutes
from tvclin.winds.soundings.igra import is_station, read_station
from tvclin.winds.soundings.levels import SoundingEntry, profile_of
from tvclin.winds.soundings.profile import RANGES, WindProfile
from tvclin.winds.soundings.wind_table import TableOptions

READERS = {
    "csv": wind_table.soundings_in,
    "openrocket": wind_table.soundings_in,
    "wyoming": wyoming.soundings_in,
    "igra": igra.soundings_in,
    "rocketpy": rocketpy.soundings_in,
    "synthetic": synthetic.soundings_in,
}
_TABLES = ("csv", "openrocket")
_MAX_LISTED_TIMES = 5
"""Largest number of times of soundings that a message lists."""
Source = str | PathLike[str]
Progress = Callable[[int, int], None]

_DATE_IN_NAME = re.compile(
    r"(?<!\d)((?:19|20)\d\d)[-_.]?(\d\d)[-_.]?(\d\d)(?:[-_T. ]?(\d\d)(?:\d\d)?)?(?!\d)"
)
"""Date, and hour or noon, in the name of a file: 2024-02-15_12, 2024021512, 2024-02-15."""
_TIME_IN_LINE = re.compile(r"((?:19|20)\d\d-\d\d-\d\d)[ T](\d\d:\d\d)")
_MAX_TIME_LINES = 50
"""Lines below a header that are searched for a time."""
_NO_TIME = (
    "no date in it: name the file by it, as 2024-02-15_12.csv, list the dates in a file (dates of"
    " [availability]), or take the files in their order (--set availability.in_order true)"
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
    """Return the wind profile of a sounding file.

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
        Units of a table that names none, as "ft,mph": of heights, speeds and directions.
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
    entries = soundings_in(text, format, units, above_ground)
    matches = entries
    if time is not None:
        matches = [entry for entry in entries if isinstance(time, str) and entry.time == time]
    if not matches:
        times = [entry.time for entry in entries if entry.time]
        listed = ", ".join(map(repr, times[:_MAX_LISTED_TIMES])) or "none"
        more = len(times) - _MAX_LISTED_TIMES
        raise errors.InputError(
            f"{text.source} has no sounding of time {errors.shown(time)}; it has {listed}"
            f"{f' and {more} more' if more > 0 else ''}"
        )
    levels = matches[0].levels()
    if time is None and len(entries) > 1:
        note = f"the first of {len(entries)} soundings in the file; choose another by its time"
        levels = replace(levels, notes=(*levels.notes, note))
    return profile_of(levels)


def soundings_in(
    text: Text, format: str | None, units: str | None, above_ground: float | None
) -> list[SoundingEntry]:
    """Return the soundings in a text.

    `format`: name of its format, or None to recognise it. `units`: units of a table that names
    none, as "ft,mph", or None. `above_ground`: elevation of the site [m], for a table of heights
    above the ground, or None. `InputError` for an unknown format, and for units or an elevation
    with a format other than a table.
    """
    name = recognised_format(text) if format is None else errors.one_of("format", format, READERS)
    if name in _TABLES:
        reading = TableOptions.of(units, above_ground, openrocket_units=name == "openrocket")
        return wind_table.soundings_in(text, reading)
    if units is not None or above_ground is not None:
        raise not_a_table_error(text.source, name)
    return READERS[name](text)


def not_a_table_error(source: str, name: str) -> errors.InputError:
    """Return the error about units or a site elevation for a format that has its own.

    `source`: name of the file. `name`: name of the format.
    """
    return errors.InputError(
        "units and above_ground in [sounding] are for tables of the formats"
        f" {' and '.join(_TABLES)}; {source} is of the format {name}"
    )


def recognised_format(text: Text) -> str:
    """Return the name of the format of a text by its content; `InputError` for an unknown one."""
    content = "\n".join(text.lines[:200])
    if re.search(r"^#\w{11} \d{4} \d\d \d\d ", content, flags=re.MULTILINE):
        return "igra"
    if re.search(r"W I N D {2,}S T A T", content):
        raise errors.InputError(
            f"{text.source} holds monthly statistics, not one wind; read it with"
            " read_range_reference"
        )
    if re.search(r"\bPRES\s+HGHT\b", content):
        return "wyoming"
    if re.search(r"\bwind_[uv][\"']?\s*[=:]", "\n".join(text.lines)):
        return "rocketpy"
    if synthetic.HEADING in map(str.strip, text.lines):
        return "synthetic"
    if wind_table.header_index(text) is not None:
        return "csv"
    raise errors.InputError(
        f"{text.source} is in no format that is recognised; a table needs a header such as"
        f" height_m,speed_m_per_s,direction_deg in its first {MAX_HEAD_LINE} lines, with at most"
        f" {MAX_COLUMNS} columns (or name the format,"
        f" --set sounding.format in a shell: {', '.join(READERS)})"
    )


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
        For files of one sounding: their format, units of tables that name none, as "ft,mph", and
        elevation of the site [m] for heights above the ground.
    progress : callable, optional
        Called with the amount read and the total: bytes of one station file, or files.

    Returns
    -------
    Soundings
        In the order of their times, without repetitions. An unusable sounding has its reason and
        line; omissions are counted in the notes.

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
    sounding_filter = SoundingFilter.of(months, years, station, utc_offset)
    if progress is not None:
        errors.callable_for("progress", progress, "of how much is read and how much there is")
    times_by_name = {} if dates is None else _times_by_name(errors.path("dates", dates))
    files = [file for file in _files(source) if dates is None or file != Path(dates)]
    checked_times = None if times is None else to_minutes(times)
    if checked_times is not None and checked_times.shape != (len(files),):
        raise errors.InputError(
            f"times must hold one for each of {len(files)} files; got {checked_times.shape}"
        )
    if errors.flag("in_order", in_order) and checked_times is not None:
        raise errors.InputError("give times or in_order=True, not both")

    if format is not None:
        errors.one_of("format", format, READERS)
    TableOptions.of(units, above_ground, openrocket_units=False)  # refuses unknown units
    collection = SoundingCollection()
    for i, file in enumerate(files):
        day = _FIRST_DAY + np.timedelta64(i, "D") if in_order else None
        if is_station(file):
            if (units, above_ground) != (None, None):
                raise not_a_table_error(called(file), "igra")
            collection.add(
                read_station(file, sounding_filter, progress if len(files) == 1 else None)
            )
        else:
            time = times_by_name.get(file.name) if checked_times is None else checked_times[i]
            reading = (format, units, above_ground)
            _add_single(collection, file, reading, sounding_filter, time, day)
        if progress is not None and len(files) > 1:
            progress(i + 1, len(files))
    if not collection.pieces and not collection.stations and collection.counted:
        remark, (count, where) = next(iter(collection.counted.items()))
        remark = remark.replace("files", "file", 1) if count == 1 else remark
        sources = [source] if isinstance(source, str | PathLike) else list(source)
        name = called(Path(sources[0]).name) if len(sources) == 1 else "source"
        raise errors.InputError(f"{name} holds no sounding: {count} {remark} (the first: {where})")
    return collection.soundings(sounding_filter.utc_offset)


def _times_by_name(path: Path) -> dict[str, Any]:
    """Return times [UTC] by the names of files, from the list of dates at a path."""

    def fit(headings: Headings) -> float:
        """Return 1 for a line of the headings file and time, else 0."""
        return float([heading.text for heading in headings] == ["file", "time"])

    sheet = sheet_in(read_lines(path, "a list of dates"), fit, "names file,time")
    try:
        return {name: np.datetime64(time, "m") for name, time in sheet.cells}
    except ValueError:
        raise errors.InputError(
            f"{called(path)} must have a name and a time in each line, as 7.csv,2024-02-15T12"
        ) from None


def _files(source: Any) -> list[Path]:
    """Return all files of a source: files themselves, and those inside folders."""
    several = not isinstance(source, str | PathLike) and isinstance(source, Iterable)
    if isinstance(source, np.ndarray):  # without axes it is iterable, but iteration fails
        several = source.ndim > 0
    paths = [errors.path("source", item) for item in (source if several else [source])]
    files = []
    for item in paths:
        if not exists(item):
            raise errors.InputError(
                f"{called(item)} does not exist; download it from its archive first"
            )
        inside = sorted(item.iterdir()) if item.is_dir() else [item]  # not those of its folders
        files += [file for file in inside if file.is_file() and not file.name.startswith(".")]
    for file in files:
        check_not_output(file)
    if not files:
        raise errors.InputError(
            f"no file of soundings in {', '.join(map(called, paths)) or 'an empty list'}"
        )
    return files


def _add_single(
    collection: SoundingCollection,
    file: Path,
    reading: tuple[str | None, str | None, float | None],
    sounding_filter: SoundingFilter,
    listed_time: Any,
    default_time: Any,
) -> None:
    """Add the soundings of a file to the collection, or the reasons why they cannot be used.

    A file without a sounding is counted. A sounding of another station than the filter's is left
    out; its station is known where the source names it, as pages of the University of Wyoming do.
    `reading`: format, units and elevation of the site [m], each perhaps None. `sounding_filter`:
    which times and stations are read. `listed_time`, `default_time`: time [UTC] that counts for a
    single sounding, and for one that is without any time; or None.
    """
    name = called(file.name)
    try:
        text = read_lines(file)
        entries = soundings_in(text, *reading)
    except errors.InputError as error:
        collection.count("files without a sounding, left out", str(error))
        return
    for entry in entries:
        time = _entry_time(text, entry, file, listed_time if len(entries) == 1 else None)
        if time is None and default_time is not None and len(entries) == 1:
            time = default_time
            collection.count("files without a date, taken in their order as one a day")
        if time is None:
            collection.count(f"files with {_NO_TIME}", name)
            continue
        if not sounding_filter.accepts(station=None, time=time):  # a file of a single station
            continue
        reason, levels = "", [np.empty(0)] * len(RANGES)  # heights, winds east and north
        try:
            profile = profile_of(entry.levels())
        except errors.InputError as error:
            reason = str(error)
        else:
            number = re.search(r": (\w+) .*Observations", profile.source)  # of the station
            if number is not None:
                if sounding_filter.station not in (None, number[1]):
                    continue
                collection.stations.setdefault(number[1], name)
            levels = [profile.height, profile.east, profile.north]
        collection.pieces.append((*levels, np.array([levels[0].size]), np.array([time])))
        collection.why.append(reason)


def _entry_time(text: Text, entry: SoundingEntry, file: Path, listed_time: Any) -> Any:
    """Return the time [UTC] of a sounding, or None where it has none.

    `listed_time`: the time from a list, or None; then the entry, the first lines of the text, or
    the name of the file have it.
    """
    if listed_time is not None:
        return listed_time
    if entry.time:
        return np.datetime64(entry.time.replace(" ", "T"), "m")
    header = wind_table.header_index(text)
    lines = text.lines[header + 1 :][:_MAX_TIME_LINES] if header is not None else ()
    for line in lines:
        match = _TIME_IN_LINE.search(line)
        if match:
            return np.datetime64(f"{match[1]}T{match[2]}", "m")
    date = _DATE_IN_NAME.search(file.stem)
    try:  # noon where the name has no hour
        return np.datetime64("{}-{}-{}T{}".format(*date.groups("12")), "m") if date else None
    except ValueError:
        return None


def _month(name: str, value: object) -> int:
    """Return the number of a month, `value`; `InputError` unless it is from 1 to 12.

    `name`: name of the argument in the error.
    """
    return int(errors.within(name, errors.whole_number(name, value), 1, 12))


@dataclass(frozen=True, kw_only=True)
class SoundingReading:
    """Format, units and site of sounding files, the window that counts, and a mean wind.

    Attributes
    ----------
    format : str, optional
        Format of the files: csv (names of columns carry units, height_m), openrocket (a CSV
        without), wyoming (text list of its university), igra (station file of NOAA), rocketpy, or
        synthetic (TOML). `read_sounding` has more on each.
    time : str, optional
        Time of the sounding in a file of several, as 2024-02-15 12 (UTC).
    units : str, optional
        Units of a table that names none, as ft,mph: of heights, speeds and directions.
    above_ground : float, optional
        Elevation of the site above the sea [m], of a table of heights above the ground.
    window : float, optional
        Length [s] of the interval of a sounding that counts, about each flight time.
    bias : str, optional
        File of the mean wind for which the flight path is biased: a sounding, as yesterday's, or a
        station file, whose mean it is.
    bias_month : int, optional
        Month of the mean of that station file, from 1 to 12.

    Raises
    ------
    InputError
        For numbers out of range, and a month without the file of a station.
    """

    format: str | None = text(None, shown="by its content")
    time: str | None = text(None, shown="the first")
    units: str | None = text(None, shown="m,m/s,deg with the format openrocket")
    above_ground: float | None = quantity("length", None)
    window: float | None = quantity(
        "time", None, errors.positive, shown="all of it over a flight, 20 at one time"
    )
    bias: str | None = text(None)
    bias_month: int | None = count(None, _month, shown="all")

    def __post_init__(self) -> None:
        """Check the fields; `InputError` as the class says."""
        checked(self)
        if self.bias_month is not None and self.bias is None:
            raise errors.InputError("bias_month needs bias, the file of a station")

    @classmethod
    def of(cls, document: Mapping[str, Any], folder: Path) -> SoundingReading:
        """Return the options for sounding files of a table [sounding]; without one the defaults.

        `document`: a study file as nested tables. `folder`: its folder, relative to which the table
        names the file of the bias, the mean wind for which the flight path is biased.
        """
        reading = READING_TABLE.made(document, lambda table: cls(**READING_TABLE.read(table)))
        if reading is None or reading.bias is None:
            return reading or cls()
        return replace(reading, bias=str(folder / reading.bias))

    @property
    def table(self) -> dict[str, Any]:
        """Arguments of `read_soundings`: format, units and site."""
        names = ("format", "units", "above_ground")
        return {name: getattr(self, name) for name in names}

    def profile(self, file: Path) -> WindProfile:
        """Return the sounding of a `file`; `InputError` where none can be read."""
        return read_sounding(file, time=self.time, **self.table)

    @cached_property
    def mean_wind(self) -> WindProfile | None:
        """Mean wind for which the flight path is biased, from the file `bias`; None without one.

        Of a station file it is the mean of all soundings, or of those of `bias_month`; another file
        is a sounding itself. `InputError` for a file that cannot be read, and for a month with a
        file that is no station file.
        """
        if self.bias is None:
            return None
        file = Path(self.bias)
        if is_station(file):
            months = None if self.bias_month is None else [self.bias_month]
            return read_soundings(file, months=months).mean()
        if self.bias_month is not None:
            raise errors.InputError("bias_month needs a bias that is the file of a station")
        return read_sounding(file)


READING_TABLE = file_table("[sounding]", SoundingReading)
NO_READING = SoundingReading()
"""Reading without any key given."""
