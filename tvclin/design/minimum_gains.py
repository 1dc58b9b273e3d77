"""Gains with the minimum deflection of all gains with the specified margins."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError
from tvclin.base.fields import Field, spec, specs
from tvclin.base.lines import Table, degrees, listed, number
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.margin_bounds import margin_bounds
from tvclin.control.autopilot.wind_response import deflection_peaks
from tvclin.control.laws.autopilot_law import SaturatedLaw
from tvclin.control.margins.criteria import CRITERIA, Criteria
from tvclin.control.margins.margins import MARGINS, Margins, loop_margins, unit_factor
from tvclin.design.gain_problem import (
    CROSSOVER,
    UNSATISFIED_COST,
    GainProblem,
    highest_crossover,
    required_limits,
)
from tvclin.flights.closed_loop.survival_limit import closed_loop_boundary
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.modes import unstable_modes
from tvclin.numerics.searches import box_minimum
from tvclin.vehicle.filters import Filter
from tvclin.winds.histories import History

PEAK, BOUNDARY = "peak", "boundary"
"""Meanings of the deflection of `MinimumGains`."""


@dataclass(frozen=True, eq=False)
class MinimumGains(Shown):
    """Gains with the minimum deflection of all gains with the specified margins.

    Attributes
    ----------
    problem : GainProblem
        Specification: plant, winds, criteria, nozzle.
    autopilot : Autopilot
        The gains, with actuator and delay.
    meaning : str
        "peak": the deflection is the peak of the linear loop, without a limit. "boundary": it is
        the minimum limit with which flights survive, by `closed_loop_boundary`; it is lower, by
        0.15 to 0.4 of trim as a rule.
    deflection : float
        Largest deflection over the winds [rad], in size.
    relative : float
        The deflection normalised by the trim ``|B alpha_w,max|`` of the worst wind.
    deflections : ndarray
        The deflection [rad] of each wind, ``(winds,)``.
    worst_wind : int
        Index of the wind with the largest deflection.
    margins : Margins
        Margins of the loop.
    active : tuple of str
        Active constraints of the minimum: names of margins within 0.5 percent of their limits,
        "crossover", and the winds, by peak and duration, where several require the same
        deflection. Empty where more gain and less gain both require more.
    many_stops : float
        With limits, the boundary [rad] in the same winds with 23 sudden ends, most of which the
        search did not use; else None.
    notes : tuple of str
        Limitations of these gains.
    """

    problem: GainProblem
    autopilot: Autopilot = field(
        metadata=specs(
            Field("attitude_gain", of="autopilot.attitude_gain", document=False),
            Field("rate_gain", "time", of="autopilot.rate_gain", document=False),
            Field("alpha_gain", of="autopilot.alpha_gain", document=False),
        )
    )
    meaning: str = field(metadata=spec())
    deflection: float = field(metadata=spec("angle"))
    relative: float = field(metadata=spec(name="part_of_trim", label="over trim"))
    deflections: FloatArray = field(metadata=spec("angle", card=False))
    worst_wind: int = field(metadata=spec(card=False))
    margins: Margins = field(
        metadata=spec(name="disk_margin", of="margins.disk_margin", document=False)
    )
    active: tuple[str, ...] = field(metadata=spec(label="held by"))
    many_stops: float | None = field(metadata=spec("angle", card=False))
    notes: tuple[str, ...] = field(metadata=spec())

    def table(self) -> Table:
        """Return the table of the deflection in each wind, in degrees and over that wind's trim."""
        meanings = {
            "peak": "largest deflection of the linear loop",
            "boundary": "minimum limit with which flights survive",
        }
        problem = self.problem
        rows = tuple(
            ((name,), degrees(f"least.{name}", angle), number(f"least.{name}.part", angle / trim))
            for name, angle, trim in zip(
                problem.names, self.deflections, problem.trims, strict=True
            )
        )
        caption = f"Minimum deflection: {meanings[self.meaning]}"
        return Table(caption, ("wind", "[deg]", "of trim"), rows)


