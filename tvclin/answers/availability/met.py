"""The wind that a flight meets in each sounding of an archive, and where it was not measured."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.ascent.atmosphere import HIGHEST, LOWEST, standard_atmosphere
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import BoolArray, FloatArray, IntArray
from tvclin.winds.histories import History
from tvclin.winds.soundings.archive import Soundings, gather
from tvclin.winds.soundings.profile import checked_flight, longest_interval
from tvclin.winds.wind_angles import MAX_LINEAR_ANGLE

Winds = tuple[FloatArray, FloatArray]
"""Knots [s], and the wind angles [rad] there, each ``(n, k)``; straight lines between them."""

WIDEST = 2000.0
"""Between two levels farther apart [m] the wind is not known."""
_BESIDE = 0.01
"""m from the edge of such a gap to where nothing is known."""
_APART = 1e6
"""m between the heights of one sounding and those of the next, where all stand in one row."""
_USUAL = 0.95
"""Of the soundings that know the wind at a height, so many have no more of it."""
_LONGEST = 0.5
"""s, between two times of a flight at which its trim is looked at."""
_GUST_PARTS = 64


@dataclass(frozen=True, eq=False)
class FlownPath:
    """A flight over height: its arrays ``(f,)``, and the height of its largest dynamic pressure.

    In [m], [s], [m/s]; `climb` is the flight path angle [rad], `densest` the height at which rho
    V^2 is largest, in the standard atmosphere. `between` are times between those that are far
    apart, at which trim is looked at as well.
    """

    height: FloatArray
    time: FloatArray
    speed: FloatArray
    climb: FloatArray
    densest: float
    between: FloatArray

    @classmethod
    def of(cls, flight: FlightSchedule) -> FlownPath:
        """Return that of a schedule; `InputError` where it has no altitude, or does not ascend."""
        time, height, speed, climb = checked_flight(flight)
        density = standard_atmosphere(np.clip(height, LOWEST, HIGHEST)).density
        densest = float(height[np.argmax(density * speed**2)])
        more = [
            np.linspace(a, b, math.ceil((b - a) / _LONGEST), endpoint=False)[1:]
            for a, b in pairwise(time.tolist())
        ]
        return cls(height, time, speed, climb, densest, np.concatenate(more))

    def finer(self, times: FloatArray) -> FloatArray:
        """Return knots of winds [s], ``(n, k)``, with the times between; the same without any."""
        if not self.between.size:
            return times
        more = np.clip(self.between, times[:, :1], times[:, -1:])
        return np.sort(np.concatenate([times, more], axis=1), axis=1)

    def angle(self, wind: FloatArray, time: FloatArray, plane: str) -> FloatArray:
        """Return angles [rad], eq (B1e), of winds [m/s] at times; at most `MAX_LINEAR_ANGLE`."""
        across = 1.0 if plane == "yaw" else np.sin(np.interp(time, self.time, self.climb))
        sine, most = (
            wind * across / np.interp(time, self.time, self.speed),
            np.sin(MAX_LINEAR_ANGLE),
        )
        return np.asarray(np.arcsin(np.clip(sine, -most, most)))


@dataclass(frozen=True, eq=False)
class KnownWinds:
    """Soundings with the edges of what they did not see: two levels more in each gap.

    `gaps` are the first of these two levels, for each gap.
    """

    height: FloatArray
    east: FloatArray
    north: FloatArray
    offsets: IntArray
    gaps: IntArray

    @classmethod
    def of(cls, soundings: Soundings, path: FlownPath) -> KnownWinds:
        """Return those of soundings that can all be used."""
        height, offsets = soundings.height, soundings.offsets
        wide = np.diff(height) > WIDEST
        wide &= (height[:-1] < path.height[-1]) & (height[1:] > path.height[0])
        wide[offsets[1:-1] - 1] = False
        below = np.flatnonzero(wide)
        at = np.repeat(below + 1, 2)
        edges = np.stack([height[below] + _BESIDE, height[below + 1] - _BESIDE], axis=-1).ravel()
        more = 2 * np.bincount(
            np.searchsorted(offsets, below, side="right"), minlength=offsets.size
        )
        return cls(
            np.insert(height, at, edges),
            np.insert(soundings.east, at, 0.0),
            np.insert(soundings.north, at, 0.0),
            offsets + np.cumsum(more[: offsets.size]),
            below + 1 + 2 * np.arange(below.size),
        )

    def some(self, index: NDArray[np.intp]) -> KnownWinds:
        """Return those of some soundings."""
        offsets, levels = gather(self.offsets, index)
        marked = np.zeros(self.height.size, dtype=bool)
        marked[self.gaps] = True
        height, east, north = (one[levels] for one in (self.height, self.east, self.north))
        return KnownWinds(height, east, north, offsets, np.flatnonzero(marked[levels]))

    @property
    def bottom(self) -> FloatArray:
        """The lowest level of each [m]."""
        return np.asarray(self.height[self.offsets[:-1]])

    @property
    def top(self) -> FloatArray:
        """The highest level of each [m]."""
        return np.asarray(self.height[self.offsets[1:] - 1])

    def incomplete(self, path: FlownPath) -> BoolArray:
        """Which do not know the wind all along a flight."""
        gap = np.zeros(self.offsets.size - 1, dtype=bool)
        gap[np.searchsorted(self.offsets, self.gaps, side="right") - 1] = True
        return gap | (self.bottom > path.height[0]) | (self.top < path.height[-1])

    def wind(self, azimuth: float, plane: str, held: bool) -> FloatArray:
        """Return the wind [m/s] at the levels, as `WindProfile`; gaps are calm, or `held`."""
        sine, cosine = np.sin(azimuth), np.cos(azimuth)
        wind = self.east * sine + self.north * cosine
        if plane == "yaw":
            wind = self.north * sine - self.east * cosine
        if self.gaps.size:
            below, above = wind[self.gaps - 1], wind[self.gaps + 2]
            stronger = np.where(np.abs(below) > np.abs(above), below, above)
            wind[self.gaps] = wind[self.gaps + 1] = stronger if held else 0.0
        return np.asarray(wind)

    def flat(self, path: FlownPath, more: Callable[[FloatArray], Any]) -> FloatArray:
        """Return the lowest and the highest height [m] at which winds can be judged, ``(n, 2)``.

        That is the longest time in which the wind, with so many m/s more at a height, cannot meet
        the flight at more than `MAX_LINEAR_ANGLE` from any side; NaN where that leaves out the
        largest dynamic pressure.
        """
        height = self.knots(path, held=False)
        wind = np.hypot(self.at(self.east, height), self.at(self.north, height)) + more(height)
        steep = wind > np.sin(MAX_LINEAR_ANGLE) * np.interp(height, path.height, path.speed)
        ends = np.tile(path.height[[0, -1]], (height.shape[0], 1))
        for i in np.flatnonzero(steep.any(axis=1)).tolist():
            run = longest_interval(np.interp(height[i], path.height, path.time), ~steep[i])
            ends[i] = np.nan
            if run.start < run.stop:
                low, high = height[i, run.start], height[i, run.stop - 1]
                ends[i, 0] = low if run.start else path.height[0]
                ends[i, 1] = high if run.stop < height.shape[1] else path.height[-1]
        inside = (ends[:, :1] <= path.densest) & (path.densest <= ends[:, 1:])
        return np.where(inside, ends, np.nan)

    def unknown(self, height: FloatArray) -> BoolArray:
        """Where at heights ``(n, k)`` nothing was measured."""
        edge = np.zeros(self.height.size)
        edge[self.gaps] = edge[self.gaps + 1] = 1.0
        outside = (height < self.bottom[:, np.newaxis]) | (height > self.top[:, np.newaxis])
        return np.asarray(outside | (self.at(edge, height) > 0.5))

    def strength(self, heights: FloatArray, azimuth: float, plane: str) -> FloatArray:
        """Return the speed [m/s] that 95 % have no more of, at heights [m] in a row.

        Counted at each height by itself; zero where nobody has measured.
        """
        height = np.broadcast_to(heights, (self.offsets.size - 1, heights.size))
        speed = np.abs(self.at(self.wind(azimuth, plane, held=False), height))
        speed[self.unknown(height)] = np.inf
        speed.sort(axis=0)
        count = np.sum(np.isfinite(speed), axis=0)
        place = np.maximum(np.ceil(_USUAL * count).astype(np.int64) - 1, 0)
        found = speed[place, np.arange(place.size)] if speed.size else np.zeros(place.size)
        return np.where(count > 0, found, 0.0)

    def knots(self, path: FlownPath, held: bool) -> FloatArray:
        """Return the heights [m] at which the flight meets a level or has a row, ``(n, k)``.

        From the lowest to the highest level, or, `held`, all along the flight; rows with fewer
        levels repeat some.
        """
        counts = np.diff(self.offsets)
        place = np.minimum(np.arange(counts.max(initial=0)), counts[:, np.newaxis] - 1)
        levels = self.height[self.offsets[:-1, np.newaxis] + place]
        first, last = path.height[0], path.height[-1]
        low, high = (np.clip(end, first, last)[:, np.newaxis] for end in (self.bottom, self.top))
        if held:
            low, high = np.full_like(low, first), np.full_like(high, last)
        rows = np.broadcast_to(path.height, (counts.size, path.height.size))
        return np.sort(np.clip(np.concatenate([levels, rows], axis=1), low, high), axis=1)

    def at(self, wind: FloatArray, height: FloatArray) -> FloatArray:
        """Return a wind [m/s] at heights ``(n, k)``, beyond the levels that of the nearest."""
        apart = _APART * np.arange(self.offsets.size - 1)
        inside = np.clip(height, self.bottom[:, np.newaxis], self.top[:, np.newaxis])
        flat = self.height + np.repeat(apart, np.diff(self.offsets))
        return np.asarray(np.interp(inside + apart[:, np.newaxis], flat, wind))


def on_lines(times: FloatArray, values: FloatArray, at: FloatArray) -> FloatArray:
    """Return values ``(n, k)`` at other times ``(n, j)``, on straight lines; zero beyond theirs."""
    low, high = min(times.min(), at.min()), max(times.max(), at.max())
    apart = (1.0 + high - low) * np.arange(times.shape[0])[:, np.newaxis]
    found = np.interp(at + apart, (times + apart).ravel(), values.ravel())
    return np.where((times[:, :1] <= at) & (at <= times[:, -1:]), found, 0.0)


def with_gust(
    gust: History, sizes: FloatArray, times: FloatArray, angle: FloatArray, at: FloatArray
) -> Winds:
    """Return winds with a gust of the size of each, whose middle is at a time [s] of each."""
    middle = 0.5 * (gust.onset + gust.end)
    own = np.linspace(gust.onset, gust.end, _GUST_PARTS + 1)
    there = np.clip(at[:, np.newaxis] + own - middle, times[:, :1], times[:, -1:])
    both = np.sort(np.concatenate([times, there], axis=1), axis=1)
    wind = on_lines(times, angle, both)
    more = np.interp(both - at[:, np.newaxis] + middle, own, gust(own), 0.0, 0.0)
    return both, wind + sizes[:, np.newaxis] * more
