"""Files of many soundings: station files of IGRA, and folders of single ones."""

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
from tvclin.base.sheet import Headings, sheet_in
from tvclin.base.text import Text, read_lines
from tvclin.winds.soundings import columns
from tvclin.winds.soundings.archive import Soundings, minutes
from tvclin.winds.soundings.columns import Reading
from tvclin.winds.soundings.igra_archive import is_station, read_station
from tvclin.winds.soundings.levels import Found, profile_of
from tvclin.winds.soundings.many import Collected, Wanted
from tvclin.winds.soundings.read import READERS, no_table, soundings_in

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
    header = columns.head_line(text)
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