class UnsatisfiedCriteriaError(InputError):
    """Error of criteria that no gains in the search range satisfy.

    Its arguments are the `GainProblem`, and the `Autopilot` with the gains nearest to the criteria.
    """

    @property
    def nearest(self) -> Autopilot:
        """Autopilot with the gains that come nearest to the criteria."""
        _problem, autopilot = self.args  # of the constructor
        return autopilot

    @property
    def shortfall(self) -> str:
        """The nearest gains, and the margin of theirs whose relative shortfall is largest."""
        problem, autopilot = self.args
        margins = loop_margins(autopilot.exact_loop(problem.plant))
        judged = problem.judge_loop(margins)
        worst = min(judged, key=lambda judgement: float(judgement.relative_surplus), default=None)
        if not margins.stable:
            words = "are unstable"
        elif worst is not None and not worst.satisfied:
            (label, _, _), (limit, unit) = MARGINS[worst.criterion.margin], worst.criterion.shown
            value = unit_factor(unit) * worst.value
            words = f"have {label} {value:.4g} where {limit:.4g} {unit}".rstrip() + " is required"
        else:
            words = "miss the required margins of modes or the crossover"
        return f"the nearest, {autopilot.gains_text}, {words}"

    @property
    def sentence(self) -> str:
        """Verdict: criteria, free gains, and the nearest gains with their shortfall."""
        problem, _autopilot = self.args
        largest = problem.crossover  # largest crossover frequency [rad/s] that is permitted
        up_to = "" if largest is None else f", with crossovers up to {largest:g} rad/s"
        return (
            f"criteria {problem.criteria.name}{up_to}: NOT MET by any {listed(problem.gains)}"
            f" gains; {self.shortfall}"
        )

    @property
    def searched(self) -> str:
        """Range of the gains that were sought, in words."""
        problem, _autopilot = self.args
        return f"gains are sought in the range of {problem.search_range}"

    @property
    def bounds(self) -> str:
        """Upper bounds of the margins of any autopilot, in one sentence; may be empty."""
        problem, _autopilot = self.args
        bounds = margin_bounds(problem.plant, actuator=problem.actuator, delay=problem.delay)
        return bounds.sentence

    def __str__(self) -> str:
        """Return the message: the verdict and the bounds."""
        return "; ".join(filter(None, (self.sentence, self.bounds)))


_SETTLING_TIME_CONSTANTS = 8.0
"""Duration of a response after its wind, in time constants of the fastest pole of the plant."""
_LIMIT_TOLERANCE = 1e-4
"""Difference of limits, relative to trim, that counts as none."""
_LINEAR_SEARCH: dict[str, Any] = {"per_round": 32, "rounds": 40}
"""Options of the search by peaks of the linear loop."""
_FLOWN_SEARCH: dict[str, Any] = {"per_round": 24, "rounds": 30, "islands": 1}
"""Options of the search by flights."""
_STOPPED_SEARCH: dict[str, Any] = {"per_round": 24, "rounds": 14, "islands": 1}
"""Options of the search by flights with sudden ends of the winds."""
_REFINEMENT: dict[str, Any] = {
    "initial": 8,
    "per_round": 12,
    "rounds": 6,
    "tolerance": _LIMIT_TOLERANCE,
}
"""Options of the last search by flights, around the best gains."""
_BOX_POINTS = 256
"""First points of a search over the unit box, for each axis beyond the first."""
_LOCAL_POINTS = 16
"""First points of a search near known gains."""
_ISLANDS = 3
"""Number of pools of a search with three gains; with two gains a single pool converges."""
_SEARCH_SCAN, _FINAL_SCAN = 24, 100
"""Number of limits above the required limit that are flown: in the search, and at its end."""
_EXACT_ROWS = 4
"""Number of the best rows of gains whose exact peaks are computed."""
_DIGITS = 4
"""Number of significant digits of gains, those that are printed."""
_DIGIT_STEPS = (2, 6)
"""Largest distances of neighbouring gains that are tried, in units of the last digit."""
_RELATIVE_TOLERANCE = 0.005
"""Relative distance at which a margin, a wind or an edge of the search range counts as active."""
_CHECK_STOPS = 23
"""Number of sudden ends of each wind at which the final gains are checked."""
_MIN_ALPHA_RATIO = 0.45
"""alpha_ratio below which a sudden end of the wind requires more than the wind."""


