"""The smallest deflection limit with which a law survives, and above which it always survives.

Survival need not be monotonic in the limit. Limits are scanned upwards and the transition from the
last loss to survival is refined; `boundary_map` repeats this over gains and delays of the loop.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.base import errors
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.cards import Shown
from tvclin.base.fields import spec
from tvclin.boundary.forecast_free import unstable_coordinates
from tvclin.control.autopilot.actuator import Actuator, check_engine
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.batch import Hardware, one_flight
from tvclin.flights.closed_loop.checks import (
    check_delays,
    check_fastest_pole,
    check_flight,
    check_rate_limit,
    check_sample_rate,
    check_samples,
)
from tvclin.flights.closed_loop.fly_many import (
    MAX_DEFLECTION_LIMIT,
    SURVIVED,
    UNDECIDED,
    status_by_limit,
)
from tvclin.flights.closed_loop.sampled_stability import MIN_FREQUENCY_OVER_POLE, dominant_pole
from tvclin.kernels.choice import repeated
from tvclin.linear.flexible import AnyPlant
from tvclin.winds.histories import History

Words = NDArray[np.str_]

OK = "ok"
NEVER = "no limit in the range survives"
ALWAYS = "every limit in the range survives"
OPEN = "undecided: the highest limit that does not survive is not lost either"
STEPS = 60
"""Number of steps of a scan."""
ABOVE = 4
"""Number of steps above the highest loss that a refinement scans."""
PARTS = 16
"""Number of parts of a step in a refinement."""
LEVELS = 3
"""Number of successive refinements."""
STRIDE = 0.02
"""Step of the scan of many limits at once, relative."""
FINE = 0.002
"""Step of its refinement, relative."""
AHEAD = 0.06
"""Range above the highest loss that its refinement scans, relative."""
LAST_PARTS = 10
"""Number of parts of the last step of its refinement."""
_MAX_CUTS = 1000
"""Largest number of sudden stops of a wind."""
_MAX_TOTAL_SAMPLES = 5_000_000
"""Largest number of samples of all winds that are flown together: some hundred megabytes."""


@dataclass(frozen=True, eq=False)
class SurvivalLimit:
    """Smallest value above which all values of a scan survive.

    `limit`: that value; infinite if the highest is lost. `lost`: highest value that does not
    survive, or minus infinity. `scan`, `outcomes`: the values, rising, and their status.
    `refinements`: step of each refinement, and the value up to which it was scanned, finest last.
    `status`: "ok", or a reason why the limit is an end of the range or not certain.
    """

    limit: float
    lost: float
    scan: FloatArray
    outcomes: Words
    refinements: tuple[tuple[float, float], ...]
    status: str


def limit_above_losses(survives: Callable[[FloatArray], Words], scan: FloatArray) -> SurvivalLimit:
    """Return the smallest value above which all values of a scan and its refinements survive.

    Each of three refinements divides the step of the scan before it into 16 parts, and scans four
    of the undivided steps above the highest loss; a new highest loss extends it. `survives`:
    function from values ``(n,)`` to their status, ``(n,)``. `scan`: equidistant values, rising.
    """
    bottom, top = float(scan[0]), float(scan[-1])
    step = float(scan[1] - scan[0])
    tried: list[FloatArray] = []
    status: list[Words] = []

    def lost(values: FloatArray) -> BoolArray:
        """Return whether flights with limits ``(n, 1)`` diverge, and add them to `tried`, `status`.

        Limits above the `top` of the scan are not flown, and count as surviving; so does the top
        after the first scan, which has flown it.
        """
        column, diverged = values[:, 0], np.zeros(values.shape, np.bool_)
        new = column < top if tried else column <= top  # the first scan includes the top
        if np.any(new):  # none above a top that does not survive
            tried.append(column[new])
            status.append(survives(column[new]))
            diverged[new, 0] = status[-1] != SURVIVED
        return diverged

    steps = (step / float(PARTS) ** np.arange(1, LEVELS + 1)).tolist()
    # of each refinement the step, the steps above the highest loss that must survive, and the steps
    # in one step of the scan before
    levels = [(fine, ABOVE * PARTS, PARTS) for fine in steps]
    highest, ends = _highest_losses(lost, scan[:, np.newaxis], levels)
    values, outcomes = np.concatenate(tried), np.concatenate(status)
    refinements = tuple((fine, min(end, top)) for fine, end in zip(steps, ends, strict=True))
    low, order = float(highest[0]), np.argsort(values)
    reason = OPEN if np.any(outcomes[values == low] == UNDECIDED) else OK
    limit = min(low + refinements[-1][0], top)
    if low == -np.inf:
        limit, reason = bottom, ALWAYS
    elif low == top:
        limit, reason = np.inf, NEVER if reason == OK else f"{NEVER}; {OPEN}"
    return SurvivalLimit(
        limit=limit,
        lost=low,
        scan=values[order],
        outcomes=outcomes[order],
        refinements=refinements,
        status=reason,
    )


def limits_above_losses(
    lost: Callable[[FloatArray], BoolArray], low: FloatArray, high: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return the survival limits of n cases, and whether each case is lost at `high`, ``(n,)``.

    Values are tried every `STRIDE` from `low` to `high`; above the highest loss every `FINE` until
    a range of `AHEAD` survives; and the remaining step in `LAST_PARTS`. `lost`: function from
    values ``(k, n)``, a column for each case, to whether they are lost. `low`, `high`: positive
    bounds of the values, ``(n,)``. Steps are relative, so that the scan is of logarithms: 0 is
    `low`, and `span` is `high`.
    """
    span, fine = np.log(np.maximum(high / low, 1.0)), np.log1p(FINE)
    count = max(int(np.ceil(span.max(initial=0.0) / STRIDE)), 1)
    scan = span * np.linspace(0.0, 1.0, count + 1)[:, np.newaxis]

    def logarithm_lost(x: FloatArray) -> BoolArray:
        """Return whether flights with the values `low` e^x are lost, in the shape of `x`.

        Values above `high` count as survived.
        """
        return lost(low * np.exp(np.minimum(x, span))) & (x <= span)

    last = fine / LAST_PARTS  # the last step
    # `levels` of `_highest_losses`, with the stride 1: no step was tried by the scan before
    levels = [(fine, int(AHEAD / FINE), 1), (last, LAST_PARTS - 1, 1)]
    highest, _ = _highest_losses(logarithm_lost, scan, levels)  # -inf without a loss
    never = highest >= span
    limits = low * np.exp(np.minimum(highest + last, span))
    return np.where(never, high, np.where(highest > -np.inf, limits, low)), never


