"""Required deflections of the soundings of an archive: bounds, equal where all wind is known.

Where the wind of a sounding is not known, two winds are computed: a calm; and a wind against the
vehicle, as strong as any that a sounding may have. The required deflection is at most the larger of
both requirements (`marched_winds`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np

from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.base.lines import plural
from tvclin.ensembles.availability.marched_winds import Additions, MarchedWinds, PlaneMarch
from tvclin.ensembles.availability.sounding_winds import (
    FlightPath,
    PolylineWinds,
    SoundingWinds,
    WindGrowth,
)
from tvclin.requirement.flight.flight_requirement import FlightMode
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.winds.histories import History
from tvclin.winds.soundings.archive import Soundings

STOPS = ("round", "square")
UNUSABLE, TOO_LOW, TOO_HIGH, TOO_FAST, TOO_SHORT, TOO_FLAT = (
    "the sounding cannot be used",
    "the sounding ends below the height of the largest dynamic pressure",
    "the sounding begins above the height of the largest dynamic pressure",
    "the wind meets the flight at more than 30 deg where the dynamic pressure is largest",
    "the sounding ends below known_to",
    "no horizontal wind turns the flight so far as the gust",
)
_MAX_LEVELS_PER_MARCH = 60_000
"""Levels of soundings that are marched together: their steps fill some megabytes."""
_KNOWN_TOLERANCE = 1e-9
"""Relative difference of requirements below which an unknown wind does not matter."""


@dataclass(frozen=True, eq=False)
class Requirements:
    """Deflections [rad] that n soundings require towards a azimuths, arrays ``(a, n)``.

    `lower`, `upper`: bounds, with calm and with a strong wind where it is not known; NaN where the
    sounding is not judged. Where trim reaches a limit more than once, and no flight decided,
    `upper` is the largest possible requirement of a flight, at most the largest trim. `lowest`:
    lowest limits with which flights may survive. `wind_known`: whether the wind is known wherever
    it may count. `reasons`: for each sounding why it is not judged, or empty. `judged`: first and
    last time [s] of the judged interval of the flight, ``(n, 2)``.
    """

    lower: FloatArray
    upper: FloatArray
    lowest: FloatArray
    wind_known: BoolArray
    reasons: list[str]
    judged: FloatArray


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
    judged_path : FlightPath
        The interval of it that is judged, up to the end of `FlightMode.until_stable`.
    marches : dict of str to PlaneMarch
        Equations of that interval by plane, for planes with an unstable mode.
    planes : tuple of str
        Planes of the motion.
    azimuths : ndarray
        Directions of flight [rad], ``(a,)``.
    limit_shape : {"round", "square"}
        Limit shape of both planes.
    known_to : float or None
        Height [m] to which each sounding must go.
    """

    flight: FlightSchedule
    path: FlightPath
    additions: Additions
    judged_path: FlightPath
    marches: dict[str, PlaneMarch]
    planes: tuple[str, ...]
    azimuths: FloatArray
    limit_shape: str
    known_to: float | None

    @classmethod
    def of(
        cls,
        flight: FlightSchedule,
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
        """Return the judge of a flight: of the requirements of soundings while it is unstable.

        `plane`: pitch, yaw or both. `model`: name of the linear model. `azimuths`: directions of
        flight [rad], ``(a,)``. `growth`: growth of winds until launch. `gust`, `gust_speed`: gust
        by its angle [rad], and wind speed [m/s] at its peak in place of the angle. `pressure`:
        whether the dynamic pressure encountered counts, or the nominal. `options`: the fields
        `limit_shape`, "round" or "square", and `known_to`, height [m] to which soundings must go,
        or None. Same exceptions as `FlightMode` and `FlightPath`.
        """
        planes, path = PLANES if plane == BOTH else (plane,), FlightPath.of(flight, pressure)
        judged_path, marches = _judged_interval(flight, model, planes, pressure)
        return cls(
            flight=flight,
            path=path,
            additions=Additions(growth, gust, gust_speed),
            judged_path=judged_path,
            marches=marches,
            planes=planes,
            azimuths=azimuths,
            **options,
        )

    def requirements(
        self, soundings: Soundings, progress: Callable[[int, int], None] | None = None
    ) -> Requirements:
        """Return bounds of the required deflections [rad] of n soundings, from trim and demand.

        The demand is the limit sufficient when held from then on. `lower` and `upper` are these
        bounds, `lowest` the lowest limit that may survive.
        `progress`: called with the number of finished soundings and of all soundings.
        """
        lower, upper, lowest = np.full((3, self.azimuths.size, len(soundings)), np.nan)
        wind_known = np.ones(lower.shape, dtype=bool)
        heights = np.full((len(soundings), 2), np.nan)
        reasons = [reason and f"{UNUSABLE}: {reason}" for reason in soundings.why]
        for reason, holds in self._unjudged(soundings).items():
            for i in np.flatnonzero(holds & soundings.usable).tolist():
                reasons[i] = reasons[i] or reason
        index = np.flatnonzero([not reason for reason in reasons])  # soundings that may be judged
        done = len(soundings) - index.size
        # batches: indices of soundings, heights [m] between which they are judged, and winds
        for cases, within, winds in self._together(soundings, index):
            heights[cases] = within
            done += cases.size
            linear = np.flatnonzero(~np.isnan(within[:, 0]))  # within linear aerodynamics
            if linear.size:
                bounds = self._bounds_of_unknown(winds.select(linear), within[linear])
                for values, bound in zip((lower, upper, lowest, wind_known), bounds, strict=True):
                    values[:, cases[linear]] = bound
            if progress is not None:
                progress(done, len(soundings))
        # NaN of heights: beyond linear aerodynamics; of bounds: no wind has the angle of the gust
        too_fast, too_flat = np.isnan(heights[:, 0]), np.isnan(lower).any(axis=0)
        reasons = [
            reason or (TOO_FAST if fast else TOO_FLAT if flat else "")
            for reason, fast, flat in zip(reasons, too_fast, too_flat, strict=True)
        ]
        return Requirements(
            lower=lower,
            upper=upper,
            lowest=lowest,
            wind_known=wind_known,
            reasons=reasons,
            judged=np.interp(heights, self.path.height, self.path.time),
        )

    def decided(
        self, soundings: Soundings, bounds: Requirements, limits: FloatArray
    ) -> tuple[Requirements, list[str]]:
        """Return requirements narrowed by flights where these decide on limits [rad]; and notes.

        `bounds`: requirements without flights. `limits`: by azimuth, ``(a,)``; a negative one
        counts as zero. A sounding is flown where the limit is `between` its bounds, which differ
        where wind is unknown or trim reaches a limit more than once; or `below` the lower one but
        not below `bounds.lowest`, with which a flight may survive. If it survives, the limit is its
        upper bound, and if `below` also the lower one. If it is lost and `between`, and its wind is
        known, both bounds become its requirement by further flights.
        """
        from tvclin.flights.closed_loop.survival_limit import FINE, STRIDE  # late: all of `flights`

        limit = np.maximum(limits, 0.0)[:, np.newaxis]
        lower, upper, notes = bounds.lower.copy(), bounds.upper.copy(), []
        with np.errstate(invalid="ignore"):  # NaN where nothing can be said
            between = (lower <= limit) & (limit < upper)  # (a, n): n soundings
            below = bounds.wind_known & (bounds.lowest <= limit) & (limit < lower)
        survive, flown = np.zeros(lower.shape, dtype=bool), between | below  # (a, n) each
        index = np.flatnonzero(np.any(flown, axis=0))
        # `within`: lowest and highest height [m] at which the winds of a batch can be judged
        for batch, within, winds in self._together(soundings, index):
            for a, wind_known in product(range(limits.size), (True, False)):
                selected = np.flatnonzero(
                    flown[a, batch] & (bounds.wind_known[a, batch] == wind_known)
                )
                if not selected.size:
                    continue
                cases, selection = batch[selected], (winds.select(selected), within[selected], a)
                # pairs of a plane's index and the winds in it, all of which must be survived:
                # unknown parts of a wind as calm and, with `strong`, as the strongest wind
                marched = list(self._marched(*selection))
                if not wind_known:
                    marched += self._marched(*selection, strong=True)
                survive[a, cases] = self._survive(marched, float(limit[a, 0]))
                fail = np.flatnonzero(between[a, cases] & ~survive[a, cases])
                if wind_known and fail.size:
                    required = [(p, in_plane.requirement(fail)) for p, in_plane in marched]
                    # of all planes together, in the measure of the limit shape
                    lower[a, cases[fail]] = upper[a, cases[fail]] = self._in_planes(required)
        upper = np.where(flown & survive, limit, upper)
        lower = np.where(below & survive, limit, lower)
        if count := int(np.sum((between & (bounds.wind_known | survive)).any(axis=0))):
            notes.append(
                f"flown with trim: {plural(count, 'sounding')} whose trim reaches the limit more"
                f" than once; higher limits are flown every {100 * FINE:g} to {100 * STRIDE:g} %,"
                " and one between these may be lost"
            )
        if count := int(np.sum((below & survive).any(axis=0))):
            notes.append(
                f"of the soundings that fly {count} have a bound of their requirement above the"
                " limit: a flight of the trim law survives with it"
            )
        return replace(bounds, lower=lower, upper=upper), notes

    def _together(
        self, soundings: Soundings, index: IndexArray
    ) -> Iterator[tuple[IndexArray, FloatArray, SoundingWinds]]:
        """Iterate over batches of soundings of about equal length that are marched together.

        `index`: indices of the usable soundings of the archive. Each item holds the indices of a
        batch ``(n,)``, the heights [m] between which its winds, with growth and gust, can be
        judged, ``(n, 2)``, NaN where nowhere, and the winds without these.
        """
        index = index[np.argsort(soundings.counts[index], kind="stable")]  # by number of levels
        together = SoundingWinds.of(soundings[index], self.path)
        # numbers of breakpoints, levels and heights of the flight, up to and with each sounding
        ends = np.cumsum(np.diff(together.offsets) + self.path.height.size)
        cuts = np.arange(_MAX_LEVELS_PER_MARCH, ends.max(initial=0), _MAX_LEVELS_PER_MARCH)
        for batch in filter(np.size, np.split(np.arange(index.size), np.searchsorted(ends, cuts))):
            winds = together.select(batch)
            yield index[batch], winds.linear_heights(self.path, self.additions.strongest), winds

    def _unjudged(self, soundings: Soundings) -> dict[str, BoolArray]:
        """Return whether a reason not to judge n soundings holds, ``(n,)``, by the reason.

        They end below, or begin above, the height of the largest dynamic pressure, or end below the
        height `known_to` [m] to which a sounding must go, where it is given.
        """
        bottom, top = np.full((2, len(soundings)), np.nan)  # [m]; NaN without a level
        full = soundings.counts > 0
        bottom[full] = soundings.height[soundings.offsets[:-1][full]]
        top[full] = soundings.height[soundings.offsets[1:][full] - 1]
        max_q = self.path.max_q  # height [m] of the largest dynamic pressure
        with np.errstate(invalid="ignore"):
            reasons = {TOO_LOW: top < max_q, TOO_HIGH: bottom > max_q}
            if self.known_to is not None:
                reasons[TOO_SHORT] = top < self.known_to
        return reasons

    def _bounds_of_unknown(
        self, winds: SoundingWinds, within: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
        """Return bounds of required deflections [rad], and whether unknown winds leave them alike.

        The bounds are the lower, the upper, and the lowest limit with which a flight may survive.
        All are ``(a, n)``, a azimuths and n winds. In gaps and beyond its levels a sounding is
        taken as calm, and as the strongest wind that counts; the bounds cover both. Where both
        require the same the unknown wind does not matter, and counts as known. `within`: heights
        [m] between which winds are judged, ``(n, 2)``.
        """
        lower, upper, lowest = self._bounds(winds, within)
        wind_known = np.ones(lower.shape, dtype=bool)
        partly = np.flatnonzero(winds.incomplete(self.path))
        if partly.size:
            calm = lower[:, partly]
            strong, higher, _ = self._bounds(winds.select(partly), within[partly], strong=True)
            wind_known[:, partly] = np.abs(strong - calm) <= _KNOWN_TOLERANCE * strong
            lower[:, partly] = np.minimum(calm, strong)
            upper[:, partly] = np.maximum(upper[:, partly], higher)
        return lower, upper, lowest, wind_known

    def _bounds(
        self, soundings: SoundingWinds, within: FloatArray, strong: bool = False
    ) -> FloatArray:
        """Return bounds of the required deflections [rad] of n winds in a azimuths, ``(3, a, n)``.

        Rows: lower bound by theory, upper bound, and the lowest limit with which a flight of the
        trim law may survive. Where trim reaches a limit more than once that is below the first row.
        The limit shape combines both planes. `within`: heights [m] between which the winds of
        `soundings` are judged, ``(n, 2)``. `strong`: whether a wind that is not known is strong, or
        calm.
        """
        towards = []  # one array (3, n) for each azimuth
        for a in range(self.azimuths.size):
            in_planes = [  # by index of a plane, for each wind in it that must be survived
                (p, np.stack([winds.bounds.lower, winds.bounds.upper, winds.bounds.lowest]))
                for p, winds in self._marched(soundings, within, a, strong)
            ]
            towards.append(self._in_planes(in_planes, (3, within.shape[0])))
        return np.stack(towards, axis=1)

    def _in_planes(
        self, in_planes: list[tuple[int, FloatArray]], shape: tuple[int, ...] = ()
    ) -> FloatArray:
        """Return the required deflections [rad] of the limit shape, from single planes.

        `in_planes`: pairs of the index of a plane and its required deflections [rad], each of one
        shape; of several in a plane the largest counts. `shape`: this shape if there are none. A
        square limit shape requires the largest of its planes, a round one the root of the sum of
        squares.
        """
        shapes = [required.shape for _, required in in_planes] or [shape]
        planes = np.zeros((len(self.planes), *shapes[0]))
        for p, required in in_planes:
            np.maximum(planes[p], required, out=planes[p])
        return planes.max(axis=0) if self.limit_shape == "square" else np.hypot.reduce(planes)

    def _survive(self, marched: list[tuple[int, MarchedWinds]], limit: float) -> BoolArray:
        """Return whether flights survive with a limit [rad] and with all above it, ``(n,)``.

        `marched`: pairs of the index of a plane, and winds of n soundings in it, all of which must
        be survived. With a round limit shape each plane has a share of the limit, in the ratio of
        the lower bounds of their requirements. Bounds decide first; a flight is flown only where
        they do not, and no other wind of the sounding is insufficient.
        """
        _, first_winds = marched[0]
        lower = np.zeros((len(self.planes), *first_winds.bounds.lower.shape))  # by plane
        for p, winds in marched:
            np.maximum(lower[p], winds.bounds.lower, out=lower[p])
        size, share = np.hypot.reduce(lower), np.ones(lower.shape)
        if self.limit_shape == "round":
            np.divide(lower, size, out=share, where=size > 0.0)
        limits, survives = share * limit, np.ones(size.shape, dtype=bool)
        undecided_winds = []
        for p, winds in marched:
            undecided, insufficient = winds.undecided(limits[p])
            survives &= ~insufficient
            undecided_winds.append((winds, limits[p], undecided))
        for winds, limits_of_plane, undecided in undecided_winds:
            cases = np.flatnonzero(undecided & survives)
            if cases.size:
                survives[cases] = winds.survive(limits_of_plane, cases)
        return survives

    def _marched(
        self, soundings: SoundingWinds, within: FloatArray, a: int, strong: bool = False
    ) -> Iterator[tuple[int, MarchedWinds]]:
        """Iterate over pairs of a plane's index and winds there, which n flights must survive.

        Each pair has a wind for each of n soundings, with bounds of its requirement. There is one
        for each sign of `additions` (growth until launch, gust) and each time of the gust.

        `within`: heights [m] between which soundings are judged, ``(n, 2)``. `a`: index of the
        azimuth. `strong`: whether a wind that is not known is strong, or calm.
        """
        azimuth, path = float(self.azimuths[a]), self.judged_path
        first, last = path.height[[0, -1]]
        low, high = np.clip(within, first, last).T[..., np.newaxis]  # (n, 1) each
        height = np.clip(soundings.breakpoints(path, strong), low, high)
        speeds = {  # calm where nothing of the interval is judged
            plane: (low < high) * soundings.interpolated(soundings.wind(azimuth, plane), height)
            for plane in PLANES
        }
        along = PolylineWinds(np.interp(height, path.height, path.time), speeds)
        for plane, march in self.marches.items():
            p = self.planes.index(plane)
            for sign, winds in self._of_signs(along, plane, soundings, height, strong):
                for with_gust in march.with_gusts(winds, sign, self.additions):
                    yield p, MarchedWinds(march, with_gust, march.bounds(with_gust))

    def _of_signs(
        self,
        along: PolylineWinds,
        plane: str,
        soundings: SoundingWinds,
        height: FloatArray,
        strong: bool,
    ) -> Iterator[tuple[float, PolylineWinds]]:
        """Iterate over signs, 1 and -1, each with the winds that are judged for it.

        In `plane` the growth until launch is added with this sign; with `strong` a wind that is not
        known is the fastest possible one of this sign, else calm. Where nothing is added, one sign
        stands for both. `along`: winds of `soundings` at heights `height` [m], ``(n, k)``; a
        sounding that has nothing to judge has one height throughout, and stays calm.
        """
        if not strong and self.additions.symmetric:
            yield 1.0, along
            return
        wind, growth = along.speeds[plane], self.additions.grown(height)  # [m/s]
        unknown, size = np.zeros(height.shape, dtype=bool), wind
        if strong:
            unknown = soundings.unknown(height)
            size = np.maximum(np.abs(wind), self.path.fastest_wind(height))
        judged = np.ptp(height, axis=1, keepdims=True) > 0.0
        for sign in (1.0, -1.0):
            speed = judged * (np.where(unknown, sign * size, wind) + sign * growth)
            yield sign, PolylineWinds(along.times, along.speeds | {plane: speed})


@lru_cache(maxsize=8)
def _judged_interval(
    flight: FlightSchedule, model: str, planes: tuple[str, ...], pressure: bool
) -> tuple[FlightPath, dict[str, PlaneMarch]]:
    """Return the judged interval of a flight, up to the last one with an unstable mode.

    With its equations by plane. `model`: its linear model. `planes`: planes of the motion, of which
    the later end counts. `pressure`: whether winds count with the dynamic pressure that they cause.
    Without an unstable mode it is the whole flight, and no plane has equations to march winds
    along. Both planes take the time steps of the plane with the fastest mode. Cached by its
    arguments.
    """
    modes = [FlightMode(flight, model, plane, flight.span) for plane in planes]
    # flights up to the end of their last interval with an unstable mode, by plane
    unstable = [mode.until_stable for mode in modes if mode.unstable]
    if not unstable:
        return FlightPath.of(flight, pressure), {}
    judged = max((mode.schedule for mode in unstable), key=lambda schedule: schedule.span[1])
    motions = [FlightMode(judged, model, mode.plane, judged.span) for mode in unstable]
    fastest = max(motions, key=lambda motion: motion.fastest.max())
    path = FlightPath.of(judged, pressure)
    return path, {mode.plane: PlaneMarch(path, mode.plane, mode, fastest) for mode in motions}
