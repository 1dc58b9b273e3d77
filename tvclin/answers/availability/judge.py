"""The need of each sounding of an archive: its bounds, equal where all of its wind is known.

Where a sounding does not know the wind it is taken as calm; and as blowing against the vehicle, as
strong as where it was known last, or as 95 % of the archive have at that height, if that is more.
The need lies between what these two ask for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from tvclin.answers.availability.flights import PlaneFlights, survives_all
from tvclin.answers.availability.growth import WindGrowth
from tvclin.answers.availability.met import FlownPath, KnownWinds, Winds, on_lines
from tvclin.answers.availability.sides import Sides, at_most, flown_needs, in_air
from tvclin.answers.availability.tables import FlightTables, flight_tables
from tvclin.answers.sizing.flight_mode import FlightMode
from tvclin.answers.sizing.flight_requirement import FlightEquations
from tvclin.answers.time_varying import even_steps
from tvclin.answers.varying_equations import Equations
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.winds.histories import History
from tvclin.winds.soundings.archive import Soundings

STOPS = ("round", "square")
UNUSABLE, TOO_LOW, TOO_HIGH, TOO_FAST, TOO_SHORT = (
    "it cannot be used",
    "it ends below the height of the largest dynamic pressure",
    "it begins above the height of the largest dynamic pressure",
    "its wind meets the flight at more than 30 deg where the dynamic pressure is largest",
    "it ends below known_to",
)
_AT_ONCE = 200_000
"""Levels of soundings that are looked at together."""
_HEIGHTS = 40
"""Of a flight, at which the strength of winds in an archive is looked at."""


@dataclass(frozen=True, eq=False)
class Needs:
    """What soundings ask for.

    `least` and `most` are with calm, and with a strong wind, where it is not known [rad], ``(a,
    n)`` for azimuths and soundings; NaN where nothing can be said. Where the limit is met more than
    once, and the law is not flown, `most` holds what a flight may need more, up to the largest
    trim, with which the law is never limited. `known` is whether the wind is known wherever it may
    count, ``(a, n)``. Of each sounding `why` is why nothing can be said, or empty, and `judged` the
    first and last time [s] of the part of the flight of which it can, ``(n, 2)``.
    """

    least: FloatArray
    most: FloatArray
    known: BoolArray
    why: list[str]
    judged: FloatArray


@dataclass(frozen=True, eq=False)
class FlightPart:
    """A part of a flight in which the air turns the vehicle to one side alone.

    By the planes with an unstable mode, `met` is times of even steps [s], and the equations
    there.
    """

    path: FlownPath
    tables: dict[str, FlightTables]
    met: dict[str, tuple[FloatArray, Equations]]


@dataclass(frozen=True, eq=False)
class Judge:
    """A flight in one or both planes, ready for any wind.

    `parts`: of the flight; in each the vehicle is flown by itself, and the largest need counts.
    `azimuths`: directions of flight [rad], ``(a,)``. `stop`: "round" or "square", how the planes go
    together. `known_to`: a height [m] to which each sounding must go. `pressure`: whether the
    dynamic pressure that a wind makes counts, or that of calm air. `strength`: what 95 % of an
    archive stay below [m/s] at `heights` [m], by plane and azimuth.
    """

    flight: FlightSchedule
    sides: Sides
    parts: tuple[FlightPart, ...]
    planes: tuple[str, ...]
    azimuths: FloatArray
    stop: str
    known_to: float | None
    pressure: bool
    heights: FloatArray
    strength: dict[tuple[str, float], FloatArray]

    @classmethod
    def of(
        cls,
        flight: FlightSchedule,
        soundings: Soundings,
        *,
        plane: str,
        model: str,
        azimuths: FloatArray,
        growth: WindGrowth | None,
        gust: History | None,
        gust_speed: float | None,
        **asked: Any,
    ) -> Judge:
        """Return that of a flight; what is not known will be as strong as in the archive.

        `InputError` as `FlightMode` and `FlownPath`.
        """
        planes, path = PLANES if plane == BOTH else (plane,), FlownPath.of(flight)
        known = KnownWinds.of(soundings[soundings.usable], path)
        evenly = np.linspace(path.time[0], path.time[-1], _HEIGHTS)
        heights = np.interp(evenly, path.time, path.height)
        return cls(
            flight,
            Sides(path, growth, gust, gust_speed),
            _parts(flight, model, planes),
            planes,
            azimuths,
            heights=heights,
            strength={
                (plane, azimuth): known.strength(heights, azimuth, plane)
                for plane in planes
                for azimuth in azimuths.tolist()
            },
            **asked,
        )

    def needs(
        self,
        soundings: Soundings,
        progress: Callable[[int, int], None] | None = None,
        flown: bool = False,
        limits: FloatArray | None = None,
    ) -> Needs:
        """Return what soundings ask for; tell how many are done.

        `flown` where a flight may need more than their bounds say; and where it may survive with
        limits [rad], ``(a,)``, that are less.
        """
        least, most = np.full((2, self.azimuths.size, len(soundings)), np.nan)
        known_all = np.ones(least.shape, dtype=bool)
        heights = np.full((len(soundings), 2), np.nan)
        why = [one and f"{UNUSABLE}: {one}" for one in soundings.why]
        index = np.flatnonzero(soundings.usable)
        for reason, holds in self._left_out(soundings):
            for i in np.flatnonzero(holds & soundings.usable).tolist():
                why[i] = why[i] or reason
            index = index[~holds[index]]
        index = index[np.argsort(soundings.counts[index], kind="stable")]
        path = self.sides.path
        known = KnownWinds.of(soundings[index], path)
        ends = np.cumsum(np.diff(known.offsets) + path.height.size)
        last = len(soundings) - index.size
        cuts = np.arange(_AT_ONCE, ends.max(initial=0), _AT_ONCE)
        for some in filter(np.size, np.split(np.arange(index.size), np.searchsorted(ends, cuts))):
            within = known.some(some).flat(path, self.sides.strongest)
            heights[index[some]] = within
            flat = ~np.isnan(within[:, 0])
            winds, within, those = known.some(some[flat]), within[flat], index[some[flat]]
            if those.size:
                low, high = self._needs(winds, within, False, flown, limits)
                least[:, those], most[:, those] = low, high
                open_ = winds.incomplete(path)
                if np.any(open_):
                    those, within = those[open_], within[open_]
                    held, higher = self._needs(
                        winds.some(np.flatnonzero(open_)), within, True, flown, limits
                    )
                    known_all[:, those] = low[:, open_] == held
                    least[:, those] = np.minimum(low[:, open_], held)
                    most[:, those] = np.maximum(high[:, open_], higher)
            last += some.size
            if progress is not None:
                progress(last, len(soundings))
        fast = np.isnan(heights[:, 0])
        why = [one or (TOO_FAST if lost else "") for one, lost in zip(why, fast, strict=True)]
        times = np.interp(heights, path.height, path.time)
        return Needs(least, most, known_all, why, times)

    def decided(
        self, soundings: Soundings, needs: Needs, limits: FloatArray
    ) -> tuple[Needs, list[str]]:
        """Return the needs, flown where that decides about limits [rad], ``(a,)``; and what to say.

        What may need more than its bound is flown for what it needs. What its bound says is lost
        has the limit for its need if it survives with it.
        """
        room = np.maximum(limits, 0.0)[:, np.newaxis]
        least, most, known, told = needs.least.copy(), needs.most.copy(), needs.known.copy(), []
        with np.errstate(invalid="ignore"):  # NaN where nothing can be said
            more = needs.known & (needs.least <= room) & (room < needs.most)
            less = needs.known & (needs.least > room)
        again = np.flatnonzero(more.any(axis=0))
        if again.size:
            found = self.needs(soundings[again], flown=True)
            least[:, again], most[:, again] = found.least, found.most
            told.append(
                f"{again.size} soundings whose trim reaches the limit more than once were flown"
                " with trim"
            )
        again = np.flatnonzero(less.any(axis=0))
        if again.size:
            found = self.needs(soundings[again], limits=room[:, 0])
            here = less[:, again] & (found.least <= room)
            for old, new in ((least, found.least), (most, found.most), (known, found.known)):
                old[:, again] = np.where(here, new, old[:, again])
            survive = int(np.sum(here.any(axis=0)))
            if survive:
                told.append(
                    f"of the soundings that fly {survive} have a bound of their needs above the"
                    " limit: a flight of the trim law survives with it"
                )
        return replace(needs, least=least, most=most, known=known), told

    def _left_out(self, soundings: Soundings) -> list[tuple[str, BoolArray]]:
        """Of which soundings nothing can be said, and why."""
        empty = soundings.counts == 0
        ends = np.minimum(soundings.offsets, max(soundings.height.size - 1, 0))
        level = np.append(soundings.height, np.nan)
        bottom = np.where(empty, np.nan, level[ends[:-1]])
        top = np.where(empty, np.nan, level[np.maximum(soundings.offsets[1:] - 1, 0)])
        densest = self.sides.path.densest
        with np.errstate(invalid="ignore"):
            reasons = [(TOO_LOW, top < densest), (TOO_HIGH, bottom > densest)]
            if self.known_to is not None:
                reasons.append((TOO_SHORT, top < self.known_to))
        return reasons

    def _needs(
        self,
        known: KnownWinds,
        within: FloatArray,
        held: bool,
        flown: bool,
        limits: FloatArray | None,
    ) -> FloatArray:
        """The least and the most needs in all azimuths, ``(2, a, n)``, of both planes.

        Between heights [m], ``(n, 2)``.
        """
        found = np.zeros((len(self.planes), 2, self.azimuths.size, within.shape[0]))
        in_calm = np.zeros_like(found[:, 0])
        met: list[list[PlaneFlights]] = [[] for _ in self.azimuths]
        paired = np.zeros(within.shape[0], dtype=bool)
        for part in self.parts:
            for p, a, need, calm, winds, pairs in self._met(part, known, within, held, flown):
                np.maximum(found[p, :, a], need, out=found[p, :, a])
                np.maximum(in_calm[p, a], calm, out=in_calm[p, a])
                mode = part.tables[self.planes[p]].mode
                met[a].append(PlaneFlights(mode, winds, in_calm[p, a]))
                paired |= pairs
        both = np.asarray(found.max(axis=0) if self.stop == "square" else np.hypot.reduce(found))
        if limits is not None:
            for a, limit in enumerate(limits.tolist()):
                over = ~paired & (np.nan_to_num(both[0, a]) > limit)
                some = np.divide(limit, both[0, a], out=np.ones(over.shape), where=over)
                both[:, a, survives_all(met[a], some)] = limit
        return both

    def _met(
        self, part: FlightPart, known: KnownWinds, within: FloatArray, held: bool, flown: bool
    ) -> Iterator[tuple[int, int, FloatArray, FloatArray, list[Winds], BoolArray]]:
        """By plane and azimuth what a part of the flight asks for, ``(2, n)``, and in which winds.

        Before these what it asks for at the least in calm air's dynamic pressure; behind them in
        which two modes grow as a pair, each ``(n,)``.
        """
        low, high = np.clip(within, *part.path.height[[0, -1]]).T[..., np.newaxis]
        there = low < high
        height = np.clip(known.knots(part.path, held), low, high)
        times = np.interp(height, part.path.height, part.path.time)
        fine = part.path.finer(times)
        hidden = known.unknown(height) if held else False
        for plane, tables in part.tables.items():
            rows = tables.at(fine)
            for a, azimuth in enumerate(self.azimuths.tolist()):
                blow = {
                    one: there * known.at(known.wind(azimuth, one, held), height) for one in PLANES
                }
                wind = blow[plane]
                strong = np.abs(wind)
                if held:
                    most = np.interp(height, self.heights, self.strength[plane, azimuth])
                    strong = np.maximum(strong, there * most)
                alike = not held and self.sides.gust is None and self.sides.growth is None
                each = flown and not alike  # the same wind to both sides is flown once
                sides = [
                    self.sides.to_one(
                        tables, height, times, np.where(hidden, strong, blows), fine, rows, each
                    )
                    for blows in (wind, -wind)
                ]
                winds = sides[0][1] + ([] if alike else sides[1][1])
                calm = [need for need, _ in sides]
                need = np.maximum(*calm)
                if flown and alike:
                    need = flown_needs(tables.mode, *winds[0], need)
                    calm = [need, need]
                if self.pressure:
                    other = blow["pitch" if plane == "yaw" else "yaw"]
                    beside = on_lines(times, other, fine)
                    factors = [
                        in_air(part.path, part.met[plane], plane, side, winds, beside, fine)
                        for side, (_, winds) in zip((1.0, -1.0), sides[: 2 - alike], strict=False)
                    ]
                    need = np.maximum(calm[0] * factors[0], calm[1] * factors[-1])
                need = np.stack([need[0], at_most(need)])
                pairs = np.asarray(rows.paired.any(axis=1))
                yield self.planes.index(plane), a, need, np.maximum(*calm)[0], winds, pairs


@lru_cache(maxsize=8)
def _parts(flight: FlightSchedule, model: str, planes: tuple[str, ...]) -> tuple[FlightPart, ...]:
    """Return the parts of a flight, kept for the next question about it."""
    found = []
    for part in flight.parts:
        every = {plane: FlightMode(part, model, plane, part.span) for plane in planes}
        grow = {plane: mode for plane, mode in every.items() if mode.unstable}
        flights = {plane: FlightEquations(mode) for plane, mode in grow.items()}
        steps = {plane: even_steps(one, part.span) for plane, one in flights.items()}
        found.append(
            FlightPart(
                FlownPath.of(part),
                {plane: flight_tables(mode) for plane, mode in grow.items()},
                {k: (steps[k], one.over(steps[k])) for k, one in flights.items()},
            )
        )
    return tuple(found)