def _highest_losses(
    lost: Callable[[FloatArray], BoolArray],
    scan: FloatArray,
    levels: Sequence[tuple[float, int, int]],
) -> tuple[FloatArray, list[float]]:
    """Return the highest lost value of each of n columns, minus infinity without a loss.

    The second result is the last value that each refinement tried, in the first column. A
    refinement counts its steps from the highest loss before it; whenever a further value is lost,
    as many steps above that value must survive. `lost`: function from values ``(k, n)`` to whether
    they are lost. `scan`: values of the first scan, rising, ``(k, n)`` or ``(k, 1)``. `levels`: for
    each refinement its step, the number `clear` of steps above a loss that must survive, and a
    stride s: every s-th of these steps was tried by the previous level (none if s is 1).
    """
    highest, ends = np.where(lost(scan), scan, -np.inf).max(axis=0), []
    for step, clear, stride in levels:
        start, first, last = np.maximum(highest, scan[0]), 1, clear
        while first <= last:
            steps = np.arange(first, last + 1)
            steps = steps[(steps % stride != 0) | (stride == 1)]  # without those tried before
            values = start + step * steps[:, np.newaxis]
            diverged = lost(values)
            highest = np.maximum(highest, np.where(diverged, values, -np.inf).max(axis=0))
            losses = steps[diverged.any(axis=1)]
            # `clear` steps above the highest loss; without a loss the loop ends
            first, last = last + 1, int(losses.max(initial=last - clear)) + clear
        ends.append(float(start[0] + step * (first - 1)))
    return highest, ends


