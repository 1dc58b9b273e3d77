"""Required deflections of the soundings of an archive: bounds, equal where all wind is known.

Where the wind of a sounding is not known it is taken as calm; and as against the vehicle, as
strong as where it was known last, or as 95 % of the archive have at that height, if that is more.
What is required lies between what these two require.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from tvclin.answers.availability.growth import WindGrowth
from tvclin.answers.availability.plane_march import Additions, MarchedWinds, PlaneMarch
from tvclin.answers.availability.sounding_winds import FlightPath, KnownWinds, LineWinds
from tvclin.answers.sizing.flight_mode import FlightMode
from tvclin.answers.sizing.flight_requirement import FlightEquations
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.winds.histories import History
from tvclin.winds.soundings.archive import Soundings

STOPS = ("round", "square")
UNUSABLE, TOO_LOW, TOO_HIGH, TOO_FAST, TOO_SHORT, TOO_FLAT = (
    "it cannot be used",
    "it ends below the height of the largest dynamic pressure",
    "it begins above the height of the largest dynamic pressure",
    "its wind meets the flight at more than 30 deg where the dynamic pressure is largest",
    "it ends below known_to",
    "no horizontal wind turns the flight so far as the gust",
)
_LEVELS_TOGETHER = 60_000
"""Levels of soundings that are marched together: their steps fill some megabytes."""
_STRENGTH_HEIGHTS = 40
"""Heights of a flight at which the strength of winds in an archive is computed."""
_KNOWN_TOLERANCE = 1e-9
"""Relative difference of requirements below which an unknown wind does not matter."""


@dataclass(frozen=True, eq=False)
class Requirements:
    """Deflections [rad] that soundings require.

    Attributes
    ----------
    least, most : ndarray
        Bounds, with calm and with a strong wind where it is not known, ``(a, n)`` for azimuths and
        soundings; NaN where nothing can be said. Where trim reaches a limit more than once, and no
        flight decided, `most` holds what a flight may require more, up to the largest trim.
    lowest : ndarray
        What flights with all the wind known require at least, ``(a, n)``.
    known : ndarray of bool
        Whether the wind is known wherever it may count, ``(a, n)``.
    why : list of str
        Reason for which nothing can be said of a sounding, or empty.
    judged : ndarray
        First and last time [s] of the judged part of the flight, ``(n, 2)``.
    """

    least: FloatArray
    most: FloatArray
    lowest: FloatArray
    known: BoolArray
    why: list[str]
    judged: FloatArray


@dataclass(frozen=True, eq=False)
class FlightPart:
    """A part of a flight in which the air turns the vehicle to one side alone.

    `marches`: by the planes with an unstable mode.
    """

    path: FlightPath
    marches: dict[str, PlaneMarch]


@dataclass(frozen=True, eq=False)
class Judge:
    """A flight in one or both planes, ready for any wind.

    Attributes
    ----------
    flight : FlightSchedule
        The flight.
    path : FlightPath
        Its arrays over height.
    additions : Additions
        Growth and gust on top of the winds.
    parts : tuple of FlightPart
        In each the vehicle is flown by itself, and the largest requirement counts.
    planes : tuple of str
        Planes of the motion.
    azimuths : ndarray
        Directions of flight [rad], ``(a,)``.
    stop : {"round", "square"}
        Limit shape of both planes.
    known_to : float or None
        Height [m] to which each sounding must go.
    heights : ndarray
        Heights [m] of `strength`.
    strength : dict
        Speeds [m/s] below which 95 % of an archive stay there, by plane and azimuth.
    """

    flight: FlightSchedule
    path: FlightPath
    additions: Additions
    parts: tuple[FlightPart, ...]
    planes: tuple[str, ...]
    azimuths: FloatArray
    stop: str
    known_to: float | None
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
        pressure: bool,
        **options: Any,
    ) -> Judge:
        """Return the judge of a flight, for which an unknown wind is as strong as in the archive.

        `InputError` as `FlightMode` and `FlightPath`.
        """
        planes, path = PLANES if plane == BOTH else (plane,), FlightPath.of(flight)
        known = KnownWinds.of(soundings[soundings.usable], path)
        evenly = np.linspace(path.time[0], path.time[-1], _STRENGTH_HEIGHTS)
        heights = np.interp(evenly, path.time, path.height)
        return cls(
            flight,
            path,
            Additions(growth, gust, gust_speed, pressure),
            _parts(flight, model, planes),
            planes,
            azimuths,
            heights=heights,
            strength={
                (plane, azimuth): known.strength(heights, azimuth, plane)
                for plane in planes
                for azimuth in azimuths.tolist()
            },
            **options,
        )

    def requirements(
        self, soundings: Soundings, progress: Callable[[int, int], None] | None = None
    ) -> Requirements:
        """Return bounds of what soundings require, from trim and demand; report progress."""
        least, most, lowest = np.full((3, self.azimuths.size, len(soundings)), np.nan)
        known_all = np.ones(least.shape, dtype=bool)
        heights = np.full((len(soundings), 2), np.nan)
        why = [reason and f"{UNUSABLE}: {reason}" for reason in soundings.why]
        for reason, holds in self._left_out(soundings):
            for i in np.flatnonzero(holds & soundings.usable).tolist():
                why[i] = why[i] or reason
        index = np.flatnonzero([not reason for reason in why])
        last = len(soundings) - index.size
        for some, within, known in self._together(soundings, index):
            heights[some] = within
            flat = np.flatnonzero(~np.isnan(within[:, 0]))
            those, winds = some[flat], known.some(flat)
            if those.size:
                low, high, flown = self._bounds(winds, within[flat], held=False)
                least[:, those], most[:, those], lowest[:, those] = low, high, flown
                partly = np.flatnonzero(winds.incomplete(self.path))
                if partly.size:
                    held, higher, _ = self._bounds(
                        winds.some(partly), within[flat[partly]], held=True
                    )
                    low, high, those = low[:, partly], high[:, partly], those[partly]
                    known_all[:, those] = np.abs(held - low) <= _KNOWN_TOLERANCE * held
                    least[:, those] = np.minimum(low, held)
                    most[:, those] = np.maximum(high, higher)
            last += some.size
            if progress is not None:
                progress(last, len(soundings))
        fast, nothing = np.isnan(heights[:, 0]), np.isnan(least).any(axis=0)
        why = [
            reason or (TOO_FAST if steep else TOO_FLAT if none else "")
            for reason, steep, none in zip(why, fast, nothing, strict=True)
        ]
        times = np.interp(heights, self.path.height, self.path.time)
        return Requirements(least, most, lowest, known_all, why, times)

    def decided(
        self, soundings: Soundings, bounds: Requirements, limits: FloatArray
    ) -> tuple[Requirements, list[str]]:
        """Return requirements with flights where these decide on limits [rad], ``(a,)``; and notes.

        A sounding whose bounds lie to both sides of the limit, and that does not survive with it,
        is flown for what it requires, if all its wind is known. One that survives with less than
        its lower bound has the limit for its requirement.
        """
        room = np.maximum(limits, 0.0)[:, np.newaxis]
        least, most, notes = bounds.least.copy(), bounds.most.copy(), []
        with np.errstate(invalid="ignore"):  # NaN where nothing can be said
            more = (bounds.least <= room) & (room < bounds.most)
            less = bounds.known & (bounds.lowest <= room) & (room < bounds.least)
        survive, index = np.zeros(least.shape, dtype=bool), np.any(more | less, axis=0)
        for some, within, winds in self._together(soundings, np.flatnonzero(index)):
            for a, limit in enumerate(room[:, 0].tolist()):
                for held in (False, True):
                    whole = bounds.known[a, some] ^ held
                    cases = np.flatnonzero((more | less)[a, some] & whole)
                    if not cases.size:
                        continue
                    those = some[cases]
                    marched = list(self._marched(winds.some(cases), within[cases], a, held=False))
                    if held:
                        marched += self._marched(winds.some(cases), within[cases], a, held=True)
                    survive[a, those] = self._survive(marched, limit)
                    fails = np.flatnonzero(more[a, those] & ~survive[a, those])
                    if fails.size and not held:
                        each = [(p, of_plane.requirement(fails)) for p, of_plane in marched]
                        least[a, those[fails]] = most[a, those[fails]] = self._in_planes(each)
        most = np.where(more & survive, room, most)
        least, most = (np.where(less & survive, room, values) for values in (least, most))
        flown = int(np.sum((more & (bounds.known | survive)).any(axis=0)))
        if flown:
            notes.append(
                f"{flown} soundings whose trim reaches the limit more than once were flown with"
                " trim"
            )
        if fewer := int(np.sum((less & survive).any(axis=0))):
            notes.append(
                f"of the soundings that fly {fewer} have a bound of their needs above the limit: a"
                " flight of the trim law survives with it"
            )
        return replace(bounds, least=least, most=most), notes

    def _together(
        self, soundings: Soundings, index: IndexArray
    ) -> Iterator[tuple[IndexArray, FloatArray, KnownWinds]]:
        """Iterate over usable soundings that are marched together.

        Given are their places, the heights [m] between which they can be judged, and their winds.
        """
        index = index[np.argsort(soundings.counts[index], kind="stable")]
        known = KnownWinds.of(soundings[index], self.path)
        ends = np.cumsum(np.diff(known.offsets) + self.path.height.size)
        cuts = np.arange(_LEVELS_TOGETHER, ends.max(initial=0), _LEVELS_TOGETHER)
        for some in filter(np.size, np.split(np.arange(index.size), np.searchsorted(ends, cuts))):
            winds = known.some(some)
            yield index[some], winds.flat(self.path, self.additions.strongest), winds

    def _left_out(self, soundings: Soundings) -> list[tuple[str, BoolArray]]:
        """Of which soundings nothing can be said, and why."""
        empty = soundings.counts == 0
        ends = np.minimum(soundings.offsets, max(soundings.height.size - 1, 0))
        level = np.append(soundings.height, np.nan)
        bottom = np.where(empty, np.nan, level[ends[:-1]])
        top = np.where(empty, np.nan, level[np.maximum(soundings.offsets[1:] - 1, 0)])
        densest = self.path.densest
        with np.errstate(invalid="ignore"):
            reasons = [(TOO_LOW, top < densest), (TOO_HIGH, bottom > densest)]
            if self.known_to is not None:
                reasons.append((TOO_SHORT, top < self.known_to))
        return reasons

    def _bounds(self, known: KnownWinds, within: FloatArray, held: bool) -> FloatArray:
        """Return least, most and lowest of winds between heights [m], ``(3, a, n)``."""
        found = []
        for a in range(self.azimuths.size):
            each = [
                (p, np.stack([winds.bounds.least, winds.bounds.most, winds.bounds.lowest]))
                for p, winds in self._marched(known, within, a, held)
            ]
            found.append(self._in_planes(each, (3, within.shape[0])))
        return np.stack(found, axis=1)

    def _in_planes(
        self, each: list[tuple[int, FloatArray]], shape: tuple[int, ...] = ()
    ) -> FloatArray:
        """Return the deflections [rad] that both planes require, from those of winds by plane."""
        planes = np.zeros((len(self.planes), *(each[0][1].shape if each else shape)))
        for p, required in each:
            np.maximum(planes[p], required, out=planes[p])
        return planes.max(axis=0) if self.stop == "square" else np.hypot.reduce(planes)

    def _survive(self, marched: list[tuple[int, MarchedWinds]], limit: float) -> BoolArray:
        """Return whether flights through all winds survive with a limit [rad] and all above.

        With a round limit shape a plane has the fraction of the limit that it has of both bounds.
        """
        least = np.zeros((len(self.planes), *marched[0][1].bounds.least.shape))
        for p, winds in marched:
            np.maximum(least[p], winds.bounds.least, out=least[p])
        size, share = np.hypot.reduce(least), np.ones(least.shape)
        if self.stop == "round":
            share = np.divide(least, size, out=share, where=size > 0.0)
        survives = np.ones(size.shape, dtype=bool)
        flown = []
        for p, winds in marched:
            decide, lost = winds.flown(share[p] * limit)
            survives &= ~lost
            flown.append((winds, share[p] * limit, decide))
        for winds, limits, decide in flown:
            cases = np.flatnonzero(decide & survives)
            if cases.size:
                survives[cases] = winds.survive(limits, cases)
        return survives

    def _marched(
        self, known: KnownWinds, within: FloatArray, a: int, held: bool
    ) -> Iterator[tuple[int, MarchedWinds]]:
        """Iterate over places of planes, and all winds there that a flight must survive.

        `within`: heights [m] between which soundings are judged, ``(n, 2)``. `a`: place of the
        azimuth. `held`: whether a wind that is not known is strong.
        """
        azimuth, pressure = float(self.azimuths[a]), self.additions.pressure
        for part in self.parts:
            low, high = np.clip(within, *part.path.height[[0, -1]]).T[..., np.newaxis]
            height = np.clip(known.knots(part.path, held), low, high)
            times = np.interp(height, part.path.height, part.path.time)
            blows = {
                plane: (low < high) * known.at(known.wind(azimuth, plane, held), height)
                for plane in PLANES
            }
            bare = LineWinds(times, blows)
            for plane, march in part.marches.items():
                for side, winds in self._pushed(bare, plane, known, height, azimuth, held):
                    for gusty in march.with_gusts(winds, side, self.additions):
                        bounds = march.bounds(gusty, pressure)
                        yield (
                            self.planes.index(plane),
                            MarchedWinds(march, gusty, bounds, pressure),
                        )

    def _pushed(
        self,
        bare: LineWinds,
        plane: str,
        known: KnownWinds,
        height: FloatArray,
        azimuth: float,
        held: bool,
    ) -> Iterator[tuple[float, LineWinds]]:
        """Iterate over the signs of winds in a plane, and winds grown to that side.

        One sign stands for both where nothing is added to the winds.
        """
        if not held and self.additions.symmetric:
            yield 1.0, bare
            return
        wind, grown = bare.speeds[plane], self.additions.grown(height)
        hidden, strong = np.zeros(height.shape, dtype=bool), wind
        if held:
            usual = np.interp(height, self.heights, self.strength[plane, azimuth])
            hidden, strong = known.unknown(height), np.maximum(np.abs(wind), usual)
        for side in (1.0, -1.0):
            blows = np.where(hidden, side * strong, wind) + side * grown
            blows = np.where(np.ptp(height, axis=1, keepdims=True) > 0.0, blows, 0.0)
            yield side, LineWinds(bare.times, bare.speeds | {plane: blows})


@lru_cache(maxsize=8)
def _parts(flight: FlightSchedule, model: str, planes: tuple[str, ...]) -> tuple[FlightPart, ...]:
    """Return the parts of a flight, kept for the next question about it."""
    found = []
    for part in flight.parts:
        path = FlightPath.of(part)
        modes = {plane: FlightMode(part, model, plane, part.span) for plane in planes}
        motions = {k: FlightEquations(mode) for k, mode in modes.items() if mode.unstable}
        fastest = max(motions.values(), key=lambda motion: motion.fastest.max(), default=None)
        marches = {
            plane: PlaneMarch(path, plane, motion, fastest)
            for plane, motion in motions.items()
            if fastest is not None
        }
        found.append(FlightPart(path, marches))
    return tuple(found)