def minimum_deflection_gains(
    plant: AnyPlant,
    winds: History | Sequence[History],
    *,
    criteria: Criteria = CRITERIA["classic"],
    gains: Sequence[str] = ("attitude", "rate"),
    actuator: Actuator | None = None,
    delay: float = 0.0,
    crossover: float | None = None,
    filters: tuple[Filter, ...] = (),
    attitude_filters: tuple[Filter, ...] = (),
    rate_filters: tuple[Filter, ...] = (),
    limits: bool = False,
    stops: int = 0,
    sample_rate: float | None = None,
) -> MinimumGains:
    """Return the gains with the minimum deflection of all gains with the specified margins.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        An aerodynamically unstable plant, no batch.
    winds : History or sequence of History
        Winds that end; the deflection is the largest over all of them.
    criteria : Criteria
        Required margins, of the whole loop and of modes.
    gains : sequence of str
        Free gains: attitude and rate, or attitude, rate and alpha.
    actuator : Actuator, optional
        Actuator of the nozzle.
    delay : float
        Delay of the loop [s]; in flights it is the computing delay.
    crossover : float, optional
        Upper limit of a gain crossover [rad/s], in place of bending modes that are not in the
        plant.
    filters, attitude_filters, rate_filters : tuple of Filter
        Filters after the sum of the feedbacks, on the attitude and on the rate.
    limits : bool
        Whether the deflection is the minimum limit with which flights survive the winds, in place
        of the peak of the linear loop.
    stops : int
        With limits, number of sudden ends of each wind that must be survived as well.
    sample_rate : float, optional
        Samples of the autopilot in a second [Hz]: its margins are then of the sampled loop.
        Without one the margins are of a continuous autopilot, and flights sample it at 100 Hz. The
        largest deflections of the linear loop belong to the continuous one, either way.

    Returns
    -------
    MinimumGains
        Gains, deflection, margins, active criteria and notes.

    Raises
    ------
    InputError
        For a plant that is aerodynamically stable, a batch, winds that do not end, neither nozzle
        nor delay nor crossover, stops without limits, margins that no gains have; also the
        exceptions of `Autopilot.wind_response` and `closed_loop_boundary`.

    Notes
    -----
    On a fixed path the margins depend on a0 + b0 and a1 alone (gains of attitude a0, rate a1 and
    alpha b0), and the deflection is affine in b0 for a given loop. The search uses none of that: it
    takes hundreds of points, then others along differences of the best, with all margins and peaks
    of a round in one call. Peaks are minimal to about 1e-3 of trim, with three gains in several
    winds to 2e-3; the gains have four digits, with which they satisfy all criteria.

    A single wind is overfitted: give several durations, and judge three gains with stops.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
    >>> wind = tv.TriangularWind(peak=0.05, duration=7.5)
    >>> gains = tv.minimum_deflection_gains(
    ...     plant, wind, actuator=tv.Actuator(), delay=0.02, crossover=2.0
    ... )
    >>> round(gains.relative, 2), gains.active
    (1.11, ('phase_margin_deg', 'crossover'))
    """
    winds_row: Any = (winds,) if isinstance(winds, History) else winds
    problem = GainProblem(
        plant=plant,
        winds=winds_row,
        criteria=criteria,
        gains=gains,
        actuator=actuator,
        delay=delay,
        crossover=crossover,
        filters=filters,
        attitude_filters=attitude_filters,
        rate_filters=rate_filters,
        limits=limits,
        stops=stops,
        sample_rate=sample_rate,
    )
    return solve_problem(problem)


def solve_problem(problem: GainProblem, start: FloatArray | None = None) -> MinimumGains:
    """Return the gains that solve a problem.

    `problem`: plant, winds, nozzle and criteria. `start`: first points in the unit box of the
    gains, ``(n, axes)``; None: the entire box is searched. `UnsatisfiedCriteriaError` where no
    gains satisfy the criteria.
    """
    axes = len(problem.gains)
    first = _BOX_POINTS * (axes - 1) if start is None else _LOCAL_POINTS
    options: dict[str, Any] = {"initial": first, "start": start, "over_box": start is None}
    pools = _ISLANDS if problem.has_alpha else 1  # of points that at first evolve by themselves
    # First by peaks of the linear loop. For limits of flights the search goes on from these points,
    # with few limits flown for each, and is refined with many. A cost below UNSATISFIED_COST is a
    # deflection over trim: the gains have all margins.
    linear = partial(_cost, problem, partial(_linear_peaks, problem))
    points, costs = box_minimum(linear, axes, islands=pools, **options, **_LINEAR_SEARCH)
    if costs[0] >= UNSATISFIED_COST:
        raise UnsatisfiedCriteriaError(problem, problem.autopilot(points[0]))
    if problem.limits:
        flown, final = (
            partial(_cost, problem, partial(required_limits, problem, scan_count=n))
            for n in (_SEARCH_SCAN, _FINAL_SCAN)
        )
        # `stops`: number of sudden ends of each wind that are flown as well
        search = _STOPPED_SEARCH if problem.stops else _FLOWN_SEARCH
        options |= search | {"start": points, "tolerance": _LIMIT_TOLERANCE}
        points, _ = box_minimum(flown, axes, **options)
        points, _ = box_minimum(final, axes, start=points, over_box=False, **_REFINEMENT)
        best = _rounded(problem, points[0])
        return _record(problem, best, _boundaries(problem, problem.autopilot(best), problem.stops))
    # The peaks of the search are those of samples: the best of a few by exact peaks.
    rows = [_rounded(problem, point) for point in points[:_EXACT_ROWS]]
    exact = [_peaks(problem, problem.autopilot(row)) for row in rows]
    k = int(np.argmin([peaks.max() for peaks in exact]))
    return _record(problem, rows[k], exact[k])