def status_in_all_winds(
    winds: Sequence[History],
    status: Callable[[History, BoolArray], Words],
    size: int,
    flown: Callable[[], None] = lambda: None,
) -> Words:
    """Return the status of many flights over all winds: the first other than survived, ``(size,)``.

    A flight that does not survive a wind is not flown in the later ones. `winds`: winds in their
    order. `status`: function from a wind and a mask of flights to the status of these flights in
    it. `size`: number of flights. `flown`: called after each wind.
    """
    outcomes = np.full(size, SURVIVED, dtype=object)
    for wind in winds:
        alive = outcomes == SURVIVED
        if np.any(alive):
            outcomes[alive] = status(wind, alive)
        flown()
    return outcomes.astype(str)


def winds_with_stops(wind: History, cuts: int, period: float) -> list[History]:
    """Return a wind, and `cuts` copies of it that stop suddenly, at equidistant times within it.

    `period`: sample period [s]. `InputError` for cuts that are not a whole number up to 1000, or
    too many samples.
    """
    stops = errors.whole_number("cuts", cuts)
    if stops > _MAX_CUTS:
        raise errors.InputError(f"cuts must be at most {_MAX_CUTS}; got {errors.shown(cuts)}")
    start, end = float(wind.onset), float(wind.end)
    if (stops + 1) * (end - start) / period > _MAX_TOTAL_SAMPLES:
        raise errors.InputError(
            f"cuts and sample_rate may make at most {_MAX_TOTAL_SAMPLES:g} samples of all winds;"
            f" got {stops + 1} times {end - start:.6g} s at {1.0 / period:.6g} Hz"
        )
    check_samples(end - start, period)
    return [wind, *(wind.before(t) for t in np.linspace(start, end, stops + 2)[1:-1])]


_LIMIT_RANGE = (1e-6, 1e6)
"""Smallest and largest limit of a scan, over the largest trim deflection."""
_MIN_GROWTH_OVER_POLE = 1e-5
"""Smallest growth rate of an unstable mode, over the fastest pole; below it may be rounding."""


@dataclass(frozen=True, eq=False)
class ClosedLoopBoundary(Shown):
    """Boundary of a law in a wind.

    Attributes
    ----------
    limit : float
        Smallest limit above which every limit of the scan survives, over ``|B alpha_w,max|``;
        infinite if the largest does not.
    deflection : float
        Deflection -limit B alpha_w,max [rad]; its sign opposes the wind.
    scan : ndarray
        Limits of the flights, rising, over ``|B alpha_w,max|``.
    survives : ndarray of bool
        Whether each of them survives.
    refinements : tuple of pairs of float
        Step of each refinement above the highest loss, and the limit up to which it was scanned,
        the finest last; both over ``|B alpha_w,max|``.
    growth : float
        Real part of the dominant pole [1/s] of the loop of law, actuator and samples in its linear
        range; negative for a stable loop.
    has_unstable_mode : bool
        Whether that pole is unstable, so that the law alone does not hold the mode for ever.
    status : str
        "ok", or the reasons: the limit is an end of the range, flights just below it are undecided,
        the loop has an unstable mode in its linear range.
    """

    limit: float = field(metadata=spec(label="limit over trim"))
    deflection: float = field(metadata=spec("angle"))
    scan: FloatArray
    survives: BoolArray
    refinements: tuple[tuple[float, float], ...] = field(metadata=spec(label="looked"))
    growth: float = field(metadata=spec("per time"))
    has_unstable_mode: bool
    status: str = field(metadata=spec())

    @property
    def monotone(self) -> bool:
        """Whether every limit of the scan above a surviving one survives."""
        return bool(np.all(np.diff(self.survives.astype(int)) >= 0))


