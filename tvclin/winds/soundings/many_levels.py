"""The levels of many soundings at once: what can be used of them, in flat arrays.

The rules are those of `levels`, and one more: a level with a wind and a pressure, but without a
height, gets one between its neighbours, straight in the logarithm of pressure.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray, IntArray
from tvclin.winds.soundings.archive import TOO_FEW
from tvclin.winds.soundings.levels import Faults, faults, geometric, towards
from tvclin.winds.soundings.many import Collected

_APART = 1e6
"""m between the heights of one sounding and those of the next, where all stand in one row."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Levels of some soundings in the order of the file, each array ``(m,)``; NaN where missing.

    `sounding`: which sounding, rising. `line`: line in the file. `broken`: not in its columns.
    `pressure`, `height`, `speed`, `direction`: [Pa], geopotential [m], [m/s], from where [rad].
    """

    sounding: IntArray
    line: IntArray
    broken: BoolArray
    pressure: FloatArray
    height: FloatArray
    speed: FloatArray
    direction: FloatArray


def collected(found: Collected, rows: Rows, times: NDArray[np.datetime64], why: list[str]) -> None:
    """Add soundings to what was found; `why` says what is already wrong with each."""
    bad = np.array([bool(reason) for reason in why], dtype=bool)
    wrongs: Faults = [(rows.broken, lambda _: "a level is cut short or not in its columns")]
    wrongs += faults(height=rows.height, speed=rows.speed, direction=rows.direction)
    for wrong, say in wrongs:
        for i in np.flatnonzero(wrong).tolist():
            sounding = int(rows.sounding[i])
            if not bad[sounding]:
                bad[sounding], why[sounding] = True, f"line {rows.line[i]}: {say(i)}"
    good = ~bad[rows.sounding]
    east, north = towards(rows.speed, rows.direction)
    blows = good & ~np.isnan(east + north)
    kept = np.flatnonzero(blows & ~np.isnan(rows.height))
    kept, twice, sunk = _rising(rows.sounding[kept], rows.height[kept], kept)
    mostly = np.bincount(sunk, minlength=bad.size) > np.bincount(
        rows.sounding[kept], minlength=bad.size
    )
    for i in np.flatnonzero(mostly & ~bad).tolist():
        bad[i], why[i] = True, "more than half of its levels lie below the one before"
    placed, height = _placed(rows, np.flatnonzero(blows & np.isnan(rows.height)))
    index = np.concatenate([kept, placed])
    level = np.concatenate([rows.height[kept], height])
    order = np.lexsort((index, level, rows.sounding[index]))  # where two are at one height
    index, level = index[order], level[order]
    sounding = rows.sounding[index]
    new = np.append(True, (np.diff(level) > 0.0) | (np.diff(sounding) > 0))[: index.size]
    index, level, sounding = (one[new] for one in (index, level, sounding))
    counts = np.bincount(sounding, minlength=bad.size)
    for i in np.flatnonzero((counts < 2) & ~bad).tolist():
        bad[i], why[i] = True, TOO_FEW
    use = ~bad[sounding]
    left = int(np.sum(blows & np.isnan(rows.height))) - placed.size
    found.count("levels with a wind and a pressure, placed in its logarithm", times=placed.size)
    found.count("levels with a wind but without a height, left out", times=left)
    found.count("levels of a height that was there already, left out", times=twice)
    found.count("levels where the balloon sank, left out", times=sunk.size)
    made = geometric(level[use]), east[index[use]], north[index[use]]
    found.pieces.append((*made, np.where(bad, 0, counts), times))
    found.why.extend(why)


def _rising(
    sounding: IntArray, height: FloatArray, index: IndexArray
) -> tuple[IndexArray, int, IntArray]:
    """Levels above all before them; how many stand twice; and of which soundings the others are."""
    above = height + _APART * sounding
    highest = np.maximum.accumulate(np.concatenate([[-np.inf], above]))[:-1]
    twice, sunk = above == highest, above < highest
    return index[~(twice | sunk)], int(twice.sum()), sounding[sunk]


def _placed(rows: Rows, index: IndexArray) -> tuple[IndexArray, FloatArray]:
    """Of levels without a height those that lie between two with one, and their heights [m]."""
    with np.errstate(invalid="ignore", divide="ignore"):
        up = -np.log(np.where(rows.pressure > 0.0, rows.pressure, np.nan))
    base = np.flatnonzero(~np.isnan(up + rows.height))
    base = _rising(rows.sounding[base], up[base], base)[0]
    base = _rising(rows.sounding[base], rows.height[base], base)[0]
    index = index[~np.isnan(up[index])]
    if not base.size or not index.size:
        return index[:0], np.empty(0)
    place, key = (up[i] + 100.0 * rows.sounding[i] for i in (index, base))
    after = np.searchsorted(key, place)
    inside = (after > 0) & (after < key.size)
    low, high = base[np.maximum(after - 1, 0)], base[np.minimum(after, key.size - 1)]
    same = (rows.sounding[low] == rows.sounding[index]) & (
        rows.sounding[high] == rows.sounding[index]
    )
    return index[inside & same], np.interp(place, key, rows.height[base])[inside & same]
