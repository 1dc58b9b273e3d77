"""Range Reference Atmospheres: monthly statistics of the wind above a launch site.

Tables T1sssyy.txt as they come with Earth-GRAM, U.S. government: for each month rows of height,
mean and standard deviation of the eastward and northward wind with their correlation, and mean,
standard deviation and skewness of the wind speed.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, fields
from os import PathLike

import numpy as np

from tvclin.base.arrays import FloatArray, IntArray
from tvclin.base.errors import InputError, bearing, each, number
from tvclin.base.sheet import Text, read_lines
from tvclin.winds.soundings.profile import WindProfile

_TITLE = re.compile(r"\s*T A B L E\s+I\s+-\s*\d+\.\s+W I N D")
_MIN_SKEWNESS = 1e-3
"""Skewness below which the distribution counts as normal."""
_MAX_NUMBER = 1e6
"""Largest number of a table."""
_MIN_PERCENTILE = 1e-6
"""Distance of a percentile from 0 and from 100, beyond the resolution of any table."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class RangeReference:
    """Wind statistics of one month above a site, from many soundings; all arrays ``(n,)``.

    Attributes
    ----------
    site, month : str
        Names in the table.
    height : ndarray
        Geometric height above the sea [m], ascending.
    mean_east, sd_east, mean_north, sd_north : ndarray
        Mean and standard deviation of the wind towards east and north [m/s].
    correlation : ndarray
        Correlation of the two components.
    mean_speed, sd_speed, skew_speed : ndarray
        Mean [m/s], standard deviation [m/s] and skewness of the wind speed.
    count : ndarray
        Number of soundings.
    source : str
        Name of the file.
    """

    site: str
    month: str
    height: FloatArray
    mean_east: FloatArray
    sd_east: FloatArray
    correlation: FloatArray
    mean_north: FloatArray
    sd_north: FloatArray
    mean_speed: FloatArray
    sd_speed: FloatArray
    skew_speed: FloatArray
    count: FloatArray
    source: str = ""

    def __repr__(self) -> str:
        """Return site, month and number of levels, as text."""
        return f"RangeReference({self.site}, {self.month}, {self.height.size} levels)"

    def speed(self, percentile: float) -> FloatArray:
        """Return the wind speed [m/s] at a percentile of soundings, ``(n,)``.

        `percentile`: above 0 and below 100. Each height has its own Pearson type III distribution
        with the mean, the standard deviation and the skewness of the table, truncated at zero.
        """
        return np.maximum(
            _pearson_quantile(_probability(percentile), self.skew_speed) * self.sd_speed
            + self.mean_speed,
            0.0,
        )

    def component(self, percentile: float, azimuth: float) -> FloatArray:
        """Return the wind component towards an azimuth [rad] at a percentile [m/s], ``(n,)``.

        Each of n heights has its own bivariate normal distribution of the winds towards east and
        north, whose component is normal. `percentile`: above 0 and below 100.
        """
        from scipy.special import ndtri  # late: import time

        angle = bearing("azimuth", azimuth)
        s, c = np.sin(angle), np.cos(angle)
        covariance = self.correlation * self.sd_east * self.sd_north
        variance = (s * self.sd_east) ** 2 + (c * self.sd_north) ** 2 + 2 * s * c * covariance
        mean = s * self.mean_east + c * self.mean_north
        return np.asarray(
            mean + ndtri(_probability(percentile)) * np.sqrt(np.maximum(variance, 0.0))
        )

    def profile(self, percentile: float, azimuth: float) -> WindProfile:
        """Return the wind towards an azimuth [rad] with a percentile's `speed` at every height.

        It is an envelope of speeds, with the shear of a mean, and not a measured wind.
        """
        speed, angle = self.speed(percentile), bearing("azimuth", azimuth)
        return WindProfile(
            height=self.height,
            east=speed * np.sin(angle),
            north=speed * np.cos(angle),
            source=f"{self.source}: {self.site}, {self.month}, {percentile:g} %",
            notes=("each height by itself: an envelope, not a wind that was measured",),
        )


_FIELDS = tuple(f.name for f in fields(RangeReference) if f.name not in ("site", "month", "source"))
"""Columns of a table, in the order of its rows."""


def read_range_reference(path: str | PathLike[str]) -> tuple[RangeReference, ...]:
    """Return the months (and the year) of the wind table of a Range Reference Atmosphere.

    Parameters
    ----------
    path : str or path
        A file T1sssyy.txt.

    Raises
    ------
    InputError
        For a file that is no such table, and rows that are incomplete or out of order.
    """
    text = read_lines(path)
    titles = [i for i, line in enumerate(text.lines) if _TITLE.match(line)]
    if not titles:
        raise InputError(f"{text.source} is no Range Reference Atmosphere: no TABLE I of winds")
    ends = [*titles[1:], len(text.lines)]
    return tuple(_month(text, first, end) for first, end in zip(titles, ends, strict=True))