def closed_loop_boundary(
    plant: AnyPlant,
    law: Law,
    wind: History,
    *,
    rate_limit: float = np.inf,
    actuator: Actuator | None = None,
    sample_rate: float = 200.0,
    delay: float = 0.0,
    gain: float = 1.0,
    cuts: int = 0,
    lowest: float = 0.02,
    highest: float = 2.0,
    progress: Callable[[int, int], None] | None = None,
) -> ClosedLoopBoundary:
    """Return the smallest deflection limit above which a law survives a wind.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        One plant with one or two real unstable poles.
    law : Law
        The law, designed on this plant or on another.
    wind : History
        One wind that ends.
    rate_limit, actuator, sample_rate, delay, gain
        Same as in `fly`, in SI units; the law is sampled.
    cuts : int
        Number of sudden stops of the wind, at equidistant times: a limit survives if it survives
        the wind with each of them.
    lowest, highest : float
        Range of the limits, over ``|B alpha_w,max|``, the trim deflection at the wind's peak.
    progress : callable, optional
        Called with the number of winds flown and their largest total.

    Returns
    -------
    ClosedLoopBoundary
        Boundary and scan: 61 limits over the range, then each of the four steps above the highest
        loss in 16 parts until these survive, and two further refinements in the same way. The limit
        is known to 1/4096 of a step of the scan.

    Raises
    ------
    InputError
        For batches, a plant without a real unstable pole, a wind that never ends, and samples
        that are far too long for the actuator.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> wind = tv.TriangularWind(peak=0.1, duration=8.0)
    >>> boundary = tv.closed_loop_boundary(plant, tv.TrimLaw(plant), wind, sample_rate=100)
    >>> round(boundary.limit, 3), round(tv.boundary_limit(plant, wind).limit, 3)
    (0.689, 0.688)
    >>> [(round(step, 5), round(end, 3)) for step, end in boundary.refinements]
    [(0.00206, 0.82), (0.00013, 0.697), (1e-05, 0.689)]
    """
    if progress is not None:
        errors.callable_for("progress", progress, "of how many are done and how many there are")
    check_flight(plant, law, wind)
    check_engine(plant, actuator)
    modes = unstable_coordinates(plant.rigid)
    period = 1.0 / check_sample_rate(sample_rate, actuator)
    max_rate = check_rate_limit(rate_limit)
    check_samples(1.0 / float(modes.poles[0]), period)
    factor = errors.number("gain", gain, errors.positive)
    low, high = (
        errors.number(
            name, errors.number(name, value, errors.positive), errors.between(*_LIMIT_RANGE)
        )
        for name, value in (("lowest", lowest), ("highest", highest))
    )
    if low >= high:
        raise errors.InputError(f"highest must be above lowest; got {high:.6g} and {low:.6g}")
    delays = float(
        check_delays(errors.number("delay", delay, errors.nonnegative, "s"), np.asarray(period))
    )
    scale = abs(float(plant.coefficients.B) * float(wind.peak))  # the largest trim deflection [rad]
    check_fastest_pole(plant, period)
    winds = winds_with_stops(wind, cuts, period)
    hardware = Hardware(period, delays, actuator=actuator, rate_limit=max_rate)

    @cache
    def flight(wind: History) -> Callable[[FloatArray], Words]:
        """Return the function from deflection limits [rad] to the status of flights in a wind."""
        return status_by_limit(one_flight(plant, law, wind, scale, hardware, factor))

    flown, total = count(1), (1 + LEVELS) * len(winds)  # a scan and its refinements fly each wind

    def report_wind() -> None:
        """Report a further wind, of `total`, to the function `progress`, if there is one."""
        if progress is not None:
            progress(min(next(flown), total), total)

    def status_at(limits: FloatArray) -> Words:
        """Return the status of flights in all winds with each of `limits`, over trim, ``(n,)``."""

        def status(wind: History, chosen: BoolArray) -> Words:
            """Return the status in a wind of flights with the limits at which `chosen` is true."""
            return flight(wind)(np.minimum(limits[chosen] * scale, MAX_DEFLECTION_LIMIT))

        return status_in_all_winds(winds, status, limits.size, report_wind)

    with repeated(total):  # similar runs, which decide between compiled and plain code
        scan = limit_above_losses(status_at, np.linspace(low, high, STEPS + 1))
    # The loop in its linear range, at that limit, on which some laws depend
    at = scan.limit if np.isfinite(scan.limit) else high
    batch = one_flight(plant, law, wind, at * scale, hardware, factor)
    worst, fastest = dominant_pole(batch), float(modes.poles[0])
    unstable = worst.real > _MIN_GROWTH_OVER_POLE * fastest
    reasons = [scan.status] if scan.status != OK else []
    if unstable:  # a slow oscillation counts as a real mode
        oscillates = worst.imag > MIN_FREQUENCY_OVER_POLE * fastest
        mode = f"an oscillation of {worst.imag:.3g} rad/s" if oscillates else "a real mode"
        reasons.append(f"near rest {mode} grows with {worst.real:+.3g} 1/s")
    return ClosedLoopBoundary(
        limit=scan.limit,
        deflection=-scan.limit * float(plant.coefficients.B) * float(wind.peak),
        scan=scan.scan,
        survives=scan.outcomes == SURVIVED,
        refinements=scan.refinements,
        growth=worst.real,
        has_unstable_mode=unstable,
        status="; ".join(reasons) or OK,
    )