def _rounded(problem: GainProblem, point: FloatArray) -> FloatArray:
    """Return the point, ``(axes,)``, of the nearest gains of `_DIGITS` digits with all margins.

    `point`: gains in the unit box of the problem, ``(axes,)``; it is returned itself where no
    neighbouring gains of so few digits satisfy the criteria.
    """
    exact = problem.autopilot(point)
    names = [f"{name}_gain" for name in problem.gains]
    gains = np.array([float(getattr(exact, name)) for name in names])
    if np.any(gains <= 0.0):
        return point
    steps = 10.0 ** (np.floor(np.log10(gains)) + 1 - _DIGITS)  # one unit of the last digit
    for count in _DIGIT_STEPS:  # largest number of these units by which a gain is moved
        shifts = np.array(list(product(range(-count, count + 1), repeat=gains.size)))
        rows = (np.round(gains / steps) + shifts) * steps
        rows = rows[np.argsort(np.max(np.abs(rows / gains - 1.0), axis=1))]
        points = np.array(
            [problem.point(replace(exact, **dict(zip(names, row, strict=True)))) for row in rows]
        )
        good = np.flatnonzero(problem.shortfalls(points) <= 0.0)
        if good.size:
            return np.asarray(points[good[0]])
    return point


def _cost(
    problem: GainProblem,
    requirement: Callable[[FloatArray, float], FloatArray],
    points: FloatArray,
    pool: FloatArray,
) -> FloatArray:
    """Return the cost of n rows of gains, ``(n,)``: required deflection over the largest trim.

    Rows that miss a criterion of the problem cost at least `UNSATISFIED_COST`. `requirement`:
    function for the deflection of rows that satisfy all criteria, exact below a goal. `points`:
    gains in the unit box, ``(n, axes)``. `pool`: rising costs of the best rows so far; the last is
    that goal. A row that satisfies all criteria costs at most 0.9 `UNSATISFIED_COST`.
    """
    shortfalls = problem.shortfalls(points)
    values = UNSATISFIED_COST + np.maximum(shortfalls, 0.0)
    good = np.flatnonzero(shortfalls <= 0.0)
    if good.size:
        required = requirement(points[good], float(pool[-1]))
        values[good] = np.minimum(required, 0.9 * UNSATISFIED_COST)
    return np.asarray(values)


def _linear_peaks(problem: GainProblem, points: FloatArray, _goal: float) -> FloatArray:
    """Return the peak deflections of n linear loops, normalised by the largest trim, ``(n,)``.

    The largest over the winds of the problem, until eight time constants of the fastest unstable
    mode after each, without samples. `points`: gains in the unit box, ``(n, axes)``. `_goal`: not
    used, since all peaks are exact; `_cost` passes it for `required_limits`, exact below it alone.
    """
    rows = replace(problem.autopilot(points), sample_rate=None)
    poles = np.real(unstable_modes(problem.plant.rigid).poles)
    after = _SETTLING_TIME_CONSTANTS / float(np.nanmax(poles))
    peaks = [deflection_peaks(rows, problem.plant, w, after) for w in problem.winds]
    return np.asarray(np.max(peaks, axis=0) / problem.trims.max())


def _peaks(problem: GainProblem, autopilot: Autopilot) -> FloatArray:
    """Return the exact peak deflections [rad] of an autopilot's linear loop, ``(winds,)``.

    In each wind of the problem, of the loop without samples.
    """
    response = replace(autopilot, sample_rate=None).wind_response_function(problem.plant)
    peaks_and_times = (response(wind).peak("deflection") for wind in problem.winds)
    return np.array([abs(peak) for peak, _ in peaks_and_times])


def _boundaries(problem: GainProblem, autopilot: Autopilot, stops: int) -> FloatArray:
    """Return the boundaries [rad] of an autopilot in each wind of a problem, ``(winds,)``.

    A boundary is the smallest deflection limit from which on every limit survives in flight.
    `stops`: number of sudden ends of each wind that must be survived as well.
    """
    law = SaturatedLaw.of(autopilot)
    limits = [
        closed_loop_boundary(
            problem.plant,
            law,
            wind,
            actuator=problem.actuator,
            delay=problem.delay,
            sample_rate=problem.flown_rate,
            cuts=stops,
        ).deflection
        for wind in problem.winds
    ]
    return np.abs(np.array(limits))


