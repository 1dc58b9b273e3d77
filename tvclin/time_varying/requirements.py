"""Requirements of vehicles whose equations vary over a wind, from two curves: trim and demand.

    x' = A x + b delta + w alpha_w

varies with time since the flight goes on, since the dynamic pressure encountered differs from the
nominal one, or not at all. With the costate p, p' = -A^T p, that is the left eigenvector of the
fastest unstable mode at the end of the wind, the unstable component p.x obeys

    p(T).x(T) = p.x + F + R delta,    F = integral of p.w alpha_w dt,  R = integral of p.b dt,

for a deflection held from t on. Under ideal trim up to t the deflection limit that is sufficient
when it is held from t on is demand(t) = -(p.x + F)/R, beside trim(t) itself
(`kernels.trim_and_demand`). `time_varying.curves` reads from both what a control with a dead band
requires; with one unstable mode, and while p.b keeps its sign, the demand at the onset is the
minimum peak of all control. Else that is at least ``|p.x + F|`` over the integral of ``|p.b|``.

With several unstable modes no control needs less than the minimum over all of them
(`minimum_peaks`), from the onset on and, for 0 < K < 1, from the exit of the dead band on.

Required with K = 1 is the smallest limit from which on every limit survives, for the ideal trim law
in the wind as it is, with both its signs. The largest min(trim, demand) is sufficient on a fixed
path, and where trim meets the limit once and the path is slow; it is required as long as trim meets
it to one side alone, and mu_alpha keeps its sign. Else the limited law itself is flown
(`SteppedWinds`) with many limits, through the wind and the calm after it, and what is required
lies above all of them with which a flight diverges.

The error of the curves is of fourth order in the steps, below 1e-6 of the largest trim at the
`STEP` of `time_varying.steps`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.kernels import trim_and_demand as marches
from tvclin.kernels.choice import repeated, run
from tvclin.time_varying.curves import Curves, at_substeps
from tvclin.time_varying.equations import Equations, minimum_peaks
from tvclin.time_varying.steps import (
    MAX_STEPS,
    Encounter,
    Motion,
    encountered_at_steps,
    step_counts,
    steps_after,
    with_calm_after,
)
from tvclin.winds.wind_angles import MAX_LINEAR_ANGLE, EncounteredWind, NominalWind

FLIGHT_SUBSTEPS = 4
"""Number of substeps in flights of the limited law, whose feedback is ten times as fast."""
_FEEDBACK_OVER_TRIM = 10.0
"""Ratio of attitude feedback to trim of the ideal trim law, same as in `TrimLaw`. A stiffer law may
survive with a percent less in a wind that changes sign on a quick path."""
_FLIGHT_MARGIN = 1.005
"""Ratio of the limit of a flight to the limit of both curves, to show that this is sufficient."""
_MIN_RATIO_BOTH_SIGNS, _MIN_RATIO_TWO_INTERVALS = 0.5, 0.9
"""Smallest limits of flights over the largest min(trim, demand), where trim reaches that with both
signs (with less the attitude leaves the linear range), or more than once as the path drifts."""
_MIN_RATIO_SIGN_CHANGE = 0.01
"""Smallest limit of flights over the largest trim, where mu_alpha changes its sign."""
_HIGHER_LIMITS = (1.0, 10.0, 100.0)
"""Highest limits of flights, over that of the wind: trim after it may be larger where mu_alpha
changes its sign, or two unstable modes are a pair for a while."""
_MIN_LIMIT = 1e-12
"""Smallest limit of a flight [rad], in place of zero."""
MAX_BATCH_STEPS = 5_000
"""Largest number of steps of the winds of a batch: some ten megabytes."""
_LIMITS_MULTIPLE = 4
"""Multiple to which the number of limits is rounded, so that many winds have the same."""


@dataclass(frozen=True, eq=False)
class VaryingRequirement:
    """Required deflections [rad] of winds for vehicles with varying equations, as sizes ``(n,)``.

    Attributes
    ----------
    trim : ndarray
        Trim along the path: the largest deflection of ideal trim, with drift.
    required : ndarray
        Required deflection at the dead band; zero without an unstable mode, NaN with K < 1 for a
        wind that changes its sign. The largest trim over K where a pair alone is unstable, and with
        K < 1 where modes are a pair for a while, or mu_alpha or the effect of a deflection changes
        its sign: a constant limit may then drive the vehicle to either side.
    minimum : ndarray
        Lower bound with the wind known: no control needs less.
    fastest_minimum : ndarray
        Lower bound by the fastest unstable mode alone; zero where its demand at the onset is none.
    time : ndarray
        Time [s] at which trim leaves the dead band with the required deflection as the limit.
    """

    trim: FloatArray
    required: FloatArray
    minimum: FloatArray
    fastest_minimum: FloatArray
    time: FloatArray


def varying_requirement(
    motion: Motion,
    encountered: Encounter | Sequence[Encounter],
    dead_band: float = 1.0,
    *,
    parts: float = 1.0,
    flights: bool = True,
) -> VaryingRequirement:
    """Return trim, required deflection at a dead band K and lower bound [rad] of n winds, ``(n,)``.

    Trim and demand are curves over time: the deflection of ideal trim, and the deflection limit
    that is sufficient when it is held from then on.

    Parameters
    ----------
    motion : Equations or FlightMode
        Equations of a vehicle, or of a vehicle for each wind.
    encountered : EncounteredWind, NominalWind, FlightWind or sequence of these
        A wind, a batch of winds, or a sequence of winds with the same number of steps.
    dead_band : float
        K in [0, 1]: the fraction of the limit up to which the vehicle is trimmed.
    parts : float
        Number of substeps of each step; below one for longer steps.
    flights : bool
        Whether the limited law is flown where flights decide; else the curves' limit counts.
    """
    if not isinstance(encountered, Sequence) and np.all(np.isinf(encountered.history.onset)):
        zero = np.zeros(np.broadcast_shapes(np.shape(encountered.history.onset), (1,)))
        unknown_time = np.full(zero.shape, np.nan)
        return VaryingRequirement(zero, zero, minimum=zero, fastest_minimum=zero, time=unknown_time)
    times, wind, ratio = encountered_at_steps(motion, encountered, parts)
    winds = SteppedWinds(motion.at_steps(times), times, wind, ratio)
    equations, trim_and_demand = winds.equations, winds.curves()
    trim = trim_and_demand.largest_trim
    has_real_mode = np.broadcast_to(equations.has_real_mode, trim.shape)
    # the demand at the onset bounds every control from below, unless the effect of a deflection
    # on the real mode `reverses`; then the minimum peaks alone do
    demand_bounds = has_real_mode & ~equations.reverses
    fastest_minimum = np.where(demand_bounds, np.abs(trim_and_demand.onset_demand), 0.0)
    # minimum peaks of any control from the onset on; for K < 1 the limit with which the vehicle
    # survives if trim leaves the dead band at K times it, and the time of this exit
    peaks, limit, time = _peaks_and_exits(winds, trim_and_demand, dead_band)
    minimum = np.maximum(fastest_minimum, peaks)
    # the limit with which trim never exits the dead band: no more is required
    trim_over_band = trim / dead_band if dead_band > 0.0 else np.full(trim.shape, np.inf)
    # it is required where a constant limit may drive the vehicle in either direction: unstable
    # modes are a pair at any step, or the moment or the effect of the deflection changes its sign
    without_exit = np.any(equations.paired, axis=(1, 2)) | equations.reverses
    within_dead_band = np.where(without_exit & (trim > 0.0), trim_over_band, 0.0)
    if dead_band == 1.0:
        paired = np.broadcast_to(equations.paired, trim_and_demand.trim.shape)
        limit, time = trim_and_demand.limit_of_trim_law(paired)
        required = np.maximum(limit, minimum)
        if flights:
            required = _required_by_flights(
                motion, winds, encountered, trim_and_demand, limit, minimum
            )
    else:
        required = np.minimum(np.maximum(limit, within_dead_band), trim_over_band)
        required = np.maximum(required, minimum)
    required = np.where(has_real_mode, required, within_dead_band)  # a pair alone, or stable
    required = np.where(np.isnan(trim), np.nan, required)
    return VaryingRequirement(trim, required, minimum, fastest_minimum, time)


def _peaks_and_exits(
    winds: SteppedWinds, trim_and_demand: Curves, dead_band: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return minimum peaks [rad] of any control, and limits [rad] and times [s] of exits.

    All are ``(n,)``, of n winds: the smallest peak of any control from the onset on, zero where the
    demand bounds it (one unstable mode); and for `dead_band` K < 1 the limit that is required, and
    the time at which trim leaves the dead band; both zero for K = 1. `trim_and_demand`: curves
    of the deflection of trim, and of the limit that is sufficient when held from then on.
    """
    minimum, limit, time = np.zeros((3, len(trim_and_demand.trim)))
    ratios = None  # trim over K [rad], for minimum peaks from an exit with 0 < K < 1 on
    if dead_band < 1.0:
        with np.errstate(divide="ignore", invalid="ignore"):
            limit, time = trim_and_demand.limit_of_dead_band(dead_band)
        if dead_band > 0.0 and winds.equations.modes:
            ratios = trim_and_demand.trim_ratios(dead_band)
    # minimum peaks from the ends of steps on, (k, S + 1), of k cases with equally many modes
    for cases, peaks in winds.peaks_over_modes(trim_and_demand.path, ratios):
        minimum[cases] = np.maximum(minimum[cases], peaks[:, 0])  # from the onset on
        if ratios is None:
            continue
        from_step = np.stack([peaks[:, :-1], peaks[:, 1:]], axis=-1)  # at begin and end of steps
        after, after_time = trim_and_demand.of(cases).limit_with_minimum(from_step, dead_band)
        larger = after > limit[cases]  # not of NaN, a wind of two signs
        limit[cases] = np.where(larger, after, limit[cases])
        time[cases] = np.where(larger, after_time, time[cases])
    return minimum, limit, time