_MAX_BOUNDARIES = 2_000
"""Largest number of boundaries in a map."""


@dataclass(frozen=True, eq=False)
class BoundaryMap(Shown):
    """Boundary of a law in a wind, over gain and delay.

    Attributes
    ----------
    gains : ndarray
        Factors on the demand of the law, ``(n,)``.
    delays : ndarray
        Computing delays [s], ``(m,)``.
    limit : ndarray
        Smallest limit above which the law survives, over ``|B alpha_w,max|``, ``(n, m)``; infinite
        if no limit of the scan does.
    growth : ndarray
        Real part of the dominant pole [1/s] in the linear range, ``(n, m)``; if positive, the loop
        oscillates whatever the limit.
    full_trim : float
        Largest trim deflection ``|B alpha_w,max|`` [rad].
    """

    gains: FloatArray = field(metadata=spec())
    delays: FloatArray = field(metadata=spec("time"))
    limit: FloatArray = field(metadata=spec(label="limit over trim"))
    growth: FloatArray
    full_trim: float


def boundary_map(
    plant: AnyPlant,
    law: Law,
    wind: History,
    gains: ArrayLike,
    delays: ArrayLike,
    *,
    rate_limit: float = np.inf,
    actuator: Actuator | None = None,
    sample_rate: float = 100.0,
    cuts: int = 0,
    lowest: float = 0.02,
    highest: float = 2.0,
) -> BoundaryMap:
    """Return the boundary of a law over the gain and the delay of its loop.

    Parameters
    ----------
    plant, law, wind
        Same as in `closed_loop_boundary`.
    gains : array_like
        Factors on the demanded deflection of the law, positive and ascending, ``(n,)``.
    delays : array_like
        Computing delays [s], rising, ``(m,)``.
    rate_limit, actuator, sample_rate, cuts, lowest, highest
        Same as in `closed_loop_boundary`.

    Raises
    ------
    InputError
        In the same cases as `closed_loop_boundary`, for gains or delays that do not rise, and for
        more than 2000 boundaries.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> law = tv.SaturatedLaw(tv.control.canonical_gains(plant.coefficients))
    >>> wind = tv.TriangularWind(peak=0.1, duration=8.0)
    >>> gains, delays = [1.0, 2.0, 4.0], [0.0, 0.3]
    >>> limits = tv.flights.boundary_map(plant, law, wind, gains, delays, sample_rate=25).limit
    >>> limits.round(2).tolist()
    [[1.39, 1.58], [0.99, 1.05], [0.82, 0.83]]
    """
    factors = errors.positive("gains", errors.one_row("gains", gains))
    delay_row = errors.nonnegative("delays", errors.one_row("delays", delays, "s"), "s")
    for name, row in (("gains", factors), ("delays", delay_row)):
        if not np.all(np.diff(row) > 0.0):
            raise errors.InputError(f"{name} must rise; got {errors.shown(row)}")
    if factors.size * delay_row.size > _MAX_BOUNDARIES:
        raise errors.InputError(
            f"gains and delays may make at most {_MAX_BOUNDARIES} boundaries; got {factors.size}"
            f" times {delay_row.size}"
        )
    options: dict[str, Any] = {"sample_rate": sample_rate, "lowest": lowest, "highest": highest}
    options |= {"rate_limit": rate_limit, "actuator": actuator, "cuts": cuts}
    boundary_at = partial(closed_loop_boundary, plant, law, wind, **options)
    boundaries = [
        [boundary_at(gain=gain, delay=delay) for delay in delay_row.tolist()]
        for gain in factors.tolist()
    ]
    return BoundaryMap(
        gains=factors,
        delays=delay_row,
        limit=np.array([[boundary.limit for boundary in row] for row in boundaries]),
        growth=np.array([[boundary.growth for boundary in row] for row in boundaries]),
        full_trim=abs(float(plant.coefficients.B) * float(wind.peak)),
    )
