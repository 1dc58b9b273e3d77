"""The levels of one sounding as a file gives them, and the profile that they make."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray, IntArray
from tvclin.base.errors import InputError
from tvclin.base.text import Text
from tvclin.winds.soundings.profile import WindProfile

EARTH_RADIUS = 6_356_766.0
"""m, to which the geopotential height of the U.S. Standard Atmosphere 1976 belongs."""
LOWEST, HIGHEST = -1e3, 1e5
FASTEST = 130.0
"""m/s, above all winds that balloons have met; of some stations winds ten times too large stand in
archives."""
_ROUNDING = 1e-9
"""Of directions and speeds, from components or other units."""
_EMPTY = "; leave the cell empty where a value is missing"
_OR_EMPTY = ", or leave the cell empty where a value is missing"
Faults = list[tuple[BoolArray, Callable[[int], str]]]


@dataclass(frozen=True, eq=False, kw_only=True)
class Levels:
    """Levels of one sounding; each array has the shape ``(n,)`` and NaN where nothing was measured.

    `line`: line of each level. `height`: [m]. `east`, `north`: wind towards east and north [m/s].
    `title`: station and time, as far as the file gives them. `geopotential`: whether heights are
    geopotential. `balloon`: whether the levels stand in the order in which a balloon met them: it
    may sink for a while. `notes`: what is already known to be worth saying.
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
    def blowing(
        cls, *, text: Text, line: IntArray, speed: FloatArray, direction: FloatArray, **more: Any
    ) -> Levels:
        """Return levels by speed [m/s] and the direction it comes from [rad].

        `more`: the other fields. `InputError` for what is no wind.
        """
        for wrong, say in faults(speed=speed, direction=direction):
            text.require(~wrong, line, say)
        east, north = towards(speed, direction)
        return cls(text=text, line=line, east=east, north=north, **more)


@dataclass(frozen=True)
class Found:
    """A sounding in a file.

    `read`: reads its levels. `time`: its time, as "2024-01-15 12"; empty where the file does not
    say. `notes`: notes for its levels.
    """

    read: Callable[[], Levels]
    time: str = ""
    notes: tuple[str, ...] = ()

    def noted(self, note: str) -> Found:
        """Return the same with a note more."""
        return replace(self, notes=(*self.notes, note))

    def levels(self) -> Levels:
        """Return the levels, with the notes."""
        levels = self.read()
        return replace(levels, notes=(*levels.notes, *self.notes))


def faults(
    *,
    height: FloatArray | None = None,
    speed: FloatArray | None = None,
    direction: FloatArray | None = None,
) -> Faults:
    """Return what no sounding may hold, alone or in an archive.

    `height`, `speed`, `direction`: [m], [m/s], [rad] of levels, ``(n,)``; NaN where nothing was
    measured. Returned: which levels are at fault, ``(n,)``, and what says so of one, by its index.
    """
    found: Faults = []
    if speed is not None:
        found += [
            (speed < 0.0, lambda i: f"speed must not be negative; got {speed[i]:.6g} m/s{_EMPTY}"),
            (
                speed > FASTEST * (1.0 + _ROUNDING),
                lambda i: (
                    f"no wind blows with {speed[i]:.6g} m/s, above {FASTEST:g}; check its"
                    f" unit{_OR_EMPTY}"
                ),
            ),
        ]
    if direction is not None:
        degrees = np.degrees(direction)
        found.append((
            (degrees < -_ROUNDING) | (degrees > 360.0 + _ROUNDING),
            lambda i: f"direction must be between 0 and 360 degrees; got {degrees[i]:.6g}{_EMPTY}",
        ))  # fmt: skip
    if height is not None:
        found.append((
            (height < LOWEST) | (height > HIGHEST),
            lambda i: (
                f"height must be between {LOWEST:g} and {HIGHEST:g} m; got {height[i]:.6g} m, so"
                f" check its unit{_OR_EMPTY}"
            ),
        ))  # fmt: skip
    return found


def towards(speed: FloatArray, direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the wind towards east and north [m/s] of a speed and the direction it comes from.

    The direction [rad] is counted from north, clockwise. A calm needs none.
    """
    angle = np.where(speed == 0.0, 0.0, direction)
    return 0.0 - speed * np.sin(angle), 0.0 - speed * np.cos(angle)


def geometric(height: FloatArray) -> FloatArray:
    """Return the geometric heights [m] of geopotential ones."""
    return EARTH_RADIUS * height / (EARTH_RADIUS - height)


def profile_of(levels: Levels) -> WindProfile:
    """Return the profile of the levels of a file, with notes on what was left out."""
    speed = np.hypot(levels.east, levels.north)
    for wrong, say in faults(height=levels.height, speed=speed):
        levels.text.require(~wrong, levels.line, say)
    measured = ~np.isnan(levels.height)
    blows = measured & ~np.isnan(levels.east + levels.north)
    rising, notes = _rising(levels, np.flatnonzero(blows))
    if rising.size < 2:
        raise InputError(
            f"{levels.text.source} must hold two or more levels with a height and a wind; got"
            f" {rising.size}"
        )
    made = geometric if levels.geopotential else np.asarray
    height = np.asarray(made(levels.height))
    lost = int(np.sum(~measured & ~np.isnan(levels.east + levels.north)))
    if lost:
        notes.append(f"{levels_in_words(lost)} with a wind but without a height left out")
    notes += _gaps(height[rising], height[measured & ~blows])
    if levels.geopotential:
        notes.append("geopotential heights made geometric")
    return WindProfile(
        height=height[rising],
        east=levels.east[rising],
        north=levels.north[rising],
        source=": ".join(filter(None, [levels.text.source, levels.title])),
        notes=(*levels.notes, *notes),
    )


def _rising(levels: Levels, index: IndexArray) -> tuple[IndexArray, list[str]]:
    """Keep of the levels those that lie above all before them."""
    height = levels.height[index]
    highest = np.maximum.accumulate(np.concatenate([[-np.inf], height]))[:-1]
    twice, sunk = height == highest, height < highest
    if np.any(sunk) and (not levels.balloon or 2 * np.sum(sunk) > height.size):
        first = int(np.argmax(sunk))
        raise levels.text.error(
            int(levels.line[index[first]]),
            f"heights must ascend; {height[first]:.6g} m comes after {highest[first]:.6g} m, so"
            " sort the levels",
        )
    notes = []
    if np.any(twice):
        count, first = levels_in_words(int(np.sum(twice))), height[np.argmax(twice)]
        notes.append(f"{count} given twice, from {first:.6g} m on: the first is kept")
    if np.any(sunk):
        notes.append(f"{levels_in_words(int(np.sum(sunk)))} where the balloon sank left out")
    return index[~(twice | sunk)], notes


def _gaps(height: FloatArray, windless: FloatArray) -> list[str]:
    above = np.searchsorted(height, windless)
    beside = np.unique(above[(above > 0) & (above < height.size)])
    outside = int(np.sum((above == 0) | (above == height.size)))
    notes = []
    if beside.size:
        widths = height[beside] - height[beside - 1]
        widest = beside[np.argmax(widths)]
        notes.append(
            f"{levels_in_words(windless.size - outside)} without a wind bridged by straight lines,"
            f" the longest from {height[widest - 1]:.6g} to {height[widest]:.6g} m"
        )
    if outside:
        notes.append(f"{levels_in_words(outside)} without a wind below or above all winds left out")
    return notes


def levels_in_words(count: int) -> str:
    """Return "1 level" or "3 levels"."""
    return f"{count} level{'s' * (count != 1)}"
