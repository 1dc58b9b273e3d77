"""Specification of gains for the minimum deflection, and the limits that rows of gains require.

Limits are found by flights, only as accurately as the search requires. A row is flown with
falling limits until a flight diverges, so that the highest limit that diverges counts, as in
`closed_loop_boundary`. A row with a loss above the goal is not bracketed any closer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial, reduce
from operator import add
from typing import Any

import numpy as np

from tvclin.base import errors
from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.base.fields import checked, quantity
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.design_rules import GIVEN_GAINS
from tvclin.control.autopilot.feedback import CHAINS
from tvclin.control.margins.bands import band_margins
from tvclin.control.margins.criteria import Criteria, Judgement
from tvclin.control.margins.margins import Margins, margins_of
from tvclin.flights.closed_loop.checks import check_sample_rate
from tvclin.flights.closed_loop.fly_many import MAX_DEFLECTION_LIMIT, SURVIVED, fly_many
from tvclin.linear.flexible import AnyPlant, FlexiblePlant, check_plant, named_modes
from tvclin.vehicle.filters import Filter
from tvclin.winds.histories import History

FREE_GAINS = (("attitude", "rate"), ("attitude", "rate", "alpha"))
"""Combinations of free gains."""
CROSSOVER = "crossover"
"""Name of the upper limit of the gain crossover."""
UNSATISFIED_COST = 10.0
"""Cost of gains that miss a criterion, to which the relative shortfall is added."""
_UNSTABLE = 100.0
"""Relative shortfall of an unstable loop, larger than of any stable loop."""
_FLOWN_RATE = 100.0
"""Sample rate of flights [Hz] of an autopilot without one."""
_MIN_STIFFNESS, _MIN_RATE = 1.01, 0.05
"""Smallest (a0 + b0)/B and a1 beta/B of the search range."""


@dataclass(frozen=True, eq=False, kw_only=True)
class GainProblem:
    """A plant, its winds and nozzle, and the required margins of its autopilot.

    The attributes are the arguments of `minimum_deflection_gains`.
    """

    plant: AnyPlant
    winds: tuple[History, ...]
    criteria: Criteria
    gains: Sequence[str]
    actuator: Actuator | None
    delay: float = quantity("delay", check=errors.nonnegative)
    crossover: float | None = quantity("natural frequency", None, errors.positive)
    filters: tuple[Filter, ...]
    attitude_filters: tuple[Filter, ...] = ()
    rate_filters: tuple[Filter, ...] = ()
    limits: bool
    stops: int
    sample_rate: float | None = quantity("sample rate", None, errors.positive)

    def __post_init__(self) -> None:
        """Check plant, winds, criteria, free gains and nozzle, and that a minimum exists."""
        check_plant(self.plant)
        errors.single("plant", self.plant.batch)
        object.__setattr__(self, "winds", _checked_winds(self.winds))
        errors.instance("criteria", self.criteria, Criteria, 'such as CRITERIA["classic"]')
        names = self.gains if isinstance(self.gains, list | tuple) else ()
        free = tuple(name for name in names if isinstance(name, str))
        if free not in FREE_GAINS or len(free) < len(names):
            raise errors.InputError(
                f"gains must be {' or '.join(map(str, FREE_GAINS))}: those that are free, in"
                " this order;"
                f" got {errors.shown(self.gains)}"
            )
        object.__setattr__(self, "gains", free)
        if not isinstance(self.actuator, Actuator | None):
            raise errors.InputError(
                f"actuator must be an Actuator or None; got {errors.shown(self.actuator)}"
            )
        errors.single("actuator", () if self.actuator is None else self.actuator.batch)
        checked(self)  # delay, crossover and sample rate
        if errors.flag("limits", self.limits):
            check_sample_rate(self.flown_rate, self.actuator)
        if errors.whole_number("stops", self.stops) and not self.limits:
            raise errors.InputError(
                "stops are sudden ends of a wind in flights with a limit: give limits=True with"
                " them, or stops=0"
            )
        mu_alpha = float(self.plant.coefficients.mu_alpha)
        if mu_alpha <= 0.0:
            raise errors.InputError(
                "gains for the minimum deflection are sought for an aerodynamically unstable"
                " vehicle,"
                f" mu_alpha > 0; got {mu_alpha:.6g} 1/s^2 (a stable vehicle requires no deflection)"
            )
        if not np.isfinite(self.fastest):
            raise errors.InputError(
                "without actuator, delay and crossover the gains for the least deflection are"
                " infinite: give one of these"
            )
        # the autopilot in the middle of the search range checks actuator, delay and filters
        _ = self.autopilot(np.full((1, len(free)), 0.5))

    @property
    def chains(self) -> dict[str, Any]:
        """Filters of command, attitude and rate by the names of their fields in `Autopilot`."""
        return {name: getattr(self, name) for name in CHAINS}

    @property
    def has_alpha(self) -> bool:
        """Whether the gain on the angle of attack is free, the third."""
        return "alpha" in self.gains

    @property
    def flown_rate(self) -> float:
        """The sample rate of flights [Hz]."""
        return self.sample_rate or _FLOWN_RATE

    @property
    def fastest(self) -> float:
        """Largest useful frequency [rad/s]: the lowest of crossover limit, actuator and delay."""
        frequencies = [np.inf if self.crossover is None else self.crossover]
        if self.actuator is not None:
            frequencies.append(float(np.max(self.actuator.natural_frequency)))
        if self.delay:
            frequencies.append(0.5 * np.pi / self.delay)  # with 90 degrees of lag
        return min(frequencies)

    @property
    def trims(self) -> FloatArray:
        """Trim deflections [rad] at each wind's peak, ``(winds,)``; B: trim over wind angle."""
        peaks = [float(wind.peak) for wind in self.winds]
        return np.abs(float(self.plant.coefficients.B) * np.array(peaks))

    @property
    def names(self) -> list[str]:
        """Names of the winds, by peak and duration."""
        return [
            f"wind of {np.degrees(float(w.peak)):.3g} deg, {float(w.end - w.onset):.3g} s"
            for w in self.winds
        ]

    def autopilot(self, points: FloatArray) -> Autopilot:
        """Return the autopilots at points of the unit box, ``(..., axes)``.

        The axes are log (a0 + b0)/B, log a1 beta/B, and b0/(a0 + b0) where alpha is free. a0, a1
        and b0 are the gains on attitude, its rate and angle of attack, B is the trim deflection per
        angle of attack, and beta [1/s] the unstable pole on a fixed path.
        """
        B, beta, (stiffest, fastest) = self._scales  # largest (a0 + b0)/B and a1 beta/B
        stiffness = _MIN_STIFFNESS * (stiffest / _MIN_STIFFNESS) ** points[..., 0]
        rate = _MIN_RATE * (fastest / _MIN_RATE) ** points[..., 1]
        share = points[..., 2] if self.has_alpha else np.zeros(points.shape[:-1])
        return Autopilot(
            attitude_gain=B * stiffness * (1.0 - share),
            rate_gain=B / beta * rate,
            alpha_gain=B * stiffness * share,
            actuator=self.actuator,
            delay=self.delay,
            sample_rate=self.sample_rate,
            **self.chains,
        )

    def point(self, autopilot: Autopilot) -> FloatArray:
        """Return the point of the gains of an autopilot in the unit box, ``(axes,)``.

        The inverse of `autopilot`: axes are log (a0 + b0)/B, log a1 beta/B and b0/(a0 + b0), of the
        gains a0, a1 and b0 on attitude, rate and angle of attack. Gains beyond the search range are
        moved to its edge; `_scales` has B, the trim deflection per angle of attack, beta =
        sqrt(mu_alpha) [1/s], and the largest two of these ratios.
        """
        B, beta, (stiffest, fastest) = self._scales  # largest (a0 + b0)/B and a1 beta/B
        a0, a1, b0 = (float(getattr(autopilot, name)) for name in GIVEN_GAINS)
        stiffness, rate = (a0 + b0) / B / _MIN_STIFFNESS, a1 * beta / B / _MIN_RATE
        axes = [
            np.log(stiffness) / np.log(stiffest / _MIN_STIFFNESS),
            np.log(rate) / np.log(fastest / _MIN_RATE),
            b0 / (a0 + b0),
        ]
        return np.clip(axes[: len(self.gains)], 0.0, 1.0)

    @property
    def _scales(self) -> tuple[float, float, tuple[float, float]]:
        """B, beta [1/s], and the largest (a0 + b0)/B and a1 beta/B of the search range.

        B is trim deflection per angle of attack, beta the unstable pole on a fixed path. The gains
        are a0 on attitude, a1 on its rate, b0 on the angle of attack. Poles of a natural
        frequency w and a damping ratio of 1 take 1 + (w/beta)^2 and 2 w/beta; w is `fastest`, the
        largest useful frequency, and the first may be half as much again.
        """
        c = self.plant.coefficients
        beta = float(np.sqrt(c.mu_alpha))
        frequency_ratio = max(self.fastest / beta, 2.0)  # w/beta; 2 keeps a range to search
        return float(c.B), beta, (1.5 * (1.0 + frequency_ratio**2), 2.0 * frequency_ratio)

    @property
    def search_range(self) -> str:
        """Range of the gains that are sought, as "a0 from 0.1 to 3, a1 from 0.01 to 2 s"."""
        B, beta, (stiffest, fastest) = self._scales  # largest (a0 + b0)/B and a1 beta/B
        name, scale = "a0 + b0" if self.has_alpha else "a0", B / beta  # of the rate gain [s]
        return (
            f"{name} from {B * _MIN_STIFFNESS:.3g} to {B * stiffest:.3g}, a1 from"
            f" {scale * _MIN_RATE:.3g} to {scale * fastest:.3g} s"
        )

    def shortfalls(self, points: FloatArray) -> FloatArray:
        """Return the largest relative shortfall of a required margin, by row of gains, ``(n,)``.

        Zero or negative where all criteria are satisfied, 100 for an unstable loop. `points`: gains
        in the unit box, ``(n, axes)``. Margins of modes count only for rows that satisfy all else.
        """
        rows = self.autopilot(points)
        loop = rows.exact_loop(self.plant)
        # delay margins, which take longer, where a criterion limits them
        margins = margins_of(loop.analysis(delays=self.criteria.has_delay_limit), loop)
        fractions = [np.full(len(points), -np.inf)]
        fractions += [-judged.relative_surplus for judged in self.judge_loop(margins)]
        if self.crossover is not None:  # upper limit of the gain crossover [rad/s]
            with np.errstate(over="ignore"):  # with a denormal crossover
                fractions.append(highest_crossover(margins) / self.crossover - 1.0)
        worst = np.max(np.nan_to_num(fractions, nan=_UNSTABLE), axis=0)
        shortfalls = np.where(margins.stable, worst, _UNSTABLE)
        good = np.flatnonzero(shortfalls <= 0.0)
        if self.plant.structure is not None and good.size and self.criteria.has_mode_limits:
            shortfalls[good] = np.maximum(shortfalls[good], self._mode_shortfalls(points[good]))
        return np.asarray(shortfalls)

    def judge_loop(self, margins: Margins) -> tuple[Judgement, ...]:
        """Return the judgements of `margins` of the whole loop, not of its modes."""
        criteria = self.criteria.without_mode_limits
        return () if criteria is None else criteria.judge(margins)

    def _mode_shortfalls(self, points: FloatArray) -> FloatArray:
        """Return the largest relative shortfall of the margins of modes, by row of gains, ``(n,)``.

        Negative where all criteria of modes are satisfied. `points`: gains in the unit box,
        ``(n, axes)``.
        """
        assert isinstance(self.plant, FlexiblePlant)
        loop = self.autopilot(points).exact_loop(self.plant)
        # the loop has its delay, but its delay margins are not computed: no criterion of a mode
        # limits them, and they are most of the work
        bands = band_margins(loop, *named_modes(self.plant), delays=False)
        worst = np.full(len(points), -np.inf)
        for judged in self.criteria.judge(bands):
            if judged.band:  # of a mode
                worst = np.maximum(worst, np.nan_to_num(-judged.relative_surplus, nan=_UNSTABLE))
        return worst