def _record(problem: GainProblem, point: FloatArray, deflections: FloatArray) -> MinimumGains:
    """Return the record of a row of gains with its margins, active constraints and notes.

    `point`: the gains in the unit box of the problem, ``(axes,)``. `deflections`: required
    deflection in each wind [rad], ``(winds,)``: of flights with a limit (`BOUNDARY`, where
    `problem.limits`), else peaks of the linear loop (`PEAK`). With flights, `many_stops` is the
    largest where the winds end suddenly at more times than in the search.
    """
    autopilot = problem.autopilot(point)
    margins = loop_margins(autopilot.exact_loop(problem.plant))
    worst = int(np.argmax(deflections))
    many_stops = None
    if problem.limits:
        many_stops = float(_boundaries(problem, autopilot, _CHECK_STOPS).max())
    return MinimumGains(
        problem=problem,
        autopilot=autopilot,
        meaning=BOUNDARY if problem.limits else PEAK,
        deflection=float(deflections[worst]),
        relative=float(deflections[worst] / problem.trims[worst]),
        deflections=deflections,
        worst_wind=worst,
        margins=margins,
        active=_active(problem, margins, deflections),
        many_stops=many_stops,
        notes=_notes(problem, autopilot, point, deflections, many_stops),
    )


def _active(problem: GainProblem, margins: Margins, deflections: FloatArray) -> tuple[str, ...]:
    """Return the names of active criteria, and of winds that require the same deflection.

    Active is what lies within 0.5 percent of its limit, and a wind of the largest deflection.
    `margins`: of the loop of the problem. `deflections`: in each wind [rad], ``(winds,)``.
    """
    active = [
        judged.criterion.margin
        for judged in problem.judge_loop(margins)
        if abs(judged.relative_surplus) < _RELATIVE_TOLERANCE
    ]
    largest = problem.crossover  # largest crossover frequency [rad/s] that is permitted
    if largest is not None and highest_crossover(margins) > (1.0 - _RELATIVE_TOLERANCE) * largest:
        active.append(CROSSOVER)
    equal = np.flatnonzero(deflections > (1.0 - _RELATIVE_TOLERANCE) * deflections.max())
    if equal.size > 1:
        active += [problem.names[k] for k in equal.tolist()]
    return tuple(active)


def _notes(
    problem: GainProblem,
    autopilot: Autopilot,
    point: FloatArray,
    deflections: FloatArray,
    many_stops: float | None,
) -> tuple[str, ...]:
    """Return the notes on gains: lean into the wind, path, winds, search range and sudden ends.

    `autopilot`, `point`: the gains, and their point in the unit box of the problem, ``(axes,)``.
    `deflections`: required deflection in each wind [rad]. `many_stops`: boundary [rad] in the winds
    with many sudden ends, or None.
    """
    notes = []
    trim = problem.trims.max()  # largest trim [rad] of the winds, without drift
    if problem.has_alpha:
        a0, b0 = float(autopilot.attitude_gain), float(autopilot.alpha_gain)
        # alpha/alpha_w in a steady wind before the path has changed; B alpha is the trim deflection
        ratio = a0 / (a0 + b0 - float(problem.plant.coefficients.B))
        if ratio < _MIN_ALPHA_RATIO:
            notes.append(
                f"these gains leave {ratio:.2f} of a steady wind as angle of attack: below"
                f" {_MIN_ALPHA_RATIO} the vehicle leans so far into the wind that a sudden end of"
                ' it requires more; seek them with sudden ends: minimum = "limit" and sudden_ends ='
                " 6 in [autopilot], in Python limits=True and stops=6"
            )
        if problem.plant.rigid.model == "fixed-path":
            notes.append(
                "a fixed path sets no price on the attitude error: judge three gains on drift-exact"
            )
    if len(problem.winds) == 1:
        notes.append("the gains are fitted to one wind alone: give shorter and longer ones as well")
    at_edge = (point < _RELATIVE_TOLERANCE) | (point > 1.0 - _RELATIVE_TOLERANCE)
    if np.any(at_edge) and not problem.has_alpha:
        notes.append("the gains lie at the edge of the search range")
    largest = (1.0 + _RELATIVE_TOLERANCE) * float(deflections.max())
    if many_stops is not None and many_stops > largest:
        notes.append(
            f"with {_CHECK_STOPS} sudden ends of each wind, most of them new to the search, the"
            f" boundary is {many_stops / trim:.3f} of trim"
        )
    return tuple(notes)