def batch_requirements(
    equations: Equations, encountered: EncounteredWind | NominalWind, dead_band: float
) -> FloatArray:
    """Return the required deflections [rad] of a batch of winds, ``(n,)``.

    `equations`: of n cases, or common to all. `encountered`: winds of the batch, or one.
    `dead_band`: K, from 0 to 1. NaN for a wind that is too long to be followed, and where the
    dynamic pressure is not known. Only winds with the same steps are integrated together, so that
    no case depends on others.
    """
    count = max(len(equations.end), encountered.count)  # number of cases
    _knots, counts = step_counts(encountered.history, equations)
    counts = np.broadcast_to(counts, (count, counts.shape[-1]))
    finite = np.flatnonzero(counts.sum(axis=-1) <= MAX_STEPS)  # not NaN, of a calm
    # the steps of the calm after the wind are a column too: cases of one batch have them in common
    counts = np.insert(counts, 0, steps_after(equations), axis=-1)
    required = np.full(count, np.nan)
    groups, group = np.unique(counts[finite], axis=0, return_inverse=True)
    batches: list[IndexArray] = []
    for k in range(len(groups)):
        same_steps = finite[np.ravel(group) == k]
        batch_size = int(MAX_BATCH_STEPS // groups[k].sum()) + 1
        batches += np.split(same_steps, range(batch_size, same_steps.size, batch_size))
    with repeated(len(batches)):  # similar runs, which decide between compiled and plain code
        for cases in batches:
            batch = equations.of(cases), encountered.of(cases, count)
            required[cases] = varying_requirement(*batch, dead_band).required
    return required


def _required_by_flights(
    motion: Motion,
    winds: SteppedWinds,
    encountered: Encounter | Sequence[Encounter],
    trim_and_demand: Curves,
    limit: FloatArray,
    minimum: FloatArray,
) -> FloatArray:
    """Return the required deflections [rad] with K = 1, ``(n,)``, by flights where these decide.

    `motion`: vehicle, with its equations at any times. `encountered`, `winds`: winds as the vehicle
    encounters them at any times, and over the steps. `limit`: the largest min(trim, demand) [rad]
    of the curves `trim_and_demand`. `minimum`: minimum peaks [rad] of any control.

    Where the curves decide and the path drifts, a single flight confirms the limit, through the
    wind as its parabolas over the steps. A flight that diverges makes flights decide.
    For an aerodynamically stable vehicle with an unstable path the law may not return the path with
    any limit: flights then end with the wind, where the limit must reduce the unstable component.
    """
    equations = winds.equations
    # whether flights decide each requirement, and the lowest limits [rad] that they try
    flown, lowest = decided_by_flights(equations, trim_and_demand, limit)
    finite = np.isfinite(trim_and_demand.onset_demand)
    required = np.maximum(limit, minimum)
    if not np.any(finite & (flown | equations.drifts)):
        return required
    paired = np.any(equations.paired, axis=(1, 2))  # at any begin, middle or end of a step
    confirmed = np.flatnonzero(finite & ~flown & ~paired)
    if equations.drifts and confirmed.size:
        times, wind, ratio = (
            at_substeps(x, FLIGHT_SUBSTEPS) for x in (winds.times, winds.wind, winds.ratio)
        )
        flights = SteppedWinds(motion.at_steps(times), times, wind, ratio)
        tried = _FLIGHT_MARGIN * np.maximum(required, _MIN_LIMIT)[confirmed, np.newaxis]
        flown[confirmed] = flights.diverge(tried, confirmed)[:, 0]
    which = decided = np.flatnonzero(flown & finite)  # winds that flights decide
    if which.size:
        changes = np.broadcast_to(equations.changes_sign, required.shape)
        wind_times, *wind_and_ratio = encountered_at_steps(motion, encountered, FLIGHT_SUBSTEPS)
        times, wind, ratio = with_calm_after(equations, wind_times, *wind_and_ratio)
        flights = SteppedWinds(motion.at_steps(times), times, wind, ratio)
        low, high = np.maximum(lowest, minimum), trim_and_demand.highest_limit
        for factor in _HIGHER_LIMITS:  # up to higher limits, where none so far is sufficient
            required[which] = flights.select(which).requirement(low[which], factor * high[which])
            which = which[np.isinf(required[which]) & (changes | paired)[which]]
        stable = equations.nominal[:, -1, -1, 1, 0] < 0.0  # mu_alpha at the end of the last step
        never = decided[(np.isinf(required) & stable)[decided]]  # no limit is sufficient
        if never.size and wind_times.shape != times.shape:  # again without the calm
            flights = SteppedWinds(motion.at_steps(wind_times), wind_times, *wind_and_ratio)
            required[never] = flights.select(never).requirement(low[never], high[never])
    return required


def decided_by_flights(
    equations: Equations, trim_and_demand: Curves, limit: FloatArray
) -> tuple[BoolArray, FloatArray]:
    """Return whether flights decide the requirement for K = 1, and the lowest limits to try [rad].

    `equations`: of n cases, or common to all. `trim_and_demand`: deflections of trim, and limits
    sufficient when held from then on, over time. `limit`: the largest min(trim, demand) [rad],
    ``(n,)``; the lowest limits are fractions of it, or of trim where mu_alpha changes its sign.
    Flights decide where trim reaches `limit` with both signs, where the path drifts and is quick,
    or trim crosses `limit` more than once, and where mu_alpha, the aerodynamic moment, changes its
    sign: the demand of a constant deflection is no bound then. Where two unstable modes are a pair
    for a while, `limit` counts all of trim then: only trim after the wind may require more.
    """
    two_signs, second_interval = (
        trim_and_demand.reaches_both_signs(limit),
        trim_and_demand.is_crossed_twice(limit) & equations.drifts,
    )
    lowest = np.where(second_interval, _MIN_RATIO_TWO_INTERVALS * limit, limit)
    lowest = np.where(two_signs, _MIN_RATIO_BOTH_SIGNS * limit, lowest)
    changes = np.broadcast_to(equations.changes_sign, limit.shape)
    lowest = np.where(changes, _MIN_RATIO_SIGN_CHANGE * trim_and_demand.largest_trim, lowest)
    quick = equations.quick_path & equations.drifts
    for_a_while = np.any(equations.paired, axis=(1, 2))  # at any begin, middle or end of a step
    lowest = np.where(for_a_while, limit, lowest)
    return two_signs | second_interval | quick | changes, lowest


@dataclass(frozen=True, eq=False)
class SteppedWinds:
    """Winds over steps, and the equations of the vehicles that encounter them.

    Attributes
    ----------
    equations : Equations
        Equations of one vehicle for all winds, or of one for each wind.
    times, wind, ratio : ndarray
        Times [s], wind angles of attack [rad], and dynamic pressure encountered over the nominal
        one, of n winds at begin, middle and end of S steps, ``(n, S, 3)``; times may be common,
        ``(1, S, 3)``. Flights take `FLIGHT_SUBSTEPS` times as many steps as trim and demand do.
    onset : ndarray, optional
        Position at which each wind begins, in steps, ``(n,)``: with 2.3 it begins in the third
        step, whose times begin there. Zero by default.
    """

    equations: Equations
    times: FloatArray
    wind: FloatArray
    ratio: FloatArray
    onset: FloatArray | None = None

    def select(self, cases: IndexArray) -> SteppedWinds:
        """Return the winds with the indices `cases`, with their equations."""
        equations = self.equations if len(self.equations.end) == 1 else self.equations.of(cases)
        times = self.times if len(self.times) == 1 else self.times[cases]
        onset = None if self.onset is None else self.onset[cases]
        return SteppedWinds(equations, times, self.wind[cases], self.ratio[cases], onset)

    def _for_kernels(self) -> tuple[marches.VaryingSteps, FloatArray, FloatArray]:
        """Return the arguments that the kernels of the limited and the unlimited trim both take.

        They are steps with equations and winds; costate of the fastest unstable mode and control
        reach, the effect on it of a unit deflection after the steps, ``(n, m + 1)``; positions of
        onsets, in steps, ``(n,)``. All are contiguous.
        """
        cases, steps, _ = self.wind.shape
        end = np.broadcast_to(self.equations.end, (cases, self.equations.end.shape[-1]))
        onset = np.zeros(cases) if self.onset is None else self.onset
        columns = marches.VaryingSteps(
            lengths=np.broadcast_to(self.times[..., 2] - self.times[..., 0], (cases, steps)),
            equations=self.equations.nominal,
            slopes=self.equations.slopes,
            ratio=self.ratio,
            wind=self.wind,
        )
        *arrays, end, onset = (np.require(x, float, ["C", "W"]) for x in (*columns, end, onset))
        return marches.VaryingSteps(*arrays), end, onset

    def curves(self) -> Curves:
        """Return trim and demand [rad] of n winds over their S steps, ``(n, S, 3)`` each.

        They are at begin, middle and end. The demand is the deflection limit that is sufficient
        when it is held from then on. Its slope is at begin and end of each step, and the path is
        the states beyond attitude and rate under trim at the ends of steps.
        """
        cases, steps, _ = shape = self.wind.shape
        order = self.equations.nominal.shape[-2]  # states, two of which are attitude and rate
        trim, demand = np.zeros(shape), np.zeros(shape)  # written by the kernel, as slope and path
        trim_range = np.zeros((cases, 2))
        slope, path = np.zeros((cases, steps, 2)), np.zeros((cases, steps + 1, order - 2))
        with np.errstate(invalid="ignore", divide="ignore"):
            run(
                marches.trim_and_demand,
                (*self._for_kernels(), trim, trim_range, demand, slope, path),
                cases=cases,
                # estimated run time, which decides between compiled and plain code
                seconds=marches.PLAIN * cases * steps,
                compiled_seconds=marches.COMPILED * cases * steps,
            )
        times = np.broadcast_to(self.times, shape)
        return Curves(
            times,
            self.wind,
            trim=trim,
            demand=demand,
            trim_range=trim_range,
            demand_slope=slope,
            path=path,
        )

    def peaks_over_modes(
        self, path: FloatArray, trim_ratios: FloatArray | None = None
    ) -> Iterator[tuple[IndexArray, FloatArray]]:
        """Yield indices of k winds and their `minimum_peaks` [rad], ``(k, S + 1)``, group by group.

        Those are the smallest peaks of any control from each of the S + 1 ends of S steps on. A
        group has equally many unstable modes; winds whose demand alone bounds every control are in
        none. `path`: the m - 2 states beyond attitude and rate, under trim, at these ends, ``(n, S
        + 1, m - 2)``. `trim_ratios`: trim over K [rad] there; None: peaks from the onset suffice.
        """
        for modes in self.equations.modes:
            # costate and control reach of the fastest mode: ``(n, m + 1)``
            steps, costates_and_reaches, _onset = self._for_kernels()
            # equations that are common to all winds have their modes in all
            cases = modes.cases if len(self.equations.end) > 1 else np.arange(len(path))
            selected = marches.VaryingSteps(*(x if len(x) == 1 else x[cases] for x in steps))
            end_of_cases = costates_and_reaches[cases]
            # a single mode is here because the effect p.b of a deflection on it changes its sign:
            # the control reach is then of a deflection with the sign of p.b, the largest one
            if modes.poles.shape[1] == 1:
                reach = np.broadcast_to(self.equations.absolute_reach, len(path))[cases]
                end_of_cases = np.append(end_of_cases[:, :-1], reach[:, np.newaxis], axis=-1)
            ratios = None if trim_ratios is None else trim_ratios[cases]
            yield cases, minimum_peaks(modes, selected, end_of_cases, path[cases], ratios)

    def diverge(self, limits: FloatArray, cases: IndexArray | slice = slice(None)) -> BoolArray:
        """Return whether flights of the ideal trim law diverge, ``(k, tries)``.

        `limits`: deflection limits [rad] to try in each of k winds, ``(k, tries)``. `cases`:
        indices of these winds, by default all. Where the aerodynamic moment changes its sign, a
        flight also diverges with an attitude above `MAX_LINEAR_ANGLE` before the calm that follows:
        a vehicle that becomes stable turns back from any attitude, by linear equations.
        """
        winds = self if isinstance(cases, slice) else self.select(cases)
        equations, count = winds.equations, winds.wind.shape[1]  # number of steps
        calm = int(steps_after(equations).max())  # the last of these, if the winds have a calm
        checked = count - calm if count > calm else count  # steps in which the attitude counts
        changes = np.broadcast_to(equations.changes_sign, len(limits))
        max_attitude = np.where(changes, MAX_LINEAR_ANGLE, np.inf)
        tried = np.require(limits, float, ["C", "W"])
        diverged = np.zeros(limits.shape, dtype=bool)  # written by the kernel
        work = count * limits.size * equations.nominal.shape[-2]  # steps, tries and states
        run(
            marches.limited_trim,
            (*winds._for_kernels(), _FEEDBACK_OVER_TRIM, max_attitude, checked, tried, diverged),
            cases=len(limits),
            # estimated run time, which decides between compiled and plain code
            seconds=marches.LIMITED_PLAIN * work,
            compiled_seconds=marches.LIMITED_COMPILED * work,
        )
        return diverged

    def requirement(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return limits [rad] of n winds from which on flights survive, at least `low`, ``(n,)``.

        Infinite where flights with `high` [rad] diverge too, with which the law should never be
        limited.
        """
        from tvclin.flights.closed_loop.survival_limit import (
            limits_above_losses,  # late: its file loads all of `flights`
        )

        bottom = np.maximum(low, _MIN_LIMIT)
        top, required = np.maximum(high, bottom), np.empty(bottom.shape)
        # one by one, since the limits tried in a scan of many cases depend on all of them
        for case in np.arange(bottom.size)[:, np.newaxis]:

            def diverge(limits: FloatArray, case: IndexArray = case) -> BoolArray:
                """Return whether flights of the case diverge with limits [rad], ``(tries, 1)``."""
                return self.diverge(limits.T, case).T

            edge, never = limits_above_losses(diverge, bottom[case], top[case])
            required[case] = np.where(never, np.inf, np.maximum(edge, low[case]))
        return required

    def survive(self, limit: FloatArray, high: FloatArray, bound: FloatArray) -> BoolArray:
        """Return whether flights in n winds survive from `limit` to `high` [rad], ``(n,)``.

        Limits are tried in relative steps: of `FINE` from `limit` up to the fraction `AHEAD` above
        the lower of `limit` and `bound`, a bound [rad] of the requirement; then of `STRIDE`.
        """
        from tvclin.flights.closed_loop.survival_limit import AHEAD, FINE, STRIDE

        low = np.maximum(limit, _MIN_LIMIT)
        top = np.maximum(high, low)
        middle = np.clip((1.0 + AHEAD) * np.minimum(bound, low), low, top)
        # logarithmic spans of fine and coarse steps, and their numbers, ``(n, 1)``
        fine_span = np.log(middle / low)[:, np.newaxis]
        coarse_span = np.log(top / middle)[:, np.newaxis]
        fine, coarse = np.ceil(fine_span / FINE), np.ceil(coarse_span / STRIDE)
        # rounded up to a multiple, so that many cases have the same number and fly together
        counts = _LIMITS_MULTIPLE * np.ceil((fine + coarse)[:, 0] / _LIMITS_MULTIPLE).astype(int)
        survives = ~self.diverge(low[:, np.newaxis])[:, 0]  # one limit in each wind
        for count in np.unique(counts[survives & (counts > 0)]).tolist():
            cases = np.flatnonzero(survives & (counts == count))
            k, n = np.arange(1, count + 1), fine[cases]
            below = np.minimum(k / np.maximum(n, 1.0), 1.0)  # fraction of the fine span
            above = np.clip((k - n) / np.maximum(coarse[cases], 1.0), 0.0, 1.0)  # of the coarse
            logarithm = fine_span[cases] * below + coarse_span[cases] * above
            tried = low[cases, np.newaxis] * np.exp(logarithm)
            survives[cases] = ~np.any(self.diverge(tried, cases), axis=1)
        return survives