def _checked_winds(winds: Any) -> tuple[History, ...]:
    """Return `winds` as a tuple; `InputError` for none, a batch, and one without an end or peak."""
    checked = errors.each("winds", winds, History, "such as TriangularWind")
    if not checked:
        raise errors.InputError("winds must be one or more; got none")
    for wind in checked:
        errors.single("wind", wind.batch)
        errors.ending("wind", wind.end)
        errors.number("the peak of a wind", abs(float(wind.peak)), errors.positive, "rad")
    return checked


def highest_crossover(margins: Margins) -> FloatArray:
    """Return the highest gain crossover [rad/s] of n loops with `margins`, ``(n,)``; or zero."""
    frequencies = np.nan_to_num(margins.crossings.gain_frequencies, nan=0.0)
    return np.asarray(np.max(frequencies, axis=-1, initial=0.0))


_MAX_LIMIT_RATIO, _MIN_LIMIT_RATIO = 2.0, 0.02
"""Range of limits, normalised by the largest trim deflection; same as `closed_loop_boundary`."""
_LIMIT_RATIO = 0.9
"""Ratio of each falling limit to the limit before it."""
_LIMITS_PER_FLIGHT = 4
"""Number of falling limits that are flown together."""
_SUBDIVISIONS, _REFINEMENTS = 8, 3
"""Parts of a bracket of the boundary, and number of subdivisions: to 1/512 of the last step."""
_MAX_SCAN_RATIO = 1.5
"""End of the scan for windows of losses, as a ratio to the required limit."""


