"""Of all gains that have the margins asked for, those that need the least deflection."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from tvclin.answers.least_gains.question import (
    CROSSOVER,
    MISSES,
    Question,
    highest_crossover,
    lacking,
)
from tvclin.answers.least_gains.race import needs
from tvclin.answers.least_gains.record import BOUNDARY, PEAK, LeastGains
from tvclin.answers.search import least_points
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.margin_bounds import margin_bounds
from tvclin.control.autopilot.wind_response import deflection_peaks
from tvclin.control.laws.attitude import SaturatedLaw
from tvclin.control.margins.criteria import CRITERIA, Criteria
from tvclin.control.margins.margins import MARGINS, Margins, loop_margins, unit_factor
from tvclin.flights.closed_loop.survival_limit import closed_loop_boundary
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.modes import unstable_modes
from tvclin.vehicle.filters import Filter
from tvclin.winds.histories import History

_SETTLED = 8.0
"""Loops are followed behind a wind for so long, over the fastest pole of the plant."""
_FINE = 1e-4
"""Of trim: limits that are closer are alike."""
_LINEAR: dict[str, Any] = {"each": 32, "rounds": 40}
_FLOWN: dict[str, Any] = {"each": 24, "rounds": 30, "islands": 1}
_STOPPED: dict[str, Any] = {"each": 24, "rounds": 14, "islands": 1}
_AGAIN: dict[str, Any] = {"first": 8, "each": 12, "rounds": 6, "tolerance": _FINE}
_OVER, _NEAR = 256, 16
"""Points and rounds of the searches: over the box, for each axis beyond the first, or nearby."""
_ISLANDS = 3
"""Pools of a search with three gains; with two, one arrives."""
_CLEAN, _CLEANER = 24, 100
"""Limits above the one found at which a row of gains is flown: in the search, and at its end."""
_BEST = 4
"""So many of the best are asked for their exact peak."""
_TIGHT = 0.005
_UNSEEN = 23
_LEANS = 0.45
"""An alpha_ratio below which a sudden end of the wind asks for more than the wind."""


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
    """Return the gains that need the least deflection of all that have the margins asked for.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        One aerodynamically unstable plant.
    winds : History or sequence of History
        Winds that end; the deflection is the largest over all of them.
    criteria : Criteria
        The margins that are asked for, of the whole loop and of modes.
    gains : sequence of str
        Those that are free: attitude and rate, or attitude, rate and alpha.
    actuator : Actuator, optional
        Of the nozzle.
    delay : float
        Of the loop [s]; in flights it is the computing delay.
    crossover : float, optional
        The highest that a gain crossover may be [rad/s]: it stands for what bends and is not in
        the plant.
    filters, attitude_filters, rate_filters : tuple of Filter
        Behind the sum of the feedbacks, on the attitude and on the rate.
    limits : bool
        Whether the deflection is the least limit with which the winds are survived, flown, in
        place of the largest of the linear loop.
    stops : int
        With limits, so many sudden ends of each wind must be survived as well.
    sample_rate : float, optional
        Samples of the autopilot in a second [Hz]: its margins are then those of the sampled loop.
        Without one the margins are of a continuous autopilot, and flights sample it at 100 Hz. The
        largest deflections of the linear loop are those of the continuous one, either way.

    Returns
    -------
    LeastGains
        With the margins, what holds the gains, and notes.

    Raises
    ------
    InputError
        For a plant that is aerodynamically stable, a batch, winds that do not end, neither nozzle
        nor delay nor crossover, stops without limits, gains of which none have the margins, and as
        `Autopilot.wind_response` and `closed_loop_boundary`.

    Notes
    -----
    On a fixed path a0 + b0 and a1 alone decide the margins, and the deflection is affine in b0 for
    a given loop. The search needs none of that: hundreds of points, then others along differences
    of the best, all margins and peaks of a round in one call. Peaks are found to about 1e-3 of
    trim, three gains in several winds to 2e-3; what is returned meets every criterion.

    One wind is overfitted: give several durations, and judge three gains with stops.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
    >>> wind = tv.TriangularWind(peak=0.05, duration=7.5)
    >>> found = tv.least_deflection_gains(
    ...     plant, wind, actuator=tv.Actuator(), delay=0.02, crossover=2.0
    ... )
    >>> round(found.relative, 2), found.active
    (1.11, ('phase_margin_deg', 'crossover'))
    """
    every: Any = (winds,) if isinstance(winds, History) else winds
    question = Question(
        plant=plant,
        winds=every,
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
    """Return the answer to a question, from gains nearby where they are known, ``(n, axes)``."""
    axes = len(question.gains)
    first = _OVER * (axes - 1) if near is None else _NEAR
    begin: dict[str, Any] = {"first": first, "known": near, "wide": near is None}
    pools = _ISLANDS if axes > len(("stiffness", "rate")) else 1
    linear = partial(_worth, question, partial(_peaked, question))
    points, found = least_points(linear, axes, islands=pools, **begin, **_LINEAR)
    if found[0] < MISSES and question.limits:
        flown, cleaner = (
            partial(_worth, question, partial(needs, question, clean=n)) for n in (_CLEAN, _CLEANER)
        )
        steps = (_STOPPED if question.stops else _FLOWN) | {"tolerance": _FINE}
        points, _ = least_points(flown, axes, **begin | {"known": points}, **steps)
        points, _ = least_points(cleaner, axes, known=points, wide=False, **_AGAIN)
    if found[0] >= MISSES:
        raise InputError(_none(question, points[0]))
    if question.limits:
        each = _boundaries(question, question.autopilot(points[0]), question.stops)
        return _record(question, points[0], each)
    exact = [_peaks(question, question.autopilot(point)) for point in points[:_BEST]]
    best = int(np.argmin([each.max() for each in exact]))
    return _record(question, points[best], exact[best])


def _worth(
    question: Question,
    need: Callable[[FloatArray, float], FloatArray],
    points: FloatArray,
    pool: FloatArray,
) -> FloatArray:
    """What each row needs over the largest trim; beyond `MISSES` where a criterion is missed.

    `need`: of rows that miss none, closely where it enters the pool.
    """
    lacks = question.lacks(points)
    values = MISSES + np.maximum(lacks, 0.0)
    good = np.flatnonzero(lacks <= 0.0)
    if good.size:
        values[good] = np.minimum(need(points[good], float(pool[-1])), 0.9 * MISSES)
    return np.asarray(values)


def _peaked(question: Question, points: FloatArray, goal: float) -> FloatArray:
    """The peak of each row of the linear loop, over the largest trim."""
    del goal
    rows = replace(question.autopilot(points), sample_rate=None)
    after = _SETTLED / float(np.nanmax(np.real(unstable_modes(question.plant.rigid).poles)))
    peaks = [deflection_peaks(rows, question.plant, w, after) for w in question.winds]
    return np.asarray(np.max(peaks, axis=0) / question.trims.max())


def _peaks(question: Question, autopilot: Autopilot) -> FloatArray:
    """The exact peak in each wind [rad]."""
    answer = replace(autopilot, sample_rate=None).wind_response_function(question.plant)
    return np.array([abs(answer(wind).peak("deflection")[0]) for wind in question.winds])


def _boundaries(question: Question, autopilot: Autopilot, stops: int) -> FloatArray:
    """The boundary in each wind [rad], with so many sudden stops of it."""
    law = SaturatedLaw.of(autopilot)
    found = [
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
    return np.abs(np.array(found))


def _record(question: Question, point: FloatArray, each: FloatArray) -> LeastGains:
    autopilot = question.autopilot(point)
    margins = loop_margins(autopilot.exact_loop(question.plant))
    worst = int(np.argmax(each))
    unseen = None
    if question.limits:
        unseen = float(_boundaries(question, autopilot, _UNSEEN).max())
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
    """The criteria that are met with nothing to spare, and winds that ask the same."""
    held = [
        one.margin
        for one in question.criteria.requirements
        if one.margin in MARGINS and abs(lacking(one, getattr(margins, one.margin))) < _TIGHT
    ]
    most = question.crossover
    if most is not None and highest_crossover(margins) > (1.0 - _TIGHT) * most:
        held.append(CROSSOVER)
    same = np.flatnonzero(each > (1.0 - _TIGHT) * each.max())
    if same.size > 1:
        held += [question.names[k] for k in same.tolist()]
    return tuple(held)


def _notes(
    question: Question,
    autopilot: Autopilot,
    point: FloatArray,
    each: FloatArray,
    unseen: float | None,
) -> tuple[str, ...]:
    notes = []
    trim = question.trims.max()
    if len(question.gains) > len(("attitude", "rate")):
        a0, b0 = float(autopilot.attitude_gain), float(autopilot.alpha_gain)
        ratio = a0 / (a0 + b0 - float(question.plant.coefficients.B))
        if ratio < _LEANS:
            notes.append(
                f"these gains leave {ratio:.2f} of a steady wind as angle of attack: below {_LEANS}"
                " the vehicle leans so far into the wind that a sudden end of it needs more; try"
                " with stops"
            )
        if question.plant.rigid.model == "fixed-path":
            notes.append(
                "a fixed path sets no price on the attitude error: judge three gains on drift-exact"
            )
    if len(question.winds) == 1:
        notes.append("the gains are fitted to one wind alone: give shorter and longer ones as well")
    if np.any((point < _TIGHT) | (point > 1.0 - _TIGHT)) and len(question.gains) == 2:
        notes.append("the gains lie at the edge of the search range")
    if unseen is not None and unseen > (1.0 + _TIGHT) * float(each.max()):
        notes.append(
            f"with {_UNSEEN} sudden ends of each wind, most of them new to the search, the boundary"
            f" is {unseen / trim:.3f} of trim"
        )
    return tuple(notes)


def _none(question: Question, point: FloatArray) -> str:
    """The sentence that no gains meet the criteria: what is nearest, and what bounds it."""
    autopilot = question.autopilot(point)
    margins = loop_margins(autopilot.exact_loop(question.plant))
    said = f"no {' and '.join(question.gains)} gains meet the criteria {question.criteria.name}"
    said += (
        f"; the nearest, a0 = {float(autopilot.attitude_gain):.4g} and"
        f" a1 = {float(autopilot.rate_gain):.4g} s,"
    )
    short = [
        (float(lacking(one, getattr(margins, one.margin))), one)
        for one in question.criteria.requirements
        if one.margin in MARGINS
    ]
    lack, one = max(short, key=lambda pair: np.nan_to_num(pair[0], nan=np.inf))
    if not margins.stable:
        said += " are unstable"
    elif lack > 0.0:
        label, unit, _ = MARGINS[one.margin]
        value, limit = (unit_factor(unit) * x for x in (getattr(margins, one.margin), one.limit))
        said += f" have {label} {value:.4g} where {limit:.4g} {unit}".rstrip() + " is required"
    else:
        said += " miss the required margins of modes or the crossover"
    bounds = margin_bounds(question.plant, actuator=question.actuator, delay=question.delay)
    return "; ".join(part for part in (said, bounds.sentence) if part)
