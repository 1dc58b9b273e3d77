"""Gains with the minimum deflection of all gains with the specified margins."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.documents import keyed
from tvclin.base.errors import InputError
from tvclin.base.lines import Table, degrees, number
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.margin_bounds import margin_bounds
from tvclin.control.autopilot.wind_response import deflection_peaks
from tvclin.control.laws.attitude import SaturatedLaw
from tvclin.control.margins.criteria import CRITERIA, Criteria
from tvclin.control.margins.margins import MARGINS, Margins, loop_margins, unit_factor
from tvclin.design.gain_search import CROSSOVER, MISSES, Question, highest_crossover, lacking, needs
from tvclin.design.search import least_points
from tvclin.flights.closed_loop.survival_limit import closed_loop_boundary
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.modes import unstable_modes
from tvclin.vehicle.filters import Filter
from tvclin.winds.histories import History

PEAK, BOUNDARY = "peak", "boundary"
"""Meanings of the deflection of `LeastGains`."""


@dataclass(frozen=True, eq=False)
class LeastGains(Shown):
    """Gains with the minimum deflection of all gains with the specified margins.

    Attributes
    ----------
    question : Question
        Specification: plant, winds, criteria, nozzle.
    autopilot : Autopilot
        The gains, with actuator and delay.
    meaning : str
        "peak": the deflection is the peak of the linear loop, without a limit. "boundary": it is
        the minimum limit with which flights survive, as of `closed_loop_boundary`; it is lower, by
        0.15 to 0.4 of trim as a rule.
    deflection : float
        Largest deflection over the winds [rad], in size.
    relative : float
        The deflection normalised by the trim ``|B alpha_w,max|`` of the worst wind.
    each : ndarray
        The deflection [rad] of each wind, ``(winds,)``.
    worst_wind : int
        Index of the wind with the largest deflection.
    margins : Margins
        Margins of the loop.
    active : tuple of str
        Active constraints of the minimum: names of margins within 0.5 percent of their limits,
        "crossover", and the winds, by peak and duration, where several require the same
        deflection. Empty where more gain and less gain both require more.
    unseen : float
        With limits, the boundary [rad] in the same winds with 23 sudden ends, most of which the
        search did not use; else None.
    notes : tuple of str
        Limitations of these gains.
    """

    question: Question
    autopilot: Autopilot
    meaning: str
    deflection: float
    relative: float
    each: FloatArray
    worst_wind: int
    margins: Margins
    active: tuple[str, ...]
    unseen: float | None
    notes: tuple[str, ...]

    as_dict = keyed(
        "meaning deflection_deg part_of_trim=relative worst_wind each_deg active"
        " unseen_stops_deg=unseen notes"
    )

    def table(self) -> Table:
        """Return the table of the deflection in each wind."""
        words = {
            "peak": "largest deflection of the linear loop",
            "boundary": "least limit with which flights survive",
        }
        q = self.question
        rows = tuple(
            ((name,), degrees(f"least.{name}", angle), number(f"least.{name}.part", angle / trim))
            for name, angle, trim in zip(q.names, self.each, q.trims, strict=True)
        )
        caption = f"Least nozzle: {words[self.meaning]}"
        return Table(caption, ("wind", "[deg]", "of trim"), rows)

    _keys = (
        "attitude_gain=autopilot.attitude_gain rate_gain_s=autopilot.rate_gain"
        " alpha_gain=autopilot.alpha_gain meaning deflection_deg over_trim=relative"
        " disk_margin=margins.disk_margin held_by=active notes"
    )


_SETTLING_TIME_CONSTANTS = 8.0
"""Duration of a response after its wind, in time constants of the fastest pole of the plant."""
_LIMIT_TOLERANCE = 1e-4
"""Difference of limits, relative to trim, that counts as none."""
_LINEAR_SEARCH: dict[str, Any] = {"each": 32, "rounds": 40}
"""Options of the search by peaks of the linear loop."""
_FLOWN_SEARCH: dict[str, Any] = {"each": 24, "rounds": 30, "islands": 1}
"""Options of the search by flights."""
_STOPPED_SEARCH: dict[str, Any] = {"each": 24, "rounds": 14, "islands": 1}
"""Options of the search by flights with sudden ends of the winds."""
_REFINEMENT: dict[str, Any] = {"first": 8, "each": 12, "rounds": 6, "tolerance": _LIMIT_TOLERANCE}
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
_RELATIVE_TOLERANCE = 0.005
"""Relative distance at which a margin, a wind or an edge of the search range counts as active."""
_CHECK_STOPS = 23
"""Number of sudden ends of each wind at which the final gains are checked."""
_MIN_ALPHA_RATIO = 0.45
"""alpha_ratio below which a sudden end of the wind requires more than the wind."""


def least_deflection_gains(
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
) -> LeastGains:
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
        Samples of the autopilot in a second [Hz]: its margins are then those of the sampled loop.
        Without one the margins are of a continuous autopilot, and flights sample it at 100 Hz. The
        largest deflections of the linear loop are those of the continuous one, either way.

    Returns
    -------
    LeastGains
        Gains, deflection, margins, active criteria and notes.

    Raises
    ------
    InputError
        For a plant that is aerodynamically stable, a batch, winds that do not end, neither nozzle
        nor delay nor crossover, stops without limits, gains of which none have the margins, and as
        `Autopilot.wind_response` and `closed_loop_boundary`.

    Notes
    -----
    On a fixed path a0 + b0 and a1 alone decide the margins, and the deflection is affine in b0 for
    a given loop. The search uses none of that: it takes hundreds of points, then others along
    differences of the best, with all margins and peaks of a round in one call. Peaks are minimal to
    about 1e-3 of trim, with three gains in several winds to 2e-3; the result satisfies all
    criteria.

    A single wind is overfitted: give several durations, and judge three gains with stops.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
    >>> wind = tv.TriangularWind(peak=0.05, duration=7.5)
    >>> gains = tv.least_deflection_gains(
    ...     plant, wind, actuator=tv.Actuator(), delay=0.02, crossover=2.0
    ... )
    >>> round(gains.relative, 2), gains.active
    (1.11, ('phase_margin_deg', 'crossover'))
    """
    winds_row: Any = (winds,) if isinstance(winds, History) else winds
    question = Question(
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
    return answered(question)


def answered(question: Question, near: FloatArray | None = None) -> LeastGains:
    """Return the gains for a question; `near`: known gains to start from, ``(n, axes)``."""
    axes = len(question.gains)
    first = _BOX_POINTS * (axes - 1) if near is None else _LOCAL_POINTS
    start: dict[str, Any] = {"first": first, "known": near, "wide": near is None}
    pools = _ISLANDS if axes > len(("stiffness", "rate")) else 1
    linear = partial(_cost, question, partial(_linear_peaks, question))
    points, costs = least_points(linear, axes, islands=pools, **start, **_LINEAR_SEARCH)
    if costs[0] < MISSES and question.limits:
        flown, final = (
            partial(_cost, question, partial(needs, question, clean=n))
            for n in (_SEARCH_SCAN, _FINAL_SCAN)
        )
        options = _STOPPED_SEARCH if question.stops else _FLOWN_SEARCH
        options = options | {"tolerance": _LIMIT_TOLERANCE}
        points, _ = least_points(flown, axes, **start | {"known": points}, **options)
        points, _ = least_points(final, axes, known=points, wide=False, **_REFINEMENT)
    if costs[0] >= MISSES:
        raise InputError(_refusal(question, points[0]))
    if question.limits:
        each = _boundaries(question, question.autopilot(points[0]), question.stops)
        return _record(question, points[0], each)
    exact = [_peaks(question, question.autopilot(point)) for point in points[:_EXACT_ROWS]]
    best = int(np.argmin([peaks.max() for peaks in exact]))
    return _record(question, points[best], exact[best])


def _cost(
    question: Question,
    need: Callable[[FloatArray, float], FloatArray],
    points: FloatArray,
    pool: FloatArray,
) -> FloatArray:
    """Return the cost of rows of gains, ``(n,)``: required deflection relative to the largest trim.

    From `MISSES` on where a criterion is missed. `need`: function for the deflection of rows that
    satisfy all criteria, exact below the largest cost of the pool.
    """
    lacks = question.lacks(points)
    values = MISSES + np.maximum(lacks, 0.0)
    good = np.flatnonzero(lacks <= 0.0)
    if good.size:
        values[good] = np.minimum(need(points[good], float(pool[-1])), 0.9 * MISSES)
    return np.asarray(values)


def _linear_peaks(question: Question, points: FloatArray, goal: float) -> FloatArray:
    """Return the peaks of the linear loop, normalised by the largest trim, ``(n,)``."""
    del goal
    rows = replace(question.autopilot(points), sample_rate=None)
    after = _SETTLING_TIME_CONSTANTS / float(
        np.nanmax(np.real(unstable_modes(question.plant.rigid).poles))
    )
    peaks = [deflection_peaks(rows, question.plant, w, after) for w in question.winds]
    return np.asarray(np.max(peaks, axis=0) / question.trims.max())


def _peaks(question: Question, autopilot: Autopilot) -> FloatArray:
    """Return the exact peaks [rad], ``(winds,)``."""
    response = replace(autopilot, sample_rate=None).wind_response_function(question.plant)
    return np.array([abs(response(wind).peak("deflection")[0]) for wind in question.winds])


def _boundaries(question: Question, autopilot: Autopilot, stops: int) -> FloatArray:
    """Return the boundaries [rad] with `stops` sudden ends of each wind, ``(winds,)``."""
    law = SaturatedLaw.of(autopilot)
    limits = [
        closed_loop_boundary(
            question.plant,
            law,
            wind,
            actuator=question.actuator,
            delay=question.delay,
            sample_rate=question.flown_rate,
            cuts=stops,
        ).deflection
        for wind in question.winds
    ]
    return np.abs(np.array(limits))


def _record(question: Question, point: FloatArray, each: FloatArray) -> LeastGains:
    """Return the record of a row of gains with its deflection in each wind [rad], ``(winds,)``."""
    autopilot = question.autopilot(point)
    margins = loop_margins(autopilot.exact_loop(question.plant))
    worst = int(np.argmax(each))
    unseen = None
    if question.limits:
        unseen = float(_boundaries(question, autopilot, _CHECK_STOPS).max())
    return LeastGains(
        question=question,
        autopilot=autopilot,
        meaning=BOUNDARY if question.limits else PEAK,
        deflection=float(each[worst]),
        relative=float(each[worst] / question.trims[worst]),
        each=each,
        worst_wind=worst,
        margins=margins,
        active=_active(question, margins, each),
        unseen=unseen,
        notes=_notes(question, autopilot, point, each, unseen),
    )


def _active(question: Question, margins: Margins, each: FloatArray) -> tuple[str, ...]:
    """Return the names of active criteria, and of the winds if several require the same."""
    active = [
        r.margin
        for r in question.criteria.requirements
        if r.margin in MARGINS and abs(lacking(r, getattr(margins, r.margin))) < _RELATIVE_TOLERANCE
    ]
    limit = question.crossover
    if limit is not None and highest_crossover(margins) > (1.0 - _RELATIVE_TOLERANCE) * limit:
        active.append(CROSSOVER)
    equal = np.flatnonzero(each > (1.0 - _RELATIVE_TOLERANCE) * each.max())
    if equal.size > 1:
        active += [question.names[k] for k in equal.tolist()]
    return tuple(active)


def _notes(
    question: Question,
    autopilot: Autopilot,
    point: FloatArray,
    each: FloatArray,
    unseen: float | None,
) -> tuple[str, ...]:
    """Return the notes on gains: lean into the wind, path, winds, search range and sudden ends."""
    notes = []
    trim = question.trims.max()
    if len(question.gains) > len(("attitude", "rate")):
        a0, b0 = float(autopilot.attitude_gain), float(autopilot.alpha_gain)
        ratio = a0 / (a0 + b0 - float(question.plant.coefficients.B))
        if ratio < _MIN_ALPHA_RATIO:
            notes.append(
                f"these gains leave {ratio:.2f} of a steady wind as angle of attack: below"
                f" {_MIN_ALPHA_RATIO} the vehicle leans so far into the wind that a sudden end of"
                " it needs more; try with stops"
            )
        if question.plant.rigid.model == "fixed-path":
            notes.append(
                "a fixed path sets no price on the attitude error: judge three gains on drift-exact"
            )
    if len(question.winds) == 1:
        notes.append("the gains are fitted to one wind alone: give shorter and longer ones as well")
    if (
        np.any((point < _RELATIVE_TOLERANCE) | (point > 1.0 - _RELATIVE_TOLERANCE))
        and len(question.gains) == 2
    ):
        notes.append("the gains lie at the edge of the search range")
    if unseen is not None and unseen > (1.0 + _RELATIVE_TOLERANCE) * float(each.max()):
        notes.append(
            f"with {_CHECK_STOPS} sudden ends of each wind, most of them new to the search, the"
            f" boundary is {unseen / trim:.3f} of trim"
        )
    return tuple(notes)


def _refusal(question: Question, point: FloatArray) -> str:
    """Return the sentence that no gains satisfy the criteria, with the nearest gains and bounds."""
    autopilot = question.autopilot(point)
    margins = loop_margins(autopilot.exact_loop(question.plant))
    text = f"no {' and '.join(question.gains)} gains meet the criteria {question.criteria.name}"
    text += (
        f"; the nearest, a0 = {float(autopilot.attitude_gain):.4g} and"
        f" a1 = {float(autopilot.rate_gain):.4g} s,"
    )
    lacks = [
        (float(lacking(r, getattr(margins, r.margin))), r)
        for r in question.criteria.requirements
        if r.margin in MARGINS
    ]
    lack, worst = max(lacks, key=lambda pair: np.nan_to_num(pair[0], nan=np.inf))
    if not margins.stable:
        text += " are unstable"
    elif lack > 0.0:
        label, unit, _ = MARGINS[worst.margin]
        value, limit = (
            unit_factor(unit) * x for x in (getattr(margins, worst.margin), worst.limit)
        )
        text += f" have {label} {value:.4g} where {limit:.4g} {unit}".rstrip() + " is required"
    else:
        text += " miss the required margins of modes or the crossover"
    bounds = margin_bounds(question.plant, actuator=question.actuator, delay=question.delay)
    return "; ".join(filter(None, (text, bounds.sentence)))