def with_sudden_ends(winds: tuple[History, ...], stops: int) -> History:
    """Return a batch of winds: each complete, and with `stops` sudden ends at even instants.

    The batch is flat, ``(winds * (stops + 1),)``. `winds`: one history each. The instants divide
    the time from the onset of a wind to its end, and after each of them the wind is zero.
    """
    # the sum is the batch of the winds: each times its unit row, zero in the others' places
    rows = zip(winds, np.eye(len(winds)), strict=True)
    combined = reduce(add, (wind * row for wind, row in rows))
    # (stops + 1, winds): sudden ends, and last the end itself, of the complete wind
    times = np.linspace(combined.onset, combined.end, stops + 2)[1:]
    return combined.before(times).cases(np.arange(times.size), times.shape)


def required_limits(
    problem: GainProblem, points: FloatArray, goal: float, scan_count: int
) -> FloatArray:
    """Return the limit that each row of gains requires, normalised by the largest trim, ``(n,)``.

    From that limit on, up to 1.5 times it, all that are flown survive. `problem`: plant, winds and
    nozzle. `points`: gains in the unit box, ``(n, axes)``. `goal`: limit above which no accuracy is
    needed; a row that diverges above it is not refined. `scan_count`: number of limits above the
    required limit that are flown as well, because windows of losses lie there. Infinite for a row
    that diverges with the largest limit, twice the trim.
    """
    rows, winds = problem.autopilot(points), with_sudden_ends(problem.winds, problem.stops)
    survive = partial(_survive, problem, rows, winds)
    steps = int(np.ceil(np.log(_MIN_LIMIT_RATIO / _MAX_LIMIT_RATIO) / np.log(_LIMIT_RATIO)))
    falling = _MAX_LIMIT_RATIO * _LIMIT_RATIO ** np.arange(steps + 1)
    # Each row is flown with falling limits until it diverges, at first with all down to the goal.
    # `diverged`: the first limit that diverges; `survived`: the limit before it.
    diverged, survived = np.full(len(points), np.inf), np.full(len(points), np.inf)
    open_rows, first = np.arange(len(points)), 0
    size = max(_LIMITS_PER_FLIGHT, int(np.sum(falling > goal)) + 1)
    while open_rows.size and first < falling.size:
        limits = falling[first : first + size]
        outcome = survive(open_rows, np.tile(limits, (open_rows.size, 1)))
        # Index of the first limit that diverges, or their number.
        at = np.where(outcome.all(axis=1), limits.size, np.argmin(outcome, axis=1))
        survived[open_rows] = np.where(at > 0, limits[at - 1], survived[open_rows])
        ends = at < limits.size
        diverged[open_rows[ends]] = limits[at[ends]]
        open_rows, first, size = open_rows[~ends], first + size, _LIMITS_PER_FLIGHT
    survived[open_rows] = diverged[open_rows] = falling[-1]  # the lowest limit is sufficient
    # Brackets below the goal are subdivided.
    bracketed = np.flatnonzero(np.isfinite(survived) & (diverged < goal) & (diverged < survived))
    for _ in range(_REFINEMENTS if bracketed.size else 0):
        brackets = np.linspace(survived[bracketed], diverged[bracketed], _SUBDIVISIONS + 1, axis=1)
        outcome = survive(bracketed, brackets[:, 1:-1])
        at = np.where(outcome.all(axis=1), _SUBDIVISIONS - 1, np.argmin(outcome, axis=1))
        survived[bracketed], diverged[bracketed] = (
            np.take_along_axis(brackets, (at + k)[:, np.newaxis], axis=1)[:, 0] for k in (0, 1)
        )
    # A higher limit that diverges raises the requirement to the next limit of the scan.
    candidates = np.flatnonzero(survived < goal)
    if candidates.size:
        scan = survived[candidates, np.newaxis] * np.linspace(1.0, _MAX_SCAN_RATIO, scan_count + 1)
        lossy = ~survive(candidates, scan)
        highest = scan_count - np.argmax(lossy[:, ::-1], axis=1)
        above = scan[np.arange(candidates.size), np.minimum(highest + 1, scan_count)]
        survived[candidates] = np.where(lossy.any(axis=1), above, survived[candidates])
    return survived


def _survive(
    problem: GainProblem, rows: Autopilot, winds: History, which: IndexArray, limits: FloatArray
) -> BoolArray:
    """Return whether rows of gains survive all winds with limits normalised by trim, ``(k, n)``.

    `problem`: plant, nozzle, and `trims`, the largest trim deflection [rad] in each wind; `chains`
    are its filters. `rows`: autopilots of all rows, ``(m,)``. `winds`: batch of winds.
    `which`: indices of k of the rows. `limits`: n for each of these rows, ``(k, n)``, over the
    largest trim deflection of the winds.
    """
    # Axes of a flight: row of gains, limit, wind.
    gains = {name: getattr(rows, name)[which, np.newaxis, np.newaxis] for name in GIVEN_GAINS}
    deflection_limits = limits[..., np.newaxis] * problem.trims.max()
    flown = fly_many(
        problem.plant,
        Autopilot(**gains, **problem.chains),
        winds,
        deflection_limit=np.minimum(deflection_limits, MAX_DEFLECTION_LIMIT),
        actuator=problem.actuator,
        sample_rate=problem.flown_rate,
        delay=problem.delay,
    )
    return np.all(flown.status == SURVIVED, axis=-1)
