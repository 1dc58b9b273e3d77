"""Levels of one sounding as a file gives them, their checks, and the profile of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray, IntArray
from tvclin.base.errors import InputError
from tvclin.base.lines import plural
from tvclin.base.sheet import Text
from tvclin.winds.soundings.profile import WindProfile

EARTH_RADIUS = 6_356_766.0
"""Earth radius [m] of geopotential heights in the U.S. Standard Atmosphere 1976."""
MIN_HEIGHT, MAX_HEIGHT = -1e3, 1e5
"""Heights [m] between which a sounding has levels."""
MAX_WIND_SPEED = 130.0
"""Largest wind speed [m/s] of a sounding; some archives hold winds ten times too large."""
_RELATIVE_ROUNDING = 1e-9
"""Relative rounding of directions and speeds from components or other units."""
_EMPTY = "; leave the cell empty where a value is missing"
_OR_EMPTY = ", or leave the cell empty where a value is missing"
Faults = list[tuple[BoolArray, Callable[[int], str]]]


@dataclass(frozen=True, eq=False, kw_only=True)
class Levels:
    """Levels of one sounding, as arrays ``(n,)`` with NaN where nothing was measured.

    `line`: line of each level. `height`: [m]. `east`, `north`: wind towards east and north [m/s].
    `title`: station and time, as far as the file gives them. `geopotential`: whether heights are
    geopotential. `balloon`: whether the levels are in the order of a balloon's ascent, which may
    descend for a while. `notes`: remarks of the reader.
    """

    text: Text
    line: IntArray
    height: FloatArray
    east: FloatArray
    north: FloatArray
    title: str = ""
    geopotential: bool = False
    balloon: bool = False
    notes: tuple[str, ...] = ()

    @classmethod
    def from_direction(
        cls, *, text: Text, line: IntArray, speed: FloatArray, direction: FloatArray, **more: Any
    ) -> Levels:
        """Return levels by speed [m/s] and the direction from which the wind blows [rad].

        `line`: line of each level in `text`. `more`: the other fields. `InputError` for values that
        are no wind.
        """
        for invalid, message in level_faults(speed, direction=direction):
            text.require(~invalid, line, message)
        east, north = wind_components(speed, direction)
        return cls(text=text, line=line, east=east, north=north, **more)


class SoundingEntry(NamedTuple):
    """Sounding in a file: a function that reads its levels, and its time.

    `time`: in UTC, as "2024-01-15 12"; empty where the file has none.
    """

    levels: Callable[[], Levels]
    time: str = ""


def level_faults(
    speed: FloatArray, *, height: FloatArray | None = None, direction: FloatArray | None = None
) -> Faults:
    """Return the possible faults of levels: which have it, ``(n,)``, and what a message says.

    The message of a fault is a function of the index of a level. `speed`, `height`, `direction`:
    [m/s], [m] and [rad] of the levels, ``(n,)``; NaN where nothing was measured.
    """
    unknown = np.full(speed.shape, np.nan)
    z = unknown if height is None else height
    degrees = unknown if direction is None else np.degrees(direction)
    return [
        (speed < 0.0, lambda i: f"speed must not be negative; got {speed[i]:.6g} m/s{_EMPTY}"),
        (
            speed > MAX_WIND_SPEED * (1.0 + _RELATIVE_ROUNDING),
            lambda i: (
                f"no wind blows with {speed[i]:.6g} m/s, above {MAX_WIND_SPEED:g}; check its"
                f" unit{_OR_EMPTY}"
            ),
        ),
        (
            (degrees < -_RELATIVE_ROUNDING) | (degrees > 360.0 + _RELATIVE_ROUNDING),
            lambda i: f"direction must be between 0 and 360 degrees; got {degrees[i]:.6g}{_EMPTY}",
        ),
        (
            (z < MIN_HEIGHT) | (z > MAX_HEIGHT),
            lambda i: (
                f"height must be between {MIN_HEIGHT:g} and {MAX_HEIGHT:g} m; got {z[i]:.6g} m, so"
                f" check its unit{_OR_EMPTY}"
            ),
        ),
    ]


def wind_components(speed: FloatArray, direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the wind towards east and north [m/s] by its speed and direction.

    The direction [rad] is that from which the wind blows, clockwise from north; it may be NaN in a
    calm.
    """
    angle = np.where(speed == 0.0, 0.0, direction)
    return 0.0 - speed * np.sin(angle), 0.0 - speed * np.cos(angle)


