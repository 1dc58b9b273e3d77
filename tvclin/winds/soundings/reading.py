"""Reading of sounding files: the table [sounding], which holds for all soundings of a case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from tvclin.base.errors import InputError, positive, whole_number, within
from tvclin.base.fields import checked, count, file_table, quantity, text
from tvclin.winds.soundings.profile import WindProfile


def _month(name: str, value: object) -> int:
    """Return the number of a month; `InputError` otherwise."""
    return int(within(name, whole_number(name, value), 1, 12))


@dataclass(frozen=True, kw_only=True)
class SoundingReading:
    """Format, units and site of sounding files, the window that counts, and a mean wind.

    Attributes
    ----------
    format : str, optional
        Format of the files: csv, openrocket, wyoming, igra, rocketpy or synthetic; see
        `read_sounding`.
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
        "time", None, positive, shown="all of it over a flight, 20 at one time"
    )
    bias: str | None = text(None)
    bias_month: int | None = count(None, _month, shown="all")

    def __post_init__(self) -> None:
        checked(self)
        if self.bias_month is not None and self.bias is None:
            raise InputError("bias_month needs bias, the file of a station")

    @classmethod
    def of(cls, document: Mapping[str, Any], folder: Path) -> SoundingReading:
        """Return the reading of the table [sounding] of a document; the bias is in its folder."""
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
        """Return the sounding of a file; same exceptions as `read_sounding`."""
        from tvclin.winds.soundings.sounding_files import read_sounding

        return read_sounding(file, time=self.time, **self.table)

    @cached_property
    def mean_wind(self) -> WindProfile | None:
        """The mean wind for which the flight path is biased."""
        from tvclin.winds.soundings.igra import is_station
        from tvclin.winds.soundings.sounding_files import read_sounding, read_soundings

        if self.bias is None:
            return None
        file = Path(self.bias)
        if is_station(file):
            months = None if self.bias_month is None else [self.bias_month]
            return read_soundings(file, months=months).mean()
        if self.bias_month is not None:
            raise InputError("bias_month needs a bias that is the file of a station")
        return read_sounding(file)


READING_TABLE = file_table("[sounding]", SoundingReading)
NO_READING = SoundingReading()
"""Reading without any key given."""