def worst_month(
    months: Sequence[RangeReference], percentile: float
) -> tuple[FloatArray, FloatArray]:
    """Return heights [m], and the largest speed [m/s] of all months at a percentile.

    Raises
    ------
    InputError
        For no month, and months whose heights differ.
    """
    months = each("months", months, RangeReference, "see read_range_reference")
    if not months or any(not np.array_equal(m.height, months[0].height) for m in months):
        raise InputError("months must be one or more, all with the same heights")
    return months[0].height, np.max([month.speed(percentile) for month in months], axis=0)


def _month(text: Text, first: int, end: int) -> RangeReference:
    """Return the statistics of a month from the lines of a table below its title.

    `first`, `end`: indices of the line of the title, and of the line after the last row.
    """
    head = "\n".join(text.lines[first + 1 : first + 5])  # month, station, names and units
    month, station = re.match(r"\s*(\w+)\s*\n", head), re.search(r"Station\s*=\s*(.*)", head)
    if not month or not station or not re.search(r"\bKM\b", head):
        raise text.error(
            first + 1, "a month, a station and a line of units in KM and M/S must follow"
        )
    lines = [i for i in range(first + 5, end) if text.lines[i].strip()]
    line = np.array(lines, dtype=np.int64) + 1
    rows = [text.lines[i].split() for i in lines]
    full = np.array([len(row) == len(_FIELDS) for row in rows], dtype=bool)
    text.require(full, line, lambda i: f"a row has {len(_FIELDS)} numbers; got {len(rows[i])}")
    if len(rows) < 2:
        raise text.error(first + 1, "two or more rows must follow")
    table = {
        name: text.numbers(name, [row[i] for row in rows], line) for i, name in enumerate(_FIELDS)
    }
    _check_rows(text, line, table)
    table["height"] = 1e3 * table["height"]
    site = " ".join(station[1].split())
    return RangeReference(site=site, month=month[1], source=text.source, **table)


def _check_rows(text: Text, line: IntArray, table: dict[str, FloatArray]) -> None:
    """Raise `InputError` about the first row with missing or impossible numbers.

    `text`: the file. `line`: line of each of n rows. `table`: columns by name, ``(n,)`` each.
    """
    complete = ~np.isnan(np.sum(list(table.values()), axis=0))
    text.require(complete, line, lambda _: "a number is missing")
    bounded = np.max(np.abs(list(table.values())), axis=0) <= _MAX_NUMBER
    text.require(bounded, line, lambda _: f"a number is beyond {_MAX_NUMBER:g}")
    spread = np.min([table[name] for name in _FIELDS if name.startswith("sd")], axis=0)
    text.require(spread >= 0.0, line, lambda _: "a standard deviation must not be negative")
    within = np.abs(table["correlation"]) <= 1.0
    text.require(within, line, lambda _: "the correlation must be between -1 and 1")
    ascending = np.append(True, np.diff(table["height"]) > 0.0)
    text.require(ascending, line, lambda _: "heights must ascend")


def _probability(percentile: float) -> float:
    """Return a percentile as a probability; `InputError` near 0 and 100."""
    value = number("percentile", percentile)
    if not _MIN_PERCENTILE <= value <= 100.0 - _MIN_PERCENTILE:
        raise InputError(
            f"percentile must be above 0 and below 100, by {_MIN_PERCENTILE:g} or more; got"
            f" {value:g}"
        )
    return value / 100


def _pearson_quantile(probability: float, skew: FloatArray) -> FloatArray:
    """Return quantiles of Pearson type III distributions of zero mean and unit deviation, ``(n,)``.

    `probability`: of the quantiles, in (0, 1). `skew`: skewness of each distribution, ``(n,)``.
    """
    from scipy.special import gammaincinv, ndtri  # late: import time

    # a gamma distribution of the shape 4/skew^2, standardised, and mirrored for a negative skewness
    symmetric = np.abs(skew) < _MIN_SKEWNESS
    size = np.where(symmetric, 1.0, np.abs(skew))
    shape = 4.0 / size**2
    upper_probability = np.where(skew > 0.0, probability, 1.0 - probability)
    gamma = np.sign(skew) * (gammaincinv(shape, upper_probability) - shape) / np.sqrt(shape)
    return np.where(symmetric, ndtri(probability), gamma)