def geometric(height: FloatArray) -> FloatArray:
    """Return geometric heights [m] from geopotential heights [m]."""
    return EARTH_RADIUS * height / (EARTH_RADIUS - height)  # gravity falls as 1/radius^2


def profile_of(levels: Levels) -> WindProfile:
    """Return the wind profile of the levels of a file, with notes on omitted levels.

    It has the ascending levels with a height and a wind. Without two of them, and for levels that
    cannot be right, `InputError`.
    """
    speed = np.hypot(levels.east, levels.north)
    for invalid, message in level_faults(speed, height=levels.height):
        levels.text.require(~invalid, levels.line, message)
    measured = ~np.isnan(levels.height)
    has_wind = measured & ~np.isnan(levels.east + levels.north)
    ascending, notes = _ascending_levels(levels, np.flatnonzero(has_wind))
    if ascending.size < 2:
        raise InputError(
            f"{levels.text.source} must hold two or more levels with a height and a wind; got"
            f" {ascending.size}"
        )
    convert = geometric if levels.geopotential else np.asarray
    height = np.asarray(convert(levels.height))
    without_height = int(np.sum(~measured & ~np.isnan(levels.east + levels.north)))
    if without_height:
        levels_without = plural(without_height, "level")
        notes.append(f"{levels_without} with a wind but without a height left out")
    notes += _gap_notes(height[ascending], height[measured & ~has_wind])
    if levels.geopotential:
        notes.append("geopotential heights made geometric")
    return WindProfile(
        height=height[ascending],
        east=levels.east[ascending],
        north=levels.north[ascending],
        source=": ".join(filter(None, [levels.text.source, levels.title])),
        notes=(*levels.notes, *notes),
    )


def _ascending_levels(levels: Levels, index: IndexArray) -> tuple[IndexArray, list[str]]:
    """Return the indices of levels that lie above all before them, and notes on the others.

    `index`: indices of the levels that count, ``(n,)``. `InputError` for descending heights, except
    in the ascent of a balloon with at most half of its levels descending.
    """
    height = levels.height[index]
    # the largest height before each level
    highest = np.maximum.accumulate(np.concatenate([[-np.inf], height]))[:-1]
    repeated, descending = height == highest, height < highest
    if np.any(descending) and (not levels.balloon or 2 * np.sum(descending) > height.size):
        first = int(np.argmax(descending))
        raise levels.text.error(
            int(levels.line[index[first]]),
            f"heights must ascend; {height[first]:.6g} m comes after {highest[first]:.6g} m, so"
            " sort the levels",
        )
    notes = []
    if np.any(repeated):
        count, first = plural(int(np.sum(repeated)), "level"), height[np.argmax(repeated)]
        notes.append(f"{count} given twice, from {first:.6g} m on: the first is kept")
    if np.any(descending):
        notes.append(f"{plural(int(np.sum(descending)), 'level')} where the balloon sank left out")
    return index[~(repeated | descending)], notes


def _gap_notes(height: FloatArray, windless: FloatArray) -> list[str]:
    """Return notes on levels without a wind: gaps that are interpolated, and levels outside.

    `height`, `windless`: heights [m] of the levels with a wind, rising, and of those without.
    """
    upper = np.searchsorted(height, windless)  # index of the next level with a wind above
    bridged = np.unique(upper[(upper > 0) & (upper < height.size)])
    outside = int(np.sum((upper == 0) | (upper == height.size)))
    notes = []
    if bridged.size:
        widths = height[bridged] - height[bridged - 1]
        widest = bridged[np.argmax(widths)]
        notes.append(
            f"{plural(windless.size - outside, 'level')} without a wind bridged by straight lines,"
            f" the longest from {height[widest - 1]:.6g} to {height[widest]:.6g} m"
        )
    if outside:
        notes.append(f"{plural(outside, 'level')} without a wind below or above all winds left out")
    return notes
